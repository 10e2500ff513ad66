//! Patch that closes a base's mesh up to a curve.

use fabkit_geometry::{Point3, Vector3};

use super::base_mesh::BaseMesh;
use super::cavity::{Candidate, Cavity};
use super::curvature::compute_curvatures;
use super::fill::Fill;
use super::intersection_curves::Curve;
use super::measure::DeviationCheck;
use super::{Base, Feature};

/// Smallest sine of the angle between a tool's axis and a surface; surfaces met at a flatter angle are left to the
/// kernel.
const LEAST_SINE: f64 = 0.2;

/// Cavity with its fill.
pub(super) struct Patch {
    pub cavity: Cavity,
    pub fill: Fill,
    /// Face number of the new triangles.
    pub face: u32,
}

impl Patch {
    /// Returns the indices of the curve's points in the direction that has the fill on its left.
    pub fn curve_order(&self, count: usize) -> impl Iterator<Item = usize> + use<> {
        curve_order(count, self.cavity.facing)
    }
}

fn curve_order(count: usize, facing: f64) -> impl Iterator<Item = usize> {
    (0..count).map(move |k| if facing > 0.0 { count - 1 - k } else { k })
}

/// One curve of one feature on the base.
pub(super) struct CurveOnBase<'a> {
    pub base: &'a Base<'a>,
    pub feature: &'a Feature,
    pub curve: &'a Curve,
    pub tolerance_mm: f64,
}

impl CurveOnBase<'_> {
    /// Computes the patch. The cavity's triangles get the mark `stamp`. `None` if they do not form a simple hole in one
    /// face, or if the fill deviates too far from the face.
    pub fn patch(
        &self,
        sheet: &mut BaseMesh,
        candidates: &[Candidate],
        clear_mm: f64,
        stamp: u32,
    ) -> Option<Patch> {
        let Self { base, feature, curve, tolerance_mm } = *self;
        let [leaf, number] = curve.face;
        let face = base.first_faces[leaf as usize] + number;
        let axis = feature.base_from_tool.vector(Vector3::z());
        let sine = axis.dot(&curve.normal);
        if sine.abs() < LEAST_SINE {
            return None;
        }
        let facing = sine.signum();
        let cavity = Cavity::new(sheet, candidates, curve, face, facing, clear_mm, stamp)?;

        // All points in space, and projected along the tool's axis as seen from the side that the face looks to.
        let tool_from_base = feature.base_from_tool.inverse();
        let mut points: Vec<[f64; 3]> = Vec::new();
        let mut flat: Vec<[f64; 2]> = Vec::new();
        let mut loops = Vec::with_capacity(cavity.loops.len() + 1);
        for chain in &cavity.loops {
            let first = points.len();
            for &edge in chain {
                let point = sheet.points[sheet.from(edge) as usize];
                let in_tool = tool_from_base.point(Point3::from(point));
                points.push(point);
                flat.push([facing * in_tool.x, in_tool.y]);
            }
            loops.push(first..points.len());
        }
        let first = points.len();
        for k in curve_order(curve.in_base.len(), facing) {
            points.push(curve.in_base[k]);
            flat.push([facing * curve.in_tool[k][0], curve.in_tool[k][1]]);
        }
        loops.push(first..points.len());

        let leaf = &base.body.leaves()[leaf as usize];
        // The curvature at one point of the curve serves for the whole patch; the result is measured below.
        let bend = compute_curvatures(leaf, number, Point3::from(curve.in_base[0]), curve.normal);
        let scaled: Vec<[f64; 2]> = points.iter().map(|&p| bend.scaled(p)).collect();
        let fill = Fill::new(&flat, &scaled, &loops)?;
        let measure = DeviationCheck::new(leaf, number, tolerance_mm)?;
        let corners = |t: &[u32; 3]| t.map(|v| points[v as usize]);
        let holds = fill.triangles.iter().all(|t| measure.is_within_tolerance(corners(t)));
        holds.then_some(Patch { cavity, fill, face })
    }
}
