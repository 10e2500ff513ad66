//! Assembly steps of a pin-tip sensor, from printing to the sensor on its robot.

use fabkit_geometry::{FixingMeans, Opening, Point3, Step, Vector3};

use super::housing::lens_holes;
use super::parameters::*;
use super::{Joints, PinTipLayout, electronics};
use crate::blocks::LED;
use crate::chain_builder::{
    GLUE_CURE, SENSOR, assemble, bond, flipped, liquid, make, names, prepare, step,
};

/// Returns the lens's holes as openings of the gel, in the frame of the filling assembly, tip down.
fn lens_openings(p: &PinTip, layout: &PinTipLayout) -> Vec<Opening> {
    let turned = flipped();
    let opening = |(name, [x, y]): (&str, [f64; 2])| Opening {
        name: name.into(),
        point: turned.point(Point3::new(x, y, layout.lens_top_z_mm)),
        axis: turned.vector(-Vector3::z()),
        radius_mm: p.lens.hole_diameter.mm() / 2.0,
    };
    ["filling hole", "vent"].into_iter().zip(lens_holes(p)).map(opening).collect()
}

/// Returns all steps, from printing to the sensor on its robot.
pub fn chain(p: &PinTip, layout: &PinTipLayout) -> Vec<Step> {
    let joints = Joints::new(p, layout);
    let with_lens = [&TIP[..], &[LENS]].concat();
    let gel = liquid(&p.fill.material, 0.3);
    let gel = gel.fills(&with_lens, GEL, Vector3::z(), lens_openings(p, layout));
    let mut steps = vec![
        make(
            "print the tip in two materials at once, print body and mount, cut the lens, etch the \
             LED board",
        )
        .source("III-A.1"),
        prepare("clean-tip", None, &TIP)
            .with_instruction(
                "wash the support out of the tip with water, between the pins gently; dry it for a \
                 day",
            )
            .source("chosen: soft pins break under a hard jet, and wet parts cloud the gel"),
        bond("glue-lens", FILLING, &with_lens, GLUE_CURE)
            .with_instruction("glue the lens to its ledge all around with cyanoacrylate, tip down")
            .source("III-A.1 says that the lens is inserted; the glue is chosen"),
        step("fill", FILLING, &with_lens, gel)
            .with_instruction(
                "fill gel slowly through one hole with a syringe, tip down, until it rises in the \
                 other",
            )
            .source("III-A.1; cure from the maker, waste chosen: what stays in syringe and holes"),
        bond("close-holes", FILLING, &[LENS, GEL], GLUE_CURE)
            .with_instruction("wipe the lens and close both holes with a drop of clear glue")
            .source("chosen"),
        assemble("focus-lens", FOCUSING, &[CAMERA, FOCUS_GAUGE])
            .with_instruction(
                "stand the gauge on the camera's board, its target against the light; turn the lens with \
                 two fingers through the windows until the holes are sharp; fix its thread with a drop \
                 of varnish",
            )
            .source("III-A.2: an adjustable lens; no finger reaches it once the board is in the body")
            .with_adjustment(CAMERA)
            .during_cure_of("close-holes"),
        assemble("assemble-body", SENSOR, &[BODY, LED_BOARD, LED, CAMERA, CAMERA_CABLE, O_RING])
            .with_instruction(
                "solder the LEDs to their board, press it in, lead its wires down the shaft; screw the focused camera \
                 in from below, its wires out of the slot; pull the O-ring over the neck",
            )
            .fixing(&[LED], &[LED_BOARD], FixingMeans::Solder)
            .source("III-A.1 and III-A.2; the O-ring is chosen")
            .with_bodies(joints.camera.names()),
        assemble("mount", SENSOR, &[ROBOT_MOUNT, BODY])
            .with_instruction(
                "bolt the mount to the robot, put the body on and turn it clockwise (seen from the tip) until it stops",
            )
            .source("III-A.3")
            .with_bodies([joints.robot.name()])
            .with_motion(layout.mount_joint.male_onto([ROBOT_MOUNT.into(), joints.robot.name()])),
        assemble("lock-tip", SENSOR, &[SKIN, DOTS, RING, BODY])
            .with_instruction(
                "put the tip on, its wide entry over the wide lug, press against the O-ring and turn \
                 it clockwise (seen from the tip) until it stops",
            )
            .source("III-A.1")
            .with_motion(layout.tip_joint.female_onto(names(&TIP))),
    ];
    if electronics::has_controller(p) {
        let mounted = steps.iter().position(|step| step.name == "mount");
        let before = mounted.unwrap_or(steps.len());
        steps.splice(before..before, controller_steps());
    }
    steps
}

/// Steps that seat the microcontroller's board, before the sensor is mounted on its robot.
fn controller_steps() -> [Step; 2] {
    [
        bond("glue-controller-holder", SENSOR, &[BODY, CONTROLLER_HOLDER], GLUE_CURE)
            .with_instruction(
                "roughen the housing, glue the holder to it with cyanoacrylate a quarter turn from the \
                 cable's slot, its floor towards the robot",
            )
            .source("III-A.2: mounted on the outside of the body; how is chosen"),
        assemble("seat-controller", SENSOR, &[CONTROLLER, CABLE_TIE])
            .with_instruction(
                "solder the camera's wires to the board, lay it into the holder with the socket of its \
                 plug free, tie it down; its cable goes on to the computer",
            )
            .source("III-A.2: SPI from the chip, serial to the computer"),
    ]
}
