//! SDF, as Gazebo and Drake read it.

use std::fmt::Write as _;

use super::xml::{comment, escaped, number, numbers, place, roll_pitch_yaw, vector};
use super::{Robot, RobotLink, RobotShape};

/// The text of an SDF file: a model with a link for each body, welded to the base.
pub fn sdf(robot: &Robot) -> String {
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n{}\n<sdf version=\"1.9\">\n  <model name=\"{}\">\n",
        comment(&robot.comment),
        escaped(&robot.name)
    );
    let base = robot.links.first().map_or("base", |link| &link.name);
    for (i, link) in robot.links.iter().enumerate() {
        text += &of_link(link, if i == 0 { robot } else { &NO_SENSORS });
    }
    // Writing to a string cannot fail.
    for link in robot.links.iter().skip(1) {
        let name = escaped(&link.name);
        let _ = writeln!(
            text,
            "    <joint name=\"{name}-weld\" type=\"fixed\">\n      <parent>{}</parent>\n      <child>{name}</child>\n    \
             </joint>",
            escaped(base)
        );
    }
    for frame in &robot.frames {
        let pose = &frame.sensor_from_frame;
        let _ = writeln!(
            text,
            "    <frame name=\"{}\" attached_to=\"{}\"><pose>{} {}</pose></frame>",
            escaped(&frame.name),
            escaped(base),
            place(pose),
            numbers(roll_pitch_yaw(pose.rotation())),
        );
    }
    text + "  </model>\n</sdf>\n"
}

/// A camera looks along x with z up: turned so from a frame that looks along z with y down, rad.
const LOOKS: &str = "0 -1.57079633 1.57079633";

/// For links that have no camera.
static NO_SENSORS: Robot = Robot {
    name: String::new(),
    comment: String::new(),
    links: Vec::new(),
    frames: Vec::new(),
    camera: None,
    touch: None,
};

fn of_link(link: &RobotLink, sensors: &Robot) -> String {
    let [xx, yy, zz, xy, xz, yz] = link.inertia.six().map(number);
    let mut text = format!(
        "    <link name=\"{}\">\n      <inertial>\n        <pose>{} 0 0 0</pose>\n        <mass>{}</mass>\n        \
         <inertia><ixx>{xx}</ixx><ixy>{xy}</ixy><ixz>{xz}</ixz><iyy>{yy}</iyy><iyz>{yz}</iyz><izz>{zz}</izz></inertia>\n      \
         </inertial>\n",
        escaped(&link.name),
        vector(&link.inertia.centre_m),
        number(link.inertia.mass_kg),
    );
    for shape in &link.visuals {
        let [r, g, b, opacity] = shape.rgba;
        let more = format!(
            "        <material><diffuse>{0}</diffuse><ambient>{0}</ambient></material>\n        <transparency>{1}</transparency>\n",
            numbers([r, g, b, opacity]),
            number(1.0 - opacity)
        );
        text += &of_shape("visual", shape, &more);
    }
    let friction = link.friction.map_or_else(String::new, |friction| {
        let mu = number(friction);
        format!("        <surface><friction><ode><mu>{mu}</mu><mu2>{mu}</mu2></ode></friction></surface>\n")
    });
    for shape in &link.collisions {
        text += &of_shape("collision", shape, &friction);
    }
    if let Some(camera) = &sensors.camera {
        let _ = writeln!(
            text,
            "      <sensor name=\"camera\" type=\"camera\">\n        <pose relative_to=\"{}\">0 0 0 {LOOKS}</pose>\n        \
             <camera>\n          <horizontal_fov>{}</horizontal_fov>\n          \
             <image><width>{}</width><height>{}</height></image>\n          \
             <clip><near>{}</near><far>1</far></clip>\n        </camera>\n      </sensor>",
            escaped(&camera.frame),
            number(camera.view_rad[0]),
            camera.size_px[0],
            camera.size_px[1],
            number(camera.near_mm / super::xml::MM_PER_M),
        );
    }
    text + "    </link>\n"
}

fn of_shape(kind: &str, shape: &RobotShape, more: &str) -> String {
    format!(
        "      <{kind} name=\"{}\">\n        <geometry><mesh><uri>{}</uri></mesh></geometry>\n{more}      </{kind}>\n",
        escaped(&shape.name),
        escaped(&shape.file)
    )
}
