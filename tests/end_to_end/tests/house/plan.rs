//! What the READMEs say: which rooms there are, and what each crate uses and may not know.

use std::collections::BTreeSet;
use std::fs;

use super::crates::{root, short};

/// What stands in the folder of a room, or all that a room holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// The folder from the root, for example `geometry/solids`.
    pub folder: String,
    /// What its package is called without `fabkit-`, where that is not the folder's name.
    pub called: Option<String>,
    /// The crates that it uses, by their short names.
    pub uses: BTreeSet<String>,
    /// The crates that its tests use besides.
    pub tests_also_use: BTreeSet<String>,
    /// What it may not know.
    pub forbidden: Vec<Forbidden>,
}

/// Something that a crate may not know.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Forbidden {
    /// `physics/` or `calibration/solver/`: a room or a crate, neither itself nor through others.
    Folder(String),
    /// `std::io` or `println!`: a path or a macro that its code may not name, tests apart.
    Word(String),
    /// `png`: a package from outside, which it may not name as its own.
    Package(String),
    /// The words "sensors' names": no text in its code is one.
    SensorNames,
}

/// The rooms and their crates.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// The rooms in their order, and what none of their crates may know.
    pub rooms: Vec<Row>,
    /// Every folder that a room's README names.
    pub crates: Vec<Row>,
}

/// Reads ARCHITECTURE.md and the README of each room.
pub fn plan() -> Plan {
    let read = |path: &str| fs::read_to_string(root().join(path)).unwrap();
    let rooms = rooms(&read("ARCHITECTURE.md"));
    let crates = rooms
        .iter()
        .map(|room| (room, format!("{}/README.md", room.folder)))
        .filter(|(_, readme)| root().join(readme).is_file())
        .flat_map(|(room, readme)| crates(&room.folder, &read(&readme)))
        .collect();
    Plan { rooms, crates }
}

/// The cells of each row below a table's head.
///
/// # Panics
/// If no table has this head.
pub fn rows(text: &str, head: &str) -> Vec<Vec<String>> {
    let mut below = text.lines().skip_while(|line| *line != head).skip(2).peekable();
    assert!(below.peek().is_some(), "no table begins with {head}");
    let cells = |row: &str| -> Vec<String> {
        let inner = row.trim().trim_start_matches('|').trim_end_matches('|');
        inner.split('|').map(|cell| cell.trim().to_owned()).collect()
    };
    let found: Vec<_> =
        below.map_while(|line| line.starts_with('|').then(|| cells(line))).collect();
    let count = head.split('|').count() - 2;
    for row in &found {
        assert_eq!(row.len(), count, "the cells of {row:?} below {head}");
    }
    found
}

/// `a, b` to its words; a dash stands for none.
pub fn words(cell: &str) -> BTreeSet<String> {
    cell.split(", ").filter(|word| *word != "—" && !word.is_empty()).map(str::to_owned).collect()
}

fn rooms(text: &str) -> Vec<Row> {
    let rows = rows(text, "| room | holds | may not know |");
    let read = |cells: Vec<String>| Row {
        folder: ticked(&cells[0])[0].trim_end_matches('/').to_owned(),
        forbidden: forbidden(&cells[2]),
        ..Row::default()
    };
    rows.into_iter().map(read).collect()
}

fn crates(room: &str, text: &str) -> Vec<Row> {
    const HEAD: &str = "| folder | uses | tests also use | holds | may not know |";
    if !text.lines().any(|line| line.starts_with("| folder |")) {
        return Vec::new();
    }
    let read = |cells: Vec<String>| {
        let own = ticked(&cells[0])[0].trim_end_matches('/').to_owned();
        let called = cells[0].split_once('(').and_then(|(_, name)| name.strip_suffix(')'));
        Row {
            folder: if own == "src" { room.to_owned() } else { format!("{room}/{own}") },
            called: called.map(str::to_owned),
            uses: words(&cells[1]),
            tests_also_use: words(&cells[2]),
            forbidden: forbidden(&cells[4]),
        }
    };
    rows(text, HEAD).into_iter().map(read).collect()
}

/// What stands between backticks.
fn ticked(cell: &str) -> Vec<&str> {
    cell.split('`').skip(1).step_by(2).collect()
}

/// What stands between backticks is checked; the words around it are for people, but for one phrase.
fn forbidden(cell: &str) -> Vec<Forbidden> {
    let read = |word: &str| match word {
        _ if word.ends_with('/') => Forbidden::Folder(word.trim_end_matches('/').to_owned()),
        _ if word.contains("::") || word.ends_with('!') => Forbidden::Word(word.to_owned()),
        _ => Forbidden::Package(word.to_owned()),
    };
    let names = cell.contains("sensors' names").then_some(Forbidden::SensorNames);
    ticked(cell).into_iter().map(read).chain(names).collect()
}

impl Row {
    /// Its package's short name.
    pub fn name(&self) -> &str {
        let last = self.folder.rsplit('/').next().unwrap_or_default();
        short(self.called.as_deref().unwrap_or(last))
    }
}

#[test]
fn a_readmes_rows_are_read() {
    let text = "# room\n\n| folder | uses | tests also use | holds | may not know |\n|---|---|---|---|---|\n\
                | `a/` (first) | b, c | d | what it holds | sensors' names, `x/y/`, `std::io`, `print!`, `png` |\n\
                | `b/` | — | — | | |\n\nMore.\n";
    let [first, second] = &crates("room", text)[..] else { panic!("two rows") };
    assert_eq!((first.name(), &*first.folder), ("first", "room/a"));
    assert_eq!(first.uses, words("b, c"));
    assert_eq!(first.tests_also_use, words("d"));
    let word = |word: &str| Forbidden::Word(word.into());
    let folder = Forbidden::Folder("x/y".into());
    let package = Forbidden::Package("png".into());
    let all = [folder, word("std::io"), word("print!"), package, Forbidden::SensorNames];
    assert_eq!(first.forbidden, all);
    assert_eq!((second.name(), second.uses.len(), second.forbidden.len()), ("b", 0, 0));
}

#[test]
#[should_panic(expected = "the cells of")]
fn a_row_that_lacks_a_cell_is_refused() {
    crates(
        "room",
        "| folder | uses | tests also use | holds | may not know |\n|---|---|---|---|---|\n| `a/` | b |\n",
    );
}
