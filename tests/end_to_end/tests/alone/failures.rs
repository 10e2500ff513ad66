//! Disks that fill up, folders that cannot be written, interrupts: whatever happens, files that
//! stood there before are untouched, and nothing half-written stays.
#![cfg(unix)]

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use fabkit_tests::{Run, binary, command, fabkit, read_folder};

/// A folder with an earlier export of one small part, and its content.
fn earlier_export(root: &Path) -> BTreeMap<String, Vec<u8>> {
    fabkit(root, &["export", "rtac0", "--part=collar", "-o", "out"]).ok();
    let before = read_folder(&root.join("out"));
    assert_eq!(before.len(), 3, "{:?}", before.keys());
    before
}

fn assert_says(run: &Run, texts: &[&str]) {
    for text in texts {
        assert!(run.stderr.contains(text), "no `{text}` in:\n{}", run.stderr);
    }
}

/// The limit lets small files through and stops a larger one in the middle. The shell ignores the
/// signal that comes with it, so that the write fails as on a full disk.
#[test]
fn a_write_that_fails_halfway_leaves_everything_as_it_was() {
    let root = tempfile::tempdir().unwrap();
    let before = earlier_export(root.path());
    let export = |folder: &str| -> Run {
        Command::new("sh")
            .args(["-c", r#"trap "" XFSZ; ulimit -f 200; exec "$0" "$@""#])
            .arg(binary())
            .args(["export", "rtac0", "-o", folder])
            .current_dir(root.path())
            .output()
            .unwrap()
            .into()
    };
    let run = export("out");
    assert_eq!(run.code, Some(4), "{run:?}");
    assert_says(&run, &["cannot write out/", "File too large", "= help: ", "ulimit"]);
    assert_eq!(read_folder(&root.path().join("out")), before);

    assert_eq!(export("fresh/deep").code, Some(4));
    assert!(!root.path().join("fresh").exists());
}

/// A real full disk: a file system of 1 MB in a name space of its own. Where the system grants none
/// to this user, the test above is what remains, and the output says so.
#[test]
fn a_full_disk_leaves_everything_as_it_was() {
    let root = tempfile::tempdir().unwrap();
    let run_in_namespace = |script: &str| {
        Command::new("unshare")
            .args(["--user", "--map-root-user", "--mount", "sh", "-c", script])
            .arg(binary())
            .current_dir(root.path())
            .output()
    };
    fs::create_dir(root.path().join("disk")).unwrap();
    let mount = "mount -t tmpfs -o size=1m none disk";
    if !run_in_namespace(mount).is_ok_and(|output| output.status.success()) {
        println!("skipped: no name space to mount a small file system in");
        return;
    }
    let script = format!(
        r#"{mount} && "$0" export rtac0 --part=collar -o disk/out --quiet
           sum() {{ cd disk/out && ls -A && cat * | cksum && cd ../..; }}
           sum > before
           "$0" export rtac0 -o disk/out; echo "exit $?"
           sum > after"#
    );
    let run: Run = run_in_namespace(&script).unwrap().into();
    assert_eq!(run.stdout, "exit 4\n", "{run:?}");
    assert_says(&run, &["cannot write disk/out/", "No space left", "= help: the disk is full"]);
    let read = |name: &str| fs::read_to_string(root.path().join(name)).unwrap();
    assert!(read("before").starts_with("collar.3mf\ncollar.stl\nmanifest.json\n"));
    assert_eq!(read("before"), read("after"));
}

#[test]
fn a_folder_that_may_not_be_written_is_named() {
    let root = tempfile::tempdir().unwrap();
    let before = earlier_export(root.path());
    let out = root.path().join("out");
    fs::set_permissions(&out, fs::Permissions::from_mode(0o555)).unwrap();
    let run = unprivileged(root.path(), &["export", "rtac0", "-o", "out"]);
    assert_eq!(run.code, Some(4), "{run:?}");
    assert_says(&run, &["cannot write into out: ", "Permission denied", "may write to with -o"]);
    assert_eq!(read_folder(&out), before);
    fs::set_permissions(&out, fs::Permissions::from_mode(0o755)).unwrap();
}

/// Permissions do not bind root: as root, the command runs as nobody, from a copy that nobody may
/// reach.
fn unprivileged(root: &Path, arguments: &[&str]) -> Run {
    let probe = root.join("probe");
    fs::create_dir(&probe).unwrap();
    fs::set_permissions(&probe, fs::Permissions::from_mode(0o555)).unwrap();
    let bound = fs::write(probe.join("x"), "").is_err();
    if bound {
        return fabkit(root, arguments);
    }
    fs::set_permissions(root, fs::Permissions::from_mode(0o755)).unwrap();
    // Copied by a process of its own: a binary that this one has open for writing, even in a child
    // that another test is just starting, cannot be run.
    let script = r#"cp "$0" fabkit && chmod 755 fabkit &&
                    exec setpriv --reuid=65534 --regid=65534 --clear-groups ./fabkit "$@""#;
    Command::new("sh")
        .args(["-c", script])
        .arg(binary())
        .args(arguments)
        .current_dir(root)
        .output()
        .unwrap()
        .into()
}

#[test]
fn files_and_folders_in_the_way_are_named() {
    let root = tempfile::tempdir().unwrap();
    let before = earlier_export(root.path());

    // A file where the folder should be.
    let run = fabkit(root.path(), &["export", "rtac0", "-o", "out/collar.stl"]);
    assert_eq!(run.code, Some(4), "{run:?}");
    assert_says(&run, &["out/collar.stl", "= help: "]);
    let run = fabkit(root.path(), &["export", "rtac0", "-o", "out/collar.stl/below"]);
    assert_eq!(run.code, Some(4), "{run:?}");
    assert_says(&run, &["out/collar.stl/below", "= help: "]);

    // A folder where a file should be.
    fs::create_dir(root.path().join("out/shell.stl")).unwrap();
    let run = fabkit(root.path(), &["export", "rtac0", "-o", "out"]);
    assert_eq!(run.code, Some(4), "{run:?}");
    assert_says(&run, &["out/shell.stl: it is a folder, not a file", "= help: "]);
    fs::remove_dir(root.path().join("out/shell.stl")).unwrap();

    assert_eq!(read_folder(&root.path().join("out")), before);
}

fn interrupt(process: u32) {
    let status = Command::new("kill").args(["-INT", &process.to_string()]).status().unwrap();
    assert!(status.success());
}

#[test]
fn an_interrupt_while_computing_ends_at_once_without_a_trace() {
    let root = tempfile::tempdir().unwrap();
    let before = earlier_export(root.path());
    let child = command(root.path())
        .args(["export", "rtac0", "-o", "out", "--tolerance=0.5um", "--format=stl,3mf,tree,png"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Long enough to have begun, much shorter than the whole.
    sleep(Duration::from_millis(300));
    let start = Instant::now();
    interrupt(child.id());
    let run: Run = child.wait_with_output().unwrap().into();
    assert_eq!(run.code, Some(130), "{run:?}");
    assert_says(&run, &["interrupted"]);
    assert!(start.elapsed() < Duration::from_secs(2), "{:?}", start.elapsed());
    assert_eq!(read_folder(&root.path().join("out")), before);
}

/// A slicer has a folder of temporary files, and is a process of its own.
#[test]
fn an_interrupt_while_slicing_ends_the_slicer_and_leaves_no_folder() {
    let root = tempfile::tempdir().unwrap();
    let place = |name: &str| root.path().join(name);
    // As slow as a slicer may be; it writes down which process it is.
    let slicer = "#!/bin/sh\necho $$ >> \"$SLICERS\"\nexec sleep 60\n";
    fs::write(place("slicer"), slicer).unwrap();
    fs::set_permissions(place("slicer"), fs::Permissions::from_mode(0o755)).unwrap();
    fs::create_dir(place("tmp")).unwrap();
    let child = command(root.path())
        .args(["guide", "rtac0", "--slice", "--quiet", "-o", "out"])
        .env("FABKIT_SLICER", place("slicer"))
        .env("SLICERS", place("slicers"))
        .env("TMPDIR", place("tmp"))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while !place("slicers").exists() && begun.elapsed() < Duration::from_secs(60) {
        sleep(Duration::from_millis(5));
    }
    let start = Instant::now();
    interrupt(child.id());
    let run: Run = child.wait_with_output().unwrap().into();
    assert_eq!(run.code, Some(130), "{run:?}");
    assert_says(&run, &["interrupted"]);
    assert!(start.elapsed() < Duration::from_secs(5), "{:?}", start.elapsed());
    assert_eq!(fs::read_dir(place("tmp")).unwrap().count(), 0);
    assert!(!place("out").exists());
    let slicers = fs::read_to_string(place("slicers")).unwrap();
    assert!(!slicers.is_empty());
    for process in slicers.lines() {
        let alive = Command::new("kill").args(["-0", process]).output().unwrap().status.success();
        assert!(!alive, "slicer {process} goes on");
    }
}

/// A folder to publish is fixtures, boards and a guide besides: minutes in which somebody loses patience.
#[test]
fn an_interrupt_while_all_is_exported_leaves_nothing() {
    let root = tempfile::tempdir().unwrap();
    for wait_ms in [300, 2000] {
        let child = command(root.path())
            .args(["export", "rtac0", "--all", "--tolerance=5um", "--quiet", "-o", "out"])
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        sleep(Duration::from_millis(wait_ms));
        interrupt(child.id());
        let run: Run = child.wait_with_output().unwrap().into();
        assert_eq!(run.code, Some(130), "{run:?}");
        assert_says(&run, &["interrupted"]);
        assert!(read_folder(root.path()).is_empty() && !root.path().join("out").exists());
    }
}

/// Interrupts as soon as the first temporary file is seen. The export may win that race; it must
/// then be complete. How many attempts were in time is printed: a disk without latency lets none.
#[test]
fn an_interrupt_while_writing_leaves_all_or_nothing() {
    let root = tempfile::tempdir().unwrap();
    let before = earlier_export(root.path());
    let out = root.path().join("out");
    const ATTEMPTS: usize = 8;
    let mut stopped = 0;
    for _ in 0..ATTEMPTS {
        let child = command(root.path())
            .args(["export", "rtac0", "-o", "out", "--quiet"])
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let deadline = Instant::now() + Duration::from_secs(60);
        let has_temporary = || {
            let names = fs::read_dir(&out).unwrap().map(|e| e.unwrap().file_name());
            names.into_iter().any(|name| name.to_string_lossy().starts_with(".fabkit-"))
        };
        while !has_temporary() && Instant::now() < deadline {
            std::hint::spin_loop();
        }
        interrupt(child.id());
        let run: Run = child.wait_with_output().unwrap().into();
        let after = read_folder(&out);
        match run.code {
            Some(130) => {
                assert_eq!(after, before);
                stopped += 1;
            }
            _ => {
                assert_eq!(run.code, Some(0), "{run:?}");
                let manifest: serde_json::Value =
                    serde_json::from_slice(&after["manifest.json"]).unwrap();
                assert_eq!(manifest["files"].as_array().unwrap().len() + 1, after.len());
                fs::remove_dir_all(&out).unwrap();
                assert_eq!(earlier_export(root.path()), before);
            }
        }
    }
    println!("{stopped} of {ATTEMPTS} attempts were in time");
}
