//! What a body is made from, as far as what touches it asks: how it cures, what it keeps from curing, how
//! hard it is, what it bears.

use std::fmt;

/// How a liquid becomes solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Curing {
    /// A silicone with a platinum catalyst, by addition.
    Platinum,
    /// A silicone with a tin catalyst, by condensation.
    Tin,
    /// A silicone of one part, by the water in air.
    Moisture,
    /// A polyurethane.
    Polyurethane,
    /// An epoxy.
    Epoxy,
    /// A resin under light.
    Light,
    /// What dries.
    Drying,
}

impl Curing {
    /// For people: what a liquid of that kind is called.
    pub fn word(self) -> &'static str {
        match self {
            Self::Platinum => "platinum silicone",
            Self::Tin => "tin silicone",
            Self::Moisture => "moisture silicone",
            Self::Polyurethane => "polyurethane",
            Self::Epoxy => "epoxy",
            Self::Light => "light-cured resin",
            Self::Drying => "what dries",
        }
    }
}

/// What sort of stuff it is, for what sticks to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Sort {
    /// A rubber or gel of silicone, and paints and glues of it.
    Silicone,
    /// Another rubber.
    Rubber,
    /// A liquid that stays one.
    Liquid,
    /// A plastic of a printer's filament.
    Plastic,
    /// A printed, light-cured resin.
    Resin,
    /// Acrylic glass.
    Acrylic,
    /// Glass.
    Glass,
    /// Wood, plywood, paper.
    Wood,
    /// Metal.
    Metal,
    /// Glass fibre in epoxy: circuit boards.
    Laminate,
}

impl Sort {
    /// The word used in tables.
    pub fn word(self) -> &'static str {
        match self {
            Self::Silicone => "silicone",
            Self::Rubber => "rubber",
            Self::Liquid => "liquid",
            Self::Plastic => "plastic",
            Self::Resin => "resin",
            Self::Acrylic => "acrylic",
            Self::Glass => "glass",
            Self::Wood => "wood",
            Self::Metal => "metal",
            Self::Laminate => "laminate",
        }
    }
}

/// Hardness on the scales of Shore, from the softest to the hardest.
///
/// The scales overlap (a gel of 00-70 is a rubber of about A 20); ordered by scale first, they tell soft
/// from hard wherever limits lie in the middle of a scale.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub enum Shore {
    /// Gels.
    OO(f64),
    /// Rubbers.
    A(f64),
    /// Hard plastics.
    D(f64),
}

impl fmt::Display for Shore {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OO(value) => write!(f, "Shore 00-{value}"),
            Self::A(value) => write!(f, "Shore A {value}"),
            Self::D(value) => write!(f, "Shore D {value}"),
        }
    }
}

/// What a body is made from; what nobody knows is left out, and no rule asks for it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Substance {
    /// What sort of stuff it is.
    pub sort: Option<Sort>,
    /// How it cures, where it is cast.
    pub cures: Option<Curing>,
    /// What it keeps from curing, unless it is sealed.
    pub inhibits: Vec<Curing>,
    /// How hard it is when it has cured.
    pub shore: Option<Shore>,
    /// Stress at which it tears, MPa.
    pub tears_mpa: Option<f64>,
    /// Viscosity of the mixture, Pa s.
    pub viscosity_pa_s: Option<f64>,
    /// Where a colour carries contrast: whether it is dark.
    pub is_dark: Option<bool>,
    /// Refractive index for visible light, against vacuum.
    pub refractive_index: Option<f64>,
    /// Where it gives way to heat.
    pub softens: Option<Softens>,
    /// How it gives way to a press; nothing of what is stiff, and of what nobody knows.
    pub elasticity: Option<Elasticity>,
}

/// How a rubber or a gel gives way, at small strain.
#[derive(Clone, Debug, PartialEq)]
pub struct Elasticity {
    /// Young's modulus, MPa.
    pub young_mpa: f64,
    /// Between which moduli batches, cures and sources lie, MPa.
    pub young_range_mpa: [f64; 2],
    /// Poisson's ratio, below 0.5.
    pub poissons_ratio: f64,
    /// Coulomb's coefficient against a dry, smooth, hard presser; where somebody says.
    pub friction: Option<f64>,
    /// Who says so, or what it follows from.
    pub source: String,
}

/// The temperature at which a stiff material gives way under a small load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Softens {
    /// Degrees Celsius.
    pub celsius: f64,
    /// Who says so, and by which test.
    pub source: &'static str,
}

/// Two bodies that stick to each other wherever their faces meet.
#[derive(Clone, Debug, PartialEq)]
pub struct Adhesion {
    /// The two, by name.
    pub bodies: [String; 2],
    /// What holds them together, for people: `cast on`, `PR-1200`, `Sil-Poxy`.
    pub by: String,
    /// How far their faces may be apart, mm.
    pub reach_mm: f64,
    /// Least strength along the face, MPa.
    pub shear_mpa: f64,
    /// Least strength across the face, MPa.
    pub pull_mpa: f64,
}
