//! Cable passages of an adapter plate: a slot through it for cables that leave below the sensor, and free space above
//! it for those that leave at the side.

use fabkit_geometry::{Angle, CUT_OVERLAP_MM, Path, Pose, Solid};

use super::pattern::BOSS_MM;
use super::{AdapterPlan, MountFace};

/// Exit of a cable from the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CableOutlet {
    /// Exit through the mounting face, inside a rectangle.
    Below {
        /// Middle, mm.
        at: [f64; 2],
        /// Half the edges, mm.
        half_mm: [f64; 2],
        /// Turn of the rectangle around its middle.
        turn: Angle,
    },
    /// Exit straight to the side.
    Sideways {
        /// Direction around the sensor's axis.
        angle: Angle,
        /// Width, mm.
        width_mm: f64,
        /// Height of its underside above the mounting face, mm.
        above_mm: f64,
    },
}

/// Play around a cable in its slot, mm.
const PLAY_MM: f64 = 0.25;

/// Width of the link from a window to the slot, as a fraction of the window's width: its walls stay clear of those of
/// both.
const LINK: f64 = 0.8;

impl MountFace {
    /// Returns the exits through the mounting face.
    fn below(&self) -> impl Iterator<Item = ([f64; 2], [f64; 2], Angle)> {
        self.exits.iter().filter_map(|exit| match *exit {
            CableOutlet::Below { at, half_mm, turn } => Some((at, half_mm, turn)),
            CableOutlet::Sideways { .. } => None,
        })
    }

    /// Returns the radius of the smallest circle around the sensor's outline, mm.
    pub(super) fn radius_mm(&self) -> f64 {
        let [x, y] = self.outline.half.map(|half| half - self.outline.corner);
        x.hypot(y) + self.outline.corner
    }

    /// Returns the smallest slot width for cables that leave through the windows, one after the other, mm.
    pub(super) fn least_slot_mm(&self) -> f64 {
        let widths = self.below().map(|(_, [x, y], _)| 2.0 * (x.min(y) + PLAY_MM));
        widths.fold(0.0, f64::max)
    }
}

/// Returns whether a position is on the sensor's axis.
fn is_middle(at: [f64; 2]) -> bool {
    at[0].hypot(at[1]) < 1e-9
}

impl AdapterPlan<'_> {
    /// Returns whether the plate has a slot for cables.
    pub(super) fn is_slotted(&self) -> bool {
        self.face.below().count() > 0
    }

    /// Returns the slot from the axis to the rim, and windows beside it that are open to it: cables are laid in from
    /// the side, so that no plug has to pass a hole.
    pub(super) fn slot_tools(&self, beyond_mm: f64) -> Vec<Solid> {
        if !self.is_slotted() {
            return Vec::new();
        }
        let low_z = self.bottom_z - if self.is_iso() { BOSS_MM } else { 0.0 } - CUT_OVERLAP_MM;
        let heights = [low_z, self.face.bottom_z_mm + CUT_OVERLAP_MM];
        let half = self.adapter.cable_width.mm() / 2.0;
        let slot = Solid::cuboid_between([-half, -half, heights[0]], [beyond_mm, half, heights[1]])
            .placed(Pose::rotation_z(self.adapter.cable_angle))
            .named("cable slot");
        let is_in_slot =
            |at: [f64; 2], [x, y]: [f64; 2]| is_middle(at) && x.max(y) + PLAY_MM <= half;
        let beside = self.face.below().filter(|(at, half_mm, _)| !is_in_slot(*at, *half_mm));
        let windows = beside.flat_map(|(at, half_mm, turn)| {
            let edges = half_mm.map(|half| 2.0 * (half + PLAY_MM));
            let corner = 0.5 * edges[0].min(edges[1]).min(1.0);
            let window = Solid::prism(Path::rectangle([0.0; 2], edges, corner), heights)
                .placed(Pose::translation(at[0], at[1], 0.0).then_in(Pose::rotation_z(turn)))
                .named("wire window");
            let link = LINK * edges[0].min(edges[1]).min(2.0 * half) / 2.0;
            let to = at[0].hypot(at[1]);
            let angle = Angle::from_rad(at[1].atan2(at[0])).expect("finite");
            let link = Solid::cuboid_between([0.0, -link, heights[0]], [to, link, heights[1]])
                .placed(Pose::rotation_z(angle))
                .named("way to the wire window");
            // A window that overlaps the slot needs no link.
            std::iter::once(window).chain((to > half).then_some(link))
        });
        std::iter::once(slot).chain(windows).collect()
    }

    /// Returns the distance of a circle from the slot and its windows, mm.
    pub(super) fn distance_to_slots(&self, [x, y]: [f64; 2], radius: f64) -> f64 {
        if !self.is_slotted() {
            return f64::INFINITY;
        }
        let slot =
            distance_to_strip([x, y], self.adapter.cable_angle, self.adapter.cable_width.mm());
        let windows = self.face.below().map(|(at, half_mm, turn)| {
            let (sin, cos) = turn.rad().sin_cos();
            let off = [x - at[0], y - at[1]];
            // The circle's centre in the window's own frame.
            let own = [off[0] * cos + off[1] * sin, off[1] * cos - off[0] * sin];
            crate::blocks::mounting::outside(own, half_mm.map(|half| half + PLAY_MM))
        });
        windows.fold(slot, f64::min) - radius
    }

    /// Returns the distance of cables that leave at the side from a cylinder of that radius and height on the plate,
    /// mm.
    pub(super) fn distance_to_cables(&self, at: [f64; 2], [radius, height]: [f64; 2]) -> f64 {
        let gaps = self.face.exits.iter().filter_map(|exit| match *exit {
            CableOutlet::Sideways { angle, width_mm, above_mm } => {
                let aside = distance_to_strip(at, angle, width_mm) - radius;
                Some(aside.max(above_mm - height))
            }
            CableOutlet::Below { .. } => None,
        });
        gaps.fold(f64::INFINITY, f64::min)
    }
}

/// Returns the distance of a point from a strip of a width that runs from the axis outwards, mm.
fn distance_to_strip([x, y]: [f64; 2], angle: Angle, width_mm: f64) -> f64 {
    let (sin, cos) = angle.rad().sin_cos();
    let (along, across) = (x * cos + y * sin, (y * cos - x * sin).abs());
    (across - width_mm / 2.0).max(0.0).hypot(along.min(0.0))
}
