//! Generator of Python signatures and docstrings from the `clap` options of a command. A test compares the package with
//! the generated modules, and updates them except in continuous integration.

use std::path::{Path, PathBuf};
use std::{env, fs};

use clap::{Arg, ArgAction, Args as _, Command, CommandFactory as _};

use super::{CaptureOptions, CastOptions, Cli, ContactOptions, DatasetOptions, PressOptions};

/// Generated Python module.
struct PythonModule {
    /// File name in the package's folder.
    file: &'static str,
    /// Command that has the options.
    command: &'static str,
    /// Template of the module. A comment with a word in capitals is replaced by lines for the options named after it,
    /// or for all options that are named nowhere. Descriptions of arguments in the template are kept.
    template: &'static str,
    options: fn(Command) -> Command,
    /// Options that come first in Python. The others follow in the order of their declaration, so that new ones come
    /// last.
    first: &'static str,
    /// Options that Python takes elsewhere, for example with the scene.
    elsewhere: &'static [&'static str],
    /// Pairs of a flag and an option: the flag is expressed in Python by `None` for the option.
    switches: &'static [(&'static str, &'static str)],
}

const MODULES: [PythonModule; 4] = [
    PythonModule {
        file: "_capture.py",
        command: "capture",
        template: include_str!("python/capture.py"),
        options: CaptureOptions::augment_args,
        first: "samples contact shear friction spacing light constants seed",
        elsewhere: &["unit"],
        switches: &[("no_noise", "seed")],
    },
    PythonModule {
        file: "_cast.py",
        command: "depth",
        template: include_str!("python/cast.py"),
        options: |of| CastOptions::augment_args(ContactOptions::augment_args(of)),
        first: "samples contact membrane shear friction spacing print_sigma",
        elsewhere: &[],
        switches: &[],
    },
    PythonModule {
        file: "_press.py",
        command: "press",
        template: include_str!("python/press.py"),
        options: PressOptions::augment_args,
        first: "contact",
        elsewhere: &[],
        switches: &[],
    },
    PythonModule {
        file: "_dataset.py",
        command: "dataset",
        template: include_str!("python/dataset.py"),
        options: |of| DatasetOptions::augment_args(ContactOptions::augment_args(of)),
        first: "presses captures images light constants contact membrane friction spacing seam_margin seed materialise",
        elsewhere: &["unit"],
        switches: &[],
    },
];

/// Largest line length of the package.
const MAX_LINE_LENGTH: usize = 100;

/// Option as a keyword argument.
struct Keyword {
    id: String,
    name: String,
    annotation: &'static str,
    default: String,
    /// Description in the docstring.
    text: String,
    /// Lines of the dictionary that is passed on.
    values: Vec<String>,
}

/// Returns the name of the value in the help text, or `flag` for an option without a value.
fn kind(arg: &Arg) -> &str {
    if matches!(arg.get_action(), ArgAction::SetTrue) {
        return "flag";
    }
    arg.get_value_names().and_then(<[_]>::first).map_or("", |name| name.as_str())
}

/// Returns the option's name in Python.
fn name(arg: &Arg) -> String {
    let id = arg.get_id();
    if kind(arg).starts_with("LENGTH") { format!("{id}_mm") } else { id.to_string() }
}

impl Keyword {
    fn new(arg: &Arg, switch: Option<&Arg>) -> Self {
        let id = arg.get_id().as_str();
        let default = arg.get_default_values().first().and_then(|text| text.to_str());
        let (kind, name) = (kind(arg), name(arg));
        let mm = |text: &str| {
            let mm: f64 = text.trim_end_matches("mm").parse().expect("a default in mm");
            format!("{mm:?}")
        };
        let none = || "None".to_owned();
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
            ("LEVEL" | "NAME", None) => ("str | None", none(), name.clone()),
            (file, None) if file.starts_with("FILE") || file.starts_with("DIR") => {
                let value = format!("None if {id} is None else os.fspath({id})");
                ("str | PathLike[str] | None", none(), value)
            }
            // A new kind of value fails the test until its Python type is decided here.
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
        Self { id: id.to_owned(), name, annotation, default, text, values }
    }

    /// Returns the lines for a word of the template; `None` for an unknown word.
    fn lines(&self, what: &str, indent: usize) -> Option<Vec<String>> {
        let Self { name, annotation, default, text, values, .. } = self;
        Some(match what {
            "ARGUMENTS" => vec![format!("{name}: {annotation} = {default},")],
            "PARAMETERS" => {
                let lines = wrap_text(text, MAX_LINE_LENGTH - indent - 4);
                [name.clone()].into_iter().chain(lines.map(|line| format!("    {line}"))).collect()
            }
            "VALUES" => values.clone(),
            "PASSED" => vec![format!("{name}={name},")],
            _ => return None,
        })
    }
}

/// Converts a help text to prose: sentences, with code in double backquotes.
fn help(arg: &Arg) -> String {
    let text = arg.get_help().expect("every option has help").to_string();
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ").replace('`', "``");
    match text.split_once(" [default: ") {
        Some((text, default)) => format!("{text}. Default: {}.", default.trim_end_matches(']')),
        None => format!("{text}."),
    }
}

/// Makes the first letter lower case, to append a sentence to another one.
fn uncapitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map(|first| first.to_lowercase().chain(letters).collect()).unwrap_or_default()
}

/// Generates the module.
fn generate_module(module: &PythonModule) -> String {
    let cli = Cli::command();
    let command = cli.find_subcommand(module.command).expect("a command");
    let keywords = list_keywords(module, command);
    let mut text = format!(
        "\"\"\"Made from the options of ``fabkit {}`` by ``cargo test -p fabkit``; do not edit.\"\"\"\n\n",
        module.command
    );
    for line in module.template.lines() {
        let indent = " ".repeat(line.len() - line.trim_start().len());
        let asked = line.trim().strip_prefix("# ");
        let filled =
            asked.and_then(|asked| fill_comment(module.template, asked, &keywords, &indent));
        for line in filled.unwrap_or_else(|| vec![line.trim().to_owned()]) {
            text += format!("{indent}{line}").trim_end();
            text.push('\n');
        }
    }
    text
}

/// Returns the lines that replace a template's comment; `None` for an ordinary comment.
fn fill_comment(
    template: &str,
    asked: &str,
    keywords: &[Keyword],
    indent: &str,
) -> Option<Vec<String>> {
    let (what, ids) = asked.split_once(' ').unwrap_or((asked, ""));
    if !what.chars().all(char::is_uppercase) {
        return None;
    }
    let is_among = |ids: &str, id: &str| ids.split_whitespace().any(|one| one == id);
    let others = template
        .lines()
        .filter_map(|line| line.trim().strip_prefix("# ")?.strip_prefix(what)?.strip_prefix(' '));
    let is_chosen = |k: &&Keyword| match ids {
        "" => !others.clone().any(|ids| is_among(ids, &k.id)),
        ids => is_among(ids, &k.id),
    };
    // Descriptions written in the template take precedence.
    let is_written =
        |k: &Keyword| what == "PARAMETERS" && template.lines().any(|line| line.trim() == k.name);
    let chosen = keywords.iter().filter(is_chosen).filter(|k| !is_written(k));
    let lines: Option<Vec<_>> = chosen.map(|k| k.lines(what, indent.len())).collect();
    lines.map(|lines| lines.concat())
}

/// Lists the options in Python's order.
fn list_keywords(module: &PythonModule, command: &Command) -> Vec<Keyword> {
    let find = |id: &str| command.get_arguments().find(|arg| arg.get_id() == id);
    let is_switch = |id: &str| module.switches.iter().any(|(switch, _)| *switch == id);
    let declared = (module.options)(Command::new("options"));
    let mut ids: Vec<&str> = declared.get_arguments().map(|arg| arg.get_id().as_str()).collect();
    ids.retain(|id| !module.elsewhere.contains(id) && !is_switch(id));
    let place = |id: &str| module.first.split(' ').position(|first| first == id);
    // The sort is stable: options that are not listed keep the order of their declaration.
    ids.sort_by_key(|id| place(id).unwrap_or(usize::MAX));
    let keyword = |id: &str| {
        let switch = module.switches.iter().find(|(_, option)| *option == id);
        let switch = switch.and_then(|(switch, _)| find(switch));
        let mut keyword = Keyword::new(find(id).expect("the command has its options"), switch);
        for arg in command.get_arguments() {
            let option = format!("--{}", arg.get_long().unwrap_or("help"));
            keyword.text = replace_option_name(&keyword.text, &option, &name(arg));
        }
        keyword
    };
    ids.into_iter().map(keyword).collect()
}

/// Replaces an option in a text by its name in Python.
fn replace_option_name(text: &str, option: &str, name: &str) -> String {
    let mut parts = text.split(option);
    let mut named = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        // The option may be the beginning of a longer one, which is kept.
        let is_whole = !part.starts_with(|c: char| c.is_alphanumeric() || c == '-');
        named += &if is_whole { format!("``{name}``") } else { option.to_owned() };
        named += part;
    }
    named
}

/// Wraps a text into lines of at most `width` characters.
fn wrap_text(text: &str, width: usize) -> impl Iterator<Item = String> {
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
        let (path, text) = (package().join(wanted.file), generate_module(wanted));
        if fs::read_to_string(&path).is_ok_and(|have| have == text) {
            continue;
        }
        assert!(!in_ci, "fabkit/python/fabkit/{} is not up to date", wanted.file);
        fs::write(&path, text).unwrap();
    }
}
