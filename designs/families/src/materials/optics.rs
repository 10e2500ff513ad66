//! Reflection and transmission of materials, with the source of each figure.

use fabkit_geometry::{Gloss, OpticalFigure, OpticalProperties};
use fabkit_text::{Setting, SourceKind, ValueSource};

use super::{Material, Percent, Reflectance};

/// Exponent of a gloss that reflects nothing, where it does not matter.
const NO_GLOSS_EXPONENT: f64 = 1.0;

/// Returns the optics of a material that is cast, sprayed or painted.
pub(super) fn optics_of_castable(material: &Material) -> OpticalProperties {
    let figures = &material.figures;
    let source = |key: &str| source_of(&material.settings, key);
    let gloss = figures.gloss.map(Percent::share).and_then(|share| {
        let exponent = figures.gloss_exponent.or((share == 0.0).then_some(NO_GLOSS_EXPONENT))?;
        Some(figure(Gloss { share, exponent }, source("gloss"), figures.source.as_deref()))
    });
    let reflectance = figures.reflectance.map(Reflectance::shares);
    OpticalProperties {
        reflectance: reflectance
            .map(|rgb| figure(rgb, source("reflectance"), figures.source.as_deref())),
        gloss,
        transmission: None,
    }
}

/// Returns the optics that a row of stock, or of words beside its name, states.
pub(super) fn optics_of_row(
    reflectance: Option<Reflectance>,
    transmission: Option<Percent>,
    settings: &[Setting],
    row_source: Option<&str>,
) -> OpticalProperties {
    let source = |key: &str| source_of(settings, key);
    OpticalProperties {
        reflectance: reflectance
            .map(|percent| figure(percent.shares(), source("reflectance"), row_source)),
        gloss: None,
        transmission: transmission
            .map(|percent| figure(percent.share(), source("transmission"), row_source)),
    }
}

/// Finds the source of the value below a key.
fn source_of<'s>(settings: &'s [Setting], key: &str) -> Option<&'s ValueSource> {
    let is_it = |setting: &&Setting| {
        setting.path.strip_suffix(key).is_some_and(|before| before.ends_with('.'))
    };
    settings.iter().find(is_it).map(|setting| &setting.source)
}

/// Joins a value with its own source, or else with that of its row.
fn figure<T>(value: T, source: Option<&ValueSource>, row: Option<&str>) -> OpticalFigure<T> {
    let own = source.map(|source| &*source.note).filter(|note| !note.is_empty());
    OpticalFigure {
        value,
        is_chosen: source.is_some_and(|source| source.kind == SourceKind::Chosen),
        source: own.or(row).unwrap_or_default().to_owned(),
    }
}
