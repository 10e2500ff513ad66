//! Fit of a flat gel's optical constants to its own captures of a ball.
//!
//! Two constants are shared by all captures: intensity of an infinitely thick layer and its scattering coefficient.
//! Each capture has the ball's depth as another parameter, which need not be measured: the width of the contact
//! determines it. The intensity from elsewhere follows from the image at rest. The lateral spread of light keeps its
//! known value.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use fabkit_files::Error;
use fabkit_fixtures::Project;
use fabkit_geometry::{Lighting, Point3, Scratch, Sensor, SurfacePoints, TouchSurface, Vector3};
use fabkit_light::{TwoStream, fit_positive};
use fabkit_scene::SensorView;
use fabkit_scene::ground_truth::Viewpoint;
use fabkit_scene::press_simulation::{ElasticSolver, resources};
use rayon::prelude::*;

use super::balls::{self, BallProfile, PadImageMap};
use super::simulated_profile::{Raster, SimulatedPatch};
use super::{
    BIN_GREY, FitLightError, SCATTER_LOG, SCATTER_PER_MM, SPACING_MM, check_shows_thickness,
    jackknife, residual_sigmas,
};
use crate::plausibility::{ExpectedLight, ImageFault, ImageGate, Judged};
use crate::{CapturedImage, LayerScene, LightConstants, check_size, surface_middle};

/// Smallest and largest simulated depth, as shares of the soft layers' thickness, and number of depths. Profiles of
/// other depths are interpolated linearly.
const DEPTHS: [f64; 2] = [0.1, 0.97];
const STEPS: usize = 13;
/// Number of surface nodes per radius of a large ball.
const NODES_TO_RADIUS: f64 = 8.0;
/// Largest depth as a share of the ball's radius. Deeper, the shaft would touch.
const MOST_OF_RADIUS: f64 = 0.97;
/// Start values of scattering, 1/mm, and of depths, as shares of the depth estimated from the contact's edge.
const SCATTER_STARTS: [f64; 2] = [0.1, 0.6];
const DEPTH_STARTS: [f64; 2] = [1.0, 0.7];
/// Start value of the intensity from elsewhere.
const GROUND: f64 = 10.0;
/// Steps of the finite differences of the constants, each in its unit, and of depths.
const SLOPE_STEPS: [f64; 4] = [1.0, 0.1, 0.001, 0.01];
/// Interval of the pixels that are compared at rest: one of this many.
const REST_STRIDE: usize = 97;
/// Largest residual of the fit, as a share of the mean intensity at rest. A real 9DTact that is compared through the
/// drawn camera leaves 0.26, simulated captures 0.03.
const MOST_UNEXPLAINED: f64 = 0.5;
/// Minimum number of captures for a jackknife of the constants.
const LEAST_CAPTURES: usize = 3;

/// Mapping between images and the pad.
#[derive(Clone, Copy, Debug)]
pub enum PadMapping<'a> {
    /// Images of a camera at its pose.
    Camera(&'a Viewpoint),
    /// Rectified images with this many millimetres per pixel, centred on the pad. The nominal camera gives the
    /// distance.
    Rectified(f64),
}

/// Returns whether optical constants are fitted to balls rather than pins: on flat gels.
///
/// ```
/// use fabkit_capture::light_fit::is_pad;
///
/// let of = |name: &str| -> Result<bool, Box<dyn std::error::Error>> {
///     let yaml = fabkit_designs::builtin_yaml(name).ok_or("no such sensor")?;
///     Ok(is_pad(&fabkit_fixtures::load(name, yaml, &[])?.design.sensor))
/// };
/// // A flat gel is fitted to balls, a dome to the pins of its calibration dome.
/// assert!(of("9dtact")? && !of("rtac0")?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn is_pad(sensor: &Sensor) -> bool {
    matches!(sensor.touch, Some(TouchSurface::Plane(_)))
}

/// Input of a fit to balls on a pad.
#[derive(Clone, Copy, Debug)]
pub struct PadFitInput<'a> {
    /// The sensor as designed.
    pub project: &'a Arc<Project>,
    /// Mapping between images and the pad.
    pub outline: PadMapping<'a>,
    /// Image without contact.
    pub reference: &'a Path,
    /// Images of one ball each.
    pub captures: &'a [PathBuf],
    /// Radius of the ball, mm.
    pub ball_radius_mm: f64,
}

/// Features of a profile: dark in the contact, bright in a ring around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileShape {
    /// Loss of intensity in the middle.
    pub middle_grey: f64,
    /// Distance at which the intensity equals that at rest, mm; `None` if it nowhere does.
    pub edge_mm: Option<f64>,
    /// Gain of intensity at the brightest place beyond that edge.
    pub ring_grey: f64,
    /// Distance of that place, mm.
    pub ring_mm: f64,
}

impl ProfileShape {
    /// Finds the features in means over bins of `bin_mm`.
    fn from_bins(darker: &[f64], bin_mm: f64) -> Self {
        let at = |bin: f64| (bin + 0.5) * bin_mm;
        // The contact's edge is the first change of sign from darker to brighter, interpolated between two bins.
        let crossing = darker.windows(2).position(|pair| pair[0] > 0.0 && pair[1] <= 0.0);
        let edge = crossing.map(|k| k as f64 + darker[k] / (darker[k] - darker[k + 1]));
        let beyond = crossing.map_or(darker.len() - 1, |k| k + 1);
        let brightest = (beyond..darker.len()).min_by(|a, b| darker[*a].total_cmp(&darker[*b]));
        let brightest = brightest.unwrap_or(beyond);
        let (mut ring_grey, mut place) = (-darker[brightest], brightest as f64);
        if brightest > 0 && brightest + 1 < darker.len() {
            // A parabola through three bins refines height and place of the maximum.
            let [before, now, after] =
                [-1, 0, 1].map(|k| -darker[(brightest as isize + k) as usize]);
            let bend = before - 2.0 * now + after;
            if bend < 0.0 {
                let off = 0.5 * (before - after) / bend;
                ring_grey = now - 0.25 * (before - after) * off;
                place += off;
            }
        }
        Self { middle_grey: darker[0], edge_mm: edge.map(at), ring_grey, ring_mm: at(place) }
    }
}

/// Result of one capture of a ball, real and predicted.
#[derive(Clone, Debug, PartialEq)]
pub struct BallResult {
    /// Path of the image.
    pub file: PathBuf,
    /// Centre of the ball, sensor frame, mm.
    pub at_mm: [f64; 2],
    /// Depth that explains the image best, mm.
    pub depth_mm: f64,
    /// Whether that depth is the smallest or largest that is tried.
    pub is_at_limit: bool,
    /// Offset of the whole image against the one at rest, in intensities.
    pub brighter_grey: f64,
    /// Loss of intensity by distance: real, with the constants of all captures, and with those of the other captures.
    pub profile_grey: Vec<[f64; 3]>,
    /// Features of the real profile.
    pub real: ProfileShape,
    /// Features of the predicted profile: held out where there are other captures.
    pub predicted: ProfileShape,
    /// Root mean square residual over the bins within the contact, in intensities.
    pub dark_rms_grey: f64,
}

/// Fitted constants of captures of balls.
#[derive(Clone, Debug)]
pub struct PadFit {
    /// Intensities of an infinitely thick layer and from elsewhere; scattering coefficient, 1/mm.
    pub values: [f64; 3],
    /// Standard deviations from leaving out each capture in turn, if there are three or more. At least as large as
    /// those from the residuals, taken as independent.
    pub sigmas: [f64; 3],
    /// Product of `layer_grey` and scattering, in intensities per mm, with its standard deviation: the initial slope of
    /// intensity over thickness. For a thin layer it is known better than either factor.
    pub layer_grey_per_mm: [f64; 2],
    /// Lateral spread of light that is held constant, mm.
    pub spread_mm: f64,
    /// Width of a profile's bins, mm.
    pub bin_mm: f64,
    /// Results of the captures, in order.
    pub balls: Vec<BallResult>,
    /// Root mean square residual over all profiles with the constants of all captures, in intensities.
    pub profile_rms_grey: f64,
    /// The same with the constants of the other captures; `None` for a single capture.
    pub held_out_profile_rms_grey: Option<f64>,
    /// Root mean square residual of the image at rest over the pad, in intensities.
    pub reference_rms_grey: f64,
}

impl PadFitInput<'_> {
    /// Fits the constants and predicts each capture from the others.
    ///
    /// # Errors
    /// Returns an error for images that cannot be read or show no ball, a sensor whose lighting shows no thickness, and
    /// layers that cannot be pressed.
    pub fn run(&self) -> Result<Judged<PadFit>, Error> {
        let sensor = &self.project.design.sensor;
        let lighting = crate::find_lighting(sensor, None)?;
        check_shows_thickness(sensor, lighting)?;
        let constants = LightConstants::for_sensor(sensor);
        let layers = LayerScene::new(sensor, lighting, &constants)?;
        let reference = CapturedImage::read(self.reference)?;
        let view = self.view(&layers, reference.size_px)?;
        check_size(self.reference, &reference, view.size_px())?;
        let expected = self.expected_light(lighting, &constants, view.size_px())?;
        let gate = ImageGate::new(expected, self.reference, reference)?;
        let (gate, mut judgement) = gate.accept_anyway();
        let reference = gate.reference().grey();
        // All faulty captures are reported at once.
        let (mut profiles, mut wrong) = (Vec::new(), Vec::new());
        for file in self.captures {
            let mut read = || {
                let (image, found) = gate.check(file, CapturedImage::read(file)?)?.accept_anyway();
                judgement.merge(&found);
                BallProfile::measure(&view, [gate.reference(), &image], self.ball_radius_mm)
            };
            match read() {
                Ok(profile) => profiles.push(profile),
                Err(error) => wrong.push(error),
            }
        }
        if let Some(error) = Error::join(wrong) {
            return Err(error);
        }
        let raster = balls::raster(self.ball_radius_mm, view.seen_from_mm());
        let model = Model::new(sensor, &layers, self.ball_radius_mm, raster)?;
        let lit_at =
            |[x, y]: [f64; 2]| layers.scene.lit.irradiance(&Point3::new(x, y, model.middle.z));
        let lit: Vec<f64> = profiles.iter().map(|profile| lit_at(profile.at_mm)).collect();
        let spread_mm = constants.spread_mm.value;
        let fitting = BallFit { profiles: &profiles, lit: &lit, model: &model, spread_mm };
        let all: Vec<usize> = (0..profiles.len()).collect();
        let values = fitting.solve(&all).ok_or(FitLightError::NoFit)?;
        let mut fitted = fitting.report(self.captures, &values)?;
        fitted.reference_rms_grey =
            rms(view.visible_pixels().step_by(REST_STRIDE).map(|(i, pixel)| {
                let sent = lit_at(pixel.at_mm) * fitting.rest_intensity(fitted.values, pixel.slant);
                balls::WHITE * f64::from(reference[i]) - sent
            }));
        let rest = view.visible_pixels().map(|(i, _)| f64::from(reference[i]));
        let (sum, count) = rest.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
        let mean = balls::WHITE * sum / f64::max(count, 1.0);
        let worst = fitted.reference_rms_grey.max(fitted.profile_rms_grey);
        // Written so that values that are no numbers are found, too.
        if worst.is_nan() || worst > MOST_UNEXPLAINED * mean {
            let fault = ImageFault::Unexplained { rms: worst, mean, most: MOST_UNEXPLAINED };
            judgement.find(self.reference, fault);
        }
        Ok(Judged::new(fitted, judgement))
    }

    /// Returns the drawn light as the images show it.
    fn expected_light(
        &self,
        lighting: &Lighting,
        constants: &LightConstants,
        size_px: [usize; 2],
    ) -> Result<ExpectedLight, Error> {
        Ok(match self.outline {
            PadMapping::Camera(viewpoint) => {
                let view = SensorView::new(Arc::clone(self.project), viewpoint.clone())?;
                ExpectedLight::render(&view, lighting, constants)
            }
            PadMapping::Rectified(_) => {
                ExpectedLight::unknown(size_px, "images that were rectified show no camera's view")
            }
        })
    }

    fn view(&self, layers: &LayerScene<'_>, size_px: [usize; 2]) -> Result<PadImageMap, Error> {
        let drawn = || Viewpoint::new(&self.project.design.sensor.camera, None, None);
        let viewpoint = match self.outline {
            PadMapping::Camera(viewpoint) => viewpoint.clone(),
            PadMapping::Rectified(_) => drawn().map_err(Error::bug)?,
        };
        let view = PadImageMap::from_camera(
            &SensorView::new(Arc::clone(self.project), viewpoint)?,
            layers,
        )?;
        Ok(match self.outline {
            PadMapping::Camera(_) => view,
            PadMapping::Rectified(mm) => {
                let points = SurfacePoints::new(layers.scene.touch).map_err(Error::bug)?;
                view.rectified(&points, size_px, mm)
            }
        })
    }
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (squares, count) = values.fold((0.0, 0.0), |(sum, count), x| (sum + x * x, count + 1.0));
    f64::sqrt(squares / f64::max(count, 1.0))
}

/// Pad under balls of increasing depth. It is pressed in its middle, and other places are taken to be like it.
struct Model {
    raster: Raster,
    depths_mm: Vec<f64>,
    patches: Vec<SimulatedPatch>,
    middle: Point3<f64>,
    /// Relative irradiance, and thickness of the layers, mm, in the middle.
    lit: f64,
    thick_mm: f64,
}

impl Model {
    fn new(
        sensor: &Sensor,
        layers: &LayerScene<'_>,
        ball_radius_mm: f64,
        raster: Raster,
    ) -> Result<Self, Error> {
        let scene = &layers.scene;
        let no_pad = || FitLightError::NoFit;
        let (middle, outward) = surface_middle(scene.touch).ok_or_else(no_pad)?;
        let thick = |place: &Point3<f64>, outward: &Vector3<f64>| {
            scene.thickness_mm((place, outward), &mut Scratch::default(), &mut Vec::new())
        };
        let thick_mm = thick(&middle, &outward).ok_or_else(no_pad)?;
        // Vertical paths: the slant of each capture's rays is applied later, as a factor on the scattering.
        let paths_mm = |rest: &Point3<f64>, outward: &Vector3<f64>, gains_mm: f64| {
            let thick_mm = thick(rest, outward).unwrap_or(0.0);
            [thick_mm, (thick_mm + gains_mm).max(0.0)]
        };
        let spacing_mm = SPACING_MM.max(ball_radius_mm / NODES_TO_RADIUS);
        let ready = ElasticSolver::for_any_press(sensor, Some(spacing_mm), false, resources())?;
        let most_mm =
            (DEPTHS[1] * scene.touch.max_indentation_mm()).min(MOST_OF_RADIUS * ball_radius_mm);
        let least_mm = DEPTHS[0] * scene.touch.max_indentation_mm();
        let depth_mm = |k: usize| least_mm + (most_mm - least_mm) * k as f64 / (STEPS - 1) as f64;
        let depths_mm: Vec<f64> = (0..STEPS).map(depth_mm).collect();
        let press = |depth_mm: &f64| {
            let tip = [ball_radius_mm, *depth_mm];
            SimulatedPatch::simulate(scene, &ready, &middle, tip, raster, paths_mm)
        };
        let patches = depths_mm.par_iter().map(press).collect::<Result<_, _>>()?;
        Ok(Self {
            raster,
            depths_mm,
            patches,
            middle,
            lit: scene.lit.irradiance(&middle),
            thick_mm,
        })
    }
}

/// Profiles of captures, and the model to compare them with.
struct BallFit<'a> {
    profiles: &'a [BallProfile],
    /// Relative irradiance at each ball.
    lit: &'a [f64],
    model: &'a Model,
    spread_mm: f64,
}

impl BallFit<'_> {
    /// Returns the loss of intensity in a capture by distance, for these constants and this depth.
    fn intensity_loss(&self, capture: usize, constants: [f64; 3], depth_mm: f64) -> Vec<f64> {
        let [layer_grey, _, scatter_per_mm] = constants;
        let (profile, depths) = (&self.profiles[capture], &self.model.depths_mm);
        let step_mm = depths[1] - depths[0];
        let at = ((depth_mm - depths[0]) / step_mm).clamp(0.0, (depths.len() - 1) as f64);
        let from = (at as usize).min(depths.len() - 2);
        // Two-stream reflectance depends on scattering times path, so a slanted path acts like stronger scattering.
        let law = TwoStream { scatter_per_mm: scatter_per_mm * profile.slant };
        // The patches were simulated with the irradiance in the pad's middle.
        let layer_grey = layer_grey * self.lit[capture] / self.model.lit;
        let [near, far] = [from, from + 1]
            .map(|k| self.model.patches[k].intensity_loss(layer_grey, law, self.spread_mm));
        let part = at - from as f64;
        near.iter().zip(far).map(|(near, far)| near + part * (far - near)).collect()
    }

    /// Returns the residuals of some captures for three constants and one depth each: real minus simulated profiles,
    /// and the intensity in the middle at rest; then the prior of the scattering coefficient.
    fn residuals(&self, captures: &[usize], values: &[f64]) -> Vec<f64> {
        let constants = [values[0], values[1], values[2]];
        let mut left = Vec::new();
        for (capture, depth_mm) in captures.iter().zip(&values[3..]) {
            let (profile, lit) = (&self.profiles[*capture], self.lit[*capture]);
            let simulated = self.intensity_loss(*capture, constants, *depth_mm);
            left.extend(profile.darker.iter().zip(simulated).map(|(real, now)| real - now));
            left.push(profile.rest_grey - lit * self.rest_intensity(constants, profile.slant));
        }
        left.push(BIN_GREY * (values[2] / SCATTER_PER_MM).ln() / SCATTER_LOG);
        left
    }

    /// Returns the intensity at rest for mean irradiance.
    fn rest_intensity(
        &self,
        [layer_grey, ground_grey, scatter_per_mm]: [f64; 3],
        slant: f64,
    ) -> f64 {
        let law = TwoStream { scatter_per_mm };
        ground_grey + layer_grey * law.reflectance(slant * self.model.thick_mm)
    }

    fn cost(&self, captures: &[usize], values: &[f64]) -> f64 {
        self.residuals(captures, values).iter().map(|left| left * left).sum()
    }

    /// Fits three constants and the depths of some captures.
    fn solve(&self, captures: &[usize]) -> Option<Vec<f64>> {
        let begin =
            SCATTER_STARTS.iter().flat_map(|scatter| DEPTH_STARTS.map(|part| (*scatter, part)));
        let from = |(scatter, part): (f64, f64)| {
            let mut start = vec![120.0 / scatter, GROUND, scatter];
            start.extend(captures.iter().map(|capture| part * self.depth_from_edge_mm(*capture)));
            fit_positive(|values| self.residuals(captures, values), &start)
        };
        let cost = |values: &Vec<f64>| self.cost(captures, values);
        begin.filter_map(from).min_by(|a, b| cost(a).total_cmp(&cost(b)))
    }

    /// Returns the simulated depth whose contact is as wide as the real one, mm.
    fn depth_from_edge_mm(&self, capture: usize) -> f64 {
        let (bin_mm, depths) = (self.model.raster.bin_mm, &self.model.depths_mm);
        let edge = |darker: &[f64]| ProfileShape::from_bins(darker, bin_mm).edge_mm;
        let Some(real) = edge(&self.profiles[capture].darker) else {
            return depths[depths.len() / 2];
        };
        let off = |depth_mm: &f64| {
            let simulated = self.intensity_loss(capture, [1.0, GROUND, SCATTER_PER_MM], *depth_mm);
            edge(&simulated).map_or(f64::INFINITY, |mm| (mm - real).abs())
        };
        depths.iter().copied().min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or_default()
    }

    /// Fits the depth of one capture for given constants, mm.
    fn depth_mm(&self, capture: usize, constants: [f64; 3]) -> f64 {
        let cost = |depth_mm: f64| {
            let simulated = self.intensity_loss(capture, constants, depth_mm);
            let real = &self.profiles[capture].darker;
            real.iter().zip(simulated).map(|(real, now)| (real - now).powi(2)).sum::<f64>()
        };
        let residuals = |values: &[f64]| {
            let simulated = self.intensity_loss(capture, constants, values[0]);
            self.profiles[capture]
                .darker
                .iter()
                .zip(simulated)
                .map(|(real, now)| real - now)
                .collect()
        };
        let nearest = self.model.depths_mm.iter().copied();
        let start = nearest.min_by(|a, b| cost(*a).total_cmp(&cost(*b))).unwrap_or_default();
        fit_positive(residuals, &[start]).map_or(start, |found| found[0])
    }

    /// Collects the results: residuals with the values of all captures, and predictions of each capture from the
    /// others. The caller sets `reference_rms_grey`.
    fn report(&self, files: &[PathBuf], values: &[f64]) -> Result<PadFit, Error> {
        let all: Vec<usize> = (0..self.profiles.len()).collect();
        let constants = [values[0], values[1], values[2]];
        let without = |capture: &usize| {
            let others: Vec<usize> = all.iter().copied().filter(|k| k != capture).collect();
            // The solution with all captures is a close start.
            let mut start = constants.to_vec();
            start.extend(others.iter().map(|other| values[3 + other]));
            fit_positive(|values| self.residuals(&others, values), &start)
                .ok_or(FitLightError::NoFit)
        };
        let held_out = if all.len() > 1 {
            all.par_iter().map(without).collect::<Result<Vec<_>, _>>()?
        } else {
            Vec::new()
        };
        let bin_mm = self.model.raster.bin_mm;
        let depths = &self.model.depths_mm;
        let [least_mm, most_mm] = [depths[0], depths[depths.len() - 1]];
        let balls: Vec<BallResult> = all
            .par_iter()
            .map(|capture| {
                let profile = &self.profiles[*capture];
                let own = self.intensity_loss(*capture, constants, values[3 + capture]);
                let predicted = held_out.get(*capture).map_or_else(
                    || own.clone(),
                    |others| {
                        let others = [others[0], others[1], others[2]];
                        self.intensity_loss(*capture, others, self.depth_mm(*capture, others))
                    },
                );
                let real = ProfileShape::from_bins(&profile.darker, bin_mm);
                let dark = real.edge_mm.map_or(own.len(), |mm| (mm / bin_mm) as usize);
                let left = profile.darker.iter().zip(&predicted).map(|(real, now)| real - now);
                let rows = profile.darker.iter().zip(&own).zip(&predicted);
                BallResult {
                    file: files[*capture].clone(),
                    at_mm: profile.at_mm,
                    depth_mm: values[3 + capture].clamp(least_mm, most_mm),
                    is_at_limit: !(least_mm..most_mm).contains(&values[3 + capture]),
                    brighter_grey: profile.brighter_grey,
                    dark_rms_grey: rms(left.take(dark)),
                    profile_grey: rows.map(|((real, own), now)| [*real, *own, *now]).collect(),
                    predicted: ProfileShape::from_bins(&predicted[..profile.darker.len()], bin_mm),
                    real,
                }
            })
            .collect();
        let left = |which: usize| {
            let rows = balls.iter().flat_map(|ball| &ball.profile_grey);
            rms(rows.map(|row| row[0] - row[which]))
        };
        let (constant, depth) = SLOPE_STEPS.split_at(3);
        let steps: Vec<f64> =
            constant.iter().chain(all.iter().map(|_| &depth[0])).copied().collect();
        let mut sigmas = residual_sigmas(|values| self.residuals(&all, values), values, &steps);
        // The fit is repeated with the product of `layer_grey` and scattering as a parameter, for its standard
        // deviation.
        let mut by_first = values.to_vec();
        by_first[0] *= values[2];
        let residuals = |by_first: &[f64]| {
            let mut values = by_first.to_vec();
            values[0] /= by_first[2];
            self.residuals(&all, &values)
        };
        let mut first_sigma = residual_sigmas(residuals, &by_first, &steps)[0];
        if all.len() >= LEAST_CAPTURES {
            let each =
                |values: &Vec<f64>| vec![values[0], values[1], values[2], values[0] * values[2]];
            let out = jackknife(&held_out.iter().map(each).collect::<Vec<_>>());
            sigmas.iter_mut().zip(&out).for_each(|(sigma, out)| *sigma = sigma.max(*out));
            first_sigma = first_sigma.max(out[3]);
        }
        Ok(PadFit {
            values: constants,
            sigmas: std::array::from_fn(|k| sigmas[k]),
            layer_grey_per_mm: [by_first[0], first_sigma],
            spread_mm: self.spread_mm,
            bin_mm,
            profile_rms_grey: left(1),
            held_out_profile_rms_grey: (!held_out.is_empty()).then(|| left(2)),
            reference_rms_grey: 0.0,
            balls,
        })
    }
}
