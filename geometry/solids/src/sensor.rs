//! A sensor: all its bodies, what holds them together, its camera and its chain.

use crate::{
    Adhesion, Body, Circuit, Kind, Leg, Lighting, LiquidSkin, Mark, NominalCamera, Pose, Step,
    TouchSurface,
};

/// Parts of several materials that leave the printer as one piece.
///
/// Their solids are in one frame and touch without overlap; their files share their coordinates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PrintGroup {
    /// `[a-z0-9-]{1,64}`; the name of the file that holds them all.
    pub name: String,
    /// The parts by name. The first says how the piece lies on the bed.
    pub parts: Vec<String>,
}

/// Two bodies that are meant to overlap: a press fit, a thread that cuts its own way.
#[derive(Clone, Debug, PartialEq)]
pub struct PressFit {
    /// The one that is pressed in.
    pub inner: String,
    /// The one that holds it.
    pub outer: String,
    /// Largest overlap that is meant, mm, measured across the fit's surface (per side).
    pub interference_mm: f64,
    /// Why.
    pub reason: String,
}

/// A layer that is cast onto something that it does not stick to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Loose {
    /// The step that casts it.
    pub step: String,
    /// The layer.
    pub layer: String,
    /// What it lies on.
    pub on: String,
}

/// A tip that comes off: what is behind it may be wider, and fixtures go around the tip alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Detachable {
    /// What comes off, by name.
    pub bodies: Vec<String>,
    /// How the rest comes back to it, sensor frame.
    pub back: Vec<Leg>,
    /// The same in words, without a full stop.
    pub instruction: String,
}

/// A whole sensor, ready for export, pictures and checks.
///
/// Sensor frame: origin at the centre of the sensing surface's base circle, +z toward the tip.
#[derive(Clone, Debug)]
pub struct Sensor {
    /// `[a-z0-9-]{1,64}`.
    pub name: String,
    /// For people.
    pub title: String,
    /// The paper.
    pub reference: String,
    /// What it consists of and is made with: parts, then layers, then components; see
    /// [`in_order`].
    pub bodies: Vec<Body>,
    /// How it is built, step by step.
    pub chain: Vec<Step>,
    /// Parts that are printed as one piece.
    pub print_groups: Vec<PrintGroup>,
    /// Overlaps that are meant.
    pub press_fits: Vec<PressFit>,
    /// Layers that do not stick to what they lie on, as far as somebody says so.
    pub loose: Vec<Loose>,
    /// What sticks to what, as far as somebody says so.
    pub adhesions: Vec<Adhesion>,
    /// Pairs that the camera tells from each other by one being dark and one light.
    pub contrasts: Vec<[String; 2]>,
    /// What the camera follows while the gel moves; empty where it follows none.
    pub marks: Vec<Mark>,
    /// The ways in which it is lit, the usual one first; empty where nobody says.
    pub lightings: Vec<Lighting>,
    /// How many bits of a grey value its camera gives.
    pub grey_bits: u32,
    /// Quality of the JPEG in which its camera sends pictures, 1 to 100; nothing where it sends them as they are.
    pub jpeg_quality: Option<u8>,
    /// Force that what is touched must bear in every direction, N; `None` where nobody asks.
    pub load_n: Option<f64>,
    /// The camera as designed.
    pub camera: NominalCamera,
    /// What the camera is there to see, by name; empty where there is no camera.
    pub sight: Vec<String>,
    /// The surface that touches things; `None` where nothing is known to press it.
    pub touch: Option<TouchSurface>,
    /// What else is pressed: a skin with channels of liquid.
    pub liquid: Option<LiquidSkin>,
    /// The part that fixtures hold, where it comes off the rest.
    pub detachable: Option<Detachable>,
    /// Where a robot holds it: the middle of the robot's pattern, or of the sensor's own face below; z towards the
    /// sensor, as out of a robot's flange. `None` where no such face is known.
    pub mount: Option<Pose>,
    /// Its circuits: what is etched, soldered and wired.
    pub circuits: Vec<Circuit>,
}

/// Parts first, then layers, then components, each in their own order: that of every list and file.
pub fn in_order(bodies: impl IntoIterator<Item = Body>) -> Vec<Body> {
    // A function of its own, so that it is compiled once, and not for every kind of iterator.
    fn sorted(mut bodies: Vec<Body>) -> Vec<Body> {
        bodies.sort_by_key(|body| match body.kind {
            Kind::Made(_) => 0,
            Kind::Cast => 1,
            Kind::Bought => 2,
        });
        bodies
    }
    sorted(bodies.into_iter().collect())
}

impl Sensor {
    /// Bodies and a camera, without a chain, press fits, a surface to touch with.
    pub fn new(
        name: impl Into<String>,
        title: impl Into<String>,
        reference: impl Into<String>,
        camera: NominalCamera,
        bodies: impl IntoIterator<Item = Body>,
    ) -> Self {
        Self {
            name: name.into(),
            title: title.into(),
            reference: reference.into(),
            bodies: in_order(bodies),
            chain: Vec::new(),
            print_groups: Vec::new(),
            press_fits: Vec::new(),
            loose: Vec::new(),
            adhesions: Vec::new(),
            contrasts: Vec::new(),
            marks: Vec::new(),
            lightings: Vec::new(),
            grey_bits: 8,
            jpeg_quality: None,
            load_n: None,
            camera,
            sight: Vec::new(),
            touch: None,
            liquid: None,
            detachable: None,
            mount: None,
            circuits: Vec::new(),
        }
    }

    /// What is made: each with its process.
    pub fn parts(&self) -> impl Iterator<Item = &Body> + Clone {
        self.bodies.iter().filter(|body| body.is_made())
    }

    /// What is cast.
    pub fn layers(&self) -> impl Iterator<Item = &Body> + Clone {
        self.bodies.iter().filter(|body| body.kind == Kind::Cast)
    }

    /// What is bought.
    pub fn components(&self) -> impl Iterator<Item = &Body> + Clone {
        self.bodies.iter().filter(|body| body.kind == Kind::Bought)
    }

    /// The body of that name.
    pub fn body(&self, name: &str) -> Option<&Body> {
        self.bodies.iter().find(|body| body.name == name)
    }

    /// The same, to change it.
    pub fn body_mut(&mut self, name: &str) -> Option<&mut Body> {
        self.bodies.iter_mut().find(|body| body.name == name)
    }
}
