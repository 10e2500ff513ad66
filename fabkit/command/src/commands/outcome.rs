//! What commands answer.

use serde_json::Value;

/// What a command has to say.
pub(super) struct Outcome {
    /// For people; empty for nothing.
    pub(super) text: String,
    /// For scripts.
    pub(super) json: Value,
    /// A check found errors.
    pub(super) failed: bool,
}
