//! `fabkit press SENSOR --indenter NAME@PLACE --depth LENGTH`

use fabkit_application::Error;
use fabkit_application::depth::RenderedImage;
use fabkit_application::export::{NpyArray, npz, png};
use fabkit_application::press_simulation::{
    MarkerDisplacement, PressRequest, PressResult, PressingError, SkinPressResult, SkinStep,
    SoftLayer, StrainTheory, curve_csv, curve_svg, draw_displacement, farthest_marker,
    press_arrays, press_document, skin_arrays, skin_csv, skin_document, skin_svg,
};
use fabkit_application::source::convert_press_error;
use fabkit_application::source::{Source, Target};
use serde_json::Value;

use super::Outcome;
use super::files::Files;
use crate::cli::PressArgs;
use crate::failure::{ErrorKind, Failure};
use crate::roles::FileRoles;

pub(super) fn run(args: &PressArgs) -> Result<Outcome, Failure> {
    FileRoles::default()
        .reads("SENSOR", Target::new(&args.design.sensor).files())
        .writes("-o", &args.output)
        .writes("--csv", &args.csv)
        .writes("--plot", &args.plot)
        .writes("--png", &args.png)
        .check()?;
    let target = Target::new(&args.design.sensor);
    if let Some(name) = target.fixture.or(target.part) {
        let message = format!("only a whole sensor can be pressed, not its {name}");
        let hint = format!("write `{}`, and name the indenter with --indenter", target.sensor);
        return Err(Failure::new(ErrorKind::BadInput, message, hint));
    }
    let project = Source::find(target.sensor)?.load(&args.design.set)?;
    let pressing = args.options.pressing(&args.indenter, args.depth).map_err(Error::from)?;
    let explained = |error| match error {
        PressingError::Press(error) => convert_press_error(&args.design.sensor, error),
        other => Error::from(other),
    };
    let told = if PressRequest::is_on_skin(&project.design.sensor) {
        PressReport::from_skin_press(&pressing.run_on_skin(&project).map_err(explained)?)
    } else {
        PressReport::from_press(&pressing.run(&project).map_err(explained)?, args.png.is_some())
    };
    let files = told.files(args)?;
    files.write()?;
    let mut json = told.json;
    json["files"] = files.json();
    Ok(Outcome { text: told.text + &files.text(), json, failed: false })
}

/// All representations of a press.
struct PressReport {
    arrays: Vec<NpyArray>,
    csv: String,
    svg: String,
    text: String,
    json: Value,
    image: Option<RenderedImage>,
}

impl PressReport {
    fn from_press(pressed: &PressResult, is_drawn: bool) -> Self {
        Self {
            arrays: press_arrays(pressed),
            csv: curve_csv(pressed),
            svg: curve_svg(pressed),
            text: text(pressed),
            json: press_document(pressed),
            image: is_drawn.then(|| draw_displacement(pressed)),
        }
    }

    fn from_skin_press(pressed: &SkinPressResult) -> Self {
        Self {
            arrays: skin_arrays(pressed),
            csv: skin_csv(pressed),
            svg: skin_svg(pressed),
            text: skin_text(pressed),
            json: skin_document(pressed),
            image: None,
        }
    }

    /// Encodes the requested files.
    fn files(&self, args: &PressArgs) -> Result<Files, Failure> {
        let mut files = Files::default();
        if let Some(path) = &args.output {
            files.add(path, npz(&self.arrays).map_err(Failure::bug)?);
        }
        if let Some(path) = &args.csv {
            files.add(path, self.csv.clone().into_bytes());
        }
        if let Some(path) = &args.plot {
            files.add(path, self.svg.clone().into_bytes());
        }
        if let Some(path) = &args.png {
            let Some(shown) = &self.image else {
                let message = "a skin with channels of liquid has no image of its surface";
                let hint = "take --plot, or the field with -o";
                return Err(Failure::new(ErrorKind::BadInput, message, hint));
            };
            let bytes = png(shown.width_px, shown.height_px, &shown.rgb).map_err(Failure::bug)?;
            files.add(path, bytes);
        }
        Ok(files)
    }
}

/// Formats the press, its layers and the simplifications.
fn heading(id: &str, level: StrainTheory, layers: &[SoftLayer], left_out: &[String]) -> String {
    let mut text = format!("{id}, {} (simulated)\n", level.name());
    for SoftLayer { name, material, thickness_mm, elasticity } in layers {
        let [least, most] = elasticity.young_range_mpa;
        text += &format!(
            "  {name}, {thickness_mm:.2} mm of {material}: E {:.3} MPa ({least:.3} to {most:.3}), nu {}; {}\n",
            elasticity.young_mpa, elasticity.poissons_ratio, elasticity.source
        );
    }
    for left_out in left_out {
        text += &format!("  left out: {left_out}\n");
    }
    text
}

/// Formats the movement of the markers.
fn marks_text(marks: &[MarkerDisplacement]) -> String {
    let Some((name, mm)) = farthest_marker(marks) else { return String::new() };
    let unknown = marks.iter().filter(|moved| moved.displacement_mm.is_none()).count();
    let beyond = match unknown {
        0 => String::new(),
        count => format!("; beyond the layers' end: {count}"),
    };
    format!("{} markers; `{name}` moves farthest, {mm:.3} mm{beyond}\n", marks.len())
}

fn skin_text(pressed: &SkinPressResult) -> String {
    let stack = &pressed.stack;
    let mut text =
        heading(&pressed.id, StrainTheory::Linear, &stack.layers, &stack.simplifications);
    text += "depth mm  force N  contact radius mm  indentation mm  bulge mm  sags mm\n";
    for SkinStep { depth_mm, outcome } in &pressed.steps {
        text += &format!(
            "{depth_mm:8.3}  {:7.3}  {:17.2}  {:14.3}  {:8.3}  {:7.3}\n",
            outcome.force_n.norm(),
            outcome.contact_radius_mm,
            outcome.max_indentation_mm,
            outcome.bulge_mm,
            outcome.sag_mm
        );
    }
    text += "channel     squeezed out mm3  column moves mm  pressure kPa  closes mm\n";
    for channel in pressed.last().into_iter().flat_map(|step| &step.outcome.channels) {
        text += &format!(
            "{:10}  {:16.3}  {:15.3}  {:12.3}  {:9.3}\n",
            channel.name,
            channel.volume_mm3,
            channel.column_displacement_mm,
            1e3 * channel.pressure_mpa,
            channel.closure_mm
        );
    }
    text += &marks_text(&pressed.marks);
    for warning in pressed.warnings() {
        text += &format!("warning: {warning}\n");
    }
    text
}

fn text(pressed: &PressResult) -> String {
    let soft = &pressed.soft;
    let mut text = heading(&pressed.id, pressed.level, &soft.layers, &soft.simplifications);
    text += "depth mm  along mm  force N  contact radius mm  indentation mm  bulge mm\n";
    for step in &pressed.steps {
        text += &format!(
            "{:8.3}  {:8.3}  {:7.3}  {:17.2}  {:14.3}  {:8.3}\n",
            step.depth_mm,
            step.shear_mm,
            step.force_n.norm(),
            step.contact_radius_mm,
            step.max_indentation_mm,
            step.bulge_mm
        );
    }
    text += &marks_text(&pressed.marks);
    if let Some(warning) = pressed.warning() {
        text += &format!("warning: {warning}\n");
    }
    let [low, high] = pressed.force_range_n();
    text += &format!(
        "stiffness at the end {:.2} N/mm; force {low:.2} to {high:.2} N for the lowest and highest known moduli\n",
        pressed.stiffness_n_mm()
    );
    text
}
