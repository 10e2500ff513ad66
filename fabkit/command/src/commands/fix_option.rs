//! Option `--fix`: automatic changes of values chosen by fabkit.

use fabkit_application::designs::fixing::ValueChange;
use fabkit_application::documents;
use fabkit_application::source::Target;
use serde_json::Value;

use crate::cli::{Command, Design, Export, Global, Render, Verify};
use crate::failure::Failure;
use crate::terminal;

/// Adds the automatic changes to the command's overrides and returns them; `None` without `--fix`.
pub(super) fn apply_fix(command: &mut Command) -> Result<Option<Vec<ValueChange>>, Failure> {
    let (sensor, preset, set, is_wanted) = match command {
        Command::Show(args) => design_fields(&mut args.design),
        Command::Check(args) => design_fields(&mut args.design),
        Command::Depth(args) => design_fields(&mut args.design),
        Command::Capture(args) => design_fields(&mut args.design),
        Command::FitLight(args) => design_fields(&mut args.design),
        Command::Reconstruct(args) => design_fields(&mut args.design),
        Command::Bench(args) => design_fields(&mut args.design),
        Command::OpticsPack(args) => design_fields(&mut args.design),
        Command::Press(args) => design_fields(&mut args.design),
        Command::Dataset(args) => design_fields(&mut args.design),
        Command::Guide(args) => design_fields(&mut args.design),
        Command::Export(Export { sensor, preset, set, fix, .. })
        | Command::Render(Render { sensor, preset, set, fix, .. }) => {
            (&**sensor, preset.as_deref(), set, *fix)
        }
        Command::Verify(Verify { sensor, set, fix, .. }) => match sensor.to_str() {
            Some(sensor) => (sensor, None, set, *fix),
            // No sensor has such a name: a folder is meant.
            None => return Ok(None),
        },
        _ => return Ok(None),
    };
    if !is_wanted {
        return Ok(None);
    }
    let changes = Target::new(sensor).with_preset(preset).fix(set)?;
    set.extend(changes.iter().map(ValueChange::as_override));
    Ok(Some(changes))
}

fn design_fields(design: &mut Design) -> (&str, Option<&str>, &mut Vec<String>, bool) {
    (&design.sensor, design.preset.as_deref(), &mut design.set, design.fix)
}

/// Prints the changes for people, before the work begins.
pub(super) fn print_changes(changes: &[ValueChange], global: &Global) {
    if !global.quiet && !global.json {
        changes.iter().for_each(|change| terminal::tell(&format!("fixed: {change}\n")));
    }
}

/// Adds the changes to a JSON document.
pub(super) fn add_to(document: &mut Value, changes: &[ValueChange]) {
    if let Some(document) = document.as_object_mut() {
        document.insert("changes".into(), documents::changes(changes));
    }
}
