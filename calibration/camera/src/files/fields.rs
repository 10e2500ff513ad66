//! Typed values from a YAML tree, with all faults collected.

use fabkit_text::{Position, YamlNode, suggestion, to_printable};
use nalgebra::DMatrix;

use super::{CameraFile, InvalidCameraFile, YamlFault};
use crate::camera::{Camera, check_size_and_interface};
use crate::error::{InvalidCamera, ParameterViolation, format_number};
use crate::estimate::CameraEstimate;
use crate::interface::Interface;
use crate::lens::Lens;
use crate::plausibility::plausibility;

/// Reader that collects faults, and the positions of parameters for messages.
///
/// Values that cannot be read become NaN, 0 or `None`, so that reading goes on; [`FieldReader::finish`] never makes a camera
/// from them.
#[derive(Default)]
pub(super) struct FieldReader {
    faults: Vec<YamlFault>,
    /// Positions in the file from which parameters were read, by parameter name.
    places: Vec<(&'static str, Position)>,
    /// Parts of the file that were not used, and assumptions.
    notes: Vec<String>,
    /// Whether the file declares its values as right, however unusual.
    pub(super) accepts_unusual: bool,
}

impl FieldReader {
    pub(super) fn fault(&mut self, fault: YamlFault) {
        self.faults.push(fault);
    }

    /// Records a part of the file that is not used, or an assumption.
    pub(super) fn note(&mut self, note: impl Into<String>) {
        self.notes.push(note.into());
    }

    /// Records the position of a camera's parameters.
    pub(super) fn record_position(&mut self, names: &[&'static str], at: Position) {
        self.places.extend(names.iter().map(|name| (*name, at)));
    }

    pub(super) fn child<'a>(&mut self, map: &'a YamlNode, key: &str) -> Option<&'a YamlNode> {
        let child = map.get(key);
        if child.is_none() {
            self.fault(YamlFault::new(map.position, key, "is missing"));
        }
        child
    }

    /// Reads a required number; NaN if it is missing or not a number.
    pub(super) fn number(&mut self, map: &YamlNode, key: &'static str) -> f64 {
        let Some(node) = self.child(map, key) else { return f64::NAN };
        self.record_position(&[key], node.position);
        self.parse_number(node, key)
    }

    /// Reads a finite number; NaN if it is not one.
    pub(super) fn parse_number(&mut self, node: &YamlNode, field: &str) -> f64 {
        let text = node.text().unwrap_or("a list or mapping");
        let number = text.parse().ok().filter(|number: &f64| number.is_finite());
        number.unwrap_or_else(|| {
            let message = format!("`{}` is not a finite number", to_printable(text));
            self.fault(YamlFault::new(node.position, field, message));
            f64::NAN
        })
    }

    /// Reads a list of numbers; entries that are not numbers become NaN.
    pub(super) fn numbers(&mut self, node: &YamlNode, field: &str) -> Vec<f64> {
        if !node.is_list() {
            self.fault(YamlFault::new(node.position, field, "must be a list of numbers"));
        }
        node.items().iter().map(|i| self.parse_number(i, field)).collect()
    }

    /// Reads a list of exactly `N` numbers; missing ones become NaN.
    pub(super) fn read_exactly<const N: usize>(
        &mut self,
        node: &YamlNode,
        field: &str,
    ) -> [f64; N] {
        // A list with unreadable entries is already reported: its length is not reported on top.
        let before = self.faults.len();
        let numbers = self.numbers(node, field);
        if numbers.len() != N && self.faults.len() == before {
            let message = format!("has {} numbers; {N} are needed", numbers.len());
            self.fault(YamlFault::new(node.position, field, message));
        }
        std::array::from_fn(|i| numbers.get(i).copied().unwrap_or(f64::NAN))
    }

    /// Reads a whole number of pixels; 0 if it is not one.
    pub(super) fn pixels(&mut self, node: &YamlNode, field: &'static str) -> u32 {
        let number = self.parse_number(node, field);
        if number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&number) {
            self.record_position(&[field], node.position);
            return number as u32;
        }
        if number.is_finite() {
            let message = format!("{number} is not a whole number of pixels");
            self.fault(YamlFault::new(node.position, field, message));
        }
        0
    }

    /// Reads an image size `[width, height]`; zeros if it is none.
    pub(super) fn size(&mut self, node: &YamlNode, field: &str) -> (u32, u32) {
        // A mapping, as some scripts write it.
        if let Some((width, height)) = node.get("width").zip(node.get("height")) {
            return (self.pixels(width, "width_px"), self.pixels(height, "height_px"));
        }
        match node.items() {
            [width, height] => (self.pixels(width, "width_px"), self.pixels(height, "height_px")),
            _ => {
                self.fault(YamlFault::new(node.position, field, "must be [width, height]"));
                (0, 0)
            }
        }
    }

    /// Reads a required word with its position.
    pub(super) fn text<'a>(&mut self, map: &'a YamlNode, key: &str) -> Option<(&'a str, Position)> {
        let node = self.child(map, key)?;
        let text = node.text();
        if text.is_none() {
            self.fault(YamlFault::new(node.position, key, "must be a single word"));
        }
        Some((text?, node.position))
    }

    /// Reports every key that is not in `known`.
    pub(super) fn require_known_keys(&mut self, map: &YamlNode, known: &[&str]) {
        for entry in map.entries() {
            if !known.contains(&entry.key.as_str()) {
                let hint = suggestion(&entry.key, known.iter().copied(), "known here");
                let fault = YamlFault::new(
                    entry.key_position,
                    &to_printable(&entry.key),
                    "is not a known key",
                );
                self.fault(fault.hint(hint));
            }
        }
    }

    /// Returns `value`, or the faults if there are any.
    pub(super) fn into_result<T>(self, value: T) -> Result<T, InvalidCameraFile> {
        if self.faults.is_empty() { Ok(value) } else { Err(self.with_violations(Vec::new())) }
    }

    /// Creates a camera from the values, or returns all faults. If `lens` is `None`, a fault has been reported for it.
    ///
    /// Files become cameras only here, so that each is compared with its image ([`plausibility`]).
    pub(super) fn into_camera(
        mut self,
        (width_px, height_px): (u32, u32),
        lens: Option<Result<Lens, InvalidCamera>>,
        interface: Interface,
        covariance: Option<DMatrix<f64>>,
    ) -> Result<CameraFile, InvalidCameraFile> {
        let camera = match lens {
            Some(Ok(lens)) if self.faults.is_empty() => {
                match Camera::new(width_px, height_px, lens, interface) {
                    Ok(camera) => camera,
                    Err(invalid) => return Err(self.with_violations(invalid.violations)),
                }
            }
            lens => return Err(self.into_faults((width_px, height_px), lens, interface)),
        };
        let findings = plausibility(&camera);
        for found in findings.iter().filter(|found| found.is_impossible()) {
            if !self.accepts_unusual {
                let place = self.place(found.parameter());
                self.fault(YamlFault::new(place, "", found.to_string()).hint(found.hint()));
            }
        }
        if !self.faults.is_empty() {
            return Err(self.with_violations(Vec::new()));
        }
        match CameraEstimate::new(camera, covariance) {
            Ok(estimate) => Ok(CameraFile { estimate, findings, notes: self.notes }),
            Err(error) => {
                self.fault(YamlFault::new(None, "covariance", error.to_string()));
                Err(self.with_violations(Vec::new()))
            }
        }
    }

    /// Returns the position in the file from which a parameter was read.
    fn place(&self, parameter: &str) -> Option<Position> {
        let find = |parameter| self.places.iter().find(|(name, _)| *name == parameter);
        // Sphere models have no k1.
        let place = find(parameter).or_else(|| find("alpha").filter(|_| parameter == "k1"));
        place.map(|(_, at)| *at)
    }

    /// Returns all faults, including those of the values, if no camera can be created.
    pub(super) fn into_faults(
        self,
        (width_px, height_px): (u32, u32),
        lens: Option<Result<Lens, InvalidCamera>>,
        interface: Interface,
    ) -> InvalidCameraFile {
        let of_lens = lens.and_then(Result::err).map_or_else(Vec::new, |e| e.violations);
        let around = check_size_and_interface(width_px, height_px, &interface).finish().err();
        let around = around.map_or_else(Vec::new, |e| e.violations);
        self.with_violations([of_lens, around].concat())
    }

    fn with_violations(mut self, violations: Vec<ParameterViolation>) -> InvalidCameraFile {
        violations.into_iter().for_each(|violation| self.violation(violation));
        self.faults.sort_by_key(super::yaml::fault_line);
        InvalidCameraFile { faults: self.faults }
    }

    /// Reports a violated condition, unless the value could not be read and is reported for that.
    fn violation(&mut self, violation: ParameterViolation) {
        let ParameterViolation { field, value, limit } = violation;
        let place = self.place(field);
        // A size of 0 without a position was not read either.
        let unread = value.is_nan() || (value == 0.0 && place.is_none());
        if !unread || self.faults.is_empty() {
            self.fault(YamlFault::new(
                place,
                field,
                format!("is {}, but {limit}", format_number(value)),
            ));
        }
    }
}
