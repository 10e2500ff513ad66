//! Invalid command lines: conversion of clap's errors for scripts and for people.

use clap::error::{ContextKind, ContextValue, Error, ErrorKind as Slip};
use fabkit_application::ErrorSubject;

use crate::failure::{ErrorKind, Failure};

/// Converts clap's error to a failure for `--json`, with its first paragraph as the message and the rest as the hint.
pub(super) fn from_clap(error: &Error) -> Failure {
    let text = error.render().to_string();
    let (message, rest) = text.split_once("\n\n").unwrap_or((&text, ""));
    let message = message.trim_start_matches("error: ");
    Failure::new(ErrorKind::BadInput, message, rest.trim()).with_subject(error_subject(error))
}

/// Largest length of a usage line that is kept. Longer ones list every alternative, which helps nobody.
const USAGE_LENGTH: usize = 160;

/// Formats clap's error for people, without empty lines, long usage lines, and the pointer to `--help` that ends every
/// message of clap.
pub(super) fn text(error: &Error) -> String {
    let text = error.render().to_string();
    let is_kept = |line: &&str| {
        let is_long_usage = line.starts_with("Usage:") && line.len() > USAGE_LENGTH;
        !(line.trim().is_empty() || line.starts_with("For more information") || is_long_usage)
    };
    text.lines().filter(is_kept).map(|line| format!("{line}\n")).collect()
}

fn error_subject(error: &Error) -> ErrorSubject {
    let first = |kind| context_values(error, kind).into_iter().next();
    // The context has the form `--tolerance <LENGTH>`.
    let name = |text: String| text.split(' ').next().unwrap_or_default().to_owned();
    let option = first(ContextKind::InvalidArg).map(name);
    let of = |code: &str| ErrorSubject { path: option.clone(), ..ErrorSubject::new(code) };
    match error.kind() {
        Slip::UnknownArgument => ErrorSubject {
            written: option,
            suggestion: first(ContextKind::SuggestedArg).map(name),
            ..ErrorSubject::new("unknown_option")
        },
        Slip::InvalidSubcommand => ErrorSubject {
            written: first(ContextKind::InvalidSubcommand),
            // clap sorts suggestions by similarity, the best last.
            suggestion: context_values(error, ContextKind::SuggestedSubcommand).pop(),
            ..ErrorSubject::new("unknown_command")
        },
        Slip::InvalidValue | Slip::ValueValidation => ErrorSubject {
            written: first(ContextKind::InvalidValue),
            choices: context_values(error, ContextKind::ValidValue),
            suggestion: first(ContextKind::SuggestedValue),
            ..of("invalid_argument")
        },
        Slip::MissingRequiredArgument
        | Slip::MissingSubcommand
        | Slip::DisplayHelpOnMissingArgumentOrSubcommand => of("missing_argument"),
        Slip::ArgumentConflict => of("conflicting_options"),
        Slip::TooManyValues | Slip::TooFewValues | Slip::WrongNumberOfValues => of("wrong_count"),
        Slip::InvalidUtf8 => of("not_utf8"),
        _ => of("bad_input"),
    }
}

fn context_values(error: &Error, kind: ContextKind) -> Vec<String> {
    match error.get(kind) {
        Some(ContextValue::String(word)) => vec![word.clone()],
        Some(ContextValue::Strings(words)) => words.clone(),
        _ => Vec::new(),
    }
}
