//! The shape every layer of a dome sensor shares.

use fabkit_geometry::{CUT_OVERLAP_MM, Path, Solid};

/// A hemisphere on a straight wall, standing on z = 0: everything a dome sensor encloses out to
/// `radius_mm`.
pub fn dome(radius_mm: f64, wall_height_mm: f64) -> Solid {
    dome_from(0.0, radius_mm, wall_height_mm)
}

/// The same dome as a cutting tool, which goes on below its foot.
pub fn dome_tool(radius_mm: f64, wall_height_mm: f64) -> Solid {
    dome_from(-CUT_OVERLAP_MM, radius_mm, wall_height_mm)
}

/// What lies between two domes of one wall height.
pub fn dome_shell(inner_mm: f64, outer_mm: f64, wall_height_mm: f64) -> Solid {
    dome(outer_mm, wall_height_mm).minus(dome_tool(inner_mm, wall_height_mm))
}

fn dome_from(foot_mm: f64, radius_mm: f64, wall_height_mm: f64) -> Solid {
    let path = Path::from([0.0, foot_mm]).line([radius_mm, foot_mm]);
    let path = if wall_height_mm > foot_mm { path.line([radius_mm, wall_height_mm]) } else { path };
    let apex = [0.0, wall_height_mm + radius_mm];
    Solid::revolution(path.arc(apex, [0.0, wall_height_mm], true).close())
}
