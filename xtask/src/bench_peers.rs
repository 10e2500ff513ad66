//! `cargo xtask bench-peers`

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::run::{built_path, cargo, check, root};

/// Times fabkit beside manifold3d, cadquery and build123d on the same trees at the same chord tolerance, prints the
/// table and writes it into `docs/benchmarks.md`.
pub fn run() -> Result<(), String> {
    let python = crate::python::environment()?;
    let release = ["build", "--release", "--package"];
    check(cargo().args(release).arg("fabkit"))?;
    check(cargo().args(release).args(["fabkit-mesh", "--example", "peer"]))?;
    let peer = built_path("release", "examples/peer");

    let trees = built_path("release", "bench-peers");
    fs::create_dir_all(&trees).map_err(|e| format!("{}: {e}", trees.display()))?;
    check(Command::new(&peer).arg("scenes").arg(&trees))?;
    let export = |sensor: &str, parts: &[&str]| {
        let mut command = Command::new(built_path("release", "fabkit"));
        command.args(["export", sensor, "--quiet", "--format", "tree", "-o"]);
        if sensor == "rtac0" {
            // This route has printed mold halves.
            command.arg("--set=molds.route=printed");
        }
        command.arg(trees.join(sensor)).args(parts.iter().map(|part| format!("--part={part}")));
        check(&mut command)
    };
    export("rtac0", &[])?;
    export("uvdtact", &["inner-elastomer", "shell-holder", "negative-cup-inner"])?;
    export("shadowtac", &["mold-skin-block", "base"])?;
    export("tactip", &["ring", "body"])?;
    export("fluidic", &["display-cover", "mold-channel-comb"])?;
    export("rtac0/pin-dome", &["dome", "surround"])?;
    export("tactip/pin-dome", &["dome"])?;
    export("rtac0/semi-domes", &["semi-dome-000", "holder"])?;

    let rtac0 = trees.join("rtac0");
    let halves = ["a", "b"].map(|half| format!("mold-translucent-gel-{half}.tree.json"));
    let groups = [
        group("200 dimples in a mold", &trees, &["dimpled-mold.tree.json".into()]),
        group("100 holes in a dome", &trees, &["perforated-dome.tree.json".into()]),
        group(
            "uvdtact: layer with 85 slots",
            &trees,
            &["uvdtact/inner-elastomer.tree.json".into()],
        ),
        group("shadowtac: mold", &trees, &["shadowtac/mold-skin-block.tree.json".into()]),
        group("rtac0: two-piece mold", &rtac0, &halves),
        group("rtac0: all printed parts", &rtac0, &trees_in(&rtac0)?),
    ];
    // Parts for which nothing was tuned: one of each kind that sensors and fixtures have.
    let untuned = [
        ("rtac0: pin dome", "rtac0/pin-dome/dome"),
        ("rtac0: pin dome's surround", "rtac0/pin-dome/surround"),
        ("tactip: pin dome", "tactip/pin-dome/dome"),
        ("rtac0: semi-dome", "rtac0/semi-domes/semi-dome-000"),
        ("rtac0: holder of semi-domes", "rtac0/semi-domes/holder"),
        ("tactip: ring", "tactip/ring"),
        ("tactip: body", "tactip/body"),
        ("uvdtact: shell holder", "uvdtact/shell-holder"),
        ("uvdtact: negative of a cup", "uvdtact/negative-cup-inner"),
        ("shadowtac: base", "shadowtac/base"),
        ("fluidic: display cover", "fluidic/display-cover"),
        ("fluidic: comb of channels", "fluidic/mold-channel-comb"),
    ];
    let untuned = untuned.map(|(title, part)| group(title, &trees, &[format!("{part}.tree.json")]));
    check(
        Command::new(python)
            .arg(root().join("xtask/peers/run.py"))
            .arg("--fabkit")
            .arg(peer)
            .arg("--verify")
            .arg(root().join("export/verify"))
            .arg("--write")
            .arg(root().join("docs/benchmarks.md"))
            .args(groups)
            .args(untuned),
    )
}

fn group(title: &str, folder: &Path, files: &[String]) -> String {
    let paths: Vec<String> = files.iter().map(|f| folder.join(f).display().to_string()).collect();
    format!("{title}={}", paths.join(","))
}

/// Lists the names of tree files in a folder, sorted.
fn trees_in(folder: &Path) -> Result<Vec<String>, String> {
    let failed = |e: std::io::Error| format!("{}: {e}", folder.display());
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let name = entry.map_err(failed)?.file_name().to_string_lossy().into_owned();
        if name.ends_with(".tree.json") {
            names.push(name);
        }
    }
    names.sort();
    Ok(names)
}
