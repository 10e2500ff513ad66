//! Eight-node brick with a uniform volume change, which does not lock for incompressible materials.

use crate::ElasticMaterial;

/// Number of displacements of the eight nodes.
pub(super) const UNKNOWNS: usize = 24;

/// Position of the second-order Gauss points on -1 to 1.
const GAUSS: f64 = 0.577_350_269_189_625_8;

/// Returns the corner of a node, -1 or 1 along each axis; x runs fastest.
pub(super) fn corner(node: usize) -> [f64; 3] {
    [0, 1, 2].map(|axis| if node >> axis & 1 == 1 { 1.0 } else { -1.0 })
}

/// Computes the change of a brick's volume by each displacement, mm2, for edges in mm.
pub(super) fn dilation(edges_mm: [f64; 3]) -> [f64; UNKNOWNS] {
    let volume_mm3: f64 = edges_mm.iter().product();
    std::array::from_fn(|i| volume_mm3 * corner(i / 3)[i % 3] / (4.0 * edges_mm[i % 3]))
}

/// Computes the stiffness of a brick, N/mm. The volume change enters by its mean, the change of shape at every Gauss
/// point (Hughes, "Generalization of selective integration procedures", 1980).
pub(super) fn stiffness(
    edges_mm: [f64; 3],
    material: &ElasticMaterial,
) -> [[f64; UNKNOWNS]; UNKNOWNS] {
    let volume_mm3: f64 = edges_mm.iter().product();
    let shear = material.shear_modulus_mpa();
    let bulk = material.lame_mpa() + 2.0 / 3.0 * shear;
    let dilation = dilation(edges_mm);
    let mut stiffness = [[0.0; UNKNOWNS]; UNKNOWNS];
    for (row, entries) in stiffness.iter_mut().enumerate() {
        for (column, entry) in entries.iter_mut().enumerate() {
            *entry = bulk * dilation[row] * dilation[column] / volume_mm3;
        }
    }
    for point in 0..8 {
        let at = corner(point).map(|sign| GAUSS * sign);
        let gradients: [[f64; 3]; 8] = std::array::from_fn(|node| {
            let sign = corner(node);
            let factor: [f64; 3] = std::array::from_fn(|axis| 1.0 + sign[axis] * at[axis]);
            std::array::from_fn(|axis| {
                let others = factor[(axis + 1) % 3] * factor[(axis + 2) % 3];
                sign[axis] * others / (4.0 * edges_mm[axis])
            })
        });
        let weight = shear * volume_mm3 / 8.0;
        for (row, entries) in stiffness.iter_mut().enumerate() {
            let (a, i) = (&gradients[row / 3], row % 3);
            for (column, entry) in entries.iter_mut().enumerate() {
                let (b, j) = (&gradients[column / 3], column % 3);
                // Double contraction of the deviatoric strains of two unit displacements.
                let same = if i == j { a[0] * b[0] + a[1] * b[1] + a[2] * b[2] } else { 0.0 };
                *entry += weight * (same + a[j] * b[i] - 2.0 / 3.0 * a[i] * b[j]);
            }
        }
    }
    stiffness
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Forces on the nodes of a brick by a displacement field of its places.
    fn forces(
        edges: [f64; 3],
        material: &ElasticMaterial,
        field: impl Fn([f64; 3]) -> [f64; 3],
    ) -> Vec<f64> {
        let stiffness = stiffness(edges, material);
        let moved: Vec<f64> = (0..8)
            .flat_map(|node| {
                let sign = corner(node);
                field(std::array::from_fn(|axis| sign[axis] * edges[axis] / 2.0))
            })
            .collect();
        stiffness.iter().map(|row| row.iter().zip(&moved).map(|(k, u)| k * u).sum()).collect()
    }

    #[test]
    fn rigid_motions_cost_nothing_and_even_strain_is_exact() {
        let (edges, material) = ([0.7, 1.3, 0.9], ElasticMaterial::new(0.05, 0.49).unwrap());
        for motion in [
            |_: [f64; 3]| [1.0, 2.0, 3.0],
            |[x, y, _]: [f64; 3]| [-y, x, 0.0],
            |[x, _, z]: [f64; 3]| [z, 0.0, -x],
        ] {
            assert!(forces(edges, &material, motion).iter().all(|f| f.abs() < 1e-13));
        }
        // Pulled along x with free sides: E times the cross-section.
        let pulled = forces(edges, &material, |[x, y, z]| [x, -0.49 * y, -0.49 * z]);
        let end: f64 = (0..8).filter(|node| node & 1 == 1).map(|node| pulled[3 * node]).sum();
        assert!((end / (0.05 * edges[1] * edges[2]) - 1.0).abs() < 1e-12);
        // Its volume grows threefold by u = (x, y, z).
        let grown: f64 = (0..UNKNOWNS)
            .map(|i| dilation(edges)[i] * corner(i / 3)[i % 3] * edges[i % 3] / 2.0)
            .sum();
        assert!((grown / (3.0 * edges.iter().product::<f64>()) - 1.0).abs() < 1e-12);
    }
}
