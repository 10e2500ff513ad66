//! What is bought: camera with lens, LEDs, screws, bolts, nuts.

use fabkit_geometry::{Body, Path, Placement, Pose, Solid, Vector3};

use super::casing::{JOINT_SCREW, joint_poses, led_poses};
use super::layout::Layout;
use super::mold::{bolt_poses, nut_poses};
use super::parameters::Cap;
use super::{AssemblyName, SKIN_MOLD, in_sensor};
use crate::assembling::SENSOR;
use crate::hardware::{HexNut, Screw};

/// How far pieces of one body reach into each other, mm, so that no faces coincide.
const INTO_MM: f64 = 0.2;

/// Length and width of the camera's USB connector, mm: micro-B for USB 3.0.
pub const CONNECTOR_MM: [f64; 2] = [13.0, 6.0];

/// Everything bought.
pub fn components(p: &Cap, layout: &Layout) -> Vec<Body> {
    // Fasteners and LEDs leave along their own axis.
    let drawn_out = |assembly: AssemblyName, poses: Vec<Pose>, out_mm: f64, lift_mm: f64| {
        let out = Vector3::new(0.0, 0.0, out_mm);
        let place = |pose: Pose| -> Placement {
            assembly.at(pose).moved_apart(pose.vector(out)).lifted(lift_mm)
        };
        poses.into_iter().map(place).collect::<Vec<_>>()
    };
    let bought = |name: &str, specification: String, solid, placements: Vec<Placement>| {
        Body::bought(name, specification, solid)
            .placed(placements)
            .one_per_place()
            .colored([176, 180, 186])
    };
    let sensor = SENSOR;
    vec![
        bought(
            "camera",
            format!(
                "{} with lens {}, {} x {} px at {} fps",
                p.camera.model,
                p.camera.lens,
                p.camera.width_px,
                p.camera.height_px,
                p.camera.frame_rate
            ),
            camera(p, layout),
            vec![in_sensor().lifted(-26.0)],
        )
        .colored([35, 60, 45]),
        bought(
            "led",
            format!("{}, one LED on {} of strip", p.leds.model, p.leds.strip_length),
            led(p),
            drawn_out(sensor, led_poses(p, layout), 2.0, 14.0),
        )
        .colored([250, 240, 170]),
        bought(
            "screw-m2x16",
            "pan head screw ISO 7045 M2x16".into(),
            JOINT_SCREW.solid(),
            drawn_out(sensor, joint_poses(p, layout), 0.0, -96.0),
        ),
        bought(
            "bolt-m3x16",
            "pan head screw ISO 7045 M3x16".into(),
            Screw::M3X16.solid(),
            drawn_out(SKIN_MOLD, bolt_poses(p, layout), 34.0, 0.0),
        ),
        bought(
            "nut-m3",
            "hexagon nut ISO 4032 M3".into(),
            HexNut::M3.solid(),
            drawn_out(SKIN_MOLD, nut_poses(p, layout), 34.0, 0.0),
        ),
    ]
}

/// Lens, mount, housing and connector, in the sensor frame.
fn camera(p: &Cap, layout: &Layout) -> Solid {
    let camera = &p.camera;
    let between = |diameter: f64, bottom_z: f64, top_z: f64| {
        Solid::cylinder(diameter / 2.0, top_z - bottom_z).at(0.0, 0.0, bottom_z)
    };
    let lens =
        between(camera.lens_diameter.mm(), layout.mount_front_z - INTO_MM, layout.lens_front_z);
    let mount =
        between(camera.mount_diameter.mm(), layout.housing_front_z - INTO_MM, layout.mount_front_z);
    let outline =
        Path::rectangle([0.0; 2], [camera.housing_size.mm(); 2], camera.housing_corner.mm());
    let housing =
        Solid::extrusion(outline, camera.housing_height.mm()).at(0.0, 0.0, layout.housing_back_z);
    let [length, width] = CONNECTOR_MM;
    let height = camera.connector_height.mm();
    let connector =
        Solid::cuboid(length, width, height + INTO_MM).at(0.0, 0.0, layout.housing_back_z - height);
    Solid::union([
        housing.named("housing"),
        mount.named("mount"),
        lens.named("lens"),
        connector.named("connector"),
    ])
}

/// A piece of strip with its package; origin on the back, z axis out of the package, y across the
/// strip.
fn led(p: &Cap) -> Solid {
    let leds = &p.leds;
    let (thickness, size) = (leds.strip_thickness.mm(), leds.package_size.mm());
    let strip = Solid::cuboid(leds.strip_length.mm(), leds.strip_width.mm(), thickness);
    let into = thickness / 2.0;
    let package =
        Solid::cuboid(size, size, leds.package_height.mm() + into).at(0.0, 0.0, thickness - into);
    Solid::union([strip, package])
}
