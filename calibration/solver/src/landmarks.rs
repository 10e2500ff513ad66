//! Pin landmarks: the contacts of a calibration dome's pins, which link the printed fixture to the solver.

mod plain_map;

use std::collections::BTreeSet;

use fabkit_geometry::{Point3, Vector3};
use fabkit_text::{InvalidDocument, JsonFormat};
use serde::{Deserialize, Serialize};

/// Value of `format` in a file of landmarks.
pub const FORMAT: &str = "fabkit-pin-landmarks";
/// Version that this crate reads and writes.
pub const VERSION: u32 = 1;
/// Largest file, bytes: room for [`MAX_PINS`] pins and more.
pub const MAX_BYTES: usize = 1 << 26;
/// Largest number of pins in a file: more than the largest set of halves has protrusions, on either side.
pub const MAX_PINS: usize = 100_000;

/// Largest coordinate of a fingertip's fixture, mm.
const MAX_COORDINATE_MM: f64 = 1000.0;
/// Tolerance of an axis's unit length.
const UNIT_TOLERANCE: f64 = 1e-6;
/// Value of `kind` for the pins of a plain map, which has no kinds.
const UNNAMED_KIND: &str = "pin";

/// Kind of pin in one hole, pushed home.
///
/// Points and vectors are arrays of three numbers in JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "PinForm", from = "PinForm")]
pub struct PinLandmark {
    /// Number beside the hole, from 1.
    pub hole: u32,
    /// Kind of pin, for example `long`. Pins of one kind share their seating offset.
    pub kind: String,
    /// Centre of the pin's rounded tip, sensor frame, mm.
    pub tip_centre_in_sensor_mm: Point3<f64>,
    /// Foremost point of the tip, which touches the sensor first, sensor frame, mm.
    pub contact_in_sensor_mm: Point3<f64>,
    /// Unit vector in which the pin is pushed, sensor frame. `None` for a plain map, unless its points lie on a sphere.
    pub axis_in_sensor: Option<Vector3<f64>>,
}

/// Form of [`PinLandmark`] in files.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PinForm {
    hole: u32,
    kind: String,
    tip_centre_in_sensor_mm: [f64; 3],
    contact_in_sensor_mm: [f64; 3],
    #[serde(default, skip_serializing_if = "Option::is_none")]
    axis_in_sensor: Option<[f64; 3]>,
}

impl From<PinLandmark> for PinForm {
    fn from(pin: PinLandmark) -> Self {
        Self {
            hole: pin.hole,
            kind: pin.kind,
            tip_centre_in_sensor_mm: pin.tip_centre_in_sensor_mm.into(),
            contact_in_sensor_mm: pin.contact_in_sensor_mm.into(),
            axis_in_sensor: pin.axis_in_sensor.map(Into::into),
        }
    }
}

impl From<PinForm> for PinLandmark {
    fn from(form: PinForm) -> Self {
        Self {
            hole: form.hole,
            kind: form.kind,
            tip_centre_in_sensor_mm: form.tip_centre_in_sensor_mm.into(),
            contact_in_sensor_mm: form.contact_in_sensor_mm.into(),
            axis_in_sensor: form.axis_in_sensor.map(Into::into),
        }
    }
}

/// Landmarks of a fixture: every hole with every kind of pin that fits it.
///
/// ```
/// use fabkit_calibration::landmarks::PinLandmarks;
/// let map = r#"{"1": [0, 0, 20.5], "2": [4.45, 0, 19.8], "3": [0, -4.45, 19.8]}"#;
/// let landmarks = PinLandmarks::from_json(map).unwrap();
/// assert_eq!(landmarks.find(2, None).unwrap().contact_in_sensor_mm.x, 4.45);
/// let again = PinLandmarks::from_json(&landmarks.to_json()).unwrap();
/// assert_eq!(again, landmarks);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PinLandmarks {
    /// Always [`FORMAT`].
    pub format: String,
    /// Always [`VERSION`].
    pub version: u32,
    /// Name of the sensor.
    pub sensor: String,
    /// Name of the fixture.
    pub fixture: String,
    /// Radius of the pins' rounded tips, mm; 0 for points.
    pub tip_radius_mm: f64,
    /// Landmarks, sorted by hole, then kind.
    pub pins: Vec<PinLandmark>,
}

const DOCUMENT: JsonFormat = JsonFormat {
    what: "list of pin landmarks",
    format: FORMAT,
    version: VERSION,
    max_bytes: MAX_BYTES,
};

impl PinLandmarks {
    /// Creates landmarks from pins, which are sorted and checked.
    ///
    /// # Errors
    /// Reports numbers that are not finite or absurdly large, axes that are not of unit length, a hole that has the
    /// same kind of pin twice, no pins or too many.
    pub fn new(
        sensor: &str,
        fixture: &str,
        tip_radius_mm: f64,
        mut pins: Vec<PinLandmark>,
    ) -> Result<Self, InvalidDocument> {
        pins.sort_by(|a, b| (a.hole, &a.kind).cmp(&(b.hole, &b.kind)));
        let landmarks = Self {
            format: FORMAT.into(),
            version: VERSION,
            sensor: sensor.into(),
            fixture: fixture.into(),
            tip_radius_mm,
            pins,
        };
        landmarks.check()?;
        Ok(landmarks)
    }

    /// Reads a document of this format, or a plain map from hole number to `[x, y, z]`, mm, sensor frame.
    ///
    /// The points of a plain map are taken as contacts. If they lie on a sphere, the pins are taken to point at its
    /// centre; otherwise their axes are unknown.
    ///
    /// # Errors
    /// Reports text that is neither, with line and column; other formats and versions; everything that
    /// [`PinLandmarks::new`] refuses.
    ///
    /// ```
    /// use fabkit_calibration::landmarks::PinLandmarks;
    /// use fabkit_geometry::Vector3;
    /// // Places of a sphere about the origin: pins point to its centre.
    /// let map = r#"{"1": [0, 0, 15], "2": [9, 0, 12], "3": [0, 9, 12], "4": [-9, 0, 12],
    ///     "5": [0, -12, 9]}"#;
    /// let tip = PinLandmarks::from_json(map)?.pins[0].axis_in_sensor.unwrap();
    /// assert!((tip - Vector3::new(0.0, 0.0, -1.0)).norm() < 1e-9);
    /// // One place off the sphere, and no axis is known.
    /// let uneven = PinLandmarks::from_json(&map.replace("15", "14"))?;
    /// assert!(uneven.pins.iter().all(|pin| pin.axis_in_sensor.is_none()));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn from_json(text: &str) -> Result<Self, InvalidDocument> {
        let value = DOCUMENT.parse(text)?;
        let Some(object) = value.as_object() else {
            return Err(DOCUMENT.refuse(
                "expected an object: a fabkit-pin-landmarks document, or hole number to [x, y, z]",
            ));
        };
        if !object.contains_key("format") {
            return plain_map::read(text, object);
        }
        let found: Self = DOCUMENT.read(text, &value)?;
        Self::new(&found.sensor, &found.fixture, found.tip_radius_mm, found.pins)
    }

    /// Writes indented JSON with a final newline.
    pub fn to_json(&self) -> String {
        let text = serde_json::to_string_pretty(self);
        text.expect("strings and finite numbers can be written") + "\n"
    }

    /// Finds the pin in a hole. Without a kind, the hole must have a single pin.
    ///
    /// ```
    /// use fabkit_calibration::landmarks::{PinLandmark, PinLandmarks};
    /// use fabkit_geometry::{Point3, Vector3};
    /// // Pins pushed down into the tip, with rounded ends of 1 mm: the contact is below the end's centre.
    /// let pin = |kind: &str, z_mm| PinLandmark {
    ///     hole: 1,
    ///     kind: kind.into(),
    ///     tip_centre_in_sensor_mm: Point3::new(0.0, 0.0, z_mm + 1.0),
    ///     contact_in_sensor_mm: Point3::new(0.0, 0.0, z_mm),
    ///     axis_in_sensor: Some(-Vector3::z()),
    /// };
    /// let pins = vec![pin("short", 20.0), pin("long", 18.0)];
    /// let landmarks = PinLandmarks::new("rtac0", "pin-dome", 1.0, pins)?;
    /// assert_eq!(landmarks.kinds(), ["long", "short"]);
    /// assert_eq!(landmarks.find(1, Some("long")).unwrap().contact_in_sensor_mm.z, 18.0);
    /// assert_eq!(landmarks.find(1, None), None);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn find(&self, hole: u32, kind: Option<&str>) -> Option<&PinLandmark> {
        let mut here = self.pins.iter().filter(|pin| pin.hole == hole);
        match kind {
            Some(kind) => here.find(|pin| pin.kind == kind),
            None => here.next().filter(|_| here.next().is_none()),
        }
    }

    /// Returns the kinds of pin, sorted.
    pub fn kinds(&self) -> Vec<&str> {
        let kinds: BTreeSet<&str> = self.pins.iter().map(|pin| pin.kind.as_str()).collect();
        kinds.into_iter().collect()
    }

    /// Reports everything that is wrong.
    fn check(&self) -> Result<(), InvalidDocument> {
        let mut problems = Vec::new();
        if self.pins.is_empty() || self.pins.len() > MAX_PINS {
            problems.push(format!("{} pins; there must be 1 to {MAX_PINS}", self.pins.len()));
        }
        if !(0.0..=MAX_COORDINATE_MM).contains(&self.tip_radius_mm) {
            let radius = self.tip_radius_mm;
            problems.push(format!("tip_radius_mm is {radius}; the limits are 0 and 1000"));
        }
        for pin in &self.pins {
            let mut wrong = |what: String| {
                problems.push(format!("hole {} ({}): {what}", pin.hole, pin.kind));
            };
            if pin.hole == 0 {
                wrong("holes are numbered from 1".into());
            }
            let points = [
                ("tip_centre_in_sensor_mm", pin.tip_centre_in_sensor_mm),
                ("contact_in_sensor_mm", pin.contact_in_sensor_mm),
            ];
            for (name, point) in points {
                if !point.iter().all(|v| v.abs() <= MAX_COORDINATE_MM) {
                    wrong(format!("{name} is beyond {MAX_COORDINATE_MM} mm or not a number"));
                }
            }
            let length = pin.axis_in_sensor.map_or(1.0, |axis| axis.norm());
            // `partial_cmp` makes NaN a fault too.
            if (length - 1.0).abs().partial_cmp(&UNIT_TOLERANCE) != Some(std::cmp::Ordering::Less) {
                wrong(format!("axis_in_sensor has length {length}; it must be 1"));
            }
        }
        for pair in self.pins.windows(2) {
            if pair[0].hole == pair[1].hole && pair[0].kind == pair[1].kind {
                problems.push(format!("hole {} has two pins `{}`", pair[0].hole, pair[0].kind));
            }
        }
        DOCUMENT.accept(problems)
    }
}
