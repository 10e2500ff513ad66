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

    /// Those that may be near a place.
    pub(super) fn near(&self, place: &Point3<f64>) -> impl Iterator<Item = &Peg> + Clone + use<'_> {
        let found = self.cells.get(&cell(place, self.cell_mm)).map_or(&[][..], Vec::as_slice);
        found.iter().map(|i| &self.pegs[*i as usize])
    }

    /// The first that a ray enters: how far along it, mm, and the normal there.
    pub(super) fn entry<'p>(
        &self,
        near: impl Iterator<Item = &'p Peg>,
        origin: &Point3<f64>,
        direction: &Vector3<f64>,
    ) -> Option<(f64, Vector3<f64>)> {
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
