//! What cast layers are to hold to: primers go into the chain and onto the list of what to buy, and
//! what does not stick is noted for the checks.

use fabkit_geometry::{Action, Assembly, Body, Loose, Order, Sensor, Solid, in_order};
use fabkit_text::{Report, Setting, shown};

use super::catalogue::Catalogue;
use super::{Bond, Hold, Material, MaterialKind};

/// A bottle, in the list of what to buy: radius and height, mm.
const BOTTLE_MM: [f64; 2] = [15.0, 60.0];

/// What a parameter that names a material is for, by the end of its path; what is not here is a layer that
/// gives way: gel, skin, coat, or a mold that is peeled off.
const ROLES: [(&str, Role); 3] = [
    ("markers.material", Role::Mark),
    ("skin.paint_material", Role::Mark),
    ("tubes.glue", Role::Glue),
];

/// What a material is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    /// It gives way and comes back.
    Elastic,
    /// It is seen on a layer, and too thin to be felt.
    Mark,
    /// It joins.
    Glue,
}

impl Role {
    fn of(path: &str) -> Self {
        let role = ROLES.iter().find(|(known, _)| path == *known);
        role.map_or(Self::Elastic, |(_, role)| *role)
    }

    /// Whether a material of a kind will do.
    fn takes(self, kind: MaterialKind) -> bool {
        use MaterialKind::{Epoxy, Gel, Glue, Ink, Other, Paint, Polyurethane, Silicone};
        match self {
            Self::Elastic => matches!(kind, Silicone | Gel | Polyurethane | Paint | Other),
            Self::Mark => matches!(kind, Ink | Paint | Silicone | Polyurethane | Epoxy | Other),
            Self::Glue => matches!(kind, Glue | Silicone | Epoxy | Polyurethane | Other),
        }
    }

    fn says(self) -> &'static str {
        match self {
            Self::Elastic => "a layer that must give way and come back",
            Self::Mark => "seen on a layer",
            Self::Glue => "what joins",
        }
    }
}

/// Reports materials of a kind that cannot do what they are named for.
pub(crate) fn check_kinds(settings: &[Setting], materials: &Catalogue, report: &mut Report) {
    for setting in settings {
        let Some(castable) = materials.find(&setting.value) else { continue };
        let material = castable.material();
        let Some(kind) = material.figures.kind else { continue };
        let role = Role::of(&setting.path);
        let others = || {
            let suits = |name: &&str| {
                let known = materials.find(name).map(|known| known.material());
                known.is_some_and(|known| known.figures.kind.is_some_and(|kind| role.takes(kind)))
            };
            let names: Vec<&str> = materials.names().into_iter().filter(suits).collect();
            names.join("; ")
        };
        report.require(
            role.takes(kind),
            &setting.path,
            || {
                format!(
                    "{} is {}, of kind {}; it is {}",
                    setting.path,
                    shown(&material.name),
                    kind.word(),
                    role.says()
                )
            },
            || format!("name one of {}; or mend `kind` of the material", others()),
        );
    }
}

/// Looks for what each poured or sprayed layer stays on, and how it holds there.
pub(crate) fn hold(sensor: &mut Sensor, materials: &Catalogue) {
    let mut primers: Vec<(String, String)> = Vec::new();
    let mut loose = Vec::new();
    let mut told: Vec<(usize, String)> = Vec::new();
    for (index, step) in sensor.chain.iter().enumerate() {
        let (layer, beside) = match &step.action {
            Action::Pour(pour) => (&pour.layer, &pour.walls),
            Action::Spray(spray) => (&spray.layer, &spray.onto),
            _ => continue,
        };
        let Some(layer) = sensor.body(layer).filter(|layer| in_use(layer)) else { continue };
        let later = &sensor.chain[index..];
        let is_taken_off = |name: &str| {
            let pulls = later.iter().filter_map(|step| match &step.action {
                Action::Demold(pulls) => Some(pulls),
                _ => None,
            });
            pulls.flatten().any(|pull| pull.body == name)
        };
        for on in beside.iter().filter_map(|name| sensor.body(name)) {
            if !in_use(on) || is_taken_off(&on.name) {
                continue;
            }
            match bond(layer, on, materials).map(|bond| &bond.hold) {
                None | Some(Hold::Itself) => {}
                Some(Hold::Not) => loose.push(Loose {
                    step: step.name.clone(),
                    layer: layer.name.clone(),
                    on: on.name.clone(),
                }),
                Some(Hold::Primer(primer)) => {
                    let known = primer.to_lowercase();
                    let is_said = sensor.chain[..=index]
                        .iter()
                        .any(|step| step.instruction.to_lowercase().contains(&known));
                    if !is_said {
                        told.push((index, format!("prime {} with {primer} first", on.name)));
                    }
                    if !primers.iter().any(|(name, _)| name == primer) {
                        primers.push((primer.clone(), format!("{} on {}", layer.name, on.name)));
                    }
                }
            }
        }
    }
    for (index, first) in told.into_iter().rev() {
        let instruction = &mut sensor.chain[index].instruction;
        *instruction = format!("{first}; {instruction}");
    }
    sensor.loose = loose;
    if primers.is_empty() {
        return;
    }
    let bottle = |(number, (primer, what)): (usize, (String, String))| {
        let name = if number == 0 { "primer".into() } else { format!("primer-{}", number + 1) };
        let [radius, height] = BOTTLE_MM;
        Body::bought(name, format!("{primer}, for {what}"), Solid::cylinder(radius, height))
            .ordered(Order::of(primer, ""))
    };
    let bottles = primers.into_iter().enumerate().map(bottle);
    let bodies = std::mem::take(&mut sensor.bodies);
    sensor.bodies = in_order(bodies.into_iter().chain(bottles));
}

/// Whether a body is a part of the sensor in use.
fn in_use(body: &Body) -> bool {
    body.placements.iter().any(|placement| placement.assembly == Assembly::sensor())
}

/// What either of two says of the other.
fn bond<'m>(layer: &Body, on: &Body, materials: &'m Catalogue) -> Option<&'m Bond> {
    let says = |of: &Body, other: &Body| {
        let bonds = &materials.find(&of.material)?.material().bonds;
        let kind = materials.find(&other.material).and_then(|other| kind_of(other.material()));
        bonds.iter().find(|bond| means(&bond.to, other, kind))
    };
    says(layer, on).or_else(|| says(on, layer))
}

fn kind_of(material: &Material) -> Option<&'static str> {
    material.figures.kind.map(MaterialKind::word)
}

/// Whether a word is for what a body is made from: all of its words are among those of the material (of
/// what is bought, of what to order), or it is its kind.
fn means(to: &str, body: &Body, kind: Option<&str>) -> bool {
    let words = |text: &str| {
        let parts = text.to_lowercase();
        let parts = parts.split(|c: char| !(c.is_alphanumeric() || matches!(c, '+' | '-')));
        parts.filter(|word| !word.is_empty()).map(str::to_owned).collect::<Vec<_>>()
    };
    let from = if body.material.is_empty() { &body.summary } else { &body.material };
    let (to, from) = (words(to), words(from));
    to.iter().all(|word| from.contains(word)) || kind.is_some_and(|kind| to == [kind])
}
