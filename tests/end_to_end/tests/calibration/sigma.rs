//! The sigma of ground truth against the scatter of simulated recalibrations.

use fabkit_application::depth::ground_truth::{
    DepthMap, PixelRays, PlacedIndenter, ReferenceSurface, StandardDeviations, Uncertainty,
};
use fabkit_calibration::extrinsics::{JointCovariance, Loss, PoseSolution, joint_estimate, refine};
use fabkit_calibration::intrinsics::{self, BoardView, LensModel};
use fabkit_calibration::landmarks::PinLandmark;
use fabkit_calibration::model::{FitParameter, Model};
use fabkit_calibration::synthetic::SyntheticSensor;
use fabkit_camera::{
    Camera, CameraEstimate, DMatrix, FlatInterface, Interface, Intrinsics, JointEstimate,
    KannalaBrandt, Lens, Point2, Vector2,
};
use fabkit_geometry::sequences::SplitMix64;
use fabkit_geometry::{Angle, Point3, Pose, Solid, Vector3};
use fabkit_tests::builtin_designs;

const TRIALS: usize = 500;
const SIGMA_PX: f64 = 0.03;
/// Of fx, fy, cx, cy, px, and of the first radial coefficient.
const CAMERA_SIGMAS: [f64; 5] = [0.02, 0.02, 0.02, 0.02, 1e-3];

/// A tenth of a common sensor's pixels, so that 500 maps are cast in a moment.
fn camera(interface: Interface) -> Camera {
    let intrinsics = Intrinsics { fx_px: 20.0, fy_px: 20.0, cx_px: 32.2, cy_px: 23.8 };
    let lens = KannalaBrandt::new(intrinsics, [0.01, -0.002, 0.0, 0.0]).unwrap();
    Camera::new(64, 48, Lens::KannalaBrandt(lens), interface).unwrap()
}

/// 29 pins that touch a ball of 15 mm about (0, 0, 6).
fn pins() -> Vec<PinLandmark> {
    let rings = [(0.0f64, 1), (18.0, 4), (36.0, 8), (54.0, 8), (72.0, 8)];
    let places = rings.into_iter().flat_map(|(polar_deg, count)| {
        (0..count).map(move |k| {
            let (s, c) = polar_deg.to_radians().sin_cos();
            let (y, x) = (f64::from(k) * std::f64::consts::TAU / f64::from(count)).sin_cos();
            Vector3::new(s * x, s * y, c)
        })
    });
    let centre = Point3::new(0.0, 0.0, 6.0);
    let pin = |(hole, outward): (u32, Vector3<f64>)| PinLandmark {
        hole,
        kind: "long".into(),
        tip_centre_in_sensor_mm: centre + 16.0 * outward,
        contact_in_sensor_mm: centre + 15.0 * outward,
        axis_in_sensor: Some(-outward),
    };
    (1..).zip(places).map(pin).collect()
}

/// For each pixel that has a value in all maps, in order; a map holds that many `axes` of one pixel after the other, of which
/// the squares are summed.
fn scatter_over_sigma(maps: &[Vec<f64>], axes: usize, predicted: &[f64]) -> Vec<f64> {
    let count = maps.len() as f64;
    let variance = |at: usize| {
        let mean = maps.iter().map(|map| map[at]).sum::<f64>() / count;
        maps.iter().map(|map| (map[at] - mean).powi(2)).sum::<f64>() / (count - 1.0)
    };
    let mut ratios: Vec<f64> = (0..predicted.len())
        .filter(|&pixel| maps.iter().all(|map| map[axes * pixel].is_finite()))
        .filter(|&pixel| predicted[pixel].is_finite() && predicted[pixel] > 0.0)
        .map(|pixel| {
            let all = (axes * pixel..axes * (pixel + 1)).map(variance).sum::<f64>();
            all.sqrt() / predicted[pixel]
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    ratios
}

/// What is known of each pixel, and how many numbers that is.
const QUANTITIES: [(&str, usize); 4] =
    [("range", 1), ("point", 3), ("indentation", 1), ("normal", 3)];

/// Each of them, pixel by pixel.
fn quantities(map: &DepthMap) -> [Vec<f64>; 4] {
    let flat = |all: Vec<Vector3<f64>>| all.into_iter().flat_map(|v| [v.x, v.y, v.z]).collect();
    [
        map.range_mm().to_vec(),
        flat(map.point_in_sensor().map(|point| point.coords).collect()),
        map.indentation_mm().collect(),
        flat(map.normal_in_sensor()),
    ]
}

fn predicted(sigmas: &StandardDeviations) -> [Vec<f64>; 4] {
    [
        sigmas.range_mm().collect(),
        sigmas.point_mm().collect(),
        sigmas.indentation_mm().collect(),
        sigmas.normal_rad().collect(),
    ]
}

#[test]
fn sigma_is_the_scatter_of_500_recalibrations() {
    let designs = builtin_designs();
    let rtac0 = designs.iter().find(|design| design.sensor.name == "rtac0").unwrap();
    let touch = rtac0.sensor.touch.as_ref().unwrap();
    let behind_glass = Interface::Flat(FlatInterface::bare_in_air(2.0, 1.41));
    for (interface, with_camera) in
        [(Interface::None, false), (Interface::None, true), (behind_glass, true)]
    {
        let camera = camera(interface);
        let degrees = |deg| Angle::from_deg(deg).unwrap();
        let assembled = Pose::translation(0.4, -0.3, 7.6)
            .then_in(Pose::rotation_x(degrees(1.2)))
            .then_in(Pose::rotation_y(degrees(-0.8)));
        let truth = Model::new(camera, assembled);
        let pins = pins();
        // Six captures of five pins each.
        let captures: Vec<Vec<&PinLandmark>> =
            (0..6).map(|capture| (0..5).map(|k| &pins[(capture + 6 * k) % 29]).collect()).collect();
        let mut bench = SyntheticSensor::new(truth.clone(), 3);
        let mut noise = SplitMix64::new(4);
        let values: Vec<f64> = camera.parameters().into_iter().map(|(_, value)| value).collect();

        let mut maps: [Vec<Vec<f64>>; 4] = Default::default();
        let mut labels: Vec<Vec<u16>> = Vec::new();
        let mut pose_covariance = [[0.0; 6]; 6];
        for _ in 0..TRIALS {
            let observations = bench.observe(&captures, SIGMA_PX).unwrap();
            let fit = refine(&truth, &FitParameter::POSE, &observations, Loss::Squares).unwrap();
            pose_covariance =
                std::array::from_fn(|r| std::array::from_fn(|c| fit.covariance[(r, c)]));
            let mut values = values.clone();
            for (value, sigma) in values.iter_mut().zip(CAMERA_SIGMAS).filter(|_| with_camera) {
                *value += sigma * noise.normal();
            }
            let camera = camera.with_parameters(&values).unwrap();
            let rays = PixelRays::new(&camera, &fit.model.camera_from_sensor.inverse());
            let surface = ReferenceSurface::cast(touch, &rays).unwrap();
            let map = surface.map_with_indenters(&[ball()]);
            labels.push(map.label().to_vec());
            for (all, now) in maps.iter_mut().zip(quantities(&map)) {
                all.push(now);
            }
        }

        let mut camera_covariance = DMatrix::zeros(values.len(), values.len());
        for (i, sigma) in CAMERA_SIGMAS.iter().enumerate() {
            camera_covariance[(i, i)] = sigma * sigma;
        }
        let estimate = CameraEstimate::new(camera, with_camera.then_some(camera_covariance));
        let joint = JointEstimate::independent(&estimate.unwrap(), Some(&pose_covariance));
        let uncertainty = Uncertainty { joint: Some(joint.unwrap()), shape_mm: 0.0 };
        let rays = PixelRays::new(&camera, &assembled.inverse());
        let surface = ReferenceSurface::cast(touch, &rays).unwrap();
        let map = surface.map_with_indenters(&[ball()]);
        labels.push(map.label().to_vec());
        let predicted = predicted(&map.compute_standard_deviations(&uncertainty));
        // First order ends at edges.
        let is_smooth = |pixel: usize| labels.iter().all(|all| all[pixel] == labels[0][pixel]);
        for (((name, axes), maps), mut predicted) in
            QUANTITIES.into_iter().zip(&maps).zip(predicted)
        {
            for (pixel, sigma) in predicted.iter_mut().enumerate() {
                if !is_smooth(pixel) {
                    *sigma = f64::NAN;
                }
            }
            let ratios = scatter_over_sigma(maps, axes, &predicted);
            let at = |share: f64| ratios[(share * (ratios.len() - 1) as f64) as usize];
            println!(
                "{} with camera: {with_camera}: scatter / sigma of {name} {:.3} at the median of {} pixels, \
                 {:.3} to {:.3} over 90 % of them",
                camera.interface().kind_name(),
                at(0.5),
                ratios.len(),
                at(0.05),
                at(0.95),
            );
            // Indentation is known where something presses.
            assert!(ratios.len() > if name == "indentation" { 40 } else { 1000 });
            // A standard deviation of 500 trials is known to 3.2 %; a few parameters move all pixels.
            assert!((at(0.5) - 1.0).abs() < 0.15, "{name}: {}", at(0.5));
            assert!(at(0.05) > 0.8 && at(0.95) < 1.2, "{name}: {} {}", at(0.05), at(0.95));
        }
    }
}

/// A ball of 12 mm that is pressed 2 mm deep into one side.
fn ball() -> PlacedIndenter {
    let outward = Vector3::new(0.5, 0.2, 0.8).normalize();
    let middle = Point3::new(0.0, 0.0, 6.0) + 25.0 * outward;
    PlacedIndenter::new("ball", &Solid::sphere(12.0), Pose::z_to(outward, middle)).unwrap()
}

/// Views of a board of 8 x 6 corners, seen from all sides, with normal noise.
fn views(camera: &Camera, noise: &mut SplitMix64) -> Vec<BoardView> {
    let tilts = [[35.0, 0.0], [-35.0, 10.0], [5.0, 40.0], [-10.0, -35.0], [25.0, 25.0], [0.0, 5.0]];
    let view = |[a, b]: [f64; 2]| {
        let turn = |deg: f64| Angle::from_deg(deg).unwrap();
        let pose = Pose::translation(-12.0, -8.0, 14.0)
            .then_in(Pose::rotation_x(turn(a)))
            .then_in(Pose::rotation_y(turn(b)));
        let corners = (0..48).map(|id| {
            let (x, y) = (f64::from(id % 8) * 3.5, f64::from(id / 8) * 3.5);
            let pixel = camera.project(&pose.point(Point3::new(x, y, 0.0))).unwrap();
            let noise_px = Vector2::new(noise.normal(), noise.normal()) * SIGMA_PX;
            intrinsics::CornerObservation {
                id,
                in_board_mm: Point2::new(x, y),
                pixel: pixel + noise_px,
                sigma_px: SIGMA_PX,
            }
        });
        BoardView { name: format!("tilted by {a} and {b}"), corners: corners.collect() }
    };
    tilts.into_iter().map(view).collect()
}

/// The whole way, 200 times: the lens from a board, the pose from pins with that lens, the truth
/// with both. Lens and pose err together, and the joint covariance knows it; the same two taken for
/// independent do not.
#[test]
fn sigma_is_the_scatter_of_lens_and_pose_calibrated_one_after_the_other() {
    const TRIALS: usize = 200;
    // Pins better than corners, so that the lens's part is not lost among theirs.
    const PIN_SIGMA_PX: f64 = 0.01;
    let designs = builtin_designs();
    let rtac0 = designs.iter().find(|design| design.sensor.name == "rtac0").unwrap();
    let touch = rtac0.sensor.touch.as_ref().unwrap();
    let in_air = camera(Interface::None);
    let mut noise = SplitMix64::new(5);
    let lenses: Vec<CameraEstimate> = (0..TRIALS)
        .map(|_| {
            let views = views(&in_air, &mut noise);
            let found = intrinsics::calibrate(&views, &in_air, &[LensModel::KannalaBrandt]);
            found.unwrap().estimate
        })
        .collect();
    let gel = Interface::Flat(FlatInterface::bare_in_air(2.0, 1.41));
    let refitted = [FitParameter::FocalScale, FitParameter::Camera("k1")];
    let cases = [
        ("lens held", Interface::None, &[][..]),
        ("lens fitted anew", Interface::None, &refitted[..]),
        ("gel fitted", gel, &[FitParameter::Camera("interface_distance_mm")][..]),
    ];
    let degrees = |deg| Angle::from_deg(deg).unwrap();
    let assembled = Pose::translation(0.4, -0.3, 7.6).then_in(Pose::rotation_x(degrees(1.2)));
    let pins = pins();
    let captures: Vec<Vec<&PinLandmark>> =
        (0..6).map(|capture| (0..5).map(|k| &pins[(capture + 6 * k) % 29]).collect()).collect();
    for (name, interface, more) in cases {
        let behind = |lens: &Camera| Camera::new(64, 48, *lens.lens(), interface).unwrap();
        let truth = Model::new(camera(interface), assembled);
        let parameters = [&FitParameter::POSE[..], more].concat();
        let mut bench = SyntheticSensor::new(truth.clone(), 6);
        let (mut maps, mut last) = (Vec::new(), None);
        for lens in &lenses {
            let observations = bench.observe(&captures, PIN_SIGMA_PX).unwrap();
            let start = Model::new(behind(lens.camera()), assembled);
            let fit: PoseSolution =
                refine(&start, &parameters, &observations, Loss::Squares).unwrap();
            let rays = PixelRays::new(&fit.model.camera, &fit.model.camera_from_sensor.inverse());
            maps.push(ReferenceSurface::cast(touch, &rays).unwrap().range_mm().to_vec());
            let joint =
                joint_estimate(lens, &fit, &observations, Loss::Squares, &fit.covariance).unwrap();
            last = Some((fit, joint));
        }
        let (fit, JointCovariance { estimate, .. }) = last.unwrap();
        let rays = PixelRays::new(&fit.model.camera, &fit.model.camera_from_sensor.inverse());
        let surface = ReferenceSurface::cast(touch, &rays).unwrap();
        let ratios = |joint: JointEstimate| {
            let uncertainty = Uncertainty { joint: Some(joint), shape_mm: 0.0 };
            let ratios = scatter_over_sigma(
                &maps,
                1,
                &surface
                    .map_without_contact()
                    .compute_standard_deviations(&uncertainty)
                    .range_mm()
                    .collect::<Vec<_>>(),
            );
            assert!(ratios.len() > 1000);
            let at = |share: f64| ratios[(share * (ratios.len() - 1) as f64) as usize];
            [at(0.05), at(0.5), at(0.95)]
        };
        let pose_alone: [[f64; 6]; 6] =
            std::array::from_fn(|r| std::array::from_fn(|c| fit.covariance[(r, c)]));
        let apart = JointEstimate::independent(&estimate.camera_estimate(), Some(&pose_alone));
        assert_eq!(estimate.coverage().interface, interface != Interface::None);
        let (together, apart) = (ratios(estimate), ratios(apart.unwrap()));
        println!("{name}: scatter / sigma {together:.3?}, as if independent {apart:.3?}");
        // A standard deviation of 200 trials is known to 5 %; a few parameters move all pixels.
        assert!((together[1] - 1.0).abs() < 0.15, "{name}: {together:?}");
        assert!(together[0] > 0.8 && together[2] < 1.2, "{name}: {together:?}");
        assert!(apart[0] < 0.7 || apart[2] > 1.3, "{name}: {apart:?}");
    }
}
