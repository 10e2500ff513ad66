//! Rigid indenters, and their extent inside the surface.

use fabkit_geometry::{
    Aabb, CompiledSolid, InvalidSolid, Point3, Pose, Ray, Scratch, Solid, TouchSurface, Vector3,
};
use fabkit_optics::START_TOLERANCE_MM;

use super::ball::BoundingBall;
use crate::cast::{BOX_SLACK_MM, box_entry};

/// Number of cells along each side of an indenter's box, when finding the part inside the surface.
const CELLS: usize = 6;

/// A rigid indenter at a pose.
///
/// ```
/// use fabkit_depth::ground_truth::PlacedIndenter;
/// use fabkit_geometry::{Point3, Pose, Solid};
///
/// // A punch, drawn from z = 0 up, and held with its lower face at z = 10 mm.
/// let punch = PlacedIndenter::new("punch", &Solid::cylinder(2.0, 5.0), Pose::translation(0.0, 0.0, 10.0))?;
/// assert!(punch.contains(&Point3::new(1.9, 0.0, 10.1)));
/// assert!(!punch.contains(&Point3::new(1.9, 0.0, 9.9)));
/// # Ok::<(), fabkit_geometry::InvalidSolid>(())
/// ```
#[derive(Clone, Debug)]
pub struct PlacedIndenter {
    /// Name for the list of labels, for example `protrusion 3`.
    pub name: String,
    /// Shape in its own frame.
    body: CompiledSolid,
    sensor_from_body: Pose,
    body_from_sensor: Pose,
}

/// Bounds of the part of an indenter inside the surface. Rays do not get farther out.
#[derive(Clone, Copy, Debug)]
pub(super) struct InsideBounds {
    /// Box in the indenter's frame.
    bounds: Aabb,
    /// Ball in the sensor frame.
    pub(super) ball: BoundingBall,
}

impl PlacedIndenter {
    /// Creates an indenter from a solid and its pose.
    ///
    /// # Errors
    /// An invalid solid.
    pub fn new(
        name: impl Into<String>,
        solid: &Solid,
        sensor_from_body: Pose,
    ) -> Result<Self, InvalidSolid> {
        let body = CompiledSolid::new(solid)?;
        let body_from_sensor = sensor_from_body.inverse();
        Ok(Self { name: name.into(), body, sensor_from_body, body_from_sensor })
    }

    /// Returns whether a point of the sensor frame lies inside.
    pub fn contains(&self, point_in_sensor: &Point3<f64>) -> bool {
        self.body.contains(&self.body_from_sensor.point(*point_in_sensor))
    }

    /// Bounds the part of the indenter inside a surface; `None` if there is none.
    ///
    /// A cell of its box counts unless its centre is farther outside than its corners are from its centre.
    pub(super) fn reach(&self, touch: &TouchSurface) -> Option<InsideBounds> {
        let whole = self.body.bounds().grown(BOX_SLACK_MM);
        if whole.is_empty() {
            return None;
        }
        let bounds = if whole.is_finite() { self.part_inside(&whole, touch) } else { whole };
        let ball = BoundingBall::around(&bounds, &self.sensor_from_body)?;
        Some(InsideBounds { bounds, ball })
    }

    /// Bounds the cells of a finite box that may reach inside the surface.
    fn part_inside(&self, whole: &Aabb, touch: &TouchSurface) -> Aabb {
        let cell = Vector3::from(whole.size_mm()) / CELLS as f64;
        let radius_mm = 0.5 * cell.norm() + BOX_SLACK_MM;
        let mut inside = Aabb::nothing();
        for i in 0..CELLS.pow(3) {
            let place = [i % CELLS, i / CELLS % CELLS, i / CELLS.pow(2)].map(|k| k as f64);
            let min = whole.min + cell.component_mul(&Vector3::from(place));
            let middle = self.sensor_from_body.point(min + 0.5 * cell);
            // The cell's bounding ball reaches the surface.
            if touch.depth_mm(&middle).0 >= -radius_mm {
                inside = inside.hull(&Aabb { min, max: min + cell });
            }
        }
        if inside.is_empty() { inside } else { inside.grown(BOX_SLACK_MM) }
    }

    /// Finds where a ray first enters the indenter, if before `end_mm`. Returns the range and the normal out of the
    /// indenter, in the sensor frame.
    pub(super) fn entry(
        &self,
        ray: &Ray,
        reach: &InsideBounds,
        end_mm: f64,
        scratch: &mut Scratch,
    ) -> Option<(f64, Vector3<f64>)> {
        let ray_in_body = Ray {
            origin: self.body_from_sensor.point(ray.origin),
            direction: self.body_from_sensor.vector(ray.direction),
        };
        box_entry(&reach.bounds, &ray_in_body, &(START_TOLERANCE_MM..end_mm))?;
        let crossing = self.body.first_crossing(&ray_in_body, START_TOLERANCE_MM, true, scratch)?;
        (crossing.t < end_mm).then(|| (crossing.t, self.sensor_from_body.vector(crossing.normal)))
    }
}
