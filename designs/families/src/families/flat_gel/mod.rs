//! Flat-gel sensors: a coated pad of gel on a clear plate above a camera (9DTact, DIGIT, GelSight).

mod bodies;
mod chain;
mod constraints;
mod layout;
mod pad;
mod parameters;

use fabkit_geometry::{Angle, Body, Lighting, NominalCamera, PlaneSurface, Pose, Sensor};

use crate::assembling::{SENSOR, in_sensor, sight};
use crate::blocks::adapter::MountFace;
use crate::blocks::lighting::{slopes, thickness};
use crate::blocks::marker_grid::MARKERS;
use crate::blocks::{self, merged, mm};
use crate::materials::Clarity;
use crate::parameters::Report;
use crate::{Built, Family, Header};
use bodies::{BASE, SHELL};
use layout::Layout;
use parameters::FlatGel;

/// The family of 9DTact, DIGIT and GelSight.
pub(crate) struct FlatGelFamily;

impl Family for FlatGelFamily {
    type Parameters = FlatGel;
    const NAME: &'static str = "flat-gel";
    const SUMMARY: &'static str = "a coated pad of gel on a clear plate above a camera";
    const EXAMPLE: &'static str = "9dtact";
    const DEFAULTS: &'static [(&'static str, &'static str)] =
        &[("flat-gel.yaml (defaults)", include_str!("defaults.yaml"))];

    fn check(parameters: &FlatGel, report: &mut Report) {
        constraints::check(parameters, report);
    }

    fn build(parameters: &FlatGel, header: &Header, _: &mut Report) -> Option<Built> {
        let layout = Layout::new(parameters);
        let sensor = sensor(parameters, header, &layout);
        let housing = &layout.housing;
        let face = MountFace {
            holder: BASE,
            mounting: housing.mounting(),
            borrowed_mm: None,
            bottom_z_mm: housing.bottom_z,
            outline: housing.outside,
            exits: vec![housing.exit()],
            heads: Vec::new(),
        };
        Some(Built { derived: derived(&sensor, &layout), sensor, face: Some(face) })
    }
}

/// Everything a flat-gel sensor consists of.
fn sensor(p: &FlatGel, header: &Header, layout: &Layout) -> Sensor {
    let (housing, board) = (&layout.housing, &layout.camera);
    let mounting = housing.mounting();
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
        touch: Some(touch(p, layout).into()),
        marks: p.markers.marks(layout.seen_z_mm),
        lightings: vec![lighting(p, layout)],
        sight: sight(&[(bodies::GEL, &p.pad.material)], bodies::COAT),
        ..blocks::sensor(header, nominal(layout), bodies)
    }
}

/// What is below the coat scatters light, or lets it through to the coat.
fn lighting(p: &FlatGel, layout: &Layout) -> Lighting {
    match p.pad.material.material().figures.clarity {
        Some(Clarity::Translucent) => thickness([bodies::GEL]),
        _ => slopes(bodies::COAT, p.markers.exist().then_some(MARKERS), layout.light.colors()),
    }
}

/// The camera, the long side of its picture along that of the pad.
fn nominal(layout: &Layout) -> NominalCamera {
    let c = layout.camera.camera;
    let size = c.pictures.size_px();
    let camera = c.view.camera_at(layout.camera.pupil_z, size);
    let turned = layout.pad.longer() == usize::from(size[0] >= size[1]);
    let quarter = Angle::from_deg(if turned { 90.0 } else { 0.0 }).expect("finite");
    let sensor_from_camera = camera.sensor_from_camera.then_in(Pose::rotation_z(quarter));
    NominalCamera { sensor_from_camera, ..camera }
}

/// Shell and base.
fn housing_parts(layout: &Layout) -> [Body; 2] {
    let (housing, light, over) = (&layout.housing, &layout.light, fabkit_geometry::CUT_OVERLAP_MM);
    let opening = layout.opening.prism([layout.plate_bottom_z_mm, over]).named("plate opening");
    let chamber = light.chamber.prism([light.step_z() - over, layout.plate_bottom_z_mm + over]);
    let cut = [opening, chamber.named("chamber")];
    [
        housing.shell(SHELL, cut, light.step_z()).placed([in_sensor()]),
        housing
            .base(BASE, layout.camera.posts())
            .cut(layout.camera.joint().held().unmarked())
            .placed([in_sensor().lifted(-46.0)]),
    ]
}

/// What is bought for the housing.
fn camera_and_screws(layout: &Layout) -> Vec<Body> {
    let lifted = |z_mm: f64| move |pose: &Pose| SENSOR.at(*pose).lifted(z_mm);
    let camera = layout.camera.body().placed([in_sensor().lifted(-34.0)]);
    let screws = [
        layout.camera.joint().bought(lifted(-27.0), lifted(0.0)),
        layout.housing.joint().bought(lifted(-60.0), lifted(0.0)),
        layout.housing.mounting().bought_nuts(lifted(-60.0)).into_iter().collect(),
    ];
    merged([camera].into_iter().chain(screws.into_iter().flatten()))
}

/// How much of a gel gives way that lies on the plate itself: it stiffens beyond.
const SOFT_SHARE: f64 = 0.5;

/// What is touched, and what fixtures hold on to.
fn touch(p: &FlatGel, layout: &Layout) -> PlaneSurface {
    PlaneSurface {
        outline: layout.pad.path(),
        top_z_mm: layout.top_z_mm,
        foot_z_mm: 0.0,
        soft_mm: if p.bed.thickness.mm() > 0.0 { 1.0 } else { SOFT_SHARE } * layout.seen_z_mm,
        grip: layout.housing.grip(),
    }
}

/// What follows from the parameters, for `fabkit show`.
fn derived(sensor: &Sensor, layout: &Layout) -> Vec<(String, String)> {
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
        mm("optical centre below the gel's outside", layout.seen_z_mm - camera.pupil_z),
        mm("lens front below the plate", layout.plate_bottom_z_mm - camera.front_z),
        by("seen on the gel", layout.seen_mm()),
        count("markers", "markers"),
        count("led", "leds"),
    ]
}
