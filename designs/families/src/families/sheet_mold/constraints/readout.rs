//! Tubes, display and the two cameras.

use std::f64::consts::SQRT_2;

use super::{APART_MM, BOLT_WEB_MM, CUT_WEB_MM, GLUE_MM, USED_VIEW};
use crate::families::sheet_mold::display::{needle_hole_mm, seal_end_x};
use crate::families::sheet_mold::joints::CAMERA;
use crate::families::sheet_mold::layout::{
    Layout, camera_board_top_mm, display_edges_mm, display_field_mm, marker_edges_mm,
    marker_field_mm,
};
use crate::families::sheet_mold::parameters::SheetMold;
use crate::hardware::HexSpacer;
use crate::parameters::{Report, limits};

/// Share of the picture's half sides that is used: the rest is for tolerances of lens and chip.
const USED_SIDES: f64 = 0.96;

pub(super) fn tubes(p: &SheetMold, report: &mut Report) {
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

pub(super) fn display(p: &SheetMold, layout: &Layout, report: &mut Report) {
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
        camera.hole_spacing <= p.camera.board_size.mm() - CAMERA.0.head_diameter_mm(),
            "the nuts bear on the board";
        camera.hole_spacing_y <= p.camera.board_size_y.mm() - CAMERA.0.head_diameter_mm(),
            "the nuts bear on the board";
    }
}

pub(super) fn cameras(p: &SheetMold, layout: &Layout, report: &mut Report) {
    let half_angle = USED_VIEW * p.camera.field_of_view.rad() / 2.0;
    let pupil =
        camera_board_top_mm(p) + p.camera.lens_height.mm() - p.camera.pupil_behind_front.mm();
    let below_markers = p.housing.sheet.mm() - p.markers.height.mm();
    let beside_spacers =
        SQRT_2 * (SQRT_2 * layout.bolt_mm - HexSpacer::M3.corner_radius_mm() - APART_MM);
    // Out to the corners, and to the sides of the picture.
    let away_mm = |field: f64, edges| (field / half_angle.tan()).max(across_picture_mm(p, edges));
    let markers_mm = away_mm(marker_field_mm(p), marker_edges_mm(p));
    let channels_mm = away_mm(display_field_mm(p), display_edges_mm(p));
    // Beside the holder in one direction is beside it.
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
            spacing - SQRT_2 * CAMERA.1.across_flats_mm / f64::sqrt(3.0),
            "the nuts lie beside the lens holder";
        camera.barrel_diameter <= p.camera.holder_size.mm(), "the barrel stands on its holder";
    }
}

/// How far a camera must be from what has these half edges (mm), so that they lie within its picture's
/// width and height: an equidistant lens, as the maker states its view over the diagonal.
fn across_picture_mm(p: &SheetMold, half_mm: [f64; 2]) -> f64 {
    let mut pixels = [p.camera.width_px, p.camera.height_px].map(f64::from);
    pixels.sort_by(|a, b| b.total_cmp(a));
    let half_view = USED_SIDES * p.camera.field_of_view.rad() / 2.0;
    let angles = pixels.map(|side| half_view * side / pixels[0].hypot(pixels[1]));
    (half_mm[0] / angles[0].tan()).max(half_mm[1] / angles[1].tan())
}
