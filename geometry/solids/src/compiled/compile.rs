//! Compilation of a solid tree to a flat list of nodes with bounding boxes.

use nalgebra::Vector3;

use super::boxes::{BoxTree, enlarge_for_rounding};
use super::shape::Primitive;
use crate::{Aabb, Pose, Solid};

/// Primitive with its pose in the root frame.
#[derive(Clone, Debug)]
pub(crate) struct CompiledLeaf {
    pub(crate) primitive: Primitive,
    pub(crate) leaf_from_root: Pose,
    /// Centre of the primitive, leaf frame; rays are recentred on it.
    pub(crate) centre: Vector3<f64>,
    /// Radius of a ball around `centre` that contains the primitive.
    pub(crate) reach_mm: f64,
    /// True below an odd number of subtractions: the primitive's inside is the body's outside.
    pub(crate) is_tool: bool,
}

#[derive(Clone, Debug)]
pub(crate) enum Node {
    Leaf(u32),
    Union(BoxTree),
    Intersection(Vec<u32>),
    Difference { of: u32, tools: u32 },
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Compiler {
    pub(crate) nodes: Vec<Node>,
    /// Bounds of each node, exact where documented so; empty where a node contains nothing.
    pub(crate) bounds: Vec<Aabb>,
    pub(crate) leaves: Vec<CompiledLeaf>,
}

impl Compiler {
    /// Adds a node and everything below it. Returns its number. Leaves are added in the order of [`Solid::leaves`].
    pub(crate) fn add(&mut self, solid: &Solid, root_from_here: Pose, is_tool: bool) -> u32 {
        match solid {
            Solid::Placed { pose, of } => self.add(of, root_from_here.then_in(*pose), is_tool),
            Solid::Feature { of, .. } => self.add(of, root_from_here, is_tool),
            Solid::Union(of) => self.any(of, root_from_here, is_tool),
            Solid::Intersection(of) => {
                let all: Vec<u32> =
                    of.iter().map(|child| self.add(child, root_from_here, is_tool)).collect();
                let bounds = all
                    .iter()
                    .fold(Aabb::everything(), |b, &child| b.common(&self.bounds[child as usize]));
                self.push(Node::Intersection(all), bounds)
            }
            Solid::Difference { of, minus } => {
                let of = self.add(of, root_from_here, is_tool);
                let tools = self.any(minus, root_from_here, !is_tool);
                // Tools only remove material, so the bounds of the minuend remain valid (if not tight).
                let bounds = self.bounds[of as usize];
                self.push(Node::Difference { of, tools }, bounds)
            }
            primitive => self.leaf(primitive, root_from_here, is_tool),
        }
    }

    /// Adds a union. Unions directly below it are flattened into it.
    fn any(&mut self, of: &[Solid], root_from_here: Pose, is_tool: bool) -> u32 {
        let mut members = Vec::new();
        for child in of {
            self.members(child, root_from_here, is_tool, &mut members);
        }
        if let [one] = members[..] {
            return one;
        }
        let bounds = |&node: &u32| self.bounds[node as usize];
        let hull = members.iter().map(bounds).fold(Aabb::nothing(), |all, b| all.hull(&b));
        let items =
            members.iter().map(|node| (*node, enlarge_for_rounding(&bounds(node)))).collect();
        self.push(Node::Union(BoxTree::new(items)), hull)
    }

    fn members(&mut self, solid: &Solid, pose: Pose, is_tool: bool, members: &mut Vec<u32>) {
        match solid {
            Solid::Placed { pose: inner, of } => {
                self.members(of, pose.then_in(*inner), is_tool, members);
            }
            Solid::Feature { of, .. } => self.members(of, pose, is_tool, members),
            Solid::Union(of) => {
                for child in of {
                    self.members(child, pose, is_tool, members);
                }
            }
            other => members.push(self.add(other, pose, is_tool)),
        }
    }

    fn leaf(&mut self, solid: &Solid, root_from_leaf: Pose, is_tool: bool) -> u32 {
        let Some(primitive) = Primitive::new(solid) else {
            unreachable!("booleans, placements and features are handled by the caller")
        };
        let bounds = primitive.bounds(&root_from_leaf);
        let own = primitive.bounds(&Pose::identity());
        let (centre, reach_mm) = if own.is_finite() {
            (own.centre().coords, 0.5 * (own.max - own.min).norm())
        } else {
            (Vector3::zeros(), f64::INFINITY)
        };
        let number = self.leaves.len() as u32;
        self.leaves.push(CompiledLeaf {
            primitive,
            leaf_from_root: root_from_leaf.inverse(),
            centre,
            // The margin keeps candidates that lie on the ball itself from being rejected by rounding.
            reach_mm: reach_mm * 1.001,
            is_tool,
        });
        self.push(Node::Leaf(number), bounds)
    }

    fn push(&mut self, node: Node, bounds: Aabb) -> u32 {
        self.nodes.push(node);
        self.bounds.push(if bounds.is_empty() { Aabb::nothing() } else { bounds });
        self.nodes.len() as u32 - 1
    }
}
