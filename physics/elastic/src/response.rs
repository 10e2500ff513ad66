//! Response of the whole body to tractions on a patch: displacements, force, moment, volumes.

use std::f64::consts::PI;

use fabkit_geometry::Vector3;
use rustfft::num_complex::Complex;

use crate::compliance::{AROUND, directions, field_rows};
use crate::outcome::{ContactState, SurfaceNode, to_body_frame};
use crate::patch::{Patch, Workspace};
use crate::rings::Buffers;
use crate::stack::ElasticStack;

/// Computes the displacement amplitudes of all interfaces' nodes by the tractions in `work.loads`, one vector per
/// harmonic.
pub(crate) fn compute_displacement_amplitudes(
    patch: &Patch<'_>,
    components: &[usize],
    work: &Workspace,
) -> Vec<Vec<Complex<f64>>> {
    let stack = patch.stack;
    let rows = field_rows(&stack.mesh);
    let mut amplitudes = Vec::new();
    for harmonic in 0..=patch.harmonics() {
        let block = &patch.compliances[harmonic];
        let (mut real, mut imaginary) = (vec![0.0; rows], vec![0.0; rows]);
        for ring in patch.rings.start.max(block.first)..patch.rings.end {
            for &component in components {
                let load = work.loads[component].at(harmonic, ring - patch.rings.start);
                let begin = (component * block.rings + ring - block.first) * rows;
                let column = &block.field[begin..begin + rows];
                for ((real, imaginary), entry) in real.iter_mut().zip(&mut imaginary).zip(column) {
                    *real += entry * load.re;
                    *imaginary += entry * load.im;
                }
            }
        }
        amplitudes
            .push(real.iter().zip(&imaginary).map(|(re, im)| Complex::new(*re, *im)).collect());
    }
    amplitudes
}

/// Computes the displacements at the nodes of the touched surface.
pub(crate) fn compute_surface_nodes(
    stack: &ElasticStack,
    amplitudes: &[Vec<Complex<f64>>],
) -> Vec<SurfaceNode> {
    let mut nodes = Vec::with_capacity(stack.rings.nodes);
    let (mut buffers, mut values) = (Buffers::default(), [Vec::new(), Vec::new(), Vec::new()]);
    for (ring, of_ring) in stack.rings.rings.iter().enumerate() {
        let at = |harmonic: usize, k: usize| match amplitudes.get(harmonic) {
            Some(amplitudes) => amplitudes[3 * ring + k],
            None => Complex::default(),
        };
        for (k, values) in values.iter_mut().enumerate() {
            values.resize(of_ring.count, 0.0);
            let turn = if k == 1 { -Complex::i() } else { Complex::new(1.0, 0.0) };
            stack.rings.synthesise(ring, values, &mut buffers, |m| turn * at(m, k));
        }
        let [radial, around, axial] = &values;
        let parts = radial.iter().zip(around).zip(axial);
        for (node, ((radial, around), axial)) in parts.enumerate() {
            let azimuth = stack.rings.azimuth(ring, node);
            let (place_mm, outward) = stack.place(ring, azimuth);
            // On the axis harmonic 1 is a vector across it, which the one-node ring does not carry.
            let displacement_mm = if ring == 0 && amplitudes.len() > 1 {
                Vector3::new(at(1, 0).re, -at(1, 0).im, at(0, 2).re)
            } else {
                to_body_frame([*radial, *around, *axial], azimuth)
            };
            nodes.push(SurfaceNode {
                place_mm,
                outward,
                area_mm2: stack.rings.area_mm2(ring),
                displacement_mm,
                pressure_mpa: 0.0,
                shear_mpa: Vector3::zeros(),
                touch: ContactState::Free,
            });
        }
    }
    nodes
}

/// Computes force and moment of the tractions in `work.loads` exactly as the elements are loaded by them.
pub(crate) fn resultants(
    patch: &Patch<'_>,
    components: &[usize],
    work: &Workspace,
) -> (Vector3<f64>, Vector3<f64>) {
    let stack = patch.stack;
    let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
    for ring in patch.rings.clone() {
        for &component in components {
            let at = |m| work.loads[component].at(m, ring - patch.rings.start);
            let even = at(0);
            let first = if patch.harmonics() > 0 { at(1) } else { Complex::default() };
            for &(column, share) in &stack.rings.rings[ring].column_weights {
                let [r, z] = stack.mesh.nodes[column * stack.mesh.rows];
                for (direction, part) in directions(&stack.mesh, column, component) {
                    let part = part * share * PI;
                    // Transverse force: integrals of harmonic 1 with the sine and cosine of the direction.
                    let across = match direction {
                        0 => Vector3::new(first.re, -first.im, 0.0) * part,
                        1 => Vector3::new(-first.re, first.im, 0.0) * part,
                        _ => Vector3::zeros(),
                    };
                    force += across;
                    moment += Vector3::new(0.0, 0.0, z).cross(&across);
                    // The axial component of harmonic 0 is the normal force; the circumferential one is the torque.
                    match direction {
                        1 => moment.z += 2.0 * part * r * even.im,
                        2 => {
                            force.z += 2.0 * part * even.re;
                            moment += Vector3::new(-first.im, -first.re, 0.0) * (r * part);
                        }
                        _ => {}
                    }
                }
            }
        }
    }
    (force, moment)
}

/// Computes the volume change of each layer by the tractions in `work.loads`, mm3.
pub(crate) fn compute_volume_changes(
    patch: &Patch<'_>,
    components: &[usize],
    work: &Workspace,
) -> Vec<f64> {
    let count = patch.stack.rings.rings.len();
    let of_layer = |by_load: &Vec<f64>| {
        let each = components.iter().flat_map(|&component| {
            patch.rings.clone().map(move |ring| {
                let load = work.loads[component].at(0, ring - patch.rings.start);
                by_load[component * count + ring]
                    * if component == AROUND { load.im } else { load.re }
            })
        });
        each.sum::<f64>()
    };
    patch.stack.dilations.iter().map(of_layer).collect()
}
