//! Assembly steps of a flat-gel sensor, from printing to the closed sensor.

use fabkit_geometry::{Action, FixingMeans, Opening, Pose, Step, Vector3};

use super::FlatGelLayout;
use super::parameters::*;
use crate::blocks::chamber_light::{LED_BOARD, LedPosition};
use crate::blocks::frame_mold::FLOOR;
use crate::blocks::marker_grid::{MARKERS, STENCIL};
use crate::blocks::{CAMERA, DOWEL, LED};
use crate::chain_builder::{
    GLUE_CURE, Name, SENSOR, assemble, bond, cure, demold, liquid, make, opening, peel, prepare,
    rigid, step,
};
use crate::materials::Castable;

/// Surplus of poured material that is scraped off, as a fraction of the layer's mass.
const SCRAPED_SURPLUS: f64 = 0.3;

/// Surplus of material that is dabbed or sprayed, as a fraction of the layer's mass. Most of it misses.
const MISSED_SURPLUS: f64 = 5.0;

/// Returns the free surface of a poured layer at the height `z`.
fn free_surface_at(layout: &FlatGelLayout, z: f64) -> Vec<Opening> {
    let [x, y] = layout.pad.half;
    vec![opening("surface", &Pose::translation(0.0, 0.0, z), x.hypot(y))]
}

fn pour(material: &Castable, walls: &[Name], layer: Name, openings: Vec<Opening>) -> Action {
    liquid(material, SCRAPED_SURPLUS).fills(walls, layer, Vector3::z(), openings)
}

/// Returns all steps, from printing to the finished sensor.
pub fn chain(p: &FlatGel, layout: &FlatGelLayout) -> Vec<Step> {
    let up = Vector3::z();
    let off_floor = || peel(FLOOR, -up, &p.pad.material);
    // A sprayed coat is applied later, so its gel leaves the floor now. A poured coat is cast on the same floor.
    let is_sprayed = p.coat.by == CoatBy::Spray;
    let off_frame = [rigid(GEL_FRAME, up)].into_iter().chain(is_sprayed.then(off_floor));
    let gel = pour(
        &p.pad.material,
        &[FLOOR, GEL_FRAME],
        GEL,
        free_surface_at(layout, layout.gel_top_z_mm),
    );
    let mut steps = vec![
        make("print and cut all parts; bake the molds and varnish them, so that silicone cures")
            .source("chosen: bare resin can keep platinum silicone from curing"),
        prepare("release", GEL_MOLD, &[FLOOR, GEL_FRAME, DOWEL])
            .with_instruction(
                "press the dowels into the floor, slide the frame onto them, spray both with mold \
                 release",
            )
            .source("chosen"),
        step("pour-gel", GEL_MOLD, &[FLOOR, GEL_FRAME], gel)
            .with_instruction("fill the frame to its brim on a level table, scrape the surplus off")
            .source("chosen"),
        demold("open-gel-mold", GEL_MOLD, off_frame.collect())
            .with_instruction(
                "pry the frame up at the slots; what is not coated here is peeled off the floor",
            )
            .source("chosen"),
    ];
    if p.markers.has_dots() {
        let ink = liquid(&p.markers.material, MISSED_SURPLUS).coats(&[GEL], MARKERS);
        let dab = step("print-markers", MARKING, &[GEL, STENCIL], ink).with_instruction(
            "lay the stencil on the gel, edge on edge, and dab the ink through it with a sponge",
        );
        steps.push(dab.source("chosen"));
    }
    if !is_sprayed {
        // The coat is poured over the ink, so the ink bounds it too.
        let inked = p.markers.has_dots().then_some(MARKERS);
        let walls: Vec<Name> = [FLOOR, COAT_FRAME, GEL].into_iter().chain(inked).collect();
        let coat = pour(&p.coat.material, &walls, COAT, free_surface_at(layout, layout.top_z_mm));
        steps.extend([
            step("pour-coat", COAT_MOLD, &[FLOOR, COAT_FRAME, DOWEL], coat)
                .with_instruction(
                    "slide the wider frame onto the dowels, fill it to its brim around and over \
                     the gel",
                )
                .source("chosen"),
            demold("open-coat-mold", COAT_MOLD, vec![rigid(COAT_FRAME, up), off_floor()])
                .with_instruction("pry the frame up, peel the pad off the floor from one corner")
                .source("chosen"),
        ]);
    }
    steps.push(
        bond("glue-plate", SENSOR, &[PLATE, SHELL], GLUE_CURE)
            .with_instruction(
                "lay the plate on the shell's ledge in a thin bead of clear adhesive, all around",
            )
            .source("chosen"),
    );
    let has_bed = p.bed.thickness.mm() > 0.0;
    if has_bed {
        let bed = pour(&p.bed.material, &[PLATE, SHELL], BED, free_surface_at(layout, 0.0));
        let fill = step("pour-bed", SENSOR, &[PLATE, SHELL], bed).with_instruction(
            "prime plate and walls, fill the shell to its rim on a level table, from one corner",
        );
        steps.push(fill.source("chosen"));
    }
    // Without a bed the pad lies on the plate itself.
    let below = if has_bed { BED } else { PLATE };
    steps.push(
        bond("glue-pad", SENSOR, &[GEL, below], cure(&p.bed.material))
            .with_instruction(
                "wet the place with uncured clear gel as glue (prime bare acrylic), lay the pad on \
                 from one edge so that no air stays, press it flat",
            )
            .source("chosen"),
    );
    if is_sprayed {
        let coat = liquid(&p.coat.material, MISSED_SURPLUS).coats(&[GEL], COAT);
        let spray = step("coat", SENSOR, &[GEL], coat)
            .with_instruction("mask the shell's rim, spray the pad's top and sides in thin passes");
        steps.push(spray.source("chosen"));
    }
    let light = match p.leds.from {
        LedPosition::Sides => assemble("fit-light", SENSOR, &[LED, SHELL]).with_instruction(
            "cut the strips, solder wires to them, glue them to the chamber's walls from below; their \
             colours take turns from wall to wall",
        )
        .fixing(&[LED], &[SHELL], FixingMeans::Glue),
        LedPosition::Below => assemble("fit-light", SENSOR, &[LED, LED_BOARD, SHELL])
            .with_instruction(
                "solder LEDs and wires to the board, push it up against the shell's step, fix it",
            )
            .fixing(&[LED], &[LED_BOARD], FixingMeans::Solder),
    };
    steps.extend([
        light.source("chosen"),
        assemble("fit-camera", SENSOR, &[CAMERA, BASE])
            .with_instruction(
                "screw the camera's board onto the base's posts, plug the cable in, hold the base against \
                 the shell and look at the image; turn the lens by its rim between two looks until \
                 the gel is sharp, lock it with a drop of nail polish",
            )
            .source("chosen")
            .with_bodies(layout.camera.joint().names())
            .with_separate_adjustment(CAMERA),
        assemble("close", SENSOR, &[SHELL, BASE])
            .with_instruction(
                "lay cable and wires into the notch, put the shell on, drive the four screws from \
                 below; a dot of silicone in the notch keeps light out",
            )
            .source("chosen")
            .with_bodies(layout.housing.joint().names())
            .with_bodies(layout.housing.mounting().nut_name()),
    ]);
    steps
}
