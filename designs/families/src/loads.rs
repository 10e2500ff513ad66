//! Loads that a sensor must bear.

use crate::materials::Force;
use crate::parameters;

parameters! {
    /// Loads that the sensor must bear.
    pub struct Loads {
        /// What pushes, drags and pulls at the touched surface, and must not tear it off.
        touch: Force = 0.1..=1000.0,
    }
}

/// Key of the section in the files of every family.
pub const KEY: &str = "loads";

/// Summary of the section.
pub const SUMMARY: &str = "What the sensor must bear.";

/// Default values: file name for messages, and YAML text.
pub const DEFAULTS: (&str, &str) = ("loads.yaml (defaults)", include_str!("loads.yaml"));
