//! Shell, base, diffuser and LED board, the gel that locks the contact module to them, and the layers of that module.

use fabkit_geometry::{
    Angle, Body, CUT_OVERLAP_MM, Color, DomeSurface, Path, Process, Profile, Solid,
};

use super::parameters::*;
use super::{
    BAFFLE_FLANGE_MM, DomeLayout, Joints, dome, dome_shell, dome_tool, electronics, led_poses,
    relief_edges_mm,
};
use crate::blocks::{BLACK, INTO_MM, MASK_GREEN, edge, holes, landmarks_at, turn};
use crate::chain_builder::{AssemblyName, flipped, in_sensor};
use crate::fits::Fit;
use crate::materials::window_transparency;

// ------ Housing ------
//
// Shell, base, diffuser and LED board.

/// Colour of frosted acrylic in images.
const FROST: Color = [225, 236, 240];

/// Depth, width and height of the slots for a screwdriver that pulls the base out, mm.
const PRY_SLOT_MM: [f64; 3] = [1.2, 6.0, 1.5];

/// Returns the shell: the tube that carries the gel and takes all other parts from below.
pub fn shell(p: &Dome, layout: &DomeLayout) -> Body {
    let wall = tube(p, layout);
    let wall =
        wall.minus_all(groove_tool(p, layout)).minus_all(electronics::shell_notch(p, layout));
    let ribs = ribs(p, layout, 0.0);
    let through = layout.shell_radius_mm - layout.base_radius_mm + CUT_OVERLAP_MM;
    let gap = p.making.gap_mm(SHELL, Process::Fdm, Fit::Snug);
    SHELL
        .made(Process::Fdm, Solid::union(std::iter::once(wall).chain(ribs)))
        .with_material(&p.shell.material)
        .placed([in_sensor(), JOINING.in_place().lifted(-45.0)])
        .colored(BLACK)
        .with_bed_orientation(flipped())
        .note("0.12 mm layers, no supports: the ribs overhang less than 1 mm")
        .in_layers(0.12)
        .with_supports(false)
        .note("bore the screw holes with a 2.4 mm drill if the printer closes them")
        .with_handles(1)
        .cut(Joints::new(p, layout).shell_base.clearance_cut(through, gap))
}

/// Returns the shell's tube without ribs, with the rounded upper edge and the shoulder if there are any.
fn tube(p: &Dome, layout: &DomeLayout) -> Solid {
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
        // The shoulder overlaps the ribs, which end below it.
        let below = layout.diffuser_bottom_z_mm - INTO_MM;
        outline.extend([([bore - shoulder, below], 0.0), ([bore, below], 0.0)]);
    }
    Solid::revolution(edge::rounded(&outline))
}

/// Returns the plug that carries the camera and closes the shell.
pub fn base(p: &Dome, layout: &DomeLayout) -> Body {
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
    // The connector fits between the camera's screws.
    let [relief_x, relief_y] = relief_edges_mm(p);
    let relief =
        Solid::cuboid(relief_x, relief_y, pocket_floor - layout.relief_z_mm + CUT_OVERLAP_MM)
            .at_z(layout.relief_z_mm);
    let plug = match electronics::tongue(p, layout) {
        Some(tongue) => plug.plus(tongue),
        None => plug,
    };
    let joints = Joints::new(p, layout);
    let [pry_depth, pry_width, pry_height] = PRY_SLOT_MM;
    let pry_slots = electronics::pry_turns(p).into_iter().zip(1..).map(|(turn, number)| {
        // Twice as deep as visible: the outer half cuts only air, whatever the plug's curvature.
        let slot = Solid::cuboid(2.0 * pry_depth, pry_width, pry_height + CUT_OVERLAP_MM);
        let slot = slot.at(r, 0.0, bottom - CUT_OVERLAP_MM);
        slot.turned_z(turn).named(format!("pry slot {number}"))
    });

    BASE.made(Process::Fdm, plug.minus(pocket.named("camera pocket")).minus(relief.named("relief")))
        .with_material(&p.shell.material)
        .placed([in_sensor().lifted(-66.0)])
        .colored(BLACK)
        .note("melt the M2 nuts in flush with the side before anything else")
        .note(match p.base.cable_exit {
            CableExit::Floor => "lead the cable through the slot, then screw the camera down",
            CableExit::Side => "lay the cable into the slit from above, then screw the camera down",
        })
        .cut(electronics::cable_cut(p, layout))
        .cut(joints.camera.thread_cut_through().without_landmarks())
        .cut(joints.shell_base.thread_cut())
        .cut(joints.mounting.thread_cut())
        .cut(holes(pry_slots))
}

/// Returns the frosted ring.
pub fn diffuser(p: &Dome, layout: &DomeLayout) -> Body {
    let (bore, notch) = (p.diffuser.bore_radius.mm(), p.diffuser.notch_radius.mm());
    let half = p.diffuser.notch_width.mm() / 2.0;
    let profile = Profile::new(Path::circle([0.0, 0.0], layout.diffuser_radius_mm))
        .with_hole(notched_circle(bore, notch, half, p.diffuser.notches));
    DIFFUSER
        .made(
            Process::Laser,
            Solid::extrusion(profile, p.diffuser.thickness.mm()).at_z(layout.diffuser_bottom_z_mm),
        )
        .with_material(&p.diffuser.material)
        .as_window(window_transparency(&p.diffuser.material))
        .placed([in_sensor().lifted(12.0), JOINING.in_place().lifted(-38.0)])
        .colored(FROST)
        .note("cut from a sheet frosted on both sides")
        .note("the gel keys into the notches")
        .with_handles(1)
}

/// Returns a circle with `count` notches of half width `half`, which reach out to the radius `notch`.
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

/// Returns the LED board without its parts.
pub fn led_board(p: &Dome, layout: &DomeLayout) -> Body {
    let profile = Profile::new(Path::circle([0.0, 0.0], layout.board_radius_mm))
        .with_hole(Path::circle([0.0, 0.0], p.led_board.bore_radius.mm()));
    let wires = electronics::wire_hole_centres(p)
        .map(|c| Path::circle(c, p.led_board.wire_hole_diameter.mm() / 2.0));
    let profile = wires.into_iter().fold(profile, Profile::with_hole);
    LED_BOARD
        .made(
            Process::Pcb,
            Solid::extrusion(profile, p.led_board.thickness.mm()).at_z(layout.base_top_z_mm),
        )
        .with_material(&p.led_board.material)
        .placed([in_sensor().lifted(-26.0)])
        .with_landmarks(landmarks_at("led", &led_poses(p, layout)))
        .colored(MASK_GREEN)
        .note("press it in from below until it meets the ribs, LEDs between the ribs")
        .note("one 470 ohm resistor for each LED")
        .with_handles(3)
}

/// Returns the black tube in the LED board's bore, or `None` if its wall is 0.
pub fn baffle(p: &Dome, layout: &DomeLayout) -> Option<Body> {
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
            .with_material(&p.shell.material)
            .placed([in_sensor().lifted(-15.0)])
            .colored(BLACK)
            .with_bed_orientation(flipped())
            .note("press it into the LED board's bore from above, before the board goes into the shell")
            .with_handles(1),
    )
}

/// Free radius for the lens inside the LED board and baffle, mm.
pub fn baffle_radius_mm(p: &Dome) -> f64 {
    p.led_board.bore_radius.mm() - p.baffle.wall.mm()
}

// ------ Lock ------
//
// Gel that holds the contact module: the filling gel continues through the diffuser out to the shell, around its ribs
// and into its groove.
//
// It is poured through the shell, tip down, onto the filling gel. Therefore every face that points down while pouring
// must let air out, and the groove's upper flank rises inwards.

/// Thickness of gel between the groove and the diffuser, and between the groove and the gel's own face, mm.
const GROOVE_EDGE_MM: f64 = 0.4;

/// Height of the groove's innermost face, mm.
const GROOVE_MM: f64 = 0.5;

/// Overlap of a rib with the wall that carries it, or with the wall behind the groove, mm.
const RIB_ROOT_MM: f64 = 0.5;

/// Distance of a rib's shoulder below the diffuser, mm. Gel above the shoulder closes the gap around the diffuser.
const RIB_STEP_MM: f64 = 0.3;

/// Minimum width of the diffuser's seat on a rib, mm.
pub const LEDGE_MM: f64 = 0.4;

/// Returns whether the sensor has a locking gel.
pub fn has_locking_gel(p: &Dome) -> bool {
    p.filling_gel.lock_depth.mm() > 0.0
}

/// Minimum depth of the locking gel that covers the groove, mm.
pub fn min_groove_gel_mm(p: &Dome) -> f64 {
    2.0 * GROOVE_EDGE_MM + GROOVE_MM + p.shell.lock_groove.mm()
}

/// Returns the groove's outline from the diffuser downwards as (radius, height), mm; empty if there is no groove.
fn groove(p: &Dome, layout: &DomeLayout) -> Vec<[f64; 2]> {
    let depth = p.shell.lock_groove.mm();
    if depth == 0.0 {
        return Vec::new();
    }
    let bore = layout.shell_bore_radius_mm;
    let top = layout.diffuser_bottom_z_mm - GROOVE_EDGE_MM;
    let inmost = top - GROOVE_MM;
    // The 45 degree flank prints without support and traps no air.
    vec![[bore, top], [bore + depth, top], [bore + depth, inmost], [bore, inmost - depth]]
}

/// Returns the solid that cuts the groove into the shell's bore.
pub fn groove_tool(p: &Dome, layout: &DomeLayout) -> Option<Solid> {
    let outline = groove(p, layout);
    let (first, last) = (outline.first()?, outline.last()?);
    // The tool starts inside the bore, so that no faces coincide.
    let inside = layout.shell_bore_radius_mm - INTO_MM;
    let outline = [&[[inside, last[1]], [inside, first[1]]], &outline[..]].concat();
    Some(Solid::revolution(Path::polygon(&outline)).named("lock groove"))
}

/// Returns the ribs between diffuser and LED board, extended by `up_mm` at the diffuser.
pub fn ribs(p: &Dome, layout: &DomeLayout, up_mm: f64) -> Vec<Solid> {
    // A rib is a sector of a ring, so its width becomes an angle at the bore.
    let half_width = (p.shell.rib_width.mm() / 2.0 / layout.shell_bore_radius_mm).asin();
    let half_width = Angle::from_rad(half_width).expect("ribs are narrower than the shell");
    let back = Angle::from_rad(-half_width.rad()).expect("finite");
    let sector = |inner: f64, outer: f64, top: f64| {
        Solid::prism(
            Path::ring_sector(inner, outer, back, half_width),
            [layout.board_top_z_mm, top],
        )
    };
    let root = layout.shell_bore_radius_mm + p.shell.lock_groove.mm() + RIB_ROOT_MM;
    let top = layout.diffuser_bottom_z_mm + up_mm;
    let rib = if has_locking_gel(p) {
        let ledge = layout.diffuser_radius_mm - layout.rib_radius_mm;
        let bears = layout.rib_radius_mm + LEDGE_MM.max(ledge - LEDGE_MM / 2.0);
        let step = layout.diffuser_bottom_z_mm - RIB_STEP_MM;
        sector(layout.rib_radius_mm, bears, top).plus(sector(bears - INTO_MM / 2.0, root, step))
    } else {
        sector(layout.rib_radius_mm, root, top)
    };
    (0..p.shell.ribs)
        .map(|i| rib.clone().turned_z(turn(i, p.shell.ribs, 0.0)).named(format!("rib {}", i + 1)))
        .collect()
}

/// Returns the gel below the diffuser, in the diffuser's bore and notches, and around its edge.
pub fn locking_gel(p: &Dome, layout: &DomeLayout) -> Option<Body> {
    if !has_locking_gel(p) {
        return None;
    }
    let (face, under) = (layout.gel_face_z_mm, layout.diffuser_bottom_z_mm);
    let (bore, seat) = (layout.shell_bore_radius_mm, layout.seat_radius_mm);
    let mut outline = vec![[0.0, face], [bore, face]];
    outline.extend(groove(p, layout).iter().rev());
    if seat < bore {
        // The gel ends below the shoulder, which the ribs carry.
        let shoulder = under - INTO_MM;
        outline.extend([[bore, shoulder], [seat, shoulder]]);
    }
    let edge = layout.diffuser_radius_mm;
    outline.extend([[seat, 0.0], [edge, 0.0], [edge, under], [0.0, under]]);
    let d = &p.diffuser;
    let hole = notched_circle(
        d.bore_radius.mm(),
        d.notch_radius.mm(),
        d.notch_width.mm() / 2.0,
        d.notches,
    );
    let plug =
        Solid::prism(Profile::new(hole), [under - INTO_MM, 0.0]).named("through the diffuser");
    // The ribs are extended beyond the gel's face. Above it is the diffuser.
    let solid = Solid::revolution(Path::polygon(&outline)).plus(plug).minus_all(ribs(
        p,
        layout,
        CUT_OVERLAP_MM,
    ));
    Some(
        LOCKING_GEL
            .cast(solid)
            .with_material(&p.filling_gel.material)
            .placed([in_sensor().lifted(8.0), JOINING.in_place().lifted(-52.0)])
            .colored([214, 226, 236])
            .opaque(0.35)
            // The gel closes around each rib, over the rib's shoulder, which makes one handle per rib.
            .with_handles(p.shell.ribs as i32),
    )
}

// ------ Layers ------
//
// Layers of the contact module, from the inside out.

/// Returns all layers, innermost first. The coat's outside is the touched surface.
pub fn layers(p: &Dome, layout: &DomeLayout, touch: &DomeSurface) -> Vec<Body> {
    let wall = layout.wall_height_mm;
    // In every tool the layers stay together; only the sensor's exploded view takes them apart. A dome and a bowl
    // have no handles.
    let placed = |layer: Body, color: Color, opacity: f64, lift_mm: f64, tools: &[AssemblyName]| {
        let in_tools = tools.iter().map(|tool| tool.in_place());
        let layer = layer.placed([in_sensor().lifted(lift_mm)]).placed(in_tools);
        layer.colored(color).opaque(opacity)
    };
    let is_dipped = p.coat.method == CoatMethod::Dip;
    let dipped: &[AssemblyName] = if is_dipped { &[COATING] } else { &[] };
    vec![
        placed(
            FILLING_GEL
                .cast(dome(layout.tube_bore_radius_mm, wall))
                .with_material(&p.filling_gel.material),
            [214, 226, 236],
            0.35,
            26.0,
            &[JOINING],
        ),
        placed(
            TRANSPARENT_GEL
                .cast(dome_shell(layout.tube_radius_mm, layout.transparent_radius_mm, wall))
                .with_material(&p.transparent_gel.material),
            [150, 200, 235],
            0.35,
            88.0,
            &[&[TRANSPARENT_MOLD, TRANSLUCENT_MOLD, JOINING][..], dipped].concat(),
        ),
        placed(
            TRANSLUCENT_GEL
                .cast(dome_shell(layout.transparent_radius_mm, layout.translucent_radius_mm, wall))
                .with_material(&p.translucent_gel.material),
            [240, 236, 225],
            0.6,
            121.0,
            &[&[TRANSLUCENT_MOLD, JOINING][..], dipped].concat(),
        ),
        placed(
            BLACK_COAT
                .cast(
                    touch
                        .solid(0.0, touch.foot_z_mm)
                        .minus(dome_tool(layout.translucent_radius_mm, wall)),
                )
                .with_material(&p.coat.material),
            [62, 64, 70],
            1.0,
            154.0,
            if dipped.is_empty() { &[TRANSLUCENT_MOLD, JOINING] } else { &[COATING, JOINING] },
        ),
    ]
}
