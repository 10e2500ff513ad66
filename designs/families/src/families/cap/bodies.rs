//! What the sensor consists of and is made with, and where bodies stand together.

use crate::assembling::AssemblyName;
pub use crate::blocks::{CAMERA, CAMERA_CABLE};

/// Casting the skin.
pub const SKIN_MOLD: AssemblyName = AssemblyName("skin-mold");

crate::bodies! {
    pub PLATE "plate" "clear plate that carries the skin";
    pub HOLDER "holder" "casing's upper piece: holds plate, LEDs and the camera's front";
    pub BASE "base" "casing's lower piece: clamps the camera, is screwed to a gripper";
    pub BLOCK "mold-skin-block" "cavity of the skin, with the dimples' pins";
    pub SPACER "mold-skin-spacer"
        "sets the height of the lid; its notches let surplus out and a screwdriver in";
    pub LID "mold-skin-lid" "closes the mold; the skin's flat foot forms on its boss";
    pub SKIN "skin";
    pub PAINT "reflective-paint";
}
