//! Materials of a design as JSON.

use fabkit_designs::materials::{Bond, BondMethod, Castable, Material, MaterialOrigin};
use serde_json::{Value, json};

/// Lists every material of a design with its properties; unknown ones are null.
///
/// ```
/// use fabkit_application::{materials::materials_json, source::Target};
///
/// let materials = materials_json(&Target::new("rtac0").design(&[])?.materials);
/// let all = materials.as_array().ok_or("no list")?;
/// let sylgard = all.iter().find(|one| one["name"] == "Dow Sylgard 184").ok_or("not known")?;
/// assert_eq!((&sylgard["origin"], &sylgard["density_g_per_cm3"]), (&"built-in".into(), &1.03.into()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn materials_json(materials: &[Castable]) -> Value {
    materials.iter().map(material_json).collect()
}

fn material_json(castable: &Castable) -> Value {
    let Material { name, figures, by_mass, bonds, settings, .. } = castable.material();
    let (origin, file) = origin(castable.material());
    let cure = castable.cure();
    let sources: Vec<Value> = settings
        .iter()
        .map(|setting| {
            json!({
                "path": setting.path,
                "value": setting.value,
                "source": setting.source.kind.word(),
                "note": setting.source.note,
            })
        })
        .collect();
    let hardness = |hardness: fabkit_designs::materials::Hardness| json!({ "scale": hardness.scale.word(), "value": hardness.value });
    json!({
        "name": name,
        "origin": origin,
        "file": file,
        "kind": figures.kind.map(|kind| kind.word()),
        "mix": by_mass.iter().map(|(name, share)| json!({ "name": name, "share": share })).collect::<Value>(),
        "density_g_per_cm3": figures.density.0,
        "cure": { "hours": cure.hours, "celsius": cure.celsius },
        "pot_life_min": figures.pot_life.map(|time| time.0),
        "shrinkage": figures.shrinkage.map(|share| share.share()),
        "breaking_strain": castable.breaking_strain(),
        "hardness": figures.hardness.map(hardness),
        "modulus_kpa": figures.modulus.map(|modulus| modulus.0),
        "refractive_index": figures.refractive_index,
        "clarity": figures.clarity.map(|clarity| clarity.word()),
        "degas": figures.degas,
        "bonds": bonds.iter().map(bond).collect::<Value>(),
        "note": figures.note,
        "sources": sources,
    })
}

fn bond(Bond { to, hold }: &Bond) -> Value {
    let primer = match hold {
        BondMethod::Primer(primer) => Some(primer),
        BondMethod::SelfBonding | BondMethod::NoBond => None,
    };
    json!({ "to": to, "sticks": *hold != BondMethod::NoBond, "primer": primer })
}

/// Returns the origin of a material as one word, and the file it comes from.
pub fn origin(material: &Material) -> (&'static str, Option<&str>) {
    match &material.origin {
        MaterialOrigin::BuiltIn => ("built-in", None),
        MaterialOrigin::UserDefined(file) => ("own", Some(file)),
        MaterialOrigin::Changed(file) => ("changed", Some(file)),
    }
}
