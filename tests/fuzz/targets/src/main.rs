//! Runs all targets, each in its own process, then the command itself.
//!
//! `fabkit-fuzz CORPUS KEPT COMMAND MAX_RUNS SECONDS SEED [NAME...]`: `cargo xtask fuzz` calls it. RUNS and SECONDS limit
//! all targets together; whichever is reached first ends the run.

use std::env;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use fabkit_fuzz_targets::end_to_end;
use fabkit_fuzz_targets::running::{
    self, Budget, failure_reason, feed, keep, limit_memory, read_corpus,
};
use fabkit_fuzz_targets::targets::{TARGETS, Target};

/// Argument that makes this process feed a single target.
const FEED: &str = "feed";
/// Name under which the command itself is selected.
const COMMAND: &str = "command";
/// Share of the time and of the inputs that the command gets.
const COMMAND_SHARE: f64 = 0.4;

type Failed = Box<dyn Error>;

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let result = match arguments.first() {
        Some(word) if word == FEED => feed_target(&arguments[1..]),
        _ => run_all(&arguments),
    };
    match result {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("fabkit-fuzz: {error}");
            ExitCode::from(2)
        }
    }
}

struct Arguments {
    corpus: PathBuf,
    kept: PathBuf,
    command: PathBuf,
    budget: Budget,
    seed: u64,
    names: Vec<String>,
}

impl Arguments {
    fn read(words: &[String]) -> Result<Self, Failed> {
        let [corpus, kept, command, runs, seconds, seed, names @ ..] = words else {
            return Err("six arguments are needed; `cargo xtask fuzz` gives them".into());
        };
        let time = Duration::try_from_secs_f64(seconds.parse()?)?;
        Ok(Self {
            corpus: corpus.into(),
            kept: kept.into(),
            // Absolute, because it is started in other folders.
            command: fs::canonicalize(command)?,
            budget: Budget { runs: runs.parse()?, time },
            seed: seed.parse()?,
            names: names.to_vec(),
        })
    }
}

/// Feeds one target in this process.
fn feed_target(words: &[String]) -> Result<bool, Failed> {
    let Arguments { corpus: folder, kept, budget, seed, names, .. } = Arguments::read(words)?;
    let name = names.first().ok_or("which target?")?;
    let target = TARGETS.iter().find(|target| target.name == name).ok_or("no such target")?;
    let done = feed(*target, &read_corpus(&folder.join(name))?, seed, budget, &kept)?;
    println!("{done}");
    Ok(true)
}

fn run_all(words: &[String]) -> Result<bool, Failed> {
    let all = Arguments::read(words)?;
    let is_wanted = |name: &str| all.names.is_empty() || all.names.iter().any(|n| n == name);
    let targets: Vec<Target> =
        TARGETS.into_iter().filter(|target| is_wanted(target.name)).collect();
    let with_command = is_wanted(COMMAND);
    // Without the other, either part gets the whole budget.
    let for_command = match (with_command, targets.is_empty()) {
        (false, _) => 0.0,
        (true, true) => 1.0,
        (true, false) => COMMAND_SHARE,
    };
    fs::create_dir_all(&all.kept)?;
    let (mut inputs, mut wrong) = (0, 0);
    for target in &targets {
        let share = 1.0 / targets.len() as f64;
        let budget = Budget {
            runs: (all.budget.runs as f64 * share * (1.0 - for_command)) as u64,
            time: all.budget.time.mul_f64(share * (1.0 - for_command)),
        };
        let (done, is_wrong) = run_target(&all, *target, budget)?;
        inputs += done;
        wrong += u64::from(is_wrong);
    }
    let start = Instant::now();
    let (mut done, most) = (0, (all.budget.runs as f64 * for_command) as u64);
    while done < most && start.elapsed() < all.budget.time.mul_f64(for_command) {
        // Each run has its own seed, with which it can be repeated alone.
        let found = end_to_end::run_once(&all.command, &all.corpus, all.seed + done)?;
        if let Some(end_to_end::Misbehaviour { what, input }) = found {
            let kept = keep(&all.kept, &input)?;
            println!("{what}\n  the input is {}", kept.display());
            wrong += 1;
        }
        done += 1;
    }
    if with_command {
        println!("{COMMAND}: {done} inputs");
    }
    println!("{} inputs, {wrong} wrong, seed {}", inputs + done, all.seed);
    Ok(wrong == 0)
}

/// Feeds a target in a separate process. Returns the number of inputs, and whether one made the process fail.
fn run_target(all: &Arguments, target: Target, budget: Budget) -> Result<(u64, bool), Failed> {
    let current = all.kept.join(format!("{}.current", target.name));
    let program = env::current_exe()?;
    let mut command = limit_memory(&program);
    command.arg(FEED).arg(&all.corpus).arg(&current).arg(&all.command);
    command.args([budget.runs.to_string(), budget.time.as_secs_f64().to_string()]);
    let output = command.arg(all.seed.to_string()).arg(target.name).output()?;
    let Some(why) = failure_reason(output.status) else {
        let done = String::from_utf8_lossy(&output.stdout).trim().parse()?;
        println!("{}: {done} inputs", target.name);
        fs::remove_file(&current)?;
        return Ok((done, false));
    };
    let kept = match fs::read(&current) {
        Ok(input) => running::keep(&all.kept.join(target.name), &input)?,
        Err(_) => Path::new("unknown").to_owned(),
    };
    let said = String::from_utf8_lossy(&output.stderr);
    println!("{}: {why}, seed {}\n  the input is {}", target.name, all.seed, kept.display());
    println!("{}", said.lines().take(12).collect::<Vec<_>>().join("\n"));
    Ok((0, true))
}
