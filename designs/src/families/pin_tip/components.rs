//! What is bought: camera, LEDs, O-ring, screws and bolts.

use fabkit_geometry::{Body, Color, Pose, Process, Solid};

use super::bodies::*;
use super::body::led_poses;
use super::joints::Joints;
use super::layout::Layout;
use super::parameters::PinTip;
use crate::assembling::{SENSOR, in_sensor};
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
        c.model,
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
                .colored(RUBBER)
                .giving(seat.ring().gives_mm()),
            CAMERA
                .bought(camera_text, camera(p, layout), [in_sensor().lifted(-74.0)])
                .placed([FOCUSING.in_place()])
                .colored(BOARD_BLUE),
        ],
        joints.camera.bought(below(-90.0), below(-90.0)),
        vec![joints.robot.bought(below(-92.0))],
    ]
    .concat()
}

/// Board with four holes, lens holder and barrel above it, plug below.
fn camera(p: &PinTip, layout: &Layout) -> Solid {
    let (c, room) = (&p.camera, p.body.wiring_room.mm());
    let screws = Joints::new(p, layout).camera;
    let gap = gap_mm(Process::Pcb, Fit::Snug);
    let tool = screws.screw.clearance_tool(c.board_thickness.mm(), gap);
    let holes = screws.poses.iter().map(|pose| tool.clone().placed(*pose)).collect();
    let heads = c.screw_spacing_y.mm() - screws.screw.head_diameter_mm();
    let plug = Solid::cuboid(5.0, heads - PLUG_MARGIN_MM, room - PLUG_MARGIN_MM + INTO_MM)
        .at_z(layout.camera_board_bottom_z_mm - room + PLUG_MARGIN_MM)
        .named("plug");
    let heights = [layout.camera_board_bottom_z_mm, layout.camera_board_top_z_mm];
    board_camera!(p.camera).solid(heights, holes, plug)
}
