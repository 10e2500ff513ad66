//! Dome sensors: a hemisphere of gels on a glass tube, a ring of LEDs, a camera below (R-Tac0).

mod bodies;
mod chain;
mod circuit;
mod components;
mod constraints;
mod housing;
mod joints;
mod layers;
mod layout;
mod lock;
mod mold;
mod parameters;
mod surface;
mod tooling;
mod wiring;

use fabkit_geometry::{Body, DomeSurface, Grip, Path, PressFit, Process, Sensor};

use crate::assembling::{shrinkage, sight};
use crate::blocks::adapter::MountFace;
use crate::blocks::lighting::thickness;
use crate::blocks::{self, DOWEL, Rect, mm, press_fit, sphere};
use crate::fits::Fit;
use crate::parameters::Report;
use crate::{Built, Family, Header};
use bodies::*;
use joints::Joints;
use layout::Layout;
use mold::{Cavity, FormTools};
use parameters::{CoatMethod, Dome, MoldRoute};

/// The family of R-Tac0.
pub(crate) struct DomeFamily;

impl Family for DomeFamily {
    type Parameters = Dome;
    const NAME: &'static str = "dome";
    const SUMMARY: &'static str = "a hemisphere of gels on a glass tube, lit by a ring of LEDs";
    const EXAMPLE: &'static str = "rtac0";
    const DEFAULTS: &'static [(&'static str, &'static str)] =
        &[("dome.yaml (defaults)", include_str!("defaults.yaml"))];

    fn check(parameters: &Dome, report: &mut Report) {
        constraints::check(parameters, report);
    }

    fn build(parameters: &Dome, header: &Header, _report: &mut Report) -> Option<Built> {
        let layout = Layout::new(parameters);
        let face = MountFace {
            holder: BASE,
            mounting: Joints::new(parameters, &layout).mounting,
            borrowed_mm: None,
            bottom_z_mm: layout.bottom_z_mm,
            outline: Rect::round(layout.shell_radius_mm),
            exits: vec![wiring::exit(parameters, &layout)],
            heads: Vec::new(),
        };
        let sensor = sensor(parameters, header);
        Some(Built { sensor, derived: derived(parameters), face: Some(face) })
    }
}

/// Everything a dome sensor consists of.
fn sensor(p: &Dome, header: &Header) -> Sensor {
    let layout = Layout::new(p);
    let [transparent, translucent] = cavities(p, &layout);
    let housing = [housing::shell, housing::base, housing::diffuser, housing::led_board]
        .map(|make| make(p, &layout));
    let both = [&transparent, &translucent];
    let molds = both.into_iter().flat_map(|cavity| match p.molds.route {
        MoldRoute::Printed => {
            let [a, b] = mold::halves(p, &layout, cavity);
            vec![a, b, mold::lid(p, &layout, cavity)]
        }
        MoldRoute::Silicone => {
            vec![tooling::form_bridge(p, &layout, cavity), mold::lid(p, &layout, cavity)]
        }
    });
    let is_silicone = p.molds.route == MoldRoute::Silicone;
    let cup = is_silicone.then(|| tooling::form_cup(p, &layout));
    let is_dipped = p.coat.method == CoatMethod::Dip;
    let dipping = is_dipped.then(|| tooling::coating_parts(p, &layout));
    let parts: Vec<Body> = housing
        .into_iter()
        .chain(housing::baffle(p, &layout))
        .chain(cup)
        .chain(molds)
        .chain([mold::collar(p, &layout), tooling::connector(p, &layout)])
        .chain([tooling::tube_jig(p, &layout)])
        .chain(dipping.into_iter().flatten())
        .collect();
    let touch = touch(p, &layout);
    let mut layers = layers::layers(p, &layout, &touch);
    layers.splice(1..1, lock::locking_gel(p, &layout));
    if is_silicone {
        layers.extend(both.map(|cavity| tooling::silicone_mold(p, &layout, cavity)));
    }
    let c = &p.camera;
    let camera = c.view.camera_at(-c.depth.mm(), c.pictures.size_px());
    let bodies = parts.into_iter().chain(layers).chain(components::components(p, &layout));
    Sensor {
        chain: chain::chain(p, &layout),
        circuits: vec![circuit::circuit(p, &layout)],
        press_fits: press_fits(p, &Joints::new(p, &layout)),
        touch: Some(touch.into()),
        lightings: vec![thickness([bodies::TRANSLUCENT_GEL])],
        jpeg_quality: u8::try_from(p.camera.jpeg_quality).ok().filter(|quality| *quality > 0),
        sight: sight(&[(bodies::TRANSLUCENT_GEL, &p.translucent_gel.material)], bodies::BLACK_COAT),
        ..blocks::sensor(header, camera, bodies)
    }
}

/// What is touched, and what fixtures hold on to: the shell stands on its lower rim.
fn touch(p: &Dome, layout: &Layout) -> DomeSurface {
    let radius_mm = layout.surface_radius_mm;
    DomeSurface {
        dome: sphere(radius_mm),
        centre_z_mm: layout.wall_height_mm,
        foot_z_mm: 0.0,
        // What lies deeper is stiffer by an order of magnitude and shows no change of brightness.
        soft_mm: p.translucent_gel.thickness.mm(),
        grip: Grip {
            outline: Path::circle([0.0, 0.0], layout.shell_radius_mm),
            top_z_mm: 0.0,
            bottom_z_mm: layout.bottom_z_mm,
            clear_radius_mm: layout.shell_bore_radius_mm,
            key: None,
            threads: Joints::new(p, layout).mounting.held().landmarks,
        },
    }
}

/// The two layers that are cast in molds.
fn cavities(p: &Dome, layout: &Layout) -> [Cavity; 2] {
    // What is dipped gets its coat outside of the mold.
    let outer = match p.coat.method {
        CoatMethod::Spray => layout.surface_radius_mm,
        CoatMethod::Dip => layout.translucent_radius_mm,
    };
    let route = p.molds.route;
    [
        Cavity {
            what: "transparent",
            route,
            halves: [INNER_A, INNER_B],
            lid: INNER_LID,
            form: FormTools {
                assembly: INNER_FORM,
                bridge: INNER_BRIDGE,
                tube: INNER_FORM_TUBE,
                mold: INNER_SILICONE,
            },
            assembly: TRANSPARENT_MOLD,
            shrinkage: shrinkage(&p.transparent_gel.material),
            radius: layout.transparent_radius_mm,
            core_radius: layout.tube_radius_mm,
        },
        Cavity {
            what: "translucent",
            route,
            halves: [OUTER_A, OUTER_B],
            lid: OUTER_LID,
            form: FormTools {
                assembly: OUTER_FORM,
                bridge: OUTER_BRIDGE,
                tube: OUTER_FORM_TUBE,
                mold: OUTER_SILICONE,
            },
            assembly: TRANSLUCENT_MOLD,
            shrinkage: shrinkage(&p.translucent_gel.material),
            radius: outer,
            core_radius: layout.transparent_radius_mm,
        },
    ]
}

/// The overlaps that are meant.
fn press_fits(p: &Dome, joints: &Joints) -> Vec<PressFit> {
    let pressed = |inner, outer, reason| {
        let overlap = -p.making.gap_mm(outer, Process::Fdm, Fit::Press);
        press_fit(inner, outer, overlap, reason)
    };
    let screws = [
        joints.camera.press_fit(BASE),
        joints.form.press_fit(FORM_CUP).filter(|_| p.molds.route == MoldRoute::Silicone),
        joints.shell_base.press_fit(BASE),
        // Where nuts of one kind hold both, one fit says so.
        joints
            .inserts()
            .filter(|mounting| mounting.nut_name() != joints.shell_base.nut_name())
            .and_then(|mounting| mounting.press_fit(BASE)),
    ];
    let mut fits = vec![pressed(LED_BOARD, SHELL, "the board is pressed in")];
    if p.baffle.wall.mm() > 0.0 {
        let overlap = -p.making.gap_mm(BAFFLE, Process::Fdm, Fit::Press);
        fits.push(press_fit(BAFFLE, LED_BOARD, overlap, "the baffle is pressed in"));
    }
    fits.extend(screws.into_iter().flatten());
    if p.molds.route == MoldRoute::Printed {
        let stay = [INNER_A, OUTER_A].map(|half| pressed(DOWEL, half, "the dowels stay in half a"));
        let lid = [INNER_B, OUTER_B];
        let lid = lid.map(|half| pressed(DOWEL, half, "the lid's dowel stays in half b"));
        fits.extend(stay.into_iter().chain(lid));
    }
    if p.coat.method == CoatMethod::Dip {
        let coat = p.coat.thickness.mm();
        let walls = cavities(p, &Layout::new(p))[1].walls();
        fits.extend(walls.into_iter().map(|wall| {
            press_fit(BLACK_COAT, wall, coat, "the coat is squeezed where the mold only centres")
        }));
    }
    fits
}

/// What follows from the parameters, for `fabkit show`.
fn derived(p: &Dome) -> Vec<(String, String)> {
    let layout = Layout::new(p);
    vec![
        mm("apex above the foot", layout.apex_z()),
        mm("total height", layout.total_height()),
        mm("shell height", layout.shell_height()),
        mm("shell bore radius", layout.shell_bore_radius_mm),
        mm("translucent gel outer radius", layout.translucent_radius_mm),
        mm("transparent gel outer radius", layout.transparent_radius_mm),
        mm("transparent gel thickness", layout.transparent_radius_mm - layout.tube_radius_mm),
        mm("tube inner radius", layout.tube_bore_radius_mm),
        mm("lens front below the foot", -layout.lens_front_z_mm),
        mm("camera board top below the foot", -layout.camera_board_top_z_mm),
    ]
}
