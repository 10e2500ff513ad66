//! The constants of a real unit's light, from its own captures of pins: what [`crate`] then rests on.
//!
//! Four numbers for all captures (what an endless layer sends back, what comes from elsewhere, how much the layer
//! scatters, how far light spreads in it) and how bright each picture is. How deep the pins went is looked for beside them:
//! what labels say of it is often not so.

mod balls;
mod document;
mod pads;
mod pads_document;
mod patch;
mod profiles;
mod seen;

use std::path::{Path, PathBuf};

use fabkit_calibration::assignment::assign;
use fabkit_calibration::landmarks::PinLandmarks;
use fabkit_calibration::model::Observation;
use fabkit_camera::{CameraEstimate, DMatrix};
use fabkit_geometry::{Sensor, SurfacePoints};
use fabkit_light::{TwoStream, fit};
use rayon::prelude::*;

pub use document::document;
pub use pads::{Ball, FittedPads, FittingPads, Outline, Shape, is_pad};
pub use pads_document::pads_document;

use fabkit_calibration::pin_captures::PinCaptureError;
use fabkit_calibration::pin_captures::PinCaptures;
use fabkit_calibration::pin_captures::pictures::read_grey;
use fabkit_files::{Error, ErrorKind, ErrorSubject, Explained};
use fabkit_scene::pressing::{Ready, threads};

use self::patch::{Patch, Raster};
use self::profiles::{BESIDE, BINS, Profile, mean_grey};
use self::seen::Seen;
use crate::{LightConstants, Scene};

/// Pins whose places differ by less in their polar angle, rad, and whose depths by less, mm, are one ring.
const SAME_RING_RAD: f64 = 0.03;
const SAME_DEPTH_MM: f64 = 0.15;
/// Depths of the middle pin that are tried beside the stated one, as parts of what is soft: the others go in as much deeper
/// or less deep than they should.
const DEPTHS: [f64; 7] = [0.3, 0.45, 0.6, 0.7, 0.8, 0.9, 0.97];
/// No pin goes in less or deeper, as parts of what is soft.
const DEPTH_LIMITS: [f64; 2] = [0.1, 0.97];
/// Polar angles at which the picture at rest is looked at, rad, and places around at each.
const REST_RAD: [f64; 13] =
    [0.05, 0.15, 0.25, 0.35, 0.45, 0.55, 0.65, 0.75, 0.85, 0.95, 1.05, 1.15, 1.25];
const AROUND: usize = 72;
/// Nearer to the outermost ring the picture at rest is not looked at, rad.
const MARGIN_RAD: f64 = 0.09;
/// What is known of scatter beforehand, 1/mm: R-Tac0's published unit, within a factor of e^1.5. Where a layer is thin for its
/// scatter, captures tell only what scatter times an endless layer's grey is, and one of the two would go anywhere. It counts
/// as much as one bin of one profile, grey.
const SCATTER_PER_MM: f64 = 0.14;
const SCATTER_LOG: f64 = 1.5;
const BIN_GREY: f64 = 2.0;
/// By so much constants are changed to see what that does, each in its unit.
const SLOPE_STEPS: [f64; 4] = [1.0, 0.1, 0.001, 0.01];
/// Distance of nodes on the surface, mm.
const SPACING_MM: f64 = 0.25;

/// Why there is no fit.
#[derive(Debug, thiserror::Error)]
pub enum FitLightError {
    /// Too little is seen.
    #[error(
        "{found} pins are seen whole in {captures} captures; a fit needs {least} in 3 at least"
    )]
    TooFew {
        /// Pins.
        found: usize,
        /// Captures.
        captures: usize,
        /// Least pins.
        least: usize,
    },
    /// Not of a dome.
    #[error("pins are fitted to on domes; `{sensor}` is none")]
    NoDome {
        /// The sensor.
        sensor: String,
    },
    /// Nothing in it is dark.
    #[error("{} shows no ball: nothing is {least} grey darker than at rest", .file.display())]
    NoBall {
        /// The picture.
        file: PathBuf,
        /// Least darkness, grey.
        least: f64,
    },
    /// A ball at the side of a picture or a pad.
    #[error(
        "the ball of {} is too near to the side: around {:.1}, {:.1} mm less than {least_mm:.1} mm are seen whole",
        .file.display(), .at_mm[0], .at_mm[1]
    )]
    NotWhole {
        /// The picture.
        file: PathBuf,
        /// Its middle, sensor frame, mm.
        at_mm: [f64; 2],
        /// How much of the pad must be seen around it, mm.
        least_mm: f64,
    },
    /// Two things press in one picture.
    #[error("{} shows more than one ball", .file.display())]
    Several {
        /// The picture.
        file: PathBuf,
    },
    /// The fit ends nowhere.
    #[error("no constants explain these captures: the fit does not end")]
    NoFit,
}

impl Explained for FitLightError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::NoFit => ErrorKind::Limit,
            _ => ErrorKind::BadInput,
        }
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::TooFew { .. } => "take more captures, with pins in full view",
            Self::NoDome { .. } => "press one ball in each capture, and leave landmarks away",
            Self::NoBall { .. } => {
                "press deeper; the picture at rest belongs apart from the others"
            }
            Self::NotWhole { .. } => {
                "press nearer to the middle of the pad, or give the size of a pixel if pictures are straight"
            }
            Self::Several { .. } => "press one ball in each capture",
            Self::NoFit => "look at the captures: is the reference of the same exposure?",
        };
        Some(hint.to_owned())
    }

    fn subject(&self) -> ErrorSubject {
        ErrorSubject::new("no_light")
    }
}

/// What is fitted from.
#[derive(Clone, Copy, Debug)]
pub struct FittingLight<'a> {
    /// The sensor as drawn.
    pub sensor: &'a Sensor,
    /// Its camera as calibrated.
    pub camera: &'a CameraEstimate,
    /// The pins that were to be had.
    pub landmarks: &'a PinLandmarks,
    /// Where pins are seen.
    pub captures: &'a PinCaptures<'a>,
    /// Where their pictures are.
    pub folder: &'a Path,
    /// The picture without contact.
    pub reference: &'a Path,
    /// Radius of the pins' tips, mm.
    pub pin_radius_mm: f64,
}

/// A ring of pins, held out in turn.
#[derive(Clone, Debug, PartialEq)]
pub struct Ring {
    /// Between the axis and the normal there, deg.
    pub polar_deg: f64,
    /// How deep its pins should go in, mm.
    pub stated_depth_mm: f64,
    /// Pins seen.
    pub pins: usize,
    /// How dark their middle is, median, grey.
    pub real_grey: f64,
    /// The same as predicted from the other captures.
    pub predicted_grey: f64,
    /// Median of what is left of each bin of the profile, rms over bins, grey.
    pub profile_rms_grey: f64,
    /// The median profile by distance from the mark, in bins of 0.25 mm, real and predicted, without what makes whole
    /// captures brighter, grey.
    pub profile_grey: Vec<[f64; 2]>,
}

/// Constants that explain captures, and what they do not explain.
#[derive(Clone, Debug)]
pub struct FittedLight {
    /// What an endless layer sends back, what comes from elsewhere, grey; scatter, 1/mm; spread, mm.
    pub values: [f64; 4],
    /// Standard deviations, from leaving out each capture in turn; no less than what is left of all of them says, which
    /// knows that a constant that came out as 0 may as well be a little more.
    pub sigmas: [f64; 4],
    /// How deep the pins went that explain the captures best, mm.
    pub pin_depth_mm: f64,
    /// What the landmarks say, mm: the median.
    pub stated_depth_mm: f64,
    /// Ring by ring.
    pub rings: Vec<Ring>,
    /// Over all rings and bins, grey.
    pub held_out_profile_rms_grey: f64,
    /// What is left of the picture at rest, by polar angle, grey, and its rms.
    pub reference: Vec<[f64; 3]>,
    /// The same.
    pub reference_rms_grey: f64,
    /// How many captures took part.
    pub captures: usize,
}

/// Captures and what the solver says of the same, for one depth.
#[derive(Clone, Debug)]
struct Fit<'a> {
    profiles: &'a [Profile],
    /// Ring of each profile.
    ring_of: &'a [usize],
    patches: Vec<Patch>,
    /// At rest: the polar angle, rad, how much light there is, the path in the layer, mm, and the real grey.
    rest: &'a [[f64; 4]],
}

impl FittingLight<'_> {
    /// Fits, and predicts each capture from the others.
    ///
    /// # Errors
    /// Marks without holes, pictures that cannot be read, a sensor whose light is not known here, too few pins.
    pub fn run(&self) -> Result<FittedLight, Error> {
        let scene = Scene::of(
            self.sensor,
            crate::lighting(self.sensor, None)?,
            &LightConstants::of(self.sensor),
        )?;
        let points = SurfacePoints::new(scene.touch).map_err(Error::bug)?;
        let SurfacePoints::Dome(dome) = &points else {
            return Err(FitLightError::NoDome { sensor: self.sensor.name.clone() }.into());
        };
        let nominal = self.sensor.camera.sensor_from_camera.inverse();
        let marked = &self.captures.marked;
        let assignment = assign(self.camera.camera(), &nominal, marked, &self.landmarks.pins)
            .ok_or(PinCaptureError::NotAssigned)?;
        let observations = &assignment.observations;
        let (tip, _) = dome.towards(0.0, 0.0).ok_or(FitLightError::NoFit)?;
        let seen = Seen::of(&assignment.model, scene.touch, &tip, observations);
        let seen = seen.ok_or(FitLightError::NoFit)?;
        let profiles = self.profiles(&scene, &seen, observations)?;
        let captures =
            profiles.iter().map(|p| p.capture).collect::<std::collections::BTreeSet<_>>();
        let least = 8;
        if profiles.len() < least || captures.len() < 3 {
            let (found, captures) = (profiles.len(), captures.len());
            return Err(FitLightError::TooFew { found, captures, least }.into());
        }
        let reference = read_grey(self.reference)?;
        let (rings, ring_of) = rings(&profiles);
        // Beyond the outermost pins the picture may show something else than the surface.
        let last_rad = rings.iter().map(|place| place.polar_rad).fold(0.0, f64::max) - MARGIN_RAD;
        let rest: Vec<[f64; 4]> = REST_RAD
            .iter()
            .filter(|polar| **polar < last_rad)
            .filter_map(|polar| {
                let around = (0..AROUND).map(|i| std::f64::consts::TAU * i as f64 / AROUND as f64);
                let places = around.filter_map(|azimuth| dome.towards(*polar, azimuth));
                let grey = mean_grey(places.map(|place| place.0), &seen, &reference)?;
                let (point, outward) = dome.towards(*polar, 0.0)?;
                let path_mm = scene.paths_mm(&point, &outward, 0.0)[0];
                Some([*polar, scene.lit.at(&point), path_mm, grey])
            })
            .collect();
        let ready = Ready::for_all(self.sensor, Some(SPACING_MM), false, threads())?;
        let soft_mm = scene.touch.soft_mm();
        let mut stated: Vec<f64> = profiles.iter().map(|profile| profile.stated_mm).collect();
        let stated_depth_mm = median(&mut stated);
        let mut depths_mm = DEPTHS.map(|part| part * soft_mm).to_vec();
        depths_mm.push(stated_depth_mm);
        depths_mm.sort_by(f64::total_cmp);
        let mut fits: Vec<OfDepth<'_>> = Vec::new();
        for depth_mm in depths_mm {
            let deeper_mm = depth_mm - stated_depth_mm;
            let patch = |ring: &RingPlace| {
                let (point, _) = dome.towards(ring.polar_rad, 0.0).ok_or(FitLightError::NoFit)?;
                let [least, most] = DEPTH_LIMITS.map(|part| part * soft_mm);
                let depth_mm = (ring.stated_mm + deeper_mm).clamp(least, most);
                let paths_mm =
                    |rest: &_, outward: &_, gains_mm| scene.paths_mm(rest, outward, gains_mm);
                let tip = [self.pin_radius_mm, depth_mm];
                Patch::pressed(&scene, &ready, &point, tip, Raster::PIN, paths_mm)
            };
            let patches = rings.iter().map(patch).collect::<Result<Vec<_>, Error>>()?;
            let fit = Fit { profiles: &profiles, ring_of: &ring_of, patches, rest: &rest };
            let Some(values) = fit.solve() else { continue };
            fits.push(OfDepth { depth_mm, values, fit });
        }
        let best =
            (0..fits.len()).min_by(|a, b| fits[*a].cost(None).total_cmp(&fits[*b].cost(None)));
        let best = best.ok_or(FitLightError::NoFit)?;
        let OfDepth { depth_mm: pin_depth_mm, values, fit } = &fits[best];
        let captures: Vec<usize> = captures.into_iter().collect();
        // Without a capture another depth may be the best: one of those beside it.
        let beside = &fits[best.saturating_sub(1)..(best + 2).min(fits.len())];
        let without = |capture: &usize| {
            let each = beside.iter().filter_map(|of| of.without(*capture));
            each.min_by(|a, b| a.cost(Some(*capture)).total_cmp(&b.cost(Some(*capture))))
        };
        let held_out: Vec<OfDepth<'_>> =
            captures.par_iter().map(without).collect::<Option<_>>().ok_or(FitLightError::NoFit)?;
        let values_of: Vec<Vec<f64>> = held_out.iter().map(|of| of.values.clone()).collect();
        Ok(FittedLight {
            sigmas: {
                let (out, least) = (
                    jackknife(&values_of),
                    least_sigmas(|values| fit.residuals(values, None), values, &SLOPE_STEPS),
                );
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
        .with_sums())
    }

    fn profiles(
        &self,
        scene: &Scene<'_>,
        seen: &Seen<'_>,
        observations: &[Observation],
    ) -> Result<Vec<Profile>, Error> {
        let reference = read_grey(self.reference)?;
        let mut profiles = Vec::new();
        for (i, record) in self.captures.records.iter().enumerate() {
            let picture = read_grey(&self.folder.join(&record.file))?;
            let here = observations.iter().filter(|o| o.contact.capture == i);
            profiles.extend(
                here.filter_map(|o| Profile::of(o, seen, scene.touch, [&reference, &picture])),
            );
        }
        Ok(profiles)
    }
}

/// What explains captures best if pins went so deep.
#[derive(Clone, Debug)]
struct OfDepth<'a> {
    depth_mm: f64,
    values: Vec<f64>,
    fit: Fit<'a>,
}

impl OfDepth<'_> {
    fn cost(&self, without: Option<usize>) -> f64 {
        self.fit.cost(&self.values, without)
    }

    /// The same without one capture.
    fn without(&self, capture: usize) -> Option<Self> {
        let residuals = |values: &[f64]| self.fit.residuals(values, Some(capture));
        let values = fit(residuals, &self.values)?;
        Some(Self { values, ..self.clone() })
    }
}

impl Fit<'_> {
    fn solve(&self) -> Option<Vec<f64>> {
        // What a layer sends back is about its scatter times what an endless one does.
        let scatter: [f64; 4] = [0.1, 0.3, 0.8, 2.0];
        let from = |scatter: &f64| {
            fit(|values| self.residuals(values, None), &[120.0 / scatter, 10.0, *scatter, 0.3])
        };
        let cost = |values: &Vec<f64>| self.cost(values, None);
        let all = scatter.iter().filter_map(from);
        all.min_by(|a, b| cost(a).total_cmp(&cost(b)))
    }

    fn cost(&self, values: &[f64], without: Option<usize>) -> f64 {
        self.residuals(values, without).iter().map(|left| left * left).sum()
    }

    /// Profiles ring by ring for these constants.
    fn simulated(&self, values: &[f64]) -> Vec<Vec<f64>> {
        let law = TwoStream { scatter_per_mm: values[2] };
        self.patches.iter().map(|patch| patch.darker(values[0], law, values[3])).collect()
    }

    /// Real less simulated, without what makes a whole capture brighter; then the picture at rest, and how usual the scatter is.
    fn residuals(&self, values: &[f64], without: Option<usize>) -> Vec<f64> {
        let simulated = self.simulated(values);
        let mut left = Vec::with_capacity(self.profiles.len() * BINS);
        for (profile, ring) in self.profiles.iter().zip(self.ring_of) {
            if Some(profile.capture) != without {
                left.extend(beside_itself(profile, &simulated[*ring]));
            }
        }
        // A bin of a median profile weighs as much as a place of the picture at rest.
        let weight = (self.profiles.len() as f64 / self.patches.len() as f64).sqrt();
        left.extend(
            self.at_rest(values).iter().map(|[_, real, simulated]| weight * (real - simulated)),
        );
        left.push(BIN_GREY * (values[2] / SCATTER_PER_MM).ln() / SCATTER_LOG);
        left
    }

    /// Polar angle, rad, real and simulated grey.
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
        held_out: &[OfDepth<'_>],
        rings: &[RingPlace],
    ) -> Vec<Ring> {
        let predicted: Vec<Vec<Vec<f64>>> =
            held_out.iter().map(|of| of.fit.simulated(&of.values)).collect();
        let ring = |(ring, place): (usize, &RingPlace)| {
            let mut left: [Vec<f64>; BINS] = Default::default();
            let mut now: [Vec<f64>; BINS] = Default::default();
            let here = self.profiles.iter().zip(self.ring_of).filter(|(_, of)| **of == ring);
            for (profile, _) in here {
                let fold = captures.iter().position(|c| *c == profile.capture).unwrap_or(0);
                let simulated = &predicted[fold][ring];
                let rest = beside_itself(profile, simulated);
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

impl FittedLight {
    fn with_sums(self) -> Self {
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

/// What is left of a profile, less what makes the whole picture there brighter or darker.
fn beside_itself(profile: &Profile, simulated: &[f64]) -> [f64; BINS] {
    let left: [f64; BINS] = std::array::from_fn(|bin| profile.darker[bin] - simulated[bin]);
    let beside = left[BESIDE..].iter().sum::<f64>() / (BINS - BESIDE) as f64;
    left.map(|grey| grey - beside)
}

/// Where a ring is, and how deep its pins should go in.
#[derive(Clone, Copy, Debug)]
struct RingPlace {
    polar_rad: f64,
    stated_mm: f64,
}

impl RingPlace {
    fn of(profile: &Profile) -> Self {
        Self { polar_rad: profile.polar_rad, stated_mm: profile.stated_mm }
    }

    fn is_of(&self, profile: &Profile) -> bool {
        (profile.polar_rad - self.polar_rad).abs() <= SAME_RING_RAD
            && (profile.stated_mm - self.stated_mm).abs() <= SAME_DEPTH_MM
    }
}

/// The rings, from the tip outwards, of each place those of less deep pins first; and the ring of each profile.
fn rings(profiles: &[Profile]) -> (Vec<RingPlace>, Vec<usize>) {
    let mut sorted: Vec<&Profile> = profiles.iter().collect();
    sorted.sort_by(|a, b| {
        let by_place = a.polar_rad.total_cmp(&b.polar_rad);
        by_place.then(a.stated_mm.total_cmp(&b.stated_mm))
    });
    let mut rings: Vec<RingPlace> = Vec::new();
    for profile in sorted {
        if !rings.iter().any(|ring| ring.is_of(profile)) {
            rings.push(RingPlace::of(profile));
        }
    }
    let ring = |profile: &Profile| rings.iter().position(|ring| ring.is_of(profile)).unwrap_or(0);
    let of = profiles.iter().map(ring).collect();
    (rings, of)
}

/// Standard deviations from what comes out without each of n (Quenouille, Tukey): (n - 1) / n of the squares' sum.
fn jackknife(held_out: &[Vec<f64>]) -> Vec<f64> {
    let count = held_out.len() as f64;
    let sigma = |k: usize| {
        let mean = held_out.iter().map(|values| values[k]).sum::<f64>() / count;
        let squares: f64 = held_out.iter().map(|values| (values[k] - mean).powi(2)).sum();
        ((count - 1.0) / count * squares).sqrt()
    };
    (0..held_out.first().map_or(0, Vec::len)).map(sigma).collect()
}

/// Standard deviations if all that is left were independent, to first order in the values themselves, each changed by its
/// step; 0 of all where two of them are one. Bins of a profile are not independent: these are the least that there are.
fn least_sigmas(residuals: impl Fn(&[f64]) -> Vec<f64>, values: &[f64], steps: &[f64]) -> Vec<f64> {
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
    // What has come to a limit changes nothing, and keeps no other from being known.
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
