//! Lens models by name, each with a number of coefficients: what files may hold, and what pictures choose among.

use super::{Intrinsics, Lens};

/// A lens model with its coefficients. Each declares itself in its own file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LensModel {
    /// As the command calls it.
    pub(super) name: &'static str,
    /// The model's own name, which those with other numbers of coefficients share.
    pub(super) of: &'static str,
    /// Names of the coefficients.
    pub(super) coefficients: &'static [&'static str],
    /// Coefficients of a lens that is a plain one near its axis.
    pub(super) plain: &'static [f64],
}

impl LensModel {
    /// As the command calls it.
    pub fn name(self) -> &'static str {
        self.name
    }

    /// The model of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|model| model.name == name)
    }

    /// Numbers to be found: focal lengths, centre and coefficients.
    pub fn parameter_count(self) -> usize {
        4 + self.coefficients.len()
    }

    /// A lens of this model that is a plain one near its axis; `None` for intrinsics that no lens has.
    pub fn plain(self, intrinsics: Intrinsics) -> Option<Lens> {
        Lens::of_model(self.of, intrinsics, self.plain)?.ok()
    }

    /// The names of all models in files: those with the most coefficients first.
    pub(crate) fn file_names() -> Vec<&'static str> {
        let mut models = Self::ALL;
        models.sort_by_key(|model| (usize::MAX - model.coefficients.len(), model.of));
        let mut names: Vec<_> = models.iter().map(|model| model.of).collect();
        names.dedup();
        names
    }

    /// The coefficients that a file gives a model of this name: as many as it begins to name.
    pub(crate) fn coefficients_in_file(
        name: &str,
        is_given: impl Fn(&str) -> bool,
    ) -> Option<&'static [&'static str]> {
        let mut counts: Vec<_> = Self::ALL.iter().filter(|model| model.of == name).collect();
        counts.sort_by_key(|model| model.coefficients.len());
        let coefficients = counts.iter().map(|model| model.coefficients);
        coefficients.reduce(|fewer, more| if is_given(more[fewer.len()]) { more } else { fewer })
    }
}
