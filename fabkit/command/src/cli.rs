//! Arguments and options of the command line. Values with a unit or a limit are checked here, while they are parsed;
//! what depends on the sensor is checked by the command.

mod beds;
mod bench;
mod calibrate;
mod capturing;
mod completing;
mod examples;
mod ground_truth;
mod guide;
mod new;
mod options;
mod pressing;
#[cfg(test)]
mod python;
mod robots;
mod sweep;

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::LazyLock;

use clap::builder::PossibleValue;
use clap::{Args, Parser, Subcommand, ValueEnum};
use fabkit_application::exports::Format;
use fabkit_application::geometry::Length;
use fabkit_application::images::ViewDirection;
use fabkit_application::memory;
use fabkit_application::packaging::{LICENSES, License};

pub use bench::Bench;
pub use calibrate::{
    Calibrate, CalibrateExtrinsics, CalibrateIntrinsics, CalibratePins, CalibratePlan,
};
pub use capturing::{Capture, CaptureOptions, FitLight, LightArgs, OpticsPack, Reconstruct};
pub use ground_truth::{CameraArgs, CastOptions, Dataset, DatasetOptions, Depth};
pub use guide::Guide;
pub use new::New;
pub use options::Named;
pub use pressing::{ContactOptions, PressArgs, PressOptions};
pub use robots::RobotArg;
pub use sweep::Sweep;

/// Limits of the edge length of tetrahedra, mm.
const EDGE_LIMITS_MM: [f64; 2] = [0.05, 10.0];
/// Limits of the chord tolerance, mm. Finer, files outgrow any slicer; coarser, a 3 mm bolt hole becomes a triangle.
const TOLERANCE_LIMITS_MM: [f64; 2] = [0.0005, 1.0];
const BED_LIMITS_MM: [f64; 2] = [20.0, 5000.0];
const KERF_LIMITS_MM: [f64; 2] = [0.0, 2.0];
const MAX_THREADS: i64 = 256;

const AFTER_HELP: &str = "\
SENSOR is the name of a built-in sensor or a path to a YAML file; SENSOR/FIXTURE is calibration \
hardware made for it.

FABKIT_MATERIALS names a YAML file with your own materials and processes. fabkit.yaml in the working \
folder sets your defaults for `export`.

Exit codes: 0 success, 1 a check failed, 2 bad input, 3 a limit was exceeded, 4 a file could not be \
read or written, 70 a bug in fabkit, 130 interrupted.";

/// Turns one description of a vision-based tactile sensor into parts, molds, calibration and ground truth.
#[derive(Debug, Parser)]
#[command(name = "fabkit", version, after_help = AFTER_HELP, max_term_width = 100)]
pub struct Cli {
    /// Options of every command.
    #[command(flatten)]
    pub global: Global,
    /// The subcommand with its own options.
    #[command(subcommand)]
    pub command: Command,
}

/// Options of every command.
#[derive(Debug, Args)]
pub struct Global {
    /// Print one JSON document instead of text, also for errors
    #[arg(long, global = true)]
    pub json: bool,
    /// Print errors only
    #[arg(short, long, global = true)]
    pub quiet: bool,
    /// Number of threads [default: one per processor]; the output does not depend on it
    #[arg(long, global = true, value_name = "N",
          value_parser = clap::value_parser!(u16).range(1..=MAX_THREADS))]
    pub threads: Option<u16>,
    /// Largest memory to use; work that would need more is refused before it starts
    #[arg(long, global = true, value_name = "SIZE", value_parser = memory::parse,
          default_value = "2GB")]
    pub memory: u64,
}

/// Subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// List the built-in sensors with their parts, layers and components
    List,
    /// Write a commented sensor file as a starting point for your own sensor
    #[command(after_help = new::after_help())]
    New(New),
    /// Show a sensor's parameters with their sources, its parts and derived values
    #[command(after_help = examples::SHOW)]
    Show(Show),
    /// Check whether a sensor can be built: overlaps, molds, trapped air, demolding, light, wiring
    #[command(after_help = examples::CHECK)]
    Check(Check),
    /// Compare a sensor with independent CAD kernels, or check a folder that fabkit wrote for damage
    #[command(after_help = VERIFY)]
    Verify(Verify),
    /// Write the files to make a sensor's parts: STL, 3MF, DXF and others
    #[command(after_help = examples::EXPORT)]
    Export(Export),
    /// Write a build guide: what to buy, make and mix, and every step with images
    #[command(after_help = examples::GUIDE)]
    Guide(Guide),
    /// Compare two designs: what can be reused, and what must be made, cast or bought
    #[command(after_help = examples::DIFF)]
    Diff(Diff),
    /// Turn measurements of a coupon into a printer's profile or a gel batch's modulus
    #[command(after_help = examples::PROFILE)]
    Profile(Profile),
    /// Render a sensor or one part of it as a PNG image, from the exact geometry
    #[command(after_help = examples::RENDER)]
    Render(Render),
    /// Compute exact depth maps of the touched surface as the camera sees it
    #[command(after_help = examples::DEPTH)]
    Depth(Depth),
    /// Simulate the image that the sensor's camera takes
    #[command(after_help = examples::CAPTURE)]
    Capture(Capture),
    /// Fit the light constants of a real unit to its captures, for `capture --constants`
    #[command(after_help = examples::FIT_LIGHT)]
    FitLight(FitLight),
    /// Reconstruct indentation and marker motion from images
    #[command(after_help = examples::RECONSTRUCT)]
    Reconstruct(Reconstruct),
    /// Run the experiments of the sensor's paper in simulation, beside the published results
    #[command(after_help = examples::BENCH)]
    Bench(Bench),
    /// Render the calibration tables of other simulators: Taxim, TacEx, TacSL
    #[command(after_help = examples::OPTICS_PACK)]
    OpticsPack(OpticsPack),
    /// Compute the elastic response to a press: force curve, contact, displacements
    #[command(after_help = examples::PRESS)]
    Press(PressArgs),
    /// Write a training data set of pressed surfaces with ground truth, or a list of probes
    #[command(after_help = examples::DATASET)]
    Dataset(Dataset),
    /// Calibrate the camera: lens from boards, pose from pins, with uncertainty
    Calibrate {
        /// Kind of calibration.
        #[command(subcommand)]
        what: Calibrate,
    },
    /// Build many variants of a sensor and compute metrics of each
    #[command(after_help = examples::SWEEP)]
    Sweep(Sweep),
    /// Print the JSON Schema of sensor files, for editors
    #[command(after_help = examples::SCHEMA)]
    Schema {
        /// Print the schema of plans for `sweep`
        #[arg(long)]
        sweep: bool,
        /// Print the schema of a command's `--json` document: `show`, `check`, `error`, ...
        #[arg(long, value_name = "NAME", conflicts_with = "sweep")]
        output: Option<String>,
    },
    /// Print a shell's completion script
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Print the manual page, or write all manual pages into a folder
    Man {
        /// Folder for `fabkit.1` and one page per command
        #[arg(short, long, value_name = "DIR")]
        output: Option<PathBuf>,
    },
}

/// `fabkit check`.
#[derive(Debug, Args)]
pub struct Check {
    /// The sensor.
    #[command(flatten)]
    pub design: Design,
    /// Fail also if a property of a material that a rule needs is not known
    #[arg(long)]
    pub strict: bool,
}

/// The design that a command works on.
#[derive(Debug, Args)]
pub struct Design {
    /// Built-in sensor, path to a sensor file, or SENSOR/FIXTURE
    #[arg(add = completing::designs())]
    pub sensor: String,
    /// Set a parameter, for example `surface.radius=14mm`; may be repeated
    #[arg(long = "set", value_name = "PATH=VALUE", add = completing::settings())]
    pub set: Vec<String>,
    /// Keep what you set and adjust fabkit's own choices as little as possible until the design is valid
    #[arg(long)]
    pub fix: bool,
    /// Built-in variant of the sensor: `rtac0 --preset published-2025` is the sensor `rtac0-published-2025`
    #[arg(long, value_name = "NAME")]
    pub preset: Option<String>,
}

const VERIFY: &str = "The kernels are Python packages. They run in the Python that FABKIT_PYTHON names (an absolute path), \
else in `.venv` of fabkit's checkout, made by `cargo xtask verify-env`, if this program lies in the \
checkout's `target` folder. Python starts isolated, without PYTHON* variables, in an empty folder, so \
that nothing of the current folder is executed.

A folder with manifest.json, dataset.json or sweep.json is checked instead: every listed file against its \
size and hash, every chunk against its checksum, the list against its own. Damaged, missing and unlisted \
files are named (exit code 1). Folders of fixtures directly below an export are checked too. If a sensor \
and a folder have the same name, the sensor is meant; write `./NAME` or `NAME/` for the folder.";

/// `fabkit show`.
#[derive(Debug, Args)]
pub struct Show {
    /// The design.
    #[command(flatten)]
    pub design: Design,
    /// Show the build steps and their mixes instead
    #[arg(long)]
    pub chain: bool,
    /// Show the range of each number with all others held; with --fix also with fabkit's own choices free to follow
    #[arg(long, conflicts_with = "chain")]
    pub limits: bool,
}

/// `fabkit export`.
#[derive(Debug, Args)]
pub struct Export {
    /// Built-in sensor, path to a sensor file, or SENSOR/FIXTURE; append `/PART` for one part
    #[arg(add = completing::parts())]
    pub sensor: String,
    /// Set a parameter, for example `surface.radius=14mm`; may be repeated
    #[arg(long = "set", value_name = "PATH=VALUE", add = completing::settings())]
    pub set: Vec<String>,
    /// Keep what you set and adjust fabkit's own choices as little as possible until the design is valid
    #[arg(long)]
    pub fix: bool,
    /// Export the calibration fixtures too, each into its own folder
    #[arg(long, conflicts_with = "parts")]
    pub fixtures: bool,
    /// Export everything that a lab publishes: parts in every format, circuit boards, fixtures, guides, sensor and
    /// camera files, licence and citation
    #[arg(long, conflicts_with_all = ["parts", "format"])]
    pub all: bool,
    /// Write the build guide too, into its own folder
    #[arg(long, conflicts_with = "parts")]
    pub guide: bool,
    /// SPDX identifier of the package's licence, for example CC0-1.0
    #[arg(long, requires = "all", value_parser = license, default_value = "CC-BY-4.0", value_name = "ID")]
    pub license: License,
    /// Author of the design for the package's citation; may be repeated
    #[arg(long = "author", requires = "all", value_name = "NAME")]
    pub authors: Vec<String>,
    /// Write one reproducible archive instead of a folder
    #[arg(long, conflicts_with_all = ["output", "clean"], value_name = "FILE.zip")]
    pub zip: Option<PathBuf>,
    /// Built-in variant of the sensor: `rtac0 --preset published-2025` is the sensor `rtac0-published-2025`
    #[arg(long, value_name = "NAME")]
    pub preset: Option<String>,
    /// Output folder [default: out/SENSOR or out/SENSOR/FIXTURE; fabkit.yaml can replace `out`]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Only this part, layer or component; may be repeated
    #[arg(long = "part", value_name = "NAME")]
    pub parts: Vec<String>,
    /// File formats, separated by commas
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        default_value = "stl,3mf,dxf",
        default_value_if("robot", clap::builder::ArgPredicate::IsPresent, None),
        value_name = "LIST"
    )]
    pub format: Vec<FormatArg>,
    /// Robot descriptions, separated by commas: links with exact masses, touched surface, camera; replaces the default
    /// formats
    #[arg(long, value_enum, value_delimiter = ',', conflicts_with_all = ["parts", "all"], value_name = "LIST")]
    pub robot: Vec<RobotArg>,
    /// Largest distance between the mesh and the exact surface, 0.0005 mm to 1 mm [default: 0.01mm]
    #[arg(long, value_parser = tolerance, value_name = "LENGTH")]
    pub tolerance: Option<f64>,
    /// Edge length of tetrahedra, 0.05 mm to 10 mm; shorter in thinner layers [default: 0.5mm]
    #[arg(long, value_parser = edge, value_name = "LENGTH")]
    pub edge: Option<f64>,
    /// Printer bed for plates: width x depth, or a printer such as `prusa-mk4` [default: 250x210mm]
    #[arg(long, value_parser = bed, value_name = "WxD")]
    pub bed: Option<[f64; 2]>,
    /// Stock sheet for laser-cut parts, width x depth [default: 600x300mm]
    #[arg(long, value_parser = bed, value_name = "WxD")]
    pub stock: Option<[f64; 2]>,
    /// Kerf of your laser, 0 mm to 2 mm [default: typical for the material]
    #[arg(long, value_parser = kerf, value_name = "LENGTH")]
    pub kerf: Option<f64>,
    /// Printer profile from `fabkit profile`: corrects sizes of parts with its process and material
    #[arg(long, value_name = "FILE.yaml")]
    pub process: Option<PathBuf>,
    /// Apply the profile to parts of other materials with the same process, too
    #[arg(long)]
    pub process_for_any_material: bool,
    /// Write nominal geometry, without correction for kerf, printer and shrinkage
    #[arg(long, conflicts_with_all = ["kerf", "process"])]
    pub nominal: bool,
    /// Remove unedited files of earlier exports that this export does not write
    #[arg(long)]
    pub clean: bool,
    /// Replace edited and foreign files too, and do not run `check` on the design
    #[arg(long)]
    pub force: bool,
}

/// `fabkit diff`.
#[derive(Debug, Args)]
pub struct Diff {
    /// Present design: built-in sensor, sensor file, or SENSOR/FIXTURE
    #[arg(value_name = "FROM", add = completing::designs())]
    pub from: String,
    /// New design
    #[arg(value_name = "TO", add = completing::designs())]
    pub to: String,
    /// Set a parameter of the present design
    #[arg(long, value_name = "PATH=VALUE", add = completing::settings())]
    pub set_from: Vec<String>,
    /// Set a parameter of the new design
    #[arg(long, value_name = "PATH=VALUE", add = completing::settings())]
    pub set_to: Vec<String>,
    /// Write an HTML page with images
    #[arg(short, long, value_name = "FILE.html")]
    pub output: Option<PathBuf>,
}

/// `fabkit profile`.
#[derive(Debug, Args)]
pub struct Profile {
    /// Coupon file with your measurements; `export SENSOR/coupon` and `export SENSOR/gel-coupon` write empty ones
    #[arg(value_name = "COUPON.yaml")]
    pub coupon: PathBuf,
    /// File to write: a printer profile named after the file, or materials
    #[arg(short, long, value_name = "FILE.yaml")]
    pub output: PathBuf,
    /// Replace the file even if it was edited or not written by fabkit
    #[arg(long)]
    pub force: bool,
}

/// `fabkit verify`.
#[derive(Debug, Args)]
pub struct Verify {
    /// Built-in sensor or path to a sensor file, with `/PART` for one part; or a folder that `export`, `dataset` or
    /// `sweep` wrote
    #[arg(value_name = "SENSOR|DIR", add = completing::parts())]
    pub sensor: OsString,
    /// Set a parameter, for example `surface.radius=14mm`; may be repeated
    #[arg(long = "set", value_name = "PATH=VALUE", add = completing::settings())]
    pub set: Vec<String>,
    /// Keep what you set and adjust fabkit's own choices as little as possible until the design is valid
    #[arg(long)]
    pub fix: bool,
    /// Only this part, layer or component; may be repeated
    #[arg(long = "part", value_name = "NAME")]
    pub parts: Vec<String>,
    /// Only this kernel; may be repeated
    #[arg(long = "kernel", value_enum, value_name = "KERNEL")]
    pub kernels: Vec<KernelArg>,
    /// Time limit for one part in one kernel, seconds [default: 600]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=86_400), value_name = "SECONDS")]
    pub limit: Option<u32>,
    /// Write an HTML report with images of every disagreement
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// Keep the compared files in this folder, as `export` writes them
    #[arg(long, value_name = "DIR")]
    pub keep: Option<PathBuf>,
}

/// A geometry kernel that is independent of fabkit.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum KernelArg {
    /// OpenCascade through cadquery: exact faces
    Cadquery,
    /// OpenCascade through build123d: exact faces
    Build123d,
    /// Triangles, rebuilt from the tree
    Manifold3d,
    /// The exported STL file
    Trimesh,
}

impl KernelArg {
    /// Returns the kernel's name on the command line and in documents.
    pub fn word(self) -> &'static str {
        match self {
            Self::Cadquery => "cadquery",
            Self::Build123d => "build123d",
            Self::Manifold3d => "manifold3d",
            Self::Trimesh => "trimesh",
        }
    }
}

/// `fabkit render`.
#[derive(Debug, Args)]
pub struct Render {
    /// Built-in sensor, path to a sensor file, or SENSOR/FIXTURE; append `/PART` for one part
    #[arg(add = completing::parts())]
    pub sensor: String,
    /// Set a parameter, for example `surface.radius=14mm`; may be repeated
    #[arg(long = "set", value_name = "PATH=VALUE", add = completing::settings())]
    pub set: Vec<String>,
    /// Keep what you set and adjust fabkit's own choices as little as possible until the design is valid
    #[arg(long)]
    pub fix: bool,
    /// Built-in variant of the sensor: `rtac0 --preset published-2025` is the sensor `rtac0-published-2025`
    #[arg(long, value_name = "NAME")]
    pub preset: Option<String>,
    /// PNG file to write
    #[arg(short, long, value_name = "FILE.png")]
    pub output: PathBuf,
    /// Width x height, px
    #[arg(long, value_parser = image_size, default_value = "1600x1200", value_name = "WxH")]
    pub size: [u32; 2],
    /// Draw the parts of the assembly apart
    #[arg(long)]
    pub exploded: bool,
    /// View: front, back, left, right, top, bottom, or azimuth from +x and elevation, degrees
    #[arg(long, value_name = "SIDE|AZ,EL", allow_hyphen_values = true)]
    pub view: Option<ViewDirection>,
    /// Cut the assembly open by a vertical plane through its axis; removes the half nearer to the viewer (without --view:
    /// the front half)
    #[arg(long)]
    pub section: bool,
    /// Assembly to draw, for example one of the molds [default: sensor]
    #[arg(long, value_name = "NAME")]
    pub assembly: Option<String>,
    /// Draw the camera's rays in a section through its pupil: refracted at the drawn faces, coloured by the body they end
    /// at; from the front without --view
    #[arg(long, conflicts_with_all = ["exploded", "assembly"])]
    pub rays: bool,
    /// Draw the view of the sensor's camera through all clear bodies, in its own resolution.
    /// `--camera=FILE` uses a camera file (fabkit, OpenCV, ROS, Kalibr and others; FILE#NAME for one of several cameras) instead of the nominal lens
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true,
          conflicts_with_all = ["exploded", "assembly", "section", "view", "size", "rays"])]
    pub camera: Option<Option<PathBuf>>,
    /// Pose file with `camera_from_sensor`, for --rays and --camera [default: the design's pose]
    #[arg(long, value_name = "FILE")]
    pub pose: Option<PathBuf>,
}

/// A file format of `--format`.
#[derive(Clone, Copy, Debug)]
pub enum FormatArg {
    /// Written by fabkit.
    Own(Format),
    /// STEP, written by the verifier's OpenCascade.
    Step,
}

/// All values of `--format`, in the order of its help.
static FORMATS: LazyLock<Vec<FormatArg>> = LazyLock::new(|| {
    let mut all: Vec<_> = Format::ALL.into_iter().map(FormatArg::Own).collect();
    let after_tree = Format::ALL.iter().position(|format| *format == Format::Tree);
    all.insert(after_tree.map_or(0, |tree| tree + 1), FormatArg::Step);
    all
});

impl ValueEnum for FormatArg {
    fn value_variants<'a>() -> &'a [Self] {
        &FORMATS
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let (word, help) = match self {
            Self::Own(format) => (format.word(), format.summary()),
            Self::Step => (
                "step",
                "B-rep with true faces, through the verifier's OpenCascade; for all parts, the assembly too",
            ),
        };
        Some(PossibleValue::new(word).help(help))
    }
}

impl FormatArg {
    /// Returns the format if fabkit writes it itself, `None` for STEP.
    pub fn own(self) -> Option<Format> {
        match self {
            Self::Own(format) => Some(format),
            Self::Step => None,
        }
    }
}

pub(crate) fn license(text: &str) -> Result<License, String> {
    License::from_id(text).ok_or_else(|| {
        let known = LICENSES.map(|license| license.id);
        format!("known licences are {}", known.join(", "))
    })
}

pub(crate) fn edge(text: &str) -> Result<f64, String> {
    length_within(text, EDGE_LIMITS_MM)
}

pub(crate) fn tolerance(text: &str) -> Result<f64, String> {
    length_within(text, TOLERANCE_LIMITS_MM)
}

pub(crate) fn kerf(text: &str) -> Result<f64, String> {
    length_within(text, KERF_LIMITS_MM)
}

fn length_within(text: &str, [min, max]: [f64; 2]) -> Result<f64, String> {
    let mm = text.parse::<Length>().map_err(|e| e.to_string())?.mm();
    if (min..=max).contains(&mm) {
        Ok(mm)
    } else {
        Err(format!("{mm} mm is not between {min} mm and {max} mm"))
    }
}

/// Parses a bed: a printer's name, `250x210mm`, or a unit on both lengths.
pub(crate) fn bed(text: &str) -> Result<[f64; 2], String> {
    if let Some(size_mm) = beds::find_bed(text) {
        return Ok(size_mm);
    }
    if !text.starts_with(|c: char| c.is_ascii_digit()) {
        return Err(beds::unknown_bed(text));
    }
    let (width, depth) = split_size(text)?;
    let unit = depth.trim_start_matches(|c: char| !c.is_alphabetic());
    let bare = width.trim().chars().all(|c| c.is_ascii_digit() || c == '.');
    let width = if bare { format!("{width}{unit}") } else { width.to_owned() };
    Ok([length_within(&width, BED_LIMITS_MM)?, length_within(depth, BED_LIMITS_MM)?])
}

fn image_size(text: &str) -> Result<[u32; 2], String> {
    let (width, height) = split_size(text)?;
    let side = |text: &str| match text.trim().parse::<u32>() {
        Ok(0) | Err(_) => Err(format!("`{text}` is not a number of pixels above 0")),
        Ok(px) => Ok(px),
    };
    Ok([side(width)?, side(height)?])
}

fn split_size(text: &str) -> Result<(&str, &str), String> {
    text.split_once('x').ok_or_else(|| "write width x height, for example 800x600".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_definition_is_sound() {
        use clap::CommandFactory;
        Cli::command().debug_assert();
    }

    #[test]
    fn tolerances_have_a_unit_and_limits() {
        assert_eq!(tolerance("0.01mm"), Ok(0.01));
        assert_eq!(tolerance("0.5 um"), Ok(0.0005));
        assert_eq!(tolerance("2 mm").unwrap_err(), "2 mm is not between 0.0005 mm and 1 mm");
        assert!(tolerance("0.4 um").is_err());
        assert!(tolerance("-0.01 mm").is_err());
        assert!(tolerance("nan mm").unwrap_err().contains("not finite"));
        assert!(tolerance("0.01").unwrap_err().contains("no unit"));
    }

    #[test]
    fn sizes_are_two_numbers() {
        assert_eq!(bed("250x210mm"), Ok([250.0, 210.0]));
        assert_eq!(bed("10in x 20 cm"), Ok([254.0, 200.0]));
        assert_eq!(bed("Prusa-MK4"), Ok([250.0, 210.0]));
        assert!(bed("prusa-mk3").unwrap_err().contains("did you mean `prusa-mk4`"));
        assert!(bed("250x210").is_err());
        assert!(bed("1x1mm").is_err());
        assert_eq!(image_size("800x600"), Ok([800, 600]));
        for wrong in ["800", "0x600", "800x", "-1x5", "1e3x5"] {
            assert!(image_size(wrong).is_err(), "{wrong}");
        }
    }
}
