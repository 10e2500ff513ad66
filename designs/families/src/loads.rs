//! What a sensor must bear.

use crate::materials::Force;
use crate::parameters;

parameters! {
    /// What the sensor must bear.
    pub struct Loads {
        /// What pushes, drags and pulls at the touched surface, and must not tear it off.
        touch: Force = 0.1..=1000.0,
    }
}

/// The key of the section in every family's files.
pub const KEY: &str = "loads";

/// What it is for.
pub const SUMMARY: &str = "What the sensor must bear.";

/// Its values where no file says anything else, for messages, and their text.
pub const DEFAULTS: (&str, &str) = ("loads.yaml (defaults)", include_str!("loads.yaml"));
