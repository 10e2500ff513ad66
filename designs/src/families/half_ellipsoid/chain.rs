//! How a half-ellipsoid sensor is built, step by step.

use fabkit_geometry::{Cure, Opening, Point3, Pull, Step, Vector3};

use super::bodies::*;
use super::joints::Joints;
use super::layout::Layout;
use super::parameters::HalfEllipsoid;
use super::tooling::{Boundary, vent_circles_mm, vent_poses};
use crate::assembling::{
    Liquid, Name, SENSOR, assemble, bond, demold, liquid, make, peeled, rigid, step,
};

/// Toward the tip.
fn up() -> Vector3<f64> {
    Vector3::z()
}

/// A silicone tool that is peeled off.
fn peel(p: &HalfEllipsoid, body: Name, direction: Vector3<f64>) -> Pull {
    peeled(body, direction, &p.tooling.silicone_material)
}

/// What the molds are cast from.
fn silicone(p: &HalfEllipsoid) -> Liquid {
    liquid(&p.tooling.silicone_material, 0.1)
}

fn opening(name: &str, point: Point3<f64>, axis: Vector3<f64>, radius_mm: f64) -> Opening {
    Opening { name: name.into(), point, axis, radius_mm }
}

/// The vents as openings of one layer's foot: each disc is centred on the foot and encloses its
/// vent, which on the thin layers' circle serves two layers.
fn foot_vents(p: &HalfEllipsoid, layout: &Layout, boundary: Boundary) -> Vec<Opening> {
    let (circle, inner, outer) = match boundary {
        Boundary::Inner => (0, layout.shell_offset_mm, layout.inner_offset_mm),
        Boundary::Outer => (1, layout.inner_offset_mm, layout.outer_offset_mm),
        Boundary::Black => (1, layout.outer_offset_mm, layout.black_offset_mm),
    };
    let beside = layout.foot_of((inner + outer) / 2.0) - vent_circles_mm(layout)[circle];
    let radius_mm = p.tooling.vent_diameter.mm() / 2.0 + beside.abs();
    let poses = vent_poses(p, layout, circle).into_iter().enumerate();
    poses
        .map(|(i, pose)| {
            let point = pose.point(Point3::new(beside, 0.0, 0.0));
            opening(&format!("vent {}", i + 1), point, -up(), radius_mm)
        })
        .collect()
}

/// Every step from printing to the sensor.
pub fn chain(p: &HalfEllipsoid, layout: &Layout) -> Vec<Step> {
    let first = make(
        "print the negatives and the housing in resin, have the shell machined and vapor polished, \
         have the board made; varnish the negatives and spray them with release agent",
    );
    let mut steps = vec![first.source("III-C, figure 3 (i)")];
    steps.extend(Boundary::ALL.into_iter().flat_map(|boundary| silicone_cup(p, layout, boundary)));
    steps.extend(silicone_core(p, layout));
    steps.extend(Boundary::ALL.into_iter().flat_map(|boundary| elastomer(p, layout, boundary)));
    steps.extend(finish(p, layout));
    steps
}

fn silicone_cup(p: &HalfEllipsoid, layout: &Layout, boundary: Boundary) -> [Step; 2] {
    let (cup, walls, place) = (boundary.cup(), [boundary.negative(), SLEEVE], boundary.casting());
    let top = Point3::new(0.0, 0.0, layout.silicone_top_z_mm);
    let open = vec![opening("free surface", top, up(), layout.silicone_radius_mm)];
    let pour = silicone(p).fills(&walls, cup, up(), open);
    // The silicone stretches, not the negative.
    let pulls = vec![rigid(SLEEVE, up()), peel(p, cup, up())];
    [
        step(format!("pour-{}", cup.name), place, &walls, pour)
            .told(
                "stand the sleeve on the negative, pour in a thin stream beside the dome up to the \
                 rim, degas until the bubbles have left",
            )
            .source("III-C, figure 3 (ii); sleeve chosen"),
        demold(format!("peel-{}", cup.name), place, pulls)
            .told("lift the sleeve, push the silicone out of it and peel it off the dome")
            .source("III-C, figure 3 (ii)"),
    ]
}

fn silicone_core(p: &HalfEllipsoid, layout: &Layout) -> [Step; 2] {
    let surface = Point3::new(0.0, 0.0, layout.core_flange_z_mm);
    let open = vec![opening("free surface", surface, -up(), layout.silicone_radius_mm)];
    let pour = silicone(p).fills(&[CORE_NEGATIVE], CORE, -up(), open);
    [
        step("pour-silicone-core", CAST_CORE, &[CORE_NEGATIVE], pour)
            .told("fill the vessel to the shoulder of its lip, degas; the pins stay uncovered")
            .source("III-C, figure 3 (ii)"),
        demold("peel-silicone-core", CAST_CORE, vec![peel(p, CORE, -up())])
            .told("blow air under the flange's edge and draw the core out")
            .source("III-C, figure 3 (ii)"),
    ]
}

fn elastomer(p: &HalfEllipsoid, layout: &Layout, boundary: Boundary) -> [Step; 2] {
    let (layer, cup, mold) = (boundary.layer(), boundary.cup(), boundary.mold());
    let mut openings = foot_vents(p, layout, boundary);
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
                "spray the mold with release agent, brush the slots full, put the mold over core and inner elastomer, tip up; press the \
                 mixture in through the vents below until it rises from the vent at the tip; tape \
                 the vents below; trim the sprue at the tip",
                "III-C, figure 3 (iv); tip up is chosen: the paper's way, tip down, leaves air in \
                 the slots",
            )
        }
        Boundary::Black => (
            &[cup, CORE, OUTER],
            &p.black_gel.material,
            -up(),
            "spray the mold with release agent, fill it, lower core and elastomers into it on the keys, wipe what rises through \
             the vents",
            "III-C, figure 3 (v)",
        ),
    };
    // A few tenths of a gram cannot be weighed and mixed alone.
    let pour = liquid(material, 3.0).fills(walls, layer, direction, openings);
    let is_last = boundary == Boundary::Black;
    let pulls = [peel(p, cup, up())].into_iter().chain(is_last.then(|| peel(p, CORE, -up())));
    [
        step(format!("pour-{}", layer.name), mold, &[cup, CORE], pour)
            .told(instruction)
            .source(source),
        demold(format!("peel-{}", layer.name), mold, pulls.collect())
            .told(if is_last {
                "peel the outer mold off, then draw the core out; trim the vents' sprues"
            } else {
                "peel the outer mold off; what was cast stays on the core; punch the vents clear"
            })
            .source(source),
    ]
}

fn finish(p: &HalfEllipsoid, layout: &Layout) -> [Step; 3] {
    let [sealed, glued] = [24.0, 1.0].map(|hours| Cure { hours, celsius: 23.0 });
    let electronics = [CAMERA, POST, BASE, LED_BOARD, WHITE_LED, UV_LED, DIFFUSER];
    [
        bond("bond-shell", SENSOR, &[SHELL, INNER, OUTER, BLACK], sealed)
            .told(
                "coat the shell with clear silicone sealant and push it into the elastomers until \
                 its shoulder is level with their feet",
            )
            .source("III-C, figure 3 (vi); cure time chosen"),
        bond("glue-electronics", SENSOR, &electronics, glued)
            .told(
                "thread the camera's cable through post and base, solder its plug; glue post, board \
                 and diffusion ring to the base with instant adhesive, wires through the slot",
            )
            .source("III-C, sensor assembly"),
        assemble("assemble", SENSOR, &[HOLDER])
            .told(
                "glue the shell's foot into its holder with instant adhesive, slide the holder over \
                 the base, join both with the M1.2 bolts",
            )
            .source("III-C, sensor assembly")
            .also(Joints::new(p, layout).holder.names()),
    ]
}
