//! Rectangular shell on a base: four screws from below, a lip that centres both, a notch for cable and wires, holes in
//! the base for a gripper's screws.

use fabkit_geometry::{
    Body, CUT_OVERLAP_MM, Color, FixtureGrip, Length, Point3, Pose, Process, Profile, Solid,
    Vector3,
};

use super::adapter::CableOutlet;
use super::cable_openings::{HousingSide, wall_opening};
use super::mounting::{Mount, MountHold, MountRing, Mounting};
use super::posted_camera::{self, PostedCamera};
use super::{APART_MM, BLACK, INTO_MM, PRINTED_WALL_MM, Rect, ScrewJoint, WHITE, corners, hanging};
use crate::chain_builder::Name;
use crate::hardware::Screw;
use crate::materials::is_dark;
use crate::parameters::{RuleReport, limits};
use crate::sections;

sections! {
    /// Printed shell, which carries the pad and closes over the camera.
    pub struct Shell {
        /// Minimum width by which the shell stands out beyond the pad; a wide interior makes the shell wider.
        rim: Length = 0.0..=20.0,
        /// Minimum thickness of the shell's wall.
        wall: Length = 0.8..=10.0,
        /// Radius of the shell's upright edges.
        corner: Length = 0.2..=20.0,
        /// Radius of the upper rim's outer edge, around the pad; 0 for a sharp edge. The base's lower edge stays sharp,
        /// because the sensor stands on it and the screws' heads lie beside it.
        edge_fillet: Length = 0.0..=5.0,
        /// Side by which cable and wires leave the shell: `right` at +x, `left` at -x, `front` at -y, `back` at +y.
        cable_side: HousingSide,
        /// Width of the notch for cable and wires.
        cable_width: Length = 1.0..=30.0,
        /// Height of that notch.
        cable_height: Length = 1.0..=20.0,
        /// Material of the shell.
        material: String = 1..=80,
    }

    /// Printed base, which closes the shell and is screwed to a gripper.
    pub struct Base {
        /// Thickness of the base's floor.
        thickness: Length = 1.0..=20.0,
        /// Material of the base.
        material: String = 1..=80,
    }
}

/// Screw that joins base and shell.
const SCREW: Screw = Screw::M1_6X6;

/// Thickness of the base under the head of a screw, mm.
const SHELF_MM: f64 = 1.2;

/// Depth of a hole beyond its screw's tip, mm.
const PILOT_SPARE_MM: f64 = 0.5;

/// Width and height of the lip, mm.
const LIP_MM: [f64; 2] = [1.0, 1.5];

/// Outlines and heights of shell and base around a room, in the sensor frame, mm. The shell's upper rim is at z = 0.
#[derive(Clone, Debug)]
pub struct Clamshell<'a> {
    /// Parameters of the shell.
    pub shell: &'a Shell,
    /// Parameters of the base.
    pub base: &'a Base,
    /// Parameters of the mounting holes.
    pub mount: &'a Mount,
    /// Outer outline of both.
    pub outside: Rect,
    /// Outline of the room above the base; its corners leave walls around the screws.
    pub room: Rect,
    /// Height of the seam: bottom of the shell, top of the base's floor.
    pub joint_z: f64,
    /// Height of the base's underside.
    pub bottom_z: f64,
    /// Play of bodies that slide into the shell, mm.
    pub slide_mm: f64,
    /// Play of the screw heads in the base, mm.
    snug_mm: f64,
    /// Distances of the screws from the axes, mm.
    screw: [f64; 2],
}

impl<'a> Clamshell<'a> {
    /// Creates a clamshell around a carried body and a room (half edges of both), its seam at `joint_z`. `slide_mm` is
    /// the play of bodies that slide into the shell, `snug_mm` that of the screw heads in the base.
    pub fn around(
        (shell, base, mount): (&'a Shell, &'a Base, &'a Mount),
        [slide_mm, snug_mm]: [f64; 2],
        carried: [f64; 2],
        room: [f64; 2],
        joint_z: f64,
    ) -> Self {
        let half = [0, 1].map(|i| (carried[i] + shell.rim.mm()).max(room[i] + shell.wall.mm()));
        let screw = half.map(|half| half - head_mm(snug_mm) - PRINTED_WALL_MM);
        let room = Rect { half: room, corner: 0.0 };
        Self {
            shell,
            base,
            mount,
            outside: Rect { half, corner: shell.corner.mm() },
            room: room.rounded_off(screw, SCREW.pilot_hole_mm() / 2.0 + PRINTED_WALL_MM),
            joint_z,
            bottom_z: joint_z - base.thickness.mm(),
            slide_mm,
            snug_mm,
            screw,
        }
    }

    /// Returns the screws from below through the base's corners into the shell.
    pub fn joint(&self) -> ScrewJoint {
        let poses = corners(self.screw).map(|at| hanging(at, self.joint_z - SHELF_MM)).to_vec();
        ScrewJoint::self_tapping("screw", SCREW, poses, SCREW.length_mm + PILOT_SPARE_MM)
    }

    /// Returns half the edges of the area of the floor that holes must lie in, mm: just inside the lip.
    fn floor(&self) -> [f64; 2] {
        self.room.half.map(|half| half - self.slide_mm - LIP_MM[0] - APART_MM)
    }

    /// Returns the mounting holes in the base's floor, for screws that the user provides.
    fn holes(&self) -> Mounting<'a> {
        let axis = self.room.longer();
        let inside = self.room.half[axis] - self.slide_mm - LIP_MM[0];
        // Distance 0 stands in until the radius of a hole is known.
        let pair = Mounting {
            mount: self.mount,
            ring: MountRing::Pair(0.0, axis),
            depth_mm: self.base.thickness.mm() + CUT_OVERLAP_MM,
            is_through: true,
            holds: (&[MountHold::Tapped, MountHold::Insert, MountHold::Through], ""),
        };
        // The pair lies as far out as the lip allows.
        Mounting { ring: MountRing::Pair(inside - APART_MM - pair.hole_mm(), axis), ..pair }
    }

    /// Returns the mounting holes as a joint.
    pub fn mounting(&self) -> ScrewJoint {
        self.holes().joint(self.bottom_z)
    }

    /// Returns the notch for cable and wires, between two heights.
    fn notch(&self, heights: [f64; 2]) -> Solid {
        let side = self.shell.cable_side;
        let reach = [0.0, self.outside.half[side.axis()] + 1.0];
        wall_opening(side, self.shell.cable_width.mm(), reach, heights).named("cable notch")
    }

    /// Returns the exit of cable and wires, which an adapter plate has to leave free.
    pub fn exit(&self) -> CableOutlet {
        CableOutlet::Sideways {
            angle: self.shell.cable_side.angle(),
            width_mm: self.shell.cable_width.mm(),
            above_mm: self.joint_z - self.bottom_z,
        }
    }

    /// Returns the shell, with `cut` and, up to the ceiling at `room_z`, the room cut out of it.
    pub fn shell(&self, name: Name, cut: impl IntoIterator<Item = Solid>, room_z: f64) -> Body {
        let below = self.joint_z - CUT_OVERLAP_MM;
        let room = self.room.prism([below, room_z]).named("room");
        let notch = self.notch([below, self.joint_z + self.shell.cable_height.mm()]);
        let outside = self.outside.rimmed([self.joint_z, 0.0], self.shell.edge_fillet.mm());
        let solid = outside.minus_all(cut).minus(room).minus(notch);
        name.made(Process::Fdm, solid)
            .with_material(&self.shell.material)
            .colored(color(&self.shell.material))
            .note("standing as in use, no supports: what overhangs inside is at most 2 mm wide")
            .with_supports(false)
            .with_handles(1)
            .cut(self.joint().thread_cut().without_landmarks())
    }

    /// Returns the base with solids that stand on it.
    pub fn base(&self, name: Name, on_it: impl IntoIterator<Item = Solid>) -> Body {
        let (bottom, joint, [width, height]) = (self.bottom_z, self.joint_z, LIP_MM);
        let around = self.room.shrunk(self.slide_mm);
        let lip = Profile::new(around.path()).with_hole(around.shrunk(width).path());
        let lip = Solid::prism(lip, [joint - INTO_MM, joint + height])
            .minus(self.notch([joint, joint + height + CUT_OVERLAP_MM]));
        let floor = self.outside.prism([bottom, joint]);
        let solid = Solid::union([floor, lip.named("lip")].into_iter().chain(on_it));
        let sunk = self.base.thickness.mm() - SHELF_MM;
        name.made(Process::Fdm, solid)
            .with_material(&self.base.material)
            .colored(color(&self.base.material))
            .note("floor down, no supports: the screws' seats are short bridges")
            .with_supports(false)
            .note("the gripper's M3 screws cut their threads into the floor")
            .cut(self.joint().counterbore_cut(SHELF_MM, sunk, self.snug_mm).without_landmarks())
            .cut(self.mounting().thread_cut_through())
    }

    /// Returns the grip for fixtures: the whole clamshell; the notch defines its orientation.
    pub fn grip(&self) -> FixtureGrip {
        let notch_z = self.joint_z + self.shell.cable_height.mm() / 2.0;
        let out = self.shell.cable_side.out();
        let out_mm = self.outside.half[self.shell.cable_side.axis()];
        let notch = Point3::from(out_mm * out + Vector3::new(0.0, 0.0, notch_z));
        FixtureGrip {
            outline: self.outside.path(),
            top_z_mm: 0.0,
            bottom_z_mm: self.bottom_z,
            clear_radius_mm: 0.0,
            key: Some(Pose::z_to(out, notch)),
            threads: self.mounting().thread_cut().landmarks,
        }
    }

    /// Reports values with which the two parts cannot be made or joined. The sections must be called `shell` and
    /// `base`. Above `ceiling_z`, only the outline `open` at the upper rim may be cut out; the pad lies on the rim with
    /// the outline `carried`. The camera stands on the base.
    pub fn check(
        &self,
        ceiling_z: f64,
        [carried, open]: [Rect; 2],
        camera: &PostedCamera,
        report: &mut RuleReport,
    ) {
        let (shell, base) = (self.shell, self.base);
        let ceiling = ceiling_z - self.joint_z;
        let tip = SCREW.length_mm - SHELF_MM + PILOT_SPARE_MM;
        let pilot = SCREW.pilot_hole_mm() / 2.0 + PRINTED_WALL_MM;
        let side = self.shell.cable_side.axis();
        limits! { report:
            shell.corner <= head_mm(self.snug_mm) + PRINTED_WALL_MM,
                "the screws' heads need a wall at the rounded corner";
            base.thickness >= SHELF_MM + SCREW.head_height_mm() + APART_MM,
                "the screws' heads are sunk into the base";
            camera.back_clearance >= LIP_MM[1] + APART_MM,
                "the camera's board lies above the base's lip";
            shell.cable_height <= ceiling - PRINTED_WALL_MM, "the notch needs a wall above it";
            // The parameter is on both sides, so that the message states the value that satisfies the rule.
            camera.back_clearance >= camera.back_clearance.mm() + tip + PRINTED_WALL_MM - ceiling,
                "the shell's screws need a wall above their tips";
            shell.cable_width <=
                (2.0 * (self.screw[1 - side] - pilot)).min(self.room.straight(side)),
                "the notch lies in the straight wall between two screws";
            shell.edge_fillet <= shell.corner.mm(),
                "a rounded rim goes around the upright edges, which are at least as round";
        }
        for (room, because) in [
            (
                self.outside.inset_of(carried),
                "the pad lies on what a rounded edge leaves of the rim",
            ),
            (
                self.outside.inset_of(open) - PRINTED_WALL_MM / 2.0,
                "a wall around the plate must be left of the rim",
            ),
            (
                -self.joint_z - shell.cable_height.mm() - PRINTED_WALL_MM,
                "the edge must end above the notch",
            ),
        ] {
            report.at_most_or_absent("shell.edge_fillet", shell.edge_fillet, room, because);
        }
        let holes = self.holes();
        holes.check_in(self.floor(), PRINTED_WALL_MM, report);
        let posts = corners(camera.spacing_mm().map(|mm| mm / 2.0));
        let screw = (posted_camera::SCREW.pilot_hole_mm() / 2.0, "a screw of the camera");
        holes.check_clear(&posts, screw, PRINTED_WALL_MM, report);
        let head = (head_mm(self.snug_mm), "a screw of the shell");
        holes.check_clear(&corners(self.screw), head, PRINTED_WALL_MM, report);
        if self.mount.hold == MountHold::Insert {
            limits! { report:
                base.thickness >= holes.least_depth_mm(), "the inserts lie in the floor";
            }
        }
    }
}

/// Returns the radius of a screw's counterbore with play, mm.
fn head_mm(snug_mm: f64) -> f64 {
    SCREW.head_diameter_mm() / 2.0 + snug_mm
}

/// Returns the drawn colour of a plastic: black unless it is known to be light.
fn color(material: &str) -> Color {
    if is_dark(material) == Some(false) { WHITE } else { BLACK }
}
