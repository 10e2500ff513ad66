//! What the house forbids. Each rule answers with everything that breaks it, in words.

use std::collections::{BTreeMap, BTreeSet};

use super::crates::{Crate, Crates, short};
use super::plan::{Forbidden, Plan, Row};
use super::tokens::Token;

/// Rooms that may use all others, and that nobody may use.
const ABOVE_ALL: [&str; 2] = ["tests", "xtask"];

/// Where code may touch files. Tests may everywhere.
const MAY_TOUCH_FILES: [&str; 5] =
    ["geometry/files", "fabkit/command", "fabkit/python", "tests", "xtask"];

/// A file's code, as far as rules ask for it; tests left out.
pub struct Code {
    /// Its path from the root.
    pub path: String,
    /// All paths that it names, from their beginning.
    pub paths: Vec<Vec<String>>,
    /// Words, signs and texts.
    pub tokens: Vec<Token>,
}

/// Short names of those that are crates of the workspace.
fn of_workspace(crates: &Crates, used: &BTreeSet<String>) -> BTreeSet<String> {
    let own = used.iter().filter(|used| crates.contains_key(*used));
    own.map(|used| short(used).to_owned()).collect()
}

/// Rows and crates are the same, and each row's `uses` and `tests also use` are what cargo sees.
pub fn wrong_rows(plan: &Plan, crates: &Crates) -> Vec<String> {
    let mut wrong = Vec::new();
    for (package, own) in crates {
        let Some(row) = plan.crates.iter().find(|row| row.folder == own.folder) else {
            wrong.push(format!("{} stands in no README", own.folder));
            continue;
        };
        if row.name() != short(package) {
            wrong.push(format!("{} is called {}, not {}", own.folder, short(package), row.name()));
        }
        let uses = of_workspace(crates, &own.uses);
        let for_tests = of_workspace(crates, &own.tests_use);
        let tests_also_use: BTreeSet<String> = for_tests.difference(&uses).cloned().collect();
        for (column, here, said) in
            [("uses", &uses, &row.uses), ("tests also use", &tests_also_use, &row.tests_also_use)]
        {
            if here != said {
                wrong.push(format!("{} {column} {here:?}, its README says {said:?}", own.folder));
            }
        }
    }
    let is_crate = |row: &&Row| crates.values().any(|own| own.folder == row.folder);
    for row in plan.crates.iter().filter(|row| !is_crate(row)) {
        if !row.uses.is_empty() || !row.tests_also_use.is_empty() {
            wrong.push(format!("{} is no crate, and uses some", row.folder));
        }
    }
    wrong
}

/// Arrows between rooms that do not point down the list of rooms.
pub fn arrows_up(plan: &Plan, crates: &Crates) -> Vec<String> {
    let place = |room: &str| {
        if ABOVE_ALL.contains(&room) {
            Some(0)
        } else {
            plan.rooms.iter().position(|row| row.folder == room).map(|place| place + 1)
        }
    };
    let mut wrong = Vec::new();
    for (package, own) in crates {
        let Some(from) = place(own.room()) else {
            wrong.push(format!("{} lies in no room", own.folder));
            continue;
        };
        for (used, target) in own
            .uses
            .iter()
            .chain(&own.tests_use)
            .filter_map(|used| crates.get_key_value(used).filter(|(used, _)| *used != package))
        {
            if target.room() != own.room() && place(target.room()).is_none_or(|to| to <= from) {
                wrong.push(format!("{} uses {}, which lies above it", own.folder, short(used)));
            }
        }
    }
    wrong
}

/// What crates know that they, or their rooms, may not.
pub fn forbidden(
    plan: &Plan,
    crates: &Crates,
    sensors: &[String],
    code: &dyn Fn(&Crate) -> Vec<Code>,
) -> Vec<String> {
    let mut wrong = Vec::new();
    let all_packages: BTreeSet<&String> = crates.values().flat_map(|own| &own.uses).collect();
    let is_folder =
        |folder: &str| crates.values().any(|own| own.folder == folder || own.room() == folder);
    for own in crates.values() {
        let of = |rows: &'_ [Row], folder: &str| {
            let row = rows.iter().find(|row| row.folder == folder);
            row.map_or(Vec::new(), |row| row.forbidden.clone())
        };
        let all = [of(&plan.rooms, own.room()), of(&plan.crates, &own.folder)].concat();
        let is_of_code =
            |one: &Forbidden| matches!(one, Forbidden::Word(_) | Forbidden::SensorNames);
        let files = if all.iter().any(is_of_code) { code(own) } else { Vec::new() };
        for one in all {
            match one {
                Forbidden::Folder(folder) if !is_folder(&folder) => {
                    wrong.push(format!("{}: {folder}/ is no room and no crate", own.folder));
                }
                Forbidden::Folder(folder) => wrong.extend(way_to(crates, own, &folder)),
                Forbidden::Package(package) if !all_packages.contains(&package) => {
                    wrong.push(format!("{}: nobody uses a package {package}", own.folder));
                }
                Forbidden::Package(package) => {
                    let knows = own.uses.contains(&package);
                    wrong.extend(knows.then(|| format!("{} uses {package}", own.folder)));
                }
                Forbidden::Word(word) => {
                    let saying = files.iter().filter(|file| names(&file.paths, &word));
                    wrong.extend(saying.map(|file| format!("{} names {word}", file.path)));
                }
                Forbidden::SensorNames => wrong.extend(files.iter().flat_map(|file| {
                    let named = sensors.iter().filter(|name| {
                        file.tokens.iter().any(|token| *token == Token::Text((*name).clone()))
                    });
                    named.map(|name| format!("{} names the sensor {name}", file.path))
                })),
            }
        }
    }
    wrong
}

/// How a crate comes to know one of a folder, as `a -> b -> c`.
fn way_to(crates: &Crates, from: &Crate, folder: &str) -> Option<String> {
    let mut seen = BTreeSet::from([from.folder.as_str()]);
    let mut ways = vec![vec![from]];
    while let Some(way) = ways.pop() {
        let last = way[way.len() - 1];
        for next in last.uses.iter().filter_map(|used| crates.get(used)) {
            let longer = [&way[..], &[next]].concat();
            if next.folder != from.folder && (next.folder == folder || next.room() == folder) {
                let names: Vec<_> = longer.iter().map(|own| own.folder.as_str()).collect();
                return Some(format!("{} knows {folder}/: {}", from.folder, names.join(" -> ")));
            }
            if seen.insert(&next.folder) {
                ways.push(longer);
            }
        }
    }
    None
}

/// Whether one of the paths is `std::fs`, or lies in it; of `println!` the macro's name.
fn names(paths: &[Vec<String>], word: &str) -> bool {
    let word: Vec<&str> = word.trim_end_matches('!').split("::").collect();
    paths.iter().any(|path| path.len() >= word.len() && path.iter().zip(&word).all(|(a, b)| a == b))
}

/// Files whose code touches the file system where that is not its business, but for `exceptions`; and
/// exceptions that are none any more.
pub fn touching_files(
    crates: &Crates,
    exceptions: &[&str],
    code: &dyn Fn(&Crate) -> Vec<Code>,
) -> Vec<String> {
    let is_free = |own: &Crate| {
        MAY_TOUCH_FILES.iter().any(|folder| own.folder == *folder || own.room() == *folder)
    };
    let files = crates.values().filter(|own| !is_free(own)).flat_map(code);
    let found: Vec<String> =
        files.filter(|file| names(&file.paths, "std::fs")).map(|file| file.path).collect();
    except("names std::fs", &found, exceptions)
}

/// What is found but for exceptions, and exceptions that are none any more.
pub fn except(what: &str, found: &[String], exceptions: &[&str]) -> Vec<String> {
    let is_excepted = |file: &&String| exceptions.contains(&file.as_str());
    let wrong = found.iter().filter(|file| !is_excepted(file));
    let past = exceptions.iter().filter(|file| !found.iter().any(|found| found == *file));
    let wrong = wrong.map(|file| format!("{file} {what}"));
    wrong
        .chain(past.map(|file| format!("{file} is no exception any more: strike it out")))
        .collect()
}

/// The packages from outside that have few users, with those that have others than they may.
pub fn wrong_users(crates: &Crates, few: &BTreeMap<String, BTreeSet<String>>) -> Vec<String> {
    let users = |package: &String| -> BTreeSet<String> {
        let using = crates.iter().filter(|(_, own)| own.uses.contains(package));
        using.map(|(name, _)| short(name).to_owned()).collect()
    };
    let wrong = few.iter().filter(|(package, said)| users(package) != **said);
    wrong
        .map(|(package, said)| format!("{package} is used by {:?}, not {said:?}", users(package)))
        .collect()
}
