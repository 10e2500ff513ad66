//! Files that can be read, and files that cannot: where, what, which limit, what to do.

use super::bulb::{GLOW, REGISTRY, glow_with, problem, problems};
use fabkit_designs::parameters::SourceKind;

#[test]
fn a_good_file_gives_values_with_sources_in_order() {
    let design = REGISTRY.load("glow.yaml", GLOW, &[], &[]).unwrap();
    assert_eq!(design.sensor.name, "glow");
    assert_eq!(design.sensor.camera.field_of_view.to_string(), "160 deg");
    assert_eq!(design.derived, [("height".to_owned(), "21 mm".to_owned())]);
    let row = |i: usize| &design.parameters[i];
    let paths: Vec<&str> = design.parameters.iter().map(|s| &*s.path).collect();
    assert_eq!(paths, REGISTRY.parameter_paths("bulb"));
    assert_eq!(row(0).path, "surface.radius");
    assert_eq!(row(0).value, "15 mm");
    assert_eq!(row(0).limits, "4 mm to 60 mm");
    assert_eq!(row(0).summary, "Radius of hemisphere and wall.");
    assert_eq!(row(0).source.kind, SourceKind::Measured);
    assert_eq!(row(0).source.note, "published mesh");
    assert_eq!(row(7).path, "optics.rings");
    assert_eq!(row(7).value, "[1 mm, 2.5 mm]");
    assert_eq!(row(7).limits, "1 to 3 items, each 0 mm to 60 mm");
}

#[test]
fn every_written_form_of_a_value_reads_the_same() {
    let plain = glow_with("{value: 15.0 mm, source: measured, note: published mesh}", "1.5cm");
    let quoted = plain.replace("1.5cm", "\"15 mm\"");
    let bom_and_crlf = format!("\u{feff}{}", GLOW.replace('\n', "\r\n"));
    for yaml in [&plain, &quoted, &bom_and_crlf] {
        let design = REGISTRY.load("x", yaml, &[], &[]).unwrap();
        assert_eq!(design.parameters[0].value, "15 mm");
    }
    let design = REGISTRY.load("x", &plain, &[], &[]).unwrap();
    assert_eq!(design.parameters[0].source.kind, SourceKind::User);
}

/// Each value that cannot stand where the radius (line 7, column 19) stands.
#[test]
fn a_wrong_value_is_told_with_place_limit_and_hint() {
    let limit = "it must be between 4 mm and 60 mm";
    for (value, says, hint) in [
        ("900 mm", "is 900 mm", "the nearest allowed value is 60 mm"),
        ("-3 mm", "is -3 mm", "the nearest allowed value is 4 mm"),
        ("12.5", "is `12.5`, which has no unit", "write `12.5 mm`"),
        ("12.5 deg", "is in `deg`, not in a unit of length", "one of mm, um, cm, m, in"),
        ("12.5 furlong", "is in `furlong`", "for example `12.5 mm`"),
        (".nan", "is not finite", "write a number"),
        ("NaN mm", "is not finite", "write a number"),
        (".inf", "is not finite", "write a number"),
        ("1e999 mm", "is not finite", "write a number"),
        ("wide", "is not a number with a unit", "for example `12.5 mm`"),
    ] {
        let found = problem(&glow_with("15.0 mm", value), &[]);
        let place = (found.line, found.column);
        assert_eq!(place, (Some(7), Some(19)), "{value}");
        assert_eq!((&*found.file, &*found.path), ("my.yaml", "surface.radius"), "{value}");
        assert_eq!(found.value, value);
        assert!(found.message.starts_with("surface.radius is "), "{}", found.message);
        assert!(found.message.contains(says), "{}", found.message);
        assert!(found.message.ends_with(limit), "{}", found.message);
        assert!(found.hint.as_ref().unwrap().contains(hint), "{:?}", found.hint);
        assert_eq!(found.to_string(), format!("my.yaml:7:19: {}", found.message));
    }
}

#[test]
fn every_kind_of_value_has_its_limits() {
    for (good, bad, path, says) in [
        ("value: 8,", "value: 8.0,", "optics.leds", "is not a whole number"),
        ("value: 8,", "value: -8,", "optics.leds", "is not a whole number"),
        ("value: 8,", "value: 65,", "optics.leds", "is 65; it must be between 1 and 64"),
        ("value: 8,", "value: 99999999999,", "optics.leds", "is too large"),
        ("160 deg", "160", "optics.field_of_view", "has no unit"),
        ("160 deg", "160 mm", "optics.field_of_view", "not in a unit of angle"),
        ("160 deg", "4 rad", "optics.field_of_view", "it must be between 10 deg and 220 deg"),
        ("0.5", "1.5", "layers.thinner", "is 1.5; it must be between 0 and 1"),
        ("0.5", ".nan", "layers.thinner", "is not finite"),
        ("0.5", "inf", "layers.thinner", "is not finite"),
        ("0.5", "0.5 mm", "layers.thinner", "is not a plain number"),
        ("true", "yes", "optics.diffuser", "is neither true nor false"),
        ("round", "squre", "optics.outline", "it must be one of round, square"),
        ("[1 mm, 2.5 mm]", "[]", "optics.rings", "has 0 items; it must have between 1 and 3"),
        ("[1 mm, 2.5 mm]", "[1 mm, 2]", "optics.rings[1]", "has no unit"),
        ("[1 mm, 2.5 mm]", "[1 mm, 99 mm]", "optics.rings[1]", "is 99 mm"),
        ("[1 mm, 2.5 mm]", "1 mm", "optics.rings", "is a list"),
        ("[1 mm, 2.5 mm]", "[[1 mm]]", "optics.rings[0]", "is not a single value"),
        ("15.0 mm", "[15.0 mm]", "surface.radius", "is a single value, not a list"),
        ("Ecoflex 00-30", "\"a\\tb\"", "layers.gel.material", "contains a control character"),
        ("Ecoflex 00-30", "\"\"", "layers.gel.material", "between 1 and 20 characters long"),
        ("name: glow", "name: Glow 1", "name", "is not a name"),
        ("name: glow", "name: ../glow", "name", "is not a name"),
        ("source: measured", "source: mesured", "surface.radius.source", "must be one of paper"),
        ("source: measured", "sauce: measured", "surface.radius.sauce", "is not known"),
        ("value: 15.0 mm, ", "", "surface.radius", "has no `value`"),
        ("value: 15.0 mm, ", "value: , ", "surface.radius", "has no `value`"),
    ] {
        let found = problem(&glow_with(good, bad), &[]);
        assert_eq!(found.path, path, "{bad}: {found:#?}");
        assert!(found.message.contains(says), "{bad}: {found:#?}");
        assert!(found.line.is_some() && found.column.is_some(), "{bad}: {found:#?}");
    }
    let found = problem(&glow_with("round", "squre"), &[]);
    assert_eq!(found.hint.unwrap(), "did you mean `square`?");
}

#[test]
fn limits_are_inclusive_in_every_unit() {
    for (good, limit) in [
        ("15.0 mm", "60 mm"),
        ("15.0 mm", "6 cm"),
        ("15.0 mm", "0.06 m"),
        ("15.0 mm", "4000 um"),
        ("160 deg", "220 deg"),
        ("160 deg", "10 °"),
    ] {
        // With a gel that fits the smallest sensor.
        let yaml = glow_with(good, limit).replace("1.5 mm", "1 mm");
        assert!(REGISTRY.load("x", &yaml, &[], &[]).is_ok(), "{limit}");
    }
}

#[test]
fn an_unknown_key_suggests_what_was_meant() {
    let found = problem(&format!("{GLOW}  colour: red\n"), &[]);
    assert_eq!((found.line, found.column), (Some(20), Some(3)));
    assert_eq!(found.message, "`colour` is not a key of optics");
    let hint = found.hint.unwrap();
    // It is often looked for, and there is a reason why there is none.
    assert!(hint.starts_with("fabkit has none: a part has the colour"), "{hint}");
    assert!(hint.contains("the keys are leds, field_of_view"), "{hint}");
    // Mistyped, hence not missing: one problem.
    let found = problem(&glow_with("wall_height", "wall_hight"), &[]);
    assert_eq!(found.message, "`wall_hight` is not a key of surface");
    assert_eq!(found.hint.unwrap(), "did you mean `wall_height`?");
    assert_eq!(problem(&glow_with("surface:", "surfaces:"), &[]).line, Some(6));
    // The right key in the wrong section.
    let found = problem(&format!("{GLOW}radius: 9 mm\n"), &[]);
    assert_eq!(found.message, "`radius` is not a key of a sensor");
    assert_eq!(found.hint.unwrap(), "did you mean `surface.radius`?");
}

#[test]
fn what_is_missing_is_told_once_per_section() {
    let yaml =
        "format: 1\nfamily: bulb\nname: x\ntitle: X\nreference: ''\nsurface:\n  radius: 9 mm\n";
    let found = problems(yaml, &[]);
    let messages: Vec<&str> = found.iter().map(|p| &*p.message).collect();
    assert_eq!(
        messages,
        [
            "the file lacks the section `layers` and the section `optics`",
            "surface lacks `wall_height`",
        ]
    );
    assert_eq!(found[1].line, Some(6));
    let hint = found[0].hint.as_ref().unwrap();
    assert!(hint.contains("`layers.gel.thickness: 1.5 mm`"), "{hint}");
    assert!(hint.contains("and 5 more; `extends: glow`"), "{hint}");
}

#[test]
fn a_section_is_not_a_value() {
    let yaml = format!("{}surface: 9 mm\n", &GLOW[..GLOW.find("surface:").unwrap()]);
    let found = problems(&yaml, &[]);
    assert_eq!(found.len(), 2, "{found:#?}"); // and the other two sections are missing
    assert_eq!(found[1].message, "surface is a section, not a value");
    assert_eq!(found[1].hint.as_ref().unwrap(), "its keys are radius, wall_height");
    let found = problem(&glow_with("{value: 0.5, source: chosen, note: sprays well}", ""), &[]);
    assert_eq!(found.message, "layers.thinner has no value");
}

#[test]
fn all_errors_come_at_once_in_the_order_of_the_file() {
    let yaml = GLOW
        .replace("15.0 mm", "900 mm")
        .replace("wall_height", "wall_hight")
        .replace("value: 0.5", "value: .nan")
        .replace("value: 8", "value: many")
        .replace("note: Fig. 1}", "note: Fig. 1}\n  outline: square");
    let found = problems(&yaml, &["surface.radios=3 mm"]);
    let places: Vec<(&str, Option<usize>)> = found.iter().map(|p| (&*p.file, p.line)).collect();
    assert_eq!(
        places,
        [
            ("my.yaml", Some(7)),
            ("my.yaml", Some(8)),
            ("my.yaml", Some(13)),
            ("my.yaml", Some(15)),
            ("my.yaml", Some(20)),
            ("--set", None),
        ]
    );
}

#[test]
fn impossible_combinations_point_at_the_value_and_at_what_limits_it() {
    let yaml = GLOW.replace("1.5 mm", "7 mm").replace("value: 8", "value: 9");
    let found = problems(&yaml.replace("value: true", "value: false"), &[]);
    assert_eq!(found.len(), 2);
    assert_eq!((found[0].line, &*found[0].path), (Some(11), "layers.gel.thickness"));
    assert_eq!(
        found[0].message,
        "layers.gel.thickness is 7 mm; it must be at most 5 mm, because two thirds of the radius \
         are taken by the tube (surface.radius is 15.0 mm in my.yaml:7)"
    );
    assert_eq!(found[0].hint.as_ref().unwrap(), "write at most 5 mm, or change `surface.radius`");
    assert_eq!((found[1].line, &*found[1].value), (Some(15), "9"));
    // The value that the message offers works, although 10/3 has no end.
    let thin = problem(&GLOW.replace("1.5 mm", "7 mm"), &["surface.radius=10 mm"]);
    assert!(thin.message.contains("at most 3.333 mm"), "{}", thin.message);
    assert!(thin.message.contains("surface.radius is 10 mm in --set"), "{}", thin.message);
    let yaml = GLOW.replace("1.5 mm", "3.333 mm");
    assert!(REGISTRY.load("x", &yaml, &["surface.radius=10 mm".into()], &[]).is_ok());
    // They are reported together with values that are out of range, but not beside a key that is unknown: a default may stand
    // in for what its author meant.
    let sets = ["surface.radius=9 mm", "x=1"];
    let found = problems(&yaml, &sets[..1]);
    assert!(found.iter().any(|p| p.message.contains("at most 3 mm")), "{found:?}");
    let found = problems(&yaml, &sets);
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].message, "`x` is not a parameter");
}

#[test]
fn what_fails_while_building_is_told_too() {
    assert_eq!(problem(GLOW, &["name=unbuildable"]).message, "it cannot be built");
}
