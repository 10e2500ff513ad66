//! Cameras of every kind, with realistic parameters.
use fabkit_camera::{
    Camera, DoubleSphere, Eucm, FlatInterface, Interface, Intrinsics, KannalaBrandt, Lens, OpenCv,
    Point3, SphericalInterface,
};
use proptest::prelude::*;

/// Configures property tests with the same cases in every run.
pub fn cases(count: u32) -> ProptestConfig {
    ProptestConfig {
        rng_seed: proptest::test_runner::RngSeed::Fixed(20_260_101),
        failure_persistence: None,
        ..ProptestConfig::with_cases(count)
    }
}

pub const INTRINSICS: Intrinsics =
    Intrinsics { fx_px: 299.97, fy_px: 297.81, cx_px: 325.24, cy_px: 264.89 };

/// Five distortion terms of a 160 degree lens; eight terms of a similar one are below.
pub const FIVE: [f64; 5] = [-0.25971254, 0.08700416, -1.4873e-5, -2.28895e-4, -0.01535192];
pub const EIGHT: [f64; 8] = [0.95, 0.18, 4e-4, -7e-4, 0.004, 1.26, 0.42, 0.03];

/// Lists each lens, with the largest incidence angle that tests use.
pub fn lenses() -> Vec<(&'static str, Lens, f64)> {
    let far = 100f64.to_radians();
    let mut lenses = vec![
        ("pinhole", Lens::OpenCv(OpenCv::new(INTRINSICS, &[]).unwrap()), 1.2),
        ("five terms", Lens::OpenCv(OpenCv::new(INTRINSICS, &FIVE).unwrap()), 1.4),
        ("eight terms", Lens::OpenCv(OpenCv::new(INTRINSICS, &EIGHT).unwrap()), 1.4),
        (
            "kannala-brandt",
            Lens::KannalaBrandt(
                KannalaBrandt::new(INTRINSICS, [0.02, -0.013, 0.004, -0.0007]).unwrap(),
            ),
            far,
        ),
        (
            "double sphere",
            Lens::DoubleSphere(DoubleSphere::new(INTRINSICS, -0.18, 0.61).unwrap()),
            far,
        ),
        ("eucm", Lens::Eucm(Eucm::new(INTRINSICS, 0.63, 1.07).unwrap()), far),
    ];
    for (_, lens, most_rad) in &mut lenses {
        // Close to the limit the pixel hardly depends on the angle, so that digits are lost.
        *most_rad = most_rad.min(0.97 * lens.angle_limit_rad());
    }
    lenses
}

pub fn interfaces() -> Vec<(&'static str, Interface)> {
    let tilted = FlatInterface {
        tilt_x_rad: 0.06,
        tilt_y_rad: -0.09,
        has_drawn_bodies_behind: true,
        ..FlatInterface::bare_in_air(2.7, 1.41)
    };
    let sphere = SphericalInterface {
        centre_in_camera: Point3::new(0.3, -0.2, 1.9),
        radius_mm: 11.0,
        index_inside: 1.0,
        index_outside: 1.41,
        has_drawn_bodies_behind: false,
    };
    let centred = SphericalInterface {
        centre_in_camera: Point3::origin(),
        has_drawn_bodies_behind: true,
        ..sphere
    };
    vec![
        ("none", Interface::None),
        ("flat", Interface::Flat(FlatInterface::bare_in_air(2.7, 1.41))),
        ("tilted", Interface::Flat(tilted)),
        (
            "pane",
            Interface::Flat(FlatInterface { glass_thickness_mm: 1.1, index_glass: 1.52, ..tilted }),
        ),
        ("sphere", Interface::Sphere(sphere)),
        ("concentric", Interface::Sphere(centred)),
    ]
}

/// All lenses behind all interfaces, with a name and the largest incidence angle to ask about.
pub fn cameras() -> Vec<(String, Camera, f64)> {
    let mut cameras = Vec::new();
    for (lens_name, lens, most_rad) in lenses() {
        for (interface_name, interface) in interfaces() {
            let camera = Camera::new(640, 480, lens, interface).unwrap();
            // A flat interface is not met beyond 90 degrees to its normal (tilted by 0.11 here).
            let most_rad = match interface {
                Interface::Flat(_) => most_rad.min(1.4),
                _ => most_rad,
            };
            cameras.push((format!("{lens_name} / {interface_name}"), camera, most_rad));
        }
    }
    cameras
}

/// One of [`cameras`], and a pixel whose direction in front of the lens is within its angle.
pub fn camera_and_pixel() -> impl Strategy<Value = (String, Camera, fabkit_camera::Point2<f64>)> {
    let cameras = cameras();
    // Uniform in angle, so that the axis is met often enough to matter.
    (0..cameras.len(), 0.0..1.0f64, 0.0..std::f64::consts::TAU).prop_map(
        move |(index, fraction, azimuth_rad)| {
            let (name, camera, most_rad) = cameras[index].clone();
            let (sin, cos) = (fraction * most_rad).sin_cos();
            let direction = Point3::new(sin * azimuth_rad.cos(), sin * azimuth_rad.sin(), cos);
            let bare = Camera::new(640, 480, *camera.lens(), Interface::None).unwrap();
            (name, camera, bare.project(&direction).unwrap())
        },
    )
}
