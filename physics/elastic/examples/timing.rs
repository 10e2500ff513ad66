//! Measures the setup of a dome and its presses on one core.
//!
//! ```sh
//! cargo run --release -p fabkit-elastic --example timing -- [SPACING_MM] [MAX_HARMONIC] [THREADS]
//! ```
//!
//! A soft layer on a stiffer one, each 1.5 mm, on a rigid ball: a half sphere of 14 mm, pressed by a ball of 4 mm at
//! different places. The least of five times is printed, since other load on the machine only adds to it.

use std::error::Error;
use std::time::{Duration, Instant};

use fabkit_elastic::{
    BallIndenter, BoundaryCondition, ElasticLayer, ElasticMaterial, ElasticStack, LayeredBody,
    MeridianCurve, MeshDensity, Press,
};
use fabkit_geometry::{Point3, Vector3};

const RADII_MM: [f64; 3] = [14.0, 12.5, 11.0];

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let spacing_mm = arguments.next().map_or(Ok(0.35), |text| text.parse())?;
    let max_harmonic = arguments.next().map_or(Ok(40), |text| text.parse())?;
    let threads = arguments.next().map_or(Ok(1), |text| text.parse())?;
    let arc = |radius_mm: f64| {
        MeridianCurve::new(move |s| {
            let (sin, cos) = (s * std::f64::consts::FRAC_PI_2).sin_cos();
            [radius_mm * sin, radius_mm * cos]
        })
    };
    let layer = |name: &str, young_mpa| {
        Ok::<_, Box<dyn Error>>(ElasticLayer {
            name: name.to_owned(),
            material: ElasticMaterial::new(young_mpa, 0.495)?,
        })
    };
    let body = LayeredBody {
        interfaces: RADII_MM.map(arc).into(),
        layers: vec![layer("soft", 0.07)?, layer("stiff", 1.7)?],
        inner: BoundaryCondition::Bonded,
        is_rim_bonded: true,
        kinks: Vec::new(),
    };
    let start = Instant::now();
    let stack = ElasticStack::new(&body, &MeshDensity::uniform(spacing_mm, max_harmonic), threads)?;
    let [unknowns, harmonics] = stack.unknowns_and_max_harmonic();
    println!(
        "setup {:.2} s on {threads} threads: {} surface nodes, {unknowns} unknowns, \
         harmonics 0 to {harmonics}",
        start.elapsed().as_secs_f64(),
        stack.surface_nodes()
    );
    for (tilt_deg, depth_mm) in [(0.0_f64, 0.6), (0.0, 1.0), (20.0, 0.6), (45.0, 0.6), (45.0, 1.0)]
    {
        let (sin, cos) = tilt_deg.to_radians().sin_cos();
        let outward = Vector3::new(sin, 0.0, cos);
        let ball = BallIndenter::new(Point3::from(30.0 * outward), 4.0)?;
        let press = Press::along(-outward, depth_mm)?;
        let mut best = Duration::MAX;
        let mut outcome = stack.press(&ball, &press)?;
        for _ in 0..5 {
            let start = Instant::now();
            outcome = stack.press(&ball, &press)?;
            best = best.min(start.elapsed());
        }
        println!(
            "{tilt_deg:2} degrees off the tip, {depth_mm} mm deep: {:.1} ms, {} iterations; {:.4} N, \
             radius {:.2} mm, bulge {:.3} mm",
            best.as_secs_f64() * 1e3,
            outcome.iterations,
            -outcome.force_n.dot(&outward),
            outcome.contact_radius_mm,
            outcome.bulge_mm
        );
        let shear_mm = 0.3 * outward.cross(&Vector3::y());
        let start = Instant::now();
        let sheared = stack.press(&ball, &press.with_shear(0.6, shear_mm, 2)?)?;
        println!(
            "    sheared by 0.3 mm with friction 0.6: {:.1} ms; {:.4} N along, {:.0} % of its area sticks",
            start.elapsed().as_secs_f64() * 1e3,
            sheared.force_n.dot(&shear_mm) / shear_mm.norm(),
            100.0 * sheared.stick_area_mm2 / sheared.contact_area_mm2
        );
    }
    Ok(())
}
