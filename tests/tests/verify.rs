//! The bridge to the verifier, with a stand-in for Python: what the package is given, and what is made
//! of its answers. What the package itself finds is tested in `verify/tests`.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use fabkit_tests::{Run, command, contents};
use serde_json::{Value, json};
use tempfile::TempDir;

/// Has the package, keeps its arguments, and answers what stands in a file.
const STAND_IN: &str = r#"#!/bin/sh
here=$(dirname "$0")
[ "$1" = "-c" ] && exit 0
shift 2
printf '%s\n' "$@" > "$here/arguments"
[ "$1" = "step" ] && echo "ISO-10303-21;" > "$3/collar.step"
cat "$here/answer"
exit "$(cat "$here/code")"
"#;

struct Bench {
    folder: TempDir,
}

impl Bench {
    /// Answers with that text and exit code.
    fn new(answer: &str, code: i32) -> Self {
        let bench = Self { folder: tempfile::tempdir().unwrap() };
        fs::write(bench.path("python"), STAND_IN).unwrap();
        fs::set_permissions(bench.path("python"), fs::Permissions::from_mode(0o755)).unwrap();
        fs::write(bench.path("answer"), answer).unwrap();
        fs::write(bench.path("code"), code.to_string()).unwrap();
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn run(&self, arguments: &[&str]) -> Run {
        let mut command = command(self.folder.path());
        command.env("FABKIT_PYTHON", self.path("python")).args(arguments);
        command.output().expect("fabkit starts").into()
    }

    /// What the package was given.
    fn arguments(&self) -> Vec<String> {
        let text = fs::read_to_string(self.path("arguments")).expect("the package was asked");
        text.lines().map(str::to_owned).collect()
    }
}

fn result(part: &str, kernel: &str, verdict: &str, reason: &str) -> Value {
    json!({
        "part": part, "kernel": kernel, "verdict": verdict, "reason": reason,
        "volume": 2e-9, "distance_mm": 4e-5, "faces": {}, "checks": [], "seconds": 0.1,
    })
}

fn answer(results: Vec<Value>) -> String {
    let passed = results.iter().all(|result| result["verdict"] == "agrees");
    json!({
        "format": "fabkit-verification", "version": 1, "kernels": ["cadquery", "trimesh"],
        "report_error": null, "passed": passed, "results": results,
    })
    .to_string()
}

fn step_answer(passed: bool, reason: &str) -> String {
    let file = json!({
        "name": "collar.step", "parts": ["collar"], "faces": {}, "passed": passed, "reason": reason,
    });
    json!({"format": "fabkit-step", "version": 1, "passed": passed, "files": [file]}).to_string()
}

#[test]
fn without_its_environment_one_line_says_which_command_makes_it() {
    let folder = tempfile::tempdir().unwrap();
    let step = ["export", "rtac0/collar", "--format=stl,step", "-o", "out"];
    for arguments in [&["verify", "rtac0"][..], &step] {
        let mut command = command(folder.path());
        command.env("FABKIT_PYTHON", folder.path().join("nowhere")).args(arguments);
        let run: Run = command.output().unwrap().into();
        assert_eq!((run.code, run.stdout.as_str()), (Some(2), ""), "{run:?}");
        assert_eq!(run.stderr.trim_end().lines().count(), 1, "{run:?}");
        assert!(run.stderr.contains("cargo xtask verify-env"), "{run:?}");
    }
    assert!(contents(folder.path()).is_empty(), "nothing is written");
}

#[test]
fn the_package_is_given_nominal_files_and_all_options() {
    let bench = Bench::new(&answer(vec![]), 0);
    // Exported for printing, this mold is larger than designed.
    let part = "mold-translucent-gel-a";
    let target = format!("rtac0/{part}");
    let options = ["--kernel=cadquery", "--kernel=trimesh", "--limit=30", "--keep=kept"];
    let report = ["--report=found.html", "--threads=1"];
    bench.run(&[&["verify", &target][..], &options, &report].concat()).ok();
    let expected = [
        "check",
        "kept",
        "--kernel",
        "cadquery",
        "--kernel",
        "trimesh",
        "--limit",
        "30",
        "--report",
        "found.html",
        "--processes",
        "1",
    ];
    assert_eq!(bench.arguments(), expected);

    let files = contents(&bench.path("kept"));
    let names: Vec<&str> = files.keys().map(String::as_str).collect();
    let of_part = ["samples.json", "stl", "tree.json"].map(|end| format!("{part}.{end}"));
    assert_eq!(names, [&["manifest.json"][..], &of_part.each_ref().map(String::as_str)].concat());
    let manifest: Value = serde_json::from_slice(&files["manifest.json"]).unwrap();
    assert_eq!(manifest["parts"][0]["compensation"]["note"], "none");
}

#[test]
fn without_a_part_every_body_is_verified_and_nothing_is_kept() {
    let bench = Bench::new(&answer(vec![]), 0);
    bench.run(&["verify", "shadowtac", "--kernel=trimesh", "--set=dimples.rings=1"]).ok();
    let folder = PathBuf::from(&bench.arguments()[1]);
    assert!(folder.is_absolute() && !folder.exists(), "{}", folder.display());
}

#[test]
fn agreement_is_a_table_and_exit_code_0() {
    let agrees = |kernel| result("collar", kernel, "agrees", "");
    let bench = Bench::new(&answer(vec![agrees("cadquery"), agrees("trimesh")]), 0);
    let run = bench.run(&["verify", "rtac0/collar"]).ok();
    // Relative volume, micrometres.
    assert!(run.stdout.contains("collar") && run.stdout.contains("2e-9 0.040"), "{}", run.stdout);
    assert!(run.stdout.contains("1 bodies agree in 2 kernels"), "{}", run.stdout);
    let document = bench.run(&["verify", "rtac0/collar", "--json"]).ok().json();
    assert_eq!((&document["format"], &document["passed"]), (&"fabkit-verify".into(), &true.into()));
    assert_eq!(document["verification"]["results"].as_array().unwrap().len(), 2);
}

#[test]
fn disagreement_names_part_kernel_and_reason_beside_the_rest_of_the_table() {
    let reason = "distance 0.02 mm, limit 0.001 mm at hole 3";
    let results = vec![
        result("base", "cadquery", "agrees", ""),
        result("collar", "cadquery", "failed", "took longer than 30 s and was stopped"),
        result("collar", "trimesh", "differs", reason),
    ];
    // The package's own exit code says the same as its document.
    let bench = Bench::new(&answer(results), 1);
    let run = bench.run(&["verify", "rtac0/collar"]);
    assert_eq!(run.code, Some(1), "{run:?}");
    for text in [
        "base",
        "FAILED",
        "DIFFERS",
        "collar in cadquery failed: took longer than 30 s and was stopped",
        &format!("collar in trimesh differs: {reason}"),
        "2 of 3 comparisons do not agree",
    ] {
        assert!(run.stdout.contains(text), "no `{text}` in:\n{}", run.stdout);
    }
    let run = bench.run(&["verify", "rtac0/collar", "--json"]);
    assert_eq!((run.code, &run.json()["passed"]), (Some(1), &false.into()));
}

#[test]
fn a_package_that_dies_is_no_agreement() {
    for (said, code) in [("Traceback (most recent call last)", 1), ("", 0), ("{\"passed\": tr", 3)]
    {
        let run = Bench::new(said, code).run(&["verify", "rtac0/collar"]);
        assert_eq!((run.code, run.stdout.as_str()), (Some(70), ""), "{run:?}");
        assert!(run.stderr.contains("stopped without an answer (exit status: "), "{run:?}");
    }
}

#[test]
fn step_files_are_listed_in_the_manifest_as_designed() {
    let bench = Bench::new(&step_answer(true, ""), 0);
    bench.run(&["export", "rtac0/collar", "--format=step", "-o", "out"]).ok();
    let arguments = bench.arguments();
    assert_eq!(
        (arguments[0].as_str(), &arguments[3..]),
        ("step", &strings(["--part", "collar"])[..])
    );
    let files = contents(&bench.path("out"));
    assert_eq!(files["collar.step"], b"ISO-10303-21;\n");
    let manifest: Value = serde_json::from_slice(&files["manifest.json"]).unwrap();
    let entry = &manifest["files"][0];
    assert_eq!((&entry["format"], &entry["parts"]), (&"step".into(), &json!(["collar"])));
    assert_eq!(manifest["parts"][0]["compensation"]["note"], "none");
}

#[test]
fn a_part_without_a_step_file_is_named_and_nothing_is_written() {
    let bench = Bench::new(&step_answer(false, "RebuildError: OpenCascade calls it invalid"), 1);
    let run = bench.run(&["export", "rtac0/collar", "--format=stl,step", "-o", "out"]);
    assert_ne!(run.code, Some(0));
    assert!(run.stderr.contains("collar.step: RebuildError: OpenCascade calls it invalid"));
    assert!(!Path::new(&bench.path("out")).exists());
}

fn strings<const N: usize>(words: [&str; N]) -> [String; N] {
    words.map(str::to_owned)
}
