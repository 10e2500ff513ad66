//! Reader of the used part of ONNX files: the graph, its nodes, and constants.
//!
//! Field numbers are those of `onnx.proto` (<https://github.com/onnx/onnx/blob/main/onnx/onnx.proto>), which are never
//! reused. Other fields are skipped: descriptions, types of intermediate values, versions of operators.

use std::collections::BTreeMap;

use crate::NetworkError;
use crate::wire::{FieldValue, Fields, floats, integers, message, text};

/// `TensorProto.DataType.FLOAT`.
const FLOAT: u64 = 1;
/// `TensorProto.DataLocation.EXTERNAL`.
const EXTERNAL: u64 = 1;

/// Constant tensor of 32-bit numbers, the last axis fastest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tensor {
    pub shape: Vec<usize>,
    pub values: Vec<f32>,
}

/// Attribute of a node; only the field of its kind is set.
#[derive(Clone, Debug, Default)]
pub struct Attribute<'a> {
    pub float: Option<f32>,
    pub integer: Option<i64>,
    pub text: Option<String>,
    pub integers: Vec<i64>,
    /// Constant that has not been decoded yet.
    pub tensor: Option<Fields<'a>>,
}

/// Node of the graph: one operation.
#[derive(Clone, Debug, Default)]
pub struct Node<'a> {
    pub name: String,
    pub operator: String,
    pub domain: String,
    pub inputs: Vec<String>,
    pub outputs: Vec<String>,
    pub attributes: BTreeMap<String, Attribute<'a>>,
}

/// Graph: nodes in an order of evaluation, and their constants.
#[derive(Clone, Debug, Default)]
pub struct Graph<'a> {
    pub nodes: Vec<Node<'a>>,
    /// Constants that have not been decoded yet, by name.
    pub constants: BTreeMap<String, Fields<'a>>,
    pub inputs: Vec<String>,
    pub outputs: Vec<String>,
}

/// Reads the graph of a model.
///
/// # Errors
/// If the bytes are not an ONNX model.
pub fn read_graph(bytes: &[u8]) -> Result<Graph<'_>, NetworkError> {
    let (mut version, mut found) = (None, None);
    for field in Fields::new(bytes) {
        // ModelProto: 1 ir_version, 7 graph.
        match field? {
            (1, FieldValue::Varint(number)) => version = Some(number),
            (7, value) => found = Some(message(value)?),
            _ => {}
        }
    }
    // Every model has a format version and a graph.
    let (Some(_), Some(fields)) = (version, found) else { return Err(NetworkError::NotOnnx) };
    let mut graph = Graph::default();
    for field in fields {
        // GraphProto: 1 node, 5 initializer, 11 input, 12 output.
        match field? {
            (1, value) => graph.nodes.push(read_node(message(value)?)?),
            (5, value) => {
                let constant = message(value)?;
                graph.constants.insert(text_field(constant.clone(), 8)?, constant);
            }
            (11, value) => graph.inputs.push(text_field(message(value)?, 1)?),
            (12, value) => graph.outputs.push(text_field(message(value)?, 1)?),
            _ => {}
        }
    }
    // Older files list their constants among the inputs.
    let Graph { inputs, constants, .. } = &mut graph;
    inputs.retain(|name| !constants.contains_key(name));
    Ok(graph)
}

/// Returns the text in field `number`; empty if there is none.
fn text_field(fields: Fields<'_>, number: u64) -> Result<String, NetworkError> {
    let mut name = String::new();
    for field in fields {
        let (field, value) = field?;
        if field == number {
            name = text(value)?;
        }
    }
    Ok(name)
}

/// Reads a node.
fn read_node(fields: Fields<'_>) -> Result<Node<'_>, NetworkError> {
    let mut node = Node::default();
    for field in fields {
        // NodeProto: 1 input, 2 output, 3 name, 4 op_type, 5 attribute, 7 domain.
        match field? {
            (1, value) => node.inputs.push(text(value)?),
            (2, value) => node.outputs.push(text(value)?),
            (3, value) => node.name = text(value)?,
            (4, value) => node.operator = text(value)?,
            (5, value) => {
                let (name, attribute) = read_attribute(message(value)?)?;
                node.attributes.insert(name, attribute);
            }
            (7, value) => node.domain = text(value)?,
            _ => {}
        }
    }
    Ok(node)
}

/// Reads an attribute with its name.
fn read_attribute(fields: Fields<'_>) -> Result<(String, Attribute<'_>), NetworkError> {
    let (mut name, mut attribute) = (String::new(), Attribute::default());
    for field in fields {
        // AttributeProto: 1 name, 2 f, 3 i, 4 s, 5 t, 8 ints.
        match field? {
            (1, value) => name = text(value)?,
            (2, FieldValue::Fixed32(bits)) => attribute.float = Some(f32::from_bits(bits)),
            (3, FieldValue::Varint(number)) => attribute.integer = Some(number as i64),
            (4, value) => attribute.text = Some(text(value)?),
            (5, value) => attribute.tensor = Some(message(value)?),
            (8, value) => integers(value, &mut attribute.integers)?,
            _ => {}
        }
    }
    Ok((name, attribute))
}

/// Decodes a constant's shape and numbers.
///
/// # Errors
/// If the numbers have another type, are in another file, do not match the shape in number, or are not finite.
pub fn read_tensor(name: &str, fields: Fields<'_>) -> Result<Tensor, NetworkError> {
    let wrong = |found: &str| {
        let (name, found) = (name.to_owned(), found.to_owned());
        NetworkError::Constant { name, found }
    };
    let (mut shape, mut values, mut raw) = (Vec::new(), Vec::new(), None);
    for field in fields {
        // TensorProto: 1 dims, 2 data_type, 4 float_data, 9 raw_data, 14 data_location.
        match field? {
            (1, value) => integers(value, &mut shape)?,
            (2, FieldValue::Varint(kind)) if kind != FLOAT => {
                return Err(wrong(&format!("its numbers are of type {kind}")));
            }
            (4, value) => floats(value, &mut values)?,
            (9, FieldValue::Bytes(bytes)) => raw = Some(FieldValue::Bytes(bytes)),
            (14, FieldValue::Varint(EXTERNAL)) => {
                return Err(wrong("its numbers are in another file"));
            }
            _ => {}
        }
    }
    if let Some(raw) = raw {
        floats(raw, &mut values)?;
    }
    let sizes: Option<Vec<usize>> =
        shape.iter().map(|size| usize::try_from(*size).ok().filter(|size| *size > 0)).collect();
    let product = |sizes: &Vec<usize>| {
        sizes.iter().try_fold(1usize, |product, size| product.checked_mul(*size))
    };
    let Some((shape, count)) = sizes
        .and_then(|sizes| Some((product(&sizes)?, sizes)))
        .map(|(count, sizes)| (sizes, count))
    else {
        return Err(wrong("its shape has an axis without numbers"));
    };
    if count != values.len() {
        return Err(wrong(&format!("{} numbers for a shape of {count}", values.len())));
    }
    if values.iter().any(|value| !value.is_finite()) {
        return Err(wrong("a number is not finite"));
    }
    Ok(Tensor { shape, values })
}
