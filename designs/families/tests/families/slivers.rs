//! No outline of a built-in sensor has a side that rounding alone made: our meshes do not mind a line of
//! 1e-15 mm, but OpenCascade builds no edge of it.

use fabkit_geometry::{Leaf, Path, Solid};

/// Shorter than what any process makes, and than what any kernel calls a point, mm.
const SHORTEST_MM: f64 = 1e-6;

/// The shortest distance between the ends of a piece, mm.
fn shortest_mm(path: &Path) -> f64 {
    let mut from = path.start;
    let lengths = path.segments.iter().map(|segment| {
        let to = segment.to();
        let length_mm = (to[0] - from[0]).hypot(to[1] - from[1]);
        from = to;
        length_mm
    });
    lengths.fold(f64::INFINITY, f64::min)
}

/// The shortest piece in a tree with the feature that it belongs to, mm.
fn shortest_in(solid: &Solid) -> Option<(f64, &str)> {
    let pieces = solid.leaves().into_iter().filter_map(in_leaf);
    pieces.min_by(|a, b| a.0.total_cmp(&b.0))
}

fn in_leaf(leaf: Leaf<'_>) -> Option<(f64, &str)> {
    let profile = match leaf.primitive {
        Solid::Extrusion(extrusion) => &extrusion.profile,
        Solid::Revolution(revolution) => &revolution.profile,
        _ => return None,
    };
    Some((profile.paths().map(shortest_mm).fold(f64::INFINITY, f64::min), leaf.feature))
}

#[test]
fn no_outline_has_a_side_that_rounding_made() {
    let mut looked_at = 0;
    for name in fabkit_designs::builtin_names() {
        let yaml = fabkit_designs::builtin_yaml(name).unwrap();
        let design = fabkit_designs::load(name, yaml, &[], &["fixtures"]).unwrap();
        for body in &design.sensor.bodies {
            let Some((length_mm, feature)) = shortest_in(&body.solid) else { continue };
            let place = format!("{name}/{}, {feature}", body.name);
            assert!(length_mm >= SHORTEST_MM, "{place}: a side of {length_mm:e} mm");
            looked_at += 1;
        }
    }
    assert!(looked_at > 100, "{looked_at}");
}

#[test]
fn a_side_that_rounding_made_is_seen() {
    let sliver = Path::polygon(&[[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [1e-15, 3.0], [0.0, 3.0]]);
    assert!(shortest_mm(&sliver) < SHORTEST_MM);
}
