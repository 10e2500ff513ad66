//! Match of a profile with a part: same process and same material as the coupon.

use fabkit_geometry::Process;

use super::ProcessProfile;
use crate::materials::StockCatalogue;

/// Match between a profile and a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProfileMatch {
    /// Same process and material.
    Match,
    /// Same process, but another material, which shrinks differently.
    OtherMaterial,
    /// Another process.
    OtherProcess,
}

impl ProcessProfile {
    /// Returns whether the profile applies to a part made by `process` from `material`: the same entry of the catalogue, or
    /// the same name where it has none. Case and punctuation do not matter, nor does the colour of filament.
    ///
    /// ```
    /// use fabkit_designs::profile::{ProcessProfile, ProfileMatch};
    /// use fabkit_geometry::Process;
    /// let yaml = "
    /// format: 1
    /// name: my-printer
    /// process: fdm
    /// material: PLA
    /// shrinkage_percent: {x: 0.3, y: 0.3, z: 0.0}
    /// holes: {offset: -0.2 mm, gain: 1.0, smallest: 2 mm, largest: 12 mm}
    /// pins: {offset: 0.1 mm, gain: 1.0, smallest: 2 mm, largest: 8 mm}
    /// elephant_foot: 0.1 mm
    /// ";
    /// let profile = ProcessProfile::read("my-printer.yaml", yaml)?;
    /// assert_eq!(profile.match_part(Process::Fdm, "black PLA"), ProfileMatch::Match);
    /// assert_eq!(profile.match_part(Process::Fdm, "PLA+"), ProfileMatch::OtherMaterial);
    /// assert_eq!(profile.match_part(Process::Sla, "PLA"), ProfileMatch::OtherProcess);
    /// # Ok::<(), fabkit_designs::parameters::InvalidDesign>(())
    /// ```
    pub fn match_part(&self, process: Process, material: &str) -> ProfileMatch {
        if process != self.process.process() {
            ProfileMatch::OtherProcess
        } else if is_same_material(process, [material, &self.material]) {
            ProfileMatch::Match
        } else {
            ProfileMatch::OtherMaterial
        }
    }
}

/// Returns whether two names mean the same material. A colour does not change the shrinkage of filament. In resin, a pigment
/// absorbs the light that cures it, so that holes close differently: there a colour makes another material.
fn is_same_material(process: Process, names: [&str; 2]) -> bool {
    let [(a, beside_a), (b, beside_b)] = names.map(|name| StockCatalogue::builtin().identity(name));
    a == b && (process == Process::Fdm || beside_a == beside_b)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn profile(process: &str, material: &str) -> ProcessProfile {
        let yaml = format!(
            "format: 1\nname: p\nprocess: {process}\nmaterial: \"{material}\"\n\
             shrinkage_percent: {{x: 0.5, y: 0.0, z: 0.0}}\n\
             holes: {{offset: 0 mm, gain: 1, smallest: 2 mm, largest: 12 mm}}\n\
             pins: {{offset: 0 mm, gain: 1, smallest: 2 mm, largest: 8 mm}}\n\
             elephant_foot: 0 mm\n"
        );
        ProcessProfile::read("p.yaml", &yaml).unwrap()
    }

    #[test]
    fn colour_matters_for_resin_but_not_for_filament() {
        let pla = profile("fdm", "PLA");
        for same in ["PLA", "black PLA", "pla, Black", "PLA (white)"] {
            assert_eq!(pla.match_part(Process::Fdm, same), ProfileMatch::Match, "{same}");
        }
        for other in ["ABS", "PLA+", "PLA-CF", "silk PLA", "black", ""] {
            assert_eq!(pla.match_part(Process::Fdm, other), ProfileMatch::OtherMaterial, "{other}");
        }
        assert_eq!(pla.match_part(Process::Sla, "PLA"), ProfileMatch::OtherProcess);
        let resin = profile("sla", "tough resin");
        assert_eq!(resin.match_part(Process::Sla, "Tough  Resin"), ProfileMatch::Match);
        assert_eq!(
            resin.match_part(Process::Sla, "tough resin, blue"),
            ProfileMatch::OtherMaterial
        );
        assert_eq!(
            profile("fdm", "black").match_part(Process::Fdm, "white"),
            ProfileMatch::OtherMaterial
        );
    }
}
