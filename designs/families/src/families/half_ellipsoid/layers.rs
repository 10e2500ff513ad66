//! What is poured: the three elastomers, and the silicone molds they are poured in.
//!
//! A solid and its negative are cut from one and the same tree, so that the chain from print to
//! silicone to elastomer closes.

use fabkit_geometry::{Body, CUT_OVERLAP_MM, Color, Placement, Solid};

use super::bodies::*;
use super::layout::Layout;
use super::markers;
use super::parameters::HalfEllipsoid;
use super::runner;
use super::tooling::{Boundary, keys, tip_vent, ways_out};
use crate::assembling::{AssemblyName, Name, SENSOR};

const RED_ELASTOMER: Color = [224, 170, 165];
const BLUE_ELASTOMER: Color = [150, 180, 225];
const BLACK_GREY: Color = [62, 64, 70];
const SILICONE: Color = [120, 190, 170];

fn layer(name: Name, solid: Solid, material: &str) -> Body {
    name.cast(solid).from(material).colored(SILICONE)
    // Bowls with blind slots or pegs have no handles.
}

/// The elastomers, the innermost first, then the silicone molds.
pub fn layers(p: &HalfEllipsoid, layout: &Layout) -> Vec<Body> {
    let mut layers = elastomers(p, layout);
    layers.push(core(p, layout));
    layers.extend(Boundary::all(p).into_iter().map(|boundary| cup(p, layout, boundary)));
    layers
}

/// The translucent ones, from the inside out.
pub fn elastomer_names(p: &HalfEllipsoid) -> Vec<Name> {
    let all = Boundary::all(p).into_iter().map(Boundary::layer);
    all.filter(|name| *name != BLACK).collect()
}

/// The molds that a layer is in, from the one that it is cast in.
fn molds_from(p: &HalfEllipsoid, boundary: Boundary) -> Vec<AssemblyName> {
    let all = Boundary::all(p).into_iter();
    all.skip_while(|other| *other != boundary).map(Boundary::mold).collect()
}

fn elastomers(p: &HalfEllipsoid, layout: &Layout) -> Vec<Body> {
    let slotted = markers::slotted(p, layout);
    let whole = |offset| layout.ellipsoid.whole(offset);
    let above_base = |solid: Solid| solid.minus(Solid::below(0.0));
    let placed = |lift_mm: f64, boundary: Boundary| -> Vec<Placement> {
        let in_tools = molds_from(p, boundary).into_iter();
        let in_tools = in_tools.map(|tool| tool.in_place().lifted(TOOL_LIFT_MM));
        std::iter::once(SENSOR.in_place().lifted(lift_mm)).chain(in_tools).collect()
    };
    let mut all = vec![
        layer(
            INNER,
            above_base(slotted.clone()).minus(whole(layout.shell_offset_mm)),
            &p.inner_elastomer.material,
        )
        .colored(RED_ELASTOMER)
        .opaque(0.8)
        .placed(placed(44.0, Boundary::Inner)),
        layer(
            OUTER,
            above_base(whole(layout.outer_offset_mm)).minus(slotted),
            &p.outer_elastomer.material,
        )
        .colored(BLUE_ELASTOMER)
        .opaque(0.8)
        .placed(placed(72.0, Boundary::Outer)),
        layer(
            BLACK,
            // Not the touched surface's own solid: OpenCascade cuts an ellipsoid from an ellipsoid, but
            // not from the same shape as a revolved profile. A test holds both against each other.
            above_base(whole(layout.black_offset_mm)).minus(whole(layout.outer_offset_mm)),
            &p.black_gel.material,
        )
        .colored(BLACK_GREY)
        .placed(placed(100.0, Boundary::Black)),
    ];
    if p.markers.is_plain() {
        all.retain(|body| body.name != OUTER.name);
    }
    all
}

/// How far elastomers are lifted off the core in pictures of molds, mm.
const TOOL_LIFT_MM: f64 = 45.0;

/// The inner boundary of the inner elastomer, on a flange that closes all three molds.
fn core(p: &HalfEllipsoid, layout: &Layout) -> Body {
    let flange = Solid::cylinder(layout.silicone_radius_mm, -layout.core_flange_z_mm)
        .at_z(layout.core_flange_z_mm);
    let pieces = [flange, layout.ellipsoid.dome_tool(layout.shell_offset_mm).named("core")];
    layer(
        CORE,
        Solid::union(pieces.into_iter().chain(keys(p, layout))).minus_all(ways_out(
            p,
            layout,
            CUT_OVERLAP_MM,
        )),
        &p.tooling.silicone_material,
    )
    .placed(
        std::iter::once(CAST_CORE)
            .chain(molds_from(p, Boundary::Inner))
            .map(AssemblyName::in_place),
    )
    // The vents, and the seat of the syringe.
    .with_handles(1 + p.tooling.vents as i32)
    .reached(runner::syringe(p, layout))
}

/// The outer boundary of one elastomer.
fn cup(p: &HalfEllipsoid, layout: &Layout, boundary: Boundary) -> Body {
    let block = Solid::cylinder(layout.silicone_radius_mm, layout.silicone_top_z_mm);
    let cavity = match boundary {
        Boundary::Inner => markers::slotted(p, layout),
        Boundary::Outer => layout.ellipsoid.whole(layout.outer_offset_mm),
        Boundary::Black => layout.ellipsoid.whole(layout.black_offset_mm),
    };
    let vent = (boundary == Boundary::Outer).then(|| tip_vent(p, layout));
    let vents = i32::from(vent.is_some());
    layer(
        boundary.cup(),
        block.minus(cavity.named("cavity")).minus_all(keys(p, layout)).minus_all(vent),
        &p.tooling.silicone_material,
    )
    .placed([boundary.casting().in_place().lifted(60.0), boundary.mold().in_place().lifted(110.0)])
    .with_handles(vents)
}
