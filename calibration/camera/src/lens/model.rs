//! Registered lens models by name and number of coefficients, for files and for the choice of a model.

use super::{Intrinsics, Lens};

/// Lens model with a fixed set of coefficients. Each is declared in the file of its model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LensModel {
    /// Name on the command line.
    pub(super) name: &'static str,
    /// Name of the model itself, shared by variants with other numbers of coefficients.
    pub(super) family: &'static str,
    /// Names of the coefficients, in their order.
    pub(super) coefficients: &'static [&'static str],
    /// Coefficients of a lens without distortion near its axis, as start values.
    pub(super) start_coefficients: &'static [f64],
}

impl LensModel {
    /// Name on the command line.
    pub fn name(self) -> &'static str {
        self.name
    }

    /// Finds the model with a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|model| model.name == name)
    }

    /// Number of unknowns in a calibration: focal lengths, centre and coefficients.
    pub fn parameter_count(self) -> usize {
        4 + self.coefficients.len()
    }

    /// Creates a lens of this model without distortion near its axis; `None` for impossible intrinsics.
    pub fn start_lens(self, intrinsics: Intrinsics) -> Option<Lens> {
        Lens::from_model_name(self.family, intrinsics, self.start_coefficients)?.ok()
    }

    /// Names of all models in files, those with the most coefficients first.
    pub(crate) fn file_names() -> Vec<&'static str> {
        let mut models = Self::ALL;
        models.sort_by_key(|model| (usize::MAX - model.coefficients.len(), model.family));
        let mut names: Vec<_> = models.iter().map(|model| model.family).collect();
        names.dedup();
        names
    }

    /// Returns the coefficient names that a file must give for this model: of its variants, the one with the most
    /// coefficients whose first additional one is given.
    pub(crate) fn coefficients_in_file(
        name: &str,
        is_given: impl Fn(&str) -> bool,
    ) -> Option<&'static [&'static str]> {
        let mut counts: Vec<_> = Self::ALL.iter().filter(|model| model.family == name).collect();
        counts.sort_by_key(|model| model.coefficients.len());
        let coefficients = counts.iter().map(|model| model.coefficients);
        // Variants of a model share their first coefficients.
        coefficients.reduce(|fewer, more| if is_given(more[fewer.len()]) { more } else { fewer })
    }
}
