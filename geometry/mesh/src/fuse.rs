//! Fusion of coaxial solids of revolution into one solid of revolution before meshing.
//!
//! Domes, rings, tubes and stepped holes are stacks of round bodies: cutting one by another in space intersects
//! thousands of triangles to find a few circles. In the half plane through the axis they are a few lines and arcs,
//! whose crossings have closed forms (`profile`). The result is a plain revolved profile, and each of its segments
//! keeps the number of its original face.
//!
//! Bodies that touch share their triangles where they share a face, and this must hold after fusion. Planes and
//! cylinders may be divided freely; a cone or a curved face is divided only if no other leaf lies on the same surface.
//! Bodies that touch, overlap along a face or would fall apart are left as they are.

mod profile;

use fabkit_geometry::{Aabb, Point3, Pose, Solid};

use self::profile::{Outline, OutlineSegment, ProfileOperation};
use crate::extent::extent;
use crate::tessellate::face_count;

/// Distance below which axes and points count as the same, mm, and sine of the angle below which directions do.
const SAME: f64 = 1e-10;

/// Distance below which surfaces count as one, mm.
const SAME_SURFACE_MM: f64 = 1e-6;

/// Equivalent tree after fusion.
pub(crate) struct FusedTree {
    pub solid: Solid,
    /// Number in the original tree of each of its faces.
    pub faces: Vec<u32>,
}

/// Fuses a tree; `None` if there is nothing to fuse.
pub(crate) fn fuse_coaxial(solid: &Solid) -> Option<FusedTree> {
    let mut fuser = Fuser { surfaces: Vec::new(), changed: false, next_face: 0 };
    for leaf in solid.leaves() {
        fuser.surfaces.extend(RevolvedSurface::whole(leaf.primitive, &leaf.root_from_leaf));
        let outline = Outline::from_primitive(leaf.primitive, &[]);
        let segs = outline.iter().flat_map(|outline| &outline.segs);
        fuser
            .surfaces
            .extend(segs.filter_map(|seg| RevolvedSurface::of(seg, &leaf.root_from_leaf)));
    }
    let part = fuser.tree(solid, Pose::identity());
    fuser.changed.then_some(FusedTree { solid: part.solid, faces: part.faces })
}

/// Surface whose triangulation depends on where it is divided, given by a point of its axis and its shape parameters.
#[derive(PartialEq)]
struct RevolvedSurface {
    at: Point3<f64>,
    shape: [f64; 3],
}

impl RevolvedSurface {
    fn of(seg: &OutlineSegment, root_from_leaf: &Pose) -> Option<Self> {
        let (z, shape) = match &seg.bend {
            Some(bend) => (bend.centre[1], [bend.centre[0], bend.axes[0], bend.axes[1]]),
            None => {
                let [r, z] = [0, 1].map(|i| seg.to[i] - seg.from[i]);
                // Planes and cylinders may be divided freely.
                if r == 0.0 || z == 0.0 {
                    return None;
                }
                (seg.from[1] - seg.from[0] * z / r, [(z / r).abs(), -1.0, -1.0])
            }
        };
        Some(Self { at: root_from_leaf.point(Point3::new(0.0, 0.0, z)), shape })
    }

    /// Returns the surface of a primitive that has no outline here.
    fn whole(primitive: &Solid, root_from_leaf: &Pose) -> Option<Self> {
        let shape = match primitive {
            Solid::Ellipsoid(s) => [0.0, s.semi_axes_mm[0], s.semi_axes_mm[2]],
            Solid::EllipsoidOffset(s) => {
                [0.0, s.equatorial_mm + s.offset_mm, s.polar_mm + s.offset_mm]
            }
            Solid::Torus(s) => [s.ring_radius_mm, s.tube_radius_mm, s.tube_radius_mm],
            _ => return None,
        };
        Some(Self { at: root_from_leaf.point(Point3::origin()), shape })
    }

    fn is_near(&self, other: &Self) -> bool {
        let near = |a: f64, b: f64| (a - b).abs() < SAME_SURFACE_MM;
        (self.at - other.at).norm() < SAME_SURFACE_MM
            && self.shape.iter().zip(&other.shape).all(|(&a, &b)| near(a, b))
    }
}

/// Subtree with the original numbers of its faces.
#[derive(Clone)]
struct Part {
    solid: Solid,
    faces: Vec<u32>,
}

impl Part {
    /// Returns the primitive below placements and names, and its pose.
    fn peeled(&self) -> (Pose, &Solid) {
        let (mut pose, mut core) = (Pose::identity(), &self.solid);
        loop {
            match core {
                Solid::Placed { pose: inner, of } => {
                    pose = pose.then_in(*inner);
                    core = of;
                }
                Solid::Feature { of, .. } => core = of,
                _ => return (pose, core),
            }
        }
    }

    fn bounds(&self) -> Aabb {
        extent(&self.solid).grown(SAME_SURFACE_MM)
    }
}

struct Fuser {
    /// Surfaces of all leaves, in the root's frame.
    surfaces: Vec<RevolvedSurface>,
    changed: bool,
    next_face: u32,
}

impl Fuser {
    fn tree(&mut self, solid: &Solid, pose: Pose) -> Part {
        match solid {
            Solid::Placed { pose: inner, of } => {
                let Part { solid, faces } = self.tree(of, pose.then_in(*inner));
                Part { solid: solid.placed(*inner), faces }
            }
            Solid::Feature { name, of } => {
                let Part { solid, faces } = self.tree(of, pose);
                Part { solid: solid.named(name.clone()), faces }
            }
            Solid::Union(of) => {
                let parts = self.trees(of, &pose);
                together(self.united(parts, &pose))
            }
            Solid::Intersection(of) => {
                let parts = self.trees(of, &pose);
                let faces = parts.iter().flat_map(|part| part.faces.clone()).collect();
                Part { solid: Solid::Intersection(solids(parts)), faces }
            }
            Solid::Difference { of, minus } => {
                let base = self.tree(of, pose);
                let tools = self.trees(minus, &pose);
                let tools = self.united(tools, &pose);
                self.cut(base, tools, &pose)
            }
            primitive => {
                let first = self.next_face;
                self.next_face += face_count(primitive);
                Part { solid: primitive.clone(), faces: (first..self.next_face).collect() }
            }
        }
    }

    fn trees(&mut self, of: &[Solid], pose: &Pose) -> Vec<Part> {
        of.iter().map(|one| self.tree(one, *pose)).collect()
    }

    /// Unites parts; coaxial ones are fused where possible.
    fn united(&mut self, parts: Vec<Part>, pose: &Pose) -> Vec<Part> {
        let mut done: Vec<Part> = Vec::with_capacity(parts.len());
        for mut part in parts {
            let mut i = 0;
            while i < done.len() {
                match self.combined(&done[i], &part, ProfileOperation::Add, pose) {
                    Some(both) => {
                        part = both;
                        // The union may now touch parts that it was apart from before, so the search starts again.
                        done.remove(i);
                        i = 0;
                    }
                    None => i += 1,
                }
            }
            done.push(part);
        }
        done
    }

    /// Cuts tools from the base, or from its one part that a tool touches, by fusion where possible. The other tools
    /// stay tools of a difference.
    fn cut(&mut self, base: Part, tools: Vec<Part>, pose: &Pose) -> Part {
        let mut bases = match base.solid {
            Solid::Union(of) => {
                let mut first = 0;
                let part = |solid: Solid| {
                    let next = first + face_count(&solid) as usize;
                    let faces = base.faces[first..next].to_vec();
                    first = next;
                    Part { solid, faces }
                };
                of.into_iter().map(part).collect()
            }
            _ => vec![base],
        };
        let mut left = Vec::with_capacity(tools.len());
        for tool in tools {
            let bounds = tool.bounds();
            let touched = |part: &Part| !part.bounds().common(&bounds).is_empty();
            // A tool that touches two parts must be cut from both, which fusion cannot do.
            let mut touched = (0..bases.len()).filter(|&i| touched(&bases[i]));
            let cut = match (touched.next(), touched.next()) {
                (Some(i), None) => self
                    .combined(&bases[i], &tool, ProfileOperation::Cut, pose)
                    .map(|part| (i, part)),
                _ => None,
            };
            match cut {
                Some((i, part)) => bases[i] = part,
                None => left.push(tool),
            }
        }
        let Part { solid, mut faces } = together(bases);
        if left.is_empty() {
            return Part { solid, faces };
        }
        faces.extend(left.iter().flat_map(|tool| &tool.faces));
        Part { solid: Solid::Difference { of: Box::new(solid), minus: solids(left) }, faces }
    }

    fn combined(
        &mut self,
        a: &Part,
        b: &Part,
        rule: ProfileOperation,
        pose: &Pose,
    ) -> Option<Part> {
        let ((a_pose, a_core), (b_pose, b_core)) = (a.peeled(), b.peeled());
        let shift_mm = along_axis(&a_pose, &b_pose)?;
        let a_outline = Outline::from_primitive(a_core, &a.faces)?;
        let b_outline = Outline::from_primitive(b_core, &b.faces)?.shifted(shift_mm);
        let root_from_a = pose.then_in(a_pose);
        let may_divide = |seg: &OutlineSegment| {
            RevolvedSurface::of(seg, &root_from_a).is_none_or(|surface| {
                // The surface itself is in the list, so a count of 1 means that no other leaf shares it.
                self.surfaces.iter().filter(|other| surface.is_near(other)).count() == 1
            })
        };
        let outline = a_outline.combined(&b_outline, rule, may_divide)?;
        let (path, faces) = outline.into_path();
        // A clockwise result would be a hole, not a body.
        if path.signed_area_mm2() <= 0.0 {
            return None;
        }
        self.changed = true;
        let solid = Solid::revolution(path).placed(a_pose);
        Some(Part { solid, faces })
    }
}

/// Returns the shift of one frame along the other's z axis; `None` if they differ in any other way.
fn along_axis(a: &Pose, b: &Pose) -> Option<f64> {
    let turn = a.rotation() - b.rotation();
    if turn.iter().any(|x| x.abs() > SAME) {
        return None;
    }
    let shift = a.rotation().transpose() * (b.translation_mm() - a.translation_mm());
    (shift.x.hypot(shift.y) < SAME).then_some(shift.z)
}

fn solids(parts: Vec<Part>) -> Vec<Solid> {
    parts.into_iter().map(|part| part.solid).collect()
}

/// Returns the union of parts; a single part as it is.
fn together(mut parts: Vec<Part>) -> Part {
    if parts.len() == 1 {
        return parts.swap_remove(0);
    }
    let faces = parts.iter().flat_map(|part| part.faces.clone()).collect();
    Part { solid: Solid::Union(solids(parts)), faces }
}

#[cfg(test)]
mod tests;
