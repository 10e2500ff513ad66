//! `fabkit schema [--sweep]`

use super::{Outcome, line};
use crate::failure::Failure;

pub(super) fn run(sweep: bool) -> Result<Outcome, Failure> {
    let json = match sweep {
        true => fabkit_application::sweep::json_schema(),
        false => fabkit_application::fixtures::json_schema(),
    };
    Ok(Outcome { text: line(&json), json, failed: false })
}
