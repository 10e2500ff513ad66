//! The bodies of a sensor as light meets them.

use fabkit_geometry::{
    Aabb, Assembly, Body, Clarity, CompiledSolid, Kind, Point3, Ray, Sensor, Vector3,
};

use crate::InvalidStack;
use crate::hollow::Hollow;
use crate::last_face::LastFace;
use crate::sensing::SensingSurface;
use crate::trace::{End, Tracer};

/// Of what is around all bodies.
pub(crate) const AIR: f64 = 1.0;

/// Most kinds of bodies, so that one byte a pixel says which.
pub const MAX_NAMES: usize = 250;

/// Largest index of what is known to be clear: diamond's is 2.4.
const MAX_INDEX: f64 = 4.0;

/// Boxes grow by this much, so that rounding hides nothing, mm.
const BOX_SLACK_MM: f64 = 1e-6;

/// Rays that look for media which overlap.
const OVERLAP_RAYS: usize = 2_048;

/// Overlaps shorter than that along a ray are rounding, mm.
const LEAST_OVERLAP_MM: f64 = 1e-6;

/// What a body is to light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Part {
    /// It lets light through, and may be what shows the touch.
    Medium {
        /// Its refractive index.
        index: f64,
        /// Whether it counts as skin too, where light goes on from skin.
        is_skin: bool,
    },
    /// It shows the touch.
    Skin,
    /// It ends rays.
    Stop {
        /// Whether it counts as skin where light goes on from skin: gel that lets no light through shows a
        /// touch to what lies on it, and hides the touch where the camera meets it first.
        is_skin: bool,
    },
}

/// One body in its place.
#[derive(Clone, Debug)]
pub(crate) struct Item {
    pub(crate) solid: CompiledSolid,
    pub(crate) bounds: Aabb,
    /// Where it surely is not.
    pub(crate) hollows: Vec<Hollow>,
    pub(crate) part: Part,
    /// Which of the stack's names.
    pub(crate) name: u8,
}

/// A sensor as light meets it: see the crate's model.
#[derive(Clone, Debug)]
pub struct Stack {
    pub(crate) items: Vec<Item>,
    pub(crate) sensing: Option<SensingSurface>,
    names: Vec<String>,
    /// What the camera's own model has of it.
    pub(crate) passed: Option<LastFace>,
}

impl Stack {
    /// The bodies of the finished sensor but for the camera's own.
    ///
    /// # Errors
    /// Clear bodies of unknown or impossible index, media that overlap where the camera looks, a camera within
    /// a part, more than [`MAX_NAMES`] kinds of bodies.
    pub fn of(sensor: &Sensor) -> Result<Self, InvalidStack> {
        let pupil = sensor.camera.sensor_from_camera.point(Point3::origin());
        let place = Assembly::sensor();
        let mut stack = Self { items: Vec::new(), sensing: None, names: Vec::new(), passed: None };
        for body in &sensor.bodies {
            let places = body.placements.iter().filter(|placed| placed.assembly == place);
            let Some(part) = places.clone().next().map(|_| Part::of(sensor, body)) else {
                continue;
            };
            let part = part?;
            let count = stack.names.len();
            for placement in places {
                let of_body = |source| InvalidStack::Solid { body: body.name.clone(), source };
                let solid = body.solid.clone().placed(placement.assembly_from_body);
                let solid = CompiledSolid::new(&solid).map_err(of_body)?;
                if !part.is_stop() || !solid.contains(&pupil) {
                    let bounds = solid.bounds().grown(BOX_SLACK_MM);
                    // Others may be many, and rays do not start there.
                    let mut hollows = Hollow::of(&body.solid, &placement.assembly_from_body);
                    hollows.retain(|hollow| hollow.holds(&pupil));
                    stack.items.push(Item { solid, bounds, hollows, part, name: count as u8 });
                } else if body.kind != Kind::Bought {
                    let body = body.name.clone();
                    return Err(InvalidStack::CameraInside { body, place_in_sensor: pupil });
                }
            }
            if stack.items.last().is_some_and(|item| usize::from(item.name) == count) {
                stack.names.push(body.name.clone());
            }
        }
        if stack.names.len() > MAX_NAMES {
            return Err(InvalidStack::TooMany { count: stack.names.len() });
        }
        if let Some(touch) = &sensor.touch {
            let of_touch = |source| InvalidStack::Solid { body: "surface".into(), source };
            stack.sensing = Some(SensingSurface::new(touch).map_err(of_touch)?);
        }
        stack.find_overlap(pupil)?;
        Ok(stack)
    }

    /// The same bodies for a camera whose own model says how light is bent on its way: they hide what is
    /// behind them, and bend nothing.
    ///
    /// # Errors
    /// As for [`Stack::of`], but for what is said of media.
    pub fn straight(sensor: &Sensor) -> Result<Self, InvalidStack> {
        let mut sensor = sensor.clone();
        for body in &mut sensor.bodies {
            body.substance.refractive_index = Some(AIR);
        }
        Self::of(&sensor)
    }

    /// Whether any medium differs from air.
    pub(crate) fn bends(&self) -> bool {
        let bends = |item: &Item| matches!(item.part, Part::Medium { index, .. } if index != AIR);
        self.items.iter().any(bends)
    }

    /// What light passes, and what counts as skin.
    pub(crate) fn without_stops(&self) -> Self {
        let mut clear = self.clone();
        clear.items.retain(|item| item.part != Part::Stop { is_skin: false });
        clear
    }

    /// Names of the bodies, as [`End`](crate::End) numbers them.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// What a ray ended at, in words.
    pub fn name_of(&self, end: End) -> &str {
        match end {
            End::Surface => "surface",
            End::Body(name) => &self.names[usize::from(name)],
            End::Mirror(_) => "total reflection",
            End::Nothing => "nothing",
        }
    }

    /// Refuses a camera whose pupil lies in what light does not pass.
    ///
    /// # Errors
    /// [`InvalidStack::CameraInside`].
    pub fn check_pupil(&self, place_in_sensor: &Point3<f64>) -> Result<(), InvalidStack> {
        let around = |item: &&Item| {
            !matches!(item.part, Part::Medium { .. }) && item.solid.contains(place_in_sensor)
        };
        let Some(item) = self.items.iter().find(around) else { return Ok(()) };
        let body = self.names[usize::from(item.name)].clone();
        Err(InvalidStack::CameraInside { body, place_in_sensor: *place_in_sensor })
    }

    /// Looks along straight rays for places that two media claim.
    fn find_overlap(&self, pupil: Point3<f64>) -> Result<(), InvalidStack> {
        let media = self.without_stops();
        let mut tracer = Tracer::new(&media);
        for number in 0..OVERLAP_RAYS {
            let ray = Ray { origin: pupil, direction: direction(number) };
            if let Some((from_mm, to_mm, [a, b])) = tracer.overlap(&ray, LEAST_OVERLAP_MM) {
                let name = |item: usize| self.names[usize::from(media.items[item].name)].clone();
                return Err(InvalidStack::Overlap {
                    bodies: [name(a), name(b)],
                    place_in_sensor: ray.at(from_mm),
                    depth_mm: to_mm - from_mm,
                });
            }
        }
        Ok(())
    }
}

/// One of [`OVERLAP_RAYS`] directions, spread evenly (a Fibonacci lattice).
fn direction(number: usize) -> Vector3<f64> {
    let along = 1.0 - (2 * number + 1) as f64 / OVERLAP_RAYS as f64;
    let (sin, cos) = (number as f64 * std::f64::consts::PI * (3.0 - 5.0_f64.sqrt())).sin_cos();
    let across = (1.0 - along * along).sqrt();
    Vector3::new(across * cos, across * sin, along)
}

impl Part {
    /// Whether it ends rays that meet it first.
    pub fn is_stop(self) -> bool {
        matches!(self, Self::Stop { .. })
    }

    /// What a body of a sensor is.
    ///
    /// # Errors
    /// A clear body of unknown or impossible index.
    pub fn of(sensor: &Sensor, body: &Body) -> Result<Self, InvalidStack> {
        let is_looked_at = sensor.sight.contains(&body.name) || body.gives_way;
        if body.clarity() != Clarity::Clear {
            let is_skin = body.kind == Kind::Cast;
            return Ok(if is_looked_at { Self::Skin } else { Self::Stop { is_skin } });
        }
        match body.substance.refractive_index {
            Some(index) if (AIR..=MAX_INDEX).contains(&index) => {
                Ok(Self::Medium { index, is_skin: is_looked_at })
            }
            Some(index) => Err(InvalidStack::Index { body: body.name.clone(), index }),
            None => Err(InvalidStack::UnknownIndex {
                body: body.name.clone(),
                material: body.material.clone(),
            }),
        }
    }
}
