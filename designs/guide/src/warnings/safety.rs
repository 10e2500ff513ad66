//! Warnings about the safety of the people who build the sensor.

use fabkit_geometry::{Action, CureMechanism, Sensor, Step};

use super::Warning;

/// Words of an instruction, with the hazard that they imply, the precaution, and the source.
const NAMED: [(&[&str], &str, &str, &str); 4] = [
    (
        &["cyanoacrylate", "instant adhesive"],
        "instant adhesive glues skin within seconds, and its vapor settles as a white haze on lenses and \
         acrylic",
        "goggles; thin drops, air that moves away from what is clear, nothing closed before it is hard",
        "Henkel, technical data sheet of Loctite 401",
    ),
    (
        &["solvent cement"],
        "solvent cement is flammable, and its vapor is harmful",
        "under a hood or in moving air, no flame, gloves that it does not dissolve (its maker names them)",
        "the maker's safety data sheet; acrylic cements hold dichloromethane or butanone",
    ),
    (
        &["prime "],
        "primers for silicone are flammable solvents",
        "in moving air, no flame, nitrile gloves",
        "Dow, safety data sheets of PR-1200 RTV and 1200 OS prime coats",
    ),
    (
        &["solder"],
        "solder's fumes irritate the lungs",
        "an extractor or moving air; wash your hands afterwards",
        "chosen: as every workshop's rules say",
    ),
];

/// Returns the warnings about masks, hoods and gloves.
pub(super) fn handling(sensor: &Sensor) -> Vec<Warning> {
    let numbered = || sensor.chain.iter().enumerate().map(|(index, step)| (index + 1, step));
    let steps = |is_meant: &dyn Fn(&Step) -> bool| -> Vec<usize> {
        numbered().filter(|(_, step)| is_meant(step)).map(|(number, _)| number).collect()
    };
    let mut told = Vec::new();
    let sprays = steps(&|step| matches!(step.action, Action::Spray(_)));
    told.push((
        sprays,
        "a sprayed or thinned coat is breathed in, and its thinner is flammable",
        "under a hood with a mask for organic vapor (A2P3), no flame, until the thinner has left",
        "chosen: makers' safety data sheets of thinners and silicone paints ask for both",
    ));
    let polyurethane = steps(&|step| {
        let layer = match &step.action {
            Action::Pour(pour) => sensor.body(&pour.layer),
            Action::Spray(spray) => sensor.body(&spray.layer),
            _ => None,
        };
        layer.is_some_and(|layer| {
            layer.substance.cure_mechanism == Some(CureMechanism::Polyurethane)
        })
    });
    told.push((
        polyurethane,
        "polyurethanes hold isocyanates: harmful when breathed in or on skin, and they make allergic for life",
        "nitrile gloves, goggles, under a hood; who works with them needs training in the EU since 2023",
        "Commission Regulation (EU) 2020/1149",
    ));
    for (words, why, does, source) in NAMED {
        let says = |step: &Step| {
            let text = step.instruction.to_lowercase();
            words.iter().any(|word| text.contains(word))
        };
        told.push((steps(&says), why, does, source));
    }
    let happens = told.into_iter().filter(|(steps, ..)| !steps.is_empty());
    happens
        .map(|(steps, why, does, source)| {
            Warning::new("safety", why, does).in_steps(steps).with_source(source)
        })
        .collect()
}
