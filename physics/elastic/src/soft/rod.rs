//! Pins embedded in gel.

use std::f64::consts::PI;

use fabkit_geometry::Vector3;

use crate::ElasticMaterial;

/// Rotation between two unit normals, before and after, by the shortest path.
pub(super) struct Turn {
    pub(super) before: Vector3<f64>,
    pub(super) after: Vector3<f64>,
}

impl Turn {
    /// Rotates a vector (Rodrigues' formula).
    pub(super) fn rotate(&self, way: Vector3<f64>) -> Vector3<f64> {
        let (across, cos) = (self.before.cross(&self.after), self.before.dot(&self.after));
        way * cos + across.cross(&way) + across * (across.dot(&way) / (1.0 + cos))
    }
}

/// A pin as a beam on an elastic foundation (Winkler's), which pulls it towards where the gel would be without the pin.
/// A stiff pin acts as a lever; a thin, soft one moves with the gel.
///
/// Per unit of length and displacement, gel holds a rod with about 4 pi G across and half of that along. These are the
/// values of slender rods in an incompressible medium, with 1 for the logarithm of the slenderness. The gel's
/// displacement is assumed uniform along the pin, and the pin not to affect what it stands on.
/// `tests/oracles/check_pins.py` quantifies the error.
pub(super) struct Rod {
    length_mm: f64,
    /// Fraction of a lever displacement, and of a rotation, that remains at the end: 1 for a stiff pin.
    left_of_lever: f64,
    left_of_turn: f64,
    /// Fraction of the root's axial displacement that remains at the end.
    left_along: f64,
}

impl Rod {
    /// Solves the beam and rod equations for a pin of a radius and length in gel.
    pub(super) fn new(
        pin: &ElasticMaterial,
        gel: &ElasticMaterial,
        radius_mm: f64,
        length_mm: f64,
    ) -> Self {
        let hold_mpa = 4.0 * PI * gel.shear_modulus_mpa();
        let stretching_n = pin.young_mpa() * PI * radius_mm.powi(2);
        let bending_nmm2 = stretching_n * radius_mm.powi(2) / 4.0;
        // Beam equation h'''' + 4 h = 0 with h = 0 and h' = 1 at the root, h'' = h''' = 0 at the end.
        let x = length_mm * (hold_mpa / (4.0 * bending_nmm2)).powf(0.25);
        let (sin, cos, sinh, cosh) = (x.sin(), x.cos(), x.sinh(), x.cosh());
        let sum = cos * cos + cosh * cosh;
        // Rod equation h'' = h along the pin, with a free end.
        let along = length_mm * (hold_mpa / (2.0 * stretching_n)).sqrt();
        let is_pin = x > 0.0;
        Self {
            length_mm,
            left_of_lever: if is_pin { (sin * cosh + cos * sinh) / (sum * x) } else { 1.0 },
            left_of_turn: 2.0 * cos * cosh / sum,
            left_along: if is_pin { along.tanh() / along } else { 1.0 },
        }
    }

    /// Computes the displacement of the pin's end, mm, and its direction, from the vector from root to end, the root's
    /// displacement and rotation, and the displacement that the gel at the end would have without the pin.
    pub(super) fn displace_end(
        &self,
        lever_mm: Vector3<f64>,
        root_moved_mm: Vector3<f64>,
        gel_moved_mm: Vector3<f64>,
        turn: &Turn,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let Some(axis) = lever_mm.try_normalize(1e-9) else {
            return (root_moved_mm, turn.rotate(lever_mm));
        };
        // Displacement of the root relative to the gel: along the pin, and across it together with its rotation.
        let apart_mm = root_moved_mm - gel_moved_mm;
        let along_mm = axis * apart_mm.dot(&axis);
        let across_mm = apart_mm - along_mm;
        let turned_mm = turn.rotate(lever_mm) - lever_mm + across_mm;
        let displacement_mm =
            gel_moved_mm + self.left_along * along_mm + self.left_of_lever * turned_mm;
        let slope = (self.left_of_turn * turned_mm - across_mm) / self.length_mm;
        (displacement_mm, (axis + slope).normalize())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rod(pin_mpa: f64, gel_mpa: f64) -> Rod {
        let material = |young| ElasticMaterial::new(young, 0.495).unwrap();
        Rod::new(&material(pin_mpa), &material(gel_mpa), 0.5, 2.0)
    }

    /// Displaces a pin whose root sinks by 0.2 mm and turns by 0.1 about y, in gel that moves differently.
    fn moved(rod: &Rod) -> (Vector3<f64>, Vector3<f64>) {
        let turn =
            Turn { before: Vector3::z(), after: Vector3::new(0.1f64.sin(), 0.0, 0.1f64.cos()) };
        let (root, gel) = (Vector3::new(0.0, 0.0, -0.2), Vector3::new(0.05, 0.02, -0.1));
        rod.displace_end(Vector3::new(0.0, 0.0, -2.0), root, gel, &turn)
    }

    #[test]
    fn a_stiff_pin_is_a_lever() {
        let (displacement_mm, axis) = moved(&rod(1e6, 1e-3));
        let lever_mm = Vector3::new(-2.0 * 0.1f64.sin(), 0.0, -0.2 + 2.0 * (1.0 - 0.1f64.cos()));
        assert!((displacement_mm - lever_mm).norm() < 1e-3, "{displacement_mm}");
        assert!((axis + Vector3::new(0.1f64.sin(), 0.0, 0.1f64.cos())).norm() < 1e-3, "{axis}");
    }

    #[test]
    fn a_pin_of_nothing_goes_with_the_gel() {
        let (displacement_mm, _) = moved(&rod(1e-6, 1.0));
        assert!((displacement_mm - Vector3::new(0.05, 0.02, -0.1)).norm() < 1e-2);
    }

    #[test]
    fn a_pin_without_length_is_its_root() {
        let turn = Turn { before: Vector3::z(), after: Vector3::z() };
        let rod = Rod::new(
            &ElasticMaterial::new(1.0, 0.4).unwrap(),
            &ElasticMaterial::new(0.1, 0.4).unwrap(),
            0.5,
            0.0,
        );
        let root = Vector3::new(0.1, 0.0, -0.2);
        assert_eq!(rod.displace_end(Vector3::zeros(), root, root, &turn).0, root);
    }
}
