//! Feeding of targets with inputs, until the time or the number of runs is used up.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus};
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use crate::mutation::mutate;
use crate::targets::Target;
use fabkit_application::geometry::sequences::SplitMix64;

/// Time limit for one input, s.
pub const MOST_SECONDS: u64 = 10;
/// Memory limit of a process, KiB: 1 GB, and the address space of stacks and the program.
pub const MOST_KIB: u64 = 1_200_000;
/// Exit code of a process whose input took too long.
const TIMEOUT_CODE: i32 = 124;

/// Limits of a run.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Number of inputs.
    pub runs: u64,
    /// Time.
    pub time: Duration,
}

/// Reads the files of a corpus, with their names.
///
/// # Errors
/// A folder that cannot be read, or has no files.
pub fn read_corpus(folder: &Path) -> io::Result<Vec<(String, Vec<u8>)>> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        files.push((name, fs::read(&path)?));
    }
    files.sort();
    if files.is_empty() {
        Err(io::Error::other(format!("{} has no files", folder.display())))
    } else {
        Ok(files)
    }
}

/// Feeds a corpus unchanged, then mutations of it. Each input is first written to `current`, so that it survives a
/// crash of the process. Returns the number of inputs.
///
/// # Errors
/// Files that cannot be read or written.
pub fn feed(
    target: Target,
    corpus: &[(String, Vec<u8>)],
    seed: u64,
    budget: Budget,
    current: &Path,
) -> io::Result<u64> {
    static STARTED_MS: AtomicU64 = AtomicU64::new(0);
    let start = Instant::now();
    let now_ms = move || start.elapsed().as_millis() as u64;
    // A watchdog: a hanging input never returns to this function.
    thread::spawn(move || {
        loop {
            thread::sleep(Duration::from_millis(250));
            let started = STARTED_MS.load(Ordering::Relaxed);
            if now_ms().saturating_sub(started) > 1000 * MOST_SECONDS {
                eprintln!("this input takes more than {MOST_SECONDS} s");
                std::process::exit(TIMEOUT_CODE);
            }
        }
    });
    let one = |input: &[u8]| -> io::Result<()> {
        fs::write(current, input)?;
        STARTED_MS.store(now_ms(), Ordering::Relaxed);
        (target.run)(input);
        Ok(())
    };
    let mut random = SplitMix64::new(seed);
    let mut done = 0;
    for (_, input) in corpus {
        one(input)?;
        done += 1;
    }
    while done < budget.runs && start.elapsed() < budget.time {
        let (_, input) = random.choose(corpus);
        let (_, other) = random.choose(corpus);
        one(&mutate(input, other, &mut random))?;
        done += 1;
    }
    Ok(done)
}

/// Makes a command whose address space is limited, so that excessive allocations fail.
pub fn limit_memory(program: &Path) -> Command {
    let mut command = Command::new("sh");
    command.args(["-c", &format!("ulimit -v {MOST_KIB} && exec \"$0\" \"$@\"")]).arg(program);
    // Each arena would reserve more address space than most inputs need.
    command.env("MALLOC_ARENA_MAX", "1").env("RUST_BACKTRACE", "0");
    command
}

/// Explains the end of a process that fed a target; `None` if it succeeded.
pub fn failure_reason(status: ExitStatus) -> Option<String> {
    match status.code() {
        Some(0) => None,
        Some(TIMEOUT_CODE) => Some(format!("more than {MOST_SECONDS} s")),
        Some(101) => Some("a panic".into()),
        Some(code) => Some(format!("exit code {code}")),
        None => Some(format!("{status}: too much memory, or too deep")),
    }
}

/// Stores an input under a name derived from its content (a 64-bit FNV-1a hash).
///
/// # Errors
/// A folder that cannot be written to.
pub fn keep(folder: &Path, input: &[u8]) -> io::Result<PathBuf> {
    fs::create_dir_all(folder)?;
    let hash = input.iter().fold(0xcbf2_9ce4_8422_2325u64, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
    });
    let place = folder.join(format!("{hash:016x}"));
    fs::write(&place, input)?;
    Ok(place)
}
