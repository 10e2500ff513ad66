//! Order in which the pieces of a step can reach their places, found by taking them apart.
//!
//! The piece that can leave first can come last (Wilson and Latombe, "Geometric reasoning about mechanical assembly",
//! Artificial Intelligence 71, 1994). Pieces leave one after the other, each straight out or along the motion that the
//! step states, with room for its tool. If none can leave alone, pieces that hold each other leave together and are
//! taken apart outside.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::f64::consts::TAU;

use fabkit_geometry::{Aabb, Motion, Occasion, Sensor, Vector3};

use super::arrival::Arrival;
use super::obstruction::Obstruction;
use super::path::{contact, follow, is_blocked, is_too_deep};
use super::tools;
use crate::memo::{Key, Memo};
use crate::rule::Rule;
use crate::scene::Placed;

/// Number of directions across z that are tried if no axis is free.
const AZIMUTHS: u32 = 24;

/// Size below which components of a direction are rounding errors.
const ROUNDING: f64 = 1e-12;

/// Bodies that move as one.
pub(crate) type Piece<'a> = Vec<&'a Placed<'a>>;

/// Function that returns the directions in which a piece may leave.
type DirectionSource = fn(&Piece) -> Vec<Vector3<f64>>;

/// Search that takes apart the pieces that a step brings.
pub(crate) struct Disassembly<'a> {
    /// Sensor, for its press fits.
    sensor: &'a Sensor,
    /// Motions that the step states.
    motions: &'a [Motion],
    /// Pieces as the step brings them.
    coming: Vec<Piece<'a>>,
    memo: &'a Memo,
    /// Cached answers of [`Self::blocks`] for mover, obstacle and direction.
    known: HashMap<(u128, u128, [u64; 3]), bool>,
    /// Key of the obstacle that last blocked a piece in a direction; it is tried first.
    witness: HashMap<(u128, [u64; 3]), u128>,
    /// Cache of places in which a tool has no room.
    blocked: tools::Blocked,
    pub(crate) stuck: Vec<Obstruction<'a>>,
    /// Pieces that have left, in the order of leaving.
    pub(crate) left: Vec<RemovedPiece<'a>>,
}

/// A piece that has left.
pub(crate) struct RemovedPiece<'a> {
    pub(crate) piece: Piece<'a>,
    /// Direction of a straight path; `None` for a stated motion.
    pub(crate) way: Option<Vector3<f64>>,
    /// Pieces into which it was taken apart outside.
    pub(crate) apart: Vec<RemovedPiece<'a>>,
}

/// Returns whether a tool drives the body in, as a screw or a nut.
fn is_drawn(placed: &Placed) -> bool {
    placed.is_drawn()
}

/// Returns the bits of a direction, for use as a key.
fn bits(direction: &Vector3<f64>) -> [u64; 3] {
    [0, 1, 2].map(|axis| direction[axis].to_bits())
}

/// Sets components that are rounding errors to zero, so that directions along an axis are exactly so.
fn cleaned(direction: Vector3<f64>) -> Vector3<f64> {
    direction.map(|v| if v.abs() < ROUNDING { 0.0 } else { v }).normalize()
}

/// Returns the axes along which a piece may leave. A screw leaves along its own axis only.
fn ways_out(piece: &Piece) -> Vec<Vector3<f64>> {
    // The z axis of each body.
    let own: Vec<Vector3<f64>> =
        piece.iter().map(|placed| cleaned(placed.pose.vector(Vector3::z()))).collect();
    if let Some(i) = piece.iter().position(|placed| is_drawn(placed))
        && piece.len() == 1
    {
        return vec![own[i]];
    }
    let mut ways = vec![Vector3::z(), -Vector3::z()];
    ways.extend(own.first().into_iter().flat_map(|own| [*own, -own]));
    ways.extend([Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::y()]);
    let mut seen = BTreeSet::new();
    // Adding 0.0 turns -0.0 into 0.0, so that equal directions have equal bits.
    ways.retain(|way| seen.insert(bits(&way.map(|v| v + 0.0))));
    ways
}

/// Returns the vector from the centre of the other bodies to that of a piece: outer pieces tend to leave outwards.
fn outwards(piece: &Piece, others: &[&Placed]) -> Vector3<f64> {
    let middle = |of: &[&Placed]| {
        let hull = of.iter().fold(Aabb::nothing(), |sum, placed| sum.hull(&placed.body.bounds()));
        hull.centre()
    };
    if others.is_empty() { Vector3::z() } else { middle(piece) - middle(others) }
}

/// Returns directions across z, evenly spread.
fn azimuths() -> Vec<Vector3<f64>> {
    let azimuth = |i: u32| {
        let (sin, cos) = (TAU * (f64::from(i) + 0.5) / f64::from(AZIMUTHS)).sin_cos();
        Vector3::new(cos, sin, 0.0)
    };
    (0..AZIMUTHS).map(azimuth).collect()
}

impl<'a> Disassembly<'a> {
    /// Searches the order in which the pieces of an arrival can be taken out.
    pub(crate) fn find(sensor: &'a Sensor, arrival: &Arrival<'a>, memo: &'a Memo) -> Self {
        let mut order = Self {
            sensor,
            motions: &arrival.step.motions,
            coming: arrival.coming.clone(),
            memo,
            known: HashMap::new(),
            witness: HashMap::new(),
            blocked: tools::Blocked::new(),
            stuck: Vec::new(),
            left: Vec::new(),
        };
        order.take_apart(order.with_motions(&arrival.coming), &arrival.standing);
        order
    }

    /// Merges pieces that a stated motion moves together.
    fn with_motions(&self, coming: &[Piece<'a>]) -> Vec<Piece<'a>> {
        let mut pieces: Vec<Piece> = Vec::new();
        let mut of_motion = BTreeMap::new();
        for piece in coming {
            let motion = self.motions.iter().position(|motion| moves(motion, piece));
            match motion.and_then(|motion| of_motion.get(&motion).copied()) {
                Some(index) => pieces[index as usize].extend(piece),
                None => {
                    of_motion.extend(motion.map(|motion| (motion, pieces.len() as u32)));
                    pieces.push(piece.clone());
                }
            }
        }
        pieces
    }

    /// Removes pieces one after the other, or in groups, and records those that are stuck.
    fn take_apart(&mut self, mut pieces: Vec<Piece<'a>>, standing: &[&'a Placed<'a>]) {
        // With nothing standing there, the last piece is where it belongs.
        while pieces.len() > usize::from(standing.is_empty()) {
            if let Some(free) = self.remove_free_piece(&pieces, standing) {
                // Pieces removed outside are recorded with the piece, not in the list of the assembly.
                let before = std::mem::take(&mut self.left);
                self.take_apart_outside(&pieces.remove(free));
                let apart = std::mem::replace(&mut self.left, before);
                if let Some(last) = self.left.last_mut() {
                    last.apart = apart;
                }
                continue;
            }
            if let Some((group, way)) = self.group(&pieces, standing) {
                let together = group.iter().flat_map(|i| pieces[*i].clone()).collect();
                let (inside, outside) = pieces
                    .into_iter()
                    .enumerate()
                    .partition::<Vec<_>, _>(|(i, _)| group.contains(i));
                let of = |pieces: Vec<(usize, Piece<'a>)>| pieces.into_iter().map(|(_, p)| p);
                let before = std::mem::take(&mut self.left);
                self.take_apart(of(inside).collect(), &[]);
                let apart = std::mem::replace(&mut self.left, before);
                self.left.push(RemovedPiece { piece: together, way: Some(way), apart });
                pieces = of(outside).collect();
                continue;
            }
            // Nothing can leave: report the least obstructed piece and go on without it.
            let (index, stuck) = self.least(&pieces, standing);
            self.stuck.extend(stuck);
            pieces.remove(index);
        }
    }

    /// Takes apart a piece that a stated motion moved as one but that was put together from several pieces before.
    fn take_apart_outside(&mut self, piece: &Piece<'a>) {
        let is_of = |part: &&Piece<'a>| {
            part.iter().all(|placed| piece.iter().any(|other| std::ptr::eq(*other, *placed)))
        };
        let parts: Vec<Piece> = self.coming.iter().filter(is_of).cloned().collect();
        if parts.len() > 1 {
            // The stated motions are for the assembled piece; its parts move freely outside.
            let motions = std::mem::take(&mut self.motions);
            self.take_apart(parts, &[]);
            self.motions = motions;
        }
    }

    /// Finds the last piece in the step's order that can leave.
    fn remove_free_piece(
        &mut self,
        pieces: &[Piece<'a>],
        standing: &[&'a Placed<'a>],
    ) -> Option<usize> {
        let across: DirectionSource = |piece| {
            if piece.len() == 1 && is_drawn(piece[0]) { Vec::new() } else { azimuths() }
        };
        // The axes first; azimuths are tried only if no piece can leave along an axis.
        [ways_out, across].into_iter().find_map(|ways| {
            (0..pieces.len()).rev().find(|&index| {
                let others = others(pieces, index, standing);
                let way = self.way_out(&pieces[index], &others, ways);
                let piece = || pieces[index].clone();
                self.left.extend(way.map(|way| RemovedPiece {
                    piece: piece(),
                    way,
                    apart: Vec::new(),
                }));
                way.is_some()
            })
        })
    }

    /// Finds a free path: `Some(None)` for a stated motion, `Some(Some(direction))` for a straight one, `None` if the
    /// piece is blocked.
    fn way_out(
        &mut self,
        piece: &Piece<'a>,
        others: &[&'a Placed<'a>],
        ways: DirectionSource,
    ) -> Option<Option<Vector3<f64>>> {
        let found = match self.motion(piece) {
            Some(motion) => {
                let allowed =
                    |mover: &Placed, other: &Placed| self.allowed_overlap_mm(mover, other);
                follow(motion, piece, others, &allowed).is_none().then_some(None)
            }
            None => {
                let mut ways = ways(piece);
                let out = outwards(piece, others);
                // Directions outwards first, since they are most likely free.
                ways.sort_by(|a, b| b.dot(&out).total_cmp(&a.dot(&out)));
                let free = ways.iter().find(|way| !self.is_in_the_way(piece, others, way));
                free.copied().map(Some)
            }
        };
        found.filter(|_| self.has_room(piece, others))
    }

    /// Returns the motion that the step states for a piece.
    fn motion(&self, piece: &Piece) -> Option<&'a Motion> {
        self.motions.iter().find(|motion| moves(motion, piece))
    }

    /// Returns whether any of the other bodies blocks a piece in a direction.
    fn is_in_the_way(
        &mut self,
        piece: &Piece<'a>,
        others: &[&'a Placed<'a>],
        way: &Vector3<f64>,
    ) -> bool {
        let key = (piece[0].key, bits(way));
        // The body that blocked the piece last time usually still does.
        let witness = self.witness.get(&key).copied();
        if others.iter().any(|other| Some(other.key) == witness) {
            return true;
        }
        let found = others.iter().find(|other| self.blocks(piece, other, way));
        self.witness.extend(found.map(|other| (key, other.key)));
        found.is_some()
    }

    /// Returns whether a body keeps a piece from leaving in a direction.
    fn blocks(&mut self, piece: &Piece<'a>, other: &'a Placed<'a>, way: &Vector3<f64>) -> bool {
        piece.iter().any(|mover| {
            let key = (mover.key, other.key, bits(way));
            if let Some(known) = self.known.get(&key) {
                return *known;
            }
            let blocks = self.holds(piece, other, mover) || self.is_met(mover, other, way);
            self.known.insert(key, blocks);
            blocks
        })
    }

    /// Returns whether the mover meets the other body in a direction, beyond the allowed overlap.
    fn is_met(&self, mover: &Placed, other: &Placed, way: &Vector3<f64>) -> bool {
        let meant_mm = self.allowed_overlap_mm(mover, other);
        let key = Key::new(5).key(mover.key).key(other.key).vector(way).number(meant_mm);
        !self.memo.is_clean(&key, || {
            !is_blocked(&mover.body, &other.body, way)
                || meant_mm > 0.0 && !is_too_deep(&mover.body, &other.body, way, meant_mm)
        })
    }

    /// Returns whether a screw holds the mover: it does so until it is drawn.
    fn holds(&self, piece: &Piece, other: &Placed, mover: &Placed) -> bool {
        let is_screw = piece.len() == 1 && is_drawn(mover);
        !is_screw && is_drawn(other) && self.pressed_mm(mover, other) > 0.0
    }

    /// Returns the depth to which two bodies may overlap on the way, mm: their press fit or the compliance of the
    /// softer one; 0 if they must not.
    fn allowed_overlap_mm(&self, a: &Placed, b: &Placed) -> f64 {
        self.pressed_mm(a, b).max(a.of.assembly_compliance_mm).max(b.of.assembly_compliance_mm)
    }

    /// Returns the interference of the press fit between two bodies, mm.
    fn pressed_mm(&self, a: &Placed, b: &Placed) -> f64 {
        let fits = self.sensor.press_fits.iter().filter(|fit| {
            (fit.inner == a.name && fit.outer == b.name)
                || (fit.inner == b.name && fit.outer == a.name)
        });
        fits.map(|fit| fit.interference_mm).fold(0.0, f64::max)
    }

    /// Returns whether all tools that install the piece have room.
    fn has_room(&mut self, piece: &Piece<'a>, others: &[&'a Placed<'a>]) -> bool {
        let (memo, blocked) = (self.memo, &mut self.blocked);
        driven(piece).all(|placed| tools::has_room(placed, others, memo, blocked))
    }

    /// Returns the obstacle that stands in the space of a tool.
    fn without_room(
        &self,
        piece: &Piece<'a>,
        others: &[&'a Placed<'a>],
    ) -> Option<Obstruction<'a>> {
        driven(piece)
            .find_map(|placed| tools::without_room(placed, Occasion::Arrival, others, self.memo))
    }

    /// Finds the smallest group of pieces, though not all, that can leave together because its members only hold each
    /// other.
    fn group(
        &mut self,
        pieces: &[Piece<'a>],
        standing: &[&'a Placed<'a>],
    ) -> Option<(BTreeSet<usize>, Vector3<f64>)> {
        let mut best: Option<(BTreeSet<usize>, Vector3<f64>)> = None;
        // A piece with a stated motion leaves along no other path.
        let starts: Vec<usize> =
            (0..pieces.len()).filter(|&i| self.motion(&pieces[i]).is_none()).collect();
        // An empty piece gives the six axes of the assembly.
        for way in ways_out(&Vec::new()) {
            for &start in &starts {
                let most = best.as_ref().map_or(pieces.len(), |(best, _)| best.len());
                // All pieces together can always leave if nothing stands there, which would prove nothing.
                let limit = if standing.is_empty() { most.min(pieces.len() - 1) } else { most };
                if let Some(group) = self.leaving_with(start, pieces, standing, &way, limit)
                    && group.len() > 1
                    && best.as_ref().is_none_or(|(best, _)| group.len() < best.len())
                {
                    best = Some((group, way));
                }
            }
        }
        best
    }

    /// Returns a piece with all pieces that it pushes out; `None` if they are more than `most`, or if a standing body
    /// blocks them.
    fn leaving_with(
        &mut self,
        start: usize,
        pieces: &[Piece<'a>],
        standing: &[&'a Placed<'a>],
        way: &Vector3<f64>,
        most: usize,
    ) -> Option<BTreeSet<usize>> {
        let (mut group, mut open) = (BTreeSet::from([start]), vec![start]);
        while let Some(piece) = open.pop() {
            if standing.iter().any(|other| self.blocks(&pieces[piece], other, way)) {
                return None;
            }
            for next in 0..pieces.len() {
                let is_new = !group.contains(&next);
                if is_new
                    && pieces[next].iter().any(|other| self.blocks(&pieces[piece], other, way))
                {
                    // A piece with a stated motion cannot be pushed along.
                    if self.motion(&pieces[next]).is_some() {
                        return None;
                    }
                    group.insert(next);
                    open.push(next);
                }
            }
            // Stop early: a smaller group is known.
            if group.len() > most {
                return None;
            }
        }
        Some(group)
    }

    /// Finds the piece that is nearest to coming free, and the obstacle that keeps it.
    fn least(
        &self,
        pieces: &[Piece<'a>],
        standing: &[&'a Placed<'a>],
    ) -> (usize, Option<Obstruction<'a>>) {
        let mut least: Option<(usize, Obstruction)> = None;
        for index in (0..pieces.len()).rev() {
            let others = others(pieces, index, standing);
            let Some(stuck) = self.find_obstruction(&pieces[index], &others) else { continue };
            // A piece that only lacks room for its tool is nearest to coming free.
            if stuck.rule == Rule::Access {
                return (index, Some(stuck));
            }
            let depth_mm = stuck.contact.depth_mm;
            if least.as_ref().is_none_or(|(_, least)| depth_mm < least.contact.depth_mm) {
                least = Some((index, stuck));
            }
        }
        least.map_or((pieces.len() - 1, None), |(index, stuck)| (index, Some(stuck)))
    }

    /// Finds the obstacle that keeps a piece from leaving, on the path on which it is blocked least.
    fn find_obstruction(
        &self,
        piece: &Piece<'a>,
        others: &[&'a Placed<'a>],
    ) -> Option<Obstruction<'a>> {
        let stuck = |other: &'a Placed<'a>, mover: &'a Placed<'a>, contact, along| Obstruction {
            rule: Rule::Motion,
            body: mover.name,
            obstacle: other.name,
            tool: None,
            along,
            contact,
        };
        if let Some(motion) = self.motion(piece) {
            let allowed = |mover: &Placed, other: &Placed| self.allowed_overlap_mm(mover, other);
            let met = follow(motion, piece, others, &allowed);
            return match met {
                Some((contact, other)) => Some(stuck(others[other], piece[0], contact, None)),
                None => self.without_room(piece, others),
            };
        }
        let worst_on = |way: &Vector3<f64>| {
            let pairs = piece.iter().flat_map(|mover| others.iter().map(move |o| (*mover, *o)));
            let met = pairs.filter_map(|(mover, other)| {
                let meant_mm = self.allowed_overlap_mm(mover, other);
                contact(&mover.body, &other.body, way, meant_mm)
                    .map(|contact| stuck(other, mover, contact, Some(-way)))
            });
            met.max_by(|a, b| a.contact.depth_mm.total_cmp(&b.contact.depth_mm))
        };
        let ways: Vec<Option<Obstruction>> = ways_out(piece).iter().map(worst_on).collect();
        // A direction is free, so only a tool can be in the way.
        if ways.iter().any(Option::is_none) {
            return self.without_room(piece, others);
        }
        let ways = ways.into_iter().flatten();
        ways.min_by(|a, b| a.contact.depth_mm.total_cmp(&b.contact.depth_mm))
    }
}

/// Iterates over the bodies of a piece that tools drive in now. Screws of a larger piece were driven in elsewhere.
fn driven<'a>(piece: &Piece<'a>) -> impl Iterator<Item = &'a Placed<'a>> {
    let is_alone = piece.len() == 1;
    piece.iter().copied().filter(move |placed| is_alone || !placed.is_drawn())
}

/// Returns whether a motion is stated for a body of the piece.
fn moves(motion: &Motion, piece: &Piece) -> bool {
    piece.iter().any(|placed| motion.bodies.iter().any(|name| name == placed.name))
}

/// Returns all bodies that a piece must pass.
fn others<'a>(
    pieces: &[Piece<'a>],
    index: usize,
    standing: &[&'a Placed<'a>],
) -> Vec<&'a Placed<'a>> {
    let beside = pieces.iter().enumerate().filter(|(i, _)| *i != index).flat_map(|(_, p)| p);
    standing.iter().chain(beside).copied().collect()
}
