//! Data card: everything that somebody needs to train on the folder.

use fabkit_depth::ground_truth::Uncertainty;
use fabkit_scene::ground_truth::median;
use fabkit_scene::press_simulation::{ContactGap, ContactModel};

use super::halves::{bodies_of_half, with_depth_map};
use super::{DatasetError, DatasetJob, Split};

/// Number of halves for which elastic and rigid contact are compared.
const COMPARED_HALVES: usize = 8;

/// Writes the content of `README.md`.
///
/// # Errors
/// Fails for a press without a contact solution.
pub(super) fn write_card(job: &DatasetJob) -> Result<String, DatasetError> {
    let plan = job.plan;
    let count = plan.patterns.len();
    let of = |split: Split| {
        let left = (0..count).flat_map(|left| (0..count).map(move |right| (left, right)));
        left.filter(|(left, right)| plan.split_of(*left, *right) == split).count()
    };
    let (width, height) = (job.surface.rays().width_px(), job.surface.rays().height_px());
    let sure = match job.uncertainty {
        Some(uncertainty) => describe_uncertainty(job, uncertainty),
        None => "camera and pose count as exact: nobody says how sure they are. `fabkit calibrate` does, and then \
                 each pixel's standard deviation is here"
            .to_owned(),
    };
    let about = serde_json::to_string_pretty(&plan.origin).unwrap_or_default();
    let contact = match job.contact {
        ContactModel::Rigid => "rigid: the gel follows what penetrates it".into(),
        ContactModel::Membrane(mm) => format!("rigid, with a membrane of {mm} mm around it"),
        ContactModel::Linear(_) => "linear (simulated): the layers below give way as elastic ones do, at small strain, and \
                              bulge beside contacts, where indentations are negative. `halves.csv` has forces and \
                              moments of the indenter on the sensor, in the sensor's frame, N and N mm. They rest on \
                              the moduli below and scale with them"
            .into(),
    };
    let samples = if job.materialise {
        "`samples/indentation_mm` and `samples/label` hold them stitched."
    } else {
        "They are not stored: stitch two halves by `is_left` and `is_right` of `reference.npz`, \
             0 where neither holds."
    };
    let model = match job.contact {
        ContactModel::Linear(_) => compare_with_rigid(job)?,
        ContactModel::Rigid | ContactModel::Membrane(_) => {
            "`fabkit depth` in rigid and in linear contact shows it press by press".into()
        }
    };
    Ok(format!(
        "# Ground truth for a tactile sensor\n\n\
         {count} patterns, {halves} half presses, {all} samples of {width} x {height} px: \
         {train} for training, {validation} for validation, {test} for test, {mixed} mixed \
         (their two patterns are for different things; leave them out).\n\n\
         - Zarr version 3; `zarr.open(\"halves/indentation_mm\", mode=\"r\")` in Python.\n\
         - `halves/`: the left halves in the order of `dataset.json`, then the right ones, which \
         are the left ones after half a turn about z.\n\
         - A sample is a left half left of the seam and a right half right of it; `samples.csv` \
         lists them. {samples}\n\
         - Indentation: range without contact minus range with it, mm, along the pixel's ray. \
         Range: `reference.npz`'s `range_mm` minus the indentation. NaN there: no surface.\n\
         - Frames: sensor frame with the origin at the centre of the surface's base circle and +z \
         toward the tip; camera frame as in OpenCV. Pixel centres at integers.\n\
         - Label: 0 no surface or seam, 1 surface, from 2 on the bodies of the pattern in the order \
         of `dataset.json`.\n\
         - Contact: {contact}. Shapes are nominal, not as printed.\n\
         - How sure: {sure}. The error of the contact model comes on top: \
         {model}.\n\n\
         ```python\n\
         import numpy, zarr\n\
         halves, reference = zarr.open(\"halves\", mode=\"r\"), numpy.load(\"reference.npz\")\n\
         left, right = halves[\"indentation_mm\"][0], halves[\"indentation_mm\"][{count}]\n\
         stitched = numpy.where(reference[\"is_left\"], left, 0) + \
         numpy.where(reference[\"is_right\"], right, 0)\n\
         range_mm = reference[\"range_mm\"] - stitched\n\
         ```\n\n\
         Made from:\n\n```json\n{about}\n```\n",
        halves = 2 * count,
        all = count * count,
        train = of(Split::Train),
        validation = of(Split::Validation),
        test = of(Split::Test),
        mixed = of(Split::Mixed),
    ))
}

/// Compares ranges with those of rigid contact, for halves spread over the set.
fn compare_with_rigid(job: &DatasetJob) -> Result<String, DatasetError> {
    let halves = 2 * job.plan.patterns.len();
    let compared = COMPARED_HALVES.min(halves);
    let mut gap = ContactGap::default();
    for number in 0..compared {
        let half = number * halves / compared;
        let rigid = job.surface.map_with_indenters(bodies_of_half(job, half));
        gap.merge(&with_depth_map(job, half, false, |map, _| ContactGap::compare(map, &rigid))?);
    }
    let [touched, beside] = [gap.touched_mm(), gap.outside_contact_mm()];
    Ok(format!(
        "in {compared} of the halves ranges are {:.3} mm rms ({:.3} at most) from those of rigid contact where something \
         touches, and {:.3} mm rms ({:.3} at most) where the surface moves beside that; `fabkit depth` shows it press by press",
        touched[0], touched[1], beside[0], beside[1]
    ))
}

/// Describes the standard deviations of the surface at rest, by medians over its pixels.
fn describe_uncertainty(job: &DatasetJob, uncertainty: &Uncertainty) -> String {
    let sigmas = job.surface.map_without_contact().compute_standard_deviations(uncertainty);
    let [range_mm, point_mm, normal_rad] = [
        median(|| sigmas.range_mm()),
        median(|| sigmas.point_mm()),
        median(|| sigmas.normal_rad()),
    ];
    format!(
        "standard deviations by camera and pose (`sigma_parameters` below), of surfaces as drawn: at rest a range is known to {range_mm:.3} mm, a point to \
         {point_mm:.3} mm, a normal to {normal_rad:.4} rad (medians; `sigma_mm`, `point_sigma_mm` and `normal_sigma_rad` in \
         `reference.npz`), and `halves/indentation_sigma_mm` has those of indentations"
    )
}
