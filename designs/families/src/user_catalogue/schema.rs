//! Sections for user-defined materials, processes, parts and articles in the JSON Schema of sensor files.

use fabkit_text::{Json, Section, section_schema};
use serde_json::json;

use crate::articles::Article;
use crate::materials::{Figures, StockMaterial};
use crate::processes::ProcessFigures;

/// Adds the sections to every definition of a sensor's file.
pub(crate) fn add_to_schema(schema: &mut Json) {
    let Some(definitions) = schema["definitions"].as_object_mut() else { return };
    for definition in definitions.values_mut() {
        definition["properties"]["materials"] = materials();
        definition["properties"]["processes"] = processes();
        definition["properties"]["parts"] = parts();
        definition["properties"]["buy"] = buy();
    }
}

fn materials() -> Json {
    let plain = |of: Json, description: &str| {
        let with_source = json!({
            "type": "object",
            "properties": { "value": of, "source": { "type": "string" }, "note": { "type": "string" } },
            "required": ["value"],
            "additionalProperties": false,
        });
        json!({ "description": description, "anyOf": [of, with_source] })
    };
    let summary =
        "Data of the material; for a material that is already listed, only the data that differ.";
    let mut one = section_schema(&Figures::fields(), summary);
    let share = json!({ "type": "object", "additionalProperties": { "type": "number", "exclusiveMinimum": 0 } });
    let primer = json!({ "type": "object", "additionalProperties": { "type": "string" } });
    one["properties"]["mix"] = plain(share, "Components and their shares by mass.");
    one["properties"]["bonds"] = plain(
        primer,
        "Bonds to other materials: the primer, or `itself` without one; `none` where it does not bond.",
    );
    one["properties"]["extends"] = json!({ "type": "string", "description": "Name of another material, of which the section lists only the changes." });
    let summary = "Data of a material that parts are printed, cut or milled from.";
    let mut stock = section_schema(&StockMaterial::fields(), summary);
    stock["properties"]["extends"] = one["properties"]["extends"].clone();
    if let Some(keys) = stock.as_object_mut() {
        // A change of a known material states what differs.
        keys.remove("required");
    }
    let description = "Materials by name, new ones or changes to the built-in ones: what is cast, and, with `sort` or \
                       by its name, what parts are printed, cut or milled from.";
    let [mut cast, stock] = [one, stock].map(|one| named(&one, description));
    // Both are a map of names to sections or a list: the sections differ.
    for (form, key) in [(0, "additionalProperties"), (1, "items")] {
        let both = json!({ "anyOf": [cast["anyOf"][form][key], stock["anyOf"][form][key]] });
        cast["anyOf"][form][key] = both;
    }
    cast
}

fn processes() -> Json {
    let summary = "Machine on which parts are made. Values not given are those usual for its kind.";
    let mut one = section_schema(&ProcessFigures::fields(), summary);
    let texts = json!({ "type": "array", "items": { "type": "string" }, "maxItems": 32 });
    one["properties"]["materials"] = texts;
    one["properties"]["extends"] = json!({ "type": "string", "description": "Name of another process, of which the section lists only the changes." });
    named(
        &one,
        "Processes by name: new ones, or changes to `fdm`, `sla`, `polyjet`, `laser`, `cnc`.",
    )
}

fn parts() -> Json {
    json!({
        "description": "Processes and materials of parts, by the parts' names; `*` stands for any text.",
        "type": "object",
        "additionalProperties": {
            "type": "object",
            "properties": {
                "process": { "type": "string", "description": "Name of the process by which these parts are made." },
                "material": { "type": "string", "description": "Material of these parts." },
            },
            "additionalProperties": false,
        },
    })
}

fn buy() -> Json {
    let summary =
        "Data of the article; for an article that is already listed, only the data that differ.";
    let mut one = section_schema(&Article::fields(), summary);
    one["properties"]["extends"] = json!({ "type": "string", "description": "Name of another article, of which the section lists only the changes." });
    named(&one, "Articles to buy, by the name of a piece, an article, a component or a kit.")
}

/// Returns the schema of a map of names to sections, or of a list of sections with names in them.
fn named(one: &Json, description: &str) -> Json {
    let mut item = one.clone();
    item["properties"]["name"] = json!({ "type": "string", "description": "Name of the entry." });
    item["required"] = json!(["name"]);
    json!({
        "description": description,
        "anyOf": [
            { "type": "object", "additionalProperties": one },
            { "type": "array", "items": item },
        ],
    })
}
