//! Image of the surface's displacement, seen from outside.

use fabkit_depth::RenderedImage;
use fabkit_depth::ground_truth::false_color;

use super::PressResult;

/// Number of pixels along each side.
const SIDE_PX: u32 = 320;
/// Half width of the visible part of a pad: in contact radii, and at least this in mm.
const CONTACTS: f64 = 4.0;
const LEAST_MM: f64 = 2.0;

/// Draws the outward displacement along the normal, mm, in false colours with a scale. Of a dome, the whole surface is
/// shown with the tip in the middle, by polar angle and azimuth, +x to the right and +y up; of a pad, the surroundings
/// of the press.
pub fn draw_displacement(pressed: &PressResult) -> RenderedImage {
    let (soft, outcome) = (&pressed.soft, &pressed.outcome);
    let reach_s = match soft.disc_radius_mm() {
        Some(radius_mm) => {
            ((CONTACTS * outcome.contact_radius_mm).max(LEAST_MM) / radius_mm).min(1.0)
        }
        None => 1.0,
    };
    let middle = 0.5 * f64::from(SIDE_PX - 1);
    let values = (0..SIDE_PX * SIDE_PX).map(|pixel| {
        let across = (f64::from(pixel % SIDE_PX) - middle) / middle;
        let up = (middle - f64::from(pixel / SIDE_PX)) / middle;
        let (share, azimuth) = (across.hypot(up), up.atan2(across));
        // The chart is a disc: its corners stay blank.
        if share > 1.0 {
            return f64::NAN;
        }
        let s = share * reach_s;
        outcome.displacement_mm(0, azimuth, s).dot(&outcome.outward(azimuth, s))
    });
    false_color(SIDE_PX, &values.collect::<Vec<f64>>(), None)
}
