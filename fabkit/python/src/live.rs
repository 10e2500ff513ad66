//! Sensors kept ready for many presses.

use std::path::PathBuf;
use std::sync::Arc;

use fabkit_application::Error;
use fabkit_application::export::{NpyArray, NpyValues};
use fabkit_application::fixtures::{Press, PressBody};
use fabkit_application::geometry::{Matrix3, Point3, Pose, Solid, Vector3};
use fabkit_application::live::{
    self, LiveOptions, LivePress, LiveResult, SkinImageRequest, SkinImages, SkinResult,
};
use fabkit_application::source::convert_press_error;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays;
use crate::design::Project;
use crate::errors::Failure;
use crate::running::{InterruptPolicy, run_on_thread};
use crate::scene::Scene;

/// Indenter: kind, sizes in mm, and `sensor_from_body`, (4, 4).
type Body = (String, Vec<f64>, [[f64; 4]; 4]);
/// Press request: names of presses, further bodies, shear along the surface in mm, friction, and seed of the noise.
type LivePressRequest = (Vec<String>, Vec<Body>, [f64; 2], Option<f64>, Option<u64>);

/// Sensor ready for presses, see [`live::Live`].
#[pyclass(frozen, module = "fabkit._fabkit")]
pub struct Live {
    sensor: String,
    scene: Arc<fabkit_application::scene::SensorView>,
    live: Arc<live::LiveSensor>,
}

#[pymethods]
impl Live {
    #[new]
    fn new(
        py: Python<'_>,
        scene: &Scene,
        light: Option<String>,
        constants: Option<PathBuf>,
        samples: u32,
        spacing_mm: Option<f64>,
    ) -> PyResult<Self> {
        let (view, sensor) = (Arc::clone(&scene.scene), scene.sensor.clone());
        let live = run_on_thread(py, InterruptPolicy::Abandon, None, move |_| {
            let options = LiveOptions { light, constants, samples, spacing_mm };
            Ok::<_, Failure>(live::LiveSensor::new(Arc::clone(&view), options)?)
        })?;
        Ok(Self { sensor, scene: Arc::clone(&scene.scene), live: Arc::new(live) })
    }

    /// Lighting, layers, and what is left out, as JSON.
    fn document(&self) -> String {
        self.live.about().document.to_string()
    }

    /// Pose of the middle of the touched surface, z pointing out of the sensor: rows of (4, 4), mm.
    fn sensor_from_touch(&self) -> [[f64; 4]; 4] {
        let pose = self.live.about().sensor_from_touch;
        let (turn, at) = (pose.rotation(), pose.translation_mm());
        let row = |i: usize| [turn[(i, 0)], turn[(i, 1)], turn[(i, 2)], at[i]];
        [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
    }

    /// Names of the markers, and their positions at rest, mm.
    fn marks(&self) -> Vec<(String, [f64; 3])> {
        list_markers(&self.scene.project)
    }

    /// Computes presses, each on a surface at rest: arrays by name, whose first axis is the press.
    fn press<'py>(
        &self,
        py: Python<'py>,
        asked: Vec<LivePressRequest>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (live, scene) = (Arc::clone(&self.live), Arc::clone(&self.scene));
        let sensor = self.sensor.clone();
        let shown = run_on_thread(py, InterruptPolicy::Abandon, None, move |_| {
            let finder = scene.project.press_finder();
            let find =
                |id: &String| finder.press(id).map_err(|error| convert_press_error(&sensor, error));
            let press = |(ids, bodies, shear_mm, friction, seed): LivePressRequest| {
                let named = ids.iter().map(find).collect::<Result<Vec<Press>, Error>>()?;
                let mut all: Vec<PressBody> = named.into_iter().flat_map(|p| p.bodies).collect();
                for (i, body) in bodies.into_iter().enumerate() {
                    all.push(build_body(i, body)?);
                }
                let (id, summary) = (ids.join(" "), String::new());
                let press = Press { id, summary, bodies: all, is_left_half: false };
                Ok(LivePress { press, shear_mm, friction, seed })
            };
            let presses: Vec<LivePress> =
                asked.into_iter().map(press).collect::<Result<_, Failure>>()?;
            let shown = live.press(presses)?;
            let about = live.about();
            Ok::<_, Failure>(stack_results(about.size_px, about.channels, &shown))
        })?;
        arrays::dictionary(py, shown)
    }
}

/// Makes a body of a kind at a pose. Its centre is its origin.
fn build_body(i: usize, (kind, sizes, pose): Body) -> Result<PressBody, Failure> {
    let solid = match (kind.as_str(), &sizes[..]) {
        ("ball", &[radius_mm]) => Solid::sphere(radius_mm),
        ("cylinder", &[radius_mm, height_mm]) => {
            Solid::rod(radius_mm, [-0.5 * height_mm, 0.5 * height_mm])
        }
        // A cuboid stands on z = 0; shifted down, its centre is the origin.
        ("box", &[x_mm, y_mm, z_mm]) => Solid::cuboid(x_mm, y_mm, z_mm).at_z(-0.5 * z_mm),
        ("capsule", &[radius_mm, height_mm]) => {
            let half_mm = 0.5 * height_mm;
            Solid::union([
                Solid::rod(radius_mm, [-half_mm, half_mm]),
                Solid::sphere(radius_mm).at_z(-half_mm),
                Solid::sphere(radius_mm).at_z(half_mm),
            ])
        }
        // Sizes: lower and upper corner of the bounding box, then a point and an outward normal for each face.
        ("convex", [min_x, min_y, min_z, max_x, max_y, max_z, faces @ ..]) => {
            let (faces, _) = faces.as_chunks::<6>();
            let behind = |[x, y, z, nx, ny, nz]: &[f64; 6]| {
                Solid::behind(Point3::new(*x, *y, *z), Vector3::new(*nx, *ny, *nz))
            };
            let around = Solid::cuboid_between([*min_x, *min_y, *min_z], [*max_x, *max_y, *max_z]);
            Solid::intersection([around].into_iter().chain(faces.iter().map(behind)))
        }
        _ => return Err(Failure::call(format!("there is no body `{kind}` of these sizes"))),
    };
    let rotation = Matrix3::from_fn(|row, column| pose[row][column]);
    let translation = Vector3::from_fn(|row, _| pose[row][3]);
    let pose = Pose::new(rotation, translation).ok_or_else(|| {
        Failure::call("the pose of a body is no rigid motion: its rotation must be one")
    })?;
    Ok(PressBody { name: format!("{kind} {i}"), solid, sensor_from_body: pose })
}

/// Stacks the results of all presses in arrays.
fn stack_results(
    [width, height]: [usize; 2],
    channels: usize,
    shown: &[LiveResult],
) -> Vec<NpyArray> {
    let count = shown.len();
    let array = |name: &str, of_each: &[usize], values: NpyValues| NpyArray {
        name: name.to_owned(),
        shape: [&[count], of_each].concat(),
        values,
    };
    let grey = shown.iter().flat_map(|one| one.grey.iter().map(|grey| grey.round() as u8));
    // Monochrome images have no axis of channels.
    let colors: &[usize] = if channels == 1 { &[] } else { &[channels] };
    let map = [height, width];
    let step = |of: fn(&fabkit_application::press_simulation::PressStep) -> Vec<f64>,
                size: usize| {
        let of_one = move |one: &LiveResult| one.step.as_ref().map_or_else(|| vec![0.0; size], of);
        NpyValues::F64(shown.iter().flat_map(of_one).collect())
    };
    let marks = shown.first().map_or(0, |one| one.marks.len());
    // Markers that the solution does not cover are NaN.
    let unknown = [f64::NAN; 3];
    let moved = shown
        .iter()
        .flat_map(|one| &one.marks)
        .flat_map(|mark| mark.displacement_mm.map_or(unknown, <[f64; 3]>::from));
    let pixels = shown.iter().flat_map(|one| &one.mark_px);
    let pixels = pixels.flat_map(|px| px.unwrap_or([f64::NAN; 2]));
    vec![
        array("image", &[&map[..], colors].concat(), NpyValues::U8(grey.collect())),
        array(
            "depth_mm",
            &map,
            NpyValues::F32(
                shown.iter().flat_map(|one| one.indentation_mm.iter().copied()).collect(),
            ),
        ),
        array(
            "contact",
            &map,
            NpyValues::Bool(shown.iter().flat_map(|one| one.contact.iter().copied()).collect()),
        ),
        array("force_n", &[3], step(|step| step.force_n.iter().copied().collect(), 3)),
        array("moment_nmm", &[3], step(|step| step.moment_nmm.iter().copied().collect(), 3)),
        array("contact_area_mm2", &[], step(|step| vec![step.contact_area_mm2], 1)),
        array("deepest_mm", &[], step(|step| vec![step.max_indentation_mm], 1)),
        array("mark_displacement_mm", &[marks, 3], NpyValues::F64(moved.collect())),
        array("mark_px", &[marks, 2], NpyValues::F64(pixels.collect())),
    ]
}

/// Skin with liquid channels ready for presses, see [`live::LiveSkin`].
#[pyclass(frozen, module = "fabkit._fabkit")]
pub struct LiveSkin {
    sensor: String,
    project: Arc<fabkit_application::fixtures::Project>,
    live: Arc<live::LiveSkin>,
}

#[pymethods]
impl LiveSkin {
    #[new]
    fn new(
        py: Python<'_>,
        project: &Project,
        sensor: String,
        spacing_mm: Option<f64>,
        size_px: Option<[u32; 2]>,
    ) -> PyResult<Self> {
        let project = Arc::clone(&project.project);
        let own = Arc::clone(&project);
        let live = run_on_thread(py, InterruptPolicy::Abandon, None, move |_| {
            Ok::<_, Failure>(live::LiveSkin::new(own, spacing_mm, size_px)?)
        })?;
        Ok(Self { sensor, project, live: Arc::new(live) })
    }

    /// Names of the channels.
    fn channels(&self) -> Vec<String> {
        self.live.channels().map(str::to_owned).collect()
    }

    /// Names of the markers, and their positions at rest, mm.
    fn marks(&self) -> Vec<(String, [f64; 3])> {
        list_markers(&self.project)
    }

    /// Computes presses, each on a skin at rest: arrays by name, whose first axis is the press. The name of an image is
    /// that of its light, preceded by a space.
    fn press<'py>(
        &self,
        py: Python<'py>,
        asked: Vec<String>,
        lights: Vec<String>,
        seed: Option<u64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (live, project) = (Arc::clone(&self.live), Arc::clone(&self.project));
        let sensor = self.sensor.clone();
        let shown = run_on_thread(py, InterruptPolicy::Abandon, None, move |_| {
            let finder = project.skin_press_finder();
            let find =
                |id: &String| finder.press(id).map_err(|error| convert_press_error(&sensor, error));
            let presses = asked.iter().map(find).collect::<Result<Vec<Press>, Error>>()?;
            let shown = live.press(&presses)?;
            let pictures = live.images(&shown, &SkinImageRequest { lights, seed })?;
            let mut all = stack_skin_results(&shown);
            all.extend(pictures.iter().map(image_array));
            Ok::<_, Failure>(all)
        })?;
        arrays::dictionary(py, shown)
    }
}

fn list_markers(project: &fabkit_application::fixtures::Project) -> Vec<(String, [f64; 3])> {
    let marks = &project.design.sensor.marks;
    marks.iter().map(|mark| (mark.name.clone(), mark.point.coords.into())).collect()
}

fn image_array(of: &SkinImages) -> NpyArray {
    let SkinImages { light, size_px: [width, height], channels, grey } = of;
    let colors: &[usize] = if *channels == 1 { &[] } else { &[*channels] };
    let values = grey.iter().flatten().map(|grey| grey.round() as u8).collect();
    NpyArray {
        name: format!(" {light}"),
        shape: [&[grey.len(), *height, *width], colors].concat(),
        values: NpyValues::U8(values),
    }
}

fn stack_skin_results(shown: &[SkinResult]) -> Vec<NpyArray> {
    let array = |name: &str, of_each: &[usize], values: Vec<f64>| NpyArray {
        name: name.to_owned(),
        shape: [&[shown.len()], of_each].concat(),
        values: NpyValues::F64(values),
    };
    let first = shown.first();
    let columns = first.map_or(0, |one| one.column_mm.len());
    let marks = first.map_or(0, |one| one.mark_mm.len());
    let pixels = |of: fn(&SkinResult) -> &Vec<Option<[f64; 2]>>| -> Vec<f64> {
        let all = shown.iter().flat_map(of);
        all.flat_map(|px| px.unwrap_or([f64::NAN; 2])).collect()
    };
    vec![
        array("force_n", &[3], shown.iter().flat_map(|one| one.force_n).collect()),
        array(
            "column_mm",
            &[columns],
            shown.iter().flat_map(|one| one.column_mm.iter().copied()).collect(),
        ),
        array("column_px", &[columns, 2], pixels(|one| &one.column_px)),
        array(
            "mark_displacement_mm",
            &[marks, 3],
            shown.iter().flat_map(|one| one.mark_mm.iter().flatten().copied()).collect(),
        ),
        array("mark_px", &[marks, 2], pixels(|one| &one.mark_px)),
    ]
}
