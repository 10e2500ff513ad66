//! Casting chain: every name in it exists, and its steps come in an order that works.

use std::collections::{BTreeMap, BTreeSet};

use fabkit_geometry::{
    Action, Body, BodyKind, CompiledSolid, Cure, Mix, Opening, Point3, Pour, Ray, Sensor, Spray,
    Step, Vector3,
};

use crate::declaration::rule;
use crate::finding::{Finding, Severity};
use crate::opening;
use crate::overlapping_steps;
use crate::rule::Rule;
use crate::rule_input::{Place, Removal, RuleInput, RuleResult};
use crate::sampling_lines::{Caster, basis};
use crate::scene::Assemblies;

rule! {
    /// The steps of the chain name what exists, in an order that works.
    Chain = "chain",
    examines: "steps",
    finds: "steps that name something that does not exist, or whose order does not work",
    limit: "—",
    for_variants: true,
    look: apply,
}

fn apply(case: &RuleInput<'_>) -> RuleResult {
    let found = [examine(case.sensor, case.scene), overlapping_steps::examine(case.sensor)];
    // Molds are as much larger as the layer in them shrinks: drawn with no shrinkage where none is stated.
    for layer in pours(case.sensor).filter_map(|(_, pour)| case.sensor.body(&pour.layer)) {
        case.questions.cast_shrinkage(Rule::Chain, layer);
    }
    Ok((found.concat(), case.sensor.chain.len()))
}

/// Largest deviation of a unit vector's length from 1.
const UNIT_ROUNDING: f64 = 1e-9;

/// Number of points of an opening's disc that are searched for the layer's surface.
const OPENING_POINTS: u32 = 256;

/// Iterates over all pours with their steps and assemblies, in order.
pub(crate) fn pours(sensor: &Sensor) -> impl Iterator<Item = (Place<'_>, &Pour)> {
    sensor.chain.iter().filter_map(|step| match (&step.action, &step.assembly) {
        (Action::Pour(pour), Some(assembly)) => {
            Some((Place { step: &step.name, assembly: &assembly.0 }, pour))
        }
        _ => None,
    })
}

/// Returns the layer that a step pours or sprays.
fn made(step: &Step) -> Option<&str> {
    match &step.action {
        Action::Pour(Pour { layer, .. }) | Action::Spray(Spray { layer, .. }) => Some(layer),
        _ => None,
    }
}

/// Returns all pulls in order, each with the bodies against which the tool is pulled.
///
/// For a mold part, these are the layers that have been cast by then and have not been taken out. For a layer that is
/// taken out of the mold in which it was cast, they are the walls of that mold that are parts and still stand there.
pub(crate) fn removals<'a>(sensor: &'a Sensor, scene: &'a Assemblies<'a>) -> Vec<Removal<'a>> {
    let mut cast = BTreeSet::new();
    let mut poured_here = BTreeMap::<(&str, &str), &[String]>::new();
    let mut gone = BTreeSet::new();
    let mut removals = Vec::new();
    for step in &sensor.chain {
        // Layers count as cast in all assemblies from here on.
        cast.extend(made(step));
        let Some(assembly) = step.assembly.as_ref().map(|a| a.0.as_str()) else { continue };
        if let Action::Pour(pour) = &step.action {
            poured_here.insert((assembly, &pour.layer), &pour.walls);
        }
        let Action::Demold(pulls) = &step.action else { continue };
        for pull in pulls {
            let body = pull.body.as_str();
            // Only a layer that was cast in this assembly has an entry.
            let walls = poured_here.get(&(assembly, body));
            let stands_against = |other: &str| match walls {
                Some(walls) => {
                    walls.iter().any(|wall| wall == other)
                        && sensor.parts().any(|part| part.name == other)
                }
                None => cast.contains(other),
            };
            let against = scene.bodies(assembly).iter().filter(|placed| {
                placed.name != body
                    && stands_against(placed.name)
                    && !gone.contains(&(assembly, placed.name))
            });
            removals.push(Removal {
                place: Place { step: &step.name, assembly },
                pull,
                tools: scene.places(assembly, body),
                cast: against.collect(),
            });
            gone.insert((assembly, body));
        }
    }
    removals
}

/// Finds errors of the chain itself.
pub(crate) fn examine(sensor: &Sensor, scene: &Assemblies) -> Vec<Finding> {
    let mut examiner = Examiner {
        scene,
        names: sensor.bodies.iter().map(|body| body.name.as_str()).collect(),
        layers: sensor.layers().map(|l| l.name.as_str()).collect(),
        made_in: BTreeMap::new(),
        used: BTreeSet::new(),
        findings: Vec::new(),
    };
    let mut steps = BTreeSet::new();
    for step in &sensor.chain {
        if !steps.insert(&step.name) {
            examiner.wrong(step, [], "two steps have this name", "give each its own");
        }
        examiner.step(step);
    }
    examiner.completeness(sensor);
    examiner.findings
}

struct Examiner<'a> {
    scene: &'a Assemblies<'a>,
    names: BTreeSet<&'a str>,
    layers: BTreeSet<&'a str>,
    /// Layers that have been cast, each with the step that made it.
    made_in: BTreeMap<&'a str, &'a str>,
    /// Bodies that a step names.
    used: BTreeSet<&'a str>,
    findings: Vec<Finding>,
}

impl<'a> Examiner<'a> {
    /// Adds an error about a step.
    fn wrong<'b>(
        &mut self,
        step: &Step,
        bodies: impl IntoIterator<Item = &'b str>,
        message: impl Into<String>,
        fix: &str,
    ) {
        let finding =
            Finding::error(Rule::Chain, message, fix).in_step(&step.name).about_bodies(bodies);
        self.findings.push(match &step.assembly {
            Some(assembly) => finding.in_assembly(&assembly.0),
            None => finding,
        });
    }

    /// Checks one step.
    fn step(&mut self, step: &'a Step) {
        if let Some(assembly) =
            step.assembly.as_ref().filter(|a| self.scene.bodies(&a.0).is_empty())
        {
            let message = format!("the assembly `{}` is empty", assembly.0);
            self.wrong(step, [], message, "name one in which bodies are placed");
        }
        for body in &step.bodies {
            self.stands(step, body);
        }
        match &step.action {
            Action::Make | Action::Prepare | Action::Assemble => {}
            Action::Bond(cure) => self.cure(step, cure),
            Action::Spray(spray) => {
                self.layer(step, &spray.layer);
                for body in &spray.onto {
                    self.wall(step, &spray.layer, body);
                }
                self.mixture(step, &spray.layer, &spray.mix, spray.waste);
                self.cure(step, &spray.cure);
            }
            Action::Pour(pour) => self.pour(step, pour),
            Action::Demold(pulls) => {
                for pull in pulls {
                    self.stands(step, &pull.body);
                    self.direction(step, &pull.direction, &format!("the pull of {}", pull.body));
                    if pull.strain_limit.is_some_and(|limit| !(limit > 0.0 && limit.is_finite())) {
                        let message = format!("the strain limit of {} is not above 0", pull.body);
                        self.wrong(step, [pull.body.as_str()], message, "state its elongation");
                    }
                }
            }
        }
        if let Some(layer) = made(step) {
            // Only after the checks, so that the step itself does not count as an earlier one.
            self.made_in.insert(layer, &step.name);
        }
    }

    /// Checks a pour: assembly, layer, walls, mixture, cure and openings.
    fn pour(&mut self, step: &'a Step, pour: &'a Pour) {
        if step.assembly.is_none() {
            let message = "a pour needs an assembly in which its cavity stands";
            self.wrong(step, [pour.layer.as_str()], message, "name the assembly");
        }
        self.layer(step, &pour.layer);
        for wall in &pour.walls {
            self.wall(step, &pour.layer, wall);
        }
        self.direction(step, &pour.up, "up");
        self.mixture(step, &pour.layer, &pour.mix, pour.waste);
        self.cure(step, &pour.cure);
        if pour.openings.is_empty() {
            let message = format!("the {} has no opening to be poured through", pour.layer);
            self.wrong(step, [pour.layer.as_str()], message, "declare gate and vents");
        }
        let assembly = step.assembly.as_ref().map_or("", |a| &a.0);
        let layer = self.scene.places(assembly, &pour.layer).first().copied();
        for opening in &pour.openings {
            self.direction(step, &opening.axis, &format!("the axis of {}", opening.name));
            if layer.is_some_and(|layer| !lies_on(opening, &layer.body)) {
                self.wrong(
                    step,
                    [pour.layer.as_str()],
                    format!("{} does not lie on the surface of the {}", opening.name, pour.layer),
                    "put its centre on the surface and its axis out of the layer",
                );
                if let Some(finding) = self.findings.last_mut() {
                    finding.place = Some(opening.point);
                }
            }
        }
    }

    /// Checks that a body exists and stands in the assembly of the step.
    fn stands(&mut self, step: &Step, body: &'a str) -> bool {
        self.used.insert(body);
        if !self.names.contains(body) {
            self.wrong(step, [body], format!("there is no body `{body}`"), "correct the name");
            return false;
        }
        let elsewhere = step.assembly.as_ref().filter(|a| self.scene.places(&a.0, body).is_empty());
        if let Some(assembly) = elsewhere {
            let message = format!("{body} does not stand in the assembly `{}`", assembly.0);
            self.wrong(step, [body], message, "place it there, or name another assembly");
            return false;
        }
        true
    }

    /// Checks that a cast body is a layer, and that it is cast only once.
    fn layer(&mut self, step: &Step, layer: &'a str) {
        if !self.layers.contains(layer) {
            let message = format!("there is no layer `{layer}`");
            self.wrong(step, [layer], message, "correct the name");
            return;
        }
        self.stands(step, layer);
        if let Some(earlier) = self.made_in.get(layer).copied() {
            let message = format!("{layer} has been cast before, in step `{earlier}`");
            self.wrong(step, [layer], message, "cast each layer once");
        }
    }

    /// Checks that a wall stands in the assembly and, if it is a layer, has been cast before.
    fn wall(&mut self, step: &Step, layer: &str, wall: &'a str) {
        if !self.stands(step, wall) {
            return;
        }
        if wall == layer {
            let message = format!("{layer} is a wall of its own cavity");
            self.wrong(step, [wall], message, "remove it from the walls");
        } else if self.layers.contains(wall) && !self.made_in.contains_key(wall) {
            let message = format!("the wall {wall} has not been cast yet");
            self.wrong(step, [wall, layer], message, "cast it in an earlier step");
        }
    }

    /// Checks that a direction is a unit vector.
    fn direction(&mut self, step: &Step, direction: &Vector3<f64>, what: &str) {
        let off = (direction.norm() - 1.0).abs();
        // NaN compares false with everything.
        if off.is_nan() || off > UNIT_ROUNDING {
            let message = format!("{what} is not a unit vector");
            self.wrong(step, [], message, "normalise it");
        }
    }

    /// Checks shares, density and waste of a mixture.
    fn mixture(&mut self, step: &Step, layer: &str, mix: &Mix, waste: f64) {
        let positive = |value: f64| value > 0.0 && value.is_finite();
        if mix.by_mass.is_empty() {
            let message = format!("fabkit knows no mixture for the {layer}");
            self.wrong(step, [layer], message, "choose a material that fabkit knows");
        } else if !(positive(mix.density_g_per_cm3)
            && mix.by_mass.iter().all(|(_, share)| positive(*share)))
        {
            let message = format!("the mixture of the {layer} has a share or density of 0");
            self.wrong(step, [layer], message, "state shares by mass and density");
        }
        if !(waste >= 0.0 && waste.is_finite()) {
            let message = format!("the waste of the {layer} is below 0");
            self.wrong(step, [layer], message, "state it as a fraction of the layer's mass");
        }
    }

    /// Checks duration and temperature of a cure.
    fn cure(&mut self, step: &Step, cure: &Cure) {
        // Absolute zero.
        let above_zero = cure.celsius > -273.15 && cure.celsius.is_finite();
        // Zero hours are valid: a liquid that never cures takes no time.
        if !(cure.hours >= 0.0 && cure.hours.is_finite() && above_zero) {
            let message = "the cure has no time or temperature";
            self.wrong(step, [], message, "state both as the data sheet does");
        }
    }

    /// Checks that every layer is cast, and that a step needs every body.
    fn completeness(&mut self, sensor: &'a Sensor) {
        for layer in sensor.layers() {
            if !self.made_in.contains_key(layer.name.as_str()) {
                self.findings.push(
                    Finding::error(
                        Rule::Chain,
                        format!("no step pours or sprays the {}", layer.name),
                        "add the step that makes it",
                    )
                    .about_bodies([layer.name.as_str()]),
                );
            }
        }
        // Kits of loose parts have no steps.
        if sensor.chain.is_empty() {
            return;
        }
        let layers = &self.layers;
        // Consumables, such as a primer, have no placement; only the step's instruction names them.
        let is_used_up = |body: &&Body| body.kind == BodyKind::Bought && body.placements.is_empty();
        let unused = sensor
            .bodies
            .iter()
            .filter(|body| !is_used_up(body))
            .map(|body| body.name.as_str())
            .filter(|name| !self.used.contains(name) && !layers.contains(name));
        self.findings.extend(unused.map(|name| {
            Finding::error(
                Rule::Chain,
                format!("no step of the chain needs {name}"),
                "name it in the step that uses it",
            )
            .with_severity(Severity::Warning)
            .about_bodies([name])
        }));
    }
}

/// Returns whether some point of an opening's disc lies on a body's surface.
///
/// The points are Vogel's sunflower ("A better way to construct the sunflower head", 1979).
fn lies_on(opening: &Opening, body: &CompiledSolid) -> bool {
    let [u, v] = basis(&opening.axis);
    let mut caster = Caster::default();
    (0..OPENING_POINTS).any(|i| {
        let radius_mm = opening.radius_mm * (f64::from(i) / f64::from(OPENING_POINTS)).sqrt();
        let (sin, cos) = (f64::from(i) * std::f64::consts::PI * (3.0 - 5f64.sqrt())).sin_cos();
        let origin: Point3<f64> = opening.point + radius_mm * (cos * u + sin * v);
        let ray = Ray { origin, direction: opening.axis };
        caster.stretches(body, &ray).any(|s| {
            opening::contains_surface_point(opening, &ray.at(s.exit.t), &s.exit.normal, 0.0)
        })
    })
}
