//! What a sensor is to light, as one JSON document: for whoever wants to follow rays without fabkit.

use fabkit_geometry::{Path, Pose, Solid};
use serde::Serialize;

use crate::tree::Units;
use crate::{ExportError, VERSION, json_bytes};

/// A lens and where it is.
#[derive(Clone, Debug, Serialize)]
pub struct LightCamera {
    /// Camera frame to sensor frame, mm.
    pub sensor_from_camera: Pose,
    /// Columns.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// Name of its projection model.
    pub lens: &'static str,
    /// The model's numbers, by name.
    pub parameters: serde_json::Map<String, serde_json::Value>,
}

/// A place of a body in the finished sensor.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct LightPlacement {
    /// Body frame to sensor frame, mm.
    pub sensor_from_body: Pose,
    /// Whether it is the camera's own: what lets no light through, and has the pupil inside.
    pub is_cameras_own: bool,
}

/// What a body is to light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LightPart {
    /// It lets light through.
    Medium,
    /// It shows the touch.
    Skin,
    /// It ends rays.
    Stop,
}

/// A body of the finished sensor.
#[derive(Clone, Debug, Serialize)]
pub struct LightBody<'a> {
    /// Its name.
    pub name: &'a str,
    /// `part`, `layer` or `component`.
    pub kind: &'a str,
    /// From what; empty where nobody says.
    pub material: &'a str,
    /// `clear`, `translucent` or `opaque`.
    pub clarity: &'a str,
    /// Against air; `None` where nobody says.
    pub refractive_index: Option<f64>,
    /// Whether the camera is there to see it, or it gives way with the surface.
    pub is_looked_at: bool,
    /// What it is to light.
    pub part: LightPart,
    /// Whether it counts as skin where light goes on from skin: all skin, media that are looked at, and gel that
    /// stops light.
    pub is_skin: bool,
    /// Where it stands.
    pub placements: Vec<LightPlacement>,
    /// Its exact shape, mm, in its own frame.
    pub solid: &'a Solid,
}

/// What touches things.
#[derive(Clone, Debug, Serialize)]
pub struct LightSurface<'a> {
    /// All that lies within the surface, down to far below the sensor, sensor frame, mm: a ray from a camera
    /// starts in it, and its outer side is outside of it.
    pub solid: Solid,
    /// The surface is that part of the solid's boundary which is not lower than this, sensor frame, mm.
    pub foot_z_mm: f64,
    /// Half axes and offset of a dome around z and the height of its centre; nothing for a pad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dome: Option<LightDome>,
    /// Outline and height of a flat pad; nothing for a dome.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plane: Option<LightPlane<'a>>,
}

/// A dome with a wall below its centre.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct LightDome {
    /// Of the ellipsoid to which it is parallel, mm.
    pub equatorial_mm: f64,
    /// The same along z, mm.
    pub polar_mm: f64,
    /// How far outside of it, mm.
    pub offset_mm: f64,
    /// Height of its centre, sensor frame, mm.
    pub centre_z_mm: f64,
}

/// A flat pad.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct LightPlane<'a> {
    /// Its edge, seen along z.
    pub outline: &'a Path,
    /// Its height, sensor frame, mm.
    pub top_z_mm: f64,
}

/// What the document says, before it becomes JSON.
#[derive(Clone, Debug)]
pub struct LightDocument<'a> {
    /// Identifies the design and the maker's version.
    pub design_hash: &'a str,
    /// The sensor's name.
    pub sensor: &'a str,
    /// The camera as designed.
    pub camera: LightCamera,
    /// All of the finished sensor.
    pub bodies: Vec<LightBody<'a>>,
    /// What touches things; `None` where nothing is known to press it.
    pub surface: Option<LightSurface<'a>>,
    /// What the numbers in `seen_by` of ground truth mean.
    pub seen_by_names: Vec<String>,
}

#[derive(Serialize)]
struct Form<'a> {
    format: &'static str,
    version: u32,
    fabkit: &'static str,
    units: Units,
    design_hash: &'a str,
    sensor: &'a str,
    camera: &'a LightCamera,
    seen_by_names: &'a [String],
    surface: Option<&'a LightSurface<'a>>,
    bodies: &'a [LightBody<'a>],
}

/// Writes what a sensor is to light, as JSON (`fabkit-light` version 1). Solids are as in a tree.
///
/// # Errors
/// [`ExportError::Json`] if the encoder refuses.
pub fn light(document: &LightDocument) -> Result<Vec<u8>, ExportError> {
    json_bytes(&Form {
        format: "fabkit-light",
        version: 1,
        fabkit: VERSION,
        units: Units::USUAL,
        design_hash: document.design_hash,
        sensor: document.sensor,
        camera: &document.camera,
        seen_by_names: &document.seen_by_names,
        surface: document.surface.as_ref(),
        bodies: &document.bodies,
    })
}
