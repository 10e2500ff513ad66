//! Spatial index of the markers on a coat, for shadowing and visibility.

use std::collections::BTreeMap;

use fabkit_geometry::{Marker, Point3, Vector3};
use fabkit_light::RaisedMarker;
use fabkit_scene::press_simulation::MarkerDisplacement;

/// Margin of the bounding balls around markers, mm: they are built for one place and used from others very nearby.
const SLACK_MM: f64 = 0.01;

/// Markers of a coat in a grid of cells.
pub(super) struct MarkerIndex {
    pegs: Vec<RaisedMarker>,
    /// Height of the markers above the coat, mm.
    height_mm: f64,
    /// Distance beyond which markers are ignored, mm. Also the size of the grid's cells.
    reach_mm: f64,
    /// Indices of the markers in or beside each cell.
    cells: BTreeMap<[i32; 3], Vec<u32>>,
}

impl MarkerIndex {
    /// Builds the index for markers at their present places, for queries up to `reach_mm` away. Markers of unknown
    /// place are left out.
    pub(super) fn new(marks: &[MarkerDisplacement], height_mm: f64, reach_mm: f64) -> Self {
        let peg = |moved: &MarkerDisplacement| {
            let Marker { point, radius_mm, .. } = &moved.mark;
            let end = point + moved.displacement_mm?;
            Some(RaisedMarker {
                centre: end - *radius_mm * moved.axis,
                axis: moved.axis,
                radius_mm: *radius_mm,
            })
        };
        let pegs: Vec<RaisedMarker> = marks.iter().filter_map(peg).collect();
        let mut own = Self { pegs, height_mm, reach_mm, cells: BTreeMap::new() };
        for (i, peg) in own.pegs.iter().enumerate() {
            // Each marker is entered in its cell and all neighbours, so a query needs one cell only.
            let at = cell(&peg.centre, own.reach_mm);
            for k in 0..27 {
                let beside = [at[0] + k % 3 - 1, at[1] + k / 3 % 3 - 1, at[2] + k / 9 - 1];
                own.cells.entry(beside).or_default().push(i as u32);
            }
        }
        own
    }

    /// Returns the markers that may be within reach of a place.
    pub(super) fn near(&self, place: &Point3<f64>) -> impl Iterator<Item = &RaisedMarker> {
        let own = self.cells.get(&cell(place, self.reach_mm)).map_or(&[][..], Vec::as_slice);
        own.iter().map(|i| &self.pegs[*i as usize])
    }

    /// Collects bounding balls around the markers near `place`, relative to `from`, into a reused list. One list serves
    /// the queries towards many light sources.
    pub(super) fn balls(
        &self,
        place: &Point3<f64>,
        from: &Point3<f64>,
        balls: &mut Vec<BoundingBall>,
    ) {
        balls.clear();
        balls.extend(self.near(place).filter_map(|peg| {
            let way = peg.centre - 0.5 * self.height_mm * peg.axis - from;
            let radius_mm = 0.5 * self.height_mm + peg.radius_mm + SLACK_MM;
            let (square, farthest_mm) = (way.norm_squared(), self.reach_mm + radius_mm);
            let beyond = square - radius_mm * radius_mm;
            (square < farthest_mm * farthest_mm).then_some(BoundingBall {
                way,
                beyond,
                radius_mm,
                peg: *peg,
            })
        }));
    }

    /// Returns whether a marker blocks the ray from a place in a direction.
    pub(super) fn blocks(
        &self,
        balls: &[BoundingBall],
        from: &Point3<f64>,
        towards: &Vector3<f64>,
    ) -> bool {
        balls.iter().any(|ball| {
            // The ball's discriminant rejects most markers before the exact intersection.
            let along = ball.way.dot(towards);
            along > -ball.radius_mm
                && ball.beyond < along * along
                && self
                    .intersect(&ball.peg, from, towards)
                    .is_some_and(|(mm, _)| mm < self.reach_mm)
        })
    }

    /// Returns the first marker that a ray enters on its way to a place: the distance before the place, mm, and the
    /// normal.
    pub(super) fn first_hit(
        &self,
        balls: &[BoundingBall],
        place: &Point3<f64>,
        direction: &Vector3<f64>,
    ) -> Option<(f64, Vector3<f64>)> {
        let origin = place - self.reach_mm * direction;
        let on_way = balls.iter().filter(|ball| {
            let along = ball.way.dot(direction);
            along < ball.radius_mm && ball.beyond < along * along
        });
        let entries = on_way.filter_map(|ball| self.intersect(&ball.peg, &origin, direction));
        let first = entries.min_by(|a, b| a.0.total_cmp(&b.0));
        let (mm, normal) = first.filter(|(mm, _)| *mm < self.reach_mm)?;
        Some((self.reach_mm - mm, normal))
    }

    /// Intersects a ray with the part of a marker above the coat: the distance along the ray, mm, and the normal.
    fn intersect(
        &self,
        peg: &RaisedMarker,
        origin: &Point3<f64>,
        direction: &Vector3<f64>,
    ) -> Option<(f64, Vector3<f64>)> {
        let hit = peg.entry(origin, direction)?;
        // Below a marker's root there is only coat.
        let from_root = (origin + hit.at_mm * direction - peg.centre).dot(&peg.axis);
        (from_root > -self.height_mm).then_some((hit.at_mm, hit.normal))
    }
}

/// Bounding ball of the part of a marker above the coat.
pub(super) struct BoundingBall {
    /// Vector to its centre, mm.
    way: Vector3<f64>,
    /// Squared distance of the centre minus squared radius, mm2.
    beyond: f64,
    radius_mm: f64,
    peg: RaisedMarker,
}

fn cell(place: &Point3<f64>, size_mm: f64) -> [i32; 3] {
    [place.x, place.y, place.z].map(|mm| (mm / size_mm).floor() as i32)
}
