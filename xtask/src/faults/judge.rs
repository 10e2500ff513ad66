//! Judgement of a folder after a fault.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Prefix of fabkit's own temporary files.
const HIDDEN: &str = ".fabkit-";
const CONTENTS: &str = "manifest.json";

/// All files below a folder, with their contents.
pub type Files = BTreeMap<String, Vec<u8>>;

/// Reads all files below a folder.
pub fn files(folder: &Path) -> Files {
    let mut found = Files::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(next) = open.pop() {
        for entry in fs::read_dir(&next).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                open.push(path);
            } else if let (Ok(name), Ok(bytes)) = (path.strip_prefix(folder), fs::read(&path)) {
                found.insert(name.display().to_string(), bytes);
            }
        }
    }
    found
}

fn is_hidden(name: &str) -> bool {
    name.rsplit('/').next().is_some_and(|name| name.starts_with(HIDDEN))
}

fn visible(files: &Files) -> Files {
    files.iter().filter(|(name, _)| !is_hidden(name)).map(|(n, b)| (n.clone(), b.clone())).collect()
}

/// Judges a run that ended by itself: exactly the old files or exactly the new ones.
pub fn check_complete(after: &Files, old: &Files, new: &Files) -> Result<(), String> {
    if after == old || after == new {
        return Ok(());
    }
    Err(format!("neither the old nor the new files: {}", difference(after, old, new)))
}

/// Judges a run that was killed: a mixture has no list of contents, each file is a complete old or new one, and every
/// old one still exists under some name.
pub fn check_recoverable(after: &Files, old: &Files, new: &Files) -> Result<(), String> {
    let seen = visible(after);
    if seen == *old || seen == *new {
        return Ok(());
    }
    if let Some(list) = seen.keys().find(|name| name.ends_with(CONTENTS)) {
        return Err(format!("{list} lies: {}", difference(&seen, old, new)));
    }
    for (name, bytes) in &seen {
        if old.get(name) != Some(bytes) && new.get(name) != Some(bytes) {
            return Err(format!("{name} is neither the old nor the new one"));
        }
    }
    for (name, bytes) in old {
        if !after.values().any(|kept| kept == bytes) {
            return Err(format!("the old {name} is lost"));
        }
    }
    Ok(())
}

/// Judges an undisturbed run: exactly the new files.
pub fn check_exact(after: &Files, new: &Files) -> Result<(), String> {
    if after == new {
        Ok(())
    } else {
        Err(format!("after the next run: {}", difference(after, new, new)))
    }
}

fn difference(after: &Files, old: &Files, new: &Files) -> String {
    let names = after.keys().chain(old.keys()).chain(new.keys());
    let mut words: Vec<String> = names
        .map(|name| {
            let here = after.get(name);
            let what = match here {
                None => "missing",
                Some(_) if here == new.get(name) && here == old.get(name) => "same",
                Some(_) if here == new.get(name) => "new",
                Some(_) if here == old.get(name) => "old",
                Some(_) => "other",
            };
            format!("{name} {what}")
        })
        .collect();
    words.sort();
    words.dedup();
    words.retain(|word| !word.ends_with(" same"));
    words.join(", ")
}
