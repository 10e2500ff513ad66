//! How light passes a body, and how see-through it is drawn.

use crate::{Body, BodyKind, OpticalClarity};

/// Opacity in renderings of what is clear.
const CLEAR_OPACITY: f64 = 0.35;

impl Body {
    /// Sets the optical clarity, and the opacity in renderings to match.
    ///
    /// ```
    /// use fabkit_geometry::{Body, OpticalClarity, Solid};
    /// let gel = Body::cast("gel", "soft core", Solid::sphere(10.0)).with_clarity(OpticalClarity::Clear);
    /// assert_eq!(gel.opacity, 0.35);
    /// let chosen = gel.opaque(0.2).with_clarity(OpticalClarity::Translucent);
    /// assert_eq!(chosen.opacity, 0.2); // chosen by hand
    /// ```
    #[must_use]
    pub fn with_clarity(mut self, clarity: OpticalClarity) -> Self {
        self.set_clarity(clarity);
        self
    }

    /// Sets the optical clarity of an existing body, and the opacity in renderings to match. An opacity below 1 is kept
    /// unless the body is opaque.
    pub fn set_clarity(&mut self, clarity: OpticalClarity) {
        self.opacity = match clarity {
            OpticalClarity::Opaque => 1.0,
            // An opacity that was chosen by hand is kept.
            _ if self.opacity < 1.0 => self.opacity,
            OpticalClarity::Clear => CLEAR_OPACITY,
            OpticalClarity::Translucent => 0.7,
        };
        self.optics = Some(clarity);
    }

    /// Marks a part that light may pass, cut from a sheet or made of resin, with the transparency of its material; `None`
    /// if no source at hand states it.
    ///
    /// ```
    /// use fabkit_geometry::{Body, OpticalClarity, Process, Solid};
    /// let plate = |clarity| {
    ///     Body::made("plate", "", Process::Laser, Solid::cylinder(9.0, 2.0)).as_window(clarity)
    /// };
    /// assert!(!plate(Some(OpticalClarity::Clear)).has_unknown_transparency());
    /// // It is drawn as if it were clear, but whoever needs its transparency must ask.
    /// assert!(plate(None).has_unknown_transparency());
    /// ```
    #[must_use]
    pub fn as_window(mut self, clarity: Option<OpticalClarity>) -> Self {
        self.is_window = true;
        match clarity {
            Some(clarity) => self.set_clarity(clarity),
            None => self.opacity = CLEAR_OPACITY,
        }
        self
    }

    /// Returns whether light may pass the body and nobody states how: a window or a layer that is drawn see-through, of a
    /// material of unknown transparency. What needs [`Body::clarity`] must not rely on it then.
    pub fn has_unknown_transparency(&self) -> bool {
        let is_seen_through = self.kind == BodyKind::Cast && self.opacity < 1.0;
        self.optics.is_none() && (self.is_window || is_seen_through)
    }

    /// Returns the optical clarity, by which bodies are drawn; by default a body that is rendered translucent counts as
    /// clear.
    pub fn clarity(&self) -> OpticalClarity {
        self.optics.unwrap_or(if self.opacity < 1.0 {
            OpticalClarity::Clear
        } else {
            OpticalClarity::Opaque
        })
    }
}
