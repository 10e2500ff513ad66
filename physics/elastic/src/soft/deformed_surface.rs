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
///
/// ```
/// # use fabkit_geometry::{Angle, Assembly, Body, Elasticity, FixtureGrip, MaterialProperties, NominalCamera};
/// # use fabkit_geometry::{Path, Placement, PlaneSurface, Pose, Sensor, Solid};
/// # let camera = NominalCamera {
/// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
/// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
/// # };
/// # let outline = Path::circle([0.0, 0.0], 15.0);
/// # let grip = FixtureGrip {
/// #     outline: outline.clone(), top_z_mm: 0.0, bottom_z_mm: -9.0, clear_radius_mm: 8.0,
/// #     key: None, threads: Vec::new(),
/// # };
/// # let touch = PlaneSurface { outline, top_z_mm: 3.0, foot_z_mm: 0.0, max_indentation_mm: 1.0, grip };
/// # let elasticity = Some(Elasticity {
/// #     young_mpa: 0.2, young_range_mpa: [0.1, 0.3], poissons_ratio: 0.49, friction: None, source: String::new(),
/// # });
/// # let mut gel = Body::cast("gel", "", Solid::cylinder(15.0, 3.0));
/// # gel.substance = MaterialProperties { elasticity, ..MaterialProperties::default() };
/// # let plate = Body::bought("plate", "", Solid::cylinder(15.0, 2.0).at_z(-2.0));
/// # let [gel, plate] = [gel, plate].map(|body| body.placed([Placement::in_place(Assembly::sensor())]));
/// # let mut sensor = Sensor::new("pad", "A pad", "", camera, [gel, plate]);
/// # sensor.touch = Some(touch.into());
/// use fabkit_elastic::{BallIndenter, DeformedSurface, Press, SoftStack};
/// use fabkit_geometry::{Point3, Vector3};
///
/// // 3 mm of gel, pressed 0.2 mm deep in its middle. The solver's frame is that of the disc.
/// let soft = SoftStack::at_tip(&sensor)?;
/// let stack = soft.build_stack(0.25, 2.0, 8, 1)?;
/// let ball = BallIndenter::new(Point3::new(0.0, 0.0, 9.0), 4.0)?;
/// let outcome = stack.press(&ball, &Press::along(-Vector3::z(), 0.2)?)?;
/// let surface = DeformedSurface::new(&stack, &outcome, None);
/// let outwards_mm = |x_mm| surface.outwards_mm(&soft, &Point3::new(x_mm, 0.0, 3.0), &Vector3::z());
/// assert!((outwards_mm(0.0) + 0.2).abs() < 0.01 && outwards_mm(3.0) > 0.0);
/// assert!(surface.pressure_mpa(&soft, &Point3::new(0.0, 0.0, 3.0), &Vector3::z()) > 0.0);
/// # Ok::<(), fabkit_elastic::SoftError>(())
/// ```
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
