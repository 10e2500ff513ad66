//! Error of inverse distortion: solved exactly, and by negated coefficients as published.

use fabkit_camera::{Camera, Interface, Intrinsics, Lens, OpenCv};
use fabkit_depth::ground_truth::{PixelRays, ReferenceSurface};
use fabkit_geometry::{DomeSurface, EllipsoidOffset, FixtureGrip, Path, Point3, Pose};

/// The camera of R-Tac0's authors: focal lengths, centre, then OpenCV's k1 k2 p1 p2 k3.
const INTRINSICS: Intrinsics = Intrinsics {
    fx_px: 299.97297618,
    fy_px: 299.81689507,
    cx_px: 325.24480754,
    cy_px: 264.89790698,
};
const COEFFICIENTS: [f64; 5] = [-0.25971254, 0.08700416, -1.4873e-5, -2.28895e-4, -0.01535192];

/// Reference dome of the authors, in the camera's frame.
const RADIUS_MM: f64 = 15.1;
const CENTRE_Z_MM: f64 = 6.0;
const CAMERA_Z_MM: f64 = 0.0;

/// The polynomial with tangential terms (Brown 1971, in OpenCV's form).
fn distort([x, y]: [f64; 2], [k1, k2, p1, p2, k3]: [f64; 5]) -> [f64; 2] {
    let r2 = x * x + y * y;
    let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
    [
        x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
        y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
    ]
}

/// Undistorts by Newton's method with differences; `None` where it does not settle on the image's own branch.
fn undistort(wanted: [f64; 2]) -> Option<[f64; 2]> {
    const STEP: f64 = 1e-7;
    let mut at = wanted;
    for _ in 0..50 {
        let [u, v] = distort(at, COEFFICIENTS);
        let (eu, ev) = (u - wanted[0], v - wanted[1]);
        let moved = |dx: f64, dy: f64| distort([at[0] + dx, at[1] + dy], COEFFICIENTS);
        let (px, mx) = (moved(STEP, 0.0), moved(-STEP, 0.0));
        let (py, my) = (moved(0.0, STEP), moved(0.0, -STEP));
        let slope = |a: f64, b: f64| (a - b) / (2.0 * STEP);
        let (a, b) = (slope(px[0], mx[0]), slope(py[0], my[0]));
        let (c, d) = (slope(px[1], mx[1]), slope(py[1], my[1]));
        let determinant = a * d - b * c;
        at = [at[0] - (d * eu - b * ev) / determinant, at[1] - (a * ev - c * eu) / determinant];
        if eu.hypot(ev) < 1e-15 {
            break;
        }
    }
    let [u, v] = distort(at, COEFFICIENTS);
    ((u - wanted[0]).hypot(v - wanted[1]) < 1e-13).then_some(at)
}

/// Distance from the camera to the dome along the direction (x, y, 1), mm.
fn range_mm([x, y]: [f64; 2]) -> f64 {
    let length = (x * x + y * y + 1.0).sqrt();
    let along = (CENTRE_Z_MM - CAMERA_Z_MM) / length;
    let closest_squared = (CENTRE_Z_MM - CAMERA_Z_MM).powi(2) - along * along;
    along + (RADIUS_MM * RADIUS_MM - closest_squared).sqrt()
}

#[test]
fn inverse_distortion_is_exact_and_the_published_one_is_not() {
    let lens = Lens::OpenCv(OpenCv::new(INTRINSICS, &COEFFICIENTS).unwrap());
    let camera = Camera::new(640, 480, lens, Interface::None).unwrap();
    let touch = DomeSurface {
        dome: EllipsoidOffset { equatorial_mm: RADIUS_MM, polar_mm: RADIUS_MM, offset_mm: 0.0 },
        centre_z_mm: CENTRE_Z_MM,
        foot_z_mm: 0.0,
        max_indentation_mm: 1.5,
        grip: FixtureGrip {
            outline: Path::circle([0.0, 0.0], RADIUS_MM),
            top_z_mm: 0.0,
            bottom_z_mm: -20.0,
            clear_radius_mm: 0.0,
            key: None,
            threads: Vec::new(),
        },
    };
    let rays = PixelRays::new(&camera, &Pose::translation(0.0, 0.0, CAMERA_Z_MM));
    let surface = ReferenceSurface::cast(&touch.into(), &rays).unwrap();
    let (mut worst_mm, mut count) = (0.0f64, 0);
    let mut published_mm: Vec<f64> = Vec::new();
    for pixel in 0..rays.len() {
        let (column, row) = ((pixel % 640) as f64, (pixel / 640) as f64);
        let seen = [
            (column - INTRINSICS.cx_px) / INTRINSICS.fx_px,
            (row - INTRINSICS.cy_px) / INTRINSICS.fy_px,
        ];
        let found = surface.range_mm()[pixel];
        let Some(direction) = undistort(seen).filter(|_| found.is_finite()) else { continue };
        let exact = range_mm(direction);
        let point = Point3::new(direction[0], direction[1], 1.0);
        // On the wall below the dome, both would be compared with the wrong surface.
        if CAMERA_Z_MM + exact / point.coords.norm() < CENTRE_Z_MM {
            continue;
        }
        worst_mm = worst_mm.max((found - exact).abs());
        let theirs = range_mm(distort(seen, COEFFICIENTS.map(|k| -k)));
        published_mm.push((theirs - exact).abs());
        count += 1;
    }
    published_mm.sort_by(f64::total_cmp);
    let mean = published_mm.iter().sum::<f64>() / published_mm.len() as f64;
    let (median, largest) = (published_mm[count / 2], published_mm[count - 1]);
    println!(
        "{count} pixels: fabkit at most {worst_mm:.1e} mm off; negated coefficients {mean:.3} mm \
         on average, {median:.3} mm at the median, {largest:.3} mm at worst"
    );
    assert!(count > 100_000, "{count}");
    assert!(worst_mm < 1e-9, "{worst_mm}");
    // Published: about 0.16 on average, 0.72 at worst within a mask that is a little smaller.
    assert!((0.15..0.17).contains(&mean) && (0.7..0.8).contains(&largest), "{mean} {largest}");
}
