//! `fabkit diff A B`

use std::fmt::Write;

use fabkit_application::design_difference;
use fabkit_application::guide::{BodyChange, ChangeKind, DesignDifference};
use fabkit_application::source::Target;
use fabkit_application::staging::write_each;
use serde_json::json;

use super::Outcome;
use crate::cli::Diff;
use crate::failure::{ErrorKind, Failure};
use crate::interrupt;
use crate::roles::FileRoles;

pub(super) fn run(args: &Diff) -> Result<Outcome, Failure> {
    let (from, to) = (Target::new(&args.from), Target::new(&args.to));
    if let Some(part) = from.part.or(to.part) {
        let message = format!("whole sensors and fixtures are compared, not their {part}");
        return Err(Failure::plain(ErrorKind::BadInput, message));
    }
    let roles = FileRoles::default().reads("FROM", from.files()).reads("TO", to.files());
    roles.writes("-o", args.output.as_slice()).check()?;
    let from = from.design(&args.set_from)?;
    let to = to.design(&args.set_to)?;
    let difference = design_difference::compute_difference(&from, &to);
    let mut json = difference.to_json();
    let mut text = format_difference(&difference);
    if let Some(path) = &args.output {
        let page = design_difference::difference_page(&from, &to, &difference)?;
        interrupt::begin_writing()?;
        if path.file_name().is_none() {
            let message = format!("{} does not name a file", path.display());
            return Err(Failure::plain(ErrorKind::BadInput, message));
        }
        write_each([(path.clone(), page.as_bytes())], &interrupt::is_requested)?;
        json["file"] = json!(path.display().to_string());
        let _ = writeln!(text, "{}", path.display());
    }
    Ok(Outcome { text, json, failed: false })
}

fn format_difference(difference: &DesignDifference) -> String {
    let mut text = String::new();
    for parameter in &difference.parameters {
        let value = |value: &Option<String>| value.clone().unwrap_or("-".into());
        let _ = writeln!(
            text,
            "{}: {} -> {}",
            parameter.path,
            value(&parameter.from),
            value(&parameter.to)
        );
    }
    let listed = |of: &mut dyn Iterator<Item = &BodyChange>, count: &dyn Fn(&BodyChange) -> u32| {
        let names = of.map(|one| match count(one) {
            1 => one.name.clone(),
            count => format!("{count} {}", one.name),
        });
        names.collect::<Vec<_>>().join(", ")
    };
    let besides = |kinds: &'static [&'static str]| {
        let mut of =
            difference.bodies.iter().filter(|one| one.besides > 0 && kinds.contains(&one.kind));
        listed(&mut of, &|one| one.besides)
    };
    let rows = [
        ("make", besides(&["part"])),
        ("boards", besides(&["board"])),
        ("cast", besides(&["layer"])),
        ("buy", besides(&["component"])),
        (
            "reuse",
            listed(&mut difference.with_change(ChangeKind::Same), &|one| {
                one.quantity[0].min(one.quantity[1])
            }),
        ),
        (
            "not needed",
            listed(&mut difference.with_change(ChangeKind::Removed), &|one| one.quantity[0]),
        ),
        (
            "steps",
            difference
                .steps
                .iter()
                .map(|step| format!("{} ({})", step.name, step.change.word()))
                .collect::<Vec<_>>()
                .join(", "),
        ),
    ];
    for (what, list) in rows.iter().filter(|(_, list)| !list.is_empty()) {
        let _ = writeln!(text, "{what:<11}{list}");
    }
    let is_same = difference.bodies.iter().all(|one| one.change == ChangeKind::Same);
    if is_same && difference.parameters.is_empty() && difference.steps.is_empty() {
        "no difference: all of it can be used again\n".into()
    } else {
        text
    }
}
