//! What parts are made from and what is bought: stuff that is not cast, by words of its trade name.

use fabkit_geometry::{Body, Curing, Shore, Softens, Sort, Substance};

use super::{Castable, CuresBy, Hardness, MaterialKind, Pressure, Scale, Viscosity, elasticity};

/// Words of a trade name, and what it is then; the first row of which one word fits counts.
struct Stock {
    words: &'static [&'static str],
    sort: Sort,
    /// On which scale, and how much; of the softest in use.
    shore: Shore,
    /// Stress that it bears at least, MPa.
    bears_mpa: f64,
    /// Whether it keeps platinum silicone from curing where it is bare.
    ///
    /// Smooth-On's bulletins of Ecoflex, Solaris and Mold Star name sulfur clays, tin silicones, latex,
    /// some stereolithographic resins and bare wood; Formlabs' guide to silicone molds asks for a coat on
    /// prints of its resins.
    inhibits: bool,
    /// Refractive index in the middle of the visible, where it is seen through.
    refractive_index: Option<f64>,
}

const STOCK: [Stock; 13] = [
    // Stratasys, data sheet of Tango: Shore A 26 to 28, tensile strength 0.8 to 1.5 MPa.
    stock(&["tango", "agilus", "elastic"], Sort::Rubber, Shore::A(26.0), 0.8, true),
    stock(&["tpu", "rubber", "o-ring"], Sort::Rubber, Shore::A(60.0), 5.0, false),
    stock(&["latex", "sulfur", "sulphur"], Sort::Rubber, Shore::A(30.0), 5.0, true),
    // Stratasys, data sheet of Vero: Shore D 83 to 86, 50 to 65 MPa; Formlabs' of its standard resins: 38 MPa
    // as printed.
    stock(
        &["resin", "sla", "formlabs", "polyjet", "vero"],
        Sort::Resin,
        Shore::D(80.0),
        30.0,
        true,
    ),
    // Evonik, data sheet of Plexiglas GS: 80 MPa; a laser's edge leaves less. Refractive index 1.491.
    stock(&["acrylic", "pmma", "plexiglas"], Sort::Acrylic, Shore::D(90.0), 30.0, false)
        .bends(1.491),
    // Borosilicate: DIN ISO 3585 allows 7 MPa; Schott, data sheet of Duran: refractive index 1.473.
    stock(&["glass"], Sort::Glass, Shore::D(100.0), 7.0, false).bends(1.473),
    // Across the layers of a filament's print, the weakest way, PLA bears about half of 50 MPa.
    stock(
        &["pla", "abs", "petg", "asa", "nylon", "pet", "pc"],
        Sort::Plastic,
        Shore::D(70.0),
        15.0,
        false,
    ),
    // Birch plywood, EN 636: more than 10 MPa along its weaker grain.
    stock(&["plywood", "wood", "mdf", "paper", "cardboard"], Sort::Wood, Shore::D(50.0), 5.0, true),
    stock(&["fr4", "board"], Sort::Laminate, Shore::D(90.0), 50.0, false),
    stock(&["steel", "aluminium", "aluminum", "brass"], Sort::Metal, Shore::D(100.0), 100.0, false),
    // Water at 20 C: 1.333 (IAPWS release on the refractive index, 1997).
    stock(&["water", "oil"], Sort::Liquid, Shore::OO(0.0), 0.0, false).bends(1.333),
    stock(&["screw", "bolt", "nut", "pin", "spacer"], Sort::Metal, Shore::D(100.0), 100.0, false),
    // Tubes and sheets of it: that of crosslinked polydimethylsiloxane.
    stock(&["silicone"], Sort::Silicone, Shore::A(10.0), 1.0, false).bends(1.41),
];

const fn stock(
    words: &'static [&'static str],
    sort: Sort,
    shore: Shore,
    bears_mpa: f64,
    inhibits: bool,
) -> Stock {
    Stock { words, sort, shore, bears_mpa, inhibits, refractive_index: None }
}

impl Stock {
    const fn bends(self, refractive_index: f64) -> Self {
        Self { refractive_index: Some(refractive_index), ..self }
    }
}

/// Words of a trade name, and where it softens then; the first row of which one word fits counts. Of families of
/// plastics, the lowest figure among common makes.
const SOFTENS: [(&[&str], f64, &str); 8] = [
    (&["petg", "pet"], 68.0, "Prusa, data sheet of Prusament PETG: heat deflection at 0.45 MPa"),
    (&["pla"], 55.0, "Prusa, data sheet of Prusament PLA: heat deflection at 0.45 MPa"),
    (&["asa"], 93.0, "Prusa, data sheet of Prusament ASA: heat deflection at 0.45 MPa"),
    (&["abs"], 80.0, "chosen: data sheets of ABS filaments name 80 to 98 C at 0.45 MPa"),
    (
        &["vero", "tango", "polyjet"],
        45.0,
        "Stratasys, data sheet of Vero: heat deflection at 0.45 MPa, 45 to 50 C",
    ),
    (
        &["resin", "sla", "formlabs"],
        58.0,
        "Formlabs, data sheet of its standard resins: heat deflection at 0.45 MPa, 58 C before and 73 C after curing",
    ),
    (
        &["acrylic", "pmma", "plexiglas"],
        80.0,
        "Evonik, data sheet of Plexiglas GS: permanent service temperature",
    ),
    (&["tpu"], 60.0, "chosen: data sheets of TPU filaments name Vicat temperatures from 60 C"),
];

fn softens(words: &[String]) -> Option<Softens> {
    let says = |known: &[&str]| words.iter().any(|word| known.contains(&&**word));
    let found = SOFTENS.iter().find(|(known, ..)| says(known));
    found.map(|(_, celsius, source)| Softens { celsius: *celsius, source })
}

/// Words that say that nothing lies on it.
const BARE: [&str; 4] = ["bare", "uncoated", "unsealed", "untreated"];

/// Words that say that something seals it.
const SEALED: [&str; 8] =
    ["sealed", "coated", "varnished", "lacquered", "painted", "baked", "anodised", "anodized"];

fn words(text: &str) -> Vec<String> {
    let text = text.to_lowercase();
    let words = text.split(|c: char| !(c.is_alphanumeric() || c == '-'));
    words.filter(|word| !word.is_empty()).map(str::to_owned).collect()
}

/// Whether it is told to be light or dark by its name; what is both, or neither, is not told.
fn is_dark(words: &[String]) -> Option<bool> {
    let says = |known: &[&str]| words.iter().any(|word| known.contains(&&**word));
    match (says(&["black", "dark"]), says(&["white", "aluminium", "silver", "yellow"])) {
        (true, false) => Some(true),
        (false, true) => Some(false),
        _ => None,
    }
}

/// What a body that is not cast from a known material is made from.
pub(super) fn substance(body: &Body) -> Substance {
    let text = if body.material.is_empty() { &body.summary } else { &body.material };
    let words = words(text);
    let says = |known: &[&str]| words.iter().any(|word| known.contains(&&**word));
    let Some(stock) = STOCK.iter().find(|stock| says(stock.words)) else {
        return Substance { is_dark: is_dark(&words), ..Substance::default() };
    };
    let is_sealed = says(&SEALED) && !says(&BARE);
    Substance {
        sort: Some(stock.sort),
        inhibits: if stock.inhibits && !is_sealed { vec![Curing::Platinum] } else { Vec::new() },
        shore: Some(stock.shore),
        tears_mpa: Some(stock.bears_mpa),
        is_dark: is_dark(&words),
        refractive_index: stock.refractive_index,
        softens: softens(&words),
        elasticity: elasticity::of_shore(stock.sort, stock.shore),
        ..Substance::default()
    }
}

/// Whether a name says that its stuff is left bare, whatever a step does to it.
pub(super) fn is_bare(material: &str) -> bool {
    words(material).iter().any(|word| BARE.contains(&&**word))
}

/// What a layer of a known material is.
pub(super) fn of_castable(castable: &Castable) -> Substance {
    let figures = &castable.material().figures;
    let cures = figures.cures.map(curing);
    let sort = match figures.kind {
        Some(MaterialKind::Silicone | MaterialKind::Gel) => Some(Sort::Silicone),
        Some(MaterialKind::Polyurethane) => Some(Sort::Rubber),
        _ => matches!(cures, Some(Curing::Platinum | Curing::Tin | Curing::Moisture))
            .then_some(Sort::Silicone),
    };
    // Traces of the other catalyst, amines, and what light has left over poison platinum.
    let poisons = matches!(cures, Some(Curing::Tin | Curing::Epoxy | Curing::Light));
    Substance {
        sort,
        cures,
        inhibits: if poisons { vec![Curing::Platinum] } else { Vec::new() },
        shore: figures.hardness.map(shore),
        tears_mpa: figures.strength.map(|Pressure(kpa)| kpa / 1e3),
        viscosity_pa_s: figures.viscosity.map(|Viscosity(pa_s)| pa_s),
        is_dark: is_dark(&words(castable)),
        refractive_index: figures.refractive_index,
        softens: None,
        elasticity: elasticity::of_castable(castable.material(), sort),
    }
}

pub(super) fn shore(Hardness { scale, value }: Hardness) -> Shore {
    match scale {
        Scale::Shore00 => Shore::OO(value),
        Scale::ShoreA => Shore::A(value),
        Scale::ShoreD => Shore::D(value),
    }
}

fn curing(by: CuresBy) -> Curing {
    match by {
        CuresBy::Platinum => Curing::Platinum,
        CuresBy::Tin => Curing::Tin,
        CuresBy::Moisture => Curing::Moisture,
        CuresBy::Polyurethane => Curing::Polyurethane,
        CuresBy::Epoxy => Curing::Epoxy,
        CuresBy::Light => Curing::Light,
        CuresBy::Drying => Curing::Drying,
    }
}
