//! Captures that are drawn at random, and what becomes of the surface.

use fabkit_calibration::extrinsics::{CalibrationOptions, Drawing, calibrate};
use fabkit_calibration::model::{Contact, FitParameter, MarkOffsets, Model, Observation};
use fabkit_camera::{CameraEstimate, Point2, Vector2};
use fabkit_fixtures::{DrawnBodies, PoseForecast};
use fabkit_geometry::sequences::SplitMix64;
use fabkit_geometry::{Matrix3, Point3, Pose, TouchSurface, Vector3};
use nalgebra::Rotation3;

/// One calibration.
pub struct Trial {
    /// Error of the surface's points, mean of the squares, mm2.
    pub square_mm2: f64,
    pub scatter_px: Option<f64>,
    pub model: String,
    /// Whether it says that the unit is the drawn one.
    pub within_tolerances: bool,
}

/// What a unit is that nobody drew.
#[derive(Clone, Copy, Debug)]
pub enum Wrong {
    Nothing,
    /// Refractive index of what is behind the first face, more than drawn.
    Index(f64),
    /// The first face, farther from the lens than drawn, mm.
    Face(f64),
    /// Glue on a face, which bends rays like a lens: at most so many pixels, about a place of the image, so wide, px.
    Ridge {
        px: f64,
        at: [f64; 2],
        wide: f64,
    },
}

impl Wrong {
    /// Where a pixel is seen instead.
    fn moved(self, pixel: Point2<f64>) -> Point2<f64> {
        let Self::Ridge { px, at, wide } = self else { return pixel };
        let out = (pixel - Point2::from(at)) / wide;
        // Largest one width away.
        pixel + px * out * (0.5 * (1.0 - out.norm_squared())).exp()
    }
}

pub struct Bench<'a> {
    pub touch: &'a TouchSurface,
    pub forecast: &'a PoseForecast,
    pub bodies: DrawnBodies,
    /// By the solver; how each is off in truth is a draw.
    pub marks: MarkOffsets,
    pub wrong: Wrong,
}

fn contact(place: Point3<f64>, axis: Option<Vector3<f64>>, capture: usize, hole: u32) -> Contact {
    Contact { capture, hole, contact_in_sensor_mm: place, axis_in_sensor: axis }
}

impl Bench<'_> {
    /// With what the drawing leaves open as it may be.
    fn truth(&self, random: &mut SplitMix64) -> Model {
        let open: Vec<FitParameter> = self
            .forecast
            .parameters
            .iter()
            .copied()
            .filter(|p| FitParameter::DRAWN_INTERFACE.contains(p))
            .collect();
        let steps: Vec<f64> = open
            .iter()
            .map(|parameter| {
                let (sigma, wrong) = match (parameter, self.wrong) {
                    (FitParameter::InterfaceShift, Wrong::Face(mm)) => (0.3, mm),
                    (FitParameter::InterfaceShift, _) => (0.3, 0.0),
                    (_, Wrong::Index(more)) => (0.01, more),
                    _ => (0.01, 0.0),
                };
                let by = sigma * random.normal();
                // What is wrong is wrong by that much in all trials.
                if wrong == 0.0 { by } else { wrong }
            })
            .collect();
        self.forecast.model.stepped(&open, &steps).unwrap()
    }

    fn captured(
        &self,
        captures: &[Vec<usize>],
        random: &mut SplitMix64,
    ) -> (Model, Vec<Observation>) {
        let pins = &self.forecast.landmarks.pins;
        let loose = &self.forecast.looseness;
        let mut truth = self.truth(random);
        let places: Vec<_> = pins.iter().map(|pin| pin.contact_in_sensor_mm).collect();
        truth.displacements = self.bodies.displacements(&truth.camera_from_sensor, &places);
        let middle = places.iter().map(|p| p.coords).sum::<Vector3<f64>>() / places.len() as f64;
        let mut normal = |sigma: f64| sigma * random.normal();
        let seating_mm = normal(loose.seating_mm);
        let marks: Vec<Vector2<f64>> = places
            .iter()
            .map(|place| {
                self.marks.offset_at(place).map_or_else(Vector2::zeros, |mark| {
                    mark.offset_px + Vector2::new(normal(mark.sigma_px), normal(mark.sigma_px))
                })
            })
            .collect();
        let mut observations = Vec::new();
        for (number, capture) in captures.iter().enumerate() {
            let shift = Vector3::from_fn(|i, _| normal(loose.dome_mm[i]));
            let turn = Rotation3::new(Vector3::from_fn(|i, _| normal(loose.dome_rad[i])));
            for &index in capture {
                let pin = &pins[index];
                let axis = pin.axis_in_sensor.unwrap();
                let any = Vector3::from_fn(|_, _| normal(loose.across_mm));
                let across = any - axis * axis.dot(&any);
                let by = across + axis * (normal(loose.along_mm) + seating_mm);
                let nominal = contact(places[index], Some(axis), number, pin.hole);
                // As it is seen behind what bends light again.
                let seen = truth.displaced_contact(&nominal) + by;
                let seen = middle + turn * (seen.coords - middle) + shift;
                let pixel =
                    truth.camera.project(&truth.camera_from_sensor.point(seen.into())).unwrap();
                let noise = self.forecast.effort.sigma_px;
                let pixel = self.wrong.moved(pixel)
                    + marks[index]
                    + Vector2::new(normal(noise), normal(noise));
                observations.push(Observation { contact: nominal, pixel, sigma_px: noise });
            }
        }
        (truth, observations)
    }

    /// Where the surface is that a model sees at a pixel, from a place near it.
    fn seen_at(
        &self,
        model: &Model,
        pixel: &Point2<f64>,
        from: Point3<f64>,
    ) -> Option<Point3<f64>> {
        let mut place = from;
        let mut model = model.clone();
        for _ in 0..6 {
            let (depth_mm, normal) = self.touch.depth_mm(&place);
            place += depth_mm * normal;
            model.displacements = self.bodies.displacements(&model.camera_from_sensor, &[place]);
            let here = contact(place, None, usize::MAX, 0);
            let missed = pixel - model.project(&here).ok()?;
            let by = model.pixel_by_contact(&here).ok()?;
            let system =
                Matrix3::from_rows(&[by.row(0).into(), by.row(1).into(), normal.transpose()]);
            place += system.try_inverse()? * Vector3::new(missed.x, missed.y, 0.0);
        }
        Some(place)
    }

    pub fn trial(&self, captures: &[Vec<usize>], seed: u64) -> Option<Trial> {
        let mut random = SplitMix64::new(seed);
        let (truth, observations) = self.captured(captures, &mut random);
        let displacements =
            |pose: &Pose, contacts: &[Point3<f64>]| self.bodies.displacements(pose, contacts);
        let drawn = self.bodies.interface();
        let drawn = drawn.map(|interface| Drawing { interface, displacements: &displacements });
        let options = CalibrationOptions {
            drawing: drawn,
            mark_offsets: Some(&self.marks),
            ..CalibrationOptions::default()
        };
        let pose = self.forecast.model.camera_from_sensor;
        let lens = CameraEstimate::from(self.forecast.model.camera.without_interface());
        let found = calibrate(&lens, &observations, &pose, Some(&pose), &options).ok()?;
        let bare = |model: &Model| Model {
            seating_offset_mm: 0.0,
            lean_mm: 0.0,
            reseatings: Vec::new(),
            mark_offsets: MarkOffsets::default(),
            ..model.clone()
        };
        let (truth, solved) = (bare(&truth), bare(found.model()));
        let mut squares = Vec::new();
        for (place, _) in &self.forecast.places {
            let mut truth = truth.clone();
            truth.displacements = self.bodies.displacements(&truth.camera_from_sensor, &[*place]);
            let Ok(pixel) = truth.project(&contact(*place, None, usize::MAX, 0)) else { continue };
            if let Some(found) = self.seen_at(&solved, &self.wrong.moved(pixel), *place) {
                squares.push((found - place).norm_squared());
            }
        }
        Some(Trial {
            square_mm2: squares.iter().sum::<f64>() / squares.len() as f64,
            scatter_px: found.scatter.map(|scatter| scatter.rms_px),
            model: found.chosen_trial().candidate.to_string(),
            within_tolerances: found.chosen_trial().within_tolerances(),
        })
    }
}
