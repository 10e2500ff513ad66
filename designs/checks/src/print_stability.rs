//! Standing: whether a printed part topples while it is printed, and whether resin stays in it.

use std::collections::BTreeMap;

use fabkit_geometry::{
    Body, CompiledSolid, Point3, Process, Ray, Sensor, Vector3, without_lettering,
};
use rayon::prelude::*;

use crate::declaration::rule;
use crate::finding::{Finding, Severity};
use crate::rule::Rule;
use crate::rule_input::{RuleInput, RuleResult};
use crate::sampling_lines::Caster;
use crate::scene::InvalidBody;

rule! {
    /// Printed parts stand while they grow, and resin leaves them.
    Standing = "standing",
    examines: "printed parts",
    finds: "printed parts that topple during printing, and resin that stays in a hollow",
    limit: "slenderness of 6, and 1 mm2 of footprint per mm of height, without a brim",
    for_variants: false,
    look: apply,
}

fn apply(case: &RuleInput<'_>) -> RuleResult {
    examine(case.sensor)
}

/// Largest ratio of height to least footprint width at which filament stands without a brim. Prusa's guide asks for a
/// brim under tall and thin parts; the figure is chosen: at 6, a nozzle that catches a curled edge with 1 N lifts the
/// foot with more than the adhesion of three lines.
const SLENDER: f64 = 6.0;

/// Smallest footprint area per height without a brim, mm2 per mm. Chosen: with 0.1 N/mm2 of adhesion, a part twice as
/// tall as its foot is wide bears 1 N at its top.
const FOOT_MM: f64 = 1.0;

/// Height below which a part does not topple, mm.
const LOW_MM: f64 = 15.0;

/// Height below which material lies on the bed, mm: the first layer.
const ON_BED_MM: f64 = 0.05;

/// Interval of air in a column: the column's index, and the lower and upper height, mm.
type Air = (usize, [f64; 2]);

/// Number of lines across the longer side of a part.
const ACROSS: f64 = 80.0;

/// Smallest volume of trapped resin that is reported, mm3: a drop.
const DROP_MM3: f64 = 20.0;

/// Smallest spacing of the lines, mm. Hollows may be open through a gap that the lines miss.
const LEAST_CELL_MM: f64 = 0.2;

/// Finds parts that topple and hollows that keep resin. Also returns the number of printed parts.
pub(crate) fn examine(kit: &Sensor) -> Result<(Vec<Finding>, usize), InvalidBody> {
    let printed: Vec<&Body> = kit
        .parts()
        .filter(|part| {
            matches!(part.process(), Some(Process::Fdm | Process::Sla | Process::PolyJet))
        })
        .collect();
    let found: Vec<Vec<Finding>> =
        printed.par_iter().map(|part| check_part(part)).collect::<Result<_, _>>()?;
    Ok((found.into_iter().flatten().collect(), printed.len()))
}

/// Returns the finding that a filament part may topple without a brim, whatever its notes say.
///
/// # Errors
/// [`InvalidBody`] if the solid of the part is not valid.
pub(crate) fn find_instability(part: &Body) -> Result<Option<Finding>, InvalidBody> {
    Ok(standing(part)?.and_then(|standing| standing.topples(part)))
}

/// Intervals of a vertical line inside a part, mm above the bed.
type Column = Vec<[f64; 2]>;

/// Columns through a part as it lies on the bed.
struct PartColumns {
    counts: [usize; 2],
    cell_mm: f64,
    low: Point3<f64>,
    height_mm: f64,
    columns: Vec<Column>,
}

/// Finds whether one part topples (filament) or keeps resin (other processes).
fn check_part(part: &Body) -> Result<Vec<Finding>, InvalidBody> {
    let Some(standing) = standing(part)? else { return Ok(Vec::new()) };
    let found = match part.process() {
        Some(Process::Fdm) => {
            standing.topples(part).filter(|_| !mentions_any(part, &["brim", "raft"]))
        }
        _ => standing.holds_resin(part),
    };
    Ok(found.into_iter().collect())
}

/// Measures a part as it lies on the bed.
fn standing(part: &Body) -> Result<Option<PartColumns>, InvalidBody> {
    let invalid = |source| InvalidBody { body: part.name.clone(), source };
    let solid = without_lettering(&part.solid).placed(part.bed_from_body);
    Ok(PartColumns::from_solid(&CompiledSolid::new(&solid).map_err(invalid)?))
}

impl PartColumns {
    /// Casts a grid of vertical lines through the body; `None` if it is empty or unbounded.
    fn from_solid(body: &CompiledSolid) -> Option<Self> {
        let bounds = body.bounds();
        if bounds.is_empty() || !bounds.is_finite() {
            return None;
        }
        let size = bounds.size_mm();
        let cell_mm = (size[0].max(size[1]) / ACROSS).max(LEAST_CELL_MM);
        // A ring of empty columns around the part, so that every open hollow reaches it.
        let counts = [0, 1].map(|axis| (size[axis] / cell_mm).ceil() as usize + 2);
        let mut caster = Caster::default();
        let mut columns = Vec::with_capacity(counts[0] * counts[1]);
        for y in 0..counts[1] {
            for x in 0..counts[0] {
                let at =
                    |axis: usize, i: usize| bounds.min[axis] + (i as f64 - 1.0 + 0.4721) * cell_mm;
                let origin = Point3::new(at(0, x), at(1, y), bounds.min.z);
                let ends = caster.intervals(body, &Ray { origin, direction: Vector3::z() });
                columns.push(ends.to_vec());
            }
        }
        let lowest = columns.iter().flatten().map(|[low, _]| *low).fold(f64::INFINITY, f64::min);
        let highest = columns.iter().flatten().map(|[_, top]| *top).fold(0.0, f64::max);
        if !lowest.is_finite() {
            return None;
        }
        // Bounding boxes may be larger than the body, so heights are measured from the lowest hit.
        columns.iter_mut().flatten().for_each(|ends| *ends = ends.map(|z| z - lowest));
        let low = Point3::new(bounds.min.x, bounds.min.y, bounds.min.z + lowest);
        Some(Self { counts, cell_mm, low, height_mm: highest - lowest, columns })
    }

    /// Returns the point of a column at a height above the bed, in the frame of the bed.
    fn point(&self, index: usize, z_mm: f64) -> Point3<f64> {
        let at = |i: usize| (i as f64 - 1.0 + 0.4721) * self.cell_mm;
        let [x, y] = [index % self.counts[0], index / self.counts[0]];
        self.low + Vector3::new(at(x), at(y), z_mm)
    }

    /// Finds whether the foot is too small or too narrow for the height.
    fn topples(&self, part: &Body) -> Option<Finding> {
        let on_bed = |column: &Column| column.first().is_some_and(|[low, _]| *low < ON_BED_MM);
        let foot: Vec<usize> =
            (0..self.columns.len()).filter(|i| on_bed(&self.columns[*i])).collect();
        let area_mm2 = foot.len() as f64 * self.cell_mm * self.cell_mm;
        let places: Vec<[f64; 2]> = foot.iter().map(|i| self.point(*i, 0.0).xy().into()).collect();
        // Points are the middles of cells, so one cell is missing.
        let width_mm = least_width(&places) + self.cell_mm;
        if self.height_mm < LOW_MM {
            return None;
        }
        let place = foot.first().map(|i| part.bed_from_body.inverse().point(self.point(*i, 0.0)));
        let stands = format!(
            "{} stands {:.1} mm high on {area_mm2:.0} mm2 that are {width_mm:.1} mm wide",
            part.name, self.height_mm
        );
        let (measured, limit, unit, what) = if area_mm2 < FOOT_MM * self.height_mm {
            (area_mm2, FOOT_MM * self.height_mm, "mm2", "it may come off the bed")
        } else if self.height_mm > SLENDER * width_mm {
            (self.height_mm, SLENDER * width_mm, "mm", "it may topple")
        } else {
            return None;
        };
        let fix = "lay it otherwise, widen its foot, or note that it is printed on a brim";
        Some(
            warning(part, format!("{stands}: {what}"), fix)
                .at_position(place)
                .with_measurement(measured, limit, unit),
        )
    }

    /// Finds the largest hollow that resin does not leave: a closed one, or for SLA one that only the build plate
    /// closes.
    fn holds_resin(&self, part: &Body) -> Option<Finding> {
        let (air, groups) = self.hollows();
        let (volume_mm3, is_closed, first) = groups
            .into_values()
            .filter(|hollow| !hollow.is_open)
            .map(|hollow| (hollow.volume_mm3, !hollow.is_on_plate, hollow.first))
            .filter(|(volume_mm3, is_closed, _)| {
                *volume_mm3 > DROP_MM3 && (*is_closed || part.process() == Some(Process::Sla))
            })
            .max_by(|a, b| a.0.total_cmp(&b.0))?;
        if !is_closed && mentions_any(part, &["support", "raise", "tilt", "drain", "vent"]) {
            return None;
        }
        let (index, [low, high]) = air[first];
        let place = part.bed_from_body.inverse().point(self.point(index, (low + high) / 2.0));
        let (what, fix) = if is_closed {
            ("a hollow without a way out", "open it with a hole of 3 mm or more")
        } else {
            (
                "a hollow that the plate closes",
                "give it a drain of 3 mm, lay it otherwise, or note that it stands on supports",
            )
        };
        let message = format!("{volume_mm3:.0} mm3 of resin stay in {}: {what}", part.name);
        let finding = warning(part, message, fix)
            .at_position(Some(place))
            .with_measurement(volume_mm3, DROP_MM3, "mm3");
        Some(if is_closed { finding.with_severity(Severity::Error) } else { finding })
    }

    /// Returns the intervals of air from the plate to the top, and the hollows that they form, by the index of a root
    /// interval.
    fn hollows(&self) -> (Vec<Air>, BTreeMap<usize, Hollow>) {
        let mut air: Vec<Air> = Vec::new();
        let mut starts = Vec::with_capacity(self.columns.len() + 1);
        for (index, column) in self.columns.iter().enumerate() {
            starts.push(air.len());
            // Air begins at the plate.
            let mut from = 0.0;
            for [low, high] in column {
                air.push((index, [from, *low]));
                from = *high;
            }
            // The last interval is open upwards.
            air.push((index, [from, f64::INFINITY]));
        }
        starts.push(air.len());
        let mut parents: Vec<usize> = (0..air.len()).collect();
        for index in 0..self.columns.len() {
            let [x, y] = [index % self.counts[0], index / self.counts[0]];
            // Each pair of adjacent columns is visited once.
            let right = (x + 1 < self.counts[0]).then_some(index + 1);
            let above = (y + 1 < self.counts[1]).then_some(index + self.counts[0]);
            for beside in [right, above].into_iter().flatten() {
                for a in starts[index]..starts[index + 1] {
                    for b in starts[beside]..starts[beside + 1] {
                        let shared = air[a].1[1].min(air[b].1[1]) - air[a].1[0].max(air[b].1[0]);
                        // Touching intervals do not let resin through.
                        if shared > ON_BED_MM {
                            let [a, b] = [root(&mut parents, a), root(&mut parents, b)];
                            // The root is the interval with the lowest index.
                            parents[a.max(b)] = a.min(b);
                        }
                    }
                }
            }
        }
        let mut groups: BTreeMap<usize, Hollow> = BTreeMap::new();
        for (i, (_, [low, high])) in air.iter().enumerate() {
            let group = groups.entry(root(&mut parents, i)).or_insert(Hollow::new(i));
            group.is_open |= high.is_infinite();
            group.is_on_plate |= *low < ON_BED_MM;
            group.volume_mm3 += (high - low) * self.cell_mm * self.cell_mm;
        }
        (air, groups)
    }
}

/// Connected intervals of air.
struct Hollow {
    first: usize,
    /// Whether it reaches past the part.
    is_open: bool,
    is_on_plate: bool,
    volume_mm3: f64,
}

impl Hollow {
    fn new(first: usize) -> Self {
        Self { first, is_open: false, is_on_plate: false, volume_mm3: 0.0 }
    }
}

/// Finds the root of an interval, with path halving.
fn root(parents: &mut [usize], mut of: usize) -> usize {
    while parents[of] != of {
        parents[of] = parents[parents[of]];
        of = parents[of];
    }
    of
}

/// Creates a warning about a part.
fn warning(part: &Body, message: String, fix: &str) -> Finding {
    Finding::error(Rule::Standing, message, fix)
        .with_severity(Severity::Warning)
        .about_bodies([part.name.as_str()])
}

/// Returns whether the part's notes mention one of these words. Notes that deny them do not count.
fn mentions_any(part: &Body, words: &[&str]) -> bool {
    part.notes.iter().any(|note| {
        let note = note.to_lowercase();
        let denied = ["no support", "without support", "no brim", "without a brim"];
        let note = denied.iter().fold(note, |note, denied| note.replace(denied, ""));
        words.iter().any(|word| note.contains(word))
    })
}

/// Returns the smallest distance of two parallel lines that enclose all points, sampled every 3 degrees.
fn least_width(points: &[[f64; 2]]) -> f64 {
    let width = |degree: i32| {
        let (sin, cos) = f64::from(degree).to_radians().sin_cos();
        let along = points.iter().map(|[x, y]| x * cos + y * sin);
        let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| {
            (low.min(at), high.max(at))
        });
        (high - low).max(0.0)
    };
    (0..180).step_by(3).map(width).fold(f64::INFINITY, f64::min)
}
