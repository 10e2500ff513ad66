//! The bridge to the verifier, with a stand-in for Python: what the package is given, and what is made
//! of its answers. What the package itself finds is tested in `export/verify/tests`.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use fabkit_tests::{Run, command, read_folder};
use serde_json::{Value, json};
use tempfile::TempDir;

/// Has the package, keeps its arguments, and answers what stands in a file.
const STAND_IN: &str = r#"#!/bin/sh
here=$(dirname "$0")
[ "$1" = "-I" ] || exit 9
shift
[ "$1" = "-c" ] && exit 0
shift 2
[ -z "$(ls -A)" ] || exit 8
env | grep -q ^PYTHON && exit 7
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
        command.envs([("PYTHONPATH", "."), ("PYTHONSAFEPATH", ""), ("PYTHONHOME", "/nowhere")]);
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
    assert!(read_folder(folder.path()).is_empty(), "nothing is written");
}

/// An environment whose package imports what a hostile folder has files of, and says where it is.
fn environment(folder: &Path) -> PathBuf {
    let made = Command::new("python3").args(["-m", "venv", "--without-pip"]).arg(folder).status();
    assert!(made.expect("python3 is there").success());
    let lib = fs::read_dir(folder.join("lib")).unwrap().next().unwrap().unwrap().path();
    let package = lib.join("site-packages/fabkit_verify");
    fs::create_dir(&package).unwrap();
    fs::write(package.join("__init__.py"), "").unwrap();
    let main = "import json, sys, subprocess, multiprocessing, importlib.util as u\n\
                lost = [m for m in ('numpy', 'sitecustomize', 'usercustomize') if u.find_spec(m)]\n\
                subprocess.run([sys.executable, '-c', 'import json'], check=True)\n\
                print(json.dumps({'kernels': lost, 'passed': not lost, 'results': []}))\n";
    fs::write(package.join("__main__.py"), main).unwrap();
    folder.join("bin/python")
}

#[test]
fn nothing_of_the_current_folder_is_run() {
    let (folder, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let ran = folder.path().join("ran");
    let python = folder.path().join(".venv/bin/python");
    fs::create_dir_all(python.parent().unwrap()).unwrap();
    fs::write(&python, format!("#!/bin/sh\necho .venv >> '{}'\n", ran.display())).unwrap();
    fs::set_permissions(&python, fs::Permissions::from_mode(0o755)).unwrap();
    fs::copy(&python, folder.path().join("python")).unwrap();
    fs::copy(&python, folder.path().join("python3")).unwrap();
    let hostile = ["numpy", "json", "sitecustomize", "usercustomize", "fabkit_verify"];
    for module in hostile {
        let code = format!("open({:?}, 'a').write('{module}\\n')\n", ran.display().to_string());
        fs::write(folder.path().join(format!("{module}.py")), code).unwrap();
    }
    let run = |python: Option<&Path>, arguments: &[&str]| -> Run {
        let mut command = command(folder.path());
        command.args(arguments).env_remove("FABKIT_PYTHON").env("PYTHONPATH", folder.path());
        command.envs([
            ("VIRTUAL_ENV", folder.path().join(".venv")),
            ("HOME", elsewhere.path().into()),
        ]);
        command.env("PATH", format!("{}:/usr/bin:/bin", folder.path().display()));
        command.envs(python.map(|python| ("FABKIT_PYTHON", python)));
        command.output().unwrap().into()
    };
    let verify = ["verify", "rtac0/collar", "--kernel=trimesh"];
    let step = ["export", "rtac0/collar", "--format=step", "-o", "out"];
    let untouched = |run: Run| {
        assert!(!ran.exists(), "{:?} ran: {run:?}", fs::read_to_string(&ran));
        run
    };
    // Whether there is an environment beside the program or not: never this one.
    for arguments in [&verify[..], &step] {
        let run = untouched(run(None, arguments));
        assert!(run.code == Some(0) || run.stderr.contains("set FABKIT_PYTHON to"), "{run:?}");
    }
    for relative in [".venv/bin/python", "./python", "python3"] {
        let run = untouched(run(Some(relative.as_ref()), &verify));
        assert_eq!(run.code, Some(2), "{run:?}");
        assert!(run.stderr.contains(&format!("FABKIT_PYTHON is {relative}, which is no absolute")));
    }
    // The right one, started where it must not look.
    let right = environment(&elsewhere.path().join("environment"));
    let run = untouched(run(Some(&right), &[&verify[..], &["--json"]].concat())).ok();
    assert_eq!(run.json()["verification"]["kernels"], json!([]));
}

#[test]
fn the_package_is_given_nominal_files_and_all_options() {
    let bench = Bench::new(&answer(vec![]), 0);
    // Exported for printing, this lid is larger than designed.
    let part = "lid-translucent-gel";
    let target = format!("rtac0/{part}");
    let options = ["--kernel=cadquery", "--kernel=trimesh", "--limit=30", "--keep=kept"];
    let report = ["--report=found.html", "--threads=1"];
    bench.run(&[&["verify", &target][..], &options, &report].concat()).ok();
    // It runs elsewhere.
    let [kept, found] = ["kept", "found.html"].map(|name| bench.path(name).display().to_string());
    let expected = [
        "check",
        &kept,
        "--kernel",
        "cadquery",
        "--kernel",
        "trimesh",
        "--limit",
        "30",
        "--report",
        &found,
        "--processes",
        "1",
    ];
    assert_eq!(bench.arguments(), expected);

    let files = read_folder(&bench.path("kept"));
    let names: Vec<&str> = files.keys().map(String::as_str).collect();
    let of_part = ["samples.json", "stl", "tree.json"].map(|end| format!("{part}.{end}"));
    assert_eq!(names, [&of_part.each_ref().map(String::as_str)[..], &["manifest.json"]].concat());
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
    let files = read_folder(&bench.path("out"));
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
