//! Typed values from a YAML tree, with all faults collected.

use fabkit_text::{Node, Position, shown, suggestion};
use nalgebra::DMatrix;

use super::{Fault, InvalidCameraFile};
use crate::camera::{Camera, check_around};
use crate::error::{InvalidCamera, LensViolation, readable};
use crate::estimate::CameraEstimate;
use crate::interface::Interface;
use crate::lens::Lens;

/// Reader that collects faults, and the positions of parameters for messages.
///
/// Values that cannot be read become NaN, 0 or `None`, so that reading goes on; [`Fields::finish`] never makes a camera
/// from them.
#[derive(Default)]
pub(super) struct Fields {
    faults: Vec<Fault>,
    /// Positions in the file from which parameters were read, by parameter name.
    places: Vec<(&'static str, Position)>,
}

impl Fields {
    pub(super) fn fault(&mut self, fault: Fault) {
        self.faults.push(fault);
    }

    /// Records the position of a camera's parameters.
    pub(super) fn stands_on(&mut self, names: &[&'static str], at: Position) {
        self.places.extend(names.iter().map(|name| (*name, at)));
    }

    pub(super) fn child<'a>(&mut self, map: &'a Node, key: &str) -> Option<&'a Node> {
        let child = map.get(key);
        if child.is_none() {
            self.fault(Fault::new(map.position, key, "is missing"));
        }
        child
    }

    /// Reads a required number; NaN if it is missing or not a number.
    pub(super) fn number(&mut self, map: &Node, key: &'static str) -> f64 {
        let Some(node) = self.child(map, key) else { return f64::NAN };
        self.stands_on(&[key], node.position);
        self.parse_number(node, key)
    }

    /// Reads a finite number; NaN if it is not one.
    pub(super) fn parse_number(&mut self, node: &Node, field: &str) -> f64 {
        let text = node.text().unwrap_or("a list or mapping");
        let number = text.parse().ok().filter(|number: &f64| number.is_finite());
        number.unwrap_or_else(|| {
            let message = format!("`{}` is not a finite number", shown(text));
            self.fault(Fault::new(node.position, field, message));
            f64::NAN
        })
    }

    /// Reads a list of numbers; entries that are not numbers become NaN.
    pub(super) fn numbers(&mut self, node: &Node, field: &str) -> Vec<f64> {
        if !node.is_list() {
            self.fault(Fault::new(node.position, field, "must be a list of numbers"));
        }
        node.items().iter().map(|i| self.parse_number(i, field)).collect()
    }

    /// Reads a list of exactly `N` numbers; missing ones become NaN.
    pub(super) fn exactly<const N: usize>(&mut self, node: &Node, field: &str) -> [f64; N] {
        // A list with unreadable entries is already reported: its length is not reported on top.
        let before = self.faults.len();
        let numbers = self.numbers(node, field);
        if numbers.len() != N && self.faults.len() == before {
            let message = format!("has {} numbers; {N} are needed", numbers.len());
            self.fault(Fault::new(node.position, field, message));
        }
        std::array::from_fn(|i| numbers.get(i).copied().unwrap_or(f64::NAN))
    }

    /// Reads a whole number of pixels; 0 if it is not one.
    pub(super) fn pixels(&mut self, node: &Node, field: &'static str) -> u32 {
        let number = self.parse_number(node, field);
        if number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&number) {
            self.stands_on(&[field], node.position);
            return number as u32;
        }
        if number.is_finite() {
            let message = format!("{number} is not a whole number of pixels");
            self.fault(Fault::new(node.position, field, message));
        }
        0
    }

    /// Reads a required word with its position.
    pub(super) fn text<'a>(&mut self, map: &'a Node, key: &str) -> Option<(&'a str, Position)> {
        let node = self.child(map, key)?;
        let text = node.text();
        if text.is_none() {
            self.fault(Fault::new(node.position, key, "must be a single word"));
        }
        Some((text?, node.position))
    }

    /// Reports every key that is not in `known`.
    pub(super) fn only(&mut self, map: &Node, known: &[&str]) {
        for entry in map.entries() {
            if !known.contains(&entry.key.as_str()) {
                let hint = suggestion(&entry.key, known.iter().copied(), "known here");
                let fault =
                    Fault::new(entry.key_position, &shown(&entry.key), "is not a known key");
                self.fault(fault.hint(hint));
            }
        }
    }

    /// Returns `value`, or the faults if there are any.
    pub(super) fn into_result<T>(self, value: T) -> Result<T, InvalidCameraFile> {
        if self.faults.is_empty() { Ok(value) } else { Err(self.with_violations(Vec::new())) }
    }

    /// Creates a camera from the values, or returns all faults. If `lens` is `None`, a fault has been reported for it.
    pub(super) fn finish(
        mut self,
        (width_px, height_px): (u32, u32),
        lens: Option<Result<Lens, InvalidCamera>>,
        interface: Interface,
        covariance: Option<DMatrix<f64>>,
    ) -> Result<CameraEstimate, InvalidCameraFile> {
        let camera = match lens {
            Some(Ok(lens)) if self.faults.is_empty() => {
                match Camera::new(width_px, height_px, lens, interface) {
                    Ok(camera) => camera,
                    Err(invalid) => return Err(self.with_violations(invalid.violations)),
                }
            }
            lens => return Err(self.faults_of((width_px, height_px), lens, interface)),
        };
        CameraEstimate::new(camera, covariance).map_err(|error| {
            self.fault(Fault::new(None, "covariance", error.to_string()));
            self.with_violations(Vec::new())
        })
    }

    /// Returns all faults, including those of the values, if no camera can be created.
    pub(super) fn faults_of(
        self,
        (width_px, height_px): (u32, u32),
        lens: Option<Result<Lens, InvalidCamera>>,
        interface: Interface,
    ) -> InvalidCameraFile {
        let of_lens = lens.and_then(Result::err).map_or_else(Vec::new, |e| e.violations);
        let around = check_around(width_px, height_px, &interface).finish().err();
        let around = around.map_or_else(Vec::new, |e| e.violations);
        self.with_violations([of_lens, around].concat())
    }

    fn with_violations(mut self, violations: Vec<LensViolation>) -> InvalidCameraFile {
        violations.into_iter().for_each(|violation| self.violation(violation));
        self.faults.sort_by_key(super::line);
        InvalidCameraFile { faults: self.faults }
    }

    /// Reports a violated condition, unless the value could not be read and is reported for that.
    fn violation(&mut self, violation: LensViolation) {
        let LensViolation { field, value, limit } = violation;
        let place = self.places.iter().find(|(name, _)| *name == field).map(|(_, at)| *at);
        // A size of 0 without a position was not read either.
        let unread = value.is_nan() || (value == 0.0 && place.is_none());
        if !unread || self.faults.is_empty() {
            self.fault(Fault::new(place, field, format!("is {}, but {limit}", readable(value))));
        }
    }
}
