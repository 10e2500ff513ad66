//! Lighting modes of a sensor, and the effect of a touch that its camera sees in each.

use nalgebra::{Point3, Vector3};

use crate::NominalCamera;

/// Relative intensities that the camera records in red, green and blue.
pub type Rgb = [f64; 3];

/// Colourless light.
pub const WHITE: Rgb = [1.0; 3];

/// Lighting mode of a sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct Lighting {
    /// Name by which users select the mode: `[a-z0-9-]`, unique within the sensor.
    pub name: &'static str,
    /// Light sources that are switched on.
    pub light_sources: Vec<LightSourceGroup>,
    /// Effect of a touch that this light makes visible.
    pub effect: VisibleEffect,
    /// Camera that observes the effect, if it is not the sensor's camera.
    pub camera: Option<NominalCamera>,
    /// Body that all light has to pass on its way to the surface, and that spreads it; `None` without a diffuser.
    pub diffuser: Option<String>,
}

/// Light sources that are all placements of one body.
#[derive(Clone, Debug, PartialEq)]
pub struct LightSourceGroup {
    /// Name of the body; [`crate::Body::light_source`] tells which part of it emits light.
    pub body: String,
    /// Colours of the body's placements in the finished sensor, in their order. If there are more placements than
    /// colours, the list starts again.
    pub colors: Vec<Rgb>,
}

/// Effect of a touch that light makes visible. Bodies are given by name.
#[derive(Clone, Debug, PartialEq)]
pub enum VisibleEffect {
    /// Thickness of translucent layers over a black one: thicker layers scatter back more light.
    Thickness {
        /// Layers, from the inside out; all have the same scattering properties.
        layers: Vec<String>,
    },
    /// Surface slopes of a reflective coat, and shadows cast on it.
    Slopes {
        /// Reflective coat.
        coat: String,
        /// Body that the dark markers on the coat are printed in; `None` where markers are bumps of the coat itself.
        printed: Option<String>,
    },
    /// Thickness of fluorescent layers, excited by light that the camera does not see.
    Fluorescence {
        /// Layers from the inside out, with the colour of each.
        layers: Vec<(String, Rgb)>,
    },
    /// Lengths of columns of dyed liquid, in ambient light.
    LiquidColumns {
        /// Body that contains all of the liquid.
        liquid: String,
        /// Columns in the order of the channels that move them.
        columns: Vec<LiquidColumn>,
    },
    /// Positions of light markers on a dark background.
    Markers {
        /// Body that contains all markers.
        marks: String,
    },
}

/// Column of liquid that a channel moves.
#[derive(Clone, Debug, PartialEq)]
pub struct LiquidColumn {
    /// Centre of its end at rest, on the face that the camera observes, sensor frame, mm.
    pub end: Point3<f64>,
    /// Direction in which that end moves while the channel is squeezed: unit vector.
    pub direction: Vector3<f64>,
    /// Width across that direction, in the observed face, mm.
    pub width_mm: f64,
}

impl Lighting {
    /// Creates a lighting mode in which all placements of one body emit colourless light.
    ///
    /// ```
    /// use fabkit_geometry::{Lighting, VisibleEffect};
    /// let coat = VisibleEffect::Slopes { coat: "coat".into(), printed: None };
    /// let mut light = Lighting::from_body("white", "led", coat);
    /// assert!(!light.is_colored());
    /// light.light_sources[0].colors = vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// assert!(light.is_colored());
    /// ```
    pub fn from_body(name: &'static str, lamp: impl Into<String>, effect: VisibleEffect) -> Self {
        let light_sources = vec![LightSourceGroup { body: lamp.into(), colors: vec![WHITE] }];
        Self { name, light_sources, effect, camera: None, diffuser: None }
    }

    /// Names the body that the light passes.
    ///
    /// ```
    /// use fabkit_geometry::{Lighting, VisibleEffect};
    /// let layers = VisibleEffect::Thickness { layers: vec!["gel".into()] };
    /// let light = Lighting::from_body("white", "led", layers).through("diffuser");
    /// assert_eq!(light.diffuser.as_deref(), Some("diffuser"));
    /// ```
    #[must_use]
    pub fn through(self, diffuser: impl Into<String>) -> Self {
        Self { diffuser: Some(diffuser.into()), ..self }
    }

    /// Returns whether the mode makes layers fluoresce.
    pub fn is_fluorescent(&self) -> bool {
        matches!(self.effect, VisibleEffect::Fluorescence { .. })
    }

    /// Returns whether images in this mode have colours.
    pub fn is_colored(&self) -> bool {
        let is_colored = |color: &Rgb| color.iter().any(|part| *part != color[0]);
        self.is_fluorescent()
            || matches!(self.effect, VisibleEffect::LiquidColumns { .. })
            || self.light_sources.iter().any(|group| group.colors.iter().any(is_colored))
    }
}

impl LightSourceGroup {
    /// Returns the colour of a placement of the body, given its index among those in the finished sensor.
    ///
    /// ```
    /// use fabkit_geometry::{LightSourceGroup, WHITE};
    /// let (red, blue) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    /// let ring = LightSourceGroup { body: "led".into(), colors: vec![red, blue] };
    /// assert_eq!([0, 1, 2, 3].map(|placement| ring.color(placement)), [red, blue, red, blue]);
    /// assert_eq!(LightSourceGroup { body: "led".into(), colors: Vec::new() }.color(0), WHITE);
    /// ```
    pub fn color(&self, placement: usize) -> Rgb {
        match self.colors.len() {
            0 => WHITE,
            count => self.colors[placement % count],
        }
    }
}
