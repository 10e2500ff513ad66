//! What calibration files say of a camera and its place.

use std::path::Path;

use fabkit_camera::files::{PoseFile, read_pose};
use fabkit_files::Error;
use fabkit_files::reading::MAX_YAML_BYTES;
use fabkit_files::reading::{self, Expected};
use fabkit_fixtures::Project;

use super::SceneError;
use crate::ground_truth::Viewpoint;

/// What calibration files say: the content of a camera file, and a pose.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ViewpointFiles {
    /// The one named, else the one that the pose was solved with.
    pub camera: Option<String>,
    /// The pose.
    pub pose: Option<PoseFile>,
}

impl ViewpointFiles {
    /// Reads them, and looks whether they make a viewpoint: a pose file brings the camera that it
    /// names, unless another is given.
    ///
    /// # Errors
    /// Files that cannot be read or hold no camera or pose, each named.
    pub fn read(
        project: &Project,
        camera: Option<&Path>,
        pose: Option<&Path>,
    ) -> Result<Self, Error> {
        Self::with_viewpoint(project, camera, pose).map(|(files, _)| files)
    }

    fn with_viewpoint(
        project: &Project,
        camera: Option<&Path>,
        pose_path: Option<&Path>,
    ) -> Result<(Self, Viewpoint), Error> {
        let pose_hint = "is it the right file? It holds the matrix `camera_from_sensor`";
        let pose = read(pose_path, "a pose file", pose_hint)?;
        let of_pose = |error| SceneError::viewpoint(pose_path, error);
        let pose = pose.map(|text| read_pose(&text)).transpose();
        let pose = pose.map_err(|error| of_pose(error.into()))?;
        // A pose is only good with the camera it was solved with: unless told otherwise, that one.
        let beside = pose_path.zip(pose.as_ref().and_then(|pose| pose.camera.as_ref()));
        let beside = beside.map(|(path, camera)| path.with_file_name(camera));
        let camera_path = camera.or(beside.as_deref());
        let camera_hint = "is it the right file? It holds a lens and an image size";
        let camera = read(camera_path, "a camera file", camera_hint)?;
        let nominal = &project.design.sensor.camera;
        // One after the other, so that each fault is told with its file.
        Viewpoint::new(nominal, camera.as_deref(), None)
            .map_err(|error| SceneError::viewpoint(camera_path, error))?;
        let viewpoint =
            Viewpoint::new(nominal, camera.as_deref(), pose.as_ref()).map_err(of_pose)?;
        Ok((Self { camera, pose }, viewpoint))
    }
}

/// The camera of a design, or what calibration files say instead. A pose file brings the camera
/// that it names, unless another is given.
///
/// # Errors
/// Files that cannot be read or hold no camera or pose, each named.
pub fn viewpoint_from_files(
    project: &Project,
    camera: Option<&Path>,
    pose: Option<&Path>,
) -> Result<Viewpoint, Error> {
    ViewpointFiles::with_viewpoint(project, camera, pose).map(|(_, viewpoint)| viewpoint)
}

fn read(
    path: Option<&Path>,
    what: &'static str,
    hint: &'static str,
) -> Result<Option<String>, Error> {
    let expected = Expected { what, max_bytes: MAX_YAML_BYTES, hint };
    Ok(path.map(|path| reading::read_text(path, expected)).transpose()?)
}
