//! Table of the error of linear theory against large strain, by depth, for several bodies.
//!
//! ```sh
//! cargo run --release -p fabkit-elastic --example levels -- [SPACING_MM]
//! ```
//!
//! A ball of 4 mm is pressed onto the pole; the second body also under a pin with a round end of 0.8 mm. Each row lists
//! the depth, the force by both theories, the error of the linear one, and the bulge by both as a part of the depth;
//! then the depth at which the linear force is off by 10 %.

use std::error::Error;
use std::f64::consts::FRAC_PI_2;

use fabkit_elastic::{
    BallIndenter, BoundaryCondition, ElasticLayer, ElasticMaterial, ElasticStack, FiniteStack,
    LayeredBody, MeridianCurve, MeshDensity, Press,
};
use fabkit_geometry::{Point3, Vector3};

const BALL_MM: f64 = 4.0;
/// Relative error of force that counts as off.
const OFF: f64 = 0.1;

fn main() -> Result<(), Box<dyn Error>> {
    let spacing_mm = std::env::args().nth(1).map_or(Ok(0.1), |text| text.parse())?;
    let layer = |young_mpa: f64| -> Result<ElasticLayer, Box<dyn Error>> {
        let material = ElasticMaterial::new(young_mpa, 0.495)?;
        Ok(ElasticLayer { name: format!("{young_mpa} MPa"), material })
    };
    let two = || -> Result<LayeredBody, Box<dyn Error>> {
        Ok(LayeredBody::pad(12.0, vec![(layer(0.07)?, 1.5), (layer(1.7)?, 1.5)]))
    };
    let bodies = [
        ("a pad, 3 mm of one gel", LayeredBody::pad(12.0, vec![(layer(0.1)?, 3.0)]), BALL_MM, 1.5),
        ("a pad, 1.5 mm soft on 1.5 mm stiff", two()?, BALL_MM, 1.1),
        ("the same under a pin", two()?, 0.8, 0.7),
        (
            "a round layer, 3 mm on a ball of 11 mm",
            dome(&[14.0, 11.0], vec![layer(0.1)?]),
            BALL_MM,
            1.5,
        ),
        (
            "the same ball under 1.5 mm soft on 1.5 mm stiff",
            dome(&[14.0, 12.5, 11.0], vec![layer(0.07)?, layer(1.7)?]),
            BALL_MM,
            1.1,
        ),
        ("half a ball of gel, 14 mm, on its flat face", half_ball(14.0, layer(0.1)?), BALL_MM, 2.5),
    ];
    for (name, body, radius_mm, deepest_mm) in bodies {
        println!("{name}");
        let division =
            MeshDensity::around_pole(spacing_mm * radius_mm / BALL_MM, 1.25 * radius_mm, 0);
        let linear = ElasticStack::new(&body, &division, 1)?;
        let finite = FiniteStack::new(&body, &division)?;
        let ball = BallIndenter::new(Point3::new(0.0, 0.0, 40.0), radius_mm)?;
        let steps = 10;
        let depths: Vec<f64> =
            (1..=steps).map(|i| deepest_mm * f64::from(i) / f64::from(steps)).collect();
        let (mut before, mut is_off) = ((0.0, 0.0), false);
        for (outcome, depth_mm) in finite.press(&ball, &depths)?.iter().zip(&depths) {
            let small = linear.press(&ball, &Press::along(-Vector3::z(), *depth_mm)?)?;
            let off = small.force_n.z / outcome.force_n.z - 1.0;
            println!(
                "  {depth_mm:.2} mm: {:.4} N linear, {:.4} N finite, {:+.1} %; bulge {:.1} %, {:.1} %",
                -small.force_n.z,
                -outcome.force_n.z,
                100.0 * off,
                100.0 * small.bulge_mm / depth_mm,
                100.0 * outcome.bulge_mm / depth_mm
            );
            if off.abs() > OFF && !is_off {
                is_off = true;
                let part = (OFF - before.1) / (off.abs() - before.1);
                println!(
                    "  linear force 10 % off at {:.2} mm",
                    before.0 + part * (depth_mm - before.0)
                );
            }
            before = (*depth_mm, off.abs());
        }
    }
    Ok(())
}

/// Builds spherical layers, bonded to a rigid ball inside and at their rim.
fn dome(radii_mm: &[f64], layers: Vec<ElasticLayer>) -> LayeredBody {
    let arc = |radius_mm: f64| {
        MeridianCurve::new(move |s| {
            let (sin, cos) = (s * FRAC_PI_2).sin_cos();
            [radius_mm * sin, radius_mm * cos]
        })
    };
    LayeredBody {
        interfaces: radii_mm.iter().map(|&radius_mm| arc(radius_mm)).collect(),
        layers,
        inner: BoundaryCondition::Bonded,
        is_rim_bonded: true,
        kinks: Vec::new(),
    }
}

/// Builds a half ball, bonded to the rigid disc that it stands on.
fn half_ball(radius_mm: f64, layer: ElasticLayer) -> LayeredBody {
    let arc = move |s: f64| {
        let (sin, cos) = (s * FRAC_PI_2).sin_cos();
        [radius_mm * sin, radius_mm * cos]
    };
    LayeredBody {
        interfaces: vec![MeridianCurve::new(arc), MeridianCurve::new(move |s| [arc(s)[0], 0.0])],
        layers: vec![layer],
        inner: BoundaryCondition::Bonded,
        is_rim_bonded: true,
        kinks: Vec::new(),
    }
}
