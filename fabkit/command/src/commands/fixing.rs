//! Option `--fix`: automatic changes of values chosen by fabkit.

use fabkit_application::designs::fixing::Change;
use fabkit_application::documents;
use fabkit_application::source::Target;
use serde_json::Value;

use crate::cli::{Command, Design, Export, Global, Render, Verify};
use crate::failure::Failure;

/// Adds the automatic changes to the command's overrides and returns them; `None` without `--fix`.
pub(super) fn fix(command: &mut Command) -> Result<Option<Vec<Change>>, Failure> {
    let (sensor, preset, set, is_wanted) = match command {
        Command::Show(args) => of(&mut args.design),
        Command::Check(design) => of(design),
        Command::Depth(args) => of(&mut args.design),
        Command::Capture(args) => of(&mut args.design),
        Command::FitLight(args) => of(&mut args.design),
        Command::Reconstruct(args) => of(&mut args.design),
        Command::Bench(args) => of(&mut args.design),
        Command::OpticsPack(args) => of(&mut args.design),
        Command::Press(args) => of(&mut args.design),
        Command::Dataset(args) => of(&mut args.design),
        Command::Guide(args) => of(&mut args.design),
        Command::Export(Export { sensor, preset, set, fix, .. })
        | Command::Render(Render { sensor, preset, set, fix, .. }) => {
            (sensor, preset.as_deref(), set, *fix)
        }
        Command::Verify(Verify { sensor, set, fix, .. }) => (sensor, None, set, *fix),
        _ => return Ok(None),
    };
    if !is_wanted {
        return Ok(None);
    }
    let changes = Target::new(sensor).with_preset(preset).fix(set)?;
    set.extend(changes.iter().map(Change::as_override));
    Ok(Some(changes))
}

fn of(design: &mut Design) -> (&mut String, Option<&str>, &mut Vec<String>, bool) {
    (&mut design.sensor, design.preset.as_deref(), &mut design.set, design.fix)
}

/// Prints the changes for people, before the work begins.
pub(super) fn tell(changes: &[Change], global: &Global) {
    if !global.quiet && !global.json {
        changes.iter().for_each(|change| eprintln!("fixed: {change}"));
    }
}

/// Adds the changes to a JSON document.
pub(super) fn add_to(document: &mut Value, changes: &[Change]) {
    if let Some(document) = document.as_object_mut() {
        document.insert("changes".into(), documents::changes(changes));
    }
}
