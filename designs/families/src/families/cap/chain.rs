//! Assembly steps of a dome-cap sensor, from printing to the closed sensor.

use fabkit_geometry::{FixingMeans, Step, Vector3};

use super::molds::vents;
use super::parameters::*;
use super::{CapLayout, Joints};
use crate::blocks::LED;
use crate::blocks::cable_openings::HousingSide;
use crate::chain_builder::{
    GLUE_CURE, ROOM_24_H, SENSOR, assemble, bond, demold, liquid, make, peel, prepare, rigid, step,
};

/// Returns all steps, from printing to the finished sensor.
pub fn chain(p: &Cap, layout: &CapLayout) -> Vec<Step> {
    // The mold is used with its mouth up.
    let up = -Vector3::z();
    let joints = Joints::new(p, layout);
    let vents = vents(p, layout).openings();
    let gel = liquid(&p.skin.material, 0.5).with_cure(ROOM_24_H);
    // Surplus of 10 layer masses: half of the mixture is solvent, and some stays in cup and brush.
    let paint = liquid(&p.paint.material, 10.0).with_cure(ROOM_24_H);
    // The block is rigid and its pins stand along the normals, so the gel has to deform.
    let off_block = peel(BLOCK, Vector3::z(), &p.skin.material);
    vec![
        make("print and cut all parts; bake the mold, so that its resin lets silicone cure")
            .source("IV-A, figure 4; baking chosen"),
        prepare("release", None, &[BLOCK, LID])
            .with_instruction("spray block and lid with mold release")
            .source("IV-A"),
        step(
            "pour-skin",
            SKIN_MOLD,
            &[BLOCK, SPACER, LID],
            gel.fills(&[BLOCK, LID], SKIN, up, vents),
        )
        .with_instruction(
            "fill the block to its rim and degas it, lay the spacer on, lower the lid edge first and \
             bolt it down; surplus runs into the trough, air leaves through the vents",
        )
        .source("IV-A: poured, degassed, 24 h; lid, spacer and waste chosen")
        .with_bodies(joints.mold.names()),
        demold("open-mold", SKIN_MOLD, vec![rigid(LID, up), rigid(SPACER, up), off_block])
            .with_instruction(
                "take the bolts out, pry lid and spacer up at the notches; then peel the skin out of \
                 the block from its edge, so that it stretches off one pin after the other",
            )
            .source("IV-A; order chosen"),
        step("paint", SENSOR, &[SKIN], paint.coats(&[SKIN], PAINT))
            .with_instruction("trim the vents' stubs, brush the reflective mixture onto the dimpled side")
            .source("IV-A: ingredients; shares, waste and cure chosen"),
        bond("glue-skin", SENSOR, &[SKIN, PLATE], GLUE_CURE)
            .with_instruction("glue the skin to the plate with Sil-Poxy, centred, without bubbles")
            .source("IV-A; cure: three times the 20 minutes usual for Sil-Poxy"),
        assemble("glue-leds", SENSOR, &[HOLDER, LED])
            .with_instruction(
                "cut the LEDs from the strip, wire them in a row, push them into the holder's \
                 pockets from above, each with a drop of hot-melt adhesive on its back, lead the wires \
                 through the groove",
            )
            .fixing(&[LED], &[HOLDER], FixingMeans::Glue)
            .source("IV-B")
            .during_cure_of("glue-skin"),
        bond("glue-plate", SENSOR, &[PLATE, HOLDER], GLUE_CURE)
            .with_instruction("glue the plate onto the holder's ledge with cyanoacrylate")
            .source("IV-B; cure chosen"),
        assemble("assemble", SENSOR, &[CAMERA, CAMERA_CABLE, BASE])
            .with_instruction(format!(
                "put the camera into the base, plug through the window{}, hold both against the holder and \
                 look at the image; turn the lens between two looks until the paint is sharp, lock it \
                 with a drop of nail polish; join base and holder with four M2 screws, screw the base to the gripper; the LEDs' \
                 wires leave by the window to a microcontroller outside of the sensor",
                match p.base.cable_side {
                    HousingSide::Front => "",
                    HousingSide::Right => " at +x, the camera turned to it",
                    HousingSide::Left => " at -x, the camera turned to it",
                    HousingSide::Back => " at +y, the camera turned to it",
                }
            ))
            .source("IV-B, figure 5")
            .with_bodies(joints.casing.names())
            .with_bodies(joints.mounting.nut_name())
            .with_separate_adjustment(CAMERA),
    ]
}
