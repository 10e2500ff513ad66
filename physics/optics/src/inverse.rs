//! Inverse problem: finds the ray from the pupil to a given point.
//!
//! A ray is determined by its direction at the pupil. Its offset from the point, measured across the ray, is a smooth
//! function of that direction as long as the ray passes the same surfaces; Newton's iteration finds its zero. Opaque
//! bodies are ignored during the search, so that a hidden point can be distinguished from one to which no light leads.

mod every;

use fabkit_geometry::{Point3, Ray, Vector3};
use nalgebra::{Matrix2, Matrix2x3, Matrix3x2, Vector2};

use crate::bundle::{Chain, Surfaces};
use crate::stack::Stack;
use crate::trace::{End, LightPath, Tracer};

/// Offset at which a ray counts as passing through a point, mm: a few roundings of its coordinates.
const NEAR_MM: f64 = 1e-12;

/// Offset that is accepted if rounding ends the iteration earlier, mm.
const NEAR_ENOUGH_MM: f64 = 1e-10;

/// Distance from a point at which the end of a ray counts as reaching it, mm.
const THERE_MM: f64 = 1e-6;

/// Maximum number of steps of an iteration, and of halvings of a step.
const MOST_STEPS: usize = 40;
const MOST_HALVINGS: usize = 6;

/// Maximum number of remembered surface sequences.
const MOST_CHAINS: usize = 6;

/// Step of central differences, rad: the one with the least error.
const STEP_RAD: f64 = 1e-5;

/// Step of one-sided differences, rad.
const SLOPE_STEP_RAD: f64 = 1e-7;

/// Number of directions of the fan, some of which are tried if the straight direction fails.
const STARTS: usize = 512;

/// Number of directions tried, those with the smallest offsets first.
const NEAREST: usize = 3;

/// A stack with and without its opaque bodies.
#[derive(Clone, Debug)]
pub struct Sights {
    stack: Stack,
    clear: Stack,
    surfaces: Surfaces,
}

/// Solver for rays to given points; one is needed per thread.
#[derive(Debug)]
pub struct Seeker<'a> {
    all: Tracer<'a>,
    clear: Tracer<'a>,
    surfaces: &'a Surfaces,
    /// Surface sequences past which points were found, the latest first: neighbouring points usually have the same.
    chains: Vec<Chain>,
    /// Surface sequences for which a search from its start has failed.
    barren: Vec<Chain>,
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
#[derive(Clone, Copy, Debug)]
pub struct Sight {
    /// Unit direction at the pupil, sensor frame.
    pub direction: Vector3<f64>,
    /// Path length from the pupil to the point, mm.
    pub way_mm: f64,
    /// Unit direction of the ray at the point.
    pub direction_there: Vector3<f64>,
    /// Actual path of the ray, with opaque bodies.
    pub path: LightPath,
}

/// Closest approach of a ray to a point.
struct Miss {
    /// Offset from the ray to the point, mm.
    off: Vector3<f64>,
    /// Direction of the ray at the closest approach.
    direction: Vector3<f64>,
    way_mm: f64,
}

impl Sights {
    /// Prepares a stack.
    pub fn new(stack: Stack) -> Self {
        let clear = stack.without_stops();
        Self { surfaces: Surfaces::of(&clear), clear, stack }
    }

    /// Returns the complete stack.
    pub fn stack(&self) -> &Stack {
        &self.stack
    }

    /// Returns whether any body refracts light.
    pub fn bends(&self) -> bool {
        self.stack.bends()
    }

    /// Creates a tracer that ignores opaque bodies, for one thread.
    pub fn media_tracer(&self) -> Tracer<'_> {
        Tracer::new(&self.clear)
    }

    /// Creates a solver for one thread.
    pub fn seeker(&self) -> Seeker<'_> {
        Seeker {
            all: Tracer::new(&self.stack),
            clear: Tracer::new(&self.clear),
            surfaces: &self.surfaces,
            chains: Vec::new(),
            barren: Vec::new(),
            fan: None,
        }
    }
}

impl Sight {
    /// Returns two unit vectors across a direction, along which its changes are measured.
    pub fn across(direction: &Vector3<f64>) -> Matrix3x2<f64> {
        let u = Vector3::ith(direction.iamin(), 1.0).cross(direction).normalize();
        Matrix3x2::from_columns(&[u, direction.cross(&u)])
    }

    /// Returns what ends the ray before the point, if anything does. The last `slack_mm` are free, because the point
    /// itself lies on the body that it belongs to.
    pub fn hidden_by(&self, slack_mm: f64) -> Option<End> {
        let ends_mm = self.path.lead_mm + self.path.end_mm;
        (ends_mm < self.way_mm - slack_mm).then_some(self.path.end)
    }
}

impl Seeker<'_> {
    /// Traces a ray through the complete stack.
    pub fn follow(&mut self, ray: &Ray) -> LightPath {
        self.all.follow(ray)
    }

    /// Finds a ray from a pupil through a point, sensor frame, mm. If there are several, one that nothing hides is
    /// preferred; the search begins at the straight line, so it usually finds the ray closest to that. Returns `None`
    /// if there is none, because light from the point is totally reflected or bent past the pupil.
    pub fn seek(&mut self, pupil: &Point3<f64>, place: &Point3<f64>) -> Option<Sight> {
        let straight = (place - pupil).try_normalize(0.0)?;
        // A closed-form solution that the real ray does not follow passes other faces; it is a good start for another
        // search. Among several rays to a point, one that is not hidden is preferred.
        let (mut leads, mut hidden) = (Vec::new(), None);
        for number in 0..self.chains.len() {
            let found = solve(&self.chains[number], pupil, place, &straight);
            let Some(direction) = found else { continue };
            if let Some(sight) = self.verified(pupil, place, &direction) {
                if sight.hidden_by(THERE_MM).is_none() {
                    // The most recently used comes first.
                    self.chains[..=number].rotate_right(1);
                    return Some(sight);
                }
                hidden = hidden.or(Some(sight));
            } else {
                leads.push(direction);
            }
        }
        let fan = self.nearest_of_fan(pupil, place);
        let starts = leads.into_iter().chain([straight]).chain(fan);
        let mut tried = Vec::new();
        for start in starts {
            let Some(sight) = self.search(pupil, place, start, &mut tried) else { continue };
            if sight.hidden_by(THERE_MM).is_none() {
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
        tried: &mut Vec<Chain>,
    ) -> Option<Sight> {
        let mut direction = start;
        loop {
            let ray = Ray { origin: *pupil, direction };
            let way_mm = self.miss(pupil, place, &direction).map_or(f64::INFINITY, |m| m.way_mm);
            let chain = Chain::of(&mut self.clear, self.surfaces, &ray, way_mm);
            let Some(chain) = chain else { break };
            // The same faces again: the search goes round in a circle.
            if tried.iter().any(|known| known.is_same(&chain)) {
                return None;
            }
            let next = solve(&chain, pupil, place, &direction);
            let sight = next.and_then(|next| self.verified(pupil, place, &next));
            if sight.is_some() {
                return sight;
            }
            let is_known = self.barren.iter().chain(&self.chains).any(|c| c.is_same(&chain));
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
        let (direction, _) = newton(start, |d| self.miss(pupil, place, d))?;
        self.verified(pupil, place, &direction)
    }

    /// Remembers the surface sequence of a ray, for neighbouring points.
    fn remember(&mut self, pupil: &Point3<f64>, sight: &Sight) {
        let ray = Ray { origin: *pupil, direction: sight.direction };
        let chain = Chain::of(&mut self.clear, self.surfaces, &ray, sight.way_mm);
        let Some(chain) = chain else { return };
        self.chains.retain(|known| !known.is_same(&chain));
        self.chains.insert(0, chain);
        self.chains.truncate(MOST_CHAINS);
    }

    /// Checks that a ray really passes through the point. If nothing ends it earlier, its traced path decides;
    /// otherwise it is traced without opaque bodies.
    fn verified(
        &mut self,
        pupil: &Point3<f64>,
        place: &Point3<f64>,
        direction: &Vector3<f64>,
    ) -> Option<Sight> {
        let direction = *direction;
        let path = self.all.follow(&Ray { origin: *pupil, direction });
        let open = Miss::of_path(place, self.all.corners(), &path);
        let is_near = |miss: &Miss| miss.off.norm() <= NEAR_ENOUGH_MM;
        let miss = match open.filter(is_near) {
            Some(miss) => miss,
            None => self.miss(pupil, place, &direction).filter(is_near)?,
        };
        Some(Sight { direction, way_mm: miss.way_mm, direction_there: miss.direction, path })
    }

    /// Computes the derivative of a ray's direction at the pupil by the point, 1/mm, along the two vectors across it
    /// that [`Sight::across`] returns. Returns `None` on a caustic, where light from neighbouring points arrives along
    /// one ray.
    pub fn by_place(
        &mut self,
        pupil: &Point3<f64>,
        place: &Point3<f64>,
        sight: &Sight,
    ) -> Option<Matrix2x3<f64>> {
        let by_direction = match self.chain_to(pupil, place, sight) {
            // In closed form, which is as exact.
            Some(chain) => by_direction(&sight.direction, |direction| {
                let (last, lead_mm) = chain.follow(pupil, direction)?;
                Some(Miss::of(place, &last, lead_mm))
            }),
            None => by_direction(&sight.direction, |direction| self.miss(pupil, place, direction)),
        }?;
        // If the point moves across the ray, the direction changes by the inverse of the offset's derivative.
        Some(by_direction.try_inverse()? * Sight::across(&sight.direction_there).transpose())
    }

    /// Returns the corners of a ray's path, sensor frame, mm: the pupil, the points of refraction, and the point.
    pub fn way(
        &mut self,
        pupil: &Point3<f64>,
        place: &Point3<f64>,
        sight: &Sight,
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
    fn chain_to(&self, pupil: &Point3<f64>, place: &Point3<f64>, sight: &Sight) -> Option<Chain> {
        let leads_there = |chain: &&Chain| {
            chain.follow(pupil, &sight.direction).is_some_and(|(last, lead_mm)| {
                let miss = Miss::of(place, &last, lead_mm);
                miss.off.norm() <= NEAR_ENOUGH_MM
                    && (miss.way_mm - sight.way_mm).abs() <= NEAR_ENOUGH_MM
            })
        };
        self.chains.iter().find(leads_there).cloned()
    }

    /// Returns the directions of the fan whose rays pass closest to a point.
    fn nearest_of_fan(&mut self, pupil: &Point3<f64>, place: &Point3<f64>) -> Vec<Vector3<f64>> {
        if self.fan.as_ref().is_none_or(|fan| fan.pupil != *pupil) {
            let rays = lattice(STARTS).map(|direction| {
                let path = self.clear.follow(&Ray { origin: *pupil, direction });
                (direction, self.clear.corners().to_vec(), path)
            });
            self.fan = Some(Fan { pupil: *pupil, rays: rays.collect() });
        }
        let rays = self.fan.iter().flat_map(|fan| &fan.rays);
        let missed = rays.filter_map(|(direction, corners, path)| {
            let miss = Miss::of_path(place, corners, path)?;
            Some((miss.off.norm(), *direction))
        });
        let mut missed: Vec<(f64, Vector3<f64>)> = missed.collect();
        missed.sort_by(|a, b| a.0.total_cmp(&b.0));
        missed.into_iter().take(NEAREST).map(|(_, direction)| direction).collect()
    }

    /// Traces a ray and returns its closest approach to a point; `None` if it ends before that.
    fn miss(
        &mut self,
        pupil: &Point3<f64>,
        place: &Point3<f64>,
        direction: &Vector3<f64>,
    ) -> Option<Miss> {
        let path = self.clear.follow(&Ray { origin: *pupil, direction: *direction });
        Miss::of_path(place, self.clear.corners(), &path)
    }
}

impl Miss {
    /// Computes the closest approach of a straight piece that begins `lead_mm` behind the pupil.
    fn of(place: &Point3<f64>, Ray { origin, direction }: &Ray, lead_mm: f64) -> Self {
        let along_mm = (place - origin).dot(direction);
        let off = place - (origin + along_mm * direction);
        Self { off, direction: *direction, way_mm: lead_mm + along_mm }
    }

    /// Computes the closest approach on the first straight piece that contains it; `None` if that is behind the pupil,
    /// or the path ends before.
    fn of_path(place: &Point3<f64>, corners: &[Point3<f64>], path: &LightPath) -> Option<Self> {
        let mut lead_mm = 0.0;
        for pair in corners.windows(2) {
            let length_mm = (pair[1] - pair[0]).norm();
            let direction = (pair[1] - pair[0]) / length_mm;
            let miss = Self::of(place, &Ray { origin: pair[0], direction }, lead_mm);
            lead_mm += length_mm;
            if miss.way_mm <= lead_mm {
                return Some(miss).filter(|miss| miss.way_mm > 0.0);
            }
        }
        let miss = Self::of(place, &path.last, lead_mm);
        // A ray that is totally reflected may pass the point before.
        let is_lost = matches!(path.end, End::Mirror(_)) && miss.way_mm > lead_mm + path.end_mm;
        (!is_lost && miss.way_mm > 0.0).then_some(miss)
    }
}

/// Generates evenly distributed unit directions: a Fibonacci lattice.
fn lattice(count: usize) -> impl Iterator<Item = Vector3<f64>> {
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
fn solve(
    chain: &Chain,
    pupil: &Point3<f64>,
    place: &Point3<f64>,
    start: &Vector3<f64>,
) -> Option<Vector3<f64>> {
    let found = newton(*start, |direction| {
        let (last, lead_mm) = chain.follow(pupil, direction)?;
        let miss = Miss::of(place, &last, lead_mm);
        (miss.way_mm > lead_mm).then_some(miss)
    });
    found.map(|(direction, _)| direction)
}

/// Solves for the direction at the pupil of a ray with zero offset, by Newton's iteration from `start`.
fn newton(
    start: Vector3<f64>,
    mut miss_of: impl FnMut(&Vector3<f64>) -> Option<Miss>,
) -> Option<(Vector3<f64>, Miss)> {
    let (mut direction, mut miss) = (start, miss_of(&start)?);
    let mut inverse: Option<Matrix2<f64>> = None;
    for _ in 0..MOST_STEPS {
        let off_mm = miss.off.norm();
        if off_mm <= NEAR_MM {
            return Some((direction, miss));
        }
        // The derivative of the previous step is reused while it works well.
        let is_old = inverse.is_some();
        let by_place = match inverse {
            Some(inverse) => inverse,
            None => slope(&direction, &miss, &mut miss_of)?.try_inverse()?,
        };
        let step = by_place * (Sight::across(&miss.direction).transpose() * miss.off);
        match shorter(&direction, step, off_mm, &mut miss_of) {
            Some((moved, nearer)) => {
                // A step that gains little means that the old derivatives no longer suffice.
                let gains = nearer.off.norm() < 1e-2 * off_mm;
                inverse = gains.then_some(by_place);
                (direction, miss) = (moved, nearer);
            }
            None if is_old => inverse = None,
            None if off_mm <= NEAR_ENOUGH_MM => return Some((direction, miss)),
            None => return None,
        }
    }
    (miss.off.norm() <= NEAR_ENOUGH_MM).then_some((direction, miss))
}

/// Computes the derivative of the offset across the ray by its direction at the pupil, mm, with central differences.
fn by_direction(
    direction: &Vector3<f64>,
    mut miss_of: impl FnMut(&Vector3<f64>) -> Option<Miss>,
) -> Option<Matrix2<f64>> {
    let across = Sight::across(direction);
    let there = Sight::across(&miss_of(direction)?.direction).transpose();
    let mut side = |axis: usize, by: f64| {
        let moved = (direction + by * across.column(axis)).normalize();
        miss_of(&moved).map(|miss| there * miss.off)
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
fn slope(
    direction: &Vector3<f64>,
    miss: &Miss,
    miss_of: &mut impl FnMut(&Vector3<f64>) -> Option<Miss>,
) -> Option<Matrix2<f64>> {
    let across = Sight::across(direction);
    let there = Sight::across(&miss.direction).transpose();
    let mut column = |axis: usize| {
        let moved = (direction + SLOPE_STEP_RAD * across.column(axis)).normalize();
        Some(there * (miss.off - miss_of(&moved)?.off) / SLOPE_STEP_RAD)
    };
    Some(Matrix2::from_columns(&[column(0)?, column(1)?]))
}

/// Returns the first of a step and its halves that reduces the offset.
fn shorter(
    direction: &Vector3<f64>,
    mut step: Vector2<f64>,
    off_mm: f64,
    miss_of: &mut impl FnMut(&Vector3<f64>) -> Option<Miss>,
) -> Option<(Vector3<f64>, Miss)> {
    let across = Sight::across(direction);
    // Larger steps than 0.5 rad are no better than a guess.
    step *= (0.5 / step.norm()).min(1.0);
    for _ in 0..MOST_HALVINGS {
        let moved = (direction + across * step).normalize();
        let found = miss_of(&moved).filter(|miss| miss.off.norm() < off_mm);
        if let Some(miss) = found {
            return Some((moved, miss));
        }
        step *= 0.5;
    }
    None
}
