//! Assembly steps of the sensor, from the laser to the assembled sensor.

use std::f64::consts::FRAC_1_SQRT_2;

use fabkit_geometry::{Cure, FixingMeans, Length, Mix, Opening, Point3, Step, Vector3};

use super::housing::needle_hole_mm;
use super::layers::{
    Side, display_channel_y, display_inlet, resting_end_x, side_volume_mm3, tube_poses,
    tube_volume_mm3,
};
use super::parameters::*;
use super::{Joints, SheetMoldLayout};
use crate::blocks::cable_openings::HousingSide as CableSide;
use crate::chain_builder::{
    Liquid, Name, SENSOR, assemble, bond, cure, demold, free_surface, liquid, make, mix, opening,
    rigid, step,
};

/// Margin by which an opening's radius exceeds what it opens, mm.
const OPENING_MARGIN_MM: f64 = 0.05;

/// Surplus of silicone that stays in cups or is scraped off the frame, as a fraction of the layer's mass.
const SCRAPED_WASTE: f64 = 0.3;

/// Cure of cemented sheets and needles of the display.
const CEMENT_CURE: Cure = Cure { hours: 24.0, celsius: 23.0 };

/// Returns the marker layer's silicone with pigment.
fn dark_mix(p: &SheetMold) -> Mix {
    let mut mix = mix(&p.marker_layer.material);
    let total: f64 = mix.by_mass.iter().map(|(_, share)| share).sum();
    let pigment = p.marker_layer.pigment_share;
    mix.by_mass.push((p.marker_layer.pigment.clone(), total * pigment / (1.0 - pigment)));
    mix
}

/// Returns dyed water. It does not cure: the time is the one in which the last bubbles rise.
fn red_water(waste: f64) -> Liquid {
    let mix = Mix {
        by_mass: vec![("water".into(), 100.0), ("red food dye".into(), 1.0)],
        density_g_per_cm3: 1.0,
        pot_life_h: None,
        degas: true,
    };
    Liquid { mix, waste, cure: Cure { hours: 0.5, celsius: 23.0 } }
}

/// Bodies that enclose the channels.
const INTERFACE_BODIES: [Name; 3] = [MARKER_LAYER, CHANNEL_LAYER, TUBE];

/// Opening at the top of a square stack.
fn stack_top(side: Length, z_mm: f64) -> Opening {
    free_surface(side.mm() * FRAC_1_SQRT_2 + OPENING_MARGIN_MM, z_mm, Vector3::z())
}

/// Returns all steps, from the laser to the finished sensor.
pub fn chain(p: &SheetMold, layout: &SheetMoldLayout) -> Vec<Step> {
    let joints = Joints::new(p, layout);
    let mut steps = casting_steps(p, layout);
    let cement = cement_display_step(p, layout);
    // The glue of one side cures while the display's cement does.
    let [left, right] = Side::BOTH.map(|side| glue_tubes(p, layout, side));
    let left = left.during_cure_of(&cement.name);
    steps.extend([cement, left, right]);
    steps.extend(fill_display_steps(p, layout));
    steps.extend(Side::BOTH.map(|side| fill(p, layout, side)));
    steps.push(seal_display_step());
    let walls = [BOX_FLOOR, BOX_WALL, CABLE_WALL, BOX_CEILING, MARKER_FRAME, CLAMP_BAR];
    let between = [CAMERA, BOX_CABLE, CAMERA_SPACER, BOX_SPACER, LED_STRIP];
    steps.extend([
        assemble("focus-box-camera", BOX_FOCUSING, &[BOX_FLOOR, CAMERA, CAMERA_SPACER])
            .with_instruction(format!(
                "screw the camera on its spacers to the floor; hold a printed page {:.0} mm in front of \
                 its lens, turn the lens until it is sharp, and tighten its lock",
                layout.marker_end_z_mm - layout.pupil_z_mm - p.camera.pupil_behind_front.mm()
            ))
            .source("chosen: fingers reach the lens only before the walls are around it")
            .with_bodies(joints.camera.names())
            .with_adjustment(CAMERA),
        assemble("assemble", SENSOR, &[&walls[..], &between].concat())
            .with_instruction(format!(
                "screw the spacers to the floor, plug the cable in, stick an LED strip to each wall, stand \
                 the walls in their slots{}, put ceiling, marker frame, interface and bars on, \
                 and draw all together with the eight corner screws",
                match p.housing.cable_side {
                    CableSide::Right => "",
                    CableSide::Left => ", that with the cable's opening at -x",
                    CableSide::Front => ", that with the cable's opening at -y",
                    CableSide::Back => ", that with the cable's opening at +y",
                }
            ))
            .fixing(&[LED_STRIP], &[BOX_WALL, CABLE_WALL], FixingMeans::Tape)
            .source(
                "II-A, figure 2: interface on a rigid frame with the camera inside; joints chosen",
            )
            .with_bodies(joints.camera.names())
            .with_bodies(joints.housing.names()),
        assemble(
            "raise-display-camera",
            SENSOR,
            &[STAND_PLATE, STAND_SPACER, CAMERA, STAND_CABLE, CAMERA_SPACER],
        )
        .with_instruction(
            "plug the cable in, put the second camera on four spacers above the display, look at the image; \
             turn the lens between two looks until the liquid's ends are sharp, and tighten its lock",
        )
        .source("II-A, figure 2: a camera sees the display; stand chosen")
        .with_bodies(joints.camera.names())
        .with_bodies(joints.display.names())
        .with_separate_adjustment(CAMERA),
    ]);
    steps
}

/// Steps that cast the two soft layers and join them.
fn casting_steps(p: &SheetMold, layout: &SheetMoldLayout) -> Vec<Step> {
    let (down, up) = (-Vector3::z(), Vector3::z());
    let [of_channels, of_markers] = Joints::new(p, layout).stacks;
    let channel_walls = [MOLD_FLOOR, CHANNEL_COMB, CHANNEL_FRAME];
    let marker_walls = [MOLD_FLOOR, MARKER_PLATE, MARKER_FRAME];
    let open_stack = |[floor, shape, frame]: [Name; 3]| {
        vec![rigid(floor, down), rigid(shape, down), rigid(frame, up)]
    };
    let clear = liquid(&p.channel_layer.material, SCRAPED_WASTE);
    let dark = Liquid { mix: dark_mix(p), ..liquid(&p.marker_layer.material, SCRAPED_WASTE) };
    // Surplus of 20 layer masses: most of the paint stays on the roller.
    let paint = liquid(&p.markers.paint_material, 20.0);
    let channel_top = vec![stack_top(p.channel_layer.side, layout.touch_z_mm)];
    let marker_top = vec![stack_top(p.marker_layer.side, layout.bond_z_mm)];
    vec![
        make("cut all sheets; seal the wooden ones with acrylic lacquer")
            .source("II-A; the seal is chosen: bare wood can keep platinum silicone from curing"),
        assemble("stack-channel-mold", CHANNEL_MOLD, &channel_walls)
            .with_instruction("bolt floor, comb and frame together, spray release agent, lay the stack level")
            .source("II-A")
            .with_bodies(of_channels.names()),
        step(
            "pour-channel-layer",
            CHANNEL_MOLD,
            &channel_walls,
            clear.fills(&channel_walls, CHANNEL_LAYER, up, channel_top),
        )
        .with_instruction("pour, draw the air out in the vacuum chamber, scrape level with the frame")
        .source("II-A: cast first, degassed in a vacuum chamber; cure from the data sheet"),
        demold("open-channel-mold", CHANNEL_MOLD, open_stack(channel_walls))
            .with_instruction(
                "undo the bolts; part the sheets with a screwdriver in the comb's notches: floor, \
                 then comb; push the layer out of the frame",
            )
            .source("chosen"),
        assemble("stack-marker-mold", MARKER_MOLD, &marker_walls)
            .with_instruction(
                "bolt floor, marker plate and frame together, spray release agent, lay the stack \
                 level",
            )
            .source("II-A: wood, which the laser does not warp")
            .with_bodies(of_markers.names()),
        step(
            "pour-marker-layer",
            MARKER_MOLD,
            &marker_walls,
            dark.fills(&marker_walls, MARKER_LAYER, up, marker_top),
        )
        .with_instruction("pour, draw the air out of the marker holes in the vacuum chamber, scrape level")
        .source("II-A; pigment and its share chosen: the background must be dark and opaque"),
        demold("open-marker-mold", MARKER_MOLD, open_stack(marker_walls))
            .with_instruction(
                "undo the bolts; take the floor off, ease the plate off the markers, lift the \
                 frame off",
            )
            .source("chosen"),
        step("paint-markers", SENSOR, &[MARKER_LAYER], paint.coats(&[MARKER_LAYER], MARKER_PAINT))
            .with_instruction("roll white silicone paint onto the ends of the markers")
            .source("II-A: ends of the markers are painted white; waste chosen"),
        bond("bond-layers", SENSOR, &[MARKER_LAYER, CHANNEL_LAYER], cure(&p.channel_layer.material))
            .with_instruction(
                "brush a thin film of the same silicone onto the marker layer inside the channel \
                 layer's outline, wait until it is tacky so that it does not run into the channels, \
                 lay the channel layer on",
            )
            .source("chosen: silicone bonds to itself"),
    ]
}

fn glue_tubes(p: &SheetMold, layout: &SheetMoldLayout, side: Side) -> Step {
    let length = p.tubes.insertion.mm();
    let radius = p.channels.width.mm().hypot(p.channels.height.mm()) / 2.0 + OPENING_MARGIN_MM;
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
    // Surplus of one layer mass: as much glue again is squeezed out of the channels.
    let up = Vector3::new(side.sign(), 0.0, 0.0);
    let glue = liquid(&p.tubes.glue, 1.0).fills(&INTERFACE_BODIES, side.glue(), up, openings);
    step(format!("glue-tubes-{}", side.word()), SENSOR, &INTERFACE_BODIES, glue)
        .with_instruction(format!(
            "stand the interface up with its {} side on top, coat the tubes' last {} with glue, push \
             them into the channels, fill up to the edge, keep their bores open",
            side.word(),
            p.tubes.insertion
        ))
        .fixing(&[TUBE], &[side.glue()], FixingMeans::Glue)
        .source("II-A")
}

/// Fills one side's channels, with the tubes on top.
fn fill(p: &SheetMold, layout: &SheetMoldLayout, side: Side) -> Step {
    let openings = tube_poses(p, layout, side)
        .into_iter()
        .enumerate()
        .map(|(k, pose)| {
            opening(format!("tube {}", k + 1), &pose, p.tubes.inner_diameter.mm() / 2.0)
        })
        .collect();
    // Surplus: the water in the tubes. The tank needs more.
    let waste = f64::from(p.channels.per_side) * tube_volume_mm3(p) / side_volume_mm3(p);
    let (walls, up) =
        ([&INTERFACE_BODIES[..], &[side.glue()]].concat(), Vector3::new(side.sign(), 0.0, 0.0));
    let water = red_water(waste).fills(&walls, side.liquid(), up, openings);
    step(format!("fill-{}", side.word()), SENSOR, &INTERFACE_BODIES, water)
        .with_instruction(format!(
            "hold the interface in a tank of the liquid with its {} side up and squeeze the air out \
             of the channels, then plug the tubes onto the needles under water",
            side.word()
        ))
        .fixing(&[TUBE], &[NEEDLE], FixingMeans::Push)
        .source("II-A: in a tank, as channels with one end cannot be filled with a syringe")
}

/// Sheets of the display.
const DISPLAY_SHEETS: [Name; 3] = [DISPLAY_BACK, DISPLAY_CHANNELS, DISPLAY_COVER];

fn cement_display_step(p: &SheetMold, layout: &SheetMoldLayout) -> Step {
    bond("cement-display", SENSOR, &DISPLAY_SHEETS, CEMENT_CURE)
        .with_instruction(
            "draw the three sheets together with bolts, let solvent cement run in between them",
        )
        .source("chosen: air ahead of the liquid drives it back (II-A)")
        .with_bodies(Joints::new(p, layout).display.names())
}

fn fill_display_steps(p: &SheetMold, layout: &SheetMoldLayout) -> Vec<Step> {
    let place = layout.sensor_from_display;
    let sheet = p.display.sheet.mm();
    let openings = display_channel_y(p)
        .into_iter()
        .enumerate()
        .flat_map(|(k, y)| {
            let [x, _] = display_inlet(p, y);
            let half_face = p.display.channel_width.mm().hypot(sheet) / 2.0 + OPENING_MARGIN_MM;
            [
                Opening {
                    name: format!("needle {}", k + 1),
                    point: place.point(Point3::new(x, y, 2.0 * sheet)),
                    axis: Vector3::z(),
                    radius_mm: needle_hole_mm(p),
                },
                Opening {
                    name: format!("air ahead {}", k + 1),
                    point: place.point(Point3::new(resting_end_x(p), y, 1.5 * sheet)),
                    axis: -Vector3::x(),
                    radius_mm: half_face,
                },
            ]
        })
        .collect();
    let walls = [&DISPLAY_SHEETS[..], &[NEEDLE]].concat();
    let water = red_water(1.0).fills(&walls, DISPLAY_LIQUID, -Vector3::x(), openings);
    vec![
        bond("glue-needles", SENSOR, &[DISPLAY_COVER, NEEDLE], CEMENT_CURE)
            .with_instruction(
                "glue the needles into the cover; they stop on the channels' edges, the bore over \
                 the channel",
            )
            .fixing(&[NEEDLE], &[DISPLAY_COVER], FixingMeans::Glue)
            .source("chosen"),
        step("fill-display", SENSOR, &walls, water)
            .with_instruction(
                "stand the display up, needles down; press liquid in through each needle up to the same \
                 length: the air ahead of it leaves by the vent at the channel's far end",
            )
            .source(
                "II-A: the display shows the liquid of each channel; vents chosen: a channel with one \
                 end cannot be filled through it",
            ),
    ]
}

/// Closes the vents. The tubes are plugged in before, because plugging them in would otherwise push the columns
/// forward.
fn seal_display_step() -> Step {
    bond("seal-display", SENSOR, &[DISPLAY_COVER, DISPLAY_SEAL], CEMENT_CURE)
        .with_instruction(
            "level the columns, cement the strip over the vents: from now on the air ahead of the \
             liquid is a spring",
        )
        .source("II-A: channels closed at their far ends, air in them drives the liquid back")
}
