//! Metrics of a press: a ball on the tip of a dome, or on the middle of a pad.

use fabkit_elastic::SoftStack;
use fabkit_geometry::Sensor;

use super::ComputedMetrics;

/// Radius of the ball, mm: the size of a fingertip. `fabkit press` simulates other balls.
const BALL_RADIUS_MM: f64 = 4.0;
const DEPTH_MM: f64 = 1.0;

/// Computes the group's metrics; a press without solution leaves a note.
pub(super) fn compute(sensor: &Sensor, computed: &mut ComputedMetrics) {
    let Some(touch) = &sensor.touch else { return };
    // The press would be deeper than the surface can give way.
    if touch.max_indentation_mm() < DEPTH_MM {
        let soft_mm = touch.max_indentation_mm();
        computed
            .notes
            .push(format!("press: the surface gives way by {soft_mm} mm, less than {DEPTH_MM} mm"));
        return;
    }
    let press = SoftStack::at_tip(sensor).and_then(|soft| soft.press_tip(BALL_RADIUS_MM, DEPTH_MM));
    match press {
        Ok(press) => {
            computed.put("force_at_1mm_n", press.force_n);
            computed.put("stiffness_n_mm", press.stiffness_n_mm);
            computed.put("bulge_mm", press.bulge_mm);
            let worst = press.bonds.iter().max_by(|a, b| a.shear_mpa.total_cmp(&b.shear_mpa));
            if let Some(worst) = worst {
                computed.put("bond_shear_strain", worst.shear_strain);
                computed.put("bond_shear_kpa", 1e3 * worst.shear_mpa);
            }
        }
        Err(error) => computed.notes.push(format!("press: {error}")),
    }
}
