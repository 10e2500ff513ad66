//! Parallel lines through a box, and the stretches of them that lie inside bodies.

use fabkit_geometry::proofs::Shadow;
use fabkit_geometry::sequences::EvenPoints;
use fabkit_geometry::{Aabb, CompiledSolid, Crossing, Point3, Ray, Scratch, Vector3};

/// Askew to everything that parts are made of, so that no face of an ordinary part is grazed, and
/// far enough apart that each face is met steeply by one of them.
pub(crate) const DIRECTIONS: [[f64; 3]; 3] =
    [[0.1234, 0.0917, 1.0], [1.0, 0.1234, 0.0917], [0.0917, 1.0, 0.1234]];

/// Where lines pass the shadow of what they look at, whose sides are from 0 to 1.
const PLACES: EvenPoints<2> = EvenPoints::square([0.5; 2]);

/// Lines of one direction spread evenly over the shadow of a box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bundle {
    direction: Vector3<f64>,
    across: [Vector3<f64>; 2],
    centre: Point3<f64>,
    half_mm: [f64; 2],
    count: usize,
}

impl Bundle {
    pub(crate) fn through(bounds: &Aabb, direction: Vector3<f64>, count: usize) -> Self {
        let direction = direction.normalize();
        let [u, v] = basis(&direction);
        let half = 0.5 * (bounds.max - bounds.min);
        let shadow_mm = |w: &Vector3<f64>| w.abs().dot(&half);
        Self {
            direction,
            across: [u, v],
            centre: bounds.centre(),
            half_mm: [shadow_mm(&u), shadow_mm(&v)],
            count,
        }
    }

    /// The area that one line stands for, mm2.
    pub(crate) fn cell_mm2(&self) -> f64 {
        4.0 * self.half_mm[0] * self.half_mm[1] / self.count as f64
    }

    /// The lines that may pass any of some boxes, by their numbers.
    pub(crate) fn through_boxes(&self, boxes: &[Aabb]) -> impl Iterator<Item = usize> + use<> {
        let shadow = Shadow::of(boxes, &self.centre, &self.across, self.half_mm);
        (0..self.count).filter(move |&index| shadow.holds(PLACES.at(index + 1)))
    }

    pub(crate) fn line(&self, index: usize) -> Ray {
        let place = PLACES.at(index + 1);
        let offset =
            |axis: usize| (2.0 * place[axis] - 1.0) * self.half_mm[axis] * self.across[axis];
        Ray { origin: self.centre + offset(0) + offset(1), direction: self.direction }
    }
}

/// Two unit vectors across a unit direction; they and it are right-handed.
pub(crate) fn basis(direction: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let least = direction.iamin();
    let u = Vector3::ith(least, 1.0).cross(direction).normalize();
    [u, direction.cross(&u)]
}

/// Buffers for casting lines; one per thread.
#[derive(Debug, Default)]
pub(crate) struct Caster {
    scratch: Scratch,
    crossings: Vec<Crossing>,
    ends: Vec<[f64; 2]>,
}

/// One stretch of a line inside a body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch {
    pub(crate) enter: Crossing,
    pub(crate) exit: Crossing,
}

impl Stretch {
    pub(crate) fn length_mm(&self) -> f64 {
        self.exit.t - self.enter.t
    }
}

impl Caster {
    /// The stretches of a line (of unit direction) inside a body, in order.
    pub(crate) fn stretches(
        &mut self,
        body: &CompiledSolid,
        ray: &Ray,
    ) -> impl Iterator<Item = Stretch> {
        body.crossings_into(ray, &mut self.scratch, &mut self.crossings);
        self.crossings.chunks_exact(2).map(|ends| Stretch { enter: ends[0], exit: ends[1] })
    }
}

impl Caster {
    /// The same without what lies at their ends: from where to where, mm.
    pub(crate) fn ends(&mut self, body: &CompiledSolid, ray: &Ray) -> &[[f64; 2]] {
        body.stretches_into(ray, &mut self.scratch, &mut self.ends);
        &self.ends
    }
}

impl Caster {
    /// Where a line (of unit direction) enters a body first beyond its origin.
    pub(crate) fn first_entry(&mut self, body: &CompiledSolid, ray: &Ray) -> Option<Crossing> {
        body.first_crossing(ray, 0.0, true, &mut self.scratch)
    }
}

/// Sine of the angle between a line and the face that it crosses; how much of a length along the
/// line counts across the face.
pub(crate) fn steepness(ray: &Ray, crossing: &Crossing) -> f64 {
    ray.direction.dot(&crossing.normal).abs()
}
