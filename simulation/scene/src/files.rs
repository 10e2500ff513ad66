//! Reading of camera and pose files.

use std::path::{Path, PathBuf};

use fabkit_camera::files::{
    CameraFile, InvalidCameraFile, MAX_FILE_BYTES, PoseFile, read_file, read_pose,
    split_camera_name,
};
use fabkit_files::Error;
use fabkit_files::reading::MAX_YAML_BYTES;
use fabkit_files::reading::{self, ExpectedFile};
use fabkit_fixtures::Project;

use super::SceneError;
use crate::ground_truth::Viewpoint;

const CAMERA_FILE: ExpectedFile = ExpectedFile {
    what: "a camera file",
    max_bytes: MAX_FILE_BYTES as u64,
    hint: "is it the right file? It holds a lens and an image size",
};
const POSE_FILE: ExpectedFile = ExpectedFile {
    what: "a pose file",
    max_bytes: MAX_YAML_BYTES,
    hint: "is it the right file? It holds the matrix `camera_from_sensor`",
};

/// Contents of calibration files: a camera, and a pose.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ViewpointFiles {
    /// Camera of the file that is given, else of the one that the pose file names.
    pub camera: Option<CameraFile>,
    /// Parsed pose.
    pub pose: Option<PoseFile>,
}

impl ViewpointFiles {
    /// Reads the files and checks that they form a viewpoint. A pose file brings the camera file that it names, unless
    /// `camera` is given.
    ///
    /// # Errors
    /// Names each file that cannot be read or holds no camera or pose.
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
        let pose = pose_path.map(|path| reading::read_text(path, POSE_FILE)).transpose()?;
        let of_pose = |error| SceneError::viewpoint(pose_path, error);
        let pose = pose.map(|text| read_pose(&text)).transpose();
        let pose = pose.map_err(|error| of_pose(error.into()))?;
        // A pose is only valid with the camera it was solved with, so that one is the default.
        let beside = pose_path.zip(pose.as_ref().and_then(|pose| pose.camera.as_ref()));
        let beside = beside.map(|(path, camera)| path.with_file_name(camera));
        let camera_path = camera.or(beside.as_deref());
        let of_camera = |error| SceneError::viewpoint(camera_path, error);
        let camera = match camera_path {
            None => None,
            Some(path) => Some(read_camera_file(path)?.map_err(|error| of_camera(error.into()))?),
        };
        let nominal = &project.design.sensor.camera;
        // The camera is checked alone first, so that each fault is reported with its own file.
        Viewpoint::from_files(nominal, camera.as_ref(), None).map_err(of_camera)?;
        let viewpoint =
            Viewpoint::from_files(nominal, camera.as_ref(), pose.as_ref()).map_err(of_pose)?;
        Ok((Self { camera, pose }, viewpoint))
    }
}

/// Splits `FILE#NAME`, as `--camera` and pose files name one camera of several, into the file and the name.
pub fn split_camera_path(path: &Path) -> (PathBuf, Option<String>) {
    split_camera_name(path, Path::exists)
}

/// Reads a camera file; `FILE#NAME` selects one camera of several. The inner result has the faults of the content.
///
/// # Errors
/// Names a file that cannot be read.
pub fn read_camera_file(path: &Path) -> Result<Result<CameraFile, InvalidCameraFile>, Error> {
    let (file, name) = split_camera_path(path);
    let text = reading::read_text(&file, CAMERA_FILE)?;
    Ok(read_file(&text, name.as_deref()))
}

/// Returns the viewpoint of a design, with the camera and pose of calibration files where given. A pose file brings the
/// camera file that it names, unless `camera` is given.
///
/// # Errors
/// Names each file that cannot be read or holds no camera or pose.
///
/// ```
/// use std::path::Path;
///
/// use fabkit_scene::viewpoint_from_files;
///
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// let nominal = viewpoint_from_files(&project, None, None)?;
/// assert_eq!(nominal.sensor_from_camera, project.design.sensor.camera.sensor_from_camera);
/// let missing = viewpoint_from_files(&project, Some(Path::new("no-such-camera.yaml")), None).unwrap_err();
/// assert!(missing.to_string().contains("no-such-camera.yaml"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn viewpoint_from_files(
    project: &Project,
    camera: Option<&Path>,
    pose: Option<&Path>,
) -> Result<Viewpoint, Error> {
    ViewpointFiles::with_viewpoint(project, camera, pose).map(|(_, viewpoint)| viewpoint)
}
