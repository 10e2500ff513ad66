//! Conversion of solids to triangle meshes.
//!
//! [`mesh`] returns a [`TriMesh`] whose vertices lie on the exact surface, except for a few made by booleans, and whose
//! triangles deviate from it by at most the chord tolerance. [`PrintMesh`] is the form that files are written from:
//! rounded to `f32`, welded, and proven closed and oriented *after* that.
//!
//! Only this crate depends on the boolean kernel.
//!
//! ```
//! use fabkit_geometry::Solid;
//! use fabkit_mesh::{DEFAULT_TOLERANCE_MM, mesh};
//!
//! let washer = Solid::cylinder(5.0, 1.0).minus(Solid::cylinder(2.0, 3.0).at(0.0, 0.0, -1.0));
//! let triangles = mesh(&washer, DEFAULT_TOLERANCE_MM)?;
//! assert_eq!(triangles.genus(), 1);
//! let file = triangles.to_print()?;
//! let exact_mm3 = 21.0 * std::f64::consts::PI;
//! assert!((file.volume_mm3() - exact_mm3).abs() < triangles.area_mm2() * DEFAULT_TOLERANCE_MM);
//! # Ok::<(), fabkit_mesh::MeshError>(())
//! ```

mod conform;
mod error;
mod evaluate;
mod extent;
mod facets;
mod fuse;
mod halfedges;
mod hull;
mod kernel;
mod measure;
#[cfg(test)]
#[path = "../tests/mesh/oracle/mod.rs"]
mod oracle;
mod print;
mod seams;
mod shading;
mod shape_key;
mod snapshot;
mod surface;
mod tessellate;
mod tri_mesh;

use fabkit_geometry::Solid;

pub use error::{MeshError, TOLERANCE_RANGE_MM};
pub use hull::{Hull, convex_hull};
pub use measure::Shell;
pub use print::{PrintDefect, PrintMesh};
pub use shading::ShadedMesh;
pub use snapshot::snapshot;
pub use tri_mesh::{FaceId, TriMesh};

/// Default chord tolerance, mm.
pub const DEFAULT_TOLERANCE_MM: f64 = 0.01;

/// Converts a solid to a triangle mesh.
///
/// The same solid and tolerance give the same mesh, bit for bit.
///
/// # Errors
/// See [`MeshError`].
///
/// ```
/// use fabkit_geometry::Solid;
/// use fabkit_mesh::{TOLERANCE_RANGE_MM, mesh};
/// let ball = Solid::sphere(10.0);
/// let [coarse, fine] = [mesh(&ball, 0.1)?, mesh(&ball, 0.01)?];
/// // Chords deviate with the square of their length: a tenth of the tolerance takes about ten times as many triangles.
/// let ratio = fine.triangles.len() as f64 / coarse.triangles.len() as f64;
/// assert!((5.0..20.0).contains(&ratio));
/// assert!(mesh(&ball, TOLERANCE_RANGE_MM.start() / 2.0).is_err());
/// # Ok::<(), fabkit_mesh::MeshError>(())
/// ```
pub fn mesh(solid: &Solid, tolerance_mm: f64) -> Result<TriMesh, MeshError> {
    Ok(seams::correct_face_edges(
        mesh_without_refinement(solid, tolerance_mm)?,
        solid,
        tolerance_mm,
    ))
}

/// Converts a solid like [`mesh`], but without refining edges where faces meet, which may deviate by more than the
/// tolerance. Intended for integrals, whose errors scale with the tolerance only if no single edge is refined.
///
/// # Errors
/// Same as for [`mesh`].
///
/// ```
/// use fabkit_geometry::{Angle, Solid};
/// use fabkit_mesh::mesh_without_refinement;
/// let rod = Solid::rod(3.0, [-10.0, 10.0]);
/// let common = rod.clone().and(rod.turned_x(Angle::from_deg(90.0).unwrap()));
/// let exact_mm3 = 16.0 / 3.0 * 3f64.powi(3); // two cylinders that cross, by Archimedes
/// let missing_mm3 =
///     |mm| mesh_without_refinement(&common, mm).map(|mesh| exact_mm3 - mesh.volume_mm3());
/// // A quarter of the tolerance, about a quarter of the error.
/// assert!((3.0..5.0).contains(&(missing_mm3(0.4)? / missing_mm3(0.1)?)));
/// assert!(missing_mm3(9.0).is_err()); // too coarse for a part
/// # Ok::<(), fabkit_mesh::MeshError>(())
/// ```
pub fn mesh_without_refinement(solid: &Solid, tolerance_mm: f64) -> Result<TriMesh, MeshError> {
    validate_and_mesh(solid, tolerance_mm, |solid, mm| evaluate::evaluate(solid, mm, true))
}

/// Converts a solid like [`mesh`], but cuts small features by the boolean kernel instead of fitting them into the mesh:
/// slower, for benchmarks and as an independent check.
///
/// # Errors
/// Same as for [`mesh`].
///
/// ```
/// use fabkit_geometry::Solid;
/// use fabkit_mesh::{mesh, mesh_by_booleans};
/// let drilled = Solid::sphere(5.0).minus(Solid::rod(1.0, [-6.0, 6.0]));
/// let [fitted, cut] = [mesh(&drilled, 0.05)?, mesh_by_booleans(&drilled, 0.05)?];
/// assert_eq!((fitted.genus(), cut.genus()), (1, 1));
/// assert!((fitted.volume_mm3() - cut.volume_mm3()).abs() < 0.05 * fitted.area_mm2());
/// # Ok::<(), fabkit_mesh::MeshError>(())
/// ```
pub fn mesh_by_booleans(solid: &Solid, tolerance_mm: f64) -> Result<TriMesh, MeshError> {
    let cut =
        validate_and_mesh(solid, tolerance_mm, |solid, mm| evaluate::evaluate(solid, mm, false))?;
    Ok(seams::correct_face_edges(cut, solid, tolerance_mm))
}

fn validate_and_mesh(
    solid: &Solid,
    tolerance_mm: f64,
    evaluate: impl FnOnce(&Solid, f64) -> Result<facets::Facets, MeshError>,
) -> Result<TriMesh, MeshError> {
    if !TOLERANCE_RANGE_MM.contains(&tolerance_mm) {
        return Err(MeshError::Tolerance { tolerance_mm });
    }
    solid.validate()?;
    Ok(to_mesh(solid, evaluate(solid, tolerance_mm)?))
}

/// Converts face numbers to face identifiers by leaf.
fn to_mesh(solid: &Solid, facets: facets::Facets) -> TriMesh {
    let ids: Vec<FaceId> = (0..)
        .zip(solid.leaves())
        .flat_map(|(leaf, l)| {
            (0..tessellate::face_count(l.primitive)).map(move |face| FaceId { leaf, face })
        })
        .collect();
    let faces = facets.faces.iter().map(|&f| ids[f as usize]).collect();
    TriMesh { vertices: facets.vertices, triangles: facets.triangles, faces }
}

/// Computes the common volume of two solids at a chord tolerance, mm^3; 0 if they are apart.
///
/// # Errors
/// Same as for [`mesh`], except that an empty intersection is not an error.
///
/// ```
/// use fabkit_geometry::Solid;
/// use fabkit_mesh::{DEFAULT_TOLERANCE_MM, intersection_volume_mm3};
/// let block = Solid::cuboid(4.0, 4.0, 2.0);
/// let common_mm3 =
///     |z_mm| intersection_volume_mm3(&block, &block.clone().at_z(z_mm), DEFAULT_TOLERANCE_MM);
/// assert!((common_mm3(1.5)? - 4.0 * 4.0 * 0.5).abs() < 1e-9);
/// assert_eq!(common_mm3(3.0)?, 0.0); // 1 mm apart
/// # Ok::<(), fabkit_mesh::MeshError>(())
/// ```
pub fn intersection_volume_mm3(a: &Solid, b: &Solid, tolerance_mm: f64) -> Result<f64, MeshError> {
    IntersectionCache::new(tolerance_mm).volume_mm3(a, b)
}

/// Computes intersections of pairs of solids, and caches each solid's mesh for reuse in other pairs and placements.
///
/// ```
/// use fabkit_geometry::Solid;
/// use fabkit_mesh::IntersectionCache;
/// let mut cache = IntersectionCache::new(0.01);
/// let (block, peg) = (Solid::cuboid(8.0, 8.0, 4.0), Solid::cuboid(1.0, 1.0, 10.0));
/// // How deep a peg is pushed in from above, once for each depth.
/// for depth_mm in [1.0, 2.0, 3.0] {
///     let common_mm3 = cache.volume_mm3(&block, &peg.clone().at_z(4.0 - depth_mm))?;
///     assert!((common_mm3 - depth_mm).abs() < 1e-9);
/// }
/// # Ok::<(), fabkit_mesh::MeshError>(())
/// ```
pub struct IntersectionCache {
    evaluator: evaluate::Evaluator,
    tolerance_mm: f64,
}

impl IntersectionCache {
    /// Creates an empty cache for a chord tolerance, mm.
    pub fn new(tolerance_mm: f64) -> Self {
        Self { evaluator: evaluate::Evaluator::new(tolerance_mm, true), tolerance_mm }
    }

    /// Computes the same as [`intersection_volume_mm3`], whatever was computed before.
    ///
    /// # Errors
    /// Same as for [`intersection_volume_mm3`].
    pub fn volume_mm3(&mut self, a: &Solid, b: &Solid) -> Result<f64, MeshError> {
        // Without fusion: faces that both solids share keep equal triangles, and shapes are cached by subtree.
        let unfused = |solid: &Solid, _| self.evaluator.evaluate_unfused(solid);
        match validate_and_mesh(&a.clone().and(b.clone()), self.tolerance_mm, unfused) {
            // The remainder of two surfaces that touch may have a tiny negative volume.
            Ok(common) => Ok(common.volume_mm3().max(0.0)),
            Err(MeshError::Empty) => Ok(0.0),
            Err(other) => Err(other),
        }
    }
}

impl TriMesh {
    /// Rounds to `f32`, welds, removes triangles that became degenerate, and proves the result closed, oriented and
    /// free of degenerate triangles.
    ///
    /// # Errors
    /// Defects that could not be repaired.
    pub fn to_print(&self) -> Result<PrintMesh, MeshError> {
        Ok(print::to_print(self)?)
    }
}
