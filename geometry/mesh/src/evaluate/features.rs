//! Selection of the operands of a boolean that are small features, and their insertion into the base's mesh.

use std::rc::Rc;

use fabkit_geometry::{CompiledSolid as ExactBody, Solid};

use super::{Evaluator, Shape, Subtree};
use crate::MeshError;
use crate::conform::{Base, Effect, Feature, RevolvedTool, conform};
use crate::shape_key::shape_key;
use crate::tessellate::face_count;

/// Largest diagonal of a feature's box as a fraction of the base's.
pub(super) const LARGEST_SHARE: f64 = 0.6;

/// Operands that may conform to the base, and all others.
pub(super) struct Split<'a> {
    pub features: Vec<(Subtree<'a>, Rc<RevolvedTool>)>,
    pub others: Vec<Subtree<'a>>,
}

impl Evaluator {
    /// Splits operands into features and others, by kind and by size relative to the base.
    pub(super) fn split<'a>(
        &mut self,
        items: Vec<Subtree<'a>>,
        base_diagonal_mm: f64,
    ) -> Result<Split<'a>, MeshError> {
        let mut split = Split { features: Vec::new(), others: Vec::new() };
        for item in items {
            let small =
                |pin: &Rc<RevolvedTool>| pin.diagonal_mm() <= LARGEST_SHARE * base_diagonal_mm;
            match self.pin(&item)?.filter(small) {
                Some(pin) if self.conforming => split.features.push((item, pin)),
                _ => split.others.push(item),
            }
        }
        Ok(split)
    }

    pub(super) fn pin(&mut self, item: &Subtree) -> Result<Option<Rc<RevolvedTool>>, MeshError> {
        if !RevolvedTool::may_be(item.core) {
            return Ok(None);
        }
        // The cache also stores that a shape is no pin.
        let key = shape_key(item.core);
        if let Some(pin) = self.pins.get(&key) {
            return Ok(pin.clone());
        }
        let body = self.body(item, &fabkit_geometry::Aabb::everything())?;
        let pin = RevolvedTool::new(item.core, body.shape.facets(), self.tolerance_mm).map(Rc::new);
        self.pins.insert(key, pin.clone());
        Ok(pin)
    }

    /// Adds features to the mesh of an exact solid, or cuts them away. Returns the mesh and the features that are left
    /// to the kernel.
    pub(super) fn conform_features<'a>(
        &self,
        shape: Rc<Shape>,
        exact: &ExactBase,
        features: Vec<(Subtree<'a>, Rc<RevolvedTool>)>,
        effect: &Effect,
    ) -> (Rc<Shape>, Vec<Subtree<'a>>) {
        let Some(body) = &exact.body else {
            return (shape, features.into_iter().map(|(item, _)| item).collect());
        };
        let placed: Vec<Feature> = features.iter().map(feature).collect();
        let base = Base { facets: shape.facets(), body, first_faces: &exact.first_faces };
        let (shape, left) = match conform(&base, &placed, effect, self.tolerance_mm) {
            Some((facets, left)) => (Shape::from_facets(facets), left),
            None => (shape.clone(), (0..features.len()).collect()),
        };
        let of_left = |(i, (item, _))| left.binary_search(&i).is_ok().then_some(item);
        (shape, features.into_iter().enumerate().filter_map(of_left).collect())
    }
}

fn feature((item, pin): &(Subtree, Rc<RevolvedTool>)) -> Feature {
    let (base_from_tool, first_face) = (item.pose, item.first_face);
    Feature { pin: pin.clone(), base_from_tool, first_face, operand: None }
}

impl<'a> Split<'a> {
    /// Moves features that cannot conform to the others, so that the kernel processes them only once.
    pub fn reject_nonconforming(&mut self, exact: &ExactBase) {
        let can = |one: &(Subtree, Rc<RevolvedTool>)| {
            exact.body.as_ref().is_some_and(|body| feature(one).has_curves(body))
        };
        let (features, rest): (Vec<_>, Vec<_>) =
            std::mem::take(&mut self.features).into_iter().partition(can);
        self.features = features;
        self.others.extend(rest.into_iter().map(|(item, _)| item));
    }
}

/// Base as an exact solid, with the number of the first face of each leaf.
pub(super) struct ExactBase {
    /// Exact solid; `None` if the tree is no valid solid without its features.
    body: Option<ExactBody>,
    first_faces: Vec<u32>,
}

impl ExactBase {
    /// Creates the exact solid of `of` minus the items.
    pub fn difference(of: &Solid, items: &[Subtree]) -> Self {
        let mut first_faces = Vec::new();
        number_leaves(of, 0, &mut first_faces);
        let tools = placed(items, &mut first_faces);
        Self { body: ExactBody::new(&of.clone().minus_all(tools)).ok(), first_faces }
    }

    /// Creates the exact solid of the union of all items.
    pub fn union(items: &[Subtree]) -> Self {
        let mut first_faces = Vec::new();
        let solids = placed(items, &mut first_faces);
        Self { body: ExactBody::new(&Solid::union(solids)).ok(), first_faces }
    }
}

fn placed(items: &[Subtree], first_faces: &mut Vec<u32>) -> Vec<Solid> {
    let place = |item: &Subtree| {
        number_leaves(item.core, item.first_face, first_faces);
        item.core.clone().placed(item.pose)
    };
    items.iter().map(place).collect()
}

fn number_leaves(solid: &Solid, mut next_face: u32, first_faces: &mut Vec<u32>) {
    for leaf in solid.leaves() {
        first_faces.push(next_face);
        next_face += face_count(leaf.primitive);
    }
}

pub(super) fn diagonal_mm(size_mm: [f64; 3]) -> f64 {
    size_mm.iter().map(|s| s * s).sum::<f64>().sqrt()
}
