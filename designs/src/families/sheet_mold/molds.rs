//! The two mold stacks. Bolts through the corners align and close each; every sheet is as thick as
//! what it casts is high.

use fabkit_geometry::{Body, Color, Landmark, Path, Point3, Pose, Profile, Vector3};

use super::channels::{comb_opening, left_channels};
use super::layout::{Layout, marker_centres};
use super::parameters::SheetMold;
use super::sheets::{Sheet, square, square_with_notches, with_bolts, with_holes};
use super::{CHANNEL_MOLD, MARKER_MOLD, SENSOR};
use crate::materials::castable;

const PLYWOOD: Color = [214, 180, 130];
const SEAL: &str =
    "seal the wood with acrylic lacquer before use: bare wood can keep silicone from curing";

fn up(z: f64) -> Pose {
    Pose::translation(0.0, 0.0, z)
}

/// All sheets of both stacks.
pub fn sheets(p: &SheetMold, layout: &Layout) -> Vec<Body> {
    // All sheets of a stack grow alike, and both stacks share their floor.
    let shrinkage = castable(&p.marker_layer.material).map_or(0.0, |m| m.shrinkage);
    let floor_mm = p.molds.floor.mm();
    let channels = left_channels(p);
    let opening = |side_mm: f64| Path::rectangle([0.0; 2], [side_mm; 2], 0.0);
    let sheet = |name, summary, profile, thickness_mm, material| Sheet {
        name,
        summary,
        profile: with_bolts(profile, layout),
        thickness_mm,
        material,
        placements: Vec::new(),
        quantity: 1,
        color: PLYWOOD,
        notes: &[],
        landmarks: Vec::new(),
        shrinkage,
    };
    let channel_material: &str = &p.molds.channel_material;
    let marker_material: &str = &p.molds.marker_material;

    let floor = Sheet {
        placements: vec![
            CHANNEL_MOLD.at(up(layout.bond_z - floor_mm)).lifted(-18.0),
            MARKER_MOLD.at(up(layout.marker_end_z - floor_mm)).lifted(-18.0),
        ],
        quantity: 2,
        notes: &[SEAL],
        ..sheet(
            "mold-floor",
            "closes a stack from below",
            Profile::new(square(p)),
            floor_mm,
            marker_material,
        )
    };
    let comb = Sheet {
        placements: vec![CHANNEL_MOLD.at(up(layout.bond_z))],
        color: super::ACRYLIC_BLUE,
        notes: &[
            "peel the protective film off",
            "silicone creeps under the fingers: trim that film off the channels after casting",
        ],
        ..sheet(
            "mold-channel-comb",
            "its fingers leave the channels in the silicone",
            Profile::new(square_with_notches(p))
                .with_hole(comb_opening(&channels, p.channel_layer.side.mm())),
            p.channels.height.mm(),
            channel_material,
        )
    };
    let channel_frame = Sheet {
        placements: vec![CHANNEL_MOLD.at(up(layout.channel_top_z)).lifted(18.0)],
        color: super::ACRYLIC_BLUE,
        notes: &["silicone is poured in here and scraped off level with the top"],
        ..sheet(
            "mold-channel-frame",
            "frame around the silicone above the channels",
            Profile::new(square(p)).with_hole(opening(p.channel_layer.side.mm())),
            p.channel_layer.roof.mm(),
            channel_material,
        )
    };
    let centres = marker_centres(p);
    let marker_plate = Sheet {
        placements: vec![MARKER_MOLD.at(up(layout.marker_end_z))],
        notes: &[SEAL],
        landmarks: marker_landmarks(&centres),
        ..sheet(
            "mold-marker-plate",
            "its holes shape the markers",
            with_holes(
                Profile::new(square_with_notches(p)),
                &centres,
                p.markers.diameter.mm() / 2.0,
            ),
            p.markers.height.mm(),
            marker_material,
        )
    };
    let marker_frame = Sheet {
        placements: vec![MARKER_MOLD.in_place().lifted(18.0), SENSOR.in_place().lifted(10.0)],
        notes: &[SEAL],
        ..sheet(
            "mold-marker-frame",
            "frame around the marker layer: in its mold, and again in the sensor",
            Profile::new(square(p)).with_hole(opening(p.marker_layer.side.mm())),
            p.marker_layer.thickness.mm(),
            marker_material,
        )
    };
    [floor, comb, channel_frame, marker_plate, marker_frame].map(Sheet::part).to_vec()
}

/// Ends of the markers, in the frame of the sheet that shapes them.
fn marker_landmarks(centres: &[[f64; 2]]) -> Vec<Landmark> {
    let landmark = |(i, [x, y]): (usize, &[f64; 2])| Landmark {
        name: format!("marker {}", i + 1),
        point: Point3::new(*x, *y, 0.0),
        axis: -Vector3::z(),
    };
    centres.iter().enumerate().map(landmark).collect()
}
