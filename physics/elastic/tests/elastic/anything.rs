//! Indenters of many shapes at many poses: each press yields a balanced result or an error.

use crate::support::{round_layer, stack};
use fabkit_elastic::{ContactState, ElasticError, MeshDensity, Press, SolidIndenter};
use fabkit_geometry::{Angle, CompiledSolid, Point3, Pose, Solid, Vector3};

const PRESSES: usize = 150;

/// Deterministic pseudo-random numbers (Marsaglia, "Xorshift RNGs", J. Stat. Softw. 8, 2003).
struct Chance(u64);

impl Chance {
    fn up_to(&mut self, most: f64) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        most * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn some_solid(chance: &mut Chance) -> Solid {
    let size_mm = 0.5 + chance.up_to(5.0);
    match chance.up_to(4.0) as u32 {
        0 => Solid::sphere(size_mm),
        1 => Solid::cylinder(size_mm, 10.0),
        2 => {
            let angle = Angle::from_deg(chance.up_to(45.0)).expect("an angle");
            Solid::cuboid(size_mm, size_mm, 10.0).turned_x(angle)
        }
        _ => Solid::cone(0.2, size_mm, 8.0),
    }
}

#[test]
fn presses_of_anything_balance_or_are_refused() {
    let stack = stack(&round_layer(0.495), MeshDensity::uniform(0.35, 40));
    let mut chance = Chance(88_172_645_463_325_252);
    let (mut answers, mut sheared, mut lost) = (0, 0, 0);
    for number in 0..PRESSES {
        let (tilt, azimuth) = (chance.up_to(1.0), chance.up_to(std::f64::consts::TAU));
        let outward =
            Vector3::new(tilt.sin() * azimuth.cos(), tilt.sin() * azimuth.sin(), tilt.cos());
        let solid = CompiledSolid::new(&some_solid(&mut chance)).unwrap();
        let indenter =
            SolidIndenter::new(&solid, &Pose::z_to(outward, Point3::from(30.0 * outward)));
        let mut press = Press::along(-outward, 0.05 + chance.up_to(1.4)).unwrap();
        let is_sheared = chance.up_to(1.0) < 0.4;
        let friction = chance.up_to(1.5);
        if is_sheared {
            let way_mm = Vector3::from_fn(|_, _| chance.up_to(0.8) - 0.4);
            press = press.with_shear(friction, way_mm, 2).unwrap();
            sheared += 1;
        }
        match stack.press(&indenter, &press) {
            Ok(outcome) => {
                answers += 1;
                // The force is compared with the nodal tractions: normals of neighbouring nodes differ by about (h /
                // R)^2 for a distance h on a radius R.
                let sum: Vector3<f64> = outcome
                    .nodes
                    .iter()
                    .map(|n| n.area_mm2 * (n.shear_mpa - n.pressure_mpa * n.outward))
                    .sum();
                let force_n = outcome.force_n.norm();
                assert!(
                    (sum - outcome.force_n).norm() < 0.01 * force_n,
                    "{number}: {sum} {force_n}"
                );
                for node in outcome.nodes.iter().filter(|node| node.touch != ContactState::Free) {
                    assert!(node.pressure_mpa > 0.0, "{number}");
                    let limit_mpa = friction * node.pressure_mpa * (1.0 + 1e-9);
                    assert!(node.shear_mpa.norm() <= limit_mpa, "{number}");
                }
            }
            Err(
                ElasticError::NoContact { .. }
                | ElasticError::TooDeep { .. }
                | ElasticError::TooCoarse { .. },
            ) => {}
            Err(error @ ElasticError::NoConvergence { .. }) => {
                assert!(is_sheared, "{number}: {error}");
                lost += 1;
            }
            Err(error) => panic!("{number}: {error}"),
        }
    }
    println!("{answers} answers of {PRESSES}; {lost} of {sheared} sheared ones did not converge");
    assert!(answers > PRESSES * 3 / 4);
    // Only sharp edges that are dragged far may fail to converge.
    assert!(lost * 20 <= sheared, "{lost} of {sheared}");
}
