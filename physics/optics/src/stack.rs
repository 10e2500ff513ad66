//! Optical stack: the bodies of a sensor as light meets them.

use fabkit_geometry::{
    Aabb, Assembly, Body, BodyKind, CompiledSolid, OpticalClarity, Point3, Ray, Sensor, Vector3,
};

use crate::InvalidStack;
use crate::hollow::Hollow;
use crate::last_face::LastFace;
use crate::sensing::SensingSurface;
use crate::trace::{RayEnd, Tracer};

/// Refractive index around all bodies.
pub(crate) const AIR_INDEX: f64 = 1.0;

/// Maximum number of names of bodies, so that one byte per pixel identifies them.
pub const MAX_NAMES: usize = 250;

/// Maximum refractive index of a clear body; that of diamond is 2.4.
const MAX_INDEX: f64 = 4.0;

/// Margin of boxes for rounding, mm.
const BOX_SLACK_MM: f64 = 1e-6;

/// Number of rays that search for overlapping media.
const OVERLAP_RAYS: usize = 2_048;

/// Length along a ray below which an overlap is rounding, mm.
const MIN_OVERLAP_MM: f64 = 1e-6;

/// Optical role of a body.
///
/// ```
/// # use fabkit_geometry::{Angle, Body, MaterialProperties, NominalCamera, OpticalClarity, Pose, Sensor, Solid};
/// # let camera = NominalCamera {
/// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
/// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
/// # };
/// use fabkit_optics::OpticalRole;
///
/// let mut gel = Body::cast("gel", "Clear gel", Solid::cylinder(9.0, 3.0)).with_clarity(OpticalClarity::Clear);
/// gel.substance = MaterialProperties { refractive_index: Some(1.41), ..MaterialProperties::default() };
/// let paint = Body::cast("paint", "Grey paint", Solid::cylinder(9.0, 0.1).at(0.0, 0.0, 3.0));
/// let mut sensor = Sensor::new("pad", "A pad", "", camera, [gel, paint]);
/// // The camera is meant to see the paint, through the gel.
/// sensor.visible_bodies = vec!["paint".to_owned()];
/// let role = |name| OpticalRole::from_body(&sensor, sensor.body(name).unwrap());
/// assert_eq!(role("gel")?, OpticalRole::Medium { index: 1.41, is_skin: false });
/// assert_eq!(role("paint")?, OpticalRole::Skin);
/// # Ok::<(), fabkit_optics::InvalidStack>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OpticalRole {
    /// Body that light passes; it may also show the touch.
    Medium {
        /// Refractive index.
        index: f64,
        /// True if it also counts as skin, for rays that come through skin.
        is_skin: bool,
    },
    /// Body that shows the touch.
    Skin,
    /// Body that ends rays.
    Opaque {
        /// True if it counts as skin for rays that come through skin. Opaque gel transmits a touch to the skin on it,
        /// and hides the touch if the camera meets the gel first.
        is_skin: bool,
    },
    /// Place of a body that is drawn elsewhere, as moving markers are: filled with the medium that light comes from, so
    /// that it goes straight on. No body has this role by itself; see [`OpticalStack::without_body`].
    Surroundings,
}

/// One placed body.
#[derive(Clone, Debug)]
pub(crate) struct Item {
    pub(crate) solid: CompiledSolid,
    pub(crate) bounds: Aabb,
    /// Regions that it certainly leaves free.
    pub(crate) hollows: Vec<Hollow>,
    pub(crate) part: OpticalRole,
    /// Index into the names of the stack.
    pub(crate) name: u8,
}

/// Bodies of a sensor as light meets them. See the model of the crate.
///
/// ```
/// # use fabkit_geometry::{Angle, Assembly, Body, NominalCamera, Placement, Point3, Pose, Ray, Sensor, Solid, Vector3};
/// # let camera = NominalCamera {
/// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
/// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
/// # };
/// use fabkit_optics::{OpticalStack, Tracer};
///
/// // An opaque lid, 10 mm above the pupil.
/// let lid = Body::bought("lid", "steel", Solid::cylinder(20.0, 1.0).at(0.0, 0.0, 10.0))
///     .placed([Placement::in_place(Assembly::sensor())]);
/// let stack = OpticalStack::from_sensor(&Sensor::new("box", "A box", "", camera, [lid]))?;
/// assert_eq!(stack.names(), ["lid"]);
/// let up = Ray { origin: Point3::origin(), direction: Vector3::z() };
/// let path = Tracer::new(&stack).follow(&up);
/// assert_eq!((stack.name_of(path.end), path.end_mm), ("lid", 10.0));
/// # Ok::<(), fabkit_optics::InvalidStack>(())
/// ```
#[derive(Clone, Debug)]
pub struct OpticalStack {
    pub(crate) items: Vec<Item>,
    pub(crate) sensing: Option<SensingSurface>,
    names: Vec<String>,
    /// Last face of the interface that the camera's own model contains, if any.
    pub(crate) modelled_face: Option<LastFace>,
}

impl OpticalStack {
    /// Builds the stack from the bodies of the assembled sensor, except the camera's own.
    ///
    /// # Errors
    /// If a clear body has an unknown or impossible refractive index, media overlap within the camera's view, the
    /// camera lies inside a body that ends light and is not a bought one, or there are more than [`MAX_NAMES`] names.
    pub fn from_sensor(sensor: &Sensor) -> Result<Self, InvalidStack> {
        let pupil = sensor.camera.sensor_from_camera.point(Point3::origin());
        let place = Assembly::sensor();
        let mut stack =
            Self { items: Vec::new(), sensing: None, names: Vec::new(), modelled_face: None };
        for body in &sensor.bodies {
            let places = body.placements.iter().filter(|placed| placed.assembly == place);
            let Some(part) = places.clone().next().map(|_| OpticalRole::from_body(sensor, body))
            else {
                continue;
            };
            let part = part?;
            let count = stack.names.len();
            for placement in places {
                let of_body = |source| InvalidStack::Solid { body: body.name.clone(), source };
                let solid = body.solid.clone().placed(placement.assembly_from_body);
                let solid = CompiledSolid::new(&solid).map_err(of_body)?;
                // A bought body around the pupil is the camera itself and is left out; any other one is an error.
                if !part.is_stop() || !solid.contains(&pupil) {
                    let bounds = solid.bounds().grown(BOX_SLACK_MM);
                    // Other hollows may be many, and rays do not start in them.
                    let mut hollows =
                        Hollow::from_solid(&body.solid, &placement.assembly_from_body);
                    hollows.retain(|hollow| hollow.contains(&pupil));
                    stack.items.push(Item { solid, bounds, hollows, part, name: count as u8 });
                } else if body.kind != BodyKind::Bought {
                    let body = body.name.clone();
                    return Err(InvalidStack::CameraInside { body, place_in_sensor: pupil });
                }
            }
            // The name is kept only if one of its placements was.
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

    /// Builds the stack for a camera whose own model describes the refraction on its way: bodies hide what is behind
    /// them, but refract nothing.
    ///
    /// # Errors
    /// As for [`OpticalStack::from_sensor`], except for those about media.
    ///
    /// ```
    /// # use fabkit_geometry::{Angle, Assembly, Body, NominalCamera, OpticalClarity, Placement, Point3, Pose};
    /// # use fabkit_geometry::{Ray, Sensor, Solid, Vector3};
    /// # let camera = NominalCamera {
    /// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
    /// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
    /// # };
    /// use fabkit_optics::{OpticalStack, Tracer};
    ///
    /// // No refractive index is needed: slanted rays pass the pane as if it were air.
    /// let pane = Body::bought("pane", "glass", Solid::cylinder(20.0, 2.0).at(0.0, 0.0, 5.0))
    ///     .with_clarity(OpticalClarity::Clear)
    ///     .placed([Placement::in_place(Assembly::sensor())]);
    /// let sensor = Sensor::new("window", "A window", "", camera, [pane]);
    /// assert!(OpticalStack::from_sensor(&sensor).is_err());
    /// let stack = OpticalStack::without_refraction(&sensor)?;
    /// let ray = Ray { origin: Point3::origin(), direction: Vector3::new(0.6, 0.0, 0.8) };
    /// let path = Tracer::new(&stack).follow(&ray);
    /// assert!((path.last.direction - ray.direction).norm() < 1e-12);
    /// # Ok::<(), fabkit_optics::InvalidStack>(())
    /// ```
    pub fn without_refraction(sensor: &Sensor) -> Result<Self, InvalidStack> {
        let mut sensor = sensor.clone();
        for body in &mut sensor.bodies {
            body.substance.refractive_index = Some(AIR_INDEX);
        }
        Self::from_sensor(&sensor)
    }

    /// Returns the stack as it would be if a body were not there and the medium around it filled its place.
    ///
    /// Whoever draws a body elsewhere must not take it off the sensor: that leaves a hole in the medium around it, at
    /// whose faces rays are refracted and end.
    ///
    /// ```
    /// # use fabkit_geometry::{Angle, Assembly, Body, MaterialProperties, NominalCamera, OpticalClarity};
    /// # use fabkit_geometry::{Placement, Point3, Pose, Ray, Sensor, Solid, Vector3};
    /// # let camera = NominalCamera {
    /// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
    /// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
    /// # };
    /// use fabkit_optics::{OpticalStack, Tracer};
    ///
    /// // A ball in a block of gel from z = 5 mm to 25 mm.
    /// let ball = || Solid::sphere(2.0).at(0.0, 0.0, 15.0);
    /// let block = Solid::cylinder(20.0, 20.0).at(0.0, 0.0, 5.0).minus(ball());
    /// # let mut gel = Body::bought("gel", "gel", block)
    /// #     .with_clarity(OpticalClarity::Clear)
    /// #     .placed([Placement::in_place(Assembly::sensor())]);
    /// # gel.substance = MaterialProperties { refractive_index: Some(1.41), ..MaterialProperties::default() };
    /// # let dot = Body::bought("dot", "steel", ball()).placed([Placement::in_place(Assembly::sensor())]);
    /// let stack = OpticalStack::from_sensor(&Sensor::new("pad", "A pad", "", camera, [gel, dot]))?;
    /// let ray = Ray { origin: Point3::origin(), direction: Vector3::new(0.1, 0.0, 0.995).normalize() };
    /// assert_eq!(stack.name_of(Tracer::new(&stack).follow(&ray).end), "dot");
    /// // Without the ball, light is refracted where it enters and leaves the block, and nowhere else.
    /// let filled = stack.without_body("dot");
    /// assert_eq!(Tracer::new(&filled).follow(&ray).bends, 2);
    /// # Ok::<(), fabkit_optics::InvalidStack>(())
    /// ```
    #[must_use]
    pub fn without_body(mut self, name: &str) -> Self {
        for item in &mut self.items {
            if self.names[usize::from(item.name)] == name {
                item.part = OpticalRole::Surroundings;
            }
        }
        self
    }

    /// Returns whether any medium differs from air.
    pub(crate) fn refracts(&self) -> bool {
        let bends = |item: &Item| matches!(item.part, OpticalRole::Medium { index, .. } if index != AIR_INDEX);
        self.items.iter().any(bends)
    }

    /// Returns the stack with media and skin only, including opaque bodies that count as skin.
    pub(crate) fn without_opaque(&self) -> Self {
        let mut clear = self.clone();
        clear.items.retain(|item| item.part != OpticalRole::Opaque { is_skin: false });
        clear
    }

    /// Returns the names of the bodies, indexed by [`End`](crate::RayEnd).
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Describes the end of a ray.
    pub fn name_of(&self, end: RayEnd) -> &str {
        match end {
            RayEnd::Surface => "surface",
            RayEnd::Body(name) => &self.names[usize::from(name)],
            RayEnd::TotalReflection(_) => "total reflection",
            RayEnd::Nothing => "nothing",
        }
    }

    /// Refuses a camera whose pupil lies in a body that light does not pass.
    ///
    /// # Errors
    /// [`InvalidStack::CameraInside`].
    ///
    /// ```
    /// # use fabkit_geometry::{Angle, Assembly, Body, NominalCamera, Placement, Point3, Pose, Sensor, Solid};
    /// # let camera = NominalCamera {
    /// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
    /// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
    /// # };
    /// use fabkit_optics::OpticalStack;
    ///
    /// // A lid from z = 10 mm to 11 mm. A calibrated pose may put the pupil elsewhere than the drawing does.
    /// let lid = Body::bought("lid", "steel", Solid::cylinder(20.0, 1.0).at(0.0, 0.0, 10.0))
    ///     .placed([Placement::in_place(Assembly::sensor())]);
    /// let stack = OpticalStack::from_sensor(&Sensor::new("box", "A box", "", camera, [lid]))?;
    /// assert!(stack.check_pupil(&Point3::new(0.0, 0.0, 2.0)).is_ok());
    /// assert!(stack.check_pupil(&Point3::new(0.0, 0.0, 10.5)).is_err());
    /// # Ok::<(), fabkit_optics::InvalidStack>(())
    /// ```
    pub fn check_pupil(&self, place_in_sensor: &Point3<f64>) -> Result<(), InvalidStack> {
        let around = |item: &&Item| {
            !matches!(item.part, OpticalRole::Medium { .. }) && item.solid.contains(place_in_sensor)
        };
        let Some(item) = self.items.iter().find(around) else { return Ok(()) };
        let body = self.names[usize::from(item.name)].clone();
        Err(InvalidStack::CameraInside { body, place_in_sensor: *place_in_sensor })
    }

    /// Searches along straight rays for points in two media.
    fn find_overlap(&self, pupil: Point3<f64>) -> Result<(), InvalidStack> {
        let media = self.without_opaque();
        let mut tracer = Tracer::new(&media);
        for number in 0..OVERLAP_RAYS {
            let ray = Ray { origin: pupil, direction: overlap_direction(number) };
            if let Some((from_mm, to_mm, [a, b])) = tracer.find_overlap(&ray, MIN_OVERLAP_MM) {
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

/// Returns one of [`OVERLAP_RAYS`] evenly distributed directions (a Fibonacci lattice).
fn overlap_direction(number: usize) -> Vector3<f64> {
    let along = 1.0 - (2 * number + 1) as f64 / OVERLAP_RAYS as f64;
    let (sin, cos) = (number as f64 * std::f64::consts::PI * (3.0 - 5.0_f64.sqrt())).sin_cos();
    let across = (1.0 - along * along).sqrt();
    Vector3::new(across * cos, across * sin, along)
}

impl OpticalRole {
    /// Returns whether the body ends rays that meet it first.
    pub fn is_stop(self) -> bool {
        matches!(self, Self::Opaque { .. })
    }

    /// Determines the optical role of a body.
    ///
    /// # Errors
    /// If a clear body has an unknown or impossible refractive index, or nobody states whether light passes a window.
    ///
    /// ```
    /// # use fabkit_geometry::{Angle, Body, NominalCamera, Pose, Process, Sensor, Solid};
    /// # let camera = NominalCamera {
    /// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
    /// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
    /// # };
    /// use fabkit_optics::OpticalRole;
    /// let pane = Body::made("pane", "", Process::Laser, Solid::cylinder(20.0, 2.0));
    /// let pane = pane.with_material("unobtainium").as_window(None);
    /// let sensor = Sensor::new("window", "A window", "", camera, [pane]);
    /// let error = OpticalRole::from_body(&sensor, &sensor.bodies[0]).unwrap_err();
    /// assert_eq!(error.to_string(), "pane: not known: transparency of unobtainium");
    /// ```
    pub fn from_body(sensor: &Sensor, body: &Body) -> Result<Self, InvalidStack> {
        if body.has_unknown_transparency() {
            let (body, material) = (body.name.clone(), body.material.clone());
            return Err(InvalidStack::UnknownTransparency { body, material });
        }
        let is_looked_at = sensor.visible_bodies.contains(&body.name) || body.is_deformable;
        if body.clarity() != OpticalClarity::Clear {
            // A marker stands off the surface: whoever sees it does not see the surface, whatever lies behind it.
            if sensor.is_marker_body(&body.name) {
                return Ok(Self::Opaque { is_skin: true });
            }
            // Cast layers may lie between the bodies that show the touch and the sensing surface.
            let is_skin = body.kind == BodyKind::Cast;
            return Ok(if is_looked_at { Self::Skin } else { Self::Opaque { is_skin } });
        }
        match body.substance.refractive_index {
            Some(index) if (AIR_INDEX..=MAX_INDEX).contains(&index) => {
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
