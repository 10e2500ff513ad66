//! Coverage of a sensor's surface by its camera, and causes of lost area.

use std::collections::BTreeMap;

use fabkit_fixtures::SurfacePoints;
use fabkit_geometry::{InvalidSolid, TouchSurface};
use fabkit_optics::{InvisibleReason, ViewStacks};
use rayon::prelude::*;
use serde_json::{Value, json};

use super::Viewpoint;
use super::probes::seeded_points;
use super::projector::{POINTS_PER_CHUNK, Projector};

/// Number of sampled points; shares are accurate to about a thousandth.
const PLACES: u32 = 4_096;

pub use fabkit_optics::{OUTSIDE_IMAGE, REFRACTION};

/// Share of a surface that a camera sees, and causes for the rest.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceCoverage {
    /// Visible share of the surface's area, 0 to 1.
    pub area: f64,
    /// Shares of the area that is not visible, by the blocking body or another cause, the largest first.
    pub lost: Vec<(String, f64)>,
    /// Area of the whole surface, mm2.
    pub area_mm2: f64,
    /// Smallest and largest angle between the surface's points and the camera's axis, rad.
    pub angles_rad: [f64; 2],
    /// Largest angle off the axis that the lens images, rad.
    pub lens_rad: f64,
}

impl SurfaceCoverage {
    /// Returns area and causes as JSON documents have them.
    pub fn to_json(&self) -> Value {
        json!({ "area": self.area, "area_mm2": self.area_mm2, "lost": self.lost_json() })
    }

    /// Returns the lost shares as a JSON object from cause to share.
    pub fn lost_json(&self) -> Value {
        self.lost.iter().map(|(by, share)| (by.clone(), json!(share))).collect()
    }
}

/// Computes the coverage from points spread evenly over the surface's area, each looked at through the sensor's bodies.
///
/// # Errors
/// Returns an error if the surface's dimensions make no valid solid.
///
/// ```
/// use fabkit_optics::ViewStacks;
/// use fabkit_scene::ground_truth::{Viewpoint, compute_coverage};
///
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// let sensor = &project.design.sensor;
/// let touch = sensor.touch.as_ref().ok_or("no surface")?;
/// let viewpoint = Viewpoint::new(&sensor.camera, None, None)?;
/// let sights = ViewStacks::new(viewpoint.stack(sensor)?);
/// let coverage = compute_coverage(touch, &viewpoint, &sights)?;
/// // What is not seen has causes, and all shares make 1.
/// let lost: f64 = coverage.lost.iter().map(|(_, share)| share).sum();
/// assert!((coverage.area + lost - 1.0).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn compute_coverage(
    touch: &TouchSurface,
    viewpoint: &Viewpoint,
    sights: &ViewStacks,
) -> Result<SurfaceCoverage, InvalidSolid> {
    let points = SurfacePoints::new(touch)?;
    let camera_from_sensor = viewpoint.sensor_from_camera.inverse();
    // A fixed seed: the result does not change from run to run.
    let places = seeded_points(0);
    let point = |number: u32| {
        let [along, around, _] = places.at(number as usize);
        points.point_at_area_fractions([along, around]).map(|(point, _)| point)
    };
    let numbers: Vec<u32> = (0..PLACES).collect();
    let looks = numbers.par_chunks(POINTS_PER_CHUNK).flat_map_iter(|numbers| {
        let mut looking = Projector::new(viewpoint, sights);
        let look = |number: &u32| {
            let point = point(*number)?;
            let in_camera = camera_from_sensor.point(point);
            // Straight through all bodies: refraction is ignored for this diagnostic.
            let angle_rad = in_camera.coords.xy().norm().atan2(in_camera.z);
            Some((looking.look(&point).err(), angle_rad))
        };
        numbers.iter().filter_map(look).collect::<Vec<_>>()
    });
    let looks: Vec<(Option<InvisibleReason>, f64)> = looks.collect();
    let share = |count: usize| count as f64 / f64::from(PLACES);
    let mut counts: BTreeMap<InvisibleReason, usize> = BTreeMap::new();
    for lost in looks.iter().filter_map(|(lost, _)| *lost) {
        *counts.entry(lost).or_default() += 1;
    }
    let seen = looks.len() - counts.values().sum::<usize>();
    let word = |lost: InvisibleReason| lost.label(sights.stack()).to_owned();
    let mut lost: Vec<(String, f64)> =
        counts.into_iter().map(|(lost, count)| (word(lost), share(count))).collect();
    // Causes with equal shares keep the order of `Lost`, since the sort is stable.
    lost.sort_by(|a, b| b.1.total_cmp(&a.1));
    let fold = |start: f64, pick: fn(f64, f64) -> f64| {
        looks.iter().fold(start, |so_far, (_, angle_rad)| pick(so_far, *angle_rad))
    };
    Ok(SurfaceCoverage {
        area: share(seen),
        lost,
        area_mm2: points.area_mm2(),
        angles_rad: [fold(f64::INFINITY, f64::min), fold(0.0, f64::max)],
        lens_rad: viewpoint.camera().angle_limit_rad(),
    })
}
