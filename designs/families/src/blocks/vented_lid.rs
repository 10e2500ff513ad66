//! Vents of a mold's lid, on a circle in the middle of a layer's foot, which is on top during casting, so that air and
//! surplus leave through them.
//!
//! The lid lies below z = 0, where it closes the mold.

use fabkit_geometry::{
    CUT_OVERLAP_MM, CutFeature, Length, Opening, Path, Pose, Profile, Solid, Vector3,
};

use super::{PRINTED_WALL_MM, around, copies, holes, ring};
use crate::chain_builder::opening;
use crate::parameters::{RuleReport, limits};

/// Depth of the channel that collects the overflow of the vents, mm.
const OVERFLOW_DEPTH_MM: f64 = 1.2;

/// Width of that channel beside a vent, mm.
const OVERFLOW_MARGIN_MM: f64 = 0.3;

/// Smallest excess of the foot's width over a vent, mm.
const FOOT_MARGIN_MM: f64 = 0.2;

/// Vents through a lid.
///
/// ```
/// use fabkit_designs::blocks::VentedLid;
/// use fabkit_geometry::{Length, Vector3};
/// let vent = Length::from_mm(1.5).ok_or("not finite")?;
/// let lid = VentedLid::over([10.0, 14.0], (4, vent));
/// assert_eq!(lid.circle_mm, 12.0);
/// // The lid is below the layer, which is cast upside down: air leaves along -z.
/// let openings = lid.openings();
/// assert_eq!((openings.len(), openings[0].axis), (4, -Vector3::z()));
/// # Ok::<(), &str>(())
/// ```
pub struct VentedLid {
    /// Number of vents.
    pub vents: u32,
    /// Diameter of each vent.
    pub vent_diameter: Length,
    /// Radius of the circle on which they open, mm.
    pub circle_mm: f64,
}

impl VentedLid {
    /// Creates vents of a number and diameter over a foot between two radii, mm.
    pub fn over([inner, outer]: [f64; 2], (vents, vent_diameter): (u32, Length)) -> Self {
        Self { vents, vent_diameter, circle_mm: (inner + outer) / 2.0 }
    }

    /// Returns the poses at which the vents meet the foot, z axis up.
    fn poses(&self) -> Vec<Pose> {
        ring(self.vents, 0.5, Pose::translation(self.circle_mm, 0.0, 0.0))
    }

    /// Returns the cut of the lid; `through` makes a hole of a radius (mm) on the axis through it.
    pub fn cut(&self, through: impl Fn(f64) -> Solid) -> CutFeature {
        let vent = through(self.vent_diameter.mm() / 2.0);
        holes(copies("vent", &self.poses(), &vent)).with_handles(self.vents as i32)
    }

    /// Returns a channel on the lid's far side, at a height (mm), that joins the vents and collects their overflow.
    pub fn overflow(&self, far_z: f64) -> CutFeature {
        let half = self.vent_diameter.mm() / 2.0 + OVERFLOW_MARGIN_MM;
        let channel = Profile::new(Path::circle([0.0; 2], self.circle_mm + half))
            .with_hole(Path::circle([0.0; 2], self.circle_mm - half));
        let channel = Solid::extrusion(channel, OVERFLOW_DEPTH_MM + CUT_OVERLAP_MM)
            .at_z(far_z - CUT_OVERLAP_MM);
        holes([channel.named("overflow channel")])
    }

    /// Returns the openings of the layer at the vents while it is cast, directed out of the layer, against the z axes
    /// of the poses.
    pub fn openings(&self) -> Vec<Opening> {
        let radius = self.vent_diameter.mm() / 2.0;
        let vent = |(pose, i): (&Pose, i32)| Opening {
            axis: -Vector3::z(),
            ..opening(format!("vent {i}"), pose, radius)
        };
        self.poses().iter().zip(1..).map(vent).collect()
    }

    /// Reports vents that are wider than a foot of width `foot_mm`, whose channel collides with whatever is on the lid
    /// within a radius (mm), or that touch each other. The section must be called `mold`.
    pub fn check(&self, (foot_mm, because): (f64, &str), within_mm: f64, report: &mut RuleReport) {
        let mold = self;
        let beside = 2.0 * (self.circle_mm - OVERFLOW_MARGIN_MM - within_mm);
        limits! { report:
            mold.vent_diameter <= (foot_mm - FOOT_MARGIN_MM).min(beside), because;
            mold.vents <= around(self.circle_mm, self.vent_diameter.mm() + PRINTED_WALL_MM),
                "vents need walls between them";
        }
    }
}
