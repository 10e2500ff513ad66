//! Which room, crate and module may know which: the tables of ARCHITECTURE.md and of the rooms' READMEs, compared
//! with what cargo sees and with what code names.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::PathBuf;

use super::crates::{Crate, Crates, crates, root};
use super::modules::Modules;
use super::paths::{full_paths, names};
use super::plan::{Forbidden, Plan, Row, plan, rows, words};
use super::rules::{self, Code};
use super::tokens::{Token, tokens};

/// Files that touch the file system though their crate may not: each is to go, and none is to come.
const STILL_TOUCHING_FILES: &[&str] = &[];

/// Crates with circles of modules across folders: each is to go, and none is to come.
const STILL_IN_CIRCLES: &[&str] = &[];

/// A crate's files, tests left out.
fn code_of(own: &Crate) -> Vec<Code> {
    let modules = own.modules();
    let paths: BTreeSet<_> = modules.iter().flat_map(Modules::paths).collect();
    let read = |path: &PathBuf| {
        let tokens = tokens(&fs::read_to_string(path).unwrap());
        let own = path.strip_prefix(root()).unwrap_or(path);
        Code {
            path: own.to_string_lossy().replace('\\', "/"),
            paths: full_paths(&names(&tokens)),
            tokens,
        }
    };
    paths.iter().map(read).collect()
}

/// What the built-in sensors are called.
fn sensors() -> Vec<String> {
    let files = fs::read_dir(root().join("designs/families/sensors")).unwrap();
    let names =
        files.map(|file| file.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned());
    let found: Vec<String> = names.collect();
    assert!(found.iter().any(|name| name == "rtac0"), "{found:?}");
    found
}

/// # Panics
/// With all of it, one a line, if anything is wrong.
fn none(wrong: &[String]) {
    assert!(wrong.is_empty(), "\n{}\n", wrong.join("\n"));
}

#[test]
fn crates_use_what_their_readmes_say() {
    none(&rules::wrong_rows(&plan(), &crates()));
}

#[test]
fn arrows_between_rooms_point_down() {
    none(&rules::arrows_up(&plan(), &crates()));
}

#[test]
fn nobody_knows_what_they_may_not() {
    let (plan, crates) = (plan(), crates());
    none(&rules::forbidden(&plan, &crates, &sensors(), &code_of));
    // Each crate is one for a reason; the only one of a room has its room's.
    let has_none = |row: &&Row| row.forbidden.is_empty() && row.folder.contains('/');
    let is_crate = |row: &&Row| crates.values().any(|own| own.folder == row.folder);
    let idle: Vec<_> = plan.crates.iter().filter(has_none).filter(is_crate).collect();
    let idle: Vec<_> =
        idle.iter().map(|row| &row.folder).filter(|f| !f.starts_with("tests/")).collect();
    assert!(idle.is_empty(), "may know everything: {idle:?}");
}

#[test]
fn files_are_touched_in_few_places() {
    none(&rules::touching_files(&crates(), STILL_TOUCHING_FILES, &code_of));
}

#[test]
fn no_modules_name_each_other_in_a_circle_across_folders() {
    let (mut found, mut ties) = (Vec::new(), Vec::new());
    for own in crates().values() {
        let circles = own.modules().into_iter().flat_map(|modules| modules.circles());
        let across: Vec<_> = circles.filter(|circle| circle.spans_folders).collect();
        if !across.is_empty() {
            found.push(own.folder.clone());
        }
        if !STILL_IN_CIRCLES.contains(&&*own.folder) {
            let all = across.into_iter().flat_map(|circle| circle.ties);
            ties.extend(all.map(|tie| tie.replace(&*root().to_string_lossy(), "")));
        }
    }
    let wrong = rules::except("has files in a circle across folders", &found, STILL_IN_CIRCLES);
    none(&[wrong, ties].concat());
}

#[test]
fn kernels_and_formats_have_few_users() {
    let text = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let few = rows(&text, "| package | users |");
    let few: BTreeMap<_, _> = few.into_iter().map(|row| (row[0].clone(), words(&row[1]))).collect();
    assert!(few.contains_key("manifold-rust"), "{few:?}");
    none(&rules::wrong_users(&crates(), &few));
}

/// A small house: `high/a` uses `low/b`, which uses `low/c`.
fn small() -> (Plan, Crates) {
    let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
    let own = |folder: &str, uses: &[&str], tests_use: &[&str]| Crate {
        folder: folder.into(),
        uses: names(uses),
        tests_use: names(tests_use),
    };
    let row = |folder: &str, uses: &[&str], tests: &[&str]| Row {
        folder: folder.into(),
        uses: names(uses),
        tests_also_use: names(tests),
        ..Row::default()
    };
    let crates = [
        ("fabkit-a", own("high/a", &["fabkit-b"], &[])),
        ("fabkit-b", own("low/b", &["fabkit-c", "png"], &[])),
        ("fabkit-c", own("low/c", &[], &["fabkit-b"])),
        ("fabkit-tests", own("tests/end_to_end", &["fabkit-a"], &[])),
    ];
    let plan = Plan {
        rooms: ["high", "low"].map(|folder| row(folder, &[], &[])).into(),
        crates: vec![
            row("high/a", &["b"], &[]),
            row("low/b", &["c"], &[]),
            row("low/c", &[], &["b"]),
            Row { called: Some("tests".into()), ..row("tests/end_to_end", &["a"], &[]) },
        ],
    };
    (plan, crates.map(|(name, own)| (name.to_owned(), own)).into())
}

/// What a crate would be if its code were this.
fn said(code: &'static str) -> impl Fn(&Crate) -> Vec<Code> {
    move |own| {
        let tokens = tokens(code);
        let path = format!("{}/src/lib.rs", own.folder);
        vec![Code { path, paths: full_paths(&names(&tokens)), tokens }]
    }
}

#[test]
fn a_sound_house_breaks_no_rule() {
    let (plan, crates) = small();
    none(&rules::wrong_rows(&plan, &crates));
    none(&rules::arrows_up(&plan, &crates));
    none(&rules::forbidden(&plan, &crates, &[], &said("")));
    none(&rules::touching_files(
        &crates,
        &[],
        &said("#[cfg(test)] mod t { use std::fs; } // std::fs"),
    ));
}

#[test]
fn rows_that_say_something_else_are_told() {
    let (mut plan, crates) = small();
    plan.crates[0].uses.clear();
    plan.crates[2].tests_also_use.clear();
    plan.crates[3].called = None;
    plan.crates.remove(1);
    let wrong = rules::wrong_rows(&plan, &crates);
    for part in [
        "high/a uses {\"b\"}",
        "low/c tests also use {\"b\"}",
        "is called tests",
        "low/b stands in no README",
    ] {
        assert!(wrong.iter().any(|wrong| wrong.contains(part)), "{part}: {wrong:?}");
    }
    assert_eq!(wrong.len(), 4, "{wrong:?}");
}

#[test]
fn arrows_that_point_up_are_told() {
    let (mut plan, mut crates) = small();
    crates.get_mut("fabkit-c").unwrap().tests_use.insert("fabkit-a".into());
    crates.get_mut("fabkit-b").unwrap().uses.insert("fabkit-tests".into());
    let wrong = rules::arrows_up(&plan, &crates);
    assert_eq!(
        wrong,
        ["low/b uses tests, which lies above it", "low/c uses a, which lies above it"]
    );
    plan.rooms.pop();
    let wrong = rules::arrows_up(&plan, &crates);
    assert!(wrong.contains(&"low/c lies in no room".to_owned()), "{wrong:?}");
}

#[test]
fn what_may_not_be_known_is_told() {
    let forbid = |at: &str, forbidden: Forbidden, code: &'static str| {
        let (mut plan, crates) = small();
        let rows = plan.rooms.iter_mut().chain(&mut plan.crates);
        rows.into_iter().find(|row| row.folder == at).unwrap().forbidden.push(forbidden);
        rules::forbidden(&plan, &crates, &["rtac0".into()], &said(code))
    };
    let folder = |folder: &str| Forbidden::Folder(folder.into());
    let through = "high/a knows low/c/: high/a -> low/b -> low/c";
    assert_eq!(forbid("high/a", folder("low/c"), ""), [through]);
    assert_eq!(forbid("high", folder("low/c"), ""), [through]);
    assert_eq!(forbid("high/a", folder("low"), "").len(), 1);
    assert_eq!(forbid("low/c", folder("lo"), ""), ["low/c: lo/ is no room and no crate"]);
    let package = |package: &str| Forbidden::Package(package.into());
    assert_eq!(forbid("low/b", package("png"), ""), ["low/b uses png"]);
    assert_eq!(forbid("high/a", package("pgn"), ""), ["high/a: nobody uses a package pgn"]);
    none(&forbid("high/a", package("png"), ""));
    let word = |word: &str| Forbidden::Word(word.into());
    let code = "use std::{io::{self as x}, fmt}; fn f() { println!(\"{}\", x::stdout()) }";
    assert_eq!(forbid("low/c", word("std::io"), code), ["low/c/src/lib.rs names std::io"]);
    assert_eq!(
        forbid("low/c", word("std::io::stdout"), code),
        ["low/c/src/lib.rs names std::io::stdout"]
    );
    assert_eq!(forbid("low/c", word("println!"), code), ["low/c/src/lib.rs names println!"]);
    none(&forbid("low/c", word("std::io"), "// std::io\n#[cfg(test)] mod t { use std::io; }"));
    none(&forbid("low/c", word("std::io"), "const T: &str = \"std::io\"; use std::iota;"));
    let named = "const T: &str = \"rtac0\"; // rtac0";
    assert_eq!(
        forbid("low/c", Forbidden::SensorNames, named),
        ["low/c/src/lib.rs names the sensor rtac0"]
    );
    none(&forbid("low/c", Forbidden::SensorNames, "// rtac0"));
}

#[test]
fn files_that_are_touched_elsewhere_are_told_and_so_are_past_exceptions() {
    let (_, crates) = small();
    let code = said("use std::fs::File; fn f() { std::fs::read(x) }");
    let file = |folder: &str| format!("{folder}/src/lib.rs");
    let excepted = [file("low/b"), file("low/d")];
    let excepted: Vec<&str> = excepted.iter().map(String::as_str).collect();
    let wrong = rules::touching_files(&crates, &excepted, &code);
    let past = format!("{} is no exception any more: strike it out", file("low/d"));
    let names = |folder| format!("{} names std::fs", file(folder));
    assert_eq!(wrong, [names("high/a"), names("low/c"), past]);
}

#[test]
fn users_of_packages_that_others_wrap_are_told() {
    let (_, crates) = small();
    let few = |users: &str| BTreeMap::from([("png".to_owned(), words(users))]);
    none(&rules::wrong_users(&crates, &few("b")));
    assert_eq!(rules::wrong_users(&crates, &few("a, b")).len(), 1);
    assert_eq!(rules::wrong_users(&crates, &few("—")).len(), 1);
}

#[test]
fn only_the_command_speaks_of_its_options() {
    let names_one = |token: &Token| {
        let Token::Text(text) = token else { return false };
        text.split("--").skip(1).any(|rest| rest.starts_with(|c: char| c.is_ascii_lowercase()))
    };
    // Those name the options of other programs.
    let others = ["src/verifier.rs", "src/slicing.rs"];
    // A command line as it is, and the options that are declared once for both doors.
    let is_shared = |name: &str| ["run", "Named"].contains(&name) || name.ends_with("Options");
    for package in ["fabkit-application", "fabkit-python"] {
        let files = code_of(&crates()[package]);
        assert!(files.len() > 10, "{package} has its sources elsewhere");
        for Code { path, paths, tokens } in files {
            if !others.iter().any(|other| path.ends_with(other)) {
                let text = tokens.iter().find(|token| names_one(token));
                assert!(text.is_none(), "{path}: {text:?}");
            }
            let of_command = |named: &&Vec<String>| {
                named[0] == "fabkit" && named.get(1).is_some_and(|name| !is_shared(name))
            };
            let named = paths.iter().find(of_command);
            assert!(named.is_none(), "{path}: {named:?}");
        }
    }
}
