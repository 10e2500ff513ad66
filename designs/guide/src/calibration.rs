//! Calibration of the finished sensor: fixtures, commands to type, and the pins for each capture.

use fabkit_geometry::csv::CsvTable;
use serde::Serialize;

/// Calibration instructions.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Calibration {
    /// Fixtures that fabkit makes for this sensor.
    pub fixtures: Vec<FixtureNote>,
    /// Commands to type, in order.
    pub commands: Vec<CalibrationCommand>,
    /// Fixture whose holes the captures refer to; empty if there is none.
    pub pins_in: String,
    /// Captures to take with pins in holes, in order.
    pub captures: Vec<PinCapture>,
}

/// Fixture with its purpose.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FixtureNote {
    /// Name of the fixture, without `SENSOR/`.
    pub name: String,
    /// Purpose.
    pub summary: String,
}

/// Command line with its purpose.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CalibrationCommand {
    /// Purpose.
    pub what: String,
    /// Command to type into a shell.
    pub line: String,
}

/// Image to capture with pins in place.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PinCapture {
    /// File name of the image.
    pub file: String,
    /// Kind of pins.
    pub pins: String,
    /// Engraved numbers of the holes that the pins go into.
    pub holes: Vec<u32>,
}

impl Calibration {
    /// Returns the captures as the list that `calibrate extrinsics` reads from their folder: `file,hole,kind`.
    ///
    /// ```
    /// use fabkit_guide::{Calibration, PinCapture};
    /// let capture = PinCapture { file: "01.png".into(), pins: "pin-long".into(), holes: vec![3, 9] };
    /// let calibration = Calibration { captures: vec![capture], ..Calibration::default() };
    /// assert_eq!(calibration.captures_csv(), "file,hole,kind\n01.png,3,long\n01.png,9,long\n");
    /// ```
    pub fn captures_csv(&self) -> String {
        let mut table = CsvTable::new("file,hole,kind");
        for capture in &self.captures {
            let kind = capture.pins.trim_start_matches("pin-");
            for &hole in &capture.holes {
                table.row([(&capture.file).into(), hole.into(), kind.into()]);
            }
        }
        table.finish()
    }
}
