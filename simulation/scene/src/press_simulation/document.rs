//! JSON documents of presses.

use fabkit_elastic::SoftLayer;
use serde_json::{Value, json};

use super::markers::marks_document;
use super::{ContactGap, ContactSolution, PressResult, PressStep};

/// Lists the soft layers as JSON, from the touched one inwards.
///
/// ```
/// use fabkit_scene::press_simulation::{ElasticSolver, soft_layers};
///
/// # let yaml = fabkit_designs::builtin_yaml("gelsight-like").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("gelsight-like.yaml", yaml, &[])?;
/// let bodies = project.press("ball@0mm,0mm,0.3mm")?.bodies;
/// let solver = ElasticSolver::for_press(&project.design.sensor, &bodies, Some(1.0), 1.into())?;
/// let layers = soft_layers(&solver.soft.layers);
/// // The gel of 4 mm is all that is soft here; its coat is thin, and left out.
/// assert_eq!(layers[0]["name"], "gel");
/// assert_eq!(layers[0]["thickness_mm"], 4.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn soft_layers(layers: &[SoftLayer]) -> Value {
    let layer = |layer: &SoftLayer| {
        json!({
            "name": layer.name,
            "material": layer.material,
            "thickness_mm": layer.thickness_mm,
            "young_mpa": layer.elasticity.young_mpa,
            "young_range_mpa": layer.elasticity.young_range_mpa,
            "poissons_ratio": layer.elasticity.poissons_ratio,
            "source": layer.elasticity.source,
        })
    };
    layers.iter().map(layer).collect()
}

/// Returns the solution of a press as JSON, with its difference from rigid contact as the camera sees it.
pub fn visible_solution_document(answer: &ContactSolution, gap: Option<&ContactGap>) -> Value {
    let mut all = self::solution_document(answer);
    all["against_rigid"] = gap.map_or(Value::Null, ContactGap::to_json);
    all
}

/// Returns the solution of a press as JSON.
pub fn solution_document(answer: &ContactSolution) -> Value {
    let PressStep { force_n, moment_nmm, .. } = &answer.step;
    json!({
        "is_simulated": true,
        "layers": soft_layers(answer.layers()),
        "left_out": answer.simplifications(),
        "spacing_mm": answer.spacing_mm(),
        "friction": answer.friction,
        "way_in_sensor_mm": <[f64; 3]>::from(answer.shear_displacement_mm),
        "force_n": <[f64; 3]>::from(*force_n),
        "moment_nmm": <[f64; 3]>::from(*moment_nmm),
        "contact_radius_mm": answer.step.contact_radius_mm,
        "contact_area_mm2": answer.step.contact_area_mm2,
        "max_indentation_mm": answer.step.max_indentation_mm,
        "bulge_mm": answer.step.bulge_mm,
    })
}

/// Returns a press as `fabkit press --json` prints it (`fabkit-press` version 1), without files.
pub fn press_document(pressed: &PressResult) -> Value {
    let step = |step: &PressStep| {
        json!({
            "depth_mm": step.depth_mm,
            "shear_mm": step.shear_mm,
            "force_n": <[f64; 3]>::from(step.force_n),
            "moment_nmm": <[f64; 3]>::from(step.moment_nmm),
            "contact_radius_mm": step.contact_radius_mm,
            "contact_area_mm2": step.contact_area_mm2,
            "max_indentation_mm": step.max_indentation_mm,
            "bulge_mm": step.bulge_mm,
        })
    };
    let mut document = json!({
        "format": "fabkit-press",
        "version": 1,
        "press": pressed.id,
        "contact_level": pressed.level.name(),
        "is_simulated": true,
        "layers": soft_layers(&pressed.soft.layers),
        "left_out": pressed.soft.simplifications,
        "nodes": pressed.nodes,
        "spacing_mm": pressed.spacing_mm,
        "warning": pressed.warning(),
        "friction": pressed.friction,
        "stiffness_n_mm": pressed.stiffness_n_mm(),
        "force_range_n": pressed.force_range_n(),
        "marks": marks_document(&pressed.marks),
        "curve": pressed.steps.iter().map(step).collect::<Vec<_>>(),
    });
    // The state at full depth is repeated at the top level, beside the curve.
    if let (Some(last), Some(document)) = (pressed.last().map(step), document.as_object_mut())
        && let Value::Object(last) = last
    {
        document.extend(last.into_iter().filter(|(key, _)| key != "depth_mm"));
        document.insert("depth_mm".into(), json!(pressed.last().map(|step| step.depth_mm)));
    }
    document
}
