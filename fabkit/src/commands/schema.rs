//! `fabkit schema [--sweep]`

use super::{Report, line};
use crate::failure::Failure;

pub(super) fn run(sweep: bool) -> Result<Report, Failure> {
    let json = match sweep {
        true => fabkit_application::sweep::json_schema(),
        false => fabkit_application::fixtures::json_schema(),
    };
    Ok(Report { text: line(&json), json, failed: false })
}
