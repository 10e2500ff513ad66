//! Comparison of two designs.

use std::collections::BTreeMap;

use fabkit_designs::{Design, design_hash};
use fabkit_files::progress::unwatched;
use fabkit_guide::{Change, Difference, Pairs, Side};
use fabkit_text::Setting;
use rayon::prelude::*;

use crate::pictures::{PictureError, Shot, picture_of_body};

/// Width and height of a part's image, px.
const PART_PX: [u32; 2] = [320, 240];

/// Computes the difference between two designs.
pub fn difference(from: &Design, to: &Design) -> Difference {
    let values = |design: &Design| -> Vec<(String, String)> {
        let value = |setting: &Setting| (setting.path.clone(), setting.value.clone());
        design.parameters.iter().map(value).collect()
    };
    let (values_from, values_to) = (values(from), values(to));
    let (hash_from, hash_to) = (design_hash(from), design_hash(to));
    let from = Side { sensor: &from.sensor, design_hash: &hash_from, parameters: &values_from };
    let to = Side { sensor: &to.sensor, design_hash: &hash_to, parameters: &values_to };
    Difference::between(from, to)
}

/// Writes the difference as one HTML page. Parts whose shape changed are drawn side by side.
///
/// # Errors
/// Bodies that cannot be drawn.
pub fn page(from: &Design, to: &Design, difference: &Difference) -> Result<String, PictureError> {
    let changed: Vec<&str> = difference
        .of(Change::Changed)
        .filter(|one| one.differs.contains(&"shape"))
        .map(|one| one.name.as_str())
        .collect();
    let drawn = |design: &Design| -> Result<BTreeMap<String, Vec<u8>>, PictureError> {
        let bodies = changed.par_iter().filter_map(|name| design.sensor.body(name));
        let shot = Shot { size_px: PART_PX, section: false, from: None };
        let draw = |body: &fabkit_geometry::Body| {
            Ok((body.name.clone(), picture_of_body(body, shot, &unwatched)?))
        };
        bodies.map(draw).collect()
    };
    Ok(difference.to_html(&Pairs { from: drawn(from)?, to: drawn(to)? }))
}
