//! Rays per second of ground truth, on one core: `cargo run --release -p fabkit-depth --example
//! truth_throughput`.

use std::fs;
use std::sync::LazyLock;
use std::time::Instant;

use fabkit_camera::Camera;
use fabkit_depth::truth::{PixelRays, Presser, Surface};
use fabkit_geometry::{EllipsoidOffset, Grip, Path, Pattern, Pose, Solid, TouchSurface};

/// R-Tac0's surface: a hemisphere on a straight wall.
fn touch() -> TouchSurface {
    TouchSurface {
        dome: EllipsoidOffset { equatorial_mm: 15.0, polar_mm: 15.0, offset_mm: 0.0 },
        centre_z_mm: 6.0,
        foot_z_mm: 0.0,
        soft_mm: 1.5,
        grip: Grip {
            outline: Path::circle([0.0, 0.0], 15.0),
            top_z_mm: 0.0,
            bottom_z_mm: -21.0,
            clear_radius_mm: 13.0,
            key: None,
            threads: Vec::new(),
        },
    }
}

/// CPU time of this process where Linux tells, which does not mind busy machines; else wall time.
fn cpu_seconds() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    // Nanoseconds on a processor, of the main thread alone.
    let stat = fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = stat.and_then(|s| s.split(' ').next().and_then(|t| t.parse::<f64>().ok()));
    nanoseconds.map_or_else(|| START.elapsed().as_secs_f64(), |ns| ns * 1e-9)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Everything on this one thread.
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global()?;
    let camera = Camera::equidistant(640, 480, 160f64.to_radians())?;
    let sensor_from_camera = Pose::translation(0.0, 0.0, -7.0);
    let places = Pattern::Fibonacci { count: 20, radius_mm: 15.0, half_angle_rad: 1.2 }.poses()?;
    let pressers: Vec<Presser> = places
        .into_iter()
        .enumerate()
        .map(|(i, pose)| {
            let solid = match i % 3 {
                0 => Solid::sphere(1.5),
                1 => Solid::cylinder(1.0, 2.0).at(0.0, 0.0, -0.8),
                _ => Solid::cone(0.2, 1.0, 2.0).at(0.0, 0.0, -1.0),
            };
            let pose = Pose::translation(0.0, 0.0, 6.0).then_in(pose);
            Presser::new(format!("protrusion {}", i + 1), &solid, pose)
        })
        .collect::<Result<_, _>>()?;

    let count = 640.0 * 480.0;
    let mrays = |name: &str, repeats: u32, run: &mut dyn FnMut()| {
        let start = cpu_seconds();
        (0..repeats).for_each(|_| run());
        let seconds = (cpu_seconds() - start) / f64::from(repeats);
        println!("{name:32} {:8.2} Mray/CPU-s, {:7.2} ms", count / seconds / 1e6, seconds * 1e3);
    };
    let rays = PixelRays::new(&camera, &sensor_from_camera);
    let surface = Surface::cast(&touch(), &rays)?;
    let map = surface.pressed(&pressers);
    let contact = map.contact().filter(|c| *c).count();
    println!("{} of {count} pixels see the surface, {contact} contact", surface.seen());
    mrays("rays of a camera", 10, &mut || drop(PixelRays::new(&camera, &sensor_from_camera)));
    mrays("reference surface", 10, &mut || drop(Surface::cast(&touch(), &rays)));
    mrays("20 protrusions", 10, &mut || drop(surface.pressed(&pressers)));
    mrays("reference and 20 protrusions", 10, &mut || {
        let surface = Surface::cast(&touch(), &rays);
        let _ = surface.map(|surface| drop(surface.pressed(&pressers)));
    });
    Ok(())
}
