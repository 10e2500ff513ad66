//! Optical parameters of a camera and its lens, shared by all families.

use std::fmt::{self, Display, Formatter};

use fabkit_geometry::{
    Angle, Length, LensImaging, LensTolerance, NominalCamera, NominalLens, Projection,
};

use super::camera_at;
use crate::parameters::Inline;
use crate::{choices, sections};

choices! {
    /// Projection of a lens: distance r from the image's centre, for focal length f, of a ray at an angle a to the
    /// axis.
    pub enum ProjectionLaw {
        /// Equidistant: r = f a.
        Equidistant = "equidistant",
        /// Equisolid-angle: r = 2 f sin(a / 2).
        Equisolid = "equisolid",
        /// Stereographic: r = 2 f tan(a / 2).
        Stereographic = "stereographic",
    }
}

sections! {
    /// Camera module of a sensor.
    pub struct Module {
        /// Camera module that is bought. Its dimensions are used unless others are given; `none` to give all dimensions
        /// by hand.
        module: String = 1..=64,
        /// Type of camera to buy.
        model: String = 1..=80,
    }

    /// Images that a camera takes.
    pub struct ImageFormat {
        /// Width of the image in pixels.
        width_px: u32 = 16..=20000,
        /// Height of the image in pixels.
        height_px: u32 = 16..=20000,
        /// Frames per second.
        frame_rate: u32 = 1..=10000,
    }

    /// Optical properties of a lens, and their tolerances.
    pub struct Optics {
        /// Tolerance of the focal length, as a fraction of it.
        focal_tolerance: f64 = 0.0..=0.2,
        /// Tolerance of the lens's axis: its distance from the image's centre, as a fraction of the image's width.
        centre_tolerance: f64 = 0.0..=0.2,
        /// Exponent of the cosine of the angle to the lens's axis, in air, by which images darken away from the axis: 4
        /// for the natural law, 0 for uniform brightness.
        vignetting: f64 = 0.0..=8.0,
        /// Diameter of the lens's entrance pupil, which is the focal length divided by the f-number; 0 for images
        /// without blur.
        aperture: Length = 0.0..=20.0,
        /// Distance that is in focus, from the optical centre along the axis, as in air.
        focus: Length = 1.0..=100000.0,
    }

    /// View of a lens on a board or in a housing, whose maker states its angle.
    pub struct View {
        /// Full angle of view of the lens, over the image's diagonal.
        field_of_view: Angle = 10.0..=220.0,
        /// Projection of the lens: relation between the angle to its axis and the distance from the image's centre.
        projection: ProjectionLaw,
        /// Optical properties of the lens.
        optics: Inline<Optics>,
    }
}

impl ImageFormat {
    /// Returns the number of pixels along both edges.
    pub fn size_px(&self) -> [u32; 2] {
        [self.width_px, self.height_px]
    }
}

/// Formats the image size and frame rate as orders state it.
impl Display for ImageFormat {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{} x {} px at {} fps", self.width_px, self.height_px, self.frame_rate)
    }
}

impl ProjectionLaw {
    /// Returns the projection of the geometry crate.
    pub fn projection(self) -> Projection {
        match self {
            Self::Equidistant => Projection::Equidistant,
            Self::Equisolid => Projection::Equisolid,
            Self::Stereographic => Projection::Stereographic,
        }
    }
}

impl Optics {
    /// Returns the lens of a camera whose images are `width_px` wide.
    pub fn lens(&self, law: ProjectionLaw, width_px: u32) -> NominalLens {
        let centre_px = self.centre_tolerance * f64::from(width_px);
        NominalLens {
            projection: law.projection(),
            tolerance: LensTolerance { focal_share: self.focal_tolerance, centre_px },
            imaging: LensImaging {
                falloff_power: self.vignetting,
                pupil_mm: self.aperture.mm(),
                focus_mm: self.focus.mm(),
            },
        }
    }

    /// Returns the camera of [`camera_at`] with this lens.
    pub fn camera_at(
        &self,
        pupil_z: f64,
        size_px: [u32; 2],
        (view, law): (Angle, ProjectionLaw),
    ) -> NominalCamera {
        camera_at(pupil_z, size_px, view, self.lens(law, size_px[0]))
    }
}

impl View {
    /// Returns the camera on the axis, see [`Optics::camera_at`].
    pub fn camera_at(&self, pupil_z: f64, size_px: [u32; 2]) -> NominalCamera {
        self.optics.camera_at(pupil_z, size_px, (self.field_of_view, self.projection))
    }

    /// Returns the angle that a pixel at the image's centre covers, rad.
    pub fn rad_per_px(&self, size_px: [u32; 2]) -> f64 {
        let [x, y] = size_px.map(f64::from);
        // Half the field of view is imaged to half the diagonal. The radius of the projection is for a focal length of
        // 1, where small angles in rad equal radii.
        self.projection.projection().radius(self.field_of_view.rad() / 2.0) / (x.hypot(y) / 2.0)
    }
}
