//! The two benchmark parts, checked.

#[path = "../benches/scenes/mod.rs"]
mod scenes;

use fabkit_mesh::{DEFAULT_TOLERANCE_MM, mesh};

#[test]
fn volumes_are_those_of_the_closed_forms() {
    for scene in scenes::all() {
        let triangles = mesh(&scene.solid, DEFAULT_TOLERANCE_MM).unwrap();
        let file = triangles.to_print().unwrap();
        let (volume, area) = (file.volume_mm3(), file.area_mm2());
        let error = (volume - scene.exact_mm3).abs();
        assert!(error < 3e-4 * scene.exact_mm3, "{}: {volume}", scene.name);
        assert!(error < area * DEFAULT_TOLERANCE_MM, "{}: {volume}", scene.name);
        assert_eq!(file.genus(), scene.genus, "{}", scene.name);
    }
}
