//! Outlines widened for the kerf are parallel curves.

use std::f64::consts::{PI, TAU};

use fabkit_export::{ExportError, widen_for_kerf};
use fabkit_geometry::{Path, Profile, Segment};
use proptest::prelude::*;

const KERF_MM: f64 = 0.2;
const HALF_MM: f64 = KERF_MM / 2.0;

/// Coordinates of some 10 mm carry 1e-15 mm, intersections lose a few digits, areas multiply by
/// lengths of 100 mm.
const AREA_SLACK_MM2: f64 = 1e-10;

fn widened(outer: Path) -> Profile {
    widen_for_kerf(&Profile::new(outer), KERF_MM).unwrap()
}

#[test]
fn convex_outlines_grow_as_steiner_says() {
    let sector = Path::from([0.0, 0.0]).line([9.0, 0.0]).arc([0.0, 9.0], [0.0, 0.0], true).close();
    let clockwise = Path::polygon(&[[0.0, 0.0], [3.0, 7.0], [8.0, 1.0]]);
    // Three quarters of a circle as one arc.
    let large_arc = Path::from([5.0, 0.0]).arc([0.0, -5.0], [0.0, 0.0], true).close();
    let outlines = [
        Path::circle([4.0, -3.0], 6.0),
        Path::rectangle([1.0, 2.0], [30.0, 20.0], 0.0),
        Path::rectangle([1.0, 2.0], [30.0, 20.0], 3.0),
        Path::slot([0.0, 0.0], [12.0, 5.0], 2.0),
        sector,
        clockwise,
        large_arc,
    ];
    for outline in outlines {
        let before = Profile::new(outline);
        let (area, length) = (before.area_mm2(), before.boundary_mm());
        let after = widen_for_kerf(&before, KERF_MM).unwrap();
        let expected = area + length * HALF_MM + PI * HALF_MM * HALF_MM;
        assert!((after.area_mm2() - expected).abs() < AREA_SLACK_MM2, "{before:?}");
        assert!((after.boundary_mm() - length - TAU * HALF_MM).abs() < AREA_SLACK_MM2);
        let ([a, b], [c, d]) = (before.bounds_mm(), after.bounds_mm());
        for i in 0..2 {
            assert!((a[i] - c[i] - HALF_MM).abs() < 1e-12 && (d[i] - b[i] - HALF_MM).abs() < 1e-12);
        }
    }
}

#[test]
fn holes_shrink_and_keep_their_corners() {
    let plate = Profile::new(Path::rectangle([0.0, 0.0], [40.0, 40.0], 0.0))
        .with_hole(Path::rectangle([-8.0, 0.0], [6.0, 4.0], 0.0))
        .with_hole(Path::rectangle([8.0, 0.0], [6.0, 4.0], 0.5))
        .with_hole(Path::circle([0.0, 12.0], 1.5));
    let cut = widen_for_kerf(&plate, KERF_MM).unwrap();
    let areas: Vec<f64> = cut.holes.iter().map(|hole| hole.signed_area_mm2().abs()).collect();
    let round_corners = |w: f64, h: f64, r: f64| w * h - (4.0 - PI) * r * r;
    let expected =
        [5.8 * 3.8, round_corners(5.8, 3.8, 0.5 - HALF_MM), PI * (1.5 - HALF_MM).powi(2)];
    for (area, expected) in areas.iter().zip(expected) {
        assert!((area - expected).abs() < AREA_SLACK_MM2, "{areas:?}");
    }
    assert_eq!(cut.holes[0].segments.len(), 4, "sharp corners stay sharp");
}

#[test]
fn a_beam_wider_than_a_hole_or_a_slit_is_refused() {
    let plate = Path::rectangle([0.0, 0.0], [10.0, 10.0], 0.0);
    let pierced = Profile::new(plate).with_hole(Path::circle([1.0, 2.0], 0.09));
    let error = widen_for_kerf(&pierced, KERF_MM).unwrap_err();
    assert_eq!(
        error.to_string(),
        "a kerf of 0.2 mm closes or divides hole 1 around (1.00, 2.00) mm"
    );
    // A pocket behind a slit narrower than the beam.
    let slit = Path::polygon(&[
        [0.0, 0.0],
        [10.0, 0.0],
        [10.0, 10.0],
        [5.09, 10.0],
        [5.09, 6.0],
        [7.0, 6.0],
        [7.0, 4.0],
        [3.0, 4.0],
        [3.0, 6.0],
        [5.0, 6.0],
        [5.0, 10.0],
        [0.0, 10.0],
    ]);
    let error = widen_for_kerf(&Profile::new(slit.clone()), KERF_MM).unwrap_err();
    assert!(
        matches!(error, ExportError::KerfTooWide { ref outline, .. } if outline.contains("outer"))
    );
    assert!(widen_for_kerf(&Profile::new(slit), 0.08).is_ok());
}

#[test]
fn no_kerf_changes_nothing() {
    let plate = Profile::new(Path::rectangle([0.0, 0.0], [10.0, 10.0], 1.0));
    assert_eq!(widen_for_kerf(&plate, 0.0).unwrap(), plate);
}

/// Distance of a point from a segment of a line or circle, mm.
fn distance_mm(p: [f64; 2], from: [f64; 2], segment: &Segment) -> f64 {
    let minus = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
    let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
    let to_point = |q: [f64; 2]| (p[0] - q[0]).hypot(p[1] - q[1]);
    let ends_mm = to_point(from).min(to_point(segment.to()));
    match segment {
        Segment::Line { to } => {
            let along = minus(*to, from);
            let s = dot(minus(p, from), along) / dot(along, along);
            let foot = [from[0] + s * along[0], from[1] + s * along[1]];
            if (0.0..=1.0).contains(&s) { to_point(foot) } else { ends_mm }
        }
        Segment::Arc { to, centre, ccw } => {
            let angle = |q: [f64; 2]| (q[1] - centre[1]).atan2(q[0] - centre[0]);
            let turn = if *ccw { 1.0 } else { -1.0 };
            let swept = |q: [f64; 2]| (turn * (angle(q) - angle(from))).rem_euclid(TAU);
            if swept(p) > swept(*to) {
                return ends_mm;
            }
            let radius_mm = (from[0] - centre[0]).hypot(from[1] - centre[1]);
            (to_point(*centre) - radius_mm).abs()
        }
        Segment::EllipticArc { .. } => unreachable!("not in these outlines"),
    }
}

fn distance_to_path_mm(p: [f64; 2], path: &Path) -> f64 {
    let mut from = path.start;
    let mut nearest_mm = f64::INFINITY;
    for segment in &path.segments {
        nearest_mm = nearest_mm.min(distance_mm(p, from, segment));
        from = segment.to();
    }
    nearest_mm
}

/// Points on a path: ends and middles of its segments.
fn points_on(path: &Path) -> Vec<[f64; 2]> {
    let mut from = path.start;
    let mut points = Vec::new();
    for segment in &path.segments {
        let to = segment.to();
        let middle = [(from[0] + to[0]) / 2.0, (from[1] + to[1]) / 2.0];
        points.push(to);
        points.push(match segment {
            Segment::Arc { centre, ccw, .. } => {
                // Short arcs bulge away from their centre.
                let arm = [middle[0] - centre[0], middle[1] - centre[1]];
                let radius_mm = (from[0] - centre[0]).hypot(from[1] - centre[1]);
                let cross = (from[0] - centre[0]) * (to[1] - centre[1])
                    - (from[1] - centre[1]) * (to[0] - centre[0]);
                assert_eq!(cross > 0.0, *ccw, "an arc of less than half a circle");
                let scale = radius_mm / arm[0].hypot(arm[1]);
                [centre[0] + scale * arm[0], centre[1] + scale * arm[1]]
            }
            _ => middle,
        });
        from = to;
    }
    points
}

/// Stars of lines and shallow arcs, with corners of both kinds.
fn star() -> impl Strategy<Value = Path> {
    let corner = (4.0..10.0f64, 0..3);
    prop::collection::vec(corner, 5..12).prop_map(|corners| {
        let count = corners.len();
        let at = |i: usize| {
            let angle = TAU * i as f64 / count as f64;
            let radius = corners[i % count].0;
            if i == count {
                [corners[0].0, 0.0]
            } else {
                [radius * angle.cos(), radius * angle.sin()]
            }
        };
        (0..count).fold(Path::from(at(0)), |path, i| {
            let ([ax, ay], [bx, by]) = (at(i), at(i + 1));
            // Centres half again as far from the chord as it is long, left or right of it.
            let side = f64::from(corners[i].1 - 1) * 1.5;
            let centre = [(ax + bx) / 2.0 - side * (by - ay), (ay + by) / 2.0 + side * (bx - ax)];
            if side == 0.0 { path.line([bx, by]) } else { path.arc([bx, by], centre, side > 0.0) }
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    /// The defining property: the distance is half a kerf everywhere.
    #[test]
    fn every_point_of_the_cut_is_half_a_kerf_from_the_piece(path in star()) {
        let cut = widened(path.clone());
        for p in points_on(&cut.outer) {
            let distance_mm = distance_to_path_mm(p, &path);
            prop_assert!((distance_mm - HALF_MM).abs() < 1e-9, "{distance_mm} at {p:?}");
        }
        prop_assert!(cut.area_mm2() > Profile::new(path).area_mm2());
    }
}
