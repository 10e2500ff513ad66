//! No product code reads words of the name of a material: its properties stand in the catalogue, by exact name.

use std::fs;

use super::crates::root;
use super::light::sources;
use super::tokens::{Token, tokens};

/// Rooms of product code.
const ROOMS: [&str; 7] =
    ["geometry", "physics", "calibration", "designs", "fixtures", "simulation", "fabkit"];

/// The catalogue, which alone knows what a colour or a finish beside a name says.
const CATALOGUE: &str = "designs/families/src/materials/";

/// Functions of a text that look into it.
const READERS: [&str; 14] = [
    "to_lowercase",
    "to_uppercase",
    "to_ascii_lowercase",
    "to_ascii_uppercase",
    "contains",
    "starts_with",
    "ends_with",
    "strip_prefix",
    "strip_suffix",
    "split",
    "split_whitespace",
    "find",
    "matches",
    "eq_ignore_ascii_case",
];

/// Returns whether a word of the code stands for the name of a material.
fn is_material(token: &Token) -> bool {
    token.word().is_some_and(|word| {
        ["material", "pigment", "plastic", "filament", "resin"]
            .iter()
            .any(|name| word == *name || word.ends_with(&format!("_{name}")))
    })
}

/// Returns what reads words of a material's name: a function of it, one that is given it, a comparison with a text.
fn readers(code: &str) -> Vec<String> {
    let tokens = tokens(code);
    let mut found = Vec::new();
    for at in 0..tokens.len() {
        let word = |ahead: usize| tokens.get(at + ahead).and_then(Token::word).unwrap_or("");
        let is_sign = |ahead: usize, sign| tokens.get(at + ahead).is_some_and(|t| t.is_sign(sign));
        if is_material(&tokens[at]) {
            let name = word(0);
            if is_sign(1, '.') && READERS.contains(&word(2)) {
                found.push(format!("{name}.{}", word(2)));
            }
            let is_compared = (is_sign(1, '=') || is_sign(1, '!')) && is_sign(2, '=');
            // An empty name is no name: `material != ""`.
            if let Some(Token::Text(text)) = tokens.get(at + 3).filter(|_| is_compared)
                && !text.is_empty()
            {
                found.push(format!("{name} compared with {text:?}"));
            }
        }
        if word(0).starts_with("contains_") && is_sign(1, '(') {
            let end = |token: &&Token| !token.is_sign(',') && !token.is_sign(')');
            if tokens[at + 2..].iter().take_while(end).any(is_material) {
                found.push(word(0).to_owned());
            }
        }
    }
    found
}

#[test]
fn no_code_reads_words_of_materials() {
    let mut found = Vec::new();
    for path in ROOMS.iter().flat_map(|room| sources(&root().join(room))) {
        let name = path.strip_prefix(root()).unwrap().to_string_lossy().replace('\\', "/");
        if name.starts_with(CATALOGUE) {
            continue;
        }
        let code = fs::read_to_string(&path).unwrap();
        found.extend(readers(&code).into_iter().map(|reader| format!("{name}: {reader}")));
    }
    assert!(
        found.is_empty(),
        "ask the body's `substance`, or {CATALOGUE}, for the property:\n{}",
        found.join("\n")
    );
}

#[test]
fn readers_are_found() {
    for code in [
        "fn a(material: &str) -> bool { material.to_lowercase().contains(\"black\") }",
        "let name = body.material.split(' ');",
        "STOCKS.iter().find(|one| contains_words(&body.material, one.word))",
        "if p.shell.soft_material == \"TPU\" { 1 } else { 2 }",
        "p.marker_layer.pigment.to_lowercase()",
    ] {
        assert_eq!(readers(code).len(), 1, "{code}");
    }
    for code in [
        "stock.shade(material)",
        "body.material == other.material",
        "body.material.is_empty() && materials.contains(&body.material)",
        "// material.contains(\"black\")\n#[cfg(test)] mod t { fn a() { material.contains(\"x\") } }",
    ] {
        assert_eq!(readers(code), [""; 0], "{code}");
    }
}
