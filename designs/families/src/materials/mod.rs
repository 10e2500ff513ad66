//! Materials: liquids that are cast (components, cure, shrinkage), and what parts are printed, cut or milled from.
//!
//! No rule reads words of a material's name: names are looked up in `materials.yaml`, for what is cast, and `stock.yaml`,
//! for the rest, and what neither states is not known.
//!
//! The built-in materials are in `materials.yaml`, in the form in which users write their own. A mixing ratio or cure
//! time that a paper states overrides them, in the sensor's chain.

mod adhesion;
mod bonds;
mod catalogue;
mod elasticity;
mod optics;
mod qualifiers;
mod stock;
mod stock_file;
mod units;

use std::ops::Deref;
use std::sync::Arc;

use fabkit_geometry::{
    BodyKind, Cure, CureMechanism, MaterialClass, MaterialProperties, Mix,
    OpticalClarity as Optics, Sensor, Shore,
};
use fabkit_text::Setting;

use crate::{choices, parameters};

pub(crate) use adhesion::{assign_substances, find_adhesions};
pub(crate) use bonds::{add_bonds, check_kinds};
pub(crate) use catalogue::{Catalogue, MATERIALS};
pub use qualifiers::Shade;
pub(crate) use stock::{StockCatalogue, StockMaterial};
pub(crate) use units::split_number;
pub use units::{
    Celsius, Current, Density, Euros, Force, Hardness, Hours, Kelvin, Mass, Minutes, Percent,
    Pressure, PriceByMass, Reflectance, Scale, Scattering, Viscosity, Voltage, Wavelength,
};

/// Room temperature, degrees Celsius, the default temperature of a cure.
const ROOM: Celsius = Celsius(23.0);

choices! {
    /// Kind of a material.
    pub enum MaterialKind {
        /// Silicone rubber.
        Silicone = "silicone",
        /// Soft gel.
        Gel = "gel",
        /// Polyurethane rubber or resin.
        Polyurethane = "polyurethane",
        /// Epoxy resin.
        Epoxy = "epoxy",
        /// Paint that coats a surface.
        Paint = "paint",
        /// Ink that marks a surface.
        Ink = "ink",
        /// Glue that joins parts.
        Glue = "glue",
        /// Any other material.
        Other = "other",
    }
}

choices! {
    /// Mechanism by which a material cures.
    pub enum CuresBy {
        /// Silicone with a platinum catalyst, inhibited by sulfur, tin, amines and bare printed resin.
        Platinum = "platinum",
        /// Silicone with a tin catalyst, which inhibits platinum.
        Tin = "tin",
        /// One-part silicone, cured by the water in air.
        Moisture = "moisture",
        /// Polyurethane.
        Polyurethane = "polyurethane",
        /// Epoxy, whose amines inhibit platinum.
        Epoxy = "epoxy",
        /// Light-cured resin, whose residues inhibit platinum.
        Light = "light",
        /// Drying: a solvent evaporates.
        Drying = "drying",
    }
}

choices! {
    /// Transparency of a material.
    pub enum Clarity {
        /// Transparent.
        Clear = "clear",
        /// Translucent: it scatters light.
        Translucent = "translucent",
        /// Opaque: it stops light.
        Opaque = "opaque",
    }
}

impl Clarity {
    /// Returns the clarity of the geometry crate.
    fn optical(self) -> Optics {
        match self {
            Self::Clear => Optics::Clear,
            Self::Translucent => Optics::Translucent,
            Self::Opaque => Optics::Opaque,
        }
    }
}

parameters! {
    /// Curing time and temperature of a material.
    pub struct CureFigures {
        /// Curing time.
        time: Hours = 0.01..=2000.0,
        /// Curing temperature; 23 C if not given.
        temperature: Option<Celsius> = -20.0..=300.0,
    }
}

parameters! {
    /// Material that is cast, sprayed or painted. Unknown data are left out.
    pub struct Figures {
        /// Kind of the material.
        kind: Option<MaterialKind>,
        /// Density of the mixture.
        density: Density = 0.05..=25.0,
        /// Rough price of small amounts, to compare designs.
        price: Option<PriceByMass> = 0.0..=100000.0,
        /// Curing time and temperature of the material.
        cure: CureFigures,
        /// Curing mechanism, which also decides what inhibits the cure.
        cures: Option<CuresBy>,
        /// Viscosity of the mixture.
        viscosity: Option<Viscosity> = 0.0001..=10000.0,
        /// Pot life: working time after mixing.
        pot_life: Option<Minutes> = 0.1..=10000.0,
        /// Linear shrinkage on curing, by which molds are made larger.
        shrinkage: Option<Percent> = 0.0..=20.0,
        /// Strain at which the material breaks. It limits how far a tool can be stretched when it is peeled off.
        breaking_strain: Option<Percent> = 0.1..=5000.0,
        /// Stress at which the material breaks.
        strength: Option<Pressure> = 1.0..=1000000.0,
        /// Durometer hardness.
        hardness: Option<Hardness>,
        /// Tensile modulus at 100 % strain.
        modulus: Option<Pressure> = 0.01..=10000000.0,
        /// Young's modulus of the cured material at small strain.
        youngs_modulus: Option<Pressure> = 0.01..=10000000.0,
        /// Lowest Young's modulus among batches, cures and sources.
        youngs_modulus_least: Option<Pressure> = 0.01..=10000000.0,
        /// Highest Young's modulus among batches, cures and sources.
        youngs_modulus_most: Option<Pressure> = 0.01..=10000000.0,
        /// Poisson's ratio; 0.495 for rubbers and gels, which keep their volume, if not given.
        poissons_ratio: Option<f64> = 0.0..=0.4999,
        /// Coulomb friction coefficient against a dry, smooth, hard indenter.
        friction: Option<f64> = 0.0..=10.0,
        /// Refractive index for visible light.
        refractive_index: Option<f64> = 1.0..=3.0,
        /// Transparency of the material: `clear`, `translucent` or `opaque`.
        clarity: Option<Clarity>,
        /// Brightness of the cured material: `dark` or `light`, where a camera tells it from another one.
        shade: Option<Shade>,
        /// Diffuse reflectance of the cured material, seen through what it coats: one percentage, or three of red, green
        /// and blue light.
        reflectance: Option<Reflectance> = 0.0..=100.0,
        /// Share of the light that the cured material reflects about the mirror direction.
        gloss: Option<Percent> = 0.0..=100.0,
        /// Width of the gloss as Blinn's exponent: 1 is nearly as wide as diffuse reflection, 1000 is polished.
        gloss_exponent: Option<f64> = 1.0..=10000.0,
        /// Scattering coefficient of a translucent layer: part of the light that turns back per millimetre.
        scattering: Option<Scattering> = 0.001..=100.0,
        /// True if the mixture is degassed in a vacuum before pouring; false if not given.
        degas: Option<bool>,
        /// Source of these data.
        source: Option<String> = 0..=500,
        /// Advice on using the material.
        note: Option<String> = 0..=500,
    }
}

/// Bond of a material to another one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bond {
    /// Name or kind of the other material.
    pub to: String,
    /// Means by which it holds.
    pub hold: BondMethod,
}

/// Means by which a material holds to another one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BondMethod {
    /// Bonds by itself.
    SelfBonding,
    /// Bonds with a primer, by name, that is applied first.
    Primer(String),
    /// Does not bond.
    NoBond,
}

/// Returns the transparency of a window cut from a sheet or made of resin, by the built-in catalogue; `None` if it is not
/// known. What a file states is asked when the design is complete.
pub(crate) fn window_transparency(material: &str) -> Option<Optics> {
    StockCatalogue::builtin().window_transparency(material)
}

/// Returns whether a material is dark, by the built-in catalogues: the entry of what is cast, else the entry of stock and
/// the colours beside its name. Families draw by it, and pigments are told apart by it; rules ask the bodies.
pub(crate) fn is_dark(material: &str) -> Option<bool> {
    let cast = Catalogue::builtin().find(material).and_then(|cast| cast.material().figures.shade);
    let shade = cast.or_else(|| StockCatalogue::builtin().shade(material));
    shade.map(|shade| shade == Shade::Dark)
}

/// Origin of a material's description.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MaterialOrigin {
    /// Built into fabkit.
    BuiltIn,
    /// Defined by a file.
    UserDefined(String),
    /// Built in, and changed by a file.
    Changed(String),
}

/// Material with all its properties.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Maker and product, as sensor files name it.
    pub name: String,
    /// Origin of the description.
    pub origin: MaterialOrigin,
    /// Measured and stated properties.
    pub figures: Figures,
    /// Components and their shares by mass, on any scale.
    pub by_mass: Vec<(String, f64)>,
    /// Bonds to other materials.
    pub bonds: Vec<Bond>,
    /// All properties as written, with their sources; paths begin with `materials.NAME.`.
    pub settings: Vec<Setting>,
}

impl Material {
    /// Returns whether the material is as fabkit comes with it.
    pub fn is_builtin(&self) -> bool {
        self.origin == MaterialOrigin::BuiltIn
    }
}

/// Castable material as a parameter: read by its name, and dereferenced to it.
///
/// ```
/// let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// let design = fabkit_designs::load("rtac0.yaml", yaml, &[], &["fixtures"])?;
/// let is_it = |name: &str| name == "Smooth-On Ecoflex 00-30";
/// let ecoflex = design.materials.iter().find(|one| is_it(one)).ok_or("another material")?;
/// // Parts A and B in equal shares, worked for 45 minutes, stretched to ten times its length.
/// assert_eq!(
///     ecoflex.mix().by_mass.iter().map(|(_, share)| *share).collect::<Vec<_>>(),
///     [1.0, 1.0]
/// );
/// assert_eq!(ecoflex.mix().pot_life_h, Some(0.75));
/// assert_eq!(ecoflex.breaking_strain(), Some(9.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Castable(Arc<Material>);

impl Castable {
    /// Returns the material with all its properties.
    pub fn material(&self) -> &Material {
        &self.0
    }

    /// Returns the components and how to mix them.
    pub fn mix(&self) -> Mix {
        Mix {
            by_mass: self.0.by_mass.clone(),
            density_g_per_cm3: self.0.figures.density.0,
            pot_life_h: self.0.figures.pot_life.map(|Minutes(minutes)| minutes / 60.0),
            degas: self.0.figures.degas.unwrap_or(false),
        }
    }

    /// Returns time and temperature of the cure.
    pub fn cure(&self) -> Cure {
        let CureFigures { time, temperature } = &self.0.figures.cure;
        Cure { hours: time.0, celsius: temperature.unwrap_or(ROOM).0 }
    }

    /// Sets the transparency of all layers cast from this material, if it is known.
    pub(crate) fn apply_transparency(&self, sensor: &mut Sensor) {
        let Some(optics) = self.clarity() else { return };
        let cast = sensor.bodies.iter_mut().filter(|body| body.kind == BodyKind::Cast);
        // The transparency that a family states stays, for example of a layer with pigment.
        cast.filter(|body| body.optics.is_none() && body.material == **self)
            .for_each(|body| body.set_clarity(optics));
    }

    /// Returns the transparency, if it is known.
    pub(crate) fn clarity(&self) -> Option<Optics> {
        self.0.figures.clarity.map(Clarity::optical)
    }

    /// Returns the linear shrinkage on curing, as a fraction; 0 where it is not stated.
    pub fn shrinkage(&self) -> f64 {
        self.0.figures.shrinkage.map_or(0.0, Percent::share)
    }

    /// Returns the breaking strain as a fraction; without one, nothing can be peeled off the material.
    pub fn breaking_strain(&self) -> Option<f64> {
        self.0.figures.breaking_strain.map(Percent::share)
    }
}

/// Dereferences to the name of the material.
impl Deref for Castable {
    type Target = str;

    fn deref(&self) -> &str {
        &self.0.name
    }
}

impl From<&Castable> for String {
    fn from(castable: &Castable) -> Self {
        castable.0.name.clone()
    }
}

/// Returns the properties of a layer that is cast from a material of the catalogue.
fn castable_properties(castable: &Castable) -> MaterialProperties {
    let figures = &castable.material().figures;
    let cures = figures.cures.map(CuresBy::mechanism);
    let class = match figures.kind {
        Some(MaterialKind::Silicone | MaterialKind::Gel) => Some(MaterialClass::Silicone),
        Some(MaterialKind::Polyurethane) => Some(MaterialClass::Rubber),
        // Without a kind, these mechanisms still identify a silicone.
        _ => matches!(
            cures,
            Some(CureMechanism::Platinum | CureMechanism::Tin | CureMechanism::Moisture)
        )
        .then_some(MaterialClass::Silicone),
    };
    // Traces of a tin catalyst, amines, and residues of light-cured resins poison platinum catalysts.
    let poisons =
        |by| matches!(by, CureMechanism::Tin | CureMechanism::Epoxy | CureMechanism::Light);
    MaterialProperties {
        class,
        cure_mechanism: cures,
        inhibited_cures: cures
            .map(|by| if poisons(by) { vec![CureMechanism::Platinum] } else { Vec::new() }),
        shore: figures.hardness.map(shore),
        tear_strength_mpa: figures.strength.map(|Pressure(kpa)| kpa / 1e3),
        viscosity_pa_s: figures.viscosity.map(|Viscosity(pa_s)| pa_s),
        cast_shrinkage: figures.shrinkage.map(Percent::share),
        is_dark: figures.shade.map(|shade| shade == Shade::Dark),
        refractive_index: figures.refractive_index,
        softening_point: None,
        elasticity: elasticity::elasticity_from_castable(castable.material(), class),
        density_g_per_cm3: Some(figures.density.0),
        usd_per_kg: figures.price.map(|PriceByMass(usd_per_kg)| usd_per_kg),
        laser_kerf_mm: None,
        warps: None,
        optics: optics::optics_of_castable(castable.material()),
    }
}

/// Converts a hardness to the type of the geometry crate.
fn shore(Hardness { scale, value }: Hardness) -> Shore {
    match scale {
        Scale::Shore00 => Shore::OO(value),
        Scale::ShoreA => Shore::A(value),
        Scale::ShoreD => Shore::D(value),
    }
}

impl CuresBy {
    /// Returns the mechanism in the geometry crate.
    fn mechanism(self) -> CureMechanism {
        match self {
            Self::Platinum => CureMechanism::Platinum,
            Self::Tin => CureMechanism::Tin,
            Self::Moisture => CureMechanism::Moisture,
            Self::Polyurethane => CureMechanism::Polyurethane,
            Self::Epoxy => CureMechanism::Epoxy,
            Self::Light => CureMechanism::Light,
            Self::Drying => CureMechanism::Drying,
        }
    }
}
