//! The sigma of ground truth against the scatter of simulated recalibrations.

use fabkit::depth::truth::{PixelRays, Surface, Uncertainty};
use fabkit_calibration::extrinsics::{Loss, refine};
use fabkit_calibration::landmarks::PinLandmark;
use fabkit_calibration::model::{Model, Parameter};
use fabkit_calibration::synthetic::{Bench, Noise};
use fabkit_camera::{Camera, DMatrix, Flat, Interface, Intrinsics, KannalaBrandt, Lens};
use fabkit_geometry::{Angle, Point3, Pose, Vector3};
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

#[test]
fn sigma_is_the_scatter_of_500_recalibrations() {
    let designs = builtin_designs();
    let rtac0 = designs.iter().find(|design| design.sensor.name == "rtac0").unwrap();
    let touch = rtac0.sensor.touch.as_ref().unwrap();
    let behind_glass = Interface::Flat(Flat::in_air(2.0, 1.41));
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
        let mut bench = Bench::new(truth.clone(), 3);
        let mut noise = Noise::new(4);
        let values: Vec<f64> = camera.parameters().into_iter().map(|(_, value)| value).collect();

        let mut maps = Vec::new();
        let mut pose_covariance = [[0.0; 6]; 6];
        for _ in 0..TRIALS {
            let observations = bench.observe(&captures, SIGMA_PX).unwrap();
            let fit = refine(&truth, &Parameter::POSE, &observations, Loss::Squares).unwrap();
            pose_covariance =
                std::array::from_fn(|r| std::array::from_fn(|c| fit.covariance[(r, c)]));
            let mut values = values.clone();
            for (value, sigma) in values.iter_mut().zip(CAMERA_SIGMAS).filter(|_| with_camera) {
                *value += sigma * noise.normal();
            }
            let camera = camera.with_parameters(&values).unwrap();
            let rays = PixelRays::new(&camera, &fit.model.camera_from_sensor.inverse());
            maps.push(Surface::cast(touch, &rays).unwrap().range_mm().to_vec());
        }

        let mut camera_covariance = DMatrix::zeros(values.len(), values.len());
        for (i, sigma) in CAMERA_SIGMAS.iter().enumerate() {
            camera_covariance[(i, i)] = sigma * sigma;
        }
        let uncertainty = Uncertainty {
            camera: with_camera.then_some(camera_covariance),
            pose: Some(pose_covariance),
            shape_mm: 0.0,
        };
        let rays = PixelRays::new(&camera, &assembled.inverse());
        let surface = Surface::cast(touch, &rays).unwrap();
        let predicted = surface.untouched().sigma_mm(&uncertainty);
        let mut ratios: Vec<f64> = (0..predicted.len())
            .filter(|&pixel| maps.iter().all(|map| map[pixel].is_finite()))
            .filter(|&pixel| predicted[pixel].is_finite())
            .map(|pixel| {
                let mean = maps.iter().map(|map| map[pixel]).sum::<f64>() / TRIALS as f64;
                let square = |map: &Vec<f64>| (map[pixel] - mean).powi(2);
                let variance = maps.iter().map(square).sum::<f64>() / (TRIALS - 1) as f64;
                variance.sqrt() / predicted[pixel]
            })
            .collect();
        ratios.sort_by(f64::total_cmp);
        let at = |share: f64| ratios[(share * (ratios.len() - 1) as f64) as usize];
        println!(
            "{} with camera: {with_camera}: scatter / sigma {:.3} at the median of {} pixels, \
             {:.3} to {:.3} over 90 % of them",
            camera.interface().kind_name(),
            at(0.5),
            ratios.len(),
            at(0.05),
            at(0.95),
        );
        assert!(ratios.len() > 1000);
        // A standard deviation of 500 trials is known to 3.2 %; a few parameters move all pixels.
        assert!((at(0.5) - 1.0).abs() < 0.15, "{}", at(0.5));
        assert!(at(0.05) > 0.8 && at(0.95) < 1.2, "{} {}", at(0.05), at(0.95));
    }
}
