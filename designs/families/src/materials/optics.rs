//! Reflection and transmission of materials, with the source of each figure.

use fabkit_geometry::{Gloss, OpticalFigure, OpticalProperties};
use fabkit_text::{Setting, SourceKind, ValueSource};

use super::{Clarity, Material, Percent, Reflectance, Scattering, Shade};

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
        scattering_per_mm: figures.scattering.map(|Scattering(per_mm)| {
            figure(per_mm, source("scattering"), figures.source.as_deref())
        }),
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
        scattering_per_mm: None,
    }
}

/// Joins the optics and the transparency that words beside a name state with those of its entry. `both` are shade and
/// transparency of the two together.
pub(super) fn combined_optics(
    (words, clarity): (&OpticalProperties, Option<Clarity>),
    entry: OpticalProperties,
    both: (Option<Shade>, Option<Clarity>),
) -> OpticalProperties {
    // What a clear sheet lets through says nothing of a white one.
    let is_clear = clarity.is_none_or(|clarity| clarity == Clarity::Clear);
    // White is opaque to the eye, too, and thin sheets of it are diffusers.
    let is_stopped = both == (Some(Shade::Dark), Some(Clarity::Opaque));
    let stopped = || OpticalFigure {
        value: 0.0,
        is_chosen: true,
        source: "dark and opaque: its pigment takes up what would pass".to_owned(),
    };
    let transmission = words.transmission.clone().or(entry.transmission.filter(|_| is_clear));
    OpticalProperties {
        reflectance: words.reflectance.clone().or(entry.reflectance),
        gloss: None,
        transmission: transmission.or_else(|| is_stopped.then(stopped)),
        scattering_per_mm: None,
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

#[cfg(test)]
mod tests {
    use fabkit_geometry::{Body, OpticalClarity, Process, Solid};

    use super::super::StockCatalogue;

    #[test]
    fn colours_and_finishes_state_how_light_is_reflected_and_passes() {
        let optics = |material: &str| {
            let part = Body::made("part", "", Process::Laser, Solid::cuboid(1.0, 1.0, 1.0));
            let optics = StockCatalogue::builtin().properties(&part.with_material(material)).optics;
            let figures = [
                optics.reflectance.as_ref().map(|figure| &figure.source),
                optics.transmission.as_ref().map(|figure| &figure.source),
            ];
            assert!(figures.into_iter().flatten().all(|source| !source.is_empty()), "{material}");
            (optics.mean_reflectance(), optics.transmission.map(|passes| passes.value))
        };
        for (material, reflectance, transmission) in [
            ("PLA", None, None),
            ("black PLA", Some(0.05), Some(0.0)),
            ("white PLA", Some(0.85), None),
            ("white resin", Some(0.85), Some(0.5)),
            ("clear PMMA", None, Some(0.92)),
            ("white PMMA", Some(0.85), None),
            ("acrylic frosted on both sides", None, Some(0.5)),
            ("black acrylic, frosted", Some(0.05), Some(0.0)),
            ("Tango Black+", Some(0.05), Some(0.0)),
            ("unobtainium", None, None),
        ] {
            assert_eq!(optics(material), (reflectance, transmission), "{material}");
        }
        let through = |process, material| {
            let body = Body::made("ring", "", process, Solid::cylinder(9.0, 2.0));
            StockCatalogue::builtin().diffuser_transparency(&body.with_material(material))
        };
        assert_eq!(through(Process::Sla, "black resin"), Some(OpticalClarity::Opaque));
        assert_eq!(through(Process::PolyJet, "Vero Black"), Some(OpticalClarity::Opaque));
        assert_eq!(through(Process::Sla, "white resin"), Some(OpticalClarity::Translucent));
        assert_eq!(through(Process::Sla, "clear resin"), Some(OpticalClarity::Translucent));
        assert_eq!(through(Process::Laser, "clear PMMA"), Some(OpticalClarity::Clear));
        assert_eq!(through(Process::Laser, "white PMMA"), Some(OpticalClarity::Translucent));
        assert_eq!(through(Process::Laser, "unobtainium"), None);
    }
}
