//! Optical description of a sensor as one JSON document, for ray tracing without fabkit.

use fabkit_geometry::{Path, Pose, Solid};
use serde::Serialize;

use crate::tree::Units;
use crate::{ExportError, VERSION, json_bytes};

/// A camera's projection and pose.
#[derive(Clone, Debug, Serialize)]
pub struct LightCamera {
    /// Transform from the camera frame to the sensor frame, mm.
    pub sensor_from_camera: Pose,
    /// Number of columns.
    pub width_px: u32,
    /// Number of rows.
    pub height_px: u32,
    /// Name of the projection model.
    pub lens: &'static str,
    /// Parameters of the model, by name.
    pub parameters: serde_json::Map<String, serde_json::Value>,
}

/// Placement of a body in the finished sensor.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct LightPlacement {
    /// Transform from the body frame to the sensor frame, mm.
    pub sensor_from_body: Pose,
    /// True if it is the camera's own body: an opaque body with the pupil inside.
    pub is_cameras_own: bool,
}

/// Optical role of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum OpticalRole {
    /// Medium that transmits light.
    Medium,
    /// Skin that shows the touch.
    Skin,
    /// Stop that ends rays.
    Stop,
}

/// A body of the finished sensor.
#[derive(Clone, Debug, Serialize)]
pub struct LightBody<'a> {
    /// Name of the body.
    pub name: &'a str,
    /// Kind of body: `part`, `layer` or `component`.
    pub kind: &'a str,
    /// Material; empty if not specified.
    pub material: &'a str,
    /// Clarity: `clear`, `translucent` or `opaque`.
    pub clarity: &'a str,
    /// Refractive index against air; `None` if not specified.
    pub refractive_index: Option<f64>,
    /// True if the camera is meant to see the body, or the body deforms with the surface.
    pub is_looked_at: bool,
    /// True if the body contains markers whose positions a lighting shows; left out if not.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub is_marker: bool,
    /// Optical role.
    pub part: OpticalRole,
    /// True if the body counts as skin where light continues from skin: all skin, media that are looked at, opaque gel,
    /// and markers.
    pub is_skin: bool,
    /// Placements of the body.
    pub placements: Vec<LightPlacement>,
    /// Exact shape, mm, in the body's own frame.
    pub solid: &'a Solid,
}

/// Sensing surface.
#[derive(Clone, Debug, Serialize)]
pub struct LightSurface<'a> {
    /// Solid of all points within the surface, down to far below the sensor, sensor frame, mm. Rays from the camera
    /// start inside it; the surface's outer side is outside of it.
    pub solid: Solid,
    /// Height above which the solid's boundary is the sensing surface, sensor frame, mm.
    pub foot_z_mm: f64,
    /// Dome around z; `None` for a pad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dome: Option<LightDome>,
    /// Flat pad; `None` for a dome.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plane: Option<LightPlane<'a>>,
}

/// A dome with a wall below its centre.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct LightDome {
    /// Equatorial half axis of the ellipsoid that the dome is parallel to, mm.
    pub equatorial_mm: f64,
    /// Polar half axis of that ellipsoid, along z, mm.
    pub polar_mm: f64,
    /// Outward distance from the ellipsoid, mm.
    pub offset_mm: f64,
    /// Height of the centre, sensor frame, mm.
    pub centre_z_mm: f64,
}

/// A flat pad.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct LightPlane<'a> {
    /// Edge, seen along z.
    pub outline: &'a Path,
    /// Height, sensor frame, mm.
    pub top_z_mm: f64,
}

/// Content of the document.
#[derive(Clone, Debug)]
pub struct LightDocument<'a> {
    /// Hash of the design and the fabkit version.
    pub design_hash: &'a str,
    /// Name of the sensor.
    pub sensor: &'a str,
    /// Camera as designed.
    pub camera: LightCamera,
    /// All bodies of the finished sensor.
    pub bodies: Vec<LightBody<'a>>,
    /// Sensing surface; `None` if the sensor has none.
    pub surface: Option<LightSurface<'a>>,
    /// Names of the codes in `seen_by` of ground truth.
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

/// Writes the optical description of a sensor as JSON (`fabkit-light` version 1). Solids have the form of a tree file.
///
/// # Errors
/// [`ExportError::Json`] if the encoder fails.
///
/// ```
/// use fabkit_export::{LightCamera, LightDocument, light};
/// use fabkit_geometry::Pose;
/// use serde_json::{Map, Value};
///
/// let camera = LightCamera {
///     sensor_from_camera: Pose::translation(0.0, 0.0, -20.0),
///     width_px: 640,
///     height_px: 480,
///     lens: "pinhole",
///     parameters: Map::from_iter([("focal_px".to_owned(), 320.0.into())]),
/// };
/// let document = LightDocument {
///     design_hash: "0123",
///     sensor: "empty",
///     camera,
///     bodies: Vec::new(),
///     surface: None,
///     seen_by_names: vec!["nothing".into()],
/// };
/// let json: Value = serde_json::from_slice(&light(&document)?)?;
/// assert_eq!(json["units"]["length"], "mm");
/// assert_eq!(json["camera"]["parameters"]["focal_px"], 320.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
