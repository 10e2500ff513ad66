//! A sensor's surface and the camera that looks at it: what `depth` and `dataset` share.

mod contacts;
mod error;
mod files;
pub mod ground_truth;
pub mod legend;
pub mod pressing;

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use fabkit_depth::truth::{DepthMap, PixelRays, Presser, ReferenceSurface, Sigmas};
use fabkit_fixtures::{Press, PressBody, Project};
use fabkit_geometry::{Pose, TouchSurface};
use fabkit_optics::{Sights, TILE};

use self::contacts::Meeting;
pub use self::error::{SceneError, unknown_hint, words};
pub use self::files::{ViewpointFiles, viewpoint_from_files};
use fabkit_files::Error;
use fabkit_files::memory::{self, Less};

use crate::ground_truth::{
    Deepest, SurfaceCoverage, Viewpoint, coverage, coverage_map, deepest, pressers,
};
use crate::pressing::{Answer, Contact, ContactGap, PressingError, Ready, threads};

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
pub const MAX_RAYS: u64 = fabkit_depth::MAX_PIXELS;

/// Rays that are cast at once where they need not know each other.
const BAND_RAYS: u32 = 1 << 18;
/// What a ray takes while it is cast and looked at, bytes: measured on surfaces that are all contact.
const BAND_BYTES: u64 = 475;
/// The same with a transition around contacts.
const MEMBRANE_BYTES: u64 = 575;
/// The same where the surface gives way.
const YIELDING_BYTES: u64 = 540;
/// What it takes besides to say how sure a place behind bent rays is: counted, not measured.
pub const BENT_BYTES: u64 = 201;

/// A sensor whose surface a camera sees.
#[derive(Clone, Debug)]
pub struct SensorView {
    /// The sensor.
    pub project: Arc<Project>,
    /// The camera at its place.
    pub viewpoint: Viewpoint,
    /// What it sees of the surface: something.
    pub coverage: SurfaceCoverage,
    /// The sensor's bodies as its rays meet them.
    sights: Arc<Sights>,
    /// The soft layers as several presses at once found them last, and the distance of nodes that was asked for.
    layers: Arc<Mutex<Option<KeptLayers>>>,
}

/// Seconds of work that depends on nothing but the sensor and this distance of nodes, mm.
type KeptLayers = (Option<f64>, Arc<Ready>);

/// What to cast.
#[derive(Clone, Debug)]
pub struct Cast<'a> {
    /// What presses; nothing for the reference.
    pub presses: &'a [Press],
    /// Rays along each side of a pixel.
    pub samples: u32,
    /// How the surface answers.
    pub contact: Contact,
    /// How far all of it moves on along the surface, mm, as for [`Ready::answer`]; elastic contact alone knows.
    pub shear_mm: [f64; 2],
    /// Standard deviation of printed and cast surfaces along their normals, mm.
    pub print_sigma_mm: f64,
    /// Whether a press may miss the surface, or touch it where the camera sees nothing of it.
    pub allow_no_contact: bool,
}

impl Cast<'_> {
    /// Nothing presses, a ray a pixel, surfaces as drawn.
    pub fn at_rest(contact: Contact) -> Self {
        Self {
            presses: &[],
            samples: 1,
            contact,
            shear_mm: [0.0; 2],
            print_sigma_mm: 0.0,
            allow_no_contact: true,
        }
    }
}

/// What the camera sees of a press.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// Ground truth.
    pub map: &'a DepthMap<'a>,
    /// How sure it is.
    pub sigmas: &'a Sigmas,
    /// The deepest contact; `None` without contact.
    pub deepest: Option<Deepest>,
    /// How many pixels see the surface.
    pub surface_px: usize,
    /// What the soft layers answer, if they were asked.
    pub answer: Option<&'a Answer<'a>>,
    /// How far that is from rigid contact.
    pub gap: Option<ContactGap>,
}

/// What presses, where it ends up, and what the soft layers answer.
struct Pressing<'a> {
    pressers: Vec<Presser>,
    answer: Option<Answer<'a>>,
}

impl SensorView {
    /// Looks whether the camera sees the surface.
    ///
    /// # Errors
    /// A sensor without a surface of known shape, bodies that no light can be followed through, a camera
    /// that sees none of it.
    pub fn new(project: Arc<Project>, viewpoint: Viewpoint) -> Result<Self, Error> {
        let touch = touch(&project)?;
        let stack = viewpoint.stack(&project.design.sensor).map_err(SceneError::Light)?;
        let sights = Arc::new(Sights::new(stack));
        let coverage = coverage(touch, &viewpoint, &sights).map_err(Error::bug)?;
        if coverage.area == 0.0 {
            return Err(SceneError::unseen(&coverage).into());
        }
        Ok(Self { project, viewpoint, coverage, sights, layers: Arc::default() })
    }

    /// Whether somebody says how sure camera or pose are, and bodies bend rays behind them.
    pub fn is_unsure_behind_bends(&self) -> bool {
        self.viewpoint.says_how_sure() && self.sights.bends()
    }

    /// The sensor's bodies as the camera's rays meet them.
    pub fn sights(&self) -> &Sights {
        &self.sights
    }

    /// Which places of the unrolled surface the camera sees, and what keeps it from the others, as PNG.
    ///
    /// # Errors
    /// None that [`SensorView::new`] has not found.
    pub fn coverage_map(&self) -> Result<Vec<u8>, Error> {
        let touch = self.touch().map_err(Error::from)?;
        let picture = coverage_map(touch, &self.viewpoint, &self.sights, &self.coverage);
        let picture = picture.map_err(Error::bug)?;
        fabkit_export::png(picture.width_px, picture.height_px, &picture.rgb).map_err(Error::bug)
    }

    /// The rays of some rows of all pixels, each split into `samples` x `samples`, behind the sensor's
    /// bodies.
    pub fn rays_of_rows(&self, samples: u32, rows: Range<u32>) -> PixelRays {
        self.viewpoint.rays_of_rows(samples, rows).through(&self.sights)
    }

    /// The surface.
    ///
    /// # Errors
    /// None that [`SensorView::new`] has not found.
    pub fn touch(&self) -> Result<&TouchSurface, SceneError> {
        touch(&self.project)
    }

    /// Casts a press, and shows what is seen of it.
    ///
    /// # Errors
    /// Options beyond their limits, a press deeper than the surface is soft, one without contact
    /// unless that is allowed, and what `look` says.
    pub fn cast<R, E: From<Error>>(
        &self,
        cast: &Cast,
        look: impl FnOnce(Seen) -> Result<R, E>,
    ) -> Result<R, E> {
        let meetings = self.meetings(cast)?;
        let ready = self.ready(cast)?;
        let pressed = self.press(cast, ready.as_deref())?;
        self.cast_rows(cast, &pressed, 0..u32::MAX, |seen| {
            if seen.deepest.is_none() && !cast.allow_no_contact {
                self.check_seen(&meetings).map_err(Error::from)?;
            }
            look(seen)
        })
    }

    /// The same in bands of rows, from the top down, if they do not depend on each other: what is
    /// large need not be in memory at once. `kept` is how many bytes `look` keeps of each ray.
    ///
    /// # Errors
    /// As for [`SensorView::cast`]; more memory than allowed.
    pub fn cast_in_bands<E: From<Error>>(
        &self,
        cast: &Cast,
        kept: u64,
        mut look: impl FnMut(Seen) -> Result<(), E>,
    ) -> Result<(), E> {
        let [width, height] = self.check(cast).map_err(Error::from)?;
        let rays = u64::from(width) * u64::from(height);
        // A transition spreads as far as it likes.
        let is_whole = cast.contact.membrane_mm() > 0.0;
        // Bands end where tiles do, so that rays are bundled as they are in the whole.
        let band = (BAND_RAYS / width / TILE * TILE).max(TILE);
        let rows = if is_whole { height } else { band.min(height) };
        let at_once = u64::from(width) * u64::from(rows);
        let per_ray = match cast.contact {
            Contact::Rigid => BAND_BYTES,
            Contact::Membrane(_) => MEMBRANE_BYTES,
            Contact::Linear(_) => YIELDING_BYTES,
        };
        let per_ray = per_ray + if self.is_unsure_behind_bends() { BENT_BYTES } else { 0 };
        memory::admit(
            &format!("casting {width} x {height} rays for these files"),
            kept * rays + per_ray * at_once,
            Less::Rays,
        )
        .map_err(Error::from)?;
        let meetings = self.meetings(cast)?;
        let ready = self.ready(cast)?;
        let pressed = self.press(cast, ready.as_deref())?;
        let mut is_seen = false;
        (0..height).step_by(rows as usize).try_for_each(|top| {
            self.cast_rows(cast, &pressed, top..top.saturating_add(rows), |seen| {
                is_seen |= seen.deepest.is_some();
                look(seen)
            })
        })?;
        if !is_seen && !cast.allow_no_contact {
            self.check_seen(&meetings).map_err(Error::from)?;
        }
        Ok(())
    }

    fn meetings(&self, cast: &Cast) -> Result<Vec<Meeting>, Error> {
        self.check(cast)?;
        let presses = cast.presses.iter().map(|press| (press.id.as_str(), press));
        self.check_presses(presses, cast.allow_no_contact)
    }

    /// The soft layers, if something presses them and they are asked.
    fn ready(&self, cast: &Cast) -> Result<Option<Arc<Ready>>, Error> {
        let Contact::Linear(linear) = cast.contact else {
            return match cast.shear_mm == [0.0; 2] {
                true => Ok(None),
                false => Err(PressingError::RigidShear { contact: cast.contact.name() }.into()),
            };
        };
        let bodies: Vec<PressBody> =
            cast.presses.iter().flat_map(|press| press.bodies.clone()).collect();
        if bodies.is_empty() {
            return Ok(None);
        }
        let sensor = &self.project.design.sensor;
        let spacing_mm = linear.spacing_mm;
        if let [_] = &bodies[..] {
            return Ok(Some(Arc::new(Ready::for_press(sensor, &bodies, spacing_mm, threads())?)));
        }
        let mut kept = self.layers.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((of_mm, ready)) = &*kept
            && *of_mm == spacing_mm
        {
            return Ok(Some(ready.clone()));
        }
        let is_dragged = cast.shear_mm != [0.0; 2];
        let ready = Arc::new(Ready::for_all(sensor, spacing_mm, is_dragged, threads())?);
        *kept = Some((spacing_mm, ready.clone()));
        Ok(Some(ready))
    }

    /// What presses, where it ends up, and what the layers answer.
    fn press<'r>(&self, cast: &Cast, ready: Option<&'r Ready>) -> Result<Pressing<'r>, Error> {
        let mut presses = cast.presses.to_vec();
        let answer = match (ready, cast.contact) {
            (Some(ready), Contact::Linear(linear)) => {
                let bodies: Vec<PressBody> =
                    presses.iter().flat_map(|press| press.bodies.clone()).collect();
                let touch = self.touch()?;
                match ready.answer(touch, &bodies, cast.shear_mm, linear.friction) {
                    Err(error) if error.is_no_contact() && cast.allow_no_contact => None,
                    answer => Some(answer?),
                }
            }
            _ => None,
        };
        if let Some(answer) = &answer {
            let way = Pose::translation(answer.way_mm.x, answer.way_mm.y, answer.way_mm.z);
            for body in presses.iter_mut().flat_map(|press| &mut press.bodies) {
                body.sensor_from_body = way.then_in(body.sensor_from_body);
            }
        }
        Ok(Pressing { pressers: pressers(&presses).map_err(Error::bug)?, answer })
    }

    fn cast_rows<R, E: From<Error>>(
        &self,
        cast: &Cast,
        pressed: &Pressing,
        rows: Range<u32>,
        look: impl FnOnce(Seen) -> Result<R, E>,
    ) -> Result<R, E> {
        let touch = self.touch().map_err(Error::from)?;
        let rays = self.rays_of_rows(cast.samples, rows);
        let surface = ReferenceSurface::cast(touch, &rays).map_err(Error::bug)?;
        let Pressing { pressers, answer } = pressed;
        let contact = match answer {
            Some(answer) => surface.yielded(pressers, answer, true),
            None => surface.pressed(pressers),
        };
        let gap = answer.as_ref().map(|_| ContactGap::of(&contact, &surface.pressed(pressers)));
        let deepest = deepest(&contact, touch);
        let map = contact.with_membrane(cast.contact.membrane_mm());
        let sigmas = map.sigmas(&self.viewpoint.uncertainty(cast.print_sigma_mm));
        look(Seen {
            map: &map,
            sigmas: &sigmas,
            deepest,
            surface_px: surface.seen(),
            answer: answer.as_ref(),
            gap,
        })
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
    ) -> Result<(), Error> {
        self.check_presses(presses, allow_no_contact).map(|_| ())
    }

    fn check(&self, cast: &Cast) -> Result<[u32; 2], SceneError> {
        within("membrane", cast.contact.membrane_mm(), MEMBRANE_LIMITS_MM)?;
        within("print sigma", cast.print_sigma_mm, SIGMA_LIMITS_MM)?;
        self.size_rays(cast.samples)
    }

    /// Columns and rows of rays, `samples` along each side of a pixel.
    ///
    /// # Errors
    /// More of them than fabkit handles.
    pub fn size_rays(&self, samples: u32) -> Result<[u32; 2], SceneError> {
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

/// Checks a length.
///
/// # Errors
/// A value outside its limits, or no number.
pub fn within(name: &'static str, value_mm: f64, limits_mm: [f64; 2]) -> Result<(), SceneError> {
    let [least, most] = limits_mm;
    if (least..=most).contains(&value_mm) {
        return Ok(());
    }
    Err(SceneError::Length { name, value_mm, limits_mm })
}

fn touch(project: &Project) -> Result<&TouchSurface, SceneError> {
    let sensor = &project.design.sensor;
    sensor.touch.as_ref().ok_or_else(|| SceneError::NoSurface { sensor: sensor.name.clone() })
}
