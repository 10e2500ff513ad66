//! Two-piece molds with dowels, lid and vents; and the collar that joins the cured module to its
//! shell while it is still in the mold.
//!
//! A mold stands in the sensor frame with its mouth at z = 0, facing down: in use it is turned
//! over, filled, and the tube pushed in from above. Air and surplus rise to the gel's foot, the
//! highest point, and leave through the lid's vents.

use fabkit_geometry::{
    Angle, Body, CUT_OVERLAP_MM, Path, Placement, Pose, Process, Profile, Solid, Vector3,
};

use super::bodies::*;
use super::layout::Layout;
use super::parameters::Dome;
use super::surface::dome_tool;
use super::tooling::plug_radius_mm;
use crate::assembling::{AssemblyName, Name, flipped};
use crate::blocks::mold::{self as molds, Half};
use crate::blocks::{MOLD_BLUE, TOOL_GREY, copies, ring};
use crate::fits::{Fit, gap_mm};

/// Depth of the channel that collects what rises through the vents, mm.
const OVERFLOW_DEPTH_MM: f64 = 1.2;

/// Width of that channel beside a vent, mm.
pub(super) const OVERFLOW_MARGIN_MM: f64 = 0.3;

/// Which layer a mold casts.
pub struct Cavity {
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

/// The two halves: `a` holds the dowels, `b` slides onto them.
pub fn halves(p: &Dome, layout: &Layout, cavity: &Cavity) -> [Body; 2] {
    let [a, b] = cavity.halves;
    [half(p, layout, cavity, a, Half::A), half(p, layout, cavity, b, Half::B)]
}

fn half(p: &Dome, layout: &Layout, cavity: &Cavity, name: Name, which: Half) -> Body {
    let outwards = which.outwards();
    name.made(
        Process::Fdm,
        molds::half(&p.mold, which)
            .minus(dome_tool(cavity.radius, layout.wall_height_mm).named("cavity")),
    )
    .from(&p.mold.material)
    .placed(
        used_in(cavity).into_iter().map(|p| p.moved_apart(Vector3::new(outwards * 30.0, 0.0, 0.0))),
    )
    .colored(MOLD_BLUE)
    .lying(Pose::rotation_y(Angle::from_deg(90.0 * outwards).expect("finite")))
    .note("parting face up, 0.12 mm layers; sand and seal the cavity")
    .note(match which {
        Half::A => "press the dowels in; they stay here",
        Half::B => "must slide onto the dowels of half a by hand",
    })
    .for_shrinkage(cavity.shrinkage)
}

fn used_in(cavity: &Cavity) -> Vec<Placement> {
    let joining = (cavity.assembly == TRANSLUCENT_MOLD).then_some(JOINING);
    std::iter::once(cavity.assembly).chain(joining).map(AssemblyName::in_place).collect()
}

/// Radius of the circle on which the lid's vents open, mm: midway over the gel's foot.
fn vent_circle_mm(cavity: &Cavity) -> f64 {
    (cavity.core_radius + cavity.radius) / 2.0
}

/// Where the vents meet the gel's foot, z axis up.
pub fn vent_poses(p: &Dome, cavity: &Cavity) -> Vec<Pose> {
    let out = Pose::translation(vent_circle_mm(cavity), 0.0, 0.0);
    ring(p.mold.vents, 0.5, out)
}

/// The lid: centres the connector and so the tube, lets air and surplus out.
pub fn lid(p: &Dome, layout: &Layout, cavity: &Cavity) -> Body {
    let thickness = p.mold.lid_thickness.mm();
    let through = |radius: f64| {
        Solid::cylinder(radius, thickness + 2.0 * CUT_OVERLAP_MM).at_z(-thickness - CUT_OVERLAP_MM)
    };
    let bore = through(plug_radius_mm(layout) + gap_mm(Process::Fdm, Fit::Slide));
    let vent_circle = vent_circle_mm(cavity);
    let vent_radius = p.mold.vent_diameter.mm() / 2.0;
    let vents = copies("vent", &vent_poses(p, cavity), &through(vent_radius));
    let half_width = vent_radius + OVERFLOW_MARGIN_MM;
    let overflow = Solid::extrusion(
        Profile::new(Path::circle([0.0; 2], vent_circle + half_width))
            .with_hole(Path::circle([0.0; 2], vent_circle - half_width)),
        OVERFLOW_DEPTH_MM + CUT_OVERLAP_MM,
    )
    .at_z(-thickness - CUT_OVERLAP_MM);
    let dowel = molds::dowel_tool(&p.mold, Fit::Slide, thickness + CUT_OVERLAP_MM);
    let dowels = copies("dowel hole", &molds::lid_dowel_poses(&p.mold), &dowel);
    cavity
        .lid
        .made(
            Process::Fdm,
            molds::plate(&p.mold, thickness)
                .minus(bore.named("bore"))
                .minus_all(vents)
                .minus(overflow.named("overflow channel"))
                .minus_all(dowels)
                .minus_all(molds::plate_pry_slots(&p.mold)),
        )
        .from(&p.mold.material)
        .placed([cavity.assembly.in_place().lifted(-30.0)])
        .colored(TOOL_GREY)
        .lying(flipped())
        .note("the flat side closes the mold, the channel faces up")
        // Bore, vents and two dowel holes.
        .for_shrinkage(cavity.shrinkage)
        .with_handles(3 + p.mold.vents as i32)
}

/// The ring that centres the shell over the module while the filling gel cures.
pub fn collar(p: &Dome, layout: &Layout) -> Body {
    let grip = p.mold.dowel_length.mm() / 2.0;
    let floor = 1.0;
    let thickness = grip + floor;
    let bore = Solid::cylinder(
        layout.shell_radius_mm + gap_mm(Process::Fdm, Fit::Slide),
        thickness + 2.0 * CUT_OVERLAP_MM,
    )
    .at_z(-thickness - CUT_OVERLAP_MM);
    let spare = 0.3;
    let dowel = molds::dowel_tool(&p.mold, Fit::Slide, grip + spare);
    let sockets = copies("socket", &molds::lid_dowel_poses(&p.mold), &dowel);
    COLLAR
        .made(
            Process::Fdm,
            molds::plate(&p.mold, thickness)
                .minus(bore.named("bore"))
                .minus_all(sockets)
                .minus_all(molds::plate_pry_slots(&p.mold)),
        )
        .from(&p.mold.material)
        .placed([JOINING.in_place().lifted(-20.0)])
        .colored(TOOL_GREY)
        .note("sockets up")
        .with_handles(1)
}
