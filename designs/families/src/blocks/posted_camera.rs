//! Small camera on posts: its board is screwed to a base, and it looks along +z at a plane.

use fabkit_geometry::{Body, Length, Process, Solid};

use super::board_camera::Board;
use super::optics::{ImageFormat, Module, View};
use super::{APART_MM, INTO_MM, PRINTED_WALL_MM, Rect, ScrewJoint, copies, corners, upright};
use crate::fits::{Fit, gap_mm};
use crate::hardware::Screw;
use crate::parameters;
use crate::parameters::{Inline, RuleReport, limits};

parameters! {
    /// Camera and its board. The camera's distance follows from the pixel pitch.
    pub struct PostedCamera {
        /// Camera module.
        module: Inline<Module>,
        /// Images of the camera.
        images: Inline<ImageFormat>,
        /// View of the camera's lens.
        view: Inline<View>,
        /// Distance between neighbouring pixels on the observed surface, in the middle of the image, for straight rays.
        pixel_pitch: Length = 0.001..=1.0,
        /// Board and lens of the camera.
        board: Inline<Board>,
        /// Free height behind the camera board for connector and cable, which is the height of the posts.
        back_clearance: Length = 1.0..=20.0,
    }
}

/// Screw that holds the board.
pub const SCREW: Screw = Screw::M1_6X5;

/// Depth of a hole beyond its screw's tip, mm.
const PILOT_SPARE_MM: f64 = 0.5;

/// Space between connector and base, mm.
const CONNECTOR_ABOVE_MM: f64 = 0.5;

/// Smallest edge of a connector for a flat cable, mm.
const LEAST_CONNECTOR_MM: f64 = 2.0;

/// Smallest thickness of the base below the end of a screw's hole, mm.
const FLOOR_MM: f64 = 0.4;

/// Camera above its base; heights in the sensor frame, mm.
#[derive(Clone, Debug)]
pub struct PlacedCamera<'a> {
    /// Parameters of the camera.
    pub camera: &'a PostedCamera,
    /// Height of the optical centre.
    pub pupil_z: f64,
    /// Height of the lens's front.
    pub front_z: f64,
    /// Height of the board's top.
    pub top_z: f64,
    /// Height of the board's bottom, which rests on the posts.
    pub bottom_z: f64,
    /// Height of the posts' feet: the top of the base.
    pub foot_z: f64,
    /// Play between the posts and the connector, mm.
    pub play_mm: f64,
}

impl PostedCamera {
    /// Returns the angle that a pixel at the image's centre covers, rad.
    pub fn rad_per_px(&self) -> f64 {
        self.view.rad_per_px(self.images.size_px())
    }

    /// Places the camera in front of a plane at height `seen_z`, so that a pixel covers `pixel_pitch` on it; the base
    /// keeps `play_mm` around the connector.
    pub fn in_front_of(&self, seen_z: f64, play_mm: f64) -> PlacedCamera<'_> {
        let pupil_z = seen_z - self.pixel_pitch.mm() / self.rad_per_px();
        let front_z = pupil_z + self.board.pupil_behind_front.mm();
        let top_z = front_z - self.board.lens_height.mm();
        let bottom_z = top_z - self.board.board_thickness.mm();
        let foot_z = bottom_z - self.back_clearance.mm();
        PlacedCamera { camera: self, pupil_z, front_z, top_z, bottom_z, foot_z, play_mm }
    }

    /// Returns the radius of a hole that the lens's holder passes, mm. The hole is in a circuit board, so that its gap
    /// does not depend on the processes that a file assigns to parts.
    pub fn bore_mm(&self) -> f64 {
        // Half the diagonal of the square holder.
        let holder = self.board.holder_size.mm() / 2f64.sqrt();
        holder.max(self.board.barrel_diameter.mm() / 2.0) + gap_mm(Process::Fdm, Fit::Free)
    }

    /// Returns the distances of the screws along x and y, mm.
    pub fn spacing_mm(&self) -> [f64; 2] {
        [self.board.screw_spacing, self.board.screw_spacing_y].map(Length::mm)
    }

    /// Returns the edges of the board along x and y, mm.
    pub fn board_mm(&self) -> [f64; 2] {
        [self.board.board_size, self.board.board_size_y].map(Length::mm)
    }
}

/// Returns the radius of a post, mm.
fn post_mm() -> f64 {
    SCREW.pilot_hole_mm() / 2.0 + PRINTED_WALL_MM
}

impl PlacedCamera<'_> {
    /// Returns the screws through the board's corners.
    pub fn joint(&self) -> ScrewJoint {
        let half = self.camera.spacing_mm().map(|mm| mm / 2.0);
        let poses = corners(half).map(|at| upright(at, self.top_z)).to_vec();
        ScrewJoint::self_tapping("camera screw", SCREW, poses, SCREW.length_mm + PILOT_SPARE_MM)
    }

    /// Returns the edges of the connector behind the board, mm: it lies between the posts.
    fn connector_mm(&self) -> [f64; 2] {
        self.camera.spacing_mm().map(|mm| mm - 2.0 * (post_mm() + self.play_mm))
    }

    /// Returns the posts, which are added to the base.
    pub fn posts(&self) -> Vec<Solid> {
        let half = self.camera.spacing_mm().map(|mm| mm / 2.0);
        let post = Solid::rod(post_mm(), [self.foot_z - INTO_MM, self.bottom_z]);
        copies("post", &corners(half).map(|at| upright(at, 0.0)), &post)
    }

    /// Returns the camera; its family places it.
    pub fn body(&self) -> Body {
        let c = self.camera;
        let thickness = c.board.board_thickness.mm();
        let holes = self.joint().clearance_cut(thickness, gap_mm(Process::Pcb, Fit::Snug));
        let ([x, y], bottom) = (self.connector_mm(), self.foot_z + CONNECTOR_ABOVE_MM);
        let connector = Solid::cuboid(x, y / 2.0, self.bottom_z + INTO_MM - bottom)
            .at_z(bottom)
            .named("connector");
        let heights = [self.bottom_z, self.top_z];
        let which = (&*c.module, &*c.images, &*c.view);
        c.board.bought(which, heights, holes.tools, connector)
    }

    /// Reports a camera that cannot be assembled on a base `base_mm` thick, in a room. The section must be called
    /// `camera`; `from` are the paths of the parameters that set the room's edges.
    pub fn check(&self, base_mm: f64, room: Rect, from: &[&str], report: &mut RuleReport) {
        let camera = &*self.camera.board;
        let head = SCREW.head_diameter_mm() / 2.0;
        let bite = SCREW.length_mm + PILOT_SPARE_MM - camera.board_thickness.mm();
        limits! { report:
            camera.holder_height <= camera.lens_height.mm(), "the lens stands out of its holder";
            camera.barrel_diameter <= camera.holder_size.mm(), "the lens stands on its holder";
            camera.screw_spacing >= camera.holder_size.mm() + 2.0 * (head + APART_MM),
                "the screws' heads lie beside the lens's holder";
            camera.screw_spacing >=
                camera.screw_spacing.mm() + LEAST_CONNECTOR_MM - self.connector_mm()[0],
                "the connector lies between the posts";
            camera.screw_spacing <= camera.board_size.mm() - SCREW.clearance_hole_mm() - 1.0,
                "the screws' holes need half a millimetre of board around them";
        }
        let posts = bite + FLOOR_MM - base_mm;
        let because = "the camera's M1.6x5 screws end inside posts and base";
        report.at_least("camera.back_clearance", self.camera.back_clearance, posts, because);
        // Square boards would only get the same messages twice.
        if camera.screw_spacing != camera.screw_spacing_y
            || camera.board_size != camera.board_size_y
        {
            limits! { report:
                camera.screw_spacing_y >= camera.holder_size.mm() + 2.0 * (head + APART_MM),
                    "the screws' heads lie beside the lens's holder";
                camera.screw_spacing_y >= camera.screw_spacing_y.mm() + LEAST_CONNECTOR_MM
                    - self.connector_mm()[1],
                    "the connector lies between the posts";
                camera.screw_spacing_y <=
                    camera.board_size_y.mm() - SCREW.clearance_hole_mm() - 1.0,
                    "the screws' holes need half a millimetre of board around them";
            }
        }
        report.require(
            room.holds(self.camera.board_mm().map(|mm| mm / 2.0), APART_MM),
            "camera.board_size",
            || {
                format!(
                    "camera.board_size is {} by {}; its corners meet the walls of its room, {:.2} x {:.2} mm \
                     with round corners of {:.2} mm",
                    camera.board_size,
                    camera.board_size_y,
                    2.0 * room.half[0],
                    2.0 * room.half[1],
                    room.corner
                )
            },
            || format!("take a smaller board, or change `{}`", from.join("` or `")),
        );
    }
}
