//! How much of a surface is a face.

use std::ops::Range;
use std::sync::Arc;

use fabkit_geometry::{Aabb, CompiledSolid, Extrusion, Point3, Pose, Segment, Solid};
use nalgebra::Vector2;

use super::edges::Edge;
use super::faces::{Cell, SLACK_MM, radius_of};

/// How much of a surface its face is.
#[derive(Clone, Debug)]
pub(super) struct Trim {
    /// Room that the whole face lies in.
    pub(super) room: Cell,
    /// Of what is upright in a frame of its own: the room is in that.
    pub(super) leaf_from_sensor: Option<Pose>,
    /// Of a plate's face.
    pub(super) outline: Option<Arc<Outline>>,
    /// Whether the surface within that room is the face; else others of its primitive bound it there.
    pub(super) is_exact: bool,
    /// All cells of its primitive.
    pub(super) cells: Range<u32>,
}

impl Trim {
    /// Where a point of the surface surely lies on the face.
    pub(super) fn room(&self) -> Room {
        let Cell { bounds, radius_mm: [near, far], .. } = &self.room;
        let within = |low: f64, high: f64| {
            // The room has some slack already. Of a plane across z, or the axis itself, one side of it is thin.
            let by_mm = if high - low < 4.0 * SLACK_MM { 0.0 } else { 2.0 * SLACK_MM };
            [low + by_mm, high - by_mm]
        };
        let [x, y, z] = [0, 1, 2].map(|axis| within(bounds.min[axis], bounds.max[axis]));
        let [near, far] = within(if *near <= 0.0 { -1.0 } else { *near }, *far);
        Room {
            low: [x[0], y[0], z[0]],
            high: [x[1], y[1], z[1]],
            squared_mm2: [near.max(0.0).powi(2), far * far],
            own_from_sensor: self.leaf_from_sensor,
        }
    }

    /// Whether a point of the surface surely lies off the face.
    pub(super) fn misses(&self, point: &Point3<f64>) -> bool {
        let point = self.leaf_from_sensor.map_or(*point, |pose| pose.point(*point));
        let Cell { bounds, radius_mm: [near, far], .. } = &self.room;
        let squared = point.x * point.x + point.y * point.y;
        let is_in =
            bounds.contains(&point) && near.max(0.0).powi(2) <= squared && squared <= far * far;
        !is_in || self.outline.as_ref().is_some_and(|outline| outline.misses(&point, 0.0))
    }
}

impl Trim {
    pub(super) fn has_outline(&self) -> bool {
        self.outline.is_some()
    }

    /// Whether all points of a plate's plane within a box surely lie outside of its outline.
    pub(super) fn misses_all(&self, bounds: &Aabb) -> bool {
        if bounds.is_empty() {
            return true;
        }
        let middle = bounds.min + 0.5 * (bounds.max - bounds.min);
        let room_point = self.leaf_from_sensor.map_or(middle, |pose| pose.point(middle));
        let reach_mm = 0.5 * (bounds.max - bounds.min).norm();
        self.outline.as_ref().is_some_and(|outline| outline.misses(&room_point, reach_mm))
    }
}

/// Between what coordinates, and squares of distances from the z axis, in a frame of its own.
#[derive(Clone, Debug)]
pub(super) struct Room {
    pub(super) low: [f64; 3],
    pub(super) high: [f64; 3],
    pub(super) squared_mm2: [f64; 2],
    pub(super) own_from_sensor: Option<Pose>,
}

impl Room {
    /// Whether all of a box lies within; `false` too where that is not plain.
    pub(super) fn holds(&self, bounds: &Aabb) -> bool {
        let [near, far] = radius_of(bounds);
        self.own_from_sensor.is_none()
            && (0..3).all(|axis| {
                self.low[axis] <= bounds.min[axis] && bounds.max[axis] <= self.high[axis]
            })
            && self.squared_mm2[0] <= near * near
            && far * far <= self.squared_mm2[1]
    }
}

/// What a plate's faces end at.
#[derive(Clone, Debug)]
pub(super) struct Outline {
    /// With the plate upright from z = 0.
    own_from_room: Pose,
    plate: CompiledSolid,
    middle_mm: f64,
    borders: Vec<Border>,
}

/// A piece of an outline.
#[derive(Clone, Copy, Debug)]
enum Border {
    Line([Vector2<f64>; 2]),
    /// Centre and radius, of the whole circle.
    Arc(Vector2<f64>, f64),
    Other,
}

impl Outline {
    pub(super) fn of(extrusion: &Extrusion, edges: &[Edge], pose: &Pose) -> Option<Arc<Self>> {
        let plate = CompiledSolid::new(&Solid::Extrusion(extrusion.clone())).ok()?;
        let border = |edge: &Edge| {
            let (from, to) = (Vector2::from(edge.from), Vector2::from(edge.segment.to()));
            match edge.segment {
                Segment::Line { .. } => Border::Line([from, to]),
                Segment::Arc { centre, .. } => {
                    let centre = Vector2::from(*centre);
                    Border::Arc(centre, (from - centre).norm())
                }
                Segment::EllipticArc { .. } => Border::Other,
            }
        };
        Some(Arc::new(Self {
            own_from_room: pose.inverse(),
            plate,
            middle_mm: extrusion.height_mm / 2.0,
            borders: edges.iter().map(border).collect(),
        }))
    }

    /// Whether all within some distance of a point, in the plane of a face, surely lie outside of the outline.
    fn misses(&self, point: &Point3<f64>, reach_mm: f64) -> bool {
        let point = self.own_from_room.point(*point).coords.xy();
        self.borders.iter().all(|border| border.distance_mm(&point) > reach_mm + 2.0 * SLACK_MM)
            && !self.plate.contains(&Point3::new(point.x, point.y, self.middle_mm))
    }
}

impl Border {
    /// At least so far away a point is.
    fn distance_mm(&self, point: &Vector2<f64>) -> f64 {
        match self {
            Self::Line([from, to]) => {
                let along = to - from;
                let share = ((point - from).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
                (point - from - share * along).norm()
            }
            Self::Arc(centre, radius_mm) => ((point - centre).norm() - radius_mm).abs(),
            Self::Other => 0.0,
        }
    }
}
