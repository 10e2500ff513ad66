//! Differences of a unit from its drawing that an explanation implies, relative to manufacturing tolerances.

use fabkit_camera::{CameraEstimate, Interface};
use fabkit_geometry::{Pose, Vector3};

use super::candidates::{Drawing, Medium, ParameterSet};
use super::refine::PoseSolution;
use crate::drawn_interface::{INDEX_SIGMA, PLACE_SIGMA_MM};
use crate::model::{Axis, FitParameter};

/// Standard deviation of a camera's position along each axis, mm: a board in its seat, and a lens that is screwed until
/// it is focused. Chosen, not measured.
const CAMERA_MM: f64 = 1.0;
/// Standard deviation of a camera's tilt, rad. Chosen, not measured.
const TILT_RAD: f64 = 0.035;
/// Standard deviation of the depth that all pins go in beyond the drawing, mm: printed seats and pins. Chosen.
const SEATING_MM: f64 = 0.15;
/// Standard deviation of the tips' lean, mm: as on the one published unit.
const LEAN_MM: f64 = 0.5;
/// Relative standard deviation of the focal lengths of a lens whose file has no covariance. Chosen: boards in a few
/// dozen images achieve this.
const FOCAL_SHARE: f64 = 0.01;
/// Standard deviation of a coefficient of a lens whose file has no covariance. Chosen likewise.
const COEFFICIENT: f64 = 0.02;
/// Number of standard deviations beyond which the unit differs from the drawing.
pub const TOLERANCE_SIGMAS: f64 = 3.0;
/// Standard deviation for an interface of another kind than the drawn one, which counts as a difference of 1.
const OTHER_KIND_SIGMA: f64 = 0.1;

/// Difference between a value that an explanation implies and that of the drawing or of the lens's own calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct UnitDifference {
    /// Name of the quantity, with its unit.
    pub name: String,
    /// Implied value minus expected value.
    pub deviation: f64,
    /// Standard deviation of the difference, from manufacturing and from the pixels together.
    pub sigma: f64,
    /// True if the fit has a prior for the quantity already.
    has_prior: bool,
}

impl UnitDifference {
    /// Returns the size of the difference in standard deviations.
    pub fn sigmas(&self) -> f64 {
        self.deviation.abs() / self.sigma
    }

    fn new(name: impl ToString, deviation: f64, made: f64, fitted: f64) -> Self {
        Self { name: name.to_string(), deviation, sigma: made.hypot(fitted), has_prior: false }
    }
}

/// Expected values, known before any image.
#[derive(Clone, Copy, Debug)]
pub(super) struct ExpectedValues<'a> {
    /// Lens with its own calibration.
    pub given: &'a CameraEstimate,
    /// Designed pose of the camera.
    pub nominal: Option<&'a Pose>,
    /// Bodies that the design draws in front of the lens.
    pub drawn: Option<Drawing<'a>>,
}

impl ExpectedValues<'_> {
    /// Lists all differences that a fit implies.
    pub fn differences(&self, of: &ParameterSet, fit: &PoseSolution) -> Vec<UnitDifference> {
        let mut all = self.pose_differences(fit);
        let fitted = |parameter: FitParameter| {
            let at = fit.parameters.iter().position(|found| *found == parameter);
            at.map_or(0.0, |at| fit.covariance[(at, at)].max(0.0).sqrt())
        };
        for parameter in &fit.parameters {
            let value = fit.model.value(*parameter).unwrap_or(0.0);
            let (by, made) = match parameter {
                FitParameter::SeatingOffset => (value, SEATING_MM),
                FitParameter::Lean => (value, LEAN_MM),
                FitParameter::FocalScale => self.focal_scale(fit),
                FitParameter::Camera(name) if !name.starts_with("interface_") => {
                    self.coefficient(name, value)
                }
                _ => continue,
            };
            all.push(UnitDifference::new(parameter, by, made, fitted(*parameter)));
        }
        let Some(drawn) = &self.drawn else { return all };
        let as_drawn = drawn.interface.designed_interface();
        let index = drawn.interface.index_outside();
        match (of.optics.medium, as_drawn) {
            (Medium::Drawn, _) => {
                for (parameter, sigma) in
                    FitParameter::DRAWN_INTERFACE.into_iter().zip([PLACE_SIGMA_MM, INDEX_SIGMA])
                {
                    let by = fit.model.prior(parameter).map_or(0.0, |(away, _)| away);
                    let name = parameter.to_string();
                    all.push(UnitDifference { name, deviation: by, sigma, has_prior: true });
                }
            }
            // Without an interface the lens is in air: as if the index outside were 1.
            (Medium::Given, _) if *fit.model.camera.interface() == Interface::None => {
                all.push(UnitDifference::new(
                    "interface_index_outside",
                    1.0 - index,
                    INDEX_SIGMA,
                    0.0,
                ));
            }
            (Medium::Given, _) => {}
            (Medium::Gel(_), Interface::Flat(flat)) => {
                let parameter = FitParameter::Camera("interface_distance_mm");
                let by = fit.model.value(parameter).unwrap_or(0.0) - flat.distance_mm;
                all.push(UnitDifference::new(parameter, by, PLACE_SIGMA_MM, fitted(parameter)));
            }
            (Medium::Gel(_), _) => {
                all.push(UnitDifference::new("interface_is_flat", 1.0, OTHER_KIND_SIGMA, 0.0));
            }
        }
        all
    }

    /// Lists the differences of the pose from the designed one; empty without a design.
    fn pose_differences(&self, fit: &PoseSolution) -> Vec<UnitDifference> {
        let Some(nominal) = self.nominal else { return Vec::new() };
        let sigma = |at: usize| fit.covariance[(at, at)].max(0.0).sqrt();
        let pose = &fit.model.camera_from_sensor;
        let off = pose.translation_mm() - nominal.translation_mm();
        let mut all: Vec<UnitDifference> = Axis::ALL
            .into_iter()
            .enumerate()
            .map(|(i, axis)| {
                let name = FitParameter::Translation(axis);
                UnitDifference::new(name, off[i], CAMERA_MM, sigma(3 + i))
            })
            .collect();
        // The turn of a camera about its own axis is not specified to the degree.
        let [now, drawn] = [pose, nominal].map(|pose| pose.vector(Vector3::z()));
        let tilt_rad = now.cross(&drawn).norm().atan2(now.dot(&drawn));
        all.push(UnitDifference::new("tilt_rad", tilt_rad, TILT_RAD, sigma(0).hypot(sigma(1))));
        all
    }

    fn given_sigma(&self, name: &str) -> Option<f64> {
        let at = self.given.names().iter().position(|found| *found == name)?;
        Some(self.given.covariance()?[(at, at)].max(0.0).sqrt())
    }

    fn focal_scale(&self, fit: &PoseSolution) -> (f64, f64) {
        let [now, before] =
            [&fit.model.camera, self.given.camera()].map(|camera| camera.lens().intrinsics().fx_px);
        (now / before - 1.0, self.given_sigma("fx_px").map_or(FOCAL_SHARE, |sigma| sigma / before))
    }

    fn coefficient(&self, name: &str, value: f64) -> (f64, f64) {
        let given = self.given.camera().parameters();
        let before = given.iter().find(|(found, _)| *found == name).map_or(0.0, |(_, v)| *v);
        (value - before, self.given_sigma(name).unwrap_or(COEFFICIENT))
    }
}

/// Computes the logarithm of the likelihood of differences, relative to its maximum, by Student's t distribution with
/// four degrees of freedom. Drawings are wrong more often than a normal distribution allows, and then by any amount.
pub(super) fn log_likelihood(differences: &[UnitDifference]) -> f64 {
    let fresh = differences.iter().filter(|difference| !difference.has_prior);
    -fresh.map(|difference| 2.5 * (difference.sigmas().powi(2) / 4.0).ln_1p()).sum::<f64>()
}
