//! Which corner of the board each corner of a grid is.

use std::collections::BTreeMap;

use fabkit_camera::Vector2;

use super::grid::{Cell, Grid};
use super::marker::Markers;
use super::{Board, BoardKind, NotFound};
use crate::image::GreyImage;

/// A checkerboard may lack this part of its corners, as long as its outline is there.
const MAY_LACK: f64 = 0.1;
/// Fewest markers that must agree on where a ChArUco board lies.
const FEWEST_MARKERS: usize = 2;
/// Corners jump from where their line puts them by at most so many pixels, or this part of the
/// spacing if that is more: distortion changes slowly from square to square.
const JUMP_PX: f64 = 1.0;
const JUMP_SPACINGS: f64 = 0.06;

/// A quarter turn, so many times.
fn turned((mut i, mut j): Cell, quarters: usize) -> Cell {
    for _ in 0..quarters {
        (i, j) = (-j, i);
    }
    (i, j)
}

/// Whether the square right of and below a corner is light, in the turned grid.
fn is_light((u, v): Cell, quarters: usize) -> bool {
    // Each quarter turn makes another of the four squares around a corner the lower right one.
    ((u + v).rem_euclid(2) == 0) == quarters.is_multiple_of(2)
}

/// The board's corners by column and row from 0.
pub(super) fn place(image: &GreyImage, board: &Board, grids: &[Grid]) -> Result<Grid, NotFound> {
    let mut placed = match board.kind {
        BoardKind::Checkerboard => checkerboard(board, grids)?,
        BoardKind::Charuco => charuco(image, board, grids)?,
    };
    drop_jumps(&mut placed);
    Ok(placed)
}

fn checkerboard(board: &Board, grids: &[Grid]) -> Result<Grid, NotFound> {
    let [columns, rows] = board.inner_corners();
    let expected = columns * rows;
    let largest = grids.first().ok_or(NotFound::NoGrid)?;
    let mut best: Option<(f64, Grid)> = None;
    for quarters in 0..4 {
        let cells = || largest.keys().map(|cell| turned(*cell, quarters));
        let least = |of: fn(Cell) -> i32| cells().map(of).min().unwrap_or(0);
        let most = |of: fn(Cell) -> i32| cells().map(of).max().unwrap_or(0);
        let (u0, v0) = (least(|c| c.0), least(|c| c.1));
        let size = [most(|c| c.0) - u0, most(|c| c.1) - v0].map(|n| n as usize + 1);
        let complete = largest.len() as f64 >= (1.0 - MAY_LACK) * expected as f64;
        // The first square is dark, and so is the one right of and below the first corner.
        if size != [columns, rows] || !complete || is_light((u0, v0), quarters) {
            continue;
        }
        let placed: Grid = largest
            .iter()
            .map(|(cell, saddle)| {
                let (u, v) = turned(*cell, quarters);
                ((u - u0, v - v0), *saddle)
            })
            .collect();
        // Of the ways that cannot be told apart, the one whose columns run most to the right.
        let to_the_right: f64 = steps(&placed).map(|step| step.normalize().x).sum();
        if best.as_ref().is_none_or(|(other, _)| to_the_right > *other) {
            best = Some((to_the_right, placed));
        }
    }
    let found = largest.len();
    best.map(|(_, placed)| placed).ok_or(NotFound::Incomplete { found, expected })
}

/// From each corner to the next in its row.
fn steps(placed: &Grid) -> impl Iterator<Item = Vector2<f64>> {
    placed
        .iter()
        .filter_map(|((c, r), saddle)| placed.get(&(c + 1, *r)).map(|next| next.at - saddle.at))
}

fn charuco(image: &GreyImage, board: &Board, grids: &[Grid]) -> Result<Grid, NotFound> {
    let markers = Markers::new(board);
    let [columns, rows] = board.inner_corners().map(|n| n as i32);
    let mut placed = Grid::new();
    let mut most_markers = 0;
    for grid in grids {
        let votes = votes(image, &markers, grid);
        let Some((shift, count)) = votes.iter().max_by_key(|(shift, count)| (**count, **shift))
        else {
            continue;
        };
        most_markers = most_markers.max(*count);
        let others: usize = votes.values().sum::<usize>() - count;
        if *count < FEWEST_MARKERS || 2 * others > *count {
            continue;
        }
        let (quarters, dc, dr) = *shift;
        for (cell, saddle) in grid {
            let (u, v) = turned(*cell, quarters);
            let cell = (u + dc, v + dr);
            if (0..columns).contains(&cell.0) && (0..rows).contains(&cell.1) {
                // Larger grids come first and are believed.
                placed.entry(cell).or_insert(*saddle);
            }
        }
    }
    match (grids.is_empty(), placed.is_empty()) {
        (true, _) => Err(NotFound::NoGrid),
        (_, true) => Err(NotFound::NoMarkers { read: most_markers, needed: FEWEST_MARKERS }),
        _ => Ok(placed),
    }
}

/// How many markers say that the grid, after so many quarter turns and a shift, is the board.
fn votes(image: &GreyImage, markers: &Markers, grid: &Grid) -> BTreeMap<(usize, i32, i32), usize> {
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
        // The marker's upper left corner is the upper left one of the turned grid too.
        let (u, v) = turned(cells[(4 - quarters) % 4], quarters);
        // The first corner is the upper left one of square [1, 1].
        let shift = (quarters, column as i32 - 1 - u, row as i32 - 1 - v);
        *votes.entry(shift).or_insert(0) += 1;
    }
    votes
}

/// Removes corners that lie beside where the others of their row and of their column put them.
fn drop_jumps(placed: &mut Grid) {
    loop {
        // A corner that nothing vouches for is no better than one that is off.
        let jumps = placed.keys().map(|cell| (jump(placed, *cell).unwrap_or(f64::INFINITY), *cell));
        // One at a time: a corner far off makes its neighbours look wrong too.
        let worst = jumps.max_by(|a, b| a.0.total_cmp(&b.0));
        match worst {
            Some((excess, cell)) if excess > 1.0 => placed.remove(&cell),
            _ => return,
        };
    }
}

/// Distance from where a corner's row or column puts it, whichever is nearer, in what is allowed.
fn jump(placed: &Grid, (c, r): Cell) -> Option<f64> {
    let here = placed[&(c, r)].at.coords;
    let along = |dc: i32, dr: i32| {
        let at = |n: i32| placed.get(&(c + n * dc, r + n * dr)).map(|saddle| saddle.at.coords);
        let spacing = at(1).or(at(-1)).map(|next| (next - here).norm())?;
        let expected = match [at(-2), at(-1), at(1), at(2)] {
            [Some(p), Some(q), Some(s), Some(t)] => (4.0 * (q + s) - p - t) / 6.0,
            // Through four points of a parabola the third difference is zero.
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
