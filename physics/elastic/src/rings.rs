//! The touched surface as rings of nodes about the axis.
//!
//! Each column of the mesh is a ring. The number of its nodes keeps their spacing close to the spacing along the
//! meridian: few near the axis, since a smooth field has few harmonics there. Counts are odd, so that N nodes and their
//! (N - 1) / 2 harmonics carry the same information.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::Arc;

use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};

use crate::element::{gauss, quadratic, quadratic_slope};
use crate::mesh::Mesh;

/// One ring of nodes.
#[derive(Clone, Debug)]
pub(crate) struct Ring {
    /// Number of nodes; odd. Node j is at the azimuth `2 pi j / count`.
    pub count: usize,
    /// Highest harmonic: `(count - 1) / 2`, but 1 on the axis, where harmonic 1 is a sideways motion.
    pub harmonics: usize,
    /// Index of the ring's first node among all nodes.
    pub first: usize,
    /// Integral over s of the ring's hat function times radius, mm2: the ring's area per radian.
    pub weight: f64,
    /// Mesh columns whose displacement enters the ring's mean, with their weights; the weights add up to `weight`.
    pub column_weights: Vec<(usize, f64)>,
}

/// All rings that can be pressed, from the pole outwards.
#[derive(Clone)]
pub(crate) struct Rings {
    pub rings: Vec<Ring>,
    pub nodes: usize,
    /// Forward and inverse transform by length.
    plans: BTreeMap<usize, [Arc<dyn Fft<f64>>; 2]>,
}

impl std::fmt::Debug for Rings {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} rings of {} nodes", self.rings.len(), self.nodes)
    }
}

/// Buffers of a Fourier transform, reused.
#[derive(Default)]
pub(crate) struct Buffers {
    line: Vec<Complex<f64>>,
    work: Vec<Complex<f64>>,
}

impl Rings {
    /// Chooses the number of nodes of each ring and prepares the transforms. Rings end at the first fixed column.
    pub fn new(mesh: &Mesh, max_harmonic: usize) -> Self {
        let free =
            (0..mesh.columns).take_while(|column| !mesh.is_fixed[column * mesh.rows]).count();
        let shares = compute_column_weights(mesh);
        let (mut rings, mut nodes, mut most) = (Vec::with_capacity(free), 0, 0);
        for (column, shares) in shares.into_iter().take(free).enumerate() {
            let (harmonics, count) = match (column, max_harmonic) {
                (_, 0) => (0, 1),
                (0, _) => (1, 1),
                _ => {
                    let spacing_mm = spacing(mesh, column);
                    let around_mm = 2.0 * PI * mesh.nodes[column * mesh.rows][0];
                    let wanted = odd_and_smooth((around_mm / spacing_mm).ceil() as usize);
                    // Counts never decrease outwards, so the rings that carry a harmonic are all those from some ring
                    // on.
                    // Two nodes per wave resolve a harmonic.
                    let harmonics = ((wanted - 1) / 2).min(max_harmonic).max(most).max(1);
                    most = harmonics;
                    (harmonics, 2 * harmonics + 1)
                }
            };
            let weight = shares.iter().map(|(_, share)| share).sum();
            rings.push(Ring { count, harmonics, first: nodes, weight, column_weights: shares });
            nodes += count;
        }
        let mut planner = FftPlanner::new();
        let lengths = rings.iter().map(|ring| ring.count);
        let mut plans = BTreeMap::new();
        for length in lengths {
            plans.entry(length).or_insert_with(|| {
                [planner.plan_fft_forward(length), planner.plan_fft_inverse(length)]
            });
        }
        Self { rings, nodes, plans }
    }

    /// Highest harmonic of any ring.
    pub fn harmonics(&self) -> usize {
        self.rings.iter().map(|ring| ring.harmonics).max().unwrap_or(0)
    }

    /// Returns the first ring that carries a harmonic; all rings further out carry it too.
    pub fn first_with(&self, harmonic: usize) -> usize {
        self.rings.iter().position(|ring| ring.harmonics >= harmonic).unwrap_or(self.rings.len())
    }

    /// Area that a node of a ring stands for, mm2.
    pub fn area_mm2(&self, ring: usize) -> f64 {
        self.rings[ring].weight * 2.0 * PI / self.rings[ring].count as f64
    }

    pub fn azimuth(&self, ring: usize, node: usize) -> f64 {
        2.0 * PI * node as f64 / self.rings[ring].count as f64
    }

    /// Transforms values around a ring to amplitudes, `f = Re sum F_m exp(i m phi)`, and passes each m and amplitude to
    /// `put`.
    pub fn analyse(
        &self,
        ring: usize,
        values: &[f64],
        buffers: &mut Buffers,
        mut put: impl FnMut(usize, Complex<f64>),
    ) {
        let count = self.rings[ring].count;
        if count == 1 {
            put(0, Complex::new(values[0], 0.0));
            return;
        }
        buffers.line.clear();
        buffers.line.extend(values.iter().map(|&value| Complex::new(value, 0.0)));
        self.transform(count, 0, buffers);
        let scale = 1.0 / count as f64;
        put(0, Complex::new(buffers.line[0].re * scale, 0.0));
        for m in 1..=count / 2 {
            // Twice, for the negative frequencies, which are not stored.
            put(m, buffers.line[m] * (2.0 * scale));
        }
    }

    /// Transforms amplitudes to values around a ring. `get` is called for each harmonic that the ring carries.
    pub fn synthesise(
        &self,
        ring: usize,
        values: &mut [f64],
        buffers: &mut Buffers,
        mut get: impl FnMut(usize) -> Complex<f64>,
    ) {
        let count = self.rings[ring].count;
        if count == 1 {
            values[0] = get(0).re;
            return;
        }
        buffers.line.clear();
        buffers.line.resize(count, Complex::new(0.0, 0.0));
        buffers.line[0] = Complex::new(get(0).re, 0.0);
        for m in 1..=count / 2 {
            buffers.line[m] = get(m);
        }
        self.transform(count, 1, buffers);
        for (value, line) in values.iter_mut().zip(&buffers.line) {
            *value = line.re;
        }
    }

    /// Transforms `buffers.line` in place: forwards for direction 0, backwards for 1, both without scaling.
    fn transform(&self, count: usize, direction: usize, buffers: &mut Buffers) {
        if let Some(plan) = self.plans.get(&count) {
            let needed = plan[direction].get_inplace_scratch_len();
            if buffers.work.len() < needed {
                buffers.work.resize(needed, Complex::new(0.0, 0.0));
            }
            plan[direction].process_with_scratch(&mut buffers.line, &mut buffers.work[..needed]);
        }
    }
}

/// Mean distance of a column to both neighbours along the meridian, mm.
fn spacing(mesh: &Mesh, column: usize) -> f64 {
    let place = |column: usize| mesh.nodes[column * mesh.rows];
    let (before, after) = (place(column - 1), place((column + 1).min(mesh.columns - 1)));
    let steps = if column + 1 < mesh.columns { 2.0 } else { 1.0 };
    (after[0] - before[0]).hypot(after[1] - before[1]) / steps
}

/// Returns the next number without prime factors other than 3, 5 and 7, for which the Fourier transform is fast.
fn odd_and_smooth(at_least: usize) -> usize {
    let is_smooth = |n: &usize| {
        let mut rest = *n;
        for factor in [3, 5, 7] {
            while rest.is_multiple_of(factor) {
                rest /= factor;
            }
        }
        rest == 1
    };
    (at_least.max(3)..).find(is_smooth).unwrap_or(at_least)
}

/// Integrates, for each column's hat function over s, its product with the quadratic functions of all columns and with
/// the radius.
///
/// Pressures are linear between neighbouring columns; displacements are quadratic over two columns' spacing.
fn compute_column_weights(mesh: &Mesh) -> Vec<Vec<(usize, f64)>> {
    let mut shares: Vec<BTreeMap<usize, f64>> = vec![BTreeMap::new(); mesh.columns];
    for element in 0..mesh.columns / 2 {
        let columns: [usize; 3] = std::array::from_fn(|i| 2 * element + i);
        let places = columns.map(|column| mesh.nodes[column * mesh.rows]);
        // Each half of an element is integrated by itself, since hat functions have a kink at the middle column.
        for half in 0..2 {
            for [position, weight] in gauss() {
                // Half 0 covers x from -1 to 0, half 1 covers 0 to 1.
                let along = 0.5 * (position + 1.0);
                let x = along - 1.0 + half as f64;
                let (values, slopes) = (quadratic(x), quadratic_slope(x));
                let sum =
                    |by: &[f64; 3], k: usize| (0..3).map(|i| by[i] * places[i][k]).sum::<f64>();
                let length = 0.5 * weight * sum(&slopes, 0).hypot(sum(&slopes, 1));
                let area = length * sum(&values, 0);
                for (hat, hat_value) in [(half, 1.0 - along), (half + 1, along)] {
                    for (i, value) in values.iter().enumerate() {
                        *shares[columns[hat]].entry(columns[i]).or_default() +=
                            area * hat_value * value;
                    }
                }
            }
        }
    }
    shares.into_iter().map(|by_column| by_column.into_iter().collect()).collect()
}
