//! Command lines that cannot be read, for scripts: what clap says, as one of fabkit's failures.

use clap::error::{ContextKind, ContextValue, Error, ErrorKind as Slip};
use fabkit_application::coded::About;

use crate::failure::{ErrorKind, Failure};

/// The same as a failure; people get clap's own text.
pub(super) fn failure(error: &Error) -> Failure {
    let text = error.render().to_string();
    let (message, rest) = text.split_once("\n\n").unwrap_or((&text, ""));
    let message = message.trim_start_matches("error: ");
    Failure::new(ErrorKind::BadInput, message, rest.trim()).about(about(error))
}

fn about(error: &Error) -> About {
    let first = |kind| words(error, kind).into_iter().next();
    // `--tolerance <LENGTH>`
    let name = |text: String| text.split(' ').next().unwrap_or_default().to_owned();
    let option = first(ContextKind::InvalidArg).map(name);
    let of = |code: &str| About { path: option.clone(), ..About::of(code) };
    match error.kind() {
        Slip::UnknownArgument => About {
            written: option,
            suggestion: first(ContextKind::SuggestedArg).map(name),
            ..About::of("unknown_option")
        },
        Slip::InvalidSubcommand => About {
            written: first(ContextKind::InvalidSubcommand),
            // The nearest stands last.
            suggestion: words(error, ContextKind::SuggestedSubcommand).pop(),
            ..About::of("unknown_command")
        },
        Slip::InvalidValue | Slip::ValueValidation => About {
            written: first(ContextKind::InvalidValue),
            choices: words(error, ContextKind::ValidValue),
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

fn words(error: &Error, kind: ContextKind) -> Vec<String> {
    match error.get(kind) {
        Some(ContextValue::String(word)) => vec![word.clone()],
        Some(ContextValue::Strings(words)) => words.clone(),
        _ => Vec::new(),
    }
}
