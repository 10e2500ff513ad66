//! What whoever slices a part must know because it follows from the part or from its printer.

/// What the slicer of a printed part is told; what is not said follows from what the part is for.
///
/// Notes say the same for people. Both are written side by side where a part is made, and a test compares
/// them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SliceAdvice {
    /// Height of a layer, mm.
    pub layer_mm: Option<f64>,
    /// Width of a line, mm.
    pub line_mm: Option<f64>,
    /// Lines side by side along each outline.
    pub perimeters: Option<u32>,
    /// How much of the inside is filled, %.
    pub infill_percent: Option<f64>,
    /// Whether it is printed with supports.
    pub supports: Option<bool>,
    /// Width of the brim, mm; 0 for none.
    pub brim_mm: Option<f64>,
}
