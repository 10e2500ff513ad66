//! `fabkit show SENSOR`

mod chain;
mod limits;

use std::iter;

use fabkit_application::designs::Design;
use fabkit_application::documents;
use fabkit_application::geometry::Body;
use fabkit_application::identity::design_hash;
use fabkit_application::source::Target;
use fabkit_application::text::shown;

use super::Outcome;
use crate::cli;
use crate::failure::Failure;
use crate::table::{Align::Left, Align::Right, table};

pub(super) fn run(args: &cli::Show, global: &cli::Global) -> Result<Outcome, Failure> {
    if args.limits {
        return limits::run(&args.design, global);
    }
    let cli::Design { sensor, set, preset, fix: _ } = &args.design;
    let design = Target::new(sensor).with_preset(preset.as_deref()).design(set)?;
    let (text, json) = match args.chain {
        true => (chain::text(&design), chain::json(&design)),
        false => (text(&design), documents::show(&design)),
    };
    Ok(Outcome { text, json, failed: false })
}

fn text(design: &Design) -> String {
    let sensor = &design.sensor;
    let mut text = format!("{}: {}\n{}\n", sensor.name, sensor.title, sensor.reference);
    text += &format!("design {}\n", design_hash(design));

    let mut rows = vec![row(["parameter", "value", "limits", "source"])];
    for setting in &design.parameters {
        let kind = match &setting.expression {
            // The whole text stands in the file, and in `--json`.
            Some(expression) => format!("{} `{}`", setting.source.kind, shown(expression)),
            None => setting.source.kind.to_string(),
        };
        let source = match setting.source.note.as_str() {
            "" => kind,
            note => format!("{kind}: {note}"),
        };
        rows.push(vec![
            setting.path.clone(),
            setting.value.clone(),
            setting.limits.clone(),
            source,
        ]);
    }
    text += &format!("\n{}", table(&[Left, Left, Left, Left], &rows));

    if !design.derived.is_empty() {
        let mut rows = vec![row(["derived", "value"])];
        rows.extend(design.derived.iter().map(|(name, value)| row([name, value])));
        text += &format!("\n{}", table(&[Left, Left], &rows));
    }

    for kind in ["part", "layer", "component"] {
        let mut rows = vec![row([kind, "n", "made", "of", "what it is"])];
        for body in sensor.bodies.iter().filter(|body| body.kind.word() == kind) {
            let quantity = body.quantity.to_string();
            rows.push(row([
                &body.name,
                &quantity,
                &body.process_word(),
                &body.material,
                &body.summary,
            ]));
        }
        if rows.len() > 1 {
            text += &format!("\n{}", table(&[Left, Right, Left, Left, Left], &rows));
        }
    }
    let notes = notes(&sensor.bodies);
    if !notes.is_empty() {
        let rows: Vec<_> = iter::once(row(["part", "how to make it"])).chain(notes).collect();
        text += &format!("\n{}", table(&[Left, Left], &rows));
    }
    text
}

/// The notes of each part. What many parts share, as a hundred semi-domes do, is said once.
fn notes(bodies: &[Body]) -> Vec<Vec<String>> {
    const MANY: usize = 5;
    let mut rows = Vec::new();
    for (index, body) in bodies.iter().enumerate() {
        for note in &body.notes {
            let also = |others: &[Body]| others.iter().filter(|o| o.notes.contains(note)).count();
            match (also(&bodies[..index]), 1 + also(&bodies[index + 1..])) {
                (0, from_here) if from_here >= MANY => {
                    let others = from_here - 1;
                    rows.push(vec![format!("{} and {others} more", body.name), note.clone()]);
                }
                (before, from_here) if before + from_here < MANY => {
                    rows.push(row([&body.name, note]));
                }
                _ => {}
            }
        }
    }
    rows
}

fn row<const N: usize>(cells: [&str; N]) -> Vec<String> {
    cells.map(str::to_owned).to_vec()
}
