//! Manufacturing plan of a sensor: an ordered chain of steps, as data.
//!
//! The chain is complete enough to be checked without pouring anything. Each pour names the walls of its cavity and its
//! openings; each demolding names the direction in which a tool comes off.

use nalgebra::{Point3, Vector3};

use crate::{Assembly, Motion};

/// One manufacturing step, in the order of the chain.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Name, `[a-z0-9-]{1,64}`, unique in the chain.
    pub name: String,
    /// Instruction to the person who carries out the step, as a sentence.
    pub instruction: String,
    /// Arrangement of the bodies during the step.
    pub assembly: Option<Assembly>,
    /// Names of the parts, layers and components that the step needs or joins.
    pub bodies: Vec<String>,
    /// Paths by which bodies reach their places, given where they are not straight or where they matter.
    pub motions: Vec<Motion>,
    /// Means that keep small bodies where the step puts them.
    pub fixings: Vec<Fixing>,
    /// Manual adjustments made in the step, such as focusing a lens.
    pub adjustments: Vec<Adjustment>,
    /// Name of the earlier step whose cure is still running during this one. `None`: everything cast or glued before
    /// has cured.
    pub during_cure_of: Option<String>,
    /// Operation of the step.
    pub action: Action,
    /// Section of the paper that describes the step, or the reason why fabkit chose it.
    pub source: String,
}

impl Step {
    /// Adds bodies that the step needs.
    #[must_use]
    pub fn with_bodies(mut self, bodies: impl IntoIterator<Item = String>) -> Self {
        self.bodies.extend(bodies);
        self
    }

    /// Adds the path by which some of the bodies reach their places.
    #[must_use]
    pub fn with_motion(mut self, motion: Motion) -> Self {
        self.motions.push(motion);
        self
    }

    /// Adds the adjustment of one body, made with everything in place that stands there by then.
    #[must_use]
    pub fn with_adjustment(mut self, body: impl Into<String>) -> Self {
        self.adjustments.push(Adjustment { body: body.into(), is_apart: false });
        self
    }

    /// Adds the adjustment of one body, made among only those bodies that the step itself brings. The body is put
    /// together with the rest, looked at, and taken away again to be adjusted.
    #[must_use]
    pub fn with_separate_adjustment(mut self, body: impl Into<String>) -> Self {
        self.adjustments.push(Adjustment { body: body.into(), is_apart: true });
        self
    }

    /// Marks the step as done while the cure of the named earlier step is running.
    #[must_use]
    pub fn during_cure_of(self, step: impl Into<String>) -> Self {
        Self { during_cure_of: Some(step.into()), ..self }
    }

    /// Returns the cure of the layer or adhesive that the step casts, sprays or glues; `None` for other actions.
    pub fn cure(&self) -> Option<Cure> {
        match &self.action {
            Action::Bond(cure) => Some(*cure),
            Action::Spray(spray) => Some(spray.cure),
            Action::Pour(pour) => Some(pour.cure),
            Action::Make | Action::Prepare | Action::Assemble | Action::Demold(_) => None,
        }
    }
}

/// Manual adjustment of a body in a step. The body's [`ToolAccess`](crate::ToolAccess) on
/// [`Occasion::Adjustment`](crate::Occasion::Adjustment) gives the room that it takes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Adjustment {
    /// Name of the adjusted body.
    pub body: String,
    /// True if the body is adjusted away from the bodies that stood there before the step: only what the step brings
    /// stands around it.
    pub is_apart: bool,
}

/// Fastening that keeps small bodies in place although no other body blocks their movement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fixing {
    /// Names of the fastened bodies.
    pub bodies: Vec<String>,
    /// Names of the bodies they are fastened to; each piece on one of them.
    pub onto: Vec<String>,
    /// Means of fastening.
    pub means: FixingMeans,
}

/// Means of fastening a small body to the body it touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FixingMeans {
    /// Solder.
    Solder,
    /// A drop of glue.
    Glue,
    /// Its own adhesive back.
    Tape,
    /// Friction: it is pushed onto or into something.
    Push,
}

/// Operation of a manufacturing step.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Print, cut or etch parts.
    Make,
    /// Clean, prime, spray release agent.
    Prepare,
    /// Put bodies together: press, screw, slide.
    Assemble,
    /// Glue bodies together, with the cure of the adhesive.
    Bond(Cure),
    /// Coat a wall with a layer too thin to need a cavity.
    Spray(Spray),
    /// Fill a cavity with a liquid.
    Pour(Pour),
    /// Take tools off the cast bodies.
    Demold(Vec<Pull>),
}

impl Action {
    /// Returns the word for this action in documents.
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
    /// Name of the layer that the liquid becomes.
    pub layer: String,
    /// Names of all bodies that enclose the liquid: tools, earlier layers, components.
    pub walls: Vec<String>,
    /// Upward direction while it cures: unit vector in the assembly's frame.
    pub up: Vector3<f64>,
    /// Openings of the cavity: gates and vents.
    pub openings: Vec<Opening>,
    /// Mixture that is poured.
    pub mix: Mix,
    /// Surplus to mix, as a fraction of the layer's mass: the residue in cups and vents.
    pub waste: f64,
    /// Cure of the layer.
    pub cure: Cure,
}

/// A liquid that is sprayed onto a wall and becomes a thin layer.
#[derive(Clone, Debug, PartialEq)]
pub struct Spray {
    /// Name of the layer that the liquid becomes.
    pub layer: String,
    /// Names of the bodies that are sprayed.
    pub onto: Vec<String>,
    /// Mixture that is sprayed.
    pub mix: Mix,
    /// Surplus to mix, as a fraction of the layer's mass.
    pub waste: f64,
    /// Cure of the layer.
    pub cure: Cure,
}

/// Gate, vent or free surface: a disc on which the layer may border on air.
#[derive(Clone, Debug, PartialEq)]
pub struct Opening {
    /// Name, for example `vent 3`.
    pub name: String,
    /// Centre of the disc, on the layer's surface, assembly frame, mm.
    pub point: Point3<f64>,
    /// Axis that points out of the layer: unit vector, assembly frame.
    pub axis: Vector3<f64>,
    /// Radius of the disc, mm.
    pub radius_mm: f64,
}

/// Mixture of liquid components.
#[derive(Clone, Debug, PartialEq)]
pub struct Mix {
    /// Each component's name and its share by mass (any scale: `10 : 1`).
    pub by_mass: Vec<(String, f64)>,
    /// Density of the mixture, g/cm^3.
    pub density_g_per_cm3: f64,
    /// Pot life after mixing, h; `None` if no source states it.
    pub pot_life_h: Option<f64>,
    /// True if air is drawn out in a vacuum before pouring.
    pub degas: bool,
}

/// Curing time and temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cure {
    /// Time, h.
    pub hours: f64,
    /// Temperature, degrees Celsius.
    pub celsius: f64,
}

/// Removal of a tool from the cast.
#[derive(Clone, Debug, PartialEq)]
pub struct Pull {
    /// The tool, by name.
    pub body: String,
    /// Direction of removal: unit vector in the assembly's frame.
    pub direction: Vector3<f64>,
    /// Strain that the silicone bears where it yields to an undercut: a silicone tool that is peeled off, or a soft
    /// layer that slips off the pins of a rigid mold. `None` where nothing yields: then the tool must come off without
    /// an undercut.
    pub strain_limit: Option<f64>,
}

impl Mix {
    /// Returns the mass of each component, g, in the order of `by_mass`, for `volume_mm3` of the mixture plus the
    /// fraction `waste`.
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
