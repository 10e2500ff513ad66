//! Bayonet joint: lugs on a spigot, grooves in the bore around it.
//!
//! Both are built in the joint's frame: origin on the axis in the plane of the female part's mouth, +z into it. When
//! locked, the lugs stand at the angles that [`BayonetJoint::lugs`] lists; the entries lie the full turn clockwise of them
//! (seen from +z), so that turning the female part clockwise locks.

use std::f64::consts::TAU;

use fabkit_geometry::{
    Angle, CUT_OVERLAP_MM, Length, Motion, MotionLeg, Path, Point3, Solid, Vector3,
};

use crate::parameters;
use crate::parameters::{RuleReport, limits};

parameters! {
    /// Two bayonet joints: between tip and body, and between body and robot mount.
    pub struct Bayonet {
        /// Number of lugs. The first is wider, so that the joint closes in one position only.
        lugs: u32 = 2..=6,
        /// Width of a lug.
        lug_width: Length = 2.0..=20.0,
        /// Width of the first lug.
        key_width: Length = 2.0..=24.0,
        /// Height of a lug.
        lug_height: Length = 1.0..=6.0,
        /// Length by which a lug reaches beyond the bore in which it locks.
        lug_reach: Length = 0.4..=4.0,
        /// Height of the hook that holds a lug.
        hook_height: Length = 1.0..=8.0,
        /// Thickness of the wall outside the groove.
        wall: Length = 0.8..=5.0,
        /// Angle by which the joint is turned from entry to lock.
        turn: Angle = 10.0..=120.0,
    }
}

/// Depth by which a lug reaches into the spigot's wall that carries it, mm.
const LUG_ROOT_MM: f64 = 0.5;

/// Play between lug and hook when locked, mm; an elastic seal takes it up.
pub const HOOK_PLAY_MM: f64 = 0.1;

/// Play above a lug, mm: a printed groove's ceiling sags.
const CEILING_PLAY_MM: f64 = 0.3;

/// Smallest land between one groove and the next entry, mm along the bore.
const LEAST_LAND_MM: f64 = 1.0;

/// Smallest excess of the first lug's width over an entry with its play, mm.
const KEY_MM: f64 = 0.5;

impl Bayonet {
    /// Reports lugs and grooves that do not work in `joint`, the narrowest one. The section must be called `bayonet`.
    pub fn check(&self, joint: &BayonetJoint, report: &mut RuleReport) {
        let (bayonet, play) = (self, 2.0 * joint.side_gap);
        let spare = (joint.land_mm() - LEAST_LAND_MM) / joint.bore_radius;
        let widest = self.lug_width.mm().max(self.key_width.mm()) + play;
        limits! { report:
            bayonet.key_width >= self.lug_width.mm() + play + KEY_MM,
                "the first lug must not pass an entry of the others";
            // The parameter is on both sides, so that the message states the value that satisfies the rule.
            bayonet.turn <= self.turn.deg() + spare.to_degrees(),
                "1 mm must stand between one groove and the next entry";
            bayonet.turn >= (widest / joint.bore_radius).to_degrees(),
                "a lug must leave its entry altogether";
        }
    }
}

/// One bayonet joint, from the parameters that both joints of a sensor share and its bore.
#[derive(Clone, Debug, PartialEq)]
pub struct BayonetJoint {
    /// Bore radius of the female part, mm.
    pub bore_radius: f64,
    /// Outer radius of the spigot, mm.
    pub spigot_radius: f64,
    /// Outer radius of the lugs, mm.
    pub lug_radius: f64,
    /// Radius of the groove's bottom, mm.
    pub groove_radius: f64,
    /// Outer radius of the female part, mm, with the specified wall beyond the groove.
    pub outer_radius: f64,
    /// Height of the hook's upper face above the mouth, mm.
    pub hook_height: f64,
    /// Height of the lug's lower face above the mouth, mm.
    pub lug_bottom: f64,
    /// Height of the lug's upper face above the mouth, mm.
    pub lug_top: f64,
    /// Height of the groove's ceiling above the mouth, mm.
    pub groove_top: f64,
    /// Turn from entry to lock.
    pub turn: Angle,
    lugs: u32,
    lug_width: f64,
    key_width: f64,
    side_gap: f64,
}

impl BayonetJoint {
    /// Creates the joint in a given bore, with play `gap` per side, mm.
    pub fn in_bore(p: &Bayonet, gap: f64, bore_radius: f64) -> Self {
        let lug_radius = bore_radius + p.lug_reach.mm();
        let groove_radius = lug_radius + gap;
        let lug_bottom = p.hook_height.mm() + HOOK_PLAY_MM;
        let lug_top = lug_bottom + p.lug_height.mm();
        Self {
            bore_radius,
            spigot_radius: bore_radius - gap,
            lug_radius,
            groove_radius,
            outer_radius: groove_radius + p.wall.mm(),
            hook_height: p.hook_height.mm(),
            lug_bottom,
            lug_top,
            groove_top: lug_top + CEILING_PLAY_MM,
            turn: p.turn,
            lugs: p.lugs,
            lug_width: p.lug_width.mm(),
            key_width: p.key_width.mm(),
            side_gap: gap,
        }
    }

    /// Creates the joint in a female part of a given outer radius.
    pub fn within(p: &Bayonet, gap: f64, outer_radius: f64) -> Self {
        // All radii grow by the same amount with the bore.
        let beyond_bore = Self::in_bore(p, gap, 0.0).outer_radius;
        Self::in_bore(p, gap, outer_radius - beyond_bore)
    }

    /// Returns middle angle and half width of each lug, rad, the wide one first.
    pub fn lugs(&self) -> Vec<(f64, f64)> {
        let half = |width: f64| (width / (2.0 * self.lug_radius)).min(1.0).asin();
        (0..self.lugs)
            .map(|i| {
                let width = if i == 0 { self.key_width } else { self.lug_width };
                (TAU * f64::from(i) / f64::from(self.lugs), half(width))
            })
            .collect()
    }

    /// Returns the angle of the play at a lug's side, rad.
    pub fn side_play_rad(&self) -> f64 {
        self.side_gap / self.lug_radius
    }

    /// Returns the narrowest land between one groove and the next entry, mm along the bore.
    pub fn land_mm(&self) -> f64 {
        let lugs = self.lugs();
        let play = 2.0 * self.side_play_rad();
        let lands = (0..lugs.len()).map(|i| {
            let ((at, half), (next, next_half)) = (lugs[i], lugs[(i + 1) % lugs.len()]);
            let step = (next - at).rem_euclid(TAU);
            step - self.turn.rad() - half - next_half - play
        });
        self.bore_radius * lands.fold(TAU, f64::min)
    }

    /// Returns the motion that puts the female part onto the male one: straight, then clockwise (seen from +z) to the
    /// lock.
    pub fn female_onto(&self, bodies: impl IntoIterator<Item = String>) -> Motion {
        self.locking(bodies, -1.0)
    }

    /// Returns the motion that puts the male part into the female one: opposite in direction and turn.
    pub fn male_onto(&self, bodies: impl IntoIterator<Item = String>) -> Motion {
        self.locking(bodies, 1.0)
    }

    /// Returns the locking motion; `sign` is the direction along z, and of the turn around it.
    fn locking(&self, bodies: impl IntoIterator<Item = String>, sign: f64) -> Motion {
        let lock = Angle::from_rad(sign * self.turn.rad()).expect("a turn is finite");
        let axis = Vector3::z();
        let turn = MotionLeg::Turn { point: Point3::origin(), axis, angle: lock, rise_mm: 0.0 };
        Motion::new(bodies, [MotionLeg::from_afar(sign * axis), turn])
    }

    /// Returns the lugs, to be united with a spigot of [`BayonetJoint::spigot_radius`]. Their upper edge is chamfered, so that
    /// it finds the entry and prints without support when the spigot points down.
    pub fn male(&self) -> Solid {
        let root = self.spigot_radius - LUG_ROOT_MM;
        // 45 degrees, over at most 0.6 of the lug's height.
        let chamfer =
            (self.lug_radius - self.spigot_radius).min(0.6 * (self.lug_top - self.lug_bottom));
        let ring = Solid::revolution(Path::polygon(&[
            [root, self.lug_bottom],
            [self.lug_radius, self.lug_bottom],
            [self.lug_radius, self.lug_top - chamfer],
            [self.lug_radius - chamfer, self.lug_top],
            [root, self.lug_top],
        ]));
        // The wedges reach beyond the ring on all sides, so that only their side faces cut it.
        let wedges = self.lugs().into_iter().enumerate().map(|(i, (middle, half))| {
            let wedge = sector(
                [root - 1.0, self.lug_radius + 1.0],
                [middle - half, middle + half],
                [self.lug_bottom - 1.0, self.lug_top + 1.0],
            );
            wedge.named(format!("lug {}", i + 1))
        });
        ring.and(Solid::union(wedges))
    }

    /// Returns the entries and grooves, to be cut from a part with the bore [`BayonetJoint::bore_radius`] whose mouth lies at
    /// `mouth_z`.
    pub fn female_tools(&self, mouth_z: f64) -> Vec<Solid> {
        let play = self.side_play_rad();
        let inner = self.bore_radius - CUT_OVERLAP_MM;
        let groove = |(i, (middle, half)): (usize, (f64, f64))| {
            let (low, high) = (middle - half - play, middle + half + play);
            let enter = low - self.turn.rad();
            let entry = sector(
                [inner, self.groove_radius],
                [enter, high - self.turn.rad()],
                [-CUT_OVERLAP_MM, self.groove_top],
            );
            let run = sector(
                [inner, self.groove_radius],
                [enter, high],
                [self.hook_height, self.groove_top],
            );
            let name = |what| format!("{what} {}", i + 1);
            [entry.named(name("entry")), run.named(name("groove"))]
        };
        let at_mouth = |tool: Solid| tool.at_z(mouth_z);
        self.lugs().into_iter().enumerate().flat_map(groove).map(at_mouth).collect()
    }
}

/// Returns a piece of a ring between two radii, two angles (rad) and two heights, mm.
fn sector([inner, outer]: [f64; 2], [from, to]: [f64; 2], [bottom, top]: [f64; 2]) -> Solid {
    let angle = |rad: f64| Angle::from_rad(rad).expect("an angle made of finite parameters");
    Solid::extrusion(Path::ring_sector(inner, outer, angle(from), angle(to)), top - bottom)
        .at_z(bottom)
}
