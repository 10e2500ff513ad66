//! Which parts are made how: `processes:` and `parts:` of files, read and applied.

use fabkit_geometry::{Kind, Machine, Sensor};
use fabkit_text::{
    Dialect, Entry, Found, Place, Reading, Setting, Source, SourceKind, join, shown,
};

use super::making::fits;
use super::{Making, ProcessFigures, ProcessKind, Recipe};
use crate::own::named::{Layered, Noun, Raw, given_name, key_of, near, read, taken};

/// Processes in files.
pub(crate) const PROCESSES: Noun = Noun {
    key: "processes",
    dialect: &Dialect::new("process", 1, ", then `processes:` and names with sections"),
};

/// The key with what is said of parts.
pub(crate) const PARTS: &str = "parts";

/// Most materials of one process.
const MOST_MATERIALS: usize = 32;

/// What a file gives to parts.
#[derive(Clone, Debug)]
struct Given {
    pattern: String,
    place: Place,
    recipe: Option<Recipe>,
    material: Option<String>,
}

/// What files say of processes and parts.
#[derive(Clone, Debug, Default)]
pub(crate) struct Processes {
    recipes: Vec<(Recipe, Vec<Setting>)>,
    given: Vec<Given>,
}

impl Processes {
    /// Reads what files say; the later ones lie over the earlier ones.
    pub fn read(raws: Vec<Raw>, parts: Vec<(Place, Entry)>, found: &mut Vec<Found>) -> Self {
        let layered = Layered::new(&raws);
        let recipe = |(key, said): (&String, &[&Raw])| recipe(&layered, key, said, found);
        let recipes = layered.iter().filter_map(recipe).collect();
        let mut all = Self { recipes, given: Vec::new() };
        for (place, entry) in parts {
            let mut reading = Reading::new(place.clone());
            for part in reading.map(PARTS, &entry.value).to_vec() {
                all.part(&mut reading, part);
            }
            found.extend(reading.found);
        }
        all
    }

    /// `parts.PATTERN.process=WORD` of the command line; whether it was one.
    pub fn set(&mut self, text: &str, place: &Place, found: &mut Vec<Found>) -> bool {
        let Some((path, value)) = text.split_once('=') else { return false };
        let Some(rest) = path.trim().strip_prefix("parts.") else { return false };
        let Some((pattern, key)) = rest.rsplit_once('.') else { return false };
        let mut reading = Reading::new(place.clone());
        let mut given =
            Given { pattern: pattern.into(), place: place.clone(), recipe: None, material: None };
        self.key(&mut reading, &mut given, key, path.trim(), value.trim(), place);
        found.extend(reading.found);
        self.given.push(given);
        true
    }

    fn part(&mut self, reading: &mut Reading, entry: Entry) {
        let path = join(PARTS, &shown(&entry.key));
        let place = reading.place.at(entry.key_position);
        let mut given =
            Given { pattern: entry.key.trim().into(), place, recipe: None, material: None };
        for inner in reading.map(&path, &entry.value).to_vec() {
            let path = join(&path, &shown(&inner.key));
            let Some(text) = reading.scalar(&path, &inner.value) else { continue };
            let key_place = reading.place.at(inner.key_position);
            let at = if matches!(&*inner.key, "process" | "material") {
                reading.place.at(inner.value.position)
            } else {
                key_place
            };
            self.key(reading, &mut given, &inner.key, &path, text, &at);
        }
        self.given.push(given);
    }

    fn key(
        &self,
        reading: &mut Reading,
        given: &mut Given,
        key: &str,
        path: &str,
        text: &str,
        at: &Place,
    ) {
        match key {
            "process" => match self.recipe(text) {
                Some(recipe) => given.recipe = Some(recipe),
                None => {
                    let names = self.names();
                    let message = format!("{path} is `{}`, which is no known process", shown(text));
                    let did = match &near(text, names.iter().map(String::as_str))[..] {
                        [] => String::new(),
                        near => format!("{} ", fabkit_text::did_you_mean(near)),
                    };
                    let hint = format!(
                        "{did}known are {}; or declare your own: `processes: {{{}: {{kind: fdm}}}}`",
                        names.join(", "),
                        shown(text)
                    );
                    reading.found.push(at.problem(path, &shown(text), message).hint(hint));
                }
            },
            "material" => {
                let value = given_name(text, at, path, &mut reading.found);
                given.material = value;
            }
            _ => {
                let message = format!("`{}` is not a key of a part", shown(key));
                let hint = fabkit_text::suggestion(key, ["process", "material"], "the keys are");
                reading.found.push(at.problem(path, &shown(key), message).hint(hint));
            }
        }
    }

    fn names(&self) -> Vec<String> {
        let own = self.recipes.iter().map(|(recipe, _)| recipe.name.clone());
        let kinds = ProcessKind::WORDS.iter().map(|word| (*word).to_owned());
        let mut names: Vec<String> = own.chain(kinds).collect();
        let mut seen = std::collections::BTreeSet::new();
        names.retain(|name| seen.insert(key_of(name)));
        names
    }

    fn recipe(&self, name: &str) -> Option<Recipe> {
        let key = key_of(name);
        let own = self.recipes.iter().find(|(recipe, _)| key_of(&recipe.name) == key);
        if let Some((recipe, _)) = own {
            return Some(recipe.clone());
        }
        let kind = ProcessKind::ALL.into_iter().find(|kind| kind.word() == key)?;
        let name = kind.word().to_owned();
        Some(Recipe { name, kind, figures: None, materials: Vec::new() })
    }

    /// For those who cut fits.
    pub fn making(&self) -> Making {
        let is_of_kind = |recipe: &&Recipe| recipe.kind.word() == key_of(&recipe.name);
        let recipes = self.recipes.iter().map(|(recipe, _)| recipe);
        let of_kind = recipes.filter(is_of_kind).cloned().collect();
        let of_parts =
            self.given.iter().filter_map(|g| Some((g.pattern.clone(), g.recipe.clone()?)));
        Making::new(of_kind, of_parts.collect())
    }

    /// What is made follows from these.
    pub fn settings(&self) -> Vec<Setting> {
        // Of machines that no part is made on, nothing follows.
        let is_given = |recipe: &Recipe| {
            let given = self.given.iter().filter_map(|given| given.recipe.as_ref());
            recipe.kind.word() == key_of(&recipe.name) || given.into_iter().any(|g| g == recipe)
        };
        let used = self.recipes.iter().filter(|(recipe, _)| is_given(recipe));
        let own = used.flat_map(|(_, settings)| settings.iter().cloned());
        let given = self.given.iter().flat_map(|given| {
            let path = join(PARTS, &given.pattern);
            let of = |key: &str, value: Option<String>, summary: &str| {
                Some(Setting {
                    path: join(&path, key),
                    value: value?,
                    kind: fabkit_text::Kind::Text,
                    source: Source { kind: SourceKind::User, note: String::new() },
                    summary: summary.into(),
                    limits: String::new(),
                    expression: None,
                    is_default: false,
                    bounds: None,
                    choices: Vec::new(),
                })
            };
            let process = given.recipe.as_ref().map(|recipe| recipe.name.clone());
            [
                of("process", process, "How these parts are made."),
                of("material", given.material.clone(), "What these parts are made from."),
            ]
        });
        own.chain(given.flatten()).collect()
    }
}

/// One process; `None` after reporting what is wrong with it.
fn recipe(
    layered: &Layered,
    key: &str,
    said: &[&Raw],
    found: &mut Vec<Found>,
) -> Option<(Recipe, Vec<Setting>)> {
    let (first, last) = (said.first()?, said.last()?);
    let name = first.name.clone();
    let before = found.len();
    let mut stack = layered.stack(PROCESSES, key, found)?;
    let path = join(PROCESSES.key, &shown(&name));
    let mut materials = Vec::new();
    for (place, entries) in &mut stack {
        let Some(node) = taken(entries, "materials") else { continue };
        let mut reading = Reading::new(place.clone());
        let path = join(&path, "materials");
        let items = reading.list(&path, &node);
        materials = items
            .iter()
            .take(MOST_MATERIALS)
            .filter_map(|item| Some(reading.scalar(&path, item)?.to_owned()))
            .collect();
        found.extend(reading.found);
    }
    let figures = read::<ProcessFigures>(PROCESSES, &name, &last.place, stack, found);
    let (figures, settings) = figures.filter(|_| found.len() == before)?;
    let named = ProcessKind::ALL.into_iter().find(|kind| kind.word() == key);
    let Some(kind) = figures.kind.or(named) else {
        let message = format!("{} lacks `kind`", shown(&name));
        let hint = format!("write `kind: ` and one of {}", ProcessKind::WORDS.join(", "));
        found.push(last.place.problem(&join(&path, "kind"), "", message).hint(hint));
        return None;
    };
    Some((Recipe { name, kind, figures: Some(figures), materials }, settings))
}

/// Gives parts their processes, with what to mind; what cannot be is reported.
pub(crate) fn assign(
    sensor: &mut Sensor,
    processes: &Processes,
    making: &Making,
    found: &mut Vec<Found>,
) {
    let names: Vec<String> = sensor.parts().map(|part| part.name.clone()).collect();
    for given in &processes.given {
        if names.iter().any(|name| fits(&given.pattern, name)) {
            continue;
        }
        let path = join(PARTS, &shown(&given.pattern));
        let near = near(&given.pattern, names.iter().map(String::as_str));
        let stem = format!("{}-", given.pattern);
        let did = match near.is_empty() {
            _ if names.iter().any(|name| name.starts_with(&stem)) => {
                format!("did you mean `{stem}*`? ")
            }
            true => String::new(),
            false => format!("{} ", fabkit_text::did_you_mean(&near)),
        };
        let message = format!("{path} names none of the sensor's parts");
        let hint = format!("{did}the parts are {}; `*` stands for anything", names.join(", "));
        found.push(given.place.problem(&path, &shown(&given.pattern), message).hint(hint));
    }
    for part in &mut sensor.bodies {
        let Kind::Made(usual) = part.kind else { continue };
        let named = processes.given.iter().rev().filter(|given| fits(&given.pattern, &part.name));
        let material = named.clone().find_map(|given| given.material.clone());
        let place = named.clone().find(|given| given.recipe.is_some());
        match making.of(&part.name) {
            Some(recipe) => {
                let process = recipe.kind.process();
                if let Some(why) = refused(usual, recipe.kind)
                    && let Some(place) = place
                {
                    let path = join(&join(PARTS, &shown(&place.pattern)), "process");
                    let message = format!("{} cannot be made by {}: {why}", part.name, recipe.name);
                    let hint = format!("it is made by {usual}; leave it out of the pattern");
                    found.push(place.place.problem(&path, &recipe.name, message).hint(hint));
                    continue;
                }
                part.kind = Kind::Made(process);
                let suits = |material: &String| {
                    recipe.materials.iter().any(|known| key_of(known) == key_of(material))
                };
                let implied = recipe.materials.first().cloned().or_else(|| {
                    recipe.kind.usual_material().filter(|_| process != usual).map(str::to_owned)
                });
                let is_missing = recipe.materials.is_empty() || !suits(&part.material);
                let old = part.material.clone();
                if let Some(new) = material.or(implied.filter(|_| is_missing)) {
                    part.material = new;
                }
                let mut note = format!("made by {}", recipe.name);
                if recipe.name != recipe.kind.word() {
                    note += &format!(" ({})", recipe.kind.word());
                }
                note += &match recipe.figures.as_ref().and_then(|figures| figures.layer_height) {
                    Some(height) => format!(" in layers of {height}"),
                    None => String::new(),
                };
                if process != usual {
                    note += &format!(", usually by {usual}");
                }
                if part.material != old {
                    note += &format!("; from {} in place of {old}", part.material);
                }
                if process != usual && !making.is_asked() {
                    note += &format!("; its fits are those of {usual}");
                }
                part.machine = Some(Machine { note: note.clone(), ..recipe.machine() });
                part.notes.insert(0, note);
                part.notes.extend(recipe.figures.as_ref().and_then(|f| f.note.clone()));
            }
            None => {
                part.machine = making.of_kind(usual).map(Recipe::machine);
                if let Some(material) = material {
                    part.material = material;
                }
            }
        }
    }
    // Parts of one piece leave one machine.
    for group in &sensor.print_groups {
        let mut made = sensor.bodies.iter().filter(|body| group.parts.contains(&body.name));
        let Some(first) = made.next() else { continue };
        let Some(other) = made.find(|other| other.kind != first.kind) else { continue };
        let message = format!(
            "{} is made by {} and {} by {}, but they are printed as one piece",
            first.name,
            first.process_word(),
            other.name,
            other.process_word()
        );
        let given = processes
            .given
            .iter()
            .find(|given| group.parts.iter().any(|p| fits(&given.pattern, p)));
        let Some(given) = given else { continue };
        let hint = format!("give {} the same process", group.parts.join(", "));
        found.push(given.place.problem(PARTS, &given.pattern, message).hint(hint));
    }
}

/// Why a part that is usually made in one way cannot be made in another.
fn refused(usual: fabkit_geometry::Process, kind: ProcessKind) -> Option<&'static str> {
    use fabkit_geometry::Process::{Cast, Laser, Pcb};
    match (usual, kind) {
        (Pcb, _) => Some("it is a circuit board"),
        (Cast, _) => Some("it is cast"),
        (Laser, _) => None,
        (_, ProcessKind::Laser) => Some("it is no flat sheet"),
        _ => None,
    }
}
