//! Shape of a sensor's surface during a press.

use fabkit_geometry::{Point3, Vector3};

use super::SoftStack;
use crate::{DisplacementField, ElasticStack, PressOutcome};

/// Iterations to trace a point back along the drag, which varies little over its own length.
const STEPS_BACK: usize = 3;

/// A deformed sensor surface, in the sensor's frame.
///
/// Pressing moves the surface along its normals, so that points in contact lie on the indenter. Friction then drags the
/// displaced surface sideways.
#[derive(Clone, Debug)]
pub struct DeformedSurface {
    straight: DisplacementField,
    sheared: Option<DisplacementField>,
}

impl DeformedSurface {
    /// Creates the surface from a straight press, and optionally the same press after its shear.
    pub fn new(
        stack: &ElasticStack,
        straight: &PressOutcome,
        sheared: Option<&PressOutcome>,
    ) -> Self {
        let field = |outcome| DisplacementField::new(stack, outcome, 0);
        Self { straight: field(straight), sheared: sheared.map(field) }
    }

    /// Returns the displacement out of the sensor, mm, along the normal of a point of the undeformed surface; negative
    /// where it is pressed in.
    #[inline]
    pub fn outwards_mm(
        &self,
        soft: &SoftStack,
        point_in_sensor: &Point3<f64>,
        outward: &Vector3<f64>,
    ) -> f64 {
        let [s, azimuth] = self.trace_back(soft, point_in_sensor, outward);
        self.last().outwards_mm(s, azimuth)
    }

    /// Returns the contact pressure at a point, MPa.
    #[inline]
    pub fn pressure_mpa(
        &self,
        soft: &SoftStack,
        point_in_sensor: &Point3<f64>,
        outward: &Vector3<f64>,
    ) -> f64 {
        let [s, azimuth] = self.trace_back(soft, point_in_sensor, outward);
        self.last().pressure_mpa(s, azimuth)
    }

    fn last(&self) -> &DisplacementField {
        self.sheared.as_ref().unwrap_or(&self.straight)
    }

    /// Returns s and azimuth, before friction dragged it, of the surface that now lies above a point.
    #[inline]
    fn trace_back(
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
            let [along, around] = soft.surface_tangents(point_in_sensor, outward);
            let drag_mm = (after[0] - before[0]) * along + (after[1] - before[1]) * around;
            at = soft.coordinates(&(point_in_sensor - drag_mm));
        }
        at
    }
}
