//! Approximate extents of solids: boxes that are never too small.

use fabkit_geometry::{Aabb, Path, Point3, Pose, Segment, Solid, Vector3};

/// Returns a box around a solid, in the solid's own frame; infinite where the solid is unbounded.
pub(crate) fn extent(solid: &Solid) -> Aabb {
    let centred =
        |x: f64, y: f64, z: f64| Aabb { min: Point3::new(-x, -y, -z), max: Point3::new(x, y, z) };
    let standing = |x: f64, y: f64, height: f64| Aabb {
        min: Point3::new(-x, -y, 0.0),
        max: Point3::new(x, y, height),
    };
    match solid {
        Solid::Sphere(s) => centred(s.radius_mm, s.radius_mm, s.radius_mm),
        Solid::Ellipsoid(s) => centred(s.semi_axes_mm[0], s.semi_axes_mm[1], s.semi_axes_mm[2]),
        Solid::Cylinder(s) => standing(s.radius_mm, s.radius_mm, s.height_mm),
        Solid::Cone(s) => {
            let wide = s.bottom_radius_mm.max(s.top_radius_mm);
            standing(wide, wide, s.height_mm)
        }
        Solid::Cuboid(s) => standing(s.size_mm[0] / 2.0, s.size_mm[1] / 2.0, s.size_mm[2]),
        Solid::Torus(s) => {
            let wide = s.ring_radius_mm + s.tube_radius_mm;
            centred(wide, wide, s.tube_radius_mm)
        }
        Solid::HalfSpace(_) => Aabb::everything(),
        Solid::Extrusion(s) => {
            let [min, max] = path_extent(&s.profile.outer);
            Aabb {
                min: Point3::new(min[0], min[1], 0.0),
                max: Point3::new(max[0], max[1], s.height_mm),
            }
        }
        Solid::Revolution(s) => {
            let [min, max] = path_extent(&s.profile.outer);
            let wide = max[0];
            Aabb { min: Point3::new(-wide, -wide, min[1]), max: Point3::new(wide, wide, max[1]) }
        }
        Solid::EllipsoidOffset(s) => {
            let wide = s.equatorial_mm + s.offset_mm;
            centred(wide, wide, s.polar_mm + s.offset_mm)
        }
        Solid::Union(of) => of.iter().map(extent).fold(Aabb::nothing(), |a, b| a.hull(&b)),
        Solid::Intersection(of) => {
            of.iter().map(extent).fold(Aabb::everything(), |a, b| a.common(&b))
        }
        Solid::Difference { of, .. } | Solid::Feature { of, .. } => extent(of),
        Solid::Placed { pose, of } => transform_box(&extent(of), pose),
    }
}

/// Returns an axis-aligned box around the moved box.
pub(crate) fn transform_box(bounds: &Aabb, pose: &Pose) -> Aabb {
    if bounds.is_empty() || !bounds.is_finite() {
        return *bounds;
    }
    let half = Vector3::from(bounds.size_mm()) / 2.0;
    let centre = pose.point(bounds.centre());
    // Half edges of the box around a rotated box.
    let reach = pose.rotation().abs() * half;
    Aabb { min: centre - reach, max: centre + reach }
}

/// Returns the smallest and largest coordinates of a path, with whole ellipses instead of their arcs.
fn path_extent(path: &Path) -> [[f64; 2]; 2] {
    let (mut min, mut max) = (path.start, path.start);
    let mut reach = |p: [f64; 2]| {
        for i in 0..2 {
            min[i] = min[i].min(p[i]);
            max[i] = max[i].max(p[i]);
        }
    };
    for segment in &path.segments {
        let to = segment.to();
        reach(to);
        let (centre, half) = match segment {
            Segment::Line { .. } => continue,
            Segment::Arc { centre, .. } => {
                (centre, [(to[0] - centre[0]).hypot(to[1] - centre[1]); 2])
            }
            Segment::EllipticArc { centre, semi_axes_mm, .. } => (centre, *semi_axes_mm),
        };
        reach([centre[0] - half[0], centre[1] - half[1]]);
        reach([centre[0] + half[0], centre[1] + half[1]]);
    }
    [min, max]
}

/// Box in any orientation.
#[derive(Clone, Debug)]
pub(crate) struct OrientedBox {
    centre: Point3<f64>,
    half_axes: [Vector3<f64>; 3],
    around: Aabb,
}

/// Distance up to which boxes count as touching, mm.
const GAP_MM: f64 = 1e-6;

impl OrientedBox {
    /// Creates the box `bounds` of a frame whose pose is `pose`.
    pub fn new(bounds: &Aabb, pose: &Pose) -> Self {
        let half = bounds.size_mm().map(|s| s / 2.0);
        let half_axes = std::array::from_fn(|i| pose.rotation().column(i).into_owned() * half[i]);
        Self {
            centre: pose.point(bounds.centre()),
            half_axes,
            around: transform_box(bounds, pose).grown(GAP_MM),
        }
    }

    /// Returns whether a plane parallel to a face of either box separates them. Boxes that can be separated only by
    /// planes along an edge of each count as touching.
    pub fn is_apart_from(&self, other: &Self) -> bool {
        // Cheap test first.
        if self.around.common(&other.around).is_empty() {
            return true;
        }
        let apart_along = |axis: &Vector3<f64>| {
            let reach = |b: &Self| b.half_axes.iter().map(|h| h.dot(axis).abs()).sum::<f64>();
            let distance = (other.centre - self.centre).dot(axis).abs();
            distance > reach(self) + reach(other) + GAP_MM * axis.norm()
        };
        self.half_axes.iter().chain(&other.half_axes).any(apart_along)
    }
}

/// Splits boxes into groups within which all are apart. Returns indices, first box first.
pub(crate) fn disjoint_groups(boxes: &[OrientedBox]) -> Vec<Vec<usize>> {
    let mut by_x: Vec<usize> = (0..boxes.len()).collect();
    let low = |i: usize| boxes[i].around.min.x;
    by_x.sort_by(|&i, &j| low(i).total_cmp(&low(j)).then(i.cmp(&j)));
    let mut touching = vec![Vec::new(); boxes.len()];
    for (k, &i) in by_x.iter().enumerate() {
        let reach = boxes[i].around.max.x;
        for &j in by_x[k + 1..].iter().take_while(|&&j| low(j) <= reach) {
            if !boxes[i].is_apart_from(&boxes[j]) {
                touching[i].push(j);
                touching[j].push(i);
            }
        }
    }
    // Greedy graph colouring: each box joins the first group that none of its neighbours is in.
    let mut group_of = vec![usize::MAX; boxes.len()];
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for i in 0..boxes.len() {
        let taken: std::collections::BTreeSet<usize> =
            touching[i].iter().map(|&j| group_of[j]).collect();
        let group = (0..).find(|g| !taken.contains(g)).unwrap_or(groups.len());
        if group == groups.len() {
            groups.push(Vec::new());
        }
        groups[group].push(i);
        group_of[i] = group;
    }
    groups
}
