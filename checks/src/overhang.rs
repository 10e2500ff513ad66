//! Where printed parts hang over: what a printer must support from below.
//!
//! Lines upwards through a part as it lies on the bed find every face that looks down; neighbours that
//! lean too far are one region. What is near to where the part carries it prints as a bridge or a ledge;
//! what is far must be supported, and the part's notes should say so.

use std::collections::BTreeSet;

use fabkit_geometry::{
    Body, CompiledSolid, Point3, Process, Ray, Sensor, Vector3, without_letters,
};
use rayon::prelude::*;

use crate::finding::{Finding, Rule, Severity};
use crate::lines::Caster;
use crate::scene::InvalidBody;

/// Steepest overhang of usual filament printers without support, from the vertical, degrees. Resin is
/// supported wherever it lies, by whoever slices it.
const USUAL_DEG: f64 = 45.0;

/// What is drawn at a limit keeps it, degrees.
const ROUNDING_DEG: f64 = 0.5;

/// Lines across the longer side of a part.
const ACROSS: f64 = 72.0;

/// What stands out no farther than this from where the part carries it prints by itself, mm.
const LEDGE_MM: f64 = 3.0;

/// What is carried on both sides of a gap no wider than this prints by itself, mm: short bridges.
const BRIDGE_MM: f64 = 10.0;

/// What is so much lower carries, mm.
const LOWER_MM: f64 = 0.01;

/// What is lower than this lies on the bed, mm.
const ON_BED_MM: f64 = 0.05;

/// The steepest overhang that a part's process makes without support, from the vertical, degrees.
fn limit_deg(part: &Body) -> Option<f64> {
    let own = part.machine.as_ref().and_then(|machine| machine.overhang_deg);
    own.or((part.process() == Some(Process::Fdm)).then_some(USUAL_DEG))
}

/// Applies the rule; the second figure is how many parts it looked at.
pub(crate) fn examine(kit: &Sensor) -> Result<(Vec<Finding>, usize), InvalidBody> {
    let printed: Vec<(&Body, f64)> =
        kit.parts().filter_map(|part| Some((part, limit_deg(part)?))).collect();
    let found: Vec<Option<Finding>> = printed
        .par_iter()
        .map(|(part, limit_deg)| of_part(part, *limit_deg))
        .collect::<Result<_, _>>()?;
    Ok((found.into_iter().flatten().collect(), printed.len()))
}

/// What a line met.
#[derive(Default)]
struct Column {
    /// From where to where it is inside the part, mm.
    inside: Vec<[f64; 2]>,
    /// The faces that lean too far.
    down: Vec<Down>,
}

impl Column {
    /// Whether it carries what hangs over beside it at a height.
    fn carries(&self, z_mm: f64) -> bool {
        self.inside.iter().any(|[low, high]| (*low..*high).contains(&(z_mm - LOWER_MM)))
    }
}

/// A face that looks down, where a line met it.
#[derive(Clone, Copy)]
struct Down {
    z_mm: f64,
    /// From the vertical, degrees.
    lean_deg: f64,
    /// Of the face, for one line, mm2.
    area_mm2: f64,
}

/// Neighbouring faces that lean too far.
struct Region {
    area_mm2: f64,
    steepest_deg: f64,
    /// Where it is farther from what carries it than any that prints by itself.
    hangs: Option<([usize; 2], f64)>,
}

fn of_part(part: &Body, limit_deg: f64) -> Result<Option<Finding>, InvalidBody> {
    let invalid = |source| InvalidBody { body: part.name.clone(), source };
    let on_bed = without_letters(&part.solid).placed(part.bed_from_body);
    let body = CompiledSolid::new(&on_bed).map_err(invalid)?;
    let bounds = body.bounds();
    if bounds.is_empty() || !bounds.is_finite() {
        return Ok(None);
    }
    let size = bounds.max - bounds.min;
    let cell_mm = size.x.max(size.y) / ACROSS;
    // Off the middles, so that no line runs along a face of an ordinary part.
    let at = |axis: usize, index: usize| bounds.min[axis] + (index as f64 + 0.4721) * cell_mm;
    let counts = [0, 1].map(|axis| (size[axis] / cell_mm).ceil().max(1.0) as usize);
    let mut caster = Caster::default();
    let mut grid: Vec<Column> = Vec::with_capacity(counts[0] * counts[1]);
    for y in 0..counts[1] {
        for x in 0..counts[0] {
            let origin = Point3::new(at(0, x), at(1, y), bounds.min.z - 1.0);
            let ray = Ray { origin, direction: Vector3::z() };
            let mut column = Column::default();
            for stretch in caster.stretches(&body, &ray) {
                let [z_mm, top_mm] = [stretch.enter.t, stretch.exit.t].map(|t| ray.at(t).z);
                column.inside.push([z_mm, top_mm]);
                let looks_down = -stretch.enter.normal.z;
                let lean_deg = looks_down.clamp(-1.0, 1.0).asin().to_degrees();
                if lean_deg > limit_deg + ROUNDING_DEG && z_mm > bounds.min.z + ON_BED_MM {
                    let area_mm2 = cell_mm * cell_mm / looks_down;
                    column.down.push(Down { z_mm, lean_deg, area_mm2 });
                }
            }
            grid.push(column);
        }
    }
    let regions = Grid { columns: &grid, counts, cell_mm }.regions();
    let hanging = regions.iter().filter_map(|region| Some((region, region.hangs?)));
    let largest = hanging.clone().max_by(|a, b| a.0.area_mm2.total_cmp(&b.0.area_mm2));
    let Some((_, ([x, y], z_mm))) = largest else { return Ok(None) };
    if says_supports(part) {
        return Ok(None);
    }
    let area_mm2: f64 = hanging.clone().map(|(region, _)| region.area_mm2).sum();
    let steepest = hanging.map(|(region, _)| region.steepest_deg).fold(0.0, f64::max);
    let place = Point3::new(at(0, x), at(1, y), z_mm);
    let by = part.machine.as_ref().map_or_else(|| part.process_word(), |own| own.name.clone());
    let message = format!(
        "{} needs supports: {area_mm2:.0} mm2 hang over by up to {steepest:.0} deg, and {by} prints \
         {limit_deg:.0} deg without",
        part.name
    );
    let fix = "print it with supports, or with another process";
    Ok(Some(
        Finding::error(Rule::Overhang, message, fix)
            .with_severity(Severity::Note)
            .of([part.name.as_str()])
            .at(Some(part.bed_from_body.inverse().point(place)))
            .measured(steepest, limit_deg, "deg"),
    ))
}

/// Whether the part's notes tell of supports, or of a bridge, already.
fn says_supports(part: &Body) -> bool {
    part.notes.iter().any(|note| {
        let denied = ["no support", "without support", "not need support", "no supports"];
        let note = denied.iter().fold(note.to_lowercase(), |note, word| note.replace(word, ""));
        note.contains("support") || note.contains("bridge")
    })
}

/// One face of a column: which column, and which of its faces.
type Place = ([usize; 2], usize);

/// The columns of a part.
struct Grid<'a> {
    columns: &'a [Column],
    counts: [usize; 2],
    cell_mm: f64,
}

impl Grid<'_> {
    fn index(&self, [x, y]: [usize; 2]) -> usize {
        y * self.counts[0] + x
    }

    fn down(&self, (at, face): Place) -> Down {
        self.columns[self.index(at)].down[face]
    }

    /// The columns around one.
    fn around(&self, [x, y]: [usize; 2]) -> impl Iterator<Item = [usize; 2]> {
        let counts = self.counts;
        let steps = [-1, 0, 1].into_iter().flat_map(|dy| [-1, 0, 1].map(|dx| [dx, dy]));
        let place = move |[dx, dy]: [isize; 2]| {
            let (x, y) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
            ([dx, dy] != [0, 0] && x < counts[0] && y < counts[1]).then_some([x, y])
        };
        steps.filter_map(place)
    }

    /// The faces that a face goes on in.
    fn next(&self, place: Place) -> impl Iterator<Item = Place> {
        let z_mm = self.down(place).z_mm;
        self.around(place.0).filter_map(move |beside| {
            // What leans farther than 45 degrees rises by less than a cell from line to line.
            let near = |down: &Down| (down.z_mm - z_mm).abs() < 1.5 * self.cell_mm;
            Some((beside, self.columns[self.index(beside)].down.iter().position(near)?))
        })
    }

    /// Groups faces of neighbouring lines that pass into each other.
    fn regions(&self) -> Vec<Region> {
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

    /// What is known of a region: how far it is from what carries it, line by line.
    fn region(&self, members: &[Place]) -> Region {
        let is_carried = |place: &Place| {
            let z_mm = self.down(*place).z_mm;
            // A slope does not carry itself.
            let own: Vec<[usize; 2]> = self.next(*place).map(|(at, _)| at).collect();
            let mut beside = self.around(place.0).filter(|at| !own.contains(at));
            beside.any(|at| self.columns[self.index(at)].carries(z_mm))
        };
        let (mut front, rest): (Vec<Place>, Vec<Place>) =
            members.iter().copied().partition(is_carried);
        let mut left: BTreeSet<Place> = rest.into_iter().collect();
        let (mut lines, mut hangs) = (0.5, None);
        while !front.is_empty() {
            if lines * self.cell_mm > LEDGE_MM {
                // Beside a bridge, at the edge of a round wall, the next line counts.
                let is_far = |place: &Place| {
                    !self.is_bridged(*place) && !self.next(*place).any(|at| self.is_bridged(at))
                };
                hangs = front.iter().copied().find(is_far).or(hangs);
            }
            let next = front.iter().flat_map(|place| self.next(*place));
            front = next.filter(|place| left.remove(place)).collect();
            lines += 1.0;
        }
        // Nothing carries what begins in the air.
        let hangs = left.first().copied().or(hangs);
        Region {
            area_mm2: members.iter().map(|place| self.down(*place).area_mm2).sum(),
            steepest_deg: members.iter().map(|p| self.down(*p).lean_deg).fold(0.0, f64::max),
            hangs: hangs.map(|place| (place.0, self.down(place).z_mm)),
        }
    }

    /// Whether a face is carried on two opposite sides that are near to each other.
    fn is_bridged(&self, place: Place) -> bool {
        let ways: [[isize; 2]; 4] = [[1, 0], [0, 1], [1, 1], [1, -1]];
        ways.into_iter().any(|[dx, dy]| {
            let lines = [[dx, dy], [-dx, -dy]].map(|way| self.to_carrier(place, way));
            let [Some(there), Some(back)] = lines else { return false };
            let step_mm = self.cell_mm * (dx as f64).hypot(dy as f64);
            // What carries begins up to a line farther in, on either side.
            (there + back) as f64 * step_mm <= BRIDGE_MM + 2.0 * step_mm
        })
    }

    /// How many lines away it is carried in a direction, if at all.
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

#[cfg(test)]
mod tests {
    use fabkit_geometry::{Angle, Machine, Pose, Solid};

    use super::*;

    fn found(part: Body) -> Option<Finding> {
        let limit_deg = limit_deg(&part)?;
        of_part(&part, limit_deg).unwrap()
    }

    fn fdm(solid: Solid) -> Body {
        Body::made("part", "a part", Process::Fdm, solid)
    }

    #[test]
    fn what_hangs_over_is_measured() {
        // A hat of radius 15 on a stem of radius 4: a ring that is 11 mm wide.
        let hat = || {
            Solid::union([
                Solid::cylinder(4.0, 12.0),
                Solid::cylinder(15.0, 3.0).at(0.0, 0.0, 11.0),
            ])
        };
        let ring_mm2 = std::f64::consts::PI * (15.0f64.powi(2) - 4.0f64.powi(2));
        let hangs = found(fdm(hat())).unwrap();
        assert_eq!((hangs.rule, hangs.severity), (Rule::Overhang, Severity::Note));
        let told: f64 =
            hangs.message.split_whitespace().find_map(|word| word.parse().ok()).expect("an area");
        // Cells of 30 / 72 mm along both edges of the ring, half of them wrong at worst.
        let off_mm2 = 0.5 * (30.0 / ACROSS) * std::f64::consts::TAU * 19.0;
        assert!((told - ring_mm2).abs() < off_mm2, "{told} {ring_mm2}");
        assert!((hangs.place.unwrap().z - 11.0).abs() < 1e-9, "{hangs:?}");
        assert!((hangs.measured.unwrap().value - 90.0).abs() < 1e-6);
        // Notes that tell of supports are believed, and those that deny them are not.
        assert!(found(fdm(hat()).note("supports below the brim")).is_none());
        assert!(found(fdm(hat()).note("print it as it lies, no supports")).is_some());
        // On its head nothing hangs over.
        let half = Angle::from_deg(180.0).unwrap();
        assert!(found(fdm(hat()).lying(Pose::rotation_x(half))).is_none());
        // Resin is supported anyway, until somebody says how far it hangs over.
        assert!(found(fdm(hat()).made_by(Process::Sla)).is_none());
        let mut resin = fdm(hat()).made_by(Process::Sla);
        resin.machine =
            Some(Machine { name: "own".into(), overhang_deg: Some(60.0), ..Machine::default() });
        assert!(found(resin).unwrap().message.contains("own prints 60 deg"));
    }

    #[test]
    fn cones_hang_over_where_they_are_flatter_than_the_limit() {
        // From radius 2 to 22 within a height.
        let cone = |height_mm: f64, limit_deg: f64| {
            let outline = [[0.0, 0.0], [2.0, 0.0], [22.0, height_mm], [0.0, height_mm]];
            let solid = Solid::revolution(fabkit_geometry::Path::polygon(&outline));
            let mut part = fdm(solid);
            let overhang_deg = Some(limit_deg);
            part.machine = Some(Machine { name: "own".into(), overhang_deg, ..Machine::default() });
            found(part)
        };
        // At 45 degrees, and at 59.
        assert!(cone(20.0, 45.0).is_none());
        let flat = cone(12.0, 45.0).unwrap();
        let lean_deg = (20.0f64 / 12.0).atan().to_degrees();
        assert!((flat.measured.unwrap().value - lean_deg).abs() < 1e-9, "{flat:?}");
        assert!(cone(12.0, 60.0).is_none());
    }

    #[test]
    fn bridges_and_ledges_print_by_themselves() {
        let tunnel = |width_mm: f64| {
            let hole = Solid::cuboid(width_mm, 40.0, 6.0).at(0.0, 0.0, -1.0);
            fdm(Solid::cuboid(30.0, 30.0, 10.0).minus(hole))
        };
        assert!(found(tunnel(8.0)).is_none());
        assert!(found(tunnel(14.0)).is_some());
        assert!(found(tunnel(14.0).note("no supports: its roof is a bridge")).is_none());
        // A ledge is carried on one side alone.
        let ledge = |out_mm: f64| {
            let wall = Solid::cuboid(10.0, 30.0, 12.0);
            let tooth = Solid::cuboid_between([4.0, -15.0, 8.0], [5.0 + out_mm, 15.0, 12.0]);
            fdm(Solid::union([wall, tooth]))
        };
        assert!(found(ledge(2.5)).is_none());
        assert!(found(ledge(4.5)).is_some());
        // Nothing carries what begins in the air, however small it is.
        let gate = |tooth: Option<Solid>| {
            let post = |x: f64| Solid::cuboid(3.0, 6.0, 11.0).at(x, 0.0, 0.0);
            let bar = Solid::cuboid(11.0, 6.0, 4.0).at(0.0, 0.0, 10.0);
            fdm(Solid::union([post(-4.0), post(4.0), bar].into_iter().chain(tooth)))
        };
        assert!(found(gate(None)).is_none());
        assert!(found(gate(Some(Solid::cuboid(1.5, 1.5, 3.0).at(0.0, 0.0, 8.0)))).is_some());
    }
}
