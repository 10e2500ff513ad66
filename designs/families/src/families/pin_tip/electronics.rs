//! Bought components, the LED circuit, and the holder of the microcontroller.

use std::f64::consts::FRAC_PI_2;

use fabkit_geometry::{
    Angle, BoardPlacement, BoardSide, Body, CUT_OVERLAP_MM, Circuit, Color, Order, Path, Point3,
    Pose, Process, Solid,
};

use super::housing::led_poses;
use super::parameters::*;
use super::{Joints, PinTipLayout};
use crate::blocks::cable::{Cable, GIVE_WAY_MM};
use crate::blocks::circuit::{
    BoardWire, CHIP_0402, CircuitBuilder, LedPackage, TO_SUPPLY, along_y, camera_to_host,
    ring_region,
};
use crate::blocks::{INTO_MM, LED, MASK_GREEN, RUBBER, WHITE, board_camera, led_ring, turn};
use crate::chain_builder::{SENSOR, STEEL, in_sensor};
use crate::fits::{Fit, gap_mm};
use crate::parameters::{RuleReport, limits};

// ------ Components ------
//
// Bought components: camera, LEDs, O-ring, screws and bolts.

const BOARD_BLUE: Color = [40, 70, 130];

/// Free width around the plug below the camera board, mm.
const PLUG_MARGIN_MM: f64 = 2.0;

/// Returns all bought components.
pub fn components(p: &PinTip, layout: &PinTipLayout) -> Vec<Body> {
    let (c, joints) = (&p.camera, Joints::new(p, layout));
    let seat = layout.seal_seat(p);
    let below = |lift_mm: f64| move |pose: &Pose| SENSOR.at(*pose).lifted(lift_mm);
    let seal_z = (layout.lens_bottom_z_mm + layout.seal_z_mm) / 2.0;
    let height = layout.lens_bottom_z_mm - layout.seal_z_mm;
    let seal = seat.ring().between_planes(layout.neck_radius_mm, height);
    let ring_text = format!("{}, silicone, black", seat.order_text());
    let camera_text = format!(
        "{}, {} x {} px, statistics at {} Hz or images at {} Hz, M12 lens of {} mm ({} on a large \
         chip)",
        c.module.model,
        c.pixels,
        c.pixels,
        c.statistics_rate,
        c.image_rate,
        c.focal_length.mm(),
        c.lens_view
    );
    [
        vec![
            led_ring!(p.leds).body(led_poses(p, layout).iter().map(below(-7.0))),
            O_RING
                .bought(ring_text, seal.at_z(seal_z), [in_sensor().lifted(2.0)])
                .made_of("silicone rubber")
                .with_order(seat.ring().order())
                .colored(RUBBER)
                .with_assembly_compliance(seat.ring().max_stretch_mm()),
            CAMERA
                .bought(camera_text, camera(p, layout), [in_sensor().lifted(-74.0)])
                .with_order(Order::new(
                    &c.module.model,
                    format!("with lens of {} mm", c.focal_length.mm()),
                ))
                .placed([FOCUSING.in_place()])
                .with_tool_access(
                    board_camera!(p.camera).lens(layout.camera_board_top_z_mm).side_access(),
                )
                .colored(BOARD_BLUE),
            camera_cable(p, layout),
        ],
        joints.camera.bought(below(-90.0), below(-90.0)),
        vec![joints.robot.bought(below(-92.0))],
    ]
    .concat()
}

/// Length of the plug along x, mm.
const PLUG_MM: f64 = 5.0;

/// Diameter of eight wires in one sleeve, mm, if the slot has room for it.
const CABLE_MM: f64 = 4.0;

/// Number of wires to order, and length of each, mm.
const WIRE_COUNT: f64 = 8.0;
const WIRE_LENGTH_MM: f64 = 200.0;

/// Play of the cable in its slot, mm.
const CABLE_PLAY_MM: f64 = 0.4;

/// Bend radius of the cable, mm: twice its diameter, as it is not moved in use.
const BEND_MM: f64 = 8.0;

/// Drawn length of the cable beyond the housing, and then along it towards the controller, mm.
const CABLE_BEYOND_MM: [f64; 2] = [14.0, 20.0];

/// Returns the wires from the plug below the camera board, out of the slot and around the housing. They are threaded
/// before they are soldered, so they have no plug at their far end.
fn camera_cable(p: &PinTip, layout: &PinTipLayout) -> Body {
    let room = p.body.wiring_room.mm();
    let diameter =
        CABLE_MM.min(p.body.cable_slot_width.mm() - CABLE_PLAY_MM).min(room / 2.0 - CABLE_PLAY_MM);
    let z = layout.camera_board_bottom_z_mm - room / 2.0;
    // Starts beside the plug, which does not turn with the slot.
    let (sin, cos) = p.body.cable_angle.rad().sin_cos();
    let half = [PLUG_MM / 2.0, plug_width_mm(p) / 2.0];
    let beside = |half: f64, along: f64, across: f64| {
        (half + diameter / 2.0 * across.abs()) / along.abs().max(1e-9)
    };
    let start = beside(half[0], cos, sin).min(beside(half[1], sin, cos));
    let [out, around] = CABLE_BEYOND_MM;
    let out = layout.mount_joint.outer_radius + out;
    let corners = [[start, 0.0], [out, 0.0], [out, around]].map(|[x, y]| Point3::new(x, y, z));
    let cable = Cable { diameter_mm: diameter, bend_mm: BEND_MM, corners: corners.to_vec() };
    let text = format!("eight stranded wires in a sleeve of {diameter:.1} mm, 200 mm long");
    let place = SENSOR.at(Pose::rotation_z(p.body.cable_angle)).lifted(-74.0);
    let order =
        Order::new("stranded wire", "0.14 mm2, eight colours").cut_to(WIRE_COUNT * WIRE_LENGTH_MM);
    CAMERA_CABLE
        .bought(text, cable.solid(), [place])
        .with_order(order)
        .colored(RUBBER)
        .with_assembly_compliance(GIVE_WAY_MM)
}

/// Width of the plug across the board, mm.
fn plug_width_mm(p: &PinTip) -> f64 {
    let screw = Joints::CAMERA_SCREW;
    p.camera.screw_spacing_y.mm() - screw.head_diameter_mm() - PLUG_MARGIN_MM
}

/// Returns the camera: a board with four holes, lens holder and barrel above, plug below.
fn camera(p: &PinTip, layout: &PinTipLayout) -> Solid {
    let (c, room) = (&p.camera, p.body.wiring_room.mm());
    let screws = Joints::new(p, layout).camera;
    let gap = gap_mm(Process::Pcb, Fit::Snug);
    let tool = screws.screw.clearance_tool(c.board_thickness.mm(), gap);
    let holes = screws.poses.iter().map(|pose| tool.clone().placed(*pose)).collect();
    let plug = Solid::cuboid(PLUG_MM, plug_width_mm(p), room - PLUG_MARGIN_MM + INTO_MM)
        .at_z(layout.camera_board_bottom_z_mm - room + PLUG_MARGIN_MM)
        .named("plug");
    let heights = [layout.camera_board_bottom_z_mm, layout.camera_board_top_z_mm];
    board_camera!(p.camera).solid(heights, holes, plug)
}

// ------ Circuit ------
//
// Parts soldered to the ring of LEDs, and the wires that lead to it.

/// Size of a wire's pad along the ring, mm.
const PAD_LENGTH_MM: f64 = 1.4;
/// Largest size of a wire's pad across the ring, mm. The pad stays clear of the board's inner edge and of the ledge.
const PAD_WIDTH_MM: f64 = 0.8;
/// Clearance between a pad and the board's edge or the ledge, mm.
const PAD_CLEARANCE_MM: f64 = 0.21;

/// Builds the circuit: LEDs between supply and ground, each with its resistor, and wires on the lower side.
pub fn circuit(p: &PinTip, layout: &PinTipLayout) -> Circuit {
    let mut board = CircuitBuilder::new_on_board(LED_BOARD, &p.leds.electric);
    let package = LedPackage::Chip([p.leds.length.mm(), p.leds.width.mm()]);
    board.add_leds_with_resistors(
        &p.leds.electric,
        (&p.leds.model, package, LED),
        along_y(&led_poses(p, layout)),
        CHIP_0402,
        "leds.current_ma, or leds.resistor_ohms where that is not 0",
    );
    let inner = p.led_board.bore_radius.mm() + PAD_CLEARANCE_MM;
    let ledge = layout.shaft_bore_radius_mm.min(layout.board_radius_mm - PAD_CLEARANCE_MM);
    let width = (ledge - inner).min(PAD_WIDTH_MM);
    let radius = inner + width / 2.0;
    for (step, wire) in [0.5, -0.5].into_iter().zip(TO_SUPPLY) {
        // Between two LEDs, one wire on each side of the LED at angle 0.
        let angle = turn(0, p.leds.count, step).rad();
        let place = BoardPlacement {
            at_mm: [radius * angle.cos(), radius * angle.sin()],
            turn_rad: angle + FRAC_PI_2,
            side: BoardSide::Bottom,
        };
        board.wire(wire.0, BoardWire::without_body(place, [PAD_LENGTH_MM, width], wire));
    }
    let ledge = ring_region([layout.shaft_bore_radius_mm, layout.board_radius_mm + 1.0]);
    board.keep_out(BoardSide::Bottom, ledge, "the ledge of the body");
    board.test_points();
    board.connection(camera_to_host(
        "camera",
        Some(CAMERA_CABLE),
        None,
        "SPI and supply, eight wires",
    ));
    board.note("solder the wires to the lower side and lead them down the shaft");
    board.build()
}

// ------ Controller ------
//
// Microcontroller's board outside the housing, its holder, and the ties that keep it there.
//
// Everything is built with the outward radius along +x, then turned into place.

/// Distance from the ties inwards at which the saddle glued to the housing ends, mm.
const SADDLE_TIE_GAP_MM: f64 = 2.0;

/// Minimum half width of the saddle, and minimum height of the wall that it is glued to, mm.
const LEAST_SADDLE_MM: [f64; 2] = [4.0, 12.0];

/// Gap for glue between housing and saddle, mm. Meshes turn circles into polygons, which would overlap at equal
/// radii.
const GLUE_MM: f64 = 0.1;

/// Distance from the housing to the holder's back beside the saddle, mm. The ties pass through it.
const TIE_GAP_MM: f64 = 1.0;

/// Thickness of the holder's back and walls, mm.
const SADDLE_WALL_MM: f64 = 2.0;

/// Depth of the room behind the board for protruding solder joints, mm.
const SOLDER_MM: f64 = 3.0;

/// Depth of the ledges that carry the board's short edges, mm.
const LEDGE_MM: f64 = 2.0;

/// Play of the board in its holder on each side, mm.
const PLAY_MM: f64 = 0.15;

/// Distance from the housing's lower end to the holder's lower end, mm.
const HOLDER_RAISE_MM: f64 = 1.0;

/// Length by which an open tie yields to what it goes around, mm.
const TIE_GIVES_MM: f64 = 20.0;

/// Width and thickness of a cable tie, and distance of its centre from the board's end, mm. The tie passes beside the
/// socket.
const TIE_MM: [f64; 3] = [2.5, 1.1, 9.5];

/// Height of the board above its holder's front, mm. The plug's socket lies on the board.
const BOARD_RAISE_MM: f64 = 0.4;

/// Width, length and height of the plug's socket (mini-B), and its overhang beyond the board's end, mm.
const SOCKET_MM: [f64; 4] = [7.7, 9.2, 3.9, 1.2];

/// Width and height of the chips on the board between the ties, mm.
const CHIPS_MM: [f64; 2] = [11.0, 1.6];

/// Radial distances and heights of the controller's holder and board, mm.
struct ControllerGeometry {
    housing_radius: f64,
    /// Radius of the holder's back beside the saddle.
    back_radius: f64,
    /// Radii of the board's back, which lies on the ledges, and of its front.
    board_radii: [f64; 2],
    heights: [f64; 2],
    /// Half the board's length.
    half_length: f64,
}

impl ControllerGeometry {
    fn new(p: &PinTip, layout: &PinTipLayout) -> Self {
        let housing_radius = layout.mount_joint.outer_radius;
        let back_radius = housing_radius + TIE_GAP_MM;
        let ledge = back_radius + SADDLE_WALL_MM + SOLDER_MM;
        let bottom = layout.body_bottom_z_mm + p.body.edge_fillet.mm() + HOLDER_RAISE_MM;
        let top = bottom + SADDLE_WALL_MM + p.controller.width.mm() + 2.0 * PLAY_MM;
        Self {
            housing_radius,
            back_radius,
            board_radii: [ledge, ledge + p.controller.thickness.mm()],
            heights: [bottom, top],
            half_length: p.controller.length.mm() / 2.0,
        }
    }

    /// Distance of a tie from the board's middle.
    fn tie_offset(&self) -> f64 {
        self.half_length - TIE_MM[2]
    }

    /// Half the width of the saddle.
    fn saddle_half_width(&self) -> f64 {
        self.tie_offset() - SADDLE_TIE_GAP_MM
    }

    /// Returns the holder: one block that prints along the axis without overhangs.
    fn holder(&self) -> Solid {
        let [bottom, top] = self.heights;
        let ([ledge, board], wide) = (self.board_radii, self.saddle_half_width());
        let front = board - BOARD_RAISE_MM;
        let inside = self.half_length + PLAY_MM;
        let end = inside + SADDLE_WALL_MM;
        let saddle = ((self.housing_radius + GLUE_MM).powi(2) - wide.powi(2)).sqrt();
        let outline = Path::from([saddle, -wide])
            .line([self.back_radius, -wide])
            .line([self.back_radius, -end])
            .line([front, -end])
            .line([front, end])
            .line([self.back_radius, end])
            .line([self.back_radius, wide])
            .line([saddle, wide])
            .arc([saddle, -wide], [0.0, 0.0], false)
            .close();
        let floor = bottom + SADDLE_WALL_MM;
        let above = top + CUT_OVERLAP_MM;
        let room = |from: f64, half: f64, to: f64| {
            Solid::cuboid_between([from, -half, floor], [to, half, above])
        };
        let bed = room(ledge, inside, front + CUT_OVERLAP_MM).named("board");
        let behind = room(ledge - SOLDER_MM, self.half_length - LEDGE_MM, ledge + CUT_OVERLAP_MM);
        Solid::extrusion(outline, top - bottom)
            .at_z(bottom)
            .minus_all([bed, behind.named("solder room")])
    }

    /// Returns the board with its chips and the socket of its plug.
    fn board(&self, p: &PinTip) -> Solid {
        let [back, front] = self.board_radii;
        let low = self.heights[0] + SADDLE_WALL_MM + PLAY_MM;
        let [middle, high] = [low + p.controller.width.mm() / 2.0, low + p.controller.width.mm()];
        let plate =
            Solid::cuboid_between([back, -self.half_length, low], [front, self.half_length, high]);
        let [width, length, height, out] = SOCKET_MM;
        let end = self.half_length + out;
        let on_board = |y: [f64; 2], half: f64, height: f64| {
            Solid::cuboid_between(
                [front - INTO_MM, y[0], middle - half],
                [front + height, y[1], middle + half],
            )
        };
        let socket = on_board([end - length, end], width / 2.0, height).named("socket");
        let [across, height] = CHIPS_MM;
        let chips = self.saddle_half_width();
        let chips = on_board([-chips, chips], across / 2.0, height).named("chips");
        Solid::union([plate, socket, chips])
    }

    /// Returns a tie around board and holder, at y = 0.
    fn tie(&self) -> Solid {
        let [width, thick, _] = TIE_MM;
        let ([low, high], [back, front]) = (self.heights, [self.back_radius, self.board_radii[1]]);
        let half = width / 2.0;
        let outside = Solid::cuboid_between(
            [back - thick, -half, low - thick],
            [front + thick, half, high + thick],
        );
        let half = half + CUT_OVERLAP_MM;
        outside.minus(Solid::cuboid_between([back, -half, low], [front, half, high]))
    }
}

/// Pose of the controller around the axis: a quarter turn after the cable's slot, from which its wires come.
fn controller_pose(p: &PinTip) -> Pose {
    let rad = p.body.cable_angle.rad() + FRAC_PI_2;
    Pose::rotation_z(Angle::from_rad(rad).expect("a sum of finite angles"))
}

/// Returns whether a microcontroller is seated on the housing.
pub fn has_controller(p: &PinTip) -> bool {
    p.controller.seat == ControllerSeat::Housing
}

/// Returns holder, board and ties; empty if there is no controller on the housing.
pub fn controller_bodies(p: &PinTip, layout: &PinTipLayout) -> Vec<Body> {
    if !has_controller(p) {
        return Vec::new();
    }
    let (seat, turn) = (ControllerGeometry::new(p, layout), controller_pose(p));
    let holder = CONTROLLER_HOLDER
        .made(Process::Fdm, seat.holder())
        .with_material(&p.body.material)
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
        .with_order(Order::new(&c.model, ""))
        .colored(MASK_GREEN);
    let width = TIE_MM[0];
    let ties = [-seat.tie_offset(), seat.tie_offset()]
        .map(|y| SENSOR.at(turn.then_in(Pose::translation(0.0, y, 0.0))).lifted(-46.0));
    let tie = CABLE_TIE
        .bought(format!("cable tie, {width} mm wide, 100 mm long"), seat.tie(), ties)
        .with_order(Order::new("cable tie", format!("{width} mm wide, 100 mm long")))
        .colored(STEEL)
        .with_assembly_compliance(TIE_GIVES_MM)
        .as_fastener()
        .with_handles(1);
    vec![holder, board, tie]
}

/// Reports a board for which its holder or the housing has no room.
pub fn check_controller(p: &PinTip, layout: &PinTipLayout, report: &mut RuleReport) {
    if !has_controller(p) {
        return;
    }
    let wall = layout.cone_bottom_z_mm - layout.body_bottom_z_mm - 2.0 * p.body.edge_fillet.mm();
    let [half, height] = LEAST_SADDLE_MM;
    limits! { report, p:
        controller.length >= 2.0 * (half + SADDLE_TIE_GAP_MM + TIE_MM[2]),
            "its ties lie between the saddle and the plug's socket";
        body.wiring_room >= p.body.wiring_room.mm() + height - wall,
            "the controller's holder needs 12 mm of the housing's round wall; `controller.seat` may be none";
    }
}
