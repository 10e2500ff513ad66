//! Table of an interface's displacements for fast evaluation at millions of points.

use std::f64::consts::TAU;

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

use crate::outcome::PressOutcome;
use crate::stack::ElasticStack;

/// Table columns per wave of the highest harmonic. The cubic interpolation is then off by less than 1 % of that
/// harmonic, which is the smallest.
const COLUMNS_PER_WAVE: usize = 4;
/// Maximum number of table rows along the meridian.
const MAX_ALONG: usize = 1024;

/// Columns that are stored twice, so that any four neighbours lie contiguously in memory.
const DUPLICATED_COLUMNS: usize = 3;

/// Displacement of an interface over s along its meridian and the azimuth, interpolated bicubically from a table.
///
/// ```
/// use std::f64::consts::PI;
/// use fabkit_elastic::{BallIndenter, LayeredBody, MeshDensity, DisplacementField, ElasticLayer, ElasticMaterial, Press, ElasticStack};
/// use fabkit_geometry::{Point3, Vector3};
///
/// // A pad of 2 mm, pressed 1 mm beside its middle.
/// let gel = ElasticLayer { name: "gel".to_owned(), material: ElasticMaterial::new(0.2, 0.49)? };
/// let pad = LayeredBody::pad(20.0, vec![(gel, 2.0)]);
/// let stack = ElasticStack::new(&pad, &MeshDensity::around_pole(0.2, 4.0, 24), 1)?;
/// let ball = BallIndenter::new(Point3::new(1.0, 0.0, 9.0), 4.0)?;
/// let outcome = stack.press(&ball, &Press::along(-Vector3::z(), 0.3)?)?;
/// let field = DisplacementField::new(&stack, &outcome, 0);
/// // The deepest place follows the ball; the other side of the axis rises.
/// let s = 1.0 / 20.0;
/// assert!((field.outwards_mm(s, 0.0) + 0.3).abs() < 0.01);
/// assert!(field.outwards_mm(3.0 * s, PI) > 0.0);
/// # Ok::<(), fabkit_elastic::ElasticError>(())
/// ```
#[derive(Clone, Debug)]
pub struct DisplacementField {
    /// Index of the last row.
    along: usize,
    /// Number of distinct columns.
    around: usize,
    /// Values row by row: out of the body along the touched surface's normal, away from the pole along its meridian,
    /// and counter-clockwise around the axis. Each row begins with its last column and ends with its first two.
    parts: [Vec<f64>; 3],
    rings: Vec<RingPressures>,
}

/// Contact pressures at a ring of nodes.
#[derive(Clone, Debug)]
struct RingPressures {
    s: f64,
    pressures_mpa: Vec<f64>,
}

impl DisplacementField {
    /// Tabulates an interface of a pressed stack; 0 is the touched surface. Interfaces that cannot move yield zeros.
    pub fn new(stack: &ElasticStack, outcome: &PressOutcome, interface: usize) -> Self {
        let mesh = &stack.mesh;
        let nearest = mesh.s.windows(2).map(|pair| pair[1] - pair[0]).fold(1.0, f64::min);
        // The finest spacing of mesh columns determines the number of rows.
        let along = ((1.0 / nearest).ceil() as usize).clamp(16, MAX_ALONG);
        let harmonics = outcome.amplitudes.len();
        // Even, so that the point behind the pole lies exactly half of the columns away.
        let around = (COLUMNS_PER_WAVE * harmonics).max(8);
        let width = around + DUPLICATED_COLUMNS;
        let mut parts = [(); 3].map(|()| vec![0.0; (along + 1) * width]);
        if interface < mesh.moving_interfaces() {
            let plan = FftPlanner::new().plan_fft_inverse(around);
            let mut work = vec![Complex::default(); plan.get_inplace_scratch_len()];
            let mut line = vec![Complex::default(); around];
            for row in 0..=along {
                let (column, values) = mesh.interpolation(row as f64 / along as f64);
                // Interpolated normal or tangent, normalised again.
                let frame = |part: fn(&crate::mesh::Frame) -> [f64; 2]| {
                    let sums = [0, 1].map(|k| {
                        let each = values.iter().enumerate();
                        each.map(|(i, value)| value * part(&mesh.frames[column + i])[k])
                            .sum::<f64>()
                    });
                    let length = sums[0].hypot(sums[1]);
                    sums.map(|part| part / length)
                };
                let (normal, tangent) = (frame(|frame| frame.normal), frame(|frame| frame.tangent));
                let at = |amplitudes: &[Complex<f64>], k: usize| {
                    let each = values.iter().enumerate();
                    each.map(|(i, value)| {
                        amplitudes[3 * (interface * mesh.columns + column + i) + k] * value
                    })
                    .sum::<Complex<f64>>()
                };
                for (k, part) in parts.iter_mut().enumerate() {
                    line.fill(Complex::default());
                    for (harmonic, amplitudes) in outcome.amplitudes.iter().enumerate() {
                        // Inverse transform of the one-sided series: the real part is the field.
                        line[harmonic] = match k {
                            0 => normal[0] * at(amplitudes, 0) + normal[1] * at(amplitudes, 2),
                            1 => tangent[0] * at(amplitudes, 0) + tangent[1] * at(amplitudes, 2),
                            // Circumferential amplitudes belong to the sine; see `AROUND` in `compliance`.
                            _ => Complex::new(0.0, -1.0) * at(amplitudes, 1),
                        };
                    }
                    plan.process_with_scratch(&mut line, &mut work);
                    let row = &mut part[row * width..(row + 1) * width];
                    for (i, to) in row.iter_mut().enumerate() {
                        // Shifted by one, so that the cubic's first neighbour of column 0 is stored before it.
                        *to = line[(i + around - 1) % around].re;
                    }
                }
            }
        }
        let rings = stack.rings.rings.iter().zip(&mesh.s).map(|(ring, s)| RingPressures {
            s: *s,
            pressures_mpa: outcome.nodes[ring.first..ring.first + ring.count]
                .iter()
                .map(|node| node.pressure_mpa)
                .collect(),
        });
        Self { along, around, parts, rings: rings.collect() }
    }

    /// Returns the displacement out of the body along the touched surface's normal, mm; 0 beyond the rim.
    #[inline]
    pub fn outwards_mm(&self, s: f64, azimuth: f64) -> f64 {
        self.at(0, s, azimuth)
    }

    /// Returns the displacements along the touched surface, away from the pole and around the axis, mm.
    ///
    /// ```
    /// use fabkit_elastic::{BallIndenter, DisplacementField, ElasticLayer, ElasticMaterial, ElasticStack};
    /// use fabkit_elastic::{LayeredBody, MeshDensity, Press};
    /// use fabkit_geometry::{Point3, Vector3};
    ///
    /// // A ball on the axis: beside it the gel moves away from the axis, and nowhere around it.
    /// let gel = ElasticLayer { name: "gel".to_owned(), material: ElasticMaterial::new(0.2, 0.49)? };
    /// let pad = LayeredBody::pad(10.0, vec![(gel, 2.0)]);
    /// let stack = ElasticStack::new(&pad, &MeshDensity::around_pole(0.1, 3.0, 0), 1)?;
    /// let ball = BallIndenter::new(Point3::new(0.0, 0.0, 9.0), 3.0)?;
    /// let outcome = stack.press(&ball, &Press::along(-Vector3::z(), 0.3)?)?;
    /// let [along_mm, around_mm] = DisplacementField::new(&stack, &outcome, 0).sideways_mm(0.2, 1.0);
    /// assert!(along_mm > 0.0 && around_mm.abs() < 1e-12);
    /// # Ok::<(), fabkit_elastic::ElasticError>(())
    /// ```
    pub fn sideways_mm(&self, s: f64, azimuth: f64) -> [f64; 2] {
        [self.at(1, s, azimuth), self.at(2, s, azimuth)]
    }

    /// Returns the contact pressure at the nearest node of the touched surface, MPa; 0 beyond the rim.
    ///
    /// ```
    /// use fabkit_elastic::{BallIndenter, DisplacementField, ElasticLayer, ElasticMaterial, ElasticStack};
    /// use fabkit_elastic::{LayeredBody, MeshDensity, Press};
    /// use fabkit_geometry::{Point3, Vector3};
    ///
    /// // Largest below the ball, none beside it; s = 1 is the pad's rim at 10 mm.
    /// let gel = ElasticLayer { name: "gel".to_owned(), material: ElasticMaterial::new(0.2, 0.49)? };
    /// let pad = LayeredBody::pad(10.0, vec![(gel, 2.0)]);
    /// let stack = ElasticStack::new(&pad, &MeshDensity::around_pole(0.1, 3.0, 0), 1)?;
    /// let ball = BallIndenter::new(Point3::new(0.0, 0.0, 9.0), 3.0)?;
    /// let outcome = stack.press(&ball, &Press::along(-Vector3::z(), 0.3)?)?;
    /// let field = DisplacementField::new(&stack, &outcome, 0);
    /// assert!(field.pressure_mpa(0.0, 0.0) > field.pressure_mpa(0.08, 0.0));
    /// assert!(field.pressure_mpa(0.08, 0.0) > 0.0 && field.pressure_mpa(0.5, 0.0) == 0.0);
    /// # Ok::<(), fabkit_elastic::ElasticError>(())
    /// ```
    pub fn pressure_mpa(&self, s: f64, azimuth: f64) -> f64 {
        let after = self.rings.partition_point(|ring| ring.s < s);
        let near = after.saturating_sub(1)..(after + 1).min(self.rings.len());
        let nearest = self.rings[near]
            .iter()
            .min_by(|a, b| (a.s - s).abs().total_cmp(&(b.s - s).abs()))
            .filter(|_| s <= 1.0);
        nearest.map_or(0.0, |ring| {
            let count = ring.pressures_mpa.len();
            let node = (azimuth.rem_euclid(TAU) / TAU * count as f64).round() as usize;
            ring.pressures_mpa[node % count]
        })
    }

    /// Interpolates one component at s and azimuth; 0 outside of s from 0 to 1.
    #[inline]
    fn at(&self, part: usize, s: f64, azimuth: f64) -> f64 {
        if !(0.0..=1.0).contains(&s) {
            return 0.0;
        }
        let row = s * self.along as f64;
        let turns = azimuth / TAU;
        // An azimuth a hair below a whole turn may round to one.
        let column = ((turns - floor(turns)) * self.around as f64).min(self.around as f64 - 1e-9);
        let (first_row, first_column) = (row as isize, column as usize);
        let by_row = catmull_rom_weights(row - first_row as f64);
        let by_column = catmull_rom_weights(column - first_column as f64);
        let width = self.around + DUPLICATED_COLUMNS;
        let mut sum = 0.0;
        for (i, by_row) in (-1..).zip(by_row) {
            let row = first_row + i;
            // Beyond the pole the opposite side continues, where tangential components point the other way.
            let (row, first, sign) = if row < 0 {
                let behind = (first_column + self.around / 2) % self.around;
                (-row, behind, if part == 0 { 1.0 } else { -1.0 })
            } else {
                (row.min(self.along as isize), first_column, 1.0)
            };
            let values = &self.parts[part][row as usize * width + first..][..4];
            let around: f64 =
                values.iter().zip(by_column).map(|(value, share)| value * share).sum();
            sum += sign * by_row * around;
        }
        sum
    }
}

/// Rounds down. `f64::floor` is a function call on processors that are not known to have an instruction for it.
#[inline]
fn floor(turns: f64) -> f64 {
    let whole = turns as i64 as f64;
    if whole > turns { whole - 1.0 } else { whole }
}

/// Weights of the four values around a point between the middle two (Catmull and Rom).
#[inline]
fn catmull_rom_weights(t: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [
        0.5 * (-t3 + 2.0 * t2 - t),
        0.5 * (3.0 * t3 - 5.0 * t2 + 2.0),
        0.5 * (-3.0 * t3 + 4.0 * t2 + t),
        0.5 * (t3 - t2),
    ]
}
