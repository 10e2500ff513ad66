//! Bought components, their wiring, and the routing of cables.

use fabkit_geometry::{
    Body, CUT_OVERLAP_MM, Circuit, Order, Placement, Point3, Pose, Process, Solid, Vector3,
    format_rounded,
};

use super::housing::{BAR_EXPLODE_MM, sensor_from_wall};
use super::layers::{Side, display_channel_y, display_inlet, tube_poses};
use super::parameters::*;
use super::{CORNER_FASTENERS, Joints, SheetMoldLayout, camera_board_top_mm};
use crate::blocks::cable::{Cable, GIVE_WAY_MM};
use crate::blocks::cable_openings::HousingSide as CableSide;
use crate::blocks::circuit::{CircuitBuilder, camera_to_host};
use crate::blocks::{
    APART_MM, BRASS, CAMERA_GREEN, INTO_MM, LED_YELLOW, RUBBER, board_camera, merged, upright,
};
use crate::chain_builder::{Name, SENSOR, flipped};
use crate::fits::{Fit, gap_mm};
use crate::hardware::HexSpacer;
use crate::parameters::{RuleReport, limits};

// ------ Components ------
//
// Bought components: cameras, screws, spacers, tubes, needles, LEDs.

/// Length of tube drawn at either end, mm.
const TUBE_STUB_MM: f64 = 20.0;

/// Height of an LED strip's centre above the box's floor, mm: below the camera's lens.
const LED_HEIGHT_MM: f64 = 14.0;

/// Returns screws and nuts: those of the cameras, then those of the corners.
fn fasteners(p: &SheetMold, layout: &SheetMoldLayout, cameras: &[Placement; 2]) -> Vec<Body> {
    let joints = Joints::new(p, layout);
    let on_cameras = cameras.iter().flat_map(|camera| {
        let drawn_out = |out_mm: f64| move |pose: &Pose| on_camera_plate(camera, *pose, out_mm);
        joints.camera.bought(drawn_out(-40.0), drawn_out(8.0))
    });
    let is_upright = |pose: &Pose| pose.vector(Vector3::z()).z > 0.0;
    let in_box = |pose: &Pose| {
        let aside = BAR_EXPLODE_MM.y * pose.translation_mm().y.signum();
        let above = Vector3::new(0.0, aside, BAR_EXPLODE_MM.z);
        let place = SENSOR.at(*pose);
        if is_upright(pose) { place.moved_apart(above).lifted(16.0) } else { place.lifted(-52.0) }
    };
    let on_display = |pose: &Pose| {
        let lift_mm = if is_upright(pose) { 112.0 } else { -16.0 };
        SENSOR.at(layout.sensor_from_display.then_in(*pose)).lifted(lift_mm)
    };
    let in_use =
        [joints.housing.bought(in_box, in_box), joints.display.bought(on_display, on_display)];
    let needed = joints.housing.poses.len() + joints.display.poses.len();
    let molds = [CHANNEL_MOLD, MARKER_MOLD].into_iter().zip(&joints.stacks);
    let in_molds = molds.flat_map(|(mold, stack)| {
        stack.bought(|pose| mold.at(*pose).lifted(-34.0), |pose| mold.at(*pose).lifted(30.0))
    });
    let mut all = merged(on_cameras.chain(in_use.concat()).chain(in_molds));
    // The molds borrow the sensor's screws, because both are not needed at the same time.
    if let Some(screw) = all.iter_mut().find(|body| body.summary == CORNER_FASTENERS.0.order_text())
    {
        screw.quantity = needed as u32;
        screw.summary += "; the molds borrow them";
    }
    all
}

/// Returns a placement at a pose in a camera's frame, moved along its line of sight in the exploded view.
fn on_camera_plate(camera: &Placement, pose: Pose, out_mm: f64) -> Placement {
    let plate = camera.assembly_from_body;
    let out = plate.vector(Vector3::new(0.0, 0.0, out_mm));
    Placement { assembly_from_body: plate.then_in(pose), ..camera.clone() }.moved_apart(out)
}

/// Returns all bought components.
pub fn components(p: &SheetMold, layout: &SheetMoldLayout) -> Vec<Body> {
    let on_display = |pose: Pose| SENSOR.at(layout.sensor_from_display.then_in(pose));
    let above_display = Pose::translation(0.0, 0.0, layout.stand_z_mm).then_in(flipped());
    let cameras =
        [SENSOR.at_z(layout.floor_z_mm).lifted(-12.0), on_display(above_display).lifted(84.0)];
    // Spacers stand on the plate, below the nuts.
    let holes = Joints::new(p, layout).camera;
    let on_plate = holes.poses.iter().map(|pose| {
        let at = pose.translation_mm();
        upright([at.x, at.y], 0.0)
    });
    let spacers = cameras
        .iter()
        .flat_map(|camera| on_plate.clone().map(|pose| on_camera_plate(camera, pose, -8.0)));
    let spacer = |name: Name, length: f64, placements: Vec<Placement>| {
        let long = format_rounded(length);
        let text = format!("hexagonal spacer M3, female both ends, {long} mm");
        name.bought(text, HexSpacer::M3.solid(length), placements)
            .with_order(HexSpacer::M3.order(length))
            .colored(BRASS)
            .threaded()
    };

    let tube_ends = Side::BOTH.into_iter().flat_map(|side| {
        let out = Vector3::new(40.0 * side.sign(), 0.0, 44.0);
        tube_poses(p, layout, side).into_iter().map(move |pose| SENSOR.at(pose).moved_apart(out))
    });
    let inlets: Vec<[f64; 2]> =
        display_channel_y(p).into_iter().map(|y| display_inlet(p, y)).collect();
    let display_tubes =
        inlets.iter().map(|&c| on_display(upright(c, layout.cover_top_mm)).lifted(92.0));
    let needle_z = layout.cover_top_mm - p.display.sheet.mm();

    let box_spacers =
        layout.bolts().map(|c| SENSOR.at(upright(c, layout.floor_z_mm)).lifted(-10.0)).to_vec();
    let stand_spacers = layout
        .display_bolts(p)
        .map(|c| on_display(upright(c, layout.cover_top_mm)).lifted(80.0))
        .to_vec();
    let mut all = vec![
        CAMERA
            .bought(camera_specification(p), camera(p, layout), cameras.clone())
            .with_order(Order::new(&p.camera.model, ""))
            .with_tool_access(board_camera!(p.camera).lens(camera_board_top_mm(p)).front_access())
            .colored(CAMERA_GREEN),
        CAMERA_SPACER
            .bought(
                format!("round spacer, 2.2 x 4 mm, {} mm long", p.camera.spacer.mm()),
                tube(1.1, 2.0, p.camera.spacer.mm()),
                spacers,
            )
            .with_order(Order::new(
                "round spacer",
                format!("2.2 x 4 mm, {} mm long", p.camera.spacer.mm()),
            )),
    ];
    all.extend(cables(p, layout, &cameras));
    all.extend(fasteners(p, layout, &cameras));
    all.extend([
        spacer(BOX_SPACER, p.housing.height.mm(), box_spacers),
        spacer(STAND_SPACER, p.display.camera_spacer.mm(), stand_spacers),
        TUBE.bought(
            format!(
                "silicone tube, {} x {} mm, {} mm long; shown are its two ends",
                p.tubes.inner_diameter.mm(),
                p.tubes.outer_diameter.mm(),
                p.tubes.length.mm()
            ),
            tube(
                p.tubes.inner_diameter.mm() / 2.0,
                p.tubes.outer_diameter.mm() / 2.0,
                TUBE_STUB_MM,
            ),
            tube_ends.chain(display_tubes),
        )
        .with_quantity(inlets.len() as u32)
        .made_of("silicone rubber")
        .with_order(
            Order::new(
                "silicone tube",
                format!(
                    "{} x {} mm (inside x outside)",
                    p.tubes.inner_diameter.mm(),
                    p.tubes.outer_diameter.mm()
                ),
            )
            .cut_to(p.tubes.length.mm()),
        )
        .colored([228, 222, 210])
        .opaque(0.7)
        .as_attached(),
        NEEDLE.bought(
            format!(
                "steel tube (blunt dispensing needle), {} mm outside, {} mm inside, cut to {} mm",
                p.tubes.needle_outer_diameter.mm(),
                p.tubes.needle_inner_diameter.mm(),
                p.tubes.needle_length.mm()
            ),
            tube(
                p.tubes.needle_inner_diameter.mm() / 2.0,
                p.tubes.needle_outer_diameter.mm() / 2.0,
                p.tubes.needle_length.mm(),
            ),
            inlets.iter().map(|&c| on_display(upright(c, needle_z)).lifted(78.0)),
        )
        .made_of("steel")
        .with_order(Order::new(
            "blunt dispensing needle",
            format!(
                "{} mm outside, {} mm inside",
                p.tubes.needle_outer_diameter.mm(),
                p.tubes.needle_inner_diameter.mm()
            ),
        ))
        .as_attached(),
        LED_STRIP
            .bought(
                format!(
                    "self-adhesive LED strip, white, diffuse, {} x {} mm, with a resistor for 5 V",
                    p.housing.led_strip_length.mm(),
                    p.housing.led_strip_width.mm()
                ),
                led_strip(p),
                (0..4).map(|i| SENSOR.at_exploded(&sensor_from_wall(layout, i).then_in(flipped()), -18.0)),
            )
            .with_order(
                Order::new(
                    "LED strip, white, self-adhesive, 5 V",
                    format!("{} mm wide", p.housing.led_strip_width.mm()),
                )
                .cut_to(p.housing.led_strip_length.mm()),
            )
            .colored(LED_YELLOW)
            .as_light_source()
            .as_attached(),
    ]);
    add_focusing_placements(&mut all, &holes.names());
    all
}

/// Adds a placement of the box's camera, and of what holds it, on the box's floor alone.
fn add_focusing_placements(all: &mut [Body], held_by: &[String]) {
    let is_of_camera = |body: &Body| {
        [CAMERA, CAMERA_SPACER].iter().any(|name| name.name == body.name)
            || held_by.contains(&body.name)
    };
    for body in all.iter_mut().filter(|body| is_of_camera(body)) {
        // The first half of the placements belongs to the box's camera, the second half to the display's.
        let of_box = &body.placements[..body.placements.len() / 2];
        let apart =
            |place: &Placement| Placement { assembly: BOX_FOCUSING.assembly(), ..place.clone() };
        let apart: Vec<Placement> = of_box.iter().map(apart).collect();
        body.placements.extend(apart);
    }
}

/// Returns a tube standing on z = 0.
fn tube(inner_mm: f64, outer_mm: f64, length_mm: f64) -> Solid {
    let bore = Solid::cylinder(inner_mm, length_mm + 2.0 * CUT_OVERLAP_MM);
    Solid::cylinder(outer_mm, length_mm).minus(bore.at_z(-CUT_OVERLAP_MM))
}

/// Returns a strip on the inside of its wall, in the wall's frame but with the z axis along its light.
fn led_strip(p: &SheetMold) -> Solid {
    let (length, width, thickness) = (
        p.housing.led_strip_length.mm(),
        p.housing.led_strip_width.mm(),
        p.housing.led_strip_thickness.mm(),
    );
    Solid::cuboid(length, width, thickness).at(0.0, -LED_HEIGHT_MM, 0.0)
}

/// Height of the LED strips' upper edge above the box's floor, mm.
pub fn led_top_mm(p: &SheetMold) -> f64 {
    LED_HEIGHT_MM + p.housing.led_strip_width.mm() / 2.0
}

fn camera_specification(p: &SheetMold) -> String {
    format!(
        "{}, {} x {} px, {} lens, board {} x {} mm",
        p.camera.model,
        p.camera.width_px,
        p.camera.height_px,
        p.camera.field_of_view,
        p.camera.board_size.mm(),
        p.camera.board_size_y.mm()
    )
}

/// Clearance between the plug and the plate that carries the camera, mm.
pub const PLUG_ABOVE_MM: f64 = 0.5;

/// Limits of the plug along x, mm.
pub fn plug_reach_mm(p: &SheetMold) -> [f64; 2] {
    [-4.0, 4.0].map(|half| p.camera.board_size.mm() / 4.0 + half)
}

/// Returns the camera: a board with four holes, lens holder, barrel, and the plug behind. Its origin lies on the
/// plate that carries it, a spacer's length below the board.
fn camera(p: &SheetMold, layout: &SheetMoldLayout) -> Solid {
    let (bottom, top) = (p.camera.spacer.mm(), camera_board_top_mm(p));
    let screws = Joints::new(p, layout).camera;
    let gap = gap_mm(Process::Pcb, Fit::Snug);
    let tool = screws.screw.clearance_tool(p.camera.board_thickness.mm(), gap);
    let holes = screws.holes().poses.iter().map(|pose| tool.clone().placed(*pose)).collect();
    // A gap stays between the plug and the plate.
    let [from, to] = plug_reach_mm(p);
    let plug = Solid::cuboid(to - from, 5.0, bottom - PLUG_ABOVE_MM + INTO_MM)
        .at((from + to) / 2.0, 0.0, PLUG_ABOVE_MM)
        .named("plug");
    board_camera!(p.camera).solid([bottom, top], holes, plug)
}

// ------ Circuit ------
//
// Wiring of the box's LED strips, and of both cameras.

/// Number of LED strips, one at each wall.
const STRIP_COUNT: u32 = 4;

/// Builds the circuit: supply and ground of each strip, and the cameras' cables.
pub fn circuit(p: &SheetMold, layout: &SheetMoldLayout) -> Circuit {
    let mut wired = CircuitBuilder::new_wired("led-strips", 5.0);
    wired.strips(STRIP_COUNT, "strip", "5 V of the supply");
    let [below, above] = cable_lengths_mm(p, layout);
    wired.connection(camera_to_host("camera in the box", Some(BOX_CABLE), Some(below), "USB"));
    wired.connection(camera_to_host(
        "camera above the display",
        Some(STAND_CABLE),
        Some(above),
        "USB",
    ));
    wired.note("no board is etched: buy strips that bring their resistors for 5 V");
    wired.note("what the strips take together is on their data sheet; all four are parallel");
    wired.build()
}

// ------ Cables ------
//
// Cables of both cameras, from the plugs behind their boards to beside the sensor.
//
// Boards stand on spacers, so a cable runs between board and plate. Each cable is plugged in before its board is
// screwed down. That of the box is laid into its opening before that wall is put on, so no plug has to pass the
// opening.

/// Diameter of a USB cable, mm, if the room behind a board and the opening allow it.
const CABLE_MM: f64 = 4.0;

/// Bend radius, mm: twice the diameter, because nothing moves in use.
const BEND_MM: f64 = 8.0;

/// Distance from a board's edge to the centre line of a cable that runs around it, mm.
const CABLE_BOARD_DISTANCE_MM: f64 = 8.0;

/// Drawn length of a cable beyond the part that it leaves, mm.
const DRAWN_CABLE_MM: f64 = 20.0;

/// Returns a cable through points in the plane of the camera's plate, mm.
fn cable(p: &SheetMold, through: &[[f64; 2]]) -> Cable {
    let behind = p.camera.spacer.mm() - PLUG_ABOVE_MM;
    let opening = p.housing.cable_height.mm().min(p.housing.cable_width.mm());
    let z = PLUG_ABOVE_MM + behind / 2.0;
    // The cable need not be centred in the opening, but it must stay below its upper edge.
    let diameter_mm = CABLE_MM.min(behind - APART_MM).min(2.0 * (opening - z) - APART_MM);
    let corners = through.iter().map(|&[x, y]| Point3::new(x, y, z)).collect();
    Cable { diameter_mm, bend_mm: BEND_MM, corners }
}

/// Returns the cable in the box, from the plug to its opening. It runs around the board unless the opening is on the
/// plug's side.
fn box_cable(p: &SheetMold, layout: &SheetMoldLayout) -> Cable {
    let start = [plug_reach_mm(p)[1], 0.0];
    let [x, y] = [p.camera.board_size, p.camera.board_size_y]
        .map(|e| e.mm() / 2.0 + CABLE_BOARD_DISTANCE_MM);
    let out = layout.wall_outer_mm + DRAWN_CABLE_MM;
    match p.housing.cable_side {
        CableSide::Right => cable(p, &[start, [out, 0.0]]),
        CableSide::Left => cable(p, &[start, [x, 0.0], [x, y], [-x, y], [-x, 0.0], [-out, 0.0]]),
        CableSide::Front => cable(p, &[start, [x, 0.0], [x, -y], [0.0, -y], [0.0, -out]]),
        CableSide::Back => cable(p, &[start, [x, 0.0], [x, y], [0.0, y], [0.0, out]]),
    }
}

/// Drawn lengths of both cables, mm, that of the box first.
pub fn cable_lengths_mm(p: &SheetMold, layout: &SheetMoldLayout) -> [f64; 2] {
    camera_cables(p, layout).map(|cable| cable.length_mm())
}

/// Returns the cable of the camera in the box, and that of the camera above the display.
fn camera_cables(p: &SheetMold, layout: &SheetMoldLayout) -> [Cable; 2] {
    let end = layout.display_size_mm[0] / 2.0 + DRAWN_CABLE_MM;
    [box_cable(p, layout), cable(p, &[[plug_reach_mm(p)[1], 0.0], [end, 0.0]])]
}

/// Returns both cables, each in the frame of its camera's plate.
pub fn cables(p: &SheetMold, layout: &SheetMoldLayout, cameras: &[Placement; 2]) -> [Body; 2] {
    let [below, above] = camera_cables(p, layout).map(|cable| cable.solid());
    let [box_camera, stand_camera] = cameras.clone();
    [
        BOX_CABLE.bought("USB cable of the camera in the box", below, [box_camera]),
        STAND_CABLE.bought("USB cable of the camera above the display", above, [stand_camera]),
    ]
    .map(|body| {
        body.with_order(Order::new("USB cable of the camera", ""))
            .colored(RUBBER)
            .with_assembly_compliance(GIVE_WAY_MM)
    })
}

/// Reports a cable that has no room around its camera's board.
pub fn check_cables(p: &SheetMold, layout: &SheetMoldLayout, report: &mut RuleReport) {
    let cable = box_cable(p, layout);
    let room = layout.wall_inner_mm - cable.diameter_mm / 2.0 - CABLE_BOARD_DISTANCE_MM - APART_MM;
    if p.housing.cable_side != CableSide::Right {
        limits! { report, p:
            camera.board_size <= 2.0 * room, "the cable goes around the board, inside the walls";
            camera.board_size_y <= 2.0 * room, "the cable goes around the board, inside the walls";
        }
    }
    report.require(
        cable.diameter_mm >= 1.0,
        "housing.cable_height",
        || {
            format!(
                "housing.cable_height is {}; a cable behind the board at {} leaves {:.1} mm of it",
                p.housing.cable_height, p.camera.spacer, cable.diameter_mm
            )
        },
        || "write a higher opening, or a shorter `camera.spacer`".into(),
    );
}
