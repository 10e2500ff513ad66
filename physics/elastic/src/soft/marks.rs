//! Where the marks are that a camera follows, while something presses.

use fabkit_geometry::{Carrier, Mark, Point3, TouchSurface, Vector3};

use super::SoftStack;
use super::rod::{Rod, Turn};
use crate::{Curve, Outcome};

/// Nearer to an interface than this part of a layer, a mark is on it.
const ON_INTERFACE: f64 = 0.02;
/// Where the layers end, by s.
const RIM: f64 = 1.0;

/// A mark that has moved, sensor frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarkMoved {
    /// From where it is at rest, mm.
    pub displacement_mm: Vector3<f64>,
    /// Which way it now points, unit.
    pub axis: Vector3<f64>,
}

/// Where a place is in the layers.
struct Within {
    s: f64,
    azimuth: f64,
    /// Counted from outside.
    layer: usize,
    /// From the layer's outer face, 0, to its inner one, 1.
    share: f64,
}

impl Within {
    fn nearest_interface(&self) -> usize {
        if self.share < 0.5 { self.layer } else { self.layer + 1 }
    }
}

impl SoftStack {
    /// Divides layers where marks are in the middle of them, so that the solver tells how just that place moves: at
    /// most one more interface in each layer, at the depth of the median mark, as a part of the layer.
    pub fn divide_at_marks(&mut self, touch: &TouchSurface, marks: &[Mark]) {
        let mut shares = vec![Vec::new(); self.body.layers.len()];
        for within in marks.iter().filter_map(|mark| self.within(touch, mark.point)) {
            shares[within.layer].push(within.share);
        }
        // From inside: what is put in moves what follows.
        for (layer, mut shares) in shares.into_iter().enumerate().rev() {
            shares.sort_by(f64::total_cmp);
            let share = shares.get(shares.len() / 2).copied().unwrap_or(0.0);
            if !(ON_INTERFACE..=1.0 - ON_INTERFACE).contains(&share) {
                continue;
            }
            let body = &mut self.body;
            let [outer, inner] = [layer, layer + 1].map(|i| &body.interfaces[i]);
            let between = Curve::between(outer, inner, share);
            body.interfaces.insert(layer + 1, between);
            body.layers.insert(layer, body.layers[layer].clone());
        }
    }

    /// Where a mark is while something presses; nothing beyond the end of the layers.
    ///
    /// The gel carries a mark as it carries its middle: exact for what is as stiff as the gel around it, and for
    /// anything symmetric in a strain that is even over its size. A pin leaves what it stands on as that goes and
    /// turns, averaged over its foot; from there it is a beam that the gel around it holds.
    pub fn mark(&self, outcome: &Outcome, touch: &TouchSurface, mark: &Mark) -> Option<MarkMoved> {
        let here = self.within(touch, mark.point)?;
        let gel_moved_mm = self.moved_mm(outcome, &here);
        let Carrier::Pin { root } = mark.carrier else {
            let turn = self.turn(outcome, touch, mark.point, &here, mark.radius_mm)?;
            return Some(MarkMoved { displacement_mm: gel_moved_mm, axis: turn.of(mark.axis) });
        };
        let foot = self.within(touch, root)?;
        let turn = self.turn(outcome, touch, root, &foot, mark.radius_mm)?;
        // It is of what lies outside of the interface that it stands on.
        let below = foot.nearest_interface().min(self.body.layers.len() - 1);
        let [pin, gel] = [below.saturating_sub(1), below].map(|i| &self.body.layers[i].material);
        let lever_mm = mark.point - root;
        let rod = Rod::new(pin, gel, mark.radius_mm, lever_mm.norm());
        let root_moved_mm = self.moved_mm(outcome, &foot);
        let (displacement_mm, axis) = rod.moved(lever_mm, root_moved_mm, gel_moved_mm, &turn);
        Some(MarkMoved { displacement_mm, axis })
    }

    fn within(&self, touch: &TouchSurface, point: Point3<f64>) -> Option<Within> {
        let (depth_mm, outward) = touch.depth_mm(&point);
        let [s, azimuth] = self.coordinates(&(point + depth_mm * outward));
        if s > RIM {
            return None;
        }
        let places: Vec<[f64; 2]> = self.body.interfaces.iter().map(|curve| curve.at(s)).collect();
        let depth_of = |i: usize| {
            let [[r, z], [outer_r, outer_z]] = [places[i], places[0]];
            (r - outer_r).hypot(z - outer_z)
        };
        // What is outside of all layers, or below them, is on the nearest face.
        let layers = self.body.layers.len();
        let layer = (1..layers).rev().find(|layer| depth_of(*layer) <= depth_mm).unwrap_or(0);
        let [outer_mm, inner_mm] = [layer, layer + 1].map(depth_of);
        let share = ((depth_mm - outer_mm) / (inner_mm - outer_mm)).clamp(0.0, 1.0);
        Some(Within { s, azimuth, layer, share })
    }

    /// How a place moves, sensor frame, mm: in proportion between interfaces.
    fn moved_mm(&self, outcome: &Outcome, at: &Within) -> Vector3<f64> {
        let [outer, inner] =
            [at.layer, at.layer + 1].map(|i| outcome.displacement_mm(i, at.azimuth, at.s));
        self.sensor_from_stack.vector((1.0 - at.share) * outer + at.share * inner)
    }

    /// How the interface nearest to a place turns there: by two ways across it, before and after.
    fn turn(
        &self,
        outcome: &Outcome,
        touch: &TouchSurface,
        point: Point3<f64>,
        at: &Within,
        radius_mm: f64,
    ) -> Option<Turn> {
        let (depth_mm, outward) = touch.depth_mm(&point);
        let surface = point + depth_mm * outward;
        let interface = at.nearest_interface();
        let ways = self.along(&surface, &outward).map(|way| {
            let [ahead, behind] = [1.0, -1.0].map(|side| {
                let [s, azimuth] = self.coordinates(&(surface + side * radius_mm * way));
                let s = s.min(RIM);
                let place = outcome.place_mm(interface, azimuth, s).coords;
                [place, place + outcome.displacement_mm(interface, azimuth, s)]
            });
            [ahead[0] - behind[0], ahead[1] - behind[1]]
        });
        let normal = |when: usize| {
            let normal = ways[0][when].cross(&ways[1][when]).try_normalize(1e-12)?;
            Some(self.sensor_from_stack.vector(normal))
        };
        Some(Turn { before: normal(0)?, after: normal(1)? })
    }
}
