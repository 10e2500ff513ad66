//! Every part, layer and component of every built-in sensor and of its fixtures: closed, oriented, of the genus its
//! author counted, and of the volume that exact lines measure.

use fabkit_designs::Design;
use fabkit_geometry::CompiledSolid;
use fabkit_geometry::measure::ray_volume;
use fabkit_mesh::{DEFAULT_TOLERANCE_MM, mesh};
use fabkit_tests::sample_bodies;
use rayon::prelude::*;

/// Lines through each body; enough for about 1e-5 of its volume.
const LINES: u32 = 100_000;

#[test]
fn meshes_are_closed_and_have_the_exact_volume() {
    meshes_have_the_exact_volume(&fabkit_tests::builtin_designs());
}

#[test]
fn meshes_of_fixtures_are_closed_and_have_the_exact_volume() {
    meshes_have_the_exact_volume(&fabkit_tests::builtin_fixtures());
}

fn meshes_have_the_exact_volume(designs: &[Design]) {
    let bodies: Vec<_> =
        designs.iter().flat_map(|d| sample_bodies(d).map(move |b| (d, b))).collect();
    println!("{:40} {:>12} {:>12} {:>10}", "body", "exact mm3", "mesh mm3", "off");
    bodies.par_iter().for_each(|(design, body)| {
        let name = format!("{}/{}", design.sensor.name, body.name);
        let mesh =
            mesh(&body.solid, DEFAULT_TOLERANCE_MM).unwrap_or_else(|e| panic!("{name}: {e}"));
        // Closed and oriented after rounding and welding, or an error.
        let print = mesh.to_print().unwrap_or_else(|e| panic!("{name}: {e}"));
        if let Some(genus) = body.genus {
            assert_eq!(print.genus(), genus, "{name}: genus");
        }
        let exact = ray_volume(&CompiledSolid::new(&body.solid).unwrap(), LINES).unwrap();
        let off = print.volume_mm3() - exact.value_mm3;
        println!("{name:40} {:12.4} {:12.4} {off:10.5}", exact.value_mm3, print.volume_mm3());
        // No facet is farther than the tolerance from the surface, so that the volumes differ by less
        // than the area times the tolerance.
        let bound = print.area_mm2() * DEFAULT_TOLERANCE_MM + exact.error_mm3;
        assert!(off.abs() <= bound, "{name}: {off} mm3 off, bound {bound}");
    });
}

#[test]
fn eighty_five_slots_do_not_cost_accuracy() {
    let designs = fabkit_tests::builtin_designs();
    let design = designs.iter().find(|d| d.sensor.name == "uvdtact").unwrap();
    let layer = design.sensor.layers().find(|l| l.name == "inner-elastomer").unwrap();
    let mesh = mesh(&layer.solid, DEFAULT_TOLERANCE_MM).unwrap();
    let exact = ray_volume(&CompiledSolid::new(&layer.solid).unwrap(), 4 * LINES).unwrap();
    let off = (mesh.volume_mm3() - exact.value_mm3).abs() / exact.value_mm3;
    println!("mesh off by {off:.1e} of {:.3} mm3", exact.value_mm3);
    assert!(off < 3e-4, "{off}");
}
