//! Result of a press on a skin with liquid channels.

use std::f64::consts::PI;

use fabkit_geometry::{Point3, Vector3};

use super::LiquidStack;
use super::contact::Equilibrium;
use crate::SoftError;
use crate::slab::SlabField;

/// Response of one channel.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelOutcome {
    /// Name in the drawing.
    pub name: String,
    /// Volume of liquid displaced out of the channel, mm3; negative where liquid is drawn in.
    pub volume_mm3: f64,
    /// Displacement of the liquid column, away from the needle, mm.
    pub column_displacement_mm: f64,
    /// Gauge pressure of the liquid, MPa.
    pub pressure_mpa: f64,
    /// Largest approach of the channel's cover to its floor, mm.
    pub closure_mm: f64,
    /// Height of the channel, mm; it is closed when the cover approaches by as much.
    pub height_mm: f64,
}

/// A deformed skin, in the sensor frame.
#[derive(Clone, Debug)]
pub struct LiquidOutcome {
    /// Force of the indenter on the skin, N.
    pub force_n: Vector3<f64>,
    /// Moment of that force about the sensor's origin, N mm.
    pub moment_nmm: Vector3<f64>,
    /// Area of all nodes in contact, mm2.
    pub contact_area_mm2: f64,
    /// Radius of the circle with this area, mm.
    pub contact_radius_mm: f64,
    /// Largest inward displacement of the surface, mm.
    pub max_indentation_mm: f64,
    /// Largest outward displacement of the surface, mm.
    pub bulge_mm: f64,
    /// Largest downward displacement of the underside, mm.
    pub sag_mm: f64,
    /// Channels in the drawing's order.
    pub channels: Vec<ChannelOutcome>,
    /// Surface nodes in contact, with their forces, N.
    touching: Vec<(usize, f64)>,
    field: SlabField,
}

/// A node of the skin's faces, in the sensor frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinNode {
    /// Undeformed position, mm.
    pub place_mm: Vector3<f64>,
    /// Normal out of the skin.
    pub outward: Vector3<f64>,
    /// Displacement, mm.
    pub displacement_mm: Vector3<f64>,
    /// Contact pressure, MPa.
    pub pressure_mpa: f64,
    /// Area that the node stands for, mm2.
    pub area_mm2: f64,
}

impl LiquidOutcome {
    /// Evaluates a press from its balanced forces and pressures. Fails if a channel is pressed shut.
    pub(super) fn new(
        stack: &LiquidStack,
        balance: &Equilibrium,
        touching: &[(usize, f64)],
        field: SlabField,
    ) -> Result<Self, SoftError> {
        let (mut force_n, mut moment_nmm, mut area_mm2) = (Vector3::zeros(), Vector3::zeros(), 0.0);
        for (i, n) in touching {
            let at = stack.top(stack.surface[*i]);
            let down = Vector3::new(0.0, 0.0, -n);
            force_n += down;
            moment_nmm += stack.slab.place(at).coords.cross(&down);
            area_mm2 += area_around_mm2(stack, at);
        }
        let moved = |at: [usize; 3]| stack.slab.displacement_mm(&field, stack.slab.node(at)).z;
        let top = stack.surface.iter().map(|at| moved(stack.top(*at)));
        let [lowest, highest] =
            top.fold([0.0, 0.0], |[low, high]: [f64; 2], z| [low.min(z), high.max(z)]);
        let under = stack.surface.iter().map(|[i, j]| moved([*i, *j, 0]));
        let sags_mm = -under.fold(0.0, f64::min);
        let channels = stack.skin.channels.iter().zip(&stack.faces).zip(&stack.columns).enumerate();
        let channels = channels.map(|(c, ((channel, faces), column))| {
            // Positive where the cover approaches the floor.
            let closes = |[above, below]: &[usize; 2]| {
                let z = |node| stack.slab.displacement_mm(&field, node).z;
                z(*below) - z(*above)
            };
            let volume_mm3 = balance.squeezed_mm3[c];
            ChannelOutcome {
                name: channel.name.clone(),
                volume_mm3,
                column_displacement_mm: volume_mm3 / column.area_mm2,
                pressure_mpa: balance.pressures_mpa[c],
                closure_mm: faces.iter().map(closes).fold(0.0, f64::max),
                height_mm: channel.height_mm,
            }
        });
        let channels: Vec<ChannelOutcome> = channels.collect();
        if let Some(shut) = channels.iter().find(|channel| channel.closure_mm >= channel.height_mm)
        {
            return Err(SoftError::ChannelClosed {
                channel: shut.name.clone(),
                closes_mm: shut.closure_mm,
                height_mm: shut.height_mm,
            });
        }
        Ok(Self {
            force_n,
            moment_nmm,
            contact_area_mm2: area_mm2,
            contact_radius_mm: (area_mm2 / PI).sqrt(),
            max_indentation_mm: -lowest,
            bulge_mm: highest,
            sag_mm: sags_mm,
            channels,
            touching: touching.to_vec(),
            field,
        })
    }

    /// Returns the displacement at a point of the skin, mm, in the sensor frame, interpolated trilinearly between
    /// nodes. Points beside or below the skin move like its nearest point.
    pub fn displacement_mm(&self, stack: &LiquidStack, place: &Point3<f64>) -> Vector3<f64> {
        let axes = [0, 1, 2].map(|axis: usize| between(stack.slab.lines_mm(axis), place[axis]));
        let mut moved = Vector3::zeros();
        for corner in 0..8_usize {
            let (mut at, mut weight) = ([0; 3], 1.0);
            for axis in 0..3 {
                let (line, share) = axes[axis];
                let is_upper = corner >> axis & 1 == 1;
                at[axis] = line + usize::from(is_upper);
                weight *= if is_upper { share } else { 1.0 - share };
            }
            moved += weight * stack.slab.displacement_mm(&self.field, stack.slab.node(at));
        }
        moved
    }

    /// Returns the nodes of the touched surface, then those of the underside below them.
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
    /// // A ball presses a skin of 3 mm with a channel in it.
    /// let stack = LiquidStack::from_sensor(&sensor, 1.0)?;
    /// let ball = BallIndenter::new(Point3::new(0.0, 0.0, 6.8), 4.0)?;
    /// let outcome = stack.prepare(&ball)?.press(&ball)?;
    /// // Pressures over areas make up the force; first come the nodes of the touched face, then those below them.
    /// let nodes = outcome.nodes(&stack);
    /// let sum_n: f64 = nodes.iter().map(|node| node.pressure_mpa * node.area_mm2).sum();
    /// assert!((sum_n + outcome.force_n.z).abs() < 1e-9);
    /// assert_eq!((nodes[0].outward.z, nodes[stack.surface_nodes()].outward.z), (1.0, -1.0));
    /// # Ok::<(), fabkit_elastic::SoftError>(())
    /// ```
    pub fn nodes(&self, stack: &LiquidStack) -> Vec<SkinNode> {
        let node = |at: [usize; 3], outward: Vector3<f64>| SkinNode {
            place_mm: stack.slab.place(at).coords,
            outward,
            displacement_mm: stack.slab.displacement_mm(&self.field, stack.slab.node(at)),
            pressure_mpa: 0.0,
            area_mm2: area_around_mm2(stack, at),
        };
        let top = stack.surface.iter().map(|at| node(stack.top(*at), Vector3::z()));
        let under = stack.surface.iter().map(|[i, j]| node([*i, *j, 0], -Vector3::z()));
        let mut nodes: Vec<SkinNode> = top.chain(under).collect();
        for (i, force_n) in &self.touching {
            nodes[*i].pressure_mpa = force_n / nodes[*i].area_mm2;
        }
        nodes
    }
}

/// Horizontal area that a node stands for, mm2.
fn area_around_mm2(stack: &LiquidStack, at: [usize; 3]) -> f64 {
    node_width_mm(stack.slab.lines_mm(0), at[0]) * node_width_mm(stack.slab.lines_mm(1), at[1])
}

/// Half the distance between the neighbours of a grid line, mm.
fn node_width_mm(lines_mm: &[f64], at: usize) -> f64 {
    let before = lines_mm[at.saturating_sub(1)];
    let after = lines_mm[(at + 1).min(lines_mm.len() - 1)];
    (after - before) / 2.0
}

/// Returns the grid line before a position and the fraction of the way to the next one.
fn between(lines_mm: &[f64], mm: f64) -> (usize, f64) {
    let last = lines_mm.len().saturating_sub(2);
    let line = lines_mm.partition_point(|line| *line <= mm).saturating_sub(1).min(last);
    let share = (mm - lines_mm[line]) / (lines_mm[line + 1] - lines_mm[line]);
    (line, share.clamp(0.0, 1.0))
}
