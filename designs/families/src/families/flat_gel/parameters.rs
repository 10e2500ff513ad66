//! Parameters of the flat-gel family, and the names of its bodies.

use fabkit_geometry::Length;

use crate::blocks::chamber_light::Leds;
use crate::blocks::clamshell::{Base, Shell};
use crate::blocks::frame_mold::FrameMold;
use crate::blocks::marker_grid::Markers;
use crate::blocks::mounting::Mount;
use crate::blocks::posted_camera::PostedCamera;
use crate::chain_builder::AssemblyName;
use crate::materials::Castable;
use crate::processes::ProcessAssignments;
use crate::{choices, parameters, sections};

parameters! {
    /// Soft pad that touches objects: gel under a coat. The housing's dimensions follow from its edges.
    pub struct Pad {
        /// Edge of the pad along x, including the coat.
        length: Length = 8.0..=120.0,
        /// Edge of the pad along y, including the coat.
        width: Length = 8.0..=120.0,
        /// Thickness of gel and coat together.
        thickness: Length = 0.8..=20.0,
        /// Radius of the pad's upright edges, including the coat.
        corner: Length = 0.2..=20.0,
        /// Trade name of the gel.
        material: Castable,
    }
}

choices! {
    /// Method by which the coat is applied to the gel.
    pub enum CoatBy {
        /// The coat is poured around the gel in a second, wider frame.
        Pour = "pour",
        /// The coat is sprayed or brushed on once the gel is in place.
        Spray = "spray",
    }
}

sections! {
    /// Opaque coat on the top and the sides of the pad.
    pub struct Coat {
        /// Thickness of the coat on the top.
        thickness: Length = 0.02..=3.0,
        /// Thickness of the coat on the sides.
        side: Length = 0.02..=5.0,
        /// Method by which the coat is applied: `pour`, around the gel in a second, wider frame, or `spray`, or with a
        /// brush, once the gel is in place.
        by: CoatBy,
        /// Trade name of the coat.
        material: Castable,
    }

    /// Clear gel between plate and pad, poured into the shell.
    pub struct Bed {
        /// Thickness of the bed; 0 if the pad is glued directly to the plate.
        thickness: Length = 0.0..=30.0,
        /// Trade name of the bed's gel. The pad is also glued with it.
        material: Castable,
    }

    /// Clear plate that carries the gel and lies on a ledge in the shell.
    pub struct Plate {
        /// Thickness of the sheet from which the plate is cut.
        thickness: Length = 1.0..=10.0,
        /// Overlap of the pad on each side over the opening for the plate.
        overlap: Length = 0.2..=10.0,
        /// Width of the ledge on which the plate lies.
        ledge: Length = 0.8..=10.0,
        /// Material of the plate.
        material: String = 1..=80,
    }

    /// Parameters of a flat-gel sensor.
    pub struct FlatGel {
        /// Soft pad that touches objects: gel under a coat. The housing's dimensions follow from its edges.
        pad: Pad,
        /// Opaque coat on the top and the sides of the pad.
        coat: Coat,
        /// Clear gel between plate and pad, poured into the shell.
        bed: Bed,
        /// Dots printed on the gel, under the coat: a grid around the middle, or a list.
        markers: Markers,
        /// Clear plate that carries the gel and lies on a ledge in the shell.
        plate: Plate,
        /// Printed shell, which carries the plate and closes over the camera.
        shell: Shell,
        /// Printed base, which closes the shell and is screwed to a gripper.
        base: Base,
        /// Holes by which the sensor is mounted.
        mount: Mount,
        /// LEDs, on the chamber's walls or on a board around the lens.
        leds: Leds,
        /// Camera and its board. The camera's distance follows from the pixel pitch.
        camera: PostedCamera,
        /// Open molds: frames that slide onto dowels in a floor.
        mold: FrameMold,
        /// Processes by which the parts are made.
        making: ProcessAssignments,
    }
}

// ------ Bodies ------
//
// Bodies of the sensor and of its tools, and the assemblies in which they stand together.

/// Assembly that casts the gel.
pub const GEL_MOLD: AssemblyName = AssemblyName("gel-mold");
/// Assembly that casts the coat around the gel.
pub const COAT_MOLD: AssemblyName = AssemblyName("coat-mold");
/// Assembly that prints the markers.
pub const MARKING: AssemblyName = AssemblyName("marking");

crate::bodies! {
    pub SHELL "shell" "holds plate and light, closes over the camera";
    pub BASE "base" "carries the camera, closes the shell";
    pub PLATE "plate" "clear plate that carries the gel";
    pub GEL_FRAME "mold-gel" "frame: fill to the brim";
    pub COAT_FRAME "mold-coat" "frame: fill to the brim";
    pub BED "bed" "clear gel on and around the plate, up to the shell's rim";
    pub GEL "gel" "soft gel under the coat";
    pub COAT "coat" "opaque coat that touches";
}
