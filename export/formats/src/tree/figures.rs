//! Volume, area, centroid and inertia of the exact solid.
//!
//! Closed forms exist for few trees. For all others the mesh's integrals are corrected by the volume between the mesh
//! and the exact faces. Along each triangle's normal a ray measures the distance to the face. Along each edge the gap
//! between neighbouring corrections is a small quadrilateral whose fourth corner is the intersection of the two faces.
//! The remaining error decreases at least as fast as the chord tolerance. Two tolerances are compared, and twice their
//! difference is stated as the error; once would suffice if every number of segments could follow the tolerance
//! exactly.

use std::collections::BTreeMap;

use fabkit_geometry::{CompiledSolid, Matrix3, Point3, Pose, Ray, Scratch, Solid, Vector3};
use fabkit_mesh::{FaceId, MeshError, TriMesh, mesh_without_refinement};
use serde::Serialize;

/// Chord tolerance of the finer of the two meshes, mm; the other is twice as coarse.
const CHORD_MM: f64 = 0.004;

/// Chord tolerance of the mesh for [`moments`], mm.
const MOMENTS_MM: f64 = 0.02;

/// Height below which a triangle's normal is meaningless, mm.
const SLIVER_MM: f64 = 1e-7;

/// Nodes and weights of the Gauss-Legendre rule on (0, 1), exact to fifth order.
const NODES: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 5.0 / 18.0),
    (0.5, 4.0 / 9.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

/// Nodes and weights of the conical product rule on a triangle, exact to fifth order (Stroud, "Approximate Calculation
/// of Multiple Integrals", 1971). From a corner towards the opposite edge these apply, along that edge `NODES`. Where
/// the corner is a cone's apex, heights are not polynomial over the triangle, but they are along each line through the
/// apex.
const FROM_CORNER: [(f64, f64); 3] = [
    (0.212_340_538_239_153, 0.139_653_959_802_908_3),
    (0.590_533_135_559_265_3, 0.458_482_212_719_172_6),
    (0.911_412_040_487_296_1, 0.401_863_827_477_919_1),
];

/// Integrals over the exact solid, for density 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ExactFigures {
    /// Volume, mm^3.
    pub volume_mm3: f64,
    /// Error bound of the volume, mm^3.
    pub volume_error_mm3: f64,
    /// Surface area, mm^2.
    pub area_mm2: f64,
    /// Error bound of the area, mm^2.
    pub area_error_mm2: f64,
    /// Centre of mass, mm.
    pub centroid_mm: [f64; 3],
    /// Error bound of the centroid, mm.
    pub centroid_error_mm: f64,
    /// Inertia about the centroid, by rows, mm^5.
    pub inertia_mm5: [[f64; 3]; 3],
    /// Error bound of each entry of the inertia, mm^5.
    pub inertia_error_mm5: f64,
    /// Lower and upper corner of the bounding box, mm.
    pub bounds_mm: [[f64; 3]; 2],
    /// Error bound of the bounding box, mm.
    pub bounds_error_mm: f64,
    /// Genus: number of through holes and handles, summed over shells.
    pub genus: i32,
    /// Number of connected boundaries; a closed cavity counts as one.
    pub shells: usize,
}

/// Computes volume, mm3, centroid, mm, and inertia about it, mm5, of the exact solid for density 1, from a single mesh.
/// Accurate to a hundredth of a percent; [`ExactFigures`] state their errors.
///
/// # Errors
/// Solids that cannot be meshed.
///
/// ```
/// use fabkit_export::moments;
/// use fabkit_geometry::Solid;
///
/// let (volume_mm3, centroid_mm, inertia_mm5) = moments(&Solid::cuboid(6.0, 4.0, 2.0))?;
/// assert!((volume_mm3 - 48.0).abs() < 1e-9);
/// // A box stands on z = 0.
/// assert!((centroid_mm.z - 1.0).abs() < 1e-9);
/// // Volume (b^2 + c^2) / 12 about x.
/// assert!((inertia_mm5[(0, 0)] - 48.0 * (16.0 + 4.0) / 12.0).abs() < 1e-6);
/// # Ok::<(), fabkit_mesh::MeshError>(())
/// ```
pub fn moments(solid: &Solid) -> Result<(f64, Vector3<f64>, Matrix3<f64>), MeshError> {
    let sums = integrate(solid, &mesh_without_refinement(solid, MOMENTS_MM)?);
    Ok((sums.volume, sums.centroid(), sums.inertia()))
}

/// Computes the figures of a solid, and returns the finer of the two meshes too.
pub(super) fn figures(solid: &Solid) -> Result<(ExactFigures, TriMesh), MeshError> {
    let coarse = integrate(solid, &mesh_without_refinement(solid, 2.0 * CHORD_MM)?);
    let finer_mesh = mesh_without_refinement(solid, CHORD_MM)?;
    let fine = integrate(solid, &finer_mesh);
    let bounds = finer_mesh.bounds();
    let (centroid, inertia) = (fine.centroid(), fine.inertia());
    let figures = ExactFigures {
        volume_mm3: fine.volume,
        // Twice the difference of the tolerances; see the module's description.
        volume_error_mm3: rounding(fine.volume) + 2.0 * (fine.volume - coarse.volume).abs(),
        area_mm2: fine.area,
        area_error_mm2: rounding(fine.area) + 2.0 * (fine.area - coarse.area).abs(),
        centroid_mm: centroid.into(),
        centroid_error_mm: 1e-9 + 2.0 * (centroid - coarse.centroid()).norm(),
        inertia_mm5: std::array::from_fn(|row| inertia.row(row).transpose().into()),
        inertia_error_mm5: rounding(inertia.amax()) + 2.0 * (inertia - coarse.inertia()).amax(),
        bounds_mm: [bounds.min.coords.into(), bounds.max.coords.into()],
        bounds_error_mm: CHORD_MM,
        genus: finer_mesh.genus(),
        shells: finer_mesh.shells(),
    };
    Ok((figures, finer_mesh))
}

/// Error bound of summing a million numbers.
fn rounding(value: f64) -> f64 {
    1e-10 * value.abs()
}

/// Moments about the origin, and the area.
#[derive(Clone, Copy, Debug)]
struct Integrals {
    volume: f64,
    area: f64,
    first: Vector3<f64>,
    second: Matrix3<f64>,
}

impl Integrals {
    fn add(&mut self, volume: f64, at: Vector3<f64>) {
        self.volume += volume;
        self.first += volume * at;
        self.second += volume * at * at.transpose();
    }

    fn centroid(&self) -> Vector3<f64> {
        self.first / self.volume
    }

    /// Inertia about the centroid.
    fn inertia(&self) -> Matrix3<f64> {
        let c = self.centroid();
        // Parallel axis theorem.
        let spread = self.second - self.volume * c * c.transpose();
        Matrix3::identity() * spread.trace() - spread
    }
}

/// Exact face as seen from a point of a nearby triangle.
#[derive(Clone, Copy, Debug)]
struct FaceHit {
    /// Distance of the face from the point along the triangle's normal, mm.
    height_mm: f64,
    /// Outward normal of the face.
    normal: Vector3<f64>,
}

/// A triangle of the mesh with its derived data.
struct Facet {
    corners: [Vector3<f64>; 3],
    normal: Vector3<f64>,
    area: f64,
    /// True if the triangle lies in its face, which is plane.
    is_flat: bool,
    /// True if the triangle is too thin to define a plane.
    is_sliver: bool,
}

impl Facet {
    fn new(mesh: &TriMesh, index: usize, leaves: &Leaves) -> Self {
        let corners = mesh.triangles[index].map(|v| Vector3::from(mesh.vertices[v as usize]));
        let [a, b, c] = corners;
        let double = (b - a).cross(&(c - a));
        let longest = [b - a, c - b, a - c].map(|edge| edge.norm()).into_iter().fold(0.0, f64::max);
        Self {
            corners,
            normal: double.try_normalize(0.0).unwrap_or_else(Vector3::z),
            area: 0.5 * double.norm(),
            is_flat: !leaves.is_curved(mesh.faces[index]),
            is_sliver: double.norm() <= SLIVER_MM * longest,
        }
    }

    fn centre(&self) -> Vector3<f64> {
        self.corners.iter().sum::<Vector3<f64>>() / 3.0
    }

    /// Returns quadrature points with the area that each stands for. They radiate from the corner opposite the shortest
    /// edge: an apex is such a corner.
    fn nodes(&self) -> impl Iterator<Item = (Vector3<f64>, f64)> + use<> {
        let length = |i: usize| (self.corners[(i + 2) % 3] - self.corners[(i + 1) % 3]).norm();
        let corner = (0..3).min_by(|a, b| length(*a).total_cmp(&length(*b))).unwrap_or(0);
        let [tip, from, to] = [0, 1, 2].map(|i| self.corners[(corner + i) % 3]);
        let area = self.area;
        FROM_CORNER.into_iter().flat_map(move |(r, weight)| {
            NODES.into_iter().map(move |(t, share)| {
                (tip + r * (from + t * (to - from) - tip), weight * share * area)
            })
        })
    }
}

/// State of the integration.
struct Integrator<'a> {
    mesh: &'a TriMesh,
    facets: Vec<Facet>,
    leaves: Leaves,
    scratch: Scratch,
    sum: Integrals,
}

/// Integrates over the exact solid, based on a mesh of it.
fn integrate(solid: &Solid, mesh: &TriMesh) -> Integrals {
    let leaves = Leaves::new(solid);
    let facets = (0..mesh.triangles.len()).map(|i| Facet::new(mesh, i, &leaves)).collect();
    let (zero, none) = (Vector3::zeros(), Matrix3::zeros());
    let sum = Integrals { volume: 0.0, area: 0.0, first: zero, second: none };
    let mut summing = Integrator { mesh, facets, leaves, scratch: Scratch::default(), sum };
    for index in 0..mesh.triangles.len() {
        summing.add_facet(index);
    }
    for pair in edges(mesh) {
        summing.add_edge(pair);
    }
    summing.sum
}

impl Integrator<'_> {
    /// Returns the face as seen from a point of a triangle, or the triangle's own plane where that is exact or no ray
    /// hits.
    fn sight(&mut self, index: usize, at: Vector3<f64>) -> FaceHit {
        let facet = &self.facets[index];
        let flat = FaceHit { height_mm: 0.0, normal: facet.normal };
        if facet.is_flat || facet.is_sliver {
            return flat;
        }
        let (id, centre) = (self.mesh.faces[index], facet.centre());
        let seen = self.leaves.hit_leaf_face(id, at, centre, facet.normal, &mut self.scratch);
        seen.unwrap_or(flat)
    }

    /// Adds a triangle, and the volume between it and its face.
    fn add_facet(&mut self, index: usize) {
        add_tetrahedron(&mut self.sum, self.facets[index].corners);
        if self.facets[index].is_flat || self.facets[index].is_sliver {
            self.sum.area += self.facets[index].area;
            return;
        }
        for (at, share) in self.facets[index].nodes() {
            let up = self.facets[index].normal;
            let FaceHit { height_mm, normal } = self.sight(index, at);
            self.sum.add(share * height_mm, at + 0.5 * height_mm * up);
            // A limit on the slope, against outliers near rims.
            self.sum.area += share / normal.dot(&up).max(0.1);
        }
    }

    /// Adds the volume between the prisms of two neighbouring triangles, in the planes across their edge: the
    /// quadrilateral from the edge over both foot points to the intersection of the faces.
    fn add_edge(&mut self, [one, two]: Pair) {
        let (first, second) = (&self.facets[one.0], &self.facets[two.0]);
        if first.is_sliver || second.is_sliver || (first.is_flat && second.is_flat) {
            return;
        }
        let (from, to) = (first.corners[one.1], first.corners[(one.1 + 1) % 3]);
        let (normal, other_normal) = (first.normal, second.normal);
        let length = (to - from).norm();
        let along = (to - from) / length;
        // In the plane across the edge: x points out of the first triangle, y along its normal.
        let (x, y) = (along.cross(&normal), normal);
        let flat = |v: Vector3<f64>| [v.dot(&x), v.dot(&y)];
        // Both triangles approximate one curved face, which is smooth across the edge.
        if self.mesh.faces[one.0] == self.mesh.faces[two.0] {
            for (t, weight) in NODES {
                let at = from + t * (to - from);
                let (a, b) = (self.sight(one.0, at), self.sight(two.0, at));
                let (p, q) = (flat(a.height_mm * normal), flat(b.height_mm * other_normal));
                let share = weight * length;
                self.sum.add(share * 0.5 * cross(q, p), at);
                let (n, step) = (flat(a.normal + b.normal), [q[0] - p[0], q[1] - p[1]]);
                self.sum.area += share * cross(n, step) / -n[0].hypot(n[1]);
            }
            return;
        }
        for (t, weight) in NODES {
            let at = from + t * (to - from);
            let (a, b) = (self.sight(one.0, at), self.sight(two.0, at));
            let (p, q) = (flat(a.height_mm * normal), flat(b.height_mm * other_normal));
            let (n, m) = (flat(a.normal), flat(b.normal));
            let across = cross(n, m);
            let meet = if across.abs() < 1e-2 {
                // Faces that meet smoothly.
                [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])]
            } else {
                let (u, v) = (dot(n, p), dot(m, q));
                [(u * m[1] - v * n[1]) / across, (v * n[0] - u * m[0]) / across]
            };
            let gap = 0.5 * (cross(q, meet) + cross(meet, p));
            let share = weight * length;
            self.sum.add(share * gap, at + 0.5 * (meet[0] * x + meet[1] * y));
            // Along the faces from their foot points to the intersection.
            let strips = dot([meet[0] - p[0], meet[1] - p[1]], [n[1], -n[0]])
                + dot([meet[0] - q[0], meet[1] - q[1]], [-m[1], m[0]]);
            self.sum.area += share * strips;
        }
    }
}

/// Adds the tetrahedron between a triangle and the origin.
fn add_tetrahedron(sum: &mut Integrals, [a, b, c]: [Vector3<f64>; 3]) {
    let determinant = a.dot(&b.cross(&c));
    let total = a + b + c;
    sum.volume += determinant / 6.0;
    sum.first += determinant / 24.0 * total;
    let squares = a * a.transpose() + b * b.transpose() + c * c.transpose();
    sum.second += determinant / 120.0 * (squares + total * total.transpose());
}

/// Both sides of an edge: triangle and edge number, for either direction.
type Pair = [(usize, usize); 2];

/// Pairs the triangles on both sides of each edge; an edge may have more than two where shells touch.
fn edges(mesh: &TriMesh) -> Vec<Pair> {
    let mut open: BTreeMap<(u32, u32), Vec<(usize, usize)>> = BTreeMap::new();
    let mut pairs = Vec::with_capacity(mesh.triangles.len() * 3 / 2);
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        for edge in 0..3 {
            let (a, b) = (corners[edge], corners[(edge + 1) % 3]);
            match open.get_mut(&(b, a)).and_then(Vec::pop) {
                Some(other) => pairs.push([other, (triangle, edge)]),
                None => open.entry((a, b)).or_default().push((triangle, edge)),
            }
        }
    }
    pairs
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Primitives of a tree, compiled one by one.
struct Leaves {
    bodies: Vec<Option<(CompiledSolid, Pose, Pose)>>,
    curved: Vec<Vec<bool>>,
}

impl Leaves {
    fn new(solid: &Solid) -> Self {
        let leaves = solid.leaves();
        let body = |leaf: &fabkit_geometry::Leaf| {
            // The whole solid is valid, and so are its primitives.
            let body = CompiledSolid::new(leaf.primitive).ok()?;
            Some((body, leaf.root_from_leaf, leaf.root_from_leaf.inverse()))
        };
        Self {
            bodies: leaves.iter().map(body).collect(),
            curved: leaves.iter().map(|leaf| curved_faces(leaf.primitive)).collect(),
        }
    }

    fn is_curved(&self, id: FaceId) -> bool {
        self.curved[id.leaf as usize].get(id.face as usize).copied().unwrap_or(false)
    }

    /// Finds the face along a triangle's normal from a point of its edge.
    ///
    /// A ray from the edge itself may miss the face by rounding, or by curvature beside a rim. It therefore starts a
    /// little inside the triangle, at growing distances, and the tangent plane leads back.
    fn hit_leaf_face(
        &self,
        id: FaceId,
        at: Vector3<f64>,
        centre: Vector3<f64>,
        normal: Vector3<f64>,
        scratch: &mut Scratch,
    ) -> Option<FaceHit> {
        let (body, root_from_leaf, leaf_from_root) = self.bodies[id.leaf as usize].as_ref()?;
        let mut crossings = Vec::new();
        [1e-4, 0.02, 0.2].iter().find_map(|inwards| {
            let origin = at + *inwards * (centre - at);
            let ray = Ray {
                origin: leaf_from_root.point(Point3::from(origin)),
                direction: leaf_from_root.vector(normal),
            };
            body.crossings_into(&ray, scratch, &mut crossings);
            let near = crossings.iter().filter(|c| c.face == id.face && c.t.abs() < 5.0 * CHORD_MM);
            let hit = near.min_by(|a, b| a.t.abs().total_cmp(&b.t.abs()))?;
            let outward = root_from_leaf.vector(hit.normal);
            // Taken alone, a subtracted primitive's face points out of that primitive, into the solid.
            let outward = if outward.dot(&normal) < 0.0 { -outward } else { outward };
            let slope = outward.dot(&normal);
            let height_mm = outward.dot(&(origin + hit.t * normal - at)) / slope.max(0.1);
            Some(FaceHit { height_mm, normal: outward })
        })
    }
}

/// Returns for each face of a primitive whether it is curved.
fn curved_faces(primitive: &Solid) -> Vec<bool> {
    use fabkit_geometry::Segment::Line;
    let bends = |profile: &fabkit_geometry::Profile| -> Vec<bool> {
        let segments = profile.paths().flat_map(|path| &path.segments);
        segments.map(|segment| !matches!(segment, Line { .. })).collect()
    };
    match primitive {
        Solid::Cuboid(_) | Solid::HalfSpace(_) => vec![false; 6],
        Solid::Cylinder(_) | Solid::Cone(_) => vec![true, false, false],
        Solid::Extrusion(s) => [false, false].into_iter().chain(bends(&s.profile)).collect(),
        // A line across the axis sweeps a plane, but testing it with a ray is harmless.
        Solid::Revolution(s) => vec![true; bends(&s.profile).len()],
        _ => vec![true],
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// A pipe and a ball away from the origin, by hand.
    #[test]
    fn moments_are_those_of_closed_forms() {
        let pipe = Solid::cylinder(5.0, 8.0).minus(Solid::cylinder(4.0, 10.0).at_z(-1.0));
        let (volume, centre, inertia) = moments(&pipe.at(1.0, 2.0, 3.0)).unwrap();
        let exact = PI * (25.0 - 16.0) * 8.0;
        assert!((volume / exact - 1.0).abs() < 1e-4, "{volume} {exact}");
        assert!((centre - Vector3::new(1.0, 2.0, 7.0)).norm() < 1e-4, "{centre}");
        let (about_axis, across) = (exact * 41.0 / 2.0, exact * (3.0 * 41.0 + 64.0) / 12.0);
        for (found, exact) in inertia.diagonal().iter().zip([across, across, about_axis]) {
            assert!((found / exact - 1.0).abs() < 1e-4, "{found} {exact}");
        }
        let (volume, _, inertia) = moments(&Solid::sphere(3.0).at(0.0, 9.0, 0.0)).unwrap();
        let exact = 4.0 / 3.0 * PI * 27.0;
        assert!((volume / exact - 1.0).abs() < 1e-4);
        assert!((inertia - Matrix3::identity() * (0.4 * exact * 9.0)).amax() < 1e-3 * exact);
    }
}
