//! Force by depth, in the sensor's frame.

use fabkit_elastic::{Level, Outcome, SoftStack};
use fabkit_geometry::{Point3, Vector3};

use super::Moved;

/// One depth of a press.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// How deep the presser stands, mm.
    pub depth_mm: f64,
    /// How far it has moved along the surface since it stands there, mm.
    pub shear_mm: f64,
    /// Of the presser on the sensor, sensor frame, N.
    pub force_n: Vector3<f64>,
    /// The same about the sensor's origin, N mm.
    pub moment_nmm: Vector3<f64>,
    /// Of the circle that has the contact's area, mm.
    pub contact_radius_mm: f64,
    /// Of all that touches, mm2.
    pub contact_area_mm2: f64,
    /// How far the surface moves in, at most, mm.
    pub max_indentation_mm: f64,
    /// How far it moves out beside the presser, at most, mm.
    pub bulge_mm: f64,
}

impl Step {
    pub(super) fn of([depth_mm, shear_mm]: [f64; 2], outcome: &Outcome, soft: &SoftStack) -> Self {
        let pose = soft.sensor_from_stack;
        let force_n = pose.vector(outcome.force_n);
        let origin = pose.point(Point3::origin()).coords;
        Self {
            depth_mm,
            shear_mm,
            force_n,
            moment_nmm: pose.vector(outcome.moment_nmm) + origin.cross(&force_n),
            contact_radius_mm: outcome.contact_radius_mm,
            contact_area_mm2: outcome.contact_area_mm2,
            max_indentation_mm: outcome.max_indentation_mm,
            bulge_mm: outcome.bulge_mm,
        }
    }
}

/// A press with the way to it.
#[derive(Debug)]
pub struct Pressed {
    /// The press at its full depth, as `depth` and `dataset` name it.
    pub id: String,
    /// By which theory.
    pub level: Level,
    /// Distance of the surface's nodes, mm.
    pub spacing_mm: f64,
    /// Coulomb's coefficient, where it moved along the surface.
    pub friction: Option<f64>,
    /// By depth; the last one at its full depth, and after its way along the surface.
    pub steps: Vec<Step>,
    /// At full depth.
    pub outcome: Outcome,
    /// What the camera follows, at full depth.
    pub marks: Vec<Moved>,
    /// What was pressed.
    pub soft: SoftStack,
    /// Nodes of the surface.
    pub nodes: usize,
}

impl Pressed {
    /// At full depth.
    pub fn last(&self) -> Option<&Step> {
        self.steps.last()
    }

    /// How force grows with depth at full depth, N/mm.
    pub fn stiffness_n_mm(&self) -> f64 {
        let straight: Vec<&Step> = self.steps.iter().filter(|step| step.shear_mm == 0.0).collect();
        let at = |i: usize| straight.get(i).map(|step| (step.depth_mm, step.force_n.norm()));
        let [before, last] = [2, 1].map(|back| straight.len().checked_sub(back).and_then(at));
        let (depth_mm, force_n) = before.unwrap_or((0.0, 0.0));
        last.map_or(f64::NAN, |(last_mm, last_n)| (last_n - force_n) / (last_mm - depth_mm))
    }

    /// What is doubtful about small strain at this depth, in words.
    pub fn warning(&self) -> Option<String> {
        let (limit_mm, strain) = self.soft.small_strain_mm();
        let depth_mm = self.last().map_or(0.0, |step| step.depth_mm);
        (self.level == Level::Linear && depth_mm > limit_mm).then(|| {
            format!(
                "{depth_mm} mm is more than {:.0} % of what gives way, {limit_mm:.2} mm: at large strain forces may be \
                 more than 10 % lower",
                100.0 * strain
            )
        })
    }

    /// The forces for the least and the most that is known of the moduli: all of them scale together, N.
    pub fn force_range_n(&self) -> [f64; 2] {
        let force_n = self.last().map_or(f64::NAN, |step| step.force_n.norm());
        let shares = self.soft.layers.iter().map(|layer| {
            layer.elasticity.young_range_mpa.map(|young_mpa| young_mpa / layer.elasticity.young_mpa)
        });
        let [low, high] = shares.fold([f64::INFINITY, 0.0], |[low, high], [least, most]| {
            [f64::min(low, least), f64::max(high, most)]
        });
        [low * force_n, high * force_n]
    }
}
