//! How a flat-gel sensor is built, step by step.

use fabkit_geometry::{Action, Cure, Opening, Pose, Pour, Pull, Spray, Step, Vector3};

use super::layout::Layout;
use super::parameters::{CoatBy, FlatGel};
use super::{COAT_MOLD, GEL_MOLD, MARKING};
use crate::assembling::{SENSOR, cure, mix, names, opening, rigid, step};
use crate::blocks::chamber_light::LightFrom;
use crate::materials::castable;

/// What a primer and an adhesive for silicone need before the next step.
const GLUED: Cure = Cure { hours: 1.0, celsius: 23.0 };

/// Surplus that is scraped off, as a part of the layer.
const SCRAPED: f64 = 0.3;

/// The free surface at a height.
fn surface(layout: &Layout, z: f64) -> Vec<Opening> {
    let [x, y] = layout.pad.half;
    vec![opening("surface", &Pose::translation(0.0, 0.0, z), x.hypot(y))]
}

fn pour(layer: &str, walls: &[&str], material: &str, openings: Vec<Opening>) -> Action {
    Action::Pour(Pour {
        layer: layer.into(),
        walls: names(walls),
        up: Vector3::z(),
        openings,
        mix: mix(material),
        waste: SCRAPED,
        cure: cure(material),
    })
}

/// What is dabbed or sprayed: most of it misses.
fn spray(layer: &str, material: &str) -> Action {
    Action::Spray(Spray {
        layer: layer.into(),
        onto: vec!["gel".into()],
        mix: mix(material),
        waste: 5.0,
        cure: cure(material),
    })
}

/// Every step from printing to the sensor.
pub fn chain(p: &FlatGel, layout: &Layout) -> Vec<Step> {
    let up = Vector3::z();
    let off_floor = |material: &str| Pull {
        body: "mold-floor".into(),
        direction: -up,
        strain_limit: castable(material).map(|m| m.breaking_strain),
    };
    let has_markers = p.markers.exist();
    let mut steps = vec![
        step("make", "print and cut all parts", None, &[], Action::Make, "chosen"),
        step(
            "release",
            "press the dowels into the floor, slide the frame onto them, spray both with mold release",
            Some(GEL_MOLD),
            &["mold-floor", "mold-gel", "dowel"],
            Action::Prepare,
            "chosen",
        ),
        step(
            "pour-gel",
            "fill the frame to its brim on a level table, scrape the surplus off",
            Some(GEL_MOLD),
            &["mold-floor", "mold-gel"],
            pour(
                "gel",
                &["mold-floor", "mold-gel"],
                &p.pad.material,
                surface(layout, layout.seen_z),
            ),
            "chosen",
        ),
    ];
    let mut pulls = vec![rigid("mold-gel", up)];
    if p.coat.by == CoatBy::Spray {
        pulls.push(off_floor(&p.pad.material));
    }
    steps.push(step(
        "open-gel-mold",
        "pry the frame up at the slots; what is not coated here is peeled off the floor",
        Some(GEL_MOLD),
        &[],
        Action::Demold(pulls),
        "chosen",
    ));
    if has_markers {
        steps.push(step(
            "print-markers",
            "lay the stencil on the gel, edge on edge, and dab the ink through it with a sponge",
            Some(MARKING),
            &["gel", "marker-stencil"],
            spray("markers", &p.markers.material),
            "chosen",
        ));
    }
    if p.coat.by == CoatBy::Pour {
        let (floor, frame) = ("mold-floor", "mold-coat");
        let walls: Vec<&str> =
            [floor, frame, "gel"].into_iter().chain(has_markers.then_some("markers")).collect();
        steps.push(step(
            "pour-coat",
            "slide the wider frame onto the dowels, fill it to its brim around and over the gel",
            Some(COAT_MOLD),
            &[floor, frame, "dowel"],
            pour("coat", &walls, &p.coat.material, surface(layout, layout.top_z)),
            "chosen",
        ));
        steps.push(step(
            "open-coat-mold",
            "pry the frame up, peel the pad off the floor from one corner",
            Some(COAT_MOLD),
            &[],
            Action::Demold(vec![rigid(frame, up), off_floor(&p.pad.material)]),
            "chosen",
        ));
    }
    steps.push(step(
        "glue-plate",
        "lay the plate on the shell's ledge in a thin bead of clear adhesive, all around",
        Some(SENSOR),
        &["plate", "shell"],
        Action::Bond(GLUED),
        "chosen",
    ));
    let has_bed = p.bed.thickness.mm() > 0.0;
    if has_bed {
        let openings = surface(layout, 0.0);
        steps.push(step(
            "pour-bed",
            "prime plate and walls, fill the shell to its rim on a level table, from one corner",
            Some(SENSOR),
            &["plate", "shell"],
            pour("bed", &["plate", "shell"], &p.bed.material, openings),
            "chosen",
        ));
    }
    steps.push(step(
        "glue-pad",
        "wet the place with uncured clear gel as glue (prime bare acrylic), lay the pad on from one \
         edge so that no air stays, press it flat",
        Some(SENSOR),
        &["gel", if has_bed { "bed" } else { "plate" }],
        Action::Bond(cure(&p.bed.material)),
        "chosen",
    ));
    if p.coat.by == CoatBy::Spray {
        steps.push(step(
            "coat",
            "mask the shell's rim, spray the pad's top and sides in thin passes",
            Some(SENSOR),
            &["gel"],
            spray("coat", &p.coat.material),
            "chosen",
        ));
    }
    let light: (&str, &[&str]) = match p.leds.from {
        LightFrom::Sides => (
            "cut the strips, solder wires to them, glue them to the chamber's walls from below; their \
             colours take turns from wall to wall",
            &["led", "shell"],
        ),
        LightFrom::Below => (
            "solder LEDs and wires to the board, push it up against the shell's step, fix it",
            &["led", "led-board", "shell"],
        ),
    };
    steps.extend([
        step("fit-light", light.0, Some(SENSOR), light.1, Action::Assemble, "chosen"),
        step(
            "fit-camera",
            "screw the camera's board onto the base's posts, plug the cable in, focus on the gel",
            Some(SENSOR),
            &["camera", "base"],
            Action::Assemble,
            "chosen",
        )
        .also(layout.camera.joint().names()),
        step(
            "close",
            "lay cable and wires into the notch, put the shell on, drive the four screws from below; \
             a dot of silicone in the notch keeps light out",
            Some(SENSOR),
            &["shell", "base"],
            Action::Assemble,
            "chosen",
        )
        .also(layout.housing.joint().names()),
    ]);
    steps
}
