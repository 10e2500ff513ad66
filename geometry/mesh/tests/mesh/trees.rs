//! Random trees: comparison of the mesh with the exact solid, and of the written mesh with the original.

use fabkit_geometry::{CompiledSolid, Point3, Pose, Ray, Solid, Vector3};
use fabkit_geometry_testing::{cases, trees};
use fabkit_mesh::{MeshError, PrintMesh, TriMesh, mesh};
use proptest::prelude::*;

const TOLERANCE_MM: f64 = 0.03;

/// Number of lines along each side of the grid that integrates the exact volume.
const LINES: usize = 64;

/// Computes the exact volume by summing chords on a grid of parallel lines, and its uncertainty, mm^3.
///
/// Taking every second line in each direction gives four estimates; their spread is the uncertainty.
fn volume_by_rays(body: &CompiledSolid) -> (f64, f64) {
    let bounds = body.bounds();
    if bounds.is_empty() {
        return (0.0, 0.0);
    }
    // An axis that no face is likely to be parallel to.
    let tilt = Pose::z_to(Vector3::new(0.36, 0.48, 0.8), bounds.centre());
    let reach_mm = Vector3::from(bounds.size_mm()).norm() / 2.0;
    let step_mm = 2.0 * reach_mm / LINES as f64;
    let mut sums = [0.0; 4];
    for i in 0..LINES {
        for j in 0..LINES {
            let at = |k: usize| (k as f64 + 0.5) * step_mm - reach_mm;
            let origin = tilt.point(Point3::new(at(i), at(j), 0.0));
            let ray = Ray { origin, direction: tilt.vector(Vector3::z()) };
            let signed = |c: &fabkit_geometry::Crossing| if c.entering { -c.t } else { c.t };
            sums[2 * (i % 2) + j % 2] += body.crossings(&ray).iter().map(signed).sum::<f64>();
        }
    }
    let estimates = sums.map(|s| s * 4.0 * step_mm * step_mm);
    let mean = estimates.iter().sum::<f64>() / 4.0;
    let spread = estimates.iter().map(|e| (e - mean).abs()).fold(0.0, f64::max);
    (mean, spread)
}

fn check(solid: &Solid) {
    let body = CompiledSolid::new(solid).expect("strategies draw valid trees");
    let (exact_mm3, spread_mm3) = volume_by_rays(&body);
    let triangles = match mesh(solid, TOLERANCE_MM) {
        Ok(triangles) => triangles,
        Err(MeshError::Empty) => {
            // Solids thinner than the tolerance may vanish.
            assert!(exact_mm3 < 0.1, "{exact_mm3} mm3, but no mesh: {solid:?}");
            return;
        }
        Err(error) => panic!("{error}: {solid:?}"),
    };
    let (volume_mm3, area_mm2) = (triangles.volume_mm3(), triangles.area_mm2());
    let bound_mm3 = area_mm2 * TOLERANCE_MM + spread_mm3;
    let off_mm3 = (volume_mm3 - exact_mm3).abs();
    assert!(off_mm3 <= bound_mm3, "{off_mm3} mm3 off, bound {bound_mm3}: {solid:?}");

    write(&triangles, solid);
    // Far out, `f32` values are 0.06 micrometres apart, and slivers collapse by the dozen.
    write(&triangles.placed(&Pose::translation(700.0, -300.0, 250.0)), solid);
}

fn write(triangles: &TriMesh, solid: &Solid) {
    let file = triangles.to_print().unwrap_or_else(|e| panic!("{e}: {solid:?}"));
    assert_eq!(file.genus(), triangles.genus());
    let bounds = triangles.bounds();
    let farthest = bounds.min.coords.abs().max().max(bounds.max.coords.abs().max()) as f32;
    let moved_mm = PrintMesh::MAX_DISPLACEMENT_ULPS * f64::from(farthest.next_up() - farthest);
    let off_mm3 = (file.volume_mm3() - triangles.volume_mm3()).abs();
    assert!(off_mm3 <= triangles.area_mm2() * moved_mm, "{off_mm3} mm3 off: {solid:?}");
}

/// Computes a hash that depends on every bit of the mesh.
fn fingerprint(mesh: &TriMesh) -> u64 {
    let coordinates = mesh.vertices.as_flattened().iter().map(|c| c.to_bits());
    let corners = mesh.triangles.as_flattened().iter().map(|&v| u64::from(v));
    let faces = mesh.faces.iter().map(|f| u64::from(f.leaf) << 32 | u64::from(f.face));
    // FNV-1a over words.
    coordinates
        .chain(corners)
        .chain(faces)
        .fold(0xcbf2_9ce4_8422_2325, |hash, word| (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3))
}

proptest! {
    #![proptest_config(cases(1000))]

    #[test]
    fn meshes_have_the_exact_volume_and_can_be_written(solid in trees()) {
        check(&solid);
    }
}

proptest! {
    #![proptest_config(cases(40))]

    #[test]
    fn the_same_solid_gives_the_same_bits_on_any_number_of_threads(solid in trees()) {
        let run = || mesh(&solid, TOLERANCE_MM).map(|m| fingerprint(&m));
        let alone = run();
        for threads in [1, 2, 8] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            prop_assert_eq!(&pool.install(run), &alone);
            // Side by side: the kernel numbers its meshes with one counter for all threads.
            let (a, b) = pool.install(|| rayon::join(run, run));
            prop_assert_eq!(&a, &alone);
            prop_assert_eq!(&b, &alone);
        }
    }
}
