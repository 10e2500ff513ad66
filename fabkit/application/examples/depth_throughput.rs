//! Measures rays per second of ground truth on one core, for presses of a built-in sensor, as JSON:
//! `cargo run --release -p fabkit-application --example depth_throughput -- rtac0 semi-dome-003 semi-dome-017`.

use std::error::Error;
use std::fs;
use std::sync::LazyLock;
use std::time::Instant;

use fabkit_application::depth::ground_truth::{PlacedIndenter, ReferenceSurface};
use fabkit_application::ground_truth::{Viewpoint, compile_indenters};
use serde_json::json;

/// Number of timed passes, after one warm-up pass.
const PASSES: u32 = 20;

/// Returns the CPU time of this thread if Linux reports it, which other load on the machine does not affect; otherwise
/// wall time.
fn cpu_seconds() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    // The first number is the nanoseconds on a processor, here of the main thread only.
    let stat = fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = stat.and_then(|s| s.split(' ').next().and_then(|t| t.parse::<f64>().ok()));
    nanoseconds.map_or_else(|| START.elapsed().as_secs_f64(), |ns| ns * 1e-9)
}

fn main() -> Result<(), Box<dyn Error>> {
    // Runs everything on this thread, so that its CPU time is all there is.
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global()?;
    let mut arguments = std::env::args().skip(1);
    let sensor = arguments.next().ok_or("which sensor?")?;
    let yaml = fabkit_application::designs::builtin_yaml(&sensor).ok_or("no such sensor")?;
    let project = fabkit_application::fixtures::load(&format!("{sensor}.yaml"), yaml, &[])?;
    let touch = project.design.sensor.touch.as_ref().ok_or("it has no curved surface")?;
    let viewpoint = Viewpoint::new(&project.design.sensor.camera, None, None)?;
    let presses = arguments.map(|id| project.press(&id)).collect::<Result<Vec<_>, _>>()?;
    let indenters: Vec<PlacedIndenter> = compile_indenters(&presses)?;

    let rays = viewpoint.rays(1);
    let surface = ReferenceSurface::cast(touch, &rays)?;
    let contact =
        surface.map_with_indenters(&indenters).contact().filter(|contact| *contact).count();
    // Only rays that reach the surface count, although the others are cast as well.
    let seen = surface.visible_pixels() as f64;
    let mray_per_cpu_s = |rays: f64, pass: &mut dyn FnMut()| {
        pass();
        let start = cpu_seconds();
        (0..PASSES).for_each(|_| pass());
        f64::from(PASSES) * rays / (cpu_seconds() - start) / 1e6
    };
    let report = json!({
        "rays": rays.len(),
        "rays_to_surface": surface.visible_pixels(),
        "rays_to_pressers": contact,
        "pressers": indenters.len(),
        // Unprojection goes first: the allocator keeps the memory that it frees for the later passes, which would
        // otherwise wait for the system to clear pages.
        "mray_per_cpu_s": {
            "unprojection": mray_per_cpu_s(rays.len() as f64, &mut || drop(viewpoint.rays(1))),
            "reference_and_press": mray_per_cpu_s(seen, &mut || {
                let surface = ReferenceSurface::cast(touch, &rays);
                let _ = surface.map(|surface| drop(surface.map_with_indenters(&indenters)));
            }),
            "reference": mray_per_cpu_s(seen, &mut || drop(ReferenceSurface::cast(touch, &rays))),
            "press": mray_per_cpu_s(seen, &mut || drop(surface.map_with_indenters(&indenters))),
        },
    });
    println!("{report}");
    Ok(())
}
