//! Displacement of markers by a press: dots, ends of dimples and slots.

use fabkit_elastic::{PressOutcome, SoftStack};
use fabkit_export::{NpyArray, NpyValues};
use fabkit_geometry::{Marker, Sensor, TouchSurface, Vector3};
use serde_json::{Value, json};

/// A marker and its displacement during a press.
#[derive(Clone, Debug)]
pub struct MarkerDisplacement {
    /// The marker at rest.
    pub mark: Marker,
    /// Displacement from rest, sensor frame, mm; `None` outside the region that was solved.
    pub displacement_mm: Option<Vector3<f64>>,
    /// Unit axis of the displaced marker, sensor frame; the axis at rest where the displacement is unknown.
    pub axis: Vector3<f64>,
}

/// Computes the displacement of all markers of a sensor.
pub(super) fn compute_displacements(
    sensor: &Sensor,
    touch: &TouchSurface,
    soft: &SoftStack,
    outcome: &PressOutcome,
) -> Vec<MarkerDisplacement> {
    let moved = |mark: &Marker| {
        let moved = soft.displace_marker(outcome, touch, mark);
        MarkerDisplacement {
            displacement_mm: moved.map(|moved| moved.displacement_mm),
            axis: moved.map_or(mark.axis, |moved| moved.axis),
            mark: mark.clone(),
        }
    };
    sensor.marks.iter().map(moved).collect()
}

/// Returns the markers as JSON, in the design's order.
pub fn marks_document(marks: &[MarkerDisplacement]) -> Value {
    let moved = |moved: &MarkerDisplacement| {
        json!({
            "name": moved.mark.name,
            "place_mm": <[f64; 3]>::from(moved.mark.point.coords),
            "displacement_mm": moved.displacement_mm.map(<[f64; 3]>::from),
            "axis": <[f64; 3]>::from(moved.axis),
        })
    };
    marks.iter().map(moved).collect()
}

/// Returns places at rest, displacements (NaN where unknown), mm, and axes of M markers as arrays of M x 3, sensor
/// frame.
pub(super) fn marks_arrays(marks: &[MarkerDisplacement]) -> [NpyArray; 3] {
    let unknown = Vector3::repeat(f64::NAN);
    let vectors = |name: &str, value: &dyn Fn(&MarkerDisplacement) -> Vector3<f64>| {
        let values = marks.iter().flat_map(|moved| <[f64; 3]>::from(value(moved)));
        let shape = vec![marks.len(), 3];
        NpyArray { name: name.into(), shape, values: NpyValues::F64(values.collect()) }
    };
    [
        vectors("mark_place_mm", &|moved| moved.mark.point.coords),
        vectors("mark_displacement_mm", &|moved| moved.displacement_mm.unwrap_or(unknown)),
        vectors("mark_axis", &|moved| moved.axis),
    ]
}

/// Returns the name and displacement, mm, of the marker that moves farthest; `None` if no displacement is known.
pub fn farthest_marker(marks: &[MarkerDisplacement]) -> Option<(&str, f64)> {
    let known =
        marks.iter().filter_map(|m| Some((m.mark.name.as_str(), m.displacement_mm?.norm())));
    known.max_by(|a, b| a.1.total_cmp(&b.1))
}
