//! Result of a press.

use std::f64::consts::PI;
use std::sync::Arc;

use fabkit_geometry::{Point3, Vector3};
use rustfft::num_complex::Complex;

use crate::compliance::{ALONG, AROUND, NORMAL};
use crate::contact::Contact;
use crate::friction::{Shear, frames};

use crate::indenter::Press;
use crate::mesh::Mesh;
use crate::patch::{Patch, Workspace};
use crate::response::{
    compute_displacement_amplitudes, compute_surface_nodes, compute_volume_changes, resultants,
};
use crate::stack::ElasticStack;

/// Theory by which a press is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StrainTheory {
    /// Small strain: displacements are proportional to tractions.
    Linear,
    /// Large strain, neo-Hookean: axisymmetric presses at the pole.
    Finite,
}

impl StrainTheory {
    /// Returns the name used in outputs.
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
    /// Undeformed position, mm.
    pub place_mm: Point3<f64>,
    /// Undeformed normal out of the body.
    pub outward: Vector3<f64>,
    /// Area that the node stands for, mm2.
    pub area_mm2: f64,
    /// Displacement, mm.
    pub displacement_mm: Vector3<f64>,
    /// Contact pressure, MPa: against the undeformed outward normal; at large strain along the axis, per undeformed
    /// area.
    pub pressure_mpa: f64,
    /// Friction traction, perpendicular to the normal, MPa.
    pub shear_mpa: Vector3<f64>,
    /// State of contact.
    pub touch: ContactState,
}

/// State of contact of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactState {
    /// No contact.
    Free,
    /// Contact with slip: friction is exhausted, or there is none.
    Slipping,
    /// Contact without slip: the surface moves with the indenter.
    Sticking,
}

/// Result of a press, in the body's frame.
///
/// ```
/// use fabkit_elastic::{BallIndenter, ContactState, ElasticLayer, ElasticMaterial, ElasticStack};
/// use fabkit_elastic::{LayeredBody, MeshDensity, Press};
/// use fabkit_geometry::{Point3, Vector3};
///
/// let gel = ElasticLayer { name: "gel".to_owned(), material: ElasticMaterial::new(0.2, 0.49)? };
/// let pad = LayeredBody::pad(10.0, vec![(gel, 2.0)]);
/// let stack = ElasticStack::new(&pad, &MeshDensity::around_pole(0.1, 2.0, 0), 1)?;
/// let ball = BallIndenter::new(Point3::new(0.0, 0.0, 9.0), 3.0)?;
/// let outcome = stack.press(&ball, &Press::along(-Vector3::z(), 0.3)?)?;
/// // Pressures over areas make up the force. Without friction all that touches slips.
/// let sum_n: f64 = outcome.nodes.iter().map(|node| node.pressure_mpa * node.area_mm2).sum();
/// assert!((sum_n / -outcome.force_n.z - 1.0).abs() < 0.02);
/// assert!(outcome.nodes.iter().all(|node| node.touch != ContactState::Sticking));
/// # Ok::<(), fabkit_elastic::ElasticError>(())
/// ```
#[derive(Clone, Debug)]
pub struct PressOutcome {
    mesh: Arc<Mesh>,
    /// Displacement amplitudes by harmonic: interface after interface, column after column, radial, circumferential,
    /// axial.
    pub(crate) amplitudes: Vec<Vec<Complex<f64>>>,
    /// Nodes of the touched surface, ring after ring from the pole outwards.
    pub nodes: Vec<SurfaceNode>,
    /// Theory of the computation.
    pub level: StrainTheory,
    /// Depth to which the indenter reaches below the undeformed surface, along its normals, mm.
    pub depth_mm: f64,
    /// Force of the indenter on the body, N.
    pub force_n: Vector3<f64>,
    /// Moment of the indenter on the body about the origin, N mm.
    pub moment_nmm: Vector3<f64>,
    /// Area of all nodes in contact, mm2: undeformed; at large strain, of the deformed contact disc.
    pub contact_area_mm2: f64,
    /// Area of the nodes that stick to the indenter, mm2; all others slip.
    pub stick_area_mm2: f64,
    /// Radius of the circle with the area of contact, mm; accurate to about half the node spacing.
    pub contact_radius_mm: f64,
    /// Largest displacement into the body, along the normal, mm.
    pub max_indentation_mm: f64,
    /// Largest displacement out of the body, along the normal, mm.
    pub bulge_mm: f64,
    /// Volume change of each layer, mm3, from the touched one inwards.
    pub volume_change_mm3: Vec<f64>,
    /// Elastic energy of the layers, N mm; known at large strain only.
    pub energy_nmm: Option<f64>,
    /// Number of contact iterations.
    pub iterations: usize,
}

impl PressOutcome {
    /// Evaluates displacements, resultants and the state of contact from solved pressures and friction tractions.
    pub(crate) fn new(
        patch: &Patch<'_>,
        contact: &Contact,
        shear: Option<&Shear>,
        press: &Press,
        depth_mm: f64,
        work: &mut Workspace,
    ) -> Self {
        let stack = patch.stack;
        let pushed: Vec<f64> = contact.pressures.iter().map(|pressure| -pressure).collect();
        let across = |k: usize| shear.map(|shear| shear.tractions[k].as_slice());
        patch.analyse([Some(&pushed), across(0), across(1)], work);
        let components: &[usize] =
            if shear.is_some() { &[NORMAL, ALONG, AROUND] } else { &[NORMAL] };
        let amplitudes = compute_displacement_amplitudes(patch, components, work);
        let (force_n, moment_nmm) = resultants(patch, components, work);
        let mut nodes = compute_surface_nodes(stack, &amplitudes);
        let begin = stack.rings.rings[patch.rings.start].first;
        for (i, node) in nodes[begin..begin + pushed.len()].iter_mut().enumerate() {
            node.pressure_mpa = contact.pressures[i];
            if node.pressure_mpa > 0.0 {
                node.touch = ContactState::Slipping;
            }
        }
        if let Some(shear) = shear {
            for (i, [_, along, around]) in frames(patch).iter().enumerate() {
                let node = &mut nodes[begin + i];
                node.shear_mpa = shear.tractions[0][i] * along + shear.tractions[1][i] * around;
                let limit_mpa = press.friction * node.pressure_mpa;
                // Tractions below the friction limit stick; the margin absorbs rounding.
                if node.shear_mpa.norm() < limit_mpa * (1.0 - 1e-9) {
                    node.touch = ContactState::Sticking;
                }
            }
        }
        let area = |touch: ContactState| {
            let those = nodes.iter().filter(|node| node.touch == touch);
            those.map(|node| node.area_mm2).sum::<f64>()
        };
        let (stick_area_mm2, slip_area_mm2) =
            (area(ContactState::Sticking), area(ContactState::Slipping));
        let outwards = |node: &SurfaceNode| node.displacement_mm.dot(&node.outward);
        let contact_area_mm2 = stick_area_mm2 + slip_area_mm2;
        let volume_change_mm3 = compute_volume_changes(patch, components, work);
        Self {
            mesh: Arc::clone(&stack.mesh),
            amplitudes,
            level: StrainTheory::Linear,
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

    /// Creates an outcome at large strain from the displacements of all mesh nodes, radial and axial, and the rings'
    /// pressures along the axis.
    pub(crate) fn from_finite_strain(
        stack: &ElasticStack,
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
                // Two displacements per node, radial and axial.
                let node = 2 * mesh.interface_node(interface, column);
                let parts = [displacements[node], 0.0, displacements[node + 1]];
                amplitudes.extend(parts.map(|part| Complex::new(part, 0.0)));
            }
        }
        let amplitudes = vec![amplitudes];
        let mut nodes = compute_surface_nodes(stack, &amplitudes);
        let mut force_n = Vector3::zeros();
        for (ring, node) in nodes.iter_mut().enumerate() {
            node.pressure_mpa = pressures[ring];
            if pressures[ring] > 0.0 {
                node.touch = ContactState::Slipping;
            }
            // By symmetry the force is axial, and the moment vanishes.
            force_n.z -= 2.0 * PI * stack.rings.rings[ring].weight * pressures[ring];
        }
        let outwards = |node: &SurfaceNode| node.displacement_mm.dot(&node.outward);
        // The contact's edge lies on the deformed surface, between the last node in contact and the next.
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
            level: StrainTheory::Finite,
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

    /// Returns the displacement of an interface (0 is the touched surface), mm, at an azimuth, radians, and a parameter
    /// s of its curve, from 0 on the axis to 1 at the rim. Zero for interfaces that do not exist or cannot move.
    ///
    /// ```
    /// use fabkit_elastic::{BallIndenter, ElasticLayer, ElasticMaterial, ElasticStack, LayeredBody};
    /// use fabkit_elastic::{MeshDensity, Press};
    /// use fabkit_geometry::{Point3, Vector3};
    ///
    /// // Two layers of 1 mm each: interface 0 is touched, 1 lies between them, 2 is bonded to the floor.
    /// let gel = ElasticLayer { name: "gel".to_owned(), material: ElasticMaterial::new(0.2, 0.49)? };
    /// let pad = LayeredBody::pad(10.0, vec![(gel.clone(), 1.0), (gel, 1.0)]);
    /// let stack = ElasticStack::new(&pad, &MeshDensity::around_pole(0.1, 2.0, 0), 1)?;
    /// let ball = BallIndenter::new(Point3::new(0.0, 0.0, 9.0), 3.0)?;
    /// let outcome = stack.press(&ball, &Press::along(-Vector3::z(), 0.3)?)?;
    /// let [touched, middle, floor] = [0, 1, 2].map(|i| outcome.displacement_mm(i, 0.0, 0.0).z);
    /// assert!((touched + 0.3).abs() < 0.003 && touched < middle && middle < 0.0 && floor == 0.0);
    /// # Ok::<(), fabkit_elastic::ElasticError>(())
    /// ```
    pub fn displacement_mm(&self, interface: usize, azimuth: f64, s: f64) -> Vector3<f64> {
        if interface >= self.mesh.moving_interfaces() {
            return Vector3::zeros();
        }
        let (column, values) = self.mesh.interpolation(s);
        let mut parts = [0.0; 3];
        // Powers of one rotation replace a sine and cosine per harmonic; a hundred of them lose two digits of sixteen.
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
        to_body_frame(parts, azimuth)
    }

    /// Returns the unit normal out of the undeformed touched surface.
    ///
    /// ```
    /// # use fabkit_elastic::{BallIndenter, BoundaryCondition, ElasticLayer, ElasticMaterial, ElasticStack};
    /// # use fabkit_elastic::{LayeredBody, MeridianCurve, MeshDensity, Press};
    /// # use fabkit_geometry::{Point3, Vector3};
    /// // A half ball of radius 10 mm on a core of radius 8 mm: s runs from the tip to the rim, in quarters of a turn.
    /// let round = |radius_mm: f64| {
    ///     MeridianCurve::new(move |s| {
    ///         let (sin, cos) = (s * std::f64::consts::FRAC_PI_2).sin_cos();
    ///         [radius_mm * sin, radius_mm * cos]
    ///     })
    /// };
    /// # let gel = ElasticLayer { name: "gel".to_owned(), material: ElasticMaterial::new(0.2, 0.49)? };
    /// # let (interfaces, inner) = (vec![round(10.0), round(8.0)], BoundaryCondition::Bonded);
    /// # let body = LayeredBody { interfaces, layers: vec![gel], inner, is_rim_bonded: true, kinks: vec![] };
    /// let stack = ElasticStack::new(&body, &MeshDensity::uniform(0.25, 0), 1)?;
    /// # let ball = BallIndenter::new(Point3::new(0.0, 0.0, 20.0), 3.0)?;
    /// let outcome = stack.press(&ball, &Press::along(-Vector3::z(), 0.2)?)?;
    /// // Half way down, at azimuth 0: 45 degrees between up and +x. Places are those before the press.
    /// let way = Vector3::new(1.0, 0.0, 1.0).normalize();
    /// assert!((outcome.outward(0.0, 0.5) - way).norm() < 1e-3);
    /// assert!((outcome.place_mm(0, 0.0, 0.5).coords - 10.0 * way).norm() < 1e-2);
    /// # Ok::<(), fabkit_elastic::ElasticError>(())
    /// ```
    pub fn outward(&self, azimuth: f64, s: f64) -> Vector3<f64> {
        let (column, values) = self.mesh.interpolation(s);
        let part = |k: usize| {
            let each = values.iter().enumerate();
            each.map(|(i, value)| value * self.mesh.frames[column + i].normal[k]).sum::<f64>()
        };
        to_body_frame([part(0), 0.0, part(1)], azimuth).normalize()
    }

    /// Returns a point of an undeformed interface, mm.
    pub fn place_mm(&self, interface: usize, azimuth: f64, s: f64) -> Point3<f64> {
        self.mesh.interface_place(interface, s, azimuth)
    }

    /// Values of s of the mesh columns, which all interfaces share.
    pub fn columns(&self) -> &[f64] {
        &self.mesh.s
    }

    /// Number of interfaces, including the touched and the innermost one.
    pub fn interfaces(&self) -> usize {
        self.mesh.interface_rows.len()
    }
}

/// Converts radial, circumferential and axial parts at an azimuth to a vector in the body's frame.
pub(crate) fn to_body_frame([radial, around, axial]: [f64; 3], azimuth: f64) -> Vector3<f64> {
    let (sin, cos) = azimuth.sin_cos();
    Vector3::new(radial * cos - around * sin, radial * sin + around * cos, axial)
}
