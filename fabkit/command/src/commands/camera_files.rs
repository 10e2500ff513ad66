//! Camera files of options: they are read, and what is unusual about them is said at once.

use std::path::Path;

use fabkit_application::calibration_runs::extrinsics;
use fabkit_application::camera::CameraEstimate;
use fabkit_application::fixtures::Project;
use fabkit_application::ground_truth::Viewpoint;
use fabkit_application::scene::viewpoint_from_files;

use crate::failure::Failure;
use crate::terminal;

/// Prints warnings about input files at once: they concern all that follows, and a long command is better stopped early.
fn print_warnings(warnings: &[String]) {
    for warning in warnings {
        terminal::tell(&format!("warning: {warning}\n"));
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
