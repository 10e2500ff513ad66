//! Parameters of the flat-gel family, and the names of its bodies.

use fabkit_geometry::Length;

use crate::assembling::AssemblyName;
use crate::blocks::chamber_light::Leds;
use crate::blocks::clamshell::{Base, Shell};
use crate::blocks::frame_mold::FrameMold;
use crate::blocks::marker_grid::Markers;
use crate::blocks::mounting::Mount;
use crate::blocks::posted_camera::PostedCamera;
use crate::materials::Castable;
use crate::processes::Making;
use crate::{choices, parameters, sections};

parameters! {
    /// The pad that touches: gel under a coat. The housing follows from its edges.
    pub struct Pad {
        /// Edge along x, with the coat.
        length: Length = 8.0..=120.0,
        /// Edge along y, with the coat.
        width: Length = 8.0..=120.0,
        /// Thickness of gel and coat together.
        thickness: Length = 0.8..=20.0,
        /// Radius of the upright edges, with the coat.
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
    /// The opaque coat on the pad's top and sides.
    pub struct Coat {
        /// Thickness on the top.
        thickness: Length = 0.02..=3.0,
        /// Thickness on the sides.
        side: Length = 0.02..=5.0,
        /// How it is made.
        by: CoatBy,
        /// Trade name.
        material: Castable,
    }

    /// The clear gel between plate and pad, poured into the shell.
    pub struct Bed {
        /// Thickness; 0 for a pad that is glued to the plate itself.
        thickness: Length = 0.0..=30.0,
        /// Trade name; the pad is glued with it, too.
        material: Castable,
    }

    /// The clear plate that carries the gel; it lies on a ledge in the shell.
    pub struct Plate {
        /// Thickness of the sheet.
        thickness: Length = 1.0..=10.0,
        /// How far the pad reaches over the opening that the plate lies in, on each side.
        overlap: Length = 0.2..=10.0,
        /// Width of the ledge.
        ledge: Length = 0.8..=10.0,
        /// Material.
        material: String = 1..=80,
    }

    /// A flat-gel sensor.
    pub struct FlatGel {
        /// The pad that touches.
        pad: Pad,
        /// The coat.
        coat: Coat,
        /// The clear gel below the pad.
        bed: Bed,
        /// The printed dots.
        markers: Markers,
        /// The clear plate.
        plate: Plate,
        /// The shell.
        shell: Shell,
        /// The base.
        base: Base,
        /// The holes that it is mounted by.
        mount: Mount,
        /// The LEDs.
        leds: Leds,
        /// The camera.
        camera: PostedCamera,
        /// The molds.
        mold: FrameMold,
        /// Which parts are made how.
        making: Making,
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
