//! Insertion of small features into a mesh without the boolean kernel.
//!
//! Sensors are curved bodies with hundreds of small holes, dimples and pins. A boolean cuts every triangle of every
//! tool with every triangle near it, which would take most of the meshing time. But the effect of such a feature on a
//! body is simple: its wall passes through one face along one closed curve, or through several faces along one curve
//! each. Therefore that curve is computed on the exact surfaces of both, the triangles of the base that it touches are
//! removed, and the gap between them and the curve is filled by a constrained Delaunay triangulation. From the curve
//! on, the tool's own tessellation continues.
//!
//! - All new vertices lie on both exact surfaces; triangles that are new in the base are measured against it.
//! - The tool's wall keeps its own azimuths, so that curves end where its rings have their points and no slivers arise.
//!   Vertices of the base that come too near a curve are removed.
//! - Every precondition is checked: each curve lies on one face, the removed triangles of the base are a simply bounded
//!   patch of that face, and no other triangle of the base reaches into the tool. Features that fail a check are left
//!   to the kernel.

mod base_mesh;
mod cavity;
mod curvature;
mod fill;
mod intersection_curves;
mod measure;
mod nearby;
mod operand_features;
mod patch;
mod revolved_tool;
#[cfg(test)]
mod tests;
mod wall;

use std::ops::Range;
use std::rc::Rc;

use fabkit_geometry::{Aabb, CompiledSolid, Point3, Pose};

use crate::extent::transform_box;
use crate::facets::Facets;
use base_mesh::{BaseMesh, NONE};
use cavity::Candidate;
use fill::Fill;
use intersection_curves::{Curve, curves};
use nearby::CandidateGrid;
pub(crate) use operand_features::FeatureTree;
use patch::{CurveOnBase, Patch};
pub(crate) use revolved_tool::RevolvedTool;
use wall::{Corner, wall};

/// Smallest distance of vertices of the base from a curve, relative to its shortest chord. The second value is tried
/// where removing vertices would deviate too far from the surface.
const CLEARANCES: [f64; 2] = [0.25, 0.01];

/// Range without limits along a tool's axis, mm.
const EVERYWHERE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// Feature: a tool with its pose in the base.
pub(crate) struct Feature {
    pub pin: Rc<RevolvedTool>,
    pub base_from_tool: Pose,
    /// Number of its face 0 in the base.
    pub first_face: u32,
    /// Leaves in the base of the operand that the feature belongs to, if that is deeper in the tree.
    pub operand: Option<Range<u32>>,
}

impl Feature {
    /// Returns whether its surface crosses a body's in curves that a mesh can be closed up to.
    pub fn has_curves(&self, body: &CompiledSolid) -> bool {
        curves(self, body).is_some()
    }
}

/// Base that features are cut from or added to.
pub(crate) struct Base<'a> {
    pub facets: &'a Facets,
    /// Exact solid of the same base.
    pub body: &'a CompiledSolid,
    /// Number of face 0 of each of the body's leaves.
    pub first_faces: &'a [u32],
}

/// Effect of features on their base.
pub(crate) enum Effect<'a> {
    /// Unite the features with the base.
    Add,
    /// Cut the features away.
    Cut,
    /// Unite or cut as the tree that contains the features demands.
    FromTree(&'a FeatureTree),
}

/// Inserts features into a base. Returns the mesh and the indices of the features that could not be inserted; `None` if
/// none could.
pub(crate) fn conform(
    base: &Base,
    features: &[Feature],
    effect: &Effect,
    tolerance_mm: f64,
) -> Option<(Facets, Vec<usize>)> {
    let reach =
        |f: &Feature| transform_box(&f.pin.facets.bounds(), &f.base_from_tool).grown(tolerance_mm);
    let boxes: Vec<Aabb> = features.iter().map(reach).collect();
    // Only features of operands deeper in the tree can meet surfaces that the base hides.
    let obstacles = match effect {
        Effect::FromTree(whole) => whole.nearby(boxes.clone()),
        _ => CandidateGrid::new(Vec::new()),
    };
    let (sheet, nearby) = (BaseMesh::new(base.facets)?, CandidateGrid::new(boxes));
    let mut work = Work { base, effect, tolerance_mm, sheet, nearby, obstacles, stamp: 0 };
    for t in 0..work.sheet.len() {
        work.nearby.add(t, &work.sheet.bounds_of(t));
    }
    let left: Vec<usize> =
        (0..features.len()).filter(|&i| work.apply(i, &features[i]).is_none()).collect();
    (left.len() < features.len()).then(|| (work.sheet.into_facets(), left))
}

struct Work<'a> {
    base: &'a Base<'a>,
    effect: &'a Effect<'a>,
    tolerance_mm: f64,
    sheet: BaseMesh,
    nearby: CandidateGrid,
    /// Triangles of surfaces that are hidden in the base.
    obstacles: CandidateGrid,
    stamp: u32,
}

impl Work<'_> {
    /// Inserts one feature. Changes nothing if it returns `None`.
    fn apply(&mut self, index: usize, feature: &Feature) -> Option<()> {
        let curves = curves(feature, self.base.body)?;
        let (adding, z_mm) = match self.effect {
            Effect::Add => (true, EVERYWHERE),
            Effect::Cut => (false, EVERYWHERE),
            Effect::FromTree(whole) => {
                let near = &self.obstacles.triangles[index];
                let span = whole.find_changed_range(
                    self.base,
                    feature,
                    &curves,
                    near,
                    self.tolerance_mm,
                )?;
                (span.adding, span.z_mm)
            }
        };
        let tool_from_base = feature.base_from_tool.inverse();
        let candidates: Vec<Candidate> = self.nearby.triangles[index]
            .iter()
            .filter(|&&t| self.sheet.alive[t as usize])
            .map(|&t| Candidate::new(t, self.sheet.points_of(t), &tool_from_base))
            .collect();
        let mut patches = Vec::with_capacity(curves.len());
        for curve in &curves {
            patches.push(self.patch(feature, curve, &candidates)?);
        }
        let taken = |c: &Candidate| {
            patches.iter().any(|p| self.sheet.stamps[c.triangle as usize] == p.cavity.stamp)
        };
        // A triangle taken by two curves counts twice here, but only once among the candidates.
        let total: usize = patches.iter().map(|p| p.cavity.triangles.len()).sum();
        if candidates.iter().filter(|c| taken(c)).count() != total {
            return None; // Two curves took the same triangle.
        }
        if candidates.iter().any(|c| !taken(c) && c.reaches_into(&feature.pin, z_mm, 0.0)) {
            return None;
        }
        self.commit(feature, &curves, patches, adding);
        Some(())
    }

    /// Computes the patch that closes the base up to a curve, at a distance from the base's other vertices if possible.
    fn patch(
        &mut self,
        feature: &Feature,
        curve: &Curve,
        candidates: &[Candidate],
    ) -> Option<Patch> {
        CLEARANCES.into_iter().find_map(|clearance| {
            self.stamp += 1;
            let clear_mm = clearance * curve.shortest_chord_mm();
            let place =
                CurveOnBase { base: self.base, feature, curve, tolerance_mm: self.tolerance_mm };
            place.patch(&mut self.sheet, candidates, clear_mm, self.stamp)
        })
    }

    fn commit(&mut self, feature: &Feature, curves: &[Curve], patches: Vec<Patch>, adding: bool) {
        let sheet = &mut self.sheet;
        let mut added = Vec::new();
        let mut first_points = Vec::with_capacity(curves.len());
        for curve in curves {
            first_points.push(sheet.points.len() as u32);
            sheet.points.extend(&curve.in_base);
        }
        for ((curve, patch), &first_point) in curves.iter().zip(patches).zip(&first_points) {
            let order = patch.curve_order(curve.in_base.len());
            let rim: Vec<u32> = patch.cavity.loops.into_iter().flatten().collect();
            let mut vertices: Vec<u32> = rim.iter().map(|&edge| sheet.from(edge)).collect();
            vertices.extend(order.map(|k| first_point + k as u32));
            let beyond: Vec<u32> = rim.iter().map(|&edge| sheet.twins[edge as usize]).collect();
            for &t in &patch.cavity.triangles {
                sheet.alive[t as usize] = false;
            }
            let first_edge = 3 * sheet.len();
            for &t in &patch.fill.triangles {
                added.push(sheet.push(t.map(|v| vertices[v as usize]), patch.face));
            }
            for (edge, &twin) in (0..).zip(&patch.fill.twins) {
                let start = patch.fill.triangles[edge as usize / 3][edge as usize % 3] as usize;
                let twin = match twin {
                    // Each vertex of the rim is the start of one rim edge.
                    Fill::RIM => beyond.get(start).copied().unwrap_or(NONE),
                    inner => first_edge + inner,
                };
                if twin != NONE {
                    sheet.link(first_edge + edge, twin);
                }
            }
        }
        let tool = &feature.pin.facets;
        // Vertices of the tool are added on first use, so that none of its removed part remains.
        let mut new_index = vec![NONE; tool.vertices.len()];
        wall(&feature.pin, curves, !adding, |corners, face| {
            let mut corners = corners.map(|corner| match corner {
                Corner::Curve { curve, point } => first_points[curve] + point as u32,
                Corner::Tool(v) => {
                    let index = &mut new_index[v as usize];
                    if *index == NONE {
                        *index = sheet.points.len() as u32;
                        let point = Point3::from(tool.vertices[v as usize]);
                        sheet.points.push(feature.base_from_tool.point(point).into());
                    }
                    *index
                }
            });
            // A tool that is cut away faces inwards.
            if !adding {
                corners.swap(1, 2);
            }
            added.push(sheet.push(corners, feature.first_face + face));
        });
        for t in added {
            self.nearby.add(t, &self.sheet.bounds_of(t));
        }
    }
}
