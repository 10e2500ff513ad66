//! Connectivity of the copper, determined from its shapes alone, not from the nets for which it was laid.

use std::collections::BTreeMap;

use crate::layout::{BoardLayout, SIDES};
use crate::shapes::{Point, Shape};

/// Connected piece of copper: the pins on it, and the position of its first pad.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CopperPiece {
    /// Pairs of part and pin, sorted.
    pub pins: Vec<(String, String)>,
    /// Position, mm.
    pub at_mm: Point,
}

/// Returns all connected pieces of copper that hold a pin.
pub(crate) fn find_copper_pieces(layout: &BoardLayout) -> Vec<CopperPiece> {
    // Pads, tracks, vias. A via has no side, because it is on both.
    let mut copper: Vec<(Option<usize>, Shape)> = Vec::new();
    let side = |of| SIDES.iter().position(|side| *side == of);
    copper.extend(layout.pads.iter().map(|pad| (side(pad.side), pad.shape.clone())));
    copper.extend(layout.tracks.iter().map(|track| (side(track.side), track.shape())));
    copper.extend(layout.vias.iter().map(|via| (None, via.shape())));
    // Union-find with path halving. The smallest index is the root, so that pieces come in the order of the pads.
    let mut root: Vec<usize> = (0..copper.len()).collect();
    fn find(root: &mut [usize], mut i: usize) -> usize {
        while root[i] != i {
            root[i] = root[root[i]];
            i = root[i];
        }
        i
    }
    let boxes: Vec<[Point; 2]> = copper.iter().map(|(_, shape)| shape.bounds()).collect();
    for i in 0..copper.len() {
        for j in i + 1..copper.len() {
            let is_same_side = match (copper[i].0, copper[j].0) {
                (Some(one), Some(other)) => one == other,
                _ => true,
            };
            if is_same_side
                && boxes_overlap(&boxes[i], &boxes[j])
                && copper[i].1.distance(&copper[j].1) <= 0.0
            {
                let (a, b) = (find(&mut root, i), find(&mut root, j));
                root[a.max(b)] = a.min(b);
            }
        }
    }
    let mut pieces: BTreeMap<usize, CopperPiece> = BTreeMap::new();
    for (i, pad) in layout.pads.iter().enumerate() {
        let piece = pieces
            .entry(find(&mut root, i))
            .or_insert_with(|| CopperPiece { pins: Vec::new(), at_mm: pad.shape.centre() });
        piece.pins.push((pad.part.clone(), pad.pin.clone()));
    }
    let mut pieces: Vec<CopperPiece> = pieces.into_values().collect();
    pieces.iter_mut().for_each(|piece| piece.pins.sort());
    pieces
}

/// Returns whether two boxes overlap or touch.
pub(crate) fn boxes_overlap(one: &[Point; 2], other: &[Point; 2]) -> bool {
    (0..2).all(|axis| one[0][axis] <= other[1][axis] && other[0][axis] <= one[1][axis])
}
