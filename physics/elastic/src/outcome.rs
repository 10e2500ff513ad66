//! What a press does.

use std::f64::consts::PI;
use std::sync::Arc;

use fabkit_geometry::{Point3, Vector3};
use rustfft::num_complex::Complex;

use crate::compliance::{ALONG, AROUND, NORMAL};
use crate::contact::Contact;
use crate::friction::{Shear, frames};

use crate::mesh::Mesh;
use crate::patch::{Patch, Work};
use crate::presser::Press;
use crate::response::{field, resultants, surface, volumes};
use crate::stack::Stack;

/// By which theory an outcome was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Small strain: displacements in proportion to tractions.
    Linear,
    /// Large strain, neo-Hookean: presses at the pole that are symmetric about the axis.
    Finite,
}

impl Level {
    /// As outputs name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Finite => "finite",
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
    /// What the presser pushes with, MPa: against the outward normal at rest; at large strain along the axis,
    /// per area at rest.
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
    pub(crate) amplitudes: Vec<Vec<Complex<f64>>>,
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
    /// Of all nodes that the presser pushes, mm2: at rest; at large strain of the disc that it then holds.
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
    /// What is stored in the layers, N mm; known at large strain.
    pub energy_nmm: Option<f64>,
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
            energy_nmm: None,
            iterations: contact.iterations,
        }
    }

    /// From displacements of all nodes of the mesh, radial and axial, and pressures of rings along the axis.
    pub(crate) fn finite(
        stack: &Stack,
        displacements: &[f64],
        pressures: &[f64],
        volume_change_mm3: Vec<f64>,
        [depth_mm, energy_nmm]: [f64; 2],
        iterations: usize,
    ) -> Self {
        let mesh = &stack.mesh;
        let mut amplitudes = Vec::with_capacity(3 * mesh.moving_interfaces() * mesh.columns);
        for interface in 0..mesh.moving_interfaces() {
            for column in 0..mesh.columns {
                let node = 2 * mesh.interface_node(interface, column);
                let parts = [displacements[node], 0.0, displacements[node + 1]];
                amplitudes.extend(parts.map(|part| Complex::new(part, 0.0)));
            }
        }
        let amplitudes = vec![amplitudes];
        let mut nodes = surface(stack, &amplitudes);
        let mut force_n = Vector3::zeros();
        for (ring, node) in nodes.iter_mut().enumerate() {
            node.pressure_mpa = pressures[ring];
            if pressures[ring] > 0.0 {
                node.touch = Touch::Slips;
            }
            force_n.z -= 2.0 * PI * stack.rings.rings[ring].weight * pressures[ring];
        }
        let outwards = |node: &SurfaceNode| node.displacement_mm.dot(&node.outward);
        // The edge is where the surface then is, between the last node that is held and the next.
        let moved_mm = |node: &SurfaceNode| node.place_mm.x + node.displacement_mm.x;
        let contact_radius_mm = match nodes.iter().rposition(|node| node.pressure_mpa > 0.0) {
            Some(last) => {
                let next = (last + 1).min(nodes.len() - 1);
                0.5 * (moved_mm(&nodes[last]) + moved_mm(&nodes[next]))
            }
            None => 0.0,
        };
        let contact_area_mm2 = PI * contact_radius_mm.powi(2);
        Self {
            mesh: Arc::clone(mesh),
            amplitudes,
            level: Level::Finite,
            depth_mm,
            force_n,
            moment_nmm: Vector3::zeros(),
            contact_area_mm2,
            stick_area_mm2: 0.0,
            contact_radius_mm,
            max_indentation_mm: nodes.iter().map(|node| -outwards(node)).fold(0.0, f64::max),
            bulge_mm: nodes.iter().map(outwards).fold(0.0, f64::max),
            nodes,
            volume_change_mm3,
            energy_nmm: Some(energy_nmm),
            iterations,
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
        // A turn more with each harmonic: a hundred of them lose two digits of sixteen.
        let step = Complex::from_polar(1.0, azimuth);
        let mut turn = Complex::new(1.0, 0.0);
        for amplitudes in &self.amplitudes {
            let (sin, cos) = (turn.im, turn.re);
            turn *= step;
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

    /// The unit normal out of the touched surface at rest.
    pub fn outward(&self, azimuth: f64, s: f64) -> Vector3<f64> {
        let (column, values) = self.mesh.interpolation(s);
        let part = |k: usize| {
            let each = values.iter().enumerate();
            each.map(|(i, value)| value * self.mesh.frames[column + i].normal[k]).sum::<f64>()
        };
        turned([part(0), 0.0, part(1)], azimuth).normalize()
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
pub(crate) fn turned([radial, around, axial]: [f64; 3], azimuth: f64) -> Vector3<f64> {
    let (sin, cos) = azimuth.sin_cos();
    Vector3::new(radial * cos - around * sin, radial * sin + around * cos, axial)
}
