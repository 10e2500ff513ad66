//! Pin-tip sensors: a soft printed hemisphere with pins inside, watched by a camera through gel
//! (the TacTip family).

mod bodies;
mod body;
mod chain;
mod circuit;
mod components;
mod constraints;
mod controller;
mod gauge;
mod joints;
mod layout;
mod parameters;
mod tip;

use fabkit_geometry::{Detachable, DomeSurface, Grip, Path, Pose, PrintGroup, Process, Sensor};

use crate::assembling::names;
use crate::blocks::LED;
use crate::blocks::lighting::places;
use crate::blocks::marks::{RoundPattern, nearest_mm};
use crate::blocks::optics::LensLaw;
use crate::blocks::{self, mm, press_fit, sphere};
use crate::fits::Fit;
use crate::parameters::Report;
use crate::{Built, Family, Header};
use bodies::{BODY, LED_BOARD, TIP};
use joints::Joints;
use layout::Layout;
use parameters::PinTip;

/// The family of the TacTip.
pub(crate) struct PinTipFamily;

impl Family for PinTipFamily {
    type Parameters = PinTip;
    const NAME: &'static str = "pin-tip";
    const SUMMARY: &'static str =
        "a soft printed hemisphere with white-tipped pins, filled with gel";
    const EXAMPLE: &'static str = "tactip";
    const DEFAULTS: &'static [(&'static str, &'static str)] =
        &[("pin-tip.yaml (defaults)", include_str!("defaults.yaml"))];

    fn check(parameters: &PinTip, report: &mut Report) {
        constraints::check(parameters, report);
    }

    fn build(parameters: &PinTip, header: &Header, _report: &mut Report) -> Option<Built> {
        let sensor = sensor(parameters, header);
        // It has a flange of its own.
        Some(Built { sensor, derived: derived(parameters), face: None })
    }
}

/// Everything a pin-tip sensor consists of.
fn sensor(p: &PinTip, header: &Header) -> Sensor {
    let layout = Layout::new(p);
    let made = [tip::lens, body::led_board, body::body, body::mount, gauge::gauge, tip::gel];
    let bodies = tip::printed(p, &layout)
        .into_iter()
        .chain(made.map(|make| make(p, &layout)))
        .chain(components::components(p, &layout))
        .chain(controller::bodies(p, &layout));
    let board = -p.making.gap_mm(BODY, Process::Fdm, Fit::Press);
    let board = press_fit(LED_BOARD, BODY, board, "the board is pressed in");
    let screws = Joints::new(p, &layout).camera.press_fit(BODY);
    // The camera looks at the tip.
    let view = (Layout::diagonal_view(p), LensLaw::Equidistant);
    let camera = p.camera.optics.camera_at(layout.pupil_z_mm, [p.camera.pixels; 2], view);
    Sensor {
        marks: tip::marks(p, &layout),
        lightings: vec![places(bodies::DOTS, LED)],
        // ADNS-3080 data sheet: pixel data of six bits.
        grey_bits: 6,
        contrasts: vec![[bodies::DOTS, bodies::SKIN].map(String::from)],
        chain: chain::chain(p, &layout),
        circuits: vec![circuit::circuit(p, &layout)],
        print_groups: vec![PrintGroup { name: "tip".into(), parts: names(&TIP) }],
        press_fits: [board].into_iter().chain(screws).collect(),
        touch: Some(touch(&layout).into()),
        detachable: Some(detachable(&layout)),
        mount: Some(Pose::translation(0.0, 0.0, layout.plate_bottom_z_mm)),
        sight: names(&[bodies::DOTS]),
        ..blocks::sensor(header, camera, bodies)
    }
}

/// The tip comes off its bayonet: the housing behind it is twice as wide.
fn detachable(layout: &Layout) -> Detachable {
    let tip = [&TIP[..], &[bodies::LENS, bodies::GEL]].concat();
    Detachable {
        bodies: names(&tip),
        back: layout.tip_joint.male_onto([]).legs,
        instruction: "push the body's lugs into the tip and turn it until it stops,".into(),
    }
}

/// How far a tip is pressed in use, mm: lens and ring are stiff enough for that.
const PRESS_MM: f64 = 5.0;

/// What is touched, and what fixtures hold on to: the tip's rigid ring, wider than the shaft below.
fn touch(layout: &Layout) -> DomeSurface {
    let radius_mm = layout.outer_radius_mm;
    DomeSurface {
        dome: sphere(radius_mm),
        centre_z_mm: 0.0,
        foot_z_mm: layout.skirt_z_mm,
        soft_mm: PRESS_MM,
        grip: Grip {
            outline: Path::circle([0.0, 0.0], radius_mm),
            top_z_mm: layout.skirt_z_mm,
            bottom_z_mm: layout.ring_bottom_z_mm,
            // The body comes to the tip from below, lugs first.
            clear_radius_mm: layout.shaft_radius_mm.max(layout.tip_joint.lug_radius),
            key: None,
            threads: Vec::new(),
        },
    }
}

/// What follows from the parameters, for `fabkit show`.
fn derived(p: &PinTip) -> Vec<(String, String)> {
    let layout = Layout::new(p);
    let pins = layout.pin_poses(p).map_or(0, |poses| poses.len());
    let [rim, rim_z] = layout.outermost_dot(p);
    let seen = 2.0 * layout.ray_radius(Layout::half_view_tangent(p), rim_z);
    let mut figures =
        vec![("pins".into(), pins.to_string()), mm("pin diameter", layout.pin_diameter_mm)];
    figures.extend(match p.pins.pattern {
        RoundPattern::Rings => Some(mm("pin spacing", layout.pin_spacing_mm)),
        RoundPattern::List => {
            nearest_mm(&layout.dot_ends(p)).map(|least| mm("nearest dots", least))
        }
    });
    figures.extend([
        mm("diameter of the circle around all dots", 2.0 * rim),
        mm("width that the camera sees at the outermost dots", seen),
        mm("margin around the dots at that distance", seen / 2.0 - rim),
        mm("target in the focusing gauge beyond the lens's front", layout.focus_mm(p)),
        ("angle that the camera sees".into(), format!("{:.2} deg", Layout::view(p).deg())),
        mm("bayonet bore radius, tip", layout.tip_joint.bore_radius),
        mm("bayonet bore radius, mount", layout.mount_joint.bore_radius),
        mm("housing diameter", 2.0 * layout.mount_joint.outer_radius),
        mm(
            "height from the mount's plate to the apex",
            layout.outer_radius_mm - layout.plate_bottom_z_mm,
        ),
    ]);
    figures
}
