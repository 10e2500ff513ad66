//! Line-box intersection, and a tree of boxes for booleans with many children.

use nalgebra::{Point3, Vector3};

use crate::Aabb;

/// Line through the whole solid tree, in the root frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub(crate) origin: Point3<f64>,
    /// Unit direction.
    pub(crate) direction: Vector3<f64>,
    inverse: Vector3<f64>,
}

impl Line {
    pub(crate) fn new(origin: Point3<f64>, unit_direction: Vector3<f64>) -> Self {
        let inverse = unit_direction.map(|v| 1.0 / v);
        Self { origin, direction: unit_direction, inverse }
    }

    /// Returns whether the line meets the box. Exact touch may be missed, so boxes are enlarged beforehand.
    #[inline]
    pub(crate) fn meets(&self, bounds: &Aabb) -> bool {
        let (mut enter, mut exit) = (f64::NEG_INFINITY, f64::INFINITY);
        for i in 0..3 {
            let a = (bounds.min[i] - self.origin[i]) * self.inverse[i];
            let b = (bounds.max[i] - self.origin[i]) * self.inverse[i];
            // `f64::min` and `f64::max` ignore NaN, which arises as 0 times infinity for a line within a face.
            enter = enter.max(a.min(b));
            exit = exit.min(a.max(b));
        }
        enter <= exit
    }
}

/// Growth of a box relative to its largest coordinate, so that rounding never hides its contents.
const GROWTH: f64 = 1e-9;

/// Enlarges the box by [`GROWTH`] to cover rounding errors.
pub(crate) fn enlarge_for_rounding(bounds: &Aabb) -> Aabb {
    let reach = bounds.min.iter().chain(bounds.max.iter()).filter(|v| v.is_finite());
    bounds.grown(GROWTH * reach.fold(1.0f64, |r, v| r.max(v.abs())))
}

/// Smallest number of children for which a tree is built; fewer are tested one by one.
const MIN_CHILDREN: usize = 6;

/// Largest number of children in a leaf of the tree.
const BUCKET: usize = 2;

/// Stack size of the traversal: a binary tree of this depth holds more children than fit in memory.
const MAX_STACK: usize = 64;

/// Children of a boolean, searched by bounding box.
#[derive(Clone, Debug)]
pub(crate) struct BoxTree {
    /// Node numbers and boxes: in the order of the solid tree if there are few, else in the order of the buckets.
    items: Vec<(u32, Aabb)>,
    tree: Vec<Branch>,
}

/// Tree node with a box around `items[first..end]`; a bucket if `second` is `None`.
#[derive(Clone, Debug)]
struct Branch {
    bounds: Aabb,
    first: u32,
    end: u32,
    /// Index of the second half's branch; the first half's branch directly follows its parent.
    second: Option<u32>,
}

impl BoxTree {
    /// Builds the tree from node numbers and their (enlarged) boxes.
    pub(crate) fn new(mut items: Vec<(u32, Aabb)>) -> Self {
        let mut tree = Vec::new();
        if items.len() >= MIN_CHILDREN {
            let count = items.len();
            grow(&mut items, 0, count, &mut tree);
        }
        Self { items, tree }
    }

    /// Calls `visit` for the children whose boxes pass `test`, until it returns `true`. Returns whether it did.
    #[inline]
    pub(crate) fn find(
        &self,
        test: impl Fn(&Aabb) -> bool,
        mut visit: impl FnMut(u32) -> bool,
    ) -> bool {
        let mut among =
            |items: &[(u32, Aabb)]| items.iter().any(|(node, bounds)| test(bounds) && visit(*node));
        if self.tree.is_empty() {
            return among(&self.items);
        }
        let mut stack = [0u32; MAX_STACK];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let at = stack[depth];
            let branch = &self.tree[at as usize];
            if !test(&branch.bounds) {
                continue;
            }
            match branch.second {
                None => {
                    if among(&self.items[branch.first as usize..branch.end as usize]) {
                        return true;
                    }
                }
                Some(second) => {
                    stack[depth] = second;
                    stack[depth + 1] = at + 1;
                    depth += 2;
                }
            }
        }
        false
    }
}

/// Adds the branch of `items[first..end]` and splits it at the median along the longest side. The depth grows with the
/// logarithm of the number of children.
fn grow(items: &mut [(u32, Aabb)], first: usize, end: usize, tree: &mut Vec<Branch>) {
    let here = tree.len();
    let slice = &mut items[first..end];
    let bounds = slice.iter().fold(Aabb::nothing(), |all, item| all.hull(&item.1));
    tree.push(Branch { bounds, first: first as u32, end: end as u32, second: None });
    if slice.len() <= BUCKET {
        return;
    }
    // The split axis follows the spread of the centres, not the box: large children would hide it.
    let middles = slice.iter().fold(Aabb::nothing(), |all, item| {
        let centre = middle(&item.1);
        all.hull(&Aabb { min: centre, max: centre })
    });
    let size = middles.size_mm();
    let axis = (0..3).max_by(|&i, &j| size[i].total_cmp(&size[j])).unwrap_or(0);
    slice.sort_by(|a, b| {
        // Ties are broken by node number, so that the tree does not depend on the input order.
        middle(&a.1)[axis].total_cmp(&middle(&b.1)[axis]).then_with(|| a.0.cmp(&b.0))
    });
    let half = first + (end - first) / 2;
    grow(items, first, half, tree);
    tree[here].second = Some(tree.len() as u32);
    grow(items, half, end, tree);
}

/// Centre of a box, with 0 for each coordinate that is not finite.
fn middle(bounds: &Aabb) -> Point3<f64> {
    bounds.centre().map(|v| if v.is_finite() { v } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(x: f64, y: f64) -> Aabb {
        Aabb { min: Point3::new(x, y, 0.0), max: Point3::new(x + 0.5, y + 0.5, 0.5) }
    }

    #[test]
    fn the_tree_finds_what_a_plain_search_finds() {
        let items: Vec<_> =
            (0..400u32).map(|i| (i, cube(f64::from(i % 20), f64::from(i / 20)))).collect();
        let children = BoxTree::new(items.clone());
        assert!(!children.tree.is_empty());
        for k in 0..200 {
            let angle = f64::from(k) * 0.1;
            let direction = Vector3::new(angle.cos(), angle.sin(), 0.01);
            let line = Line::new(Point3::new(10.0 + angle, 9.0, 0.2), direction.normalize());
            let mut found = Vec::new();
            children.find(
                |b| line.meets(b),
                |node| {
                    found.push(node);
                    false
                },
            );
            found.sort_unstable();
            let plain: Vec<u32> = items.iter().filter(|i| line.meets(&i.1)).map(|i| i.0).collect();
            assert_eq!(found, plain);
        }
    }

    #[test]
    fn a_line_along_a_grown_face_meets_the_box() {
        let bounds = cube(0.0, 0.0);
        let line = Line::new(Point3::new(0.0, -3.0, 0.5), Vector3::y());
        assert!(line.meets(&enlarge_for_rounding(&bounds)));
        assert!(!line.meets(&enlarge_for_rounding(&cube(1.0, 0.0))));
    }
}
