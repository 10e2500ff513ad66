//! The layers of the contact module, from the inside out.

use fabkit_geometry::{Color, Layer, Placement, Vector3};

use super::layout::Layout;
use super::parameters::Dome;
use super::surface::{dome, dome_shell};
use super::{COATING, JOINING, TRANSLUCENT_MOLD, TRANSPARENT_MOLD, in_sensor};

/// All layers, the innermost first.
pub fn layers(p: &Dome, layout: &Layout) -> Vec<Layer> {
    let wall = layout.wall_height;
    let cast = |assemblies: &[super::AssemblyName]| -> Vec<Placement> {
        let tools = assemblies.iter().map(|a| Placement::in_place(a.assembly()));
        std::iter::once(in_sensor()).chain(tools).collect()
    };
    let layer = |name: &str, summary: &str, solid, material: &str, recipe: &[&str]| Layer {
        name: name.into(),
        summary: summary.into(),
        solid,
        placements: Vec::new(),
        material: material.into(),
        recipe: recipe.iter().map(|step| step.to_string()).collect(),
        color: [255, 255, 255],
        opacity: 0.35,
        // A dome and a bowl have no handles.
        genus: 0,
        explode_mm: Vector3::zeros(),
    };
    let lifted = |layer: Layer, color: Color, opacity: f64, z_mm: f64, placements| Layer {
        color,
        opacity,
        explode_mm: Vector3::new(0.0, 0.0, z_mm),
        placements,
        ..layer
    };
    vec![
        lifted(
            layer(
                "filling-gel",
                "spreads the LEDs' light and glues the tube to diffuser and shell",
                dome(layout.tube_bore_radius, wall),
                &p.filling_gel.material,
                &[
                    "mix A and B 1 : 1 by mass and degas in vacuum",
                    "fill the tube to its rim, tip down, the module still in its mold",
                    "lower shell and diffuser through the collar onto it",
                    "cure 24 h at room temperature",
                ],
            ),
            [214, 226, 236],
            0.35,
            20.0,
            cast(&[JOINING]),
        ),
        lifted(
            layer(
                "transparent-gel",
                "carries the translucent gel and spreads light",
                dome_shell(layout.tube_radius, layout.transparent_radius, wall),
                &p.transparent_gel.material,
                &[
                    "prime the tube with PR-1200 RTV",
                    "spray the mold with Ease Release 200",
                    "mix A and B 10 : 1 by mass and degas",
                    "pour, push the tube in on its connector, close the lid",
                    "cure about 24 h, open the mold",
                ],
            ),
            [150, 200, 235],
            0.35,
            75.0,
            cast(&[TRANSPARENT_MOLD, TRANSLUCENT_MOLD, JOINING, COATING]),
        ),
        lifted(
            layer(
                "translucent-gel",
                "brightens and darkens with its depth; its thickness is the sensing range",
                dome_shell(layout.transparent_radius, layout.translucent_radius, wall),
                &p.translucent_gel.material,
                &[
                    "mix A and B 1 : 1 by mass and degas",
                    "pour onto the wet coat at once, push the transparent gel in",
                    "cure about 24 h at room temperature",
                ],
            ),
            [240, 236, 225],
            0.6,
            105.0,
            cast(&[TRANSLUCENT_MOLD, JOINING, COATING]),
        ),
        lifted(
            layer(
                "black-coat",
                "keeps light in, ambient light out, and takes the wear",
                dome_shell(layout.translucent_radius, layout.surface_radius, wall),
                &p.coat.material,
                &[
                    "mix silicone oil, catalyst and thinner 100 : 3 : 500 by mass",
                    "spray onto the inside of the mold",
                ],
            ),
            [40, 40, 44],
            1.0,
            135.0,
            cast(&[TRANSLUCENT_MOLD, JOINING]),
        ),
    ]
}
