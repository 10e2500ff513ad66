//! Tiling of samples into chunks, so that nearly every chunk belongs to one half.
//!
//! A chunk whose pixels all lie left of the seam is the same in all samples with that left half. It is packed and
//! stored once in a file, however many samples contain it. Only chunks through which the seam passes are stitched
//! sample by sample.

use fabkit_depth::ground_truth::Side;

/// Numbers of strips that are tried: more strips follow a crooked seam more closely, fewer are faster to read.
const STRIPS: [usize; 5] = [1, 2, 4, 8, 16];

/// Largest fraction of chunks with pixels of both halves; above it, narrower strips are tried.
const MAX_MIXED_FRACTION: f64 = 0.125;

/// Grid of equal chunks over an image; the last ones may reach beyond it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Tiling {
    /// Rows and columns of the image.
    size_px: [usize; 2],
    /// Rows and columns of a chunk.
    chunk_px: [usize; 2],
    /// True if a chunk has pixels on the left, and on the right of the seam, for each chunk.
    sides: Vec<[bool; 2]>,
}

impl Tiling {
    /// Cuts the image into strips along the seam, as few as are sufficient.
    pub(super) fn new(sides: &[Side], width_px: usize) -> Self {
        let size_px = [sides.len() / width_px, width_px];
        let strips = STRIPS.into_iter().flat_map(|count| {
            [[1, count], [count, 1]].map(|[rows, columns]| {
                Self::with_chunks(
                    sides,
                    size_px,
                    [size_px[0].div_ceil(rows), size_px[1].div_ceil(columns)],
                )
            })
        });
        let mut best: Option<(f64, Self)> = None;
        for tiling in strips {
            let mixed = tiling.mixed_fraction();
            // Tilings come from coarse to fine: the first good one has the fewest chunks.
            if mixed <= MAX_MIXED_FRACTION {
                return tiling;
            }
            if best.as_ref().is_none_or(|(least, _)| mixed < *least) {
                best = Some((mixed, tiling));
            }
        }
        best.map_or_else(|| Self::with_chunks(sides, size_px, size_px), |(_, tiling)| tiling)
    }

    /// Cuts the image into chunks of a size.
    fn with_chunks(sides: &[Side], size_px: [usize; 2], chunk_px: [usize; 2]) -> Self {
        let mut tiling = Self { size_px, chunk_px, sides: Vec::new() };
        let chunks = tiling.grid().into_iter().product();
        tiling.sides = (0..chunks)
            .map(|chunk| {
                let of = |own| tiling.pixels(chunk).any(|(_, pixel)| sides[pixel] == own);
                [of(Side::Left), of(Side::Right)]
            })
            .collect();
        tiling
    }

    fn mixed_fraction(&self) -> f64 {
        let mixed = self.sides.iter().filter(|sides| **sides == [true; 2]).count();
        mixed as f64 / self.sides.len() as f64
    }

    /// Numbers of chunks along rows and columns.
    fn grid(&self) -> [usize; 2] {
        [0, 1].map(|axis| self.size_px[axis].div_ceil(self.chunk_px[axis]))
    }

    /// Number of chunks.
    pub(super) fn chunks(&self) -> usize {
        self.sides.len()
    }

    /// Rows and columns of a chunk.
    pub(super) fn chunk_px(&self) -> [usize; 2] {
        self.chunk_px
    }

    /// Number of pixels of a chunk, including those beyond the image.
    pub(super) fn chunk_pixels(&self) -> usize {
        self.chunk_px.into_iter().product()
    }

    /// Returns whether a chunk has pixels on the left, and on the right.
    pub(super) fn sides(&self, chunk: usize) -> [bool; 2] {
        self.sides[chunk]
    }

    /// Lists the pixels of a chunk that lie in the image: their positions in the chunk and in the image.
    pub(super) fn pixels(&self, chunk: usize) -> impl Iterator<Item = (usize, usize)> + use<> {
        let ([height, width], [rows, columns]) = (self.size_px, self.chunk_px);
        // Chunks are numbered row by row.
        let across = self.grid()[1];
        let (top, left) = (chunk / across * rows, chunk % across * columns);
        (top..(top + rows).min(height)).flat_map(move |row| {
            (left..(left + columns).min(width))
                .map(move |column| ((row - top) * columns + column - left, row * width + column))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A seam of one pixel along a line from (x, 0) to (x + lean, height).
    fn seam(width: usize, height: usize, x: f64, lean: f64) -> Vec<Side> {
        let side = |i: usize| {
            let (column, row) = ((i % width) as f64, (i / width) as f64);
            match column - (x + lean * row / height as f64) {
                d if d < -0.5 => Side::Left,
                d if d > 0.5 => Side::Right,
                _ => Side::Neither,
            }
        };
        (0..width * height).map(side).collect()
    }

    #[test]
    fn a_straight_seam_in_the_middle_takes_two_chunks() {
        let tiling = Tiling::new(&seam(64, 48, 31.5, 0.0), 64);
        assert_eq!((tiling.chunk_px(), tiling.chunks()), ([48, 32], 2));
        assert_eq!([tiling.sides(0), tiling.sides(1)], [[true, false], [false, true]]);
    }

    #[test]
    fn a_crooked_seam_takes_narrow_strips_along_it() {
        let tiling = Tiling::new(&seam(64, 48, 28.0, 9.0), 64);
        assert!(tiling.chunk_px()[0] == 48 && tiling.chunk_px()[1] <= 8, "{tiling:?}");
        // Lying, it takes strips of rows.
        let sides = seam(48, 64, 20.0, 3.0);
        let lying: Vec<Side> = (0..64 * 48).map(|i| sides[i % 64 * 48 + i / 64]).collect();
        let tiling = Tiling::new(&lying, 64);
        assert!(tiling.chunk_px()[1] == 64 && tiling.chunk_px()[0] < 48, "{tiling:?}");
    }

    #[test]
    fn chunks_hold_every_pixel_once() {
        for (width, height) in [(97, 31), (5, 3), (1, 1)] {
            let tiling = Tiling::new(&seam(width, height, 0.4 * width as f64, 1.0), width);
            let mut seen = vec![0; width * height];
            for chunk in 0..tiling.chunks() {
                let mut last = None;
                for (place, pixel) in tiling.pixels(chunk) {
                    assert!(place < tiling.chunk_pixels() && last < Some(place));
                    last = Some(place);
                    seen[pixel] += 1;
                }
            }
            assert!(seen.iter().all(|count| *count == 1));
        }
    }
}
