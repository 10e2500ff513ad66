//! What tractions on rings do: of each harmonic, two dense matrices.
//!
//! For a body of revolution the map from tractions on the touched surface to displacements is block-circulant
//! in the azimuth; each harmonic has its own blocks, and none feels another. Only what a press can load is solved
//! for: a ring that nothing touches costs nothing, nor do drags without friction.

use std::ops::Range;

use fabkit_sparse::RightSides;

use crate::ElasticError;
use crate::element::Shape;
use crate::harmonic::Assembly;
use crate::mesh::Mesh;
use crate::rings::Rings;

/// The most memory that matrices may take, MiB.
const LIMIT_MIB: usize = 3000;

/// Components of tractions and displacements on the touched surface.
pub(crate) const NORMAL: usize = 0;
/// Along s.
pub(crate) const ALONG: usize = 1;
/// Around the axis: amplitudes are those of the sine, `i` times those of the values.
pub(crate) const AROUND: usize = 2;

/// Rings that are solved for in one go, whatever else is asked for: so the same traction has the same answer, to the
/// last bit, in every stack of a body.
const TOGETHER: usize = 8;

/// Tractions to be answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Loads {
    /// Of these rings: whole groups of [`TOGETHER`].
    rings: Range<usize>,
    /// 1 for pressures alone, 3 with what drags.
    components: usize,
}

impl Loads {
    /// Of rings of a surface that has `count`.
    pub fn new(rings: &Range<usize>, is_dragged: bool, count: usize) -> Self {
        let start = rings.start / TOGETHER * TOGETHER;
        let end = rings.end.next_multiple_of(TOGETHER).min(count);
        Self { rings: start..end, components: if is_dragged { 3 } else { 1 } }
    }

    /// Whether these are among them.
    pub fn hold(&self, others: &Self) -> bool {
        self.components >= others.components
            && self.rings.start <= others.rings.start
            && self.rings.end >= others.rings.end
    }

    /// Both, and what lies between them.
    pub fn and(&self, others: &Self) -> Self {
        let start = self.rings.start.min(others.rings.start);
        Self {
            rings: start..self.rings.end.max(others.rings.end),
            components: self.components.max(others.components),
        }
    }

    /// The highest harmonic of any of their rings: that of the outermost.
    fn harmonics(&self, rings: &Rings) -> usize {
        rings.rings[self.rings.end - 1].harmonics
    }

    /// Those of its rings that know a harmonic.
    fn with(&self, rings: &Rings, harmonic: usize) -> Range<usize> {
        rings.first_with(harmonic).max(self.rings.start)..self.rings.end
    }
}

/// The matrices of one harmonic.
#[derive(Clone, Debug)]
pub(crate) struct Compliance {
    /// The first ring that is loaded and knows the harmonic.
    pub first: usize,
    /// How many there are.
    pub rings: usize,
    /// 1 for pressures alone, 3 with what drags.
    pub components: usize,
    /// Tractions to mean displacements of rings, mm/MPa: square, column after column, each component's rings
    /// together. Weighted by the rings' weights it is symmetric (Betti's reciprocity).
    pub contact: Vec<f64>,
    /// Tractions to displacements of the nodes of interfaces that move, mm/MPa: column after column;
    /// interface after interface, column of the mesh after column; radial, around, axial.
    pub field: Vec<f64>,
}

impl Compliance {
    /// Solves a harmonic for tractions of one on each ring.
    ///
    /// # Errors
    /// A body that nothing holds.
    pub fn new(
        assembly: &Assembly<'_>,
        mesh: &Mesh,
        rings: &Rings,
        harmonic: usize,
        loads: &Loads,
    ) -> Result<Self, ElasticError> {
        let solver = assembly.harmonic(harmonic)?;
        let loaded = loads.with(rings, harmonic);
        let (count, components) = (loaded.len(), loads.components);
        let mut contact = Vec::with_capacity((components * count).pow(2));
        let mut field = Vec::with_capacity(components * count * field_rows(mesh));
        let mut solution = RightSides::new(solver.unknowns.count, TOGETHER);
        for component in 0..components {
            let mut begin = loaded.start;
            while begin < loaded.end {
                let group = begin..(begin + 1).next_multiple_of(TOGETHER).min(loaded.end);
                solution.clear();
                for (load, ring) in group.clone().enumerate() {
                    let side = solution.column_mut(load);
                    for &(column, share) in &rings.rings[ring].shares {
                        for (direction, part) in directions(mesh, column, component) {
                            let unknown = solver.unknowns.of(column * mesh.rows, direction);
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
                        let unknown = solver.unknowns.of(node, direction);
                        unknown.map_or(0.0, |(row, sign)| sign * solved[row])
                    };
                    for moved in 0..components {
                        contact.extend(rings.rings[loaded.clone()].iter().map(|ring| {
                            let shares = ring.shares.iter().map(|&(column, share)| {
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

/// Numbers in a column of [`Compliance::field`].
pub(crate) fn field_rows(mesh: &Mesh) -> usize {
    3 * mesh.moving_interfaces() * mesh.columns
}

/// A component on the touched surface as parts of radial (0), around (1) and axial (2).
pub(crate) fn directions(mesh: &Mesh, column: usize, component: usize) -> [(usize, f64); 2] {
    let frame = &mesh.frames[column];
    match component {
        NORMAL => [(0, frame.normal[0]), (2, frame.normal[1])],
        ALONG => [(0, frame.tangent[0]), (2, frame.tangent[1])],
        _ => [(1, 1.0), (1, 0.0)],
    }
}

/// # Errors
/// Matrices that take more memory than [`LIMIT_MIB`].
fn check_size(mesh: &Mesh, rings: &Rings, loads: &Loads) -> Result<(), ElasticError> {
    let harmonics = loads.harmonics(rings);
    let numbers: usize = (0..=harmonics)
        .map(|harmonic| {
            let loads = loads.components * loads.with(rings, harmonic).len();
            loads * (loads + field_rows(mesh))
        })
        .sum();
    let needed_mib = numbers * size_of::<f64>() / (1 << 20);
    match needed_mib > LIMIT_MIB {
        true => Err(ElasticError::TooLarge {
            harmonics: harmonics + 1,
            rings: loads.rings.len(),
            needed_mib,
            limit_mib: LIMIT_MIB,
        }),
        false => Ok(()),
    }
}

/// All harmonics of what is loaded, shared out to threads; each is the work of one thread, so that bytes do not depend
/// on how many there are.
///
/// # Errors
/// More memory than there may be; the first harmonic, by its number, that cannot be factorised.
pub(crate) fn all(
    mesh: &Mesh,
    rings: &Rings,
    loads: &Loads,
    threads: usize,
) -> Result<Vec<Compliance>, ElasticError> {
    check_size(mesh, rings, loads)?;
    let count = loads.harmonics(rings) + 1;
    let assembly = Assembly::new(mesh, count - 1)?;
    let threads = threads.clamp(1, count);
    let next = std::sync::atomic::AtomicUsize::new(0);
    let work = || {
        let mut done = Vec::new();
        loop {
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

/// What each layer's volume gains by a traction of one on each ring, mm3/MPa: layer after layer, of the
/// harmonic 0 alone, the others gain none.
///
/// # Errors
/// A body that nothing holds.
pub(crate) fn dilations(mesh: &Mesh, rings: &Rings) -> Result<Vec<Vec<f64>>, ElasticError> {
    let assembly = Assembly::new(mesh, 0)?;
    let solver = assembly.harmonic(0)?;
    let shape = Shape::new();
    // By reciprocity one solution for each layer is enough: the load is what the layer's volume feels.
    let mut solution = RightSides::new(solver.unknowns.count, mesh.materials.len());
    for element in mesh.elements() {
        let nodes = mesh.element_nodes(element);
        for (i, dilation) in shape.dilation(&mesh.element_places(element)).into_iter().enumerate() {
            if let Some((row, sign)) = solver.unknowns.of(nodes[i / 3], i % 3) {
                solution.column_mut(mesh.layer_of[element[1]])[row] += sign * dilation;
            }
        }
    }
    solver.solve(&mut solution);
    let per_radian = |layer: usize, component: usize, ring: usize| {
        let parts = rings.rings[ring].shares.iter().flat_map(|&(column, share)| {
            directions(mesh, column, component)
                .map(|(d, part)| (column * mesh.rows, d, share * part))
        });
        let terms = parts.map(|(node, direction, part)| {
            let (row, sign) = solver.unknowns.of(node, direction)?;
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
