//! What a sensor's file says of its camera's lens.

use fabkit_geometry::{LensImaging, LensTolerance, NominalLens, Projection};

use crate::choices;

choices! {
    /// How far from the picture's middle a lens shows what it sees at an angle a off its axis.
    pub enum LensLaw {
        /// r = f a.
        Equidistant = "equidistant",
        /// r = 2 f sin(a / 2).
        Equisolid = "equisolid",
        /// r = 2 f tan(a / 2).
        Stereographic = "stereographic",
    }
}

impl LensLaw {
    /// The lens; tolerances as shares of the focal length and of a picture's width, px.
    pub fn lens(self, focal_share: f64, centre_share: f64, width_px: u32) -> NominalLens {
        let projection = match self {
            Self::Equidistant => Projection::Equidistant,
            Self::Equisolid => Projection::Equisolid,
            Self::Stereographic => Projection::Stereographic,
        };
        let centre_px = centre_share * f64::from(width_px);
        NominalLens {
            projection,
            tolerance: LensTolerance { focal_share, centre_px },
            imaging: LensImaging::default(),
        }
    }
}

/// The lens that the section `camera` of a family describes.
macro_rules! nominal_lens {
    ($camera:expr) => {{
        let camera = &$camera;
        let lens = camera.projection.lens(
            camera.focal_tolerance,
            camera.centre_tolerance,
            camera.width_px,
        );
        fabkit_geometry::NominalLens { imaging: $crate::blocks::imaging!(camera), ..lens }
    }};
}
pub(crate) use nominal_lens;

/// What the lens that the section `camera` of a family describes does to how bright and how sharp pictures are.
macro_rules! imaging {
    ($camera:expr) => {
        fabkit_geometry::LensImaging {
            falloff_power: $camera.vignetting,
            pupil_mm: $camera.aperture.mm(),
            focus_mm: $camera.focus.mm(),
        }
    };
}
pub(crate) use imaging;
