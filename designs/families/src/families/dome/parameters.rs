//! Parameters of the dome family, and the names of its bodies.

use fabkit_geometry::{Angle, Length};

use crate::assembling::AssemblyName;
use crate::blocks::board_camera::Board;
use crate::blocks::circuit::Electric;
use crate::blocks::cup_and_bridge::Form;
use crate::blocks::mold::Mold;
use crate::blocks::mounting::Mount;
use crate::blocks::optics::{Module, Pictures, View};
pub use crate::blocks::{CAMERA, CAMERA_CABLE, LED_WIRE};
use crate::materials::Castable;
use crate::parameters::Inline;
use crate::processes::Making;
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
    /// The sensing surface: a hemisphere on a straight wall.
    pub struct Surface {
        /// Radius of the hemisphere and the wall, to the outside of the black coat.
        radius: Length = 8.0..=60.0,
        /// Height of the straight wall below the hemisphere.
        wall_height: Length = 0.0..=60.0,
    }

    /// The rigid transparent test tube that carries the gels.
    pub struct Tube {
        /// Outer diameter.
        outer_diameter: Length = 8.0..=100.0,
        /// Thickness of the glass.
        wall: Length = 0.4..=5.0,
    }

    /// The layer between tube and translucent gel; its thickness is what these two leave.
    pub struct TransparentGel {
        /// Trade name.
        material: Castable,
    }

    /// The layer whose brightness tells its depth.
    pub struct TranslucentGel {
        /// Thickness with the coat: the difference of the two cavities' radii.
        thickness: Length = 0.3..=10.0,
        /// Trade name.
        material: Castable,
    }

    /// The black layer outside.
    pub struct Coat {
        /// Thickness when dry.
        thickness: Length = 0.005..=1.0,
        /// How it is put on: a `spray` into the outer mold, or the module is taken out for a `dip`.
        method: CoatMethod,
        /// Trade name.
        material: Castable,
    }

    /// The gel that fills the tube and glues it to the diffuser and shell.
    pub struct FillingGel {
        /// Trade name.
        material: Castable,
        /// How far the same gel, poured through the diffuser's bore, goes on below the diffuser: out to the
        /// shell and around its ribs, which lock it; 0 for none.
        lock_depth: Length = 0.0..=20.0,
    }

    /// The largest outer dimensions.
    pub struct Envelope {
        /// Across.
        diameter: Length = 10.0..=200.0,
        /// From the base's bottom to the tip.
        height: Length = 10.0..=300.0,
    }

    /// The printed tube that holds diffuser, LED board and base.
    pub struct Shell {
        /// Outer diameter.
        outer_diameter: Length = 12.0..=150.0,
        /// Thickness of the wall.
        wall: Length = 0.8..=10.0,
        /// Radius of its outer edge below the gel; 0 for a sharp one.
        edge_fillet: Length = 0.0..=8.0,
        /// How far its upper rim reaches inwards over the ribs, around a narrower diffuser: it covers what a
        /// tip leaves open that is narrower than the shell; 0 for a straight bore.
        shoulder: Length = 0.0..=60.0,
        /// Number of ribs between diffuser and LED board.
        ribs: u32 = 3..=12,
        /// How far a rib stands out from the wall.
        rib_depth: Length = 0.4..=60.0,
        /// Width of a rib.
        rib_width: Length = 0.8..=10.0,
        /// Depth of a groove in the bore, below the diffuser, that the filling gel flows into; 0 for none.
        lock_groove: Length = 0.0..=3.0,
        /// Number of M2x4 screws that join shell and base.
        screws: u32 = 2..=8,
        /// Material.
        material: String = 1..=80,
    }

    /// The frosted ring above the LEDs.
    pub struct Diffuser {
        /// Thickness of the sheet.
        thickness: Length = 0.5..=6.0,
        /// Radius of the bore the camera looks through.
        bore_radius: Length = 2.0..=60.0,
        /// Radius the notches in the bore reach.
        notch_radius: Length = 2.0..=60.0,
        /// Number of notches.
        notches: u32 = 2..=16,
        /// Width of a notch.
        notch_width: Length = 0.5..=10.0,
        /// Distance from the LED board's top to the diffuser's bottom.
        height_above_board: Length = 1.0..=60.0,
        /// Material.
        material: String = 1..=80,
    }

    /// A black tube in the LED board's bore: it keeps the LEDs' mirror images in the gel's flat face out
    /// of the picture.
    pub struct Baffle {
        /// Thickness of its wall; 0 for no baffle.
        wall: Length = 0.0..=3.0,
        /// What it keeps off the gel above it.
        gap: Length = 0.1..=5.0,
    }

    /// The annular board that carries the LEDs.
    pub struct LedBoard {
        /// Thickness.
        thickness: Length = 0.4..=3.2,
        /// Radius of the bore the lens passes through.
        bore_radius: Length = 2.0..=60.0,
        /// Diameter of the two holes for wires.
        wire_hole_diameter: Length = 0.4..=3.0,
        /// Material.
        material: String = 1..=80,
    }

    /// The LEDs.
    pub struct Leds {
        /// How many.
        count: u32 = 3..=32,
        /// Radius of the circle of their centres.
        circle_radius: Length = 3.0..=70.0,
        /// Length of the package, along the circle.
        length: Length = 0.5..=6.0,
        /// Width of the package, along the radius.
        width: Length = 0.5..=6.0,
        /// Height of the package.
        height: Length = 0.2..=4.0,
        /// Type.
        model: String = 1..=80,
        /// Their electricity.
        electric: Inline<Electric>,
    }

    /// The camera and the board it comes on.
    pub struct Camera {
        /// Which it is.
        module: Inline<Module>,
        /// Its pictures.
        pictures: Inline<Pictures>,
        /// Quality of the JPEG in which it sends pictures, as encoders count it; 0 for none.
        jpeg_quality: u32 = 0..=100,
        /// What its lens sees.
        view: Inline<View>,
        /// Distance of the optical centre below the sensing surface's foot.
        depth: Length = 0.0..=100.0,
        /// Its board and lens.
        board: Inline<Board>,
        /// Room behind the board for connector and parts.
        back_clearance: Length = 0.5..=10.0,
    }

    /// The camera's cable and the wires of the LEDs.
    pub struct Cables {
        /// Diameter of the camera's cable.
        diameter: Length = 0.8..=8.0,
        /// Edge of the plug on the cable's free end, across.
        plug_width: Length = 1.0..=20.0,
        /// Edge of that plug, the other way across.
        plug_height: Length = 1.0..=20.0,
        /// Length of that plug.
        plug_length: Length = 1.0..=30.0,
        /// Diameter of a wire of the LEDs, over its insulation.
        wire_diameter: Length = 0.4..=3.0,
        /// Radius to which such a wire is bent, to its middle.
        wire_bend: Length = 0.5..=20.0,
    }

    /// The printed plug that closes the shell and carries the camera.
    pub struct Base {
        /// Height.
        height: Length = 4.0..=60.0,
        /// Length of the slot for the cable.
        cable_slot_length: Length = 1.0..=20.0,
        /// Width of the slot for the cable.
        cable_slot_width: Length = 1.0..=20.0,
        /// Turn of the slot for the cable: it lies along x at 0, along y at 90 degrees.
        cable_angle: Angle = -180.0..=180.0,
        /// Where cable and wires leave: `floor`, through a slot in the face that is mounted, or `side`,
        /// through a slit in base and shell beside it.
        cable_exit: CableExit,
        /// Direction in which they leave by the side, from +x.
        exit_angle: Angle = -180.0..=180.0,
        /// Number of holes in the bottom for mounting, on a ring.
        mount_holes: u32 = 2..=6,
        /// Radius of the circle of the mounting holes.
        mount_radius: Length = 2.0..=70.0,
    }

    /// How the gels are cast.
    pub struct Molds {
        /// In what: `silicone`, cast around glass tubes as the paper does, or `printed` halves.
        route: MoldRoute,
    }

    /// The handle that holds the tube by its inside while gel is cast around it.
    pub struct Connector {
        /// How far the plug reaches into the tube.
        plug_length: Length = 2.0..=40.0,
        /// Diameter of the cord of the O-ring around the plug.
        o_ring_cord: Length = 1.0..=4.0,
        /// How much of the cord is squeezed.
        o_ring_squeeze: f64 = 0.1..=0.3,
        /// Diameter of the handle.
        handle_diameter: Length = 4.0..=40.0,
        /// Length of the handle.
        handle_length: Length = 5.0..=80.0,
        /// Diameter of the air channel.
        air_channel_diameter: Length = 1.0..=8.0,
    }

    /// The container for black mixture and the holder that hangs a sensor into it.
    pub struct Coating {
        /// Gap between sensing surface and container.
        gap: Length = 1.0..=40.0,
        /// Thickness of walls, floor and holder.
        wall: Length = 1.2..=10.0,
    }

    /// A dome sensor.
    pub struct Dome {
        /// The sensing surface.
        surface: Surface,
        /// The rigid transparent tube.
        tube: Tube,
        /// The filling gel.
        filling_gel: FillingGel,
        /// The transparent gel.
        transparent_gel: TransparentGel,
        /// The translucent gel.
        translucent_gel: TranslucentGel,
        /// The black coat.
        coat: Coat,
        /// The outer dimensions.
        envelope: Envelope,
        /// The shell.
        shell: Shell,
        /// The diffuser.
        diffuser: Diffuser,
        /// The baffle.
        baffle: Baffle,
        /// The LED board.
        led_board: LedBoard,
        /// The LEDs.
        leds: Leds,
        /// The camera.
        camera: Camera,
        /// The cables.
        cables: Cables,
        /// The base.
        base: Base,
        /// The holes that it is mounted by.
        mount: Mount,
        /// How the gels are cast.
        molds: Molds,
        /// The molds' sizes.
        mold: Mold,
        /// The connector.
        connector: Connector,
        /// The silicone form.
        form: Form,
        /// The coating tools.
        coating: Coating,
        /// Which parts are made how.
        making: Making,
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
