//! Force over depth of a press, sensor frame.

use fabkit_elastic::{PressOutcome, SoftStack, StrainTheory};
use fabkit_geometry::{Point3, Vector3};

use super::MarkerDisplacement;

/// State of a press at one depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressStep {
    /// Depth of the indenter, mm.
    pub depth_mm: f64,
    /// Displacement of the indenter along the surface at this depth, mm.
    pub shear_mm: f64,
    /// Force of the indenter on the sensor, sensor frame, N.
    pub force_n: Vector3<f64>,
    /// Moment of that force about the sensor's origin, N mm.
    pub moment_nmm: Vector3<f64>,
    /// Radius of the circle with the same area as the contact, mm.
    pub contact_radius_mm: f64,
    /// Area of contact of all indenters, mm2.
    pub contact_area_mm2: f64,
    /// Largest inward displacement of the surface, mm.
    pub max_indentation_mm: f64,
    /// Largest outward displacement beside the indenter, mm.
    pub bulge_mm: f64,
}

impl PressStep {
    pub(super) fn from_outcome(
        [depth_mm, shear_mm]: [f64; 2],
        outcome: &PressOutcome,
        soft: &SoftStack,
    ) -> Self {
        let pose = soft.sensor_from_stack;
        let force_n = pose.vector(outcome.force_n);
        let origin = pose.point(Point3::origin()).coords;
        Self {
            depth_mm,
            shear_mm,
            force_n,
            // The solver's moment is about the stack's origin; it is moved to the sensor's origin.
            moment_nmm: pose.vector(outcome.moment_nmm) + origin.cross(&force_n),
            contact_radius_mm: outcome.contact_radius_mm,
            contact_area_mm2: outcome.contact_area_mm2,
            max_indentation_mm: outcome.max_indentation_mm,
            bulge_mm: outcome.bulge_mm,
        }
    }
}

/// A press, solved at increasing depths.
#[derive(Debug)]
pub struct PressResult {
    /// Identifier of the press at its full depth, as for `depth` and `dataset`.
    pub id: String,
    /// Elastic theory.
    pub level: StrainTheory,
    /// Distance of the surface's nodes, mm.
    pub spacing_mm: f64,
    /// Coulomb's friction coefficient; `None` if nothing moved along the surface.
    pub friction: Option<f64>,
    /// States at increasing depth. The last one is at full depth, after the displacement along the surface if there is
    /// one.
    pub steps: Vec<PressStep>,
    /// Solution of the last state.
    pub outcome: PressOutcome,
    /// Markers at full depth.
    pub marks: Vec<MarkerDisplacement>,
    /// The soft layers.
    pub soft: SoftStack,
    /// Number of the surface's nodes.
    pub nodes: usize,
}

impl PressResult {
    /// Returns the last state.
    pub fn last(&self) -> Option<&PressStep> {
        self.steps.last()
    }

    /// Returns the slope of force over depth at full depth, N/mm: the difference quotient of the last two states
    /// without displacement along the surface. NaN without states.
    ///
    /// ```
    /// # let yaml = fabkit_designs::builtin_yaml("gelsight-like").ok_or("no such sensor")?;
    /// # let project = fabkit_fixtures::load("gelsight-like.yaml", yaml, &[])?;
    /// # use fabkit_scene::press_simulation::{PressRequest, StrainTheory};
    /// let request = PressRequest {
    ///     indenter: "ball@0mm,0mm",
    ///     depth_mm: 0.4,
    ///     steps: 2,
    /// #     level: StrainTheory::Linear,
    /// #     shear_mm: [0.0; 2],
    /// #     friction: None,
    ///     spacing_mm: Some(0.5),
    /// #     resources: 1.into(),
    /// };
    /// let pressed = request.run(&project)?;
    /// let [half, full] = [&pressed.steps[0], &pressed.steps[1]];
    /// let slope_n_mm = (full.force_n.norm() - half.force_n.norm()) / (full.depth_mm - half.depth_mm);
    /// assert!((pressed.stiffness_n_mm() - slope_n_mm).abs() < 1e-9);
    /// // A ball's contact grows, so the last part of the way is the stiffest.
    /// assert!(pressed.stiffness_n_mm() > full.force_n.norm() / full.depth_mm);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn stiffness_n_mm(&self) -> f64 {
        let straight: Vec<&PressStep> =
            self.steps.iter().filter(|step| step.shear_mm == 0.0).collect();
        let at = |i: usize| straight.get(i).map(|step| (step.depth_mm, step.force_n.norm()));
        // With a single state, the undeformed surface (no depth, no force) is the other point.
        let [before, last] = [2, 1].map(|back| straight.len().checked_sub(back).and_then(at));
        let (depth_mm, force_n) = before.unwrap_or((0.0, 0.0));
        last.map_or(f64::NAN, |(last_mm, last_n)| (last_n - force_n) / (last_mm - depth_mm))
    }

    /// Returns a warning if the depth exceeds the range of small strain.
    pub fn warning(&self) -> Option<String> {
        let (limit_mm, strain) = self.soft.small_strain_mm();
        let depth_mm = self.last().map_or(0.0, |step| step.depth_mm);
        // Large strain has no such limit.
        (self.level == StrainTheory::Linear && depth_mm > limit_mm).then(|| {
            format!(
                "{depth_mm} mm is more than {:.0} % of the soft thickness, {limit_mm:.2} mm: at large strain forces may be \
                 more than 10 % lower",
                100.0 * strain
            )
        })
    }

    /// Returns the force at full depth for the lowest and the highest known moduli, N. All moduli scale together, so
    /// the force scales with them.
    pub fn force_range_n(&self) -> [f64; 2] {
        let force_n = self.last().map_or(f64::NAN, |step| step.force_n.norm());
        // The widest relative range over all layers bounds the force.
        let shares = self.soft.layers.iter().map(|layer| {
            layer.elasticity.young_range_mpa.map(|young_mpa| young_mpa / layer.elasticity.young_mpa)
        });
        let [low, high] = shares.fold([f64::INFINITY, 0.0], |[low, high], [least, most]| {
            [f64::min(low, least), f64::max(high, most)]
        });
        [low * force_n, high * force_n]
    }
}
