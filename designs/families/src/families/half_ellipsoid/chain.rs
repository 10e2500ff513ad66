//! Assembly steps of a half-ellipsoid sensor, from printing to the connected sensor.

use fabkit_geometry::{Cure, FixingMeans, Opening, Point3, Pose, Pull, Step, Vector3};

use super::electronics::has_board_parts;
use super::housing::elastomer_names;
use super::molds::{self, Boundary, vent_poses};
use super::parameters::*;
use super::{HalfEllipsoidLayout, Joints};
use crate::chain_builder::{
    Liquid, Name, SENSOR, assemble, bond, demold, free_surface, liquid, make, peel, prepare, rigid,
    step,
};

/// Direction towards the tip.
fn up() -> Vector3<f64> {
    Vector3::z()
}

/// Pull that peels off a silicone tool.
fn peel_silicone(p: &HalfEllipsoid, body: Name, direction: Vector3<f64>) -> Pull {
    peel(body, direction, &p.tooling.silicone_material)
}

/// Silicone of the molds, with its surplus.
fn mold_silicone(p: &HalfEllipsoid) -> Liquid {
    liquid(&p.tooling.silicone_material, 0.1)
}

fn opening(name: &str, point: Point3<f64>, axis: Vector3<f64>, radius_mm: f64) -> Opening {
    Opening { name: name.into(), point, axis, radius_mm }
}

/// Openings at a layer's foot: the inner elastomer's over the vents, a thin layer's over the gates.
fn foot_openings(
    p: &HalfEllipsoid,
    layout: &HalfEllipsoidLayout,
    boundary: Boundary,
) -> Vec<Opening> {
    let feet = match boundary {
        Boundary::Inner => {
            let radius_mm = p.tooling.vent_diameter.mm() / 2.0;
            let vent = |(pose, i): (&Pose, u32)| {
                opening(&format!("vent {i}"), pose.point(Point3::origin()), -up(), radius_mm)
            };
            return vent_poses(p, layout).iter().zip(1..).map(vent).collect();
        }
        Boundary::Outer => [layout.inner_offset_mm, layout.outer_offset_mm],
        Boundary::Black => [layout.outer_offset_mm, layout.black_offset_mm],
    };
    let gate = |(rad, i): (f64, u32)| {
        let (point, radius_mm) =
            molds::gate_opening_disc(rad, layout, feet.map(|offset| layout.foot_radius_mm(offset)));
        opening(&format!("gate {i}"), point, -up(), radius_mm)
    };
    molds::gate_angles_rad(p).zip(1..).map(gate).collect()
}

/// Returns all steps, from printing to the finished sensor.
pub fn chain(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Vec<Step> {
    let first = make(
        "print the negatives and the housing in resin, have the shell machined and vapor polished, \
         have the board made; varnish the negatives and spray them with release agent",
    );
    let mut steps = vec![first.source("III-C, figure 3 (i)")];
    let mut cups =
        Boundary::for_design(p).into_iter().flat_map(|one| silicone_cup_steps(p, layout, one));
    // The core is cast in its own vessel, so it need not wait for the first cup.
    let [core, drawn] = silicone_core_steps(p, layout);
    let first = cups.next();
    let core = match &first {
        Some(cup) => core.during_cure_of(&cup.name),
        None => core,
    };
    steps.extend(first.into_iter().chain([core]).chain(cups).chain([drawn]));
    steps.extend(
        Boundary::for_design(p)
            .into_iter()
            .flat_map(|boundary| elastomer_steps(p, layout, boundary)),
    );
    steps.extend(finishing_steps(p, layout));
    steps
}

fn silicone_cup_steps(
    p: &HalfEllipsoid,
    layout: &HalfEllipsoidLayout,
    boundary: Boundary,
) -> [Step; 2] {
    let (cup, walls, place) =
        (boundary.cup(), [boundary.negative(), SLEEVE], boundary.mold_casting_assembly());
    let open = vec![free_surface(layout.silicone_radius_mm, layout.silicone_top_z_mm, up())];
    let pour = mold_silicone(p).fills(&walls, cup, up(), open);
    // The silicone stretches; the negative is rigid.
    let pulls = vec![rigid(SLEEVE, up()), peel_silicone(p, cup, up())];
    [
        step(format!("pour-{}", cup.name), place, &walls, pour)
            .with_instruction(
                "stand the sleeve on the negative, pour in a thin stream beside the dome up to the \
                 rim, degas until the bubbles have left",
            )
            .source("III-C, figure 3 (ii); sleeve chosen"),
        demold(format!("peel-{}", cup.name), place, pulls)
            .with_instruction(
                "lift the sleeve, push the silicone out of it and peel it off the dome",
            )
            .source("III-C, figure 3 (ii)"),
    ]
}

fn silicone_core_steps(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> [Step; 2] {
    let open = vec![free_surface(layout.silicone_radius_mm, layout.core_flange_z_mm, -up())];
    let pour = mold_silicone(p).fills(&[CORE_NEGATIVE], CORE, -up(), open);
    [
        step("pour-silicone-core", CAST_CORE, &[CORE_NEGATIVE], pour)
            .with_instruction(
                "fill the vessel to the shoulder of its lip, degas; the pins stay uncovered",
            )
            .source("III-C, figure 3 (ii)"),
        demold("peel-silicone-core", CAST_CORE, vec![peel_silicone(p, CORE, -up())])
            .with_instruction("blow air under the flange's edge and draw the core out")
            .source("III-C, figure 3 (ii)"),
    ]
}

fn elastomer_steps(
    p: &HalfEllipsoid,
    layout: &HalfEllipsoidLayout,
    boundary: Boundary,
) -> [Step; 2] {
    let (layer, cup, mold) = (boundary.layer(), boundary.cup(), boundary.casting_assembly());
    let mut openings = foot_openings(p, layout, boundary);
    let (walls, material, direction, instruction, source): (&[Name], _, _, _, _) = match boundary {
        Boundary::Inner => (
            &[cup, CORE],
            &p.inner_elastomer.material,
            -up(),
            "spray both molds with release agent, fill the outer one, lower the core into it on its \
             keys, wipe what rises through the vents",
            "III-C, figure 3 (iii)",
        ),
        Boundary::Outer => {
            let tip = Point3::new(0.0, 0.0, layout.ellipsoid.polar + layout.outer_offset_mm);
            openings.push(opening("tip vent", tip, up(), p.tooling.tip_vent_diameter.mm() / 2.0));
            (
                &[cup, CORE, INNER],
                &p.outer_elastomer.material,
                up(),
                "spray the mold with release agent, brush the slots full, put the mold over core and \
                 inner elastomer, tip up; press a syringe's tip into the seat in the flange from \
                 below and push until the mixture rises from the vent at the tip; leave the syringe in until it has cured; tape the vents of \
                 the inner elastomer before",
                "III-C, figure 3 (iv); tip up is chosen: the paper's way, tip down, leaves air in \
                 the slots",
            )
        }
        Boundary::Black => (
            if p.markers.is_plain() { &[cup, CORE, INNER] } else { &[cup, CORE, OUTER] },
            &p.black_gel.material,
            -up(),
            "spray the mold with release agent, fill it, lower core and elastomers into it on the \
             keys; what is too much runs through the gates into the ring and out of the syringe's seat",
            "III-C, figure 3 (v)",
        ),
    };
    // Surplus of three layer masses: a few tenths of a gram cannot be weighed and mixed alone.
    let pour = liquid(material, 3.0).fills(walls, layer, direction, openings);
    let is_last = boundary == Boundary::Black;
    let pulls = [peel_silicone(p, cup, up())]
        .into_iter()
        .chain(is_last.then(|| peel_silicone(p, CORE, -up())));
    [
        step(format!("pour-{}", layer.name), mold, &[cup, CORE], pour)
            .with_instruction(instruction)
            .source(source),
        demold(format!("peel-{}", layer.name), mold, pulls.collect())
            .with_instruction(match boundary {
                Boundary::Black => {
                    "peel the outer mold off, then draw the core out; trim what has cured in gates and \
                     ring"
                }
                Boundary::Outer => {
                    "peel the outer mold off; cut the gates at the foot and lift them and the ring out \
                     of the flange; trim the sprue at the tip"
                }
                Boundary::Inner => {
                    "peel the outer mold off; what was cast stays on the core; cut the vents' sprues off \
                     below"
                }
            })
            .source(source),
    ]
}

fn finishing_steps(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Vec<Step> {
    let [sealed, glued] = [24.0, 1.0].map(|hours| Cure { hours, celsius: 23.0 });
    let mut electronics =
        vec![CAMERA, POST, BASE, LED_BOARD, WHITE_LED, UV_LED, LED_WIRE, DIFFUSER];
    if has_board_parts(p) {
        electronics.extend([SWITCH, RESISTOR]);
    }
    let soft = [&[SHELL][..], &elastomer_names(p), &[BLACK]].concat();
    vec![
        bond("bond-shell", SENSOR, &soft, sealed)
            .with_instruction(
                "coat the shell with clear silicone sealant and push it into the elastomers until \
                 its shoulder is level with their feet",
            )
            .source("III-C, figure 3 (vi); cure time chosen"),
        bond("glue-holder", SENSOR, &[HOLDER], glued)
            .with_instruction("glue the shell's foot into its holder with instant adhesive")
            .source("III-C, sensor assembly"),
        bond("glue-electronics", SENSOR, &electronics, glued)
            .with_instruction(
                "solder LEDs, switch, resistors and wires to the board: supply, ground, and one wire that \
                 switches each kind of LEDs; thread the camera's cable through post and base, solder \
                 its plug; glue post, board and diffusion ring to the base with instant adhesive, wires \
                 through the slot",
            )
            .fixing(&[WHITE_LED, UV_LED], &[LED_BOARD], FixingMeans::Solder)
            .source("III-C: illumination system, sensor assembly"),
        assemble("assemble", SENSOR, &[HOLDER])
            .with_instruction("slide the holder over the base, join both with the M1.2 bolts")
            .source("III-C, sensor assembly")
            .with_bodies(Joints::new(p, layout).holder.names()),
        prepare("connect", None, &[])
            .with_instruction(
                "outside of the sensor: the camera's cable to its USB video board (C8209DP), the wires to \
                 5 V, ground and two pins of a Raspberry Pi; none of these has a place in the sensor",
            )
            .source("III-A: all but wires is housed inside; III-C: boards and supply"),
    ]
}
