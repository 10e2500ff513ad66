//! Parameters of the pin-tip family, and the names of its bodies.

use fabkit_geometry::{Angle, Length};

use crate::blocks::bayonet::Bayonet;
use crate::blocks::circuit::Electric;
use crate::blocks::listed_markers::{ListedMarkers, RoundPattern};
use crate::blocks::optics::{Module, Optics};
pub use crate::blocks::{CAMERA, CAMERA_CABLE};
use crate::chain_builder::{AssemblyName, Name};
use crate::materials::Castable;
use crate::parameters::Inline;
use crate::processes::ProcessAssignments;
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
    /// Printed tip: skin, pins with dots, and ring.
    pub struct Tip {
        /// Outer diameter of hemisphere and ring.
        diameter: Length = 20.0..=80.0,
        /// Material of skin and pins.
        soft_material: String = 1..=80,
        /// Material of ring and dots.
        rigid_material: String = 1..=80,
    }

    /// Soft hemisphere that touches objects.
    pub struct Skin {
        /// Thickness of the skin.
        thickness: Length = 0.5..=4.0,
        /// Height by which the skin reaches down around the ring, so that the bond is loaded in shear.
        skirt_height: Length = 0.5..=5.0,
        /// Thickness of the ring inside that skirt.
        upstand: Length = 0.3..=2.0,
    }

    /// Pins on the inside of the skin, each along the local normal.
    pub struct Pins {
        /// Layout of the pins: one of the paper's (`A` to `D`), or `free`.
        layout: PinLayout,
        /// Diameter of a pin; used only in the layout `free`.
        diameter: Length = 0.4..=5.0,
        /// Pattern of the pins: `rings` around the apex, or a `list` of positions `polar` and `azimuth`, for which only
        /// the layout's diameter is used.
        pattern: RoundPattern,
        /// For a list: angle of each pin from the apex, at the hemisphere's centre.
        polar: Vec<Angle> = (1..=1000, 0.0..=90.0),
        /// For a list: angle of each pin around the axis, from +x towards +y.
        azimuth: Vec<Angle> = (1..=1000, -360.0..=360.0),
        /// Distance between neighbouring circles, and between pins on one circle, along the skin's inside; used only in
        /// the layout `free`.
        spacing: Length = 1.0..=15.0,
        /// For rings: distance of the outermost circle of pins from the apex, along the skin's inside.
        reach: Length = 0.0..=120.0,
        /// Length of the soft pin without its dot.
        length: Length = 0.3..=8.0,
        /// Thickness of the white dot on the end of a pin.
        dot_thickness: Length = 0.1..=3.0,
    }

    /// Clear gel between skin and window.
    pub struct Fill {
        /// Distance of the window below the hemisphere's foot.
        depth: Length = 0.5..=20.0,
        /// Trade name of the gel.
        material: Castable,
    }

    /// Flat window that closes the tip.
    pub struct Lens {
        /// Thickness of the sheet from which the window is cut.
        thickness: Length = 0.8..=6.0,
        /// Width of the ledge to which the window is glued.
        ledge: Length = 0.3..=5.0,
        /// Diameter of the two holes in the window: gel is filled through one, air leaves through the other.
        hole_diameter: Length = 0.8..=5.0,
        /// Radius of the circle on which the holes' centres lie.
        hole_radius: Length = 2.0..=38.0,
        /// Material of the window.
        material: String = 1..=80,
    }

    /// O-ring between body and window, which keeps light out and the bayonet from turning.
    pub struct Seal {
        /// Diameter of the O-ring's cord.
        cord: Length = 0.6..=3.0,
        /// Fraction of the cord's diameter by which the O-ring is squeezed.
        squeeze: f64 = 0.1..=0.3,
    }

    /// Annular circuit board with the LEDs, below the window.
    pub struct LedBoard {
        /// Thickness of the LED board.
        thickness: Length = 0.4..=3.2,
        /// Radius of the bore through which the camera looks.
        bore_radius: Length = 2.0..=35.0,
        /// Material of the LED board.
        material: String = 1..=80,
    }

    /// LEDs on the annular board.
    pub struct Leds {
        /// Number of LEDs.
        count: u32 = 3..=32,
        /// Radius of the circle on which the LEDs' centres lie.
        circle_radius: Length = 3.0..=38.0,
        /// Length of an LED's package, along the circle.
        length: Length = 0.5..=6.0,
        /// Width of an LED's package, along the radius.
        width: Length = 0.3..=6.0,
        /// Height of an LED's package.
        height: Length = 0.2..=4.0,
        /// Distance of the LEDs' tops below the window.
        gap: Length = 0.1..=10.0,
        /// Type of LED to buy.
        model: String = 1..=80,
        /// Electrical data of the LEDs.
        electric: Inline<Electric>,
    }

    /// Image sensor with its board and lens.
    pub struct Camera {
        /// Camera module.
        module: Inline<Module>,
        /// Number of pixels along each side of the square image.
        pixels: u32 = 8..=4000,
        /// Frame rate when whole images are read, Hz.
        image_rate: f64 = 0.1..=10000.0,
        /// Rate of the statistics that the chip computes itself, Hz.
        statistics_rate: u32 = 1..=20000,
        /// Edge of the chip's square pixel array.
        array_size: Length = 0.2..=20.0,
        /// Fraction of half the image's width that stays free around the dots, for tolerances of the lens's focal
        /// length and of the chip's position.
        margin: f64 = 0.0..=0.5,
        /// Focal length of the lens.
        focal_length: Length = 0.5..=50.0,
        /// Full angle of view of the lens on a chip that fills its image circle.
        lens_view: Angle = 10.0..=200.0,
        /// Optical properties of the lens.
        optics: Inline<Optics>,
        /// Distance of the lens's optical centre below the hemisphere's foot.
        depth: Length = 5.0..=200.0,
        /// Distance of the optical centre behind the lens's front.
        pupil_behind_front: Length = 0.0..=20.0,
        /// Edge of the camera board along x.
        board_size: Length = 10.0..=60.0,
        /// Edge of the camera board along y.
        board_size_y: Length = 10.0..=60.0,
        /// Thickness of the camera board.
        board_thickness: Length = 0.4..=3.2,
        /// Distance between the centres of the board's screw holes along x.
        screw_spacing: Length = 5.0..=58.0,
        /// Distance between the centres of the board's screw holes along y.
        screw_spacing_y: Length = 5.0..=58.0,
        /// Edge of the square lens holder.
        holder_size: Length = 4.0..=40.0,
        /// Height of the lens holder above the camera board.
        holder_height: Length = 1.0..=30.0,
        /// Diameter of the lens barrel.
        barrel_diameter: Length = 2.0..=40.0,
        /// Height of the lens's front above the camera board.
        lens_height: Length = 2.0..=60.0,
    }

    /// Printed body: spigot, shaft, and the housing of the camera board.
    pub struct Body {
        /// Length of the shaft, from the end that faces the window to the housing.
        shaft_length: Length = 10.0..=200.0,
        /// Outer diameter of the shaft.
        shaft_diameter: Length = 14.0..=78.0,
        /// Thickness of the shaft's wall.
        shaft_wall: Length = 1.2..=6.0,
        /// Thickness of the neck between O-ring and LED board.
        neck_wall: Length = 0.4..=3.0,
        /// Free height below the camera board for plugs and cable.
        wiring_room: Length = 3.0..=40.0,
        /// Width of the slot through which the cable leaves.
        cable_slot_width: Length = 2.0..=20.0,
        /// Angle of that slot around the axis: 0 at +x, 90 degrees at +y.
        cable_angle: Angle = -180.0..=180.0,
        /// Radius of the housing's outer edges, below the cone and above the mount; 0 for sharp edges.
        edge_fillet: Length = 0.0..=5.0,
        /// Diameter of the posts to which the camera board is screwed.
        post_diameter: Length = 4.0..=12.0,
        /// Material of the body.
        material: String = 1..=80,
    }

    /// Microcontroller that reads the image sensor.
    pub struct Controller {
        /// Place of the microcontroller's board: in a holder on the `housing`, or elsewhere (`none`).
        seat: ControllerSeat,
        /// Type of microcontroller board to buy.
        model: String = 1..=80,
        /// Length of the microcontroller's board.
        length: Length = 15.0..=120.0,
        /// Width of the microcontroller's board.
        width: Length = 10.0..=80.0,
        /// Thickness of the microcontroller's board.
        thickness: Length = 0.6..=3.2,
    }

    /// Flange between robot and body.
    pub struct Mount {
        /// Thickness of the flange's plate.
        plate: Length = 2.0..=15.0,
        /// Height of the spigot on the flange.
        spigot_height: Length = 4.0..=30.0,
        /// Thickness of the spigot's wall.
        spigot_wall: Length = 1.2..=6.0,
        /// Diameter of the circle on which the bolts lie.
        bolt_circle: Length = 15.0..=100.0,
        /// Number of M5 bolts.
        bolts: u32 = 3..=12,
    }

    /// Parameters of a pin-tip sensor.
    pub struct PinTip {
        /// Printed tip: skin, pins with dots, and ring.
        tip: Tip,
        /// Soft hemisphere that touches objects.
        skin: Skin,
        /// Pins on the inside of the skin, each along the local normal.
        pins: Pins,
        /// Clear gel between skin and window.
        fill: Fill,
        /// Flat window that closes the tip.
        lens: Lens,
        /// Two bayonet joints: between tip and body, and between body and robot mount.
        bayonet: Bayonet,
        /// O-ring between body and window, which keeps light out and the bayonet from turning.
        seal: Seal,
        /// Annular circuit board with the LEDs, below the window.
        led_board: LedBoard,
        /// LEDs on the annular board.
        leds: Leds,
        /// Image sensor with its board and lens.
        camera: Camera,
        /// Printed body: spigot, shaft, and the housing of the camera board.
        body: Body,
        /// Microcontroller that reads the image sensor.
        controller: Controller,
        /// Flange between robot and body.
        mount: Mount,
        /// Processes by which the parts are made.
        making: ProcessAssignments,
    }
}

impl Pins {
    /// Returns the listed pins.
    pub fn listed(&self) -> ListedMarkers<'_, Angle> {
        ListedMarkers::new("pin", ("pins.polar", &self.polar), ("pins.azimuth", &self.azimuth))
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
