//! `SENSOR[/FIXTURE][/PART]`: where a design's text comes from.

mod user_files;

use std::path::{Path, PathBuf};

use fabkit_capture::Unit;
use fabkit_checks::{self as checks, CheckReport, InvalidBody, Severity};
use fabkit_designs::fixing::{self, Change, Feasible};
use fabkit_designs::{self as designs, BaseFile, Design, Extends, SensorText, UserFile};
use fabkit_files::diagnostics::{Diagnosed, SourceText};
use fabkit_files::listing::real_path;
use fabkit_files::progress::{OnProgress, counted};
use fabkit_files::reading::{self, Expected, ReadError};
use fabkit_files::{Error, ErrorKind, ErrorSubject, Explained, UnknownName};
use fabkit_fixtures::{self as fixtures, FixtureError, PressError, Project};
use fabkit_scene::SceneError;
use fabkit_text::InvalidDesign;

pub use fabkit_files::reading::MAX_YAML_BYTES;

pub use self::user_files::{USER_FILE_VARIABLE, read_profile, user_file};

/// A sensor or a fixture that is not there.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub enum SourceError {
    /// No built-in sensor of that name.
    Sensor(UnknownName),
    /// No built-in variant of that name.
    #[error("{unknown}")]
    Preset {
        /// Of which sensor.
        sensor: String,
        /// What was asked for.
        unknown: UnknownName,
    },
    /// No such fixture, or none for this sensor.
    Fixture(FixtureError),
    /// A file that another one extends and that cannot be read.
    #[error("{file}:{line}: extends `{word}`: {why}")]
    Extended {
        /// The one that extends it.
        file: String,
        /// Where it does.
        line: usize,
        /// What stands there.
        word: String,
        /// Why it cannot be read.
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

/// What a command is about: a sensor or one of its fixtures, and perhaps one part of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Target<'a> {
    /// Name of a built-in sensor, or a path.
    pub sensor: &'a str,
    /// Name of a fixture.
    pub fixture: Option<&'a str>,
    /// Name of a part, layer or component.
    pub part: Option<&'a str>,
    /// A built-in variant of the sensor: the rest of its name after `SENSOR-`.
    pub preset: Option<&'a str>,
}

/// Fixtures by name.
pub type NamedDesigns = Vec<(&'static str, Design)>;

impl<'a> Target<'a> {
    /// Splits `SENSOR[/FIXTURE][/PART]`. Paths have slashes too: a name that is a file, or looks
    /// like one, is a path as a whole.
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

    /// The sensor's file, where it is not built in, and those that it extends, as far as they can be
    /// read.
    pub fn files(&self) -> Vec<PathBuf> {
        if !is_path(self.sensor) {
            return Vec::new();
        }
        let extended = Source::find(self.sensor).map(|source| source.bases).unwrap_or_default();
        let extended = extended.into_iter().map(|base| base.file.into());
        std::iter::once(self.sensor.into()).chain(extended).collect()
    }

    /// Whether a built-in sensor is meant.
    pub fn is_builtin(&self) -> bool {
        designs::builtin_yaml(self.sensor).is_some()
    }

    /// The same of a built-in variant of the sensor.
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

    /// The sensor itself, whatever of it is meant.
    ///
    /// # Errors
    /// As for [`Target::design`].
    pub fn project(&self, overrides: &[String]) -> Result<Project, Error> {
        self.source()?.load(overrides)
    }

    /// Reads and builds what is meant, its part aside.
    ///
    /// # Errors
    /// Unknown names, unreadable or oversized files, and all problems of the design.
    pub fn design(&self, overrides: &[String]) -> Result<Design, Error> {
        let source = self.source()?;
        let project = source.load(overrides)?;
        match self.fixture {
            None => Ok(project.design),
            Some(name) => project.fixture(name).map_err(|error| source.error(error)),
        }
    }

    /// What has to change of what fabkit has chosen so that the sensor can be built.
    ///
    /// # Errors
    /// As for [`Source::fix`].
    pub fn fix(&self, overrides: &[String]) -> Result<Vec<Change>, Error> {
        self.source()?.fix(overrides)
    }

    /// How far each number of the sensor can go.
    ///
    /// # Errors
    /// As for [`Source::limits`].
    pub fn limits(
        &self,
        overrides: &[String],
        follow: bool,
        progress: OnProgress,
    ) -> Result<Vec<Feasible>, Error> {
        self.source()?.limits(overrides, follow, progress)
    }

    /// Reads the sensor and builds the fixture whose pins tell the camera's pose: its pin dome, or pin
    /// plate.
    ///
    /// # Errors
    /// As for [`Target::design`].
    pub fn pins(&self, overrides: &[String]) -> Result<Design, Error> {
        let source = self.source()?;
        let project = source.load(overrides)?;
        project.fixture(project.pin_fixture_name()).map_err(|error| source.error(error))
    }

    /// Reads and builds the sensor and all its fixtures, by name.
    ///
    /// # Errors
    /// As for [`Target::design`].
    pub fn design_with_fixtures(
        &self,
        overrides: &[String],
    ) -> Result<(Design, NamedDesigns), Error> {
        let source = self.source()?;
        let project = source.load(overrides)?;
        let fixture = |name| match project.fixture(name) {
            Ok(design) => Ok((name, design)),
            Err(error) => Err(source.error(error)),
        };
        let fixtures =
            project.fixture_names().into_iter().map(fixture).collect::<Result<_, _>>()?;
        Ok((project.design, fixtures))
    }

    /// Applies all rules to it. The inner error is a solid that is none.
    ///
    /// # Errors
    /// As for [`Target::design`].
    pub fn check(
        &self,
        overrides: &[String],
        progress: OnProgress,
    ) -> Result<Result<CheckReport, InvalidBody>, Error> {
        let progress = &counted(progress);
        let source = self.source()?;
        let project = source.load(overrides)?;
        match self.fixture {
            None => Ok(checks::check_watched(&project.design.sensor, progress)),
            Some(name) => {
                project.check_fixture(name, progress).map_err(|error| source.error(error))
            }
        }
    }
}

/// What keeps designs from being built as described.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Faults {
    /// How many findings are errors.
    pub errors: usize,
    /// Each design with errors, and the first of them.
    pub first: Vec<(String, String)>,
}

impl Target<'_> {
    /// Applies all rules to it, and perhaps to all fixtures of the sensor, for those who want to know
    /// no more than whether it passes. The inner error is a solid that is none.
    ///
    /// # Errors
    /// As for [`Target::design`].
    pub fn faults(
        &self,
        overrides: &[String],
        with_fixtures: bool,
    ) -> Result<Result<Faults, InvalidBody>, Error> {
        let source = self.source()?;
        let project = source.load(overrides)?;
        let fixtures = match self.fixture {
            Some(name) => vec![name],
            None if with_fixtures => project.fixture_names(),
            None => Vec::new(),
        };
        let mut reports = Vec::new();
        if self.fixture.is_none() {
            // Nothing is weighed: that takes a third of the time of some sensors.
            let report = checks::check_variant(&project.design.sensor, &checks::Memo::default());
            reports.push((project.design.sensor.name.clone(), report));
        }
        for name in fixtures {
            let report = project.check_fixture(name, &|_, _| {}).map_err(|e| source.error(e))?;
            reports.push((format!("{}/{name}", project.design.sensor.name), report));
        }
        let mut faults = Faults::default();
        for (name, report) in reports {
            let report = match report {
                Ok(report) => report,
                Err(invalid) => return Ok(Err(invalid)),
            };
            faults.errors += report.errors();
            let first = report.findings.into_iter().find(|f| f.severity == Severity::Error);
            faults.first.extend(first.map(|finding| (name, finding.message)));
        }
        Ok(Ok(faults))
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
    yaml || (sensor.contains('/') && path.exists() && !path.is_dir())
}

/// A sensor's file as text, with the built-in files that it may refer to.
pub struct Source {
    main: SourceText,
    /// The user's files that it extends.
    bases: Vec<BaseFile>,
    /// It may extend those and a built-in sensor, and problems may lie there.
    others: Vec<SourceText>,
    /// What the user keeps for all sensors.
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
            return Ok(Self::of_texts(main, bases).with_user(user_file()?));
        } else if let Some(text) = builtin(sensor) {
            text
        } else {
            let unknown = UnknownName::new("sensor", sensor, designs::builtin_names());
            return Err(SourceError::Sensor(unknown).into());
        };
        Ok(Self::of_text(main).with_user(user_file()?))
    }

    /// A sensor whose text came from elsewhere; `main.file` names it in messages.
    pub fn of_text(main: SourceText) -> Self {
        Self::of_texts(main, Vec::new())
    }

    /// The same of one that extends other files.
    pub fn of_texts(main: SourceText, bases: Vec<BaseFile>) -> Self {
        let own = bases.iter().map(|BaseFile { file, text, .. }| (file.clone(), text.clone()));
        let own: Vec<_> = own.map(|(file, text)| SourceText { file, text }).collect();
        let defaults = fixtures::default_files()
            .chain(designs::REGISTRY.default_files())
            .map(|(file, text)| SourceText { file: file.into(), text: text.into() });
        let builtin = designs::builtin_names().into_iter().filter_map(builtin);
        let others = own.into_iter().chain(builtin).chain(defaults);
        let others = others.filter(|other| other.file != main.file).collect();
        Self { main, bases, others, user: None }
    }

    /// The same with what the user keeps for all sensors.
    #[must_use]
    pub fn with_user(mut self, user: Option<UserFile>) -> Self {
        let text =
            |user: &UserFile| SourceText { file: user.file.clone(), text: user.text.clone() };
        self.others.extend(user.as_ref().map(text));
        self.user = user;
        self
    }

    /// What the user keeps for all sensors.
    pub fn user(&self) -> Option<&UserFile> {
        self.user.as_ref()
    }

    /// Finds a built-in variant of a built-in sensor: `rtac0` and `published-2025`.
    ///
    /// # Errors
    /// A sensor or a preset that is not built in.
    pub fn preset(sensor: &str, preset: &str) -> Result<Self, Error> {
        let base = Self::find(sensor)?;
        let Some(main) = builtin(&format!("{sensor}-{preset}")) else {
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

    /// All that it is read from.
    fn sensor_text(&self) -> SensorText<'_> {
        let SourceText { file, text: yaml } = &self.main;
        SensorText { file, yaml, bases: &self.bases, user: self.user.as_ref() }
    }

    /// The files that the sensor's extends.
    pub fn bases(&self) -> &[BaseFile] {
        &self.bases
    }

    /// The sensor's own file.
    pub fn text(&self) -> &SourceText {
        &self.main
    }

    /// Every file that problems may lie in: the sensor's own first.
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

    /// Builds a unit of the sensor: made parts and layers off by what is permissible, camera and lamps as it has them.
    /// Parameters and fixtures are the drawing's.
    ///
    /// # Errors
    /// All problems of the design.
    pub fn unit(&self, unit: Unit, overrides: &[String]) -> Result<Project, Error> {
        let drawn = self.load(overrides)?;
        let off = |path: &str| unit.off(path);
        let built = designs::built::as_built(self.sensor_text(), overrides, &[fixtures::KEY], &off);
        let (built, dimensions) = built.map_err(|invalid| self.invalid(invalid))?;
        let mut sensor = built.sensor;
        unit.build(&mut sensor);
        Ok(drawn.into_unit(unit.0, sensor, dimensions))
    }

    /// The fewest and least changes of what fabkit has chosen with which the sensor can be built.
    ///
    /// # Errors
    /// What cannot be read, or which rules contradict each other.
    pub fn fix(&self, overrides: &[String]) -> Result<Vec<Change>, Error> {
        fixing::fix(self.sensor_text(), overrides, &[fixtures::KEY])
            .map_err(|invalid| self.invalid(invalid))
    }

    /// How far each number of the sensor can go; with `follow` also where chosen values may follow.
    ///
    /// # Errors
    /// All problems of the design.
    pub fn limits(
        &self,
        overrides: &[String],
        follow: bool,
        progress: OnProgress,
    ) -> Result<Vec<Feasible>, Error> {
        let progress = counted(progress);
        let others = [fixtures::KEY];
        fixing::limits(self.sensor_text(), overrides, &others, follow, &|done, all| {
            progress(done, all);
        })
        .map_err(|invalid| self.invalid(invalid))
    }

    /// Why a fixture cannot be had, with the texts that are to blame.
    pub fn error(&self, error: FixtureError) -> Error {
        match error {
            FixtureError::Invalid(invalid) => self.invalid(invalid),
            other => SourceError::Fixture(other).into(),
        }
    }

    fn invalid(&self, invalid: InvalidDesign) -> Error {
        Diagnosed::new(invalid, self.texts().cloned()).into()
    }
}

/// Reads the files that a file extends, one through the other. A circle, or more of them than may be,
/// ends there: what is wrong with them is told where they are read.
fn extended_files(main: &SourceText) -> Result<Vec<BaseFile>, Error> {
    /// One more than may be.
    const MOST: usize = 17;
    let mut bases: Vec<BaseFile> = Vec::new();
    let real = |file: &str| real_path(Path::new(file));
    let mut known = vec![(real(&main.file), main.file.clone())];
    let mut last = main.clone();
    while bases.len() < MOST
        && let Some(Extends { word, line }) = designs::extended_file(&last.text)
    {
        let folder = Path::new(&last.file).parent().unwrap_or(Path::new(""));
        let file = folder.join(&word).display().to_string();
        let by = last.file.clone();
        // Under the name that it has already, however it is spelled here.
        let place = real(&file);
        if let Some((_, file)) = known.iter().find(|(known, _)| *known == place) {
            bases.push(BaseFile { by, word, file: file.clone(), text: String::new() });
            break;
        }
        let text = reading::read_text(Path::new(&file), EXPECTED).map_err(|why| {
            let (file, word, why) = (by.clone(), word.clone(), Box::new(why));
            SourceError::Extended { file, line, word, why }
        })?;
        known.push((place, file.clone()));
        bases.push(BaseFile { by, word, file: file.clone(), text: text.clone() });
        last = SourceText { file, text };
    }
    Ok(bases)
}

/// Why a press of a sensor cannot be had; `sensor` is a name or a path, whose texts may be to blame.
pub fn press_error(sensor: &str, error: PressError) -> Error {
    match error {
        PressError::Fixture(error) => match Source::find(sensor) {
            Ok(source) => source.error(error),
            Err(error) => error,
        },
        PressError::Surface(_) => Error::bug(error),
        other => SceneError::Press(other).into(),
    }
}

/// The text of a built-in sensor, named as the designs crate names it in messages.
fn builtin(name: &str) -> Option<SourceText> {
    let text = designs::builtin_yaml(name)?;
    Some(SourceText { file: format!("{name}.yaml (built-in)"), text: text.into() })
}

const EXPECTED: Expected = Expected {
    what: "a sensor's file",
    max_bytes: MAX_YAML_BYTES,
    hint: "is it the right file? `fabkit show rtac0` shows what one holds",
};

fn read_yaml(path: &Path) -> Result<String, Error> {
    Ok(reading::read_text(path, EXPECTED)?)
}

#[cfg(test)]
mod tests {
    use fabkit_geometry::Pose;

    use super::*;

    #[test]
    fn a_fixture_and_a_part_follow_a_name_or_a_path() {
        let split = |text| {
            let Target { sensor, fixture, part, .. } = Target::new(text);
            (sensor, fixture, part)
        };
        assert_eq!(split("rtac0"), ("rtac0", None, None));
        assert_eq!(split("rtac0/shell"), ("rtac0", None, Some("shell")));
        assert_eq!(split("rtac0/indenters"), ("rtac0", Some("indenters"), None));
        let part = ("rtac0", Some("indenters"), Some("hemisphere"));
        assert_eq!(split("rtac0/indenters/hemisphere"), part);
        assert_eq!(split("a/b/my.yaml"), ("a/b/my.yaml", None, None));
        assert_eq!(split("a/b/my.yaml/shell"), ("a/b/my.yaml", None, Some("shell")));
        assert_eq!(split("./my.yml/indenters"), ("./my.yml", Some("indenters"), None));
        assert_eq!(split("/shell"), ("/shell", None, None));
    }

    #[test]
    fn fixtures_press_where_the_drawing_puts_them_and_places_are_the_units_own() {
        let source = Source::find("rtac0").unwrap();
        let (drawn, unit) = (source.load(&[]).unwrap(), source.unit(Unit(3), &[]).unwrap());
        assert!(drawn.design.sensor.touch != unit.design.sensor.touch);
        let placed = |project: &Project, id: &str| -> Vec<Pose> {
            project.press(id).unwrap().bodies.iter().map(|body| body.sensor_from_body).collect()
        };
        for id in ["pin-1-long", "semi-dome-017"] {
            assert_eq!(placed(&drawn, id), placed(&unit, id), "{id}");
        }
        let id = "ball@24deg,120deg,0.5mm";
        assert_ne!(placed(&drawn, id), placed(&unit, id));
        let hash = |project: &Project| fabkit_designs::design_hash(&project.design);
        assert_eq!(hash(&drawn), hash(&unit));
    }
}
