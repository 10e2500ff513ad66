//! Reasons why a camera does not see a point.

use fabkit_camera::Point2;
use fabkit_geometry::Point3;

use crate::stack::Stack;
use crate::trace::End;
use crate::viewer::{Unseen, Viewer};

/// Label of points outside the image. See [`Lost::word`].
pub const BESIDE_PICTURE: &str = "beside the picture";

/// Label of points whose light is bent away or totally reflected. See [`Lost::word`].
pub const REFRACTION: &str = "refraction";

/// Distance from a point at which the end of a ray counts as reaching it, mm.
const THERE_MM: f64 = 1e-6;

/// Reason why a point is not seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Lost {
    /// A body hides it; index into the names of the stack.
    Hidden(u8),
    /// Its light is bent away or totally reflected.
    Refraction,
    /// Its light enters the lens, but arrives outside the image.
    BesidePicture,
}

impl Lost {
    /// Returns the reason that corresponds to the end of a ray.
    pub fn at(end: End) -> Self {
        match end {
            End::Body(name) => Self::Hidden(name),
            End::Surface | End::Mirror(_) | End::Nothing => Self::Refraction,
        }
    }

    /// Returns the name of the hiding body, or [`REFRACTION`], or [`BESIDE_PICTURE`].
    pub fn word(self, stack: &Stack) -> &str {
        match self {
            Self::Hidden(name) => stack.name_of(End::Body(name)),
            Self::Refraction => REFRACTION,
            Self::BesidePicture => BESIDE_PICTURE,
        }
    }
}

impl Viewer<'_> {
    /// Returns the pixel of a visible point, sensor frame, mm.
    ///
    /// # Errors
    /// The reason why it is not seen.
    pub fn see(&mut self, place_in_sensor: &Point3<f64>) -> Result<Point2<f64>, Lost> {
        match self.look_at(place_in_sensor) {
            Err(Unseen::NoLight { .. }) => Err(Lost::Refraction),
            Err(Unseen::Lens(_)) => Err(Lost::BesidePicture),
            Ok(look) if !self.camera().sees(&look.pixel) => Err(Lost::BesidePicture),
            Ok(look) => {
                look.sight.hidden_by(THERE_MM).map_or(Ok(look.pixel), |by| Err(Lost::at(by)))
            }
        }
    }
}

/// Describes shares of invisible points by [`Lost::word`]: `27 % lies beside the picture, diffuser hides 3 %`.
///
/// ```
/// let lost = [("refraction".to_owned(), 0.25), ("lid".to_owned(), 0.041)];
/// assert_eq!(fabkit_optics::in_words(&lost, 0), "25 % is bent or reflected away, lid hides 4 %");
/// ```
pub fn in_words(lost: &[(String, f64)], digits: usize) -> String {
    let part = |(by, share): &(String, f64)| {
        let percent = 100.0 * share;
        match by.as_str() {
            BESIDE_PICTURE => format!("{percent:.digits$} % lies beside the picture"),
            REFRACTION => format!("{percent:.digits$} % is bent or reflected away"),
            body => format!("{body} hides {percent:.digits$} %"),
        }
    };
    lost.iter().map(part).collect::<Vec<_>>().join(", ")
}
