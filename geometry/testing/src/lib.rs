//! Random solids and lines for property tests, used here and in the crates that mesh or cast solids.
//!
//! All solids are in general position: random rotations and shifts keep faces from coinciding.

mod reference_parts;

use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

pub use self::reference_parts::{dimpled_mold, perforated_dome};
use fabkit_geometry::{Angle, Path, Pose, Profile, Ray, Solid};

/// Returns a configuration with `count` cases and a fixed seed, so that every run tests the same cases.
pub fn cases(count: u32) -> ProptestConfig {
    ProptestConfig {
        rng_seed: RngSeed::Fixed(20_260_101),
        failure_persistence: None,
        ..ProptestConfig::with_cases(count)
    }
}

/// Generates unit vectors, uniformly distributed.
pub fn directions() -> impl Strategy<Value = Vector3<f64>> {
    (-1.0f64..1.0, 0.0..std::f64::consts::TAU).prop_map(|(z, angle)| {
        let across = (1.0 - z * z).sqrt();
        Vector3::new(across * angle.cos(), across * angle.sin(), z)
    })
}

fn radians(angle: f64) -> Angle {
    Angle::from_rad(angle).expect("strategies draw finite angles")
}

/// Generates rigid motions: any rotation axis, shifts up to `shift_mm` along each coordinate.
pub fn poses(shift_mm: f64) -> impl Strategy<Value = Pose> {
    let shift = -shift_mm..=shift_mm;
    (directions(), 0.0..std::f64::consts::TAU, [shift.clone(), shift.clone(), shift]).prop_map(
        |(axis, angle, at)| {
            Pose::z_to(axis, Point3::from(at)).then_in(Pose::rotation_z(radians(angle)))
        },
    )
}

/// Generates lines through a point within `reach_mm` of the origin along each coordinate. They start up to ten times as
/// far away.
pub fn rays(reach_mm: f64) -> impl Strategy<Value = Ray> {
    let near = -reach_mm..=reach_mm;
    (directions(), [near.clone(), near.clone(), near], -10.0f64..10.0, 0.1f64..10.0).prop_map(
        move |(direction, through, back, speed)| Ray {
            origin: Point3::from(through) + back * reach_mm * direction,
            direction: speed * direction,
        },
    )
}

/// Generates primitives of every kind but the half-space, 1 to 6 mm in size, in their own frames.
pub fn primitives() -> impl Strategy<Value = Solid> {
    let size = || 1.0f64..6.0;
    let thin = || 0.1f64..0.9;
    prop_oneof![
        size().prop_map(Solid::sphere),
        [size(), size(), size()].prop_map(Solid::ellipsoid),
        (size(), size()).prop_map(|(r, h)| Solid::cylinder(r, h)),
        (size(), size(), thin()).prop_map(|(r, h, top)| Solid::cone(r, r * top, h)),
        (size(), size()).prop_map(|(r, h)| Solid::cone(0.0, r, h)),
        (size(), size(), size()).prop_map(|(x, y, z)| Solid::cuboid(x, y, z)),
        (size(), thin()).prop_map(|(r, tube)| Solid::torus(r, r * tube)),
        (plates(), size()).prop_map(|(profile, h)| Solid::extrusion(profile, h)),
        meridians().prop_map(Solid::revolution),
        (size(), size(), -0.8f64..1.5).prop_map(|(equatorial, polar, depth)| {
            let (long, short) = (equatorial.max(polar), equatorial.min(polar));
            let inward_limit = short * short / long;
            let offset = if depth < 0.0 { depth * inward_limit } else { depth };
            Solid::ellipsoid_offset(equatorial, polar, offset)
        }),
    ]
}

/// Generates profiles for extrusions: stars, slots, ring sectors, rounded plates with a hole.
pub fn plates() -> impl Strategy<Value = Profile> {
    let size = || 2.0f64..6.0;
    prop_oneof![
        (3usize..9, size(), 0.3f64..0.9).prop_map(|(points, r, dent)| {
            let vertex = |i: usize| {
                let angle = std::f64::consts::PI * i as f64 / points as f64;
                let r = if i.is_multiple_of(2) { r } else { dent * r };
                [r * angle.cos(), r * angle.sin()]
            };
            Path::polygon(&(0..2 * points).map(vertex).collect::<Vec<_>>()).into()
        }),
        (size(), 0.2f64..2.0).prop_map(|(l, r)| Path::slot([-l, 0.3], [l, -0.2], r).into()),
        (size(), 0.2f64..0.9, 0.1f64..3.0).prop_map(|(r, inner, start)| {
            Path::ring_sector(inner * r, r, radians(start), radians(start + 4.0)).into()
        }),
        (size(), size(), 0.1f64..0.5, 0.2f64..0.6).prop_map(|(x, y, corner, hole)| {
            let plate = Path::rectangle([0.5, -0.5], [x, y], corner * x.min(y));
            Profile::new(plate).with_hole(Path::circle([0.5, -0.5], 0.5 * hole * x.min(y)))
        }),
    ]
}

/// Generates profiles for revolutions: bowls, lenses, rings with elliptic and off-axis arcs.
pub fn meridians() -> impl Strategy<Value = Profile> {
    let size = || 2.0f64..6.0;
    prop_oneof![
        // Shell of a dome: two spheres about the origin.
        (size(), 0.3f64..0.95).prop_map(|(r, inner)| {
            let i = inner * r;
            Path::from([i, 0.0])
                .line([r, 0.0])
                .arc([0.0, r], [0.0, 0.0], true)
                .line([0.0, i])
                .arc([i, 0.0], [0.0, 0.0], false)
                .into()
        }),
        // Goblet upside down: one off-axis arc that bulges inwards, and a slanted top.
        (size(), size(), 0.1f64..0.3).prop_map(|(r, h, waist)| {
            let depth = waist * r.min(h);
            let half = 0.5 * h;
            // A chord of the full height, sagging by `depth`.
            let radius = (half * half + depth * depth) / (2.0 * depth);
            Path::from([0.0, 0.0])
                .line([r, 0.0])
                .arc([r, h], [r - depth + radius, half], false)
                .line([0.0, 1.2 * h])
                .close()
                .into()
        }),
        // Half an ellipse off the axis, with a square hole.
        (size(), 0.2f64..0.9, 0.2f64..2.0).prop_map(|(r, a, b)| {
            let (a, b) = (a * r, b * r);
            let rim =
                Path::from([r + a, 0.0]).elliptic_arc([r - a, 0.0], [r, 0.0], [a, b], true).close();
            Profile::new(rim).with_hole(Path::rectangle([r, 0.3 * b], [0.5 * a, 0.2 * b], 0.0))
        }),
        // Lens: an ellipse on the axis below, and a circle whose centre lies beyond the axis above.
        (size(), 0.3f64..0.9, 0.1f64..0.6).prop_map(|(r, b, beyond)| {
            let centre = [-beyond * r, 0.0];
            let radius = r - centre[0];
            let top = (radius * radius - centre[0] * centre[0]).sqrt();
            Path::from([0.0, -b * r])
                .elliptic_arc([r, 0.0], [0.0, 0.0], [r, b * r], true)
                .arc([0.0, top], centre, true)
                .close()
                .into()
        }),
    ]
}

/// Generates bounded trees of placed primitives, about 30 mm across, up to three booleans deep.
pub fn trees() -> impl Strategy<Value = Solid> {
    let leaf = (primitives(), poses(4.0)).prop_map(|(solid, pose)| solid.placed(pose));
    leaf.prop_recursive(3, 12, 4, |inner| {
        let several = || prop::collection::vec(inner.clone(), 2..5);
        prop_oneof![
            several().prop_map(Solid::union),
            (inner.clone(), several()).prop_map(|(of, minus)| of.minus_all(minus)),
            (inner.clone(), inner.clone()).prop_map(|(a, b)| a.and(b)),
            // Half-spaces are unbounded by themselves; here they cut.
            (inner.clone(), directions(), -2.0f64..2.0).prop_map(|(of, outward, at)| {
                of.and(Solid::behind(Point3::from(at * outward), outward))
            }),
            (inner.clone(), poses(2.0)).prop_map(|(of, pose)| of.placed(pose)),
        ]
    })
}
