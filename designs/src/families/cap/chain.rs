//! How a dome-cap sensor is built, step by step.

use fabkit_geometry::{Action, Cure, Pour, Pull, Spray, Step, Vector3};

use super::SKIN_MOLD;
use super::joints::Joints;
use super::layout::Layout;
use super::mold::vent_poses;
use super::parameters::Cap;
use crate::assembling::{SENSOR, mix, names, rigid, step, vents};
use crate::materials::castable;

const ROOM_24_H: Cure = Cure { hours: 24.0, celsius: 23.0 };

/// Every step from printing to the sensor.
pub fn chain(p: &Cap, layout: &Layout) -> Vec<Step> {
    // The mold is used with its mouth up.
    let up = -Vector3::z();
    let joints = Joints::new(p, layout);
    let (block, spacer, lid) = ("mold-skin-block", "mold-skin-spacer", "mold-skin-lid");
    vec![
        step(
            "make",
            "print and cut all parts; bake the mold, so that its resin lets silicone cure",
            None,
            &[],
            Action::Make,
            "IV-A, figure 4; baking chosen",
        ),
        step(
            "release",
            "spray block and lid with mold release",
            None,
            &[block, lid],
            Action::Prepare,
            "IV-A",
        ),
        step(
            "pour-skin",
            "fill the block to its rim and degas it, lay the spacer on, lower the lid edge first and \
             bolt it down; surplus runs into the trough, air leaves through the vents",
            Some(SKIN_MOLD),
            &[block, spacer, lid],
            Action::Pour(Pour {
                layer: "skin".into(),
                walls: names(&[block, lid]),
                up,
                openings: vents(&vent_poses(p, layout), p.mold.vent_diameter.mm() / 2.0),
                mix: mix(&p.skin.material),
                waste: 0.5,
                cure: ROOM_24_H,
            }),
            "IV-A: poured, degassed, 24 h; lid, spacer and waste chosen",
        )
        .also(joints.mold.names()),
        step(
            "open-mold",
            "take the bolts out, pry lid and spacer up at the notches; then peel the skin out of the \
             block from its edge, so that it stretches off one pin after the other",
            Some(SKIN_MOLD),
            &[],
            Action::Demold(vec![
                rigid(lid, up),
                rigid(spacer, up),
                // The block is rigid, and its pins stand along the normals: what gives is the gel.
                Pull {
                    body: block.into(),
                    direction: Vector3::z(),
                    strain_limit: castable(&p.skin.material).map(|m| m.breaking_strain),
                },
            ]),
            "IV-A; order chosen",
        ),
        step(
            "paint",
            "trim the vents' stubs, brush the reflective mixture onto the dimpled side",
            Some(SENSOR),
            &["skin"],
            Action::Spray(Spray {
                layer: "reflective-paint".into(),
                onto: vec!["skin".into()],
                mix: mix(&p.paint.material),
                // Half of the mixture is solvent, and cup and brush keep some.
                waste: 10.0,
                cure: ROOM_24_H,
            }),
            "IV-A: ingredients; shares, waste and cure chosen",
        ),
        step(
            "glue-skin",
            "glue the skin to the plate with Sil-Poxy, centred, without bubbles",
            Some(SENSOR),
            &["skin", "plate"],
            Action::Bond(Cure { hours: 1.0, celsius: 23.0 }),
            "IV-A; cure: three times the 20 minutes usual for Sil-Poxy",
        ),
        step(
            "glue-leds",
            "cut the LEDs from the strip, wire them in a row, push them into the holder's pockets \
             from above, lead the wires through the groove",
            Some(SENSOR),
            &["holder", "led"],
            Action::Assemble,
            "IV-B",
        ),
        step(
            "glue-plate",
            "glue the plate onto the holder's ledge with cyanoacrylate",
            Some(SENSOR),
            &["plate", "holder"],
            Action::Bond(Cure { hours: 1.0, celsius: 23.0 }),
            "IV-B; cure chosen",
        ),
        step(
            "assemble",
            "focus the lens on the paint, put the camera into the base, plug through the window; join \
             base and holder with four M2 screws, screw the base to the gripper",
            Some(SENSOR),
            &["camera", "base"],
            Action::Assemble,
            "IV-B, figure 5",
        )
        .also(joints.casing.names()),
    ]
}
