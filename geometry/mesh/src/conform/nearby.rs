//! Search for the triangles near each tool.

use fabkit_geometry::Aabb;

/// Largest number of grid cells along each axis.
const MOST_CELLS: f64 = 24.0;

/// Grid of cells with the tools' boxes, and for each tool the triangles whose boxes overlap its own.
pub(super) struct CandidateGrid {
    boxes: Vec<Aabb>,
    cells: Vec<Vec<u32>>,
    counts: [usize; 3],
    around: Aabb,
    pub triangles: Vec<Vec<u32>>,
}

impl CandidateGrid {
    pub fn new(boxes: Vec<Aabb>) -> Self {
        let around = boxes.iter().fold(Aabb::nothing(), |all, one| all.hull(one));
        let size = around.size_mm();
        let widest = boxes.iter().flat_map(Aabb::size_mm).fold(f64::MIN_POSITIVE, f64::max);
        let counts = size.map(|s| (s / widest).ceil().clamp(1.0, MOST_CELLS) as usize);
        let triangles = vec![Vec::new(); boxes.len()];
        let cells = vec![Vec::new(); counts.iter().product()];
        let mut nearby = Self { boxes, cells, counts, around, triangles };
        for tool in 0..nearby.boxes.len() {
            for cell in nearby.cells_of(&nearby.boxes[tool]).collect::<Vec<_>>() {
                nearby.cells[cell].push(tool as u32);
            }
        }
        nearby
    }

    /// Adds a triangle to every tool with an overlapping box.
    pub fn add(&mut self, triangle: u32, bounds: &Aabb) {
        if self.around.common(bounds).is_empty() {
            return;
        }
        for cell in self.cells_of(bounds).collect::<Vec<_>>() {
            for &tool in &self.cells[cell] {
                let noted = &mut self.triangles[tool as usize];
                // A triangle that covers several cells meets the same tool repeatedly.
                if noted.last() != Some(&triangle)
                    && !self.boxes[tool as usize].common(bounds).is_empty()
                {
                    noted.push(triangle);
                }
            }
        }
    }

    fn cells_of(&self, bounds: &Aabb) -> impl Iterator<Item = usize> + use<> {
        let counts = self.counts;
        let (low, size) = (self.around.min, self.around.size_mm());
        let cell = move |value: f64, axis: usize| {
            let share = (value - low[axis]) / size[axis].max(f64::MIN_POSITIVE);
            // A cast from a float saturates: points outside belong to the outermost cell.
            ((share * counts[axis] as f64) as usize).min(counts[axis] - 1)
        };
        let range = [0, 1, 2].map(|i| cell(bounds.min[i], i)..=cell(bounds.max[i], i));
        let [x, y, z] = range;
        z.flat_map(move |k| {
            let x = x.clone();
            y.clone().flat_map(move |j| {
                let row = (k * counts[1] + j) * counts[0];
                x.clone().map(move |i| row + i)
            })
        })
    }
}
