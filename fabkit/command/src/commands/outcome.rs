//! Results of commands.

use serde_json::Value;

/// Result of a command.
pub(super) struct Outcome {
    /// Text for people; may be empty.
    pub(super) text: String,
    /// JSON document for scripts.
    pub(super) json: Value,
    /// True if a check found errors.
    pub(super) failed: bool,
}
