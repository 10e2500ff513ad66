//! Interpolation table over the undeformed sensing surface.

use std::f64::consts::TAU;

use fabkit_geometry::{Point3, SurfacePoints, Vector3};

/// Steps of the table: along a dome's meridian or a pad's x, and around the axis or along y.
const STEPS: [usize; 2] = [16, 32];

/// A point of the surface with its outward normal.
pub(super) type SurfacePlace = (Point3<f64>, Vector3<f64>);

/// Grid of the table on a dome or a pad.
#[derive(Clone, Copy, Debug)]
pub(super) enum SurfaceGrid {
    Dome { centre: Point3<f64>, last_rad: f64 },
    Pad { bounds_mm: [[f64; 2]; 2] },
}

/// Indices and weights of the four neighbouring places.
pub(super) type BilinearWeights = [(usize, f64); 4];

impl SurfaceGrid {
    pub(super) fn new(points: &SurfacePoints) -> Self {
        match points {
            SurfacePoints::Dome(dome) => {
                Self::Dome { centre: dome.centre(), last_rad: dome.max_polar_rad() }
            }
            SurfacePoints::Plane(pad) => Self::Pad { bounds_mm: pad.bounds_mm() },
        }
    }

    /// Returns the places in order, each with its weight in area averages; `None` beyond a pad's rounded corners.
    pub(super) fn places(&self, points: &SurfacePoints) -> Vec<(Option<SurfacePlace>, f64)> {
        let [rows, columns] = STEPS;
        let each = (0..=rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
        let place = |(row, column): (usize, usize)| {
            let along = row as f64 / rows as f64;
            match (points, self) {
                (SurfacePoints::Dome(dome), Self::Dome { last_rad, .. }) => {
                    // The foot itself already belongs to the wall below.
                    let polar = along.min(1.0 - 1e-9) * last_rad;
                    let place =
                        dome.point_in_direction(polar, TAU * column as f64 / columns as f64);
                    (place, (along * last_rad).sin())
                }
                (SurfacePoints::Plane(pad), Self::Pad { bounds_mm: [x, y] }) => {
                    // Slightly inside the outline, where the pad's surface is defined.
                    let part = |[from, to]: &[f64; 2], share: f64| {
                        from + (to - from) * share.clamp(1e-6, 1.0 - 1e-6)
                    };
                    let across = column as f64 / (columns - 1) as f64;
                    (pad.at([part(x, along), part(y, across)]), 1.0)
                }
                _ => (None, 0.0),
            }
        };
        each.map(place).collect()
    }

    /// Returns a predicate on indices of places: whether one lies within the last quarter of a dome's meridian, where
    /// light sources and housings are.
    pub(super) fn is_near_foot(&self) -> impl Fn(usize) -> bool + use<> {
        let [rows, columns] = STEPS;
        let is_dome = matches!(self, Self::Dome { .. });
        move |i| is_dome && 4 * (i / columns) > 3 * rows
    }

    /// Returns the four places around a point of the undeformed surface, with bilinear weights.
    #[inline]
    pub(super) fn weights_at(&self, point: &Point3<f64>) -> BilinearWeights {
        let [rows, columns] = STEPS;
        let (row, column, last) = match self {
            Self::Dome { centre, last_rad } => {
                let out = point - centre;
                let polar = out.x.hypot(out.y).atan2(out.z);
                let around = out.y.atan2(out.x).rem_euclid(TAU) / TAU;
                (polar / last_rad * rows as f64, around * columns as f64, columns)
            }
            Self::Pad { bounds_mm: [x, y] } => {
                let share = |[from, to]: &[f64; 2], mm: f64| (mm - from) / (to - from);
                let across = share(y, point.y) * (columns - 1) as f64;
                (share(x, point.x) * rows as f64, across, columns - 1)
            }
        };
        let row = row.clamp(0.0, rows as f64 - 1e-9);
        // Just below the last index, so that the upper neighbour exists.
        let column = column.clamp(0.0, last as f64 - 1e-9);
        let (i, j) = (row as usize, column as usize);
        let (by_row, by_column) = (row - i as f64, column - j as f64);
        // On a dome the last column's neighbour is the first one.
        let at = |i: usize, j: usize| i * columns + j % columns;
        [
            (at(i, j), (1.0 - by_row) * (1.0 - by_column)),
            (at(i, j + 1), (1.0 - by_row) * by_column),
            (at(i + 1, j), by_row * (1.0 - by_column)),
            (at(i + 1, j + 1), by_row * by_column),
        ]
    }
}
