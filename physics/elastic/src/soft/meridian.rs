//! Meridian of a dome's layers.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use fabkit_geometry::{DomePoints, Ray};

use super::bodies::{Bodies, SoftColumn};
use crate::BoundaryCondition;

/// Number of steps along the meridian at which the bodies are probed.
pub(super) const STEPS: usize = 240;
/// Number of meridians that are averaged; features that differ between them are not rotationally symmetric.
const MERIDIANS: usize = 36;
/// Differences between meridians below this are rounding, mm.
pub(super) const ROUND_MM: f64 = 1e-6;
/// Half width, in steps, over which dimples, pins and slots are averaged along the meridian.
const SPREAD_STEPS: usize = 16;
/// Fraction of the usual depth of all layers; a shallower column ends at an inclusion.
const SHALLOW: f64 = 0.5;
/// Distance beyond the rim within which something rigid must begin to hold it, mm.
const RIM_MM: f64 = 0.3;

/// Meridian of a dome's layers as a table, averaged around the axis.
pub(super) struct Meridian {
    /// Largest polar angle at which all layers exist, rad.
    pub(super) end_rad: f64,
    /// Depth of each layer's lower face below the surface, mm, by step and layer.
    pub(super) depths_mm: Vec<Vec<f64>>,
    /// True where something rigid follows the last layer, by step.
    pub(super) is_held: Vec<bool>,
    /// The rigid body that follows most often.
    pub(super) held_by: Option<usize>,
    /// Largest variation of each layer's depth around the axis, mm.
    pub(super) uneven_mm: Vec<f64>,
}

/// Finds the sequence of soft bodies, from outside inwards, that lies below most of the surface (not below a pin or a
/// hole), and the median of their total depth, mm.
pub(super) fn find_usual_layers(bodies: &Bodies, face: &DomePoints) -> (Vec<usize>, f64) {
    let mut counted = BTreeMap::<Vec<usize>, Vec<f64>>::new();
    for ring in 0..MERIDIANS {
        // Sampled about evenly by area: longer rings have more points.
        let polar = face.max_polar_rad() * (ring as f64 + 0.5) / MERIDIANS as f64;
        let places = ((polar.sin() * MERIDIANS as f64).ceil() as usize).max(1);
        for place in 0..places {
            // Offset, so that no azimuth falls on an axis.
            let azimuth = (place as f64 + 0.37) * TAU / places as f64;
            if let Some((point, outward)) = face.point_in_direction(polar, azimuth) {
                let soft = bodies.find_soft_below(point, outward).soft;
                let names = soft.iter().map(|stretch| stretch.body).collect();
                counted.entry(names).or_default().extend(soft.last().map(|last| last.end_mm));
            }
        }
    }
    let Some((names, mut depths_mm)) = counted.into_iter().max_by_key(|(_, depths)| depths.len())
    else {
        return (Vec::new(), 0.0);
    };
    depths_mm.sort_by(f64::total_cmp);
    let usual_mm = depths_mm.get(depths_mm.len() / 2).copied().unwrap_or(0.0);
    (names, usual_mm)
}

impl Meridian {
    /// Averages the depths of the layers in `names` around the axis, at each step along the meridian.
    pub(super) fn from_bodies(
        bodies: &Bodies,
        face: &DomePoints,
        names: &[usize],
        usual_mm: f64,
    ) -> Self {
        let column = |polar: f64, azimuth: f64| {
            let (point, outward) = face.point_in_direction(polar, azimuth)?;
            let column = bodies.find_soft_below(point, outward);
            let has_all = column.soft.len() >= names.len()
                && column.soft.iter().zip(names).all(|(stretch, name)| stretch.body == *name);
            // A dot or a pin may stand in the last layer.
            let is_whole = has_all && column.soft[names.len() - 1].end_mm > SHALLOW * usual_mm;
            is_whole.then_some(column)
        };
        let around = |polar: f64| -> Vec<SoftColumn> {
            let azimuths =
                // Offset, so that no meridian falls on an axis.
                (0..MERIDIANS).map(|i| (f64::from(i as u32) + 0.37) * 360.0 / MERIDIANS as f64);
            let mut columns: Vec<SoftColumn> =
                azimuths.filter_map(|deg| column(polar, deg.to_radians())).collect();
            // Columns that end at an inclusion, such as a dot or a pin, are left out.
            let follow = |next| columns.iter().filter(|column| column.next == next).count();
            let usual = columns.iter().map(|column| column.next).max_by_key(|next| follow(*next));
            columns.retain(|column| Some(column.next) == usual);
            columns
        };
        // Most meridians must have all layers; those that pass through a pin or a slot may lack some.
        let is_whole = |columns: &[SoftColumn]| 2 * columns.len() > MERIDIANS;
        let last_rad = face.max_polar_rad() * (1.0 - 1e-6);
        let polar = |i: usize| last_rad * i as f64 / STEPS as f64;
        let whole = (1..=STEPS).rev().find(|i| is_whole(&around(polar(*i)))).unwrap_or(1);
        let end_rad = polar(whole);
        let mut uneven_mm = vec![0.0f64; names.len()];
        let mut held = BTreeMap::<usize, usize>::new();
        let mut rows: Vec<Option<(Vec<f64>, bool)>> = Vec::new();
        for i in 0..=STEPS {
            let columns = around(end_rad * i as f64 / STEPS as f64);
            if !is_whole(&columns) {
                rows.push(None);
                continue;
            }
            let mut here = Vec::new();
            for (layer, uneven) in uneven_mm.iter_mut().enumerate() {
                let ends = || columns.iter().map(|column| column.soft[layer].end_mm);
                let (least, most) =
                    (ends().fold(f64::INFINITY, f64::min), ends().fold(0.0, f64::max));
                *uneven = uneven.max(most - least);
                // Rotationally symmetric faces stay exact.
                let is_even = most - least < ROUND_MM;
                here.push(if is_even { least } else { ends().sum::<f64>() / columns.len() as f64 });
            }
            let holding = || columns.iter().filter(|c| c.is_held && c.soft.len() == names.len());
            holding().filter_map(|c| c.next).for_each(|body| *held.entry(body).or_default() += 1);
            rows.push(Some((here, 2 * holding().count() > columns.len())));
        }
        // Where a pin or a hole covers all azimuths, as at a tip, the nearest step's values apply.
        let nearest =
            |i: usize| (0..=STEPS).filter(|j| rows[*j].is_some()).min_by_key(|j| j.abs_diff(i));
        let filled = (0..=STEPS).filter_map(|i| rows[nearest(i)?].clone());
        let (mut depths_mm, is_held): (Vec<_>, Vec<_>) = filled.unzip();
        for layer in (0..names.len()).filter(|layer| uneven_mm[*layer] > ROUND_MM) {
            smooth_depths(&mut depths_mm, layer);
        }
        let held_by = held.into_iter().max_by_key(|(_, count)| *count).map(|(body, _)| body);
        Self { end_rad, depths_mm, is_held, held_by, uneven_mm }
    }

    /// Interpolates the depth of a layer's lower face between the table's rows, mm.
    pub(super) fn depth_mm(&self, layer: usize, s: f64) -> f64 {
        let place = s.clamp(0.0, 1.0) * STEPS as f64;
        let i = (place as usize).min(STEPS - 1);
        let share = place - i as f64;
        (1.0 - share) * self.depths_mm[i][layer] + share * self.depths_mm[i + 1][layer]
    }

    /// Returns the boundary condition of the innermost face, and records where it is simplified.
    pub(super) fn inner_boundary(&self, left_out: &mut Vec<String>) -> BoundaryCondition {
        let held = self.is_held.iter().filter(|held| **held).count();
        let from = self.is_held.iter().position(|held| *held).unwrap_or(STEPS);
        // Held from a step on to the rim: an exact boundary condition exists.
        if from > 0 && from < STEPS && self.is_held[from..].iter().all(|held| *held) {
            return BoundaryCondition::BondedBeyond(from as f64 / STEPS as f64);
        }
        let share = 100.0 * held as f64 / (STEPS + 1) as f64;
        match share {
            100.0 => BoundaryCondition::Bonded,
            0.0 => BoundaryCondition::Free,
            50.0.. => {
                left_out.push(format!(
                    "that nothing stiff holds {:.1} % of the inner face",
                    100.0 - share
                ));
                BoundaryCondition::Bonded
            }
            _ => {
                left_out.push(format!("that something stiff holds {share:.1} % of the inner face"));
                BoundaryCondition::Free
            }
        }
    }
}

/// Averages a layer's depths along the meridian too, so that the layer keeps its volume approximately.
fn smooth_depths(depths_mm: &mut [Vec<f64>], layer: usize) {
    let before: Vec<f64> = depths_mm.iter().map(|row| row[layer]).collect();
    for (i, row) in depths_mm.iter_mut().enumerate() {
        let (from, to) = (i.saturating_sub(SPREAD_STEPS), (i + SPREAD_STEPS).min(STEPS));
        row[layer] = before[from..=to].iter().sum::<f64>() / (to - from + 1) as f64;
    }
}

/// Returns whether something rigid begins beyond the end of the meridian, at half the depth of the layers down to
/// `layer`.
pub(super) fn is_rim_held(
    bodies: &Bodies,
    face: &DomePoints,
    meridian: &Meridian,
    layer: usize,
) -> bool {
    let depth_mm = meridian.depths_mm[STEPS][layer] / 2.0;
    let place = |polar: f64| {
        face.point_in_direction(polar, 0.01).map(|(point, outward)| point - depth_mm * outward)
    };
    let (Some(end), Some(before)) = (place(meridian.end_rad), place(meridian.end_rad * 0.995))
    else {
        return false;
    };
    // Along the layers, from just before their end.
    let ray = Ray { origin: before, direction: (end - before).normalize() };
    let end_mm = (end - before).norm();
    bodies.intersect(&ray).iter().any(|stretch| {
        let is_stiff = bodies.placed[stretch.body].elasticity.is_none();
        is_stiff && stretch.begin_mm < end_mm + RIM_MM && stretch.end_mm > end_mm
    })
}
