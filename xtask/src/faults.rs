//! `cargo xtask faults [--rounds N] [--seed N]`: state of the disk after injected faults.
//!
//! A small library that is loaded before the C library ([`shim`]) fails, or kills the command, at each of its calls of
//! open, write, rename, link and fsync. Other runs are killed at random moments, run simultaneously in the same folder,
//! or run out of memory. After each trial the old files are complete or the new ones are, an existing list of contents
//! is correct, and the next run leaves nothing but its files.

mod inputs;
mod judge;
mod random;
mod scenarios;
mod shim;

use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

use self::random::Random;
use self::scenarios::Scenario;
use crate::run::{built_path, root, skip};

/// Numbers of trials in one round. The gate does one round; a thorough search about twenty.
const FAULTS: usize = 220;
const KILLS: usize = 50;
const CONCURRENT_RUNS: usize = 10;
const MEMORY_RUNS: usize = 12;

/// Single trial.
#[derive(Clone, Debug)]
enum Trial {
    /// A system call fails, or kills the process.
    Call(shim::Fault),
    /// The process is killed after this share of its usual time.
    Kill(f64),
    /// Several processes run at once; in a resumable folder, after one that was killed after this share of its usual
    /// time.
    Concurrent(f64),
    /// The address space is limited to this number of MiB.
    Memory(u64),
}

/// Runs the trials.
pub fn run(arguments: &[String]) -> Result<(), String> {
    let option = |name: &str, usual: u64| -> Result<u64, String> {
        let place = arguments.iter().position(|argument| argument == name);
        let value = place.map(|i| arguments.get(i + 1).map(String::as_str).unwrap_or_default());
        value.map_or(Ok(usual), |v| v.parse().map_err(|_| format!("{name} needs a number")))
    };
    let (rounds, seed) = (option("--rounds", 1)?, option("--seed", 1)?);
    let scratch = Scratch::new(seed)?;
    let shim = match shim::build(&scratch.0) {
        Ok(shim) => shim,
        Err(why) => return skip("injected faults", &why),
    };
    let fabkit = crate::run::fabkit()?;
    let mut scenarios = scenarios::all(&fabkit, &scratch.0)?;
    for scenario in &mut scenarios {
        scenario.prepare(&shim)?;
    }
    let trials = draw_trials(&scenarios, rounds as usize, &mut Random(seed));
    let next = AtomicUsize::new(0);
    let wrong = Mutex::new(Vec::new());
    let threads = thread::available_parallelism().map_or(2, usize::from);
    thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some((scenario, trial)) = trials.get(next.fetch_add(1, Ordering::Relaxed))
                {
                    let scenario = &scenarios[*scenario];
                    if let Err(why) = scenario.try_out(trial, &shim) {
                        let text = format!("{} {trial:?}: {why}", scenario.name);
                        eprintln!("{text}");
                        wrong.lock().unwrap_or_else(PoisonError::into_inner).push(text);
                    }
                }
            });
        }
    });
    let count = |of: fn(&Trial) -> bool| trials.iter().filter(|(_, trial)| of(trial)).count();
    println!(
        "xtask: {} injected faults, {} kills, {} crowds, {} starved runs; seed {seed}",
        count(|t| matches!(t, Trial::Call(fault) if !fault.kills())),
        count(|t| matches!(t, Trial::Kill(_)) || matches!(t, Trial::Call(f) if f.kills())),
        count(|t| matches!(t, Trial::Concurrent(_))),
        count(|t| matches!(t, Trial::Memory(_))),
    );
    let wrong = wrong.into_inner().unwrap_or_else(PoisonError::into_inner);
    match wrong.len() {
        0 => Ok(()),
        n => Err(format!("{n} trials lost, tore or left something")),
    }
}

/// Draws the trials: every call of every kind in turn until the number is reached, the rest at random.
fn draw_trials(scenarios: &[Scenario], rounds: usize, random: &mut Random) -> Vec<(usize, Trial)> {
    let mut trials = Vec::new();
    let mut calls: Vec<(usize, shim::Fault)> = scenarios
        .iter()
        .enumerate()
        .flat_map(|(i, scenario)| scenario.faults().into_iter().map(move |fault| (i, fault)))
        .collect();
    // The order depends on the seed, so that short runs with different seeds cover everything.
    random.shuffle(&mut calls);
    let (kills, fails): (Vec<_>, Vec<_>) = calls.into_iter().partition(|(_, f)| f.kills());
    // Each call at most once in every round, even if there are few of them.
    let some = |of: Vec<(usize, shim::Fault)>, count: usize| {
        let all = of.len().max(1);
        let of = of.into_iter().cycle().take(count.min(all * rounds));
        of.map(|(i, fault)| (i, Trial::Call(fault))).collect::<Vec<_>>()
    };
    trials.extend(some(fails, FAULTS * rounds));
    trials.extend(some(kills, KILLS * rounds / 2));
    let mut any = |of: &dyn Fn(&Scenario) -> bool| {
        let fit: Vec<usize> = (0..scenarios.len()).filter(|i| of(&scenarios[*i])).collect();
        fit[random.below(fit.len())]
    };
    for _ in 0..rounds * KILLS / 2 {
        // The values are drawn below, after all trials are chosen.
        let at = any(&|_| true);
        trials.push((at, Trial::Kill(0.0)));
    }
    for _ in 0..rounds * CONCURRENT_RUNS {
        trials.push((any(&|s| s.has_rivals()), Trial::Concurrent(0.0)));
    }
    for _ in 0..rounds * MEMORY_RUNS {
        trials.push((any(&|_| true), Trial::Memory(0)));
    }
    for (_, trial) in &mut trials {
        match trial {
            Trial::Kill(part) => *part = random.unit(),
            // Negative values are set to 0: half of the crowds start in an empty folder.
            Trial::Concurrent(part) => *part = (2.0 * random.unit() - 1.0).max(0.0),
            Trial::Memory(mib) => *mib = 60 + random.below(400) as u64,
            _ => {}
        }
    }
    trials
}

/// Temporary folder of all trials, removed when dropped.
struct Scratch(PathBuf);

impl Scratch {
    fn new(seed: u64) -> Result<Self, String> {
        let name = format!("faults-{}-{seed}", std::process::id());
        let folder =
            built_path("release", "").parent().map_or_else(|| root().join("target"), |p| p.into());
        let folder = folder.join(name);
        std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        folder.canonicalize().map(Self).map_err(|e| format!("{}: {e}", folder.display()))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
