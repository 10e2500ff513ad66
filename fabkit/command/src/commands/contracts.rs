//! JSON Schemas of the `--json` documents, for programs that read them.

use fabkit_application::{Explained, UnknownName};
use serde_json::Value;

use crate::failure::{ErrorKind, Failure};

/// Schema of each document, by its name in `fabkit schema --output`.
const OUTPUT_SCHEMAS: &[(&str, &str)] = &[
    ("archive", include_str!("../../schemas/archive.json")),
    ("bench", include_str!("../../schemas/bench.json")),
    ("calibrate-extrinsics", include_str!("../../schemas/calibrate-extrinsics.json")),
    ("calibrate-intrinsics", include_str!("../../schemas/calibrate-intrinsics.json")),
    ("calibrate-pins", include_str!("../../schemas/calibrate-pins.json")),
    ("calibrate-plan", include_str!("../../schemas/calibrate-plan.json")),
    ("capture", include_str!("../../schemas/capture.json")),
    ("chain", include_str!("../../schemas/chain.json")),
    ("check", include_str!("../../schemas/check.json")),
    ("completions", include_str!("../../schemas/completions.json")),
    ("dataset", include_str!("../../schemas/dataset.json")),
    ("depth", include_str!("../../schemas/depth.json")),
    ("diff", include_str!("../../schemas/diff.json")),
    ("error", include_str!("../../schemas/error.json")),
    ("export", include_str!("../../schemas/export.json")),
    ("fit-light", include_str!("../../schemas/fit-light.json")),
    ("gel-profile", include_str!("../../schemas/gel-profile.json")),
    ("guide", include_str!("../../schemas/guide.json")),
    ("limits", include_str!("../../schemas/limits.json")),
    ("list", include_str!("../../schemas/list.json")),
    ("man", include_str!("../../schemas/man.json")),
    ("new", include_str!("../../schemas/new.json")),
    ("optics-pack", include_str!("../../schemas/optics-pack.json")),
    ("press", include_str!("../../schemas/press.json")),
    ("probes", include_str!("../../schemas/probes.json")),
    ("profile", include_str!("../../schemas/profile.json")),
    ("reconstruct", include_str!("../../schemas/reconstruct.json")),
    ("render", include_str!("../../schemas/render.json")),
    ("reread", include_str!("../../schemas/reread.json")),
    ("show", include_str!("../../schemas/show.json")),
    ("sweep", include_str!("../../schemas/sweep.json")),
    ("verify", include_str!("../../schemas/verify.json")),
];

/// Returns the JSON Schema of one document.
pub(super) fn schema(name: &str) -> Result<Value, Failure> {
    let names = OUTPUT_SCHEMAS.iter().map(|(name, _)| *name);
    match OUTPUT_SCHEMAS.iter().find(|(known, _)| *known == name) {
        Some((_, text)) => serde_json::from_str(text).map_err(Failure::bug),
        None => {
            let unknown = UnknownName::new("output", name, names);
            let hint = unknown.hint();
            let about = unknown.subject();
            Err(Failure::new(ErrorKind::BadInput, unknown, hint).with_subject(about))
        }
    }
}
