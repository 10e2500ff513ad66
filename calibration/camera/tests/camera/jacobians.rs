//! Derivatives against differences of the projection itself.

use crate::common;
use crate::common::camera_and_pixel;
use fabkit_camera::{Camera, Interface, Point2, Point3, Vector2, Vector3};
use proptest::prelude::*;

/// Central difference of fourth order: the error falls with the fourth power of the step.
fn difference(pixel_at: impl Fn(f64) -> Vector2<f64>, step: f64) -> Vector2<f64> {
    let central = |h: f64| (pixel_at(h) - pixel_at(-h)) / (2.0 * h);
    (central(step) * 4.0 - central(2.0 * step)) / 3.0
}

/// 1e-6 of the column's length. The floor is what rounding leaves of pixels near 1e3 (1e-13) after
/// division by the step and a few operations.
fn agree(analytic: Vector2<f64>, numeric: Vector2<f64>, step: f64) -> Result<(), String> {
    let allowed = 1e-6 * analytic.norm() + 3e-12 / step;
    let error = (analytic - numeric).norm();
    if error <= allowed {
        Ok(())
    } else {
        Err(format!("{analytic} differs from {numeric} by {error:e} > {allowed:e}"))
    }
}

fn check(camera: &Camera, point: Point3<f64>) -> Result<(), String> {
    let projection = camera.project_with_jacobians(&point).map_err(|e| e.to_string())?;
    let plain = camera.project(&point).map_err(|e| e.to_string())?;
    if (projection.pixel - plain).norm() > 1e-10 {
        return Err(format!("{} is not {plain}", projection.pixel));
    }
    let step_mm = 1e-4;
    for axis in 0..3 {
        let pixel_at = |h: f64| {
            let mut moved = point;
            moved[axis] += h;
            camera.project(&moved).unwrap().coords
        };
        agree(projection.by_point.column(axis).into(), difference(pixel_at, step_mm), step_mm)
            .map_err(|e| format!("by point {axis}: {e}"))?;
    }
    let parameters = camera.parameters();
    assert_eq!(parameters.len(), projection.by_parameters.len());
    for (index, (name, value)) in parameters.iter().enumerate() {
        let step = 1e-4 * value.abs().max(0.1);
        let pixel_at = |h: f64| {
            let mut values: Vec<f64> = parameters.iter().map(|(_, v)| *v).collect();
            values[index] += h;
            camera.with_parameters(&values).unwrap().project(&point).unwrap().coords
        };
        agree(projection.by_parameters[index], difference(pixel_at, step), step)
            .map_err(|e| format!("by {name}: {e}"))?;
    }
    Ok(())
}

proptest! {
    #![proptest_config(common::cases(4000))]

    #[test]
    fn derivatives_are_those_of_the_projection(
        (name, camera, pixel) in camera_and_pixel(),
        depth_mm in 1.0..20.0f64,
    ) {
        let ray = camera.unproject(&pixel).unwrap();
        if let Err(why) = check(&camera, ray.at(depth_mm)) {
            prop_assert!(false, "{name} at {pixel}: {why}");
        }
    }
}

#[test]
fn derivatives_hold_on_the_axis_and_just_behind_the_interface() {
    for (name, camera, _) in common::cameras() {
        let intrinsics = camera.lens().intrinsics();
        let axis = Point2::new(intrinsics.cx_px, intrinsics.cy_px);
        let ray = camera.unproject(&axis).unwrap();
        for depth_mm in [3e-4, 5.0] {
            let point = ray.at(depth_mm);
            // Differences need room on both sides.
            if depth_mm < 1.0 && *camera.interface() == Interface::None {
                continue;
            }
            let projection = camera.project_with_jacobians(&point).unwrap();
            let along = projection.by_point * ray.direction;
            // Moving along a ray does not move the pixel.
            assert!(along.norm() < 1e-9, "{name}: {along}");
            if depth_mm > 1.0 {
                check(&camera, point).unwrap_or_else(|why| panic!("{name}: {why}"));
            }
        }
    }
}

#[test]
fn a_point_on_the_interface_has_derivatives() {
    for (name, camera, _) in common::cameras() {
        match camera.interface() {
            Interface::None | Interface::FromDrawing => continue,
            // Behind a pane the surface of the gel is not the one that the lens looks at.
            Interface::Flat(flat) if flat.glass_thickness_mm > 0.0 => continue,
            _ => {}
        }
        let pixel = Point2::new(400.0, 300.0);
        let ray = camera.unproject(&pixel).unwrap();
        let projection = camera.project_with_jacobians(&ray.at(0.0)).unwrap();
        assert!((projection.pixel - pixel).norm() < 1e-9, "{name}");
        // On the surface, points move the pixel as if there were no interface.
        let bare = Camera::new(640, 480, *camera.lens(), Interface::None).unwrap();
        let without = bare.project_with_jacobians(&ray.at(0.0)).unwrap();
        let tangent: Vector3<f64> = surface_tangent(&camera, ray.at(0.0));
        let (with, without) = (projection.by_point * tangent, without.by_point * tangent);
        assert!((with - without).norm() <= 1e-6 * without.norm(), "{name}: {with} {without}");
    }
}

/// Some direction along the interface at one of its points.
fn surface_tangent(camera: &Camera, point: Point3<f64>) -> Vector3<f64> {
    let normal = match camera.interface() {
        Interface::Sphere(sphere) => point - sphere.centre_in_camera,
        // Two more points of the plane.
        _ => {
            let on_plane = |x, y| {
                let ray = camera.unproject(&Point2::new(x, y)).unwrap();
                ray.origin_in_camera
            };
            return on_plane(500.0, 200.0) - on_plane(200.0, 250.0);
        }
    };
    normal.cross(&Vector3::new(0.3, 0.5, -0.2))
}
