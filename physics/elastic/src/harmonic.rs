//! Unknowns and factorised stiffness of one harmonic of the azimuth.

use fabkit_sparse::{Factors, RightHandSides, SparseError, SymmetricPattern};

use crate::ElasticError;
use crate::element::{Shape, StiffnessPolynomial, UNKNOWNS};
use crate::mesh::Mesh;

/// Maps each displacement component of each node to an unknown and a sign.
///
/// On the axis a field must be single-valued: harmonics from 2 on vanish there, harmonic 0 moves along the axis only,
/// and harmonic 1 is one motion across it, `V = -U`.
pub(crate) struct Unknowns {
    /// Unknown and sign by node and component (radial, circumferential, axial).
    indices: Vec<Option<(usize, f64)>>,
    pub count: usize,
}

impl Unknowns {
    /// Numbers the unknowns of a harmonic. The pattern is the same for all harmonics from 2 on.
    pub fn new(mesh: &Mesh, harmonic: usize) -> Self {
        let mut indices = Vec::with_capacity(3 * mesh.nodes.len());
        let mut count = 0;
        let mut next = || {
            count += 1;
            Some((count - 1, 1.0))
        };
        for (node, place) in mesh.nodes.iter().enumerate() {
            let on_axis = place[0] == 0.0;
            match (mesh.is_fixed[node], on_axis, harmonic) {
                // See `Unknowns` for what moves on the axis.
                (true, _, _) | (false, true, 2..) => indices.extend([None; 3]),
                (false, true, 0) => indices.extend([None, None, next()]),
                (false, true, 1) => {
                    let across = next();
                    indices.extend([across, across.map(|(index, _)| (index, -1.0)), None]);
                }
                (false, false, _) => indices.extend([next(), next(), next()]),
            }
        }
        Self { indices, count }
    }

    /// Returns the unknown and the sign of a node's component, or `None` if it cannot move.
    pub fn index_and_sign(&self, node: usize, component: usize) -> Option<(usize, f64)> {
        self.indices[3 * node + component]
    }
}

/// Element stiffnesses and sparsity patterns that the harmonics of a body share.
pub(crate) struct Assembly<'a> {
    mesh: &'a Mesh,
    /// Stiffness of each element.
    parts: Vec<StiffnessPolynomial>,
    /// Patterns of harmonic 0, of harmonic 1, and of all from 2 on.
    patterns: Vec<Pattern>,
}

/// Sparsity pattern of a stiffness matrix, with the unknowns that it belongs to.
struct Pattern {
    unknowns: Unknowns,
    matrix: SymmetricPattern,
}

impl<'a> Assembly<'a> {
    /// Prepares harmonics 0 to `most`.
    ///
    /// # Errors
    /// An element without area.
    pub fn new(mesh: &'a Mesh, most: usize) -> Result<Self, ElasticError> {
        let shape = Shape::new();
        let parts = mesh.elements().map(|element| {
            let material = &mesh.materials[mesh.layer_by_row[element[1]]];
            let parts = shape.stiffness(&mesh.element_places(element), material);
            let reason = || "an element has no area".to_owned();
            parts.ok_or_else(|| ElasticError::Factorisation { harmonic: 0, reason: reason() })
        });
        let parts = parts.collect::<Result<_, _>>()?;
        let patterns = (0..=most.min(2)).map(|harmonic| Pattern::new(mesh, harmonic));
        Ok(Self { mesh, parts, patterns: patterns.collect::<Result<_, _>>()? })
    }

    /// Factorises the stiffness of a harmonic.
    ///
    /// # Errors
    /// A pivot that is not positive: the body is not held.
    pub fn factorise(&self, harmonic: usize) -> Result<FactorisedHarmonic<'_>, ElasticError> {
        let Pattern { unknowns, matrix } = &self.patterns[harmonic.min(self.patterns.len() - 1)];
        let mut values = Vec::new();
        for (element, parts) in self.mesh.elements().zip(&self.parts) {
            let stiffness = parts.evaluate(harmonic);
            for_each_lower_entry(self.mesh, unknowns, element, |[i, j], _, sign| {
                values.push(sign * stiffness[(i, j)]);
            });
        }
        let factors = matrix.factorise(&values).map_err(factorisation_error(harmonic))?;
        Ok(FactorisedHarmonic { unknowns, factors })
    }
}

/// Returns a conversion of solver errors that names the harmonic.
pub(crate) fn factorisation_error(harmonic: usize) -> impl Fn(SparseError) -> ElasticError {
    move |error| ElasticError::Factorisation { harmonic, reason: error.to_string() }
}

impl Pattern {
    /// Analyses the sparsity pattern of a harmonic.
    fn new(mesh: &Mesh, harmonic: usize) -> Result<Self, ElasticError> {
        let unknowns = Unknowns::new(mesh, harmonic);
        let mut places = Vec::new();
        for element in mesh.elements() {
            for_each_lower_entry(mesh, &unknowns, element, |_, place, _| places.push(place));
        }
        let matrix =
            SymmetricPattern::new(unknowns.count, places).map_err(factorisation_error(harmonic))?;
        Ok(Self { unknowns, matrix })
    }
}

/// Calls `entry` for each entry of an element on and below the diagonal, with its indices in the element, its indices
/// in the body's matrix and its sign.
fn for_each_lower_entry(
    mesh: &Mesh,
    unknowns: &Unknowns,
    element: [usize; 2],
    mut entry: impl FnMut([usize; 2], [usize; 2], f64),
) {
    let nodes = mesh.element_nodes(element);
    let of: [_; UNKNOWNS] = std::array::from_fn(|i| unknowns.index_and_sign(nodes[i / 3], i % 3));
    for (i, of_row) in of.iter().enumerate() {
        let Some((row, sign_row)) = *of_row else { continue };
        for (j, of_column) in of.iter().enumerate() {
            let Some((column, sign)) = *of_column else { continue };
            if column <= row {
                entry([i, j], [row, column], sign_row * sign);
            }
        }
    }
}

/// Factorised stiffness of a harmonic.
pub(crate) struct FactorisedHarmonic<'a> {
    pub unknowns: &'a Unknowns,
    factors: Factors,
}

impl FactorisedHarmonic<'_> {
    /// Replaces loads, one column each, by the displacements that they cause.
    pub fn solve(&self, loads: &mut RightHandSides) {
        self.factors.solve(loads);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        BoundaryCondition, ElasticLayer, ElasticMaterial, LayeredBody, MeridianCurve, MeshDensity,
    };

    /// A dome of two materials between a half ellipsoid and a ball, with a free rim: every side is curved.
    fn dome(poisson: f64) -> Mesh {
        let ellipse = |r: f64, z: f64| {
            MeridianCurve::new(move |s| {
                let angle = s * 1.3;
                [r * angle.sin(), z * angle.cos()]
            })
        };
        let layer = |young| ElasticLayer {
            name: "layer".to_owned(),
            material: ElasticMaterial::new(young, poisson).unwrap(),
        };
        let body = LayeredBody {
            interfaces: vec![ellipse(6.0, 5.0), ellipse(5.0, 4.2), ellipse(4.0, 3.0)],
            layers: vec![layer(0.1), layer(1.0)],
            inner: BoundaryCondition::Bonded,
            is_rim_bonded: false,
            kinks: vec![0.37],
        };
        Mesh::new(&body, &MeshDensity::uniform(0.5, 0)).unwrap()
    }

    /// Nodal forces of a displacement field given by U, V, W, and the largest entry of |K| |u| for comparison.
    fn forces(
        mesh: &Mesh,
        harmonic: usize,
        field: &dyn Fn([f64; 2]) -> [f64; 3],
    ) -> (Vec<f64>, f64) {
        let shape = Shape::new();
        let mut forces = vec![0.0; 3 * mesh.nodes.len()];
        let mut largest: f64 = 0.0;
        for element in mesh.elements() {
            let nodes = mesh.element_nodes(element);
            let material = &mesh.materials[mesh.layer_by_row[element[1]]];
            let stiffness = shape
                .stiffness(&mesh.element_places(element), material)
                .unwrap()
                .evaluate(harmonic);
            let values: Vec<f64> = nodes.iter().flat_map(|&n| field(mesh.nodes[n])).collect();
            for i in 0..UNKNOWNS {
                let terms = (0..UNKNOWNS).map(|j| stiffness[(i, j)] * values[j]);
                forces[3 * nodes[i / 3] + i % 3] += terms.clone().sum::<f64>();
                largest = largest.max(terms.map(f64::abs).sum());
            }
        }
        (forces, largest)
    }

    /// Displacement amplitudes U, V, W as a function of the position.
    type Field = fn([f64; 2]) -> [f64; 3];

    #[test]
    fn rigid_motions_cost_nothing() {
        let motions: [(usize, &str, Field); 4] = [
            (0, "up", |_| [0.0, 0.0, 1.0]),
            (0, "about the axis", |[r, _]| [0.0, r, 0.0]),
            (1, "across", |_| [1.0, -1.0, 0.0]),
            (1, "about a line across", |[r, z]| [z, -z, -r]),
        ];
        for poisson in [0.0, 0.3, 0.4999] {
            let mesh = dome(poisson);
            for (harmonic, name, motion) in motions {
                let (forces, largest) = forces(&mesh, harmonic, &motion);
                let worst = forces.iter().fold(0.0, |worst: f64, f| worst.max(f.abs()));
                // 9 elements of 27 terms meet in a node.
                assert!(worst < 1e-13 * largest, "{name}, {poisson}: {worst:e} of {largest:e}");
            }
        }
    }

    #[test]
    fn even_strain_leaves_no_force_inside() {
        // All linear displacement fields, except rigid motions, are of the harmonics 0, 1 and 2.
        let fields: [(usize, Field); 4] = [
            (0, |[r, _]| [r, 0.0, 0.0]),
            (0, |[_, z]| [0.0, 0.0, z]),
            (1, |[_, z]| [z, -z, 0.0]),
            (2, |[r, _]| [r, -r, 0.0]),
        ];
        for poisson in [0.0, 0.3, 0.4999] {
            let mut mesh = dome(poisson);
            mesh.materials[1] = mesh.materials[0];
            for (harmonic, field) in fields {
                let (forces, largest) = forces(&mesh, harmonic, &field);
                let inside = (1..mesh.columns - 1)
                    .flat_map(|column| (1..mesh.rows - 1).map(move |row| (column, row)))
                    .flat_map(|(column, row)| forces[3 * (column * mesh.rows + row)..][..3].iter());
                let worst = inside.fold(0.0, |worst: f64, f| worst.max(f.abs()));
                let surface = forces.iter().fold(0.0, |worst: f64, f| worst.max(f.abs()));
                assert!(worst < 1e-13 * largest, "{harmonic}, {poisson}: {worst:e} of {largest:e}");
                assert!(surface > 1e-6 * largest, "{harmonic}: what is strained needs forces");
            }
        }
    }

    #[test]
    fn volume_grows_as_its_surface_moves() {
        // The field u = (x, y, z) increases a body's volume by three times itself.
        let mesh = dome(0.3);
        let shape = Shape::new();
        let (mut grown, mut volume) = (0.0, 0.0);
        for element in mesh.elements() {
            let places = mesh.element_places(element);
            let dilation = shape.dilation(&places);
            grown += (0..9).map(|n| dilation[3 * n] * places[n][0]).sum::<f64>();
            grown += (0..9).map(|n| dilation[3 * n + 2] * places[n][1]).sum::<f64>();
            volume += shape.points(&places).map(|p| p.area * p.place[0]).sum::<f64>();
        }
        assert!((grown / volume - 3.0).abs() < 1e-12);
    }

    #[test]
    fn a_solution_answers_its_load() {
        let mesh = dome(0.4999);
        for harmonic in [0, 1, 2, 7] {
            let assembly = Assembly::new(&mesh, harmonic).unwrap();
            let solver = assembly.factorise(harmonic).unwrap();
            let node = mesh.interface_node(0, mesh.columns / 2);
            let (row, _) = solver.unknowns.index_and_sign(node, 0).unwrap();
            let mut solution = RightHandSides::new(solver.unknowns.count, 1);
            solution.column_mut(0)[row] = 1.0;
            solver.solve(&mut solution);
            let solution = solution.column(0);
            let value = |node: usize, component: usize| match solver
                .unknowns
                .index_and_sign(node, component)
            {
                Some((index, sign)) => sign * solution[index],
                None => 0.0,
            };
            let shape = Shape::new();
            let mut forces = vec![0.0; solver.unknowns.count];
            for element in mesh.elements() {
                let nodes = mesh.element_nodes(element);
                let material = &mesh.materials[mesh.layer_by_row[element[1]]];
                let stiffness = shape
                    .stiffness(&mesh.element_places(element), material)
                    .unwrap()
                    .evaluate(harmonic);
                for i in 0..UNKNOWNS {
                    let Some((row, sign)) = solver.unknowns.index_and_sign(nodes[i / 3], i % 3)
                    else {
                        continue;
                    };
                    let sum: f64 =
                        (0..UNKNOWNS).map(|j| stiffness[(i, j)] * value(nodes[j / 3], j % 3)).sum();
                    forces[row] += sign * sum;
                }
            }
            forces[row] -= 1.0;
            let worst = forces.iter().fold(0.0, |worst: f64, f| worst.max(f.abs()));
            // The bulk stiffness is 5,000 times the shear stiffness, which costs about four of sixteen digits.
            assert!(worst < 1e-10, "{harmonic}: {worst:e}");
        }
    }
}
