//! Errors of reading and evaluating networks.

/// Accepted operators, for messages.
pub const ACCEPTED: &str =
    "Conv, Relu, Clip, Sigmoid, Identity, and Add, Sub, Mul, Div with a constant";

/// Reason why a file is not a network that can be evaluated, or an image does not suit it.
///
/// ```
/// use fabkit_network::writer::{ChainLayer, write_chain};
/// use fabkit_network::{Network, NetworkError};
///
/// // Two channels would be two maps; messages name the node that is at fault.
/// let two = ChainLayer::convolution([2, 1, 1, 1], 1, &[1.0; 2], &[0.0; 2]);
/// let error = Network::read(&write_chain(&[two])).unwrap_err();
/// assert_eq!(error, NetworkError::Channels { channels: 2 });
/// let cut_off = &write_chain(&[ChainLayer::operator("Relu")])[..20];
/// assert!(Network::read(cut_off).is_err());
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NetworkError {
    /// Bytes that are not an ONNX model.
    #[error("this is no ONNX file: its bytes are not those of a model")]
    NotOnnx,
    /// File that ends too early.
    #[error("the file ends within a value: it is cut off")]
    Truncated,
    /// Unknown operator.
    #[error("node {node}: {operator} is not known; a chain of {ACCEPTED} is")]
    Operator {
        /// Number and name of the node.
        node: String,
        /// Operator of the node.
        operator: String,
    },
    /// Node whose input is not the output of the node before it.
    #[error(
        "node {node}: {operator} takes `{takes}`; a chain is read, in which it takes `{before}`"
    )]
    NotAChain {
        /// Number and name of the node.
        node: String,
        /// Operator of the node.
        operator: String,
        /// Input of the node.
        takes: String,
        /// Output of the node before it.
        before: String,
    },
    /// Graph with several outputs, or an output other than that of its last node.
    #[error("the graph gives {gives}; a chain gives one map, what its last node does")]
    Outputs {
        /// Outputs of the graph.
        gives: String,
    },
    /// Graph with several inputs, or none.
    #[error("the graph takes {takes}; one image is accepted, 1 x 1 x rows x columns")]
    Inputs {
        /// Inputs of the graph.
        takes: String,
    },
    /// Known operator with an unsupported attribute or input.
    #[error("node {node}: {operator} with {found}; {accepted} is accepted")]
    Attribute {
        /// Number and name of the node.
        node: String,
        /// Operator of the node.
        operator: String,
        /// Unsupported attribute or input.
        found: String,
        /// Accepted alternative.
        accepted: String,
    },
    /// Constant that is missing, or not made of 32-bit numbers.
    #[error(
        "constant `{name}`: {found}; as many finite 32 bit numbers as its shape says, in this file, are accepted"
    )]
    Constant {
        /// Name of the constant.
        name: String,
        /// Description of the problem.
        found: String,
    },
    /// Network with more than one output per pixel.
    #[error("the network gives {channels} channels; one is accepted: depth")]
    Channels {
        /// Number of output channels.
        channels: usize,
    },
    /// Network that is too large.
    #[error("the network has {found}; at most {limit} are accepted")]
    TooLarge {
        /// Property that is too large.
        found: String,
        /// Limit.
        limit: usize,
    },
    /// Image whose values do not form complete rows.
    #[error("{values} values are no image of {columns} columns")]
    ImageShape {
        /// Number of values.
        values: usize,
        /// Stated number of columns.
        columns: usize,
    },
    /// Image with a value that is not finite.
    #[error("the image has a value that is not finite")]
    NotFinite,
}
