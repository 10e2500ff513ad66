//! Dome-cap sensors: a dimpled cap of clear gel, painted outside, on a clear plate; coloured LEDs
//! and a camera below (ShadowTac).

mod bodies;
mod casing;
mod chain;
mod circuit;
mod components;
mod constraints;
mod joints;
mod layout;
mod mold;
mod parameters;
mod skin;

use fabkit_geometry::{DomeSurface, Grip, NominalCamera, Point3, Pose, Sensor, Vector3};

use crate::assembling::names;
use crate::blocks::adapter::MountFace;
use crate::blocks::lighting::{RED_GREEN_BLUE, slopes};
use crate::blocks::marks::RoundPattern;
use crate::blocks::{self, mm, sphere};
use crate::parameters::Report;
use crate::{Built, Family, Header};
use joints::Joints;
use layout::Layout;
use parameters::{Cap, Direction};

/// The family of ShadowTac.
pub(crate) struct CapFamily;

impl Family for CapFamily {
    type Parameters = Cap;
    const NAME: &'static str = "dome-cap";
    const SUMMARY: &'static str = "a dimpled, painted cap of gel on a plate, lit in three colours";
    const EXAMPLE: &'static str = "shadowtac";
    const DEFAULTS: &'static [(&'static str, &'static str)] =
        &[("dome-cap.yaml (defaults)", include_str!("defaults.yaml"))];

    fn check(parameters: &Cap, report: &mut Report) {
        constraints::check(parameters, report);
    }

    fn build(parameters: &Cap, header: &Header, report: &mut Report) -> Option<Built> {
        let layout = Layout::new(parameters);
        match skin::dimple_poses(parameters, &layout) {
            Ok(dimples) => Some(Built {
                sensor: sensor(parameters, header, &layout, &dimples),
                derived: derived(parameters, &layout),
                face: Some(face(parameters, &layout)),
            }),
            Err(error) => {
                report.require(
                    false,
                    "dimples.rings",
                    || format!("dimples.rings: {error}"),
                    || "write fewer rings, or a smaller `dimples.spacing`".into(),
                );
                None
            }
        }
    }
}

/// What it is mounted by.
fn face(p: &Cap, layout: &Layout) -> MountFace {
    MountFace {
        holder: bodies::BASE,
        mounting: Joints::new(p, layout).mounting,
        borrowed_mm: None,
        bottom_z_mm: layout.bottom_z_mm,
        outline: casing::outside(p),
        exits: vec![components::exit(p, layout)],
        heads: Vec::new(),
    }
}

/// Everything a dome-cap sensor consists of.
fn sensor(p: &Cap, header: &Header, layout: &Layout, dimples: &[Pose]) -> Sensor {
    let casing = [casing::plate(p, layout), casing::holder(p, layout), casing::base(p, layout)];
    let (touch, joints) = (touch(p, layout), Joints::new(p, layout));
    let bodies = casing
        .into_iter()
        .chain(mold::parts(p, layout, dimples))
        .chain(skin::layers(p, layout, &touch, dimples))
        .chain(components::components(p, layout));
    Sensor {
        chain: chain::chain(p, layout),
        circuits: vec![circuit::circuit(p)],
        press_fits: joints
            .casing
            .press_fit(bodies::HOLDER)
            .into_iter()
            .chain(joints.inserts().and_then(|mounting| mounting.press_fit(bodies::BASE)))
            .collect(),
        // Bumps stand out of it: nothing that fits a cap fits them.
        touch: (p.dimples.direction == Direction::IntoGel).then(|| touch.into()),
        marks: skin::marks(p, dimples),
        lightings: vec![slopes(bodies::PAINT, None, RED_BLUE_GREEN.map(|i| RED_GREEN_BLUE[i]))],
        sight: names(&[bodies::PAINT]),
        ..blocks::sensor(header, nominal(p), bodies)
    }
}

/// The order of the LEDs' colours, counter-clockwise seen from outside: measured in the published code.
const RED_BLUE_GREEN: [usize; 3] = [0, 2, 1];

/// The camera, turned as its plug is.
fn nominal(p: &Cap) -> NominalCamera {
    let c = &p.camera;
    let camera = c.view.camera_at(-c.depth.mm(), c.pictures.size_px());
    let sensor_from_camera = components::turned(p, camera.sensor_from_camera);
    NominalCamera { sensor_from_camera, ..camera }
}

/// How much of the skin's height gives way measurably: a solid cap of gel stiffens beyond.
const SOFT_SHARE: f64 = 0.4;

/// What is touched, and what fixtures hold on to: the whole casing, whose plug's window exists once.
fn touch(p: &Cap, layout: &Layout) -> DomeSurface {
    let radius_mm = layout.sphere_radius_mm + p.paint.thickness.mm();
    let outside = casing::outside(p);
    let out = p.base.cable_side.out();
    let height = Vector3::new(0.0, 0.0, (layout.floor_z_mm + layout.housing_back_z_mm) / 2.0);
    let window = Point3::from(outside.narrow() * out + height);
    DomeSurface {
        dome: sphere(radius_mm),
        centre_z_mm: layout.sphere_z_mm,
        foot_z_mm: 0.0,
        soft_mm: SOFT_SHARE * p.skin.height.mm(),
        grip: Grip {
            outline: outside.path(),
            top_z_mm: 0.0,
            bottom_z_mm: layout.bottom_z_mm,
            clear_radius_mm: 0.0,
            key: Some(Pose::z_to(out, window)),
            threads: Joints::new(p, layout).mounting.held().landmarks,
        },
    }
}

/// What follows from the parameters, for `fabkit show`.
fn derived(p: &Cap, layout: &Layout) -> Vec<(String, String)> {
    let mut figures = vec![
        mm("sphere radius", layout.sphere_radius_mm),
        mm("sphere centre below the foot", -layout.sphere_z_mm),
        ("dimples".into(), skin::dimple_count(p).to_string()),
    ];
    let is_ring = p.dimples.pattern == RoundPattern::Rings;
    if is_ring {
        let step_deg = layout.ring_tilt_rad(p, 1).to_degrees();
        figures.push(("polar step from ring to ring".into(), format!("{step_deg:.3} deg")));
    }
    figures.extend(
        constraints::nearest_dimples_mm(p, layout).map(|least| mm("nearest neighbours", least)),
    );
    let lowest = constraints::lowest_dimple_z(p, layout, layout.outermost_tilt_rad(p));
    let outermost = if is_ring { "ring" } else { "dimple" };
    figures.extend([
        mm(&format!("outermost {outermost} above the foot"), lowest),
        mm("total height", p.skin.height.mm() + p.paint.thickness.mm() - layout.bottom_z_mm),
        mm("casing height", -layout.bottom_z_mm),
        mm("lens front below the plate", layout.plate_bottom_z_mm - layout.lens_front_z_mm),
        mm("plug room behind the connector", plug_room_mm(p, layout)),
    ]);
    figures
}

/// Room between the camera's connector and the base's floor, mm.
fn plug_room_mm(p: &Cap, layout: &Layout) -> f64 {
    layout.housing_back_z_mm - p.camera.connector_height.mm() - layout.floor_z_mm
}
