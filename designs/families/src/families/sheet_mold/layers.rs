//! What is cast, painted, glued and filled in.

use fabkit_geometry::{
    Body, CUT_OVERLAP_MM, Clarity, Color, Path, Point3, Pose, Shells, Solid, Vector3,
};

use super::bodies::*;
use super::channels::{Channel, Side, area_mm2, left_channels, port_y, turned};
use super::layout::{Layout, channel_count, marker_centres};
use super::parameters::SheetMold;
use crate::assembling::{AssemblyName, Name, SENSOR};

/// How far a marker's cylinder reaches into the layer it stands on, mm.
const JOIN_MM: f64 = 0.5;

const RED: Color = [214, 60, 60];

/// All layers, from the camera to the finger, the display's liquid last.
pub fn layers(p: &SheetMold, layout: &Layout) -> Vec<Body> {
    let channels = left_channels(p);
    let layer = |name: Name, solid, material: &str, color, opacity| {
        name.cast(solid).from(material).colored(color).opaque(opacity)
    };
    let placed = |layer: Body, lift_mm: f64, molds: &[AssemblyName]| {
        let in_molds = molds.iter().map(|mold| mold.in_place());
        let placements = std::iter::once(SENSOR.in_place().lifted(lift_mm)).chain(in_molds);
        layer.placed(placements)
    };
    let marker_layer =
        layer(MARKER_LAYER, marker_layer(p, layout), &p.marker_layer.material, [70, 72, 80], 1.0);
    let is_dyed = p.marker_layer.pigment_share > 0.0;
    let marker_layer = if is_dyed { marker_layer.in_light(Clarity::Opaque) } else { marker_layer };
    let pigment = p.marker_layer.pigment.to_lowercase();
    let says = |word: &str| is_dyed && pigment.contains(word);
    // Of other colours nobody knows how dark they are.
    let is_dark = match (says("black"), says("white")) {
        (true, false) => Some(true),
        (false, true) => Some(false),
        _ => None,
    };
    let marker_layer = marker_layer.shaded(is_dark);
    let paint = layer(
        MARKER_PAINT,
        discs(p, layout.marker_end_z_mm - p.markers.paint.mm(), p.markers.paint.mm()),
        &p.markers.paint_material,
        [245, 245, 240],
        1.0,
    )
    .in_shells(Shells::pieces(marker_centres(p).len()));
    let channel_layer = layer(
        CHANNEL_LAYER,
        channel_layer(p, layout, &channels),
        &p.channel_layer.material,
        [196, 214, 226],
        0.45,
    );
    let mut all = vec![
        placed(paint, 22.0, &[]),
        placed(marker_layer, 30.0, &[MARKER_MOLD]),
        placed(channel_layer, 58.0, &[CHANNEL_MOLD]),
    ];
    for side in Side::BOTH {
        let glue =
            layer(side.glue(), tube_glue(p, layout, side), &p.tubes.glue, [200, 200, 190], 0.8)
                // A sleeve around each tube.
                .with_handles(p.channels.per_side as i32)
                .in_shells(Shells::pieces(p.channels.per_side as usize));
        let liquid =
            layer(side.liquid(), liquid(p, layout, &channels, side), "water, dyed red", RED, 0.9)
                .in_shells(Shells::pieces(channels.len()));
        all.push(placed(glue, 44.0, &[]));
        all.push(placed(liquid, 44.0, &[]));
    }
    let display = layer(DISPLAY_LIQUID, display_liquid(p), "water, dyed red", RED, 0.9);
    let place = SENSOR.at(layout.sensor_from_display).lifted(34.0);
    let shells = Shells::pieces(channel_count(p) as usize);
    all.push(display.placed([place]).in_shells(shells));
    all
}

/// Cylinders under every marker; the same circles as the holes of their mold.
fn discs(p: &SheetMold, bottom_z: f64, height_mm: f64) -> Solid {
    let radius = p.markers.diameter.mm() / 2.0;
    Solid::union(marker_centres(p).into_iter().enumerate().map(|(i, centre)| {
        Solid::extrusion(Path::circle(centre, radius), height_mm)
            .at_z(bottom_z)
            .named(format!("marker {}", i + 1))
    }))
}

fn marker_layer(p: &SheetMold, layout: &Layout) -> Solid {
    let outline = Path::rectangle([0.0; 2], [p.marker_layer.side.mm(); 2], 0.0);
    let plate = Solid::extrusion(outline, p.marker_layer.thickness.mm());
    let markers = discs(p, layout.marker_end_z_mm, p.markers.height.mm() + JOIN_MM);
    match markers {
        Solid::Union(markers) => Solid::union([vec![plate], markers].concat()),
        one => plate.plus(one),
    }
}

fn channel_layer(p: &SheetMold, layout: &Layout, channels: &[Channel]) -> Solid {
    let side = p.channel_layer.side.mm();
    let outline = Path::rectangle([0.0; 2], [side; 2], 0.0);
    let block =
        Solid::extrusion(outline, layout.touch_z_mm - layout.bond_z_mm).at_z(layout.bond_z_mm);
    let root_x = -side / 2.0 - CUT_OVERLAP_MM;
    let grooves = Side::BOTH.into_iter().flat_map(|entrance| {
        channels.iter().enumerate().map(move |(k, channel)| {
            let outline = turned(channel.outline(root_x), entrance).close();
            Solid::extrusion(outline, p.channels.height.mm() + CUT_OVERLAP_MM)
                .at_z(layout.bond_z_mm - CUT_OVERLAP_MM)
                .named(format!("channel {} {}", entrance.word(), k + 1))
        })
    });
    block.minus_all(grooves)
}

/// The water behind the tubes' ends.
fn liquid(p: &SheetMold, layout: &Layout, channels: &[Channel], side: Side) -> Solid {
    Solid::union(
        channel_liquids(p, layout, channels, side)
            .into_iter()
            .map(|(name, solid)| solid.named(format!("channel {name}"))),
    )
}

/// The water of each channel of one side, by the channel's name.
pub fn channel_liquids(
    p: &SheetMold,
    layout: &Layout,
    channels: &[Channel],
    side: Side,
) -> Vec<(String, Solid)> {
    let root_x = p.tubes.insertion.mm() - p.channel_layer.side.mm() / 2.0;
    let water = |(k, channel): (usize, &Channel)| {
        let outline = turned(channel.outline(root_x), side).close();
        let solid = Solid::extrusion(outline, p.channels.height.mm()).at_z(layout.bond_z_mm);
        (format!("{} {}", side.word(), k + 1), solid)
    };
    channels.iter().enumerate().map(water).collect()
}

/// Liquid in the channels of one side, behind the tubes' ends.
pub fn side_volume_mm3(p: &SheetMold) -> f64 {
    let root_x = p.tubes.insertion.mm() - p.channel_layer.side.mm() / 2.0;
    let areas = left_channels(p).into_iter().map(|c| area_mm2(&c.outline(root_x).close()));
    p.channels.height.mm() * areas.sum::<f64>()
}

/// Bore of one tube.
pub fn tube_volume_mm3(p: &SheetMold) -> f64 {
    std::f64::consts::PI * (p.tubes.inner_diameter.mm() / 2.0).powi(2) * p.tubes.length.mm()
}

/// Where the tubes of one side begin: origin at the end of the tube in its channel, z axis out.
pub fn tube_poses(p: &SheetMold, layout: &Layout, side: Side) -> Vec<Pose> {
    let x = p.tubes.insertion.mm() - p.channel_layer.side.mm() / 2.0;
    let z = layout.bond_z_mm + p.channels.height.mm() / 2.0;
    (0..p.channels.per_side)
        .map(|k| {
            let [x, y] = side.turn([x, port_y(p, k)]);
            Pose::z_to(Vector3::new(side.sign(), 0.0, 0.0), Point3::new(x, y, z))
        })
        .collect()
}

fn tube_glue(p: &SheetMold, layout: &Layout, side: Side) -> Solid {
    let (width, height, length) =
        (p.channels.width.mm(), p.channels.height.mm(), p.tubes.insertion.mm());
    let tube = Solid::cylinder(p.tubes.outer_diameter.mm() / 2.0, length + 2.0 * CUT_OVERLAP_MM)
        .at_z(-CUT_OVERLAP_MM);
    let sleeves = tube_poses(p, layout, side).into_iter().enumerate().map(|(k, pose)| {
        let outer = side.sign() * p.channel_layer.side.mm() / 2.0;
        let end = pose.point(Point3::origin());
        let (low, high) = (outer.min(end.x), outer.max(end.x));
        let bottom = layout.bond_z_mm;
        Solid::cuboid_between(
            [low, end.y - width / 2.0, bottom],
            [high, end.y + width / 2.0, bottom + height],
        )
        .minus(tube.clone().placed(pose))
        .named(format!("sleeve {} {}", side.word(), k + 1))
    });
    Solid::union(sleeves)
}

/// Where the display's channels lie, in its frame: y of each.
pub fn display_channel_y(p: &SheetMold) -> Vec<f64> {
    let n = channel_count(p);
    (0..n).map(|k| (f64::from(k) - (f64::from(n) - 1.0) / 2.0) * p.display.pitch.mm()).collect()
}

/// Centre of the round end at which a display channel is filled; the other is its mirror image.
pub fn display_inlet(p: &SheetMold, y: f64) -> [f64; 2] {
    [(p.display.channel_length.mm() - p.display.channel_width.mm()) / 2.0, y]
}

/// Where the liquid in the display ends at rest, x in the display's frame.
pub fn rest_x(p: &SheetMold) -> f64 {
    p.display.channel_length.mm() / 2.0 - p.display.rest_length.mm()
}

fn display_liquid(p: &SheetMold) -> Solid {
    let (radius, sheet) = (p.display.channel_width.mm() / 2.0, p.display.sheet.mm());
    let rest = rest_x(p);
    Solid::union(display_channel_y(p).into_iter().enumerate().map(|(k, y)| {
        let inlet = display_inlet(p, y);
        let outline = Path::from([rest, y - radius])
            .line([inlet[0], y - radius])
            .arc([inlet[0], y + radius], inlet, true)
            .line([rest, y + radius])
            .close();
        Solid::extrusion(outline, sheet).at_z(sheet).named(format!("channel {}", k + 1))
    }))
}
