//! Presses on a sensor's soft layers: forces, contact, and displacement of the surface.
//!
//! The layers are the design's layers below the surface, with the moduli of their materials. The indenter is the exact
//! solid of a fixture's press. [`fabkit_elastic`] solves the contact, at small strain unless large strain is requested.

mod contact;
mod contact_gap;
mod displacement_image;
mod document;
mod elastic_solver;
mod error;
mod files;
mod force_curve;
mod large_strain;
mod markers;
mod skin;

use fabkit_elastic::Press;
use fabkit_elastic::SolverResources;
use fabkit_fixtures::Project;

pub use contact::{ContactModel, ContactSolution, LinearOptions};
pub use contact_gap::ContactGap;
pub use displacement_image::draw_displacement;
pub use document::{press_document, soft_layers, solution_document, visible_solution_document};
pub use elastic_solver::ElasticSolver;
pub use error::PressingError;
pub use fabkit_elastic::{SoftLayer, StrainTheory};
pub use files::{curve_csv, curve_svg, press_arrays};
pub use force_curve::{PressResult, PressStep};
pub use markers::marks_document;
pub use markers::{MarkerDisplacement, farthest_marker};
pub use skin::with_indenters;
pub use skin::{
    SkinPressResult, SkinStep, press_skin, skin_arrays, skin_csv, skin_document, skin_svg,
};

/// Maximum number of steps of a force curve.
pub const MAX_STEPS: u32 = 200;
/// Number of steps of a displacement along the surface, which separate slip from stick.
pub(super) const SHEAR_STEPS: usize = 8;

/// Options of a press and of its discretisation.
///
/// ```
/// use fabkit_scene::press_simulation::{PressRequest, curve_csv};
/// # use fabkit_scene::press_simulation::StrainTheory;
///
/// # let yaml = fabkit_designs::builtin_yaml("gelsight-like").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("gelsight-like.yaml", yaml, &[])?;
/// let request = PressRequest {
///     indenter: "ball@2mm,-1mm",
///     depth_mm: 0.3,
///     steps: 3,
///     spacing_mm: Some(0.4),
/// #     level: StrainTheory::Linear,
/// #     shear_mm: [0.0; 2],
/// #     friction: None,
/// #     resources: 1.into(),
/// };
/// let pressed = request.run(&project)?;
/// // The ball pushes the pad down, towards -z, and the force grows with depth.
/// assert!(pressed.steps[2].force_n.z < pressed.steps[0].force_n.z && pressed.steps[0].force_n.z < 0.0);
/// // A line for each step, and a header.
/// assert_eq!(curve_csv(&pressed).lines().count(), 1 + 3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct PressRequest<'a> {
    /// Indenter and place without depth: `ball@30deg,120deg`, or `ball@2mm,-3mm` on a pad.
    pub indenter: &'a str,
    /// Depth along the surface's normal at that place, mm.
    pub depth_mm: f64,
    /// Elastic theory.
    pub level: StrainTheory,
    /// Number of equal depth steps of the force curve.
    pub steps: u32,
    /// Displacement of the indenter along the surface at full depth, mm: on a dome away from the tip and around it,
    /// counter-clockwise seen from the tip; on a pad along x and y.
    pub shear_mm: [f64; 2],
    /// Coulomb's friction coefficient for that displacement; `None` for that of the touched material.
    pub friction: Option<f64>,
    /// Distance of the surface's nodes, mm; `None` for a value derived from the surface and the press.
    pub spacing_mm: Option<f64>,
    /// Threads and memory of the setup. The result does not depend on them.
    pub resources: SolverResources,
}

impl PressRequest<'_> {
    /// Solves the press at increasing depths. The last solution is kept in full.
    ///
    /// # Errors
    /// [`PressingError`]: an unknown press, a sensor without soft layers, contact that does not converge.
    pub fn run(&self, project: &Project) -> Result<PressResult, PressingError> {
        self.check()?;
        if self.level == StrainTheory::Finite {
            return self.run_finite(project);
        }
        let finder = project.press_finder();
        let last = finder.press(&self.id(self.depth_mm))?;
        let sensor = &project.design.sensor;
        let touch = elastic_solver::touch(sensor)?;
        // The mesh is made for the full depth and serves all smaller depths as well.
        let ready =
            ElasticSolver::for_press(sensor, &last.bodies, self.spacing_mm, self.resources)?;
        let soft = &ready.soft;
        // Each depth is solved from scratch, so a step does not depend on earlier ones.
        let mut steps = Vec::new();
        let mut outcome = None;
        for i in 1..=self.steps {
            let depth_mm = self.depth_at(i);
            let press = finder.press(&self.id(depth_mm))?;
            let pressed = ready.press(&press.bodies, &Press::in_place())?;
            steps.push(PressStep::from_outcome([depth_mm, 0.0], &pressed, soft));
            outcome = Some(pressed);
        }
        let mut friction = None;
        if self.shear_mm != [0.0; 2] {
            let coefficient = ready.friction(self.friction)?;
            let place = contact::deepest_place(touch, &last.bodies)?;
            let way_mm = ready.surface_displacement(touch, &place, self.shear_mm);
            // The solver works in the frame of the stack.
            let way_mm = soft.sensor_from_stack.inverse().vector(way_mm);
            let press = Press::in_place().with_shear(coefficient, way_mm, SHEAR_STEPS)?;
            friction = Some(coefficient);
            let pressed = ready.press(&last.bodies, &press)?;
            steps.push(PressStep::from_outcome([self.depth_mm, way_mm.norm()], &pressed, soft));
            outcome = Some(pressed);
        }
        let outcome = outcome.ok_or_else(|| self.no_steps())?;
        let nodes = ready.stack.surface_nodes();
        let marks = markers::compute_displacements(sensor, touch, &ready.soft, &outcome);
        let spacing_mm = ready.spacing_mm;
        Ok(PressResult {
            id: last.id,
            level: StrainTheory::Linear,
            spacing_mm,
            friction,
            steps,
            outcome,
            marks,
            soft: ready.soft,
            nodes,
        })
    }

    /// Returns the press's identifier at a depth, as fixtures know it.
    fn id(&self, depth_mm: f64) -> String {
        format!("{},{depth_mm}mm", self.indenter)
    }

    /// Returns the depth of the i-th step, mm.
    fn depth_at(&self, i: u32) -> f64 {
        self.depth_mm * f64::from(i) / f64::from(self.steps)
    }

    pub(super) fn check(&self) -> Result<(), PressingError> {
        if !(1..=MAX_STEPS).contains(&self.steps) {
            return Err(self.no_steps());
        }
        Ok(())
    }

    pub(super) fn no_steps(&self) -> PressingError {
        let limit = format!("1 to {MAX_STEPS} steps");
        PressingError::Range { what: "steps", value: self.steps.to_string(), limit }
    }
}

/// Returns the threads of the current rayon pool, and the memory that the process may use.
pub fn resources() -> SolverResources {
    SolverResources {
        threads: rayon::current_num_threads(),
        memory_bytes: fabkit_files::memory::available_bytes(),
    }
}
