//! Where a sensor's surface is while something presses.

use fabkit_geometry::{Point3, Vector3};

use super::SoftStack;
use crate::{Field, Outcome, Stack};

/// Drags are followed back in as many steps: they change little over their own length.
const STEPS_BACK: usize = 3;

/// A surface that has given way, in the sensor's frame.
///
/// A press moves the surface along its normals: there the presser was met, so that what touches lies on the
/// presser. Friction then drags along what has moved.
#[derive(Clone, Debug)]
pub struct Yielded {
    straight: Field,
    sheared: Option<Field>,
}

impl Yielded {
    /// From a press that goes straight in, and the same after its way along the surface.
    pub fn new(stack: &Stack, straight: &Outcome, sheared: Option<&Outcome>) -> Self {
        let field = |outcome| Field::new(stack, outcome, 0);
        Self { straight: field(straight), sheared: sheared.map(field) }
    }

    /// How far it has moved out of the sensor, mm, along the normal at rest of a point of the surface at rest;
    /// negative where it is pressed in.
    #[inline]
    pub fn outwards_mm(
        &self,
        soft: &SoftStack,
        point_in_sensor: &Point3<f64>,
        outward: &Vector3<f64>,
    ) -> f64 {
        let [s, azimuth] = self.source(soft, point_in_sensor, outward);
        self.last().outwards_mm(s, azimuth)
    }

    /// What the presser pushes it with there, MPa.
    #[inline]
    pub fn pressure_mpa(
        &self,
        soft: &SoftStack,
        point_in_sensor: &Point3<f64>,
        outward: &Vector3<f64>,
    ) -> f64 {
        let [s, azimuth] = self.source(soft, point_in_sensor, outward);
        self.last().pressure_mpa(s, azimuth)
    }

    fn last(&self) -> &Field {
        self.sheared.as_ref().unwrap_or(&self.straight)
    }

    /// Where what is now above a point was before friction dragged it there: s and azimuth.
    #[inline]
    fn source(
        &self,
        soft: &SoftStack,
        point_in_sensor: &Point3<f64>,
        outward: &Vector3<f64>,
    ) -> [f64; 2] {
        let mut at = soft.coordinates(point_in_sensor);
        let Some(sheared) = &self.sheared else { return at };
        for _ in 0..STEPS_BACK {
            let (before, after) =
                (self.straight.sideways_mm(at[0], at[1]), sheared.sideways_mm(at[0], at[1]));
            let [along, around] = soft.along(point_in_sensor, outward);
            let drag_mm = (after[0] - before[0]) * along + (after[1] - before[1]) * around;
            at = soft.coordinates(&(point_in_sensor - drag_mm));
        }
        at
    }
}
