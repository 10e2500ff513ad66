//! Bought components, the LED circuit, and the routing of the cable.

use fabkit_geometry::{Angle, Body, Circuit, Connection, Order, Path, Point3, Pose, Solid};

use super::housing::led_poses;
use super::parameters::*;
use super::{CapLayout, Joints};
use crate::blocks::adapter::CableOutlet;
use crate::blocks::cable::{Cable, GIVE_WAY_MM};
use crate::blocks::cable_openings::HousingSide;
use crate::blocks::circuit::{CircuitBuilder, camera_to_host};
use crate::blocks::{APART_MM, CAMERA_GREEN, INTO_MM, LED, LED_YELLOW, RUBBER};
use crate::chain_builder::{SENSOR, in_sensor};
use crate::hardware::ThreadedLens;

// ------ Components ------
//
// Bought components: camera with lens, LEDs, screws, bolts, nuts.

/// Length and width of the camera's USB connector (micro-B for USB 3.0), mm.
pub const CONNECTOR_MM: [f64; 2] = [13.0, 6.0];

/// Returns all bought components.
pub fn components(p: &Cap, layout: &CapLayout) -> Vec<Body> {
    let c = &p.camera;
    let camera_text = format!("{} with lens {}, {}", c.module.model, c.lens, *c.images);
    let led_text = format!("{}, one LED on {} of strip", p.leds.model, p.leds.strip_length);
    let leds = led_poses(p, layout);
    let leds = leds.iter().map(|pose| SENSOR.at_exploded(pose, 2.0).lifted(14.0));
    let lens = ThreadedLens { barrel_mm: c.lens_diameter.mm(), front_z: layout.lens_front_z_mm };
    let joints = Joints::new(p, layout);
    let below = |pose: &Pose| SENSOR.at(*pose).lifted(-96.0);
    let off_mold = |pose: &Pose| SKIN_MOLD.at_exploded(pose, 34.0);
    [
        vec![
            CAMERA
                .bought(camera_text, camera(p, layout), [in_sensor().lifted(-26.0)])
                .with_order(Order::new(&c.module.model, format!("with lens {}", c.lens)))
                .with_tool_access(lens.front_access())
                .colored(CAMERA_GREEN),
            LED.bought(led_text, led(p), leds)
                .with_order(Order::new(&p.leds.model, "").cut_to(p.leds.strip_length.mm()))
                .colored(LED_YELLOW)
                .with_light_source(package(p))
                .as_attached(),
            camera_cable(p, layout),
        ],
        joints.casing.bought(below, below),
        joints.mold.bought(off_mold, off_mold),
        joints.mounting.bought_nuts(below).into_iter().collect(),
    ]
    .concat()
}

/// Returns the camera with lens, mount, housing and connector, in the sensor frame.
fn camera(p: &Cap, layout: &CapLayout) -> Solid {
    let camera = &p.camera;
    let [lens_radius, mount_radius] =
        [camera.lens_diameter, camera.mount_diameter].map(|d| d.mm() / 2.0);
    let lens = Solid::rod(lens_radius, [layout.mount_front_z_mm - INTO_MM, layout.lens_front_z_mm]);
    let mount =
        Solid::rod(mount_radius, [layout.housing_front_z_mm - INTO_MM, layout.mount_front_z_mm]);
    let outline =
        Path::rectangle([0.0; 2], [camera.housing_size.mm(); 2], camera.housing_corner.mm());
    let housing =
        Solid::extrusion(outline, camera.housing_height.mm()).at_z(layout.housing_back_z_mm);
    let [length, width] = CONNECTOR_MM;
    let height = camera.connector_height.mm();
    let connector =
        Solid::cuboid(length, width, height + INTO_MM).at_z(layout.housing_back_z_mm - height);
    let whole = Solid::union([
        housing.named("housing"),
        mount.named("mount"),
        lens.named("lens"),
        connector.named("connector"),
    ]);
    match p.base.cable_side {
        HousingSide::Front => whole,
        _ => whole.placed(turned_to_cable_side(p, Pose::identity())),
    }
}

/// Width of the angled plug, mm: the largest width that passes the window.
const PLUG_WIDTH_MM: f64 = 13.5;

/// Reach of the plug from the axis, away from the window and towards it, mm.
const PLUG_REACH_MM: [f64; 2] = [3.0, 9.0];

/// Height of the plug below its socket, mm.
const PLUG_HEIGHT_MM: f64 = 7.0;

/// Diameter of the camera's cable, mm: usual for USB 3.0.
const CABLE_MM: f64 = 4.5;

/// Drawn length of the cable beyond the casing, mm. It is drawn straight, because a bend there would bend its plug.
const CABLE_BEYOND_MM: f64 = 20.0;

/// Returns the height of the plug's top, and the height of the plug as far as the base's floor leaves room for it,
/// mm.
fn plug_top_and_height_mm(p: &Cap, layout: &CapLayout) -> (f64, f64) {
    let top = layout.housing_back_z_mm - p.camera.connector_height.mm();
    (top, PLUG_HEIGHT_MM.min(top - layout.floor_z_mm - APART_MM))
}

/// Diameter of the drawn cable, mm: less than the plug's height.
fn cable_diameter_mm(plug_mm: f64) -> f64 {
    CABLE_MM.min(plug_mm - APART_MM)
}

/// Cable exit that a plate below the casing must leave free.
pub fn cable_exit(p: &Cap, layout: &CapLayout) -> CableOutlet {
    let (top, height) = plug_top_and_height_mm(p, layout);
    let (width_mm, angle) = (cable_diameter_mm(height), p.base.cable_side.angle());
    let above_mm = top - height / 2.0 - width_mm / 2.0 - layout.bottom_z_mm;
    CableOutlet::Sideways { angle, width_mm, above_mm }
}

/// Distance from the axis at which the drawn cable ends, mm.
fn cable_end_mm(p: &Cap) -> f64 {
    p.holder.width.mm() / 2.0 + CABLE_BEYOND_MM
}

/// Drawn length of the cable without its plug, mm.
pub fn drawn_cable_mm(p: &Cap) -> f64 {
    cable_end_mm(p) - PLUG_REACH_MM[1] + INTO_MM
}

/// Returns the camera's cable with its angled plug, which enters through the window.
fn camera_cable(p: &Cap, layout: &CapLayout) -> Body {
    let (top, height) = plug_top_and_height_mm(p, layout);
    let [back, front] = PLUG_REACH_MM;
    let half = PLUG_WIDTH_MM / 2.0;
    let plug = Solid::cuboid_between([-half, -front, top - height], [half, back, top]);
    let middle = top - height / 2.0;
    let cable = Cable {
        diameter_mm: cable_diameter_mm(height),
        bend_mm: 0.0,
        corners: [INTO_MM - front, -cable_end_mm(p)].map(|y| Point3::new(0.0, y, middle)).to_vec(),
    };
    let solid = Solid::union([plug.named("plug"), cable.solid()]);
    let place = SENSOR.at(turned_to_cable_side(p, Pose::identity())).lifted(-44.0);
    CAMERA_CABLE
        .bought("USB 3.0 cable with an angled micro-B plug", solid, [place])
        .with_order(Order::new("USB 3.0 cable with an angled micro-B plug", ""))
        .colored(RUBBER)
        .with_assembly_compliance(GIVE_WAY_MM)
}

/// Turns a pose about the sensor's axis from the front, where the window is by default, to the side that has it.
pub fn turned_to_cable_side(p: &Cap, pose: Pose) -> Pose {
    let quarters = (p.base.cable_side.quarters() + 4 - HousingSide::Front.quarters()) % 4;
    let turn = Angle::from_deg(90.0 * f64::from(quarters)).expect("finite");
    match quarters {
        0 => pose,
        _ => Pose::rotation_z(turn).then_in(pose),
    }
}

/// Returns a piece of strip with its LED package. Its origin is on the back, z points out of the package, y across
/// the strip.
fn led(p: &Cap) -> Solid {
    let leds = &p.leds;
    let thickness = leds.strip_thickness.mm();
    let strip = Solid::cuboid(leds.strip_length.mm(), leds.strip_width.mm(), thickness);
    Solid::union([strip, package(p)])
}

/// Returns the LED package, which overlaps its strip.
fn package(p: &Cap) -> Solid {
    let (size, into) = (p.leds.package_size.mm(), p.leds.strip_thickness.mm() / 2.0);
    Solid::cuboid(size, size, p.leds.package_height.mm() + into).at_z(into)
}

// ------ Circuit ------
//
// Wiring of the pieces of strip: supply and ground in parallel, data from one to the next.

/// Current of one LED of such strips at full white, A (Adafruit's guide to NeoPixels: 60 mA, 20 mA per colour).
const LED_FULL_WHITE_A: f64 = 0.060;

/// Builds the circuit: wires between supply, controller and pieces of strip, and the camera's cable.
pub fn circuit(p: &Cap) -> Circuit {
    // Such strips are made for 5 V.
    let mut wired = CircuitBuilder::new_wired("led-strips", 5.0);
    let mut connect = |from: String, to: String, carries: &str, color: &str| {
        let (carries, color) = (carries.to_owned(), Some(color.to_owned()));
        wired.connection(Connection { from, to, carries, by: None, length_mm: None, color });
    };
    for piece in 1..=p.leds.count {
        let at = |pad: &str| format!("strip {piece}, {pad}");
        let before = |pad: &str, first: &str| match piece {
            1 => first.to_owned(),
            _ => format!("strip {}, {pad}", piece - 1),
        };
        connect(at("5V"), before("5V", "5 V of the supply"), "5V", "red");
        connect(at("GND"), before("GND", "ground of supply and controller"), "GND", "black");
        connect(at("DIN"), before("DOUT", "digital pin of the controller"), "data", "green");
    }
    wired.add_current(LED_FULL_WHITE_A * f64::from(p.leds.count));
    wired.connection(camera_to_host(
        "camera",
        Some(CAMERA_CABLE),
        Some(drawn_cable_mm(p)),
        "USB 3.0",
    ));
    wired.note("no board is etched: each piece of strip carries its LED with its driver and needs no resistor for its LED");
    wired
        .note("the total current is that of all LEDs in full white; one colour each takes a third");
    wired.build()
}
