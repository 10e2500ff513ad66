//! Text labels on printed parts, placed by a rule that knows nothing of families: on the first flat or nearly flat face
//! that has room, that nothing else touches and that is thick enough. Where the name does not fit, first the letters
//! get smaller, then the name is shortened.

mod abbreviations;
mod face;

use fabkit_geometry::{Body, CompiledSolid, Length, Pose, Process, Sensor, Solid, has_lettering};

use crate::blocks::label::{Label, LabelError};
use crate::parameters::{RuleReport, suggestion, to_printable};
use crate::{choices, parameters};
use face::{FaceSearch, LabelPlace, MARGIN_MM};

choices! {
    /// Style of text on printed parts.
    pub enum LabelStyle {
        /// No text.
        None = "none",
        /// Raised text.
        Raised = "raised",
        /// Sunken text, cut into the part.
        Sunken = "sunken",
    }
}

parameters! {
    /// Text on printed parts.
    pub struct Labels {
        /// Style of the text: `raised`, `sunken` (cut in) or `none`.
        style: LabelStyle,
        /// Names of the printed parts with text; `all` for every part that has room.
        parts: Vec<String> = (1..=100, 1..=64),
        /// Text to write; if empty, the part's name, shortened where necessary.
        text: String = 0..=40,
        /// Height of the letters; lower where there is less room.
        height: Length = 2.0..=30.0,
        /// Depth of sunken letters, or height of raised ones above the face.
        depth: Length = 0.2..=2.0,
    }
}

/// Key of the section in the files of every family.
pub const KEY: &str = "labels";

/// Summary of the section.
pub const SUMMARY: &str = "Text on printed parts.";

/// Default values: file name for messages, and YAML text.
pub const DEFAULTS: (&str, &str) = ("labels.yaml (defaults)", include_str!("labels.yaml"));

/// Beginning of the note that explains why a part carries no label.
const NO_LABEL_NOTE: &str = "carries no label: ";

/// Keyword that selects every part.
const ALL: &str = "all";

impl Labels {
    /// Returns whether every part that has room is labelled, including those of fixtures.
    pub(crate) fn selects_all(&self) -> bool {
        self.parts.iter().any(|name| name == ALL)
    }
}

/// Returns the smallest legible letter height, mm: for filament from a 0.4 mm nozzle, where strokes are as wide as its
/// lines, and for resin, where the makers' guides ask for details of 0.15 mm (Formlabs) to 0.5 mm (Stratasys).
fn min_height_mm(process: Option<Process>) -> f64 {
    if process == Some(Process::Fdm) { 3.0 } else { 2.5 }
}

/// Returns the letter heights to try, in this order, mm: the requested one, then lower ones.
fn heights_mm(asked_mm: f64, process: Option<Process>) -> impl Iterator<Item = f64> {
    let least_mm = min_height_mm(process);
    let steps = [1.0, 0.75, 0.5].map(|part| (part * asked_mm).max(least_mm).min(asked_mm));
    // Near the smallest height, several steps may be clamped to the same value.
    let is_new = move |i: usize| i == 0 || steps[i] < steps[i - 1];
    (0..steps.len()).filter(move |i| is_new(*i)).map(move |i| steps[i])
}

/// Adds text to the parts that `labels` selects. Returns the names of the labelled parts; reports a part that is named
/// but cannot be labelled.
pub(crate) fn apply(labels: &Labels, sensor: &mut Sensor, report: &mut RuleReport) -> Vec<String> {
    if labels.style == LabelStyle::None {
        return Vec::new();
    }
    let printed: Vec<String> =
        sensor.bodies.iter().filter(|body| is_printed(body)).map(|b| b.name.clone()).collect();
    let is_all = labels.selects_all();
    // Every name that is no printed part is reported.
    for name in labels.parts.iter().filter(|name| *name != ALL && !printed.contains(name)) {
        report.require(
            false,
            "labels.parts",
            || format!("labels.parts: `{}` is not a printed part", to_printable(name)),
            || suggestion(name, printed.iter().map(String::as_str), "the printed parts are"),
        );
    }
    let compiled: Vec<Option<CompiledSolid>> =
        sensor.bodies.iter().map(|body| CompiledSolid::new(&body.solid).ok()).collect();
    let mut written: Vec<(usize, String, Label)> = Vec::new();
    let mut bare: Vec<(usize, String)> = Vec::new();
    for (i, body) in sensor.bodies.iter().enumerate() {
        let is_named = labels.parts.contains(&body.name);
        let Some(own) = compiled[i].as_ref() else { continue };
        let stays_bare = body.notes.iter().any(|note| note.starts_with(NO_LABEL_NOTE));
        let is_asked = printed.contains(&body.name) && (is_named || is_all);
        if !is_asked || stays_bare || has_lettering(&body.solid) {
            continue;
        }
        if let Some(first) = labelled_partner(sensor, body) {
            bare.push((i, format!("it leaves the printer in one piece with {first}")));
            continue;
        }
        let sunken_mm = (labels.style == LabelStyle::Sunken).then(|| labels.depth.mm());
        let faces = FaceSearch::new(body, own, sensor, &compiled, sunken_mm);
        match place_label(labels, body, faces, &printed) {
            Ok(Some((text, label))) => written.push((i, text, label)),
            Ok(None) if is_named => report_no_face(labels, body, report),
            Ok(None) => {
                let least_mm = min_height_mm(body.process());
                let why = format!("no free face has room for letters {least_mm} mm high");
                bare.push((i, why));
            }
            Err(why) => {
                // The letters are the problem, not the face, so no other part is tried.
                let (path, hint) = match why {
                    LabelError::Low(_) => ("labels.height", "write higher letters"),
                    _ => ("labels.text", "write other letters"),
                };
                report.require(false, path, || format!("{path}: {why}"), || hint.into());
                return Vec::new();
            }
        }
    }
    drop(compiled);
    for (i, why) in bare {
        sensor.bodies[i].notes.push(format!("{NO_LABEL_NOTE}{why}"));
    }
    let mut names = Vec::new();
    for (i, text, label) in written {
        let body = &mut sensor.bodies[i];
        names.push(body.name.clone());
        // A note is needed only where the label differs from the part's name.
        if !text.eq_ignore_ascii_case(&body.name) {
            body.notes.push(format!("labelled {}", text.to_ascii_uppercase()));
        }
        match labels.style {
            LabelStyle::Sunken => *body = body.clone().cut(label.sunken()),
            _ => body.solid = Solid::union([body.solid.clone(), label.raised()]),
        }
    }
    names
}

/// Returns whether a body is made by a printing process.
fn is_printed(body: &Body) -> bool {
    body.is_made() && matches!(body.process(), Some(Process::Fdm | Process::Sla | Process::PolyJet))
}

/// Returns the part that carries the label of the group that `body` is printed with in one piece, if that is another
/// part.
fn labelled_partner<'a>(sensor: &'a Sensor, body: &Body) -> Option<&'a str> {
    let group = sensor.print_groups.iter().find(|group| group.parts.contains(&body.name))?;
    // The last part of a group is the stiff one. Letters go there: the others are soft or covered.
    let first = group.parts.last()?;
    (*first != body.name).then_some(first.as_str())
}

/// Finds the text of a part and its place: the longest text in the largest letters for which a face has room.
fn place_label(
    labels: &Labels,
    body: &Body,
    mut faces: FaceSearch,
    names: &[String],
) -> Result<Option<(String, Label)>, LabelError> {
    let texts = match labels.text.trim() {
        "" => abbreviations::label_texts(&body.name, names),
        text => vec![text.to_owned()],
    };
    for text in texts {
        for height_mm in heights_mm(labels.height.mm(), body.process()) {
            let label = Label::new(&text, height_mm, Pose::identity())?;
            if let Some(LabelPlace { pose, fall_mm }) = faces.find(label.size_mm()) {
                let label = label.with_depth(labels.depth.mm() + fall_mm)?.at(pose);
                return Ok(Some((text, label)));
            }
        }
    }
    Ok(None)
}

/// Reports that no face of a named part has room for its label.
fn report_no_face(labels: &Labels, body: &Body, report: &mut RuleReport) {
    let text = if labels.text.trim().is_empty() { &body.name } else { &labels.text };
    let size = Label::new(text, labels.height.mm(), Pose::identity()).map(|label| label.size_mm());
    let [width, height] = size.unwrap_or_default().map(|mm| mm + 2.0 * MARGIN_MM);
    report.require(
        false,
        "labels.parts",
        || {
            format!(
                "labels.parts: {} has no free flat face of {width:.1} x {height:.1} mm, which `{text}` \
                 takes, nor one for less",
                body.name
            )
        },
        || {
            "write a shorter `labels.text` or a smaller `labels.height`, or leave the part out".into()
        },
    );
}
