//! Interactive model for a web page: all bodies of the assemblies, the camera's rays, and a pressed surface.

use fabkit_depth::ground_truth::scale_color;
use fabkit_designs::{Design, design_hash};
use fabkit_geometry::{
    CompiledSolid, Point3, Pose, Sensor, Solid, SurfacePoints, TouchSurface, Vector3,
};
use fabkit_guide::{CameraRay, CameraRays, PressedSurface, ViewerModel};
use fabkit_scene::ground_truth::Viewpoint;

use crate::camera_view::{self, DrawnRay};
use crate::exports::{ExportRunError, shown_glb};
use crate::images::default_assembly;

/// Radius of the pressing ball, mm. Chosen: it fits on every built-in surface.
const BALL_RADIUS_MM: f64 = 3.0;
/// Indentation as a share of the soft thickness. Chosen: the dent is visible and stays within the gel.
const INDENTATION_SHARE: f64 = 0.6;
/// Largest indentation, mm, for thick soft layers. Chosen.
const MAX_INDENTATION_MM: f64 = 2.0;
/// Polar angle and azimuth of the press on a dome, degrees, from the tip towards the initial viewer. Chosen: the dent
/// is in sight.
const PRESS_DIRECTION_DEG: [f64; 2] = [30.0, -45.0];
/// Chord tolerance of the pressed surface, mm: fine enough for its colours to follow the ball.
const PRESSED_CHORD_MM: f64 = 0.01;
/// Length to which an escaping ray is drawn beyond its last corner, mm.
const ESCAPED_RAY_MM: f64 = 20.0;
/// Largest number of assemblies in a page. A dome may have a hundred halves that differ only in their protrusions; a
/// few suffice.
const MOST_ASSEMBLIES: usize = 8;
/// Number of steps between the surface and the deepest point at which bodies are looked up.
const DEPTH_STEPS: u32 = 20;

/// Makes the model of a design: up to `MOST_ASSEMBLIES` assemblies, the default one first, then in the order of the
/// chain; where available, with the camera's rays and the pressed surface.
///
/// # Errors
/// Bodies that cannot be meshed.
///
/// ```
/// use fabkit_application::{model_view::build_model, source::Target};
///
/// let model = build_model(&Target::new("9dtact").design(&[])?)?;
/// // A binary glTF file, with the camera's rays and a pressed surface beside it.
/// assert_eq!(model.glb[..4], *b"glTF");
/// assert!(model.rays.is_some() && model.pressed.is_some());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn build_model(design: &Design) -> Result<ViewerModel, ExportRunError> {
    let sensor = &design.sensor;
    let assemblies = assemblies(sensor);
    Ok(ViewerModel {
        title: sensor.title.clone(),
        glb: shown_glb(design, &design_hash(design), &assemblies)?,
        rays: trace_rays(sensor),
        pressed: sensor.touch.as_ref().and_then(|touch| press_surface(sensor, touch)),
    })
}

fn assemblies(sensor: &Sensor) -> Vec<String> {
    let mut found = vec![default_assembly(sensor)];
    let of_chain = sensor.chain.iter().filter_map(|step| step.assembly.as_ref());
    let of_bodies = sensor.bodies.iter().flat_map(|body| &body.placements).map(|p| &p.assembly);
    let placed: Vec<&str> = of_bodies.map(|assembly| assembly.0.as_str()).collect();
    for name in of_chain.map(|assembly| assembly.0.as_str()).chain(placed.iter().copied()) {
        // A step may name an assembly without bodies.
        if placed.contains(&name) && !found.iter().any(|known| known == name) {
            found.push(name.to_owned());
        }
    }
    found.truncate(MOST_ASSEMBLIES);
    found
}

/// Traces rays in the two upright planes through the camera's axis. Returns `None` without a camera, or where no light
/// can be traced, which `check` explains.
fn trace_rays(sensor: &Sensor) -> Option<CameraRays> {
    if sensor.visible_bodies.is_empty() {
        return None;
    }
    let viewpoint = Viewpoint::new(&sensor.camera, None, None).ok()?;
    let stack = camera_view::build_stack(sensor, &viewpoint).ok()?;
    let mut rays: Vec<DrawnRay> = Vec::new();
    for normal in [Vector3::y(), Vector3::x()] {
        // A horizontal camera has only one such plane; the other direction is along its axis and fails.
        rays.extend(camera_view::trace_plane_rays(&viewpoint, &stack, &normal).unwrap_or_default());
    }
    let colors = camera_view::ray_colors(&rays, sensor);
    let drawn = rays.into_iter().zip(colors).map(|(mut ray, color)| {
        shorten(&mut ray.path_mm);
        CameraRay { color, path_mm: ray.path_mm }
    });
    Some(CameraRays { rays: drawn.collect() }).filter(|rays| !rays.rays.is_empty())
}

fn shorten(path_mm: &mut [[f64; 3]]) {
    if let [.., before, last] = path_mm {
        let way = Vector3::from(*last) - Vector3::from(*before);
        // Only the last segment of an escaped ray is that long; all others lie within the sensor.
        if way.norm() > ESCAPED_RAY_MM && way.norm() > 0.5 * camera_view::MAX_RAY_MM {
            *last = (Vector3::from(*before) + ESCAPED_RAY_MM * way.normalize()).into();
        }
    }
}

/// Computes the surface pressed by a rigid ball, as in ground truth; `None` where the surface is smaller than the ball.
fn press_surface(sensor: &Sensor, touch: &TouchSurface) -> Option<PressedSurface> {
    let (place, outward) = match SurfacePoints::new(touch).ok()? {
        SurfacePoints::Dome(dome) => {
            let [polar, azimuth] = PRESS_DIRECTION_DEG.map(|degrees| degrees.to_radians());
            // At most halfway to the rim, so that the ball stays on the dome.
            dome.point_in_direction(polar.min(0.5 * dome.max_polar_rad()), azimuth)?
        }
        SurfacePoints::Plane(plane) => {
            plane.at(plane.bounds_mm().map(|[least, most]| 0.5 * (least + most)))?
        }
    };
    let deep_mm = (INDENTATION_SHARE * touch.max_indentation_mm()).min(MAX_INDENTATION_MM);
    let middle = place + (BALL_RADIUS_MM - deep_mm) * outward;
    let ball = Solid::sphere(BALL_RADIUS_MM).at(middle.x, middle.y, middle.z);
    let solid = touch.solid(0.0, touch.foot_z_mm()).minus(ball);
    let mesh = fabkit_mesh::mesh(&solid, PRESSED_CHORD_MM).and_then(|mesh| mesh.to_print()).ok()?;
    let mesh = mesh.with_exact_normals(&solid);
    let color = |at: &[f32; 3]| {
        let point: Point3<f64> = at.map(f64::from).into();
        // Parts without contact are at rest; below its foot, the surface is not defined.
        let is_pressed = (point - middle).norm() < BALL_RADIUS_MM + PRESSED_CHORD_MM;
        let depth_mm = if is_pressed { touch.depth_mm(&point).0 } else { 0.0 };
        scale_color(depth_mm, [0.0, deep_mm])
    };
    let reached = |share: f64| place - share * deep_mm * outward;
    let asked = || (1..DEPTH_STEPS).map(|i| reached(f64::from(i) / f64::from(DEPTH_STEPS)));
    let is_pressed = |body: &&fabkit_geometry::Body| {
        let Ok(solid) = CompiledSolid::new(&body.solid) else { return false };
        let here = body.placements.iter().filter(|p| p.assembly.0 == default_assembly(sensor));
        let frames: Vec<Pose> = here.map(|p| p.assembly_from_body.inverse()).collect();
        frames.iter().any(|frame| asked().any(|point| solid.contains(&frame.point(point))))
    };
    let instead_of = sensor.bodies.iter().filter(is_pressed).map(|body| body.name.clone());
    Some(PressedSurface {
        ball_mm: 2.0 * BALL_RADIUS_MM,
        indentation_mm: deep_mm,
        colors: mesh.positions.iter().map(color).collect(),
        hidden_bodies: instead_of.collect(),
        positions_mm: mesh.positions,
        normals: mesh.normals,
        triangles: mesh.triangles,
    })
}

#[cfg(test)]
mod tests {
    use fabkit_designs::{builtin_names, builtin_yaml, load};

    use super::*;

    #[test]
    fn every_sensor_is_pressed_as_deep_as_it_says_and_seen_by_its_camera() {
        let mut pressed_count = 0;
        for name in builtin_names() {
            let design = load(name, builtin_yaml(name).unwrap(), &[], &["fixtures"]).unwrap();
            let sensor = &design.sensor;
            assert_eq!(trace_rays(sensor).is_some(), !sensor.visible_bodies.is_empty(), "{name}");
            let Some(touch) = &sensor.touch else { continue };
            let pressed = press_surface(sensor, touch).unwrap();
            // The deepest point has the last colour of the scale, and the surface at rest the first.
            let has = |value: f64| {
                let color = scale_color(value, [0.0, pressed.indentation_mm]);
                let near = |c: &[u8; 3]| c.iter().zip(color).all(|(a, b)| a.abs_diff(b) <= 12);
                pressed.colors.iter().any(near)
            };
            assert!(has(0.0) && has(pressed.indentation_mm), "{name}");
            assert!(
                pressed.indentation_mm <= touch.max_indentation_mm()
                    && !pressed.hidden_bodies.is_empty(),
                "{name}"
            );
            pressed_count += 1;
        }
        assert!(pressed_count > 6, "{pressed_count}");
    }
}
