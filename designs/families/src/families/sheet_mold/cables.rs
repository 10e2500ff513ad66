//! The cables of both cameras, from the plugs behind their boards to beside the sensor.
//!
//! Boards stand on spacers, so that a cable runs between board and plate. Each is plugged in before its
//! board is screwed down; the box's is laid into its opening before that wall is put on, so that no plug
//! has to pass it.

use fabkit_geometry::{Body, Order, Placement, Point3};

use super::bodies::*;
use super::components::{PLUG_ABOVE_MM, plug_reach_mm};
use super::layout::Layout;
use super::parameters::SheetMold;
use crate::blocks::cable::{Cable, GIVES_MM};
use crate::blocks::cable_way::Side;
use crate::blocks::{APART_MM, RUBBER};
use crate::parameters::{Report, limits};

/// Diameter of a USB cable, mm, where the room behind a board and the opening allow it.
const CABLE_MM: f64 = 4.0;

/// Bend radius, mm: twice the diameter, as nothing moves in use.
const BEND_MM: f64 = 8.0;

/// From a board's edge to the middle of a cable that goes around it, mm.
const BESIDE_MM: f64 = 8.0;

/// How far a cable is drawn beyond what it leaves, mm.
const BEYOND_MM: f64 = 20.0;

/// A cable through points in the plane of the camera's plate, mm.
fn cable(p: &SheetMold, through: &[[f64; 2]]) -> Cable {
    let behind = p.camera.spacer.mm() - PLUG_ABOVE_MM;
    let opening = p.housing.cable_height.mm().min(p.housing.cable_width.mm());
    let z = PLUG_ABOVE_MM + behind / 2.0;
    // Symmetric in the opening's height is not needed; below its upper edge is.
    let diameter_mm = CABLE_MM.min(behind - APART_MM).min(2.0 * (opening - z) - APART_MM);
    let corners = through.iter().map(|&[x, y]| Point3::new(x, y, z)).collect();
    Cable { diameter_mm, bend_mm: BEND_MM, corners }
}

/// The cable in the box: to its opening, around the board where that is not beside the plug.
fn in_box(p: &SheetMold, layout: &Layout) -> Cable {
    let start = [plug_reach_mm(p)[1], 0.0];
    let [x, y] = [p.camera.board_size, p.camera.board_size_y].map(|e| e.mm() / 2.0 + BESIDE_MM);
    let out = layout.wall_outer_mm + BEYOND_MM;
    match p.housing.cable_side {
        Side::Right => cable(p, &[start, [out, 0.0]]),
        Side::Left => cable(p, &[start, [x, 0.0], [x, y], [-x, y], [-x, 0.0], [-out, 0.0]]),
        Side::Front => cable(p, &[start, [x, 0.0], [x, -y], [0.0, -y], [0.0, -out]]),
        Side::Back => cable(p, &[start, [x, 0.0], [x, y], [0.0, y], [0.0, out]]),
    }
}

/// How long both are drawn, mm: that of the box first.
pub fn lengths_mm(p: &SheetMold, layout: &Layout) -> [f64; 2] {
    both(p, layout).map(|cable| cable.length_mm())
}

/// That of the camera in the box, and that of the one above the display.
fn both(p: &SheetMold, layout: &Layout) -> [Cable; 2] {
    let end = layout.display_size_mm[0] / 2.0 + BEYOND_MM;
    [in_box(p, layout), cable(p, &[[plug_reach_mm(p)[1], 0.0], [end, 0.0]])]
}

/// Both, each in the frame of its camera's plate.
pub fn cables(p: &SheetMold, layout: &Layout, cameras: &[Placement; 2]) -> [Body; 2] {
    let [below, above] = both(p, layout).map(|cable| cable.solid());
    let [box_camera, stand_camera] = cameras.clone();
    [
        BOX_CABLE.bought("USB cable of the camera in the box", below, [box_camera]),
        STAND_CABLE.bought("USB cable of the camera above the display", above, [stand_camera]),
    ]
    .map(|body| {
        body.ordered(Order::of("USB cable of the camera", "")).colored(RUBBER).giving(GIVES_MM)
    })
}

/// Reports a cable that has no room around its camera's board.
pub fn check(p: &SheetMold, layout: &Layout, report: &mut Report) {
    let cable = in_box(p, layout);
    let room = layout.wall_inner_mm - cable.diameter_mm / 2.0 - BESIDE_MM - APART_MM;
    if p.housing.cable_side != Side::Right {
        limits! { report, p:
            camera.board_size <= 2.0 * room, "the cable goes around the board, inside the walls";
            camera.board_size_y <= 2.0 * room, "the cable goes around the board, inside the walls";
        }
    }
    report.require(
        cable.diameter_mm >= 1.0,
        "housing.cable_height",
        || {
            format!(
                "housing.cable_height is {}; a cable behind the board at {} leaves {:.1} mm of it",
                p.housing.cable_height, p.camera.spacer, cable.diameter_mm
            )
        },
        || "write a higher opening, or a shorter `camera.spacer`".into(),
    );
}
