//! Columns of liquid with air shut in ahead of them.

/// Pressure of the air around, MPa: the standard atmosphere.
pub const AIR_MPA: f64 = 0.101_325;

/// A column of liquid that shut-in air pushes back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Column {
    /// Its cross-section, mm2.
    pub area_mm2: f64,
    /// Of the air at rest, mm3; infinite where the column is open.
    pub air_mm3: f64,
}

impl Column {
    /// Pressure above that of the air around, MPa, once so much liquid has come in, mm3, and how it grows with it,
    /// MPa/mm3: an ideal gas whose temperature stays, `p V` as before.
    pub(super) fn pressure_mpa(&self, squeezed_mm3: f64) -> [f64; 2] {
        if self.air_mm3.is_infinite() {
            return [0.0, 0.0];
        }
        // Iterations may ask for more than there is room for.
        let left_mm3 = (self.air_mm3 - squeezed_mm3).max(1e-3 * self.air_mm3);
        let pressure = AIR_MPA * (self.air_mm3 / left_mm3 - 1.0);
        [pressure, AIR_MPA * self.air_mm3 / (left_mm3 * left_mm3)]
    }
}
