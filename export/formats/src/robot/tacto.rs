//! TACTO's YAML: camera, gel and lights of its renderer.

use std::fmt::Write as _;

use super::numbers::{MM_PER_M, number};
use super::rotation::{opengl_rotation, roll_pitch_yaw};
use super::{Robot, RobotSensingSurface};

/// Number of OpenGL's fixed lights.
const MAX_LIGHTS: usize = 8;

/// Writes a configuration of TACTO's renderer, in metres and degrees; `None` for a sensor without a sensing surface.
///
/// The gel is the sensing surface's mesh, which TACTO looks for in the folder that it is started from; width, height
/// and origin describe the same surface for programs that do not read meshes. TACTO has no refraction and a single
/// pinhole camera, enlarges its gel by a fiftieth, and supports eight lights: of more, every n-th is taken. Colours and
/// positions are the drawn ones. TACTO adds the light to an image at rest, so intensities need tuning there.
///
/// facebookresearch/tacto, `config_digit.yml` and the README's section on configurations.
pub fn tacto(robot: &Robot) -> Option<String> {
    let touch = robot.touch.as_ref()?;
    let camera = &robot.camera;
    let metres = |values: &[f64]| {
        let all: Vec<String> = values.iter().map(|mm| number(mm / MM_PER_M)).collect();
        format!("[{}]", all.join(", "))
    };
    let plain = |values: &[f64]| {
        format!("[{}]", values.iter().map(|value| number(*value)).collect::<Vec<_>>().join(", "))
    };
    let turned = roll_pitch_yaw(&opengl_rotation(camera)).map(f64::to_degrees);
    // At most eight, taken evenly from the list.
    let step = robot.light_sources.len().div_ceil(MAX_LIGHTS).max(1);
    let lamps: Vec<_> = robot.light_sources.iter().step_by(step).collect();
    let list = |of: &dyn Fn(usize) -> String| {
        format!("[{}]", (0..lamps.len()).map(of).collect::<Vec<_>>().join(", "))
    };
    let RobotSensingSurface {
        mesh,
        size_mm: [wide, high, _],
        top_z_mm,
        max_indentation_mm: soft_mm,
        ..
    } = touch;
    let mut text = format!("# {}\n", robot.comment.replace('\n', " "));
    // Writing to a string cannot fail.
    let _ = write!(
        text,
        "# Metres, degrees, sensor frame. {} of {} lamps.\n\
         sensor:\n  \
           camera:\n    \
             - position: {}\n      \
               orientation: {}\n      \
               yfov: {}\n      \
               znear: {}\n      \
               lightIDList: {}\n  \
           gel:\n    \
             origin: {}\n    \
             width: {}\n    \
             height: {}\n    \
             curvature: false\n    \
             mesh: {}\n  \
           lights:\n    \
             origin: [0, 0, 0]\n    \
             polar: false\n    \
             xyz:\n      \
               coords: {}\n    \
             colors: {}\n    \
             intensities: {}\n  \
           noise:\n    \
             color:\n      \
               mean: 0\n      \
               std: 0\n  \
           force:\n    \
             enable: false\n    \
             range_force: [0, 100]\n    \
             max_deformation: {}\n",
        lamps.len(),
        robot.light_sources.len(),
        metres(camera.sensor_from_camera.translation_mm().as_slice()),
        plain(&turned),
        number(camera.view_rad()[1].to_degrees()),
        number(camera.near_mm / MM_PER_M),
        list(&|i| i.to_string()),
        metres(&[0.0, 0.0, *top_z_mm]),
        number(wide / MM_PER_M),
        number(high / MM_PER_M),
        mesh.file,
        list(&|i| metres(&lamps[i].place_mm)),
        list(&|i| plain(&lamps[i].rgb)),
        list(&|i| number(lamps[i].share)),
        number(soft_mm / MM_PER_M),
    );
    Some(text)
}
