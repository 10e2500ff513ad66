//! Parameters of the pin-tip family, and the names of its bodies.

use fabkit_geometry::{Angle, Length};

use crate::assembling::{AssemblyName, Name};
use crate::blocks::bayonet::Bayonet;
use crate::blocks::circuit::Electric;
use crate::blocks::marks::{Listed, RoundPattern};
use crate::blocks::optics::{Module, Optics};
pub use crate::blocks::{CAMERA, CAMERA_CABLE};
use crate::materials::Castable;
use crate::parameters::Inline;
use crate::processes::Making;
use crate::{choices, sections};

choices! {
    /// Diameter and spacing of the pins, as in the paper's figure 2 and section III-D.
    pub enum PinLayout {
        /// Tip-A: diameter 1 mm, spacing 3 mm.
        A = "A",
        /// Tip-B: diameter 1 mm, spacing 4 mm.
        B = "B",
        /// Tip-C: diameter 1 mm, spacing 4.5 mm.
        C = "C",
        /// Tip-D: diameter 1.7 mm, spacing 4.5 mm.
        D = "D",
        /// Diameter and spacing given by `pins.diameter` and `pins.spacing`.
        Free = "free",
    }
}

choices! {
    /// Place of the microcontroller's board.
    pub enum ControllerSeat {
        /// In a holder that is glued to the outside of the housing.
        Housing = "housing",
        /// Elsewhere, on a cable that the user provides.
        None = "none",
    }
}

sections! {
    /// The printed tip: skin, pins with dots, and ring.
    pub struct Tip {
        /// Outer diameter of hemisphere and ring.
        diameter: Length = 20.0..=80.0,
        /// What skin and pins are printed from.
        soft_material: String = 1..=80,
        /// What ring and dots are printed from.
        rigid_material: String = 1..=80,
    }

    /// The soft hemisphere that touches things.
    pub struct Skin {
        /// Thickness.
        thickness: Length = 0.5..=4.0,
        /// How far the skin reaches down around the ring, so that the bond is loaded in shear.
        skirt_height: Length = 0.5..=5.0,
        /// Thickness of the ring inside that skirt.
        upstand: Length = 0.3..=2.0,
    }

    /// The pins on the skin's inside, each along the local normal.
    pub struct Pins {
        /// Which of the paper's layouts, or a free one.
        layout: PinLayout,
        /// Diameter; counts in the layout `free` only.
        diameter: Length = 0.4..=5.0,
        /// How they lie: `rings` around the apex, or a `list` of places `polar` and `azimuth`; of the
        /// layout the diameter counts then.
        pattern: RoundPattern,
        /// List: angle of each pin from the apex, at the hemisphere's centre.
        polar: Vec<Angle> = (1..=1000, 0.0..=90.0),
        /// List: angle of each pin around the axis, from +x towards +y.
        azimuth: Vec<Angle> = (1..=1000, -360.0..=360.0),
        /// Distance of neighbouring circles, and of pins on one, along the skin's inside; counts in
        /// the layout `free` only.
        spacing: Length = 1.0..=15.0,
        /// Rings: farthest circle of pins from the apex, along the skin's inside.
        reach: Length = 0.0..=120.0,
        /// Length of the soft pin.
        length: Length = 0.3..=8.0,
        /// Thickness of the white dot on its end.
        dot_thickness: Length = 0.1..=3.0,
    }

    /// The clear gel between skin and lens.
    pub struct Fill {
        /// Distance of the lens below the hemisphere's foot.
        depth: Length = 0.5..=20.0,
        /// Trade name.
        material: Castable,
    }

    /// The flat window that closes the tip.
    pub struct Lens {
        /// Thickness of the sheet.
        thickness: Length = 0.8..=6.0,
        /// Width of the ledge that it is glued to.
        ledge: Length = 0.3..=5.0,
        /// Diameter of the two holes that gel is filled through and air leaves by.
        hole_diameter: Length = 0.8..=5.0,
        /// Radius of the circle of their centres.
        hole_radius: Length = 2.0..=38.0,
        /// Material.
        material: String = 1..=80,
    }

    /// The O-ring between body and lens, which keeps light out and the bayonet from turning.
    pub struct Seal {
        /// Diameter of the cord.
        cord: Length = 0.6..=3.0,
        /// How much of the cord is squeezed.
        squeeze: f64 = 0.1..=0.3,
    }

    /// The annular board with the LEDs, below the lens.
    pub struct LedBoard {
        /// Thickness.
        thickness: Length = 0.4..=3.2,
        /// Radius of the bore the camera looks through.
        bore_radius: Length = 2.0..=35.0,
        /// Material.
        material: String = 1..=80,
    }

    /// The LEDs.
    pub struct Leds {
        /// How many.
        count: u32 = 3..=32,
        /// Radius of the circle of their centres.
        circle_radius: Length = 3.0..=38.0,
        /// Length of the package, along the circle.
        length: Length = 0.5..=6.0,
        /// Width of the package, along the radius.
        width: Length = 0.3..=6.0,
        /// Height of the package.
        height: Length = 0.2..=4.0,
        /// Distance of their tops below the lens.
        gap: Length = 0.1..=10.0,
        /// Type.
        model: String = 1..=80,
        /// Their electricity.
        electric: Inline<Electric>,
    }

    /// The image sensor, its board and lens.
    pub struct Camera {
        /// Which it is.
        module: Inline<Module>,
        /// Pixels along each side of the square image.
        pixels: u32 = 8..=4000,
        /// Images per second when whole images are read.
        image_rate: f64 = 0.1..=10000.0,
        /// Rate of the chip's own statistics, Hz.
        statistics_rate: u32 = 1..=20000,
        /// Edge of the chip's square pixel array.
        array_size: Length = 0.2..=20.0,
        /// Share of the picture's half width that stays free around the dots: what a lens's focal length and
        /// a chip that sits beside its axis may be off.
        margin: f64 = 0.0..=0.5,
        /// Focal length.
        focal_length: Length = 0.5..=50.0,
        /// Full angle of view of the lens on a chip that fills its image circle.
        lens_view: Angle = 10.0..=200.0,
        /// Its lens.
        optics: Inline<Optics>,
        /// Distance of the optical centre below the hemisphere's foot.
        depth: Length = 5.0..=200.0,
        /// Distance of the optical centre behind the lens's front.
        pupil_behind_front: Length = 0.0..=20.0,
        /// Edge of the board along x.
        board_size: Length = 10.0..=60.0,
        /// Edge of the board along y.
        board_size_y: Length = 10.0..=60.0,
        /// Thickness of the board.
        board_thickness: Length = 0.4..=3.2,
        /// Distance of the screw holes' centres along x.
        screw_spacing: Length = 5.0..=58.0,
        /// Distance of the screw holes' centres along y.
        screw_spacing_y: Length = 5.0..=58.0,
        /// Edge of the square lens holder.
        holder_size: Length = 4.0..=40.0,
        /// Height of the lens holder above the board.
        holder_height: Length = 1.0..=30.0,
        /// Diameter of the lens barrel.
        barrel_diameter: Length = 2.0..=40.0,
        /// Height of the lens's front above the board.
        lens_height: Length = 2.0..=60.0,
    }

    /// The printed body: spigot, shaft, and the housing of the board.
    pub struct Body {
        /// Length of the shaft, from the end that faces the lens to the housing.
        shaft_length: Length = 10.0..=200.0,
        /// Outer diameter of the shaft.
        shaft_diameter: Length = 14.0..=78.0,
        /// Thickness of the shaft's wall.
        shaft_wall: Length = 1.2..=6.0,
        /// Thickness of the neck between O-ring and LED board.
        neck_wall: Length = 0.4..=3.0,
        /// Free height below the camera board, for plugs and cable.
        wiring_room: Length = 3.0..=40.0,
        /// Width of the slot that the cable leaves by.
        cable_slot_width: Length = 2.0..=20.0,
        /// Where that slot is around the axis: at +x at 0, at +y at 90 degrees.
        cable_angle: Angle = -180.0..=180.0,
        /// Radius of the housing's outer edges, below the cone and above the mount; 0 for sharp ones.
        edge_fillet: Length = 0.0..=5.0,
        /// Diameter of the posts that the camera board is screwed to.
        post_diameter: Length = 4.0..=12.0,
        /// Material.
        material: String = 1..=80,
    }

    /// The microcontroller that reads the chip.
    pub struct Controller {
        /// Where its board is: in a holder on the `housing`, or elsewhere, for `none`.
        seat: ControllerSeat,
        /// Type.
        model: String = 1..=80,
        /// Length of its board.
        length: Length = 15.0..=120.0,
        /// Width of its board.
        width: Length = 10.0..=80.0,
        /// Thickness of its board.
        thickness: Length = 0.6..=3.2,
    }

    /// The flange between robot and body.
    pub struct Mount {
        /// Thickness of the plate.
        plate: Length = 2.0..=15.0,
        /// Height of the spigot.
        spigot_height: Length = 4.0..=30.0,
        /// Thickness of the spigot's wall.
        spigot_wall: Length = 1.2..=6.0,
        /// Diameter of the circle of bolts.
        bolt_circle: Length = 15.0..=100.0,
        /// Number of M5 bolts.
        bolts: u32 = 3..=12,
    }

    /// A pin-tip sensor.
    pub struct PinTip {
        /// The printed tip.
        tip: Tip,
        /// The skin.
        skin: Skin,
        /// The pins.
        pins: Pins,
        /// The gel.
        fill: Fill,
        /// The window.
        lens: Lens,
        /// The bayonets.
        bayonet: Bayonet,
        /// The seal.
        seal: Seal,
        /// The LED board.
        led_board: LedBoard,
        /// The LEDs.
        leds: Leds,
        /// The camera.
        camera: Camera,
        /// The body.
        body: Body,
        /// The microcontroller.
        controller: Controller,
        /// The robot mount.
        mount: Mount,
        /// Which parts are made how.
        making: Making,
    }
}

impl Pins {
    /// Returns the listed pins.
    pub fn listed(&self) -> Listed<'_, Angle> {
        Listed::new("pin", ("pins.polar", &self.polar), ("pins.azimuth", &self.azimuth))
    }
}

// ------ Bodies ------
//
// Bodies of the sensor and of its tools, and the assemblies in which they stand together.

/// Assembly that fills the tip with gel, tip down. The sensor's frame is turned over, so that up is +z.
pub const FILLING: AssemblyName = AssemblyName("filling");

/// Assembly that focuses the lens, before the camera board is screwed into the body.
pub const FOCUSING: AssemblyName = AssemblyName("focusing");

/// Bodies of the printed tip, which is one piece.
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
