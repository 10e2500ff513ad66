//! Two parts of tactile sensors with volumes known in closed form.

use std::f64::consts::PI;

use nalgebra::{Point3, Vector3};

use fabkit_geometry::{CUT_OVERLAP_MM, Pattern, Solid};

/// Computes the volume of the core that a coaxial cylinder of radius `a` cuts out of half a ball, from the plane
/// through the ball's centre up to the sphere, mm^3.
fn core_mm3(ball_mm: f64, a: f64) -> f64 {
    2.0 * PI / 3.0 * (ball_mm.powi(3) - (ball_mm * ball_mm - a * a).powf(1.5))
}

/// Builds half a hollow ball, radii 18 and 15 mm, with 100 radial holes of diameter 1 mm. Returns it with its volume in
/// mm^3: 4910.254750.
///
/// The holes lie on a Fibonacci lattice that keeps them apart from each other and from the rim. Each hole thus removes
/// what a cylinder cuts out between two concentric spheres.
pub fn perforated_dome() -> (Solid, f64) {
    let (outer, inner, hole) = (18.0, 15.0, 0.5);
    let upwards = Solid::behind(Point3::origin(), -Vector3::z());
    let shell = Solid::sphere(outer).minus(Solid::sphere(inner)).and(upwards);
    let tool = Solid::cylinder(hole, outer - inner + 2.0).at(0.0, 0.0, -1.0);
    let lattice =
        Pattern::Fibonacci { count: 100, radius_mm: inner, half_angle_rad: 80f64.to_radians() };
    let holes = lattice.features("hole", &tool).expect("the lattice is valid");
    let half_shell_mm3 = 2.0 * PI / 3.0 * (f64::powi(outer, 3) - f64::powi(inner, 3));
    let hole_mm3 = core_mm3(outer, hole) - core_mm3(inner, hole);
    (shell.minus_all(holes), half_shell_mm3 - 100.0 * hole_mm3)
}

/// Builds a mold block, 45 x 45 x 14 mm, with a spherical cap (base diameter 35, height 8 mm) sunk into its top and 200
/// dimples in the wall of the cap. Returns it with its volume in mm^3: 24219.930363.
///
/// A dimple is a cylinder of diameter 0.45 mm with a hemispherical tip. It reaches 0.5 mm beyond the sphere, along the
/// normal.
pub fn dimpled_mold() -> (Solid, f64) {
    let (base, height): (f64, f64) = (17.5, 8.0);
    let (top, dimple, depth): (f64, f64, f64) = (14.0, 0.225, 0.5);
    let ball = (base * base + height * height) / (2.0 * height);
    let sphere = Solid::sphere(ball);
    // In the sphere's frame, tip up: the shaft points from inside the sphere outwards.
    let shaft = Solid::cylinder(dimple, CUT_OVERLAP_MM + depth - dimple)
        .at(0.0, 0.0, -CUT_OVERLAP_MM)
        .plus(Solid::sphere(dimple).at(0.0, 0.0, depth - dimple));
    let lattice =
        Pattern::Fibonacci { count: 200, radius_mm: ball, half_angle_rad: 45f64.to_radians() };
    let dimples = lattice.features("dimple", &shaft).expect("the lattice is valid");
    // Turned over and centred above the block.
    let over = |solid: Solid| {
        let half_turn = fabkit_geometry::Angle::from_rad(PI).expect("finite");
        solid.turned_x(half_turn).at(0.0, 0.0, top - height + ball)
    };
    let mold = Solid::cuboid(45.0, 45.0, top)
        .minus(over(sphere).named("cap"))
        .minus_all(dimples.into_iter().map(over));
    let cap_mm3 = PI * height * (3.0 * base * base + height * height) / 6.0;
    // The volume of a dimple is the part above the tangent plane of the sphere, plus the part between plane and sphere.
    let shaft_mm3 = PI * dimple * dimple * (depth - dimple) + 2.0 / 3.0 * PI * dimple.powi(3);
    let beyond_mm3 = PI * dimple * dimple * ball - core_mm3(ball, dimple);
    (mold, 45.0 * 45.0 * top - cap_mm3 - 200.0 * (shaft_mm3 + beyond_mm3))
}
