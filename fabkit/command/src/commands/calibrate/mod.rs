//! `fabkit calibrate ...`: cameras and poses from images.

mod extrinsics;
mod intrinsics;
mod pins;
mod plan;

use super::Outcome;
use crate::cli::Calibrate;
use crate::failure::Failure;

pub(super) fn run(what: &Calibrate) -> Result<Outcome, Failure> {
    match what {
        Calibrate::Intrinsics(args) => intrinsics::run(args),
        Calibrate::Pins(args) => pins::run(args),
        Calibrate::Extrinsics(args) => extrinsics::run(args),
        Calibrate::Plan(args) => plan::run(args),
    }
}
