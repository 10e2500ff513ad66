//! Liquids that are cast: what is mixed, how it cures, how it shrinks. Figures from the makers' data
//! sheets; a paper's own mixing ratio or cure time goes before them, in the sensor's chain.

use fabkit_geometry::{Cure, Mix};

/// A castable material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Castable {
    /// Maker and product, as sensor files name it.
    pub name: &'static str,
    /// Components and their shares by mass.
    pub by_mass: &'static [(&'static str, f64)],
    /// Density, g/cm^3.
    pub density_g_per_cm3: f64,
    /// Linear shrinkage on curing at room temperature, as a fraction.
    pub shrinkage: f64,
    /// Elongation at break, as a strain: the limit for a tool that is peeled off.
    pub breaking_strain: f64,
    /// Whether it needs a vacuum before pouring.
    pub degas: bool,
    /// How it cures at room temperature.
    pub cure: Cure,
}

const fn hours(hours: f64) -> Cure {
    Cure { hours, celsius: 23.0 }
}

/// Every castable material that fabkit knows, by name.
pub const CASTABLES: &[Castable] = &[
    Castable {
        name: "Dow Sylgard 184",
        by_mass: &[("Sylgard 184 A", 10.0), ("Sylgard 184 B", 1.0)],
        density_g_per_cm3: 1.03,
        // Above 1 % only when it is cured hot.
        shrinkage: 0.001,
        breaking_strain: 1.2,
        degas: true,
        cure: hours(48.0),
    },
    Castable {
        name: "Smooth-On Ecoflex 00-10",
        by_mass: &[("Ecoflex 00-10 A", 1.0), ("Ecoflex 00-10 B", 1.0)],
        density_g_per_cm3: 1.04,
        shrinkage: 0.001,
        breaking_strain: 8.0,
        degas: true,
        cure: hours(4.0),
    },
    Castable {
        name: "Smooth-On Ecoflex 00-30",
        by_mass: &[("Ecoflex 00-30 A", 1.0), ("Ecoflex 00-30 B", 1.0)],
        density_g_per_cm3: 1.07,
        shrinkage: 0.001,
        breaking_strain: 9.0,
        degas: true,
        cure: hours(4.0),
    },
    Castable {
        name: "Smooth-On Ecoflex 00-30 with black Silc-Pig",
        // Kim et al., UVDtact, III-C.
        by_mass: &[("Ecoflex 00-30 A", 5.0), ("Ecoflex 00-30 B", 5.0), ("black Silc-Pig", 1.0)],
        density_g_per_cm3: 1.07,
        shrinkage: 0.001,
        breaking_strain: 9.0,
        degas: true,
        cure: hours(4.0),
    },
    Castable {
        name: "Smooth-On Ecoflex 00-50 with blue UV ink",
        // Kim et al., UVDtact, III-C.
        by_mass: &[("Ecoflex 00-50 A", 10.0), ("Ecoflex 00-50 B", 10.0), ("blue UV ink", 1.0)],
        density_g_per_cm3: 1.07,
        shrinkage: 0.001,
        breaking_strain: 9.8,
        degas: true,
        cure: hours(3.0),
    },
    Castable {
        name: "Smooth-On Ecoflex 00-50 with red UV ink",
        // Kim et al., UVDtact, III-C.
        by_mass: &[("Ecoflex 00-50 A", 10.0), ("Ecoflex 00-50 B", 10.0), ("red UV ink", 1.0)],
        density_g_per_cm3: 1.07,
        shrinkage: 0.001,
        breaking_strain: 9.8,
        degas: true,
        cure: hours(3.0),
    },
    Castable {
        name: "Smooth-On MoldStar 30",
        by_mass: &[("MoldStar 30 A", 1.0), ("MoldStar 30 B", 1.0)],
        density_g_per_cm3: 1.12,
        shrinkage: 0.001,
        breaking_strain: 3.39,
        degas: true,
        cure: hours(6.0),
    },
    Castable {
        name: "Smooth-On Psycho Paint, black",
        // As the white one.
        by_mass: &[("Psycho Paint A", 1.0), ("Psycho Paint B", 1.0), ("Silc Pig black", 0.1)],
        density_g_per_cm3: 1.05,
        shrinkage: 0.0,
        breaking_strain: 6.0,
        degas: false,
        cure: hours(2.0),
    },
    Castable {
        name: "Smooth-On Psycho Paint, white",
        // The maker's ratio for the paint base; the pigment's share is a few percent.
        by_mass: &[("Psycho Paint A", 1.0), ("Psycho Paint B", 1.0), ("Silc Pig white", 0.1)],
        density_g_per_cm3: 1.05,
        shrinkage: 0.0,
        breaking_strain: 6.0,
        degas: false,
        cure: hours(2.0),
    },
    Castable {
        name: "Smooth-On Sil-Poxy",
        by_mass: &[("Sil-Poxy", 1.0)],
        density_g_per_cm3: 1.1,
        shrinkage: 0.0,
        breaking_strain: 7.5,
        degas: false,
        // Handled after minutes; air must reach the inside.
        cure: hours(24.0),
    },
    Castable {
        name: "Smooth-On Psycho Paint with aluminium",
        // The ShadowTac paper names the ingredients, not their shares: chosen so that it covers in
        // one coat and still brushes.
        by_mass: &[
            ("Psycho Paint A", 10.0),
            ("Psycho Paint B", 10.0),
            ("aluminium powder", 2.0),
            ("Silc Pig white", 1.0),
            ("silicone solvent", 20.0),
        ],
        density_g_per_cm3: 1.05,
        shrinkage: 0.0,
        breaking_strain: 3.0,
        degas: false,
        cure: hours(24.0),
    },
    Castable {
        name: "Smooth-On Solaris",
        by_mass: &[("Solaris A", 1.0), ("Solaris B", 1.0)],
        density_g_per_cm3: 0.99,
        shrinkage: 0.001,
        breaking_strain: 2.9,
        degas: true,
        cure: hours(24.0),
    },
    Castable {
        name: "Techsil RTV27905",
        // Ratio, density and cure as usual for two-part clear gels of this softness; the maker's
        // sheet that comes with the batch goes before them.
        by_mass: &[("RTV27905 A", 1.0), ("RTV27905 B", 1.0)],
        density_g_per_cm3: 0.98,
        shrinkage: 0.001,
        breaking_strain: 2.0,
        degas: true,
        cure: hours(24.0),
    },
    Castable {
        name: "Smooth-On Solaris with 40 % thinner",
        // 40 % of the mass of A and B together.
        by_mass: &[("Solaris A", 50.0), ("Solaris B", 50.0), ("Silicone Thinner", 40.0)],
        density_g_per_cm3: 0.98,
        shrinkage: 0.001,
        // Thinner weakens: half of what Solaris bears is a cautious figure, not a measured one.
        breaking_strain: 1.45,
        degas: true,
        cure: hours(24.0),
    },
    Castable {
        name: "Yonglihua PTG-501",
        // The paper's ratio: oil, catalyst, thinner.
        by_mass: &[("PTG-501 silicone oil", 100.0), ("catalyst", 3.0), ("thinner", 500.0)],
        density_g_per_cm3: 0.9,
        shrinkage: 0.0,
        breaking_strain: 3.0,
        degas: false,
        cure: hours(24.0),
    },
];

/// The material of that name.
pub fn castable(name: &str) -> Option<&'static Castable> {
    CASTABLES.iter().find(|material| material.name == name)
}

impl Castable {
    /// What is mixed.
    pub fn mix(&self) -> Mix {
        Mix {
            by_mass: self.by_mass.iter().map(|(name, share)| (name.to_string(), *share)).collect(),
            density_g_per_cm3: self.density_g_per_cm3,
            degas: self.degas,
        }
    }
}

/// Names of all castable materials, for messages.
pub fn castable_names() -> String {
    CASTABLES.iter().map(|material| material.name).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_material_is_plausible() {
        for m in CASTABLES {
            assert!(m.by_mass.iter().all(|(_, share)| *share > 0.0), "{}", m.name);
            assert!((0.5..3.0).contains(&m.density_g_per_cm3), "{}", m.name);
            assert!((0.0..0.05).contains(&m.shrinkage), "{}", m.name);
            assert!(m.cure.hours > 0.0 && m.breaking_strain > 0.0, "{}", m.name);
            assert_eq!(castable(m.name), Some(m));
        }
    }
}
