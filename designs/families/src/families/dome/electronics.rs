//! Bought components, the LED circuit, and the routing of cable and wires.

use std::f64::consts::{PI, TAU};

use fabkit_geometry::{
    Angle, BoardPlacement, BoardSide, Body, CUT_OVERLAP_MM, Circuit, CutFeature, KeepOutRegion,
    Order, Path, Placement, Point3, Pose, Process, Solid, Vector3,
};

use super::molds::{form, o_ring_seat};
use super::parameters::*;
use super::{
    BAFFLE_FLANGE_MM, DomeLayout, Joints, cable_slot, cavities, dome_shell, led_poses,
    relief_edges_mm,
};
use crate::blocks::adapter::CableOutlet;
use crate::blocks::cable::{Cable, GIVE_WAY_MM, wire_order};
use crate::blocks::circuit::{
    BoardWire, CHIP_0603, CircuitBuilder, LedPackage, TO_SUPPLY, along_y, camera_to_host,
    ring_region,
};
use crate::blocks::cup_and_bridge::CupAndBridge;
use crate::blocks::mold::{lid_dowel_poses, side_dowel_poses};
use crate::blocks::{
    APART_MM, DOWEL, GLASS, INTO_MM, LED, RUBBER, half_chord, holes, led_ring, merged, turn,
};
use crate::chain_builder::{AssemblyName, SENSOR, in_sensor};
use crate::fits::{Fit, gap_mm};
use crate::hardware::Dowel;

// ------ Components ------
//
// Bought components: glass tubes, camera, LEDs, screws, nuts, dowels, O-ring.

/// Returns all bought components.
pub fn components(p: &Dome, layout: &DomeLayout) -> Vec<Body> {
    let each = |assembly: AssemblyName, poses: &[Pose], lift_mm: f64| -> Vec<Placement> {
        poses.iter().map(|&pose| assembly.at(pose).lifted(lift_mm)).collect()
    };
    // In the exploded view, fasteners move along their own axis.
    let drawn_out = |out_mm: f64, lift_mm: f64| {
        move |pose: &Pose| SENSOR.at_exploded(pose, out_mm).lifted(lift_mm)
    };
    let here = [Pose::identity()];

    let side = side_dowel_poses(&p.mold);
    let lid = lid_dowel_poses(&p.mold);
    let dowels = [TRANSPARENT_MOLD, TRANSLUCENT_MOLD, JOINING]
        .into_iter()
        .flat_map(|mold| [each(mold, &side, 0.0), each(mold, &lid, -12.0)].concat());
    let (seat, dowel) = (o_ring_seat(p, layout), dowel(p));
    let joints = Joints::new(p, layout);

    let is_silicone = p.molds.route == MoldRoute::Silicone;
    let is_dipped = p.coat.method == CoatMethod::Dip;
    let in_form = |form: AssemblyName| move |pose: &Pose| form.at(*pose).lifted(-45.0);
    // Both forms use the same screws, one after the other.
    let form_screws = if is_silicone {
        [INNER_FORM, OUTER_FORM]
            .map(|form| joints.form.bought(in_form(form), in_form(form)))
            .concat()
    } else {
        Vec::new()
    };
    let sensor = vec![
        TUBE.bought(
            format!(
                "glass test tube, {} mm outside, {} mm wall, cut {} mm from its tip",
                p.tube.outer_diameter.mm(),
                p.tube.wall.mm(),
                layout.wall_height_mm + layout.tube_radius_mm
            ),
            dome_shell(layout.tube_bore_radius_mm, layout.tube_radius_mm, layout.wall_height_mm),
            vec![],
        )
        .made_of("borosilicate glass")
        .placed([
            in_sensor().lifted(56.0),
            TRANSPARENT_MOLD.in_place(),
            TRANSLUCENT_MOLD.in_place(),
            JOINING.in_place(),
            CUTTING.in_place(),
        ])
        .placed(is_dipped.then(|| COATING.in_place()))
        .with_quantity(1)
        .with_order(Order::new(
            "glass test tube",
            format!("{} mm outside, {} mm wall", p.tube.outer_diameter.mm(), p.tube.wall.mm()),
        ))
        .colored(GLASS)
        .opaque(0.3),
        camera(p, layout).placed([in_sensor().lifted(-46.0)]),
        led_ring!(p.leds).body(each(SENSOR, &led_poses(p, layout), -20.0)),
    ];
    let screws = [
        joints.camera.bought(drawn_out(0.0, -36.0), drawn_out(0.0, 0.0)),
        joints.shell_base.bought(drawn_out(12.0, 0.0), drawn_out(6.0, -66.0)),
        form_screws,
        joints.mounting.bought_nuts(drawn_out(6.0, -66.0)).into_iter().collect(),
    ];
    let screws = merged(screws.into_iter().flatten());
    let dowels = (!is_silicone).then(|| {
        DOWEL
            .bought(dowel.specification(), dowel.solid(), dowels)
            .with_quantity(2 * (side.len() + lid.len()) as u32)
            .with_order(dowel.order())
            .with_tool_access(dowel.press_access())
            .as_fastener()
    });
    let gripped =
        [TRANSPARENT_MOLD, TRANSLUCENT_MOLD].into_iter().chain(is_dipped.then_some(COATING));
    let ring = O_RING
        .bought(
            seat.order_text(),
            seat.ring()
                .between_cylinders([seat.radius_mm, layout.tube_bore_radius_mm])
                .at_z(p.connector.plug_length.mm() / 2.0),
            gripped.flat_map(|tool| each(tool, &here, -42.0)),
        )
        .with_quantity(1)
        .made_of("rubber")
        .with_order(seat.ring().order())
        .colored(RUBBER)
        .with_assembly_compliance(seat.ring().max_stretch_mm());
    let forms = cavities(p, layout).map(|cavity| {
        let form = form(p, layout, &cavity);
        cavity
            .form
            .tube
            .bought(
                format!(
                    "glass test tube with rim, {} mm outside, {} mm long",
                    2.0 * cavity.radius,
                    p.form.tube_length.mm()
                ),
                form_tube(p, layout, &form, cavity.radius),
                each(cavity.form.assembly, &here, -60.0),
            )
            .made_of("borosilicate glass")
            .with_order(Order::new(
                "glass test tube with rim",
                format!("{} mm outside, {} mm long", 2.0 * cavity.radius, p.form.tube_length.mm()),
            ))
            .colored(GLASS)
            .opaque(0.35)
    });
    let forms = is_silicone.then_some(forms).into_iter().flatten();
    let tools = dowels.into_iter().chain([ring]).chain(forms);
    sensor.into_iter().chain(cables(p, layout)).chain(screws).chain(tools).collect()
}

/// Returns the camera: a board with four holes, lens holder and barrel, and a connector behind.
fn camera(p: &Dome, layout: &DomeLayout) -> Body {
    let thickness = p.camera.board.board_thickness.mm();
    let holes =
        Joints::new(p, layout).camera.clearance_cut(thickness, gap_mm(Process::Pcb, Fit::Snug));
    let edges = relief_edges_mm(p).map(|edge| edge - 2.0);
    let connector =
        Solid::cuboid(edges[0], edges[1] / 2.0, p.camera.back_clearance.mm() - 0.5 + INTO_MM)
            .at_z(layout.relief_z_mm + 0.5)
            .named("connector");
    let heights = [layout.camera_board_bottom_z_mm, layout.camera_board_top_z_mm];
    let c = &p.camera;
    c.board.bought((&c.module, &c.images, &c.view), heights, holes.tools, connector)
}

fn dowel(p: &Dome) -> Dowel {
    Dowel { diameter_mm: p.mold.dowel_diameter.mm(), length_mm: p.mold.dowel_length.mm() }
}

/// Returns the glass tube whose outside shapes a silicone mold. Its rim rests on the bridge's sleeve.
fn form_tube(p: &Dome, layout: &DomeLayout, form: &CupAndBridge<'_>, outer: f64) -> Solid {
    let wall = layout.wall_height_mm;
    let inner = outer - p.tube.wall.mm();
    let centre = [0.0, wall];
    let outside = Path::from([0.0, form.rim_z])
        .line([outer + p.form.tube_rim.mm(), form.rim_z])
        .line([outer + p.form.tube_rim.mm(), form.sleeve_z])
        .line([outer, form.sleeve_z])
        .line([outer, wall])
        .arc([0.0, wall + outer], centre, true)
        .close();
    let below = form.rim_z - CUT_OVERLAP_MM;
    let inside = Path::from([0.0, below])
        .line([inner, below])
        .line([inner, wall])
        .arc([0.0, wall + inner], centre, true)
        .close();
    Solid::revolution(outside).minus(Solid::revolution(inside))
}

// ------ Circuit ------
//
// Parts soldered to the LED board, and the wires that lead to it.

/// Size of a wire's pad along and across the exit direction, mm.
const PAD_MM: [f64; 2] = [1.5, 0.8];

/// Builds the circuit: LEDs between supply and ground, each with its resistor, two wires, and the camera's cable.
pub fn circuit(p: &Dome, layout: &DomeLayout) -> Circuit {
    let mut board = CircuitBuilder::new_on_board(LED_BOARD, &p.leds.electric);
    let package = LedPackage::Chip([p.leds.length.mm(), p.leds.width.mm()]);
    board.add_leds_with_resistors(
        &p.leds.electric,
        (&p.leds.model, package, LED),
        along_y(&led_poses(p, layout)),
        CHIP_0603,
        "leds.resistor_ohms, or leds.current_ma where that is 0",
    );
    let drawn = is_side_exit(p);
    let by = drawn.then_some(LED_WIRE);
    let length_mm = drawn.then(|| led_wire(p, layout).length_mm());
    let holes = wire_hole_centres(p);
    for (at_mm, (net, color, to)) in holes.into_iter().zip(TO_SUPPLY) {
        let out = at_mm[1].atan2(at_mm[0]);
        // If the holes lie outside the circle of LEDs, the pads point away from that circle.
        let is_outside = at_mm[0].hypot(at_mm[1]) > p.leds.circle_radius.mm();
        let way = if drawn { p.base.exit_angle.rad() } else { out };
        board.wire(
            net,
            BoardWire {
                place: BoardPlacement {
                    at_mm,
                    turn_rad: if is_outside { way + PI } else { way },
                    side: BoardSide::Top,
                },
                hole_mm: Some(p.led_board.wire_hole_diameter.mm()),
                pad_mm: PAD_MM,
                by,
                to,
                length_mm,
                color,
            },
        );
    }
    let baffle = p.led_board.bore_radius.mm() + BAFFLE_FLANGE_MM;
    if p.baffle.wall.mm() > 0.0 {
        board.keep_out(BoardSide::Top, ring_region([0.0, baffle]), "the baffle's flange");
    }
    for rib in 0..p.shell.ribs {
        // A rib is a sector of a ring. The region has a margin of 0.1 mm inwards and 0.01 rad on each side.
        let half = (p.shell.rib_width.mm() / 2.0 / layout.shell_bore_radius_mm).asin();
        let region = KeepOutRegion::Sector {
            inner_mm: layout.rib_radius_mm - 0.1,
            outer_mm: layout.shell_radius_mm,
            middle_rad: turn(rib, p.shell.ribs, 0.0).rad(),
            half_rad: half + 0.01,
        };
        board.keep_out(BoardSide::Top, region, "a rib of the shell");
    }
    board.test_points();
    let length_mm = drawn.then(|| camera_cable(p, layout).length_mm());
    board.connection(camera_to_host("camera", drawn.then_some(CAMERA_CABLE), length_mm, "USB"));
    board.note("push each wire's strand through its hole from below, bend it over and solder it to the pad beside it");
    board.note("no part stands on the lower side: the base lies against it");
    board.build()
}

// ------ Wiring ------
//
// Routing of wires and cable: a slit in the base leads to the side from the camera's recess and from below the LED
// board's wire holes. A notch in the shell slides over it.

/// Drawn length of the cable outside the shell, up to its plug, mm.
const CABLE_OUT_MM: f64 = 20.0;

/// Drawn length of the wires outside the shell, mm. They end before the plug.
const WIRES_OUT_MM: f64 = 12.0;

/// Height of the tongue's lower face above the base's bottom, mm: less than one printed layer.
const TONGUE_LIFT_MM: f64 = 0.04;

/// Clearance between cable and wires, and between them and the walls of their slit, mm.
const CABLE_PLAY_MM: f64 = 0.15;

/// Gap between the camera board and the cable, mm.
const CABLE_BOARD_GAP_MM: f64 = 0.3;

/// Width and heights, mm, of the slit for cable and wires. The exit direction is +x.
pub struct CableSlit {
    /// Width across the exit direction.
    pub width_mm: f64,
    /// Height of the cable's centre line.
    pub cable_z: f64,
    /// Height of the wires' centre lines.
    pub wire_z: f64,
    /// Height of the upper end of the shell's notch.
    pub top_z: f64,
    /// Height of the upper face of the tongue below the cable.
    pub tongue_z: f64,
}

impl CableSlit {
    /// Derives the slit from the cable, the wires and the camera board.
    pub fn new(p: &Dome, layout: &DomeLayout) -> Self {
        let (cable, wire) = (p.cables.diameter.mm(), p.cables.wire_diameter.mm());
        let cable_z = layout.camera_board_bottom_z_mm - CABLE_BOARD_GAP_MM - cable / 2.0;
        let wire_z = cable_z + cable / 2.0 + CABLE_PLAY_MM + wire / 2.0;
        Self {
            width_mm: cable.max(2.0 * wire + APART_MM) + 2.0 * CABLE_PLAY_MM,
            cable_z,
            wire_z,
            top_z: wire_z + wire / 2.0 + CABLE_PLAY_MM,
            tongue_z: cable_z - cable / 2.0 - CABLE_PLAY_MM,
        }
    }
}

/// Returns whether cable and wires leave through the side.
pub fn is_side_exit(p: &Dome) -> bool {
    p.base.cable_exit == CableExit::Side
}

/// Pose that turns +x into the exit direction.
fn exit_rotation(p: &Dome) -> Pose {
    Pose::rotation_z(p.base.exit_angle)
}

/// Centres of the two wire holes in the LED board, mm. For an exit at the side they lie next to each other above the
/// slit. For an exit through the floor they lie opposite each other, over the corners of the camera's pocket.
pub fn wire_hole_centres(p: &Dome) -> [[f64; 2]; 2] {
    if is_side_exit(p) {
        let [x, y] = first_wire_hole(p);
        return [y, -y].map(|y| {
            let at = exit_rotation(p).point(Point3::new(x, y, 0.0));
            [at.x, at.y]
        });
    }
    let radius = p.led_board.bore_radius.mm() + p.led_board.wire_hole_diameter.mm();
    // The LEDs nearest to 45 and 225 degrees are half a step away from these angles.
    [0.125, 0.625].map(|turns: f64| {
        let angle = turns * TAU;
        [radius * angle.cos(), radius * angle.sin()]
    })
}

/// Centre of the first wire hole if the exit direction is +x, mm.
fn first_wire_hole(p: &Dome) -> [f64; 2] {
    let radius = wire_hole_circle_radius_mm(p);
    let beside = (p.cables.wire_diameter.mm() + APART_MM) / 2.0;
    [(radius.powi(2) - beside.powi(2)).max(0.0).sqrt(), beside]
}

/// Clearance between a wire and the edge of the camera board, mm.
const BOARD_CLEARANCE_MM: f64 = 0.5;

/// Distance of the wire holes from the axis, mm. They lie inside the circle of LEDs, or outside of it if the camera
/// board is in the way.
fn wire_hole_circle_radius_mm(p: &Dome) -> f64 {
    let hole = p.led_board.wire_hole_diameter.mm();
    // Distance from the axis to the board's edge in the exit direction.
    let out = exit_rotation(p).vector(Vector3::x());
    let edge = [p.camera.board.board_size, p.camera.board.board_size_y].map(|edge| edge.mm() / 2.0);
    let board = (edge[0] / out.x.abs().max(1e-9)).min(edge[1] / out.y.abs().max(1e-9));
    let beside = board + BOARD_CLEARANCE_MM + p.cables.wire_diameter.mm() / 2.0;
    let inside = p.led_board.bore_radius.mm() + hole;
    if inside >= beside {
        return inside;
    }
    (p.leds.circle_radius.mm() + p.leds.width.mm() / 2.0 + hole).max(beside)
}

/// Distance from the axis to the outer edge of a wire hole, mm.
pub fn wire_hole_end_radius_mm(p: &Dome) -> f64 {
    wire_hole_circle_radius_mm(p) + p.led_board.wire_hole_diameter.mm() / 2.0
}

/// Returns the cut in the base for the cable: a slot in its floor, or the slit to its side.
pub fn cable_cut(p: &Dome, layout: &DomeLayout) -> CutFeature {
    let (bottom, top) = (layout.bottom_z_mm, layout.base_top_z_mm + CUT_OVERLAP_MM);
    if !is_side_exit(p) {
        return cable_slot(p).cut("cable slot", [bottom, layout.relief_z_mm]);
    }
    let slit = CableSlit::new(p, layout);
    let half = slit.width_mm / 2.0;
    let beyond = layout.shell_radius_mm + 1.0;
    let tool = Solid::cuboid_between([0.0, -half, slit.tongue_z], [beyond, half, top]);
    holes([tool.placed(exit_rotation(p)).named("cable slit")])
}

/// Angles of the slots by which a screwdriver pulls the base out. For an exit at the side they lie a third of the
/// screws' ring to either side of it: between a screw and a mounting hole, as the exit does.
pub fn pry_turns(p: &Dome) -> Vec<Angle> {
    if !is_side_exit(p) {
        return vec![turn(0, 2, 0.5), turn(1, 2, 0.5)];
    }
    let count = p.shell.screws;
    let third = (f64::from(count) / 3.0).round().max(1.0) as u32;
    let mut steps = vec![third, count - third];
    steps.dedup();
    let exit = p.base.exit_angle.rad();
    let from_exit = |i| Angle::from_rad(exit + turn(i, count, 0.0).rad()).expect("finite");
    steps.into_iter().map(from_exit).collect()
}

/// Returns the tongue on the base that closes the shell's notch below the cable. It also aligns base and shell.
pub fn tongue(p: &Dome, layout: &DomeLayout) -> Option<Solid> {
    if !is_side_exit(p) {
        return None;
    }
    let slit = CableSlit::new(p, layout);
    let half = slit.width_mm / 2.0 - p.making.gap_mm(BASE, Process::Fdm, Fit::Slide);
    // The tongue's corners must not stand out of the shell.
    let reach = half_chord(layout.shell_radius_mm - APART_MM, half);
    let inside = layout.base_radius_mm - 1.0;
    let tongue = Solid::cuboid_between(
        [inside, -half, layout.bottom_z_mm + TONGUE_LIFT_MM],
        [reach, half, slit.tongue_z + INTO_MM],
    );
    Some(tongue.placed(exit_rotation(p)).named("tongue"))
}

/// Returns the notch in the shell's rim that slides over cable and wires.
pub fn shell_notch(p: &Dome, layout: &DomeLayout) -> Option<Solid> {
    if !is_side_exit(p) {
        return None;
    }
    let slit = CableSlit::new(p, layout);
    let half = slit.width_mm / 2.0;
    let from = half_chord(layout.shell_bore_radius_mm, half) - 1.0;
    let tool = Solid::cuboid_between(
        [from, -half, layout.bottom_z_mm - CUT_OVERLAP_MM],
        [layout.shell_radius_mm + 1.0, half, slit.top_z],
    );
    Some(tool.placed(exit_rotation(p)).named("cable notch"))
}

/// Path of the camera's cable, from its connector to the plug on its free end. The exit direction is +x.
pub fn camera_cable(p: &Dome, layout: &DomeLayout) -> Cable {
    let z = CableSlit::new(p, layout).cable_z;
    let [x, y] = relief_edges_mm(p).map(|edge| edge / 2.0 - 1.0);
    // The connector is half as deep as it is wide. The path starts at the face that the exit direction meets.
    let out = exit_rotation(p).vector(Vector3::x());
    let face = (x / out.x.abs().max(1e-9)).min(y / 2.0 / out.y.abs().max(1e-9));
    let end = layout.shell_radius_mm + CABLE_OUT_MM;
    let corners = vec![Point3::new(face + APART_MM, 0.0, z), Point3::new(end, 0.0, z)];
    Cable { diameter_mm: p.cables.diameter.mm(), bend_mm: p.cables.diameter.mm(), corners }
}

/// Path of a wire from the LED board: down beside the camera board, then out above the cable.
pub fn led_wire(p: &Dome, layout: &DomeLayout) -> Cable {
    let slit = CableSlit::new(p, layout);
    let [x, _] = first_wire_hole(p);
    let corners = vec![
        Point3::new(x, 0.0, layout.base_top_z_mm),
        Point3::new(x, 0.0, slit.wire_z),
        Point3::new(layout.shell_radius_mm + WIRES_OUT_MM, 0.0, slit.wire_z),
    ];
    Cable { diameter_mm: p.cables.wire_diameter.mm(), bend_mm: p.cables.wire_bend.mm(), corners }
}

/// Cable exit that a plate below the sensor must leave free.
pub fn cable_exit(p: &Dome, layout: &DomeLayout) -> CableOutlet {
    if is_side_exit(p) {
        let slit = CableSlit::new(p, layout);
        let above_mm = slit.cable_z - p.cables.diameter.mm() / 2.0 - layout.bottom_z_mm;
        return CableOutlet::Sideways {
            angle: p.base.exit_angle,
            width_mm: slit.width_mm,
            above_mm,
        };
    }
    let slot = cable_slot(p);
    let mut half_mm = [slot.width.mm() / 2.0; 2];
    half_mm[slot.along] = slot.length.mm() / 2.0;
    CableOutlet::Below { at: slot.at, half_mm, turn: slot.turn }
}

/// Returns the cable and the wires as they lie in the sensor; empty if they leave through the floor.
pub fn cables(p: &Dome, layout: &DomeLayout) -> Vec<Body> {
    if !is_side_exit(p) {
        return Vec::new();
    }
    let cable = camera_cable(p, layout);
    let plug = [p.cables.plug_height, p.cables.plug_width, p.cables.plug_length].map(|l| l.mm());
    let cord = cable.solid().plus(cable.plug(Vector3::z(), plug)).placed(exit_rotation(p));
    let wire = led_wire(p, layout);
    let [_, beside] = first_wire_hole(p);
    let places = [beside, -beside]
        .map(|y| SENSOR.at(exit_rotation(p).then_in(Pose::translation(0.0, y, 0.0))).lifted(-36.0));
    vec![
        CAMERA_CABLE
            .bought(
                format!(
                    "the camera's cable, {} mm thick, its plug {} x {} mm",
                    p.cables.diameter.mm(),
                    plug[1],
                    plug[0]
                ),
                cord,
                [in_sensor().lifted(-46.0)],
            )
            .with_order(Order::new("USB cable of the camera", "with the camera's own plug"))
            .colored(RUBBER)
            .with_assembly_compliance(GIVE_WAY_MM),
        LED_WIRE
            .bought(
                format!("stranded wire, {} mm thick over all", p.cables.wire_diameter.mm()),
                wire.solid(),
                places,
            )
            .with_order(wire_order(p.cables.wire_diameter))
            .colored([190, 60, 50])
            .with_assembly_compliance(GIVE_WAY_MM),
    ]
}
