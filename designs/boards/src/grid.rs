//! Grid of points over which tracks are routed: rings and rays on an annular board, rows and columns elsewhere.

use std::f64::consts::TAU;

use crate::BoardShape;
use crate::shapes::{Point, Shape};

/// Finest distance between neighbouring points, mm. Large boards get a coarser grid, so that the number of points
/// stays bounded.
const MIN_STEP_MM: f64 = 0.1;
/// Approximate maximum number of points of a grid.
const MAX_POINTS: f64 = 40_000.0;
/// Edge length of the cells in which points are looked up, mm.
const CELL_MM: f64 = 1.0;

/// Points with their neighbours.
pub(crate) struct Grid {
    /// Positions of the points, mm.
    pub points: Vec<Point>,
    /// Number of rows: rings or lines.
    rows: usize,
    /// Number of points per row.
    columns: usize,
    /// Whether rows are closed rings.
    is_annular: bool,
    /// Longest distance between two neighbours, mm.
    pub step_mm: f64,
    low: Point,
    cells: [usize; 2],
    cell_points: Vec<Vec<u32>>,
}

impl Grid {
    /// Covers a board with points.
    pub fn new(board: &BoardShape) -> Self {
        let [low, high] = Shape::polygon(board.edge.clone()).bounds();
        let area = (high[0] - low[0]) * (high[1] - low[1]);
        let step = MIN_STEP_MM.max((area / MAX_POINTS).sqrt());
        let (points, rows, columns, is_annular) = match board.annulus_mm() {
            Some([inner, outer]) => {
                let rows = ((outer - inner) / step) as usize + 1;
                // A multiple of eight, because LEDs stand at such angles.
                let columns = ((TAU * outer / step / 8.0).ceil() as usize) * 8;
                let at = |i: usize| {
                    let (row, column) = (i / columns, i % columns);
                    let radius = inner + step * row as f64;
                    let angle = TAU * column as f64 / columns as f64;
                    [radius * angle.cos(), radius * angle.sin()]
                };
                ((0..rows * columns).map(at).collect::<Vec<_>>(), rows, columns, true)
            }
            None => {
                let middle = [0, 1].map(|axis| (low[axis] + high[axis]) / 2.0);
                let half = [0, 1].map(|axis| ((high[axis] - low[axis]) / 2.0 / step) as usize);
                let [columns, rows] = half.map(|half| 2 * half + 1);
                let at = |i: usize| {
                    let (row, column) = (i / columns, i % columns);
                    [
                        middle[0] + step * (column as f64 - half[0] as f64),
                        middle[1] + step * (row as f64 - half[1] as f64),
                    ]
                };
                ((0..rows * columns).map(at).collect::<Vec<_>>(), rows, columns, false)
            }
        };
        // Lookup table from square cells to the points in them.
        let cells = [0, 1].map(|axis| ((high[axis] - low[axis]) / CELL_MM) as usize + 1);
        let mut cell_points = vec![Vec::new(); cells[0] * cells[1]];
        for (i, p) in points.iter().enumerate() {
            let cell =
                [0, 1].map(|a| (((p[a] - low[a]) / CELL_MM).max(0.0) as usize).min(cells[a] - 1));
            cell_points[cell[1] * cells[0] + cell[0]].push(i as u32);
        }
        // Diagonal neighbours are farthest apart.
        let step_mm = step * std::f64::consts::SQRT_2;
        Self { points, rows, columns, is_annular, step_mm, low, cells, cell_points }
    }

    /// Indices of the neighbours of a point, diagonal ones included.
    pub fn neighbours(&self, index: usize) -> impl Iterator<Item = usize> + '_ {
        let (row, column) = ((index / self.columns) as i64, (index % self.columns) as i64);
        let ways = [(0, 1), (0, -1), (1, 0), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1)];
        ways.into_iter().filter_map(move |(up, along)| {
            let (row, mut column) = (row + up, column + along);
            if self.is_annular {
                column = column.rem_euclid(self.columns as i64);
            }
            let is_there =
                (0..self.rows as i64).contains(&row) && (0..self.columns as i64).contains(&column);
            is_there.then(|| row as usize * self.columns + column as usize)
        })
    }

    /// Calls `each` with every point that may be within `by_mm` of a shape. It may also pass points that are farther
    /// away.
    pub fn for_each_near(&self, shape: &Shape, by_mm: f64, mut each: impl FnMut(usize)) {
        let [low, high] = shape.bounds();
        let cell = |axis: usize, at: f64| {
            (((at - self.low[axis]) / CELL_MM).max(0.0) as usize).min(self.cells[axis] - 1)
        };
        for y in cell(1, low[1] - by_mm)..=cell(1, high[1] + by_mm) {
            for x in cell(0, low[0] - by_mm)..=cell(0, high[0] + by_mm) {
                self.cell_points[y * self.cells[0] + x].iter().for_each(|i| each(*i as usize));
            }
        }
    }
}
