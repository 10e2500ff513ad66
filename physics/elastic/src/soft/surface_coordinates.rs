//! Surface coordinates of a sensor and mesh density of its solver.

use std::f64::consts::TAU;

use fabkit_geometry::{Point3, Vector3};

use super::{SoftError, SoftStack};
use crate::SolverResources;
use crate::{ElasticStack, MeshDensity};

/// Parametrisation of a sensor's surface.
#[derive(Clone, Copy, Debug)]
pub(super) enum SurfaceCoordinates {
    /// Direction from a centre, up to the polar angle at which the layers end.
    Dome { centre: Point3<f64>, end_rad: f64, equator_radius_mm: f64 },
    /// Distance from the middle of a disc.
    Disc { radius_mm: f64 },
}

impl SoftStack {
    /// Returns s and azimuth, rad, of a point of the undeformed surface, sensor frame, mm; s is above 1 beyond the
    /// layers' end.
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
    /// use fabkit_elastic::SoftStack;
    /// use fabkit_geometry::Point3;
    ///
    /// // 3 mm of gel: the disc that stands for the pad is ten times as wide, around the middle.
    /// let soft = SoftStack::at_tip(&sensor)?;
    /// assert!((soft.disc_radius_mm().unwrap() - 30.0).abs() < 1e-9);
    /// let [s, azimuth] = soft.coordinates(&Point3::new(0.0, 3.0, 3.0));
    /// assert!((s - 0.1).abs() < 1e-9 && (azimuth.to_degrees() - 90.0).abs() < 1e-9);
    /// # Ok::<(), fabkit_elastic::SoftError>(())
    /// ```
    #[inline]
    pub fn coordinates(&self, point_in_sensor: &Point3<f64>) -> [f64; 2] {
        match &self.plan {
            SurfaceCoordinates::Dome { centre, end_rad, .. } => {
                let out = point_in_sensor - centre;
                let polar = out.x.hypot(out.y).atan2(out.z);
                [polar / end_rad, out.y.atan2(out.x)]
            }
            SurfaceCoordinates::Disc { radius_mm } => {
                let middle = self.sensor_from_stack.translation_mm();
                let [x, y] = [point_in_sensor.x - middle[0], point_in_sensor.y - middle[1]];
                [x.hypot(y) / radius_mm, y.atan2(x)]
            }
        }
    }

    /// Builds the solver with surface nodes `spacing_mm` apart: everywhere on a dome; on a pad up to `reach_mm` from
    /// its middle and gradually coarser beyond, with at most `most_harmonics` harmonics of the azimuth.
    ///
    /// # Errors
    /// Errors of the solver.
    pub fn build_stack(
        &self,
        spacing_mm: f64,
        reach_mm: f64,
        most_harmonics: usize,
        resources: impl Into<SolverResources>,
    ) -> Result<ElasticStack, SoftError> {
        // Two nodes per wave: the Nyquist limit.
        let harmonics =
            |radius_mm: f64| (TAU * radius_mm / (2.0 * spacing_mm)).ceil().max(1.0) as usize;
        let division = match self.plan {
            SurfaceCoordinates::Dome { equator_radius_mm, .. } => {
                MeshDensity::uniform(spacing_mm, harmonics(equator_radius_mm))
            }
            SurfaceCoordinates::Disc { radius_mm } => {
                let reach_mm = reach_mm.min(radius_mm);
                let harmonics = harmonics(reach_mm).min(most_harmonics);
                MeshDensity::around_pole(spacing_mm, reach_mm, harmonics)
            }
        };
        Ok(ElasticStack::new(&self.body, &division, resources)?)
    }

    /// Returns a division that is fine around the axis, for axisymmetric presses.
    pub fn division_at_pole(&self, spacing_mm: f64, reach_mm: f64) -> MeshDensity {
        MeshDensity::around_pole(spacing_mm, reach_mm, 0)
    }

    /// Radius of the disc that stands for a pad, mm; `None` for a dome.
    pub fn disc_radius_mm(&self) -> Option<f64> {
        match self.plan {
            SurfaceCoordinates::Dome { .. } => None,
            SurfaceCoordinates::Disc { radius_mm } => Some(radius_mm),
        }
    }

    /// Returns two directions along the undeformed surface at one of its points: away from the pole, and
    /// counter-clockwise around it. At the pole they are x and y.
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
    /// use fabkit_elastic::SoftStack;
    /// use fabkit_geometry::{Point3, Vector3};
    ///
    /// // On the y axis of a pad, away from its middle is +y, and counter-clockwise is -x.
    /// let soft = SoftStack::at_tip(&sensor)?;
    /// let [along, around] = soft.surface_tangents(&Point3::new(0.0, 3.0, 3.0), &Vector3::z());
    /// assert!((along - Vector3::y()).norm() < 1e-12 && (around + Vector3::x()).norm() < 1e-12);
    /// # Ok::<(), fabkit_elastic::SoftError>(())
    /// ```
    pub fn surface_tangents(
        &self,
        point_in_sensor: &Point3<f64>,
        outward: &Vector3<f64>,
    ) -> [Vector3<f64>; 2] {
        let middle = self.sensor_from_stack.translation_mm();
        let out = Vector3::new(point_in_sensor.x - middle[0], point_in_sensor.y - middle[1], 0.0);
        // At the pole every direction leads away; x is chosen.
        let out = out.try_normalize(1e-9).unwrap_or_else(Vector3::x);
        let around = Vector3::z().cross(&out);
        [around.cross(outward), around]
    }
}
