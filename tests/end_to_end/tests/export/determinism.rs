//! The same command gives the same bytes: twice, on any number of threads. In debug
//! and release too: `cargo xtask bytes --debug`.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use fabkit_tests::{binary, read_folder};

fn export(binary: &Path, extra: &[&str]) -> BTreeMap<String, Vec<u8>> {
    let root = tempfile::tempdir().unwrap();
    let status = Command::new(binary)
        .current_dir(root.path())
        .args(["export", "rtac0", "--quiet", "-o", "here"])
        .args(extra)
        .status()
        .unwrap();
    assert!(status.success(), "{status}");
    let files = read_folder(&root.path().join("here"));
    assert!(files.len() > 20, "{:?}", files.keys());
    files
}

fn assert_same(a: &BTreeMap<String, Vec<u8>>, b: &BTreeMap<String, Vec<u8>>) {
    assert!(a.keys().eq(b.keys()), "{:?} and {:?}", a.keys(), b.keys());
    for (name, bytes) in a {
        assert!(*bytes == b[name], "{name} differs");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let formats = "--format=stl,3mf,dxf,svg,tree,glb";
    let first = export(binary(), &[formats]);
    for threads in ["--threads=1", "--threads=2", "--threads=8"] {
        assert_same(&first, &export(binary(), &[formats, threads]));
    }
}

#[test]
fn any_number_of_threads_and_both_profiles_give_the_same_images() {
    let parts = ["--format=png", "--part=base", "--part=filling-gel"];
    let image = |binary: &Path, threads: &str| {
        let root = tempfile::tempdir().unwrap();
        let status = Command::new(binary)
            .current_dir(root.path())
            .args(["export", "rtac0", "--quiet", "-o", "here", threads])
            .args(parts)
            .status()
            .unwrap();
        assert!(status.success(), "{status}");
        read_folder(&root.path().join("here"))
    };
    let first = image(binary(), "--threads=1");
    assert!(first.contains_key("base.png"), "{:?}", first.keys());
    assert_same(&first, &image(binary(), "--threads=8"));
}
