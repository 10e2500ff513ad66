//! Marks that are listed one by one lie where their lists say, in molds and layers alike, and what cannot
//! be made is refused with the item that it is about.

use fabkit_designs::parameters::Problem;
use fabkit_designs::{Design, builtin_yaml, load};
use fabkit_geometry::{Body, CompiledSolid, Point3, Vector3};

fn overridden(sensor: &str, sets: &[&str]) -> Result<Design, Vec<Problem>> {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    load(sensor, builtin_yaml(sensor).unwrap(), &sets, &["fixtures"]).map_err(|e| e.problems)
}

fn made(sensor: &str, sets: &[&str]) -> Design {
    overridden(sensor, sets).unwrap_or_else(|why| panic!("{sensor} {sets:?}: {why:#?}"))
}

/// One problem at `path`, which says all of `texts`.
fn refused(sensor: &str, sets: &[&str], path: &str, texts: &[&str]) {
    let why = overridden(sensor, sets).map(|_| ()).expect_err(&format!("{sensor} {sets:?}"));
    let told = |p: &Problem| format!("{}\n{}", p.message, p.hint.as_deref().unwrap_or_default());
    let is_it = |p: &&Problem| p.path == path && texts.iter().all(|text| told(p).contains(text));
    assert_eq!(why.iter().filter(is_it).count(), 1, "{path} {texts:?} in {why:#?}");
}

fn body<'a>(design: &'a Design, name: &str) -> &'a Body {
    design.sensor.body(name).unwrap_or_else(|| panic!("no {name}"))
}

fn derived<'a>(design: &'a Design, name: &str) -> Option<&'a str> {
    let figure = design.derived.iter().find(|(known, _)| known == name);
    figure.map(|(_, value)| value.as_str())
}

/// Landmarks of a body whose names begin so, in their order: name, point, axis.
fn landmarks(body: &Body, word: &str) -> Vec<(String, Point3<f64>, Vector3<f64>)> {
    let marks = body.landmarks.iter().filter(|mark| mark.name.starts_with(word));
    marks.map(|mark| (mark.name.clone(), mark.point, mark.axis)).collect()
}

/// Names of features with that word, in the order of the tree.
fn features(body: &Body, word: &str) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for leaf in body.solid.leaves() {
        if leaf.feature.starts_with(word) && !names.iter().any(|name| name == leaf.feature) {
            names.push(leaf.feature.to_owned());
        }
    }
    names
}

/// Three marks that no ring holds: polar angles and azimuths, degrees.
const ROUND: [[f64; 2]; 3] = [[0.0, 0.0], [12.5, 90.0], [20.0, -135.0]];

/// The direction of a normal at these angles, degrees.
fn direction([polar, azimuth]: [f64; 2]) -> Vector3<f64> {
    let ((s, c), (sin, cos)) = (polar.to_radians().sin_cos(), azimuth.to_radians().sin_cos());
    Vector3::new(s * cos, s * sin, c)
}

/// `SECTION.pattern=list` and both of its lists, degrees.
fn round(section: &str, marks: &[[f64; 2]]) -> Vec<String> {
    let list = |i: usize| {
        let items: Vec<String> = marks.iter().map(|mark| format!("{} deg", mark[i])).collect();
        format!("[{}]", items.join(", "))
    };
    vec![
        format!("{section}.pattern=list"),
        format!("{section}.polar={}", list(0)),
        format!("{section}.azimuth={}", list(1)),
    ]
}

fn strs(sets: &[String]) -> Vec<&str> {
    sets.iter().map(String::as_str).collect()
}

/// What is listed, with more of the same command line.
fn with<'a>(listed: &'a [String], more: &[&'a str]) -> Vec<&'a str> {
    [&strs(listed)[..], more].concat()
}

/// Numbers of three marks.
fn numbered(word: &str) -> Vec<String> {
    (1..=3).map(|i| format!("{word} {i}")).collect()
}

/// Coordinates are some ten millimetres from a few operations each; this is a million times their rounding.
const SAME_MM: f64 = 1e-9;

fn lies(found: &[(String, Point3<f64>, Vector3<f64>)], expected: &[(Point3<f64>, Vector3<f64>)]) {
    assert_eq!(found.len(), expected.len());
    for ((name, point, axis), (at, along)) in found.iter().zip(expected) {
        assert!((point - at).norm() < SAME_MM, "{name}: {point}, not {at}");
        assert!((axis - along).norm() < SAME_MM, "{name}: {axis}, not {along}");
    }
}

#[test]
fn dimples_are_listed_on_the_sphere() {
    let listed = round("dimples", &ROUND);
    let design = made("shadowtac", &strs(&listed));
    // Chords: 17.5^2 = 8 (2 R - 8).
    let radius = (17.5f64.powi(2) + 64.0) / 16.0;
    let centre = Point3::new(0.0, 0.0, 8.0 - radius);
    let at = |below: f64, mark: [f64; 2]| centre + (radius - below) * direction(mark);
    let block = body(&design, "mold-skin-block");
    let expected = ROUND.map(|mark| (at(0.0, mark), direction(mark)));
    let dimples = landmarks(block, "dimple");
    lies(&dimples, &expected);
    let names: Vec<&str> = dimples.iter().map(|(name, ..)| name.as_str()).collect();
    assert_eq!(names, numbered("dimple"));
    let [gel, mold, paint] = ["skin", "mold-skin-block", "reflective-paint"].map(|name| {
        assert_eq!(features(body(&design, name), "dimple"), numbered("dimple"), "{name}");
        CompiledSolid::new(&body(&design, name).solid).unwrap()
    });
    // Half way down a dimple of 0.5 mm: the mold's pin, and paint, instead of gel.
    for mark in ROUND {
        let inside = at(0.25, mark);
        assert!(!gel.contains(&inside) && mold.contains(&inside) && paint.contains(&inside));
    }
    let beside = at(0.25, [12.5, -90.0]);
    assert!(gel.contains(&beside) && !mold.contains(&beside));
    assert_eq!(derived(&design, "dimples"), Some("3"));
    assert_eq!(derived(&design, "polar step from ring to ring"), None);
    // The chord between the first two.
    let least = 2.0 * radius * (12.5f64.to_radians() / 2.0).sin();
    assert_eq!(derived(&design, "nearest neighbours"), Some(&*format!("{least:.3} mm")));
}

#[test]
fn dimples_that_cannot_be_made_are_named() {
    let uneven =
        ["dimples.pattern=list", "dimples.polar=[0deg,9deg,9deg]", "dimples.azimuth=[0deg,0deg]"];
    let texts = ["dimples.polar has 3 items and dimples.azimuth has 2; each dimple has both"];
    refused("shadowtac", &uneven, "dimples.polar", &texts);
    let low = round("dimples", &[[0.0, 0.0], [10.0, 5.0], [10.0, 95.0], [60.0, 20.0]]);
    let texts =
        ["dimples.polar[3] (dimple 4) is 60 deg; it must be at most", "0.3 mm above the foot"];
    refused("shadowtac", &strs(&low), "dimples.polar[3]", &texts);
    // 0.5 mm deep, two dimples of 0.45 mm that are 1 degree apart on 23.14 mm run into each other.
    let near = round("dimples", &[[5.0, 0.0], [0.0, 0.0], [5.0, 180.0], [6.0, 0.0]]);
    let apart = 2.0 * (370.25 / 16.0 - 0.5) * 0.5f64.to_radians().sin();
    let text = format!("dimples 1 and 4 (dimples.polar[0] and dimples.polar[3]) are {apart:.3} mm");
    let texts = [&*text, "it must be at least 0.650 mm", "`dimples.width`"];
    refused("shadowtac", &strs(&near), "dimples.polar[3]", &texts);
    // What is told as the largest angle can be made, and a tenth of a degree more cannot.
    let why = overridden("shadowtac", &strs(&low)).map(|_| ()).unwrap_err();
    let told = why.iter().find(|p| p.path == "dimples.polar[3]").unwrap();
    let most = told.message.split("at most ").nth(1).unwrap().split(' ').next().unwrap();
    let most: f64 = most.parse().unwrap();
    for (polar, is_made) in [(most, true), (most + 0.1, false)] {
        let listed = round("dimples", &[[polar, 0.0]]);
        assert_eq!(overridden("shadowtac", &strs(&listed)).is_ok(), is_made, "{polar}");
    }
    // From far below, a narrow ledge hides what lies further out.
    let narrow = ["camera.depth=30mm", "holder.aperture_diameter=28mm"];
    let hidden = round("dimples", &[[0.0, 0.0], [45.0, 20.0]]);
    let texts = ["dimples.polar[1] (dimple 2) is 45 deg", "hide", "`holder.aperture_diameter`"];
    refused("shadowtac", &with(&hidden, &narrow), "dimples.polar[1]", &texts);
}

#[test]
fn markers_are_listed_on_the_ellipsoid_by_their_normals() {
    let marks = [[0.0, 0.0], [50.0, 90.0], [82.0, -135.0]];
    let listed = round("markers", &marks);
    let design = made("uvdtact", &strs(&listed));
    // 0.4 mm of black gel and 0.5 mm of outer elastomer inside half axes of 9 and 24 mm.
    let (across, along, below) = (9.0, 24.0, 0.9);
    let negative = body(&design, "negative-cup-inner");
    let found = landmarks(negative, "marker");
    assert_eq!(found.iter().map(|(name, ..)| name.clone()).collect::<Vec<_>>(), numbered("marker"));
    for ((name, point, axis), mark) in found.iter().zip(marks) {
        assert!((axis - direction(mark)).norm() < SAME_MM, "{name}");
        // Along its normal it meets the ellipsoid, whose gradient lies along that normal.
        let foot = point + below * axis;
        let gradient = Vector3::new(
            foot.x / across / across,
            foot.y / across / across,
            foot.z / along / along,
        );
        let value = (foot.x.hypot(foot.y) / across).powi(2) + (foot.z / along).powi(2);
        assert!((value - 1.0).abs() < SAME_MM, "{name}: {value}");
        assert!((gradient.normalize() - axis).norm() < SAME_MM, "{name}");
    }
    let [inner, outer, cup, print] =
        ["inner-elastomer", "outer-elastomer", "silicone-cup-inner", "negative-cup-inner"].map(
            |name| {
                assert_eq!(features(body(&design, name), "marker"), numbered("marker"), "{name}");
                CompiledSolid::new(&body(&design, name).solid).unwrap()
            },
        );
    // 1 mm deep slots: the outer elastomer and the silicone mold fill them.
    for (_, point, axis) in &found {
        let inside = point - 0.7 * axis;
        assert!(!inner.contains(&inside) && !print.contains(&inside));
        assert!(outer.contains(&inside) && cup.contains(&inside));
    }
    assert_eq!(derived(&design, "markers"), Some("3"));
    assert_eq!(derived(&design, "markers per ring, from the tip"), None);
}

#[test]
fn markers_that_cannot_be_made_are_named() {
    let uneven =
        ["markers.pattern=list", "markers.polar=[0deg,60deg]", "markers.azimuth=[0deg,0deg,0deg]"];
    let texts = ["markers.polar has 2 items and markers.azimuth has 3; each marker has both"];
    refused("uvdtact", &uneven, "markers.azimuth", &texts);
    let low = round("markers", &[[0.0, 0.0], [89.5, 20.0]]);
    let texts = ["markers.polar[1] (marker 2) is 89.5 deg; it must be at most", "the base circle"];
    refused("uvdtact", &strs(&low), "markers.polar[1]", &texts);
    let near = round("markers", &[[80.0, 0.0], [80.0, 8.0], [80.0, 180.0]]);
    let texts = ["markers 1 and 2 (markers.polar[0] and markers.polar[1])", "at least 1.200 mm"];
    refused("uvdtact", &strs(&near), "markers.polar[1]", &texts);
}

#[test]
fn pins_are_listed_on_the_hemisphere() {
    let listed = round("pins", &ROUND);
    let design = made("tactip", &strs(&listed));
    // 27 mm across less 1 mm of skin; a pin of 1.5 mm ends in a dot of 0.5 mm.
    let (inside, end) = (12.5, 10.5);
    let at = |mm: f64, mark: [f64; 2]| Point3::from(mm * direction(mark));
    let dots = landmarks(body(&design, "dots"), "dot");
    lies(&dots, &ROUND.map(|mark| (at(end, mark), -direction(mark))));
    let names: Vec<&str> = dots.iter().map(|(name, ..)| name.as_str()).collect();
    assert_eq!(names, numbered("dot"));
    assert_eq!(body(&design, "dots").shells.unwrap().pieces, 3);
    assert_eq!(features(body(&design, "skin"), "pin "), numbered("pin"));
    let [skin, dots, gel] =
        ["skin", "dots", "gel"].map(|name| CompiledSolid::new(&body(&design, name).solid).unwrap());
    for mark in ROUND {
        assert!(skin.contains(&at(inside - 0.7, mark)) && !gel.contains(&at(inside - 0.7, mark)));
        assert!(dots.contains(&at(end + 0.2, mark)) && !gel.contains(&at(end + 0.2, mark)));
    }
    assert!(gel.contains(&at(inside - 0.7, [12.5, -90.0])));
    assert_eq!(derived(&design, "pins"), Some("3"));
    // Layouts give the diameter: 1.7 mm instead of 1 mm.
    let thick = made("tactip", &with(&listed, &["pins.layout=D"]));
    assert_eq!(derived(&thick, "pin diameter"), Some("1.700 mm"));
}

#[test]
fn pins_that_cannot_be_made_are_named() {
    let uneven = ["pins.pattern=list", "pins.polar=[0deg]", "pins.azimuth=[0deg,10deg]"];
    let texts = ["pins.polar has 1 items and pins.azimuth has 2; each pin has both"];
    refused("tactip", &uneven, "pins.azimuth", &texts);
    // The camera's image ends far above the skin's edge.
    let low = round("pins", &[[0.0, 0.0], [80.0, 0.0]]);
    let texts =
        ["pins.polar[1] (pin 2) is 80 deg; it must be at most", "the pixels", "`camera.depth`"];
    refused("tactip", &strs(&low), "pins.polar[1]", &texts);
    // Through a keyhole, not even the pin on the axis.
    let keyhole = ["camera.array_size=0.2mm", "camera.focal_length=50mm", "camera.depth=60mm"];
    let middle = round("pins", &[[0.0, 0.0]]);
    let texts = ["pins.polar[0] (pin 1) is 0 deg; no value works", "change `camera.depth`"];
    refused("tactip", &with(&middle, &keyhole), "pins.polar[0]", &texts);
    // Chords between the dots' ends, at 10.5 mm.
    let near = round("pins", &[[0.0, 0.0], [20.0, 0.0], [24.0, 0.0]]);
    let apart = 21.0 * 2f64.to_radians().sin();
    let text = format!("pins 2 and 3 (pins.polar[1] and pins.polar[2]) are {apart:.3} mm apart");
    refused("tactip", &strs(&near), "pins.polar[2]", &[&text, "at least 1.300 mm"]);
}

#[test]
fn markers_are_listed_in_the_window() {
    let marks = [[-5.5, 0.0], [7.25, 3.0], [0.0, -11.0]];
    let listed =
        ["markers.pattern=list", "markers.x=[-5.5mm,7.25mm,0mm]", "markers.y=[0mm,3mm,-11mm]"];
    let design = made("fluidic", &listed);
    let plate = body(&design, "mold-marker-plate");
    let found = landmarks(plate, "marker");
    let expected = marks.map(|[x, y]| (Point3::new(x, y, 0.0), -Vector3::z()));
    lies(&found, &expected);
    assert_eq!(found.iter().map(|(name, ..)| name.clone()).collect::<Vec<_>>(), numbered("marker"));
    // Markers hang 3 mm down from z = 0; the paint is below that; the sheet's holes go through.
    let [layer, paint, sheet] = ["marker-layer", "marker-paint", "mold-marker-plate"]
        .map(|name| CompiledSolid::new(&body(&design, name).solid).unwrap());
    for [x, y] in marks {
        assert!(
            layer.contains(&Point3::new(x, y, -1.5)) && !sheet.contains(&Point3::new(x, y, 1.5))
        );
        assert!(paint.contains(&Point3::new(x, y, -3.05)));
    }
    assert!(!layer.contains(&Point3::new(5.5, 0.0, -1.5)));
    assert!(sheet.contains(&Point3::new(5.5, 0.0, 1.5)));
    assert_eq!(features(body(&design, "marker-layer"), "marker"), numbered("marker"));
    assert_eq!(body(&design, "marker-paint").shells.unwrap().pieces, 3);

    let uneven = ["markers.pattern=list", "markers.x=[0mm]", "markers.y=[0mm,9mm]"];
    let texts = ["markers.x has 1 items and markers.y has 2; each marker has both"];
    refused("fluidic", &uneven, "markers.y", &texts);
    // A window of 64 mm, less 1 mm of wood and half of 2 mm on either side.
    let far = ["markers.pattern=list", "markers.x=[0mm,4mm]", "markers.y=[0mm,-31mm]"];
    let texts = ["markers.y[1] (marker 2) is -31 mm; it must be at least -30 mm", "the window"];
    refused("fluidic", &far, "markers.y[1]", &texts);
    let near = ["markers.pattern=list", "markers.x=[0mm,9mm,2mm]", "markers.y=[0mm,0mm,2mm]"];
    let texts = ["markers 1 and 3 (markers.x[0] and markers.x[2]) are 2.828 mm", "3.000 mm"];
    refused("fluidic", &near, "markers.x[2]", &texts);
}

#[test]
fn dots_are_listed_on_the_gel() {
    let list = ["markers.pattern=list", "markers.x=[-5mm, 0mm, 4mm]", "markers.y=[0mm, 3mm, -2mm]"];
    let design = made("gelsight-like", &list);
    assert_eq!(body(&design, "markers").shells.unwrap().pieces, 3);
    assert_eq!(body(&design, "marker-stencil").genus, Some(3));
    let far = ["markers.pattern=list", "markers.x=[40mm]", "markers.y=[0mm]"];
    let texts = ["markers.x[0] (dot 1) is 40 mm; it must be at most", "`markers.diameter`"];
    refused("gelsight-like", &far, "markers.x[0]", &texts);
    let near = ["markers.pattern=list", "markers.x=[0mm,0.5mm]", "markers.y=[0mm,0mm]"];
    let texts = ["dots 1 and 2 (markers.x[0] and markers.x[1]) are 0.500 mm apart"];
    refused("gelsight-like", &near, "markers.x[1]", &texts);
    let uneven = ["markers.pattern=list", "markers.x=[0mm]", "markers.y=[0mm,1mm]"];
    refused("gelsight-like", &uneven, "markers.y", &["markers.x has 1 items and markers.y has 2"]);
}

#[test]
fn a_single_mark_and_the_lists_of_the_defaults_can_be_made() {
    for (sensor, section, places) in [
        ("shadowtac", "dimples", ["polar", "azimuth"]),
        ("uvdtact", "markers", ["polar", "azimuth"]),
        ("tactip", "pins", ["polar", "azimuth"]),
        ("fluidic", "markers", ["x", "y"]),
        ("gelsight-like", "markers", ["x", "y"]),
    ] {
        let unit = if places[0] == "x" { "mm" } else { "deg" };
        let pattern = format!("{section}.pattern=list");
        made(sensor, &[&pattern]);
        let one = places.map(|key| format!("{section}.{key}=[3 {unit}]"));
        let design = made(sensor, &[&pattern, &one[0], &one[1]]);
        for body in &design.sensor.bodies {
            body.solid.validate().unwrap_or_else(|e| panic!("{sensor} / {}: {e}", body.name));
        }
    }
}

#[test]
fn a_mark_that_is_refused_is_shown_where_it_stands() {
    let yaml = format!(
        "format: 1\nextends: shadowtac\nname: own\n{}",
        "dimples:\n  pattern: list\n  polar:\n    - 0 deg\n    - 70 deg\n  azimuth: [0 deg, 0 deg]\n"
    );
    let why = load("own.yaml", &yaml, &[], &["fixtures"]).map(|_| ()).unwrap_err();
    let low = why.problems.iter().find(|p| p.path == "dimples.polar[1]").unwrap();
    assert_eq!((low.line, low.value.as_str()), (Some(8), "70 deg"));
}

/// The same places in one way as in the other.
#[test]
fn rings_that_are_listed_are_the_rings() {
    // One ring of six, 1.4 mm from the apex along the surface of the sphere.
    let rings = made("shadowtac", &["dimples.rings=1"]);
    let radius = 370.25 / 16.0;
    let polar = (1.4f64 / radius).to_degrees();
    let mut marks = vec![[0.0, 0.0]];
    marks.extend((0..6).map(|i| [polar, 60.0 * f64::from(i)]));
    let listed = made("shadowtac", &strs(&round("dimples", &marks)));
    let poses = |design: &Design| landmarks(body(design, "mold-skin-block"), "dimple");
    for ((name, a, n), (other, b, m)) in poses(&rings).iter().zip(poses(&listed)) {
        assert_eq!(*name, other);
        assert!((a - b).norm() < SAME_MM && (n - m).norm() < SAME_MM, "{name}");
    }
    assert_eq!(poses(&rings).len(), 7);
}
