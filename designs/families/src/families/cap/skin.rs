//! The skin: a spherical cap of clear gel with dimples, and the reflective paint on it.
//!
//! Gel, paint and mold come from the same functions with the same numbers, so that they touch
//! without gap or overlap.

use fabkit_geometry::{
    Body, CUT_OVERLAP_MM, Carrier, DomeSurface, InvalidPattern, Mark, Path, Pattern, Pose, Solid,
};

use super::bodies::*;
use super::layout::Layout;
use super::parameters::{Cap, Direction};
use crate::assembling::in_sensor;
use crate::blocks::marks::RoundPattern;
use crate::blocks::{copies, sphere};

/// How many dimples there are: 1 + 6 + 12 + ..., or as many as are listed.
pub fn dimple_count(p: &Cap) -> usize {
    match p.dimples.pattern {
        RoundPattern::Rings => 1 + 3 * p.dimples.rings as usize * (p.dimples.rings as usize + 1),
        RoundPattern::List => p.dimples.listed().places().count(),
    }
}

/// Where the dimples meet the gel's surface: z axis along the outward normal, from the apex
/// outwards or as listed, sensor frame.
///
/// # Errors
/// Rings beyond the far pole of the sphere, which the constraints refuse.
pub fn dimple_poses(p: &Cap, layout: &Layout) -> Result<Vec<Pose>, InvalidPattern> {
    let surface = sphere(layout.sphere_radius_mm);
    let poses = match p.dimples.pattern {
        RoundPattern::Rings => Pattern::SurfaceRings {
            surface,
            spacing_mm: p.dimples.spacing.mm(),
            counts: (0..=p.dimples.rings).map(|k| if k == 0 { 1 } else { 6 * k }).collect(),
        }
        .poses()?,
        RoundPattern::List => p.dimples.listed().poses(&surface),
    };
    let sensor_from_sphere = Pose::translation(0.0, 0.0, layout.sphere_z_mm);
    Ok(poses.into_iter().map(|pose| sensor_from_sphere.then_in(pose)).collect())
}

/// The gel's cap, on z = 0; a tool goes on below its foot, with a straight wall so that the
/// spherical face stays the same.
fn cap(layout: &Layout, is_tool: bool) -> Solid {
    let radius_mm = layout.sphere_radius_mm;
    let foot = (radius_mm.powi(2) - layout.sphere_z_mm.powi(2)).sqrt();
    let path = if is_tool {
        Path::from([0.0, -CUT_OVERLAP_MM]).line([foot, -CUT_OVERLAP_MM]).line([foot, 0.0])
    } else {
        Path::from([0.0, 0.0]).line([foot, 0.0])
    };
    let (apex, centre) = ([0.0, layout.sphere_z_mm + radius_mm], [0.0, layout.sphere_z_mm]);
    Solid::revolution(path.arc(apex, centre, true).close())
}

/// A cylinder of `width_mm` with a hemispherical tip, from beyond the surface z = 0 to its tip at
/// `height_mm`.
fn pin(width_mm: f64, height_mm: f64, direction: Direction) -> Solid {
    let (radius, root) = (width_mm / 2.0, CUT_OVERLAP_MM);
    let shoulder = height_mm - radius;
    let path = match direction {
        Direction::IntoGel => Path::from([0.0, -height_mm])
            .arc([radius, -shoulder], [0.0, -shoulder], true)
            .line([radius, root])
            .line([0.0, root]),
        Direction::OutOfGel => Path::from([0.0, -root])
            .line([radius, -root])
            .line([radius, shoulder])
            .arc([0.0, height_mm], [0.0, shoulder], true),
    };
    Solid::revolution(path.close())
}

fn dimples(p: &Cap, poses: &[Pose], grown_mm: f64) -> Vec<Solid> {
    let width = p.dimples.width.mm() + 2.0 * grown_mm;
    let feature = pin(width, p.dimples.height.mm() + grown_mm, p.dimples.direction);
    copies("dimple", poses, &feature)
}

/// The dimples' ends, which the camera follows.
pub fn marks(p: &Cap, poses: &[Pose]) -> Vec<Mark> {
    let (radius_mm, height_mm) = (p.dimples.width.mm() / 2.0, p.dimples.height.mm());
    let depth_mm = match p.dimples.direction {
        Direction::IntoGel => height_mm,
        Direction::OutOfGel => -height_mm,
    };
    Mark::below("dimple", poses, depth_mm, radius_mm, |_| Carrier::Gel)
}

/// The gel with its dimples; as a tool it goes on below its foot.
pub fn gel(p: &Cap, layout: &Layout, poses: &[Pose], is_tool: bool) -> Solid {
    let cap = cap(layout, is_tool).named("dome");
    let dimples = dimples(p, poses, 0.0);
    match p.dimples.direction {
        Direction::IntoGel => cap.minus_all(dimples),
        Direction::OutOfGel => Solid::union(std::iter::once(cap).chain(dimples)),
    }
}

/// The paint: fills dimples in the gel, covers bumps on it.
fn paint(p: &Cap, layout: &Layout, touch: &DomeSurface, poses: &[Pose]) -> Solid {
    let thickness = p.paint.thickness.mm();
    let outside = touch.solid(0.0, touch.foot_z_mm).named("outside");
    let outside = match p.dimples.direction {
        Direction::IntoGel => outside,
        Direction::OutOfGel => {
            Solid::union(std::iter::once(outside).chain(dimples(p, poses, thickness)))
        }
    };
    outside.minus(gel(p, layout, poses, true))
}

/// Gel and paint, which ends in the surface that is touched.
pub fn layers(p: &Cap, layout: &Layout, touch: &DomeSurface, poses: &[Pose]) -> Vec<Body> {
    vec![
        Body::cast(
            SKIN,
            format!("clear gel with {} dimples", dimple_count(p)),
            gel(p, layout, poses, false),
        )
        .from(&p.skin.material)
        .placed([in_sensor().lifted(38.0), SKIN_MOLD.in_place()])
        .colored([190, 215, 235])
        .opaque(0.8), // Dimples are blind.
        Body::cast(
            PAINT,
            match p.dimples.direction {
                Direction::IntoGel => "reflects the coloured light; fills the dimples",
                Direction::OutOfGel => "reflects the coloured light; covers the dimples",
            },
            paint(p, layout, touch, poses),
        )
        .from(&p.paint.material)
        .placed([in_sensor().lifted(66.0)])
        .colored([205, 207, 212]),
    ]
}
