//! Tools around the molds: the connector that holds the tube, the form that casts a silicone mold
//! around a glass tube, the coating container and its holder.
//!
//! All stand in the sensor frame; like the molds they are used tip down.

use fabkit_geometry::{Angle, Body, CUT_OVERLAP_MM, Path, Pose, Process, Solid};

use super::bodies::*;
use super::joints::Joints;
use super::layout::Layout;
use super::parameters::Dome;
use super::surface::dome_tool;
use crate::assembling::{Name, flipped};
use crate::blocks::{TOOL_GREY, turn};
use crate::fits::{Fit, gap_mm};

/// Thickness of the connector's flange, mm.
const FLANGE_MM: f64 = 3.0;

/// How much smaller than the tube the flange is, mm per side: it must clear the lid's channel.
pub(super) const FLANGE_INSET_MM: f64 = 0.25;

/// Gap between the holder and the foot of the gel that hangs below it, mm.
const HOLDER_GAP_MM: f64 = 0.5;

/// Radius of the hole through which a cured mold is pushed out of its cup, mm.
pub(super) const PUSH_HOLE_RADIUS_MM: f64 = 1.5;

/// Number of windows in the bridge to pour through.
const POUR_WINDOWS: u32 = 3;

/// Radius of the connector's plug, mm: it slides into the tube.
pub fn plug_radius_mm(layout: &Layout) -> f64 {
    layout.tube_bore_radius_mm - gap_mm(Process::Fdm, Fit::Slide)
}

/// Width of the O-ring's groove, in cords: a squeezed cord grows wider.
pub const GROOVE_CORDS: f64 = 1.3;

/// Radius of the bottom of the O-ring's groove, mm.
pub fn groove_radius_mm(p: &Dome, layout: &Layout) -> f64 {
    layout.tube_bore_radius_mm - p.connector.o_ring_cord.mm() * (1.0 - p.connector.o_ring_squeeze)
}

/// The handle that the tube hangs on while gel is cast around it: an O-ring grips the tube's
/// inside, the neck passes the lid, the flange stops on it, a channel lets the tube's air out.
pub fn connector(p: &Dome, layout: &Layout) -> Body {
    let plug = plug_radius_mm(layout);
    let groove = groove_radius_mm(p, layout);
    let groove_half = GROOVE_CORDS / 2.0 * p.connector.o_ring_cord.mm();
    let groove_z = p.connector.plug_length.mm() / 2.0;
    let flange_radius = layout.tube_radius_mm - FLANGE_INSET_MM;
    let (handle, air) =
        (p.connector.handle_diameter.mm() / 2.0, p.connector.air_channel_diameter.mm() / 2.0);
    let flange_top = -p.mold.lid_thickness.mm();
    let flange_bottom = flange_top - FLANGE_MM;
    let handle_end = flange_bottom - p.connector.handle_length.mm();
    let plug_end = p.connector.plug_length.mm();
    let outline = Path::polygon(&[
        [air, handle_end],
        [handle, handle_end],
        [handle, flange_bottom],
        [flange_radius, flange_bottom],
        [flange_radius, flange_top],
        [plug, flange_top],
        [plug, groove_z - groove_half],
        [groove, groove_z - groove_half],
        [groove, groove_z + groove_half],
        [plug, groove_z + groove_half],
        [plug, plug_end],
        [air, plug_end],
    ]);
    CONNECTOR
        .made(Process::Fdm, Solid::revolution(outline))
        .from(&p.mold.material)
        .placed([TRANSPARENT_MOLD, TRANSLUCENT_MOLD, COATING].map(|a| a.in_place().lifted(-55.0)))
        .colored(TOOL_GREY)
        .lying(flipped())
        .note("plug down, handle up")
        .note("put the O-ring on dry")
        .with_handles(1)
}

/// Heights and radii of the silicone form, mm, sensor frame.
#[derive(Clone, Debug, PartialEq)]
pub struct FormLayout {
    /// Outside of the silicone, inside of the cup.
    pub silicone_radius: f64,
    /// Top of the silicone (its floor in use).
    pub silicone_top_z: f64,
    /// Rim of the cup.
    pub cup_rim_z: f64,
    /// Outside of the cup.
    pub cup_radius: f64,
    /// Side of the bridge that faces away from the cup.
    pub bridge_z: f64,
    /// Where the tube's rim rests on the bridge's sleeve.
    pub sleeve_z: f64,
    /// Open end of the tube.
    pub rim_z: f64,
}

impl FormLayout {
    /// Height of the tube's rim, mm.
    const RIM_HEIGHT_MM: f64 = 1.5;

    /// Derives the form.
    pub fn new(p: &Dome, layout: &Layout) -> Self {
        let silicone_radius = layout.transparent_radius_mm + p.form.silicone.mm();
        let tip_z = layout.wall_height_mm + layout.transparent_radius_mm;
        let rim_z = tip_z - p.form.tube_length.mm();
        let cup_rim_z = -p.form.headroom.mm();
        Self {
            silicone_radius,
            silicone_top_z: tip_z + p.form.silicone_floor.mm(),
            cup_rim_z,
            cup_radius: silicone_radius + p.form.cup_wall.mm(),
            bridge_z: cup_rim_z - p.form.plate.mm(),
            sleeve_z: rim_z + Self::RIM_HEIGHT_MM,
            rim_z,
        }
    }
}

/// Cup and bridge.
pub fn form_parts(p: &Dome, layout: &Layout) -> [Body; 2] {
    let form = FormLayout::new(p, layout);
    let tool = |name: Name, solid, genus, lift_mm, notes: &[&str]| {
        name.made(Process::Fdm, solid)
            .from(&p.mold.material)
            .placed([FORM.in_place().lifted(lift_mm)])
            .colored(TOOL_GREY)
            .lying(flipped())
            .notes(notes.iter().copied())
            .with_handles(genus)
    };
    let cup = tool(
        FORM_CUP,
        cup(p, &form),
        1,
        70.0,
        &["tape the hole in the floor before pouring; push the cured mold out through it"],
    );
    let bridge = tool(
        FORM_BRIDGE,
        bridge(p, layout, &form),
        1 + POUR_WINDOWS as i32,
        -30.0,
        &["sleeve up, no supports"],
    );
    let (joint, gap) = (Joints::new(p, layout).form, gap_mm(Process::Fdm, Fit::Snug));
    [cup.cut(joint.held().unmarked()), bridge.cut(joint.passed(p.form.plate.mm(), gap).unmarked())]
}

fn cup(p: &Dome, form: &FormLayout) -> Solid {
    let floor_z = form.silicone_top_z + p.form.plate.mm();
    let bowl = Path::polygon(&[
        [0.0, form.silicone_top_z],
        [form.silicone_radius, form.silicone_top_z],
        [form.silicone_radius, form.cup_rim_z],
        [form.cup_radius, form.cup_rim_z],
        [form.cup_radius, floor_z],
        [0.0, floor_z],
    ]);
    let push_hole = Solid::cylinder(PUSH_HOLE_RADIUS_MM, p.form.plate.mm() + 2.0 * CUT_OVERLAP_MM)
        .at_z(form.silicone_top_z - CUT_OVERLAP_MM);
    Solid::revolution(bowl).minus(push_hole.named("push hole"))
}

fn bridge(p: &Dome, layout: &Layout, form: &FormLayout) -> Solid {
    let bore = layout.transparent_radius_mm + gap_mm(Process::Fdm, Fit::Slide);
    let sleeve = bore + p.form.plate.mm();
    let plate = Path::polygon(&[
        [bore, form.cup_rim_z],
        [form.cup_radius, form.cup_rim_z],
        [form.cup_radius, form.bridge_z],
        [sleeve, form.bridge_z],
        [sleeve, form.sleeve_z],
        [bore, form.sleeve_z],
    ]);
    // Windows stay over the silicone and off the sleeve.
    let rim = 1.0;
    let quarter = Angle::from_deg(25.0).expect("finite");
    let back = Angle::from_deg(-25.0).expect("finite");
    let window = Solid::extrusion(
        Path::ring_sector(sleeve + rim, form.silicone_radius - rim, back, quarter),
        p.form.plate.mm() + 2.0 * CUT_OVERLAP_MM,
    )
    .at_z(form.bridge_z - CUT_OVERLAP_MM);
    let windows = (0..POUR_WINDOWS).map(|i| {
        window.clone().turned_z(turn(i, POUR_WINDOWS, 0.5)).named(format!("pour window {}", i + 1))
    });
    Solid::revolution(plate).minus_all(windows)
}

/// The silicone mold itself: glass-smooth, cut open along the parting plane when cured.
pub fn silicone_mold(p: &Dome, layout: &Layout) -> Body {
    let form = FormLayout::new(p, layout);
    SILICONE_MOLD
        .cast(
            Solid::cylinder(form.silicone_radius, form.silicone_top_z).minus(
                dome_tool(layout.transparent_radius_mm, layout.wall_height_mm).named("cavity"),
            ),
        )
        .from(&p.form.silicone_material)
        .placed([FORM.in_place().lifted(30.0)])
        .colored([90, 140, 215])
        .opaque(0.6)
}

/// Container for the black mixture, and the holder that hangs a module into it by its connector.
pub fn coating_parts(p: &Dome, layout: &Layout) -> [Body; 2] {
    let wall = p.coating.wall.mm();
    let inner = layout.surface_radius_mm + p.coating.gap.mm();
    let (rim_z, floor_z) = (-HOLDER_GAP_MM, layout.apex_z() + p.coating.gap.mm());
    let container = Solid::revolution(Path::polygon(&[
        [0.0, floor_z],
        [inner, floor_z],
        [inner, rim_z],
        [inner + wall, rim_z],
        [inner + wall, floor_z + wall],
        [0.0, floor_z + wall],
    ]));

    // The holder takes the lid's place under the connector's flange.
    let plate_z = -p.mold.lid_thickness.mm();
    let spigot_depth = wall;
    let spigot = inner - gap_mm(Process::Fdm, Fit::Slide);
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
    let slot_radius = plug_radius_mm(layout) + gap_mm(Process::Fdm, Fit::Free);
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
