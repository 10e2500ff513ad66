//! Evaluation of a chain of layers over an image, tile by tile.
//!
//! In each tile, a layer is evaluated only where the next layer reads it, and the last layer only where its output is
//! requested. Outside the image every layer reads zeros, as the paddings of its convolutions state.

use rayon::prelude::*;

use crate::chain::Chain;
use crate::convolution::EvaluationPixels;
use crate::pointwise::apply;

/// Rows and columns of a tile, px. Maps of 64 channels around it stay in the second-level cache.
pub const TILE_PX: usize = 32;

/// Pixels at which the output is requested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputRegion {
    /// All pixels.
    Everything,
    /// Pixels where the image is not zero.
    Nonzero,
}

/// Rectangle of an image: its first row and column, which may lie outside the image, and its size.
#[derive(Clone, Copy, Debug)]
struct Rectangle {
    first: [isize; 2],
    size: [usize; 2],
}

impl Rectangle {
    /// Returns the rectangle enlarged by `reach` rows and columns on each side.
    fn enlarged(self, reach: [usize; 2]) -> Self {
        Self {
            first: [0, 1].map(|k| self.first[k] - reach[k] as isize),
            size: [0, 1].map(|k| self.size[k] + 2 * reach[k]),
        }
    }

    fn pixels(self) -> usize {
        self.size[0] * self.size[1]
    }

    /// Returns the rows and columns of the rectangle that lie in an image of the given size.
    fn inside(self, image: [usize; 2]) -> [std::ops::Range<usize>; 2] {
        [0, 1].map(|k| {
            let clamped = |at: isize| at.clamp(0, self.size[k] as isize) as usize;
            clamped(-self.first[k])..clamped(image[k] as isize - self.first[k])
        })
    }

    /// Returns whether the whole rectangle lies in the image.
    fn is_inside(self, image: [usize; 2]) -> bool {
        self.inside(image) == self.size.map(|size| 0..size)
    }
}

/// Working memory of a thread; its content is meaningless between tiles.
#[derive(Default)]
struct Workspace {
    before: Vec<f32>,
    after: Vec<f32>,
    windows: Vec<usize>,
    pixels: Vec<usize>,
}

/// Input image, row by row, with its rows and columns.
#[derive(Clone, Copy)]
struct InputImage<'a> {
    values: &'a [f32],
    size: [usize; 2],
}

/// Returns the maximum working memory of a thread, bytes.
pub fn bytes_per_thread(chain: &Chain) -> u64 {
    let mut part = Rectangle { first: [0, 0], size: [TILE_PX, TILE_PX] };
    let mut largest = part.pixels();
    for stage in chain.stages.iter().rev() {
        largest = largest.max(part.pixels() * stage.convolution.outputs);
        part = part.enlarged(stage.convolution.kernel.map(|px| px / 2));
    }
    // Two lists of indices, and a mask for the tile and for each layer.
    let a_pixel = 2 * size_of::<usize>() + (1 + chain.stages.len()) * size_of::<bool>();
    (2 * size_of::<f32>() * largest.max(part.pixels()) + a_pixel * part.pixels()) as u64
}

/// Evaluates a chain on an image with `columns` columns.
pub fn evaluate(chain: &Chain, values: &[f32], columns: usize, wanted: OutputRegion) -> Vec<f32> {
    let mut all = vec![0.0; values.len()];
    if values.is_empty() {
        return all;
    }
    let given = InputImage { values, size: [values.len() / columns, columns] };
    let across = columns.div_ceil(TILE_PX);
    let count = across * given.size[0].div_ceil(TILE_PX);
    let part = |tile: usize| {
        let first = [tile / across * TILE_PX, tile % across * TILE_PX];
        let size = [0, 1].map(|k| TILE_PX.min(given.size[k] - first[k]));
        Rectangle { first: first.map(|px| px as isize), size }
    };
    let tiles: Vec<Option<Vec<f32>>> = (0..count)
        .into_par_iter()
        .map_init(Workspace::default, |room, tile| {
            evaluate_tile(chain, given, part(tile), wanted, room)
        })
        .collect();
    for (tile, found) in tiles.into_iter().enumerate() {
        let (Rectangle { first, size }, Some(found)) = (part(tile), found) else { continue };
        for (row, found) in found.chunks_exact(size[1]).enumerate() {
            let start = (first[0] as usize + row) * columns + first[1] as usize;
            all[start..start + size[1]].copy_from_slice(found);
        }
    }
    all
}

/// Evaluates one tile, with zeros where the output is not requested; `None` if it is requested nowhere.
fn evaluate_tile(
    chain: &Chain,
    given: InputImage,
    tile: Rectangle,
    wanted: OutputRegion,
    room: &mut Workspace,
) -> Option<Vec<f32>> {
    let row_of = |row: usize| {
        let start = (tile.first[0] as usize + row) * given.size[1] + tile.first[1] as usize;
        &given.values[start..start + tile.size[1]]
    };
    let rows = 0..tile.size[0];
    let asked: Vec<bool> = match wanted {
        OutputRegion::Everything => vec![true; tile.pixels()],
        OutputRegion::Nonzero => {
            // Most tiles end here. Without an early exit from the row, the comparison is vectorized.
            let is_touched =
                |row| row_of(row).iter().fold(false, |any, value| any | (*value != 0.0));
            if !rows.clone().any(is_touched) {
                return None;
            }
            let mut asked = Vec::with_capacity(tile.pixels());
            rows.for_each(|row| asked.extend(row_of(row).iter().map(|value| *value != 0.0)));
            asked
        }
    };
    // From the last layer to the first: the rectangle and the pixels at which each is evaluated.
    let mut needs = vec![(tile, asked)];
    for stage in chain.stages.iter().skip(1).rev() {
        let (part, asked) = &needs[needs.len() - 1];
        needs.push(dilate(*part, asked, stage.convolution.kernel.map(|px| px / 2)));
    }
    let reach =
        chain.stages.first().map_or([0, 0], |stage| stage.convolution.kernel.map(|px| px / 2));
    let first = needs[needs.len() - 1].0.enlarged(reach);
    load_input(chain, given, first, &mut room.before);
    let mut columns = first.size[1];
    for (i, (stage, (part, asked))) in chain.stages.iter().zip(needs.iter().rev()).enumerate() {
        let outputs = stage.convolution.outputs;
        let count = part.pixels() * outputs;
        if room.after.len() < count {
            room.after.resize(count, 0.0);
        }
        // Pixels outside the image are read by the next layer but never written, so they must be zero. Unrequested
        // pixels inside keep stale values that nothing reads.
        if !part.is_inside(given.size) {
            room.after[..count].fill(0.0);
        }
        if i > 0 && stage.convolution.kernel == [1, 1] {
            // A 1 x 1 window reads exactly the pixels of the layer before it.
            room.windows.clone_from(&room.pixels);
        } else {
            list_windows(*part, asked, given.size, columns, room);
        }
        let places = EvaluationPixels {
            map: &room.before,
            columns,
            windows: &room.windows,
            pixels: &room.pixels,
        };
        stage.convolution.evaluate(places, &stage.pointwise, &mut room.after);
        std::mem::swap(&mut room.before, &mut room.after);
        columns = part.size[1];
    }
    let (_, asked) = &needs[0];
    // Without any convolution, the whole tile was read.
    let found = asked.iter().zip(&room.before);
    Some(found.map(|(asked, value)| if *asked { *value } else { 0.0 }).collect())
}

/// Lists the requested pixels of a rectangle that lie in the image, and the first pixel of each window in the input
/// map, which has `columns` columns.
fn list_windows(
    part: Rectangle,
    asked: &[bool],
    image: [usize; 2],
    columns: usize,
    room: &mut Workspace,
) {
    let [rows, inside] = part.inside(image);
    room.windows.clear();
    room.pixels.clear();
    for row in rows {
        let start = row * part.size[1];
        let asked = &asked[start..start + part.size[1]];
        for column in inside.clone() {
            if asked[column] {
                room.windows.push(row * columns + column);
                room.pixels.push(start + column);
            }
        }
    }
}

/// Returns the pixels that windows with the given reach read, and their rectangle.
fn dilate(part: Rectangle, asked: &[bool], reach: [usize; 2]) -> (Rectangle, Vec<bool>) {
    if reach == [0, 0] {
        return (part, asked.to_vec());
    }
    let wider = part.enlarged(reach);
    let [columns, wide] = [part.size[1], wider.size[1]];
    let mut found = vec![false; wider.pixels()];
    let mut along = vec![false; wide];
    for (row, asked) in asked.chunks_exact(columns).enumerate() {
        // Number of columns still covered by the window of the last requested pixel.
        let mut left = 0;
        for (column, along) in along.iter_mut().enumerate() {
            if asked.get(column).is_some_and(|asked| *asked) {
                left = 2 * reach[1] + 1;
            }
            *along = left > 0;
            left = left.saturating_sub(1);
        }
        if !along.contains(&true) {
            continue;
        }
        for found in found[row * wide..][..(2 * reach[0] + 1) * wide].chunks_exact_mut(wide) {
            found.iter_mut().zip(&along).for_each(|(found, along)| *found |= along);
        }
    }
    (wider, found)
}

/// Copies a rectangle of the image, with zeros outside it, and applies the operations before the first layer.
fn load_input(chain: &Chain, given: InputImage, part: Rectangle, into: &mut Vec<f32>) {
    into.clear();
    into.resize(part.pixels(), 0.0);
    let [rows, columns] = part.inside(given.size);
    for row in rows {
        let from = (part.first[0] + row as isize) as usize * given.size[1];
        let from = from + (part.first[1] + columns.start as isize) as usize;
        let into = &mut into[row * part.size[1]..][columns.clone()];
        into.copy_from_slice(&given.values[from..from + into.len()]);
        apply(&chain.before, into, 1, 0);
    }
}
