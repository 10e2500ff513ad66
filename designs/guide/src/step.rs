//! A step as a guide tells it.

use serde::Serialize;

/// What a step needs.
#[derive(Clone, Debug, Serialize)]
pub struct Need {
    /// Its name in the design.
    pub name: String,
    /// How many for one unit.
    pub count: usize,
}

/// One step.
#[derive(Clone, Debug, Serialize)]
pub struct GuideStep {
    /// From 1.
    pub number: usize,
    /// Its name in the design.
    pub name: String,
    /// What is done: `make`, `prepare`, `assemble`, `bond`, `spray`, `pour` or `demold`.
    pub action: &'static str,
    /// What to do, as a sentence.
    pub instruction: String,
    /// Where bodies stand together.
    pub assembly: Option<String>,
    /// What it needs, in the order of the design.
    pub needs: Vec<Need>,
    /// What comes off in it, by name.
    pub removed: Vec<String>,
    /// Who sets something right in it, by name.
    pub adjusted: Vec<String>,
    /// The number of the step whose cure is waited for meanwhile.
    pub during: Option<usize>,
    /// Section of the paper, or why it is so.
    pub source: String,
    /// What hands hold in it.
    pub tools: Vec<String>,
    /// What to check when it is done.
    pub checks: Vec<String>,
    /// Which way things come and go.
    pub ways: Vec<Way>,
}

/// Bodies that are brought to their places or taken away together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Way {
    /// Which, by name.
    pub bodies: Vec<String>,
    /// Whether they come; else they go.
    pub is_coming: bool,
    /// Which way, a unit vector of the assembly's frame.
    pub along: [f64; 3],
}
