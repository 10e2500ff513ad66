//! What stands in the way of a body that moves: exactly along straight legs, by small steps along
//! turns.

use fabkit_geometry::proofs::{Shadow, meetings, obstacles};
use fabkit_geometry::{Aabb, CompiledSolid, Leg, Motion, Point3, Pose, Ray, Vector3};
use rayon::prelude::*;

use crate::interference::deepest;
use crate::lines::{Bundle, Caster, DIRECTIONS, basis};
use crate::scene::Placed;

/// Lines along the longer side of what mover and obstacle have in common across the way.
const LINES: usize = 160;

/// Lines along that side where a rough answer may do.
const FEW: usize = 32;

/// Of so many lines side by side, one is tried first.
const COARSE: usize = 12;

/// What lies ahead by less is contact, mm.
const CONTACT_MM: f64 = 1e-5;

/// No point of a body goes further between two of the places at which a turn is looked at, mm.
const STEP_MM: f64 = 0.25;

/// Lines of each direction that look for an overlap in such a place.
const TURN_LINES: usize = 400;

/// Overlaps in such a place that are thinner are taken for what lies between two of them, mm.
const TURN_CONTACT_MM: f64 = 0.02;

/// Where a way ends too early.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contact {
    pub(crate) place: Point3<f64>,
    /// How much of the obstacle lies in the way, across it; for turns, how deep it is met.
    pub(crate) depth_mm: f64,
}

/// The lines along a straight way that may meet both bodies.
struct Lines {
    direction: Vector3<f64>,
    across: [Vector3<f64>; 2],
    from: [f64; 2],
    sides: [f64; 2],
    cell_mm: f64,
    size: [usize; 2],
    shadow: Option<Shadow>,
}

impl Lines {
    /// `None` if nothing is in the way.
    fn of(
        mover: &CompiledSolid,
        other: &CompiledSolid,
        direction: &Vector3<f64>,
        count: usize,
    ) -> Option<Self> {
        let [u, v] = basis(direction);
        let shadow = |bounds: &Aabb, w: &Vector3<f64>| {
            let half_mm = w.abs().dot(&(0.5 * (bounds.max - bounds.min)));
            let middle_mm = w.dot(&bounds.centre().coords);
            [middle_mm - half_mm, middle_mm + half_mm]
        };
        let [of_mover, of_other] = [mover.bounds(), other.bounds()];
        let ahead_mm = shadow(&of_other, direction)[1] - shadow(&of_mover, direction)[0];
        let common = [u, v].map(|w| {
            let (a, b) = (shadow(&of_mover, &w), shadow(&of_other, &w));
            [a[0].max(b[0]), a[1].min(b[1])]
        });
        let sides = common.map(|[from, to]| to - from);
        let may_meet = ahead_mm > 0.0 && sides.iter().all(|&s| s > CONTACT_MM && s.is_finite());
        if !may_meet {
            return None;
        }
        let cell_mm = sides[0].max(sides[1]) / count as f64;
        let size = sides.map(|side| (side / cell_mm).ceil() as usize);
        let from = common.map(|[from, _]| from);
        Some(Self {
            direction: *direction,
            across: [u, v],
            from,
            sides,
            cell_mm,
            size,
            shadow: None,
        })
    }

    /// Without the lines that provably meet nothing; `None` if all do not.
    fn that_may_meet(self, mover: &CompiledSolid, other: &CompiledSolid) -> Option<Self> {
        let boxes = obstacles(mover, &[other], &self.direction);
        if boxes.as_ref().is_some_and(Vec::is_empty) {
            return None;
        }
        let [u, v] = self.across;
        let middle = [0, 1].map(|k| self.from[k] + 0.5 * self.sides[k]);
        let centre = Point3::from(middle[0] * u + middle[1] * v);
        let half = self.sides.map(|side| 0.5 * side);
        let shadow = boxes.map(|boxes| Shadow::of(&boxes, &centre, &self.across, half));
        Some(Self { shadow, ..self })
    }

    /// Whether any of every `stride`-th line in both directions is blocked.
    fn is_any_blocked(&self, mover: &CompiledSolid, other: &CompiledSolid, stride: usize) -> bool {
        let row = |j: usize| {
            let mut casters = [Caster::default(), Caster::default()];
            (stride / 2..self.size[0]).step_by(stride).any(|i| {
                self.ray(i, j).is_some_and(|ray| met(&ray, mover, other, &mut casters).is_some())
            })
        };
        (stride / 2..self.size[1]).step_by(stride).any(row)
    }

    /// The line through a cell; none where it is known that nothing is met.
    fn ray(&self, i: usize, j: usize) -> Option<Ray> {
        let [x, y] = [i, j].map(|k| (k as f64 + 0.482) * self.cell_mm);
        let side = |k: usize| self.size[k] as f64 * self.cell_mm;
        let is_open =
            self.shadow.as_ref().is_none_or(|shadow| shadow.holds([x / side(0), y / side(1)]));
        let [u, v] = self.across;
        let origin = Point3::from((self.from[0] + x) * u + (self.from[1] + y) * v);
        is_open.then_some(Ray { origin, direction: self.direction })
    }

    /// Which lines are blocked, and where, row by row.
    fn blocked(&self, mover: &CompiledSolid, other: &CompiledSolid) -> Vec<Option<Point3<f64>>> {
        let row = |j: usize| {
            let mut casters = [Caster::default(), Caster::default()];
            (0..self.size[0])
                .map(|i| self.ray(i, j).and_then(|ray| met(&ray, mover, other, &mut casters)))
                .collect::<Vec<_>>()
        };
        (0..self.size[1]).into_par_iter().flat_map_iter(row).collect()
    }

    /// Where most is in the way, and how much.
    fn deepest(&self, mover: &CompiledSolid, other: &CompiledSolid) -> Option<Contact> {
        let blocked = self.blocked(mover, other);
        let deep = depths(&blocked, self.size);
        let (index, cells) = deep.into_iter().enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
        // Of a strip one cell wide, the middle is one cell from what is free.
        let depth_mm = (2.0 * cells - 1.0) * self.cell_mm;
        blocked[index].map(|place| Contact { place, depth_mm })
    }
}

/// Where a line meets what lies ahead of the mover.
fn met(
    ray: &Ray,
    mover: &CompiledSolid,
    other: &CompiledSolid,
    [first, second]: &mut [Caster; 2],
) -> Option<Point3<f64>> {
    let [_, hindmost_mm] = *first.ends(mover, ray).first()?;
    let ahead = second.ends(other, ray).iter();
    let mut ahead = ahead.filter(|[from, to]| to - from.max(hindmost_mm) > CONTACT_MM);
    ahead.next().map(|[from, _]| ray.at(from.max(hindmost_mm)))
}

/// Whether anything of `other` lies ahead of the mover on its way out of everything.
pub(crate) fn is_blocked(
    mover: &CompiledSolid,
    other: &CompiledSolid,
    direction: &Vector3<f64>,
) -> bool {
    let Some(lines) = Lines::of(mover, other, direction, LINES) else { return false };
    // A few lines tell most of what is blocked, and a proof most of what is not.
    lines.is_any_blocked(mover, other, COARSE)
        || lines
            .that_may_meet(mover, other)
            .is_some_and(|lines| lines.is_any_blocked(mover, other, 1))
}

/// The same with place and depth: the thickness, across the way, of what is in it. It is known to one
/// cell, of which [`LINES`] lie side by side.
pub(crate) fn contact(
    mover: &CompiledSolid,
    other: &CompiledSolid,
    direction: &Vector3<f64>,
    allowed_mm: f64,
) -> Option<Contact> {
    let lines = Lines::of(mover, other, direction, LINES)?.that_may_meet(mover, other)?;
    let contact = lines.deepest(mover, other)?;
    let is_meant = allowed_mm > 0.0 && contact.depth_mm <= allowed_mm + lines.cell_mm;
    (!is_meant).then_some(contact)
}

/// Whether what is in the way reaches deeper into it than is allowed: what [`contact`] finds, told by few
/// lines where it is much deeper.
pub(crate) fn is_too_deep(
    mover: &CompiledSolid,
    other: &CompiledSolid,
    direction: &Vector3<f64>,
    allowed_mm: f64,
) -> bool {
    let Some(few) = Lines::of(mover, other, direction, FEW) else { return false };
    let deepest = few.deepest(mover, other);
    deepest.is_some_and(|contact| contact.depth_mm > allowed_mm + 3.0 * few.cell_mm)
        || contact(mover, other, direction, allowed_mm).is_some()
}

/// Distance of each blocked cell from the nearest free one, in cells: steps of 1 and sqrt(2)
/// (Borgefors, "Distance transformations in digital images", 1986), 8 % too long at most.
fn depths(blocked: &[Option<Point3<f64>>], [width, height]: [usize; 2]) -> Vec<f64> {
    let mut far: Vec<f64> =
        blocked.iter().map(|met| if met.is_some() { f64::INFINITY } else { 0.0 }).collect();
    let near = |far: &[f64], i: usize, j: usize, [di, dj]: [isize; 2]| {
        let at = |k: usize, d: isize, n: usize| k.checked_add_signed(d).filter(|&k| k < n);
        let of = at(i, di, width).zip(at(j, dj, height)).map_or(0.0, |(i, j)| far[j * width + i]);
        of + (di as f64).hypot(dj as f64)
    };
    let half = [[-1, 0], [-1, -1], [0, -1], [1, -1]];
    let cells = |backwards: bool| {
        let all = width * height;
        (0..all).map(move |k| if backwards { all - 1 - k } else { k })
    };
    for (backwards, sign) in [(false, 1), (true, -1)] {
        for k in cells(backwards) {
            let steps = half.map(|[di, dj]| [sign * di, sign * dj]);
            let least = steps
                .map(|s| near(&far, k % width, k / width, s))
                .into_iter()
                .fold(far[k], f64::min);
            far[k] = least;
        }
    }
    far
}

/// How deep two bodies in their places overlap, if they do by more than a turn can leave unseen.
pub(crate) fn overlap(a: &CompiledSolid, b: &CompiledSolid, allowed_mm: f64) -> Option<Contact> {
    let boxes = meetings(a, b)?;
    if boxes.is_empty() {
        return None;
    }
    let common = a.bounds().common(&b.bounds());
    let mut casters = [Caster::default(), Caster::default()];
    let is_met = DIRECTIONS.iter().any(|direction| {
        let bundle = Bundle::through(&common, (*direction).into(), TURN_LINES);
        let mut lines = bundle.through_boxes(&boxes).map(|index| bundle.line(index));
        lines.any(|ray| {
            let [in_a, in_b] = &mut casters;
            let in_a = in_a.ends(a, &ray);
            let in_b = if in_a.is_empty() { &[] } else { in_b.ends(b, &ray) };
            let common = |x: &[f64; 2], y: &[f64; 2]| x[1].min(y[1]) - x[0].max(y[0]);
            in_b.iter().any(|y| in_a.iter().any(|x| common(x, y) > TURN_CONTACT_MM))
        })
    });
    if !is_met {
        return None;
    }
    let limit_mm = allowed_mm + TURN_CONTACT_MM;
    deepest(a, b, limit_mm)
        .filter(|(depth_mm, _)| *depth_mm > limit_mm)
        .map(|(depth_mm, place)| Contact { place, depth_mm })
}

/// Follows a stated way back from its end; the first contact with one of the others, and which.
pub(crate) fn follow<'a>(
    motion: &Motion,
    movers: &[&Placed<'a>],
    others: &[&Placed<'a>],
    allowed_mm: &dyn Fn(&Placed, &Placed) -> f64,
) -> Option<(Contact, usize)> {
    // Where it stands, from where it stands in its place.
    let mut moved = Pose::identity();
    for leg in motion.legs.iter().rev() {
        let steps = steps(leg, movers);
        for _ in 0..steps {
            moved = back(leg, steps).then_in(moved);
            if let Some(met) = met_at(&moved, movers, others, allowed_mm) {
                return Some(met);
            }
        }
        if let Leg::Straight { along, length_mm: None } = leg {
            return met_outwards(&moved, -along, movers, others, allowed_mm);
        }
    }
    None
}

/// How many steps a leg takes that is looked at by steps.
fn steps(leg: &Leg, movers: &[&Placed]) -> usize {
    let way_mm = match leg {
        Leg::Straight { length_mm, .. } => length_mm.unwrap_or(0.0),
        Leg::Turn { point, axis, angle, rise_mm } => {
            let corners = movers.iter().flat_map(|mover| corners(&mover.body.bounds()));
            let radius_mm = corners.map(|corner| (corner - point).cross(axis).norm());
            (radius_mm.fold(0.0, f64::max) * angle.rad()).hypot(*rise_mm)
        }
    };
    (way_mm / STEP_MM).ceil() as usize
}

/// One of so many equal steps back along a leg.
fn back(leg: &Leg, steps: usize) -> Pose {
    let share = -1.0 / steps as f64;
    match leg {
        Leg::Straight { along, length_mm } => {
            let by = share * length_mm.unwrap_or(0.0) * along;
            Pose::translation(by.x, by.y, by.z)
        }
        Leg::Turn { point, axis, angle, rise_mm } => {
            let frame = Pose::z_to(*axis, *point);
            let part = fabkit_geometry::Angle::from_rad(share * angle.rad());
            let turn = Pose::rotation_z(part.expect("a part of an angle is finite"));
            let screw = Pose::translation(0.0, 0.0, share * rise_mm).then_in(turn);
            frame.then_in(screw).then_in(frame.inverse())
        }
    }
}

fn corners(bounds: &Aabb) -> [Point3<f64>; 8] {
    std::array::from_fn(|i| {
        let side = |axis: usize| [bounds.min[axis], bounds.max[axis]][(i >> axis) & 1];
        Point3::new(side(0), side(1), side(2))
    })
}

/// A body that has been moved away from its place; nothing if it cannot be, which solids that have been
/// placed once can.
fn at(moved: &Pose, mover: &Placed) -> Option<CompiledSolid> {
    CompiledSolid::new(&mover.of.solid.clone().placed(moved.then_in(mover.pose))).ok()
}

fn met_at(
    moved: &Pose,
    movers: &[&Placed],
    others: &[&Placed],
    allowed_mm: &dyn Fn(&Placed, &Placed) -> f64,
) -> Option<(Contact, usize)> {
    movers.iter().find_map(|mover| {
        let body = at(moved, mover)?;
        others.iter().enumerate().find_map(|(index, other)| {
            overlap(&body, &other.body, allowed_mm(mover, other)).map(|contact| (contact, index))
        })
    })
}

fn met_outwards(
    moved: &Pose,
    direction: Vector3<f64>,
    movers: &[&Placed],
    others: &[&Placed],
    allowed_mm: &dyn Fn(&Placed, &Placed) -> f64,
) -> Option<(Contact, usize)> {
    movers.iter().find_map(|mover| {
        let body = at(moved, mover)?;
        others.iter().enumerate().find_map(|(index, other)| {
            let allowed_mm = allowed_mm(mover, other);
            contact(&body, &other.body, &direction, allowed_mm).map(|contact| (contact, index))
        })
    })
}
