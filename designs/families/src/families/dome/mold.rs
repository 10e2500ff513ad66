//! Molds with lid and vents, in two halves or of silicone in a cup; and the collar that joins the cured module to its
//! shell while it is still in the mold.
//!
//! A mold stands in the sensor frame with its mouth at z = 0, facing down: in use it is turned
//! over, filled, and the tube pushed in from above. Air and surplus rise to the gel's foot, the
//! highest point, and leave through the lid's vents.

use fabkit_geometry::{Angle, Body, CUT_OVERLAP_MM, Placement, Pose, Process, Solid, Vector3};

use super::bodies::*;
use super::layout::Layout;
use super::parameters::{Dome, MoldRoute};
use super::surface::dome_tool;
use super::tooling::{self, plug_radius_mm};
use crate::assembling::{AssemblyName, Name, flipped};
use crate::blocks::mold::{self as molds, Half};
use crate::blocks::{MOLD_BLUE, PRINTED_WALL_MM, TOOL_GREY, VentedLid, copies, holes};
use crate::fits::Fit;
use crate::hardware::tools::pry;

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
    (least + tooling::NOTCH_DAM_MM).min(thickness - PRINTED_WALL_MM).max(least)
}

/// A round plate with the screwdrivers that lift it.
fn pried(p: &Dome, layout: &Layout, plate: Body, slide: f64, thickness: f64) -> Body {
    if p.molds.route == MoldRoute::Printed {
        return plate;
    }
    let radius = tooling::cup(p, layout).silicone_radius - slide;
    let middle = (disc_gap_mm(p, thickness) + tooling::NOTCH_DAM_MM) / 2.0;
    let mouth = Pose::translation(radius, 0.0, -middle);
    let turns = tooling::NOTCHES.map(tooling::notch_turn).into_iter();
    turns.fold(plate, |plate, turn| {
        plate.reached(pry(Pose::rotation_z(turn).then_in(mouth), DISC_PRY_MM))
    })
}

/// A round plate below z = 0 that the cup of a silicone mold centres, with pry slots behind the cup's
/// notches.
fn disc(p: &Dome, layout: &Layout, slide: f64, thickness: f64) -> Solid {
    let radius = tooling::cup(p, layout).silicone_radius - slide;
    let (gap, length) = (disc_gap_mm(p, thickness), p.mold.pry_length.mm());
    let slot = Solid::cuboid(2.0 * DISC_PRY_MM, length, gap + CUT_OVERLAP_MM).at(radius, 0.0, -gap);
    let slots = tooling::NOTCHES.map(|i| {
        let slot = slot.clone().turned_z(tooling::notch_turn(i));
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
