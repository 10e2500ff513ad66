//! Contact sheet of a data set: random samples side by side.

use fabkit_depth::ground_truth::false_color;
use fabkit_depth::{RenderedImage, contact_sheet};
use fabkit_files::Error;

use super::halves::cast_half;
use super::plan::shuffled_indices;
use super::{DatasetError, DatasetJob};

const SAMPLES: usize = 12;
const COLUMNS: usize = 4;
const GAP_PX: u32 = 8;

/// Renders the indentations of a few samples chosen by a seed, on a common scale.
///
/// # Errors
/// Fails for a camera too large for a sheet, or a press without a contact solution.
///
/// ```
/// use fabkit_dataset::{DatasetRequest, prepare_job, render_contact_sheet};
/// # use fabkit_files::Error;
/// # use fabkit_scene::press_simulation::ContactModel;
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// # let viewpoint = fabkit_scene::ground_truth::Viewpoint::new(&project.design.sensor.camera, None, None)?;
/// # let viewpoint = viewpoint.resized([40, 30])?;
/// # let scene = fabkit_scene::SensorView::new(std::sync::Arc::new(project), viewpoint)?;
/// # let request = DatasetRequest {
/// #     presses: None,
/// #     captures: None,
/// #     images: None,
/// #     contact: ContactModel::Rigid,
/// #     seam_margin_mm: 0.5,
/// #     allow_no_contact: false,
/// #     seed: 1,
/// #     materialise: false,
/// #     resume: false,
/// # };
/// let sheet = prepare_job(&scene, &|error| Error::bug(error), &request, |job, _| render_contact_sheet(job, 1))?;
/// assert!(sheet.width_px > 40 && sheet.height_px > 30);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn render_contact_sheet(job: &DatasetJob, seed: u64) -> Result<RenderedImage, Error> {
    let count = job.patterns.len();
    let chosen = shuffled_indices(count * count, seed).into_iter().take(SAMPLES);
    let maps: Vec<Vec<f64>> = chosen
        .map(|sample| {
            let (left, right) =
                (cast_half(job, sample / count)?, cast_half(job, count + sample % count)?);
            let stitched = job.seam.stitch(&left.indentation_mm, &right.indentation_mm, f32::NAN);
            Ok(stitched.into_iter().map(f64::from).collect())
        })
        .collect::<Result<_, DatasetError>>()?;
    let largest = maps.iter().flatten().copied().fold(0.0, f64::max);
    let width_px = job.surface.rays().width_px();
    let image = |map: &Vec<f64>| false_color(width_px, map, Some([0.0, largest]));
    let images: Vec<RenderedImage> = maps.iter().map(image).collect();
    Ok(contact_sheet(&images, COLUMNS, GAP_PX).map_err(DatasetError::from)?)
}
