//! Shaded line drawings of parts and assemblies.
//!
//! Each pixel starts with one ray through its centre. Where neighbouring rays see different things (another body, a
//! step in depth, a crease), the pixel is refined with [`pen::SUBSAMPLES`] squared rays; lines are drawn there, and
//! nowhere else. The work is cut into tiles that overlap by as much as a line can reach, so that tiles are independent.

mod camera_view;
mod contact_sheet;
mod framing;
mod lines;
mod overlay;
mod pen;
mod sample;
mod shade;
mod surface;
#[cfg(test)]
mod tests;
mod tile;
mod view;

use fabkit_geometry::{CompiledSolid, Point3, Pose};
use rayon::prelude::*;

use crate::Scene;
pub use camera_view::{PixelContent, render_camera_view};
pub use contact_sheet::contact_sheet;
pub use framing::Framing;
use pen::Pen;
use sample::{Setup, Tracer};
use shade::Shader;
use tile::{TILE_PX, Tile};
pub use view::{SectionCut, View, ViewProjection};

/// Maximum number of pixels of an image.
pub const MAX_PIXELS: u64 = 64_000_000;

/// Number of probes along the longer side in the search for the extent of the bodies. A body that is thinner than a
/// cell *and* sticks out by more than the margin may lose its tip.
const PROBES: f64 = 256.0;

/// A body in an image.
///
/// ```
/// use fabkit_depth::{Actor, View, render};
/// use fabkit_geometry::{CompiledSolid, Pose, Solid};
///
/// // A green ball in a blue one, which is half transparent; and beside both what is not there.
/// let ball = |radius_mm| CompiledSolid::new(&Solid::sphere(radius_mm));
/// let core = Actor::new(ball(2.0)?, [0, 200, 0]);
/// let shell = Actor::new(ball(5.0)?, [0, 0, 200]).with_opacity(0.5);
/// let far = Actor::new(ball(1.0)?, [0; 3]).placed(Pose::translation(20.0, 0.0, 0.0)).with_opacity(0.0);
/// let [red, green, blue] = render(&[core, shell, far], &View::front(64, 64))?.pixel(10, 32);
/// assert!(green > red && blue > red);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Actor {
    /// Shape of the body.
    pub body: CompiledSolid,
    /// Pose of the body.
    pub scene_from_body: Pose,
    /// Colour, sRGB.
    pub color: [u8; 3],
    /// Opacity, 0 to 1; below 1, bodies behind show through.
    pub opacity: f64,
}

impl Actor {
    /// Creates an opaque body whose own frame is the scene's.
    pub fn new(body: CompiledSolid, color: [u8; 3]) -> Self {
        Self { body, scene_from_body: Pose::identity(), color, opacity: 1.0 }
    }

    /// Sets the pose.
    #[must_use]
    pub fn placed(mut self, scene_from_body: Pose) -> Self {
        self.scene_from_body = scene_from_body;
        self
    }

    /// Sets the opacity: 0 is invisible, 1 opaque.
    #[must_use]
    pub fn with_opacity(mut self, opacity: f64) -> Self {
        self.opacity = opacity;
        self
    }
}

/// An opaque sRGB image, row by row from the top, three bytes a pixel.
///
/// ```
/// use fabkit_depth::RenderedImage;
///
/// // White, with a black square whose right and lower edges are those before pixel 4; parts outside are left out.
/// let mut image = RenderedImage::filled(8, 6, [255; 3])?;
/// image.fill([2, 2], [4, 4], [0; 3]);
/// image.fill([6, 4], [99, 99], [0; 3]);
/// assert_eq!((image.pixel(2, 2), image.pixel(3, 3), image.pixel(4, 4)), ([0; 3], [0; 3], [255; 3]));
/// assert_eq!((image.pixel(7, 5), image.rgb.len()), ([0; 3], 3 * 8 * 6));
/// # Ok::<(), fabkit_depth::RenderError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct RenderedImage {
    /// Width, px.
    pub width_px: u32,
    /// Height, px.
    pub height_px: u32,
    /// Pixels: `3 * width * height` bytes.
    pub rgb: Vec<u8>,
}

impl RenderedImage {
    /// Returns the colour of a pixel, column `x_px` of row `y_px`.
    ///
    /// # Panics
    /// If the pixel is outside the image.
    pub fn pixel(&self, x_px: u32, y_px: u32) -> [u8; 3] {
        assert!(x_px < self.width_px && y_px < self.height_px, "outside the image");
        let at = 3 * (y_px as usize * self.width_px as usize + x_px as usize);
        [self.rgb[at], self.rgb[at + 1], self.rgb[at + 2]]
    }

    fn blank(width_px: u32, height_px: u32, color: [u8; 3]) -> Result<Self, RenderError> {
        check_size(width_px, height_px)?;
        let rgb = color.repeat(width_px as usize * height_px as usize);
        Ok(Self { width_px, height_px, rgb })
    }

    /// Copies rows of `rgb`, each `width_px` wide, with their first pixel at (`x_px`, `y_px`).
    fn paste(&mut self, rgb: &[u8], width_px: u32, x_px: u32, y_px: u32) {
        for (row, line) in rgb.chunks_exact(3 * width_px as usize).enumerate() {
            let at = 3 * ((y_px as usize + row) * self.width_px as usize + x_px as usize);
            self.rgb[at..at + line.len()].copy_from_slice(line);
        }
    }
}

/// Errors of rendering.
///
/// ```
/// use fabkit_depth::{Actor, RenderError, View, render};
/// use fabkit_geometry::{CompiledSolid, Point3, Solid, Vector3};
///
/// // A cut above the ball takes away all that is below it.
/// let ball = Actor::new(CompiledSolid::new(&Solid::sphere(5.0))?, [200; 3]);
/// let view = View::front(64, 48).cut(Point3::new(0.0, 0.0, 6.0), -Vector3::z());
/// assert_eq!(render(std::slice::from_ref(&ball), &view), Err(RenderError::NothingToDraw));
/// let wide = View::front(100_000, 1_000);
/// assert!(matches!(render(&[ball], &wide), Err(RenderError::TooLarge { .. })));
/// # Ok::<(), fabkit_geometry::InvalidSolid>(())
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RenderError {
    /// Side of no pixels.
    #[error("an image of {width_px} x {height_px} px has no pixels")]
    NoPixels {
        /// Requested width, px.
        width_px: u32,
        /// Requested height, px.
        height_px: u32,
    },
    /// Number of pixels above [`MAX_PIXELS`].
    #[error("an image of {width_px} x {height_px} px is above the limit of {MAX_PIXELS} pixels")]
    TooLarge {
        /// Requested width, px.
        width_px: u64,
        /// Requested height, px.
        height_px: u64,
    },
    /// No actors, or no part of them left after the cut.
    #[error("there is nothing to draw")]
    NothingToDraw,
    /// Infinite body, which cannot be framed.
    #[error("actor {actor} has no finite bounds")]
    Unbounded {
        /// Index of the actor in the list.
        actor: usize,
    },
    /// Opacity outside 0 to 1.
    #[error("actor {actor} has opacity {opacity}, which is not between 0 and 1")]
    Opacity {
        /// Index of the actor in the list.
        actor: usize,
        /// Requested opacity.
        opacity: f64,
    },
    /// Viewing direction that is zero or not finite.
    #[error("the direction to look in must be finite and not zero")]
    NoDirection,
    /// Cutting plane that is not finite, or whose normal is zero.
    #[error("the cut needs a finite point and a finite direction that is not zero")]
    BadCut,
    /// Field of view outside the range of [`ViewProjection::Perspective`].
    #[error("a field of view of {field_of_view_deg} degrees is not between 1 and 120")]
    FieldOfView {
        /// Requested field of view, degrees.
        field_of_view_deg: f64,
    },
    /// Margin that leaves no room; see [`View::margin`].
    #[error("a margin of {margin} of the image is not between 0 and 0.45")]
    Margin {
        /// Requested margin.
        margin: f64,
    },
}

/// Renders a scene, framed so that all of it fits.
///
/// Runs on rayon's current thread pool; the bytes do not depend on its size.
///
/// # Errors
/// See [`RenderError`].
///
/// ```
/// use fabkit_depth::{Actor, View, render};
/// use fabkit_geometry::{CompiledSolid, Pose, Solid};
///
/// // A blue ball stands before a red one: to the front is -y.
/// let ball = CompiledSolid::new(&Solid::sphere(5.0))?;
/// let near = Actor::new(ball.clone(), [0, 0, 220]).placed(Pose::translation(0.0, -20.0, 0.0));
/// let far = Actor::new(ball, [220, 0, 0]);
/// let [red, _, blue] = render(&[near, far], &View::front(64, 64))?.pixel(32, 32);
/// assert!(blue > red);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn render(actors: &[Actor], view: &View) -> Result<RenderedImage, RenderError> {
    render_with_progress(actors, view, &|_, _| {})
}

/// Renders a scene, and reports the number of finished pixel rows and their total to `progress`.
///
/// # Errors
/// See [`RenderError`].
///
/// ```
/// use std::cell::RefCell;
///
/// use fabkit_depth::{Actor, View, render_with_progress};
/// use fabkit_geometry::{CompiledSolid, Solid};
///
/// let ball = Actor::new(CompiledSolid::new(&Solid::sphere(5.0))?, [200; 3]);
/// let rows = RefCell::new(Vec::new());
/// render_with_progress(&[ball], &View::front(64, 200), &|done, all| rows.borrow_mut().push((done, all)))?;
/// assert_eq!(rows.borrow().last(), Some(&(200, 200)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn render_with_progress(
    actors: &[Actor],
    view: &View,
    progress: &dyn Fn(usize, usize),
) -> Result<RenderedImage, RenderError> {
    render_with_framing(actors, view, progress).map(|(image, _)| image)
}

/// Renders a scene, and also returns its framing, which maps points to pixels.
///
/// # Errors
/// See [`RenderError`].
pub fn render_with_framing(
    actors: &[Actor],
    view: &View,
    progress: &dyn Fn(usize, usize),
) -> Result<(RenderedImage, Framing), RenderError> {
    let setup = prepare(actors, view)?;
    let mut image = RenderedImage::blank(view.width_px, view.height_px, [255; 3])?;
    let columns = view.width_px.div_ceil(TILE_PX);
    let rows = view.height_px.div_ceil(TILE_PX);
    // One row of tiles at a time keeps memory to little more than the image itself.
    for row in 0..rows {
        let tiles: Vec<_> = (0..columns)
            .into_par_iter()
            .map(|column| {
                let tile = Tile::at(column, row, view.width_px, view.height_px);
                let rgb = tile.draw(&setup);
                (tile, rgb)
            })
            .collect();
        for (tile, rgb) in tiles {
            image.paste(&rgb, tile.width_px, tile.x_px, tile.y_px);
        }
        let drawn_px = ((row + 1) * TILE_PX).min(view.height_px);
        progress(drawn_px as usize, view.height_px as usize);
    }
    Ok((image, setup.framing))
}

/// Validates the input and determines the framing.
fn prepare<'a>(actors: &'a [Actor], view: &View) -> Result<Setup<'a>, RenderError> {
    view.validate()?;
    for (index, actor) in actors.iter().enumerate() {
        if !(0.0..=1.0).contains(&actor.opacity) {
            return Err(RenderError::Opacity { actor: index, opacity: actor.opacity });
        }
    }
    let scene = Scene::new(actors.iter().map(|actor| (&actor.body, actor.scene_from_body)));
    let opaque = actors.iter().filter(|actor| actor.opacity == 1.0);
    let shelters = Scene::new(opaque.map(|actor| (&actor.body, actor.scene_from_body)));
    let framing = Framing::fit(view, &framed_points(&scene, view.cut.as_ref())?)?;
    let shader = Shader::new(actors, &framing, view);
    let mut setup =
        Setup { scene, occluders: shelters, framing, shader, pen: Pen::from_view(view) };
    if let Some(closer) = find_tight_framing(&setup, view) {
        setup.framing = closer;
    }
    Ok(setup)
}

fn check_size(width_px: u32, height_px: u32) -> Result<(), RenderError> {
    if width_px == 0 || height_px == 0 {
        return Err(RenderError::NoPixels { width_px, height_px });
    }
    let (width_px, height_px) = (u64::from(width_px), u64::from(height_px));
    if width_px * height_px > MAX_PIXELS {
        return Err(RenderError::TooLarge { width_px, height_px });
    }
    Ok(())
}

/// Finds a tighter framing. Boxes of round and of cut bodies are larger than the bodies, so a grid of probes finds
/// where they are visible. Returns `None` if they are nowhere.
fn find_tight_framing(setup: &Setup<'_>, view: &View) -> Option<Framing> {
    let (width, height) = (f64::from(view.width_px), f64::from(view.height_px));
    // A coarse grid of rays over the image.
    let cell_px = width.max(height) / PROBES;
    let rows = (height / cell_px).ceil() as u32;
    let columns = (width / cell_px).ceil() as u32;
    let place = |cell: u32| (f64::from(cell) + 0.5) * cell_px;
    let seen_in_row = |row: u32| {
        let mut tracer = Tracer::new(setup);
        let mut seen = (0..columns).filter(|&column| tracer.meets(place(column), place(row)));
        let first = seen.next()?;
        Some((row, first, seen.next_back().unwrap_or(first)))
    };
    let seen: Vec<_> = (0..rows).into_par_iter().filter_map(seen_in_row).collect();
    let first_column = seen.iter().map(|row| row.1).min()?;
    let last_column = seen.iter().map(|row| row.2).max()?;
    // One cell more on each side: between two probes a body may extend almost to the next.
    let low = [place(first_column) - cell_px, place(seen.first()?.0) - cell_px];
    let high = [place(last_column) + cell_px, place(seen.last()?.0) + cell_px];
    Some(setup.framing.zoomed(view, low, high))
}

/// Returns points whose hull holds the scene: the corners of the actors' boxes after the cut.
fn framed_points(
    scene: &Scene<'_>,
    cut: Option<&SectionCut>,
) -> Result<Vec<Point3<f64>>, RenderError> {
    let mut points = Vec::new();
    for index in 0..scene.len() {
        let bounds = scene.bounds(index);
        if bounds.is_empty() {
            continue;
        }
        if !bounds.is_finite() {
            return Err(RenderError::Unbounded { actor: index });
        }
        let corners = crate::cast::corners(&bounds);
        match cut {
            Some(cut) => cut.clip_box(&corners, &mut points),
            None => points.extend(corners),
        }
    }
    if points.is_empty() { Err(RenderError::NothingToDraw) } else { Ok(points) }
}
