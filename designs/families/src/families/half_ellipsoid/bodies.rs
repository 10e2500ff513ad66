//! What the sensor consists of and is made with, and where bodies stand together.

use crate::assembling::AssemblyName;
pub use crate::blocks::{CAMERA, LED_WIRE};

/// Casting the silicone molds on and in their negatives.
pub const CAST_INNER_CUP: AssemblyName = AssemblyName("cast-cup-inner");
pub const CAST_OUTER_CUP: AssemblyName = AssemblyName("cast-cup-outer");
pub const CAST_BLACK_CUP: AssemblyName = AssemblyName("cast-cup-black");
pub const CAST_CORE: AssemblyName = AssemblyName("cast-core");
/// Casting the layers.
pub const INNER_MOLD: AssemblyName = AssemblyName("inner-mold");
pub const OUTER_MOLD: AssemblyName = AssemblyName("outer-mold");
pub const BLACK_MOLD: AssemblyName = AssemblyName("black-mold");

crate::bodies! {
    pub SHELL "shell" "rigid transparent skeleton that carries the elastomers";
    pub HOLDER "shell-holder"
        "ring that the shell is glued into; comes off with the bolts to change the elastomer";
    pub DIFFUSER "diffusion-ring"
        "spreads the white LEDs' light; lets the UV LEDs' light through holes";
    pub POST "camera-holder" "post that holds the camera above the diffusion ring";
    pub LED_BOARD "led-board" "round circuit board with white and UV LEDs";
    pub BASE "base" "plug that carries camera, board and diffusion ring, and closes the holder";

    pub INNER_NEGATIVE "negative-cup-inner"
        "the silicone mold for the outside of the inner elastomer is cast around it";
    pub OUTER_NEGATIVE "negative-cup-outer"
        "the silicone mold for the outside of the outer elastomer is cast around it";
    pub BLACK_NEGATIVE "negative-cup-black"
        "the silicone mold for the outside of the black gel is cast around it";
    pub CORE_NEGATIVE "negative-core"
        "the silicone core, inner boundary of the inner elastomer, is cast in it";
    pub SLEEVE "casting-sleeve" "holds the silicone around a negative; filled to its rim";

    pub INNER "inner-elastomer"
        "translucent; darkens where it is thinned, glows red under UV light";
    pub OUTER "outer-elastomer"
        "translucent; its pegs in the slots are the markers, blue under UV light";
    pub BLACK "black-gel" "keeps light in, ambient light out, and takes the wear";
    pub CORE "silicone-core"
        "silicone mold: inner boundary of the inner elastomer; closes the other molds";
    pub INNER_CUP "silicone-cup-inner" "silicone mold: outer boundary of the inner elastomer";
    pub OUTER_CUP "silicone-cup-outer" "silicone mold: outer boundary of the outer elastomer";
    pub BLACK_CUP "silicone-cup-black" "silicone mold: outer boundary of the black gel";

    pub WHITE_LED "white-led";
    pub UV_LED "uv-led";
    pub SWITCH "dual-switch";
    pub RESISTOR "led-resistor";
}
