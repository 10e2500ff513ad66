//! Resin mold that casts the skin: a block with the cavity, a lid whose boss closes it, and a spacer between both.
//!
//! The mold stands in the sensor frame with its mouth at z = 0, facing down. In use it is turned over. The gel is
//! poured into the block and degassed, then the lid is put on. The lid's boss meets the block on a narrow land.
//! Surplus gel flows over the land into the trough inside the spacer, and out through the notches. The boss is flat
//! and wider than the gel, so the bolts' play does not matter and no dowels are needed.

use fabkit_geometry::{Angle, Body, CUT_OVERLAP_MM, CutFeature, Path, Pose, Process, Solid};

use super::housing::gel;
use super::parameters::*;
use super::{CapLayout, Joints};
use crate::blocks::{MOLD_BLUE, TOOL_GREY, VentedLid, holes, landmarks_at, turn};
use crate::chain_builder::{Name, flipped, shrinkage};
use crate::hardware::tools::pry;

const WASH: &str = "wash, cure and bake: uncured resin keeps platinum silicone from curing";

/// Vents in the lid, between the area that the camera sees and the gel's edge.
pub fn vents(p: &Cap, layout: &CapLayout) -> VentedLid {
    let foot = [layout.chamber_radius_mm, layout.foot_radius_mm];
    VentedLid::over(foot, (p.mold.vents, p.mold.vent_diameter))
}

/// Cuts the bolts' holes with the given diameter: the block and the plates on it have different ones.
fn bolt_holes(p: &Cap, layout: &CapLayout, diameter_mm: f64) -> CutFeature {
    let depth = p.mold.height.mm() - layout.lid_z_mm + CUT_OVERLAP_MM;
    Joints::new(p, layout)
        .mold
        .clearance_cut_with_radius(depth, diameter_mm / 2.0)
        .without_landmarks()
}

/// Cuts two radial slots at the outside of the mold, each between two bolts. They start at the height `bottom_z`, are
/// `height` high, and reach `reach_mm` inwards.
fn pry_slots(p: &Cap, layout: &CapLayout, reach_mm: f64, bottom_z: f64, height: f64) -> CutFeature {
    holes(pry_slot_angles(p).into_iter().zip(1..).map(|(turn, number)| {
        let slot = Solid::cuboid(2.0 * reach_mm, p.mold.pry_width.mm(), height)
            .at(layout.mold_radius_mm, 0.0, bottom_z)
            .turned_z(turn);
        slot.named(format!("pry slot {number}"))
    }))
}

/// Angles of the slots: in the middle between two bolts.
fn pry_slot_angles(p: &Cap) -> [Angle; 2] {
    [0, 1].map(|i| turn(i * (p.mold.bolts / 2), p.mold.bolts, 0.5))
}

fn tool(p: &Cap, name: Name, solid: Solid, lift_mm: f64) -> Body {
    name.made(Process::Sla, solid)
        .with_material(&p.mold.material)
        .placed([SKIN_MOLD.in_place().lifted(lift_mm)])
        .colored(TOOL_GREY)
        .sealed("bake")
        .for_shrinkage(shrinkage(&p.skin.material))
}

/// Returns block, spacer and lid.
pub fn mold_parts(p: &Cap, layout: &CapLayout, dimples: &[Pose]) -> [Body; 3] {
    [block(p, layout, dimples), spacer(p, layout), lid(p, layout)]
}

/// Returns the block, which is the negative of the gel: each dimple becomes a pin.
fn block(p: &Cap, layout: &CapLayout, dimples: &[Pose]) -> Body {
    let solid = Solid::cylinder(layout.mold_radius_mm, p.mold.height.mm());
    let (reach, height) = (p.mold.pry_depth.mm(), p.mold.pry_gap.mm() + CUT_OVERLAP_MM);
    let block = tool(p, BLOCK, solid.minus(gel(p, layout, dimples, true)), 26.0)
        .colored(MOLD_BLUE)
        .with_landmarks(landmarks_at("dimple", dimples))
        .with_bed_orientation(flipped())
        .note("cavity up, 0.025 mm layers, no supports inside")
        .note(WASH)
        .cut(bolt_holes(p, layout, p.mold.block_hole.mm()))
        .cut(Joints::new(p, layout).mold.thread_cut().without_landmarks())
        .cut(pry_slots(p, layout, reach, -CUT_OVERLAP_MM, height));
    pry_slot_angles(p).into_iter().fold(block, |block, turn| {
        let mouth = Pose::translation(layout.mold_radius_mm, 0.0, p.mold.pry_gap.mm() / 2.0);
        block.with_tool_access(pry(Pose::rotation_z(turn).then_in(mouth), reach))
    })
}

fn spacer(p: &Cap, layout: &CapLayout) -> Body {
    let (bore, outside) = (layout.spacer_bore_mm, layout.mold_radius_mm);
    let ring = Solid::revolution(Path::polygon(&[
        [bore, layout.flange_z_mm],
        [outside, layout.flange_z_mm],
        [outside, 0.0],
        [bore, 0.0],
    ]));
    // The notch goes from the trough to the outside and is half as deep as the spacer is thick.
    let (reach, depth) = (outside - bore + 1.0, p.mold.spacer.mm() / 2.0 + CUT_OVERLAP_MM);
    tool(p, SPACER, ring, -10.0)
        .with_bed_orientation(flipped())
        .note(WASH)
        .note("grind it down, or add film, if the skin comes out too thick or thin")
        .with_handles(1)
        .cut(bolt_holes(p, layout, p.mold.lid_hole.mm()))
        .cut(pry_slots(p, layout, reach, layout.flange_z_mm - CUT_OVERLAP_MM, depth))
}

fn lid(p: &Cap, layout: &CapLayout) -> Body {
    let outline = Path::polygon(&[
        [0.0, layout.lid_z_mm],
        [layout.mold_radius_mm, layout.lid_z_mm],
        [layout.mold_radius_mm, layout.flange_z_mm],
        [layout.boss_radius_mm, layout.flange_z_mm],
        [layout.boss_radius_mm, 0.0],
        [0.0, 0.0],
    ]);
    let depth = -layout.lid_z_mm + CUT_OVERLAP_MM;
    let through = |radius| Solid::cylinder(radius, depth + CUT_OVERLAP_MM).at_z(-depth);
    tool(p, LID, Solid::revolution(outline), -24.0)
        .note("boss up; polish the boss, the camera looks through its print")
        .note(WASH)
        .cut(vents(p, layout).cut(through))
        .cut(bolt_holes(p, layout, p.mold.lid_hole.mm()))
}
