//! Body, LED board and robot mount.

use fabkit_geometry::{Body, CUT_OVERLAP_MM, Color, Path, Pose, Process, Profile, Solid};

use super::bodies::*;
use super::joints::Joints;
use super::layout::Layout;
use super::parameters::PinTip;
use crate::assembling::{flipped, in_sensor};
use crate::blocks::cable_way::{Side, wall_way};
use crate::blocks::{MASK_GREEN, edge, holes, led_ring, marks};

const ABS_GREY: Color = [104, 110, 120];
const MOUNT_GREY: Color = [150, 156, 164];

/// The LEDs on their board, z axis up, x axis outwards.
pub fn led_poses(p: &PinTip, layout: &Layout) -> Vec<Pose> {
    led_ring!(p.leds).poses(layout.board_top_z_mm, 0.0)
}

/// Spigot, shaft, cone and housing in one print.
pub fn body(p: &PinTip, layout: &Layout) -> Body {
    let (tip, mount) = (&layout.tip_joint, &layout.mount_joint);
    let bottom = layout.body_bottom_z_mm;
    let fillet = p.body.edge_fillet.mm();
    let outside = Solid::revolution(edge::rounded(&[
        ([0.0, layout.neck_top_z_mm], 0.0),
        ([layout.neck_radius_mm, layout.neck_top_z_mm], 0.0),
        ([layout.neck_radius_mm, layout.seal_z_mm], 0.0),
        ([tip.spigot_radius, layout.seal_z_mm], 0.0),
        ([tip.spigot_radius, layout.shoulder_z_mm], 0.0),
        ([layout.shaft_radius_mm, layout.shoulder_z_mm], 0.0),
        ([layout.shaft_radius_mm, layout.shaft_bottom_z_mm], 0.0),
        ([mount.outer_radius, layout.cone_bottom_z_mm], fillet),
        ([mount.outer_radius, bottom], fillet),
        ([0.0, bottom], 0.0),
    ]));
    let above = layout.neck_top_z_mm + CUT_OVERLAP_MM;
    let below = bottom - CUT_OVERLAP_MM;
    let cavity = Solid::revolution(Path::polygon(&[
        [0.0, above],
        [layout.board_seat_radius_mm, above],
        [layout.board_seat_radius_mm, layout.board_bottom_z_mm],
        [layout.shaft_bore_radius_mm, layout.board_bottom_z_mm],
        [layout.shaft_bore_radius_mm, layout.bore_bottom_z_mm],
        [mount.bore_radius, layout.cavity_top_z_mm],
        [mount.bore_radius, below],
        [0.0, below],
    ]))
    .named("cavity");
    // What the cavity spares stays: posts that grow out of the cone, whatever its slope.
    let screws = Joints::new(p, layout).camera;
    let post = Solid::cylinder(
        p.body.post_diameter.mm() / 2.0,
        layout.shaft_bottom_z_mm - layout.camera_board_top_z_mm,
    );
    let posts = screws.poses.iter().zip(1..).map(|(pose, i)| {
        let at = pose.translation_mm();
        post.clone().at(at.x, at.y, layout.camera_board_top_z_mm).named(format!("post {i}"))
    });
    let lugs = tip.male().at_z(layout.ring_bottom_z_mm);
    BODY.made(Process::Fdm, outside.plus(lugs).minus(cavity.minus_all(posts)))
        .from(&p.body.material)
        .placed([in_sensor().lifted(-30.0)])
        .colored(ABS_GREY)
        // The spigot down: cone, posts and both bayonets then print without support.
        .lying(flipped())
        .note("print with the spigot down, without support")
        .with_supports(false)
        .note(
            "a tall part on a narrow ring: print it on a brim 8 mm wide, slowly where it is narrow, \
             and trim the brim off the spigot's edge",
        )
        .on_brim(8.0)
        .note("paint the shaft's inside matt black if the filament is bright")
        // The bore for the light, and the slot for the cable.
        .with_handles(2)
        .cut(screws.held())
        .cut(holes(mount.female_tools(bottom)))
        .cut(holes([cable_slot(p, layout)]))
}

/// The passage for the cable, between camera board and mount.
fn cable_slot(p: &PinTip, layout: &Layout) -> Solid {
    let (bore, outer) = (layout.mount_joint.bore_radius, layout.mount_joint.outer_radius);
    let width = p.body.cable_slot_width.mm();
    let height = p.body.wiring_room.mm() / 2.0;
    // From well inside the wall, whose inner face curves away, to beyond its outside.
    let inner = bore - width / 2.0;
    let bottom = layout.camera_board_bottom_z_mm - p.body.wiring_room.mm() / 2.0 - height / 2.0;
    let reach = [inner, outer + CUT_OVERLAP_MM];
    let slot = wall_way(Side::Right, width, reach, [bottom, bottom + height]).named("cable slot");
    if p.body.cable_angle.rad() == 0.0 { slot } else { slot.turned_z(p.body.cable_angle) }
}

/// The annular board.
pub fn led_board(p: &PinTip, layout: &Layout) -> Body {
    let outline = Profile::new(Path::circle([0.0, 0.0], layout.board_radius_mm))
        .with_hole(Path::circle([0.0, 0.0], p.led_board.bore_radius.mm()));
    LED_BOARD
        .made(
            Process::Pcb,
            Solid::extrusion(outline, p.led_board.thickness.mm()).at_z(layout.board_bottom_z_mm),
        )
        .from(&p.led_board.material)
        .placed([in_sensor().lifted(-12.0)])
        .marked(marks("led", &led_poses(p, layout)))
        .colored(MASK_GREEN)
        .note("solder the wires to the lower side, inside the ledge, and lead them down the shaft")
        .note("press it in from above until it meets the ledge")
        .with_handles(1)
}

/// The flange that the body locks onto.
pub fn mount(p: &PinTip, layout: &Layout) -> Body {
    let joint = &layout.mount_joint;
    let inner = joint.spigot_radius - p.mount.spigot_wall.mm();
    let top = layout.body_bottom_z_mm + p.mount.spigot_height.mm();
    let outside = Solid::revolution(Path::polygon(&[
        [0.0, layout.plate_bottom_z_mm],
        [joint.outer_radius, layout.plate_bottom_z_mm],
        [joint.outer_radius, layout.plate_top_z_mm],
        [joint.spigot_radius, layout.plate_top_z_mm],
        [joint.spigot_radius, top],
        [inner, top],
        [inner, layout.plate_top_z_mm],
        [0.0, layout.plate_top_z_mm],
    ]));
    ROBOT_MOUNT
        .made(Process::Fdm, outside.plus(joint.male().at_z(layout.body_bottom_z_mm)))
        .from(&p.body.material)
        .placed([in_sensor().lifted(-112.0)])
        .colored(MOUNT_GREY)
        .note("print on its plate; the lugs stand out far enough to print freely")
        .cut(Joints::new(p, layout).robot.passed())
}
