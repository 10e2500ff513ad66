//! The screws of the sensor: each joint is stated here, and nowhere else.

use fabkit_geometry::{Point3, Pose, Vector3};

use super::layout::{BOLT, Layout};
use super::parameters::HalfEllipsoid;
use crate::blocks::mounting::{MountHold, MountRing, Mounting};
use crate::blocks::{Joint, ring};

/// Room of a bolt's hole beyond its tip, mm.
const BOLT_SPARE_MM: f64 = 0.4;

/// Depth of the mounting holes, mm.
const MOUNT_DEPTH_MM: f64 = 3.0;

/// All joints, in the sensor frame.
pub struct Joints {
    /// Through the shell holder's skirt into the base, pointing at the axis.
    pub holder: Joint,
    /// In the base's bottom, for what the sensor is mounted on; a user's screws.
    pub mounting: Joint,
}

impl Joints {
    /// Where they are; meaningful only for parameters that satisfy the family's constraints.
    pub fn new(p: &HalfEllipsoid, layout: &Layout) -> Self {
        // A flat head lies flush with a round wall where its rim does.
        let head = BOLT.head_diameter_mm() / 2.0;
        let radius = (layout.holder_radius_mm.powi(2) - head.powi(2)).sqrt();
        let bolt = Pose::z_to(Vector3::x(), Point3::new(radius, 0.0, layout.bolt_z_mm));
        let bolts = ring(p.base.bolts, 0.0, bolt);
        let depth = BOLT.length_mm + BOLT_SPARE_MM;
        Self {
            holder: Joint::self_tapping("bolt", BOLT, bolts, depth).of_bolts(),
            mounting: mounting(p).joint(layout.bottom_z_mm),
        }
    }
}

/// Holes for what the sensor is mounted on.
pub(super) fn mounting(p: &HalfEllipsoid) -> Mounting<'_> {
    Mounting {
        mount: &p.mount,
        // Half a step off the bolts.
        ring: MountRing::Circle(p.base.mount_holes, p.base.mount_radius, 0.5),
        depth_mm: MOUNT_DEPTH_MM,
        is_through: false,
        holds: (
            &[MountHold::Tapped],
            "the base is of resin, which does not melt around an insert, and everything in it is glued \
             in above the holes",
        ),
    }
}
