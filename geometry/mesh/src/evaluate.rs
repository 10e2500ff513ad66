//! Evaluation of solid trees to triangles: choice, order and extent of booleans.
//!
//! Booleans dominate the cost, so as few as possible are made, on as little as possible:
//!
//! - Tools whose boxes are apart are put side by side into one mesh without a boolean.
//! - A - (B + C) is A - B - C: tools are never united with each other first.
//! - Small features are inserted into the base's mesh without a boolean where possible (`conform`).
//! - Equal shapes, up to whole subtrees, are meshed once and placed many times.

mod cull;
mod deferred_features;
mod features;

use std::cell::OnceCell;
use std::collections::BTreeMap;
use std::rc::Rc;

use fabkit_geometry::{Aabb, Pose, Solid};

use self::cull::cull_beyond_base;
use self::features::{ExactBase, Split, diagonal_mm};
use crate::MeshError;
use crate::conform::{Effect, RevolvedTool};
use crate::extent::{OrientedBox, disjoint_groups, extent, transform_box};
use crate::facets::Facets;
use crate::fuse::{FusedTree, fuse_coaxial};
use crate::kernel::{Operation, Prepared};
use crate::shape_key::{has_half_space, shape_key};
use crate::tessellate::{box_faces, face_count, tessellate};

/// Largest number of tool groups that are cut one by one. With more, uniting them pairwise first costs less than
/// cutting the whole base again for each.
const MOST_CUTS: usize = 4;

/// Meshes a valid tree, with small features by booleans too unless `conforming`.
pub(crate) fn evaluate(
    solid: &Solid,
    tolerance_mm: f64,
    conforming: bool,
) -> Result<Facets, MeshError> {
    // If the fused tree cannot be meshed, the tree as written is meshed, so that errors refer to it.
    if let Some(FusedTree { solid, faces }) = fuse_coaxial(solid)
        && let Ok(mut facets) = evaluate_without_fusion(&solid, tolerance_mm, conforming)
    {
        for face in &mut facets.faces {
            *face = faces[*face as usize];
        }
        return Ok(facets);
    }
    evaluate_without_fusion(solid, tolerance_mm, conforming)
}

/// Meshes a tree without fusing solids of revolution; only by booleans unless `conforming`.
pub(crate) fn evaluate_without_fusion(
    solid: &Solid,
    tolerance_mm: f64,
    conforming: bool,
) -> Result<Facets, MeshError> {
    Evaluator::new(tolerance_mm, conforming).evaluate_unfused(solid)
}

/// Meshes a tree with the features of operands inserted last; `None` if that gains nothing or cannot be done.
#[cfg(test)]
pub(crate) fn evaluate_with_deferred_features(
    solid: &Solid,
    tolerance_mm: f64,
) -> Result<Option<Facets>, MeshError> {
    let root = Subtree::peel(Pose::identity(), solid, 0);
    Evaluator::new(tolerance_mm, true).evaluate_with_deferred_features(&root)
}

/// Subtree without its outer placements and names.
struct Subtree<'a> {
    pose: Pose,
    core: &'a Solid,
    first_face: u32,
}

impl<'a> Subtree<'a> {
    fn peel(mut pose: Pose, mut core: &'a Solid, first_face: u32) -> Self {
        loop {
            match core {
                Solid::Placed { pose: inner, of } => {
                    pose = pose.then_in(*inner);
                    core = of;
                }
                Solid::Feature { of, .. } => core = of,
                _ => return Self { pose, core, first_face },
            }
        }
    }

    fn list(pose: Pose, solids: &'a [Solid], mut first_face: u32) -> Vec<Self> {
        let peel = |solid: &'a Solid| {
            let item = Self::peel(pose, solid, first_face);
            first_face += face_count(solid);
            item
        };
        solids.iter().map(peel).collect()
    }
}

/// Replaces unions by their operands, except unions that occur several times: meshing such a union once costs less than
/// meshing its operands repeatedly.
fn flattened(items: Vec<Subtree>) -> Vec<Subtree> {
    if !items.iter().any(|item| matches!(item.core, Solid::Union(_))) {
        return items;
    }
    let mut times: BTreeMap<Vec<u64>, usize> = BTreeMap::new();
    for item in &items {
        *times.entry(shape_key(item.core)).or_default() += 1;
    }
    let mut flat = Vec::with_capacity(items.len());
    for item in items {
        match item.core {
            Solid::Union(of) if times[&shape_key(item.core)] == 1 => {
                flat.extend(flattened(Subtree::list(item.pose, of, item.first_face)));
            }
            _ => flat.push(item),
        }
    }
    flat
}

/// Mesh in its own frame with face numbers from 0, in either representation, converted on demand.
struct Shape {
    facets: OnceCell<Facets>,
    prepared: OnceCell<Prepared>,
}

impl Shape {
    fn from_facets(facets: Facets) -> Rc<Self> {
        Rc::new(Self { facets: OnceCell::from(facets), prepared: OnceCell::new() })
    }

    fn from_prepared(prepared: Prepared) -> Rc<Self> {
        Rc::new(Self { facets: OnceCell::new(), prepared: OnceCell::from(prepared) })
    }

    fn facets(&self) -> &Facets {
        self.facets.get_or_init(|| self.prepared.get().map(Prepared::to_facets).unwrap_or_default())
    }

    fn prepared(&self) -> Result<&Prepared, MeshError> {
        if let Some(prepared) = self.prepared.get() {
            return Ok(prepared);
        }
        let prepared = Prepared::from_facets(self.facets())?;
        Ok(self.prepared.get_or_init(|| prepared))
    }

    fn is_empty(&self) -> bool {
        self.facets.get().map_or_else(
            || self.prepared.get().is_none_or(Prepared::is_empty),
            |facets| facets.triangles.is_empty(),
        )
    }

    fn bounds(&self) -> Aabb {
        self.prepared.get().map_or_else(|| self.facets().bounds(), Prepared::bounds)
    }
}

/// Shape with its pose.
#[derive(Clone)]
struct Body {
    shape: Rc<Shape>,
    pose: Pose,
    first_face: u32,
}

impl Body {
    fn oriented_box(&self) -> OrientedBox {
        OrientedBox::new(&self.shape.bounds(), &self.pose)
    }

    /// Returns the shape in the surrounding frame.
    fn to_outer_frame(&self) -> Result<Rc<Shape>, MeshError> {
        if self.pose == Pose::identity() && self.first_face == 0 {
            return Ok(self.shape.clone());
        }
        if self.shape.facets.get().is_some() {
            return Ok(side_by_side(std::slice::from_ref(self)));
        }
        Ok(Shape::from_prepared(self.shape.prepared()?.placed(&self.pose, self.first_face)))
    }
}

/// Combines bodies that are apart into one mesh.
fn side_by_side(bodies: &[Body]) -> Rc<Shape> {
    let mut facets = Facets::default();
    for body in bodies {
        facets.append(body.shape.facets(), &body.pose, body.first_face);
    }
    Shape::from_facets(facets)
}

fn combine(a: &Shape, b: &Shape, operation: Operation) -> Result<Rc<Shape>, MeshError> {
    Ok(Shape::from_prepared(a.prepared()?.combine(b.prepared()?, operation)?))
}

/// Combines bodies that are apart to few shapes by greedy grouping.
fn grouped(bodies: &[Body]) -> Result<Vec<Rc<Shape>>, MeshError> {
    let boxes: Vec<OrientedBox> = bodies.iter().map(Body::oriented_box).collect();
    disjoint_groups(&boxes)
        .into_iter()
        .map(|group| match group[..] {
            [only] => bodies[only].to_outer_frame(),
            _ => {
                let members: Vec<Body> = group.iter().map(|&i| bodies[i].clone()).collect();
                Ok(side_by_side(&members))
            }
        })
        .collect()
}

/// Unites shapes pairwise, so that each triangle takes part in few booleans.
fn united(mut shapes: Vec<Rc<Shape>>) -> Result<Rc<Shape>, MeshError> {
    while shapes.len() > 1 {
        shapes = shapes
            .chunks(2)
            .map(|pair| match pair {
                [a, b] => combine(a, b, Operation::Add),
                _ => Ok(pair[0].clone()),
            })
            .collect::<Result<_, _>>()?;
    }
    Ok(shapes.pop().unwrap_or_else(|| Shape::from_facets(Facets::default())))
}

/// Evaluator of trees at one tolerance, with a cache of their shapes.
pub(crate) struct Evaluator {
    tolerance_mm: f64,
    conforming: bool,
    shapes: BTreeMap<Vec<u64>, Rc<Shape>>,
    pins: BTreeMap<Vec<u64>, Option<Rc<RevolvedTool>>>,
}

impl Evaluator {
    pub(crate) fn new(tolerance_mm: f64, conforming: bool) -> Self {
        Self { tolerance_mm, conforming, shapes: BTreeMap::new(), pins: BTreeMap::new() }
    }

    /// Meshes a tree whose faces are those of its leaves, so that solids which share a face share its triangles
    /// wherever other solids cut it.
    pub(crate) fn evaluate_unfused(&mut self, solid: &Solid) -> Result<Facets, MeshError> {
        let root = Subtree::peel(Pose::identity(), solid, 0);
        if self.conforming
            && let Some(facets) = self.evaluate_with_deferred_features(&root)?
        {
            return Ok(facets);
        }
        self.evaluate_as_written(&root)
    }

    /// Meshes the whole tree as it is written.
    fn evaluate_as_written(&mut self, root: &Subtree) -> Result<Facets, MeshError> {
        let body = self.body(root, &Aabb::everything())?;
        // Empty intermediate results are fine; only the whole must not be empty.
        if body.shape.is_empty() {
            return Err(MeshError::Empty);
        }
        let mut facets = Facets::default();
        facets.append(body.shape.facets(), &body.pose, body.first_face);
        Ok(facets)
    }

    /// Meshes an item. Only the part within `context`, given in the frame around the item, needs to be right.
    fn body(&mut self, item: &Subtree, context: &Aabb) -> Result<Body, MeshError> {
        let shape = if has_half_space(item.core) {
            let local = transform_box(context, &item.pose.inverse());
            self.shape(item.core, &local)?
        } else {
            // Half spaces depend on their context and are not cached.
            let key = shape_key(item.core);
            match self.shapes.get(&key) {
                Some(shape) => shape.clone(),
                None => {
                    let shape = self.shape(item.core, &Aabb::everything())?;
                    self.shapes.insert(key, shape.clone());
                    shape
                }
            }
        };
        Ok(Body { shape, pose: item.pose, first_face: item.first_face })
    }

    /// Meshes items and returns the bodies that are not empty.
    fn bodies(&mut self, items: &[Subtree], context: &Aabb) -> Result<Vec<Body>, MeshError> {
        let mut bodies = Vec::with_capacity(items.len());
        for item in items {
            let body = self.body(item, context)?;
            if !body.shape.is_empty() {
                bodies.push(body);
            }
        }
        Ok(bodies)
    }

    fn shape(&mut self, core: &Solid, context: &Aabb) -> Result<Rc<Shape>, MeshError> {
        match core {
            Solid::Union(of) => self.union(of, context),
            Solid::Intersection(of) => self.intersection(of, context),
            Solid::Difference { of, minus } => self.difference(of, minus, context),
            Solid::HalfSpace(_) => half_space(context),
            primitive => tessellate(primitive, self.tolerance_mm)
                .map(Shape::from_facets)
                .ok_or(MeshError::TooFine { tolerance_mm: self.tolerance_mm }),
        }
    }

    fn union(&mut self, of: &[Solid], context: &Aabb) -> Result<Rc<Shape>, MeshError> {
        let items = flattened(Subtree::list(Pose::identity(), of, 0));
        let sizes = items.iter().map(|item| diagonal_mm(extent(item.core).size_mm()));
        // The largest operand counts as the base that features are compared with.
        let largest_mm = sizes.fold(0.0, f64::max);
        let mut split = self.split(items, largest_mm)?;
        let exact = ExactBase::union(&split.others);
        split.reject_nonconforming(&exact);
        let Split { features, others } = split;
        let bodies = self.bodies(&others, context)?;
        let base = united(grouped(&bodies)?)?;
        if features.is_empty() {
            return Ok(base);
        }
        let (base, left) = self.conform_features(base, &exact, features, &Effect::Add);
        let bodies = self.bodies(&left, context)?;
        let mut shapes = grouped(&bodies)?;
        shapes.insert(0, base);
        united(shapes)
    }

    fn difference(
        &mut self,
        of: &Solid,
        minus: &[Solid],
        context: &Aabb,
    ) -> Result<Rc<Shape>, MeshError> {
        let base = self.body(&Subtree::peel(Pose::identity(), of, 0), context)?;
        let base = base.to_outer_frame()?;
        if base.is_empty() {
            return Ok(base);
        }
        let items = flattened(Subtree::list(Pose::identity(), minus, face_count(of)));
        let mut split = self.split(items, diagonal_mm(base.bounds().size_mm()))?;
        let exact = ExactBase::difference(of, &split.others);
        split.reject_nonconforming(&exact);
        let Split { features, others } = split;
        let base = self.cut(base, &others)?;
        if features.is_empty() || base.is_empty() {
            return Ok(base);
        }
        let (base, left) = self.conform_features(base, &exact, features, &Effect::Cut);
        self.cut(base, &left)
    }

    /// Cuts items from a base by the kernel.
    fn cut(&mut self, base: Rc<Shape>, items: &[Subtree]) -> Result<Rc<Shape>, MeshError> {
        let bounds = base.bounds();
        let base_box = OrientedBox::new(&bounds, &Pose::identity());
        let mut tools = self.bodies(items, &bounds)?;
        // Tools that do not reach the base would only cost time.
        tools.retain(|tool| !tool.oriented_box().is_apart_from(&base_box));
        let mut tools = grouped(&tools)?;
        if tools.len() > MOST_CUTS {
            tools = vec![united(tools)?];
        }
        // Small tools first: each cut passes through the whole base, which should grow late.
        tools.sort_by_key(|tool| tool.facets().triangles.len());
        tools.into_iter().try_fold(base, |rest, tool| {
            let needed = cull_beyond_base(tool.facets(), &rest.bounds()).map(Shape::from_facets);
            combine(&rest, &needed.unwrap_or(tool), Operation::Subtract)
        })
    }

    fn intersection(&mut self, of: &[Solid], context: &Aabb) -> Result<Rc<Shape>, MeshError> {
        let items = Subtree::list(Pose::identity(), of, 0);
        let extents: Vec<Aabb> = of.iter().map(extent).collect();
        let mut common: Option<Rc<Shape>> = None;
        for (i, item) in items.iter().enumerate() {
            let others = extents.iter().enumerate().filter(|(j, _)| *j != i);
            // An operand matters only within the boxes of all others, which also bounds half spaces.
            let within = others.fold(*context, |all, (_, other)| all.common(other));
            let shape = self.body(item, &within)?.to_outer_frame()?;
            common = Some(match common {
                None => shape,
                Some(rest) if rest.is_empty() || shape.is_empty() => {
                    return Ok(Shape::from_facets(Facets::default()));
                }
                Some(rest) => combine(&rest, &shape, Operation::Intersect)?,
            });
        }
        common.ok_or(MeshError::Empty)
    }
}

/// Meshes the part of the half space z <= 0 that matters within `context`.
fn half_space(context: &Aabb) -> Result<Rc<Shape>, MeshError> {
    let mut facets = Facets::default();
    if context.is_empty() || context.min.z >= 0.0 {
        return Ok(Shape::from_facets(facets));
    }
    if !context.is_finite() {
        return Err(MeshError::Unbounded);
    }
    // Wide enough that its other faces are far from everything else.
    let beyond = context.grown(1.0 + context.size_mm().into_iter().fold(0.0, f64::max) / 4.0);
    for k in 0..8 {
        let pick = |bit: usize, top: f64| if k >> bit & 1 == 0 { beyond.min[bit] } else { top };
        facets.vertex([pick(0, beyond.max.x), pick(1, beyond.max.y), pick(2, 0.0)]);
    }
    box_faces(&mut facets, [0; 6]);
    Ok(Shape::from_facets(facets))
}
