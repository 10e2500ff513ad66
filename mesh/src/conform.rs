//! Small features without the boolean kernel.
//!
//! Sensors are curved bodies with hundreds of small holes, dimples and pins. A boolean cuts every
//! triangle of every tool with every triangle near it; most of a mesh's time would go there. But
//! what such a feature does to a body is simple: its wall passes through one face along one closed
//! curve, or through several faces along one curve each. So that curve is computed on the exact
//! surfaces of both, the triangles of the base that it touches are taken out, and the gap between
//! them and the curve is filled by a constrained Delaunay triangulation; from the curve on, the
//! tool's own tessellation goes on.
//!
//! - All new vertices lie on both exact surfaces; triangles that are new in the base are measured
//!   against it.
//! - The tool's wall keeps its own azimuths, so that curves end where its rings have their points
//!   and no slivers arise; vertices of the base that come too near a curve go.
//! - Every precondition is checked: the curves lie on one face each, the base's triangles taken are
//!   a plain patch of that face, and no other triangle of the base reaches into the tool. Whatever
//!   fails one is left to the kernel.

mod bend;
mod cavity;
mod fill;
mod measure;
mod nearby;
mod pin;
mod sheet;
#[cfg(test)]
mod tests;
mod trim;
mod wall;

use std::rc::Rc;

use fabkit_geometry::{Body, Point3, Pose, Vector3};

use crate::extent::moved;
use crate::facets::Facets;
use bend::bend;
use cavity::{Candidate, Cavity};
use fill::Fill;
use measure::Measure;
use nearby::Nearby;
pub(crate) use pin::Pin;
use sheet::{NONE, Sheet};
use trim::{Curve, curves};
use wall::{Corner, wall};

/// How near vertices of the base may be to a curve, relative to its shortest chord; the second
/// value is for where removing them would stray too far from the surface.
const CLEARANCES: [f64; 2] = [0.25, 0.01];

/// A surface that a tool's axis meets at less than this sine is left to the kernel.
const LEAST_SINE: f64 = 0.2;

/// A tool in its place.
pub(crate) struct Feature {
    pub pin: Rc<Pin>,
    pub base_from_tool: Pose,
    /// Of its face 0.
    pub first_face: u32,
}

/// What is cut or added to.
pub(crate) struct Base<'a> {
    pub facets: &'a Facets,
    /// The same solid, exactly.
    pub body: &'a Body,
    /// Face number of face 0 of each of the body's leaves.
    pub first_faces: &'a [u32],
}

/// Adds features to a base, or cuts them away; returns those that could not be, too.
pub(crate) fn conform(
    base: &Base,
    features: &[Feature],
    adding: bool,
    tolerance_mm: f64,
) -> Option<(Facets, Vec<usize>)> {
    let sheet = Sheet::new(base.facets)?;
    let reach = |f: &Feature| moved(&f.pin.facets.bounds(), &f.base_from_tool).grown(tolerance_mm);
    let nearby = Nearby::new(features.iter().map(reach).collect());
    let mut work = Work { base, adding, tolerance_mm, sheet, nearby, stamp: 0 };
    for t in 0..work.sheet.len() {
        work.nearby.add(t, &work.sheet.bounds_of(t));
    }
    let left: Vec<usize> =
        (0..features.len()).filter(|&i| work.apply(i, &features[i]).is_none()).collect();
    (left.len() < features.len()).then(|| (work.sheet.into_facets(), left))
}

struct Work<'a> {
    base: &'a Base<'a>,
    adding: bool,
    tolerance_mm: f64,
    sheet: Sheet,
    nearby: Nearby,
    stamp: u32,
}

/// A cavity and what fills it.
struct Patch {
    cavity: Cavity,
    fill: Fill,
    face: u32,
}

impl Work<'_> {
    /// Nothing has changed if it returns `None`.
    fn apply(&mut self, index: usize, feature: &Feature) -> Option<()> {
        let curves = curves(&feature.pin, &feature.base_from_tool, self.base.body)?;
        let tool_from_base = feature.base_from_tool.inverse();
        let in_tool = |p: [f64; 3]| tool_from_base.point(Point3::from(p)).into();
        let candidates: Vec<Candidate> = self.nearby.triangles[index]
            .iter()
            .filter(|&&t| self.sheet.alive[t as usize])
            .map(|&t| Candidate { triangle: t, corners: self.sheet.points_of(t).map(in_tool) })
            .collect();
        let mut patches = Vec::with_capacity(curves.len());
        for curve in &curves {
            let patch = CLEARANCES.into_iter().find_map(|clearance| {
                self.patch(feature, curve, &candidates, clearance * curve.shortest_chord_mm())
            });
            patches.push(patch?);
        }
        // The last attempt of each curve is the one that counts.
        let taken = |c: &&Candidate| {
            patches.iter().any(|p| self.sheet.stamps[c.triangle as usize] == p.cavity.stamp)
        };
        let total: usize = patches.iter().map(|p| p.cavity.triangles.len()).sum();
        if candidates.iter().filter(taken).count() != total {
            return None; // Two curves took the same triangle.
        }
        let reaches_in = |c: &Candidate| {
            let radius_mm = feature.pin.radius_between_mm(c.z_range_mm());
            radius_mm.is_some_and(|radius_mm| c.axis_distance_mm() < radius_mm)
        };
        if candidates.iter().any(|c| !taken(&c) && reaches_in(c)) {
            return None;
        }
        self.commit(feature, &curves, patches);
        Some(())
    }

    fn patch(
        &mut self,
        feature: &Feature,
        curve: &Curve,
        candidates: &[Candidate],
        clear_mm: f64,
    ) -> Option<Patch> {
        let [leaf, number] = curve.face;
        let face = self.base.first_faces[leaf as usize] + number;
        self.stamp += 1;
        let axis = feature.base_from_tool.vector(Vector3::z());
        let sine = axis.dot(&curve.normal);
        if sine.abs() < LEAST_SINE {
            return None;
        }
        let facing = sine.signum();
        let cavity =
            Cavity::new(&mut self.sheet, candidates, curve, face, facing, clear_mm, self.stamp)?;

        let tool_from_base = feature.base_from_tool.inverse();
        let mut solid: Vec<[f64; 3]> = Vec::new();
        let mut flat: Vec<[f64; 2]> = Vec::new();
        let mut loops = Vec::with_capacity(cavity.loops.len() + 1);
        for chain in &cavity.loops {
            let first = solid.len();
            for &edge in chain {
                let point = self.sheet.points[self.sheet.from(edge) as usize];
                let in_tool = tool_from_base.point(Point3::from(point));
                solid.push(point);
                flat.push([facing * in_tool.x, in_tool.y]);
            }
            loops.push(first..solid.len());
        }
        let first = solid.len();
        for k in curve_order(curve.in_base.len(), facing) {
            solid.push(curve.in_base[k]);
            flat.push([facing * curve.in_tool[k][0], curve.in_tool[k][1]]);
        }
        loops.push(first..solid.len());

        let leaf = &self.base.body.leaves()[leaf as usize];
        let bend = bend(leaf, number, Point3::from(curve.in_base[0]), curve.normal);
        let scaled: Vec<[f64; 2]> = solid.iter().map(|&p| bend.scaled(p)).collect();
        let fill = Fill::new(&flat, &scaled, &loops)?;
        let mut measure = Measure::new(self.base.body, axis, curve, self.tolerance_mm);
        let corners = |t: &[u32; 3]| t.map(|v| solid[v as usize]);
        let holds = fill.triangles.iter().all(|t| measure.holds(corners(t), &bend));
        holds.then_some(Patch { cavity, fill, face })
    }

    fn commit(&mut self, feature: &Feature, curves: &[Curve], patches: Vec<Patch>) {
        let sheet = &mut self.sheet;
        let mut added = Vec::new();
        let mut first_points = Vec::with_capacity(curves.len());
        for curve in curves {
            first_points.push(sheet.points.len() as u32);
            sheet.points.extend(&curve.in_base);
        }
        for ((curve, patch), &first_point) in curves.iter().zip(patches).zip(&first_points) {
            let rim: Vec<u32> = patch.cavity.loops.into_iter().flatten().collect();
            let mut vertices: Vec<u32> = rim.iter().map(|&edge| sheet.from(edge)).collect();
            let order = curve_order(curve.in_base.len(), patch.cavity.facing);
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
                    // Each vertex of the rim begins one edge of it.
                    Fill::RIM => beyond.get(start).copied().unwrap_or(NONE),
                    inner => first_edge + inner,
                };
                if twin != NONE {
                    sheet.link(first_edge + edge, twin);
                }
            }
        }
        let tool = &feature.pin.facets;
        let mut new_index = vec![NONE; tool.vertices.len()];
        wall(&feature.pin, curves, !self.adding, |corners, face| {
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
            if !self.adding {
                corners.swap(1, 2);
            }
            added.push(sheet.push(corners, feature.first_face + face));
        });
        for t in added {
            self.nearby.add(t, &self.sheet.bounds_of(t));
        }
    }
}

/// The curve's points in the direction in which the fill lies on their left.
fn curve_order(count: usize, facing: f64) -> impl Iterator<Item = usize> {
    (0..count).map(move |k| if facing > 0.0 { count - 1 - k } else { k })
}
