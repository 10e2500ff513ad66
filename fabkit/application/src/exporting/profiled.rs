//! Parts to which a printer profile applies.

use std::collections::BTreeSet;

use fabkit_designs::Design;
use fabkit_designs::profile::{ProcessProfile, Suits};
use fabkit_export::{NotApplied, ProfileEntry};
use fabkit_geometry::Body;

use super::{ExportFailure, ExportOptions, chosen, pieces};

/// Checks that the profile applies to a part of at least one design. A profile without effect is most likely a mistake;
/// of several designs, some may have no matching part.
///
/// # Errors
/// [`ExportFailure::ProfileUnused`] if it applies to no part, [`ExportFailure::ProfileWithoutFiles`] if no requested
/// file can apply it, and names that no body has.
pub fn require_profile_applies<'a>(
    designs: impl IntoIterator<Item = &'a Design>,
    options: &ExportOptions,
) -> Result<(), ExportFailure> {
    let Some(profile) = options.profile.as_ref().filter(|_| !options.nominal) else {
        return Ok(());
    };
    let name = || profile.name.as_str().to_owned();
    if !options.prints() {
        return Err(ExportFailure::ProfileWithoutFiles { profile: name() });
    }
    let (mut made, mut has_process) = (BTreeSet::new(), false);
    for design in designs {
        let sensor = &design.sensor;
        let pieces = pieces::pieces(sensor, chosen(sensor, &options.parts)?)?;
        for body in pieces.iter().flat_map(|piece| &piece.bodies) {
            match suits(profile, body) {
                Suits::Yes => return Ok(()),
                Suits::OtherMaterial if options.profile_for_any_material => return Ok(()),
                Suits::OtherMaterial => has_process = true,
                Suits::OtherProcess => {}
            }
            made.insert(match body.process() {
                Some(process) => format!("{process} of {}", &body.material),
                None => "bought".to_owned(),
            });
        }
    }
    Err(ExportFailure::ProfileUnused {
        profile: name(),
        process: profile.process.process().to_string(),
        material: profile.material.clone(),
        made: made.into_iter().collect(),
        has_process,
    })
}

/// Returns the manifest's entry of the profile; `None` without a profile or for nominal files.
pub(super) fn entry<'a>(
    bodies: impl Iterator<Item = &'a Body>,
    options: &ExportOptions,
) -> Option<ProfileEntry> {
    let profile = options.profile.as_ref().filter(|_| !options.nominal)?;
    let mut entry = ProfileEntry {
        name: profile.name.as_str().to_owned(),
        process: profile.process.process().to_string(),
        material: profile.material.clone(),
        for_any_material: options.profile_for_any_material,
        applied: Vec::new(),
        applied_to_other_material: Vec::new(),
        not_applied: Vec::new(),
    };
    for body in bodies {
        let name = || body.name.to_owned();
        let because = match suits(profile, body) {
            Suits::Yes => {
                entry.applied.push(name());
                continue;
            }
            Suits::OtherMaterial if options.profile_for_any_material => {
                entry.applied.push(name());
                entry.applied_to_other_material.push(name());
                continue;
            }
            Suits::OtherMaterial => "other-material",
            Suits::OtherProcess => "other-process",
        };
        let (process, material) = (body.process_word(), body.material.to_owned());
        entry.not_applied.push(NotApplied {
            part: name(),
            process,
            material,
            because: because.to_owned(),
        });
    }
    Some(entry)
}

fn suits(profile: &ProcessProfile, body: &Body) -> Suits {
    body.process().map_or(Suits::OtherProcess, |process| profile.suits(process, &body.material))
}
