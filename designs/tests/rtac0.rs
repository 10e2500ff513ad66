//! The built-in R-Tac0: it loads, every solid is valid, and derived figures are the published ones.

use fabkit_designs::{Design, builtin_yaml, load};

fn rtac0(overrides: &[&str]) -> Design {
    let overrides: Vec<String> = overrides.iter().map(|o| o.to_string()).collect();
    let yaml = builtin_yaml("rtac0").unwrap();
    load("rtac0.yaml", yaml, &overrides).unwrap_or_else(|e| panic!("{e}: {:#?}", e.problems))
}

#[test]
fn every_solid_is_valid() {
    let sensor = rtac0(&[]).sensor;
    let solids = sensor
        .parts
        .iter()
        .map(|p| (&p.name, &p.solid))
        .chain(sensor.layers.iter().map(|l| (&l.name, &l.solid)))
        .chain(sensor.components.iter().map(|c| (&c.name, &c.solid)));
    for (name, solid) in solids {
        solid.validate().unwrap_or_else(|e| panic!("{name}: {e}"));
    }
}

#[test]
fn the_published_shell_height_follows_from_the_stack() {
    // Diffuser, gap, LED board and base were measured or chosen one by one; the published shell,
    // measured independently, is 21.65 mm high.
    let design = rtac0(&[]);
    let shell_height = design.derived.iter().find(|(name, _)| name == "shell height").unwrap();
    assert_eq!(shell_height.1, "21.650 mm");
}
