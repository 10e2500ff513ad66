//! Material properties of bodies: cure, cure inhibition, hardness, strength, elasticity, adhesion, optics.

use std::fmt;

use crate::Rgb;

/// Curing mechanism of a liquid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum CureMechanism {
    /// Silicone with a platinum catalyst (addition cure).
    Platinum,
    /// Silicone with a tin catalyst (condensation cure).
    Tin,
    /// One-part silicone, cured by the water in air.
    Moisture,
    /// Polyurethane.
    Polyurethane,
    /// Epoxy.
    Epoxy,
    /// Resin cured by light.
    Light,
    /// Liquid that dries, such as paint.
    Drying,
}

impl CureMechanism {
    /// Returns the name of such a liquid for texts.
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

/// Material class, for deciding what sticks to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum MaterialClass {
    /// Silicone rubber or gel, and silicone paints and glues.
    Silicone,
    /// Other rubber.
    Rubber,
    /// Liquid that does not cure.
    Liquid,
    /// Plastic of printer filament.
    Plastic,
    /// Printed, light-cured resin.
    Resin,
    /// Acrylic glass.
    Acrylic,
    /// Glass.
    Glass,
    /// Wood, plywood, paper.
    Wood,
    /// Metal.
    Metal,
    /// Laminate of glass fibre and epoxy: circuit boards.
    Laminate,
}

impl MaterialClass {
    /// Returns the word used in tables.
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

/// Shore hardness. The order is from the softest to the hardest.
///
/// The scales overlap (a gel of 00-70 is a rubber of about A 20). Values are ordered by scale first, which separates
/// soft from hard wherever limits lie in the middle of a scale.
///
/// ```
/// use fabkit_geometry::Shore;
/// assert!(Shore::OO(30.0) < Shore::A(10.0) && Shore::A(10.0) < Shore::A(30.0));
/// assert!(Shore::OO(70.0) < Shore::A(10.0)); // by scale, although that gel is the harder one
/// assert_eq!(Shore::A(30.0).to_string(), "Shore A 30");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub enum Shore {
    /// Shore 00, for gels.
    OO(f64),
    /// Shore A, for rubbers.
    A(f64),
    /// Shore D, for hard plastics.
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

/// Property of a material that a rule or a figure needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum MaterialProperty {
    /// Class of the material, which decides what sticks to it.
    Class,
    /// Curing mechanism of a liquid.
    Cure,
    /// Whether the bare material keeps platinum silicone from curing.
    Inhibition,
    /// Shore hardness.
    Hardness,
    /// Stress at which it fails.
    Strength,
    /// Viscosity of the mixture before curing.
    Viscosity,
    /// Linear shrinkage on curing, by which molds are made larger.
    Shrinkage,
    /// Whether its colour is dark or light.
    Shade,
    /// Young's modulus of a soft layer.
    Elasticity,
    /// Temperature at which it softens.
    Softening,
    /// How light passes it.
    Transparency,
    /// Density.
    Density,
    /// Rough price.
    Price,
    /// Share of the light that its surface reflects diffusely.
    Reflectance,
    /// Share of the light that its surface reflects about the mirror direction.
    Gloss,
    /// Share of the light that passes a sheet or a print of it.
    Transmission,
    /// Scattering coefficient of a translucent layer.
    Scattering,
}

impl MaterialProperty {
    /// Returns the property's name for texts, a noun without an article.
    pub fn word(self) -> &'static str {
        match self {
            Self::Class => "class",
            Self::Cure => "curing mechanism",
            Self::Inhibition => "cure inhibition",
            Self::Hardness => "hardness",
            Self::Strength => "strength",
            Self::Viscosity => "viscosity",
            Self::Shrinkage => "shrinkage",
            Self::Shade => "shade",
            Self::Elasticity => "Young's modulus",
            Self::Softening => "softening temperature",
            Self::Transparency => "transparency",
            Self::Density => "density",
            Self::Price => "price",
            Self::Reflectance => "reflectance",
            Self::Gloss => "gloss",
            Self::Transmission => "transmission",
            Self::Scattering => "scattering",
        }
    }

    /// Returns the key that states the property, in `stock:` for what is printed, cut or bought, and in `materials:`
    /// for what is cast.
    pub fn key(self, is_cast: bool) -> &'static str {
        match self {
            Self::Class if is_cast => "kind",
            Self::Class => "sort",
            Self::Cure => "cures",
            Self::Inhibition => "inhibits_platinum",
            Self::Hardness => "hardness",
            Self::Strength => "strength",
            Self::Viscosity => "viscosity",
            Self::Shrinkage => "shrinkage",
            Self::Shade => "shade",
            Self::Elasticity => "youngs_modulus",
            Self::Softening => "softens",
            Self::Transparency => "clarity",
            Self::Density => "density",
            Self::Price => "price",
            Self::Reflectance => "reflectance",
            Self::Gloss => "gloss",
            Self::Transmission => "transmission",
            Self::Scattering => "scattering",
        }
    }

    /// Returns what would settle the property of a material that no source at hand states, as an instruction.
    ///
    /// ```
    /// use fabkit_geometry::MaterialProperty;
    /// let says = MaterialProperty::Density.remedy("jelly", true);
    /// assert_eq!(says, "state `density` of `jelly` below `materials:`");
    /// ```
    pub fn remedy(self, material: &str, is_cast: bool) -> String {
        let key = match self {
            Self::Elasticity => "youngs_modulus`, `modulus` or `hardness",
            _ => self.key(is_cast),
        };
        match material {
            "" => "state what it is made of".to_owned(),
            _ if is_cast => format!("state `{key}` of `{material}` below `materials:`"),
            _ => format!(
                "name a material of the list that docs/reference/own.md gives, or state `{key}` of \
                 `{material}` below `materials:`"
            ),
        }
    }
}

impl fmt::Display for MaterialProperty {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

/// Material properties of a body; `None` where no source at hand states one. Rules ask for them through
/// `fabkit-checks`' `MaterialQuestions`, which reports each property that a rule needed and nobody stated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MaterialProperties {
    /// Material class.
    pub class: Option<MaterialClass>,
    /// Curing mechanism, if it is cast.
    pub cure_mechanism: Option<CureMechanism>,
    /// Curing mechanisms that it inhibits unless it is sealed; empty if it inhibits none.
    pub inhibited_cures: Option<Vec<CureMechanism>>,
    /// Hardness when cured.
    pub shore: Option<Shore>,
    /// Tear strength: stress at which it tears, MPa.
    pub tear_strength_mpa: Option<f64>,
    /// Viscosity of the mixture before curing, Pa s.
    pub viscosity_pa_s: Option<f64>,
    /// Linear shrinkage on curing, as a fraction, if it is cast.
    pub cast_shrinkage: Option<f64>,
    /// Whether it is dark, where its colour provides contrast.
    pub is_dark: Option<bool>,
    /// Refractive index for visible light, against vacuum.
    pub refractive_index: Option<f64>,
    /// Softening temperature.
    pub softening_point: Option<SofteningPoint>,
    /// Elasticity; `None` for stiff or unknown materials.
    pub elasticity: Option<Elasticity>,
    /// Density, g/cm3; of the mixture, if it is cast.
    pub density_g_per_cm3: Option<f64>,
    /// Rough price of small amounts, US dollars per kg, to compare designs.
    pub usd_per_kg: Option<f64>,
    /// Width that a laser's beam removes, mm.
    pub laser_kerf_mm: Option<f64>,
    /// Whether prints lift their corners off the bed while they cool.
    pub warps: Option<bool>,
    /// Reflection and transmission of light.
    pub optics: OpticalProperties,
}

/// Reflection and transmission of light by a part or a coat as it is made. Each figure is `None` where no source states
/// it.
///
/// ```
/// use fabkit_geometry::{OpticalFigure, OpticalProperties};
///
/// let red = OpticalFigure { value: [0.6, 0.2, 0.1], is_chosen: false, source: "measured".to_owned() };
/// let paint = OpticalProperties { reflectance: Some(red), ..OpticalProperties::default() };
/// assert!(paint.mean_reflectance().is_some_and(|mean| (mean - 0.3).abs() < 1e-12));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OpticalProperties {
    /// Diffuse reflectance for red, green and blue light, 0 to 1.
    pub reflectance: Option<OpticalFigure<Rgb>>,
    /// Reflection about the mirror direction.
    pub gloss: Option<OpticalFigure<Gloss>>,
    /// Share of the light that passes, 0 to 1, scattered or not.
    pub transmission: Option<OpticalFigure<f64>>,
    /// Scattering coefficient of a translucent layer: part of the light that turns back per millimetre, 1/mm.
    pub scattering_per_mm: Option<OpticalFigure<f64>>,
}

impl OpticalProperties {
    /// Returns the diffuse reflectance as a camera without colours sees it; `None` if it is not known.
    pub fn mean_reflectance(&self) -> Option<f64> {
        let [red, green, blue] = self.reflectance.as_ref()?.value;
        // Three equal numbers are their mean, without the rounding of a sum.
        let is_grey = red == green && green == blue;
        Some(if is_grey { red } else { (red + green + blue) / 3.0 })
    }
}

/// Optical figure of a material with its source.
#[derive(Clone, Debug, PartialEq)]
pub struct OpticalFigure<T> {
    /// Value, dimensionless, or in the unit that the field's name gives.
    pub value: T,
    /// Whether it is a choice, rather than stated by a maker or a paper, or measured.
    pub is_chosen: bool,
    /// Source, or the reason of a choice.
    pub source: String,
}

/// Reflection about the mirror direction (Blinn 1977).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gloss {
    /// Share of the light, 0 to 1.
    pub share: f64,
    /// Exponent: 1 is nearly as wide as diffuse reflection, 1000 is polished.
    pub exponent: f64,
}

/// Elastic properties of a rubber or a gel, at small strain.
#[derive(Clone, Debug, PartialEq)]
pub struct Elasticity {
    /// Young's modulus, MPa.
    pub young_mpa: f64,
    /// Range of Young's modulus over batches, cures and sources, MPa.
    pub young_range_mpa: [f64; 2],
    /// Poisson's ratio, below 0.5.
    pub poissons_ratio: f64,
    /// Coulomb friction coefficient against a dry, smooth, hard indenter; `None` if no source states it.
    pub friction: Option<f64>,
    /// Source of the values, or their derivation.
    pub source: String,
}

/// Temperature at which a stiff material softens under a small load.
#[derive(Clone, Debug, PartialEq)]
pub struct SofteningPoint {
    /// Temperature, degrees Celsius.
    pub celsius: f64,
    /// Source and test method.
    pub source: String,
}

/// Adhesion between two bodies, wherever their faces meet.
#[derive(Clone, Debug, PartialEq)]
pub struct Adhesion {
    /// Names of the two bodies.
    pub bodies: [String; 2],
    /// Bonding agent or process, for texts: `cast on`, `PR-1200`, `Sil-Poxy`.
    pub by: String,
    /// Largest distance between their faces that it bridges, mm.
    pub reach_mm: f64,
    /// Minimum shear strength along the face, MPa.
    pub shear_mpa: f64,
    /// Minimum tensile strength across the face, MPa.
    pub pull_mpa: f64,
}
