//! Patterns of a data set: the sensor's semi-domes, or the list in a text file.

use fabkit_fixtures::{Press, PressError, PressFinder, Project};
use fabkit_geometry::Length;
use fabkit_scene::unknown_press_hint;
use fabkit_text::{Position, YamlFault, to_printable};

/// Largest number of patterns: each half is cast and each pair stitched, which makes a million samples.
pub const MAX_PATTERNS: usize = 1000;
/// Largest number of bodies in a pattern: labels are bytes, of which 0 and 1 are taken.
pub const MAX_BODIES: usize = 254;
const MAX_NAME: usize = 64;

/// Form of a line, for messages.
const FORM: &str = "a line is `NAME = ID + ID`, or an ID alone, and may end in `shear 0.5mm,0mm`";
/// Word before the lengths by which bodies move along the surface.
const SHEAR: &str = " shear ";
/// Largest shear, mm: no sensor's surface is larger.
const MAX_SHEAR_MM: f64 = 50.0;

/// Reason why there are no patterns.
#[derive(Debug, thiserror::Error)]
pub enum PatternsError {
    /// The sensor's own presses cannot be made.
    #[error(transparent)]
    Press(#[from] PressError),
    /// The sensor has no halves.
    #[error("{sensor} has neither semi-domes nor half-plates")]
    NoSemiDomes {
        /// Name of the sensor.
        sensor: String,
    },
}

/// Pattern on the left side, as a list of presses.
#[derive(Clone, Debug)]
pub struct NamedPresses {
    /// Name, for example `semi-dome-017`.
    pub name: String,
    /// Presses of the pattern.
    pub presses: Vec<Press>,
    /// Subsequent motion of all bodies along the surface, mm: on a dome away from the tip and around it at the deepest
    /// point, on a pad along x and y.
    pub shear_mm: [f64; 2],
}

/// Returns all presses of the sensor that are halves, as patterns.
///
/// # Errors
/// Fails if the sensor has no halves, or if they cannot be made.
pub fn semi_domes(project: &Project) -> Result<Vec<NamedPresses>, PatternsError> {
    let (mut presses, mut failed) = (Vec::new(), None);
    for of_fixture in project.presses() {
        match of_fixture {
            Ok(of_fixture) => presses.extend(of_fixture.into_iter().filter(|p| p.is_left_half)),
            Err(error) => failed = failed.or(Some(error)),
        }
    }
    if presses.is_empty() {
        // Perhaps the semi-domes are the fixtures that cannot be made.
        if let Some(error) = failed {
            return Err(PressError::from(error).into());
        }
        return Err(PatternsError::NoSemiDomes { sensor: project.design.sensor.name.clone() });
    }
    let named = |press: Press| NamedPresses {
        name: press.id.clone(),
        presses: vec![press],
        shear_mm: [0.0; 2],
    };
    Ok(presses.into_iter().map(named).collect())
}

/// Reads a list of patterns: one pattern a line, `NAME = ID + ID` or an ID alone; `#` starts a comment.
///
/// # Errors
/// Returns all problems.
///
/// ```
/// use fabkit_dataset::read_patterns;
///
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// let text = "
/// ## two on the left at once, and one that then slides
/// pair = hemisphere@30deg,150deg,1mm + ball@30deg,210deg,1mm
/// slid = ball@30deg,180deg,1mm shear 0.5mm,0mm
/// ";
/// let patterns = read_patterns(text, &project).map_err(|faults| format!("{faults:?}"))?;
/// assert_eq!((&*patterns[0].name, patterns[0].presses.len()), ("pair", 2));
/// assert_eq!(patterns[1].shear_mm, [0.5, 0.0]);
/// // Every fault is told with its line.
/// let faults = read_patterns("bull@30deg,180deg,1mm\nx = nothing", &project).unwrap_err();
/// assert_eq!(faults.len(), 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read(text: &str, project: &Project) -> Result<Vec<NamedPresses>, Vec<YamlFault>> {
    let mut faults = Vec::new();
    let mut patterns: Vec<NamedPresses> = Vec::new();
    let finder = project.press_finder();
    for (line, content) in (1..).zip(text.lines()) {
        let content = content.split('#').next().unwrap_or_default().trim_end();
        // Faults point to the first character that is not a space.
        let column = 1 + content.chars().take_while(|c| c.is_whitespace()).count();
        let content = content.trim_start();
        if content.is_empty() {
            continue;
        }
        let mut fault = |message: String, hint: String| {
            let fault = YamlFault::new(Position { line, column }, "", message).hint(hint);
            faults.push(YamlFault { written: to_printable(content), ..fault });
        };
        match pattern(content, &finder) {
            Ok(found) if patterns.iter().any(|other| other.name == found.name) => {
                let message = format!("there is a pattern `{}` already", found.name);
                fault(message, "give it another name".into());
            }
            Ok(found) => patterns.push(found),
            Err((message, hint)) => fault(message, hint),
        }
    }
    let count = patterns.len();
    if faults.is_empty() && !(1..=MAX_PATTERNS).contains(&count) {
        let message = format!("{count} patterns; there must be 1 to {MAX_PATTERNS}");
        faults.push(YamlFault::new(None, "", message).hint(FORM));
    }
    if faults.is_empty() { Ok(patterns) } else { Err(faults) }
}

/// Problem, and advice.
type Problem = (String, String);

/// Parses a line of the list.
fn pattern(content: &str, finder: &PressFinder) -> Result<NamedPresses, Problem> {
    let (name, ids) = match content.split_once('=') {
        Some((name, ids)) => (name.trim(), ids),
        None => (content.split(SHEAR).next().unwrap_or_default().trim(), content),
    };
    let (ids, shear_mm) = match ids.split_once(SHEAR) {
        Some((ids, lengths)) => (ids, parse_shear(lengths)?),
        None => (ids, [0.0; 2]),
    };
    let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    if name.is_empty() || name.len() > MAX_NAME || !name.chars().all(is_plain) {
        let message = format!("`{name}` cannot name files");
        let hint = format!(
            "write `NAME = {}`; a name has 1 to {MAX_NAME} letters, digits, `-`, `_`, `.`",
            ids.trim()
        );
        return Err((message, hint));
    }
    let press = |id: &str| {
        finder.press(id).map_err(|error| {
            let hint = match &error {
                PressError::Unknown { id, known, place } => unknown_press_hint(id, known, place),
                _ => FORM.into(),
            };
            (error.to_string(), hint)
        })
    };
    let presses: Vec<Press> =
        ids.split('+').map(|id| press(id.trim())).collect::<Result<_, _>>()?;
    let bodies: usize = presses.iter().map(|press| press.bodies.len()).sum();
    if bodies > MAX_BODIES {
        let message = format!("`{name}` has {bodies} bodies; {MAX_BODIES} are possible");
        return Err((message, "make two patterns of it".into()));
    }
    Ok(NamedPresses { name: name.into(), presses, shear_mm })
}

/// Reads two lengths, mm.
fn parse_shear(text: &str) -> Result<[f64; 2], Problem> {
    let length = |text: &str| text.trim().parse::<Length>().ok().map(Length::mm);
    let lengths = text.split_once(',').and_then(|(a, b)| Some([length(a)?, length(b)?]));
    match lengths.filter(|[a, b]| a.hypot(*b) <= MAX_SHEAR_MM) {
        Some(lengths) => Ok(lengths),
        None => {
            let message = format!("`{}` is no way along the surface", text.trim());
            Err((message, format!("write two lengths up to {MAX_SHEAR_MM} mm: `shear 0.5mm,0mm`")))
        }
    }
}

impl NamedPresses {
    /// Returns the presses on the left, and after half a turn about z on the right.
    pub(super) fn sides(&self) -> [Vec<Press>; 2] {
        [self.presses.clone(), self.presses.iter().cloned().map(Press::flipped).collect()]
    }
}

/// Computes a BLAKE3 hash, in hex, over every solid and its pose.
///
/// # Panics
/// Never: solids and poses are JSON.
pub fn hash_patterns(patterns: &[NamedPresses]) -> String {
    let mut hasher = blake3::Hasher::new();
    for pattern in patterns {
        hasher.update(pattern.name.as_bytes());
        for body in pattern.presses.iter().flat_map(|press| &press.bodies) {
            let json = serde_json::to_vec(&(&body.name, &body.solid, &body.sensor_from_body));
            hasher.update(&json.expect("solids and poses are JSON"));
        }
        // A pattern without shear is hashed by its presses alone.
        if pattern.shear_mm != [0.0; 2] {
            hasher.update(format!("{:?}", pattern.shear_mm).as_bytes());
        }
        hasher.update(b"\n");
    }
    hasher.finalize().to_hex().to_string()
}
