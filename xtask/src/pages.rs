//! `cargo xtask pages`: tests the pages of `fabkit guide` in a real browser, and the viewer's bundle.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::bytes::sensors_and_fixtures;
use crate::run::{built_path, check, exists, fabkit, root};

/// Page opened in `cargo xtask test`: that of one sensor.
const SAMPLE: &str = "rtac0";
/// Argument that selects the sample.
pub const SAMPLED: &str = "--sample";

/// Time limit of the first frame in the sample, ms: other work may run on the machine, without a graphics card.
/// `cargo xtask pages` itself allows a second.
const SAMPLE_FRAME_MS: &str = "10000";

/// Tests the pages of all designs, of the named ones, or of the sample.
pub fn run(designs: &[String]) -> Result<(), String> {
    let tools = Tools::find()?;
    if designs == [SAMPLED] {
        return tools.judge(&[SAMPLE.to_owned()], &[("FABKIT_FIRST_FRAME_MS", SAMPLE_FRAME_MS)]);
    }
    tools.bundle()?;
    if designs.is_empty() {
        let all = sensors_and_fixtures(&fabkit()?)?.into_iter().flat_map(|(sensor, fixtures)| {
            let fixtures = fixtures.iter().map(|fixture| format!("{sensor}/{fixture}"));
            fixtures.chain([sensor.clone()]).collect::<Vec<_>>()
        });
        return tools.judge(&all.collect::<Vec<_>>(), &[]);
    }
    tools.judge(designs, &[])
}

/// Finds a program in `PATH`: the browser driver does not search itself.
fn find_program(program: &str) -> Option<PathBuf> {
    let folders = env::var_os("PATH")?;
    env::split_paths(&folders).map(|folder| folder.join(program)).find(|path| path.is_file())
}

/// Programs from npm in the versions of `designs/viewer/package-lock.json`, and a browser.
pub struct Tools {
    chromium: PathBuf,
}

impl Tools {
    /// Finds the browser, and installs the locked packages unless they are up to date.
    pub fn find() -> Result<Self, String> {
        let chromium =
            ["chromium", "chromium-browser", "google-chrome"].into_iter().find_map(find_program);
        let chromium =
            chromium.ok_or("Chromium is not installed; the system's packages have it")?;
        for program in ["node", "npm"] {
            if !exists(Path::new(program)) {
                return Err(format!("{program} is not installed; the system's packages have it"));
            }
        }
        let written =
            |path: &str| fs::metadata(viewer().join(path)).and_then(|m| m.modified()).ok();
        // npm writes this copy of the lock at the end of an installation; a missing file is older than any.
        if written("node_modules/.package-lock.json") < written("package-lock.json") {
            let mut npm = Command::new("npm");
            npm.args(["ci", "--ignore-scripts", "--no-audit", "--no-fund"]);
            check(npm.current_dir(viewer()))?;
        }
        Ok(Self { chromium })
    }

    /// Returns the folder with gltf-validator.
    pub fn modules(&self) -> PathBuf {
        viewer().join("node_modules")
    }

    /// Checks that the viewer in the repository is what its sources build, byte by byte.
    pub fn bundle(&self) -> Result<(), String> {
        let folder = built_path("pages", "bundle");
        check(Command::new("node").arg(viewer().join("build.js")).arg(&folder))?;
        let read = |path: PathBuf| fs::read(&path).map_err(|e| format!("{}: {e}", path.display()));
        let made = read(folder.join("viewer.js"))?;
        if made == read(root().join("designs/guide/src/viewer/viewer.js"))? {
            return Ok(());
        }
        Err("designs/guide/src/viewer/viewer.js is not what viewer/ makes: run `npm run build` there"
            .into())
    }

    fn judge(&self, designs: &[String], envs: &[(&str, &str)]) -> Result<(), String> {
        let fabkit = fabkit()?;
        let folders: Vec<PathBuf> =
            designs.iter().map(|design| built_path("pages", &design.replace('/', "-"))).collect();
        for (design, folder) in designs.iter().zip(&folders) {
            check(Command::new(&fabkit).args(["guide", design, "--quiet", "-o"]).arg(folder))?;
        }
        let script = viewer().join("check/pages.js");
        let mut node = Command::new("node");
        check(node.arg(script).arg(&self.chromium).args(&folders).envs(envs.iter().copied()))
    }
}

fn viewer() -> PathBuf {
    root().join("designs/viewer")
}
