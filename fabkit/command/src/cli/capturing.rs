//! Options of `fabkit capture`, `optics-pack`, `fit-light` and `reconstruct`.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};
use fabkit_application::Error;
use fabkit_application::capturing::{CaptureRequest, LightConstants};
use fabkit_application::fixtures::Press;
use fabkit_application::geometry::Lighting;
use fabkit_application::press_simulation::{ContactModel, LinearOptions};
use fabkit_application::scene::{Cast, MAX_SAMPLES};

use super::ground_truth::CameraArgs;
use super::options::options;
use super::pressing::{depth, friction, shear, spacing};
use super::{Design, length_within};

const LIGHT: &str = "Light source that is on, for example `uv` [default: the sensor's usual one]";
const CONSTANTS: &str =
    "Light constants of a unit, written by `fit-light` [default: those of R-Tac0's published unit]";

/// Standard deviation of printed and cast surfaces in `--truth` files, mm; the default of `depth --print-sigma`.
const PRINT_SIGMA_MM: f64 = 0.05;

/// Light of a capture.
#[derive(Debug, Args)]
pub struct LightArgs {
    /// Light source that is on.
    #[arg(long, value_name = "NAME", help = LIGHT)]
    pub light: Option<String>,
    /// File with the light constants of a unit.
    #[arg(long, value_name = "FILE.json", help = CONSTANTS)]
    pub constants: Option<PathBuf>,
}

/// `fabkit capture`.
#[derive(Debug, Args)]
#[command(group(clap::ArgGroup::new("what").args(["press", "indenter", "reference"]).required(true)))]
pub struct Capture {
    /// The sensor.
    #[command(flatten)]
    pub design: Design,
    /// Camera and pose.
    #[command(flatten)]
    pub camera: CameraArgs,
    /// A press, for example `semi-dome-017`, or `hemisphere@30deg,120deg,1.2mm`: an indenter at a polar angle,
    /// azimuth and indentation; may be repeated
    #[arg(long, value_name = "ID")]
    pub press: Vec<String>,
    /// A press without its indentation, which --depth gives: for example `ball@30deg,120deg`
    #[arg(long, value_name = "INDENTER@PLACE", requires = "depth")]
    pub indenter: Option<String>,
    /// Indentation by --indenter, along the surface's normal at the contact
    #[arg(long, value_parser = depth, value_name = "LENGTH", requires = "indenter")]
    pub depth: Option<f64>,
    /// Take the reference image, without contact
    #[arg(long)]
    pub reference: bool,
    /// Options shared with the Python package.
    #[command(flatten)]
    pub options: CaptureOptions,
    /// Bits per channel in the image file
    #[arg(long, value_name = "N", default_value = "8", value_parser = ["8", "16"])]
    pub bits: String,
    /// Image file to write
    #[arg(short, long, value_name = "FILE.png", required = true)]
    pub output: PathBuf,
    /// Write the ground truth of the image for NumPy, as `depth -o` does
    #[arg(long, value_name = "FILE.npz")]
    pub truth: Option<PathBuf>,
}

options! {
    /// Options of `fabkit capture` and keyword arguments of `fabkit.depth.Scene.capture`.
    pub struct CaptureOptions {
        /// Tangential motion of the indenter after pressing, linear contact only: on a dome away from the tip and around it,
        /// at the deepest point; on a pad along x and y
        #[arg(long, value_parser = shear, default_value = "0mm,0mm", value_name = "LENGTH,LENGTH", allow_hyphen_values = true)]
        pub shear: [f64; 2],
        /// Contact model
        #[arg(long, value_parser = contact_levels(), value_name = "LEVEL", default_value = "linear")]
        pub contact: String,
        /// Coulomb friction coefficient for --shear [default: of the touched material]
        #[arg(long, value_parser = friction, value_name = "NUMBER", allow_hyphen_values = true)]
        pub friction: Option<f64>,
        /// Node spacing on the surface, linear contact only [default: as fine as a few seconds allow]
        #[arg(long, value_parser = spacing, value_name = "LENGTH")]
        pub spacing: Option<f64>,
        /// Continue if a press does not touch the surface or the camera does not see it
        #[arg(long, conflicts_with = "reference")]
        pub allow_no_contact: bool,
        /// Cast N x N rays per pixel and average them
        #[arg(long, value_name = "N", default_value = "1",
              value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SAMPLES)))]
        pub samples: u32,
        /// Light source that is on.
        #[arg(long, value_name = "NAME", help = LIGHT)]
        pub light: Option<String>,
        /// File with the light constants of a unit.
        #[arg(long, value_name = "FILE.json", help = CONSTANTS)]
        pub constants: Option<PathBuf>,
        /// Simulate specimen N of the design: dimensions, camera pose, light sources and layers vary within their tolerances;
        /// the same number gives the same specimen [default: the nominal design]
        #[arg(long, value_name = "N")]
        pub unit: Option<u64>,
        /// Seed of noise and drift
        #[arg(long, value_name = "N", default_value = "0")]
        pub seed: u64,
        /// Without noise, drift and the camera's JPEG compression
        #[arg(long, conflicts_with = "seed")]
        pub no_noise: bool,
    }
}

/// Values of `capture --contact`.
fn contact_levels() -> PossibleValuesParser {
    PossibleValuesParser::new([
        PossibleValue::new("rigid").help("The surface follows the indenter; nothing else moves"),
        PossibleValue::new("linear").help("Elastic layers that yield and bulge, small strain"),
    ])
}

impl CaptureOptions {
    /// Builds the capture request of `presses` under `lighting`.
    ///
    /// # Errors
    /// [`PressingError::Contact`](fabkit_application::press_simulation::PressingError::Contact): no such contact model, or an option of another model.
    pub fn capturing<'a>(
        &self,
        presses: &'a [Press],
        lighting: &'a Lighting,
        constants: &'a LightConstants,
    ) -> Result<CaptureRequest<'a>, Error> {
        let linear = LinearOptions { spacing_mm: self.spacing, friction: self.friction };
        let cast = Cast {
            presses,
            samples: self.samples,
            contact: ContactModel::from_name(Some(&self.contact), 0.0, linear)?,
            shear_mm: self.shear,
            print_sigma_mm: PRINT_SIGMA_MM,
            allow_no_contact: self.allow_no_contact,
        };
        let seed = (!self.no_noise).then_some(self.seed);
        Ok(CaptureRequest { cast, lighting, constants, seed })
    }
}

/// `fabkit optics-pack`.
#[derive(Debug, Args)]
pub struct OpticsPack {
    /// The sensor.
    #[command(flatten)]
    pub design: Design,
    /// Camera and pose.
    #[command(flatten)]
    pub camera: CameraArgs,
    /// Light.
    #[command(flatten)]
    pub light: LightArgs,
    /// Output folder
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
}

/// `fabkit fit-light`.
#[derive(Debug, Args)]
pub struct FitLight {
    /// The sensor.
    #[command(flatten)]
    pub design: Design,
    /// Camera file (fabkit, OpenCV, ROS, Kalibr and others; FILE#NAME for one of several cameras); required for domes [default on a pad: its nominal lens]
    #[arg(long, value_name = "FILE.yaml")]
    pub camera: Option<PathBuf>,
    /// On a pad: pose file with `camera_from_sensor` [default: the design's pose]; on a dome the pins determine it
    #[arg(long, value_name = "FILE")]
    pub pose: Option<PathBuf>,
    /// On a pad, instead of a camera: size of a pixel in rectified images that are centred on the pad
    #[arg(long, value_parser = pixel_size, value_name = "LENGTH", conflicts_with_all = ["camera", "pose"])]
    pub scale: Option<f64>,
    /// On a pad: diameter of the ball in each capture
    #[arg(long, value_parser = ball_diameter, value_name = "LENGTH")]
    pub ball_diameter: Option<f64>,
    /// Folder of captures: on a dome named after the holes with pins, as 01_05_08.png, or listed in captures.csv; on a pad
    /// one ball each
    #[arg(long, value_name = "DIR")]
    pub captures: PathBuf,
    /// Reference image without contact [default: ref.png in the folder]
    #[arg(long, value_name = "IMAGE")]
    pub reference: Option<PathBuf>,
    /// Contact points of the pins: a landmarks file, or a JSON map of hole number to [x, y, z] in mm
    /// [default: those of the sensor's pin-dome]
    #[arg(long, value_name = "FILE.json")]
    pub landmarks: Option<PathBuf>,
    /// Kind of pin that was used, if the dome has several
    #[arg(long, value_name = "KIND")]
    pub pin: Option<String>,
    /// Radius of the pins' rounded tips [default: from the landmarks, else from the sensor's pin-dome]
    #[arg(long, value_parser = pin_radius, value_name = "LENGTH")]
    pub pin_radius: Option<f64>,
    /// File of constants to write, for `capture --constants`
    #[arg(short, long, value_name = "FILE.json")]
    pub output: Option<PathBuf>,
    /// Write the file even if images or results are implausible
    #[arg(long)]
    pub force: bool,
}

/// `fabkit reconstruct`.
#[derive(Debug, Args)]
pub struct Reconstruct {
    /// The sensor.
    #[command(flatten)]
    pub design: Design,
    /// Images with contact: PNG, JPEG, TIFF or BMP
    #[arg(required = true, value_name = "IMAGE")]
    pub images: Vec<PathBuf>,
    /// Reference image without contact, from the same camera
    #[arg(long, value_name = "IMAGE")]
    pub reference: PathBuf,
    /// Camera and pose.
    #[command(flatten)]
    pub camera: CameraArgs,
    /// Light.
    #[command(flatten)]
    pub light: LightArgs,
    /// Neural network (a chain of convolutions) that predicts indentation; FILE.json beside it describes its input
    /// [default: the physics of the light]
    #[arg(long, value_name = "FILE.onnx", conflicts_with = "constants")]
    pub network: Option<PathBuf>,
    /// Output folder for one NPZ file per image
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Write files even if images or results are implausible
    #[arg(long)]
    pub force: bool,
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
