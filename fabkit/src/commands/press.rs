//! `fabkit press SENSOR --indenter NAME@PLACE --depth LENGTH`

use std::path::PathBuf;

use fabkit_application::Error;
use fabkit_application::export::{npz, png};
use fabkit_application::pressing::{
    Level, Pressed, Pressing, PressingError, SoftLayer, arrays, curve_csv, curve_svg, document,
    picture, threads,
};
use fabkit_application::scene::press_error;
use fabkit_application::source::{Source, Target};
use fabkit_application::staging::write_each;
use serde_json::{Value, json};

use super::Outcome;
use crate::cli::{ContactLevel, PressArgs};
use crate::failure::{ErrorKind, Failure};
use crate::interrupt;
use crate::roles::Roles;
use crate::table::size;

pub(super) fn run(args: &PressArgs) -> Result<Outcome, Failure> {
    Roles::default()
        .reads("SENSOR", Target::new(&args.design.sensor).files())
        .writes("-o", &args.output)
        .writes("--csv", &args.csv)
        .writes("--plot", &args.plot)
        .writes("--png", &args.png)
        .check()?;
    let target = Target::new(&args.design.sensor);
    if let Some(name) = target.fixture.or(target.part) {
        let message = format!("a whole sensor is pressed, not its {name}");
        let hint = format!("write `{}`; what presses is named with --indenter", target.sensor);
        return Err(Failure::new(ErrorKind::BadInput, message, hint));
    }
    let project = Source::find(target.sensor)?.load(&args.design.set)?;
    let pressing = Pressing {
        indenter: &args.indenter,
        depth_mm: args.depth,
        level: match args.contact {
            ContactLevel::Linear => Level::Linear,
            ContactLevel::Finite => Level::Finite,
        },
        steps: args.steps,
        shear_mm: args.shear,
        friction: args.friction,
        spacing_mm: args.spacing,
        threads: threads(),
    };
    let pressed = pressing.run(&project).map_err(|error| match error {
        PressingError::Press(error) => press_error(&args.design.sensor, error),
        other => Error::from(other),
    })?;

    let mut files: Vec<(PathBuf, Vec<u8>)> = Vec::new();
    if let Some(path) = &args.output {
        files.push((path.clone(), npz(&arrays(&pressed)).map_err(Failure::bug)?));
    }
    if let Some(path) = &args.csv {
        files.push((path.clone(), curve_csv(&pressed).into_bytes()));
    }
    if let Some(path) = &args.plot {
        files.push((path.clone(), curve_svg(&pressed).into_bytes()));
    }
    if let Some(path) = &args.png {
        let shown = picture(&pressed);
        let bytes = png(shown.width_px, shown.height_px, &shown.rgb).map_err(Failure::bug)?;
        files.push((path.clone(), bytes));
    }
    interrupt::begin_writing()?;
    write_each(
        files.iter().map(|(path, bytes)| (path.clone(), &bytes[..])),
        &interrupt::requested,
    )?;
    let listed: Vec<Value> = files
        .iter()
        .map(|(path, bytes)| json!({ "file": path.display().to_string(), "bytes": bytes.len() }))
        .collect();
    let mut text = text(&pressed);
    for (path, bytes) in &files {
        text += &format!("{}: {}\n", path.display(), size(bytes.len() as u64));
    }
    let mut json = document(&pressed);
    json["files"] = json!(listed);
    Ok(Outcome { text, json, failed: false })
}

fn text(pressed: &Pressed) -> String {
    let mut text = format!("{}, {} (simulated)\n", pressed.id, pressed.level.name());
    for SoftLayer { name, material, thickness_mm, elasticity } in &pressed.soft.layers {
        let [least, most] = elasticity.young_range_mpa;
        text += &format!(
            "  {name}, {thickness_mm:.2} mm of {material}: E {:.3} MPa ({least:.3} to {most:.3}), nu {}; {}\n",
            elasticity.young_mpa, elasticity.poissons_ratio, elasticity.source
        );
    }
    for left_out in &pressed.soft.left_out {
        text += &format!("  left out: {left_out}\n");
    }
    text += "depth mm  along mm  force N  contact radius mm  pressed in mm  bulge mm\n";
    for step in &pressed.steps {
        text += &format!(
            "{:8.3}  {:8.3}  {:7.3}  {:17.2}  {:13.3}  {:8.3}\n",
            step.depth_mm,
            step.shear_mm,
            step.force_n.norm(),
            step.contact_radius_mm,
            step.max_indentation_mm,
            step.bulge_mm
        );
    }
    if let Some(warning) = pressed.warning() {
        text += &format!("warning: {warning}\n");
    }
    let [low, high] = pressed.force_range_n();
    text += &format!(
        "{:.2} N/mm at the end; for the least and the most that is known of the moduli {low:.2} to {high:.2} N\n",
        pressed.stiffness_n_mm()
    );
    text
}
