//! `fabkit verify SENSOR[/PART]`, `fabkit verify DIR`

use std::collections::BTreeMap;
use std::path::{Path, is_separator};

use fabkit_application::source::Target;
use fabkit_application::verifier::{Verifier, VerifyOptions};
use serde_json::{Value, json};

use super::progress::Progress;
use super::{Outcome, verify_folder};
use crate::cli::{Global, Verify};
use crate::failure::Failure;
use crate::roles::FileRoles;
use crate::table::{Align::Left, table};

/// Default time limit of a kernel for one part, s.
const DEFAULT_LIMIT_S: u32 = 600;

pub(super) fn run(args: &Verify, global: &Global) -> Result<Outcome, Failure> {
    // Folders may have any name; sensors have names in UTF-8.
    let Some(sensor) = args.sensor.to_str() else {
        return verify_folder::run(args, Path::new(&args.sensor));
    };
    if let Some(folder) = folder(sensor) {
        return verify_folder::run(args, folder);
    }
    let target = Target::new(sensor);
    let part = target.part;
    FileRoles::default()
        .reads("SENSOR", target.files())
        .writes("--report", &args.report)
        .check()?;
    let design = target.design(&args.set)?;
    let verifier = Verifier::find()?;
    let options = VerifyOptions {
        parts: part.map(str::to_owned).into_iter().chain(args.parts.iter().cloned()).collect(),
        kernels: args.kernels.iter().map(|kernel| kernel.word().to_owned()).collect(),
        limit_s: Some(args.limit.unwrap_or(DEFAULT_LIMIT_S).into()),
        keep: args.keep.clone(),
        report: args.report.clone(),
    };
    let progress = Progress::new(global, format!("rebuilding {sensor}"));
    let answer = verifier.verify(&design, &options, &|step| progress.show(step))?;
    drop(progress);
    let passed = answer["passed"] == true;
    let text = text(&design.sensor.name, &answer);
    let json = json!({
        "format": "fabkit-verify",
        "version": 1,
        "name": design.sensor.name,
        "passed": passed,
        "verification": answer,
    });
    Ok(Outcome { text, json, failed: !passed })
}

/// Returns the folder to be verified, if the argument means one. The name of a built-in sensor means the sensor, unless
/// it ends in a separator.
fn folder(text: &str) -> Option<&Path> {
    let is_meant = text.ends_with(is_separator) || !Target::new(text).is_builtin();
    // With a trailing separator, only a folder can be meant, even if it does not exist.
    Some(Path::new(text)).filter(|path| text.ends_with(is_separator) || is_meant && path.is_dir())
}

fn words(values: &Value) -> Vec<&str> {
    values.as_array().map(|all| all.iter().filter_map(Value::as_str).collect()).unwrap_or_default()
}

fn text(name: &str, answer: &Value) -> String {
    let kernels = words(&answer["kernels"]);
    let results = answer["results"].as_array().map(Vec::as_slice).unwrap_or_default();
    let mut by_part: BTreeMap<&str, BTreeMap<&str, &Value>> = BTreeMap::new();
    for result in results {
        let key = |field: &str| result[field].as_str().unwrap_or_default();
        by_part.entry(key("part")).or_default().insert(key("kernel"), result);
    }
    let mut rows =
        vec![["part"].into_iter().chain(kernels.iter().copied()).map(str::to_owned).collect()];
    for (part, cells) in &by_part {
        let cell = |kernel: &&str| {
            cells.get(kernel).map_or(String::new(), |result| format_comparison(result))
        };
        rows.push(std::iter::once((*part).to_owned()).chain(kernels.iter().map(cell)).collect());
    }
    let mut text = table(&vec![Left; kernels.len() + 1], &rows);
    text += "(largest relative difference in volume, largest distance of surfaces in µm)\n";
    let mut wrong = 0;
    for result in results.iter().filter(|result| result["verdict"] != "agrees") {
        wrong += 1;
        let field = |name: &str| result[name].as_str().unwrap_or_default();
        text += &format!(
            "\n{} in {} {}: {}\n",
            field("part"),
            field("kernel"),
            field("verdict"),
            field("reason")
        );
    }
    if let Some(error) = answer["report_error"].as_str() {
        text += &format!("\nthe report could not be written: {error}\n");
    }
    text += &match wrong {
        0 => format!("\n{name}: {} bodies agree in {} kernels\n", by_part.len(), kernels.len()),
        _ => format!("\n{name}: {wrong} of {} comparisons do not agree\n", results.len()),
    };
    text
}

/// Formats a comparison, for example `2e-12 0.001`; with the verdict unless the kernels agree.
fn format_comparison(result: &Value) -> String {
    let verdict = result["verdict"].as_str().unwrap_or_default();
    let (volume, distance) = (result["volume"].as_f64(), result["distance_mm"].as_f64());
    let figures = match (volume, distance) {
        (Some(volume), Some(mm)) => format!("{volume:.0e} {:.3}", 1000.0 * mm),
        _ => String::new(),
    };
    if verdict == "agrees" { figures } else { format!("{} {figures}", verdict.to_uppercase()) }
}
