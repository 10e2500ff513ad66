//! Shell completions of arguments: designs, their parts, parameters.

use std::ffi::OsStr;

use clap_complete::engine::{
    ArgValueCompleter, CompletionCandidate, PathCompleter, ValueCompleter,
};
use fabkit_application::designs;
use fabkit_application::source::Source;

/// Keeps the names that begin with the current word.
fn filter_candidates<'a>(
    names: impl IntoIterator<Item = String> + 'a,
    current: &'a str,
) -> impl Iterator<Item = CompletionCandidate> + 'a {
    names.into_iter().filter(move |name| name.starts_with(current)).map(CompletionCandidate::new)
}

fn yaml_files(current: &OsStr) -> Vec<CompletionCandidate> {
    PathCompleter::any()
        .filter(|path| path.is_dir() || path.extension().is_some_and(|end| end == "yaml"))
        .complete(current)
}

/// Completes built-in sensors and YAML files.
fn complete_sensors(current: &OsStr) -> Vec<CompletionCandidate> {
    let names = designs::builtin_names().into_iter().map(str::to_owned);
    let mut found: Vec<_> = filter_candidates(names, &current.to_string_lossy()).collect();
    found.extend(yaml_files(current));
    found
}

/// Completes sensors and, behind `/`, their fixtures, optionally also their parts.
fn complete_designs(current: &OsStr, with_parts: bool) -> Vec<CompletionCandidate> {
    let text = current.to_string_lossy();
    let Some((sensor, _)) = text.split_once('/') else { return complete_sensors(current) };
    let Ok(project) = Source::find(sensor).and_then(|source| source.load(&[])) else {
        return yaml_files(current);
    };
    let mut names: Vec<String> = project.fixture_names().into_iter().map(str::to_owned).collect();
    if with_parts {
        names.extend(project.design.sensor.parts().map(|part| part.name.clone()));
    }
    let names = names.into_iter().map(|name| format!("{sensor}/{name}"));
    let mut found: Vec<_> = filter_candidates(names, &text).collect();
    found.extend(yaml_files(current));
    found
}

/// Completes `SENSOR`.
pub(super) fn sensors() -> ArgValueCompleter {
    ArgValueCompleter::new(complete_sensors)
}

/// Completes `SENSOR` or `SENSOR/FIXTURE`.
pub(super) fn designs() -> ArgValueCompleter {
    ArgValueCompleter::new(|current: &OsStr| complete_designs(current, false))
}

/// Completes `SENSOR`, `SENSOR/FIXTURE` or `SENSOR/PART`.
pub(super) fn parts() -> ArgValueCompleter {
    ArgValueCompleter::new(|current: &OsStr| complete_designs(current, true))
}

/// Completes `PATH=VALUE`.
pub(super) fn settings() -> ArgValueCompleter {
    ArgValueCompleter::new(complete_parameter_paths)
}

/// Completes parameter paths of all families, because the sensor is not known here.
fn complete_parameter_paths(current: &OsStr) -> Vec<CompletionCandidate> {
    let families = designs::REGISTRY.families();
    let mut paths: Vec<String> = families
        .iter()
        .flat_map(|family| designs::REGISTRY.parameter_paths(family.name()))
        .map(|path| path + "=")
        .collect();
    paths.sort();
    paths.dedup();
    filter_candidates(paths, &current.to_string_lossy()).collect()
}
