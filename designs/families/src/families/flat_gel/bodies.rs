//! What the sensor consists of and is made with, and where bodies stand together.

use crate::assembling::AssemblyName;

/// Casting the gel.
pub const GEL_MOLD: AssemblyName = AssemblyName("gel-mold");
/// Casting the coat around it.
pub const COAT_MOLD: AssemblyName = AssemblyName("coat-mold");
/// Printing the markers.
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
