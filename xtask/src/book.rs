//! `cargo xtask book`: generates the reference from the command's output, and runs every block of the book.

mod command;
mod expected;
mod markdown;
mod pages;
mod structure;
mod sweep;
mod yaml;

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use std::time::Instant;

use crate::run::{built_path, check, exists, in_ci, root, skip, tool_path};
use pages::Runner;

/// First lines of generated pages.
const GENERATED: &str = "<!-- Made by `cargo xtask book`; do not edit. -->";

/// Folders of the Python packages, in the order of their reference.
const PACKAGES: [&str; 2] = ["fabkit/python/fabkit", "simulation/bench/fabkit_bench"];

/// Generated page.
pub struct Output {
    /// Path relative to `docs/`.
    path: PathBuf,
    text: String,
}

/// Writes the reference, checks contents and links, runs every block, and makes the HTML pages. With `only`, only pages
/// whose path contains that word run.
///
/// # Errors
/// Everything that differs from the book.
pub fn run(only: Option<&str>) -> Result<(), String> {
    let fabkit = crate::run::fabkit()?;
    let chosen = env::var_os("FABKIT_PYTHON").map(|python| Ok(python.into()));
    let python = match chosen.unwrap_or_else(crate::python::environment) {
        Ok(python) => Some(python),
        Err(why) => {
            skip("the book's commands and programs", &why)?;
            None
        }
    };
    reference(&fabkit, python.as_deref())?;
    let docs = root().join("docs");
    let pages = structure::pages(&docs)?;
    let mut faults = structure::faults(&docs, &pages)?;
    let front = structure::front_pages(root())?;
    faults.extend(structure::dead_links(root(), &front));
    if let Some(python) = python {
        let package = if is_importable(&python, "fabkit") {
            None
        } else {
            Some(crate::python_package::unpacked()?)
        };
        let runner = || Runner::new(&fabkit, &python, package.as_deref());
        let docs_pages = pages.iter().map(|(path, page)| (Path::new("docs").join(path), page));
        let chosen: Vec<_> = docs_pages
            .chain(front.iter().map(|(path, page)| (path.clone(), page)))
            .filter(|(path, _)| only.is_none_or(|word| path.to_string_lossy().contains(word)))
            .collect();
        let (runners, found) = run_pages([runner()?, runner()?], &chosen);
        faults.extend(found);
        let mut skipped: Vec<String> =
            runners.iter().flat_map(|runner| runner.skipped.iter().cloned()).collect();
        skipped.sort();
        for block in skipped {
            println!("xtask: NOT RUN {block}");
        }
        let ran: usize = runners.iter().map(|runner| runner.ran).sum();
        println!("xtask: ran {ran} commands and programs of the book");
    }
    if !faults.is_empty() {
        return Err(faults.join("\n"));
    }
    html(&docs)
}

/// Runs pages two at a time, each in its own folder. Faults are returned in the order of the pages.
fn run_pages(
    mut runners: [Runner; 2],
    pages: &[(PathBuf, &markdown::Page)],
) -> ([Runner; 2], Vec<String>) {
    let waiting = Mutex::new(pages.iter().enumerate());
    let faults = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for runner in &mut runners {
            let (waiting, faults) = (&waiting, &faults);
            scope.spawn(move || {
                loop {
                    // Taken in a separate statement: in the loop's head, the lock would be held while the page runs.
                    let next = waiting.lock().ok().and_then(|mut waiting| waiting.next());
                    let Some((place, (path, page))) = next else { return };
                    if let Err(fault) = run_page(runner, path, page)
                        && let Ok(mut faults) = faults.lock()
                    {
                        faults.push((place, fault));
                    }
                }
            });
        }
    });
    let mut faults = faults.into_inner().unwrap_or_default();
    faults.sort();
    (runners, faults.into_iter().map(|(_, fault)| fault).collect())
}

fn run_page(runner: &mut Runner, path: &Path, page: &markdown::Page) -> Result<(), String> {
    let folder = built_path("book-runs", "").join(path.with_extension(""));
    let failed = |e: std::io::Error| format!("{}: {e}", folder.display());
    if folder.exists() {
        fs::remove_dir_all(&folder).map_err(failed)?;
    }
    fs::create_dir_all(&folder).map_err(failed)?;
    let (before, start) = (runner.ran, Instant::now());
    runner.page(path, page, &folder)?;
    if runner.ran > before {
        println!("xtask: {} ({:.1} s)", path.display(), start.elapsed().as_secs_f64());
    }
    fs::remove_dir_all(&folder).map_err(failed)
}

/// Updates the generated pages; in continuous integration they must be up to date.
fn reference(fabkit: &Path, python: Option<&Path>) -> Result<(), String> {
    let schema = run_output(Command::new(fabkit).arg("schema"))?;
    let mut outputs = yaml::pages(&schema)?;
    outputs.push(sweep::page(&run_output(Command::new(fabkit).args(["schema", "--sweep"]))?)?);
    outputs.push(command::page(fabkit)?);
    if let Some(python) = python {
        outputs.push(python_page(python)?);
    }
    for Output { path, text } in outputs {
        let place = root().join("docs").join(&path);
        if fs::read_to_string(&place).is_ok_and(|have| have == text) {
            continue;
        }
        if in_ci() {
            let path = path.display();
            return Err(format!("docs/{path} is not up to date: run `cargo xtask book`"));
        }
        fs::write(&place, text).map_err(|e| format!("{}: {e}", place.display()))?;
        println!("xtask: wrote docs/{}", path.display());
    }
    Ok(())
}

fn python_page(python: &Path) -> Result<Output, String> {
    let script = root().join("xtask/book/python_reference.py");
    let packages = PACKAGES.map(|package| root().join(package));
    let text = run_output(Command::new(python).arg(script).args(packages))?;
    let text = format!("# Python\n\n{GENERATED}\n\n{text}");
    Ok(Output { path: PathBuf::from("reference/python.md"), text })
}

/// Updates the book's page on Python from the docstrings. It needs only an interpreter, so that an outdated page is
/// reported without running the whole book.
pub fn compare_python_page() -> Result<(), String> {
    let python = Path::new("python3");
    if Command::new(python).arg("--version").output().is_err() {
        return skip("the book's page on Python", "python3 is not here");
    }
    let Output { path, text } = python_page(python)?;
    let place = root().join("docs").join(path);
    if fs::read_to_string(&place).is_ok_and(|have| have == text) {
        return Ok(());
    }
    if in_ci() {
        return Err("docs/reference/python.md is not up to date: run `cargo xtask lint`".into());
    }
    fs::write(&place, text).map_err(|e| format!("{}: {e}", place.display()))?;
    println!("xtask: wrote docs/reference/python.md");
    Ok(())
}

/// Makes the book's HTML pages in `target/book`, if mdBook is installed. The Markdown pages are readable without it.
fn html(docs: &Path) -> Result<(), String> {
    let Some(mdbook) = ["mdbook".into(), tool_path("mdbook")].into_iter().find(|p| exists(p))
    else {
        return skip(
            "the book as HTML pages",
            "mdbook is not here; `cargo install --locked --root .tools mdbook` brings it",
        );
    };
    check(Command::new(mdbook).arg("build").arg(docs).arg("--dest-dir").arg(built_path("book", "")))
}

/// Returns Python code that imports a module, but not from the folder in which the interpreter starts.
fn import_code(module: &str) -> String {
    format!("import sys; del sys.path[0]; import {module}")
}

/// Returns whether an interpreter can import a module, independent of the current folder, which may have a subfolder of
/// that name.
fn is_importable(python: &Path, module: &str) -> bool {
    let mut import = Command::new(python);
    import.args(["-c", &import_code(module)]).current_dir(env::temp_dir());
    import.output().is_ok_and(|output| output.status.success())
}

/// Runs a program and returns its standard output.
fn run_output(command: &mut Command) -> Result<String, String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command.output().map_err(|e| format!("{name}: {e}"))?;
    if !output.status.success() {
        return Err(format!(
            "{name}: {}\n{}",
            output.status,
            String::from_utf8_lossy(&output.stderr)
        ));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}
