//! `cargo xtask test`

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::run::{
    build_workspace, built_path, cargo, check, check_side_by_side, fabkit, in_ci, root, skip,
    skipped, task,
};
use crate::samples::{FULL, Samples};

/// Help of `cargo xtask test`: the tests and what they leave out.
const HELP: &str = "\
Usage: cargo xtask test [--full]

Runs the same tests on every machine. Where many things differ little, it looks at a sample:

  sensors            the first of each family; `fabkit check` is asked of all
  fixtures           those of rtac0, 9dtact and fluidic; every tenth of a hundred halves
  presses            every third indenter of each sensor through its camera
  wrong designs      every third of those that a rule has to find
  edits              each parameter by 25 %, and of what is refused every 24th with --fix
  Python package     every third test of what it says as the command does
  other kernels      seven designs, some bodies of each, with fewer dimples, slots and holes
  outside programs   every fifth part in the slicer, six random variants, 500 rays of each of five
                     sensors, and a few designs for each of the others

How quick the machine is, measured before anything begins, halves or quarters what kernels, slicer,
variants and rays are given, and how many sensors, presses and wrong designs the tests look at. With --full, or FABKIT_FULL=1, all of it is looked at:
hours on two cores.
";

/// Designs rebuilt by other kernels: step between sampled bodies, and options that reduce features for which
/// OpenCascade takes minutes: 469 dimples, 85 slots, 29 holes. A dome, a flat sensor, one sensor of each other family,
/// and the fixture with the most kinds of parts; built-in variants differ from them in numbers only.
/// `fabkit verify SENSOR` rebuilds everything.
const REBUILT_DESIGNS: [(&str, usize, &[&str]); 7] = [
    ("rtac0", 2, &[]),
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
    ("9dtact", 1, &[]),
];

/// Halves rebuilt out of a hundred, which differ only in their protrusions; the same ones in full.
const SEMI_DOMES: (&str, [&str; 2]) = ("rtac0/semi-domes", ["semi-dome-044", "semi-dome-099"]);

/// Sensors and fixtures whose GLB files trimesh reads; in full, all of them.
const GLB_DESIGNS: [&str; 5] =
    ["rtac0", "rtac0/pin-dome", "9dtact", "fluidic", "tactip/semi-domes"];

/// Sensors whose robot files are read, with a mount; in full, those of all families.
const ROBOTS: [&str; 1] = ["rtac0"];

/// Numbers of random variants, by default and in full, always the same ones; `cargo xtask variants` makes more.
const VARIANTS: usize = 6;
const VARIANTS_IN_FULL: usize = 200;
const SEED: u64 = 13;

/// Sensors whose files lib3mf, ezdxf and OpenCV read: one with sheets, one with a mold of slots, one with channels.
const PARSED_SENSORS: [&str; 3] = ["rtac0", "uvdtact", "fluidic"];

/// Simulated captures analysed as in the papers: dimples by their shadows, dots by 30 x 30 pixels.
const ANALYSED_CAPTURES: [&str; 2] = ["shadows", "dots"];

/// Sensors whose optics pack is read as simulators read it.
const OPTICS_PACK_SENSORS: [&str; 1] = ["digit-like"];

/// Step between the parts that the slicer slices, of all parts of all sensors.
const SLICED_EVERY: usize = 5;

/// Parts whose 3MF files are sliced twice, with their settings and as told: small ones of several kinds.
const SLICED_PARTS: [&str; 3] = ["rtac0/baffle", "9dtact/base", "tactip/controller-holder"];

/// Programs from the system's packages that read fabkit's files.
const CONSUMERS: [&str; 2] = ["admesh", "prusa-slicer"];

/// Builds everything, runs the independent oracles on the command's files, and runs all tests.
pub fn run(arguments: &[String]) -> Result<(), String> {
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match *words {
        [] => {}
        // As a child process, because the tests read the variable themselves.
        ["--full"] => return check(task("test")?.env(FULL, "1")),
        ["-h" | "--help"] => {
            print!("{HELP}");
            return Ok(());
        }
        _ => return Err(format!("`{}` is not known here\n\n{HELP}", words.join(" "))),
    }
    let samples = Samples::choose();
    build_workspace()?;
    let tests = crate::rust_tests::build(samples)?;
    let mut side_by_side = Vec::new();
    if in_ci() {
        side_by_side.push(task("lint")?);
    }
    match crate::python::uv() {
        Ok(_) => side_by_side.push(task("python")?),
        Err(why) => skip("the Python package", &why)?,
    }
    side_by_side.extend(tests.beside_others);
    side_by_side.push(crate::rust_tests::doc_tests()?);
    if in_ci() {
        side_by_side.push(task("book")?);
    }
    match crate::python::environment() {
        Ok(python) => side_by_side.extend(oracles(&python, samples)?),
        Err(why) => skip("the outside oracles and other kernels", &why)?,
    }
    let mut failed = Vec::new();
    let mut note = |result: Result<(), String>| failed.extend(result.err());
    note(check_side_by_side(side_by_side));
    // These measure time, or inject faults: nothing else may run beside them.
    for mut test in tests.exclusive {
        note(check(&mut test));
    }
    note(crate::fuzz::run(std::iter::empty()));
    #[cfg(unix)]
    note(crate::faults::run(&[]));
    for step in skipped() {
        println!("xtask: SKIPPED {step}");
    }
    if failed.is_empty() { Ok(()) } else { Err(failed.join("\n")) }
}

/// Makes the commands of the independent oracles: those that take minutes first, then those that take seconds.
fn oracles(python: &Path, samples: Samples) -> Result<Vec<Command>, String> {
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
    let mut all = rebuild_commands(python, &fabkit, samples)?;
    let variants = samples.count(VARIANTS_IN_FULL, VARIANTS);
    all.push(crate::variants::judge(python, &fabkit, variants, SEED));
    let sliced = samples.step(SLICED_EVERY).to_string();
    println!("xtask: {variants} random variants, every {sliced}. part in the slicer");
    let mut robots = reader("tests/oracles/check_robot.py", &[]);
    robots.args(samples.names(&ROBOTS));
    all.push(robots);
    let mut glb = script("tests/oracles/check_glb.py");
    glb.arg(&fabkit).args(samples.names(&GLB_DESIGNS));
    match crate::pages::Tools::find() {
        Ok(tools) => {
            glb.arg("--validator").arg(tools.modules());
            tools.bundle()?;
            let mut pages = task("pages")?;
            pages.args(samples.names(&[crate::pages::SAMPLED]));
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
    all.push(crate::light::sample(python, &fabkit, samples));
    for consumer in CONSUMERS {
        if installed(consumer) {
            let mut consumes = reader("tests/oracles/consumers.py", &[consumer]);
            if consumer == "prusa-slicer" {
                consumes.arg(&sliced);
            }
            all.push(consumes);
            if consumer == "prusa-slicer" {
                let mut settings = reader("tests/oracles/consumers.py", &["settings"]);
                settings.args(SLICED_PARTS);
                all.push(settings);
            }
        } else {
            skip(consumer, "it is not installed; the system's packages have it")?;
        }
    }
    let (mut images, mut optics) =
        (script("tests/oracles/check_pictures.py"), script("tests/oracles/check_optics.py"));
    images.arg(&fabkit).args(samples.names(&ANALYSED_CAPTURES));
    optics.arg(&fabkit).args(samples.names(&OPTICS_PACK_SENSORS));
    all.extend([images, optics]);
    let mut files = reader("tests/oracles/check_files.py", &[]);
    files.args(samples.names(&PARSED_SENSORS));
    all.push(files);
    for oracle in ["contracts", "boards", "intrinsics", "dataset", "tetrahedra", "robot_examples"] {
        all.push(reader(&format!("tests/oracles/check_{oracle}.py"), &[]));
    }
    all.push(glb);
    let mut elastic = script("tests/oracles/check_elastic.py");
    elastic.arg(built_path("release", "examples/press_json"));
    all.push(elastic);
    Ok(all)
}

/// Makes the commands that rebuild bodies with other kernels.
fn rebuild_commands(
    python: &Path,
    fabkit: &Path,
    samples: Samples,
) -> Result<Vec<Command>, String> {
    let verify = |design: &str, parts: &[&str], options: &[&str]| {
        let mut command = Command::new(fabkit);
        command.args(["verify", design]).args(options).env("FABKIT_PYTHON", python);
        command.args(parts.iter().map(|part| format!("--part={part}")));
        command
    };
    let mut all = Vec::new();
    for (design, every, options) in REBUILT_DESIGNS {
        let bodies = bodies(fabkit, design)?;
        let step = samples.step(every);
        let sample: Vec<&str> = bodies.iter().step_by(step).map(String::as_str).collect();
        println!("xtask: verifies {} of {} bodies of {design}", sample.len(), bodies.len());
        all.push(verify(design, &sample, samples.names(options)));
    }
    let (design, halves) = SEMI_DOMES;
    all.push(verify(design, &halves, &[]));
    Ok(all)
}

/// Lists the names of a sensor's bodies.
fn bodies(fabkit: &Path, design: &str) -> Result<Vec<String>, String> {
    let shown = Command::new(fabkit).args(["show", design, "--json"]).output();
    let shown = shown.map_err(|e| format!("cannot show {design}: {e}"))?;
    let shown: Value =
        serde_json::from_slice(&shown.stdout).map_err(|e| format!("{design}: {e}"))?;
    let bodies = shown["bodies"].as_array().into_iter().flatten();
    Ok(bodies.filter_map(|body| Some(body["name"].as_str()?.to_owned())).collect())
}

/// `cargo xtask opencv`: compares the corner detector of the `opencv` feature with fabkit's on the same images. It is
/// not part of the tests, because OpenCV's headers and bindings take longer than all other oracles.
pub fn opencv_detector() -> Result<(), String> {
    let package = ["--package", "fabkit-calibration", "--features", "opencv"];
    let tests = ["--test", "solver", "opencv", "--", "--nocapture"];
    // In release as well, so that the bindings are built once.
    let clippy = ["--release", "--all-targets", "--", "-D", "warnings"];
    check(cargo().args(["clippy"]).args(package).args(clippy))?;
    check(cargo().args(["test", "--release"]).args(package).args(tests))
}

/// Returns whether a program can be started. Neither consumer exits with 0 for `--version`, so the exit code is
/// ignored.
fn installed(program: &str) -> bool {
    Command::new(program).arg("--help").output().is_ok()
}
