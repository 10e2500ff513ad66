//! Simulated intensity profiles around a pin or a ball, from the elastic solver.

use fabkit_depth::ground_truth::SurfaceDisplacement;
use fabkit_files::Error;
use fabkit_fixtures::PressBody;
use fabkit_geometry::{Point3, Pose, Solid, TouchSurface, Vector3};
use fabkit_light::TwoStream;
use fabkit_scene::press_simulation::ElasticSolver;

use super::profiles::tangents;
use crate::LayerGeometry;

/// Length of the pin's shaft, mm.
const PIN_MM: f64 = 8.0;
/// Largest reach of the spread of light to either side, in places.
const MOST_SPREAD: usize = 12;

/// Grid of places of a patch, and bins of its profile.
#[derive(Clone, Copy, Debug)]
pub(super) struct Raster {
    /// Distance of places, mm.
    pub step_mm: f64,
    /// Number of places from the middle to a side.
    pub half: usize,
    /// Width of a bin, mm, and number of bins.
    pub bin_mm: f64,
    pub bins: usize,
    /// Inverse of the distance from which rays seem to come, 1/mm. Places that are pressed in are closer to it and look
    /// larger by this factor per millimetre. 0 leaves the effect out.
    pub nearer_per_mm: f64,
}

impl Raster {
    /// Returns the number of places along a side.
    fn side(self) -> usize {
        2 * self.half + 1
    }

    /// Returns the offset of a place from the middle, mm.
    fn place_mm(self, i: usize) -> [f64; 2] {
        [i % self.side(), i / self.side()].map(|k| (k as f64 - self.half as f64) * self.step_mm)
    }
}

/// Square of simulated places around an indenter.
#[derive(Clone, Debug)]
pub(super) struct SimulatedPatch {
    raster: Raster,
    /// Relative irradiance.
    lit: f64,
    /// Length of the camera's path in the layer, at rest and pressed, mm; row by row.
    paths_mm: Vec<[f64; 2]>,
    /// Bin of each place, by its apparent distance from the middle; beyond the last bin there are more numbers.
    bin_of_place: Vec<usize>,
}

impl SimulatedPatch {
    /// Presses a pin with a round tip along the normal into a place of the surface. `paths_mm` returns the length of
    /// the camera's path at a place with this normal, at rest and where the layer has become thicker by the given
    /// amount.
    pub(super) fn simulate(
        scene: &LayerGeometry<'_>,
        ready: &ElasticSolver,
        surface: &Point3<f64>,
        [radius_mm, depth_mm]: [f64; 2],
        raster: Raster,
        paths_mm: impl Fn(&Point3<f64>, &Vector3<f64>, f64) -> [f64; 2],
    ) -> Result<Self, Error> {
        let touch: &TouchSurface = scene.touch;
        let (_, outward) = touch.depth_mm(surface);
        let tip = surface + (radius_mm - depth_mm) * outward;
        let pin = PressBody {
            name: "pin".to_owned(),
            solid: Solid::union([Solid::sphere(radius_mm), Solid::cylinder(radius_mm, PIN_MM)]),
            sensor_from_body: Pose::z_to(outward, tip),
        };
        let answer = ready.solve_contact(touch, &[pin], [0.0; 2], None)?;
        let lower = answer.lower_face(scene.innermost());
        let [right, up] = tangents(&outward);
        let side = raster.side();
        let paths = (0..side * side).map(|i| {
            let [u, v] = raster.place_mm(i);
            let beside = surface + u * right + v * up;
            let (depth_mm, outward) = touch.depth_mm(&beside);
            let rest = beside + depth_mm * outward;
            let lower_mm = lower.as_ref().map_or(0.0, |lower| lower.outwards_mm(&rest));
            let outwards_mm = answer.outwards_mm(&rest, &outward);
            // A place that is pressed in (negative outwards displacement) is closer to the rays' origin and looks
            // larger.
            let larger = 1.0 - outwards_mm * raster.nearer_per_mm;
            (paths_mm(&rest, &outward, outwards_mm - lower_mm), larger)
        });
        let (paths_mm, larger): (Vec<_>, Vec<f64>) = paths.unzip();
        let bin = |(i, larger): (usize, f64)| {
            let [u, v] = raster.place_mm(i);
            (larger * u.hypot(v) / raster.bin_mm) as usize
        };
        let bin_of_place = larger.into_iter().enumerate().map(bin).collect();
        Ok(Self { raster, lit: scene.lit.irradiance(surface), paths_mm, bin_of_place })
    }

    /// Returns the loss of intensity against rest by distance from the middle, for the intensity of an infinitely thick
    /// layer, a law of reflectance and the lateral spread of light, mm.
    pub(super) fn intensity_loss(
        &self,
        layer_grey: f64,
        law: TwoStream,
        spread_mm: f64,
    ) -> Vec<f64> {
        let Raster { step_mm, bins, .. } = self.raster;
        let side = self.raster.side();
        let darker = |[rest, now]: &[f64; 2]| law.reflectance(*rest) - law.reflectance(*now);
        let raw: Vec<f64> = self.paths_mm.iter().map(darker).collect();
        let weights: Vec<f64> = (0..=MOST_SPREAD)
            .map(|k| (-0.5 * (k as f64 * step_mm / spread_mm.max(1e-3)).powi(2)).exp())
            .collect();
        // The sum of the truncated kernel normalises it.
        let all = 2.0 * weights[1..].iter().sum::<f64>() + weights[0];
        // The Gaussian is separable: rows are filtered first, then columns.
        let blur = Blur { side, weights: &weights, all };
        let both = blur.along_columns(&blur.along_rows(&raw));
        let (mut sums, mut counts) = (vec![0.0; bins], vec![0.0; bins]);
        for (value, bin) in both.iter().zip(&self.bin_of_place) {
            if *bin < bins {
                sums[*bin] += value;
                counts[*bin] += 1.0;
            }
        }
        (0..bins).map(|bin| self.lit * layer_grey * sums[bin] / counts[bin]).collect()
    }
}

/// Symmetric filter of a square of places along one direction. Beyond the border, the last place is repeated.
struct Blur<'a> {
    side: usize,
    /// Weight of the place itself, and of those to either side of it by distance.
    weights: &'a [f64],
    /// Sum of all weights.
    all: f64,
}

impl Blur<'_> {
    /// Filters along rows.
    fn along_rows(&self, from: &[f64]) -> Vec<f64> {
        let reach = self.weights.len() - 1;
        let mut padded = vec![0.0; self.side + 2 * reach];
        let mut to = Vec::with_capacity(from.len());
        for row in from.chunks_exact(self.side) {
            padded[..reach].fill(row[0]);
            padded[reach..reach + self.side].copy_from_slice(row);
            padded[reach + self.side..].fill(row[self.side - 1]);
            let shifted = |by: usize| &padded[by..by + self.side];
            self.push_sums(&mut to, |k| [shifted(reach + k), shifted(reach - k)]);
        }
        to
    }

    /// Filters along columns.
    fn along_columns(&self, from: &[f64]) -> Vec<f64> {
        let mut to = Vec::with_capacity(from.len());
        for row in 0..self.side {
            let at = |row: usize| &from[row * self.side..][..self.side];
            let last = self.side - 1;
            self.push_sums(&mut to, |k| [at((row + k).min(last)), at(row.saturating_sub(k))]);
        }
        to
    }

    /// Appends one filtered row, given the rows at a distance to either side. Whole rows are added at a time, so that
    /// the compiler works on several places at once.
    fn push_sums<'r>(&self, to: &mut Vec<f64>, beside: impl Fn(usize) -> [&'r [f64]; 2]) {
        let mut sums = vec![0.0; self.side];
        for (k, weight) in self.weights.iter().enumerate().skip(1) {
            let [after, before] = beside(k);
            for ((sum, after), before) in sums.iter_mut().zip(after).zip(before) {
                *sum += weight * (after + before);
            }
        }
        let [middle, _] = beside(0);
        to.extend(middle.iter().zip(sums).map(|(at, sum)| (self.weights[0] * at + sum) / self.all));
    }
}
