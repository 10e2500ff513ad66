//! Parameters of the sheet-mold family, and the names of its bodies.

use fabkit_geometry::{Angle, Length};

use crate::assembling::AssemblyName;
pub use crate::blocks::CAMERA;
use crate::blocks::cable_way::Side;
use crate::blocks::marks::{FlatPattern, Listed};
use crate::blocks::optics::{LensLaw, Optics};
use crate::materials::Castable;
use crate::parameters::Inline;
use crate::processes::Making;
use crate::{choices, sections};

choices! {
    /// Arrangement of the channels in the interface. Half of them enter from each of two sides.
    pub enum Arrangement {
        /// Parallel channels, from the side to the middle.
        Straight = "straight",
        /// Channels with a round chamber at each end. The chambers stand in a staggered grid of four columns.
        Grid = "grid",
        /// Channels like spokes towards the centre, alternately long and short.
        Radial = "radial",
    }
}

sections! {
    /// The sheets that everything rigid is cut from.
    pub struct Stock {
        /// Length of a stock sheet.
        length: Length = 50.0..=3000.0,
        /// Width of a stock sheet.
        width: Length = 50.0..=2000.0,
        /// Bare edge that the laser leaves around what it cuts.
        margin: Length = 0.0..=50.0,
    }

    /// The outline that mold sheets, box and clamps share, with a bolt in each corner.
    pub struct Plate {
        /// Edge of the square plates.
        side: Length = 40.0..=400.0,
        /// Distance between two bolts along an edge.
        bolt_spacing: Length = 30.0..=380.0,
        /// Width of the notches for a screwdriver that parts a stack.
        pry_width: Length = 4.0..=30.0,
        /// Depth of these notches.
        pry_depth: Length = 1.0..=10.0,
    }

    /// The soft layer with the liquid's channels, on top.
    pub struct ChannelLayer {
        /// Edge of the square layer.
        side: Length = 20.0..=300.0,
        /// Thickness above the channels: the sheet of the mold's frame.
        roof: Length = 1.0..=10.0,
        /// Trade name.
        material: Castable,
    }

    /// The channels.
    pub struct Channels {
        /// How they run.
        arrangement: Arrangement,
        /// Channels that enter from each of the two sides.
        per_side: u32 = 2..=16,
        /// Distance between two channels where they enter.
        pitch: Length = 2.0..=30.0,
        /// Width.
        width: Length = 1.0..=20.0,
        /// Height: the sheet that the mold's fingers are cut from.
        height: Length = 1.0..=10.0,
        /// Diameter of the chambers, where the arrangement has any.
        chamber_diameter: Length = 1.0..=40.0,
        /// Thinnest silicone between two channels.
        wall: Length = 0.5..=10.0,
    }

    /// The soft layer with the markers, below.
    pub struct MarkerLayer {
        /// Edge of the square layer; what stands out around the channel layer is held by the box.
        side: Length = 20.0..=350.0,
        /// Thickness without markers: the sheet of the mold's frame.
        thickness: Length = 1.0..=10.0,
        /// Trade name.
        material: Castable,
        /// Trade name of the pigment that makes it dark.
        pigment: String = 1..=80,
        /// Share of the pigment by mass.
        pigment_share: f64 = 0.0..=0.1,
    }

    /// The markers.
    pub struct Markers {
        /// How they lie: a square `grid` of `per_row` along each edge, or a `list` of places `x` and `y`.
        pattern: FlatPattern,
        /// List: x of each marker.
        x: Vec<Length> = (1..=1000, -150.0..=150.0),
        /// List: y of each marker.
        y: Vec<Length> = (1..=1000, -150.0..=150.0),
        /// Grid: markers along each edge.
        per_row: u32 = 2..=40,
        /// Grid: distance between two markers.
        pitch: Length = 0.5..=30.0,
        /// Diameter.
        diameter: Length = 0.3..=10.0,
        /// Height: the sheet that the mold's holes are cut into.
        height: Length = 0.5..=10.0,
        /// Thickness of the paint on their ends.
        paint: Length = 0.02..=0.5,
        /// Trade name of the paint.
        paint_material: Castable,
    }

    /// What the molds are made from.
    pub struct Molds {
        /// Sheet below both stacks.
        floor: Length = 1.5..=10.0,
        /// Material of the stack that casts the channel layer.
        channel_material: String = 1..=80,
        /// Material of the stack that casts the marker layer, and of both floors.
        marker_material: String = 1..=80,
    }

    /// The tubes from the interface to the display, and their joints.
    pub struct Tubes {
        /// Outer diameter of the silicone tube.
        outer_diameter: Length = 1.0..=10.0,
        /// Inner diameter.
        inner_diameter: Length = 0.3..=8.0,
        /// Length between interface and display.
        length: Length = 30.0..=3000.0,
        /// How far a tube is glued into its channel.
        insertion: Length = 2.0..=20.0,
        /// Trade name of the glue.
        glue: Castable,
        /// Outer diameter of the steel needle that joins a tube to the display.
        needle_outer_diameter: Length = 0.3..=8.0,
        /// Inner diameter of the needle.
        needle_inner_diameter: Length = 0.1..=7.0,
        /// Length of the needle.
        needle_length: Length = 4.0..=40.0,
    }

    /// The rigid box below the interface, with the camera that sees the markers. Its edges are square, as
    /// those of all sheets that a laser cuts.
    pub struct Housing {
        /// Thickness of its sheets.
        sheet: Length = 2.0..=10.0,
        /// Inner height: the length of the hexagonal spacers in its corners.
        height: Length = 30.0..=300.0,
        /// Edge of the square window below the interface.
        window: Length = 10.0..=300.0,
        /// Fingers and gaps along each upright edge.
        fingers: u32 = 3..=31,
        /// Width of the tabs that locate a wall in the plates above and below it.
        tab: Length = 4.0..=60.0,
        /// Which wall has the opening for the cable: `right` at +x, `left` at -x, `front` at -y, `back` at
        /// +y, towards the display.
        cable_side: Side,
        /// Width of the opening for the cable.
        cable_width: Length = 3.0..=40.0,
        /// Height of the opening for the cable.
        cable_height: Length = 2.0..=30.0,
        /// Thickness of the bars that hold the interface down.
        clamp: Length = 2.0..=10.0,
        /// Distance between the channel layer and the bars.
        clamp_gap: Length = 0.5..=20.0,
        /// Material.
        material: String = 1..=80,
        /// Length of the LED strip on each wall.
        led_strip_length: Length = 10.0..=300.0,
        /// Width of the strip.
        led_strip_width: Length = 3.0..=20.0,
        /// Thickness of the strip.
        led_strip_thickness: Length = 0.5..=6.0,
    }

    /// The display: a plate with one straight channel for each of the interface's.
    pub struct Display {
        /// Thickness of each of its three sheets.
        sheet: Length = 1.0..=10.0,
        /// Length of the channels.
        channel_length: Length = 20.0..=500.0,
        /// Width of the channels.
        channel_width: Length = 0.5..=10.0,
        /// Distance between two channels.
        pitch: Length = 2.0..=30.0,
        /// Length of liquid in a channel while nothing is touched.
        rest_length: Length = 5.0..=400.0,
        /// Distance of the bolts from the channels and from the plate's edges.
        border: Length = 4.0..=40.0,
        /// Length of the hexagonal spacers that carry the camera above it.
        camera_spacer: Length = 20.0..=400.0,
        /// Material of the sheet behind the channels.
        back_material: String = 1..=80,
        /// Material of the other two sheets.
        clear_material: String = 1..=80,
    }

    /// The two cameras, which are the same.
    pub struct Camera {
        /// Module that is bought; its sizes hold where nothing else is written; `none` for sizes by hand.
        module: String = 1..=64,
        /// What to buy.
        model: String = 1..=80,
        /// Image width.
        width_px: u32 = 16..=8192,
        /// Image height.
        height_px: u32 = 16..=8192,
        /// Full angle of view of the lens, over the image's diagonal.
        field_of_view: Angle = 10.0..=170.0,
        /// How the lens lays angles onto the picture.
        projection: LensLaw,
        /// Its lens.
        optics: Inline<Optics>,
        /// Edge of the board along x.
        board_size: Length = 10.0..=80.0,
        /// Edge of the board along y.
        board_size_y: Length = 10.0..=80.0,
        /// Thickness of the board.
        board_thickness: Length = 0.6..=3.0,
        /// Distance between two of its four holes along x.
        hole_spacing: Length = 6.0..=76.0,
        /// Distance between two of its four holes along y.
        hole_spacing_y: Length = 6.0..=76.0,
        /// Height of the spacers behind the board.
        spacer: Length = 2.0..=20.0,
        /// From the board to the lens's front.
        lens_height: Length = 3.0..=50.0,
        /// Edge of the square lens holder.
        holder_size: Length = 4.0..=40.0,
        /// Height of the lens holder above the board.
        holder_height: Length = 1.0..=40.0,
        /// Diameter of the lens barrel.
        barrel_diameter: Length = 3.0..=40.0,
        /// Distance of the entrance pupil behind the lens's front.
        pupil_behind_front: Length = 0.0..=20.0,
    }

    /// A soft interface with liquid channels over markers, cast between laser-cut sheets.
    pub struct SheetMold {
        /// Stock sheets.
        stock: Stock,
        /// The outline that plates share.
        plate: Plate,
        /// The layer with the channels.
        channel_layer: ChannelLayer,
        /// The channels.
        channels: Channels,
        /// The layer with the markers.
        marker_layer: MarkerLayer,
        /// The markers.
        markers: Markers,
        /// The molds.
        molds: Molds,
        /// The tubes.
        tubes: Tubes,
        /// The box.
        housing: Housing,
        /// The display.
        display: Display,
        /// The cameras.
        camera: Camera,
        /// Which parts are made how.
        making: Making,
    }
}

impl Markers {
    /// Returns the listed markers.
    pub fn listed(&self) -> Listed<'_, Length> {
        Listed::new("marker", ("markers.x", &self.x), ("markers.y", &self.y))
    }
}

// ------ Bodies ------
//
// Bodies of the sensor and of its tools, and the assemblies in which they stand together.

/// Assembly of the stack that casts the channel layer.
pub const CHANNEL_MOLD: AssemblyName = AssemblyName("channel-mold");
/// Assembly of the stack that casts the marker layer.
pub const MARKER_MOLD: AssemblyName = AssemblyName("marker-mold");
/// Assembly of the box's floor with its camera, before the walls are around it.
pub const BOX_FOCUSING: AssemblyName = AssemblyName("box-focusing");

crate::bodies! {
    pub MOLD_FLOOR "mold-floor" "closes a stack from below";
    pub CHANNEL_COMB "mold-channel-comb" "its fingers leave the channels in the silicone";
    pub CHANNEL_FRAME "mold-channel-frame" "frame around the silicone above the channels";
    pub MARKER_PLATE "mold-marker-plate" "its holes shape the markers";
    pub MARKER_FRAME "mold-marker-frame"
        "frame around the marker layer: in its mold, and again in the sensor";

    pub BOX_CEILING "box-ceiling" "carries the interface around its window";
    pub BOX_FLOOR "box-floor" "carries the camera";
    pub CABLE_WALL "box-wall-cable" "wall with the way out for the camera's and the LEDs' cables";
    pub BOX_WALL "box-wall" "wall; its fingers mesh with those of its neighbours";
    pub CLAMP_BAR "clamp-bar" "holds the interface down on the box";
    pub DISPLAY_BACK "display-back" "white sheet behind the channels";
    pub DISPLAY_CHANNELS "display-channels"
        "one straight channel for each of the interface's";
    pub DISPLAY_COVER "display-cover" "closes the channels; needles stand in its holes at one end, air leaves at the other";
    pub DISPLAY_SEAL "display-seal"
        "strip that closes the vents at the channels' far ends once they are filled";
    pub STAND_PLATE "stand-plate" "carries the camera that sees the display";

    pub MARKER_PAINT "marker-paint" "white ends of the markers, which the camera tracks";
    pub MARKER_LAYER "marker-layer"
        "dark layer with markers on its underside; closes the channels from below";
    pub CHANNEL_LAYER "channel-layer"
        "clear layer that is touched, with the channels on its underside";
    pub LEFT_GLUE "tube-glue-left" "seals the tubes in their channels";
    pub RIGHT_GLUE "tube-glue-right" "seals the tubes in their channels";
    pub LEFT_LIQUID "liquid-left" "coloured water in the channels that enter from this side";
    pub RIGHT_LIQUID "liquid-right" "coloured water in the channels that enter from this side";
    pub DISPLAY_LIQUID "liquid-display" "coloured water in the display while nothing is touched";

    pub BOX_CABLE "box-camera-cable";
    pub STAND_CABLE "stand-camera-cable";
    pub CAMERA_SPACER "spacer-m2";
    pub BOX_SPACER "box-spacer";
    pub STAND_SPACER "stand-spacer";
    pub TUBE "tube";
    pub NEEDLE "needle";
    pub LED_STRIP "led-strip";
}
