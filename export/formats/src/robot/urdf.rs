//! URDF files for ROS, PyBullet, Drake, SAPIEN and MuJoCo's importer.

use std::fmt::Write as _;

use super::numbers::{number, numbers};
use super::rotation::roll_pitch_yaw;
use super::xml::{comment, escaped, translation_m, vector};
use super::{Robot, RobotLink, RobotShape};

/// Writes a URDF file.
///
/// Soft layers are links of their own, welded to the base. An element for MuJoCo keeps it from merging them.
pub fn urdf(robot: &Robot) -> String {
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n{}\n<robot name=\"{}\">\n",
        comment(&robot.comment),
        escaped(&robot.name)
    );
    text += "  <mujoco>\n    <compiler strippath=\"false\" fusestatic=\"false\" discardvisual=\"false\" \
             balanceinertia=\"false\"/>\n  </mujoco>\n";
    for link in &robot.links {
        text += &write_link(link);
    }
    let base = robot.links.first().map_or("base", |link| &link.name);
    // Writing to a string cannot fail.
    for link in robot.links.iter().skip(1) {
        let _ = write!(text, "{}", weld(base, &link.name, "0 0 0", "0 0 0"));
    }
    for frame in &robot.frames {
        let _ = writeln!(text, "  <link name=\"{}\">\n{MASSLESS}  </link>", escaped(&frame.name));
        let pose = &frame.sensor_from_frame;
        text += &weld(
            base,
            &frame.name,
            &translation_m(pose),
            &numbers(roll_pitch_yaw(pose.rotation())),
        );
    }
    text + "</robot>\n"
}

/// Inertial element of frames. A mass of zero must be stated: PyBullet assumes one kilogram for links without it.
const MASSLESS: &str = "    <inertial>\n      <mass value=\"0\"/>\n      <inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" \
                        iyz=\"0\" izz=\"0\"/>\n    </inertial>\n";

fn weld(base: &str, link: &str, xyz: &str, rpy: &str) -> String {
    format!(
        "  <joint name=\"{link}-weld\" type=\"fixed\">\n    <parent link=\"{base}\"/>\n    <child link=\"{link}\"/>\n    \
         <origin xyz=\"{xyz}\" rpy=\"{rpy}\"/>\n  </joint>\n",
        base = escaped(base),
        link = escaped(link),
    )
}

fn write_link(link: &RobotLink) -> String {
    let [xx, yy, zz, xy, xz, yz] = link.inertia.moments().map(number);
    let mut text = format!(
        "  <link name=\"{}\">\n    <inertial>\n      <origin xyz=\"{}\" rpy=\"0 0 0\"/>\n      <mass value=\"{}\"/>\n      \
         <inertia ixx=\"{xx}\" ixy=\"{xy}\" ixz=\"{xz}\" iyy=\"{yy}\" iyz=\"{yz}\" izz=\"{zz}\"/>\n    </inertial>\n",
        escaped(&link.name),
        vector(&link.inertia.centre_m),
        number(link.inertia.mass_kg),
    );
    for shape in &link.visuals {
        // Materials are global in URDF and need unique names.
        let color = format!(
            "      <material name=\"{}\"><color rgba=\"{}\"/></material>\n",
            escaped(&shape.name),
            numbers(shape.rgba)
        );
        text += &write_shape("visual", shape, &color);
    }
    for shape in &link.collisions {
        text += &write_shape("collision", shape, "");
    }
    text + "  </link>\n"
}

fn write_shape(kind: &str, shape: &RobotShape, more: &str) -> String {
    format!(
        "    <{kind} name=\"{}\">\n      <geometry><mesh filename=\"{}\"/></geometry>\n{more}    </{kind}>\n",
        escaped(&shape.name),
        escaped(&shape.mesh.file)
    )
}
