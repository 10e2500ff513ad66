//! Expected accuracy of the camera's pose from images of pins in the pin dome or pin plate.

use fabkit_calibration::model::FitParameter;
use fabkit_fixtures::{FixtureError, Project};

use super::ComputedMetrics;

/// Computes the group's metrics; notes say why some are missing.
pub(super) fn compute(project: &Project, computed: &mut ComputedMetrics) {
    // The name is `pin dome` or `pin plate`.
    let what = project.pin_fixture_name().replace('-', " ");
    let forecast = match project.pin_forecast() {
        Ok(Ok(forecast)) => forecast,
        Ok(Err(why)) => return computed.notes.push(format!("{what}: {why}")),
        // A sensor that states no surface has neither fixture.
        Err(FixtureError::Unsuitable { .. }) => return,
        Err(FixtureError::Invalid(invalid)) => {
            let messages: Vec<&str> = invalid.problems.iter().map(|p| &*p.message).collect();
            return computed.notes.push(format!("{what}: {}", messages.join("; ")));
        }
        Err(error) => return computed.notes.push(format!("{what}: {error}")),
    };
    computed.put("camera_position_sigma_mm", forecast.pose.position_sigma_mm);
    computed.put("camera_rotation_sigma_deg", forecast.pose.rotation_sigma_deg);
    let offset = FitParameter::SeatingOffset;
    match forecast.with_offset.sigma(offset).filter(|_| forecast.with_offset.is_observable(offset))
    {
        Some(sigma_mm) => computed.put("seating_offset_sigma_mm", sigma_mm),
        None => computed.notes.push(format!("{what}: the seating offset is not observable")),
    }
}
