//! What the sensor consists of and is made with, and where bodies stand together.

use crate::assembling::{AssemblyName, Name};
pub use crate::blocks::{CAMERA, CAMERA_CABLE};

/// Filling the tip with gel, tip down: the sensor's frame turned over, so that up is +z.
pub const FILLING: AssemblyName = AssemblyName("filling");

/// Focusing the lens, before the camera's board is screwed into the body.
pub const FOCUSING: AssemblyName = AssemblyName("focusing");

/// The printed tip, in one piece.
pub const TIP: [Name; 3] = [SKIN, DOTS, RING];

crate::bodies! {
    pub SKIN "skin" "soft hemisphere with a pin for each dot";
    pub DOTS "dots" "white ends of the pins, which the camera sees";
    pub RING "ring" "rigid ring that holds the lens and locks onto the body";
    pub LENS "lens" "flat window that closes the tip; gel is filled through its holes";
    pub LED_BOARD "led-board" "annular circuit board that carries the LEDs";
    pub BODY "body" "shaft between tip and camera; locks the tip, houses LEDs and camera";
    pub ROBOT_MOUNT "robot-mount" "flange that is bolted to the robot; the body locks onto it";
    pub FOCUS_GAUGE "focus-gauge"
        "holds a target as far from the lens as the dots will be, while the lens is turned";
    pub CONTROLLER_HOLDER "controller-holder"
        "glued to the housing; the microcontroller's board lies in it";
    pub GEL "gel" "clear filling that springs the skin back";
    pub O_RING "o-ring";
    pub CONTROLLER "controller";
    pub CABLE_TIE "cable-tie";
}
