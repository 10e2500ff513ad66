//! Extraction of operands' features from the tree, and their insertion into the finished mesh.
//!
//! A mold is a block minus a layer, and the layer has hundreds of dimples. Evaluated as written, the block would be cut
//! by a mesh full of dimples; here it is cut by the bare layer, and the dimples follow (`conform/operand_features.rs` states the
//! conditions).

use std::ops::Range;
use std::rc::Rc;

use fabkit_geometry::{Aabb, CompiledSolid as ExactBody, Pose, Solid};

use super::features::{LARGEST_SHARE, diagonal_mm};
use super::{Evaluator, Subtree};
use crate::MeshError;
use crate::conform::{Base, Effect, Feature, FeatureTree, RevolvedTool, conform};
use crate::extent::extent;
use crate::facets::Facets;
use crate::tessellate::face_count;

/// Smallest number of features that are extracted.
const MIN_FEATURES: usize = 8;

impl Evaluator {
    /// Returns the mesh; `None` if there are too few features, or some that cannot be inserted.
    pub(super) fn evaluate_with_deferred_features(
        &mut self,
        root: &Subtree,
    ) -> Result<Option<Facets>, MeshError> {
        let mut lift = Lift { evaluator: self, features: Vec::new(), faces: Vec::new(), leaves: 0 };
        let mut next_face = root.first_face;
        let bare = lift.strip_features(root.core, root.pose, true, &mut next_face)?;
        let Lift { features, faces, .. } = lift;
        if features.len() < MIN_FEATURES {
            return Ok(None);
        }
        let mut facets = self.evaluate_as_written(&Subtree::peel(Pose::identity(), &bare, 0))?;
        for face in &mut facets.faces {
            *face = faces[*face as usize];
        }
        // The exact solids with and without features decide about inside and outside.
        let placed = root.core.clone().placed(root.pose);
        let (Ok(with), Ok(without)) = (ExactBody::new(&placed), ExactBody::new(&bare)) else {
            return Ok(None);
        };
        let (mut leaves, mut first_faces, mut first) = (Facets::default(), Vec::new(), 0);
        for (number, leaf) in (0..).zip(bare.leaves()) {
            first_faces.push(faces[first as usize]);
            first += face_count(leaf.primitive);
            // Half spaces have no triangles; `conform/operand_features.rs` tests their planes directly.
            if !matches!(leaf.primitive, Solid::HalfSpace(_)) {
                let item = Subtree::peel(Pose::identity(), leaf.primitive, 0);
                let shape = self.body(&item, &Aabb::everything())?.shape;
                let counted = leaves.faces.len();
                leaves.append(shape.facets(), &leaf.root_from_leaf, 0);
                leaves.faces[counted..].fill(number);
            }
        }
        let base = Base { facets: &facets, body: &without, first_faces: &first_faces };
        let whole = FeatureTree { body: with, leaves };
        let done = conform(&base, &features, &Effect::FromTree(&whole), self.tolerance_mm);
        Ok(done.and_then(|(facets, left)| left.is_empty().then_some(facets)))
    }
}

struct Lift<'e> {
    evaluator: &'e mut Evaluator,
    features: Vec<Feature>,
    /// Number in the whole tree of each face of the bare tree.
    faces: Vec<u32>,
    /// Number of leaves of the bare tree so far.
    leaves: u32,
}

impl Lift<'_> {
    /// Returns the tree without the features of its operands. Operands of the root itself stay, because they cost
    /// nothing extra.
    fn strip_features(
        &mut self,
        solid: &Solid,
        pose: Pose,
        is_root: bool,
        next_face: &mut u32,
    ) -> Result<Solid, MeshError> {
        Ok(match solid {
            Solid::Placed { pose: inner, of } => {
                self.strip_features(of, pose.then_in(*inner), is_root, next_face)?
            }
            Solid::Feature { name, of } => {
                self.strip_features(of, pose, is_root, next_face)?.named(name.clone())
            }
            Solid::Union(of) => Solid::Union(self.operands(of, pose, is_root, next_face)?),
            Solid::Intersection(of) => {
                let bare = of.iter().map(|one| self.strip_features(one, pose, false, next_face));
                Solid::Intersection(bare.collect::<Result<_, _>>()?)
            }
            Solid::Difference { of, minus } => {
                let all: Vec<&Solid> = std::iter::once(&**of).chain(minus).collect();
                let mut bare = self.operands(all, pose, is_root, next_face)?;
                let tools = bare.split_off(1);
                bare.swap_remove(0).minus_all(tools)
            }
            primitive => {
                let count = face_count(primitive);
                self.faces.extend(*next_face..*next_face + count);
                *next_face += count;
                self.leaves += 1;
                primitive.clone().placed(pose)
            }
        })
    }

    /// Returns the bare operands of a union, or of a difference (its base and its tools).
    fn operands<'a>(
        &mut self,
        all: impl IntoIterator<Item = &'a Solid>,
        pose: Pose,
        is_root: bool,
        next_face: &mut u32,
    ) -> Result<Vec<Solid>, MeshError> {
        let all: Vec<&Solid> = all.into_iter().collect();
        let sizes = all.iter().map(|one| diagonal_mm(extent(one).size_mm()));
        let largest_mm = sizes.filter(|s| s.is_finite()).fold(0.0, f64::max);
        let (first_leaf, first_feature) = (self.leaves, self.features.len());
        let mut bare = Vec::with_capacity(all.len());
        for one in all {
            let item = Subtree::peel(pose, one, *next_face);
            let is_small = |pin: &Rc<RevolvedTool>| pin.diagonal_mm() <= LARGEST_SHARE * largest_mm;
            let pin = if is_root { None } else { self.evaluator.pin(&item)?.filter(is_small) };
            match pin {
                // The first operand stays: the features need something to conform to.
                Some(pin) if !bare.is_empty() => {
                    self.features.push(Feature {
                        pin,
                        base_from_tool: item.pose,
                        first_face: item.first_face,
                        operand: None,
                    });
                    *next_face += face_count(one);
                }
                _ => bare.push(self.strip_features(one, pose, false, next_face)?),
            }
        }
        let operand: Range<u32> = first_leaf..self.leaves;
        // Features of deeper operands have their operand already.
        for feature in &mut self.features[first_feature..] {
            feature.operand.get_or_insert(operand.clone());
        }
        Ok(bare)
    }
}
