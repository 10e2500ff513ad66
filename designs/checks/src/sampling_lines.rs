//! Parallel lines through a box, and the stretches of them that lie inside bodies.

use fabkit_geometry::proofs::ProjectionRaster;
use fabkit_geometry::sequences::EvenPoints;
use fabkit_geometry::{Aabb, CompiledSolid, Crossing, Point3, Ray, Scratch, Vector3};

/// Directions of sampling lines. They are oblique to everything that parts are made of, so that lines graze no face of
/// an ordinary part, and nearly orthogonal, so that one of them meets each face steeply.
pub(crate) const DIRECTIONS: [[f64; 3]; 3] =
    [[0.1234, 0.0917, 1.0], [1.0, 0.1234, 0.0917], [0.0917, 1.0, 0.1234]];

/// Positions of lines in the projection of the sampled box, whose sides are scaled to 0..1.
const PLACES: EvenPoints<2> = EvenPoints::square([0.5; 2]);

/// Parallel lines spread evenly over the projection of a box.
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

    /// Area of one line's share of the projection, mm2.
    pub(crate) fn cell_mm2(&self) -> f64 {
        4.0 * self.half_mm[0] * self.half_mm[1] / self.count as f64
    }

    /// Iterates over the indices of the lines that may pass any of some boxes.
    pub(crate) fn through_boxes(&self, boxes: &[Aabb]) -> impl Iterator<Item = usize> + use<> {
        let shadow = ProjectionRaster::from_boxes(boxes, &self.centre, &self.across, self.half_mm);
        (0..self.count).filter(move |&index| shadow.may_meet_box(PLACES.at(index + 1)))
    }

    pub(crate) fn line(&self, index: usize) -> Ray {
        let place = PLACES.at(index + 1);
        let offset =
            |axis: usize| (2.0 * place[axis] - 1.0) * self.half_mm[axis] * self.across[axis];
        Ray { origin: self.centre + offset(0) + offset(1), direction: self.direction }
    }
}

/// Returns two unit vectors that form a right-handed basis with a unit direction, which comes last.
pub(crate) fn basis(direction: &Vector3<f64>) -> [Vector3<f64>; 2] {
    // The axis with the smallest component is farthest from parallel to the direction.
    let least = direction.iamin();
    let u = Vector3::ith(least, 1.0).cross(direction).normalize();
    [u, direction.cross(&u)]
}

/// Buffers for intersecting lines with bodies; one per thread.
#[derive(Debug, Default)]
pub(crate) struct Caster {
    scratch: Scratch,
    crossings: Vec<Crossing>,
    ends: Vec<[f64; 2]>,
}

/// Stretch of a line inside a body.
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
    /// Iterates over the stretches of a line (of unit direction) inside a body, in order.
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
    /// Returns the stretches as intervals [enter, exit], mm, without normals, which is faster.
    pub(crate) fn intervals(&mut self, body: &CompiledSolid, ray: &Ray) -> &[[f64; 2]] {
        body.stretches_into(ray, &mut self.scratch, &mut self.ends);
        &self.ends
    }
}

impl Caster {
    /// Returns the first entry of a line (of unit direction) into a body beyond the line's origin.
    pub(crate) fn first_entry(&mut self, body: &CompiledSolid, ray: &Ray) -> Option<Crossing> {
        body.first_crossing(ray, 0.0, true, &mut self.scratch)
    }
}

/// Returns the sine of the angle between a line and the face that it crosses. It converts a length along the line to a
/// length across the face.
pub(crate) fn steepness(ray: &Ray, crossing: &Crossing) -> f64 {
    ray.direction.dot(&crossing.normal).abs()
}
