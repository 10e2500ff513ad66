//! Lenses as they are: what papers, data sheets and published calibrations say of each sensor's camera.

use fabkit_camera::Camera;
use fabkit_geometry::{NominalCamera, Projection};
use fabkit_optics::{CameraView, OpticalStack, RayEnd, ViewStacks};
use fabkit_tests::build_design;
use nalgebra::Point2;

/// Radius in the image of what is seen at an angle off the axis, px.
fn radius_px(camera: &NominalCamera, degrees: f64) -> f64 {
    camera.focal_px() * camera.lens.projection.radius(degrees.to_radians())
}

/// PP-Tac's repository, `Calibration/sensor1/calibration_new.cfg`: focal length and radial terms of OpenCV.
fn published_rtac0_px(degrees: f64) -> f64 {
    let out = degrees.to_radians().tan();
    let u = out * out;
    299.9 * out * (1.0 + u * (-0.259_713 + u * (0.087_004 - u * 0.015_352)))
}

#[test]
fn rtac0s_lens_is_the_published_one_where_that_was_fitted() {
    let camera = build_design("rtac0", &[]).sensor.camera;
    let tolerance = camera.lens.tolerance;
    for degrees in [10.0, 20.0, 30.0, 40.0] {
        let off = radius_px(&camera, degrees) - published_rtac0_px(degrees);
        assert!(off.abs() < 2.6, "{off} px at {degrees} degrees");
    }
    assert!((camera.focal_px() / 299.9 - 1.0).abs() < tolerance.focal_share);
    assert!(tolerance.centre_px > 25.4, "{}", tolerance.centre_px);
    // The law that was drawn before is not within the bound.
    let was = build_design("rtac0", &["camera.projection=equidistant"]).sensor.camera;
    assert!(published_rtac0_px(40.0) - radius_px(&was, 40.0) > 10.0);
}

#[test]
fn shadowtacs_focal_length_is_that_of_lens_and_pixels() {
    let camera = build_design("shadowtac", &[]).sensor.camera;
    assert_eq!(camera.lens.projection, Projection::Stereographic);
    let off = camera.focal_px() / (2.8 / 0.003_45) - 1.0;
    assert!(off.abs() < 1e-3, "{off}");
}

/// Reaches of the surface from the middle of UVDtact's image, px: along a row, a column, and both diagonals.
fn reaches(set: &[&str]) -> Vec<f64> {
    let sensor = build_design("uvdtact", set).sensor;
    let nominal = &sensor.camera;
    let (view_rad, terms) = (nominal.field_of_view.rad(), nominal.lens.projection.terms());
    let camera =
        Camera::from_data_sheet(nominal.width_px, nominal.height_px, view_rad, terms).unwrap();
    let sights = ViewStacks::new(OpticalStack::from_sensor(&sensor).unwrap());
    let mut viewer = CameraView::new(&camera, &nominal.sensor_from_camera, &sights);
    let half = f64::from(nominal.width_px) / 2.0 - 0.5;
    let mut is_seen = |x: f64, y: f64| {
        let pixel = Point2::new(half + x, half + y);
        viewer.path(&pixel).is_ok_and(|path| matches!(path.end, RayEnd::Surface))
    };
    let ways = [[1.0, 0.0], [0.0, 1.0], [0.6, 0.8], [-0.6, 0.8], [-1.0, 0.0], [0.0, -1.0]];
    let steps = |way: [f64; 2], is_seen: &mut dyn FnMut(f64, f64) -> bool| {
        let seen = (1..=200).take_while(|&step| {
            let r = f64::from(step) - 0.5;
            is_seen(r * way[0], r * way[1])
        });
        seen.count() as f64
    };
    ways.map(|way| steps(way, &mut is_seen)).to_vec()
}

#[test]
fn uvdtacts_image_is_the_papers_circle() {
    for reach in reaches(&[]) {
        assert!((152.0..=155.5).contains(&reach), "{reach} px; the paper crops to 311");
    }
    // As it was drawn: the whole image.
    let full = reaches(&["camera.field_of_view=120deg", "camera.front_depth=2.6mm"]);
    assert!(full.iter().all(|&reach| reach > 190.0), "{full:?}");
}
