//! Search for all rays from a pupil through a point.

use fabkit_geometry::{Point3, Ray, Vector3};

use super::{SightLine, SightLineSolver, fibonacci_directions, newton, solve_sequence};
use crate::tile_tracing::RefractionSequence;

/// Number of start directions: 4.5 degrees from one to the next.
const START_DIRECTIONS: usize = 2048;

/// Angle below which two rays at the pupil are the same, rad.
const MIN_SEPARATION_RAD: f64 = 1e-7;

impl SightLineSolver<'_> {
    /// Finds all rays from a pupil through a point that a search from directions all around, 4.5 degrees apart, finds.
    /// The shortest path comes first; rays that something opaque hides are included ([`SightLine::hidden_by`]). The result
    /// is empty if no light leads from the point to the pupil. A ray past faces that appear smaller than 4.5 degrees,
    /// and are thus met by no start direction, may be missed. Points and paths are in the sensor frame, mm.
    ///
    /// A glass ball shows a point far behind it twice: through its middle, and past it.
    ///
    /// ```
    /// use fabkit_geometry::{Angle, Assembly, Body, OpticalClarity, NominalCamera, Placement, Point3, Pose, Sensor};
    /// use fabkit_geometry::{Solid, MaterialProperties};
    /// use fabkit_optics::{ViewStacks, OpticalStack};
    /// # let camera = NominalCamera {
    /// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
    /// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
    /// # };
    /// let mut ball = Body::bought("ball", "glass", Solid::sphere(2.0).at(0.0, 0.0, 6.0))
    ///     .with_clarity(OpticalClarity::Clear)
    ///     .placed([Placement::in_place(Assembly::sensor())]);
    /// ball.substance = MaterialProperties { refractive_index: Some(1.5), ..MaterialProperties::default() };
    /// let sights = ViewStacks::new(OpticalStack::from_sensor(&Sensor::new("marble", "A marble", "", camera, [ball]))?);
    /// let pupil = Point3::origin();
    /// // Beside the axis: upside down through the ball, and straight past its rim.
    /// let every = sights.sight_line_solver().find_all_sight_lines(&pupil, &Point3::new(14.0, 0.0, 30.0));
    /// assert!(every.iter().any(|sight| sight.direction.x < 0.0));
    /// assert!(every.iter().any(|sight| (sight.direction.x / sight.direction.z - 14.0 / 30.0).abs() < 1e-9));
    /// # Ok::<(), fabkit_optics::InvalidStack>(())
    /// ```
    pub fn find_all_sight_lines(
        &mut self,
        pupil: &Point3<f64>,
        place: &Point3<f64>,
    ) -> Vec<SightLine> {
        let straight = (place - pupil).try_normalize(0.0);
        let mut sights: Vec<SightLine> = Vec::new();
        for start in straight.into_iter().chain(fibonacci_directions(START_DIRECTIONS)) {
            let Some(direction) = self.solve_from(pupil, place, &start) else { continue };
            let is_known =
                |known: &SightLine| (known.direction - direction).norm() < MIN_SEPARATION_RAD;
            if sights.iter().any(is_known) {
                continue;
            }
            sights.extend(self.verify(pupil, place, &direction));
        }
        sights.sort_by(|a, b| a.way_mm.total_cmp(&b.way_mm));
        sights
    }

    /// Solves for the direction that a start leads to: past its own faces in closed form, or with traced rays.
    fn solve_from(
        &mut self,
        pupil: &Point3<f64>,
        place: &Point3<f64>,
        start: &Vector3<f64>,
    ) -> Option<Vector3<f64>> {
        let way_mm = self.closest_approach(pupil, place, start)?.way_mm;
        let ray = Ray { origin: *pupil, direction: *start };
        match RefractionSequence::from_ray(&mut self.clear, self.surfaces, &ray, way_mm) {
            Some(chain) => solve_sequence(&chain, pupil, place, start),
            None => {
                newton(*start, |d| self.closest_approach(pupil, place, d)).map(|(found, _)| found)
            }
        }
    }
}
