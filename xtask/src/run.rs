//! Running of other programs.

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Returns the workspace's root.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."))
}

/// Returns whether this is continuous integration, where nothing may be skipped.
pub fn in_ci() -> bool {
    env::var_os("CI").is_some_and(|value| !value.is_empty() && value != "false")
}

/// Skips an optional step with a message; fails in continuous integration.
pub fn skip(step: &str, why: &str) -> Result<(), String> {
    if in_ci() {
        return Err(format!("{step} must not be skipped here: {why}"));
    }
    println!("xtask: SKIPPED {step}: {why}");
    if let Ok(mut steps) = SKIPPED.lock() {
        steps.push(format!("{step}: {why}"));
    }
    Ok(())
}

static SKIPPED: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// Lists everything skipped so far, with the reasons.
pub fn skipped() -> Vec<String> {
    SKIPPED.lock().map(|steps| steps.clone()).unwrap_or_default()
}

/// Makes the command of another task, as a separate process that can run beside others.
pub fn task(name: &str) -> Result<Command, String> {
    let mut command = Command::new(env::current_exe().map_err(|e| format!("xtask: {e}"))?);
    command.arg(name);
    Ok(command)
}

/// Makes a command of the cargo that runs this task.
pub fn cargo() -> Command {
    let cargo = env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo"));
    let mut command = Command::new(cargo);
    command.current_dir(root());
    command
}

/// Runs a program with its output shown, and prints the command and the time that it took, which shows what makes the
/// gate slow.
pub fn check(command: &mut Command) -> Result<(), String> {
    let shown = shown(command);
    println!("xtask: {shown}");
    let start = Instant::now();
    let status = command.status().map_err(|e| format!("cannot run {shown}: {e}"))?;
    println!("xtask: {:.0} s for {shown}", start.elapsed().as_secs_f64());
    if status.success() { Ok(()) } else { Err(format!("{shown}: {status}")) }
}

/// Runs several programs at a time, in the given order: most of them keep one core busy and leave the other idle. The
/// output of each is printed when it has ended, so that lines do not mix. All are run, and all failures are listed.
pub fn check_side_by_side(commands: Vec<Command>) -> Result<(), String> {
    let waiting = Mutex::new(commands.into_iter());
    let failures = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..PARALLEL_PROGRAMS {
            scope.spawn(|| {
                loop {
                    // Taken in a separate statement: in the loop's head, the lock would be held while the program runs.
                    let next = waiting.lock().ok().and_then(|mut waiting| waiting.next());
                    let Some(mut command) = next else { return };
                    if let Err(why) = check_captured(&mut command)
                        && let Ok(mut failures) = failures.lock()
                    {
                        failures.push(why);
                    }
                }
            });
        }
    });
    let mut failures = failures.into_inner().map_err(|_| "a program's watcher ended early")?;
    failures.sort();
    if failures.is_empty() { Ok(()) } else { Err(failures.join("\n")) }
}

/// Number of programs that run side by side: the machine of the gate has two cores, and some programs wait for a disk
/// or a browser.
const PARALLEL_PROGRAMS: usize = 3;

/// Runs a program like [`check`], but prints its output in one piece when it has ended.
fn check_captured(command: &mut Command) -> Result<(), String> {
    let shown = shown(command);
    let start = Instant::now();
    let output = command.stdin(Stdio::null()).output();
    let output = output.map_err(|e| format!("cannot run {shown}: {e}"))?;
    let mut said = format!("xtask: {shown}\n");
    for stream in [&output.stdout, &output.stderr] {
        said += &String::from_utf8_lossy(stream);
    }
    println!("{}\nxtask: {:.0} s for {shown}", said.trim_end(), start.elapsed().as_secs_f64());
    if output.status.success() { Ok(()) } else { Err(format!("{shown}: {}", output.status)) }
}

/// Returns whether a program can be run.
pub fn exists(program: &Path) -> bool {
    Command::new(program).arg("--version").output().is_ok_and(|output| output.status.success())
}

/// Returns the path at which `cargo install --root .tools` installs a program.
pub fn tool_path(name: &str) -> PathBuf {
    root().join(".tools/bin").join(format!("{name}{}", env::consts::EXE_SUFFIX))
}

/// Packages whose tests are run. The Python package has neither tests nor examples in Rust, and its wheel configures
/// PyO3 differently: the two builds would invalidate each other.
pub const WORKSPACE: [&str; 3] = ["--workspace", "--exclude", "fabkit-python"];

/// Build targets: of the examples, only those that oracles use. Clippy examines all of them.
const TARGETS: [&str; 9] = [
    "--lib",
    "--bins",
    "--tests",
    "--example",
    "press_json",
    "--example",
    "lamps_json",
    "--example",
    "models_json",
];

/// True once [`build_workspace`] has built everything.
static ALL_BUILT: AtomicBool = AtomicBool::new(false);

/// Builds everything that the tests need in one call.
///
/// Cargo unifies the features that the packages of one call request of their dependencies: with separate calls for the
/// command, the fuzz targets and the tests, every crate would be compiled three times.
pub fn build_workspace() -> Result<(), String> {
    check(cargo().args(["build", "--release"]).args(TARGETS).args(WORKSPACE))?;
    ALL_BUILT.store(true, Ordering::Relaxed);
    Ok(())
}

/// Builds a program of a workspace package in release, and returns its path; with `FABKIT` set, returns its path beside
/// that command.
pub fn build_program(package: &str, name: &str) -> Result<PathBuf, String> {
    if let Some(fabkit) = env::var_os("FABKIT") {
        return Ok(Path::new(&fabkit).with_file_name(format!("{name}{}", env::consts::EXE_SUFFIX)));
    }
    if !ALL_BUILT.load(Ordering::Relaxed) {
        check(cargo().args(["build", "--release", "--package", package]))?;
    }
    Ok(built_path("release", name))
}

/// Builds the command and returns its path.
pub fn fabkit() -> Result<PathBuf, String> {
    build_program("fabkit", "fabkit")
}

/// Returns the path at which cargo builds a program in a profile, `debug` or `release`.
pub fn built_path(profile: &str, name: &str) -> PathBuf {
    let target =
        env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from);
    target.join(profile).join(format!("{name}{}", env::consts::EXE_SUFFIX))
}

fn shown(command: &Command) -> String {
    let program = Path::new(command.get_program());
    let name = program.file_stem().unwrap_or(program.as_os_str());
    std::iter::once(name)
        .chain(command.get_args())
        .map(|word| word.to_string_lossy())
        .collect::<Vec<_>>()
        .join(" ")
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn all_programs_run_and_all_that_fail_are_named() {
        let run = |names: &[&str]| check_side_by_side(names.iter().map(Command::new).collect());
        assert_eq!(run(&["true"; 9]), Ok(()));
        let failures = run(&["false", "true", "true", "true", "false"]).unwrap_err();
        assert_eq!(failures.lines().count(), 2, "{failures}");
    }
}
