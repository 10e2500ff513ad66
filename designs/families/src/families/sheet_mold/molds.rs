//! The two mold stacks. Bolts through the corners align and close each; every sheet is as thick as
//! what it casts is high.

use fabkit_geometry::{Body, Carrier, Color, Landmark, Mark, Path, Point3, Pose, Profile, Vector3};

use super::bodies::*;
use super::channels::{comb_opening, left_channels};
use super::layout::{Layout, marker_centres};
use super::parameters::SheetMold;
use super::sheets::{pried, sheet, square, square_with_notches, with_bolts, with_holes};
use crate::assembling::{SENSOR, shrinkage};
use crate::blocks::MOLD_BLUE;

const PLYWOOD: Color = [214, 180, 130];
const SEAL: &str =
    "seal the wood with acrylic lacquer before use: bare wood can keep silicone from curing";

/// All sheets of both stacks.
pub fn sheets(p: &SheetMold, layout: &Layout) -> Vec<Body> {
    // All sheets of a stack grow alike, and both stacks share their floor.
    let shrinkage = shrinkage(&p.marker_layer.material);
    let floor_mm = p.molds.floor.mm();
    let channels = left_channels(p);
    let opening = |side_mm: f64| Path::rectangle([0.0; 2], [side_mm; 2], 0.0);
    let cut = |name, profile, thickness_mm, material: &str| {
        sheet(name, with_bolts(profile, p, layout, name), thickness_mm, material)
            .sealed("lacquer")
            .colored(PLYWOOD)
            .for_shrinkage(shrinkage)
    };
    let notched = |name, profile, thickness_mm, material: &str| {
        pried(p, cut(name, profile, thickness_mm, material), thickness_mm)
    };
    let (acrylic, wood) = (&p.molds.channel_material, &p.molds.marker_material);
    let centres = marker_centres(p);
    vec![
        cut(MOLD_FLOOR, Profile::new(square(p)), floor_mm, wood)
            .placed([
                CHANNEL_MOLD.at_z(layout.bond_z_mm - floor_mm).lifted(-18.0),
                MARKER_MOLD.at_z(layout.marker_end_z_mm - floor_mm).lifted(-18.0),
            ])
            .times(2)
            .note(SEAL),
        notched(
            CHANNEL_COMB,
            Profile::new(square_with_notches(p))
                .with_hole(comb_opening(&channels, p.channel_layer.side.mm())),
            p.channels.height.mm(),
            acrylic,
        )
        .placed([CHANNEL_MOLD.at_z(layout.bond_z_mm)])
        .colored(MOLD_BLUE)
        .note("peel the protective film off")
        .note("silicone creeps under the fingers: trim that film off the channels after casting"),
        cut(
            CHANNEL_FRAME,
            Profile::new(square(p)).with_hole(opening(p.channel_layer.side.mm())),
            p.channel_layer.roof.mm(),
            acrylic,
        )
        .placed([CHANNEL_MOLD.at_z(layout.channel_top_z_mm).lifted(18.0)])
        .colored(MOLD_BLUE)
        .note("silicone is poured in here and scraped off level with the top"),
        notched(
            MARKER_PLATE,
            with_holes(
                Profile::new(square_with_notches(p)),
                &centres,
                p.markers.diameter.mm() / 2.0,
            ),
            p.markers.height.mm(),
            wood,
        )
        .placed([MARKER_MOLD.at_z(layout.marker_end_z_mm)])
        .marked(marker_landmarks(&centres))
        .note(SEAL),
        cut(
            MARKER_FRAME,
            Profile::new(square(p)).with_hole(opening(p.marker_layer.side.mm())),
            p.marker_layer.thickness.mm(),
            wood,
        )
        .placed([MARKER_MOLD.in_place().lifted(18.0), SENSOR.in_place().lifted(10.0)])
        .note(SEAL),
    ]
}

/// Ends of the markers, paint included, which the camera follows.
pub fn marks(p: &SheetMold, layout: &Layout) -> Vec<Mark> {
    let end_mm = layout.marker_end_z_mm - p.markers.paint.mm();
    let poses = marker_centres(p).into_iter().map(|[x, y]| Pose::translation(x, y, end_mm));
    let radius_mm = p.markers.diameter.mm() / 2.0;
    Mark::below("marker", &poses.collect::<Vec<_>>(), 0.0, radius_mm, |_| Carrier::Gel)
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
