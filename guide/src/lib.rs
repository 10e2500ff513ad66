//! The build package's pages: what to buy, what to make, what to mix, and each step, from the same
//! description as the parts.
//!
//! A [`Guide`] holds facts alone; its JSON, its tables ([`Guide::bom_csv`], [`Guide::parts_csv`]) and its page
//! ([`Guide::to_html`]) say the same. Nothing here opens a file or draws a body: pictures are handed in.
//!
//! ```
//! use fabkit_guide::{Guide, Request};
//! # let sensor = fabkit_checks::example::puck();
//! let guide = Guide::of(&sensor, &Request { design_hash: "00", units: 2, density: &|_| None })?;
//! // Two pucks are poured one after the other in the same mold.
//! assert_eq!(guide.mixes[0].batches, 2);
//! assert!(guide.parts_csv().starts_with("name,quantity,"));
//! let page = guide.to_html(&Default::default());
//! assert!(page.contains(&guide.mixes[0].components[0].name));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![forbid(unsafe_code)]

mod csv;
mod html;
mod lists;
mod timeline;
mod wiring;

use fabkit_checks::{Batch, batches};
use fabkit_geometry::{Action, Placement, Sensor, Step};
use serde::Serialize;

pub use html::{BoardArt, Pictures};
pub use lists::{Bought, Liquid, Made, NoSuchPart, Tool};
pub use timeline::{Stretch, Timeline};
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
    /// Parts to print, cut and etch.
    pub made: Vec<Made>,
    /// Pieces to buy.
    pub bought: Vec<Bought>,
    /// What is poured and sprayed, summed over all steps.
    pub liquids: Vec<Liquid>,
    /// What is mixed, step by step.
    pub mixes: Vec<Mixed>,
    /// What to do.
    pub steps: Vec<GuideStep>,
    /// What is soldered and wired.
    pub wiring: Vec<Wiring>,
    /// When, for one unit.
    pub timeline: Timeline,
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
    /// Hours until it has cured.
    pub cure_h: f64,
    /// At how many degrees Celsius.
    pub cure_celsius: f64,
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
}

impl Guide {
    /// What a sensor or fixture needs.
    ///
    /// # Errors
    /// A part that cannot be made.
    pub fn of(sensor: &Sensor, request: &Request<'_>) -> Result<Self, NoSuchPart> {
        let mixes = mixes(sensor, &batches(sensor), request.units);
        Ok(Self {
            format: "fabkit-guide",
            version: 1,
            name: sensor.name.clone(),
            title: sensor.title.clone(),
            reference: sensor.reference.clone(),
            design_hash: request.design_hash.to_owned(),
            units: request.units,
            made: lists::made(sensor, request)?,
            bought: lists::bought(sensor, request.units),
            liquids: lists::liquids(&mixes),
            mixes,
            steps: sensor.chain.iter().enumerate().map(|(i, step)| told(sensor, i, step)).collect(),
            wiring: wiring::wirings(sensor),
            timeline: Timeline::of(&sensor.chain),
        })
    }

    /// All of it as JSON (`fabkit-guide` version 1).
    pub fn to_json(&self) -> serde_json::Value {
        serde_json::to_value(self).expect("names and numbers alone")
    }
}

fn mixes(sensor: &Sensor, batches: &[Batch], units: u32) -> Vec<Mixed> {
    let of = |batch: &Batch| {
        let step = sensor.chain.iter().position(|step| step.name == batch.step)? + 1;
        let layer = sensor.body(&batch.layer)?;
        let components = batch.components_g.iter();
        Some(Mixed {
            step,
            layer: batch.layer.clone(),
            volume_mm3: batch.volume.value_mm3,
            waste: batch.waste,
            batches: if lists::stays(layer) { units } else { 1 },
            components: components
                .map(|(name, mass_g)| Component { name: name.clone(), mass_g: *mass_g })
                .collect(),
            degas: batch.degas,
            cure_h: batch.cure.hours,
            cure_celsius: batch.cure.celsius,
        })
    };
    batches.iter().filter_map(of).collect()
}

fn told(sensor: &Sensor, index: usize, step: &Step) -> GuideStep {
    let number_of =
        |name: &String| sensor.chain.iter().position(|s| s.name == *name).map(|i| i + 1);
    GuideStep {
        number: index + 1,
        name: step.name.clone(),
        action: word(&step.action),
        instruction: step.instruction.clone(),
        assembly: step.assembly.as_ref().map(|assembly| assembly.0.clone()),
        needs: step.bodies.iter().map(|name| need(sensor, step, name)).collect(),
        removed: match &step.action {
            Action::Demold(pulls) => pulls.iter().map(|pull| pull.body.clone()).collect(),
            _ => Vec::new(),
        },
        adjusted: step.adjustments.iter().map(|one| one.body.clone()).collect(),
        during: step.during.as_ref().and_then(number_of),
        source: step.source.clone(),
    }
}

/// As many as stand where the step puts them; else as many as a lab needs.
fn need(sensor: &Sensor, step: &Step, name: &str) -> Need {
    let count = sensor.body(name).map_or(1, |body| {
        let is_there = |placed: &&Placement| Some(&placed.assembly) == step.assembly.as_ref();
        match body.placements.iter().filter(is_there).count() {
            0 => body.quantity as usize,
            count => count,
        }
    });
    Need { name: name.to_owned(), count }
}

fn word(action: &Action) -> &'static str {
    match action {
        Action::Make => "make",
        Action::Prepare => "prepare",
        Action::Assemble => "assemble",
        Action::Bond(_) => "bond",
        Action::Spray(_) => "spray",
        Action::Pour(_) => "pour",
        Action::Demold(_) => "demold",
    }
}
