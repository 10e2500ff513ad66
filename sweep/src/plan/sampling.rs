//! Points that fill a cube of many dimensions evenly.

/// Digits below this part of 1 change no `f64`.
const FINEST: f64 = 1.0 / (1u64 << 53) as f64;

/// The first 32 primes: one base for each axis.
const PRIMES: [u32; 32] = [
    2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61, 67, 71, 73, 79, 83, 89, 97,
    101, 103, 107, 109, 113, 127, 131,
];

/// Most dimensions.
pub const MAX_DIMENSIONS: usize = PRIMES.len();

/// The `index`-th point of a scrambled Halton sequence, each coordinate in [0, 1).
///
/// Halton's radical inverses (Numer. Math. 2, 1960) with the digits of each place permuted at random,
/// but always alike for a seed (Owen, "A randomized Halton algorithm in R", 2017): plain Halton points
/// lie on lines where two bases are large. Any point can be had without those before it.
///
/// # Panics
/// Above [`MAX_DIMENSIONS`] dimensions.
pub fn halton(index: u64, dimensions: usize, seed: u64) -> Vec<f64> {
    (0..dimensions).map(|axis| radical_inverse(index, axis, seed)).collect()
}

fn radical_inverse(mut index: u64, axis: usize, seed: u64) -> f64 {
    let base = PRIMES[axis];
    let (mut value, mut part) = (0.0, 1.0);
    let mut place = 0u64;
    // Leading zeros are permuted too, so that the first points are spread like the others.
    while part > FINEST {
        part /= f64::from(base);
        let digit = (index % u64::from(base)) as u32;
        index /= u64::from(base);
        value += f64::from(permuted(digit, base, [seed, axis as u64, place])) * part;
        place += 1;
    }
    // Rounding may have reached 1.
    f64::min(value, 1.0 - FINEST)
}

/// Where a random permutation of `0..base` sends a digit (Fisher and Yates).
fn permuted(digit: u32, base: u32, key: [u64; 3]) -> u32 {
    let mut order: Vec<u32> = (0..base).collect();
    let mut state = key.iter().fold(0x51ee_b0a7, |state, k| mix(state ^ mix(*k)));
    for i in (1..base as usize).rev() {
        state = mix(state);
        // A modulus far below 2^64 favours nobody noticeably.
        order.swap(i, (state % (i as u64 + 1)) as usize);
    }
    order[digit as usize]
}

/// SplitMix64 (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators", 2014).
fn mix(state: u64) -> u64 {
    let mut z = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_axis_is_stratified() {
        // b^k consecutive points of base b have one in each b^k-th: the defining property.
        for (axis, base) in PRIMES.iter().enumerate().take(6) {
            let cells = (*base as usize).pow(2);
            let mut seen = vec![0; cells];
            for index in 0..cells as u64 {
                let value = radical_inverse(index, axis, 3);
                seen[(value * cells as f64 + 1e-9) as usize] += 1;
            }
            assert!(seen.iter().all(|count| *count == 1), "base {base}: {seen:?}");
        }
    }

    #[test]
    fn pairs_of_axes_are_filled_evenly() {
        // 2000 points over 16 cells: random ones scatter by 11 around 125. In the bases of the last
        // axes that are sampled often, plain Halton points lie on a few lines.
        for [a, b] in [[0, 1], [4, 7], [10, 11]] {
            let mut cells = [0u32; 16];
            for index in 0..2000 {
                let at = |axis| (radical_inverse(index, axis, 1) * 4.0) as usize;
                cells[4 * at(a) + at(b)] += 1;
            }
            assert!(cells.iter().all(|n| (90..=160).contains(n)), "axes {a} {b}: {cells:?}");
        }
    }

    #[test]
    fn the_seed_decides() {
        assert_eq!(halton(5, 4, 1), halton(5, 4, 1));
        assert_ne!(halton(5, 4, 1), halton(5, 4, 2));
        assert!(halton(u64::MAX, 32, 9).iter().all(|u| (0.0..1.0).contains(u)));
    }
}
