//! Configurations of tactile sensors in Isaac Lab, as YAML whose keys are the fields of its classes
//! (`configclass.from_dict`).

use std::fmt::Write as _;

use super::numbers::{MM_PER_M, number};
use super::usd::identifier;
use super::{Robot, RobotCamera, RobotSensingSurface};

/// Number of force-field points along the longer side.
const FIELD: f64 = 24.0;
/// Margin at the edge of the sensing area, as a part of its shorter side, chosen so that no point lies on the edge.
const MARGIN: f64 = 0.05;
/// Friction coefficient where a layer has none: TacSL's default.
const FRICTION: f64 = 0.5;
/// Folder of the optics pack, beside the file.
const PACK: &str = "optics";

/// Writes the fields of TacSL's `VisuoTactileSensorCfg`, with those of `GelSightRenderCfg` and `TiledCameraCfg` inside;
/// `None` for a sensor without a sensing surface.
///
/// Stiffnesses are those of one point of the force field: Young's modulus of the layers in series, divided by their
/// thickness and multiplied by the area of a point.
///
/// isaac-sim/IsaacLab, `isaaclab_contrib/sensors/tacsl_sensor/visuotactile_sensor_cfg.py`.
pub fn tacsl(robot: &Robot) -> Option<String> {
    let touch = robot.touch.as_ref()?;
    let [wide_mm, high_mm, _] = touch.size_mm;
    let apart_mm = wide_mm.max(high_mm) / FIELD;
    let [columns, rows] = [wide_mm, high_mm].map(|side| (side / apart_mm).round().max(2.0));
    // Stiffness of one point, E A / t, in N/m: MPa mm2 / mm is N/mm.
    let area_mm2 = wide_mm * high_mm / (columns * rows);
    let stiffness = touch.young_mpa * area_mm2 / touch.thickness_mm * MM_PER_M;
    // The shear modulus of an incompressible material is a third of Young's modulus.
    let shear = stiffness / 3.0;
    let link = robot.links.iter().find(|link| link.name == touch.link)?;
    let base = prim(robot, "base");
    let camera = &robot.camera;
    let [width, height] = camera.size_px;
    let mut text = head(robot, touch, "VisuoTactileSensorCfg of Isaac Lab's TacSL sensor");
    // Writing to a string cannot fail.
    let _ = write!(
        text,
        "prim_path: \"{{ENV_REGEX_NS}}/{elastomer}\"\n\
         enable_camera_tactile: {}\n\
         enable_force_field: true\n\
         tactile_array_size: [{rows}, {columns}]\n\
         tactile_margin: {margin}\n\
         normal_contact_stiffness: {normal}\n\
         tangential_stiffness: {shear}\n\
         friction_coefficient: {friction}\n\
         camera_cfg:\n  \
           prim_path: \"{{ENV_REGEX_NS}}/{base}/camera\"\n  \
           spawn: null\n  \
           height: {height}\n  \
           width: {width}\n  \
           data_types: [\"distance_to_image_plane\"]\n",
        touch.slope_bins.is_some(),
        elastomer = prim(robot, &touch.link),
        margin = number(MARGIN * wide_mm.min(high_mm) / MM_PER_M),
        normal = number(stiffness),
        shear = number(shear),
        friction = number(link.friction.unwrap_or(FRICTION)),
    );
    if let Some(bins) = touch.slope_bins {
        let _ = write!(
            text,
            "render_cfg:\n  \
               base_data_path: \"{PACK}\"\n  \
               sensor_data_dir_name: \"tacsl\"\n  \
               image_height: {height}\n  \
               image_width: {width}\n  \
               num_bins: {bins}\n  \
               mm_per_pixel: {}\n",
            number(pixel_size_mm(camera, touch)),
        );
    }
    Some(text)
}

/// Writes the fields of TacEx's `GelSightSensorCfg`, with those of `TaximSimulatorCfg` inside; `None` for a sensor
/// without a sensing surface.
///
/// DH-Ng/TacEx, `tacex/gelsight_sensor_cfg.py`, `tacex/simulation_approaches/gpu_taxim/taxim_sim_cfg.py`.
pub fn tacex(robot: &Robot) -> Option<String> {
    let touch = robot.touch.as_ref()?;
    let camera = &robot.camera;
    let [width, height] = camera.size_px;
    let [wide, high, deep] = touch.size_mm.map(|mm| number(mm / MM_PER_M));
    let whole = size_mm(robot)?.map(|mm| number(mm / MM_PER_M));
    let far_mm = surface_distance_mm(camera, touch);
    let mut text = head(robot, touch, "GelSightSensorCfg of TacEx");
    // Writing to a string cannot fail.
    let _ = write!(
        text,
        "prim_path: \"{{ENV_REGEX_NS}}/{base}\"\n\
         case_dimensions: {{width: {}, length: {}, height: {}}}\n\
         gelpad_dimensions: {{width: {wide}, length: {high}, height: {deep}}}\n\
         sensor_camera_cfg:\n  \
           prim_path_appendix: /camera\n  \
           update_period: 0\n  \
           resolution: [{width}, {height}]\n  \
           data_types: [\"depth\"]\n  \
           clipping_range: [{near}, {far}]\n",
        whole[0],
        whole[1],
        whole[2],
        base = prim(robot, "base"),
        near = number(camera.near_mm / MM_PER_M),
        far = number(far_mm / MM_PER_M),
    );
    text += &match touch.slope_bins {
        None => "data_types: [\"camera_depth\"]\noptical_sim_cfg: null\n".to_owned(),
        Some(_) => format!(
            "data_types: [\"tactile_rgb\", \"height_map\", \"camera_depth\"]\n\
             compute_indentation_depth_class: optical_sim\n\
             optical_sim_cfg:\n  \
               calib_folder_path: {PACK}/taxim\n  \
               gelpad_height: {deep}\n  \
               gelpad_to_camera_min_distance: {}\n  \
               with_shadow: false\n  \
               tactile_img_res: [{width}, {height}]\n",
            number((far_mm - touch.max_indentation_mm).max(camera.near_mm) / MM_PER_M),
        ),
    };
    Some(text)
}

/// Writes the leading comment lines of a configuration.
fn head(robot: &Robot, touch: &RobotSensingSurface, class: &str) -> String {
    let comment = robot.comment.replace('\n', " ");
    let pack = match touch.slope_bins {
        None => "No image: Taxim's table is of slopes on a flat surface, and this sensor has none."
            .to_owned(),
        Some(_) => format!(
            "The folder `{PACK}` is rendered by\n# fabkit optics-pack {} --camera robot-camera.yaml -o {PACK}",
            robot.name
        ),
    };
    format!("# {comment}\n# Fields of {class}: `cfg.from_dict(yaml)`.\n# {pack}\n")
}

fn prim(robot: &Robot, link: &str) -> String {
    format!("{}/{}", identifier(&robot.name), identifier(link))
}

/// Distance from the camera to the top of the sensing surface, along the camera's axis, mm.
fn surface_distance_mm(camera: &RobotCamera, touch: &RobotSensingSurface) -> f64 {
    let top = fabkit_geometry::Point3::new(0.0, 0.0, touch.top_z_mm);
    camera.sensor_from_camera.inverse().point(top).z
}

/// Size of a pixel at that distance, mm.
fn pixel_size_mm(camera: &RobotCamera, touch: &RobotSensingSurface) -> f64 {
    surface_distance_mm(camera, touch) / camera.focal_px
}

/// Size of the bounding box of all visual shapes, mm.
fn size_mm(robot: &Robot) -> Option<[f64; 3]> {
    let shapes = robot.links.iter().flat_map(|link| &link.visuals);
    let both = shapes.map(|shape| shape.mesh.bounds_mm()).reduce(|[a, b], [c, d]| {
        [
            [0, 1, 2].map(|axis| f64::min(a[axis], c[axis])),
            [0, 1, 2].map(|axis| f64::max(b[axis], d[axis])),
        ]
    });
    both.map(|[least, most]| [0, 1, 2].map(|axis| most[axis] - least[axis]))
}
