//! Fit of a unit's optical constants to its own captures of pins. Simulated captures then use these constants.
//!
//! Four constants are shared by all captures: intensity of an infinitely thick layer, intensity from elsewhere,
//! scattering coefficient of the layer, and lateral spread of light in it. Each capture has an offset of its own. The
//! depth of the pins is searched as well, since the depths in labels are often wrong.

mod balls;
mod corrected_camera;
mod document;
mod error;
mod pads;
mod pads_document;
mod profiles;
mod rendered_pin;
mod simulated_profile;

use std::path::Path;

use fabkit_calibration::assignment::assign;
use fabkit_calibration::landmarks::PinLandmarks;
use fabkit_calibration::model::Observation;
use fabkit_camera::{CameraEstimate, DMatrix};
use fabkit_geometry::{Sensor, SurfacePoints};
use fabkit_light::{TwoStream, fit_positive};
use rayon::prelude::*;

pub use document::fit_document;
pub use error::FitLightError;
use error::check_shows_thickness;
pub use pads::{BallResult, PadFit, PadFitInput, PadMapping, ProfileShape, is_pad};
pub use pads_document::pads_document;

use fabkit_calibration::image::GreyImage;
use fabkit_calibration::pin_captures::PinCaptureError;
use fabkit_calibration::pin_captures::PinCaptures;
use fabkit_files::Error;

use self::corrected_camera::CorrectedCamera;
use self::profiles::{BINS, FIRST_BIN_BESIDE, PinProfile, mean_intensity};
use self::rendered_pin::{PinRenderer, RenderedPin};
use crate::plausibility::{CheckedImage, ExpectedLight, ImageGate, Judged, Judgement};
use crate::{CapturedImage, LayerGeometry, LightConstants};

/// Largest differences in polar angle, rad, and stated depth, mm, between pins of one ring.
const SAME_RING_RAD: f64 = 0.03;
const SAME_DEPTH_MM: f64 = 0.15;
/// Depths of the middle pin that are tried besides the stated one, as shares of the soft layers' thickness. The other
/// pins are shifted by the same difference.
const DEPTHS: [f64; 7] = [0.3, 0.45, 0.6, 0.7, 0.8, 0.9, 0.97];
/// How often the steps between depths are halved around the best one.
const DEPTH_HALVINGS: usize = 2;
/// Smallest and largest depth of a pin, as shares of the soft layers' thickness.
const DEPTH_LIMITS: [f64; 2] = [0.1, 0.97];
/// Polar angles at which the image at rest is sampled, rad, and number of samples around each.
const REST_RAD: [f64; 13] =
    [0.05, 0.15, 0.25, 0.35, 0.45, 0.55, 0.65, 0.75, 0.85, 0.95, 1.05, 1.15, 1.25];
const AROUND: usize = 72;
/// Distance in polar angle from the outermost ring within which the image at rest is not sampled, rad.
const MARGIN_RAD: f64 = 0.09;
/// Prior of the scattering coefficient, 1/mm, from R-Tac0's published unit, its standard deviation in the logarithm (a
/// factor of e^1.5), and its weight in intensities. Where a layer is thin for its scattering, captures only determine
/// the product of scattering and `layer_grey`, and the single values would drift. The prior weighs as much as one bin
/// of one profile.
const SCATTER_PER_MM: f64 = 0.14;
const SCATTER_LOG: f64 = 1.5;
const BIN_GREY: f64 = 2.0;
/// Steps of the finite differences of the constants, each in its unit.
const SLOPE_STEPS: [f64; 4] = [1.0, 0.1, 0.001, 0.01];
/// Distance of nodes on the surface, mm.
const SPACING_MM: f64 = 0.25;

/// Input of a fit to pins.
#[derive(Clone, Copy, Debug)]
pub struct LightFitInput<'a> {
    /// The sensor as designed.
    pub sensor: &'a Sensor,
    /// Calibrated camera.
    pub camera: &'a CameraEstimate,
    /// Landmarks: the holes of the fixture with their pins.
    pub landmarks: &'a PinLandmarks,
    /// Captures with the pixels of the pins' marks.
    pub captures: &'a PinCaptures<'a>,
    /// Folder of the captures' images.
    pub folder: &'a Path,
    /// Image without contact.
    pub reference: &'a Path,
    /// Radius of the pins' tips, mm.
    pub pin_radius_mm: f64,
}

/// A ring of pins with equal polar angle and depth, predicted from other captures.
#[derive(Clone, Debug, PartialEq)]
pub struct Ring {
    /// Angle between the axis and the normal there, deg.
    pub polar_deg: f64,
    /// Depth of its pins in the labels, mm.
    pub stated_depth_mm: f64,
    /// Number of visible pins.
    pub pins: usize,
    /// Median loss of intensity in the middle of the pins.
    pub real_grey: f64,
    /// Median loss predicted from the other captures.
    pub predicted_grey: f64,
    /// Root mean square over bins of the median residual of each bin, in intensities.
    pub profile_rms_grey: f64,
    /// Median loss of intensity by distance from the mark, in bins of 0.25 mm: real and predicted, without the offsets
    /// of whole captures.
    pub profile_grey: Vec<[f64; 2]>,
}

/// Fitted constants and their residuals.
#[derive(Clone, Debug)]
pub struct LightFit {
    /// Intensities of an infinitely thick layer and from elsewhere; scattering coefficient, 1/mm; lateral spread, mm.
    pub values: [f64; 4],
    /// Standard deviations, from leaving out each capture in turn. At least as large as those from the residuals of all
    /// captures, so that a constant at its limit of 0 does not seem exact.
    pub sigmas: [f64; 4],
    /// Depth of the pins that explains the captures best, mm.
    pub pin_depth_mm: f64,
    /// Median depth in the landmarks, mm.
    pub stated_depth_mm: f64,
    /// Results ring by ring.
    pub rings: Vec<Ring>,
    /// Root mean square of held-out residuals over all rings and bins, in intensities.
    pub held_out_profile_rms_grey: f64,
    /// Image at rest: polar angle, rad, real intensity and simulated intensity.
    pub reference: Vec<[f64; 3]>,
    /// Root mean square difference of these intensities.
    pub reference_rms_grey: f64,
    /// Number of captures in the fit.
    pub captures: usize,
}

/// Captures, and the same pins rendered, for one depth.
#[derive(Clone)]
struct PinFit<'a> {
    profiles: &'a [PinProfile],
    /// Ring index of each profile.
    ring_of: &'a [usize],
    pins: Vec<RenderedPin>,
    renderer: &'a PinRenderer<'a>,
    /// Constants of which four are fitted.
    constants: &'a LightConstants,
    /// Samples at rest: polar angle, rad, relative irradiance, path in the layer, mm, and real intensity.
    rest: &'a [[f64; 4]],
}

impl LightFitInput<'_> {
    /// Fits the constants and predicts each capture from the others.
    ///
    /// # Errors
    /// Returns an error for marks that cannot be assigned to holes, images that cannot be read, a sensor whose lighting
    /// cannot be simulated, and too few pins.
    pub fn run(&self) -> Result<Judged<LightFit>, Error> {
        let lighting = crate::find_lighting(self.sensor, None)?;
        check_shows_thickness(self.sensor, lighting)?;
        let scene =
            LayerGeometry::new(self.sensor, lighting, &LightConstants::for_sensor(self.sensor))?;
        let points = SurfacePoints::new(scene.touch).map_err(Error::bug)?;
        let SurfacePoints::Dome(dome) = &points else {
            return Err(FitLightError::NoDome { sensor: self.sensor.name.clone() }.into());
        };
        let nominal = self.sensor.camera.sensor_from_camera.inverse();
        let marked = &self.captures.marked;
        let assignment = assign(self.camera.camera(), &nominal, marked, &self.landmarks.pins)
            .ok_or(PinCaptureError::NotAssigned)?;
        let observations = &assignment.observations;
        let (tip, _) = dome.point_in_direction(0.0, 0.0).ok_or(FitLightError::NoFit)?;
        let seen = CorrectedCamera::fit(&assignment.model, scene.touch, &tip, observations);
        let seen = seen.ok_or(FitLightError::NoFit)?;
        let (gate, mut judgement) = self.gate()?.accept_anyway();
        let (profiles, found) = self.profiles(&scene, &seen, observations, &gate)?.accept_anyway();
        judgement.merge(&found);
        let captures =
            profiles.iter().map(|p| p.capture).collect::<std::collections::BTreeSet<_>>();
        let least = 8;
        if profiles.len() < least || captures.len() < 3 {
            let (found, captures) = (profiles.len(), captures.len());
            return Err(FitLightError::TooFew { found, captures, least }.into());
        }
        let reference = to_grey_image(gate.reference())?;
        let (rings, ring_of) = rings(&profiles);
        // Beyond the outermost pins the image may show something other than the surface.
        let last_rad = rings.iter().map(|place| place.polar_rad).fold(0.0, f64::max) - MARGIN_RAD;
        let rest: Vec<[f64; 4]> = REST_RAD
            .iter()
            .filter(|polar| **polar < last_rad)
            .filter_map(|polar| {
                let around = (0..AROUND).map(|i| std::f64::consts::TAU * i as f64 / AROUND as f64);
                let places = around.filter_map(|azimuth| dome.point_in_direction(*polar, azimuth));
                let grey = mean_intensity(places.map(|place| place.0), &seen, &reference)?;
                let (point, outward) = dome.point_in_direction(*polar, 0.0)?;
                let path_mm = scene.paths_mm(&point, &outward, 0.0)[0];
                Some([*polar, scene.lit.irradiance(&point), path_mm, grey])
            })
            .collect();
        // The exposure is part of the constants that are fitted.
        let constants =
            LightConstants { middle_grey: None, ..LightConstants::for_sensor(self.sensor) };
        let renderer = PinRenderer::new(self.sensor, lighting, self.camera.camera(), &constants)?;
        let soft_mm = scene.touch.max_indentation_mm();
        let mut stated: Vec<f64> = profiles.iter().map(|profile| profile.stated_mm).collect();
        let stated_depth_mm = median(&mut stated);
        let mut depths_mm = DEPTHS.map(|part| part * soft_mm).to_vec();
        depths_mm.push(stated_depth_mm);
        let fit_at = |depth_mm: f64, from: Option<&[f64]>| -> Result<Option<DepthFit<'_>>, Error> {
            let deeper_mm = depth_mm - stated_depth_mm;
            let pin = |ring: &RingPlace| {
                let (point, _) =
                    dome.point_in_direction(ring.polar_rad, 0.0).ok_or(FitLightError::NoFit)?;
                let [least, most] = DEPTH_LIMITS.map(|part| part * soft_mm);
                // All rings are shifted by the same difference, within what the soft layers allow.
                let depth_mm = (ring.stated_mm + deeper_mm).clamp(least, most);
                renderer.render(&point, [self.pin_radius_mm, depth_mm])
            };
            let pins = rings.par_iter().map(pin).collect::<Result<Vec<_>, Error>>()?;
            let fit = PinFit {
                profiles: &profiles,
                ring_of: &ring_of,
                pins,
                renderer: &renderer,
                constants: &constants,
                rest: &rest,
            };
            let values = fit.solve(from);
            Ok(values.map(|values| DepthFit { depth_mm, values, fit }))
        };
        let mut fits: Vec<DepthFit<'_>> = Vec::new();
        let mut best = 0;
        for _ in 0..=DEPTH_HALVINGS {
            let from = fits.get(best).map(|of: &DepthFit<'_>| of.values.clone());
            for depth_mm in depths_mm {
                // A depth without a converging fit is skipped.
                fits.extend(fit_at(depth_mm, from.as_deref())?);
            }
            fits.sort_by(|a, b| a.depth_mm.total_cmp(&b.depth_mm));
            best = (0..fits.len())
                .min_by(|a, b| fits[*a].cost(None).total_cmp(&fits[*b].cost(None)))
                .ok_or(FitLightError::NoFit)?;
            // The depths between the best one and its neighbours are tried next.
            let beside = &fits[best.saturating_sub(1)..(best + 2).min(fits.len())];
            let between = |pair: &[DepthFit<'_>]| f64::midpoint(pair[0].depth_mm, pair[1].depth_mm);
            depths_mm = beside.windows(2).map(between).collect();
        }
        let DepthFit { depth_mm: pin_depth_mm, values, fit } = &fits[best];
        let captures: Vec<usize> = captures.into_iter().collect();
        // Without one capture another depth may fit best; only the neighbouring depths are tried.
        let beside = &fits[best.saturating_sub(1)..(best + 2).min(fits.len())];
        let without = |capture: &usize| {
            let each = beside.iter().filter_map(|of| of.without(*capture));
            each.min_by(|a, b| a.cost(Some(*capture)).total_cmp(&b.cost(Some(*capture))))
        };
        let held_out: Vec<DepthFit<'_>> =
            captures.par_iter().map(without).collect::<Option<_>>().ok_or(FitLightError::NoFit)?;
        let values_of: Vec<Vec<f64>> = held_out.iter().map(|of| of.values.clone()).collect();
        let fitted = LightFit {
            sigmas: {
                let (out, least) = (
                    jackknife(&values_of),
                    residual_sigmas(|values| fit.residuals(values, None), values, &SLOPE_STEPS),
                );
                // The jackknife is too optimistic for constants at a limit.
                std::array::from_fn(|k| out[k].max(least[k]))
            },
            rings: fit.held_out(&captures, &held_out, &rings),
            held_out_profile_rms_grey: 0.0,
            reference: fit.at_rest(values),
            reference_rms_grey: 0.0,
            pin_depth_mm: *pin_depth_mm,
            stated_depth_mm,
            captures: captures.len(),
            values: std::array::from_fn(|k| values[k]),
        }
        .with_totals();
        Ok(Judged::new(fitted, judgement))
    }

    /// Makes the gate for the captures. The camera's pose follows from them, so that nothing drawn is compared.
    fn gate(&self) -> Result<Judged<ImageGate>, Error> {
        let image = CapturedImage::read(self.reference)?;
        let why = "the pins in the images determine the camera's pose";
        ImageGate::new(ExpectedLight::unknown(image.size_px, why), self.reference, image)
    }

    fn profiles(
        &self,
        scene: &LayerGeometry<'_>,
        seen: &CorrectedCamera<'_>,
        observations: &[Observation],
        gate: &ImageGate,
    ) -> Result<Judged<Vec<PinProfile>>, Error> {
        let reference = to_grey_image(gate.reference())?;
        let (mut profiles, mut judgement) = (Vec::new(), Judgement::default());
        for (i, record) in self.captures.records.iter().enumerate() {
            let file = self.folder.join(&record.file);
            let (image, found) = gate.check(&file, CapturedImage::read(&file)?)?.accept_anyway();
            judgement.merge(&found);
            let image = to_grey_image(&image)?;
            let here = observations.iter().filter(|o| o.contact.capture == i);
            profiles.extend(
                here.filter_map(|o| {
                    PinProfile::measure(o, seen, scene.touch, [&reference, &image])
                }),
            );
        }
        Ok(Judged::new(profiles, judgement))
    }
}

fn to_grey_image(checked: &CheckedImage) -> Result<GreyImage, Error> {
    let [width_px, height_px] = checked.image().size_px.map(|px| px as u32);
    GreyImage::new(width_px, height_px, checked.grey()).map_err(|source| {
        let file = checked.file().display().to_string();
        PinCaptureError::Image { file, source }.into()
    })
}

/// Best constants for one depth of the pins.
#[derive(Clone)]
struct DepthFit<'a> {
    depth_mm: f64,
    values: Vec<f64>,
    fit: PinFit<'a>,
}

impl DepthFit<'_> {
    fn cost(&self, without: Option<usize>) -> f64 {
        self.fit.cost(&self.values, without)
    }

    /// Fits again without one capture.
    fn without(&self, capture: usize) -> Option<Self> {
        let residuals = |values: &[f64]| self.fit.residuals(values, Some(capture));
        let values = fit_positive(residuals, &self.values)?;
        Some(Self { values, ..self.clone() })
    }
}

impl PinFit<'_> {
    /// Fits the constants, from those of a depth nearby if there are any.
    fn solve(&self, from: Option<&[f64]>) -> Option<Vec<f64>> {
        if let Some(from) = from {
            return fit_positive(|values| self.residuals(values, None), from);
        }
        // Start values keep the product of scattering and infinite-layer intensity at 120, since a thin layer's
        // brightness is about that product.
        let scatter: [f64; 4] = [0.1, 0.3, 0.8, 2.0];
        let from = |scatter: &f64| {
            fit_positive(
                |values| self.residuals(values, None),
                &[120.0 / scatter, 10.0, *scatter, 0.3],
            )
        };
        let cost = |values: &Vec<f64>| self.cost(values, None);
        let all = scatter.iter().filter_map(from);
        all.min_by(|a, b| cost(a).total_cmp(&cost(b)))
    }

    fn cost(&self, values: &[f64], without: Option<usize>) -> f64 {
        self.residuals(values, without).iter().map(|left| left * left).sum()
    }

    /// Renders the profile of each ring.
    fn simulated(&self, values: &[f64]) -> Vec<Vec<f64>> {
        let mut constants = self.constants.clone();
        constants.set_fitted(values);
        self.pins.par_iter().map(|pin| self.renderer.profile(pin, &constants)).collect()
    }

    /// Returns the residuals: real minus simulated profiles without offsets, then the image at rest, then the prior of
    /// the scattering coefficient.
    fn residuals(&self, values: &[f64], without: Option<usize>) -> Vec<f64> {
        let simulated = self.simulated(values);
        let mut left = Vec::with_capacity(self.profiles.len() * BINS);
        for (profile, ring) in self.profiles.iter().zip(self.ring_of) {
            if Some(profile.capture) != without {
                left.extend(residuals_without_offset(profile, &simulated[*ring]));
            }
        }
        // One bin of a median profile weighs as much as one sample of the image at rest.
        let weight = (self.profiles.len() as f64 / self.pins.len() as f64).sqrt();
        left.extend(
            self.at_rest(values).iter().map(|[_, real, simulated]| weight * (real - simulated)),
        );
        left.push(BIN_GREY * (values[2] / SCATTER_PER_MM).ln() / SCATTER_LOG);
        left
    }

    /// Returns polar angle, rad, real intensity and simulated intensity at rest.
    fn at_rest(&self, values: &[f64]) -> Vec<[f64; 3]> {
        let law = TwoStream { scatter_per_mm: values[2] };
        let grey = |[polar, lit, path_mm, real]: &[f64; 4]| {
            [*polar, *real, lit * (values[1] + values[0] * law.reflectance(*path_mm))]
        };
        self.rest.iter().map(grey).collect()
    }

    fn held_out(
        &self,
        captures: &[usize],
        held_out: &[DepthFit<'_>],
        rings: &[RingPlace],
    ) -> Vec<Ring> {
        let predicted: Vec<Vec<Vec<f64>>> =
            held_out.iter().map(|of| of.fit.simulated(&of.values)).collect();
        // Each profile is compared with the prediction that was made without its own capture.
        let ring = |(ring, place): (usize, &RingPlace)| {
            let mut left: [Vec<f64>; BINS] = Default::default();
            let mut now: [Vec<f64>; BINS] = Default::default();
            let here = self.profiles.iter().zip(self.ring_of).filter(|(_, of)| **of == ring);
            for (profile, _) in here {
                let fold = captures.iter().position(|c| *c == profile.capture).unwrap_or(0);
                let simulated = &predicted[fold][ring];
                let rest = residuals_without_offset(profile, simulated);
                left.iter_mut().zip(rest).for_each(|(all, one)| all.push(one));
                now.iter_mut().zip(simulated).for_each(|(all, one)| all.push(*one));
            }
            let pins = left[0].len();
            let both = left.iter_mut().zip(&mut now);
            let medians: Vec<[f64; 2]> =
                both.map(|(left, now)| [median(left), median(now)]).collect();
            let squares: f64 = medians.iter().map(|[left, _]| left * left).sum();
            let profile_grey: Vec<[f64; 2]> =
                medians.iter().map(|[left, now]| [left + now, *now]).collect();
            Ring {
                polar_deg: place.polar_rad.to_degrees(),
                stated_depth_mm: place.stated_mm,
                pins,
                real_grey: profile_grey[0][0],
                predicted_grey: profile_grey[0][1],
                profile_grey,
                profile_rms_grey: (squares / BINS as f64).sqrt(),
            }
        };
        rings.iter().enumerate().map(ring).collect()
    }
}

impl LightFit {
    fn with_totals(self) -> Self {
        let rms = |squares: f64, count: usize| (squares / count as f64).sqrt();
        let profiles = self.rings.iter().map(|ring| ring.profile_rms_grey.powi(2)).sum();
        let rest = self.reference.iter().map(|[_, real, now]| (real - now).powi(2)).sum();
        Self {
            held_out_profile_rms_grey: rms(profiles, self.rings.len()),
            reference_rms_grey: rms(rest, self.reference.len()),
            ..self
        }
    }
}

/// Returns the residuals of a profile minus their mean beside the pin, which is the offset of the whole capture.
fn residuals_without_offset(profile: &PinProfile, simulated: &[f64]) -> [f64; BINS] {
    let left: [f64; BINS] = std::array::from_fn(|bin| profile.darker[bin] - simulated[bin]);
    let beside = left[FIRST_BIN_BESIDE..].iter().sum::<f64>() / (BINS - FIRST_BIN_BESIDE) as f64;
    left.map(|grey| grey - beside)
}

/// Polar angle of a ring and depth of its pins in the labels.
#[derive(Clone, Copy, Debug)]
struct RingPlace {
    polar_rad: f64,
    stated_mm: f64,
}

impl RingPlace {
    fn from_profile(profile: &PinProfile) -> Self {
        Self { polar_rad: profile.polar_rad, stated_mm: profile.stated_mm }
    }

    fn contains(&self, profile: &PinProfile) -> bool {
        (profile.polar_rad - self.polar_rad).abs() <= SAME_RING_RAD
            && (profile.stated_mm - self.stated_mm).abs() <= SAME_DEPTH_MM
    }
}

/// Groups profiles to rings, ordered by polar angle and then by depth. Also returns the ring index of each profile.
fn rings(profiles: &[PinProfile]) -> (Vec<RingPlace>, Vec<usize>) {
    let mut sorted: Vec<&PinProfile> = profiles.iter().collect();
    sorted.sort_by(|a, b| {
        let by_place = a.polar_rad.total_cmp(&b.polar_rad);
        by_place.then(a.stated_mm.total_cmp(&b.stated_mm))
    });
    let mut rings: Vec<RingPlace> = Vec::new();
    for profile in sorted {
        if !rings.iter().any(|ring| ring.contains(profile)) {
            rings.push(RingPlace::from_profile(profile));
        }
    }
    let ring =
        |profile: &PinProfile| rings.iter().position(|ring| ring.contains(profile)).unwrap_or(0);
    let of = profiles.iter().map(ring).collect();
    (rings, of)
}

/// Returns jackknife standard deviations (Quenouille, Tukey) from estimates without each of n captures: (n - 1) / n
/// times the sum of squares.
fn jackknife(held_out: &[Vec<f64>]) -> Vec<f64> {
    let count = held_out.len() as f64;
    let sigma = |k: usize| {
        let mean = held_out.iter().map(|values| values[k]).sum::<f64>() / count;
        let squares: f64 = held_out.iter().map(|values| (values[k] - mean).powi(2)).sum();
        ((count - 1.0) / count * squares).sqrt()
    };
    (0..held_out.first().map_or(0, Vec::len)).map(sigma).collect()
}

/// Returns standard deviations for independent residuals, to first order in the values, each changed by its step. All
/// are 0 if two values cannot be told apart. Bins of a profile are not independent, so these are lower bounds.
fn residual_sigmas(
    residuals: impl Fn(&[f64]) -> Vec<f64>,
    values: &[f64],
    steps: &[f64],
) -> Vec<f64> {
    let left = residuals(values);
    let slope = |(k, step): (usize, &f64)| -> Vec<f64> {
        let mut more = values.to_vec();
        more[k] += step;
        let more = residuals(&more);
        more.iter().zip(&left).map(|(more, now)| (more - now) / step).collect()
    };
    let slopes: Vec<Vec<f64>> = steps.iter().enumerate().map(slope).collect();
    let count = steps.len();
    let mut normal = DMatrix::from_fn(count, count, |i, j| {
        slopes[i].iter().zip(&slopes[j]).map(|(a, b)| a * b).sum::<f64>()
    });
    // A value at a limit does not change the residuals. Its unit diagonal keeps the matrix invertible for the others.
    let is_stuck: Vec<bool> = (0..count).map(|k| normal[(k, k)] == 0.0).collect();
    (0..count).filter(|k| is_stuck[*k]).for_each(|k| normal[(k, k)] = 1.0);
    let squares: f64 = left.iter().map(|left| left * left).sum();
    let variance = squares / left.len().saturating_sub(count).max(1) as f64;
    let covariance = normal.try_inverse();
    let sigma =
        |k: usize| covariance.as_ref().map_or(0.0, |all| (variance * all[(k, k)]).max(0.0).sqrt());
    (0..count).map(sigma).collect()
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => f64::NAN,
        count if count % 2 == 1 => values[count / 2],
        count => 0.5 * (values[count / 2 - 1] + values[count / 2]),
    }
}
