//! Binary chunk of a GLB file, and the lists of buffer views and accessors into it.

use fabkit_mesh::ShadedMesh;

use super::json::{
    Accessor, Animation, Attributes, Buffer, Channel, Document, Primitive, Sampler, Target, View,
};

const F32: u32 = 5126;
const U16: u32 = 5123;
const U32: u32 = 5125;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// Largest index of 16 bits: the value above restarts primitives.
const MOST_SHORT: usize = u16::MAX as usize - 1;

/// Bytes of the chunk, and the lists that describe them.
#[derive(Debug, Default)]
pub(super) struct BinaryChunk {
    bytes: Vec<u8>,
    views: Vec<View>,
    accessors: Vec<Accessor>,
}

impl BinaryChunk {
    /// Adds a mesh. The caller sets the primitive's material.
    pub fn mesh(&mut self, mesh: &ShadedMesh) -> Primitive {
        let position = self.vectors(&mesh.positions, Some(VERTICES), true);
        let normal = self.vectors(&mesh.normals, Some(VERTICES), false);
        let indices = self.indices(mesh);
        Primitive { attributes: Attributes { position, normal }, indices, material: 0 }
    }

    /// Adds an animation in which nodes move straight from one position to another.
    pub fn animation(
        &mut self,
        name: &'static str,
        lasting_s: f32,
        moves: &[(usize, [[f64; 3]; 2])],
    ) -> Animation {
        let from = self.bytes.len();
        self.floats([0.0, lasting_s]);
        self.floats(moves.iter().flat_map(|(_, ends)| ends.as_flattened()).map(|&x| x as f32));
        let view = self.view(from, None);
        let [min, max] = [0.0, f64::from(lasting_s)].map(|end| Some(vec![end]));
        let times = Accessor { count: 2, kind: "SCALAR", min, max, ..floats(view, 0, 2) };
        let input = self.accessor(times);
        let (mut channels, mut samplers) = (Vec::new(), Vec::new());
        for (number, (node, _)) in moves.iter().enumerate() {
            // Two times of four bytes, then two positions of twelve bytes per node.
            let output = self.accessor(floats(view, 8 + 24 * number, 2));
            channels.push(Channel {
                sampler: number,
                target: Target { node: *node, path: "translation" },
            });
            samplers.push(Sampler { input, output });
        }
        Animation { name, channels, samplers }
    }

    /// Moves the lists into the document and returns the bytes.
    pub fn finish(self, document: &mut Document) -> Vec<u8> {
        document.accessors = self.accessors;
        document.buffer_views = self.views;
        document.buffers = vec![Buffer { byte_length: self.bytes.len() }];
        self.bytes
    }

    /// Adds vectors; `bounded` adds their bounds, which the standard requires for positions.
    fn vectors(&mut self, vectors: &[[f32; 3]], target: Option<u32>, bounded: bool) -> usize {
        let from = self.bytes.len();
        self.floats(vectors.as_flattened().iter().copied());
        let view = self.view(from, target);
        let ends = |pick: fn(f32, f32) -> f32| {
            let end = |axis: usize| vectors.iter().map(|v| v[axis]).reduce(pick).unwrap_or(0.0);
            // Exactly the 32-bit numbers, which validators compare with the data.
            bounded.then(|| [0, 1, 2].map(|axis| f64::from(end(axis))).to_vec())
        };
        let accessor = floats(view, 0, vectors.len());
        self.accessor(Accessor { min: ends(f32::min), max: ends(f32::max), ..accessor })
    }

    /// Adds triangle indices, with 16 bits where they suffice.
    fn indices(&mut self, mesh: &ShadedMesh) -> usize {
        let from = self.bytes.len();
        let indices = mesh.triangles.as_flattened();
        let is_short = mesh.positions.len() <= MOST_SHORT + 1;
        if is_short {
            self.bytes.extend(indices.iter().flat_map(|&i| (i as u16).to_le_bytes()));
        } else {
            self.bytes.extend(indices.iter().flat_map(|i| i.to_le_bytes()));
        }
        let view = self.view(from, Some(INDICES));
        self.accessor(Accessor {
            component_type: if is_short { U16 } else { U32 },
            kind: "SCALAR",
            ..floats(view, 0, indices.len())
        })
    }

    fn floats(&mut self, values: impl IntoIterator<Item = f32>) {
        // No negative zero: equal numbers are equal bytes.
        self.bytes.extend(values.into_iter().flat_map(|value| (value + 0.0).to_le_bytes()));
    }

    /// Adds a view of all bytes from an offset on, and pads to a multiple of four.
    fn view(&mut self, byte_offset: usize, target: Option<u32>) -> usize {
        let byte_length = self.bytes.len() - byte_offset;
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(View { buffer: 0, byte_offset, byte_length, target });
        self.views.len() - 1
    }

    fn accessor(&mut self, accessor: Accessor) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}

/// Creates an accessor of vectors with three 32-bit components.
fn floats(buffer_view: usize, byte_offset: usize, count: usize) -> Accessor {
    let (component_type, kind) = (F32, "VEC3");
    Accessor { buffer_view, byte_offset, component_type, count, kind, min: None, max: None }
}
