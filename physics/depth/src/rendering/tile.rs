//! Rendering of one tile of an image: samples, refinement, lines.

use super::lines::{Line, line_between};
use super::pen::{Pen, SUBSAMPLES};
use super::sample::{Sample, Setup, Tracer};
use super::shade::{Linear, Shader, add, srgb};

/// Side of a tile, px.
pub(super) const TILE_PX: u32 = 128;

/// Opacity of outlines and of creases.
const OUTLINE_INK: f32 = 0.95;
const CREASE_INK: f32 = 0.70;

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
        // Tiles at the right and lower border may be smaller.
        let clip = |from: u32, size: u32| (size - from).min(TILE_PX);
        Self { x_px, y_px, width_px: clip(x_px, width_px), height_px: clip(y_px, height_px) }
    }

    /// Renders the tile's pixels, three bytes each, row by row.
    pub fn draw(&self, setup: &Setup<'_>) -> Vec<u8> {
        let mut samples = Samples::trace(self, setup);
        samples.refine();
        let ink = Ink::draw(&samples, &setup.pen);
        let mut rgb = Vec::with_capacity(3 * (self.width_px * self.height_px) as usize);
        for y in 0..samples.height {
            for x in 0..samples.width {
                rgb.extend(srgb(samples.pixel(x, y, &ink, &setup.shader)));
            }
        }
        rgb
    }
}

/// Samples of a refined pixel, in a square.
type Block = [Sample; (SUBSAMPLES * SUBSAMPLES) as usize];

/// Samples of a tile and its apron. Pixels are counted from the tile's first.
struct Samples<'a> {
    tracer: Tracer<'a>,
    left: i32,
    top: i32,
    width: i32,
    height: i32,
    /// Number of pixels around the tile that may be refined. One more is sampled to detect where.
    margin: i32,
    /// Central sample of each pixel, including the apron.
    centres: Vec<Sample>,
    /// Block that refines each pixel.
    block_of: Vec<Option<u32>>,
    blocks: Vec<Block>,
    /// Strongest line to the four neighbours, for each subsample of each block.
    lines: Vec<[Line; (SUBSAMPLES * SUBSAMPLES) as usize]>,
}

impl<'a> Samples<'a> {
    /// Traces the central ray of each pixel of a tile and its apron.
    fn trace(tile: &Tile, setup: &'a Setup<'a>) -> Self {
        let mut tracer = Tracer::new(setup);
        let (left, top) = (tile.x_px as i32, tile.y_px as i32);
        let (width, height) = (tile.width_px as i32, tile.height_px as i32);
        let margin = setup.pen.margin_px();
        let apron = margin + 1;
        let mut centres = Vec::new();
        for y in -apron..height + apron {
            for x in -apron..width + apron {
                centres.push(tracer.trace(f64::from(left + x) + 0.5, f64::from(top + y) + 0.5));
            }
        }
        let block_of = vec![None; centres.len()];
        let (blocks, lines) = Default::default();
        Self { tracer, left, top, width, height, margin, centres, block_of, blocks, lines }
    }

    fn index(&self, x: i32, y: i32) -> usize {
        let apron = self.margin + 1;
        ((y + apron) * (self.width + 2 * apron) + x + apron) as usize
    }

    fn line(&self, a: &Sample, b: &Sample) -> Line {
        line_between(self.tracer.surfaces(a), self.tracer.surfaces(b), self.tracer.framing)
    }

    /// Traces blocks wherever a pixel differs from a direct neighbour, and finds lines.
    fn refine(&mut self) {
        let mut breaks = vec![false; self.centres.len()];
        let margin = self.margin;
        let (right_end, bottom_end) = (self.width + margin + 1, self.height + margin + 1);
        for y in -margin - 1..bottom_end {
            for x in -margin - 1..right_end {
                let here = self.index(x, y);
                let right = (x + 1 < right_end).then(|| self.index(x + 1, y));
                let below = (y + 1 < bottom_end).then(|| self.index(x, y + 1));
                // Left and upper neighbours were compared when they were the current pixel.
                for next in [right, below].into_iter().flatten() {
                    if self.line(&self.centres[here], &self.centres[next]).is_visible() {
                        breaks[here] = true;
                        breaks[next] = true;
                    }
                }
            }
        }
        for y in -margin..self.height + margin {
            for x in -margin..self.width + margin {
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

    /// Traces the subsamples of a pixel.
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

    /// Returns the block of a subsample and its index in it; `None` if its pixel is not refined. Subsamples are counted
    /// from the tile's first.
    fn subsample(&self, sub_x: i32, sub_y: i32) -> Option<(usize, usize)> {
        let (x, y) = (sub_x.div_euclid(SUBSAMPLES), sub_y.div_euclid(SUBSAMPLES));
        let block = self.block_of[self.index(x, y)]?;
        let within = sub_y.rem_euclid(SUBSAMPLES) * SUBSAMPLES + sub_x.rem_euclid(SUBSAMPLES);
        Some((block as usize, within as usize))
    }

    /// Finds the lines between neighbouring subsamples of refined pixels.
    fn find_lines(&mut self) {
        self.lines = vec![Default::default(); self.blocks.len()];
        let margin = self.margin;
        for sub_y in -margin * SUBSAMPLES..(self.height + margin) * SUBSAMPLES {
            for sub_x in -margin * SUBSAMPLES..(self.width + margin) * SUBSAMPLES {
                let Some((block, within)) = self.subsample(sub_x, sub_y) else { continue };
                for (next_x, next_y) in [(sub_x + 1, sub_y), (sub_x, sub_y + 1)] {
                    // Lines end at pixels that are not refined.
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

    /// Returns the colour of a pixel: the mean of its subsamples with ink where it is refined or inked.
    fn pixel(&self, x: i32, y: i32, ink: &Ink, shader: &Shader) -> Linear {
        let at = self.index(x, y);
        let block = self.block_of[at].map(|block| &self.blocks[block as usize]);
        if block.is_none() && !ink.touches(x, y) {
            return self.centres[at].color;
        }
        let mut sum = [0.0; 3];
        for within in 0..SUBSAMPLES * SUBSAMPLES {
            let sample = block.map_or(&self.centres[at], |block| &block[within as usize]);
            let sub_x = x * SUBSAMPLES + within % SUBSAMPLES;
            let sub_y = y * SUBSAMPLES + within / SUBSAMPLES;
            sum = add(sum, shader.blend_ink(sample.color, ink.strength(sub_x, sub_y)), 1.0);
        }
        sum.map(|channel| channel / (SUBSAMPLES * SUBSAMPLES) as f32)
    }
}

/// Line strength at each subsample of a tile.
struct Ink {
    /// Number of subsamples per row.
    width: i32,
    height: i32,
    /// Strengths row by row; empty where the tile has no lines at all.
    strengths: Vec<f32>,
    /// True for pixels that lines touch.
    touched: Vec<bool>,
}

impl Ink {
    /// Draws the lines of all subsamples, including those of the apron that reach into the tile.
    fn draw(samples: &Samples<'_>, pen: &Pen) -> Self {
        let (width, height) = (samples.width * SUBSAMPLES, samples.height * SUBSAMPLES);
        let mut ink = Self { width, height, strengths: Vec::new(), touched: Vec::new() };
        if samples.blocks.is_empty() {
            return ink;
        }
        ink.strengths.resize((width * height) as usize, 0.0);
        ink.touched.resize((samples.width * samples.height) as usize, false);
        // Subsamples of the apron are included, since their lines reach into the tile.
        let reach = samples.margin * SUBSAMPLES;
        for sub_y in -reach..height + reach {
            for sub_x in -reach..width + reach {
                let Some((block, within)) = samples.subsample(sub_x, sub_y) else { continue };
                let line = samples.lines[block][within];
                ink.dot(sub_x, sub_y, pen.outline_reach, OUTLINE_INK * line.outline);
                ink.dot(sub_x, sub_y, pen.crease_reach, CREASE_INK * line.crease);
            }
        }
        ink
    }

    /// Draws a disc of the pen, keeping the stronger of new and old strengths.
    fn dot(&mut self, sub_x: i32, sub_y: i32, radius: f64, strength: f32) {
        if strength == 0.0 {
            return;
        }
        let reach = radius as i32;
        for y in (sub_y - reach).max(0)..=(sub_y + reach).min(self.height - 1) {
            for x in (sub_x - reach).max(0)..=(sub_x + reach).min(self.width - 1) {
                let (dx, dy) = (x - sub_x, y - sub_y);
                // The maximum, not the sum, so that overlapping discs of one line do not darken it.
                if f64::from(dx * dx + dy * dy) <= radius * radius {
                    let there = &mut self.strengths[(y * self.width + x) as usize];
                    *there = there.max(strength);
                    let pixel = y / SUBSAMPLES * (self.width / SUBSAMPLES) + x / SUBSAMPLES;
                    self.touched[pixel as usize] = true;
                }
            }
        }
    }

    fn touches(&self, x: i32, y: i32) -> bool {
        let pixel = (y * (self.width / SUBSAMPLES) + x) as usize;
        self.touched.get(pixel).is_some_and(|&touched| touched)
    }

    fn strength(&self, sub_x: i32, sub_y: i32) -> f32 {
        self.strengths.get((sub_y * self.width + sub_x) as usize).map_or(0.0, |&strength| strength)
    }
}
