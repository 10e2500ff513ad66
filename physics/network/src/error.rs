//! Why a file is no network that can be evaluated.

/// What operators are accepted, for messages.
pub const ACCEPTED: &str =
    "Conv, Relu, Clip, Sigmoid, Identity, and Add, Sub, Mul, Div with a constant";

/// Why a file is no network that can be evaluated, or a picture none that it takes.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NetworkError {
    /// Bytes of something else.
    #[error("this is no ONNX file: its bytes are not those of a model")]
    NoOnnx,
    /// A file that ends too early.
    #[error("the file ends within a value: it is cut off")]
    Truncated,
    /// An operator that is not known here.
    #[error("node {node}: {operator} is not known; a chain of {ACCEPTED} is")]
    Operator {
        /// The node: its number and name.
        node: String,
        /// Its operator.
        operator: String,
    },
    /// A node whose input is not what the one before it gives.
    #[error(
        "node {node}: {operator} takes `{takes}`; a chain is read, in which it takes `{before}`"
    )]
    NoChain {
        /// The node.
        node: String,
        /// Its operator.
        operator: String,
        /// What it takes.
        takes: String,
        /// What the node before it gives.
        before: String,
    },
    /// A graph that gives something else than its chain does, or several things.
    #[error("the graph gives {gives}; a chain gives one map, what its last node does")]
    Outputs {
        /// What it gives.
        gives: String,
    },
    /// A graph that takes several things, or none.
    #[error("the graph takes {takes}; one picture is accepted, 1 x 1 x rows x columns")]
    Inputs {
        /// What it takes.
        takes: String,
    },
    /// An operator that is known, in a way that is not.
    #[error("node {node}: {operator} with {found}; {accepted} is accepted")]
    Attribute {
        /// The node.
        node: String,
        /// Its operator.
        operator: String,
        /// What it has.
        found: String,
        /// What it may have.
        accepted: String,
    },
    /// A constant that is missing, or none of 32 bit numbers.
    #[error(
        "constant `{name}`: {found}; as many finite 32 bit numbers as its shape says, in this file, are accepted"
    )]
    Constant {
        /// Its name.
        name: String,
        /// What is wrong with it.
        found: String,
    },
    /// A network that gives more than one number for each pixel.
    #[error("the network gives {channels} channels; one is accepted: depth")]
    Channels {
        /// How many.
        channels: usize,
    },
    /// A network that is larger than any that a picture needs.
    #[error("the network has {found}; at most {limit} are accepted")]
    TooLarge {
        /// What it has too much of.
        found: String,
        /// How much of it is accepted.
        limit: usize,
    },
    /// A picture whose values are no full rows.
    #[error("{values} values are no picture of {columns} columns")]
    Picture {
        /// How many values there are.
        values: usize,
        /// How many columns it is said to have.
        columns: usize,
    },
    /// A picture with a value that is no number.
    #[error("the picture has a value that is not finite")]
    NotFinite,
}
