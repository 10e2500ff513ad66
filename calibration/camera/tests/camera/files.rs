//! Camera files: round trips, other programs' files, and files that must be refused.

use crate::common;
use fabkit_camera::files::{CameraFormat, read, read_file, write};
use fabkit_camera::{Camera, CameraEstimate, DMatrix, Interface, Lens, OpenCv, Point3, Vector3};
use proptest::prelude::*;

/// A covariance with correlations, as a product of a matrix with its transpose.
fn covariance(n: usize) -> DMatrix<f64> {
    let root = DMatrix::from_fn(n, n, |r, c| 1e-3 / (1.0 + r as f64 + 2.0 * c as f64));
    &root * root.transpose()
}

#[test]
fn our_own_format_keeps_everything() {
    for (name, camera, _) in common::cameras() {
        for covariance in [None, Some(covariance(camera.parameter_count()))] {
            let estimate = CameraEstimate::new(camera, covariance).unwrap();
            let text = write(&estimate, CameraFormat::Fabkit).unwrap();
            assert_eq!(read(&text).unwrap(), estimate, "{name}:\n{text}");
        }
    }
}

#[test]
fn a_lens_by_itself_says_so_in_our_format_and_is_a_lens_in_others() {
    let (_, camera, _) = common::cameras().into_iter().next().unwrap();
    let estimate = CameraEstimate::from(camera.without_interface()).with_drawn_interface();
    let text = write(&estimate, CameraFormat::Fabkit).unwrap();
    assert!(text.contains("interface:\n  kind: drawn\n"), "{text}");
    assert_eq!(read(&text).unwrap(), estimate);
    let opencv = write(&estimate, CameraFormat::OpenCv).unwrap();
    assert_eq!(read(&opencv).unwrap(), estimate.without_drawn_interface());
}

#[test]
fn other_formats_give_back_what_they_take_and_name_what_they_cannot() {
    for (name, camera, _) in common::cameras() {
        for format in [CameraFormat::OpenCv, CameraFormat::Ros, CameraFormat::Kalibr] {
            let holds = match (camera.lens(), format) {
                _ if *camera.interface() != Interface::None => false,
                (Lens::OpenCv(lens), CameraFormat::Kalibr) => {
                    *lens == OpenCv::new(common::INTRINSICS, &[]).unwrap()
                }
                (Lens::OpenCv(_) | Lens::KannalaBrandt(_), _) => true,
                (_, format) => format == CameraFormat::Kalibr,
            };
            let estimate = CameraEstimate::new(camera, None).unwrap();
            match write(&estimate, format) {
                Ok(text) => {
                    assert!(holds, "{name}: {format:?} loses something");
                    assert_eq!(read(&text).unwrap(), estimate, "{name}:\n{text}");
                }
                Err(lossy) => assert!(!holds, "{name}: {lossy}"),
            }
        }
    }
}

#[test]
fn losses_are_named_all_at_once() {
    let (_, camera, _) =
        common::cameras().into_iter().find(|(name, ..)| name == "double sphere / tilted").unwrap();
    let covariance = covariance(camera.parameter_count());
    let estimate = CameraEstimate::new(camera, Some(covariance)).unwrap();
    assert_eq!(
        write(&estimate, CameraFormat::Ros).unwrap_err().to_string(),
        "a camera file of format `ros` would lose the lens model (double-sphere) and the \
         refractive interface (flat) and the covariance of the parameters"
    );
    let five = Lens::OpenCv(OpenCv::new(common::INTRINSICS, &common::FIVE).unwrap());
    let camera = Camera::new(640, 480, five, Interface::None).unwrap();
    let estimate = CameraEstimate::new(camera, None).unwrap();
    let lossy = write(&estimate, CameraFormat::Kalibr).unwrap_err().to_string();
    assert!(lossy.ends_with("would lose the distortion beyond k1 k2 p1 p2 (k3)"), "{lossy}");
}

/// Written by `cv2.FileStorage` of opencv-python-headless 5.0.0, with an older first line.
const OPENCV: &str = "\
%YAML:1.0
---
image_width: 640
image_height: 480
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 299.97297617999999, 0., 325.24480754000001, 0.,
       299.81689506999999, 264.89790698000002, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ -0.25971253999999999, 0.087004159999999997, -1.4873e-05,
       -0.00022889500000000001, -0.01535192 ]
";

#[test]
fn opencv_files_are_read() {
    let estimate = read(OPENCV).unwrap();
    let camera = estimate.camera();
    assert_eq!((camera.width_px(), camera.height_px()), (640, 480));
    let intrinsics = camera.lens().intrinsics();
    assert_eq!((intrinsics.fx_px, intrinsics.fy_px), (299.97297618, 299.81689507));
    assert_eq!((intrinsics.cx_px, intrinsics.cy_px), (325.24480754, 264.89790698));
    assert_eq!(camera.lens().coefficients(), common::FIVE);
    assert_eq!(camera.lens().model_name(), "opencv");
    assert_eq!(estimate.covariance(), None);
    // OpenCV 5 writes a directive that is YAML.
    let newer = OPENCV.replace("%YAML:1.0", "%YAML 1.2");
    assert_eq!(read(&newer).unwrap(), estimate);
}

#[test]
fn four_coefficients_need_a_statement() {
    let four = OPENCV.replace(", -0.01535192 ]", " ]").replace("001,\n", "001\n");
    let four = four.replace("-0.00022889500000000001,", "-0.00022889500000000001");
    let error = read(&four).unwrap_err().to_string();
    assert!(error.contains("fisheye_model: 1"), "{error}");
    let fisheye = read(&four.replace("image_width", "fisheye_model: 1\nimage_width")).unwrap();
    assert_eq!(fisheye.camera().lens().model_name(), "kannala-brandt");
    let pinhole = read(&four.replace("image_width", "fisheye_model: 0\nimage_width")).unwrap();
    assert_eq!(pinhole.camera().lens().coefficients()[3..], [common::FIVE[3], 0.0]);
}

#[test]
fn kalibr_files_are_read() {
    // The layout of the format's documentation, with other numbers.
    let chain = |model: &str, intrinsics: &str, distortion: &str, k: &str| {
        format!(
            "cam0:\n  cam_overlaps: []\n  camera_model: {model}\n  intrinsics: {intrinsics}\n  \
             distortion_model: {distortion}\n  distortion_coeffs: {k}\n  rostopic: /cam0/image\n  \
             resolution: [752, 480]\n"
        )
    };
    let radtan =
        chain("pinhole", "[461.6, 460.1, 362.6, 246.0]", "radtan", "[-0.2, 0.06, 1e-3, 2e-4]");
    let camera = *read(&radtan).unwrap().camera();
    assert_eq!(camera.lens().coefficients(), [-0.2, 0.06, 1e-3, 2e-4, 0.0]);

    // Mei's model: x / (z + xi d) scaled by the focal length.
    let xi = 0.8;
    let omni = chain("omni", "[0.8, 833.0, 830.0, 373.0, 253.0]", "none", "[]");
    let camera = *read(&omni).unwrap().camera();
    let point = fabkit_camera::Point3::new(3.0, -4.0, 1.0);
    let denominator = point.z + xi * point.coords.norm();
    let pixel = camera.project(&point).unwrap();
    assert!((pixel.x - (833.0 * point.x / denominator + 373.0)).abs() < 1e-10);
    assert!((pixel.y - (830.0 * point.y / denominator + 253.0)).abs() < 1e-10);

    let distorted = omni.replace("[]\n  ros", "[0.1, 0, 0, 0]\n  ros");
    let error = read(&distorted).unwrap_err().to_string();
    assert!(error.starts_with("line 6: distortion_coeffs: `omni`"), "{error}");
    let two = format!("{radtan}cam1:\n  camera_model: pinhole\n");
    let error = read(&two).unwrap_err().to_string();
    assert!(
        error.starts_with("the file holds 2 cameras: `cam0`, `cam1` (write FILE#cam0"),
        "{error}"
    );
    assert_eq!(read_file(&two, Some("cam0")).unwrap().estimate, read(&radtan).unwrap());
}

#[test]
fn bad_values_are_named_with_line_and_limit() {
    let bad = OPENCV
        .replace("image_width: 640", "image_width: 0")
        .replace("299.97297617999999", "-3.")
        .replace("299.81689506999999", ".Nan");
    let error = read(&bad).unwrap_err();
    let text = error.to_string();
    assert_eq!(error.faults.len(), 3, "{text}");
    assert!(text.contains("line 3: width_px: is 0, but must be at least 1"), "{text}");
    assert!(text.contains("fx_px: is -3, but must be above 0"), "{text}");
    assert!(text.contains("line 10: camera_matrix: `.Nan` is not a finite number"), "{text}");

    for (from, to, expected) in [
        ("325.24480754000001", "9e3", "cx_px: is 9000, but must be -640 to 1280"),
        ("image_width: 640", "image_width: 640.5", "640.5 is not a whole number of pixels"),
        ("image_width: 640", "image_width: 90000000", "at most 64000000 pixels"),
        ("image_width: 640\n", "", "image_width: is missing"),
        ("299.97297617999999, 0.,", "299.9, 0.7,", "a skew of 0.7 px"),
        ("-0.25971253999999999", "-1e5", "folds back"),
        ("-0.25971253999999999", "1e300", "k1: is 1e300"),
        ("rows: 3", "rows: *three", "aliases"),
        ("dt: d", "dt: &d d", "anchors"),
        ("!!opencv-matrix", "!!python/object", "tags"),
        ("image_height: 480", "image_width: 480", "written twice"),
    ] {
        let text = OPENCV.replace(from, to);
        match read(&text) {
            Ok(_) => panic!("{to} was accepted"),
            Err(error) => assert!(error.to_string().contains(expected), "{error}"),
        }
    }
}

#[test]
fn our_own_format_is_strict() {
    let (_, camera, _) = common::cameras().into_iter().find(|c| c.0 == "eucm / sphere").unwrap();
    let estimate = CameraEstimate::new(camera, Some(covariance(camera.parameter_count()))).unwrap();
    let good = write(&estimate, CameraFormat::Fabkit).unwrap();
    for (from, to, expected) in [
        ("fabkit_camera: 1", "fabkit_camera: 2", "version `2` is not known"),
        ("model: eucm", "model: ucm", "`ucm` is not a lens model"),
        ("  alpha:", "  alfa:", "alfa: is not a known key"),
        ("kind: sphere", "kind: cube", "`cube` is not a kind of interface"),
        ("radius_mm: 11.0", "radius_mm: 1.0", "the lens must be inside the sphere"),
        ("index_outside: 1.41", "index_outside: 0.9", "interface_index_outside: is 0.9"),
        (
            "index_outside: 1.41",
            "index_outside: 1.41\n  behind: glass",
            "behind: `glass` is nothing",
        ),
        ("names: [fx_px, fy_px", "names: [fy_px, fx_px", "names: are not the parameters"),
        ("matrix:\n    - [", "matrix:\n    - [1e9, ", "a row has 12 numbers; 11 are needed"),
        ("matrix:\n    - [", "matrix:\n    - [-", "covariance"),
    ] {
        assert!(good.contains(from), "{from} not in\n{good}");
        let error = read(&good.replace(from, to)).unwrap_err().to_string();
        assert!(error.contains(expected), "{to}: {error}");
    }
}

#[test]
fn other_texts_are_refused() {
    for (text, expected) in [
        ("", "empty"),
        ("42", "no camera file"),
        ("a: [1, 2", "not YAML"),
        ("camera_matrix: 3", "camera_matrix"),
        ("cam0: 3", "resolution: is missing"),
        ("fabkit_camera: 1", "lens: is missing"),
    ] {
        let error = read(text).unwrap_err().to_string();
        assert!(error.contains(expected), "{text}: {error}");
    }
    let error = read(&" ".repeat((1 << 20) + 1)).unwrap_err().to_string();
    assert!(error.contains("at most 1048576"), "{error}");
    let error = read(&"[".repeat(5000)).unwrap_err().to_string();
    assert!(error.contains("deep") || error.contains("not YAML"), "{error}");
}

proptest! {
    #![proptest_config(common::cases(3000))]

    /// A damaged file may be refused or read as another camera, but reading ends in one of these.
    #[test]
    fn damaged_files_do_not_break_the_reader(
        which in 0..3usize,
        cut in 0..600usize,
        insert in "[-0-9:{}\\[\\]&*!%., \na-k#'\"]{0,4}",
    ) {
        let (_, camera, _) = common::cameras().remove([0, 18, 8][which]);
        let text = match which {
            0 => OPENCV.to_owned(),
            _ => write(&CameraEstimate::new(camera, None).unwrap(), CameraFormat::Fabkit).unwrap(),
        };
        let cut = cut % text.len();
        let damaged = format!("{}{insert}{}", &text[..cut], &text[(cut + 1).min(text.len())..]);
        if let Ok(estimate) = read(&damaged) {
            let again = write(&estimate, CameraFormat::Fabkit).unwrap();
            prop_assert_eq!(read(&again).unwrap(), estimate);
        }
    }
}

#[test]
fn the_table_of_lens_models_names_them_all() {
    let page = include_str!("../../../../docs/theory/cameras.md");
    let rows = page.lines().skip_while(|line| !line.starts_with("| model | file name |")).skip(2);
    let rows: Vec<&str> = rows.take_while(|line| line.starts_with('|')).collect();
    let said = rows.iter().flat_map(|row| row.split('`').skip(1).step_by(2));
    let mut said: Vec<&str> = said.collect();
    let mut known: Vec<&str> = fabkit_camera::LensModel::ALL.map(|model| model.name()).into();
    said.sort_unstable();
    known.sort_unstable();
    assert_eq!(said, known, "docs/theory/cameras.md");
}

#[test]
fn every_registered_model_sees_what_it_projects_and_is_kept_by_our_own_format() {
    for model in fabkit_camera::LensModel::ALL {
        let lens = model.start_lens(common::INTRINSICS).unwrap();
        let camera = Camera::new(640, 480, lens, Interface::None).unwrap();
        let direction = Vector3::new(0.3, -0.2, 1.0).normalize();
        let pixel = camera.project(&Point3::from(direction)).unwrap();
        let seen = camera.unproject(&pixel).unwrap().direction;
        assert!((seen - direction).norm() < 1e-12, "{}", model.name());
        let estimate = CameraEstimate::new(camera, None).unwrap();
        assert_eq!(read(&write(&estimate, CameraFormat::Fabkit).unwrap()).unwrap(), estimate);
    }
}
