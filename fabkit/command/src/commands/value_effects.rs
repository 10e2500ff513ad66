//! Warnings about values of the user that change nothing, or change the size of the whole.

use fabkit_application::fixtures::ValueEffects;
use fabkit_application::source::{Target, value_effects_json};
use serde_json::Value;

use crate::cli::{Calibrate, Command, Design, Global};
use crate::terminal;

/// Finds the effects of all values that the user set for the designs of a command.
pub(super) fn find_effects(command: &Command) -> ValueEffects {
    let mut found = ValueEffects::default();
    for (target, set) in designs(command) {
        let ValueEffects { effects, not_examined } = target.value_effects(set);
        found.effects.extend(effects);
        found.not_examined += not_examined;
    }
    found
}

/// Returns the designs that a command loads, each with its overrides. Without a wildcard, so that a new command is decided
/// on here.
fn designs(command: &Command) -> Vec<(Target<'_>, &[String])> {
    match command {
        Command::Show(args) => of_design(&args.design),
        Command::Check(args) => of_design(&args.design),
        Command::Depth(args) => of_design(&args.design),
        Command::Capture(args) => of_design(&args.design),
        Command::FitLight(args) => of_design(&args.design),
        Command::Reconstruct(args) => of_design(&args.design),
        Command::Bench(args) => of_design(&args.design),
        Command::OpticsPack(args) => of_design(&args.design),
        Command::Press(args) => of_design(&args.design),
        Command::Dataset(args) => of_design(&args.design),
        Command::Guide(args) => of_design(&args.design),
        Command::Export(args) => {
            vec![(Target::new(&args.sensor).with_preset(args.preset.as_deref()), &args.set[..])]
        }
        Command::Render(args) => {
            vec![(Target::new(&args.sensor).with_preset(args.preset.as_deref()), &args.set[..])]
        }
        // A name that is not UTF-8 is that of a folder.
        Command::Verify(args) => {
            let sensor = args.sensor.to_str().into_iter();
            sensor.map(|sensor| (Target::new(sensor), &args.set[..])).collect()
        }
        Command::Diff(args) => vec![
            (Target::new(&args.from), &args.set_from[..]),
            (Target::new(&args.to), &args.set_to[..]),
        ],
        Command::Calibrate { what } => match what {
            Calibrate::Intrinsics(args) => vec![(Target::new(&args.sensor), &args.set[..])],
            Calibrate::Extrinsics(args) => vec![(Target::new(&args.sensor), &args.set[..])],
            Calibrate::Plan(args) => vec![(Target::new(&args.sensor), &args.set[..])],
            Calibrate::Pins(_) => Vec::new(),
        },
        // A sweep varies its values itself, and its report says which matter.
        Command::Sweep(_) => Vec::new(),
        // These load no design of the user's.
        Command::List
        | Command::New(_)
        | Command::Profile(_)
        | Command::Schema { .. }
        | Command::Completions { .. }
        | Command::Man { .. } => Vec::new(),
    }
}

fn of_design(design: &Design) -> Vec<(Target<'_>, &[String])> {
    let Design { sensor, set, preset, .. } = design;
    vec![(Target::new(sensor).with_preset(preset.as_deref()), &set[..])]
}

/// Prints the effects for people, before the work begins.
pub(super) fn print_effects(found: &ValueEffects, global: &Global) {
    if !global.quiet && !global.json {
        for sentence in found.sentences() {
            terminal::tell(&format!("warning: {sentence}\n"));
        }
    }
}

/// Adds the effects to a JSON document, if there are any.
pub(super) fn add_to(document: &mut Value, found: &ValueEffects) {
    if let Some(document) = document.as_object_mut().filter(|_| !found.effects.is_empty()) {
        document.insert("value_effects".into(), value_effects_json(found));
    }
}
