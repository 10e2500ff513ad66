//! Fuzzing of the command itself with nearly valid files: it must end in time, with a documented exit code, within its
//! memory.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io;
use std::os::unix::ffi::OsStringExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::mutation::mutate;
use crate::running::{MOST_SECONDS, limit_memory};
use fabkit_application::geometry::sequences::SplitMix64;

/// Exit codes that `fabkit --help` documents for any input.
const DOCUMENTED_CODES: std::ops::RangeInclusive<i32> = 0..=4;

/// Settings of a camera small enough to be cast at once.
const SMALL_CAMERA: [&str; 4] = ["--set", "camera.width_px=64", "--set", "camera.height_px=48"];
/// Memory limit for inputs that determine the amount of work themselves.
const MEMORY_LIMIT: [&str; 2] = ["--memory", "200MB"];

/// Command line with an input.
struct Case {
    /// Name of its corpus.
    corpus: &'static str,
    /// File to which the input is written, in the command's folder.
    file: &'static str,
    /// Arguments; `{}` stands for the input itself.
    arguments: &'static [&'static str],
    camera: &'static [&'static str],
}

const fn case(
    corpus: &'static str,
    file: &'static str,
    arguments: &'static [&'static str],
    camera: &'static [&'static str],
) -> Case {
    Case { corpus, file, arguments, camera }
}

const POSE: &[&str] =
    &["calibrate", "extrinsics", "rtac0", "--camera", "camera.yaml", "-o", "p.yaml"];
const BOARD: &[&str] =
    &["calibrate", "intrinsics", "rtac0", "--board", "board.json", "-o", "c.yaml"];

const CASES: [Case; 17] = [
    case("sensor", "in.yaml", &["show", "in.yaml"], &[]),
    case("sensor", "in.yaml", &["render", "in.yaml", "-o", "o.png", "--size", "32x24"], &[]),
    case("override", "in", &["show", "rtac0", "--set", "{}"], &[]),
    case(
        "camera",
        "in.yaml",
        &["depth", "rtac0", "--camera", "in.yaml", "--reference", "-o", "o.npz"],
        &MEMORY_LIMIT,
    ),
    case(
        "pose",
        "in.yaml",
        &["depth", "rtac0", "--pose", "in.yaml", "--reference", "--png", "o.png"],
        &SMALL_CAMERA,
    ),
    case("press", "in", &["depth", "rtac0", "--press", "{}", "--png", "o.png"], &SMALL_CAMERA),
    case(
        "press",
        "in.txt",
        &["dataset", "rtac0", "--presses", "in.txt", "-o", "ds"],
        &SMALL_CAMERA,
    ),
    case("landmarks", "in.json", POSE, &["--captures", "captures", "--landmarks", "in.json"]),
    case("marks", "captures/captures.csv", POSE, &["--captures", "captures"]),
    case("picture", "in.png", &["calibrate", "pins", "--reference", "picture.png", "in.png"], &[]),
    case(
        "picture",
        "in.png",
        &["calibrate", "pins", "--reference", "in.png", "picture.png"],
        &MEMORY_LIMIT,
    ),
    case("picture", "in.png", BOARD, &["in.png"]),
    case("board", "board.json", BOARD, &["--corners", "corners.csv"]),
    case("corners", "corners.csv", BOARD, &["--corners", "corners.csv"]),
    // The folder is not empty: the plan is read, and no sweep is begun.
    case("plan", "in.yaml", &["sweep", "in.yaml", "-o", "."], &[]),
    case("profile", "in.yaml", &["export", "rtac0/base", "--process", "in.yaml", "-o", "out"], &[]),
    case("coupon", "in.yaml", &["profile", "in.yaml", "-o", "printer.yaml"], &[]),
];

/// Further files to which command lines refer: their names, and their origins in the corpus.
const FURTHER_FILES: [(&str, &str); 5] = [
    ("camera.yaml", "camera/fabkit.yaml"),
    ("board.json", "board/charuco.json"),
    ("corners.csv", "corners/corners.csv"),
    ("captures/captures.csv", "marks/measured.csv"),
    ("picture.png", "picture/grey.png"),
];

/// Input with which the command misbehaved.
#[derive(Clone, Debug)]
pub struct Misbehaviour {
    /// Description for people.
    pub what: String,
    /// The input.
    pub input: Vec<u8>,
}

/// Runs the command once, with an input determined by the seed. Returns what went wrong, if anything.
///
/// # Errors
/// Files that cannot be read or written, or a command that cannot be started.
pub fn run_once(command: &Path, corpus: &Path, seed: u64) -> io::Result<Option<Misbehaviour>> {
    let mut random = SplitMix64::new(seed);
    let Case { corpus: kind, file, arguments, camera } = random.choose(&CASES);
    let files = crate::running::read_corpus(&corpus.join(kind))?;
    let (_, other) = random.choose(&files);
    let input = mutate(&random.choose(&files).1, other, &mut random);

    let folder = tempfile::tempdir()?;
    fs::create_dir(folder.path().join("captures"))?;
    for (name, from) in FURTHER_FILES {
        fs::copy(corpus.join(from), folder.path().join(name))?;
    }
    fs::write(folder.path().join(file), &input)?;
    // An argument cannot contain a zero byte, nor exceed the system's limit on its length.
    let mut word: Vec<u8> = input.iter().copied().filter(|byte| *byte != 0).collect();
    word.truncate(100_000);
    let word = OsString::from_vec(word);
    let mut bounded = limit_memory(command);
    for argument in arguments.iter().chain(*camera) {
        match *argument {
            "{}" => bounded.arg(&word),
            other => bounded.arg(other),
        };
    }
    bounded.args(["--threads", "2"]);
    let said = folder.path().join("said");
    let verdict = verdict(bounded.current_dir(folder.path()), &said)?;
    Ok(verdict.map(|what| {
        let line = format!("fabkit {} {}", arguments.join(" "), camera.join(" "));
        let said = fs::read(&said).unwrap_or_default();
        let said = String::from_utf8_lossy(&said[..said.len().min(600)]).into_owned();
        Misbehaviour {
            what: format!("{what}: {line}, {file} from {kind}, seed {seed}\n{said}"),
            input,
        }
    }))
}

/// Runs the command and judges its end; `None` if it is as documented.
fn verdict(command: &mut Command, said: &Path) -> io::Result<Option<String>> {
    let said = File::create(said)?;
    let mut child = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(said).spawn()?;
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(match status.code() {
                Some(code) if DOCUMENTED_CODES.contains(&code) => None,
                Some(code) => Some(format!("exit code {code}")),
                None => Some(format!("{status}")),
            });
        }
        if start.elapsed() > Duration::from_secs(MOST_SECONDS) {
            child.kill()?;
            child.wait()?;
            return Ok(Some(format!("more than {MOST_SECONDS} s")));
        }
        thread::sleep(Duration::from_millis(2));
    }
}
