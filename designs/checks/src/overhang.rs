//! Overhangs of printed parts, which a printer must support from below.
//!
//! Vertical lines through a part on the bed find every face that points down. Adjacent faces that lean too far form a
//! region. Faces near the edge where the part carries them print as a ledge, and faces between two walls print as a
//! bridge, if the process can span the gap. The rest must be supported, and the part's notes should say so.

mod grid;

use fabkit_geometry::{
    Body, CompiledSolid, Point3, Process, Ray, Sensor, Vector3, without_lettering,
};
use rayon::prelude::*;

use crate::finding::{Finding, Severity};
use crate::sampling_lines::Caster;
use crate::scene::InvalidBody;

use crate::declaration::rule;
use crate::rule::Rule;
use crate::rule_input::{RuleInput, RuleResult};
use grid::{Column, Grid, OverhangFace, Region};

rule! {
    /// Overhangs that need supports are noted on the part.
    Overhang = "overhang",
    examines: "printed parts",
    finds: "overhangs of a printed part as it lies on the bed",
    limit: "sampled in columns, 72 across",
    for_variants: false,
    look: apply,
}

fn apply(case: &RuleInput<'_>) -> RuleResult {
    examine(case.sensor)
}

/// Steepest overhang that usual filament printers print without support, from the vertical, degrees. Resin parts have
/// no such limit: whoever slices them supports them anyway.
const USUAL_DEG: f64 = 45.0;

/// Tolerance, so that a face drawn exactly at the limit passes, degrees.
const ROUNDING_DEG: f64 = 0.5;

/// Number of lines across the longer side of a part.
const ACROSS: f64 = 72.0;

/// Widest gap that usual filament printers bridge without visible sagging, mm. Other processes cannot bridge: their
/// material does not harden in the air.
const BRIDGE_MM: f64 = 10.0;

/// Height below which a face lies on the bed, mm.
const ON_BED_MM: f64 = 0.05;

/// Limits of a part's process without support.
#[derive(Clone, Copy)]
struct Limits {
    /// Steepest overhang, from the vertical, degrees.
    lean_deg: f64,
    /// Widest gap that can be bridged, mm.
    bridge_mm: f64,
}

impl Limits {
    /// Returns the limits; `None` if the process needs no note about supports and no machine states a limit.
    fn for_part(part: &Body) -> Option<Self> {
        let machine = part.machine.as_ref();
        // Usual limits exist only for filament.
        let usual = |figure: f64| (part.process() == Some(Process::Fdm)).then_some(figure);
        let lean_deg = machine.and_then(|own| own.overhang_deg).or(usual(USUAL_DEG))?;
        let bridge_mm = machine.and_then(|own| own.bridge_mm).or(usual(BRIDGE_MM));
        Some(Self { lean_deg, bridge_mm: bridge_mm.unwrap_or(0.0) })
    }
}

/// Finds overhangs in all printed parts whose notes do not mention supports. Also returns the number of parts examined.
pub(crate) fn examine(kit: &Sensor) -> Result<(Vec<Finding>, usize), InvalidBody> {
    let printed: Vec<(&Body, Limits)> =
        kit.parts().filter_map(|part| Some((part, Limits::for_part(part)?))).collect();
    let found: Vec<Option<Finding>> = printed
        .par_iter()
        .map(|(part, limits)| check_part(part, *limits))
        .collect::<Result<_, _>>()?;
    Ok((found.into_iter().flatten().collect(), printed.len()))
}

/// Finds the overhang of a part as it lies on the bed, whatever its notes say; `None` for processes without limits.
///
/// # Errors
/// [`InvalidBody`] if the solid of the part is not valid.
pub(crate) fn find_overhang(part: &Body) -> Result<Option<Finding>, InvalidBody> {
    Limits::for_part(part).map_or(Ok(None), |limits| measure_overhang(part, limits))
}

/// Finds the overhang of a part unless its notes mention supports.
fn check_part(part: &Body, limits: Limits) -> Result<Option<Finding>, InvalidBody> {
    if says_supports(part) { Ok(None) } else { measure_overhang(part, limits) }
}

/// Measures overhangs on a grid of vertical lines.
fn measure_overhang(part: &Body, limits: Limits) -> Result<Option<Finding>, InvalidBody> {
    let invalid = |source| InvalidBody { body: part.name.clone(), source };
    // Letters are too small to need supports.
    let on_bed = without_lettering(&part.solid).placed(part.bed_from_body);
    let body = CompiledSolid::new(&on_bed).map_err(invalid)?;
    let bounds = body.bounds();
    if bounds.is_empty() || !bounds.is_finite() {
        return Ok(None);
    }
    let size = bounds.max - bounds.min;
    let cell_mm = size.x.max(size.y) / ACROSS;
    // The offset keeps lines off faces of ordinary parts, which lie at round coordinates.
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
                if lean_deg > limits.lean_deg + ROUNDING_DEG && z_mm > bounds.min.z + ON_BED_MM {
                    // Area of the inclined face over one cell.
                    let area_mm2 = cell_mm * cell_mm / looks_down;
                    column.down.push(OverhangFace { z_mm, lean_deg, area_mm2 });
                }
            }
            grid.push(column);
        }
    }
    let bridge_mm = limits.bridge_mm;
    let regions = Grid { columns: &grid, counts, cell_mm, bridge_mm }.regions();
    let hanging = regions.iter().filter_map(|region| Some((region, region.unsupported_at?)));
    // The finding is placed at the largest region.
    let largest = hanging.clone().max_by(|a, b| a.0.area_mm2.total_cmp(&b.0.area_mm2));
    let Some((worst, ([x, y], z_mm))) = largest else { return Ok(None) };
    let area_mm2: f64 = hanging.clone().map(|(region, _)| region.area_mm2).sum();
    let steepest = hanging.map(|(region, _)| region.steepest_deg).fold(0.0, f64::max);
    let place = Point3::new(at(0, x), at(1, y), z_mm);
    let finding = finding(part, limits, worst, [area_mm2, steepest]);
    Ok(Some(finding.at_position(Some(part.bed_from_body.inverse().point(place)))))
}

/// Reports a part: its worst region, and the area (mm2) and steepest overhang (degrees) of all regions.
fn finding(part: &Body, limits: Limits, worst: &Region, [area_mm2, steepest]: [f64; 2]) -> Finding {
    let Limits { lean_deg, bridge_mm } = limits;
    let by = part.machine.as_ref().map_or_else(|| part.process_word(), |own| own.name.clone());
    let (span, able) = match worst.span_mm {
        Some(span_mm) if bridge_mm > 0.0 => {
            (format!(" over a gap of {span_mm:.0} mm"), format!(" and bridges {bridge_mm:.0} mm"))
        }
        _ => Default::default(),
    };
    let message = format!(
        "{} needs supports: {area_mm2:.0} mm2 hang over by up to {steepest:.0} deg{span}, and {by} prints \
         {lean_deg:.0} deg without{able}",
        part.name
    );
    let fix = "print it with supports, in another orientation, or with another process";
    let finding = Finding::error(Rule::Overhang, message, fix)
        .with_severity(Severity::Note)
        .about_bodies([part.name.as_str()]);
    match worst.span_mm {
        Some(span_mm) if bridge_mm > 0.0 => finding.with_measurement(span_mm, bridge_mm, "mm"),
        _ => finding.with_measurement(steepest, lean_deg, "deg"),
    }
}

/// Returns whether the part's notes mention supports. Notes that deny them do not count.
fn says_supports(part: &Body) -> bool {
    part.notes.iter().any(|note| {
        // Denials contain the word, too, so they are removed first.
        let denied = ["no support", "without support", "not need support", "no supports"];
        let note = denied.iter().fold(note.to_lowercase(), |note, word| note.replace(word, ""));
        note.contains("support")
    })
}

#[cfg(test)]
mod tests {
    use fabkit_geometry::{Angle, Machine, Pose, Solid};

    use super::*;

    fn found(part: Body) -> Option<Finding> {
        let limits = Limits::for_part(&part)?;
        check_part(&part, limits).unwrap()
    }

    fn fdm(solid: Solid) -> Body {
        Body::made("part", "a part", Process::Fdm, solid)
    }

    #[test]
    fn overhangs_are_measured() {
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
        assert!(found(fdm(hat()).with_bed_orientation(Pose::rotation_x(half))).is_none());
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
        let wide = found(tunnel(14.0)).unwrap();
        let measured = wide.measured.unwrap();
        assert!((measured.value - 14.0).abs() < 30.0 / ACROSS, "{measured:?}");
        assert_eq!((measured.limit, measured.unit), (BRIDGE_MM, "mm"));
        assert!(wide.message.contains("over a gap of 14 mm"), "{}", wide.message);
        // To call it a bridge does not make it shorter.
        assert!(found(tunnel(14.0).note("no supports: its roof is a bridge")).is_some());
        assert!(found(tunnel(14.0).note("supports below its roof")).is_none());
        // A printer that cools well spans more; resin does not harden on its way through the air.
        let machine = |process, overhang_deg, bridge_mm| {
            let mut part = tunnel(8.0).made_by(process);
            let name = "own".to_owned();
            part.machine = Some(Machine { name, overhang_deg, bridge_mm, ..Machine::default() });
            found(part)
        };
        assert!(machine(Process::Fdm, None, None).is_none());
        assert!(machine(Process::Fdm, None, Some(5.0)).is_some());
        assert!(machine(Process::Fdm, None, Some(9.0)).is_none());
        assert!(machine(Process::Sla, None, None).is_none());
        let resin = machine(Process::Sla, Some(45.0), None).unwrap();
        assert_eq!(resin.measured.unwrap().unit, "deg");
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
