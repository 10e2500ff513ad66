//! Application of assigned processes, materials and labels to the parts of a sensor or fixture.

use fabkit_geometry::{Body, BodyKind, Machine, Process, Sensor};
use fabkit_text::{InvalidDesign, LocatedProblem, RuleReport, Setting, join, to_printable};

use super::part_processes::{PartAssignment, matches_pattern};
use super::{NamedProcess, PARTS, ProcessAssignments, ProcessKind, Processes};
use crate::articles::{Articles, fill_all};
use crate::labels::{self, Labels};
use crate::materials::{Catalogue, StockCatalogue, assign_substances};
use crate::user_catalogue::named_sections::similar_names;

/// Statements of a sensor's file on processes, parts, labels and articles, kept for the fixtures of the sensor.
#[derive(Clone, Debug)]
pub struct Workshop {
    pub(crate) processes: Processes,
    pub(crate) making: ProcessAssignments,
    pub(crate) labels: Option<Labels>,
    pub(crate) articles: Articles,
    pub(crate) materials: Catalogue,
    pub(crate) stock: StockCatalogue,
}

impl Workshop {
    /// Applies processes, materials, labels and articles to the parts of a fixture as to those of the sensor. Returns
    /// the settings they depend on, as further parameters. Parts of a fixture are called `FIXTURE/PART`.
    ///
    /// # Errors
    /// Parts that cannot be made as a file says.
    pub fn apply(
        &self,
        fixture: &str,
        kit: &mut Sensor,
        report: &mut RuleReport,
    ) -> Result<Vec<Setting>, InvalidDesign> {
        let mut found = Vec::new();
        let scope = format!("{fixture}/");
        fill_all(kit, &self.articles);
        assign(kit, &scope, &self.making, true, &mut found);
        assign_substances(kit, &self.materials, &self.stock);
        if let Some(labels) = self.labels.as_ref().filter(|labels| labels.selects_all()) {
            labels::apply(labels, kit, report);
        }
        if found.is_empty() {
            let mut settings = self.processes.settings(&names(kit, &scope));
            settings.extend(self.stock.settings(&kit.bodies));
            Ok(settings)
        } else {
            Err(InvalidDesign::new(LocatedProblem::sort(found)))
        }
    }
}

/// Returns the names of parts as patterns address them; those of a fixture start with `FIXTURE/`.
pub(crate) fn names(kit: &Sensor, scope: &str) -> Vec<String> {
    kit.parts().map(|part| format!("{scope}{}", part.name)).collect()
}

/// Reports patterns that match neither a part of the sensor nor one of its fixtures.
pub(crate) fn report_unmatched(
    making: &ProcessAssignments,
    of_sensor: &[String],
    of_fixtures: &[String],
    found: &mut Vec<LocatedProblem>,
) {
    let mut fixtures: Vec<&str> =
        of_fixtures.iter().filter_map(|name| Some(name.split_once('/')?.0)).collect();
    // Parts of one fixture are listed one after the other.
    fixtures.dedup();
    for given in making.all_assignments() {
        let mut names = of_sensor.iter().chain(of_fixtures);
        if names.any(|name| matches_pattern(&given.pattern, name)) {
            continue;
        }
        let path = join(PARTS, &to_printable(&given.pattern));
        let (or, theirs) = match fixtures.join("/*`, `") {
            none if none.is_empty() => ("", String::new()),
            all => (" or of its fixtures'", format!(", those of its fixtures `{all}/*`")),
        };
        let message = format!("{path} names none of the sensor's parts{or}");
        let did = did_you_mean(&given.pattern, of_sensor, of_fixtures, &fixtures);
        let hint =
            format!("{did}the parts are {}{theirs}; `*` stands for anything", of_sensor.join(", "));
        found.push(given.place.problem(&path, &to_printable(&given.pattern), message).hint(hint));
    }
}

/// Returns a suggestion for a pattern that matches nothing.
fn did_you_mean(
    pattern: &str,
    of_sensor: &[String],
    of_fixtures: &[String],
    fixtures: &[&str],
) -> String {
    let say = |names: &[&str]| match names {
        [] => None,
        names => Some(format!("{} ", fabkit_text::did_you_mean(names))),
    };
    let stem = format!("{pattern}-");
    if of_sensor.iter().any(|name| name.starts_with(&stem)) {
        return format!("did you mean `{stem}*`? ");
    }
    // Most likely mistakes, in this order: a misspelt part, a fixture without `/*`, a part without its fixture.
    let in_fixture = |name: &&String| name.split_once('/').is_some_and(|(_, part)| part == pattern);
    let named: Vec<&str> = of_fixtures.iter().filter(in_fixture).map(String::as_str).collect();
    let whole: Vec<String> =
        fixtures.iter().filter(|name| **name == pattern).map(|name| format!("{name}/*")).collect();
    let whole: Vec<&str> = whole.iter().map(String::as_str).collect();
    let sensor = similar_names(pattern, of_sensor.iter().map(String::as_str));
    say(&sensor)
        .or_else(|| say(&whole))
        .or_else(|| say(&named))
        .or_else(|| say(&similar_names(pattern, of_fixtures.iter().map(String::as_str))))
        .unwrap_or_default()
}

/// Assigns processes and materials to the parts of a kit, with notes for whoever makes them, and reports impossible
/// assignments. `scope` precedes the names of the parts; `follows` tells whether all fits follow the process.
pub(crate) fn assign(
    kit: &mut Sensor,
    scope: &str,
    making: &ProcessAssignments,
    follows: bool,
    found: &mut Vec<LocatedProblem>,
) {
    for part in &mut kit.bodies {
        let BodyKind::Made(usual) = part.kind else { continue };
        let name = format!("{scope}{}", part.name);
        let material = making.material(&name, usual, &part.material);
        let Some(recipe) = making.process_for(&name) else {
            part.machine = making.process_for_kind(usual).map(NamedProcess::machine);
            part.material = material;
            continue;
        };
        let place = making.assignments_for(&name).find(|given| given.recipe.is_some());
        if let (Some(why), Some(place)) = (refusal_reason(usual, recipe.kind), place) {
            let path = join(&join(PARTS, &to_printable(&place.pattern)), "process");
            let message = format!("{name} cannot be made by {}: {why}", recipe.name);
            let hint = format!("it is made by {usual}; leave it out of the pattern");
            found.push(place.place.problem(&path, &recipe.name, message).hint(hint));
            continue;
        }
        let old = std::mem::replace(&mut part.material, material);
        apply_process(part, recipe, usual, &old, follows);
    }
    // Parts printed as one piece need the same process.
    for group in &kit.print_groups {
        let mut made = kit.bodies.iter().filter(|body| group.parts.contains(&body.name));
        let Some(first) = made.next() else { continue };
        let Some(other) = made.find(|other| other.kind != first.kind) else { continue };
        let message = format!(
            "{} is made by {} and {} by {}, but they are printed as one piece",
            first.name,
            first.process_word(),
            other.name,
            other.process_word()
        );
        let is_meant = |given: &&PartAssignment| {
            group
                .parts
                .iter()
                .any(|part| matches_pattern(&given.pattern, &format!("{scope}{part}")))
        };
        let Some(given) = making.all_assignments().iter().find(is_meant) else { continue };
        let hint = format!("give {} the same process", group.parts.join(", "));
        found.push(given.place.problem(PARTS, &given.pattern, message).hint(hint));
    }
}

/// Changes a part, usually made by `usual` from `old`, to a recipe and adds a note about the change.
fn apply_process(part: &mut Body, recipe: &NamedProcess, usual: Process, old: &str, follows: bool) {
    let process = recipe.kind.process();
    part.kind = BodyKind::Made(process);
    let mut note = format!("made by {}", recipe.name);
    if recipe.name != recipe.kind.word() {
        note += &format!(" ({})", recipe.kind.word());
    }
    note += &match recipe.figures.as_ref().and_then(|figures| figures.layer_height) {
        Some(height) => format!(" in layers of {height}"),
        None => String::new(),
    };
    if process != usual {
        note += &format!(", usually by {usual}");
    }
    if part.material != old {
        note += &format!("; from {} in place of {old}", part.material);
    }
    if process != usual && !follows {
        note += &format!("; its fits are those of {usual}");
    }
    part.machine = Some(Machine { note: note.clone(), ..recipe.machine() });
    part.notes.insert(0, note);
    part.notes.extend(recipe.figures.as_ref().and_then(|f| f.note.clone()));
}

/// Returns the reason why a part that is usually made by one process cannot be made by another.
fn refusal_reason(usual: Process, kind: ProcessKind) -> Option<&'static str> {
    use Process::{Cast, Laser, Pcb};
    match (usual, kind) {
        (Pcb, _) => Some("it is a circuit board"),
        (Cast, _) => Some("it is cast"),
        (Laser, _) => None,
        (_, ProcessKind::Laser) => Some("it is no flat sheet"),
        _ => None,
    }
}
