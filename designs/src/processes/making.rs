//! Fits of parts that a file gives another process.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use fabkit_geometry::Process;
use fabkit_text::{Look, Parameter, Reader, Shape};

use super::Recipe;
use crate::assembling::Name;
use crate::own::Known;
use crate::{Fit, gap_mm};

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
    of_parts: Vec<(String, Recipe)>,
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
    pub(crate) fn new(of_kind: Vec<Recipe>, of_parts: Vec<(String, Recipe)>) -> Self {
        Self(Arc::new(Inner { of_kind, of_parts, is_asked: AtomicBool::new(false) }))
    }

    /// Gap per side of a fit in a part that has the hole and is usually made by `usual`: see [`gap_mm`].
    pub fn gap_mm(&self, part: Name, usual: Process, fit: Fit) -> f64 {
        self.0.is_asked.store(true, Ordering::Relaxed);
        let recipe = self.of(part.name).or_else(|| self.of_kind(usual));
        recipe.map_or_else(|| gap_mm(usual, fit), |recipe| gap_of(recipe, fit))
    }

    /// The same where one shape serves several parts, each with its usual process: the largest gap.
    pub fn widest_mm(&self, parts: impl IntoIterator<Item = (Name, Process)>, fit: Fit) -> f64 {
        let gaps = parts.into_iter().map(|(part, usual)| self.gap_mm(part, usual, fit));
        gaps.fold(f64::NEG_INFINITY, f64::max)
    }

    /// Whether the family's fits follow.
    pub(crate) fn is_asked(&self) -> bool {
        self.0.is_asked.load(Ordering::Relaxed)
    }

    /// What a file says of a part.
    pub(crate) fn of(&self, part: &str) -> Option<&Recipe> {
        let given = self.0.of_parts.iter().rev().find(|(pattern, _)| fits(pattern, part));
        given.map(|(_, recipe)| recipe)
    }

    /// What a file says of every part of a kind.
    pub(crate) fn of_kind(&self, process: Process) -> Option<&Recipe> {
        self.0.of_kind.iter().find(|recipe| recipe.kind.process() == process)
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

/// It stands nowhere in a file.
impl Parameter for Making {
    type Limits = ();

    fn shape((): &()) -> Shape {
        Shape::Section(Vec::new())
    }

    fn read(reader: &mut Reader, _: &str, _: &str, (): &()) -> Option<Self> {
        Some(reader.known::<Known>().map(|known| known.making.clone()).unwrap_or_default())
    }

    fn neighbours(&self, _: &str, (): &(), _: f64, _: Look<Self>) {}
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
