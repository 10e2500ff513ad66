//! Captures of pins as a lab has them: a folder of pictures, which holes had pins, and the picture without contact.

mod error;
pub mod pictures;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use fabkit_picture::{ENDINGS, is_named_as_one};

use crate::assignment::{Mark, MarkedCapture};
use crate::captures::{self, ListedPin};
use crate::landmarks::{PinLandmark, PinLandmarks};
use crate::pins::DetectionOptions;
use crate::report::CaptureRecord;

pub use error::{OTHER_CAMERA, PinCaptureError};
use fabkit_files::Error;
use fabkit_files::listing;
use fabkit_files::reading::{self, Expected, natural_order};

/// Most pictures in a folder.
pub const MAX_PICTURES: usize = 10_000;
/// Names under which the picture without contact is looked for.
const REFERENCES: [&str; 2] = ["ref", "reference"];
/// Kinds of pin that an error names.
const NAMED: usize = 8;
/// Name of the list of captures.
pub const LIST: &str = "captures.csv";

/// What a folder of captures holds.
#[derive(Clone, Debug, Default)]
pub struct PinCaptures<'a> {
    /// For reports.
    pub records: Vec<CaptureRecord>,
    /// For the solver, in the same order.
    pub marked: Vec<MarkedCapture<'a>>,
    /// Where the pictures are, if marks were found in pictures.
    pub folder: Option<PathBuf>,
    /// Whether all marks were found in pictures here; else they are whatever somebody took for pins.
    pub is_detected: bool,
    /// The largest share of what is lit that is saturated in a picture, 0 to 1.
    pub saturated: f64,
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
) -> Result<PinCaptures<'a>, Error> {
    let (planned, reference) = planned(folder, reference, landmarks, kind)?;
    let seen: Vec<PathBuf> =
        planned.iter().filter(|c| c.marks.is_none()).map(|c| folder.join(&c.file)).collect();
    let mut detections = Vec::new();
    if !seen.is_empty() {
        let Some(reference) = reference else {
            return Err(PinCaptureError::NoReference { folder: folder.into() }.into());
        };
        detections = pictures::detect_all(&reference, &seen, &DetectionOptions::default())?;
    }
    let saturated = detections.iter().map(|found| found.saturated).fold(0.0, f64::max);
    let mut detections = detections.into_iter();
    let is_detected = planned.iter().all(|capture| capture.marks.is_none());
    let folder = Some(folder.into());
    let mut captures = PinCaptures { is_detected, folder, saturated, ..PinCaptures::default() };
    for Planned { file, pins, labelled, marks } in planned {
        let detected = || {
            let marks = detections.next().map(|detection| detection.marks).unwrap_or_default();
            marks.iter().map(|m| Mark { pixel: m.pixel, sigma_px: m.sigma_px }).collect()
        };
        let marks: Vec<Mark> = marks.unwrap_or_else(detected);
        captures.add(file, MarkedCapture { marks, pins, labelled });
    }
    Ok(captures)
}

/// The pins of each capture of a folder, by their places among the landmarks; pictures are not looked at.
///
/// # Errors
/// As for [`read`], but for what is wrong with pictures; captures that do not say which pins they show.
pub fn pressed(
    folder: &Path,
    landmarks: &PinLandmarks,
    kind: Option<&str>,
) -> Result<Vec<Vec<usize>>, Error> {
    let (planned, _) = planned(folder, None, landmarks, kind)?;
    let unlabelled = |capture: &&Planned<'_>| !capture.labelled;
    if let Some(capture) = planned.iter().find(unlabelled) {
        return Err(PinCaptureError::Unlabelled { file: capture.file.clone() }.into());
    }
    let place = |pin: &&PinLandmark| landmarks.pins.iter().position(|found| found == *pin);
    Ok(planned.iter().map(|capture| capture.pins.iter().filter_map(place).collect()).collect())
}

/// What a folder holds, and the picture without contact, if it is there.
fn planned<'a>(
    folder: &Path,
    reference: Option<&Path>,
    landmarks: &'a PinLandmarks,
    kind: Option<&str>,
) -> Result<(Vec<Planned<'a>>, Option<PathBuf>), Error> {
    let files = pictures_in(folder)?;
    let list = list_in(folder)?;
    let reference = match reference {
        Some(path) => Some(path.to_owned()),
        None => REFERENCES
            .iter()
            .flat_map(|name| ENDINGS.map(|end| folder.join(format!("{name}.{end}"))))
            .find(|path| path.is_file()),
    };
    let reference_name = reference.as_ref().and_then(|path| path.file_name()?.to_str());
    let pictures = || files.iter().filter(|file| Some(file.as_str()) != reference_name);
    let choose = Choose { landmarks, kind };
    let is_open = || pictures().any(|file| choose.kinds_in(file).is_none());
    if list.is_empty() && kind.is_none() && landmarks.kinds().len() > 1 && is_open() {
        let kinds = names(landmarks);
        return Err(PinCaptureError::SeveralKinds { at: None, kinds }.into());
    }
    let mut planned = Vec::new();
    let mut wrong = Vec::new();
    let mut plan = |result: Result<Planned<'a>, Error>| match result {
        Ok(capture) => planned.push(capture),
        Err(error) => wrong.push(error),
    };
    if list.is_empty() {
        pictures().for_each(|file| plan(choose.by_name(file)));
    } else {
        for (file, pins) in &list {
            plan(choose.by_list(file, pins));
        }
    }
    if let Some(error) = Error::all(wrong) {
        return Err(error);
    }
    if planned.is_empty() {
        return Err(PinCaptureError::NoCaptures { folder: folder.into() }.into());
    }
    Ok((planned, reference))
}

/// A capture whose pins were found elsewhere.
#[derive(Clone, Debug)]
pub struct MeasuredCapture {
    /// What reports call it.
    pub name: String,
    /// The holes that had pins, if that is known.
    pub holes: Option<Vec<u32>>,
    /// Where pins are seen.
    pub marks: Vec<Mark>,
}

/// Captures whose pins were found elsewhere.
///
/// # Errors
/// Holes and kinds that the landmarks do not have, of all captures.
pub fn from_marks<'a>(
    given: Vec<MeasuredCapture>,
    landmarks: &'a PinLandmarks,
    kind: Option<&str>,
) -> Result<PinCaptures<'a>, Error> {
    let choose = Choose { landmarks, kind };
    let (mut captures, mut wrong) = (PinCaptures::default(), Vec::new());
    for MeasuredCapture { name, holes, marks } in given {
        match choose.pins(&name, holes.as_deref()) {
            Err(error) => wrong.push(error.into()),
            Ok(pins) => {
                captures.add(name, MarkedCapture { marks, pins, labelled: holes.is_some() })
            }
        }
    }
    Error::all(wrong).map_or(Ok(captures), Err)
}

impl<'a> PinCaptures<'a> {
    fn add(&mut self, file: String, marked: MarkedCapture<'a>) {
        let pins_expected = marked.labelled.then_some(marked.pins.len());
        let pins_found = marked.marks.len();
        self.records.push(CaptureRecord { file, pins_expected, pins_found });
        self.marked.push(marked);
    }
}

/// Finds the pins that a label means.
#[derive(Clone, Copy, Debug)]
struct Choose<'a, 'k> {
    /// All pins.
    landmarks: &'a PinLandmarks,
    /// The kind used, where a label does not say.
    kind: Option<&'k str>,
}

impl<'a> Choose<'a, '_> {
    /// The pin in a hole; it may not be there, or be one of several kinds.
    fn pin(
        &self,
        file: &str,
        hole: u32,
        kind: Option<&str>,
    ) -> Result<&'a PinLandmark, PinCaptureError> {
        let kind = kind.or(self.kind);
        self.landmarks.find(hole, kind).ok_or_else(|| {
            let (file, kinds) = (file.to_owned(), names(self.landmarks));
            let has_hole = self.landmarks.pins.iter().any(|pin| pin.hole == hole);
            match (kind.map(str::to_owned), has_hole) {
                (_, false) => PinCaptureError::NoHole { file, hole },
                (Some(kind), true) => PinCaptureError::NoSuchPin { file, hole, kind, kinds },
                (None, true) => PinCaptureError::SeveralKinds { at: Some((file, hole)), kinds },
            }
        })
    }

    /// The pins that a capture shows: those in its holes, or whichever of the kind.
    fn pins(
        &self,
        file: &str,
        holes: Option<&[u32]>,
    ) -> Result<Vec<&'a PinLandmark>, PinCaptureError> {
        let wanted = |pin: &&PinLandmark| self.kind.is_none_or(|kind| pin.kind == kind);
        match holes {
            Some(holes) => holes.iter().map(|hole| self.pin(file, *hole, None)).collect(),
            None => Ok(self.landmarks.pins.iter().filter(wanted).collect()),
        }
    }

    /// All pins of the kinds that a file is named after: `semi-dome-017`, or two halves with a `+` between them.
    fn kinds_in(&self, file: &str) -> Option<Vec<&'a PinLandmark>> {
        let pins_of = |kind: &str| -> Option<Vec<_>> {
            let pins =
                self.landmarks.pins.iter().filter(|pin| pin.kind == kind).collect::<Vec<_>>();
            Some(pins).filter(|pins| !pins.is_empty())
        };
        let of_each: Option<Vec<_>> = stem(file).split('+').map(pins_of).collect();
        of_each.map(|pins| pins.concat())
    }

    fn by_name(&self, file: &str) -> Result<Planned<'a>, Error> {
        if let Some(pins) = self.kinds_in(file) {
            // No complete label: many protrusions of a half have no mark, and too few do to tell how the camera is turned.
            return Ok(Planned { file: file.into(), pins, labelled: false, marks: None });
        }
        let stem = stem(file);
        let holes = captures::holes_from_name(stem);
        let (pins, labelled) = (self.pins(file, holes.as_deref())?, holes.is_some());
        Ok(Planned { file: file.into(), pins, labelled, marks: None })
    }

    fn by_list(&self, file: &str, listed: &[ListedPin]) -> Result<Planned<'a>, Error> {
        let pin = |p: &ListedPin| self.pin(file, p.hole, p.kind.as_deref());
        let pins = listed.iter().map(pin).collect::<Result<Vec<_>, _>>()?;
        let measured: Vec<Mark> = listed
            .iter()
            .filter_map(|p| p.pixel)
            .map(|(pixel, sigma_px)| Mark { pixel, sigma_px })
            .collect();
        if !measured.is_empty() && measured.len() < listed.len() {
            return Err(PinCaptureError::HalfMeasured { file: file.into() }.into());
        }
        let marks = (!measured.is_empty()).then_some(measured);
        Ok(Planned { file: file.into(), pins, labelled: true, marks })
    }
}

/// A file's name without its ending.
fn stem(file: &str) -> &str {
    Path::new(file).file_stem().and_then(|stem| stem.to_str()).unwrap_or_default()
}

/// Kinds of pin; the first of them where there are as many as a set has halves.
fn names(landmarks: &PinLandmarks) -> String {
    let kinds = landmarks.kinds();
    let first = kinds.iter().take(NAMED).copied().collect::<Vec<_>>().join(", ");
    match kinds.len().saturating_sub(NAMED) {
        0 => first,
        more => format!("{first} and {more} more"),
    }
}

/// The pictures of a folder but the one without contact, in natural order.
///
/// # Errors
/// A folder that cannot be read, holds too many pictures or none.
pub fn pictures_of(folder: &Path, reference: &Path) -> Result<Vec<PathBuf>, Error> {
    let is_reference = |path: &PathBuf| same_file(path, reference);
    let all = pictures_in(folder)?.into_iter().map(|name| folder.join(name));
    let captures: Vec<PathBuf> = all.filter(|path| !is_reference(path)).collect();
    if captures.is_empty() {
        return Err(PinCaptureError::NoCaptures { folder: folder.into() }.into());
    }
    Ok(captures)
}

/// Whether two paths name one file.
fn same_file(a: &Path, b: &Path) -> bool {
    listing::real_path(a) == listing::real_path(b)
}

fn pictures_in(folder: &Path) -> Result<Vec<String>, PinCaptureError> {
    let unreadable = |source| PinCaptureError::Folder { folder: folder.into(), source };
    let mut files = Vec::new();
    for entry in listing::entries(folder).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?;
        // Names that are not UTF-8 hold no label either.
        if entry.is_utf8() && is_named_as_one(&entry.name) {
            files.push(entry.name);
        }
        if files.len() > MAX_PICTURES {
            return Err(PinCaptureError::TooManyPictures { folder: folder.into() });
        }
    }
    files.sort_by(|a, b| natural_order(a, b));
    Ok(files)
}

fn list_in(folder: &Path) -> Result<BTreeMap<String, Vec<ListedPin>>, Error> {
    let path = folder.join(LIST);
    if !path.is_file() {
        return Ok(BTreeMap::new());
    }
    let expected = Expected {
        what: "a list of captures",
        max_bytes: captures::MAX_BYTES as u64,
        hint: "it has one row for each pin",
    };
    let text = reading::read_text(&path, expected)?;
    captures::read_list(&text).map_err(|source| PinCaptureError::List { file: path, source }.into())
}
