//! Constraints between parameters: parts must fit, hold, and be manufacturable.

use std::f64::consts::SQRT_2;

use fabkit_geometry::{BodyKind, CompiledSolid, Process, Sensor};

use super::electronics::{self, led_top_mm};
use super::housing::{clamp_inner_mm, needle_hole_mm, seal_end_x};
use super::layers::{Channel, Side, left_channels, spoke_radii_mm};
use super::parameters::*;
use super::{
    CAMERA_FASTENERS, CORNER_FASTENERS, SheetMoldLayout, bolt_hole_mm, camera_board_top_mm,
    display_field_half_mm, display_field_radius_mm, marker_field_half_mm, marker_field_radius_mm,
};
use crate::blocks::listed_markers::FlatPattern;
use crate::fits::Fit;
use crate::hardware::HexSpacer;
use crate::parameters::{RuleReport, limits};

/// Minimum width of a web that a laser leaves in wood or acrylic, mm.
const CUT_WEB_MM: f64 = 1.0;

/// Minimum width of material around a bolt hole, mm.
const BOLT_WEB_MM: f64 = 2.5;

/// Minimum gap for glue around a tube in its channel, mm per side.
const GLUE_MM: f64 = 0.15;

/// Minimum overlap of the interface and the parts that hold its rim, mm.
const GRIP_MM: f64 = 4.0;

/// Usable share of the image's half angle: the rim of an image is dark and soft.
const USABLE_ANGLE_SHARE: f64 = 0.95;

/// Minimum gap between parts that must not touch, mm.
const APART_MM: f64 = 0.3;

/// Reports every combination of parameters that cannot be built.
pub(super) fn check(p: &SheetMold, report: &mut RuleReport) {
    let layout = SheetMoldLayout::new(p);
    check_channels(p, report);
    check_markers(p, report);
    check_plates(p, &layout, report);
    check_housing(p, &layout, report);
    check_screws(p, report);
    check_tubes(p, report);
    check_display(p, &layout, report);
    check_cameras(p, &layout, report);
    electronics::check_cables(p, &layout, report);
}

/// Minimum thickness of silicone between any two channels, mm.
pub(super) fn thinnest_wall_mm(p: &SheetMold) -> f64 {
    let left = left_channels(p);
    let all: Vec<Channel> = Side::BOTH
        .into_iter()
        .flat_map(|side| left.iter().map(move |channel| channel.mirrored_to(side)))
        .collect();
    let pairs = all
        .iter()
        .enumerate()
        .flat_map(|(i, a)| all[i + 1..].iter().map(move |b| a.distance_to(b)));
    pairs.fold(f64::INFINITY, f64::min)
}

fn check_channels(p: &SheetMold, report: &mut RuleReport) {
    let wall = p.channels.wall.mm();
    let is_grid = p.channels.arrangement == Arrangement::Grid;
    if is_grid {
        limits! { report, p:
            channels.chamber_diameter >= p.channels.width.mm(),
                "a chamber is at least as wide as its channel";
            // The neighbour's channel runs past each chamber.
            channels.chamber_diameter <=
                2.0 * (p.channels.pitch.mm() - wall) - p.channels.width.mm(),
                "a chamber must leave a wall to the channel beside it";
        }
    }
    let across = f64::from(p.channels.per_side - 1) * p.channels.pitch.mm();
    let widest = if is_grid { p.channels.chamber_diameter } else { p.channels.width }.mm();
    // Length along x: the tube, a straight piece, and the rest that depends on the arrangement.
    let stub = p.tubes.insertion.mm() + p.channels.width.mm() / 2.0;
    let behind = match p.channels.arrangement {
        Arrangement::Straight => p.channels.width.mm() / 2.0 + wall / 2.0,
        // Two columns of chambers, their walls, and half a wall up to the middle.
        Arrangement::Grid => 1.5 * (widest + wall),
        Arrangement::Radial => {
            let middle = p.channels.per_side / 2;
            let [start, end] = [middle - 1, middle]
                .map(|k| spoke_radii_mm(p, k))
                .into_iter()
                .fold([0.0_f64; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])]);
            report.at_least(
                "channels.pitch",
                p.channels.pitch,
                p.channels.pitch.mm() * (end + p.channels.width.mm() / 2.0) / start,
                "short spokes must begin outside of where they end",
            );
            start + p.channels.width.mm() / 2.0
        }
    };
    limits! { report, p:
        channels.width <= p.channels.pitch.mm() - wall,
            "channels must leave a wall between each other";
        channel_layer.side >= across + widest + 2.0 * wall,
            "all channels of a side enter beside each other, with a wall outside of the last";
        channel_layer.side >= 2.0 * (stub + behind),
            format!(
                "channels in the arrangement `{}` need their length",
                p.channels.arrangement.word()
            );
    }
    let is_radial = p.channels.arrangement == Arrangement::Radial;
    report.require(
        !is_radial || p.channels.per_side.is_multiple_of(2),
        "channels.per_side",
        || {
            format!(
                "channels.per_side is {}; it must be even, because long and short spokes take \
                 turns all the way round",
                p.channels.per_side
            )
        },
        || format!("write {}, or another arrangement", p.channels.per_side - 1),
    );
    let thinnest = thinnest_wall_mm(p);
    report.require(
        thinnest >= wall - 1e-9,
        "channels.arrangement",
        || {
            format!(
                "channels of the arrangement `{}` come within {:.3} mm of each other; the wall \
                 between them must be at least {} (channels.wall)",
                p.channels.arrangement.word(),
                thinnest,
                p.channels.wall
            )
        },
        || {
            format!(
                "write `straight`, or make `channels.width` at most {:.3} mm",
                (p.channels.width.mm() + thinnest - wall).max(0.0)
            )
        },
    );
}

fn check_markers(p: &SheetMold, report: &mut RuleReport) {
    let is_listed = p.markers.pattern == FlatPattern::List;
    if is_listed {
        check_listed_markers(p, report);
    } else {
        limits! { report, p:
            markers.diameter <= p.markers.pitch.mm() - CUT_WEB_MM,
                "the mold keeps 1 mm of wood between two holes";
        }
    }
    limits! { report, p:
        markers.height <= 2.5 * p.markers.diameter.mm(), "slender markers tear off in their mold";
    }
    if !is_listed {
        let field =
            f64::from(p.markers.per_row - 1) * p.markers.pitch.mm() + p.markers.diameter.mm();
        limits! { report, p:
            housing.window >= field + 2.0 * CUT_WEB_MM, "all markers hang in the window";
        }
    }
}

/// Checks listed markers: in the window, and apart from each other.
fn check_listed_markers(p: &SheetMold, report: &mut RuleReport) {
    let listed = p.markers.listed();
    listed.check_lengths(report);
    let most = (p.housing.window.mm() - p.markers.diameter.mm()) / 2.0 - CUT_WEB_MM;
    let window = ("all markers hang in the window", "`housing.window` or `markers.diameter`");
    for axis in [0, 1] {
        listed.check_within(axis, most, window, report);
    }
    let web = ("the mold keeps 1 mm of wood between two holes", "`markers.diameter`");
    listed.check_apart_on_plane(p.markers.diameter.mm() + CUT_WEB_MM, web, report);
}

// ------ Rigid ------
//
// Plates, box and screws.

pub(super) fn check_plates(p: &SheetMold, layout: &SheetMoldLayout, report: &mut RuleReport) {
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
    let slide = p.making.widest_gap_mm(slotted, Fit::Slide);
    limits! { report, p:
        marker_layer.side >= 2.0 * (clamp_inner_mm(p) + GRIP_MM),
            "the bars beside the channel layer must hold 4 mm of the marker layer";
        marker_layer.side >= p.housing.window.mm() + 2.0 * GRIP_MM,
            "the marker layer rests on the rim of the window";
        // Measured across the corner, from the cavity's corner to the hole.
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

pub(super) fn check_housing(p: &SheetMold, layout: &SheetMoldLayout, report: &mut RuleReport) {
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

/// Checks that the M3 x 12 screws reach their nuts and spacers, and do not hit the end of a thread.
pub(super) fn check_screws(p: &SheetMold, report: &mut RuleReport) {
    let (screw, nut) = CORNER_FASTENERS;
    let length = screw.length_mm;
    let thread = HexSpacer::M3.thread_depth_mm;
    let grip = 2.0;
    let above_floor = length - p.molds.floor.mm() - nut.height_mm;
    let m2 = CAMERA_FASTENERS.0.length_mm
        - p.housing.sheet.mm()
        - p.camera.board_thickness.mm()
        - CAMERA_FASTENERS.1.height_mm;
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

/// Checks that every sheet fits the stock, in either orientation.
pub fn check_sheets(p: &SheetMold, sensor: &Sensor, report: &mut RuleReport) {
    // Length and width of each sheet, the longer one first.
    let sizes: Vec<(&str, [f64; 2])> = sensor
        .parts()
        .filter(|part| part.kind == BodyKind::Made(Process::Laser))
        // Sheets that are printed instead only have to fit on a printer's bed.
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

// ------ Readout ------
//
// Tubes, display and the two cameras.

/// Usable share of the image's half sides. The rest covers tolerances of lens and chip.
const USABLE_SIDE_SHARE: f64 = 0.96;

pub(super) fn check_tubes(p: &SheetMold, report: &mut RuleReport) {
    limits! { report, p:
        tubes.outer_diameter <= p.channels.width.mm().min(p.channels.height.mm()) - 2.0 * GLUE_MM,
            "a tube is glued into its channel with 0.15 mm of glue around it";
        tubes.inner_diameter <= p.tubes.outer_diameter.mm() - 0.4, "a tube needs a wall of 0.2 mm";
        tubes.needle_outer_diameter >= p.tubes.inner_diameter.mm() + 0.05,
            "the tube must grip the needle";
        tubes.needle_outer_diameter <= 1.5 * p.tubes.inner_diameter.mm(),
            "the tube stretches by half at most";
        tubes.needle_inner_diameter <= p.tubes.needle_outer_diameter.mm() - 0.2,
            "a needle needs a wall of 0.1 mm";
        tubes.needle_length >= p.display.sheet.mm() + 3.0,
            "a tube needs 3 mm of needle above the cover";
    }
}

pub(super) fn check_display(p: &SheetMold, layout: &SheetMoldLayout, report: &mut RuleReport) {
    let beside_spacers =
        layout.display_size_mm[1].min(layout.display_size_mm[0]) - 4.0 * p.display.border.mm();
    limits! { report, p:
        display.channel_width <= p.tubes.needle_outer_diameter.mm() - 0.2,
            "the needles stop on the channels' edges";
        display.pitch >= p.tubes.outer_diameter.mm() + 2.0 * APART_MM,
            "the tubes stand side by side on the display";
        display.pitch >= p.display.channel_width.mm().max(2.0 * needle_hole_mm(p)) + CUT_WEB_MM,
            "channels and the holes above them keep 1 mm between each other";
        display.rest_length <= p.display.channel_length.mm() - 2.0 * p.display.channel_width.mm(),
            "air must be left ahead of the liquid: it drives it back";
        display.rest_length <= p.display.channel_length.mm() / 2.0 - seal_end_x(p),
            "the liquid ends in sight, before the strip that closes the vents";
        display.rest_length >= 2.0 * p.tubes.needle_outer_diameter.mm(),
            "the liquid ends in sight, off the needle";
        display.border >= HexSpacer::M3.corner_radius_mm() + BOLT_WEB_MM,
            "spacers stand between the channels and the edge";
        camera.board_size <= beside_spacers,
            "the board hangs between the spacers above the display";
        camera.board_size_y <= beside_spacers,
            "the board hangs between the spacers above the display";
        camera.hole_spacing <= p.camera.board_size.mm() - CAMERA_FASTENERS.0.head_diameter_mm(),
            "the nuts bear on the board";
        camera.hole_spacing_y <= p.camera.board_size_y.mm() - CAMERA_FASTENERS.0.head_diameter_mm(),
            "the nuts bear on the board";
    }
}

pub(super) fn check_cameras(p: &SheetMold, layout: &SheetMoldLayout, report: &mut RuleReport) {
    let half_angle = USABLE_ANGLE_SHARE * p.camera.field_of_view.rad() / 2.0;
    let pupil =
        camera_board_top_mm(p) + p.camera.lens_height.mm() - p.camera.pupil_behind_front.mm();
    let below_markers = p.housing.sheet.mm() - p.markers.height.mm();
    let beside_spacers =
        SQRT_2 * (SQRT_2 * layout.bolt_mm - HexSpacer::M3.corner_radius_mm() - APART_MM);
    // Distances at which the corners and the sides of the field lie within the image.
    let away_mm =
        |field: f64, edges| (field / half_angle.tan()).max(min_image_distance_mm(p, edges));
    let markers_mm = away_mm(marker_field_radius_mm(p), marker_field_half_mm(p));
    let channels_mm = away_mm(display_field_radius_mm(p), display_field_half_mm(p));
    // Nuts that clear the holder along one axis clear it altogether.
    let spacing = p.camera.hole_spacing.mm().max(p.camera.hole_spacing_y.mm());
    limits! { report, p:
        housing.height >= markers_mm + pupil - below_markers, "the camera must see every marker";
        display.camera_spacer >= channels_mm + pupil - p.display.sheet.mm(),
            "the second camera must see every channel of the display";
        camera.board_size <= beside_spacers, "the board lies between the corner spacers";
        camera.board_size_y <= beside_spacers, "the board lies between the corner spacers";
        camera.pupil_behind_front <= p.camera.lens_height.mm(), "the pupil lies in the lens";
        camera.holder_height <= p.camera.lens_height.mm() - 0.5,
            "the barrel stands out of its holder";
        camera.holder_size <=
            spacing - SQRT_2 * CAMERA_FASTENERS.1.across_flats_mm / f64::sqrt(3.0),
            "the nuts lie beside the lens holder";
        camera.barrel_diameter <= p.camera.holder_size.mm(), "the barrel stands on its holder";
    }
}

/// Minimum distance of a camera from a field with these half edges, mm, so that the field lies within the image's
/// width and height. The lens is taken as equidistant, with the angle of view over the diagonal, as the maker states it.
fn min_image_distance_mm(p: &SheetMold, half_mm: [f64; 2]) -> f64 {
    let mut pixels = [p.camera.width_px, p.camera.height_px].map(f64::from);
    pixels.sort_by(|a, b| b.total_cmp(a));
    let half_view = USABLE_SIDE_SHARE * p.camera.field_of_view.rad() / 2.0;
    let angles = pixels.map(|side| half_view * side / pixels[0].hypot(pixels[1]));
    (half_mm[0] / angles[0].tan()).max(half_mm[1] / angles[1].tan())
}
