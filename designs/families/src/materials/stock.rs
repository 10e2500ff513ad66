//! Catalogue of what parts are printed, cut or milled from and what bought parts are made of, by exact name.

use std::collections::BTreeMap;
use std::sync::{Arc, LazyLock};

use fabkit_geometry::{
    Body, BodyKind, CureMechanism, Length, MaterialClass, MaterialProperties, OpticalClarity,
    OpticalFigure, OpticalProperties, Process, SofteningPoint,
};
use fabkit_text::{LocatedProblem, Setting};

use super::catalogue::MATERIALS;
use super::qualifiers::{
    Qualities, Shade, SurfaceTreatment, explain, has_meaning, is_explained, words,
};
use super::stock_file::{BUILTIN_FILE, DIALECT, read_builtin};
use super::{
    Celsius, Clarity, Density, Hardness, Percent, Pressure, PriceByMass, Reflectance, Viscosity,
    elasticity, optics, shore,
};
use crate::user_catalogue::named_sections::{
    LayeredSections, RawSection, SectionKind, key_of, read,
};
use crate::{choices, sections};

choices! {
    /// Class of a material that is not cast.
    pub enum StockClass {
        /// Silicone rubber, as tubes and sheets.
        Silicone = "silicone",
        /// Other rubber.
        Rubber = "rubber",
        /// Liquid that does not cure.
        Liquid = "liquid",
        /// Thermoplastic.
        Plastic = "plastic",
        /// Resin cured by light.
        Resin = "resin",
        /// Acrylic glass.
        Acrylic = "acrylic",
        /// Glass.
        Glass = "glass",
        /// Wood, plywood, paper.
        Wood = "wood",
        /// Metal.
        Metal = "metal",
        /// Laminate of glass fibre and epoxy.
        Laminate = "laminate",
    }
}

impl StockClass {
    /// Returns the class in the geometry crate.
    fn class(self) -> MaterialClass {
        match self {
            Self::Silicone => MaterialClass::Silicone,
            Self::Rubber => MaterialClass::Rubber,
            Self::Liquid => MaterialClass::Liquid,
            Self::Plastic => MaterialClass::Plastic,
            Self::Resin => MaterialClass::Resin,
            Self::Acrylic => MaterialClass::Acrylic,
            Self::Glass => MaterialClass::Glass,
            Self::Wood => MaterialClass::Wood,
            Self::Metal => MaterialClass::Metal,
            Self::Laminate => MaterialClass::Laminate,
        }
    }
}

sections! {
    /// Properties of a material that parts are printed, cut or milled from. Unknown properties are left out.
    pub struct StockMaterial {
        /// Class of material: `plastic`, `resin`, `rubber`, `acrylic`, `glass`, `metal` and so on.
        sort: StockClass,
        /// Other names of the same material, with commas between them.
        also: Option<String> = 1..=400,
        /// Hardness, of the softest variety in use.
        hardness: Option<Hardness>,
        /// Minimum stress at which the material fails.
        strength: Option<Pressure> = 0.0..=10000000.0,
        /// Whether the bare material keeps platinum silicone from curing.
        inhibits_platinum: Option<bool>,
        /// Refractive index in the middle of the visible spectrum.
        refractive_index: Option<f64> = 1.0..=3.0,
        /// Viscosity, of liquids.
        viscosity: Option<Viscosity> = 0.0001..=10000.0,
        /// Transparency of the material without pigment.
        clarity: Option<Clarity>,
        /// Brightness, where the name of the material decides it.
        shade: Option<Shade>,
        /// Diffuse reflectance: one percentage, or three of red, green and blue light.
        reflectance: Option<Reflectance> = 0.0..=100.0,
        /// Share of the light that passes a sheet or a print of it as diffusers have, scattered or not.
        transmission: Option<Percent> = 0.0..=100.0,
        /// Softening temperature.
        softens: Option<Celsius> = 0.0..=2000.0,
        /// Density of the solid material.
        density: Option<Density> = 0.05..=25.0,
        /// Rough price of small amounts, to compare designs.
        price: Option<PriceByMass> = 0.0..=100000.0,
        /// True for filament that lifts its corners off the bed while it cools, so that it gets a brim.
        warps: Option<bool>,
        /// Width that a laser's beam removes; 0.2 mm if not given.
        kerf: Option<Length> = 0.0..=1.0,
        /// Source of these data.
        source: Option<String> = 0..=500,
        /// Advice on using the material.
        note: Option<String> = 0..=500,
    }
}

const STOCK: SectionKind = SectionKind { key: "stock", dialect: &DIALECT };

/// Entries of the built-in file.
static BUILTIN: LazyLock<StockCatalogue> = LazyLock::new(|| {
    let mut found = Vec::new();
    let catalogue = StockCatalogue::from_sections(read_builtin(STOCK, &mut found), &mut found);
    debug_assert!(found.is_empty(), "{found:#?}");
    catalogue
});

/// A material of the catalogue with the name under which messages know it.
#[derive(Clone, Debug, PartialEq)]
struct StockEntry {
    name: String,
    material: StockMaterial,
    optics: OpticalProperties,
    /// Values that a file states, with their sources; empty for built-in entries.
    settings: Vec<Setting>,
}

/// All materials that parts may be printed, cut or milled from.
#[derive(Clone, Debug)]
pub(crate) struct StockCatalogue {
    raws: Arc<Vec<RawSection>>,
    /// Entries by [`key_of`] their names and of `also`.
    by_key: Arc<BTreeMap<String, StockEntry>>,
}

/// What the name of a material says, as written for a part: `clear PMMA, frosted on both sides`.
#[derive(Clone, Debug, Default, PartialEq)]
struct StockName<'a> {
    /// Entry of the catalogue; `None` if no entry has this name.
    entry: Option<&'a StockEntry>,
    /// What the words beside the entry's name say.
    beside: Qualities,
}

impl StockCatalogue {
    /// Returns the materials that fabkit comes with.
    pub fn builtin() -> &'static Self {
        &BUILTIN
    }

    /// Returns the materials with the entries of files added; later entries override earlier ones.
    pub fn with(&self, own: Vec<RawSection>, found: &mut Vec<LocatedProblem>) -> Self {
        if own.is_empty() {
            return self.clone();
        }
        Self::from_sections(self.raws.iter().cloned().chain(own).collect(), found)
    }

    fn from_sections(raws: Vec<RawSection>, found: &mut Vec<LocatedProblem>) -> Self {
        let layered = LayeredSections::new(&raws);
        let mut by_key = BTreeMap::new();
        for (key, said) in layered.iter() {
            let (Some(first), Some(last)) = (said.first(), said.last()) else { continue };
            let Some(mut stack) = layered.stack(STOCK, key, found) else { continue };
            // Another name of the base is no name of what extends it.
            let own = said.len();
            let bases = stack.len().saturating_sub(own);
            for (_, entries) in &mut stack[..bases] {
                entries.retain(|entry| entry.key != "also");
            }
            let name = first.name.clone();
            let read = read::<StockMaterial>(MATERIALS, &name, &last.place, stack, found);
            let Some((material, mut settings)) = read else { continue };
            let source = material.source.as_deref();
            let optics = optics::optics_of_row(
                material.reflectance,
                material.transmission,
                &settings,
                source,
            );
            settings.retain(|setting| {
                let is_text = setting.path.ends_with(".source") || setting.path.ends_with(".note");
                &*last.place.file != BUILTIN_FILE && !setting.is_default && !is_text
            });
            let others = items(material.also.as_deref()).map(key_of);
            let keys: Vec<String> = others.chain([key.clone()]).collect();
            for key in keys {
                let entry = StockEntry {
                    name: name.clone(),
                    material: material.clone(),
                    optics: optics.clone(),
                    settings: settings.clone(),
                };
                by_key.insert(key, entry);
            }
        }
        Self { raws: Arc::new(raws), by_key: Arc::new(by_key) }
    }

    /// Splits the sections of `materials:` into those about materials of this kind, which say `sort`, change an entry, or
    /// extend one, and those about what is cast.
    pub fn split(&self, sections: Vec<RawSection>) -> (Vec<RawSection>, Vec<RawSection>) {
        let mut extending: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        let mut first: BTreeMap<String, usize> = BTreeMap::new();
        let mut is_stock = vec![false; sections.len()];
        let mut next = Vec::new();
        for (i, section) in sections.iter().enumerate() {
            let (key, base) = (key_of(&section.name), section.base());
            let is_entry = |key: &String| self.by_key.contains_key(key);
            let says_sort = section.entries.iter().any(|entry| entry.key == "sort");
            if says_sort || is_entry(&key) || base.as_ref().is_some_and(is_entry) {
                next.push(i);
            } else if let Some(base) = base {
                extending.entry(base).or_default().push(i);
            }
            first.entry(key).or_insert(i);
        }
        // What extends a name extends the first section of that name.
        while let Some(i) = next.pop() {
            let key = key_of(&sections[i].name);
            if !std::mem::replace(&mut is_stock[i], true) && first.get(&key) == Some(&i) {
                next.extend(extending.remove(&key).into_iter().flatten());
            }
        }
        let (stock, cast): (Vec<_>, Vec<_>) =
            sections.into_iter().zip(is_stock).partition(|(_, is_stock)| *is_stock);
        let sections = |pairs: Vec<(RawSection, bool)>| pairs.into_iter().map(|(one, _)| one);
        (sections(stock).collect(), sections(cast).collect())
    }

    /// Finds the entry that a name means, and the words beside it, each of which a table explains. With any other word it
    /// is another material, of which nothing is known.
    fn find_entry(&self, text: &str) -> Option<(&StockEntry, Vec<String>)> {
        if let Some(entry) = self.by_key.get(&key_of(text)) {
            return Some((entry, Vec::new()));
        }
        let words = words(text);
        // The longest run of words that is a name, and the first of these.
        (1..=words.len()).rev().find_map(|length| {
            (0..=words.len() - length).find_map(|from| {
                let to = from + length;
                let entry = self.by_key.get(&words[from..to].join(" "))?;
                let beside = [&words[..from], &words[to..]].concat();
                beside.iter().all(|word| is_explained(word)).then_some((entry, beside))
            })
        })
    }

    /// Reads the name of a material. A colour of an unknown material is a colour nevertheless.
    fn read_name(&self, text: &str) -> StockName<'_> {
        match self.find_entry(text) {
            Some((entry, words)) => StockName { entry: Some(entry), beside: explain(&words) },
            None => StockName { entry: None, beside: explain(&words(text)) },
        }
    }

    /// Returns the material of a body that is not cast: what it is called, or what a bought body is made of.
    fn name_of_body(&self, body: &Body) -> StockName<'_> {
        match body.stock {
            Some(stock) if body.material.is_empty() => self.read_name(stock),
            _ => self.read_name(&body.material),
        }
    }

    /// Returns the properties of a body that is not cast from a material of the catalogue.
    pub fn properties(&self, body: &Body) -> MaterialProperties {
        let name = self.name_of_body(body);
        let is_dark = name.beside.shade.map(|shade| shade == Shade::Dark);
        // A resin printer prints resin, whatever its maker calls it.
        let is_resin = matches!(body.kind, BodyKind::Made(Process::Sla | Process::PolyJet));
        let is_sealed = name.beside.surface == Some(SurfaceTreatment::Sealed);
        let inhibited = |inhibits: bool| {
            if inhibits && !is_sealed { vec![CureMechanism::Platinum] } else { Vec::new() }
        };
        let Some(StockEntry { material, .. }) = name.entry else {
            return MaterialProperties {
                class: is_resin.then_some(MaterialClass::Resin),
                inhibited_cures: is_resin.then(|| inhibited(true)),
                is_dark,
                optics: name.beside.optics,
                ..MaterialProperties::default()
            };
        };
        let optics = name.combined_optics();
        let class = material.sort.class();
        let shore = material.hardness.map(shore);
        MaterialProperties {
            class: Some(class),
            inhibited_cures: if is_sealed {
                Some(Vec::new())
            } else {
                // Resin that a process cures by light inhibits, even if its entry was written for another process.
                material.inhibits_platinum.or(is_resin.then_some(true)).map(inhibited)
            },
            shore,
            tear_strength_mpa: material.strength.map(|Pressure(kpa)| kpa / 1e3),
            viscosity_pa_s: material.viscosity.map(|Viscosity(pa_s)| pa_s),
            is_dark: is_dark.or(material.shade.map(|shade| shade == Shade::Dark)),
            refractive_index: material.refractive_index,
            softening_point: material.softens.map(|Celsius(celsius)| SofteningPoint {
                celsius,
                source: material.source.clone().unwrap_or_default(),
            }),
            elasticity: shore.and_then(|shore| elasticity::elasticity_from_shore(class, shore)),
            density_g_per_cm3: material.density.map(|Density(g_per_cm3)| g_per_cm3),
            usd_per_kg: material.price.map(|PriceByMass(usd_per_kg)| usd_per_kg),
            laser_kerf_mm: material.kerf.map(Length::mm),
            warps: material.warps,
            optics,
            ..MaterialProperties::default()
        }
    }

    /// Returns what files state of the materials of these bodies, as further parameters that the design depends on.
    pub fn settings(&self, bodies: &[Body]) -> Vec<Setting> {
        let entries = bodies.iter().filter_map(|body| self.name_of_body(body).entry);
        let by_name: BTreeMap<&str, &StockEntry> =
            entries.map(|entry| (&*entry.name, entry)).collect();
        by_name.into_values().flat_map(|entry| entry.settings.clone()).collect()
    }

    /// Returns whether the name of a body's material says that it is left bare, whatever a step does to it.
    pub fn is_bare(&self, body: &Body) -> bool {
        self.name_of_body(body).beside.surface == Some(SurfaceTreatment::Bare)
    }

    /// Returns the transparency of a window cut from a sheet or made of resin: that of the words beside its material's
    /// name, else the material's own. `None` if neither is known.
    pub fn window_transparency(&self, material: &str) -> Option<OpticalClarity> {
        let name = self.read_name(material);
        // Frost scatters whatever colour is named beside it, and a pigment is named beside a clear material.
        name.beside.clarity.or_else(|| name.entry?.material.clarity).map(Clarity::optical)
    }

    /// Returns the transparency of a thin part that spreads light: opaque if its material passes none, clear if it is cut
    /// from a clear sheet, else translucent: prints scatter, and so does white pigment. `None` for a sheet of a material
    /// that nobody describes.
    pub fn diffuser_transparency(&self, body: &Body) -> Option<OpticalClarity> {
        let name = self.name_of_body(body);
        if let Some(OpticalFigure { value: 0.0, .. }) = name.combined_optics().transmission {
            return Some(OpticalClarity::Opaque);
        }
        if matches!(body.kind, BodyKind::Made(Process::Fdm | Process::Sla | Process::PolyJet)) {
            return Some(OpticalClarity::Translucent);
        }
        match name.beside.clarity.or_else(|| name.entry?.material.clarity)? {
            Clarity::Clear => Some(OpticalClarity::Clear),
            _ => Some(OpticalClarity::Translucent),
        }
    }

    /// Returns the transparency of a printed part whose material is called clear or translucent: translucent, because
    /// print layers scatter light. `None` if the name does not suggest that light passes.
    pub fn print_transparency(&self, body: &Body) -> Option<OpticalClarity> {
        let name = self.name_of_body(body);
        let own = || name.entry.filter(|_| name.beside.shade.is_none())?.material.clarity;
        let passes = |clarity: &Clarity| *clarity != Clarity::Opaque;
        let is_painted = name.beside.surface == Some(SurfaceTreatment::Sealed);
        let of_words =
            name.beside.clarity.or_else(|| own().filter(|clarity| *clarity == Clarity::Clear));
        of_words.filter(passes).filter(|_| !is_painted).map(|_| OpticalClarity::Translucent)
    }

    /// Returns the brightness of a material: that of the words beside its name, else its own.
    pub fn shade(&self, material: &str) -> Option<Shade> {
        let name = self.read_name(material);
        name.beside.shade.or_else(|| name.entry?.material.shade)
    }

    /// Returns whether `to`, a key of `bonds`, means the material of a body: its class, its entry by any name, or the
    /// material as the body names it.
    pub fn is_called(&self, to: &str, body: &Body) -> bool {
        let name = self.name_of_body(body);
        let is_entry = name.entry.is_some_and(|entry| {
            entry.material.sort.word() == key_of(to)
                || self.by_key.get(&key_of(to)).is_some_and(|other| other.name == entry.name)
        });
        is_entry || (!body.material.is_empty() && key_of(&body.material) == key_of(to))
    }

    /// Returns which material a name means, as the name of its entry, and the colours and finishes beside it, in order. A
    /// name that no entry has stands for itself, without these words.
    pub fn identity(&self, text: &str) -> (String, Vec<String>) {
        let (name, mut beside) = match self.find_entry(text) {
            Some((entry, beside)) => (entry.name.clone(), beside),
            None => {
                let is_beside = |word: &String| is_explained(word);
                let (beside, own): (Vec<_>, Vec<_>) = words(text).into_iter().partition(is_beside);
                // A material that is named by its colour alone keeps it.
                if own.is_empty() { (beside.join(" "), own) } else { (own.join(" "), beside) }
            }
        };
        beside.retain(|word| has_meaning(word));
        beside.sort_unstable();
        (name, beside)
    }

    /// Returns whether `asked`, a material with or without colours and finishes, is what `material` names: the same
    /// material, with at least these words beside it.
    pub fn means(&self, asked: &str, material: &str) -> bool {
        let ((name, asked), (other, words)) = (self.identity(asked), self.identity(material));
        name == other && asked.iter().all(|word| words.contains(word))
    }
}

impl StockName<'_> {
    /// Returns the optics that the words state, and for the rest those of the entry.
    fn combined_optics(&self) -> OpticalProperties {
        let figures = self.entry.map(|entry| &entry.material);
        let shade = self.beside.shade.or(figures.and_then(|figures| figures.shade));
        let clarity = self.beside.clarity.or(figures.and_then(|figures| figures.clarity));
        let entry = self.entry.map(|entry| entry.optics.clone()).unwrap_or_default();
        optics::combined_optics((&self.beside.optics, self.beside.clarity), entry, (shade, clarity))
    }
}

/// Splits a list with commas.
fn items(list: Option<&str>) -> impl Iterator<Item = &str> {
    list.into_iter().flat_map(|list| list.split(',')).map(str::trim)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::materials::qualifiers;
    use fabkit_geometry::Solid;

    fn body(process: Process, material: &str) -> Body {
        Body::made("part", "", process, Solid::cuboid(1.0, 1.0, 1.0)).with_material(material)
    }

    fn properties(process: Process, material: &str) -> MaterialProperties {
        StockCatalogue::builtin().properties(&body(process, material))
    }

    #[test]
    fn every_row_is_read() {
        let text = include_str!("../../stock.yaml");
        let rows = text.lines().filter(|line| line.starts_with("  ") && line.contains(": {"));
        assert_eq!(
            StockCatalogue::builtin().raws.len() + qualifiers::row_count(),
            rows.filter(|line| !line.trim_start().starts_with('#')).count()
        );
        for (key, entry) in StockCatalogue::builtin().by_key.iter() {
            assert!(entry.material.source.is_some(), "{key} states no source");
        }
    }

    #[test]
    fn the_book_lists_every_entry() {
        let book = include_str!("../../../../docs/reference/own.md");
        for entry in StockCatalogue::builtin().by_key.values() {
            assert!(book.contains(&format!("\n| {} |", entry.name)), "{}", entry.name);
        }
    }

    #[test]
    fn colours_and_finishes_beside_a_name_are_explained() {
        let petg = properties(Process::Fdm, "black PETG");
        assert_eq!(petg.class, Some(MaterialClass::Plastic));
        assert_eq!((petg.tear_strength_mpa, petg.is_dark), (Some(15.0), Some(true)));
        assert_eq!(petg.softening_point.map(|softens| softens.celsius), Some(68.0));
        let inhibits = |material| properties(Process::Laser, material).inhibited_cures;
        assert_eq!(inhibits("varnished plywood"), Some(vec![]));
        assert_eq!(inhibits("plywood"), Some(vec![CureMechanism::Platinum]));
        assert_eq!(inhibits("uncoated, varnished plywood"), Some(vec![CureMechanism::Platinum]));
        let window = |material| StockCatalogue::builtin().window_transparency(material);
        assert_eq!(window("clear PMMA"), Some(OpticalClarity::Clear));
        assert_eq!(window("acrylic frosted on both sides"), Some(OpticalClarity::Translucent));
        assert_eq!(window("black acrylic, frosted"), Some(OpticalClarity::Opaque));
        assert_eq!(window("unobtainium"), None);
    }

    #[test]
    fn a_colour_counts_beside_a_name_that_no_entry_has() {
        let stock = StockCatalogue::builtin();
        assert!(stock.shade("black unobtainium").is_some_and(|shade| shade == Shade::Dark));
        assert!(
            stock.window_transparency("frosted unobtainium") == Some(OpticalClarity::Translucent)
        );
        assert!(
            stock.shade("unobtainium").is_none()
                && stock.window_transparency("unobtainium").is_none()
        );
    }

    #[test]
    fn a_name_that_no_entry_has_is_not_known_by_its_words() {
        for unknown in ["Siraya Tech Blu", "PLA Turbo 3000", "Delrun"] {
            let properties = properties(Process::Fdm, unknown);
            assert_eq!(properties, MaterialProperties::default(), "{unknown}");
        }
        // The process says that it is resin; resin cured by light inhibits.
        let blu = properties(Process::Sla, "Siraya Tech Blu");
        assert_eq!(blu.class, Some(MaterialClass::Resin));
        assert_eq!(blu.inhibited_cures, Some(vec![CureMechanism::Platinum]));
        assert_eq!((blu.shore, blu.tear_strength_mpa), (None, None));
    }
}
