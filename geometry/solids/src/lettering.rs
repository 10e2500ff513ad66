//! Lettering on parts: features that only identify a part.

use crate::Solid;

/// Names of the features that are lettering: a part's label, and the number of one of several copies.
pub const LETTERING_FEATURES: [&str; 2] = ["label", "number"];

/// Returns whether a part carries lettering.
pub fn has_lettering(solid: &Solid) -> bool {
    solid.leaves().iter().any(|leaf| LETTERING_FEATURES.contains(&leaf.feature))
}

/// Removes the lettering from a solid, for rules that measure walls and edges: letters leave ridges without a function.
///
/// ```
/// use fabkit_geometry::{Solid, has_lettering, without_lettering};
/// let plate = Solid::cuboid(20.0, 8.0, 2.0);
/// let letter = Solid::cuboid(0.6, 4.0, 1.0).at(0.0, 0.0, 1.6).named("label");
/// let labelled = plate.clone().minus(letter);
/// assert!(has_lettering(&labelled) && !has_lettering(&without_lettering(&labelled)));
/// ```
#[must_use]
pub fn without_lettering(solid: &Solid) -> Solid {
    let is_kept = |solid: &&Solid| !is_letters(solid);
    // Only operands of unions and tools of differences are dropped: lettering is never the base of a part.
    let each = |solids: &[Solid]| solids.iter().filter(is_kept).map(without_lettering).collect();
    match solid {
        Solid::Union(of) => Solid::Union(each(of)),
        Solid::Difference { of, minus } => {
            let minus: Vec<Solid> = each(minus);
            if minus.is_empty() {
                without_lettering(of)
            } else {
                Solid::Difference { of: Box::new(without_lettering(of)), minus }
            }
        }
        Solid::Placed { pose, of } => {
            Solid::Placed { pose: *pose, of: Box::new(without_lettering(of)) }
        }
        Solid::Feature { name, of } => {
            Solid::Feature { name: name.clone(), of: Box::new(without_lettering(of)) }
        }
        other => other.clone(),
    }
}

fn is_letters(solid: &Solid) -> bool {
    match solid {
        Solid::Feature { name, .. } => LETTERING_FEATURES.contains(&name.as_str()),
        Solid::Placed { of, .. } => is_letters(of),
        _ => false,
    }
}
