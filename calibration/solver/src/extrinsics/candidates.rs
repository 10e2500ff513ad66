//! Candidate explanations: sets of parameters between pins and pixels.

use std::fmt;

use fabkit_camera::{Camera, FlatInterface, Interface};
use fabkit_geometry::{Point3, Pose};

use super::CalibrationOptions;
use super::refine::{Loss, PoseSolution, SolveError, refine};
use crate::drawn_interface::DrawnInterface;
use crate::model::{ApparentDisplacements, FitParameter, Model, MountingError, Observation};

/// Distances of the interface from the lens at which a fit starts, or is fixed, mm.
const INTERFACE_STARTS_MM: [f64; 14] =
    [0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0, 12.0, 14.0, 15.0, 16.0, 17.0, 20.0];
/// Smallest thickness of gel between the interface and the nearest pin, mm, because pins press on gel.
const MIN_GEL_MM: f64 = 1.0;
/// Number of fits through the drawn bodies. Bodies behind the first interface move pixels by half a pixel at most, and
/// that changes by a hundredth with the pose.
const DRAWN_ROUNDS: usize = 3;
/// Parameter of the distance between the lens and a flat surface of gel.
const INTERFACE_DISTANCE: FitParameter = FitParameter::Camera("interface_distance_mm");

/// Media between lens and pins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Medium {
    /// Media as in the camera file.
    Given,
    /// Bodies that the design draws, within the tolerances of molds, prints and data sheets.
    Drawn,
    /// Air in front of the lens, then a flat surface of gel of this refractive index at a distance that is solved for.
    Gel(f64),
}

/// Bodies that a design draws between lens and pins, for [`Medium::Drawn`].
#[derive(Clone, Copy)]
pub struct Drawing<'a> {
    /// First interface on the path of light from the lens.
    pub interface: DrawnInterface,
    /// Function for the bodies behind it: apparent displacements from a pose (sensor frame to camera frame), for
    /// contacts in the sensor frame, mm.
    pub displacements: &'a dyn Fn(&Pose, &[Point3<f64>]) -> ApparentDisplacements,
}

impl fmt::Debug for Drawing<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Drawing").field("interface", &self.interface).finish_non_exhaustive()
    }
}

/// Optics beyond the camera file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Optics {
    /// Media between lens and pins.
    pub medium: Medium,
    /// Number of the lens's radial terms that are solved for anew. The first scales both focal lengths, the others are
    /// its leading distortion coefficients. They represent everything that refracts light and is not known in detail.
    pub radial_terms: usize,
}

impl Optics {
    /// Optics as in the camera file.
    pub const GIVEN: Self = Self { medium: Medium::Given, radial_terms: 0 };
}

/// Explanation of the pixels: a set of parameters to solve for.
///
/// ```
/// use fabkit_calibration::extrinsics::{Medium, Optics, ParameterSet};
/// use fabkit_camera::Camera;
/// let camera = Camera::equidistant(640, 480, 2.8)?;
/// let optics = Optics { medium: Medium::Gel(1.41), radial_terms: 2 };
/// let set = ParameterSet { optics, lean: true, ..ParameterSet::PLAIN };
/// assert_eq!(set.to_string(), "gel+radial-2+lean");
/// // Beyond the six of the pose:
/// let names = set.parameters(&camera, 10).into_iter().skip(6).map(|p| p.to_string());
/// let expected = ["interface_distance_mm", "focal_scale", "k1", "lean_mm"];
/// assert_eq!(names.collect::<Vec<_>>(), expected);
/// # Ok::<(), fabkit_camera::InvalidCamera>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterSet {
    /// Optics.
    pub optics: Optics,
    /// True if all pins may lean in the same sense; see [`FitParameter::Lean`].
    pub lean: bool,
    /// True if all pins may sit deeper or less deep; see [`FitParameter::SeatingOffset`].
    pub seating: bool,
    /// True if the dome may sit differently in every capture.
    pub reseating: bool,
}

impl ParameterSet {
    /// Explanation by the pose alone.
    pub const PLAIN: Self =
        Self { optics: Optics::GIVEN, lean: false, seating: false, reseating: false };

    /// Lists the parameters of the explanation, pose first.
    pub fn parameters(&self, camera: &Camera, captures: usize) -> Vec<FitParameter> {
        let mut parameters = FitParameter::POSE.to_vec();
        match self.optics.medium {
            Medium::Given => {}
            Medium::Drawn => parameters.extend(FitParameter::DRAWN_INTERFACE),
            Medium::Gel(_) => parameters.push(INTERFACE_DISTANCE),
        }
        if self.optics.radial_terms > 0 {
            parameters.push(FitParameter::FocalScale);
            // OpenCV's tangential terms p1 and p2 are not radial.
            let names = camera.lens().coefficient_names().iter();
            let radial = names.filter(|name| !name.starts_with('p'));
            let further = radial.take(self.optics.radial_terms - 1);
            parameters.extend(further.map(|name| FitParameter::Camera(name)));
        }
        parameters.extend(self.lean.then_some(FitParameter::Lean));
        parameters.extend(self.seating.then_some(FitParameter::SeatingOffset));
        if self.reseating {
            for capture in 0..captures {
                let seats = [MountingError::ShiftX, MountingError::ShiftY, MountingError::Turn];
                parameters.extend(seats.map(|seat| FitParameter::Reseating(capture, seat)));
            }
        }
        parameters
    }

    /// Fits the explanation, starting from the pose of a plainer one.
    ///
    /// If the best gel surface would reach the nearest pins, the distance is fixed at the best one tried before that.
    pub(super) fn fit(
        &self,
        start: &Model,
        observations: &[Observation],
        captures: usize,
        options: &CalibrationOptions<'_>,
    ) -> Result<PoseSolution, SolveError> {
        let loss = options.loss;
        let mut parameters = self.parameters(&start.camera, captures);
        if !start.mark_offsets.is_empty() {
            parameters.extend(FitParameter::LIGHT);
        }
        let index = match (self.optics.medium, &options.drawing) {
            (Medium::Gel(index), _) => index,
            (Medium::Drawn, Some(drawing)) => {
                return fit_drawn(drawing, start, &parameters, observations, loss);
            }
            (Medium::Given | Medium::Drawn, _) => {
                return refine(start, &parameters, observations, loss);
            }
        };
        let held: Vec<FitParameter> =
            parameters.iter().copied().filter(|p| *p != INTERFACE_DISTANCE).collect();
        let mut best: Option<PoseSolution> = None;
        let mut first_error = None;
        for distance_mm in INTERFACE_STARTS_MM {
            let Some(model) = with_gel_surface(start, distance_mm, index) else { continue };
            // First with the distance fixed: from a rough start, distance and pose would diverge together.
            let fixed = match refine(&model, &held, observations, loss) {
                Ok(fixed) => fixed,
                Err(error) => {
                    first_error.get_or_insert(error);
                    continue;
                }
            };
            let free = refine(&fixed.model, &parameters, observations, loss);
            for fit in [Ok(fixed), free].into_iter().flatten() {
                // The fixed fit competes too, because the free one may put the gel's surface behind pins.
                let better = best.as_ref().is_none_or(|best| fit.cost < best.cost);
                if better && min_gel_thickness_mm(&fit.model, observations) > MIN_GEL_MM {
                    best = Some(fit);
                }
            }
        }
        best.ok_or(first_error.unwrap_or(SolveError::PinsThroughGel))
    }
}

/// Fits through the drawn bodies. The displacements by the bodies behind the first interface are computed for a pose,
/// and again for the pose that the fit finds.
pub(super) fn fit_drawn(
    drawing: &Drawing<'_>,
    start: &Model,
    parameters: &[FitParameter],
    observations: &[Observation],
    loss: Loss,
) -> Result<PoseSolution, SolveError> {
    let contacts: Vec<_> = observations.iter().map(|o| o.contact.contact_in_sensor_mm).collect();
    let mut model = at_designed_position(start)
        .and_then(|model| model.with_drawn_interface(&drawing.interface))
        .ok_or(SolveError::NoDrawnInterface)?;
    for round in 1.. {
        model.displacements = (drawing.displacements)(&model.camera_from_sensor, &contacts);
        let fit = refine(&model, parameters, observations, loss)?;
        // Without bodies behind the first interface one round is exact.
        if round == DRAWN_ROUNDS || model.displacements == ApparentDisplacements::default() {
            return Ok(fit);
        }
        model = fit.model;
    }
    unreachable!("the last round returns")
}

/// Returns the model with the camera at its designed position and its present orientation.
fn at_designed_position(start: &Model) -> Option<Model> {
    let mut model = start.clone();
    if let Some(expected) = start.expected_translation_mm {
        model.camera_from_sensor = Pose::new(*start.camera_from_sensor.rotation(), expected)?;
    }
    Some(model)
}

/// Returns the model with the lens in air in front of a flat surface of gel. The camera is at its designed position,
/// where refraction and distance have not yet compensated each other.
fn with_gel_surface(start: &Model, distance_mm: f64, index: f64) -> Option<Model> {
    let mut model = at_designed_position(start)?;
    let interface = Interface::Flat(FlatInterface::bare_in_air(distance_mm, index));
    let (width_px, height_px) = (start.camera.width_px(), start.camera.height_px());
    model.camera = Camera::new(width_px, height_px, *start.camera.lens(), interface).ok()?;
    Some(model)
}

/// Computes the thickness of gel between the flat surface and the nearest pin, mm.
fn min_gel_thickness_mm(model: &Model, observations: &[Observation]) -> f64 {
    let Interface::Flat(flat) = model.camera.interface() else { return f64::INFINITY };
    let depth = |o: &Observation| {
        model.camera_from_sensor.point(model.displaced_contact(&o.contact)).z - flat.distance_mm
    };
    observations.iter().map(depth).fold(f64::INFINITY, f64::min)
}

impl fmt::Display for ParameterSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.optics.medium, self.optics.radial_terms) {
            (Medium::Given, 0) => f.write_str("plain")?,
            (Medium::Given, terms) => write!(f, "radial-{terms}")?,
            (Medium::Drawn, 0) => f.write_str("drawn")?,
            (Medium::Drawn, terms) => write!(f, "drawn+radial-{terms}")?,
            (Medium::Gel(_), 0) => f.write_str("gel")?,
            (Medium::Gel(_), terms) => write!(f, "gel+radial-{terms}")?,
        }
        for (name, on) in
            [("lean", self.lean), ("seating", self.seating), ("reseating", self.reseating)]
        {
            if on {
                write!(f, "+{name}")?;
            }
        }
        Ok(())
    }
}
