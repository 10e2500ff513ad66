//! Plate, holder and base.

use std::f64::consts::TAU;

use fabkit_geometry::{
    Angle, Body, CUT_OVERLAP_MM, Landmark, Path, Point3, Pose, Process, Solid, Vector3,
};

use super::layout::Layout;
use super::parameters::Cap;
use super::{BLACK, flipped, in_sensor};
use crate::fits::{Fit, gap_mm};
use crate::hardware::Screw;

/// The screw that joins holder and base.
pub const JOINT_SCREW: Screw = Screw::M2X16;

/// How far a joint's screw bites into the holder, mm: two and a half times its diameter.
pub const JOINT_BITE_MM: f64 = 5.0;

/// Depth of a screw's hole beyond its tip, mm.
const PILOT_SPARE_MM: f64 = 1.0;

/// Depth and width of the groove beside the camera that the LEDs' wires go through, mm.
pub const WIRE_GROOVE_MM: [f64; 2] = [1.2, 8.0];

/// Distance of the plug's window from the floor and from the camera's seat, mm.
const WINDOW_MARGIN_MM: f64 = 1.0;

/// `index` out of `count` around the axis, from `offset` steps.
pub fn turn(index: u32, count: u32, offset: f64) -> Angle {
    let rad = TAU * (f64::from(index) + offset) / f64::from(count);
    Angle::from_rad(rad).expect("a fraction of a turn is finite")
}

/// Poses on strips' backs: z axis towards the sensor's axis, y axis up.
pub fn led_poses(p: &Cap, layout: &Layout) -> Vec<Pose> {
    let degrees = |deg: f64| Angle::from_deg(deg).expect("finite");
    let inwards = Pose::translation(layout.strip_back, 0.0, layout.led_z)
        .then_in(Pose::rotation_z(degrees(-90.0)))
        .then_in(Pose::rotation_x(degrees(90.0)));
    // The first one stands on +y, over the middle of a side.
    let first = f64::from(p.leds.count) / 4.0;
    (0..p.leds.count)
        .map(|i| Pose::rotation_z(turn(i, p.leds.count, first)).then_in(inwards))
        .collect()
}

/// Where the heads of the screws that join holder and base bear: z axis down, out of the base.
pub fn joint_poses(p: &Cap, layout: &Layout) -> Vec<Pose> {
    let half = p.holder.screw_spacing.mm() / 2.0;
    let z = joint_head_z(layout);
    [[half, half], [-half, half], [-half, -half], [half, -half]]
        .map(|[x, y]| Pose::z_to(-Vector3::z(), Point3::new(x, y, z)))
        .to_vec()
}

/// Height at which the joint's heads bear.
pub fn joint_head_z(layout: &Layout) -> f64 {
    layout.joint_z + JOINT_BITE_MM - JOINT_SCREW.length_mm
}

/// Holes for the gripper's screws: z axis down, origin on the base's bottom.
pub fn mount_poses(p: &Cap, layout: &Layout) -> Vec<Pose> {
    let down =
        Pose::z_to(-Vector3::z(), Point3::new(p.base.mount_radius.mm(), 0.0, layout.bottom_z));
    (0..p.base.mount_holes)
        .map(|i| Pose::rotation_z(turn(i, p.base.mount_holes, 0.0)).then_in(down))
        .collect()
}

/// A square prism of the casing between two heights.
fn outline(p: &Cap, bottom_z: f64, top_z: f64) -> Solid {
    let width = p.holder.width.mm();
    let path = Path::rectangle([0.0; 2], [width; 2], p.holder.corner.mm());
    Solid::extrusion(path, top_z - bottom_z).at(0.0, 0.0, bottom_z)
}

/// Room for the camera's housing between two heights.
fn pocket(layout: &Layout, bottom_z: f64, top_z: f64) -> Solid {
    let edge = 2.0 * layout.pocket_half;
    let path = Path::rectangle([0.0; 2], [edge; 2], layout.pocket_corner);
    Solid::extrusion(path, top_z - bottom_z).at(0.0, 0.0, bottom_z)
}

/// A groove beside the camera's housing, from the chamber to the room behind the camera.
fn wire_groove(layout: &Layout, bottom_z: f64, top_z: f64) -> Solid {
    let [depth, width] = WIRE_GROOVE_MM;
    let reach = layout.pocket_half + depth;
    Solid::cuboid_between([0.0, -width / 2.0, bottom_z], [reach, width / 2.0, top_z])
        .named("wire groove")
}

fn bore(radius: f64, bottom_z: f64, top_z: f64) -> Solid {
    Solid::cylinder(radius, top_z - bottom_z).at(0.0, 0.0, bottom_z)
}

/// The clear plate.
pub fn plate(p: &Cap, layout: &Layout) -> Body {
    Body::made(
        "plate",
        "clear plate that carries the skin",
        Process::Laser,
        Solid::extrusion(Path::circle([0.0; 2], layout.plate_radius), p.plate.thickness.mm()).at(
            0.0,
            0.0,
            layout.plate_bottom_z,
        ),
    )
    .from(&p.plate.material)
    .placed([in_sensor().lifted(24.0)])
    .colored([190, 215, 225])
    .note("leave the protective film on until the skin is glued")
}

/// The casing's upper piece.
pub fn holder(p: &Cap, layout: &Layout) -> Body {
    let over = CUT_OVERLAP_MM;
    // One profile from the plate's recess down to the camera: ledge and chamber.
    let (recess, chamber) = (layout.recess_radius, layout.chamber_radius);
    let inside = Solid::revolution(Path::polygon(&[
        [0.0, layout.housing_front_z],
        [chamber, layout.housing_front_z],
        [chamber, layout.plate_bottom_z],
        [recess, layout.plate_bottom_z],
        [recess, over],
        [0.0, over],
    ]));
    // Strips are pushed in from above, before the plate is glued on.
    let slack = gap_mm(Process::Fdm, Fit::Slide);
    let depth = layout.strip_back - layout.led_front;
    let pocket_height = p.leds.strip_width.mm() + p.leds.below_plate.mm() + over;
    let led_pocket = Solid::cuboid(p.leds.strip_length.mm() + 2.0 * slack, pocket_height, depth)
        .at(0.0, (pocket_height - p.leds.strip_width.mm()) / 2.0, 0.0);
    let leds = led_poses(p, layout);
    let led_pockets = leds
        .iter()
        .enumerate()
        .map(|(i, pose)| led_pocket.clone().placed(*pose).named(format!("led pocket {}", i + 1)));
    let joint = joint_poses(p, layout);
    let pilots = joint.iter().enumerate().map(|(i, pose)| {
        let depth = JOINT_SCREW.length_mm + PILOT_SPARE_MM;
        JOINT_SCREW.pilot_tool(depth).placed(*pose).named(format!("screw hole {}", i + 1))
    });
    Body::made(
        "holder",
        "casing's upper piece: holds plate, LEDs and the camera's front",
        Process::Fdm,
        outline(p, layout.joint_z, 0.0)
            .minus(inside.named("chamber"))
            .minus(
                pocket(layout, layout.joint_z - over, layout.housing_front_z)
                    .named("camera pocket"),
            )
            .minus(wire_groove(layout, layout.joint_z - over, layout.housing_front_z + over))
            .minus_all(led_pockets)
            .minus_all(pilots),
    )
    .from(&p.holder.material)
    .placed([in_sensor()])
    .marked(leds.iter().enumerate().map(|(i, pose)| Landmark::at(format!("led {}", i + 1), pose)))
    .colored(BLACK)
    .lying(flipped())
    .note("plate side down, no supports: the ledges overhang about 1 mm")
    .note("matt black filament; stray light blurs the shadows")
    // The chamber goes through; everything else is open to it or blind.
    .with_handles(1)
}

/// The casing's lower piece.
pub fn base(p: &Cap, layout: &Layout) -> Body {
    let over = CUT_OVERLAP_MM;
    let joint = joint_poses(p, layout);
    let head_radius = JOINT_SCREW.head_diameter_mm() / 2.0 + gap_mm(Process::Fdm, Fit::Snug);
    let (head_z, bottom) = (joint_head_z(layout), layout.bottom_z);
    let screw_radius = JOINT_SCREW.clearance_hole_mm() / 2.0;
    // Passage and counterbore in the screw's own frame, z downwards.
    let to_bottom = head_z - bottom + over;
    let to_top = layout.joint_z - head_z + over;
    let passage = Solid::revolution(Path::polygon(&[
        [0.0, -to_top],
        [screw_radius, -to_top],
        [screw_radius, 0.0],
        [head_radius, 0.0],
        [head_radius, to_bottom],
        [0.0, to_bottom],
    ]));
    let passages = joint
        .iter()
        .enumerate()
        .map(|(i, pose)| passage.clone().placed(*pose).named(format!("screw passage {}", i + 1)));
    let mounts = mount_poses(p, layout);
    let pilots = mounts.iter().enumerate().map(|(i, pose)| {
        Screw::M3X4
            .pilot_tool(p.base.floor.mm() + over)
            .placed(*pose)
            .named(format!("mounting hole {}", i + 1))
    });
    let half = p.base.window_width.mm() / 2.0;
    let window = Solid::cuboid_between(
        [-half, -p.holder.width.mm(), layout.floor_z + WINDOW_MARGIN_MM],
        [half, 0.0, layout.housing_back_z - WINDOW_MARGIN_MM],
    );
    Body::made(
        "base",
        "casing's lower piece: clamps the camera, is screwed to a gripper",
        Process::Fdm,
        outline(p, bottom, layout.joint_z)
            .minus(
                pocket(layout, layout.housing_back_z, layout.joint_z + over).named("camera pocket"),
            )
            .minus(
                bore(layout.chamber_radius, layout.floor_z, layout.housing_back_z + over)
                    .named("plug room"),
            )
            .minus(wire_groove(layout, layout.housing_back_z - over, layout.joint_z + over))
            .minus(window.named("plug window"))
            .minus_all(passages)
            .minus_all(pilots),
    )
    .from(&p.holder.material)
    .placed([in_sensor().lifted(-62.0)])
    .marked(
        mounts
            .iter()
            .enumerate()
            .map(|(i, pose)| Landmark::at(format!("mounting hole {}", i + 1), pose)),
    )
    .colored(BLACK)
    .note("floor down, no supports: the window's upper edge is a bridge")
    .note("the gripper's M3 screws cut their threads into the floor")
    // A cup with the joint's passages, the mounting holes and the plug's window.
    .with_handles(4 + p.base.mount_holes as i32 + 1)
}
