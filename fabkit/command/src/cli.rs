//! What the command line may say. Values that have a unit or a limit are checked here, as they are
//! read; what needs the sensor to be checked is checked by the command.

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

use std::path::PathBuf;
use std::sync::LazyLock;

use clap::builder::PossibleValue;
use clap::{Args, Parser, Subcommand, ValueEnum};
use fabkit_application::exporting::Format;
use fabkit_application::geometry::Length;
use fabkit_application::memory;
use fabkit_application::packaging::{LICENSES, License};
use fabkit_application::pictures::Viewer;

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

/// Shortest and longest edge of tetrahedra, mm.
const EDGE_LIMITS_MM: [f64; 2] = [0.05, 10.0];
/// Smallest and largest chord tolerance, mm. Below, files outgrow any slicer; above, a 3 mm bolt
/// hole is a triangle.
const TOLERANCE_LIMITS_MM: [f64; 2] = [0.0005, 1.0];
const BED_LIMITS_MM: [f64; 2] = [20.0, 5000.0];
const KERF_LIMITS_MM: [f64; 2] = [0.0, 2.0];
const MAX_THREADS: i64 = 256;

const AFTER_HELP: &str = "\
SENSOR is the name of a built-in sensor or a path to a YAML file; SENSOR/FIXTURE is calibration \
hardware made for it.

FABKIT_MATERIALS names a YAML file with materials and processes of your own; fabkit.yaml in the \
working folder holds your defaults of `export`.

Exit codes: 0 done, 1 a check failed, 2 bad input, 3 a limit was hit, 4 files could not be read or \
written, 70 a bug in fabkit, 130 interrupted.";

/// One description of a vision-based tactile sensor to printable parts, molds and ground truth.
#[derive(Debug, Parser)]
#[command(name = "fabkit", version, after_help = AFTER_HELP, max_term_width = 100)]
pub struct Cli {
    /// Options of every command.
    #[command(flatten)]
    pub global: Global,
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// Options of every command.
#[derive(Debug, Args)]
pub struct Global {
    /// Write one JSON document to standard output instead of text, also for errors
    #[arg(long, global = true)]
    pub json: bool,
    /// Write nothing but errors
    #[arg(short, long, global = true)]
    pub quiet: bool,
    /// Work on this many threads instead of one per processor; the output is the same
    #[arg(long, global = true, value_name = "N",
          value_parser = clap::value_parser!(u16).range(1..=MAX_THREADS))]
    pub threads: Option<u16>,
    /// Refuse what takes more memory than this, before it begins
    #[arg(long, global = true, value_name = "SIZE", value_parser = memory::parse,
          default_value = "2GB")]
    pub memory: u64,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// List the built-in sensors with their parts, layers and components
    List,
    /// Write a commented file of a sensor of your own, to start from
    #[command(after_help = new::after_help())]
    New(New),
    /// Show a sensor's parameters with their sources, its parts and derived figures
    #[command(after_help = examples::SHOW)]
    Show(Show),
    /// Check that a sensor can be built: overlaps, molds, trapped air, demolding
    #[command(after_help = examples::CHECK)]
    Check(Design),
    /// Rebuild a sensor in kernels that fabkit did not write, and compare; or read a folder again that
    /// fabkit wrote, and name what is damaged
    #[command(after_help = VERIFY)]
    Verify(Verify),
    /// Write a sensor's parts as files for printers, or one part of it
    #[command(after_help = examples::EXPORT)]
    Export(Export),
    /// Write the pages to build a sensor or fixture from: what to buy, make and mix, and each step
    #[command(after_help = examples::GUIDE)]
    Guide(Guide),
    /// Say what changes from one design to another: what can be used again, what to make, cast and buy
    #[command(after_help = examples::DIFF)]
    Diff(Diff),
    /// Turn a measured coupon into a printer's profile, or into the modulus of a batch of gel
    #[command(after_help = examples::PROFILE)]
    Profile(Profile),
    /// Draw a sensor or one part of it as PNG, from the exact geometry
    #[command(after_help = examples::RENDER)]
    Render(Render),
    /// Compute exactly what the camera sees of the surface, pressed or not
    #[command(after_help = examples::DEPTH)]
    Depth(Depth),
    /// Take the picture that the sensor's camera would take, simulated
    #[command(after_help = examples::CAPTURE)]
    Capture(Capture),
    /// Fit the constants of a real unit's light to its captures of pins, or of a ball on a pad, for `capture`
    #[command(after_help = examples::FIT_LIGHT)]
    FitLight(FitLight),
    /// Say how deep pictures are pressed, from how dark layers or how bright slopes have become, or by a network, and where
    /// their marks have moved
    #[command(after_help = examples::RECONSTRUCT)]
    Reconstruct(Reconstruct),
    /// Run the paper's experiments in simulation, and print its table beside that
    #[command(after_help = examples::BENCH)]
    Bench(Bench),
    /// Render what simulators measure on a real unit: its picture at rest, and what slopes or depths look like
    #[command(after_help = examples::OPTICS_PACK)]
    OpticsPack(OpticsPack),
    /// Compute how soft layers give way to a press: force curve, contact, displacements
    #[command(after_help = examples::PRESS)]
    Press(PressArgs),
    /// Compute training targets for all combinations of two half presses, or a probe set
    #[command(after_help = examples::DATASET)]
    Dataset(Dataset),
    /// Find pins and boards in pictures; solve for the camera and its pose, and say how sure it is
    Calibrate {
        /// What to calibrate.
        #[command(subcommand)]
        what: Calibrate,
    },
    /// Build many variants of a sensor, and compute what each of them is worth
    #[command(after_help = examples::SWEEP)]
    Sweep(Sweep),
    /// Print the JSON Schema of sensor files, for editors
    #[command(after_help = examples::SCHEMA)]
    Schema {
        /// Of plans for `sweep` instead
        #[arg(long)]
        sweep: bool,
        /// Of what a command prints with `--json` instead: `show`, `check`, `error`, ...
        #[arg(long, value_name = "NAME", conflicts_with = "sweep")]
        output: Option<String>,
    },
    /// Print the completions for a shell
    Completions {
        /// Which shell
        shell: clap_complete::Shell,
    },
    /// Print the manual page, or write all pages into a folder
    Man {
        /// Folder for `fabkit.1` and one page per command
        #[arg(short, long, value_name = "DIR")]
        output: Option<PathBuf>,
    },
}

/// Which design.
#[derive(Debug, Args)]
pub struct Design {
    /// Name of a built-in sensor or path to a YAML file, or SENSOR/FIXTURE
    #[arg(add = completing::designs())]
    pub sensor: String,
    /// Change a parameter, for example `surface.radius=14mm`
    #[arg(long = "set", value_name = "PATH=VALUE", add = completing::settings())]
    pub set: Vec<String>,
    /// Keep what you set, and change what fabkit has chosen, as little as possible, until all fits
    #[arg(long)]
    pub fix: bool,
    /// A built-in variant of the sensor, for example `published-2025`: short for SENSOR-NAME
    #[arg(long, value_name = "NAME")]
    pub preset: Option<String>,
}

const VERIFY: &str = "The kernels are Python packages. Which Python runs them is decided so: \
FABKIT_PYTHON, which must be an absolute path; else `.venv` of fabkit's checkout, made by `cargo \
xtask verify-env`, if this program lies in the checkout's `target` folder. Nothing of the current \
folder is run: Python starts isolated, without PYTHON* variables, in an empty folder.

A folder with manifest.json, dataset.json or sweep.json is read again instead: every listed file is \
compared with its size and hash, every chunk with its checksum, the list with its own. Files that are \
damaged, missing, or not listed are named (exit code 1). Folders of fixtures directly below an export \
are read too. A sensor's name keeps its meaning where a folder has the same one; `./NAME` and `NAME/` \
mean the folder.";

/// `fabkit show`.
#[derive(Debug, Args)]
pub struct Show {
    /// Which design.
    #[command(flatten)]
    pub design: Design,
    /// Show how it is built instead: every step, and what to mix for it
    #[arg(long)]
    pub chain: bool,
    /// Show how far each number can go with all others held instead; with --fix, also if what fabkit
    /// has chosen may follow
    #[arg(long, conflicts_with = "chain")]
    pub limits: bool,
}

/// `fabkit export`.
#[derive(Debug, Args)]
pub struct Export {
    /// Name of a built-in sensor or path to a YAML file, or SENSOR/FIXTURE; `/PART` after it means
    /// that part alone
    #[arg(add = completing::parts())]
    pub sensor: String,
    /// Change a parameter, for example `surface.radius=14mm`
    #[arg(long = "set", value_name = "PATH=VALUE", add = completing::settings())]
    pub set: Vec<String>,
    /// Keep what you set, and change what fabkit has chosen, as little as possible, until all fits
    #[arg(long)]
    pub fix: bool,
    /// Its fixtures too, each into a folder of its own
    #[arg(long, conflicts_with = "parts")]
    pub fixtures: bool,
    /// All that a lab publishes: parts in every format, circuit boards, fixtures, guides, the sensor's file
    /// and camera, licence and citation
    #[arg(long, conflicts_with_all = ["parts", "format"])]
    pub all: bool,
    /// The guide too, into a folder of its own
    #[arg(long, conflicts_with = "parts")]
    pub guide: bool,
    /// Licence of a package by its SPDX identifier, for example CC0-1.0
    #[arg(long, requires = "all", value_parser = license, default_value = "CC-BY-4.0", value_name = "ID")]
    pub license: License,
    /// Who made the design, for the package's citation; may be repeated
    #[arg(long = "author", requires = "all", value_name = "NAME")]
    pub authors: Vec<String>,
    /// Write one archive instead of a folder; the same bytes for the same files
    #[arg(long, conflicts_with_all = ["output", "clean"], value_name = "FILE.zip")]
    pub zip: Option<PathBuf>,
    /// A built-in variant of the sensor, for example `published-2025`: short for SENSOR-NAME
    #[arg(long, value_name = "NAME")]
    pub preset: Option<String>,
    /// Where to write [default: out/SENSOR or out/SENSOR/FIXTURE; in place of `out` what fabkit.yaml
    /// says]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Only this part, layer or component; may be repeated
    #[arg(long = "part", value_name = "NAME")]
    pub parts: Vec<String>,
    /// Which files
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        default_value = "stl,3mf,dxf",
        default_value_if("robot", clap::builder::ArgPredicate::IsPresent, None),
        value_name = "LIST"
    )]
    pub format: Vec<FormatArg>,
    /// For robots and simulators: links with exact masses, what is touched and feels, the camera; in place of
    /// --format's usual files
    #[arg(long, value_enum, value_delimiter = ',', conflicts_with_all = ["parts", "all"], value_name = "LIST")]
    pub robot: Vec<RobotArg>,
    /// Largest distance between triangles and the exact surface, 0.0005 mm to 1 mm [default: 0.01mm]
    #[arg(long, value_parser = tolerance, value_name = "LENGTH")]
    pub tolerance: Option<f64>,
    /// Length of the edges of tetrahedra, 0.05 mm to 10 mm; shorter where a layer is thinner [default: 0.5 mm]
    #[arg(long, value_parser = edge, value_name = "LENGTH")]
    pub edge: Option<f64>,
    /// Printer bed on which plates are laid out: width x depth, or a printer, such as `prusa-mk4`
    /// [default: 250x210mm]
    #[arg(long, value_parser = bed, value_name = "WxD")]
    pub bed: Option<[f64; 2]>,
    /// Stock sheets on which laser-cut parts are laid out, width x depth [default: 600x300mm]
    #[arg(long, value_parser = bed, value_name = "WxD")]
    pub stock: Option<[f64; 2]>,
    /// Width of your laser's cut instead of the usual one for the material, 0 mm to 2 mm
    #[arg(long, value_parser = kerf, value_name = "LENGTH")]
    pub kerf: Option<f64>,
    /// Make up for what your printer does to sizes, in parts of the profile's process and material:
    /// a file from `fabkit profile`
    #[arg(long, value_name = "FILE.yaml")]
    pub process: Option<PathBuf>,
    /// Apply the profile to parts of other materials too, where the process is the same
    #[arg(long)]
    pub process_for_any_material: bool,
    /// Write the geometry as designed, without making up for the laser's cut, the printer and
    /// shrinkage
    #[arg(long, conflicts_with_all = ["kerf", "process"])]
    pub nominal: bool,
    /// Remove what the folder's manifest lists and this export does not write, if nobody has changed
    /// it since
    #[arg(long)]
    pub clean: bool,
    /// Replace also files that were changed since fabkit wrote them, or that it did not write; and do
    /// not look whether the design passes `check`
    #[arg(long)]
    pub force: bool,
}

/// `fabkit diff`.
#[derive(Debug, Args)]
pub struct Diff {
    /// What there is: a sensor's name or file, or SENSOR/FIXTURE
    #[arg(value_name = "FROM", add = completing::designs())]
    pub from: String,
    /// What is wanted
    #[arg(value_name = "TO", add = completing::designs())]
    pub to: String,
    /// Change a parameter of the first
    #[arg(long, value_name = "PATH=VALUE", add = completing::settings())]
    pub set_from: Vec<String>,
    /// Change a parameter of the second
    #[arg(long, value_name = "PATH=VALUE", add = completing::settings())]
    pub set_to: Vec<String>,
    /// Write a page with pictures, too
    #[arg(short, long, value_name = "FILE.html")]
    pub output: Option<PathBuf>,
}

/// `fabkit profile`.
#[derive(Debug, Args)]
pub struct Profile {
    /// The coupon's file with what you measured; `export SENSOR/coupon` and `export
    /// SENSOR/gel-coupon` write empty ones
    #[arg(value_name = "COUPON.yaml")]
    pub coupon: PathBuf,
    /// The file to write: a profile, whose name becomes the printer's, or materials
    #[arg(short, long, value_name = "FILE.yaml")]
    pub output: PathBuf,
    /// Replace the file also if it was changed since fabkit wrote it, or if fabkit did not write it
    #[arg(long)]
    pub force: bool,
}

/// `fabkit verify`.
#[derive(Debug, Args)]
pub struct Verify {
    /// Name of a built-in sensor or path to a YAML file; `/PART` after it means that part alone. Or a
    /// folder that `export`, `dataset` or `sweep` wrote
    #[arg(value_name = "SENSOR|DIR", add = completing::parts())]
    pub sensor: String,
    /// Change a parameter, for example `surface.radius=14mm`
    #[arg(long = "set", value_name = "PATH=VALUE", add = completing::settings())]
    pub set: Vec<String>,
    /// Keep what you set, and change what fabkit has chosen, as little as possible, until all fits
    #[arg(long)]
    pub fix: bool,
    /// Only this part, layer or component; may be repeated
    #[arg(long = "part", value_name = "NAME")]
    pub parts: Vec<String>,
    /// Only this kernel; may be repeated
    #[arg(long = "kernel", value_enum, value_name = "KERNEL")]
    pub kernels: Vec<KernelArg>,
    /// Most that one kernel may take for one part, seconds [default: 600]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=86_400), value_name = "SECONDS")]
    pub limit: Option<u32>,
    /// Write a report with pictures of every disagreement
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// Keep the files that are compared in this folder, as `export` would write them there
    #[arg(long, value_name = "DIR")]
    pub keep: Option<PathBuf>,
}

/// A kernel that fabkit did not write.
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
    /// The word used on the command line and in documents.
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
    /// Name of a built-in sensor or path to a YAML file, or SENSOR/FIXTURE; `/PART` after it means
    /// that part alone
    #[arg(add = completing::parts())]
    pub sensor: String,
    /// Change a parameter, for example `surface.radius=14mm`
    #[arg(long = "set", value_name = "PATH=VALUE", add = completing::settings())]
    pub set: Vec<String>,
    /// Keep what you set, and change what fabkit has chosen, as little as possible, until all fits
    #[arg(long)]
    pub fix: bool,
    /// A built-in variant of the sensor, for example `published-2025`: short for SENSOR-NAME
    #[arg(long, value_name = "NAME")]
    pub preset: Option<String>,
    /// The PNG file to write
    #[arg(short, long, value_name = "FILE.png")]
    pub output: PathBuf,
    /// Width and height, px
    #[arg(long, value_parser = picture_size, default_value = "1600x1200", value_name = "WxH")]
    pub size: [u32; 2],
    /// Pull the parts of the assembly apart
    #[arg(long)]
    pub exploded: bool,
    /// From where: front, back, left, right, top, bottom, or azimuth from +x and elevation in degrees
    #[arg(long, value_name = "SIDE|AZ,EL", allow_hyphen_values = true)]
    pub view: Option<Viewer>,
    /// Take the half nearer to the viewer away, upright through the axis; the front half without --view
    #[arg(long)]
    pub section: bool,
    /// Which assembly to draw, for example one of the molds [default: sensor]
    #[arg(long, value_name = "NAME")]
    pub assembly: Option<String>,
    /// Draw the camera's rays through the sensor, cut through the camera's pupil: bent at the drawn faces,
    /// coloured by what they end at; from the front without --view
    #[arg(long, conflicts_with_all = ["exploded", "assembly"])]
    pub rays: bool,
    /// Draw what the camera sees instead: its own picture, in its own size, through all that is clear.
    /// `--camera=FILE` takes a camera file (fabkit, OpenCV, ROS or Kalibr) instead of the nominal lens
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true,
          conflicts_with_all = ["exploded", "assembly", "section", "view", "size", "rays"])]
    pub camera: Option<Option<PathBuf>>,
    /// Pose file with `camera_from_sensor`, for --rays and --camera [default: where the design puts the
    /// camera]
    #[arg(long, value_name = "FILE")]
    pub pose: Option<PathBuf>,
}

/// A kind of file.
#[derive(Clone, Copy, Debug)]
pub enum FormatArg {
    /// What fabkit writes itself.
    Own(Format),
    /// What the verifier's OpenCascade writes.
    Step,
}

/// What `--format` knows, in the order of its help.
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
    /// The format that fabkit writes itself; nothing for STEP.
    pub fn own(self) -> Option<Format> {
        match self {
            Self::Own(format) => Some(format),
            Self::Step => None,
        }
    }
}

pub(crate) fn license(text: &str) -> Result<License, String> {
    License::of(text).ok_or_else(|| {
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

/// A printer, `250x210mm`, or with a unit on both.
pub(crate) fn bed(text: &str) -> Result<[f64; 2], String> {
    if let Some(size_mm) = beds::of(text) {
        return Ok(size_mm);
    }
    if !text.starts_with(|c: char| c.is_ascii_digit()) {
        return Err(beds::unknown(text));
    }
    let (width, depth) = split_size(text)?;
    let unit = depth.trim_start_matches(|c: char| !c.is_alphabetic());
    let bare = width.trim().chars().all(|c| c.is_ascii_digit() || c == '.');
    let width = if bare { format!("{width}{unit}") } else { width.to_owned() };
    Ok([length_within(&width, BED_LIMITS_MM)?, length_within(depth, BED_LIMITS_MM)?])
}

fn picture_size(text: &str) -> Result<[u32; 2], String> {
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
        assert_eq!(picture_size("800x600"), Ok([800, 600]));
        for wrong in ["800", "0x600", "800x", "-1x5", "1e3x5"] {
            assert!(picture_size(wrong).is_err(), "{wrong}");
        }
    }
}
