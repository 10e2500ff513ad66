//! What the parameters must fulfil together so that things fit, hold and can be made.

use fabkit_geometry::Process;

use super::components::connector_mm;
use super::housing::{bore_mm, leds_at_wall, post_mm, row_out_mm};
use super::joints::{CAMERA_SCREW, CASING_SCREW, LIP_MM, PILOT_SPARE_MM, SHELF_MM, mount_out_mm};
use super::layout::Layout;
use super::pad::frames;
use super::parameters::{FlatGel, LightFrom};
use crate::blocks::{APART_MM, PRINTED_WALL_MM, require_castable};
use crate::fits::{Fit, gap_mm};
use crate::parameters::Report;

/// Thinnest bed that flows over a plate, mm.
const LEAST_BED_MM: f64 = 1.0;

/// Smallest connector for a flat cable, mm.
const LEAST_CONNECTOR_MM: f64 = 2.0;

/// Widest overhang inside the shell that prints without support, mm.
const OVERHANG_MM: f64 = 2.0;

/// What the housing's edges along x and y follow from.
const EDGES: [&str; 2] = ["pad.length", "pad.width"];

/// What the heights below the pad follow from.
const DISTANCE: [&str; 5] = [
    "camera.pixel_pitch",
    "camera.field_of_view",
    "pad.thickness",
    "bed.thickness",
    "plate.thickness",
];

/// Reports every combination that cannot be built.
pub(super) fn check(p: &FlatGel, report: &mut Report) {
    let layout = Layout::new(p);
    let materials = [
        ("pad.material", &p.pad.material),
        ("coat.material", &p.coat.material),
        ("bed.material", &p.bed.material),
        ("markers.material", &p.markers.material),
    ];
    require_castable(&materials, report);
    pad(p, &layout, report);
    room(p, &layout, report);
    if !report.is_clean() {
        return; // The rest would follow from it.
    }
    markers(p, &layout, report);
    shell(p, &layout, report);
    light(p, &layout, report);
    camera(p, &layout, report);
    frames(p, &layout).check(&["pad.thickness", "coat.thickness"], report);
}

fn pad(p: &FlatGel, layout: &Layout, report: &mut Report) {
    report.at_most(
        "coat.thickness",
        p.coat.thickness,
        p.pad.thickness.mm() / 2.0,
        "most of the pad is gel",
        &["pad.thickness"],
    );
    report.at_least(
        "pad.corner",
        p.pad.corner,
        p.coat.side.mm() + 0.1,
        "the gel's corners are rounder than the coat is thick, or it tears there",
        &["coat.side"],
    );
    let least = layout.pad.half[0].min(layout.pad.half[1]);
    let of = "corners must leave straight sides";
    report.at_most("pad.corner", p.pad.corner, least / 2.0, of, &EDGES);
    let bed = p.bed.thickness.mm();
    report.require(
        bed == 0.0 || bed >= LEAST_BED_MM,
        "bed.thickness",
        || format!("bed.thickness is {bed} mm; a thinner bed than {LEAST_BED_MM} mm does not flow"),
        || format!("write 0 mm for none, or at least {LEAST_BED_MM} mm"),
    );
    report.at_most(
        "plate.overlap",
        p.plate.overlap,
        least - p.coat.side.mm() - p.plate.ledge.mm() - 2.0,
        "the camera must see something",
        &["pad.length", "pad.width", "plate.ledge"],
    );
}

/// The camera's room beside the chamber above it.
fn room(p: &FlatGel, layout: &Layout, report: &mut Report) {
    let (board, most) = (p.camera.board_size, layout.chamber.half);
    report.at_most(
        "camera.board_size",
        board,
        2.0 * (most[0].min(most[1]) + OVERHANG_MM - gap_mm(Process::Fdm, Fit::Slide)),
        "the shell would overhang more than 2 mm above a wider board",
        &["pad.length", "pad.width", "plate.overlap", "plate.ledge"],
    );
    report.at_least(
        "camera.back_clearance",
        p.camera.back_clearance,
        LIP_MM[1] + APART_MM,
        "the board lies above the base's lip",
        &[],
    );
    let corner = layout.lower.corner;
    let straight = layout.chamber.half[0].min(layout.chamber.half[1]) - 0.5;
    report.at_most(
        "shell.wall",
        p.shell.wall,
        if corner <= straight {
            p.shell.wall.mm()
        } else {
            p.shell.wall.mm() - (corner - straight)
        },
        "the screws in the corners would round the chamber to less than a straight wall",
        &EDGES,
    );
}

fn markers(p: &FlatGel, layout: &Layout, report: &mut Report) {
    let dots = &p.markers;
    if dots.columns * dots.rows == 0 {
        return;
    }
    report.at_most(
        "markers.thickness",
        dots.thickness,
        p.coat.thickness.mm() / 2.0,
        "the coat covers the ink",
        &["coat.thickness"],
    );
    report.at_most(
        "markers.diameter",
        dots.diameter,
        dots.spacing.mm() - 0.2,
        "the stencil needs 0.2 mm between neighbours",
        &["markers.spacing"],
    );
    let seen = layout.seen_mm(p);
    let counts = [("markers.columns", dots.columns), ("markers.rows", dots.rows)];
    for (i, (path, count)) in counts.into_iter().enumerate() {
        let flat = layout.gel.half[i] - layout.gel.corner.max(0.3);
        let room = 2.0 * seen[i].min(flat) - dots.diameter.mm();
        let most = (room / dots.spacing.mm() + 1e-9).floor().max(0.0) as u32 + 1;
        report.require(
            count <= most,
            path,
            || {
                format!(
                    "{path} is {count}; at {} from dot to dot, the camera sees {most} on the {:.2} mm \
                     of gel between its picture's edges, the ledge and the LEDs",
                    dots.spacing,
                    room + dots.diameter.mm()
                )
            },
            || format!("write {most}, or change `markers.spacing` or `camera.field_of_view`"),
        );
    }
}

fn shell(p: &FlatGel, layout: &Layout, report: &mut Report) {
    let head = CASING_SCREW.head_diameter_mm() / 2.0 + gap_mm(Process::Fdm, Fit::Snug);
    report.at_most(
        "shell.corner",
        p.shell.corner,
        head + PRINTED_WALL_MM,
        "the screws' heads need a wall at the rounded corner",
        &[],
    );
    for (i, path) in EDGES.into_iter().enumerate() {
        let wall = layout.outside.half[i] - layout.opening.half[i];
        report.at_least(
            "shell.rim",
            p.shell.rim,
            p.shell.rim.mm() + PRINTED_WALL_MM - wall,
            "the plate's opening needs a wall around it",
            &["plate.overlap", path],
        );
    }
    report.at_least(
        "base.thickness",
        p.base.thickness,
        SHELF_MM + CASING_SCREW.head_height_mm() + 0.2,
        "the screws' heads are sunk into the base",
        &[],
    );
    let below_board = CAMERA_SCREW.length_mm + PILOT_SPARE_MM - p.camera.board_thickness.mm() + 0.4;
    report.at_least(
        "base.thickness",
        p.base.thickness,
        below_board - p.camera.back_clearance.mm(),
        "the camera's M1.6x5 screws end inside the base",
        &["camera.back_clearance", "camera.board_thickness"],
    );
    report.at_most(
        "shell.cable_height",
        p.shell.cable_height,
        layout.plate_bottom_z - layout.joint_z - PRINTED_WALL_MM,
        "the notch ends below the plate",
        &DISTANCE,
    );
    let pilot = CASING_SCREW.pilot_hole_mm() / 2.0 + PRINTED_WALL_MM;
    report.at_most(
        "shell.cable_width",
        p.shell.cable_width,
        2.0 * (layout.screw[0] - pilot).min(layout.lower.half[0] - layout.lower.corner),
        "the notch lies in the straight wall between two screws",
        &["pad.length"],
    );
    let bite = CASING_SCREW.length_mm - SHELF_MM + PILOT_SPARE_MM;
    report.at_least(
        "camera.back_clearance",
        p.camera.back_clearance,
        p.camera.back_clearance.mm() + bite + 1.0 - (layout.plate_bottom_z - layout.joint_z),
        "the shell's screws end below the plate",
        &DISTANCE,
    );
}

fn light(p: &FlatGel, layout: &Layout, report: &mut Report) {
    let leds = &p.leds;
    match leds.from {
        LightFrom::Sides => {
            let walls = leds.count.min(4) as usize;
            let fewest = (0..walls).map(|i| leds_at_wall(p, layout, i)).min().unwrap_or(0);
            report.require(
                leds.count <= 4,
                "leds.count",
                || format!("leds.count is {}; the shell has 4 walls", leds.count),
                || "write at most 4".into(),
            );
            let straight = layout.chamber.half.map(|h| 2.0 * (h - layout.chamber.corner));
            report.require(
                fewest > 0,
                "leds.pitch",
                || {
                    format!(
                        "leds.pitch is {}; the chamber's walls are straight over {:.2} mm and {:.2} mm",
                        leds.pitch, straight[0], straight[1]
                    )
                },
                || "write less than the shorter one, or make the pad larger".into(),
            );
            let out = leds.board_thickness.mm() + leds.package_height.mm();
            report.at_most(
                "leds.package_height",
                leds.package_height,
                leds.package_height.mm() + layout.chamber.corner + 1.0 - out,
                "LEDs of neighbouring walls must not touch",
                &["leds.board_thickness"],
            );
            report.at_most(
                "leds.below_plate",
                leds.below_plate,
                layout.plate_bottom_z - layout.step_z - leds.width.mm(),
                "the strips end above the camera's room",
                &["leds.width", "camera.pixel_pitch", "camera.lens_height"],
            );
            let beside = layout.chamber.half[0].min(layout.chamber.half[1]) - out - APART_MM;
            report.at_most(
                "camera.barrel_diameter",
                p.camera.barrel_diameter,
                2.0 * beside,
                "the lens stands between the LEDs",
                &["leds.package_height", "leds.board_thickness"],
            );
        }
        LightFrom::Below => {
            report.at_least(
                "camera.lens_height",
                p.camera.lens_height,
                p.camera.lens_height.mm()
                    + layout.board_top_z
                    + CAMERA_SCREW.head_height_mm()
                    + APART_MM
                    - (layout.step_z - leds.board_thickness.mm()),
                "the LEDs' board lies above the heads of the camera's screws",
                &["camera.pupil_behind_front", "leds.package_height", "leds.board_thickness"],
            );
            let (long, short) = (layout.longer(), 1 - layout.longer());
            report.at_least(
                EDGES[short],
                [p.pad.length, p.pad.width][short],
                2.0 * (layout.pad.half[short] - layout.lower.half[short] + bore_mm(p) + 1.0),
                "the LEDs' board needs 1 mm beside the lens's holder",
                &["camera.holder_size", "plate.overlap", "plate.ledge"],
            );
            let inside = bore_mm(p) + leds.width.mm() / 2.0 + 0.2;
            report.at_least(
                EDGES[long],
                [p.pad.length, p.pad.width][long],
                2.0 * (layout.pad.half[long] + inside - row_out_mm(p, layout)),
                "the rows of LEDs lie beside the lens's holder",
                &["camera.holder_size", "leds.width"],
            );
            let straight = 2.0 * (layout.chamber.half[short] - layout.chamber.corner);
            let room = straight / f64::from(leds.count.max(2) - 1);
            report.at_most(
                "leds.pitch",
                leds.pitch,
                room - 0.2,
                "the LEDs of a row must not touch",
                &["leds.count", EDGES[short]],
            );
        }
    }
}

fn camera(p: &FlatGel, layout: &Layout, report: &mut Report) {
    let camera = &p.camera;
    report.at_least(
        "camera.pixel_pitch",
        camera.pixel_pitch,
        camera.pixel_pitch.mm()
            * (1.0
                + (layout.lens_front_z + 0.5 - layout.plate_bottom_z)
                    / (layout.seen_z - layout.pupil_z)),
        "the lens must not touch the plate",
        &DISTANCE[1..],
    );
    report.at_most(
        "camera.holder_height",
        camera.holder_height,
        camera.lens_height.mm(),
        "the lens stands out of its holder",
        &["camera.lens_height"],
    );
    report.at_most(
        "camera.barrel_diameter",
        camera.barrel_diameter,
        camera.holder_size.mm(),
        "the lens stands on its holder",
        &["camera.holder_size"],
    );
    let head = CAMERA_SCREW.head_diameter_mm() / 2.0;
    report.at_least(
        "camera.screw_spacing",
        camera.screw_spacing,
        camera.holder_size.mm() + 2.0 * (head + APART_MM),
        "the screws' heads lie beside the lens's holder",
        &["camera.holder_size"],
    );
    report.at_least(
        "camera.screw_spacing",
        camera.screw_spacing,
        camera.screw_spacing.mm() + LEAST_CONNECTOR_MM - connector_mm(p),
        "the connector lies between the posts",
        &[],
    );
    report.at_most(
        "camera.screw_spacing",
        camera.screw_spacing,
        camera.board_size.mm() - CAMERA_SCREW.clearance_hole_mm() - 1.0,
        "the screws' holes need half a millimetre of board around them",
        &["camera.board_size"],
    );
    let board = camera.board_size.mm() / 2.0;
    report.require(
        layout.lower.holds([board; 2], APART_MM),
        "camera.board_size",
        || {
            format!(
                "camera.board_size is {}; its corners meet the round corners (radius {:.2} mm) of the \
                 room of {:.2} x {:.2} mm around it",
                camera.board_size,
                layout.lower.corner,
                2.0 * layout.lower.half[0],
                2.0 * layout.lower.half[1]
            )
        },
        || "take a smaller board, a larger pad or a larger `shell.rim`".into(),
    );
    // Nothing of a mounting screw's hole may meet a post.
    let spacing = camera.screw_spacing.mm() / 2.0;
    let apart = (mount_out_mm(layout) - spacing).hypot(spacing) - post_mm();
    report.at_least(
        "camera.screw_spacing",
        camera.screw_spacing,
        camera.screw_spacing.mm() + 2.0 * (1.25 + PRINTED_WALL_MM - apart),
        "a wall remains between mounting holes and posts",
        &EDGES,
    );
}
