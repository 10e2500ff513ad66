//! Parts to which a printer profile applies.

use std::collections::BTreeSet;

use fabkit_designs::Design;
use fabkit_designs::profile::{ProcessProfile, ProfileMatch};
use fabkit_export::{ProfileEntry, UncompensatedBody};
use fabkit_geometry::Body;

use super::{ExportOptions, ExportRunError, pieces, select_bodies};

/// Checks that the profile applies to a part of at least one design. A profile without effect is most likely a mistake;
/// of several designs, some may have no matching part.
///
/// # Errors
/// [`ExportRunError::ProfileUnused`] if it applies to no part, [`ExportRunError::ProfileWithoutFiles`] if no requested
/// file can apply it, and names that no body has.
pub fn require_profile_applies<'a>(
    designs: impl IntoIterator<Item = &'a Design>,
    options: &ExportOptions,
) -> Result<(), ExportRunError> {
    let Some(profile) = options.profile.as_ref().filter(|_| !options.nominal) else {
        return Ok(());
    };
    let name = || profile.name.as_str().to_owned();
    if !options.has_printed_files() {
        return Err(ExportRunError::ProfileWithoutFiles { profile: name() });
    }
    let (mut made, mut has_process) = (BTreeSet::new(), false);
    for design in designs {
        let sensor = &design.sensor;
        let pieces = pieces::pieces(sensor, select_bodies(sensor, &options.parts)?)?;
        for body in pieces.iter().flat_map(|piece| &piece.bodies) {
            match match_profile(profile, body) {
                ProfileMatch::Match => return Ok(()),
                ProfileMatch::OtherMaterial if options.profile_for_any_material => return Ok(()),
                ProfileMatch::OtherMaterial => has_process = true,
                ProfileMatch::OtherProcess => {}
            }
            made.insert(match body.process() {
                Some(process) => format!("{process} of {}", &body.material),
                None => "bought".to_owned(),
            });
        }
    }
    Err(ExportRunError::ProfileUnused {
        profile: name(),
        process: profile.process.process().to_string(),
        material: profile.material.clone(),
        made: made.into_iter().collect(),
        has_process,
    })
}

/// Returns the manifest's entry of the profile; `None` without a profile or for nominal files.
pub(super) fn manifest_entry<'a>(
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
        let because = match match_profile(profile, body) {
            ProfileMatch::Match => {
                entry.applied.push(name());
                continue;
            }
            ProfileMatch::OtherMaterial if options.profile_for_any_material => {
                entry.applied.push(name());
                entry.applied_to_other_material.push(name());
                continue;
            }
            ProfileMatch::OtherMaterial => "other-material",
            ProfileMatch::OtherProcess => "other-process",
        };
        let (process, material) = (body.process_word(), body.material.to_owned());
        entry.not_applied.push(UncompensatedBody {
            part: name(),
            process,
            material,
            because: because.to_owned(),
        });
    }
    Some(entry)
}

fn match_profile(profile: &ProcessProfile, body: &Body) -> ProfileMatch {
    body.process()
        .map_or(ProfileMatch::OtherProcess, |process| profile.match_part(process, &body.material))
}
