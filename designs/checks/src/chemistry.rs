//! Chemistry of casting: liquids cure against everything that they touch, and bodies that are to be separated do not
//! bond.

use fabkit_geometry::{Action, Assembly, Body, BodyKind, CureMechanism, MaterialClass, Sensor};

use crate::declaration::rule;
use crate::finding::Finding;
use crate::material_questions::MaterialQuestions;
use crate::rule::Rule;
use crate::rule_input::{RuleInput, RuleResult};

rule! {
    /// Liquids cure against the walls that they touch, and do not bond to their molds.
    Chemistry = "chemistry",
    examines: "pairs of liquid and wall",
    finds: "silicone that does not cure against a body that it touches, or bonds to its mold",
    limit: "curing mechanisms and inhibitors of the materials; a step that seals or releases the \
             wall",
    for_variants: true,
    look: apply,
}

fn apply(case: &RuleInput<'_>) -> RuleResult {
    Ok(examine(case.sensor, &case.questions))
}

/// Contact of a liquid with a wall that would spoil the cast.
#[derive(Clone, Copy, Debug)]
pub struct Hazard<'a> {
    /// Index of the step that pours or sprays the liquid.
    pub step: usize,
    /// Layer that the liquid becomes.
    pub layer: &'a Body,
    /// Wall that it touches.
    pub wall: &'a Body,
    /// Harm that the contact does.
    pub harm: Harm,
    /// Index of the step that prevents the harm by sealing or releasing the wall; `None` if no step does.
    pub prevented_in: Option<usize>,
}

/// Harm that an unprepared wall does to a liquid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Harm {
    /// The wall inhibits this kind of cure, so the liquid stays sticky.
    Inhibits(CureMechanism),
    /// The liquid bonds to the wall, although one of the two is to come off.
    BondsToWall,
}

/// Returns all hazards in the order of the chain, including those that a step of the chain prevents.
///
/// ```
/// use fabkit_checks::{Harm, example, hazards};
/// use fabkit_geometry::CureMechanism;
/// let mut sensor = example::puck();
/// sensor.bodies[2].substance.cure_mechanism = Some(CureMechanism::Platinum);
/// // The dish is printed of a resin whose residues keep platinum silicone from curing.
/// sensor.bodies[0].substance.inhibited_cures = Some(vec![CureMechanism::Platinum]);
/// let found = hazards(&sensor);
/// assert_eq!((&*found[0].layer.name, &*found[0].wall.name), ("puck", "dish"));
/// assert_eq!(found[0].harm, Harm::Inhibits(CureMechanism::Platinum));
/// assert_eq!(found[0].prevented_in, None);
/// ```
pub fn hazards(sensor: &Sensor) -> Vec<Hazard<'_>> {
    // Whoever asks for hazards alone does not hear of what is not known; `check` says it.
    let questions = MaterialQuestions::default();
    contacts(sensor).filter_map(|contact| contact.hazard(&questions)).collect()
}

/// Finds hazards that no step prevents. Also returns the number of pairs of liquid and wall.
pub(crate) fn examine(sensor: &Sensor, questions: &MaterialQuestions) -> (Vec<Finding>, usize) {
    let open = contacts(sensor)
        .filter_map(|contact| contact.hazard(questions))
        .filter(|hazard| hazard.prevented_in.is_none())
        .map(|hazard| hazard.finding().in_step(&sensor.chain[hazard.step].name));
    (open.collect(), contacts(sensor).count())
}

/// Iterates over all pairs of a poured or sprayed layer and a body that it touches.
fn contacts(sensor: &Sensor) -> impl Iterator<Item = Contact<'_>> {
    sensor.chain.iter().enumerate().flat_map(move |(index, step)| {
        let (layer, beside): (_, &[String]) = match &step.action {
            Action::Pour(pour) => (Some(&pour.layer), &pour.walls),
            Action::Spray(spray) => (Some(&spray.layer), &spray.onto),
            _ => (None, &[]),
        };
        let layer = layer.and_then(|name| sensor.body(name));
        let walls = beside.iter().filter_map(|name| sensor.body(name));
        layer.into_iter().flat_map(move |layer| {
            walls.clone().map(move |wall| Contact { sensor, index, layer, wall })
        })
    })
}

/// A liquid and a wall that it touches in a step.
struct Contact<'a> {
    sensor: &'a Sensor,
    index: usize,
    layer: &'a Body,
    wall: &'a Body,
}

impl<'a> Contact<'a> {
    /// Returns the hazard of this contact: the wall inhibits the cure, or the liquid bonds to it.
    fn hazard(self, questions: &MaterialQuestions) -> Option<Hazard<'a>> {
        let Self { index: step, layer, wall, .. } = self;
        let told =
            |harm, kept_off_in| Hazard { step, layer, wall, harm, prevented_in: kept_off_in };
        let inhibited =
            self.inhibited(questions).map(|curing| told(Harm::Inhibits(curing), self.sealed_in()));
        // An inhibited liquid does not cure, so bonding matters only once the wall is sealed.
        match inhibited {
            Some(Hazard { prevented_in: None, .. }) => inhibited,
            _ if self.grows_together(questions) => {
                let grown = told(Harm::BondsToWall, self.released_in());
                inhibited.filter(|_| grown.prevented_in.is_some()).or(Some(grown))
            }
            _ => inhibited,
        }
    }

    /// Returns the layer's cure if the wall inhibits it.
    fn inhibited(&self, questions: &MaterialQuestions) -> Option<CureMechanism> {
        let Self { layer, wall, .. } = self;
        if questions.class(Rule::Chemistry, layer) == Some(MaterialClass::Liquid) {
            return None;
        }
        // The cure matters only where the wall inhibits some cure, which a platinum silicone is the first to feel.
        let platinum = CureMechanism::Platinum;
        if questions.inhibits(Rule::Chemistry, wall, platinum) == Some(false) {
            return None;
        }
        let cure = questions.cure(Rule::Chemistry, layer)?;
        questions.inhibits(Rule::Chemistry, wall, cure)?.then_some(cure)
    }

    /// Finds the step, up to this one, whose instruction names the sealer that the wall's material asks for.
    fn sealed_in(&self) -> Option<usize> {
        let by = self.wall.sealed_by?;
        let mut until_now = self.sensor.chain[..=self.index].iter();
        until_now.position(|step| step.instruction.to_lowercase().contains(by))
    }

    /// Returns whether both are silicone and not both stay in the sensor: silicone bonds to cured silicone unless
    /// release agent lies between them. Silicone that cures by moisture does not count.
    fn grows_together(&self, questions: &MaterialQuestions) -> bool {
        let both_stay = [self.layer, self.wall].into_iter().all(is_in_sensor);
        let is_silicone =
            |body: &Body| questions.class(Rule::Chemistry, body) == Some(MaterialClass::Silicone);
        if both_stay || !is_silicone(self.layer) || !is_silicone(self.wall) {
            return false;
        }
        // Tubes and sheets of silicone do not say how they were cured: they count as cured silicone does.
        let is_by_moisture = |body: &Body| {
            body.kind == BodyKind::Cast
                && questions.cure(Rule::Chemistry, body) == Some(CureMechanism::Moisture)
        };
        !is_by_moisture(self.layer) && !is_by_moisture(self.wall)
    }

    /// Finds the first step, up to this one, whose instruction mentions a release and that concerns the wall.
    fn released_in(&self) -> Option<usize> {
        let mut chain = self.sensor.chain[..=self.index].iter().enumerate();
        let said = chain.find(|(at, step)| {
            // A release in an earlier step counts only if that step names the wall.
            let is_meant = *at == self.index || step.bodies.contains(&self.wall.name);
            is_meant && step.instruction.to_lowercase().contains("release")
        });
        said.map(|(at, _)| at)
    }
}

impl Hazard<'_> {
    /// Converts the hazard to a finding.
    fn finding(&self) -> Finding {
        let Self { layer, wall, .. } = self;
        let (message, fix) = match self.harm {
            Harm::Inhibits(curing) => {
                let message = format!(
                    "{} of {} stays sticky against {} of {}, which keeps {} from curing",
                    layer.name,
                    layer.material,
                    wall.name,
                    stuff(wall),
                    curing.word()
                );
                let fix = match wall.sealed_by {
                    Some(by) => {
                        format!("say in a step before the pour that {} is sealed ({by})", wall.name)
                    }
                    None => format!(
                        "seal {} and say so in its material (`sealed {}`), or make it of something \
                         that does not inhibit {}",
                        wall.name,
                        stuff(wall),
                        curing.word()
                    ),
                };
                (message, fix)
            }
            Harm::BondsToWall => (
                format!(
                    "{} of {} grows together with {} of {}: silicone sticks to silicone",
                    layer.name, layer.material, wall.name, wall.material
                ),
                format!("spray {} with release agent, and say so in a step before", wall.name),
            ),
        };
        Finding::error(Rule::Chemistry, message, fix)
            .about_bodies([wall.name.as_str(), &layer.name])
    }
}

/// Returns the body's material, or its description if it has none.
fn stuff(body: &Body) -> &str {
    if body.material.is_empty() { &body.summary } else { &body.material }
}

/// Returns whether a body is part of the finished sensor.
pub(crate) fn is_in_sensor(body: &Body) -> bool {
    body.placements.iter().any(|placement| placement.assembly == Assembly::sensor())
}
