//! `fabkit capture`.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};
use fabkit_application::Error;
use fabkit_application::capturing::{Capturing, LightConstants};
use fabkit_application::fixtures::Press;
use fabkit_application::geometry::Lighting;
use fabkit_application::pressing::{Contact, Linear};
use fabkit_application::scene::{Cast, MAX_SAMPLES};

use super::ground_truth::CameraArgs;
use super::options::options;
use super::pressing::{depth, friction, shear, spacing};
use super::{Design, length_within};

const LIGHT: &str = "Which of the sensor's lights is on, for example `uv` [default: its usual one]";
const CONSTANTS: &str = "Constants of a unit's light, as `fit-light` writes them [default: those of R-Tac0's published unit]";

/// Standard deviation of printed and cast surfaces that truth is written with, mm: that of `depth`.
const PRINT_SIGMA_MM: f64 = 0.05;

/// What lights a picture.
#[derive(Debug, Args)]
pub struct LightArgs {
    /// Which of the sensor's lights is on.
    #[arg(long, value_name = "NAME", help = LIGHT)]
    pub light: Option<String>,
    /// File of constants of a unit's light.
    #[arg(long, value_name = "FILE.json", help = CONSTANTS)]
    pub constants: Option<PathBuf>,
}

/// `fabkit capture`.
#[derive(Debug, Args)]
#[command(group(clap::ArgGroup::new("what").args(["press", "indenter", "reference"]).required(true)))]
pub struct Capture {
    /// Which sensor.
    #[command(flatten)]
    pub design: Design,
    /// Where the camera is.
    #[command(flatten)]
    pub camera: CameraArgs,
    /// What presses, for example `semi-dome-017`, or `hemisphere@30deg,120deg,1.2mm`: an indenter by
    /// polar angle, azimuth and depth; may be repeated
    #[arg(long, value_name = "ID")]
    pub press: Vec<String>,
    /// The same in two parts: an indenter and a place, for example `ball@30deg,120deg`
    #[arg(long, value_name = "INDENTER@PLACE", requires = "depth")]
    pub indenter: Option<String>,
    /// How deep the indenter goes, along the surface's normal there
    #[arg(long, value_parser = depth, value_name = "LENGTH", requires = "indenter")]
    pub depth: Option<f64>,
    /// Nothing presses
    #[arg(long)]
    pub reference: bool,
    /// How the picture is taken.
    #[command(flatten)]
    pub options: CaptureOptions,
    /// Of a grey value in the file
    #[arg(long, value_name = "N", default_value = "8", value_parser = ["8", "16"])]
    pub bits: String,
    /// Write the picture
    #[arg(short, long, value_name = "FILE.png", required = true)]
    pub output: PathBuf,
    /// Write the truth that it shows for NumPy, as `depth` does
    #[arg(long, value_name = "FILE.npz")]
    pub truth: Option<PathBuf>,
}

options! {
    /// How a picture is taken: options of `fabkit capture`, and keyword arguments of `fabkit.depth.Scene.capture`.
    pub struct CaptureOptions {
        /// How far all that presses then moves along the surface, in linear contact: on a dome away from the tip and around
        /// it where it goes deepest, on a pad along x and y
        #[arg(long, value_parser = shear, default_value = "0mm,0mm", value_name = "LENGTH,LENGTH", allow_hyphen_values = true)]
        pub shear: [f64; 2],
        /// How the layers answer: as elastic ones that bulge, or as what follows the presser and nothing else
        #[arg(long, value_parser = contact_levels(), value_name = "LEVEL", default_value = "linear")]
        pub contact: String,
        /// Coulomb's coefficient of friction where something moves along the surface [default: that of the touched material]
        #[arg(long, value_parser = friction, value_name = "NUMBER", allow_hyphen_values = true)]
        pub friction: Option<f64>,
        /// Distance of the surface's nodes in linear contact [default: as fine as a few seconds allow]
        #[arg(long, value_parser = spacing, value_name = "LENGTH")]
        pub spacing: Option<f64>,
        /// Go on where a press does not touch the surface, or where the camera sees nothing of it
        #[arg(long, conflicts_with = "reference")]
        pub allow_no_contact: bool,
        /// Cast N x N rays for each pixel, which records their mean
        #[arg(long, value_name = "N", default_value = "1",
              value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SAMPLES)))]
        pub samples: u32,
        /// Which of the sensor's lights is on.
        #[arg(long, value_name = "NAME", help = LIGHT)]
        pub light: Option<String>,
        /// File of constants of a unit's light.
        #[arg(long, value_name = "FILE.json", help = CONSTANTS)]
        pub constants: Option<PathBuf>,
        /// Of another sensor of the same design: what its parts measure, where its camera sits, how bright its lamps are, how
        /// its layers came out differ from the drawing as tolerances let them; the same number is the same unit
        #[arg(long, value_name = "N")]
        pub unit: Option<u64>,
        /// Of noise and drift: another seed is another picture of the same
        #[arg(long, value_name = "N", default_value = "0")]
        pub seed: u64,
        /// Neither noise nor drift, and not as the JPEG in which a camera sends it
        #[arg(long, conflicts_with = "seed")]
        pub no_noise: bool,
    }
}

/// How layers answer to what is captured.
fn contact_levels() -> PossibleValuesParser {
    PossibleValuesParser::new([
        PossibleValue::new("rigid").help("They follow what presses, and nothing else moves"),
        PossibleValue::new("linear").help("They give way as elastic ones do, and bulge"),
    ])
}

impl CaptureOptions {
    /// The picture of `presses` in this light.
    ///
    /// # Errors
    /// [`PressingError::Contact`](fabkit_application::pressing::PressingError::Contact): no such level of contact, and what belongs to another one.
    pub fn capturing<'a>(
        &self,
        presses: &'a [Press],
        lighting: &'a Lighting,
        constants: &'a LightConstants,
    ) -> Result<Capturing<'a>, Error> {
        let linear = Linear { spacing_mm: self.spacing, friction: self.friction };
        let cast = Cast {
            presses,
            samples: self.samples,
            contact: Contact::named(Some(&self.contact), 0.0, linear)?,
            shear_mm: self.shear,
            print_sigma_mm: PRINT_SIGMA_MM,
            allow_no_contact: self.allow_no_contact,
        };
        let seed = (!self.no_noise).then_some(self.seed);
        Ok(Capturing { cast, lighting, constants, seed })
    }
}

/// `fabkit optics-pack`.
#[derive(Debug, Args)]
pub struct OpticsPack {
    /// Which sensor.
    #[command(flatten)]
    pub design: Design,
    /// Where the camera is.
    #[command(flatten)]
    pub camera: CameraArgs,
    /// What lights it.
    #[command(flatten)]
    pub light: LightArgs,
    /// The folder to write into
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
}

/// `fabkit fit-light`.
#[derive(Debug, Args)]
pub struct FitLight {
    /// Which sensor.
    #[command(flatten)]
    pub design: Design,
    /// The camera's file: fabkit's, OpenCV's, ROS's or Kalibr's; on a pad [default: its nominal lens]
    #[arg(long, value_name = "FILE.yaml")]
    pub camera: Option<PathBuf>,
    /// On a pad: pose file with `camera_from_sensor` [default: where the design puts the camera]; a dome's pins tell it
    #[arg(long, value_name = "FILE")]
    pub pose: Option<PathBuf>,
    /// On a pad, instead of a camera: pictures that were made straight, with so much of it to a pixel, their middle on its own
    #[arg(long, value_parser = pixel_size, value_name = "LENGTH", conflicts_with_all = ["camera", "pose"])]
    pub scale: Option<f64>,
    /// On a pad: diameter of the ball that each capture shows
    #[arg(long, value_parser = ball_diameter, value_name = "LENGTH")]
    pub ball_diameter: Option<f64>,
    /// Folder of pictures: of a dome named after the holes that had pins, as 01_05_08.png, or with a list in captures.csv; of
    /// a pad with one ball each
    #[arg(long, value_name = "DIR")]
    pub captures: PathBuf,
    /// The picture without contact [default: ref.png in the folder]
    #[arg(long, value_name = "IMAGE")]
    pub reference: Option<PathBuf>,
    /// Where pins touch: a dome's landmarks, or a JSON map of hole number to [x, y, z] in mm
    /// [default: those of the sensor's own pin-dome]
    #[arg(long, value_name = "FILE.json")]
    pub landmarks: Option<PathBuf>,
    /// Which kind of pin was used, where the dome has several
    #[arg(long, value_name = "KIND")]
    pub pin: Option<String>,
    /// Radius of the pins' round tips [default: what the landmarks say, else that of the sensor's own pin-dome]
    #[arg(long, value_parser = pin_radius, value_name = "LENGTH")]
    pub pin_radius: Option<f64>,
    /// Write the constants for `capture --constants`
    #[arg(short, long, value_name = "FILE.json")]
    pub output: Option<PathBuf>,
}

/// `fabkit reconstruct`.
#[derive(Debug, Args)]
pub struct Reconstruct {
    /// Which sensor.
    #[command(flatten)]
    pub design: Design,
    /// Pictures with contact: PNG, JPEG, TIFF or BMP
    #[arg(required = true, value_name = "IMAGE")]
    pub pictures: Vec<PathBuf>,
    /// The picture without contact, from the same camera
    #[arg(long, value_name = "IMAGE")]
    pub reference: PathBuf,
    /// Where the camera is.
    #[command(flatten)]
    pub camera: CameraArgs,
    /// What lights it.
    #[command(flatten)]
    pub light: LightArgs,
    /// A network to find depth with: a chain of convolutions; FILE.json beside it says what it takes [default: depth from
    /// the light's own laws]
    #[arg(long, value_name = "FILE.onnx", conflicts_with = "constants")]
    pub network: Option<PathBuf>,
    /// The folder to write one NPZ file for each picture into
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
}

const PIN_RADIUS_LIMITS_MM: [f64; 2] = [0.1, 5.0];
const BALL_DIAMETER_LIMITS_MM: [f64; 2] = [1.0, 20.0];
const PIXEL_LIMITS_MM: [f64; 2] = [0.001, 1.0];

fn ball_diameter(text: &str) -> Result<f64, String> {
    length_within(text, BALL_DIAMETER_LIMITS_MM)
}

fn pixel_size(text: &str) -> Result<f64, String> {
    length_within(text, PIXEL_LIMITS_MM)
}

fn pin_radius(text: &str) -> Result<f64, String> {
    length_within(text, PIN_RADIUS_LIMITS_MM)
}
