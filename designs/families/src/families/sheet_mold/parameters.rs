//! Parameters of the sheet-mold family, and the names of its bodies.

use fabkit_geometry::{Angle, Length};

pub use crate::blocks::CAMERA;
use crate::blocks::cable_openings::HousingSide;
use crate::blocks::listed_markers::{FlatPattern, ListedMarkers};
use crate::blocks::optics::{Optics, ProjectionLaw};
use crate::chain_builder::AssemblyName;
use crate::materials::Castable;
use crate::parameters::Inline;
use crate::processes::ProcessAssignments;
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
    /// Stock sheets from which all rigid parts are cut.
    pub struct Stock {
        /// Length of a stock sheet.
        length: Length = 50.0..=3000.0,
        /// Width of a stock sheet.
        width: Length = 50.0..=2000.0,
        /// Width of the edge of a sheet that stays free of laser cuts.
        margin: Length = 0.0..=50.0,
    }

    /// Outline that mold sheets, box and clamps share, with a bolt in each corner.
    pub struct Plate {
        /// Edge of the square plates.
        side: Length = 40.0..=400.0,
        /// Distance between two bolts along an edge of the plate.
        bolt_spacing: Length = 30.0..=380.0,
        /// Width of the notches for a screwdriver that separates the sheets of a stack.
        pry_width: Length = 4.0..=30.0,
        /// Depth of these notches.
        pry_depth: Length = 1.0..=10.0,
    }

    /// Soft upper layer, with the channels for the liquid.
    pub struct ChannelLayer {
        /// Edge of the square layer.
        side: Length = 20.0..=300.0,
        /// Thickness of the layer above the channels, which is that of the sheet for the mold's frame.
        roof: Length = 1.0..=10.0,
        /// Trade name of the layer's material.
        material: Castable,
    }

    /// Channels for the liquid in the soft layer.
    pub struct Channels {
        /// Arrangement of the channels.
        arrangement: Arrangement,
        /// Number of channels that enter from each of the two sides.
        per_side: u32 = 2..=16,
        /// Distance between two channels where they enter.
        pitch: Length = 2.0..=30.0,
        /// Width of a channel.
        width: Length = 1.0..=20.0,
        /// Height of a channel, which is the thickness of the sheet from which the mold's fingers are cut.
        height: Length = 1.0..=10.0,
        /// Diameter of the chambers, if the arrangement has any.
        chamber_diameter: Length = 1.0..=40.0,
        /// Minimum thickness of silicone between two channels.
        wall: Length = 0.5..=10.0,
    }

    /// Soft lower layer, with the markers.
    pub struct MarkerLayer {
        /// Edge of the square layer. Its rim around the channel layer is held by the box.
        side: Length = 20.0..=350.0,
        /// Thickness of the layer without markers, which is that of the sheet for the mold's frame.
        thickness: Length = 1.0..=10.0,
        /// Trade name of the layer's material.
        material: Castable,
        /// Trade name of the pigment that makes the layer dark.
        pigment: String = 1..=80,
        /// Mass fraction of the pigment.
        pigment_share: f64 = 0.0..=0.1,
    }

    /// Markers on the underside of the marker layer.
    pub struct Markers {
        /// Pattern of the markers: a square `grid` of `per_row` along each edge, or a `list` of positions `x` and `y`.
        pattern: FlatPattern,
        /// For a list: x of each marker.
        x: Vec<Length> = (1..=1000, -150.0..=150.0),
        /// For a list: y of each marker.
        y: Vec<Length> = (1..=1000, -150.0..=150.0),
        /// For a grid: number of markers along each edge.
        per_row: u32 = 2..=40,
        /// For a grid: distance between two markers.
        pitch: Length = 0.5..=30.0,
        /// Diameter of a marker.
        diameter: Length = 0.3..=10.0,
        /// Height of a marker, which is the thickness of the sheet with the mold's holes.
        height: Length = 0.5..=10.0,
        /// Thickness of the paint on the markers' ends.
        paint: Length = 0.02..=0.5,
        /// Trade name of the paint on the markers' ends.
        paint_material: Castable,
    }

    /// Thickness and materials of the mold sheets.
    pub struct Molds {
        /// Thickness of the sheet at the bottom of both mold stacks.
        floor: Length = 1.5..=10.0,
        /// Material of the mold stack in which the channel layer is cast.
        channel_material: String = 1..=80,
        /// Material of the mold stack in which the marker layer is cast, and of both floors.
        marker_material: String = 1..=80,
    }

    /// Tubes between interface and display, and their joints.
    pub struct Tubes {
        /// Outer diameter of the silicone tube.
        outer_diameter: Length = 1.0..=10.0,
        /// Inner diameter of the silicone tube.
        inner_diameter: Length = 0.3..=8.0,
        /// Length of a tube between interface and display.
        length: Length = 30.0..=3000.0,
        /// Length of a tube that is glued into its channel.
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

    /// Rigid box below the interface, with the camera that sees the markers. Its edges are square, like those of all
    /// laser-cut sheets.
    pub struct Housing {
        /// Thickness of the box's sheets.
        sheet: Length = 2.0..=10.0,
        /// Inner height of the box, which is the length of the hexagonal spacers in its corners.
        height: Length = 30.0..=300.0,
        /// Edge of the square window below the interface.
        window: Length = 10.0..=300.0,
        /// Number of fingers and gaps along each upright edge, where two walls interlock.
        fingers: u32 = 3..=31,
        /// Width of the tabs that locate a wall in the plates above and below it.
        tab: Length = 4.0..=60.0,
        /// Wall with the opening for the cable: `right` at +x, `left` at -x, `front` at -y, `back` at +y, towards the
        /// display.
        cable_side: HousingSide,
        /// Width of the opening for the cable.
        cable_width: Length = 3.0..=40.0,
        /// Height of the opening for the cable.
        cable_height: Length = 2.0..=30.0,
        /// Thickness of the clamp bars that hold the interface down.
        clamp: Length = 2.0..=10.0,
        /// Distance between the channel layer and the clamp bars.
        clamp_gap: Length = 0.5..=20.0,
        /// Material of the box.
        material: String = 1..=80,
        /// Length of the LED strip on each wall.
        led_strip_length: Length = 10.0..=300.0,
        /// Width of the LED strip.
        led_strip_width: Length = 3.0..=20.0,
        /// Thickness of the LED strip.
        led_strip_thickness: Length = 0.5..=6.0,
    }

    /// Display: a plate with one straight channel for each channel of the interface.
    pub struct Display {
        /// Thickness of each of the display's three sheets.
        sheet: Length = 1.0..=10.0,
        /// Length of the display's channels.
        channel_length: Length = 20.0..=500.0,
        /// Width of the display's channels.
        channel_width: Length = 0.5..=10.0,
        /// Distance between two channels of the display.
        pitch: Length = 2.0..=30.0,
        /// Length of the liquid column in a channel while nothing touches the sensor.
        rest_length: Length = 5.0..=400.0,
        /// Distance of the bolts from the channels and from the plate's edges.
        border: Length = 4.0..=40.0,
        /// Length of the hexagonal spacers that carry the camera above the display.
        camera_spacer: Length = 20.0..=400.0,
        /// Material of the sheet behind the channels.
        back_material: String = 1..=80,
        /// Material of the other two sheets.
        clear_material: String = 1..=80,
    }

    /// The sensor's two cameras, which are of the same type.
    pub struct Camera {
        /// Camera module that is bought. Its dimensions are used unless others are given; `none` to give all dimensions
        /// by hand.
        module: String = 1..=64,
        /// Type of camera to buy.
        model: String = 1..=80,
        /// Width of the image in pixels.
        width_px: u32 = 16..=8192,
        /// Height of the image in pixels.
        height_px: u32 = 16..=8192,
        /// Full angle of view of the lens, over the image's diagonal.
        field_of_view: Angle = 10.0..=170.0,
        /// Projection of the lens: relation between the angle to its axis and the distance from the image's centre.
        projection: ProjectionLaw,
        /// Optical properties of the lens.
        optics: Inline<Optics>,
        /// Edge of the camera board along x.
        board_size: Length = 10.0..=80.0,
        /// Edge of the camera board along y.
        board_size_y: Length = 10.0..=80.0,
        /// Thickness of the camera board.
        board_thickness: Length = 0.6..=3.0,
        /// Distance between two of the board's four holes along x.
        hole_spacing: Length = 6.0..=76.0,
        /// Distance between two of the board's four holes along y.
        hole_spacing_y: Length = 6.0..=76.0,
        /// Height of the spacers behind the camera board.
        spacer: Length = 2.0..=20.0,
        /// Height of the lens's front above the camera board.
        lens_height: Length = 3.0..=50.0,
        /// Edge of the square lens holder.
        holder_size: Length = 4.0..=40.0,
        /// Height of the lens holder above the camera board.
        holder_height: Length = 1.0..=40.0,
        /// Diameter of the lens barrel.
        barrel_diameter: Length = 3.0..=40.0,
        /// Distance of the entrance pupil behind the lens's front.
        pupil_behind_front: Length = 0.0..=20.0,
    }

    /// Parameters of a soft interface with liquid channels over markers, cast between laser-cut sheets.
    pub struct SheetMold {
        /// Stock sheets from which all rigid parts are cut.
        stock: Stock,
        /// Outline that mold sheets, box and clamps share, with a bolt in each corner.
        plate: Plate,
        /// Soft upper layer, with the channels for the liquid.
        channel_layer: ChannelLayer,
        /// Channels for the liquid in the soft layer.
        channels: Channels,
        /// Soft lower layer, with the markers.
        marker_layer: MarkerLayer,
        /// Markers on the underside of the marker layer.
        markers: Markers,
        /// Thickness and materials of the mold sheets.
        molds: Molds,
        /// Tubes between interface and display, and their joints.
        tubes: Tubes,
        /// Rigid box below the interface, with the camera that sees the markers.
        housing: Housing,
        /// Display: a plate with one straight channel for each channel of the interface.
        display: Display,
        /// The sensor's two cameras, which are of the same type.
        camera: Camera,
        /// Processes by which the parts are made.
        making: ProcessAssignments,
    }
}

impl Markers {
    /// Returns the listed markers.
    pub fn listed(&self) -> ListedMarkers<'_, Length> {
        ListedMarkers::new("marker", ("markers.x", &self.x), ("markers.y", &self.y))
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
