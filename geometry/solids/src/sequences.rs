//! Reproducible quasirandom and pseudorandom sequences.
//!
//! All sampling, here and in dependent crates, uses this module, so that no result depends on a generator whose next
//! version yields other numbers.
//!
//! ```
//! use fabkit_geometry::sequences::halton;
//! // Of eight points in a row, one lies in each eighth of the first axis.
//! let mut eighths: Vec<u32> = (0..8).map(|index| (8.0 * halton(index, 2, 1)[0]) as u32).collect();
//! eighths.sort_unstable();
//! assert_eq!(eighths, [0, 1, 2, 3, 4, 5, 6, 7]);
//! assert_eq!(halton(5, 2, 1), halton(5, 2, 1)); // no state: any point, at any time
//! ```

/// Golden angle, rad: `pi (3 - sqrt(5))`, the angle between successive points of a sunflower pattern (Vogel, Math.
/// Biosciences 44, 1979).
pub const GOLDEN_ANGLE_RAD: f64 = 2.399_963_229_728_653;

/// Golden angle as a fraction of a turn, in the opposite direction: the golden ratio minus 1.
pub const GOLDEN_RATIO_CONJUGATE: f64 = 0.618_033_988_749_894_9;

/// Quasirandom points that fill a unit square or cube evenly, for any number of points: no gap is larger than a few
/// cells.
///
/// Uses the additive recurrence whose steps are powers of the inverse of the generalised golden ratio, the root above 1
/// of `x^(N + 1) = x + 1` (Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018). Another shift
/// gives other points of the same evenness (Cranley and Patterson, SIAM J. Numer. Anal. 1976).
///
/// ```
/// use fabkit_geometry::sequences::EvenPoints;
/// let points = EvenPoints::square([0.5; 2]);
/// let [u, v] = points.at(1);
/// assert!((u - 0.254_878).abs() < 1e-6 && (v - 0.069_840).abs() < 1e-6);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct EvenPoints<const N: usize> {
    shift: [f64; N],
    steps: [f64; N],
}

impl EvenPoints<2> {
    /// Creates a sequence in the unit square.
    pub const fn square(shift: [f64; 2]) -> Self {
        Self { shift, steps: [0.754_877_666_246_692_7, 0.569_840_290_998_053_3] }
    }
}

impl EvenPoints<3> {
    /// Creates a sequence in the unit cube.
    pub const fn cube(shift: [f64; 3]) -> Self {
        // Written out because the result of `powi` may differ between platforms.
        let steps = [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_2];
        Self { shift, steps }
    }
}

impl<const N: usize> EvenPoints<N> {
    /// Returns the point with a number, each coordinate in [0, 1); 0 gives the shift itself.
    pub fn at(&self, number: usize) -> [f64; N] {
        std::array::from_fn(|axis| (self.shift[axis] + number as f64 * self.steps[axis]).fract())
    }
}

/// Weight below which a digit changes no `f64` near 1.
const FINEST: f64 = 1.0 / (1u64 << 53) as f64;

/// Returns the `index`-th number in [0, 1) of the van der Corput sequence in a base: its digits, mirrored at the radix
/// point.
///
/// ```
/// use fabkit_geometry::sequences::radical_inverse;
/// assert_eq!(radical_inverse(6, 2), 0.375);
/// ```
pub fn radical_inverse(index: u64, base: u32) -> f64 {
    mirrored(index, base, |digit, _| digit)
}

/// Mirrors the digits of a number at the radix point after passing each digit with its place to `replaced`; leading
/// zeros too.
fn mirrored(mut index: u64, base: u32, replaced: impl Fn(u32, u64) -> u32) -> f64 {
    let (mut value, mut part, mut place) = (0.0, 1.0, 0);
    while part > FINEST {
        part /= f64::from(base);
        let digit = (index % u64::from(base)) as u32;
        index /= u64::from(base);
        value += f64::from(replaced(digit, place)) * part;
        place += 1;
    }
    // Rounding may have reached 1.
    f64::min(value, 1.0 - FINEST)
}

/// First 32 primes: one base for each axis.
const PRIMES: [u32; 32] = [
    2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61, 67, 71, 73, 79, 83, 89, 97,
    101, 103, 107, 109, 113, 127, 131,
];

/// Largest number of dimensions of [`halton`].
pub const MAX_DIMENSIONS: usize = PRIMES.len();

/// Computes the `index`-th point of a scrambled Halton sequence, each coordinate in [0, 1).
///
/// Halton's radical inverses (Numer. Math. 2, 1960) with the digits of each place permuted at random, reproducibly for
/// a seed (Owen, "A randomized Halton algorithm in R", 2017): plain Halton points lie on lines where two bases are
/// large. Leading zeros are permuted too, so that the first points are spread like the others. Any point can be
/// computed without those before it.
///
/// # Panics
/// Above [`MAX_DIMENSIONS`] dimensions.
pub fn halton(index: u64, dimensions: usize, seed: u64) -> Vec<f64> {
    (0..dimensions).map(|axis| halton_coordinate(index, axis, seed)).collect()
}

fn halton_coordinate(index: u64, axis: usize, seed: u64) -> f64 {
    let base = PRIMES[axis];
    mirrored(index, base, |digit, place| permuted(digit, base, [seed, axis as u64, place]))
}

/// Returns the image of a digit under a random permutation of `0..base` that is determined by `key`.
fn permuted(digit: u32, base: u32, key: [u64; 3]) -> u32 {
    let mix = |state| SplitMix64::new(state).bits();
    let mut order: Vec<u32> = (0..base).collect();
    // Arbitrary start value; each part of the key is mixed in before the next.
    let mut state = key.iter().fold(0x51ee_b0a7, |state, k| mix(state ^ mix(*k)));
    // Fisher-Yates shuffle of the digits, driven by the hashed key.
    for last in (1..base as usize).rev() {
        state = mix(state);
        order.swap(last, (state % (last as u64 + 1)) as usize);
    }
    order[digit as usize]
}

/// Pseudorandom generator SplitMix64 (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA
/// 2014).
///
/// ```
/// use fabkit_geometry::sequences::SplitMix64;
/// let mut random = SplitMix64::new(0);
/// assert_eq!(random.bits(), 0xe220_a839_7b1d_cdaf);
/// assert!((0.0..1.0).contains(&random.unit()));
/// ```
#[derive(Clone, Debug)]
pub struct SplitMix64(u64);

impl SplitMix64 {
    /// Creates a generator; the same seed gives the same numbers.
    pub const fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Returns 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Returns a number in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Returns a number in [least, most).
    pub fn between(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.unit()
    }

    /// Returns an integer below `end`; 0 if `end` is 0.
    pub fn below(&mut self, end: usize) -> usize {
        (self.unit() * end as f64) as usize
    }

    /// Returns a random element.
    ///
    /// # Panics
    /// If the slice is empty.
    pub fn choose<'a, T>(&mut self, of: &'a [T]) -> &'a T {
        &of[self.below(of.len())]
    }

    /// Returns a normally distributed number with mean 0 and standard deviation 1 (Box-Muller transform).
    pub fn normal(&mut self) -> f64 {
        // The minimum avoids the logarithm of 0.
        let radius = (-2.0 * self.unit().max(f64::MIN_POSITIVE).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.unit()).cos()
    }

    /// Shuffles items uniformly (Fisher-Yates).
    ///
    /// ```
    /// use fabkit_geometry::sequences::SplitMix64;
    /// let shuffled = |seed| {
    ///     let mut order: Vec<u32> = (0..10).collect();
    ///     SplitMix64::new(seed).shuffle(&mut order);
    ///     order
    /// };
    /// assert_eq!(shuffled(3), shuffled(3));
    /// assert_ne!(shuffled(3), shuffled(4));
    /// ```
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            // The bias of the remainder is far below one in a billion.
            items.swap(last, (self.bits() % (last as u64 + 1)) as usize);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_powers_of_the_roots_that_they_should_be() {
        // Their third and fourth powers follow from the definition.
        let of = |points: &[f64], order: i32| {
            let inverse = points[0];
            assert!((inverse.powi(-order) - 1.0 / inverse - 1.0).abs() < 1e-14, "{inverse}");
            for (power, step) in points.iter().enumerate() {
                assert!((step - inverse.powi(power as i32 + 1)).abs() < 1e-15, "{step}");
            }
        };
        of(&EvenPoints::square([0.0; 2]).steps, 3);
        of(&EvenPoints::cube([0.0; 3]).steps, 4);
        assert_eq!(GOLDEN_ANGLE_RAD, std::f64::consts::PI * (3.0 - 5.0f64.sqrt()));
        let turns = 1.0 - GOLDEN_ANGLE_RAD / std::f64::consts::TAU;
        assert!((turns - GOLDEN_RATIO_CONJUGATE).abs() < 1e-15, "{turns}");
    }

    #[test]
    fn points_fill_every_cell_of_a_grid_alike_for_any_shift() {
        for seed in 0..20 {
            let mut random = SplitMix64::new(seed);
            let square = EvenPoints::square([0; 2].map(|_| random.unit()));
            let cube = EvenPoints::cube([0; 3].map(|_| random.unit()));
            let (mut cells, mut blocks) = ([0u32; 64], [0u32; 64]);
            for number in 0..6400 {
                let [x, y] = square.at(number).map(|v| (8.0 * v) as usize);
                cells[8 * x + y] += 1;
                let [x, y, z] = cube.at(number).map(|v| (4.0 * v) as usize);
                blocks[16 * x + 4 * y + z] += 1;
            }
            // Chi squared around 100 in each: random points have 63 on average, and below 32 not once in
            // a thousand times.
            let unevenness = |counts: &[u32]| {
                counts.iter().map(|count| (f64::from(*count) - 100.0).powi(2) / 100.0).sum::<f64>()
            };
            assert!(unevenness(&cells) < 32.0, "seed {seed}: {cells:?}");
            assert!(unevenness(&blocks) < 32.0, "seed {seed}: {blocks:?}");
        }
    }

    #[test]
    fn each_axis_of_a_halton_sequence_is_stratified() {
        // b^k consecutive points of base b have one in each b^k-th: the defining property.
        for (axis, base) in PRIMES.iter().enumerate().take(6) {
            let cells = (*base as usize).pow(2);
            let mut seen = vec![0; cells];
            for index in 0..cells as u64 {
                let value = halton_coordinate(index, axis, 3);
                seen[(value * cells as f64 + 1e-9) as usize] += 1;
            }
            assert!(seen.iter().all(|count| *count == 1), "base {base}: {seen:?}");
        }
    }

    #[test]
    fn pairs_of_axes_of_a_halton_sequence_are_filled_evenly() {
        // 2000 points over 16 cells: random ones scatter by 11 around 125. In the bases of the last
        // axes that are sampled often, plain Halton points lie on a few lines.
        for [a, b] in [[0, 1], [4, 7], [10, 11]] {
            let mut cells = [0u32; 16];
            for index in 0..2000 {
                let at = |axis| (halton_coordinate(index, axis, 1) * 4.0) as usize;
                cells[4 * at(a) + at(b)] += 1;
            }
            assert!(cells.iter().all(|n| (90..=160).contains(n)), "axes {a} {b}: {cells:?}");
        }
    }

    #[test]
    fn a_seed_gives_the_same_points_each_time_and_none_reaches_1() {
        assert_eq!(halton(5, 4, 1), halton(5, 4, 1));
        assert_ne!(halton(5, 4, 1), halton(5, 4, 2));
        assert!(halton(u64::MAX, 32, 9).iter().all(|u| (0.0..1.0).contains(u)));
    }

    #[test]
    fn random_numbers_have_their_moments_and_orders_lose_nothing() {
        let mut random = SplitMix64::new(7);
        let count = 20_000;
        let normal: Vec<f64> = (0..count).map(|_| random.normal()).collect();
        let mean = normal.iter().sum::<f64>() / f64::from(count);
        let variance = normal.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / f64::from(count);
        // Five standard deviations of the mean and of the variance of `count` numbers.
        assert!(mean.abs() < 5.0 / f64::from(count).sqrt(), "{mean}");
        assert!((variance - 1.0).abs() < 5.0 * (2.0 / f64::from(count)).sqrt(), "{variance}");
        let mut order: Vec<usize> = (0..100).collect();
        random.shuffle(&mut order);
        assert_ne!(order, (0..100).collect::<Vec<_>>());
        order.sort_unstable();
        assert_eq!(order, (0..100).collect::<Vec<_>>());
    }
}
