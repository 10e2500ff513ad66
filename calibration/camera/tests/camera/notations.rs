//! Camera files of all notations: the same camera in each, and what is said about files that are not read.

use crate::common;
use fabkit_camera::files::{NOTATIONS, read, read_file};
use fabkit_camera::{Camera, Interface, Intrinsics, KannalaBrandt, Lens, OpenCv, Point3};
use proptest::prelude::*;

const INTRINSICS: Intrinsics =
    Intrinsics { fx_px: 410.5, fy_px: 409.25, cx_px: 322.75, cy_px: 236.5 };
const RADTAN: [f64; 4] = [-0.11, 0.021, 0.0013, -0.0008];
const FISHEYE: [f64; 4] = [0.021, -0.013, 0.004, -0.0007];

/// A pinhole with distortion, in each notation. The third is the name to ask for.
const PINHOLES: [(&str, &str, Option<&str>); 15] = [
    (
        "OpenCV YAML",
        "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\nfisheye_model: 0\n\
         camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 410.5, 0., \
         322.75, 0., 409.25, 236.5, 0., 0., 1. ]\ndistortion_coefficients: !!opencv-matrix\n   \
         rows: 4\n   cols: 1\n   dt: d\n   data: [ -0.11, 0.021, 0.0013, -0.0008 ]\n",
        None,
    ),
    (
        "OpenCV XML",
        "<?xml version=\"1.0\"?>\n<opencv_storage>\n<image_Width>640</image_Width>\n\
         <image_Height>480</image_Height>\n<Camera_Matrix type_id=\"opencv-matrix\">\n<rows>3</rows>\
         <cols>3</cols><dt>d</dt>\n<data>\n 410.5 0. 322.75 0. 409.25 236.5 0. 0. 1.</data>\
         </Camera_Matrix>\n<Distortion_Coefficients type_id=\"opencv-matrix\"><rows>5</rows>\
         <cols>1</cols><dt>d</dt>\n<data>-0.11 0.021 0.0013 -0.0008 0.</data>\
         </Distortion_Coefficients>\n</opencv_storage>\n",
        None,
    ),
    (
        "nested rows, JSON",
        "{\"dim\": [640, 480], \"K\": [[410.5, 0, 322.75], [0, 409.25, 236.5], [0, 0, 1]], \"D\": \
         [[-0.11, 0.021, 0.0013, -0.0008, 0]]}",
        None,
    ),
    (
        "nested rows, YAML",
        "mtx:\n- [410.5, 0, 322.75]\n- [0, 409.25, 236.5]\n- [0, 0, 1]\ndist:\n- [-0.11]\n- \
         [0.021]\n- [0.0013]\n- [-0.0008]\n- [0]\nimage_size: [640, 480]\n",
        None,
    ),
    (
        "ROS YAML",
        "image_width: 640\nimage_height: 480\ncamera_matrix: {rows: 3, cols: 3, data: [410.5, 0, \
         322.75, 0, 409.25, 236.5, 0, 0, 1]}\ndistortion_model: plumb_bob\n\
         distortion_coefficients: {rows: 1, cols: 5, data: [-0.11, 0.021, 0.0013, -0.0008, 0]}\n",
        None,
    ),
    (
        "ROS echo",
        "header:\n  stamp:\n    sec: 3\n    nanosec: 5\n  frame_id: ''\nheight: 480\nwidth: 640\n\
         distortion_model: plumb_bob\nd:\n- -0.11\n- 0.021\n- 0.0013\n- -0.0008\n- 0.0\nk:\n- 410.5\n\
         - 0.0\n- 322.75\n- 0.0\n- 409.25\n- 236.5\n- 0.0\n- 0.0\n- 1.0\nbinning_x: 0\n---\n",
        None,
    ),
    (
        "ROS ini",
        "[image]\n\nwidth\n640\n\nheight\n480\n\n[left]\n\ncamera matrix\n410.5 0 322.75\n0 409.25 \
         236.5\n0 0 1\n\ndistortion\n-0.11 0.021 0.0013 -0.0008 0\n\n[right]\n\ncamera matrix\n400 0 \
         320\n0 400 240\n0 0 1\n\ndistortion\n0 0 0 0 0\n",
        Some("left"),
    ),
    (
        "Kalibr",
        "cam0:\n  camera_model: pinhole\n  intrinsics: [400, 400, 320, 240]\n  distortion_model: \
         none\n  distortion_coeffs: []\n  resolution: [640, 480]\ncam1:\n  T_cn_cnm1: [[1, 0, 0, 0], \
         [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n  camera_model: pinhole\n  intrinsics: [410.5, \
         409.25, 322.75, 236.5]\n  distortion_model: radtan\n  distortion_coeffs: [-0.11, 0.021, \
         0.0013, -0.0008]\n  resolution: [640, 480]\n",
        Some("cam1"),
    ),
    (
        "camodocal",
        "%YAML:1.0\n---\nmodel_type: PINHOLE\ncamera_name: a\nimage_width: 640\nimage_height: 480\n\
         distortion_parameters:\n   k1: -0.11\n   k2: 0.021\n   p1: 0.0013\n   p2: -0.0008\n\
         projection_parameters:\n   fx: 410.5\n   fy: 409.25\n   cx: 322.75\n   cy: 236.5\n",
        None,
    ),
    (
        "ORB-SLAM2",
        "%YAML:1.0\n#----\nCamera.fx: 410.5\nCamera.fy: 409.25\nCamera.cx: 322.75\nCamera.cy: 236.5\n\
         Camera.k1: -0.11\nCamera.k2: 0.021\nCamera.p1: 0.0013\nCamera.p2: -0.0008\nCamera.width: \
         640\nCamera.height: 480\nCamera.RGB: 1\n",
        None,
    ),
    (
        "ORB-SLAM3",
        "%YAML:1.0\nFile.version: \"1.0\"\nCamera.type: \"PinHole\"\nCamera1.fx: 410.5\nCamera1.fy: \
         409.25\nCamera1.cx: 322.75\nCamera1.cy: 236.5\nCamera1.k1: -0.11\nCamera1.k2: 0.021\n\
         Camera1.p1: 0.0013\nCamera1.p2: -0.0008\nCamera.width: 640\nCamera.height: 480\n",
        Some("Camera1"),
    ),
    (
        "mrcal",
        "{'lensmodel': 'LENSMODEL_OPENCV4', 'intrinsics': [410.5, 409.25, 322.75, 236.5, -0.11, \
         0.021, 0.0013, -0.0008,], 'imagersize': [640, 480,], 'extrinsics': [0, 0, 0, 0, 0, 0],}",
        None,
    ),
    (
        "COLMAP",
        "# Camera list with one line of data per camera:\n1 OPENCV 640 480 410.5 409.25 323.25 237 \
         -0.11 0.021 0.0013 -0.0008\n",
        None,
    ),
    (
        "COLMAP, by id",
        "1 PINHOLE 64 48 50 50 32 24\n4 FULL_OPENCV 640 480 410.5 409.25 323.25 237 -0.11 0.021 \
         0.0013 -0.0008 0 0 0 0\n",
        Some("4"),
    ),
    (
        "fabkit",
        "fabkit_camera: 1\nwidth_px: 640\nheight_px: 480\nlens: {model: opencv, fx_px: 410.5, fy_px: \
         409.25, cx_px: 322.75, cy_px: 236.5, k1: -0.11, k2: 0.021, p1: 0.0013, p2: -0.0008, k3: 0}\n",
        None,
    ),
];

const FISHEYES: [(&str, &str); 7] = [
    (
        "nested column",
        "{\"width\": 640, \"height\": 480, \"K\": [[410.5, 0, 322.75], [0, 409.25, 236.5], [0, 0, \
         1]], \"D\": [[0.021], [-0.013], [0.004], [-0.0007]]}",
    ),
    (
        "ROS",
        "height: 480\nwidth: 640\ndistortion_model: equidistant\nD: [0.021, -0.013, 0.004, -0.0007]\n\
         K: [410.5, 0, 322.75, 0, 409.25, 236.5, 0, 0, 1]\n...\n",
    ),
    (
        "Kalibr",
        "cam0: {camera_model: pinhole, intrinsics: [410.5, 409.25, 322.75, 236.5], distortion_model: \
         equidistant, distortion_coeffs: [0.021, -0.013, 0.004, -0.0007], resolution: [640, 480]}\n",
    ),
    (
        "camodocal",
        "model_type: KANNALA_BRANDT\nimage_width: 640\nimage_height: 480\nprojection_parameters: {k2: \
         0.021, k3: -0.013, k4: 0.004, k5: -0.0007, mu: 410.5, mv: 409.25, u0: 322.75, v0: 236.5}\n",
    ),
    (
        "ORB-SLAM",
        "Camera.type: KannalaBrandt8\nCamera1.fx: 410.5\nCamera1.fy: 409.25\nCamera1.cx: 322.75\n\
         Camera1.cy: 236.5\nCamera1.k1: 0.021\nCamera1.k2: -0.013\nCamera1.k3: 0.004\nCamera1.k4: \
         -0.0007\nCamera.width: 640\nCamera.height: 480\n",
    ),
    ("COLMAP", "1 OPENCV_FISHEYE 640 480 410.5 409.25 323.25 237 0.021 -0.013 0.004 -0.0007\n"),
    (
        "OpenCV XML",
        "<opencv_storage><image_width>640</image_width><image_height>480</image_height>\
         <fisheye_model>1</fisheye_model><camera_matrix type_id=\"opencv-matrix\"><data>410.5 0 322.75 \
         0 409.25 236.5 0 0 1</data></camera_matrix><distortion_coefficients><data>0.021 -0.013 0.004 \
         -0.0007</data></distortion_coefficients></opencv_storage>",
    ),
];

/// Returns the largest distance of projections of points all over the image, px.
fn largest_difference(camera: &Camera, expected: &Camera) -> f64 {
    let mut largest = 0.0f64;
    for i in -6..=6 {
        for j in -6..=6 {
            let point = Point3::new(0.1 * f64::from(i), 0.08 * f64::from(j), 1.0);
            let [a, b] = [camera, expected].map(|camera| camera.project(&point).unwrap());
            largest = largest.max((a - b).norm());
        }
    }
    largest
}

#[test]
fn every_notation_gives_the_same_pinhole() {
    let lens = Lens::OpenCv(OpenCv::new(INTRINSICS, &RADTAN).unwrap());
    let expected = Camera::new(640, 480, lens, Interface::None).unwrap();
    for (title, text, name) in PINHOLES {
        let file = read_file(text, name).unwrap_or_else(|error| panic!("{title}: {error}"));
        // The same numbers, in another order of operations at most.
        let error = largest_difference(file.estimate.camera(), &expected);
        assert!(error < 1e-9, "{title}: {error:e} px");
        assert_eq!(file.warnings(), Vec::<String>::new(), "{title}");
    }
}

#[test]
fn every_notation_gives_the_same_fisheye() {
    let lens = Lens::KannalaBrandt(KannalaBrandt::new(INTRINSICS, FISHEYE).unwrap());
    let expected = Camera::new(640, 480, lens, Interface::None).unwrap();
    for (title, text) in FISHEYES {
        let file = read_file(text, None).unwrap_or_else(|error| panic!("{title}: {error}"));
        let error = largest_difference(file.estimate.camera(), &expected);
        assert!(error < 1e-9, "{title}: {error:e} px");
        // Only a guess is told.
        assert_eq!(file.warnings().len(), usize::from(title == "nested column"), "{title}");
    }
}

#[test]
fn an_empty_model_is_a_rectified_camera() {
    let text = "distortion_model: ''\nheight: 480\nwidth: 640\nD: []\nK: [410.5, 0, 322.75, 0, 409.25, \
        236.5, 0, 0, 1]\nR: [0, 0, 0, 0, 0, 0, 0, 0, 0]\n";
    let file = read_file(text, None).unwrap();
    assert_eq!(file.estimate.camera().lens().coefficients(), [0.0; 5]);
    assert_eq!(file.warnings(), Vec::<String>::new());
    assert_eq!(read(&text.replace("D: []", "D: null")).unwrap(), file.estimate);
    for (from, to, expected) in [
        ("D: []", "D: [0.1, 0, 0, 0, 0]", "is empty, but there are 5 coefficients"),
        (
            "410.5, 0, 322.75, 0, 409.25, 236.5, 0, 0, 1",
            "0, 0, 0, 0, 0, 0, 0, 0, 0",
            "not calibrated",
        ),
    ] {
        let error = read(&text.replace(from, to)).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn nested_matrices_keep_their_shape() {
    let good = "{\"w\": 640, \"h\": 480, \"K\": [[410, 0, 322], [0, 409, 236], [0, 0, 1]], \"D\": [0, 0, 0, \
        0, 0]}";
    read(good).unwrap();
    for (from, to, expected) in [
        ("[0, 409, 236]", "[0, 409]", "its rows have different numbers of columns"),
        (", [0, 0, 1]", "", "camera_matrix: has 6 numbers; 9 are needed"),
        ("[0, 409, 236]", "[0, NaN, 236]", "`NaN` is not a finite number"),
        (
            "[[410, 0, 322], [0, 409, 236], [0, 0, 1]]",
            "[410, 0, 0, 0, 409, 0, 322, 236, 1]",
            "written column by column",
        ),
        ("[0, 409, 236]", "7", "must be a list of numbers"),
        ("[0, 0, 0, 0, 0]", "[[0], [0], [0], [0]]", "four coefficients are either"),
    ] {
        let error = read(&good.replace(from, to)).unwrap_err().to_string();
        assert!(error.contains(expected), "{to}: {error}");
    }
}

#[test]
fn cameras_may_stand_under_their_names() {
    let one =
        "{image_width: 640, image_height: 480, K: [410, 0, 322, 0, 409, 236, 0, 0, 1], D: []}";
    let text = format!("left: {one}\nright: {}\nbaseline: 3\n", one.replace("410", "411"));
    let right = read_file(&text, Some("right")).unwrap();
    assert_eq!(right.estimate.camera().lens().intrinsics().fx_px, 411.0);
    let error = read(&text).unwrap_err().to_string();
    assert!(error.contains("2 cameras: `left`, `right` (write FILE#left"), "{error}");
    let pair = "image_size: [640, 480]\nM1: [410, 0, 322, 0, 409, 236, 0, 0, 1]\nD1: []\n\
        M2: [411, 0, 322, 0, 409, 236, 0, 0, 1]\nD2: []\n";
    assert_eq!(read_file(pair, Some("M2")).unwrap().estimate, right.estimate);
    let error = read(pair).unwrap_err().to_string();
    assert!(error.contains("2 cameras: `M1`, `M2`"), "{error}");
    let error = read_file(one, Some("left")).unwrap_err().to_string();
    assert!(error.contains("has no name; `left` was asked for (leave out the #"), "{error}");
}

#[test]
fn unknown_files_are_told_what_is_read_and_what_they_lack() {
    let error = read("a: 1\n").unwrap_err().to_string();
    for notation in NOTATIONS {
        assert!(error.contains(notation.name) && error.contains(notation.told_by), "{error}");
    }
    let error = read("image_width: 640\nD: []\n").unwrap_err().to_string();
    assert!(error.starts_with("this camera file lacks `camera_matrix`"), "{error}");
}

#[test]
fn the_book_lists_all_notations() {
    let page = include_str!("../../../../docs/reference/files.md");
    for name in NOTATIONS.iter().flat_map(|notation| notation.name.split(", ")) {
        let row = format!("| {name} | ");
        assert!(name == "fabkit" || page.contains(&row), "docs/reference/files.md: {name}");
    }
}

#[test]
fn models_of_mrcal_may_be_long() {
    let (_, text, _) = PINHOLES.into_iter().find(|(title, ..)| *title == "mrcal").unwrap();
    let inputs = format!("'optimization_inputs': b'{}',}}", "x#{[".repeat(1 << 19));
    let long = format!("{}{inputs}", text.strip_suffix('}').unwrap());
    assert_eq!(read(&long).unwrap(), read(text).unwrap());
}

proptest! {
    #![proptest_config(common::cases(3000))]

    /// Damaged files of all notations may be refused, or be read as another camera, but reading ends in one of these.
    #[test]
    fn damaged_files_end_in_a_camera_or_an_error(
        which in 0..PINHOLES.len(),
        cut in 0..900usize,
        removed in 0..40usize,
        insert in "[-0-9:{}<>/\\[\\]&*!%., \na-k#'\"]{0,4}",
    ) {
        let (_, text, name) = PINHOLES[which];
        let cut = cut % text.len();
        let damaged =
            format!("{}{insert}{}", &text[..cut], &text[(cut + removed).min(text.len())..]);
        let _ = read_file(&damaged, name);
        // Cut off.
        let _ = read_file(&text[..cut], name);
    }
}
