//! Elasticity of rubbers and gels: the stated Young's modulus, or an estimate from the stress at 100 % strain, or one
//! from the hardness, in this order. Each says in its `source` which it is.

use fabkit_geometry::{Elasticity, MaterialClass, Shore};

use super::{Material, Pressure, shore};

/// Default Poisson's ratio of rubbers and gels. Their bulk moduli of about 1 GPa would give 0.4999 and more; above
/// 0.495 the result of pressing such thin layers hardly changes any more.
const POISSONS_RATIO: f64 = 0.495;

/// Factor by which moduli of equal hardness scatter, to either side.
const SPREAD: f64 = 1.5;

/// Factor by which moduli from Shore 00 scatter, to either side: makers' moduli of Ecoflex 00-10, 00-30 and 00-50 at
/// 100 % strain (55, 69 and 83 kPa) are 1.2, 0.67 and 0.35 times what the relation gives.
const SPREAD_00: f64 = 3.0;

/// Factor by which moduli of rubbers softer than Shore A 20 scatter, to either side: Gent's relation was found for
/// harder ones, and gives 3.3 times the maker's modulus of Solaris, Shore A 15, at 100 % strain.
const SPREAD_SOFT: f64 = 3.5;

/// Shore A hardness below which Gent's relation is extrapolated.
const SOFTEST_SHORE_A: f64 = 20.0;

/// Young's modulus of a neo-Hookean rubber as a multiple of its engineering stress at 100 % strain: the stress is
/// E / 3 (2 - 1 / 4).
const NEO_HOOKEAN: f64 = 12.0 / 7.0;

/// Part of the stress at 100 % strain below which Young's modulus does not fall: as for the built-in gels.
const SECANT_SPREAD: f64 = 1.2;

/// Returns the elasticity of a material that is cast, sprayed or painted.
pub(super) fn elasticity_from_castable(
    material: &Material,
    sort: Option<MaterialClass>,
) -> Option<Elasticity> {
    let figures = &material.figures;
    let mpa = |figure: Option<Pressure>| figure.map(|Pressure(kpa)| kpa / 1e3);
    let by_hardness = || {
        // What is cast and gives way is a rubber unless its kind says otherwise.
        let class = sort.unwrap_or(MaterialClass::Rubber);
        elasticity_from_shore(class, figures.hardness.map(shore)?)
    };
    let Some(young_mpa) = mpa(figures.youngs_modulus) else {
        let found = mpa(figures.modulus).map(elasticity_from_modulus).or_else(by_hardness)?;
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

/// Estimates the elasticity from the engineering stress at 100 % strain, MPa: that stress, which is the secant modulus.
/// A neo-Hookean rubber of the same stress has 12/7 of it at small strain, which is the highest value.
fn elasticity_from_modulus(stress_mpa: f64) -> Elasticity {
    Elasticity {
        young_mpa: stress_mpa,
        young_range_mpa: [stress_mpa / SECANT_SPREAD, stress_mpa * NEO_HOOKEAN],
        poissons_ratio: POISSONS_RATIO,
        friction: None,
        source: "modulus at 100 % strain".to_owned(),
    }
}

/// Estimates the elasticity of a rubber or a silicone from its Shore A or Shore 00 hardness; `None` for other classes and
/// for Shore D.
///
/// Shore A: A. N. Gent, On the relation between indentation hardness and Young's modulus, Rubber Chemistry and Technology
/// 31 (1958). Shore 00: Hertz's contact of the durometer's ball, 1.19 mm in radius, under the spring's force of 0.203 N
/// and 9.08 mN a degree that ASTM D2240 gives, at the indentation of 25.4 um a degree below 100.
pub(super) fn elasticity_from_shore(sort: MaterialClass, shore: Shore) -> Option<Elasticity> {
    if !matches!(sort, MaterialClass::Rubber | MaterialClass::Silicone) {
        return None;
    }
    let (young_mpa, spread, source) = match shore {
        // The formulas have a pole at 100, where the durometer does not sink in.
        Shore::A(value) if value < 100.0 => {
            let young_mpa =
                0.0981 * (56.0 + 7.623_36 * value) / (0.137_505 * (254.0 - 2.54 * value));
            let spread = if value < SOFTEST_SHORE_A { SPREAD_SOFT } else { SPREAD };
            (young_mpa, spread, format!("Gent 1958, from {shore}"))
        }
        Shore::OO(value) if value < 100.0 => {
            let force_n = 0.203 + 9.08e-3 * value;
            let indentation_mm = 0.0254 * (100.0 - value);
            let plane_strain = 1.0 - POISSONS_RATIO * POISSONS_RATIO;
            let young_mpa =
                0.75 * plane_strain * force_n / (1.19f64.sqrt() * indentation_mm.powf(1.5));
            (young_mpa, SPREAD_00, format!("ASTM D2240 and Hertz, from {shore}"))
        }
        _ => return None,
    };
    Some(Elasticity {
        young_mpa,
        young_range_mpa: [young_mpa / spread, young_mpa * spread],
        poissons_ratio: POISSONS_RATIO,
        friction: None,
        source,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rubber_hardness_gives_a_modulus_with_its_spread() {
        let rubber = |shore| elasticity_from_shore(MaterialClass::Rubber, shore).unwrap();
        // The paper's curve passes 1.15 MPa at 30 and 5.5 MPa at 70, read to a tenth.
        assert!((rubber(Shore::A(30.0)).young_mpa - 1.15).abs() < 0.1);
        assert!((rubber(Shore::A(70.0)).young_mpa - 5.5).abs() < 0.6);
        // Makers' moduli at 100 % strain lie within the range: Solaris, Ecoflex 00-10, 00-30 and 00-50.
        let makers = [
            (Shore::A(15.0), 0.172),
            (Shore::OO(10.0), 0.055),
            (Shore::OO(30.0), 0.069),
            (Shore::OO(50.0), 0.083),
        ];
        for (shore, stress_mpa) in makers {
            let [least, most] = rubber(shore).young_range_mpa;
            assert!((least..=most).contains(&stress_mpa), "{shore}: {least} to {most}");
        }
        assert_eq!(elasticity_from_shore(MaterialClass::Acrylic, Shore::A(90.0)), None);
        assert_eq!(elasticity_from_shore(MaterialClass::Rubber, Shore::D(40.0)), None);
    }

    #[test]
    fn the_stress_at_full_strain_bounds_the_modulus() {
        let gel = elasticity_from_modulus(0.069);
        assert_eq!(gel.young_mpa, 0.069);
        // A neo-Hookean rubber stretched to twice its length bears E / 3 (2 - 1 / 4).
        let most = gel.young_range_mpa[1];
        assert!((most / 3.0 * (2.0 - 0.25) - 0.069).abs() < 1e-12);
    }
}
