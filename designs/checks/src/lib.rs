//! Design rules for sensors: bodies do not overlap, molds are the negatives of the layers that are cast in them, air
//! can leave the molds, tools come off, and the casting chain is complete.
//!
//! # Conventions
//!
//! - No rule knows a sensor by name, and none works on triangles: the rules intersect the exact geometry with lines.
//!   Where a rule samples, its resolution is stated in [`RESOLUTION`] and in the rule's file.
//! - Points are in the frame of the assembly in which a finding was made, mm.
//! - The same sensor gives the same findings in the same order on any number of threads.
//!
//! ```
//! use fabkit_checks::{Rule, check, example};
//!
//! let mut sensor = example::puck();
//! assert_eq!(check(&sensor)?.errors(), 0);
//!
//! // The same dish 0.1 mm lower is no longer the puck's negative.
//! sensor.bodies[0].placements[0].assembly_from_body =
//!     fabkit_geometry::Pose::translation(0.0, 0.0, -0.1);
//! let report = check(&sensor)?;
//! assert!(report.findings.iter().any(|f| f.rule == Rule::Casting && f.bodies == ["puck", "dish"]));
//! # Ok::<(), fabkit_checks::InvalidBody>(())
//! ```

mod bonding;
mod camera_view;
mod casting;
mod chain;
mod check;
mod chemistry;
mod circuit;
mod contacts;
mod daylight;
mod declaration;
mod demolding;
pub mod example;
mod finding;
mod flow;
mod glare;
mod hardness;
mod illumination;
mod interference;
mod labels;
mod lens_adjustment;
mod masses;
mod material_questions;
mod memo;
mod motion;
mod opening;
mod outlet;
mod overhang;
mod overlapping_steps;
mod parting;
mod print_stability;
mod printability;
mod retention;
mod rule;
mod rule_input;
mod sampling_lines;
mod scene;
mod slicer_settings;
mod tearing;
mod trapped_air;
mod visibility;

pub use check::{
    CheckReport, ExaminedCount, Progress, check, check_camera_view, check_interference_between,
    check_manual_steps, check_motions, check_rules, check_variant, check_visibility,
    check_with_progress,
};
pub use chemistry::{Harm, Hazard, hazards};
pub use finding::{Finding, MeasuredValue, Severity};
pub use masses::{Batch, batches};
pub use material_questions::UnknownProperty;
pub use memo::Memo;
pub use motion::{Movement, PlacedBody, Stage, stages};
pub use printability::{
    PrintLimits, machine_limits, part_limits, print_limits, printability, thinnest_wall,
};
pub use rule::Rule;
pub use scene::InvalidBody;
pub use slicer_settings::{ChosenSetting, PrintSettings, print_settings};

use declaration::Declaration;

/// All rules for sensors and for kits of loose parts, in the order of reports.
const RULES: [Declaration; 21] = [
    chain::RULE,
    interference::RULE,
    casting::RULE,
    trapped_air::RULE,
    demolding::RULE,
    parting::RULE,
    flow::RULE,
    camera_view::RULE,
    daylight::RULE,
    glare::RULE,
    motion::RULE,
    lens_adjustment::RULE,
    bonding::RULE,
    chemistry::RULE,
    hardness::RULE,
    retention::RULE,
    circuit::RULE,
    labels::RULE,
    printability::RULE,
    print_stability::RULE,
    overhang::RULE,
];

impl Rule {
    /// All rules that [`check`] applies to sensors and to kits of loose parts, in the order of reports.
    pub const ALL: [Self; RULES.len()] = {
        // A `const` cannot use iterators, hence the loop.
        let mut all = [RULES[0].rule; RULES.len()];
        let mut next = 0;
        while next < RULES.len() {
            all[next] = RULES[next].rule;
            next += 1;
        }
        all
    };

    /// Returns what the rule finds, and its limits with their sources, as text for people. `None` for the rules of
    /// [`Rule::HARDWARE`] that are not in [`Rule::ALL`].
    ///
    /// ```
    /// use fabkit_checks::Rule;
    /// for rule in Rule::ALL {
    ///     assert!(rule.description_and_limit().is_some(), "{rule}");
    /// }
    /// // A rule for calibration hardware alone.
    /// assert!(Rule::Seating.description_and_limit().is_none());
    /// ```
    pub fn description_and_limit(self) -> Option<[&'static str; 2]> {
        RULES
            .iter()
            .find(|declared| declared.rule == self)
            .map(|declared| declared.description_and_limit)
    }
}

/// Sampling resolution of the rules, as text for people.
pub const RESOLUTION: &str = "overlap: 20 000 lines per pair; casting: 3 x 8192 lines per layer, \
                              faces within 1e-6 mm are together; air and tools: 320 columns \
                              across, pockets shallower than a column are not seen; \
                              sight: twice 8192 rays from the pupil, not bent, \
                              and 256 places through the drawn bodies; motions: 160 lines \
                              across, turns by steps of at most 0.25 mm";
