//! Stock and bought things that are not cast: their properties, by words of the trade name.

use std::sync::LazyLock;

use fabkit_geometry::{
    Body, CureMechanism, MaterialClass, MaterialProperties, Shore, SofteningPoint,
};
use fabkit_text::{Dialect, Section, TextLayer, TextPlace, read_mapping, take_format};

use super::{
    Castable, Celsius, CuresBy, Hardness, MaterialKind, Pressure, Scale, Viscosity, elasticity,
};
use crate::sections;
use crate::user_catalogue::named_sections::{SectionKind, read, read_sections};

sections! {
    /// Properties of materials whose trade name contains one of a few words.
    pub struct StockMaterial {
        /// Words of trade names, in lower case.
        words: Vec<String> = (1..=32, 1..=40),
        /// Class of material, as in the tables: `rubber`, `resin`, `metal` and so on.
        sort: String = 1..=20,
        /// Hardness of the softest variety in use.
        hardness: Hardness,
        /// Minimum stress at which the material fails.
        strength: Pressure = 0.0..=10000000.0,
        /// True if the bare material inhibits the cure of platinum silicone; false if not given.
        inhibits_platinum: Option<bool>,
        /// Refractive index in the middle of the visible spectrum, for materials that are looked through.
        refractive_index: Option<f64> = 1.0..=3.0,
    }

    /// Softening temperature of materials whose trade name contains one of a few words.
    pub struct Softening {
        /// Words of trade names, in lower case.
        words: Vec<String> = (1..=32, 1..=40),
        /// Softening temperature; for families of plastics the lowest among common makes.
        softens: Celsius = 0.0..=2000.0,
        /// Source of the temperature, with its test method.
        by: String = 1..=300,
    }
}

/// Built-in tables of stock; the first row with a matching word counts.
struct StockTables {
    stock: Vec<(StockMaterial, MaterialClass)>,
    softenings: Vec<Softening>,
}

/// Tables of the built-in file.
static STOCK_TABLES: LazyLock<StockTables> = LazyLock::new(|| {
    let stock: Vec<StockMaterial> = rows("stock");
    let sorted = |stuff: StockMaterial| {
        let sort = SORTS.into_iter().find(|sort| sort.word() == stuff.sort);
        sort.map(|sort| (stuff, sort))
    };
    StockTables {
        stock: stock.into_iter().filter_map(sorted).collect(),
        softenings: rows("softening"),
    }
});

/// All sorts that a row may name.
const SORTS: [MaterialClass; 10] = [
    MaterialClass::Silicone,
    MaterialClass::Rubber,
    MaterialClass::Liquid,
    MaterialClass::Plastic,
    MaterialClass::Resin,
    MaterialClass::Acrylic,
    MaterialClass::Glass,
    MaterialClass::Wood,
    MaterialClass::Metal,
    MaterialClass::Laminate,
];

/// Reads the rows below a key of the built-in file, in order.
fn rows<S: Section>(key: &'static str) -> Vec<S> {
    static FILE: Dialect = Dialect::new("file of stock", 1, "");
    let noun = SectionKind { key, dialect: &FILE };
    let place = TextPlace::new(TextLayer::Base, "stock.yaml (built-in)", &FILE);
    let mut found = Vec::new();
    let mut entries =
        read_mapping(include_str!("../../stock.yaml"), &place, &mut found).unwrap_or_default();
    take_format(&mut entries, &place, &mut found);
    let mut rows = Vec::new();
    for entry in entries.into_iter().filter(|entry| entry.key == key) {
        for raw in read_sections(noun, entry, &place, &mut found) {
            let stack = vec![(raw.place.clone(), raw.entries)];
            rows.extend(read::<S>(noun, &raw.name, &raw.place, stack, &mut found));
        }
    }
    debug_assert!(found.is_empty(), "{found:#?}");
    rows.into_iter().map(|(row, _)| row).collect()
}

/// Returns the softening temperature of a material by the words of its name.
fn softens(words: &[String]) -> Option<SofteningPoint> {
    let says = |row: &&Softening| words.iter().any(|word| row.words.contains(word));
    let found = STOCK_TABLES.softenings.iter().find(says);
    found.map(|row| SofteningPoint { celsius: row.softens.0, source: &row.by })
}

/// Words for an untreated surface.
const BARE: [&str; 4] = ["bare", "uncoated", "unsealed", "untreated"];

/// Words for a sealed surface.
const SEALED: [&str; 8] =
    ["sealed", "coated", "varnished", "lacquered", "painted", "baked", "anodised", "anodized"];

/// Splits a name into words in lower case.
fn words(text: &str) -> Vec<String> {
    let text = text.to_lowercase();
    let words = text.split(|c: char| !(c.is_alphanumeric() || c == '-'));
    words.filter(|word| !word.is_empty()).map(str::to_owned).collect()
}

/// Returns whether a name says that the material is dark (`true`) or light (`false`); `None` if it says both or
/// neither.
fn is_dark(words: &[String]) -> Option<bool> {
    let says = |known: &[&str]| words.iter().any(|word| known.contains(&&**word));
    match (says(&["black", "dark"]), says(&["white", "aluminium", "silver", "yellow"])) {
        (true, false) => Some(true),
        (false, true) => Some(false),
        _ => None,
    }
}

/// Returns the properties of a body that is not cast from a material of the catalogue.
pub(super) fn substance_from_name(body: &Body) -> MaterialProperties {
    let text = if body.material.is_empty() { &body.summary } else { &body.material };
    let words = words(text);
    let says = |known: &[&str]| words.iter().any(|word| known.contains(&&**word));
    let fits = |(stuff, _): &&(StockMaterial, MaterialClass)| {
        words.iter().any(|word| stuff.words.contains(word))
    };
    let Some((stuff, sort)) = STOCK_TABLES.stock.iter().find(fits) else {
        return MaterialProperties { is_dark: is_dark(&words), ..MaterialProperties::default() };
    };
    // Words such as `uncoated` outweigh a sealing word in the same name.
    let is_sealed = says(&SEALED) && !says(&BARE);
    let inhibits = stuff.inhibits_platinum == Some(true) && !is_sealed;
    let shore = shore(stuff.hardness);
    MaterialProperties {
        class: Some(*sort),
        inhibited_cures: if inhibits { vec![CureMechanism::Platinum] } else { Vec::new() },
        shore: Some(shore),
        tear_strength_mpa: Some(stuff.strength.0 / 1e3),
        is_dark: is_dark(&words),
        refractive_index: stuff.refractive_index,
        softening_point: softens(&words),
        elasticity: elasticity::elasticity_from_shore(*sort, shore),
        ..MaterialProperties::default()
    }
}

/// Returns whether a name says that the material is left bare, whatever a step does to it.
pub(super) fn is_bare(material: &str) -> bool {
    words(material).iter().any(|word| BARE.contains(&&**word))
}

/// Returns the properties of a layer that is cast from a material of the catalogue.
pub(super) fn substance_from_castable(castable: &Castable) -> MaterialProperties {
    let figures = &castable.material().figures;
    let cures = figures.cures.map(curing);
    let sort = match figures.kind {
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
        matches!(cures, Some(CureMechanism::Tin | CureMechanism::Epoxy | CureMechanism::Light));
    MaterialProperties {
        class: sort,
        cure_mechanism: cures,
        inhibited_cures: if poisons { vec![CureMechanism::Platinum] } else { Vec::new() },
        shore: figures.hardness.map(shore),
        tear_strength_mpa: figures.strength.map(|Pressure(kpa)| kpa / 1e3),
        viscosity_pa_s: figures.viscosity.map(|Viscosity(pa_s)| pa_s),
        is_dark: is_dark(&words(castable)),
        refractive_index: figures.refractive_index,
        softening_point: None,
        elasticity: elasticity::elasticity_from_castable(castable.material(), sort),
    }
}

/// Converts a hardness to the type of the geometry crate.
pub(super) fn shore(Hardness { scale, value }: Hardness) -> Shore {
    match scale {
        Scale::Shore00 => Shore::OO(value),
        Scale::ShoreA => Shore::A(value),
        Scale::ShoreD => Shore::D(value),
    }
}

/// Converts a curing mechanism to the type of the geometry crate.
fn curing(by: CuresBy) -> CureMechanism {
    match by {
        CuresBy::Platinum => CureMechanism::Platinum,
        CuresBy::Tin => CureMechanism::Tin,
        CuresBy::Moisture => CureMechanism::Moisture,
        CuresBy::Polyurethane => CureMechanism::Polyurethane,
        CuresBy::Epoxy => CureMechanism::Epoxy,
        CuresBy::Light => CureMechanism::Light,
        CuresBy::Drying => CureMechanism::Drying,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_is_read_and_a_first_word_counts() {
        let rows = include_str!("../../stock.yaml").matches(" {words: [").count();
        assert_eq!(STOCK_TABLES.stock.len() + STOCK_TABLES.softenings.len(), rows);
        let of = |material: &str| {
            let solid = fabkit_geometry::Solid::cuboid(1.0, 1.0, 1.0);
            let process = fabkit_geometry::Process::Fdm;
            substance_from_name(&Body::made("part", "", process, solid).with_material(material))
        };
        let petg = of("black PETG");
        assert_eq!(
            (petg.class, petg.tear_strength_mpa),
            (Some(MaterialClass::Plastic), Some(15.0))
        );
        assert_eq!(petg.softening_point.map(|softens| softens.celsius), Some(68.0));
        assert_eq!(of("varnished plywood").inhibited_cures, []);
        assert_eq!(of("plywood").inhibited_cures, [CureMechanism::Platinum]);
    }
}
