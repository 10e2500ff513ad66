//! Sweeps by the real binary: the same bytes however they are computed, killed and resumed, refused
//! with the culprit's name; and their metrics against other ways to the same figures.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use fabkit_application::sweep::{Plan, PlanSource, Row, Status};
use fabkit_optics::{CameraView, ViewStacks};
use fabkit_tests::{Run, command, fabkit};

const SMALL: &str = "
format: 1
sensor: rtac0
set: {camera.field_of_view: 150 deg}
axes:
  camera.depth: {from: 6 mm, to: 8 mm, steps: 3}
  translucent_gel.thickness: [1.4 mm, 1.5 mm, 0.7 mm]
metrics: [coverage, mm_per_px_median, parts_mass_g, calibration, marker_count]
constraints: [camera.depth + 0]
objectives: {coverage: max, mm_per_px_median: min}
";

/// The plan above with its constraints replaced.
fn small(constraints: &str) -> String {
    SMALL.replace("[camera.depth + 0]", constraints)
}

fn folder(plan: &str) -> tempfile::TempDir {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("sweep.yaml"), plan).unwrap();
    root
}

fn sweep(root: &Path, more: &[&str]) -> Run {
    fabkit(root, &[&["sweep", "sweep.yaml", "-o", "out"], more].concat())
}

/// Every file with its hash.
fn files(root: &Path) -> BTreeMap<String, String> {
    let entries = fs::read_dir(root.join("out")).unwrap().map(Result::unwrap);
    let hash = |path: &Path| blake3::hash(&fs::read(path).unwrap()).to_hex().to_string();
    entries.map(|e| (e.file_name().into_string().unwrap(), hash(&e.path()))).collect()
}

fn assert_says(run: &Run, code: i32, texts: &[&str]) {
    assert_eq!(run.code, Some(code), "{run:?}");
    for text in texts {
        assert!(run.stderr.contains(text), "no `{text}` in:\n{}", run.stderr);
    }
}

/// Lines of a table as cells by column; no cell of these plans but `reason` has a comma.
fn table(root: &Path) -> Vec<BTreeMap<String, String>> {
    let csv = fs::read_to_string(root.join("out/sweep.csv")).unwrap();
    let cells = |line: &str| {
        let (mut cells, mut quoted) = (vec![String::new()], false);
        for c in line.chars() {
            match c {
                '"' => quoted = !quoted,
                ',' if !quoted => cells.push(String::new()),
                c => cells.last_mut().unwrap().push(c),
            }
        }
        cells
    };
    let mut lines = csv.lines();
    let names = cells(lines.next().unwrap());
    lines.map(|line| names.iter().cloned().zip(cells(line)).collect()).collect()
}

#[test]
fn a_small_sweep_has_a_row_for_each_variant() {
    let root = folder(&small("[camera.depth <= 0.5 * surface.radius, dome_position_sigma_mm < 1]"));
    let run = sweep(root.path(), &["--threads", "1"]).ok();
    assert!(run.stdout.contains("9 variants: 4 ok, 3 excluded, 2 invalid"), "{}", run.stdout);
    let names: Vec<String> = files(root.path()).into_keys().collect();
    assert_eq!(names, ["report.html", "sweep.csv", "sweep.json", "sweep.parquet"]);

    let rows = table(root.path());
    let depths: Vec<&str> = rows.iter().map(|row| &*row["camera.depth_mm"]).collect();
    assert_eq!(depths, ["6", "6", "6", "7", "7", "7", "8", "8", "8"]);
    let number = |row: usize, name: &str| rows[row][name].parse::<f64>().unwrap();
    assert!(number(0, "coverage") < number(3, "coverage"), "further back, more is seen");
    // The constraint on parameters goes before the design that cannot be.
    assert_eq!((&*rows[8]["status"], &*rows[8]["error_code"]), ("excluded", "constraint"));
    assert!(rows[8]["reason"].contains("8 mm against 7.5 mm"), "{}", rows[8]["reason"]);
    assert_eq!((&*rows[2]["status"], &*rows[2]["error_code"]), ("invalid", "design"));
    assert!(rows[2]["reason"].contains("translucent_gel.thickness"), "{}", rows[2]["reason"]);
    assert!(rows[2]["coverage"].is_empty() && rows[0]["marker_count"].is_empty());
    // What is further back sees more and larger pixels: both are on the front.
    assert_eq!(
        (&*rows[0]["pareto"], &*rows[3]["pareto"], &*rows[8]["pareto"]),
        ("true", "true", "false")
    );
    let report = fs::read_to_string(root.path().join("out/report.html")).unwrap();
    for text in ["Pareto front", "One at a time", "Pairs", "No variant has marker_count"] {
        assert!(report.contains(text), "no `{text}`");
    }
    assert!(!report.contains("http") && !report.contains("<script"));

    // Any number of threads, any folder: the same bytes.
    let other =
        folder(&small("[camera.depth <= 0.5 * surface.radius, dome_position_sigma_mm < 1]"));
    sweep(other.path(), &["--threads", "4"]).ok();
    assert_eq!(files(root.path()), files(other.path()));
}

#[test]
fn killed_and_resumed_it_ends_with_the_same_bytes() {
    let plan = "format: 1\nsensor: rtac0\nsample: 60\nseed: 7\naxes:\n  \
                camera.depth: {from: 6 mm, to: 7 mm}\n  camera.field_of_view: {from: 120 deg, to: \
                170 deg}\nmetrics: [camera, calibration]\n";
    let (whole, killed) = (folder(plan), folder(plan));
    let start = Instant::now();
    sweep(whole.path(), &[]).ok();
    let usual = start.elapsed();
    let mut kept = 0;
    for kill in 1..=6u32 {
        let more: &[&str] = if killed.path().join("out").exists() { &["--resume"] } else { &[] };
        let mut child = command(killed.path())
            .args([&["sweep", "sweep.yaml", "-o", "out"], more].concat())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        sleep(usual * kill / 12 + Duration::from_millis(5));
        let _ = child.kill();
        child.wait().unwrap();
        kept = fs::read_dir(killed.path().join("out/sweep.partial")).map_or(kept, Iterator::count);
    }
    assert!(kept > 1 || killed.path().join("out/sweep.json").exists(), "nothing was kept");
    sweep(killed.path(), &["--resume"]).ok();
    assert_eq!(files(killed.path()), files(whole.path()));
    // Resumed once more, there is nothing left to do.
    let again = sweep(killed.path(), &["--resume"]).ok();
    assert!(again.stdout.contains("60 rows found"), "{}", again.stdout);
    assert_eq!(files(killed.path()), files(whole.path()));

    // Finished, it is left alone; another plan is not mixed with it.
    assert_says(&sweep(whole.path(), &[]), 2, &["out is not empty", "--resume"]);
    fs::write(whole.path().join("sweep.yaml"), plan.replace("seed: 7", "seed: 8")).unwrap();
    assert_says(&sweep(whole.path(), &["--resume"]), 2, &["holds another sweep"]);
}

#[test]
fn an_interrupt_keeps_finished_rows() {
    let plan = "format: 1\nsensor: rtac0\nsample: 5000\naxes:\n  \
                camera.depth: {from: 6 mm, to: 7 mm}\nmetrics: [coverage]\n";
    let root = folder(plan);
    let child = command(root.path())
        .args(["sweep", "sweep.yaml", "-o", "out", "--threads", "1"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let partial = root.path().join("out/sweep.partial");
    let is_rows = |name: &str| name.ends_with(".jsonl");
    let rows = || {
        let files = fs::read_dir(&partial).into_iter().flatten().flatten();
        files.filter(|file| file.file_name().to_str().is_some_and(is_rows)).count()
    };
    let start = Instant::now();
    while rows() < 2 && start.elapsed() < Duration::from_secs(30) {
        sleep(Duration::from_millis(2));
    }
    let status = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(status.success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{output:?}");
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(told.contains("--resume goes on from here"), "{told}");
    assert!(rows() >= 2 && !root.path().join("out/sweep.csv").exists());
    // Rows are whole: another run reads every one of them.
    for file in fs::read_dir(&partial).unwrap().map(|e| e.unwrap().path()) {
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        assert!(!name.starts_with('.'), "{name} is left over");
        if name.ends_with(".jsonl") {
            let text = fs::read_to_string(file).unwrap();
            assert!(text.lines().all(|line| Row::from_line(line).is_ok()));
        }
    }
}

#[test]
fn what_is_wrong_with_a_plan_is_told_at_once_with_its_lines() {
    let plan = "\
format: 1
sensor: rtac0
sead: 3
axes:
  surface.raduis: [14 mm, 15 mm]
  camera.depth: {from: 8 mm, to: 6 mm, steps: 3}
  camera.width_px: [640, six]
  camera.field_of_view: {from: 100, to: 120 deg, steps: 2}
  tube.wall: {from: 1 mm, to: 1.2 mm}
metrics: [coverrage]
constraints: [surface.radius >= 12, smallest_wall_mm >= 0.8, depth < 3 mm]
objectives: {coverage: most}
";
    let root = folder(plan);
    let texts = [
        "`sead` is not a key of a sweep",
        "did you mean `seed`?",
        "sweep.yaml:5:3",
        "did you mean `surface.radius`",
        "camera.depth goes from 8 to 6",
        "camera.width_px takes a whole number, not `six`",
        "`from` of camera.field_of_view is `100`, not an angle",
        "tube.wall lacks `steps`",
        "`coverrage` is not a metric",
        "did you mean `coverage`?",
        "`surface.radius` has a unit, `12` has none",
        "`smallest_wall_mm` is not among the metrics of this plan",
        "`depth` is neither a parameter nor a metric",
        "`most` is neither `min` nor `max`",
    ];
    assert_says(&sweep(root.path(), &[]), 2, &texts);
    assert!(!root.path().join("out").exists());

    let missing = folder("format: 1\nsensor: rtac9\naxes: {camera.depth: [6 mm]}\n");
    assert_says(&sweep(missing.path(), &[]), 2, &["rtac9"]);
    let set = folder(
        "format: 1\nsensor: rtac0\nset: {surface.radius: 900 mm}\naxes: {leds.count: [8]}\n",
    );
    assert_says(&sweep(set.path(), &[]), 2, &["sweep.yaml:3:7", "surface.radius is 900 mm"]);
    assert_says(
        &sweep(folder("").path(), &[]),
        2,
        &["the file is empty", "`sensor: NAME` and `axes:`"],
    );
    let large = folder(&small("[]").replace("steps: 3", "steps: 90000"));
    assert_says(&sweep(large.path(), &[]), 2, &["270000 combinations; at most 100000"]);
}

#[test]
fn constraints_that_exclude_everything_are_named() {
    // Known before anything is built.
    let root = folder(&small("[camera.depth < 5 mm, camera.depth < 7 mm]"));
    let texts = ["`camera.depth < 5 mm` excludes all 9 variants", "6 mm against 5 mm"];
    let run = sweep(root.path(), &[]);
    assert_says(&run, 2, &texts);
    assert!(!run.stderr.contains("`camera.depth < 7 mm` excludes"));
    let root = folder(&small("[camera.depth < 7 mm, camera.depth > 7 mm]"));
    assert_says(
        &sweep(root.path(), &[]),
        2,
        &["together exclude all 9", "`camera.depth < 7 mm` leaves 3"],
    );
    // Known afterwards: the table is there.
    let root = folder(&small("[coverage > 2]").replace(", 0.7 mm", ""));
    let run = sweep(root.path(), &[]);
    assert_eq!(run.code, Some(1), "{run:?}");
    assert!(
        run.stdout.contains("no variant is left: `coverage > 2` excludes 6 of 6"),
        "{}",
        run.stdout
    );
    assert_eq!(table(root.path()).len(), 6);
}

/// The row of a built-in sensor as it is: one axis that says what the file says.
fn row(sensor: &str, axis: &str, metrics: &str) -> Row {
    let text = format!("format: 1\nsensor: {sensor}\naxes: {{{axis}}}\nmetrics: [{metrics}]\n");
    let yaml = fabkit_application::designs::builtin_yaml(sensor).unwrap();
    let plan = Plan::new(PlanSource::new("sweep.yaml", &text, sensor, yaml)).unwrap();
    let row = plan.evaluate(0);
    assert_eq!(row.status, Status::Ok, "{sensor}: {:?}", row.reason);
    row
}

#[test]
fn metrics_agree_with_other_ways_to_them() {
    let rtac0 = row("rtac0", "leds.count: [8]", "camera, masses, meshes, calibration, walls");
    let of = |name: &str| rtac0.metrics[name];
    // 2 pi r (r + h) of a hemisphere on a wall.
    let area_mm2 = 2.0 * std::f64::consts::PI * 15.0 * 21.0;
    assert!((of("surface_area_mm2") / area_mm2 - 1.0).abs() < 1e-6);
    // Lines against triangles at a chord tolerance of 0.05 mm, which shrink a 12 mm cylinder by 0.3 %.
    assert!(
        (of("parts_volume_mm3") / of("mesh_volume_mm3") - 1.0).abs() < 5e-3,
        "{:?}",
        rtac0.metrics
    );
    let by_material: f64 =
        rtac0.metrics.iter().filter(|(name, _)| name.starts_with("mass_g[")).map(|(_, g)| g).sum();
    let total = of("parts_mass_g") + of("layers_mass_g");
    assert!((by_material / total - 1.0).abs() < 1e-12);
    // As `fabkit check` tells it, to its digits.
    let root = tempfile::tempdir().unwrap();
    let run = fabkit(root.path(), &["check", "rtac0/pin-dome"]);
    let told = format!("position to {:.4} mm", of("camera_position_sigma_mm"));
    assert!(run.stdout.contains(&told), "no `{told}` in {}", run.stdout);
    let told = format!("seating offset to {:.4} mm", of("seating_offset_sigma_mm"));
    assert!(run.stdout.contains(&told), "no `{told}` in {}", run.stdout);

    // The coverage that `fabkit depth` tells from four times as many other places.
    let touch = |sensor: &str| {
        let yaml = fabkit_application::designs::builtin_yaml(sensor).unwrap();
        fabkit_application::designs::load(sensor, yaml, &[], &["fixtures"]).unwrap().sensor
    };
    let sensor = touch("rtac0");
    let viewpoint =
        fabkit_application::ground_truth::Viewpoint::new(&sensor.camera, None, None).unwrap();
    let sights = ViewStacks::new(viewpoint.stack(&sensor).unwrap());
    let touch = sensor.touch.as_ref().unwrap();
    let coverage =
        fabkit_application::ground_truth::compute_coverage(touch, &viewpoint, &sights).unwrap();
    assert!((of("coverage") - coverage.area).abs() < 4e-3, "{} {}", of("coverage"), coverage.area);
}

#[test]
fn markers_are_found_and_flat_sensors_have_empty_cells() {
    let expected = [
        ("shadowtac", "camera.width_px: [1920]", 469.0),
        ("uvdtact", "camera.width_px: [400]", 85.0),
        ("tactip", "camera.pixels: [30]", 57.0),
    ];
    for (sensor, axis, count) in expected {
        let row = row(sensor, axis, "markers");
        assert_eq!(row.metrics["marker_count"], count, "{sensor}");
        let of = |name: &str| row.metrics[name];
        assert!(of("marker_px_min") <= of("marker_px_median"), "{sensor}");
        assert!((0.0..1.0).contains(&of("occlusion")), "{sensor}: {}", of("occlusion"));
    }
    // The dot at the tip is seen face on, all others askew: its 1 mm at its distance.
    let tactip = row("tactip", "camera.pixels: [30]", "markers");
    let yaml = fabkit_application::designs::builtin_yaml("tactip").unwrap();
    let sensor =
        fabkit_application::designs::load("tactip", yaml, &[], &["fixtures"]).unwrap().sensor;
    let dots = &sensor.body("dots").unwrap().landmarks;
    let tip = dots.iter().map(|dot| dot.point).min_by(|a, b| {
        let from_axis = |p: &fabkit_application::geometry::Point3<f64>| p.x.hypot(p.y);
        from_axis(a).total_cmp(&from_axis(b))
    });
    let camera = &sensor.camera;
    let viewpoint = fabkit_application::ground_truth::Viewpoint::new(camera, None, None).unwrap();
    let sights = ViewStacks::new(viewpoint.stack(&sensor).unwrap());
    let mut viewer = CameraView::new(viewpoint.camera(), &viewpoint.sensor_from_camera, &sights);
    let look = viewer.project(&tip.unwrap()).unwrap();
    let way = viewer.path_corners(&tip.unwrap(), &look);
    // Behind flat faces a thing looks nearer: each length counts by its index. Air, window, gel.
    let pieces = way.windows(2).map(|piece| (piece[1] - piece[0]).norm());
    let looks_mm: f64 = pieces.zip([1.0, 1.491, 1.41]).map(|(mm, index)| mm / index).sum();
    assert_eq!(way.len(), 4);
    let focal_px = 30f64.hypot(30.0) / camera.field_of_view.rad();
    let expected_px = focal_px / looks_mm;
    let found_px = tactip.metrics["marker_px_max"];
    assert!((found_px / expected_px - 1.0).abs() < 0.02, "{found_px} {expected_px}");
    // Twice the pixels: twice as wide, and hiding as much.
    let finer = row("tactip", "camera.pixels: [60]", "markers");
    assert!(
        (finer.metrics["marker_px_median"] / tactip.metrics["marker_px_median"] - 2.0).abs() < 1e-9
    );
    assert_eq!(finer.metrics["occlusion"], tactip.metrics["occlusion"]);
    let fluidic = row("fluidic", "camera.width_px: [640]", "camera, calibration, masses");
    assert!(!fluidic.metrics.contains_key("coverage") && fluidic.notes.is_empty());
    assert!(fluidic.metrics["parts_mass_g"] > 0.0);
}

/// What a sweep says whose interpreter is a script.
#[cfg(unix)]
fn benched(script: &str) -> (tempfile::TempDir, Run) {
    use std::os::unix::fs::PermissionsExt as _;

    let root = folder(&small("[]").replace("[coverage,", "[depth_mae_mm, coverage,"));
    let python = root.path().join("python");
    fs::write(&python, format!("#!/bin/sh\n{script}\n")).unwrap();
    fs::set_permissions(&python, fs::Permissions::from_mode(0o755)).unwrap();
    let mut command = command(root.path());
    command.args(["sweep", "sweep.yaml", "-o", "out", "--threads", "2"]);
    let run = Run::from(command.env("FABKIT_PYTHON", &python).output().unwrap());
    (root, run)
}

/// Figures of the bench come from interpreters: `fabkit/python/tests/test_sweep.py` has real ones.
#[cfg(unix)]
#[test]
fn an_interpreter_without_an_answer_is_named() {
    let hello = format!("read source; echo '{{\"version\": \"{}\"}}'", env!("CARGO_PKG_VERSION"));
    let runs = [
        ("echo '{\"missing\": \"No module named fabkit\"}'; exit 9", 2, "No module named fabkit"),
        ("read source; echo '{\"version\": \"0.0.1\"}'; cat", 2, "its package is of version 0.0.1"),
        ("exit 3", 70, "stopped without an answer (exit status: 3)"),
        (
            &*format!("{hello}; read number; echo '{{\"error\": \"KeyError: x\"}}'"),
            70,
            "KeyError: x",
        ),
        (
            &*format!("{hello}; read number; echo '{{\"row\": \"nothing\"}}'"),
            4,
            "not a row of a sweep",
        ),
    ];
    for (script, code, text) in runs {
        let (root, run) = benched(script);
        assert_says(&run, code, &[text]);
        // What has begun can be gone on with; without a first answer nothing has.
        assert_eq!(root.path().join("out").exists(), script.starts_with(&*hello), "{run:?}");
    }
}

/// A relative path would be another program in every folder, also in one that somebody else filled.
#[cfg(unix)]
#[test]
fn no_interpreter_of_the_working_folder_is_run() {
    use std::os::unix::fs::PermissionsExt as _;

    let root = folder(&small("[]").replace("[coverage,", "[depth_mae_mm, coverage,"));
    for name in ["python3", "prusa-slicer"] {
        let program = root.path().join(name);
        fs::write(&program, "#!/bin/sh\ntouch was-run\n").unwrap();
        fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
    }
    let bench = &["bench", "rtac0", "-o", "bench"][..];
    let sweep = &["sweep", "sweep.yaml", "-o", "out"];
    let slice = &["guide", "9dtact/coupon", "--slice", "-o", "guide"];
    for (words, variable, value, says) in [
        (
            bench,
            "FABKIT_PYTHON",
            "./python3",
            "error: the interpreter ./python3 is no absolute path",
        ),
        (bench, "PATH", ".", "error: python3 cannot run the bench"),
        (sweep, "FABKIT_PYTHON", "python3", "error: the interpreter python3 is no absolute path"),
        (sweep, "PATH", "", "error: python3 cannot run the bench"),
        (slice, "FABKIT_SLICER", "./prusa-slicer", "prusa-slicer"),
        (slice, "PATH", ".", "slicer"),
    ] {
        let mut command = command(root.path());
        command.args(words).env_remove("FABKIT_PYTHON").env(variable, value);
        let run = Run::from(command.output().unwrap());
        assert_eq!(run.code, Some(2), "{words:?} {variable}={value}: {run:?}");
        assert!(run.stderr.contains(says), "{run:?}");
        assert!(!root.path().join("was-run").exists(), "{words:?} {variable}={value}");
    }
}
