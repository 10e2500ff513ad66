//! Captures of pins in a lab's folder: images, the holes that had pins, and the image without contact.

mod error;
pub mod images;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use fabkit_image::{EXTENSIONS, has_image_extension};

use crate::assignment::{Mark, MarkedCapture};
use crate::captures::{self, ListedPin};
use crate::landmarks::{PinLandmark, PinLandmarks};
use crate::pin_detection::{DetectionOptions, PinMark};
use crate::report::CaptureRecord;
use crate::significance::LeftOut;

pub use error::{OTHER_CAMERA, PinCaptureError};
use fabkit_files::Error;
use fabkit_files::directory_listing;
use fabkit_files::reading::{self, ExpectedFile, compare_natural};

/// Largest number of images in a folder.
pub const MAX_IMAGES: usize = 10_000;
/// Names of the image without contact, without extension.
const REFERENCE_NAMES: [&str; 2] = ["ref", "reference"];
/// Largest number of kinds of pin that an error lists.
const MAX_NAMED_KINDS: usize = 8;
/// File name of the list of captures.
pub const LIST_FILE_NAME: &str = "captures.csv";

/// Captures of a folder.
#[derive(Clone, Debug, Default)]
pub struct PinCaptures<'a> {
    /// Records for reports.
    pub records: Vec<CaptureRecord>,
    /// Captures for the solver, in the order of `records`.
    pub marked: Vec<MarkedCapture<'a>>,
    /// Folder of the images, if marks were detected in images.
    pub folder: Option<PathBuf>,
    /// Width and height of the images, px, if marks were detected in images.
    pub size_px: Option<[u32; 2]>,
    /// True if all marks were detected in images here; otherwise they may be anything that somebody took for pins.
    pub is_detected: bool,
    /// Largest fraction of lit pixels that are saturated in an image, 0 to 1.
    pub saturated: f64,
}

/// Capture before its image is searched.
struct PlannedCapture<'a> {
    file: String,
    pins: Vec<&'a PinLandmark>,
    labelled: bool,
    /// Marks measured by hand; then no image is needed.
    marks: Option<Vec<Mark>>,
}

/// Reads a folder of captures and detects the marks in its images.
///
/// The holes that had pins are listed in `captures.csv` in the folder, or else named by an image's file name. An image
/// whose name says nothing may show any pins.
///
/// # Errors
/// Reports a folder that cannot be read or holds no captures, a missing reference, holes that the landmarks do not
/// have, images that cannot be used; all of a kind together.
pub fn read<'a>(
    folder: &Path,
    reference: Option<&Path>,
    landmarks: &'a PinLandmarks,
    kind: Option<&str>,
) -> Result<PinCaptures<'a>, Error> {
    let (planned, reference) = plan_captures(folder, reference, landmarks, kind)?;
    let seen: Vec<PathBuf> =
        planned.iter().filter(|c| c.marks.is_none()).map(|c| folder.join(&c.file)).collect();
    let (mut detections, mut size_px) = (Vec::new(), None);
    if !seen.is_empty() {
        let Some(reference) = reference else {
            return Err(PinCaptureError::NoReference { folder: folder.into() }.into());
        };
        detections = images::detect_all(&reference, &seen, &DetectionOptions::default())?;
        // All images have the size of the reference, else they are refused.
        size_px = Some(images::read_size_px(&reference)?);
    }
    let saturated = detections.iter().map(|found| found.saturated_fraction).fold(0.0, f64::max);
    let mut detections = detections.into_iter();
    let is_detected = planned.iter().all(|capture| capture.marks.is_none());
    let folder = Some(folder.into());
    let mut captures =
        PinCaptures { is_detected, folder, size_px, saturated, ..PinCaptures::default() };
    for PlannedCapture { file, pins, labelled, marks } in planned {
        let mut detected = || {
            let Some(detection) = detections.next() else {
                return (Vec::new(), LeftOut::default());
            };
            let (marks, left_out) = detection.marks.into_parts();
            let mark = |m: &PinMark| Mark { pixel: m.pixel, sigma_px: m.sigma_px };
            (marks.iter().map(mark).collect(), left_out)
        };
        let (marks, left_out) =
            marks.map_or_else(&mut detected, |marks| (marks, LeftOut::default()));
        captures.add(file, left_out, MarkedCapture { marks, pins, is_labelled: labelled });
    }
    Ok(captures)
}

/// Returns the pins of each capture of a folder, by their indices among the landmarks, without reading images.
///
/// # Errors
/// Fails as [`read`], except for problems with images, and for captures that do not say which pins they show.
pub fn pressed_pins(
    folder: &Path,
    landmarks: &PinLandmarks,
    kind: Option<&str>,
) -> Result<Vec<Vec<usize>>, Error> {
    let (planned, _) = plan_captures(folder, None, landmarks, kind)?;
    let unlabelled = |capture: &&PlannedCapture<'_>| !capture.labelled;
    if let Some(capture) = planned.iter().find(unlabelled) {
        return Err(PinCaptureError::Unlabelled { file: capture.file.clone() }.into());
    }
    let place = |pin: &&PinLandmark| landmarks.pins.iter().position(|found| found == *pin);
    Ok(planned.iter().map(|capture| capture.pins.iter().filter_map(place).collect()).collect())
}

/// Lists the captures of a folder, and finds the image without contact, if it exists.
fn plan_captures<'a>(
    folder: &Path,
    reference: Option<&Path>,
    landmarks: &'a PinLandmarks,
    kind: Option<&str>,
) -> Result<(Vec<PlannedCapture<'a>>, Option<PathBuf>), Error> {
    let files = image_names(folder)?;
    let list = read_capture_list(folder)?;
    let reference = match reference {
        Some(path) => Some(path.to_owned()),
        None => REFERENCE_NAMES
            .iter()
            .flat_map(|name| EXTENSIONS.map(|end| folder.join(format!("{name}.{end}"))))
            .find(|path| path.is_file()),
    };
    // The reference may lie in the same folder and is no capture.
    let reference_name = reference.as_ref().and_then(|path| path.file_name()?.to_str());
    let pictures = || files.iter().filter(|file| Some(file.as_str()) != reference_name);
    let choose = PinLookup { landmarks, kind };
    // True if some image's name does not tell the kind.
    let is_open = || pictures().any(|file| choose.pins_from_file_name(file).is_none());
    if list.is_empty() && kind.is_none() && landmarks.kinds().len() > 1 && is_open() {
        let kinds = names(landmarks);
        return Err(PinCaptureError::SeveralKinds { at: None, kinds }.into());
    }
    let mut planned = Vec::new();
    let mut wrong = Vec::new();
    let mut plan = |result: Result<PlannedCapture<'a>, Error>| match result {
        Ok(capture) => planned.push(capture),
        Err(error) => wrong.push(error),
    };
    if list.is_empty() {
        pictures().for_each(|file| plan(choose.capture_from_name(file)));
    } else {
        for (file, pins) in &list {
            plan(choose.capture_from_list(file, pins));
        }
    }
    if let Some(error) = Error::join(wrong) {
        return Err(error);
    }
    if planned.is_empty() {
        return Err(PinCaptureError::NoCaptures { folder: folder.into() }.into());
    }
    Ok((planned, reference))
}

/// Capture whose pins were detected elsewhere.
#[derive(Clone, Debug)]
pub struct MeasuredCapture {
    /// Name in reports.
    pub name: String,
    /// Holes that had pins, if known.
    pub holes: Option<Vec<u32>>,
    /// Marks of the pins.
    pub marks: Vec<Mark>,
}

/// Creates captures from marks that were detected elsewhere.
///
/// # Errors
/// Reports holes and kinds that the landmarks do not have, of all captures.
///
/// ```
/// use fabkit_calibration::assignment::Mark;
/// use fabkit_calibration::landmarks::PinLandmarks;
/// use fabkit_calibration::pin_captures::{MeasuredCapture, from_marks};
/// use fabkit_camera::Point2;
/// let landmarks = PinLandmarks::from_json(r#"{"1": [0, 0, 15], "2": [9, 0, 12]}"#)?;
/// let capture = |holes: &[u32]| MeasuredCapture {
///     name: "first".into(),
///     holes: Some(holes.to_vec()),
///     marks: vec![Mark { pixel: Point2::new(310.5, 222.0), sigma_px: 0.2 }],
/// };
/// // Two pins on the label, one mark.
/// let captures = from_marks(vec![capture(&[1, 2])], &landmarks, None)?;
/// let record = &captures.records[0];
/// assert_eq!((record.pins_expected, record.pins_found), (Some(2), 1));
/// let unknown = from_marks(vec![capture(&[1, 9])], &landmarks, None).unwrap_err();
/// assert_eq!(unknown.to_string(), "first: the landmarks have no hole 9");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn from_marks<'a>(
    given: Vec<MeasuredCapture>,
    landmarks: &'a PinLandmarks,
    kind: Option<&str>,
) -> Result<PinCaptures<'a>, Error> {
    let choose = PinLookup { landmarks, kind };
    let (mut captures, mut wrong) = (PinCaptures::default(), Vec::new());
    for MeasuredCapture { name, holes, marks } in given {
        match choose.pins(&name, holes.as_deref()) {
            Err(error) => wrong.push(error.into()),
            Ok(pins) => {
                let marked = MarkedCapture { marks, pins, is_labelled: holes.is_some() };
                captures.add(name, LeftOut::default(), marked);
            }
        }
    }
    Error::join(wrong).map_or(Ok(captures), Err)
}

impl<'a> PinCaptures<'a> {
    fn add(&mut self, file: String, left_out: LeftOut, marked: MarkedCapture<'a>) {
        let pins_expected = marked.is_labelled.then_some(marked.pins.len());
        let pins_found = marked.marks.len();
        self.records.push(CaptureRecord { file, pins_expected, pins_found, left_out });
        self.marked.push(marked);
    }
}

/// Lookup of the pins that a label refers to.
#[derive(Clone, Copy, Debug)]
struct PinLookup<'a, 'k> {
    /// All pins of the fixture.
    landmarks: &'a PinLandmarks,
    /// Kind of pin for labels that do not name one.
    kind: Option<&'k str>,
}

impl<'a> PinLookup<'a, '_> {
    /// Finds the pin in a hole, which may not exist or be one of several kinds.
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

    /// Finds the pins that a capture may show: those in its holes, or all of the kind.
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

    /// Finds all pins of the kinds that a file is named after: `semi-dome-017`, or two halves with a `+` between them.
    fn pins_from_file_name(&self, file: &str) -> Option<Vec<&'a PinLandmark>> {
        let pins_of = |kind: &str| -> Option<Vec<_>> {
            let pins =
                self.landmarks.pins.iter().filter(|pin| pin.kind == kind).collect::<Vec<_>>();
            Some(pins).filter(|pins| !pins.is_empty())
        };
        let of_each: Option<Vec<_>> = stem(file).split('+').map(pins_of).collect();
        of_each.map(|pins| pins.concat())
    }

    /// Reads a capture's pins from its file name.
    fn capture_from_name(&self, file: &str) -> Result<PlannedCapture<'a>, Error> {
        if let Some(pins) = self.pins_from_file_name(file) {
            // Not a complete label: many protrusions of a half leave no mark, and too few do to determine how the
            // camera is turned.
            return Ok(PlannedCapture { file: file.into(), pins, labelled: false, marks: None });
        }
        let stem = stem(file);
        let holes = captures::holes_from_name(stem);
        let (pins, labelled) = (self.pins(file, holes.as_deref())?, holes.is_some());
        Ok(PlannedCapture { file: file.into(), pins, labelled, marks: None })
    }

    /// Reads a capture's pins, and perhaps their marks, from the list.
    fn capture_from_list(
        &self,
        file: &str,
        listed: &[ListedPin],
    ) -> Result<PlannedCapture<'a>, Error> {
        let pin = |p: &ListedPin| self.pin(file, p.hole, p.kind.as_deref());
        let pins = listed.iter().map(pin).collect::<Result<Vec<_>, _>>()?;
        let measured: Vec<Mark> = listed
            .iter()
            .filter_map(|p| p.pixel)
            .map(|(pixel, sigma_px)| Mark { pixel, sigma_px })
            .collect();
        if !measured.is_empty() && measured.len() < listed.len() {
            return Err(PinCaptureError::PartlyMeasured { file: file.into() }.into());
        }
        let marks = (!measured.is_empty()).then_some(measured);
        Ok(PlannedCapture { file: file.into(), pins, labelled: true, marks })
    }
}

/// Returns a file name without its extension.
fn stem(file: &str) -> &str {
    Path::new(file).file_stem().and_then(|stem| stem.to_str()).unwrap_or_default()
}

/// Joins the names of the kinds of pin. Only the first ones if there are many, as in a set of halves.
fn names(landmarks: &PinLandmarks) -> String {
    let kinds = landmarks.kinds();
    let first = kinds.iter().take(MAX_NAMED_KINDS).copied().collect::<Vec<_>>().join(", ");
    match kinds.len().saturating_sub(MAX_NAMED_KINDS) {
        0 => first,
        more => format!("{first} and {more} more"),
    }
}

/// Lists the images of a folder except the one without contact, in natural order.
///
/// # Errors
/// Fails for a folder that cannot be read, has too many images or none.
pub fn image_paths(folder: &Path, reference: &Path) -> Result<Vec<PathBuf>, Error> {
    let is_reference = |path: &PathBuf| same_file(path, reference);
    let all = image_names(folder)?.into_iter().map(|name| folder.join(name));
    let captures: Vec<PathBuf> = all.filter(|path| !is_reference(path)).collect();
    if captures.is_empty() {
        return Err(PinCaptureError::NoCaptures { folder: folder.into() }.into());
    }
    Ok(captures)
}

/// Returns whether two paths lead to the same file.
fn same_file(a: &Path, b: &Path) -> bool {
    directory_listing::canonical_path(a) == directory_listing::canonical_path(b)
}

/// Lists the file names of a folder's images, in natural order.
fn image_names(folder: &Path) -> Result<Vec<String>, PinCaptureError> {
    let unreadable = |source| PinCaptureError::Folder { folder: folder.into(), source };
    let mut files = Vec::new();
    for entry in directory_listing::list_entries(folder).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?;
        // A name that is not UTF-8 cannot be a label.
        if entry.is_utf8() && has_image_extension(&entry.name) {
            files.push(entry.name);
        }
        if files.len() > MAX_IMAGES {
            return Err(PinCaptureError::TooManyImages { folder: folder.into() });
        }
    }
    files.sort_by(|a, b| compare_natural(a, b));
    Ok(files)
}

/// Reads the list of captures, if the folder has one.
fn read_capture_list(folder: &Path) -> Result<BTreeMap<String, Vec<ListedPin>>, Error> {
    let path = folder.join(LIST_FILE_NAME);
    if !path.is_file() {
        return Ok(BTreeMap::new());
    }
    let expected = ExpectedFile {
        what: "a list of captures",
        max_bytes: captures::MAX_BYTES as u64,
        hint: "it has one row for each pin",
    };
    let text = reading::read_text(&path, expected)?;
    captures::read_list(&text).map_err(|source| PinCaptureError::List { file: path, source }.into())
}
