//! Against OpenCV's own numbers.
//!
//! Made with opencv-python-headless 5.0.0: `cv2.projectPoints` and `cv2.fisheye.projectPoints` with
//! identity pose, the intrinsics below and the coefficients beside each table. OpenCV computes in
//! double precision; 1e-9 px allows for another order of the same operations.

use fabkit_camera::{Camera, Interface, Intrinsics, KannalaBrandt, Lens, OpenCv, Point2, Point3};

const INTRINSICS: Intrinsics = Intrinsics {
    fx_px: 299.97297618,
    fy_px: 299.81689507,
    cx_px: 325.24480754,
    cy_px: 264.89790698,
};

/// Point in mm, pixel.
type Golden = ([f64; 3], [f64; 2]);

fn compare(lens: Lens, golden: &[Golden]) {
    let camera = Camera::new(640, 480, lens, Interface::None).unwrap();
    for (point, pixel) in golden {
        let error = camera.project(&Point3::from(*point)).unwrap() - Point2::from(*pixel);
        assert!(error.norm() < 1e-9, "{point:?}: {error}");
    }
}

#[test]
fn five_terms_project_as_opencv_does() {
    let k = [-0.25971254, 0.08700416, -1.4873e-5, -2.28895e-4, -0.01535192];
    compare(
        Lens::OpenCv(OpenCv::new(INTRINSICS, &k).unwrap()),
        &[
            ([1.0, 2.0, 10.0], [354.85405377788453, 324.0922267533982]),
            ([-7.0, 3.0, 9.0], [126.09805798729926, 350.17785257794475]),
            ([6.0, -5.5, 8.0], [506.7401514998605, 98.54400532679784]),
            ([0.5, 0.25, 20.0], [332.74246846783484, 268.64481018633944]),
            ([-9.0, -8.0, 10.0], [119.97004240418931, 82.60837576545799]),
        ],
    );
}

#[test]
fn eight_terms_project_as_opencv_does() {
    let k = [0.95, 0.18, 4e-4, -7e-4, 0.004, 1.26, 0.42, 0.03];
    compare(
        Lens::OpenCv(OpenCv::new(INTRINSICS, &k).unwrap()),
        &[
            ([1.0, 2.0, 10.0], [354.77823087901385, 323.96100368014993]),
            ([-7.0, 3.0, 9.0], [130.33061495822432, 348.4105647935775]),
            ([6.0, -5.5, 8.0], [500.6655634377431, 104.10421262433923]),
            ([0.5, 0.25, 20.0], [332.74196486006355, 268.64471086390444]),
            ([-9.0, -8.0, 10.0], [128.18476917287094, 90.26896479332805]),
        ],
    );
}

#[test]
fn fisheye_up_to_84_degrees() {
    let k = [0.02, -0.013, 0.004, -0.0007];
    compare(
        Lens::KannalaBrandt(KannalaBrandt::new(INTRINSICS, k).unwrap()),
        &[
            ([0.858317, 0.151344, 9.961947], [351.0286134463022, 269.44190870256676]),
            ([-3.213938, 3.830222, 8.660254], [223.8222131475948, 385.7057521078282]),
            ([-2.961981, -8.137977, 5.0], [216.6709657479372, -33.25109865579316]),
            ([4.924039, -8.528685, 1.736482], [536.5729295938656, -100.94265406254772]),
            ([7.038514, 7.038514, 0.958458], [640.4135446508219, 579.9026563644874]),
            ([3.0, 1.0, 0.5], [731.1772275143927, 400.13830909313776]),
        ],
    );
}
