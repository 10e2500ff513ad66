//! Context that parameters are read with, and the parameters that are looked up in it.

use fabkit_text::{FieldShape, NeighbourCallback, Parameter, Reader, Refusal};

use super::named_sections::similar_names;
use crate::materials::{Castable, Catalogue};
use crate::processes::ProcessAssignments;

/// Context that parameters are read with.
#[derive(Clone, Debug)]
pub(crate) struct ReaderContext {
    /// All materials that may be named.
    pub materials: Catalogue,
    /// Processes and materials that files assign to parts.
    pub making: ProcessAssignments,
}

/// Reads a material by its name, which is looked up in the reader's context.
impl Parameter for Castable {
    type Limits = ();

    fn shape((): &()) -> FieldShape {
        match <String as Parameter>::shape(&(1..=80)) {
            FieldShape::Value { is_list, kind, schema, .. } => {
                FieldShape::Value { is_list, kind, allowed: ALLOWED.into(), schema }
            }
            section @ FieldShape::Section(_) => section,
        }
    }

    fn read(reader: &mut Reader, path: &str, summary: &str, (): &()) -> Option<Self> {
        let known = reader.context::<ReaderContext>().map(|known| &known.materials);
        // Readers without context know the built-in materials only.
        let known = known.unwrap_or_else(|| Catalogue::builtin()).clone();
        reader.read_lookup(path, summary, ALLOWED, |text| match known.find(text) {
            Some(castable) => Ok((castable.clone(), String::from(castable))),
            None => {
                let near = similar_names(text, known.names());
                let known_names = if near.is_empty() {
                    "`fabkit show SENSOR` lists the known ones".to_owned()
                } else {
                    fabkit_text::did_you_mean(&near)
                };
                let hint = format!(
                    "{known_names}; or declare your own: `materials: {{{}: {{density: 1 g/cm3, cure: \
                     {{time: 24 h}}}}}}`",
                    fabkit_text::to_printable(text.trim())
                );
                let refusal = Refusal::new("of which fabkit knows neither mix nor cure", &hint);
                let instead = near.first().map(|name| (*name).to_owned());
                Err(Refusal { instead, ..refusal.code("unknown_material") })
            }
        })
    }

    fn neighbours(&self, _: &str, (): &(), _: f64, _: NeighbourCallback<Self>) {}
}

/// Description of the allowed values, for people.
const ALLOWED: &str = "a known material";

/// Takes the assignments from the reader's context: they are no parameter of a file.
impl Parameter for ProcessAssignments {
    type Limits = ();

    fn shape((): &()) -> FieldShape {
        FieldShape::Section(Vec::new())
    }

    fn read(reader: &mut Reader, _: &str, _: &str, (): &()) -> Option<Self> {
        Some(
            reader.context::<ReaderContext>().map(|known| known.making.clone()).unwrap_or_default(),
        )
    }

    fn neighbours(&self, _: &str, (): &(), _: f64, _: NeighbourCallback<Self>) {}
}
