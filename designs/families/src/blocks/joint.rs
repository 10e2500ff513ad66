//! Screw joints: the positions of the screws are stated once, and holes, hardware and thread overlaps are derived from
//! them.
//!
//! A joint gives each body that it holds together its holes, landmarks and handles ([`CutFeature`]), lists the bought pieces,
//! and declares the overlap of the thread.

use fabkit_geometry::{
    Body, CUT_OVERLAP_MM, CutFeature, Path, Placement, Pose, PressFit, Profile, Solid,
};

use super::{BRASS, copies, landmarks_at, press_fit};
use crate::chain_builder::{Name, bought};
use crate::hardware::{HeatSetNut, HexNut, Screw};

/// Thread that holds a screw.
#[derive(Clone, Debug, PartialEq)]
enum ScrewHold {
    /// Thread that the screw cuts into plastic itself.
    Plastic {
        /// Depth of the hole below the screw's head, mm.
        depth_mm: f64,
    },
    /// Nut that is melted in.
    HeatSet {
        /// Type of the nut.
        nut: HeatSetNut,
        /// Poses of the nuts: z axis out of the body, origin where the nut ends flush.
        poses: Vec<Pose>,
        /// Space behind the nut, mm.
        spare_mm: f64,
    },
    /// Thread of a bought piece, such as a spacer.
    Thread,
    /// Nut on the far side that the user provides: the screw passes a hole.
    Free {
        /// Depth of the hole below the origin, mm.
        depth_mm: f64,
    },
    /// Hexagon nut, on a face or in a pocket that keeps it from turning.
    Hex {
        /// Type of the nut.
        nut: HexNut,
        /// Poses of the nuts: origin where the nut bears, z axis away from the screw's head.
        poses: Vec<Pose>,
        /// Clearance beside its flats, mm.
        gap_mm: f64,
        /// Depth of the pocket, mm; 0 on a face.
        depth_mm: f64,
    },
}

/// Equal screws that hold bodies together.
///
/// ```
/// use fabkit_designs::{Screw, blocks::ScrewJoint, blocks::ring, chain_builder::SENSOR};
/// use fabkit_geometry::Pose;
/// let poses = ring(3, 0.0, Pose::translation(10.0, 0.0, 0.0));
/// let joint = ScrewJoint::self_tapping("lid screw", Screw::M3X12, poses, 13.0);
/// // The lid gets through holes of 3.4 mm, the box blind ones of 2.5 mm; three screws are bought.
/// assert_eq!(joint.clearance_cut(3.0, 0.0).handles, 3);
/// assert_eq!(joint.thread_cut().handles, 0);
/// assert_eq!(joint.holes().radius_mm, 1.25);
/// let bought = joint.bought(|pose| SENSOR.at(*pose), |pose| SENSOR.at(*pose));
/// assert_eq!((&*bought[0].name, bought[0].placements.len()), ("screw-m3x12", 3));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ScrewJoint {
    /// Name of its holes and landmarks: `camera screw` or, if no screw is bought, `mounting hole`.
    pub label: &'static str,
    /// Type of the screws.
    pub screw: Screw,
    /// Pose of each screw, in the frame of all bodies: see [`Screw`].
    pub poses: Vec<Pose>,
    /// Stem of the screws' name: `screw` or `bolt`.
    word: &'static str,
    /// Thread that holds them.
    hold: ScrewHold,
}

/// Holes of a joint, for constraints.
#[derive(Clone, Copy, Debug)]
pub struct Holes<'a> {
    /// Poses at which they open, the z axis out of the body.
    pub poses: &'a [Pose],
    /// Radius, mm.
    pub radius_mm: f64,
    /// Depth below the origin of the pose, mm.
    pub depth_mm: f64,
}

impl ScrewJoint {
    /// Creates a joint of screws that cut their thread into plastic, in holes of a depth below their heads.
    pub fn self_tapping(
        label: &'static str,
        screw: Screw,
        poses: Vec<Pose>,
        depth_mm: f64,
    ) -> Self {
        Self { label, screw, poses, word: "screw", hold: ScrewHold::Plastic { depth_mm } }
    }

    /// Creates a joint of screws in nuts that are melted into plastic; `hold` is the nut, its poses and the space
    /// behind it, mm.
    pub fn heat_set(
        label: &'static str,
        screw: Screw,
        poses: Vec<Pose>,
        hold: (HeatSetNut, Vec<Pose>, f64),
    ) -> Self {
        let (nut, nuts, spare_mm) = hold;
        let hold = ScrewHold::HeatSet { nut, poses: nuts, spare_mm };
        Self { label, screw, poses, word: "screw", hold }
    }

    /// Creates a joint of screws in hexagon nuts that lie on a face.
    pub fn in_hex_nuts(
        label: &'static str,
        screw: Screw,
        poses: Vec<Pose>,
        (nut, nuts): (HexNut, Vec<Pose>),
    ) -> Self {
        let hold = ScrewHold::Hex { nut, poses: nuts, gap_mm: 0.0, depth_mm: 0.0 };
        Self { label, screw, poses, word: "screw", hold }
    }

    /// Moves the hexagon nuts into pockets with a clearance beside their flats and a depth, mm.
    #[must_use]
    pub fn in_pockets(mut self, gap: f64, depth: f64) -> Self {
        if let ScrewHold::Hex { gap_mm, depth_mm, .. } = &mut self.hold {
            (*gap_mm, *depth_mm) = (gap, depth);
        }
        self
    }

    /// Creates a joint of screws in the threads of a bought piece.
    pub fn in_threads(label: &'static str, screw: Screw, poses: Vec<Pose>) -> Self {
        Self { label, screw, poses, word: "screw", hold: ScrewHold::Thread }
    }

    /// Creates a joint of screws that pass holes of a depth, into threads that the user provides.
    pub fn through_holes(
        label: &'static str,
        screw: Screw,
        poses: Vec<Pose>,
        depth_mm: f64,
    ) -> Self {
        Self { label, screw, poses, word: "screw", hold: ScrewHold::Free { depth_mm } }
    }

    /// Names the screws `bolt` in texts for the lab.
    #[must_use]
    pub fn named_bolts(self) -> Self {
        Self { word: "bolt", ..self }
    }

    /// Returns the screw's name among a sensor's bodies.
    pub fn name(&self) -> String {
        self.screw.name().replacen("screw", self.word, 1)
    }

    /// Returns the cut for a body that the screws pass over `depth_mm` below their heads: clearance holes with `gap_mm`
    /// around a countersunk head, one handle each.
    pub fn clearance_cut(&self, depth_mm: f64, gap_mm: f64) -> CutFeature {
        let tool = self.screw.clearance_tool(depth_mm, gap_mm);
        self.cut(&tool, &self.poses, &self.hole()).with_handles(self.poses.len() as i32)
    }

    /// Returns the same cut with holes of another radius than the standard's.
    pub fn clearance_cut_with_radius(&self, depth_mm: f64, radius_mm: f64) -> CutFeature {
        let tool = Solid::cylinder(radius_mm, depth_mm + CUT_OVERLAP_MM).at_z(-depth_mm);
        self.cut(&tool, &self.poses, &self.hole()).with_handles(self.poses.len() as i32)
    }

    /// Returns the same cut with the heads in counterbores `height_mm` deep with clearance `gap_mm`.
    pub fn counterbore_cut(&self, depth_mm: f64, height_mm: f64, gap_mm: f64) -> CutFeature {
        let tool = self.screw.counterbore_tool(depth_mm, height_mm, gap_mm);
        let passage = format!("{} passage", self.label);
        self.cut(&tool, &self.poses, &passage).with_handles(self.poses.len() as i32)
    }

    /// Adds the clearance holes to a sheet's profile.
    pub fn pierce_profile(&self, profile: Profile) -> Profile {
        let radius = self.screw.clearance_hole_mm() / 2.0;
        self.poses.iter().fold(profile, |profile, pose| {
            let at = pose.translation_mm();
            profile.with_hole(Path::circle([at.x, at.y], radius))
        })
    }

    /// Returns the cut for the body that holds the screws or their nuts: blind holes.
    pub fn thread_cut(&self) -> CutFeature {
        match &self.hold {
            // The bought piece comes with its thread.
            ScrewHold::Thread => CutFeature::default(),
            ScrewHold::Free { depth_mm } => {
                let tool = Solid::cylinder(self.free_radius_mm(), *depth_mm + CUT_OVERLAP_MM);
                self.cut(&tool.at_z(-*depth_mm), &self.poses, &self.hole())
            }
            ScrewHold::Plastic { depth_mm } => {
                self.cut(&self.screw.pilot_tool(*depth_mm), &self.poses, &self.hole())
            }
            ScrewHold::HeatSet { nut, poses, spare_mm } => {
                self.cut(&nut.hole_tool(*spare_mm), poses, "nut hole")
            }
            ScrewHold::Hex { nut, poses, gap_mm, depth_mm } => {
                self.cut(&nut.pocket_tool(*gap_mm, *depth_mm), poses, "nut pocket")
            }
        }
    }

    /// Returns the same cut where the holes go all the way through.
    pub fn thread_cut_through(&self) -> CutFeature {
        self.thread_cut().with_handles(self.poses.len() as i32)
    }

    /// Returns the holes that hold the screws or their nuts.
    pub fn holes(&self) -> Holes<'_> {
        match &self.hold {
            ScrewHold::Thread => Holes { poses: &self.poses, radius_mm: 0.0, depth_mm: 0.0 },
            ScrewHold::Free { depth_mm } => {
                Holes { poses: &self.poses, radius_mm: self.free_radius_mm(), depth_mm: *depth_mm }
            }
            ScrewHold::Plastic { depth_mm } => Holes {
                poses: &self.poses,
                radius_mm: self.screw.pilot_hole_mm() / 2.0,
                depth_mm: *depth_mm,
            },
            ScrewHold::HeatSet { nut, poses, spare_mm } => {
                Holes { poses, radius_mm: nut.hole_mm / 2.0, depth_mm: nut.length_mm + spare_mm }
            }
            ScrewHold::Hex { nut, poses, gap_mm, depth_mm } => {
                Holes { poses, radius_mm: nut.corner_mm(*gap_mm), depth_mm: *depth_mm }
            }
        }
    }

    /// Returns whether the screws find a thread in the body that holds them.
    pub fn has_thread(&self) -> bool {
        !matches!(self.hold, ScrewHold::Free { .. } | ScrewHold::Thread)
    }

    fn free_radius_mm(&self) -> f64 {
        self.screw.clearance_hole_mm() / 2.0
    }

    /// Returns the name of a screw's hole.
    fn hole(&self) -> String {
        // Avoids `mounting hole hole`.
        let is_said = self.label.ends_with("hole");
        if is_said { self.label.to_owned() } else { format!("{} hole", self.label) }
    }

    /// Returns the cut of a tool at all poses, with landmarks and without handles.
    fn cut(&self, tool: &Solid, poses: &[Pose], hole: &str) -> CutFeature {
        // The landmark of a nut's hole is named after the nut, others after the screw.
        let label = if hole.starts_with("nut") { "nut" } else { self.label };
        CutFeature {
            tools: copies(hole, poses, tool),
            landmarks: landmarks_at(label, poses),
            handles: 0,
        }
    }

    /// Returns the bought pieces: the screws and, if there are any, the nuts, each at its placements.
    pub fn bought(
        &self,
        place_screw: impl Fn(&Pose) -> Placement,
        place_nut: impl Fn(&Pose) -> Placement,
    ) -> Vec<Body> {
        let screws = self.screw.solid();
        let screws = bought(
            &self.name(),
            self.screw.order_text(),
            screws,
            self.poses.iter().map(place_screw),
        )
        .with_order(self.screw.order())
        .with_tool_access(self.screw.driver())
        .as_fastener();
        std::iter::once(screws).chain(self.bought_nuts(place_nut)).collect()
    }

    /// Returns the nuts alone, for screws that the user provides.
    pub fn bought_nuts(&self, place_nut: impl Fn(&Pose) -> Placement) -> Option<Body> {
        match &self.hold {
            ScrewHold::Plastic { .. } | ScrewHold::Thread | ScrewHold::Free { .. } => None,
            ScrewHold::HeatSet { nut, poses, .. } => {
                let places = poses.iter().map(place_nut);
                let body = bought(&nut.name(), nut.order_text(), nut.solid(), places);
                Some(
                    body.with_order(nut.order())
                        .colored(BRASS)
                        .with_tool_access(nut.iron())
                        .threaded(),
                )
            }
            ScrewHold::Hex { nut, poses, depth_mm, .. } => {
                let places = poses.iter().map(place_nut);
                let tool = if *depth_mm > 0.0 { nut.pusher() } else { nut.socket() };
                let body = bought(&nut.name(), nut.order_text(), nut.solid(), places);
                Some(body.with_order(nut.order()).with_tool_access(tool).threaded())
            }
        }
    }

    /// Returns the intended overlap: of the thread with plastic, or of the nut with the plastic that it melts; a nut in
    /// a pocket overlaps with nothing.
    pub fn press_fit(&self, holder: Name) -> Option<PressFit> {
        match &self.hold {
            ScrewHold::Plastic { .. } => {
                let reason = format!("the {} cuts its thread into plastic", self.word);
                let overlap_mm = self.screw.thread_overlap_mm();
                Some(press_fit(self.name(), holder, overlap_mm, &reason))
            }
            ScrewHold::HeatSet { nut, .. } => {
                Some(press_fit(nut.name(), holder, nut.overlap_mm(), "the nut is melted in"))
            }
            ScrewHold::Hex { .. } | ScrewHold::Thread | ScrewHold::Free { .. } => None,
        }
    }

    /// Returns the names of the bought pieces, for the steps of the chain.
    pub fn names(&self) -> Vec<String> {
        std::iter::once(self.name()).chain(self.nut_name()).collect()
    }

    /// Returns the nut's name among a sensor's bodies, if there is one.
    pub fn nut_name(&self) -> Option<String> {
        match &self.hold {
            ScrewHold::Plastic { .. } | ScrewHold::Thread | ScrewHold::Free { .. } => None,
            ScrewHold::HeatSet { nut, .. } => Some(nut.name()),
            ScrewHold::Hex { nut, .. } => Some(nut.name()),
        }
    }
}
