//! Comparison of two designs.

use std::collections::BTreeMap;

use fabkit_designs::{Design, design_hash};
use fabkit_files::progress::ignore_progress;
use fabkit_guide::{ChangeKind, ComparedDesign, DesignDifference, PartImagePairs};
use fabkit_text::Setting;
use rayon::prelude::*;

use crate::images::{DrawingError, ImageView, draw_body};

/// Width and height of a part's image, px.
const PART_PX: [u32; 2] = [320, 240];

/// Computes the difference between two designs.
///
/// ```
/// use fabkit_application::{design_difference::compute_difference, source::Target};
///
/// let target = Target::new("rtac0");
/// let (drawn, thick) = (target.design(&[])?, target.design(&["coat.thickness=0.1 mm".into()])?);
/// let difference = compute_difference(&drawn, &thick);
/// assert!(difference.parameters.iter().any(|one| one.path == "coat.thickness"));
/// assert!(compute_difference(&drawn, &drawn).parameters.is_empty());
/// # Ok::<(), fabkit_application::Error>(())
/// ```
pub fn compute_difference(from: &Design, to: &Design) -> DesignDifference {
    let values = |design: &Design| -> Vec<(String, String)> {
        let value = |setting: &Setting| (setting.path.clone(), setting.value.clone());
        design.parameters.iter().map(value).collect()
    };
    let (values_from, values_to) = (values(from), values(to));
    let (hash_from, hash_to) = (design_hash(from), design_hash(to));
    let from =
        ComparedDesign { sensor: &from.sensor, design_hash: &hash_from, parameters: &values_from };
    let to = ComparedDesign { sensor: &to.sensor, design_hash: &hash_to, parameters: &values_to };
    DesignDifference::between(from, to)
}

/// Writes the difference as one HTML page. Parts whose shape changed are drawn side by side.
///
/// # Errors
/// Bodies that cannot be drawn.
pub fn difference_page(
    from: &Design,
    to: &Design,
    difference: &DesignDifference,
) -> Result<String, DrawingError> {
    let changed: Vec<&str> = difference
        .with_change(ChangeKind::Changed)
        .filter(|one| one.differs.contains(&"shape"))
        .map(|one| one.name.as_str())
        .collect();
    let drawn = |design: &Design| -> Result<BTreeMap<String, Vec<u8>>, DrawingError> {
        let bodies = changed.par_iter().filter_map(|name| design.sensor.body(name));
        let shot = ImageView { size_px: PART_PX, is_section: false, from: None };
        let draw = |body: &fabkit_geometry::Body| {
            Ok((body.name.clone(), draw_body(body, shot, &ignore_progress)?))
        };
        bodies.map(draw).collect()
    };
    Ok(difference.to_html(&PartImagePairs { from: drawn(from)?, to: drawn(to)? }))
}
