//! Python's side of options: signatures, docstrings and what is passed on, from what `clap` knows of each. A test holds
//! the package to it, and writes what is not up to date unless this is continuous integration.

use std::path::{Path, PathBuf};
use std::{env, fs};

use clap::{Arg, ArgAction, Args as _, Command, CommandFactory as _};

use super::{CaptureOptions, Cli};

/// A module of the package, and the options that it takes.
struct Module {
    /// In the package's folder.
    file: &'static str,
    /// The command whose options they are.
    command: &'static str,
    /// The module, with comments in capitals for what is filled in.
    template: &'static str,
    options: fn(Command) -> Command,
    /// Options that Python says in another place: with the scene, for example.
    elsewhere: &'static [&'static str],
    /// A flag, and the option that is `None` in Python where the command has the flag.
    switches: &'static [(&'static str, &'static str)],
}

const MODULES: [Module; 1] = [Module {
    file: "_capture.py",
    command: "capture",
    template: include_str!("python/capture.py"),
    options: CaptureOptions::augment_args,
    elsewhere: &["unit"],
    switches: &[("no_noise", "seed")],
}];

/// Widest line of the package.
const WIDEST: usize = 100;

/// An option as a keyword argument.
struct Keyword {
    name: String,
    annotation: &'static str,
    default: String,
    /// For `help()`.
    text: String,
    /// Lines of the dictionary that is passed on.
    values: Vec<String>,
}

impl Keyword {
    fn new(arg: &Arg, switch: Option<&Arg>) -> Self {
        let id = arg.get_id().as_str();
        let default = arg.get_default_values().first().and_then(|text| text.to_str());
        let kind = arg.get_value_names().and_then(<[_]>::first).map_or("", |name| name.as_str());
        let kind = if matches!(arg.get_action(), ArgAction::SetTrue) { "flag" } else { kind };
        let mm = |text: &str| {
            let mm: f64 = text.trim_end_matches("mm").parse().expect("a default in mm");
            format!("{mm:?}")
        };
        let none = || "None".to_owned();
        let name = if kind.starts_with("LENGTH") { format!("{id}_mm") } else { id.to_owned() };
        let (annotation, default, value) = match (kind, default) {
            ("flag", _) => ("bool", "False".to_owned(), name.clone()),
            ("N", Some(default)) if switch.is_some() => {
                ("int | None", default.to_owned(), format!("{default} if {id} is None else {id}"))
            }
            ("N", Some(default)) => ("int", default.to_owned(), name.clone()),
            ("N", None) => ("int | None", none(), name.clone()),
            ("NUMBER", None) => ("float | None", none(), name.clone()),
            ("LENGTH", Some(default)) => {
                ("float | str", mm(default), format!("_arrays.length_mm({name}, \"{name}\")"))
            }
            ("LENGTH", None) => (
                "float | str | None",
                none(),
                format!("_arrays.optional_length_mm({name}, \"{name}\")"),
            ),
            ("LENGTH,LENGTH", Some(default)) => {
                let both: Vec<String> = default.split(',').map(mm).collect();
                let value = format!("_arrays.lengths_mm({name}, \"{name}\")");
                ("tuple[float | str, float | str]", format!("({})", both.join(", ")), value)
            }
            ("LEVEL" | "NAME", Some(default)) => ("str", format!("{default:?}"), name.clone()),
            ("NAME", None) => ("str | None", none(), name.clone()),
            (file, None) if file.starts_with("FILE") => {
                let value = format!("None if {id} is None else os.fspath({id})");
                ("str | PathLike[str] | None", none(), value)
            }
            (other, _) => panic!("{id}: what is {other} in Python?"),
        };
        let mut values = vec![format!("\"{id}\": {value},")];
        let mut text = help(arg);
        let levels = arg.get_possible_values();
        if kind != "flag" && !levels.is_empty() {
            let levels = levels.iter().map(|level| {
                let about = level.get_help().map(ToString::to_string).unwrap_or_default();
                format!("``{:?}``: {}", level.get_name(), uncapitalised(&about))
            });
            text += &format!(" {}.", levels.collect::<Vec<_>>().join("; "));
        }
        if let Some(switch) = switch {
            values.push(format!("\"{}\": {id} is None,", switch.get_id()));
            text += &format!(" ``None``: {}", uncapitalised(&help(switch)));
        }
        Self { name, annotation, default, text, values }
    }
}

/// Help as prose: sentences, with code in double backquotes.
fn help(arg: &Arg) -> String {
    let text = arg.get_help().expect("every option has help").to_string();
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ").replace('`', "``");
    match text.split_once(" [default: ") {
        Some((text, default)) => format!("{text}. Default: {}.", default.trim_end_matches(']')),
        None => format!("{text}."),
    }
}

/// A sentence as the end of another one.
fn uncapitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map(|first| first.to_lowercase().chain(letters).collect()).unwrap_or_default()
}

/// The module as it should be.
fn module(module: &Module) -> String {
    let cli = Cli::command();
    let command = cli.find_subcommand(module.command).expect("a command");
    let find = |id: &str| command.get_arguments().find(|arg| arg.get_id() == id);
    let declared = (module.options)(Command::new("options"));
    let is_switch = |id: &str| module.switches.iter().any(|(switch, _)| *switch == id);
    let ids = declared.get_arguments().map(|arg| arg.get_id().as_str());
    let keywords: Vec<Keyword> = ids
        .filter(|id| !module.elsewhere.contains(id) && !is_switch(id))
        .map(|id| {
            let switch = module.switches.iter().find(|(_, option)| *option == id);
            let switch = switch.and_then(|(switch, _)| find(switch));
            Keyword::new(find(id).expect("the command has its options"), switch)
        })
        .collect();
    let mut text = format!(
        "\"\"\"Made from the options of ``fabkit {}`` by ``cargo test -p fabkit``; do not edit.\"\"\"\n\n",
        module.command
    );
    for line in module.template.lines() {
        let indent = " ".repeat(line.len() - line.trim_start().len());
        let lines: Vec<String> = match line.trim() {
            "# ARGUMENTS" => keywords
                .iter()
                .map(|k| format!("{}: {} = {},", k.name, k.annotation, k.default))
                .collect(),
            "# PARAMETERS" => keywords
                .iter()
                .flat_map(|k| {
                    let lines = wrapped(&k.text, WIDEST - indent.len() - 4);
                    [k.name.clone()].into_iter().chain(lines.map(|line| format!("    {line}")))
                })
                .collect(),
            "# VALUES" => keywords.iter().flat_map(|k| k.values.clone()).collect(),
            "" => vec![String::new()],
            line => vec![line.to_owned()],
        };
        for line in lines {
            let line = if line.is_empty() { line } else { format!("{indent}{line}") };
            text += &line;
            text.push('\n');
        }
    }
    text
}

/// Lines of at most so many characters.
fn wrapped(text: &str, width: usize) -> impl Iterator<Item = String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let line = lines.last_mut().expect("there is one");
        if line.is_empty() {
            line.push_str(word);
        } else if line.chars().count() + 1 + word.chars().count() <= width {
            *line += &format!(" {word}");
        } else {
            lines.push(word.to_owned());
        }
    }
    lines.into_iter()
}

fn package() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../python/fabkit")
}

#[test]
fn the_python_package_has_the_options_as_they_are_declared() {
    let in_ci = env::var_os("CI").is_some_and(|value| !value.is_empty() && value != "false");
    for wanted in &MODULES {
        let (path, text) = (package().join(wanted.file), module(wanted));
        if fs::read_to_string(&path).is_ok_and(|have| have == text) {
            continue;
        }
        assert!(!in_ci, "fabkit/python/fabkit/{} is not up to date", wanted.file);
        fs::write(&path, text).unwrap();
        eprintln!("wrote fabkit/python/fabkit/{}", wanted.file);
    }
}
