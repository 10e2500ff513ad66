//! Liquid columns with air enclosed ahead of them.

/// Ambient air pressure, MPa: the standard atmosphere.
pub const AMBIENT_AIR_MPA: f64 = 0.101_325;

/// A liquid column against enclosed air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiquidColumn {
    /// Cross-section, mm2.
    pub area_mm2: f64,
    /// Volume of the enclosed air at rest, mm3; infinite where the column is open.
    pub air_mm3: f64,
}

impl LiquidColumn {
    /// Returns the gauge pressure, MPa, after a volume of liquid, mm3, has come in, and its derivative, MPa/mm3. The
    /// air is an ideal gas at constant temperature: `p V` is constant.
    pub(super) fn pressure_mpa(&self, squeezed_mm3: f64) -> [f64; 2] {
        if self.air_mm3.is_infinite() {
            return [0.0, 0.0];
        }
        // Newton's iterations may overshoot the available volume.
        let left_mm3 = (self.air_mm3 - squeezed_mm3).max(1e-3 * self.air_mm3);
        let pressure = AMBIENT_AIR_MPA * (self.air_mm3 / left_mm3 - 1.0);
        [pressure, AMBIENT_AIR_MPA * self.air_mm3 / (left_mm3 * left_mm3)]
    }
}
