//! Words that stand beside the name of a material: colours, finishes, shapes.

use std::sync::LazyLock;

use fabkit_geometry::{OpticalFigure, OpticalProperties};
use fabkit_text::Setting;

use super::stock_file::{DIALECT, read_builtin};
use super::{Clarity, Percent, Reflectance, optics};
use crate::user_catalogue::named_sections::{SectionKind, read};
use crate::{choices, sections};

choices! {
    /// Brightness of a material, where a camera tells it from another one.
    pub enum Shade {
        /// Black or nearly so.
        Dark = "dark",
        /// White or of bright metal.
        Light = "light",
    }
}

choices! {
    /// Treatment of a surface, which decides whether the material below it inhibits cures.
    pub enum SurfaceTreatment {
        /// Varnished, painted, baked: nothing of the material reaches the liquid.
        Sealed = "sealed",
        /// As it was made, whatever a step says.
        Bare = "bare",
    }
}

sections! {
    /// Words that stand beside the name of a material, and what they say of it.
    pub struct Qualifier {
        /// Words in lower case.
        words: Vec<String> = (1..=64, 1..=40),
        /// Transparency that the words state.
        clarity: Option<Clarity>,
        /// Brightness that the words state.
        shade: Option<Shade>,
        /// Treatment of the surface that the words state.
        surface: Option<SurfaceTreatment>,
        /// True for words that say nothing of the material: `sheet`, `on`.
        filler: Option<bool>,
        /// Diffuse reflectance that the words state.
        reflectance: Option<Reflectance> = 0.0..=100.0,
        /// Share of the light that passes, as the words state it.
        transmission: Option<Percent> = 0.0..=100.0,
    }
}

const QUALIFIERS: SectionKind = SectionKind { key: "qualifiers", dialect: &DIALECT };

/// Rows of the built-in file.
static TABLE: LazyLock<Vec<(Qualifier, OpticalProperties)>> = LazyLock::new(|| {
    let mut found = Vec::new();
    let mut rows = Vec::new();
    for raw in read_builtin(QUALIFIERS, &mut found) {
        let stack = vec![(raw.place.clone(), raw.entries)];
        rows.extend(read::<Qualifier>(QUALIFIERS, &raw.name, &raw.place, stack, &mut found));
    }
    debug_assert!(found.is_empty(), "{found:#?}");
    let with_optics = |(row, settings): (Qualifier, Vec<Setting>)| {
        let optics = optics::optics_of_row(row.reflectance, row.transmission, &settings, None);
        (row, optics)
    };
    rows.into_iter().map(with_optics).collect()
});

/// What the words beside the name of a material say.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Qualities {
    /// Transparency.
    pub clarity: Option<Clarity>,
    /// Brightness.
    pub shade: Option<Shade>,
    /// Treatment of the surface.
    pub surface: Option<SurfaceTreatment>,
    /// Reflectance and transmission.
    pub optics: OpticalProperties,
}

/// Returns what the words beside a material's name say, as far as a table explains them.
pub(super) fn explain(words: &[String]) -> Qualities {
    let mut said = Qualities::default();
    for (row, optics) in words.iter().filter_map(|word| qualifier(word)) {
        // Pigment stops light that a finish would scatter, and frost scatters light that clear material would pass.
        said.clarity = match (said.clarity, row.clarity) {
            (Some(Clarity::Opaque), _) | (_, Some(Clarity::Opaque)) => Some(Clarity::Opaque),
            (Some(Clarity::Translucent), _) => Some(Clarity::Translucent),
            (known, new) => new.or(known),
        };
        said.shade = said.shade.or(row.shade);
        // `uncoated` outweighs a sealing word in the same name.
        said.surface = match (said.surface, row.surface) {
            (Some(SurfaceTreatment::Bare), _) => Some(SurfaceTreatment::Bare),
            (known, new) => new.or(known),
        };
        said.optics.reflectance = said.optics.reflectance.or_else(|| optics.reflectance.clone());
        // Light passes pigment and finish in turn: at most what either lets through.
        let share = |figure: &OpticalFigure<f64>| figure.value;
        said.optics.transmission = match (said.optics.transmission, optics.transmission.clone()) {
            (Some(known), Some(new)) if share(&new) < share(&known) => Some(new),
            (known, new) => known.or(new),
        };
    }
    said
}

/// Returns whether a word may stand beside the name of any material.
pub(super) fn is_explained(word: &str) -> bool {
    qualifier(word).is_some()
}

/// Returns whether a word says something of the material beside whose name it stands.
pub(super) fn has_meaning(word: &str) -> bool {
    qualifier(word).is_some_and(|(row, _)| row.filler != Some(true))
}

fn qualifier(word: &str) -> Option<&'static (Qualifier, OpticalProperties)> {
    TABLE.iter().find(|(row, _)| row.words.iter().any(|known| known == word))
}

/// Splits a name into words in lower case. Hyphens and plus signs belong to words.
pub(super) fn words(text: &str) -> Vec<String> {
    let text = text.to_lowercase();
    let words = text.split(|c: char| !(c.is_alphanumeric() || matches!(c, '-' | '+')));
    words.filter(|word| !word.is_empty()).map(str::to_owned).collect()
}

/// Returns the number of rows in the built-in file.
#[cfg(test)]
pub(super) fn row_count() -> usize {
    TABLE.len()
}
