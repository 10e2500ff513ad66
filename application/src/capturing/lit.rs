//! How much light arrives at each place of a layer, at rest.

use std::f64::consts::TAU;

use fabkit_geometry::{Point3, SurfacePoints, Vector3};
use fabkit_light::Emitters;

/// Steps of the table along a dome's meridian or a pad's x, and around or along y.
const STEPS: [usize; 2] = [16, 32];

/// A table over the sensing surface: between its places in proportion.
#[derive(Debug)]
pub(crate) struct Lit {
    plan: Plan,
    /// Row after row; 1 on average over the surface.
    values: Vec<f64>,
}

#[derive(Debug)]
enum Plan {
    Dome { centre: Point3<f64>, last_rad: f64 },
    Pad { bounds_mm: [[f64; 2]; 2] },
}

impl Lit {
    /// Light that arrives straight, and `bounce` of its average everywhere; the places are `below_mm` below the surface
    /// and look inwards. Nothing where no light arrives at all.
    pub(super) fn new(
        points: &SurfacePoints,
        emitters: &Emitters,
        below_mm: impl Fn(&Point3<f64>, &Vector3<f64>) -> f64,
        bounce: f64,
    ) -> Option<Self> {
        let [rows, columns] = STEPS;
        let plan = match points {
            SurfacePoints::Dome(dome) => {
                Plan::Dome { centre: dome.centre(), last_rad: dome.last_polar_rad() }
            }
            SurfacePoints::Plane(pad) => Plan::Pad { bounds_mm: pad.bounds_mm() },
        };
        let mut places = Vec::new();
        let mut weights = Vec::new();
        for row in 0..=rows {
            let along = row as f64 / rows as f64;
            for column in 0..columns {
                let place = match (points, &plan) {
                    (SurfacePoints::Dome(dome), Plan::Dome { last_rad, .. }) => {
                        weights.push((along * last_rad).sin());
                        // The foot itself belongs to the wall below.
                        let polar = along.min(1.0 - 1e-9) * last_rad;
                        dome.towards(polar, TAU * column as f64 / columns as f64)
                    }
                    (SurfacePoints::Plane(pad), Plan::Pad { bounds_mm: [x, y] }) => {
                        weights.push(1.0);
                        // A hair within the outline.
                        let part = |[from, to]: &[f64; 2], share: f64| {
                            from + (to - from) * share.clamp(1e-6, 1.0 - 1e-6)
                        };
                        pad.at([part(x, along), part(y, column as f64 / (columns - 1) as f64)])
                    }
                    _ => None,
                };
                places.push(place);
            }
        }
        let known: Vec<(Point3<f64>, Vector3<f64>)> = places
            .iter()
            .flatten()
            .map(|(point, outward)| (point - below_mm(point, outward) * outward, -outward))
            .collect();
        let mut arrives = emitters.irradiance(&known).into_iter();
        // Beyond a pad's rounded corners nothing is looked at.
        let mut values: Vec<f64> =
            places.iter().map(|place| place.and_then(|_| arrives.next()).unwrap_or(0.0)).collect();
        let weighted = |(value, weight): (&f64, &f64)| value * weight;
        let on = places.iter().zip(&weights).filter(|(place, _)| place.is_some());
        let mean = values.iter().zip(&weights).map(weighted).sum::<f64>()
            / on.map(|(_, weight)| weight).sum::<f64>();
        if mean.is_nan() || mean <= 0.0 {
            return None;
        }
        values.iter_mut().for_each(|value| *value = (*value / mean + bounce) / (1.0 + bounce));
        Some(Self { plan, values })
    }

    /// At a point of the surface at rest.
    pub(crate) fn at(&self, point: &Point3<f64>) -> f64 {
        let [rows, columns] = STEPS;
        let (row, column, is_round) = match &self.plan {
            Plan::Dome { centre, last_rad } => {
                let out = point - centre;
                let polar = out.x.hypot(out.y).atan2(out.z);
                let around = out.y.atan2(out.x).rem_euclid(TAU) / TAU;
                (polar / last_rad * rows as f64, around * columns as f64, true)
            }
            Plan::Pad { bounds_mm: [x, y] } => {
                let share = |[from, to]: &[f64; 2], mm: f64| (mm - from) / (to - from);
                (share(x, point.x) * rows as f64, share(y, point.y) * (columns - 1) as f64, false)
            }
        };
        let last = if is_round { columns } else { columns - 1 };
        let row = row.clamp(0.0, rows as f64 - 1e-9);
        let column = column.clamp(0.0, last as f64 - 1e-9);
        let (i, j) = (row as usize, column as usize);
        let (by_row, by_column) = (row - i as f64, column - j as f64);
        let value = |i: usize, j: usize| self.values[i * columns + j % columns];
        (1.0 - by_row) * ((1.0 - by_column) * value(i, j) + by_column * value(i, j + 1))
            + by_row * ((1.0 - by_column) * value(i + 1, j) + by_column * value(i + 1, j + 1))
    }
}
