//! How the thin layers' mixture gets to their feet, and what is too much away from there: gates under
//! the feet, a ring that joins them, and a seat for a syringe.
//!
//! All lie in the face of the core's flange that the cups close, so that each gate opens over the whole
//! width of a foot, however thin, and what has cured there is lifted out once the cup is off.

use std::f64::consts::{PI, TAU};

use fabkit_geometry::{CUT_OVERLAP_MM, Path, Point3, Pose, Profile, Reach, Solid};

use super::layout::Layout;
use super::parameters::HalfEllipsoid;
use super::tooling::key_circle_mm;
use crate::blocks::hanging;
use crate::blocks::sprue::LuerSeat;
use crate::hardware::tools;

/// Width of a gate, mm: a ridge in the negative that is twice as wide as high.
const GATE_MM: f64 = 2.4;

/// Depth of gates and ring, mm.
const RUNNER_MM: f64 = 1.2;

/// From the outermost layer's foot to the ring, mm: what the cup closes.
const LAND_MM: f64 = 0.6;

/// Width of the ring, mm.
const RING_MM: f64 = 1.0;

/// From the outermost layer's foot to the ring's outside, mm.
pub const REACH_MM: f64 = LAND_MM + RING_MM;

/// Silicone between a vent, a gate, a key or the seat and its neighbour, mm.
pub const SILICONE_WALL_MM: f64 = 0.5;

/// The seat in the core's flange.
pub fn seat(p: &HalfEllipsoid) -> LuerSeat {
    LuerSeat { wall_mm: p.tooling.core_flange.mm() }
}

/// Angle of the seat around the axis, rad: between two keys.
fn seat_rad(p: &HalfEllipsoid) -> f64 {
    PI / f64::from(p.tooling.keys)
}

/// Half the angle that a gate takes where the thin layers begin, rad.
pub fn half_gate_rad(layout: &Layout) -> f64 {
    (GATE_MM / 2.0 / layout.foot_of(layout.inner_offset_mm)).min(1.0).asin()
}

/// The middles of the gates, rad: half a step off the vents of the inner elastomer.
pub fn gates_rad(p: &HalfEllipsoid) -> impl Iterator<Item = f64> {
    let count = p.tooling.vents;
    (0..count).map(move |i| TAU * (f64::from(i) + 0.5) / f64::from(count))
}

fn polar(radius: f64, rad: f64) -> [f64; 2] {
    [radius * rad.cos(), radius * rad.sin()]
}

/// Gates and ring, and the way from it to the seat, from above the flange's face to their floor.
fn channels(p: &HalfEllipsoid, layout: &Layout) -> Solid {
    let gate = layout.foot_of(layout.inner_offset_mm);
    let inner = layout.foot_of(layout.black_offset_mm) + LAND_MM;
    let (outer, half) = (inner + RING_MM, half_gate_rad(layout));
    let mut teeth = Path::from(polar(gate, -half + first(p)));
    for middle in gates_rad(p) {
        let next = middle + TAU / f64::from(p.tooling.vents) - half;
        teeth = teeth
            .arc(polar(gate, middle + half), [0.0; 2], true)
            .line(polar(inner, middle + half))
            .arc(polar(inner, next), [0.0; 2], true)
            .line(polar(gate, next));
    }
    let (to, end) = (seat_rad(p), key_circle_mm(layout));
    let side = (GATE_MM / 2.0 / outer).min(1.0).asin();
    let outline = Path::from(polar(outer, to + side))
        .arc(polar(outer, to + PI), [0.0; 2], true)
        .arc(polar(outer, to - side), [0.0; 2], true)
        .line(polar(end, to - side))
        .arc(polar(end, to + side), [0.0; 2], true)
        .close();
    Solid::prism(Profile::new(outline).with_hole(teeth.close()), [-RUNNER_MM, CUT_OVERLAP_MM])
        .named("runner")
}

fn first(p: &HalfEllipsoid) -> f64 {
    PI / f64::from(p.tooling.vents)
}

/// What the core's flange has less, and its negative more; the seat `beyond_mm` longer on the far side.
pub fn tools(p: &HalfEllipsoid, layout: &Layout, beyond_mm: f64) -> Vec<Solid> {
    let [x, y] = polar(key_circle_mm(layout), seat_rad(p));
    let mouth = Pose::translation(x, y, layout.core_flange_z_mm);
    vec![channels(p, layout), seat(p).tool(&mouth, beyond_mm)]
}

/// The syringe in its seat, in the frame of the core.
pub fn syringe(p: &HalfEllipsoid, layout: &Layout) -> Reach {
    let at = polar(key_circle_mm(layout), seat_rad(p));
    tools::syringe(hanging(at, layout.core_flange_z_mm), seat(p).stands_out_mm())
}

/// Middle and radius of a disc that holds what one gate opens of a foot between two radii, mm.
pub fn open_disc(rad: f64, layout: &Layout, [inner, outer]: [f64; 2]) -> (Point3<f64>, f64) {
    let middle = (inner + outer) / 2.0;
    let [x, y] = polar(middle, rad);
    let half = half_gate_rad(layout);
    let corner = polar(outer, half);
    let radius = (corner[0] - middle).abs().max((outer - inner) / 2.0).hypot(corner[1]);
    (Point3::new(x, y, 0.0), radius + CUT_OVERLAP_MM)
}
