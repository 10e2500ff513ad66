//! `fabkit check SENSOR`

use fabkit_application::checks::{Batch, CheckReport, Finding, UnknownProperty};
use fabkit_application::source::Target;
use fabkit_application::text::list_names;
use fabkit_application::{Explained, UnknownName, documents};

use super::Outcome;
use super::progress::Progress;
use crate::cli;
use crate::failure::{ErrorKind, Failure};
use crate::table::{Align::Left, Align::Right, table};

pub(super) fn run(args: &cli::Check, global: &cli::Global) -> Result<Outcome, Failure> {
    let cli::Check { design: args, strict } = args;
    let target = Target::new(&args.sensor).with_preset(args.preset.as_deref());
    if let Some(name) = target.part {
        let project = target.project(&args.set)?;
        let unknown = UnknownName::new("fixture", name, project.fixture_names());
        let hint = format!("{}; a single part cannot be checked", unknown.hint());
        let about = unknown.subject();
        return Err(Failure::new(ErrorKind::BadInput, unknown, hint).with_subject(about));
    }
    let design = target.design(&args.set)?;
    // The design has been built and checked above, so its solids are valid, and an invalid one is a bug.
    let progress = Progress::new(global, format!("checking {}", args.sensor));
    let report = target.check(&args.set, &|step| progress.show(step))?.map_err(Failure::bug)?;
    drop(progress);
    let text = text(&design.sensor.name, &report);
    let is_open = *strict && !report.not_known.is_empty();
    let failed = report.errors() > 0 || is_open;
    Ok(Outcome { text, json: documents::check(&design, &report), failed })
}

fn text(name: &str, report: &CheckReport) -> String {
    let cells = |cells: [&str; 3]| cells.map(str::to_owned).to_vec();
    let mut rows = vec![cells(["rule", "examined", "result"])];
    for examined in &report.examined {
        let result = match report.for_rule(examined.rule).count() {
            0 => "ok".to_owned(),
            1 => "1 finding".to_owned(),
            n => format!("{n} findings"),
        };
        let count = format_examined(examined.count, examined.what);
        rows.push(cells([examined.rule.word(), &count, &result]));
    }
    let mut text = table(&[Left, Left, Left], &rows);
    for finding in &report.findings {
        text += &format!("\n{}", finding_text(finding));
    }
    if !report.batches.is_empty() {
        text += &format!("\n{}", batches_text(&report.batches));
    }
    for unknown in &report.not_known {
        text += &format!("\n{}", unknown_text(unknown));
    }
    text += &match report.errors() {
        0 if report.not_known.is_empty() => format!("\n{name} can be built as described\n"),
        0 => {
            let subjects: Vec<String> =
                report.not_known.iter().map(UnknownProperty::subject).collect();
            let names: Vec<&str> = subjects.iter().map(String::as_str).collect();
            let names = list_names(&names);
            format!("\n{name} can be built, as far as is known; not known: {names}\n")
        }
        1 => "\n1 error\n".to_owned(),
        n => format!("\n{n} errors\n"),
    };
    text
}

/// Formats a property that a rule needed and nobody states.
fn unknown_text(unknown: &UnknownProperty) -> String {
    let rules: Vec<&str> = unknown.rules.iter().map(|rule| rule.word()).collect();
    let bodies: Vec<&str> = unknown.bodies.iter().map(String::as_str).collect();
    format!(
        "not known[{}]: {}\n  --> {}\n  = help: {}\n",
        rules.join(", "),
        unknown.subject(),
        list_names(&bodies),
        unknown.remedy
    )
}

/// Formats a count with its noun, which is given in the plural: `1 pair of touching bodies`.
fn format_examined(count: usize, what: &str) -> String {
    if count != 1 {
        return format!("{count} {what}");
    }
    let words = [" of ", " in ", " with ", " for ", " against ", " between "];
    let end = words.iter().filter_map(|word| what.find(word)).min().unwrap_or(what.len());
    let (nouns, rest) = what.split_at(end);
    let noun = match nouns.strip_suffix("bodies") {
        Some(before) => format!("{before}body"),
        None => nouns.strip_suffix('s').unwrap_or(nouns).to_owned(),
    };
    format!("1 {noun}{rest}")
}

fn finding_text(finding: &Finding) -> String {
    let mut text = format!("{}[{}]: {}\n", finding.severity, finding.rule, finding.message);
    let at = finding.place.map(|p| format!("({:.3}, {:.3}, {:.3}) mm", p.x, p.y, p.z));
    let places = [
        finding.step.as_ref().map(|step| format!("step {step}")),
        finding.assembly.as_ref().map(|assembly| format!("assembly {assembly}")),
        at,
    ];
    let place = places.into_iter().flatten().collect::<Vec<_>>().join(", ");
    if !place.is_empty() {
        text += &format!("  --> {place}\n");
    }
    if let Some(measured) = finding.measured {
        let unit = if measured.unit.is_empty() { "" } else { " " };
        text += &format!(
            "  = {}{unit}{}, limit {}{unit}{}\n",
            rounded(measured.value),
            measured.unit,
            format_limit(measured.limit),
            measured.unit
        );
    }
    text + &format!("  = help: {}\n", finding.fix)
}

/// Formats a measured value with four decimals; the JSON document has all digits.
fn rounded(value: f64) -> String {
    let small = value != 0.0 && value.abs() < 1e-3;
    if small { format!("{value:.3e}") } else { format!("{value:.4}") }
}

/// Formats a limit exactly as in the rule, or rounded if it has many decimals, such as a third.
fn format_limit(limit: f64) -> String {
    let all = limit.to_string();
    if all.len() > 8 { rounded(limit) } else { all }
}

fn batches_text(batches: &[Batch]) -> String {
    let cells = |cells: [&str; 4]| cells.map(str::to_owned).to_vec();
    let mut rows = vec![cells(["mix", "layer mm3", "waste", "components"])];
    for batch in batches {
        rows.push(cells([
            &batch.layer,
            &format!("{:.2}", batch.volume.value_mm3),
            &format!("{:.0} %", 100.0 * batch.waste),
            &components(batch),
        ]));
    }
    table(&[Left, Right, Right, Left], &rows)
}

/// Lists the masses of a batch, for example `1.32 g Part A, 1.32 g Part B`.
pub(super) fn components(batch: &Batch) -> String {
    let weighed = batch.components_g.iter().map(|(name, grams)| format!("{grams:.2} g {name}"));
    weighed.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::format_examined;

    #[test]
    fn one_is_counted_in_the_singular() {
        assert_eq!(format_examined(1, "pairs of touching bodies"), "1 pair of touching bodies");
        assert_eq!(format_examined(1, "bodies in view"), "1 body in view");
        assert_eq!(format_examined(1, "surface-shaping steps"), "1 surface-shaping step");
        assert_eq!(format_examined(2, "pours"), "2 pours");
    }
}
