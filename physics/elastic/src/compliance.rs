//! Compliance of the touched surface: two dense matrices for each harmonic.
//!
//! For a body of revolution the map from tractions on the touched surface to displacements is block-circulant in the
//! azimuth; each harmonic has its own blocks and is independent of the others. Only loads that a press can apply are
//! solved for: rings that nothing touches cost nothing, nor do tangential tractions without friction.

use std::ops::Range;

use fabkit_sparse::RightHandSides;

use crate::ElasticError;
use crate::element::Shape;
use crate::harmonic::Assembly;
use crate::mesh::Mesh;
use crate::resources::SolverResources;
use crate::rings::Rings;

/// Memory limit of the matrices of the largest solver, MiB.
const LIMIT_MIB: usize = 3000;

/// Normal component of tractions and displacements on the touched surface.
pub(crate) const NORMAL: usize = 0;
/// Component along s.
pub(crate) const ALONG: usize = 1;
/// Component around the axis. Its amplitudes are those of the sine: `i` times the amplitudes of the values.
pub(crate) const AROUND: usize = 2;

/// Rings that are always solved for together, whatever else a press needs. The same traction then has the same
/// solution, to the last bit, in every stack of a body.
const RING_GROUP: usize = 8;

/// Set of unit tractions to solve for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct LoadSet {
    /// Loaded rings: whole groups of [`RING_GROUP`].
    rings: Range<usize>,
    /// 1 for pressures alone, 3 with tangential tractions.
    components: usize,
}

impl LoadSet {
    /// Creates the loads for a range of rings of a surface with `count` rings, rounded out to whole groups.
    pub fn new(rings: &Range<usize>, is_dragged: bool, count: usize) -> Self {
        let start = rings.start / RING_GROUP * RING_GROUP;
        let end = rings.end.next_multiple_of(RING_GROUP).min(count);
        Self { rings: start..end, components: if is_dragged { 3 } else { 1 } }
    }

    /// Returns whether `others` are a subset of these loads.
    pub fn contains(&self, others: &Self) -> bool {
        self.components >= others.components
            && self.rings.start <= others.rings.start
            && self.rings.end >= others.rings.end
    }

    /// Returns the union of both, including the rings between them.
    pub fn union(&self, others: &Self) -> Self {
        let start = self.rings.start.min(others.rings.start);
        Self {
            rings: start..self.rings.end.max(others.rings.end),
            components: self.components.max(others.components),
        }
    }

    /// Highest harmonic of any loaded ring: that of the outermost.
    fn harmonics(&self, rings: &Rings) -> usize {
        rings.rings[self.rings.end - 1].harmonics
    }

    /// Returns the loaded rings that carry a harmonic.
    fn with(&self, rings: &Rings, harmonic: usize) -> Range<usize> {
        rings.first_with(harmonic).max(self.rings.start)..self.rings.end
    }
}

/// Compliance matrices of one harmonic.
#[derive(Clone, Debug)]
pub(crate) struct Compliance {
    /// First loaded ring that carries the harmonic.
    pub first: usize,
    /// Number of rings.
    pub rings: usize,
    /// 1 for pressures alone, 3 with tangential tractions.
    pub components: usize,
    /// Map from tractions to mean displacements of rings, mm/MPa: square, column-major, with each component's rings in
    /// one piece. Weighted by the rings' weights it is symmetric (Betti's reciprocity).
    pub contact: Vec<f64>,
    /// Map from tractions to displacements of the nodes of movable interfaces, mm/MPa: column-major. Rows run over
    /// interfaces, mesh columns within, then radial, circumferential and axial.
    pub field: Vec<f64>,
}

impl Compliance {
    /// Solves a harmonic for unit tractions on each ring.
    ///
    /// # Errors
    /// A body that is not held.
    pub fn new(
        assembly: &Assembly<'_>,
        mesh: &Mesh,
        rings: &Rings,
        harmonic: usize,
        loads: &LoadSet,
    ) -> Result<Self, ElasticError> {
        let solver = assembly.factorise(harmonic)?;
        let loaded = loads.with(rings, harmonic);
        let (count, components) = (loaded.len(), loads.components);
        let mut contact = Vec::with_capacity((components * count).pow(2));
        let mut field = Vec::with_capacity(components * count * field_rows(mesh));
        let mut solution = RightHandSides::new(solver.unknowns.count, RING_GROUP);
        for component in 0..components {
            let mut begin = loaded.start;
            while begin < loaded.end {
                // Ends at fixed multiples, so that a group does not depend on where the range begins.
                let group = begin..(begin + 1).next_multiple_of(RING_GROUP).min(loaded.end);
                solution.clear();
                for (load, ring) in group.clone().enumerate() {
                    let side = solution.column_mut(load);
                    for &(column, share) in &rings.rings[ring].column_weights {
                        for (direction, part) in directions(mesh, column, component) {
                            let unknown =
                                solver.unknowns.index_and_sign(column * mesh.rows, direction);
                            if let Some((row, sign)) = unknown {
                                side[row] += sign * share * part;
                            }
                        }
                    }
                }
                solver.solve(&mut solution);
                for load in 0..group.len() {
                    let solved = solution.column(load);
                    let value = |node: usize, direction: usize| {
                        let unknown = solver.unknowns.index_and_sign(node, direction);
                        unknown.map_or(0.0, |(row, sign)| sign * solved[row])
                    };
                    for moved in 0..components {
                        contact.extend(rings.rings[loaded.clone()].iter().map(|ring| {
                            // Mean over the ring's hat function; by reciprocity it has the weights of the load.
                            let shares = ring.column_weights.iter().map(|&(column, share)| {
                                let along =
                                    |(d, part): (usize, f64)| part * value(column * mesh.rows, d);
                                share
                                    * directions(mesh, column, moved).map(along).iter().sum::<f64>()
                            });
                            shares.sum::<f64>() / ring.weight
                        }));
                    }
                    for interface in 0..mesh.moving_interfaces() {
                        for column in 0..mesh.columns {
                            let node = mesh.interface_node(interface, column);
                            field.extend((0..3).map(|direction| value(node, direction)));
                        }
                    }
                }
                begin = group.end;
            }
        }
        Ok(Self { first: loaded.start, rings: count, components, contact, field })
    }
}

/// Number of rows of [`Compliance::field`].
pub(crate) fn field_rows(mesh: &Mesh) -> usize {
    3 * mesh.moving_interfaces() * mesh.columns
}

/// Returns a component on the touched surface as parts of radial (0), circumferential (1) and axial (2) displacement.
pub(crate) fn directions(mesh: &Mesh, column: usize, component: usize) -> [(usize, f64); 2] {
    let frame = &mesh.frames[column];
    match component {
        NORMAL => [(0, frame.normal[0]), (2, frame.normal[1])],
        ALONG => [(0, frame.tangent[0]), (2, frame.tangent[1])],
        // The second part only makes the arrays equally long.
        _ => [(1, 1.0), (1, 0.0)],
    }
}

/// Checks the memory that the matrices need, of which `memory_bytes` are allowed.
///
/// # Errors
/// Matrices that take more memory than [`LIMIT_MIB`], or than allowed.
fn check_size(
    mesh: &Mesh,
    rings: &Rings,
    loads: &LoadSet,
    memory_bytes: u64,
) -> Result<(), ElasticError> {
    let allowed_mib = usize::try_from(memory_bytes >> 20).unwrap_or(usize::MAX);
    let limit_mib = LIMIT_MIB.min(allowed_mib);
    let harmonics = loads.harmonics(rings);
    let numbers: usize = (0..=harmonics)
        .map(|harmonic| {
            let loads = loads.components * loads.with(rings, harmonic).len();
            loads * (loads + field_rows(mesh))
        })
        .sum();
    let needed_mib = numbers * size_of::<f64>() / (1 << 20);
    if needed_mib > limit_mib {
        Err(ElasticError::TooLarge {
            harmonics: harmonics + 1,
            rings: loads.rings.len(),
            needed_mib,
            limit_mib,
        })
    } else {
        Ok(())
    }
}

/// Solves all harmonics of the loads on several threads. One thread solves a harmonic as a whole, so that results do
/// not depend on the number of threads.
///
/// # Errors
/// More memory than [`LIMIT_MIB`] or than allowed, or the error of the lowest harmonic that cannot be factorised.
pub(crate) fn solve_all(
    mesh: &Mesh,
    rings: &Rings,
    loads: &LoadSet,
    resources: SolverResources,
) -> Result<Vec<Compliance>, ElasticError> {
    check_size(mesh, rings, loads, resources.memory_bytes)?;
    let count = loads.harmonics(rings) + 1;
    let assembly = Assembly::new(mesh, count - 1)?;
    let threads = resources.threads.clamp(1, count);
    let next = std::sync::atomic::AtomicUsize::new(0);
    let work = || {
        let mut done = Vec::new();
        loop {
            // Harmonics are handed out one by one, since they differ in cost.
            let harmonic = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            if harmonic >= count {
                return done;
            }
            done.push((harmonic, Compliance::new(&assembly, mesh, rings, harmonic, loads)));
        }
    };
    let mut found: Vec<(usize, Result<Compliance, ElasticError>)> = std::thread::scope(|scope| {
        let others: Vec<_> = (1..threads).map(|_| scope.spawn(work)).collect();
        let mut found = work();
        for other in others {
            match other.join() {
                Ok(done) => found.extend(done),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        found
    });
    found.sort_by_key(|(harmonic, _)| *harmonic);
    found.into_iter().map(|(_, compliance)| compliance).collect()
}

/// Computes the volume change of each layer by unit tractions on each ring, mm3/MPa. Only harmonic 0 changes volumes.
///
/// # Errors
/// A body that is not held.
pub(crate) fn dilations(mesh: &Mesh, rings: &Rings) -> Result<Vec<Vec<f64>>, ElasticError> {
    let assembly = Assembly::new(mesh, 0)?;
    let solver = assembly.factorise(0)?;
    let shape = Shape::new();
    // By reciprocity one solution per layer suffices: the load is the layer's dilation by each displacement.
    let mut solution = RightHandSides::new(solver.unknowns.count, mesh.materials.len());
    for element in mesh.elements() {
        let nodes = mesh.element_nodes(element);
        for (i, dilation) in shape.dilation(&mesh.element_places(element)).into_iter().enumerate() {
            if let Some((row, sign)) = solver.unknowns.index_and_sign(nodes[i / 3], i % 3) {
                solution.column_mut(mesh.layer_by_row[element[1]])[row] += sign * dilation;
            }
        }
    }
    solver.solve(&mut solution);
    let per_radian = |layer: usize, component: usize, ring: usize| {
        let parts = rings.rings[ring].column_weights.iter().flat_map(|&(column, share)| {
            directions(mesh, column, component)
                .map(|(d, part)| (column * mesh.rows, d, share * part))
        });
        let terms = parts.map(|(node, direction, part)| {
            let (row, sign) = solver.unknowns.index_and_sign(node, direction)?;
            Some(part * sign * solution.column(layer)[row])
        });
        terms.flatten().sum::<f64>()
    };
    let whole = 2.0 * std::f64::consts::PI;
    Ok((0..mesh.materials.len())
        .map(|layer| {
            let loads = (0..3).flat_map(|c| (0..rings.rings.len()).map(move |ring| (c, ring)));
            loads.map(|(c, ring)| whole * per_radian(layer, c, ring)).collect()
        })
        .collect())
}
