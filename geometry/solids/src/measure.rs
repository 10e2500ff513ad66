//! Volumes by integration along lines: the reference that meshes are compared with.

use nalgebra::{Point3, Vector3};

use crate::compiled::{Hit, Line, Span};
use crate::proofs::{ProjectionRaster, find_overlap_boxes};
use crate::sequences::SplitMix64;
use crate::{Aabb, CompiledSolid, Scratch};

/// Volume with its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeEstimate {
    /// Volume, mm^3.
    pub value_mm3: f64,
    /// Half width of the 99 % confidence interval, mm^3.
    pub error_mm3: f64,
}

/// Overlap of two bodies.
///
/// ```
/// use fabkit_geometry::{CompiledSolid, Solid, measure::overlap_volume};
/// let block = |z_mm| CompiledSolid::new(&Solid::cuboid(4.0, 4.0, 2.0).at_z(z_mm));
/// let pressed = overlap_volume(&block(0.0)?, &block(1.5)?, 20_000)?;
/// assert!((pressed.volume.value_mm3 - 4.0 * 4.0 * 0.5).abs() < 0.01);
/// assert!(pressed.witness.is_some_and(|point| (1.5..=2.0).contains(&point.z)));
/// // One on the other: they touch and share nothing.
/// let stacked = overlap_volume(&block(0.0)?, &block(2.0)?, 20_000)?;
/// assert_eq!((stacked.volume.value_mm3, stacked.witness), (0.0, None));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// Common volume, mm^3; exactly 0 for bodies that are apart or only touch.
    pub volume: VolumeEstimate,
    /// Midpoint of the longest common stretch found on the lines; `None` without overlap.
    pub witness: Option<Point3<f64>>,
}

/// Reason why a volume cannot be computed.
///
/// ```
/// use fabkit_geometry::measure::{MeasureError, ray_volume};
/// use fabkit_geometry::{CompiledSolid, Solid};
/// let table = Solid::below(0.0);
/// assert_eq!(ray_volume(&CompiledSolid::new(&table)?, 1000), Err(MeasureError::Unbounded));
/// let slab = table.and(Solid::cuboid_between([-1.0, -1.0, -2.0], [1.0, 1.0, 2.0]));
/// assert!((ray_volume(&CompiledSolid::new(&slab)?, 20_000)?.value_mm3 - 8.0).abs() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeasureError {
    /// Unbounded solid, such as a half-space.
    #[error("the solid has no finite bounds; its volume is not defined")]
    Unbounded,
}

/// Thickness across the touching faces below which a contact is treated as rounding, mm.
const CONTACT_MM: f64 = 1e-9;

/// Number of independent estimates from which the error is computed.
const SHIFTS: u32 = 8;

/// Student's t for 99 % confidence with `SHIFTS - 1` degrees of freedom.
const STUDENT_T: f64 = 3.499;

/// Computes the volume of a body from the lengths of about `lines` parallel lines inside it.
///
/// The lines pass the points of a Fibonacci lattice, which is shifted eight times at random (with a fixed seed); the
/// scatter of the eight results gives the error (Sloan and Joe, "Lattice Methods for Multiple Integration", 1994, and
/// Cranley and Patterson, SIAM J. Numer. Anal. 1976). They run askew to the axes, so that they never graze faces of
/// ordinary parts. The error falls with the number of lines; a hundred thousand give the volume of a part of ordinary
/// shape to about 1e-5.
///
/// ```
/// use fabkit_geometry::{CompiledSolid, Solid, measure::ray_volume};
/// let cube = CompiledSolid::new(&Solid::cuboid(2.0, 2.0, 2.0))?;
/// let volume = ray_volume(&cube, 20_000)?;
/// assert!((volume.value_mm3 - 8.0).abs() < 8e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`MeasureError::Unbounded`].
pub fn ray_volume(body: &CompiledSolid, lines: u32) -> Result<VolumeEstimate, MeasureError> {
    let mut scratch = Scratch::default();
    integrate(&body.bounds(), lines, None, |line| {
        body.spans(line, &mut scratch).iter().map(length).sum()
    })
}

/// Computes the common volume of two bodies in one frame, from about `lines` lines through the intersection of their
/// boxes.
///
/// Contact without overlap gives exactly 0: stretches thinner than 1e-9 mm, measured across the faces at their ends, do
/// not count. Lines that pass only where the bodies are proven not to overlap are skipped; they would add 0.
///
/// # Errors
/// [`MeasureError::Unbounded`] if the intersection of the bodies' boxes is unbounded.
pub fn overlap_volume(
    a: &CompiledSolid,
    b: &CompiledSolid,
    lines: u32,
) -> Result<Overlap, MeasureError> {
    let (mut in_a, mut in_b) = (Scratch::default(), Scratch::default());
    let mut longest_mm = 0.0;
    let mut witness = None;
    let common = a.bounds().common(&b.bounds());
    let boxes = find_overlap_boxes(a, b);
    let volume = integrate(&common, lines, boxes.as_deref(), |line| {
        let spans_a = a.spans(line, &mut in_a);
        let spans_b = if spans_a.is_empty() { &[] } else { b.spans(line, &mut in_b) };
        let mut total_mm = 0.0;
        for_each_common(spans_a, spans_b, |enter, exit| {
            let (t0, t1) = (enter.hit().t_mm, exit.hit().t_mm);
            // Rounding shifts a face across itself; along the line that shift is divided by the sine of the angle
            // between line and face.
            let skew = |end: &End| 1.0 / end.normal(a, b, line).dot(&line.direction).abs();
            if t1 - t0 > CONTACT_MM * (skew(&enter) + skew(&exit)) {
                total_mm += t1 - t0;
                if t1 - t0 > longest_mm {
                    longest_mm = t1 - t0;
                    witness = Some(line.origin + 0.5 * (t0 + t1) * line.direction);
                }
            }
        });
        total_mm
    })?;
    Ok(Overlap { volume, witness })
}

/// End of a common stretch, with the body whose surface it lies on.
enum End {
    OnA(Hit),
    OnB(Hit),
}

impl End {
    fn hit(&self) -> &Hit {
        match self {
            Self::OnA(hit) | Self::OnB(hit) => hit,
        }
    }

    fn normal(&self, a: &CompiledSolid, b: &CompiledSolid, line: &Line) -> Vector3<f64> {
        match self {
            Self::OnA(hit) => a.normal(line, hit, true),
            Self::OnB(hit) => b.normal(line, hit, true),
        }
    }
}

/// Visits the common stretches of two sorted lists.
fn for_each_common(a: &[Span], b: &[Span], mut visit: impl FnMut(End, End)) {
    let (mut i, mut j) = (0, 0);
    while i < a.len() && j < b.len() {
        let (x, y) = (a[i], b[j]);
        let enter =
            if x.enter.t_mm >= y.enter.t_mm { End::OnA(x.enter) } else { End::OnB(y.enter) };
        let a_ends_first = x.exit.t_mm <= y.exit.t_mm;
        let exit = if a_ends_first { End::OnA(x.exit) } else { End::OnB(y.exit) };
        if enter.hit().t_mm < exit.hit().t_mm {
            visit(enter, exit);
        }
        if a_ends_first {
            i += 1;
        } else {
            j += 1;
        }
    }
}

fn length(span: &Span) -> f64 {
    span.exit.t_mm - span.enter.t_mm
}

/// Integrates a function of parallel lines over the projection of a box. The function must be 0 on lines that pass none
/// of `boxes`.
fn integrate(
    bounds: &Aabb,
    lines: u32,
    boxes: Option<&[Aabb]>,
    mut length_mm: impl FnMut(&Line) -> f64,
) -> Result<VolumeEstimate, MeasureError> {
    if bounds.is_empty() {
        return Ok(VolumeEstimate { value_mm3: 0.0, error_mm3: 0.0 });
    }
    if !bounds.is_finite() {
        return Err(MeasureError::Unbounded);
    }
    // Askew to all usual faces of parts, yet near z to keep the projected area small.
    let direction = Vector3::new(0.1234, 0.0917, 1.0).normalize();
    let u = direction.cross(&Vector3::y()).normalize();
    let v = direction.cross(&u);
    let centre = bounds.centre();
    let half = 0.5 * (bounds.max - bounds.min);
    let shadow = |w: &Vector3<f64>| w.abs().dot(&half);
    let (half_u, half_v) = (shadow(&u), shadow(&v));
    // The bodies are proven not to overlap.
    if boxes.is_some_and(<[Aabb]>::is_empty) {
        return Ok(VolumeEstimate { value_mm3: 0.0, error_mm3: 0.0 });
    }
    let shadow =
        boxes.map(|boxes| ProjectionRaster::from_boxes(boxes, &centre, &[u, v], [half_u, half_v]));
    // Consecutive Fibonacci numbers give a good two-dimensional lattice.
    let (count, stride) = fibonacci(lines / SHIFTS);
    let mut volumes = [0.0; SHIFTS as usize];
    // Random shifts: shifts on a lattice would interfere with the lattice of lines.
    let mut random = SplitMix64::new(0);
    for volume in &mut volumes {
        let (shift_u, shift_v) = (random.unit(), random.unit());
        let mut sum_mm = 0.0;
        for i in 0..count {
            let x = (i as f64 / count as f64 + shift_u).fract();
            let y = ((i * stride % count) as f64 / count as f64 + shift_v).fract();
            if shadow.as_ref().is_some_and(|shadow| !shadow.may_meet_box([x, y])) {
                continue;
            }
            let offset = (2.0 * x - 1.0) * half_u * u + (2.0 * y - 1.0) * half_v * v;
            sum_mm += length_mm(&Line::new(centre + offset, direction));
        }
        // Mean length times the area of the projected rectangle.
        *volume = sum_mm / count as f64 * 4.0 * half_u * half_v;
    }
    let n = f64::from(SHIFTS);
    let value_mm3 = volumes.iter().sum::<f64>() / n;
    let variance = volumes.iter().map(|v| (v - value_mm3).powi(2)).sum::<f64>() / (n - 1.0);
    Ok(VolumeEstimate { value_mm3, error_mm3: STUDENT_T * (variance / n).sqrt() })
}

/// Returns the first Fibonacci number at or above `lines` (at least 13), and the one before it.
fn fibonacci(lines: u32) -> (u64, u64) {
    let (mut before, mut count) = (8u64, 13u64);
    while count < u64::from(lines) {
        (before, count) = (count, before + count);
    }
    (count, before)
}
