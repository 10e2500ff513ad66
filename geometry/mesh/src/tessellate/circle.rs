//! Number and positions of points on circles.

use std::cmp::Ordering;

/// Smallest number of points on a full circle, whatever the tolerance.
const MIN_RING: usize = 8;

/// Fraction of the tolerance that the chords of a shared ring may use up.
///
/// A ring at a profile's vertex is shared by the faces on both sides. If its chords took the whole tolerance, no
/// triangle of an adjoining doubly curved face could use them as an edge.
const RING_SHARE: f64 = 0.8;

/// Radius, in tolerances, below which a feature counts as small; such features come by the hundred.
const SMALL: f64 = 100.0;

/// Fraction of the tolerance for small features: chords lie inside their circle, so that the holes of a part all come
/// out too small, and their errors add up.
const SMALL_SHARE: f64 = 0.75;

/// Returns the tolerance to use for a surface of this radius, mm.
pub(super) fn tolerance_for(radius_mm: f64, tolerance_mm: f64) -> f64 {
    if radius_mm < SMALL * tolerance_mm { SMALL_SHARE * tolerance_mm } else { tolerance_mm }
}

/// Returns the number of chords that keep a full circle within `sagitta_mm`, as a real number, at least 3.
pub(super) fn chords_per_turn(radius_mm: f64, sagitta_mm: f64) -> f64 {
    // Half the chord's angle is acos(1 - s/r); as an arcsine it keeps its digits for small s/r.
    let sine = (sagitta_mm / (2.0 * radius_mm)).sqrt();
    if sine >= 0.5 { 3.0 } else { std::f64::consts::PI / (2.0 * sine.asin()) }
}

/// Returns the number of points on a ring that two faces may share: it depends only on radius and tolerance.
///
/// A multiple of 4, so that the extreme points along x and y are included.
pub(super) fn ring_count(radius_mm: f64, tolerance_mm: f64) -> usize {
    let sagitta_mm = RING_SHARE * tolerance_for(radius_mm, tolerance_mm);
    let chords = chords_per_turn(radius_mm, sagitta_mm);
    // The small offset keeps an exact integer from being rounded up.
    MIN_RING.max(4 * ((chords / 4.0 - 1e-9).ceil() as usize))
}

/// Returns the number of chords for an arc of `angle_rad`, as dense as [`ring_count`] so that it agrees with full
/// circles.
pub(super) fn arc_count(radius_mm: f64, angle_rad: f64, tolerance_mm: f64) -> usize {
    let turns = angle_rad / std::f64::consts::TAU;
    let chords = ring_count(radius_mm, tolerance_mm) as f64 * turns;
    1.max((chords - 1e-9).ceil() as usize)
}

/// Computes cosine and sine of `numerator / denominator` of a full turn.
///
/// Exact at quarter turns, and exactly symmetric between the eight octants.
pub(crate) fn cos_sin_of_turn(numerator: usize, denominator: usize) -> [f64; 2] {
    let quarters = 4 * (numerator % denominator);
    let (quadrant, rest) = (quarters / denominator, quarters % denominator);
    let angle = |part: usize| std::f64::consts::FRAC_PI_2 * part as f64 / denominator as f64;
    let [c, s] = match (2 * rest).cmp(&denominator) {
        Ordering::Less => {
            let (s, c) = angle(rest).sin_cos();
            [c, s]
        }
        Ordering::Equal => [std::f64::consts::FRAC_1_SQRT_2; 2],
        Ordering::Greater => angle(denominator - rest).sin_cos().into(),
    };
    match quadrant {
        0 => [c, s],
        1 => [-s, c],
        2 => [-c, -s],
        _ => [s, -c],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarter_turns_are_exact_and_octants_are_mirrored() {
        for n in [8, 12, 100, 128] {
            assert_eq!(cos_sin_of_turn(0, n), [1.0, 0.0]);
            assert_eq!(cos_sin_of_turn(n / 4, n).map(f64::abs), [0.0, 1.0]);
            for k in 1..n / 4 {
                let ([c, s], [c2, s2]) = (cos_sin_of_turn(k, n), cos_sin_of_turn(n / 4 - k, n));
                assert_eq!((c, s), (s2, c2));
                assert!((c * c + s * s - 1.0).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn the_sagitta_of_a_ring_stays_below_the_tolerance() {
        for (radius, tolerance) in [(0.05, 0.1), (0.5, 0.01), (15.0, 0.01), (500.0, 1e-4)] {
            let n = ring_count(radius, tolerance) as f64;
            let sagitta = |n: f64| radius * (1.0 - (std::f64::consts::PI / n).cos());
            let most = RING_SHARE * tolerance_for(radius, tolerance);
            assert!(sagitta(n) <= most * (1.0 + 1e-9));
            assert!(n == 8.0 || sagitta(n - 4.0) > most);
        }
    }
}
