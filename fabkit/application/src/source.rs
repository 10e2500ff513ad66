//! Targets `SENSOR[/FIXTURE][/PART]`, and the texts from which designs are read.

mod check_errors;
#[cfg(test)]
mod tests;
mod user_files;
mod value_effects;

use std::path::{Path, PathBuf};

use fabkit_capture::Unit;
use fabkit_checks::{self as checks, CheckReport, InvalidBody};
use fabkit_designs::fixing::{self, FeasibleRange, ValueChange};
use fabkit_designs::{self as designs, BaseFile, BaseReference, Design, SensorText, UserFile};
use fabkit_files::diagnostics::{DiagnosedDesign, SourceText};
use fabkit_files::directory_listing::canonical_path;
use fabkit_files::progress::{ProgressCallback, report_counts};
use fabkit_files::reading::{self, ExpectedFile, ReadError};
use fabkit_files::{Error, ErrorKind, ErrorSubject, Explained, UnknownName};
use fabkit_fixtures::{self as fixtures, FixtureError, PressError, Project};
use fabkit_scene::SceneError;
use fabkit_text::InvalidDesign;

pub use fabkit_files::reading::MAX_YAML_BYTES;

pub use self::check_errors::CheckErrors;
pub use self::user_files::{USER_FILE_VARIABLE, read_profile, user_file};
pub use self::value_effects::value_effects_json;

/// Error of a sensor, variant or fixture that cannot be found or read.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub enum SourceError {
    /// Unknown built-in sensor.
    Sensor(UnknownName),
    /// Unknown built-in variant.
    #[error("{unknown}")]
    Preset {
        /// Name of the sensor.
        sensor: String,
        /// Requested variant.
        unknown: UnknownName,
    },
    /// Unknown fixture, or one that this sensor does not have.
    Fixture(FixtureError),
    /// Base file that cannot be read.
    #[error("{file}:{line}: extends `{word}`: {why}")]
    Extended {
        /// File that extends it.
        file: String,
        /// Line of its `extends`.
        line: usize,
        /// Path given there.
        word: String,
        /// Reason.
        why: Box<ReadError>,
    },
}

impl Explained for SourceError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Extended { why, .. } => why.kind(),
            _ => ErrorKind::BadInput,
        }
    }

    fn hint(&self) -> Option<String> {
        Some(match self {
            Self::Extended { why, .. } => {
                return why.hint().or(Some("paths are relative to the file that extends".into()));
            }
            Self::Sensor(unknown) => match &unknown.closest {
                Some(_) => unknown.hint(),
                None => format!("{}; a file of your own ends in .yaml", unknown.hint()),
            },
            Self::Preset { sensor, unknown } if unknown.known.is_empty() => {
                format!("{sensor} has no presets")
            }
            Self::Preset { unknown, .. } => unknown.hint(),
            Self::Fixture(_) => "`fabkit list` shows every fixture".into(),
        })
    }

    fn subject(&self) -> ErrorSubject {
        match self {
            Self::Sensor(error) | Self::Preset { unknown: error, .. } => error.subject(),
            Self::Fixture(FixtureError::Unknown { name }) => {
                UnknownName::new("fixture", name, fixtures::fixture_names()).subject()
            }
            Self::Fixture(_) => ErrorSubject::new("unsuitable_fixture"),
            Self::Extended { why, .. } => why.subject(),
        }
    }
}

/// Target of a command: a sensor or one of its fixtures, and optionally one part.
///
/// ```
/// use fabkit_application::source::Target;
/// let target = Target::new("rtac0/pin-dome/dome");
/// assert_eq!((target.sensor, target.fixture, target.part), ("rtac0", Some("pin-dome"), Some("dome")));
/// // What is no fixture is a part; what ends like a file is one as a whole.
/// assert_eq!(Target::new("rtac0/base").part, Some("base"));
/// assert_eq!(Target::new("sensors/mine.yaml").sensor, "sensors/mine.yaml");
/// let design = Target::new("rtac0").design(&["surface.radius=16 mm".into()])?;
/// assert!(design.parameters.iter().any(|one| one.path == "surface.radius" && one.value == "16 mm"));
/// # Ok::<(), fabkit_application::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Target<'a> {
    /// Name of a built-in sensor, or a path.
    pub sensor: &'a str,
    /// Name of the fixture.
    pub fixture: Option<&'a str>,
    /// Name of a part, layer or component.
    pub part: Option<&'a str>,
    /// Built-in variant of the sensor: the part of its name after `SENSOR-`.
    pub preset: Option<&'a str>,
}

/// Fixtures with their names.
pub type NamedDesigns = Vec<(&'static str, Design)>;

impl<'a> Target<'a> {
    /// Splits `SENSOR[/FIXTURE][/PART]`. A text that is an existing file, or ends like one, is a path as a whole,
    /// although it contains slashes.
    pub fn new(text: &'a str) -> Self {
        let plain = Self { sensor: text, fixture: None, part: None, preset: None };
        let (rest, last) = split_last(text);
        let is_fixture = |name: &str| fixtures::fixture_names().any(|fixture| fixture == name);
        match last {
            Some(last) if is_fixture(last) => Self { sensor: rest, fixture: Some(last), ..plain },
            Some(last) => match split_last(rest) {
                (sensor, Some(fixture)) if is_fixture(fixture) => {
                    Self { sensor, fixture: Some(fixture), part: Some(last), ..plain }
                }
                _ => Self { sensor: rest, part: Some(last), ..plain },
            },
            None => plain,
        }
    }

    /// Returns the sensor's file and the files that it extends, as far as they can be read; nothing for a built-in
    /// sensor.
    pub fn files(&self) -> Vec<PathBuf> {
        if !is_path(self.sensor) {
            return Vec::new();
        }
        let extended = Source::find(self.sensor).map(|source| source.bases).unwrap_or_default();
        let extended = extended.into_iter().map(|base| base.file.into());
        std::iter::once(self.sensor.into()).chain(extended).collect()
    }

    /// Returns whether the sensor is built in.
    pub fn is_builtin(&self) -> bool {
        designs::builtin_yaml(self.sensor).is_some()
    }

    /// Selects a built-in variant of the sensor.
    #[must_use]
    pub fn with_preset(self, preset: Option<&'a str>) -> Self {
        Self { preset, ..self }
    }

    fn source(&self) -> Result<Source, Error> {
        match self.preset {
            None => Source::find(self.sensor),
            Some(preset) => Source::preset(self.sensor, preset),
        }
    }

    /// Loads the sensor as a project, ignoring fixture and part.
    ///
    /// # Errors
    /// See [`Target::design`].
    pub fn project(&self, overrides: &[String]) -> Result<Project, Error> {
        self.source()?.load(overrides)
    }

    /// Reads and builds the sensor or the fixture, ignoring the part.
    ///
    /// # Errors
    /// Unknown names, unreadable or oversized files, and all problems of the design.
    pub fn design(&self, overrides: &[String]) -> Result<Design, Error> {
        let source = self.source()?;
        let project = source.load(overrides)?;
        match self.fixture {
            None => Ok(project.design),
            Some(name) => {
                project.fixture(name).map_err(|error| source.convert_fixture_error(error))
            }
        }
    }

    /// Finds changes of values chosen by fabkit with which the sensor can be built.
    ///
    /// # Errors
    /// See [`Source::fix`].
    pub fn fix(&self, overrides: &[String]) -> Result<Vec<ValueChange>, Error> {
        self.source()?.fix(overrides)
    }

    /// Computes the feasible range of each number of the sensor.
    ///
    /// # Errors
    /// See [`Source::limits`].
    pub fn limits(
        &self,
        overrides: &[String],
        follow: bool,
        progress: ProgressCallback,
    ) -> Result<Vec<FeasibleRange>, Error> {
        self.source()?.limits(overrides, follow, progress)
    }

    /// Reads the sensor and builds the fixture whose pins determine the camera's pose: its pin dome or pin plate.
    ///
    /// # Errors
    /// See [`Target::design`].
    pub fn pin_fixture(&self, overrides: &[String]) -> Result<Design, Error> {
        let source = self.source()?;
        let project = source.load(overrides)?;
        project
            .fixture(project.pin_fixture_name())
            .map_err(|error| source.convert_fixture_error(error))
    }

    /// Reads and builds the sensor and all its fixtures, with their names.
    ///
    /// # Errors
    /// See [`Target::design`].
    pub fn design_with_fixtures(
        &self,
        overrides: &[String],
    ) -> Result<(Design, NamedDesigns), Error> {
        let source = self.source()?;
        let project = source.load(overrides)?;
        let fixture = |name| match project.fixture(name) {
            Ok(design) => Ok((name, design)),
            Err(error) => Err(source.convert_fixture_error(error)),
        };
        let fixtures =
            project.fixture_names().into_iter().map(fixture).collect::<Result<_, _>>()?;
        Ok((project.design, fixtures))
    }

    /// Applies all rules to the sensor or the fixture. The inner error is an invalid solid.
    ///
    /// # Errors
    /// See [`Target::design`].
    pub fn check(
        &self,
        overrides: &[String],
        progress: ProgressCallback,
    ) -> Result<Result<CheckReport, InvalidBody>, Error> {
        let progress = &report_counts(progress);
        let source = self.source()?;
        let project = source.load(overrides)?;
        match self.fixture {
            None => Ok(checks::check_with_progress(&project.design.sensor, progress)),
            Some(name) => project
                .check_fixture(name, progress)
                .map_err(|error| source.convert_fixture_error(error)),
        }
    }
}

fn split_last(text: &str) -> (&str, Option<&str>) {
    if is_path(text) {
        return (text, None);
    }
    match text.rsplit_once('/') {
        Some((rest, last)) if !rest.is_empty() => (rest, Some(last)),
        _ => (text, None),
    }
}

fn is_path(sensor: &str) -> bool {
    let path = Path::new(sensor);
    let yaml = path.extension().is_some_and(|e| e == "yaml" || e == "yml");
    // A folder does not count: `SENSOR/FIXTURE` may have the name of one, for example in the output of an export.
    yaml || (sensor.contains('/') && path.exists() && !path.is_dir())
}

/// Text of a sensor file, with all texts that it may refer to.
///
/// ```
/// use fabkit_application::diagnostics::SourceText;
/// use fabkit_application::source::Source;
/// let text = "format: 1\nextends: rtac0\nname: mine\ntitle: Mine\ncoat: {thickness: 0.1 mm}\n";
/// let source = Source::from_text(SourceText { file: "mine.yaml".into(), text: text.into() });
/// assert_eq!(source.load(&[])?.design.sensor.name, "mine");
/// // Overrides, as `--set` of the command, win over the file.
/// assert!(source.load(&["coat.thickness=-1 mm".into()]).is_err());
/// # Ok::<(), fabkit_application::Error>(())
/// ```
pub struct Source {
    main: SourceText,
    /// User files that it extends, directly or indirectly.
    bases: Vec<BaseFile>,
    /// All other texts in which problems may lie: the extended files, built-in sensors and defaults.
    others: Vec<SourceText>,
    /// User's file of materials and processes for all sensors.
    user: Option<UserFile>,
}

impl Source {
    /// Finds a built-in sensor by name, or reads a file.
    ///
    /// # Errors
    /// Unknown names, unreadable or oversized files.
    pub fn find(sensor: &str) -> Result<Self, Error> {
        let main = if is_path(sensor) {
            let main = SourceText { file: sensor.into(), text: read_yaml(Path::new(sensor))? };
            let bases = extended_files(&main)?;
            return Ok(Self::from_texts(main, bases).with_user(user_file()?));
        } else if let Some(text) = builtin_text(sensor) {
            text
        } else {
            let unknown = UnknownName::new("sensor", sensor, designs::builtin_names());
            return Err(SourceError::Sensor(unknown).into());
        };
        Ok(Self::from_text(main).with_user(user_file()?))
    }

    /// Makes a source from text. `main.file` names it in messages.
    pub fn from_text(main: SourceText) -> Self {
        Self::from_texts(main, Vec::new())
    }

    /// Makes a source from text that extends other files.
    pub fn from_texts(main: SourceText, bases: Vec<BaseFile>) -> Self {
        let own = bases.iter().map(|BaseFile { file, text, .. }| (file.clone(), text.clone()));
        let own: Vec<_> = own.map(|(file, text)| SourceText { file, text }).collect();
        let defaults = fixtures::default_files()
            .chain(designs::REGISTRY.default_files())
            .map(|(file, text)| SourceText { file: file.into(), text: text.into() });
        let builtin = designs::builtin_names().into_iter().filter_map(builtin_text);
        let others = own.into_iter().chain(builtin).chain(defaults);
        let others = others.filter(|other| other.file != main.file).collect();
        Self { main, bases, others, user: None }
    }

    /// Adds the user's file of materials and processes.
    #[must_use]
    pub fn with_user(mut self, user: Option<UserFile>) -> Self {
        let text =
            |user: &UserFile| SourceText { file: user.file.clone(), text: user.text.clone() };
        self.others.extend(user.as_ref().map(text));
        self.user = user;
        self
    }

    /// Returns the user's file of materials and processes.
    pub fn user(&self) -> Option<&UserFile> {
        self.user.as_ref()
    }

    /// Finds a built-in variant of a built-in sensor, for example `rtac0` and `published-2025`.
    ///
    /// # Errors
    /// A sensor or a preset that is not built in.
    pub fn preset(sensor: &str, preset: &str) -> Result<Self, Error> {
        let base = Self::find(sensor)?;
        let Some(main) = builtin_text(&format!("{sensor}-{preset}")) else {
            let of_sensor = |name: &'static str| name.strip_prefix(sensor)?.strip_prefix('-');
            let known: Vec<&str> =
                designs::builtin_names().into_iter().filter_map(of_sensor).collect();
            let unknown = UnknownName::new("preset", preset, known.iter().copied());
            return Err(SourceError::Preset { sensor: sensor.into(), unknown }.into());
        };
        let mut others: Vec<SourceText> = std::iter::once(base.main).chain(base.others).collect();
        others.retain(|other| other.file != main.file);
        Ok(Self { main, bases: Vec::new(), others, user: base.user })
    }

    /// Returns all texts from which the sensor is read.
    fn sensor_text(&self) -> SensorText<'_> {
        let SourceText { file, text: yaml } = &self.main;
        SensorText { file, yaml, bases: &self.bases, user: self.user.as_ref(), omitted: None }
    }

    /// Returns the files that the sensor file extends.
    pub fn bases(&self) -> &[BaseFile] {
        &self.bases
    }

    /// Returns the sensor's own file.
    pub fn text(&self) -> &SourceText {
        &self.main
    }

    /// Returns every file in which problems may lie, the sensor's own first.
    pub fn texts(&self) -> impl Iterator<Item = &SourceText> {
        std::iter::once(&self.main).chain(&self.others)
    }

    /// Builds the sensor and reads the parameters of its fixtures.
    ///
    /// # Errors
    /// All problems of the design.
    pub fn load(&self, overrides: &[String]) -> Result<Project, Error> {
        fixtures::load_text(self.sensor_text(), overrides).map_err(|mut invalid| {
            fixing::advise(self.sensor_text(), overrides, &[fixtures::KEY], &mut invalid);
            self.invalid(invalid)
        })
    }

    /// Builds one unit of the sensor: made parts and layers deviate within their tolerances, and camera and light
    /// sources are the unit's own. Parameters and fixtures stay nominal.
    ///
    /// # Errors
    /// All problems of the design.
    pub fn load_unit(&self, unit: Unit, overrides: &[String]) -> Result<Project, Error> {
        let drawn = self.load(overrides)?;
        let off = |path: &str| unit.dimension_deviation(path);
        let built = designs::unit_dimensions::build_unit(
            self.sensor_text(),
            overrides,
            &[fixtures::KEY],
            &off,
        );
        let (built, dimensions) = built.map_err(|invalid| self.invalid(invalid))?;
        let mut sensor = built.sensor;
        unit.apply_to_sensor(&mut sensor);
        Ok(drawn.into_unit(unit.0, sensor, dimensions))
    }

    /// Finds the fewest and smallest changes of values chosen by fabkit with which the sensor can be built.
    ///
    /// # Errors
    /// Texts that cannot be read, and rules that contradict each other.
    pub fn fix(&self, overrides: &[String]) -> Result<Vec<ValueChange>, Error> {
        fixing::fix(self.sensor_text(), overrides, &[fixtures::KEY])
            .map_err(|invalid| self.invalid(invalid))
    }

    /// Computes the feasible range of each number of the sensor; with `follow` also the range in which chosen values
    /// may follow.
    ///
    /// # Errors
    /// All problems of the design.
    pub fn limits(
        &self,
        overrides: &[String],
        follow: bool,
        progress: ProgressCallback,
    ) -> Result<Vec<FeasibleRange>, Error> {
        let progress = report_counts(progress);
        let others = [fixtures::KEY];
        fixing::find_feasible_ranges(
            self.sensor_text(),
            overrides,
            &others,
            follow,
            &|done, all| {
                progress(done, all);
            },
        )
        .map_err(|invalid| self.invalid(invalid))
    }

    /// Converts a fixture's error, attaching the texts that cause it.
    pub fn convert_fixture_error(&self, error: FixtureError) -> Error {
        match error {
            FixtureError::Invalid(invalid) => self.invalid(invalid),
            other => SourceError::Fixture(other).into(),
        }
    }

    fn invalid(&self, invalid: InvalidDesign) -> Error {
        DiagnosedDesign::new(invalid, self.texts().cloned()).into()
    }
}

/// Reads the chain of extended files. A cycle or an excessive chain ends here; it is reported where the files are
/// interpreted.
fn extended_files(main: &SourceText) -> Result<Vec<BaseFile>, Error> {
    /// One more than allowed, so that the excess is noticed later.
    const MOST: usize = 17;
    let mut bases: Vec<BaseFile> = Vec::new();
    let real = |file: &str| canonical_path(Path::new(file));
    let mut known = vec![(real(&main.file), main.file.clone())];
    let mut last = main.clone();
    while bases.len() < MOST
        && let Some(BaseReference { word, line }) = designs::extended_file(&last.text)
    {
        let folder = Path::new(&last.file).parent().unwrap_or(Path::new(""));
        let file = folder.join(&word).display().to_string();
        let by = last.file.clone();
        // A known file is listed under its first name, however it is spelled here. The repetition marks a cycle.
        let place = real(&file);
        if let Some((_, file)) = known.iter().find(|(known, _)| *known == place) {
            bases.push(BaseFile {
                extending_file: by,
                word,
                file: file.clone(),
                text: String::new(),
            });
            break;
        }
        let text = reading::read_text(Path::new(&file), EXPECTED).map_err(|why| {
            let (file, word, why) = (by.clone(), word.clone(), Box::new(why));
            SourceError::Extended { file, line, word, why }
        })?;
        known.push((place, file.clone()));
        bases.push(BaseFile { extending_file: by, word, file: file.clone(), text: text.clone() });
        last = SourceText { file, text };
    }
    Ok(bases)
}

/// Converts the error of a press; `sensor` is a name or a path, whose texts may be the cause.
pub fn convert_press_error(sensor: &str, error: PressError) -> Error {
    match error {
        PressError::Fixture(error) => match Source::find(sensor) {
            Ok(source) => source.convert_fixture_error(error),
            Err(error) => error,
        },
        PressError::Surface(_) => Error::bug(error),
        other => SceneError::Press(other).into(),
    }
}

/// Returns the text of a built-in sensor, named as the designs crate names it in messages.
fn builtin_text(name: &str) -> Option<SourceText> {
    let text = designs::builtin_yaml(name)?;
    Some(SourceText { file: format!("{name}.yaml (built-in)"), text: text.into() })
}

const EXPECTED: ExpectedFile = ExpectedFile {
    what: "a sensor's file",
    max_bytes: MAX_YAML_BYTES,
    hint: "is it the right file? `fabkit show rtac0` shows what one holds",
};

fn read_yaml(path: &Path) -> Result<String, Error> {
    Ok(reading::read_text(path, EXPECTED)?)
}
