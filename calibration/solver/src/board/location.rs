//! Location of a grid of saddles on the board: which corner of the board each saddle is.

use std::collections::BTreeMap;

use fabkit_camera::Vector2;

use super::grid::{Cell, Grid};
use super::marker::MarkerReader;
use super::{Board, BoardKind, BoardNotFound};
use crate::image::GreyImage;

/// Largest fraction of corners that a checkerboard may lack, as long as its outline is complete.
const MAX_MISSING_FRACTION: f64 = 0.1;
/// Smallest number of markers that must agree on the location of a ChArUco board.
const MIN_AGREEING_MARKERS: usize = 2;
/// Largest distance of a corner, px, from the position extrapolated along its row or column, unless [`JUMP_SPACINGS`]
/// allows more: distortion changes slowly from square to square.
const JUMP_PX: f64 = 1.0;
/// Largest distance of a corner from that position, in spacings.
const JUMP_SPACINGS: f64 = 0.06;

/// Rotates a cell by `quarters` quarter turns.
fn rotate_cell((mut i, mut j): Cell, quarters: usize) -> Cell {
    for _ in 0..quarters {
        (i, j) = (-j, i);
    }
    (i, j)
}

/// Returns whether the square to the lower right of a corner is light, in the turned grid.
fn is_light((u, v): Cell, quarters: usize) -> bool {
    // After each quarter turn another of the four squares around a corner is the lower right one.
    ((u + v).rem_euclid(2) == 0) == quarters.is_multiple_of(2)
}

/// Finds which corner of the board each saddle is. The keys of the result are the board's columns and rows from 0.
pub(super) fn locate(
    image: &GreyImage,
    board: &Board,
    grids: &[Grid],
) -> Result<Grid, BoardNotFound> {
    let mut placed = match board.kind {
        BoardKind::Checkerboard => checkerboard(board, grids)?,
        BoardKind::Charuco => charuco(image, board, grids)?,
    };
    drop_jumps(&mut placed);
    Ok(placed)
}

/// Locates the largest grid on a checkerboard by its outline.
fn checkerboard(board: &Board, grids: &[Grid]) -> Result<Grid, BoardNotFound> {
    let [columns, rows] = board.inner_corners();
    let expected = columns * rows;
    let largest = grids.first().ok_or(BoardNotFound::NoGrid)?;
    let mut best: Option<(f64, Grid)> = None;
    for quarters in 0..4 {
        let cells = || largest.keys().map(|cell| rotate_cell(*cell, quarters));
        let least = |of: fn(Cell) -> i32| cells().map(of).min().unwrap_or(0);
        let most = |of: fn(Cell) -> i32| cells().map(of).max().unwrap_or(0);
        let (u0, v0) = (least(|c| c.0), least(|c| c.1));
        let size = [most(|c| c.0) - u0, most(|c| c.1) - v0].map(|n| n as usize + 1);
        let complete = largest.len() as f64 >= (1.0 - MAX_MISSING_FRACTION) * expected as f64;
        // The board's first square is dark, and so is the one to the lower right of its first corner.
        if size != [columns, rows] || !complete || is_light((u0, v0), quarters) {
            continue;
        }
        let placed: Grid = largest
            .iter()
            .map(|(cell, saddle)| {
                let (u, v) = rotate_cell(*cell, quarters);
                ((u - u0, v - v0), *saddle)
            })
            .collect();
        // Of orientations that look alike, the one whose rows run most to the right.
        let to_the_right: f64 = steps(&placed).map(|step| step.normalize().x).sum();
        if best.as_ref().is_none_or(|(other, _)| to_the_right > *other) {
            best = Some((to_the_right, placed));
        }
    }
    let found = largest.len();
    best.map(|(_, placed)| placed).ok_or(BoardNotFound::Incomplete { found, expected })
}

/// Lists the vectors from each corner to the next in its row.
fn steps(placed: &Grid) -> impl Iterator<Item = Vector2<f64>> {
    placed
        .iter()
        .filter_map(|((c, r), saddle)| placed.get(&(c + 1, *r)).map(|next| next.at - saddle.at))
}

/// Locates all grids on a ChArUco board by its markers, and joins them.
fn charuco(image: &GreyImage, board: &Board, grids: &[Grid]) -> Result<Grid, BoardNotFound> {
    let markers = MarkerReader::new(board);
    let [columns, rows] = board.inner_corners().map(|n| n as i32);
    let mut placed = Grid::new();
    let mut most_markers = 0;
    for grid in grids {
        let votes = count_votes(image, &markers, grid);
        let Some((shift, count)) = votes.iter().max_by_key(|(shift, count)| (**count, **shift))
        else {
            continue;
        };
        most_markers = most_markers.max(*count);
        // A few contradicting markers are misread; more mean that the location is not reliable.
        let others: usize = votes.values().sum::<usize>() - count;
        if *count < MIN_AGREEING_MARKERS || 2 * others > *count {
            continue;
        }
        let (quarters, dc, dr) = *shift;
        for (cell, saddle) in grid {
            let (u, v) = rotate_cell(*cell, quarters);
            let cell = (u + dc, v + dr);
            if (0..columns).contains(&cell.0) && (0..rows).contains(&cell.1) {
                // Larger grids come first and take precedence.
                placed.entry(cell).or_insert(*saddle);
            }
        }
    }
    match (grids.is_empty(), placed.is_empty()) {
        (true, _) => Err(BoardNotFound::NoGrid),
        (_, true) => {
            Err(BoardNotFound::NoMarkers { read: most_markers, needed: MIN_AGREEING_MARKERS })
        }
        _ => Ok(placed),
    }
}

/// Counts the markers that agree on each location: quarter turns and shift of the grid.
fn count_votes(
    image: &GreyImage,
    markers: &MarkerReader,
    grid: &Grid,
) -> BTreeMap<(usize, i32, i32), usize> {
    let mut votes = BTreeMap::new();
    for &(i, j) in grid.keys().filter(|cell| is_light(**cell, 0)) {
        let cells = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
        let [Some(a), Some(b), Some(c), Some(d)] = cells.map(|cell| grid.get(&cell)) else {
            continue;
        };
        let Some((quarters, [column, row])) =
            markers.read(image, [a, b, c, d].map(|saddle| saddle.at))
        else {
            continue;
        };
        // The marker's upper left corner is also the upper left corner of its square in the turned grid.
        let (u, v) = rotate_cell(cells[(4 - quarters) % 4], quarters);
        // The board's first corner is the upper left one of square [1, 1].
        let shift = (quarters, column as i32 - 1 - u, row as i32 - 1 - v);
        *votes.entry(shift).or_insert(0) += 1;
    }
    votes
}

/// Removes corners that deviate from the position extrapolated from the others of their row and column.
fn drop_jumps(placed: &mut Grid) {
    loop {
        // A corner without neighbours to check it is treated like one that is off.
        let jumps = placed
            .keys()
            .map(|cell| (relative_jump(placed, *cell).unwrap_or(f64::INFINITY), *cell));
        // One at a time: a corner far off makes its neighbours look wrong too.
        let worst = jumps.max_by(|a, b| a.0.total_cmp(&b.0));
        match worst {
            Some((excess, cell)) if excess > 1.0 => placed.remove(&cell),
            _ => return,
        };
    }
}

/// Computes the distance of a corner from the position extrapolated along its row or column, whichever is nearer, as a
/// multiple of the tolerance. `None` without enough neighbours.
fn relative_jump(placed: &Grid, (c, r): Cell) -> Option<f64> {
    let here = placed[&(c, r)].at.coords;
    let along = |dc: i32, dr: i32| {
        let at = |n: i32| placed.get(&(c + n * dc, r + n * dr)).map(|saddle| saddle.at.coords);
        let spacing = at(1).or(at(-1)).map(|next| (next - here).norm())?;
        let expected = match [at(-2), at(-1), at(1), at(2)] {
            // Central prediction of fourth order: the fourth difference vanishes.
            [Some(p), Some(q), Some(s), Some(t)] => (4.0 * (q + s) - p - t) / 6.0,
            // The third difference vanishes for four equidistant points of a parabola.
            [_, Some(q), Some(s), Some(t)] => (q + 3.0 * s - t) / 3.0,
            [Some(p), Some(q), Some(s), _] => (s + 3.0 * q - p) / 3.0,
            [_, _, Some(s), Some(t)] => 3.0 * (s - t) + at(3)?,
            [Some(p), Some(q), _, _] => 3.0 * (q - p) + at(-3)?,
            _ => return None,
        };
        Some((expected - here).norm() / JUMP_PX.max(JUMP_SPACINGS * spacing))
    };
    match (along(1, 0), along(0, 1)) {
        (Some(a), Some(b)) => Some(a.min(b)),
        (a, b) => a.or(b),
    }
}

#[cfg(test)]
mod tests {
    use fabkit_camera::Point2;

    use super::super::saddle::Saddle;
    use super::*;

    fn saddle(x: f64, y: f64) -> Saddle {
        let edges = [Vector2::x(), Vector2::y()];
        Saddle { at: Point2::new(x, y), edges, contrast: 1.0, noise_px: 0.02 }
    }

    /// A grid with barrel distortion: 30 px squares shrink to 25 px towards its border.
    fn barrel() -> Grid {
        let at = |c: i32, r: i32| {
            let (x, y) = (f64::from(c) - 4.0, f64::from(r) - 2.5);
            let scale = 30.0 * (1.0 - 0.004 * (x * x + y * y));
            saddle(200.0 + scale * x, 150.0 + scale * y)
        };
        let cells = (0..9).flat_map(|c| (0..6).map(move |r| (c, r)));
        cells.map(|(c, r)| ((c, r), at(c, r))).collect()
    }

    #[test]
    fn distortion_is_no_jump() {
        let mut placed = barrel();
        drop_jumps(&mut placed);
        assert_eq!(placed.len(), 54);
    }

    #[test]
    fn single_corners_that_jump_are_dropped_and_their_neighbours_stay() {
        for cell in barrel().into_keys() {
            let mut placed = barrel();
            // More than the allowed part of the spacing and what distortion does at the ends.
            placed.get_mut(&cell).unwrap().at += Vector2::new(2.5, -2.0);
            drop_jumps(&mut placed);
            assert!(!placed.contains_key(&cell), "{cell:?}");
            assert_eq!(placed.len(), 53, "{cell:?}");
        }
    }
}
