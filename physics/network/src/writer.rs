//! Writer of ONNX files, for tests and examples.

/// Node of a chain.
#[derive(Clone, Debug)]
pub struct ChainLayer {
    operator: &'static str,
    /// Integer attributes.
    integers: Vec<(&'static str, Vec<i64>)>,
    /// Constants with their shapes.
    constants: Vec<(Vec<usize>, Vec<f32>)>,
}

impl ChainLayer {
    /// Creates a convolution from weights (outputs x inputs of a group x rows x columns), padded by half of its window.
    ///
    /// ```
    /// use fabkit_network::Network;
    /// use fabkit_network::writer::{ChainLayer, write_chain};
    ///
    /// // Weights lie row by row; they are not flipped, so the last of three looks at the pixel on the right.
    /// let right = ChainLayer::convolution([1, 1, 1, 3], 1, &[0.0, 0.0, 1.0], &[0.0]);
    /// let network = Network::read(&write_chain(&[right]))?;
    /// assert_eq!(network.run(&[1.0, 2.0, 3.0], 3)?, [2.0, 3.0, 0.0]);
    /// # Ok::<(), fabkit_network::NetworkError>(())
    /// ```
    pub fn convolution(shape: [usize; 4], groups: usize, weights: &[f32], bias: &[f32]) -> Self {
        let [outputs, _, rows, columns] = shape;
        let half = [rows / 2, columns / 2, rows / 2, columns / 2].map(|px| px as i64);
        Self::operator("Conv")
            .with_attribute("pads", &half)
            .with_attribute("group", &[groups as i64])
            .with_constant(&shape, weights)
            .with_constant(&[outputs], bias)
    }

    /// Creates a node without constants.
    pub fn operator(operator: &'static str) -> Self {
        Self { operator, integers: Vec::new(), constants: Vec::new() }
    }

    /// Adds an attribute of integers: `group` is written as one number, other keys as a list.
    ///
    /// ```
    /// use fabkit_network::Network;
    /// use fabkit_network::writer::{ChainLayer, write_chain};
    ///
    /// // A stride of 2 would halve the image; maps that keep their size are read only.
    /// let halving = ChainLayer::convolution([1, 1, 1, 1], 1, &[1.0], &[0.0]).with_attribute("strides", &[2, 2]);
    /// assert!(Network::read(&write_chain(&[halving])).unwrap_err().to_string().contains("strides"));
    /// ```
    pub fn with_attribute(mut self, key: &'static str, numbers: &[i64]) -> Self {
        self.integers.push((key, numbers.to_vec()));
        self
    }

    /// Adds a constant input.
    ///
    /// ```
    /// use fabkit_network::Network;
    /// use fabkit_network::writer::{ChainLayer, write_chain};
    ///
    /// // Intensities of 0 to 255 as parts of 1.
    /// let part = ChainLayer::operator("Div").with_constant(&[1], &[255.0]);
    /// let same = ChainLayer::convolution([1, 1, 1, 1], 1, &[1.0], &[0.0]);
    /// let network = Network::read(&write_chain(&[part, same]))?;
    /// assert_eq!(network.run(&[0.0, 51.0, 255.0], 3)?, [0.0, 0.2, 1.0]);
    /// # Ok::<(), fabkit_network::NetworkError>(())
    /// ```
    pub fn with_constant(mut self, shape: &[usize], values: &[f32]) -> Self {
        self.constants.push((shape.to_vec(), values.to_vec()));
        self
    }
}

/// Appends an integer of variable length.
fn varint(mut value: u64, into: &mut Vec<u8>) {
    while value >= 0x80 {
        into.push(value as u8 | 0x80);
        value >>= 7;
    }
    into.push(value as u8);
}

/// Appends an integer field.
fn integer(number: u64, value: i64, into: &mut Vec<u8>) {
    varint(number << 3, into);
    varint(value as u64, into);
}

/// Appends a field of bytes.
fn bytes(number: u64, value: &[u8], into: &mut Vec<u8>) {
    varint(number << 3 | 2, into);
    varint(value.len() as u64, into);
    into.extend(value);
}

/// Writes an ONNX file with one layer after the other, from `x` to `y`; version 13 of the operators.
pub fn write_chain(layers: &[ChainLayer]) -> Vec<u8> {
    let mut graph = Vec::new();
    let (mut nodes, mut constants) = (Vec::new(), Vec::new());
    for (i, layer) in layers.iter().enumerate() {
        let name = |i: usize| match i {
            0 => "x".to_owned(),
            i if i == layers.len() => "y".to_owned(),
            i => format!("t{i}"),
        };
        let mut node = Vec::new();
        bytes(1, name(i).as_bytes(), &mut node);
        for (k, (shape, values)) in layer.constants.iter().enumerate() {
            let name = format!("c{i}.{k}");
            bytes(1, name.as_bytes(), &mut node);
            let mut tensor = Vec::new();
            shape.iter().for_each(|size| integer(1, *size as i64, &mut tensor));
            // TensorProto.data_type 1: FLOAT.
            integer(2, 1, &mut tensor);
            bytes(8, name.as_bytes(), &mut tensor);
            let raw: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
            bytes(9, &raw, &mut tensor);
            bytes(5, &tensor, &mut constants);
        }
        bytes(2, name(i + 1).as_bytes(), &mut node);
        bytes(3, format!("n{i}").as_bytes(), &mut node);
        bytes(4, layer.operator.as_bytes(), &mut node);
        for (key, numbers) in &layer.integers {
            let mut attribute = Vec::new();
            bytes(1, key.as_bytes(), &mut attribute);
            if let ([one], true) = (&numbers[..], *key == "group") {
                integer(3, *one, &mut attribute);
                // AttributeProto.type 2: INT.
                integer(20, 2, &mut attribute);
            } else {
                numbers.iter().for_each(|number| integer(8, *number, &mut attribute));
                // AttributeProto.type 7: INTS.
                integer(20, 7, &mut attribute);
            }
            bytes(5, &attribute, &mut node);
        }
        bytes(1, &node, &mut nodes);
    }
    graph.extend(nodes);
    bytes(2, b"chain", &mut graph);
    graph.extend(constants);
    for (number, name, channels) in [(11, "x", 1), (12, "y", 1)] {
        let mut shape = Vec::new();
        for size in [Some(1), Some(channels), None, None] {
            let mut axis = Vec::new();
            match size {
                Some(size) => integer(1, size, &mut axis),
                None => bytes(2, b"n", &mut axis),
            }
            bytes(1, &axis, &mut shape);
        }
        let (mut tensor, mut kind, mut value) = (Vec::new(), Vec::new(), Vec::new());
        integer(1, 1, &mut tensor);
        bytes(2, &shape, &mut tensor);
        bytes(1, &tensor, &mut kind);
        bytes(1, name.as_bytes(), &mut value);
        bytes(2, &kind, &mut value);
        bytes(number, &value, &mut graph);
    }
    let (mut model, mut version) = (Vec::new(), Vec::new());
    // Version 8 of the file format.
    integer(1, 8, &mut model);
    bytes(7, &graph, &mut model);
    integer(2, 13, &mut version);
    bytes(8, &version, &mut model);
    model
}
