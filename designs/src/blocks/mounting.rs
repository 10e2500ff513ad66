//! How a sensor is held: a user's screws in its floor, or bolts through its plate into the flange of
//! a robot.

use fabkit_geometry::{Body, CUT_OVERLAP_MM, Cut, Length, Placement, Pose, Solid};

use super::{Joint, around, bought, copies, hanging, marks, ring};
use crate::hardware::{Screw, SocketScrew};
use crate::parameters::{Report, limits};

/// Length of thread that a robot's flange takes, mm.
const BOLT_BITE_MM: f64 = 6.0;

/// Between the heads of two bolts, mm.
const HEADS_APART_MM: f64 = 1.0;

/// Between a bolt's head and the wall around it, mm.
const HEAD_IN_WALL_MM: f64 = 0.5;

/// Holes on a circle of a floor, for a user's screws.
pub struct Mounting {
    /// How many.
    pub mount_holes: u32,
    /// Radius of their circle.
    pub mount_radius: Length,
    /// By how many steps the first is off the x axis.
    pub offset: f64,
    /// What is screwed in.
    pub screw: Screw,
    /// Depth of the holes, mm.
    pub depth_mm: f64,
}

impl Mounting {
    /// In a floor whose underside has that height, mm.
    pub fn joint(&self, bottom_z: f64) -> Joint {
        let first = hanging([self.mount_radius.mm(), 0.0], bottom_z);
        let poses = ring(self.mount_holes, self.offset, first);
        Joint::self_tapping("mounting hole", self.screw, poses, self.depth_mm)
    }

    /// Reports holes beyond a radius (mm), or without walls so thick (mm) between them. The section
    /// must be called `base`.
    pub fn check(&self, (within_mm, because): (f64, &str), wall_mm: f64, report: &mut Report) {
        let (base, hole) = (self, self.screw.pilot_hole_mm() / 2.0);
        let half_step = std::f64::consts::PI / f64::from(self.mount_holes);
        limits! { report:
            base.mount_radius <= within_mm - hole, because;
            base.mount_radius >= (hole + wall_mm) / half_step.sin(),
                "mounting holes need walls between them";
        }
    }
}

/// Socket head bolts through a plate into a robot's flange.
pub struct Flange {
    /// Which.
    pub bolt: SocketScrew,
    /// How many.
    pub bolts: u32,
    /// Diameter of their circle.
    pub bolt_circle: Length,
    /// Where the heads bear: the top of the plate, mm.
    pub top_z: f64,
    /// Thickness of the plate that they hold, mm.
    pub plate_mm: f64,
}

impl Flange {
    /// Of each bolt: z axis up, origin where the head bears.
    fn poses(&self) -> Vec<Pose> {
        ring(self.bolts, 0.5, Pose::translation(self.bolt_circle.mm() / 2.0, 0.0, self.top_z))
    }

    /// Its bolt's name among a sensor's bodies.
    pub fn name(&self) -> String {
        format!("bolt-m{}", self.bolt.thread_mm)
    }

    /// What the plate gets.
    pub fn passed(&self) -> Cut {
        let (poses, depth) = (self.poses(), self.plate_mm + CUT_OVERLAP_MM);
        let hole = Solid::cylinder(self.bolt.clearance_hole_mm / 2.0, depth + CUT_OVERLAP_MM);
        Cut {
            tools: copies("bolt hole", &poses, &hole.at_z(-depth)),
            landmarks: marks("bolt", &poses),
            handles: poses.len() as i32,
        }
    }

    /// What is bought: through the plate and into the flange, as near as the standard's lengths
    /// come.
    pub fn bought(&self, place: impl Fn(&Pose) -> Placement) -> Body {
        let length = SocketScrew::length_near_mm(self.plate_mm + BOLT_BITE_MM);
        let ordered = format!("socket head screw ISO 4762 M{}x{length}", self.bolt.thread_mm);
        let text = format!("{ordered}, and what the robot's maker demands");
        bought(&self.name(), text, self.bolt.solid(length), self.poses().iter().map(place))
    }

    /// Reports heads that meet each other, or a wall around them of that radius (mm). The section
    /// must be called `mount`.
    pub fn check(&self, (within_mm, what): (f64, &str), report: &mut Report) {
        let (mount, head) = (self, self.bolt.head_diameter_mm / 2.0);
        limits! { report:
            mount.bolt_circle <= 2.0 * (within_mm - head - HEAD_IN_WALL_MM),
                format!("the bolts' heads lie inside {what}");
            mount.bolts <= around(self.bolt_circle.mm() / 2.0, 2.0 * head + HEADS_APART_MM),
                format!("the M{} heads stand side by side on their circle", self.bolt.thread_mm);
        }
    }
}
