//! Pictures of parts and assemblies, drawn from the exact geometry.

use fabkit_depth::{Actor, View, render};
use fabkit_export::ExportError;
use fabkit_geometry::{Assembly, Body, InvalidSolid, Pose, Sensor, Vector3};

use crate::bodies::{BodyRef, UnknownName, bodies};

/// Largest picture, px.
pub const MAX_PIXELS: u64 = 64_000_000;

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// A tree that is no solid.
    #[error("{body}: {source}")]
    Solid {
        /// Which body.
        body: String,
        /// Why.
        source: InvalidSolid,
    },
    /// No body stands in that assembly.
    #[error(transparent)]
    Unknown(#[from] UnknownName),
    /// The picture could not be encoded.
    #[error(transparent)]
    Encode(#[from] ExportError),
}

/// A body alone, as it lies in its own frame, as PNG; `size_px` is width and height.
///
/// # Errors
/// [`PictureError`].
pub fn picture_of_body(body: &BodyRef, size_px: [u32; 2]) -> Result<Vec<u8>, PictureError> {
    let actor = actor(body, &prepared(body)?, Pose::identity(), 1.0);
    draw(&[actor], size_px)
}

/// All bodies of an assembly in their places as PNG, or apart as the design spreads them.
///
/// # Errors
/// [`PictureError`].
pub fn picture_of_assembly(
    sensor: &Sensor,
    assembly: &str,
    exploded: bool,
    size_px: [u32; 2],
) -> Result<Vec<u8>, PictureError> {
    let mut actors = Vec::new();
    let all = bodies(sensor);
    for body in &all {
        let places: Vec<&Pose> = body
            .placements
            .iter()
            .filter(|p| p.assembly.0 == assembly)
            .map(|p| &p.assembly_from_body)
            .collect();
        if places.is_empty() {
            continue;
        }
        let prepared = prepared(body)?;
        for place in places {
            let apart_mm = if exploded { body.explode_mm } else { Vector3::zeros() };
            let shift = Pose::translation(apart_mm.x, apart_mm.y, apart_mm.z);
            actors.push(actor(body, &prepared, shift.then_in(*place), body.opacity));
        }
    }
    if actors.is_empty() {
        let known: std::collections::BTreeSet<&str> =
            all.iter().flat_map(|b| b.placements).map(|p| p.assembly.0.as_str()).collect();
        return Err(UnknownName::new("assembly", assembly, known).into());
    }
    draw(&actors, size_px)
}

/// The assembly that pictures show unless another is asked for.
pub fn default_assembly() -> String {
    Assembly::sensor().0
}

fn prepared(body: &BodyRef) -> Result<Body, PictureError> {
    Body::new(body.solid).map_err(|source| PictureError::Solid { body: body.name.into(), source })
}

fn actor(body: &BodyRef, prepared: &Body, scene_from_body: Pose, opacity: f64) -> Actor {
    Actor { body: prepared.clone(), scene_from_body, color: body.color, opacity }
}

fn draw(actors: &[Actor], [width_px, height_px]: [u32; 2]) -> Result<Vec<u8>, PictureError> {
    let picture =
        render(actors, &View { width_px, height_px, looking: Vector3::new(-1.0, 1.0, -1.0) });
    Ok(fabkit_export::png(picture.width_px, picture.height_px, &picture.rgb)?)
}
