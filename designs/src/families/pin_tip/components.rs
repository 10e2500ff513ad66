//! What is bought: camera, LEDs, O-ring, screws and bolts.

use fabkit_geometry::{Body, Color, Placement, Pose, Process, Solid};

use super::body::{BOARD_SCREW, BOLT, board_screw_poses, bolt_poses, led_pose};
use super::in_sensor;
use super::layout::Layout;
use super::parameters::PinTip;
use crate::fits::{Fit, gap_mm};
use crate::hardware::{ORing, SocketScrew};

const STEEL: Color = [176, 180, 186];
const BOARD_BLUE: Color = [40, 70, 130];
const RUBBER: Color = [30, 30, 30];

/// Length of thread that the robot's flange takes, mm.
const BOLT_BITE_MM: f64 = 6.0;

/// Free width around the plug below the camera board, mm.
const PLUG_MARGIN_MM: f64 = 2.0;

/// Length of an M5 bolt: through the plate and into the flange, as near as the standard's lengths
/// come.
fn bolt_length_mm(p: &PinTip) -> f64 {
    SocketScrew::length_near_mm(p.mount.plate.mm() + BOLT_BITE_MM)
}

/// The ring on the body's neck.
fn o_ring(p: &PinTip, layout: &Layout) -> ORing {
    let (cord_mm, inside_mm) = (p.seal.cord.mm(), 2.0 * layout.neck_radius);
    let stocked = ORing::on(cord_mm, inside_mm);
    // Only designs that break a constraint have none.
    stocked.unwrap_or(ORing { inside_mm, cord_mm, standard: "not stocked" })
}

/// Everything bought.
pub fn components(p: &PinTip, layout: &Layout) -> Vec<Body> {
    let at = |poses: Vec<Pose>, lift_mm: f64| -> Vec<Placement> {
        let place = |pose| Placement { assembly_from_body: pose, ..in_sensor() }.lifted(lift_mm);
        poses.into_iter().map(place).collect()
    };
    let bought = |name: &str, specification: String, solid, color, placements: Vec<Placement>| {
        Body::bought(name, specification, solid).placed(placements).one_per_place().colored(color)
    };
    let c = &p.camera;
    let (length, ring) = (bolt_length_mm(p), o_ring(p, layout));
    vec![
        bought(
            "led",
            p.leds.model.clone(),
            Solid::cuboid(p.leds.width.mm(), p.leds.length.mm(), p.leds.height.mm()),
            [250, 240, 170],
            at((0..p.leds.count).map(|i| led_pose(p, layout, i)).collect(), -7.0),
        ),
        bought(
            "o-ring",
            format!(
                "O-ring {} x {} mm, {}, silicone, black",
                ring.inside_mm, ring.cord_mm, ring.standard
            ),
            ring.between_planes(layout.neck_radius, layout.lens_bottom_z - layout.seal_z).at(
                0.0,
                0.0,
                (layout.lens_bottom_z + layout.seal_z) / 2.0,
            ),
            RUBBER,
            at(vec![Pose::identity()], 2.0),
        ),
        bought(
            "camera",
            format!(
                "{}, {} x {} px, statistics at {} Hz or images at {} Hz, M12 lens of {} mm ({} on \
                 a large chip)",
                c.model,
                c.pixels,
                c.pixels,
                c.statistics_rate,
                c.image_rate,
                c.focal_length.mm(),
                c.lens_view
            ),
            camera(p, layout),
            BOARD_BLUE,
            at(vec![Pose::identity()], -74.0),
        ),
        bought(
            "screw-m3x6",
            "pan head screw ISO 7045 M3x6".into(),
            BOARD_SCREW.solid(),
            STEEL,
            at(board_screw_poses(p, layout), -90.0),
        ),
        bought(
            "bolt-m5",
            format!("socket head screw ISO 4762 M5x{length}, and what the robot's maker demands"),
            BOLT.solid(length),
            STEEL,
            at(bolt_poses(p, layout), -92.0),
        ),
    ]
}

/// Board with four holes, lens holder and barrel above it, plug below.
fn camera(p: &PinTip, layout: &Layout) -> Solid {
    // Pieces of one body reach into each other, so that no faces coincide.
    let into = 0.2;
    let c = &p.camera;
    let (board, holder) = (c.board_size.mm(), c.holder_size.mm());
    let top = layout.camera_board_top_z;
    let holes = board_screw_poses(p, layout).into_iter().map(|pose| {
        BOARD_SCREW
            .clearance_tool(c.board_thickness.mm(), gap_mm(Process::Pcb, Fit::Snug))
            .placed(pose)
    });
    let plate = Solid::cuboid(board, board, c.board_thickness.mm())
        .at(0.0, 0.0, layout.camera_board_bottom_z)
        .minus_all(holes);
    let holder = Solid::cuboid(holder, holder, c.holder_height.mm() + into)
        .at(0.0, 0.0, top - into)
        .named("lens holder");
    let barrel = Solid::cylinder(
        c.barrel_diameter.mm() / 2.0,
        c.lens_height.mm() - c.holder_height.mm() + into,
    )
    .at(0.0, 0.0, top + c.holder_height.mm() - into)
    .named("lens barrel");
    let plug = Solid::cuboid(
        5.0,
        c.screw_spacing.mm() - BOARD_SCREW.head_diameter_mm() - PLUG_MARGIN_MM,
        p.body.wiring_room.mm() - PLUG_MARGIN_MM + into,
    )
    .at(0.0, 0.0, layout.camera_board_bottom_z - p.body.wiring_room.mm() + PLUG_MARGIN_MM)
    .named("plug");
    Solid::union([plate, holder, barrel, plug])
}
