//! Parameters of the half-ellipsoid family, and the names of its bodies.

use fabkit_geometry::{Angle, Length};

use crate::blocks::listed_markers::{ListedMarkers, RoundPattern};
use crate::blocks::mounting::Mount;
use crate::blocks::optics::{ImageFormat, Module, Optics, ProjectionLaw};
pub use crate::blocks::{CAMERA, LED_WIRE};
use crate::chain_builder::AssemblyName;
use crate::materials::Castable;
use crate::parameters::Inline;
use crate::processes::ProcessAssignments;
use crate::{choices, sections};

choices! {
    /// Surface to which `surface.diameter` and `surface.height` are measured.
    pub enum MeasuredTo {
        /// Outside of the black gel, which is the finished sensor.
        BlackGel = "black-gel",
        /// Outside of the outer elastomer; the black gel is added to it.
        OuterElastomer = "outer-elastomer",
    }
}

sections! {
    /// Half ellipsoid of revolution from which every layer is offset.
    pub struct Surface {
        /// Diameter of the ellipsoid's base circle.
        diameter: Length = 12.0..=80.0,
        /// Height of the ellipsoid's tip above the base circle.
        height: Length = 8.0..=120.0,
        /// Surface to which diameter and height are measured: the outside of the black gel or of the outer elastomer.
        measured_to: MeasuredTo,
    }

    /// Rigid transparent skeleton below the elastomers.
    pub struct Shell {
        /// Thickness of the shell's dome.
        thickness: Length = 0.5..=10.0,
        /// Height of the shell's foot below the base circle, which is glued into the shell holder.
        foot_height: Length = 1.0..=20.0,
        /// Width of the shell's shoulder, which stands on the shell holder.
        shoulder: Length = 0.1..=3.0,
        /// Diameter of the ball mill that finishes the inside of the shell. It rounds the tip, which would otherwise be
        /// pointed.
        ball_mill_diameter: Length = 0.5..=12.0,
        /// Material of the shell.
        material: String = 1..=80,
    }

    /// Cast layer.
    pub struct Elastomer {
        /// Thickness of the layer, along the surface's normal.
        thickness: Length = 0.1..=10.0,
        /// Material of the layer, by its name in fabkit's table of materials.
        material: Castable,
    }

    /// Slots in the inner elastomer that the outer elastomer fills, made visible by UV light.
    pub struct Markers {
        /// Pattern of the markers: `count` of them on `rings` around the tip, or a `list` of positions `polar` and
        /// `azimuth`.
        pattern: RoundPattern,
        /// For a list: angle between the sensor's axis and each marker's axis, as for the holes of a pin dome.
        polar: Vec<Angle> = (1..=1000, 0.0..=90.0),
        /// For a list: angle of each marker around the axis, from +x towards +y.
        azimuth: Vec<Angle> = (1..=1000, -360.0..=360.0),
        /// For rings: number of markers; 0 for a sensor without markers, whose inner elastomer is as thick as both
        /// elastomers together.
        count: u32 = 0..=600,
        /// Radius of a marker's slot and of its round end.
        radius: Length = 0.1..=5.0,
        /// Depth of the slot's straight part, without its round end.
        straight_depth: Length = 0.05..=5.0,
        /// Minimum thickness of elastomer between slots, and between a slot and the shell.
        wall: Length = 0.1..=5.0,
    }

    /// Printed ring that carries the shell and slides over the base.
    pub struct Holder {
        /// Outer diameter of the shell holder.
        outer_diameter: Length = 12.0..=100.0,
        /// Radius of the holder's upper outer edge, around the elastomers' feet; 0 for a sharp edge. The base's lower
        /// edge stays sharp, because the sensor stands on it.
        edge_fillet: Length = 0.0..=5.0,
        /// Thickness of the holder's skirt around the base.
        skirt: Length = 0.8..=6.0,
        /// Material of the shell holder.
        material: String = 1..=80,
    }

    /// Printed white ring above the LEDs.
    pub struct Diffuser {
        /// Thickness of the diffuser's plate above the LEDs.
        thickness: Length = 0.4..=4.0,
        /// Thickness of the diffuser's wall, which stands on the board.
        wall: Length = 0.4..=4.0,
        /// Distance from the LEDs' tops to the diffuser's plate.
        gap: Length = 0.0..=5.0,
        /// Material of the diffuser.
        material: String = 1..=80,
    }

    /// Round circuit board that carries the LEDs.
    pub struct LedBoard {
        /// Thickness of the LED board.
        thickness: Length = 0.4..=3.2,
        /// Number of wires: supply, ground, and one that switches each kind of LED.
        wires: u32 = 2..=8,
        /// Diameter of a wire over its insulation.
        wire_diameter: Length = 0.3..=3.0,
        /// Diameter of the holes into which the wires are soldered.
        wire_hole_diameter: Length = 0.4..=2.0,
        /// Height of the components soldered to the board's underside, a dual switch and two resistors; 0 for none.
        parts_height: Length = 0.0..=4.0,
        /// Type of the switch for the LEDs.
        switch_model: String = 1..=80,
        /// Material of the LED board.
        material: String = 1..=80,
    }

    /// White and UV LEDs, alternating on one circle.
    pub struct Leds {
        /// Number of LEDs of each kind.
        pairs: u32 = 2..=16,
        /// Diameter of an LED's package.
        diameter: Length = 0.5..=8.0,
        /// Height of an LED's package.
        height: Length = 0.3..=8.0,
        /// Radius of the circle on which the LEDs' centres lie.
        circle_radius: Length = 1.0..=40.0,
        /// Type of white LED to buy.
        white_model: String = 1..=80,
        /// Type of UV LED to buy.
        uv_model: String = 1..=80,
        /// Supply voltage, V.
        supply_volts: f64 = 3.0..=5.5,
        /// Forward voltage of a white LED at its current, V.
        white_forward_volts: f64 = 1.5..=24.0,
        /// Forward voltage of a UV LED at its current, V.
        uv_forward_volts: f64 = 1.5..=24.0,
        /// Current of each LED, mA, for which the resistors are calculated.
        current_ma: f64 = 0.5..=60.0,
        /// Largest current that an LED withstands permanently, mA.
        rated_ma: f64 = 1.0..=3000.0,
        /// Largest current that the supply delivers, mA.
        supply_ma: f64 = 1.0..=20000.0,
    }

    /// Endoscope camera.
    pub struct Camera {
        /// Camera module.
        module: Inline<Module>,
        /// Diameter of the camera.
        diameter: Length = 0.8..=12.0,
        /// Length of the camera.
        length: Length = 1.0..=30.0,
        /// Diameter of the camera's cable.
        cable_diameter: Length = 0.2..=5.0,
        /// Distance of the lens's front below the base circle.
        front_depth: Length = 0.0..=30.0,
        /// Distance of the entrance pupil behind the lens's front.
        pupil_behind_front: Length = 0.0..=5.0,
        /// Images of the camera.
        images: Inline<ImageFormat>,
        /// Full angle of view of the lens, over the image's diagonal.
        field_of_view: Angle = 10.0..=180.0,
        /// Projection of the lens: relation between the angle to its axis and the distance from the image's centre.
        projection: ProjectionLaw,
        /// Optical properties of the lens.
        optics: Inline<Optics>,
    }

    /// Printed post that carries the camera, through LED board and diffuser.
    pub struct CameraHolder {
        /// Thickness of the post's wall around the camera.
        wall: Length = 0.4..=4.0,
        /// Depth of the post's socket in the base.
        socket_depth: Length = 0.5..=10.0,
    }

    /// Printed base that carries camera and electronics.
    pub struct Base {
        /// Depth of the pocket for resistors and switch below the LED board.
        pocket_depth: Length = 0.0..=6.0,
        /// Thickness of the flange on which the holder's skirt stands.
        flange: Length = 1.0..=10.0,
        /// Number of M1.2 bolts that join base and shell holder.
        bolts: u32 = 2..=8,
        /// Length of the slot for the LED board's wires.
        wire_slot_length: Length = 1.0..=10.0,
        /// Width of the slot for the LED board's wires.
        wire_slot_width: Length = 0.6..=6.0,
        /// Angle of that slot around the axis: 0 at +x, 90 degrees at +y.
        cable_angle: Angle = -180.0..=180.0,
        /// Number of mounting holes in the bottom, on a circle.
        mount_holes: u32 = 2..=6,
        /// Radius of the circle on which the mounting holes lie.
        mount_radius: Length = 2.0..=40.0,
    }

    /// Printed negatives and the silicone molds cast from them.
    pub struct Tooling {
        /// Outer diameter of the silicone molds.
        silicone_diameter: Length = 20.0..=200.0,
        /// Thickness of the silicone beyond the tip.
        silicone_floor: Length = 2.0..=40.0,
        /// Thickness of the core's flange, which closes the molds and holds the tip of a syringe.
        core_flange: Length = 2.0..=20.0,
        /// Largest diameter of the keys between core and molds.
        key_diameter: Length = 1.5..=20.0,
        /// Height of the keys.
        key_height: Length = 0.5..=10.0,
        /// Number of keys.
        keys: u32 = 2..=12,
        /// Number of vents at the foot of the inner elastomer, and of gates at the foot of each of the two thin layers.
        vents: u32 = 3..=64,
        /// Diameter of a vent at the foot, from where it narrows slightly.
        vent_diameter: Length = 0.3..=4.0,
        /// Diameter of the vent at the tip of the mold for the outer elastomer.
        tip_vent_diameter: Length = 0.5..=4.0,
        /// Thickness of the printed walls and plates.
        wall: Length = 1.2..=10.0,
        /// Silicone of the molds, by its name in fabkit's table of materials.
        silicone_material: Castable,
        /// Resin of the printed negatives.
        resin: String = 1..=80,
    }

    /// Parameters of a sensor whose layers are half ellipsoids.
    pub struct HalfEllipsoid {
        /// Half ellipsoid of revolution from which every layer is offset.
        surface: Surface,
        /// Rigid transparent skeleton below the elastomers.
        shell: Shell,
        /// Cast elastomer layer on the shell.
        inner_elastomer: Elastomer,
        /// Cast elastomer layer around the inner elastomer.
        outer_elastomer: Elastomer,
        /// Opaque gel layer on the outside.
        black_gel: Elastomer,
        /// Slots in the inner elastomer that the outer elastomer fills, made visible by UV light.
        markers: Markers,
        /// Printed ring that carries the shell and slides over the base.
        holder: Holder,
        /// Printed white ring above the LEDs.
        diffuser: Diffuser,
        /// Round circuit board that carries the LEDs.
        led_board: LedBoard,
        /// White and UV LEDs, alternating on one circle.
        leds: Leds,
        /// Endoscope camera.
        camera: Camera,
        /// Printed post that carries the camera, through LED board and diffuser.
        camera_holder: CameraHolder,
        /// Printed base that carries camera and electronics.
        base: Base,
        /// Holes by which the sensor is mounted.
        mount: Mount,
        /// Printed negatives and the silicone molds cast from them.
        tooling: Tooling,
        /// Processes by which the parts are made.
        making: ProcessAssignments,
    }
}

impl Markers {
    /// Returns whether there are no markers. Inner and outer elastomer are then one pour, because nothing
    /// distinguishes them.
    pub fn is_plain(&self) -> bool {
        self.pattern == RoundPattern::Rings && self.count == 0
    }

    /// Returns the listed markers.
    ///
    /// They are given by the angle of the normal, not by the height over the base circle: near the tip a tenth of a
    /// millimetre is hardly a micrometre of height. The angle is the same for all parallel surfaces. So a marker lies
    /// below the point of the finished sensor that has this normal, whatever the layers measure, and below the pin of
    /// a pin dome with the same angles.
    pub fn listed(&self) -> ListedMarkers<'_, Angle> {
        ListedMarkers::new(
            "marker",
            ("markers.polar", &self.polar),
            ("markers.azimuth", &self.azimuth),
        )
    }
}

// ------ Bodies ------
//
// Bodies of the sensor and of its tools, and the assemblies in which they stand together.

/// Assemblies that cast the silicone molds on and in their negatives.
pub const CAST_INNER_CUP: AssemblyName = AssemblyName("cast-cup-inner");
pub const CAST_OUTER_CUP: AssemblyName = AssemblyName("cast-cup-outer");
pub const CAST_BLACK_CUP: AssemblyName = AssemblyName("cast-cup-black");
pub const CAST_CORE: AssemblyName = AssemblyName("cast-core");
/// Assemblies that cast the layers.
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
