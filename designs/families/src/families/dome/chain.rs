//! Assembly steps of a dome sensor, from printing to the closed sensor.

use fabkit_geometry::{Cure, FixingMeans, Pull, Step, Vector3};

use super::molds::{Cavity, form, vents};
use super::parameters::*;
use super::{DomeLayout, Joints, cavities, electronics, housing};
use crate::blocks::cup_and_bridge::PUSH_HOLE_RADIUS_MM;
use crate::blocks::{DOWEL, LED};
use crate::chain_builder::{
    Liquid, Name, ROOM_24_H, SENSOR, assemble, bond, demold, free_surface, liquid, make, prepare,
    rigid, step,
};

/// Cure of a material that gets its next layer while it is still wet.
const NO_CURE: Cure = Cure { hours: 0.0, celsius: 23.0 };
/// Cure of the silicone mold, from the material's data sheet.
const ROOM_6_H: Cure = Cure { hours: 6.0, celsius: 23.0 };

/// Data that all steps are built from.
struct StepSequence<'a> {
    p: &'a Dome,
    layout: &'a DomeLayout,
    joints: Joints,
    /// Up direction while casting: molds and tube are used tip down.
    up: Vector3<f64>,
    inner: Cavity,
    outer: Cavity,
}

/// Returns all steps, from printing to the finished sensor.
pub fn chain(p: &Dome, layout: &DomeLayout) -> Vec<Step> {
    let [inner, outer] = cavities(p, layout);
    let (joints, up) = (Joints::new(p, layout), -Vector3::z());
    let chain = StepSequence { p, layout, joints, up, inner, outer };
    let steps = [
        chain.preparation_steps(),
        chain.transparent_gel_steps(),
        chain.translucent_gel_steps(),
        chain.joining_steps(),
        chain.closing_steps(),
    ];
    steps.concat()
}

impl StepSequence<'_> {
    fn is_silicone(&self) -> bool {
        self.p.molds.route == MoldRoute::Silicone
    }

    fn is_dipped(&self) -> bool {
        self.p.coat.method == CoatMethod::Dip
    }

    fn make_parts_step(&self) -> Step {
        let dowels = if self.is_silicone() { "" } else { "; press the dowels in" };
        make(format!("print, cut and etch all parts{dowels}")).source("III-B, figure 4a")
    }

    fn preparation_steps(&self) -> Vec<Step> {
        let mut steps = vec![self.make_parts_step()];
        if self.is_silicone() {
            let [cast, open] = self.silicone_mold_steps(&self.inner);
            let cut = self.cut_tube_step().during_cure_of(&cast.name);
            steps.extend([cast, cut, open]);
            steps.extend(self.silicone_mold_steps(&self.outer));
        } else {
            steps.push(self.cut_tube_step());
        }
        let molds = [self.inner.mold_walls(), self.outer.mold_walls()].concat();
        steps.push(
            prepare("prime", None, &[&[TUBE][..], &molds].concat())
                .with_instruction(
                    "clean the tube and prime it with PR-1200 RTV; spray the molds with Ease Release \
                     200 and let it dry: silicone would grow together with silicone",
                )
                .source("III-B.1"),
        );
        steps
    }

    fn cut_tube_step(&self) -> Step {
        prepare("cut-tube", CUTTING, &[TUBE_JIG, TUBE])
            .with_instruction(
                "put the test tube into the jig, tip first, until it stands; mark it all around at the \
                 jig's rim with a diamond file or a wet cutting disc, break it there, and grind the edge \
                 flat and blunt on wet paper of grain 400, goggles and gloves on",
            )
            .source("chosen: the paper shows a cut tube and does not say how")
    }

    /// Casts a seamless mold around a glass tube, then pulls the tube out.
    fn silicone_mold_steps(&self, cavity: &Cavity) -> [Step; 2] {
        let form = form(self.p, self.layout, cavity);
        let mut push_hole = free_surface(PUSH_HOLE_RADIUS_MM, 0.0, self.up);
        push_hole.name = "push hole, taped".into();
        push_hole.point.z = form.silicone_top_z;
        push_hole.axis = Vector3::z();
        let openings = vec![free_surface(form.silicone_radius, 0.0, self.up), push_hole];
        let silicone = liquid(&self.p.form.silicone_material, 0.1).with_cure(ROOM_6_H);
        let tools = &cavity.form;
        let what = cavity.layer_name;
        [
            step(
                format!("cast-{}-mold", what),
                tools.assembly,
                &[FORM_CUP, tools.bridge, tools.tube],
                silicone.fills(&[FORM_CUP, tools.tube], tools.mold, self.up, openings),
            )
            .with_instruction(
                "tape the hole in the cup's floor, hang the glass tube into the cup by the bridge and \
                 pour silicone around it, up to 3 mm below the cup's rim",
            )
            .source("III-B.1, figure 4 b2; cure time from the material's data sheet")
            .with_bodies(self.joints.form.names()),
            demold(
                format!("open-{what}-form"),
                tools.assembly,
                vec![rigid(tools.tube, self.up), rigid(tools.bridge, self.up)],
            )
            .with_instruction(
                "take the screws out, let soapy water run between glass and silicone, pull the tube out \
                 and lift the bridge; the mold stays in its cup, which centres the lid",
            )
            .source("chosen: nothing parts the mold, so that no seam runs over what is touched"),
        ]
    }

    /// Lists the pulls that take a cast gel out of its mold, together with connector and lid.
    fn demolding_pulls(&self, cavity: &Cavity) -> Vec<Pull> {
        let lid = [rigid(CONNECTOR, self.up), rigid(cavity.lid, self.up)];
        if self.is_silicone() {
            // The gel leaves with the lid. In the gel's frame it is the mold that moves away, in the opposite
            // direction.
            return [&[rigid(cavity.form.mold, -self.up)], &lid[..]].concat();
        }
        [&lid[..], &halves_pulls(cavity)].concat()
    }

    /// Lists the bodies that form and hold a mold while gel is cast in it.
    fn mold_tools(&self, cavity: &Cavity) -> Vec<Name> {
        let common = [CONNECTOR, O_RING, TUBE];
        let own = if self.is_silicone() {
            vec![FORM_CUP, cavity.form.mold, cavity.lid]
        } else {
            vec![cavity.halves[0], cavity.halves[1], cavity.lid, DOWEL]
        };
        [own, common.to_vec()].concat()
    }

    fn transparent_gel_steps(&self) -> Vec<Step> {
        let gel = liquid(&self.p.transparent_gel.material, 0.5).with_cure(ROOM_24_H);
        let walls = [self.inner.mold_walls(), vec![INNER_LID, TUBE]].concat();
        let openings = vents(self.p, &self.inner).openings();
        let open = match self.p.molds.route {
            MoldRoute::Silicone => {
                "bend the mold's rim to let air in and pull the tube out by its connector, with the lid; \
                 then pull the connector out and take the lid off"
            }
            MoldRoute::Printed => {
                "pull the connector out of the tube, lift the lid with a screwdriver in its pry slots, \
                 then part the halves"
            }
        };
        vec![
            step(
                "pour-transparent-gel",
                TRANSPARENT_MOLD,
                &self.mold_tools(&self.inner),
                gel.fills(&walls, TRANSPARENT_GEL, self.up, openings),
            )
            .with_instruction(
                "fill the mold, push the tube in on its connector until the lid closes, wipe what rises \
                 through the vents",
            )
            .source("III-B.1"),
            demold("open-transparent-mold", TRANSPARENT_MOLD, self.demolding_pulls(&self.inner))
                .with_instruction(open)
                .source("III-B.1"),
        ]
    }

    /// Mixes the coat with a surplus of 20 layer masses: five sixths of the mixture is thinner, and most of a spray
    /// misses.
    fn coat_mixture(&self) -> Liquid {
        liquid(&self.p.coat.material, 20.0).with_cure(ROOM_24_H)
    }

    fn translucent_gel_steps(&self) -> Vec<Step> {
        let gel = liquid(&self.p.translucent_gel.material, 0.5).with_cure(ROOM_24_H);
        let molds = self.outer.mold_walls();
        let mut steps = Vec::new();
        let mut walls = [&molds[..], &[OUTER_LID, TRANSPARENT_GEL]].concat();
        if !self.is_dipped() {
            walls.push(BLACK_COAT);
            steps.push(
                step(
                    "spray-coat",
                    TRANSLUCENT_MOLD,
                    &molds,
                    self.coat_mixture().coats(&molds, BLACK_COAT),
                )
                .with_instruction(
                    "spray the black mixture onto the inside of the outer mold in thin coats, and \
                         let it dry",
                )
                .source("III-B.1; waste chosen")
                .with_bodies((!self.is_silicone()).then(|| DOWEL.into())),
            );
        }
        let openings = vents(self.p, &self.outer).openings();
        steps.push(
            step(
                "pour-translucent-gel",
                TRANSLUCENT_MOLD,
                &self.mold_tools(&self.outer),
                gel.fills(&walls, TRANSLUCENT_GEL, self.up, openings),
            )
            .with_instruction(
                "fill the outer mold and push the cured transparent gel in on its connector until the \
                 lid closes",
            )
            .source("III-B.1"),
        );
        if self.is_dipped() {
            steps.extend(self.dip_coating_steps());
            return steps;
        }
        let lid = vec![rigid(CONNECTOR, self.up), rigid(OUTER_LID, self.up)];
        steps.push(
            demold("lift-lid", TRANSLUCENT_MOLD, lid)
                .with_instruction(
                    "pull the connector out of the tube and lift the lid; the module stays in its mold",
                )
                .source("chosen: the mold goes on to centre the shell"),
        );
        steps
    }

    /// Steps that dip the module, for users without a spray gun.
    fn dip_coating_steps(&self) -> [Step; 3] {
        [
            demold("take-out-module", TRANSLUCENT_MOLD, self.demolding_pulls(&self.outer))
                .with_instruction("take the module out of its mold, with the lid, and the lid off it")
                .source("III-B.1"),
            step(
                "dip-coat",
                COATING,
                &[CONTAINER, HOLDER, CONNECTOR, O_RING, TUBE],
                self.coat_mixture().coats(&[TRANSLUCENT_GEL], BLACK_COAT),
            )
            .with_instruction(
                "put the connector back into the tube, hang the module by it from the holder into the \
                 container, filled with the black mixture, lift it out and let it drip and dry",
            )
            .source("chosen: for those who have no spray gun"),
            assemble("put-back", JOINING, &self.outer.mold_walls())
                .with_instruction("put the module back into its mold, which centres the shell; the coat gives way")
                .source("chosen"),
        ]
    }

    fn joining_steps(&self) -> Vec<Step> {
        let is_locked = housing::has_locking_gel(self.p);
        // If a locking gel follows, the filling gel is left wet until that is poured onto it; both cure together.
        let cure = if is_locked { NO_CURE } else { ROOM_24_H };
        let filling = liquid(&self.p.filling_gel.material, 0.1).with_cure(cure);
        let in_tube = vec![free_surface(self.layout.tube_bore_radius_mm, 0.0, self.up)];
        let dowel: &[Name] = if self.is_silicone() { &[FORM_CUP] } else { &[DOWEL] };
        let mut steps = vec![
            step(
                "pour-filling-gel",
                JOINING,
                &[TUBE],
                filling.fills(&[TUBE], FILLING_GEL, self.up, in_tube),
            )
            .with_instruction("fill the tube to its rim")
            .source("III-B.1"),
            bond("join-shell", JOINING, &[&[COLLAR, DIFFUSER, SHELL], dowel].concat(), cure)
                .with_instruction(if is_locked {
                    "put the collar on, lower diffuser and shell through it onto the wet gel"
                } else {
                    "put the collar on, lower diffuser and shell through it onto the wet gel, let it \
                     cure"
                })
                .source("III-B.1: the filling gel glues the tube to the shell; the collar is chosen"),
        ];
        if is_locked {
            steps.push(self.locking_gel_step());
        }
        let off = if self.is_silicone() {
            vec![rigid(self.outer.form.mold, -self.up)]
        } else {
            halves_pulls(&self.outer).to_vec()
        };
        steps.push(
            demold("open-translucent-mold", JOINING, [vec![rigid(COLLAR, self.up)], off].concat())
                .with_instruction(if self.is_silicone() {
                    "lift the collar off the shell, bend the mold's rim to let air in and pull the \
                     module out by its shell"
                } else {
                    "lift the collar, part the halves"
                })
                .source("III-B.1"),
        );
        steps
    }

    fn locking_gel_step(&self) -> Step {
        let layout = self.layout;
        let mut surface = free_surface(layout.shell_bore_radius_mm, 0.0, self.up);
        surface.point.z = layout.gel_face_z_mm;
        let outside =
            [self.outer.mold_walls(), vec![TRANSPARENT_GEL, TRANSLUCENT_GEL, BLACK_COAT]].concat();
        let walls = [vec![FILLING_GEL, DIFFUSER, SHELL, TUBE], outside].concat();
        let gel = liquid(&self.p.filling_gel.material, 0.1).with_cure(ROOM_24_H);
        step("pour-locking-gel", JOINING, &[], gel.fills(&walls, LOCKING_GEL, self.up, vec![surface]))
            .with_instruction(format!(
                "pour more of the same gel through the shell while the first is wet, until it stands \
                 {} mm over the diffuser, so that it fills notches and groove and goes around the ribs",
                self.p.filling_gel.lock_depth.mm()
            ))
            .source("III-B.1: the filling gel glues the tube to the shell; its shape is chosen")
    }

    fn closing_steps(&self) -> Vec<Step> {
        let p = self.p;
        let baffle: &[Name] = if p.baffle.wall.mm() > 0.0 { &[BAFFLE] } else { &[] };
        let wired = !electronics::cables(p, self.layout).is_empty();
        let [wires, cable]: [&[Name]; 2] =
            if wired { [&[LED_WIRE], &[CAMERA_CABLE]] } else { [&[], &[]] };
        let press = if baffle.is_empty() { "" } else { "press the baffle into the LED board, " };
        let lead = if wired { "lay cable and wires into the slit, " } else { "" };
        vec![
            assemble("mount-leds", SENSOR, &[&[LED_BOARD, LED], baffle, wires].concat())
                .with_instruction(format!(
                    "solder the LEDs onto the board and two wires into its holes, {press}press the board \
                     into the shell from below until it meets the ribs"
                ))
                .fixing(&[LED], &[LED_BOARD], FixingMeans::Solder)
                .source("III-B.2"),
            assemble("focus", SENSOR, &[&[CAMERA, BASE], cable].concat())
                .with_instruction(format!(
                    "melt the nuts into the base, screw the camera down, {lead}push the base in without \
                     its screws, light the LEDs and look at the image; pull the base out by its pry \
                     slots, turn the lens by its rim with tweezers, and try again until the dust on the \
                     gel is sharp; then lock the lens in its thread with a drop of nail polish"
                ))
                .source("chosen: with the gel on, the lens is reached only while the base is out")
                .with_bodies(self.joints.camera.names())
                .with_bodies(self.joints.mounting.nut_name())
                .with_bodies(self.joints.shell_base.nut_name())
                .with_separate_adjustment(CAMERA),
            assemble("close", SENSOR, &[BASE])
                .with_instruction(format!(
                    "push the base in and join it to the shell with {} M{} screws",
                    self.joints.shell_base.poses.len(),
                    self.joints.shell_base.screw.thread_mm
                ))
                .source("III-B.4")
                .with_bodies([self.joints.shell_base.name()]),
        ]
    }
}

fn halves_pulls(cavity: &Cavity) -> [Pull; 2] {
    let [a, b] = cavity.halves;
    [rigid(a, -Vector3::x()), rigid(b, Vector3::x())]
}
