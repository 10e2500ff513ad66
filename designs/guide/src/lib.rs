//! The build package's pages: what to buy, what to make, what to mix, and each step, from the same
//! description as the parts.
//!
//! A [`Guide`] holds facts alone; its JSON, its tables ([`Guide::bom_csv`], [`Guide::parts_csv`]) and its page
//! ([`Guide::to_html`]) say the same. Nothing here opens a file or draws a body: pictures are handed in.
//!
//! ```
//! use fabkit_guide::{Guide, NoShop, Request};
//! # let sensor = fabkit_checks::example::puck();
//! let stages = fabkit_checks::stages(&sensor)?;
//! let shop = &NoShop;
//! let request =
//!     Request { design_hash: "00", units: 2, density: &|_| None, shop, stages: &stages, calibration: None };
//! let guide = Guide::of(&sensor, &request)?;
//! // What does not stay in the sensor, as this puck, is poured once for all units.
//! assert_eq!(guide.mixes[0].batches, 1);
//! assert!(guide.parts_csv().starts_with("name,quantity,"));
//! let page = guide.to_html(&Default::default());
//! assert!(page.contains(&guide.mixes[0].components[0].name));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![forbid(unsafe_code)]

mod calibration;
mod csv;
mod diff;
mod extent;
mod html;
mod lists;
mod outer;
mod printing;
mod sheets;
mod shop;
mod supplies;
mod timeline;
mod told;
mod warnings;
mod wiring;

use fabkit_checks::{Batch, Stage, batches};
use fabkit_geometry::{Action, Sensor};
use serde::Serialize;

pub use calibration::{Calibration, Capture, FixtureNote, Typed};
pub use diff::{BodyChange, Change, DesignName, Difference, ParameterChange, Side, StepChange};
pub use html::{BoardArt, Model, Pairs, Pictures, Pressed, Rays, SeenRay, StepPictures};
pub use lists::{Bought, Liquid, Made, NoSuchPart, Tool};
pub use outer::Outer;
pub use printing::{Printing, Sliced};
pub use sheets::{SheetPiece, SheetPlan};
pub use shop::{Figure, NoShop, Purchase, Shop, Use};
pub use supplies::{Costs, Stock, Supply};
pub use timeline::{Meanwhile, Series, Stretch, Timeline};
pub use warnings::Warning;
pub use wiring::{Wire, WiredNet, WiredPart, WiredPin, WiredResistor, Wiring};

/// What a guide is asked for.
#[derive(Clone, Copy)]
pub struct Request<'a> {
    /// The design's hash, which tells it from others of its name.
    pub design_hash: &'a str,
    /// How many sensors are to be built; molds and tools are made once.
    pub units: u32,
    /// Density of a material that parts are made of, g/cm3, as far as anybody knows it.
    pub density: &'a dyn Fn(&str) -> Option<f64>,
    /// What stands where in each step: of the same sensor, as [`fabkit_checks::stages`] tells it.
    pub stages: &'a [Stage<'a>],
    /// What may be bought.
    pub shop: &'a dyn Shop,
    /// How it is calibrated, where it is.
    pub calibration: Option<&'a Calibration>,
}

/// Everything that a lab needs to know to build a design.
#[derive(Clone, Debug, Serialize)]
pub struct Guide {
    /// `fabkit-guide`.
    pub format: &'static str,
    /// 1.
    pub version: u32,
    /// The design's name.
    pub name: String,
    /// Its title.
    pub title: String,
    /// Who published it.
    pub reference: String,
    /// Tells it from other designs of its name.
    pub design_hash: String,
    /// How many are built.
    pub units: u32,
    /// How large and heavy one is; `null` where nothing stands together.
    pub outer: Option<Outer>,
    /// Parts to print, cut and etch.
    pub made: Vec<Made>,
    /// What is cut from stock sheets, for all units.
    pub sheets: Vec<SheetPlan>,
    /// Pieces to buy.
    pub bought: Vec<Bought>,
    /// What is poured and sprayed, summed over all steps.
    pub liquids: Vec<Liquid>,
    /// What parts are made from.
    pub stock: Vec<Stock>,
    /// What the work uses up, and its tools.
    pub supplies: Vec<Supply>,
    /// What everything that is bought costs.
    pub costs: Costs,
    /// What is mixed, step by step.
    pub mixes: Vec<Mixed>,
    /// What to mind.
    pub warnings: Vec<Warning>,
    /// What to do.
    pub steps: Vec<GuideStep>,
    /// What is soldered and wired.
    pub wiring: Vec<Wiring>,
    /// When, for one unit.
    pub timeline: Timeline,
    /// How it is calibrated; `null` of what is not.
    pub calibration: Option<Calibration>,
}

/// One mix of a step.
#[derive(Clone, Debug, Serialize)]
pub struct Mixed {
    /// The step's number, from 1.
    pub step: usize,
    /// The layer that it becomes.
    pub layer: String,
    /// The layer's volume, mm3.
    pub volume_mm3: f64,
    /// Surplus in the masses, as a fraction of the layer's.
    pub waste: f64,
    /// How often it is mixed: once for each unit, or once for what is cast as a tool.
    pub batches: u32,
    /// Masses of one batch, waste included.
    pub components: Vec<Component>,
    /// Whether air is drawn out in a vacuum.
    pub degas: bool,
    /// How long air is given to leave it, h: in the vacuum, else at rest before it is poured; 0 of what is sprayed.
    pub air_h: f64,
    /// Where that is from: `chosen`.
    pub air_source: &'static str,
    /// Hours until it has cured.
    pub cure_h: f64,
    /// At how many degrees Celsius.
    pub cure_celsius: f64,
    /// How long it can be worked with after mixing, h; `null` where its maker does not say.
    pub pot_life_h: Option<f64>,
    /// How long hands need with it, h: until the step is done in which it cures.
    pub in_hand_h: f64,
}

/// Part of a mix.
#[derive(Clone, Debug, Serialize)]
pub struct Component {
    /// As it is sold.
    pub name: String,
    /// g.
    pub mass_g: f64,
}

/// What a step needs.
#[derive(Clone, Debug, Serialize)]
pub struct Need {
    /// Its name in the design.
    pub name: String,
    /// How many for one unit.
    pub count: usize,
}

/// One step.
#[derive(Clone, Debug, Serialize)]
pub struct GuideStep {
    /// From 1.
    pub number: usize,
    /// Its name in the design.
    pub name: String,
    /// What is done: `make`, `prepare`, `assemble`, `bond`, `spray`, `pour` or `demold`.
    pub action: &'static str,
    /// What to do, as a sentence.
    pub instruction: String,
    /// Where bodies stand together.
    pub assembly: Option<String>,
    /// What it needs, in the order of the design.
    pub needs: Vec<Need>,
    /// What comes off in it, by name.
    pub removed: Vec<String>,
    /// Who sets something right in it, by name.
    pub adjusted: Vec<String>,
    /// The number of the step whose cure is waited for meanwhile.
    pub during: Option<usize>,
    /// Section of the paper, or why it is so.
    pub source: String,
    /// What hands hold in it.
    pub tools: Vec<String>,
    /// What to check when it is done.
    pub checks: Vec<String>,
    /// Which way things come and go.
    pub ways: Vec<Way>,
}

/// Bodies that are brought to their places or taken away together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Way {
    /// Which, by name.
    pub bodies: Vec<String>,
    /// Whether they come; else they go.
    pub is_coming: bool,
    /// Which way, a unit vector of the assembly's frame.
    pub along: [f64; 3],
}

impl Guide {
    /// What a sensor or fixture needs.
    ///
    /// # Errors
    /// A part that cannot be made.
    pub fn of(sensor: &Sensor, request: &Request<'_>) -> Result<Self, NoSuchPart> {
        let mixes = mixes(sensor, &batches(sensor), request.units);
        let timeline = Timeline::of(sensor, request.units);
        let steps = told::steps(sensor, request.stages, &mixes);
        let made = lists::made(sensor, request)?;
        let bought = lists::bought(sensor, request.units);
        let liquids = lists::liquids(&mixes, request.shop);
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
            outer: outer::outer(sensor, request)?,
            made,
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
        })
    }

    /// All of it as JSON (`fabkit-guide` version 1).
    pub fn to_json(&self) -> serde_json::Value {
        serde_json::to_value(self).expect("names and numbers alone")
    }
}

/// In a vacuum, h: until foam has risen and fallen, and as long again. Chosen.
const VACUUM_H: f64 = 5.0 / 60.0;

/// At rest, h: until bubbles of a millimetre have risen through a cup. Chosen.
const REST_H: f64 = 10.0 / 60.0;

/// Of a pot life, what may go by before it is poured; chosen.
const SHARE_OF_POT_LIFE: f64 = 1.0 / 3.0;

fn air_h(degas: bool, action: &Action, pot_life_h: Option<f64>) -> f64 {
    let wanted_h = match action {
        _ if degas => VACUUM_H,
        Action::Spray(_) => 0.0,
        _ => REST_H,
    };
    pot_life_h.map_or(wanted_h, |life_h| wanted_h.min(SHARE_OF_POT_LIFE * life_h))
}

fn mixes(sensor: &Sensor, batches: &[Batch], units: u32) -> Vec<Mixed> {
    let of = |batch: &Batch| {
        let index = sensor.chain.iter().position(|step| step.name == batch.step)?;
        let pot_life_h = match &sensor.chain[index].action {
            Action::Pour(pour) => pour.mix.pot_life_h,
            Action::Spray(spray) => spray.mix.pot_life_h,
            _ => None,
        };
        let layer = sensor.body(&batch.layer)?;
        let components = batch.components_g.iter();
        Some(Mixed {
            step: index + 1,
            layer: batch.layer.clone(),
            volume_mm3: batch.volume.value_mm3,
            waste: batch.waste,
            batches: if lists::stays(layer) { units } else { 1 },
            components: components
                .map(|(name, mass_g)| Component { name: name.clone(), mass_g: *mass_g })
                .collect(),
            degas: batch.degas,
            air_h: air_h(batch.degas, &sensor.chain[index].action, pot_life_h),
            air_source: "chosen",
            cure_h: batch.cure.hours,
            cure_celsius: batch.cure.celsius,
            pot_life_h,
            in_hand_h: warnings::in_hand_h(&sensor.chain, index),
        })
    };
    batches.iter().filter_map(of).collect()
}
