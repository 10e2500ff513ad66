//! Scenarios: the disturbed commands, and the execution of trials.

use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::sleep;
use std::time::{Duration, Instant};

use super::Trial;
use super::inputs::{CAMERA, SWEEP, camera_file, captures, corners};
use super::judge::{self, Files};
use super::shim::{self, Fault, KINDS};

/// Time limit of a run; a longer one counts as hanging.
const TIME_LIMIT: Duration = Duration::from_secs(120);

/// Documented exit codes: success, bad input, limit, input or output failure.
const DOCUMENTED: [i32; 4] = [0, 2, 3, 4];

/// Way in which a command writes its folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Replaces a set of files in one transaction.
    Set,
    /// Begins a folder, and resumes it.
    Resumable,
}

/// Command with its inputs and expected outputs.
#[derive(Clone, Debug)]
pub struct Scenario {
    pub name: &'static str,
    kind: Kind,
    fabkit: PathBuf,
    scratch: PathBuf,
    inputs: Vec<(String, String)>,
    /// Arguments of the run that makes the old files.
    before: Vec<String>,
    /// Arguments of the disturbed run.
    arguments: Vec<String>,
    /// Arguments of the simultaneous runs.
    rivals: Vec<Vec<String>>,
    old: Files,
    new: Files,
    /// Files that each rival writes when it runs alone.
    rival_files: Vec<Files>,
    counts: Vec<usize>,
    usual: Duration,
}

fn words(line: &str) -> Vec<String> {
    line.split_whitespace().map(str::to_owned).collect()
}

/// Makes all scenarios.
pub fn all(fabkit: &Path, scratch: &Path) -> Result<Vec<Scenario>, String> {
    let make = |name, kind, inputs: &[(&str, &str)], before: &str, arguments: &str| Scenario {
        name,
        kind,
        fabkit: fabkit.into(),
        scratch: scratch.into(),
        inputs: inputs.iter().map(|(n, t)| ((*n).to_owned(), (*t).to_owned())).collect(),
        before: words(before),
        arguments: words(arguments),
        rivals: Vec::new(),
        old: Files::new(),
        new: Files::new(),
        rival_files: Vec::new(),
        counts: Vec::new(),
        usual: Duration::ZERO,
    };
    let camera = [("camera.yaml", CAMERA)];
    let export = "export rtac0 --part collar --part base --format stl,3mf -o out --set \
                  base.height";
    let mut set =
        make("export", Kind::Set, &[], &format!("{export}=8.7mm"), &format!("{export}=9mm"));
    set.rivals = (0..4).map(|i| words(&format!("{export}=8.{}mm", i + 6))).collect();
    let depth =
        "depth rtac0 --camera camera.yaml -o out/a/x.npz --png out/b/x.png --ply out/b/x.ply";
    let presses = "--press hemisphere@20deg,0deg";
    let corners = corners();
    let board = board(fabkit, scratch)?;
    let lens = [("corners.csv", corners.as_str()), ("board.json", board.as_str())];
    let calibrate = "calibrate intrinsics rtac0 --board board.json --corners corners.csv --model \
                     kannala-brandt -o out/camera.yaml --report out/report/lens.html --set \
                     camera.field_of_view";
    let (landmarks, captures) = captures();
    let (lens_a, lens_b) = (camera_file(229.18), camera_file(228.0));
    let pins = [
        ("a.yaml", lens_a.as_str()),
        ("b.yaml", &lens_b),
        ("landmarks.json", &landmarks),
        ("captures/captures.csv", &captures),
    ];
    let extrinsics = "calibrate extrinsics rtac0 --captures captures --landmarks landmarks.json -o \
                      out/pose.yaml --report out/report/pose.html --camera";
    let dataset = "dataset rtac0 --camera camera.yaml --resume -o out --presses";
    let list = "a = hemisphere@20deg,0deg,0.5mm\nb = hemisphere@40deg,0deg,1mm\n";
    let other = "a = hemisphere@30deg,0deg,0.5mm\nb = hemisphere@10deg,0deg,1mm\n";
    let pressed = [camera[0], ("list.txt", list), ("other.txt", other)];
    let mut dataset_of =
        make("dataset", Kind::Resumable, &pressed, "", &format!("{dataset} list.txt"));
    dataset_of.rivals = rivals(dataset, "list.txt", "other.txt");
    let other = SWEEP.replace("8 mm", "9 mm");
    let plans = [("sweep.yaml", SWEEP), ("other.yaml", &other)];
    let sweep = "sweep --resume -o out";
    let mut sweep_of = make("sweep", Kind::Resumable, &plans, "", &format!("{sweep} sweep.yaml"));
    sweep_of.rivals = rivals(sweep, "sweep.yaml", "other.yaml");
    Ok(vec![
        set,
        make(
            "depth",
            Kind::Set,
            &camera,
            &format!("{depth} {presses},0.5mm"),
            &format!("{depth} {presses},1mm"),
        ),
        make(
            "calibrate",
            Kind::Set,
            &lens,
            &format!("{calibrate}=150deg --set camera.depth=7mm"),
            &format!("{calibrate}=140deg"),
        ),
        make(
            "extrinsics",
            Kind::Set,
            &pins,
            &format!("{extrinsics} a.yaml"),
            &format!("{extrinsics} b.yaml"),
        ),
        dataset_of,
        sweep_of,
    ])
}

/// Makes the arguments of four simultaneous runs: three with the same input, and one with another.
fn rivals(command: &str, same: &str, other: &str) -> Vec<Vec<String>> {
    [same, same, other, same].iter().map(|input| words(&format!("{command} {input}"))).collect()
}

/// Exports the board to which the corners belong.
fn board(fabkit: &Path, scratch: &Path) -> Result<String, String> {
    let out = scratch.join("boards");
    let mut command = Command::new(fabkit);
    command.args(["export", "rtac0/boards", "--quiet", "--format=svg", "-o"]).arg(&out);
    let output = command.output().map_err(|e| e.to_string())?;
    let entries = fs::read_dir(&out).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut boards: Vec<PathBuf> =
        entries.filter(|path| path.to_string_lossy().ends_with(".board.json")).collect();
    boards.sort();
    let first =
        boards.first().ok_or_else(|| String::from_utf8_lossy(&output.stderr).into_owned())?;
    fs::read_to_string(first).map_err(|e| e.to_string())
}

static NUMBER: AtomicUsize = AtomicUsize::new(0);

impl Scenario {
    pub fn has_rivals(&self) -> bool {
        !self.rivals.is_empty()
    }

    /// Lists every fault: each call of each kind with each error.
    pub fn faults(&self) -> Vec<Fault> {
        let mut faults = Vec::new();
        for ((call, errors), count) in KINDS.iter().zip(&self.counts) {
            for k in 1..=*count {
                for &error in *errors {
                    faults.push(Fault { call, ordinal: k, error, is_persistent: false });
                    // A full disk (28) and missing permissions (13) persist, so all later calls fail as well.
                    if [28, 13].contains(&error) {
                        faults.push(Fault { call, ordinal: k, error, is_persistent: true });
                    }
                }
            }
        }
        faults
    }

    /// Runs the scenario undisturbed, to learn its old and new files, its numbers of calls and its usual time.
    pub fn prepare(&mut self, shim: &Path) -> Result<(), String> {
        let place = self.make_folder()?;
        self.run_well(&place, &self.before)?;
        self.old = judge::files(&place.join("out"));
        let start = Instant::now();
        let mut command = self.command(&place, &self.arguments);
        self.counts = shim::count(&mut command, shim, &place)
            .map_err(|why| format!("{}: {why}", self.name))?;
        self.usual = start.elapsed();
        self.new = judge::files(&place.join("out"));
        if self.kind == Kind::Set && self.old == self.new {
            return Err(format!("{}: the new files are the old ones", self.name));
        }
        for rival in &self.rivals {
            let place = self.make_folder()?;
            self.run_well(&place, rival)?;
            self.rival_files.push(judge::files(&place.join("out")));
        }
        Ok(())
    }

    /// Runs one trial and judges the remaining files.
    pub fn try_out(&self, trial: &Trial, shim: &Path) -> Result<(), String> {
        let place = self.make_folder()?;
        for (name, bytes) in &self.old {
            let path = place.join("out").join(name);
            let folder = path.parent().unwrap_or(&place);
            fs::create_dir_all(folder).and_then(|()| fs::write(&path, bytes)).map_err(text)?;
        }
        let judged = match trial {
            Trial::Concurrent(part) => self.run_concurrently(&place, *part),
            _ => self.disturb(trial, shim, &place),
        };
        if judged.is_ok() {
            fs::remove_dir_all(&place).map_err(text)?;
        }
        judged.map_err(|why| format!("{why} (in {})", place.display()))
    }

    fn disturb(&self, trial: &Trial, shim: &Path, place: &Path) -> Result<(), String> {
        let mut command = self.command(place, &self.arguments);
        match trial {
            Trial::Call(fault) => fault.inject(&mut command, shim, place),
            Trial::Memory(mib) => command = self.command_with_memory(place, *mib),
            _ => {}
        }
        let child = command.spawn().map_err(text)?;
        let wait = match trial {
            Trial::Kill(part) => self.usual.mul_f64(*part),
            _ => TIME_LIMIT,
        };
        let status = wait_for(child, wait, matches!(trial, Trial::Kill(_)))?;
        // Without memory the allocator aborts, which is a signal as well.
        let died = status.code().is_none();
        if died && matches!(trial, Trial::Call(fault) if !fault.kills()) {
            return Err(format!("ended by a signal: {status}"));
        }
        if let Some(code) = status.code().filter(|code| !DOCUMENTED.contains(code)) {
            return Err(format!("exit code {code}"));
        }
        let after = judge::files(&place.join("out"));
        if status.success() {
            judge::check_exact(&after, &self.new)?;
        }
        // If renaming fails persistently, nothing can be put back; the next run does that.
        let is_stuck =
            matches!(trial, Trial::Call(Fault { call: "rename", is_persistent: true, .. }));
        if self.kind == Kind::Set {
            if died || is_stuck {
                judge::check_recoverable(&after, &self.old, &self.new)?
            } else {
                judge::check_complete(&after, &self.old, &self.new)?
            }
        }
        if after != self.new {
            self.run_well(place, &self.arguments).map_err(|why| format!("the next run: {why}"))?;
            judge::check_exact(&judge::files(&place.join("out")), &self.new)?;
        }
        Ok(())
    }

    fn run_concurrently(&self, place: &Path, part: f64) -> Result<(), String> {
        let spawn = |rival: &Vec<String>| self.command(place, rival).spawn().map_err(text);
        // The crowd then meets a folder that is begun but not finished.
        if self.kind == Kind::Resumable && part > 0.0 {
            wait_for(spawn(&self.arguments)?, self.usual.mul_f64(part), true)?;
        }
        let children: Vec<Child> = self.rivals.iter().map(spawn).collect::<Result<_, _>>()?;
        // Exit code 4: the folder is in use. Code 2, for resumable folders only: it holds another plan.
        let usual: &[i32] = if self.kind == Kind::Set { &[0, 4] } else { &[0, 2, 4] };
        let mut has_finished = false;
        for child in children {
            let status = wait_for(child, TIME_LIMIT, false)?;
            if !status.code().is_some_and(|code| usual.contains(&code)) {
                return Err(format!("one of several at once: {status}"));
            }
            has_finished |= status.success();
        }
        let is_one = || self.rival_files.contains(&judge::files(&place.join("out")));
        if is_one() {
            return Ok(());
        }
        if has_finished || self.kind == Kind::Set {
            return Err("a mixture of several runs".into());
        }
        // Each run may have been refused because of one that in turn found another's folder. Alone, one of them must be
        // able to resume.
        let mut refusals = Vec::new();
        for rival in &self.rivals {
            match self.run_well(place, rival) {
                Ok(()) if is_one() => return Ok(()),
                Ok(()) => return Err("a mixture of several runs, after the next one".into()),
                Err(why) => refusals.push(why),
            }
        }
        Err(format!("nobody can go on after several runs at once: {}", refusals.join("; ")))
    }

    /// Makes a new folder with the inputs.
    fn make_folder(&self) -> Result<PathBuf, String> {
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let place = self.scratch.join(format!("{}-{number}", self.name));
        fs::create_dir_all(&place).map_err(text)?;
        for (name, content) in &self.inputs {
            let path = place.join(name);
            let folder = path.parent().unwrap_or(&place);
            fs::create_dir_all(folder).and_then(|()| fs::write(&path, content)).map_err(text)?;
        }
        Ok(place)
    }

    /// Makes the command with one thread, so that the k-th call is the same each time.
    fn command(&self, place: &Path, arguments: &[String]) -> Command {
        let mut command = Command::new(&self.fabkit);
        command.current_dir(place).args(arguments).args(["--quiet", "--threads", "1"]);
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        command
    }

    fn command_with_memory(&self, place: &Path, mib: u64) -> Command {
        let mut command = Command::new("sh");
        let script = format!(r#"ulimit -v {}; exec "$0" "$@""#, mib << 10);
        command.args(["-c", &script]).arg(&self.fabkit).args(&self.arguments);
        command.args(["--quiet", "--threads", "1"]).current_dir(place);
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        command
    }

    fn run_well(&self, place: &Path, arguments: &[String]) -> Result<(), String> {
        if arguments.is_empty() {
            return Ok(());
        }
        let mut command = self.command(place, arguments);
        let output = command.stderr(Stdio::piped()).output().map_err(text)?;
        if output.status.success() {
            Ok(())
        } else {
            Err(format!("{}: {}", self.name, String::from_utf8_lossy(&output.stderr)))
        }
    }
}

fn text(error: std::io::Error) -> String {
    error.to_string()
}

/// Waits for the end of a process, and kills it after `latest`. Being killed is an error unless `may_last`.
fn wait_for(mut child: Child, latest: Duration, may_last: bool) -> Result<ExitStatus, String> {
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait().map_err(text)? {
            return Ok(status);
        }
        if start.elapsed() >= latest {
            child.kill().map_err(text)?;
            let status = child.wait().map_err(text)?;
            let killed = status.signal().is_some();
            return if may_last || !killed { Ok(status) } else { Err("it hangs".into()) };
        }
        sleep(Duration::from_millis(1));
    }
}
