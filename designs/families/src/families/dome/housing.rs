//! Shell, base, diffuser and LED board.

use fabkit_geometry::{Body, CUT_OVERLAP_MM, Color, Path, Pose, Process, Profile, Solid};

use super::bodies::*;
use super::joints::Joints;
use super::layout::Layout;
use super::parameters::{CableExit, Dome};
use super::{lock, wiring};
use crate::assembling::{flipped, in_sensor};
use crate::blocks::cable_way::FloorSlot;
use crate::blocks::{BLACK, INTO_MM, MASK_GREEN, edge, holes, led_ring, marks, turn};
use crate::fits::Fit;
use crate::hardware::Screw;
use crate::materials::glazing;

const FROST: Color = [225, 236, 240];

/// Depth, width and height of the slots for a screwdriver that pulls the base out, mm.
const PRY_SLOT_MM: [f64; 3] = [1.2, 6.0, 1.5];

/// Where the LEDs stand on the board, z axis up, x axis outwards.
pub fn led_poses(p: &Dome, layout: &Layout) -> Vec<Pose> {
    // Ribs start at 0: LEDs stand half a step off, so that neither shades the other.
    led_ring!(p.leds).poses(layout.board_top_z_mm, 0.5)
}

/// The tube that everything slides into from below, and the gel stands on.
pub fn shell(p: &Dome, layout: &Layout) -> Body {
    let wall = tube(p, layout);
    let wall =
        wall.minus_all(lock::groove_tool(p, layout)).minus_all(wiring::shell_notch(p, layout));
    let ribs = lock::ribs(p, layout, 0.0);
    let through = layout.shell_radius_mm - layout.base_radius_mm + CUT_OVERLAP_MM;
    let gap = p.making.gap_mm(SHELL, Process::Fdm, Fit::Snug);
    SHELL
        .made(Process::Fdm, Solid::union(std::iter::once(wall).chain(ribs)))
        .from(&p.shell.material)
        .placed([in_sensor(), JOINING.in_place().lifted(-45.0)])
        .colored(BLACK)
        .lying(flipped())
        .note("0.12 mm layers, no supports: the ribs overhang less than 1 mm")
        .in_layers(0.12)
        .with_supports(false)
        .note("bore the screw holes with a 2.4 mm drill if the printer closes them")
        .with_handles(1)
        .cut(Joints::new(p, layout).shell_base.passed(through, gap))
}

/// The shell without ribs: a tube, unless its upper edge is round or its rim reaches inwards.
fn tube(p: &Dome, layout: &Layout) -> Solid {
    let (radius, bore) = (layout.shell_radius_mm, layout.shell_bore_radius_mm);
    let (height, bottom) = (layout.shell_height(), layout.bottom_z_mm);
    let (fillet, shoulder) = (p.shell.edge_fillet.mm(), p.shell.shoulder.mm());
    if fillet == 0.0 && shoulder == 0.0 {
        return Solid::cylinder(radius, height).at_z(bottom).minus(
            Solid::cylinder(bore, height + 2.0 * CUT_OVERLAP_MM).at_z(bottom - CUT_OVERLAP_MM),
        );
    }
    let mut outline = vec![
        ([bore, bottom], 0.0),
        ([radius, bottom], 0.0),
        ([radius, 0.0], fillet),
        ([bore - shoulder, 0.0], 0.0),
    ];
    if shoulder > 0.0 {
        // Into the ribs, which end below it.
        let below = layout.diffuser_bottom_z_mm - INTO_MM;
        outline.extend([([bore - shoulder, below], 0.0), ([bore, below], 0.0)]);
    }
    Solid::revolution(edge::rounded(&outline))
}

/// The plug that carries the camera and closes the shell.
pub fn base(p: &Dome, layout: &Layout) -> Body {
    let chamfer = 0.6;
    let (r, top, bottom) = (layout.base_radius_mm, layout.base_top_z_mm, layout.bottom_z_mm);
    let plug = Solid::revolution(Path::polygon(&[
        [0.0, bottom],
        [r, bottom],
        [r, top - chamfer],
        [r - chamfer, top],
        [0.0, top],
    ]));

    let [pocket_x, pocket_y] = [p.camera.board.board_size, p.camera.board.board_size_y]
        .map(|edge| edge.mm() + 2.0 * p.making.gap_mm(BASE, Process::Fdm, Fit::Slide));
    let pocket_floor = layout.camera_board_bottom_z_mm;
    let pocket =
        Solid::cuboid(pocket_x, pocket_y, top - pocket_floor + CUT_OVERLAP_MM).at_z(pocket_floor);
    // Between the camera's screws there is room for its connector.
    let [relief_x, relief_y] = relief_edges_mm(p);
    let relief =
        Solid::cuboid(relief_x, relief_y, pocket_floor - layout.relief_z_mm + CUT_OVERLAP_MM)
            .at_z(layout.relief_z_mm);
    let plug = match wiring::tongue(p, layout) {
        Some(tongue) => plug.plus(tongue),
        None => plug,
    };
    let joints = Joints::new(p, layout);
    let [pry_depth, pry_width, pry_height] = PRY_SLOT_MM;
    let pry_slots = wiring::pry_turns(p).into_iter().zip(1..).map(|(turn, number)| {
        // Twice as deep as it shows: the outer half cuts air, whatever the plug's curvature.
        let slot = Solid::cuboid(2.0 * pry_depth, pry_width, pry_height + CUT_OVERLAP_MM);
        let slot = slot.at(r, 0.0, bottom - CUT_OVERLAP_MM);
        slot.turned_z(turn).named(format!("pry slot {number}"))
    });

    BASE.made(Process::Fdm, plug.minus(pocket.named("camera pocket")).minus(relief.named("relief")))
        .from(&p.shell.material)
        .placed([in_sensor().lifted(-66.0)])
        .colored(BLACK)
        .note("melt the M2 nuts in flush with the side before anything else")
        .note(match p.base.cable_exit {
            CableExit::Floor => "lead the cable through the slot, then screw the camera down",
            CableExit::Side => "lay the cable into the slit from above, then screw the camera down",
        })
        .cut(wiring::way_out(p, layout))
        .cut(joints.camera.held_through().unmarked())
        .cut(joints.shell_base.held())
        .cut(joints.mounting.held())
        .cut(holes(pry_slots))
}

/// The slot for the cable, below the camera's connector.
pub fn cable_slot(p: &Dome) -> FloorSlot {
    let (length, width) = (p.base.cable_slot_length, p.base.cable_slot_width);
    FloorSlot { length, width, along: 0, at: [0.0; 2], turn: p.base.cable_angle }
}

/// Edges of the recess behind the camera board along x and y, mm: up to the pads of its screws.
pub fn relief_edges_mm(p: &Dome) -> [f64; 2] {
    let pad = Screw::M1_6X5.pilot_hole_mm() + 1.2;
    [p.camera.board.screw_spacing, p.camera.board.screw_spacing_y].map(|spacing| spacing.mm() - pad)
}

/// The frosted ring.
pub fn diffuser(p: &Dome, layout: &Layout) -> Body {
    let (bore, notch) = (p.diffuser.bore_radius.mm(), p.diffuser.notch_radius.mm());
    let half = p.diffuser.notch_width.mm() / 2.0;
    let profile = Profile::new(Path::circle([0.0, 0.0], layout.diffuser_radius_mm))
        .with_hole(notched_circle(bore, notch, half, p.diffuser.notches));
    DIFFUSER
        .made(
            Process::Laser,
            Solid::extrusion(profile, p.diffuser.thickness.mm()).at_z(layout.diffuser_bottom_z_mm),
        )
        .from(&p.diffuser.material)
        .in_light(glazing(&p.diffuser.material))
        .placed([in_sensor().lifted(12.0), JOINING.in_place().lifted(-38.0)])
        .colored(FROST)
        .note("cut from a sheet frosted on both sides")
        .note("the gel keys into the notches")
        .with_handles(1)
}

/// A circle with `count` notches of half width `half` out to a larger radius.
pub(super) fn notched_circle(radius: f64, notch: f64, half: f64, count: u32) -> Path {
    let centre = [0.0, 0.0];
    let at = |r: f64, angle: f64| [r * angle.cos(), r * angle.sin()];
    let (inner, outer) = ((half / radius).asin(), (half / notch).asin());
    let start = at(radius, -inner);
    let mut path = Path::from(start);
    for i in 0..count {
        let middle = turn(i, count, 0.0).rad();
        let next =
            if i + 1 == count { start } else { at(radius, turn(i + 1, count, 0.0).rad() - inner) };
        path = path
            .line(at(notch, middle - outer))
            .arc(at(notch, middle + outer), centre, true)
            .line(at(radius, middle + inner))
            .arc(next, centre, true);
    }
    path
}

/// The outline of the LED board.
pub fn led_board(p: &Dome, layout: &Layout) -> Body {
    let profile = Profile::new(Path::circle([0.0, 0.0], layout.board_radius_mm))
        .with_hole(Path::circle([0.0, 0.0], p.led_board.bore_radius.mm()));
    let wires =
        wiring::hole_centres(p).map(|c| Path::circle(c, p.led_board.wire_hole_diameter.mm() / 2.0));
    let profile = wires.into_iter().fold(profile, Profile::with_hole);
    LED_BOARD
        .made(
            Process::Pcb,
            Solid::extrusion(profile, p.led_board.thickness.mm()).at_z(layout.base_top_z_mm),
        )
        .from(&p.led_board.material)
        .placed([in_sensor().lifted(-26.0)])
        .marked(marks("led", &led_poses(p, layout)))
        .colored(MASK_GREEN)
        .note("press it in from below until it meets the ribs, LEDs between the ribs")
        .note("one 470 ohm resistor for each LED")
        .with_handles(3)
}

/// The black tube in the LED board's bore; nothing where its wall is 0.
pub fn baffle(p: &Dome, layout: &Layout) -> Option<Body> {
    if p.baffle.wall.mm() == 0.0 {
        return None;
    }
    let bore = p.led_board.bore_radius.mm();
    let inside = baffle_radius_mm(p);
    let pressed = bore - p.making.gap_mm(BAFFLE, Process::Fdm, Fit::Press);
    let flange = bore + BAFFLE_FLANGE_MM;
    let (bottom, seat) = (layout.base_top_z_mm, layout.board_top_z_mm);
    let top = layout.gel_face_z_mm.min(layout.diffuser_bottom_z_mm) - p.baffle.gap.mm();
    let solid = Solid::revolution(Path::polygon(&[
        [inside, bottom],
        [pressed, bottom],
        [pressed, seat],
        [flange, seat],
        [flange, top],
        [inside, top],
    ]));
    Some(
        BAFFLE
            .made(Process::Fdm, solid)
            .from(&p.shell.material)
            .placed([in_sensor().lifted(-15.0)])
            .colored(BLACK)
            .lying(flipped())
            .note("press it into the LED board's bore from above, before the board goes into the shell")
            .with_handles(1),
    )
}

/// How far the baffle's flange reaches over the LED board, mm: the wire holes begin beyond it.
pub const BAFFLE_FLANGE_MM: f64 = 0.35;

/// Radius of what stays free for the lens inside the LED board, mm.
pub fn baffle_radius_mm(p: &Dome) -> f64 {
    p.led_board.bore_radius.mm() - p.baffle.wall.mm()
}
