//! Slicer settings that follow from a part or from its printer.

/// Slicer settings of a printed part. Settings that are `None` follow from the part's purpose.
///
/// Notes tell people the same. Both are written side by side where a part is defined, and a test compares them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SliceAdvice {
    /// Layer height, mm.
    pub layer_mm: Option<f64>,
    /// Line width, mm.
    pub line_mm: Option<f64>,
    /// Number of perimeter lines along each outline.
    pub perimeters: Option<u32>,
    /// Infill, %.
    pub infill_percent: Option<f64>,
    /// True if it is printed with supports.
    pub supports: Option<bool>,
    /// Width of the brim, mm; 0 for none.
    pub brim_mm: Option<f64>,
}
