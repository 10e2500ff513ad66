//! Camera files of options: they are read, and what is unusual about them is said at once, and in the JSON of whichever
//! command read them.

use std::path::Path;
use std::sync::Mutex;

use fabkit_application::calibration_runs::extrinsics;
use fabkit_application::camera::CameraEstimate;
use fabkit_application::fixtures::Project;
use fabkit_application::ground_truth::Viewpoint;
use fabkit_application::scene::viewpoint_from_files;
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::terminal;

/// Warnings of this run, for its JSON. Kept here, so that no command has to pass them on.
static WARNINGS: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// Prints warnings about input files at once: they concern all that follows, and a long command is better stopped early.
fn print_warnings(warnings: &[String]) {
    for warning in warnings {
        terminal::tell(&format!("warning: {warning}\n"));
    }
    if let Ok(mut all) = WARNINGS.lock() {
        all.extend_from_slice(warnings);
    }
}

/// Moves the warnings of this run to its JSON.
pub(super) fn move_warnings_to(json: &mut Value) {
    let warnings = WARNINGS.lock().map(|mut all| std::mem::take(&mut *all)).unwrap_or_default();
    if let (false, Value::Object(document)) = (warnings.is_empty(), json) {
        document.insert("camera_warnings".into(), json!(warnings));
    }
}

/// Reads a camera file, and prints what is unusual about it.
pub(super) fn read_camera(path: &Path) -> Result<CameraEstimate, Failure> {
    let file = extrinsics::read_camera(path)?;
    print_warnings(&file.warnings());
    Ok(file.estimate)
}

/// Returns the viewpoint of camera and pose files, and prints what is unusual about them.
pub(super) fn load_viewpoint(
    project: &Project,
    camera: Option<&Path>,
    pose: Option<&Path>,
) -> Result<Viewpoint, Failure> {
    let viewpoint = viewpoint_from_files(project, camera, pose)?;
    print_warnings(viewpoint.warnings());
    Ok(viewpoint)
}
