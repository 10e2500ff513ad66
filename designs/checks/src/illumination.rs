//! Illumination: diffusers that stop the light or spread none, and coats too dark to show their slopes.

use fabkit_geometry::{Body, OpticalClarity, Sensor, VisibleEffect};

use crate::finding::{Finding, Severity};
use crate::material_questions::MaterialQuestions;
use crate::rule::Rule;

/// Smallest share of the light that a diffuser passes. Chosen: opal sheets pass 30 % and more; at a tenth, a camera would
/// have to amplify its image ten times.
const LEAST_TRANSMISSION: f64 = 0.1;

/// Smallest reflectance of a coat whose slopes are to be seen. Chosen: coats of published sensors are of aluminium powder
/// or grey pigment, which reflect 30 to 60 %; black paint reflects 4 to 7 %.
const LEAST_REFLECTANCE: f64 = 0.1;

/// Finds bodies whose material keeps a lighting from showing what it is for.
pub(crate) fn examine(sensor: &Sensor, questions: &MaterialQuestions) -> Vec<Finding> {
    let mut findings = Vec::new();
    for lighting in &sensor.lightings {
        let body = |name: &String| sensor.body(name);
        let diffuser = lighting.diffuser.as_ref().and_then(body);
        findings.extend(diffuser.and_then(|body| dark_diffuser(body, lighting.name, questions)));
        findings.extend(diffuser.and_then(|body| clear_diffuser(body, lighting.name, questions)));
        if let VisibleEffect::Slopes { coat, .. } = &lighting.effect {
            findings.extend(body(coat).and_then(|body| dark_coat(body, lighting.name, questions)));
        }
    }
    findings
}

/// Compares what a diffuser lets through with the least that it must.
fn dark_diffuser(body: &Body, light: &str, questions: &MaterialQuestions) -> Option<Finding> {
    let passes = questions.transmission(Rule::Sight, body)?;
    if passes >= LEAST_TRANSMISSION {
        return None;
    }
    let message = format!(
        "{} of {} stops {:.0} % of the `{light}` light that has to pass it",
        body.name,
        body.material,
        100.0 * (1.0 - passes)
    );
    let fix = "take a frosted or white translucent material";
    let finding = Finding::error(Rule::Sight, message, fix).about_bodies([body.name.as_str()]);
    Some(finding.with_measurement(100.0 * passes, 100.0 * LEAST_TRANSMISSION, "%"))
}

/// Finds a diffuser that spreads nothing: the light reaches the surface as if there were none.
fn clear_diffuser(body: &Body, light: &str, questions: &MaterialQuestions) -> Option<Finding> {
    if questions.transparency(Rule::Sight, body)? != OpticalClarity::Clear {
        return None;
    }
    let message = format!(
        "{} of {} is clear and spreads none of the `{light}` light: its light sources show as spots",
        body.name, body.material
    );
    let fix = "take a frosted or white translucent material";
    let finding = Finding::error(Rule::Sight, message, fix).with_severity(Severity::Warning);
    Some(finding.about_bodies([body.name.as_str()]))
}

/// Compares the reflectance of a coat with the least that shows slopes.
fn dark_coat(body: &Body, light: &str, questions: &MaterialQuestions) -> Option<Finding> {
    let reflectance = questions.reflectance(Rule::Sight, body)?;
    if reflectance >= LEAST_REFLECTANCE {
        return None;
    }
    let message = format!(
        "{} of {} reflects {:.0} % of the `{light}` light that is to show its slopes: images are dark and noisy",
        body.name,
        body.material,
        100.0 * reflectance
    );
    let fix = "take a coat with aluminium powder or a light pigment";
    let finding = Finding::error(Rule::Sight, message, fix)
        .with_severity(Severity::Warning)
        .about_bodies([body.name.as_str()]);
    Some(finding.with_measurement(100.0 * reflectance, 100.0 * LEAST_REFLECTANCE, "%"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fabkit_geometry::{
        Lighting, OpticalClarity, OpticalFigure, OpticalProperties, Process, Solid,
    };

    fn figure<T>(value: T) -> Option<OpticalFigure<T>> {
        Some(OpticalFigure { value, is_chosen: false, source: "measured".to_owned() })
    }

    /// Findings for a sensor with a ring and a paint, and the properties that were missing.
    fn found(optics: OpticalProperties, clarity: OpticalClarity) -> (Vec<Finding>, Vec<String>) {
        let mut sensor = crate::example::puck();
        let part = |name: &str| {
            let solid = Solid::cuboid(1.0, 1.0, 1.0);
            Body::made(name, "", Process::Laser, solid).with_material(name).with_clarity(clarity)
        };
        let mut bodies = [part("ring"), part("paint")];
        bodies.iter_mut().for_each(|body| body.substance.optics = optics.clone());
        sensor.bodies.extend(bodies);
        let effect = VisibleEffect::Slopes { coat: "paint".into(), printed: None };
        sensor.lightings = vec![Lighting::from_body("white", "led", effect).through("ring")];
        let questions = MaterialQuestions::default();
        let findings = examine(&sensor, &questions);
        let missing = questions.unanswered().iter().map(|unknown| unknown.subject()).collect();
        (findings, missing)
    }

    #[test]
    fn what_stops_light_is_found_and_what_is_not_known_is_listed() {
        let optics = |transmission: f64, reflectance: f64| OpticalProperties {
            reflectance: figure([reflectance; 3]),
            gloss: None,
            transmission: figure(transmission),
            scattering_per_mm: None,
        };
        let (none, missing) = found(optics(0.5, 0.45), OpticalClarity::Translucent);
        assert!(none.is_empty() && missing.is_empty(), "{none:#?} {missing:?}");

        let (dark, _) = found(optics(0.02, 0.05), OpticalClarity::Translucent);
        assert_eq!(
            dark.iter().map(|of| of.severity).collect::<Vec<_>>(),
            [Severity::Error, Severity::Warning]
        );
        assert!(dark[0].message.contains("ring of ring stops 98 %"), "{}", dark[0].message);
        assert!(dark[1].message.contains("paint of paint reflects 5 %"), "{}", dark[1].message);

        let (none, missing) = found(OpticalProperties::default(), OpticalClarity::Translucent);
        assert!(none.is_empty(), "{none:#?}");
        assert_eq!(missing, ["reflectance of paint", "transmission of ring"]);
        let (clear, _) = found(optics(0.92, 0.45), OpticalClarity::Clear);
        assert_eq!(clear.iter().map(|of| of.severity).collect::<Vec<_>>(), [Severity::Warning]);
        assert!(clear[0].message.contains("ring of ring is clear"), "{}", clear[0].message);
        // An opaque ring stops everything, whatever its material is.
        let (opaque, missing) = found(OpticalProperties::default(), OpticalClarity::Opaque);
        assert!(opaque[0].message.contains("stops 100 %"), "{}", opaque[0].message);
        assert_eq!(missing, ["reflectance of paint"]);
    }
}
