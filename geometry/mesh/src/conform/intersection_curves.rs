//! Intersection curves of a tool's surface with the base: closed curves, sampled on both exactly.

use std::ops::Range;

use fabkit_geometry::{CompiledSolid, Crossing, Point3, Pose, Ray, Scratch, Vector3};

use super::Feature;
use crate::tessellate::cos_sin_of_turn;

/// Smallest distance of a curve from the ends of the stroke it lies on, mm.
const CLEAR_MM: f64 = 1e-4;

/// Closed curve around the tool, point by point in azimuth.
pub(super) struct Curve {
    /// Index of the tool's stroke that it lies on.
    pub stroke: usize,
    /// Points in the base's frame, mm.
    pub in_base: Vec<[f64; 3]>,
    /// Same points in the tool's frame, mm.
    pub in_tool: Vec<[f64; 3]>,
    /// Leaf and face of the base.
    pub face: [u32; 2],
    /// True if the profile, followed in its direction, enters the base here.
    pub entering: bool,
    /// Normal out of the base at the first point, base frame.
    pub normal: Vector3<f64>,
}

impl Curve {
    pub fn shortest_chord_mm(&self) -> f64 {
        let ends = self.in_tool.iter().zip(self.in_tool.iter().cycle().skip(1));
        let chord = |(p, q): (&[f64; 3], &[f64; 3])| (Point3::from(*p) - Point3::from(*q)).norm();
        ends.map(chord).fold(f64::MAX, f64::min)
    }
}

/// Computes all curves in the order of the tool's profile; `None` if a crossing does not continue around the tool on
/// one face.
///
/// For a feature that belongs to an operand of the base, only curves on the operand's own faces are returned.
pub(super) fn curves(feature: &Feature, base: &CompiledSolid) -> Option<Vec<Curve>> {
    let Feature { pin, base_from_tool, operand, .. } = feature;
    let leaves = operand.clone().unwrap_or(0..u32::MAX);
    let mut curves: Vec<Curve> = Vec::new();
    let (scratch, hits) = (Scratch::default(), Vec::new());
    let mut caster = Caster { base, base_from_tool, leaves, scratch, hits };
    for (index, stroke) in pin.strokes.iter().enumerate() {
        if !stroke.straight {
            continue;
        }
        let length_mm = (stroke.to[0] - stroke.from[0]).hypot(stroke.to[1] - stroke.from[1]);
        // The tool's own azimuths are used, so that the wall needs no extra vertices.
        let count = stroke.rings[0].len().max(stroke.rings[1].len());
        let first = curves.len();
        for k in 0..count {
            let [c, s] = cos_sin_of_turn(k, count);
            let at = |[r, z]: [f64; 2]| Point3::new(r * c, r * s, z);
            let (from, to) = (at(stroke.from), at(stroke.to));
            caster.cast(from, to);
            if k == 0 {
                curves.extend(caster.hits.iter().map(|hit| Curve {
                    stroke: index,
                    in_base: Vec::with_capacity(count),
                    in_tool: Vec::with_capacity(count),
                    face: [hit.leaf, hit.face],
                    entering: hit.entering,
                    normal: hit.normal,
                }));
                if curves.len() == first {
                    break;
                }
            }
            // Every azimuth must have the same number of crossings as the first one.
            let same = caster.hits.len() == curves.len() - first;
            if !same {
                return None;
            }
            for (hit, curve) in caster.hits.iter().zip(&mut curves[first..]) {
                let clear = CLEAR_MM / length_mm;
                if [hit.leaf, hit.face] != curve.face
                    || hit.entering != curve.entering
                    || !(clear..1.0 - clear).contains(&hit.t)
                {
                    return None;
                }
                let in_tool = from + hit.t * (to - from);
                curve.in_tool.push(in_tool.into());
                curve.in_base.push(base_from_tool.point(in_tool).into());
            }
        }
    }
    // Along the profile, entries and exits must alternate.
    let alternate = curves.windows(2).all(|w| w[0].entering != w[1].entering);
    (alternate && !curves.is_empty()).then_some(curves)
}

struct Caster<'a> {
    base: &'a CompiledSolid,
    base_from_tool: &'a Pose,
    leaves: Range<u32>,
    scratch: Scratch,
    hits: Vec<Crossing>,
}

impl Caster<'_> {
    /// Finds the crossings of the segment between two points of the tool's frame, ends included.
    fn cast(&mut self, from: Point3<f64>, to: Point3<f64>) {
        let origin = self.base_from_tool.point(from);
        let direction = self.base_from_tool.vector(to - from);
        self.base.crossings_into(&Ray { origin, direction }, &mut self.scratch, &mut self.hits);
        let counts = |hit: &Crossing| self.leaves.contains(&hit.leaf);
        self.hits.retain(|hit| (0.0..=1.0).contains(&hit.t) && counts(hit));
    }
}
