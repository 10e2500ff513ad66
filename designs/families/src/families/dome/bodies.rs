//! What the sensor consists of and is made with, and where bodies stand together.

use crate::assembling::AssemblyName;
pub use crate::blocks::{CAMERA, CAMERA_CABLE, LED_WIRE};

/// Casting the transparent gel around the tube.
pub const TRANSPARENT_MOLD: AssemblyName = AssemblyName("transparent-mold");
/// Casting the translucent gel around the transparent one.
pub const TRANSLUCENT_MOLD: AssemblyName = AssemblyName("translucent-mold");
/// Gluing the cured module to its shell.
pub const JOINING: AssemblyName = AssemblyName("joining");
/// Casting the silicone mold of the transparent gel around a glass tube.
pub const INNER_FORM: AssemblyName = AssemblyName("form-transparent-gel");
/// Casting the silicone mold of the translucent gel around a glass tube.
pub const OUTER_FORM: AssemblyName = AssemblyName("form-translucent-gel");
/// Cutting the tube to its length.
pub const CUTTING: AssemblyName = AssemblyName("cutting");
/// Dipping a module into black mixture.
pub const COATING: AssemblyName = AssemblyName("coating");

crate::bodies! {
    pub SHELL "shell" "tube that holds diffuser, LED board and base; the gel stands on it";
    pub BASE "base" "plug that carries the camera and closes the shell";
    pub DIFFUSER "diffuser" "frosted ring that spreads the LEDs' light";
    pub LED_BOARD "led-board" "annular circuit board that carries the LEDs";
    pub BAFFLE "baffle" "black tube that keeps the LEDs' mirror images out of the picture";

    pub INNER_A "mold-transparent-gel-a" "half a of the mold that casts the transparent gel";
    pub INNER_B "mold-transparent-gel-b" "half b of the mold that casts the transparent gel";
    pub INNER_LID "lid-transparent-gel" "centres the tube in the transparent gel mold";
    pub OUTER_A "mold-translucent-gel-a" "half a of the mold that casts the translucent gel";
    pub OUTER_B "mold-translucent-gel-b" "half b of the mold that casts the translucent gel";
    pub OUTER_LID "lid-translucent-gel" "centres the tube in the translucent gel mold";
    pub COLLAR "collar"
        "centres the shell on the module, still in its mold, while the filling gel cures";
    pub CONNECTOR "connector"
        "handle that holds the tube by its inside while gel is cast around it";
    pub FORM_CUP "form-cup"
        "cup that a silicone mold is cast in, and stays in while it is used";
    pub INNER_BRIDGE "form-bridge-transparent-gel"
        "hangs the narrower glass tube into the form's cup; silicone is poured through its windows";
    pub OUTER_BRIDGE "form-bridge-translucent-gel"
        "hangs the wider glass tube into the form's cup; silicone is poured through its windows";
    pub TUBE_JIG "tube-jig" "sleeve whose rim shows where the test tube is cut, square to its axis";
    pub CONTAINER "coating-container" "holds the black mixture";
    pub HOLDER "coating-holder" "hangs a module into the container by its connector";

    pub FILLING_GEL "filling-gel"
        "spreads the LEDs' light and glues the tube to diffuser and shell";
    pub LOCKING_GEL "locking-gel"
        "goes on from the filling gel through the diffuser, out to the shell, and locks all to its ribs and \
         groove";
    pub TRANSPARENT_GEL "transparent-gel" "carries the translucent gel and spreads light";
    pub TRANSLUCENT_GEL "translucent-gel"
        "brightens and darkens with its depth; its thickness is the sensing range";
    pub BLACK_COAT "black-coat" "keeps light in, ambient light out, and takes the wear";
    pub INNER_SILICONE "silicone-mold-transparent-gel"
        "smooth mold for the transparent gel, cast around a glass tube";
    pub OUTER_SILICONE "silicone-mold-translucent-gel"
        "smooth mold for the translucent gel, cast around a wider glass tube";

    pub TUBE "tube";
    pub O_RING "o-ring";
    pub INNER_FORM_TUBE "form-tube-transparent-gel";
    pub OUTER_FORM_TUBE "form-tube-translucent-gel";
}
