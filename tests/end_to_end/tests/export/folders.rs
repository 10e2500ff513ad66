//! Folders belong to whoever names them: what is there and fabkit did not write is never replaced.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use fabkit_tests::{Run, fabkit};

const SMALL: [&str; 4] = ["--set", "camera.width_px=160", "--set", "camera.height_px=120"];

/// Each command that writes into a folder, with its arguments but `-o`, and with files that it writes there.
const WRITERS: &[(&str, &str, &[&str])] = &[
    ("export", "9dtact --part plate", &["plate.stl", "plate.3mf", "manifest.json"]),
    ("guide", "9dtact/coupon", &["index.html", "guide.json", "bom.csv", "parts.csv"]),
    ("man", "", &["fabkit.1", "fabkit-show.1"]),
    ("optics-pack", "rtac0 SMALL", &["optics.json"]),
    ("reconstruct", "rtac0 SMALL --reference ref.png ref.png", &["ref.npz"]),
    ("dataset", "rtac0 SMALL", &["dataset.json", "samples.csv"]),
    ("sweep", "plan.yaml", &["sweep.csv", "report.html"]),
];

/// Its files are written by Python, with the same function; see `simulation/bench/tests`.
const WRITTEN_BY_PYTHON: [&str; 1] = ["bench"];

const PLAN: &str =
    "format: 1\nsensor: rtac0\naxes:\n  camera.depth: [6.1 mm]\nmetrics: [coverage]\n";

fn run(folder: &Path, command: &str, arguments: &str, output: &str) -> Run {
    let mut words = vec![command];
    for word in arguments.split_whitespace() {
        if word == "SMALL" { words.extend(SMALL) } else { words.push(word) }
    }
    words.extend(["-o", output]);
    fabkit(folder, &words)
}

/// Names of the commands whose help says that `-o` is a folder.
fn folder_commands(root: &Path) -> BTreeSet<String> {
    let help = fabkit(root, &["--help"]).ok().stdout;
    let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    let names = listed.take_while(|line| line.starts_with("  "));
    let names = names.filter_map(|line| line.strip_prefix("  ")?.split(' ').next());
    let writes = |name: &&str| {
        !name.is_empty() && *name != "help" && {
            fabkit(root, &[*name, "--help"]).stdout.contains("-o, --output <DIR>")
        }
    };
    names.filter(writes).map(str::to_owned).collect()
}

#[test]
fn no_command_replaces_files_of_somebody_else() {
    let root = tempfile::tempdir().unwrap();
    let listed = WRITERS.iter().map(|(name, ..)| (*name).to_owned());
    let listed: BTreeSet<String> = listed.chain(WRITTEN_BY_PYTHON.map(str::to_owned)).collect();
    assert_eq!(folder_commands(root.path()), listed, "commands with -o DIR");
    let reference = [&["capture", "rtac0", "--reference", "-o", "ref.png"], &SMALL[..]].concat();
    fabkit(root.path(), &reference).ok();
    fs::write(root.path().join("plan.yaml"), PLAN).unwrap();
    for &(command, arguments, files) in WRITERS {
        for file in files {
            let folder = format!("{command}-{file}");
            let place = root.path().join(&folder).join(file);
            fs::create_dir(root.path().join(&folder)).unwrap();
            fs::write(&place, "mine").unwrap();
            let refused = run(root.path(), command, arguments, &folder);
            assert_eq!(refused.code, Some(2), "{command} over {file}: {refused:?}");
            assert!(refused.stderr.contains(&folder), "{refused:?}");
            assert_eq!(fs::read_to_string(&place).unwrap(), "mine", "{command}");
            assert_eq!(fs::read_dir(root.path().join(&folder)).unwrap().count(), 1, "{command}");
        }
    }
}

/// What fabkit wrote it replaces, as long as nobody changed it.
#[test]
fn a_command_replaces_its_own_files() {
    let root = tempfile::tempdir().unwrap();
    let guide = |target: &str| fabkit(root.path(), &["guide", target, "-o", "guide", "-q"]);
    guide("9dtact/coupon").ok();
    guide("digit-like/coupon").ok();
    let page = root.path().join("guide/index.html");
    fs::write(&page, fs::read_to_string(&page).unwrap() + "<!-- my notes -->").unwrap();
    let refused = guide("9dtact/coupon");
    assert_eq!(refused.code, Some(2), "{refused:?}");
    let says = "error: guide/index.html is there, and fabkit did not write it\n  \
                = help: move it away, or choose another folder with -o\n";
    assert_eq!(refused.stderr, says);
}

/// Folders may have any name that the system allows.
#[cfg(target_os = "linux")]
#[test]
fn what_is_written_under_any_name_is_read_again() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt as _;

    let root = tempfile::tempdir().unwrap();
    let name = OsStr::from_bytes(b"of \xff");
    let run = |words: &[&OsStr]| {
        let output = fabkit_tests::command(root.path()).args(words).output().unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let export = ["export", "9dtact", "--part", "plate", "-o"].map(OsStr::new);
    assert_eq!(run(&[&export[..], &[name]].concat()).0, Some(0));
    let (code, text) = run(&["verify".as_ref(), name]);
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("all as written"), "{text}");
    // A name that is no folder is refused, too.
    assert_eq!(run(&["verify".as_ref(), OsStr::from_bytes(b"no \xff")]).0, Some(4));
}
