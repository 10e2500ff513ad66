//! Metrics of markers: features that repeat under one of a few names.

use std::collections::BTreeSet;

use fabkit_geometry::{
    Assembly, CompiledSolid, InvalidSolid, Placement, Point3, Pose, Ray, Sensor, Solid, Vector3,
};
use nalgebra::Matrix3x2;

use super::ComputedMetrics;
use super::camera::{SurfacePlace, View};

/// Names of features that a camera tracks; a number follows.
const FEATURE_NAMES: [&str; 3] = ["marker", "dimple", "dot"];

/// Marker, sensor frame.
struct Marker {
    body: CompiledSolid,
    sensor_from_marker: Pose,
    /// Centre of its bounding box, sensor frame, mm.
    centre: Point3<f64>,
    /// Radius of the ball around `centre` that encloses the marker, mm.
    reach_mm: f64,
    /// Widths across its axis, mm.
    widths_mm: [f64; 2],
}

/// Computes the group's metrics; nothing for a sensor without markers.
pub(super) fn compute(view: &View, computed: &mut ComputedMetrics) -> Result<(), InvalidSolid> {
    let markers = markers(view.sensor())?;
    if markers.is_empty() {
        return Ok(());
    }
    let mut viewer = view.viewer();
    let widths: Vec<f64> = markers
        .iter()
        .filter_map(|marker| {
            let look = viewer.project(&marker.centre).ok()?;
            // The half of the marker in front of its centre does not hide it.
            let is_hidden = look.sight.hidden_by(marker.reach_mm).is_some();
            if is_hidden || !view.camera().is_in_image(&look.pixel) {
                return None;
            }
            let by_place = viewer.pixel_by_point(&marker.centre, &look)?;
            let across =
                [Vector3::x(), Vector3::y()].map(|axis| marker.sensor_from_marker.vector(axis));
            // The marker's disc maps to an ellipse in the image; a disc of its area has the diameter sqrt(a b |det|).
            let px_per_mm = by_place * Matrix3x2::from_columns(&across);
            let [a, b] = marker.widths_mm;
            Some((a * b * px_per_mm.determinant().abs()).sqrt())
        })
        .collect();
    computed.put("marker_count", markers.len() as f64);
    computed.put("markers_seen", widths.len() as f64);
    computed.put_spread("marker_px", widths);
    if let Some((places, _)) = view.places() {
        let mut is_behind = |place: &SurfacePlace| {
            is_path_blocked(&markers, &viewer.path_corners(&place.point, &place.look))
        };
        // Light that another body blocks is lost in either case.
        let (behind, open): (Vec<&SurfacePlace>, Vec<&SurfacePlace>) =
            places.iter().partition(|place| is_behind(place));
        let hidden = behind.len();
        let seen = open.iter().filter(|place| place.hidden_by.is_none()).count();
        if hidden + seen > 0 {
            computed.put("occlusion", hidden as f64 / (hidden + seen) as f64);
        }
    }
    Ok(())
}

/// Finds the markers of the first body of the sensor in use that has any. Layers come before parts, because a mold has
/// the same features.
fn markers(sensor: &Sensor) -> Result<Vec<Marker>, InvalidSolid> {
    let layers = sensor.layers().map(|layer| (&layer.solid, &layer.placements));
    let parts = sensor.parts().map(|part| (&part.solid, &part.placements));
    let in_use = |placements: &[Placement]| {
        placements.iter().find(|p| p.assembly == Assembly::sensor()).map(|p| p.assembly_from_body)
    };
    for (solid, placements) in layers.chain(parts) {
        let Some(sensor_from_body) = in_use(placements) else { continue };
        let found = markers_of_body(solid, &sensor_from_body)?;
        if !found.is_empty() {
            return Ok(found);
        }
    }
    Ok(Vec::new())
}

/// Finds the markers among a solid's features.
fn markers_of_body(solid: &Solid, sensor_from_body: &Pose) -> Result<Vec<Marker>, InvalidSolid> {
    let mut names = BTreeSet::new();
    let mut markers = Vec::new();
    for leaf in solid.leaves() {
        let Some((word, number)) = leaf.feature.rsplit_once(' ') else { continue };
        let is_marker = FEATURE_NAMES.contains(&word) && number.parse::<u32>().is_ok();
        // A feature of several primitives is measured by its first one.
        if !is_marker || !names.insert(leaf.feature) {
            continue;
        }
        let body = CompiledSolid::new(leaf.primitive)?;
        let bounds = body.bounds();
        let size = bounds.max - bounds.min;
        let sensor_from_marker = sensor_from_body.then_in(leaf.root_from_leaf);
        markers.push(Marker {
            centre: sensor_from_marker.point(bounds.centre()),
            reach_mm: 0.5 * size.norm(),
            widths_mm: [size.x, size.y],
            sensor_from_marker,
            body,
        });
    }
    Ok(markers)
}

/// Returns whether a marker blocks a path of light.
fn is_path_blocked(markers: &[Marker], way: &[Point3<f64>]) -> bool {
    way.windows(2).any(|piece| is_segment_blocked(markers, &piece[0], &piece[1]))
}

/// Returns whether a marker blocks the straight line between two points.
fn is_segment_blocked(markers: &[Marker], eye: &Point3<f64>, place: &Point3<f64>) -> bool {
    let sight = place - eye;
    let length_mm = sight.norm();
    let direction = sight / length_mm;
    markers.iter().any(|marker| {
        let to_centre = marker.centre - eye;
        let along = to_centre.dot(&direction);
        let beside_mm = (to_centre - along * direction).norm();
        if beside_mm > marker.reach_mm || along < 0.0 || along - marker.reach_mm > length_mm {
            return false;
        }
        let from = marker.sensor_from_marker.inverse();
        let ray = Ray { origin: from.point(*eye), direction: from.vector(direction) };
        marker.body.crossings(&ray).iter().any(|c| c.entering && c.t < length_mm)
    })
}
