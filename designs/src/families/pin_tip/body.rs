//! Body, LED board and robot mount.

use std::f64::consts::TAU;

use fabkit_geometry::{
    Angle, Body, CUT_OVERLAP_MM, Color, Landmark, Path, Point3, Pose, Process, Profile, Solid,
    Vector3,
};

use super::in_sensor;
use super::layout::Layout;
use super::parameters::PinTip;
use crate::hardware::{Head, Screw, SocketScrew};

/// Holds the camera board.
pub const BOARD_SCREW: Screw = Screw { thread_mm: 3.0, length_mm: 6.0, head: Head::Pan };

/// Holds the mount to the robot's flange.
pub const BOLT: SocketScrew = SocketScrew::M5;

/// Below the tip of a board screw, for chips, mm.
const PILOT_SPARE_MM: f64 = 1.5;

const ABS_GREY: Color = [104, 110, 120];
const MOUNT_GREY: Color = [150, 156, 164];
const MASK_GREEN: Color = [40, 120, 70];

/// `index` out of `count` around the axis, from `offset` steps.
pub fn turn(index: u32, count: u32, offset: f64) -> Angle {
    let rad = TAU * (f64::from(index) + offset) / f64::from(count);
    Angle::from_rad(rad).expect("a fraction of a turn is finite")
}

/// Where the camera board's screws stand: z axis down and out, origin where the heads bear.
pub fn board_screw_poses(p: &PinTip, layout: &Layout) -> Vec<Pose> {
    let half = p.camera.screw_spacing.mm() / 2.0;
    [[half, half], [-half, half], [-half, -half], [half, -half]]
        .map(|[x, y]| Pose::z_to(-Vector3::z(), Point3::new(x, y, layout.camera_board_bottom_z)))
        .to_vec()
}

/// Depth of the board screws' holes in the posts, mm.
pub fn pilot_depth_mm(p: &PinTip) -> f64 {
    BOARD_SCREW.length_mm - p.camera.board_thickness.mm() + PILOT_SPARE_MM
}

/// The pose of LED `index` on its board, z axis up, x axis outwards.
pub fn led_pose(p: &PinTip, layout: &Layout, index: u32) -> Pose {
    Pose::rotation_z(turn(index, p.leds.count, 0.0)).then_in(Pose::translation(
        p.leds.circle_radius.mm(),
        0.0,
        layout.board_top_z,
    ))
}

/// Where the bolts into the robot's flange stand: z axis up, origin where the heads bear.
pub fn bolt_poses(p: &PinTip, layout: &Layout) -> Vec<Pose> {
    let radius = p.mount.bolt_circle.mm() / 2.0;
    (0..p.mount.bolts)
        .map(|i| {
            Pose::rotation_z(turn(i, p.mount.bolts, 0.5)).then_in(Pose::translation(
                radius,
                0.0,
                layout.plate_top_z,
            ))
        })
        .collect()
}

/// Spigot, shaft, cone and housing in one print.
pub fn body(p: &PinTip, layout: &Layout) -> Body {
    let (tip, mount) = (&layout.tip_joint, &layout.mount_joint);
    let bottom = layout.body_bottom_z;
    let outside = Solid::revolution(Path::polygon(&[
        [0.0, layout.neck_top_z],
        [layout.neck_radius, layout.neck_top_z],
        [layout.neck_radius, layout.seal_z],
        [tip.spigot_radius, layout.seal_z],
        [tip.spigot_radius, layout.shoulder_z],
        [layout.shaft_radius, layout.shoulder_z],
        [layout.shaft_radius, layout.shaft_bottom_z],
        [mount.outer_radius, layout.cone_bottom_z],
        [mount.outer_radius, bottom],
        [0.0, bottom],
    ]));
    let above = layout.neck_top_z + CUT_OVERLAP_MM;
    let below = bottom - CUT_OVERLAP_MM;
    let cavity = Solid::revolution(Path::polygon(&[
        [0.0, above],
        [layout.board_seat_radius, above],
        [layout.board_seat_radius, layout.board_bottom_z],
        [layout.shaft_bore_radius, layout.board_bottom_z],
        [layout.shaft_bore_radius, layout.bore_bottom_z],
        [mount.bore_radius, layout.cavity_top_z],
        [mount.bore_radius, below],
        [0.0, below],
    ]))
    .named("cavity");
    // What the cavity spares stays: posts that grow out of the cone, whatever its slope.
    let screws = board_screw_poses(p, layout);
    let posts = screws.iter().enumerate().map(|(i, pose)| {
        let at = pose.translation_mm();
        Solid::cylinder(
            p.body.post_diameter.mm() / 2.0,
            layout.shaft_bottom_z - layout.camera_board_top_z,
        )
        .at(at.x, at.y, layout.camera_board_top_z)
        .named(format!("post {}", i + 1))
    });
    let pilots = screws.iter().enumerate().map(|(i, pose)| {
        BOARD_SCREW
            .pilot_tool(p.camera.board_thickness.mm() + pilot_depth_mm(p))
            .placed(*pose)
            .named(format!("camera screw hole {}", i + 1))
    });
    let slot = cable_slot(p, layout);
    let mouth = Pose::translation(0.0, 0.0, bottom);
    let grooves = mount.female_tools().into_iter().map(|tool| tool.placed(mouth));
    let lugs = tip.male().at(0.0, 0.0, layout.ring_bottom_z);
    let board =
        screws.iter().enumerate().map(|(i, s)| Landmark::at(format!("camera screw {}", i + 1), s));
    Body::made(
        "body",
        "shaft between tip and camera; locks the tip, houses LEDs and camera",
        Process::Fdm,
        outside
            .plus(lugs)
            .minus(cavity.minus_all(posts))
            .minus_all(pilots)
            .minus_all(grooves)
            .minus(slot),
    )
    .from(&p.body.material)
    .placed([in_sensor().lifted(-30.0)])
    .marked(board)
    .colored(ABS_GREY)
    // The spigot down: cone, posts and both bayonets then print without support.
    .lying(Pose::rotation_x(Angle::from_deg(180.0).expect("finite")))
    .note("print with the spigot down, without support")
    .note("paint the shaft's inside matt black if the filament is bright")
    // The bore for the light, and the slot for the cable.
    .with_handles(2)
}

/// The passage for the cable, between camera board and mount.
fn cable_slot(p: &PinTip, layout: &Layout) -> Solid {
    let (bore, outer) = (layout.mount_joint.bore_radius, layout.mount_joint.outer_radius);
    let width = p.body.cable_slot_width.mm();
    let height = p.body.wiring_room.mm() / 2.0;
    // From well inside the wall, whose inner face curves away, to beyond its outside.
    let inner = bore - width / 2.0;
    let length = outer + CUT_OVERLAP_MM - inner;
    let middle = layout.camera_board_bottom_z - p.body.wiring_room.mm() / 2.0;
    Solid::cuboid(length, width, height)
        .at(inner + length / 2.0, 0.0, middle - height / 2.0)
        .named("cable slot")
}

/// The annular board.
pub fn led_board(p: &PinTip, layout: &Layout) -> Body {
    let outline = Profile::new(Path::circle([0.0, 0.0], layout.board_radius))
        .with_hole(Path::circle([0.0, 0.0], p.led_board.bore_radius.mm()));
    let leds =
        (0..p.leds.count).map(|i| Landmark::at(format!("led {}", i + 1), &led_pose(p, layout, i)));
    Body::made(
        "led-board",
        "annular circuit board that carries the LEDs",
        Process::Pcb,
        Solid::extrusion(outline, p.led_board.thickness.mm()).at(0.0, 0.0, layout.board_bottom_z),
    )
    .from(&p.led_board.material)
    .placed([in_sensor().lifted(-12.0)])
    .marked(leds)
    .colored(MASK_GREEN)
    .note("solder the wires to the lower side, inside the ledge, and lead them down the shaft")
    .note("press it in from above until it meets the ledge")
    .with_handles(1)
}

/// The flange that the body locks onto.
pub fn mount(p: &PinTip, layout: &Layout) -> Body {
    let joint = &layout.mount_joint;
    let inner = joint.spigot_radius - p.mount.spigot_wall.mm();
    let top = layout.body_bottom_z + p.mount.spigot_height.mm();
    let outside = Solid::revolution(Path::polygon(&[
        [0.0, layout.plate_bottom_z],
        [joint.outer_radius, layout.plate_bottom_z],
        [joint.outer_radius, layout.plate_top_z],
        [joint.spigot_radius, layout.plate_top_z],
        [joint.spigot_radius, top],
        [inner, top],
        [inner, layout.plate_top_z],
        [0.0, layout.plate_top_z],
    ]));
    let holes = bolt_poses(p, layout).into_iter().enumerate().map(|(i, pose)| {
        let depth = p.mount.plate.mm() + CUT_OVERLAP_MM;
        Solid::cylinder(BOLT.clearance_hole_mm / 2.0, depth + CUT_OVERLAP_MM)
            .at(0.0, 0.0, -depth)
            .placed(pose)
            .named(format!("bolt hole {}", i + 1))
    });
    let bolts = bolt_poses(p, layout);
    let bolts =
        bolts.iter().enumerate().map(|(i, pose)| Landmark::at(format!("bolt {}", i + 1), pose));
    Body::made(
        "robot-mount",
        "flange that is bolted to the robot; the body locks onto it",
        Process::Fdm,
        outside.plus(joint.male().at(0.0, 0.0, layout.body_bottom_z)).minus_all(holes),
    )
    .from(&p.body.material)
    .placed([in_sensor().lifted(-112.0)])
    .marked(bolts)
    .colored(MOUNT_GREY)
    .note("print on its plate; the lugs stand out far enough to print freely")
    .with_handles(p.mount.bolts as i32)
}
