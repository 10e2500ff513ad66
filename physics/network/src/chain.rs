//! Conversion of an ONNX graph to a chain of layers that can be evaluated.

use crate::NetworkError;
use crate::convolution::Convolution;
use crate::onnx::{Attribute, Graph, Node, Tensor, read_graph, read_tensor};
use crate::pointwise::{Pointwise, PointwiseConstant};

/// Maximum number of channels between two layers: a tile of them must fit in memory.
const MAX_CHANNELS: usize = 1024;
/// Maximum reach of an output pixel: how many input pixels to each side influence it.
const MAX_REACH_PX: usize = 64;

/// Convolution, and the pointwise operations on its output.
#[derive(Clone, Debug)]
pub struct ConvolutionStage {
    pub convolution: Convolution,
    pub pointwise: Vec<Pointwise>,
}

/// Chain of layers from an image with one channel to a map with one channel.
#[derive(Clone, Debug, Default)]
pub struct Chain {
    /// Pointwise operations on the image before the first convolution.
    pub before: Vec<Pointwise>,
    pub stages: Vec<ConvolutionStage>,
}

/// Reads a chain from the bytes of an ONNX file.
///
/// # Errors
/// If the graph is not a chain of known operators; see [`NetworkError`].
pub fn read_chain(bytes: &[u8]) -> Result<Chain, NetworkError> {
    let mut graph = read_graph(bytes)?;
    let [input] = &graph.inputs[..] else {
        return Err(NetworkError::Inputs { takes: quote_names(&graph.inputs) });
    };
    let mut reading = ChainBuilder {
        current: input.clone(),
        channels: 1,
        reach: [0, 0],
        chain: Chain::default(),
    };
    let nodes = std::mem::take(&mut graph.nodes);
    for (number, node) in nodes.into_iter().enumerate() {
        let at = NodeContext {
            node: &format!("{} `{}`", number + 1, node.name),
            operator: &node.operator,
        };
        // Both names stand for the standard operators.
        if !matches!(&node.domain[..], "" | "ai.onnx") {
            let operator = format!("{}.{}", node.domain, node.operator);
            return Err(NetworkError::Operator { node: at.node.to_owned(), operator });
        }
        // Kept with the initializers of the graph.
        if node.operator == "Constant" {
            let value = node.attributes.get("value").and_then(|value| value.tensor.clone());
            let (Some(value), [name]) = (value, &node.outputs[..]) else {
                return Err(at.attribute_error("something else than `value`", "a tensor in it"));
            };
            graph.constants.insert(name.clone(), value);
            continue;
        }
        reading.add_node(&graph, at, &node)?;
    }
    let ChainBuilder { current, channels, chain, .. } = reading;
    if graph.outputs != [current] {
        return Err(NetworkError::Outputs { gives: quote_names(&graph.outputs) });
    }
    if channels != 1 {
        return Err(NetworkError::Channels { channels });
    }
    Ok(chain)
}

/// Quotes names for a message.
fn quote_names(names: &[String]) -> String {
    match names {
        [] => "nothing".to_owned(),
        names => format!("`{}`", names.join("`, `")),
    }
}

/// Node that is being read, for messages.
#[derive(Clone, Copy)]
struct NodeContext<'a> {
    node: &'a str,
    operator: &'a str,
}

impl NodeContext<'_> {
    /// Creates the error of an unsupported attribute or input.
    fn attribute_error(self, found: impl Into<String>, accepted: &str) -> NetworkError {
        NetworkError::Attribute {
            node: self.node.to_owned(),
            operator: self.operator.to_owned(),
            found: found.into(),
            accepted: accepted.to_owned(),
        }
    }
}

/// Chain as far as it has been read.
struct ChainBuilder {
    /// Name of the last node's output.
    current: String,
    channels: usize,
    /// Reach of an output pixel so far, rows and columns, px.
    reach: [usize; 2],
    chain: Chain,
}

impl ChainBuilder {
    /// Adds a node to the chain.
    fn add_node(
        &mut self,
        graph: &Graph,
        at: NodeContext,
        node: &Node,
    ) -> Result<(), NetworkError> {
        let known = ["Conv", "Relu", "Clip", "Sigmoid", "Identity", "Add", "Sub", "Mul", "Div"];
        if !known.contains(&at.operator) {
            let (node, operator) = (at.node.to_owned(), at.operator.to_owned());
            return Err(NetworkError::Operator { node, operator });
        }
        let data = self.find_data_input(at, node)?;
        let [output] = &node.outputs[..] else {
            return Err(at.attribute_error(format!("{} outputs", node.outputs.len()), "one"));
        };
        let others: Vec<&str> =
            (0..node.inputs.len()).filter(|i| *i != data).map(|i| &node.inputs[i][..]).collect();
        let constant = |i: usize| others.get(i).filter(|name| !name.is_empty());
        match at.operator {
            "Conv" => self.convolve(graph, at, node, &others)?,
            "Relu" => self.push_pointwise(Pointwise::Clip { least: 0.0, most: f32::INFINITY }),
            "Sigmoid" => self.push_pointwise(Pointwise::Sigmoid),
            "Clip" => {
                // Limits are attributes up to version 6 of the operator, and inputs since version 11.
                let limit = |i: usize, key: &str, none: f32| match constant(i) {
                    Some(name) => match find_constant(graph, name)?.values[..] {
                        [value] => Ok(value),
                        _ => Err(at.attribute_error("limits of a shape", "one number for each")),
                    },
                    None => Ok(node.attributes.get(key).and_then(|key| key.float).unwrap_or(none)),
                };
                let least = limit(0, "min", f32::NEG_INFINITY)?;
                self.push_pointwise(Pointwise::Clip {
                    least,
                    most: limit(1, "max", f32::INFINITY)?,
                });
            }
            "Identity" => {}
            operator => {
                let Some(name) = constant(0) else {
                    return Err(at.attribute_error("one input", "one map and one constant"));
                };
                let constant = self.constant(at, &find_constant(graph, name)?)?;
                self.push_pointwise(match operator {
                    "Add" => Pointwise::Add(constant),
                    // x - c and x + (-c) are identical in floating point.
                    "Sub" => Pointwise::Add(constant.negated()),
                    "Mul" => Pointwise::Multiply(constant),
                    _ => Pointwise::Divide(constant),
                });
            }
        }
        self.current.clone_from(output);
        Ok(())
    }

    /// Returns the index of the input that is the previous node's output.
    fn find_data_input(&self, at: NodeContext, node: &Node) -> Result<usize, NetworkError> {
        // The operands of a sum or a product may come in either order.
        let places = if matches!(at.operator, "Add" | "Mul") { 2 } else { 1 };
        let found = node.inputs.iter().take(places).position(|name| *name == self.current);
        found.ok_or_else(|| NetworkError::NotAChain {
            node: at.node.to_owned(),
            operator: at.operator.to_owned(),
            takes: node.inputs.first().cloned().unwrap_or_default(),
            before: self.current.clone(),
        })
    }

    /// Appends a pointwise operation after the last convolution, or before the first.
    fn push_pointwise(&mut self, pointwise: Pointwise) {
        let Chain { before, stages } = &mut self.chain;
        stages.last_mut().map_or(before, |stage| &mut stage.pointwise).push(pointwise);
    }

    /// Converts a tensor to a constant: one number for all channels, or one for each.
    fn constant(&self, at: NodeContext, found: &Tensor) -> Result<PointwiseConstant, NetworkError> {
        let per_channel: Vec<usize> = vec![self.channels, 1, 1];
        // A leading batch axis of length 1 is ignored.
        let shape = found.shape.strip_prefix(&[1]).filter(|rest| rest.len() == 3);
        match found.values[..] {
            [value] if found.shape.len() <= 4 => Ok(PointwiseConstant::Scalar(value)),
            _ if shape.unwrap_or(&found.shape) == per_channel => {
                Ok(PointwiseConstant::Channels(found.values.clone()))
            }
            _ => {
                let accepted =
                    format!("one number, or {} x 1 x 1: one for each channel", self.channels);
                Err(at.attribute_error(format!("a constant of shape {:?}", found.shape), &accepted))
            }
        }
    }

    /// Appends a convolution.
    fn convolve(
        &mut self,
        graph: &Graph,
        at: NodeContext,
        node: &Node,
        others: &[&str],
    ) -> Result<(), NetworkError> {
        let Some(weights) = others.first() else {
            return Err(at.attribute_error("no weights", "a constant"));
        };
        let weights = find_constant(graph, weights)?;
        let &[outputs, per_group, rows, columns] = &weights.shape[..] else {
            let found = format!("weights of shape {:?}", weights.shape);
            return Err(at.attribute_error(found, "outputs x inputs x rows x columns"));
        };
        let bias = match others.get(1).filter(|name| !name.is_empty()) {
            None => vec![0.0; outputs],
            Some(name) => find_constant(graph, name)?.values,
        };
        if bias.len() != outputs {
            return Err(
                at.attribute_error(format!("{} offsets", bias.len()), "one for each output")
            );
        }
        let groups = node.attributes.get("group").and_then(|group| group.integer).unwrap_or(1);
        let groups = usize::try_from(groups).unwrap_or(0);
        let fits = groups.checked_mul(per_group) == Some(self.channels);
        if !fits || !outputs.is_multiple_of(groups) {
            let found = format!(
                "{outputs} x {per_group} channels in {groups} groups after {} channels",
                self.channels
            );
            return Err(
                at.attribute_error(found, "as many inputs as there are, groups of equal size")
            );
        }
        if outputs > MAX_CHANNELS {
            let found = format!("{outputs} channels");
            return Err(NetworkError::TooLarge { found, limit: MAX_CHANNELS });
        }
        check_window(at, node, [rows, columns])?;
        self.reach = [self.reach[0] + rows / 2, self.reach[1] + columns / 2];
        let reach_px = self.reach[0].max(self.reach[1]);
        if reach_px > MAX_REACH_PX {
            let found = format!("a reach of {reach_px} px to each side");
            return Err(NetworkError::TooLarge { found, limit: MAX_REACH_PX });
        }
        self.channels = outputs;
        let convolution =
            Convolution::new(&weights.values, &bias, [outputs, per_group, rows, columns], groups);
        self.chain.stages.push(ConvolutionStage { convolution, pointwise: Vec::new() });
        Ok(())
    }
}

/// Finds and reads a constant by name.
fn find_constant(graph: &Graph, name: &str) -> Result<Tensor, NetworkError> {
    let missing = || {
        let found = "there is none of this name".to_owned();
        NetworkError::Constant { name: name.to_owned(), found }
    };
    read_tensor(name, graph.constants.get(name).cloned().ok_or_else(missing)?)
}

/// Checks that a convolution keeps the size of the map, and that its window is centred on the pixel.
fn check_window(at: NodeContext, node: &Node, kernel: [usize; 2]) -> Result<(), NetworkError> {
    let given = |key: &str| node.attributes.get(key);
    let numbers = |key: &str| given(key).map_or(&[][..], |key: &Attribute| &key.integers[..]);
    let [rows, columns] = kernel;
    if rows % 2 == 0 || columns % 2 == 0 {
        return Err(at.attribute_error(format!("a kernel of {rows} x {columns}"), "an odd size"));
    }
    let shape = numbers("kernel_shape");
    if !shape.is_empty() && shape != [rows as i64, columns as i64] {
        return Err(at.attribute_error(format!("kernel_shape {shape:?}"), "that of its weights"));
    }
    for key in ["strides", "dilations"] {
        if numbers(key).iter().any(|number| *number != 1) {
            return Err(at.attribute_error(format!("{key} {:?}", numbers(key)), "1"));
        }
    }
    let half = [rows / 2, columns / 2, rows / 2, columns / 2].map(|px| px as i64);
    let auto = given("auto_pad").and_then(|key| key.text.clone()).unwrap_or_default();
    let pads = match &auto[..] {
        "" | "NOTSET" => numbers("pads"),
        "SAME_UPPER" | "SAME_LOWER" => &half,
        // Without padding; accepted below for 1 x 1 windows only.
        "VALID" => &[],
        other => return Err(at.attribute_error(format!("auto_pad {other}"), "SAME_UPPER or pads")),
    };
    if pads != half && !(pads.is_empty() && half == [0; 4]) {
        return Err(at.attribute_error(
            format!("pads {pads:?}"),
            &format!("{half:?}: maps keep their size"),
        ));
    }
    Ok(())
}

/// The operators listed in messages are those that are read.
#[cfg(test)]
#[test]
fn messages_list_all_accepted_operators() {
    for operator in ["Conv", "Relu", "Clip", "Sigmoid", "Identity", "Add", "Sub", "Mul", "Div"] {
        assert!(crate::error::ACCEPTED.contains(operator));
    }
}
