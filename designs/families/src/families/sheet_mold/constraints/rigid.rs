//! Plates, box and screws.

use std::f64::consts::SQRT_2;

use fabkit_geometry::{CompiledSolid, Kind, Process, Sensor};

use super::{APART_MM, BOLT_WEB_MM, CUT_WEB_MM, GRIP_MM};
use crate::families::sheet_mold::bodies::*;
use crate::families::sheet_mold::components::led_top_mm;
use crate::families::sheet_mold::housing::clamp_inner_mm;
use crate::families::sheet_mold::joints::{CAMERA, CORNER};
use crate::families::sheet_mold::layout::{Layout, bolt_hole_mm};
use crate::families::sheet_mold::parameters::SheetMold;
use crate::fits::Fit;
use crate::hardware::HexSpacer;
use crate::parameters::{Report, limits};

pub(super) fn plates(p: &SheetMold, layout: &Layout, report: &mut Report) {
    let plates = [
        MOLD_FLOOR,
        CHANNEL_COMB,
        CHANNEL_FRAME,
        MARKER_PLATE,
        MARKER_FRAME,
        BOX_CEILING,
        BOX_FLOOR,
    ];
    let hole = plates.map(|plate| bolt_hole_mm(p, plate)).into_iter().fold(0.0, f64::max);
    let slotted = [BOX_CEILING, BOX_FLOOR].map(|plate| (plate, Process::Laser));
    let slide = p.making.widest_mm(slotted, Fit::Slide);
    limits! { report, p:
        marker_layer.side >= 2.0 * (clamp_inner_mm(p) + GRIP_MM),
            "the bars beside the channel layer must hold 4 mm of the marker layer";
        marker_layer.side >= p.housing.window.mm() + 2.0 * GRIP_MM,
            "the marker layer rests on the rim of the window";
        // Across the corner from the cavity's corner to the hole.
        plate.bolt_spacing >= p.marker_layer.side.mm() + SQRT_2 * (hole + BOLT_WEB_MM),
            "bolts stand outside of the cavity's corners";
        plate.side >=
            2.0 * (layout.wall_outer_mm + slide + BOLT_WEB_MM),
            "plates reach beyond the walls' slots, which lie outside of the bolts";
        plate.pry_depth <= (p.plate.side.mm() - p.marker_layer.side.mm()) / 2.0 - BOLT_WEB_MM,
            "the notches must not open the cavity";
        plate.pry_width <= p.plate.bolt_spacing.mm() - 4.0 * hole,
            "the notches lie between the bolts";
    }
}

pub(super) fn housing(p: &SheetMold, layout: &Layout, report: &mut Report) {
    let spacer = HexSpacer::M3.corner_radius_mm();
    let (fingers, bar_hole) = (f64::from(p.housing.fingers), bolt_hole_mm(p, CLAMP_BAR));
    limits! { report, p:
        housing.window <= 2.0 * (layout.bolt_mm - spacer),
            "the spacers in the corners bear on the ceiling outside of the window";
        housing.tab <= layout.wall_inner_mm - p.housing.cable_width.mm() - 2.0 * CUT_WEB_MM,
            "the cable leaves between a wall's two tabs";
        housing.cable_height <= led_top_mm(p) - p.housing.led_strip_width.mm() - APART_MM,
            "the LED strips lie above the cable";
        housing.led_strip_length <= 2.0 * (layout.bolt_mm - spacer),
            "the strips fit between the corner spacers";
        housing.led_strip_width <= p.housing.height.mm() / 2.0,
            "the strips stay in the lower half of the box, out of the camera's sight";
        housing.clamp_gap <=
            layout.bolt_mm - bar_hole - BOLT_WEB_MM - p.channel_layer.side.mm() / 2.0,
            "a bar reaches inwards from its bolts";
        housing.height >= 2.0 * HexSpacer::M3.thread_depth_mm,
            "the spacers have a thread at either end";
        housing.height >= fingers * p.housing.sheet.mm(),
            "fingers are at least as high as the sheet is thick";
    }
}

/// The M3 x 12 screws must reach their nuts and spacers, and not hit the end of the thread.
pub(super) fn screws(p: &SheetMold, report: &mut Report) {
    let (screw, nut) = CORNER;
    let length = screw.length_mm;
    let thread = HexSpacer::M3.thread_depth_mm;
    let grip = 2.0;
    let above_floor = length - p.molds.floor.mm() - nut.height_mm;
    let m2 = CAMERA.0.length_mm
        - p.housing.sheet.mm()
        - p.camera.board_thickness.mm()
        - CAMERA.1.height_mm;
    limits! { report, p:
        molds.floor <= length - nut.height_mm - p.channels.height.mm() - p.channel_layer.roof.mm(),
            "an M3x12 screw must reach through the stack and its nut";
        markers.height <= above_floor - p.marker_layer.thickness.mm(),
            "an M3x12 screw must reach through the stack and its nut";
        housing.clamp <= length - grip - p.housing.sheet.mm() - p.marker_layer.thickness.mm(),
            "an M3x12 screw must reach 2 mm into its spacer";
        housing.sheet >= length - thread,
            "an M3x12 screw must not hit the end of its spacer's thread";
        display.sheet <= (length - grip) / 3.0, "an M3x12 screw must reach 2 mm into its spacer";
        display.sheet >= (length - thread) / 3.0,
            "an M3x12 screw must not hit the end of its spacer's thread";
        camera.spacer <= m2, "an M2x12 screw must reach through sheet, spacer, board and nut";
    }
}

/// Every sheet fits the stock, either way round.
pub fn check_sheets(p: &SheetMold, sensor: &Sensor, report: &mut Report) {
    // Length and width of each, the longer one first.
    let sizes: Vec<(&str, [f64; 2])> = sensor
        .parts()
        .filter(|part| part.kind == Kind::Made(Process::Laser))
        // What is printed instead need fit on a bed only.
        .filter(|part| p.making.process(&part.name, Process::Laser) == Process::Laser)
        .filter_map(|part| {
            let [x, y, _] = CompiledSolid::new(&part.solid).ok()?.bounds().size_mm();
            Some((part.name.as_str(), [x.max(y), x.min(y)]))
        })
        .collect();
    let length = ("stock.length", p.stock.length);
    let width = ("stock.width", p.stock.width);
    let by_size = if p.stock.length >= p.stock.width { [length, width] } else { [width, length] };
    for (side, (path, stock)) in by_size.into_iter().enumerate() {
        let largest = sizes.iter().max_by(|a, b| a.1[side].total_cmp(&b.1[side]));
        if let Some((name, size)) = largest {
            report.at_least(
                path,
                stock,
                size[side] + 2.0 * p.stock.margin.mm(),
                format!("`{name}` measures {:.1} x {:.1} mm", size[0], size[1]),
            );
        }
    }
}
