//! Loads that a sensor must bear.

use crate::materials::Force;
use crate::parameters;

parameters! {
    /// Loads that the sensor must withstand.
    pub struct Loads {
        /// Force on the touched surface, in pushing, dragging and pulling, that must not tear it off.
        touch: Force = 0.1..=1000.0,
    }
}

/// Key of the section in the files of every family.
pub const KEY: &str = "loads";

/// Summary of the section.
pub const SUMMARY: &str = "Loads that the sensor must withstand.";

/// Default values: file name for messages, and YAML text.
pub const DEFAULTS: (&str, &str) = ("loads.yaml (defaults)", include_str!("loads.yaml"));
