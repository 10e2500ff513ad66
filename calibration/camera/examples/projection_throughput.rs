//! Nanoseconds per call, one core: `cargo run --release -p fabkit-camera --example projection_throughput`.

use std::hint::black_box;
use std::time::Instant;

use fabkit_camera::{
    Camera, DoubleSphere, Eucm, FlatInterface, Interface, Intrinsics, KannalaBrandt, Lens, OpenCv,
    Point2, Point3, SphericalInterface,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let at = Intrinsics { fx_px: 300.0, fy_px: 300.0, cx_px: 319.5, cy_px: 239.5 };
    let k = [-0.25971254, 0.08700416, -1.4873e-5, -2.28895e-4, -0.01535192];
    let lenses = [
        Lens::OpenCv(OpenCv::new(at, &k)?),
        Lens::KannalaBrandt(KannalaBrandt::new(at, [0.02, -0.013, 0.004, -0.0007])?),
        Lens::DoubleSphere(DoubleSphere::new(at, -0.18, 0.61)?),
        Lens::Eucm(Eucm::new(at, 0.63, 1.07)?),
    ];
    let interfaces = [
        Interface::None,
        Interface::Flat(FlatInterface {
            tilt_x_rad: 0.02,
            ..FlatInterface::bare_in_air(2.7, 1.41)
        }),
        Interface::Sphere(SphericalInterface {
            centre_in_camera: Point3::new(0.3, -0.2, 1.9),
            radius_mm: 11.0,
            index_inside: 1.0,
            index_outside: 1.41,
            has_drawn_bodies_behind: false,
        }),
    ];
    println!(
        "{:<16}{:<8}{:>12}{:>12}{:>12}",
        "ns per call", "", "unproject", "project", "jacobians"
    );
    for lens in lenses {
        for interface in interfaces {
            let camera = Camera::new(640, 480, lens, interface)?;
            let pixels: Vec<Point2<f64>> = (0..480)
                .flat_map(|row| (0..640).map(move |column| Point2::new(column.into(), row.into())))
                .filter(|pixel| camera.unproject(pixel).is_ok())
                .collect();
            let points: Vec<Point3<f64>> = pixels
                .iter()
                .filter_map(|pixel| Some(camera.unproject(pixel).ok()?.at(9.0)))
                .collect();
            println!(
                "{:<16}{:<8}{:>12.0}{:>12.0}{:>12.0}",
                lens.model_name(),
                interface.kind_name(),
                nanoseconds(&pixels, |pixel| camera.unproject(pixel)),
                nanoseconds(&points, |point| camera.project(point)),
                nanoseconds(&points, |point| camera.project_with_jacobians(point)),
            );
        }
    }
    Ok(())
}

/// Best of five passes.
fn nanoseconds<T, R>(inputs: &[T], call: impl Fn(&T) -> R) -> f64 {
    let pass = |_| {
        let start = Instant::now();
        for input in inputs {
            black_box(call(black_box(input)));
        }
        start.elapsed().as_secs_f64() * 1e9 / inputs.len() as f64
    };
    (0..5).map(pass).fold(f64::INFINITY, f64::min)
}
