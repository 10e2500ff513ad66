//! The display: three sheets with straight channels between them, and a plate on spacers that holds
//! the second camera above.

use fabkit_geometry::{Body, Landmark, Path, Point3, Pose, Process, Profile, Vector3};

use super::SENSOR;
use super::housing::{BLACK, camera_holes};
use super::layers::{display_channel_y, display_inlet, rest_x};
use super::layout::{Layout, bolt_hole_mm};
use super::parameters::SheetMold;
use super::sheets::{Sheet, with_holes};
use crate::fits::{Fit, gap_mm};
use crate::hardware::Screw;

/// Radius of the display's corners, mm.
const CORNER_MM: f64 = 4.0;

/// Radius of the holes that the needles are glued into.
pub fn needle_hole_mm(p: &SheetMold) -> f64 {
    p.tubes.needle_outer_diameter.mm() / 2.0 + gap_mm(Process::Laser, Fit::Snug)
}

/// The three sheets, from below, and the camera's plate.
pub fn sheets(p: &SheetMold, layout: &Layout) -> Vec<Body> {
    let plate = || {
        let outline = Path::rectangle([0.0; 2], layout.display_size, CORNER_MM);
        with_holes(Profile::new(outline), &layout.display_bolts(p), bolt_hole_mm())
    };
    let sheet = |name, summary, profile, material, z: f64, lift_mm: f64| Sheet {
        name,
        summary,
        profile,
        thickness_mm: p.display.sheet.mm(),
        material,
        placements: vec![
            SENSOR
                .at(layout.sensor_from_display.then_in(Pose::translation(0.0, 0.0, z)))
                .lifted(lift_mm),
        ],
        quantity: 1,
        color: [214, 228, 234],
        notes: &[],
        landmarks: Vec::new(),
        shrinkage: 0.0,
    };
    let t = p.display.sheet.mm();
    let channels = display_channel_y(p).into_iter().fold(plate(), |profile, y| {
        let [x, y] = display_inlet(p, y);
        profile.with_hole(Path::slot([-x, y], [x, y], p.display.channel_width.mm() / 2.0))
    });
    let inlets: Vec<[f64; 2]> =
        display_channel_y(p).into_iter().map(|y| display_inlet(p, y)).collect();

    let back = Sheet {
        color: [246, 246, 242],
        ..sheet(
            "display-back",
            "white sheet behind the channels",
            plate(),
            &p.display.back_material,
            0.0,
            0.0,
        )
    };
    let channels = Sheet {
        landmarks: rest_landmarks(p),
        ..sheet(
            "display-channels",
            "one straight channel for each of the interface's, closed at the far end",
            channels,
            &p.display.clear_material,
            t,
            10.0,
        )
    };
    let cover = sheet(
        "display-cover",
        "closes the channels; the needles stand in its holes",
        with_holes(plate(), &inlets, needle_hole_mm(p)),
        &p.display.clear_material,
        2.0 * t,
        28.0,
    );
    let stand = Sheet {
        thickness_mm: p.housing.sheet.mm(),
        color: BLACK,
        ..sheet(
            "stand-plate",
            "carries the camera that sees the display",
            with_holes(plate(), &camera_holes(p), Screw::M2X12.clearance_hole_mm() / 2.0),
            &p.housing.material,
            layout.stand_z,
            96.0,
        )
    };
    [back, channels, cover, stand].map(Sheet::part).to_vec()
}

/// Where each column of liquid ends at rest, at mid height, in the channel sheet's frame.
fn rest_landmarks(p: &SheetMold) -> Vec<Landmark> {
    let rest = |(k, y): (usize, f64)| Landmark {
        name: format!("rest {}", k + 1),
        point: Point3::new(rest_x(p), y, p.display.sheet.mm() / 2.0),
        axis: -Vector3::x(),
    };
    display_channel_y(p).into_iter().enumerate().map(rest).collect()
}
