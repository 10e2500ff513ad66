//! The microcontroller's board outside of the housing, its holder, and the ties that keep it there.
//!
//! Everything is built with the radius that points at it along +x, and turned from there.

use std::f64::consts::FRAC_PI_2;

use fabkit_geometry::{Angle, Body, CUT_OVERLAP_MM, Order, Path, Pose, Process, Solid};

use super::bodies::*;
use super::layout::Layout;
use super::parameters::{ControllerSeat, PinTip};
use crate::assembling::SENSOR;
use crate::blocks::{INTO_MM, MASK_GREEN, STEEL, WHITE};
use crate::parameters::{Report, limits};

/// How far inside of the ties the saddle that is glued to the housing ends, mm.
const SADDLE_INSIDE_MM: f64 = 2.0;

/// Least half of the saddle's width, and least height of the wall that it is glued to, mm.
const LEAST_SADDLE_MM: [f64; 2] = [4.0, 12.0];

/// Glue between the housing and the saddle, mm: printed as polygons, equal radii would overlap.
const GLUE_MM: f64 = 0.1;

/// From the housing to the holder's back beside the saddle, mm: ties pass.
const BACK_MM: f64 = 1.0;

/// Thickness of the holder's back and of its walls, mm.
const WALL_MM: f64 = 2.0;

/// Room behind the board, mm: what is soldered through it stands out there.
const SOLDER_MM: f64 = 3.0;

/// Depth of the ledges that the board's short edges lie on, mm.
const LEDGE_MM: f64 = 2.0;

/// Play of the board in its holder, mm on each side.
const PLAY_MM: f64 = 0.15;

/// From the housing's lower end to the holder's, mm.
const ABOVE_END_MM: f64 = 1.0;

/// How far a tie that is not closed yet gives way to what it goes around, mm.
const OPEN_MM: f64 = 20.0;

/// Width and thickness of a cable tie, and how far its middle lies inside of the board's end, mm: beside the
/// socket.
const TIE_MM: [f64; 3] = [2.5, 1.1, 9.5];

/// How far the board stands out of its holder, mm: the plug's socket lies on it.
const PROUD_MM: f64 = 0.4;

/// Width, length, height of the plug's socket, and how far it stands out of the board, mm: mini-B.
const SOCKET_MM: [f64; 4] = [7.7, 9.2, 3.9, 1.2];

/// Width and height of where chips stand on the board, between the ties, mm.
const CHIPS_MM: [f64; 2] = [11.0, 1.6];

/// Distances from the axis and heights, mm.
struct Seat {
    housing: f64,
    /// The holder's back beside the saddle.
    back: f64,
    /// What the board lies on, and its far side, where the holder ends too.
    board: [f64; 2],
    heights: [f64; 2],
    /// Half the board's length.
    half: f64,
}

impl Seat {
    fn new(p: &PinTip, layout: &Layout) -> Self {
        let housing = layout.mount_joint.outer_radius;
        let back = housing + BACK_MM;
        let ledge = back + WALL_MM + SOLDER_MM;
        let bottom = layout.body_bottom_z_mm + p.body.edge_fillet.mm() + ABOVE_END_MM;
        let top = bottom + WALL_MM + p.controller.width.mm() + 2.0 * PLAY_MM;
        Self {
            housing,
            back,
            board: [ledge, ledge + p.controller.thickness.mm()],
            heights: [bottom, top],
            half: p.controller.length.mm() / 2.0,
        }
    }

    /// How far from the middle a tie lies.
    fn aside(&self) -> f64 {
        self.half - TIE_MM[2]
    }

    /// Half the width of the saddle.
    fn saddle(&self) -> f64 {
        self.aside() - SADDLE_INSIDE_MM
    }

    /// One block as a print that grows along the axis: nothing hangs over.
    fn holder(&self) -> Solid {
        let [bottom, top] = self.heights;
        let ([ledge, board], wide) = (self.board, self.saddle());
        let front = board - PROUD_MM;
        let inside = self.half + PLAY_MM;
        let end = inside + WALL_MM;
        let saddle = ((self.housing + GLUE_MM).powi(2) - wide.powi(2)).sqrt();
        let outline = Path::from([saddle, -wide])
            .line([self.back, -wide])
            .line([self.back, -end])
            .line([front, -end])
            .line([front, end])
            .line([self.back, end])
            .line([self.back, wide])
            .line([saddle, wide])
            .arc([saddle, -wide], [0.0, 0.0], false)
            .close();
        let floor = bottom + WALL_MM;
        let above = top + CUT_OVERLAP_MM;
        let room = |from: f64, half: f64, to: f64| {
            Solid::cuboid_between([from, -half, floor], [to, half, above])
        };
        let bed = room(ledge, inside, front + CUT_OVERLAP_MM).named("board");
        let behind = room(ledge - SOLDER_MM, self.half - LEDGE_MM, ledge + CUT_OVERLAP_MM);
        Solid::extrusion(outline, top - bottom)
            .at_z(bottom)
            .minus_all([bed, behind.named("solder room")])
    }

    /// Board with its chips and the socket of its plug.
    fn board(&self, p: &PinTip) -> Solid {
        let [back, front] = self.board;
        let low = self.heights[0] + WALL_MM + PLAY_MM;
        let [middle, high] = [low + p.controller.width.mm() / 2.0, low + p.controller.width.mm()];
        let plate = Solid::cuboid_between([back, -self.half, low], [front, self.half, high]);
        let [width, length, height, out] = SOCKET_MM;
        let end = self.half + out;
        let on_board = |y: [f64; 2], half: f64, height: f64| {
            Solid::cuboid_between(
                [front - INTO_MM, y[0], middle - half],
                [front + height, y[1], middle + half],
            )
        };
        let socket = on_board([end - length, end], width / 2.0, height).named("socket");
        let [across, height] = CHIPS_MM;
        let chips = self.saddle();
        let chips = on_board([-chips, chips], across / 2.0, height).named("chips");
        Solid::union([plate, socket, chips])
    }

    /// A tie around board and holder, at y = 0.
    fn tie(&self) -> Solid {
        let [width, thick, _] = TIE_MM;
        let ([low, high], [back, front]) = (self.heights, [self.back, self.board[1]]);
        let half = width / 2.0;
        let outside = Solid::cuboid_between(
            [back - thick, -half, low - thick],
            [front + thick, half, high + thick],
        );
        let half = half + CUT_OVERLAP_MM;
        outside.minus(Solid::cuboid_between([back, -half, low], [front, half, high]))
    }
}

/// Where it is around the axis: a quarter turn after the cable's slot, whose wires lead to it.
fn turn(p: &PinTip) -> Pose {
    let rad = p.body.cable_angle.rad() + FRAC_PI_2;
    Pose::rotation_z(Angle::from_rad(rad).expect("a sum of finite angles"))
}

/// Whether there is one.
pub fn is_there(p: &PinTip) -> bool {
    p.controller.seat == ControllerSeat::Housing
}

/// Holder, board and ties, if there are any.
pub fn bodies(p: &PinTip, layout: &Layout) -> Vec<Body> {
    if !is_there(p) {
        return Vec::new();
    }
    let (seat, turn) = (Seat::new(p, layout), turn(p));
    let holder = CONTROLLER_HOLDER
        .made(Process::Fdm, seat.holder())
        .from(&p.body.material)
        .placed([SENSOR.at(turn).lifted(-46.0)])
        .colored(WHITE)
        .note("print it standing on its floor, as it stands in use, without support")
        .with_supports(false);
    let c = &p.controller;
    let text = format!(
        "{}, {} x {} x {} mm, wires soldered in place of its pins",
        c.model,
        c.length.mm(),
        c.width.mm(),
        c.thickness.mm()
    );
    let board = CONTROLLER
        .bought(text, seat.board(p), [SENSOR.at(turn).lifted(-46.0)])
        .ordered(Order::of(&c.model, ""))
        .colored(MASK_GREEN);
    let width = TIE_MM[0];
    let ties = [-seat.aside(), seat.aside()]
        .map(|y| SENSOR.at(turn.then_in(Pose::translation(0.0, y, 0.0))).lifted(-46.0));
    let tie = CABLE_TIE
        .bought(format!("cable tie, {width} mm wide, 100 mm long"), seat.tie(), ties)
        .ordered(Order::of("cable tie", format!("{width} mm wide, 100 mm long")))
        .colored(STEEL)
        .giving(OPEN_MM)
        .fastening()
        .with_handles(1);
    vec![holder, board, tie]
}

/// Reports a board that its holder or the housing has no room for.
pub fn check(p: &PinTip, layout: &Layout, report: &mut Report) {
    if !is_there(p) {
        return;
    }
    let wall = layout.cone_bottom_z_mm - layout.body_bottom_z_mm - 2.0 * p.body.edge_fillet.mm();
    let [half, height] = LEAST_SADDLE_MM;
    limits! { report, p:
        controller.length >= 2.0 * (half + SADDLE_INSIDE_MM + TIE_MM[2]),
            "its ties lie between the saddle and the plug's socket";
        body.wiring_room >= p.body.wiring_room.mm() + height - wall,
            "the controller's holder needs 12 mm of the housing's round wall; `controller.seat` may be none";
    }
}
