//! `fabkit bench SENSOR -o DIR`

use std::ffi::OsString;

use fabkit_application::source::Target;
use fabkit_application::{Error, benchmark};
use serde_json::{Value, json};

use super::Outcome;
use crate::cli::{Bench, Global};
use crate::failure::Failure;
use crate::roles::FileRoles;
use crate::table::{Align::Left, Align::Right, wrapped_table};
use crate::terminal;

/// Files that are always written into the folder; networks may be added.
const FILES: [&str; 2] = ["bench.json", "bench.html"];

pub(super) fn run(args: &Bench, global: &Global) -> Result<Outcome, Failure> {
    let target = Target::new(&args.design.sensor).with_preset(args.design.preset.as_deref());
    let files = FILES.map(|name| args.output.join(name));
    FileRoles::default().reads("SENSOR", target.files()).writes("-o", &files).check()?;
    // Errors of the design are reported before Python starts.
    target.design(&args.design.set)?;
    let mut words: Vec<OsString> = vec![target.sensor.into(), "--json".into()];
    if let Some(preset) = &args.design.preset {
        // The benchmark knows presets by their full names.
        words[0] = format!("{}-{preset}", target.sensor).into();
    }
    if args.full {
        words.push("--full".into());
    }
    words.extend(["--seed".into(), args.seed.to_string().into()]);
    words.extend(["-o".into(), args.output.clone().into_os_string()]);
    let pairs = |option: &'static str, values: &[String]| -> Vec<OsString> {
        values.iter().flat_map(|value| [option.into(), value.into()]).collect()
    };
    words.extend(pairs("--rows", &args.rows));
    words.extend(pairs("--set", &args.design.set));
    let tell = |line: &str| {
        if !global.quiet {
            terminal::tell(&format!("{line}\n"));
        }
    };
    let mut json = benchmark::run(&words, &tell).map_err(Error::from)?;
    let rows = json["rows"].as_array().map_or(&[][..], Vec::as_slice);
    let mut lines = vec![
        ["what", "paper", "simulated", "baseline", "unit", "samples"].map(String::from).to_vec(),
    ];
    lines.extend(rows.iter().map(|row| {
        let number = |key: &str| row[key].as_f64().map_or_else(|| "-".to_owned(), rounded);
        vec![
            text(&row["name"]),
            number("paper"),
            number("simulated"),
            number("baseline"),
            text(&row["unit"]),
            row["samples"].to_string(),
        ]
    }));
    let told = wrapped_table(&[Left, Right, Right, Right, Left, Right], &lines);
    let text = format!("{told}open {}\n", files[1].display());
    let networks = json["networks"].as_array().into_iter().flatten();
    let networks = networks.filter_map(|network| network["name"].as_str()).flat_map(|name| {
        ["onnx", "json"].map(|end| args.output.join("networks").join(format!("{name}.{end}")))
    });
    let written: Vec<String> =
        files.iter().cloned().chain(networks).map(|file| file.display().to_string()).collect();
    json["files"] = json!(written);
    Ok(Outcome { text, json, failed: false })
}

fn text(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_owned()
}

/// Formats a number with three decimals, or with one if it is large.
fn rounded(value: f64) -> String {
    if value.abs() >= 100.0 { format!("{value:.1}") } else { format!("{value:.3}") }
}
