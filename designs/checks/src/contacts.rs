//! Contacts: areas on which bodies of one assembly closely face each other, and their directions.
//!
//! Lines along three orthogonal directions cross the box that two bodies share. Lines along d meet a face of area dA
//! and normal n on an area of |n d| dA. Weighted once more by |n d|, the three directions together give dA for any n.

use fabkit_geometry::{Aabb, Crossing, Ray, Vector3};

use crate::sampling_lines::{Bundle, Caster, DIRECTIONS, Stretch, basis, steepness};
use crate::scene::Placed;

/// Largest gap across which bodies still stop each other, mm.
pub(crate) const PLAY_MM: f64 = 0.5;

/// Largest overlap of press fits, mm.
const OVERLAP_MM: f64 = 1.0;

/// Largest cosine between the normals of two faces that face each other.
const FACING: f64 = -0.5;

/// Smallest cosine between a face's normal and a direction for which the face stops motion along it: faces within 10
/// degrees of parallel to the motion let it pass.
const STOPS: f64 = 0.17;

/// Smallest and largest number of lines in each direction through the box that two bodies share.
const LINES: (usize, usize) = (96, 800);

/// Number of directions of motion: +x, -x, +y, -y, +z, -z.
pub(crate) const MOTION_DIRECTIONS: usize = 6;

/// Names of the directions.
pub(crate) const MOTION_DIRECTION_WORDS: [&str; MOTION_DIRECTIONS] =
    ["+x", "-x", "+y", "-y", "+z", "-z"];

/// Returns the opposite direction along the same axis.
pub(crate) fn opposite(way: usize) -> usize {
    way ^ 1
}

/// Computes the component of a normal along a direction.
fn along(normal: &Vector3<f64>, way: usize) -> f64 {
    // Directions come in pairs of an axis and its opposite.
    let part = normal[way / 2];
    if way.is_multiple_of(2) { part } else { -part }
}

/// Areas on which one body faces another one.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Faces {
    /// Area of faces that stop the first body when it moves along each direction, projected along the direction, mm2.
    pub(crate) ahead_mm2: [f64; MOTION_DIRECTIONS],
    /// Total area that sticks, mm2.
    pub(crate) bonded_mm2: f64,
    /// Area that sticks, times the squared cosine, over normals with a component along each direction, mm2. It carries
    /// tension.
    pub(crate) across_mm2: [f64; MOTION_DIRECTIONS],
    /// Area that sticks, times the squared sine of the angle between its normal and each axis, mm2. It carries shear.
    pub(crate) beside_mm2: [f64; 3],
}

impl Faces {
    /// Returns the same faces as seen from the other body.
    pub(crate) fn reversed(&self) -> Self {
        let swapped = |of: &[f64; MOTION_DIRECTIONS]| std::array::from_fn(|way| of[opposite(way)]);
        Self { ahead_mm2: swapped(&self.ahead_mm2), across_mm2: swapped(&self.across_mm2), ..*self }
    }

    /// Returns whether the bodies face each other at all.
    pub(crate) fn meet(&self) -> bool {
        self.bonded_mm2 > 0.0 || self.ahead_mm2.iter().any(|area| *area > 0.0)
    }

    fn add(&mut self, normal: &Vector3<f64>, area_mm2: f64, sticks: bool) {
        for way in 0..MOTION_DIRECTIONS {
            let part = along(normal, way);
            if part > STOPS {
                // Projected along the direction of motion.
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

/// Returns the box in which two bodies can face each other; `None` if they are too far apart.
fn shared(a: &Placed, b: &Placed) -> Option<Aabb> {
    // Grown boxes also meet if the bodies have play.
    let common = a.body.bounds().grown(PLAY_MM).common(&b.body.bounds().grown(PLAY_MM));
    (!common.is_empty() && common.is_finite()).then_some(common)
}

/// Returns the number of lines per direction: about one for each square millimetre of the box's three projections,
/// within the limits [`LINES`].
fn lines(shared: &Aabb) -> usize {
    let [x, y, z] = shared.size_mm();
    ((x * y + y * z + z * x) as usize).clamp(LINES.0, LINES.1)
}

/// Computes the areas on which `a` faces `b`. `reach_mm` is the largest gap that their bond fills, if they are bonded.
/// `None` if they are too far apart.
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
                // Faces that follow the exit from `a`, and faces that precede the entry into `a`.
                let nexts = of_b.iter().map(|other| (stretch.exit, other.enter, 1.0));
                let lasts = of_b.iter().map(|other| (stretch.enter, other.exit, -1.0));
                for (own, other, sign) in nexts.chain(lasts) {
                    let Some(gap_mm) = gap_mm(&ray, &own, &other, sign) else { continue };
                    // Divided by |n d| for the area of the face, times |n d|^2 for the weight of this direction.
                    let area_mm2 = bundle.cell_mm2() * steepness(&ray, &own);
                    let sticks = reach_mm.is_some_and(|reach| gap_mm.abs() <= reach);
                    faces.add(&own.normal, area_mm2, sticks);
                }
            }
        }
    }
    Some(faces)
}

/// Computes the gap between two faces, measured across them; `None` if they do not face each other or the gap is out of
/// range.
fn gap_mm(ray: &Ray, own: &Crossing, other: &Crossing, sign: f64) -> Option<f64> {
    if own.normal.dot(&other.normal) > FACING {
        return None;
    }
    let gap_mm = sign * (other.t - own.t) * steepness(ray, own);
    (-OVERLAP_MM..=PLAY_MM).contains(&gap_mm).then_some(gap_mm)
}
