//! Tests of sources: names, paths, fixtures of units.

use fabkit_geometry::Pose;

use super::*;

#[test]
fn a_fixture_and_a_part_follow_a_name_or_a_path() {
    let split = |text| {
        let Target { sensor, fixture, part, .. } = Target::new(text);
        (sensor, fixture, part)
    };
    assert_eq!(split("rtac0"), ("rtac0", None, None));
    assert_eq!(split("rtac0/shell"), ("rtac0", None, Some("shell")));
    assert_eq!(split("rtac0/indenters"), ("rtac0", Some("indenters"), None));
    let part = ("rtac0", Some("indenters"), Some("hemisphere"));
    assert_eq!(split("rtac0/indenters/hemisphere"), part);
    assert_eq!(split("a/b/my.yaml"), ("a/b/my.yaml", None, None));
    assert_eq!(split("a/b/my.yaml/shell"), ("a/b/my.yaml", None, Some("shell")));
    assert_eq!(split("./my.yml/indenters"), ("./my.yml", Some("indenters"), None));
    assert_eq!(split("/shell"), ("/shell", None, None));
}

#[test]
fn fixtures_press_where_the_drawing_puts_them_and_places_are_the_units_own() {
    let source = Source::find("rtac0").unwrap();
    let (drawn, unit) = (source.load(&[]).unwrap(), source.load_unit(Unit(3), &[]).unwrap());
    assert!(drawn.design.sensor.touch != unit.design.sensor.touch);
    let placed = |project: &Project, id: &str| -> Vec<Pose> {
        project.press(id).unwrap().bodies.iter().map(|body| body.sensor_from_body).collect()
    };
    for id in ["pin-1-long", "semi-dome-017"] {
        assert_eq!(placed(&drawn, id), placed(&unit, id), "{id}");
    }
    let id = "ball@24deg,120deg,0.5mm";
    assert_ne!(placed(&drawn, id), placed(&unit, id));
    let hash = |project: &Project| fabkit_designs::design_hash(&project.design);
    assert_eq!(hash(&drawn), hash(&unit));
}
