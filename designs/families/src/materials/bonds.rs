//! Adhesion of cast layers: adds primers to the chain and to the list of what to buy, and notes joints that do not hold
//! for the checks.

use fabkit_geometry::{Action, Assembly, Body, Order, Sensor, Solid, UnbondedLayer, sort_by_kind};
use fabkit_text::{RuleReport, Setting, to_printable};

use super::catalogue::Catalogue;
use super::{Bond, BondMethod, Material, MaterialKind, StockCatalogue};

/// Size of a primer bottle in the list of what to buy: radius and height, mm.
const BOTTLE_MM: [f64; 2] = [15.0, 60.0];

/// Roles of parameters that name a material, by path. Any other parameter names an elastic layer: gel, skin, coat, or a
/// mold that is peeled off.
const ROLES: [(&str, MaterialRole); 3] = [
    ("markers.material", MaterialRole::Mark),
    ("skin.paint_material", MaterialRole::Mark),
    ("tubes.glue", MaterialRole::Glue),
];

/// Role of a material in the sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum MaterialRole {
    /// Layer that deforms and recovers.
    Elastic,
    /// Visible mark on a layer, too thin to matter mechanically.
    Mark,
    /// Adhesive.
    Glue,
}

impl MaterialRole {
    /// Returns the role of the parameter at a path.
    fn from_path(path: &str) -> Self {
        let role = ROLES.iter().find(|(known, _)| path == *known);
        role.map_or(Self::Elastic, |(_, role)| *role)
    }

    /// Returns whether a material of this kind suits the role.
    fn accepts(self, kind: MaterialKind) -> bool {
        use MaterialKind::{Epoxy, Gel, Glue, Ink, Other, Paint, Polyurethane, Silicone};
        match self {
            Self::Elastic => matches!(kind, Silicone | Gel | Polyurethane | Paint | Other),
            Self::Mark => matches!(kind, Ink | Paint | Silicone | Polyurethane | Epoxy | Other),
            Self::Glue => matches!(kind, Glue | Silicone | Epoxy | Polyurethane | Other),
        }
    }

    /// Returns a description for messages.
    fn description(self) -> &'static str {
        match self {
            Self::Elastic => "a layer that must give way and come back",
            Self::Mark => "seen on a layer",
            Self::Glue => "what joins",
        }
    }
}

/// Reports materials of a kind that does not suit their role.
pub(crate) fn check_kinds(settings: &[Setting], materials: &Catalogue, report: &mut RuleReport) {
    for setting in settings {
        let Some(castable) = materials.find(&setting.value) else { continue };
        let material = castable.material();
        let Some(kind) = material.figures.kind else { continue };
        let role = MaterialRole::from_path(&setting.path);
        let others = || {
            let suits = |name: &&str| {
                let known = materials.find(name).map(|known| known.material());
                known.is_some_and(|known| known.figures.kind.is_some_and(|kind| role.accepts(kind)))
            };
            let names: Vec<&str> = materials.names().into_iter().filter(suits).collect();
            names.join("; ")
        };
        report.require(
            role.accepts(kind),
            &setting.path,
            || {
                format!(
                    "{} is {}, of kind {}; it is {}",
                    setting.path,
                    to_printable(&material.name),
                    kind.word(),
                    role.description()
                )
            },
            || format!("name one of {}; or mend `kind` of the material", others()),
        );
    }
}

/// Finds the bodies that each poured or sprayed layer stays on, and how it holds there.
pub(crate) fn add_bonds(sensor: &mut Sensor, materials: &Catalogue, stock: &StockCatalogue) {
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
        // A mold wall that a later step takes off needs no bond.
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
            match bond(layer, on, materials, stock).map(|bond| &bond.hold) {
                None | Some(BondMethod::SelfBonding) => {}
                Some(BondMethod::NoBond) => loose.push(UnbondedLayer {
                    step: step.name.clone(),
                    layer: layer.name.clone(),
                    substrate: on.name.clone(),
                }),
                Some(BondMethod::Primer(primer)) => {
                    // Families may name the primer in an instruction themselves: then nothing is added to it.
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
        // Names of bodies are unique.
        let name = if number == 0 { "primer".into() } else { format!("primer-{}", number + 1) };
        let [radius, height] = BOTTLE_MM;
        Body::bought(name, format!("{primer}, for {what}"), Solid::cylinder(radius, height))
            .with_order(Order::new(primer, ""))
    };
    let bottles = primers.into_iter().enumerate().map(bottle);
    let bodies = std::mem::take(&mut sensor.bodies);
    sensor.bodies = sort_by_kind(bodies.into_iter().chain(bottles));
}

/// Returns whether a body is part of the assembled sensor.
fn in_use(body: &Body) -> bool {
    body.placements.iter().any(|placement| placement.assembly == Assembly::sensor())
}

/// Finds the bond that either of two materials states towards the other.
fn bond<'m>(
    layer: &Body,
    on: &Body,
    materials: &'m Catalogue,
    stock: &StockCatalogue,
) -> Option<&'m Bond> {
    let says = |of: &Body, other: &Body| {
        let bonds = &materials.find(&of.material)?.material().bonds;
        let kind = materials.find(&other.material).and_then(|other| kind_of(other.material()));
        bonds.iter().find(|bond| kind == Some(&*bond.to) || stock.is_called(&bond.to, other))
    };
    says(layer, on).or_else(|| says(on, layer))
}

/// Returns the word for a material's kind.
fn kind_of(material: &Material) -> Option<&'static str> {
    material.figures.kind.map(MaterialKind::word)
}
