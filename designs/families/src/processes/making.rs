//! Fits of parts that a file gives another process.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use fabkit_geometry::{Machine, Process};
use fabkit_text::Place;

use super::Recipe;
use crate::own::named::key_of;
use crate::{Fit, gap_mm};

/// What a file gives to the parts that a pattern names.
#[derive(Clone, Debug)]
pub(crate) struct Given {
    pub pattern: String,
    pub place: Place,
    pub recipe: Option<Recipe>,
    pub material: Option<String>,
}

/// Which parts are made otherwise than their family says, for those who cut fits into them.
///
/// It is read with the parameters of a family, and stands nowhere in a file.
#[derive(Clone, Debug, Default)]
pub struct Making(Arc<Inner>);

#[derive(Debug, Default)]
struct Inner {
    /// Recipes of whole kinds: what a file says of `fdm` goes for every part of that kind.
    of_kind: Vec<Recipe>,
    /// Parts by pattern; the last that fits counts.
    of_parts: Vec<Given>,
    /// Whether the family cuts its fits by what is said here.
    is_asked: AtomicBool,
}

/// What it says does not tell parameters apart: it is the same for all of a design.
impl PartialEq for Making {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Making {
    pub(crate) fn new(of_kind: Vec<Recipe>, of_parts: Vec<Given>) -> Self {
        Self(Arc::new(Inner { of_kind, of_parts, is_asked: AtomicBool::new(false) }))
    }

    /// Gap per side of a fit in a part that has the hole and is usually made by `usual`: see [`gap_mm`].
    ///
    /// A part of a fixture is called `FIXTURE/PART`; see [`Making::in_fixture`].
    pub fn gap_mm(&self, part: impl AsRef<str>, usual: Process, fit: Fit) -> f64 {
        self.0.is_asked.store(true, Ordering::Relaxed);
        let recipe = self.of(part.as_ref()).or_else(|| self.of_kind(usual));
        recipe.map_or_else(|| gap_mm(usual, fit), |recipe| gap_of(recipe, fit))
    }

    /// The same where one shape serves several parts, each with its usual process: the largest gap.
    pub fn widest_mm<N: AsRef<str>>(
        &self,
        parts: impl IntoIterator<Item = (N, Process)>,
        fit: Fit,
    ) -> f64 {
        let gaps = parts.into_iter().map(|(part, usual)| self.gap_mm(part, usual, fit));
        gaps.fold(f64::NEG_INFINITY, f64::max)
    }

    /// How a part is made that is usually made by `usual`.
    pub fn process(&self, part: impl AsRef<str>, usual: Process) -> Process {
        self.of(part.as_ref()).map_or(usual, |recipe| recipe.kind.process())
    }

    /// For the parts of a fixture, which are usually made by `usual`.
    pub fn in_fixture(&self, fixture: &'static str, usual: Process) -> FixtureMaking<'_> {
        FixtureMaking { making: self, fixture, usual }
    }

    /// Whether every part is made as usual: no file says anything.
    fn is_usual(&self) -> bool {
        self.0.of_kind.is_empty() && self.0.of_parts.is_empty()
    }

    /// Whether the family's fits follow.
    pub(crate) fn is_asked(&self) -> bool {
        self.0.is_asked.load(Ordering::Relaxed)
    }

    /// What files say of a part, the last first.
    pub(crate) fn given(&self, part: &str) -> impl Iterator<Item = &Given> + Clone {
        self.0.of_parts.iter().rev().filter(move |given| fits(&given.pattern, part))
    }

    /// Everything that is said of parts.
    pub(crate) fn all_given(&self) -> &[Given] {
        &self.0.of_parts
    }

    /// What a file says of how a part is made.
    pub(crate) fn of(&self, part: &str) -> Option<&Recipe> {
        self.given(part).find_map(|given| given.recipe.as_ref())
    }

    /// What a part is made from that is usually made by `usual` from `material`.
    pub(crate) fn material(&self, part: &str, usual: Process, material: &str) -> String {
        if let Some(given) = self.given(part).find_map(|given| given.material.clone()) {
            return given;
        }
        let Some(recipe) = self.of(part) else { return material.into() };
        // What follows a comma is its color.
        let (plain, color) = material.split_once(", ").unwrap_or((material, ""));
        let suits = |known: &String| [material, plain].map(key_of).contains(&key_of(known));
        match recipe.materials.first() {
            Some(_) if recipe.materials.iter().any(suits) => material.into(),
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

    /// What a file says of every part of a kind.
    pub(crate) fn of_kind(&self, process: Process) -> Option<&Recipe> {
        self.0.of_kind.iter().find(|recipe| recipe.kind.process() == process)
    }
}

/// How the parts of one fixture are made; they are called by their names in it.
#[derive(Clone, Copy, Debug)]
pub struct FixtureMaking<'a> {
    making: &'a Making,
    fixture: &'static str,
    usual: Process,
}

/// How a part is made.
#[derive(Clone, Debug, PartialEq)]
pub struct Made {
    /// Its process.
    pub process: Process,
    /// From what.
    pub material: String,
    /// On what, where a file says so.
    pub machine: Option<Machine>,
}

impl Made {
    /// What messages call it: the machine, or the process.
    pub fn word(&self) -> String {
        self.machine.as_ref().map_or_else(|| self.process.to_string(), |own| own.name.clone())
    }
}

impl<'a> FixtureMaking<'a> {
    /// For parts that are usually made in another way.
    #[must_use]
    pub fn usually(self, usual: Process) -> Self {
        Self { usual, ..self }
    }

    /// How they are made where nobody says anything.
    pub fn usual(&self) -> Process {
        self.usual
    }

    fn name(&self, part: &str) -> String {
        format!("{}/{part}", self.fixture)
    }

    /// Gap per side of a fit in a part that has the hole: see [`gap_mm`].
    pub fn gap_mm(&self, part: impl AsRef<str>, fit: Fit) -> f64 {
        self.making.gap_mm(self.name(part.as_ref()), self.usual, fit)
    }

    /// The same where one shape serves several parts: the largest gap.
    pub fn widest_mm<N: AsRef<str>>(&self, parts: impl IntoIterator<Item = N>, fit: Fit) -> f64 {
        if self.making.is_usual() {
            return gap_mm(self.usual, fit);
        }
        let gaps = parts.into_iter().map(|part| self.gap_mm(part, fit));
        gaps.fold(f64::NEG_INFINITY, f64::max)
    }

    /// How a part is made that is usually made from `material`.
    pub fn made(&self, part: impl AsRef<str>, material: &str) -> Made {
        let name = self.name(part.as_ref());
        let recipe = self.making.of(&name);
        Made {
            process: recipe.map_or(self.usual, |recipe| recipe.kind.process()),
            material: self.making.material(&name, self.usual, material),
            machine: recipe.or_else(|| self.making.of_kind(self.usual)).map(Recipe::machine),
        }
    }
}

fn gap_of(recipe: &Recipe, fit: Fit) -> f64 {
    recipe.clearance_mm(fit).unwrap_or_else(|| gap_mm(recipe.kind.process(), fit))
}

/// Whether a name is as a pattern says, in which `*` stands for anything.
pub(crate) fn fits(pattern: &str, name: &str) -> bool {
    let mut pieces = pattern.split('*');
    let first = pieces.next().unwrap_or_default();
    let Some(mut rest) = name.strip_prefix(first) else { return false };
    let mut pieces: Vec<&str> = pieces.collect();
    let Some(last) = pieces.pop() else { return rest.is_empty() };
    for piece in pieces {
        let Some(at) = rest.find(piece) else { return false };
        rest = &rest[at + piece.len()..];
    }
    rest.ends_with(last)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_star_stands_for_anything() {
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
            assert_eq!(fits(pattern, name), is_it, "{pattern} {name}");
        }
    }
}
