//! From a place to the ray that sees it.
//!
//! A ray is known by its direction at the pupil. How far it passes beside a place, measured across it, is a
//! smooth function of that direction as long as it passes the same surfaces; Newton's iteration finds where
//! that is 0. What is opaque is left out while a ray is looked for, so that a place that is hidden is told
//! from one to which no light leads.

use fabkit_geometry::{Point3, Ray, Vector3};
use nalgebra::{Matrix2, Matrix2x3, Matrix3x2, Vector2};

use crate::stack::Stack;
use crate::trace::{End, LightPath, Tracer};

/// Rays that pass a place nearer than that go through it, mm: a few roundings of its coordinates.
const NEAR_MM: f64 = 1e-12;

/// Where rounding ends the iteration earlier, this near is near enough, mm.
const NEAR_ENOUGH_MM: f64 = 1e-10;

/// Most steps of an iteration, and most halvings of a step.
const MOST_STEPS: usize = 40;
const MOST_HALVINGS: usize = 12;

/// Step of differences, rad: that of the least error of central ones.
const STEP_RAD: f64 = 1e-5;

/// The same where one side is enough.
const SLOPE_STEP_RAD: f64 = 1e-7;

/// Directions that are tried where the straight one leads nowhere.
const STARTS: usize = 96;

/// The stack as it is, and without what is opaque.
#[derive(Clone, Debug)]
pub struct Sights {
    stack: Stack,
    clear: Stack,
}

/// Finds rays; one per thread.
#[derive(Debug)]
pub struct Seeker<'a> {
    all: Tracer<'a>,
    clear: Tracer<'a>,
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
        Self { clear: stack.without_stops(), stack }
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
        Seeker { all: Tracer::new(&self.stack), clear: Tracer::new(&self.clear) }
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
        let found = self.newton(pupil, place, straight).or_else(|| {
            let start = self.nearest_start(pupil, place, &straight)?;
            self.newton(pupil, place, start)
        })?;
        let (direction, Miss { direction: direction_there, way_mm, .. }) = found;
        let path = self.all.follow(&Ray { origin: *pupil, direction });
        Some(Sight { direction, way_mm, direction_there, path })
    }

    /// Change of a sight's direction at the pupil with the place, 1/mm: along the two vectors across it that
    /// [`Sight::across`] gives. `None` where a caustic lies: light from nearby places arrives as one.
    pub fn by_place(
        &mut self,
        pupil: &Point3<f64>,
        place: &Point3<f64>,
        sight: &Sight,
    ) -> Option<Matrix2x3<f64>> {
        let by_direction = self.by_direction(pupil, place, &sight.direction, STEP_RAD)?;
        // Moved by something across the ray, the place is met by a direction that is off by the inverse.
        Some(by_direction.try_inverse()? * Sight::across(&sight.direction_there).transpose())
    }

    fn newton(
        &mut self,
        pupil: &Point3<f64>,
        place: &Point3<f64>,
        start: Vector3<f64>,
    ) -> Option<(Vector3<f64>, Miss)> {
        let (mut direction, mut miss) = (start, self.miss(pupil, place, &start)?);
        let mut inverse: Option<Matrix2<f64>> = None;
        for _ in 0..MOST_STEPS {
            let off_mm = miss.off.norm();
            if off_mm <= NEAR_MM {
                return Some((direction, miss));
            }
            let is_old = inverse.is_some();
            let by_place = match inverse {
                Some(inverse) => inverse,
                None => self.slope(pupil, place, &direction, &miss)?.try_inverse()?,
            };
            let step = by_place * (Sight::across(&miss.direction).transpose() * miss.off);
            let next = self.shorter(pupil, place, &direction, step, off_mm);
            match next {
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

    /// [`Seeker::by_direction`] to one side, which is enough to get nearer, for half as many rays.
    fn slope(
        &mut self,
        pupil: &Point3<f64>,
        place: &Point3<f64>,
        direction: &Vector3<f64>,
        miss: &Miss,
    ) -> Option<Matrix2<f64>> {
        let across = Sight::across(direction);
        let there = Sight::across(&miss.direction).transpose();
        let mut column = |axis: usize| {
            let moved = (direction + SLOPE_STEP_RAD * across.column(axis)).normalize();
            let moved = self.miss(pupil, place, &moved)?;
            Some(there * (miss.off - moved.off) / SLOPE_STEP_RAD)
        };
        Some(Matrix2::from_columns(&[column(0)?, column(1)?]))
    }

    /// The first of a step and its halves that leads nearer.
    fn shorter(
        &mut self,
        pupil: &Point3<f64>,
        place: &Point3<f64>,
        direction: &Vector3<f64>,
        mut step: Vector2<f64>,
        off_mm: f64,
    ) -> Option<(Vector3<f64>, Miss)> {
        let across = Sight::across(direction);
        // A step of more than that is a guess.
        step *= (0.5 / step.norm()).min(1.0);
        for _ in 0..MOST_HALVINGS {
            let moved = (direction + across * step).normalize();
            let found = self.miss(pupil, place, &moved).filter(|miss| miss.off.norm() < off_mm);
            if let Some(miss) = found {
                return Some((moved, miss));
            }
            step *= 0.5;
        }
        None
    }

    /// Change of where the ray passes, across it, with its direction at the pupil, mm.
    fn by_direction(
        &mut self,
        pupil: &Point3<f64>,
        place: &Point3<f64>,
        direction: &Vector3<f64>,
        step_rad: f64,
    ) -> Option<Matrix2<f64>> {
        let across = Sight::across(direction);
        let middle = self.miss(pupil, place, direction)?;
        let there = Sight::across(&middle.direction).transpose();
        let mut side = |axis: usize, by: f64| {
            let moved = (direction + by * across.column(axis)).normalize();
            self.miss(pupil, place, &moved).map(|miss| there * miss.off)
        };
        let mut columns = [Vector2::zeros(); 2];
        for (axis, column) in columns.iter_mut().enumerate() {
            let (before, after) = (side(axis, -step_rad)?, side(axis, step_rad)?);
            // The ray comes nearer by what its miss becomes smaller.
            *column = (before - after) / (2.0 * step_rad);
        }
        Some(Matrix2::from_columns(&columns))
    }

    /// Of directions all around, the one that passes nearest.
    fn nearest_start(
        &mut self,
        pupil: &Point3<f64>,
        place: &Point3<f64>,
        straight: &Vector3<f64>,
    ) -> Option<Vector3<f64>> {
        let across = Sight::across(straight);
        let starts = (0..STARTS).map(|number| {
            // A Fibonacci lattice on the half that looks towards the place.
            let along = 1.0 - (number as f64 + 0.5) / STARTS as f64;
            let turn = number as f64 * std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
            let (sin, cos) = turn.sin_cos();
            let beside = (1.0 - along * along).sqrt() * Vector2::new(cos, sin);
            along * straight + across * beside
        });
        let missed = |start| Some((self.miss(pupil, place, &start)?.off.norm(), start));
        let nearest = starts.filter_map(missed).min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.map(|(_, start)| start)
    }

    /// How a ray passes a place; `None` where it ends before that.
    fn miss(
        &mut self,
        pupil: &Point3<f64>,
        place: &Point3<f64>,
        direction: &Vector3<f64>,
    ) -> Option<Miss> {
        let path = self.clear.follow(&Ray { origin: *pupil, direction: *direction });
        if let End::Mirror(_) = path.end {
            // Before that it may pass the place.
            let along_mm = (place - path.last.origin).dot(&path.last.direction);
            if along_mm > path.end_mm {
                return None;
            }
        }
        let mut way_mm = 0.0;
        for pair in self.clear.corners().windows(2) {
            let piece = pair[1] - pair[0];
            let length_mm = piece.norm();
            let direction = piece / length_mm;
            let along_mm = (place - pair[0]).dot(&direction);
            if along_mm <= length_mm {
                let off = place - (pair[0] + along_mm * direction);
                return Some(Miss { off, direction, way_mm: way_mm + along_mm });
            }
            way_mm += length_mm;
        }
        let Ray { origin, direction } = path.last;
        let along_mm = (place - origin).dot(&direction);
        Some(Miss {
            off: place - (origin + along_mm * direction),
            direction,
            way_mm: way_mm + along_mm,
        })
    }
}
