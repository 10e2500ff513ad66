//! The files of a crate, and which of them names what another one defines.
//!
//! A name is followed through `use` and `pub use` to the file that defines it: a module that only hands
//! names on is no way round. Methods, and names that macros make, have no path and are not seen.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use super::paths::{Import, Names, names};
use super::tokens::tokens;

/// A crate's modules by their paths from its root.
#[derive(Default)]
pub struct Modules {
    modules: BTreeMap<Vec<String>, Module>,
    files: Vec<(PathBuf, Names)>,
    macros: BTreeMap<String, usize>,
}

#[derive(Default)]
struct Module {
    file: usize,
    items: BTreeSet<String>,
    imports: Vec<Import>,
}

/// For each file the files that define what it names, with the names.
type Edges = BTreeMap<usize, BTreeMap<usize, BTreeSet<String>>>;

/// Longest way along `use` after `use` that is followed.
const LONGEST_WAY: usize = 16;

impl Modules {
    /// Reads a crate from its root file.
    pub fn read(root: &Path) -> Self {
        let mut found = Self::default();
        let folder = root.parent().expect("a crate's root lies in a folder");
        let read = &|path: &Path| fs::read_to_string(path).ok();
        found.add(root.to_owned(), folder, Vec::new(), read);
        found
    }

    /// The files that it has, tests left out.
    pub fn paths(&self) -> Vec<PathBuf> {
        self.files.iter().map(|(path, _)| path.clone()).collect()
    }

    fn add(
        &mut self,
        path: PathBuf,
        folder: &Path,
        module: Vec<String>,
        read: &dyn Fn(&Path) -> Option<String>,
    ) {
        let code = read(&path).unwrap_or_else(|| panic!("{} is no file", path.display()));
        let names = names(&tokens(&code));
        let file = self.files.len();
        let own = |inside: &[String]| [&module[..], inside].concat();
        self.modules.insert(module.clone(), Module { file, ..Module::default() });
        for inside in &names.inline {
            self.modules.insert(own(inside), Module { file, ..Module::default() });
        }
        for (inside, item) in &names.items {
            self.modules.get_mut(&own(inside)).expect("was found").items.insert(item.clone());
        }
        for import in &names.imports {
            let module = self.modules.get_mut(&own(&import.inside)).expect("was found");
            module.imports.push(import.clone());
        }
        self.macros.extend(names.macros.iter().map(|name| (name.clone(), file)));
        let children = names.files.clone();
        self.files.push((path, names));
        for inside in children {
            let stem = inside.iter().fold(folder.to_owned(), |stem, piece| stem.join(piece));
            let beside = stem.with_extension("rs");
            let path = if read(&beside).is_some() { beside } else { stem.join("mod.rs") };
            // A file that a `#[path]` names is another crate's or a test's.
            if read(&path).is_some() {
                self.add(path, &stem, own(&inside), read);
            }
        }
    }

    /// For each file the files that define what it names.
    fn edges(&self) -> Edges {
        let mut found = Edges::new();
        let roots = self.modules.iter().filter(|(path, own)| {
            path.is_empty() || self.modules[&path[..path.len() - 1]].file != own.file
        });
        for (module, Module { file, .. }) in roots {
            let names = &self.files[*file].1;
            let own = |inside: &[String]| [&module[..], inside].concat();
            let mut add = |inside: &[String], path: &[String]| {
                let target = self.definer(&own(inside), path, LONGEST_WAY);
                let Some(target) = target.filter(|target| target != file) else { return };
                let name = path.last().cloned().unwrap_or_default();
                found.entry(*file).or_default().entry(target).or_default().insert(name);
            };
            let used =
                names.imports.iter().filter(|import| import.name != "*" && !import.is_handed_on);
            used.for_each(|import| add(&import.inside, &import.path));
            names.mentions.iter().for_each(|(inside, path)| add(inside, path));
        }
        found
    }

    /// The file that defines what a path names, seen from a module; `None` for modules themselves, and for
    /// what is not the crate's.
    fn definer(&self, from: &[String], path: &[String], left: usize) -> Option<usize> {
        let left = left.checked_sub(1)?;
        let (first, rest) = path.split_first()?;
        let module = &self.modules[from];
        match first.as_str() {
            "crate" => self.within(&[], rest, left),
            "self" => self.within(from, rest, left),
            "super" => {
                let parent = &from[..from.len().saturating_sub(1)];
                self.definer(parent, &[&["self".to_owned()], rest].concat(), left)
            }
            _ if module.items.contains(first) => Some(module.file),
            _ => self.within(from, path, left),
        }
    }

    fn within(&self, module: &[String], path: &[String], left: usize) -> Option<usize> {
        let left = left.checked_sub(1)?;
        let (first, rest) = path.split_first()?;
        let own = &self.modules[module];
        if matches!(first.as_str(), "super" | "self") {
            return self.definer(module, path, left);
        }
        if own.items.contains(first) {
            return Some(own.file);
        }
        let child = [module, std::slice::from_ref(first)].concat();
        if self.modules.contains_key(&child) {
            return self.within(&child, rest, left);
        }
        let is_itself = |import: &&Import| import.path[..] == [first.clone()];
        let given = own.imports.iter().filter(|import| import.name == *first);
        if let Some(import) = given.clone().find(|import| !is_itself(import)) {
            return self.definer(module, &[&import.path, rest].concat(), left);
        }
        if given.count() == 0 {
            let all = own.imports.iter().filter(|import| import.name == "*");
            let mut through = all.map(|import| [&import.path, path].concat());
            if let Some(file) = through.find_map(|path| self.definer(module, &path, left)) {
                return Some(file);
            }
        }
        // What `#[macro_export]` puts at the root.
        self.macros.get(first).copied().filter(|_| module.is_empty() && rest.is_empty())
    }

    /// The folder in which a file is at home: a module's own file lives with its children.
    fn home(&self, file: usize) -> PathBuf {
        let path = &self.files[file].0;
        let own = path.with_extension("");
        let has_children = self.files.iter().any(|(other, _)| other.starts_with(&own));
        if has_children { own } else { path.parent().unwrap_or(path).to_owned() }
    }

    /// Groups of files that name each other in a loop: across folders, then inside one without its face.
    pub fn circles(&self) -> Vec<Circle> {
        let edges = self.edges();
        let without_faces = self.without_faces(&edges);
        let mut circles = self.circles_of(&edges);
        circles.retain(|circle| circle.spans_folders);
        let inside = self.circles_of(&without_faces).into_iter();
        circles.extend(inside.filter(|circle| !circle.spans_folders));
        circles
    }

    /// Edges without those from a file to the module in whose folder it lies: a face and its own rooms may know
    /// each other.
    fn without_faces(&self, edges: &Edges) -> Edges {
        let homes: Vec<PathBuf> = (0..self.files.len()).map(|file| self.home(file)).collect();
        let is_face = |file: usize| {
            let path = &self.files[file].0;
            let own =
                ["lib", "main", "mod"].iter().any(|stem| path.ends_with(format!("{stem}.rs")));
            own || path.with_extension("") == homes[file]
        };
        let is_kept = |from: usize, to: usize| !is_face(to) || homes[from] != homes[to];
        edges
            .iter()
            .map(|(from, to)| {
                let kept = to.iter().filter(|(to, _)| is_kept(*from, **to));
                (*from, kept.map(|(to, names)| (*to, names.clone())).collect())
            })
            .collect()
    }

    fn circles_of(&self, edges: &Edges) -> Vec<Circle> {
        let reached: Vec<BTreeSet<usize>> = (0..self.files.len())
            .map(|file| {
                let mut found = BTreeSet::new();
                let mut open = vec![file];
                while let Some(next) = open.pop() {
                    let further = edges.get(&next).into_iter().flat_map(BTreeMap::keys);
                    open.extend(further.copied().filter(|target| found.insert(*target)));
                }
                found
            })
            .collect();
        let mut circles = Vec::new();
        let mut seen: BTreeSet<usize> = BTreeSet::new();
        for file in 0..self.files.len() {
            if !reached[file].contains(&file) || seen.contains(&file) {
                continue;
            }
            let members: BTreeSet<usize> = reached[file]
                .iter()
                .copied()
                .filter(|other| reached[*other].contains(&file))
                .collect();
            seen.extend(&members);
            let homes: BTreeSet<PathBuf> = members.iter().map(|file| self.home(*file)).collect();
            let name = |file: usize| self.files[file].0.display().to_string();
            let inner = |from: usize| {
                let to = edges[&from].iter().filter(|(to, _)| members.contains(to));
                to.map(move |(to, names)| (from, *to, names))
            };
            let ties = members.iter().flat_map(|from| inner(*from)).map(|(from, to, names)| {
                let names: Vec<&str> = names.iter().map(String::as_str).collect();
                format!("{} -> {}: {}", name(from), name(to), names.join(", "))
            });
            circles.push(Circle { spans_folders: homes.len() > 1, ties: ties.collect() });
        }
        circles
    }
}

/// Files that name each other in a loop.
#[derive(Debug)]
pub struct Circle {
    /// Whether the files are at home in more than one folder.
    pub spans_folders: bool,
    /// `file -> file: names that the first takes from the second`.
    pub ties: Vec<String>,
}

#[cfg(test)]
fn circles(files: &[(&str, &str)]) -> Vec<Circle> {
    let read = |path: &Path| {
        let found = files.iter().find(|(name, _)| Path::new(name) == path);
        found.map(|(_, code)| (*code).to_owned())
    };
    let mut modules = Modules::default();
    modules.add("src/lib.rs".into(), Path::new("src"), Vec::new(), &read);
    modules.circles()
}

#[test]
fn a_circle_of_two_folders_is_found() {
    let found = circles(&[
        ("src/lib.rs", "mod a; mod b;"),
        ("src/a.rs", "mod inner; use crate::b::{self, B}; pub struct A(B);"),
        ("src/a/inner.rs", "fn f() { super::g() }"),
        ("src/b.rs", "pub struct B; fn h(a: crate::a::A) {}"),
    ]);
    let across: Vec<&Circle> = found.iter().filter(|circle| circle.spans_folders).collect();
    assert!(!across.is_empty(), "{found:?}");
    assert_eq!(across[0].ties, ["src/a.rs -> src/b.rs: B", "src/b.rs -> src/a.rs: A"]);
}

#[test]
fn a_name_handed_on_leads_to_who_defines_it() {
    let face = "mod a; mod b; pub use a::A; pub(crate) use b::*;";
    let found = circles(&[
        ("src/lib.rs", face),
        ("src/a.rs", "use crate::B; pub struct A(B);"),
        ("src/b.rs", "pub struct B; fn f(_: crate::A) {}"),
    ]);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(!found[0].spans_folders);
    // The crate's root hands names on and is no part of the circle.
    assert!(found[0].ties.iter().all(|tie| !tie.contains("lib.rs")), "{found:?}");
}

#[test]
fn a_module_and_its_own_children_may_know_each_other() {
    let found = circles(&[
        ("src/lib.rs", "mod a; mod c;"),
        ("src/a/mod.rs", "mod b; pub struct A; fn f() { b::g() }"),
        ("src/a/b.rs", "use super::A; pub fn g() {}"),
        ("src/c.rs", "use crate::a::A; #[cfg(test)] mod tests { use crate::c; }"),
    ]);
    assert!(found.is_empty(), "{found:?}");
}

#[test]
fn a_grandchild_that_its_ancestor_calls_closes_a_circle() {
    let found = circles(&[
        ("src/lib.rs", "mod a; pub struct Root; fn f() { a::g() }"),
        ("src/a/mod.rs", "mod b; pub fn g() { b::h() }"),
        ("src/a/b.rs", "pub fn h() { let _ = crate::Root; }"),
    ]);
    assert!(found.iter().any(|circle| circle.spans_folders), "{found:?}");
}
