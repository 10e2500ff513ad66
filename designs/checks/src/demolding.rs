//! Demolding: no cast material is in the way of a tool that is taken off.
//!
//! On a grid of lines along the pull, cast material ahead of the tool holds it back: an undercut. A rigid tool must
//! have none. A silicone tool stretches sideways by the distance from the undercut to the nearest place from which the
//! tool comes off freely. Stretched around an axis through the cast, a displacement `u` at the radius `r` is a hoop
//! strain `u / r` (Timoshenko and Goodier, "Theory of Elasticity", section 28).

use fabkit_geometry::proofs::{ProjectionRaster, find_obstacle_boxes};
use fabkit_geometry::{Aabb, CompiledSolid, Point3, Pull, Ray, Vector3};
use rayon::prelude::*;

use crate::rule_input::{Place, Removal};
use crate::rule_input::{RuleInput, RuleResult};

use crate::declaration::rule;
use crate::finding::{Finding, Severity};
use crate::memo::{Key, Memo};
use crate::rule::Rule;
use crate::sampling_lines::{Caster, basis, steepness};
use crate::scene::Placed;

rule! {
    /// Tools come off what was cast.
    Demolding = "demolding",
    examines: "pulls",
    finds: "undercuts and bodies that obstruct a tool when it is taken off",
    limit: "the strain that a soft material withstands",
    for_variants: true,
    look: apply,
}

fn apply(case: &RuleInput<'_>) -> RuleResult {
    let RuleInput { memo, tick, removals, .. } = case;
    let pulled = removals.par_iter().map(|removal| {
        let has_direction = removal.pull.direction.norm() > 0.0;
        let found = has_direction.then(|| examine(removal, memo));
        tick();
        found.unwrap_or_default()
    });
    Ok((pulled.collect::<Vec<_>>().concat(), removals.len()))
}

/// Number of lines along the longer side of the region that tool and cast share.
pub(crate) const LINES: usize = 320;

/// Maximum number of cells at which the depth of an undercut is measured.
const PROBES: usize = 2048;

/// Largest length of cast material ahead of the tool, across its face, that counts as contact, mm.
const CONTACT_MM: f64 = 1e-6;

/// Intersections of one line along the pull; positions are comparable from line to line.
#[derive(Clone, Copy, Debug)]
struct Cell {
    /// Last end of cast material; minus infinity if there is none.
    cast_end_mm: f64,
    /// End of the tool, if cast material lies ahead of it.
    held: Option<Held>,
}

#[derive(Clone, Copy, Debug)]
struct Held {
    tool_end_mm: f64,
    place: Point3<f64>,
    /// Index of the cast body that holds the tool.
    by: usize,
}

struct Grid {
    cells: Vec<Cell>,
    size: [usize; 2],
    cell_mm: f64,
    /// Axis of the pull through the centre of the cast, in cells.
    axis: [f64; 2],
}

/// Undercut that holds a tool.
struct Undercut {
    area_mm2: f64,
    depth_mm: f64,
    strain: f64,
    place: Point3<f64>,
    /// Index of the cast body that holds the tool at `place`.
    by: usize,
}

/// Finds undercuts of one tool.
pub(crate) fn examine(removal: &Removal, memo: &Memo) -> Vec<Finding> {
    let key = Key::new(4).vector(&removal.pull.direction).word(removal.tools.len() as u64);
    let bodies = removal.tools.iter().chain(&removal.cast);
    let key = bodies.fold(key, |key, placed| key.key(placed.key));
    let mut findings = Vec::new();
    memo.is_clean(&key, || {
        findings = undercuts(removal);
        findings.is_empty()
    });
    findings
}

fn undercuts(removal: &Removal) -> Vec<Finding> {
    let Removal { place, pull, tools, cast } = removal;
    let direction = pull.direction.normalize();
    let undercuts = tools.iter().filter_map(|tool| {
        let bounds = cast.iter().fold(Aabb::nothing(), |sum, c| sum.hull(&c.body.bounds()));
        // A tool can only be held where its projection overlaps that of the cast.
        let grid = Grid::along(&direction, tool, cast, &bounds)?;
        grid.undercut()
    });
    undercuts.filter_map(|undercut| judge(place, pull, cast, &undercut)).collect()
}

/// Converts an undercut to a finding: an error if the tool is rigid or tears, else a note.
fn judge(place: &Place, pull: &Pull, cast: &[&Placed], undercut: &Undercut) -> Option<Finding> {
    let Undercut { area_mm2, depth_mm, strain, .. } = *undercut;
    let finding = match pull.strain_limit {
        None => Finding::error(
            Rule::Demolding,
            format!(
                "{} does not come off: it has an undercut of {area_mm2:.2} mm2, up to {depth_mm:.2} mm deep, behind the cast",
                pull.body
            ),
            "pull it another way, divide it, or cast it from silicone",
        )
        .with_measurement(area_mm2, 0.0, "mm2"),
        Some(limit) if strain > limit => Finding::error(
            Rule::Demolding,
            format!(
                "{} tears: to clear an undercut of {depth_mm:.2} mm it must stretch by {:.0} %",
                pull.body,
                100.0 * strain
            ),
            "make the undercut shallower, divide the tool, or use a softer material",
        )
        .with_measurement(strain, limit, "strain"),
        Some(limit) => Finding::error(
            Rule::Demolding,
            format!(
                "taking {} off stretches silicone by {:.0} % over an undercut of {depth_mm:.2} mm \
                 ({area_mm2:.2} mm2)",
                pull.body,
                100.0 * strain
            ),
            "nothing to do: its material withstands that strain",
        )
        .with_severity(Severity::Note)
        .with_measurement(strain, limit, "strain"),
    };
    Some(
        finding
            .in_step(place.step)
            .in_assembly(place.assembly)
            .about_bodies([pull.body.as_str(), cast[undercut.by].name])
            .at_position(Some(undercut.place)),
    )
}

impl Grid {
    /// Casts the grid of lines. `None` if the projections of tool and cast do not overlap, or if nothing is held.
    fn along(
        direction: &Vector3<f64>,
        tool: &Placed,
        cast: &[&Placed],
        cast_bounds: &Aabb,
    ) -> Option<Self> {
        let [u, v] = basis(direction);
        let shadow = |bounds: &Aabb, w: &Vector3<f64>| {
            let half_mm = w.abs().dot(&(0.5 * (bounds.max - bounds.min)));
            let middle_mm = w.dot(&bounds.centre().coords);
            [middle_mm - half_mm, middle_mm + half_mm]
        };
        let tool_bounds = tool.body.bounds();
        let common = [u, v].map(|w| {
            let (a, b) = (shadow(&tool_bounds, &w), shadow(cast_bounds, &w));
            [a[0].max(b[0]), a[1].min(b[1])]
        });
        let sides = common.map(|[from, to]| to - from);
        if sides.iter().any(|&side| !(side > 0.0 && side.is_finite())) {
            return None;
        }
        let cell_mm = sides[0].max(sides[1]) / LINES as f64;
        // A margin of one cell, so that the free space beside the cast is included.
        let size = sides.map(|side| (side / cell_mm).ceil() as usize + 2);
        // An offset of an odd fraction of a cell keeps lines off walls at round coordinates.
        let place = |axis: usize, i: usize| common[axis][0] + (i as f64 - 0.518) * cell_mm;
        let ray = |i: usize, j: usize| Ray {
            origin: Point3::from(place(0, i) * u + place(1, j) * v),
            direction: *direction,
        };
        let cast_bodies: Vec<&CompiledSolid> = cast.iter().map(|placed| &placed.body).collect();
        if let Some(boxes) = find_obstacle_boxes(&tool.body, &cast_bodies, direction) {
            if boxes.is_empty() {
                return None;
            }
            // Where the proof by boxes fails, a first pass with the lines through the boxes finds whether anything is
            // held; the full grid is cast only then.
            let middle = [0, 1].map(|k| 0.5 * (common[k][0] + common[k][1]));
            let centre = Point3::from(middle[0] * u + middle[1] * v);
            let shadow = ProjectionRaster::from_boxes(
                &boxes,
                &centre,
                &[u, v],
                sides.map(|side| 0.5 * side),
            );
            let share = |k: usize, i: usize| (place(k, i) - common[k][0]) / sides[k];
            let is_held = (0..size[1]).into_par_iter().any(|j| {
                let mut caster = Caster::default();
                (0..size[0])
                    .filter(|&i| shadow.may_meet_box([share(0, i), share(1, j)]))
                    .any(|i| cell(&ray(i, j), tool, cast, &mut caster).held.is_some())
            });
            if !is_held {
                return None;
            }
        }
        let cells: Vec<Vec<Cell>> = (0..size[1])
            .into_par_iter()
            .map(|j| {
                let mut caster = Caster::default();
                (0..size[0]).map(|i| cell(&ray(i, j), tool, cast, &mut caster)).collect()
            })
            .collect();
        let centre = cast_bounds.centre().coords;
        let axis = [0, 1].map(|k| ([u, v][k].dot(&centre) - common[k][0]) / cell_mm + 0.518);
        Some(Self { cells: cells.into_iter().flatten().collect(), size, cell_mm, axis })
    }

    fn undercut(&self) -> Option<Undercut> {
        let held: Vec<(usize, Held)> = self
            .cells
            .iter()
            .enumerate()
            .filter_map(|(i, cell)| cell.held.map(|held| (i, held)))
            .collect();
        let probes: Vec<&(usize, Held)> =
            held.iter().step_by(held.len().div_ceil(PROBES).max(1)).collect();
        // Measured at a sample of the held cells, since each search takes long.
        let depths_mm: Vec<f64> = probes
            .par_iter()
            .map(|(index, held)| self.way_out_cells(*index, held.tool_end_mm) * self.cell_mm)
            .collect();
        // Distance of a cell from the axis of the pull.
        let radius_mm = |index: usize| {
            let [i, j] = [index % self.size[0], index / self.size[0]];
            (i as f64 - self.axis[0]).hypot(j as f64 - self.axis[1]) * self.cell_mm
        };
        // At the axis itself, the displacement stands in for the radius, which limits the strain to 1.
        let strain = probes
            .iter()
            .zip(&depths_mm)
            .map(|((index, _), depth_mm)| depth_mm / radius_mm(*index).max(*depth_mm))
            .fold(0.0, f64::max);
        let deepest = (0..probes.len()).max_by(|&a, &b| depths_mm[a].total_cmp(&depths_mm[b]))?;
        let Held { place, by, .. } = probes[deepest].1;
        Some(Undercut {
            area_mm2: held.len() as f64 * self.cell_mm * self.cell_mm,
            depth_mm: depths_mm[deepest],
            strain,
            place,
            by,
        })
    }

    /// Returns the distance, in cells, to the nearest cell at which a tool that ends at `tool_end_mm` comes off.
    ///
    /// Square rings around the cell are searched until no ring farther out can be nearer.
    fn way_out_cells(&self, index: usize, tool_end_mm: f64) -> f64 {
        let [width, height] = self.size.map(|n| n as isize);
        let [i, j] = [index as isize % width, index as isize / width];
        let is_clear = |di: isize, dj: isize| {
            let (i, j) = (i + di, j + dj);
            // Beyond the grid there is no tool or no cast.
            let inside = (0..width).contains(&i) && (0..height).contains(&j);
            !inside || self.cells[(j * width + i) as usize].cast_end_mm <= tool_end_mm + CONTACT_MM
        };
        let mut nearest = f64::INFINITY;
        let mut ring = 1;
        // A ring's nearest cell is `ring` cells away.
        while (ring as f64) < nearest {
            for along in -ring..=ring {
                for [di, dj] in [[along, -ring], [along, ring], [-ring, along], [ring, along]] {
                    let distance = (di as f64).hypot(dj as f64);
                    if distance < nearest && is_clear(di, dj) {
                        nearest = distance;
                    }
                }
            }
            ring += 1;
        }
        nearest
    }
}

/// Intersects one line along the pull with tool and cast.
fn cell(ray: &Ray, tool: &Placed, cast: &[&Placed], caster: &mut Caster) -> Cell {
    // The first stretch of the tool must pass all cast material ahead.
    let hindmost = caster.intervals(&tool.body, ray).first().map(|[_, exit]| *exit);
    let mut cell = Cell { cast_end_mm: f64::NEG_INFINITY, held: None };
    for (by, layer) in cast.iter().enumerate() {
        let Some(&[enter, exit]) = caster.intervals(&layer.body, ray).last() else { continue };
        cell.cast_end_mm = cell.cast_end_mm.max(exit);
        let Some(tool_end_mm) = hindmost else { continue };
        let beyond_mm = exit - enter.max(tool_end_mm);
        // The length across the faces never exceeds that along the line, so most lines need no normals.
        if beyond_mm <= CONTACT_MM {
            continue;
        }
        let tool_end = caster.stretches(&tool.body, ray).next().map(|stretch| stretch.exit);
        let last = caster.stretches(&layer.body, ray).last().map(|stretch| stretch.exit);
        let faces = [tool_end, last];
        let steep = faces.iter().flatten().map(|exit| steepness(ray, exit));
        if beyond_mm * steep.fold(1.0, f64::min) > CONTACT_MM {
            // The first cast body that holds the tool is named.
            cell.held = cell.held.or(Some(Held { tool_end_mm, place: ray.at(tool_end_mm), by }));
        }
    }
    cell
}
