//! Listed markers: dots, dimples, pins, whatever a camera tracks.
//!
//! Two lists of a family's section hold their coordinates, one item of each for every marker. The order is that of the
//! lists, everywhere: `dimple 7` is the seventh in molds, landmarks and trees.

use std::f64::consts::FRAC_PI_2;

use fabkit_geometry::{Angle, EllipsoidOffset, Length, Point3, Pose};

use crate::choices;
use crate::parameters::{LimitedQuantity, RuleReport};

choices! {
    /// Pattern of markers on a flat face.
    pub enum FlatPattern {
        /// Grid around the middle.
        Grid = "grid",
        /// List of positions.
        List = "list",
    }
}

choices! {
    /// Pattern of markers on a round surface.
    pub enum RoundPattern {
        /// Rings around the tip.
        Rings = "rings",
        /// List of positions.
        List = "list",
    }
}

/// Number of bisection steps, enough to exhaust the digits of an angle.
const HALVINGS: u32 = 60;

/// Markers as a section lists them.
#[derive(Clone, Copy, Debug)]
pub struct ListedMarkers<'a, Q> {
    /// Word for one marker; its number follows it.
    word: &'static str,
    /// Path and items of both lists.
    lists: [(&'static str, &'a [Q]); 2],
}

impl<'a, Q: LimitedQuantity> ListedMarkers<'a, Q> {
    /// Creates the view of two lists, of markers that are called `word`.
    pub fn new(
        word: &'static str,
        first: (&'static str, &'a [Q]),
        second: (&'static str, &'a [Q]),
    ) -> Self {
        Self { word, lists: [first, second] }
    }

    /// Returns both coordinates of each marker, up to the end of the shorter list.
    pub fn places(&self) -> impl Iterator<Item = [Q; 2]> + use<'a, Q> {
        let [(_, first), (_, second)] = self.lists;
        first.iter().zip(second).map(|(a, b)| [*a, *b])
    }

    /// Reports lists of different length.
    pub fn check_lengths(&self, report: &mut RuleReport) {
        let [(first, a), (second, b)] = self.lists;
        let (path, longer) = if a.len() >= b.len() { (first, a.len()) } else { (second, b.len()) };
        let word = self.word;
        report.require(
            a.len() == b.len(),
            path,
            || {
                let (a, b) = (a.len(), b.len());
                format!("{first} has {a} items and {second} has {b}; each {word} has both")
            },
            || format!("write {longer} items in each, or as few as the shorter list has"),
        );
    }

    /// Reports every item of the list `which` whose magnitude exceeds `most`, in the unit that people write; if `most`
    /// is negative, no value works. `because` completes "it must be at most 20 mm, because ...".
    pub fn check_within(
        &self,
        which: usize,
        most: f64,
        (because, or): (&str, &str),
        report: &mut RuleReport,
    ) {
        let (path, items) = self.lists[which];
        // Rounded towards zero, so that the suggested value is allowed.
        let works = ((most + 1e-9) * Q::STEPS_PER_UNIT).floor() / Q::STEPS_PER_UNIT;
        let is_far = |item: &Q| item.value().abs() > most + 1e-9;
        for (i, item) in items.iter().enumerate().filter(|(_, item)| is_far(item)) {
            let (number, word, unit) = (i + 1, self.word, Q::UNIT);
            let limit = match item.value() < 0.0 {
                _ if most < 0.0 => None,
                true => Some(format!("at least {}{unit}", 0.0 - works)),
                false => Some(format!("at most {works}{unit}")),
            };
            let must = match &limit {
                Some(limit) => format!("it must be {limit}"),
                None => "no value works".into(),
            };
            report.require(
                false,
                &format!("{path}[{i}]"),
                || format!("{path}[{i}] ({word} {number}) is {item}; {must}, because {because}"),
                || match &limit {
                    Some(limit) => format!("write {limit}, or change {or}"),
                    None => format!("change {or}"),
                },
            );
        }
    }

    /// Reports every marker that is closer than `least_mm` to one that is listed before it; `points` are the points
    /// where markers come closest to each other.
    pub fn check_apart(
        &self,
        points: &[Point3<f64>],
        least_mm: f64,
        (because, or): (&str, &str),
        report: &mut RuleReport,
    ) {
        let (path, word) = (self.lists[0].0, self.word);
        for (j, i, mm) in find_near_pairs(points, least_mm - 1e-9) {
            report.require(
                false,
                &format!("{path}[{j}]"),
                || {
                    format!(
                        "{word}s {} and {} ({path}[{i}] and {path}[{j}]) are {mm:.3} mm apart, from axis \
                         to axis where they are nearest; it must be at least {least_mm:.3} mm, because \
                         {because}",
                        i + 1,
                        j + 1
                    )
                },
                || format!("move one of them, or change {or}"),
            );
        }
    }
}

impl ListedMarkers<'_, Angle> {
    /// Returns the poses of the markers on a surface of revolution around z, z axis along the outward normal. The first
    /// coordinate is the angle between the normal and z, the second turns around z from x.
    pub fn poses(&self, surface: &EllipsoidOffset) -> Vec<Pose> {
        let pose = |[polar, azimuth]: [Angle; 2]| {
            let [radius_mm, z_mm] = surface.meridian_point(polar);
            Pose::rotation_z(azimuth)
                .then_in(Pose::translation(radius_mm, 0.0, z_mm))
                .then_in(Pose::rotation_y(polar))
        };
        self.places().map(pose).collect()
    }

    /// Returns the largest of the first coordinates, rad.
    pub fn outermost_rad(&self) -> f64 {
        self.places().map(|[polar, _]| polar.rad()).fold(0.0, f64::max)
    }
}

impl ListedMarkers<'_, Length> {
    /// Returns the positions on a plane, mm.
    pub fn points_mm(&self) -> Vec<[f64; 2]> {
        self.places().map(|place| place.map(Length::mm)).collect()
    }

    /// Calls [`ListedMarkers::check_apart`] for markers on a plane.
    pub fn check_apart_on_plane(&self, least_mm: f64, told: (&str, &str), report: &mut RuleReport) {
        let points = self.points_mm().into_iter().map(|[x, y]| Point3::new(x, y, 0.0));
        self.check_apart(&points.collect::<Vec<_>>(), least_mm, told, report);
    }
}

/// Finds the largest angle up to 90 degrees up to which `holds` is true, in degrees, by bisection; negative infinity if
/// it is false even at 0.
pub fn max_angle_deg(holds: impl Fn(Angle) -> bool) -> f64 {
    let at = |rad: f64| Angle::from_rad(rad).is_some_and(&holds);
    if !at(0.0) {
        return f64::NEG_INFINITY;
    }
    if at(FRAC_PI_2) {
        return 90.0;
    }
    let (mut low, mut high) = (0.0, FRAC_PI_2);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if at(middle) { low = middle } else { high = middle }
    }
    low.to_degrees()
}

/// Returns the smallest distance between two points, mm; `None` for fewer than two points.
pub fn nearest_mm(points: &[Point3<f64>]) -> Option<f64> {
    let mut least = f64::INFINITY;
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x));
    for (i, a) in sorted.iter().enumerate() {
        // Sorted by x: later points are farther away than the smallest distance so far.
        for b in &sorted[i + 1..] {
            if b.x - a.x >= least {
                break;
            }
            least = least.min((a - b).norm());
        }
    }
    least.is_finite().then_some(least)
}

/// Finds, for each point, the nearest earlier point that is closer than `least_mm`. Returns (index, index of the
/// earlier point, distance in mm), in the order of the points.
fn find_near_pairs(points: &[Point3<f64>], least_mm: f64) -> Vec<(usize, usize, f64)> {
    let mut sorted: Vec<usize> = (0..points.len()).collect();
    sorted.sort_by(|&i, &j| points[i].x.total_cmp(&points[j].x));
    let mut found: Vec<Option<(usize, f64)>> = vec![None; points.len()];
    for (k, &a) in sorted.iter().enumerate() {
        let beside = |b: &&usize| points[**b].x - points[a].x < least_mm;
        for &b in sorted[k + 1..].iter().take_while(beside) {
            let mm = (points[a] - points[b]).norm();
            let (before, after) = (a.min(b), a.max(b));
            // Ties go to the earlier marker, so that the result does not depend on the order of the sort.
            let is_nearer = found[after].is_none_or(|(i, least)| (mm, before) < (least, i));
            if mm < least_mm && is_nearer {
                found[after] = Some((before, mm));
            }
        }
    }
    let pair = |(j, near): (usize, &Option<(usize, f64)>)| near.map(|(i, mm)| (j, i, mm));
    found.iter().enumerate().filter_map(pair).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_pairs_match_brute_force() {
        // Points of a low-discrepancy sequence: three irrational steps.
        let at = |i: u32, step: f64| 10.0 * (f64::from(i) * step).fract();
        let points: Vec<Point3<f64>> = (1..200)
            .map(|i| Point3::new(at(i, 0.819_17), at(i, 0.671_04), at(i, 0.549_7)))
            .collect();
        let distance = |i: usize, j: usize| (points[i] - points[j]).norm();
        let before = |j: usize| (0..j).min_by(|&a, &b| distance(a, j).total_cmp(&distance(b, j)));
        let all: Vec<(usize, usize, f64)> = (0..points.len())
            .filter_map(|j| before(j).map(|i| (j, i, distance(i, j))))
            .filter(|(.., mm)| *mm < 1.6)
            .collect();
        assert!(all.len() > 10);
        assert_eq!(find_near_pairs(&points, 1.6), all);
        let least = all.iter().map(|(.., mm)| *mm).fold(f64::INFINITY, f64::min);
        assert_eq!(nearest_mm(&points), Some(least));
        assert_eq!(nearest_mm(&points[..1]), None);
    }

    #[test]
    fn the_farthest_angle_is_where_a_height_ends() {
        // 10 cos 60 deg is 5.
        assert!((max_angle_deg(|polar| 10.0 * polar.rad().cos() >= 5.0) - 60.0).abs() < 1e-9);
        assert_eq!(max_angle_deg(|_| true), 90.0);
        assert!(max_angle_deg(|_| false) < 0.0);
    }
}
