//! SDF files for Gazebo and Drake.

use std::fmt::Write as _;

use super::numbers::{MM_PER_M, number, numbers};
use super::rotation::roll_pitch_yaw;
use super::xml::{comment, escaped, translation_m, vector};
use super::{Robot, RobotCamera, RobotLink, RobotSensingSurface, RobotShape};

/// Rotation from a frame that looks along z with y down to SDF's cameras, which look along x with z up, as roll, pitch
/// and yaw, rad.
const CAMERA_RPY: &str = "0 -1.57079633 1.57079633";
const PA_PER_MPA: f64 = 1e6;

/// Writes an SDF file: a model with a link for each body, welded to the base.
pub fn sdf(robot: &Robot) -> String {
    model(robot, "<sdf version=\"1.9\">", &Gazebo)
}

/// Writes an SDF file with Drake's own elements: the sensing surface as compliant tetrahedra (hydroelastic contact),
/// rigid bodies as rigid convex pieces. Drake does not read SDF's cameras; `robot.json` has the intrinsics.
///
/// Drake, "Parsing models", section "drake:proximity_properties".
pub fn drake(robot: &Robot) -> String {
    model(robot, "<sdf version=\"1.9\" xmlns:drake=\"drake.mit.edu\">", &Drake(&robot.touch))
}

/// Differences between readers of SDF.
trait Dialect {
    /// Returns whether links contain cameras.
    fn has_camera(&self) -> bool;
    /// Returns elements for transparency beyond the alpha of the colour, which all readers use.
    fn transparency(&self, opacity: f64) -> String;
    /// Returns the geometry and the further elements of a collision shape.
    fn collision(&self, shape: &RobotShape, friction: Option<f64>) -> (String, String);
}

struct Gazebo;

impl Dialect for Gazebo {
    fn has_camera(&self) -> bool {
        true
    }

    fn transparency(&self, opacity: f64) -> String {
        format!("        <transparency>{}</transparency>\n", number(1.0 - opacity))
    }

    fn collision(&self, shape: &RobotShape, friction: Option<f64>) -> (String, String) {
        let surface = friction.map_or_else(String::new, |friction| {
            let mu = number(friction);
            format!("        <surface><friction><ode><mu>{mu}</mu><mu2>{mu}</mu2></ode></friction></surface>\n")
        });
        (mesh(&shape.mesh.file, ""), surface)
    }
}

struct Drake<'a>(&'a Option<RobotSensingSurface>);

impl Dialect for Drake<'_> {
    fn has_camera(&self) -> bool {
        false
    }

    fn transparency(&self, _: f64) -> String {
        String::new()
    }

    fn collision(&self, shape: &RobotShape, friction: Option<f64>) -> (String, String) {
        let mu = friction.map_or_else(String::new, |friction| {
            let mu = number(friction);
            format!(
                "<drake:mu_static>{mu}</drake:mu_static><drake:mu_dynamic>{mu}</drake:mu_dynamic>"
            )
        });
        let own = |inner: &str| {
            format!(
                "        <drake:proximity_properties>{inner}{mu}</drake:proximity_properties>\n"
            )
        };
        // Only the sensing surface is compliant.
        match self.0.as_ref().filter(|touch| touch.mesh.file == shape.mesh.file) {
            Some(touch) => {
                let modulus = number(touch.young_mpa * PA_PER_MPA);
                let gives = format!(
                    "<drake:compliant_hydroelastic/><drake:hydroelastic_modulus>{modulus}</drake:hydroelastic_modulus>"
                );
                (mesh(&touch.tetrahedra.file, ""), own(&gives))
            }
            None => (
                mesh(&shape.mesh.file, "<drake:declare_convex/>"),
                own("<drake:rigid_hydroelastic/>"),
            ),
        }
    }
}

fn mesh(file: &str, more: &str) -> String {
    format!("<mesh><uri>{}</uri>{more}</mesh>", escaped(file))
}

/// Writes a model in a dialect of SDF.
fn model(robot: &Robot, root: &str, dialect: &dyn Dialect) -> String {
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n{}\n{root}\n  <model name=\"{}\">\n",
        comment(&robot.comment),
        escaped(&robot.name)
    );
    let base = robot.links.first().map_or("base", |link| &link.name);
    for (i, link) in robot.links.iter().enumerate() {
        // The camera belongs to the base.
        let camera = (i == 0 && dialect.has_camera()).then_some(&robot.camera);
        text += &write_link(link, camera, dialect);
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
            translation_m(pose),
            numbers(roll_pitch_yaw(pose.rotation())),
        );
    }
    text + "  </model>\n</sdf>\n"
}

fn write_link(link: &RobotLink, camera: Option<&RobotCamera>, dialect: &dyn Dialect) -> String {
    let [xx, yy, zz, xy, xz, yz] = link.inertia.moments().map(number);
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
            "        <material><diffuse>{0}</diffuse><ambient>{0}</ambient></material>\n{1}",
            numbers([r, g, b, opacity]),
            dialect.transparency(opacity)
        );
        text += &write_shape("visual", &shape.name, &mesh(&shape.mesh.file, ""), &more);
    }
    for shape in &link.collisions {
        let (geometry, more) = dialect.collision(shape, link.friction);
        text += &write_shape("collision", &shape.name, &geometry, &more);
    }
    if let Some(camera) = camera {
        let _ = writeln!(
            text,
            "      <sensor name=\"camera\" type=\"camera\">\n        <pose relative_to=\"{}\">0 0 0 {CAMERA_RPY}</pose>\n        \
             <camera>\n          <horizontal_fov>{}</horizontal_fov>\n          \
             <image><width>{}</width><height>{}</height></image>\n          \
             <clip><near>{}</near><far>1</far></clip>\n        </camera>\n      </sensor>",
            escaped(&camera.frame),
            number(camera.view_rad()[0]),
            camera.size_px[0],
            camera.size_px[1],
            number(camera.near_mm / MM_PER_M),
        );
    }
    text + "    </link>\n"
}

fn write_shape(kind: &str, name: &str, geometry: &str, more: &str) -> String {
    format!(
        "      <{kind} name=\"{}\">\n        <geometry>{geometry}</geometry>\n{more}      </{kind}>\n",
        escaped(name)
    )
}
