//! Casing parts (plate, holder and base), and the skin on them.

use fabkit_geometry::{
    Angle, Body, CUT_OVERLAP_MM, DomeSurface, InvalidPattern, Marker, MarkerCarrier, Path, Pattern,
    Pose, Process, Solid,
};

use super::parameters::*;
use super::{CapLayout, Joints, casing_head_z};
use crate::blocks::cable_openings::{HousingSide, wall_opening};
use crate::blocks::listed_markers::RoundPattern;
use crate::blocks::{BLACK, GLASS, Rect, copies, landmarks_at, ring, sphere};
use crate::chain_builder::{flipped, in_sensor};
use crate::fits::Fit;
use crate::materials::window_transparency;

// ------ Casing ------
//
// Plate, holder and base.

/// Depth and width, mm, of the groove beside the camera for the LEDs' wires.
pub const WIRE_GROOVE_MM: [f64; 2] = [1.2, 8.0];

/// Distance of the plug's window from the floor and from the camera's seat, mm.
const WINDOW_MARGIN_MM: f64 = 1.0;

/// Longest upper edge of a window that every filament printer bridges without supports, mm.
const LONGEST_BRIDGE_MM: f64 = 10.0;

/// Width of the brim under a rounded rim, which touches the bed only in a line, mm. Chosen value: the height of the
/// rim's edge.
const RIM_BRIM_MM: f64 = 5.0;

/// Poses on the backs of the LED strips: z axis towards the sensor's axis, y axis up.
pub fn led_poses(p: &Cap, layout: &CapLayout) -> Vec<Pose> {
    let degrees = |deg: f64| Angle::from_deg(deg).expect("finite");
    let inwards = Pose::translation(layout.strip_back_mm, 0.0, layout.led_z_mm)
        .then_in(Pose::rotation_z(degrees(-90.0)))
        .then_in(Pose::rotation_x(degrees(90.0)));
    // The first LED stands on +y, in the middle of a side.
    let first = f64::from(p.leds.count) / 4.0;
    ring(p.leds.count, first, inwards)
}

/// Outline of the casing seen along z.
pub fn casing_outline(p: &Cap) -> Rect {
    Rect { half: [p.holder.width.mm() / 2.0; 2], corner: p.holder.corner.mm() }
}

/// Returns the pocket for the camera's housing between two heights.
fn pocket(layout: &CapLayout, heights: [f64; 2]) -> Solid {
    let edge = 2.0 * layout.pocket_half_mm;
    let path = Path::rectangle([0.0; 2], [edge; 2], layout.pocket_corner_mm);
    Solid::prism(path, heights).named("camera pocket")
}

/// Returns the groove beside the camera's housing, from the chamber to the room behind the camera.
fn wire_groove(layout: &CapLayout, [bottom_z, top_z]: [f64; 2]) -> Solid {
    let [depth, width] = WIRE_GROOVE_MM;
    let reach = layout.pocket_half_mm + depth;
    wall_opening(HousingSide::Right, width, [0.0, reach], [bottom_z, top_z]).named("wire groove")
}

/// Returns the clear plate.
pub fn plate(p: &Cap, layout: &CapLayout) -> Body {
    let disc = Path::circle([0.0; 2], layout.plate_radius_mm);
    PLATE
        .made(
            Process::Laser,
            Solid::extrusion(disc, p.plate.thickness.mm()).at_z(layout.plate_bottom_z_mm),
        )
        .with_material(&p.plate.material)
        .as_window(window_transparency(&p.plate.material))
        .placed([in_sensor().lifted(24.0)])
        .colored(GLASS)
        .note("leave the protective film on until the skin is glued")
}

/// Returns the upper part of the casing.
pub fn holder(p: &Cap, layout: &CapLayout) -> Body {
    let over = CUT_OVERLAP_MM;
    // One profile for the plate's recess, the ledge and the chamber, down to the camera.
    let (recess, chamber) = (layout.recess_radius_mm, layout.chamber_radius_mm);
    let inside = Solid::revolution(Path::polygon(&[
        [0.0, layout.housing_front_z_mm],
        [chamber, layout.housing_front_z_mm],
        [chamber, layout.plate_bottom_z_mm],
        [recess, layout.plate_bottom_z_mm],
        [recess, over],
        [0.0, over],
    ]));
    // The strips are pushed in from above before the plate is glued on, so their pockets are open upwards.
    let slack = p.making.gap_mm(HOLDER, Process::Fdm, Fit::Slide);
    let depth = layout.strip_back_mm - layout.led_front_mm;
    let pocket_height = p.leds.strip_width.mm() + p.leds.below_plate.mm() + over;
    let led_pocket = Solid::cuboid(p.leds.strip_length.mm() + 2.0 * slack, pocket_height, depth)
        .at(0.0, (pocket_height - p.leds.strip_width.mm()) / 2.0, 0.0);
    let leds = led_poses(p, layout);
    let below = layout.joint_z_mm - over;
    let is_round = p.holder.edge_fillet.mm() > 0.0;
    HOLDER
        .made(
            Process::Fdm,
            casing_outline(p)
                .rimmed([layout.joint_z_mm, 0.0], p.holder.edge_fillet.mm())
                .minus(inside.named("chamber"))
                .minus(pocket(layout, [below, layout.housing_front_z_mm]))
                .minus(wire_groove(layout, [below, layout.housing_front_z_mm + over]))
                .minus_all(copies("led pocket", &leds, &led_pocket)),
        )
        .with_material(&p.holder.material)
        .placed([in_sensor()])
        .with_landmarks(landmarks_at("led", &leds))
        .colored(BLACK)
        .with_bed_orientation(flipped())
        .note("plate side down, no supports: the ledges overhang about 1 mm")
        .with_supports(false)
        .note("matt black filament; stray light blurs the shadows")
        .notes(is_round.then_some(
            "the rounded rim lies on the bed: print it on a brim and smooth its lowest layers",
        ))
        .on_brim(if is_round { RIM_BRIM_MM } else { 0.0 })
        // The chamber goes through. All other openings are blind or lead into it.
        .with_handles(1)
        .cut(Joints::new(p, layout).casing.thread_cut().without_landmarks())
}

/// Returns the lower part of the casing.
pub fn base(p: &Cap, layout: &CapLayout) -> Body {
    let over = CUT_OVERLAP_MM;
    let (joints, head_z, bottom) =
        (Joints::new(p, layout), casing_head_z(layout), layout.bottom_z_mm);
    let heights =
        [layout.floor_z_mm + WINDOW_MARGIN_MM, layout.housing_back_z_mm - WINDOW_MARGIN_MM];
    let (width, reach) = (p.base.window_width.mm(), [0.0, p.holder.width.mm()]);
    let window = wall_opening(p.base.cable_side, width, reach, heights);
    let plug_room =
        Solid::rod(layout.chamber_radius_mm, [layout.floor_z_mm, layout.housing_back_z_mm + over]);
    let gap = p.making.gap_mm(BASE, Process::Fdm, Fit::Snug);
    let printing_note = if width <= LONGEST_BRIDGE_MM {
        "floor down, no supports: the window's upper edge is a short bridge".to_owned()
    } else {
        format!(
            "floor down, with supports in the window alone, whose upper edge spans {width:.0} mm; they \
             break out of it from inside and outside"
        )
    };
    BASE.made(
        Process::Fdm,
        casing_outline(p)
            .prism([bottom, layout.joint_z_mm])
            .minus(pocket(layout, [layout.housing_back_z_mm, layout.joint_z_mm + over]))
            .minus(plug_room.named("plug room"))
            .minus(wire_groove(layout, [layout.housing_back_z_mm - over, layout.joint_z_mm + over]))
            .minus(window.named("plug window")),
    )
    .with_material(&p.holder.material)
    .placed([in_sensor().lifted(-62.0)])
    .colored(BLACK)
    .note(printing_note)
    .with_supports(width > LONGEST_BRIDGE_MM)
    .note("the gripper's M3 screws cut their threads into the floor")
    .with_handles(1) // The plug's window.
    .cut(
        joints
            .casing
            .counterbore_cut(layout.joint_z_mm - head_z, head_z - bottom, gap)
            .without_landmarks(),
    )
    .cut(joints.mounting.thread_cut_through())
}

// ------ Skin ------
//
// Skin: a spherical cap of clear gel with dimples, and the reflective paint on it.
//
// Gel, paint and mold are made by the same functions from the same numbers, so that they touch without gap or
// overlap.

/// Number of dimples: 1 + 6 + 12 + ... in rings, or as many as are listed.
pub fn dimple_count(p: &Cap) -> usize {
    match p.dimples.pattern {
        RoundPattern::Rings => 1 + 3 * p.dimples.rings as usize * (p.dimples.rings as usize + 1),
        RoundPattern::List => p.dimples.listed().places().count(),
    }
}

/// Poses of the dimples on the gel's surface in the sensor frame, z axis along the outward normal. Rings are ordered
/// from the apex outwards.
///
/// # Errors
/// Fails if rings lie beyond the far pole of the sphere, which the constraints refuse.
pub fn dimple_poses(p: &Cap, layout: &CapLayout) -> Result<Vec<Pose>, InvalidPattern> {
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

/// Returns the gel's cap on z = 0. As a tool it extends below its foot with a straight wall, so that the spherical
/// face stays the same.
fn cap(layout: &CapLayout, is_tool: bool) -> Solid {
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

/// Returns a cylinder of `width_mm` with a hemispherical tip. It starts beyond the surface z = 0, inside or outside
/// of the gel, and its tip is `height_mm` away from the surface.
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

/// Returns the solids of all dimples, offset outwards by `grown_mm`.
fn dimples(p: &Cap, poses: &[Pose], grown_mm: f64) -> Vec<Solid> {
    let width = p.dimples.width.mm() + 2.0 * grown_mm;
    let feature = pin(width, p.dimples.height.mm() + grown_mm, p.dimples.direction);
    copies("dimple", poses, &feature)
}

/// Returns the ends of the dimples, which are the markers that the camera tracks.
pub fn dimple_marks(p: &Cap, poses: &[Pose]) -> Vec<Marker> {
    let (radius_mm, height_mm) = (p.dimples.width.mm() / 2.0, p.dimples.height.mm());
    let depth_mm = match p.dimples.direction {
        Direction::IntoGel => height_mm,
        Direction::OutOfGel => -height_mm,
    };
    Marker::place_below_poses("dimple", poses, depth_mm, radius_mm, |_| MarkerCarrier::Gel)
}

/// Returns the gel with its dimples. As a tool it extends below its foot.
pub fn gel(p: &Cap, layout: &CapLayout, poses: &[Pose], is_tool: bool) -> Solid {
    let cap = cap(layout, is_tool).named("dome");
    let dimples = dimples(p, poses, 0.0);
    match p.dimples.direction {
        Direction::IntoGel => cap.minus_all(dimples),
        Direction::OutOfGel => Solid::union(std::iter::once(cap).chain(dimples)),
    }
}

/// Returns the paint, which fills dimples in the gel or covers bumps on it.
fn paint(p: &Cap, layout: &CapLayout, touch: &DomeSurface, poses: &[Pose]) -> Solid {
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

/// Returns gel and paint. The paint's outside is the touched surface.
pub fn layers(p: &Cap, layout: &CapLayout, touch: &DomeSurface, poses: &[Pose]) -> Vec<Body> {
    vec![
        Body::cast(
            SKIN,
            format!("clear gel with {} dimples", dimple_count(p)),
            gel(p, layout, poses, false),
        )
        .with_material(&p.skin.material)
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
        .with_material(&p.paint.material)
        .placed([in_sensor().lifted(66.0)])
        .colored([205, 207, 212]),
    ]
}
