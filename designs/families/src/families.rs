//! Table of sensor families, the only place where each is registered, and of the built-in sensors: every file of
//! `sensors/`.

mod cap;
mod dome;
mod flat_gel;
mod half_ellipsoid;
mod pin_tip;
mod sheet_mold;

use crate::FamilyEntry;

/// All families.
pub(crate) const FAMILIES: &[FamilyEntry] = &[
    FamilyEntry::new::<cap::CapFamily>(),
    FamilyEntry::new::<dome::DomeFamily>(),
    FamilyEntry::new::<flat_gel::FlatGelFamily>(),
    FamilyEntry::new::<half_ellipsoid::HalfEllipsoidFamily>(),
    FamilyEntry::new::<pin_tip::PinTipFamily>(),
    FamilyEntry::new::<sheet_mold::SheetMoldFamily>(),
];

/// All built-in sensors: name, and YAML text from `sensors/`.
pub(crate) const SENSORS: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/sensors.rs"));
