//! Assignment of the spots in an image to markers.
//!
//! A regular pattern looks the same when shifted by one pitch. The nearest marker is therefore wrong as soon as all
//! move by more than half a pitch, and beside a press sooner. Markers are told apart by the fact that neighbours move
//! alike. The search starts where the neighbours of a marker fit best, and grows to each next marker at the place that
//! its assigned neighbours predict, the best fit first. It is repeated from several candidates for the shift of the
//! whole pattern. The start that assigns most markers wins, and markers on which equally good starts disagree stay
//! unassigned.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Maximum number of neighbours of a marker.
const NEIGHBOURS: usize = 6;
/// Largest distance of neighbours, relative to the nearest one.
const NEIGHBOURS_REACH: f64 = 2.5;
/// Largest distance of a spot from the predicted place, relative to the distance to the nearest marker. Below one half,
/// the right spot is never nearer to the place of another marker.
const GATE: f64 = 0.42;
/// Largest displacement of markers, in the same unit.
pub(super) const REACH: f64 = 1.1;
/// Difference below which two shifts of the whole pattern count as the same.
const SAME_WAY: f64 = 0.35;
/// Difference below which a shift is not even evaluated.
const NEARLY_ALIKE: f64 = 0.15;
/// Number of shifts from which the search starts.
const MAX_SHIFTS: usize = 6;
/// Penalty on displacements: a pattern shifted by one pitch must find this much more of itself than an unshifted one.
const DISPLACEMENT_PENALTY: f64 = 0.1;
/// Relative difference of scores below which two starts are equally good.
const AS_GOOD: f64 = 0.02;
/// Maximum number of refinements, in which each marker is predicted by all its neighbours.
const ROUNDS: usize = 3;

pub(super) type Px = [f64; 2];

/// Markers at rest.
#[derive(Clone, Debug)]
pub(super) struct Pattern {
    at: Vec<Option<Px>>,
    /// Distance of each marker to the nearest other one, px.
    pitch_px: Vec<f64>,
    beside: Vec<Vec<usize>>,
}

pub(super) fn distance(a: &Px, b: &Px) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

pub(super) fn subtract(a: &Px, b: &Px) -> Px {
    [a[0] - b[0], a[1] - b[1]]
}

pub(super) fn add(a: &Px, b: &Px) -> Px {
    [a[0] + b[0], a[1] + b[1]]
}

/// Candidate for the next assignment; the smaller `misses`, the sooner.
struct Candidate {
    misses: f64,
    mark: usize,
    found: usize,
    /// Number of assigned neighbours when the candidate was made.
    known: usize,
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        // A heap pops its largest item, so the order is reversed. Indices break ties, which keeps the result
        // reproducible.
        let key = |next: &Self| (next.mark, next.found);
        other.misses.total_cmp(&self.misses).then_with(|| key(other).cmp(&key(self)))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate {}

/// Index of the assigned spot for each marker.
type Assignment = Vec<Option<usize>>;

impl Pattern {
    /// Creates the pattern from pixels of markers; `None` for markers that are not tracked. A marker without neighbours
    /// has the pitch `alone_px`.
    pub(super) fn new(at: Vec<Option<Px>>, alone_px: f64) -> Self {
        let others = |i: usize| {
            let Some(own) = &at[i] else { return Vec::new() };
            let known = at.iter().enumerate().filter(|(j, _)| *j != i);
            let mut others: Vec<(f64, usize)> =
                known.filter_map(|(j, other)| Some((distance(own, other.as_ref()?), j))).collect();
            others.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            others.truncate(NEIGHBOURS);
            others
        };
        let all: Vec<Vec<(f64, usize)>> = (0..at.len()).map(others).collect();
        let pitch_px: Vec<f64> =
            all.iter().map(|others| others.first().map_or(alone_px, |(px, _)| *px)).collect();
        let near = |(others, pitch_px): (&Vec<(f64, usize)>, &f64)| {
            let near = others.iter().filter(|(px, _)| *px < NEIGHBOURS_REACH * pitch_px);
            near.map(|(_, j)| *j).collect()
        };
        let mut beside: Vec<Vec<usize>> = all.iter().zip(&pitch_px).map(near).collect();
        // Neighbourhood is made symmetric.
        for i in 0..beside.len() {
            for j in beside[i].clone() {
                if !beside[j].contains(&i) {
                    beside[j].push(i);
                }
            }
        }
        Self { at, pitch_px, beside }
    }

    pub(super) fn at(&self) -> &[Option<Px>] {
        &self.at
    }

    /// Returns the neighbours of a marker.
    pub(super) fn neighbours(&self, mark: usize) -> &[usize] {
        &self.beside[mark]
    }

    pub(super) fn pitch_px(&self) -> &[f64] {
        &self.pitch_px
    }

    /// Assigns spots to markers; each spot goes to one marker at most.
    pub(super) fn assign(&self, found: &[Px]) -> Assignment {
        let near: Vec<Vec<usize>> = (0..self.at.len())
            .map(|i| {
                let Some(own) = &self.at[i] else { return Vec::new() };
                let reach_px = REACH * self.pitch_px[i];
                (0..found.len()).filter(|k| distance(&found[*k], own) < reach_px).collect()
            })
            .collect();
        let begin = |way: Px| {
            let chosen = self.refine(found, &near, self.grow(found, &near, way));
            (self.score(found, &chosen), chosen)
        };
        // If nearly all markers are near rest, no other start can be as good.
        let still = begin([0.0; 2]);
        if still.0 > (1.0 - AS_GOOD) * self.at.iter().flatten().count() as f64 {
            return still.1;
        }
        let mut begun = vec![still];
        begun.extend(self.candidate_shifts(found, &near).into_iter().map(begin));
        begun.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut begun = begun.into_iter();
        let Some((worth, mut best)) = begun.next() else { return Vec::new() };
        for (_, other) in begun.take_while(|(other, _)| *other > (1.0 - AS_GOOD) * worth) {
            for (own, other) in best.iter_mut().zip(&other) {
                *own = own.filter(|own| other.is_none_or(|other| other == *own));
            }
        }
        best
    }

    /// Returns candidates for the shift of the whole pattern, distinct from each other: shifts of single markers that
    /// bring most others to a spot.
    fn candidate_shifts(&self, found: &[Px], near: &[Vec<usize>]) -> Vec<Px> {
        let votes = |way: &Px| {
            let is_found = |i: &usize| {
                let expected = self.at[*i].map(|at| add(&at, way));
                let gate_px = 0.6 * GATE * self.pitch_px[*i];
                expected
                    .is_some_and(|at| near[*i].iter().any(|k| distance(&found[*k], &at) < gate_px))
            };
            (0..self.at.len()).filter(is_found).count()
        };
        // The zero shift is always a candidate. Of nearly equal shifts only one is evaluated.
        let smallest = self.pitch_px.iter().copied().fold(f64::INFINITY, f64::min);
        let mut apart: Vec<(Px, f64)> = vec![([0.0; 2], smallest)];
        for (i, near) in near.iter().enumerate() {
            for k in near {
                let Some(at) = &self.at[i] else { continue };
                let (way, pitch) = (subtract(&found[*k], at), self.pitch_px[i]);
                let is_new = |(other, own): &(Px, f64)| {
                    distance(other, &way) > NEARLY_ALIKE * own.min(pitch)
                };
                if apart.iter().all(is_new) {
                    apart.push((way, pitch));
                }
            }
        }
        let mut ways: Vec<(usize, Px, f64)> =
            apart.into_iter().map(|(way, pitch)| (votes(&way), way, pitch)).collect();
        ways.sort_by(|a, b| {
            let short = a.1[0].hypot(a.1[1]).total_cmp(&b.1[0].hypot(b.1[1]));
            b.0.cmp(&a.0).then(short)
        });
        let mut kept: Vec<(Px, f64)> = vec![([0.0; 2], smallest)];
        for (_, way, pitch) in ways {
            if kept.len() == MAX_SHIFTS {
                break;
            }
            if kept.iter().all(|(other, own)| distance(other, &way) > SAME_WAY * own.max(pitch)) {
                kept.push((way, pitch));
            }
        }
        kept.into_iter().skip(1).map(|(way, _)| way).collect()
    }

    /// Predicts the displacement of a marker as the mean of its assigned neighbours, weighted by inverse squared
    /// distance. Also returns their number.
    fn predict_displacement(
        &self,
        mark: usize,
        found: &[Px],
        chosen: &Assignment,
    ) -> Option<(Px, usize)> {
        let own = self.at[mark]?;
        let (mut sum, mut weights, mut known) = ([0.0; 2], 0.0, 0);
        for j in &self.beside[mark] {
            let (Some(at), Some(k)) = (&self.at[*j], chosen[*j]) else { continue };
            let weight = distance(&own, at).powi(-2);
            let moved = subtract(&found[k], at);
            sum = add(&sum, &[weight * moved[0], weight * moved[1]]);
            weights += weight;
            known += 1;
        }
        (known > 0).then(|| (sum.map(|part| part / weights), known))
    }

    /// Returns the distance of a spot from the predicted place of a marker, relative to its pitch.
    fn relative_miss(&self, mark: usize, way: &Px, place: &Px) -> f64 {
        self.at[mark]
            .map_or(f64::INFINITY, |at| distance(&add(&at, way), place) / self.pitch_px[mark])
    }

    /// Grows an assignment outwards from the best-fitting marker.
    fn grow(&self, found: &[Px], near: &[Vec<usize>], way: Px) -> Assignment {
        let count = self.at.len();
        let mut chosen: Assignment = vec![None; count];
        let mut taken = vec![false; found.len()];
        let mut open = BinaryHeap::new();
        // Before any assignment, a marker is predicted by the shift of the whole, and ranked by how well its neighbours
        // fit.
        for i in 0..count {
            for k in &near[i] {
                let Some(at) = &self.at[i] else { continue };
                let moved = subtract(&found[*k], at);
                let off = self.relative_miss(i, &way, &found[*k]);
                if off < GATE {
                    let fits = self.beside[i].iter().map(|j| {
                        let nearest =
                            near[*j].iter().map(|l| self.relative_miss(*j, &moved, &found[*l]));
                        nearest.fold(0.5, f64::min)
                    });
                    let (sum, many) = fits.fold((0.0, 0), |(sum, many), fit| (sum + fit, many + 1));
                    let fit = if many > 0 { sum / f64::from(many) } else { 0.0 };
                    // The added 1 ranks these candidates behind all that have assigned neighbours.
                    open.push(Candidate { misses: 1.0 + off + fit, mark: i, found: *k, known: 0 });
                }
            }
        }
        while let Some(Candidate { mark, found: place, known, .. }) = open.pop() {
            if chosen[mark].is_some() || taken[place] {
                continue;
            }
            let now = self.predict_displacement(mark, found, &chosen).map_or(0, |(_, known)| known);
            // The candidate is outdated: its neighbours have been assigned since, and have added a new one.
            if now != known {
                continue;
            }
            chosen[mark] = Some(place);
            taken[place] = true;
            for j in &self.beside[mark] {
                if chosen[*j].is_some() {
                    continue;
                }
                let Some((way, known)) = self.predict_displacement(*j, found, &chosen) else {
                    continue;
                };
                for k in &near[*j] {
                    let misses = self.relative_miss(*j, &way, &found[*k]);
                    if misses < GATE && !taken[*k] {
                        open.push(Candidate { misses, mark: *j, found: *k, known });
                    }
                }
            }
        }
        chosen
    }

    /// Refines an assignment: all markers are assigned anew, each predicted by its neighbours on all sides.
    fn refine(&self, found: &[Px], near: &[Vec<usize>], mut chosen: Assignment) -> Assignment {
        for _ in 0..ROUNDS {
            let mut pairs = Vec::new();
            for (i, near) in near.iter().enumerate() {
                let by_others = self.predict_displacement(i, found, &chosen);
                let Some((way, _)) = by_others else {
                    // A marker without assigned neighbours keeps its spot.
                    pairs.extend(chosen[i].map(|k| (GATE, i, k)));
                    continue;
                };
                let fits = near.iter().map(|k| (self.relative_miss(i, &way, &found[*k]), i, *k));
                pairs.extend(fits.filter(|(misses, ..)| *misses < GATE));
            }
            pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
            let mut next: Assignment = vec![None; self.at.len()];
            let mut taken = vec![false; found.len()];
            for (_, i, k) in pairs {
                if next[i].is_none() && !taken[k] {
                    next[i] = Some(k);
                    taken[k] = true;
                }
            }
            let is_same = next == chosen;
            chosen = next;
            if is_same {
                break;
            }
        }
        chosen
    }

    /// Returns the score of an assignment: the number of markers, less for uneven and large displacements.
    fn score(&self, found: &[Px], chosen: &Assignment) -> f64 {
        let own = |i: usize| {
            let (at, k) = (self.at[i]?, chosen[i]?);
            let moved = subtract(&found[k], &at);
            let misses = self
                .predict_displacement(i, found, chosen)
                .map_or(GATE, |(way, _)| self.relative_miss(i, &way, &found[k]));
            let far = moved[0].hypot(moved[1]) / self.pitch_px[i];
            Some(1.0 - (misses / GATE).powi(2) - DISPLACEMENT_PENALTY * far)
        };
        (0..self.at.len()).filter_map(own).sum()
    }
}

#[cfg(test)]
mod tests {
    use fabkit_geometry::sequences::SplitMix64;

    use super::*;

    /// A square lattice, or rings of which each has six marks more than the one within.
    fn pattern(is_square: bool, pitch_px: f64) -> Vec<Px> {
        if is_square {
            return (0..100).map(|i| [i % 10, i / 10].map(|k| pitch_px * f64::from(k))).collect();
        }
        let ring = |ring: i32| {
            let count = (6 * ring).max(1);
            (0..count).map(move |i| {
                let angle = std::f64::consts::TAU * f64::from(i) / f64::from(count);
                [angle.cos(), angle.sin()].map(|part| pitch_px * f64::from(ring) * part)
            })
        };
        (0..6).flat_map(ring).collect()
    }

    #[test]
    fn markers_are_never_swapped_after_random_presses() {
        let (mut seen, mut there) = (0, 0);
        for seed in 0..200 {
            let mut random = SplitMix64::new(seed);
            let pitch_px = random.between(4.0, 60.0);
            let at = pattern(seed % 2 == 0, pitch_px);
            let mut own = |most: f64| random.between(-most, most) * pitch_px;
            // All of it by half a pitch in some direction, and a press that moves what is around it by up to half a pitch more,
            // from one mark to the next by a quarter of a pitch at most: exp(-r^2 / 2 w^2) changes by 0.61 / w.
            let angle = own(std::f64::consts::PI) / pitch_px;
            let (far, bump) = (own(0.25).abs() * 2.0, own(0.5));
            let (middle, wide) = ([own(4.0), own(4.0)], 0.61 * bump.abs() / 0.25 + pitch_px);
            let moved: Vec<Px> = at
                .iter()
                .map(|px| {
                    let near = bump * (-0.5 * (distance(px, &middle) / wide).powi(2)).exp();
                    [angle.cos(), angle.sin()].map(|part| part * far + near)
                })
                .collect();
            let mut found = Vec::new();
            let mut whose = Vec::new();
            for (i, (px, by)) in at.iter().zip(&moved).enumerate() {
                // One of twenty is hidden, and each is found a bit beside where it is.
                if own(1.0).abs() > 0.05 * pitch_px {
                    found.push(add(&add(px, by), &[own(0.03), own(0.03)]));
                    whose.push(Some(i));
                }
            }
            there += found.len();
            for _ in 0..4 {
                found.push([own(6.0), own(6.0)]);
                whose.push(None);
            }
            let known = Pattern::new(at.iter().copied().map(Some).collect(), pitch_px);
            for (i, chosen) in known.assign(&found).into_iter().enumerate() {
                let Some(owner) = chosen.and_then(|k| whose[k]) else { continue };
                assert_eq!(
                    owner, i,
                    "seed {seed}: {far:.2} px and {bump:.2} px of {pitch_px:.2} px"
                );
                seen += 1;
            }
        }
        println!("{seen} of {there} markers are assigned");
        // A place that is none may lie where a hidden mark would be, or beside one.
        assert!(f64::from(seen) > 0.97 * there as f64, "{seen} of {there}");
    }

    #[test]
    fn no_spots_give_no_assignment() {
        let known = Pattern::new(vec![Some([5.0, 5.0]), None, Some([25.0, 5.0])], 10.0);
        assert_eq!(known.assign(&[]), [None; 3]);
        assert_eq!(known.assign(&[[25.5, 6.0]]), [None, None, Some(0)]);
        let alone = Pattern::new(vec![Some([5.0, 5.0])], 10.0);
        assert_eq!(alone.assign(&[[6.0, 5.0], [40.0, 40.0]]), [Some(0)]);
    }
}
