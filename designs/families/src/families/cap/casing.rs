//! Plate, holder and base.

use fabkit_geometry::{Angle, Body, CUT_OVERLAP_MM, Path, Pose, Process, Solid};

use super::bodies::*;
use super::joints::{Joints, casing_head_z};
use super::layout::Layout;
use super::parameters::Cap;
use crate::assembling::{flipped, in_sensor};
use crate::blocks::cable_way::{Side, wall_way};
use crate::blocks::{BLACK, GLASS, Rect, copies, marks, ring};
use crate::fits::Fit;
use crate::materials::glazing;

/// Depth and width of the groove beside the camera that the LEDs' wires go through, mm.
pub const WIRE_GROOVE_MM: [f64; 2] = [1.2, 8.0];

/// Distance of the plug's window from the floor and from the camera's seat, mm.
const WINDOW_MARGIN_MM: f64 = 1.0;

/// Widest upper edge of a window that every filament printer spans without supports, mm.
const LONGEST_BRIDGE_MM: f64 = 10.0;

/// Brim under a rounded rim, which touches the bed in a line, mm; chosen: as wide as the rim's edge is high.
const RIM_BRIM_MM: f64 = 5.0;

/// Poses on strips' backs: z axis towards the sensor's axis, y axis up.
pub fn led_poses(p: &Cap, layout: &Layout) -> Vec<Pose> {
    let degrees = |deg: f64| Angle::from_deg(deg).expect("finite");
    let inwards = Pose::translation(layout.strip_back_mm, 0.0, layout.led_z_mm)
        .then_in(Pose::rotation_z(degrees(-90.0)))
        .then_in(Pose::rotation_x(degrees(90.0)));
    // The first one stands on +y, over the middle of a side.
    let first = f64::from(p.leds.count) / 4.0;
    ring(p.leds.count, first, inwards)
}

/// The casing's outside seen along z.
pub fn outside(p: &Cap) -> Rect {
    Rect { half: [p.holder.width.mm() / 2.0; 2], corner: p.holder.corner.mm() }
}

/// Room for the camera's housing between two heights.
fn pocket(layout: &Layout, heights: [f64; 2]) -> Solid {
    let edge = 2.0 * layout.pocket_half_mm;
    let path = Path::rectangle([0.0; 2], [edge; 2], layout.pocket_corner_mm);
    Solid::prism(path, heights).named("camera pocket")
}

/// A groove beside the camera's housing, from the chamber to the room behind the camera.
fn wire_groove(layout: &Layout, [bottom_z, top_z]: [f64; 2]) -> Solid {
    let [depth, width] = WIRE_GROOVE_MM;
    let reach = layout.pocket_half_mm + depth;
    wall_way(Side::Right, width, [0.0, reach], [bottom_z, top_z]).named("wire groove")
}

/// The clear plate.
pub fn plate(p: &Cap, layout: &Layout) -> Body {
    let disc = Path::circle([0.0; 2], layout.plate_radius_mm);
    PLATE
        .made(
            Process::Laser,
            Solid::extrusion(disc, p.plate.thickness.mm()).at_z(layout.plate_bottom_z_mm),
        )
        .from(&p.plate.material)
        .in_light(glazing(&p.plate.material))
        .placed([in_sensor().lifted(24.0)])
        .colored(GLASS)
        .note("leave the protective film on until the skin is glued")
}

/// The casing's upper piece.
pub fn holder(p: &Cap, layout: &Layout) -> Body {
    let over = CUT_OVERLAP_MM;
    // One profile from the plate's recess down to the camera: ledge and chamber.
    let (recess, chamber) = (layout.recess_radius_mm, layout.chamber_radius_mm);
    let inside = Solid::revolution(Path::polygon(&[
        [0.0, layout.housing_front_z_mm],
        [chamber, layout.housing_front_z_mm],
        [chamber, layout.plate_bottom_z_mm],
        [recess, layout.plate_bottom_z_mm],
        [recess, over],
        [0.0, over],
    ]));
    // Strips are pushed in from above, before the plate is glued on.
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
            outside(p)
                .rimmed([layout.joint_z_mm, 0.0], p.holder.edge_fillet.mm())
                .minus(inside.named("chamber"))
                .minus(pocket(layout, [below, layout.housing_front_z_mm]))
                .minus(wire_groove(layout, [below, layout.housing_front_z_mm + over]))
                .minus_all(copies("led pocket", &leds, &led_pocket)),
        )
        .from(&p.holder.material)
        .placed([in_sensor()])
        .marked(marks("led", &leds))
        .colored(BLACK)
        .lying(flipped())
        .note("plate side down, no supports: the ledges overhang about 1 mm")
        .with_supports(false)
        .note("matt black filament; stray light blurs the shadows")
        .notes(is_round.then_some(
            "the rounded rim lies on the bed: print it on a brim and smooth its lowest layers",
        ))
        .on_brim(if is_round { RIM_BRIM_MM } else { 0.0 })
        // The chamber goes through; everything else is open to it or blind.
        .with_handles(1)
        .cut(Joints::new(p, layout).casing.held().unmarked())
}

/// The casing's lower piece.
pub fn base(p: &Cap, layout: &Layout) -> Body {
    let over = CUT_OVERLAP_MM;
    let (joints, head_z, bottom) =
        (Joints::new(p, layout), casing_head_z(layout), layout.bottom_z_mm);
    let heights =
        [layout.floor_z_mm + WINDOW_MARGIN_MM, layout.housing_back_z_mm - WINDOW_MARGIN_MM];
    let (width, reach) = (p.base.window_width.mm(), [0.0, p.holder.width.mm()]);
    let window = wall_way(p.base.cable_side, width, reach, heights);
    let plug_room =
        Solid::rod(layout.chamber_radius_mm, [layout.floor_z_mm, layout.housing_back_z_mm + over]);
    let gap = p.making.gap_mm(BASE, Process::Fdm, Fit::Snug);
    BASE.made(
        Process::Fdm,
        outside(p)
            .prism([bottom, layout.joint_z_mm])
            .minus(pocket(layout, [layout.housing_back_z_mm, layout.joint_z_mm + over]))
            .minus(plug_room.named("plug room"))
            .minus(wire_groove(layout, [layout.housing_back_z_mm - over, layout.joint_z_mm + over]))
            .minus(window.named("plug window")),
    )
    .from(&p.holder.material)
    .placed([in_sensor().lifted(-62.0)])
    .colored(BLACK)
    .note(match width <= LONGEST_BRIDGE_MM {
        true => "floor down, no supports: the window's upper edge is a short bridge".to_owned(),
        false => format!(
            "floor down, with supports in the window alone, whose upper edge spans {width:.0} mm; they \
             break out of it from inside and outside"
        ),
    })
    .with_supports(width > LONGEST_BRIDGE_MM)
    .note("the gripper's M3 screws cut their threads into the floor")
    .with_handles(1) // The plug's window.
    .cut(joints.casing.sunk(layout.joint_z_mm - head_z, head_z - bottom, gap).unmarked())
    .cut(joints.mounting.held_through())
}
