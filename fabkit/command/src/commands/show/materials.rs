//! Materials of a design, for `fabkit show`.

use fabkit_application::designs::materials::{Castable, MaterialOrigin};

use super::row;
use crate::table::{Align::Left, wrapped_table};

/// Formats one line for each cast material; empty if there is none.
pub(super) fn text(materials: &[Castable]) -> String {
    if materials.is_empty() {
        return String::new();
    }
    let mut rows =
        vec![row(["material", "density", "cure", "pot life", "shrinks", "hardness", "from"])];
    for castable in materials {
        let material = castable.material();
        let figures = &material.figures;
        let known = |text: Option<String>| text.unwrap_or_else(|| "-".into());
        let from = match &material.origin {
            MaterialOrigin::BuiltIn => "built-in".to_owned(),
            MaterialOrigin::UserDefined(file) => file.clone(),
            MaterialOrigin::Changed(file) => format!("{file}, over built-in"),
        };
        rows.push(vec![
            material.name.clone(),
            figures.density.to_string(),
            figures.cure.time.to_string(),
            known(figures.pot_life.map(|f| f.to_string())),
            known(figures.shrinkage.map(|f| f.to_string())),
            known(figures.hardness.map(|f| f.to_string())),
            from,
        ]);
    }
    format!("\n{}", wrapped_table(&[Left; 7], &rows))
}
