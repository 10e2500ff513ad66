//! How a dome sensor is built, step by step.

use fabkit_geometry::{Cure, Step, Vector3};

use super::bodies::*;
use super::cavities;
use super::joints::Joints;
use super::layout::Layout;
use super::mold::vents;
use super::parameters::Dome;
use super::tooling::form;
use crate::assembling::{
    Name, SENSOR, assemble, bond, demold, free_surface, liquid, make, prepare, rigid, step,
};
use crate::blocks::cup_and_bridge::PUSH_HOLE_RADIUS_MM;
use crate::blocks::{DOWEL, LED};

const ROOM_24_H: Cure = Cure { hours: 24.0, celsius: 23.0 };
/// Of the silicone mold, from the material's data sheet.
const ROOM_6_H: Cure = Cure { hours: 6.0, celsius: 23.0 };

/// Every step from printing to the sensor.
pub fn chain(p: &Dome, layout: &Layout) -> Vec<Step> {
    let joints = Joints::new(p, layout);
    // Molds and tube are used tip down.
    let up = -Vector3::z();
    let halves_apart = |a: Name, b: Name| [rigid(a, -Vector3::x()), rigid(b, Vector3::x())];
    let [inner_vents, outer_vents] = cavities(p, layout).map(|cavity| vents(p, &cavity).openings());

    let form = form(p, layout);
    let mut push_hole = free_surface(PUSH_HOLE_RADIUS_MM, 0.0, up);
    push_hole.name = "push hole, taped".into();
    push_hole.point.z = form.silicone_top_z;
    push_hole.axis = Vector3::z();
    let silicone = liquid(&p.form.silicone_material, 0.1).curing(ROOM_6_H);
    let in_form = vec![free_surface(form.silicone_radius, 0.0, up), push_hole];

    let transparent = liquid(&p.transparent_gel.material, 0.5).curing(ROOM_24_H);
    let translucent = liquid(&p.translucent_gel.material, 0.5).curing(ROOM_24_H);
    // Five sixths of the mixture is thinner, and most of a spray misses.
    let coat = liquid(&p.coat.material, 20.0).curing(ROOM_24_H);
    let filling = liquid(&p.filling_gel.material, 0.1).curing(ROOM_24_H);
    let in_tube = vec![free_surface(layout.tube_bore_radius_mm, 0.0, up)];
    let around_tube = [INNER_A, INNER_B, INNER_LID, TUBE];
    let around_gel = [OUTER_A, OUTER_B, OUTER_LID, TRANSPARENT_GEL, BLACK_COAT];

    // The connector's flange stands on the lid.
    let off_inner = [rigid(CONNECTOR, up), rigid(INNER_LID, up)];
    let off_inner = [off_inner, halves_apart(INNER_A, INNER_B)].concat();
    let off_outer = [vec![rigid(COLLAR, up)], halves_apart(OUTER_A, OUTER_B).to_vec()].concat();
    vec![
        make("print, cut and etch all parts; press the dowels in").source("III-B, figure 4a"),
        step(
            "silicone-mold",
            FORM,
            &[FORM_CUP, FORM_BRIDGE, FORM_TUBE],
            silicone.fills(&[FORM_CUP, FORM_TUBE], SILICONE_MOLD, up, in_form),
        )
        .told(
            "optional, for a smoother transparent gel: hang the glass tube into the cup by the bridge \
             and pour silicone around it",
        )
        .source("III-B.1, figure 4 b2; cure time from the material's data sheet")
        .also(joints.form.names()),
        prepare("prime", None, &[TUBE, INNER_A, INNER_B])
            .told(
                "clean the tube and prime it with PR-1200 RTV; spray the mold with Ease Release \
                 200",
            )
            .source("III-B.1"),
        step(
            "pour-transparent-gel",
            TRANSPARENT_MOLD,
            &[INNER_A, INNER_B, INNER_LID, CONNECTOR, O_RING, TUBE, DOWEL],
            transparent.fills(&around_tube, TRANSPARENT_GEL, up, inner_vents),
        )
        .told(
            "fill the mold, push the tube in on its connector until the lid closes, wipe what rises \
             through the vents",
        )
        .source("III-B.1"),
        demold("open-transparent-mold", TRANSPARENT_MOLD, off_inner)
            .told(
                "pull the connector out of the tube, lift the lid with a screwdriver in its pry \
                 slots, then part the halves",
            )
            .source("III-B.1"),
        step(
            "spray-coat",
            TRANSLUCENT_MOLD,
            &[OUTER_A, OUTER_B, DOWEL],
            coat.coats(&[OUTER_A, OUTER_B], BLACK_COAT),
        )
        .told("spray the black mixture onto the inside of the outer mold")
        .source("III-B.1; waste chosen"),
        step(
            "pour-translucent-gel",
            TRANSLUCENT_MOLD,
            &[OUTER_A, OUTER_B, OUTER_LID, CONNECTOR, O_RING, TUBE, DOWEL],
            translucent.fills(&around_gel, TRANSLUCENT_GEL, up, outer_vents),
        )
        .told(
            "at once, fill the outer mold and push the cured transparent gel in on its connector until \
             the lid closes",
        )
        .source("III-B.1"),
        demold("lift-lid", TRANSLUCENT_MOLD, vec![rigid(CONNECTOR, up), rigid(OUTER_LID, up)])
            .told(
                "pull the connector out of the tube and lift the lid; the module stays in its mold",
            )
            .source("chosen: the mold goes on to centre the shell"),
        prepare("dip-coat", COATING, &[CONTAINER, HOLDER, CONNECTOR, O_RING, TUBE])
            .told(
                "instead of spraying: part the halves, put the connector back into the tube, hang \
                 the module by it from the holder into the container, filled with the black mixture, \
                 and let it drip",
            )
            .source("chosen: for those who have no spray gun"),
        step("pour-filling-gel", JOINING, &[TUBE], filling.fills(&[TUBE], FILLING_GEL, up, in_tube))
            .told("fill the tube to its rim")
            .source("III-B.1"),
        bond("join-shell", JOINING, &[COLLAR, DIFFUSER, SHELL, DOWEL], ROOM_24_H)
            .told(
                "put the collar on, lower diffuser and shell through it onto the wet gel, let it \
                 cure",
            )
            .source("III-B.1: the filling gel glues the tube to the shell; the collar is chosen"),
        demold("open-translucent-mold", JOINING, off_outer)
            .told("lift the collar, part the halves")
            .source("III-B.1"),
        assemble("assemble", SENSOR, &[LED_BOARD, LED, CAMERA, BASE])
            .told(format!(
                "press the LED board in from below, screw the camera to the base, push the base in, \
                 join both with {} M{} screws",
                joints.shell_base.poses.len(),
                joints.shell_base.screw.thread_mm
            ))
            .source("III-B.2 to III-B.4")
            .also(joints.camera.names())
            .also(joints.shell_base.names())
            .also(joints.mounting.nut_name()),
    ]
}
