//! Marks on a coat, found quickly.

use std::collections::BTreeMap;

use fabkit_geometry::{Mark, Point3, Vector3};
use fabkit_light::Peg;
use fabkit_scene::pressing::Moved;

/// Balls around pegs are larger by this, mm: places that are looked at from are a hair beside each other.
const SLACK_MM: f64 = 0.01;

/// Where marks of a coat are, and what they are.
pub(super) struct Pegs {
    pegs: Vec<Peg>,
    /// How far they stand out of the coat, mm.
    height_mm: f64,
    /// Farther off nothing is asked of them, mm.
    reach_mm: f64,
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
        let mut own = Self { pegs, height_mm, reach_mm, cells: BTreeMap::new() };
        for (i, peg) in own.pegs.iter().enumerate() {
            let at = cell(&peg.centre, own.reach_mm);
            for k in 0..27 {
                let beside = [at[0] + k % 3 - 1, at[1] + k / 3 % 3 - 1, at[2] + k / 9 - 1];
                own.cells.entry(beside).or_default().push(i as u32);
            }
        }
        own
    }

    /// Those of which anything may be within reach of a place.
    pub(super) fn near(&self, place: &Point3<f64>) -> impl Iterator<Item = &Peg> {
        let own = self.cells.get(&cell(place, self.reach_mm)).map_or(&[][..], Vec::as_slice);
        own.iter().map(|i| &self.pegs[*i as usize])
    }

    /// Balls around what stands out of the coat near a place, as seen from there or from nearby, into a list that is used
    /// again: a place asks about many lamps.
    pub(super) fn balls(&self, place: &Point3<f64>, from: &Point3<f64>, balls: &mut Vec<Ball>) {
        balls.clear();
        balls.extend(self.near(place).filter_map(|peg| {
            let way = peg.centre - 0.5 * self.height_mm * peg.axis - from;
            let radius_mm = 0.5 * self.height_mm + peg.radius_mm + SLACK_MM;
            let (square, farthest_mm) = (way.norm_squared(), self.reach_mm + radius_mm);
            let beyond = square - radius_mm * radius_mm;
            (square < farthest_mm * farthest_mm).then_some(Ball {
                way,
                beyond,
                radius_mm,
                peg: *peg,
            })
        }));
    }

    /// Whether any of them hides what lies there.
    pub(super) fn hide(&self, balls: &[Ball], from: &Point3<f64>, towards: &Vector3<f64>) -> bool {
        balls.iter().any(|ball| {
            let along = ball.way.dot(towards);
            along > -ball.radius_mm
                && ball.beyond < along * along
                && self.entry(&ball.peg, from, towards).is_some_and(|(mm, _)| mm < self.reach_mm)
        })
    }

    /// What a ray that would arrive at a place enters first: how far before it, mm, and the normal there.
    pub(super) fn before(
        &self,
        balls: &[Ball],
        place: &Point3<f64>,
        direction: &Vector3<f64>,
    ) -> Option<(f64, Vector3<f64>)> {
        let origin = place - self.reach_mm * direction;
        let on_way = balls.iter().filter(|ball| {
            let along = ball.way.dot(direction);
            along < ball.radius_mm && ball.beyond < along * along
        });
        let entries = on_way.filter_map(|ball| self.entry(&ball.peg, &origin, direction));
        let first = entries.min_by(|a, b| a.0.total_cmp(&b.0));
        let (mm, normal) = first.filter(|(mm, _)| *mm < self.reach_mm)?;
        Some((self.reach_mm - mm, normal))
    }

    /// Where a ray enters what of a peg stands out of the coat: how far along it, mm, and the normal there.
    fn entry(
        &self,
        peg: &Peg,
        origin: &Point3<f64>,
        direction: &Vector3<f64>,
    ) -> Option<(f64, Vector3<f64>)> {
        let hit = peg.entry(origin, direction)?;
        // Behind its root there is the coat.
        let from_root = (origin + hit.at_mm * direction - peg.centre).dot(&peg.axis);
        (from_root > -self.height_mm).then_some((hit.at_mm, hit.normal))
    }
}

/// Around what of a peg stands out of the coat.
pub(super) struct Ball {
    /// To its middle, mm.
    way: Vector3<f64>,
    /// The square of how far that is, less the square of its radius.
    beyond: f64,
    radius_mm: f64,
    peg: Peg,
}

fn cell(place: &Point3<f64>, size_mm: f64) -> [i32; 3] {
    [place.x, place.y, place.z].map(|mm| (mm / size_mm).floor() as i32)
}
