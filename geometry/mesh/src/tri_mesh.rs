//! Triangle meshes with the faces that the triangles belong to.

use fabkit_geometry::Pose;

use crate::facets;

/// Face of a primitive that a triangle belongs to.
///
/// ```
/// use fabkit_geometry::Solid;
/// use fabkit_mesh::{FaceId, mesh};
/// // Of a bore through a plate, only the side is left: face 0 of the second primitive.
/// let drilled = Solid::cuboid(10.0, 10.0, 2.0).minus(Solid::rod(2.0, [-0.1, 2.1]));
/// let triangles = mesh(&drilled, 0.1)?;
/// assert!(triangles.faces.contains(&FaceId { leaf: 1, face: 0 }));
/// assert!(triangles.faces.iter().all(|id| id.leaf == 0 || id.face == 0));
/// # Ok::<(), fabkit_mesh::MeshError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FaceId {
    /// Index into [`Solid::leaves`](fabkit_geometry::Solid::leaves).
    pub leaf: u32,
    /// Face number within the primitive, as the primitive documents.
    pub face: u32,
}

/// Closed, oriented triangle mesh, mm.
///
/// ```
/// use fabkit_geometry::Solid;
/// use fabkit_mesh::mesh;
/// let cube = mesh(&Solid::cuboid(2.0, 2.0, 2.0), 0.1)?;
/// assert_eq!((cube.vertices.len(), cube.triangles.len(), cube.faces.len()), (8, 12, 12));
/// assert!((cube.volume_mm3() - 8.0).abs() < 1e-12 && (cube.area_mm2() - 24.0).abs() < 1e-12);
/// # Ok::<(), fabkit_mesh::MeshError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TriMesh {
    /// Vertex positions, mm.
    pub vertices: Vec<[f64; 3]>,
    /// Triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Faces, one per triangle.
    pub faces: Vec<FaceId>,
}

impl TriMesh {
    /// Returns the mesh after a rigid motion.
    ///
    /// ```
    /// use fabkit_geometry::{Pose, Solid};
    /// let pin = fabkit_mesh::mesh(&Solid::cylinder(2.0, 6.0), 0.1)?;
    /// let lifted = pin.placed(&Pose::translation(0.0, 0.0, 10.0));
    /// assert_eq!((lifted.bounds().min.z, lifted.bounds().max.z), (10.0, 16.0));
    /// assert_eq!(lifted.triangles, pin.triangles);
    /// # Ok::<(), fabkit_mesh::MeshError>(())
    /// ```
    #[must_use]
    pub fn placed(&self, pose: &Pose) -> Self {
        let vertices = self.vertices.iter().map(|&v| facets::transform_point(pose, v)).collect();
        Self { vertices, triangles: self.triangles.clone(), faces: self.faces.clone() }
    }

    /// Returns the mesh scaled about the origin by a factor above 0; its deviation from the surface scales with it.
    ///
    /// ```
    /// use fabkit_geometry::Solid;
    /// let mold = fabkit_mesh::mesh(&Solid::cuboid(10.0, 10.0, 4.0), 0.1)?;
    /// let shrinkage = 0.2;
    /// let enlarged = mold.scaled(1.0 / (1.0 - shrinkage));
    /// assert!((enlarged.bounds().size_mm()[0] - 12.5).abs() < 1e-12);
    /// assert!((enlarged.volume_mm3() - 12.5 * 12.5 * 5.0).abs() < 1e-9);
    /// # Ok::<(), fabkit_mesh::MeshError>(())
    /// ```
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let vertices = self.vertices.iter().map(|v| v.map(|x| x * factor)).collect();
        Self { vertices, triangles: self.triangles.clone(), faces: self.faces.clone() }
    }

    /// Returns the mesh stretched along x, y and z about the origin by factors above 0; its deviation from the surface
    /// grows by at most the largest factor.
    ///
    /// ```
    /// use fabkit_geometry::Solid;
    /// let block = fabkit_mesh::mesh(&Solid::cuboid(10.0, 10.0, 4.0), 0.1)?;
    /// let taller = block.stretched([1.0, 1.0, 1.5]);
    /// assert_eq!(taller.bounds().size_mm(), [10.0, 10.0, 6.0]);
    /// # Ok::<(), fabkit_mesh::MeshError>(())
    /// ```
    #[must_use]
    pub fn stretched(&self, factors: [f64; 3]) -> Self {
        let stretch = |v: &[f64; 3]| std::array::from_fn(|i| v[i] * factors[i]);
        let vertices = self.vertices.iter().map(stretch).collect();
        Self { vertices, triangles: self.triangles.clone(), faces: self.faces.clone() }
    }
}
