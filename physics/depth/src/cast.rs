//! Intersections of rays with a scene of placed bodies.

use std::ops::Range;

use fabkit_geometry::{Aabb, CompiledSolid, Crossing, Point3, Pose, Ray, Vector3};

/// Growth of bounding boxes, so that a surface in the face of its own box is not lost to rounding, mm.
pub(crate) const BOX_SLACK_MM: f64 = 1e-6;

/// Placed bodies with a bounding-volume hierarchy over their boxes.
///
/// ```
/// use fabkit_depth::Scene;
/// use fabkit_geometry::{CompiledSolid, Point3, Pose, Ray, Solid, Vector3};
///
/// // Two balls of radius 2 mm around x = 5 mm and x = 15 mm, seen from the origin.
/// let ball = CompiledSolid::new(&Solid::sphere(2.0))?;
/// let scene = Scene::new([15.0, 5.0].map(|x_mm| (&ball, Pose::translation(x_mm, 0.0, 0.0))));
/// let ray = Ray { origin: Point3::origin(), direction: Vector3::x() };
/// let hit = |range| scene.first_hit(&ray, range, &mut Default::default()).map(|hit| (hit.body, hit.crossing.t));
/// // The nearer ball is the second of the list. From its middle on, the other one comes first.
/// assert_eq!((hit(0.0..f64::INFINITY), hit(5.0..f64::INFINITY)), (Some((1, 3.0)), Some((0, 13.0))));
/// assert_eq!(hit(0.0..2.0), None);
/// # Ok::<(), fabkit_geometry::InvalidSolid>(())
/// ```
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    bodies: Vec<PlacedBody<'a>>,
    nodes: Vec<Node>,
}

#[derive(Clone, Debug)]
struct PlacedBody<'a> {
    body: &'a CompiledSolid,
    scene_from_body: Pose,
    body_from_scene: Pose,
    bounds: Aabb,
}

/// Node of the flattened hierarchy. The left child of an inner node follows it directly.
#[derive(Clone, Debug)]
struct Node {
    bounds: Aabb,
    kind: NodeKind,
}

#[derive(Clone, Debug)]
enum NodeKind {
    Leaf { body: u32 },
    Inner { right: u32 },
}

/// Point where a ray enters a body of a [`Scene`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index of the body in the list given to [`Scene::new`].
    pub body: u32,
    /// Crossing of the surface; its normal is in the scene frame.
    pub crossing: Crossing,
}

/// Buffers that queries reuse; one per thread.
#[derive(Debug, Default)]
pub struct SceneScratch {
    /// Entry into the box, and index, of the bodies that a ray may meet, nearest first.
    candidates: Vec<(f64, u32)>,
    crossings: Vec<Crossing>,
    in_body: fabkit_geometry::Scratch,
    stack: Vec<u32>,
}

impl<'a> Scene<'a> {
    /// Builds the hierarchy over bodies, each with its `scene_from_body`.
    pub fn new(bodies: impl IntoIterator<Item = (&'a CompiledSolid, Pose)>) -> Self {
        let bodies: Vec<_> = bodies
            .into_iter()
            .map(|(body, scene_from_body)| PlacedBody {
                body,
                scene_from_body,
                body_from_scene: scene_from_body.inverse(),
                bounds: moved_bounds(&body.bounds(), &scene_from_body),
            })
            .collect();
        // Bodies without volume stay in the list, so that indices match, but not in the hierarchy.
        let mut order: Vec<u32> = (0..bodies.len() as u32)
            .filter(|&index| !bodies[index as usize].bounds.is_empty())
            .collect();
        let mut scene = Self { bodies, nodes: Vec::new() };
        if !order.is_empty() {
            scene.build(&mut order);
        }
        scene
    }

    /// Returns the bounding box of a body, scene frame; empty for a body without volume.
    pub fn bounds(&self, body: usize) -> Aabb {
        self.bodies[body].bounds
    }

    /// Number of bodies.
    pub fn len(&self) -> usize {
        self.bodies.len()
    }

    /// Returns whether the scene has no bodies.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Visits all crossings of the whole line, body by body, nearest box first.
    ///
    /// `visit` receives the body's index and its crossings (in order along the ray, normals in the scene frame). It
    /// returns the `t` beyond which no further bodies are needed: infinity to visit all.
    ///
    /// ```
    /// use fabkit_depth::Scene;
    /// use fabkit_geometry::{CompiledSolid, Point3, Pose, Ray, Solid, Vector3};
    ///
    /// // A line through a ball of radius 2 mm in 5 mm distance: it enters, and leaves.
    /// let ball = CompiledSolid::new(&Solid::sphere(2.0))?;
    /// let scene = Scene::new([(&ball, Pose::translation(5.0, 0.0, 0.0))]);
    /// let (ray, mut found) = (Ray { origin: Point3::origin(), direction: Vector3::x() }, Vec::new());
    /// scene.visit_crossings(&ray, &mut Default::default(), |_, crossings| {
    ///     found.extend(crossings.iter().map(|crossing| (crossing.t, crossing.entering)));
    ///     f64::INFINITY
    /// });
    /// assert_eq!(found, [(3.0, true), (7.0, false)]);
    /// # Ok::<(), fabkit_geometry::InvalidSolid>(())
    /// ```
    pub fn visit_crossings(
        &self,
        ray: &Ray,
        scratch: &mut SceneScratch,
        visit: impl FnMut(u32, &[Crossing]) -> f64,
    ) {
        self.visit_within(f64::NEG_INFINITY..f64::INFINITY, ray, scratch, visit);
    }

    /// Finds the first surface that the ray enters with `t` in a range.
    pub fn first_hit(
        &self,
        ray: &Ray,
        range: Range<f64>,
        scratch: &mut SceneScratch,
    ) -> Option<Hit> {
        let mut first: Option<Hit> = None;
        self.visit_within(range.clone(), ray, scratch, |body, crossings| {
            // Crossings are sorted, so the first entry within the range is the nearest of this body.
            let entered = crossings.iter().find(|c| c.entering && range.contains(&c.t));
            if let Some(&crossing) = entered
                && first.is_none_or(|hit| crossing.t < hit.crossing.t)
            {
                first = Some(Hit { body, crossing });
            }
            first.map_or(f64::INFINITY, |hit| hit.crossing.t)
        });
        first
    }

    /// Visits crossings like [`Scene::visit_crossings`], but only of bodies whose boxes the ray meets within a range.
    fn visit_within(
        &self,
        range: Range<f64>,
        ray: &Ray,
        scratch: &mut SceneScratch,
        mut visit: impl FnMut(u32, &[Crossing]) -> f64,
    ) {
        self.find_candidates(&range, ray, scratch);
        let mut enough = f64::INFINITY;
        for candidate in 0..scratch.candidates.len() {
            let (entry, index) = scratch.candidates[candidate];
            // Boxes are sorted by entry: no later body can be nearer.
            if entry > enough {
                break;
            }
            let placed = &self.bodies[index as usize];
            let ray_in_body = Ray {
                origin: placed.body_from_scene.point(ray.origin),
                direction: placed.body_from_scene.vector(ray.direction),
            };
            let SceneScratch { crossings, in_body, .. } = scratch;
            placed.body.crossings_into(&ray_in_body, in_body, crossings);
            if scratch.crossings.is_empty() {
                continue;
            }
            // Rotations preserve length, so normals stay unit vectors.
            for crossing in &mut scratch.crossings {
                crossing.normal = placed.scene_from_body.vector(crossing.normal);
            }
            enough = enough.min(visit(index, &scratch.crossings));
        }
    }

    /// Collects the bodies whose boxes the ray meets within a range, nearest first.
    fn find_candidates(&self, range: &Range<f64>, ray: &Ray, scratch: &mut SceneScratch) {
        scratch.candidates.clear();
        scratch.stack.clear();
        if !self.nodes.is_empty() {
            scratch.stack.push(0);
        }
        while let Some(at) = scratch.stack.pop() {
            let node = &self.nodes[at as usize];
            let Some(entry) = box_entry(&node.bounds, ray, range) else { continue };
            match node.kind {
                NodeKind::Leaf { body } => scratch.candidates.push((entry, body)),
                NodeKind::Inner { right } => scratch.stack.extend([right, at + 1]),
            }
        }
        // The index settles ties, so that the order does not depend on the hierarchy.
        scratch.candidates.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }

    /// Adds a subtree over `order` and returns its root. The split is at the median along the longest side of the
    /// centres' box.
    fn build(&mut self, order: &mut [u32]) -> u32 {
        let at = self.nodes.len();
        let bounds = order
            .iter()
            .fold(Aabb::nothing(), |hull, &i| hull.hull(&self.bodies[i as usize].bounds));
        if let [body] = *order {
            self.nodes.push(Node { bounds, kind: NodeKind::Leaf { body } });
            return at as u32;
        }
        let centre = |i: u32| self.bodies[i as usize].bounds.centre();
        let centres = order.iter().fold(Aabb::nothing(), |hull, &i| {
            let point = centre(i);
            hull.hull(&Aabb { min: point, max: point })
        });
        let axis = Vector3::from(centres.size_mm()).imax();
        order.sort_by(|&a, &b| centre(a)[axis].total_cmp(&centre(b)[axis]).then(a.cmp(&b)));
        let (left, right) = order.split_at_mut(order.len() / 2);
        // The right child's index is known only after the left subtree has been built.
        self.nodes.push(Node { bounds, kind: NodeKind::Inner { right: 0 } });
        self.build(left);
        let right = self.build(right);
        self.nodes[at].kind = NodeKind::Inner { right };
        at as u32
    }
}

/// Returns the eight corners of a box.
pub(crate) fn corners(bounds: &Aabb) -> [Point3<f64>; 8] {
    std::array::from_fn(|i| {
        let pick = |axis: usize| {
            if i >> axis & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] }
        };
        Point3::new(pick(0), pick(1), pick(2))
    })
}

/// Bounds a transformed box, slightly enlarged. Infinite boxes stay infinite.
pub(crate) fn moved_bounds(bounds: &Aabb, scene_from_body: &Pose) -> Aabb {
    if bounds.is_empty() {
        return Aabb::nothing();
    }
    if !bounds.is_finite() {
        return Aabb::everything();
    }
    corners(bounds)
        .map(|corner| scene_from_body.point(corner))
        .iter()
        .fold(Aabb::nothing(), |hull, corner| hull.hull(&Aabb { min: *corner, max: *corner }))
        .grown(BOX_SLACK_MM)
}

/// Returns the `t` at which a ray enters a box within a range, or `None` if it misses.
#[inline]
pub(crate) fn box_entry(bounds: &Aabb, ray: &Ray, range: &Range<f64>) -> Option<f64> {
    let [entry, exit] = ray.range_in(bounds)?;
    let entry = entry.max(range.start);
    (entry <= exit.min(range.end)).then_some(entry)
}
