//! Bought pieces against the tables of their standards, smallest and largest sizes, in mm. The tables
//! are written out here once more: what is modelled must not be checked against itself.

use std::f64::consts::PI;

use fabkit_designs::{
    Design, Dowel, HeatSetNut, HexNut, ORing, Screw, SocketScrew, builtin_yaml, load,
};
use fabkit_geometry::measure::ray_volume;
use fabkit_geometry::{CompiledSolid, Point3, Ray, Solid, Vector3};

/// The smallest and the largest, mm.
type Limits = [f64; 2];
type PanRow = (f64, Limits, Limits, Limits);
type CountersunkRow = (f64, f64, Limits, f64, Limits);

/// Arithmetic alone.
const EXACT: f64 = 1e-9;

/// ISO 7045, product grade A: thread, dk, k, shortest and longest screw.
const ISO_7045: [PanRow; 3] = [
    (1.6, [2.9, 3.2], [1.16, 1.3], [3.0, 16.0]),
    (2.0, [3.7, 4.0], [1.46, 1.6], [3.0, 20.0]),
    (3.0, [5.3, 5.6], [2.26, 2.4], [4.0, 30.0]),
];
/// Lengths that ISO 7045 and ISO 7046 have between 3 and 20 mm.
const LENGTHS: [f64; 9] = [3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0];
/// ISO 7046-1 (M1.2: DIN 963): thread, theoretical dk max, dk, k max; ISO 15065 (M1.2: DIN 74 form A
/// as the largest): Dc.
const COUNTERSUNK: [CountersunkRow; 2] =
    [(1.2, 2.64, [2.16, 2.3], 0.72, [2.64, 2.8]), (2.0, 4.4, [3.5, 3.8], 1.2, [4.4, 4.5])];
/// ISO 273, medium.
const ISO_273: [(f64, f64); 4] = [(1.2, 1.4), (1.6, 1.8), (2.0, 2.4), (3.0, 3.4)];
/// ISO 4032: thread, s, m.
const ISO_4032: [(f64, [f64; 2], [f64; 2]); 2] =
    [(2.0, [3.82, 4.0], [1.35, 1.6]), (3.0, [5.32, 5.5], [2.15, 2.4])];

fn sensor(name: &str, sets: &[&str]) -> Design {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    load(name, builtin_yaml(name).unwrap(), &sets, &["fixtures"])
        .unwrap_or_else(|e| panic!("{:#?}", e.problems))
}

/// Where a line crosses a solid.
fn along(solid: &Solid, origin: [f64; 3], direction: [f64; 3]) -> Vec<f64> {
    let ray = Ray { origin: Point3::from(origin), direction: Vector3::from(direction) };
    CompiledSolid::new(solid).unwrap().crossings(&ray).iter().map(|crossing| crossing.t).collect()
}

/// Distance of the outermost surface from the z axis at a height.
fn radius(solid: &Solid, z: f64) -> f64 {
    along(solid, [0.0, 0.0, z], [1.0, 0.0, 0.0]).last().copied().unwrap_or(0.0)
}

#[test]
fn screws_are_those_of_their_standards() {
    let screws = [
        Screw::M1_6X5,
        Screw::M1_6X6,
        Screw::M3X4,
        Screw::M2X12,
        Screw::M2X16,
        Screw::M3X12,
        Screw::M3X16,
        Screw { length_mm: 6.0, ..Screw::M3X4 },
    ];
    for screw in screws {
        let (_, dk, k, lengths) =
            ISO_7045.into_iter().find(|(thread, ..)| *thread == screw.thread_mm).unwrap();
        assert_eq!(screw.standard(), "ISO 7045");
        let solid = screw.solid();
        assert!((2.0 * radius(&solid, k[0] / 2.0) - dk[1]).abs() < EXACT, "{screw:?}");
        let ends = along(&solid, [0.0; 3], [0.0, 0.0, 1.0]);
        assert!((ends[1] - k[1]).abs() < EXACT && ends[0] == -screw.length_mm, "{screw:?}");
        assert!(dk[0] < dk[1] && k[0] < k[1]);
        assert!((lengths[0]..=lengths[1]).contains(&screw.length_mm), "{screw:?}");
        assert!(LENGTHS.contains(&screw.length_mm), "{screw:?}");
    }
    for (thread_mm, hole) in ISO_273 {
        assert_eq!(Screw { thread_mm, ..Screw::M3X4 }.clearance_hole_mm(), hole);
    }
}

#[test]
fn the_largest_head_does_not_stand_proud_of_the_smallest_countersink() {
    for (screw, standard) in [(Screw::M1_2X3, "DIN 963"), (Screw::M2X4, "ISO 7046")] {
        let (_, sharp, dk, k, dc) =
            COUNTERSUNK.into_iter().find(|(thread, ..)| *thread == screw.thread_mm).unwrap();
        assert_eq!(screw.standard(), standard);
        let solid = screw.solid();
        // The modelled head is the largest: rim, cone and height.
        assert!((2.0 * radius(&solid, -1e-6) - dk[1]).abs() < EXACT && dk[0] < dk[1]);
        assert!((sharp - screw.thread_mm - 2.0 * k).abs() < EXACT, "a cone of 90 degrees");
        assert!((2.0 * radius(&solid, -k - 1e-6) - screw.thread_mm).abs() < EXACT);
        for gap_mm in [0.0, 0.05, 0.1] {
            let tool = screw.clearance_tool(3.0, gap_mm);
            let at_surface = 2.0 * (radius(&tool, 0.0) - gap_mm);
            assert!((dc[0] - EXACT..=dc[1]).contains(&at_surface), "{screw:?}: {at_surface}");
            for step in 0..=100 {
                let depth = k * f64::from(step) / 100.0;
                let head = (dk[1] / 2.0).min(sharp / 2.0 - depth);
                let room = radius(&tool, -depth);
                assert!(room >= head + gap_mm - EXACT, "{screw:?} {depth}: {room} {head}");
                assert!(radius(&solid, -depth - 1e-9) <= head + 1e-6, "{screw:?} {depth}");
            }
            let depth = (at_surface - screw.clearance_hole_mm()) / 2.0 + gap_mm;
            assert!((screw.sink_depth_mm(gap_mm) - depth).abs() < EXACT);
        }
    }
}

#[test]
fn nuts_socket_screws_inserts_and_dowels_are_those_of_their_tables() {
    for nut in [HexNut::M2, HexNut::M3] {
        let (_, s, m) = ISO_4032.into_iter().find(|(t, ..)| *t == nut.thread_mm).unwrap();
        let flats = along(&nut.solid(), [0.0, 0.0, m[0] / 2.0], [0.0, 1.0, 0.0]);
        assert!((2.0 * flats.last().unwrap() - s[1]).abs() < EXACT && s[0] < s[1]);
        let beside = along(&nut.solid(), [0.0, 0.45 * s[1], 0.0], [0.0, 0.0, 1.0]);
        assert!((beside[1] - beside[0] - m[1]).abs() < EXACT && m[0] < m[1]);
    }
    // ISO 4762: dk 8.28 to 8.5, k 4.82 to 5; ISO 273: 5.5.
    let solid = SocketScrew::M5.solid(12.0);
    assert!((2.0 * radius(&solid, 1.0) - 8.5).abs() < EXACT);
    assert_eq!(along(&solid, [0.0; 3], [0.0, 0.0, 1.0]), [-12.0, 5.0]);
    assert_eq!(SocketScrew::M5.clearance_hole_mm, 5.5);
    for (wanted, length) in [(12.0, 12.0), (13.9, 12.0), (14.1, 16.0), (1.0, 8.0), (23.0, 25.0)] {
        assert_eq!(SocketScrew::length_near_mm(wanted), length);
    }
    // Pencom MNZ-M2: hole 2.65 + 0.1, insert 3.0, length 3.0, wall 0.8.
    let nut = HeatSetNut::M2;
    assert!((2.65..=2.75).contains(&nut.hole_mm) && nut.wall_mm == 0.8);
    assert_eq!((nut.diameter_mm, nut.length_mm), (3.0, 3.0));
    // ISO 2338.
    let ordered = |diameter_mm, length_mm| Dowel { diameter_mm, length_mm }.specification();
    assert_eq!(ordered(3.0, 8.0), "dowel pin ISO 2338, 3 x 8 mm");
    for (diameter_mm, length_mm) in [(3.0, 7.0), (3.0, 6.0), (3.2, 8.0), (3.0, 9.0), (2.0, 22.0)] {
        let specification = ordered(diameter_mm, length_mm);
        assert!(specification.contains("no size of ISO 2338"), "{specification}");
    }
    let rtac0 = sensor("rtac0", &["molds.route=printed"]);
    let dowel = rtac0.sensor.components().find(|c| c.name == "dowel").unwrap();
    assert_eq!(dowel.summary, ordered(3.0, 8.0));
}

/// A ring in its groove, from the solids of the parts around it.
struct Groove {
    /// Across the cord where it is squeezed.
    height: f64,
    width: f64,
    /// What the ring is stretched over.
    inside: f64,
}

fn component<'a>(design: &'a Design, name: &str) -> &'a Solid {
    &design.sensor.components().find(|c| c.name == name).unwrap().solid
}

fn part<'a>(design: &'a Design, name: &str) -> &'a Solid {
    &design.sensor.body(name).unwrap().solid
}

/// Around the connector's plug, closed by the tube.
fn rtac0_groove(design: &Design) -> Groove {
    let connector = part(design, "connector");
    let middle_z = CompiledSolid::new(component(design, "o-ring")).unwrap().bounds().centre_z();
    let bottom = radius(connector, middle_z);
    let tube = along(component(design, "tube"), [0.0, 0.0, middle_z], [1.0, 0.0, 0.0]);
    let bore = tube[tube.len() - 2];
    let walls = along(connector, [(bottom + bore) / 2.0, 0.0, middle_z], [0.0, 0.0, 1.0]);
    let above = walls.iter().copied().filter(|t| *t > 0.0).fold(f64::INFINITY, f64::min);
    let below = walls.iter().copied().filter(|t| *t < 0.0).fold(f64::NEG_INFINITY, f64::max);
    Groove { height: bore - bottom, width: above - below, inside: 2.0 * bottom }
}

/// On the body's neck, below the lens, inside the ring.
fn tactip_groove(design: &Design) -> Groove {
    let [body, lens, ring] = ["body", "lens", "ring"].map(|name| part(design, name));
    let middle_z = CompiledSolid::new(component(design, "o-ring")).unwrap().bounds().centre_z();
    let neck = radius(body, middle_z);
    let outer = along(ring, [0.0, 0.0, middle_z], [1.0, 0.0, 0.0]);
    let bore = outer.into_iter().find(|t| *t > 0.0).unwrap();
    let x = (neck + bore) / 2.0;
    let seat = along(body, [x, 0.0, middle_z], [0.0, 0.0, 1.0]);
    let seat = seat.into_iter().filter(|t| *t < 0.0).fold(f64::NEG_INFINITY, f64::max);
    let cover = along(lens, [x, 0.0, middle_z], [0.0, 0.0, 1.0]);
    let cover = cover.into_iter().find(|t| *t > 0.0).unwrap();
    Groove { height: cover - seat, width: bore - neck, inside: 2.0 * neck }
}

trait CentreZ {
    fn centre_z(&self) -> f64;
}

impl CentreZ for fabkit_geometry::Aabb {
    fn centre_z(&self) -> f64 {
        (self.min.z + self.max.z) / 2.0
    }
}

#[test]
fn o_rings_are_stocked_keep_their_volume_and_have_grooves_that_suit_them() {
    type OfDesign = fn(&Design) -> Groove;
    let cases: [(&str, &[&str], &str, OfDesign); 5] = [
        ("rtac0", &[], "18 x 2", rtac0_groove),
        ("rtac0", &["connector.o_ring_cord=1.78mm"], "18.77 x 1.78", rtac0_groove),
        ("rtac0", &["connector.o_ring_cord=1.5mm"], "19 x 1.5", rtac0_groove),
        ("tactip", &[], "19 x 1", tactip_groove),
        ("tactip", &["seal.squeeze=0.2"], "19 x 1", tactip_groove),
    ];
    for (name, sets, size, groove) in cases {
        let design = sensor(name, sets);
        let ring = design.sensor.components().find(|c| c.name == "o-ring").unwrap();
        let said = &ring.summary;
        assert!(said.starts_with(&format!("O-ring {size} mm, ")), "{said}");
        let (inside, cord) = size.split_once(" x ").unwrap();
        let [inside, cord]: [f64; 2] = [inside, cord].map(|mm| mm.parse().unwrap());

        // Rubber keeps its volume: pi^2 / 4 d^2 (D + d). Lines measure to some 1e-5.
        let volume = PI * PI / 4.0 * cord * cord * (inside + cord);
        let modelled =
            ray_volume(&CompiledSolid::new(&ring.solid).unwrap(), 60_000).unwrap().value_mm3;
        assert!((modelled / volume - 1.0).abs() < 1e-3, "{name}: {modelled} mm3, free {volume}");

        let Groove { height, width, inside: over } = groove(&design);
        let stretch = over / inside - 1.0;
        assert!((-0.01..=0.05).contains(&stretch), "{name}: stretched by {stretch}");
        // The stretched cord, its middle as far out as its inside and half of itself.
        let stretched = ORing { inside_mm: inside, cord_mm: cord, standard: "" };
        let thin = stretched.stretched_cord_mm(over);
        let check = PI * PI / 4.0 * thin * thin * (over + thin);
        assert!((check / volume - 1.0).abs() < 1e-9, "{check} {volume}");
        let squeeze = 1.0 - height / thin;
        assert!((0.1..=0.3).contains(&squeeze), "{name}: squeezed by {squeeze}");
        let fill = PI / 4.0 * thin * thin / (height * width);
        assert!((0.6..=0.85).contains(&fill), "{name}: filled to {fill}");
        println!(
            "{name} {said}: {modelled:.2} of {volume:.2} mm3, stretch {stretch:.4}, \
                  squeeze {squeeze:.3}, fill {fill:.3}"
        );
    }
    // What is not stocked is refused by name.
    for (name, set, path) in [
        ("rtac0", "connector.o_ring_cord=2.2mm", "connector.o_ring_cord"),
        ("tactip", "seal.cord=0.9mm", "seal.cord"),
    ] {
        let refused =
            load(name, builtin_yaml(name).unwrap(), &[set.to_owned()], &["fixtures"]).unwrap_err();
        let found = refused.problems.iter().find(|problem| problem.path == path).unwrap();
        assert!(found.message.contains("no O-ring of that cord is stocked"), "{}", found.message);
    }
}

#[test]
fn a_ring_is_found_for_every_groove_that_is_wide_enough() {
    // Whole millimetres, stretched by 5 % or slack by 1 %, leave no gap from 17 mm.
    for step in 0..4000 {
        let bottom_mm = 17.0 + 0.01 * f64::from(step);
        let ring = ORing::find_stocked(2.0, bottom_mm).unwrap_or_else(|| panic!("{bottom_mm}"));
        let stretch = bottom_mm / ring.inside_mm - 1.0;
        // 17.85 mm stretch a ring of 17 mm by 5 %, but for the last digit.
        assert!((-0.01..=0.05 + 1e-9).contains(&stretch), "{bottom_mm}: {ring:?}");
    }
    assert_eq!(ORing::find_stocked(2.0, 3.5), None);
    assert_eq!(ORing::find_stocked(2.2, 18.0), None);
    assert_eq!(ORing::find_stocked(1.78, 19.15).map(|ring| ring.inside_mm), Some(18.77));
}
