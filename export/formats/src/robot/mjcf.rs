//! MJCF, MuJoCo's own format.

use std::fmt::Write as _;

use super::numbers::{number, numbers};
use super::rotation::{opengl_rotation, quaternion};
use super::xml::{comment, escaped, translation_m, vector};
use super::{Robot, RobotLink};

/// Attributes of geoms that are only visible, and of geoms that collide, in MuJoCo's viewer groups.
const VISUAL_ATTRIBUTES: &str = "contype=\"0\" conaffinity=\"0\" group=\"2\"";
const COLLISION_ATTRIBUTES: &str = "group=\"3\"";

/// Writes an MJCF file: a body for the base, one inside it for each soft layer, sites for frames, the camera, and a
/// tactile sensor on the vertices of the sensing surface.
///
/// MuJoCo moves a mesh's origin to its centre and aligns it with its principal axes, and moves the geometry back. A
/// `tactile` sensor is therefore correct only where its geometry is the very mesh that it samples, which is so here.
pub fn mjcf(robot: &Robot) -> String {
    let mut text = format!(
        "{}\n<mujoco model=\"{}\">\n  <compiler angle=\"radian\" autolimits=\"true\"/>\n  <asset>\n",
        comment(&robot.comment),
        escaped(&robot.name)
    );
    let shapes = || robot.links.iter().flat_map(|link| link.visuals.iter().chain(&link.collisions));
    let mut files: Vec<&str> = shapes().map(|shape| &*shape.mesh.file).collect();
    // A mesh that several shapes use is declared once.
    files.sort_unstable();
    files.dedup();
    // Writing to a string cannot fail.
    for file in files {
        let _ = writeln!(text, "    <mesh name=\"{}\" file=\"{}\"/>", mesh(file), escaped(file));
    }
    text += "  </asset>\n  <worldbody>\n";
    let mut links = robot.links.iter();
    if let Some(base) = links.next() {
        let _ = writeln!(text, "    <body name=\"{}\">", escaped(&base.name));
        text += &write_link(base, 6);
        for link in links {
            let _ = writeln!(text, "      <body name=\"{}\">", escaped(&link.name));
            text += &write_link(link, 8);
            text += "      </body>\n";
        }
        for frame in &robot.frames {
            let _ = writeln!(
                text,
                "      <site name=\"{}\" pos=\"{}\" quat=\"{}\" size=\"0.0005\"/>",
                escaped(&frame.name),
                translation_m(&frame.sensor_from_frame),
                numbers(quaternion(frame.sensor_from_frame.rotation())),
            );
        }
        let camera = &robot.camera;
        let _ = writeln!(
            text,
            "      <camera name=\"camera\" pos=\"{}\" quat=\"{}\" fovy=\"{}\" resolution=\"{} {}\"/>",
            translation_m(&camera.sensor_from_camera),
            numbers(quaternion(&opengl_rotation(camera))),
            number(camera.view_rad()[1].to_degrees()),
            camera.size_px[0],
            camera.size_px[1],
        );
        text += "    </body>\n";
    }
    text += "  </worldbody>\n";
    if let Some(touch) = &robot.touch {
        let name = mesh(&touch.mesh.file);
        let _ = writeln!(
            text,
            "  <sensor>\n    <tactile name=\"tactile\" geom=\"touch\" mesh=\"{name}\"/>\n  </sensor>"
        );
    }
    text + "</mujoco>\n"
}

fn mesh(file: &str) -> String {
    escaped(file.strip_suffix(".obj").unwrap_or(file))
}

fn write_link(link: &RobotLink, deep: usize) -> String {
    let indent = " ".repeat(deep);
    let mut text = format!(
        "{indent}<inertial pos=\"{}\" mass=\"{}\" fullinertia=\"{}\"/>\n",
        vector(&link.inertia.centre_m),
        number(link.inertia.mass_kg),
        numbers(link.inertia.moments()),
    );
    for shape in &link.visuals {
        let _ = writeln!(
            text,
            "{indent}<geom type=\"mesh\" mesh=\"{}\" rgba=\"{}\" {VISUAL_ATTRIBUTES}/>",
            mesh(&shape.mesh.file),
            numbers(shape.rgba)
        );
    }
    let friction = link.friction.map_or_else(String::new, |friction| {
        // MuJoCo's defaults for torsional and rolling friction follow the sliding one.
        format!(" friction=\"{} 0.005 0.0001\"", number(friction))
    });
    for shape in &link.collisions {
        let _ = writeln!(
            text,
            "{indent}<geom name=\"{}\" type=\"mesh\" mesh=\"{}\" rgba=\"{}\"{friction} {COLLISION_ATTRIBUTES}/>",
            escaped(&shape.name),
            mesh(&shape.mesh.file),
            numbers(shape.rgba)
        );
    }
    text
}
