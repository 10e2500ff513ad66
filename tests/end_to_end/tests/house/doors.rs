//! What leaves fabkit does so through one door each: text to the terminal, tables, programs that are started, and files
//! under names that fabkit chose.

use std::fs;
use std::path::{Path, PathBuf};

use super::crates::root;
use super::tokens::{Token, tokens};

/// Rooms whose code users run.
const ROOMS: [&str; 8] =
    ["fabkit", "simulation", "fixtures", "designs", "physics", "calibration", "export", "geometry"];

/// Source files of the rooms, without tests, examples and benches, each with its path from the root.
fn sources() -> Vec<(String, Vec<Token>)> {
    fn collect(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if path.is_dir() {
                if !["tests", "examples", "benches", "target"].contains(&&*name) {
                    collect(&path, found);
                }
            } else if name.ends_with(".rs") && name != "tests.rs" {
                found.push(path);
            }
        }
    }
    let mut found = Vec::new();
    ROOMS.iter().for_each(|room| collect(&root().join(room), &mut found));
    found.sort();
    let source = |path: PathBuf| {
        let code = tokens(&fs::read_to_string(&path).unwrap());
        (path.strip_prefix(root()).unwrap().to_string_lossy().replace('\\', "/"), code)
    };
    let sources: Vec<_> = found.into_iter().map(source).collect();
    assert!(sources.len() > 400, "{} files", sources.len());
    sources
}

/// Returns whether words stand there in this order, with `::` between them.
fn has_path(code: &[Token], words: &[&str]) -> bool {
    let length = 3 * words.len() - 2;
    code.windows(length).any(|window| {
        let is_word = words.iter().enumerate().all(|(i, word)| window[3 * i].is(word));
        is_word
            && (1..words.len())
                .all(|i| window[3 * i - 2].is_sign(':') && window[3 * i - 1].is_sign(':'))
    })
}

fn has_macro(code: &[Token], name: &str) -> bool {
    code.windows(2).any(|pair| pair[0].is(name) && pair[1].is_sign('!'))
}

/// Files that have what is asked for, apart from those that may.
fn others(has: impl Fn(&[Token]) -> bool, may: &[&str]) -> Vec<String> {
    let sources = sources();
    for file in may {
        let (_, code) = sources.iter().find(|(path, _)| path == file).unwrap();
        assert!(has(code), "{file} has none any more: take it off the list");
    }
    let others = sources.into_iter().filter(|(path, code)| has(code) && !may.contains(&&**path));
    others.map(|(path, _)| path).collect()
}

#[test]
fn text_reaches_the_terminal_through_one_module() {
    let prints = |code: &[Token]| {
        ["println", "eprintln", "print", "eprint"].iter().any(|name| has_macro(code, name))
            || has_path(code, &["io", "stdout"])
            || has_path(code, &["io", "stderr"])
    };
    let may = [
        "fabkit/command/src/terminal.rs",
        // Passes on what the verifier's Python writes, escaped.
        "fabkit/application/src/verifier.rs",
    ];
    let found: Vec<String> = others(prints, &may);
    let is_build = |path: &&String| path.ends_with("build.rs");
    let found: Vec<&String> = found.iter().filter(|path| !is_build(path)).collect();
    assert!(found.is_empty(), "{found:?}: print with `terminal`");
}

#[test]
fn programs_are_started_by_one_module() {
    let starts = |code: &[Token]| has_path(code, &["Command", "new"]);
    // The other is clap's.
    let may = ["fabkit/application/src/programs.rs"];
    let found: Vec<String> =
        others(starts, &may).into_iter().filter(|path| !path.contains("/cli")).collect();
    assert!(found.is_empty(), "{found:?}: start programs with `Program`");
}

/// A line of names with commas between them is the head of a table.
fn is_table_head(text: &str) -> bool {
    // Tokens hold strings as they are written, over several lines with backslashes.
    let text: String = text.split("\\\n").map(str::trim_start).collect();
    let names: Vec<&str> = text.trim_end_matches("\\n").split(',').collect();
    let is_name = |name: &&str| {
        !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
    };
    names.len() >= 4 && names.iter().all(is_name)
}

#[test]
fn tables_are_written_by_one_type() {
    // Functions whose name speaks of CSV, and heads of tables.
    let writes = |code: &[Token]| {
        let is_function = |pair: &[Token]| {
            let name = pair[1].word().unwrap_or_default();
            pair[0].is("fn")
                && (name.ends_with("_csv") || name == "csv" || name.starts_with("csv_"))
        };
        code.windows(2).any(is_function)
            || code.iter().any(|token| matches!(token, Token::Text(text) if is_table_head(text)))
    };
    // A reader, and attributes of Gerber files.
    let may = ["simulation/dataset/src/captures.rs", "designs/boards/src/files.rs"];
    let wrong: Vec<String> = sources()
        .into_iter()
        .filter(|(path, code)| {
            let uses = code.iter().any(|token| token.is("CsvTable"));
            writes(code) && !uses && !may.contains(&&**path)
        })
        .map(|(path, _)| path)
        .collect();
    assert!(wrong.is_empty(), "{wrong:?}: write tables with `CsvTable`");
}

#[test]
fn files_with_names_of_fabkits_choice_are_written_with_their_list() {
    // `write_each` replaces what is there: its callers name places that the user named, one by one.
    let may = [
        // Plans of sweeps: an empty folder.
        "fabkit/application/src/sweep_runs/mod.rs",
        "fabkit/command/src/commands/archive.rs",
        "fabkit/command/src/commands/calibrate/extrinsics.rs",
        "fabkit/command/src/commands/calibrate/intrinsics.rs",
        "fabkit/command/src/commands/dataset.rs",
        "fabkit/command/src/commands/dataset/probes.rs",
        "fabkit/command/src/commands/diff.rs",
        "fabkit/command/src/commands/files.rs",
        "fabkit/command/src/commands/fit_light.rs",
        "fabkit/command/src/commands/new.rs",
        "fabkit/command/src/commands/profile.rs",
        "fabkit/command/src/commands/render.rs",
        "fabkit/python/src/calibrate.rs",
        "fabkit/python/src/export.rs",
        // Where it is.
        "geometry/files/src/staging/mod.rs",
    ];
    let found = others(|code| code.iter().any(|token| token.is("write_each")), &may);
    assert!(found.is_empty(), "{found:?}: write them with `write_all`");
}
