//! The picture that file managers and slicers show of a file: what its triangles look like from the front, the
//! right and above. Drawn from the triangles, because they are there, and in some milliseconds.

use fabkit_geometry::{Point3, Vector3};

use super::Object;
use crate::ExportError;

/// Width and height, px.
const SIDE_PX: usize = 256;
/// Samples of a pixel along each side.
const FINER: usize = 2;
const SIDE: usize = SIDE_PX * FINER;
/// Free on each side, samples.
const MARGIN: f64 = 12.0;

const BACKGROUND: [f64; 3] = [255.0; 3];

/// Light in the shade, as a fraction.
const AMBIENT: f64 = 0.35;

/// Right, up and towards the viewer, who stands 60 degrees off the x axis and 30 above the bed.
fn axes() -> [Vector3<f64>; 3] {
    let (azimuth, elevation) = ((-60.0f64).to_radians(), 30.0f64.to_radians());
    let towards = Vector3::new(
        elevation.cos() * azimuth.cos(),
        elevation.cos() * azimuth.sin(),
        elevation.sin(),
    );
    let right = Vector3::z().cross(&towards).normalize();
    [right, towards.cross(&right), towards]
}

/// A PNG of all objects where they lie.
///
/// # Errors
/// [`ExportError`] if the encoder refuses.
pub(super) fn png_of(objects: &[Object]) -> Result<Vec<u8>, ExportError> {
    let [right, up, towards] = axes();
    let seen = |[x, y, z]: [f32; 3]| {
        let place = Vector3::new(f64::from(x), f64::from(y), f64::from(z));
        Point3::new(place.dot(&right), place.dot(&up), place.dot(&towards))
    };
    let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for vertex in objects.iter().flat_map(|object| object.mesh.vertices()) {
        let at = seen(*vertex);
        for axis in 0..2 {
            min[axis] = min[axis].min(at[axis]);
            max[axis] = max[axis].max(at[axis]);
        }
    }
    let size = (max[0] - min[0]).max(max[1] - min[1]).max(f64::MIN_POSITIVE);
    let scale = (SIDE as f64 - 2.0 * MARGIN) / size;
    let middle = [0, 1].map(|axis| (min[axis] + max[axis]) / 2.0);
    // From the viewer's millimetres to samples, y downwards.
    let sample = |at: Point3<f64>| {
        let half = SIDE as f64 / 2.0;
        Point3::new(
            half + (at.x - middle[0]) * scale,
            half - (at.y - middle[1]) * scale,
            at.z * scale,
        )
    };
    let mut canvas = Canvas::new();
    for object in objects {
        let corners: Vec<Point3<f64>> =
            object.mesh.vertices().iter().map(|vertex| sample(seen(*vertex))).collect();
        for triangle in object.mesh.triangles() {
            canvas.triangle(triangle.map(|i| corners[i as usize]), object.color);
        }
    }
    crate::png(SIDE_PX as u32, SIDE_PX as u32, &canvas.pixels())
}

/// Samples: how near what is seen is, and its color.
struct Canvas {
    depth: Vec<f64>,
    color: Vec<[f64; 3]>,
}

impl Canvas {
    fn new() -> Self {
        let count = SIDE * SIDE;
        Self { depth: vec![f64::NEG_INFINITY; count], color: vec![BACKGROUND; count] }
    }

    fn triangle(&mut self, [a, b, c]: [Point3<f64>; 3], color: [u8; 3]) {
        // In samples, y downwards: what faces the viewer turns clockwise.
        let normal = (c - a).cross(&(b - a));
        if normal.z <= 0.0 {
            return;
        }
        let Some(unit) = normal.try_normalize(1e-12) else { return };
        // Light from the upper left of the viewer.
        let light = Vector3::new(-0.35, -0.55, 0.75).normalize();
        let shade = AMBIENT + (1.0 - AMBIENT) * unit.dot(&light).max(0.0);
        // Black would hide all edges.
        let color = color.map(|value| (45.0 + f64::from(value) * 210.0 / 255.0) * shade);
        let range = |axis: usize| {
            let values = [a[axis], b[axis], c[axis]];
            let low = values.into_iter().fold(f64::INFINITY, f64::min);
            let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
            (low - 0.5).ceil().max(0.0) as usize
                ..=(high - 0.5).floor().min(SIDE as f64 - 1.0).max(0.0) as usize
        };
        let rows = range(1);
        for y in rows {
            for x in range(0) {
                let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
                let side = |p: Point3<f64>, q: Point3<f64>| {
                    (q.y - p.y) * (px - p.x) - (q.x - p.x) * (py - p.y)
                };
                if side(a, b) < 0.0 || side(b, c) < 0.0 || side(c, a) < 0.0 {
                    continue;
                }
                // Depth on the triangle's plane.
                let z = a.z - (normal.x * (px - a.x) + normal.y * (py - a.y)) / normal.z;
                let at = y * SIDE + x;
                if z > self.depth[at] {
                    self.depth[at] = z;
                    self.color[at] = color;
                }
            }
        }
    }

    /// RGB, averaged over the samples of each pixel.
    fn pixels(&self) -> Vec<u8> {
        let mut pixels = Vec::with_capacity(3 * SIDE_PX * SIDE_PX);
        for y in 0..SIDE_PX {
            for x in 0..SIDE_PX {
                for channel in 0..3 {
                    let samples = (0..FINER * FINER).map(|i| {
                        let (row, column) = (y * FINER + i / FINER, x * FINER + i % FINER);
                        self.color[row * SIDE + column][channel]
                    });
                    let mean = samples.sum::<f64>() / (FINER * FINER) as f64;
                    pixels.push(mean.round() as u8);
                }
            }
        }
        pixels
    }
}
