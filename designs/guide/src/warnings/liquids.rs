//! Warnings about liquids that do not cure, do not release or do not bond.

use std::collections::BTreeMap;

use fabkit_checks::{Harm, hazards};
use fabkit_geometry::{Action, Body, CureMechanism, Sensor, Step};

use super::Warning;
use crate::timeline::hands_on_h;
use crate::{StepMix, Timeline};

const SMOOTH_ON: &str = "Smooth-On, technical bulletins of Ecoflex, Solaris and Mold Star: sulfur, tin, amines and some \
     printed resins keep platinum silicone from curing; Formlabs' guide to silicone molds asks for a coat";
const GROWS: &str = "Smooth-On, technical bulletin of Ease Release 200: silicone bonds to silicone \
                     unless release agent lies between";
const DOW: &str = "Dow, guides to PR-1200 and 1200 OS prime coats: silicone that cures on a smooth, \
                   unprimed face can be peeled off";

/// Returns the layer that a step pours or sprays, and the bodies it touches.
fn liquid(step: &Step) -> Option<(&str, &[String])> {
    match &step.action {
        Action::Pour(pour) => Some((&pour.layer, &pour.walls)),
        Action::Spray(spray) => Some((&spray.layer, &spray.onto)),
        _ => None,
    }
}

/// Returns the name of a body's material, or its specification.
fn material_name(body: &Body) -> &str {
    if body.material.is_empty() { &body.summary } else { &body.material }
}

/// Returns warnings about walls that inhibit a liquid's cure or that it bonds to.
pub(super) fn wall_warnings(sensor: &Sensor) -> Vec<Warning> {
    let told = hazards(sensor).into_iter().map(|hazard| {
        let (layer, wall) = (hazard.layer, hazard.wall);
        let kept_off = hazard.prevented_in.map(|step| step + 1);
        let (rule, why, left, source) = match hazard.harm {
            Harm::Inhibits(curing) => (
                "inhibition",
                format!(
                    "{} ({}) keeps {} ({}) from curing where they touch: it stays sticky",
                    wall.name,
                    material_name(wall),
                    layer.name,
                    curing.word()
                ),
                format!(
                    "seal {} before the pour: wash and cure the print through, bake it or coat it with \
                     clear acrylic, and try a drop of the mix on it first",
                    wall.name
                ),
                SMOOTH_ON,
            ),
            Harm::BondsToWall => (
                "release",
                format!("{} grows together with {}: silicone on silicone", layer.name, wall.name),
                format!("spray {} with release agent for silicone, and let it dry", wall.name),
                GROWS,
            ),
        };
        let sealed = wall.sealed_by.unwrap_or("the coat that it names");
        let does = match (kept_off, hazard.harm) {
            (None, _) => left,
            (Some(number), Harm::Inhibits(_)) => {
                format!("step {number} seals it ({sealed}): do not leave that out")
            }
            (Some(number), Harm::BondsToWall) => {
                format!("step {number} puts release agent between: do not leave that out")
            }
        };
        Warning::new(rule, why, does)
            .in_steps([hazard.step + 1])
            .with_bodies([layer.name.as_str(), wall.name.as_str()])
            .with_source(source)
            .with_solution(kept_off)
    });
    told.collect()
}

/// Returns warnings about joints that hold only with a primer, and about those that do not hold.
pub(super) fn primers(sensor: &Sensor) -> Vec<Warning> {
    let step_of = |layer: &str| {
        let makes = |step: &Step| liquid(step).is_some_and(|(made, _)| made == layer);
        sensor.chain.iter().position(makes)
    };
    let mut told = Vec::new();
    for loose in &sensor.loose {
        let step = sensor.chain.iter().position(|step| step.name == loose.step);
        let why =
            format!("{} does not stick to {}, on which it is cast", loose.layer, loose.substrate);
        let does = format!("prime {}, or hold the two together by their shapes", loose.substrate);
        told.push(
            Warning::new("loose", why, does)
                .in_steps(step.map(|step| step + 1))
                .with_bodies([loose.layer.as_str(), loose.substrate.as_str()])
                .with_source("the materials' own `bonds`"),
        );
    }
    // The agent of such joints is called `cast on primer`.
    for adhesion in sensor.adhesions.iter().filter(|adhesion| adhesion.by.contains("primer")) {
        let [layer, on] = &adhesion.bodies;
        let Some(step) = step_of(layer).or_else(|| step_of(on)) else { continue };
        let primes = |(at, other): (usize, &Step)| {
            // The pour itself may name the primer, or an earlier step on the same body.
            let is_meant = at == step || other.bodies.contains(on);
            is_meant && other.instruction.to_lowercase().contains("prime")
        };
        let in_step = sensor.chain[..=step].iter().enumerate().position(primes);
        let why = format!("{layer} peels off {on} where no primer lies between");
        let does = match in_step {
            Some(index) => {
                format!("step {} primes it: clean, thin, and left to dry in moist air", index + 1)
            }
            None => format!("prime {on} before, and let it dry"),
        };
        told.push(
            Warning::new("primer", why, does)
                .in_steps([step + 1])
                .with_bodies([layer.as_str(), on.as_str()])
                .with_source(DOW)
                .with_solution(in_step.map(|index| index + 1)),
        );
    }
    told
}

/// Returns warnings about cures that are hotter than the softening temperature of a wall.
pub(super) fn heat(sensor: &Sensor) -> Vec<Warning> {
    let mut told = Vec::new();
    for (index, step) in sensor.chain.iter().enumerate() {
        let (Some((layer, walls)), Some(cure)) = (liquid(step), step.cure()) else { continue };
        for wall in walls.iter().filter_map(|name| sensor.body(name)) {
            let Some(softens) =
                wall.substance.softening_point.as_ref().filter(|s| s.celsius <= cure.celsius)
            else {
                continue;
            };
            let why = format!(
                "{layer} cures at {} °C, and {} of {} gives way at {} °C",
                cure.celsius,
                wall.name,
                material_name(wall),
                softens.celsius
            );
            let does = format!(
                "cure it below {} °C for longer, as the maker's sheet allows, or make {} of what bears \
                 the heat",
                softens.celsius, wall.name
            );
            told.push(
                Warning::new("heat", why, does)
                    .in_steps([index + 1])
                    .with_bodies([layer, wall.name.as_str()])
                    .with_source(&softens.source),
            );
        }
    }
    told
}

/// Returns warnings about mixes that set before their handling is finished.
pub(super) fn pot_lives(mixes: &[StepMix], timeline: &Timeline) -> Vec<Warning> {
    let late = mixes.iter().filter_map(|mix| {
        let pot_life_h = mix.pot_life_h.filter(|pot_life_h| *pot_life_h < mix.in_hand_h)?;
        let why = format!(
            "the mix for {} has a pot life of {:.0} min, but the work with it takes {:.0} min",
            mix.layer,
            60.0 * pot_life_h,
            60.0 * mix.in_hand_h
        );
        let does = "lay everything out before you mix, degas no longer than bubbles rise, or mix and \
                    pour in two halves; a cold mix lasts longer";
        let warning = Warning::new("pot-life", why, does).in_steps([mix.step]);
        Some(warning.with_bodies([mix.layer.as_str()]).with_source(format!(
            "the maker's data sheet for the pot life; hands-on times are {}",
            timeline.hands_on
        )))
    });
    late.collect()
}

/// Returns warnings about substances that must not come near the liquids.
pub(super) fn gloves(sensor: &Sensor) -> Vec<Warning> {
    let mut of: BTreeMap<usize, &str> = BTreeMap::new();
    for (index, step) in sensor.chain.iter().enumerate() {
        let layer = liquid(step).and_then(|(layer, _)| sensor.body(layer));
        if let Some(layer) =
            layer.filter(|l| l.substance.cure_mechanism == Some(CureMechanism::Platinum))
        {
            of.insert(index + 1, &layer.name);
        }
    }
    if of.is_empty() {
        return Vec::new();
    }
    let why = "traces of sulfur, tin and amines keep platinum silicone from curing: latex gloves, modeling \
               clay with sulfur, tin silicone, epoxy hardener, cups and sticks that have seen them";
    let does = "vinyl or nitrile gloves, new cups and sticks, a table that nothing else is cast on";
    vec![
        Warning::new("gloves", why, does)
            .in_steps(of.keys().copied())
            .with_bodies(of.values().copied())
            .with_source(SMOOTH_ON),
    ]
}

/// Returns the time for which a mix is handled, h: until the hands-on work of its own step ends or, if it cures
/// together with later layers, that of the step in which it cures.
pub(crate) fn handling_time_h(chain: &[Step], step: usize) -> f64 {
    // A cure of 0 h means that the layer cures together with a later one.
    let cures = |step: &Step| step.cure().is_none_or(|cure| cure.hours > 0.0);
    let mut hours = 0.0;
    for later in &chain[step..] {
        hours += hands_on_h(&later.action);
        if cures(later) {
            break;
        }
    }
    hours
}
