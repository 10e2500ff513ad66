//! Convex hull of points.

use crate::MeshError;
use crate::facets::Facets;
use crate::kernel;

/// Convex polyhedron of triangles, counter-clockwise seen from outside.
///
/// ```
/// use fabkit_mesh::convex_hull;
/// let mut corners = vec![[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0]];
/// assert_eq!(convex_hull(&corners)?.volume_mm3(), 0.0); // a triangle is flat
/// corners.push([0.0, 0.0, 2.0]);
/// assert!((convex_hull(&corners)?.volume_mm3() - 3.0).abs() < 1e-12); // 4.5 mm2 times 2 mm / 3
/// # Ok::<(), fabkit_mesh::MeshError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hull {
    /// Corner points, mm.
    pub vertices: Vec<[f64; 3]>,
    /// Triangles as indices of corners.
    pub triangles: Vec<[u32; 3]>,
}

impl Hull {
    /// Computes the enclosed volume, mm3.
    pub fn volume_mm3(&self) -> f64 {
        let corner = |i: u32| fabkit_geometry::Vector3::from(self.vertices[i as usize]);
        let sixth = |t: &[u32; 3]| corner(t[0]).dot(&corner(t[1]).cross(&corner(t[2])));
        self.triangles.iter().map(sixth).sum::<f64>() / 6.0
    }
}

/// Computes the convex hull of points, mm.
///
/// ```
/// let corners = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect::<Vec<_>>();
/// let inside = [[0.5; 3], [0.2, 0.3, 0.4]];
/// let hull = fabkit_mesh::convex_hull(&[&corners[..], &inside].concat())?;
/// assert_eq!((hull.vertices.len(), hull.triangles.len()), (8, 12));
/// assert!((hull.volume_mm3() - 1.0).abs() < 1e-12);
/// # Ok::<(), fabkit_mesh::MeshError>(())
/// ```
///
/// # Errors
/// Failure of the boolean kernel. Points in one plane are not an error: their hull is flat, with volume 0.
pub fn convex_hull(points: &[[f64; 3]]) -> Result<Hull, MeshError> {
    let Facets { vertices, triangles, .. } = kernel::hull(points)?;
    Ok(Hull { vertices, triangles })
}
