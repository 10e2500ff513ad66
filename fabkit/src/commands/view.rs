//! The scene that a command line means.

use std::sync::Arc;

use super::{Exit, Failure};
use crate::cli::{Design, View};
use crate::roles::Roles;
use crate::scene::{Scene, viewpoint_from_files};
use crate::source::{Source, Target};

/// The files that say what is seen, and from where.
pub(super) fn roles(design: &Design, view: &View) -> Roles {
    Roles::default()
        .reads("SENSOR", Target::new(&design.sensor).file())
        .reads("--camera", &view.camera)
        .reads("--pose", &view.pose)
}

pub(super) fn scene(design: &Design, view: &View) -> Result<Scene, Failure> {
    let target = Target::new(&design.sensor);
    if let Some(name) = target.fixture.or(target.part) {
        let message = format!("ground truth is for a whole sensor, not for its {name}");
        let hint = format!("write `{}`; what presses is named with --press", target.sensor);
        return Err(Failure::new(Exit::BadInput, message, hint));
    }
    let project = Source::find(target.sensor)?.load(&design.set)?;
    let viewpoint = viewpoint_from_files(&project, view.camera.as_deref(), view.pose.as_deref())?;
    Scene::new(Arc::new(project), viewpoint)
}
