//! Poses from simulated captures that were taken through the drawn bodies.
//!
//! Each trial is another unit of the same design: its camera stands askew, its first face lies where molds
//! leave it, its gel has the index of its batch. Pixels come from the exact paths through that unit's bodies;
//! the solver knows the design alone.
//!
//! `FABKIT_TRIALS=2000 cargo test --release -p fabkit-tests --test calibration drawn:: -- --nocapture` does more of them, and
//! the derived limits are as much narrower.

use std::f64::consts::SQRT_2;
use std::sync::Arc;

use fabkit_application::calibration_runs::extrinsics::fixture_landmarks;
use fabkit_application::fixtures;
use fabkit_application::ground_truth::Viewpoint;
use fabkit_calibration::drawn_interface::{INDEX_SIGMA, PLACE_SIGMA_MM};
use fabkit_calibration::extrinsics::{Drawing, Loss, PoseSolution, solve_drawn, solve_pose};
use fabkit_calibration::landmarks::PinLandmark;
use fabkit_calibration::model::{Contact, Model, Observation};
use fabkit_camera::files::{self, CameraFormat};
use fabkit_camera::{Camera, Interface};

use fabkit_application::depth::ground_truth::ReferenceSurface;
use fabkit_designs::builtin_yaml;
use fabkit_fixtures::DrawnBodies;
use fabkit_geometry::sequences::SplitMix64;
use fabkit_geometry::{Point3, Pose, Sensor, Solid, Vector3};
use fabkit_optics::{CameraView, OpticalStack, ViewStacks};
use fabkit_tests::build_design;
use nalgebra::{Rotation3, Vector2, Vector6};
use rayon::prelude::*;

const SIGMA_PX: f64 = 0.3;
const CAPTURES: usize = 10;
const PINS: usize = 5;
/// How a camera is mounted, one standard deviation.
const TURN_RAD: f64 = 0.02;
const SHIFT_MM: f64 = 0.3;
/// Rays pass the first face within this distance of the axis, mm.
const FACE_RADIUS_MM: f64 = 5.0;

struct Bench {
    sensor: Sensor,
    camera: Camera,
    pins: Vec<PinLandmark>,
    bodies: DrawnBodies,
}

impl Bench {
    fn new(name: &str) -> Self {
        let sensor = build_design(name, &[]).sensor;
        let project = fixtures::load(name, builtin_yaml(name).unwrap(), &[]).unwrap();
        let dome = project.fixture("pin-dome").unwrap();
        let nominal = &sensor.camera;
        let lens = (nominal.width_px, nominal.height_px, nominal.field_of_view.rad());
        let camera = Camera::equidistant(lens.0, lens.1, lens.2).unwrap();
        let bodies = DrawnBodies::new(&sensor, &camera).unwrap();
        Self { pins: fixture_landmarks(&dome).unwrap().pins.clone(), sensor, camera, bodies }
    }

    /// Another unit: its sensor, and its camera's pose.
    fn unit(&self, random: &mut SplitMix64) -> (Sensor, Pose) {
        let drawn = self.bodies.interface().unwrap();
        let Interface::Flat(flat) = drawn.designed_interface() else { panic!("a face") };
        let nominal = &self.sensor.camera.sensor_from_camera;
        let shift_mm = PLACE_SIGMA_MM * random.normal();
        let face = nominal.point(Point3::new(0.0, 0.0, flat.distance_mm));
        let index = flat.index_outside + INDEX_SIGMA * random.normal();
        let mut sensor = self.sensor.clone();
        for body in &mut sensor.bodies {
            if body.substance.refractive_index != Some(flat.index_outside) {
                continue;
            }
            body.substance.refractive_index = Some(index);
            let probe = face + Vector3::new(0.01, 0.02, 0.05);
            if !fabkit_geometry::CompiledSolid::new(&body.solid).unwrap().contains(&probe) {
                continue;
            }
            // The gel behind the first face: less of it, or more.
            let plug = |from_mm: f64, to_mm: f64| {
                let plug = Solid::cylinder(FACE_RADIUS_MM, to_mm - from_mm);
                plug.at(face.x, face.y, face.z + from_mm)
            };
            let solid = body.solid.clone();
            body.solid = if shift_mm > 0.0 {
                solid.minus(plug(-0.5, shift_mm))
            } else {
                solid.plus(plug(shift_mm, 0.5))
            };
        }
        let [turn, shift] =
            [TURN_RAD, SHIFT_MM].map(|sigma| sigma * Vector3::from_fn(|_, _| random.normal()));
        let designed = nominal.inverse();
        let rotation = Rotation3::new(turn).matrix() * designed.rotation();
        (sensor, Pose::new(rotation, designed.translation_mm() + shift).unwrap())
    }

    /// What a unit's camera sees of pins that all sit where they should.
    fn capture(
        &self,
        sensor: &Sensor,
        pose: &Pose,
        noise_px: f64,
        random: &mut SplitMix64,
    ) -> Vec<Observation> {
        let sights = ViewStacks::new(OpticalStack::from_sensor(sensor).unwrap());
        let mut viewer = CameraView::new(&self.camera, &pose.inverse(), &sights);
        let seen = self.pins.iter().filter_map(|pin| {
            let look = viewer.project(&pin.contact_in_sensor_mm).ok()?;
            let is_seen =
                self.camera.is_in_image(&look.pixel) && look.sight.hidden_by(0.5).is_none();
            is_seen.then_some((pin, look.pixel))
        });
        let seen: Vec<_> = seen.collect();
        assert!(seen.len() > 12, "{} pins are seen", seen.len());
        let mut observations = Vec::new();
        for capture in 0..CAPTURES {
            for place in 0..PINS {
                let (pin, pixel) = seen[(capture * 7 + place * seen.len() / PINS) % seen.len()];
                let noise = noise_px * Vector2::from_fn(|_, _| random.normal());
                let contact = Contact {
                    capture,
                    hole: pin.hole,
                    contact_in_sensor_mm: pin.contact_in_sensor_mm,
                    axis_in_sensor: pin.axis_in_sensor,
                };
                observations.push(Observation {
                    contact,
                    pixel: pixel + noise,
                    sigma_px: SIGMA_PX,
                });
            }
        }
        observations
    }

    /// Through the drawn bodies.
    fn solved(&self, observations: &[Observation]) -> PoseSolution {
        let displacements =
            |pose: &Pose, contacts: &[Point3<f64>]| self.bodies.displacements(pose, contacts);
        let drawing =
            Drawing { interface: self.bodies.interface().unwrap(), displacements: &displacements };
        let start = Model::new(self.camera, self.sensor.camera.sensor_from_camera.inverse());
        solve_drawn(observations, &start, &drawing, Loss::Squares).unwrap()
    }

    /// Where the surface is that each pixel of a small image shows.
    fn shown(&self, viewpoint: &Viewpoint, stack: OpticalStack) -> Vec<Option<Point3<f64>>> {
        let small = viewpoint.resized([80, 60]).unwrap();
        let rays = small.rays(1).traced_through(&Arc::new(ViewStacks::new(stack)));
        let surface = ReferenceSurface::cast(self.sensor.touch.as_ref().unwrap(), &rays).unwrap();
        let points = surface.map_without_contact().point_in_sensor().collect::<Vec<_>>();
        points.into_iter().map(|point| Some(point).filter(|point| point.x.is_finite())).collect()
    }

    /// By how much the solved camera shows another place of the surface than the unit's own does, mm rms, of marks without
    /// noise: as the calibration files have it.
    fn surface_off_mm(&self, seed: u64) -> f64 {
        let mut random = SplitMix64::new(seed);
        let (sensor, truth) = self.unit(&mut random);
        let observations = self.capture(&sensor, &truth, 0.0, &mut random);
        let fit = self.solved(&observations);
        let viewpoint = |camera: Camera, camera_from_sensor: &Pose| {
            let text = files::write(&camera.into(), CameraFormat::Fabkit).unwrap();
            let pose = files::PoseFile {
                camera_from_sensor: rows_of(camera_from_sensor),
                covariance: None,
                joint: None,
                camera: None,
            };
            Viewpoint::new(&sensor.camera, Some(&text), Some(&pose)).unwrap()
        };
        let own = viewpoint(self.camera.with_drawn_interface(), &truth);
        let own = self.shown(&own, own.stack(&sensor).unwrap());
        let solved = viewpoint(fit.model.camera, &fit.model.camera_from_sensor);
        let solved = self.shown(&solved, solved.stack(&self.sensor).unwrap());
        let squares = own
            .iter()
            .zip(&solved)
            .filter_map(|(own, solved)| Some((own.as_ref()? - solved.as_ref()?).norm_squared()));
        let squares: Vec<f64> = squares.collect();
        assert!(squares.len() > 1_000, "{}", squares.len());
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    }

    /// Errors of the pose, in standard deviations, and their sum of squares by the covariance (NEES).
    fn trial(&self, seed: u64) -> ([Trial; 2], f64) {
        let mut random = SplitMix64::new(seed);
        let (sensor, truth) = self.unit(&mut random);
        let observations = self.capture(&sensor, &truth, SIGMA_PX, &mut random);
        let start = self.sensor.camera.sensor_from_camera.inverse();
        let drawn = self.solved(&observations);
        let ignored = solve_pose(&self.camera, &observations, Some(&start), Loss::Squares).unwrap();
        let off_mm =
            (ignored.model.camera_from_sensor.translation_mm() - truth.translation_mm()).norm();
        ([&drawn, &ignored].map(|fit| Trial::of(fit, &truth)), off_mm)
    }
}

struct Trial {
    in_sigmas: Vector6<f64>,
    nees: f64,
}

impl Trial {
    fn of(fit: &PoseSolution, truth: &Pose) -> Self {
        let found = &fit.model.camera_from_sensor;
        let turned =
            Rotation3::from_matrix_unchecked(found.rotation() * truth.rotation().transpose());
        let shifted = found.translation_mm() - truth.translation_mm();
        let turn = turned.scaled_axis();
        let error = Vector6::new(turn.x, turn.y, turn.z, shifted.x, shifted.y, shifted.z);
        let covariance = fit.covariance.fixed_view::<6, 6>(0, 0).into_owned();
        let in_sigmas = error.component_div(&covariance.diagonal().map(f64::sqrt));
        let inverse = covariance.try_inverse().unwrap();
        Self { in_sigmas, nees: error.dot(&(inverse * error)) }
    }
}

/// Means over trials: largest bias of the six in their standard deviations, and NEES; with the drawn bodies
/// and without; and how far off the camera is without.
fn means(trials: usize) -> ([(f64, f64); 2], f64) {
    let bench = Bench::new("rtac0");
    let all: Vec<_> = (0..trials as u64).into_par_iter().map(|seed| bench.trial(seed)).collect();
    let mean = |of: usize| {
        let bias = all.iter().map(|(t, _)| t[of].in_sigmas).sum::<Vector6<f64>>() / trials as f64;
        (bias.amax(), all.iter().map(|(t, _)| t[of].nees).sum::<f64>() / trials as f64)
    };
    let off_mm = all.iter().map(|(_, off_mm)| off_mm).sum::<f64>() / trials as f64;
    let figures = [mean(0), mean(1)];
    let [(bias, nees), (bias_ignored, nees_ignored)] = figures;
    println!("{trials} trials of rtac0, simulated through its drawn bodies");
    println!("drawn bodies: largest bias {bias:.3} sigma, NEES {nees:.2} of 6");
    println!(
        "ignored: largest bias {bias_ignored:.1} sigma, NEES {nees_ignored:.0}, camera off by {off_mm:.2} mm"
    );
    (figures, off_mm)
}

#[test]
fn poses_through_the_drawn_bodies_are_as_sure_as_they_say() {
    let asked = std::env::var("FABKIT_TRIALS").ok();
    let trials = asked.map_or(60, |count| count.parse().expect("a number of trials"));
    let ([(bias, nees), (_, ignored)], off_mm) = means(trials);
    // Means of n trials scatter by 1 / sqrt n in sigmas; of six of them one is beyond 3.5 of that once in 400.
    let scatter = 1.0 / (trials as f64).sqrt();
    assert!(bias < 3.5 * scatter, "{bias}");
    // The sum of 6 squares has the variance 12.
    assert!((nees - 6.0).abs() < 3.5 * 12.0_f64.sqrt() * scatter, "{nees}");
    assert!(ignored > 100.0 && off_mm > SQRT_2, "{ignored} {off_mm}");
}

/// A pose goes with what bends light behind the interface that the solver knows. Without R-Tac0's tube it showed the surface
/// 0.07 mm beside where it is.
#[test]
fn solved_cameras_show_the_surface_where_it_is() {
    let bench = Bench::new("rtac0");
    for seed in 0..4 {
        let off_mm = bench.surface_off_mm(seed);
        println!("seed {seed}: {off_mm:.4} mm");
        // What the tube displaces is that of the design, and not of the unit's own index, which differs by some hundredths.
        assert!(off_mm < 0.02, "{seed}: {off_mm}");
    }
}

/// As pose files have them.
fn rows_of(pose: &Pose) -> [[f64; 4]; 4] {
    let (rotation, translation) = (pose.rotation(), pose.translation_mm());
    let entry = |row: usize, column: usize| match (row, column) {
        (3, _) => f64::from(u8::from(column == 3)),
        (_, 3) => translation[row],
        _ => rotation[(row, column)],
    };
    std::array::from_fn(|row| std::array::from_fn(|column| entry(row, column)))
}
