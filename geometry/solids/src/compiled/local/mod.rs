//! Proofs that bodies have nothing in common, box by box.
//!
//! Within a small box, few faces of a body are left, and what of the body lies in the box is a
//! formula of their sides: behind the sphere and beyond the plane. Bodies that touch share a surface
//! there and lie on its two sides, so that the formula of what they have in common contradicts
//! itself. Boxes in which it does not are halved, down to a limit; what is left has to be looked at.
//! It is the pruning of trees that spatial subdivision of constructive geometry is known for (Woodwark
//! and Quinlan, "Reducing the Effect of Complexity on Volume Model Evaluation", 1982).

mod leaf;
mod plane;
mod surface;

use std::collections::VecDeque;

use nalgebra::{Point3, Vector3};

use self::leaf::{Faces, Leaf, Local};
use self::surface::{Families, Literal, SAME_MM};
use super::{CompiledSolid, Node};
use crate::Aabb;

/// Faces that enter a box by less do not, mm; far above rounding, far below what counts as an
/// overlap.
const SLACK_MM: f64 = 1e-11;

/// How much more than a box is searched for faces through which lines leave it, mm, so that a face
/// between two boxes belongs to one of them.
const BETWEEN_MM: f64 = 1e-9;

/// Conjunctions at most that a box's formula may have; beyond, the box is halved.
const MOST_TERMS: usize = 64;

/// A box by its middle.
#[derive(Clone, Copy, Debug)]
struct Cell {
    centre: Point3<f64>,
    half: Vector3<f64>,
}

impl Cell {
    fn of(bounds: &Aabb) -> Self {
        Self { centre: bounds.centre(), half: 0.5 * (bounds.max - bounds.min) }
    }
}

/// Points on given sides of surfaces: in one of several conjunctions. Where there are too many, it
/// is all of the box, which holds what is meant and proves nothing.
#[derive(Clone, Debug, PartialEq)]
struct Sides(Vec<Vec<Literal>>);

impl Sides {
    /// Nothing of a solid: nothing, or where its outside is asked for, everything.
    fn none(positive: bool) -> Self {
        if positive { Self(Vec::new()) } else { Self::everything() }
    }

    fn everything() -> Self {
        Self(vec![Vec::new()])
    }

    fn is_nothing(&self) -> bool {
        self.0.is_empty()
    }

    fn is_everything(&self) -> bool {
        self.0.iter().any(Vec::is_empty)
    }

    /// Behind all of some surfaces, or where their outside is asked for, all other points.
    fn behind(literals: &[Literal], inside: bool) -> Self {
        match inside {
            true => Self(vec![literals.to_vec()]),
            false => Self(literals.iter().map(|l| vec![l.negated()]).collect()),
        }
    }

    /// What is in either.
    fn join(mut self, other: Self) -> Self {
        if self.is_everything() || other.is_everything() {
            return Self::everything();
        }
        self.0.extend(other.0);
        if self.0.len() > MOST_TERMS { Self::everything() } else { self }
    }

    /// What is in both; terms that contradict themselves go.
    fn meet(self, other: &Self) -> Self {
        if self.is_nothing() || other.is_everything() {
            return self;
        }
        if other.is_nothing() || self.is_everything() {
            return other.clone();
        }
        let mut terms = Vec::new();
        for a in &self.0 {
            for b in &other.0 {
                if a.iter().any(|x| b.iter().any(|y| x.excludes(y))) {
                    continue;
                }
                if terms.len() == MOST_TERMS {
                    // Either alone holds more than both.
                    return self;
                }
                let new = b.iter().filter(|y| !a.contains(y));
                terms.push(a.iter().chain(new).copied().collect());
            }
        }
        Self(terms)
    }
}

/// A body with the surfaces that have been asked for.
struct Asked<'a> {
    body: &'a CompiledSolid,
    faces: Vec<Faces>,
}

impl<'a> Asked<'a> {
    fn new(body: &'a CompiledSolid) -> Self {
        Self { body, faces: vec![Faces::default(); body.leaves.len()] }
    }

    /// What of a primitive lies in a box.
    fn local(&mut self, leaf: u32, cell: &Cell, families: &mut Families<'a>) -> Local {
        let index = leaf as usize;
        let mut leaf = Leaf {
            primitive: &self.body.compiled[index].primitive,
            leaf: &self.body.leaves[index],
            faces: &mut self.faces[index],
            families,
        };
        leaf.local(cell)
    }

    /// Whether a line in this direction may leave the body within a box. `bounds` is the box,
    /// grown a little.
    fn may_leave(
        &mut self,
        node: u32,
        cell: &Cell,
        bounds: &Aabb,
        direction: &Vector3<f64>,
        families: &mut Families<'a>,
    ) -> bool {
        let body = self.body;
        match &body.nodes[node as usize] {
            Node::Leaf(leaf) => {
                let local = self.local(*leaf, &Cell::of(bounds), families);
                let is_tool = body.compiled[*leaf as usize].is_tool;
                let leaves = |face: &Literal| {
                    let face = if is_tool { face.negated() } else { *face };
                    families.may_leave(&face, &cell.centre, &cell.half, direction)
                };
                !local.is_nothing() && local.faces().is_none_or(|mut faces| faces.any(leaves))
            }
            Node::Any(children) => children.find(
                |b| !is_apart(b, bounds),
                |child| self.may_leave(child, cell, bounds, direction, families),
            ),
            Node::All(children) => children.iter().any(|&child| {
                !is_apart(&body.boxes[child as usize], bounds)
                    && self.may_leave(child, cell, bounds, direction, families)
            }),
            Node::Minus { of, tools } => [*of, *tools].into_iter().any(|child| {
                !is_apart(&body.boxes[child as usize], bounds)
                    && self.may_leave(child, cell, bounds, direction, families)
            }),
        }
    }

    /// What of a node, or of its outside, lies in a box; never less.
    fn sides(
        &mut self,
        node: u32,
        cell: &Cell,
        bounds: &Aabb,
        positive: bool,
        families: &mut Families<'a>,
    ) -> Sides {
        let body = self.body;
        let is_beside = |node: u32| is_apart(&body.boxes[node as usize], bounds);
        match &body.nodes[node as usize] {
            Node::Leaf(leaf) => self.local(*leaf, cell, families).sides(positive),
            Node::Any(children) => {
                let mut near = Vec::new();
                children.find(
                    |b| !is_apart(b, bounds),
                    |child| {
                        near.push(child);
                        false
                    },
                );
                let mut sum = Sides::none(positive);
                for child in near {
                    let part = self.sides(child, cell, bounds, positive, families);
                    sum = if positive { sum.join(part) } else { sum.meet(&part) };
                    if if positive { sum.is_everything() } else { sum.is_nothing() } {
                        break;
                    }
                }
                sum
            }
            Node::All(children) => {
                let mut sum = Sides::none(!positive);
                for &child in children {
                    if is_beside(child) {
                        return Sides::none(positive);
                    }
                    let part = self.sides(child, cell, bounds, positive, families);
                    sum = if positive { sum.meet(&part) } else { sum.join(part) };
                }
                sum
            }
            Node::Minus { of, tools } => {
                if is_beside(*of) {
                    return Sides::none(positive);
                }
                let of = self.sides(*of, cell, bounds, positive, families);
                if (positive && of.is_nothing()) || is_beside(*tools) {
                    return of;
                }
                let rest = self.sides(*tools, cell, bounds, !positive, families);
                if positive { of.meet(&rest) } else { of.join(rest) }
            }
        }
    }
}

/// Whether two boxes have no more than faces in common.
fn is_apart(a: &Aabb, b: &Aabb) -> bool {
    (0..3).any(|i| a.min[i] >= b.max[i] || b.min[i] >= a.max[i])
}

/// Boxes within `bounds` outside of which two bodies have nothing in common but contact thinner
/// than 1e-9 mm; none if that is proven for all of it.
///
/// At most `budget` boxes are looked at.
pub(crate) fn meeting_boxes(
    a: &CompiledSolid,
    b: &CompiledSolid,
    bounds: &Aabb,
    budget: usize,
) -> Vec<Aabb> {
    let mut families = Families::default();
    let (mut in_a, mut in_b) = (Asked::new(a), Asked::new(b));
    if (bounds.max - bounds.min).min() <= SAME_MM {
        return Vec::new();
    }
    halved(bounds, budget, |bounds| {
        let cell = Cell::of(bounds);
        let of_a = in_a.sides(a.root, &cell, bounds, true, &mut families);
        if of_a.is_nothing() {
            return Verdict::Proven;
        }
        let common = of_a.meet(&in_b.sides(b.root, &cell, bounds, true, &mut families));
        match common.is_nothing() {
            true => Verdict::Proven,
            // Neither has a face here: halves would say no more.
            false if common.is_everything() => Verdict::Hopeless,
            false => Verdict::Open,
        }
    })
}

/// Boxes outside of whose shadows along an axis of the frame no line leaves a tool and meets any of
/// the other bodies further on; none if that is proven of all lines.
///
/// `forwards` tells the line's direction along the axis. At most `budget` boxes are looked at. `None`
/// where the bodies are not bounded.
pub(crate) fn held_boxes(
    tool: &CompiledSolid,
    others: &[&CompiledSolid],
    axis: usize,
    forwards: bool,
    budget: usize,
) -> Option<Vec<Aabb>> {
    let hull = others.iter().fold(Aabb::nothing(), |sum, other| sum.hull(&other.bounds()));
    let mut bounds = tool.bounds().common(&hull);
    // Along the axis, from where the tool begins to where the others end.
    if forwards {
        bounds.min[axis] = tool.bounds().min[axis];
        bounds.max[axis] = hull.max[axis];
    } else {
        bounds.min[axis] = hull.min[axis];
        bounds.max[axis] = tool.bounds().max[axis];
    }
    if bounds.is_empty() {
        return Some(Vec::new());
    }
    if !bounds.is_finite() {
        return None;
    }
    let mut direction = Vector3::zeros();
    direction[axis] = if forwards { 1.0 } else { -1.0 };
    let all = bounds;
    let mut families = Families::default();
    let mut in_tool = Asked::new(tool);
    let mut in_others: Vec<Asked> = others.iter().map(|other| Asked::new(other)).collect();
    Some(halved(&all, budget, |bounds| {
        let cell = Cell::of(bounds);
        let of_tool = in_tool.sides(tool.root, &cell, bounds, true, &mut families);
        let grown = bounds.grown(BETWEEN_MM);
        if of_tool.is_nothing()
            || !in_tool.may_leave(tool.root, &cell, &grown, &direction, &mut families)
        {
            return Verdict::Proven;
        }
        let mut ahead = *bounds;
        match forwards {
            true => ahead.max[axis] = all.max[axis],
            false => ahead.min[axis] = all.min[axis],
        }
        let column = Cell::of(&ahead);
        let is_free = in_others.iter_mut().all(|other| {
            let root = other.body.root;
            other.sides(root, &column, &ahead, true, &mut families).is_nothing()
        });
        if is_free { Verdict::Proven } else { Verdict::Open }
    }))
}

/// What is known of a box.
enum Verdict {
    /// Nothing in it has to be looked at.
    Proven,
    /// Something may have to be, and its halves may tell.
    Open,
    /// Something may have to be, and its halves would not tell either.
    Hopeless,
}

/// The boxes that are left of one when those that are open are halved again and again; at most
/// `budget` are judged.
fn halved(bounds: &Aabb, budget: usize, mut judge: impl FnMut(&Aabb) -> Verdict) -> Vec<Aabb> {
    let mut left = Vec::new();
    let mut queue = VecDeque::from([*bounds]);
    let mut judged = 0;
    while let Some(bounds) = queue.pop_front() {
        if judged == budget {
            left.push(bounds);
            continue;
        }
        judged += 1;
        match judge(&bounds) {
            Verdict::Proven => {}
            Verdict::Open => queue.extend(halves(&bounds)),
            Verdict::Hopeless => left.push(bounds),
        }
    }
    left
}

fn halves(bounds: &Aabb) -> [Aabb; 2] {
    let axis = (bounds.max - bounds.min).imax();
    let middle = 0.5 * (bounds.min[axis] + bounds.max[axis]);
    let (mut low, mut high) = (*bounds, *bounds);
    low.max[axis] = middle;
    high.min[axis] = middle;
    [low, high]
}
