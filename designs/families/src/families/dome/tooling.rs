//! Tools around the molds: the connector that holds the tube, the form that casts a silicone mold
//! around a glass tube, the coating container and its holder.
//!
//! All stand in the sensor frame; like the molds they are used tip down.

use fabkit_geometry::{Angle, Body, CUT_OVERLAP_MM, Path, Pose, Process, Solid};

use super::bodies::*;
use super::layout::Layout;
use super::mold::Cavity;
use super::parameters::{CoatMethod, Dome};
use super::surface::dome_tool;
use crate::assembling::{Name, flipped};
use crate::blocks::cup_and_bridge::{CupAndBridge, bowl};
use crate::blocks::{ORingSeat, TOOL_GREY, holes, turn};
use crate::fits::Fit;

/// Thickness of the connector's flange, mm.
const FLANGE_MM: f64 = 3.0;

/// What of the handle stays straight, mm.
const CONE_END_MM: f64 = 2.0;

/// How much smaller than the tube the flange is, mm per side: it must clear the lid's channel.
pub(super) const FLANGE_INSET_MM: f64 = 0.25;

/// Gap between the holder and the foot of the gel that hangs below it, mm.
const HOLDER_GAP_MM: f64 = 0.5;

/// Radius of the connector's plug, mm: it slides into the tube.
pub fn plug_radius_mm(p: &Dome, layout: &Layout) -> f64 {
    layout.tube_bore_radius_mm - p.making.gap_mm(CONNECTOR, Process::Fdm, Fit::Slide)
}

/// What the connector's O-ring is stretched over: the tube's bore squeezes it.
pub fn o_ring_seat(p: &Dome, layout: &Layout) -> ORingSeat {
    let (cord, squeeze) = (p.connector.o_ring_cord, p.connector.o_ring_squeeze);
    ORingSeat::squeezed_in(layout.tube_bore_radius_mm, cord, squeeze)
}

/// The handle that the tube hangs on while gel is cast around it: an O-ring grips the tube's
/// inside, the neck passes the lid, the flange stops on it, a channel lets the tube's air out.
pub fn connector(p: &Dome, layout: &Layout) -> Body {
    let plug = plug_radius_mm(p, layout);
    let groove = o_ring_seat(p, layout).groove(plug, p.connector.plug_length.mm() / 2.0);
    let flange_radius = layout.tube_radius_mm - FLANGE_INSET_MM;
    let (handle, air) =
        (p.connector.handle_diameter.mm() / 2.0, p.connector.air_channel_diameter.mm() / 2.0);
    let is_dipped = p.coat.method == CoatMethod::Dip;
    let gripped =
        [TRANSPARENT_MOLD, TRANSLUCENT_MOLD].into_iter().chain(is_dipped.then_some(COATING));
    let flange_top = -p.mold.lid_thickness.mm();
    let flange_bottom = flange_top - FLANGE_MM;
    let handle_end = flange_bottom - p.connector.handle_length.mm();
    let plug_end = p.connector.plug_length.mm();
    // Printed on its handle, the flange grows out of it at 45 degrees, as far as the handle is long enough.
    let cone = (flange_radius - handle).min(p.connector.handle_length.mm() - CONE_END_MM).max(0.0);
    let below = [
        [air, handle_end],
        [handle, handle_end],
        [handle, flange_bottom - cone],
        [flange_radius, flange_bottom],
        [flange_radius, flange_top],
        [plug, flange_top],
    ];
    let above = [[plug, plug_end], [air, plug_end]];
    let outline = Path::polygon(&[&below[..], &groove, &above].concat());
    CONNECTOR
        .made(Process::Fdm, Solid::revolution(outline))
        .from(&p.mold.material)
        .placed(gripped.map(|a| a.in_place().lifted(-55.0)))
        .colored(TOOL_GREY)
        .note("handle down, plug up, no supports")
        .with_supports(false)
        .note("put the O-ring on dry")
        .with_handles(1)
}

/// Places of the notches in the cup's rim that a screwdriver reaches the lid through: between the screws.
pub const NOTCHES: [u32; 3] = [0, 1, 2];

/// How much of the cup's rim stays above the silicone at a notch, mm.
pub const NOTCH_DAM_MM: f64 = 0.5;

/// Turns a notch from +x to its place.
pub fn notch_turn(i: u32) -> Angle {
    turn(i, NOTCHES.len() as u32, 0.5)
}

/// The cup that both silicone molds are cast in, with the narrower tube.
pub fn cup<'a>(p: &'a Dome, layout: &Layout) -> CupAndBridge<'a> {
    let tip_z = layout.wall_height_mm + layout.transparent_radius_mm;
    let bridges = [INNER_BRIDGE, OUTER_BRIDGE].map(|bridge| (bridge, Process::Fdm));
    let slide = p.making.widest_mm(bridges, Fit::Slide);
    p.form.around(layout.transparent_radius_mm, tip_z, slide)
}

/// Cup and bridge around the glass tube of a layer.
pub fn form<'a>(p: &'a Dome, layout: &Layout, cavity: &Cavity) -> CupAndBridge<'a> {
    cup(p, layout).with_tube(cavity.radius, layout.wall_height_mm + cavity.radius)
}

/// The cup: one for each mold, which stays in it.
pub fn form_cup(p: &Dome, layout: &Layout) -> Body {
    let form = cup(p, layout);
    let (rim, [inner, outer]) = form.rim();
    let length = p.mold.pry_length.mm();
    let notch = Solid::cuboid_between(
        [inner - 1.0, -length / 2.0, rim - CUT_OVERLAP_MM],
        [outer + 1.0, length / 2.0, -NOTCH_DAM_MM],
    );
    let notches = NOTCHES
        .map(|i| notch.clone().turned_z(notch_turn(i)).named(format!("pry notch {}", i + 1)));
    let used = [INNER_FORM, OUTER_FORM, TRANSPARENT_MOLD, TRANSLUCENT_MOLD, JOINING];
    form.cup(FORM_CUP)
        .cut(holes(notches))
        .from(&p.mold.material)
        .placed(used.map(|assembly| assembly.in_place().lifted(70.0)))
        .times(2)
}

/// What hangs the glass tube of a layer into the cup.
pub fn form_bridge(p: &Dome, layout: &Layout, cavity: &Cavity) -> Body {
    form(p, layout, cavity).bridge(cavity.form.bridge).from(&p.mold.material).placed([cavity
        .form
        .assembly
        .in_place()
        .lifted(-30.0)])
}

/// A silicone mold: glass-smooth and in one piece.
pub fn silicone_mold(p: &Dome, layout: &Layout, cavity: &Cavity) -> Body {
    let form = form(p, layout, cavity);
    let cavity_tool = dome_tool(cavity.radius, layout.wall_height_mm).named("cavity");
    let solid = Solid::cylinder(form.silicone_radius, form.silicone_top_z).minus(cavity_tool);
    let used = super::mold::used_in(cavity).into_iter().map(|place| place.lifted(35.0));
    cavity
        .form
        .mold
        .cast(solid)
        .from(&p.form.silicone_material)
        .placed([cavity.form.assembly.in_place().lifted(30.0)])
        .placed(used)
        .colored([90, 140, 215])
        .opaque(0.6)
}

/// Thickness of the jig's wall and floor, mm.
const JIG_WALL_MM: f64 = 3.0;

/// The sleeve that shows where the tube is cut: it stands on the sleeve's floor, tip first.
pub fn tube_jig(p: &Dome, layout: &Layout) -> Body {
    let inner = layout.tube_radius_mm + p.making.gap_mm(TUBE_JIG, Process::Fdm, Fit::Slide);
    let floor = layout.wall_height_mm + layout.tube_radius_mm;
    let sleeve = bowl([inner, inner + JIG_WALL_MM], 0.0, [floor, floor + JIG_WALL_MM]);
    TUBE_JIG
        .made(Process::Fdm, sleeve)
        .from(&p.mold.material)
        .placed([CUTTING.in_place().lifted(30.0)])
        .colored(TOOL_GREY)
        .lying(flipped())
        .note("floor down, no supports; check its depth with a calliper: it is the tube's length")
        .with_supports(false)
}

/// Container for the black mixture, and the holder that hangs a module into it by its connector.
pub fn coating_parts(p: &Dome, layout: &Layout) -> [Body; 2] {
    let wall = p.coating.wall.mm();
    let inner = layout.surface_radius_mm + p.coating.gap.mm();
    let (rim_z, floor_z) = (-HOLDER_GAP_MM, layout.apex_z() + p.coating.gap.mm());
    let container = bowl([inner, inner + wall], rim_z, [floor_z, floor_z + wall]);

    // The holder takes the lid's place under the connector's flange.
    let plate_z = -p.mold.lid_thickness.mm();
    let spigot_depth = wall;
    let spigot = inner - p.making.gap_mm(CONTAINER, Process::Fdm, Fit::Slide);
    let holder = Solid::revolution(Path::polygon(&[
        [0.0, plate_z],
        [inner + wall, plate_z],
        [inner + wall, rim_z],
        [spigot, rim_z],
        [spigot, rim_z + spigot_depth],
        [spigot - wall, rim_z + spigot_depth],
        [spigot - wall, rim_z],
        [0.0, rim_z],
    ]));
    let free = p.making.gap_mm(HOLDER, Process::Fdm, Fit::Free);
    let slot_radius = plug_radius_mm(p, layout) + free;
    let slot_height = rim_z + spigot_depth - plate_z + 2.0 * CUT_OVERLAP_MM;
    let slot =
        Solid::extrusion(Path::slot([0.0, 0.0], [0.0, 2.0 * inner], slot_radius), slot_height)
            .at_z(plate_z - CUT_OVERLAP_MM);

    let tool = |name: Name, solid, bed_from_body, lift_mm, notes: &[&str]| {
        name.made(Process::Fdm, solid)
            .from(&p.mold.material)
            .placed([COATING.in_place().lifted(lift_mm)])
            .colored(TOOL_GREY)
            .lying(bed_from_body)
            .notes(notes.iter().copied())
    };
    [
        tool(CONTAINER, container, flipped(), 40.0, &["four perimeters, so that it holds solvent"]),
        tool(
            HOLDER,
            holder.minus(slot.named("slot")),
            Pose::identity(),
            -20.0,
            &["slide it under the connector's flange, then lower both into the container"],
        ),
    ]
}
