//! What a press does.

use std::f64::consts::PI;
use std::sync::Arc;

use fabkit_geometry::{Point3, Vector3};
use rustfft::num_complex::Complex;

use crate::compliance::{ALONG, AROUND, NORMAL, directions, field_rows};
use crate::contact::Contact;
use crate::friction::{Shear, frames};

use crate::mesh::Mesh;
use crate::patch::{Patch, Work};
use crate::presser::Press;
use crate::rings::Buffers;
use crate::stack::Stack;

/// By which theory an outcome was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Small strain: displacements in proportion to tractions.
    Linear,
}

impl Level {
    /// As outputs name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
        }
    }
}

/// A node of the touched surface, in the body's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceNode {
    /// At rest, mm.
    pub place_mm: Point3<f64>,
    /// Out of the body, at rest.
    pub outward: Vector3<f64>,
    /// The area that it stands for, mm2.
    pub area_mm2: f64,
    /// From rest, mm.
    pub displacement_mm: Vector3<f64>,
    /// What the presser pushes with, against the outward normal, MPa.
    pub pressure_mpa: f64,
    /// What friction drags with, across the normal, MPa.
    pub shear_mpa: Vector3<f64>,
    /// Whether the presser holds it.
    pub touch: Touch,
}

/// What a presser does to a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Touch {
    /// It is not there.
    Free,
    /// It pushes, and slips: friction is used up, or there is none.
    Slips,
    /// It pushes, and takes the surface along.
    Sticks,
}

/// What a press does, in the body's frame.
#[derive(Clone, Debug)]
pub struct Outcome {
    mesh: Arc<Mesh>,
    /// By harmonic: interface after interface, column after column, radial, around, axial.
    amplitudes: Vec<Vec<Complex<f64>>>,
    /// Nodes of the touched surface, ring after ring from the pole outwards.
    pub nodes: Vec<SurfaceNode>,
    /// By which theory.
    pub level: Level,
    /// How far the presser reaches below the surface at rest, along its normals, mm.
    pub depth_mm: f64,
    /// Of the presser on the body, N.
    pub force_n: Vector3<f64>,
    /// Of the presser on the body about the origin, N mm.
    pub moment_nmm: Vector3<f64>,
    /// Of all nodes that the presser pushes, mm2.
    pub contact_area_mm2: f64,
    /// Of those nodes that move with the presser, mm2; all others slip.
    pub stick_area_mm2: f64,
    /// Of the circle of the area that is pushed, mm; to about half the distance of nodes.
    pub contact_radius_mm: f64,
    /// The largest displacement into the body, along the normal, mm.
    pub max_indentation_mm: f64,
    /// The largest displacement out of the body, along the normal, mm.
    pub bulge_mm: f64,
    /// What each layer's volume gains, mm3, from the touched one inwards.
    pub volume_change_mm3: Vec<f64>,
    /// How often the contact was improved.
    pub iterations: usize,
}

impl Outcome {
    pub(crate) fn new(
        patch: &Patch<'_>,
        contact: &Contact,
        shear: Option<&Shear>,
        press: &Press,
        depth_mm: f64,
        work: &mut Work,
    ) -> Self {
        let stack = patch.stack;
        let pushed: Vec<f64> = contact.pressures.iter().map(|pressure| -pressure).collect();
        let across = |k: usize| shear.map(|shear| shear.tractions[k].as_slice());
        patch.analyse([Some(&pushed), across(0), across(1)], work);
        let components: &[usize] =
            if shear.is_some() { &[NORMAL, ALONG, AROUND] } else { &[NORMAL] };
        let amplitudes = field(patch, components, work);
        let (force_n, moment_nmm) = resultants(patch, components, work);
        let mut nodes = surface(stack, &amplitudes);
        let begin = stack.rings.rings[patch.rings.start].first;
        for (i, node) in nodes[begin..begin + pushed.len()].iter_mut().enumerate() {
            node.pressure_mpa = contact.pressures[i];
            if node.pressure_mpa > 0.0 {
                node.touch = Touch::Slips;
            }
        }
        if let Some(shear) = shear {
            for (i, [_, along, around]) in frames(patch).iter().enumerate() {
                let node = &mut nodes[begin + i];
                node.shear_mpa = shear.tractions[0][i] * along + shear.tractions[1][i] * around;
                let limit_mpa = press.friction * node.pressure_mpa;
                if node.shear_mpa.norm() < limit_mpa * (1.0 - 1e-9) {
                    node.touch = Touch::Sticks;
                }
            }
        }
        let area = |touch: Touch| {
            let those = nodes.iter().filter(|node| node.touch == touch);
            those.map(|node| node.area_mm2).sum::<f64>()
        };
        let (stick_area_mm2, slip_area_mm2) = (area(Touch::Sticks), area(Touch::Slips));
        let outwards = |node: &SurfaceNode| node.displacement_mm.dot(&node.outward);
        let contact_area_mm2 = stick_area_mm2 + slip_area_mm2;
        let volume_change_mm3 = volumes(patch, components, work);
        Self {
            mesh: Arc::clone(&stack.mesh),
            amplitudes,
            level: Level::Linear,
            depth_mm,
            force_n,
            moment_nmm,
            contact_area_mm2,
            stick_area_mm2,
            contact_radius_mm: (contact_area_mm2 / PI).sqrt(),
            max_indentation_mm: nodes.iter().map(|node| -outwards(node)).fold(0.0, f64::max),
            bulge_mm: nodes.iter().map(outwards).fold(0.0, f64::max),
            nodes,
            volume_change_mm3,
            iterations: contact.iterations,
        }
    }

    /// Displacement of an interface (0 is the touched surface) at an azimuth, radians, and a place s of its
    /// curve, from 0 on the axis to 1 at the rim, mm. Zero where there is no such interface.
    pub fn displacement_mm(&self, interface: usize, azimuth: f64, s: f64) -> Vector3<f64> {
        if interface >= self.mesh.moving_interfaces() {
            return Vector3::zeros();
        }
        let (column, values) = self.mesh.interpolation(s);
        let mut parts = [0.0; 3];
        for (harmonic, amplitudes) in self.amplitudes.iter().enumerate() {
            let (sin, cos) = (harmonic as f64 * azimuth).sin_cos();
            for (i, value) in values.iter().enumerate() {
                let here = 3 * (interface * self.mesh.columns + column + i);
                let [radial, around, axial] = [0, 1, 2].map(|k| amplitudes[here + k]);
                parts[0] += value * (radial.re * cos - radial.im * sin);
                parts[1] += value * (around.re * sin + around.im * cos);
                parts[2] += value * (axial.re * cos - axial.im * sin);
            }
        }
        turned(parts, azimuth)
    }

    /// A place of an interface at rest, mm.
    pub fn place_mm(&self, interface: usize, azimuth: f64, s: f64) -> Point3<f64> {
        self.mesh.interface_place(interface, s, azimuth)
    }

    /// s of each column of nodes, which all interfaces share.
    pub fn columns(&self) -> &[f64] {
        &self.mesh.s
    }

    /// How many interfaces there are, the touched one and the innermost included.
    pub fn interfaces(&self) -> usize {
        self.mesh.interface_rows.len()
    }
}

/// Radial, around and axial parts at an azimuth to the body's frame.
fn turned([radial, around, axial]: [f64; 3], azimuth: f64) -> Vector3<f64> {
    let (sin, cos) = azimuth.sin_cos();
    Vector3::new(radial * cos - around * sin, radial * sin + around * cos, axial)
}

/// Displacements of all interfaces' nodes by the tractions in `work.loads`.
fn field(patch: &Patch<'_>, components: &[usize], work: &Work) -> Vec<Vec<Complex<f64>>> {
    let stack = patch.stack;
    let rows = field_rows(&stack.mesh);
    let mut amplitudes = Vec::new();
    for harmonic in 0..=patch.harmonics() {
        let block = &stack.compliances[harmonic];
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

/// Displacements at the nodes of the touched surface.
fn surface(stack: &Stack, amplitudes: &[Vec<Complex<f64>>]) -> Vec<SurfaceNode> {
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
            let displacement_mm = match ring == 0 && amplitudes.len() > 1 {
                true => Vector3::new(at(1, 0).re, -at(1, 0).im, at(0, 2).re),
                false => turned([*radial, *around, *axial], azimuth),
            };
            nodes.push(SurfaceNode {
                place_mm,
                outward,
                area_mm2: stack.rings.area_mm2(ring),
                displacement_mm,
                pressure_mpa: 0.0,
                shear_mpa: Vector3::zeros(),
                touch: Touch::Free,
            });
        }
    }
    nodes
}

/// Force and moment of the tractions in `work.loads`, exactly as the elements feel them.
fn resultants(
    patch: &Patch<'_>,
    components: &[usize],
    work: &Work,
) -> (Vector3<f64>, Vector3<f64>) {
    let stack = patch.stack;
    let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
    for ring in patch.rings.clone() {
        for &component in components {
            let at = |m| work.loads[component].at(m, ring - patch.rings.start);
            let even = at(0);
            let first = if patch.harmonics() > 0 { at(1) } else { Complex::default() };
            for &(column, share) in &stack.rings.rings[ring].shares {
                let [r, z] = stack.mesh.nodes[column * stack.mesh.rows];
                for (direction, part) in directions(&stack.mesh, column, component) {
                    let part = part * share * PI;
                    // Across: integrals of the first harmonic with the directions' own sine and cosine.
                    let across = match direction {
                        0 => Vector3::new(first.re, -first.im, 0.0) * part,
                        1 => Vector3::new(-first.re, first.im, 0.0) * part,
                        _ => Vector3::zeros(),
                    };
                    force += across;
                    moment += Vector3::new(0.0, 0.0, z).cross(&across);
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

/// What layers gain by the tractions in `work.loads`, mm3.
fn volumes(patch: &Patch<'_>, components: &[usize], work: &Work) -> Vec<f64> {
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
