//! How the sensor is built, step by step.

use std::f64::consts::FRAC_1_SQRT_2;

use fabkit_geometry::{Action, Cure, Length, Mix, Opening, Point3, Pour, Spray, Step, Vector3};

use super::channels::Side;
use super::display::needle_hole_mm;
use super::joints::Joints;
use super::layers::{
    display_channel_y, display_inlet, rest_x, side_volume_mm3, tube_poses, tube_volume_mm3,
};
use super::layout::Layout;
use super::parameters::SheetMold;
use super::{CHANNEL_MOLD, MARKER_MOLD, SENSOR};
use crate::assembling::{cure, free_surface, mix, names, opening, rigid, step};

/// Openings reach this far beyond what they open, mm.
const BEYOND_MM: f64 = 0.05;

/// Mixed silicone that stays in cups and is scraped off the frame, as a share of the layer.
const SCRAPED_WASTE: f64 = 0.3;

/// The marker layer's silicone with pigment.
fn dark_mix(p: &SheetMold) -> Mix {
    let mut mix = mix(&p.marker_layer.material);
    let total: f64 = mix.by_mass.iter().map(|(_, share)| share).sum();
    let pigment = p.marker_layer.pigment_share;
    mix.by_mass.push((p.marker_layer.pigment.clone(), total * pigment / (1.0 - pigment)));
    mix
}

/// Dyed water.
fn red_water() -> Mix {
    Mix {
        by_mass: vec![("water".into(), 100.0), ("red food dye".into(), 1.0)],
        density_g_per_cm3: 1.0,
        degas: true,
    }
}

/// Water does not cure; it stands until the last bubbles have risen.
const STANDING: Cure = Cure { hours: 0.5, celsius: 23.0 };

/// The open top of a square stack.
fn stack_top(side: Length, z_mm: f64) -> Opening {
    free_surface(side.mm() * FRAC_1_SQRT_2 + BEYOND_MM, z_mm, Vector3::z())
}

/// Every step from the laser to the sensor.
pub fn chain(p: &SheetMold, layout: &Layout) -> Vec<Step> {
    let joints = Joints::new(p, layout);
    let mut steps = casting(p, layout);
    for side in Side::BOTH {
        steps.push(glue_tubes(p, layout, side));
    }
    steps.extend(display(p, layout));
    for side in Side::BOTH {
        steps.push(fill(p, layout, side));
    }
    let assemble = step(
        "assemble",
        "screw the camera and the spacers to the floor, stick an LED strip to each wall, stand the \
         walls in their slots, put ceiling, marker frame, interface and bars on, and draw all \
         together with the eight corner screws",
        Some(SENSOR),
        &[
            "box-floor",
            "box-wall",
            "box-wall-cable",
            "box-ceiling",
            "mold-marker-frame",
            "clamp-bar",
            "camera",
            "spacer-m2",
            "box-spacer",
            "led-strip",
        ],
        Action::Assemble,
        "II-A, figure 2: interface on a rigid frame with the camera inside; joints chosen",
    )
    .also(joints.camera.names())
    .also(joints.housing.names());
    let raise = step(
        "raise-display-camera",
        "put the second camera on four spacers above the display",
        Some(SENSOR),
        &["stand-plate", "stand-spacer", "camera", "spacer-m2"],
        Action::Assemble,
        "II-A, figure 2: a camera sees the display; stand chosen",
    )
    .also(joints.camera.names())
    .also(joints.display.names());
    steps.extend([assemble, raise]);
    steps
}

/// The two soft layers, and their joining.
fn casting(p: &SheetMold, layout: &Layout) -> Vec<Step> {
    let (down, up) = (-Vector3::z(), Vector3::z());
    let [of_channels, of_markers] = Joints::new(p, layout).stacks;
    let channel_walls = ["mold-floor", "mold-channel-comb", "mold-channel-frame"];
    let marker_walls = ["mold-floor", "mold-marker-plate", "mold-marker-frame"];
    vec![
        step(
            "make",
            "cut all sheets; seal the wooden ones with acrylic lacquer",
            None,
            &[],
            Action::Make,
            "II-A; the seal is chosen: bare wood can keep platinum silicone from curing",
        ),
        step(
            "stack-channel-mold",
            "bolt floor, comb and frame together, spray release agent, lay the stack level",
            Some(CHANNEL_MOLD),
            &channel_walls,
            Action::Assemble,
            "II-A",
        )
        .also(of_channels.names()),
        step(
            "pour-channel-layer",
            "pour, draw the air out in the vacuum chamber, scrape level with the frame",
            Some(CHANNEL_MOLD),
            &channel_walls,
            Action::Pour(Pour {
                layer: "channel-layer".into(),
                walls: names(&channel_walls),
                up,
                openings: vec![stack_top(p.channel_layer.side, layout.touch_z)],
                mix: mix(&p.channel_layer.material),
                waste: SCRAPED_WASTE,
                cure: cure(&p.channel_layer.material),
            }),
            "II-A: cast first, degassed in a vacuum chamber; cure from the data sheet",
        ),
        step(
            "open-channel-mold",
            "undo the bolts; part the sheets with a screwdriver in the comb's notches: floor, then \
             comb; push the layer out of the frame",
            Some(CHANNEL_MOLD),
            &[],
            Action::Demold(vec![
                rigid("mold-floor", down),
                rigid("mold-channel-comb", down),
                rigid("mold-channel-frame", up),
            ]),
            "chosen",
        ),
        step(
            "stack-marker-mold",
            "bolt floor, marker plate and frame together, spray release agent, lay the stack level",
            Some(MARKER_MOLD),
            &marker_walls,
            Action::Assemble,
            "II-A: wood, which the laser does not warp",
        )
        .also(of_markers.names()),
        step(
            "pour-marker-layer",
            "pour, draw the air out of the marker holes in the vacuum chamber, scrape level",
            Some(MARKER_MOLD),
            &marker_walls,
            Action::Pour(Pour {
                layer: "marker-layer".into(),
                walls: names(&marker_walls),
                up,
                openings: vec![stack_top(p.marker_layer.side, layout.bond_z)],
                mix: dark_mix(p),
                waste: SCRAPED_WASTE,
                cure: cure(&p.marker_layer.material),
            }),
            "II-A; pigment and its share chosen: the background must be dark and opaque",
        ),
        step(
            "open-marker-mold",
            "undo the bolts; take the floor off, ease the plate off the markers, lift the frame off",
            Some(MARKER_MOLD),
            &[],
            Action::Demold(vec![
                rigid("mold-floor", down),
                rigid("mold-marker-plate", down),
                rigid("mold-marker-frame", up),
            ]),
            "chosen",
        ),
        step(
            "paint-markers",
            "roll white silicone paint onto the ends of the markers",
            Some(SENSOR),
            &["marker-layer"],
            Action::Spray(Spray {
                layer: "marker-paint".into(),
                onto: names(&["marker-layer"]),
                mix: mix(&p.markers.paint_material),
                // Most of it stays on the roller.
                waste: 20.0,
                cure: cure(&p.markers.paint_material),
            }),
            "II-A: ends of the markers are painted white; waste chosen",
        ),
        step(
            "bond-layers",
            "brush a thin film of the same silicone onto the marker layer inside the channel \
             layer's outline, wait until it is tacky so that it does not run into the channels, \
             lay the channel layer on",
            Some(SENSOR),
            &["marker-layer", "channel-layer"],
            Action::Bond(cure(&p.channel_layer.material)),
            "chosen: silicone bonds to itself",
        ),
    ]
}

fn glue_tubes(p: &SheetMold, layout: &Layout, side: Side) -> Step {
    let layer = format!("tube-glue-{}", side.word());
    let length = p.tubes.insertion.mm();
    let radius = p.channels.width.mm().hypot(p.channels.height.mm()) / 2.0 + BEYOND_MM;
    let openings = tube_poses(p, layout, side)
        .into_iter()
        .enumerate()
        .flat_map(|(k, pose)| {
            [("inner", 0.0, -1.0), ("outer", length, 1.0)].map(|(word, z, sign)| Opening {
                name: format!("{word} end {}", k + 1),
                point: pose.point(Point3::new(0.0, 0.0, z)),
                axis: pose.vector(Vector3::new(0.0, 0.0, sign)),
                radius_mm: radius,
            })
        })
        .collect();
    step(
        format!("glue-tubes-{}", side.word()),
        format!(
            "stand the interface up with its {} side on top, coat the tubes' last {} with glue, push \
             them into the channels, fill up to the edge, keep their bores open",
            side.word(),
            p.tubes.insertion
        ),
        Some(SENSOR),
        &["marker-layer", "channel-layer", "tube"],
        Action::Pour(Pour {
            layer,
            walls: names(&["marker-layer", "channel-layer", "tube"]),
            up: Vector3::new(side.sign(), 0.0, 0.0),
            openings,
            mix: mix(&p.tubes.glue),
            // It is squeezed out of the channels.
            waste: 1.0,
            cure: cure(&p.tubes.glue),
        }),
        "II-A",
    )
}

/// Filling one side's channels, with the tubes on top.
fn fill(p: &SheetMold, layout: &Layout, side: Side) -> Step {
    let openings = tube_poses(p, layout, side)
        .into_iter()
        .enumerate()
        .map(|(k, pose)| {
            opening(format!("tube {}", k + 1), &pose, p.tubes.inner_diameter.mm() / 2.0)
        })
        .collect();
    step(
        format!("fill-{}", side.word()),
        format!(
            "hold the interface in a tank of the liquid with its {} side up and squeeze the air out \
             of the channels, then plug the tubes onto the needles under water",
            side.word()
        ),
        Some(SENSOR),
        &["marker-layer", "channel-layer", "tube"],
        Action::Pour(Pour {
            layer: format!("liquid-{}", side.word()),
            walls: [
                names(&["marker-layer", "channel-layer", "tube"]),
                vec![format!("tube-glue-{}", side.word())],
            ]
            .concat(),
            up: Vector3::new(side.sign(), 0.0, 0.0),
            openings,
            mix: red_water(),
            // What the tubes hold; the tank needs more.
            waste: f64::from(p.channels.per_side) * tube_volume_mm3(p) / side_volume_mm3(p),
            cure: STANDING,
        }),
        "II-A: in a tank, as channels with one end cannot be filled with a syringe",
    )
}

fn display(p: &SheetMold, layout: &Layout) -> Vec<Step> {
    let place = layout.sensor_from_display;
    let sheet = p.display.sheet.mm();
    let openings = display_channel_y(p)
        .into_iter()
        .enumerate()
        .flat_map(|(k, y)| {
            let [x, _] = display_inlet(p, y);
            let half_face = p.display.channel_width.mm().hypot(sheet) / 2.0 + BEYOND_MM;
            [
                Opening {
                    name: format!("needle {}", k + 1),
                    point: place.point(Point3::new(x, y, 2.0 * sheet)),
                    axis: Vector3::z(),
                    radius_mm: needle_hole_mm(p),
                },
                Opening {
                    name: format!("air ahead {}", k + 1),
                    point: place.point(Point3::new(rest_x(p), y, 1.5 * sheet)),
                    axis: -Vector3::x(),
                    radius_mm: half_face,
                },
            ]
        })
        .collect();
    let sheets = ["display-back", "display-channels", "display-cover"];
    vec![
        step(
            "cement-display",
            "draw the three sheets together with bolts, let solvent cement run in between them",
            Some(SENSOR),
            &sheets,
            Action::Bond(Cure { hours: 24.0, celsius: 23.0 }),
            "chosen: channels closed at their far ends, air in them drives the liquid back (II-A)",
        )
        .also(Joints::new(p, layout).display.names()),
        step(
            "glue-needles",
            "glue the needles into the cover; they stop on the channels' edges, the bore over the \
             channel",
            Some(SENSOR),
            &["display-cover", "needle"],
            Action::Bond(Cure { hours: 24.0, celsius: 23.0 }),
            "chosen",
        ),
        step(
            "fill-display",
            "draw liquid in through each needle up to the same length, needles down",
            Some(SENSOR),
            &[&sheets[..], &["needle"]].concat(),
            Action::Pour(Pour {
                layer: "liquid-display".into(),
                walls: names(&[&sheets[..], &["needle"]].concat()),
                up: -Vector3::x(),
                openings,
                mix: red_water(),
                waste: 1.0,
                cure: STANDING,
            }),
            "II-A: the display shows the liquid of each channel",
        ),
    ]
}
