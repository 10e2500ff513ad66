//! Molds, and the tools that are used with them.

use fabkit_geometry::{
    Angle, Body, CUT_OVERLAP_MM, Path, Placement, Pose, Process, Solid, Vector3,
};

use super::parameters::*;
use super::{DomeLayout, dome_tool};
use crate::blocks::cup_and_bridge::{CupAndBridge, bowl};
use crate::blocks::mold::{self as molds, Half};
use crate::blocks::{
    MOLD_BLUE, ORingSeat, PRINTED_WALL_MM, TOOL_GREY, VentedLid, copies, holes, turn,
};
use crate::chain_builder::{AssemblyName, Name, flipped};
use crate::fits::Fit;
use crate::hardware::tools::pry;

// ------ Mold ------
//
// Molds with lid and vents, either in two halves or of silicone in a cup, and the collar that joins the cured module
// to its shell while it is still in the mold.
//
// A mold stands in the sensor frame with its mouth at z = 0, facing down. In use it is turned over and filled, and
// the tube is pushed in from above. Air and surplus rise to the gel's foot, which is then the highest point, and
// leave through the lid's vents.

/// Tools that cast a seamless silicone mold.
pub struct FormTools {
    /// Assembly of cup, bridge, tube and silicone.
    pub assembly: AssemblyName,
    /// Bridge that hangs the tube into the cup.
    pub bridge: Name,
    /// Glass tube whose outside shapes the layer.
    pub tube: Name,
    /// Silicone mold.
    pub mold: Name,
}

/// Mold cavity of one cast layer.
pub struct Cavity {
    /// Name of the layer, as used in names of steps.
    pub layer_name: &'static str,
    /// Kind of mold.
    pub route: MoldRoute,
    /// Tools that cast the layer's silicone mold.
    pub form: FormTools,
    /// The two halves of the layer's printed mold.
    pub halves: [Name; 2],
    /// Lid that closes the mold.
    pub lid: Name,
    /// Assembly of mold and layer.
    pub assembly: AssemblyName,
    /// Linear shrinkage of the layer's material, as a fraction.
    pub shrinkage: f64,
    /// Outer radius of the layer, mm.
    pub radius: f64,
    /// Outer radius of the core that stands inside the mold, mm.
    pub core_radius: f64,
}

impl Cavity {
    /// Names of the bodies that shape the layer's outside.
    pub fn mold_walls(&self) -> Vec<Name> {
        match self.route {
            MoldRoute::Silicone => vec![self.form.mold],
            MoldRoute::Printed => self.halves.to_vec(),
        }
    }
}

/// Returns the two mold halves: `a` holds the dowels, `b` slides onto them.
pub fn halves(p: &Dome, layout: &DomeLayout, cavity: &Cavity) -> [Body; 2] {
    let [a, b] = cavity.halves;
    [half(p, layout, cavity, a, Half::A), half(p, layout, cavity, b, Half::B)]
}

fn half(p: &Dome, layout: &DomeLayout, cavity: &Cavity, name: Name, which: Half) -> Body {
    let outwards = which.outwards();
    name.made(
        Process::Fdm,
        molds::half(&p.mold, &p.making, name, which)
            .minus(dome_tool(cavity.radius, layout.wall_height_mm).named("cavity")),
    )
    .with_material(&p.mold.material)
    .placed(
        mold_placements(cavity)
            .into_iter()
            .map(|p| p.moved_apart(Vector3::new(outwards * 30.0, 0.0, 0.0))),
    )
    .colored(MOLD_BLUE)
    .with_bed_orientation(Pose::rotation_y(Angle::from_deg(90.0 * outwards).expect("finite")))
    .note("parting face up, 0.12 mm layers; sand and seal the cavity")
    .in_layers(0.12)
    .note(match which {
        Half::A => "press the dowels in; they stay here",
        Half::B => "must slide onto the dowels of half a by hand",
    })
    .for_shrinkage(cavity.shrinkage)
}

/// Returns the assemblies that use the mold. The module stays in the outer mold while the shell is joined to it.
pub(super) fn mold_placements(cavity: &Cavity) -> Vec<Placement> {
    let joining = (cavity.assembly == TRANSLUCENT_MOLD).then_some(JOINING);
    std::iter::once(cavity.assembly).chain(joining).map(AssemblyName::in_place).collect()
}

/// Vents in the lid, above the gel's foot.
pub fn vents(p: &Dome, cavity: &Cavity) -> VentedLid {
    let foot = [cavity.core_radius, cavity.radius];
    VentedLid::over(foot, (p.mold.vents, p.mold.vent_diameter))
}

/// Returns the lid. It centres the connector, and with it the tube, and lets air and surplus gel out.
pub fn lid(p: &Dome, layout: &DomeLayout, cavity: &Cavity) -> Body {
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
    with_pry_tools(p, layout, plate, slide, thickness)
        .cut(holes([bore.named("bore")]).with_handles(1))
        .cut(vents.cut(through))
        .cut(vents.overflow(-thickness))
        .with_material(&p.mold.material)
        .placed([cavity.assembly.in_place().lifted(-30.0)])
        .colored(TOOL_GREY)
        .with_bed_orientation(flipped())
        .note("the flat side closes the mold, the channel faces up")
        .for_shrinkage(cavity.shrinkage)
}

/// Radial depth of a pry slot in a round lid or collar, mm.
const DISC_PRY_MM: f64 = 2.0;

/// Height of the pry slots in a round plate, mm. The cup's notches end short of the mold's mouth, and the blade
/// enters above what stays of the rim.
fn disc_gap_mm(p: &Dome, thickness: f64) -> f64 {
    let least = p.mold.pry_gap.mm() / 2.0;
    (least + NOTCH_DAM_MM).min(thickness - PRINTED_WALL_MM).max(least)
}

/// Adds the screwdriver poses that lift a round plate. Plates of printed molds stay as they are.
fn with_pry_tools(p: &Dome, layout: &DomeLayout, plate: Body, slide: f64, thickness: f64) -> Body {
    if p.molds.route == MoldRoute::Printed {
        return plate;
    }
    let radius = cup(p, layout).silicone_radius - slide;
    let middle = (disc_gap_mm(p, thickness) + NOTCH_DAM_MM) / 2.0;
    let mouth = Pose::translation(radius, 0.0, -middle);
    let turns = NOTCHES.map(notch_turn).into_iter();
    turns.fold(plate, |plate, turn| {
        plate.with_tool_access(pry(Pose::rotation_z(turn).then_in(mouth), DISC_PRY_MM))
    })
}

/// Returns a round plate below z = 0 that is centred by the cup of a silicone mold. Its pry slots are aligned with
/// the cup's notches.
fn disc(p: &Dome, layout: &DomeLayout, slide: f64, thickness: f64) -> Solid {
    let radius = cup(p, layout).silicone_radius - slide;
    let (gap, length) = (disc_gap_mm(p, thickness), p.mold.pry_length.mm());
    let slot = Solid::cuboid(2.0 * DISC_PRY_MM, length, gap + CUT_OVERLAP_MM).at(radius, 0.0, -gap);
    let slots = NOTCHES.map(|i| {
        let slot = slot.clone().turned_z(notch_turn(i));
        slot.named(format!("pry slot {}", i + 1))
    });
    Solid::rod(radius, [-thickness, 0.0]).minus_all(slots)
}

/// Returns the ring that centres the shell over the module while the filling gel cures.
pub fn collar(p: &Dome, layout: &DomeLayout) -> Body {
    // Half of each dowel is held by the mold, the other half by the collar.
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
    with_pry_tools(p, layout, plate, slide, thickness)
        .with_material(&p.mold.material)
        .placed([JOINING.in_place().lifted(-20.0)])
        .colored(TOOL_GREY)
        .note("sockets up")
        .with_handles(1)
}

// ------ Tooling ------
//
// Tools around the molds: the connector that holds the tube, the form that casts a silicone mold around a glass tube,
// the coating container and its holder.
//
// All stand in the sensor frame. Like the molds, they are used tip down.

/// Thickness of the connector's flange, mm.
const FLANGE_MM: f64 = 3.0;

/// Length of the handle that stays cylindrical below the cone under the flange, mm.
const CONE_END_MM: f64 = 2.0;

/// Radial inset of the flange from the tube's outside, mm. The flange must clear the lid's overflow channel.
pub(super) const FLANGE_INSET_MM: f64 = 0.25;

/// Gap between the holder and the foot of the gel that hangs below it, mm.
const HOLDER_GAP_MM: f64 = 0.5;

/// Radius of the connector's plug, which slides into the tube, mm.
pub fn plug_radius_mm(p: &Dome, layout: &DomeLayout) -> f64 {
    layout.tube_bore_radius_mm - p.making.gap_mm(CONNECTOR, Process::Fdm, Fit::Slide)
}

/// Seat of the connector's O-ring, which is squeezed by the tube's bore.
pub fn o_ring_seat(p: &Dome, layout: &DomeLayout) -> ORingSeat {
    let (cord, squeeze) = (p.connector.o_ring_cord, p.connector.o_ring_squeeze);
    ORingSeat::squeezed_in(layout.tube_bore_radius_mm, cord, squeeze)
}

/// Returns the handle that holds the tube while gel is cast around it. An O-ring grips the tube's inside, the neck
/// passes through the lid, the flange stops on the lid, and a channel lets the tube's air out.
pub fn connector(p: &Dome, layout: &DomeLayout) -> Body {
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
    // Printed standing on its handle, so the flange needs a 45 degree cone below it, as long as the handle allows.
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
        .with_material(&p.mold.material)
        .placed(gripped.map(|a| a.in_place().lifted(-55.0)))
        .colored(TOOL_GREY)
        .note("handle down, plug up, no supports")
        .with_supports(false)
        .note("put the O-ring on dry")
        .with_handles(1)
}

/// Indices of the notches in the cup's rim through which a screwdriver reaches the lid. They lie between the screws.
pub const NOTCHES: [u32; 3] = [0, 1, 2];

/// Height of the cup's rim above the silicone at a notch, mm.
pub const NOTCH_DAM_MM: f64 = 0.5;

/// Angle of notch `i` from +x.
pub fn notch_turn(i: u32) -> Angle {
    turn(i, NOTCHES.len() as u32, 0.5)
}

/// Cup in which both silicone molds are cast, dimensioned for the narrower tube.
pub fn cup<'a>(p: &'a Dome, layout: &DomeLayout) -> CupAndBridge<'a> {
    let tip_z = layout.wall_height_mm + layout.transparent_radius_mm;
    let bridges = [INNER_BRIDGE, OUTER_BRIDGE].map(|bridge| (bridge, Process::Fdm));
    let slide = p.making.widest_gap_mm(bridges, Fit::Slide);
    p.form.around(layout.transparent_radius_mm, tip_z, slide)
}

/// Cup and bridge with the glass tube of one layer.
pub fn form<'a>(p: &'a Dome, layout: &DomeLayout, cavity: &Cavity) -> CupAndBridge<'a> {
    cup(p, layout).with_tube(cavity.radius, layout.wall_height_mm + cavity.radius)
}

/// Returns the cup. Two are made, because each silicone mold stays in its own.
pub fn form_cup(p: &Dome, layout: &DomeLayout) -> Body {
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
        .with_material(&p.mold.material)
        .placed(used.map(|assembly| assembly.in_place().lifted(70.0)))
        .with_quantity(2)
}

/// Returns the bridge that hangs a layer's glass tube into the cup.
pub fn form_bridge(p: &Dome, layout: &DomeLayout, cavity: &Cavity) -> Body {
    form(p, layout, cavity)
        .bridge(cavity.form.bridge)
        .with_material(&p.mold.material)
        .placed([cavity.form.assembly.in_place().lifted(-30.0)])
}

/// Returns the silicone mold of a layer, smooth as glass and in one piece.
pub fn silicone_mold(p: &Dome, layout: &DomeLayout, cavity: &Cavity) -> Body {
    let form = form(p, layout, cavity);
    let cavity_tool = dome_tool(cavity.radius, layout.wall_height_mm).named("cavity");
    let solid = Solid::cylinder(form.silicone_radius, form.silicone_top_z).minus(cavity_tool);
    let used = mold_placements(cavity).into_iter().map(|place| place.lifted(35.0));
    cavity
        .form
        .mold
        .cast(solid)
        .with_material(&p.form.silicone_material)
        .placed([cavity.form.assembly.in_place().lifted(30.0)])
        .placed(used)
        .colored([90, 140, 215])
        .opaque(0.6)
}

/// Thickness of the wall and floor of the tube-cutting jig, mm.
const JIG_WALL_MM: f64 = 3.0;

/// Returns the sleeve whose rim shows where to cut the tube. The tube stands in it tip first, on its floor.
pub fn tube_jig(p: &Dome, layout: &DomeLayout) -> Body {
    let inner = layout.tube_radius_mm + p.making.gap_mm(TUBE_JIG, Process::Fdm, Fit::Slide);
    let floor = layout.wall_height_mm + layout.tube_radius_mm;
    let sleeve = bowl([inner, inner + JIG_WALL_MM], 0.0, [floor, floor + JIG_WALL_MM]);
    TUBE_JIG
        .made(Process::Fdm, sleeve)
        .with_material(&p.mold.material)
        .placed([CUTTING.in_place().lifted(30.0)])
        .colored(TOOL_GREY)
        .with_bed_orientation(flipped())
        .note("floor down, no supports; check its depth with a calliper: it is the tube's length")
        .with_supports(false)
}

/// Returns the container for the black mixture, and the holder that hangs a module into it by its connector.
pub fn coating_parts(p: &Dome, layout: &DomeLayout) -> [Body; 2] {
    let wall = p.coating.wall.mm();
    let inner = layout.surface_radius_mm + p.coating.gap.mm();
    let (rim_z, floor_z) = (-HOLDER_GAP_MM, layout.apex_z() + p.coating.gap.mm());
    let container = bowl([inner, inner + wall], rim_z, [floor_z, floor_z + wall]);

    // The holder takes the place of the lid below the connector's flange.
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
            .with_material(&p.mold.material)
            .placed([COATING.in_place().lifted(lift_mm)])
            .colored(TOOL_GREY)
            .with_bed_orientation(bed_from_body)
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
