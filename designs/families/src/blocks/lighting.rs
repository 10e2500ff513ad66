//! Lighting of sensors: which bodies shine, in which colours, and what the camera measures in that light.

use fabkit_geometry::{LightSourceGroup, Lighting, Rgb, VisibleEffect};

use super::LED;
use crate::chain_builder::Name;

/// Response of a camera's red, green and blue channel to a red, a green and a blue LED. Chosen: LEDs are 20 to 40 nm
/// wide, the filters of chips overlap by a tenth to a fifth.
pub const RED_GREEN_BLUE: [Rgb; 3] = [[1.0, 0.10, 0.03], [0.12, 1.0, 0.15], [0.03, 0.18, 1.0]];

/// Returns a lighting by the LEDs that shows the thickness of layers.
pub fn thickness_lighting<const N: usize>(layers: [Name; N]) -> Lighting {
    Lighting::from_body(
        "white",
        LED,
        VisibleEffect::Thickness { layers: layers.map(String::from).to_vec() },
    )
}

/// Returns a lighting that shows the slope of a coat, by LEDs whose colours alternate in the given order.
pub fn slope_lighting(
    coat: Name,
    printed: Option<Name>,
    colors: impl IntoIterator<Item = Rgb>,
) -> Lighting {
    Lighting {
        name: "colored",
        light_sources: vec![LightSourceGroup {
            body: LED.into(),
            colors: colors.into_iter().collect(),
        }],
        effect: VisibleEffect::Slopes { coat: coat.into(), printed: printed.map(String::from) },
        camera: None,
        diffuser: None,
    }
}

/// Returns a lighting by the body `lamp` that shows the positions of markers.
pub fn marker_lighting(marks: Name, lamp: Name) -> Lighting {
    Lighting::from_body("white", lamp, VisibleEffect::Markers { marks: marks.into() })
}
