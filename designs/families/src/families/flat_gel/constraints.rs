//! Constraints between parameters: parts must fit, hold, and be manufacturable. The shared blocks check their own.

use super::FlatGelLayout;
use super::pad::frames;
use super::parameters::FlatGel;
use crate::blocks::PRINTED_WALL_MM;
use crate::parameters::{RuleReport, limits};

/// Minimum thickness of a bed that flows level over a plate, mm.
const LEAST_BED_MM: f64 = 1.0;

/// Largest overhang inside the shell that prints without support, mm.
const OVERHANG_MM: f64 = 2.0;

/// Minimum width of the chamber that the camera looks through, mm.
const LEAST_CHAMBER_MM: f64 = 4.0;

/// Minimum distance between lens and plate, mm.
const LENS_APART_MM: f64 = 0.5;

/// Parameters that determine the housing's edges along x and y, for messages.
const EDGE_PARAMETERS: [&str; 2] = ["pad.length", "pad.width"];

/// Reports every combination of parameters that cannot be built.
pub(super) fn check(p: &FlatGel, report: &mut RuleReport) {
    let layout = FlatGelLayout::new(p);
    check_pad(p, &layout, report);
    check_plate(p, &layout, report);
    if !report.is_clean() {
        return; // Every limit below would follow from these problems.
    }
    let (housing, base_mm) = (&layout.housing, p.base.thickness.mm());
    housing.check(layout.plate_bottom_z_mm, [layout.pad, layout.opening], &p.camera, report);
    layout.camera.check(base_mm, housing.room, &EDGE_PARAMETERS, report);
    layout
        .light
        .check([(EDGE_PARAMETERS[0], p.pad.length), (EDGE_PARAMETERS[1], p.pad.width)], report);
    p.markers.check(layout.gel, layout.visible_half_mm(), report);
    frames(p, &layout).check("pad.thickness", report);
}

fn check_pad(p: &FlatGel, layout: &FlatGelLayout, report: &mut RuleReport) {
    limits! { report, p:
        coat.thickness <= p.pad.thickness.mm() / 2.0, "most of the pad is gel";
        pad.corner >= p.coat.side.mm() + 0.1, "the gel under the coat has round edges, too";
        pad.corner <= layout.pad.narrow() / 2.0, "straight sides must remain between the edges";
    }
    let bed = p.bed.thickness.mm();
    report.require(
        bed == 0.0 || bed >= LEAST_BED_MM,
        "bed.thickness",
        || format!("bed.thickness is {bed} mm; a bed below {LEAST_BED_MM} mm does not flow level"),
        || format!("write 0 mm for none, or at least {LEAST_BED_MM} mm"),
    );
    if p.markers.has_dots() {
        limits! { report, p:
            markers.thickness <= p.coat.thickness.mm() / 2.0, "the coat covers the ink";
        }
    }
}

/// Checks the opening for the plate, and the chamber below it.
fn check_plate(p: &FlatGel, layout: &FlatGelLayout, report: &mut RuleReport) {
    let (plate, chamber, slide) = (&p.plate, layout.light.chamber, layout.housing.slide_mm);
    // Walls around the opening, along x and y.
    let [x, y] = [0, 1].map(|i| layout.housing.outside.half[i] - layout.opening.half[i]);
    let front_mm = layout.plate_bottom_z_mm - layout.camera.front_z;
    let distance_mm = layout.gel_top_z_mm - layout.camera.pupil_z;
    limits! { report, p:
        plate.overlap <= plate.overlap.mm() + chamber.narrow() - LEAST_CHAMBER_MM / 2.0,
            "the camera must see something past the ledge";
        plate.overlap >= p.coat.side.mm() + slide,
            "the pad's gel, not its coat alone, covers the joint around the plate";
        shell.rim >= p.shell.rim.mm() + PRINTED_WALL_MM - x.min(y),
            "the plate's opening needs a wall around it";
    }
    let camera = &*p.camera.board;
    limits! { report:
        camera.board_size <= 2.0 * (chamber.narrow() + OVERHANG_MM - slide),
            "the shell would overhang a wider board by more than 2 mm";
    }
    // A larger pixel pitch moves the camera away from the gel, in proportion to its distance.
    limits! { report, p:
        camera.pixel_pitch >=
            p.camera.pixel_pitch.mm() * (1.0 + (LENS_APART_MM - front_mm) / distance_mm),
            "the lens must not touch the plate";
        shell.wall <= p.shell.wall.mm() + chamber.narrow() - 1.0 - chamber.corner,
            "screws in the corners would round the chamber off";
    }
}
