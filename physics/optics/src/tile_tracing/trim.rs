//! Trims: the part of a surface that belongs to a face.

use std::ops::Range;
use std::sync::Arc;

use fabkit_geometry::{Aabb, CompiledSolid, Extrusion, Point3, Pose, Segment, Solid};
use nalgebra::Vector2;

use super::edges::Edge;
use super::faces::{Cell, SLACK_MM, radius_range};

/// Bounds of a face on its surface.
#[derive(Clone, Debug)]
pub(super) struct Trim {
    /// Room that contains the whole face.
    pub(super) room: Cell,
    /// Frame of the room, if it is not the sensor's: that of a tilted or displaced primitive.
    pub(super) leaf_from_sensor: Option<Pose>,
    /// Outline, for the faces of plates.
    pub(super) outline: Option<Arc<Outline>>,
    /// True if the surface within the room is exactly the face. Otherwise it is bounded by other faces of its
    /// primitive.
    pub(super) is_exact: bool,
    /// Range of all cells of its primitive.
    pub(super) cells: Range<u32>,
    /// Range of all cells of its item if some are clipped to the item's box, as those of a tool that reaches beyond the
    /// body that it cuts; otherwise empty.
    ///
    /// At a face of such an item, rays have passed the same faces within the box, but need not be in the same primitives.
    /// They are if no face of the item lies between their positions: the way between these lies within the box.
    pub(super) clipped_item_cells: Range<u32>,
}

impl Trim {
    /// Returns the room in which a point of the surface certainly lies on the face.
    pub(super) fn room(&self) -> Room {
        let Cell { bounds, radius_mm: [near, far], .. } = &self.room;
        let within = |low: f64, high: f64| {
            // Boxes have a margin, of which twice is taken off here to be certain. Thin ranges stay as they are, as
            // those of a plane across z; and the axis itself counts as inside.
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

    /// Returns whether a point of the surface certainly lies outside the face.
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
    /// Returns whether the face has an outline.
    pub(super) fn has_outline(&self) -> bool {
        self.outline.is_some()
    }

    /// Returns whether all points of a plate's plane within a box certainly lie outside its outline.
    pub(super) fn misses_box(&self, bounds: &Aabb) -> bool {
        if bounds.is_empty() {
            return true;
        }
        let middle = bounds.min + 0.5 * (bounds.max - bounds.min);
        let room_point = self.leaf_from_sensor.map_or(middle, |pose| pose.point(middle));
        let reach_mm = 0.5 * (bounds.max - bounds.min).norm();
        self.outline.as_ref().is_some_and(|outline| outline.misses(&room_point, reach_mm))
    }
}

/// Ranges of coordinates, and of squared distances from the z axis, in the sensor's frame or one of its own.
#[derive(Clone, Debug)]
pub(super) struct Room {
    pub(super) low: [f64; 3],
    pub(super) high: [f64; 3],
    pub(super) squared_mm2: [f64; 2],
    pub(super) own_from_sensor: Option<Pose>,
}

impl Room {
    /// Returns whether a box certainly lies within. Always false for rooms in a frame of their own.
    pub(super) fn contains_box(&self, bounds: &Aabb) -> bool {
        let [near, far] = radius_range(bounds);
        self.own_from_sensor.is_none()
            && (0..3).all(|axis| {
                self.low[axis] <= bounds.min[axis] && bounds.max[axis] <= self.high[axis]
            })
            && self.squared_mm2[0] <= near * near
            && far * far <= self.squared_mm2[1]
    }
}

/// Outline of the faces of a plate.
#[derive(Clone, Debug)]
pub(super) struct Outline {
    /// Pose of the frame in which the plate stands upright from z = 0.
    own_from_room: Pose,
    plate: CompiledSolid,
    middle_mm: f64,
    borders: Vec<OutlinePiece>,
}

/// Piece of an outline.
#[derive(Clone, Copy, Debug)]
enum OutlinePiece {
    Line([Vector2<f64>; 2]),
    /// Centre and radius of the whole circle.
    Arc(Vector2<f64>, f64),
    Other,
}

impl Outline {
    /// Builds the outline of an extrusion's end faces.
    pub(super) fn from_extrusion(
        extrusion: &Extrusion,
        edges: &[Edge],
        pose: &Pose,
    ) -> Option<Arc<Self>> {
        let plate = CompiledSolid::new(&Solid::Extrusion(extrusion.clone())).ok()?;
        let border = |edge: &Edge| {
            let (from, to) = (Vector2::from(edge.from), Vector2::from(edge.segment.to()));
            match edge.segment {
                Segment::Line { .. } => OutlinePiece::Line([from, to]),
                Segment::Arc { centre, .. } => {
                    let centre = Vector2::from(*centre);
                    OutlinePiece::Arc(centre, (from - centre).norm())
                }
                Segment::EllipticArc { .. } => OutlinePiece::Other,
            }
        };
        Some(Arc::new(Self {
            own_from_room: pose.inverse(),
            plate,
            middle_mm: extrusion.height_mm / 2.0,
            borders: edges.iter().map(border).collect(),
        }))
    }

    /// Returns whether all points within a distance of a point, in the plane of the face, certainly lie outside the
    /// outline.
    fn misses(&self, point: &Point3<f64>, reach_mm: f64) -> bool {
        let point = self.own_from_room.point(*point).coords.xy();
        // If no edge comes near, all of the disk is inside or outside, as its centre is.
        self.borders.iter().all(|border| border.distance_mm(&point) > reach_mm + 2.0 * SLACK_MM)
            && !self.plate.contains(&Point3::new(point.x, point.y, self.middle_mm))
    }
}

impl OutlinePiece {
    /// Returns a lower bound of the distance of a point.
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
