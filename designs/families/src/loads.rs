//! What a sensor must bear.

use crate::materials::Force;
use crate::parameters;

parameters! {
    /// Loads that the sensor must withstand.
    pub struct Loads {
        /// Force on the touched surface, in pushing, dragging and pulling, that must not tear it off.
        touch: Force = 0.1..=1000.0,
    }
}

/// The key of the section in every family's files.
pub const KEY: &str = "loads";

/// What it is for.
pub const SUMMARY: &str = "Loads that the sensor must withstand.";

/// Its values where no file says anything else, for messages, and their text.
pub const DEFAULTS: (&str, &str) = ("loads.yaml (defaults)", include_str!("loads.yaml"));
