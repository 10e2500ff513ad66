//! What the sensor consists of and is made with, and where bodies stand together.

use super::channels::Side;
use crate::assembling::{AssemblyName, Name};
pub use crate::blocks::CAMERA;

/// The stack that casts the layer with the channels.
pub const CHANNEL_MOLD: AssemblyName = AssemblyName("channel-mold");
/// The stack that casts the layer with the markers.
pub const MARKER_MOLD: AssemblyName = AssemblyName("marker-mold");
/// The box's floor with its camera, before walls are around it.
pub const BOX_FOCUSING: AssemblyName = AssemblyName("box-focusing");

crate::bodies! {
    pub MOLD_FLOOR "mold-floor" "closes a stack from below";
    pub CHANNEL_COMB "mold-channel-comb" "its fingers leave the channels in the silicone";
    pub CHANNEL_FRAME "mold-channel-frame" "frame around the silicone above the channels";
    pub MARKER_PLATE "mold-marker-plate" "its holes shape the markers";
    pub MARKER_FRAME "mold-marker-frame"
        "frame around the marker layer: in its mold, and again in the sensor";

    pub BOX_CEILING "box-ceiling" "carries the interface around its window";
    pub BOX_FLOOR "box-floor" "carries the camera";
    pub CABLE_WALL "box-wall-cable" "wall with the way out for the camera's and the LEDs' cables";
    pub BOX_WALL "box-wall" "wall; its fingers mesh with those of its neighbours";
    pub CLAMP_BAR "clamp-bar" "holds the interface down on the box";
    pub DISPLAY_BACK "display-back" "white sheet behind the channels";
    pub DISPLAY_CHANNELS "display-channels"
        "one straight channel for each of the interface's";
    pub DISPLAY_COVER "display-cover" "closes the channels; needles stand in its holes at one end, air leaves at the other";
    pub DISPLAY_SEAL "display-seal"
        "strip that closes the vents at the channels' far ends once they are filled";
    pub STAND_PLATE "stand-plate" "carries the camera that sees the display";

    pub MARKER_PAINT "marker-paint" "white ends of the markers, which the camera tracks";
    pub MARKER_LAYER "marker-layer"
        "dark layer with markers on its underside; closes the channels from below";
    pub CHANNEL_LAYER "channel-layer"
        "clear layer that is touched, with the channels on its underside";
    LEFT_GLUE "tube-glue-left" "seals the tubes in their channels";
    RIGHT_GLUE "tube-glue-right" "seals the tubes in their channels";
    LEFT_LIQUID "liquid-left" "coloured water in the channels that enter from this side";
    RIGHT_LIQUID "liquid-right" "coloured water in the channels that enter from this side";
    pub DISPLAY_LIQUID "liquid-display" "coloured water in the display while nothing is touched";

    pub BOX_CABLE "box-camera-cable";
    pub STAND_CABLE "stand-camera-cable";
    pub CAMERA_SPACER "spacer-m2";
    pub BOX_SPACER "box-spacer";
    pub STAND_SPACER "stand-spacer";
    pub TUBE "tube";
    pub NEEDLE "needle";
    pub LED_STRIP "led-strip";
}

impl Side {
    /// Around the tubes of this side.
    pub fn glue(self) -> Name {
        match self {
            Self::Left => LEFT_GLUE,
            Self::Right => RIGHT_GLUE,
        }
    }

    /// In the channels of this side.
    pub fn liquid(self) -> Name {
        match self {
            Self::Left => LEFT_LIQUID,
            Self::Right => RIGHT_LIQUID,
        }
    }
}
