//! Proof that bodies do not overlap, by subdivision into boxes.
//!
//! Few faces of a body cross a small box, and the part of the body in the box is a formula of their sides: behind the
//! sphere and beyond the plane. Bodies that touch share a surface there and lie on its two sides, so that the formula
//! of their intersection contradicts itself. Boxes with a formula that does not contradict itself are halved, down to a
//! limit; the boxes that remain have to be examined otherwise. This is the tree pruning known from spatial subdivision
//! of constructive solid geometry (Woodwark and Quinlan, "Reducing the Effect of Complexity on Volume Model
//! Evaluation", 1982).

mod leaf;
mod plane;
mod surface;

use std::collections::VecDeque;

use nalgebra::{Point3, Vector3};

use self::leaf::{Faces, Leaf, Local};
use self::surface::{Families, Literal, SAME_MM};
use super::{CompiledSolid, Node};
use crate::Aabb;

/// Depth up to which a face that enters a box is ignored, mm: far above rounding, far below what counts as an overlap.
const SLACK_MM: f64 = 1e-11;

/// Margin around a box within which exit faces of lines are searched, mm, so that a face between two boxes belongs to
/// at least one of them.
const BETWEEN_MM: f64 = 1e-9;

/// Largest number of conjunctions in the formula of a box; beyond it, the box is halved.
const MOST_TERMS: usize = 64;

/// Box given by its centre and half edges.
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

/// Points on given sides of surfaces, as a disjunction of conjunctions. If there would be too many terms, it becomes
/// the whole box: a superset that proves nothing.
#[derive(Clone, Debug, PartialEq)]
struct SideFormula(Vec<Vec<Literal>>);

impl SideFormula {
    /// Formula for an empty solid: no point, or every point if its outside is meant (`positive` is false).
    fn empty(positive: bool) -> Self {
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

    /// Formula for the points behind all given surfaces, or (if `inside` is false) for all other points.
    fn behind(literals: &[Literal], inside: bool) -> Self {
        if inside {
            Self(vec![literals.to_vec()])
        } else {
            Self(literals.iter().map(|l| vec![l.negated()]).collect())
        }
    }

    /// Returns the union.
    fn join(mut self, other: Self) -> Self {
        if self.is_everything() || other.is_everything() {
            return Self::everything();
        }
        self.0.extend(other.0);
        if self.0.len() > MOST_TERMS { Self::everything() } else { self }
    }

    /// Returns the intersection, without terms that contradict themselves.
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
                    // Too many terms: one operand alone is still a superset of the intersection.
                    return self;
                }
                let new = b.iter().filter(|y| !a.contains(y));
                terms.push(a.iter().chain(new).copied().collect());
            }
        }
        Self(terms)
    }
}

/// Body with the surfaces created for it so far.
struct LocalBody<'a> {
    body: &'a CompiledSolid,
    faces: Vec<Faces>,
}

impl<'a> LocalBody<'a> {
    fn new(body: &'a CompiledSolid) -> Self {
        Self { body, faces: vec![Faces::default(); body.leaves.len()] }
    }

    /// Returns the part of a primitive that lies in a box.
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

    /// Returns whether a line in this direction may leave the body within a box. `bounds` is the box, slightly
    /// enlarged.
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
            Node::Union(children) => children.find(
                |b| !is_apart(b, bounds),
                |child| self.may_leave(child, cell, bounds, direction, families),
            ),
            Node::Intersection(children) => children.iter().any(|&child| {
                !is_apart(&body.boxes[child as usize], bounds)
                    && self.may_leave(child, cell, bounds, direction, families)
            }),
            Node::Difference { of, tools } => [*of, *tools].into_iter().any(|child| {
                !is_apart(&body.boxes[child as usize], bounds)
                    && self.may_leave(child, cell, bounds, direction, families)
            }),
        }
    }

    /// Returns a formula for the part of a node (or, if `positive` is false, of its outside) that lies in a box: never
    /// a smaller set than the exact one.
    fn sides(
        &mut self,
        node: u32,
        cell: &Cell,
        bounds: &Aabb,
        positive: bool,
        families: &mut Families<'a>,
    ) -> SideFormula {
        let body = self.body;
        let is_beside = |node: u32| is_apart(&body.boxes[node as usize], bounds);
        match &body.nodes[node as usize] {
            Node::Leaf(leaf) => self.local(*leaf, cell, families).sides(positive),
            Node::Union(children) => {
                let mut near = Vec::new();
                children.find(
                    |b| !is_apart(b, bounds),
                    |child| {
                        near.push(child);
                        false
                    },
                );
                // By De Morgan's laws the outside of a union is the intersection of the outsides.
                let mut sum = SideFormula::empty(positive);
                for child in near {
                    let part = self.sides(child, cell, bounds, positive, families);
                    sum = if positive { sum.join(part) } else { sum.meet(&part) };
                    if if positive { sum.is_everything() } else { sum.is_nothing() } {
                        break;
                    }
                }
                sum
            }
            Node::Intersection(children) => {
                let mut sum = SideFormula::empty(!positive);
                for &child in children {
                    if is_beside(child) {
                        return SideFormula::empty(positive);
                    }
                    let part = self.sides(child, cell, bounds, positive, families);
                    sum = if positive { sum.meet(&part) } else { sum.join(part) };
                }
                sum
            }
            Node::Difference { of, tools } => {
                if is_beside(*of) {
                    return SideFormula::empty(positive);
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

/// Returns whether two boxes share at most faces.
fn is_apart(a: &Aabb, b: &Aabb) -> bool {
    (0..3).any(|i| a.min[i] >= b.max[i] || b.min[i] >= a.max[i])
}

/// Returns the boxes within `bounds` outside of which two bodies are proven to share nothing but contact thinner than
/// 1e-9 mm; none if that is proven everywhere.
///
/// At most `budget` boxes are examined.
pub(crate) fn subdivide_for_overlap(
    a: &CompiledSolid,
    b: &CompiledSolid,
    bounds: &Aabb,
    budget: usize,
) -> Vec<Aabb> {
    let mut families = Families::default();
    let (mut in_a, mut in_b) = (LocalBody::new(a), LocalBody::new(b));
    // A box this thin contains only contact.
    if (bounds.max - bounds.min).min() <= SAME_MM {
        return Vec::new();
    }
    subdivide(bounds, budget, |bounds| {
        let cell = Cell::of(bounds);
        let of_a = in_a.sides(a.root, &cell, bounds, true, &mut families);
        if of_a.is_nothing() {
            return Verdict::Proven;
        }
        let common = of_a.meet(&in_b.sides(b.root, &cell, bounds, true, &mut families));
        match common.is_nothing() {
            true => Verdict::Proven,
            // Neither body has a face in this box: its halves would tell no more.
            false if common.is_everything() => Verdict::Hopeless,
            false => Verdict::Open,
        }
    })
}

/// Returns boxes such that a line along an axis of the frame that leaves the tool and then meets one of the other
/// bodies passes through one of them; none if that is excluded for all lines.
///
/// `forwards` is the line's direction along the axis. At most `budget` boxes are examined. Returns `None` where the
/// bodies are unbounded.
pub(crate) fn subdivide_for_obstacles(
    tool: &CompiledSolid,
    others: &[&CompiledSolid],
    axis: usize,
    forwards: bool,
    budget: usize,
) -> Option<Vec<Aabb>> {
    let hull = others.iter().fold(Aabb::nothing(), |sum, other| sum.hull(&other.bounds()));
    let mut bounds = tool.bounds().common(&hull);
    // Along the axis the search reaches from the start of the tool to the end of the others.
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
    let mut in_tool = LocalBody::new(tool);
    let mut in_others: Vec<LocalBody> = others.iter().map(|other| LocalBody::new(other)).collect();
    Some(subdivide(&all, budget, |bounds| {
        let cell = Cell::of(bounds);
        let of_tool = in_tool.sides(tool.root, &cell, bounds, true, &mut families);
        // Enlarged, so that a face on the border between two boxes is found from one of them.
        let grown = bounds.grown(BETWEEN_MM);
        if of_tool.is_nothing()
            || !in_tool.may_leave(tool.root, &cell, &grown, &direction, &mut families)
        {
            return Verdict::Proven;
        }
        // Everything that the tool's part in this box sweeps on its way out.
        let mut ahead = *bounds;
        if forwards {
            ahead.max[axis] = all.max[axis]
        } else {
            ahead.min[axis] = all.min[axis]
        }
        let column = Cell::of(&ahead);
        let is_free = in_others.iter_mut().all(|other| {
            let root = other.body.root;
            other.sides(root, &column, &ahead, true, &mut families).is_nothing()
        });
        if is_free { Verdict::Proven } else { Verdict::Open }
    }))
}

/// Result of examining a box.
enum Verdict {
    /// Nothing in the box needs further examination.
    Proven,
    /// The box may contain an overlap, and its halves may decide.
    Open,
    /// The box may contain an overlap, and its halves would not decide either.
    Hopeless,
}

/// Halves open boxes repeatedly, breadth first, and returns those that are not proven. At most `budget` boxes are
/// judged.
fn subdivide(bounds: &Aabb, budget: usize, mut judge: impl FnMut(&Aabb) -> Verdict) -> Vec<Aabb> {
    let mut left = Vec::new();
    let mut queue = VecDeque::from([*bounds]);
    let mut judged = 0;
    while let Some(bounds) = queue.pop_front() {
        // Boxes beyond the budget count as not proven.
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
    // The longest edge is halved, so that boxes stay compact.
    let axis = (bounds.max - bounds.min).imax();
    let middle = 0.5 * (bounds.min[axis] + bounds.max[axis]);
    let (mut low, mut high) = (*bounds, *bounds);
    low.max[axis] = middle;
    high.min[axis] = middle;
    [low, high]
}
