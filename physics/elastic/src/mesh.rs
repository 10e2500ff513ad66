//! Structured mesh of nine-node quadrilaterals between the exact interfaces.

use fabkit_geometry::Point3;

use crate::element::{Shape, quadratic};
use crate::meridian::LayeredBody;
use crate::mesh_density::MeshDensity;
use crate::{ElasticError, ElasticMaterial};

/// Elements and nodes of a meridian section.
///
/// Nodes lie in columns along s and in rows from the touched surface inwards; a node's index is `column * rows + row`.
/// Even columns and rows hold the corners of elements.
#[derive(Clone, Debug)]
pub(crate) struct Mesh {
    pub columns: usize,
    pub rows: usize,
    /// Radius and height of each node, mm.
    pub nodes: Vec<[f64; 2]>,
    /// True for nodes that cannot move.
    pub is_fixed: Vec<bool>,
    /// s of each column.
    pub s: Vec<f64>,
    /// Layer of each row of elements.
    pub layer_by_row: Vec<usize>,
    /// Row of each interface.
    pub interface_rows: Vec<usize>,
    /// Material of each layer.
    pub materials: Vec<ElasticMaterial>,
    /// Outward normal and tangent along s at each node of the touched surface, as radial and axial parts.
    pub frames: Vec<Frame>,
}

/// Normal and tangent at a node of the touched surface, in its meridian plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    /// Unit normal out of the body: radial and axial part.
    pub normal: [f64; 2],
    /// Unit tangent along s: radial and axial part.
    pub tangent: [f64; 2],
}

impl Mesh {
    /// Meshes a body.
    ///
    /// # Errors
    /// Whatever [`LayeredBody::check`] and [`MeshDensity::check`] reject, and layers that fold over.
    pub fn new(body: &LayeredBody, division: &MeshDensity) -> Result<Self, ElasticError> {
        body.check()?;
        division.check()?;
        let along = insert_midpoints(&division.boundaries_along(body)?);
        let through: Vec<Vec<f64>> =
            division.boundaries_through(body)?.iter().map(|ends| insert_midpoints(ends)).collect();
        let mut layer_of = Vec::new();
        let mut interface_rows = vec![0];
        for (layer, fractions) in through.iter().enumerate() {
            layer_of.extend(std::iter::repeat_n(layer, fractions.len() / 2));
            interface_rows.push(interface_rows[layer] + fractions.len() - 1);
        }
        let rows = interface_rows[body.layers.len()] + 1;
        let (mut nodes, mut is_fixed) = (Vec::new(), Vec::new());
        for &s in &along {
            // `Division::along` ends at exactly 1.
            let is_held_rim = s == 1.0 && body.is_rim_bonded;
            for (layer, fractions) in through.iter().enumerate() {
                let (outer, inner) = (body.place(layer, s)?, body.place(layer + 1, s)?);
                // Neighbouring layers share the row of their interface; only the first layer adds its outer row.
                for &fraction in &fractions[usize::from(layer > 0)..] {
                    let between = |i: usize| outer[i] + fraction * (inner[i] - outer[i]);
                    nodes.push([between(0), between(1)]);
                    is_fixed.push(is_held_rim);
                }
            }
            let innermost = is_fixed.len() - 1;
            is_fixed[innermost] |= body.inner.is_bonded_at(s);
        }
        let mut mesh = Self {
            columns: along.len(),
            rows,
            nodes,
            is_fixed,
            s: along,
            layer_by_row: layer_of,
            interface_rows,
            materials: body.layers.iter().map(|layer| layer.material).collect(),
            frames: Vec::new(),
        };
        // Frames come last: in folded elements their tangents may have no length.
        mesh.check_elements(body)?;
        mesh.frames = mesh.surface_frames();
        Ok(mesh)
    }

    /// Iterates over the elements as pairs of column and row.
    pub fn elements(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        let through = self.layer_by_row.len();
        (0..self.columns / 2).flat_map(move |column| (0..through).map(move |row| [column, row]))
    }

    /// Returns the nine nodes of an element, column by column, each from the touched surface inwards.
    pub fn element_nodes(&self, [column, row]: [usize; 2]) -> [usize; 9] {
        std::array::from_fn(|i| (2 * column + i / 3) * self.rows + 2 * row + i % 3)
    }

    /// Returns the positions of an element's nodes (radius and height), mm.
    pub fn element_places(&self, element: [usize; 2]) -> [[f64; 2]; 9] {
        self.element_nodes(element).map(|node| self.nodes[node])
    }

    /// Number of interfaces that can move. The innermost one does not count if it is bonded everywhere.
    pub fn moving_interfaces(&self) -> usize {
        let last = self.interface_rows.len() - 1;
        let moves =
            (0..self.columns).any(|column| !self.is_fixed[self.interface_node(last, column)]);
        if moves { last + 1 } else { last }
    }

    /// Returns the node of an interface in a column.
    pub fn interface_node(&self, interface: usize, column: usize) -> usize {
        column * self.rows + self.interface_rows[interface]
    }

    /// Returns the first of the three columns of the element around s, and their interpolation weights at s.
    pub fn interpolation(&self, s: f64) -> (usize, [f64; 3]) {
        let s = s.clamp(0.0, 1.0);
        let ends = (0..self.columns / 2).map(|element| self.s[2 * element + 2]);
        let element = ends.take_while(|end| *end < s).count().min(self.columns / 2 - 1);
        let [begin, end] = [self.s[2 * element], self.s[2 * element + 2]];
        (2 * element, quadratic(2.0 * (s - begin) / (end - begin) - 1.0))
    }

    /// Returns the point of an interface at s and azimuth as the elements interpolate it, mm.
    pub fn interface_place(&self, interface: usize, s: f64, azimuth: f64) -> Point3<f64> {
        let (column, values) = self.interpolation(s);
        let mut place = [0.0; 2];
        for (i, value) in values.iter().enumerate() {
            let [r, z] = self.nodes[self.interface_node(interface, column + i)];
            place = [place[0] + value * r, place[1] + value * z];
        }
        Point3::new(place[0] * azimuth.cos(), place[0] * azimuth.sin(), place[1])
    }

    /// Returns the point of the touched surface at s and azimuth, mm.
    pub fn surface_place(&self, s: f64, azimuth: f64) -> Point3<f64> {
        self.interface_place(0, s, azimuth)
    }

    /// Checks that every element has a positive area.
    fn check_elements(&self, body: &LayeredBody) -> Result<(), ElasticError> {
        let shape = Shape::new();
        for element in self.elements() {
            let places = self.element_places(element);
            if let Some([radius_mm, height_mm]) = shape.find_fold(&places) {
                let layer = body.layers[self.layer_by_row[element[1]]].name.clone();
                return Err(ElasticError::Folded { layer, radius_mm, height_mm });
            }
        }
        Ok(())
    }

    /// Computes normal and tangent at the nodes of the touched surface. Where two elements meet, both tangents are
    /// averaged.
    fn surface_frames(&self) -> Vec<Frame> {
        let place = |column: usize| self.nodes[column * self.rows];
        let mut tangents = vec![[0.0; 2]; self.columns];
        for element in 0..self.columns / 2 {
            let ends: [[f64; 2]; 3] = std::array::from_fn(|i| place(2 * element + i));
            // Derivatives of the three quadratic shape functions at their own nodes.
            for (i, by_node) in
                [[-1.5, 2.0, -0.5], [-0.5, 0.0, 0.5], [0.5, -2.0, 1.5]].iter().enumerate()
            {
                let d: [f64; 2] =
                    std::array::from_fn(|k| (0..3).map(|j| by_node[j] * ends[j][k]).sum());
                let length = d[0].hypot(d[1]);
                tangents[2 * element + i][0] += d[0] / length;
                tangents[2 * element + i][1] += d[1] / length;
            }
        }
        // A smooth surface is horizontal on the axis.
        tangents[0] = [1.0, 0.0];
        let unit = |[r, z]: [f64; 2]| {
            let length = r.hypot(z);
            let tangent = [r / length, z / length];
            Frame { normal: [-tangent[1], tangent[0]], tangent }
        };
        tangents.into_iter().map(unit).collect()
    }
}

/// Inserts the midpoint between each pair of neighbouring values.
fn insert_midpoints(ends: &[f64]) -> Vec<f64> {
    let mut all = Vec::with_capacity(2 * ends.len() - 1);
    for pair in ends.windows(2) {
        all.extend([pair[0], 0.5 * (pair[0] + pair[1])]);
    }
    all.extend(ends.last());
    all
}
