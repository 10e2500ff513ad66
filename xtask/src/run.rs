//! Running other programs.

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Instant, SystemTime};

/// The workspace's root.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."))
}

/// Whether this is continuous integration, where nothing may be skipped.
pub fn in_ci() -> bool {
    env::var_os("CI").is_some_and(|value| !value.is_empty() && value != "false")
}

/// Skips an optional step aloud, or fails in continuous integration.
pub fn skip(step: &str, why: &str) -> Result<(), String> {
    if in_ci() {
        return Err(format!("{step} must not be skipped here: {why}"));
    }
    println!("xtask: SKIPPED {step}: {why}");
    note_skipped(format!("{step}: {why}"));
    Ok(())
}

/// Says that something is left out because it is late.
pub fn note_late(step: &str) {
    println!("xtask: NOT RUN, it is late: {step}");
    note_skipped(format!("{step}, because it was late"));
}

fn note_skipped(step: String) {
    if let Ok(mut steps) = SKIPPED.lock() {
        steps.push(step);
    }
}

static SKIPPED: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// Everything that was skipped so far, and why.
pub fn skipped() -> Vec<String> {
    SKIPPED.lock().map(|steps| steps.clone()).unwrap_or_default()
}

/// The cargo that runs this task.
pub fn cargo() -> Command {
    let cargo = env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo"));
    let mut command = Command::new(cargo);
    command.current_dir(root());
    command
}

/// Runs a program, showing what and letting it print; and how long it took, so that one sees what makes the
/// gate slow.
pub fn check(command: &mut Command) -> Result<(), String> {
    let shown = shown(command);
    println!("xtask: {shown}");
    let start = Instant::now();
    let status = command.status().map_err(|e| format!("cannot run {shown}: {e}"))?;
    println!("xtask: {:.0} s for {shown}", start.elapsed().as_secs_f64());
    if status.success() { Ok(()) } else { Err(format!("{shown}: {status}")) }
}

/// Runs a few programs at a time, the first ones first: most of them keep one core busy, and leave the other idle.
/// What each prints is shown when it has ended, so that lines of two do not mix. All are run, and all that fail
/// are named; but of `samples`, which come last, those whose turn comes too late are left out aloud.
pub fn check_side_by_side(commands: Vec<Command>, samples: Vec<Command>) -> Result<(), String> {
    side_by_side(commands, samples, &is_late)
}

fn side_by_side(
    commands: Vec<Command>,
    samples: Vec<Command>,
    is_late: &(dyn Fn() -> bool + Sync),
) -> Result<(), String> {
    let samples = samples.into_iter().map(|command| (command, true));
    let all: Vec<_> = commands.into_iter().map(|command| (command, false)).chain(samples).collect();
    let waiting = Mutex::new(all.into_iter());
    let failures = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..AT_A_TIME {
            scope.spawn(|| {
                loop {
                    // Not in the loop's head: there the lock would be held while the program runs.
                    let next = waiting.lock().ok().and_then(|mut waiting| waiting.next());
                    let Some((mut command, is_sample)) = next else { return };
                    if is_sample && is_late() {
                        note_late(&shown(&command));
                        continue;
                    }
                    if let Err(why) = captured(&mut command)
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

/// Whether the time is over that the gate has for what others say in part: samples for outside programs, pages of the book.
/// `.ci/run` says when, in seconds since 1970. A slow machine would be stopped before its end, and nothing would be known.
pub fn is_late() -> bool {
    let end = env::var("FABKIT_LATE_FROM").ok().and_then(|text| text.parse().ok());
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    end.zip(now.ok()).is_some_and(|(end, now): (u64, _)| now.as_secs() > end)
}

/// Programs that run side by side: the machine of the gate has two cores, and some wait for a disk or a browser.
const AT_A_TIME: usize = 3;

/// As [`check`], and what the program prints is printed in one piece when it has ended.
fn captured(command: &mut Command) -> Result<(), String> {
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

/// Whether a program can be run at all.
pub fn exists(program: &Path) -> bool {
    Command::new(program).arg("--version").output().is_ok_and(|output| output.status.success())
}

/// Where `cargo install --root .tools` puts a program.
pub fn tool(name: &str) -> PathBuf {
    root().join(".tools/bin").join(format!("{name}{}", env::consts::EXE_SUFFIX))
}

/// Whose tests are run. The Python package has neither tests nor examples in Rust, and its wheel is built
/// with PyO3 set up another way: each of two builds would undo what the other has built.
pub const WORKSPACE: [&str; 3] = ["--workspace", "--exclude", "fabkit-python"];

/// What is built of it: of the examples, those that outside oracles ask. Clippy looks at all of them.
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

/// Everything was built by [`build_workspace`].
static ALL_BUILT: AtomicBool = AtomicBool::new(false);

/// Builds all that the tests need in one go.
///
/// Cargo joins the features that the packages of one call ask of their dependencies: with one call for
/// the command, one for the fuzz targets and one for the tests, every crate would be compiled three times.
pub fn build_workspace() -> Result<(), String> {
    check(cargo().args(["build", "--release"]).args(TARGETS).args(WORKSPACE))?;
    ALL_BUILT.store(true, Ordering::Relaxed);
    Ok(())
}

/// A program of one of the workspace's packages, built first: in release, or where `FABKIT` says that
/// the command is.
pub fn program(package: &str, name: &str) -> Result<PathBuf, String> {
    if let Some(fabkit) = env::var_os("FABKIT") {
        return Ok(Path::new(&fabkit).with_file_name(format!("{name}{}", env::consts::EXE_SUFFIX)));
    }
    if !ALL_BUILT.load(Ordering::Relaxed) {
        check(cargo().args(["build", "--release", "--package", package]))?;
    }
    Ok(built("release", name))
}

/// The command.
pub fn fabkit() -> Result<PathBuf, String> {
    program("fabkit", "fabkit")
}

/// Where cargo puts what it builds in a profile, `debug` or `release`.
pub fn built(profile: &str, name: &str) -> PathBuf {
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
    fn samples_give_way_when_it_is_late_and_nothing_else_does() {
        let of = |names: &[&str]| names.iter().map(Command::new).collect::<Vec<_>>();
        let run =
            |commands, samples, late: bool| side_by_side(of(commands), of(samples), &move || late);
        assert!(run(&["true"], &["true", "false"], true).is_ok());
        assert!(run(&["true"], &["true", "false"], false).is_err());
        assert!(run(&["true", "false"], &["true"], true).is_err());
    }
}
