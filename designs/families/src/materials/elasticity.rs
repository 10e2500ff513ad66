//! Elasticity of rubbers and gels: stated figures, or estimates from the hardness.

use fabkit_geometry::{Elasticity, MaterialClass, Shore};

use super::stock::shore;
use super::{Material, Pressure};

/// Default Poisson's ratio of rubbers and gels. Their bulk moduli of about 1 GPa would give 0.4999 and more; above
/// 0.495 the result of pressing such thin layers hardly changes any more.
const POISSONS_RATIO: f64 = 0.495;

/// Factor by which moduli of equal hardness scatter, to either side.
const SPREAD: f64 = 1.5;

/// Shore A hardness below which Gent's relation, which was found for rubbers, gives far too high a modulus.
const SOFTEST_SHORE_A: f64 = 20.0;

/// Returns the elasticity of a material that is cast, sprayed or painted.
pub(super) fn elasticity_from_castable(
    material: &Material,
    sort: Option<MaterialClass>,
) -> Option<Elasticity> {
    let figures = &material.figures;
    let mpa = |figure: Option<Pressure>| figure.map(|Pressure(kpa)| kpa / 1e3);
    let by_hardness = || elasticity_from_shore(sort?, figures.hardness.map(shore)?);
    let Some(young_mpa) = mpa(figures.youngs_modulus) else {
        let found = by_hardness()?;
        return Some(Elasticity {
            poissons_ratio: figures.poissons_ratio.unwrap_or(found.poissons_ratio),
            friction: figures.friction,
            ..found
        });
    };
    let path = format!("materials.{}.youngs_modulus", material.name);
    let setting = material.settings.iter().find(|setting| setting.path == path);
    let said = setting.map(|setting| (setting.source.kind.word(), &setting.source.note));
    let source =
        said.map(
            |(kind, note)| {
                if note.is_empty() { kind.to_owned() } else { format!("{kind}: {note}") }
            },
        );
    let least = mpa(figures.youngs_modulus_least).unwrap_or(young_mpa / SPREAD);
    let most = mpa(figures.youngs_modulus_most).unwrap_or(young_mpa * SPREAD);
    Some(Elasticity {
        young_mpa,
        // A stated range need not contain the stated value; this one does.
        young_range_mpa: [least.min(young_mpa), most.max(young_mpa)],
        poissons_ratio: figures.poissons_ratio.unwrap_or(POISSONS_RATIO),
        friction: figures.friction,
        source: source.or_else(|| figures.source.clone()).unwrap_or_default(),
    })
}

/// Estimates the elasticity of a rubber from its Shore A hardness; `None` for other sorts and scales. Formula: A. N.
/// Gent, On the relation between indentation hardness and Young's modulus, Rubber Chemistry and Technology 31 (1958).
pub(super) fn elasticity_from_shore(sort: MaterialClass, shore: Shore) -> Option<Elasticity> {
    let Shore::A(value) = shore else { return None };
    if !matches!(sort, MaterialClass::Rubber | MaterialClass::Silicone) || value < SOFTEST_SHORE_A {
        return None;
    }
    // Gent's formula, with the Shore A hardness as value and the result in MPa.
    let young_mpa = 0.0981 * (56.0 + 7.623_36 * value) / (0.137_505 * (254.0 - 2.54 * value));
    Some(Elasticity {
        young_mpa,
        young_range_mpa: [young_mpa / SPREAD, young_mpa * SPREAD],
        poissons_ratio: POISSONS_RATIO,
        friction: None,
        source: format!("Gent 1958, from {shore}"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_rubber_hardness_gives_a_modulus() {
        // The paper's curve passes 1.15 MPa at 30 and 5.5 MPa at 70, read to a tenth.
        let young = |value| {
            elasticity_from_shore(MaterialClass::Rubber, Shore::A(value)).unwrap().young_mpa
        };
        assert!((young(30.0) - 1.15).abs() < 0.1 && (young(70.0) - 5.5).abs() < 0.6);
        assert_eq!(elasticity_from_shore(MaterialClass::Rubber, Shore::OO(30.0)), None);
        assert_eq!(elasticity_from_shore(MaterialClass::Silicone, Shore::A(10.0)), None);
        assert_eq!(elasticity_from_shore(MaterialClass::Acrylic, Shore::A(90.0)), None);
    }
}
