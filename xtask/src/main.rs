//! Development tasks: `cargo xtask help` lists them.

mod bench_depth;
mod bench_peers;
mod book;
mod bytes;
mod edits;
#[cfg(unix)]
mod faults;
mod fuzz;
mod light;
mod lint;
mod pages;
mod python;
mod python_package;
mod real_captures;
mod run;
mod rust_tests;
mod samples;
mod style;
mod test;
mod variants;

use std::env;
use std::process::ExitCode;

const HELP: &str = "\
Usage: cargo xtask TASK

Tasks:
  test [--full]      Set up what tests need and run them all: outside oracles, unit, end-to-end, doc tests;
                     of many things a sample, which --help names, or everything
  verify-env         Make the Python environment of the verifier and of the outside oracles
  lint               Formatting, clippy and documentation without warnings, licences and sources
  fuzz [--seconds S | --runs N] [--seed K] [NAME...]
                     Feed everything that reads files, and the command, with files that are nearly right
  python             Build the Python package's wheel, install it, run its tests; types and style
  book [PAGE]        Write the book's reference, run every command and program in it, make its HTML
  bytes [--accept | --debug]
                     Compare the bytes of all exports with the list in xtask/bytes.txt, or write it anew;
                     or compare those of a release and of a debug build
  faults [--rounds N] [--seed N]
                     Fail each system call, kill, crowd and starve commands; look at what is on disk
  edits              Change each numeric parameter of the sensors alone by 10 % and 25 %; what is refused, and
                     why, and what --fix makes of it
  style [FOLDER...]  Count habits that make code hard to read for newcomers, here or in other repositories
  bench-peers        Time fabkit beside its peers, print the ratios and write docs/benchmarks.md
  bench-depth        Cast ground truth beside Embree and Open3D; rates and errors
  variants N         Export N random variants of sensors and fixtures; trimesh judges every file.
                     --seed S for others than last time
  light [--mitsuba] [SENSOR...]
                     Follow 50,000 pixels' rays of five sensors with NumPy, or three sensors' with Mitsuba 3,
                     and compare with what fabkit says they see
  opencv             Compare our corner detector with OpenCV's; needs OpenCV 4 with headers, and libclang
  pages [DESIGN...]  Open the pages of `fabkit guide` in Chromium, of all designs or those that are named: the
                     model, screens, paper, accessibility; build the viewer's bundle again and compare
  real-captures DIR  Calibrate the published captures of a real R-Tac0, hold the result to its limits
";

fn main() -> ExitCode {
    let task = env::args().nth(1).unwrap_or_default();
    let result = match task.as_str() {
        "test" => test::run(&env::args().skip(2).collect::<Vec<_>>()),
        "verify-env" => python::run(),
        "lint" => lint::run(),
        "fuzz" => fuzz::run(env::args().skip(2)),
        "python" => python_package::run(),
        "opencv" => test::opencv_detector(),
        "book" => book::run(env::args().nth(2).as_deref()),
        "bytes" => bytes::run(&env::args().skip(2).collect::<Vec<_>>()),
        #[cfg(unix)]
        "faults" => faults::run(&env::args().skip(2).collect::<Vec<_>>()),
        "variants" => variants::run(&env::args().skip(2).collect::<Vec<_>>()),
        "light" => light::run(&env::args().skip(2).collect::<Vec<_>>()),
        "pages" => pages::run(&env::args().skip(2).collect::<Vec<_>>()),
        "edits" => edits::run(),
        "style" => style::run(&env::args().skip(2).collect::<Vec<_>>()),
        "bench-depth" => bench_depth::run(),
        "real-captures" => real_captures::run(env::args_os().nth(2).map(Into::into)),
        "bench-peers" => bench_peers::run(),
        "" | "-h" | "--help" | "help" => {
            print!("{HELP}");
            return ExitCode::SUCCESS;
        }
        other => Err(format!("there is no task `{other}`\n\n{HELP}")),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}
