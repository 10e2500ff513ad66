//! How a sensor comes into being: an ordered chain of steps, as data.
//!
//! A chain is complete enough to be checked without pouring anything: each pour names the walls of
//! its cavity and its openings, each demolding the direction in which a tool comes off.

use nalgebra::{Point3, Vector3};

use crate::{Assembly, Motion};

/// One step, in the order of the chain.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// `[a-z0-9-]{1,64}`, unique in the chain.
    pub name: String,
    /// What to do, as a sentence to the person who does it.
    pub instruction: String,
    /// Where bodies stand together while it is done.
    pub assembly: Option<Assembly>,
    /// Parts, layers and components that the step needs or joins, by name.
    pub bodies: Vec<String>,
    /// Ways that bodies take to their places, where they are not straight or matter.
    pub motions: Vec<Motion>,
    /// What keeps small things where the step puts them.
    pub fixings: Vec<Fixing>,
    /// What hands set right in it: lenses that are focused.
    pub adjustments: Vec<Adjustment>,
    /// The earlier step whose cure is waited for meanwhile, by name; with none, all that was cast or
    /// glued before has cured.
    pub during: Option<String>,
    /// What happens.
    pub action: Action,
    /// Section of the paper, or why fabkit chose it.
    pub source: String,
}

impl Step {
    /// More bodies that it needs.
    #[must_use]
    pub fn also(mut self, bodies: impl IntoIterator<Item = String>) -> Self {
        self.bodies.extend(bodies);
        self
    }

    /// A way that some of its bodies take to their places.
    #[must_use]
    pub fn moving(mut self, motion: Motion) -> Self {
        self.motions.push(motion);
        self
    }

    /// One of its bodies is set right in it, among all that stands there by then.
    #[must_use]
    pub fn adjusting(mut self, body: impl Into<String>) -> Self {
        self.adjustments.push(Adjustment { body: body.into(), is_apart: false });
        self
    }

    /// The same, among what the step itself brings: it is put together with the rest, looked at, and
    /// taken away again to be set right.
    #[must_use]
    pub fn adjusting_apart(mut self, body: impl Into<String>) -> Self {
        self.adjustments.push(Adjustment { body: body.into(), is_apart: true });
        self
    }

    /// Done while an earlier step's cure is waited for.
    #[must_use]
    pub fn during(self, step: impl Into<String>) -> Self {
        Self { during: Some(step.into()), ..self }
    }

    /// How what is cast, sprayed or glued in it hardens.
    pub fn cure(&self) -> Option<Cure> {
        match &self.action {
            Action::Bond(cure) => Some(*cure),
            Action::Spray(spray) => Some(spray.cure),
            Action::Pour(pour) => Some(pour.cure),
            Action::Make | Action::Prepare | Action::Assemble | Action::Demold(_) => None,
        }
    }
}

/// A body that is set right by hand or with a tool in a step: its [`Reach`](crate::Reach) on
/// [`Occasion::Adjustment`](crate::Occasion::Adjustment) says what room that takes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Adjustment {
    /// Which, by name.
    pub body: String,
    /// Whether it is done apart from what stood there before the step: only what the step brings
    /// stands around it.
    pub is_apart: bool,
}

/// Small things that a step makes stay where they are, though nothing stands in their way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fixing {
    /// What stays, by name.
    pub bodies: Vec<String>,
    /// On which bodies, by name; each piece on one of them.
    pub onto: Vec<String>,
    /// How it does.
    pub by: FixedBy,
}

/// What keeps something small on what it touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FixedBy {
    /// Solder.
    Solder,
    /// A drop of glue.
    Glue,
    /// Its own adhesive back.
    Tape,
    /// Friction: it is pushed onto or into something.
    Push,
}

/// What a step does.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Print, cut or etch parts.
    Make,
    /// Clean, prime, spray release agent.
    Prepare,
    /// Put bodies together: press, screw, slide.
    Assemble,
    /// Glue bodies together; the adhesive's cure.
    Bond(Cure),
    /// Coat a wall with a layer too thin to need a cavity.
    Spray(Spray),
    /// Fill a cavity with a liquid.
    Pour(Pour),
    /// Take tools off what was cast.
    Demold(Vec<Pull>),
}

impl Action {
    /// As in documents.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Make => "make",
            Self::Prepare => "prepare",
            Self::Assemble => "assemble",
            Self::Bond(_) => "bond",
            Self::Spray(_) => "spray",
            Self::Pour(_) => "pour",
            Self::Demold(_) => "demold",
        }
    }
}

/// A liquid that fills a cavity and becomes a layer.
#[derive(Clone, Debug, PartialEq)]
pub struct Pour {
    /// The layer it becomes, by name.
    pub layer: String,
    /// Everything that encloses the liquid, by name: tools, earlier layers, components.
    pub walls: Vec<String>,
    /// Up while it cures: unit vector in the assembly's frame.
    pub up: Vector3<f64>,
    /// Where the cavity is open: gates and vents.
    pub openings: Vec<Opening>,
    /// What is mixed.
    pub mix: Mix,
    /// Surplus to mix, as a fraction of the layer's mass: what stays in cups and vents.
    pub waste: f64,
    /// How it cures.
    pub cure: Cure,
}

/// A liquid that is sprayed onto a wall and becomes a thin layer.
#[derive(Clone, Debug, PartialEq)]
pub struct Spray {
    /// The layer it becomes, by name.
    pub layer: String,
    /// What it is sprayed on, by name.
    pub onto: Vec<String>,
    /// What is mixed.
    pub mix: Mix,
    /// Surplus to mix, as a fraction of the layer's mass.
    pub waste: f64,
    /// How it cures.
    pub cure: Cure,
}

/// A gate, a vent or a free surface: on this disc the layer may border on air.
#[derive(Clone, Debug, PartialEq)]
pub struct Opening {
    /// For example `vent 3`.
    pub name: String,
    /// Centre of the disc, on the layer's surface, assembly frame, mm.
    pub point: Point3<f64>,
    /// Out of the layer: unit vector, assembly frame.
    pub axis: Vector3<f64>,
    /// Radius of the disc, mm.
    pub radius_mm: f64,
}

/// Components of a liquid.
#[derive(Clone, Debug, PartialEq)]
pub struct Mix {
    /// Each component's name and its share by mass (any scale: `10 : 1`).
    pub by_mass: Vec<(String, f64)>,
    /// Density of the mixture, g/cm^3.
    pub density_g_per_cm3: f64,
    /// How long it can be worked with after mixing, h, where anybody says so.
    pub pot_life_h: Option<f64>,
    /// Whether air is drawn out in a vacuum before pouring.
    pub degas: bool,
}

/// How long and how warm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cure {
    /// Time, h.
    pub hours: f64,
    /// Temperature, degrees Celsius.
    pub celsius: f64,
}

/// A tool that is taken off.
#[derive(Clone, Debug, PartialEq)]
pub struct Pull {
    /// The tool, by name.
    pub body: String,
    /// Where it goes: unit vector in the assembly's frame.
    pub direction: Vector3<f64>,
    /// Where silicone gives way to an undercut, the strain that it bears: a silicone tool that is
    /// peeled off, or a soft layer that slips off the pins of a rigid mold. Where nothing gives,
    /// there is none, and the tool must come off without undercut.
    pub strain_limit: Option<f64>,
}

impl Mix {
    /// Mass of each component for `volume_mm3` of the mixture with `waste` added, g, in order.
    ///
    /// ```
    /// use fabkit_geometry::Mix;
    /// let sylgard = Mix {
    ///     by_mass: vec![("A".into(), 10.0), ("B".into(), 1.0)],
    ///     density_g_per_cm3: 1.03,
    ///     pot_life_h: Some(1.5),
    ///     degas: true,
    /// };
    /// let grams = sylgard.masses_g(1000.0, 0.1);
    /// assert!((grams[0] - 1.03).abs() < 1e-12 && (grams[1] - 0.103).abs() < 1e-12);
    /// ```
    pub fn masses_g(&self, volume_mm3: f64, waste: f64) -> Vec<f64> {
        let total_g = volume_mm3 / 1000.0 * self.density_g_per_cm3 * (1.0 + waste);
        let shares: f64 = self.by_mass.iter().map(|(_, share)| share).sum();
        self.by_mass.iter().map(|(_, share)| total_g * share / shares).collect()
    }
}
