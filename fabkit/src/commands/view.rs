//! What `depth` and `dataset` share: the sensor's surface and the camera that looks at it.

use std::collections::BTreeSet;
use std::fmt::Display;
use std::path::Path;

use fabkit::camera::files::read_pose;
use fabkit::fixtures::{Press, PressError, Project};
use fabkit::geometry::TouchSurface;
use fabkit::ground_truth::{Coverage, Viewpoint, coverage, penetration};
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::cli::{Design, View};
use crate::failure::{Exit, Failure};
use crate::reading::{self, Expected};
use crate::source::{MAX_YAML_BYTES, Source, Target};

/// Below this share of the surface a camera is taken for misplaced, and said to be.
const LITTLE: f64 = 0.5;

/// A press may go this much past the soft layer: rounding.
const SLACK_MM: f64 = 1e-6;
/// Faults that are listed one by one.
pub(super) const MOST_FAULTS: usize = 50;

/// A sensor whose surface a camera sees.
pub(super) struct Scene {
    pub project: Project,
    pub viewpoint: Viewpoint,
    pub coverage: Coverage,
}

impl Scene {
    pub(super) fn new(design: &Design, view: &View) -> Result<Self, Failure> {
        let target = Target::new(&design.sensor);
        if let Some(name) = target.fixture.or(target.part) {
            let message = format!("ground truth is for a whole sensor, not for its {name}");
            let hint = format!("write `{}`; what presses is named with --press", target.sensor);
            return Err(Failure::new(Exit::BadInput, message, hint));
        }
        let project = Source::find(target.sensor)?.load(&design.set)?;
        let viewpoint = viewpoint(&project, view)?;
        let coverage = coverage(touch(&project)?, &viewpoint).map_err(Failure::bug)?;
        if coverage.area == 0.0 {
            return Err(unseen(&coverage));
        }
        Ok(Self { project, viewpoint, coverage })
    }

    pub(super) fn touch(&self) -> Result<&TouchSurface, Failure> {
        touch(&self.project)
    }

    /// For people; more of it where something may be wrong.
    pub(super) fn coverage_text(&self) -> String {
        let Coverage { area, area_mm2, angles_rad, lens_rad } = self.coverage;
        let share =
            format!("the camera sees {:.1} % of the surface's {area_mm2:.0} mm2", 100.0 * area);
        if area >= LITTLE {
            return format!("{share}\n");
        }
        format!(
            "warning: {share}: it lies {:.0} to {:.0} deg off its axis, the lens reaches {:.0} deg\n",
            angles_rad[0].to_degrees(),
            angles_rad[1].to_degrees(),
            lens_rad.to_degrees(),
        )
    }

    pub(super) fn coverage_json(&self) -> Value {
        json!({ "area": self.coverage.area, "area_mm2": self.coverage.area_mm2 })
    }
}

fn touch(project: &Project) -> Result<&TouchSurface, Failure> {
    let sensor = &project.design.sensor;
    sensor.touch.as_ref().ok_or_else(|| {
        let message = format!("{} has no curved sensing surface to look at", sensor.name);
        Failure::plain(Exit::BadInput, message)
    })
}

fn viewpoint(project: &Project, view: &View) -> Result<Viewpoint, Failure> {
    let pose_hint = "is it the right file? It holds the matrix `camera_from_sensor`";
    let pose = read(view.pose.as_deref(), "a pose file", pose_hint)?;
    let fault = |path: Option<&Path>, error: &dyn Display| {
        let name = path.map_or_else(String::new, |path| format!("{}: ", path.display()));
        Failure::plain(Exit::BadInput, format!("{name}{error}"))
    };
    let of_pose = |error: &dyn Display| fault(view.pose.as_deref(), error);
    let pose = pose.map(|text| read_pose(&text)).transpose().map_err(|error| of_pose(&error))?;
    // A pose is only good with the camera it was solved with: unless told otherwise, that one.
    let beside = view.pose.as_deref().zip(pose.as_ref().and_then(|pose| pose.camera.as_ref()));
    let beside = beside.map(|(path, camera)| path.with_file_name(camera));
    let camera_path = view.camera.as_deref().or(beside.as_deref());
    let camera_hint = "is it the right file? It holds a lens and an image size";
    let camera = read(camera_path, "a camera file", camera_hint)?;
    let nominal = &project.design.sensor.camera;
    // One after the other, so that each fault is told with its file.
    Viewpoint::new(nominal, camera.as_deref(), None).map_err(|error| fault(camera_path, &error))?;
    Viewpoint::new(nominal, camera.as_deref(), pose.as_ref()).map_err(|error| of_pose(&error))
}

fn read(
    path: Option<&Path>,
    what: &'static str,
    hint: &'static str,
) -> Result<Option<String>, Failure> {
    let expected = Expected { what, max_bytes: MAX_YAML_BYTES, hint };
    path.map(|path| reading::text(path, expected)).transpose()
}

fn unseen(coverage: &Coverage) -> Failure {
    let [near, far] = coverage.angles_rad.map(f64::to_degrees);
    let message = format!(
        "the camera sees none of the surface: it lies {near:.0} to {far:.0} deg off the camera's \
         axis, and the lens reaches {:.0} deg",
        coverage.lens_rad.to_degrees()
    );
    Failure::new(
        Exit::BadInput,
        message,
        "is the pose `camera_from_sensor`, in mm, and not its inverse?",
    )
}

/// Refuses presses, by the names they go by, that reach below the soft layer: what is there does not
/// give way, so that nobody can take a picture of such a press.
pub(super) fn check_depths<'a>(
    touch: &TouchSurface,
    presses: impl Iterator<Item = (&'a str, &'a Press)>,
) -> Result<(), Failure> {
    let bodies: Vec<_> = presses
        .flat_map(|(name, press)| press.bodies.iter().map(move |body| (name, body)))
        .collect();
    let found = bodies.par_iter().map(|(_, body)| penetration(touch, body));
    let found: Vec<_> = found.collect::<Result<_, _>>().map_err(Failure::bug)?;
    let too_deep: Vec<String> = bodies
        .iter()
        .zip(found)
        .filter_map(|((name, body), deepest)| {
            let deepest = deepest.filter(|deepest| deepest.depth_mm > touch.soft_mm + SLACK_MM)?;
            let at = deepest.point_in_sensor;
            let body = if body.name == *name { "it" } else { &body.name };
            Some(format!(
                "`{name}`: {body} goes {:.3} mm deep at ({:.2}, {:.2}, {:.2}) mm, but the rigid shell \
                 begins {} mm below the surface",
                deepest.depth_mm, at.x, at.y, at.z, touch.soft_mm,
            ))
        })
        .collect();
    if too_deep.is_empty() {
        return Ok(());
    }
    let (count, shown) = (too_deep.len(), too_deep.len().min(MOST_FAULTS));
    let mut message = too_deep[..shown].join("\nerror: ");
    if count > shown {
        message += &format!("\nerror: and {} more", count - shown);
    }
    Err(Failure::new(Exit::BadInput, message, "press less deep, or leave these out"))
}

/// A press that cannot be had, for people.
pub(super) fn press_failure(sensor: &str, error: PressError) -> Failure {
    match error {
        PressError::Unknown { id, known } => {
            let list = known.iter().map(String::as_str);
            let unknown = fabkit::bodies::UnknownName::new("press", &id, list);
            let tool = known.iter().find(|name| name.ends_with('@'));
            let hint = match (&unknown.closest, tool) {
                (Some(closest), _) if closest.ends_with('@') => place_hint(closest),
                (Some(_), _) => unknown.hint(),
                (None, tool) => {
                    let examples = one_of_each_kind(&known);
                    let listed = format!("presses are {}", examples.join(", "));
                    [Some(listed), tool.map(|tool| place_hint(tool))]
                        .into_iter()
                        .flatten()
                        .collect::<Vec<_>>()
                        .join("; ")
                }
            };
            Failure::new(Exit::BadInput, unknown, hint)
        }
        PressError::Unreadable { .. } => {
            let hint = "for example `hemisphere@30deg,120deg,1.2mm`: polar angle, azimuth, depth";
            Failure::new(Exit::BadInput, error, hint)
        }
        PressError::Fixture(error) => match Source::find(sensor) {
            Ok(source) => source.failure(error),
            Err(failure) => failure,
        },
        PressError::OutOfRange { .. } | PressError::Flat { .. } => {
            Failure::plain(Exit::BadInput, error)
        }
        PressError::Surface(_) => Failure::bug(error),
    }
}

fn place_hint(tool: &str) -> String {
    format!("an indenter and its place are written like `{tool}30deg,120deg,1mm`")
}

/// The first of the names that differ in their numbers alone.
fn one_of_each_kind(names: &[String]) -> Vec<String> {
    let mut kinds = BTreeSet::new();
    let kind = |name: &str| -> String { name.chars().filter(|c| !c.is_ascii_digit()).collect() };
    let listed = names.iter().filter(|name| !name.ends_with('@'));
    let first = listed.filter(|name| kinds.insert(kind(name)));
    first.map(|name| format!("`{name}`")).collect()
}
