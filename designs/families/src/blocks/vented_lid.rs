//! Vents of a mold's lid: on a circle midway over a layer's foot, which lies up in use, so that air
//! and what is too much leave through them.
//!
//! The lid lies below z = 0, where it closes the mold.

use fabkit_geometry::{CUT_OVERLAP_MM, Cut, Length, Opening, Path, Pose, Profile, Solid, Vector3};

use super::{PRINTED_WALL_MM, around, copies, holes, ring};
use crate::assembling::opening;
use crate::parameters::{Report, limits};

/// Depth of the channel that collects what rises through the vents, mm.
const OVERFLOW_DEPTH_MM: f64 = 1.2;

/// Width of that channel beside a vent, mm.
const OVERFLOW_MARGIN_MM: f64 = 0.3;

/// How much wider than a vent the foot is, mm.
const FOOT_MARGIN_MM: f64 = 0.2;

/// The vents through a lid.
pub struct VentedLid {
    /// How many.
    pub vents: u32,
    /// Diameter of each.
    pub vent_diameter: Length,
    /// Radius of the circle that they open on, mm.
    pub circle_mm: f64,
}

impl VentedLid {
    /// So many vents of that diameter over a foot between two radii, mm.
    pub fn over([inner, outer]: [f64; 2], (vents, vent_diameter): (u32, Length)) -> Self {
        Self { vents, vent_diameter, circle_mm: (inner + outer) / 2.0 }
    }

    /// Where they meet the foot, z axis up.
    fn poses(&self) -> Vec<Pose> {
        ring(self.vents, 0.5, Pose::translation(self.circle_mm, 0.0, 0.0))
    }

    /// What the lid gets; `through` makes a hole of a radius (mm) on the axis through it.
    pub fn cut(&self, through: impl Fn(f64) -> Solid) -> Cut {
        let vent = through(self.vent_diameter.mm() / 2.0);
        holes(copies("vent", &self.poses(), &vent)).with_handles(self.vents as i32)
    }

    /// A channel on the lid's far side at that height (mm) that joins the vents and collects what
    /// rises.
    pub fn overflow(&self, far_z: f64) -> Cut {
        let half = self.vent_diameter.mm() / 2.0 + OVERFLOW_MARGIN_MM;
        let channel = Profile::new(Path::circle([0.0; 2], self.circle_mm + half))
            .with_hole(Path::circle([0.0; 2], self.circle_mm - half));
        let channel = Solid::extrusion(channel, OVERFLOW_DEPTH_MM + CUT_OVERLAP_MM)
            .at_z(far_z - CUT_OVERLAP_MM);
        holes([channel.named("overflow channel")])
    }

    /// Where the layer is open to them while it is cast: out of the layer, against their z axes.
    pub fn openings(&self) -> Vec<Opening> {
        let radius = self.vent_diameter.mm() / 2.0;
        let vent = |(pose, i): (&Pose, i32)| Opening {
            axis: -Vector3::z(),
            ..opening(format!("vent {i}"), pose, radius)
        };
        self.poses().iter().zip(1..).map(vent).collect()
    }

    /// Reports vents that do not open over a foot so wide (mm) alone, whose channel meets what
    /// stands on the lid within a radius (mm), or that meet each other. The section must be called
    /// `mold`.
    pub fn check(&self, (foot_mm, because): (f64, &str), within_mm: f64, report: &mut Report) {
        let mold = self;
        let beside = 2.0 * (self.circle_mm - OVERFLOW_MARGIN_MM - within_mm);
        limits! { report:
            mold.vent_diameter <= (foot_mm - FOOT_MARGIN_MM).min(beside), because;
            mold.vents <= around(self.circle_mm, self.vent_diameter.mm() + PRINTED_WALL_MM),
                "vents need walls between them";
        }
    }
}
