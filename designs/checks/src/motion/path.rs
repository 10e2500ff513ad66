//! Obstacles in the way of a moving body: exact along straight legs, in small steps along turns.

use fabkit_geometry::proofs::{ProjectionRaster, find_obstacle_boxes, find_overlap_boxes};
use fabkit_geometry::{Aabb, CompiledSolid, Motion, MotionLeg, Point3, Pose, Ray, Vector3};
use rayon::prelude::*;

use crate::interference::deepest;
use crate::sampling_lines::{Bundle, Caster, DIRECTIONS, basis};
use crate::scene::Placed;

/// Number of lines along the longer side of the region that mover and obstacle share, projected along the path.
const LINES: usize = 160;

/// Number of lines along that side for a coarse answer.
const FEW: usize = 32;

/// Stride of the lines that are tried first.
const COARSE: usize = 12;

/// Largest length of an obstacle ahead that counts as contact, mm.
const CONTACT_MM: f64 = 1e-5;

/// Largest distance that any point of a body moves between two sampled poses of a turn, mm.
const STEP_MM: f64 = 0.25;

/// Number of lines per direction that look for an overlap at such a pose.
const TURN_LINES: usize = 400;

/// Largest thickness of an overlap at such a pose that is ignored, mm; it can be due to the sampling.
const TURN_CONTACT_MM: f64 = 0.02;

/// Point at which a path is blocked.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contact {
    /// Position in the assembly's frame, mm.
    pub(crate) place: Point3<f64>,
    /// Width of the part of the obstacle in the way, measured across the path; for turns, the depth of the overlap, mm.
    pub(crate) depth_mm: f64,
}

/// Lines along a straight path that may meet both bodies.
struct Lines {
    direction: Vector3<f64>,
    across: [Vector3<f64>; 2],
    from: [f64; 2],
    sides: [f64; 2],
    cell_mm: f64,
    size: [usize; 2],
    shadow: Option<ProjectionRaster>,
}

impl Lines {
    /// Creates the lines; `None` if the bounding boxes show that nothing is in the way.
    fn between(
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
        // Distance from the mover's rear to the far end of the obstacle.
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

    /// Drops lines that provably meet nothing; `None` if that holds for all of them.
    fn without_clear_lines(self, mover: &CompiledSolid, other: &CompiledSolid) -> Option<Self> {
        let boxes = find_obstacle_boxes(mover, &[other], &self.direction);
        if boxes.as_ref().is_some_and(Vec::is_empty) {
            return None;
        }
        let [u, v] = self.across;
        let middle = [0, 1].map(|k| self.from[k] + 0.5 * self.sides[k]);
        let centre = Point3::from(middle[0] * u + middle[1] * v);
        let half = self.sides.map(|side| 0.5 * side);
        let shadow =
            boxes.map(|boxes| ProjectionRaster::from_boxes(&boxes, &centre, &self.across, half));
        Some(Self { shadow, ..self })
    }

    /// Returns whether any of every `stride`-th line in both directions is blocked.
    fn is_any_blocked(&self, mover: &CompiledSolid, other: &CompiledSolid, stride: usize) -> bool {
        let row = |j: usize| {
            let mut casters = [Caster::default(), Caster::default()];
            (stride / 2..self.size[0]).step_by(stride).any(|i| {
                self.ray(i, j).is_some_and(|ray| {
                    first_blocked_point(&ray, mover, other, &mut casters).is_some()
                })
            })
        };
        (stride / 2..self.size[1]).step_by(stride).any(row)
    }

    /// Returns the line through a cell; `None` if it is known to meet nothing.
    fn ray(&self, i: usize, j: usize) -> Option<Ray> {
        // An offset of an odd fraction of a cell keeps lines off walls at round coordinates.
        let [x, y] = [i, j].map(|k| (k as f64 + 0.482) * self.cell_mm);
        let side = |k: usize| self.size[k] as f64 * self.cell_mm;
        let is_open = self
            .shadow
            .as_ref()
            .is_none_or(|shadow| shadow.may_meet_box([x / side(0), y / side(1)]));
        let [u, v] = self.across;
        let origin = Point3::from((self.from[0] + x) * u + (self.from[1] + y) * v);
        is_open.then_some(Ray { origin, direction: self.direction })
    }

    /// Returns the point at which each line is blocked, row by row.
    fn blocked(&self, mover: &CompiledSolid, other: &CompiledSolid) -> Vec<Option<Point3<f64>>> {
        let row = |j: usize| {
            let mut casters = [Caster::default(), Caster::default()];
            (0..self.size[0])
                .map(|i| {
                    self.ray(i, j)
                        .and_then(|ray| first_blocked_point(&ray, mover, other, &mut casters))
                })
                .collect::<Vec<_>>()
        };
        (0..self.size[1]).into_par_iter().flat_map_iter(row).collect()
    }

    /// Finds the point where the obstacle is widest across the path.
    fn deepest(&self, mover: &CompiledSolid, other: &CompiledSolid) -> Option<Contact> {
        let blocked = self.blocked(mover, other);
        let deep = depths(&blocked, self.size);
        let (index, cells) = deep.into_iter().enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
        // In a blocked strip one cell wide, the only cell is one cell away from a free one: subtract half a cell on
        // either side.
        let depth_mm = (2.0 * cells - 1.0) * self.cell_mm;
        blocked[index].map(|place| Contact { place, depth_mm })
    }
}

/// Returns the point at which a line meets an obstacle ahead of the mover.
fn first_blocked_point(
    ray: &Ray,
    mover: &CompiledSolid,
    other: &CompiledSolid,
    [first, second]: &mut [Caster; 2],
) -> Option<Point3<f64>> {
    let [_, hindmost_mm] = *first.intervals(mover, ray).first()?;
    let ahead = second.intervals(other, ray).iter();
    let mut ahead = ahead.filter(|[from, to]| to - from.max(hindmost_mm) > CONTACT_MM);
    ahead.next().map(|[from, _]| ray.at(from.max(hindmost_mm)))
}

/// Returns whether any part of `other` lies ahead of the mover on a straight path to infinity.
pub(crate) fn is_blocked(
    mover: &CompiledSolid,
    other: &CompiledSolid,
    direction: &Vector3<f64>,
) -> bool {
    let Some(lines) = Lines::between(mover, other, direction, LINES) else { return false };
    // A few lines find most blocked paths, and a proof with boxes most free ones.
    lines.is_any_blocked(mover, other, COARSE)
        || lines
            .without_clear_lines(mover, other)
            .is_some_and(|lines| lines.is_any_blocked(mover, other, 1))
}

/// Finds the point and depth of the obstacle on a straight path; `None` if it is not deeper than `allowed_mm`. The
/// depth is the width of the obstacle across the path, known to one cell of the grid of [`LINES`] lines.
pub(crate) fn contact(
    mover: &CompiledSolid,
    other: &CompiledSolid,
    direction: &Vector3<f64>,
    allowed_mm: f64,
) -> Option<Contact> {
    let lines =
        Lines::between(mover, other, direction, LINES)?.without_clear_lines(mover, other)?;
    let contact = lines.deepest(mover, other)?;
    let is_meant = allowed_mm > 0.0 && contact.depth_mm <= allowed_mm + lines.cell_mm;
    (!is_meant).then_some(contact)
}

/// Returns whether [`contact`] finds an obstacle that is deeper than allowed. A few lines decide clear cases.
pub(crate) fn is_too_deep(
    mover: &CompiledSolid,
    other: &CompiledSolid,
    direction: &Vector3<f64>,
    allowed_mm: f64,
) -> bool {
    let Some(few) = Lines::between(mover, other, direction, FEW) else { return false };
    let deepest = few.deepest(mover, other);
    deepest.is_some_and(|contact| contact.depth_mm > allowed_mm + 3.0 * few.cell_mm)
        || contact(mover, other, direction, allowed_mm).is_some()
}

/// Computes the distance of each blocked cell from the nearest free one, in cells, with steps of 1 and sqrt(2)
/// (Borgefors, "Distance transformations in digital images", 1986); at most 8 % too long.
fn depths(blocked: &[Option<Point3<f64>>], [width, height]: [usize; 2]) -> Vec<f64> {
    // Two-pass chamfer distance transform.
    let mut far: Vec<f64> =
        blocked.iter().map(|met| if met.is_some() { f64::INFINITY } else { 0.0 }).collect();
    let near = |far: &[f64], i: usize, j: usize, [di, dj]: [isize; 2]| {
        // Cells beyond the grid are free.
        let at = |k: usize, d: isize, n: usize| k.checked_add_signed(d).filter(|&k| k < n);
        let of = at(i, di, width).zip(at(j, dj, height)).map_or(0.0, |(i, j)| far[j * width + i]);
        of + (di as f64).hypot(dj as f64)
    };
    // Neighbours that a forward pass has visited; the backward pass uses their opposites.
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

/// Returns the overlap of two bodies at their poses if it is deeper than allowed and than the sampling of a turn can
/// resolve.
pub(crate) fn overlap(a: &CompiledSolid, b: &CompiledSolid, allowed_mm: f64) -> Option<Contact> {
    let boxes = find_overlap_boxes(a, b)?;
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
            let in_a = in_a.intervals(a, &ray);
            let in_b = if in_a.is_empty() { &[] } else { in_b.intervals(b, &ray) };
            let common = |x: &[f64; 2], y: &[f64; 2]| x[1].min(y[1]) - x[0].max(y[0]);
            in_b.iter().any(|y| in_a.iter().any(|x| common(x, y) > TURN_CONTACT_MM))
        })
    });
    if !is_met {
        return None;
    }
    // A rough test with few lines came first, since measuring the depth is slow.
    let limit_mm = allowed_mm + TURN_CONTACT_MM;
    deepest(a, b, limit_mm)
        .filter(|(depth_mm, _)| *depth_mm > limit_mm)
        .map(|(depth_mm, place)| Contact { place, depth_mm })
}

/// Follows a stated motion backwards from its end. Returns the first contact with another body, and the index of that
/// body.
pub(crate) fn follow<'a>(
    motion: &Motion,
    movers: &[&Placed<'a>],
    others: &[&Placed<'a>],
    allowed_mm: &dyn Fn(&Placed, &Placed) -> f64,
) -> Option<(Contact, usize)> {
    // Transform of the movers from their final pose.
    let mut moved = Pose::identity();
    for leg in motion.legs.iter().rev() {
        let steps = steps(leg, movers);
        for _ in 0..steps {
            // Motions are stated forwards, so they are followed from their end.
            moved = back(leg, steps).then_in(moved);
            if let Some(met) = met_at(&moved, movers, others, allowed_mm) {
                return Some(met);
            }
        }
        // A leg without a length comes from infinity; no leg can precede it.
        if let MotionLeg::Straight { along, length_mm: None } = leg {
            return met_outwards(&moved, -along, movers, others, allowed_mm);
        }
    }
    None
}

/// Returns the number of steps in which a leg is sampled, from the longest way of any corner of the movers' bounding
/// boxes.
fn steps(leg: &MotionLeg, movers: &[&Placed]) -> usize {
    let way_mm = match leg {
        MotionLeg::Straight { length_mm, .. } => length_mm.unwrap_or(0.0),
        MotionLeg::Turn { point, axis, angle, rise_mm } => {
            let corners = movers.iter().flat_map(|mover| corners(&mover.body.bounds()));
            let radius_mm = corners.map(|corner| (corner - point).cross(axis).norm());
            (radius_mm.fold(0.0, f64::max) * angle.rad()).hypot(*rise_mm)
        }
    };
    (way_mm / STEP_MM).ceil() as usize
}

/// Returns the transform of one of `steps` equal steps backwards along a leg.
fn back(leg: &MotionLeg, steps: usize) -> Pose {
    let share = -1.0 / steps as f64;
    match leg {
        MotionLeg::Straight { along, length_mm } => {
            let by = share * length_mm.unwrap_or(0.0) * along;
            Pose::translation(by.x, by.y, by.z)
        }
        MotionLeg::Turn { point, axis, angle, rise_mm } => {
            // Turn about z in a frame on the axis.
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

/// Compiles a body that has been moved away from its place. `None` only in theory: a solid that has been placed once
/// can be placed again.
fn moved_body(moved: &Pose, mover: &Placed) -> Option<CompiledSolid> {
    CompiledSolid::new(&mover.of.solid.clone().placed(moved.then_in(mover.pose))).ok()
}

/// Finds the first overlap of the moved bodies with the others.
fn met_at(
    moved: &Pose,
    movers: &[&Placed],
    others: &[&Placed],
    allowed_mm: &dyn Fn(&Placed, &Placed) -> f64,
) -> Option<(Contact, usize)> {
    movers.iter().find_map(|mover| {
        let body = moved_body(moved, mover)?;
        others.iter().enumerate().find_map(|(index, other)| {
            overlap(&body, &other.body, allowed_mm(mover, other)).map(|contact| (contact, index))
        })
    })
}

/// Finds the first obstacle on the straight way out of the moved bodies.
fn met_outwards(
    moved: &Pose,
    direction: Vector3<f64>,
    movers: &[&Placed],
    others: &[&Placed],
    allowed_mm: &dyn Fn(&Placed, &Placed) -> f64,
) -> Option<(Contact, usize)> {
    movers.iter().find_map(|mover| {
        let body = moved_body(moved, mover)?;
        others.iter().enumerate().find_map(|(index, other)| {
            let allowed_mm = allowed_mm(mover, other);
            contact(&body, &other.body, &direction, allowed_mm).map(|contact| (contact, index))
        })
    })
}
