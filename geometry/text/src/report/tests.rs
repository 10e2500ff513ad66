use fabkit_geometry::{Angle, Length};

use super::*;
use crate::layer::TextLayer;
use crate::place::{TextPlace, WrittenText};
use crate::{Dialect, ValueSource};

fn report() -> RuleReport {
    let place = TextPlace::new(TextLayer::File, "x.yaml", &const { Dialect::new("thing", 1, "") });
    let text = WrittenText::Scalar("1 mm".into());
    let source = ValueSource::user("");
    let written =
        BTreeMap::from([("wall".to_owned(), WrittenValue::new(place, text, source).into())]);
    RuleReport::new(written, Vec::new())
}

fn length(mm: f64) -> Length {
    Length::from_mm(mm).unwrap()
}

#[test]
fn the_limit_that_is_offered_is_itself_accepted() {
    for limit_mm in [1.0 / 3.0, 0.1 + 0.2, 2.0, 1e-4, 0.0] {
        let mut report = report();
        report.at_least("wall", length(-1.0), limit_mm, "it must hold");
        let hint = report.found[0].problem.hint.clone().unwrap();
        let offered: Length = hint.trim_start_matches("write at least ").parse().unwrap();
        assert!(offered.mm() - limit_mm < 1e-3, "{hint}");
        let mut report = self::report();
        report.at_least("wall", offered, limit_mm, "it must hold");
        assert!(report.is_clean(), "{hint}");
    }
    // 0.1 + 0.2 is a little more than 0.3, which still counts as 0.3.
    let mut report = report();
    report.at_least("wall", length(0.3), 0.1 + 0.2, "it must hold");
    report.at_most("wall", length(0.1 + 0.2), 0.3, "it must fit");
    assert!(report.is_clean());
    // A limit that came out as NaN is never met.
    report.at_most("wall", length(0.3), f64::NAN, "it must fit");
    report.at_least("wall", length(0.3), f64::NAN, "it must fit");
    assert_eq!(report.found.len(), 2);
}

#[test]
fn limits_are_offered_in_the_unit_and_the_steps_of_what_is_limited() {
    let mut report = report();
    report.at_most("wall", Angle::from_deg(9.0).unwrap(), 8.66, "it must turn");
    report.at_least("wall", Angle::from_deg(8.0).unwrap(), 8.61, "it must turn");
    report.at_most("wall", 9, 8.66, "they must fit");
    report.at_least("wall", 8, 8.61, "they must fit");
    report.at_most("wall", 0.5, 0.12349, "it must be soft");
    // Seven and a bit less by rounding are seven.
    report.at_most("wall", 7, 7.0 - 1e-10, "they must fit");
    let hints = report.found.iter().map(|found| found.problem.hint.clone().unwrap());
    let offered =
        ["at most 8.6 deg", "at least 8.7 deg", "at most 8", "at least 9", "at most 0.123"];
    assert_eq!(hints.collect::<Vec<_>>(), offered.map(|offer| format!("write {offer}")));
}

#[test]
fn a_limit_is_stated_for_the_parameter_that_it_names() {
    let place = TextPlace::new(TextLayer::File, "x.yaml", &const { Dialect::new("thing", 1, "") });
    let source = ValueSource::user("");
    let written = ["a", "box.a"].map(|path| {
        let text = WrittenText::Scalar("1".into());
        (path.to_owned(), WrittenValue::new(place.clone(), text, source.clone()).into())
    });
    let mut report = RuleReport::new(written.into(), Vec::new());
    struct Boxed {
        a: f64,
    }
    let (p, a) = (Boxed { a: 2.0 }, 3);
    let (r, at) = (&mut report, |path: &str| format!("box.{path}"));
    crate::limits! { r, p: a <= 1.0, "of p"; a >= 1.0, "it holds"; }
    crate::limits! { r, p, at => a <= 1.5, "of p, in the box"; }
    crate::limits! { r: a <= 2.0, "of the variable"; }
    let messages: Vec<_> = report.found.iter().map(|f| f.problem.message.as_str()).collect();
    assert_eq!(
        messages,
        [
            "a is 2; it must be at most 1, because of p",
            "box.a is 2; it must be at most 1.5, because of p, in the box",
            "a is 3; it must be at most 2, because of the variable",
        ]
    );
}

crate::choices! {
    /// Of the box.
    pub enum Lid {
        /// It takes room.
        Thick = "thick",
        /// It does not.
        Thin = "thin",
    }
}
crate::parameters! {
    /// Test.
    pub struct Crate {
        /// Wall.
        wall: Length = 0.0..=9.0,
        /// Width.
        width: Length = 0.0..=90.0,
        /// Ribs.
        ribs: u32 = 1..=9,
        /// Gaps.
        gaps: Vec<Length> = (1..=3, 0.0..=5.0),
        /// Lid.
        lid: Lid,
        /// Label, which says nothing of the wall.
        label: String = 0..=9,
        /// Weight, which does not either.
        weight: f64 = 0.0..=9.0,
    }
}

fn check(p: &Crate, report: &mut RuleReport) {
    let lid_mm = if p.lid == Lid::Thick { 1.0 } else { 0.0 };
    let gaps_mm: f64 = p.gaps.iter().map(|gap| gap.mm()).sum();
    // The wall cancels out of the limit; the weight would matter if it were larger.
    let room_mm = p.wall.mm() + p.width.mm() - gaps_mm - lid_mm - p.wall.mm();
    report.at_most("wall", p.wall, (room_mm / f64::from(p.ribs)).max(0.01 * p.weight), "it fits");
}

#[test]
fn a_limit_names_all_that_it_follows_from_and_nothing_else() {
    let place = TextPlace::new(TextLayer::File, "x.yaml", &const { Dialect::new("thing", 1, "") });
    let source = ValueSource::user("");
    let written = <Crate as crate::Section>::fields().into_iter().map(|field| {
        let text = WrittenText::Scalar("1".into());
        let written = WrittenValue::new(place.clone(), text, source.clone());
        (field.name.to_owned(), written.into())
    });
    let mut report = RuleReport::new(written.collect(), Vec::new());
    let p = Crate {
        wall: length(5.0),
        width: length(9.0),
        ribs: 2,
        gaps: vec![length(1.0), length(0.5)],
        lid: Lid::Thick,
        label: "a".into(),
        weight: 1.0,
    };
    check(&p, &mut report);
    report.find_limit_inputs("", &p, check);
    let problem = &report.found[0].problem;
    let hint = "write at most 3.25 mm, or change `width`, `ribs` or `gaps`";
    assert_eq!(problem.hint.as_deref(), Some(hint));
    let follows = "(width is 1 in x.yaml, ribs is 1 in x.yaml, gaps is 1 in x.yaml)";
    assert!(problem.message.ends_with(follows), "{}", problem.message);

    // Small changes do not move a saturated limit; the input that saturated it is still named.
    let drained = |p: &Crate, report: &mut RuleReport| {
        let room_mm = (p.width.mm() - 10.0).max(0.0);
        report.at_most("wall", p.wall, room_mm, "it fits");
    };
    let mut report = RuleReport::with_shared(report.written, Vec::new());
    drained(&p, &mut report);
    report.find_limit_inputs("", &p, drained);
    assert_eq!(report.found[0].problem.hint.as_deref(), Some("change `width`"));

    // Without any room, 0 is recommended.
    let absent = |p: &Crate, report: &mut RuleReport| {
        report.at_most_or_absent("wall", p.wall, p.width.mm() - 10.0, "it fits");
    };
    let mut report = RuleReport::with_shared(report.written, Vec::new());
    absent(&p, &mut report);
    report.find_limit_inputs("", &p, absent);
    let hint = "write at most 0 mm, or change `width`";
    assert_eq!(report.found[0].problem.hint.as_deref(), Some(hint));
}

#[test]
#[should_panic(expected = "`wal` is not a parameter")]
fn a_slip_in_a_path_shows_even_if_the_condition_holds() {
    report().require(true, "wal", String::new, String::new);
}

#[test]
fn items_of_a_long_list_are_moved_together() {
    let length = |mm| fabkit_geometry::Length::from_mm(mm).unwrap();
    let limits = (1..=1000, 0.0..=50.0);
    let moved = |items: usize| {
        let list: Vec<Length> = (0..items).map(|i| length(1.0 + i as f64 / 100.0)).collect();
        let mut moved = Vec::new();
        list.neighbours("gaps", &limits, 0.25, &mut |_, other: Vec<Length>| {
            moved.push(list.iter().zip(&other).filter(|(a, b)| a != b).count());
        });
        moved
    };
    // Two neighbours for each item, and the list without its last item.
    assert_eq!(moved(3), [1, 1, 1, 1, 1, 1, 0]);
    assert_eq!(moved(1000), [1000, 1000]);
}
