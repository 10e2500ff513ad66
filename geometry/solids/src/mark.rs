//! What a camera follows below the touched surface.

use nalgebra::{Point3, Vector3};

use crate::Pose;

/// A dot, the end of a dimple or of a slot: what a camera follows while the gel around it moves.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Unique, with its number in the drawing's order: `dimple 7`.
    pub name: String,
    /// The middle of what faces the camera, at rest, sensor frame, mm.
    pub point: Point3<f64>,
    /// The way in which it points, mostly towards the camera; unit, sensor frame.
    pub axis: Vector3<f64>,
    /// Half of its width, mm.
    pub radius_mm: f64,
    /// What moves it.
    pub carrier: Carrier,
}

/// What moves a mark.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Carrier {
    /// The gel around it.
    Gel,
    /// A pin of what it stands on, in softer gel, from its root to the mark.
    Pin {
        /// Where it begins, on its axis, sensor frame, mm.
        root: Point3<f64>,
    },
}

impl Mark {
    /// Marks in the order of poses whose z axes point outwards: each at `depth_mm` below its pose's origin, named by a
    /// word and its number.
    pub fn below(
        word: &str,
        poses: &[Pose],
        depth_mm: f64,
        radius_mm: f64,
        carrier: impl Fn(&Pose) -> Carrier,
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
