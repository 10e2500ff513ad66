//! Flow of surplus liquid out of a closed mold, through gates and vents, while a hand presses it shut.

use fabkit_geometry::Pour;

use crate::declaration::rule;
use crate::finding::Finding;
use crate::rule::Rule;
use crate::rule_input::Place;
use crate::rule_input::{RuleInput, RuleResult};
use crate::sampling_lines::{Bundle, Caster};
use crate::scene::Assemblies;
use rayon::prelude::*;

rule! {
    /// A closed mold lets its surplus out.
    Flow = "flow",
    examines: "pours",
    finds: "vents that do not let the surplus out while a hand presses the mold shut",
    limit: "Hagen-Poiseuille flow with the material's viscosity, 10 kPa, 60 s (chosen)",
    for_variants: true,
    look: apply,
}

fn apply(case: &RuleInput<'_>) -> RuleResult {
    let RuleInput { sensor, scene, pours, .. } = case;
    let flows = pours.par_iter().map(|(at, pour)| Vents::measure(at, pour, scene));
    let vents: Vec<Option<Vents>> = flows.collect();
    let mut findings = Vec::new();
    for ((place, pour), vents) in pours.iter().zip(vents) {
        let (Some(vents), Some(layer)) = (vents, sensor.body(&pour.layer)) else { continue };
        let viscosity = case.questions.viscosity_pa_s(Rule::Flow, layer);
        findings.extend(viscosity.and_then(|pa_s| vents.examine(pa_s, place, pour)));
    }
    Ok((findings, pours.len()))
}

/// Pressure of a hand on a lid or core, 10 N on 10 cm2, Pa (chosen).
const PRESSURE_PA: f64 = 1e4;

/// Length of a vent in diameters, from a 3 mm plate with vents of 0.6 mm (chosen).
const LENGTH_DIAMETERS: f64 = 5.0;

/// Fraction of the layer's volume that is pressed out; molds are filled until they overflow (chosen).
const SURPLUS: f64 = 0.5;

/// Longest time that somebody presses, s (chosen).
const LONGEST_S: f64 = 60.0;

/// Fraction of the layer's projected area above which the openings together count as a free surface.
const FREE: f64 = 0.3;

/// Number of lines that measure a layer.
const LINES: usize = 2_048;

/// Openings of a closed mold, and the surplus that has to leave through them.
struct Vents {
    surplus_mm3: f64,
    area_mm2: f64,
}

impl Vents {
    /// Measures a pour along lines; `None` for a mold whose openings together are a free surface, which needs no vents.
    fn measure(place: &Place, pour: &Pour, scene: &Assemblies) -> Option<Self> {
        let layer = scene.places(place.assembly, &pour.layer).into_iter().next()?;
        let bundle = Bundle::through(&layer.body.bounds(), pour.up, LINES);
        let mut caster = Caster::default();
        let (mut volume_mm3, mut shadow_mm2) = (0.0, 0.0);
        for ray in (0..LINES).map(|index| bundle.line(index)) {
            let length: f64 =
                caster.intervals(&layer.body, &ray).iter().map(|[from, to]| to - from).sum();
            volume_mm3 += length * bundle.cell_mm2();
            shadow_mm2 += if length > 0.0 { bundle.cell_mm2() } else { 0.0 };
        }
        let area_mm2: f64 =
            pour.openings.iter().map(|o| std::f64::consts::PI * o.radius_mm.powi(2)).sum();
        (area_mm2 <= FREE * shadow_mm2)
            .then_some(Self { surplus_mm3: SURPLUS * volume_mm3, area_mm2 })
    }

    /// Computes the time that the surplus takes through the openings, and reports it if it is too long.
    ///
    /// Hagen-Poiseuille: a pressure p drives the flow rate pi r^4 p / (8 mu l) through a pipe of radius r and length l.
    fn examine(&self, viscosity_pa_s: f64, place: &Place, pour: &Pour) -> Option<Finding> {
        let through = |radius_mm: f64| {
            let length_mm = LENGTH_DIAMETERS * 2.0 * radius_mm;
            std::f64::consts::PI * radius_mm.powi(4) * PRESSURE_PA
                / (8.0 * viscosity_pa_s * length_mm)
        };
        let mm3_per_s: f64 = pour.openings.iter().map(|opening| through(opening.radius_mm)).sum();
        let seconds = self.surplus_mm3 / mm3_per_s;
        (seconds > LONGEST_S).then(|| {
            let message = format!(
                "the surplus of {} leaves the mold too slowly: its {} openings have {:.2} mm2 in all, \
                 its mixture {viscosity_pa_s} Pa s",
                pour.layer,
                pour.openings.len(),
                self.area_mm2
            );
            let finding =
                Finding::error(Rule::Flow, message, "add vents, widen them, or take a thinner mixture");
            let finding = finding.in_step(place.step).in_assembly(place.assembly);
            finding.about_bodies([pour.layer.as_str()]).with_measurement(seconds, LONGEST_S, "s")
        })
    }
}
