//! `extends` and `--set`.

use super::bulb::{GLOW, REGISTRY, problem};
use fabkit_designs::Design;
use fabkit_designs::parameters::{Setting, SourceKind};

fn load(yaml: &str, overrides: &[&str]) -> Design {
    let overrides: Vec<String> = overrides.iter().map(|&o| o.to_owned()).collect();
    REGISTRY.load("my.yaml", yaml, &overrides, &[]).unwrap()
}

fn row<'a>(design: &'a Design, path: &str) -> &'a Setting {
    design.parameters.iter().find(|s| s.path == path).unwrap()
}

#[test]
fn a_file_that_extends_lists_only_what_differs() {
    let design = load("format: 1\nextends: glow\nname: mine\nsurface:\n  radius: 9 mm\n", &[]);
    assert_eq!((&*design.sensor.name, &*design.sensor.title), ("mine", "Glow"));
    assert_eq!(row(&design, "surface.radius").value, "9 mm");
    assert_eq!(row(&design, "surface.radius").source.kind, SourceKind::User);
    assert_eq!(row(&design, "surface.wall_height").source.kind, SourceKind::Paper);
    // Through a built-in sensor that extends another.
    let design = load("format: 1\nextends: glow-wide\n", &[]);
    assert_eq!(design.sensor.name, "glow-wide");
    assert_eq!(row(&design, "surface.radius").value, "20 mm");
    assert_eq!(row(&design, "optics.leds").value, "8");
}

#[test]
fn what_is_extended_must_exist_and_fit() {
    let found = problem("format: 1\nextends: gloww\n", &[]);
    assert_eq!((found.line, found.column), (Some(2), Some(10)));
    assert_eq!(found.hint.unwrap(), "did you mean `glow`?");
    let found = problem("format: 1\nextends: ../../etc/passwd\n", &[]);
    assert!(found.message.contains("is not a built-in sensor"));
    let found = problem("format: 1\nextends: loop\n", &[]);
    let chain = "my.yaml -> loop.yaml (built-in) -> loop.yaml (built-in)";
    assert_eq!(found.message, format!("extends `loop`, which extends itself: {chain}"));
    let found = problem("format: 1\nextends: other.yaml\n", &[]);
    assert_eq!(found.message, "extends `other.yaml`, a file that is not at hand here");
    let found = problem("format: 1\nextends: [glow]\n", &[]);
    assert_eq!(found.message, "extends must be followed by one word");
}

#[test]
fn a_limit_that_the_base_sets_names_the_base() {
    let found = problem("format: 1\nextends: glow\nsurface:\n  radius: 4 mm\n", &[]);
    assert_eq!(found.file, "glow.yaml (built-in)");
    assert_eq!(found.line, Some(11));
    assert!(found.message.contains("surface.radius is 4 mm in my.yaml:4"), "{}", found.message);
}

#[test]
fn format_and_family_come_first() {
    let found = problem("format: 2\nextends: glow\n", &[]);
    assert_eq!(found.message, "format is `2`; this version of fabkit reads 1");
    let found = problem("extends: glow\n", &[]);
    assert_eq!(found.message, "the format is missing");
    let found = problem("format: 1\nfamily: bulp\n", &[]);
    assert_eq!(found.hint.unwrap(), "did you mean `bulb`?");
    let found = problem("format: 1\nname: x\n", &[]);
    assert!(found.hint.unwrap().contains("`family: NAME` with one of bulb"));
    assert!(problem("", &[]).message.contains("empty"));
    assert!(problem("# nothing\n", &[]).message.contains("empty"));
    assert!(problem("- 1\n", &[]).message.contains("keys and values"));
}

#[test]
fn overrides_win_and_are_marked() {
    let design = load(GLOW, &["surface.radius = 0.5 in", "optics.rings=[3 mm]", "title=A: b"]);
    assert_eq!(row(&design, "surface.radius").value, "12.7 mm");
    assert_eq!(row(&design, "surface.radius").source.kind, SourceKind::User);
    assert_eq!(row(&design, "surface.radius").source.note, "--set");
    assert_eq!(row(&design, "optics.rings").value, "[3 mm]");
    assert_eq!(design.sensor.title, "A: b");
    // Before limits are checked: a bad value in the file does not matter any more.
    let design = load(&GLOW.replace("15.0 mm", "900 mm"), &["surface.radius=9 mm"]);
    assert_eq!(row(&design, "surface.radius").value, "9 mm");
}

#[test]
fn wrong_overrides_are_told() {
    for (overrides, path, says, hint) in [
        (&["surface.radius=9"][..], "surface.radius", "has no unit", "write `9 mm`"),
        (&["surface.radius=900 mm"], "surface.radius", "between 4 mm and 60 mm", "60 mm"),
        (&["surface.radius=nan"], "surface.radius", "is not finite", "write a number"),
        (&["surface.radius="], "surface.radius", "set to nothing", "=VALUE"),
        (&["surface.radius"], "", "is not an override", "path=value"),
        (&["surfce.radius=9 mm"], "surfce.radius", "is not a parameter", "`surface.radius`"),
        (&["radius=9 mm"], "radius", "is not a parameter", "`surface.radius`"),
        (&["surface.radius.value=9 mm"], "surface.radius.value", "is not a", "surface.radius"),
        (&["zzz=1"], "zzz", "is not a parameter", "fabkit show"),
        (&["surface=9 mm"], "surface", "is a section", "surface.radius, surface.wall_height"),
        (&["family=other"], "family", "is not a parameter", "decided by the file"),
        (&["optics.rings=3 mm"], "optics.rings", "is a list", "[a, b, c]"),
        (&["optics.rings=[3 mm"], "optics.rings", "cannot be read", "[a, b]"),
        (&["optics.rings=*a"], "optics.rings", "aliases", "[a, b]"),
        (&["optics.leds=7", "optics.leds=8"], "optics.leds", "to `7` and to `8`", "keep one"),
    ] {
        let found = problem(GLOW, overrides);
        assert_eq!((&*found.file, found.line), ("--set", None), "{overrides:?}");
        assert_eq!(found.path, path);
        assert!(found.message.contains(says), "{found:#?}");
        assert!(found.hint.as_ref().unwrap().contains(hint), "{found:#?}");
    }
}
