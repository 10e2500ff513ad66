//! View of a sensor's sensing surface by one camera: casting of rays, contact models and ground truth. Shared by the
//! commands `depth` and `dataset`.
//!
//! ```
//! # use std::sync::Arc;
//! use fabkit_scene::ground_truth::Viewpoint;
//! use fabkit_scene::{Cast, SensorView, press_simulation::ContactModel};
//!
//! let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
//! let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
//! let presses = [project.press("hemisphere@0deg,0deg,1mm")?];
//! // The camera of the design, with fewer pixels.
//! let viewpoint = Viewpoint::new(&project.design.sensor.camera, None, None)?.resized([80, 60])?;
//! let view = SensorView::new(Arc::new(project), viewpoint)?;
//! let cast = Cast { presses: &presses, ..Cast::at_rest(ContactModel::Rigid) };
//! let deepest = view.cast(&cast, 0, |seen| Ok::<_, fabkit_files::Error>(seen.deepest))?;
//! // A pixel near the deepest point, which is 1 mm deep, and not exactly at it.
//! assert!(deepest.is_some_and(|deepest| deepest.depth_mm > 0.9 && deepest.depth_mm <= 1.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod cast;
mod error;
mod files;
pub mod ground_truth;
pub mod legend;
mod limits;
mod press_checks;
pub mod press_simulation;

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use fabkit_depth::ground_truth::{PixelRays, PlacedIndenter, ReferenceSurface};
use fabkit_fixtures::{Press, PressBody, Project};
use fabkit_geometry::{Pose, TouchSurface};
use fabkit_optics::{TILE, ViewStacks};

pub use self::cast::{Cast, CastResult, check_length};
pub use self::error::{SceneError, join_causes, unknown_press_hint};
pub use self::files::{ViewpointFiles, read_camera_file, split_camera_path, viewpoint_from_files};
pub use self::limits::{
    MARGIN_LIMITS_MM, MAX_RAYS, MAX_SAMPLES, MEMBRANE_LIMITS_MM, SIGMA_LIMITS_MM,
};
use self::press_checks::PressApproach;
use fabkit_files::Error;
use fabkit_files::memory::{MemoryGrant, MemoryHint};

use crate::ground_truth::{
    SurfaceCoverage, Viewpoint, compile_indenters, compute_coverage, draw_coverage_map,
    find_deepest_contact,
};
use crate::press_simulation::{
    ContactGap, ContactModel, ContactSolution, ElasticSolver, PressingError, resources,
};

/// Number of rays per band, where rays can be cast independently of each other.
const BAND_RAYS: u32 = 1 << 18;
/// Memory per ray while a band is cast and evaluated, bytes. Measured on surfaces that are all contact.
const BAND_BYTES: u64 = 475;
/// Same as [`BAND_BYTES`] for contact with a membrane.
const MEMBRANE_BYTES: u64 = 575;
/// Same as [`BAND_BYTES`] for elastic contact.
const ELASTIC_BYTES: u64 = 540;
/// Memory per ray while all rays are cast at once without contact that is solved, bytes. Measured: 160 bytes with what a
/// capture adds, of which 80 are counted there.
const WHOLE_BYTES: u64 = 120;
/// Additional memory per ray for elastic contact, bytes: the map of rigid contact that it is compared with, and normals.
const WHOLE_ELASTIC_BYTES: u64 = 120;
/// Additional memory per ray for a membrane, bytes: as measured between [`MEMBRANE_BYTES`] and [`BAND_BYTES`], doubled.
const WHOLE_MEMBRANE_BYTES: u64 = 200;
/// Additional memory per ray for standard deviations of an uncertain camera, bytes.
const WHOLE_SIGMA_BYTES: u64 = 120;
/// Additional memory per ray for uncertainties behind refracting bodies, bytes. Derived by counting, not measured.
pub const REFRACTION_BYTES: u64 = 201;

/// A sensor whose sensing surface is seen by a camera.
///
/// ```
/// use std::sync::Arc;
///
/// use fabkit_scene::SensorView;
/// use fabkit_scene::ground_truth::Viewpoint;
///
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// let camera = Viewpoint::new(&project.design.sensor.camera, None, None)?;
/// let view = SensorView::new(Arc::new(project.clone()), camera.clone())?;
/// assert!(view.coverage.area > 0.5 && view.coverage.area <= 1.0);
///
/// // A camera that looks away from the surface sees nothing of it.
/// let mut away = camera;
/// away.sensor_from_camera = fabkit_geometry::Pose::translation(0.0, 0.0, 500.0).then_in(away.sensor_from_camera);
/// assert!(SensorView::new(Arc::new(project), away).is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SensorView {
    /// The sensor's design and fixtures.
    pub project: Arc<Project>,
    /// The camera at its pose.
    pub viewpoint: Viewpoint,
    /// Coverage of the surface by the camera; its area is greater than 0.
    pub coverage: SurfaceCoverage,
    /// Optical paths of the camera's rays through the sensor's bodies.
    sights: Arc<ViewStacks>,
    /// Solver of the last cast with several presses at once, and the node spacing that was requested for it.
    layers: Arc<Mutex<Option<KeptLayers>>>,
}

/// Requested node spacing, mm, and the solver for it. Its setup takes seconds and depends on the sensor and the spacing
/// alone.
type KeptLayers = (Option<f64>, Arc<ElasticSolver>);

/// Indenters at their final poses, and the solution of the elastic layers.
struct SolvedPresses<'a> {
    indenters: Vec<PlacedIndenter>,
    answer: Option<ContactSolution<'a>>,
}

impl SensorView {
    /// Builds the view and computes the camera's coverage of the surface.
    ///
    /// # Errors
    /// Returns an error for a sensor without a surface of known shape, for bodies that light cannot be traced through,
    /// and for a camera that sees none of the surface.
    pub fn new(project: Arc<Project>, viewpoint: Viewpoint) -> Result<Self, Error> {
        let touch = touch(&project)?;
        let stack = viewpoint.stack(&project.design.sensor).map_err(SceneError::Light)?;
        let sights = Arc::new(ViewStacks::new(stack));
        let coverage = compute_coverage(touch, &viewpoint, &sights).map_err(Error::bug)?;
        if coverage.area == 0.0 {
            return Err(SceneError::unseen(&coverage).into());
        }
        Ok(Self { project, viewpoint, coverage, sights, layers: Arc::default() })
    }

    /// Returns the same view with another number of pixels. Uncertainties are dropped.
    ///
    /// # Errors
    /// Returns an error for an image without pixels, or with more than cameras may have.
    ///
    /// ```
    /// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
    /// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
    /// # let viewpoint = fabkit_scene::ground_truth::Viewpoint::new(&project.design.sensor.camera, None, None)?;
    /// # let scene = fabkit_scene::SensorView::new(std::sync::Arc::new(project), viewpoint)?;
    /// let small = scene.resized([48, 36])?;
    /// assert_eq!(small.viewpoint.camera().width_px(), 48);
    /// assert_eq!(small.coverage.area, scene.coverage.area);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn resized(&self, size_px: [u32; 2]) -> Result<Self, Error> {
        let viewpoint = self.viewpoint.resized(size_px);
        let viewpoint = viewpoint.map_err(|error| SceneError::viewpoint(None, error))?;
        Ok(Self { viewpoint, layers: Arc::default(), ..self.clone() })
    }

    /// Returns whether calibration states uncertainties of camera or pose, and bodies refract the camera's rays.
    pub fn has_refracted_uncertainty(&self) -> bool {
        self.viewpoint.has_uncertainty() && self.sights.bends()
    }

    /// Returns the optical paths of the camera's rays through the sensor's bodies.
    pub fn sights(&self) -> &ViewStacks {
        &self.sights
    }

    /// Renders as PNG which parts of the unrolled surface the camera sees, and what hides the others.
    ///
    /// # Errors
    /// Fails only where [`SensorView::new`] would.
    pub fn coverage_map_png(&self) -> Result<Vec<u8>, Error> {
        let touch = self.touch().map_err(Error::from)?;
        let image = draw_coverage_map(touch, &self.viewpoint, &self.sights, &self.coverage);
        let image = image.map_err(Error::bug)?;
        fabkit_export::png(image.width_px, image.height_px, &image.rgb).map_err(Error::bug)
    }

    /// Computes the rays behind the sensor's bodies, each pixel split into `samples` x `samples` rays. `rows` counts
    /// rows of rays, not of pixels. The grant is that of all work on these rays: see [`SensorView::request_memory`].
    ///
    /// ```
    /// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
    /// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
    /// # let viewpoint = fabkit_scene::ground_truth::Viewpoint::new(&project.design.sensor.camera, None, None)?;
    /// # let viewpoint = viewpoint.resized([40, 30])?;
    /// # let scene = fabkit_scene::SensorView::new(std::sync::Arc::new(project), viewpoint)?;
    /// let grant = scene.request_memory("rays", 2, 100)?;
    /// assert_eq!(grant.bytes(), 80 * 60 * 100);
    /// assert_eq!(scene.rays_of_rows(2, 0..10, &grant).width_px(), 80);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn rays_of_rows(&self, samples: u32, rows: Range<u32>, _grant: &MemoryGrant) -> PixelRays {
        self.viewpoint.rays_of_rows(samples, rows).traced_through(&self.sights)
    }

    /// Requests memory for work on all rays, `samples` x `samples` in each pixel, that takes so many bytes per ray.
    ///
    /// # Errors
    /// More memory than allowed, with what would make it less.
    pub fn request_memory(
        &self,
        what: &str,
        samples: u32,
        bytes_per_ray: u64,
    ) -> Result<MemoryGrant, Error> {
        let [width, height] = self.ray_grid_size(samples)?;
        let rays = u64::from(width) * u64::from(height);
        // The camera is made smaller where there is no sample to leave out.
        let less = if samples > 1 { MemoryHint::Rays } else { MemoryHint::Camera };
        let what = format!("{what} {width} x {height} rays");
        Ok(MemoryGrant::request(&what, bytes_per_ray.saturating_mul(rays), less)?)
    }

    /// Returns the memory per ray while all rays of a cast are in memory at once, bytes.
    fn whole_bytes(&self, cast: &Cast) -> u64 {
        let if_so = |so: bool, bytes: u64| if so { bytes } else { 0 };
        let is_elastic =
            matches!(cast.contact, ContactModel::Linear(_)) && !cast.presses.is_empty();
        WHOLE_BYTES
            + if_so(is_elastic, WHOLE_ELASTIC_BYTES)
            + if_so(cast.contact.membrane_mm() > 0.0, WHOLE_MEMBRANE_BYTES)
            + if_so(
                self.viewpoint.has_uncertainty() || cast.print_sigma_mm > 0.0,
                WHOLE_SIGMA_BYTES,
            )
            + if_so(self.has_refracted_uncertainty(), REFRACTION_BYTES)
    }

    /// Returns the sensing surface.
    ///
    /// # Errors
    /// Fails only where [`SensorView::new`] would.
    pub fn touch(&self) -> Result<&TouchSurface, SceneError> {
        touch(&self.project)
    }

    /// Casts all rays of a press at once and passes the result to `look`, which takes `kept` bytes of its own for each ray.
    ///
    /// # Errors
    /// Returns an error for options beyond their limits, more memory than allowed, a press that reaches below the soft layer, a press without
    /// contact unless that is allowed, and any error of `look`.
    pub fn cast<R, E: From<Error>>(
        &self,
        cast: &Cast,
        kept: u64,
        look: impl FnOnce(CastResult) -> Result<R, E>,
        // Only a press that geometrically touches can get here without visible contact: the camera does not see it.
    ) -> Result<R, E> {
        self.check(cast).map_err(Error::from)?;
        let grant = self.request_memory("casting", cast.samples, kept + self.whole_bytes(cast))?;
        let meetings = self.check_and_approach(cast)?;
        let ready = self.ready(cast)?;
        let pressed = self.press(cast, ready.as_deref())?;
        self.cast_rows(cast, &pressed, (0..u32::MAX, &grant), |seen| {
            if seen.deepest.is_none() && !cast.allow_no_contact {
                self.check_visible(&meetings).map_err(Error::from)?;
            }
            look(seen)
        })
    }

    /// Casts like [`SensorView::cast`], but in bands of rows from the top down, so that large maps need not be in
    /// memory at once. With a membrane, all rows form one band. `kept` is the number of bytes that `look` keeps of each
    /// ray.
    ///
    /// # Errors
    /// Returns the errors of [`SensorView::cast`], and one if the cast needs more memory than allowed.
    ///
    /// ```
    /// use fabkit_scene::Cast;
    /// use fabkit_scene::ground_truth::{FileSelection, MapCollector};
    /// use fabkit_scene::press_simulation::ContactModel;
    ///
    /// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
    /// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
    /// # let viewpoint = fabkit_scene::ground_truth::Viewpoint::new(&project.design.sensor.camera, None, None)?;
    /// # let viewpoint = viewpoint.resized([40, 30])?;
    /// # let scene = fabkit_scene::SensorView::new(std::sync::Arc::new(project), viewpoint)?;
    /// let wanted = FileSelection { mask: true, ..FileSelection::default() };
    /// let mut files = MapCollector::new(wanted, [40, 30]);
    /// scene.cast_in_bands(&Cast::at_rest(ContactModel::Rigid), wanted.bytes_per_ray(), |seen| {
    ///     files.surface_px += seen.surface_px;
    ///     files.add(seen.map, seen.sigmas).map_err(fabkit_files::Error::bug)
    /// })?;
    /// assert!(files.surface_px > 0 && files.contact_px == 0);
    /// assert_eq!(files.mask_png()?[1..4], *b"PNG");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn cast_in_bands<E: From<Error>>(
        &self,
        cast: &Cast,
        kept: u64,
        mut look: impl FnMut(CastResult) -> Result<(), E>,
    ) -> Result<(), E> {
        let [width, height] = self.check(cast).map_err(Error::from)?;
        let rays = u64::from(width) * u64::from(height);
        // The transition of a membrane couples rows at any distance, so all rows are cast at once.
        let is_whole = cast.contact.membrane_mm() > 0.0;
        // Bands end where tiles do, so that rays are bundled exactly as in a cast of the whole image.
        // Wide images still get one row of tiles per band.
        let band = (BAND_RAYS / width / TILE * TILE).max(TILE);
        let rows = if is_whole { height } else { band.min(height) };
        let at_once = u64::from(width) * u64::from(rows);
        let per_ray = match cast.contact {
            ContactModel::Rigid => BAND_BYTES,
            ContactModel::Membrane(_) => MEMBRANE_BYTES,
            ContactModel::Linear(_) => ELASTIC_BYTES,
        };
        let per_ray = per_ray + if self.has_refracted_uncertainty() { REFRACTION_BYTES } else { 0 };
        let grant = MemoryGrant::request(
            &format!("casting {width} x {height} rays for these files"),
            // `look` keeps its data of all rays, but only one band is cast at a time.
            kept * rays + per_ray * at_once,
            MemoryHint::Rays,
        )
        .map_err(Error::from)?;
        let meetings = self.check_and_approach(cast)?;
        let ready = self.ready(cast)?;
        let pressed = self.press(cast, ready.as_deref())?;
        let mut is_seen = false;
        (0..height).step_by(rows as usize).try_for_each(|top| {
            self.cast_rows(cast, &pressed, (top..top.saturating_add(rows), &grant), |seen| {
                is_seen |= seen.deepest.is_some();
                look(seen)
            })
        })?;
        if !is_seen && !cast.allow_no_contact {
            self.check_visible(&meetings).map_err(Error::from)?;
        }
        Ok(())
    }

    fn check_and_approach(&self, cast: &Cast) -> Result<Vec<PressApproach>, Error> {
        self.check(cast)?;
        let presses = cast.presses.iter().map(|press| (press.id.as_str(), press));
        self.check_presses(presses, cast.allow_no_contact)
    }

    /// Returns the solver of the soft layers, or `None` if nothing presses or contact is not elastic. Solvers for
    /// several bodies are kept for later casts; a single body gets a mesh refined at its contact.
    fn ready(&self, cast: &Cast) -> Result<Option<Arc<ElasticSolver>>, Error> {
        // Rigid and membrane contact have no tangential degrees of freedom, so a shear would be ignored silently.
        let ContactModel::Linear(linear) = cast.contact else {
            return if cast.shear_mm == [0.0; 2] {
                Ok(None)
            } else {
                Err(PressingError::RigidShear { contact: cast.contact.name() }.into())
            };
        };
        let bodies: Vec<PressBody> =
            cast.presses.iter().flat_map(|press| press.bodies.clone()).collect();
        if bodies.is_empty() {
            return Ok(None);
        }
        let sensor = &self.project.design.sensor;
        let spacing_mm = linear.spacing_mm;
        // A single body gets a mesh for its own contact, which no other press can reuse.
        if let [_] = &bodies[..] {
            return Ok(Some(Arc::new(ElasticSolver::for_press(
                sensor,
                &bodies,
                spacing_mm,
                resources(),
            )?)));
        }
        // The lock is held during setup: concurrent casts wait for one solver instead of each building its own.
        let mut kept = self.layers.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((of_mm, ready)) = &*kept
            && *of_mm == spacing_mm
        {
            return Ok(Some(ready.clone()));
        }
        let is_dragged = cast.shear_mm != [0.0; 2];
        let ready =
            Arc::new(ElasticSolver::for_any_press(sensor, spacing_mm, is_dragged, resources())?);
        *kept = Some((spacing_mm, ready.clone()));
        Ok(Some(ready))
    }

    /// Solves the contact and moves the indenters along the surface by the solution's displacement.
    fn press<'r>(
        &self,
        cast: &Cast,
        ready: Option<&'r ElasticSolver>,
    ) -> Result<SolvedPresses<'r>, Error> {
        let mut presses = cast.presses.to_vec();
        let answer = match (ready, cast.contact) {
            (Some(ready), ContactModel::Linear(linear)) => {
                let bodies: Vec<PressBody> =
                    presses.iter().flat_map(|press| press.bodies.clone()).collect();
                let touch = self.touch()?;
                match ready.solve_contact(touch, &bodies, cast.shear_mm, linear.friction) {
                    // Without contact the surface stays at rest, as in a cast without presses.
                    Err(error) if error.is_no_contact() && cast.allow_no_contact => None,
                    answer => Some(answer?),
                }
            }
            _ => None,
        };
        if let Some(answer) = &answer {
            // The map must show the indenters where the solution left them.
            let way = Pose::translation(
                answer.shear_displacement_mm.x,
                answer.shear_displacement_mm.y,
                answer.shear_displacement_mm.z,
            );
            for body in presses.iter_mut().flat_map(|press| &mut press.bodies) {
                body.sensor_from_body = way.then_in(body.sensor_from_body);
            }
        }
        Ok(SolvedPresses { indenters: compile_indenters(&presses).map_err(Error::bug)?, answer })
    }

    fn cast_rows<R, E: From<Error>>(
        &self,
        cast: &Cast,
        pressed: &SolvedPresses,
        (rows, grant): (Range<u32>, &MemoryGrant),
        look: impl FnOnce(CastResult) -> Result<R, E>,
    ) -> Result<R, E> {
        let touch = self.touch().map_err(Error::from)?;
        let rays = self.rays_of_rows(cast.samples, rows, grant);
        let surface = ReferenceSurface::cast(touch, &rays).map_err(Error::bug)?;
        let SolvedPresses { indenters, answer } = pressed;
        let contact = match answer {
            Some(answer) => surface.map_deformed(indenters, answer, true),
            None => surface.map_with_indenters(indenters),
        };
        // Rigid contact of the same final poses is the reference.
        let gap = answer
            .as_ref()
            .map(|_| ContactGap::compare(&contact, &surface.map_with_indenters(indenters)));
        let deepest = find_deepest_contact(&contact, touch);
        let map = contact.with_membrane(cast.contact.membrane_mm());
        let sigmas =
            map.compute_standard_deviations(&self.viewpoint.uncertainty(cast.print_sigma_mm));
        look(CastResult {
            map: &map,
            sigmas: &sigmas,
            deepest,
            surface_px: surface.visible_pixels(),
            answer: answer.as_ref(),
            gap,
        })
    }

    /// Checks presses, given with the names they are reported by: none may reach below the soft layer, and each must
    /// touch the surface unless `allow_no_contact` is set.
    ///
    /// # Errors
    /// Lists every faulty press with its depth or distance and its place.
    ///
    /// ```
    /// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
    /// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
    /// # let viewpoint = fabkit_scene::ground_truth::Viewpoint::new(&project.design.sensor.camera, None, None)?;
    /// # let viewpoint = viewpoint.resized([40, 30])?;
    /// # let scene = fabkit_scene::SensorView::new(std::sync::Arc::new(project), viewpoint)?;
    /// let pressed = scene.project.press("hemisphere@0deg,0deg,1mm")?;
    /// let empty = fabkit_fixtures::Press { bodies: vec![], ..pressed.clone() };
    /// assert!(scene.check_contacts([("one", &pressed)].into_iter(), false).is_ok());
    /// // A press without bodies touches nothing.
    /// let presses = || [("one", &pressed), ("none", &empty)].into_iter();
    /// assert!(scene.check_contacts(presses(), true).is_ok());
    /// assert!(scene.check_contacts(presses(), false).is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn check_contacts<'a>(
        &self,
        presses: impl Iterator<Item = (&'a str, &'a Press)>,
        allow_no_contact: bool,
    ) -> Result<(), Error> {
        self.check_presses(presses, allow_no_contact).map(|_| ())
    }

    fn check(&self, cast: &Cast) -> Result<[u32; 2], SceneError> {
        check_length("membrane", cast.contact.membrane_mm(), MEMBRANE_LIMITS_MM)?;
        check_length("print sigma", cast.print_sigma_mm, SIGMA_LIMITS_MM)?;
        self.ray_grid_size(cast.samples)
    }

    /// Returns the number of columns and rows of rays for `samples` rays along each side of a pixel.
    ///
    /// # Errors
    /// Returns an error if `samples` is outside 1 to [`MAX_SAMPLES`] or there are more than [`MAX_RAYS`] rays.
    ///
    /// ```
    /// use fabkit_scene::MAX_SAMPLES;
    ///
    /// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
    /// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
    /// # let viewpoint = fabkit_scene::ground_truth::Viewpoint::new(&project.design.sensor.camera, None, None)?;
    /// # let viewpoint = viewpoint.resized([40, 30])?;
    /// # let scene = fabkit_scene::SensorView::new(std::sync::Arc::new(project), viewpoint)?;
    /// assert_eq!(scene.ray_grid_size(3)?, [120, 90]);
    /// assert!(scene.ray_grid_size(0).is_err());
    /// assert!(scene.ray_grid_size(MAX_SAMPLES + 1).is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn ray_grid_size(&self, samples: u32) -> Result<[u32; 2], SceneError> {
        let camera = self.viewpoint.camera();
        if !(1..=MAX_SAMPLES).contains(&samples) {
            return Err(SceneError::Samples { samples });
        }
        let [width, height] = [camera.width_px(), camera.height_px()].map(|side| side * samples);
        if u64::from(width) * u64::from(height) <= MAX_RAYS {
            return Ok([width, height]);
        }
        Err(SceneError::TooManyRays { width, height })
    }
}

fn touch(project: &Project) -> Result<&TouchSurface, SceneError> {
    let sensor = &project.design.sensor;
    sensor.touch.as_ref().ok_or_else(|| SceneError::NoSurface { sensor: sensor.name.clone() })
}
