//! Nothing overlaps that is not meant to: exact lines and mesh intersection, over every pair of
//! bodies in every assembly of every built-in sensor.

use std::collections::BTreeMap;

use fabkit_geometry::measure::overlap_volume;
use fabkit_geometry::{Body, PressFit, Sensor, Solid};
use fabkit_mesh::{DEFAULT_TOLERANCE_MM, intersection_volume_mm3, mesh};

/// Lines through the box that two bodies share.
const LINES: u32 = 20_000;

/// Largest common volume of two meshes that only touch, mm3.
const TOUCHING_MM3: f64 = 1e-6;

struct Placed {
    name: String,
    solid: Solid,
    body: Body,
}

/// Bodies by assembly, each in its place.
fn assemblies(sensor: &Sensor) -> BTreeMap<String, Vec<Placed>> {
    let parts = sensor.parts.iter().map(|p| (&p.name, &p.solid, &p.placements));
    let layers = sensor.layers.iter().map(|l| (&l.name, &l.solid, &l.placements));
    let components = sensor.components.iter().map(|c| (&c.name, &c.solid, &c.placements));
    let mut assemblies = BTreeMap::<String, Vec<Placed>>::new();
    for (name, solid, placements) in parts.chain(layers).chain(components) {
        for placement in placements {
            let solid = solid.clone().placed(placement.assembly_from_body);
            let body = Body::new(&solid).unwrap();
            assemblies.entry(placement.assembly.0.clone()).or_default().push(Placed {
                name: name.clone(),
                solid,
                body,
            });
        }
    }
    assemblies
}

fn press_fit<'a>(sensor: &'a Sensor, a: &Placed, b: &Placed) -> Option<&'a PressFit> {
    sensor.press_fits.iter().find(|fit| {
        (fit.inner == a.name && fit.outer == b.name) || (fit.inner == b.name && fit.outer == a.name)
    })
}

/// A press fit overlaps by no more than its interference all over the inner body's surface.
fn is_within(fit: &PressFit, volume_mm3: f64, inner: &Placed) -> bool {
    let area_mm2 = mesh(&inner.solid, DEFAULT_TOLERANCE_MM).unwrap().area_mm2();
    volume_mm3 <= fit.interference_mm * area_mm2
}

#[test]
fn only_press_fits_overlap() {
    for design in fabkit_tests::builtin_designs() {
        let sensor = &design.sensor;
        let mut met = vec![false; sensor.press_fits.len()];
        let mut wrong = Vec::new();
        for (assembly, placed) in assemblies(sensor) {
            let mut pairs = 0;
            for (i, a) in placed.iter().enumerate() {
                for b in &placed[i + 1..] {
                    if a.body.bounds().common(&b.body.bounds()).is_empty() {
                        continue;
                    }
                    pairs += 1;
                    let overlap = overlap_volume(&a.body, &b.body, LINES).unwrap();
                    let exact_mm3 = overlap.volume.value_mm3;
                    if let Some(fit) = press_fit(sensor, a, b) {
                        let inner = if fit.inner == a.name { a } else { b };
                        let index = sensor.press_fits.iter().position(|f| f == fit).unwrap();
                        met[index] |= exact_mm3 > 0.0;
                        if !is_within(fit, exact_mm3, inner) {
                            wrong.push(format!(
                                "{assembly}: {} in {} overlaps by {exact_mm3} mm3, more than its \
                                 fit says",
                                fit.inner, fit.outer
                            ));
                        }
                        continue;
                    }
                    let mesh_mm3 =
                        intersection_volume_mm3(&a.solid, &b.solid, DEFAULT_TOLERANCE_MM).unwrap();
                    if exact_mm3 > 0.0 || mesh_mm3 >= TOUCHING_MM3 {
                        wrong.push(format!(
                            "{assembly}: {} and {} overlap: exact {exact_mm3} mm3 at {:?}, meshes \
                             {mesh_mm3} mm3",
                            a.name, b.name, overlap.witness
                        ));
                    }
                }
            }
            println!("{} / {assembly}: {} bodies, {pairs} pairs", sensor.name, placed.len());
        }
        for (fit, met) in sensor.press_fits.iter().zip(met) {
            if !met {
                wrong.push(format!(
                    "{} in {} is declared but does not overlap",
                    fit.inner, fit.outer
                ));
            }
        }
        assert!(wrong.is_empty(), "{}:\n{}", sensor.name, wrong.join("\n"));
    }
}

#[test]
fn an_overlap_is_found() {
    // The negative control: a tube that is 0.02 mm too wide for its gel.
    let gel = Solid::cylinder(10.0, 5.0).minus(Solid::cylinder(5.0, 7.0).at(0.0, 0.0, -1.0));
    let tube = Solid::cylinder(5.02, 5.0);
    let overlap =
        overlap_volume(&Body::new(&gel).unwrap(), &Body::new(&tube).unwrap(), LINES).unwrap();
    let ring_mm3 = std::f64::consts::PI * (5.02f64.powi(2) - 25.0) * 5.0;
    assert!((overlap.volume.value_mm3 - ring_mm3).abs() < 0.05 * ring_mm3, "{overlap:?}");
    let meshes = intersection_volume_mm3(&gel, &tube, 0.001).unwrap();
    assert!((meshes - ring_mm3).abs() < 0.1 * ring_mm3, "{meshes}");
}
