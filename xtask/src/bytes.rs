//! `cargo xtask bytes`: whether a change kept every byte that it should have kept.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use crate::run::{built, cargo, check, fabkit, root};

const USAGE: &str = "usage: cargo xtask bytes [--accept | --debug]";

/// One line for each file: its hash, then design and name.
///
/// Sine and cosine come from the system's library, and their last bit from the processor's
/// instructions: on another kind of machine some hashes differ though nothing is wrong. So the list
/// is compared where it was written, before and after a change, and not in continuous integration.
const LIST: &str = "xtask/bytes.txt";

/// Formats whose bytes follow from geometry alone, or from geometry and meshes.
const FORMATS: &str = "stl,3mf,dxf,svg,tree";

/// The pattern of the data sets: two halves, so that camera, presses and stitching take part.
const PATTERN: &str = "pair = HALF-001 + HALF-044\n";
/// Fixtures that have halves, and what a half is called.
const HALVES: [(&str, &str); 2] = [("semi-domes", "semi-dome"), ("half-plates", "half-plate")];

/// Pictures of every kind of light: their names, sensors and what takes them. Layers answer on few nodes, which is quick.
const PICTURES: [(&str, &str, &str); 7] = [
    ("rtac0", "rtac0", "--press ball@24deg,120deg,0.5mm --spacing 1mm"),
    ("9dtact", "9dtact", "--press ball@0mm,0mm,1mm --spacing 1mm"),
    ("shadowtac", "shadowtac", "--press ball@24deg,120deg,0.5mm --spacing 1mm"),
    ("uvdtact-white", "uvdtact", "--light white --reference"),
    ("uvdtact-uv", "uvdtact", "--light uv --press hemisphere@24deg,120deg,0.5mm --spacing 1mm"),
    ("tactip", "tactip", "--press disc-107@24deg,120deg,0.5mm --spacing 2mm"),
    ("fluidic", "fluidic", "--press ball@20mm,3mm,2mm --spacing 2mm"),
];

/// Compares with the list or, where debug builds could differ, with a debug build; or writes the list
/// anew.
pub fn run(arguments: &[String]) -> Result<(), String> {
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let (accept, debug) = match *words {
        [] => (false, false),
        ["--accept"] => (true, false),
        ["--debug"] => (false, true),
        _ => return Err(USAGE.into()),
    };
    let now = hashes(&fabkit()?, None)?;
    if debug {
        check(cargo().args(["build", "--package", "fabkit"]))?;
        // On one thread, so that what hangs on their number shows as well.
        let debug = hashes(&built("debug", "fabkit"), Some("1"))?;
        return compared("the release build", &now, &debug);
    }
    let list = root().join(LIST);
    if accept {
        let lines: String = now.iter().map(|(file, hash)| format!("{hash} {file}\n")).collect();
        return fs::write(&list, lines).map_err(|e| format!("cannot write {LIST}: {e}"));
    }
    let text = fs::read_to_string(&list).map_err(|e| format!("cannot read {LIST}: {e}"))?;
    let before: BTreeMap<String, String> = text
        .lines()
        .filter_map(|line| line.split_once(' '))
        .map(|(hash, file)| (file.to_owned(), hash.to_owned()))
        .collect();
    compared(LIST, &before, &now)
}

/// The hashes of everything that a command exports, and of pictures, which may be told how many threads to use.
fn hashes(fabkit: &Path, threads: Option<&str>) -> Result<BTreeMap<String, String>, String> {
    let mut hashes = BTreeMap::new();
    for sensor in sensors(fabkit)? {
        hash_exports(fabkit, &sensor, &mut hashes)?;
    }
    hash_pictures(fabkit, threads, &mut hashes)?;
    Ok(hashes)
}

fn hash_pictures(
    fabkit: &Path,
    threads: Option<&str>,
    hashes: &mut BTreeMap<String, String>,
) -> Result<(), String> {
    let folder = root().join("target/bytes/pictures");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    for (name, sensor, options) in PICTURES {
        let picture = folder.join(format!("{name}.png"));
        let threads = threads.into_iter().flat_map(|count| ["--threads", count]);
        check(
            Command::new(fabkit)
                .args(["--quiet", "capture", sensor, "--output"])
                .arg(&picture)
                .args(options.split(' '))
                .args(threads),
        )?;
    }
    hash_folder(&folder, "pictures", hashes)?;
    fs::remove_dir_all(&folder).map_err(|e| e.to_string())
}

fn compared(
    what: &str,
    before: &BTreeMap<String, String>,
    now: &BTreeMap<String, String>,
) -> Result<(), String> {
    let mut different = 0;
    for (file, hash) in before {
        let says = match now.get(file) {
            None => "is gone",
            Some(other) if other != hash => "differs",
            Some(_) => continue,
        };
        println!("{file} {says}");
        different += 1;
    }
    for file in now.keys().filter(|file| !before.contains_key(*file)) {
        println!("{file} is new");
        different += 1;
    }
    if different > 0 {
        return Err(format!(
            "{different} of {} files differ from {what}; where that is meant, write {LIST} anew with \
             `cargo xtask bytes --accept` and say why",
            now.len()
        ));
    }
    println!("{} files, byte for byte as in {what}", now.len());
    Ok(())
}

/// Names of all built-in sensors.
fn sensors(fabkit: &Path) -> Result<Vec<String>, String> {
    Ok(sensors_and_fixtures(fabkit)?.into_iter().map(|(sensor, _)| sensor).collect())
}

/// All built-in sensors with the names of their fixtures.
pub fn sensors_and_fixtures(fabkit: &Path) -> Result<Vec<(String, Vec<String>)>, String> {
    let output = Command::new(fabkit).args(["list", "--json"]).output();
    let output = output.map_err(|e| format!("cannot run fabkit: {e}"))?;
    let list: serde_json::Value =
        serde_json::from_slice(&output.stdout).map_err(|e| format!("fabkit list: {e}"))?;
    let sensors = list["sensors"].as_array().ok_or("fabkit list names no sensors")?;
    let word = |value: &serde_json::Value| value.as_str().map(str::to_owned);
    let fixtures = |s: &serde_json::Value| {
        s["fixtures"].as_array().into_iter().flatten().filter_map(word).collect()
    };
    Ok(sensors.iter().filter_map(|s| Some((word(&s["name"])?, fixtures(s)))).collect())
}

/// A sensor and all its fixtures; and a data set, where it is pressed by halves.
fn hash_exports(
    fabkit: &Path,
    sensor: &str,
    hashes: &mut BTreeMap<String, String>,
) -> Result<(), String> {
    let folder = root().join("target/bytes").join(sensor);
    let _ = fs::remove_dir_all(&folder);
    let export = folder.join("export");
    check(
        Command::new(fabkit)
            .args(["--quiet", "export", sensor, "--fixtures", "--format", FORMATS, "--output"])
            .arg(&export),
    )?;
    let has = |fixture: &str| fs::exists(export.join(fixture)).is_ok_and(|exists| exists);
    for (_, half) in HALVES.into_iter().filter(|(fixture, _)| has(fixture)) {
        let pattern = folder.join("pattern.txt");
        fs::write(&pattern, PATTERN.replace("HALF", half)).map_err(|e| e.to_string())?;
        check(
            Command::new(fabkit)
                .args(["--quiet", "dataset", sensor, "--materialise", "--presses"])
                .arg(&pattern)
                .arg("--output")
                .arg(folder.join("dataset")),
        )?;
    }
    hash_folder(&folder, sensor, hashes)?;
    fs::remove_dir_all(&folder).map_err(|e| e.to_string())
}

/// Adds every file below a folder but manifests, which name versions and times.
fn hash_folder(
    folder: &Path,
    name: &str,
    hashes: &mut BTreeMap<String, String>,
) -> Result<(), String> {
    let entries = fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut entries: Vec<_> = entries.flatten().collect();
    entries.sort_by_key(|entry| entry.file_name());
    for entry in entries {
        let (path, file) = (entry.path(), entry.file_name());
        let name = format!("{name}/{}", file.to_string_lossy());
        if path.is_dir() {
            hash_folder(&path, &name, hashes)?;
        } else if file != "manifest.json" && file != "pattern.txt" {
            let bytes = fs::read(&path).map_err(|e| format!("{}: {e}", path.display()))?;
            let hash = short(&bytes);
            // Of a hundred halves one line is enough.
            let set = hashes.entry(unnumbered(&name)).or_default();
            *set =
                if set.is_empty() { hash } else { short(format!("{set}{name}{hash}").as_bytes()) };
        }
    }
    Ok(())
}

fn short(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex()[..16].to_owned()
}

/// `semi-dome-044.stl` to `semi-dome-*.stl`.
fn unnumbered(name: &str) -> String {
    let number = |word: &str| word.len() == 3 && word.bytes().all(|b| b.is_ascii_digit());
    let starred = |part: &str| match part.split_once('.') {
        Some((stem, rest)) if number(stem) => format!("*.{rest}"),
        _ => part.to_owned(),
    };
    name.split('-').map(starred).collect::<Vec<_>>().join("-")
}
