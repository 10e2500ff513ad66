//! The rigid box: four walls between two plates, drawn together by spacers and screws in the
//! corners, without glue. Everything is cut from one sheet: the molds need the laser anyway, and a
//! dark sheet is as light-tight as a print. Edges are as a laser leaves them, square.

use std::f64::consts::FRAC_PI_2;

use fabkit_geometry::{Angle, Body, Path, Placement, Pose, Process, Profile, Vector3};

use super::bodies::*;
use super::joints::Joints;
use super::layout::{Layout, bolt_hole_mm};
use super::parameters::SheetMold;
use super::sheets::{sheet, square, with_bolts, with_holes};
use crate::assembling::{Name, SENSOR};
use crate::blocks::BLACK;
use crate::blocks::Rect;
use crate::blocks::adapter::{Exit, MountFace};
use crate::fits::Fit;
use crate::hardware::HexSpacer;

/// Tabs end below the surface of the plate they reach into, so that nothing rocks on them, mm.
const TAB_SHORT_MM: f64 = 0.3;

/// How far walls move out in the exploded picture, mm.
const WALL_EXPLODE_MM: f64 = 34.0;

/// How far a clamping bar moves in the exploded picture, its own frame, mm.
pub const BAR_EXPLODE_MM: Vector3<f64> = Vector3::new(0.0, 26.0, 76.0);

/// Number of walls.
const WALLS: u32 = 4;

/// Plates, walls and clamping bars.
pub fn sheets(p: &SheetMold, layout: &Layout) -> Vec<Body> {
    let cut = |name, profile, thickness_mm: f64| {
        sheet(name, profile, thickness_mm, &p.housing.material).colored(BLACK)
    };
    let (thickness, cable) = (p.housing.sheet.mm(), p.housing.cable_side.quarters());
    let window = Path::rectangle([0.0; 2], [p.housing.window.mm(); 2], 0.0);
    let slotted = |name| {
        let plate = with_bolts(Profile::new(square(p)), p, layout, name);
        with_tab_slots(plate, p, layout, name)
    };
    let bar = |i| {
        let pose = quarter(i).then_in(Pose::translation(0.0, 0.0, layout.bond_z_mm));
        SENSOR.at(pose).moved_apart(pose.vector(BAR_EXPLODE_MM))
    };
    vec![
        cut(BOX_CEILING, slotted(BOX_CEILING).with_hole(window), thickness)
            .placed([SENSOR.at_z(layout.ceiling_z_mm)]),
        cut(BOX_FLOOR, Joints::new(p, layout).camera.pierced(slotted(BOX_FLOOR)), thickness)
            .placed([SENSOR, BOX_FOCUSING].map(|at| at.at_z(layout.bottom_z_mm).lifted(-34.0))),
        cut(CABLE_WALL, Profile::new(wall(p, layout, true)), thickness)
            .placed([wall_placement(layout, cable)]),
        cut(BOX_WALL, Profile::new(wall(p, layout, false)), thickness)
            .placed((1..WALLS).map(|i| wall_placement(layout, (cable + i) % WALLS)))
            .one_per_place(),
        cut(CLAMP_BAR, clamp_bar(p, layout), p.housing.clamp.mm())
            .placed([0, 2].map(bar))
            .one_per_place()
            .note("one on either side without tubes"),
    ]
}

/// A quarter turn about z, `i` times.
fn quarter(i: u32) -> Pose {
    Pose::rotation_z(Angle::from_rad(f64::from(i) * FRAC_PI_2).expect("finite"))
}

/// Turns a wall's frame (x along it, y up, z out) to the wall at +x, standing on the floor.
pub fn sensor_from_wall(layout: &Layout, i: u32) -> Pose {
    let right_angle = Angle::from_rad(FRAC_PI_2).expect("finite");
    let upright = Pose::rotation_z(right_angle).then_in(Pose::rotation_x(right_angle));
    quarter(i)
        .then_in(Pose::translation(layout.wall_inner_mm, 0.0, layout.floor_z_mm))
        .then_in(upright)
}

fn wall_placement(layout: &Layout, i: u32) -> Placement {
    SENSOR.drawn_out(&sensor_from_wall(layout, i), WALL_EXPLODE_MM)
}

/// Centres of a wall's two tabs, along it.
fn tab_centres(layout: &Layout) -> [f64; 2] {
    [-layout.wall_inner_mm / 2.0, layout.wall_inner_mm / 2.0]
}

/// A wall's outline. Its right edge has fingers where its left edge has gaps, so that four equal
/// walls close the box.
fn wall(p: &SheetMold, layout: &Layout, has_cable: bool) -> Path {
    // Fingers of either mesh with those of the other: the larger gap.
    let meshing = [CABLE_WALL, BOX_WALL].map(|wall| (wall, Process::Laser));
    let (height, play) = (p.housing.height.mm(), p.making.widest_mm(meshing, Fit::Snug));
    let (finger, gap) = (layout.wall_outer_mm, layout.wall_inner_mm - play);
    let tab = p.housing.tab.mm() / 2.0;
    let reach = p.housing.sheet.mm() - TAB_SHORT_MM;

    // Corners of the edge that has fingers in the intervals of that parity, from bottom to top.
    let edge = |parity: u32| -> Vec<[f64; 2]> {
        let is_finger = |j: u32| j % 2 == parity;
        let x = |j: u32| if is_finger(j) { finger } else { gap };
        let mut points = vec![[x(0), 0.0]];
        for j in 1..p.housing.fingers {
            let boundary = height * f64::from(j) / f64::from(p.housing.fingers);
            // Fingers are narrower than gaps.
            let y = if is_finger(j) { boundary + play } else { boundary - play };
            points.extend([[x(j - 1), y], [x(j), y]]);
        }
        points.push([x(p.housing.fingers - 1), height]);
        points
    };
    let mut points = Vec::new();
    let [left_tab, right_tab] = tab_centres(layout);
    let tab_below = |x: f64| [[x - tab, 0.0], [x - tab, -reach], [x + tab, -reach], [x + tab, 0.0]];
    points.extend(tab_below(left_tab));
    if has_cable {
        let (w, h) = (p.housing.cable_width.mm() / 2.0, p.housing.cable_height.mm());
        points.extend([[-w, 0.0], [-w, h], [w, h], [w, 0.0]]);
    }
    points.extend(tab_below(right_tab));
    points.extend(edge(0));
    for x in [right_tab, left_tab] {
        points.extend(tab_below(x).iter().rev().map(|[x, y]| [*x, height - y]));
    }
    points.extend(edge(1).into_iter().rev().map(|[x, y]| [-x, y]));
    Path::polygon(&points)
}

fn with_tab_slots(profile: Profile, p: &SheetMold, layout: &Layout, plate: Name) -> Profile {
    let play = 2.0 * p.making.gap_mm(plate, Process::Laser, Fit::Slide);
    let (along, across) = (p.housing.tab.mm() + play, p.housing.sheet.mm() + play);
    let middle = (layout.wall_inner_mm + layout.wall_outer_mm) / 2.0;
    (0..WALLS).fold(profile, |profile, i| {
        tab_centres(layout).into_iter().fold(profile, |profile, offset| {
            let (centre, size) = match i {
                0 => ([middle, offset], [across, along]),
                1 => ([offset, middle], [along, across]),
                2 => ([-middle, offset], [across, along]),
                _ => ([offset, -middle], [along, across]),
            };
            profile.with_hole(Path::rectangle(centre, size, 0.0))
        })
    })
}

/// The bar at +y; the other is the same, turned.
fn clamp_bar(p: &SheetMold, layout: &Layout) -> Profile {
    let half = p.plate.side.mm() / 2.0;
    let inner = clamp_inner_mm(p);
    let r = half - layout.bolt_mm;
    let outline = Path::from([-half, inner])
        .line([half, inner])
        .line([half, half - r])
        .arc([half - r, half], [half - r, half - r], true)
        .line([r - half, half])
        .arc([-half, half - r], [r - half, half - r], true)
        .close();
    let holes = [[layout.bolt_mm, layout.bolt_mm], [-layout.bolt_mm, layout.bolt_mm]];
    with_holes(Profile::new(outline), &holes, bolt_hole_mm(p, CLAMP_BAR))
}

/// Inner edge of a clamping bar, from the axis.
pub fn clamp_inner_mm(p: &SheetMold) -> f64 {
    p.channel_layer.side.mm() / 2.0 + p.housing.clamp_gap.mm()
}

/// What the box is mounted by: the corner screws in its floor, which go through a plate below it too.
pub fn face(p: &SheetMold, layout: &Layout) -> MountFace {
    let joints = Joints::new(p, layout);
    let is_below = |pose: &Pose| pose.vector(Vector3::z()).z < 0.0;
    let mut mounting = joints.housing.clone();
    mounting.poses.retain(is_below);
    let sheet = p.housing.sheet.mm();
    let head = &joints.camera.screw;
    let size = [head.head_diameter_mm() / 2.0, head.head_height_mm()];
    let half = p.plate.side.mm() / 2.0;
    MountFace {
        holder: BOX_FLOOR,
        mounting,
        borrowed_mm: Some([sheet, sheet + HexSpacer::M3.thread_depth_mm]),
        bottom_z_mm: layout.bottom_z_mm,
        outline: Rect { half: [half; 2], corner: half - layout.bolt_mm },
        exits: vec![Exit::Aside {
            angle: p.housing.cable_side.angle(),
            width_mm: p.housing.cable_width.mm(),
            above_mm: sheet,
        }],
        heads: joints
            .camera
            .poses
            .iter()
            .map(|pose| (pose.translation_mm().xy().into(), size))
            .collect(),
    }
}
