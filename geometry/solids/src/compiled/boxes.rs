//! Boxes against lines, and a tree of boxes for booleans with many children.

use nalgebra::{Point3, Vector3};

use crate::Aabb;

/// A line through the whole tree, in the root frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub(crate) origin: Point3<f64>,
    /// Unit.
    pub(crate) direction: Vector3<f64>,
    inverse: Vector3<f64>,
}

impl Line {
    pub(crate) fn new(origin: Point3<f64>, unit_direction: Vector3<f64>) -> Self {
        let inverse = unit_direction.map(|v| 1.0 / v);
        Self { origin, direction: unit_direction, inverse }
    }

    /// Whether the line meets the box. Exact touch may be missed, so boxes are grown beforehand.
    #[inline]
    pub(crate) fn meets(&self, bounds: &Aabb) -> bool {
        let (mut enter, mut exit) = (f64::NEG_INFINITY, f64::INFINITY);
        for i in 0..3 {
            let a = (bounds.min[i] - self.origin[i]) * self.inverse[i];
            let b = (bounds.max[i] - self.origin[i]) * self.inverse[i];
            // `min` and `max` pass over NaN: 0 times infinity, a line within a face.
            enter = enter.max(a.min(b));
            exit = exit.min(a.max(b));
        }
        enter <= exit
    }
}

/// How far boxes are grown, relative to their largest coordinate, so that rounding never hides
/// what they hold.
const GROWTH: f64 = 1e-9;

/// The box grown a little.
pub(crate) fn generous(bounds: &Aabb) -> Aabb {
    let reach = bounds.min.iter().chain(bounds.max.iter()).filter(|v| v.is_finite());
    bounds.grown(GROWTH * reach.fold(1.0f64, |r, v| r.max(v.abs())))
}

/// Fewer children than this are tested one by one.
const MIN_CHILDREN: usize = 6;

/// Children per lowest box.
const BUCKET: usize = 2;

/// Binary trees of this depth hold more children than memory does.
const MAX_STACK: usize = 64;

/// Children of a boolean, found by box.
#[derive(Clone, Debug)]
pub(crate) struct Children {
    /// Node numbers and boxes, in tree order if there are few, else in the order of the buckets.
    items: Vec<(u32, Aabb)>,
    tree: Vec<Branch>,
}

/// A box over `items[first..end]`; without `second`, a bucket.
#[derive(Clone, Debug)]
struct Branch {
    bounds: Aabb,
    first: u32,
    end: u32,
    /// Where the second half's branch stands; the first half's follows its parent.
    second: Option<u32>,
}

impl Children {
    /// From node numbers with (generous) boxes.
    pub(crate) fn new(mut items: Vec<(u32, Aabb)>) -> Self {
        let mut tree = Vec::new();
        if items.len() >= MIN_CHILDREN {
            let count = items.len();
            grow(&mut items, 0, count, &mut tree);
        }
        Self { items, tree }
    }

    /// Calls `visit` for the children whose boxes pass `test`, until it returns `true`; returns
    /// whether it did.
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

/// Splits at the median along the longest side; depth is the logarithm of the number of children.
fn grow(items: &mut [(u32, Aabb)], first: usize, end: usize, tree: &mut Vec<Branch>) {
    let here = tree.len();
    let slice = &mut items[first..end];
    let bounds = slice.iter().fold(Aabb::nothing(), |all, item| all.hull(&item.1));
    tree.push(Branch { bounds, first: first as u32, end: end as u32, second: None });
    if slice.len() <= BUCKET {
        return;
    }
    let middles = slice.iter().fold(Aabb::nothing(), |all, item| {
        let centre = middle(&item.1);
        all.hull(&Aabb { min: centre, max: centre })
    });
    let size = middles.size_mm();
    let axis = (0..3).max_by(|&i, &j| size[i].total_cmp(&size[j])).unwrap_or(0);
    slice.sort_by(|a, b| {
        middle(&a.1)[axis].total_cmp(&middle(&b.1)[axis]).then_with(|| a.0.cmp(&b.0))
    });
    let half = first + (end - first) / 2;
    grow(items, first, half, tree);
    tree[here].second = Some(tree.len() as u32);
    grow(items, half, end, tree);
}

/// Centre of a box; of an unbounded one, something finite.
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
        let children = Children::new(items.clone());
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
        assert!(line.meets(&generous(&bounds)));
        assert!(!line.meets(&generous(&cube(1.0, 0.0))));
    }
}
