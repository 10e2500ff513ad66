//! `fabkit show SENSOR --limits`

use fabkit_application::designs::fixing::{FeasibleRange, ValueRange};
use fabkit_application::documents;
use fabkit_application::source::Target;

use super::super::Outcome;
use super::super::progress::Progress;
use crate::cli;
use crate::failure::{ErrorKind, Failure};
use crate::table::{Align::Left, Align::Right, table};

pub(super) fn run(args: &cli::Design, global: &cli::Global) -> Result<Outcome, Failure> {
    let target = Target::new(&args.sensor).with_preset(args.preset.as_deref());
    if let Some(name) = target.fixture.or(target.part) {
        let message = format!("--limits is for a whole sensor, not for its {name}");
        let hint = format!("write `fabkit show {} --limits`", target.sensor);
        return Err(Failure::new(ErrorKind::BadInput, message, hint));
    }
    let progress = Progress::new(global, format!("trying values of {}", args.sensor));
    let limits = target.limits(&args.set, args.fix, &|step| progress.show(step))?;
    drop(progress);
    let json = documents::limits(target.sensor, &limits);
    Ok(Outcome { text: text(&limits, args.fix), json, failed: false })
}

fn text(limits: &[FeasibleRange], is_followed: bool) -> String {
    let mut head = vec!["parameter", "value", "from", "to"];
    let mut align = vec![Left, Right, Right, Right];
    if is_followed {
        head.extend(["--fix from", "to"]);
        align.extend([Right, Right]);
    }
    let mut rows = vec![head.into_iter().map(str::to_owned).collect::<Vec<_>>()];
    for feasible in limits {
        let number = |value: f64| match feasible.unit {
            "" => value.to_string(),
            unit => format!("{value} {unit}"),
        };
        let ends = |range: &ValueRange| {
            [(range.low, range.is_end[0]), (range.high, range.is_end[1])].map(|(value, is_end)| {
                if is_end { format!("{}*", number(value)) } else { number(value) }
            })
        };
        let value = (feasible.value * 1e3).round() / 1e3;
        let mut row = vec![feasible.path.clone(), number(value)];
        row.extend(ends(&feasible.alone));
        if let Some(followed) = &feasible.following {
            row.extend(ends(followed));
        }
        rows.push(row);
    }
    table(&align, &rows) + "\n* the end of what fabkit allows at all\n"
}
