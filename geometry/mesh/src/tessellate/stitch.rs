//! Triangles between two rings of points around one axis.

/// Distribution of a ring's points around the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RingPoints {
    /// Number of points; 1 for a pole.
    pub count: usize,
    /// True if the ring is rotated by half a step.
    pub staggered: bool,
}

impl RingPoints {
    pub fn pole() -> Self {
        Self { count: 1, staggered: false }
    }

    /// Returns the azimuth of point `k` as numerator and denominator of a fraction of a turn.
    pub fn fraction(&self, k: usize) -> (usize, usize) {
        (2 * k + usize::from(self.staggered), 2 * self.count)
    }

    /// Computes cosine and sine of the azimuth of point `k`.
    pub fn direction(&self, k: usize) -> [f64; 2] {
        let (numerator, denominator) = self.fraction(k);
        super::circle::cos_sin_of_turn(numerator, denominator)
    }
}

/// Triangle of two neighbours on one ring and one point on the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum StripTriangle {
    /// Points `a`, `a + 1` of the lower ring and `b` of the upper.
    Lower { a: usize, b: usize },
    /// Point `a` of the lower ring and `b`, `b + 1` of the upper.
    Upper { a: usize, b: usize },
}

/// Emits all triangles between two rings, always with the diagonal that spans the smaller azimuth. Indices run up to
/// and including the counts: the caller wraps them.
pub(crate) fn stitch(lower: RingPoints, upper: RingPoints, mut emit: impl FnMut(StripTriangle)) {
    let repeats = repeats(lower, upper);
    let (part_a, part_b) = (steps(lower) / repeats, steps(upper) / repeats);
    for part in 0..repeats {
        stitch_sector(lower, upper, |strip| {
            emit(match strip {
                StripTriangle::Lower { a, b } => {
                    StripTriangle::Lower { a: a + part * part_a, b: b + part * part_b }
                }
                StripTriangle::Upper { a, b } => {
                    StripTriangle::Upper { a: a + part * part_a, b: b + part * part_b }
                }
            });
        });
    }
}

/// Emits the triangles of the first repeating sector between two rings.
///
/// No triangle is wider than one step of the coarser ring.
pub(super) fn stitch_sector(
    lower: RingPoints,
    upper: RingPoints,
    mut emit: impl FnMut(StripTriangle),
) {
    let repeats = repeats(lower, upper);
    let (steps_a, steps_b) = (steps(lower) / repeats, steps(upper) / repeats);
    // Azimuths over the common denominator, as integers: ties are ties on every machine.
    let (na, nb) = (lower.count as i64, upper.count as i64);
    let azimuth_a = |k: usize| (2 * k as i64 + i64::from(lower.staggered)) * nb;
    let azimuth_b = |k: usize| (2 * k as i64 + i64::from(upper.staggered)) * na;
    let (mut a, mut b) = (0, 0);
    while a < steps_a || b < steps_b {
        // Angular width of the diagonal after an advance on either ring.
        let advance_a = (azimuth_a(a + 1) - azimuth_b(b)).abs();
        let advance_b = (azimuth_b(b + 1) - azimuth_a(a)).abs();
        if b == steps_b || (a < steps_a && advance_a <= advance_b) {
            emit(StripTriangle::Lower { a, b });
            a += 1;
        } else {
            emit(StripTriangle::Upper { a, b });
            b += 1;
        }
    }
}

/// Returns the number of equal sectors of a turn in which the pattern between two rings repeats.
fn repeats(lower: RingPoints, upper: RingPoints) -> usize {
    let (a, b) = (steps(lower), steps(upper));
    if a == 0 || b == 0 { a.max(b) } else { gcd(a, b) }
}

fn steps(spread: RingPoints) -> usize {
    if spread.count == 1 { 0 } else { spread.count }
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}
