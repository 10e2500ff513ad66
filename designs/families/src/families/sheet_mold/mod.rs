//! Sheet-mold sensors: a soft interface with liquid channels over markers, cast between laser-cut sheets, on a box
//! with a camera, and a display that a second camera watches (Soter et al.).
//!
//! This file holds the layout, the screw joints and the deformable interface, on which all other files of the family
//! build.

mod chain;
mod constraints;
mod electronics;
mod housing;
mod layers;
mod parameters;

use fabkit_geometry::{
    FixtureGrip, LiquidChannel, LiquidSkin, Path, PlaneSurface, Pose, Process, Sensor,
};

use crate::blocks::lighting::marker_lighting;
use crate::blocks::listed_markers::FlatPattern;
use crate::blocks::{self, ScrewJoint, corners, hanging, mm, press_fit, upright};
use crate::chain_builder::{Name, names};
use crate::fits::Fit;
use crate::hardware::{HexNut, HexSpacer, Screw};
use crate::parameters::RuleReport;
use crate::{Family, FamilyOutput, Header, layout};
use housing::enclosed_air_mm3;
use layers::{Side, channel_liquids, left_channels};
use parameters::{NEEDLE, SheetMold, TUBE};

/// Sheet-mold family, whose built-in example is the fluidic sensor.
pub(crate) struct SheetMoldFamily;

impl Family for SheetMoldFamily {
    type Parameters = SheetMold;
    const NAME: &'static str = "sheet-mold";
    const SUMMARY: &'static str = "liquid channels over markers, cast between laser-cut sheets";
    const EXAMPLE: &'static str = "fluidic";
    const DEFAULTS: &'static [(&'static str, &'static str)] =
        &[("sheet-mold.yaml (defaults)", include_str!("defaults.yaml"))];

    fn check(parameters: &SheetMold, report: &mut RuleReport) {
        constraints::check(parameters, report);
    }

    fn build(p: &SheetMold, header: &Header, report: &mut RuleReport) -> Option<FamilyOutput> {
        let layout = SheetMoldLayout::new(p);
        let sensor = build_sensor(p, &layout, header);
        constraints::check_sheets(p, &sensor, report);
        let derived = derived_dimensions(p, &layout);
        let face = Some(housing::mount_face(p, &layout));
        report.is_clean().then_some(FamilyOutput { sensor, derived, face })
    }
}

/// Builds the sensor: all bodies, the circuit, press fits, casting steps, liquid channels and cameras.
fn build_sensor(p: &SheetMold, layout: &SheetMoldLayout, header: &Header) -> Sensor {
    let size = [p.camera.width_px, p.camera.height_px];
    // The camera looks up at the markers.
    let view = (p.camera.field_of_view, p.camera.projection);
    let camera = p.camera.optics.camera_at(layout.pupil_z_mm, size, view);
    let bodies = housing::mold_sheets(p, layout)
        .into_iter()
        .chain(housing::box_sheets(p, layout))
        .chain(housing::display_sheets(p, layout))
        .chain(layers::layers(p, layout))
        .chain(electronics::components(p, layout));
    let stretch_mm = (p.tubes.needle_outer_diameter.mm() - p.tubes.inner_diameter.mm()) / 2.0;
    let reason = "the tube is stretched over the needle";
    Sensor {
        chain: chain::chain(p, layout),
        circuits: vec![electronics::circuit(p, layout)],
        liquid: Some(liquid_skin(p, layout)),
        marks: housing::marks(p, layout),
        lightings: vec![
            marker_lighting(parameters::MARKER_PAINT, parameters::LED_STRIP),
            housing::display_lighting(p, layout),
        ],
        contrasts: vec![[parameters::MARKER_PAINT, parameters::MARKER_LAYER].map(String::from)],
        press_fits: vec![press_fit(NEEDLE, TUBE, stretch_mm, reason)],
        visible_bodies: names(&[parameters::MARKER_PAINT]),
        ..blocks::sensor(header, camera, bodies)
    }
}

/// Lists the derived dimensions that `fabkit show` prints.
fn derived_dimensions(p: &SheetMold, layout: &SheetMoldLayout) -> Vec<(String, String)> {
    let display_area_mm2 = p.display.channel_width.mm() * p.display.sheet.mm();
    vec![
        mm("thickness of the interface", layout.touch_z_mm),
        mm("height of the box with the interface", layout.touch_z_mm - layout.bottom_z_mm),
        mm("from the camera's pupil to the markers", layout.marker_end_z_mm - layout.pupil_z_mm),
        mm(
            "from the second pupil to the liquid",
            layout.display_pupil_z_mm - layout.cover_top_mm / 2.0,
        ),
        mm("smallest wall between two channels", constraints::thinnest_wall_mm(p)),
        ("water in the channels".into(), format!("{:.1} mm3", 2.0 * layers::side_volume_mm3(p))),
        ("water in one tube".into(), format!("{:.1} mm3", layers::tube_volume_mm3(p))),
        mm("travel in the display for 10 mm3", 10.0 / display_area_mm2),
        mm("length of the display", layout.display_size_mm[0]),
        mm("width of the display", layout.display_size_mm[1]),
    ]
}

// ------ Layout ------
//
// Heights, distances and poses that more than one part needs, each derived once.

/// Clearance between a spacer's corner and the wall beside it, mm.
const SPACER_GAP_MM: f64 = 0.3;

/// Free width of table between box and display, mm.
const DISPLAY_GAP_MM: f64 = 30.0;

layout! {
    /// Heights and distances, mm, in the sensor frame unless stated otherwise.
    ///
    /// z = 0 is the face of the marker layer on which the markers stand. They point down, towards the camera. The
    /// channels lie above.
    pub struct SheetMoldLayout from p: &SheetMold {
        /// Lower ends of the markers.
        marker_end_z_mm = -p.markers.height.mm();
        /// Interface between the two soft layers.
        bond_z_mm = p.marker_layer.thickness.mm();
        /// Top of the channels.
        channel_top_z_mm = bond_z_mm + p.channels.height.mm();
        /// Touched surface.
        touch_z_mm = channel_top_z_mm + p.channel_layer.roof.mm();

        /// Half the distance between two bolts.
        bolt_mm = p.plate.bolt_spacing.mm() / 2.0;
        /// Distance of the inner faces of the box's walls from its axis.
        wall_inner_mm = bolt_mm + HexSpacer::M3.corner_radius_mm() + SPACER_GAP_MM;
        let sheet = p.housing.sheet.mm();
        /// Distance of the outer faces of the box's walls from its axis.
        wall_outer_mm = wall_inner_mm + sheet;
        /// Lower face of the plate that carries the interface.
        ceiling_z_mm = -sheet;
        /// Upper face of the plate that carries the camera.
        floor_z_mm = ceiling_z_mm - p.housing.height.mm();
        /// Lower face of that plate. The display's lower face lies at the same height.
        bottom_z_mm = floor_z_mm - sheet;
        let pupil_above_seat =
            camera_board_top_mm(p) + p.camera.lens_height.mm() - p.camera.pupil_behind_front.mm();
        /// Entrance pupil of the camera below the markers.
        pupil_z_mm = floor_z_mm + pupil_above_seat;

        let border = 2.0 * p.display.border.mm();
        let across = f64::from(channel_count(p) - 1) * p.display.pitch.mm();
        /// Edge lengths of the display's sheets, along and across its channels.
        display_size_mm: [f64; 2] = [
            p.display.channel_length.mm() + 2.0 * border,
            // The bolts stand beyond the channels' ends.
            across + p.display.channel_width.mm() + border,
        ];
        /// Height of the display cover's upper face above the display's lower face.
        cover_top_mm = 3.0 * p.display.sheet.mm();
        /// Height of the lower face of the plate above the display, measured from the display's lower face.
        stand_z_mm = cover_top_mm + p.display.camera_spacer.mm();
        /// Height of the entrance pupil of the camera above the display, measured from the display's lower face.
        display_pupil_z_mm = stand_z_mm - pupil_above_seat;
        let y = p.plate.side.mm() / 2.0 + DISPLAY_GAP_MM + display_size_mm[1] / 2.0;
        /// Pose of the display's frame: origin at its centre on its lower face, x along the channels.
        sensor_from_display: Pose = Pose::translation(0.0, y, bottom_z_mm);
    }
}

impl SheetMoldLayout {
    /// Positions of the bolts in the corners of the square plates, mm.
    pub fn bolts(&self) -> [[f64; 2]; 4] {
        corners([self.bolt_mm, self.bolt_mm])
    }

    /// Positions of the bolts in the corners of the display, in its frame, mm.
    pub fn display_bolts(&self, p: &SheetMold) -> [[f64; 2]; 4] {
        let border = p.display.border.mm();
        corners([self.display_size_mm[0] / 2.0 - border, self.display_size_mm[1] / 2.0 - border])
    }
}

/// Number of channels on both sides together.
pub fn channel_count(p: &SheetMold) -> u32 {
    2 * p.channels.per_side
}

/// Centres of the markers, row by row or as listed, mm.
pub fn marker_centres(p: &SheetMold) -> Vec<[f64; 2]> {
    if p.markers.pattern == FlatPattern::List {
        return p.markers.listed().points_mm();
    }
    let n = p.markers.per_row;
    let at = |i: u32| (f64::from(i) - (f64::from(n) - 1.0) / 2.0) * p.markers.pitch.mm();
    (0..n).flat_map(|row| (0..n).map(move |column| [at(column), at(row)])).collect()
}

/// Half the diagonal of the field of markers that the camera below must see, mm.
pub fn marker_field_radius_mm(p: &SheetMold) -> f64 {
    if p.markers.pattern == FlatPattern::List {
        let out = p.markers.listed().points_mm().into_iter().map(|[x, y]| x.hypot(y));
        return out.fold(0.0, f64::max) + p.markers.diameter.mm() / 2.0;
    }
    let half = f64::from(p.markers.per_row - 1) * p.markers.pitch.mm() / 2.0;
    half * std::f64::consts::SQRT_2 + p.markers.diameter.mm() / 2.0
}

/// Half the longer and half the shorter edge of the field of markers, mm.
pub fn marker_field_half_mm(p: &SheetMold) -> [f64; 2] {
    let edge = p.markers.diameter.mm() / 2.0;
    if p.markers.pattern == FlatPattern::List {
        let points = p.markers.listed().points_mm().into_iter();
        let out = points
            .fold([0.0, 0.0], |[x, y]: [f64; 2], at| [x.max(at[0].abs()), y.max(at[1].abs())]);
        return [out[0].max(out[1]) + edge, out[0].min(out[1]) + edge];
    }
    [f64::from(p.markers.per_row - 1) * p.markers.pitch.mm() / 2.0 + edge; 2]
}

/// Half the longer and half the shorter edge of the display's field of channels, mm.
pub fn display_field_half_mm(p: &SheetMold) -> [f64; 2] {
    let along = p.display.channel_length.mm() / 2.0;
    let across = f64::from(channel_count(p) - 1) * p.display.pitch.mm() / 2.0
        + p.display.channel_width.mm() / 2.0;
    [along.max(across), along.min(across)]
}

/// Half the diagonal of the display's field of channels that the camera above must see, mm.
pub fn display_field_radius_mm(p: &SheetMold) -> f64 {
    let [long, short] = display_field_half_mm(p);
    long.hypot(short)
}

/// Radius of a sheet's holes for the M3 bolts that align and hold every stack, mm.
pub fn bolt_hole_mm(p: &SheetMold, sheet: Name) -> f64 {
    CORNER_FASTENERS.0.thread_mm / 2.0 + p.making.gap_mm(sheet, Process::Laser, Fit::Slide)
}

/// Distance from the plate that carries a camera to the far face of its board, mm.
pub fn camera_board_top_mm(p: &SheetMold) -> f64 {
    p.camera.spacer.mm() + p.camera.board_thickness.mm()
}

// ------ Joints ------
//
// Screws of the sensor and of its molds. Each joint is defined here and nowhere else.

/// Screw and nut in the corners of every stack of sheets. The molds borrow the sensor's screws.
pub const CORNER_FASTENERS: (Screw, HexNut) = (Screw::M3X12, HexNut::M3);

/// Screw and nut that hold the cameras.
pub const CAMERA_FASTENERS: (Screw, HexNut) = (Screw::M2X12, HexNut::M2);

/// All screw joints, in the sensor frame unless stated otherwise.
pub struct Joints {
    /// Bolts through the mold of the channel layer, and through that of the marker layer.
    pub stacks: [ScrewJoint; 2],
    /// Screws from above and below into the spacers of the box, corner by corner.
    pub housing: ScrewJoint,
    /// Screws from below and above into the spacers on the display, corner by corner, in its frame.
    pub display: ScrewJoint,
    /// Screws through plate, spacers and camera board, in the camera's frame: origin on the plate that carries it, z
    /// axis along the line of sight.
    pub camera: ScrewJoint,
}

impl Joints {
    /// Places the joints. The result is meaningful only for parameters that satisfy the family's constraints.
    pub fn new(p: &SheetMold, layout: &SheetMoldLayout) -> Self {
        let (screw, nut) = CORNER_FASTENERS;
        let (sheet, floor) = (p.housing.sheet.mm(), p.molds.floor.mm());
        let all = |at: [[f64; 2]; 4], pose: &dyn Fn([f64; 2]) -> Pose| at.map(pose).to_vec();
        let stack = |bottom_z: f64, top_z: f64| {
            let [heads, nuts] = [
                all(layout.bolts(), &|at| hanging(at, bottom_z)),
                all(layout.bolts(), &|at| upright(at, top_z)),
            ];
            ScrewJoint::in_hex_nuts("bolt", screw, heads, (nut, nuts))
        };
        let clamp_z = layout.bond_z_mm + p.housing.clamp.mm();
        let housing =
            layout.bolts().map(|at| [upright(at, clamp_z), hanging(at, layout.bottom_z_mm)]);
        let stand_z = layout.stand_z_mm + sheet;
        let display = layout.display_bolts(p).map(|at| [hanging(at, 0.0), upright(at, stand_z)]);
        let holes =
            corners([p.camera.hole_spacing, p.camera.hole_spacing_y].map(|edge| edge.mm() / 2.0));
        let nuts = all(holes, &|at| upright(at, camera_board_top_mm(p)));
        Self {
            stacks: [
                stack(layout.bond_z_mm - floor, layout.touch_z_mm),
                stack(layout.marker_end_z_mm - floor, layout.bond_z_mm),
            ],
            housing: ScrewJoint::in_threads("corner screw", screw, housing.concat()),
            display: ScrewJoint::in_threads("corner screw", screw, display.concat()),
            camera: ScrewJoint::in_hex_nuts(
                "camera screw",
                CAMERA_FASTENERS.0,
                all(holes, &|at| hanging(at, -sheet)),
                (CAMERA_FASTENERS.1, nuts),
            ),
        }
    }
}

// ------ Skin ------
//
// Deformable parts: the interface over the box's window, its channels, and the columns of liquid that they move.

/// Returns the deformable interface.
///
/// Channels are numbered as in the display: those of the left side, then those of the right one.
pub fn liquid_skin(p: &SheetMold, layout: &SheetMoldLayout) -> LiquidSkin {
    let channels = left_channels(p);
    let channel = |(name, liquid)| LiquidChannel {
        name,
        liquid,
        width_mm: p.channels.width.mm(),
        height_mm: p.channels.height.mm(),
        cover_mm: p.channel_layer.roof.mm(),
        column_mm2: p.display.channel_width.mm() * p.display.sheet.mm(),
        column_mm: p.display.rest_length.mm(),
        air_mm3: enclosed_air_mm3(p),
    };
    let box_outline = Path::rectangle([0.0; 2], [2.0 * layout.wall_outer_mm; 2], 0.0);
    let touch = PlaneSurface {
        outline: Path::rectangle([0.0; 2], [p.channel_layer.side.mm(); 2], 0.0),
        top_z_mm: layout.touch_z_mm,
        foot_z_mm: layout.bond_z_mm,
        max_indentation_mm: layout.touch_z_mm,
        grip: FixtureGrip {
            outline: box_outline,
            top_z_mm: layout.ceiling_z_mm,
            bottom_z_mm: layout.bottom_z_mm,
            clear_radius_mm: 0.0,
            key: None,
            threads: Vec::new(),
        },
    };
    LiquidSkin {
        touch: touch.into(),
        window_mm: [p.housing.window.mm(); 2],
        levels_mm: vec![0.0, layout.bond_z_mm, layout.channel_top_z_mm, layout.touch_z_mm],
        channels: Side::BOTH
            .into_iter()
            .flat_map(|side| channel_liquids(p, layout, &channels, side))
            .map(channel)
            .collect(),
    }
}
