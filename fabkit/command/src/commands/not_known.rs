//! Lines about what is not known, for people: material properties that no source states, and what images do not tell. They
//! follow from a command's JSON, so that no command's text can leave out what its JSON says.

use serde_json::Value;

use super::Outcome;

/// Adds a line for each entry below a `not_known` of the JSON that the text does not name yet.
pub(super) fn add_lines(outcome: &mut Outcome) {
    let mut lines = Vec::new();
    collect(&outcome.json, &mut lines);
    for [subject, more] in lines {
        if !outcome.text.contains(&subject) {
            outcome.text += &format!("{subject}; {more}\n");
        }
    }
}

/// Collects subjects, with a remedy or a reason, in the order of the JSON.
fn collect(json: &Value, lines: &mut Vec<[String; 2]>) {
    match json {
        Value::Object(map) => {
            for (key, value) in map {
                match (key.as_str(), value) {
                    ("not_known", Value::Array(all)) => lines.extend(all.iter().filter_map(line)),
                    _ => collect(value, lines),
                }
            }
        }
        Value::Array(items) => items.iter().for_each(|item| collect(item, lines)),
        _ => {}
    }
}

/// Returns a property of a material with what would settle it, or what could not be compared with the reason.
fn line(unknown: &Value) -> Option<[String; 2]> {
    let text = |key: &str| Some(unknown[key].as_str()?.to_owned());
    if let (Some(what), Some(why)) = (text("what"), text("why")) {
        return Some([format!("not compared: {}", what.replace('_', " ")), why]);
    }
    let (property, material) = (text("property")?, text("material")?);
    let bodies = unknown["bodies"].as_array().map(Vec::as_slice).unwrap_or_default();
    let bodies: Vec<&str> = bodies.iter().filter_map(Value::as_str).collect();
    // Bodies that name no material stand for it.
    let owner = if material.is_empty() { bodies.join(", ") } else { material };
    Some([format!("not known: {property} of {owner}"), text("remedy")?])
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn each_property_that_the_text_leaves_out_gets_one_line() {
        let unknown = |property: &str, material: &str| json!({ "property": property, "material": material, "remedy": format!("state {property}") });
        let json = json!({
            "light": { "not_known": [unknown("gloss", "paint"), unknown("scattering", "gel")] },
            "views": [{ "not_known": [unknown("gloss", "paint")] }],
            "not_known": [{ "what": "its_size", "why": "no image" }],
        });
        let text = "not known: scattering of gel, and so on\n".to_owned();
        let mut outcome = Outcome { text: text.clone(), json, failed: false };
        add_lines(&mut outcome);
        let lines = "not known: gloss of paint; state gloss\nnot compared: its size; no image\n";
        assert_eq!(outcome.text, text + lines);
    }
}
