//! No name steers the terminal, whatever command prints it: names come from files of other people.

use std::fs;
use std::path::Path;

use fabkit_tests::{command, fabkit};

/// Colours, a title of the window, a line written over, C1 controls, deletion, and overrides of direction.
const HOSTILE: &str = "a\u{1b}[31m\u{1b}]0;x\u{7}\r\u{9b}2J\u{7f}\u{202e}\u{2066}\u{200f}z";

/// Characters that may not reach a terminal.
fn is_steering(c: char) -> bool {
    let is_bidi = matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    is_bidi || c.is_control() && c != '\n' && c != '\t'
}

/// Names of all commands, and of those of `calibrate`.
fn commands(root: &Path) -> Vec<Vec<String>> {
    let listed = |words: &[&str]| -> Vec<String> {
        let help = fabkit(root, &[words, &["--help"]].concat()).ok().stdout;
        let lines = help.lines().skip_while(|line| *line != "Commands:").skip(1);
        let names = lines.take_while(|line| line.starts_with("  "));
        let names = names.filter_map(|line| line.strip_prefix("  ")?.split(' ').next());
        names.filter(|name| !name.is_empty() && *name != "help").map(str::to_owned).collect()
    };
    let all = listed(&[]).into_iter().filter(|name| name != "calibrate").map(|name| vec![name]);
    let below = listed(&["calibrate"]).into_iter().map(|name| vec!["calibrate".to_owned(), name]);
    all.chain(below).collect()
}

fn assert_harmless(root: &Path, words: &[&str]) {
    let mut command = command(root);
    // Whatever Python is installed here, no bench is run.
    let output = command.args(words).env("FABKIT_PYTHON", "/nowhere/python").output().unwrap();
    for bytes in [&output.stdout, &output.stderr] {
        let text = String::from_utf8_lossy(bytes);
        let found: Vec<char> = text.chars().filter(|c| is_steering(*c)).collect();
        assert!(found.is_empty(), "{words:?}: {found:?} in {text}");
    }
}

#[cfg(unix)]
#[test]
fn no_command_prints_characters_that_steer_the_terminal() {
    let root = tempfile::tempdir().unwrap();
    let commands = commands(root.path());
    assert!(commands.len() > 20, "{commands:?}");
    // A design that is there and wrong, one that is not there, a folder, and an image that is none.
    let there = format!("{HOSTILE}.yaml");
    let yaml = format!(
        "format: 1\nextends: rtac0\nname: mine\ntitle: \"{}\"\nsurface: {{radius: 1 m}}\n",
        "\u{202e}x"
    );
    fs::write(root.path().join(&there), yaml).unwrap();
    // Not empty, so that nobody begins a data set there.
    fs::create_dir(root.path().join(HOSTILE)).unwrap();
    fs::write(root.path().join(HOSTILE).join("kept"), "").unwrap();
    let png = format!("{HOSTILE}.png");
    fs::write(root.path().join(&png), "no image").unwrap();
    let missing = format!("{HOSTILE}/missing.yaml");
    let option = format!("--{HOSTILE}");
    let set = format!("{HOSTILE}=1");
    for name in &commands {
        let name: Vec<&str> = name.iter().map(String::as_str).collect();
        let more: [&[&str]; 8] = [
            &[&there],
            &[&missing],
            &[&option],
            &["rtac0", "--set", &set],
            &["9dtact/coupon", "-o", HOSTILE],
            &["-o", HOSTILE],
            &["rtac0", "--reference", &png, &png, "-o", HOSTILE],
            &["rtac0", "--json", "--set", &set],
        ];
        // Whether the command knows such arguments does not matter: what it answers does.
        for more in more {
            assert_harmless(root.path(), &[&name[..], more].concat());
        }
    }
}

/// What a text shows that is no error: reports and results.
#[test]
fn titles_and_notes_of_files_do_not_steer_the_terminal() {
    let root = tempfile::tempdir().unwrap();
    let yaml = "format: 1\nextends: rtac0\nname: mine\ntitle: \"x\u{202e}y\"\nreference: \"a\u{2066}b\"\n\
                leds: {model: {value: \"n\u{200f}m\", note: \"o\u{202d}p\"}}\n";
    fs::write(root.path().join("mine.yaml"), yaml).unwrap();
    for words in [
        &["show", "mine.yaml"][..],
        &["show", "mine.yaml", "--json"],
        &["check", "mine.yaml"],
        &["diff", "rtac0", "mine.yaml"],
        &["export", "mine.yaml", "--part", "collar", "-o", "out"],
        &["verify", "out"],
    ] {
        assert_harmless(root.path(), words);
    }
    // Programs read the same as before.
    let json = fabkit(root.path(), &["show", "mine.yaml", "--json"]).ok().json();
    assert!(json.to_string().contains("x\u{202e}y"), "{json}");
}
