//! User-defined materials, processes and articles, from a sensor's file or from a file for all sensors.

pub(crate) mod named_sections;
mod reader_context;
mod schema;

use fabkit_text::{
    Dialect, LocatedProblem, OVERRIDE_FILE_NAME, Setting, TextLayer, TextPlace, YamlEntry,
    read_mapping, suggestion, take_format, to_printable,
};

use crate::articles::{Articles, BUYING};
use crate::materials::{Castable, Catalogue, MATERIALS, StockCatalogue};
use crate::processes::{PARTS, PROCESSES, Processes};

use named_sections::{RawSection, SectionKind, read_sections};
pub(crate) use reader_context::ReaderContext;
pub(crate) use schema::add_to_schema;

/// User's file for all sensors: materials, processes and articles to buy.
///
/// ```
/// use fabkit_designs::{SensorText, UserFile, unit_dimensions::build_unit};
/// let text = "
/// format: 1
/// materials:
///   My silicone: {extends: Smooth-On Ecoflex 00-30, density: 1.1 g/cm3}
/// ";
/// let user = UserFile { file: "materials.yaml".into(), text: text.into() };
/// let yaml = "format: 1\nextends: rtac0\ntranslucent_gel: {material: My silicone}\n";
/// let text = SensorText { user: Some(&user), ..SensorText::without_bases("mine.yaml", yaml) };
/// let (design, _) = build_unit(text, &[], &["fixtures"], &|_| 0.0)?;
/// assert!(design.materials.iter().any(|one| one.mix().density_g_per_cm3 == 1.1));
/// # Ok::<(), fabkit_designs::parameters::InvalidDesign>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UserFile {
    /// Name of the file in messages.
    pub file: String,
    /// YAML text of the file.
    pub text: String,
}

/// Dialect of the user's file.
const USER: Dialect = Dialect::new("materials", 1, ", then `materials:`, `processes:` or `buy:`");

/// Top-level keys of the user's file.
const USER_KEYS: [&str; 3] = [MATERIALS.key, PROCESSES.key, BUYING.key];

/// Catalogues that result from the built-in entries and those of files.
#[derive(Clone, Debug)]
pub(crate) struct UserCatalogue {
    /// All materials that may be cast.
    pub materials: Catalogue,
    /// All materials that parts are printed, cut or milled from.
    pub stock: StockCatalogue,
    /// Processes, and their assignment to parts.
    pub processes: Processes,
    /// All articles that may be bought.
    pub articles: Articles,
}

impl UserCatalogue {
    /// Removes the user's sections from the layers of a sensor, of which the sensor's own file is the first, and
    /// reports their problems.
    pub fn take_from_layers(
        layers: &mut [(TextPlace, Vec<YamlEntry>)],
        user: Option<&UserFile>,
        found: &mut Vec<LocatedProblem>,
    ) -> Self {
        let (mut materials, mut processes, mut parts) = (Vec::new(), Vec::new(), Vec::new());
        let mut buying = Vec::new();
        if let Some((place, mut entries)) = user_entries(user, found) {
            take_raws(MATERIALS, &mut entries, &place, &mut materials, found);
            take_raws(PROCESSES, &mut entries, &place, &mut processes, found);
            take_raws(BUYING, &mut entries, &place, &mut buying, found);
        }
        // From the farthest base to the sensor's own file, which overrides all others.
        for (place, entries) in layers.iter_mut().rev() {
            take_raws(MATERIALS, entries, place, &mut materials, found);
            take_raws(PROCESSES, entries, place, &mut processes, found);
            take_raws(BUYING, entries, place, &mut buying, found);
            if let Some(at) = entries.iter().position(|entry| entry.key == PARTS) {
                parts.push((place.clone(), entries.remove(at)));
            }
        }
        let builtin = StockCatalogue::builtin();
        let (stock, materials) = builtin.split(materials);
        let materials = Catalogue::builtin().with(materials, found);
        let stock = builtin.with(stock, found);
        Self {
            materials,
            processes: Processes::read(processes, parts, found),
            articles: Articles::builtin().with(buying, &stock, found),
            stock,
        }
    }

    /// Removes the assignments to parts, which begin with `parts.`, from the overrides of the command line. Returns the
    /// other overrides.
    pub fn take_overrides(
        &mut self,
        overrides: &[String],
        found: &mut Vec<LocatedProblem>,
    ) -> Vec<String> {
        let place = TextPlace::new(TextLayer::Override, OVERRIDE_FILE_NAME, &USER);
        let mut rest = overrides.to_vec();
        rest.retain(|text| !self.processes.take_override(text, &place, found));
        rest
    }

    /// Returns the context that parameters are read with.
    pub fn known(&self) -> ReaderContext {
        ReaderContext { materials: self.materials.clone(), making: self.processes.to_assignments() }
    }

    /// Returns all figures of used materials and processes that are not built in, as further parameters, because the
    /// parts depend on them. `parts` are the names of the made parts.
    pub fn settings(&self, materials: &[Castable], parts: &[String]) -> Vec<Setting> {
        let own = materials.iter().filter(|castable| !castable.material().is_builtin());
        let own = own.flat_map(|castable| castable.material().settings.clone());
        own.chain(self.processes.settings(parts)).collect()
    }

    /// Returns the materials that parameters name, in their order, each once.
    pub fn used_materials(&self, parameters: &[Setting]) -> Vec<Castable> {
        let mut used: Vec<Castable> = Vec::new();
        for setting in parameters {
            let found = self.materials.find(&setting.value);
            let is_new = |castable: &&Castable| !used.contains(castable);
            used.extend(found.filter(is_new).cloned());
        }
        used
    }
}

/// Reads the user's file and reports unknown keys.
fn user_entries(
    user: Option<&UserFile>,
    found: &mut Vec<LocatedProblem>,
) -> Option<(TextPlace, Vec<YamlEntry>)> {
    let UserFile { file, text } = user?;
    let place = TextPlace::new(TextLayer::Base, file, &USER);
    let mut entries = read_mapping(text, &place, found)?;
    take_format(&mut entries, &place, found);
    entries.retain(|YamlEntry { key, key_position, .. }| {
        let is_known = USER_KEYS.contains(&&**key);
        if !is_known {
            let message = format!("`{}` is not a key of a materials file", to_printable(key));
            let hint = suggestion(key, USER_KEYS, "the keys are");
            found.push(place.at(*key_position).problem(&to_printable(key), "", message).hint(hint));
        }
        is_known
    });
    Some((place, entries))
}

/// Removes a section from entries and appends the named sections in it to `all`.
fn take_raws(
    noun: SectionKind,
    entries: &mut Vec<YamlEntry>,
    place: &TextPlace,
    all: &mut Vec<RawSection>,
    found: &mut Vec<LocatedProblem>,
) {
    if let Some(at) = entries.iter().position(|entry| entry.key == noun.key) {
        all.extend(read_sections(noun, entries.remove(at), place, found));
    }
}
