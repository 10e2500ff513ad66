//! A folder of captures: pictures, which holes had pins, and the picture without contact.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use fabkit::calibration::assignment::{Mark, MarkedCapture};
use fabkit::calibration::captures::{self, ListedPin};
use fabkit::calibration::landmarks::{PinLandmark, PinLandmarks};
use fabkit::calibration::pins::DetectionOptions;
use fabkit::calibration::report::CaptureRecord;

use super::pictures;
use crate::failure::{Exit, Failure};
use crate::reading::{self, Expected};

/// Most pictures in a folder.
const MAX_PICTURES: usize = 10_000;
/// Names under which the picture without contact is looked for.
const REFERENCES: [&str; 2] = ["ref.png", "reference.png"];
/// Name of the list of captures.
const LIST: &str = "captures.csv";

/// What a folder of captures holds.
#[derive(Clone, Debug, Default)]
pub struct Captures<'a> {
    /// For reports.
    pub records: Vec<CaptureRecord>,
    /// For the solver, in the same order.
    pub marked: Vec<MarkedCapture<'a>>,
}

/// One capture before its picture is looked at.
struct Planned<'a> {
    file: String,
    pins: Vec<&'a PinLandmark>,
    labelled: bool,
    /// Measured by hand; then there is no need for a picture.
    marks: Option<Vec<Mark>>,
}

/// Reads a folder.
///
/// Which holes had pins is said by `captures.csv` in the folder, or else by a picture's name; a
/// picture whose name says nothing may show any pins.
///
/// # Errors
/// A folder that cannot be read or holds no captures, a missing reference, holes that the landmarks
/// do not have, pictures that cannot be used; all of a kind at once.
pub fn read<'a>(
    folder: &Path,
    reference: Option<&Path>,
    landmarks: &'a PinLandmarks,
    kind: Option<&str>,
) -> Result<Captures<'a>, Failure> {
    let files = pictures_in(folder)?;
    let list = list_in(folder)?;
    let reference = match reference {
        Some(path) => Some(path.to_owned()),
        None => REFERENCES.iter().map(|name| folder.join(name)).find(|path| path.is_file()),
    };
    let reference_name = reference.as_ref().and_then(|path| path.file_name()?.to_str());
    if list.is_empty() && kind.is_none() && landmarks.kinds().len() > 1 {
        let kinds = landmarks.kinds().join(", ");
        return Err(several_kinds(format!("the landmarks have several kinds of pin: {kinds}")));
    }
    let mut planned = Vec::new();
    let mut wrong = Vec::new();
    let mut plan = |result: Result<Planned<'a>, Failure>| match result {
        Ok(capture) => planned.push(capture),
        Err(failure) => wrong.push(failure),
    };
    let choose = Choose { landmarks, kind };
    if list.is_empty() {
        for file in files.iter().filter(|file| Some(file.as_str()) != reference_name) {
            plan(choose.by_name(file));
        }
    } else {
        for (file, pins) in &list {
            plan(choose.by_list(file, pins));
        }
    }
    if let Some(failure) = Failure::all(wrong) {
        return Err(failure);
    }
    if planned.is_empty() {
        let message = format!("{} holds no captures", folder.display());
        let hint = "captures are PNG files, named after their holes as in 01_05_08.png";
        return Err(Failure::new(Exit::BadInput, message, hint));
    }
    let seen: Vec<PathBuf> =
        planned.iter().filter(|c| c.marks.is_none()).map(|c| folder.join(&c.file)).collect();
    let mut detections = Vec::new();
    if !seen.is_empty() {
        let Some(reference) = reference else {
            let message = format!("{} has no picture without contact", folder.display());
            let hint = "save one there as ref.png, or name it with --reference";
            return Err(Failure::new(Exit::BadInput, message, hint));
        };
        detections = pictures::detect_all(&reference, &seen, &DetectionOptions::default())?;
    }
    let mut detections = detections.into_iter();
    let (mut records, mut marked) = (Vec::new(), Vec::new());
    for Planned { file, pins, labelled, marks } in planned {
        let detected = || {
            let marks = detections.next().map(|detection| detection.marks).unwrap_or_default();
            marks.iter().map(|m| Mark { pixel: m.pixel, sigma_px: m.sigma_px }).collect()
        };
        let marks: Vec<Mark> = marks.unwrap_or_else(detected);
        let pins_expected = labelled.then_some(pins.len());
        records.push(CaptureRecord { file, pins_expected, pins_found: marks.len() });
        marked.push(MarkedCapture { marks, pins, labelled });
    }
    Ok(Captures { records, marked })
}

/// Finds the pins that a label means.
#[derive(Clone, Copy, Debug)]
pub struct Choose<'a, 'k> {
    /// All pins.
    pub landmarks: &'a PinLandmarks,
    /// The kind used, where a label does not say.
    pub kind: Option<&'k str>,
}

impl<'a> Choose<'a, '_> {
    /// The pin in a hole.
    ///
    /// # Errors
    /// A hole or a kind that the landmarks do not have; several kinds and no choice.
    pub fn pin(
        &self,
        file: &str,
        hole: u32,
        kind: Option<&str>,
    ) -> Result<&'a PinLandmark, Failure> {
        let kind = kind.or(self.kind);
        self.landmarks.find(hole, kind).ok_or_else(|| {
            let kinds = self.landmarks.kinds().join(", ");
            let has_hole = self.landmarks.pins.iter().any(|pin| pin.hole == hole);
            match (kind, has_hole) {
                (_, false) => Failure::plain(
                    Exit::BadInput,
                    format!("{file}: the landmarks have no hole {hole}"),
                ),
                (Some(kind), true) => Failure::new(
                    Exit::BadInput,
                    format!("{file}: hole {hole} has no pin of kind `{kind}`"),
                    format!("its kinds are: {kinds}"),
                ),
                (None, true) => several_kinds(format!(
                    "{file}: there are several kinds of pin for hole {hole}: {kinds}"
                )),
            }
        })
    }

    fn by_name(&self, file: &str) -> Result<Planned<'a>, Failure> {
        let stem = Path::new(file).file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        let holes = captures::holes_from_name(stem);
        let labelled = holes.is_some();
        let pins = match holes {
            Some(holes) => {
                holes.iter().map(|h| self.pin(file, *h, None)).collect::<Result<_, _>>()?
            }
            None => {
                let wanted = |pin: &&PinLandmark| self.kind.is_none_or(|kind| pin.kind == kind);
                self.landmarks.pins.iter().filter(wanted).collect()
            }
        };
        Ok(Planned { file: file.into(), pins, labelled, marks: None })
    }

    fn by_list(&self, file: &str, listed: &[ListedPin]) -> Result<Planned<'a>, Failure> {
        let pin = |p: &ListedPin| self.pin(file, p.hole, p.kind.as_deref());
        let pins = listed.iter().map(pin).collect::<Result<Vec<_>, _>>()?;
        let measured: Vec<Mark> = listed
            .iter()
            .filter_map(|p| p.pixel)
            .map(|(pixel, sigma_px)| Mark { pixel, sigma_px })
            .collect();
        if !measured.is_empty() && measured.len() < listed.len() {
            let message = format!("{file}: some pins have a pixel and some have none");
            return Err(Failure::plain(Exit::BadInput, message));
        }
        let marks = (!measured.is_empty()).then_some(measured);
        Ok(Planned { file: file.into(), pins, labelled: true, marks })
    }
}

fn several_kinds(message: String) -> Failure {
    let hint = format!("say which was used with --pin, or in the column `kind` of {LIST}");
    Failure::new(Exit::BadInput, message, hint)
}

fn pictures_in(folder: &Path) -> Result<Vec<String>, Failure> {
    let unreadable = |error: std::io::Error| {
        Failure::plain(Exit::BadInput, format!("cannot read {}: {error}", folder.display()))
    };
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).map_err(unreadable)? {
        let name = entry.map_err(unreadable)?.file_name();
        // Names that are not UTF-8 hold no label either.
        let Some(name) = name.to_str() else { continue };
        if name.to_ascii_lowercase().ends_with(".png") {
            files.push(name.to_owned());
        }
        if files.len() > MAX_PICTURES {
            let message = format!("{} holds more than {MAX_PICTURES} pictures", folder.display());
            return Err(Failure::plain(Exit::Limit, message));
        }
    }
    files.sort();
    Ok(files)
}

fn list_in(folder: &Path) -> Result<BTreeMap<String, Vec<ListedPin>>, Failure> {
    let path = folder.join(LIST);
    if !path.is_file() {
        return Ok(BTreeMap::new());
    }
    let expected = Expected {
        what: "a list of captures",
        max_bytes: captures::MAX_BYTES as u64,
        hint: "it has one row for each pin",
    };
    let text = reading::text(&path, expected)?;
    captures::read_list(&text)
        .map_err(|error| Failure::plain(Exit::BadInput, format!("{}: {error}", path.display())))
}
