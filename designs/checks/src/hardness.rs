//! Hardness of soft and holding parts, thickness of sprayed coats, and contrast between colours.

use fabkit_geometry::{Action, Assembly, Body, BodyKind, Sensor, Shore, Vector3};

use crate::chemistry::is_in_sensor;
use crate::declaration::rule;
use crate::finding::Finding;
use crate::material_questions::MaterialQuestions;
use crate::rule::Rule;
use crate::rule_input::{RuleInput, RuleResult};
use crate::sampling_lines::{Bundle, Caster, steepness};
use crate::scene::Assemblies;

rule! {
    /// Parts are soft where they must give way and firm where they must hold.
    Softness = "softness",
    examines: "made and cast bodies",
    finds: "gels that are too hard, molds that are too soft, holders that give way, coats that run",
    limit: "Shore hardness in data sheets",
    for_variants: true,
    look: apply,
}

fn apply(case: &RuleInput<'_>) -> RuleResult {
    Ok(examine(case.sensor, case.scene, &case.questions))
}

/// Softest silicone that keeps its shape as a mold. Makers sell Shore A 15 to 40 for molds (Smooth-On's Mold Star 15,
/// 16 and 30); softer ones sag under the liquid.
const SOFTEST_MOLD: Shore = Shore::A(15.0);

/// Softest part that can hold others; hard rubber wheels are Shore A 80.
const SOFTEST_HOLDER: Shore = Shore::A(80.0);

/// Hardest part that gives way to touch: a tire's tread. Fingertips of robots have Shore A 10 to 60.
const HARDEST_TOUCHED: Shore = Shore::A(70.0);

/// Thickest coat that can be sprayed, mm: three passes of 0.1 mm. A thicker one runs, and stiffens the gel under it.
const THICKEST_COAT_MM: f64 = 0.3;

/// Number of lines through a coat.
const LINES: usize = 256;

/// Smallest steepness at which a line measures the thickness of a coat.
const STEEP: f64 = 0.9;

/// Finds bodies of the wrong hardness and coats that are too thick. Also returns the number of bodies examined.
pub(crate) fn examine(
    sensor: &Sensor,
    scene: &Assemblies,
    questions: &MaterialQuestions,
) -> (Vec<Finding>, usize) {
    let bodies = sensor.bodies.iter().filter(|body| body.kind != BodyKind::Bought);
    // Forces, images and robots need the elasticity of what gives way; here is where it is missed first.
    for body in bodies.clone().filter(|body| is_in_sensor(body) && body.gives_way()) {
        questions.elasticity(Rule::Softness, body);
    }
    let findings = bodies.clone().filter_map(|body| firmness(body, questions));
    let findings = findings.chain(coats(sensor, scene)).collect();
    (findings, bodies.count())
}

/// Compares the hardness of a body with the limits for its purpose.
fn firmness(body: &Body, questions: &MaterialQuestions) -> Option<Finding> {
    // Layers of the finished sensor may be of any hardness.
    if body.kind == BodyKind::Cast && is_in_sensor(body) {
        return None;
    }
    let shore = questions.shore(Rule::Softness, body)?;
    let about = |message: String, fix: String| {
        Some(Finding::error(Rule::Softness, message, fix).about_bodies([body.name.as_str()]))
    };
    let Body { name, material, .. } = body;
    match body.kind {
        BodyKind::Cast if !is_in_sensor(body) && shore < SOFTEST_MOLD => about(
            format!("{name} of {material} is a mold of {shore}, which sags under the pour"),
            format!("take a silicone of {SOFTEST_MOLD} or more"),
        ),
        BodyKind::Made(_) if body.is_deformable && shore > HARDEST_TOUCHED => about(
            format!("{name} of {material} must give way in contact, but has {shore}"),
            format!("take a rubber of at most {HARDEST_TOUCHED}"),
        ),
        BodyKind::Made(_) if !body.is_deformable && shore < SOFTEST_HOLDER => about(
            format!("{name} of {material} must keep its shape, but has {shore}"),
            format!("take a plastic, or a rubber of at least {SOFTEST_HOLDER}"),
        ),
        _ => None,
    }
}

/// Finds sprayed layers that are too thick.
fn coats<'a>(sensor: &'a Sensor, scene: &'a Assemblies) -> impl Iterator<Item = Finding> + use<'a> {
    let assembly = Assembly::sensor().0;
    sensor.chain.iter().filter_map(move |step| {
        let Action::Spray(spray) = &step.action else { return None };
        let placed = scene.places(&assembly, &spray.layer).into_iter().next()?;
        let bundle = Bundle::through(&placed.body.bounds(), Vector3::z(), LINES);
        let mut caster = Caster::default();
        let mut lengths_mm = Vec::new();
        for ray in (0..LINES).map(|index| bundle.line(index)) {
            for stretch in caster.stretches(&placed.body, &ray) {
                let steep = steepness(&ray, &stretch.enter).min(steepness(&ray, &stretch.exit));
                // On steep sides of the coat, a vertical line runs along it.
                if steep > STEEP {
                    lengths_mm.push(stretch.length_mm() * steep);
                }
            }
        }
        // The median of the lines: some run inside the coat along its sides and are too long.
        lengths_mm.sort_by(f64::total_cmp);
        let median = lengths_mm.get(lengths_mm.len() / 2);
        let mm = median.copied().filter(|mm| *mm > THICKEST_COAT_MM)?;
        let message = format!("{} is sprayed, but thicker than a coat can be", spray.layer);
        let fix = "take a thinner coat, or pour it into a mold";
        let finding = Finding::error(Rule::Softness, message, fix).in_step(&step.name);
        Some(finding.about_bodies([spray.layer.as_str()]).with_measurement(
            mm,
            THICKEST_COAT_MM,
            "mm",
        ))
    })
}

/// Finds pairs that the camera tells apart by brightness although both are dark or both light.
pub(crate) fn contrasts(sensor: &Sensor, questions: &MaterialQuestions) -> Vec<Finding> {
    let finding = |pair: &[String; 2]| {
        let [a, b] = [sensor.body(&pair[0])?, sensor.body(&pair[1])?];
        let shades = [a, b].map(|body| questions.is_dark(Rule::Sight, body));
        let [Some(is_dark), Some(other)] = shades else { return None };
        if other != is_dark {
            return None;
        }
        let shade = if is_dark { "dark" } else { "light" };
        let message = format!("{} of {} is as {shade} as {} behind it", a.name, a.material, b.name);
        let fix =
            format!("take a {} colour for one of them", if is_dark { "light" } else { "dark" });
        Some(
            Finding::error(Rule::Sight, message, fix)
                .about_bodies([a.name.as_str(), b.name.as_str()]),
        )
    };
    sensor.contrasts.iter().filter_map(finding).collect()
}
