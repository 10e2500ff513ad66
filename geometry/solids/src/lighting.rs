//! The ways in which a sensor is lit, and what its camera sees of a touch by that light.

use nalgebra::{Point3, Vector3};

use crate::NominalCamera;

/// Light as the camera's red, green and blue record it, relative to each other.
pub type Rgb = [f64; 3];

/// Light without a colour.
pub const WHITE: Rgb = [1.0; 3];

/// One way in which a sensor is lit.
#[derive(Clone, Debug, PartialEq)]
pub struct Lighting {
    /// What people say to have it: `[a-z0-9-]`, unique within the sensor.
    pub name: &'static str,
    /// What is switched on for it.
    pub lamps: Vec<LampGroup>,
    /// What it shows.
    pub shows: Shows,
    /// What looks at that, if it is not the sensor's camera.
    pub camera: Option<NominalCamera>,
}

/// Lamps that are all placements of one body.
#[derive(Clone, Debug, PartialEq)]
pub struct LampGroup {
    /// The body, by name; it says what of it shines.
    pub body: String,
    /// The colour of each of its placements in the finished sensor, in their order; where there are more, again from the
    /// first.
    pub colors: Vec<Rgb>,
}

/// What light shows of a touch. Bodies by name.
#[derive(Clone, Debug, PartialEq)]
pub enum Shows {
    /// How thick translucent layers over a black one are: they send back the more light.
    Thickness {
        /// The layers, from the inside out; all scatter alike.
        layers: Vec<String>,
    },
    /// Which way a reflective coat looks, and what casts shadows on it.
    Slopes {
        /// The coat.
        coat: String,
        /// What dark marks on it are drawn in; nothing where marks are of the coat itself and stand out of it.
        printed: Option<String>,
    },
    /// How thick layers are that glow in a light that is not seen itself.
    Glow {
        /// From the inside out, with the colour of each.
        layers: Vec<(String, Rgb)>,
    },
    /// How far columns of dyed liquid reach, in the light of the room.
    Columns {
        /// The liquid, all of it.
        liquid: String,
        /// In the order of the channels that move them.
        columns: Vec<Column>,
    },
    /// Where light marks are on a dark ground.
    Marks {
        /// What they are drawn in, all of them.
        marks: String,
    },
}

/// A column of liquid that a channel moves.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// The middle of its end at rest, on the face that is looked at, sensor frame, mm.
    pub end: Point3<f64>,
    /// The way in which that moves while the channel is squeezed, unit.
    pub way: Vector3<f64>,
    /// Across that, in the face that is looked at, mm.
    pub width_mm: f64,
}

impl Lighting {
    /// By all placements of a body, whose light has no colour that is seen.
    pub fn by(name: &'static str, lamp: impl Into<String>, shows: Shows) -> Self {
        let lamps = vec![LampGroup { body: lamp.into(), colors: vec![WHITE] }];
        Self { name, lamps, shows, camera: None }
    }

    /// Whether it makes layers glow.
    pub fn glows(&self) -> bool {
        matches!(self.shows, Shows::Glow { .. })
    }

    /// Whether a picture has colours.
    pub fn is_colored(&self) -> bool {
        let is_colored = |color: &Rgb| color.iter().any(|part| *part != color[0]);
        self.glows()
            || matches!(self.shows, Shows::Columns { .. })
            || self.lamps.iter().any(|group| group.colors.iter().any(is_colored))
    }
}

impl LampGroup {
    /// Of a placement of the body, by its number among those in the finished sensor.
    pub fn color(&self, placement: usize) -> Rgb {
        match self.colors.len() {
            0 => WHITE,
            count => self.colors[placement % count],
        }
    }
}
