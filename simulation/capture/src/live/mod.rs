//! Live simulation of a sensor: press after press, with image, depth and force, at the rate that simulators and studies
//! need.
//!
//! Everything that no press changes is computed once: the rays' points on the surface, the compliance of the layers,
//! the image at rest. This data borrows from the sensor's scene, so it lives on a thread of its own, which receives
//! presses through a channel. Presses of one request are solved in parallel. All results are simulated, at small
//! strain.

mod skin;

use std::path::PathBuf;
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Arc, OnceLock};
use std::{process, thread};

use fabkit_depth::ground_truth::{DepthMap, ReferenceSurface, SURFACE_LABEL};
use fabkit_files::Error;
use fabkit_fixtures::Press;
use fabkit_geometry::{Pose, TouchSurface};
use fabkit_scene::SensorView;
use fabkit_scene::ground_truth::compile_indenters;
use fabkit_scene::press_simulation::{
    ContactModel, ContactSolution, ElasticSolver, LinearOptions, MarkerDisplacement, PressStep,
    resources, soft_layers,
};
use rayon::prelude::*;
use serde_json::Value;

use crate::Renderer;

pub use skin::{LiveSkin, SkinImageRequest, SkinImages, SkinResult};

/// Displacement below which the surface counts as unmoved, mm. Slopes are then about 1e-3, and intensities change by
/// less than their noise.
const STILL_MM: f64 = Renderer::MOTION_THRESHOLD_MM;

/// Options of a live sensor.
#[derive(Clone, Debug, Default)]
pub struct LiveOptions {
    /// Name of the lighting; `None` for the sensor's default.
    pub light: Option<String>,
    /// File of optical constants; `None` for the sensor's own.
    pub constants: Option<PathBuf>,
    /// Number of rays along each side of a pixel; 0 counts as 1.
    pub samples: u32,
    /// Distance of the surface's nodes, mm; `None` for a value that allows a setup within a few seconds.
    pub spacing_mm: Option<f64>,
}

/// One press on a live sensor.
#[derive(Clone, Debug)]
pub struct LivePress {
    /// Bodies at their poses, pressed in all at once; none for a sensor at rest.
    pub press: Press,
    /// Displacement along the surface after indentation, mm, as for [`ElasticSolver::solve_contact`].
    pub shear_mm: [f64; 2],
    /// Coulomb's friction coefficient for that displacement; `None` for that of the touched material.
    pub friction: Option<f64>,
    /// Seed of noise and drift; `None` for neither.
    pub seed: Option<u64>,
}

/// Result of a press. Lists of pixels go row by row.
#[derive(Clone, Debug)]
pub struct LiveResult {
    /// Intensities from 0 to 255, not rounded, pixel by pixel: one value, or red, green and blue.
    pub grey: Vec<f64>,
    /// Indentation along each pixel's ray, mm: the mean over its rays. NaN where no surface is seen.
    pub indentation_mm: Vec<f32>,
    /// Pixels where any ray sees an indenter.
    pub contact: Vec<bool>,
    /// Forces and contact; `None` without contact.
    pub step: Option<PressStep>,
    /// Markers at their present places.
    pub marks: Vec<MarkerDisplacement>,
    /// Pixels of the markers; `None` outside the image.
    pub mark_px: Vec<Option<[f64; 2]>>,
}

type LiveRequest = (Vec<LivePress>, Sender<Result<Vec<LiveResult>, Error>>);

/// Data of a live sensor that is known before any press.
#[derive(Clone, Debug)]
pub struct LiveInfo {
    /// Number of columns and rows of images.
    pub size_px: [usize; 2],
    /// Number of values per pixel: 1 or 3.
    pub channels: usize,
    /// Lighting, layers and simplifications as JSON.
    pub document: Value,
    /// Frame in the middle of the sensing surface, with z out of the sensor.
    pub sensor_from_touch: Pose,
}

/// A sensor that is ready for presses. Dropping it ends its thread.
///
/// ```
/// use std::sync::Arc;
///
/// use fabkit_capture::live::{LiveOptions, LivePress, LiveSensor};
///
/// # let yaml = fabkit_designs::builtin_yaml("gelsight-like").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("gelsight-like.yaml", yaml, &[])?;
/// # let viewpoint = fabkit_scene::ground_truth::Viewpoint::new(&project.design.sensor.camera, None, None)?;
/// # let viewpoint = viewpoint.resized([32, 24])?;
/// # let scene = fabkit_scene::SensorView::new(std::sync::Arc::new(project), viewpoint)?;
/// let press = scene.project.press("ball@0mm,0mm,0.3mm")?;
/// let options = LiveOptions { spacing_mm: Some(1.0), ..LiveOptions::default() };
/// let live = LiveSensor::new(Arc::new(scene), options)?;
/// assert_eq!(live.about().size_px, [32, 24]);
/// let shown = live.press(vec![LivePress { press, shear_mm: [0.0; 2], friction: None, seed: None }])?;
/// // The ball pushes the pad down, and the camera sees it in the middle.
/// assert!(shown[0].step.as_ref().is_some_and(|step| step.force_n.z < 0.0));
/// assert!(shown[0].contact[12 * 32 + 16] && !shown[0].contact[0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct LiveSensor {
    asks: Sender<LiveRequest>,
    about: LiveInfo,
    /// Scene and options, from which it is set up again in a forked process.
    setup: (Arc<SensorView>, LiveOptions),
    /// Process that has its thread.
    process: u32,
    /// The same sensor in a process that was forked from this one.
    in_child: OnceLock<Box<LiveSensor>>,
}

impl LiveSensor {
    /// Sets a sensor up, which takes seconds.
    ///
    /// # Errors
    /// Returns an error for an unknown lighting, a sensor without soft layers, and rays or nodes beyond their limits.
    pub fn new(scene: Arc<SensorView>, options: LiveOptions) -> Result<Self, Error> {
        let (asks, asked) = mpsc::channel();
        // The thread reports its data or the error of its setup once, before it serves presses.
        let (begin, begun) = mpsc::sync_channel(1);
        let setup = (Arc::clone(&scene), options.clone());
        // Presses are solved by threads of the sensor's own: the pool of the caller is not known to a new thread, and
        // rayon's global pool is none that survives a fork.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(rayon::current_num_threads());
        let pool = pool.build().map_err(Error::bug)?;
        thread::spawn(move || {
            pool.install(move || {
                let kept = run_live(&scene, &options, |about, kept| {
                    // The receiver is gone if the caller was interrupted.
                    if begin.send(Ok(about)).is_ok() {
                        serve_requests(&asked, kept);
                    }
                });
                if let Err(error) = kept {
                    let _ = begin.send(Err(error));
                }
            })
        });
        let about = begun.recv().map_err(|_| Error::bug("a live sensor did not start"))??;
        Ok(Self { asks, about, setup, process: process::id(), in_child: OnceLock::new() })
    }

    /// Returns the data that is known before any press.
    pub fn about(&self) -> &LiveInfo {
        &self.about
    }

    /// Solves presses in parallel, each on a surface at rest. In a forked process the first press sets the sensor up again,
    /// because its thread stayed in the parent.
    ///
    /// # Errors
    /// Returns the error of the first press that has one: contact deeper than the layers, contact that does not
    /// converge, unknown friction.
    pub fn press(&self, presses: Vec<LivePress>) -> Result<Vec<LiveResult>, Error> {
        if self.process != process::id() {
            return self.in_this_process()?.press(presses);
        }
        let (reply, replied) = mpsc::channel();
        let gone = |_| Error::bug("a live sensor has stopped");
        self.asks.send((presses, reply)).map_err(|_| Error::bug("a live sensor has stopped"))?;
        replied.recv().map_err(gone)?
    }

    /// Returns the sensor of a process that was forked from that of this one.
    fn in_this_process(&self) -> Result<&Self, Error> {
        if let Some(live) = self.in_child.get() {
            return Ok(live);
        }
        let (scene, options) = &self.setup;
        let live = Box::new(Self::new(Arc::clone(scene), options.clone())?);
        // Another thread may have been faster: its sensor is the same.
        Ok(self.in_child.get_or_init(|| live))
    }
}

fn serve_requests(asked: &Receiver<LiveRequest>, kept: &LiveState<'_>) {
    while let Ok((presses, reply)) = asked.recv() {
        let shown = presses.par_iter().map(|press| kept.press(press)).collect();
        // The receiver is gone if the caller was interrupted.
        let _ = reply.send(shown);
    }
}

/// Everything that no press changes.
struct LiveState<'a> {
    scene: &'a SensorView,
    touch: &'a TouchSurface,
    samples: usize,
    surface: &'a ReferenceSurface<'a>,
    ready: ElasticSolver,
    studio: Renderer<'a>,
    /// Pixels of the markers at rest.
    mark_px: Vec<Option<[f64; 2]>>,
}

fn run_live(
    scene: &SensorView,
    options: &LiveOptions,
    work: impl FnOnce(LiveInfo, &LiveState<'_>),
) -> Result<(), Error> {
    let sensor = &scene.project.design.sensor;
    let (light, constants) = (options.light.as_deref(), options.constants.as_deref());
    let (lighting, constants) = crate::select_lighting(&scene.project, light, constants)?;
    let touch = scene.touch()?;
    let contact =
        ContactModel::Linear(LinearOptions { spacing_mm: options.spacing_mm, friction: None });
    let samples = options.samples.max(1);
    let size_px = scene.ray_grid_size(samples)?.map(|side| (side / samples) as usize);
    // Presses are rendered in parallel: each takes the memory of a capture besides what is shared.
    let per_ray = Renderer::BYTES_PER_RAY * (1 + rayon::current_num_threads() as u64);
    let grant = scene.request_memory("a live sensor with", samples, per_ray)?;
    let rays = scene.rays_of_rows(samples, 0..u32::MAX, &grant);
    let surface = ReferenceSurface::cast(touch, &rays).map_err(Error::bug)?;
    // Presses may come anywhere and with shear.
    let ready = ElasticSolver::for_any_press(sensor, options.spacing_mm, true, resources())?;
    let studio = Renderer::new(scene, &surface, lighting, &constants, contact)?;
    let mut document = studio.document();
    document["layers"] = soft_layers(&ready.soft.layers);
    document["layers_left_out"] = ready.soft.simplifications.clone().into();
    document["spacing_mm"] = ready.spacing_mm.into();
    let (middle, outward) = crate::surface_middle(touch).ok_or_else(|| Error::bug("no middle"))?;
    let sensor_from_touch = Pose::z_to(outward, middle);
    let channels = studio.channels();
    let about = LiveInfo { size_px, channels, document, sensor_from_touch };
    let samples = samples as usize;
    let marks = crate::displaced_markers(sensor, None);
    let mark_px = crate::project_markers(&scene.viewpoint, scene.sights(), &marks);
    work(about, &LiveState { scene, touch, samples, surface: &surface, ready, studio, mark_px });
    Ok(())
}

impl LiveState<'_> {
    fn press(&self, asked: &LivePress) -> Result<LiveResult, Error> {
        let LivePress { press, shear_mm, friction, seed } = asked;
        let answer = if press.bodies.is_empty() {
            None
        } else {
            match self.ready.solve_contact(self.touch, &press.bodies, *shear_mm, *friction) {
                // Contact smaller than the node spacing counts as none, so that a control loop does not stop at first
                // touch.
                Err(error) if error.is_no_contact() || error.is_first_touch() => None,
                answer => Some(answer?),
            }
        };
        let Some(answer) = answer else {
            return self.to_result(&self.surface.map_without_contact(), None, *seed);
        };
        let mut moved = press.clone();
        let way = Pose::translation(
            answer.shear_displacement_mm.x,
            answer.shear_displacement_mm.y,
            answer.shear_displacement_mm.z,
        );
        for body in &mut moved.bodies {
            body.sensor_from_body = way.then_in(body.sensor_from_body);
        }
        let indenters = compile_indenters(&[moved]).map_err(Error::bug)?;
        // Normals cost time and only shading by slopes needs them.
        let normals = self.studio.needs_normals();
        let map = self.surface.map_deformed_beyond(STILL_MM, &indenters, &answer, normals);
        self.to_result(&map, Some(&answer), *seed)
    }

    /// Projects markers to pixels. Only those that have moved are projected anew.
    fn pixels_of(&self, marks: &[MarkerDisplacement]) -> Vec<Option<[f64; 2]>> {
        let has_moved =
            |mark: &MarkerDisplacement| mark.displacement_mm.is_none_or(|mm| mm.norm() > STILL_MM);
        let moved: Vec<usize> = (0..marks.len()).filter(|i| has_moved(&marks[*i])).collect();
        let own: Vec<MarkerDisplacement> = moved.iter().map(|i| marks[*i].clone()).collect();
        let found = crate::project_markers(&self.scene.viewpoint, self.scene.sights(), &own);
        let mut pixels = self.mark_px.clone();
        moved.into_iter().zip(found).for_each(|(i, pixel)| pixels[i] = pixel);
        pixels
    }

    fn to_result(
        &self,
        map: &DepthMap<'_>,
        answer: Option<&ContactSolution<'_>>,
        seed: Option<u64>,
    ) -> Result<LiveResult, Error> {
        let by_ray: Vec<f64> = map.indentation_mm().collect();
        let grey = if self.studio.needs_normals() || answer.is_none() {
            self.studio.render(map, answer, seed)?
        } else {
            // Rays whose indentation is below the threshold keep their value at rest and are not rendered again.
            let seen = |mm: &f64| if mm.is_finite() { *mm as f32 } else { 0.0 };
            let by_mm: Vec<f32> = by_ray.iter().map(seen).collect();
            let label = |label: &u16| u8::try_from(*label).unwrap_or(u8::MAX);
            let labels: Vec<u8> = map.label().iter().map(label).collect();
            let moved =
                self.surface.map_from_indentation(&by_mm, &labels, Renderer::MOTION_THRESHOLD_MM);
            self.studio.render(&moved, answer, seed)?
        };
        let sensor = &self.scene.project.design.sensor;
        let marks = crate::displaced_markers(sensor, answer);
        let mark_px = self.pixels_of(&marks);
        let width = map.width_px() as usize;
        let touched: Vec<bool> = map.label().iter().map(|label| *label > SURFACE_LABEL).collect();
        Ok(LiveResult {
            grey,
            indentation_mm: map_pixels(&by_ray, width, self.samples, mean),
            contact: map_pixels(&touched, width, self.samples, |rays| rays.contains(&true)),
            step: answer.map(|answer| answer.step),
            marks,
            mark_px,
        })
    }
}

/// Applies `of` to the rays of each pixel; rays lie in rows of `width`.
fn map_pixels<T: Copy, U>(
    rays: &[T],
    width: usize,
    samples: usize,
    of: impl Fn(&[T]) -> U,
) -> Vec<U> {
    let mut own = Vec::with_capacity(samples * samples);
    let mut pixels = Vec::with_capacity(rays.len() / (samples * samples));
    for rows in rays.chunks_exact(width * samples) {
        for column in (0..width).step_by(samples) {
            own.clear();
            rows.chunks_exact(width).for_each(|row| own.extend(&row[column..column + samples]));
            pixels.push(of(&own));
        }
    }
    pixels
}

/// Returns the mean over the rays that see the surface.
fn mean(rays_mm: &[f64]) -> f32 {
    let seen = rays_mm.iter().filter(|mm| mm.is_finite());
    let (sum, count) = seen.fold((0.0, 0.0), |(sum, count), mm| (sum + mm, count + 1.0));
    // Without any, 0 / 0 gives NaN.
    (sum / count) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_made_of_their_own_rays() {
        let rays: Vec<f64> = vec![1.0, 3.0, f64::NAN, f64::NAN, 5.0, 7.0, 2.0, f64::NAN];
        let means = map_pixels(&rays, 4, 2, mean);
        assert_eq!(means[0], 4.0);
        assert_eq!(means[1], 2.0);
        assert!(map_pixels(&rays[2..4], 2, 1, mean)[0].is_nan());
        assert_eq!(map_pixels(&[true, false, false, false], 2, 2, |r| r.contains(&true)), [true]);
    }
}
