//! Scene described by the options of a command line.

use std::sync::Arc;

use fabkit_application::capturing::{LightConstants, Unit, select_lighting as lit_by};
use fabkit_application::fixtures::Project;
use fabkit_application::geometry::Lighting;
use fabkit_application::ground_truth::{SurfaceCoverage, Viewpoint};
use fabkit_application::scene::{SensorView, join_causes};
use fabkit_application::source::{Source, Target};

use super::{ErrorKind, Failure};
use crate::cli::{CameraArgs, Design, LightArgs};
use crate::roles::FileRoles;

/// Lists the files from which design, camera and pose are read.
pub(super) fn roles(design: &Design, camera: &CameraArgs) -> FileRoles {
    FileRoles::default()
        .reads("SENSOR", Target::new(&design.sensor).files())
        .reads_camera(&camera.camera)
        .reads("--pose", &camera.pose)
}

pub(super) fn build_scene(design: &Design, camera: &CameraArgs) -> Result<SensorView, Failure> {
    build_unit_scene(design, camera, None)
}

/// Builds the scene of one unit.
pub(super) fn build_unit_scene(
    design: &Design,
    camera: &CameraArgs,
    unit: Option<Unit>,
) -> Result<SensorView, Failure> {
    let (project, viewpoint) = load_viewpoint(design, camera, unit)?;
    Ok(SensorView::new(project, viewpoint)?)
}

/// Loads the sensor, or one unit of it, and its camera's viewpoint.
pub(super) fn load_viewpoint(
    design: &Design,
    camera: &CameraArgs,
    unit: Option<Unit>,
) -> Result<(Arc<Project>, Viewpoint), Failure> {
    let target = Target::new(&design.sensor);
    if let Some(name) = target.fixture.or(target.part) {
        let message = format!("ground truth is for a whole sensor, not for its {name}");
        let hint = format!("write `{}`, and name the press with --press", target.sensor);
        return Err(Failure::new(ErrorKind::BadInput, message, hint));
    }
    let source = Source::find(target.sensor)?;
    let project = match unit {
        None => source.load(&design.set)?,
        Some(unit) => source.load_unit(unit, &design.set)?,
    };
    let viewpoint = super::camera_files::load_viewpoint(
        &project,
        camera.camera.as_deref(),
        camera.pose.as_deref(),
    )?;
    Ok((Arc::new(project), viewpoint))
}

/// Finds the selected lighting and its constants.
pub(super) fn find_lighting<'a>(
    project: &'a Project,
    args: &LightArgs,
) -> Result<(&'a Lighting, LightConstants), Failure> {
    Ok(lit_by(project, args.light.as_deref(), args.constants.as_deref())?)
}

/// Returns the viewpoint of a lighting's own camera, unless another camera was named.
pub(super) fn lighting_viewpoint(
    lighting: &Lighting,
    args: &CameraArgs,
    viewpoint: Viewpoint,
) -> Result<Viewpoint, Failure> {
    match &lighting.camera {
        Some(camera) if args.camera.is_none() && args.pose.is_none() => {
            Viewpoint::new(camera, None, None).map_err(Failure::bug)
        }
        _ => Ok(viewpoint),
    }
}

/// Share of the surface below which a camera is probably misplaced, which is then stated.
const MIN_COVERAGE: f64 = 0.5;

/// Formats the visible share of the surface, and the reasons for the rest; with more details below [`MIN_COVERAGE`].
pub(super) fn coverage_text(coverage: &SurfaceCoverage) -> String {
    let SurfaceCoverage { area, lost, area_mm2, angles_rad, lens_rad } = coverage;
    let rest = if lost.is_empty() { String::new() } else { format!("; {}", join_causes(lost)) };
    let share =
        format!("the camera sees {:.1} % of the surface's {area_mm2:.0} mm2{rest}", 100.0 * area);
    if *area >= MIN_COVERAGE {
        return format!("{share}\n");
    }
    format!(
        "warning: {share}; the surface lies {:.0} to {:.0} deg off the camera's axis, the lens reaches {:.0} deg\n",
        angles_rad[0].to_degrees(),
        angles_rad[1].to_degrees(),
        lens_rad.to_degrees(),
    )
}
