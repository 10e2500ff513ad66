//! `fabkit show SENSOR`

mod chain;
mod limits;
mod materials;

use std::iter;

use fabkit_application::designs::Design;
use fabkit_application::designs::design_hash;
use fabkit_application::geometry::Body;
use fabkit_application::source::Target;
use fabkit_application::text::{Setting, to_printable};
use fabkit_application::{Explained, UnknownName, documents};

use super::Outcome;
use crate::cli;
use crate::failure::{ErrorKind, Failure};
use crate::table::{Align::Left, Align::Right, wrap_text, wrapped_table};

pub(super) fn run(args: &cli::Show, global: &cli::Global) -> Result<Outcome, Failure> {
    let cli::Design { sensor, set, preset, fix: _ } = &args.design;
    let target = Target::new(sensor).with_preset(preset.as_deref());
    if let Some(name) = target.part {
        let project = target.project(set)?;
        let unknown = UnknownName::new("fixture", name, project.fixture_names());
        let hint = format!("{}; a single part has no parameters of its own", unknown.hint());
        let about = unknown.subject();
        return Err(Failure::new(ErrorKind::BadInput, unknown, hint).with_subject(about));
    }
    if args.limits {
        return limits::run(&args.design, global);
    }
    let design = target.design(set)?;
    let (text, json) = if args.chain {
        (chain::text(&design), documents::chain(&design))
    } else {
        (text(&design), documents::show(&design))
    };
    Ok(Outcome { text, json, failed: false })
}

fn text(design: &Design) -> String {
    let sensor = &design.sensor;
    let title = format!("{}: {}", sensor.name, sensor.title);
    let mut text = format!("{}\n{}\n", wrap_text(&title, 2), wrap_text(&sensor.reference, 2));
    text += &format!("design {}\n", design_hash(design));

    let mut rows = vec![row(["parameter", "value", "limits", "source"])];
    for setting in documents::own_first(&design.parameters) {
        rows.push(vec![
            setting.path.clone(),
            setting.value.clone(),
            setting.limits.clone(),
            setting.source.kind.to_string(),
        ]);
    }
    text += &format!("\n{}", wrapped_table(&[Left, Left, Left, Left], &rows));

    if !design.derived.is_empty() {
        let mut rows = vec![row(["derived", "value"])];
        rows.extend(design.derived.iter().map(|(name, value)| row([name, value])));
        text += &format!("\n{}", wrapped_table(&[Left, Left], &rows));
    }

    for kind in ["part", "layer", "component"] {
        let mut rows = vec![row([kind, "n", "made", "of", "description"])];
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
            text += &format!("\n{}", wrapped_table(&[Left, Right, Left, Left, Left], &rows));
        }
    }
    text += &materials::text(&design.materials);
    let notes = notes(&sensor.bodies);
    if !notes.is_empty() {
        let rows: Vec<_> = iter::once(row(["part", "instructions"])).chain(notes).collect();
        text += &format!("\n{}", wrapped_table(&[Left, Left], &rows));
    }
    text + &reasons(design)
}

/// Lists for each value its expression, note and tolerance. Printed last, because it is long.
fn reasons(design: &Design) -> String {
    let mut rows = vec![row(["parameter", "origin of the value"])];
    for Setting { path, expression, source, .. } in documents::own_first(&design.parameters) {
        // The whole text is in the file, and in `--json`.
        let formula = expression.iter().map(|expression| format!("`{}`", to_printable(expression)));
        let note = Some(source.note.clone()).filter(|note| !note.is_empty());
        let within =
            source.tolerance.iter().map(|tolerance| format!("within {tolerance} either way"));
        let reason = formula.chain(note).chain(within).collect::<Vec<_>>().join(": ");
        if !reason.is_empty() {
            rows.push(row([path, &reason]));
        }
    }
    if rows.len() > 1 {
        format!("\n{}", wrapped_table(&[Left, Left], &rows))
    } else {
        String::new()
    }
}

/// Lists the notes of the parts. A note shared by many parts, such as a hundred semi-domes, is printed once.
fn notes(bodies: &[Body]) -> Vec<Vec<String>> {
    const MANY: usize = 5;
    let mut rows = Vec::new();
    for (index, body) in bodies.iter().enumerate() {
        for note in &body.notes {
            let also = |others: &[Body]| others.iter().filter(|o| o.notes.contains(note)).count();
            match (also(&bodies[..index]), 1 + also(&bodies[index + 1..])) {
                // Printed at the first of the parts; the others are only counted.
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
