//! Registry of sensor families and built-in sensors, which turns a sensor file into a design.

mod camera_modules;
mod extends;
mod layers;
mod missing_parameters;
mod templates;
mod trial;
mod user_values;

use std::cell::RefCell;

use fabkit_geometry::Sensor;
use fabkit_text::{
    Dialect, Example, FamilySchema, FieldDeclaration, FileSafeName, InvalidDesign, Json,
    LocatedProblem, Parameter, ParameterTable, Reader, RuleReport, Section, Setting, TextLayer,
    TextPlace, root_schema,
};

pub use camera_modules::camera_modules;
pub use extends::{BaseFile, BaseReference, SensorText, extended_file};
pub use templates::TemplateBase;
pub(crate) use trial::Trial;
pub use user_values::UserValue;

use layers::{LayeredDocument, OtherSections, internal_error, lay_defaults, lay_shared_defaults};

use crate::Design;
use crate::articles::fill_and_check;
use crate::blocks;
use crate::blocks::adapter::{self, Adapter, MountFace};
use crate::labels::{self, Labels};
use crate::loads::{self, Loads};
use crate::materials::{Castable, add_bonds, assign_substances, check_kinds, find_adhesions};
use crate::processes::{Workshop, assign, names, report_unmatched};
use crate::user_catalogue::{ReaderContext, add_to_schema};

/// Version of the file format that is read.
pub const FORMAT: u32 = 1;

/// Dialect of sensor files.
const SENSOR: Dialect = Dialect {
    base: "a built-in sensor",
    absent: missing_parameters::ABSENT,
    ..Dialect::new("sensor", FORMAT, " and `extends: NAME`")
};

fabkit_text::parameters! {
    /// Keys that every sensor file has besides its parameters.
    pub struct Header {
        /// Name of the sensor and of its output folder.
        name: FileSafeName,
        /// Title of the sensor, for people.
        title: String = 1..=200,
        /// Publication from which the sensor comes.
        reference: String = 0..=500,
    }
}

/// Result of [`Family::build`].
#[derive(Clone, Debug)]
pub struct FamilyOutput {
    /// Parts, layers and components.
    pub sensor: Sensor,
    /// Quantities derived from the parameters, for `fabkit show`: name, and value with unit.
    pub derived: Vec<(String, String)>,
    /// Face that the sensor is mounted by, if an adapter can be screwed to it.
    pub face: Option<MountFace>,
}

/// Family of sensors: parameters, the constraints between them, and the parts made from them.
pub trait Family {
    /// Parameters, declared with [`parameters!`](crate::parameters!).
    type Parameters: Section;
    /// Word behind `family:` in sensor files.
    const NAME: &'static str;
    /// Summary in one line.
    const SUMMARY: &'static str;
    /// Built-in sensor whose values serve as examples.
    const EXAMPLE: &'static str;
    /// Default values: file name for messages and YAML text of each file.
    ///
    /// The defaults describe what the family made before it had these parameters, so that they do not count for the
    /// identity of a design.
    const DEFAULTS: &'static [(&'static str, &'static str)] = &[];

    /// Reports impossible combinations. Each value is already within its own limits.
    fn check(parameters: &Self::Parameters, report: &mut RuleReport);

    /// Builds the parts. Called only while there is no problem; returns `None` after reporting one.
    fn build(
        parameters: &Self::Parameters,
        header: &Header,
        report: &mut RuleReport,
    ) -> Option<FamilyOutput>;
}

/// Entry of the table of families: the type-erased form of a [`Family`].
#[derive(Clone, Copy, Debug)]
pub struct FamilyEntry {
    name: &'static str,
    summary: &'static str,
    example: &'static str,
    defaults: &'static [(&'static str, &'static str)],
    fields: fn() -> Vec<FieldDeclaration>,
    run: fn(Reader, Option<&Example>, ReadSections) -> ReadOutcome,
    probe: fn(Reader) -> RuleReport,
}

/// Callback that reads the sections of other crates in the same file, after the family's own parameters.
type ReadSections<'a> = &'a mut dyn FnMut(&mut Reader);

/// Callback that returns the names of parts that other crates make for a sensor, as `parts:` calls them; `None` where
/// they are not known.
type FixturePartNames<'a> = &'a mut dyn FnMut(&Sensor) -> Option<Vec<String>>;

/// Design with the positions of its values in the files, and with the statements on how parts are made.
struct LoadedDesign {
    design: Design,
    report: RuleReport,
    workshop: Workshop,
}

/// Result of reading and building: settings and parts, as far as they could be obtained, and the problems.
struct ReadOutcome {
    settings: Vec<Setting>,
    built: Option<FamilyOutput>,
    labels: Option<Labels>,
    report: RuleReport,
}

/// Section that another crate keeps in sensor files.
///
/// Values that a file leaves out come from the defaults, which are files of the same form.
#[derive(Clone, Copy, Debug)]
pub struct Extension {
    /// Top-level key of the section.
    pub key: &'static str,
    /// Summary in one line.
    pub summary: &'static str,
    /// Default values: file name for messages and YAML text of each file; each file holds `key:` alone.
    pub defaults: &'static [(&'static str, &'static str)],
}

/// Parameters of an extension, as read.
#[derive(Clone, Debug)]
pub struct ExtensionValues<P> {
    /// Typed parameters.
    pub parameters: P,
    /// Parameters as `fabkit show` prints them.
    pub settings: Vec<Setting>,
    /// Report that knows the positions of the values, for further findings.
    pub report: RuleReport,
    /// Statements of the file on how parts are made.
    pub workshop: Workshop,
}

impl FamilyEntry {
    /// Creates the entry of a family.
    pub const fn new<F: Family>() -> Self {
        Self {
            name: F::NAME,
            summary: F::SUMMARY,
            example: F::EXAMPLE,
            defaults: F::DEFAULTS,
            fields: F::Parameters::fields,
            run: run::<F>,
            probe: probe::<F>,
        }
    }

    /// Returns the word behind `family:`.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Returns the summary in one line.
    pub fn summary(&self) -> &'static str {
        self.summary
    }

    /// Returns the built-in sensor whose values serve as examples.
    pub fn example(&self) -> &'static str {
        self.example
    }

    /// Returns the family's parameters, followed by those that every family has.
    fn parameters(&self) -> Vec<FieldDeclaration> {
        let mut fields = (self.fields)();
        let shape = Adapter::shape(&());
        fields.push(FieldDeclaration {
            name: adapter::KEY,
            summary: adapter::SUMMARY.into(),
            shape,
        });
        let shape = Labels::shape(&());
        fields.push(FieldDeclaration { name: labels::KEY, summary: labels::SUMMARY.into(), shape });
        let shape = Loads::shape(&());
        fields.push(FieldDeclaration { name: loads::KEY, summary: loads::SUMMARY.into(), shape });
        fields
    }

    /// Returns every key of this family's files except `format`, `family` and `extends`.
    fn all_fields(&self) -> Vec<FieldDeclaration> {
        [Header::fields(), self.parameters()].concat()
    }

    /// Lays the family's default values into a document.
    fn lay_defaults(&self, document: &mut ParameterTable) {
        lay_shared_defaults(document);
        // The family's own defaults come last: they override those shared by all families.
        let files = [&[adapter::DEFAULTS, labels::DEFAULTS, loads::DEFAULTS], self.defaults];
        lay_defaults(document, &files.concat(), TextLayer::Default);
    }
}

/// Reads a document as the family `F` and builds its parts, then applies loads, adapter and labels.
fn run<F: Family>(
    mut reader: Reader,
    example: Option<&Example>,
    read_more: ReadSections,
) -> ReadOutcome {
    let header = Header::read(&mut reader, "", "", &());
    reader.take_settings(); // The header is no parameter.
    let parameters = F::Parameters::read(&mut reader, "", "", &());
    let adapter = Adapter::read(&mut reader, adapter::KEY, "", &());
    let labels = Labels::read(&mut reader, labels::KEY, "", &());
    let loads = Loads::read(&mut reader, loads::KEY, "", &());
    let settings = reader.take_settings();
    // Read after the family's settings have been taken, so that those of other crates stay separate.
    read_more(&mut reader);
    let known = reader.context::<ReaderContext>().cloned();
    let mut report = reader.finish(example);
    if let Some(known) = &known {
        check_kinds(&settings, &known.materials, &mut report);
    }
    if let Some(parameters) = parameters.as_ref().filter(|_| !report.has_unknown_names()) {
        F::check(parameters, &mut report);
        // Evaluates the rules on neighbouring values, to trace which parameters each limit follows from.
        report.find_limit_inputs("", parameters, F::check);
    }
    let mut built = match (&parameters, &header) {
        (Some(parameters), Some(header)) if report.is_clean() => {
            F::build(parameters, header, &mut report)
        }
        _ => None,
    };
    if let (Some(built), Some(loads)) = (&mut built, loads) {
        built.sensor.required_load_n = Some(loads.touch.0);
    }
    if let (Some(built), Some(adapter)) = (&mut built, adapter) {
        adapter::apply(&adapter, built.face.as_ref(), &mut built.sensor, &mut report);
    }
    if let (Some(built), Some(labels)) = (&mut built, &labels) {
        let labelled = labels::apply(labels, &mut built.sensor, &mut report);
        if !labelled.is_empty() {
            built.derived.push(("labelled parts".into(), labelled.join(", ")));
        }
    }
    ReadOutcome { settings, built, labels, report }
}

/// Checks the values against the family's constraints without building anything.
fn probe<F: Family>(mut reader: Reader) -> RuleReport {
    Header::read(&mut reader, "", "", &());
    let parameters = F::Parameters::read(&mut reader, "", "", &());
    let mut report = reader.finish(None);
    if let Some(parameters) = &parameters {
        F::check(parameters, &mut report);
    }
    report
}

/// Table of all families and built-in sensors.
///
/// ```
/// use fabkit_designs::REGISTRY;
/// let families: Vec<_> = REGISTRY.families().iter().map(|family| family.name()).collect();
/// assert!(families.contains(&"dome") && families.contains(&"flat-gel"));
/// assert!(REGISTRY.parameter_paths("dome").contains(&"surface.radius".to_owned()));
/// assert!(REGISTRY.parameter_paths("no-such-family").is_empty());
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Registry {
    families: &'static [FamilyEntry],
    sensors: &'static [(&'static str, &'static str)],
}

impl Registry {
    /// Creates a registry of families and of built-in sensors, each sensor with its name and YAML text.
    pub const fn new(
        families: &'static [FamilyEntry],
        sensors: &'static [(&'static str, &'static str)],
    ) -> Self {
        Self { families, sensors }
    }

    /// Returns the names of the built-in sensors, sorted.
    pub fn builtin_names(&self) -> Vec<&'static str> {
        let mut names: Vec<&str> = self.sensors.iter().map(|(name, _)| *name).collect();
        names.sort_unstable();
        names
    }

    /// Returns the YAML text of a built-in sensor.
    pub fn builtin_yaml(&self, name: &str) -> Option<&'static str> {
        self.sensors.iter().find(|(known, _)| *known == name).map(|(_, yaml)| *yaml)
    }

    /// Returns the files with default values, each with its name for messages and its text. A file that several
    /// families share appears several times.
    pub fn default_files(&self) -> impl Iterator<Item = (&'static str, &'static str)> {
        let defaults = self.families.iter().flat_map(|family| family.defaults.iter().copied());
        let shared = [blocks::DEFAULTS, adapter::DEFAULTS, labels::DEFAULTS, loads::DEFAULTS];
        defaults.chain(shared)
    }

    /// Returns the dotted path of every parameter of a family, in order.
    pub fn parameter_paths(&self, family: &str) -> Vec<String> {
        let family = self.families.iter().filter(|f| f.name == family);
        let root = TextPlace::new(TextLayer::File, "", &SENSOR);
        family.flat_map(|f| ParameterTable::new(f.parameters(), root.clone()).paths()).collect()
    }

    /// Returns the JSON Schema (draft-07) of sensor files.
    ///
    /// `extensions` are the sections that other crates keep in the files: key, summary, fields. All of their values
    /// have defaults.
    pub fn json_schema(&self, extensions: &[(&str, &str, Vec<FieldDeclaration>)]) -> Json {
        // A key is optional if the family's defaults give it a value.
        let optional = |family: &FamilyEntry| {
            let place = TextPlace::new(TextLayer::Default, "", &SENSOR);
            let mut document = ParameterTable::new(family.parameters(), place);
            family.lay_defaults(&mut document);
            document.into_values().into_keys().collect()
        };
        let schema = |family: &FamilyEntry| FamilySchema {
            optional: optional(family),
            name: family.name,
            summary: family.summary,
            fields: family.all_fields(),
            sensors: self
                .builtin_names()
                .into_iter()
                .filter(|name| self.family_of(name) == Some(family.name))
                .collect(),
        };
        let families: Vec<FamilySchema> = self.families.iter().map(schema).collect();
        let mut schema = root_schema(FORMAT, &families, extensions);
        add_to_schema(&mut schema);
        schema
    }

    /// Returns the family that a built-in sensor belongs to, directly or through the sensor it extends.
    fn family_of(&self, name: &str) -> Option<&'static str> {
        let place = TextPlace::new(TextLayer::Base, name, &SENSOR);
        let layers = self.layers(self.builtin_yaml(name)?, place, &[], &mut Vec::new())?;
        Some(layers.family.name)
    }

    /// Builds a design from YAML text and overrides (`path=value`).
    ///
    /// `file` names the text in messages. Top-level keys among `others` belong to other crates and are skipped.
    ///
    /// # Errors
    /// Every problem, in the order of the file, then of the overrides.
    pub fn load(
        &self,
        file: &str,
        yaml: &str,
        overrides: &[String],
        others: &[&str],
    ) -> Result<Design, InvalidDesign> {
        self.load_text(SensorText::without_bases(file, yaml), overrides, others)
    }

    /// Builds a design from a sensor's file, the files it extends and the user's file.
    ///
    /// # Errors
    /// As for [`Registry::load`].
    pub(crate) fn load_text(
        &self,
        text: SensorText,
        overrides: &[String],
        others: &[&str],
    ) -> Result<Design, InvalidDesign> {
        let extra = OtherSections { others, section: None };
        // If other crates keep sections in the file, the names of their parts are not known here.
        let mut names = |_: &Sensor| others.is_empty().then(Vec::new);
        self.load_with(text, overrides, extra, &mut |_| (), &mut names).map(|loaded| loaded.design)
    }

    /// Builds a design and reads the section that another crate keeps in the file. `names` returns the names of the
    /// parts that this crate makes for the sensor, as `parts:` calls them.
    ///
    /// # Errors
    /// As for [`Registry::load`].
    pub fn load_extended<P: Section>(
        &self,
        text: SensorText,
        overrides: &[String],
        extension: &Extension,
        names: impl Fn(&P, &Sensor) -> Vec<String>,
    ) -> Result<(Design, ExtensionValues<P>), InvalidDesign> {
        // Two closures share the parameters: one reads them, the other names the parts that are made from them.
        let (parameters, mut settings) = (RefCell::new(None), Vec::new());
        let field = FieldDeclaration {
            name: extension.key,
            summary: extension.summary.into(),
            shape: P::shape(&()),
        };
        let mut read = |reader: &mut Reader| {
            *parameters.borrow_mut() = P::read(reader, extension.key, "", &());
            settings = reader.take_settings();
        };
        // `None` while the extension's parameters cannot be read: its parts are not known then.
        let mut names = |sensor: &Sensor| Some(names(parameters.borrow().as_ref()?, sensor));
        let extra = OtherSections { others: &[], section: Some((extension, field)) };
        let LoadedDesign { design, report, workshop } =
            self.load_with(text, overrides, extra, &mut read, &mut names)?;
        match parameters.into_inner() {
            Some(parameters) => {
                Ok((design, ExtensionValues { parameters, settings, report, workshop }))
            }
            None => Err(internal_error(text.file, format!("`{}` cannot be read", extension.key))),
        }
    }

    /// Reads all layers, builds the design and completes it with processes, materials and articles.
    fn load_with(
        &self,
        text: SensorText,
        overrides: &[String],
        extra: OtherSections,
        read_more: ReadSections,
        more_names: FixturePartNames,
    ) -> Result<LoadedDesign, InvalidDesign> {
        let LayeredDocument { document, family, own } = self.layer_texts(text, overrides, extra)?;
        let example = self.example(&family);
        let known = own.known();
        let making = known.making.clone();
        let reader = Reader::new(document).with_context(known);
        let ReadOutcome { settings, built, labels, report } =
            (family.run)(reader, example.as_ref(), read_more);
        match built {
            Some(FamilyOutput { mut sensor, derived, .. }) if report.is_clean() => {
                let mut found = Vec::new();
                let of_sensor = names(&sensor, "");
                assign(&mut sensor, "", &making, making.is_used(), &mut found);
                add_bonds(&mut sensor, &own.materials, &own.stock);
                fill_and_check(&mut sensor, &own.articles, &own.materials.components(), &mut found);
                let materials: Vec<Castable> = own.used_materials(&settings);
                materials.iter().for_each(|material| material.apply_transparency(&mut sensor));
                assign_substances(&mut sensor, &own.materials, &own.stock);
                find_adhesions(&mut sensor);
                // The fixtures of a sensor may depend on the materials of its parts, so their names are asked for last.
                if !making.all_assignments().is_empty()
                    && let Some(more) = more_names(&sensor)
                {
                    report_unmatched(&making, &of_sensor, &more, &mut found);
                }
                if !found.is_empty() {
                    return Err(InvalidDesign::new(LocatedProblem::sort(found)));
                }
                let mut parameters = settings;
                parameters.extend(own.settings(&materials, &of_sensor));
                parameters.extend(own.stock.settings(&sensor.bodies));
                let design = Design {
                    family: family.name,
                    sensor,
                    parameters,
                    derived,
                    materials,
                    companions: Vec::new(),
                    articles: own.articles.clone(),
                };
                let workshop = Workshop {
                    processes: own.processes,
                    making,
                    labels,
                    articles: own.articles,
                    materials: own.materials,
                    stock: own.stock,
                };
                Ok(LoadedDesign { design, report, workshop })
            }
            _ if !report.is_clean() => Err(report.into_invalid()),
            // A family that reports no problem has to build something.
            _ => {
                Err(internal_error(text.file, format!("the family {} built nothing", family.name)))
            }
        }
    }

    /// Returns the values of a family's example, for hints in messages.
    fn example(&self, family: &FamilyEntry) -> Option<Example> {
        let (_, values) = self.builtin_values(family.example)?;
        let values = values.into_iter().map(|(path, w)| (path, w.text.to_printable())).collect();
        Some(Example { name: family.example, values })
    }
}
