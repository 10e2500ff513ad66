//! The `fabkit` command: one file for each subcommand. A command returns the text for standard output; only this module
//! prints.

mod archive;
mod bench;
mod calibrate;
mod camera_files;
mod capture;
mod check;
mod completions;
mod contracts;
mod dataset;
mod depth;
mod diff;
mod export;
mod files;
mod findings;
mod fit_light;
mod fix_option;
mod gel_profile;
mod guide;
mod list;
mod man;
mod new;
mod not_known;
mod optics_pack;
mod outcome;
mod press;
mod profile;
mod profile_report;
mod progress;
mod reconstruct;
mod render;
mod schema;
mod show;
mod sweep;
mod typed;
mod usage_error;
mod value_effects;
mod verify;
mod verify_folder;
mod view;

use std::ffi::OsString;
use std::io;

use clap::{CommandFactory, Parser};
use clap_complete::CompleteEnv;
use fabkit_application::fixtures::ValueEffects;
use fabkit_application::memory;

use crate::cli::{Calibrate, Cli, Command, Global};
use crate::failure::{self, ErrorKind, Failure, FailureCode};
use crate::{interrupt, terminal};
use outcome::Outcome;

/// Exit code of a command that worked, but found errors in what it examined.
const CHECK_FAILED: u8 = 1;

/// Runs a command line, see [`run`](crate::run).
pub(crate) fn main(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    if complete_shell(&arguments) {
        return 0;
    }
    let json = arguments.iter().any(|word| word == "--json");
    failure::catch_panics(json, || match Cli::try_parse_from(&arguments) {
        Ok(cli) => run_and_print(cli),
        // Help and version are "errors" of clap that go to standard output; the last arm prints them.
        Err(error) if error.use_stderr() && json => {
            let failure = usage_error::from_clap(&error);
            exit_after(terminal::print_json(&failure.to_json()), failure.exit_code() as u8)
        }
        Err(error) if error.use_stderr() => {
            terminal::tell(&usage_error::text(&error));
            FailureCode::BadInput as u8
        }
        Err(error) => error.exit(),
    })
}

/// Returns whether this call was a shell's request for completions, recognised by the variable that the script of
/// `fabkit completions` sets.
fn complete_shell(arguments: &[OsString]) -> bool {
    let folder = std::env::current_dir().ok();
    let shell = CompleteEnv::with_factory(Cli::command);
    shell.try_complete(arguments.iter().cloned(), folder.as_deref()).unwrap_or_else(|e| e.exit())
}

fn run_and_print(mut cli: Cli) -> u8 {
    interrupt::install_handler();
    let result = run_with_fix(&mut cli);
    let Global { json, quiet, .. } = cli.global;
    match &result {
        Ok(report) if json => exit_after(terminal::print_json(&report.json), exit_code(report)),
        Ok(report) => {
            // `--quiet` suppresses reports, but not text that is the command's result.
            let is_wanted = !quiet || report.failed || prints_its_result(&cli.command);
            let text = if is_wanted { &*report.text } else { "" };
            exit_after(terminal::print(text), exit_code(report))
        }
        Err(failure) => {
            let code = failure.exit_code() as u8;
            if json {
                return exit_after(terminal::print_json(&failure.to_json()), code);
            }
            terminal::tell(&failure.to_text());
            code
        }
    }
}

/// Returns the exit code after printing, or that of an output error.
fn exit_after(printed: io::Result<()>, code: u8) -> u8 {
    match printed {
        // The reader has closed the pipe, as in `fabkit show rtac0 | head`.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => code,
        Err(error) => {
            terminal::tell(&format!("error: cannot write to standard output: {error}\n"));
            FailureCode::Io as u8
        }
        Ok(()) => code,
    }
}

fn exit_code(report: &Outcome) -> u8 {
    if report.failed { CHECK_FAILED } else { 0 }
}

/// Runs the command with the changes of `--fix`.
fn run_with_fix(cli: &mut Cli) -> Result<Outcome, Failure> {
    let Some(changes) = fix_option::apply_fix(&mut cli.command)? else {
        return run_with_warnings(cli, &value_effects::find_effects(&cli.command));
    };
    let mut effects = value_effects::find_effects(&cli.command);
    // The changes are fabkit's, not the user's.
    effects.effects.retain(|one| changes.iter().all(|change| change.path != one.path()));
    fix_option::print_changes(&changes, &cli.global);
    let mut outcome = run_with_warnings(cli, &effects)?;
    fix_option::add_to(&mut outcome.json, &changes);
    Ok(outcome)
}

/// Runs the command with warnings about values that change nothing.
fn run_with_warnings(cli: &Cli, effects: &ValueEffects) -> Result<Outcome, Failure> {
    value_effects::print_effects(effects, &cli.global);
    let mut outcome = run(cli)?;
    camera_files::move_warnings_to(&mut outcome.json);
    not_known::add_lines(&mut outcome);
    value_effects::add_to(&mut outcome.json, effects);
    Ok(outcome)
}

fn run(cli: &Cli) -> Result<Outcome, Failure> {
    memory::set_limit(cli.global.memory);
    let Some(threads) = cli.global.threads else { return run_command(cli) };
    // A pool of its own instead of the global one, which can be set once only and does not survive a fork.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build();
    let failed = |e| Failure::plain(ErrorKind::Limit, format!("{threads} threads: {e}"));
    pool.map_err(failed)?.install(|| run_command(cli))
}

fn run_command(cli: &Cli) -> Result<Outcome, Failure> {
    match &cli.command {
        Command::List => list::run(),
        Command::New(args) => new::run(args),
        Command::Show(args) => show::run(args, &cli.global),
        Command::Check(args) => check::run(args, &cli.global),
        Command::Verify(args) => verify::run(args, &cli.global),
        Command::Export(args) => export::run(args, &cli.global),
        Command::Guide(args) => guide::run(args, &cli.global),
        Command::Diff(args) => diff::run(args),
        Command::Profile(args) => profile::run(args),
        Command::Render(args) => render::run(args, &cli.global),
        Command::Depth(args) => depth::run(args),
        Command::Press(args) => press::run(args),
        Command::Capture(args) => capture::run(args),
        Command::FitLight(args) => fit_light::run(args),
        Command::Reconstruct(args) => reconstruct::run(args),
        Command::Bench(args) => bench::run(args, &cli.global),
        Command::OpticsPack(args) => optics_pack::run(args),
        Command::Dataset(args) => dataset::run(args, &cli.global),
        Command::Calibrate { what } => calibrate::run(what),
        Command::Sweep(args) => sweep::run(args, &cli.global),
        Command::Schema { sweep, output } => schema::run(*sweep, output.as_deref()),
        Command::Completions { shell } => completions::run(*shell),
        Command::Man { output } => man::run(output.as_deref()),
    }
}

/// Returns whether the command's text is its result, instead of a report on its work.
fn prints_its_result(command: &Command) -> bool {
    !matches!(
        command,
        Command::Calibrate { what: Calibrate::Intrinsics(_) | Calibrate::Extrinsics(_) }
            | Command::Capture(_)
            | Command::Bench(_)
            | Command::Check(_)
            | Command::Dataset(_)
            | Command::Depth(_)
            | Command::Export(_)
            | Command::Guide(_)
            | Command::New(_)
            | Command::OpticsPack(_)
            | Command::Reconstruct(_)
            | Command::Sweep(_)
            | Command::Verify(_)
            | Command::Render(_)
            | Command::Man { output: Some(_) }
    )
}
