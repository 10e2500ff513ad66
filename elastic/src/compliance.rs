//! What tractions on rings do: of each harmonic, two dense matrices.
//!
//! For a body of revolution the map from tractions on the touched surface to displacements is block-circulant
//! in the azimuth; each harmonic has its own blocks, and none feels another.

use faer::Mat;

use crate::ElasticError;
use crate::element::Shape;
use crate::harmonic::Harmonic;
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

/// The matrices of one harmonic.
#[derive(Clone, Debug)]
pub(crate) struct Compliance {
    /// The first ring that knows the harmonic.
    pub first: usize,
    /// How many rings do.
    pub rings: usize,
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
    pub fn new(mesh: &Mesh, rings: &Rings, harmonic: usize) -> Result<Self, ElasticError> {
        let solver = Harmonic::new(mesh, harmonic)?;
        let first = rings.first_with(harmonic);
        let count = rings.rings.len() - first;
        let mut solution = Mat::zeros(solver.unknowns.count, 3 * count);
        for ring in 0..count {
            for &(column, share) in &rings.rings[first + ring].shares {
                let node = column * mesh.rows;
                for component in 0..3 {
                    for (direction, part) in directions(mesh, column, component) {
                        if let Some((row, sign)) = solver.unknowns.of(node, direction) {
                            solution[(row, component * count + ring)] += sign * share * part;
                        }
                    }
                }
            }
        }
        solver.solve(&mut solution);
        let value = |node: usize, direction: usize, load: usize| {
            solver
                .unknowns
                .of(node, direction)
                .map_or(0.0, |(row, sign)| sign * solution[(row, load)])
        };
        let mut contact = Vec::with_capacity(9 * count * count);
        let mut field = Vec::with_capacity(3 * count * field_rows(mesh));
        for load in 0..3 * count {
            for component in 0..3 {
                for ring in &rings.rings[first..] {
                    let moved = ring.shares.iter().map(|&(column, share)| {
                        let parts = directions(mesh, column, component);
                        let along =
                            |(d, part): (usize, f64)| part * value(column * mesh.rows, d, load);
                        share * parts.into_iter().map(along).sum::<f64>()
                    });
                    contact.push(moved.sum::<f64>() / ring.weight);
                }
            }
            for interface in 0..mesh.moving_interfaces() {
                for column in 0..mesh.columns {
                    let node = mesh.interface_node(interface, column);
                    field.extend((0..3).map(|direction| value(node, direction, load)));
                }
            }
        }
        Ok(Self { first, rings: count, contact, field })
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
pub(crate) fn check_size(mesh: &Mesh, rings: &Rings) -> Result<(), ElasticError> {
    let numbers: usize = (0..=rings.harmonics())
        .map(|harmonic| {
            let loads = 3 * (rings.rings.len() - rings.first_with(harmonic));
            loads * (loads + field_rows(mesh))
        })
        .sum();
    let needed_mib = numbers * size_of::<f64>() / (1 << 20);
    match needed_mib > LIMIT_MIB {
        true => Err(ElasticError::TooLarge {
            harmonics: rings.harmonics() + 1,
            rings: rings.rings.len(),
            needed_mib,
            limit_mib: LIMIT_MIB,
        }),
        false => Ok(()),
    }
}

/// All harmonics, shared out to threads; each is the work of one thread, so that bytes do not depend on how
/// many there are.
///
/// # Errors
/// The first harmonic, by its number, that cannot be factorised.
pub(crate) fn all(
    mesh: &Mesh,
    rings: &Rings,
    threads: usize,
) -> Result<Vec<Compliance>, ElasticError> {
    let count = rings.harmonics() + 1;
    let threads = threads.clamp(1, count);
    let next = std::sync::atomic::AtomicUsize::new(0);
    let work = || {
        let mut done = Vec::new();
        loop {
            let harmonic = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            if harmonic >= count {
                return done;
            }
            done.push((harmonic, Compliance::new(mesh, rings, harmonic)));
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
    let solver = Harmonic::new(mesh, 0)?;
    let shape = Shape::new();
    // By reciprocity one solution for each layer is enough: the load is what the layer's volume feels.
    let mut solution = Mat::zeros(solver.unknowns.count, mesh.materials.len());
    for element in mesh.elements() {
        let nodes = mesh.element_nodes(element);
        for (i, dilation) in shape.dilation(&mesh.element_places(element)).into_iter().enumerate() {
            if let Some((row, sign)) = solver.unknowns.of(nodes[i / 3], i % 3) {
                solution[(row, mesh.layer_of[element[1]])] += sign * dilation;
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
            Some(part * sign * solution[(row, layer)])
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
