//! Where bodies of one assembly face each other closely, how much of it, and which way.
//!
//! Lines of three directions at right angles pass the box that two bodies share. A face of area dA with the
//! normal n is met by lines along d over |n d| dA; counted once more by |n d|, the three directions together
//! give dA whatever n is.

use fabkit_geometry::{Aabb, Crossing, Ray, Vector3};

use crate::lines::{Bundle, Caster, DIRECTIONS, Stretch, basis, steepness};
use crate::scene::Placed;

/// Bodies that fit with so much play still stop each other, mm.
pub(crate) const PLAY_MM: f64 = 0.5;

/// Press fits overlap by at most that much, mm.
const OVERLAP_MM: f64 = 1.0;

/// Faces that look at each other: cosine between one normal and the other, at most.
const FACING: f64 = -0.5;

/// A face stops a motion that meets it less askew than that (cosine; 10 degrees off its plane).
const STOPS: f64 = 0.17;

/// Fewest and most lines of each direction through what two bodies share.
const LINES: (usize, usize) = (96, 800);

/// The six ways: +x, -x, +y, -y, +z, -z.
pub(crate) const WAYS: usize = 6;

/// What the ways are called.
pub(crate) const WAY_WORDS: [&str; WAYS] = ["+x", "-x", "+y", "-y", "+z", "-z"];

/// The other way along the same axis.
pub(crate) fn opposite(way: usize) -> usize {
    way ^ 1
}

/// How far a normal points along a way.
fn along(normal: &Vector3<f64>, way: usize) -> f64 {
    let part = normal[way / 2];
    if way.is_multiple_of(2) { part } else { -part }
}

/// The faces that one body turns to another one.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Faces {
    /// What of the other stands in the way of the first, seen along each way, mm2.
    pub(crate) ahead_mm2: [f64; WAYS],
    /// Of what sticks: all of it, mm2.
    pub(crate) bonded_mm2: f64,
    /// Of what sticks: area times the squared cosine, for normals along each way, mm2.
    pub(crate) across_mm2: [f64; WAYS],
    /// Of what sticks: area times the squared sine, for each axis, mm2.
    pub(crate) beside_mm2: [f64; 3],
}

impl Faces {
    /// The same, as the other body sees it.
    pub(crate) fn turned(&self) -> Self {
        let swapped = |of: &[f64; WAYS]| std::array::from_fn(|way| of[opposite(way)]);
        Self { ahead_mm2: swapped(&self.ahead_mm2), across_mm2: swapped(&self.across_mm2), ..*self }
    }

    /// Whether they are near each other at all.
    pub(crate) fn meet(&self) -> bool {
        self.bonded_mm2 > 0.0 || self.ahead_mm2.iter().any(|area| *area > 0.0)
    }

    fn add(&mut self, normal: &Vector3<f64>, area_mm2: f64, sticks: bool) {
        for way in 0..WAYS {
            let part = along(normal, way);
            if part > STOPS {
                self.ahead_mm2[way] += area_mm2 * part;
            }
            if part > 0.0 && sticks {
                self.across_mm2[way] += area_mm2 * part * part;
            }
        }
        if sticks {
            self.bonded_mm2 += area_mm2;
            for axis in 0..3 {
                self.beside_mm2[axis] += area_mm2 * (1.0 - normal[axis].powi(2));
            }
        }
    }
}

/// The box in which two bodies can face each other; `None` if they are too far apart.
fn shared(a: &Placed, b: &Placed) -> Option<Aabb> {
    let common = a.body.bounds().grown(PLAY_MM).common(&b.body.bounds().grown(PLAY_MM));
    (!common.is_empty() && common.is_finite()).then_some(common)
}

/// So many lines that each stands for about a square millimetre, or for a few of what is large.
fn lines(shared: &Aabb) -> usize {
    let [x, y, z] = shared.size_mm();
    ((x * y + y * z + z * x) as usize).clamp(LINES.0, LINES.1)
}

/// What `a` turns to `b`; `reach_mm` is how far what sticks them together reaches, if anything does.
pub(crate) fn faces([a, b]: [&Placed; 2], reach_mm: Option<f64>) -> Option<Faces> {
    let common = shared(a, b)?;
    let lines = lines(&common);
    let first = Vector3::from(DIRECTIONS[0]).normalize();
    let [second, third] = basis(&first);
    let (mut faces, mut casters) = (Faces::default(), [Caster::default(), Caster::default()]);
    for direction in [first, second, third] {
        let bundle = Bundle::through(&common, direction, lines);
        for ray in (0..lines).map(|index| bundle.line(index)) {
            let [of_a, of_b] = &mut casters;
            let of_a: Vec<Stretch> = of_a.stretches(&a.body, &ray).collect();
            if of_a.is_empty() {
                continue;
            }
            let of_b: Vec<Stretch> = of_b.stretches(&b.body, &ray).collect();
            for stretch in &of_a {
                let nexts = of_b.iter().map(|other| (stretch.exit, other.enter, 1.0));
                let lasts = of_b.iter().map(|other| (stretch.enter, other.exit, -1.0));
                for (own, other, sign) in nexts.chain(lasts) {
                    let Some(gap_mm) = gap_mm(&ray, &own, &other, sign) else { continue };
                    let area_mm2 = bundle.cell_mm2() * steepness(&ray, &own);
                    let sticks = reach_mm.is_some_and(|reach| gap_mm.abs() <= reach);
                    faces.add(&own.normal, area_mm2, sticks);
                }
            }
        }
    }
    Some(faces)
}

/// How far two faces that look at each other are apart across them; `None` if they do not, or too far.
fn gap_mm(ray: &Ray, own: &Crossing, other: &Crossing, sign: f64) -> Option<f64> {
    if own.normal.dot(&other.normal) > FACING {
        return None;
    }
    let gap_mm = sign * (other.t - own.t) * steepness(ray, own);
    (-OVERLAP_MM..=PLAY_MM).contains(&gap_mm).then_some(gap_mm)
}
