//! Reading and checking landmarks.

use fabkit_calibration::landmarks::{PinLandmark, PinLandmarks};
use fabkit_geometry::{Point3, Vector3};

/// Holes on rings of a sphere of radius 14.5 mm about (0, 0, 6), rounded to 0.01 mm.
fn map_of_a_dome() -> String {
    let mut entries = vec!["\"1\": [0, 0, 20.5]".to_owned()];
    for (ring, polar_deg) in [20.0f64, 45.0, 70.0].into_iter().enumerate() {
        for k in 0..6 {
            let (s, c) = polar_deg.to_radians().sin_cos();
            let (sa, ca) = (f64::from(k) * 60f64.to_radians()).sin_cos();
            let hole = 2 + ring * 6 + k as usize;
            let [x, y, z] = [14.5 * s * ca, 14.5 * s * sa, 6.0 + 14.5 * c];
            entries.push(format!("\"{hole}\": [{x:.2}, {y:.2}, {z:.2}]"));
        }
    }
    format!("{{{}}}", entries.join(", "))
}

#[test]
fn a_plain_map_of_a_dome_has_axes_to_its_centre() {
    let landmarks = PinLandmarks::from_json(&map_of_a_dome()).unwrap();
    assert_eq!(landmarks.pins.len(), 19);
    assert!(landmarks.pins.windows(2).all(|w| w[0].hole < w[1].hole));
    for pin in &landmarks.pins {
        let to_centre = Point3::new(0.0, 0.0, 6.0) - pin.contact_in_sensor_mm;
        // Rounding moves the centre by a few 0.01 mm: 0.05 mm seen from 14.5 mm.
        let angle = pin.axis_in_sensor.unwrap().cross(&to_centre.normalize()).norm();
        assert!(angle < 0.004, "hole {}: {angle}", pin.hole);
    }
}

#[test]
fn points_off_a_sphere_have_no_axis() {
    let text = map_of_a_dome().replace("20.5", "19.5");
    let landmarks = PinLandmarks::from_json(&text).unwrap();
    assert!(landmarks.pins.iter().all(|pin| pin.axis_in_sensor.is_none()));
}

#[test]
fn documents_survive_a_round_trip() {
    let pin = |hole, kind: &str, z| PinLandmark {
        hole,
        kind: kind.into(),
        tip_centre_in_sensor_mm: Point3::new(0.1, 0.2, z),
        contact_in_sensor_mm: Point3::new(0.1, 0.2, z - 1.0),
        axis_in_sensor: Some(-Vector3::z()),
    };
    let pins = vec![pin(2, "long", 20.0), pin(1, "short", 21.0), pin(1, "long", 20.0)];
    let landmarks = PinLandmarks::new("rtac0", "pin-dome", 1.0, pins).unwrap();
    assert_eq!(PinLandmarks::from_json(&landmarks.to_json()).unwrap(), landmarks);
    assert_eq!(landmarks.kinds(), ["long", "short"]);
    assert_eq!(landmarks.pins[0].kind, "long");
    assert!(landmarks.find(1, None).is_none(), "hole 1 has two kinds");
    assert_eq!(landmarks.find(1, Some("short")).unwrap().contact_in_sensor_mm.z, 20.0);
    assert_eq!(landmarks.find(2, None).unwrap().kind, "long");
}

#[test]
fn wrong_files_are_refused_with_the_place() {
    for (text, expected) in [
        ("", "line 1"),
        ("[1]", "expected an object"),
        (r#"{"one": [0, 0, 1]}"#, "\"one\" is not the number of a hole"),
        (r#"{"0": [0, 0, 1]}"#, "\"0\" is not the number of a hole"),
        (r#"{"3": [0, 1]}"#, "hole 3: expected [x, y, z]"),
        (r#"{"3": [0, 1, 2], "3": [0, 1, 3]}"#, "hole 3 stands there twice"),
        (r#"{"3": [0, 1, 2], "03": [0, 1, 3]}"#, "written differently"),
        (r#"{"3": [0, 1, 2000]}"#, "beyond 1000 mm"),
        (r#"{"format": "other", "version": 1}"#, "format \"other\" version 1"),
        (r#"{"format": "fabkit-pin-landmarks", "version": 2}"#, "version 2; this fabkit reads"),
        ("{\"format\": \"fabkit-pin-landmarks\", \"version\": 1,\n \"sensor\": 3}", "line 2"),
        ("{}", "0 pins"),
    ] {
        let message = PinLandmarks::from_json(text).unwrap_err().to_string();
        assert!(message.contains(expected), "{text}: {message}");
    }
    let huge = format!("{{\"1\": [0, 0, 1{}]}}", " ".repeat(1 << 20));
    assert!(
        PinLandmarks::from_json(&huge).unwrap_err().to_string().contains("the limit is 1048576")
    );
}

#[test]
fn all_problems_are_named_at_once() {
    let pin = PinLandmark {
        hole: 0,
        kind: "a".into(),
        tip_centre_in_sensor_mm: Point3::origin(),
        contact_in_sensor_mm: Point3::new(f64::NAN, 0.0, 0.0),
        axis_in_sensor: Some(Vector3::new(0.0, 0.0, 2.0)),
    };
    let error = PinLandmarks::new("s", "f", -1.0, vec![pin.clone(), pin]).unwrap_err();
    // Twice three, the radius, and the repetition.
    assert_eq!(error.problems.len(), 8, "{error}");
}
