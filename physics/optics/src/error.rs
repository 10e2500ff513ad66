//! Why nothing can be said about a sensor's light.

use fabkit_geometry::{InvalidSolid, Point3};

/// Bodies that no light can be followed through.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InvalidStack {
    /// A clear body of which nobody knows how it bends light.
    #[error("{body}: light passes it, but nobody says how {} bends light", material_of(.material))]
    UnknownIndex {
        /// Which body.
        body: String,
        /// From what; empty where nobody says.
        material: String,
    },
    /// An index that no medium has.
    #[error("{body}: a refractive index of {index} is not within 1 to 4")]
    Index {
        /// Which body.
        body: String,
        /// As told.
        index: f64,
    },
    /// Two media in one place.
    #[error(
        "{} and {} overlap by {depth_mm:.3} mm at ({:.3}, {:.3}, {:.3}) mm: light has two media there",
        .bodies[0], .bodies[1], .place_in_sensor.x, .place_in_sensor.y, .place_in_sensor.z
    )]
    Overlap {
        /// The two, by name.
        bodies: [String; 2],
        /// Where a ray from the camera first is in both, sensor frame, mm.
        place_in_sensor: Point3<f64>,
        /// Along that ray, mm.
        depth_mm: f64,
    },
    /// A camera within what light does not pass.
    #[error(
        "the camera's pupil at ({:.3}, {:.3}, {:.3}) mm lies inside {body}, which light does not pass",
        .place_in_sensor.x, .place_in_sensor.y, .place_in_sensor.z
    )]
    CameraInside {
        /// Which body.
        body: String,
        /// The pupil, sensor frame, mm.
        place_in_sensor: Point3<f64>,
    },
    /// More bodies than can be told apart.
    #[error("{count} kinds of bodies; at most {} can be told apart", crate::MAX_NAMES)]
    TooMany {
        /// How many there are.
        count: usize,
    },
    /// A camera that has an interface in its own model where none is drawn.
    #[error(
        "the camera's file has an interface before drawn bodies, but none is drawn that all rays pass first"
    )]
    NoInterface,
    /// Dimensions that make no solid.
    #[error("{body}: {source}")]
    Solid {
        /// Which body.
        body: String,
        /// What is wrong with it.
        source: InvalidSolid,
    },
}

impl InvalidStack {
    /// What to do about it; empty where the message says it all.
    pub fn hint(&self) -> &'static str {
        match self {
            Self::UnknownIndex { .. } | Self::Index { .. } => {
                "state `refractive_index` of the material under `materials:`, for example 1.41 of a clear silicone"
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

fn material_of(material: &str) -> &str {
    if material.is_empty() { "what it is made from" } else { material }
}
