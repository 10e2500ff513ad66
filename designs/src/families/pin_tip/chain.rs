//! How a pin-tip sensor is built, step by step.

use fabkit_geometry::{Action, Cure, Opening, Point3, Pour, Step, Vector3};

use super::joints::Joints;
use super::layout::Layout;
use super::parameters::PinTip;
use super::tip::lens_holes;
use super::{FILLING, TIP};
use crate::assembling::{SENSOR, cure, flipped, mix, names, step};

const GLUED: Cure = Cure { hours: 1.0, celsius: 23.0 };

/// The lens's holes as openings of the gel, in the frame of the filling, tip down.
fn openings(p: &PinTip, layout: &Layout) -> Vec<Opening> {
    let turned = flipped();
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
    let joints = Joints::new(p, layout);
    let with_lens = [&TIP[..], &["lens"]].concat();
    vec![
        step(
            "make",
            "print the tip in two materials at once, print body and mount, cut the lens, etch the \
             LED board",
            None,
            &[],
            Action::Make,
            "III-A.1",
        ),
        step(
            "clean-tip",
            "wash the support out of the tip with water, between the pins gently; dry it for a day",
            None,
            &TIP,
            Action::Prepare,
            "chosen: soft pins break under a hard jet, and wet parts cloud the gel",
        ),
        step(
            "glue-lens",
            "glue the lens to its ledge all around with cyanoacrylate, tip down",
            Some(FILLING),
            &with_lens,
            Action::Bond(GLUED),
            "III-A.1 says that the lens is inserted; the glue is chosen",
        ),
        step(
            "fill",
            "fill gel slowly through one hole with a syringe, tip down, until it rises in the other",
            Some(FILLING),
            &with_lens,
            Action::Pour(Pour {
                layer: "gel".into(),
                walls: names(&with_lens),
                up: Vector3::z(),
                openings: openings(p, layout),
                mix: mix(&p.fill.material),
                waste: 0.3,
                cure: cure(&p.fill.material),
            }),
            "III-A.1; cure from the maker, waste chosen: what stays in syringe and holes",
        ),
        step(
            "close-holes",
            "wipe the lens and close both holes with a drop of clear glue",
            Some(FILLING),
            &["lens", "gel"],
            Action::Bond(GLUED),
            "chosen",
        ),
        step(
            "assemble-body",
            "press the LED board in, lead its wires down the shaft; screw the camera in from below, \
             turn its lens until the dots are sharp; pull the O-ring over the neck",
            Some(SENSOR),
            &["body", "led-board", "led", "camera", "o-ring"],
            Action::Assemble,
            "III-A.1 and III-A.2; the O-ring is chosen",
        )
        .also(joints.camera.names()),
        step(
            "mount",
            "bolt the mount to the robot, lead the cable out of its slot, put the body on and turn \
             it clockwise (seen from the tip) until it stops",
            Some(SENSOR),
            &["robot-mount", "body"],
            Action::Assemble,
            "III-A.3",
        )
        .also([joints.robot.name()]),
        step(
            "lock-tip",
            "put the tip on, its wide entry over the wide lug, press against the O-ring and turn it \
             clockwise (seen from the tip) until it stops",
            Some(SENSOR),
            &["skin", "dots", "ring", "body"],
            Action::Assemble,
            "III-A.1",
        ),
    ]
}
