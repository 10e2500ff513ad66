//! Volume, genus and reproducibility of the two benchmark parts.

#[path = "../../examples/peer/scenes.rs"]
mod benchmarked;

use fabkit_mesh::{DEFAULT_TOLERANCE_MM, mesh};

#[test]
fn volumes_are_those_of_the_closed_forms() {
    for scene in benchmarked::all() {
        let triangles = mesh(&scene.solid, DEFAULT_TOLERANCE_MM).unwrap();
        let file = triangles.to_print().unwrap();
        let (volume, area) = (file.volume_mm3(), file.area_mm2());
        let error = (volume - scene.exact_mm3).abs();
        assert!(error < 3e-4 * scene.exact_mm3, "{}: {volume}", scene.name);
        assert!(error < area * DEFAULT_TOLERANCE_MM, "{}: {volume}", scene.name);
        assert_eq!(file.genus(), scene.genus, "{}", scene.name);
    }
}

#[test]
fn large_booleans_do_not_depend_on_the_number_of_threads() {
    // Large enough for the kernel to run in several threads.
    for scene in benchmarked::all() {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| mesh(&scene.solid, DEFAULT_TOLERANCE_MM).unwrap())
        };
        let alone = on(1);
        assert_eq!(on(2), alone);
        assert_eq!(on(8), alone);
    }
}
