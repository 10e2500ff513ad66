//! Which subtrees are the same shape, whatever their features are called.

use fabkit_geometry::Solid;

/// Equal for two solids exactly if they are the same tree of the same numbers, names aside.
pub(crate) fn shape_key(solid: &Solid) -> Vec<u64> {
    solid.shape_key()
}

/// Whether a half space is in it: its mesh depends on what it is combined with.
pub(crate) fn has_half_space(solid: &Solid) -> bool {
    matches!(solid, Solid::HalfSpace(_)) || solid.children().into_iter().any(has_half_space)
}
