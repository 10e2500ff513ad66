//! How a half-ellipsoid sensor is built, step by step.

use fabkit_geometry::{Action, Cure, Opening, Point3, Pour, Pull, Step, Vector3};

use super::joints::Joints;
use super::layout::Layout;
use super::parameters::HalfEllipsoid;
use super::tooling::{Boundary, vent_circles_mm, vent_poses};
use super::{CAST_CORE, CORE, INNER, OUTER, SENSOR, SLEEVE};
use crate::assembling::{cure, mix, names, rigid, step};
use crate::materials::castable;

/// Toward the tip.
fn up() -> Vector3<f64> {
    Vector3::z()
}

/// A silicone tool that is peeled off.
fn peel(p: &HalfEllipsoid, body: &str, direction: Vector3<f64>) -> Pull {
    let limit = castable(&p.tooling.silicone_material).map(|material| material.breaking_strain);
    Pull { body: body.into(), direction, strain_limit: limit }
}

fn opening(name: &str, point: Point3<f64>, axis: Vector3<f64>, radius_mm: f64) -> Opening {
    Opening { name: name.into(), point, axis, radius_mm }
}

/// The vents as openings of one layer's foot: each disc is centred on the foot and encloses its
/// vent, which on the thin layers' circle serves two layers.
fn foot_vents(p: &HalfEllipsoid, layout: &Layout, boundary: Boundary) -> Vec<Opening> {
    let (circle, inner, outer) = match boundary {
        Boundary::Inner => (0, layout.shell_offset, layout.inner_offset),
        Boundary::Outer => (1, layout.inner_offset, layout.outer_offset),
        Boundary::Black => (1, layout.outer_offset, layout.black_offset),
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
    let mut steps = vec![step(
        "make",
        "print the negatives and the housing in resin, have the shell machined and vapor polished, \
         have the board made; varnish the negatives and spray them with release agent",
        None,
        &[],
        Action::Make,
        "III-C, figure 3 (i)",
    )];
    for boundary in Boundary::ALL {
        steps.extend(silicone_cup(p, layout, boundary));
    }
    steps.extend(silicone_core(p, layout));
    for boundary in Boundary::ALL {
        steps.extend(elastomer(p, layout, boundary));
    }
    steps.extend(finish(p, layout));
    steps
}

fn silicone_cup(p: &HalfEllipsoid, layout: &Layout, boundary: Boundary) -> [Step; 2] {
    let (cup, negative) = (boundary.cup(), boundary.negative());
    let top = Point3::new(0.0, 0.0, layout.silicone_top_z);
    [
        step(
            format!("pour-{cup}"),
            "stand the sleeve on the negative, pour in a thin stream beside the dome up to the rim, \
             degas until the bubbles have left",
            Some(boundary.casting()),
            &[negative, SLEEVE],
            Action::Pour(Pour {
                layer: cup.into(),
                walls: names(&[negative, SLEEVE]),
                up: up(),
                openings: vec![opening("free surface", top, up(), layout.silicone_radius)],
                mix: mix(&p.tooling.silicone_material),
                waste: 0.1,
                cure: cure(&p.tooling.silicone_material),
            }),
            "III-C, figure 3 (ii); sleeve chosen",
        ),
        step(
            format!("peel-{cup}"),
            "lift the sleeve, push the silicone out of it and peel it off the dome",
            Some(boundary.casting()),
            &[],
            // The silicone stretches, not the negative.
            Action::Demold(vec![rigid(SLEEVE, up()), peel(p, cup, up())]),
            "III-C, figure 3 (ii)",
        ),
    ]
}

fn silicone_core(p: &HalfEllipsoid, layout: &Layout) -> [Step; 2] {
    let surface = Point3::new(0.0, 0.0, layout.core_flange_z);
    [
        step(
            "pour-silicone-core",
            "fill the vessel to the shoulder of its lip, degas; the pins stay uncovered",
            Some(CAST_CORE),
            &["negative-core"],
            Action::Pour(Pour {
                layer: CORE.into(),
                walls: names(&["negative-core"]),
                up: -up(),
                openings: vec![opening("free surface", surface, -up(), layout.silicone_radius)],
                mix: mix(&p.tooling.silicone_material),
                waste: 0.1,
                cure: cure(&p.tooling.silicone_material),
            }),
            "III-C, figure 3 (ii)",
        ),
        step(
            "peel-silicone-core",
            "blow air under the flange's edge and draw the core out",
            Some(CAST_CORE),
            &[],
            Action::Demold(vec![peel(p, CORE, -up())]),
            "III-C, figure 3 (ii)",
        ),
    ]
}

fn elastomer(p: &HalfEllipsoid, layout: &Layout, boundary: Boundary) -> [Step; 2] {
    let (layer, cup) = (boundary.layer(), boundary.cup());
    let mut openings = foot_vents(p, layout, boundary);
    let (walls, material, direction, instruction, source): (&[&str], _, _, _, _) = match boundary {
        Boundary::Inner => (
            &[cup, CORE],
            &p.inner_elastomer.material,
            -up(),
            "spray both molds with release agent, fill the outer one, lower the core into it on its \
             keys, wipe what rises through the vents",
            "III-C, figure 3 (iii)",
        ),
        Boundary::Outer => {
            let tip = Point3::new(0.0, 0.0, layout.ellipsoid.polar + layout.outer_offset);
            openings.push(opening("tip vent", tip, up(), p.tooling.tip_vent_diameter.mm() / 2.0));
            (
                &[cup, CORE, INNER],
                &p.outer_elastomer.material,
                up(),
                "brush the slots full, put the mold over core and inner elastomer, tip up; press the \
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
            "fill the mold, lower core and elastomers into it on the keys, wipe what rises through \
             the vents",
            "III-C, figure 3 (v)",
        ),
    };
    [
        step(
            format!("pour-{layer}"),
            instruction,
            Some(boundary.mold()),
            &[cup, CORE],
            Action::Pour(Pour {
                layer: layer.into(),
                walls: names(walls),
                up: direction,
                openings,
                mix: mix(material),
                // A few tenths of a gram cannot be weighed and mixed alone.
                waste: 3.0,
                cure: cure(material),
            }),
            source,
        ),
        step(
            format!("peel-{layer}"),
            if boundary == Boundary::Black {
                "peel the outer mold off, then draw the core out; trim the vents' sprues"
            } else {
                "peel the outer mold off; what was cast stays on the core; punch the vents clear"
            },
            Some(boundary.mold()),
            &[],
            Action::Demold(match boundary {
                Boundary::Black => vec![peel(p, cup, up()), peel(p, CORE, -up())],
                _ => vec![peel(p, cup, up())],
            }),
            source,
        ),
    ]
}

fn finish(p: &HalfEllipsoid, layout: &Layout) -> [Step; 3] {
    [
        step(
            "bond-shell",
            "coat the shell with clear silicone sealant and push it into the elastomers until its \
             shoulder is level with their feet",
            Some(SENSOR),
            &["shell", INNER, OUTER, "black-gel"],
            Action::Bond(Cure { hours: 24.0, celsius: 23.0 }),
            "III-C, figure 3 (vi); cure time chosen",
        ),
        step(
            "glue-electronics",
            "thread the camera's cable through post and base, solder its plug; glue post, board and \
             diffusion ring to the base with instant adhesive, wires through the slot",
            Some(SENSOR),
            &[
                "camera",
                "camera-holder",
                "base",
                "led-board",
                "white-led",
                "uv-led",
                "diffusion-ring",
            ],
            Action::Bond(Cure { hours: 1.0, celsius: 23.0 }),
            "III-C, sensor assembly",
        ),
        step(
            "assemble",
            "glue the shell's foot into its holder with instant adhesive, slide the holder over the \
             base, join both with the M1.2 bolts",
            Some(SENSOR),
            &["shell-holder"],
            Action::Assemble,
            "III-C, sensor assembly",
        )
        .also(Joints::new(p, layout).holder.names()),
    ]
}
