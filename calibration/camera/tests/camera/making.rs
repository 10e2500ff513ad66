//! Construction and validation of cameras and estimates.

use crate::common;
use fabkit_camera::{
    Camera, CameraEstimate, DMatrix, FlatInterface, Interface, InvalidCovariance, Point2, Point3,
};

#[test]
fn parameters_have_names_and_go_both_ways() {
    for (name, camera, _) in common::cameras() {
        let parameters = camera.parameters();
        assert_eq!(parameters.len(), camera.parameter_count(), "{name}");
        let values: Vec<f64> = parameters.iter().map(|(_, value)| *value).collect();
        assert_eq!(camera.with_parameters(&values).unwrap(), camera, "{name}");
        let error = camera.with_parameters(&values[1..]).unwrap_err();
        assert_eq!(error.violations[0].field, "number of parameters");
        assert_eq!(
            parameters[..4].iter().map(|(n, _)| *n).collect::<Vec<_>>(),
            ["fx_px", "fy_px", "cx_px", "cy_px"]
        );
    }
    let (_, camera, _) = common::cameras().into_iter().find(|c| c.0 == "eucm / pane").unwrap();
    assert_eq!(
        camera.parameters()[4..].iter().map(|(n, _)| *n).collect::<Vec<_>>(),
        [
            "alpha",
            "beta",
            "interface_distance_mm",
            "interface_tilt_x_rad",
            "interface_tilt_y_rad",
            "interface_index_outside",
        ]
    );
}

#[test]
fn impossible_cameras_are_refused_with_all_reasons() {
    let (_, camera, _) = common::cameras().remove(0);
    let mut values: Vec<f64> = camera.parameters().iter().map(|(_, value)| *value).collect();
    values[0] = 0.0;
    values[1] = f64::NAN;
    values[8] = f64::INFINITY;
    let fields: Vec<_> = camera.with_parameters(&values).unwrap_err().violations;
    assert_eq!(fields.iter().map(|v| v.field).collect::<Vec<_>>(), ["fx_px", "fy_px", "k3"]);

    let interface = Interface::Flat(FlatInterface {
        distance_mm: -1.0,
        ..FlatInterface::bare_in_air(1.0, 0.5)
    });
    let error = Camera::new(0, 480, *camera.lens(), interface).unwrap_err();
    assert_eq!(
        error.to_string(),
        "width_px = 0: must be at least 1; interface_distance_mm = -1: must be above 0 and at \
         most 1000; interface_index_outside = 0.5: must be at least the index on the lens's side \
         (1) and at most 4"
    );
    assert!(Camera::equidistant(640, 480, f64::NAN).is_err());
    assert!(Camera::equidistant(8000, 8001, 2.0).is_err());
}

#[test]
fn the_nominal_lens_spreads_its_angle_over_the_diagonal() {
    let camera = Camera::equidistant(640, 480, 160f64.to_radians()).unwrap();
    let corner = Point2::new(-0.5, -0.5);
    let ray = camera.unproject(&corner).unwrap();
    assert!((ray.direction.z - 80f64.to_radians().cos()).abs() < 1e-14);
    assert!(camera.is_in_image(&corner) && !camera.is_in_image(&Point2::new(639.5, 0.0)));
    // The published focal length of a 160 degree, 640 x 480 camera is 300 px: within a tenth.
    let fx_px = camera.lens().intrinsics().fx_px;
    assert!((fx_px / 300.0 - 1.0).abs() < 0.1, "{fx_px}");
    assert_eq!(ray.at(3.0), Point3::from(ray.direction * 3.0));
}

#[test]
fn covariances_are_checked() {
    let (_, camera, _) = common::cameras().remove(18);
    let n = camera.parameter_count();
    let make = |matrix: DMatrix<f64>| CameraEstimate::new(camera, Some(matrix));
    let mut good = DMatrix::identity(n, n) * 0.04;
    good[(4, 4)] = 1e-16;
    good[(5, 5)] = 0.0; // held
    let sigmas = make(good.clone()).unwrap().sigmas().unwrap();
    assert!((sigmas[0] - 0.2).abs() < 1e-15 && (sigmas[4] - 1e-8).abs() < 1e-20);
    assert_eq!(sigmas[5], 0.0);

    assert!(matches!(make(DMatrix::identity(n, n + 1)), Err(InvalidCovariance::WrongSize { .. })));
    let mut bad = good.clone();
    bad[(1, 2)] = f64::NAN;
    assert!(matches!(
        make(bad),
        Err(InvalidCovariance::NotFinite { row: "fy_px", column: "cx_px" })
    ));
    let mut bad = good.clone();
    bad[(0, 4)] = 1e-9;
    assert!(matches!(
        make(bad),
        Err(InvalidCovariance::NotSymmetric { row: "fx_px", column: "k1" })
    ));
    // A correlation of 1.5, between parameters of very different scale.
    let mut bad = good.clone();
    (bad[(0, 4)], bad[(4, 0)]) = (3e-9, 3e-9);
    assert!(matches!(make(bad), Err(InvalidCovariance::NotPositive { .. })));
    let mut bad = good;
    bad[(5, 5)] = -1e-20;
    assert!(matches!(make(bad), Err(InvalidCovariance::NotPositive { .. })));
}
