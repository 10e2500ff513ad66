//! The gauge that the lens is focused in: once the board is screwed in, no finger reaches the lens.

use fabkit_geometry::{Body, CUT_OVERLAP_MM, Path, Pose, Process, Solid};

use super::bodies::*;
use super::layout::Layout;
use super::parameters::PinTip;
use crate::assembling::flipped;
use crate::blocks::{TOOL_GREY, copies, ring};

/// Thickness of the gauge's wall and of its target, mm.
const WALL_MM: f64 = 2.0;

/// Room beside lens holder and barrel, mm.
const BESIDE_MM: f64 = 0.6;

/// How far the windows for two fingers reach beyond the lens's front, mm: a fingertip's width.
const FINGERS_MM: f64 = 16.0;

/// Width of those windows as a share of the gauge's radius: four legs stay, over the board's corners.
const WINDOW_SHARE: f64 = 0.9;

/// Holes of the target around the one in the middle.
const TARGETS: u32 = 6;

/// Radius of their circle, mm: the middle of the picture, where the pins press first.
const TARGET_CIRCLE_MM: f64 = 4.0;

/// Outside and inside of the gauge, mm: it stands on the board, around the lens holder.
fn radii_mm(p: &PinTip) -> [f64; 2] {
    let camera = &p.camera;
    let corner = camera.holder_size.mm() * std::f64::consts::FRAC_1_SQRT_2;
    let least = corner.max(camera.barrel_diameter.mm() / 2.0) + BESIDE_MM + WALL_MM;
    let board = camera.board_size.mm().min(camera.board_size_y.mm()) / 2.0 - BESIDE_MM;
    let outer = least.max(board);
    [outer, outer - WALL_MM]
}

/// Tube on four legs with the target on top: holes against the light, as far away in air as the dots are
/// through lens and gel.
pub fn gauge(p: &PinTip, layout: &Layout) -> Body {
    let [outer, inner] = radii_mm(p);
    let bottom = layout.camera_board_top_z_mm;
    let target = layout.lens_front_z_mm + layout.focus_mm(p);
    let bell = Solid::revolution(Path::polygon(&[
        [inner, bottom],
        [outer, bottom],
        [outer, target + WALL_MM],
        [0.0, target + WALL_MM],
        [0.0, target],
        [inner, target],
    ]));
    let (half, far) = (WINDOW_SHARE * outer / 2.0, outer + CUT_OVERLAP_MM);
    // The tube stays closed below the target, however near that is.
    let top = (layout.lens_front_z_mm + FINGERS_MM).min(target - WALL_MM);
    let bottom = bottom - CUT_OVERLAP_MM;
    let windows = [
        Solid::cuboid_between([-far, -half, bottom], [far, half, top]).named("window along x"),
        Solid::cuboid_between([-half, -far, bottom], [half, far, top]).named("window along y"),
    ];
    let hole = Solid::rod(
        layout.pin_diameter_mm / 2.0,
        [target - CUT_OVERLAP_MM, target + WALL_MM + CUT_OVERLAP_MM],
    );
    let around = ring(TARGETS, 0.0, Pose::translation(TARGET_CIRCLE_MM, 0.0, 0.0));
    let places = [&[Pose::identity()], &around[..]].concat();
    FOCUS_GAUGE
        .made(Process::Fdm, bell.minus_all(windows).minus_all(copies("target", &places, &hole)))
        .from(&p.body.material)
        .placed([FOCUSING.in_place().lifted(30.0)])
        .colored(TOOL_GREY)
        .lying(flipped())
        .note("print on the target, legs up, without support")
        .with_supports(false)
        .with_handles(places.len() as i32)
}
