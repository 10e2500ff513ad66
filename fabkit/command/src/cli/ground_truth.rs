//! `fabkit depth` and `fabkit dataset`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use fabkit_application::Error;
use fabkit_application::dataset::{DatasetRequest, ImageRequest};
use fabkit_application::fixtures::Press;
use fabkit_application::ground_truth::Shown;
use fabkit_application::scene::{Cast, MARGIN_LIMITS_MM, MAX_SAMPLES, SIGMA_LIMITS_MM};

use super::options::options;
use super::pressing::{ContactOptions, shear};
use super::{Design, length_within};

const PROBE_LIMITS_MM: [f64; 2] = [0.01, 20.0];
const MAX_PROBES: i64 = 10_000_000;

/// Where the camera is.
#[derive(Debug, Args)]
pub struct CameraArgs {
    /// Camera file (fabkit, OpenCV, ROS or Kalibr) [default: the one that the pose file names, else
    /// the sensor's nominal lens]
    #[arg(long, value_name = "FILE")]
    pub camera: Option<PathBuf>,
    /// Pose file with `camera_from_sensor` [default: where the design puts the camera]
    #[arg(long, value_name = "FILE")]
    pub pose: Option<PathBuf>,
}

/// Where the camera is, and how truth is computed.
#[derive(Debug, Args)]
pub struct View {
    /// Where the camera is.
    #[command(flatten)]
    pub camera: CameraArgs,
    /// How the surface answers.
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
    /// Which sensor.
    #[command(flatten)]
    pub design: Design,
    /// Where the camera is.
    #[command(flatten)]
    pub view: View,
    /// What presses, for example `semi-dome-017`, `semi-dome-017-flipped`, or
    /// `hemisphere@30deg,120deg,1.2mm`: an indenter by polar angle, azimuth and depth; may be
    /// repeated
    #[arg(long, value_name = "ID")]
    pub press: Vec<String>,
    /// Nothing presses
    #[arg(long)]
    pub reference: bool,
    /// How it is cast.
    #[command(flatten)]
    pub options: CastOptions,
    /// Write all maps for NumPy
    #[arg(short, long, value_name = "FILE.npz")]
    pub output: Option<PathBuf>,
    /// Write a map in colours with a scale
    #[arg(long, value_name = "FILE.png")]
    pub png: Option<PathBuf>,
    /// Write which pixels see the surface: white on black, 8-bit grey
    #[arg(long, value_name = "FILE.png")]
    pub mask: Option<PathBuf>,
    /// Write which places of the unrolled surface the camera sees, and what keeps it from the others
    #[arg(long, value_name = "FILE.png")]
    pub coverage_map: Option<PathBuf>,
    /// Write a map in 16-bit grey, 0.001 mm a step
    #[arg(long, value_name = "FILE.png")]
    pub grey: Option<PathBuf>,
    /// Write a map in 32-bit floating point, mm
    #[arg(long, value_name = "FILE.tiff")]
    pub tiff: Option<PathBuf>,
    /// Which map pictures and TIFF show [default: indentation if something presses, else range]
    #[arg(long, value_enum, value_name = "MAP")]
    pub show: Option<ShownArg>,
    /// Write the points that the pixels see
    #[arg(long, value_name = "FILE.ply")]
    pub ply: Option<PathBuf>,
}

options! {
    /// How ground truth is cast, beside how the surface answers: options of `fabkit depth`, and keyword arguments of
    /// `fabkit.depth.cast` in Python.
    pub struct CastOptions {
        /// How far all that presses then moves along the surface, in linear contact: on a dome away from the tip and around
        /// it where it goes deepest, on a pad along x and y
        #[arg(long, value_parser = shear, default_value = "0mm,0mm", value_name = "LENGTH,LENGTH", allow_hyphen_values = true)]
        pub shear: [f64; 2],
        /// Go on where a press does not touch the surface, or where the camera sees nothing of it
        #[arg(long, requires = "press")]
        pub allow_no_contact: bool,
        /// Cast N x N rays for each pixel; the maps grow by that
        #[arg(long, value_name = "N", default_value = "1",
              value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SAMPLES)))]
        pub samples: u32,
        /// Standard deviation of printed and cast surfaces along their normals, 0 mm to 1 mm
        #[arg(long, value_parser = sigma, default_value = "0.05mm", value_name = "LENGTH")]
        pub print_sigma: f64,
    }
}

impl CastOptions {
    /// The truth of `presses` on a surface that answers so.
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

/// A map.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum ShownArg {
    /// Distance along the ray
    Range,
    /// Depth along the camera's axis
    Z,
    /// Range without contact minus range with it
    Indentation,
    /// Standard deviation of the range
    Sigma,
}

impl From<ShownArg> for Shown {
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
    /// Which sensor.
    #[command(flatten)]
    pub design: Design,
    /// Where the camera is.
    #[command(flatten)]
    pub view: View,
    /// Folder of the data set; with --probes, the CSV file
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// What it is made of.
    #[command(flatten)]
    pub options: DatasetOptions,
    /// Also write a picture of random samples
    #[arg(long, value_name = "FILE.png", conflicts_with = "probes")]
    pub contact_sheet: Option<PathBuf>,
    /// Instead, list single presses of one indenter: where its tip is, and where it is seen
    #[arg(long, conflicts_with_all = ["presses", "materialise", "resume"])]
    pub probes: bool,
    /// How many probes
    #[arg(long, value_name = "N", default_value = "33803", requires = "probes",
          value_parser = clap::value_parser!(u32).range(1..=MAX_PROBES))]
    pub count: u32,
    /// Deepest probe [default: 1.6 mm, or as deep as the surface is soft]
    #[arg(long, value_parser = probe_length, value_name = "LENGTH", requires = "probes")]
    pub depth: Option<f64>,
}

options! {
    /// What a data set is made of: options of `fabkit dataset`, and keyword arguments of `fabkit.dataset.write` in Python.
    pub struct DatasetOptions {
        /// Text file of patterns for the left side, one a line: an ID, or `NAME = ID + ID`, and in linear contact
        /// `shear 0.5mm,0mm` after it
        /// [default: all semi-domes or half-plates of the sensor]
        #[arg(long, value_name = "FILE")]
        pub presses: Option<PathBuf>,
        /// Go on where a press does not touch the surface, or where the camera sees no probe's tip
        #[arg(long)]
        pub allow_no_contact: bool,
        /// Write all stitched samples, not only the halves that they consist of
        #[arg(long)]
        pub materialise: bool,
        /// Go on where an earlier run of the same command was stopped
        #[arg(long)]
        pub resume: bool,
        /// Which patterns are for training, validation and test; where probes start
        #[arg(long, value_name = "N", default_value = "1")]
        pub seed: u64,
        /// Leave out what lies this near to the seam between the halves, 0 mm to 10 mm
        #[arg(long, value_parser = margin, default_value = "0.5mm", value_name = "LENGTH")]
        pub seam_margin: f64,
        /// Pictures to be stitched like the halves: a folder with `PATTERN-left.png` and
        /// `PATTERN-right.png`, or a CSV file with the columns pattern, side, file
        #[arg(long, value_name = "DIR|CSV", conflicts_with = "probes")]
        pub captures: Option<PathBuf>,
        /// Take a picture of each half, as `capture` does, and stitch them like the halves; each with noise of its own, which
        /// --seed decides
        #[arg(long, conflicts_with_all = ["probes", "captures"])]
        pub images: bool,
        /// Which of the sensor's lights is on in them [default: its usual one]
        #[arg(long, value_name = "NAME", requires = "images")]
        pub light: Option<String>,
        /// In them and in the truth: of another sensor of the same design, as for `capture`
        #[arg(long, value_name = "N", requires = "images")]
        pub unit: Option<u64>,
        /// Constants of a unit's light for them, as `fit-light` writes them
        #[arg(long, value_name = "FILE.json", requires = "images")]
        pub constants: Option<PathBuf>,
    }
}

impl DatasetOptions {
    /// The data set of a surface that answers so.
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
