//! Molds, and the tools around them.

use fabkit_geometry::{
    Angle, Body, CUT_OVERLAP_MM, Path, Placement, Pose, Process, Solid, Vector3,
};

use super::parameters::*;
use super::{Layout, dome_tool};
use crate::assembling::{AssemblyName, Name, flipped};
use crate::blocks::cup_and_bridge::{CupAndBridge, bowl};
use crate::blocks::mold::{self as molds, Half};
use crate::blocks::{
    MOLD_BLUE, ORingSeat, PRINTED_WALL_MM, TOOL_GREY, VentedLid, copies, holes, turn,
};
use crate::fits::Fit;
use crate::hardware::tools::pry;

// ------ Mold ------
//
// Molds with lid and vents, in two halves or of silicone in a cup; and the collar that joins the cured module to its
// shell while it is still in the mold.
//
// A mold stands in the sensor frame with its mouth at z = 0, facing down: in use it is turned
// over, filled, and the tube pushed in from above. Air and surplus rise to the gel's foot, the
// highest point, and leave through the lid's vents.

/// What casts a seamless mold.
pub struct FormTools {
    /// Where cup, bridge, tube and silicone stand together.
    pub assembly: AssemblyName,
    /// What hangs the tube into the cup.
    pub bridge: Name,
    /// The glass tube whose outside the layer gets.
    pub tube: Name,
    /// The mold.
    pub mold: Name,
}

/// Which layer a mold casts.
pub struct Cavity {
    /// Which, in the names of steps.
    pub what: &'static str,
    /// In what it is cast.
    pub route: MoldRoute,
    /// What casts its mold of silicone.
    pub form: FormTools,
    /// The halves that cast it.
    pub halves: [Name; 2],
    /// What closes them.
    pub lid: Name,
    /// Where mold and layer stand together.
    pub assembly: AssemblyName,
    /// Linear shrinkage of its material.
    pub shrinkage: f64,
    /// Outer radius of the layer, mm.
    pub radius: f64,
    /// Outer radius of what stands inside the mold, mm.
    pub core_radius: f64,
}

impl Cavity {
    /// What shapes the layer's outside.
    pub fn walls(&self) -> Vec<Name> {
        match self.route {
            MoldRoute::Silicone => vec![self.form.mold],
            MoldRoute::Printed => self.halves.to_vec(),
        }
    }
}

/// The two halves: `a` holds the dowels, `b` slides onto them.
pub fn halves(p: &Dome, layout: &Layout, cavity: &Cavity) -> [Body; 2] {
    let [a, b] = cavity.halves;
    [half(p, layout, cavity, a, Half::A), half(p, layout, cavity, b, Half::B)]
}

fn half(p: &Dome, layout: &Layout, cavity: &Cavity, name: Name, which: Half) -> Body {
    let outwards = which.outwards();
    name.made(
        Process::Fdm,
        molds::half(&p.mold, &p.making, name, which)
            .minus(dome_tool(cavity.radius, layout.wall_height_mm).named("cavity")),
    )
    .from(&p.mold.material)
    .placed(
        used_in(cavity).into_iter().map(|p| p.moved_apart(Vector3::new(outwards * 30.0, 0.0, 0.0))),
    )
    .colored(MOLD_BLUE)
    .lying(Pose::rotation_y(Angle::from_deg(90.0 * outwards).expect("finite")))
    .note("parting face up, 0.12 mm layers; sand and seal the cavity")
    .in_layers(0.12)
    .note(match which {
        Half::A => "press the dowels in; they stay here",
        Half::B => "must slide onto the dowels of half a by hand",
    })
    .for_shrinkage(cavity.shrinkage)
}

pub(super) fn used_in(cavity: &Cavity) -> Vec<Placement> {
    let joining = (cavity.assembly == TRANSLUCENT_MOLD).then_some(JOINING);
    std::iter::once(cavity.assembly).chain(joining).map(AssemblyName::in_place).collect()
}

/// The vents over the gel's foot.
pub fn vents(p: &Dome, cavity: &Cavity) -> VentedLid {
    let foot = [cavity.core_radius, cavity.radius];
    VentedLid::over(foot, (p.mold.vents, p.mold.vent_diameter))
}

/// The lid: centres the connector and so the tube, lets air and surplus out.
pub fn lid(p: &Dome, layout: &Layout, cavity: &Cavity) -> Body {
    let thickness = p.mold.lid_thickness.mm();
    let vents = vents(p, cavity);
    let through = |radius: f64| {
        Solid::cylinder(radius, thickness + 2.0 * CUT_OVERLAP_MM).at_z(-thickness - CUT_OVERLAP_MM)
    };
    let slide = p.making.gap_mm(cavity.lid, Process::Fdm, Fit::Slide);
    let bore = through(plug_radius_mm(p, layout) + slide);
    let plate = match cavity.route {
        MoldRoute::Printed => {
            let dowel = molds::dowel_tool(&p.mold, slide, thickness + CUT_OVERLAP_MM);
            let dowels = copies("dowel hole", &molds::lid_dowel_poses(&p.mold), &dowel);
            let plate = cavity.lid.made(Process::Fdm, molds::plate(&p.mold, thickness));
            plate.cut(holes(dowels).with_handles(2)).cut(holes(molds::plate_pry_slots(&p.mold)))
        }
        MoldRoute::Silicone => cavity.lid.made(Process::Fdm, disc(p, layout, slide, thickness)),
    };
    pried(p, layout, plate, slide, thickness)
        .cut(holes([bore.named("bore")]).with_handles(1))
        .cut(vents.cut(through))
        .cut(vents.overflow(-thickness))
        .from(&p.mold.material)
        .placed([cavity.assembly.in_place().lifted(-30.0)])
        .colored(TOOL_GREY)
        .lying(flipped())
        .note("the flat side closes the mold, the channel faces up")
        .for_shrinkage(cavity.shrinkage)
}

/// How far a pry slot reaches into a round lid or collar, mm.
const DISC_PRY_MM: f64 = 2.0;

/// Height of those slots, mm: the cup's notches end before the mold's mouth, and the blade goes in over that.
fn disc_gap_mm(p: &Dome, thickness: f64) -> f64 {
    let least = p.mold.pry_gap.mm() / 2.0;
    (least + NOTCH_DAM_MM).min(thickness - PRINTED_WALL_MM).max(least)
}

/// A round plate with the screwdrivers that lift it.
fn pried(p: &Dome, layout: &Layout, plate: Body, slide: f64, thickness: f64) -> Body {
    if p.molds.route == MoldRoute::Printed {
        return plate;
    }
    let radius = cup(p, layout).silicone_radius - slide;
    let middle = (disc_gap_mm(p, thickness) + NOTCH_DAM_MM) / 2.0;
    let mouth = Pose::translation(radius, 0.0, -middle);
    let turns = NOTCHES.map(notch_turn).into_iter();
    turns.fold(plate, |plate, turn| {
        plate.reached(pry(Pose::rotation_z(turn).then_in(mouth), DISC_PRY_MM))
    })
}

/// A round plate below z = 0 that the cup of a silicone mold centres, with pry slots behind the cup's
/// notches.
fn disc(p: &Dome, layout: &Layout, slide: f64, thickness: f64) -> Solid {
    let radius = cup(p, layout).silicone_radius - slide;
    let (gap, length) = (disc_gap_mm(p, thickness), p.mold.pry_length.mm());
    let slot = Solid::cuboid(2.0 * DISC_PRY_MM, length, gap + CUT_OVERLAP_MM).at(radius, 0.0, -gap);
    let slots = NOTCHES.map(|i| {
        let slot = slot.clone().turned_z(notch_turn(i));
        slot.named(format!("pry slot {}", i + 1))
    });
    Solid::rod(radius, [-thickness, 0.0]).minus_all(slots)
}

/// The ring that centres the shell over the module while the filling gel cures.
pub fn collar(p: &Dome, layout: &Layout) -> Body {
    let grip = p.mold.dowel_length.mm() / 2.0;
    let floor = 1.0;
    let thickness = grip + floor;
    let slide = p.making.gap_mm(COLLAR, Process::Fdm, Fit::Slide);
    let bore = Solid::cylinder(layout.shell_radius_mm + slide, thickness + 2.0 * CUT_OVERLAP_MM)
        .at_z(-thickness - CUT_OVERLAP_MM);
    let plate = match p.molds.route {
        MoldRoute::Printed => {
            let spare = 0.3;
            let dowel = molds::dowel_tool(&p.mold, slide, grip + spare);
            let sockets = copies("socket", &molds::lid_dowel_poses(&p.mold), &dowel);
            molds::plate(&p.mold, thickness)
                .minus_all(sockets)
                .minus_all(molds::plate_pry_slots(&p.mold))
        }
        MoldRoute::Silicone => disc(p, layout, slide, thickness),
    };
    let plate = COLLAR.made(Process::Fdm, plate.minus(bore.named("bore")));
    pried(p, layout, plate, slide, thickness)
        .from(&p.mold.material)
        .placed([JOINING.in_place().lifted(-20.0)])
        .colored(TOOL_GREY)
        .note("sockets up")
        .with_handles(1)
}

// ------ Tooling ------
//
// Tools around the molds: the connector that holds the tube, the form that casts a silicone mold
// around a glass tube, the coating container and its holder.
//
// All stand in the sensor frame; like the molds they are used tip down.

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
    let used = used_in(cavity).into_iter().map(|place| place.lifted(35.0));
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
