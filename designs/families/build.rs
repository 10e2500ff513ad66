//! Lists the YAML files of folders, so that a new sensor, camera or article is a file and nothing else.

use std::fmt::Write;
use std::path::PathBuf;
use std::{env, fs};

/// Each becomes `FOLDER.rs`: an array of names and texts, by name.
const FOLDERS: [&str; 3] = ["cameras", "catalogue", "sensors"];

fn main() {
    let here = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("Cargo says it"));
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("Cargo says it"));
    for folder in FOLDERS {
        println!("cargo::rerun-if-changed={folder}");
        let files = fs::read_dir(here.join(folder)).expect("the folder is there");
        let mut files: Vec<PathBuf> = files.map(|file| file.expect("is read").path()).collect();
        files.retain(|file| file.extension().is_some_and(|extension| extension == "yaml"));
        files.sort_by_key(|file| file.file_stem().map(ToOwned::to_owned));
        let mut list = String::from("&[");
        for file in files {
            let name = file.file_stem().expect("has an extension");
            write!(list, "({name:?}, include_str!({file:?})),").expect("grows");
        }
        list.push(']');
        fs::write(out.join(folder).with_extension("rs"), list).expect("is written");
    }
}
