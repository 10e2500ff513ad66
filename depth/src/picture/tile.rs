//! A piece of the picture: samples, refinement, lines.

use super::lines::{Line, line_between};
use super::sample::{Sample, Setup, Tracer};
use super::shade::{Linear, Shader, add, srgb};

/// Side of a tile.
pub(super) const TILE_PX: u32 = 128;

/// A refined pixel is looked at with the square of this many rays.
pub(super) const SUBSAMPLES: i32 = 4;

/// Half width of lines beyond the samples right beside them, in subsamples: squared distance that
/// a line still covers, and its strength.
const OUTLINE: (i32, f32) = (5, 0.95);
const CREASE: (i32, f32) = (1, 0.70);
/// How far a line reaches, in subsamples; at most `SUBSAMPLES - 1`, so that a pixel's lines depend
/// on nothing beyond its direct neighbours.
const REACH: i32 = 2;

/// Pixels around a tile that are sampled: lines come from the next pixel, whose refinement depends
/// on the one after it.
const APRON: i32 = 2;

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tile {
    pub x_px: u32,
    pub y_px: u32,
    pub width_px: u32,
    pub height_px: u32,
}

impl Tile {
    pub fn at(column: u32, row: u32, width_px: u32, height_px: u32) -> Self {
        let (x_px, y_px) = (column * TILE_PX, row * TILE_PX);
        let clip = |from: u32, size: u32| (size - from).min(TILE_PX);
        Self { x_px, y_px, width_px: clip(x_px, width_px), height_px: clip(y_px, height_px) }
    }

    /// The tile's pixels, three bytes each, row by row.
    pub fn draw(&self, setup: &Setup<'_>) -> Vec<u8> {
        let (width, height) = (self.width_px as i32, self.height_px as i32);
        let tracer = Tracer::new(setup);
        let mut samples = Samples::trace(self, tracer);
        samples.refine();
        let mut rgb = Vec::with_capacity(3 * (width * height) as usize);
        for y in 0..height {
            for x in 0..width {
                rgb.extend(srgb(samples.pixel(x, y, &setup.shader)));
            }
        }
        rgb
    }
}

/// A square of samples within a pixel.
type Block = [Sample; (SUBSAMPLES * SUBSAMPLES) as usize];

/// Samples of a tile and its apron. Pixels are counted from the tile's first.
struct Samples<'a> {
    tracer: Tracer<'a>,
    left: i32,
    top: i32,
    width: i32,
    height: i32,
    /// One per pixel, apron included.
    centres: Vec<Sample>,
    /// Per pixel, which block refines it.
    block_of: Vec<Option<u32>>,
    blocks: Vec<Block>,
    /// Per subsample of each block, the strongest line to its four neighbours.
    lines: Vec<[Line; (SUBSAMPLES * SUBSAMPLES) as usize]>,
}

impl<'a> Samples<'a> {
    fn trace(tile: &Tile, mut tracer: Tracer<'a>) -> Self {
        let (left, top) = (tile.x_px as i32, tile.y_px as i32);
        let (width, height) = (tile.width_px as i32, tile.height_px as i32);
        let mut centres = Vec::new();
        for y in -APRON..height + APRON {
            for x in -APRON..width + APRON {
                centres.push(tracer.trace(f64::from(left + x) + 0.5, f64::from(top + y) + 0.5));
            }
        }
        let block_of = vec![None; centres.len()];
        let (blocks, lines) = Default::default();
        Self { tracer, left, top, width, height, centres, block_of, blocks, lines }
    }

    fn index(&self, x: i32, y: i32) -> usize {
        ((y + APRON) * (self.width + 2 * APRON) + x + APRON) as usize
    }

    fn line(&self, a: &Sample, b: &Sample) -> Line {
        line_between(self.tracer.surfaces(a), self.tracer.surfaces(b), self.tracer.framing)
    }

    /// Traces blocks wherever a pixel differs from a direct neighbour, and finds lines.
    fn refine(&mut self) {
        let mut breaks = vec![false; self.centres.len()];
        for y in -APRON..self.height + APRON {
            for x in -APRON..self.width + APRON {
                let here = self.index(x, y);
                let right = (x + 1 < self.width + APRON).then(|| self.index(x + 1, y));
                let below = (y + 1 < self.height + APRON).then(|| self.index(x, y + 1));
                for next in [right, below].into_iter().flatten() {
                    if self.line(&self.centres[here], &self.centres[next]).is_visible() {
                        breaks[here] = true;
                        breaks[next] = true;
                    }
                }
            }
        }
        for y in -1..=self.height {
            for x in -1..=self.width {
                let at = self.index(x, y);
                if breaks[at] {
                    self.block_of[at] = Some(self.blocks.len() as u32);
                    let block = self.trace_block(x, y);
                    self.blocks.push(block);
                }
            }
        }
        self.find_lines();
    }

    fn trace_block(&mut self, x: i32, y: i32) -> Block {
        let place = |pixel: i32, sub: i32| {
            f64::from(pixel) + (f64::from(sub) + 0.5) / f64::from(SUBSAMPLES)
        };
        let (x, y) = (self.left + x, self.top + y);
        std::array::from_fn(|i| {
            let (sub_x, sub_y) = (i as i32 % SUBSAMPLES, i as i32 / SUBSAMPLES);
            self.tracer.trace(place(x, sub_x), place(y, sub_y))
        })
    }

    /// Block and place in it of a subsample, counted from the tile's first; none if its pixel is
    /// not refined.
    fn subsample(&self, sub_x: i32, sub_y: i32) -> Option<(usize, usize)> {
        let (x, y) = (sub_x.div_euclid(SUBSAMPLES), sub_y.div_euclid(SUBSAMPLES));
        let block = self.block_of[self.index(x, y)]?;
        let within = sub_y.rem_euclid(SUBSAMPLES) * SUBSAMPLES + sub_x.rem_euclid(SUBSAMPLES);
        Some((block as usize, within as usize))
    }

    fn find_lines(&mut self) {
        self.lines = vec![Default::default(); self.blocks.len()];
        for sub_y in -SUBSAMPLES..(self.height + 1) * SUBSAMPLES {
            for sub_x in -SUBSAMPLES..(self.width + 1) * SUBSAMPLES {
                let Some((block, within)) = self.subsample(sub_x, sub_y) else { continue };
                for (next_x, next_y) in [(sub_x + 1, sub_y), (sub_x, sub_y + 1)] {
                    let Some((next, next_within)) = self.subsample(next_x, next_y) else {
                        continue;
                    };
                    let line =
                        self.line(&self.blocks[block][within], &self.blocks[next][next_within]);
                    for (block, within) in [(block, within), (next, next_within)] {
                        let strongest = &mut self.lines[block][within];
                        *strongest = strongest.stronger(line);
                    }
                }
            }
        }
    }

    fn pixel(&self, x: i32, y: i32, shader: &Shader) -> Linear {
        let at = self.index(x, y);
        let Some(block) = self.block_of[at] else { return self.centres[at].color };
        let mut sum = [0.0; 3];
        for (within, sample) in self.blocks[block as usize].iter().enumerate() {
            let sub_x = x * SUBSAMPLES + within as i32 % SUBSAMPLES;
            let sub_y = y * SUBSAMPLES + within as i32 / SUBSAMPLES;
            sum = add(sum, shader.inked(sample.color, self.ink(sub_x, sub_y)), 1.0);
        }
        sum.map(|channel| channel / (SUBSAMPLES * SUBSAMPLES) as f32)
    }

    /// How strongly lines cover a subsample.
    fn ink(&self, sub_x: i32, sub_y: i32) -> f32 {
        let mut strongest: f32 = 0.0;
        for dy in -REACH..=REACH {
            for dx in -REACH..=REACH {
                let Some((block, within)) = self.subsample(sub_x + dx, sub_y + dy) else {
                    continue;
                };
                let line = self.lines[block][within];
                let distance_squared = dx * dx + dy * dy;
                for ((reach_squared, strength), found) in
                    [(OUTLINE, line.outline), (CREASE, line.crease)]
                {
                    if distance_squared <= reach_squared {
                        strongest = strongest.max(strength * found);
                    }
                }
            }
        }
        strongest
    }
}
