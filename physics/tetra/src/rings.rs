//! Triangulation of a surface of revolution by rings of nodes about the axis.

use std::f64::consts::TAU;

use fabkit_elastic::MeridianCurve;

use crate::mesh::{DomeNode, Face};

/// Sample points by which the length of the meridian is measured.
const LENGTH_STEPS: usize = 4000;
/// Height of an equilateral triangle over its side.
const HEIGHT: f64 = 0.866;
/// Minimum number of nodes of a ring.
const MIN_RING_NODES: usize = 5;

/// Triangulates a surface with edges about `edge_mm` long. Returns nodes by s and azimuth, triangles, and the nodes of
/// the rim in order.
pub(crate) fn triangulate(
    surface: &MeridianCurve,
    edge_mm: f64,
) -> (Vec<DomeNode>, Vec<Face>, Vec<u32>) {
    let lengths = arc_lengths(surface);
    let total_mm = lengths[LENGTH_STEPS];
    let rows = ((total_mm / (HEIGHT * edge_mm)).round() as usize).max(2);
    let mut nodes = vec![DomeNode { s: 0.0, azimuth: 0.0 }];
    let mut faces = Vec::new();
    let mut before = Ring { first: 0, count: 1, phase: 0.0 };
    for row in 1..=rows {
        let s = if row == rows {
            1.0
        } else {
            find_parameter(&lengths, total_mm * row as f64 / rows as f64)
        };
        let around_mm = TAU * surface.at(s)[0];
        let count = ((around_mm / edge_mm).round() as usize).max(MIN_RING_NODES);
        // Every other ring is turned by half a step, so that triangles are equilateral where neighbouring rings have
        // equal counts.
        let phase = if row % 2 == 1 { 0.5 / count as f64 } else { 0.0 };
        let ring = Ring { first: nodes.len() as u32, count, phase };
        nodes.extend((0..count).map(|i| DomeNode { s, azimuth: TAU * ring.turn(i) }));
        match before.count {
            1 => faces.extend((0..count).map(|i| [0, ring.node(i), ring.node(i + 1)])),
            _ => triangulate_strip(&before, &ring, &mut faces),
        }
        before = ring;
    }
    (nodes, faces, (0..before.count).map(|i| before.node(i)).collect())
}

/// Ring of evenly spaced nodes.
struct Ring {
    first: u32,
    count: usize,
    /// Azimuth of its first node, turns.
    phase: f64,
}

impl Ring {
    /// Returns the index of a node; continues beyond one turn.
    fn node(&self, i: usize) -> u32 {
        self.first + (i % self.count) as u32
    }

    /// Returns the azimuth of a node, turns; continues beyond one turn.
    fn turn(&self, i: usize) -> f64 {
        self.phase + i as f64 / self.count as f64
    }
}

/// Triangulates the strip between two rings: each triangle takes the nearer of the two next nodes.
fn triangulate_strip(inner: &Ring, outer: &Ring, faces: &mut Vec<Face>) {
    let (mut i, mut j) = (0, 0);
    // Starts at the outer node that is nearest to the first inner one.
    let skip = ((inner.phase - outer.phase) * outer.count as f64).round().max(0.0) as usize;
    while i < inner.count || j < outer.count {
        let (a, b) = (inner.node(i), outer.node(j + skip));
        let across_outer = (outer.turn(j + skip + 1) - inner.turn(i)).abs();
        let across_inner = (inner.turn(i + 1) - outer.turn(j + skip)).abs();
        let takes_outer = j < outer.count && (i == inner.count || across_outer <= across_inner);
        if takes_outer {
            faces.push([a, b, outer.node(j + skip + 1)]);
            j += 1;
        } else {
            faces.push([a, b, inner.node(i + 1)]);
            i += 1;
        }
    }
}

/// Returns the length of the meridian from the pole to each sample point.
fn arc_lengths(surface: &MeridianCurve) -> Vec<f64> {
    let mut lengths = vec![0.0];
    let mut before = surface.at(0.0);
    for i in 1..=LENGTH_STEPS {
        let here = surface.at(i as f64 / LENGTH_STEPS as f64);
        lengths.push(lengths[i - 1] + (here[0] - before[0]).hypot(here[1] - before[1]));
        before = here;
    }
    lengths
}

/// Returns the curve parameter at a length along the meridian.
fn find_parameter(lengths: &[f64], length_mm: f64) -> f64 {
    let i = lengths.partition_point(|&l| l <= length_mm).clamp(1, LENGTH_STEPS) - 1;
    let step_mm = lengths[i + 1] - lengths[i];
    let within = if step_mm > 0.0 { (length_mm - lengths[i]) / step_mm } else { 0.0 };
    (i as f64 + within) / LENGTH_STEPS as f64
}
