//! Structural comparison of solids, ignoring feature names.

use fabkit_geometry::Solid;

/// Returns a key that is equal for two solids exactly if they are the same tree with the same numbers, apart from
/// names.
pub(crate) fn shape_key(solid: &Solid) -> Vec<u64> {
    solid.shape_key()
}

/// Returns whether the solid contains a half space, whose mesh depends on the solids it is combined with.
pub(crate) fn has_half_space(solid: &Solid) -> bool {
    matches!(solid, Solid::HalfSpace(_)) || solid.children().into_iter().any(has_half_space)
}
