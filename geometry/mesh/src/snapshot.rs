//! Thumbnails of meshes for embedding in files, seen from the front, the right and above. They are drawn from the
//! triangles, which exist anyway, within some milliseconds.

use fabkit_geometry::{Point3, Vector3};

use crate::PrintMesh;

/// Samples of a pixel along each side (supersampling).
const FINER: usize = 2;

/// Margin on each side, as a fraction of the image.
const MARGIN: f64 = 0.024;

const BACKGROUND: [u8; 3] = [255; 3];

/// Intensity in the shade, as a fraction.
const AMBIENT: f64 = 0.35;

/// Intensity of a black body in full light, 0 to 255: at 0 all its edges would be invisible.
const DARKEST: f64 = 45.0;

/// Renders a square image of meshes in their frame, each in its sRGB colour, on white. Returns `side_px` rows of
/// `side_px` pixels of red, green and blue, from the top.
///
/// ```
/// use fabkit_geometry::Solid;
/// let mesh = fabkit_mesh::mesh(&Solid::sphere(5.0), 0.1)?.to_print()?;
/// let rgb = fabkit_mesh::snapshot(&[(&mesh, [255, 0, 0])], 32);
/// assert_eq!(rgb.len(), 3 * 32 * 32);
/// let middle = &rgb[3 * (16 * 32 + 16)..][..3];
/// assert!(middle[0] > 2 * middle[1]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn snapshot(meshes: &[(&PrintMesh, [u8; 3])], side_px: usize) -> Vec<u8> {
    let [right, up, towards] = axes();
    let seen = |[x, y, z]: [f32; 3]| {
        let place = Vector3::new(f64::from(x), f64::from(y), f64::from(z));
        Point3::new(place.dot(&right), place.dot(&up), place.dot(&towards))
    };
    let corners: Vec<Vec<Point3<f64>>> = meshes
        .iter()
        .map(|(mesh, _)| mesh.vertices().iter().map(|vertex| seen(*vertex)).collect())
        .collect();
    let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for at in corners.iter().flatten() {
        for axis in 0..2 {
            min[axis] = min[axis].min(at[axis]);
            max[axis] = max[axis].max(at[axis]);
        }
    }
    let mut canvas = Canvas::new(side_px * FINER);
    let side = canvas.side as f64;
    let size = (max[0] - min[0]).max(max[1] - min[1]).max(f64::MIN_POSITIVE);
    let scale = side * (1.0 - 2.0 * MARGIN) / size;
    let middle = [0, 1].map(|axis| f64::midpoint(min[axis], max[axis]));
    // Conversion from the viewer's millimetres to samples, y downwards.
    let sample = |at: Point3<f64>| {
        let [x, y] = [(at.x - middle[0]) * scale, (middle[1] - at.y) * scale];
        Point3::new(0.5 * side + x, 0.5 * side + y, at.z * scale)
    };
    for ((mesh, color), corners) in meshes.iter().zip(corners) {
        let corners: Vec<Point3<f64>> = corners.into_iter().map(sample).collect();
        for triangle in mesh.triangles() {
            canvas.triangle(triangle.map(|i| corners[i as usize]), *color);
        }
    }
    canvas.pixels()
}

/// Returns the directions right, up and towards the viewer, who looks from 60 degrees off the x axis and 30 degrees
/// above the bed.
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

/// Buffer of samples with depth (larger is nearer) and colour.
struct Canvas {
    side: usize,
    depth: Vec<f64>,
    color: Vec<[u8; 3]>,
}

impl Canvas {
    fn new(side: usize) -> Self {
        let count = side * side;
        Self { side, depth: vec![f64::NEG_INFINITY; count], color: vec![BACKGROUND; count] }
    }

    fn triangle(&mut self, [a, b, c]: [Point3<f64>; 3], color: [u8; 3]) {
        // In samples, with y downwards, triangles that face the viewer turn clockwise.
        let normal = (c - a).cross(&(b - a));
        if normal.z <= 0.0 {
            return;
        }
        let Some(unit) = normal.try_normalize(1e-12) else { return };
        // Light from the upper left of the viewer.
        let light = Vector3::new(-0.35, -0.55, 0.75).normalize();
        let shade = AMBIENT + (1.0 - AMBIENT) * unit.dot(&light).max(0.0);
        // Lambertian shading with ambient light.
        let lit = |value: u8| (DARKEST + f64::from(value) * (255.0 - DARKEST) / 255.0) * shade;
        let color = color.map(|value| lit(value).round() as u8);
        let range = |axis: usize| {
            let values = [a[axis], b[axis], c[axis]];
            let low = values.into_iter().fold(f64::INFINITY, f64::min);
            let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
            // The end is one past the last sample centre within the range.
            (low - 0.5).ceil().max(0.0) as usize
                ..((high + 0.5).floor().max(0.0) as usize).min(self.side)
        };
        let columns = range(0);
        for y in range(1) {
            for x in columns.clone() {
                let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
                let side = |p: Point3<f64>, q: Point3<f64>| {
                    (q.y - p.y) * (px - p.x) - (q.x - p.x) * (py - p.y)
                };
                if side(a, b) < 0.0 || side(b, c) < 0.0 || side(c, a) < 0.0 {
                    continue;
                }
                // Depth of the triangle's plane at the sample.
                let z = a.z - (normal.x * (px - a.x) + normal.y * (py - a.y)) / normal.z;
                let at = y * self.side + x;
                if z > self.depth[at] {
                    self.depth[at] = z;
                    self.color[at] = color;
                }
            }
        }
    }

    /// Returns RGB pixels, averaged over the samples of each.
    fn pixels(&self) -> Vec<u8> {
        const COUNT: usize = FINER * FINER;
        let side_px = self.side / FINER;
        let mut pixels = Vec::with_capacity(3 * side_px * side_px);
        for y in 0..side_px {
            for x in 0..side_px {
                let mut sums = [COUNT / 2; 3];
                for i in 0..COUNT {
                    let at = (y * FINER + i / FINER) * self.side + x * FINER + i % FINER;
                    for (sum, value) in sums.iter_mut().zip(self.color[at]) {
                        *sum += usize::from(value);
                    }
                }
                pixels.extend(sums.map(|sum| (sum / COUNT) as u8));
            }
        }
        pixels
    }
}
