//! How a pin-tip sensor is built, step by step.

use fabkit_geometry::{Action, Cure, Mix, Opening, Point3, Pour, Step, Vector3};

use super::FILLING;
use super::layout::Layout;
use super::parameters::PinTip;
use super::tip::lens_holes;
use crate::materials::{Castable, castable};

const GLUED: Cure = Cure { hours: 1.0, celsius: 23.0 };

/// What the gel is mixed from and how it cures; nothing for an unknown material, which `check`
/// refuses.
fn gel(p: &PinTip) -> (Mix, Cure) {
    let nothing = Mix { by_mass: Vec::new(), density_g_per_cm3: 0.0, degas: false };
    castable(&p.fill.material)
        .map_or((nothing, GLUED), |material: &Castable| (material.mix(), material.cure))
}

/// The lens's holes as openings of the gel, in the frame of the filling, tip down.
fn openings(p: &PinTip, layout: &Layout) -> Vec<Opening> {
    let turned = FILLING.pose();
    let opening = |(name, [x, y]): (&str, [f64; 2])| Opening {
        name: name.into(),
        point: turned.point(Point3::new(x, y, layout.lens_top_z)),
        axis: turned.vector(-Vector3::z()),
        radius_mm: p.lens.hole_diameter.mm() / 2.0,
    };
    ["filling hole", "vent"].into_iter().zip(lens_holes(p)).map(opening).collect()
}

/// Every step from printing to the sensor on its robot.
pub fn chain(p: &PinTip, layout: &Layout) -> Vec<Step> {
    let step =
        |name: &str, instruction: &str, bodies: &[&str], action: Action, source: &str| Step {
            name: name.into(),
            instruction: instruction.into(),
            assembly: None,
            bodies: bodies.iter().map(|body| body.to_string()).collect(),
            action,
            source: source.into(),
        };
    let filling = |step: Step| Step { assembly: Some(FILLING.assembly()), ..step };
    let sensor = |step: Step| Step { assembly: Some(super::sensor_assembly()), ..step };
    let tip = ["skin", "dots", "ring"];
    let (mix, cure) = gel(p);
    vec![
        step(
            "make",
            "print the tip in two materials at once, print body and mount, cut the lens, etch the \
             LED board",
            &[],
            Action::Make,
            "III-A.1",
        ),
        step(
            "clean-tip",
            "wash the support out of the tip with water, between the pins gently; dry it for a day",
            &tip,
            Action::Prepare,
            "chosen: soft pins break under a hard jet, and wet parts cloud the gel",
        ),
        filling(step(
            "glue-lens",
            "glue the lens to its ledge all around with cyanoacrylate, tip down",
            &["skin", "dots", "ring", "lens"],
            Action::Bond(GLUED),
            "III-A.1 says that the lens is inserted; the glue is chosen",
        )),
        filling(step(
            "fill",
            "fill gel slowly through one hole with a syringe, tip down, until it rises in the other",
            &["skin", "dots", "ring", "lens"],
            Action::Pour(Pour {
                layer: "gel".into(),
                walls: ["skin", "dots", "ring", "lens"].map(String::from).to_vec(),
                up: Vector3::z(),
                openings: openings(p, layout),
                mix,
                waste: 0.3,
                cure,
            }),
            "III-A.1; cure from the maker, waste chosen: what stays in syringe and holes",
        )),
        filling(step(
            "close-holes",
            "wipe the lens and close both holes with a drop of clear glue",
            &["lens", "gel"],
            Action::Bond(GLUED),
            "chosen",
        )),
        sensor(step(
            "assemble-body",
            "press the LED board in, lead its wires down the shaft; screw the camera in from below, \
             turn its lens until the dots are sharp; pull the O-ring over the neck",
            &["body", "led-board", "led", "camera", "screw-m3x6", "o-ring"],
            Action::Assemble,
            "III-A.1 and III-A.2; the O-ring is chosen",
        )),
        sensor(step(
            "mount",
            "bolt the mount to the robot, lead the cable out of its slot, put the body on and turn \
             it clockwise (seen from the tip) until it stops",
            &["robot-mount", "bolt-m5", "body"],
            Action::Assemble,
            "III-A.3",
        )),
        sensor(step(
            "lock-tip",
            "put the tip on, its wide entry over the wide lug, press against the O-ring and turn it \
             clockwise (seen from the tip) until it stops",
            &["skin", "dots", "ring", "body"],
            Action::Assemble,
            "III-A.1",
        )),
    ]
}
