//! Lines about what is not known, for people: material properties that no source states, and what images do not tell. They
//! follow from a command's JSON, so that no command's text can leave out what its JSON says.

use serde_json::Value;

use super::Outcome;

/// Adds a line for each entry below a `not_known` of the JSON that the text does not name yet.
pub(super) fn add_lines(outcome: &mut Outcome) {
    let mut lines = Vec::new();
    collect(&outcome.json, &mut lines);
    for Line { subject, text } in lines {
        if !names(&outcome.text, &subject) {
            outcome.text += &text;
        }
    }
}

/// Line of a text.
struct Line {
    /// Words that a text has which says the same in a sentence of its own, as for a finding of a rule.
    subject: String,
    text: String,
}

/// Returns whether a text names the subject, and not one whose name is longer.
fn names(text: &str, subject: &str) -> bool {
    text.match_indices(subject).any(|(at, _)| {
        let next = text[at + subject.len()..].chars().next();
        next.is_none_or(|next| matches!(next, ';' | ',' | '\n'))
    })
}

/// Collects subjects, with a remedy or a reason, in the order of the JSON.
fn collect(json: &Value, lines: &mut Vec<Line>) {
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
fn line(unknown: &Value) -> Option<Line> {
    let text = |key: &str| Some(unknown[key].as_str()?.to_owned());
    if let (Some(what), Some(why)) = (text("what"), text("why")) {
        let subject = format!("not compared: {}", what.replace('_', " "));
        return Some(Line { text: format!("{subject}; {why}\n"), subject });
    }
    let (property, material) = (text("property")?, text("material")?);
    let bodies = unknown["bodies"].as_array().map(Vec::as_slice).unwrap_or_default();
    let bodies: Vec<&str> = bodies.iter().filter_map(Value::as_str).collect();
    // Bodies that name no material stand for it.
    let owner = if material.is_empty() { bodies.join(", ") } else { material };
    let subject = format!("{property} of {owner}");
    Some(Line { text: format!("not known: {subject}; {}\n", text("remedy")?), subject })
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn each_property_that_the_text_leaves_out_gets_one_line() {
        let unknown = |property: &str, material: &str| {
            let remedy = format!("state {property}");
            json!({ "property": property, "material": material, "remedy": remedy })
        };
        let json = json!({
            "light": { "not_known": [unknown("gloss", "paint"), unknown("scattering", "gel")] },
            "rules": { "not_known": [unknown("price", "gel")] },
            "views": [{ "not_known": [unknown("gloss", "paint")] }],
            "not_known": [{ "what": "its_size", "why": "no image" }],
        });
        let text = "gloss of paint B\nnot known[flow]: price of gel\nnot known: scattering of gel, price of gel\n"
            .to_owned();
        let mut outcome = Outcome { text: text.clone(), json, failed: false };
        add_lines(&mut outcome);
        let lines = "not known: gloss of paint; state gloss\nnot compared: its size; no image\n";
        assert_eq!(outcome.text, text + lines);
    }
}
