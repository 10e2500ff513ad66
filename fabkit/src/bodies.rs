//! Parts, layers and components seen as one list of bodies.

use fabkit_geometry::{Color, Landmark, Placement, Pose, Process, Sensor, Shells, Solid};

/// Which list of the sensor a body comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Made from a file.
    Part,
    /// Poured or sprayed.
    Layer,
    /// Bought.
    Component,
}

impl Kind {
    /// The word used in files and on the command line.
    pub fn word(self) -> &'static str {
        match self {
            Self::Part => "part",
            Self::Layer => "layer",
            Self::Component => "component",
        }
    }
}

/// What parts, layers and components have in common.
#[derive(Clone, Copy, Debug)]
pub struct BodyRef<'a> {
    /// Its list.
    pub kind: Kind,
    /// Unique within the sensor.
    pub name: &'a str,
    /// One line for people.
    pub summary: &'a str,
    /// Its shape in its own frame, mm.
    pub solid: &'a Solid,
    /// Where it is used.
    pub placements: &'a [Placement],
    /// How it is made; nothing for what is bought.
    pub process: Option<Process>,
    /// From what; empty for what is bought.
    pub material: &'a str,
    /// How many a lab needs.
    pub quantity: u32,
    /// Points others rely on.
    pub landmarks: &'a [Landmark],
    /// For pictures.
    pub color: Color,
    /// 0 to 1.
    pub opacity: f64,
    /// How it lies on the bed; the identity for what is not printed.
    pub bed_from_part: Pose,
    /// Linear shrinkage that exported copies make up for; 0 for everything but molds.
    pub shrinkage: f64,
    /// Through holes and handles, where the design counts them.
    pub genus: Option<i32>,
    /// Pieces and cavities, where the design counts them.
    pub shells: Option<Shells>,
    /// What the person at the printer or cutter should know.
    pub notes: &'a [String],
}

impl BodyRef<'_> {
    /// How it is made, for example `fdm`; empty for what is bought.
    pub fn process_word(&self) -> String {
        self.process.map(|process| process.to_string()).unwrap_or_default()
    }
}

/// All bodies of a sensor: parts, then layers, then components, each in the design's order.
pub fn bodies(sensor: &Sensor) -> Vec<BodyRef<'_>> {
    let parts = sensor.parts.iter().map(|part| BodyRef {
        kind: Kind::Part,
        name: &part.name,
        summary: &part.summary,
        solid: &part.solid,
        placements: &part.placements,
        process: Some(part.process),
        material: &part.material,
        quantity: part.quantity,
        landmarks: &part.landmarks,
        color: part.color,
        opacity: 1.0,
        bed_from_part: part.bed_from_part,
        shrinkage: part.shrinkage,
        genus: Some(part.genus),
        shells: Some(part.shells),
        notes: &part.print_notes,
    });
    let layers = sensor.layers.iter().map(|layer| BodyRef {
        kind: Kind::Layer,
        name: &layer.name,
        summary: &layer.summary,
        solid: &layer.solid,
        placements: &layer.placements,
        process: Some(Process::Cast),
        material: &layer.material,
        quantity: 1,
        landmarks: &[],
        color: layer.color,
        opacity: layer.opacity,
        bed_from_part: Pose::identity(),
        shrinkage: 0.0,
        genus: Some(layer.genus),
        shells: Some(layer.shells),
        notes: &[],
    });
    let components = sensor.components.iter().map(|component| BodyRef {
        kind: Kind::Component,
        name: &component.name,
        summary: &component.specification,
        solid: &component.solid,
        placements: &component.placements,
        process: None,
        material: "",
        quantity: component.quantity,
        landmarks: &[],
        color: component.color,
        opacity: component.opacity,
        bed_from_part: Pose::identity(),
        shrinkage: 0.0,
        genus: None,
        shells: None,
        notes: &[],
    });
    parts.chain(layers).chain(components).collect()
}

/// A name that is not there.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no {what} `{name}`")]
pub struct UnknownName {
    /// What was looked for, for example `part`.
    pub what: &'static str,
    /// The name asked for.
    pub name: String,
    /// What would have been found, in order.
    pub known: Vec<String>,
    /// The known name that is closest, if any is close.
    pub closest: Option<String>,
}

impl UnknownName {
    /// Names what is there, and finds what may have been meant.
    pub fn new<'a>(
        what: &'static str,
        name: &str,
        known: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        let known: Vec<String> = known.into_iter().map(str::to_owned).collect();
        let similar = fabkit_text::similar(name, known.iter().map(String::as_str));
        let closest = similar.first().map(|known| (*known).to_owned());
        Self { what, name: name.into(), known, closest }
    }

    /// What to do about it.
    pub fn hint(&self) -> String {
        match &self.closest {
            Some(closest) => fabkit_text::did_you_mean(&[closest]),
            None => format!("known: {}", self.known.join(", ")),
        }
    }
}

/// The body of that name.
///
/// # Errors
/// [`UnknownName`] with the names that there are.
pub fn find<'a>(sensor: &'a Sensor, name: &str) -> Result<BodyRef<'a>, UnknownName> {
    let all = bodies(sensor);
    match all.iter().find(|body| body.name == name) {
        Some(body) => Ok(*body),
        None => Err(UnknownName::new("part", name, all.iter().map(|body| body.name))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_typo_gets_a_suggestion_and_another_word_the_list() {
        let unknown = |name| UnknownName::new("part", name, ["base", "shell", "diffuser"]);
        assert_eq!(unknown("shel").hint(), "did you mean `shell`?");
        assert_eq!(unknown("difuser").hint(), "did you mean `diffuser`?");
        assert_eq!(unknown("xyzzy").hint(), "known: base, shell, diffuser");
        assert_eq!(unknown("shel").to_string(), "there is no part `shel`");
    }
}
