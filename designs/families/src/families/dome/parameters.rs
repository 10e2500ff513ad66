//! Parameters of the dome family, and the names of its bodies.

use fabkit_geometry::{Angle, Length};

use crate::blocks::board_camera::Board;
use crate::blocks::circuit::Electric;
use crate::blocks::cup_and_bridge::Form;
use crate::blocks::mold::Mold;
use crate::blocks::mounting::Mount;
use crate::blocks::optics::{ImageFormat, Module, View};
pub use crate::blocks::{CAMERA, CAMERA_CABLE, LED_WIRE};
use crate::chain_builder::AssemblyName;
use crate::materials::Castable;
use crate::parameters::Inline;
use crate::processes::ProcessAssignments;
use crate::{choices, sections};

choices! {
    /// Place where the cables leave the sensor.
    pub enum CableExit {
        /// Through the floor, by which the sensor is mounted.
        Floor = "floor",
        /// Through the side.
        Side = "side",
    }
}

choices! {
    /// Kind of mold in which the two gels are cast.
    pub enum MoldRoute {
        /// Silicone molds, cast around glass tubes: smooth and without a seam.
        Silicone = "silicone",
        /// Printed halves: quick, with a seam over the tip.
        Printed = "printed",
    }
}

choices! {
    /// Method by which the coat is applied.
    pub enum CoatMethod {
        /// The coat is sprayed into the mold.
        Spray = "spray",
        /// The module is dipped into the mixture.
        Dip = "dip",
    }
}

sections! {
    /// Sensing surface: a hemisphere on a straight wall.
    pub struct Surface {
        /// Outer radius of hemisphere and wall, including the black coat.
        radius: Length = 8.0..=60.0,
        /// Height of the straight wall below the hemisphere.
        wall_height: Length = 0.0..=60.0,
    }

    /// Rigid transparent test tube that carries the gels.
    pub struct Tube {
        /// Outer diameter of the tube.
        outer_diameter: Length = 8.0..=100.0,
        /// Thickness of the tube's glass.
        wall: Length = 0.4..=5.0,
    }

    /// Gel layer between tube and translucent gel. Its thickness follows from theirs.
    pub struct TransparentGel {
        /// Trade name of the transparent gel.
        material: Castable,
    }

    /// Gel layer whose brightness depends on its depth.
    pub struct TranslucentGel {
        /// Thickness of the layer including the coat: the difference between the radii of the two cavities.
        thickness: Length = 0.3..=10.0,
        /// Trade name of the translucent gel.
        material: Castable,
    }

    /// Black layer on the outside.
    pub struct Coat {
        /// Thickness of the coat when dry.
        thickness: Length = 0.005..=1.0,
        /// Method of coating: a `spray` into the outer mold, or a `dip` of the module, taken out of it.
        method: CoatMethod,
        /// Trade name of the coat.
        material: Castable,
    }

    /// Gel that fills the tube and glues it to diffuser and shell.
    pub struct FillingGel {
        /// Trade name of the filling gel.
        material: Castable,
        /// Depth to which the same gel, poured through the diffuser's bore, continues below the diffuser, out to the
        /// shell and around its ribs, which lock it; 0 for none.
        lock_depth: Length = 0.0..=20.0,
    }

    /// Largest outer dimensions allowed.
    pub struct Envelope {
        /// Largest outer diameter.
        diameter: Length = 10.0..=200.0,
        /// Largest height, from the base's bottom to the tip.
        height: Length = 10.0..=300.0,
    }

    /// Printed tube that holds diffuser, LED board and base.
    pub struct Shell {
        /// Outer diameter of the shell.
        outer_diameter: Length = 12.0..=150.0,
        /// Thickness of the shell's wall.
        wall: Length = 0.8..=10.0,
        /// Radius of the shell's outer edge below the gel; 0 for a sharp edge.
        edge_fillet: Length = 0.0..=8.0,
        /// Width by which the shell's upper rim reaches inwards over the ribs, around a narrower diffuser. It covers
        /// the gap of a tip that is narrower than the shell; 0 for a straight bore.
        shoulder: Length = 0.0..=60.0,
        /// Number of ribs between diffuser and LED board.
        ribs: u32 = 3..=12,
        /// Radial depth of a rib.
        rib_depth: Length = 0.4..=60.0,
        /// Width of a rib.
        rib_width: Length = 0.8..=10.0,
        /// Depth of a groove in the shell's bore, below the diffuser, into which the filling gel flows; 0 for none.
        lock_groove: Length = 0.0..=3.0,
        /// Number of M2x4 screws that join shell and base.
        screws: u32 = 2..=8,
        /// Material of the shell.
        material: String = 1..=80,
    }

    /// Frosted ring above the LEDs.
    pub struct Diffuser {
        /// Thickness of the sheet from which the diffuser is cut.
        thickness: Length = 0.5..=6.0,
        /// Radius of the bore through which the camera looks.
        bore_radius: Length = 2.0..=60.0,
        /// Distance from the axis to which the notches in the bore reach.
        notch_radius: Length = 2.0..=60.0,
        /// Number of notches in the bore.
        notches: u32 = 2..=16,
        /// Width of a notch.
        notch_width: Length = 0.5..=10.0,
        /// Distance from the LED board's top to the diffuser's bottom.
        height_above_board: Length = 1.0..=60.0,
        /// Material of the diffuser.
        material: String = 1..=80,
    }

    /// Black tube in the LED board's bore, which keeps reflections of the LEDs in the gel's flat face out of the image.
    pub struct Baffle {
        /// Thickness of the baffle's wall; 0 for no baffle.
        wall: Length = 0.0..=3.0,
        /// Gap between the baffle and the gel above it.
        gap: Length = 0.1..=5.0,
    }

    /// Annular circuit board that carries the LEDs.
    pub struct LedBoard {
        /// Thickness of the LED board.
        thickness: Length = 0.4..=3.2,
        /// Radius of the bore through which the camera's lens passes.
        bore_radius: Length = 2.0..=60.0,
        /// Diameter of the two holes for the wires.
        wire_hole_diameter: Length = 0.4..=3.0,
        /// Material of the LED board.
        material: String = 1..=80,
    }

    /// LEDs on the annular board.
    pub struct Leds {
        /// Number of LEDs.
        count: u32 = 3..=32,
        /// Radius of the circle on which the LEDs' centres lie.
        circle_radius: Length = 3.0..=70.0,
        /// Length of an LED's package, along the circle.
        length: Length = 0.5..=6.0,
        /// Width of an LED's package, along the radius.
        width: Length = 0.5..=6.0,
        /// Height of an LED's package.
        height: Length = 0.2..=4.0,
        /// Type of LED to buy.
        model: String = 1..=80,
        /// Electrical data of the LEDs.
        electric: Inline<Electric>,
    }

    /// Camera with its board.
    pub struct Camera {
        /// Camera module.
        module: Inline<Module>,
        /// Images of the camera.
        images: Inline<ImageFormat>,
        /// Quality of the JPEG images that the camera sends, on the scale of JPEG encoders; 0 if it does not send JPEG.
        jpeg_quality: u32 = 0..=100,
        /// View of the camera's lens.
        view: Inline<View>,
        /// Distance of the lens's optical centre below the sensing surface's foot.
        depth: Length = 0.0..=100.0,
        /// Board and lens of the camera.
        board: Inline<Board>,
        /// Free height behind the camera board for its connector and components.
        back_clearance: Length = 0.5..=10.0,
    }

    /// Cable of the camera and wires of the LEDs.
    pub struct Cables {
        /// Diameter of the camera's cable.
        diameter: Length = 0.8..=8.0,
        /// Width of the plug on the cable's free end.
        plug_width: Length = 1.0..=20.0,
        /// Height of that plug.
        plug_height: Length = 1.0..=20.0,
        /// Length of that plug.
        plug_length: Length = 1.0..=30.0,
        /// Diameter of an LED's wire over its insulation.
        wire_diameter: Length = 0.4..=3.0,
        /// Bending radius of such a wire, to its middle.
        wire_bend: Length = 0.5..=20.0,
    }

    /// Printed plug that closes the shell and carries the camera.
    pub struct Base {
        /// Height of the base.
        height: Length = 4.0..=60.0,
        /// Length of the slot for the cable.
        cable_slot_length: Length = 1.0..=20.0,
        /// Width of the slot for the cable.
        cable_slot_width: Length = 1.0..=20.0,
        /// Direction of the slot for the cable: it lies along x at 0, along y at 90 degrees.
        cable_angle: Angle = -180.0..=180.0,
        /// Exit of cable and wires: `floor`, through a slot in the face by which the sensor is mounted, or `side`,
        /// through a slit in base and shell.
        cable_exit: CableExit,
        /// Direction in which they leave through the side, from +x.
        exit_angle: Angle = -180.0..=180.0,
        /// Number of mounting holes in the bottom, on a circle.
        mount_holes: u32 = 2..=6,
        /// Radius of the circle on which the mounting holes lie.
        mount_radius: Length = 2.0..=70.0,
    }

    /// Casting of the gels.
    pub struct Molds {
        /// Kind of mold: `silicone`, cast around glass tubes as in the paper, or `printed` halves.
        route: MoldRoute,
    }

    /// Handle that holds the tube by its inside while gel is cast around it.
    pub struct Connector {
        /// Length of the plug inside the tube.
        plug_length: Length = 2.0..=40.0,
        /// Diameter of the cord of the O-ring around the plug.
        o_ring_cord: Length = 1.0..=4.0,
        /// Fraction of the cord's diameter by which the O-ring is squeezed.
        o_ring_squeeze: f64 = 0.1..=0.3,
        /// Diameter of the handle.
        handle_diameter: Length = 4.0..=40.0,
        /// Length of the handle.
        handle_length: Length = 5.0..=80.0,
        /// Diameter of the air channel.
        air_channel_diameter: Length = 1.0..=8.0,
    }

    /// Container for the black mixture, and holder that hangs a sensor into it.
    pub struct Coating {
        /// Gap between the sensing surface and the container.
        gap: Length = 1.0..=40.0,
        /// Thickness of the walls and the floor of the container, and of the holder.
        wall: Length = 1.2..=10.0,
    }

    /// Parameters of a dome sensor.
    pub struct Dome {
        /// Sensing surface: a hemisphere on a straight wall.
        surface: Surface,
        /// Rigid transparent test tube that carries the gels.
        tube: Tube,
        /// Gel that fills the tube and glues it to diffuser and shell.
        filling_gel: FillingGel,
        /// Gel layer between tube and translucent gel. Its thickness follows from theirs.
        transparent_gel: TransparentGel,
        /// Gel layer whose brightness depends on its depth.
        translucent_gel: TranslucentGel,
        /// Black layer on the outside.
        coat: Coat,
        /// Largest outer dimensions allowed.
        envelope: Envelope,
        /// Printed tube that holds diffuser, LED board and base.
        shell: Shell,
        /// Frosted ring above the LEDs.
        diffuser: Diffuser,
        /// Black tube in the LED board's bore, which keeps reflections of the LEDs in the gel's flat face out of the
        /// image.
        baffle: Baffle,
        /// Annular circuit board that carries the LEDs.
        led_board: LedBoard,
        /// LEDs on the annular board.
        leds: Leds,
        /// Camera with its board.
        camera: Camera,
        /// Cable of the camera and wires of the LEDs.
        cables: Cables,
        /// Printed plug that closes the shell and carries the camera.
        base: Base,
        /// Holes by which the sensor is mounted.
        mount: Mount,
        /// Casting of the gels.
        molds: Molds,
        /// Dimensions and material of the two-piece molds for the gels.
        mold: Mold,
        /// Handle that holds the tube by its inside while gel is cast around it.
        connector: Connector,
        /// Cup and bridge with which a silicone mold is cast around a glass tube.
        form: Form,
        /// Container for the black mixture, and holder that hangs a sensor into it.
        coating: Coating,
        /// Processes by which the parts are made.
        making: ProcessAssignments,
    }
}

// ------ Bodies ------
//
// Bodies of the sensor and of its tools, and the assemblies in which they stand together.

/// Assembly that casts the transparent gel around the tube.
pub const TRANSPARENT_MOLD: AssemblyName = AssemblyName("transparent-mold");
/// Assembly that casts the translucent gel around the transparent one.
pub const TRANSLUCENT_MOLD: AssemblyName = AssemblyName("translucent-mold");
/// Assembly that glues the cured module to its shell.
pub const JOINING: AssemblyName = AssemblyName("joining");
/// Assembly that casts the silicone mold of the transparent gel around a glass tube.
pub const INNER_FORM: AssemblyName = AssemblyName("form-transparent-gel");
/// Assembly that casts the silicone mold of the translucent gel around a glass tube.
pub const OUTER_FORM: AssemblyName = AssemblyName("form-translucent-gel");
/// Assembly that cuts the tube to its length.
pub const CUTTING: AssemblyName = AssemblyName("cutting");
/// Assembly that dips a module into the black mixture.
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
