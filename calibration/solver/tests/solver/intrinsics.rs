//! Calibration of a camera from known corners with known noise.

use crate::common::scene::{Studio, USUAL, fisheye, somewhere};
use fabkit_calibration::board::{Board, find_corners};
use fabkit_calibration::intrinsics::{
    BoardView, CornerObservation, LensCalibrationError, LensModel, calibrate,
};
use fabkit_camera::{
    Camera, Interface, Intrinsics, Lens, OpenCv, Point2, Point3, Vector2, Vector3,
};
use fabkit_geometry::sequences::SplitMix64;
use fabkit_geometry::{Angle, Matrix3, Pose};

const KB: &[LensModel] = &[LensModel::KannalaBrandt];

fn board() -> Board {
    Board::checkerboard("test", [9, 6], 3.0).unwrap()
}

/// Returns the camera of the data sheet, whose angle is 10 % off.
fn nominal() -> Camera {
    Camera::equidistant(640, 480, 145f64.to_radians()).unwrap()
}

/// Projects the corners of a board at known poses, with normal noise.
fn observe(
    studio: &Studio,
    board: &Board,
    poses: &[Pose],
    noise_px: f64,
    random: &mut SplitMix64,
) -> Vec<BoardView> {
    let view = |(index, pose): (usize, &Pose)| {
        let truth = studio.truth(board, pose).unwrap();
        let mut corner = |(c, pixel): (&fabkit_calibration::board::BoardCorner, &Point2<f64>)| {
            let noise = Vector2::new(random.normal(), random.normal()) * noise_px;
            let [x, y] = c.in_board_mm;
            CornerObservation {
                id: c.id,
                in_board_mm: Point2::new(x, y),
                pixel: pixel + noise,
                sigma_px: noise_px.max(0.01),
            }
        };
        let corners = board.corners.iter().zip(&truth).map(&mut corner).collect();
        BoardView { name: format!("view {index}"), corners }
    };
    poses.iter().enumerate().map(view).collect()
}

fn poses(studio: &Studio, board: &Board, count: usize, random: &mut SplitMix64) -> Vec<Pose> {
    let size = f64::from(board.squares[0]) * board.square_mm;
    let mut poses = Vec::new();
    while poses.len() < count {
        let pose = somewhere(board, random, [0.35 * size, 1.3 * size], 60.0, 50.0);
        if studio.shows(board, &pose, 2.0) {
            poses.push(pose);
        }
    }
    poses
}

fn fx(camera: &Camera) -> f64 {
    camera.lens().intrinsics().fx_px
}

/// 200 trials of 15 views with 0.1 px of noise: the focal length is within three of its standard
/// deviations in at least 95 %, and these are not stated larger than they are. The number within
/// one standard deviation is binomial with p = 0.683: 137 +- 6.6.
#[test]
fn focal_length_is_as_sure_as_it_says() {
    let (studio, board) = (Studio::new(fisheye()), board());
    let (mut within_three, mut within_one, mut relative) = (0, 0, 0.0);
    for trial in 0..200 {
        let mut random = SplitMix64::new(1000 + trial);
        let poses = poses(&studio, &board, 15, &mut random);
        let views = observe(&studio, &board, &poses, 0.1, &mut random);
        let found = calibrate(&views, &nominal(), KB).unwrap();
        let sigma = found.estimate.sigmas().unwrap()[0];
        let error = (fx(found.estimate.camera()) - fx(&studio.camera)).abs();
        within_three += u32::from(error < 3.0 * sigma);
        within_one += u32::from(error < sigma);
        relative += sigma / fx(&studio.camera) / 200.0;
        assert!(
            (found.residual_scale - 1.0).abs() < 0.12,
            "trial {trial}: {}",
            found.residual_scale
        );
    }
    println!(
        "within 3 sigma {within_three}/200, within 1 sigma {within_one}/200, sigma {relative:.2e}"
    );
    assert!(within_three >= 190);
    assert!((117..=157).contains(&within_one));
}

#[test]
fn exact_corners_give_the_exact_camera() {
    let (studio, board) = (Studio::new(fisheye()), board());
    let mut random = SplitMix64::new(3);
    let poses = poses(&studio, &board, 8, &mut random);
    let views = observe(&studio, &board, &poses, 0.0, &mut random);
    let found = calibrate(&views, &nominal(), &LensModel::ALL).unwrap();
    assert_eq!(found.model, LensModel::KannalaBrandt);
    let truth = studio.camera.parameters();
    for ((name, value), (_, expected)) in found.estimate.camera().parameters().iter().zip(&truth) {
        assert!((value - expected).abs() < 1e-6 * expected.abs().max(0.1), "{name}: {value}");
    }
    for (view, pose) in found.views.iter().zip(&poses) {
        let off = (view.camera_from_board.translation_mm() - pose.translation_mm()).norm();
        assert!(off < 1e-6, "{}: {off} mm", view.name);
    }
}

/// Boards almost parallel to the image give small residuals and a focal length that may be far off. The result must say
/// so, in numbers and in words.
#[test]
fn frontal_boards_are_named() {
    // A narrow lens: a fisheye tells angles apart even on a frontal board.
    let intrinsics = Intrinsics { fx_px: 700.0, fy_px: 700.0, cx_px: 322.0, cy_px: 238.0 };
    let lens = OpenCv::new(intrinsics, &[-0.1, 0.02, 0.0, 0.0, 0.0]).unwrap();
    let camera = Camera::new(640, 480, Lens::OpenCv(lens), Interface::None).unwrap();
    let (studio, board) = (Studio::new(camera), board());
    let mut random = SplitMix64::new(4);
    let turn = |random: &mut SplitMix64| Angle::from_deg(random.between(-4.0, 4.0)).unwrap();
    let poses: Vec<Pose> = (0..10)
        .map(|_| {
            Pose::translation(random.between(-16.0, -11.0), random.between(-11.0, -7.0), 40.0)
                .then_in(Pose::rotation_x(turn(&mut random)))
                .then_in(Pose::rotation_y(turn(&mut random)))
        })
        .collect();
    let views = observe(&studio, &board, &poses, 0.14, &mut random);
    let nominal = Camera::equidistant(640, 480, 60f64.to_radians()).unwrap();
    let found = calibrate(&views, &nominal, &[LensModel::OpenCv5]).unwrap();
    let [focal_px, sigma_px] = found.focal_px;
    println!("focal {focal_px:.1} +- {sigma_px:.1}, truth 700; rms {:.3}", found.rms_px);
    assert!(found.rms_px < 0.25, "{}", found.rms_px);
    assert!(sigma_px > 0.01 * 700.0, "{sigma_px}");
    assert!((focal_px - 700.0).abs() < 3.0 * sigma_px, "{focal_px} +- {sigma_px}");
    let first = &found.advice.warnings[0];
    assert!(first.contains("parallel to the image") && first.contains("mrad"), "{first}");
}

#[test]
fn images_choose_the_lens_model() {
    // Tangential distortion, which no fisheye model has.
    let intrinsics = Intrinsics { fx_px: 430.0, fy_px: 432.0, cx_px: 318.0, cy_px: 243.0 };
    let lens = OpenCv::new(intrinsics, &[-0.2, 0.05, 0.004, -0.006, 0.0]).unwrap();
    let camera = Camera::new(640, 480, Lens::OpenCv(lens), Interface::None).unwrap();
    let (studio, board) = (Studio::new(camera), board());
    let mut random = SplitMix64::new(5);
    let size = f64::from(board.squares[0]) * board.square_mm;
    let mut poses = Vec::new();
    while poses.len() < 12 {
        let pose = somewhere(&board, &mut random, [0.9 * size, 1.5 * size], 25.0, 45.0);
        if studio.shows(&board, &pose, 2.0) {
            poses.push(pose);
        }
    }
    let views = observe(&studio, &board, &poses, 0.1, &mut random);
    let nominal = Camera::equidistant(640, 480, 85f64.to_radians()).unwrap();
    let found = calibrate(&views, &nominal, &LensModel::ALL).unwrap();
    for candidate in &found.candidates {
        println!("{:?}", candidate);
    }
    assert_eq!(found.model, LensModel::OpenCv5);
    let sigmas = found.estimate.sigmas().unwrap();
    for (i, (name, truth)) in studio.camera.parameters().iter().enumerate() {
        let value = found.estimate.camera().parameters()[i].1;
        assert!((value - truth).abs() < 4.0 * sigmas[i], "{name}: {value} +- {}", sigmas[i]);
    }
    // A fisheye lens beyond what a pinhole can see: those models say that they cannot. 12 views of
    // usual corners do not tell the others apart, and the simplest predicts best what was left out;
    // better corners show what it lacks.
    for (noise_px, expected) in [(0.1, LensModel::Eucm), (0.02, LensModel::KannalaBrandt)] {
        let (studio, mut random) = (Studio::new(fisheye()), SplitMix64::new(6));
        let poses = self::poses(&studio, &board, 12, &mut random);
        let views = observe(&studio, &board, &poses, noise_px, &mut random);
        let found = calibrate(&views, &self::nominal(), &LensModel::ALL).unwrap();
        for candidate in &found.candidates {
            println!("{:?}", candidate);
            let is_pinhole = candidate.model.name().starts_with("opencv");
            assert_eq!(candidate.fit.is_none(), is_pinhole);
        }
        assert_eq!(found.model, expected);
    }
}

#[test]
fn gross_errors_do_not_pull() {
    let (studio, board) = (Studio::new(fisheye()), board());
    let mut random = SplitMix64::new(7);
    let poses = poses(&studio, &board, 15, &mut random);
    let mut views = observe(&studio, &board, &poses, 0.1, &mut random);
    // One corner in 40 lies on its neighbour.
    for view in &mut views {
        view.corners[17].pixel = view.corners[18].pixel;
    }
    let found = calibrate(&views, &nominal(), KB).unwrap();
    let error = (fx(found.estimate.camera()) / fx(&studio.camera) - 1.0).abs();
    println!("relative error with outliers {error:.1e}");
    assert!(error < 1e-3);
}

#[test]
fn views_that_add_nothing_and_views_that_do_not_belong_are_named() {
    let (studio, board) = (Studio::new(fisheye()), board());
    let mut random = SplitMix64::new(8);
    let mut poses = poses(&studio, &board, 10, &mut random);
    // Far away in the middle: a few pixels that say little.
    let [w, h] = board.squares.map(|n| f64::from(n) * board.square_mm);
    poses.push(Pose::translation(-0.5 * w, -0.5 * h, 300.0));
    let mut views = observe(&studio, &board, &poses, 0.1, &mut random);
    for corner in &mut views[4].corners {
        // A bent board.
        corner.pixel.x += 1.5 * (corner.in_board_mm.x * 0.3).sin();
    }
    let found = calibrate(&views, &nominal(), KB).unwrap();
    let all = found.advice.warnings.join("\n");
    println!("{all}");
    assert!(found.advice.influence[10].adds_nothing);
    assert!(all.contains("nothing would be lost without view 10"), "{all}");
    assert!(all.contains("view 4: residuals are"), "{all}");
}

#[test]
fn too_little_is_refused() {
    let (studio, board) = (Studio::new(fisheye()), board());
    let mut random = SplitMix64::new(9);
    let poses = poses(&studio, &board, 3, &mut random);
    let mut views = observe(&studio, &board, &poses, 0.1, &mut random);
    assert!(calibrate(&views, &nominal(), KB).is_ok());
    views[1].corners.truncate(5);
    let refused = calibrate(&views, &nominal(), KB).unwrap_err();
    assert_eq!(refused, LensCalibrationError::TooFewViews { usable: 2 });
    views[0].corners[3].pixel.x = f64::NAN;
    let refused = calibrate(&views, &nominal(), KB).unwrap_err();
    assert!(refused.to_string().contains("view 0: corner 3"), "{refused}");
    // The same view thrice is one view: eight equations for eight unknowns, and poses.
    let pose = poses[0];
    let same = observe(&studio, &board, &[pose; 3], 0.0, &mut random);
    match calibrate(&same, &nominal(), KB) {
        Err(LensCalibrationError::NotObservable { .. }) => {}
        Ok(found) => assert!(found.advice.influence.iter().all(|w| w.growth < 0.3)),
        Err(other) => panic!("{other}"),
    }
}

/// Returns views of boards far away in the middle of the image: some 17 of 80 degrees to all sides.
fn central_views(studio: &Studio, board: &Board, random: &mut SplitMix64) -> Vec<BoardView> {
    let mut poses = Vec::new();
    while poses.len() < 12 {
        let pose = somewhere(board, random, [50.0, 80.0], 4.0, 45.0);
        if studio.shows(board, &pose, 2.0) {
            poses.push(pose);
        }
    }
    observe(studio, board, &poses, 0.1, random)
}

/// Returns the root mean square angle between the rays of two cameras at the corners of some views, without the best
/// common rotation.
fn rays_apart_rad(views: &[BoardView], a: &Camera, b: &Camera) -> f64 {
    let pixels = views.iter().flat_map(|view| &view.corners).map(|corner| corner.pixel);
    let pairs: Vec<_> = pixels
        .map(|pixel| {
            (a.unproject(&pixel).unwrap().direction, b.unproject(&pixel).unwrap().direction)
        })
        .collect();
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for (a, b) in &pairs {
        normal += Matrix3::identity() - a * a.transpose();
        right += a.cross(&(b - a));
    }
    let turn = normal.try_inverse().unwrap() * right;
    let apart = pairs.iter().map(|(a, b)| (b - a - turn.cross(a)).norm_squared());
    (apart.sum::<f64>() / pairs.len() as f64).sqrt()
}

/// The parameters are undetermined, but rays are right, and the result says so.
#[test]
fn central_views_tell_rays_and_no_more() {
    let (studio, board) = (Studio::new(fisheye()), board());
    let mut random = SplitMix64::new(11);
    let views = central_views(&studio, &board, &mut random);
    let found = calibrate(&views, &nominal(), &LensModel::ALL).unwrap();
    for candidate in &found.candidates {
        println!("{:?}", candidate);
    }
    println!("{:?}\n{}", found.rays, found.advice.warnings.join("\n"));
    // Nothing tells the models apart: the simplest, and of those the one whose focal length is one.
    assert_eq!(found.model, LensModel::Eucm);
    let [focal_px, sigma_px] = found.focal_px;
    let truth_px = fx(&studio.camera);
    println!("focal {focal_px:.2} +- {sigma_px:.2}, truth {truth_px}");
    assert!(sigma_px < 0.01 * truth_px, "{sigma_px}");
    assert!((focal_px - truth_px).abs() < 4.0 * sigma_px, "{focal_px} +- {sigma_px}");
    // The double sphere's says the same, though its parameters do not.
    let double = calibrate(&views, &nominal(), &[LensModel::DoubleSphere]).unwrap();
    let ratio = double.focal_px[1] / sigma_px;
    println!("as a double sphere {:?} of {:?}", double.focal_px, double.estimate.sigmas());
    assert!((double.focal_px[0] - focal_px).abs() < sigma_px && (0.8..1.25).contains(&ratio));
    assert!(double.estimate.sigmas().unwrap()[0] > 10.0 * double.focal_px[1]);
    for found in [&found, &double] {
        let all = found.advice.warnings.join("\n");
        assert!(!all.contains("focal length") && !all.contains("optical axis"), "{all}");
        assert!(all.contains("the lens model extrapolates, rays to"), "{all}");
        let (seen, beyond) = (found.rays.observed, found.rays.extrapolated.unwrap());
        assert!(
            seen.worst.px < 0.5 && beyond.worst.px > 10.0 * seen.worst.px,
            "{seen:?} {beyond:?}"
        );
        let apart_rad = rays_apart_rad(&views, found.estimate.camera(), &studio.camera);
        println!("rays are {:.3} mrad apart", 1e3 * apart_rad);
        assert!(apart_rad < 3.0 * seen.worst.angle_rad, "{apart_rad}");
    }
}

/// In 60 calibrations, rays scatter as predicted, between the typical and the worst value.
#[test]
fn rays_are_as_sure_as_they_say() {
    let (studio, board) = (Studio::new(fisheye()), board());
    let (mut squares, mut typical, mut worst) = (0.0, 0.0, 0.0);
    for trial in 0..60 {
        let mut random = SplitMix64::new(2000 + trial);
        let views = central_views(&studio, &board, &mut random);
        let found = calibrate(&views, &nominal(), KB).unwrap();
        let seen = found.rays.observed;
        squares += rays_apart_rad(&views, found.estimate.camera(), &studio.camera).powi(2) / 60.0;
        typical += seen.typical.angle_rad / 60.0;
        worst += seen.worst.angle_rad / 60.0;
    }
    let scatter = squares.sqrt();
    println!("scatter {scatter:.3e}, typical {typical:.3e}, worst {worst:.3e} rad");
    // 60 trials of a few parameters: a root mean square to about 5 %.
    assert!(scatter > 0.85 * typical && scatter < 1.15 * worst);
}

/// Calibrates from rendered images.
#[test]
fn rendered_boards_give_the_true_camera() {
    let (studio, board) = (Studio::new(fisheye()), board());
    let mut random = SplitMix64::new(10);
    let poses = poses(&studio, &board, 15, &mut random);
    let mut views = Vec::new();
    for (index, pose) in poses.iter().enumerate() {
        let image = studio.picture(&board, pose, USUAL, &mut random);
        let Ok(found) = find_corners(&image, &board) else { continue };
        let corners = found.iter().map(|corner| {
            let [x, y] = board.corners[corner.id as usize].in_board_mm;
            CornerObservation {
                id: corner.id,
                in_board_mm: Point2::new(x, y),
                pixel: corner.pixel,
                sigma_px: corner.sigma_px,
            }
        });
        views.push(BoardView { name: format!("image {index}"), corners: corners.collect() });
    }
    assert!(views.len() >= 14);
    let found = calibrate(&views, &nominal(), &LensModel::ALL).unwrap();
    let sigmas = found.estimate.sigmas().unwrap();
    println!(
        "rms {:.4} px, scale {:.2}, {:?}\n{}",
        found.rms_px,
        found.residual_scale,
        found.estimate.camera().parameters(),
        found.advice.warnings.join("\n")
    );
    assert!(found.rms_px < 0.1);
    let error = (fx(found.estimate.camera()) - fx(&studio.camera)).abs();
    assert!(error < 3.5 * sigmas[0], "{error} against {}", sigmas[0]);
    // Everywhere in sight, pixels lie where the true camera has them.
    for theta_deg in [10.0f64, 30.0, 50.0, 65.0] {
        let (s, c) = theta_deg.to_radians().sin_cos();
        let point = Point3::new(0.6 * s, 0.8 * s, c);
        let there = found.estimate.camera().project(&point).unwrap();
        let off = (there - studio.camera.project(&point).unwrap()).norm();
        assert!(off < 0.15, "{theta_deg} degrees: {off} px");
    }
}
