//! Plate, shell, base and the LEDs' board.

use fabkit_geometry::{
    Angle, Body, CUT_OVERLAP_MM, Color, Path, Pose, Process, Profile, Solid, Vector3,
};

use super::joints::{CAMERA_SCREW, Joints, LIP_MM};
use super::layout::{Block, Layout};
use super::parameters::{FlatGel, LightFrom};
use super::{BLACK, in_sensor};
use crate::blocks::{GLASS, MASK_GREEN, PRINTED_WALL_MM, copies, corners, marks, turn, upright};
use crate::fits::{Fit, gap_mm};

/// White plastic as pictures show it.
const WHITE: Color = [236, 236, 232];

/// How a plastic of that name looks.
fn color(material: &str) -> Color {
    if material.contains("white") { WHITE } else { BLACK }
}

/// Room between the lens's holder and the LEDs' board around it, mm.
pub const BORE_GAP_MM: f64 = 0.4;

/// Radius of the hole in the LEDs' board that the lens looks through, mm.
pub fn bore_mm(p: &FlatGel) -> f64 {
    let holder = p.camera.holder_size.mm() / 2.0;
    (holder * 2f64.sqrt()).max(p.camera.barrel_diameter.mm() / 2.0) + BORE_GAP_MM
}

/// How many LEDs a strip at the wall `i` holds (0: +x, 1: +y, 2: -x, 3: -y).
pub fn leds_at_wall(p: &FlatGel, layout: &Layout, i: usize) -> u32 {
    let straight = layout.chamber.half[(i + 1) % 2] - layout.chamber.corner;
    (2.0 * straight / p.leds.pitch.mm()).floor().max(0.0) as u32
}

/// Where the LEDs are: the origin behind strip or on the board, z axis along the light.
pub fn led_poses(p: &FlatGel, layout: &Layout) -> Vec<Pose> {
    let spread = |count: u32, step: f64| {
        (0..count).map(move |i| step * (f64::from(i) - f64::from(count - 1) / 2.0))
    };
    let quarter = |deg: f64| Angle::from_deg(deg).expect("finite");
    match p.leds.from {
        LightFrom::Sides => {
            let inwards = Pose::rotation_z(quarter(-90.0)).then_in(Pose::rotation_x(quarter(90.0)));
            (0..p.leds.count.min(4))
                .flat_map(|wall| {
                    let (i, back) = (wall as usize, layout.chamber.half[wall as usize % 2]);
                    spread(leds_at_wall(p, layout, i), p.leds.pitch.mm()).map(move |along| {
                        let at = Pose::translation(back, along, layout.strip_z);
                        Pose::rotation_z(turn(wall, 4, 0.0)).then_in(at).then_in(inwards)
                    })
                })
                .collect()
        }
        LightFrom::Below => {
            // Two rows at the ends of the longer axis, as long as the straight part of the walls.
            let (long, short) = (layout.longer(), 1 - layout.longer());
            let row = row_out_mm(p, layout);
            let straight = layout.chamber.half[short] - layout.chamber.corner;
            let step = 2.0 * straight / f64::from(p.leds.count.max(2) - 1);
            [-row, row]
                .into_iter()
                .flat_map(|row| spread(p.leds.count, step).map(move |along| (row, along)))
                .map(|(row, along)| {
                    let mut at = [row; 2];
                    at[short] = along;
                    let turned = Pose::rotation_z(quarter(90.0 * (1 - long) as f64));
                    upright(at, layout.step_z).then_in(turned)
                })
                .collect()
        }
    }
}

/// Distance of the rows of LEDs from the axis, mm.
pub fn row_out_mm(p: &FlatGel, layout: &Layout) -> f64 {
    layout.chamber.half[layout.longer()] - p.leds.width.mm() / 2.0 - PRINTED_WALL_MM
}

/// All of it.
pub fn parts(p: &FlatGel, layout: &Layout) -> Vec<Body> {
    let board = (p.leds.from == LightFrom::Below).then(|| led_board(p, layout));
    [plate(p, layout), shell(p, layout), base(p, layout)].into_iter().chain(board).collect()
}

fn plate(p: &FlatGel, layout: &Layout) -> Body {
    Body::made(
        "plate",
        "clear plate that carries the gel",
        Process::Laser,
        layout.plate.prism([layout.plate_bottom_z, layout.plate_top_z]),
    )
    .from(&p.plate.material)
    .placed([in_sensor().lifted(14.0)])
    .colored(GLASS)
    .opaque(0.5)
    .note("leave the protective film on until it is glued")
}

/// The notch that cable and wires leave through.
fn notch(p: &FlatGel, layout: &Layout, heights: [f64; 2]) -> Solid {
    let half = p.shell.cable_width.mm() / 2.0;
    let [bottom, top] = heights;
    Solid::cuboid_between([-half, -layout.outside.half[1] - 1.0, bottom], [half, 0.0, top])
        .named("cable notch")
}

fn shell(p: &FlatGel, layout: &Layout) -> Body {
    let over = CUT_OVERLAP_MM;
    let opening = layout.opening.prism([layout.plate_bottom_z, over]).named("plate opening");
    let chamber = layout.chamber.prism([layout.step_z - over, layout.plate_bottom_z + over]);
    let lower = layout.lower.prism([layout.joint_z - over, layout.step_z]);
    let notch =
        notch(p, layout, [layout.joint_z - over, layout.joint_z + p.shell.cable_height.mm()]);
    let body = Body::made(
        "shell",
        "holds plate and light, closes over the camera",
        Process::Fdm,
        layout
            .outside
            .prism([layout.joint_z, 0.0])
            .minus(opening)
            .minus(chamber.named("chamber"))
            .minus(lower.named("camera room"))
            .minus(notch),
    )
    .from(&p.shell.material)
    .placed([in_sensor()])
    .colored(color(&p.shell.material))
    .note("standing as in use, no supports: what overhangs inside is narrower than 1 mm")
    .with_handles(1);
    body.cut(Joints::new(p, layout).casing.held().unmarked())
}

fn base(p: &FlatGel, layout: &Layout) -> Body {
    let joints = Joints::new(p, layout);
    let (bottom, joint, gap) = (layout.bottom_z, layout.joint_z, gap_mm(Process::Fdm, Fit::Snug));
    let into = layout.joint_z - super::INTO_MM;
    let [width, height] = LIP_MM;
    let around = layout.lower.shrunk(gap_mm(Process::Fdm, Fit::Slide));
    let lip = Profile::new(around.path()).with_hole(around.shrunk(width).path());
    let lip = Solid::prism(lip, [into, joint + height]).minus(notch(
        p,
        layout,
        [joint, joint + height + 1.0],
    ));
    let half = p.camera.screw_spacing.mm() / 2.0;
    let post = Solid::rod(post_mm(), [into, layout.board_bottom_z]);
    let posts = copies("post", &corners([half, half]).map(|at| upright(at, 0.0)), &post);
    Body::made(
        "base",
        "carries the camera, closes the shell, is screwed to a gripper",
        Process::Fdm,
        Solid::union(
            [layout.outside.prism([bottom, joint]), lip.named("lip")].into_iter().chain(posts),
        ),
    )
    .from(&p.base.material)
    .placed([in_sensor().lifted(-40.0)])
    .colored(color(&p.base.material))
    .note("floor down, no supports: the screws' seats are short bridges")
    .note("the gripper's M3 screws cut their threads into the floor")
    .cut(joints.casing.sunk(joint - head_z(&joints), head_z(&joints) - bottom, gap).unmarked())
    .cut(joints.camera.held().unmarked())
    .cut(joints.mounting.held_through())
}

/// Height at which the heads of the casing's screws bear.
fn head_z(joints: &Joints) -> f64 {
    joints.casing.poses[0].translation_mm().z
}

/// Radius of a post under the camera's board, mm.
pub fn post_mm() -> f64 {
    CAMERA_SCREW.pilot_hole_mm() / 2.0 + PRINTED_WALL_MM
}

/// The board around the lens, glued up against the shell's step.
pub fn led_board_block(layout: &Layout) -> Block {
    layout.lower.shrunk(gap_mm(Process::Fdm, Fit::Slide))
}

fn led_board(p: &FlatGel, layout: &Layout) -> Body {
    let bore = Path::circle([0.0; 2], bore_mm(p));
    let profile = Profile::new(led_board_block(layout).path()).with_hole(bore);
    let top = layout.step_z;
    Body::made(
        "led-board",
        "circuit board around the lens that carries the LEDs",
        Process::Pcb,
        Solid::prism(profile, [top - p.leds.board_thickness.mm(), top]),
    )
    .from("FR4")
    .placed([in_sensor().moved_apart(Vector3::new(0.0, 0.0, -16.0))])
    .marked(marks("led", &led_poses(p, layout)))
    .colored(MASK_GREEN)
    .note("push it up against the shell's step and fix it with four drops of glue")
    .with_handles(1)
}
