//! Grid of overhanging faces: connected regions and their distance from the material that carries them.

use std::collections::BTreeSet;

/// Largest distance from the carrying edge that prints without support, mm.
const LEDGE_MM: f64 = 3.0;

/// Depth below a face at which carrying material is searched, mm.
const LOWER_MM: f64 = 0.01;

/// Intersections of one vertical line.
#[derive(Default)]
pub(super) struct Column {
    /// Intervals inside the part, mm.
    pub(super) inside: Vec<[f64; 2]>,
    /// Faces that lean too far.
    pub(super) down: Vec<OverhangFace>,
}

impl Column {
    /// Returns whether it has material that carries an overhang beside it at height `z_mm`.
    fn carries(&self, z_mm: f64) -> bool {
        self.inside.iter().any(|[low, high]| (*low..*high).contains(&(z_mm - LOWER_MM)))
    }
}

/// A downward face at its intersection with a line.
#[derive(Clone, Copy)]
pub(super) struct OverhangFace {
    pub(super) z_mm: f64,
    /// Inclination from the vertical, degrees.
    pub(super) lean_deg: f64,
    /// Area of the face for one line, mm2.
    pub(super) area_mm2: f64,
}

/// Connected faces that lean too far.
pub(super) struct Region {
    pub(super) area_mm2: f64,
    pub(super) steepest_deg: f64,
    /// Column and height of a face that is farther from its carrier than can be printed.
    pub(super) unsupported_at: Option<([usize; 2], f64)>,
    /// Gap between the carriers on either side of that face, if there are two, mm.
    pub(super) span_mm: Option<f64>,
}

/// A face of a column: the column's x and y index, and the index of the face in it.
type Place = ([usize; 2], usize);

/// Columns of a part.
pub(super) struct Grid<'a> {
    pub(super) columns: &'a [Column],
    pub(super) counts: [usize; 2],
    pub(super) cell_mm: f64,
    /// Widest gap that can be bridged, mm.
    pub(super) bridge_mm: f64,
}

impl Grid<'_> {
    fn index(&self, [x, y]: [usize; 2]) -> usize {
        y * self.counts[0] + x
    }

    fn down(&self, (at, face): Place) -> OverhangFace {
        self.columns[self.index(at)].down[face]
    }

    /// Iterates over the columns around one.
    fn around(&self, [x, y]: [usize; 2]) -> impl Iterator<Item = [usize; 2]> {
        let counts = self.counts;
        let steps = [-1, 0, 1].into_iter().flat_map(|dy| [-1, 0, 1].map(|dx| [dx, dy]));
        let place = move |[dx, dy]: [isize; 2]| {
            let (x, y) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
            ([dx, dy] != [0, 0] && x < counts[0] && y < counts[1]).then_some([x, y])
        };
        steps.filter_map(place)
    }

    /// Iterates over the faces of adjacent columns that continue a face.
    fn next(&self, place: Place) -> impl Iterator<Item = Place> {
        let z_mm = self.down(place).z_mm;
        self.around(place.0).filter_map(move |beside| {
            // A face that leans more than 45 degrees rises by less than a cell from line to line.
            let near = |down: &OverhangFace| (down.z_mm - z_mm).abs() < 1.5 * self.cell_mm;
            Some((beside, self.columns[self.index(beside)].down.iter().position(near)?))
        })
    }

    /// Groups faces of adjacent lines that continue each other.
    pub(super) fn regions(&self) -> Vec<Region> {
        let mut seen: BTreeSet<Place> = BTreeSet::new();
        let mut regions = Vec::new();
        for (index, column) in self.columns.iter().enumerate() {
            let at = [index % self.counts[0], index / self.counts[0]];
            for face in 0..column.down.len() {
                if !seen.insert((at, face)) {
                    continue;
                }
                let mut members = vec![(at, face)];
                let mut done = 0;
                while let Some(&place) = members.get(done) {
                    done += 1;
                    members.extend(self.next(place).filter(|beside| seen.insert(*beside)));
                }
                regions.push(self.region(&members));
            }
        }
        regions
    }

    /// Measures a region by spreading from its carried faces, one line per round.
    fn region(&self, members: &[Place]) -> Region {
        let is_carried = |place: &Place| {
            let z_mm = self.down(*place).z_mm;
            // Adjacent columns of the same slope do not carry it.
            let own: Vec<[usize; 2]> = self.next(*place).map(|(at, _)| at).collect();
            let mut beside = self.around(place.0).filter(|at| !own.contains(at));
            beside.any(|at| self.columns[self.index(at)].carries(z_mm))
        };
        let (mut front, rest): (Vec<Place>, Vec<Place>) =
            members.iter().copied().partition(is_carried);
        let mut left: BTreeSet<Place> = rest.into_iter().collect();
        // The edge lies on average half a cell before the first line.
        let (mut lines, mut hangs) = (0.5, None);
        while !front.is_empty() {
            if lines * self.cell_mm > LEDGE_MM {
                // A face next to a bridged one is exempt, for example at the edge of a round wall.
                let is_far = |place: &Place| {
                    !self.is_bridged(*place) && !self.next(*place).any(|at| self.is_bridged(at))
                };
                hangs = front.iter().copied().find(is_far).or(hangs);
            }
            let next = front.iter().flat_map(|place| self.next(*place));
            front = next.filter(|place| left.remove(place)).collect();
            lines += 1.0;
        }
        // Faces that the spreading never reached start in the air.
        let hangs = left.first().copied().or(hangs);
        Region {
            area_mm2: members.iter().map(|place| self.down(*place).area_mm2).sum(),
            steepest_deg: members.iter().map(|p| self.down(*p).lean_deg).fold(0.0, f64::max),
            unsupported_at: hangs.map(|place| (place.0, self.down(place).z_mm)),
            span_mm: hangs.and_then(|place| self.span_mm(place)).map(|[span, step]| span - step),
        }
    }

    /// Returns whether a face is carried on two opposite sides that are close enough to bridge.
    fn is_bridged(&self, place: Place) -> bool {
        // On either side, the carrier begins up to one line farther in.
        self.span_mm(place).is_some_and(|[span, step]| span <= self.bridge_mm + 2.0 * step)
    }

    /// Finds the narrowest gap that a face spans between two carriers, among the four directions along and between the
    /// grid's axes. Returns the distance of the carrying lines on either side and the distance between lines in that
    /// direction, mm. On average, the distance exceeds the gap by half a step on either side.
    fn span_mm(&self, place: Place) -> Option<[f64; 2]> {
        let ways: [[isize; 2]; 4] = [[1, 0], [0, 1], [1, 1], [1, -1]];
        let spans = ways.into_iter().filter_map(|[dx, dy]| {
            let there = self.to_carrier(place, [dx, dy])?;
            let back = self.to_carrier(place, [-dx, -dy])?;
            let step_mm = self.cell_mm * (dx as f64).hypot(dy as f64);
            Some([(there + back) as f64 * step_mm, step_mm])
        });
        spans.min_by(|a, b| (a[0] - 2.0 * a[1]).total_cmp(&(b[0] - 2.0 * b[1])))
    }

    /// Returns the number of lines to the carrier in a direction, if there is one.
    fn to_carrier(&self, place: Place, [dx, dy]: [isize; 2]) -> Option<usize> {
        let ([mut x, mut y], z_mm) = (place.0, self.down(place).z_mm);
        for lines in 1.. {
            (x, y) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
            if x >= self.counts[0] || y >= self.counts[1] {
                return None;
            }
            let column = &self.columns[self.index([x, y])];
            if !column.down.iter().any(|down| (down.z_mm - z_mm).abs() < 1.5 * self.cell_mm) {
                return column.carries(z_mm).then_some(lines);
            }
        }
        None
    }
}
