//! Seats for a syringe's tip, through which a mold is filled under pressure.

use fabkit_geometry::{CUT_OVERLAP_MM, Pose, Solid};

/// Diameter of the small end of a male Luer cone, mm: ISO 80369-7, like ISO 594-1 before it, allows 3.925 to 3.990 mm.
const TIP_MM: f64 = 3.96;

/// Increase of the cone's diameter per length: 6 % (ISO 80369-7).
const TAPER: f64 = 0.06;

/// Largest insertion depth of the cone, mm: its smallest length in ISO 80369-7.
const LONGEST_MM: f64 = 7.5;

/// Distance between the tip's end and the far side of the wall, mm: the mixture turns off there.
const BEFORE_TIP_MM: f64 = 1.5;

/// Smallest length of a seat that holds a syringe by friction, mm.
const LEAST_MM: f64 = 3.0;

/// Smallest thickness of a wall for a seat, mm.
pub const LEAST_WALL_MM: f64 = LEAST_MM + BEFORE_TIP_MM;

/// Conical hole through a wall in which a syringe's Luer tip seals.
///
/// ```
/// use fabkit_designs::blocks::sprue::LuerSeat;
/// use fabkit_geometry::{CompiledSolid, Pose};
/// let seat = LuerSeat { wall_mm: 4.0 };
/// // The hole tapers from its mouth into the wall.
/// let hole = CompiledSolid::new(&seat.tool(&Pose::identity(), 0.0))?.bounds();
/// assert!((hole.max.x - seat.mouth_mm()).abs() < 1e-6);
/// assert!(hole.min.z > -1e-9 && hole.max.z > 4.0);
/// # Ok::<(), fabkit_geometry::InvalidSolid>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LuerSeat {
    /// Thickness of the wall, mm.
    pub wall_mm: f64,
}

impl LuerSeat {
    /// Returns the length of the tip inside the wall, mm.
    fn seated_mm(self) -> f64 {
        (self.wall_mm - BEFORE_TIP_MM).min(LONGEST_MM)
    }

    /// Returns the length of the tip outside the wall, mm.
    pub fn stands_out_mm(self) -> f64 {
        LONGEST_MM - self.seated_mm()
    }

    /// Returns the radius at a depth below the mouth, mm.
    fn radius_at(self, depth_mm: f64) -> f64 {
        (TIP_MM + TAPER * (self.seated_mm() - depth_mm)) / 2.0
    }

    /// Returns the radius of the mouth, mm.
    pub fn mouth_mm(self) -> f64 {
        self.radius_at(0.0)
    }

    /// Returns the hole: mouth at the pose's origin, z axis into the wall; it continues by `beyond_mm` in front of the
    /// mouth.
    pub fn tool(self, mouth: &Pose, beyond_mm: f64) -> Solid {
        let ends = [-beyond_mm, self.wall_mm + CUT_OVERLAP_MM];
        let [wide, narrow] = ends.map(|depth| self.radius_at(depth));
        let cone = Solid::cone(wide, narrow, ends[1] - ends[0]).at_z(ends[0]);
        cone.placed(*mouth).named("syringe seat")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn luer_tip_depth_matches_cone_diameter() {
        for wall_mm in [LEAST_WALL_MM, 6.0, 9.0, 20.0] {
            let seat = LuerSeat { wall_mm };
            // The cone's end has the radius of the hole where it comes to rest.
            let held = 2.0 * (seat.mouth_mm() - TIP_MM / 2.0) / TAPER;
            assert!((held - seat.seated_mm()).abs() < 1e-9);
            assert!(held > LEAST_MM - 1e-9 && held < LONGEST_MM + 1e-9, "{wall_mm}: {held}");
            assert!(wall_mm - held >= BEFORE_TIP_MM - 1e-9);
        }
        // The standard's own female cone takes the tip in until its large end: 3.96 + 0.06 x 7.5.
        let mouth = 2.0 * LuerSeat { wall_mm: 9.0 }.mouth_mm();
        assert!((mouth - 4.41).abs() < 1e-9, "{mouth}");
    }
}
