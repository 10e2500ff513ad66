//! How sensors are lit.

use fabkit_geometry::{LampGroup, Lighting, Rgb, Shows};

use super::LED;
use crate::assembling::Name;

/// What a camera's red, green and blue record of a red, a green and a blue LED. Chosen: LEDs are 20 to 40 nm wide, the
/// filters of chips overlap by a tenth to a fifth.
pub const RED_GREEN_BLUE: [Rgb; 3] = [[1.0, 0.10, 0.03], [0.12, 1.0, 0.15], [0.03, 0.18, 1.0]];

/// The layers' thickness, in the light of the LEDs.
pub fn thickness<const N: usize>(layers: [Name; N]) -> Lighting {
    Lighting::by("white", LED, Shows::Thickness { layers: layers.map(String::from).to_vec() })
}

/// Which way a coat looks, by the colours of the LEDs one after the other.
pub fn slopes(
    coat: Name,
    printed: Option<Name>,
    colors: impl IntoIterator<Item = Rgb>,
) -> Lighting {
    Lighting {
        name: "colored",
        lamps: vec![LampGroup { body: LED.into(), colors: colors.into_iter().collect() }],
        shows: Shows::Slopes { coat: coat.into(), printed: printed.map(String::from) },
        camera: None,
    }
}

/// Where marks are, in the light of some lamps.
pub fn places(marks: Name, lamp: Name) -> Lighting {
    Lighting::by("white", lamp, Shows::Marks { marks: marks.into() })
}
