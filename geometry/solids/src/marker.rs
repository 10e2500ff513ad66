//! Markers below the touched surface that a camera tracks.

use nalgebra::{Point3, Vector3};

use crate::Pose;

/// Marker that a camera tracks while the gel around it moves: a dot, or the end of a dimple or of a slot.
#[derive(Clone, Debug, PartialEq)]
pub struct Marker {
    /// Unique name with the number in the drawing's order: `dimple 7`.
    pub name: String,
    /// Centre of the face towards the camera, at rest, sensor frame, mm.
    pub point: Point3<f64>,
    /// Direction in which the marker points, mostly towards the camera: unit vector, sensor frame.
    pub axis: Vector3<f64>,
    /// Half of the marker's width, mm.
    pub radius_mm: f64,
    /// Material or structure that moves the marker.
    pub carrier: MarkerCarrier,
}

/// Material or structure that moves a marker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MarkerCarrier {
    /// Gel around the marker.
    Gel,
    /// Pin in softer gel that carries the marker at its tip; it extends from its root to the marker.
    Pin {
        /// Root of the pin, on its axis, sensor frame, mm.
        root: Point3<f64>,
    },
}

impl Marker {
    /// Creates one marker per pose, in the order of the poses, whose z axes point outwards. Each marker lies `depth_mm`
    /// below its pose's origin and is named `word` and its number.
    ///
    /// ```
    /// use fabkit_geometry::{Marker, MarkerCarrier, Point3, Pose, Vector3};
    /// let tip = Pose::translation(0.0, 0.0, 20.0);
    /// let dots = Marker::place_below_poses("dot", &[tip], 1.5, 0.4, |_| MarkerCarrier::Gel);
    /// assert_eq!((&*dots[0].name, dots[0].point), ("dot 1", Point3::new(0.0, 0.0, 18.5)));
    /// assert_eq!(dots[0].axis, -Vector3::z()); // towards the camera below
    /// ```
    pub fn place_below_poses(
        word: &str,
        poses: &[Pose],
        depth_mm: f64,
        radius_mm: f64,
        carrier: impl Fn(&Pose) -> MarkerCarrier,
    ) -> Vec<Self> {
        let mark = |(i, pose): (usize, &Pose)| Self {
            name: format!("{word} {}", i + 1),
            point: pose.point(Point3::new(0.0, 0.0, -depth_mm)),
            axis: pose.vector(-Vector3::z()),
            radius_mm,
            carrier: carrier(pose),
        };
        poses.iter().enumerate().map(mark).collect()
    }
}
