//! The constants of a flat gel's light, from its own captures of a ball.
//!
//! Two numbers for all captures, what an endless layer sends back and how much it scatters, and how deep the ball went in each
//! one, which nobody needs to have measured: how wide the contact is tells it. What comes from elsewhere is what the picture at
//! rest has beside the layer's light. How far light spreads in the layer stays what it is known to be.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use fabkit_files::Error;
use fabkit_fixtures::Project;
use fabkit_geometry::{Point3, Scratch, Sensor, SurfacePoints, TouchSurface, Vector3};
use fabkit_light::{TwoStream, fit};
use fabkit_scene::SensorView;
use fabkit_scene::ground_truth::Viewpoint;
use fabkit_scene::pressing::{Ready, threads};
use rayon::prelude::*;

use super::balls::{self, PadView, Profile};
use super::patch::{Patch, Raster};
use super::{
    BIN_GREY, FitLightError, SCATTER_LOG, SCATTER_PER_MM, SPACING_MM, jackknife, least_sigmas,
};
use crate::{LayerScene, LightConstants, middle_of};
use crate::{Taken, check_size};

/// Least and largest depth that is tried, as parts of what is soft, and how many between them: profiles of others lie between
/// these, in proportion.
const DEPTHS: [f64; 2] = [0.1, 0.97];
const STEPS: usize = 13;
/// Nodes of the surface to a large ball's radius.
const NODES_TO_RADIUS: f64 = 8.0;
/// No ball goes in deeper than this part of its radius: its shaft would.
const MOST_OF_RADIUS: f64 = 0.97;
/// Scatter from which a fit begins, 1/mm; and depths, as parts of what the contact's edge says.
const SCATTER: [f64; 2] = [0.1, 0.6];
const BEGIN: [f64; 2] = [1.0, 0.7];
/// What comes from elsewhere in the beginning, grey.
const GROUND: f64 = 10.0;
/// By so much constants are changed to see what that does, each in its unit, and depths.
const SLOPE_STEPS: [f64; 4] = [1.0, 0.1, 0.001, 0.01];
/// The picture at rest is looked at in one pixel of so many.
const REST_EVERY: usize = 97;
/// So many captures tell from each other how sure the constants are.
const LEAST_CAPTURES: usize = 3;

/// How pictures show the pad.
#[derive(Clone, Copy, Debug)]
pub enum Outline<'a> {
    /// Through a camera at its place.
    Camera(&'a Viewpoint),
    /// Made straight, of so many mm to a pixel, their middle on the pad's; from as far as the drawn camera.
    Straight(f64),
}

/// Whether light is fitted to balls rather than pins: on flat gels.
pub fn is_pad(sensor: &Sensor) -> bool {
    matches!(sensor.touch, Some(TouchSurface::Plane(_)))
}

/// What is fitted from.
#[derive(Clone, Copy, Debug)]
pub struct FittingPads<'a> {
    /// The sensor as drawn.
    pub project: &'a Arc<Project>,
    /// How its pictures show it.
    pub outline: Outline<'a>,
    /// The picture without contact.
    pub reference: &'a Path,
    /// Pictures of one ball each.
    pub captures: &'a [PathBuf],
    /// The ball's radius, mm.
    pub ball_radius_mm: f64,
}

/// What a profile looks like: dark where the ball is, bright around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// How dark the middle is, grey.
    pub middle_grey: f64,
    /// How far out it is as bright as at rest, mm; nothing where it nowhere is.
    pub edge_mm: Option<f64>,
    /// How much brighter than at rest the brightest place beyond that is, grey.
    pub ring_grey: f64,
    /// How far out that place is, mm.
    pub ring_mm: f64,
}

impl Shape {
    /// Of means by bins of so many mm.
    fn of(darker: &[f64], bin_mm: f64) -> Self {
        let at = |bin: f64| (bin + 0.5) * bin_mm;
        let crossing = darker.windows(2).position(|pair| pair[0] > 0.0 && pair[1] <= 0.0);
        let edge = crossing.map(|k| k as f64 + darker[k] / (darker[k] - darker[k + 1]));
        let beyond = crossing.map_or(darker.len() - 1, |k| k + 1);
        let brightest = (beyond..darker.len()).min_by(|a, b| darker[*a].total_cmp(&darker[*b]));
        let brightest = brightest.unwrap_or(beyond);
        let (mut ring_grey, mut place) = (-darker[brightest], brightest as f64);
        if brightest > 0 && brightest + 1 < darker.len() {
            // A parabola through three bins.
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

/// A ball, as it is and as predicted.
#[derive(Clone, Debug, PartialEq)]
pub struct Ball {
    /// Its picture.
    pub file: PathBuf,
    /// Its middle, sensor frame, mm.
    pub at_mm: [f64; 2],
    /// How deep it went that explains its picture best, mm.
    pub depth_mm: f64,
    /// Whether that is the least or the most that is tried.
    pub is_at_limit: bool,
    /// How much brighter its picture is as a whole than the one at rest, grey.
    pub brighter_grey: f64,
    /// Grey by which it is darker than at rest, by distance: real, by the constants of all captures, and by those of the others.
    pub profile_grey: Vec<[f64; 3]>,
    /// The real profile's.
    pub real: Shape,
    /// The predicted one's: held out where there are others.
    pub predicted: Shape,
    /// What is left where it is dark, rms over bins, grey.
    pub dark_rms_grey: f64,
}

/// Constants that explain captures of balls.
#[derive(Clone, Debug)]
pub struct FittedPads {
    /// What an endless layer sends back, what comes from elsewhere, grey; scatter, 1/mm.
    pub values: [f64; 3],
    /// Standard deviations: from leaving out each capture in turn, where there are three or more, and no less than what is left
    /// says if it were independent.
    pub sigmas: [f64; 3],
    /// How bright the first of a layer is, layer_grey times scatter, grey/mm, and its standard deviation: of a thin layer this is
    /// known better than either.
    pub layer_grey_per_mm: [f64; 2],
    /// What is held, mm.
    pub spread_mm: f64,
    /// Width of a profile's bins, mm.
    pub bin_mm: f64,
    /// The captures, in order.
    pub balls: Vec<Ball>,
    /// Over all profiles, grey: by the constants of all.
    pub profile_rms_grey: f64,
    /// The same by those of the others; nothing where there is one capture alone.
    pub held_out_profile_rms_grey: Option<f64>,
    /// What is left of the picture at rest over the pad, grey, rms.
    pub reference_rms_grey: f64,
}

impl FittingPads<'_> {
    /// Fits, and predicts each capture from the others.
    ///
    /// # Errors
    /// Pictures that cannot be read or show no ball, a sensor whose light shows no thickness, layers that cannot be pressed.
    pub fn run(&self) -> Result<FittedPads, Error> {
        let sensor = &self.project.design.sensor;
        let lighting = crate::lighting(sensor, None)?;
        let constants = LightConstants::of(sensor);
        let layers = LayerScene::of(sensor, lighting, &constants)?;
        let reference = Taken::read(self.reference)?;
        let view = self.view(&layers, reference.size_px)?;
        check_size(self.reference, &reference, view.size_px())?;
        let reference = reference.grey();
        let (mut profiles, mut wrong) = (Vec::new(), Vec::new());
        for file in self.captures {
            let read = || {
                let picture = Taken::read(file)?;
                check_size(file, &picture, view.size_px())?;
                Profile::of(&view, file, [&reference, &picture.grey()], self.ball_radius_mm)
            };
            match read() {
                Ok(profile) => profiles.push(profile),
                Err(error) => wrong.push(error),
            }
        }
        if let Some(error) = Error::all(wrong) {
            return Err(error);
        }
        let raster = balls::raster(self.ball_radius_mm, view.seen_from_mm());
        let model = Model::new(sensor, &layers, self.ball_radius_mm, raster)?;
        let lit_at = |[x, y]: [f64; 2]| layers.scene.lit.at(&Point3::new(x, y, model.middle.z));
        let lit: Vec<f64> = profiles.iter().map(|profile| lit_at(profile.at_mm)).collect();
        let spread_mm = constants.spread_mm.value;
        let fitting = Fit { profiles: &profiles, lit: &lit, model: &model, spread_mm };
        let all: Vec<usize> = (0..profiles.len()).collect();
        let values = fitting.solve(&all).ok_or(FitLightError::NoFit)?;
        let mut fitted = fitting.report(self.captures, &values)?;
        fitted.reference_rms_grey = rms(view.seen().step_by(REST_EVERY).map(|(i, pixel)| {
            let sent = lit_at(pixel.at_mm) * fitting.sent(fitted.values, pixel.slant);
            balls::WHITE * f64::from(reference[i]) - sent
        }));
        Ok(fitted)
    }

    fn view(&self, layers: &LayerScene<'_>, size_px: [usize; 2]) -> Result<PadView, Error> {
        let drawn = || Viewpoint::new(&self.project.design.sensor.camera, None, None);
        let viewpoint = match self.outline {
            Outline::Camera(viewpoint) => viewpoint.clone(),
            Outline::Straight(_) => drawn().map_err(Error::bug)?,
        };
        let view =
            PadView::through(&SensorView::new(Arc::clone(self.project), viewpoint)?, layers)?;
        Ok(match self.outline {
            Outline::Camera(_) => view,
            Outline::Straight(mm) => {
                let points = SurfacePoints::new(layers.scene.touch).map_err(Error::bug)?;
                view.straight(&points, size_px, mm)
            }
        })
    }
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (squares, count) = values.fold((0.0, 0.0), |(sum, count), x| (sum + x * x, count + 1.0));
    f64::sqrt(squares / f64::max(count, 1.0))
}

/// The pad as a ball goes deeper: pressed in its middle, which others are taken to be like.
struct Model {
    raster: Raster,
    depths_mm: Vec<f64>,
    patches: Vec<Patch>,
    middle: Point3<f64>,
    /// How much light there is, and how thick the layers are, mm.
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
        let (middle, outward) = middle_of(scene.touch).ok_or_else(no_pad)?;
        let thick = |place: &Point3<f64>, outward: &Vector3<f64>| {
            scene.thickness_mm((place, outward), &mut Scratch::default(), &mut Vec::new())
        };
        let thick_mm = thick(&middle, &outward).ok_or_else(no_pad)?;
        // Straight through: a ray that is slanted sees all of it longer.
        let paths_mm = |rest: &Point3<f64>, outward: &Vector3<f64>, gains_mm: f64| {
            let thick_mm = thick(rest, outward).unwrap_or(0.0);
            [thick_mm, (thick_mm + gains_mm).max(0.0)]
        };
        let spacing_mm = SPACING_MM.max(ball_radius_mm / NODES_TO_RADIUS);
        let ready = Ready::for_all(sensor, Some(spacing_mm), false, threads())?;
        let most_mm = (DEPTHS[1] * scene.touch.soft_mm()).min(MOST_OF_RADIUS * ball_radius_mm);
        let least_mm = DEPTHS[0] * scene.touch.soft_mm();
        let depth_mm = |k: usize| least_mm + (most_mm - least_mm) * k as f64 / (STEPS - 1) as f64;
        let depths_mm: Vec<f64> = (0..STEPS).map(depth_mm).collect();
        let press = |depth_mm: &f64| {
            let tip = [ball_radius_mm, *depth_mm];
            Patch::pressed(scene, &ready, &middle, tip, raster, paths_mm)
        };
        let patches = depths_mm.par_iter().map(press).collect::<Result<_, _>>()?;
        Ok(Self { raster, depths_mm, patches, middle, lit: scene.lit.at(&middle), thick_mm })
    }
}

/// Profiles, and what the solver says of the same.
struct Fit<'a> {
    profiles: &'a [Profile],
    /// How much light there is at each.
    lit: &'a [f64],
    model: &'a Model,
    spread_mm: f64,
}

impl Fit<'_> {
    /// By how much it is darker in a capture, by distance, for these constants and this depth.
    fn darker(&self, capture: usize, constants: [f64; 3], depth_mm: f64) -> Vec<f64> {
        let [layer_grey, _, scatter_per_mm] = constants;
        let (profile, depths) = (&self.profiles[capture], &self.model.depths_mm);
        let step_mm = depths[1] - depths[0];
        let at = ((depth_mm - depths[0]) / step_mm).clamp(0.0, (depths.len() - 1) as f64);
        let from = (at as usize).min(depths.len() - 2);
        let law = TwoStream { scatter_per_mm: scatter_per_mm * profile.slant };
        // Patches are lit as the pad's middle is.
        let layer_grey = layer_grey * self.lit[capture] / self.model.lit;
        let [near, far] =
            [from, from + 1].map(|k| self.model.patches[k].darker(layer_grey, law, self.spread_mm));
        let part = at - from as f64;
        near.iter().zip(far).map(|(near, far)| near + part * (far - near)).collect()
    }

    /// Real less simulated of some captures, for three constants and a depth for each: profiles, and the middle at rest; then
    /// how usual the scatter is.
    fn residuals(&self, captures: &[usize], values: &[f64]) -> Vec<f64> {
        let constants = [values[0], values[1], values[2]];
        let mut left = Vec::new();
        for (capture, depth_mm) in captures.iter().zip(&values[3..]) {
            let (profile, lit) = (&self.profiles[*capture], self.lit[*capture]);
            let simulated = self.darker(*capture, constants, *depth_mm);
            left.extend(profile.darker.iter().zip(simulated).map(|(real, now)| real - now));
            left.push(profile.rest_grey - lit * self.sent(constants, profile.slant));
        }
        left.push(BIN_GREY * (values[2] / SCATTER_PER_MM).ln() / SCATTER_LOG);
        left
    }

    /// What comes back at rest where light is as on average, grey.
    fn sent(&self, [layer_grey, ground_grey, scatter_per_mm]: [f64; 3], slant: f64) -> f64 {
        let law = TwoStream { scatter_per_mm };
        ground_grey + layer_grey * law.reflectance(slant * self.model.thick_mm)
    }

    fn cost(&self, captures: &[usize], values: &[f64]) -> f64 {
        self.residuals(captures, values).iter().map(|left| left * left).sum()
    }

    /// Three constants, and a depth for each of some captures.
    fn solve(&self, captures: &[usize]) -> Option<Vec<f64>> {
        let begin = SCATTER.iter().flat_map(|scatter| BEGIN.map(|part| (*scatter, part)));
        let from = |(scatter, part): (f64, f64)| {
            let mut start = vec![120.0 / scatter, GROUND, scatter];
            start.extend(captures.iter().map(|capture| part * self.by_edge_mm(*capture)));
            fit(|values| self.residuals(captures, values), &start)
        };
        let cost = |values: &Vec<f64>| self.cost(captures, values);
        begin.filter_map(from).min_by(|a, b| cost(a).total_cmp(&cost(b)))
    }

    /// The depth whose contact is as wide as the real one, mm.
    fn by_edge_mm(&self, capture: usize) -> f64 {
        let (bin_mm, depths) = (self.model.raster.bin_mm, &self.model.depths_mm);
        let edge = |darker: &[f64]| Shape::of(darker, bin_mm).edge_mm;
        let Some(real) = edge(&self.profiles[capture].darker) else {
            return depths[depths.len() / 2];
        };
        let off = |depth_mm: &f64| {
            let simulated = self.darker(capture, [1.0, GROUND, SCATTER_PER_MM], *depth_mm);
            edge(&simulated).map_or(f64::INFINITY, |mm| (mm - real).abs())
        };
        depths.iter().copied().min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or_default()
    }

    /// How deep the ball of a capture went, for these constants.
    fn depth_mm(&self, capture: usize, constants: [f64; 3]) -> f64 {
        let cost = |depth_mm: f64| {
            let simulated = self.darker(capture, constants, depth_mm);
            let real = &self.profiles[capture].darker;
            real.iter().zip(simulated).map(|(real, now)| (real - now).powi(2)).sum::<f64>()
        };
        let residuals = |values: &[f64]| {
            let simulated = self.darker(capture, constants, values[0]);
            self.profiles[capture]
                .darker
                .iter()
                .zip(simulated)
                .map(|(real, now)| real - now)
                .collect()
        };
        let nearest = self.model.depths_mm.iter().copied();
        let start = nearest.min_by(|a, b| cost(*a).total_cmp(&cost(*b))).unwrap_or_default();
        fit(residuals, &[start]).map_or(start, |found| found[0])
    }

    /// What these values, of all captures, explain, and each capture by what the others say; `reference_rms_grey` is left to
    /// who knows the picture at rest.
    fn report(&self, files: &[PathBuf], values: &[f64]) -> Result<FittedPads, Error> {
        let all: Vec<usize> = (0..self.profiles.len()).collect();
        let constants = [values[0], values[1], values[2]];
        let without = |capture: &usize| {
            let others: Vec<usize> = all.iter().copied().filter(|k| k != capture).collect();
            // From where all captures have led: without one of them it is not far.
            let mut start = constants.to_vec();
            start.extend(others.iter().map(|other| values[3 + other]));
            fit(|values| self.residuals(&others, values), &start).ok_or(FitLightError::NoFit)
        };
        let held_out = if all.len() > 1 {
            all.par_iter().map(without).collect::<Result<Vec<_>, _>>()?
        } else {
            Vec::new()
        };
        let bin_mm = self.model.raster.bin_mm;
        let depths = &self.model.depths_mm;
        let [least_mm, most_mm] = [depths[0], depths[depths.len() - 1]];
        let balls: Vec<Ball> = all
            .par_iter()
            .map(|capture| {
                let profile = &self.profiles[*capture];
                let own = self.darker(*capture, constants, values[3 + capture]);
                let predicted = held_out.get(*capture).map_or_else(
                    || own.clone(),
                    |others| {
                        let others = [others[0], others[1], others[2]];
                        self.darker(*capture, others, self.depth_mm(*capture, others))
                    },
                );
                let real = Shape::of(&profile.darker, bin_mm);
                let dark = real.edge_mm.map_or(own.len(), |mm| (mm / bin_mm) as usize);
                let left = profile.darker.iter().zip(&predicted).map(|(real, now)| real - now);
                let rows = profile.darker.iter().zip(&own).zip(&predicted);
                Ball {
                    file: files[*capture].clone(),
                    at_mm: profile.at_mm,
                    depth_mm: values[3 + capture].clamp(least_mm, most_mm),
                    is_at_limit: !(least_mm..most_mm).contains(&values[3 + capture]),
                    brighter_grey: profile.brighter_grey,
                    dark_rms_grey: rms(left.take(dark)),
                    profile_grey: rows.map(|((real, own), now)| [*real, *own, *now]).collect(),
                    predicted: Shape::of(&predicted[..profile.darker.len()], bin_mm),
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
        let mut sigmas = least_sigmas(|values| self.residuals(&all, values), values, &steps);
        // The same by what the first of a layer sends back, grey/mm, instead of what an endless one does.
        let mut by_first = values.to_vec();
        by_first[0] *= values[2];
        let residuals = |by_first: &[f64]| {
            let mut values = by_first.to_vec();
            values[0] /= by_first[2];
            self.residuals(&all, &values)
        };
        let mut first_sigma = least_sigmas(residuals, &by_first, &steps)[0];
        if all.len() >= LEAST_CAPTURES {
            let each =
                |values: &Vec<f64>| vec![values[0], values[1], values[2], values[0] * values[2]];
            let out = jackknife(&held_out.iter().map(each).collect::<Vec<_>>());
            sigmas.iter_mut().zip(&out).for_each(|(sigma, out)| *sigma = sigma.max(*out));
            first_sigma = first_sigma.max(out[3]);
        }
        Ok(FittedPads {
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
