//! Observability: how well a set of pins determines the parameters, before anything is printed.
//!
//! The Fisher information of the pixels, `sum J^T J / sigma^2`, gives the smallest covariance that any unbiased solver
//! can reach (the Cramer-Rao bound). To find what *cannot* be determined, each parameter is measured in units of its
//! prior standard deviation ([`FitParameter::prior_sigma`]). In these units the information's eigenvalues are
//! comparable: 1 plus an eigenvalue is the squared ratio of the uncertainty before to that after. A combination is
//! called not observable if the images do not even reduce its uncertainty to a third.
//!
//! The seating offset is the important case. Pins of one length, all pointing at the dome's centre, have their tips on
//! one sphere. An offset makes that sphere smaller, which scales the tips about its centre, and a scaled scene at a
//! scaled distance looks the same to a camera without refraction. Then the information matrix is exactly singular, with
//! the offset and the camera's translation along the line to the dome's centre in its null space, whatever the number
//! of captures, even if the lens is known perfectly. Two lengths give two spheres; the ratio of their radii changes
//! with the offset, but not with scale.

use fabkit_camera::Camera;
use fabkit_geometry::Pose;
use nalgebra::{DMatrix, DVector, Matrix3, Vector2};

use crate::information::ScaledCholesky;
use crate::landmarks::PinLandmark;
use crate::model::{Contact, FitParameter, Model, Observation};

/// Largest ratio of the uncertainty after the images to the prior for an observable direction.
const OBSERVABLE: f64 = 1.0 / 3.0;
/// Smallest component of a parameter in a direction for which it is named.
const NAMED_PART: f64 = 0.25;

/// Number and quality of the planned images.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressPlan {
    /// Number of images with pins.
    pub captures: usize,
    /// Number of pins pushed home in each, spread evenly over the given pins.
    pub pins_per_capture: usize,
    /// Standard deviation of each pixel coordinate, px.
    pub sigma_px: f64,
}

/// Combination of parameters that the images do not determine.
///
/// ```
/// use fabkit_calibration::landmarks::PinLandmarks;
/// use fabkit_calibration::model::FitParameter;
/// use fabkit_calibration::observability::{PressPlan, predict};
/// use fabkit_camera::Camera;
/// use fabkit_geometry::Pose;
/// // All contacts on one sphere of 15 mm, its centre 15 mm in front of the camera: to pins that go in 1 mm deeper
/// // belongs a camera that is 1 mm nearer, and the pixels are the same.
/// let map = r#"{"1": [0, 0, 15], "2": [9, 0, 12], "3": [0, 9, 12], "4": [-9, 0, 12],
///     "5": [0, -12, 9], "6": [12, 0, 9], "7": [-12, 0, 9]}"#;
/// let landmarks = PinLandmarks::from_json(map)?;
/// let (camera, pose) = (Camera::equidistant(640, 480, 2.8)?, Pose::translation(0.0, 0.0, 15.0));
/// let effort = PressPlan { captures: 1000, pins_per_capture: 7, sigma_px: 0.3 };
/// let parameters = [&FitParameter::POSE[..], &[FitParameter::SeatingOffset]].concat();
/// let prediction = predict(&camera, &pose, &landmarks.pins, effort, &parameters);
/// assert!(!prediction.is_observable(FitParameter::SeatingOffset));
/// let terms = prediction.unobservable[0].terms.iter();
/// let names: Vec<String> = terms.map(|(parameter, _)| parameter.to_string()).collect();
/// assert_eq!(names, ["seating_offset_mm", "translation_z_mm"]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct UnobservableCombination {
    /// Parameters that can change together almost without effect, with their components in the combination: a unit
    /// vector in units of prior standard deviations, without components below a quarter. The largest comes first.
    pub terms: Vec<(FitParameter, f64)>,
    /// Ratio of the uncertainty after the images to that before; 1 if they carry no information.
    pub remaining: f64,
}

/// Predicted uncertainty of a calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationPrediction {
    /// Standard deviation of each parameter, given images and prior, in its unit.
    pub sigmas: Vec<(FitParameter, f64)>,
    /// Covariance of the parameters, in the order of `sigmas`.
    pub covariance: DMatrix<f64>,
    /// Standard deviation of the camera's position in the sensor frame, root of the sum of squares over the axes, mm.
    pub position_sigma_mm: f64,
    /// Standard deviation of the camera's orientation, root of the sum of squares over the axes, degrees.
    pub rotation_sigma_deg: f64,
    /// Combinations that stay undetermined, the worst first. Empty if all is well.
    pub unobservable: Vec<UnobservableCombination>,
    /// Holes whose pins the camera cannot see; they do not contribute.
    pub invisible_holes: Vec<u32>,
}

impl CalibrationPrediction {
    /// Returns the standard deviation of a parameter; `None` if it was not among those predicted.
    pub fn sigma(&self, parameter: FitParameter) -> Option<f64> {
        self.sigmas.iter().find(|(found, _)| *found == parameter).map(|(_, sigma)| *sigma)
    }

    /// Returns whether a parameter is named in no unobservable combination.
    pub fn is_observable(&self, parameter: FitParameter) -> bool {
        let named =
            |u: &UnobservableCombination| u.terms.iter().any(|(found, _)| *found == parameter);
        !self.unobservable.iter().any(named)
    }
}

/// Predicts how well `parameters` will be known.
///
/// ```
/// use fabkit_calibration::landmarks::PinLandmarks;
/// use fabkit_calibration::model::FitParameter;
/// use fabkit_calibration::observability::{PressPlan, predict};
/// use fabkit_camera::Camera;
/// use fabkit_geometry::Pose;
/// // Nine holes around a tip 15 mm in front of the camera.
/// let mut map = vec!["\"1\": [0, 0, 15]".to_owned()];
/// for k in 0..8 {
///     let (s, c) = (f64::from(k) * 0.785).sin_cos();
///     map.push(format!("\"{}\": [{:.3}, {:.3}, {}]", k + 2, 9.0 * c, 9.0 * s, 12 - k % 2 * 3));
/// }
/// let pins = PinLandmarks::from_json(&format!("{{{}}}", map.join(", "))).unwrap();
/// let camera = Camera::equidistant(640, 480, 2.8).unwrap();
/// let pose = Pose::translation(0.0, 0.0, 7.0);
/// let effort = PressPlan { captures: 10, pins_per_capture: 5, sigma_px: 0.3 };
/// let prediction = predict(&camera, &pose, &pins.pins, effort, &FitParameter::POSE);
/// assert!(prediction.unobservable.is_empty() && prediction.position_sigma_mm < 0.1);
/// ```
pub fn predict(
    camera: &Camera,
    camera_from_sensor: &Pose,
    pins: &[PinLandmark],
    effort: PressPlan,
    parameters: &[FitParameter],
) -> CalibrationPrediction {
    let model = Model::new(*camera, *camera_from_sensor);
    predict_from(&model, pins, &vec![true; pins.len()], effort, parameters)
}

/// Predicts as [`predict`] for a model, which may have a drawn interface. Pins that are hidden by parts of the sensor
/// are false in `is_seen`.
///
/// ```
/// use fabkit_calibration::landmarks::PinLandmarks;
/// use fabkit_calibration::model::{FitParameter, Model};
/// use fabkit_calibration::observability::{PressPlan, predict_from};
/// use fabkit_camera::Camera;
/// use fabkit_geometry::Pose;
/// let map = r#"{"1": [0, 0, 15], "2": [9, 0, 12], "3": [0, 9, 12], "4": [-9, 0, 12],
///     "5": [0, -12, 9]}"#;
/// let landmarks = PinLandmarks::from_json(map)?;
/// let model = Model::new(Camera::equidistant(640, 480, 2.8)?, Pose::translation(0.0, 0.0, 7.0));
/// let effort = PressPlan { captures: 4, pins_per_capture: 5, sigma_px: 0.3 };
/// // Something stands in front of hole 2.
/// let is_seen = [true, false, true, true, true];
/// let found = predict_from(&model, &landmarks.pins, &is_seen, effort, &FitParameter::POSE);
/// assert_eq!(found.invisible_holes, [2]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn predict_from(
    model: &Model,
    pins: &[PinLandmark],
    is_seen: &[bool],
    effort: PressPlan,
    parameters: &[FitParameter],
) -> CalibrationPrediction {
    let mut information = DMatrix::zeros(parameters.len(), parameters.len());
    let mut columns = vec![Vector2::zeros(); parameters.len()];
    let mut unseen_holes = Vec::new();
    let mut seen = 0usize;
    for (pin, is_seen) in pins.iter().zip(is_seen) {
        let contact = Contact {
            capture: 0,
            hole: pin.hole,
            contact_in_sensor_mm: pin.contact_in_sensor_mm,
            axis_in_sensor: pin.axis_in_sensor,
        };
        match model.differentiate(&contact, parameters, &mut columns) {
            Ok(pixel) if *is_seen && model.camera.is_in_image(&pixel) => {
                seen += 1;
                // The weight follows below, when the number of visible pins is known.
                add_information(&mut information, &columns, 1.0);
            }
            _ => unseen_holes.push(pin.hole),
        }
    }
    // The visible pins stand for all that will be pressed: their information is scaled to that number.
    unseen_holes.dedup();
    let pressed = effort.captures * effort.pins_per_capture;
    information *= pressed as f64 / seen.max(1) as f64 / effort.sigma_px.powi(2);
    let unobservable = find_unobservable_except_drawn(model, &information, parameters);
    let covariance = posterior_covariance(model, &information, parameters);
    let position = position_covariance(&covariance, parameters, &model.camera_from_sensor);
    let rotation: f64 = (0..parameters.len())
        .filter(|i| matches!(parameters[*i], FitParameter::Rotation(_)))
        .map(|i| covariance[(i, i)])
        .sum();
    CalibrationPrediction {
        sigmas: parameters
            .iter()
            .enumerate()
            .map(|(i, p)| (*p, covariance[(i, i)].sqrt()))
            .collect(),
        position_sigma_mm: position.trace().sqrt(),
        rotation_sigma_deg: rotation.sqrt().to_degrees(),
        covariance,
        unobservable,
        invisible_holes: unseen_holes,
    }
}

/// Finds the combinations that pixels leave undetermined, among the parameters that have no prior from the drawing or
/// of the light.
fn find_unobservable_except_drawn(
    model: &Model,
    information: &DMatrix<f64>,
    parameters: &[FitParameter],
) -> Vec<UnobservableCombination> {
    find_unobservable_except(model, information, parameters, &|p| model.has_drawing_prior(p))
}

/// Finds the combinations that pixels leave undetermined, among all parameters but those known beforehand.
fn find_unobservable_except(
    model: &Model,
    information: &DMatrix<f64>,
    parameters: &[FitParameter],
    is_known: &dyn Fn(FitParameter) -> bool,
) -> Vec<UnobservableCombination> {
    let (drawn, rest): (Vec<usize>, Vec<usize>) =
        (0..parameters.len()).partition(|i| is_known(parameters[*i]));
    if drawn.is_empty() {
        return find_unobservable(information, parameters);
    }
    let part = |rows: &[usize], columns: &[usize]| {
        DMatrix::from_fn(rows.len(), columns.len(), |r, c| information[(rows[r], columns[c])])
    };
    let mut known = part(&drawn, &drawn);
    for (i, at) in drawn.iter().enumerate() {
        known[(i, i)] += sigma(model, parameters[*at]).powi(-2);
    }
    // Schur complement: the information about the rest, with the known parameters free within their priors.
    let mixed = part(&rest, &drawn);
    let told = match ScaledCholesky::new(&known) {
        Some(factor) => part(&rest, &rest) - &mixed * factor.inverse() * mixed.transpose(),
        None => part(&rest, &rest),
    };
    let rest: Vec<FitParameter> = rest.into_iter().map(|at| parameters[at]).collect();
    find_unobservable(&told, &rest)
}

/// Returns a parameter's prior standard deviation: that of the drawing if it has one, else the general one.
fn sigma(model: &Model, parameter: FitParameter) -> f64 {
    let drawn = model.prior(parameter).filter(|_| model.has_drawing_prior(parameter));
    drawn.map_or(parameter.prior_sigma(), |(_, sigma)| sigma)
}

/// Finds the combinations of parameters that the observed pixels leave undetermined. Priors that take part in a fit do
/// not count, except those of the light.
pub fn find_unobservable_from_observations(
    model: &Model,
    parameters: &[FitParameter],
    observations: &[Observation],
) -> Vec<UnobservableCombination> {
    let mut information = DMatrix::zeros(parameters.len(), parameters.len());
    let mut columns = vec![Vector2::zeros(); parameters.len()];
    for observation in observations {
        if model.differentiate(&observation.contact, parameters, &mut columns).is_ok() {
            add_information(&mut information, &columns, observation.sigma_px.powi(-2));
        }
    }
    find_unobservable_except(model, &information, parameters, &|p| FitParameter::LIGHT.contains(&p))
}

/// Adds `weight J^T J` of one pixel to an information matrix.
fn add_information(information: &mut DMatrix<f64>, columns: &[Vector2<f64>], weight: f64) {
    for (i, a) in columns.iter().enumerate() {
        for (j, b) in columns[..=i].iter().enumerate() {
            let value = weight * a.dot(b);
            information[(i, j)] += value;
            if i != j {
                information[(j, i)] += value;
            }
        }
    }
}

/// Finds the combinations of parameters that an information matrix leaves undetermined.
pub(crate) fn find_unobservable(
    information: &DMatrix<f64>,
    parameters: &[FitParameter],
) -> Vec<UnobservableCombination> {
    let scale = DVector::from_iterator(
        parameters.len(),
        parameters.iter().map(|parameter| parameter.prior_sigma()),
    );
    let scaled = DMatrix::from_fn(parameters.len(), parameters.len(), |i, j| {
        information[(i, j)] * scale[i] * scale[j]
    });
    let eigen = scaled.symmetric_eigen();
    let mut found: Vec<UnobservableCombination> = Vec::new();
    for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        // Rounding can make an eigenvalue slightly negative.
        let remaining = 1.0 / (1.0 + value.max(0.0)).sqrt();
        if remaining <= OBSERVABLE {
            continue;
        }
        // The sign of an eigenvector is arbitrary: the largest component is made positive.
        let largest = vector.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs()));
        let sign = largest.unwrap_or(1.0).signum();
        let mut terms: Vec<(FitParameter, f64)> = parameters
            .iter()
            .zip(vector.iter())
            .map(|(parameter, part)| (*parameter, sign * part))
            .filter(|(_, part)| part.abs() > NAMED_PART)
            .collect();
        terms.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()).then(a.0.cmp(&b.0)));
        found.push(UnobservableCombination { terms, remaining });
    }
    found.sort_by(|a, b| b.remaining.total_cmp(&a.remaining));
    found
}

/// Computes the covariance `(I + D^-2)^-1`: never worse than the prior, and finite where the information is singular.
fn posterior_covariance(
    model: &Model,
    information: &DMatrix<f64>,
    parameters: &[FitParameter],
) -> DMatrix<f64> {
    let sigmas = parameters.iter().map(|parameter| sigma(model, *parameter));
    let sigmas = DVector::from_iterator(parameters.len(), sigmas);
    // If the information is not finite, the prior alone remains.
    ScaledCholesky::with_prior(information, &sigmas).map_or_else(
        || DMatrix::from_diagonal(&sigmas.map(|sigma| sigma.powi(2))),
        |factor| factor.inverse(),
    )
}

/// Computes the covariance of the camera's position in the sensor frame, mm^2, from that of a pose.
///
/// The position is `-R^T t`. With the rotation stepped as `exp(w) R` it moves by `-R^T (dt + t x w)`.
pub(crate) fn position_covariance(
    covariance: &DMatrix<f64>,
    parameters: &[FitParameter],
    camera_from_sensor: &Pose,
) -> Matrix3<f64> {
    let t = camera_from_sensor.translation_mm();
    let mut jacobian = DMatrix::zeros(3, parameters.len());
    for (i, parameter) in parameters.iter().enumerate() {
        let moved = match parameter {
            FitParameter::Translation(axis) => axis.unit(),
            FitParameter::Rotation(axis) => t.cross(&axis.unit()),
            _ => continue,
        };
        let column = -(camera_from_sensor.rotation().transpose() * moved);
        jacobian.set_column(i, &column);
    }
    let product = &jacobian * covariance * jacobian.transpose();
    Matrix3::from_fn(|i, j| product[(i, j)])
}
