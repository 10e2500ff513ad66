//! `fabkit new NAME (--family FAMILY | --extends SENSOR) [-o FILE.yaml]`

use std::fs;
use std::path::{Path, PathBuf};

use fabkit_application::designs::{FamilyEntry, REGISTRY, TemplateBase};
use fabkit_application::fixtures::sensor_template;
use fabkit_application::staging::write_each;
use fabkit_application::text::{FileSafeName, Scalar, to_printable};
use fabkit_application::{Explained, UnknownName};
use serde_json::json;

use super::Outcome;
use crate::cli::New;
use crate::failure::{ErrorKind, Failure};
use crate::interrupt;

pub(super) fn run(args: &New) -> Result<Outcome, Failure> {
    let name = sensor_name(&args.name)?;
    let (start, what) = match (&args.family, &args.extends) {
        (Some(family), _) => {
            (TemplateBase::Family(family), format!("a sensor of the family {family}"))
        }
        (None, sensor) => {
            let sensor = sensor.as_deref().unwrap_or_default();
            (TemplateBase::Extends(sensor), format!("extends {sensor}"))
        }
    };
    let text = sensor_template(&name, start).ok_or_else(|| unknown(start))?;
    let place = match &args.output {
        Some(place) => place.clone(),
        None => PathBuf::from(format!("{}.yaml", name.as_str())),
    };
    check_place(&place, args.force)?;
    interrupt::begin_writing()?;
    write_each([(place.clone(), text.as_bytes())], &interrupt::is_requested)?;
    let shown = place.display();
    Ok(Outcome {
        text: format!("{shown}: {what}; `fabkit check {shown}` says whether it can be built\n"),
        json: json!({
            "format": "fabkit-new",
            "version": 1,
            "file": shown.to_string(),
            "name": name.as_str(),
            "family": args.family,
            "extends": args.extends,
        }),
        failed: false,
    })
}

fn sensor_name(text: &str) -> Result<FileSafeName, Failure> {
    FileSafeName::parse(text).map_err(|_| {
        let message = format!("`{}` cannot be a sensor's name", to_printable(text));
        let hint = format!("write {}, for example `my-sensor`", FileSafeName::allowed(&()));
        Failure::new(ErrorKind::BadInput, message, hint)
    })
}

/// Makes the failure for an unknown family or sensor.
fn unknown(start: TemplateBase) -> Failure {
    let families = REGISTRY.families().iter().map(FamilyEntry::name);
    let (unknown, all) = match start {
        TemplateBase::Family(word) => {
            (UnknownName::new("family", word, families), "the families are")
        }
        TemplateBase::Extends(sensor) => {
            let unknown = UnknownName::new("built-in sensor", sensor, REGISTRY.builtin_names());
            (unknown, "the built-in sensors are")
        }
    };
    let closest = unknown.closest.as_ref().map(|_| unknown.hint() + " ").unwrap_or_default();
    let hint = format!("{closest}{all} {}", unknown.known.join(", "));
    Failure::new(ErrorKind::BadInput, &unknown, hint).with_subject(unknown.subject())
}

/// Checks the path of a new sensor file: it must end in `.yaml`. Existing files are replaced only by force, because
/// people edit them.
fn check_place(place: &Path, forced: bool) -> Result<(), Failure> {
    let shown = place.display();
    if !place.extension().is_some_and(|ending| ending == "yaml" || ending == "yml") {
        let hint = "sensors' files do; write for example `-o my-sensor.yaml`";
        return Err(Failure::new(
            ErrorKind::BadInput,
            format!("{shown} does not end in .yaml"),
            hint,
        ));
    }
    if !forced && fs::symlink_metadata(place).is_ok() {
        let hint = "choose another file with -o, or let --force replace it";
        return Err(Failure::new(ErrorKind::BadInput, format!("{shown} is there already"), hint));
    }
    Ok(())
}
