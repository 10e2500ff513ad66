//! Marks on a coat, found quickly.

use std::collections::BTreeMap;

use fabkit_geometry::{Mark, Point3, Vector3};
use fabkit_light::Peg;

use crate::pressing::Moved;

/// Where marks of a coat are, and what they are.
pub(super) struct Pegs {
    pegs: Vec<Peg>,
    /// How far they stand out of the coat, mm.
    height_mm: f64,
    cell_mm: f64,
    /// Those that are near any place of a cell.
    cells: BTreeMap<[i32; 3], Vec<u32>>,
}

impl Pegs {
    /// Of marks where they are now, for places up to `reach_mm` beside them; those of unknown place are left out.
    pub(super) fn of(marks: &[Moved], height_mm: f64, reach_mm: f64) -> Self {
        let peg = |moved: &Moved| {
            let Mark { point, radius_mm, .. } = &moved.mark;
            let end = point + moved.displacement_mm?;
            Some(Peg {
                centre: end - *radius_mm * moved.axis,
                axis: moved.axis,
                radius_mm: *radius_mm,
            })
        };
        let pegs: Vec<Peg> = marks.iter().filter_map(peg).collect();
        let mut own = Self { pegs, height_mm, cell_mm: reach_mm, cells: BTreeMap::new() };
        for (i, peg) in own.pegs.iter().enumerate() {
            let at = cell(&peg.centre, own.cell_mm);
            for k in 0..27 {
                let beside = [at[0] + k % 3 - 1, at[1] + k / 3 % 3 - 1, at[2] + k / 9 - 1];
                own.cells.entry(beside).or_default().push(i as u32);
            }
        }
        own
    }

    /// Those of which anything is within reach of a place, by number, into a list that is used again.
    pub(super) fn near(&self, place: &Point3<f64>, found: &mut Vec<u32>) {
        found.clear();
        let own = self.cells.get(&cell(place, self.cell_mm)).map_or(&[][..], Vec::as_slice);
        found.extend(own.iter().filter(|i| {
            let peg = &self.pegs[**i as usize];
            let reach_mm = self.cell_mm + self.height_mm + peg.radius_mm;
            (peg.centre - place).norm_squared() < reach_mm * reach_mm
        }));
    }

    /// One of them.
    pub(super) fn peg(&self, number: u32) -> &Peg {
        &self.pegs[number as usize]
    }

    /// The first that a ray enters: how far along it, mm, and the normal there.
    pub(super) fn entry(
        &self,
        near: &[u32],
        origin: &Point3<f64>,
        direction: &Vector3<f64>,
    ) -> Option<(f64, Vector3<f64>)> {
        let near = near.iter().map(|i| self.peg(*i));
        let near = near.filter(|peg| peg.is_near(origin, direction, self.height_mm));
        let entries = near.filter_map(|peg| {
            let hit = peg.entry(origin, direction)?;
            // Behind its root there is the coat.
            let from_root = (origin + hit.at_mm * direction - peg.centre).dot(&peg.axis);
            (from_root > -self.height_mm).then_some((hit.at_mm, hit.normal))
        });
        entries.min_by(|a, b| a.0.total_cmp(&b.0))
    }
}

fn cell(place: &Point3<f64>, size_mm: f64) -> [i32; 3] {
    [place.x, place.y, place.z].map(|mm| (mm / size_mm).floor() as i32)
}
