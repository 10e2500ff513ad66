//! Nothing overlaps that is not meant to in what prints and images show: mesh intersection, over every pair of bodies
//! in every assembly of every built-in sensor and fixture. Exact lines are a rule of `fabkit check`, which other tests hold.

use std::cell::OnceCell;
use std::collections::BTreeMap;

use fabkit_designs::Design;
use fabkit_geometry::measure::overlap_volume;
use fabkit_geometry::{Aabb, Body, CompiledSolid, Sensor, Solid};
use fabkit_mesh::{DEFAULT_TOLERANCE_MM, IntersectionCache, intersection_volume_mm3, mesh};

/// Lines through the box that two bodies share.
const LINES: u32 = 20_000;

/// Thickness of what two meshes that only touch have in common, over the smaller one's surface, as a fraction
/// of their tolerance. Most share their triangles, and have nothing; where a hole or a ring cuts the face of
/// one, the triangles around it differ by slivers within the tolerance.
const TOUCHING: f64 = 0.01;

/// Of a body that stands in more places than this, such as a pin in each hole, meshes are
/// intersected in the first ones only; the rule looks at all of them.
const MESHED_PLACES: usize = 3;

struct Placed {
    name: String,
    solid: Solid,
    bounds: Aabb,
    /// Of its mesh, mm2; asked for only where meshes have something in common.
    area_mm2: OnceCell<f64>,
}

/// Bodies by assembly, each in its place.
fn assemblies(sensor: &Sensor) -> BTreeMap<String, Vec<Placed>> {
    let mut assemblies = BTreeMap::<String, Vec<Placed>>::new();
    for Body { name, solid, placements, .. } in &sensor.bodies {
        let mut places = BTreeMap::<&str, usize>::new();
        for placement in placements {
            let place = places.entry(&placement.assembly.0).or_default();
            *place += 1;
            if *place > MESHED_PLACES {
                continue;
            }
            let solid = solid.clone().placed(placement.assembly_from_body);
            let bounds = CompiledSolid::new(&solid).unwrap().bounds();
            assemblies.entry(placement.assembly.0.clone()).or_default().push(Placed {
                name: name.clone(),
                solid,
                bounds,
                area_mm2: OnceCell::new(),
            });
        }
    }
    assemblies
}

fn is_press_fit(sensor: &Sensor, a: &Placed, b: &Placed) -> bool {
    sensor.press_fits.iter().any(|fit| {
        (fit.inner == a.name && fit.outer == b.name) || (fit.inner == b.name && fit.outer == a.name)
    })
}

fn touching_mm3(a: &Placed, b: &Placed) -> f64 {
    let area_mm2 = |placed: &Placed| {
        let meshed = || mesh(&placed.solid, DEFAULT_TOLERANCE_MM).unwrap().area_mm2();
        *placed.area_mm2.get_or_init(meshed)
    };
    TOUCHING * DEFAULT_TOLERANCE_MM * area_mm2(a).min(area_mm2(b))
}

#[test]
fn only_press_fits_overlap() {
    press_fits_alone_overlap(&fabkit_tests::builtin_designs());
}

#[test]
fn only_press_fits_overlap_in_fixtures() {
    press_fits_alone_overlap(&fabkit_tests::builtin_fixtures());
}

fn press_fits_alone_overlap(designs: &[Design]) {
    for design in designs {
        let sensor = &design.sensor;
        let mut wrong = Vec::new();
        let mut meshes = IntersectionCache::new(DEFAULT_TOLERANCE_MM);
        for (assembly, placed) in assemblies(sensor) {
            let mut pairs = 0;
            for (i, a) in placed.iter().enumerate() {
                for b in &placed[i + 1..] {
                    let apart = a.bounds.common(&b.bounds).is_empty();
                    if apart || is_press_fit(sensor, a, b) {
                        continue;
                    }
                    pairs += 1;
                    let mesh_mm3 = meshes.volume_mm3(&a.solid, &b.solid).unwrap();
                    if mesh_mm3 > 0.0 && mesh_mm3 >= touching_mm3(a, b) {
                        wrong.push(format!(
                            "{assembly}: the meshes of {} and {} overlap by {mesh_mm3} mm3",
                            a.name, b.name
                        ));
                    }
                }
            }
            println!("{} / {assembly}: {} bodies, {pairs} pairs", sensor.name, placed.len());
        }
        assert!(wrong.is_empty(), "{}:\n{}", sensor.name, wrong.join("\n"));
    }
}

#[test]
fn an_overlap_is_found() {
    // The negative control: a tube that is 0.02 mm too wide for its gel.
    let gel = Solid::cylinder(10.0, 5.0).minus(Solid::cylinder(5.0, 7.0).at(0.0, 0.0, -1.0));
    let tube = Solid::cylinder(5.02, 5.0);
    let overlap = overlap_volume(
        &CompiledSolid::new(&gel).unwrap(),
        &CompiledSolid::new(&tube).unwrap(),
        LINES,
    )
    .unwrap();
    let ring_mm3 = std::f64::consts::PI * (5.02f64.powi(2) - 25.0) * 5.0;
    assert!((overlap.volume.value_mm3 - ring_mm3).abs() < 0.05 * ring_mm3, "{overlap:?}");
    let meshes = intersection_volume_mm3(&gel, &tube, 0.001).unwrap();
    assert!((meshes - ring_mm3).abs() < 0.1 * ring_mm3, "{meshes}");
}
