//! How the finished sensor is calibrated: which fixtures there are, what to type, and which pin goes where.

use serde::Serialize;

/// All of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Calibration {
    /// The hardware that fabkit makes for this sensor.
    pub fixtures: Vec<FixtureNote>,
    /// What to type, in order.
    pub commands: Vec<Typed>,
    /// The fixture whose holes the captures name; empty without one.
    pub pins_in: String,
    /// Pictures to take with pins in holes, in order.
    pub captures: Vec<Capture>,
}

/// A fixture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FixtureNote {
    /// Behind `SENSOR/`.
    pub name: String,
    /// What it is for.
    pub summary: String,
}

/// A command line.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Typed {
    /// What it is for.
    pub what: String,
    /// What to type into a shell.
    pub line: String,
}

/// A picture with pins.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Capture {
    /// What to call the picture.
    pub file: String,
    /// Which pins.
    pub pins: String,
    /// In which holes, by their engraved numbers.
    pub holes: Vec<u32>,
}

impl Calibration {
    /// The captures as the list that `calibrate extrinsics` reads from their folder: `file,hole,kind`.
    ///
    /// ```
    /// use fabkit_guide::{Calibration, Capture};
    /// let capture = Capture { file: "01.png".into(), pins: "pin-long".into(), holes: vec![3, 9] };
    /// let calibration = Calibration { captures: vec![capture], ..Calibration::default() };
    /// assert_eq!(calibration.captures_csv(), "file,hole,kind\n01.png,3,long\n01.png,9,long\n");
    /// ```
    pub fn captures_csv(&self) -> String {
        let rows = self.captures.iter().flat_map(|capture| {
            let kind = capture.pins.trim_start_matches("pin-");
            capture.holes.iter().map(move |hole| format!("{},{hole},{kind}\n", capture.file))
        });
        "file,hole,kind\n".to_owned() + &rows.collect::<String>()
    }
}
