//! What users add of their own, in a sensor's file or in one for all of their sensors.

mod known;
pub(crate) mod named;
mod schema;

use fabkit_text::{
    Dialect, Entry, Found, OVERRIDES, Place, Setting, TextLayer, check_format, mapping_of, shown,
    suggestion,
};

use crate::buying::{Articles, BUYING};
use crate::materials::{Castable, Catalogue, MATERIALS};
use crate::processes::{PARTS, PROCESSES, Processes};

pub(crate) use known::Known;
use named::{Noun, Raw, raws};
pub(crate) use schema::add_to_schema;

/// A file with what a user keeps for all sensors: materials, processes and what to buy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UserFile {
    /// Its name in messages.
    pub file: String,
    /// Its text.
    pub text: String,
}

/// The user's file.
const USER: Dialect = Dialect::new("materials", 1, ", then `materials:`, `processes:` or `buy:`");

/// Keys of the user's file.
const USER_KEYS: [&str; 3] = [MATERIALS.key, PROCESSES.key, BUYING.key];

/// What files say beside the parameters of a family.
#[derive(Clone, Debug)]
pub(crate) struct Own {
    /// Every material that may be named.
    pub materials: Catalogue,
    /// What is said of processes and of parts.
    pub processes: Processes,
    /// Everything that may be bought.
    pub articles: Articles,
}

impl Own {
    /// Takes its sections out of the layers of a sensor, the sensor's own file first among them; what
    /// is wrong is reported.
    pub fn take(
        layers: &mut [(Place, Vec<Entry>)],
        user: Option<&UserFile>,
        found: &mut Vec<Found>,
    ) -> Self {
        let (mut materials, mut processes, mut parts) = (Vec::new(), Vec::new(), Vec::new());
        let mut buying = Vec::new();
        if let Some((place, mut entries)) = user_entries(user, found) {
            take_raws(MATERIALS, &mut entries, &place, &mut materials, found);
            take_raws(PROCESSES, &mut entries, &place, &mut processes, found);
            take_raws(BUYING, &mut entries, &place, &mut buying, found);
        }
        for (place, entries) in layers.iter_mut().rev() {
            take_raws(MATERIALS, entries, place, &mut materials, found);
            take_raws(PROCESSES, entries, place, &mut processes, found);
            take_raws(BUYING, entries, place, &mut buying, found);
            if let Some(at) = entries.iter().position(|entry| entry.key == PARTS) {
                parts.push((place.clone(), entries.remove(at)));
            }
        }
        Self {
            materials: Catalogue::builtin().with(materials, found),
            processes: Processes::read(processes, parts, found),
            articles: Articles::builtin().with(buying, found),
        }
    }

    /// Takes what the command line says of parts out of the overrides.
    pub fn take_overrides(&mut self, overrides: &[String], found: &mut Vec<Found>) -> Vec<String> {
        let place = Place::new(TextLayer::Override, OVERRIDES, &USER);
        let mut rest = overrides.to_vec();
        rest.retain(|text| !self.processes.set(text, &place, found));
        rest
    }

    /// What parameters are read with.
    pub fn known(&self) -> Known {
        Known { materials: self.materials.clone(), making: self.processes.making() }
    }

    /// Every figure of what is used and not as it is built in, as further parameters: what is made
    /// follows from them. `parts` are the names of what is made.
    pub fn settings(&self, materials: &[Castable], parts: &[String]) -> Vec<Setting> {
        let own = materials.iter().filter(|castable| !castable.material().is_builtin());
        let own = own.flat_map(|castable| castable.material().settings.clone());
        own.chain(self.processes.settings(parts)).collect()
    }

    /// The materials that parameters name, in their order.
    pub fn used(&self, parameters: &[Setting]) -> Vec<Castable> {
        let mut used: Vec<Castable> = Vec::new();
        for setting in parameters {
            let found = self.materials.find(&setting.value);
            let is_new = |castable: &&Castable| !used.contains(castable);
            used.extend(found.filter(is_new).cloned());
        }
        used
    }
}

fn user_entries(user: Option<&UserFile>, found: &mut Vec<Found>) -> Option<(Place, Vec<Entry>)> {
    let UserFile { file, text } = user?;
    let place = Place::new(TextLayer::Base, file, &USER);
    let mut entries = mapping_of(text, &place, found)?;
    check_format(&mut entries, &place, found);
    entries.retain(|Entry { key, key_position, .. }| {
        let is_known = USER_KEYS.contains(&&**key);
        if !is_known {
            let message = format!("`{}` is not a key of a materials file", shown(key));
            let hint = suggestion(key, USER_KEYS, "the keys are");
            found.push(place.at(*key_position).problem(&shown(key), "", message).hint(hint));
        }
        is_known
    });
    Some((place, entries))
}

fn take_raws(
    noun: Noun,
    entries: &mut Vec<Entry>,
    place: &Place,
    all: &mut Vec<Raw>,
    found: &mut Vec<Found>,
) {
    if let Some(at) = entries.iter().position(|entry| entry.key == noun.key) {
        all.extend(raws(noun, entries.remove(at), place, found));
    }
}
