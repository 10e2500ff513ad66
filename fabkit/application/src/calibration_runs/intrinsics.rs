//! Calibration of the camera's lens from views of a board.

use fabkit_calibration::intrinsics::{LensCalibration, LensModel, calibrate};
use fabkit_calibration::report::ImageRecord;
use fabkit_camera::Camera;
use fabkit_files::Error;
use fabkit_geometry::NominalCamera;

use super::CalibrationRunError;
use super::boards::Views;

/// Fits lens models to the views, starting at the sensor's nominal camera. An empty `models` tries all models.
///
/// # Errors
/// Views that do not determine the lens.
pub fn solve(
    views: &Views,
    nominal: &NominalCamera,
    models: &[LensModel],
) -> Result<LensCalibration, Error> {
    let NominalCamera { width_px, height_px, field_of_view, lens, .. } = nominal;
    let (view_rad, terms) = (field_of_view.rad(), lens.projection.terms());
    let nominal =
        Camera::from_data_sheet(*width_px, *height_px, view_rad, terms).map_err(Error::bug)?;
    let models = if models.is_empty() { &LensModel::ALL[..] } else { models };
    calibrate(&views.usable, &nominal, models).map_err(|source| {
        // Unusable images are the most frequent cause, so the error lists them.
        let of = |record: &ImageRecord| Some((record.file.clone(), record.unused_reason.clone()?));
        let unused = views.records.iter().filter_map(of).collect();
        CalibrationRunError::Lens { source, unused }.into()
    })
}
