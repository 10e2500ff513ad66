//! Features of operands: meshes `A - (B - features)` without cutting A by a mesh full of features.
//!
//! The base is meshed as if there were no features, here `A - B`. A feature of B changes the base only where it
//! overlaps B, here by adding to it, provided that no other surface of the tree comes near that part: then every other
//! operand covers the part completely or not at all.

use fabkit_geometry::{Aabb, CompiledSolid, Point3, Pose, Ray, Solid, Vector3};

use super::cavity::Candidate;
use super::intersection_curves::Curve;
use super::nearby::CandidateGrid;
use super::{Base, Feature};
use crate::facets::Facets;

/// Tree with its features, and the surfaces of the tree without them.
pub(crate) struct FeatureTree {
    /// Exact solid with features.
    pub body: CompiledSolid,
    /// Triangles of all leaves of the base in their poses; the face number of each is the number of its leaf.
    pub leaves: Facets,
}

/// Part of a feature that changes the base, and the direction of the change.
pub(super) struct ChangedRange {
    /// True if it adds to the base, false if it cuts.
    pub adding: bool,
    /// Range of the relevant part of the tool along its axis, mm.
    pub z_mm: [f64; 2],
}

impl FeatureTree {
    /// Finds the leaves' triangles near each feature.
    pub(super) fn nearby(&self, boxes: Vec<Aabb>) -> CandidateGrid {
        let mut nearby = CandidateGrid::new(boxes);
        for (t, corners) in (0..).zip(&self.leaves.triangles) {
            let corner = |v: u32| {
                let point = Point3::from(self.leaves.vertices[v as usize]);
                Aabb { min: point, max: point }
            };
            let bounds = corners.map(corner).iter().fold(Aabb::nothing(), |all, b| all.hull(b));
            nearby.add(t, &bounds);
        }
        nearby
    }

    /// Returns the part of the feature that changes the base; `None` unless one curve alone describes the change.
    pub(super) fn find_changed_range(
        &self,
        base: &Base,
        feature: &Feature,
        curves: &[Curve],
        near: &[u32],
        tolerance_mm: f64,
    ) -> Option<ChangedRange> {
        // A feature with several curves, such as a through hole, changes both sides of a wall.
        let [curve] = curves else { return None };
        let operand = feature.operand.clone()?;
        if !crosses_once(base, feature, curve) {
            return None;
        }
        let span = self.effect(base, feature, curve)?;
        let tool_from_base = feature.base_from_tool.inverse();
        let own = curve.face[0];
        let is_free = |t: u32| {
            let leaf = self.leaves.faces[t as usize];
            // Beyond the curve the feature lies outside of its operand: only that operand's other surfaces could change
            // that.
            let z_mm = if operand.contains(&leaf) { super::EVERYWHERE } else { span.z_mm };
            let points = self.leaves.triangles[t as usize];
            let points = points.map(|v| self.leaves.vertices[v as usize]);
            let candidate = Candidate::new(t, points, &tool_from_base);
            // The surface that carries the curve may, and must, meet the tool.
            leaf == own || !candidate.reaches_into(&feature.pin, z_mm, tolerance_mm)
        };
        let planes =
            base.body.leaves().iter().filter(|l| matches!(l.primitive, Solid::HalfSpace(_)));
        let free = near.iter().all(|&t| is_free(t))
            && planes.into_iter().all(|l| on_one_side(feature, &l.body_from_leaf, tolerance_mm));
        free.then_some(span)
    }

    /// Determines the side of the curve on which the feature changes the base, by testing points on the tool's axis.
    fn effect(&self, base: &Base, feature: &Feature, curve: &Curve) -> Option<ChangedRange> {
        let (mut low, mut high) = (f64::MAX, f64::MIN);
        for point in &curve.in_tool {
            (low, high) = (low.min(point[2]), high.max(point[2]));
        }
        let strokes = &feature.pin.strokes;
        let (below, above) = (&strokes[..=curve.stroke], &strokes[curve.stroke..]);
        let bottom = below.iter().map(|s| s.z_mm[0]).fold(low, f64::min);
        let top = above.iter().map(|s| s.z_mm[1]).fold(high, f64::max);
        // Whether the feature changes the inside of the tree at a point of its axis, and in which direction.
        let changes = |z: f64| {
            let point = feature.base_from_tool.point(Point3::new(0.0, 0.0, z));
            let (with, without) = (self.body.contains(&point), base.body.contains(&point));
            (with != without).then_some(with)
        };
        let first = changes((bottom + low) / 2.0);
        let last = changes((top + high) / 2.0);
        let (adding, z_mm, starts_inside) = match (first, last) {
            (Some(adding), None) => (adding, [bottom, high], !curve.entering),
            (None, Some(adding)) => (adding, [low, top], curve.entering),
            _ => return None,
        };
        // Where the feature adds, the base was empty, and where it cuts, the base was solid.
        (starts_inside != adding).then_some(ChangedRange { adding, z_mm })
    }
}

/// Returns whether the surface that carries the curve meets the tool's profile nowhere else, in visible or hidden
/// parts. Tested along four meridians.
fn crosses_once(base: &Base, feature: &Feature, curve: &Curve) -> bool {
    let leaf = &base.body.leaves()[curve.face[0] as usize];
    let Ok(surface) = CompiledSolid::new(&leaf.primitive.clone().placed(leaf.body_from_leaf))
    else {
        return false;
    };
    let crossings = |[c, s]: [f64; 2]| -> usize {
        let at = |[r, z]: [f64; 2]| feature.base_from_tool.point(Point3::new(r * c, r * s, z));
        let along = |stroke: &super::revolved_tool::ToolStroke| {
            let (from, to) = (at(stroke.from), at(stroke.to));
            let hits = surface.crossings(&Ray { origin: from, direction: to - from });
            hits.iter().filter(|hit| (0.0..=1.0).contains(&hit.t)).count()
        };
        feature.pin.strokes.iter().map(along).sum()
    };
    [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]].into_iter().all(|d| crossings(d) == 1)
}

fn on_one_side(feature: &Feature, base_from_plane: &Pose, margin_mm: f64) -> bool {
    let plane_from_tool = base_from_plane.inverse().then_in(feature.base_from_tool);
    let normal = plane_from_tool.rotation().row(2).transpose();
    let height = |v: &[f64; 3]| normal.dot(&Vector3::from(*v)) + plane_from_tool.translation_mm().z;
    let heights = feature.pin.facets.vertices.iter().map(height);
    let (low, high) = heights.fold((f64::MAX, f64::MIN), |(l, h), z| (l.min(z), h.max(z)));
    low > margin_mm || high < -margin_mm
}
