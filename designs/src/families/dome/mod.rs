//! Dome sensors: a hemisphere of gels on a glass tube, a ring of LEDs, a camera below (R-Tac0).

mod chain;
mod components;
mod constraints;
mod housing;
mod joints;
mod layers;
mod layout;
mod mold;
mod parameters;
mod surface;
mod tooling;

use fabkit_geometry::{
    Body, Color, EllipsoidOffset, Grip, NominalCamera, Path, Pose, PressFit, Process, Sensor,
    TouchSurface,
};

use crate::assembling::{AssemblyName, BLACK, SENSOR, flipped, in_sensor};
use crate::fits::{Fit, gap_mm};
use crate::materials::castable;
use crate::parameters::Report;
use crate::{Built, Family, Header};
use joints::Joints;
use layout::Layout;
use mold::Cavity;
use parameters::Dome;

const FROST: Color = [225, 236, 240];
const MOLD_BLUE: Color = [120, 160, 205];

/// Casting the transparent gel around the tube.
const TRANSPARENT_MOLD: AssemblyName = AssemblyName("transparent-mold");
/// Casting the translucent gel around the transparent one.
const TRANSLUCENT_MOLD: AssemblyName = AssemblyName("translucent-mold");
/// Gluing the cured module to its shell.
const JOINING: AssemblyName = AssemblyName("joining");
/// Casting a silicone mold around a glass tube.
const FORM: AssemblyName = AssemblyName("form");
/// Dipping a module into black mixture.
const COATING: AssemblyName = AssemblyName("coating");

/// The family of R-Tac0.
pub(crate) struct DomeFamily;

impl Family for DomeFamily {
    type Parameters = Dome;
    const NAME: &'static str = "dome";
    const SUMMARY: &'static str = "a hemisphere of gels on a glass tube, lit by a ring of LEDs";
    const EXAMPLE: &'static str = "rtac0";

    fn check(parameters: &Dome, report: &mut Report) {
        constraints::check(parameters, report);
    }

    fn build(parameters: &Dome, header: &Header, _report: &mut Report) -> Option<Built> {
        Some(Built { sensor: sensor(parameters, header), derived: derived(parameters) })
    }
}

/// Everything a dome sensor consists of.
fn sensor(p: &Dome, header: &Header) -> Sensor {
    let layout = Layout::new(p);
    let [transparent, translucent] = cavities(p, &layout);
    let housing = [
        housing::shell(p, &layout),
        housing::base(p, &layout),
        housing::diffuser(p, &layout),
        housing::led_board(p, &layout),
    ];
    let molds = [&transparent, &translucent].map(|cavity| {
        let [a, b] = mold::halves(p, &layout, cavity);
        [a, b, mold::lid(p, &layout, cavity)]
    });
    let parts: Vec<Body> = housing
        .into_iter()
        .chain(molds.into_iter().flatten())
        .chain([mold::collar(p, &layout), tooling::connector(p, &layout)])
        .chain(tooling::form_parts(p, &layout))
        .chain(tooling::coating_parts(p, &layout))
        .collect();
    let mut layers = layers::layers(p, &layout);
    layers.push(tooling::silicone_mold(p, &layout));
    Sensor {
        chain: chain::chain(p, &layout),
        press_fits: press_fits(&Joints::new(p, &layout)),
        touch: Some(touch(p, &layout)),
        ..Sensor::new(
            header.name.as_str(),
            &header.title,
            &header.reference,
            NominalCamera {
                // The camera looks at the tip; its image's right is the sensor's +x.
                sensor_from_camera: Pose::translation(0.0, 0.0, -p.camera.depth.mm()),
                width_px: p.camera.width_px,
                height_px: p.camera.height_px,
                field_of_view: p.camera.field_of_view,
            },
            parts.into_iter().chain(layers).chain(components::components(p, &layout)),
        )
    }
}

/// What is touched, and what fixtures hold on to: the shell stands on its lower rim.
fn touch(p: &Dome, layout: &Layout) -> TouchSurface {
    let radius_mm = layout.surface_radius;
    TouchSurface {
        dome: EllipsoidOffset { equatorial_mm: radius_mm, polar_mm: radius_mm, offset_mm: 0.0 },
        centre_z_mm: layout.wall_height,
        foot_z_mm: 0.0,
        // What lies deeper is stiffer by an order of magnitude and shows no change of brightness.
        soft_mm: p.translucent_gel.thickness.mm(),
        grip: Grip {
            outline: Path::circle([0.0, 0.0], layout.shell_radius),
            top_z_mm: 0.0,
            bottom_z_mm: layout.bottom_z,
            clear_radius_mm: layout.shell_bore_radius,
            key: None,
            threads: Joints::new(p, layout).mounting.held().landmarks,
        },
    }
}

/// The two layers that are cast in molds.
fn cavities(p: &Dome, layout: &Layout) -> [Cavity<'static>; 2] {
    let shrinkage = |material: &str| castable(material).map_or(0.0, |m| m.shrinkage);
    [
        Cavity {
            layer: "transparent-gel",
            assembly: TRANSPARENT_MOLD,
            shrinkage: shrinkage(&p.transparent_gel.material),
            radius: layout.transparent_radius,
            core_radius: layout.tube_radius,
        },
        Cavity {
            layer: "translucent-gel",
            assembly: TRANSLUCENT_MOLD,
            shrinkage: shrinkage(&p.translucent_gel.material),
            radius: layout.surface_radius,
            core_radius: layout.transparent_radius,
        },
    ]
}

/// The overlaps that are meant.
fn press_fits(joints: &Joints) -> Vec<PressFit> {
    let fit = |inner: &str, outer: &str, interference_mm: f64, reason: &str| PressFit {
        inner: inner.into(),
        outer: outer.into(),
        interference_mm,
        reason: reason.into(),
    };
    let dowel = -gap_mm(Process::Fdm, Fit::Press);
    vec![
        fit("led-board", "shell", -gap_mm(Process::Pcb, Fit::Press), "the board is pressed in"),
        joints.camera.press_fit("base"),
        joints.form.press_fit("form-cup"),
        joints.shell_base.press_fit("base"),
        fit("dowel", "mold-transparent-gel-a", dowel, "the dowels stay in half a"),
        fit("dowel", "mold-translucent-gel-a", dowel, "the dowels stay in half a"),
        fit("dowel", "mold-transparent-gel-b", dowel, "the lid's dowel stays in half b"),
        fit("dowel", "mold-translucent-gel-b", dowel, "the lid's dowel stays in half b"),
    ]
}

/// What follows from the parameters, for `fabkit show`.
fn derived(p: &Dome) -> Vec<(String, String)> {
    let layout = Layout::new(p);
    let mm = |name: &str, value: f64| (name.to_string(), format!("{value:.3} mm"));
    vec![
        mm("apex above the foot", layout.apex_z()),
        mm("total height", layout.total_height()),
        mm("shell height", layout.shell_height()),
        mm("shell bore radius", layout.shell_bore_radius),
        mm("translucent gel outer radius", layout.translucent_radius),
        mm("transparent gel outer radius", layout.transparent_radius),
        mm("transparent gel thickness", layout.transparent_radius - layout.tube_radius),
        mm("tube inner radius", layout.tube_bore_radius),
        mm("lens front below the foot", -layout.lens_front_z),
        mm("camera board top below the foot", -layout.camera_board_top_z),
    ]
}
