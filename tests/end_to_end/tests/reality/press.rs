//! Halves that would rub over the gel, or not get to their places, and pins that the camera does not see:
//! each is found, by the rule and the body that are to blame, and what ships has no such finding.

use fabkit_checks::{Finding, Rule, Severity};
use fabkit_fixtures::{Project, load};
use fabkit_geometry::{MotionLeg, Sensor, Vector3};
use fabkit_tests::{motions, sample_cases};
use rayon::prelude::*;

const ROUND: [&str; 4] = ["rtac0", "uvdtact", "tactip", "shadowtac"];

fn project(sensor: &str, settings: &[&str]) -> Project {
    let settings: Vec<String> = settings.iter().map(|set| (*set).to_owned()).collect();
    load(sensor, fabkit_designs::builtin_yaml(sensor).unwrap(), &settings).unwrap()
}

/// Two halves that press and the empty one, in their holder.
fn kit(sensor: &str) -> Sensor {
    let two = ["fixtures.semi_domes.count=2"];
    project(sensor, &two).fixture("semi-domes").unwrap().sensor
}

/// The ways of the two halves that are shown, the left one's first: unit vectors.
fn ways(kit: &mut Sensor) -> Vec<&mut Vector3<f64>> {
    let mate = kit.chain.iter_mut().find(|step| step.name == "mate").unwrap();
    let legs = mate.motions.iter_mut().flat_map(|motion| &mut motion.legs);
    let along = legs.filter_map(|leg| match leg {
        MotionLeg::Straight { along, .. } => Some(along),
        MotionLeg::Turn { .. } => None,
    });
    along.collect()
}

/// The way that a half goes instead.
type Change = fn(Vector3<f64>) -> Vector3<f64>;

/// The way, how it is changed, and what stands in it.
const WRONG_WAYS: [(&str, Change); 4] = [
    // As it was: sideways between rails.
    ("from the side", |way| Vector3::new(way.x.signum(), 0.0, 0.0)),
    ("from above", |_| -Vector3::z()),
    // The way of the other quarter.
    ("from the other quarter", |way| Vector3::new(way.x, -way.y, way.z)),
    ("from below", |way| -way),
];

#[test]
fn halves_come_on_no_other_way_than_along_their_dowels() {
    sample_cases(&ROUND).par_iter().for_each(|sensor| {
        let found = motions(&kit(sensor)).unwrap();
        assert!(found.is_empty(), "{sensor}: {found:#?}");
        for (name, change) in WRONG_WAYS {
            let mut kit = kit(sensor);
            for way in ways(&mut kit) {
                *way = change(*way).normalize();
            }
            let found = motions(&kit).unwrap();
            let of_half = |half: &str| {
                found.iter().any(|finding| {
                    finding.rule == Rule::Motion
                        && finding.bodies.first().is_some_and(|b| b == half)
                })
            };
            assert!(of_half("semi-dome-001"), "{sensor} {name}: {found:#?}");
            assert!(of_half("semi-dome-000"), "{sensor} {name}: {found:#?}");
        }
    });
}

/// Findings about what images of the pins tell, without the forecast that all have.
fn seen(settings: &[&str]) -> Vec<Finding> {
    let report = project("rtac0", settings).examine_fixture("pin-dome").unwrap();
    let of_pins = |finding: &Finding| {
        finding.rule == Rule::Observability && finding.severity != Severity::Note
    };
    report.findings.into_iter().filter(of_pins).collect()
}

/// How wide the camera sees, and how grave it is that it misses so many of 58 holes.
const NARROW: [(&str, Severity, f64); 3] = [
    ("110deg", Severity::Warning, 10.0),
    ("60deg", Severity::Error, 24.0),
    ("40deg", Severity::Error, 26.0),
];

#[test]
fn a_camera_that_misses_a_third_of_the_pins_is_found() {
    assert_eq!(seen(&[]), []);
    for (angle, severity, holes) in NARROW {
        let found = seen(&[&format!("camera.field_of_view={angle}")]);
        let missed = found.iter().find(|finding| finding.message.contains("does not see the pins"));
        let missed = missed.unwrap_or_else(|| panic!("{angle}: {found:#?}"));
        let measured = missed.measured.unwrap();
        assert_eq!((missed.severity, measured.value), (severity, holes), "{angle}");
        assert_eq!(measured.limit, 58.0);
    }
}
