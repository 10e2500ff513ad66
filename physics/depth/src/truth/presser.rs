//! Rigid bodies that are pressed in, and how much of them there is to see.

use fabkit_geometry::{
    Aabb, CompiledSolid, InvalidSolid, Point3, Pose, Ray, Scratch, Solid, TouchSurface, Vector3,
};
use fabkit_optics::START_MM;

use super::ball::Ball;
use crate::cast::{BOX_SLACK_MM, box_entry};

/// Parts that each side of a presser's box is cut into, to find those inside of the surface.
const CELLS: usize = 6;

/// A rigid body that is pressed into the surface.
#[derive(Clone, Debug)]
pub struct Presser {
    /// For the list of labels, for example `protrusion 3`.
    pub name: String,
    /// Its shape.
    body: CompiledSolid,
    sensor_from_body: Pose,
    body_from_sensor: Pose,
}

/// Around all of a presser that lies inside of the surface: rays get no further.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    /// In the presser's frame.
    bounds: Aabb,
    /// In the sensor frame.
    pub(super) ball: Ball,
}

impl Presser {
    /// A solid in its place.
    ///
    /// # Errors
    /// A solid that is none.
    pub fn new(
        name: impl Into<String>,
        solid: &Solid,
        sensor_from_body: Pose,
    ) -> Result<Self, InvalidSolid> {
        let body = CompiledSolid::new(solid)?;
        let body_from_sensor = sensor_from_body.inverse();
        Ok(Self { name: name.into(), body, sensor_from_body, body_from_sensor })
    }

    /// Whether a point of the sensor frame lies inside.
    pub fn contains(&self, point_in_sensor: &Point3<f64>) -> bool {
        self.body.contains(&self.body_from_sensor.point(*point_in_sensor))
    }

    /// What of it is inside of a surface; `None` if nothing is.
    ///
    /// A part of its box belongs to that unless its middle is further outside than its corners are
    /// from its middle.
    pub(super) fn reach(&self, touch: &TouchSurface) -> Option<Reach> {
        let whole = self.body.bounds().grown(BOX_SLACK_MM);
        if whole.is_empty() {
            return None;
        }
        let bounds = if whole.is_finite() { self.part_inside(&whole, touch) } else { whole };
        let ball = Ball::around(&bounds, &self.sensor_from_body)?;
        Some(Reach { bounds, ball })
    }

    fn part_inside(&self, whole: &Aabb, touch: &TouchSurface) -> Aabb {
        let cell = Vector3::from(whole.size_mm()) / CELLS as f64;
        let radius_mm = 0.5 * cell.norm() + BOX_SLACK_MM;
        let mut inside = Aabb::nothing();
        for i in 0..CELLS.pow(3) {
            let place = [i % CELLS, i / CELLS % CELLS, i / CELLS.pow(2)].map(|k| k as f64);
            let min = whole.min + cell.component_mul(&Vector3::from(place));
            let middle = self.sensor_from_body.point(min + 0.5 * cell);
            if touch.depth_mm(&middle).0 >= -radius_mm {
                inside = inside.hull(&Aabb { min, max: min + cell });
            }
        }
        if inside.is_empty() { inside } else { inside.grown(BOX_SLACK_MM) }
    }

    /// Where a ray first enters, if it does so before `end_mm`, with the normal out of the presser in
    /// the sensor frame.
    pub(super) fn entry(
        &self,
        ray: &Ray,
        reach: &Reach,
        end_mm: f64,
        scratch: &mut Scratch,
    ) -> Option<(f64, Vector3<f64>)> {
        let ray_in_body = Ray {
            origin: self.body_from_sensor.point(ray.origin),
            direction: self.body_from_sensor.vector(ray.direction),
        };
        box_entry(&reach.bounds, &ray_in_body, &(START_MM..end_mm))?;
        let crossing = self.body.first_crossing(&ray_in_body, START_MM, true, scratch)?;
        (crossing.t < end_mm).then(|| (crossing.t, self.sensor_from_body.vector(crossing.normal)))
    }
}
