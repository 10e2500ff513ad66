//! `cargo xtask test`

use std::env;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::run::{
    build_workspace, built, cargo, check, check_side_by_side, fabkit, in_ci, root, skip, skipped,
};

/// The sensor that is verified everywhere.
const ALWAYS_VERIFIED: &str = "rtac0";

/// In continuous integration, of its bodies every so many-th.
const ALWAYS_EVERY: usize = 2;

/// What is verified besides in continuous integration: a flat sensor. Built-in variants differ from it in numbers alone.
const VERIFIED_IN_CI: [&str; 1] = ["9dtact"];

/// One sensor of each other family and the fixture with the most kinds of parts, every so many-th of its bodies, and
/// fewer features where OpenCascade takes minutes for them: 469 dimples, 85 slots, 29 holes. All of them with `fabkit verify
/// SENSOR`.
const SAMPLED_IN_CI: [(&str, usize, &[&str]); 5] = [
    (
        "rtac0/pin-dome",
        2,
        &[
            "--set=fixtures.pin_dome.rings.polar=[0 deg, 36 deg, 72 deg]",
            "--set=fixtures.pin_dome.rings.counts=[1, 3, 4]",
        ],
    ),
    ("shadowtac", 2, &["--set=dimples.rings=3"]),
    ("uvdtact", 9, &["--set=markers.count=7"]),
    ("fluidic", 8, &[]),
    ("tactip", 8, &[]),
];

/// Of a hundred halves, which differ in their protrusions alone.
const SEMI_DOMES_IN_CI: (&str, [&str; 2]) =
    ("rtac0/semi-domes", ["semi-dome-044", "semi-dome-099"]);

/// Sensors and fixtures whose GLB files trimesh reads; all of them without naming any.
const VIEWED: [&str; 5] = ["rtac0", "rtac0/pin-dome", "9dtact", "fluidic", "tactip/semi-domes"];

/// Whose files for robots are read, with a mount; those of all families without naming any.
const ROBOTS: [&str; 1] = ["rtac0"];

/// Random variants that are made every time, always the same ones; more with `cargo xtask variants`.
const VARIANTS: (u32, u64) = (6, 13);

/// Sensors whose files lib3mf, ezdxf and OpenCV read: one with sheets, one with a mold of slots, one with channels.
const READ: [&str; 3] = ["rtac0", "uvdtact", "fluidic"];

/// Pictures that are read as papers read theirs: dimples by their shadows, dots by 30 x 30 pixels.
const SEEN: [&str; 2] = ["shadows", "dots"];

/// Whose optics pack is read as simulators read it.
const PACKED: &str = "digit-like";

/// Of all parts of all sensors the slicer slices every so many-th.
const SLICED_EVERY: &str = "5";

/// Parts whose 3MF files are sliced twice, with their settings and as told: small ones of several kinds.
const SLICED: [&str; 3] = ["rtac0/baffle", "9dtact/base", "tactip/controller-holder"];

/// Programs that read what fabkit writes, from the system's packages.
const CONSUMERS: [&str; 2] = ["admesh", "prusa-slicer"];

/// Builds, lets the outside oracles read what the command writes, and runs all tests.
pub fn run() -> Result<(), String> {
    build_workspace()?;
    let tests = crate::rust_tests::build()?;
    let mut side_by_side = Vec::new();
    if in_ci() {
        // First, because cargo waits for cargo, and nothing else here asks it for anything.
        let mut lint = Command::new(env::current_exe().map_err(|e| format!("xtask: {e}"))?);
        lint.arg("lint");
        side_by_side.push(lint);
    }
    let mut package = match crate::python::uv() {
        Ok(_) => crate::python_package::checks()?,
        Err(why) => {
            skip("the Python package", &why)?;
            Vec::new()
        }
    };
    side_by_side.append(&mut package);
    side_by_side.extend(tests.beside_others);
    let samples = match crate::python::environment() {
        Ok(python) => oracles(&python)?,
        Err(why) => {
            skip("the outside oracles and other kernels", &why)?;
            Vec::new()
        }
    };
    let mut failed = Vec::new();
    let mut note = |result: Result<(), String>| failed.extend(result.err());
    note(check_side_by_side(side_by_side, samples));
    // These measure, or do harm: nothing else runs beside them.
    for mut test in tests.alone {
        note(check(&mut test));
    }
    note(crate::fuzz::run(std::iter::empty()));
    #[cfg(unix)]
    note(crate::faults::run(&[]));
    note(crate::rust_tests::documented());
    for step in skipped() {
        println!("xtask: SKIPPED {step}");
    }
    if failed.is_empty() { Ok(()) } else { Err(failed.join("\n")) }
}

/// What outside programs say of samples: what takes minutes, then what takes seconds.
fn oracles(python: &Path) -> Result<Vec<Command>, String> {
    let fabkit = fabkit()?;
    let script = |path: &str| {
        let mut command = Command::new(python);
        command.arg(root().join(path)).env("FABKIT_PYTHON", python);
        command
    };
    let reader = |path: &str, arguments: &[&str]| {
        let mut command = script(path);
        command.args(arguments).arg(&fabkit);
        command
    };
    let mut all = verified(python, &fabkit)?;
    let (count, seed) = VARIANTS;
    all.push(crate::variants::judge(python, &fabkit, count, seed));
    let mut robots = reader("tests/oracles/check_robot.py", &[]);
    robots.args(ROBOTS);
    all.push(robots);
    let mut glb = script("tests/oracles/check_glb.py");
    glb.arg(&fabkit).args(VIEWED);
    match crate::pages::Tools::find() {
        Ok(tools) => {
            glb.arg("--validator").arg(tools.modules());
            tools.bundle()?;
            let mut pages = Command::new(env::current_exe().map_err(|e| format!("xtask: {e}"))?);
            pages.args(["pages", crate::pages::SAMPLED]);
            all.push(pages);
        }
        Err(why) => skip("pages in a browser, and gltf-validator", &why)?,
    }
    let mut tests = Command::new(python);
    tests
        .args(["-m", "unittest", "discover", "--start-directory"])
        .arg(root().join("export/verify/tests"));
    tests.env("FABKIT", &fabkit).env("FABKIT_PYTHON", python);
    all.push(tests);
    all.push(crate::light::sample(python, &fabkit));
    for consumer in CONSUMERS {
        if installed(consumer) {
            let mut consumes = reader("tests/oracles/consumers.py", &[consumer]);
            if consumer == "prusa-slicer" {
                consumes.arg(SLICED_EVERY);
            }
            all.push(consumes);
            if consumer == "prusa-slicer" {
                let mut settings = reader("tests/oracles/consumers.py", &["settings"]);
                settings.args(SLICED);
                all.push(settings);
            }
        } else {
            skip(consumer, "it is not installed; the system's packages have it")?;
        }
    }
    let (mut pictures, mut optics) =
        (script("tests/oracles/check_pictures.py"), script("tests/oracles/check_optics.py"));
    pictures.arg(&fabkit);
    optics.arg(&fabkit);
    if in_ci() {
        pictures.args(SEEN);
        optics.arg(PACKED);
    }
    all.extend([pictures, optics]);
    let mut files = reader("tests/oracles/check_files.py", &[]);
    files.args(READ);
    all.push(files);
    for oracle in ["contracts", "boards", "intrinsics", "dataset", "tetrahedra", "robot_examples"] {
        all.push(reader(&format!("tests/oracles/check_{oracle}.py"), &[]));
    }
    all.push(glb);
    let mut elastic = script("tests/oracles/check_elastic.py");
    elastic.arg(built("release", "examples/press_json"));
    all.push(elastic);
    Ok(all)
}

/// What other kernels rebuild.
fn verified(python: &Path, fabkit: &Path) -> Result<Vec<Command>, String> {
    let verify = |design: &str, parts: &[&str], options: &[&str]| {
        let mut command = Command::new(fabkit);
        command.args(["verify", design]).args(options).env("FABKIT_PYTHON", python);
        command.args(parts.iter().map(|part| format!("--part={part}")));
        command
    };
    let mut all = Vec::new();
    if in_ci() {
        let always: (&str, usize, &[&str]) = (ALWAYS_VERIFIED, ALWAYS_EVERY, &[]);
        for (design, every, options) in [always].into_iter().chain(SAMPLED_IN_CI) {
            let bodies = bodies(fabkit, design)?;
            let sample: Vec<&str> = bodies.iter().step_by(every).map(String::as_str).collect();
            all.push(verify(design, &sample, options));
        }
        all.extend(VERIFIED_IN_CI.iter().map(|design| verify(design, &[], &[])));
        let (design, halves) = SEMI_DOMES_IN_CI;
        all.push(verify(design, &halves, &[]));
    } else {
        all.push(verify(ALWAYS_VERIFIED, &[], &[]));
        skip("verification of the other sensors", "it is part of continuous integration")?;
    }
    Ok(all)
}

/// Names of a sensor's bodies.
fn bodies(fabkit: &Path, design: &str) -> Result<Vec<String>, String> {
    let shown = Command::new(fabkit).args(["show", design, "--json"]).output();
    let shown = shown.map_err(|e| format!("cannot show {design}: {e}"))?;
    let shown: Value =
        serde_json::from_slice(&shown.stdout).map_err(|e| format!("{design}: {e}"))?;
    let bodies = shown["bodies"].as_array().into_iter().flatten();
    Ok(bodies.filter_map(|body| Some(body["name"].as_str()?.to_owned())).collect())
}

/// `cargo xtask opencv`: the corner detector that is there only with the `opencv` feature, on the same pictures
/// as ours. Not part of the tests, because OpenCV's headers and bindings take longer than all other oracles.
pub fn opencv_detector() -> Result<(), String> {
    let package = ["--package", "fabkit-calibration", "--features", "opencv"];
    let tests = ["--test", "boards", "opencv", "--", "--nocapture"];
    // In release as well: the bindings are made once.
    let clippy = ["--release", "--all-targets", "--", "-D", "warnings"];
    check(cargo().args(["clippy"]).args(package).args(clippy))?;
    check(cargo().args(["test", "--release"]).args(package).args(tests))
}

/// Whether a program can be started; neither of the consumers exits with 0 for `--version`.
fn installed(program: &str) -> bool {
    Command::new(program).arg("--help").output().is_ok()
}
