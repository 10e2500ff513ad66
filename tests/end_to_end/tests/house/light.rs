//! What the code of light and rays may not do, because what follows from it is a wrong answer that nobody notices.

use std::fs;
use std::path::{Path, PathBuf};

use super::crates::root;

/// A text that may stand in few files only.
struct Rule {
    /// Texts, without spaces.
    texts: &'static [&'static str],
    /// Rooms that the rule is about.
    rooms: &'static [&'static str],
    /// Ends of the paths of files that may hold the text.
    except: &'static [&'static str],
    /// What to do instead.
    instead: &'static str,
}

const RULES: [Rule; 3] = [
    Rule {
        texts: &["/ray.direction[", "/line.direction[", "direction.map(f64::recip)"],
        rooms: &["geometry", "physics", "simulation", "designs", "fixtures", "fabkit"],
        except: &[],
        instead: "a component of 0 makes the quotient infinite or NaN: ask `Ray::range_in`, which says what it means",
    },
    Rule {
        texts: &["bodies.retain("],
        rooms: &["physics", "simulation"],
        except: &[
            // These trace straight rays, which no hole refracts.
            "physics/light/src/light_sources.rs",
            "simulation/capture/src/columns.rs",
        ],
        instead: "a body that is taken off leaves a hole in the gel around it: `OpticalStack::without_body` fills it",
    },
    Rule {
        texts: &["0.5*size[0]", "0.5*f64::from(camera.width_px())", "camera.width_px())/2.0"],
        rooms: &["physics", "simulation", "calibration", "fabkit", "export"],
        except: &[],
        instead: "centres of pixels have whole coordinates: `image_centre_px` is the middle of an image",
    },
];

/// Returns the Rust files below a folder, tests and examples apart, in order.
pub fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut entries: Vec<PathBuf> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    let is_own = |path: &PathBuf| {
        let name = path.file_name().unwrap().to_string_lossy();
        !["tests", "examples", "benches", "target", "tests.rs"].contains(&&*name)
    };
    let own = entries.into_iter().filter(is_own);
    own.flat_map(|path| match path.is_dir() {
        true => sources(&path),
        false => vec![path],
    })
    .filter(|path| path.extension().is_some_and(|extension| extension == "rs"))
    .collect()
}

/// Returns the lines of code that hold one of the texts, up to the file's own tests, with their numbers.
fn breaches(code: &str, texts: &[&str]) -> Vec<usize> {
    let own = code.split("#[cfg(test)]").next().unwrap_or(code);
    let lines = own.lines().enumerate();
    let is_breach = |line: &str| {
        let line: String = line.chars().filter(|c| !c.is_whitespace()).collect();
        !line.starts_with("//") && texts.iter().any(|text| line.contains(text))
    };
    lines.filter(|(_, line)| is_breach(line)).map(|(number, _)| number + 1).collect()
}

#[test]
fn what_makes_silent_errors_of_light_stands_nowhere() {
    let mut found = Vec::new();
    for rule in &RULES {
        for path in rule.rooms.iter().flat_map(|room| sources(&root().join(room))) {
            let name = path.strip_prefix(root()).unwrap().to_string_lossy().into_owned();
            if rule.except.iter().any(|end| name == *end) {
                continue;
            }
            let code = fs::read_to_string(&path).unwrap();
            let lines = breaches(&code, rule.texts).into_iter();
            found.extend(lines.map(|line| format!("{name}:{line}: {}", rule.instead)));
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn a_breach_is_found_where_it_stands() {
    let code = "// a / ray.direction[0]\nlet t = (side - o) / ray.direction[axis];\n#[cfg(test)]\n1.0 / ray.direction[0]";
    assert_eq!(breaches(code, RULES[0].texts), [2]);
    assert_eq!(breaches("ground.bodies.retain(|b| b.name != *marks);", RULES[1].texts), [1]);
}
