//! Cameras that cannot be are refused with figures, unusual ones come with a warning, and ordinary ones with none.

use crate::common;
use fabkit_camera::files::{CameraFormat, read, read_file, write};
use fabkit_camera::{
    Camera, CameraEstimate, CameraFinding, Eucm, Interface, Intrinsics, KannalaBrandt, Lens,
    OpenCv, plausibility,
};

/// A file of ROS with a pinhole, or a fisheye with coefficients.
fn ros([width, height]: [u32; 2], [fx, fy, cx, cy]: [f64; 4], k: &[f64]) -> String {
    let model = if k.is_empty() { "plumb_bob" } else { "equidistant" };
    format!(
        "image_width: {width}\nimage_height: {height}\ndistortion_model: {model}\n\
         camera_matrix: [{fx}, 0, {cx}, 0, {fy}, {cy}, 0, 0, 1]\ndistortion_coefficients: {k:?}\n"
    )
}

const VGA: [u32; 2] = [640, 480];

#[test]
fn matrices_in_other_units_are_refused_with_the_unit() {
    for (intrinsics, expected) in [
        ([0.0036, 0.0036, 0.00192, 0.00144], "is the matrix in metres?"),
        ([0.0036, 0.0036, 0.00192, 0.00144], "6 um give 600 px"),
        ([3.6, 3.6, 1.92, 1.44], "is the matrix in millimetres?"),
        ([0.9, 1.2, 0.5, 0.5], "divided by the image's size?"),
        ([0.0036, 0.0036, 319.5, 239.5], "is it in metres?"),
        ([3.6, 3.6, 319.5, 239.5], "is it in millimetres?"),
        // Micrometres, and a focal length of a lens in front of a telescope.
        ([3600.0, 3600.0, 1920.0, 1440.0], "must be -640 to 1280"),
        ([40000.0, 40000.0, 319.5, 239.5], "a field of view of 1.15 degrees"),
        ([2000.0, 400.0, 319.5, 239.5], "focal lengths of 2000 px along rows and 400"),
    ] {
        let error = read(&ros(VGA, intrinsics, &[])).unwrap_err();
        assert_eq!(error.faults.len(), 1 + usize::from(intrinsics[2] == 1920.0), "{error}");
        assert!(error.to_string().contains(expected), "{error}");
        assert!(error.to_string().starts_with("line 4: "), "{error}");
    }
    // The limit of lenses that see behind themselves is another, but millimetres are beyond it, too.
    let error = read(&ros(VGA, [3.6, 3.6, 319.5, 239.5], &[0.0; 4])).unwrap_err().to_string();
    assert!(error.contains("is 66.7 of them; at most 8 are possible"), "{error}");
}

#[test]
fn calibrations_at_another_size_are_recognised() {
    for (size, [cx, cy], expected) in [
        (VGA, [639.4, 479.6], "lies outside the image, 640 x 480 px (calibrated at 1280 x 960 px?"),
        (VGA, [639.4, 479.6], "Then fx = 250 and cx = (cx + 0.5) * 0.5 - 0.5"),
        (VGA, [630.1, 470.2], "lies in a corner of the image, 640 x 480 px (calibrated at 1280"),
        (VGA, [0.0, 0.0], "is it measured from the image's centre? Add 319.5 to cx and 239.5"),
        (VGA, [639.5, 359.5], "it is the centre of an image of about 1280 x 720 px"),
        (VGA, [631.0, 351.0], "lies on the border of the image, 640 x 480 px (it is the centre of"),
        ([320, 240], [639.5, 479.5], "calibrated at 1280 x 960 px?"),
        (VGA, [-30.0, 239.5], "measured from another corner"),
    ] {
        let error = read(&ros(size, [500.0, 500.0, cx, cy], &[])).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    for ([cx, cy], expected) in [
        ([159.5, 119.5], "calibrated at 320 x 240 px? Then fx = 1000"),
        ([81.0, 58.0], "calibrated at 160 x 120 px? Then fx = 2000"),
        ([239.5, 319.5], "are width and height exchanged?"),
        ([480.0, 239.5], "is the image a part of a larger one?"),
    ] {
        let file = read_file(&ros(VGA, [500.0, 500.0, cx, cy], &[]), None).unwrap();
        let warnings = file.warnings();
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        assert!(warnings[0].contains(expected), "{warnings:?}");
    }
}

#[test]
fn folds_are_stated_with_radius_and_share() {
    // r = t - t^3 / 3 stops growing at 1 rad, where it is 2/3.
    let k = [-1.0 / 3.0, 0.0, 0.0, 0.0];
    let text = ros(VGA, [290.0, 290.0, 319.5, 239.5], &k);
    let error = read(&text).unwrap_err().to_string();
    // 193.3 px: a circle with 38.2 % of the pixels, counted on a grid of 100 x 100.
    assert!(error.contains("grows up to 193 px (57.3 degrees)"), "{error}");
    let share: f64 = error.split("; ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    let circle = std::f64::consts::PI * (290.0 * 2.0 / 3.0f64).powi(2) / (640.0 * 480.0);
    assert!((share / 100.0 - (1.0 - circle)).abs() < 0.01, "{error}");

    // Beyond the short side only the corners are lost: a warning. 420 px are beyond the corners: nothing.
    for (focal, count) in [(450.0, 1), (630.0, 0)] {
        let file = read_file(&ros(VGA, [focal, focal, 319.5, 239.5], &k), None).unwrap();
        assert_eq!(file.findings.len(), count, "{:?}", file.findings);
    }
}

#[test]
fn real_cameras_are_ordinary() {
    for (size, [f, cx, cy], k) in [
        // A webcam, a phone, a macro lens, a microscope's objective.
        (VGA, [520.0, 331.0, 228.0], &[][..]),
        ([4032, 3024], [3100.0, 2030.0, 1490.0], &[]),
        ([1920, 1080], [9000.0, 980.0, 530.0], &[]),
        (VGA, [8000.0, 319.5, 239.5], &[]),
        // A 160 degree lens, a wide lens without distortion, a small part of an image with its own centre.
        (VGA, [286.0, 310.0, 250.0], &[0.02, -0.013, 0.004, -0.0007]),
        (VGA, [150.0, 319.5, 239.5], &[]),
        ([64, 48], [300.0, 35.0, 20.0], &[]),
    ] {
        let file = read_file(&ros(size, [f, f, cx, cy], k), None).unwrap();
        assert_eq!(file.warnings(), Vec::<String>::new());
    }
    // The round images of a fisheye and of an endoscope leave the corners dark: a warning, no error. The five terms of
    // a 160 degree lens fold in the corners.
    let intrinsics = |f: f64| Intrinsics { fx_px: f, fy_px: f, cx_px: 319.5, cy_px: 239.5 };
    for lens in [
        Lens::KannalaBrandt(KannalaBrandt::new(intrinsics(60.0), [0.0; 4]).unwrap()),
        Lens::KannalaBrandt(KannalaBrandt::new(intrinsics(240.0), [-0.14, 0.0, 0.0, 0.0]).unwrap()),
        Lens::Eucm(Eucm::new(intrinsics(100.0), 0.7, 1.0).unwrap()),
        Lens::OpenCv(OpenCv::new(common::INTRINSICS, &common::FIVE).unwrap()),
    ] {
        let camera = Camera::new(640, 480, lens, Interface::None).unwrap();
        let findings = plausibility(&camera);
        assert!(matches!(findings[..], [CameraFinding::FoldsBack { .. }]), "{findings:?}");
        assert!(!findings[0].is_impossible(), "{findings:?}");
    }
}

#[test]
fn our_own_format_keeps_impossible_cameras_and_says_so() {
    let intrinsics = Intrinsics { fx_px: 500.0, fy_px: 500.0, cx_px: 700.0, cy_px: 300.0 };
    let lens = Lens::OpenCv(OpenCv::new(intrinsics, &[]).unwrap());
    // A part of an image.
    let camera = Camera::new(640, 480, lens, Interface::None).unwrap();
    let estimate = CameraEstimate::from(camera);
    let text = write(&estimate, CameraFormat::Fabkit).unwrap();
    let file = read_file(&text, None).unwrap();
    assert_eq!(file.estimate, estimate);
    assert_eq!(file.warnings().len(), 1);
    let error = read(&text.replace("unusual: accepted\n", "")).unwrap_err().to_string();
    assert!(error.starts_with("line 9: the principal point (700.0, 300.0)"), "{error}");
    let error = read(&text.replace("accepted", "yes")).unwrap_err().to_string();
    assert!(error.contains("unusual: is `yes`, but must be `accepted`"), "{error}");
    let lossy = write(&estimate, CameraFormat::Ros).unwrap_err().to_string();
    assert!(lossy.contains("that its values are meant so"), "{lossy}");
}
