//! Finite element at large strain: energy, forces and tangent.
//!
//! A compressible neo-Hookean material: `W = G/2 (I1 - 3 - 2 ln J) + lambda/2 (J - 1)^2` (after Bonet and Wood,
//! "Nonlinear continuum mechanics for finite element analysis", 2008, section 6.4). The second `J - 1` is projected
//! onto functions that are linear in the element, as at small strain. For small displacements the element becomes that
//! of [`crate::element`].

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use crate::ElasticMaterial;
use crate::element::{Shape, centre};

/// Number of radial and axial displacements of the nine nodes.
pub(crate) const UNKNOWNS: usize = 18;
/// Number of components of the deformation gradient: four in the meridian plane, one circumferential.
const PARTS: usize = 5;

type Parts = SVector<f64, PARTS>;

/// Energy of an element and its derivatives by its unknowns, per radian.
pub(crate) struct ElementState {
    /// Energy, N mm.
    pub energy: f64,
    /// Nodal forces, N.
    pub forces: SVector<f64, UNKNOWNS>,
    /// Tangent stiffness, N/mm.
    pub tangent: SMatrix<f64, UNKNOWNS, UNKNOWNS>,
    /// Volume change, mm3.
    pub growth: f64,
    /// Coefficients of the pressures that follow from its volume change, MPa, and their derivatives by the unknowns.
    pub pressures: Vector3<f64>,
    pub pressures_by: SMatrix<f64, 3, UNKNOWNS>,
}

/// Volume ratio of a deformation gradient, with its first and second derivatives.
struct VolumeRatio {
    ratio: f64,
    slope: Parts,
    curvature: SMatrix<f64, PARTS, PARTS>,
}

impl VolumeRatio {
    /// Computes the volume ratio of a deformation gradient with the components rr, rz, zr, zz and the circumferential
    /// stretch.
    fn from_gradient(f: &Parts) -> Self {
        let [rr, rz, zr, zz, around] = [f[0], f[1], f[2], f[3], f[4]];
        let plane = rr * zz - rz * zr;
        let slope = Parts::new(zz * around, -zr * around, -rz * around, rr * around, plane);
        let mut curvature = SMatrix::zeros();
        let mixed =
            [(0, 3, around), (1, 2, -around), (0, 4, zz), (1, 4, -zr), (2, 4, -rz), (3, 4, rr)];
        for (i, j, value) in mixed {
            curvature[(i, j)] = value;
            curvature[(j, i)] = value;
        }
        Self { ratio: plane * around, slope, curvature }
    }
}

/// Computes an element at given displacements; `None` where it is inverted.
///
/// `held` are pressure coefficients, MPa, for the geometric part of the tangent. Those that follow from the volume
/// change agree with them in the end, but are far off on the way: second-order volume errors times a modulus ratio of
/// thousands.
pub(crate) fn compute_element(
    shape: &Shape,
    places: &[[f64; 2]; 9],
    material: &ElasticMaterial,
    displacements: &SVector<f64, UNKNOWNS>,
    held: &Vector3<f64>,
) -> Option<ElementState> {
    let (shear, lame) = (material.shear_modulus_mpa(), material.lame_mpa());
    let (middle, scale) = centre(places);
    let mut points = Vec::with_capacity(16);
    let (mut pressures, mut mean) = (Matrix3::zeros(), Vector3::zeros());
    let mut by_unknown = SMatrix::<f64, 3, UNKNOWNS>::zeros();
    for point in shape.points(places) {
        let [r, z] = point.place;
        let weight = point.area * r;
        let mut gradient = SMatrix::<f64, PARTS, UNKNOWNS>::zeros();
        for node in 0..9 {
            let [n_r, n_z] = point.slope[node];
            gradient[(0, 2 * node)] = n_r;
            gradient[(1, 2 * node)] = n_z;
            gradient[(2, 2 * node + 1)] = n_r;
            gradient[(3, 2 * node + 1)] = n_z;
            gradient[(4, 2 * node)] = point.value[node] / r;
        }
        let f = gradient * displacements + Parts::new(1.0, 0.0, 0.0, 1.0, 1.0);
        let volume = VolumeRatio::from_gradient(&f);
        if !(volume.ratio > 0.0 && f[4] > 0.0) {
            return None;
        }
        let linear = Vector3::new(1.0, (r - middle[0]) / scale, (z - middle[1]) / scale);
        pressures += weight * linear * linear.transpose();
        mean += weight * (volume.ratio - 1.0) * linear;
        by_unknown += weight * linear * (volume.slope.transpose() * gradient);
        points.push((weight, gradient, f, volume, linear));
    }
    let inverse = pressures.try_inverse()?;
    let amounts = inverse * mean;
    let pressures_by = lame * inverse * by_unknown;
    let mut strained = ElementState {
        energy: 0.5 * lame * mean.dot(&amounts),
        forces: SVector::zeros(),
        tangent: by_unknown.transpose() * pressures_by,
        growth: mean[0],
        pressures: lame * amounts,
        pressures_by,
    };
    for (weight, gradient, f, volume, linear) in &points {
        let by_ratio = lame * amounts.dot(linear) - shear / volume.ratio;
        strained.energy +=
            weight * 0.5 * shear * (f.norm_squared() - 3.0 - 2.0 * volume.ratio.ln());
        let stress = shear * f + by_ratio * volume.slope;
        // The pressure term uses `held`, not the current coefficients; see above.
        let stiffness = SMatrix::<f64, PARTS, PARTS>::identity() * shear
            + volume.slope * volume.slope.transpose() * (shear / volume.ratio.powi(2))
            + (held.dot(linear) - shear / volume.ratio) * volume.curvature;
        strained.forces += *weight * gradient.transpose() * stress;
        strained.tangent += *weight * gradient.transpose() * stiffness * gradient;
    }
    Some(strained)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A skewed element with curved sides.
    const PLACES: [[f64; 2]; 9] = [
        [1.0, 2.0],
        [0.95, 1.5],
        [1.0, 1.0],
        [1.6, 2.15],
        [1.55, 1.55],
        [1.5, 0.95],
        [2.1, 2.0],
        [2.2, 1.6],
        [2.0, 1.1],
    ];

    fn some_displacements(size: f64) -> SVector<f64, UNKNOWNS> {
        SVector::from_fn(|i, _| size * (1.7 * i as f64 + 0.3).sin())
    }

    #[test]
    fn forces_and_tangent_are_derivatives_of_the_energy() {
        let shape = Shape::new();
        for poisson in [0.3, 0.495] {
            let material = ElasticMaterial::new(0.5, poisson).unwrap();
            let u = some_displacements(0.08);
            let first = compute_element(&shape, &PLACES, &material, &u, &Vector3::zeros()).unwrap();
            let at = |u: &SVector<f64, UNKNOWNS>| {
                compute_element(&shape, &PLACES, &material, u, &first.pressures).unwrap()
            };
            let here = at(&u);
            // Differences of energies of about 1, rounded to 1e-16, over twice the step; and the step
            // squared.
            let step = 1e-5;
            for i in 0..UNKNOWNS {
                let moved = |sign: f64| {
                    let mut there = u;
                    there[i] += sign * step;
                    at(&there)
                };
                let (ahead, behind) = (moved(1.0), moved(-1.0));
                let force = (ahead.energy - behind.energy) / (2.0 * step);
                assert!((force - here.forces[i]).abs() < 1e-7 * here.tangent.amax(), "{i}");
                let row = (ahead.forces - behind.forces) / (2.0 * step);
                assert!((row - here.tangent.column(i)).amax() < 1e-7 * here.tangent.amax(), "{i}");
            }
        }
    }

    #[test]
    fn a_small_strain_is_that_of_the_linear_element() {
        let shape = Shape::new();
        let material = ElasticMaterial::new(0.5, 0.49).unwrap();
        let at_rest =
            compute_element(&shape, &PLACES, &material, &SVector::zeros(), &Vector3::zeros())
                .unwrap();
        let linear = shape.stiffness(&PLACES, &material).unwrap().evaluate(0);
        assert!(at_rest.energy.abs() < 1e-15 && at_rest.forces.amax() < 1e-15);
        for i in 0..UNKNOWNS {
            for j in 0..UNKNOWNS {
                // Radial and axial of radial, around and axial.
                let same = linear[(3 * (i / 2) + 2 * (i % 2), 3 * (j / 2) + 2 * (j % 2))];
                assert!((at_rest.tangent[(i, j)] - same).abs() < 1e-12 * linear.amax(), "{i} {j}");
            }
        }
    }

    #[test]
    fn what_is_inside_out_is_none() {
        let material = ElasticMaterial::new(0.5, 0.3).unwrap();
        let u = SVector::from_fn(|i, _| if i % 2 == 1 { -2.0 * PLACES[i / 2][1] } else { 0.0 });
        assert!(
            compute_element(&Shape::new(), &PLACES, &material, &u, &Vector3::zeros()).is_none()
        );
    }
}
