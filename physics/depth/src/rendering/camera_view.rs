//! Camera views: each pixel shows the body that its ray, refracted or not, meets.

use fabkit_geometry::{Pose, Ray, Vector3};
use rayon::prelude::*;

use super::framing::Framing;
use super::shade::{Linear, Shader, add, linear, srgb};
use super::surface::VisibleSurface;
use super::{Actor, RenderError, RenderedImage, View};
use crate::{Scene, SceneScratch};

/// Number of rays along each side of a pixel in which more than one face is seen.
const SUBSAMPLES: u32 = 4;

/// Fraction of a pixel's light that a line absorbs at the border of two bodies.
const EDGE_INK: f32 = 0.45;

/// Range from which hits count, mm: a body may touch the face at which the last segment of a path begins.
const START_MM: f64 = -1e-6;

/// Content of a position in a camera's image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PixelContent {
    /// First body that this ray meets: the last straight segment of the path of light, scene frame.
    Along(Ray),
    /// Unshaded colour, sRGB.
    Plain([u8; 3]),
}

/// Face that a ray met: body, primitive and face of that; `None` for plain colours.
type Face = Option<(u32, u32, u32)>;

/// Renders a camera's view of opaque bodies. `look` returns the content of a position in the image, px, where centres of
/// pixels have whole coordinates, as cameras count them; it receives a value that `start` creates for each thread.
///
/// Runs on rayon's current thread pool; the bytes do not depend on its size.
///
/// # Errors
/// An image without pixels, or a too large one.
///
/// ```
/// use fabkit_depth::{Actor, PixelContent, render_camera_view};
/// use fabkit_geometry::{CompiledSolid, Point3, Pose, Ray, Solid, Vector3};
///
/// // A pinhole of 45 degrees at the origin looks along +z at a ball; its upper two rows are left black.
/// let ball = CompiledSolid::new(&Solid::sphere(3.0))?;
/// let actors = [Actor::new(ball, [200, 0, 0]).placed(Pose::translation(0.0, 0.0, 10.0))];
/// let look = |_: &mut (), [x_px, y_px]: [f64; 2]| {
///     let direction = Vector3::new((x_px - 15.5) / 32.0, (y_px - 15.5) / 32.0, 1.0).normalize();
///     let ray = Ray { origin: Point3::origin(), direction };
///     if y_px < 2.0 { PixelContent::Plain([0; 3]) } else { PixelContent::Along(ray) }
/// };
/// let image = render_camera_view(&actors, &Pose::identity(), [32, 32], || (), look, &|_, _| {})?;
/// let [red, green, _] = image.pixel(16, 16);
/// assert!(red > green && image.pixel(16, 0) == [0; 3]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn render_camera_view<T>(
    actors: &[Actor],
    sensor_from_camera: &Pose,
    [width_px, height_px]: [u32; 2],
    start: impl Fn() -> T + Sync,
    look: impl Fn(&mut T, [f64; 2]) -> PixelContent + Sync,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<RenderedImage, RenderError> {
    let mut image = RenderedImage::blank(width_px, height_px, [255; 3])?;
    let view = View::along(Vector3::z(), width_px, height_px);
    let framing = Framing::from_camera(sensor_from_camera);
    let painter = Painter {
        scene: Scene::new(actors.iter().map(|actor| (&actor.body, actor.scene_from_body))),
        shader: Shader::new(actors, &framing, &view),
    };
    let width = width_px as usize;
    // First pass: one ray through the centre of each pixel.
    let middles: Vec<(Face, Linear)> = (0..height_px)
        .into_par_iter()
        .flat_map_iter(|row| {
            let mut tools = (start(), SceneScratch::default());
            let one = |column| {
                let place = [f64::from(column), f64::from(row)];
                painter.sample(look(&mut tools.0, place), place, &mut tools.1)
            };
            (0..width_px).map(one).collect::<Vec<_>>()
        })
        .collect();
    progress(height_px as usize / 2, height_px as usize);
    // Second pass: pixels at borders of faces are refined.
    let rows = image.rgb.par_chunks_mut(3 * width).enumerate();
    rows.for_each(|(row, bytes)| {
        let mut tools = None;
        for column in 0..width {
            let (face, mut color) = middles[row * width + column];
            if is_edge(&middles, width, [column, row], face) {
                let tools = tools.get_or_insert_with(|| (start(), SceneScratch::default()));
                color = painter.pixel([column, row], |place| {
                    painter.sample(look(&mut tools.0, place), place, &mut tools.1)
                });
            }
            bytes[3 * column..3 * column + 3].copy_from_slice(&srgb(color));
        }
    });
    progress(height_px as usize, height_px as usize);
    Ok(image)
}

/// Returns whether a neighbour of a pixel shows another face.
fn is_edge(
    middles: &[(Face, Linear)],
    width: usize,
    [column, row]: [usize; 2],
    face: Face,
) -> bool {
    let differs = |at: usize| middles.get(at).is_some_and(|(other, _)| *other != face);
    let at = row * width + column;
    (column > 0 && differs(at - 1))
        || (column + 1 < width && differs(at + 1))
        || (row > 0 && differs(at - width))
        || differs(at + width)
}

struct Painter<'a> {
    scene: Scene<'a>,
    shader: Shader,
}

impl Painter<'_> {
    /// Shades a sample at a position where centres of pixels have whole coordinates, and returns the face that it shows.
    fn sample(
        &self,
        glimpse: PixelContent,
        place: [f64; 2],
        scratch: &mut SceneScratch,
    ) -> (Face, Linear) {
        // The shader counts from the outer corner of the first pixel.
        let [x_px, y_px] = place.map(|px| px + 0.5);
        let ray = match glimpse {
            PixelContent::Plain(color) => return (None, linear(color)),
            PixelContent::Along(ray) => ray,
        };
        let hit = self.scene.first_hit(&ray, START_MM..f64::INFINITY, scratch);
        let Some(hit) = hit else { return (None, self.shader.background(y_px)) };
        let crossing = hit.crossing;
        let surface = VisibleSurface {
            t: crossing.t,
            point: ray.at(crossing.t),
            normal: crossing.normal,
            actor: hit.body,
            leaf: crossing.leaf,
            face: crossing.face,
            line_weight: 1.0,
        };
        let face = Some((hit.body, crossing.leaf, crossing.face));
        (face, self.shader.shade(&surface, 0.0, x_px, y_px))
    }

    /// Averages a pixel that shows several faces, with a line where bodies meet.
    fn pixel(
        &self,
        [column, row]: [usize; 2],
        mut sample: impl FnMut([f64; 2]) -> (Face, Linear),
    ) -> Linear {
        let step = 1.0 / f64::from(SUBSAMPLES);
        let place = |at: usize, sub: u32| at as f64 - 0.5 + (f64::from(sub) + 0.5) * step;
        let (mut sum, mut bodies) = ([0.0; 3], Vec::new());
        for number in 0..SUBSAMPLES * SUBSAMPLES {
            let (x, y) = (number % SUBSAMPLES, number / SUBSAMPLES);
            let (face, color) = sample([place(column, x), place(row, y)]);
            // Lines are drawn between bodies only, not between faces of one body.
            bodies.push(face.map(|(body, ..)| body));
            sum = add(sum, color, 1.0 / (SUBSAMPLES * SUBSAMPLES) as f32);
        }
        let is_edge = bodies.iter().any(|body| *body != bodies[0]);
        if is_edge { self.shader.blend_ink(sum, EDGE_INK) } else { sum }
    }
}
