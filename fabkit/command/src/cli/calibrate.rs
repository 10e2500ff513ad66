//! `fabkit calibrate`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use fabkit_application::calibrating::boards;
use fabkit_application::calibration::intrinsics::LensModel;

use super::{completing, examples};

/// `fabkit calibrate`.
#[derive(Debug, Subcommand)]
pub enum Calibrate {
    /// Solve for the lens of the camera from pictures of a board, in air
    #[command(after_help = examples::INTRINSICS)]
    Intrinsics(CalibrateIntrinsics),
    /// Find the marks of pins in pictures, each with its standard deviation
    #[command(after_help = examples::PINS)]
    Pins(CalibratePins),
    /// Solve for the pose of the camera from pictures of pins in a calibration dome
    #[command(after_help = examples::EXTRINSICS)]
    Extrinsics(CalibrateExtrinsics),
    /// Say how sure the surface will be after so many captures of pins, and which holes to press next
    #[command(after_help = examples::PLAN)]
    Plan(CalibratePlan),
}

/// `fabkit calibrate intrinsics`.
#[derive(Debug, Args)]
pub struct CalibrateIntrinsics {
    /// Name of a built-in sensor, or path to a YAML file
    #[arg(add = completing::sensors())]
    pub sensor: String,
    /// Pictures of the board: PNG, JPEG, TIFF or BMP
    #[arg(required_unless_present = "corners", conflicts_with = "corners", value_name = "IMAGE")]
    pub images: Vec<PathBuf>,
    /// Change a parameter, for example `camera.field_of_view=150deg`
    #[arg(long = "set", value_name = "PATH=VALUE", add = completing::settings())]
    pub set: Vec<String>,
    /// The board's file, as exported with it
    #[arg(long, value_name = "FILE.json")]
    pub board: PathBuf,
    /// Who looks for the corners in the pictures
    #[arg(long, value_enum, default_value = "fabkit", value_name = "NAME")]
    pub detector: Detector,
    /// A list of corners instead of pictures: view,corner,x_px,y_px[,sigma_px]
    #[arg(long, value_name = "FILE.csv")]
    pub corners: Option<PathBuf>,
    /// Only this lens model; may be repeated [default: all, chosen by evidence]
    #[arg(long = "model", value_parser = lens_model, value_name = "NAME")]
    pub models: Vec<LensModel>,
    /// The camera's file to write
    #[arg(short, long, value_name = "FILE.yaml")]
    pub output: PathBuf,
    /// Replace files also if they were changed since fabkit wrote them, or if fabkit did not write them
    #[arg(long)]
    pub force: bool,
    /// Write a report as one HTML file
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

/// Who finds a board's corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Detector {
    /// Our own: any board, any lens
    Fabkit,
    /// OpenCV, where fabkit was built with it: checkerboards
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
    /// Pictures with contact: PNG, JPEG, TIFF or BMP
    #[arg(required = true, value_name = "IMAGE")]
    pub images: Vec<PathBuf>,
    /// The picture without contact, from the same camera
    #[arg(long, value_name = "IMAGE")]
    pub reference: PathBuf,
    /// Contacts are brighter than the surface around them, not darker
    #[arg(long)]
    pub brighter: bool,
}

/// `fabkit calibrate extrinsics`.
#[derive(Debug, Args)]
pub struct CalibrateExtrinsics {
    /// Name of a built-in sensor, or path to a YAML file
    #[arg(add = completing::sensors())]
    pub sensor: String,
    /// Change a parameter, for example `camera.depth=8mm`
    #[arg(long = "set", value_name = "PATH=VALUE", add = completing::settings())]
    pub set: Vec<String>,
    /// The camera's file: fabkit's, OpenCV's, ROS's or Kalibr's
    #[arg(long, value_name = "FILE.yaml")]
    pub camera: PathBuf,
    /// Folder of pictures named after the holes that had pins, as 01_05_08.png, or with a list in
    /// captures.csv: file,hole[,kind][,x_px,y_px[,sigma_px]]
    #[arg(long, value_name = "DIR")]
    pub captures: PathBuf,
    /// The picture without contact [default: ref.png or reference.png in the folder, or .jpg, ...]
    #[arg(long, value_name = "IMAGE")]
    pub reference: Option<PathBuf>,
    /// Where pins touch: a dome's landmarks, or a JSON map of hole number to [x, y, z] in mm
    /// [default: those of the sensor's own pin-dome or pin-plate]
    #[arg(long, value_name = "FILE.json")]
    pub landmarks: Option<PathBuf>,
    /// What pressed, as in `fabkit list SENSOR`: `semi-domes` and `half-plates` are targets too, of pictures named after
    /// their halves, as semi-dome-017.png, or of two with a + between them [default: its pin-dome or pin-plate]
    #[arg(long, conflicts_with = "landmarks", value_name = "FIXTURE")]
    pub fixture: Option<String>,
    /// Which kind of pin was used, where the dome has several
    #[arg(long, value_name = "KIND")]
    pub pin: Option<String>,
    /// Refractive index of the gel that is tried before the lens, 1 to 2
    #[arg(long, value_parser = refractive_index, default_value = "1.41", value_name = "N")]
    pub gel_index: f64,
    /// The pose's file to write; the camera that belongs to it is written beside it
    #[arg(short, long, value_name = "FILE.yaml")]
    pub output: PathBuf,
    /// Replace files also if they were changed since fabkit wrote them, or if fabkit did not write them
    #[arg(long)]
    pub force: bool,
    /// Write a report as one HTML file
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

/// `fabkit calibrate plan`.
#[derive(Debug, Args)]
pub struct CalibratePlan {
    /// Name of a built-in sensor, or path to a YAML file
    #[arg(add = completing::sensors())]
    pub sensor: String,
    /// Change a parameter, for example `fixtures.pin_dome.captures.noise_px=0.5`
    #[arg(long = "set", value_name = "PATH=VALUE", add = completing::settings())]
    pub set: Vec<String>,
    /// The camera's file: fabkit's, OpenCV's, ROS's or Kalibr's; its covariance takes part [default: the sensor's nominal
    /// lens, as if it were exact]
    #[arg(long, value_name = "FILE.yaml")]
    pub camera: Option<PathBuf>,
    /// Folder of the captures that there are, named as for `extrinsics`; the pictures are not looked at
    #[arg(long, value_name = "DIR")]
    pub done: Option<PathBuf>,
    /// Which kind of pin was used in them, where the dome has several
    #[arg(long, value_name = "KIND", requires = "done")]
    pub pin: Option<String>,
    /// How many captures to take from now on [default: what is left of the number in the sensor's file]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=500))]
    pub captures: Option<u16>,
    /// Pins in each [default: the number in the sensor's file]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=100))]
    pub pins: Option<u16>,
}

fn lens_model(name: &str) -> Result<LensModel, String> {
    LensModel::named(name).ok_or_else(|| {
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
