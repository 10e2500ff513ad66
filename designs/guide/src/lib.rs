//! Build guide: the lists of what to buy, make and mix, and every step, from the same description as the parts.
//!
//! A [`Guide`] holds facts only; its JSON, its tables ([`Guide::bom_csv`], [`Guide::parts_csv`]) and its page
//! ([`Guide::to_html`]) present the same facts. This crate opens no files and renders no bodies: the caller passes the
//! images.
//!
//! ```
//! use fabkit_guide::{Guide, NoShop, Request};
//! # let sensor = fabkit_checks::example::puck();
//! let stages = fabkit_checks::stages(&sensor)?;
//! let shop = &NoShop;
//! let request =
//!     Request { design_hash: "00", units: 2, density: &|_| None, shop, stages: &stages, calibration: None };
//! let guide = Guide::new(&sensor, &request)?;
//! // What does not stay in the sensor, as this puck, is poured once for all units.
//! assert_eq!(guide.mixes[0].batches, 1);
//! assert!(guide.parts_csv().starts_with("name,quantity,"));
//! let page = guide.to_html(&Default::default());
//! assert!(page.contains(&guide.mixes[0].components[0].name));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![forbid(unsafe_code)]

mod bill_of_materials;
mod calibration;
mod csv;
mod diff;
mod error;
mod extent;
mod html;
mod instructions;
mod membership;
mod mixes;
mod overall_size;
mod printing;
mod request;
mod sheets;
mod shop;
mod step;
mod supplies;
mod timeline;
mod warnings;
mod wiring;

use fabkit_checks::{Batch, batches};
use fabkit_geometry::{Action, Sensor};
use serde::Serialize;

pub use bill_of_materials::{BodyUse, BoughtPiece, LiquidComponent, MadePart};
pub use calibration::{Calibration, CalibrationCommand, FixtureNote, PinCapture};
pub use diff::{
    BodyChange, ChangeKind, ComparedDesign, DesignDifference, DesignName, ParameterChange,
    StepChange,
};
pub use error::GuideError;
pub use html::{
    BoardArt, CameraRay, CameraRays, PageImages, PartImagePairs, PressedSurface, StepImages,
    ViewerModel,
};
pub use mixes::{MixComponent, StepMix};
pub use overall_size::OverallSize;
pub use printing::{PrintPlan, SlicerEstimate};
pub use request::Request;
pub use sheets::{SheetPiece, SheetPlan};
pub use shop::{ArticleProperty, NoShop, Purchase, Shop, SupplyKind};
pub use step::{BodyMotion, GuideStep, NeededBody};
pub use supplies::{Costs, Stock, Supply};
pub use timeline::{ParallelSteps, StepInterval, Timeline, UnitSeries};
pub use warnings::Warning;
pub use wiring::{WiredNet, WiredPart, WiredPin, WiredResistor, Wiring, WiringConnection};

/// Everything that a lab needs to know to build a design.
#[derive(Clone, Debug, Serialize)]
pub struct Guide {
    /// Format name, `fabkit-guide`.
    pub format: &'static str,
    /// Format version, 1.
    pub version: u32,
    /// Name of the design.
    pub name: String,
    /// Title of the design.
    pub title: String,
    /// Publication that the design comes from.
    pub reference: String,
    /// Hash that distinguishes it from other designs of the same name.
    pub design_hash: String,
    /// Number of units to build.
    pub units: u32,
    /// Size and mass of one unit; `null` if no bodies are placed together.
    pub outer: Option<OverallSize>,
    /// Parts to print, cut and etch.
    pub made: Vec<MadePart>,
    /// Stock sheets to cut, for all units.
    pub sheets: Vec<SheetPlan>,
    /// Pieces to buy.
    pub bought: Vec<BoughtPiece>,
    /// Components of poured and sprayed mixes, summed over all steps.
    pub liquids: Vec<LiquidComponent>,
    /// Stock that parts are made from.
    pub stock: Vec<Stock>,
    /// Consumables and tools.
    pub supplies: Vec<Supply>,
    /// Cost of everything that is bought.
    pub costs: Costs,
    /// Mixes, step by step.
    pub mixes: Vec<StepMix>,
    /// Warnings.
    pub warnings: Vec<Warning>,
    /// Steps of the build.
    pub steps: Vec<GuideStep>,
    /// Circuits to solder and wire.
    pub wiring: Vec<Wiring>,
    /// Schedule.
    pub timeline: Timeline,
    /// Calibration of the finished sensor; `null` if there is none.
    pub calibration: Option<Calibration>,
    /// Errors that `fabkit check` finds: the design cannot be built as described.
    pub check_errors: Vec<String>,
}

impl Guide {
    /// Creates the guide of a sensor or fixture.
    ///
    /// # Errors
    /// A part that cannot be made.
    pub fn new(sensor: &Sensor, request: &Request<'_>) -> Result<Self, GuideError> {
        let mixes = compute_mixes(sensor, &batches(sensor), request.units);
        let timeline = Timeline::new(sensor, request.units);
        let steps = instructions::steps(sensor, request.stages, &mixes);
        let made = bill_of_materials::made(sensor, request)?;
        let bought = bill_of_materials::bought(sensor, request.units);
        let liquids = bill_of_materials::liquids(&mixes, request.shop);
        let stock = supplies::stock(&made, request.shop);
        let supplies = supplies::supplies(sensor, (&made, &mixes), request.shop);
        let costs = supplies::costs(&bought, &liquids, &stock, &supplies);
        Ok(Self {
            format: "fabkit-guide",
            version: 1,
            name: sensor.name.clone(),
            title: sensor.title.clone(),
            reference: sensor.reference.clone(),
            design_hash: request.design_hash.to_owned(),
            units: request.units,
            outer: overall_size::measure(sensor, request)?,
            made,
            // See `take_sheets`.
            sheets: Vec::new(),
            bought,
            liquids,
            stock,
            supplies,
            costs,
            warnings: warnings::warnings(sensor, &mixes, &timeline),
            mixes,
            steps,
            wiring: wiring::wirings(sensor),
            timeline,
            calibration: request.calibration.cloned(),
            // Known to callers that apply the rules of `check`.
            check_errors: Vec::new(),
        })
    }

    /// Returns the guide as JSON (`fabkit-guide` version 1).
    ///
    /// ```
    /// # use fabkit_guide::{Guide, NoShop, Request};
    /// # let sensor = fabkit_checks::example::puck();
    /// # let stages = fabkit_checks::stages(&sensor)?;
    /// # let (density, shop, calibration) = (&|_: &str| None, &NoShop, None);
    /// # let request = Request { design_hash: "00", units: 1, density, shop, stages: &stages, calibration };
    /// let json = Guide::new(&sensor, &request)?.to_json();
    /// assert_eq!(json["format"], "fabkit-guide");
    /// assert_eq!(json["made"][0]["name"], "dish");
    /// // What is not known is null.
    /// assert!(json["made"][0]["mass_g"].is_null());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn to_json(&self) -> serde_json::Value {
        serde_json::to_value(self).expect("names and numbers alone")
    }
}

/// Degassing time in a vacuum, h: until foam has risen and collapsed, and as long again. Chosen.
const VACUUM_H: f64 = 5.0 / 60.0;

/// Resting time, h: until bubbles of a millimetre have risen through a cup. Chosen.
const REST_H: f64 = 10.0 / 60.0;

/// Largest fraction of the pot life that is spent on removing air; chosen.
const SHARE_OF_POT_LIFE: f64 = 1.0 / 3.0;

/// Returns the time for air to leave a mix, h.
fn air_h(degas: bool, action: &Action, pot_life_h: Option<f64>) -> f64 {
    let wanted_h = match action {
        // A vacuum replaces the time at rest; sprays need neither.
        _ if degas => VACUUM_H,
        Action::Spray(_) => 0.0,
        _ => REST_H,
    };
    pot_life_h.map_or(wanted_h, |life_h| wanted_h.min(SHARE_OF_POT_LIFE * life_h))
}

/// Returns the mixes of all steps.
fn compute_mixes(sensor: &Sensor, batches: &[Batch], units: u32) -> Vec<StepMix> {
    let of = |batch: &Batch| {
        // Batches refer to steps by name, the guide by number.
        let index = sensor.chain.iter().position(|step| step.name == batch.step)?;
        let pot_life_h = match &sensor.chain[index].action {
            Action::Pour(pour) => pour.mix.pot_life_h,
            Action::Spray(spray) => spray.mix.pot_life_h,
            _ => None,
        };
        let layer = sensor.body(&batch.layer)?;
        let components = batch.components_g.iter();
        Some(StepMix {
            step: index + 1,
            layer: batch.layer.clone(),
            volume_mm3: batch.volume.value_mm3,
            waste: batch.waste,
            // A layer that is a tool is cast once for all units.
            batches: if membership::is_in_sensor(layer) { units } else { 1 },
            components: components
                .map(|(name, mass_g)| MixComponent { name: name.clone(), mass_g: *mass_g })
                .collect(),
            degas: batch.degas,
            air_h: air_h(batch.degas, &sensor.chain[index].action, pot_life_h),
            air_source: "chosen",
            cure_h: batch.cure.hours,
            cure_celsius: batch.cure.celsius,
            pot_life_h,
            in_hand_h: warnings::handling_time_h(&sensor.chain, index),
        })
    };
    batches.iter().filter_map(of).collect()
}
