//! What a press on a skin with liquid does.

use std::f64::consts::PI;

use fabkit_geometry::{Point3, Vector3};

use super::LiquidStack;
use super::contact::Balance;
use crate::SoftError;
use crate::slab::SlabField;

/// What one channel does.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelMoved {
    /// As the drawing calls it.
    pub name: String,
    /// Liquid that is squeezed out of it, mm3; negative where it is drawn in.
    pub volume_mm3: f64,
    /// How far its column moves, away from the needle, mm.
    pub column_moves_mm: f64,
    /// In its liquid, above that of the air around, MPa.
    pub pressure_mpa: f64,
    /// How far its cover comes down onto its floor, at most, mm.
    pub closes_mm: f64,
    /// Its height, mm: what it can close by.
    pub height_mm: f64,
}

/// A skin that has given way, sensor frame.
#[derive(Clone, Debug)]
pub struct LiquidOutcome {
    /// Of the presser on the skin, N.
    pub force_n: Vector3<f64>,
    /// The same about the sensor's origin, N mm.
    pub moment_nmm: Vector3<f64>,
    /// Of all that touches, mm2.
    pub contact_area_mm2: f64,
    /// Of the circle that has this area, mm.
    pub contact_radius_mm: f64,
    /// How far the surface moves in, at most, mm.
    pub max_indentation_mm: f64,
    /// How far it moves out, at most, mm.
    pub bulge_mm: f64,
    /// How far the underside moves down, at most, mm.
    pub sags_mm: f64,
    /// Each channel, in the drawing's order.
    pub channels: Vec<ChannelMoved>,
    /// Of the surface's nodes, those that are touched, and with what force, N.
    touching: Vec<(usize, f64)>,
    field: SlabField,
}

/// A node of the skin's faces, sensor frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinNode {
    /// Where it is at rest, mm.
    pub place_mm: Vector3<f64>,
    /// Out of the skin.
    pub outward: Vector3<f64>,
    /// How far it moves, mm.
    pub displacement_mm: Vector3<f64>,
    /// What the presser pushes it with, MPa.
    pub pressure_mpa: f64,
    /// What area it stands for, mm2.
    pub area_mm2: f64,
}

impl LiquidOutcome {
    pub(super) fn new(
        stack: &LiquidStack,
        balance: &Balance,
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
            let closes = |[above, below]: &[usize; 2]| {
                let z = |node| stack.slab.displacement_mm(&field, node).z;
                z(*below) - z(*above)
            };
            let volume_mm3 = balance.squeezed_mm3[c];
            ChannelMoved {
                name: channel.name.clone(),
                volume_mm3,
                column_moves_mm: volume_mm3 / column.area_mm2,
                pressure_mpa: balance.pressures_mpa[c],
                closes_mm: faces.iter().map(closes).fold(0.0, f64::max),
                height_mm: channel.height_mm,
            }
        });
        let channels: Vec<ChannelMoved> = channels.collect();
        if let Some(shut) = channels.iter().find(|channel| channel.closes_mm >= channel.height_mm) {
            return Err(SoftError::Shut {
                channel: shut.name.clone(),
                closes_mm: shut.closes_mm,
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
            sags_mm,
            channels,
            touching: touching.to_vec(),
            field,
        })
    }

    /// How far a place of the skin moves, mm, sensor frame: between nodes in proportion. Places beside or below the
    /// skin move as its nearest place does.
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

    /// The nodes of the touched surface, then those of the underside below them.
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

/// What area a node stands for, seen from above, mm2.
fn area_around_mm2(stack: &LiquidStack, at: [usize; 3]) -> f64 {
    around_mm(stack.slab.lines_mm(0), at[0]) * around_mm(stack.slab.lines_mm(1), at[1])
}

/// Half of the ways to the lines beside a line, mm.
fn around_mm(lines_mm: &[f64], at: usize) -> f64 {
    let before = lines_mm[at.saturating_sub(1)];
    let after = lines_mm[(at + 1).min(lines_mm.len() - 1)];
    (after - before) / 2.0
}

/// The line before a place, and how much of the way to the next one it has gone.
fn between(lines_mm: &[f64], mm: f64) -> (usize, f64) {
    let last = lines_mm.len().saturating_sub(2);
    let line = lines_mm.partition_point(|line| *line <= mm).saturating_sub(1).min(last);
    let share = (mm - lines_mm[line]) / (lines_mm[line + 1] - lines_mm[line]);
    (line, share.clamp(0.0, 1.0))
}
