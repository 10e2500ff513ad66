//! Screws that hold bodies together: where they are is stated once, and everything else follows.
//!
//! A joint gives each body that takes part in it its holes, landmarks and handles ([`Cut`]), lists
//! what is bought, and declares the overlap of the thread.

use fabkit_geometry::{Body, Cut, Landmark, Placement, Pose, PressFit, Solid};

use super::{BRASS, STEEL};
use crate::hardware::{HeatSetNut, Screw};

/// What a screw's thread holds in.
#[derive(Clone, Debug, PartialEq)]
enum Hold {
    /// Plastic that the screw cuts its own thread into.
    Plastic {
        /// Depth of the hole below the screw's head, mm.
        depth_mm: f64,
    },
    /// A nut that is melted in.
    HeatSet {
        /// Which.
        nut: HeatSetNut,
        /// Of each: the z axis out of the body, the origin where the nut ends flush.
        poses: Vec<Pose>,
        /// Room behind the nut, mm.
        spare_mm: f64,
    },
}

/// Equal screws that hold bodies together.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// What its holes and landmarks are called: `camera screw` or, where there is no screw to be
    /// bought, `mounting hole`.
    pub label: &'static str,
    /// Which screws.
    pub screw: Screw,
    /// Of each screw, in the frame of all bodies: see [`Screw`].
    pub poses: Vec<Pose>,
    /// What holds them.
    hold: Hold,
}

/// Holes of a joint, for constraints.
#[derive(Clone, Copy, Debug)]
pub struct Holes<'a> {
    /// Where they open, the z axis out of the body.
    pub poses: &'a [Pose],
    /// Radius, mm.
    pub radius_mm: f64,
    /// Depth below the origin of the pose, mm.
    pub depth_mm: f64,
}

impl Joint {
    /// Screws that cut their thread into plastic, in holes so deep below their heads.
    pub fn self_tapping(
        label: &'static str,
        screw: Screw,
        poses: Vec<Pose>,
        depth_mm: f64,
    ) -> Self {
        Self { label, screw, poses, hold: Hold::Plastic { depth_mm } }
    }

    /// Screws in nuts that are melted into plastic.
    pub fn heat_set(
        label: &'static str,
        screw: Screw,
        poses: Vec<Pose>,
        hold: (HeatSetNut, Vec<Pose>, f64),
    ) -> Self {
        let (nut, nuts, spare_mm) = hold;
        Self { label, screw, poses, hold: Hold::HeatSet { nut, poses: nuts, spare_mm } }
    }

    /// What a body gets that the screws pass on `depth_mm` below their heads: holes with `gap_mm`
    /// to spare around a countersunk head, a handle each.
    pub fn passed(&self, depth_mm: f64, gap_mm: f64) -> Cut {
        let tool = self.screw.clearance_tool(depth_mm, gap_mm);
        self.cut(&tool, &self.poses, self.label).with_handles(self.poses.len() as i32)
    }

    /// What the body gets that holds the screws or their nuts: blind holes.
    pub fn held(&self) -> Cut {
        match &self.hold {
            Hold::Plastic { depth_mm } => {
                self.cut(&self.screw.pilot_tool(*depth_mm), &self.poses, self.label)
            }
            Hold::HeatSet { nut, poses, spare_mm } => self.cut(&nut.tool(*spare_mm), poses, "nut"),
        }
    }

    /// The same, where the holes go all the way through.
    pub fn held_through(&self) -> Cut {
        self.held().with_handles(self.poses.len() as i32)
    }

    /// The holes that hold the screws or their nuts.
    pub fn holes(&self) -> Holes<'_> {
        match &self.hold {
            Hold::Plastic { depth_mm } => Holes {
                poses: &self.poses,
                radius_mm: self.screw.pilot_hole_mm() / 2.0,
                depth_mm: *depth_mm,
            },
            Hold::HeatSet { nut, poses, spare_mm } => {
                Holes { poses, radius_mm: nut.hole_mm / 2.0, depth_mm: nut.length_mm + spare_mm }
            }
        }
    }

    fn cut(&self, tool: &Solid, poses: &[Pose], label: &str) -> Cut {
        let numbered = || poses.iter().zip(1..);
        let hole = if label.ends_with("hole") { label.to_owned() } else { format!("{label} hole") };
        Cut {
            tools: numbered()
                .map(|(pose, i)| tool.clone().placed(*pose).named(format!("{hole} {i}")))
                .collect(),
            landmarks: numbered()
                .map(|(pose, i)| Landmark::at(format!("{label} {i}"), pose))
                .collect(),
            handles: 0,
        }
    }

    /// What is bought: the screws and, if there are any, the nuts, each where it is placed.
    pub fn bought(
        &self,
        place_screw: impl Fn(&Pose) -> Placement,
        place_nut: impl Fn(&Pose) -> Placement,
    ) -> Vec<Body> {
        let screw = &self.screw;
        let screws = Body::bought(screw.name(), screw.ordered(), screw.solid())
            .placed(self.poses.iter().map(place_screw))
            .one_per_place()
            .colored(STEEL);
        let Hold::HeatSet { nut, poses, .. } = &self.hold else { return vec![screws] };
        let nuts = Body::bought(nut.name(), nut.ordered(), nut.solid())
            .placed(poses.iter().map(place_nut))
            .one_per_place()
            .colored(BRASS);
        vec![screws, nuts]
    }

    /// How what holds overlaps: the thread and plastic, or the nut and the plastic that it melts.
    pub fn press_fit(&self, holder: &str) -> PressFit {
        let (inner, interference_mm, reason) = match &self.hold {
            Hold::Plastic { .. } => (
                self.screw.name(),
                self.screw.thread_overlap_mm(),
                "the screw cuts its thread into plastic",
            ),
            Hold::HeatSet { nut, .. } => (nut.name(), nut.overlap_mm(), "the nut is melted in"),
        };
        PressFit { inner, outer: holder.into(), interference_mm, reason: reason.into() }
    }

    /// What is bought for it, by name, for the chain's steps.
    pub fn names(&self) -> Vec<String> {
        let nut = match &self.hold {
            Hold::Plastic { .. } => None,
            Hold::HeatSet { nut, .. } => Some(nut.name()),
        };
        std::iter::once(self.screw.name()).chain(nut).collect()
    }
}
