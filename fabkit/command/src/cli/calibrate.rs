//! Options of `fabkit calibrate`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use fabkit_application::calibration::intrinsics::LensModel;
use fabkit_application::calibration_runs::boards;

use super::{completing, examples};

/// `fabkit calibrate`.
#[derive(Debug, Subcommand)]
pub enum Calibrate {
    /// Calibrate the lens from images of a board, in air
    #[command(after_help = examples::INTRINSICS)]
    Intrinsics(CalibrateIntrinsics),
    /// Detect pin contacts in images, each with its standard deviation
    #[command(after_help = examples::PINS)]
    Pins(CalibratePins),
    /// Calibrate the camera's pose from captures of pins in a calibration dome
    #[command(after_help = examples::EXTRINSICS)]
    Extrinsics(CalibrateExtrinsics),
    /// Forecast the uncertainty of the surface after more captures, and which holes to press next
    #[command(after_help = examples::PLAN)]
    Plan(CalibratePlan),
}

/// `fabkit calibrate intrinsics`.
#[derive(Debug, Args)]
pub struct CalibrateIntrinsics {
    /// Built-in sensor or path to a sensor file
    #[arg(add = completing::sensors())]
    pub sensor: String,
    /// Images of the board: PNG, JPEG, TIFF or BMP
    #[arg(required_unless_present = "corners", conflicts_with = "corners", value_name = "IMAGE")]
    pub images: Vec<PathBuf>,
    /// Set a parameter, for example `camera.field_of_view=150deg`; may be repeated
    #[arg(long = "set", value_name = "PATH=VALUE", add = completing::settings())]
    pub set: Vec<String>,
    /// Board file, exported with the board
    #[arg(long, value_name = "FILE.json")]
    pub board: PathBuf,
    /// Corner detector
    #[arg(long, value_enum, default_value = "fabkit", value_name = "NAME")]
    pub detector: Detector,
    /// List of corners instead of images: view,corner,x_px,y_px[,sigma_px]
    #[arg(long, value_name = "FILE.csv")]
    pub corners: Option<PathBuf>,
    /// Only this lens model; may be repeated [default: all; the evidence decides]
    #[arg(long = "model", value_parser = lens_model, value_name = "NAME")]
    pub models: Vec<LensModel>,
    /// Camera file to write
    #[arg(short, long, value_name = "FILE.yaml")]
    pub output: PathBuf,
    /// Replace files even if they were edited or not written by fabkit
    #[arg(long)]
    pub force: bool,
    /// Write an HTML report
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

/// Corner detectors of `--detector`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Detector {
    /// fabkit's own: any board, any lens
    Fabkit,
    /// OpenCV, if fabkit was built with it: checkerboards only
    Opencv,
}

impl From<Detector> for boards::Detector {
    fn from(detector: Detector) -> Self {
        match detector {
            Detector::Fabkit => Self::Fabkit,
            Detector::Opencv => Self::Opencv,
        }
    }
}

/// `fabkit calibrate pins`.
#[derive(Debug, Args)]
pub struct CalibratePins {
    /// Images with contact: PNG, JPEG, TIFF or BMP
    #[arg(required = true, value_name = "IMAGE")]
    pub images: Vec<PathBuf>,
    /// Reference image without contact, from the same camera
    #[arg(long, value_name = "IMAGE")]
    pub reference: PathBuf,
    /// Contacts are brighter than their surroundings, not darker
    #[arg(long)]
    pub brighter: bool,
}

/// `fabkit calibrate extrinsics`.
#[derive(Debug, Args)]
pub struct CalibrateExtrinsics {
    /// Built-in sensor or path to a sensor file
    #[arg(add = completing::sensors())]
    pub sensor: String,
    /// Set a parameter, for example `camera.depth=8mm`; may be repeated
    #[arg(long = "set", value_name = "PATH=VALUE", add = completing::settings())]
    pub set: Vec<String>,
    /// Camera file (fabkit, OpenCV, ROS, Kalibr and others; FILE#NAME for one of several cameras)
    #[arg(long, value_name = "FILE.yaml")]
    pub camera: PathBuf,
    /// Folder of captures named after the holes with pins, as 01_05_08.png, or listed in captures.csv:
    /// file,hole[,kind][,x_px,y_px[,sigma_px]]
    #[arg(long, value_name = "DIR")]
    pub captures: PathBuf,
    /// Reference image without contact [default: ref.png or reference.png in the folder, or .jpg, ...]
    #[arg(long, value_name = "IMAGE")]
    pub reference: Option<PathBuf>,
    /// Contact points of the pins: a landmarks file, or a JSON map of hole number to [x, y, z] in mm
    /// [default: those of the sensor's pin-dome or pin-plate]
    #[arg(long, value_name = "FILE.json")]
    pub landmarks: Option<PathBuf>,
    /// Calibration target: a fixture of the sensor. Captures of `semi-domes` and `half-plates` are named after the halves, as
    /// semi-dome-017.png, two of them joined by + [default: pin-dome or pin-plate]
    #[arg(long, conflicts_with = "landmarks", value_name = "FIXTURE")]
    pub fixture: Option<String>,
    /// Kind of pin that was used, if the dome has several
    #[arg(long, value_name = "KIND")]
    pub pin: Option<String>,
    /// Refractive index of the gel in front of the lens, 1 to 2, for explanations that have one
    #[arg(long, value_parser = refractive_index, default_value = "1.41", value_name = "N")]
    pub gel_index: f64,
    /// Pose file to write; its camera file is written beside it
    #[arg(short, long, value_name = "FILE.yaml")]
    pub output: PathBuf,
    /// Replace files even if they were edited or not written by fabkit
    #[arg(long)]
    pub force: bool,
    /// Write an HTML report
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

/// `fabkit calibrate plan`.
#[derive(Debug, Args)]
pub struct CalibratePlan {
    /// Built-in sensor or path to a sensor file
    #[arg(add = completing::sensors())]
    pub sensor: String,
    /// Set a parameter, for example `fixtures.pin_dome.captures.noise_px=0.5`; may be repeated
    #[arg(long = "set", value_name = "PATH=VALUE", add = completing::settings())]
    pub set: Vec<String>,
    /// Camera file (fabkit, OpenCV, ROS, Kalibr and others; FILE#NAME for one of several cameras) with its covariance [default: the sensor's nominal lens, taken as exact]
    #[arg(long, value_name = "FILE.yaml")]
    pub camera: Option<PathBuf>,
    /// Folder of existing captures, named as for `extrinsics`; only the names are read
    #[arg(long, value_name = "DIR")]
    pub done: Option<PathBuf>,
    /// Kind of pin in the existing captures, if the dome has several
    #[arg(long, value_name = "KIND", requires = "done")]
    pub pin: Option<String>,
    /// Number of further captures [default: the number in the sensor file less the existing ones]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=500))]
    pub captures: Option<u16>,
    /// Pins per capture [default: the number in the sensor file]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=100))]
    pub pins: Option<u16>,
}

fn lens_model(name: &str) -> Result<LensModel, String> {
    LensModel::from_name(name).ok_or_else(|| {
        let names = LensModel::ALL.map(|model| model.name()).join(", ");
        format!("there is no lens model `{name}`; there are {names}")
    })
}

fn refractive_index(text: &str) -> Result<f64, String> {
    let index: f64 = text.parse().map_err(|_| format!("`{text}` is not a number"))?;
    if (1.0..=2.0).contains(&index) {
        Ok(index)
    } else {
        Err(format!("{index} is not between 1 (air) and 2"))
    }
}
