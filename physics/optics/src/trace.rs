//! Tracing of a single ray from medium to medium.

use fabkit_geometry::{Aabb, Point3, Ray, Scratch, Vector3};

use crate::sensing::START_TOLERANCE_MM;
use crate::snell::refract;
use crate::stack::{AIR_INDEX, OpticalRole, OpticalStack};

/// Distance along a ray within which two faces touch, mm. Solids that share a face are intersected separately; between
/// them there is no air for light to pass.
pub(crate) const TOUCH_TOLERANCE_MM: f64 = 1e-7;

/// Maximum number of refractions of a path; light that needs more is trapped.
const MAX_REFRACTIONS: u32 = 64;

/// End of a ray.
///
/// ```
/// # use fabkit_geometry::{Angle, Assembly, Body, MaterialProperties, NominalCamera, OpticalClarity};
/// # use fabkit_geometry::{Placement, Point3, Pose, Ray, Sensor, Solid, Vector3};
/// # let camera = NominalCamera {
/// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
/// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
/// # };
/// # let mut block = Body::bought("block", "glass", Solid::cylinder(20.0, 4.0).at(0.0, 0.0, -2.0))
/// #     .with_clarity(OpticalClarity::Clear)
/// #     .placed([Placement::in_place(Assembly::sensor())]);
/// # block.substance = MaterialProperties { refractive_index: Some(1.5), ..MaterialProperties::default() };
/// use fabkit_optics::{OpticalStack, RayEnd, Tracer};
///
/// // The pupil lies within glass of index 1.5, which light leaves up to arcsin(1 / 1.5) = 41.8 degrees.
/// let stack = OpticalStack::from_sensor(&Sensor::new("block", "A block", "", camera, [block]))?;
/// let end = |deg: f64| {
///     let (sin, cos) = deg.to_radians().sin_cos();
///     let ray = Ray { origin: Point3::origin(), direction: Vector3::new(sin, 0.0, cos) };
///     Tracer::new(&stack).follow(&ray).end
/// };
/// assert_eq!([end(41.0), end(43.0)], [RayEnd::Nothing, RayEnd::TotalReflection(0)]);
/// # Ok::<(), fabkit_optics::InvalidStack>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayEnd {
    /// Sensing surface.
    Surface,
    /// Body that hides what is behind it; index into [`OpticalStack::names`].
    Body(u8),
    /// Total reflection, from within at the face of this body or at the face to it.
    TotalReflection(u8),
    /// Nothing: the ray leaves the sensor.
    Nothing,
}

/// Path of a ray.
///
/// ```
/// # use fabkit_geometry::{Angle, Assembly, Body, MaterialProperties, NominalCamera, OpticalClarity};
/// # use fabkit_geometry::{Placement, Point3, Pose, Ray, Sensor, Solid, Vector3};
/// # let camera = NominalCamera {
/// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
/// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
/// # };
/// # let [pane, lid] = [("pane", 5.0), ("lid", 10.0)].map(|(name, z_mm)| {
/// #     Body::bought(name, "", Solid::cylinder(20.0, 2.0).at(0.0, 0.0, z_mm))
/// #         .placed([Placement::in_place(Assembly::sensor())])
/// # });
/// # let mut pane = pane.with_clarity(OpticalClarity::Clear);
/// # pane.substance = MaterialProperties { refractive_index: Some(1.5), ..MaterialProperties::default() };
/// use fabkit_optics::{OpticalStack, Tracer};
///
/// // Glass from z = 5 mm to 7 mm, and a lid at 10 mm.
/// let stack = OpticalStack::from_sensor(&Sensor::new("box", "A box", "", camera, [pane, lid]))?;
/// let up = Ray { origin: Point3::origin(), direction: Vector3::z() };
/// let path = Tracer::new(&stack).follow(&up);
/// // The last piece begins where the ray leaves the glass, so that the lid is 7 mm + 3 mm away.
/// assert!((path.lead_mm - 7.0).abs() < 1e-12 && (path.end_mm - 3.0).abs() < 1e-12);
/// assert_eq!(stack.name_of(path.end), "lid");
/// # Ok::<(), fabkit_optics::InvalidStack>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightPath {
    /// Last straight piece, from the last refraction.
    pub last: Ray,
    /// Length of all pieces before the last, mm.
    pub lead_mm: f64,
    /// Distance along the last piece at which it ends, mm; infinite if it leaves the sensor.
    pub end_mm: f64,
    /// End of the ray.
    pub end: RayEnd,
    /// Number of refractions.
    pub bends: u32,
}

/// Refraction of a ray between two media.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refraction {
    /// Position, sensor frame, mm.
    pub place: Point3<f64>,
    /// Unit normal of the face, on either side.
    pub normal: Vector3<f64>,
    /// Refractive indices before and behind the face.
    pub indices: [f64; 2],
}

/// Part of a line inside a body.
#[derive(Clone, Copy, Debug)]
struct BodyInterval {
    from_mm: f64,
    to_mm: f64,
    item: u32,
}

/// Event that ends a straight piece.
pub(crate) enum PieceEnd {
    Bend { at_mm: f64, normal: Vector3<f64>, to_index: f64, item: u32 },
    End { at_mm: f64, end: RayEnd },
}

impl PieceEnd {
    /// Returns the distance of the event, mm.
    pub(crate) fn at_mm(&self) -> f64 {
        match self {
            Self::Bend { at_mm, .. } | Self::End { at_mm, .. } => *at_mm,
        }
    }
}

/// Tracer of rays through a [`OpticalStack`]; one is needed per thread, so that its buffers are reused.
#[derive(Debug)]
pub struct Tracer<'a> {
    stack: &'a OpticalStack,
    /// Bodies that have not been intersected yet, each with the distance before which the line meets nothing of it; the
    /// nearest is last.
    pending_bodies: Vec<(f64, u32)>,
    /// Distances at which the line enters boxes, regardless of hollows.
    boxes: Vec<(f64, u32)>,
    insides: Vec<BodyInterval>,
    stretches: Vec<[f64; 2]>,
    scratch: Scratch,
    corners: Vec<Point3<f64>>,
    bends: Vec<Refraction>,
}

impl<'a> Tracer<'a> {
    /// Creates a tracer for one thread.
    pub fn new(stack: &'a OpticalStack) -> Self {
        Self {
            stack,
            pending_bodies: Vec::new(),
            boxes: Vec::new(),
            insides: Vec::new(),
            stretches: Vec::new(),
            scratch: Scratch::default(),
            corners: Vec::new(),
            bends: Vec::new(),
        }
    }

    /// Returns the start of the last traced ray and its points of refraction, in order, sensor frame, mm.
    ///
    /// ```
    /// # use fabkit_geometry::{Angle, NominalCamera, Pose, Sensor};
    /// # let camera = NominalCamera {
    /// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
    /// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
    /// # };
    /// use fabkit_geometry::{Point3, Ray, Vector3};
    /// use fabkit_optics::{OpticalStack, RayEnd, Tracer};
    ///
    /// // Where nothing is, a ray has no corner but its start, and no end.
    /// let stack = OpticalStack::from_sensor(&Sensor::new("air", "Air", "", camera, []))?;
    /// let mut tracer = Tracer::new(&stack);
    /// let path = tracer.follow(&Ray { origin: Point3::origin(), direction: Vector3::x() });
    /// assert_eq!((path.end, path.end_mm), (RayEnd::Nothing, f64::INFINITY));
    /// assert_eq!(tracer.corners(), [Point3::origin()]);
    /// # Ok::<(), fabkit_optics::InvalidStack>(())
    /// ```
    pub fn corners(&self) -> &[Point3<f64>] {
        &self.corners
    }

    /// Returns the refractions of the last traced ray, in order.
    ///
    /// ```
    /// # use fabkit_geometry::{Angle, Assembly, Body, MaterialProperties, NominalCamera, OpticalClarity};
    /// # use fabkit_geometry::{Placement, Point3, Pose, Ray, Sensor, Solid, Vector3};
    /// # let camera = NominalCamera {
    /// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
    /// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
    /// # };
    /// # let mut pane = Body::bought("pane", "glass", Solid::cylinder(20.0, 2.0).at(0.0, 0.0, 5.0))
    /// #     .with_clarity(OpticalClarity::Clear)
    /// #     .placed([Placement::in_place(Assembly::sensor())]);
    /// # pane.substance = MaterialProperties { refractive_index: Some(1.5), ..MaterialProperties::default() };
    /// use fabkit_optics::{OpticalStack, Tracer};
    ///
    /// // A pane from z = 5 mm to 7 mm: light goes from air into glass, and out again.
    /// let stack = OpticalStack::from_sensor(&Sensor::new("window", "A window", "", camera, [pane]))?;
    /// let mut tracer = Tracer::new(&stack);
    /// tracer.follow(&Ray { origin: Point3::origin(), direction: Vector3::new(0.6, 0.0, 0.8) });
    /// let [enters, leaves] = [tracer.bends()[0], tracer.bends()[1]];
    /// assert_eq!((enters.indices, leaves.indices), ([1.0, 1.5], [1.5, 1.0]));
    /// assert!((enters.place.z - 5.0).abs() < 1e-12 && (leaves.place.z - 7.0).abs() < 1e-12);
    /// # Ok::<(), fabkit_optics::InvalidStack>(())
    /// ```
    pub fn bends(&self) -> &[Refraction] {
        &self.bends
    }

    /// Traces a ray of unit direction from the pupil to its end.
    pub fn follow(&mut self, ray: &Ray) -> LightPath {
        self.bends.clear();
        self.corners.clear();
        self.corners.push(ray.origin);
        let mut path = LightPath {
            last: *ray,
            lead_mm: 0.0,
            end_mm: f64::INFINITY,
            end: RayEnd::Nothing,
            bends: 0,
        };
        let mut index = None;
        while path.bends < MAX_REFRACTIONS {
            match self.trace_piece(&path.last, &mut index) {
                PieceEnd::End { at_mm, end } => return LightPath { end_mm: at_mm, end, ..path },
                PieceEnd::Bend { at_mm, normal, to_index, item } => {
                    let from_index = index.unwrap_or(AIR_INDEX);
                    let ratio = from_index / to_index;
                    let Some(direction) = refract(&path.last.direction, &normal, ratio) else {
                        let name = self.stack.items[item as usize].name;
                        return LightPath {
                            end_mm: at_mm,
                            end: RayEnd::TotalReflection(name),
                            ..path
                        };
                    };
                    path.last = Ray { origin: path.last.at(at_mm), direction };
                    path.lead_mm += at_mm;
                    path.bends += 1;
                    index = Some(to_index);
                    self.corners.push(path.last.origin);
                    let indices = [from_index, to_index];
                    self.bends.push(Refraction { place: path.last.origin, normal, indices });
                }
            }
        }
        // Trapped light counts as leaving the sensor.
        path
    }

    /// Finds the first part of a line that lies in two media of different refractive index, and both of them.
    pub(crate) fn find_overlap(
        &mut self,
        ray: &Ray,
        least_mm: f64,
    ) -> Option<(f64, f64, [usize; 2])> {
        self.begin_line(ray);
        self.intersect_until(ray, f64::INFINITY);
        let index = |inside: &BodyInterval| match self.stack.items[inside.item as usize].part {
            OpticalRole::Medium { index, .. } => Some(index),
            _ => None,
        };
        self.insides.retain(|inside| index(inside).is_some());
        self.insides.sort_by(|a, b| a.from_mm.total_cmp(&b.from_mm));
        let pairs = self.insides.iter().enumerate().flat_map(|(i, a)| {
            self.insides[i + 1..]
                .iter()
                .map(move |b| (a, b))
                // Sorted by start: later ones cannot overlap `a` either.
                .take_while(|(a, b)| b.from_mm < a.to_mm)
        });
        pairs.filter(|(a, b)| index(a) != index(b)).find_map(|(a, b)| {
            let (from_mm, to_mm) = (b.from_mm.max(0.0), b.to_mm.min(a.to_mm));
            let items = [a.item as usize, b.item as usize];
            (to_mm - from_mm > least_mm).then_some((from_mm, to_mm, items))
        })
    }

    /// Follows a straight piece until something ends it. `index` is the refractive index of the present medium; the
    /// first piece determines it.
    pub(crate) fn trace_piece(&mut self, ray: &Ray, index: &mut Option<f64>) -> PieceEnd {
        self.begin_line(ray);
        let stack = self.stack;
        let (mut t_mm, mut last) = (0.0, None);
        loop {
            self.intersect_until(ray, t_mm + TOUCH_TOLERANCE_MM);
            // Looked up just behind the face, so that touching bodies leave no gap.
            let Some(inside) = self.body_at(t_mm + TOUCH_TOLERANCE_MM) else {
                if index.is_some_and(|index| index != AIR_INDEX) {
                    if self.is_sensing(ray, t_mm) {
                        return PieceEnd::End { at_mm: t_mm, end: RayEnd::Surface };
                    }
                    if let Some(item) = last {
                        let normal = self.normal(ray, item, t_mm, false);
                        return PieceEnd::Bend { at_mm: t_mm, normal, to_index: AIR_INDEX, item };
                    }
                }
                *index = Some(AIR_INDEX);
                match self.next_entry(ray, t_mm + TOUCH_TOLERANCE_MM) {
                    Some(next_mm) => t_mm = next_mm,
                    None => return PieceEnd::End { at_mm: f64::INFINITY, end: RayEnd::Nothing },
                }
                continue;
            };
            let item = &stack.items[inside.item as usize];
            match item.part {
                OpticalRole::Opaque { .. } => {
                    return PieceEnd::End { at_mm: t_mm, end: RayEnd::Body(item.name) };
                }
                OpticalRole::Skin => return self.trace_skin(ray, t_mm, item.name),
                OpticalRole::Medium { .. } | OpticalRole::Surroundings => {
                    let to_index = match item.part {
                        OpticalRole::Medium { index, .. } => index,
                        _ => index.unwrap_or(AIR_INDEX),
                    };
                    if *index.get_or_insert(to_index) != to_index {
                        // Of two touching faces, that of the body being entered counts, unless it was passed before.
                        let is_entered = (inside.from_mm - t_mm).abs() <= TOUCH_TOLERANCE_MM;
                        let face =
                            if is_entered { inside.item } else { last.unwrap_or(inside.item) };
                        let normal = self.normal(ray, face, t_mm, is_entered);
                        return PieceEnd::Bend { at_mm: t_mm, normal, to_index, item: inside.item };
                    }
                    // The same refractive index: straight on to the end of this body.
                    (t_mm, last) = (inside.to_mm, Some(inside.item));
                    if t_mm == f64::INFINITY {
                        return PieceEnd::End { at_mm: t_mm, end: RayEnd::Nothing };
                    }
                }
            }
        }
    }

    /// Returns the index of an item's name.
    pub(crate) fn name(&self, item: u32) -> u8 {
        self.stack.items[item as usize].name
    }

    /// Returns whether bodies of this name are skin and nothing else.
    pub(crate) fn is_skin(&self, name: u8) -> bool {
        self.stack.items.iter().any(|item| item.name == name && item.part == OpticalRole::Skin)
    }

    /// Returns the items whose boxes the present line enters before a distance, each once.
    pub(crate) fn boxes_before(&self, at_mm: f64) -> impl Iterator<Item = u32> {
        let before = self.boxes.iter().filter(move |(entry_mm, _)| *entry_mm <= at_mm);
        before.map(|(_, item)| *item)
    }

    /// Continues a ray that has met skin: it sees the surface if only skin lies between this point and the sensing
    /// surface.
    fn trace_skin(&mut self, ray: &Ray, at_mm: f64, name: u8) -> PieceEnd {
        let hidden = PieceEnd::End { at_mm, end: RayEnd::Body(name) };
        let Some(sensing) = &self.stack.sensing else { return hidden };
        let Some((exit_mm, _)) = sensing.exit(ray, &mut self.scratch) else { return hidden };
        let mut t_mm = at_mm;
        while t_mm < exit_mm - TOUCH_TOLERANCE_MM {
            self.intersect_until(ray, t_mm + TOUCH_TOLERANCE_MM);
            let Some(inside) = self.body_at(t_mm + TOUCH_TOLERANCE_MM) else { return hidden };
            match self.stack.items[inside.item as usize].part {
                OpticalRole::Skin
                | OpticalRole::Surroundings
                | OpticalRole::Medium { is_skin: true, .. }
                | OpticalRole::Opaque { is_skin: true } => {
                    t_mm = inside.to_mm;
                }
                OpticalRole::Opaque { .. } | OpticalRole::Medium { .. } => return hidden,
            }
        }
        PieceEnd::End { at_mm: exit_mm, end: RayEnd::Surface }
    }

    /// Returns whether a point of a ray lies on the sensing surface.
    fn is_sensing(&mut self, ray: &Ray, at_mm: f64) -> bool {
        let Some(sensing) = &self.stack.sensing else { return false };
        let exit = sensing.exit(ray, &mut self.scratch);
        exit.is_some_and(|(exit_mm, _)| (exit_mm - at_mm).abs() <= TOUCH_TOLERANCE_MM)
    }

    /// Returns the normal of the face that a ray passes at a distance.
    fn normal(&mut self, ray: &Ray, item: u32, at_mm: f64, entering: bool) -> Vector3<f64> {
        let solid = &self.stack.items[item as usize].solid;
        let crossing = solid.first_crossing(
            ray,
            at_mm - 2.0 * TOUCH_TOLERANCE_MM,
            entering,
            &mut self.scratch,
        );
        // Only a stretch too short to count has no such crossing.
        crossing.map_or(ray.direction, |crossing| crossing.normal)
    }

    /// Begins a line by finding the boxes that it enters.
    fn begin_line(&mut self, ray: &Ray) {
        self.insides.clear();
        self.boxes.clear();
        self.pending_bodies.clear();
        for (item, of) in self.stack.items.iter().enumerate() {
            if let Some(entry_mm) = box_entry(&of.bounds, ray) {
                self.boxes.push((entry_mm, item as u32));
                let free_mm = of.hollows.iter().map(|hollow| hollow.exit_mm(ray));
                self.pending_bodies.push((free_mm.fold(entry_mm, f64::max), item as u32));
            }
        }
        // The nearest is last, so that it can be popped; the index settles ties.
        self.pending_bodies.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(b.1.cmp(&a.1)));
    }

    /// Intersects all bodies whose boxes (without hollows) the line enters before a distance.
    fn intersect_until(&mut self, ray: &Ray, t_mm: f64) {
        while let Some(&(entry_mm, item)) = self.pending_bodies.last()
            && entry_mm <= t_mm
        {
            self.pending_bodies.pop();
            let solid = &self.stack.items[item as usize].solid;
            solid.stretches_into(ray, &mut self.scratch, &mut self.stretches);
            let ahead = self.stretches.iter().filter(|[_, to_mm]| *to_mm > START_TOLERANCE_MM);
            self.insides.extend(ahead.map(|&[from_mm, to_mm]| BodyInterval {
                from_mm,
                to_mm,
                item,
            }));
        }
    }

    /// Returns the body at a distance. Opaque bodies come before media, these before places that media
    /// fill, and among equals the one entered last wins.
    fn body_at(&self, t_mm: f64) -> Option<BodyInterval> {
        let items = &self.stack.items;
        let rank = |inside: &BodyInterval| match items[inside.item as usize].part {
            OpticalRole::Surroundings => 0,
            OpticalRole::Medium { .. } => 1,
            OpticalRole::Skin => 2,
            OpticalRole::Opaque { .. } => 3,
        };
        self.insides
            .iter()
            .filter(|inside| inside.from_mm <= t_mm && t_mm < inside.to_mm)
            .max_by(|a, b| {
                rank(a)
                    .cmp(&rank(b))
                    .then(a.from_mm.total_cmp(&b.from_mm))
                    .then(b.item.cmp(&a.item))
            })
            .copied()
    }

    /// Returns the distance at which the next body is entered, from a point in air.
    fn next_entry(&mut self, ray: &Ray, after_mm: f64) -> Option<f64> {
        loop {
            let ahead = self.insides.iter().map(|inside| inside.from_mm).filter(|&t| t > after_mm);
            let next_mm = ahead.fold(f64::INFINITY, f64::min);
            match self.pending_bodies.last() {
                Some(&(entry_mm, _)) if entry_mm < next_mm => self.intersect_until(ray, entry_mm),
                _ => return next_mm.is_finite().then_some(next_mm),
            }
        }
    }
}

/// Returns the distance at which a line enters a box ahead of its origin, if it does; 0 from within.
#[inline]
pub(crate) fn box_entry(bounds: &Aabb, line: &Ray) -> Option<f64> {
    let [entry, exit] = line.range_in(bounds)?;
    (exit >= 0.0).then_some(entry.max(0.0))
}
