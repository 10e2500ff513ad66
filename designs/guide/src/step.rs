//! Steps as a guide presents them.

use serde::Serialize;

/// Body that a step needs.
#[derive(Clone, Debug, Serialize)]
pub struct NeededBody {
    /// Name in the design.
    pub name: String,
    /// Number of pieces for one unit.
    pub count: usize,
}

/// Step of a build.
#[derive(Clone, Debug, Serialize)]
pub struct GuideStep {
    /// Number, from 1.
    pub number: usize,
    /// Name in the design.
    pub name: String,
    /// Action: `make`, `prepare`, `assemble`, `bond`, `spray`, `pour` or `demold`.
    pub action: &'static str,
    /// Instruction, as a sentence.
    pub instruction: String,
    /// Assembly in which the bodies are placed.
    pub assembly: Option<String>,
    /// Bodies that it needs, in the order of the design.
    pub needs: Vec<NeededBody>,
    /// Names of the bodies that it takes off.
    pub removed: Vec<String>,
    /// Names of the bodies that are adjusted.
    pub adjusted: Vec<String>,
    /// Number of the step that cures meanwhile.
    pub during: Option<usize>,
    /// Section of the paper, or reason for the step.
    pub source: String,
    /// Tools to hold.
    pub tools: Vec<String>,
    /// Checks when it is done.
    pub checks: Vec<String>,
    /// Directions in which bodies come and go.
    pub ways: Vec<BodyMotion>,
}

/// Bodies that are put in place or taken away together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BodyMotion {
    /// Names of the bodies.
    pub bodies: Vec<String>,
    /// True if they come, false if they go.
    pub is_coming: bool,
    /// Direction of motion, a unit vector in the assembly's frame.
    pub along: [f64; 3],
}
