//! Where printed parts hang over: what a printer must support from below.
//!
//! Lines upwards through a part as it lies on the bed find every face that looks down; neighbours that
//! lean too far are one region. What is narrow prints as a bridge or a ledge; what is wide must be
//! supported, and the part's notes should say so.

use fabkit_geometry::{Body, CompiledSolid, Point3, Process, Ray, Sensor, Vector3};
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

/// What is not farther than this from both of its sides is bridged, or stands out by itself, mm.
const BRIDGED_MM: f64 = 3.0;

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
    /// How far its inside is from its edge, mm.
    depth_mm: f64,
    middle: [usize; 2],
    z_mm: f64,
}

fn of_part(part: &Body, limit_deg: f64) -> Result<Option<Finding>, InvalidBody> {
    let invalid = |source| InvalidBody { body: part.name.clone(), source };
    let on_bed = part.solid.clone().placed(part.bed_from_body);
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
    let mut grid: Vec<Vec<Down>> = Vec::with_capacity(counts[0] * counts[1]);
    for y in 0..counts[1] {
        for x in 0..counts[0] {
            let origin = Point3::new(at(0, x), at(1, y), bounds.min.z - 1.0);
            let ray = Ray { origin, direction: Vector3::z() };
            let down = caster.stretches(&body, &ray).filter_map(|stretch| {
                let z_mm = ray.at(stretch.enter.t).z;
                let looks_down = -stretch.enter.normal.z;
                let lean_deg = looks_down.clamp(-1.0, 1.0).asin().to_degrees();
                let hangs = lean_deg > limit_deg + ROUNDING_DEG && z_mm > bounds.min.z + ON_BED_MM;
                let area_mm2 = cell_mm * cell_mm / looks_down;
                hangs.then_some(Down { z_mm, lean_deg, area_mm2 })
            });
            grid.push(down.collect());
        }
    }
    let regions = regions(&grid, counts, cell_mm);
    let wide: Vec<&Region> = regions.iter().filter(|region| region.depth_mm > BRIDGED_MM).collect();
    let Some(largest) = wide.iter().max_by(|a, b| a.area_mm2.total_cmp(&b.area_mm2)) else {
        return Ok(None);
    };
    if says_supports(part) {
        return Ok(None);
    }
    let area_mm2: f64 = wide.iter().map(|region| region.area_mm2).sum();
    let steepest = wide.iter().map(|region| region.steepest_deg).fold(0.0, f64::max);
    let place = Point3::new(at(0, largest.middle[0]), at(1, largest.middle[1]), largest.z_mm);
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

/// Whether the part's notes tell of supports already.
fn says_supports(part: &Body) -> bool {
    part.notes.iter().any(|note| {
        let denied = ["no support", "without support", "not need support", "no supports"];
        let note = denied.iter().fold(note.to_lowercase(), |note, word| note.replace(word, ""));
        note.contains("support")
    })
}

/// Groups faces of neighbouring lines that pass into each other.
fn regions(grid: &[Vec<Down>], counts: [usize; 2], cell_mm: f64) -> Vec<Region> {
    let around = |[x, y]: [usize; 2]| {
        let steps = [-1isize, 0, 1];
        let places = steps.into_iter().flat_map(move |dy| steps.map(|dx| (dx, dy)));
        places.filter(|step| *step != (0, 0)).map(move |(dx, dy)| {
            let (x, y) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
            (x < counts[0] && y < counts[1]).then_some([x, y])
        })
    };
    // Faces that lean farther than 45 degrees rise by less than a cell from line to line.
    let next = |place: [usize; 2], z_mm: f64| {
        let column = &grid[place[1] * counts[0] + place[0]];
        column.iter().position(|down| (down.z_mm - z_mm).abs() < 1.5 * cell_mm)
    };
    let mut seen: Vec<Vec<bool>> = grid.iter().map(|column| vec![false; column.len()]).collect();
    let mut regions = Vec::new();
    for start in 0..grid.len() {
        for layer in 0..grid[start].len() {
            if std::mem::replace(&mut seen[start][layer], true) {
                continue;
            }
            let mut members = vec![([start % counts[0], start / counts[0]], layer)];
            let mut done = 0;
            while let Some(&(place, layer)) = members.get(done) {
                done += 1;
                let z_mm = grid[place[1] * counts[0] + place[0]][layer].z_mm;
                for beside in around(place).flatten() {
                    let Some(layer) = next(beside, z_mm) else { continue };
                    let index = beside[1] * counts[0] + beside[0];
                    if !std::mem::replace(&mut seen[index][layer], true) {
                        members.push((beside, layer));
                    }
                }
            }
            regions.push(region(grid, counts, cell_mm, &members));
        }
    }
    regions
}

/// What is known of a region: its depth by peeling it line by line from its edge.
fn region(
    grid: &[Vec<Down>],
    counts: [usize; 2],
    cell_mm: f64,
    members: &[([usize; 2], usize)],
) -> Region {
    let down = |(place, layer): &([usize; 2], usize)| grid[place[1] * counts[0] + place[0]][*layer];
    let mut inside = vec![false; grid.len()];
    for ([x, y], _) in members {
        inside[y * counts[0] + x] = true;
    }
    let mut left: Vec<[usize; 2]> = members.iter().map(|(place, _)| *place).collect();
    left.sort_unstable();
    left.dedup();
    let (mut middle, mut peels) = (left[0], 0);
    while !left.is_empty() {
        middle = left[left.len() / 2];
        peels += 1;
        let is_edge = |[x, y]: &[usize; 2]| {
            let (x, y) = (*x, *y);
            let on_rim = x == 0 || y == 0 || x + 1 == counts[0] || y + 1 == counts[1];
            on_rim
                || [[x - 1, y], [x + 1, y], [x, y - 1], [x, y + 1]]
                    .iter()
                    .any(|[x, y]| !inside[y * counts[0] + x])
        };
        let (edge, rest): (Vec<_>, Vec<_>) = left.into_iter().partition(is_edge);
        for [x, y] in edge {
            inside[y * counts[0] + x] = false;
        }
        left = rest;
    }
    let at_middle = members.iter().find(|(place, _)| *place == middle).map(down);
    Region {
        area_mm2: members.iter().map(|member| down(member).area_mm2).sum(),
        steepest_deg: members.iter().map(|member| down(member).lean_deg).fold(0.0, f64::max),
        depth_mm: (peels as f64 - 0.5) * cell_mm,
        middle,
        z_mm: at_middle.map_or(0.0, |down| down.z_mm),
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
        assert!(found(tunnel(5.0)).is_none());
        assert!(found(tunnel(12.0)).is_some());
    }
}
