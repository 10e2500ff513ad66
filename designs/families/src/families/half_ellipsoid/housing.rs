//! Shell, holders and base, and the elastomers on the shell.

use fabkit_geometry::{
    Body, CUT_OVERLAP_MM, Color, Landmark, OpticalClarity, Path, Placement, Pose, Process, Profile,
    Solid,
};

use super::molds::{self, Boundary, flange_openings, keys, tip_vent};
use super::parameters::*;
use super::{HalfEllipsoidLayout, Joints};
use crate::blocks::adapter::CableOutlet;
use crate::blocks::cable_openings::FloorSlot;
use crate::blocks::{
    BLACK as BLACK_PLASTIC, GLASS, MASK_GREEN, copies, edge, holes, landmarks_at, ring, turn,
};
use crate::chain_builder::{AssemblyName, Name, SENSOR, flipped};
use crate::fits::Fit;
use crate::materials::window_transparency;

// ------ Housing ------
//
// Shell, shell holder, base, camera holder, diffusion ring and LED board.

const WHITE: Color = [240, 240, 236];

/// Depth, width and height of the slots for a screwdriver that lifts the holder off the flange, mm.
pub const PRY_SLOT_MM: [f64; 3] = [1.0, 4.0, 0.8];

/// Minimum wall of printed resin, mm.
pub const RESIN_WALL_MM: f64 = 0.5;

/// Width of board between two holes for wires, mm.
const HOLE_WEB_MM: f64 = 0.2;

/// Radial margin of the hole above an LED, mm.
pub const LED_HOLE_MARGIN_MM: f64 = 0.05;

/// Poses of the LEDs on the board, z axis up. Even ones are white, odd ones UV.
pub fn led_poses(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Vec<Pose> {
    let out = Pose::translation(p.leds.circle_radius.mm(), 0.0, layout.board_top_z_mm);
    ring(2 * p.leds.pairs, 0.0, out)
}

/// Poses of the white LEDs, and of the UV LEDs.
pub fn leds_by_kind(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> [Vec<Pose>; 2] {
    [0, 1].map(|kind| led_poses(p, layout).into_iter().skip(kind).step_by(2).collect())
}

/// Inner and outer radius of the pocket for the board's parts, mm.
pub fn pocket_radii_mm(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> [f64; 2] {
    // It lies between the socket of the post and a rim on which the board rests.
    let inner = (layout.post_radius_mm + 1.0).max(socket_mm(p, layout) + RESIN_WALL_MM);
    [inner, layout.base_radius_mm - 1.2]
}

/// Radius of the post's socket in the base, mm.
fn socket_mm(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> f64 {
    layout.post_radius_mm + p.making.gap_mm(BASE, Process::Sla, Fit::Snug)
}

fn housing_part(name: Name, solid: Solid, material: &str, lift_mm: f64) -> Body {
    name.made(Process::Sla, solid)
        .with_material(material)
        .placed([SENSOR.in_place().lifted(lift_mm)])
        .colored(BLACK_PLASTIC)
}

/// Returns all parts of the housing.
pub fn housing_parts(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Vec<Body> {
    [shell, holder, diffuser, camera_holder, led_board, base].map(|make| make(p, layout)).to_vec()
}

/// Returns the acrylic shell: a dome, its foot, and the bore that a ball mill leaves.
fn shell(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Body {
    let dome = layout.ellipsoid.whole(layout.shell_offset_mm).minus(Solid::below(0.0));
    let foot = Solid::cylinder(layout.foot_radius_mm, CUT_OVERLAP_MM - layout.foot_z_mm)
        .at_z(layout.foot_z_mm);
    let mill = p.shell.ball_mill_diameter.mm() / 2.0;
    let cavity =
        layout.ellipsoid.cavity(layout.cavity_depth_mm, mill, layout.foot_z_mm - CUT_OVERLAP_MM);
    housing_part(
        SHELL,
        Solid::union([dome, foot.named("foot")]).minus(cavity.named("inside")),
        &p.shell.material,
        16.0,
    )
    .made_by(Process::Cnc)
    .colored(GLASS)
    .as_window(window_transparency(&p.shell.material))
    .with_bed_orientation(flipped())
    .notes([
        "machine the inside first, then turn the outside on a plug; vapor polish both",
        "the inside's tip is rounded by the ball mill: elsewhere the wall is even",
    ])
}

/// Returns the ring into which the shell is glued. It slides over the base and is held by the bolts.
fn holder(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Body {
    let outline = [
        ([layout.collar_radius_mm, 0.0], 0.0),
        ([layout.collar_radius_mm, layout.step_z_mm], 0.0),
        ([layout.skirt_radius_mm, layout.step_z_mm], 0.0),
        ([layout.skirt_radius_mm, layout.flange_z_mm], 0.0),
        ([layout.holder_radius_mm, layout.flange_z_mm], 0.0),
        ([layout.holder_radius_mm, 0.0], p.holder.edge_fillet.mm()),
    ];
    let snug = p.making.gap_mm(HOLDER, Process::Sla, Fit::Snug);
    let through = layout.holder_radius_mm - layout.base_radius_mm + CUT_OVERLAP_MM;
    housing_part(HOLDER, Solid::revolution(edge::rounded(&outline)), &p.holder.material, -14.0)
        .with_handles(1)
        .cut(Joints::new(p, layout).holder.clearance_cut(through, snug))
        .notes([
            "the end with the small bore up; wet-sand the top, the elastomers' feet rest on it",
            "instant adhesive around the shell's foot",
        ])
}

/// Radius of the diffuser's bore around the post, mm.
pub fn diffuser_bore_mm(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> f64 {
    layout.post_radius_mm + p.making.gap_mm(DIFFUSER, Process::Sla, Fit::Free)
}

/// Returns the white ring over the LEDs. It would absorb UV light, which passes through holes instead.
fn diffuser(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Body {
    let bore = diffuser_bore_mm(p, layout);
    let outline = [
        [bore, layout.diffuser_plate_z_mm],
        [layout.diffuser_wall_radius_mm, layout.diffuser_plate_z_mm],
        [layout.diffuser_wall_radius_mm, layout.board_top_z_mm],
        [layout.board_radius_mm, layout.board_top_z_mm],
        [layout.board_radius_mm, layout.diffuser_top_z_mm],
        [bore, layout.diffuser_top_z_mm],
    ];
    let hole = Solid::cylinder(
        p.leds.diameter.mm() / 2.0 + LED_HOLE_MARGIN_MM,
        layout.diffuser_top_z_mm - layout.diffuser_plate_z_mm + 2.0 * CUT_OVERLAP_MM,
    );
    let [_, uv] = leds_by_kind(p, layout);
    let above = layout.diffuser_plate_z_mm - CUT_OVERLAP_MM - layout.board_top_z_mm;
    let lifted: Vec<Pose> =
        uv.iter().map(|pose| pose.then_in(Pose::translation(0.0, 0.0, above))).collect();
    housing_part(
        DIFFUSER,
        Solid::revolution(Path::polygon(&outline)).minus_all(copies("uv hole", &lifted, &hole)),
        &p.diffuser.material,
        -28.0,
    )
    .with_clarity(OpticalClarity::Translucent)
    .colored(WHITE)
    .with_bed_orientation(flipped())
    .with_landmarks(landmarks_at("uv hole", &uv))
    .with_handles(1 + p.leds.pairs as i32)
    .notes(["white resin; the plate on the bed, holes over the UV LEDs"])
}

/// Returns the post that carries the camera through board and diffuser. The camera's cable leaves it below.
fn camera_holder(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Body {
    let back = layout.camera_front_z_mm - p.camera.length.mm();
    let outline = [
        [layout.cable_radius_mm, layout.post_end_z_mm],
        [layout.post_radius_mm, layout.post_end_z_mm],
        [layout.post_radius_mm, layout.camera_front_z_mm],
        [layout.post_bore_radius_mm, layout.camera_front_z_mm],
        [layout.post_bore_radius_mm, back],
        [layout.cable_radius_mm, back],
    ];
    housing_part(POST, Solid::revolution(Path::polygon(&outline)), &p.holder.material, -44.0)
        .with_handles(1)
        .notes([
            "upright, the wide bore up",
            "thread the cable from above before the plug is soldered on; the camera ends flush",
        ])
}

/// Slot for the board's wires, across the radius that points at it. It opens into the pocket alone.
pub fn wire_slot(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> FloorSlot {
    let (length, width) = (p.base.wire_slot_length, p.base.wire_slot_width);
    let out = pocket_radii_mm(p, layout)[0] + width.mm() / 2.0 + 0.1;
    let (sin, cos) = p.base.cable_angle.rad().sin_cos();
    FloorSlot { length, width, along: 1, at: [out * cos, out * sin], turn: p.base.cable_angle }
}

/// Distance between two wires' centres in the slot, mm. The board keeps a bridge between two holes, and the wires'
/// insulation does not rub.
fn wire_pitch_mm(p: &HalfEllipsoid) -> f64 {
    let board = &p.led_board;
    (board.wire_hole_diameter.mm() + HOLE_WEB_MM).max(board.wire_diameter.mm() + 0.05)
}

/// Length of the slot that the wires need, mm.
pub fn wire_row_mm(p: &HalfEllipsoid) -> f64 {
    let board = &p.led_board;
    let widest = board.wire_hole_diameter.mm().max(board.wire_diameter.mm());
    f64::from(board.wires - 1) * wire_pitch_mm(p) + widest
}

/// Positions of the wires, mm: side by side in the middle of the slot.
pub fn wire_positions(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Vec<[f64; 2]> {
    let slot = wire_slot(p, layout);
    let (sin, cos) = slot.turn.rad().sin_cos();
    let middle = f64::from(p.led_board.wires - 1) / 2.0;
    let aside = |i: u32| (f64::from(i) - middle) * wire_pitch_mm(p);
    let at = |aside: f64| [slot.at[0] - aside * sin, slot.at[1] + aside * cos];
    (0..p.led_board.wires).map(aside).map(at).collect()
}

/// Cable exits that a plate below the sensor must leave free: the camera's cable at the axis, and the wires.
pub fn cable_exits(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Vec<CableOutlet> {
    let (slot, wire) = (wire_slot(p, layout), p.led_board.wire_diameter.mm());
    let along = f64::from(p.led_board.wires - 1) * wire_pitch_mm(p) + wire;
    let cable = [p.camera.cable_diameter.mm() / 2.0; 2];
    vec![
        CableOutlet::Below { at: [0.0; 2], half_mm: cable, turn: slot.turn },
        CableOutlet::Below { at: slot.at, half_mm: [wire / 2.0, along / 2.0], turn: slot.turn },
    ]
}

/// Returns the LED board, whose resistors and switch are on its lower side.
fn led_board(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Body {
    // The board is a circuit board whatever process `making` sets for other parts, so its gap is fixed.
    let bore = layout.post_radius_mm + crate::gap_mm(Process::Pcb, Fit::Free);
    let wire = p.led_board.wire_hole_diameter.mm() / 2.0;
    let profile = wire_positions(p, layout).into_iter().fold(
        Profile::new(Path::circle([0.0; 2], layout.board_radius_mm))
            .with_hole(Path::circle([0.0; 2], bore)),
        |profile, centre| profile.with_hole(Path::circle(centre, wire)),
    );
    let landmarks = led_poses(p, layout).into_iter().enumerate().map(|(i, pose)| {
        let kind = if i % 2 == 0 { "white" } else { "uv" };
        Landmark::at(format!("{kind} led {}", i / 2 + 1), &pose)
    });
    housing_part(
        LED_BOARD,
        Solid::extrusion(profile, p.led_board.thickness.mm()).at_z(layout.base_top_z_mm),
        &p.led_board.material,
        -50.0,
    )
    .made_by(Process::Pcb)
    .colored(MASK_GREEN)
    .with_landmarks(landmarks)
    .with_handles(1 + p.led_board.wires as i32)
    .notes([
        "white and UV LEDs alternate; two parallel circuits, a resistor for each",
        "resistors and the dual switch on the underside, inside the base's pocket, off the wires' slot",
        "a hole for each wire: supply, ground, and one that switches each kind of LEDs",
    ])
}

/// Returns the plug to which all electronics are glued.
fn base(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Body {
    let [pocket_inner, pocket_outer] = pocket_radii_mm(p, layout);
    let socket = socket_mm(p, layout);
    let chamfer = 0.3;
    // One profile: passage for the cable, socket of the post, pocket, plug and flange.
    let plug_top = layout.base_top_z_mm;
    let mut outline = vec![
        [layout.cable_radius_mm, layout.bottom_z_mm],
        [layout.holder_radius_mm, layout.bottom_z_mm],
        [layout.holder_radius_mm, layout.flange_z_mm],
        [layout.base_radius_mm, layout.flange_z_mm],
        [layout.base_radius_mm, plug_top - chamfer],
        [layout.base_radius_mm - chamfer, plug_top],
    ];
    if layout.pocket_z_mm < plug_top {
        outline.extend([
            [pocket_outer, plug_top],
            [pocket_outer, layout.pocket_z_mm],
            [pocket_inner, layout.pocket_z_mm],
            [pocket_inner, plug_top],
        ]);
    }
    outline.extend([
        [socket, plug_top],
        [socket, layout.post_end_z_mm],
        [layout.cable_radius_mm, layout.post_end_z_mm],
    ]);

    let [pry_depth, pry_width, pry_height] = PRY_SLOT_MM;
    let pry_slots = [0, 1].map(|i| {
        // Twice as deep as visible: the outer half cuts only air, whatever the curvature.
        Solid::cuboid(2.0 * pry_depth, pry_width, pry_height + CUT_OVERLAP_MM)
            .at(layout.holder_radius_mm, 0.0, layout.flange_z_mm - pry_height)
            .turned_z(turn(2 * i + 1, 4, 0.0))
            .named(format!("pry slot {}", i + 1))
    });
    let joints = Joints::new(p, layout);
    housing_part(BASE, Solid::revolution(Path::polygon(&outline)), &p.holder.material, -66.0)
        .cut(wire_slot(p, layout).cut("wire slot", [layout.bottom_z_mm, plug_top]))
        .cut(joints.holder.thread_cut())
        .cut(joints.mounting.thread_cut())
        .cut(holes(pry_slots))
        .with_handles(1) // The passage of the camera's cable.
        .notes([
            "flange on the bed",
            "glue in this order: post with camera, board, diffusion ring",
            "the bolts cut their own threads; drive them once before anything is glued",
        ])
}

// ------ Layers ------
//
// Cast bodies: the three elastomers, and the silicone molds in which they are cast.
//
// A solid and its negative are cut from the same tree, so that the chain from print to silicone to elastomer closes.

const RED_ELASTOMER: Color = [224, 170, 165];
const BLUE_ELASTOMER: Color = [150, 180, 225];
const BLACK_GREY: Color = [62, 64, 70];
const SILICONE: Color = [120, 190, 170];

fn layer(name: Name, solid: Solid, material: &str) -> Body {
    name.cast(solid).with_material(material).colored(SILICONE)
    // Bowls with blind slots or pegs have no handles.
}

/// Returns the elastomers, innermost first, then the silicone molds.
pub fn layers(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Vec<Body> {
    let mut layers = elastomers(p, layout);
    layers.push(core(p, layout));
    layers.extend(Boundary::for_design(p).into_iter().map(|boundary| cup(p, layout, boundary)));
    layers
}

/// Names of the translucent elastomers, from the inside out.
pub fn elastomer_names(p: &HalfEllipsoid) -> Vec<Name> {
    let all = Boundary::for_design(p).into_iter().map(Boundary::layer);
    all.filter(|name| *name != BLACK).collect()
}

/// Molds that a layer is in, from the one in which it is cast onwards.
fn molds_from(p: &HalfEllipsoid, boundary: Boundary) -> Vec<AssemblyName> {
    let all = Boundary::for_design(p).into_iter();
    all.skip_while(|other| *other != boundary).map(Boundary::casting_assembly).collect()
}

fn elastomers(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Vec<Body> {
    let slotted = molds::slotted_solid(p, layout);
    let whole = |offset| layout.ellipsoid.whole(offset);
    let above_base = |solid: Solid| solid.minus(Solid::below(0.0));
    let placed = |lift_mm: f64, boundary: Boundary| -> Vec<Placement> {
        let in_tools = molds_from(p, boundary).into_iter();
        let in_tools = in_tools.map(|tool| tool.in_place().lifted(TOOL_LIFT_MM));
        std::iter::once(SENSOR.in_place().lifted(lift_mm)).chain(in_tools).collect()
    };
    let mut all = vec![
        layer(
            INNER,
            above_base(slotted.clone()).minus(whole(layout.shell_offset_mm)),
            &p.inner_elastomer.material,
        )
        .colored(RED_ELASTOMER)
        .opaque(0.8)
        .placed(placed(44.0, Boundary::Inner)),
        layer(
            OUTER,
            above_base(whole(layout.outer_offset_mm)).minus(slotted),
            &p.outer_elastomer.material,
        )
        .colored(BLUE_ELASTOMER)
        .opaque(0.8)
        .placed(placed(72.0, Boundary::Outer)),
        layer(
            BLACK,
            // This is not the touched surface's own solid. OpenCascade cuts an ellipsoid from an ellipsoid, but not
            // from the same shape as a revolved profile. A test compares both.
            above_base(whole(layout.black_offset_mm)).minus(whole(layout.outer_offset_mm)),
            &p.black_gel.material,
        )
        .colored(BLACK_GREY)
        .placed(placed(100.0, Boundary::Black)),
    ];
    if p.markers.is_plain() {
        all.retain(|body| body.name != OUTER.name);
    }
    all
}

/// Displacement of elastomers off the core in exploded views of the molds, mm.
const TOOL_LIFT_MM: f64 = 45.0;

/// Returns the core: the inner boundary of the inner elastomer, on a flange that closes all three molds.
fn core(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Body {
    let flange = Solid::cylinder(layout.silicone_radius_mm, -layout.core_flange_z_mm)
        .at_z(layout.core_flange_z_mm);
    let pieces = [flange, layout.ellipsoid.dome_tool(layout.shell_offset_mm).named("core")];
    layer(
        CORE,
        Solid::union(pieces.into_iter().chain(keys(p, layout))).minus_all(flange_openings(
            p,
            layout,
            CUT_OVERLAP_MM,
        )),
        &p.tooling.silicone_material,
    )
    .placed(
        std::iter::once(CAST_CORE)
            .chain(molds_from(p, Boundary::Inner))
            .map(AssemblyName::in_place),
    )
    // Handles: the vents, and the seat of the syringe.
    .with_handles(1 + p.tooling.vents as i32)
    .with_tool_access(molds::syringe(p, layout))
}

/// Returns the silicone mold for the outer boundary of one layer.
fn cup(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout, boundary: Boundary) -> Body {
    let block = Solid::cylinder(layout.silicone_radius_mm, layout.silicone_top_z_mm);
    let cavity = match boundary {
        Boundary::Inner => molds::slotted_solid(p, layout),
        Boundary::Outer => layout.ellipsoid.whole(layout.outer_offset_mm),
        Boundary::Black => layout.ellipsoid.whole(layout.black_offset_mm),
    };
    let vent = (boundary == Boundary::Outer).then(|| tip_vent(p, layout));
    let vents = i32::from(vent.is_some());
    layer(
        boundary.cup(),
        block.minus(cavity.named("cavity")).minus_all(keys(p, layout)).minus_all(vent),
        &p.tooling.silicone_material,
    )
    .placed([
        boundary.mold_casting_assembly().in_place().lifted(60.0),
        boundary.casting_assembly().in_place().lifted(110.0),
    ])
    .with_handles(vents)
}
