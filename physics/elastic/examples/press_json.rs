//! Presses a layered pad or dome described in JSON on standard input, and prints the result as JSON.
//!
//! ```sh
//! echo '{"radius_mm": 12, "layers": [{"young_mpa": 0.07, "poisson": 0.495, "thickness_mm": 1.5}],
//!        "indenter": {"ball_mm": 4}, "depth_mm": 0.5, "spacing_mm": 0.1}' |
//!     cargo run --release -p fabkit-elastic --example press_json
//! ```
//!
//! `indenter` is `{"ball_mm": R}` or `{"pin_mm": R}`, a rod with a round end. Optional: `max_harmonic` (0:
//! axisymmetric), `at_mm` ([x, y] of the indenter), `reach_mm` (radius of the fine part of the mesh), `cap_mm` (the
//! height of a spherical cap above its rigid base, in place of a flat pad), `friction` and `shear_mm` ([x, y]), `level`
//! ("linear", or "finite" for large strain, which presses at the pole only), `probes_mm` ([[x, y], ...], points at
//! which the touched surface's displacement is printed).

use std::error::Error;
use std::io::Read;
use std::time::Instant;

use fabkit_elastic::{
    BoundaryCondition, ElasticLayer, ElasticMaterial, ElasticStack, FiniteStack, LayeredBody,
    MeridianCurve, MeshDensity, Press, PressOutcome, SolidIndenter,
};
use fabkit_geometry::{CompiledSolid, Pose, Solid, Vector3};
use serde_json::{Value, json};

fn main() -> Result<(), Box<dyn Error>> {
    let mut text = String::new();
    std::io::stdin().read_to_string(&mut text)?;
    let asked: Value = serde_json::from_str(&text)?;
    let number = |key: &str| asked[key].as_f64().ok_or_else(|| format!("{key} is missing"));

    let mut layers = Vec::new();
    for layer in asked["layers"].as_array().ok_or("layers are missing")? {
        let number = |key: &str| layer[key].as_f64().ok_or_else(|| format!("a layer lacks {key}"));
        let material = ElasticMaterial::new(number("young_mpa")?, number("poisson")?)?;
        let name = format!("layer {}", layers.len() + 1);
        layers.push((ElasticLayer { name, material }, number("thickness_mm")?));
    }
    let body = match asked["cap_mm"].as_f64() {
        Some(height_mm) => cap(number("radius_mm")?, height_mm, layers),
        None => LayeredBody::pad(number("radius_mm")?, layers),
    };
    let max_harmonic = asked["max_harmonic"].as_u64().unwrap_or(0) as usize;
    let division = MeshDensity {
        reach_mm: asked["reach_mm"].as_f64().unwrap_or(f64::INFINITY),
        growth: 1.15,
        ..MeshDensity::uniform(number("spacing_mm")?, max_harmonic)
    };
    let start = Instant::now();
    let stack = ElasticStack::new(&body, &division, 1)?;
    let setup_s = start.elapsed().as_secs_f64();

    let at = |i: usize| asked["at_mm"][i].as_f64().unwrap_or(0.0);
    let solid = match (asked["presser"]["ball_mm"].as_f64(), asked["presser"]["pin_mm"].as_f64()) {
        (Some(radius_mm), _) => Solid::sphere(radius_mm).at(0.0, 0.0, radius_mm),
        (_, Some(radius_mm)) => {
            Solid::sphere(radius_mm).plus(Solid::cylinder(radius_mm, 20.0)).at(0.0, 0.0, radius_mm)
        }
        _ => return Err("indenter is missing: ball_mm or pin_mm".into()),
    };
    let solid = CompiledSolid::new(&solid)?;
    let indenter = SolidIndenter::new(&solid, &Pose::translation(at(0), at(1), 50.0));
    let mut press = Press::along(-Vector3::z(), number("depth_mm")?)?;
    if let Some(friction) = asked["friction"].as_f64() {
        let shear = |i: usize| asked["shear_mm"][i].as_f64().unwrap_or(0.0);
        press = press.with_shear(friction, Vector3::new(shear(0), shear(1), 0.0), 1)?;
    }
    let start = Instant::now();
    let outcome = match asked["level"].as_str() {
        Some("finite") => {
            let depth_mm = number("depth_mm")?;
            let steps: Vec<f64> = (1..=20).map(|i| depth_mm * f64::from(i) / 20.0).collect();
            let outcomes = FiniteStack::new(&body, &division)?.press(&indenter, &steps)?;
            outcomes.into_iter().next_back().ok_or("no outcome")?
        }
        None | Some("linear") => stack.press(&indenter, &press)?,
        Some(other) => return Err(format!("level {other:?} is neither linear nor finite").into()),
    };
    let press_s = start.elapsed().as_secs_f64();
    let mut answer = described(&stack, &outcome, setup_s, press_s);
    let probes = asked["probes_mm"].as_array().map(Vec::as_slice).unwrap_or_default();
    let at = |probe: &Value| {
        let [x, y] = [0, 1].map(|i| probe[i].as_f64().unwrap_or(f64::NAN));
        let moved = outcome.displacement_mm(0, y.atan2(x), along(&outcome, x.hypot(y)));
        moved.as_slice().to_vec()
    };
    answer["probes"] = probes.iter().map(at).collect();
    println!("{answer}");
    Ok(())
}

/// Builds the first layer as a spherical cap, bonded to its flat base.
fn cap(radius_mm: f64, height_mm: f64, layers: Vec<(ElasticLayer, f64)>) -> LayeredBody {
    let ball_mm = (radius_mm.powi(2) + height_mm.powi(2)) / (2.0 * height_mm);
    let widest = (radius_mm / ball_mm).asin();
    let outer = move |s: f64| {
        let angle = s * widest;
        [ball_mm * angle.sin(), height_mm - ball_mm * (1.0 - angle.cos())]
    };
    let base = move |s: f64| [outer(s)[0], 0.0];
    LayeredBody {
        interfaces: vec![MeridianCurve::new(outer), MeridianCurve::new(base)],
        layers: layers.into_iter().take(1).map(|(layer, _)| layer).collect(),
        inner: BoundaryCondition::Bonded,
        is_rim_bonded: true,
        kinks: Vec::new(),
    }
}

/// Finds the s at which the touched surface has a radius.
fn along(outcome: &PressOutcome, radius_mm: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if outcome.place_mm(0, 0.0, middle).x < radius_mm {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

fn described(stack: &ElasticStack, outcome: &PressOutcome, setup_s: f64, press_s: f64) -> Value {
    // Along azimuth 0, for comparison with axisymmetric solutions.
    let profile = |interface: usize| {
        let at = |s: &f64| {
            let place = outcome.place_mm(interface, 0.0, *s);
            let moved = outcome.displacement_mm(interface, 0.0, *s);
            json!([place.x, place.z, moved.x, moved.z])
        };
        outcome.columns().iter().map(at).collect::<Vec<Value>>()
    };
    json!({
        "contact_level": outcome.level.name(),
        "force_n": outcome.force_n.as_slice(),
        "moment_nmm": outcome.moment_nmm.as_slice(),
        "contact_radius_mm": outcome.contact_radius_mm,
        "contact_area_mm2": outcome.contact_area_mm2,
        "max_indentation_mm": outcome.max_indentation_mm,
        "bulge_mm": outcome.bulge_mm,
        "volume_change_mm3": outcome.volume_change_mm3,
        "surface_nodes": stack.surface_nodes(),
        "iterations": outcome.iterations,
        "setup_s": setup_s,
        "press_s": press_s,
        "profiles": (0..outcome.interfaces()).map(profile).collect::<Vec<Vec<Value>>>(),
    })
}
