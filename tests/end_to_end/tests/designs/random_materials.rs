//! Random materials of one's own: where a value could turn a check red, leaving it out is said.

use std::fs;
use std::path::Path;

use fabkit_tests::{fabkit, is_full};
use serde_json::Value;

/// Random numbers, the same ones in every run.
struct Random(u64);

impl Random {
    fn below(&mut self, count: usize) -> usize {
        // Constants of Knuth's linear congruential generator; its high bits are the random ones.
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % count
    }

    fn one<'a>(&mut self, of: &[&'a str]) -> &'a str {
        of[self.below(of.len())]
    }
}

/// Key, values that designs live with, a value that some rule refuses where it asks, and the property's name.
type Figure = (&'static str, &'static [&'static str], &'static str, &'static str);

const CAST: [Figure; 6] = [
    ("cures", &["platinum"], "tin", "curing mechanism"),
    ("viscosity", &["3 Pa s", "4 Pa s", "0.8 Pa s"], "9000 Pa s", "viscosity"),
    ("strength", &["1380 kPa", "2000 kPa", "1600 kPa"], "2 kPa", "strength"),
    ("youngs_modulus", &["70 kPa", "110 kPa", "60 kPa"], "9000000 kPa", "Young's modulus"),
    ("clarity", &["translucent"], "opaque", "transparency"),
    ("shrinkage", &["0.1 %", "0.05 %", "0.2 %"], "10 %", "shrinkage"),
];

const PRINTED: [Figure; 3] = [
    ("hardness", &["Shore D 70", "Shore D 80", "Shore D 76"], "Shore 00-20", "hardness"),
    ("strength", &["20000 kPa", "35000 kPa"], "1 kPa", "strength"),
    ("inhibits_platinum", &["false"], "true", "cure inhibition"),
];

/// Sensors with a layer that is cast of a material of one's own, each with the lines that name it.
const LAYERS: [(&str, &str); 4] = [
    ("rtac0", "translucent_gel: {material: MATERIAL}"),
    ("rtac0", "transparent_gel: {material: MATERIAL}"),
    ("digit-like", "pad: {material: MATERIAL}"),
    ("9dtact", "pad: {material: MATERIAL}"),
];

/// Findings and open questions of a design with a material that states these figures.
fn check(
    folder: &Path,
    (sensor, line): (&str, &str),
    base: &str,
    stated: &[String],
) -> (Vec<String>, Vec<String>) {
    let stated: String = stated.iter().map(|line| format!("    {line}\n")).collect();
    let line = line.replace("MATERIAL", "Lab stuff");
    let yaml = format!(
        "format: 1\nextends: {sensor}\nname: own\nmaterials:\n  Lab stuff:\n{base}{stated}{line}\n"
    );
    fs::write(folder.join("own.yaml"), &yaml).unwrap();
    let run = fabkit(folder, &["check", "own.yaml", "--json"]);
    assert!(matches!(run.code, Some(0 | 1)), "{yaml}{}", run.stderr);
    let document: Value = serde_json::from_str(&run.stdout).unwrap();
    let all = |key: &str, words: [&str; 2]| {
        let items = document[key].as_array().unwrap().iter();
        items
            .map(|one| words.map(|word| one[word].as_str().unwrap().to_owned()).join(" of "))
            .collect()
    };
    (all("findings", ["rule", "message"]), all("not_known", ["property", "material"]))
}

/// Each random material states some figures and not others. Two checks of it with one figure at two ends differ if a rule
/// asks for it; then the check without it has to name it.
#[test]
fn what_could_turn_a_check_red_is_asked_for_where_it_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random(53);
    let (mut asked, mut materials) = (0, 0);
    for _ in 0..if is_full() { 100 } else { 6 } {
        let is_cast = random.below(3) > 0;
        let (place, base, figures) = if is_cast {
            let place = LAYERS[random.below(LAYERS.len())];
            (place, "    kind: gel\n    density: 1.1 g/cm3\n    cure: {time: 4 h}\n", &CAST[..])
        } else {
            let part = ["shell", "base", "lid-translucent-gel"][random.below(3)];
            let line: &'static str = match part {
                "shell" => "parts: {shell: {material: MATERIAL}}",
                "base" => "parts: {base: {material: MATERIAL}}",
                _ => "parts: {lid-translucent-gel: {material: MATERIAL}}",
            };
            (("rtac0", line), "    sort: plastic\n", &PRINTED[..])
        };
        let tried = &figures[random.below(figures.len())];
        // Others are stated or not.
        let mut others = Vec::new();
        for (key, good, ..) in figures.iter().filter(|figure| figure.0 != tried.0) {
            if random.below(3) > 0 {
                others.push(format!("{key}: {}", random.one(good)));
            }
        }
        let with = |value: &str| [&others[..], &[format!("{}: {value}", tried.0)]].concat();
        let good = check(folder.path(), place, base, &with(random.one(tried.1)));
        let bad = check(folder.path(), place, base, &with(tried.2));
        let without = check(folder.path(), place, base, &others);
        materials += 1;
        let question = format!("{} of Lab stuff", tried.3);
        assert!(
            !good.1.contains(&question),
            "{place:?}, {others:?}: {question} though it is stated"
        );
        if good.0 != bad.0 {
            asked += 1;
            assert!(
                without.1.contains(&question),
                "{place:?}, {others:?}: nobody asks for {question}, which can turn the check: {:?} and {:?}",
                good.0,
                bad.0
            );
        }
    }
    assert!(3 * asked > materials, "{asked} of {materials} figures mattered");
}
