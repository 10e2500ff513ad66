//! From a place to the ray that sees it.
//!
//! A ray is known by its direction at the pupil. How far it passes beside a place, measured across it, is a
//! smooth function of that direction as long as it passes the same surfaces; Newton's iteration finds where
//! that is 0. What is opaque is left out while a ray is looked for, so that a place that is hidden is told
//! from one to which no light leads.

mod every;

use fabkit_geometry::{Point3, Ray, Vector3};
use nalgebra::{Matrix2, Matrix2x3, Matrix3x2, Vector2};

use crate::bundle::{Chain, Surfaces};
use crate::stack::Stack;
use crate::trace::{End, LightPath, Tracer};

/// Rays that pass a place nearer than that go through it, mm: a few roundings of its coordinates.
const NEAR_MM: f64 = 1e-12;

/// Where rounding ends the iteration earlier, this near is near enough, mm.
const NEAR_ENOUGH_MM: f64 = 1e-10;

/// A ray that ends that near to a place ends there, mm.
const THERE_MM: f64 = 1e-6;

/// Most steps of an iteration, and most halvings of a step.
const MOST_STEPS: usize = 40;
const MOST_HALVINGS: usize = 6;

/// Ways past different faces that are remembered.
const MOST_CHAINS: usize = 6;

/// Step of differences, rad: that of the least error of central ones.
const STEP_RAD: f64 = 1e-5;

/// The same where one side is enough.
const SLOPE_STEP_RAD: f64 = 1e-7;

/// Directions of which some are tried where the straight one leads nowhere.
const STARTS: usize = 512;

/// How many of them, the nearest first.
const NEAREST: usize = 3;

/// The stack as it is, and without what is opaque.
#[derive(Clone, Debug)]
pub struct Sights {
    stack: Stack,
    clear: Stack,
    surfaces: Surfaces,
}

/// Finds rays; one per thread.
#[derive(Debug)]
pub struct Seeker<'a> {
    all: Tracer<'a>,
    clear: Tracer<'a>,
    surfaces: &'a Surfaces,
    /// The faces past which places were found, the last first: neighbours are found past the same.
    chains: Vec<Chain>,
    /// Those past which nothing was found where a search began.
    barren: Vec<Chain>,
    fan: Option<Fan>,
}

/// Rays from one pupil in all directions.
#[derive(Debug)]
struct Fan {
    pupil: Point3<f64>,
    /// Direction, corners and path of each.
    rays: Vec<(Vector3<f64>, Vec<Point3<f64>>, LightPath)>,
}

/// The ray that goes through a place if nothing opaque is in its way.
#[derive(Clone, Copy, Debug)]
pub struct Sight {
    /// Unit direction at the pupil, sensor frame.
    pub direction: Vector3<f64>,
    /// Length of the way from the pupil to the place, mm.
    pub way_mm: f64,
    /// Unit direction at the place.
    pub direction_there: Vector3<f64>,
    /// Where the ray really goes.
    pub path: LightPath,
}

/// Where a ray passes a place.
struct Miss {
    /// From the ray to the place, mm.
    off: Vector3<f64>,
    /// Direction of the ray there.
    direction: Vector3<f64>,
    way_mm: f64,
}

impl Sights {
    /// Prepares a stack.
    pub fn new(stack: Stack) -> Self {
        let clear = stack.without_stops();
        Self { surfaces: Surfaces::of(&clear), clear, stack }
    }

    /// All of it.
    pub fn stack(&self) -> &Stack {
        &self.stack
    }

    /// Whether anything in it bends light.
    pub fn bends(&self) -> bool {
        self.stack.bends()
    }

    /// Follows rays through what is clear, as if nothing stood in their way; for those of one thread.
    pub fn media_tracer(&self) -> Tracer<'_> {
        Tracer::new(&self.clear)
    }

    /// For the places of one thread.
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
    /// The two unit vectors across a direction along which its changes are counted.
    pub fn across(direction: &Vector3<f64>) -> Matrix3x2<f64> {
        let u = Vector3::ith(direction.iamin(), 1.0).cross(direction).normalize();
        Matrix3x2::from_columns(&[u, direction.cross(&u)])
    }

    /// What ends the ray before it is at the place, if anything does; the place itself lies on what it
    /// belongs to, so that the last `slack_mm` are free.
    pub fn hidden_by(&self, slack_mm: f64) -> Option<End> {
        let ends_mm = self.path.lead_mm + self.path.end_mm;
        (ends_mm < self.way_mm - slack_mm).then_some(self.path.end)
    }
}

impl Seeker<'_> {
    /// Follows a ray through all of the stack.
    pub fn follow(&mut self, ray: &Ray) -> LightPath {
        self.all.follow(ray)
    }

    /// The ray from a pupil through a place, sensor frame, mm; the one nearest to the straight line between
    /// them where there are several, `None` where there is none: light from there is totally reflected, or
    /// bent past the pupil.
    pub fn seek(&mut self, pupil: &Point3<f64>, place: &Point3<f64>) -> Option<Sight> {
        let straight = (place - pupil).try_normalize(0.0)?;
        // Where a way in closed form leads that the real ray does not go, it goes past other faces. Of several
        // rays to a place one that nothing hides is better.
        let (mut leads, mut hidden) = (Vec::new(), None);
        for number in 0..self.chains.len() {
            let found = solve(&self.chains[number], pupil, place, &straight);
            let Some(direction) = found else { continue };
            if let Some(sight) = self.verified(pupil, place, &direction) {
                if sight.hidden_by(THERE_MM).is_none() {
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

    /// Past the faces that a ray passes, then past those that the ray passes which that leads to, and so on;
    /// where these were never met before or have no closed form, with rays that are followed.
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

    /// The faces of a sight, for its neighbours.
    fn remember(&mut self, pupil: &Point3<f64>, sight: &Sight) {
        let ray = Ray { origin: *pupil, direction: sight.direction };
        let chain = Chain::of(&mut self.clear, self.surfaces, &ray, sight.way_mm);
        let Some(chain) = chain else { return };
        self.chains.retain(|known| !known.is_same(&chain));
        self.chains.insert(0, chain);
        self.chains.truncate(MOST_CHAINS);
    }

    /// Does a ray really go there? If nothing ends it before, that is known at once.
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

    /// Change of a sight's direction at the pupil with the place, 1/mm: along the two vectors across it that
    /// [`Sight::across`] gives. `None` where a caustic lies: light from nearby places arrives as one.
    pub fn by_place(
        &mut self,
        pupil: &Point3<f64>,
        place: &Point3<f64>,
        sight: &Sight,
    ) -> Option<Matrix2x3<f64>> {
        let by_direction = match self.chain_to(pupil, place, sight) {
            // In closed form, and as exact.
            Some(chain) => by_direction(&sight.direction, |direction| {
                let (last, lead_mm) = chain.follow(pupil, direction)?;
                Some(Miss::of(place, &last, lead_mm))
            }),
            None => by_direction(&sight.direction, |direction| self.miss(pupil, place, direction)),
        }?;
        // Moved by something across the ray, the place is met by a direction that is off by the inverse.
        Some(by_direction.try_inverse()? * Sight::across(&sight.direction_there).transpose())
    }

    /// The corners of a sight's way, sensor frame, mm: the pupil, where it is bent, and the place.
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

    /// The known faces past which a place was seen.
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

    /// Of directions all around, those that pass nearest.
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

    /// How a ray passes a place; `None` where it ends before that.
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
    /// Of a straight piece that begins `lead_mm` behind the pupil.
    fn of(place: &Point3<f64>, Ray { origin, direction }: &Ray, lead_mm: f64) -> Self {
        let along_mm = (place - origin).dot(direction);
        let off = place - (origin + along_mm * direction);
        Self { off, direction: *direction, way_mm: lead_mm + along_mm }
    }

    /// Of the first piece that does not end before it is beside the place; `None` where that is behind the
    /// pupil, or where the path ends before.
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
        // Before it is reflected it may pass the place.
        let is_lost = matches!(path.end, End::Mirror(_)) && miss.way_mm > lead_mm + path.end_mm;
        (!is_lost && miss.way_mm > 0.0).then_some(miss)
    }
}

/// Unit directions all around, evenly: a Fibonacci lattice.
fn lattice(count: usize) -> impl Iterator<Item = Vector3<f64>> {
    (0..count).map(move |number| {
        let along = 1.0 - (2 * number + 1) as f64 / count as f64;
        let turn = number as f64 * std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
        let (sin, cos) = turn.sin_cos();
        let beside = (1.0 - along * along).sqrt();
        Vector3::new(beside * cos, beside * sin, along)
    })
}

/// The direction at the pupil of a ray past these surfaces to a place, wherever they end.
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

/// The direction at the pupil of a ray that misses a place by nothing, by Newton's iteration from another.
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
        let is_old = inverse.is_some();
        let by_place = match inverse {
            Some(inverse) => inverse,
            None => slope(&direction, &miss, &mut miss_of)?.try_inverse()?,
        };
        let step = by_place * (Sight::across(&miss.direction).transpose() * miss.off);
        match shorter(&direction, step, off_mm, &mut miss_of) {
            Some((moved, nearer)) => {
                // A step that gains little asks for new derivatives.
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

/// Change of where a ray passes, across it, with its direction at the pupil, mm.
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
        // The ray comes nearer by what its miss becomes smaller.
        Some((before - after) / (2.0 * STEP_RAD))
    };
    Some(Matrix2::from_columns(&[column(0)?, column(1)?]))
}

/// [`by_direction`] to one side, which is enough to get nearer, for half as many rays.
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

/// The first of a step and its halves that leads nearer.
fn shorter(
    direction: &Vector3<f64>,
    mut step: Vector2<f64>,
    off_mm: f64,
    miss_of: &mut impl FnMut(&Vector3<f64>) -> Option<Miss>,
) -> Option<(Vector3<f64>, Miss)> {
    let across = Sight::across(direction);
    // A step of more than that is a guess.
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
