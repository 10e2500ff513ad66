//! Slicer settings of parts.

use fabkit_checks::{ChosenSetting, PrintSettings, print_settings};
use fabkit_export::SlicerSettings;
use fabkit_geometry::{Body, Process, Sensor};

use super::ExportRunError;

/// Slicer settings of a part, with their reasons as text.
#[derive(Clone, Debug, Default)]
pub(super) struct SlicerInstructions {
    pub settings: Option<SlicerSettings>,
    pub reasons_text: String,
}

/// Chooses the slicer settings of a part.
///
/// # Errors
/// [`ExportRunError::Examined`] if its solid is invalid.
pub(super) fn slicer_instructions(
    sensor: &Sensor,
    body: &Body,
) -> Result<SlicerInstructions, ExportRunError> {
    let about = match (print_settings(sensor, body)?, body.process()) {
        (Some(settings), _) => {
            let about = format!("{}: {}.", body.name, reasons(&settings));
            return Ok(SlicerInstructions {
                settings: Some(slicer(&settings)),
                reasons_text: about,
            });
        }
        (None, Some(process @ (Process::Sla | Process::PolyJet))) => format!(
            "{}: no settings, because layers, exposure and supports of {process} are the resin's and the \
             printer's.",
            body.name
        ),
        _ => String::new(),
    };
    Ok(SlicerInstructions { settings: None, reasons_text: about })
}

fn slicer(settings: &PrintSettings) -> SlicerSettings {
    SlicerSettings {
        layer_mm: settings.layer_mm.value,
        perimeters: settings.perimeters.value,
        solid_layers: settings.solid_layers.value,
        infill_percent: settings.infill_percent.value,
        supports: settings.supports.value,
        brim_mm: settings.brim_mm.value,
    }
}

/// Joins all settings with their reasons in one sentence.
fn reasons(settings: &PrintSettings) -> String {
    fn because<T>(what: String, chosen: &ChosenSetting<T>) -> String {
        format!("{what} ({})", chosen.reason)
    }
    let supports = if settings.supports.value { "supports" } else { "no supports" };
    let brim = match settings.brim_mm.value {
        0.0 => "no brim".to_owned(),
        mm => format!("brim {mm} mm"),
    };
    [
        because(format!("layers {} mm", settings.layer_mm.value), &settings.layer_mm),
        because(format!("{} perimeters", settings.perimeters.value), &settings.perimeters),
        because(format!("{} solid layers", settings.solid_layers.value), &settings.solid_layers),
        because(format!("infill {} %", settings.infill_percent.value), &settings.infill_percent),
        because(supports.to_owned(), &settings.supports),
        because(brim, &settings.brim_mm),
    ]
    .join("; ")
}
