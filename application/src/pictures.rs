//! Pictures of parts and assemblies, drawn from the exact geometry.

use fabkit_depth::{Actor, RenderError, View, render_watched};
use fabkit_export::ExportError;
use fabkit_geometry::{
    Assembly, Body, CompiledSolid, InvalidSolid, Placement, Point3, Pose, Sensor, Vector3,
};

use crate::bodies::UnknownName;
use crate::progress::{OnProgress, counted};
use crate::{ErrorKind, Explained};

pub use fabkit_depth::MAX_PIXELS;

/// How a picture is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shot {
    /// Width and height, px.
    pub size_px: [u32; 2],
    /// Take the half in front of the x-z plane away.
    pub section: bool,
}

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
    /// The scene cannot be drawn.
    #[error("{}", undrawn(.0))]
    Render(#[from] RenderError),
    /// The picture could not be encoded.
    #[error(transparent)]
    Encode(#[from] ExportError),
}

/// What draws knows no planes of section.
fn undrawn(error: &RenderError) -> String {
    match error {
        RenderError::NothingToDraw => "nothing is left behind the section plane".into(),
        other => other.to_string(),
    }
}

impl Explained for PictureError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Unknown(_)
            | Self::Render(RenderError::NothingToDraw | RenderError::NoPixels { .. }) => {
                ErrorKind::BadInput
            }
            Self::Render(RenderError::TooLarge { .. }) => ErrorKind::Limit,
            _ => ErrorKind::Bug,
        }
    }

    fn hint(&self) -> Option<String> {
        match self {
            Self::Unknown(unknown) => Some(unknown.hint()),
            Self::Render(RenderError::TooLarge { .. }) => Some("ask for a smaller picture".into()),
            _ => None,
        }
    }
}

/// A body alone, as it lies on the printer's bed, as PNG; what is not printed, in its own frame.
///
/// # Errors
/// [`PictureError`].
pub fn picture_of_body(
    body: &Body,
    shot: Shot,
    progress: OnProgress,
) -> Result<Vec<u8>, PictureError> {
    let actor = actor(body, &prepared(body)?, body.bed_from_body, 1.0);
    draw(&[actor], shot, progress)
}

/// All bodies of an assembly in their places as PNG, or apart as the design spreads them.
///
/// # Errors
/// [`PictureError`].
pub fn picture_of_assembly(
    sensor: &Sensor,
    assembly: &str,
    exploded: bool,
    shot: Shot,
    progress: OnProgress,
) -> Result<Vec<u8>, PictureError> {
    let mut actors = Vec::new();
    for body in &sensor.bodies {
        let places: Vec<&Placement> =
            body.placements.iter().filter(|p| p.assembly.0 == assembly).collect();
        if places.is_empty() {
            continue;
        }
        let prepared = prepared(body)?;
        for place in places {
            let apart_mm = if exploded { place.explode_mm } else { Vector3::zeros() };
            let shift = Pose::translation(apart_mm.x, apart_mm.y, apart_mm.z);
            actors.push(actor(
                body,
                &prepared,
                shift.then_in(place.assembly_from_body),
                body.opacity,
            ));
        }
    }
    if actors.is_empty() {
        let known: std::collections::BTreeSet<&str> = sensor
            .bodies
            .iter()
            .flat_map(|b| &b.placements)
            .map(|p| p.assembly.0.as_str())
            .collect();
        return Err(UnknownName::new("assembly", assembly, known).into());
    }
    draw(&actors, shot, progress)
}

/// The assembly that pictures show unless another is asked for: the sensor itself, or the first
/// one of a fixture.
pub fn default_assembly(sensor: &Sensor) -> String {
    let mut assemblies =
        sensor.bodies.iter().flat_map(|body| &body.placements).map(|p| &p.assembly);
    let sensor = Assembly::sensor();
    let first = assemblies.clone().next();
    let found = assemblies.find(|assembly| **assembly == sensor).or(first);
    found.unwrap_or(&sensor).0.clone()
}

fn prepared(body: &Body) -> Result<CompiledSolid, PictureError> {
    CompiledSolid::new(&body.solid)
        .map_err(|source| PictureError::Solid { body: body.name.clone(), source })
}

fn actor(body: &Body, prepared: &CompiledSolid, scene_from_body: Pose, opacity: f64) -> Actor {
    Actor { body: prepared.clone(), scene_from_body, color: body.color, opacity }
}

fn draw(actors: &[Actor], shot: Shot, progress: OnProgress) -> Result<Vec<u8>, PictureError> {
    let [width_px, height_px] = shot.size_px;
    let view = if shot.section {
        View::section(width_px, height_px, Point3::origin(), -Vector3::y())
    } else {
        View::isometric(width_px, height_px)
    };
    let picture = render_watched(actors, &view, &counted(progress))?;
    Ok(fabkit_export::png(picture.width_px, picture.height_px, &picture.rgb)?)
}
