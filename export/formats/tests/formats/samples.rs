//! Samples of lines, points and landmarks, against a solid whose surface is one formula.

use std::collections::BTreeSet;

use fabkit_export::{SamplesDocument, samples};
use fabkit_geometry::{Landmark, Point3, Solid, Vector3};
use serde_json::Value;

const RADIUS_MM: f64 = 5.0;
const BORE_MM: f64 = 2.0;

/// A ball with a bore along z.
fn bead() -> Solid {
    let bore = Solid::cylinder(BORE_MM, 12.0).at(0.0, 0.0, -6.0).named("bore");
    Solid::sphere(RADIUS_MM).named("ball").minus(bore)
}

/// Signed function of the bead: negative inside, near its surface the distance to it.
fn outside_mm(p: Vector3<f64>) -> f64 {
    (p.norm() - RADIUS_MM).max(BORE_MM - p.xy().norm())
}

fn landmarks() -> Vec<Landmark> {
    let at = |name: &str, point: [f64; 3], axis: Vector3<f64>| Landmark {
        name: name.into(),
        point: Point3::from(point),
        axis,
    };
    vec![
        at("equator", [RADIUS_MM, 0.0, 0.0], Vector3::x()),
        at("middle", [0.0; 3], Vector3::z()),
        at("wall", [3.0, 0.0, 0.5], Vector3::new(1.0, 1.0, 1.0).normalize()),
    ]
}

fn document() -> Vec<u8> {
    let (solid, landmarks) = (bead(), landmarks());
    let (design_hash, sensor, name) = ("0123", "test", "bead");
    let document =
        SamplesDocument { design_hash, sensor, name, solid: &solid, landmarks: &landmarks };
    samples(&document).expect("a bead can be sampled")
}

fn parsed() -> Value {
    serde_json::from_slice(&document()).expect("samples are JSON")
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn vector(value: &Value) -> Vector3<f64> {
    Vector3::from_column_slice(&numbers(value))
}

#[test]
fn lines_name_all_crossings_of_the_surface() {
    let parsed = parsed();
    let lines = parsed["lines"].as_array().unwrap();
    assert!(lines.len() > 300, "{}", lines.len());
    for line in lines {
        let (origin, direction) = (vector(&line["origin_mm"]), vector(&line["direction"]));
        assert!((direction.norm() - 1.0).abs() < 1e-12);
        let (t, cosine) = (numbers(&line["t_mm"]), numbers(&line["cosine"]));
        let at = |t: f64| origin + t * direction;
        for (i, (&t, &cosine)) in t.iter().zip(&cosine).enumerate() {
            assert!(outside_mm(at(t)).abs() < 1e-9, "{line}");
            // Grazing lines are left out; the others enter and leave alternately.
            assert!(cosine.abs() > 0.05 && (cosine < 0.0) == (i % 2 == 0), "{line}");
            let on_ball = line["leaf"][i] == 0;
            let radial = if on_ball { at(t) } else { -Vector3::new(at(t).x, at(t).y, 0.0) };
            assert!((radial.normalize().dot(&direction) - cosine).abs() < 1e-9, "{line}");
        }
        assert!(t.windows(2).all(|pair| pair[1] - pair[0] > 1e-4), "{line}");
        // None is missing: between crossings a line stays inside or outside.
        let ends: Vec<f64> = [-30.0].into_iter().chain(t).chain([40.0]).collect();
        for (i, pair) in ends.windows(2).enumerate() {
            let (low, high) = (pair[0] + 1e-6, pair[1] - 1e-6);
            let inside = (0..=100).map(|k| at(low + (high - low) * f64::from(k) / 100.0));
            assert!(inside.into_iter().all(|p| (outside_mm(p) < 0.0) == (i % 2 == 1)), "{line}");
        }
    }
}

#[test]
fn every_face_that_is_left_is_aimed_at_by_its_name() {
    let parsed = parsed();
    let lines = parsed["lines"].as_array().unwrap();
    let purposes: BTreeSet<&str> = lines.iter().map(|line| line["of"].as_str().unwrap()).collect();
    // The bore's two end faces are outside of the ball.
    let expected = [
        "ball, leaf 0 face 0",
        "bore, leaf 1 face 0",
        "bundle 0",
        "bundle 1",
        "bundle 2",
        "landmark equator",
        "landmark middle",
        "landmark wall",
        "seam of leaves 0 and 1",
    ];
    assert_eq!(purposes, expected.into());
    for line in lines.iter().filter(|line| line["of"] == "bore, leaf 1 face 0") {
        assert!(line["leaf"].as_array().unwrap().contains(&1.into()), "{line}");
    }
}

#[test]
fn each_bundle_weighs_the_volume() {
    let parsed = parsed();
    let half = (RADIUS_MM * RADIUS_MM - BORE_MM * BORE_MM).sqrt();
    let volume = 4.0 / 3.0 * std::f64::consts::PI * half.powi(3);
    for (number, weight) in numbers(&parsed["bundle_mm2"]).into_iter().enumerate() {
        let of = format!("bundle {number}");
        let lines = parsed["lines"].as_array().unwrap().iter().filter(|line| line["of"] == of);
        let inside: f64 = lines
            .map(|line| numbers(&line["t_mm"]).chunks_exact(2).map(|p| p[1] - p[0]).sum::<f64>())
            .sum();
        // 144 jittered cells; those at the rim, about 40 of 5 mm, are each off by half at random: 3 %. Grazing lines,
        // which are left out, are short.
        let off = (weight * inside / volume - 1.0).abs();
        assert!(off < 0.1, "{of}: {}", weight * inside / volume);
    }
}

#[test]
fn points_and_landmarks_lie_where_they_are_said_to_lie() {
    let parsed = parsed();
    let points = parsed["points"].as_array().unwrap();
    let inside = |point: &&Value| point["inside"] == true;
    for point in points {
        let outside = outside_mm(vector(&point["point_mm"]));
        assert_eq!(inside(&point), outside < 0.0, "{point}");
        assert!(outside.abs() > 1e-4, "{point}");
    }
    let count = points.iter().filter(inside).count();
    assert!(count > 20 && points.len() - count > 20, "{count} of {}", points.len());

    let found: Vec<_> = parsed["landmarks"].as_array().unwrap().iter().collect();
    let lies_in: Vec<_> = found.iter().map(|l| l["lies_in"].as_str().unwrap()).collect();
    assert_eq!(lies_in, ["surface", "void", "solid"]);
}

#[test]
fn no_line_follows_the_edge_on_which_a_landmark_lies() {
    let solid = Solid::cylinder(4.0, 2.0);
    let at = |name: &str, x: f64, axis: Vector3<f64>| Landmark {
        name: name.into(),
        point: Point3::new(x, 0.0, 2.0),
        axis,
    };
    // The first line runs along the wall and the second along the top; the third enters the solid.
    let landmarks = [
        at("wall", 4.0, Vector3::z()),
        at("edge", 4.0, Vector3::x()),
        at("top", 1.0, Vector3::z()),
    ];
    let (design_hash, sensor, name) = ("0123", "test", "disc");
    let document =
        SamplesDocument { design_hash, sensor, name, solid: &solid, landmarks: &landmarks };
    let parsed: Value = serde_json::from_slice(&samples(&document).unwrap()).unwrap();
    let lines = parsed["lines"].as_array().unwrap();
    let along = |of: &str, axis: Vector3<f64>| {
        let through = lines.iter().filter(|line| line["of"] == of);
        through.filter(|line| vector(&line["direction"]).dot(&axis).abs() > 0.999).count()
    };
    assert_eq!(along("landmark wall", Vector3::z()), 0);
    assert_eq!(along("landmark edge", Vector3::x()), 0);
    assert_eq!(along("landmark top", Vector3::z()), 1);
    let found = parsed["landmarks"].as_array().unwrap();
    assert!(found.iter().all(|landmark| landmark["lies_in"] == "surface"), "{found:?}");
}

#[test]
fn the_same_body_gives_the_same_bytes() {
    assert_eq!(document(), document());
}
