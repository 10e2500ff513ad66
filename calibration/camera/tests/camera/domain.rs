//! End of each lens's domain, found independently by brute force, and the errors beyond it.

use crate::common;

use std::f64::consts::{PI, TAU};

use common::INTRINSICS;
use fabkit_camera::{
    Camera, DoubleSphere, Eucm, Interface, KannalaBrandt, Lens, OpenCv, OutsideDomain, Point2,
    Point3,
};
use proptest::prelude::*;

fn bare(lens: Lens) -> Camera {
    Camera::new(640, 480, lens, Interface::None).unwrap()
}

fn towards(theta: f64, azimuth: f64) -> Point3<f64> {
    let (sin, cos) = theta.sin_cos();
    Point3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos)
}

/// The first angle at which a radius ceases to grow, by steps and then by finer steps.
fn first_fold(radius: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, PI);
    for _ in 0..3 {
        let step = (high - low) / 4000.0;
        let folds = |i: &i32| {
            let theta = low + f64::from(*i) * step;
            // Not growing, infinite, or beyond infinity.
            let (here, next) = (radius(theta), radius(theta + step));
            !(next > here && here >= 0.0 && next < 1e9)
        };
        let Some(first) = (0..4000).find(folds) else { return PI };
        let centre = low + f64::from(first) * step;
        (low, high) = ((centre - step).max(0.0), (centre + 2.0 * step).min(PI));
    }
    0.5 * (low + high)
}

/// Compares a lens with the radius that its model states, in units of the focal length.
fn check_radial(lens: Lens, radius: impl Fn(f64) -> f64) {
    let camera = bare(lens);
    let limit_rad = camera.angle_limit_rad();
    // The third pass of `first_fold` steps by 1e-9; at a maximum, radii differ by squares.
    let expected = first_fold(&radius);
    assert!((limit_rad - expected).abs() < 2e-6, "{lens:?}: {limit_rad} {expected}");
    for i in 1..=19 {
        let theta = limit_rad * 0.05 * f64::from(i);
        let pixel = camera.project(&towards(theta, 0.0)).unwrap();
        let expected_px = INTRINSICS.fx_px * radius(theta) + INTRINSICS.cx_px;
        let error_px = (pixel.x - expected_px).abs().max((pixel.y - INTRINSICS.cy_px).abs());
        assert!(error_px < 1e-12 * expected_px.max(1e3), "{lens:?} at {theta}: {error_px:e}");
    }
}

#[test]
fn lenses_follow_their_models_up_to_where_the_radius_ceases_to_grow() {
    for k in
        [[0.0; 4], [-0.1, 0.0, 0.0, 0.0], [0.02, -0.013, 0.004, -0.0007], [0.3, -0.3, 0.05, 0.0]]
    {
        let lens = KannalaBrandt::new(INTRINSICS, k).unwrap();
        check_radial(Lens::KannalaBrandt(lens), |t| {
            t + k[0] * t.powi(3) + k[1] * t.powi(5) + k[2] * t.powi(7) + k[3] * t.powi(9)
        });
    }
    for (xi, alpha) in [(-0.18, 0.61), (0.4, 0.8), (-0.5, 0.3), (0.0, 0.5)] {
        let lens = DoubleSphere::new(INTRINSICS, xi, alpha).unwrap();
        check_radial(Lens::DoubleSphere(lens), |t| {
            let z1 = t.cos() + xi;
            t.sin() / (alpha * t.sin().hypot(z1) + (1.0 - alpha) * z1)
        });
    }
    for (alpha, beta) in [(0.63, 1.07), (0.4, 2.0), (1.0, 0.7)] {
        let lens = Eucm::new(INTRINSICS, alpha, beta).unwrap();
        check_radial(Lens::Eucm(lens), |t| {
            let d = (beta * t.sin().powi(2) + t.cos().powi(2)).sqrt();
            t.sin() / (alpha * d + (1.0 - alpha) * t.cos())
        });
    }
    for k in [
        [-0.25971254, 0.08700416, 0.0, 0.0, -0.01535192, 0.0, 0.0, 0.0],
        [-0.3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.21, -0.13, 0.0, 0.0, 0.011, 0.45, -0.06, 0.02],
        // A pole of the rational function comes first.
        [0.0, 0.0, 0.0, 0.0, 0.0, -0.5, 0.0, 0.0],
    ] {
        let lens = OpenCv::new(INTRINSICS, &k).unwrap();
        check_radial(Lens::OpenCv(lens), |t| {
            let (r, u) = (t.tan(), t.tan().powi(2));
            r * (1.0 + u * (k[0] + u * (k[1] + u * k[4])))
                / (1.0 + u * (k[5] + u * (k[6] + u * k[7])))
        });
    }
    // In closed form: 1 - 0.3 theta^2 = 0.
    let lens = Lens::KannalaBrandt(KannalaBrandt::new(INTRINSICS, [-0.1, 0.0, 0.0, 0.0]).unwrap());
    assert!((lens.angle_limit_rad() - (1.0f64 / 0.3).sqrt()).abs() < 1e-15);
}

#[test]
fn tangential_terms_end_the_domain_at_their_worst_azimuth() {
    let k = [-0.26, 0.087, 8e-3, -5e-3, -0.0153];
    let lens = Lens::OpenCv(OpenCv::new(INTRINSICS, &k).unwrap());
    let radial = Lens::OpenCv(OpenCv::new(INTRINSICS, &[k[0], k[1], 0.0, 0.0, k[4]]).unwrap());
    let limit = lens.angle_limit_rad().tan();
    assert!(limit < 0.99 * radial.angle_limit_rad().tan());
    let distort = |x: f64, y: f64| {
        let u = x * x + y * y;
        let s = 1.0 + u * (k[0] + u * (k[1] + u * k[4]));
        let (p1, p2) = (k[2], k[3]);
        (
            x * s + 2.0 * p1 * x * y + p2 * (u + 2.0 * x * x),
            y * s + p1 * (u + 2.0 * y * y) + 2.0 * p2 * x * y,
        )
    };
    let determinant = |r: f64, azimuth: f64| {
        let (x, y, h) = (r * azimuth.cos(), r * azimuth.sin(), 1e-5);
        let ((ax, ay), (bx, by)) = (distort(x + h, y), distort(x - h, y));
        let ((cx, cy), (dx, dy)) = (distort(x, y + h), distort(x, y - h));
        ((ax - bx) * (cy - dy) - (ay - by) * (cx - dx)) / (4.0 * h * h)
    };
    let least = |r: f64| {
        (0..3600).map(|i| determinant(r, f64::from(i) * TAU / 3600.0)).fold(f64::MAX, f64::min)
    };
    // Positive everywhere inside, and gone just beyond; differences are good to about 1e-9.
    for i in 1..=100 {
        assert!(least(limit * (0.001 + 0.00998 * f64::from(i))) > 0.0);
    }
    assert!(least(limit * 0.99999) > 0.0 && least(limit * 1.00001) < 0.0);
}

/// Lenses of all kinds with coefficients that no one would choose.
fn any_lens() -> impl Strategy<Value = Lens> {
    let k = || prop::array::uniform8(-1.0..1.0f64);
    let opencv = (k(), 0..3usize).prop_map(|(k, kind)| {
        let [k1, k2, p1, p2, k3, ..] = k;
        let p = [p1 * 0.1, p2 * 0.1];
        match kind {
            0 => OpenCv::new(INTRINSICS, &[k1, k2, p[0], p[1]]),
            1 => OpenCv::new(INTRINSICS, &[k1, k2, 0.0, 0.0, k3]),
            _ => OpenCv::new(INTRINSICS, &[k1, k2, p[0], p[1], k3, k[5], k[6], k[7]]),
        }
        .map(Lens::OpenCv)
    });
    let kannala_brandt = k().prop_map(|k| {
        KannalaBrandt::new(INTRINSICS, [k[0], 0.3 * k[1], 0.1 * k[2], 0.03 * k[3]])
            .map(Lens::KannalaBrandt)
    });
    let double_sphere = (-0.95..0.95f64, 0.0..=1.0f64)
        .prop_map(|(xi, alpha)| DoubleSphere::new(INTRINSICS, xi, alpha).map(Lens::DoubleSphere));
    let eucm = (0.0..=1.0f64, 0.1..5.0f64)
        .prop_map(|(alpha, beta)| Eucm::new(INTRINSICS, alpha, beta).map(Lens::Eucm));
    prop_oneof![opencv, kannala_brandt, double_sphere, eucm]
        .prop_filter_map("folds back at once", Result::ok)
}

proptest! {
    #![proptest_config(common::cases(20_000))]

    #[test]
    fn any_lens_is_one_to_one_within_its_limit_and_silent_beyond(
        lens in any_lens(),
        fraction in 0.0..0.98f64,
        azimuth in 0.0..TAU,
        beyond in 1e-9..1.0f64,
    ) {
        let camera = bare(lens);
        let limit_rad = camera.angle_limit_rad();
        let inside = towards(fraction * limit_rad, azimuth);
        let pixel = camera.project(&inside).unwrap();
        let ray = camera.unproject(&pixel).unwrap();
        // Radii that grow without end (alpha up to 1/2) lose digits in proportion.
        let far = 1.0 + (pixel - Point2::new(INTRINSICS.cx_px, INTRINSICS.cy_px)).norm() / 300.0;
        let miss = ray.direction.cross(&inside.coords).norm();
        prop_assert!(miss < 1e-12 * far, "{lens:?}: {miss:e}");
        prop_assert!(ray.direction.dot(&inside.coords) > 0.0);

        let angle_rad = limit_rad + beyond * (PI - limit_rad);
        match camera.project(&towards(angle_rad, azimuth)) {
            // Rounding of the sine and cosine of 180 degrees.
            _ if angle_rad > PI - 1e-9 => {}
            Err(OutsideDomain::Angle { angle_rad: said, limit_rad: end }) => {
                prop_assert!((said - angle_rad).abs() < 1e-9 && end == limit_rad);
            }
            other => prop_assert!(false, "{lens:?} at {angle_rad}: {other:?}"),
        }
    }

    #[test]
    fn any_pixel_has_a_ray_that_leads_back_or_none(
        lens in any_lens(),
        radius_px in 0.0..3000.0f64,
        azimuth in 0.0..TAU,
    ) {
        let camera = bare(lens);
        let pixel = Point2::new(radius_px * azimuth.cos(), radius_px * azimuth.sin());
        if let Ok(ray) = camera.unproject(&pixel) {
            let angle_rad = ray.direction.xy().norm().atan2(ray.direction.z);
            prop_assert!(angle_rad <= camera.angle_limit_rad() + 1e-12);
            if angle_rad < 0.999 * camera.angle_limit_rad() {
                let again = camera.project(&Point3::from(ray.direction)).unwrap();
                let miss_px = (again - pixel).norm();
                prop_assert!(miss_px < 1e-9, "{lens:?} at {pixel}: {miss_px:e}");
            }
        }
    }
}

#[test]
fn what_has_no_direction_is_refused_by_every_camera() {
    for (name, camera, _) in common::cameras() {
        for point in [[f64::NAN, 0.0, 5.0], [0.0, f64::INFINITY, 5.0], [0.0, 0.0, f64::INFINITY]] {
            let answer = camera.project(&Point3::from(point));
            assert!(answer.is_err(), "{name} {point:?}: {answer:?}");
            assert!(camera.project_with_jacobians(&Point3::from(point)).is_err());
        }
        for scale in [1e-200, 1e200] {
            let point = Point3::new(3.0, -4.0, 5.0) * scale;
            // An answer must be the right one: that of the same direction.
            if let Ok(pixel) = camera.project(&point) {
                assert!(pixel.x.is_finite() && pixel.y.is_finite(), "{name} {scale}: {pixel}");
            }
        }
        assert!(camera.project(&Point3::origin()).is_err(), "{name}");
        for pixel in [[f64::NAN, 3.0], [3.0, f64::INFINITY]] {
            assert!(camera.unproject(&Point2::from(pixel)).is_err(), "{name} {pixel:?}");
        }
        for far in [1e9, 1e160, 1e308] {
            if let Ok(ray) = camera.unproject(&Point2::new(far, far)) {
                assert!((ray.direction.norm() - 1.0).abs() < 1e-9, "{name} {far}: {ray:?}");
            }
        }
    }
}

#[test]
fn pixels_beyond_the_image_circle_are_refused_with_the_limit() {
    let (_, lens, _) = common::lenses().remove(3);
    let camera = bare(lens);
    let edge = camera.project(&towards(camera.angle_limit_rad(), 0.0)).unwrap();
    assert!(camera.unproject(&Point2::new(edge.x - 1e-6, edge.y)).is_ok());
    let refused = camera.unproject(&Point2::new(edge.x + 1e-6, edge.y)).unwrap_err();
    let limit_rad = camera.angle_limit_rad();
    assert!(matches!(refused, OutsideDomain::Pixel { limit_rad: said, .. } if said == limit_rad));
    let message = camera.project(&Point3::new(0.0, 0.0, -1.0)).unwrap_err().to_string();
    let expected = format!(
        "180.000 degrees off the optical axis; the lens model ends at {:.3} degrees",
        limit_rad.to_degrees()
    );
    assert_eq!(message, expected);
}
