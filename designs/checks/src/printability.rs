//! Printability: a part fits on the printer's bed, and its walls and holes are not too thin.

use fabkit_geometry::{
    Body, CompiledSolid, Machine, Point3, Process, Sensor, Solid, without_lettering,
};
use rayon::prelude::*;

use crate::declaration::rule;
use crate::finding::{Finding, Severity};
use crate::rule::Rule;
use crate::rule_input::{RuleInput, RuleResult};
use crate::sampling_lines::{Bundle, Caster, DIRECTIONS, steepness};
use crate::scene::InvalidBody;

rule! {
    /// The printer can make the part.
    Printability = "printability",
    examines: "printed parts",
    finds: "walls and holes that a machine cannot make, and parts that do not fit its bed",
    limit: "the machine's data in the sensor's file, else those of usual machines: walls of 0.8 mm \
             and holes of 1 mm for filament, 0.4 and 0.5 mm for resin, 0.6 and 0.6 mm for jetted \
             resin",
    for_variants: true,
    look: apply,
}

fn apply(case: &RuleInput<'_>) -> RuleResult {
    on_machines(case.sensor)
}

/// Number of lines through each part in each direction.
const LINES: usize = 6_000;

/// Largest cosine between the normals of two faces that bound a wall. It is also that of an edge sharper than 26
/// degrees.
const OPPOSITE: f64 = -0.9;

/// Prefix of messages about walls.
const WALL: &str = "a wall of";

/// Rounding allowed, mm.
const ROUNDING_MM: f64 = 1e-6;

/// Limits of a usual machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrintLimits {
    /// Thinnest wall, mm.
    pub wall_mm: f64,
    /// Smallest diameter of a hole, mm.
    pub hole_mm: f64,
    /// Largest part, width x depth x height, mm.
    pub bed_mm: [f64; 3],
}

/// Returns the usual limits of a process; `None` if it is not printing.
///
/// They are those of ordinary desktop machines: two lines of a 0.4 mm nozzle, a few pixels of a resin printer's screen.
///
/// ```
/// use fabkit_checks::print_limits;
/// use fabkit_geometry::Process;
/// // Two lines of a nozzle of 0.4 mm.
/// assert_eq!(print_limits(Process::Fdm).map(|limits| limits.wall_mm), Some(0.8));
/// assert_eq!(print_limits(Process::Laser), None);
/// ```
pub fn print_limits(process: Process) -> Option<PrintLimits> {
    match process {
        Process::Fdm => {
            Some(PrintLimits { wall_mm: 0.8, hole_mm: 1.0, bed_mm: [250.0, 210.0, 210.0] })
        }
        Process::Sla => {
            Some(PrintLimits { wall_mm: 0.4, hole_mm: 0.5, bed_mm: [145.0, 145.0, 185.0] })
        }
        Process::PolyJet => {
            Some(PrintLimits { wall_mm: 0.6, hole_mm: 0.6, bed_mm: [250.0, 250.0, 200.0] })
        }
        Process::Laser | Process::Cnc | Process::Cast | Process::Pcb => None,
    }
}

/// Returns the limits of a part: those of its machine, or else the usual ones of its process.
pub fn part_limits(part: &Body) -> Option<PrintLimits> {
    machine_limits(part.process()?, part.machine.as_ref())
}

/// Returns the limits of a process, replaced by those that a machine states.
///
/// ```
/// use fabkit_checks::{machine_limits, print_limits};
/// use fabkit_geometry::{Machine, Process};
/// let machine = Machine { bed_mm: [None, None, Some(400.0)], ..Machine::default() };
/// let limits = machine_limits(Process::Fdm, Some(&machine)).ok_or("no printer")?;
/// // The machine is higher than usual; what it does not state is as usual.
/// assert_eq!(limits.bed_mm, [250.0, 210.0, 400.0]);
/// assert_eq!(Some(limits.wall_mm), print_limits(Process::Fdm).map(|usual| usual.wall_mm));
/// # Ok::<(), &str>(())
/// ```
pub fn machine_limits(process: Process, machine: Option<&Machine>) -> Option<PrintLimits> {
    let usual = print_limits(process)?;
    let Some(machine) = machine else { return Some(usual) };
    let [width, depth, height] = usual.bed_mm;
    let [own_width, own_depth, own_height] = machine.bed_mm;
    Some(PrintLimits {
        wall_mm: machine.wall_mm.unwrap_or(usual.wall_mm),
        hole_mm: machine.hole_mm.unwrap_or(usual.hole_mm),
        bed_mm: [
            own_width.unwrap_or(width),
            own_depth.unwrap_or(depth),
            own_height.unwrap_or(height),
        ],
    })
}

/// Applies the rule to the printed parts of a kit. Also returns the number of parts.
///
/// Walls are measured along exact lines: from the point where a line enters, along the face's normal to the opposite
/// face. Only faces with nearly opposite normals bound a wall. An edge sharper than 26 degrees counts as a wall that is
/// too thin.
///
/// ```
/// # let mut kit = fabkit_checks::example::puck();
/// use fabkit_checks::printability;
/// use fabkit_geometry::Solid;
/// assert!(printability(&kit)?.0.is_empty());
/// // A fin of 0.3 mm on the dish.
/// let fin = Solid::cuboid(0.3, 4.0, 5.0).at(12.0, 0.0, -1.0);
/// kit.bodies[0].solid = kit.bodies[0].solid.clone().plus(fin);
/// assert!(printability(&kit)?.0[0].message.contains("0.30 mm"));
/// # Ok::<(), fabkit_checks::InvalidBody>(())
/// ```
///
/// # Errors
/// [`InvalidBody`] if the solid of a part is not valid.
pub fn printability(kit: &Sensor) -> Result<(Vec<Finding>, usize), InvalidBody> {
    let limits = kit.parts().filter_map(|part| Some((part, part_limits(part)?)));
    all(limits.collect())
}

/// Applies the rule to all printed parts, with the limits of their machines, else the usual ones, and to parts of other
/// machines that state limits. Walls that are too thin are warnings: sharp edges count as such, and print blunt.
pub(crate) fn on_machines(kit: &Sensor) -> Result<(Vec<Finding>, usize), InvalidBody> {
    let limits = |part: &Body| {
        part_limits(part).or_else(|| {
            // Laser cutters and mills have only the limits that a file states.
            let machine = part.machine.as_ref()?;
            Some(PrintLimits {
                wall_mm: machine.wall_mm.unwrap_or(0.0),
                hole_mm: machine.hole_mm.unwrap_or(0.0),
                bed_mm: machine.bed_mm.map(|side| side.unwrap_or(f64::INFINITY)),
            })
        })
    };
    let (mut findings, count) =
        all(kit.parts().filter_map(|part| Some((part, limits(part)?))).collect())?;
    for finding in findings.iter_mut().filter(|finding| finding.message.starts_with(WALL)) {
        finding.severity = Severity::Warning;
    }
    Ok((findings, count))
}

/// Examines printed parts in parallel, each against its limits.
fn all(printed: Vec<(&Body, PrintLimits)>) -> Result<(Vec<Finding>, usize), InvalidBody> {
    let found: Vec<Vec<Finding>> =
        printed.par_iter().map(|(part, limits)| examine(part, limits)).collect::<Result<_, _>>()?;
    Ok((found.into_iter().flatten().collect(), printed.len()))
}

/// Examines one part: size, smallest hole, thinnest wall.
fn examine(part: &Body, limits: &PrintLimits) -> Result<Vec<Finding>, InvalidBody> {
    let invalid = |source| InvalidBody { body: part.name.clone(), source };
    // Ridges between letters may be thin.
    let solid = without_lettering(&part.solid);
    let body = CompiledSolid::new(&solid).map_err(invalid)?;
    let on_bed = CompiledSolid::new(&solid.placed(part.bed_from_body)).map_err(invalid)?;
    let about = |finding: Finding| finding.about_bodies([part.name.as_str()]);
    let mut findings = Vec::new();

    let size = on_bed.bounds().max - on_bed.bounds().min;
    // A part may be turned on the bed.
    let [long, short] = [size.x.max(size.y), size.x.min(size.y)];
    let [width, depth, height] = limits.bed_mm;
    let over = [(long, width.max(depth)), (short, width.min(depth)), (size.z, height)];
    if let Some((value, limit)) = over.into_iter().find(|(value, limit)| value > limit) {
        let message = format!(
            "{} is {:.1} x {:.1} x {:.1} mm, more than {} takes",
            part.name,
            size.x,
            size.y,
            size.z,
            match &part.machine {
                Some(machine) => machine.name.clone(),
                None => format!("a usual printer for {}", part.process_word()),
            }
        );
        let fix = "make it smaller, or print it elsewhere";
        findings.push(
            about(Finding::error(Rule::Printability, message, fix))
                .with_measurement(value, limit, "mm"),
        );
    }

    let tools = body.leaves().iter().filter(|leaf| leaf.is_tool);
    let holes = tools.filter_map(|leaf| match &leaf.primitive {
        // Only round holes have a diameter.
        Solid::Cylinder(hole) => Some((2.0 * hole.radius_mm, leaf)),
        _ => None,
    });
    if let Some((diameter, leaf)) = holes.min_by(|a, b| a.0.total_cmp(&b.0))
        && diameter < limits.hole_mm - ROUNDING_MM
    {
        let message = format!("{} of {} is {diameter:.2} mm wide", leaf.feature, part.name);
        let fix = "widen it, or print it with another process";
        findings.push(
            about(Finding::error(Rule::Printability, message, fix))
                .at_position(Some(leaf.body_from_leaf.point(Point3::origin())))
                .with_measurement(diameter, limits.hole_mm, "mm"),
        );
    }

    // 0 stands for no stated limit.
    let is_limited = limits.wall_mm > 0.0;
    let thinnest = is_limited.then(|| thinnest_wall(&body, limits.wall_mm, LINES)).flatten();
    if let Some((thickness, place)) = thinnest {
        let message = format!("{WALL} {} is {thickness:.2} mm thin", part.name);
        let fix = "thicken it, or print it with another process";
        findings.push(
            about(Finding::error(Rule::Printability, message, fix))
                .at_position(Some(place))
                .with_measurement(thickness, limits.wall_mm, "mm"),
        );
    }
    Ok(findings)
}

/// Finds the thinnest wall below a limit. Returns its thickness, mm, and its position. Samples `lines` lines in each of
/// three directions; walls smaller than their spacing can be missed. See [`printability`] for the definition of a wall.
///
/// ```
/// use fabkit_checks::thinnest_wall;
/// use fabkit_geometry::{CompiledSolid, Solid};
/// let plate = CompiledSolid::new(&Solid::cuboid(20.0, 10.0, 0.5))?;
/// let (thickness_mm, place) = thinnest_wall(&plate, 0.8, 1000).ok_or("no thin wall")?;
/// assert!((thickness_mm - 0.5).abs() < 1e-9 && (place.z - 0.25).abs() < 1e-9);
/// // Nothing is thinner than 0.4 mm.
/// assert_eq!(thinnest_wall(&plate, 0.4, 1000), None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn thinnest_wall(
    body: &CompiledSolid,
    limit_mm: f64,
    lines: usize,
) -> Option<(f64, Point3<f64>)> {
    let bounds = body.bounds();
    if bounds.is_empty() || !bounds.is_finite() {
        return None;
    }
    let mut casters = [Caster::default(), Caster::default()];
    let mut thinnest: Option<(f64, Point3<f64>)> = None;
    for direction in DIRECTIONS {
        let bundle = Bundle::through(&bounds, direction.into(), lines);
        for ray in (0..lines).map(|index| bundle.line(index)) {
            let [along, across] = &mut casters;
            for stretch in along.stretches(body, &ray) {
                // Skips stretches that are clearly thicker across their faces than the limit. The factor 2 allows for
                // faces that are not parallel.
                let steep = steepness(&ray, &stretch.enter).max(steepness(&ray, &stretch.exit));
                if stretch.length_mm() * steep > 2.0 * limit_mm {
                    continue;
                }
                // Through the wall, perpendicular to the face.
                let inwards = fabkit_geometry::Ray {
                    origin: ray.at(stretch.enter.t),
                    direction: -stretch.enter.normal,
                };
                let wall = across
                    .stretches(body, &inwards)
                    // The stretch that begins at the face itself.
                    .find(|wall| wall.enter.t.abs() < ROUNDING_MM && wall.exit.t > 0.0);
                let Some(wall) = wall else { continue };
                let is_wall = wall.exit.normal.dot(&stretch.enter.normal) < OPPOSITE;
                let is_thinner = wall.exit.t < thinnest.map_or(limit_mm - ROUNDING_MM, |t| t.0);
                if is_wall && is_thinner {
                    thinnest = Some((wall.exit.t, inwards.at(0.5 * wall.exit.t)));
                }
            }
        }
    }
    thinnest
}
