//! Runs the blocks of a page as a reader would: top to bottom, in one fresh folder.
//!
//! | block | what happens |
//! |---|---|
//! | `console` | each `$ ` command runs in bash; where output is shown, it must be that |
//! | `python` | runs as one program |
//! | any with `file=NAME` | is written there instead |
//! | any with `from=PATH` | must stand in that file of the repository, line by line |
//! | `text output` | must be what the `python` block before it printed |
//!
//! `fails=N` expects that exit code; `needs=MODULE` skips a block if Python lacks the module.

use std::collections::BTreeMap;
use std::env;
use std::ffi::OsString;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::expected;
use super::markdown::{Block, Page};
use crate::run::{in_ci, root};

/// Languages of blocks that look runnable but are not run.
const SHELLS: [&str; 4] = ["sh", "bash", "shell", "zsh"];

/// Commands that install fabkit. They may stand in such blocks, because the gate runs them or their equivalents
/// elsewhere: they build everything anew, or install into the reader's home.
const SETUP_COMMANDS: [&str; 4] = [
    "cargo run --release -- export rtac0",
    "cargo xtask test",
    "cargo install --path fabkit --locked",
    "pip install .",
];

/// Modules that continuous integration may lack.
const TOO_LARGE: [&str; 1] = ["torch"];

/// Returns whether a block holds nothing but [`SETUP_COMMANDS`].
fn is_setup(text: &str) -> bool {
    text.lines().all(|line| SETUP_COMMANDS.contains(&line))
}

/// Runner of blocks, with the search paths of commands and modules.
pub struct Runner {
    python: PathBuf,
    path: OsString,
    python_path: OsString,
    modules: BTreeMap<String, bool>,
    /// Skipped blocks, with the reasons.
    pub skipped: Vec<String>,
    /// Number of commands and programs that ran.
    pub ran: usize,
}

impl Runner {
    /// Makes a runner with the built command, an interpreter, and optionally a folder of modules for it.
    ///
    /// # Errors
    /// Paths that cannot be part of `PATH`.
    pub fn new(fabkit: &Path, python: &Path, modules: Option<&Path>) -> Result<Self, String> {
        let folders = [fabkit.parent(), python.parent()].into_iter().flatten().map(Path::to_owned);
        let system = env::var_os("PATH").unwrap_or_default();
        let path = env::join_paths(folders.chain(env::split_paths(&system)))
            .map_err(|e| format!("PATH: {e}"))?;
        let own = env::var_os("PYTHONPATH");
        let folders = modules.map(Path::to_owned).into_iter();
        let own = own.iter().flat_map(env::split_paths);
        let python_path = env::join_paths(folders.chain(own));
        let python_path = python_path.map_err(|e| format!("PYTHONPATH: {e}"))?;
        let (python, modules) = (python.to_owned(), BTreeMap::new());
        Ok(Self { python, path, python_path, modules, skipped: Vec::new(), ran: 0 })
    }

    /// Runs a page in a folder.
    ///
    /// # Errors
    /// The first block that does not behave as the page says.
    pub fn page(&mut self, name: &Path, page: &Page, folder: &Path) -> Result<(), String> {
        let mut printed = None;
        for block in &page.blocks {
            let place = |line: usize| format!("{}:{}", name.display(), block.line + line);
            if let Some(module) = block.option("needs").filter(|module| !self.has_module(module)) {
                let skipped = format!("{}: Python has no `{module}` here", place(0));
                if in_ci() && !TOO_LARGE.contains(&module) {
                    return Err(skipped);
                }
                self.skipped.push(skipped);
                // A skipped program printed nothing, so the output block after it is skipped too.
                printed = None;
                continue;
            }
            if let Some(file) = block.option("file") {
                fs::write(folder.join(file), &block.text)
                    .map_err(|e| format!("{}: {file}: {e}", place(0)))?;
                continue;
            }
            if let Some(source) = block.option("from") {
                check_quotation(source, &block.text).map_err(|e| format!("{}: {e}", place(0)))?;
                continue;
            }
            match block.language.as_str() {
                "console" => self.console(block, folder, &place)?,
                "python" => {
                    printed =
                        Some(self.python(block, folder).map_err(|e| format!("{}: {e}", place(0)))?);
                }
                "text" if block.has("output") => {
                    if let Some(printed) = printed.take() {
                        let shown: Vec<String> =
                            block.text.lines().map(|line| line.trim_end().to_owned()).collect();
                        expected::compare(&shown, &printed)
                            .map_err(|e| format!("{}: {e}\n{printed}", place(0)))?;
                    }
                }
                shell if SHELLS.contains(&shell) && !is_setup(&block.text) => {
                    return Err(format!(
                        "{}: `{shell}` blocks do not run; write console",
                        place(0)
                    ));
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn console(
        &mut self,
        block: &Block,
        folder: &Path,
        place: &dyn Fn(usize) -> String,
    ) -> Result<(), String> {
        for step in expected::steps(&block.text).map_err(|e| format!("{}: {e}", place(0)))? {
            let failed = |why: &str, output: &str| {
                format!("{}: $ {}\n{output}{why}", place(1 + step.line), step.command)
            };
            let mut bash = self.command(Path::new("bash"), folder);
            // Standard error goes to the same pipe, so that lines keep their order.
            bash.args(["-c", &format!("exec 2>&1; set -eo pipefail; {}", step.command)]);
            let (code, output) = run_command(&mut bash, "").map_err(|e| failed(&e, ""))?;
            self.ran += 1;
            check_exit_code(block, code).map_err(|e| failed(&e, &output))?;
            if !step.shown.is_empty() {
                expected::compare(&step.shown, &output).map_err(|e| failed(&e, &output))?;
            }
        }
        Ok(())
    }

    fn python(&mut self, block: &Block, folder: &Path) -> Result<String, String> {
        let mut python = self.command(&self.python, folder);
        let (code, output) = run_command(python.arg("-"), &block.text)?;
        self.ran += 1;
        check_exit_code(block, code).map_err(|e| format!("{e}\n{output}"))?;
        Ok(output)
    }

    fn command(&self, program: &Path, folder: &Path) -> Command {
        let mut command = Command::new(program);
        command
            .current_dir(folder)
            .env("PATH", &self.path)
            .env("PYTHONPATH", &self.python_path)
            .env("FABKIT_PYTHON", &self.python)
            .env("COLUMNS", "100");
        command
    }

    fn has_module(&mut self, module: &str) -> bool {
        if let Some(known) = self.modules.get(module) {
            return *known;
        }
        let found = Command::new(&self.python)
            .args(["-c", &super::import_code(module)])
            .env("PYTHONPATH", &self.python_path)
            .current_dir(env::temp_dir())
            .stderr(Stdio::null())
            .status()
            .is_ok_and(|status| status.success());
        self.modules.insert(module.to_owned(), found);
        found
    }
}

/// Checks that lines occur consecutively in a file of the repository, ignoring indentation.
fn check_quotation(source: &str, text: &str) -> Result<(), String> {
    let have = fs::read_to_string(root().join(source)).map_err(|e| format!("{source}: {e}"))?;
    let trimmed = |text: &str| text.lines().map(|l| l.trim().to_owned()).collect::<Vec<_>>();
    let gap = || ["...".to_owned()];
    let shown = [&gap()[..], &trimmed(text), &gap()].concat();
    expected::compare(&shown, &trimmed(&have).join("\n"))
        .map_err(|_| format!("{source} has no such lines any more"))
}

fn check_exit_code(block: &Block, code: Option<i32>) -> Result<(), String> {
    let wanted = block.option("fails").unwrap_or("0");
    let have = code.map_or("a signal".to_owned(), |code| code.to_string());
    if have == wanted { Ok(()) } else { Err(format!("exit code {have} instead of {wanted}")) }
}

/// Runs a command. Returns the exit code, and standard output followed by standard error.
fn run_command(command: &mut Command, input: &str) -> Result<(Option<i32>, String), String> {
    let failed = |e: std::io::Error| format!("cannot run it: {e}");
    let pipes = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = pipes.spawn().map_err(failed)?;
    if let Some(mut stdin) = child.stdin.take() {
        // A program that ends without reading closes the pipe; its exit code shows whether that is right.
        let _ = stdin.write_all(input.as_bytes());
    }
    let output = child.wait_with_output().map_err(failed)?;
    let text = [output.stdout, output.stderr].concat();
    Ok((output.status.code(), String::from_utf8_lossy(&text).into_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::book::markdown;

    /// Runs a page in an empty folder, with `true` and `false` in place of the command.
    fn run(text: &str) -> Result<usize, String> {
        let folder =
            env::temp_dir().join(format!("fabkit-book-{}-{:p}", std::process::id(), text.as_ptr()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        let mut runner = Runner::new(Path::new("/bin/true"), Path::new("python3"), None).unwrap();
        let page = markdown::read(text).unwrap();
        let outcome = runner.page(Path::new("a.md"), &page, &folder);
        fs::remove_dir_all(&folder).unwrap();
        outcome.map(|()| runner.ran)
    }

    #[test]
    fn commands_do_what_the_page_says() {
        assert_eq!(
            run("```text file=a.txt\nsome\n```\n```console\n$ cat a.txt\nsome\n```\n"),
            Ok(1)
        );
        assert_eq!(run("```console fails=1\n$ false\n```\n"), Ok(1));
        let wrong = run("words\n```console\n$ true\n$ echo b\na\n```\n").unwrap_err();
        assert!(wrong.starts_with("a.md:4: $ echo b") && wrong.contains("lacks `a`"), "{wrong}");
        let failed = run("```console\n$ false\n```\n").unwrap_err();
        assert!(failed.contains("exit code 1 instead of 0"), "{failed}");
        assert!(run("```bash\ntrue\n```\n").unwrap_err().contains("do not run"));
    }

    #[test]
    fn quotations_must_stand_in_the_repository() {
        assert_eq!(run("```rust from=xtask/src/main.rs\nfn main() -> ExitCode {\n```\n"), Ok(0));
        let gone = run("```rust from=xtask/src/main.rs\nfn gone() {\n```\n").unwrap_err();
        assert!(gone.contains("xtask/src/main.rs has no such lines"), "{gone}");
    }
}
