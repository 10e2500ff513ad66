//! `fabkit list`

use fabkit_application::designs;
use fabkit_application::source::Source;
use serde_json::json;

use super::Outcome;
use crate::failure::Failure;

pub(super) fn run() -> Result<Outcome, Failure> {
    let mut text = String::new();
    let mut sensors = Vec::new();
    for name in designs::builtin_names() {
        let project = Source::find(name)?.load(&[])?;
        let (design, fixtures) = (&project.design, project.fixture_names());
        let sensor = &design.sensor;
        let parts: Vec<&str> = sensor.parts().map(|body| body.name.as_str()).collect();
        let layers: Vec<&str> = sensor.layers().map(|body| body.name.as_str()).collect();
        let components: Vec<&str> = sensor.components().map(|body| body.name.as_str()).collect();
        text += &format!("{name}: {}\n", design.sensor.title);
        for (label, names) in [
            ("parts", &parts),
            ("layers", &layers),
            ("components", &components),
            ("fixtures", &fixtures),
        ] {
            text += &format!("  {label:<11} {}\n", names.join(", "));
        }
        sensors.push(json!({
            "name": name,
            "title": design.sensor.title,
            "reference": design.sensor.reference,
            "parts": parts,
            "layers": layers,
            "components": components,
            "fixtures": fixtures,
        }));
    }
    let json = json!({ "format": "fabkit-list", "version": 1, "sensors": sensors });
    Ok(Outcome { text, json, failed: false })
}
