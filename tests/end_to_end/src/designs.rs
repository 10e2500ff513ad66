//! Built-in sensors as built by the library.

use std::collections::BTreeSet;
use std::env;

use fabkit_designs::{Design, builtin_names, builtin_yaml, load};
use fabkit_geometry::{Body, Solid};

/// Sensors whose fixtures are tested by default: one of each kind of surface.
const WITH_FIXTURES: [&str; 3] = ["rtac0", "9dtact", "fluidic"];

/// Returns whether tests cover everything, as in `cargo xtask test --full`: with `FABKIT_FULL=1`. Without it they cover
/// a sample where many cases are similar; the sample is the same on every machine.
pub fn is_full() -> bool {
    env::var_os("FABKIT_FULL").is_some_and(|value| value == "1")
}

/// Returns the divisor of sample sizes that `cargo xtask test` has found for this machine: 1 on a quick one, 2 or 4 on
/// slow ones, from `FABKIT_SLOWNESS`.
pub fn slowness() -> usize {
    let stated = env::var("FABKIT_SLOWNESS").ok().and_then(|text| text.parse().ok());
    stated.filter(|slowness| *slowness > 0 && !is_full()).unwrap_or(1)
}

/// Returns the names of the built-in sensors under test: the first of each family, or all with [`is_full`]. The others
/// differ from it in numbers only, and `fabkit check` is always run on all of them.
pub fn tested_sensors() -> Vec<&'static str> {
    let mut families = BTreeSet::new();
    let is_new = |name: &&str| is_full() || families.insert(build_design(name, &[]).family);
    builtin_names().into_iter().filter(is_new).collect()
}

/// Returns [`tested_sensors`], or every second or fourth of them on a slow machine, for tests that take seconds of each.
pub fn sampled_sensors() -> Vec<&'static str> {
    tested_sensors().into_iter().step_by(slowness()).collect()
}

/// Builds the sensors of [`tested_sensors`] with their own values.
///
/// # Panics
/// If one does not load.
pub fn builtin_designs() -> Vec<Design> {
    tested_sensors().into_iter().map(|name| build_design(name, &[])).collect()
}

/// Builds a built-in sensor with settings as after `--set`. The sections of other crates in its file (`fixtures`) are
/// skipped.
///
/// # Panics
/// If it does not load.
pub fn build_design(name: &str, settings: &[&str]) -> Design {
    let yaml = builtin_yaml(name).expect("named by the registry");
    let listed: Vec<String> = settings.iter().map(|set| (*set).to_owned()).collect();
    load(name, yaml, &listed, &["fixtures"])
        .unwrap_or_else(|error| panic!("{name} {settings:?}: {error:?}"))
}

/// Builds the fixtures of three built-in sensors with their own values, or of every sensor with [`is_full`]. A fixture
/// that several sensors share is returned once.
///
/// # Panics
/// If one cannot be built.
pub fn builtin_fixtures() -> Vec<Design> {
    let mut fixtures: Vec<Design> = Vec::new();
    let is_wanted = |name: &&str| is_full() || WITH_FIXTURES.contains(name);
    for name in builtin_names().into_iter().filter(is_wanted) {
        let yaml = builtin_yaml(name).expect("named by the registry");
        let project = fabkit_fixtures::load(name, yaml, &[]);
        let project = project.unwrap_or_else(|e| panic!("{name}: {:#?}", e.problems));
        for fixture in project.fixture_names() {
            let design = project.fixture(fixture);
            let design = design.unwrap_or_else(|e| panic!("{name}/{fixture}: {e:#?}"));
            // Fixtures of several sensors may be the same solids.
            let is_new = !fixtures.iter().any(|known| solids(known).eq(solids(&design)));
            fixtures.extend(is_new.then_some(design));
        }
    }
    fixtures
}

/// Returns the cases that a test covers: the first and every third after it, fewer on a slow machine, or all with
/// [`is_full`].
pub fn sample_cases<T>(cases: &[T]) -> Vec<&T> {
    cases.iter().step_by(if is_full() { 1 } else { 3 * slowness() }).collect()
}

/// Returns the bodies under test: all of them, except that of the hundred halves of a fixture, which differ only in
/// their protrusions, every tenth is taken, unless [`is_full`].
pub fn sample_bodies(design: &Design) -> impl Iterator<Item = &Body> {
    let all = is_full();
    let number = |body: &Body| body.name.rsplit_once('-').and_then(|(_, n)| n.parse::<u32>().ok());
    design.sensor.bodies.iter().filter(move |body| all || number(body).is_none_or(|n| n % 10 == 0))
}

fn solids(design: &Design) -> impl Iterator<Item = &Solid> {
    let components = design.sensor.components().map(|component| &component.solid);
    design.sensor.parts().map(|part| &part.solid).chain(components)
}
