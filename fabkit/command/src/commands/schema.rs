//! `fabkit schema [--sweep | --output NAME]`

use super::Outcome;
use crate::failure::Failure;

pub(super) fn run(sweep: bool, output: Option<&str>) -> Result<Outcome, Failure> {
    let json = match output {
        Some(name) => super::contracts::schema(name)?,
        None if sweep => fabkit_application::sweep::json_schema(),
        None => fabkit_application::fixtures::json_schema(),
    };
    Ok(Outcome { text: format!("{json:#}\n"), json, failed: false })
}
