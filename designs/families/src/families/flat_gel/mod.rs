//! Flat-gel sensors: a coated pad of gel on a clear plate above a camera (9DTact, DIGIT, GelSight).
//!
//! This file holds the layout, on which all other files of the family build.

mod chain;
mod constraints;
mod pad;
mod parameters;

use fabkit_geometry::{Angle, Body, Lighting, NominalCamera, PlaneSurface, Pose, Process, Sensor};

use crate::blocks::adapter::MountFace;
use crate::blocks::chamber_light::ChamberLight;
use crate::blocks::clamshell::Clamshell;
use crate::blocks::lighting::{slope_lighting, thickness_lighting};
use crate::blocks::marker_grid::MARKERS;
use crate::blocks::posted_camera::PlacedCamera;
use crate::blocks::{self, Rect, merged, mm};
use crate::chain_builder::{SENSOR, in_sensor, visible_layers};
use crate::fits::Fit;
use crate::materials::Clarity;
use crate::parameters::RuleReport;
use crate::{Family, FamilyOutput, Header};
use parameters::{BASE, FlatGel, SHELL};

/// Flat-gel family, which covers 9DTact, DIGIT and GelSight.
pub(crate) struct FlatGelFamily;

impl Family for FlatGelFamily {
    type Parameters = FlatGel;
    const NAME: &'static str = "flat-gel";
    const SUMMARY: &'static str = "a coated pad of gel on a clear plate above a camera";
    const EXAMPLE: &'static str = "9dtact";
    const DEFAULTS: &'static [(&'static str, &'static str)] =
        &[("flat-gel.yaml (defaults)", include_str!("defaults.yaml"))];

    fn check(parameters: &FlatGel, report: &mut RuleReport) {
        constraints::check(parameters, report);
    }

    fn build(parameters: &FlatGel, header: &Header, _: &mut RuleReport) -> Option<FamilyOutput> {
        let layout = FlatGelLayout::new(parameters);
        let sensor = build_sensor(parameters, header, &layout);
        let housing = &layout.housing;
        let face = MountFace {
            holder: BASE,
            mounting: housing.mounting(),
            replaced_screw_mm: None,
            bottom_z_mm: housing.bottom_z,
            outline: housing.outside,
            exits: vec![housing.exit()],
            heads: Vec::new(),
        };
        Some(FamilyOutput {
            derived: derived_dimensions(&sensor, &layout),
            sensor,
            face: Some(face),
        })
    }
}

/// Builds the sensor: all bodies, the circuit, press fits, casting steps and the camera.
fn build_sensor(p: &FlatGel, header: &Header, layout: &FlatGelLayout) -> Sensor {
    let (housing, board) = (&layout.housing, &layout.camera);
    let mounting = housing.mounting();
    // Only nuts are pressed in; other mounting holes take a user's screws.
    let inserts = mounting.nut_name().and_then(|_| mounting.press_fit(BASE));
    let fits = [housing.joint().press_fit(SHELL), board.joint().press_fit(BASE), inserts];
    let bodies = housing_parts(layout)
        .into_iter()
        .chain([pad::plate(p, layout)])
        .chain(layout.light.bodies(SENSOR))
        .chain(pad::tools(p, layout))
        .chain(pad::layers(p, layout))
        .chain(camera_and_screws(layout));
    Sensor {
        chain: chain::chain(p, layout),
        circuits: vec![layout.light.circuit()],
        press_fits: fits
            .into_iter()
            .flatten()
            .chain([pad::frames(p, layout).press_fit()])
            .collect(),
        touch: Some(touch_surface(p, layout).into()),
        marks: p.markers.marks(layout.gel_top_z_mm),
        lightings: vec![lighting(p, layout)],
        visible_bodies: visible_layers(&[(parameters::GEL, &p.pad.material)], parameters::COAT),
        ..blocks::sensor(header, nominal_camera(layout), bodies)
    }
}

/// Returns the relation between indentation and intensity. A translucent gel scatters light, so intensity depends on
/// its thickness; a clear gel lets light through to the coat, so intensity depends on the coat's slopes.
fn lighting(p: &FlatGel, layout: &FlatGelLayout) -> Lighting {
    match p.pad.material.material().figures.clarity {
        Some(Clarity::Translucent) => thickness_lighting([parameters::GEL]),
        _ => slope_lighting(
            parameters::COAT,
            p.markers.has_dots().then_some(MARKERS),
            layout.light.colors(),
        ),
    }
}

/// Nominal camera, turned so that the long side of its image lies along that of the pad.
fn nominal_camera(layout: &FlatGelLayout) -> NominalCamera {
    let c = layout.camera.camera;
    let size = c.images.size_px();
    let camera = c.view.camera_at(layout.camera.pupil_z, size);
    // Turned if the image is wide and the pad is long along y, or the other way round.
    let turned = layout.pad.longer() == usize::from(size[0] >= size[1]);
    let quarter = Angle::from_deg(if turned { 90.0 } else { 0.0 }).expect("finite");
    let sensor_from_camera = camera.sensor_from_camera.then_in(Pose::rotation_z(quarter));
    NominalCamera { sensor_from_camera, ..camera }
}

/// Returns shell and base.
fn housing_parts(layout: &FlatGelLayout) -> [Body; 2] {
    let (housing, light, over) = (&layout.housing, &layout.light, fabkit_geometry::CUT_OVERLAP_MM);
    let opening = layout.opening.prism([layout.plate_bottom_z_mm, over]).named("plate opening");
    let chamber = light.chamber.prism([light.step_z() - over, layout.plate_bottom_z_mm + over]);
    let cut = [opening, chamber.named("chamber")];
    [
        housing.shell(SHELL, cut, light.step_z()).placed([in_sensor()]),
        housing
            .base(BASE, layout.camera.posts())
            .cut(layout.camera.joint().thread_cut().without_landmarks())
            .placed([in_sensor().lifted(-46.0)]),
    ]
}

/// Returns the bought parts of the housing: camera, screws and nuts.
fn camera_and_screws(layout: &FlatGelLayout) -> Vec<Body> {
    let lifted = |z_mm: f64| move |pose: &Pose| SENSOR.at(*pose).lifted(z_mm);
    let camera = layout.camera.body().placed([in_sensor().lifted(-34.0)]);
    let screws = [
        layout.camera.joint().bought(lifted(-27.0), lifted(0.0)),
        layout.housing.joint().bought(lifted(-60.0), lifted(0.0)),
        layout.housing.mounting().bought_nuts(lifted(-60.0)).into_iter().collect(),
    ];
    merged([camera].into_iter().chain(screws.into_iter().flatten()))
}

/// Share of its thickness up to which a gel is measurably soft if it lies directly on the plate. Beyond, it stiffens.
const SOFT_SHARE: f64 = 0.5;

/// Returns the touched surface, and the part of the housing that fixtures grip.
fn touch_surface(p: &FlatGel, layout: &FlatGelLayout) -> PlaneSurface {
    PlaneSurface {
        outline: layout.pad.path(),
        top_z_mm: layout.top_z_mm,
        foot_z_mm: 0.0,
        max_indentation_mm: if p.bed.thickness.mm() > 0.0 { 1.0 } else { SOFT_SHARE }
            * layout.gel_top_z_mm,
        grip: layout.housing.grip(),
    }
}

/// Lists the derived dimensions that `fabkit show` prints.
fn derived_dimensions(sensor: &Sensor, layout: &FlatGelLayout) -> Vec<(String, String)> {
    let by = |name: &str, [x, y]: [f64; 2]| {
        (name.to_owned(), format!("{:.3} x {:.3} mm", 2.0 * x, 2.0 * y))
    };
    let count = |name: &str, label: &str| {
        let body = sensor.body(name).map_or(0, |body| match label {
            "leds" => body.placements.len(),
            _ => body.shells.map_or(0, |shells| shells.pieces),
        });
        (label.to_owned(), body.to_string())
    };
    let (camera, housing) = (&layout.camera, &layout.housing);
    vec![
        by("housing", housing.outside.half),
        mm("height of the shell", -housing.joint_z),
        mm("total height", layout.top_z_mm - housing.bottom_z),
        by("plate", layout.plate.half),
        by("gel under the coat", layout.gel.half),
        mm("optical centre below the gel's outside", layout.gel_top_z_mm - camera.pupil_z),
        mm("lens front below the plate", layout.plate_bottom_z_mm - camera.front_z),
        by("seen on the gel", layout.visible_half_mm()),
        count("markers", "markers"),
        count("led", "leds"),
    ]
}

// ------ Layout ------
//
// Edges and heights that more than one body needs, each derived once.

/// Refractive index of acrylic. Gel has a lower one, so using this one for both underestimates the visible area.
const PLATE_INDEX: f64 = 1.49;

/// Edges and heights in the sensor frame, mm. The pad's foot, which is the upper rim of the shell, is at z = 0.
#[derive(Clone, Debug)]
pub struct FlatGelLayout<'a> {
    /// Outline of the pad with its coat.
    pub pad: Rect,
    /// Outline of the pad's gel.
    pub gel: Rect,
    /// Opening in the shell for plate and bed.
    pub opening: Rect,
    /// Outline of the plate.
    pub plate: Rect,
    /// Top of the pad.
    pub top_z_mm: f64,
    /// Top of the gel, below the coat, which the camera sees.
    pub gel_top_z_mm: f64,
    /// Top of the plate.
    pub plate_top_z_mm: f64,
    /// Bottom of the plate.
    pub plate_bottom_z_mm: f64,
    /// Camera on its posts.
    pub camera: PlacedCamera<'a>,
    /// Shell and base, joined as a clamshell.
    pub housing: Clamshell<'a>,
    /// Chamber below the plate's ledge, with its light sources.
    pub light: ChamberLight<'a>,
}

impl<'a> FlatGelLayout<'a> {
    /// Derives the layout; meaningful only for parameters that satisfy the family's constraints.
    pub fn new(p: &'a FlatGel) -> Self {
        let gap_mm = |part, fit| p.making.gap_mm(part, Process::Fdm, fit);
        let slide = gap_mm(SHELL, Fit::Slide);
        let half = [p.pad.length, p.pad.width].map(|edge| edge.mm() / 2.0);
        let pad = Rect { half, corner: p.pad.corner.mm() };
        let side = p.coat.side.mm();
        let gel = Rect { corner: p.pad.corner.mm() - side, ..pad.shrunk(side) };
        let opening = pad.shrunk(p.plate.overlap.mm());

        let (top_z_mm, plate_top_z_mm) = (p.pad.thickness.mm(), -p.bed.thickness.mm());
        let gel_top_z_mm = top_z_mm - p.coat.thickness.mm();
        let plate_bottom_z_mm = plate_top_z_mm - p.plate.thickness.mm();
        let camera = p.camera.in_front_of(gel_top_z_mm, gap_mm(BASE, Fit::Slide));

        let chamber = opening.half.map(|half| half - p.plate.ledge.mm());
        // The camera is inserted from below, so the room below the chamber must be at least as wide as its board.
        let board = p.camera.board_mm().map(|edge| edge / 2.0 + slide);
        let room = [0, 1].map(|i| (chamber[i] + p.leds.step_mm()).max(board[i]));
        let sections = (&p.shell, &p.base, &p.mount);
        let play = [slide, gap_mm(BASE, Fit::Snug)];
        let housing = Clamshell::around(sections, play, half, room, camera.foot_z);
        let light = ChamberLight {
            leds: &p.leds,
            chamber: Rect { half: chamber, ..housing.room },
            room: housing.room,
            ceiling_z: plate_bottom_z_mm,
            camera: camera.clone(),
            slide_mm: slide,
        };
        Self {
            pad,
            gel,
            opening,
            plate: opening.shrunk(slide),
            top_z_mm,
            gel_top_z_mm,
            plate_top_z_mm,
            plate_bottom_z_mm,
            camera,
            housing,
            light,
        }
    }

    /// Half edges, mm, along x and y of the area of gel under the coat that the camera sees through plate and gel. It
    /// is limited by the gel's edge, the image's edge, the plate's ledge or the LEDs.
    pub fn visible_half_mm(&self) -> [f64; 2] {
        let camera = self.camera.camera;
        let px = camera.images.size_px().map(f64::from);
        let (air, inside) = (
            self.plate_bottom_z_mm - self.camera.pupil_z,
            self.gel_top_z_mm - self.plate_bottom_z_mm,
        );
        let light = &self.light;
        [0, 1].map(|axis| {
            // The image's long side lies along the pad's long side.
            let px = if (axis == self.pad.longer()) == (px[0] >= px[1]) { px[0] } else { px[1] };
            let ledge = light.chamber.half[axis];
            // Below 1.5 rad, because the tangent of a wider angle would be meaningless.
            let mut slope = (px / 2.0 * camera.rad_per_px()).min(1.5).tan().min(ledge / air);
            if light.leds.out_mm() > 0.0 {
                let above = light.strip_top_z() - self.camera.pupil_z;
                slope = slope.min((ledge - light.leds.out_mm()) / above);
            }
            // Snell's law for a ray with this slope in air: its slope in the medium times the length of the medium.
            let n2 = PLATE_INDEX.powi(2);
            let bent = inside * slope / (n2 + (n2 - 1.0) * slope.powi(2)).sqrt();
            (air * slope + bent).min(self.gel.half[axis])
        })
    }
}
