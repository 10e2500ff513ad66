//! Interfaces against the laws of refraction themselves.

use crate::common;
use crate::common::camera_and_pixel;
use fabkit_camera::{
    Camera, FlatInterface, Interface, OutsideDomain, Point2, Point3, SphericalInterface, Vector3,
};
use proptest::prelude::*;

/// Normal of an interface at a point of it, away from the lens.
fn normal_at(interface: &Interface, point: &Point3<f64>) -> Vector3<f64> {
    match interface {
        Interface::None | Interface::FromDrawing => Vector3::z(),
        Interface::Flat(flat) => {
            let about_y = nalgebra::Rotation3::from_axis_angle(&Vector3::y_axis(), flat.tilt_y_rad);
            let about_x = nalgebra::Rotation3::from_axis_angle(&Vector3::x_axis(), flat.tilt_x_rad);
            about_x * (about_y * Vector3::z())
        }
        Interface::Sphere(sphere) => (point - sphere.centre_in_camera).normalize(),
    }
}

fn with_interface(camera: &Camera, interface: Interface) -> Camera {
    Camera::new(camera.width_px(), camera.height_px(), *camera.lens(), interface).unwrap()
}

proptest! {
    #![proptest_config(common::cases(10_000))]

    #[test]
    fn rays_start_on_the_interface_and_obey_snell((name, camera, pixel) in camera_and_pixel()) {
        let ray = camera.unproject(&pixel).unwrap();
        let before = with_interface(&camera, Interface::None).unproject(&pixel).unwrap().direction;
        let start = ray.origin_in_camera;
        let normal = normal_at(camera.interface(), &start);
        let ratio = match camera.interface() {
            Interface::None | Interface::FromDrawing => {
                prop_assert_eq!(ray.direction, before);
                prop_assert_eq!(start, Point3::origin());
                return Ok(());
            }
            Interface::Flat(flat) => {
                let height_mm = normal.dot(&start.coords);
                let expected_mm = flat.distance_mm + flat.glass_thickness_mm;
                prop_assert!((height_mm - expected_mm).abs() < 1e-12, "{name}: {height_mm}");
                // In the pane the ray crosses sideways what Snell's law says for glass.
                let sine = before.cross(&normal).norm();
                let on_glass = before * (flat.distance_mm / before.dot(&normal));
                let in_glass = start.coords - on_glass;
                let in_glass_sine = sine / flat.index_glass;
                let shift_mm = flat.glass_thickness_mm * in_glass_sine.asin().tan();
                prop_assert!((in_glass.cross(&normal).norm() - shift_mm).abs() < 1e-12);
                flat.index_outside / flat.index_inside
            }
            Interface::Sphere(sphere) => {
                let reach_mm = (start - sphere.centre_in_camera).norm();
                prop_assert!((reach_mm - sphere.radius_mm).abs() < 1e-12);
                prop_assert!(start.coords.cross(&before).norm() < 1e-12);
                sphere.index_outside / sphere.index_inside
            }
        };
        // Snell's law with its plane of incidence: n (direction x normal) stays.
        let change = before.cross(&normal) - ray.direction.cross(&normal) * ratio;
        prop_assert!(change.norm() < 1e-14, "{name}: {change}");
        prop_assert!(ray.direction.dot(&normal) > 0.0);
    }

    #[test]
    fn an_interface_between_equal_media_does_nothing(
        (_, camera, pixel) in camera_and_pixel(),
        depth_mm in 0.0..20.0f64,
    ) {
        let same = match *camera.interface() {
            Interface::None | Interface::FromDrawing => Interface::None,
            Interface::Flat(flat) => Interface::Flat(FlatInterface {
                index_inside: 1.33,
                index_glass: 1.33,
                index_outside: 1.33,
                ..flat
            }),
            Interface::Sphere(sphere) => {
                Interface::Sphere(SphericalInterface { index_outside: sphere.index_inside, ..sphere })
            }
        };
        let point = with_interface(&camera, same).unproject(&pixel).unwrap().at(depth_mm);
        if point.coords.norm() > 0.1 {
            let seen = with_interface(&camera, Interface::None).project(&point).unwrap();
            prop_assert!((seen - pixel).norm() < 1e-9);
        }
    }

    #[test]
    fn a_pane_of_gel_is_gel_and_a_pane_of_air_is_air(
        x_mm in -30.0..30.0f64,
        y_mm in -30.0..30.0f64,
        depth_mm in 0.0..30.0f64,
    ) {
        let (_, camera, _) = common::cameras().remove(0);
        let pane = FlatInterface { glass_thickness_mm: 1.5, tilt_y_rad: 0.1, ..FlatInterface::bare_in_air(3.0, 1.41) };
        let point = Point3::new(x_mm, y_mm, depth_mm + 8.0);
        let pixel = |flat| with_interface(&camera, Interface::Flat(flat)).project(&point).unwrap();
        let bare = FlatInterface { glass_thickness_mm: 0.0, ..pane };
        let of_gel = pixel(FlatInterface { index_glass: 1.41, ..pane });
        prop_assert!((of_gel - pixel(bare)).norm() < 1e-9);
        let of_air = pixel(FlatInterface { index_glass: 1.0, ..pane });
        let farther = pixel(FlatInterface { distance_mm: 4.5, ..bare });
        prop_assert!((of_air - farther).norm() < 1e-9);
    }
}

#[test]
fn things_in_gel_look_nearer() {
    // Apparent depth near the normal: depth / index.
    let (_, camera, _) = common::cameras().remove(0);
    let camera = with_interface(&camera, Interface::Flat(FlatInterface::bare_in_air(4.0, 1.41)));
    let bare = with_interface(&camera, Interface::None);
    let point = Point3::new(1e-4, -2e-4, 4.0 + 7.05);
    let seen = camera.project(&point).unwrap();
    let apparent = bare.project(&Point3::new(1e-4, -2e-4, 4.0 + 5.0)).unwrap();
    // The next term is of third order in 2e-4 / 9.
    assert!((seen - apparent).norm() < 1e-9, "{seen} {apparent}");
}

#[test]
fn a_concentric_sphere_bends_nothing() {
    for (_, camera, most_rad) in
        common::cameras().into_iter().filter(|c| c.0.ends_with("/ concentric"))
    {
        let bare = with_interface(&camera, Interface::None);
        let (sin, cos) = most_rad.sin_cos();
        let point = Point3::new(15.0 * sin, 0.0, 15.0 * cos);
        let (with, without) = (camera.project(&point).unwrap(), bare.project(&point).unwrap());
        assert!((with - without).norm() < 1e-10);
    }
}

#[test]
fn nearly_concentric_is_nearly_nothing() {
    // The plane of incidence hangs on a vector of 1e-12 mm; the answer must not.
    let (_, camera, _) = common::cameras().remove(18);
    let sphere = SphericalInterface {
        centre_in_camera: Point3::new(1e-12, 0.0, -1e-13),
        radius_mm: 8.0,
        index_inside: 1.0,
        index_outside: 1.5,
        has_drawn_bodies_behind: false,
    };
    let near = with_interface(&camera, Interface::Sphere(sphere));
    let bare = with_interface(&camera, Interface::None);
    let point = Point3::new(3.0, -7.0, 6.0);
    assert!((near.project(&point).unwrap() - bare.project(&point).unwrap()).norm() < 1e-9);
    let derivatives = near.project_with_jacobians(&point).unwrap();
    assert!(derivatives.by_parameters.iter().all(|c| c.x.is_finite() && c.y.is_finite()));
}

#[test]
fn points_and_pixels_without_a_path_are_refused() {
    let camera = Camera::equidistant(640, 480, 200f64.to_radians()).unwrap();
    let flat = with_interface(&camera, Interface::Flat(FlatInterface::bare_in_air(4.0, 1.41)));
    let refused = flat.project(&Point3::new(1.0, 1.0, 3.0)).unwrap_err();
    assert_eq!(refused, OutsideDomain::BeforeInterface { depth_mm: 1.0 });
    assert!(flat.project_with_jacobians(&Point3::new(1.0, 1.0, 3.0)).is_err());
    assert!(flat.project(&Point3::new(1.0, 1.0, 4.0)).is_ok());
    // The lens sees this pixel at 100 degrees, where there is no window.
    let refused = flat.unproject(&Point2::new(319.5 + 400.0, 239.5)).unwrap_err();
    match refused {
        OutsideDomain::MissesInterface { angle_rad } => {
            assert!((angle_rad.to_degrees() - 100.0).abs() < 1e-9);
        }
        other => panic!("{other}"),
    }
    let sphere = SphericalInterface {
        centre_in_camera: Point3::new(0.0, 0.0, 2.0),
        radius_mm: 10.0,
        index_inside: 1.0,
        index_outside: 1.41,
        has_drawn_bodies_behind: false,
    };
    let within = with_interface(&camera, Interface::Sphere(sphere));
    let refused = within.project(&Point3::new(0.0, 0.0, 9.0)).unwrap_err();
    assert_eq!(refused, OutsideDomain::BeforeInterface { depth_mm: 3.0 });
}
