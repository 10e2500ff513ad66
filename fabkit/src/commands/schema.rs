//! `fabkit schema`

use super::{Report, line};
use crate::failure::Failure;

pub(super) fn run() -> Result<Report, Failure> {
    let json = fabkit::fixtures::json_schema();
    Ok(Report { text: line(&json), json, failed: false })
}
