//! What the parameters must fulfil together so that things fit, hold and can be made.

use std::f64::consts::SQRT_2;

use fabkit_geometry::{Body, Part, Process};

use super::channels::{Channel, Side, left_channels, spoke_radii_mm};
use super::components::led_top_mm;
use super::display::needle_hole_mm;
use super::housing::clamp_inner_mm;
use super::layout::{Layout, bolt_hole_mm, camera_board_top_mm, display_field_mm, marker_field_mm};
use super::parameters::{Arrangement, SheetMold};
use crate::fits::{Fit, gap_mm};
use crate::hardware::{HexSpacer, Screw};
use crate::materials::{castable, castable_names};
use crate::parameters::Report;

/// Thinnest web that a laser leaves in wood or acrylic, mm.
const CUT_WEB_MM: f64 = 1.0;

/// Least material around a bolt hole, mm.
const BOLT_WEB_MM: f64 = 2.5;

/// Least room around a tube in its channel, for glue, mm per side.
const GLUE_MM: f64 = 0.15;

/// Smallest overlap of the interface and what holds its rim, mm.
const GRIP_MM: f64 = 4.0;

/// Share of the image's half angle that may be used: the rim of an image is dark and soft.
const USED_VIEW: f64 = 0.95;

/// Smallest gap between parts that must not touch, mm.
const APART_MM: f64 = 0.3;

/// Reports every combination that cannot be built.
pub(super) fn check(p: &SheetMold, report: &mut Report) {
    let layout = Layout::new(p);
    materials(p, report);
    channels(p, report);
    markers(p, report);
    plates(p, &layout, report);
    housing(p, &layout, report);
    screws(p, report);
    tubes(p, report);
    display(p, &layout, report);
    cameras(p, &layout, report);
}

fn materials(p: &SheetMold, report: &mut Report) {
    for (path, name) in [
        ("channel_layer.material", &p.channel_layer.material),
        ("marker_layer.material", &p.marker_layer.material),
        ("markers.paint_material", &p.markers.paint_material),
        ("tubes.glue", &p.tubes.glue),
    ] {
        report.require(
            castable(name).is_some(),
            path,
            || format!("{path} is `{name}`, of which fabkit knows neither mix nor cure"),
            || format!("write one of {}", castable_names()),
        );
    }
}

/// Thinnest silicone between any two channels.
pub(super) fn thinnest_wall_mm(p: &SheetMold) -> f64 {
    let left = left_channels(p);
    let all: Vec<Channel> = Side::BOTH
        .into_iter()
        .flat_map(|side| left.iter().map(move |channel| channel.entering(side)))
        .collect();
    let pairs = all
        .iter()
        .enumerate()
        .flat_map(|(i, a)| all[i + 1..].iter().map(move |b| a.distance_to(b)));
    pairs.fold(f64::INFINITY, f64::min)
}

fn channels(p: &SheetMold, report: &mut Report) {
    let wall = p.channels.wall.mm();
    let is_grid = p.channels.arrangement == Arrangement::Grid;
    if is_grid {
        report.at_least(
            "channels.chamber_diameter",
            p.channels.chamber_diameter,
            p.channels.width.mm(),
            "a chamber is at least as wide as its channel",
            &["channels.width"],
        );
        // Past each chamber runs the channel of its neighbour.
        report.at_most(
            "channels.chamber_diameter",
            p.channels.chamber_diameter,
            2.0 * (p.channels.pitch.mm() - wall) - p.channels.width.mm(),
            "a chamber must leave a wall to the channel beside it",
            &["channels.pitch", "channels.wall", "channels.width"],
        );
    }
    report.at_most(
        "channels.width",
        p.channels.width,
        p.channels.pitch.mm() - wall,
        "channels must leave a wall between each other",
        &["channels.pitch", "channels.wall"],
    );
    let across = f64::from(p.channels.per_side - 1) * p.channels.pitch.mm();
    let widest = if is_grid { p.channels.chamber_diameter } else { p.channels.width }.mm();
    report.at_least(
        "channel_layer.side",
        p.channel_layer.side,
        across + widest + 2.0 * wall,
        "all channels of a side enter beside each other, with a wall outside of the last",
        &["channels.per_side", "channels.pitch", "channels.wall"],
    );
    // Along x: tube, straight piece, and what the arrangement puts behind it.
    let stub = p.tubes.insertion.mm() + p.channels.width.mm() / 2.0;
    let behind = match p.channels.arrangement {
        Arrangement::Straight => p.channels.width.mm() / 2.0 + wall / 2.0,
        // Two columns of chambers, their walls, and half a wall to the middle.
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
                &["channels.width", "channels.wall", "channels.per_side"],
            );
            start + p.channels.width.mm() / 2.0
        }
    };
    report.at_least(
        "channel_layer.side",
        p.channel_layer.side,
        2.0 * (stub + behind),
        format!(
            "channels in the arrangement `{}` need their length",
            p.channels.arrangement.word()
        ),
        &["tubes.insertion", "channels.width", "channels.arrangement"],
    );
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

fn markers(p: &SheetMold, report: &mut Report) {
    report.at_most(
        "markers.diameter",
        p.markers.diameter,
        p.markers.pitch.mm() - CUT_WEB_MM,
        "the mold keeps 1 mm of wood between two holes",
        &["markers.pitch"],
    );
    report.at_most(
        "markers.height",
        p.markers.height,
        2.5 * p.markers.diameter.mm(),
        "slender markers tear off in their mold",
        &["markers.diameter"],
    );
    let field = f64::from(p.markers.per_row - 1) * p.markers.pitch.mm() + p.markers.diameter.mm();
    report.at_least(
        "housing.window",
        p.housing.window,
        field + 2.0 * CUT_WEB_MM,
        "all markers hang in the window",
        &["markers.per_row", "markers.pitch", "markers.diameter"],
    );
}

fn plates(p: &SheetMold, layout: &Layout, report: &mut Report) {
    let hole = bolt_hole_mm();
    report.at_least(
        "marker_layer.side",
        p.marker_layer.side,
        2.0 * (clamp_inner_mm(p) + GRIP_MM),
        "the bars beside the channel layer must hold 4 mm of the marker layer",
        &["channel_layer.side", "housing.clamp_gap"],
    );
    report.at_least(
        "marker_layer.side",
        p.marker_layer.side,
        p.housing.window.mm() + 2.0 * GRIP_MM,
        "the marker layer rests on the rim of the window",
        &["housing.window"],
    );
    // Across the corner from the cavity's corner to the hole.
    report.at_least(
        "plate.bolt_spacing",
        p.plate.bolt_spacing,
        p.marker_layer.side.mm() + SQRT_2 * (hole + BOLT_WEB_MM),
        "bolts stand outside of the cavity's corners",
        &["marker_layer.side"],
    );
    report.at_least(
        "plate.side",
        p.plate.side,
        2.0 * (layout.wall_outer + gap_mm(Process::Laser, Fit::Slide) + BOLT_WEB_MM),
        "plates reach beyond the walls' slots, which lie outside of the bolts",
        &["plate.bolt_spacing", "housing.sheet"],
    );
    report.at_most(
        "plate.pry_depth",
        p.plate.pry_depth,
        (p.plate.side.mm() - p.marker_layer.side.mm()) / 2.0 - BOLT_WEB_MM,
        "the notches must not open the cavity",
        &["plate.side", "marker_layer.side"],
    );
    report.at_most(
        "plate.pry_width",
        p.plate.pry_width,
        p.plate.bolt_spacing.mm() - 4.0 * hole,
        "the notches lie between the bolts",
        &["plate.bolt_spacing"],
    );
}

fn housing(p: &SheetMold, layout: &Layout, report: &mut Report) {
    let spacer = HexSpacer::M3.corner_radius_mm();
    report.at_most(
        "housing.window",
        p.housing.window,
        2.0 * (layout.bolt - spacer),
        "the spacers in the corners bear on the ceiling outside of the window",
        &["plate.bolt_spacing"],
    );
    report.at_most(
        "housing.tab",
        p.housing.tab,
        layout.wall_inner - p.housing.cable_width.mm() - 2.0 * CUT_WEB_MM,
        "the cable leaves between a wall's two tabs",
        &["plate.bolt_spacing", "housing.cable_width"],
    );
    report.at_most(
        "housing.cable_height",
        p.housing.cable_height,
        led_top_mm(p) - p.housing.led_strip_width.mm() - APART_MM,
        "the LED strips lie above the cable",
        &["housing.led_strip_width"],
    );
    report.at_most(
        "housing.led_strip_length",
        p.housing.led_strip_length,
        2.0 * (layout.bolt - spacer),
        "the strips fit between the corner spacers",
        &["plate.bolt_spacing"],
    );
    report.at_most(
        "housing.led_strip_width",
        p.housing.led_strip_width,
        p.housing.height.mm() / 2.0,
        "the strips stay in the lower half of the box, out of the camera's sight",
        &["housing.height"],
    );
    report.at_most(
        "housing.clamp_gap",
        p.housing.clamp_gap,
        layout.bolt - bolt_hole_mm() - BOLT_WEB_MM - p.channel_layer.side.mm() / 2.0,
        "a bar reaches inwards from its bolts",
        &["plate.bolt_spacing", "channel_layer.side"],
    );
    report.at_least(
        "housing.height",
        p.housing.height,
        2.0 * HexSpacer::M3.thread_depth_mm,
        "the spacers have a thread at either end",
        &[],
    );
    let fingers = f64::from(p.housing.fingers);
    report.at_least(
        "housing.height",
        p.housing.height,
        fingers * p.housing.sheet.mm(),
        "fingers are at least as high as the sheet is thick",
        &["housing.fingers", "housing.sheet"],
    );
}

/// The M3 x 12 screws must reach their nuts and spacers, and not hit the end of the thread.
fn screws(p: &SheetMold, report: &mut Report) {
    let length = Screw::M3X12.length_mm;
    let thread = HexSpacer::M3.thread_depth_mm;
    let grip = 2.0;
    let above_floor = length - p.molds.floor.mm() - 2.4;
    report.at_most(
        "molds.floor",
        p.molds.floor,
        length - 2.4 - p.channels.height.mm() - p.channel_layer.roof.mm(),
        "an M3x12 screw must reach through the stack and its nut",
        &["channels.height", "channel_layer.roof"],
    );
    report.at_most(
        "markers.height",
        p.markers.height,
        above_floor - p.marker_layer.thickness.mm(),
        "an M3x12 screw must reach through the stack and its nut",
        &["molds.floor", "marker_layer.thickness"],
    );
    report.at_most(
        "housing.clamp",
        p.housing.clamp,
        length - grip - p.housing.sheet.mm() - p.marker_layer.thickness.mm(),
        "an M3x12 screw must reach 2 mm into its spacer",
        &["housing.sheet", "marker_layer.thickness"],
    );
    report.at_least(
        "housing.sheet",
        p.housing.sheet,
        length - thread,
        "an M3x12 screw must not hit the end of its spacer's thread",
        &[],
    );
    report.at_most(
        "display.sheet",
        p.display.sheet,
        (length - grip) / 3.0,
        "an M3x12 screw must reach 2 mm into its spacer",
        &[],
    );
    report.at_least(
        "display.sheet",
        p.display.sheet,
        (length - thread) / 3.0,
        "an M3x12 screw must not hit the end of its spacer's thread",
        &[],
    );
    let m2 = Screw::M2X12.length_mm - p.housing.sheet.mm() - p.camera.board_thickness.mm() - 1.6;
    report.at_most(
        "camera.spacer",
        p.camera.spacer,
        m2,
        "an M2x12 screw must reach through sheet, spacer, board and nut",
        &["housing.sheet", "camera.board_thickness"],
    );
}

fn tubes(p: &SheetMold, report: &mut Report) {
    report.at_most(
        "tubes.outer_diameter",
        p.tubes.outer_diameter,
        p.channels.width.mm().min(p.channels.height.mm()) - 2.0 * GLUE_MM,
        "a tube is glued into its channel with 0.15 mm of glue around it",
        &["channels.width", "channels.height"],
    );
    report.at_most(
        "tubes.inner_diameter",
        p.tubes.inner_diameter,
        p.tubes.outer_diameter.mm() - 0.4,
        "a tube needs a wall of 0.2 mm",
        &["tubes.outer_diameter"],
    );
    report.at_least(
        "tubes.needle_outer_diameter",
        p.tubes.needle_outer_diameter,
        p.tubes.inner_diameter.mm() + 0.05,
        "the tube must grip the needle",
        &["tubes.inner_diameter"],
    );
    report.at_most(
        "tubes.needle_outer_diameter",
        p.tubes.needle_outer_diameter,
        1.5 * p.tubes.inner_diameter.mm(),
        "the tube stretches by half at most",
        &["tubes.inner_diameter"],
    );
    report.at_most(
        "tubes.needle_inner_diameter",
        p.tubes.needle_inner_diameter,
        p.tubes.needle_outer_diameter.mm() - 0.2,
        "a needle needs a wall of 0.1 mm",
        &["tubes.needle_outer_diameter"],
    );
    report.at_least(
        "tubes.needle_length",
        p.tubes.needle_length,
        p.display.sheet.mm() + 3.0,
        "a tube needs 3 mm of needle above the cover",
        &["display.sheet"],
    );
}

fn display(p: &SheetMold, layout: &Layout, report: &mut Report) {
    report.at_most(
        "display.channel_width",
        p.display.channel_width,
        p.tubes.needle_outer_diameter.mm() - 0.2,
        "the needles stop on the channels' edges",
        &["tubes.needle_outer_diameter"],
    );
    report.at_least(
        "display.pitch",
        p.display.pitch,
        p.tubes.outer_diameter.mm() + 2.0 * APART_MM,
        "the tubes stand side by side on the display",
        &["tubes.outer_diameter"],
    );
    report.at_least(
        "display.pitch",
        p.display.pitch,
        p.display.channel_width.mm().max(2.0 * needle_hole_mm(p)) + CUT_WEB_MM,
        "channels and the holes above them keep 1 mm between each other",
        &["display.channel_width", "tubes.needle_outer_diameter"],
    );
    report.at_most(
        "display.rest_length",
        p.display.rest_length,
        p.display.channel_length.mm() - 2.0 * p.display.channel_width.mm(),
        "air must be left ahead of the liquid: it drives it back",
        &["display.channel_length", "display.channel_width"],
    );
    report.at_least(
        "display.rest_length",
        p.display.rest_length,
        2.0 * p.tubes.needle_outer_diameter.mm(),
        "the liquid ends in sight, off the needle",
        &["tubes.needle_outer_diameter"],
    );
    report.at_least(
        "display.border",
        p.display.border,
        HexSpacer::M3.corner_radius_mm() + BOLT_WEB_MM,
        "spacers stand between the channels and the edge",
        &[],
    );
    report.at_most(
        "camera.board_size",
        p.camera.board_size,
        layout.display_size[1].min(layout.display_size[0]) - 4.0 * p.display.border.mm(),
        "the board hangs between the spacers above the display",
        &["display.border", "display.pitch"],
    );
    report.at_most(
        "camera.hole_spacing",
        p.camera.hole_spacing,
        p.camera.board_size.mm() - Screw::M2X12.head_diameter_mm(),
        "the nuts bear on the board",
        &["camera.board_size"],
    );
}

fn cameras(p: &SheetMold, layout: &Layout, report: &mut Report) {
    let half_angle = USED_VIEW * p.camera.field_of_view.rad() / 2.0;
    let pupil =
        camera_board_top_mm(p) + p.camera.lens_height.mm() - p.camera.pupil_behind_front.mm();
    let below_markers = p.housing.sheet.mm() - p.markers.height.mm();
    report.at_least(
        "housing.height",
        p.housing.height,
        marker_field_mm(p) / half_angle.tan() + pupil - below_markers,
        "the camera must see every marker",
        &["camera.field_of_view", "camera.lens_height", "markers.pitch", "markers.per_row"],
    );
    report.at_least(
        "display.camera_spacer",
        p.display.camera_spacer,
        display_field_mm(p) / half_angle.tan() + pupil - p.display.sheet.mm(),
        "the second camera must see every channel of the display",
        &["camera.field_of_view", "camera.lens_height", "display.channel_length", "display.pitch"],
    );
    report.at_most(
        "camera.board_size",
        p.camera.board_size,
        SQRT_2 * (SQRT_2 * layout.bolt - HexSpacer::M3.corner_radius_mm() - APART_MM),
        "the board lies between the corner spacers",
        &["plate.bolt_spacing"],
    );
    report.at_most(
        "camera.pupil_behind_front",
        p.camera.pupil_behind_front,
        p.camera.lens_height.mm(),
        "the pupil lies in the lens",
        &["camera.lens_height"],
    );
    report.at_most(
        "camera.holder_height",
        p.camera.holder_height,
        p.camera.lens_height.mm() - 0.5,
        "the barrel stands out of its holder",
        &["camera.lens_height"],
    );
    report.at_most(
        "camera.holder_size",
        p.camera.holder_size,
        SQRT_2 * (p.camera.hole_spacing.mm() / SQRT_2 - 4.0 / f64::sqrt(3.0)),
        "the nuts lie beside the lens holder",
        &["camera.hole_spacing"],
    );
    report.at_most(
        "camera.barrel_diameter",
        p.camera.barrel_diameter,
        p.camera.holder_size.mm(),
        "the barrel stands on its holder",
        &["camera.holder_size"],
    );
}

/// Every sheet fits the stock, either way round.
pub(super) fn check_sheets(p: &SheetMold, parts: &[Part], report: &mut Report) {
    // Length and width of each, the longer one first.
    let sizes: Vec<(&str, [f64; 2])> = parts
        .iter()
        .filter(|part| part.process == Process::Laser)
        .filter_map(|part| {
            let [x, y, _] = Body::new(&part.solid).ok()?.bounds().size_mm();
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
                &["stock.margin"],
            );
        }
    }
}
