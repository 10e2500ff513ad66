//! A sensor's surface and the camera that looks at it: what `depth` and `dataset` share.

mod contacts;

use std::collections::BTreeSet;
use std::fmt::Display;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use fabkit::camera::Interface;
use fabkit::camera::files::{PoseFile, read_pose};
use fabkit::depth::truth::{DepthMap, Presser, Surface};
use fabkit::fixtures::{Press, PressError, Project};
use fabkit::geometry::TouchSurface;
use fabkit::ground_truth::{Coverage, Deepest, Viewpoint, coverage, deepest, pressers};
use serde_json::{Value, json};

use self::contacts::Meeting;
use crate::failure::{Exit, Failure};
use crate::memory;
use crate::reading::{self, Expected};
use crate::source::{MAX_YAML_BYTES, Source};

/// Radius of the transition around contacts, smallest and largest, mm: wider than any gel's skin
/// carries.
pub const MEMBRANE_LIMITS_MM: [f64; 2] = [0.0, 10.0];
/// Standard deviation of printed and cast surfaces, smallest and largest, mm.
pub const SIGMA_LIMITS_MM: [f64; 2] = [0.0, 1.0];
/// What is left out on either side of a seam, smallest and largest, mm.
pub const MARGIN_LIMITS_MM: [f64; 2] = [0.0, 10.0];
/// Most rays along each side of a pixel.
pub const MAX_SAMPLES: u32 = 8;
/// Most rays of one cast: the same limit as for pictures.
pub const MAX_RAYS: u64 = fabkit::pictures::MAX_PIXELS;

/// Rays that are cast at once where they need not know each other.
const BAND_RAYS: u32 = 1 << 18;
/// What a ray takes while it is cast and looked at, bytes: measured on surfaces that are all contact.
const BAND_BYTES: u64 = 450;
/// The same with a transition around contacts.
const MEMBRANE_BYTES: u64 = 550;

/// Below this share of the surface a camera is taken for misplaced, and said to be.
const LITTLE: f64 = 0.5;
/// Faults that are listed one by one.
pub(crate) const MOST_FAULTS: usize = 50;

/// A sensor whose surface a camera sees.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The sensor.
    pub project: Arc<Project>,
    /// The camera at its place.
    pub viewpoint: Viewpoint,
    /// What it sees of the surface: something.
    pub coverage: Coverage,
}

/// What to cast.
#[derive(Clone, Debug)]
pub struct Cast<'a> {
    /// What presses; nothing for the reference.
    pub presses: &'a [Press],
    /// Rays along each side of a pixel.
    pub samples: u32,
    /// Radius of the transition around contacts, mm.
    pub membrane_mm: f64,
    /// Standard deviation of printed and cast surfaces along their normals, mm.
    pub print_sigma_mm: f64,
    /// Whether a press may miss the surface, or touch it where the camera sees nothing of it.
    pub allow_no_contact: bool,
}

/// What the camera sees of a press.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// Ground truth.
    pub map: &'a DepthMap<'a>,
    /// Standard deviation of its range, mm, row by row.
    pub sigma_mm: &'a [f64],
    /// The deepest contact; `None` without contact.
    pub deepest: Option<Deepest>,
    /// How many pixels see the surface.
    pub surface_px: usize,
}

impl Scene {
    /// Looks whether the camera sees the surface.
    ///
    /// # Errors
    /// A sensor without a curved surface, a camera that sees none of it.
    pub fn new(project: Arc<Project>, viewpoint: Viewpoint) -> Result<Self, Failure> {
        let coverage = coverage(touch(&project)?, &viewpoint).map_err(Failure::bug)?;
        if coverage.area == 0.0 {
            return Err(unseen(&coverage));
        }
        Ok(Self { project, viewpoint, coverage })
    }

    /// The surface.
    ///
    /// # Errors
    /// None that [`Scene::new`] has not found.
    pub fn touch(&self) -> Result<&TouchSurface, Failure> {
        touch(&self.project)
    }

    /// Casts a press, and shows what is seen of it.
    ///
    /// # Errors
    /// Options beyond their limits, a press deeper than the surface is soft, one without contact
    /// unless that is allowed, and what `look` says.
    pub fn cast<R>(
        &self,
        cast: &Cast,
        look: impl FnOnce(Seen) -> Result<R, Failure>,
    ) -> Result<R, Failure> {
        let (pressers, meetings) = self.pressers(cast)?;
        self.cast_rows(cast, &pressers, 0..u32::MAX, |seen| {
            if seen.deepest.is_none() && !cast.allow_no_contact {
                self.check_seen(&meetings)?;
            }
            look(seen)
        })
    }

    /// The same in bands of rows, from the top down, if they do not depend on each other: what is
    /// large need not be in memory at once. `kept` is how many bytes `look` keeps of each ray.
    ///
    /// # Errors
    /// As for [`Scene::cast`]; more memory than allowed.
    pub fn cast_in_bands(
        &self,
        cast: &Cast,
        kept: u64,
        mut look: impl FnMut(Seen) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let [width, height] = self.check(cast)?;
        let rays = u64::from(width) * u64::from(height);
        let origins = if *self.viewpoint.camera().interface() == Interface::None { 0 } else { 24 };
        // A transition spreads as far as it likes.
        let is_whole = cast.membrane_mm > 0.0;
        let rows = if is_whole { height } else { (BAND_RAYS / width).clamp(1, height) };
        let at_once = u64::from(width) * u64::from(rows);
        let per_ray = origins + if is_whole { MEMBRANE_BYTES } else { BAND_BYTES };
        memory::admit(
            &format!("casting {width} x {height} rays for these files"),
            kept * rays + per_ray * at_once,
            "ask for fewer --samples or files",
        )?;
        let (pressers, meetings) = self.pressers(cast)?;
        let mut is_seen = false;
        (0..height).step_by(rows as usize).try_for_each(|top| {
            self.cast_rows(cast, &pressers, top..top.saturating_add(rows), |seen| {
                is_seen |= seen.deepest.is_some();
                look(seen)
            })
        })?;
        if is_seen || cast.allow_no_contact { Ok(()) } else { self.check_seen(&meetings) }
    }

    fn pressers(&self, cast: &Cast) -> Result<(Vec<Presser>, Vec<Meeting>), Failure> {
        self.check(cast)?;
        let presses = cast.presses.iter().map(|press| (press.id.as_str(), press));
        let meetings = self.check_presses(presses, cast.allow_no_contact)?;
        Ok((pressers(cast.presses).map_err(Failure::bug)?, meetings))
    }

    fn cast_rows<R>(
        &self,
        cast: &Cast,
        pressers: &[Presser],
        rows: Range<u32>,
        look: impl FnOnce(Seen) -> Result<R, Failure>,
    ) -> Result<R, Failure> {
        let rays = self.viewpoint.rays_of_rows(cast.samples, rows);
        let surface = Surface::cast(self.touch()?, &rays).map_err(Failure::bug)?;
        let rigid = surface.pressed(pressers);
        let deepest = deepest(&rigid, self.touch()?);
        let map = rigid.with_membrane(cast.membrane_mm);
        let sigma_mm = map.sigma_mm(&self.viewpoint.uncertainty(cast.print_sigma_mm));
        look(Seen { map: &map, sigma_mm: &sigma_mm, deepest, surface_px: surface.seen() })
    }

    /// Refuses presses, by the names they go by, that go deeper than the surface is soft, or do not
    /// touch it, unless that is allowed.
    ///
    /// # Errors
    /// Every one of them, with how deep or how far, and where.
    pub fn check_contacts<'a>(
        &self,
        presses: impl Iterator<Item = (&'a str, &'a Press)>,
        allow_no_contact: bool,
    ) -> Result<(), Failure> {
        self.check_presses(presses, allow_no_contact).map(|_| ())
    }

    /// Columns and rows of rays.
    fn check(&self, cast: &Cast) -> Result<[u32; 2], Failure> {
        let camera = self.viewpoint.camera();
        let samples = cast.samples;
        if !(1..=MAX_SAMPLES).contains(&samples) {
            let message = format!("{samples} samples; the limits are 1 and {MAX_SAMPLES}");
            return Err(Failure::plain(Exit::BadInput, message));
        }
        within("membrane", cast.membrane_mm, MEMBRANE_LIMITS_MM)?;
        within("print sigma", cast.print_sigma_mm, SIGMA_LIMITS_MM)?;
        let [width, height] = [camera.width_px(), camera.height_px()].map(|side| side * samples);
        if u64::from(width) * u64::from(height) <= MAX_RAYS {
            return Ok([width, height]);
        }
        let message = format!("{width} x {height} rays are more than {MAX_RAYS}");
        Err(Failure::new(Exit::Limit, message, "ask for fewer --samples"))
    }

    /// For people; more of it where something may be wrong.
    pub fn coverage_text(&self) -> String {
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

    /// For programs.
    pub fn coverage_json(&self) -> Value {
        json!({ "area": self.coverage.area, "area_mm2": self.coverage.area_mm2 })
    }
}

/// Checks a length that did not come through the command line.
///
/// # Errors
/// A value outside its limits, or no number.
pub fn within(name: &str, value_mm: f64, [least, most]: [f64; 2]) -> Result<(), Failure> {
    if (least..=most).contains(&value_mm) {
        return Ok(());
    }
    let message = format!("{name}: {value_mm} mm; the limits are {least} mm and {most} mm");
    Err(Failure::plain(Exit::BadInput, message))
}

fn touch(project: &Project) -> Result<&TouchSurface, Failure> {
    let sensor = &project.design.sensor;
    sensor.touch.as_ref().ok_or_else(|| {
        let message = format!("{} has no sensing surface of known shape to look at", sensor.name);
        Failure::plain(Exit::BadInput, message)
    })
}

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
    ) -> Result<Self, Failure> {
        Self::with_viewpoint(project, camera, pose).map(|(files, _)| files)
    }

    fn with_viewpoint(
        project: &Project,
        camera: Option<&Path>,
        pose_path: Option<&Path>,
    ) -> Result<(Self, Viewpoint), Failure> {
        let pose_hint = "is it the right file? It holds the matrix `camera_from_sensor`";
        let pose = read(pose_path, "a pose file", pose_hint)?;
        let fault = |path: Option<&Path>, error: &dyn Display| {
            let name = path.map_or_else(String::new, |path| format!("{}: ", path.display()));
            Failure::plain(Exit::BadInput, format!("{name}{error}"))
        };
        let of_pose = |error: &dyn Display| fault(pose_path, error);
        let pose =
            pose.map(|text| read_pose(&text)).transpose().map_err(|error| of_pose(&error))?;
        // A pose is only good with the camera it was solved with: unless told otherwise, that one.
        let beside = pose_path.zip(pose.as_ref().and_then(|pose| pose.camera.as_ref()));
        let beside = beside.map(|(path, camera)| path.with_file_name(camera));
        let camera_path = camera.or(beside.as_deref());
        let camera_hint = "is it the right file? It holds a lens and an image size";
        let camera = read(camera_path, "a camera file", camera_hint)?;
        let nominal = &project.design.sensor.camera;
        // One after the other, so that each fault is told with its file.
        Viewpoint::new(nominal, camera.as_deref(), None)
            .map_err(|error| fault(camera_path, &error))?;
        let viewpoint = Viewpoint::new(nominal, camera.as_deref(), pose.as_ref())
            .map_err(|error| of_pose(&error))?;
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
) -> Result<Viewpoint, Failure> {
    ViewpointFiles::with_viewpoint(project, camera, pose).map(|(_, viewpoint)| viewpoint)
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

/// A press that cannot be had, for people.
pub fn press_failure(sensor: &str, error: PressError) -> Failure {
    let hint = match &error {
        PressError::Unknown { id, known, place } => Some(unknown_hint(id, known, place)),
        PressError::Unreadable { example, .. } => {
            Some(format!("a place is written like `{example}`: polar angle, azimuth, depth"))
        }
        _ => None,
    };
    match error {
        PressError::Fixture(error) => match Source::find(sensor) {
            Ok(source) => source.failure(error),
            Err(failure) => failure,
        },
        PressError::Surface(_) => Failure::bug(error),
        other => match hint {
            Some(hint) => Failure::new(Exit::BadInput, other, hint),
            None => Failure::plain(Exit::BadInput, other),
        },
    }
}

/// What somebody may have meant who asked for a press that there is not.
pub fn unknown_hint(id: &str, known: &[String], place: &str) -> String {
    let written =
        |tool: &str| format!("an indenter and its place are written like `{tool}{place}`");
    let unknown = fabkit::bodies::UnknownName::new("press", id, known.iter().map(String::as_str));
    match &unknown.closest {
        Some(closest) if closest.ends_with('@') => written(closest),
        Some(_) => unknown.hint(),
        None => {
            let listed = one_of_each_kind(known);
            let listed = (!listed.is_empty()).then(|| format!("presses are {}", listed.join(", ")));
            let tools: Vec<&String> = known.iter().filter(|name| name.ends_with('@')).collect();
            let written = tools.first().map(|tool| written(tool));
            listed.into_iter().chain(written).collect::<Vec<_>>().join("; ")
        }
    }
}

/// The first of the names that differ in their numbers alone.
fn one_of_each_kind(names: &[String]) -> Vec<String> {
    let mut kinds = BTreeSet::new();
    let kind = |name: &str| -> String { name.chars().filter(|c| !c.is_ascii_digit()).collect() };
    let listed = names.iter().filter(|name| !name.ends_with('@'));
    let first = listed.filter(|name| kinds.insert(kind(name)));
    first.map(|name| format!("`{name}`")).collect()
}
