//! What is bought: camera, LEDs, O-ring, screws and bolts.

use fabkit_geometry::{Body, Color, Order, Point3, Pose, Process, Solid};

use super::bodies::*;
use super::body::led_poses;
use super::joints::Joints;
use super::layout::Layout;
use super::parameters::PinTip;
use crate::assembling::{SENSOR, in_sensor};
use crate::blocks::cable::{Cable, GIVES_MM};
use crate::blocks::{INTO_MM, RUBBER, board_camera, led_ring};
use crate::fits::{Fit, gap_mm};

const BOARD_BLUE: Color = [40, 70, 130];

/// Free width around the plug below the camera board, mm.
const PLUG_MARGIN_MM: f64 = 2.0;

/// Everything bought.
pub fn components(p: &PinTip, layout: &Layout) -> Vec<Body> {
    let (c, joints) = (&p.camera, Joints::new(p, layout));
    let seat = layout.seal_seat(p);
    let below = |lift_mm: f64| move |pose: &Pose| SENSOR.at(*pose).lifted(lift_mm);
    let seal_z = (layout.lens_bottom_z_mm + layout.seal_z_mm) / 2.0;
    let height = layout.lens_bottom_z_mm - layout.seal_z_mm;
    let seal = seat.ring().between_planes(layout.neck_radius_mm, height);
    let ring_text = format!("{}, silicone, black", seat.ordered());
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
                .ordered(seat.ring().order())
                .colored(RUBBER)
                .giving(seat.ring().gives_mm()),
            CAMERA
                .bought(camera_text, camera(p, layout), [in_sensor().lifted(-74.0)])
                .ordered(Order::of(
                    &c.module.model,
                    format!("with lens of {} mm", c.focal_length.mm()),
                ))
                .placed([FOCUSING.in_place()])
                .reached(
                    board_camera!(p.camera).lens(layout.camera_board_top_z_mm).turned_from_sides(),
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

/// Diameter of eight wires in one sleeve, mm, where the slot has room for it.
const CABLE_MM: f64 = 4.0;

/// How many wires, and how long each is, mm, as they are ordered.
const WIRES: f64 = 8.0;
const WIRE_MM: f64 = 200.0;

/// Play of the cable in its slot, mm.
const CABLE_PLAY_MM: f64 = 0.4;

/// Bend radius of the cable, mm: twice its diameter, as it is not moved in use.
const BEND_MM: f64 = 8.0;

/// How far the cable goes on beyond the housing, and along it towards the controller, mm.
const CABLE_BEYOND_MM: [f64; 2] = [14.0, 20.0];

/// The wires from the plug below the camera's board, out of the slot and around the housing: they are
/// threaded before they are soldered, without a plug at their far end.
fn camera_cable(p: &PinTip, layout: &Layout) -> Body {
    let room = p.body.wiring_room.mm();
    let diameter =
        CABLE_MM.min(p.body.cable_slot_width.mm() - CABLE_PLAY_MM).min(room / 2.0 - CABLE_PLAY_MM);
    let z = layout.camera_board_bottom_z_mm - room / 2.0;
    // Beside the plug, whose sides do not turn with the slot.
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
    let order = Order::of("stranded wire", "0.14 mm2, eight colours").cut_to(WIRES * WIRE_MM);
    CAMERA_CABLE
        .bought(text, cable.solid(), [place])
        .ordered(order)
        .colored(RUBBER)
        .giving(GIVES_MM)
}

/// Width of the plug across the board, mm.
fn plug_width_mm(p: &PinTip) -> f64 {
    let screw = Joints::SCREW;
    p.camera.screw_spacing_y.mm() - screw.head_diameter_mm() - PLUG_MARGIN_MM
}

/// Board with four holes, lens holder and barrel above it, plug below.
fn camera(p: &PinTip, layout: &Layout) -> Solid {
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
