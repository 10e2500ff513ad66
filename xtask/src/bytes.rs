//! `cargo xtask bytes`: checks that a change kept the exported bytes.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use crate::run::{built_path, cargo, check, fabkit, root};

const USAGE: &str = "usage: cargo xtask bytes [--accept | --debug]";

/// List of hashes: one line for each file, with its hash, design and name.
///
/// Sine and cosine come from the system's library, and their last bit depends on the processor's instructions: on
/// another kind of machine some hashes differ without a fault. The list is therefore compared on the machine that wrote
/// it, before and after a change, and not in continuous integration.
const LIST: &str = "xtask/bytes.txt";

/// Formats whose bytes depend only on geometry and meshes.
const FORMATS: &str = "stl,3mf,dxf,svg,tree";

/// Pattern of the data sets: two halves, so that camera, presses and stitching take part.
const PATTERN: &str = "pair = HALF-001 + HALF-044\n";
/// Fixtures with halves, and the name prefix of their halves.
const HALVES: [(&str, &str); 2] = [("semi-domes", "semi-dome"), ("half-plates", "half-plate")];

/// Simulated captures with every kind of light: name, sensor and options. The coarse spacing keeps the contact solver
/// quick.
const IMAGES: [(&str, &str, &str); 7] = [
    ("rtac0", "rtac0", "--press ball@24deg,120deg,0.5mm --spacing 1mm"),
    ("9dtact", "9dtact", "--press ball@0mm,0mm,1mm --spacing 1mm"),
    ("shadowtac", "shadowtac", "--press ball@24deg,120deg,0.5mm --spacing 1mm"),
    ("uvdtact-white", "uvdtact", "--light white --reference"),
    ("uvdtact-uv", "uvdtact", "--light uv --press hemisphere@24deg,120deg,0.5mm --spacing 1mm"),
    ("tactip", "tactip", "--press disc-107@24deg,120deg,0.5mm --spacing 2mm"),
    ("fluidic", "fluidic", "--press ball@20mm,3mm,2mm --spacing 2mm"),
];

/// Compares the hashes with the list, or with a debug build, or writes the list anew.
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
        // On one thread, so that dependences on the number of threads show as well.
        let debug = hashes(&built_path("debug", "fabkit"), Some("1"))?;
        return compare_hashes("the release build", &now, &debug);
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
    compare_hashes(LIST, &before, &now)
}

/// Hashes everything that the command exports, and captures computed on the given number of threads.
fn hashes(fabkit: &Path, threads: Option<&str>) -> Result<BTreeMap<String, String>, String> {
    let mut hashes = BTreeMap::new();
    for sensor in sensors(fabkit)? {
        hash_exports(fabkit, &sensor, &mut hashes)?;
    }
    hash_images(fabkit, threads, &mut hashes)?;
    Ok(hashes)
}

fn hash_images(
    fabkit: &Path,
    threads: Option<&str>,
    hashes: &mut BTreeMap<String, String>,
) -> Result<(), String> {
    let folder = root().join("target/bytes/pictures");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    for (name, sensor, options) in IMAGES {
        let image = folder.join(format!("{name}.png"));
        let threads = threads.into_iter().flat_map(|count| ["--threads", count]);
        check(
            Command::new(fabkit)
                .args(["--quiet", "capture", sensor, "--output"])
                .arg(&image)
                .args(options.split(' '))
                .args(threads),
        )?;
    }
    hash_folder(&folder, "pictures", hashes)?;
    fs::remove_dir_all(&folder).map_err(|e| e.to_string())
}

fn compare_hashes(
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

/// Lists the names of all built-in sensors.
fn sensors(fabkit: &Path) -> Result<Vec<String>, String> {
    Ok(sensors_and_fixtures(fabkit)?.into_iter().map(|(sensor, _)| sensor).collect())
}

/// Lists all built-in sensors with the names of their fixtures.
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

/// Hashes the exports of a sensor and all its fixtures and, if it has halves, a data set.
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

/// Adds every file below a folder except manifests, which contain versions and times.
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
            let hash = short_hash(&bytes);
            // Numbered halves are combined in one line.
            let set = hashes.entry(star_number(&name)).or_default();
            *set = if set.is_empty() {
                hash
            } else {
                short_hash(format!("{set}{name}{hash}").as_bytes())
            };
        }
    }
    Ok(())
}

fn short_hash(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex()[..16].to_owned()
}

/// Replaces the number of a half: `semi-dome-044.stl` becomes `semi-dome-*.stl`.
fn star_number(name: &str) -> String {
    let number = |word: &str| word.len() == 3 && word.bytes().all(|b| b.is_ascii_digit());
    let starred = |part: &str| match part.split_once('.') {
        Some((stem, rest)) if number(stem) => format!("*.{rest}"),
        _ => part.to_owned(),
    };
    name.split('-').map(starred).collect::<Vec<_>>().join("-")
}
