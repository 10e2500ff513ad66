//! Options of `fabkit press`, and of the contact model in `depth` and `dataset`.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};
use fabkit_application::Error;
use fabkit_application::press_simulation::{
    ContactModel, LinearOptions, MAX_STEPS, PressRequest, PressingError, StrainTheory, resources,
};
use fabkit_application::scene::MEMBRANE_LIMITS_MM;

use super::options::options;
use super::{Design, length_within};

const DEPTH_LIMITS_MM: [f64; 2] = [0.001, 50.0];
const SPACING_LIMITS_MM: [f64; 2] = [0.01, 5.0];

/// `fabkit press`.
#[derive(Debug, Args)]
pub struct PressArgs {
    /// The sensor.
    #[command(flatten)]
    pub design: Design,
    /// Indenter and contact: `ball@30deg,120deg` by polar angle and azimuth on a dome, `ball@2mm,-3mm` on a pad
    #[arg(long, value_name = "NAME@PLACE")]
    pub indenter: String,
    /// Indentation along the surface's normal at the contact
    #[arg(long, value_parser = depth, value_name = "LENGTH")]
    pub depth: f64,
    /// Options shared with the Python package.
    #[command(flatten)]
    pub options: PressOptions,
    /// Write the force curve as a table
    #[arg(long, value_name = "FILE.csv")]
    pub csv: Option<PathBuf>,
    /// Write the force curve as a plot
    #[arg(long, value_name = "FILE.svg")]
    pub plot: Option<PathBuf>,
    /// Write the outward displacement of the surface as a colour image with a scale: a whole dome by polar angle around
    /// the tip, the surroundings of the press on a pad
    #[arg(long, value_name = "FILE.png")]
    pub png: Option<PathBuf>,
    /// Write positions, displacements and tractions of the surface for NumPy
    #[arg(short, long, value_name = "FILE.npz")]
    pub output: Option<PathBuf>,
}

options! {
    /// Options of `fabkit press`, and keyword arguments of `fabkit.press` in Python.
    pub struct PressOptions {
        /// Tangential motion of the indenter after pressing: on a dome away from the tip and around it, on a pad along x and y
        #[arg(long, value_parser = shear, default_value = "0mm,0mm", value_name = "LENGTH,LENGTH", allow_hyphen_values = true)]
        pub shear: [f64; 2],
        /// Coulomb friction coefficient for --shear [default: of the touched material]
        #[arg(long, value_parser = friction, value_name = "NUMBER", allow_hyphen_values = true)]
        pub friction: Option<f64>,
        /// Elastic model
        #[arg(long, value_parser = theories(), value_name = "LEVEL", default_value = "linear")]
        pub contact: String,
        /// Number of equal steps of the force curve
        #[arg(long, value_name = "N", default_value = "10",
              value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_STEPS)))]
        pub steps: u32,
        /// Node spacing on the surface [default: about 5,000 nodes on a dome, about 20 across the contact on a pad]
        #[arg(long, value_parser = spacing, value_name = "LENGTH")]
        pub spacing: Option<f64>,
    }
}

impl PressOptions {
    /// Builds the request to press `indenter` to `depth_mm`.
    ///
    /// # Errors
    /// [`PressingError::Contact`]: unknown elastic model.
    pub fn pressing<'a>(
        &self,
        indenter: &'a str,
        depth_mm: f64,
    ) -> Result<PressRequest<'a>, PressingError> {
        let level = [StrainTheory::Linear, StrainTheory::Finite]
            .into_iter()
            .find(|l| l.name() == self.contact);
        let unknown = || PressingError::Contact {
            problem: format!("there is no contact `{}`: linear or finite", self.contact),
        };
        Ok(PressRequest {
            indenter,
            depth_mm,
            level: level.ok_or_else(unknown)?,
            steps: self.steps,
            shear_mm: self.shear,
            friction: self.friction,
            spacing_mm: self.spacing,
            resources: resources(),
        })
    }
}

/// Values of `press --contact`.
fn theories() -> PossibleValuesParser {
    PossibleValuesParser::new([
        PossibleValue::new("linear")
            .help("Small strain, layered, nearly incompressible, with Coulomb friction"),
        PossibleValue::new("finite").help(
            "Large strain, neo-Hookean, without friction, axially symmetric: at the tip of a dome or on a pad; takes seconds",
        ),
    ])
}

options! {
    /// Contact model: options of `fabkit depth` and `dataset`, and keyword arguments of `fabkit.depth.cast` and
    /// `fabkit.dataset.write` in Python.
    pub struct ContactOptions {
        /// Contact model [default: membrane with --membrane, else rigid]
        #[arg(long, value_parser = answers(), value_name = "LEVEL")]
        pub contact: Option<String>,
        /// Distance around a contact over which the gel returns to rest, 0 mm to 10 mm; without it only the contact moves
        #[arg(long, value_parser = membrane, default_value = "0mm", value_name = "LENGTH")]
        pub membrane: f64,
        /// Coulomb friction coefficient for --shear, linear contact only [default: of the touched material]
        #[arg(long, value_parser = friction, value_name = "NUMBER", allow_hyphen_values = true)]
        pub friction: Option<f64>,
        /// Node spacing on the surface, linear contact only [default: as fine as a few seconds allow]
        #[arg(long, value_parser = spacing, value_name = "LENGTH")]
        pub spacing: Option<f64>,
    }
}

/// Values of `--contact` in `depth` and `dataset`.
fn answers() -> PossibleValuesParser {
    PossibleValuesParser::new([
        PossibleValue::new("rigid").help("The surface follows the indenter; nothing else moves"),
        PossibleValue::new("membrane")
            .help("The surface returns to rest over the distance --membrane"),
        PossibleValue::new("linear").help("Elastic layers that yield and bulge, small strain"),
    ])
}

impl ContactOptions {
    /// Combines the options into one contact model.
    ///
    /// # Errors
    /// [`PressingError::Contact`]: unknown contact model, or an option of another model.
    pub fn contact(&self) -> Result<ContactModel, Error> {
        let linear = LinearOptions { spacing_mm: self.spacing, friction: self.friction };
        Ok(ContactModel::from_name(self.contact.as_deref(), self.membrane, linear)?)
    }
}

fn membrane(text: &str) -> Result<f64, String> {
    length_within(text, MEMBRANE_LIMITS_MM)
}

pub(super) fn shear(text: &str) -> Result<[f64; 2], String> {
    let (first, second) = text.split_once(',').ok_or("two lengths, for example `0.5mm,0mm`")?;
    let mm = |text: &str| {
        let within = [-DEPTH_LIMITS_MM[1], DEPTH_LIMITS_MM[1]];
        length_within(text.trim(), within)
    };
    Ok([mm(first)?, mm(second)?])
}

pub(super) fn friction(text: &str) -> Result<f64, String> {
    let friction: f64 = text.parse().map_err(|_| format!("`{text}` is no number"))?;
    if (0.0..=10.0).contains(&friction) {
        Ok(friction)
    } else {
        Err(format!("{friction} is not between 0 and 10"))
    }
}

pub(super) fn depth(text: &str) -> Result<f64, String> {
    length_within(text, DEPTH_LIMITS_MM)
}

pub(super) fn spacing(text: &str) -> Result<f64, String> {
    length_within(text, SPACING_LIMITS_MM)
}
