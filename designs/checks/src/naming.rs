//! Parts that are only told apart by capital letters: file systems take their files for one.

use crate::case::{Case, Looked};
use crate::declaration::rule;
use crate::finding::Finding;
use crate::rule::Rule;

rule! {
    /// Files of different parts do not replace each other.
    Naming = "naming",
    examines: "names of parts",
    finds: "parts whose names differ by capital letters alone",
    limit: "—",
    for_variants: true,
    look: apply,
}

fn apply(case: &Case<'_>) -> Looked {
    let names: Vec<&str> = case.sensor.parts().map(|part| part.name.as_str()).collect();
    let same = |(i, name): (usize, &&str)| {
        let before = names[..i].iter().find(|before| before.eq_ignore_ascii_case(name))?;
        let message =
            format!("{name} and {before} are one file where capital letters do not count");
        Some(Finding::error(Rule::Naming, message, "rename one of them").of([*name, *before]))
    };
    Ok((names.iter().enumerate().filter_map(same).collect(), names.len()))
}

#[test]
fn names_that_differ_by_capital_letters_alone_are_found() {
    let mut sensor = crate::example::puck();
    let of =
        |sensor: &fabkit_geometry::Sensor| crate::check(sensor).unwrap().of(Rule::Naming).count();
    assert_eq!(of(&sensor), 0);
    let same = sensor.bodies[0].name.to_uppercase();
    sensor.bodies[1].name = same;
    assert_eq!(of(&sensor), 1);
}
