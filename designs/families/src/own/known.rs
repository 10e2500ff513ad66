//! Context that parameters are read with, and the parameters that are looked up in it.

use fabkit_text::{Look, Parameter, Reader, Refusal, Shape};

use super::named::near;
use crate::materials::{Castable, Catalogue};
use crate::processes::Making;

/// Context that parameters are read with.
#[derive(Clone, Debug)]
pub(crate) struct Known {
    /// All materials that may be named.
    pub materials: Catalogue,
    /// Processes and materials that files assign to parts.
    pub making: Making,
}

/// Reads a material by its name, which is looked up in the reader's context.
impl Parameter for Castable {
    type Limits = ();

    fn shape((): &()) -> Shape {
        match <String as Parameter>::shape(&(1..=80)) {
            Shape::Value { is_list, kind, schema, .. } => {
                Shape::Value { is_list, kind, allowed: ALLOWED.into(), schema }
            }
            section @ Shape::Section(_) => section,
        }
    }

    fn read(reader: &mut Reader, path: &str, summary: &str, (): &()) -> Option<Self> {
        let known = reader.known::<Known>().map(|known| &known.materials);
        // Readers without context know the built-in materials only.
        let known = known.unwrap_or_else(|| Catalogue::builtin()).clone();
        reader.looked_up(path, summary, ALLOWED, |text| match known.find(text) {
            Some(castable) => Ok((castable.clone(), String::from(castable))),
            None => {
                let near = near(text, known.names());
                let known_names = if near.is_empty() {
                    "`fabkit show SENSOR` lists the known ones".to_owned()
                } else {
                    fabkit_text::did_you_mean(&near)
                };
                let hint = format!(
                    "{known_names}; or declare your own: `materials: {{{}: {{density: 1 g/cm3, cure: \
                     {{time: 24 h}}}}}}`",
                    fabkit_text::shown(text.trim())
                );
                let refusal = Refusal::new("of which fabkit knows neither mix nor cure", &hint);
                let instead = near.first().map(|name| (*name).to_owned());
                Err(Refusal { instead, ..refusal.code("unknown_material") })
            }
        })
    }

    fn neighbours(&self, _: &str, (): &(), _: f64, _: Look<Self>) {}
}

/// Description of the allowed values, for people.
const ALLOWED: &str = "a known material";

/// Takes the assignments from the reader's context: they are no parameter of a file.
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
