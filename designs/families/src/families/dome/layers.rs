//! The layers of the contact module, from the inside out.

use fabkit_geometry::{Body, Color, DomeSurface};

use super::bodies::*;
use super::layout::Layout;
use super::parameters::{CoatMethod, Dome};
use super::surface::{dome, dome_shell, dome_tool};
use crate::assembling::{AssemblyName, in_sensor};

/// All layers, the innermost first; the coat ends in the surface that is touched.
pub fn layers(p: &Dome, layout: &Layout, touch: &DomeSurface) -> Vec<Body> {
    let wall = layout.wall_height_mm;
    // In every tool the layers stay together; only the sensor's picture takes them apart. A dome and
    // a bowl have no handles.
    let placed = |layer: Body, color: Color, opacity: f64, lift_mm: f64, tools: &[AssemblyName]| {
        let in_tools = tools.iter().map(|tool| tool.in_place());
        let layer = layer.placed([in_sensor().lifted(lift_mm)]).placed(in_tools);
        layer.colored(color).opaque(opacity)
    };
    let is_dipped = p.coat.method == CoatMethod::Dip;
    let dipped: &[AssemblyName] = if is_dipped { &[COATING] } else { &[] };
    vec![
        placed(
            FILLING_GEL.cast(dome(layout.tube_bore_radius_mm, wall)).from(&p.filling_gel.material),
            [214, 226, 236],
            0.35,
            26.0,
            &[JOINING],
        ),
        placed(
            TRANSPARENT_GEL
                .cast(dome_shell(layout.tube_radius_mm, layout.transparent_radius_mm, wall))
                .from(&p.transparent_gel.material),
            [150, 200, 235],
            0.35,
            88.0,
            &[&[TRANSPARENT_MOLD, TRANSLUCENT_MOLD, JOINING][..], dipped].concat(),
        ),
        placed(
            TRANSLUCENT_GEL
                .cast(dome_shell(layout.transparent_radius_mm, layout.translucent_radius_mm, wall))
                .from(&p.translucent_gel.material),
            [240, 236, 225],
            0.6,
            121.0,
            &[&[TRANSLUCENT_MOLD, JOINING][..], dipped].concat(),
        ),
        placed(
            BLACK_COAT
                .cast(
                    touch
                        .solid(0.0, touch.foot_z_mm)
                        .minus(dome_tool(layout.translucent_radius_mm, wall)),
                )
                .from(&p.coat.material),
            [62, 64, 70],
            1.0,
            154.0,
            if dipped.is_empty() { &[TRANSLUCENT_MOLD, JOINING] } else { &[COATING, JOINING] },
        ),
    ]
}
