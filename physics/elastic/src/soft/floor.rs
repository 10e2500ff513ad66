//! Flat floor of a dome that is filled with gel to the bottom, which rays along surface normals do not reach.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, TAU};

use fabkit_geometry::{DomePoints, Point3, Ray, Vector3};

use super::bodies::Bodies;
use crate::MeridianCurve;

/// Numbers of radii and azimuths at which vertical rays probe the floor.
const RADII: usize = 200;
const AZIMUTHS: usize = 24;
/// Tolerance of equal heights, mm.
const SAME_MM: f64 = 1e-6;

/// Blend of the floor's parametrisation: part that follows the sine of the dome's polar angle, that is, lies straight
/// below it.
const SINE_SHARE: f64 = 0.4;

/// A flat rigid face that holds the lowest layer.
pub(super) struct Floor {
    pub(super) z_mm: f64,
    radius_mm: f64,
    /// Body that the face belongs to.
    pub(super) body: usize,
}

impl Floor {
    /// Finds the level where most of the soft material below a dome ends, along vertical rays from above. Returns
    /// `None` if it is not flat, not around the axis, or not held.
    pub(super) fn find(bodies: &Bodies, face: &DomePoints, apex_z_mm: f64) -> Option<Self> {
        let radius_mm = |i: usize| face.equator_radius_mm() * (i as f64 + 0.5) / RADII as f64;
        let ends: Vec<Vec<(usize, f64)>> = (0..RADII)
            .map(|i| {
                // Offset, so that no azimuth falls on an axis.
                let azimuths = (0..AZIMUTHS).map(|k| (k as f64 + 0.37) * TAU / AZIMUTHS as f64);
                let end = |azimuth: f64| {
                    let (sin, cos) = azimuth.sin_cos();
                    let [x, y] = [cos, sin].map(|part| radius_mm(i) * part);
                    let origin = Point3::new(x, y, apex_z_mm + 1.0);
                    let column = bodies.first_soft(&Ray { origin, direction: -Vector3::z() });
                    let (next, last) = (column.next?, column.soft.last()?);
                    Some((next, origin.z - last.end_mm))
                };
                azimuths.filter_map(end).collect()
            })
            .collect();
        // Weighted by area: a ring counts in proportion to its radius.
        let mut weights = BTreeMap::<(usize, i64), f64>::new();
        let key = |(body, z_mm): (usize, f64)| (body, (z_mm / SAME_MM).round() as i64);
        for (i, ring) in ends.iter().enumerate() {
            ring.iter().for_each(|end| *weights.entry(key(*end)).or_default() += radius_mm(i));
        }
        let (usual, _) = weights.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        // Some rays end at parts inside the gel, and at the tip all may: at a dot or a pin.
        let is_floor = |ring: &Vec<(usize, f64)>| {
            2 * ring.iter().filter(|end| key(**end) == usual).count() > AZIMUTHS
        };
        let rings = ends.iter().rposition(is_floor)? + 1;
        // A floor below less than half of the radius does not hold the gel.
        (2 * rings > RADII).then(|| Self {
            z_mm: usual.1 as f64 * SAME_MM,
            radius_mm: face.equator_radius_mm() * rings as f64 / RADII as f64,
            body: usual.0,
        })
    }

    /// Returns the meridian of the floor.
    pub(super) fn curve(&self) -> MeridianCurve {
        // Even spacing inclines the mesh columns least at the rim, the sine does so on the way there; a blend serves
        // both.
        let (radius_mm, z_mm) = (self.radius_mm, self.z_mm);
        MeridianCurve::new(move |s| {
            let share = (1.0 - SINE_SHARE) * s + SINE_SHARE * (s * FRAC_PI_2).sin();
            [radius_mm * share, z_mm]
        })
    }
}
