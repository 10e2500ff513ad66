//! Flat-gel sensors: a coated pad of gel on a clear plate above a camera (9DTact, DIGIT, GelSight).

mod chain;
mod components;
mod constraints;
mod housing;
mod joints;
mod layout;
mod pad;
mod parameters;

use fabkit_geometry::{Grip, PlaneSurface, Point3, Pose, Sensor, Vector3};

use crate::assembling::{AssemblyName, in_sensor};
use crate::blocks::{self, BLACK, INTO_MM, camera_at, mm};
use crate::parameters::Report;
use crate::{Built, Family, Header};
use joints::Joints;
use layout::Layout;
use parameters::FlatGel;

/// Casting the gel.
const GEL_MOLD: AssemblyName = AssemblyName("gel-mold");

/// Casting the coat around it.
const COAT_MOLD: AssemblyName = AssemblyName("coat-mold");

/// Printing the markers.
const MARKING: AssemblyName = AssemblyName("marking");

/// The family of 9DTact, DIGIT and GelSight.
pub(crate) struct FlatGelFamily;

impl Family for FlatGelFamily {
    type Parameters = FlatGel;
    const NAME: &'static str = "flat-gel";
    const SUMMARY: &'static str = "a coated pad of gel on a clear plate above a camera";
    const EXAMPLE: &'static str = "9dtact";

    fn check(parameters: &FlatGel, report: &mut Report) {
        constraints::check(parameters, report);
    }

    fn build(parameters: &FlatGel, header: &Header, _: &mut Report) -> Option<Built> {
        let layout = Layout::new(parameters);
        let derived = derived(parameters, &layout);
        Some(Built { sensor: sensor(parameters, header, &layout), derived })
    }
}

/// Everything a flat-gel sensor consists of.
fn sensor(p: &FlatGel, header: &Header, layout: &Layout) -> Sensor {
    let joints = Joints::new(p, layout);
    let screws = [joints.casing.press_fit("shell"), joints.camera.press_fit("base")];
    let size = [p.camera.width_px, p.camera.height_px];
    let camera = camera_at(layout.pupil_z, size, p.camera.field_of_view);
    let bodies = housing::parts(p, layout)
        .into_iter()
        .chain(pad::tools(p, layout))
        .chain(pad::layers(p, layout))
        .chain(components::components(p, layout));
    let dowels = pad::frames(p, layout).press_fit();
    Sensor {
        chain: chain::chain(p, layout),
        press_fits: screws.into_iter().flatten().chain([dowels]).collect(),
        touch: Some(touch(p, layout, &joints).into()),
        ..blocks::sensor(header, camera, bodies)
    }
}

/// What is touched, and what fixtures hold on to: shell and base, whose notch exists once.
fn touch(p: &FlatGel, layout: &Layout, joints: &Joints) -> PlaneSurface {
    let notch_z = layout.joint_z + p.shell.cable_height.mm() / 2.0;
    let notch = Point3::new(0.0, -layout.outside.half[1], notch_z);
    PlaneSurface {
        outline: layout.pad.path(),
        top_z_mm: layout.top_z,
        foot_z_mm: 0.0,
        soft_mm: layout.seen_z,
        grip: Grip {
            outline: layout.outside.path(),
            top_z_mm: 0.0,
            bottom_z_mm: layout.bottom_z,
            clear_radius_mm: 0.0,
            key: Some(Pose::z_to(-Vector3::y(), notch)),
            threads: joints.mounting.held().landmarks,
        },
    }
}

/// What follows from the parameters, for `fabkit show`.
fn derived(p: &FlatGel, layout: &Layout) -> Vec<(String, String)> {
    let by = |name: &str, [x, y]: [f64; 2]| {
        (name.to_owned(), format!("{:.3} x {:.3} mm", 2.0 * x, 2.0 * y))
    };
    vec![
        by("housing", layout.outside.half),
        mm("height of the shell", -layout.joint_z),
        mm("total height", layout.top_z - layout.bottom_z),
        by("plate", layout.plate.half),
        by("gel under the coat", layout.gel.half),
        mm("optical centre below the gel's outside", layout.seen_z - layout.pupil_z),
        mm("lens front below the plate", layout.plate_bottom_z - layout.lens_front_z),
        by("seen on the gel", layout.seen_mm(p)),
        ("markers".into(), pad::marker_poses(p, layout).len().to_string()),
        ("leds".into(), housing::led_poses(p, layout).len().to_string()),
    ]
}
