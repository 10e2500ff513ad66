//! Inverse problem: finds the ray from the pupil to a given point.
//!
//! A ray is determined by its direction at the pupil. Its offset from the point, measured across the ray, is a smooth
//! function of that direction as long as the ray passes the same surfaces; Newton's iteration finds its zero. Opaque
//! bodies are ignored during the search, so that a hidden point can be distinguished from one to which no light leads.

mod all_rays;

use fabkit_geometry::{Point3, Ray, Vector3};
use nalgebra::{Matrix2, Matrix2x3, Matrix3x2, Vector2};

use crate::stack::OpticalStack;
use crate::tile_tracing::{FaceSurfaces, RefractionSequence};
use crate::trace::{LightPath, RayEnd, Tracer};

/// Offset at which a ray counts as passing through a point, mm: a few roundings of its coordinates.
const OFFSET_TOLERANCE_MM: f64 = 1e-12;

/// Offset that is accepted if rounding ends the iteration earlier, mm.
const ACCEPTED_OFFSET_MM: f64 = 1e-10;

/// Distance from a point at which the end of a ray counts as reaching it, mm.
const END_TOLERANCE_MM: f64 = 1e-6;

/// Maximum number of steps of an iteration, and of halvings of a step.
const MAX_STEPS: usize = 40;
const MAX_HALVINGS: usize = 6;

/// Maximum number of remembered surface sequences.
const MAX_SEQUENCES: usize = 6;

/// Step of central differences, rad: the one with the least error.
const STEP_RAD: f64 = 1e-5;

/// Step of one-sided differences, rad.
const SLOPE_STEP_RAD: f64 = 1e-7;

/// Number of directions of the fan, some of which are tried if the straight direction fails.
const STARTS: usize = 512;

/// Number of directions tried, those with the smallest offsets first.
const MAX_FAN_STARTS: usize = 3;

/// A stack with and without its opaque bodies.
#[derive(Clone, Debug)]
pub struct ViewStacks {
    stack: OpticalStack,
    clear: OpticalStack,
    surfaces: FaceSurfaces,
}

/// Solver for rays to given points; one is needed per thread.
#[derive(Debug)]
pub struct SightLineSolver<'a> {
    all: Tracer<'a>,
    clear: Tracer<'a>,
    surfaces: &'a FaceSurfaces,
    /// Surface sequences past which points were found, the latest first: neighbouring points usually have the same.
    chains: Vec<RefractionSequence>,
    /// Surface sequences for which a search from its start has failed.
    barren: Vec<RefractionSequence>,
    fan: Option<Fan>,
}

/// Rays from one pupil in all directions.
#[derive(Debug)]
struct Fan {
    pupil: Point3<f64>,
    /// Direction, corners and path of each ray.
    rays: Vec<(Vector3<f64>, Vec<Point3<f64>>, LightPath)>,
}

/// Ray that passes through a point if nothing opaque blocks it.
///
/// ```
/// # use fabkit_geometry::{Angle, Assembly, Body, NominalCamera, Placement, Point3, Pose, Sensor, Solid};
/// # let camera = NominalCamera {
/// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
/// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
/// # };
/// # let lid = Body::bought("lid", "steel", Solid::cylinder(20.0, 1.0).at(0.0, 0.0, 10.0))
/// #     .placed([Placement::in_place(Assembly::sensor())]);
/// use fabkit_optics::{OpticalStack, RayEnd, ViewStacks};
///
/// // A lid at z = 10 mm hides what lies behind it; it is found nevertheless.
/// let sights = ViewStacks::new(OpticalStack::from_sensor(&Sensor::new("box", "A box", "", camera, [lid]))?);
/// let mut solver = sights.sight_line_solver();
/// let pupil = Point3::origin();
/// let behind = solver.find_sight_line(&pupil, &Point3::new(0.0, 0.0, 15.0)).unwrap();
/// assert_eq!((behind.way_mm, behind.hidden_by(1e-6)), (15.0, Some(RayEnd::Body(0))));
/// // A point on the lid is not hidden by it.
/// let before = solver.find_sight_line(&pupil, &Point3::new(3.0, 0.0, 10.0)).unwrap();
/// assert_eq!(before.hidden_by(1e-6), None);
/// # Ok::<(), fabkit_optics::InvalidStack>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct SightLine {
    /// Unit direction at the pupil, sensor frame.
    pub direction: Vector3<f64>,
    /// Path length from the pupil to the point, mm.
    pub way_mm: f64,
    /// Unit direction of the ray at the point.
    pub direction_at_point: Vector3<f64>,
    /// Actual path of the ray, with opaque bodies.
    pub path: LightPath,
}

/// Closest approach of a ray to a point.
struct ClosestApproach {
    /// Offset from the ray to the point, mm.
    offset_mm: Vector3<f64>,
    /// Direction of the ray at the closest approach.
    direction: Vector3<f64>,
    way_mm: f64,
}

impl ViewStacks {
    /// Prepares a stack.
    pub fn new(stack: OpticalStack) -> Self {
        let clear = stack.without_opaque();
        Self { surfaces: FaceSurfaces::of(&clear), clear, stack }
    }

    /// Returns the complete stack.
    pub fn stack(&self) -> &OpticalStack {
        &self.stack
    }

    /// Returns whether any body refracts light.
    ///
    /// ```
    /// # use fabkit_geometry::{Angle, Assembly, Body, MaterialProperties, NominalCamera, OpticalClarity};
    /// # use fabkit_geometry::{Placement, Pose, Sensor, Solid};
    /// # let camera = NominalCamera {
    /// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
    /// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
    /// # };
    /// # let mut pane = Body::bought("pane", "glass", Solid::cylinder(20.0, 2.0).at(0.0, 0.0, 5.0))
    /// #     .with_clarity(OpticalClarity::Clear)
    /// #     .placed([Placement::in_place(Assembly::sensor())]);
    /// # pane.substance = MaterialProperties { refractive_index: Some(1.5), ..MaterialProperties::default() };
    /// use fabkit_optics::{OpticalStack, ViewStacks};
    ///
    /// // A pane of glass, taken as glass, and taken as air.
    /// let sensor = Sensor::new("window", "A window", "", camera, [pane]);
    /// assert!(ViewStacks::new(OpticalStack::from_sensor(&sensor)?).bends());
    /// assert!(!ViewStacks::new(OpticalStack::without_refraction(&sensor)?).bends());
    /// # Ok::<(), fabkit_optics::InvalidStack>(())
    /// ```
    pub fn bends(&self) -> bool {
        self.stack.refracts()
    }

    /// Creates a tracer that ignores opaque bodies, for one thread.
    pub fn media_tracer(&self) -> Tracer<'_> {
        Tracer::new(&self.clear)
    }

    /// Creates a solver for one thread.
    pub fn sight_line_solver(&self) -> SightLineSolver<'_> {
        SightLineSolver {
            all: Tracer::new(&self.stack),
            clear: Tracer::new(&self.clear),
            surfaces: &self.surfaces,
            chains: Vec::new(),
            barren: Vec::new(),
            fan: None,
        }
    }
}

impl SightLine {
    /// Returns two unit vectors across a direction, along which its changes are measured.
    pub fn transverse_axes(direction: &Vector3<f64>) -> Matrix3x2<f64> {
        let u = Vector3::ith(direction.iamin(), 1.0).cross(direction).normalize();
        Matrix3x2::from_columns(&[u, direction.cross(&u)])
    }

    /// Returns what ends the ray before the point, if anything does. The last `slack_mm` are free, because the point
    /// itself lies on the body that it belongs to.
    pub fn hidden_by(&self, slack_mm: f64) -> Option<RayEnd> {
        let ends_mm = self.path.lead_mm + self.path.end_mm;
        (ends_mm < self.way_mm - slack_mm).then_some(self.path.end)
    }
}

impl SightLineSolver<'_> {
    /// Traces a ray through the complete stack.
    pub fn follow(&mut self, ray: &Ray) -> LightPath {
        self.all.follow(ray)
    }

    /// Finds a ray from a pupil through a point, sensor frame, mm. If there are several, one that nothing hides is
    /// preferred; the search begins at the straight line, so it usually finds the ray closest to that. Returns `None`
    /// if there is none, because light from the point is totally reflected or bent past the pupil.
    ///
    /// ```
    /// # use fabkit_geometry::{Angle, Assembly, Body, MaterialProperties, NominalCamera, OpticalClarity};
    /// # use fabkit_geometry::{Placement, Point3, Pose, Sensor, Solid};
    /// # let camera = NominalCamera {
    /// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
    /// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
    /// # };
    /// # let mut pane = Body::bought("pane", "glass", Solid::cylinder(20.0, 2.0).at(0.0, 0.0, 5.0))
    /// #     .with_clarity(OpticalClarity::Clear)
    /// #     .placed([Placement::in_place(Assembly::sensor())]);
    /// # pane.substance = MaterialProperties { refractive_index: Some(1.5), ..MaterialProperties::default() };
    /// use fabkit_optics::{OpticalStack, ViewStacks};
    ///
    /// // Behind a pane of 2 mm, a point 12 mm away and 9 mm aside.
    /// let sights = ViewStacks::new(OpticalStack::from_sensor(&Sensor::new("pane", "A pane", "", camera, [pane]))?);
    /// let mut solver = sights.sight_line_solver();
    /// let point = Point3::new(9.0, 0.0, 12.0);
    /// let sight = solver.find_sight_line(&Point3::origin(), &point).unwrap();
    /// // Glass lifts what lies behind it: the ray is flatter than the straight line, whose slope is 9 to 12.
    /// assert!(sight.direction.x / sight.direction.z > 0.75);
    /// // Both faces are parallel, and so are the ray's first and last piece.
    /// assert!((sight.direction_at_point - sight.direction).norm() < 1e-12);
    /// assert_eq!(solver.corners(&Point3::origin(), &point, &sight).len(), 4);
    /// # Ok::<(), fabkit_optics::InvalidStack>(())
    /// ```
    pub fn find_sight_line(
        &mut self,
        pupil: &Point3<f64>,
        place: &Point3<f64>,
    ) -> Option<SightLine> {
        let straight = (place - pupil).try_normalize(0.0)?;
        // A closed-form solution that the real ray does not follow passes other faces; it is a good start for another
        // search. Among several rays to a point, one that is not hidden is preferred.
        let (mut leads, mut hidden) = (Vec::new(), None);
        for number in 0..self.chains.len() {
            let found = solve_sequence(&self.chains[number], pupil, place, &straight);
            let Some(direction) = found else { continue };
            if let Some(sight) = self.verify(pupil, place, &direction) {
                if sight.hidden_by(END_TOLERANCE_MM).is_none() {
                    // The most recently used comes first.
                    self.chains[..=number].rotate_right(1);
                    return Some(sight);
                }
                hidden = hidden.or(Some(sight));
            } else {
                leads.push(direction);
            }
        }
        let fan = self.nearest_fan_directions(pupil, place);
        let starts = leads.into_iter().chain([straight]).chain(fan);
        let mut tried = Vec::new();
        for start in starts {
            let Some(sight) = self.search(pupil, place, start, &mut tried) else { continue };
            if sight.hidden_by(END_TOLERANCE_MM).is_none() {
                self.remember(pupil, &sight);
                return Some(sight);
            }
            hidden = hidden.or(Some(sight));
        }
        hidden
    }

    /// Searches past the faces that the start passes, then past those that the solution's ray passes, and so on. If the
    /// faces have no closed form, or a sequence fails for the first time, traced rays are used instead.
    fn search(
        &mut self,
        pupil: &Point3<f64>,
        place: &Point3<f64>,
        start: Vector3<f64>,
        tried: &mut Vec<RefractionSequence>,
    ) -> Option<SightLine> {
        let mut direction = start;
        loop {
            let ray = Ray { origin: *pupil, direction };
            let way_mm =
                self.closest_approach(pupil, place, &direction).map_or(f64::INFINITY, |m| m.way_mm);
            let chain = RefractionSequence::from_ray(&mut self.clear, self.surfaces, &ray, way_mm);
            let Some(chain) = chain else { break };
            // The same faces again: the search goes round in a circle.
            if tried.iter().any(|known| known.has_same_faces(&chain)) {
                return None;
            }
            let next = solve_sequence(&chain, pupil, place, &direction);
            let sight = next.and_then(|next| self.verify(pupil, place, &next));
            if sight.is_some() {
                return sight;
            }
            let is_known = self.barren.iter().chain(&self.chains).any(|c| c.has_same_faces(&chain));
            tried.push(chain.clone());
            match next {
                Some(next) => direction = next,
                None if is_known => return None,
                None => {
                    self.barren.push(chain);
                    break;
                }
            }
        }
        let (direction, _) = newton(start, |d| self.closest_approach(pupil, place, d))?;
        self.verify(pupil, place, &direction)
    }

    /// Remembers the surface sequence of a ray, for neighbouring points.
    fn remember(&mut self, pupil: &Point3<f64>, sight: &SightLine) {
        let ray = Ray { origin: *pupil, direction: sight.direction };
        let chain =
            RefractionSequence::from_ray(&mut self.clear, self.surfaces, &ray, sight.way_mm);
        let Some(chain) = chain else { return };
        self.chains.retain(|known| !known.has_same_faces(&chain));
        self.chains.insert(0, chain);
        self.chains.truncate(MAX_SEQUENCES);
    }

    /// Checks that a ray really passes through the point. If nothing ends it earlier, its traced path decides;
    /// otherwise it is traced without opaque bodies.
    fn verify(
        &mut self,
        pupil: &Point3<f64>,
        place: &Point3<f64>,
        direction: &Vector3<f64>,
    ) -> Option<SightLine> {
        let direction = *direction;
        let path = self.all.follow(&Ray { origin: *pupil, direction });
        let open = ClosestApproach::from_path(place, self.all.corners(), &path);
        let is_near = |miss: &ClosestApproach| miss.offset_mm.norm() <= ACCEPTED_OFFSET_MM;
        let miss = match open.filter(is_near) {
            Some(miss) => miss,
            None => self.closest_approach(pupil, place, &direction).filter(is_near)?,
        };
        Some(SightLine { direction, way_mm: miss.way_mm, direction_at_point: miss.direction, path })
    }

    /// Computes the derivative of a ray's direction at the pupil by the point, 1/mm, along the two vectors across it
    /// that [`SightLine::transverse_axes`] returns. Returns `None` on a caustic, where light from neighbouring points arrives along
    /// one ray.
    ///
    /// ```
    /// # use fabkit_geometry::{Angle, NominalCamera, Point3, Pose, Sensor};
    /// # let camera = NominalCamera {
    /// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
    /// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
    /// # };
    /// use fabkit_optics::{OpticalStack, ViewStacks};
    ///
    /// // In air: a millimetre across the ray, 20 mm away, turns it by a twentieth; along it, by nothing.
    /// let sights = ViewStacks::new(OpticalStack::from_sensor(&Sensor::new("air", "Air", "", camera, []))?);
    /// let mut solver = sights.sight_line_solver();
    /// let (pupil, point) = (Point3::origin(), Point3::new(0.0, 0.0, 20.0));
    /// let sight = solver.find_sight_line(&pupil, &point).unwrap();
    /// let by_point = solver.direction_by_point(&pupil, &point, &sight).unwrap();
    /// assert!((by_point.column(0).norm() - 0.05).abs() < 1e-9);
    /// assert!(by_point.column(2).norm() < 1e-9);
    /// # Ok::<(), fabkit_optics::InvalidStack>(())
    /// ```
    pub fn direction_by_point(
        &mut self,
        pupil: &Point3<f64>,
        place: &Point3<f64>,
        sight: &SightLine,
    ) -> Option<Matrix2x3<f64>> {
        let by_direction = match self.find_sequence(pupil, place, sight) {
            // In closed form, which is as exact.
            Some(chain) => offset_by_direction(&sight.direction, |direction| {
                let (last, lead_mm) = chain.follow(pupil, direction)?;
                Some(ClosestApproach::from_piece(place, &last, lead_mm))
            }),
            None => offset_by_direction(&sight.direction, |direction| {
                self.closest_approach(pupil, place, direction)
            }),
        }?;
        // If the point moves across the ray, the direction changes by the inverse of the offset's derivative.
        Some(
            by_direction.try_inverse()?
                * SightLine::transverse_axes(&sight.direction_at_point).transpose(),
        )
    }

    /// Returns the corners of a ray's path, sensor frame, mm: the pupil, the points of refraction, and the point.
    pub fn corners(
        &mut self,
        pupil: &Point3<f64>,
        place: &Point3<f64>,
        sight: &SightLine,
    ) -> Vec<Point3<f64>> {
        self.clear.follow(&Ray { origin: *pupil, direction: sight.direction });
        let mut left_mm = sight.way_mm;
        let mut way = vec![*pupil];
        for pair in self.clear.corners().windows(2) {
            left_mm -= (pair[1] - pair[0]).norm();
            if left_mm <= 0.0 {
                break;
            }
            way.push(pair[1]);
        }
        way.push(*place);
        way
    }

    /// Returns the remembered surface sequence past which a point was found.
    fn find_sequence(
        &self,
        pupil: &Point3<f64>,
        place: &Point3<f64>,
        sight: &SightLine,
    ) -> Option<RefractionSequence> {
        let leads_there = |chain: &&RefractionSequence| {
            chain.follow(pupil, &sight.direction).is_some_and(|(last, lead_mm)| {
                let miss = ClosestApproach::from_piece(place, &last, lead_mm);
                miss.offset_mm.norm() <= ACCEPTED_OFFSET_MM
                    && (miss.way_mm - sight.way_mm).abs() <= ACCEPTED_OFFSET_MM
            })
        };
        self.chains.iter().find(leads_there).cloned()
    }

    /// Returns the directions of the fan whose rays pass closest to a point.
    fn nearest_fan_directions(
        &mut self,
        pupil: &Point3<f64>,
        place: &Point3<f64>,
    ) -> Vec<Vector3<f64>> {
        if self.fan.as_ref().is_none_or(|fan| fan.pupil != *pupil) {
            let rays = fibonacci_directions(STARTS).map(|direction| {
                let path = self.clear.follow(&Ray { origin: *pupil, direction });
                (direction, self.clear.corners().to_vec(), path)
            });
            self.fan = Some(Fan { pupil: *pupil, rays: rays.collect() });
        }
        let rays = self.fan.iter().flat_map(|fan| &fan.rays);
        let missed = rays.filter_map(|(direction, corners, path)| {
            let miss = ClosestApproach::from_path(place, corners, path)?;
            Some((miss.offset_mm.norm(), *direction))
        });
        let mut missed: Vec<(f64, Vector3<f64>)> = missed.collect();
        missed.sort_by(|a, b| a.0.total_cmp(&b.0));
        missed.into_iter().take(MAX_FAN_STARTS).map(|(_, direction)| direction).collect()
    }

    /// Traces a ray and returns its closest approach to a point; `None` if it ends before that.
    fn closest_approach(
        &mut self,
        pupil: &Point3<f64>,
        place: &Point3<f64>,
        direction: &Vector3<f64>,
    ) -> Option<ClosestApproach> {
        let path = self.clear.follow(&Ray { origin: *pupil, direction: *direction });
        ClosestApproach::from_path(place, self.clear.corners(), &path)
    }
}

impl ClosestApproach {
    /// Computes the closest approach of a straight piece that begins `lead_mm` behind the pupil.
    fn from_piece(place: &Point3<f64>, Ray { origin, direction }: &Ray, lead_mm: f64) -> Self {
        let along_mm = (place - origin).dot(direction);
        let offset_mm = place - (origin + along_mm * direction);
        Self { offset_mm, direction: *direction, way_mm: lead_mm + along_mm }
    }

    /// Computes the closest approach on the first straight piece that contains it; `None` if that is behind the pupil,
    /// or the path ends before.
    fn from_path(place: &Point3<f64>, corners: &[Point3<f64>], path: &LightPath) -> Option<Self> {
        let mut lead_mm = 0.0;
        for pair in corners.windows(2) {
            let length_mm = (pair[1] - pair[0]).norm();
            let direction = (pair[1] - pair[0]) / length_mm;
            let miss = Self::from_piece(place, &Ray { origin: pair[0], direction }, lead_mm);
            lead_mm += length_mm;
            if miss.way_mm <= lead_mm {
                return Some(miss).filter(|miss| miss.way_mm > 0.0);
            }
        }
        let miss = Self::from_piece(place, &path.last, lead_mm);
        // A ray that is totally reflected may pass the point before.
        let is_lost =
            matches!(path.end, RayEnd::TotalReflection(_)) && miss.way_mm > lead_mm + path.end_mm;
        (!is_lost && miss.way_mm > 0.0).then_some(miss)
    }
}

/// Generates evenly distributed unit directions: a Fibonacci lattice.
fn fibonacci_directions(count: usize) -> impl Iterator<Item = Vector3<f64>> {
    (0..count).map(move |number| {
        let along = 1.0 - (2 * number + 1) as f64 / count as f64;
        let turn = number as f64 * std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
        let (sin, cos) = turn.sin_cos();
        let beside = (1.0 - along * along).sqrt();
        Vector3::new(beside * cos, beside * sin, along)
    })
}

/// Solves for the direction at the pupil of a ray past the given surfaces to a point. Whether the ray meets the faces
/// on these surfaces is not checked.
fn solve_sequence(
    chain: &RefractionSequence,
    pupil: &Point3<f64>,
    place: &Point3<f64>,
    start: &Vector3<f64>,
) -> Option<Vector3<f64>> {
    let found = newton(*start, |direction| {
        let (last, lead_mm) = chain.follow(pupil, direction)?;
        let miss = ClosestApproach::from_piece(place, &last, lead_mm);
        (miss.way_mm > lead_mm).then_some(miss)
    });
    found.map(|(direction, _)| direction)
}

/// Solves for the direction at the pupil of a ray with zero offset, by Newton's iteration from `start`.
fn newton(
    start: Vector3<f64>,
    mut miss_of: impl FnMut(&Vector3<f64>) -> Option<ClosestApproach>,
) -> Option<(Vector3<f64>, ClosestApproach)> {
    let (mut direction, mut miss) = (start, miss_of(&start)?);
    let mut inverse: Option<Matrix2<f64>> = None;
    for _ in 0..MAX_STEPS {
        let off_mm = miss.offset_mm.norm();
        if off_mm <= OFFSET_TOLERANCE_MM {
            return Some((direction, miss));
        }
        // The derivative of the previous step is reused while it works well.
        let is_old = inverse.is_some();
        let by_place = match inverse {
            Some(inverse) => inverse,
            None => {
                offset_by_direction_one_sided(&direction, &miss, &mut miss_of)?.try_inverse()?
            }
        };
        let step =
            by_place * (SightLine::transverse_axes(&miss.direction).transpose() * miss.offset_mm);
        match damp_step(&direction, step, off_mm, &mut miss_of) {
            Some((moved, nearer)) => {
                // A step that gains little means that the old derivatives no longer suffice.
                let gains = nearer.offset_mm.norm() < 1e-2 * off_mm;
                inverse = gains.then_some(by_place);
                (direction, miss) = (moved, nearer);
            }
            None if is_old => inverse = None,
            None if off_mm <= ACCEPTED_OFFSET_MM => return Some((direction, miss)),
            None => return None,
        }
    }
    (miss.offset_mm.norm() <= ACCEPTED_OFFSET_MM).then_some((direction, miss))
}

/// Computes the derivative of the offset across the ray by its direction at the pupil, mm, with central differences.
fn offset_by_direction(
    direction: &Vector3<f64>,
    mut miss_of: impl FnMut(&Vector3<f64>) -> Option<ClosestApproach>,
) -> Option<Matrix2<f64>> {
    let across = SightLine::transverse_axes(direction);
    let there = SightLine::transverse_axes(&miss_of(direction)?.direction).transpose();
    let mut side = |axis: usize, by: f64| {
        let moved = (direction + by * across.column(axis)).normalize();
        miss_of(&moved).map(|miss| there * miss.offset_mm)
    };
    let mut column = |axis: usize| {
        let (before, after) = (side(axis, -STEP_RAD)?, side(axis, STEP_RAD)?);
        // Reversed, because the offset points from the ray to the point.
        Some((before - after) / (2.0 * STEP_RAD))
    };
    Some(Matrix2::from_columns(&[column(0)?, column(1)?]))
}

/// Computes the same derivative as [`by_direction`] with one-sided differences, which suffices for Newton steps and
/// needs half as many rays.
fn offset_by_direction_one_sided(
    direction: &Vector3<f64>,
    miss: &ClosestApproach,
    miss_of: &mut impl FnMut(&Vector3<f64>) -> Option<ClosestApproach>,
) -> Option<Matrix2<f64>> {
    let across = SightLine::transverse_axes(direction);
    let there = SightLine::transverse_axes(&miss.direction).transpose();
    let mut column = |axis: usize| {
        let moved = (direction + SLOPE_STEP_RAD * across.column(axis)).normalize();
        Some(there * (miss.offset_mm - miss_of(&moved)?.offset_mm) / SLOPE_STEP_RAD)
    };
    Some(Matrix2::from_columns(&[column(0)?, column(1)?]))
}

/// Returns the first of a step and its halves that reduces the offset.
fn damp_step(
    direction: &Vector3<f64>,
    mut step: Vector2<f64>,
    off_mm: f64,
    miss_of: &mut impl FnMut(&Vector3<f64>) -> Option<ClosestApproach>,
) -> Option<(Vector3<f64>, ClosestApproach)> {
    let across = SightLine::transverse_axes(direction);
    // Larger steps than 0.5 rad are no better than a guess.
    step *= (0.5 / step.norm()).min(1.0);
    for _ in 0..MAX_HALVINGS {
        let moved = (direction + across * step).normalize();
        let found = miss_of(&moved).filter(|miss| miss.offset_mm.norm() < off_mm);
        if let Some(miss) = found {
            return Some((moved, miss));
        }
        step *= 0.5;
    }
    None
}
