//! Options of `fabkit depth` and `fabkit dataset`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use fabkit_application::Error;
use fabkit_application::dataset::{DatasetRequest, ImageRequest};
use fabkit_application::fixtures::Press;
use fabkit_application::ground_truth::MapQuantity;
use fabkit_application::scene::{Cast, MARGIN_LIMITS_MM, MAX_SAMPLES, SIGMA_LIMITS_MM};

use super::options::options;
use super::pressing::{ContactOptions, shear};
use super::{Design, length_within};

const PROBE_LIMITS_MM: [f64; 2] = [0.01, 20.0];
const MAX_PROBES: i64 = 10_000_000;

/// Camera and pose.
#[derive(Debug, Args)]
pub struct CameraArgs {
    /// Camera file (fabkit, OpenCV, ROS, Kalibr and others; FILE#NAME for one of several cameras) [default: the one named in the pose file, else the sensor's nominal lens]
    #[arg(long, value_name = "FILE")]
    pub camera: Option<PathBuf>,
    /// Pose file with `camera_from_sensor` [default: the design's pose]
    #[arg(long, value_name = "FILE")]
    pub pose: Option<PathBuf>,
}

/// Camera, pose and contact model.
#[derive(Debug, Args)]
pub struct View {
    /// Camera and pose.
    #[command(flatten)]
    pub camera: CameraArgs,
    /// Contact model.
    #[command(flatten)]
    pub contact: ContactOptions,
}

/// `fabkit depth`.
#[derive(Debug, Args)]
#[command(group(clap::ArgGroup::new("what").args(["press", "reference"]).required(true)))]
#[command(group(
    clap::ArgGroup::new("outputs").args(["output", "png", "grey", "tiff", "mask", "coverage_map", "ply"]).required(true)
        .multiple(true)
))]
pub struct Depth {
    /// The sensor.
    #[command(flatten)]
    pub design: Design,
    /// Camera, pose and contact model.
    #[command(flatten)]
    pub view: View,
    /// A press, for example `semi-dome-017`, `semi-dome-017-flipped`, or `hemisphere@30deg,120deg,1.2mm`: an indenter at a
    /// polar angle, azimuth and indentation; may be repeated
    #[arg(long, value_name = "ID")]
    pub press: Vec<String>,
    /// Compute the surface at rest, without contact
    #[arg(long)]
    pub reference: bool,
    /// Options shared with the Python package.
    #[command(flatten)]
    pub options: CastOptions,
    /// Write all maps for NumPy
    #[arg(short, long, value_name = "FILE.npz")]
    pub output: Option<PathBuf>,
    /// Write a map as a colour image with a scale
    #[arg(long, value_name = "FILE.png")]
    pub png: Option<PathBuf>,
    /// Write the mask of pixels that see the surface: white on black, 8 bits
    #[arg(long, value_name = "FILE.png")]
    pub mask: Option<PathBuf>,
    /// Write the camera's coverage of the unrolled surface, and what hides the rest
    #[arg(long, value_name = "FILE.png")]
    pub coverage_map: Option<PathBuf>,
    /// Write a map as a 16-bit greyscale image, 0.001 mm per step
    #[arg(long, value_name = "FILE.png")]
    pub grey: Option<PathBuf>,
    /// Write a map as a 32-bit floating-point TIFF, mm
    #[arg(long, value_name = "FILE.tiff")]
    pub tiff: Option<PathBuf>,
    /// Map in image files and TIFF [default: indentation with --press, else range]
    #[arg(long, value_enum, value_name = "MAP")]
    pub show: Option<ShownArg>,
    /// Write the point cloud of the pixels
    #[arg(long, value_name = "FILE.ply")]
    pub ply: Option<PathBuf>,
}

options! {
    /// Options of `fabkit depth` besides the contact model, and keyword arguments of `fabkit.depth.cast` in Python.
    pub struct CastOptions {
        /// Tangential motion of the indenter after pressing, linear contact only: on a dome away from the tip and around it,
        /// at the deepest point; on a pad along x and y
        #[arg(long, value_parser = shear, default_value = "0mm,0mm", value_name = "LENGTH,LENGTH", allow_hyphen_values = true)]
        pub shear: [f64; 2],
        /// Continue if a press does not touch the surface or the camera does not see it
        #[arg(long, requires = "press")]
        pub allow_no_contact: bool,
        /// Cast N x N rays per pixel; maps become N times as large each way
        #[arg(long, value_name = "N", default_value = "1",
              value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SAMPLES)))]
        pub samples: u32,
        /// Standard deviation of printed and cast surfaces along their normals, 0 mm to 1 mm
        #[arg(long, value_parser = sigma, default_value = "0.05mm", value_name = "LENGTH")]
        pub print_sigma: f64,
    }
}

impl CastOptions {
    /// Builds the request for ground truth of `presses` with the given contact model.
    ///
    /// # Errors
    /// As [`ContactOptions::contact`].
    pub fn cast<'a>(
        &self,
        presses: &'a [Press],
        contact: &ContactOptions,
    ) -> Result<Cast<'a>, Error> {
        Ok(Cast {
            presses,
            samples: self.samples,
            contact: contact.contact()?,
            shear_mm: self.shear,
            print_sigma_mm: self.print_sigma,
            allow_no_contact: self.allow_no_contact,
        })
    }
}

/// A map of `depth --show`.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum ShownArg {
    /// Distance along the ray
    Range,
    /// Depth along the camera's axis
    Z,
    /// Range without contact minus range with contact
    Indentation,
    /// Standard deviation of the range
    Sigma,
}

impl From<ShownArg> for MapQuantity {
    fn from(arg: ShownArg) -> Self {
        match arg {
            ShownArg::Range => Self::Range,
            ShownArg::Z => Self::Z,
            ShownArg::Indentation => Self::Indentation,
            ShownArg::Sigma => Self::Sigma,
        }
    }
}

/// `fabkit dataset`.
#[derive(Debug, Args)]
pub struct Dataset {
    /// The sensor.
    #[command(flatten)]
    pub design: Design,
    /// Camera, pose and contact model.
    #[command(flatten)]
    pub view: View,
    /// Folder of the data set; with --probes the CSV file
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Options shared with the Python package.
    #[command(flatten)]
    pub options: DatasetOptions,
    /// Also write an overview image of random samples
    #[arg(long, value_name = "FILE.png", conflicts_with = "probes")]
    pub contact_sheet: Option<PathBuf>,
    /// Write a list of single presses instead: the indenter's tip in space and in the image
    #[arg(long, conflicts_with_all = ["presses", "materialise", "resume"])]
    pub probes: bool,
    /// Number of probes
    #[arg(long, value_name = "N", default_value = "33803", requires = "probes",
          value_parser = clap::value_parser!(u32).range(1..=MAX_PROBES))]
    pub count: u32,
    /// Largest indentation of a probe [default: 1.6mm, or the thickness of the soft layers if less]
    #[arg(long, value_parser = probe_length, value_name = "LENGTH", requires = "probes")]
    pub depth: Option<f64>,
}

options! {
    /// Options of `fabkit dataset`, and keyword arguments of `fabkit.dataset.write` in Python.
    pub struct DatasetOptions {
        /// Text file of presses for the left half, one per line: an ID, or `NAME = ID + ID`, with linear contact followed by
        /// `shear 0.5mm,0mm`
        /// [default: all semi-domes or half-plates of the sensor]
        #[arg(long, value_name = "FILE")]
        pub presses: Option<PathBuf>,
        /// Continue if a press does not touch the surface or the camera sees no probe's tip
        #[arg(long)]
        pub allow_no_contact: bool,
        /// Write all stitched samples, not only their halves
        #[arg(long)]
        pub materialise: bool,
        /// Continue an interrupted run of the same command
        #[arg(long)]
        pub resume: bool,
        /// Seed of the split into training, validation and test, and of the probes
        #[arg(long, value_name = "N", default_value = "1")]
        pub seed: u64,
        /// Margin to leave out on both sides of the seam between the halves, 0 mm to 10 mm
        #[arg(long, value_parser = margin, default_value = "0.5mm", value_name = "LENGTH")]
        pub seam_margin: f64,
        /// Captured images to stitch like the halves: a folder with `PATTERN-left.png` and `PATTERN-right.png`, or a CSV file
        /// with the columns pattern, side, file
        #[arg(long, value_name = "DIR|CSV", conflicts_with = "probes")]
        pub captures: Option<PathBuf>,
        /// Simulate an image of each half, as `capture` does, and stitch them like the halves; --seed determines the noise of
        /// each
        #[arg(long, conflicts_with_all = ["probes", "captures"])]
        pub images: bool,
        /// Light source that is on in simulated images [default: the sensor's usual one]
        #[arg(long, value_name = "NAME", requires = "images")]
        pub light: Option<String>,
        /// Specimen number for simulated images and ground truth, as for `capture`
        #[arg(long, value_name = "N", requires = "images")]
        pub unit: Option<u64>,
        /// Light constants of a unit for simulated images, written by `fit-light`
        #[arg(long, value_name = "FILE.json", requires = "images")]
        pub constants: Option<PathBuf>,
    }
}

impl DatasetOptions {
    /// Builds the request for a data set with the given contact model.
    ///
    /// # Errors
    /// As [`ContactOptions::contact`].
    pub fn request(&self, contact: &ContactOptions) -> Result<DatasetRequest<'_>, Error> {
        Ok(DatasetRequest {
            presses: self.presses.as_deref(),
            captures: self.captures.as_deref(),
            images: self.images.then_some(ImageRequest {
                light: self.light.as_deref(),
                constants: self.constants.as_deref(),
            }),
            contact: contact.contact()?,
            seam_margin_mm: self.seam_margin,
            allow_no_contact: self.allow_no_contact,
            seed: self.seed,
            materialise: self.materialise,
            resume: self.resume,
        })
    }
}

fn sigma(text: &str) -> Result<f64, String> {
    length_within(text, SIGMA_LIMITS_MM)
}

fn margin(text: &str) -> Result<f64, String> {
    length_within(text, MARGIN_LIMITS_MM)
}

fn probe_length(text: &str) -> Result<f64, String> {
    length_within(text, PROBE_LIMITS_MM)
}
