//! Errors of optical stacks.

use fabkit_geometry::{InvalidSolid, Point3};

/// Reason why light cannot be traced through the bodies of a sensor.
///
/// ```
/// # use fabkit_geometry::{Angle, Assembly, Body, NominalCamera, OpticalClarity, Placement, Pose, Sensor, Solid};
/// # let camera = NominalCamera {
/// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
/// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
/// # };
/// use fabkit_optics::OpticalStack;
///
/// // No source says what the pane is made from.
/// let pane = Body::bought("pane", "clear", Solid::cylinder(20.0, 2.0).at(0.0, 0.0, 5.0))
///     .with_clarity(OpticalClarity::Clear)
///     .placed([Placement::in_place(Assembly::sensor())]);
/// let error = OpticalStack::from_sensor(&Sensor::new("window", "A window", "", camera, [pane])).unwrap_err();
/// assert!(error.to_string().starts_with("pane: light passes it, but the refractive index"));
/// assert!(error.hint().contains("refractive_index"));
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InvalidStack {
    /// Clear body with an unknown refractive index.
    #[error("{body}: light passes it, but the refractive index of {} is not known", material_or_unknown(.material))]
    UnknownIndex {
        /// Name of the body.
        body: String,
        /// Name of the material; empty if unknown.
        material: String,
    },
    /// Window or layer that light may pass, of unknown transparency.
    #[error("{body}: not known: transparency of {}", material_or_unknown(.material))]
    UnknownTransparency {
        /// Name of the body.
        body: String,
        /// Name of the material; empty if unknown.
        material: String,
    },
    /// Refractive index outside 1 to 4.
    #[error("{body}: a refractive index of {index} is not within 1 to 4")]
    Index {
        /// Name of the body.
        body: String,
        /// Stated index.
        index: f64,
    },
    /// Overlap of two media.
    #[error(
        "{} and {} overlap by {depth_mm:.3} mm at ({:.3}, {:.3}, {:.3}) mm: a place can have only one medium",
        .bodies[0], .bodies[1], .place_in_sensor.x, .place_in_sensor.y, .place_in_sensor.z
    )]
    Overlap {
        /// Names of the two bodies.
        bodies: [String; 2],
        /// First point of a ray from the camera that lies in both, sensor frame, mm.
        place_in_sensor: Point3<f64>,
        /// Length of the overlap along that ray, mm.
        depth_mm: f64,
    },
    /// Camera inside a body that light does not pass.
    #[error(
        "the camera's pupil at ({:.3}, {:.3}, {:.3}) mm lies inside {body}, which light does not pass",
        .place_in_sensor.x, .place_in_sensor.y, .place_in_sensor.z
    )]
    CameraInside {
        /// Name of the body.
        body: String,
        /// Position of the pupil, sensor frame, mm.
        place_in_sensor: Point3<f64>,
    },
    /// More bodies than can be distinguished.
    #[error("{count} kinds of bodies; at most {} can be told apart", crate::MAX_NAMES)]
    TooMany {
        /// Number of bodies of different names.
        count: usize,
    },
    /// Camera whose model has an interface although none is drawn.
    #[error(
        "the camera's file has an interface before drawn bodies, but none is drawn that all rays pass first"
    )]
    NoInterface,
    /// Invalid solid.
    #[error("{body}: {source}")]
    Solid {
        /// Name of the body.
        body: String,
        /// Reason.
        source: InvalidSolid,
    },
}

impl InvalidStack {
    /// Returns what to do; empty if the message says it.
    pub fn hint(&self) -> &'static str {
        match self {
            Self::UnknownIndex { .. } | Self::Index { .. } => {
                "state `refractive_index` of the material under `materials:`, for example 1.41 of a clear silicone"
            }
            Self::UnknownTransparency { .. } => {
                "state `clarity` of the material under `materials:`: clear, translucent or opaque"
            }
            Self::NoInterface => {
                "a camera that was calibrated with this design; or remove `behind` from the camera's file, and nothing but \
                 its interface bends rays"
            }
            Self::CameraInside { .. } => "a camera pose from which the lens looks out",
            _ => "",
        }
    }
}

/// Returns the name of the material, or words that stand for an unknown one.
fn material_or_unknown(material: &str) -> &str {
    if material.is_empty() { "its material" } else { material }
}
