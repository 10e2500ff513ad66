//! Where things are: every height, distance and pose that more than one part needs, derived once.

use fabkit_geometry::{Pose, Process};

use super::joints::CORNER;
use super::parameters::SheetMold;
use crate::assembling::Name;
use crate::blocks::corners;
use crate::blocks::marks::FlatPattern;
use crate::fits::Fit;
use crate::hardware::HexSpacer;
use crate::layout;

/// Room between a spacer's corner and the wall beside it, mm.
const SPACER_GAP_MM: f64 = 0.3;

/// Free table between box and display, mm.
const DISPLAY_GAP_MM: f64 = 30.0;

layout! {
    /// Heights and distances, mm, sensor frame unless stated.
    ///
    /// z = 0 is the face of the marker layer that the markers stand on. They point down, toward the
    /// camera; the channels lie above.
    pub struct Layout from p: &SheetMold {
        /// Ends of the markers.
        marker_end_z_mm = -p.markers.height.mm();
        /// Between the two soft layers.
        bond_z_mm = p.marker_layer.thickness.mm();
        /// Top of the channels.
        channel_top_z_mm = bond_z_mm + p.channels.height.mm();
        /// The surface that is touched.
        touch_z_mm = channel_top_z_mm + p.channel_layer.roof.mm();

        /// Half the distance between two bolts.
        bolt_mm = p.plate.bolt_spacing.mm() / 2.0;
        /// Inside of the box's walls, from its axis.
        wall_inner_mm = bolt_mm + HexSpacer::M3.corner_radius_mm() + SPACER_GAP_MM;
        let sheet = p.housing.sheet.mm();
        /// Outside of the box's walls.
        wall_outer_mm = wall_inner_mm + sheet;
        /// Underside of the plate that carries the interface.
        ceiling_z_mm = -sheet;
        /// Top of the plate that carries the camera.
        floor_z_mm = ceiling_z_mm - p.housing.height.mm();
        /// Underside of that plate; the display's lies at the same height.
        bottom_z_mm = floor_z_mm - sheet;
        let pupil_above_seat =
            camera_board_top_mm(p) + p.camera.lens_height.mm() - p.camera.pupil_behind_front.mm();
        /// Entrance pupil of the camera below the markers.
        pupil_z_mm = floor_z_mm + pupil_above_seat;

        let border = 2.0 * p.display.border.mm();
        let across = f64::from(channel_count(p) - 1) * p.display.pitch.mm();
        /// Edges of the display's sheets, along and across its channels.
        display_size_mm: [f64; 2] = [
            p.display.channel_length.mm() + 2.0 * border,
            // The bolts stand beyond the channels' ends.
            across + p.display.channel_width.mm() + border,
        ];
        /// Top of the display's cover above its underside.
        cover_top_mm = 3.0 * p.display.sheet.mm();
        /// Underside of the plate above the display, above the display's underside.
        stand_z_mm = cover_top_mm + p.display.camera_spacer.mm();
        /// Entrance pupil of the camera above the display, above the display's underside.
        display_pupil_z_mm = stand_z_mm - pupil_above_seat;
        let y = p.plate.side.mm() / 2.0 + DISPLAY_GAP_MM + display_size_mm[1] / 2.0;
        /// The display's frame: its centre, on its underside, x along the channels.
        sensor_from_display: Pose = Pose::translation(0.0, y, bottom_z_mm);
    }
}

impl Layout {
    /// Corners where bolts stand: of the square plates.
    pub fn bolts(&self) -> [[f64; 2]; 4] {
        corners([self.bolt_mm, self.bolt_mm])
    }

    /// Corners where bolts stand, in the display's frame.
    pub fn display_bolts(&self, p: &SheetMold) -> [[f64; 2]; 4] {
        let border = p.display.border.mm();
        corners([self.display_size_mm[0] / 2.0 - border, self.display_size_mm[1] / 2.0 - border])
    }
}

/// Number of channels, left and right together.
pub fn channel_count(p: &SheetMold) -> u32 {
    2 * p.channels.per_side
}

/// Centres of the markers, row by row or as listed.
pub fn marker_centres(p: &SheetMold) -> Vec<[f64; 2]> {
    if p.markers.pattern == FlatPattern::List {
        return p.markers.listed().points_mm();
    }
    let n = p.markers.per_row;
    let at = |i: u32| (f64::from(i) - (f64::from(n) - 1.0) / 2.0) * p.markers.pitch.mm();
    (0..n).flat_map(|row| (0..n).map(move |column| [at(column), at(row)])).collect()
}

/// Half the diagonal of what the camera below must see, mm.
pub fn marker_field_mm(p: &SheetMold) -> f64 {
    if p.markers.pattern == FlatPattern::List {
        let out = p.markers.listed().points_mm().into_iter().map(|[x, y]| x.hypot(y));
        return out.fold(0.0, f64::max) + p.markers.diameter.mm() / 2.0;
    }
    let half = f64::from(p.markers.per_row - 1) * p.markers.pitch.mm() / 2.0;
    half * std::f64::consts::SQRT_2 + p.markers.diameter.mm() / 2.0
}

/// Half the longer and half the shorter edge of what the camera before the markers must see, mm.
pub fn marker_edges_mm(p: &SheetMold) -> [f64; 2] {
    let edge = p.markers.diameter.mm() / 2.0;
    if p.markers.pattern == FlatPattern::List {
        let points = p.markers.listed().points_mm().into_iter();
        let out = points
            .fold([0.0, 0.0], |[x, y]: [f64; 2], at| [x.max(at[0].abs()), y.max(at[1].abs())]);
        return [out[0].max(out[1]) + edge, out[0].min(out[1]) + edge];
    }
    [f64::from(p.markers.per_row - 1) * p.markers.pitch.mm() / 2.0 + edge; 2]
}

/// The same of the camera above the display.
pub fn display_edges_mm(p: &SheetMold) -> [f64; 2] {
    let along = p.display.channel_length.mm() / 2.0;
    let across = f64::from(channel_count(p) - 1) * p.display.pitch.mm() / 2.0
        + p.display.channel_width.mm() / 2.0;
    [along.max(across), along.min(across)]
}

/// Half the diagonal of what the camera above the display must see, mm.
pub fn display_field_mm(p: &SheetMold) -> f64 {
    let [long, short] = display_edges_mm(p);
    long.hypot(short)
}

/// Radius of a sheet's holes for the M3 bolts that align and hold every stack, mm.
pub fn bolt_hole_mm(p: &SheetMold, sheet: Name) -> f64 {
    CORNER.0.thread_mm / 2.0 + p.making.gap_mm(sheet, Process::Laser, Fit::Slide)
}

/// From the plate that carries a camera to the far side of its board, mm.
pub fn camera_board_top_mm(p: &SheetMold) -> f64 {
    p.camera.spacer.mm() + p.camera.board_thickness.mm()
}
