//! Fits of parts whose process or clearances a file changes.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use fabkit_geometry::{Machine, Process};
use fabkit_text::TextPlace;

use super::NamedProcess;
use crate::user_catalogue::named_sections::key_of;
use crate::{Fit, gap_mm};

/// Assignment of a file to the parts that match a pattern.
#[derive(Clone, Debug)]
pub(crate) struct PartAssignment {
    pub pattern: String,
    pub place: TextPlace,
    pub recipe: Option<NamedProcess>,
    pub material: Option<String>,
}

/// Processes and materials that differ from the family's own, for code that cuts fits into parts.
///
/// It is read together with the parameters of a family, but is no key of a file.
#[derive(Clone, Debug, Default)]
pub struct ProcessAssignments(Arc<Inner>);

/// Shared content of [`ProcessAssignments`].
#[derive(Debug, Default)]
struct Inner {
    /// Recipes of whole kinds: a file's figures for `fdm` apply to every part of that kind.
    of_kind: Vec<NamedProcess>,
    /// Assignments by pattern; the last match counts.
    of_parts: Vec<PartAssignment>,
    /// True once the family has asked for a gap here, so that its fits follow the process.
    is_used: AtomicBool,
}

/// Always equal: all parameters of one design share the same assignments, so they never distinguish two values.
impl PartialEq for ProcessAssignments {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl ProcessAssignments {
    pub(crate) fn new(of_kind: Vec<NamedProcess>, of_parts: Vec<PartAssignment>) -> Self {
        Self(Arc::new(Inner { of_kind, of_parts, is_used: AtomicBool::new(false) }))
    }

    /// Returns the gap per side, mm, of a fit in the part that has the hole and is usually made by `usual`: see
    /// [`gap_mm`].
    ///
    /// A part of a fixture is called `FIXTURE/PART`; see [`ProcessAssignments::in_fixture`].
    ///
    /// ```
    /// use fabkit_designs::{Fit, processes::ProcessAssignments};
    /// use fabkit_geometry::Process;
    /// // Where no file says anything, gaps are those usual for the process.
    /// let usual = ProcessAssignments::default();
    /// assert_eq!(usual.gap_mm("shell", Process::Fdm, Fit::Slide), 0.2);
    /// let parts = [("shell", Process::Fdm), ("lens-holder", Process::Sla)];
    /// assert_eq!(usual.widest_gap_mm(parts, Fit::Slide), 0.2);
    /// ```
    pub fn gap_mm(&self, part: impl AsRef<str>, usual: Process, fit: Fit) -> f64 {
        // Only read after the family has built its parts.
        self.0.is_used.store(true, Ordering::Relaxed);
        let recipe = self.process_for(part.as_ref()).or_else(|| self.process_for_kind(usual));
        recipe.map_or_else(|| gap_mm(usual, fit), |recipe| gap_of(recipe, fit))
    }

    /// Returns the largest gap per side, mm, where one shape serves several parts, each given with its usual process.
    pub fn widest_gap_mm<N: AsRef<str>>(
        &self,
        parts: impl IntoIterator<Item = (N, Process)>,
        fit: Fit,
    ) -> f64 {
        let gaps = parts.into_iter().map(|(part, usual)| self.gap_mm(part, usual, fit));
        gaps.fold(f64::NEG_INFINITY, f64::max)
    }

    /// Returns the process of a part that is usually made by `usual`.
    pub fn process(&self, part: impl AsRef<str>, usual: Process) -> Process {
        self.process_for(part.as_ref()).map_or(usual, |recipe| recipe.kind.process())
    }

    /// Returns the assignments for the parts of a fixture, which are usually made by `usual`.
    pub fn in_fixture(&self, fixture: &'static str, usual: Process) -> FixtureProcesses<'_> {
        FixtureProcesses { making: self, fixture, usual }
    }

    /// Returns whether every part is made as usual, because no file states anything.
    fn is_usual(&self) -> bool {
        self.0.of_kind.is_empty() && self.0.of_parts.is_empty()
    }

    /// Returns whether the family has asked for its gaps, so that its fits follow the process.
    pub(crate) fn is_used(&self) -> bool {
        self.0.is_used.load(Ordering::Relaxed)
    }

    /// Returns the assignments that match a part, the last one first.
    pub(crate) fn assignments_for(
        &self,
        part: &str,
    ) -> impl Iterator<Item = &PartAssignment> + Clone {
        self.0.of_parts.iter().rev().filter(move |given| matches_pattern(&given.pattern, part))
    }

    /// Returns all assignments.
    pub(crate) fn all_assignments(&self) -> &[PartAssignment] {
        &self.0.of_parts
    }

    /// Returns the recipe that a file assigns to a part.
    pub(crate) fn process_for(&self, part: &str) -> Option<&NamedProcess> {
        self.assignments_for(part).find_map(|given| given.recipe.as_ref())
    }

    /// Returns the material of a part that is usually made by `usual` from `material`.
    pub(crate) fn material(&self, part: &str, usual: Process, material: &str) -> String {
        if let Some(given) = self.assignments_for(part).find_map(|given| given.material.clone()) {
            return given;
        }
        let Some(recipe) = self.process_for(part) else { return material.into() };
        // In names such as `PLA, black`, the text after the comma is the colour.
        let (plain, color) = material.split_once(", ").unwrap_or((material, ""));
        let suits = |known: &String| [material, plain].map(key_of).contains(&key_of(known));
        match recipe.materials.first() {
            Some(_) if recipe.materials.iter().any(suits) => material.into(),
            // The process does not take the part's usual material.
            Some(first) => first.clone(),
            None => match recipe.kind.usual_material() {
                Some(new) if recipe.kind.process() != usual && !color.is_empty() => {
                    format!("{new}, {color}")
                }
                Some(new) if recipe.kind.process() != usual => new.into(),
                _ => material.into(),
            },
        }
    }

    /// Returns the recipe that a file states for all parts of a kind.
    pub(crate) fn process_for_kind(&self, process: Process) -> Option<&NamedProcess> {
        self.0.of_kind.iter().find(|recipe| recipe.kind.process() == process)
    }
}

/// Assignments for the parts of one fixture, which are addressed by their names in it.
#[derive(Clone, Copy, Debug)]
pub struct FixtureProcesses<'a> {
    making: &'a ProcessAssignments,
    fixture: &'static str,
    usual: Process,
}

/// Process, material and machine of a part.
#[derive(Clone, Debug, PartialEq)]
pub struct PartManufacture {
    /// Process that makes the part.
    pub process: Process,
    /// Material that the part is made from.
    pub material: String,
    /// Machine that makes it, if a file states one.
    pub machine: Option<Machine>,
}

impl PartManufacture {
    /// Returns the name for messages: the machine, or the process.
    pub fn word(&self) -> String {
        self.machine.as_ref().map_or_else(|| self.process.to_string(), |own| own.name.clone())
    }
}

impl<'a> FixtureProcesses<'a> {
    /// Returns the assignments for parts with another usual process.
    #[must_use]
    pub fn with_usual(self, usual: Process) -> Self {
        Self { usual, ..self }
    }

    /// Returns the usual process.
    pub fn usual(&self) -> Process {
        self.usual
    }

    /// Returns the name of a part in patterns.
    fn name(&self, part: &str) -> String {
        format!("{}/{part}", self.fixture)
    }

    /// Returns the gap per side, mm, of a fit in the part that has the hole: see [`gap_mm`].
    pub fn gap_mm(&self, part: impl AsRef<str>, fit: Fit) -> f64 {
        self.making.gap_mm(self.name(part.as_ref()), self.usual, fit)
    }

    /// Returns the largest gap per side, mm, where one shape serves several parts.
    pub fn widest_gap_mm<N: AsRef<str>>(
        &self,
        parts: impl IntoIterator<Item = N>,
        fit: Fit,
    ) -> f64 {
        // Without statements all parts have the same gap.
        if self.making.is_usual() {
            return gap_mm(self.usual, fit);
        }
        let gaps = parts.into_iter().map(|part| self.gap_mm(part, fit));
        gaps.fold(f64::NEG_INFINITY, f64::max)
    }

    /// Returns process, material and machine of a part that is usually made from `material`.
    pub fn manufacture(&self, part: impl AsRef<str>, material: &str) -> PartManufacture {
        let name = self.name(part.as_ref());
        let recipe = self.making.process_for(&name);
        PartManufacture {
            process: recipe.map_or(self.usual, |recipe| recipe.kind.process()),
            material: self.making.material(&name, self.usual, material),
            machine: recipe
                .or_else(|| self.making.process_for_kind(self.usual))
                .map(NamedProcess::machine),
        }
    }
}

/// Returns the gap of a recipe: its own, otherwise the one of its kind.
fn gap_of(recipe: &NamedProcess, fit: Fit) -> f64 {
    recipe.clearance_mm(fit).unwrap_or_else(|| gap_mm(recipe.kind.process(), fit))
}

/// Returns whether a name matches a pattern, in which `*` stands for any text.
pub(crate) fn matches_pattern(pattern: &str, name: &str) -> bool {
    let mut pieces = pattern.split('*');
    let first = pieces.next().unwrap_or_default();
    let Some(mut rest) = name.strip_prefix(first) else { return false };
    let mut pieces: Vec<&str> = pieces.collect();
    // A pattern without `*` has to match exactly.
    let Some(last) = pieces.pop() else { return rest.is_empty() };
    for piece in pieces {
        // Leftmost matches suffice, because only the last piece is anchored at the end.
        let Some(at) = rest.find(piece) else { return false };
        rest = &rest[at + piece.len()..];
    }
    rest.ends_with(last)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn star_matches_any_text() {
        for (pattern, name, is_it) in [
            ("mold-*", "mold-gel-a", true),
            ("mold-*", "my-mold-a", false),
            ("*-a", "mold-gel-a", true),
            ("mold-*-a", "mold-gel-a", true),
            ("mold-*-a", "mold-a", false),
            ("*", "", true),
            ("lid", "lid", true),
            ("lid", "lids", false),
            ("a*a", "a", false),
            ("*el*l*", "gel-lid", true),
        ] {
            assert_eq!(matches_pattern(pattern, name), is_it, "{pattern} {name}");
        }
    }
}
