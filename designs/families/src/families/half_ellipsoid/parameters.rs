//! Parameters of the half-ellipsoid family, and the names of its bodies.

use fabkit_geometry::{Angle, Length};

use crate::assembling::AssemblyName;
use crate::blocks::marks::{Listed, RoundPattern};
use crate::blocks::mounting::Mount;
use crate::blocks::optics::{LensLaw, Module, Optics, Pictures};
pub use crate::blocks::{CAMERA, LED_WIRE};
use crate::materials::Castable;
use crate::parameters::Inline;
use crate::processes::Making;
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
    /// The half ellipsoid of revolution from which every layer is offset.
    pub struct Surface {
        /// Diameter of the base circle.
        diameter: Length = 12.0..=80.0,
        /// Height of the tip above the base circle.
        height: Length = 8.0..=120.0,
        /// Which surface diameter and height are measured to.
        measured_to: MeasuredTo,
    }

    /// The rigid transparent skeleton below the elastomers.
    pub struct Shell {
        /// Thickness of the dome.
        thickness: Length = 0.5..=10.0,
        /// Height of the foot below the base circle, glued into the shell holder.
        foot_height: Length = 1.0..=20.0,
        /// Width of the shoulder that stands on the shell holder.
        shoulder: Length = 0.1..=3.0,
        /// Diameter of the ball mill that finishes the inside: it rounds what would be a pointed tip.
        ball_mill_diameter: Length = 0.5..=12.0,
        /// Material.
        material: String = 1..=80,
    }

    /// One cast layer.
    pub struct Elastomer {
        /// Thickness, along the surface's normal.
        thickness: Length = 0.1..=10.0,
        /// What is cast, as fabkit's table of materials names it.
        material: Castable,
    }

    /// Slots in the inner elastomer that the outer elastomer fills: what UV light makes visible.
    pub struct Markers {
        /// How they lie: `count` of them on `rings` around the tip, or a `list` of places `polar` and
        /// `azimuth`.
        pattern: RoundPattern,
        /// List: angle between the axis and each marker's own, as of a pin dome's holes.
        polar: Vec<Angle> = (1..=1000, 0.0..=90.0),
        /// List: angle of each marker around the axis, from +x towards +y.
        azimuth: Vec<Angle> = (1..=1000, -360.0..=360.0),
        /// Rings: how many; 0 for a plain sensor, whose inner elastomer is cast as thick as both together.
        count: u32 = 0..=600,
        /// Radius of the slot and of its round end.
        radius: Length = 0.1..=5.0,
        /// Depth of the slot's straight part; the round end comes on top.
        straight_depth: Length = 0.05..=5.0,
        /// Thinnest elastomer left between slots, and between a slot and the shell.
        wall: Length = 0.1..=5.0,
    }

    /// The printed ring that carries the shell and slides over the base.
    pub struct Holder {
        /// Outer diameter.
        outer_diameter: Length = 12.0..=100.0,
        /// Radius of its upper outer edge, around the elastomers' feet; 0 for a sharp one. The base's lower
        /// edge stays sharp: the sensor stands on it.
        edge_fillet: Length = 0.0..=5.0,
        /// Thickness of the skirt around the base.
        skirt: Length = 0.8..=6.0,
        /// Material.
        material: String = 1..=80,
    }

    /// The printed white ring above the LEDs.
    pub struct Diffuser {
        /// Thickness of the plate above the LEDs.
        thickness: Length = 0.4..=4.0,
        /// Thickness of the wall that stands on the board.
        wall: Length = 0.4..=4.0,
        /// Distance from the LEDs' tops to the plate.
        gap: Length = 0.0..=5.0,
        /// Material.
        material: String = 1..=80,
    }

    /// The round board that carries the LEDs.
    pub struct LedBoard {
        /// Thickness.
        thickness: Length = 0.4..=3.2,
        /// Number of wires: supply, ground, and one that switches each kind of LEDs.
        wires: u32 = 2..=8,
        /// Diameter of a wire over its insulation.
        wire_diameter: Length = 0.3..=3.0,
        /// Diameter of the holes that the wires are soldered into.
        wire_hole_diameter: Length = 0.4..=2.0,
        /// Height of what is soldered to the underside, a dual switch and two resistors; 0 for none.
        parts_height: Length = 0.0..=4.0,
        /// What switches the LEDs.
        switch_model: String = 1..=80,
        /// Material.
        material: String = 1..=80,
    }

    /// White and UV LEDs, alternating on one circle.
    pub struct Leds {
        /// How many of each kind.
        pairs: u32 = 2..=16,
        /// Diameter of the package.
        diameter: Length = 0.5..=8.0,
        /// Height of the package.
        height: Length = 0.3..=8.0,
        /// Radius of the circle of their centres.
        circle_radius: Length = 1.0..=40.0,
        /// Type of the white ones.
        white_model: String = 1..=80,
        /// Type of the UV ones.
        uv_model: String = 1..=80,
        /// Supply, V.
        supply_volts: f64 = 3.0..=5.5,
        /// Forward voltage of a white LED at its current, V.
        white_forward_volts: f64 = 1.5..=24.0,
        /// Forward voltage of a UV LED at its current, V.
        uv_forward_volts: f64 = 1.5..=24.0,
        /// Current of each LED, mA, that the resistors are calculated for.
        current_ma: f64 = 0.5..=60.0,
        /// Largest current that an LED bears for long, mA.
        rated_ma: f64 = 1.0..=3000.0,
        /// Largest current that the supply gives, mA.
        supply_ma: f64 = 1.0..=20000.0,
    }

    /// The endoscope camera.
    pub struct Camera {
        /// Which it is.
        module: Inline<Module>,
        /// Diameter.
        diameter: Length = 0.8..=12.0,
        /// Length.
        length: Length = 1.0..=30.0,
        /// Diameter of its cable.
        cable_diameter: Length = 0.2..=5.0,
        /// Distance of the lens's front below the base circle.
        front_depth: Length = 0.0..=30.0,
        /// Distance of the entrance pupil behind the front.
        pupil_behind_front: Length = 0.0..=5.0,
        /// Its pictures.
        pictures: Inline<Pictures>,
        /// Full angle of view of the lens, over the image's diagonal.
        field_of_view: Angle = 10.0..=180.0,
        /// How the lens lays angles onto the picture.
        projection: LensLaw,
        /// Its lens.
        optics: Inline<Optics>,
    }

    /// The printed post that carries the camera through board and diffuser.
    pub struct CameraHolder {
        /// Thickness of the wall around the camera.
        wall: Length = 0.4..=4.0,
        /// How deep the post stands in the base.
        socket_depth: Length = 0.5..=10.0,
    }

    /// The printed base that carries everything electric.
    pub struct Base {
        /// Depth of the pocket for resistors and switch below the board.
        pocket_depth: Length = 0.0..=6.0,
        /// Thickness of the flange that the skirt stands on.
        flange: Length = 1.0..=10.0,
        /// Number of M1.2 bolts that join base and shell holder.
        bolts: u32 = 2..=8,
        /// Length of the slot for the board's wires.
        wire_slot_length: Length = 1.0..=10.0,
        /// Width of the slot for the board's wires.
        wire_slot_width: Length = 0.6..=6.0,
        /// Where that slot is around the axis: at +x at 0, at +y at 90 degrees.
        cable_angle: Angle = -180.0..=180.0,
        /// Number of holes in the bottom for mounting, on a ring.
        mount_holes: u32 = 2..=6,
        /// Radius of the circle of the mounting holes.
        mount_radius: Length = 2.0..=40.0,
    }

    /// Printed negatives and the silicone molds cast from them.
    pub struct Tooling {
        /// Outer diameter of the silicone molds.
        silicone_diameter: Length = 20.0..=200.0,
        /// Thickness of silicone beyond the tip.
        silicone_floor: Length = 2.0..=40.0,
        /// Thickness of the core's flange, which closes the molds and holds the tip of a syringe.
        core_flange: Length = 2.0..=20.0,
        /// Largest diameter of the keys between core and molds.
        key_diameter: Length = 1.5..=20.0,
        /// Height of the keys.
        key_height: Length = 0.5..=10.0,
        /// Number of keys.
        keys: u32 = 2..=12,
        /// Vents at the foot of the inner elastomer, and as many gates under the two thin layers' feet.
        vents: u32 = 3..=64,
        /// Diameter of a vent at the foot; it narrows a little from there.
        vent_diameter: Length = 0.3..=4.0,
        /// Diameter of the vent at the tip of the mold for the outer elastomer.
        tip_vent_diameter: Length = 0.5..=4.0,
        /// Thickness of printed walls and plates.
        wall: Length = 1.2..=10.0,
        /// Silicone of the molds.
        silicone_material: Castable,
        /// Resin of the negatives.
        resin: String = 1..=80,
    }

    /// A sensor with half ellipsoids for layers.
    pub struct HalfEllipsoid {
        /// The sensing surface.
        surface: Surface,
        /// The acrylic shell.
        shell: Shell,
        /// The elastomer next to the shell.
        inner_elastomer: Elastomer,
        /// The elastomer around it.
        outer_elastomer: Elastomer,
        /// The opaque layer outside.
        black_gel: Elastomer,
        /// The markers.
        markers: Markers,
        /// The shell holder.
        holder: Holder,
        /// The diffusion ring.
        diffuser: Diffuser,
        /// The LED board.
        led_board: LedBoard,
        /// The LEDs.
        leds: Leds,
        /// The camera.
        camera: Camera,
        /// The camera holder.
        camera_holder: CameraHolder,
        /// The base.
        base: Base,
        /// The holes that it is mounted by.
        mount: Mount,
        /// Molds and their negatives.
        tooling: Tooling,
        /// Which parts are made how.
        making: Making,
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
    pub fn listed(&self) -> Listed<'_, Angle> {
        Listed::new("marker", ("markers.polar", &self.polar), ("markers.azimuth", &self.azimuth))
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
