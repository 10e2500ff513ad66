//! Soft skins with liquid channels: the volume that a press displaces from each channel.
//!
//! The covers of channels are about as thick as they are wide, so that thin-plate theory does not apply. The drawn skin
//! is therefore solved in three dimensions with bricks between grid lines along the channels' faces.

mod columns;
mod contact;
mod outcome;
mod skin_model;

use fabkit_geometry::{LiquidSkin, Sensor, Vector3};
use nalgebra::DMatrix;

pub use self::columns::{AMBIENT_AIR_MPA, LiquidColumn};
use self::contact::LinearResponses;
pub use self::outcome::{ChannelOutcome, LiquidOutcome, SkinNode};
use self::skin_model::SkinModel;
use crate::slab::{Slab, SlabField};
use crate::{ElasticError, Indenter, SoftError, SoftLayer};

/// Maximum number of surface nodes that an indenter may touch.
const MOST_TOUCHED: usize = 600;

/// A drawn skin as a factorised slab of bricks.
///
/// ```
/// # use fabkit_geometry::{Angle, Assembly, Body, Elasticity, FixtureGrip, LiquidChannel, LiquidSkin};
/// # use fabkit_geometry::{MaterialProperties, NominalCamera, Path, Placement, PlaneSurface, Pose, Sensor, Solid};
/// # let camera = NominalCamera {
/// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
/// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
/// # };
/// # let outline = Path::rectangle([0.0; 2], [12.0; 2], 0.0);
/// # let grip = FixtureGrip {
/// #     outline: outline.clone(), top_z_mm: 0.0, bottom_z_mm: -9.0, clear_radius_mm: 8.0,
/// #     key: None, threads: Vec::new(),
/// # };
/// # let touch = PlaneSurface { outline, top_z_mm: 3.0, foot_z_mm: 0.0, max_indentation_mm: 1.0, grip };
/// # let elasticity = Some(Elasticity {
/// #     young_mpa: 0.2, young_range_mpa: [0.1, 0.3], poissons_ratio: 0.45, friction: None, source: String::new(),
/// # });
/// # let liquid = Solid::cuboid(12.0, 2.0, 1.0).at_z(1.0);
/// # let mut skin = Body::cast("skin", "", Solid::cuboid(12.0, 12.0, 3.0).minus(liquid.clone()))
/// #     .placed([Placement::in_place(Assembly::sensor())]);
/// # skin.substance = MaterialProperties { elasticity, ..MaterialProperties::default() };
/// # let mut sensor = Sensor::new("skin", "A skin", "", camera, [skin]);
/// # let channel = LiquidChannel {
/// #     name: "middle".to_owned(), liquid, width_mm: 2.0, height_mm: 1.0, cover_mm: 1.0,
/// #     column_mm2: 0.5, column_mm: 20.0, air_mm3: 10.0,
/// # };
/// # sensor.liquid = Some(LiquidSkin {
/// #     touch: touch.into(), window_mm: [12.0; 2], levels_mm: vec![0.0, 1.0, 2.0, 3.0], channels: vec![channel],
/// # });
/// use fabkit_elastic::{BallIndenter, LiquidStack};
/// use fabkit_geometry::Point3;
///
/// // A skin of 3 mm over a window of 12 x 12 mm, with a channel of 2 x 1 mm along x in it.
/// let stack = LiquidStack::from_sensor(&sensor, 1.0)?;
/// // A ball of radius 4 mm whose lowest point is 0.2 mm below the skin's face, at z = 3 mm.
/// let ball = BallIndenter::new(Point3::new(0.0, 0.0, 6.8), 4.0)?;
/// let outcome = stack.prepare(&ball)?.press(&ball)?;
/// // Liquid is squeezed out into its column, and the air ahead of it pushes back.
/// let channel = &outcome.channels[0];
/// assert!(channel.volume_mm3 > 0.0 && channel.pressure_mpa > 0.0);
/// assert!((channel.column_displacement_mm - channel.volume_mm3 / 0.5).abs() < 1e-12);
/// # Ok::<(), fabkit_elastic::SoftError>(())
/// ```
#[derive(Debug)]
pub struct LiquidStack {
    /// Soft layers from the touched surface inwards, with their largest thickness.
    pub layers: Vec<SoftLayer>,
    /// Simplifications, in words.
    pub simplifications: Vec<String>,
    skin: LiquidSkin,
    slab: Slab,
    columns: Vec<LiquidColumn>,
    /// Grid lines along x and y of the touched surface's nodes.
    surface: Vec<[usize; 2]>,
    /// Pairs of nodes above and below each channel.
    faces: Vec<Vec<[usize; 2]>>,
}

/// A skin's responses, solved for the nodes that an indenter may touch.
#[derive(Debug)]
pub struct LiquidSolver<'a> {
    stack: &'a LiquidStack,
    /// Surface nodes that may be touched.
    touched: Vec<usize>,
    responses: LinearResponses,
}

impl LiquidStack {
    /// Builds the skin of a sensor with nodes about `spacing_mm` apart.
    ///
    /// # Errors
    /// A sensor without such a skin or without soft material in it, or more nodes than fit.
    pub fn from_sensor(sensor: &Sensor, spacing_mm: f64) -> Result<Self, SoftError> {
        let none = || SoftError::NothingSoft { sensor: sensor.name.clone() };
        let skin = sensor.liquid.as_ref().ok_or_else(none)?;
        let drawn = SkinModel::from_sensor(sensor, skin, spacing_mm)?;
        let layers = drawn.layers();
        if layers.is_empty() {
            return Err(none());
        }
        // Nodes on the window's border are fixed.
        let [half_x, half_y] = skin.window_mm.map(|width_mm| width_mm / 2.0 - 1e-6);
        let slab = Slab::new(
            drawn.lines_mm.clone(),
            skin.channels.len(),
            |at| drawn.cell(at),
            |place| place.x.abs() >= half_x || place.y.abs() >= half_y,
        )?;
        let columns = skin
            .channels
            .iter()
            .map(|channel| LiquidColumn { area_mm2: channel.column_mm2, air_mm3: channel.air_mm3 });
        Ok(Self {
            layers,
            simplifications: drawn.describe_simplifications(skin),
            columns: columns.collect(),
            surface: drawn.surface(),
            faces: drawn.faces(&slab, skin.channels.len()),
            skin: skin.clone(),
            slab,
        })
    }

    /// Number of unknown displacements.
    pub fn unknowns(&self) -> usize {
        self.slab.unknowns()
    }

    /// Number of nodes of the touched surface.
    pub fn surface_nodes(&self) -> usize {
        self.surface.len()
    }

    /// Returns the drawn skin.
    pub fn skin(&self) -> &LiquidSkin {
        &self.skin
    }

    fn top(&self, [i, j]: [usize; 2]) -> [usize; 3] {
        [i, j, self.slab.lines_mm(2).len() - 1]
    }

    /// Computes the depth to which an indenter reaches below each node of the undeformed surface, mm; negative above
    /// it.
    fn indenter_depths_mm(&self, indenter: &(impl Indenter + ?Sized)) -> Vec<f64> {
        let lines_mm = self.slab.lines_mm(2);
        let reach_mm = lines_mm.last().unwrap_or(&0.0) - lines_mm.first().unwrap_or(&0.0);
        let up = Vector3::z();
        let gap =
            |at: &[usize; 2]| -indenter.gap_mm(&self.slab.place(self.top(*at)), &up, reach_mm);
        self.surface.iter().map(gap).collect()
    }

    /// Solves for all nodes that an indenter at its deepest pose may touch.
    pub fn prepare(
        &self,
        deepest: &(impl Indenter + ?Sized),
    ) -> Result<LiquidSolver<'_>, ElasticError> {
        let reached_mm = self.indenter_depths_mm(deepest);
        let most_mm = reached_mm.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if most_mm <= 0.0 {
            return Err(ElasticError::NoContact { gap_mm: -most_mm });
        }
        // Liquid displaced from elsewhere lifts the surface by less than the depth of the press.
        let touched: Vec<usize> =
            (0..reached_mm.len()).filter(|i| reached_mm[*i] > -0.3 * most_mm).collect();
        if touched.len() > MOST_TOUCHED {
            return Err(ElasticError::TooFine { unknowns: touched.len(), limit: MOST_TOUCHED });
        }
        let nodes: Vec<usize> =
            touched.iter().map(|i| self.slab.node(self.top(self.surface[*i]))).collect();
        let (count, channels) = (nodes.len(), self.columns.len());
        let mut answers = LinearResponses {
            compliance: DMatrix::zeros(count, count),
            squeezed: DMatrix::zeros(channels, count),
            growth: DMatrix::zeros(channels, channels),
        };
        self.slab.solve_unit_loads(&nodes, |which, field| {
            for channel in 0..channels {
                // The first fields belong to forces on nodes, the rest to pressures in channels.
                let grown_mm3 = self.slab.growth_mm3(channel, &field);
                match which.checked_sub(count) {
                    None => answers.squeezed[(channel, which)] = -grown_mm3,
                    Some(other) => answers.growth[(channel, other)] = grown_mm3,
                }
            }
            if which < count {
                for (row, node) in nodes.iter().enumerate() {
                    answers.compliance[(row, which)] = -self.slab.displacement_mm(&field, *node).z;
                }
            }
        });
        Ok(LiquidSolver { stack: self, touched, responses: answers })
    }
}

impl LiquidSolver<'_> {
    /// Presses an indenter straight down, without friction.
    pub fn press(&self, indenter: &(impl Indenter + ?Sized)) -> Result<LiquidOutcome, SoftError> {
        let stack = self.stack;
        let all_mm = stack.indenter_depths_mm(indenter);
        let most_mm = all_mm.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if most_mm <= 0.0 {
            return Err(ElasticError::NoContact { gap_mm: -most_mm }.into());
        }
        let reached_mm: Vec<f64> = self.touched.iter().map(|i| all_mm[*i]).collect();
        let balance = self.responses.solve_equilibrium(&reached_mm, &stack.columns)?;
        let node = |i: usize| stack.slab.node(stack.top(stack.surface[i]));
        let down: Vec<(usize, f64)> = self
            .touched
            .iter()
            .zip(&balance.forces_n)
            .map(|(i, force)| (node(*i), -force))
            .collect();
        // The responses cover touched nodes only; the whole field needs one more solution.
        let field: SlabField = stack.slab.solve(&down, balance.pressures_mpa.as_slice());
        let touching: Vec<(usize, f64)> = self
            .touched
            .iter()
            .zip(&balance.forces_n)
            .filter(|(_, force)| **force > 0.0)
            .map(|(i, force)| (*i, *force))
            .collect();
        LiquidOutcome::new(stack, &balance, &touching, field)
    }
}
