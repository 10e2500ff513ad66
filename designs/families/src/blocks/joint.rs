//! Screws that hold bodies together: where they are is stated once, and everything else follows.
//!
//! A joint gives each body that takes part in it its holes, landmarks and handles ([`Cut`]), lists
//! what is bought, and declares the overlap of the thread.

use fabkit_geometry::{Body, CUT_OVERLAP_MM, Cut, Path, Placement, Pose, PressFit, Profile, Solid};

use super::{BRASS, copies, marks, press_fit};
use crate::assembling::{Name, bought};
use crate::hardware::{HeatSetNut, HexNut, Screw};

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
    /// The thread of something bought, such as a spacer.
    Thread,
    /// A nut on the far side, a user's: the screw passes.
    Free {
        /// Depth of the hole below the origin, mm.
        depth_mm: f64,
    },
    /// A hexagon nut, on a face or in a pocket that keeps it from turning.
    Hex {
        /// Which.
        nut: HexNut,
        /// Of each: the origin where the nut bears, the z axis away from the screw's head.
        poses: Vec<Pose>,
        /// Room beside its flats, mm.
        gap_mm: f64,
        /// Depth of the pocket, mm; 0 on a face.
        depth_mm: f64,
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
    /// Whether they are called `screw` or `bolt`.
    word: &'static str,
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
        Self { label, screw, poses, word: "screw", hold: Hold::Plastic { depth_mm } }
    }

    /// Screws in nuts that are melted into plastic.
    pub fn heat_set(
        label: &'static str,
        screw: Screw,
        poses: Vec<Pose>,
        hold: (HeatSetNut, Vec<Pose>, f64),
    ) -> Self {
        let (nut, nuts, spare_mm) = hold;
        let hold = Hold::HeatSet { nut, poses: nuts, spare_mm };
        Self { label, screw, poses, word: "screw", hold }
    }

    /// Screws in hexagon nuts that lie on a face.
    pub fn nutted(
        label: &'static str,
        screw: Screw,
        poses: Vec<Pose>,
        (nut, nuts): (HexNut, Vec<Pose>),
    ) -> Self {
        let hold = Hold::Hex { nut, poses: nuts, gap_mm: 0.0, depth_mm: 0.0 };
        Self { label, screw, poses, word: "screw", hold }
    }

    /// The same, the nuts in pockets with so much room beside their flats, and so deep.
    #[must_use]
    pub fn in_pockets(mut self, gap: f64, depth: f64) -> Self {
        if let Hold::Hex { gap_mm, depth_mm, .. } = &mut self.hold {
            (*gap_mm, *depth_mm) = (gap, depth);
        }
        self
    }

    /// Screws in threads that something bought has.
    pub fn in_threads(label: &'static str, screw: Screw, poses: Vec<Pose>) -> Self {
        Self { label, screw, poses, word: "screw", hold: Hold::Thread }
    }

    /// Screws that pass holes so deep into what somebody else has.
    pub fn free(label: &'static str, screw: Screw, poses: Vec<Pose>, depth_mm: f64) -> Self {
        Self { label, screw, poses, word: "screw", hold: Hold::Free { depth_mm } }
    }

    /// The same, called bolts where a lab reads of them.
    #[must_use]
    pub fn of_bolts(self) -> Self {
        Self { word: "bolt", ..self }
    }

    /// The screw's name among a sensor's bodies.
    pub fn name(&self) -> String {
        self.screw.name().replacen("screw", self.word, 1)
    }

    /// What a body gets that the screws pass on `depth_mm` below their heads: holes with `gap_mm`
    /// to spare around a countersunk head, a handle each.
    pub fn passed(&self, depth_mm: f64, gap_mm: f64) -> Cut {
        let tool = self.screw.clearance_tool(depth_mm, gap_mm);
        self.cut(&tool, &self.poses, &self.hole()).with_handles(self.poses.len() as i32)
    }

    /// The same, for a hole of another radius than the standard's.
    pub fn passed_freely(&self, depth_mm: f64, radius_mm: f64) -> Cut {
        let tool = Solid::cylinder(radius_mm, depth_mm + CUT_OVERLAP_MM).at_z(-depth_mm);
        self.cut(&tool, &self.poses, &self.hole()).with_handles(self.poses.len() as i32)
    }

    /// The same, where the heads lie in counterbores `height_mm` deep with `gap_mm` to spare.
    pub fn sunk(&self, depth_mm: f64, height_mm: f64, gap_mm: f64) -> Cut {
        let tool = self.screw.sunk_tool(depth_mm, height_mm, gap_mm);
        let passage = format!("{} passage", self.label);
        self.cut(&tool, &self.poses, &passage).with_handles(self.poses.len() as i32)
    }

    /// A sheet's profile with their holes.
    pub fn pierced(&self, profile: Profile) -> Profile {
        let radius = self.screw.clearance_hole_mm() / 2.0;
        self.poses.iter().fold(profile, |profile, pose| {
            let at = pose.translation_mm();
            profile.with_hole(Path::circle([at.x, at.y], radius))
        })
    }

    /// What the body gets that holds the screws or their nuts: blind holes.
    pub fn held(&self) -> Cut {
        match &self.hold {
            Hold::Thread => Cut::default(),
            Hold::Free { depth_mm } => {
                let tool = Solid::cylinder(self.free_radius_mm(), *depth_mm + CUT_OVERLAP_MM);
                self.cut(&tool.at_z(-*depth_mm), &self.poses, &self.hole())
            }
            Hold::Plastic { depth_mm } => {
                self.cut(&self.screw.pilot_tool(*depth_mm), &self.poses, &self.hole())
            }
            Hold::HeatSet { nut, poses, spare_mm } => {
                self.cut(&nut.tool(*spare_mm), poses, "nut hole")
            }
            Hold::Hex { nut, poses, gap_mm, depth_mm } => {
                self.cut(&nut.tool(*gap_mm, *depth_mm), poses, "nut pocket")
            }
        }
    }

    /// The same, where the holes go all the way through.
    pub fn held_through(&self) -> Cut {
        self.held().with_handles(self.poses.len() as i32)
    }

    /// The holes that hold the screws or their nuts.
    pub fn holes(&self) -> Holes<'_> {
        match &self.hold {
            Hold::Thread => Holes { poses: &self.poses, radius_mm: 0.0, depth_mm: 0.0 },
            Hold::Free { depth_mm } => {
                Holes { poses: &self.poses, radius_mm: self.free_radius_mm(), depth_mm: *depth_mm }
            }
            Hold::Plastic { depth_mm } => Holes {
                poses: &self.poses,
                radius_mm: self.screw.pilot_hole_mm() / 2.0,
                depth_mm: *depth_mm,
            },
            Hold::HeatSet { nut, poses, spare_mm } => {
                Holes { poses, radius_mm: nut.hole_mm / 2.0, depth_mm: nut.length_mm + spare_mm }
            }
            Hold::Hex { nut, poses, gap_mm, depth_mm } => {
                Holes { poses, radius_mm: nut.corner_mm(*gap_mm), depth_mm: *depth_mm }
            }
        }
    }

    /// Whether the screws find a thread in the body that holds them.
    pub fn holds(&self) -> bool {
        !matches!(self.hold, Hold::Free { .. } | Hold::Thread)
    }

    fn free_radius_mm(&self) -> f64 {
        self.screw.clearance_hole_mm() / 2.0
    }

    fn hole(&self) -> String {
        let is_said = self.label.ends_with("hole");
        if is_said { self.label.to_owned() } else { format!("{} hole", self.label) }
    }

    fn cut(&self, tool: &Solid, poses: &[Pose], hole: &str) -> Cut {
        // A nut's landmark is the nut, a screw's the screw.
        let label = if hole.starts_with("nut") { "nut" } else { self.label };
        Cut { tools: copies(hole, poses, tool), landmarks: marks(label, poses), handles: 0 }
    }

    /// What is bought: the screws and, if there are any, the nuts, each where it is placed.
    pub fn bought(
        &self,
        place_screw: impl Fn(&Pose) -> Placement,
        place_nut: impl Fn(&Pose) -> Placement,
    ) -> Vec<Body> {
        let screws = self.screw.solid();
        let screws =
            bought(&self.name(), self.screw.ordered(), screws, self.poses.iter().map(place_screw))
                .ordered(self.screw.order())
                .reached(self.screw.driver())
                .fastening();
        std::iter::once(screws).chain(self.bought_nuts(place_nut)).collect()
    }

    /// The nuts alone, of screws that a user brings.
    pub fn bought_nuts(&self, place_nut: impl Fn(&Pose) -> Placement) -> Option<Body> {
        match &self.hold {
            Hold::Plastic { .. } | Hold::Thread | Hold::Free { .. } => None,
            Hold::HeatSet { nut, poses, .. } => {
                let places = poses.iter().map(place_nut);
                let body = bought(&nut.name(), nut.ordered(), nut.solid(), places);
                Some(body.ordered(nut.order()).colored(BRASS).reached(nut.iron()).threaded())
            }
            Hold::Hex { nut, poses, depth_mm, .. } => {
                let places = poses.iter().map(place_nut);
                let tool = if *depth_mm > 0.0 { nut.pusher() } else { nut.socket() };
                let body = bought(&nut.name(), nut.ordered(), nut.solid(), places);
                Some(body.ordered(nut.order()).reached(tool).threaded())
            }
        }
    }

    /// How what holds overlaps: the thread and plastic, or the nut and the plastic that it melts;
    /// a nut in its pocket overlaps with nothing.
    pub fn press_fit(&self, holder: Name) -> Option<PressFit> {
        match &self.hold {
            Hold::Plastic { .. } => {
                let reason = format!("the {} cuts its thread into plastic", self.word);
                let overlap_mm = self.screw.thread_overlap_mm();
                Some(press_fit(self.name(), holder, overlap_mm, &reason))
            }
            Hold::HeatSet { nut, .. } => {
                Some(press_fit(nut.name(), holder, nut.overlap_mm(), "the nut is melted in"))
            }
            Hold::Hex { .. } | Hold::Thread | Hold::Free { .. } => None,
        }
    }

    /// What is bought for it, by name, for the chain's steps.
    pub fn names(&self) -> Vec<String> {
        std::iter::once(self.name()).chain(self.nut_name()).collect()
    }

    /// The nut's name among a sensor's bodies, if there is one.
    pub fn nut_name(&self) -> Option<String> {
        match &self.hold {
            Hold::Plastic { .. } | Hold::Thread | Hold::Free { .. } => None,
            Hold::HeatSet { nut, .. } => Some(nut.name()),
            Hold::Hex { nut, .. } => Some(nut.name()),
        }
    }
}
