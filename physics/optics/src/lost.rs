//! Why a camera does not see a place.

use fabkit_camera::Point2;
use fabkit_geometry::Point3;

use crate::stack::Stack;
use crate::trace::End;
use crate::viewer::{Unseen, Viewer};

/// What is lost since the camera looks elsewhere, see [`Lost::word`].
pub const BESIDE_PICTURE: &str = "beside the picture";

/// What is lost since light is bent away or totally reflected, in the same.
pub const REFRACTION: &str = "refraction";

/// A ray that ends that near to a place ends there, mm.
const THERE_MM: f64 = 1e-6;

/// Why a place is not seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Lost {
    /// One of the stack's names stands in the way.
    Hidden(u8),
    /// Light from there is bent away, or reflected back.
    Refraction,
    /// Light from there enters the lens, but beside what it shows.
    BesidePicture,
}

impl Lost {
    /// What keeps a place from being seen by ending its ray.
    pub fn at(end: End) -> Self {
        match end {
            End::Body(name) => Self::Hidden(name),
            End::Surface | End::Mirror(_) | End::Nothing => Self::Refraction,
        }
    }

    /// The body in the way, or [`REFRACTION`], or [`BESIDE_PICTURE`].
    pub fn word(self, stack: &Stack) -> &str {
        match self {
            Self::Hidden(name) => stack.name_of(End::Body(name)),
            Self::Refraction => REFRACTION,
            Self::BesidePicture => BESIDE_PICTURE,
        }
    }
}

impl Viewer<'_> {
    /// The pixel of a place, sensor frame, mm.
    ///
    /// # Errors
    /// Why it is not seen.
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

/// Shares of what is lost, by [`Lost::word`], in words: `27 % lies beside the picture, diffuser hides 3 %`.
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
