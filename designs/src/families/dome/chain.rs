//! How a dome sensor is built, step by step.

use fabkit_geometry::{Action, Cure, Pour, Spray, Step, Vector3};

use super::joints::Joints;
use super::layout::Layout;
use super::mold::vent_poses;
use super::parameters::Dome;
use super::tooling::{FormLayout, PUSH_HOLE_RADIUS_MM};
use super::{COATING, FORM, JOINING, TRANSLUCENT_MOLD, TRANSPARENT_MOLD, cavities};
use crate::assembling::{SENSOR, free_surface, mix, names, rigid, step, vents};

const ROOM_24_H: Cure = Cure { hours: 24.0, celsius: 23.0 };

/// Every step from printing to the sensor.
pub fn chain(p: &Dome, layout: &Layout) -> Vec<Step> {
    let [transparent, translucent] = cavities(p, layout);
    let vent_radius = p.mold.vent_diameter.mm() / 2.0;
    let form = FormLayout::new(p, layout);
    let joints = Joints::new(p, layout);
    // Molds and tube are used tip down.
    let up = -Vector3::z();
    let halves_apart = |a: &str, b: &str| vec![rigid(a, -Vector3::x()), rigid(b, Vector3::x())];
    let (mold_a, mold_b) = ("mold-transparent-gel-a", "mold-transparent-gel-b");
    let (outer_a, outer_b) = ("mold-translucent-gel-a", "mold-translucent-gel-b");

    let mut push_hole = free_surface(PUSH_HOLE_RADIUS_MM, 0.0, up);
    push_hole.name = "push hole, taped".into();
    push_hole.point.z = form.silicone_top_z;
    push_hole.axis = Vector3::z();

    vec![
        step(
            "make",
            "print, cut and etch all parts; press the dowels in",
            None,
            &[],
            Action::Make,
            "III-B, figure 4a",
        ),
        step(
            "silicone-mold",
            "optional, for a smoother transparent gel: hang the glass tube into the cup by the bridge \
             and pour silicone around it",
            Some(FORM),
            &["form-cup", "form-bridge", "form-tube"],
            Action::Pour(Pour {
                layer: "silicone-mold".into(),
                walls: names(&["form-cup", "form-tube"]),
                up,
                openings: vec![free_surface(form.silicone_radius, 0.0, up), push_hole],
                mix: mix(&p.form.silicone_material),
                waste: 0.1,
                cure: Cure { hours: 6.0, celsius: 23.0 },
            }),
            "III-B.1, figure 4 b2; cure time from the material's data sheet",
        )
        .also(joints.form.names()),
        step(
            "prime",
            "clean the tube and prime it with PR-1200 RTV; spray the mold with Ease Release 200",
            None,
            &["tube", mold_a, mold_b],
            Action::Prepare,
            "III-B.1",
        ),
        step(
            "pour-transparent-gel",
            "fill the mold, push the tube in on its connector until the lid closes, wipe what rises \
             through the vents",
            Some(TRANSPARENT_MOLD),
            &[mold_a, mold_b, "lid-transparent-gel", "connector", "o-ring", "tube", "dowel"],
            Action::Pour(Pour {
                layer: transparent.layer.into(),
                walls: names(&[mold_a, mold_b, "lid-transparent-gel", "tube"]),
                up,
                openings: vents(&vent_poses(p, &transparent), vent_radius),
                mix: mix(&p.transparent_gel.material),
                waste: 0.5,
                cure: ROOM_24_H,
            }),
            "III-B.1",
        ),
        step(
            "open-transparent-mold",
            "pull the connector out of the tube, lift the lid with a screwdriver in its pry slots, \
             then part the halves",
            Some(TRANSPARENT_MOLD),
            &[],
            Action::Demold(
                [
                    // Its flange stands on the lid.
                    vec![rigid("connector", up), rigid("lid-transparent-gel", up)],
                    halves_apart(mold_a, mold_b),
                ]
                .concat(),
            ),
            "III-B.1",
        ),
        step(
            "spray-coat",
            "spray the black mixture onto the inside of the outer mold",
            Some(TRANSLUCENT_MOLD),
            &[outer_a, outer_b],
            Action::Spray(Spray {
                layer: "black-coat".into(),
                onto: names(&[outer_a, outer_b]),
                mix: mix(&p.coat.material),
                // Five sixths of the mixture is thinner, and most of a spray misses.
                waste: 20.0,
                cure: ROOM_24_H,
            }),
            "III-B.1; waste chosen",
        ),
        step(
            "pour-translucent-gel",
            "at once, fill the outer mold and push the cured transparent gel in on its connector until \
             the lid closes",
            Some(TRANSLUCENT_MOLD),
            &[outer_a, outer_b, "lid-translucent-gel", "connector", "o-ring", "tube", "dowel"],
            Action::Pour(Pour {
                layer: translucent.layer.into(),
                walls: names(&[
                    outer_a,
                    outer_b,
                    "lid-translucent-gel",
                    "transparent-gel",
                    "black-coat",
                ]),
                up,
                openings: vents(&vent_poses(p, &translucent), vent_radius),
                mix: mix(&p.translucent_gel.material),
                waste: 0.5,
                cure: ROOM_24_H,
            }),
            "III-B.1",
        ),
        step(
            "lift-lid",
            "pull the connector out of the tube and lift the lid; the module stays in its mold",
            Some(TRANSLUCENT_MOLD),
            &[],
            Action::Demold(vec![rigid("connector", up), rigid("lid-translucent-gel", up)]),
            "chosen: the mold goes on to centre the shell",
        ),
        step(
            "dip-coat",
            "instead of spraying: part the halves, put the connector back into the tube, hang the \
             module by it from the holder into the container, filled with the black mixture, and \
             let it drip",
            Some(COATING),
            &["coating-container", "coating-holder", "connector", "o-ring", "tube"],
            Action::Prepare,
            "chosen: for those who have no spray gun",
        ),
        step(
            "pour-filling-gel",
            "fill the tube to its rim",
            Some(JOINING),
            &["tube"],
            Action::Pour(Pour {
                layer: "filling-gel".into(),
                walls: names(&["tube"]),
                up,
                openings: vec![free_surface(layout.tube_bore_radius, 0.0, up)],
                mix: mix(&p.filling_gel.material),
                waste: 0.1,
                cure: ROOM_24_H,
            }),
            "III-B.1",
        ),
        step(
            "join-shell",
            "put the collar on, lower diffuser and shell through it onto the wet gel, let it cure",
            Some(JOINING),
            &["collar", "diffuser", "shell", "dowel"],
            Action::Bond(ROOM_24_H),
            "III-B.1: the filling gel glues the tube to the shell; the collar is chosen",
        ),
        step(
            "open-translucent-mold",
            "lift the collar, part the halves",
            Some(JOINING),
            &[],
            Action::Demold([vec![rigid("collar", up)], halves_apart(outer_a, outer_b)].concat()),
            "III-B.1",
        ),
        step(
            "assemble",
            format!(
                "press the LED board in from below, screw the camera to the base, push the base in, \
                 join both with {} M{} screws",
                joints.shell_base.poses.len(),
                joints.shell_base.screw.thread_mm
            ),
            Some(SENSOR),
            &["led-board", "led", "camera", "base"],
            Action::Assemble,
            "III-B.2 to III-B.4",
        )
        .also(joints.camera.names())
        .also(joints.shell_base.names()),
    ]
}
