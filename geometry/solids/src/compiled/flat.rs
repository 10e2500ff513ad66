//! Cuboid and half-space: primitives bounded by planes only.

use nalgebra::Vector3;

use super::shape::{CastBuffers, Chord, LocalRay, Shape, Wall};
use crate::{Cuboid, HalfSpace};

impl Cuboid {
    fn limits(&self) -> [[f64; 2]; 3] {
        let [x, y, z] = self.size_mm;
        [[-0.5 * x, 0.5 * x], [-0.5 * y, 0.5 * y], [0.0, z]]
    }
}

impl Shape for Cuboid {
    fn support(&self, u: &Vector3<f64>) -> f64 {
        (0..3).map(|i| self.limits()[i].map(|v| v * u[i])).map(|[a, b]| a.max(b)).sum()
    }

    fn contains(&self, p: &Vector3<f64>) -> bool {
        self.limits().iter().zip(p.iter()).all(|([low, high], v)| low < v && v < high)
    }

    fn normal(&self, face: u32, _p: &Vector3<f64>) -> Vector3<f64> {
        let mut normal = Vector3::zeros();
        normal[(face as usize / 2).min(2)] = if face.is_multiple_of(2) { -1.0 } else { 1.0 };
        normal
    }

    fn cast(&self, ray: &LocalRay, work: &mut CastBuffers) {
        let limits = self.limits();
        let slab = |i: usize| {
            let face = 2 * i as u32;
            let (low, high) =
                (Wall { at: limits[i][0], face }, Wall { at: limits[i][1], face: face + 1 });
            Chord::slab(ray.origin[i], ray.direction[i], low, high)
        };
        work.chords.extend(slab(0).and_then(|x| x.meet(slab(1)?)?.meet(slab(2)?)));
    }
}

impl Shape for HalfSpace {
    fn support(&self, u: &Vector3<f64>) -> f64 {
        if u.x == 0.0 && u.y == 0.0 && u.z > 0.0 { 0.0 } else { f64::INFINITY }
    }

    fn contains(&self, p: &Vector3<f64>) -> bool {
        p.z < 0.0
    }

    fn normal(&self, _face: u32, _p: &Vector3<f64>) -> Vector3<f64> {
        Vector3::z()
    }

    fn cast(&self, ray: &LocalRay, work: &mut CastBuffers) {
        let below = Wall { at: f64::NEG_INFINITY, face: 0 };
        work.chords.extend(Chord::slab(
            ray.origin.z,
            ray.direction.z,
            below,
            Wall { at: 0.0, face: 0 },
        ));
    }
}
