//! How far new triangles stray from the exact face.

use fabkit_geometry::{Body, Crossing, Point3, Ray, Scratch, Vector3};

use super::bend::Bend;
use super::trim::Curve;

/// A stray bound from the curvatures at one point of a patch must stay below this share of the
/// tolerance to do without measuring: they change from point to point.
const TRUSTED_SHARE: f64 = 0.7;

/// Where a triangle is compared with the face: in its middle and halfway along its edges.
const SAMPLES: [[f64; 3]; 4] =
    [[1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0], [0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]];

pub(super) struct Measure<'a> {
    body: &'a Body,
    axis: Vector3<f64>,
    face: [u32; 2],
    tolerance_mm: f64,
    scratch: Scratch,
    hits: Vec<Crossing>,
}

impl<'a> Measure<'a> {
    pub fn new(body: &'a Body, axis: Vector3<f64>, curve: &Curve, tolerance_mm: f64) -> Self {
        let (scratch, hits) = (Scratch::default(), Vec::new());
        Self { body, axis, face: curve.face, tolerance_mm, scratch, hits }
    }

    /// Whether the triangle keeps to the face.
    pub fn holds(&mut self, corners: [[f64; 3]; 3], bend: &Bend) -> bool {
        bend.most_stray_mm(corners) < TRUSTED_SHARE * self.tolerance_mm
            || SAMPLES.iter().all(|weights| {
                let [a, b, c] = [0, 1, 2].map(|i| weights[i] * Vector3::from(corners[i]));
                self.stray_mm(Point3::from(a + b + c)) <= self.tolerance_mm
            })
    }

    /// Distance from the face, by the plane that touches it where a line along the axis meets it.
    fn stray_mm(&mut self, origin: Point3<f64>) -> f64 {
        let ray = Ray { origin, direction: self.axis };
        self.body.crossings_into(&ray, &mut self.scratch, &mut self.hits);
        let of_face = self.hits.iter().filter(|hit| [hit.leaf, hit.face] == self.face);
        let strays = of_face.map(|hit| (hit.t * hit.normal.dot(&self.axis)).abs());
        strays.fold(f64::MAX, f64::min)
    }
}
