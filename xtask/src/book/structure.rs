//! Structure of the book: every page is in `SUMMARY.md`, and every link has a target.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Component, Path, PathBuf};

use super::markdown::{self, Page};

/// File name of the table of contents.
pub const SUMMARY: &str = "SUMMARY.md";

/// Reads all pages below a folder, by their relative paths.
///
/// # Errors
/// Files that cannot be read or parsed.
pub fn pages(docs: &Path) -> Result<BTreeMap<PathBuf, Page>, String> {
    let mut pages = BTreeMap::new();
    for file in files(docs)? {
        if file.extension().is_some_and(|extension| extension == "md") {
            let text = fs::read_to_string(docs.join(&file))
                .map_err(|e| format!("{}: {e}", file.display()))?;
            let page =
                markdown::read(&text).map_err(|e| format!("docs/{}: {e}", file.display()))?;
            pages.insert(file, page);
        }
    }
    Ok(pages)
}

/// Front pages of the repository, which run like the book's but are not part of it. Paths are from the root.
const FRONT_PAGES: [&str; 1] = ["README.md"];

/// Reads the front pages.
///
/// # Errors
/// A page that cannot be read.
pub fn front_pages(root: &Path) -> Result<BTreeMap<PathBuf, Page>, String> {
    let read = |name: &str| {
        let text = fs::read_to_string(root.join(name)).map_err(|e| format!("{name}: {e}"))?;
        let page = markdown::read(&text).map_err(|e| format!("{name}: {e}"))?;
        Ok((PathBuf::from(name), page))
    };
    FRONT_PAGES.into_iter().map(read).collect()
}

/// Finds links of front pages to files that do not exist.
pub fn dead_links(root: &Path, pages: &BTreeMap<PathBuf, Page>) -> Vec<String> {
    let mut faults = Vec::new();
    for (path, page) in pages {
        let folder = root.join(path.parent().unwrap_or(Path::new("")));
        for link in &page.links {
            let file = link.target.split('#').next().unwrap_or_default();
            let is_elsewhere =
                ["https://", "http://"].iter().any(|scheme| file.starts_with(scheme));
            if !(is_elsewhere || file.is_empty() || folder.join(file).exists()) {
                faults.push(format!("{}:{}: there is no {file}", path.display(), link.line));
            }
        }
    }
    faults
}

/// Finds all faults of contents and links.
///
/// # Errors
/// A folder that cannot be read.
pub fn faults(docs: &Path, pages: &BTreeMap<PathBuf, Page>) -> Result<Vec<String>, String> {
    let there: BTreeSet<PathBuf> = files(docs)?.into_iter().collect();
    let mut faults = Vec::new();
    for (path, page) in pages {
        for link in &page.links {
            if let Some(fault) = fault(path, &link.target, pages, &there) {
                faults.push(format!("docs/{}:{}: {fault}", path.display(), link.line));
            }
        }
    }
    let listed: BTreeSet<PathBuf> = pages
        .get(Path::new(SUMMARY))
        .map(|summary| summary.links.iter().map(|link| PathBuf::from(&link.target)).collect())
        .unwrap_or_default();
    // `README.md` describes the folder, and is not part of the book.
    let is_apart = |path: &Path| [SUMMARY, "README.md"].map(Path::new).contains(&path);
    let missing = pages.keys().filter(|path| !is_apart(path) && !listed.contains(*path));
    faults.extend(missing.map(|path| format!("docs/{}: not in {SUMMARY}", path.display())));
    Ok(faults)
}

fn fault(
    from: &Path,
    target: &str,
    pages: &BTreeMap<PathBuf, Page>,
    there: &BTreeSet<PathBuf>,
) -> Option<String> {
    if ["https://", "http://", "mailto:"].iter().any(|scheme| target.starts_with(scheme)) {
        return None;
    }
    let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
    let path = match file {
        "" => Some(from.to_owned()),
        file => resolve_inside(&from.parent().unwrap_or(Path::new("")).join(file)),
    };
    let Some(path) = path else {
        return Some(format!("`{target}` leaves docs/, which the book's reader does not have"));
    };
    if !there.contains(&path) {
        return Some(format!("`{target}`: there is no {}", path.display()));
    }
    let known = |page: &Page| anchor.is_empty() || page.anchors.iter().any(|a| a == anchor);
    match pages.get(&path) {
        Some(page) if !known(page) => {
            Some(format!("`{target}`: {} has no heading `#{anchor}`", path.display()))
        }
        _ => None,
    }
}

/// Resolves `.` and `..` in a relative path; `None` if it leads outside.
fn resolve_inside(path: &Path) -> Option<PathBuf> {
    let mut inside = PathBuf::new();
    for component in path.components() {
        match component {
            Component::Normal(name) => inside.push(name),
            Component::CurDir => {}
            // `pop` is false at the top: the path then leads outside.
            Component::ParentDir if inside.pop() => {}
            _ => return None,
        }
    }
    Some(inside)
}

/// Lists all files below a folder, by their relative paths.
fn files(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let failed = |e| format!("{}: {e}", folder.display());
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let name = PathBuf::from(entry.file_name());
        if entry.path().is_dir() {
            found.extend(files(&entry.path())?.into_iter().map(|file| name.join(file)));
        } else {
            found.push(name);
        }
    }
    found.sort();
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_book_hangs_together() {
        let docs = crate::run::root().join("docs");
        let pages = pages(&docs).unwrap();
        assert!(pages.contains_key(Path::new(SUMMARY)));
        assert_eq!(faults(&docs, &pages).unwrap(), Vec::<String>::new());
    }

    #[test]
    fn broken_links_and_forgotten_pages_are_named() {
        let page = |text: &str| markdown::read(text).unwrap();
        let pages: BTreeMap<PathBuf, Page> = [
            ("SUMMARY.md", page("[A](a.md)")),
            ("a.md", page("[B](b/b.md#head) [C](c.md) [D](b/b.md#tail) [E](../e.md)")),
            ("b/b.md", page("# Head\n[A](../a.md) [net](https://example.org)")),
        ]
        .into_iter()
        .map(|(path, page)| (PathBuf::from(path), page))
        .collect();
        let there = pages.keys().cloned().collect();
        let of = |from: &str| -> Vec<Option<String>> {
            let links = &pages[Path::new(from)].links;
            links.iter().map(|l| fault(Path::new(from), &l.target, &pages, &there)).collect()
        };
        assert_eq!(of("b/b.md"), [None, None]);
        let [None, Some(c), Some(d), Some(e)] = &of("a.md")[..] else { panic!("{:?}", of("a.md")) };
        assert!(
            c.contains("there is no c.md") && d.contains("#tail") && e.contains("leaves docs/")
        );
    }
}
