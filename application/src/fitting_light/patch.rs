//! The layer around a pin, as the elastic solver has it: what a simulated profile is made from.

use fabkit_depth::truth::Yielding;
use fabkit_fixtures::PressBody;
use fabkit_geometry::{Point3, Pose, Solid, TouchSurface};
use fabkit_light::TwoStream;

use super::profiles::{BIN_MM, BINS, tangents};
use crate::Error;
use crate::capturing::Scene;
use crate::pressing::Ready;

/// Distance of the places on the patch, mm, and how many there are from its middle to its side.
const STEP_MM: f64 = 0.1;
const HALF: usize = 32;
const SIDE: usize = 2 * HALF + 1;
/// How far out a pin reaches, mm.
const PIN_MM: f64 = 8.0;
/// Light spreads at most this many places to either side.
const MOST_SPREAD: usize = 12;

/// A square of places around a pin.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    /// How much light there is.
    lit: f64,
    /// Along the camera's path, at rest and pressed, mm; row after row.
    paths_mm: Vec<[f64; 2]>,
}

impl Patch {
    /// Presses a pin with a round tip in along the normal at a place of the surface.
    pub(super) fn pressed(
        scene: &Scene<'_>,
        ready: &Ready,
        surface: &Point3<f64>,
        [radius_mm, depth_mm]: [f64; 2],
    ) -> Result<Self, Error> {
        let touch: &TouchSurface = scene.touch;
        let (_, outward) = touch.depth_mm(surface);
        let tip = surface + (radius_mm - depth_mm) * outward;
        let pin = PressBody {
            name: "pin".to_owned(),
            solid: Solid::union([Solid::sphere(radius_mm), Solid::cylinder(radius_mm, PIN_MM)]),
            sensor_from_body: Pose::z_to(outward, tip),
        };
        let answer = ready.answer(touch, &[pin], [0.0; 2], None)?;
        let lower = answer.lower_face(scene.innermost());
        let [right, up] = tangents(&outward);
        let paths = (0..SIDE * SIDE).map(|i| {
            let [u, v] = [i % SIDE, i / SIDE].map(|k| (k as f64 - HALF as f64) * STEP_MM);
            let beside = surface + u * right + v * up;
            let (depth_mm, outward) = touch.depth_mm(&beside);
            let rest = beside + depth_mm * outward;
            let lower_mm = lower.as_ref().map_or(0.0, |lower| lower.outwards_mm(&rest));
            let gains_mm = answer.outwards_mm(&rest, &outward) - lower_mm;
            scene.paths_mm(&rest, &outward, gains_mm)
        });
        Ok(Self { lit: scene.lit.at(surface), paths_mm: paths.collect() })
    }

    /// By how much it is darker than at rest, by the distance from its middle, for what an endless layer would send back,
    /// a layer's law, and how far light spreads in it, mm.
    pub(super) fn darker(&self, layer_grey: f64, law: TwoStream, spread_mm: f64) -> [f64; BINS] {
        let darker = |[rest, now]: &[f64; 2]| law.reflectance(*rest) - law.reflectance(*now);
        let raw: Vec<f64> = self.paths_mm.iter().map(darker).collect();
        let weights: Vec<f64> = (0..=MOST_SPREAD)
            .map(|k| (-0.5 * (k as f64 * STEP_MM / spread_mm.max(1e-3)).powi(2)).exp())
            .collect();
        let all = 2.0 * weights[1..].iter().sum::<f64>() + weights[0];
        let spread = |from: &[f64], stride: usize, along: &dyn Fn(usize) -> usize| -> Vec<f64> {
            (0..SIDE * SIDE)
                .map(|i| {
                    let at = along(i) as isize;
                    let place = |k: isize| {
                        let inside = (at + k).clamp(0, SIDE as isize - 1) - at;
                        from[(i as isize + inside * stride as isize) as usize]
                    };
                    let beside = (1..=MOST_SPREAD as isize)
                        .map(|k| weights[k as usize] * (place(k) + place(-k)));
                    (weights[0] * place(0) + beside.sum::<f64>()) / all
                })
                .collect()
        };
        let rows = spread(&raw, 1, &|i| i % SIDE);
        let both = spread(&rows, SIDE, &|i| i / SIDE);
        let (mut sums, mut counts) = ([0.0; BINS], [0.0; BINS]);
        for (i, value) in both.iter().enumerate() {
            let [u, v] = [i % SIDE, i / SIDE].map(|k| (k as f64 - HALF as f64) * STEP_MM);
            let bin = (u.hypot(v) / BIN_MM) as usize;
            if bin < BINS {
                sums[bin] += value;
                counts[bin] += 1.0;
            }
        }
        std::array::from_fn(|bin| self.lit * layer_grey * sums[bin] / counts[bin])
    }
}
