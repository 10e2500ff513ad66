//! The display: three sheets with straight channels between them, a strip that closes their vents, and
//! a plate on spacers that holds the second camera above.

use fabkit_geometry::{
    Body, Color, Column, Landmark, Lighting, NominalCamera, Path, Point3, Pose, Process, Profile,
    Shows, Vector3,
};

use super::bodies::*;
use super::joints::Joints;
use super::layers::{display_channel_y, display_inlet, rest_x};
use super::layout::{Layout, bolt_hole_mm};
use super::parameters::SheetMold;
use super::sheets::{sheet, with_holes};
use crate::assembling::{SENSOR, flipped};
use crate::blocks::BLACK;
use crate::fits::Fit;

const CLEAR: Color = [214, 228, 234];
const WHITE: Color = [246, 246, 242];

/// Radius of the display's corners, mm.
const CORNER_MM: f64 = 4.0;

/// Radius of the holes that the needles are glued into.
pub fn needle_hole_mm(p: &SheetMold) -> f64 {
    p.tubes.needle_outer_diameter.mm() / 2.0
        + p.making.gap_mm(DISPLAY_COVER, Process::Laser, Fit::Snug)
}

/// Largest radius of a vent at a channel's far end, mm: air passes, and a film of cement closes it.
const VENT_MM: f64 = 0.6;

/// How far the strip that closes the vents reaches beside their middles, along the channels, mm.
const SEAL_HALF_MM: f64 = 3.0;

/// How far that strip reaches beyond the outermost vents, mm.
const SEAL_BEYOND_MM: f64 = 2.0;

/// Radius of the vents, mm: they open over their channels alone.
fn vent_mm(p: &SheetMold) -> f64 {
    (p.display.channel_width.mm() / 2.0 - 0.1).min(VENT_MM)
}

/// Where the vents are, x in the display's frame: so far from the channels' ends that the strip stays
/// beside the spacers.
pub fn vent_x(p: &SheetMold) -> f64 {
    let [inlet, _] = display_inlet(p, 0.0);
    SEAL_HALF_MM - inlet
}

/// Where the strip over the vents ends towards the liquid, x in the display's frame.
pub fn seal_end_x(p: &SheetMold) -> f64 {
    vent_x(p) + SEAL_HALF_MM
}

/// Air that is shut in ahead of one column of liquid at rest, mm3: in its channel, and in the vent below the strip.
pub fn shut_in_air_mm3(p: &SheetMold) -> f64 {
    let ([inlet, _], rest) = (display_inlet(p, 0.0), rest_x(p));
    let radius = p.display.channel_width.mm() / 2.0;
    let ahead = Path::from([rest, radius])
        .line([-inlet, radius])
        .arc([-inlet, -radius], [-inlet, 0.0], true)
        .line([rest, -radius])
        .close();
    let vent = Path::circle([0.0; 2], vent_mm(p));
    p.display.sheet.mm() * (ahead.signed_area_mm2().abs() + vent.signed_area_mm2())
}

/// The strip that is cemented over the vents, its middle on the axis.
fn seal(p: &SheetMold) -> Profile {
    let last = display_channel_y(p).into_iter().fold(0.0, f64::max);
    let half = last + vent_mm(p) + SEAL_BEYOND_MM;
    Profile::new(Path::rectangle([0.0; 2], [2.0 * SEAL_HALF_MM, 2.0 * half], 0.0))
}

/// The columns as the second camera sees them.
pub fn lighting(p: &SheetMold, layout: &Layout) -> Lighting {
    let column = |y: f64| Column {
        end: layout.sensor_from_display.point(Point3::new(
            rest_x(p),
            y,
            2.0 * p.display.sheet.mm(),
        )),
        way: layout.sensor_from_display.vector(-Vector3::x()),
        width_mm: p.display.channel_width.mm(),
    };
    let columns = display_channel_y(p).into_iter().map(column).collect();
    let size = [p.camera.width_px, p.camera.height_px];
    let view = (p.camera.field_of_view, p.camera.projection);
    let camera = p.camera.optics.camera_at(0.0, size, view);
    // Above the display, looking down.
    let above = Pose::translation(0.0, 0.0, layout.display_pupil_z_mm).then_in(flipped());
    Lighting {
        name: "display",
        lamps: Vec::new(),
        shows: Shows::Columns { liquid: DISPLAY_LIQUID.into(), columns },
        camera: Some(NominalCamera {
            sensor_from_camera: layout.sensor_from_display.then_in(above),
            ..camera
        }),
    }
}

/// The display's sheets, from below, and the camera's plate.
pub fn sheets(p: &SheetMold, layout: &Layout) -> Vec<Body> {
    let plate = |name| {
        let outline = Path::rectangle([0.0; 2], layout.display_size_mm, CORNER_MM);
        with_holes(Profile::new(outline), &layout.display_bolts(p), bolt_hole_mm(p, name))
    };
    let place = |z: f64, lift_mm: f64| {
        let in_display = Pose::translation(0.0, 0.0, z);
        [SENSOR.at(layout.sensor_from_display.then_in(in_display)).lifted(lift_mm)]
    };
    let t = p.display.sheet.mm();
    let inlets: Vec<[f64; 2]> =
        display_channel_y(p).into_iter().map(|y| display_inlet(p, y)).collect();
    let vents: Vec<[f64; 2]> = display_channel_y(p).into_iter().map(|y| [vent_x(p), y]).collect();
    let channels = inlets.iter().fold(plate(DISPLAY_CHANNELS), |profile, &[x, y]| {
        profile.with_hole(Path::slot([-x, y], [x, y], p.display.channel_width.mm() / 2.0))
    });
    let over_vents = layout.sensor_from_display.then_in(Pose::translation(vent_x(p), 0.0, 3.0 * t));
    vec![
        sheet(DISPLAY_BACK, plate(DISPLAY_BACK), t, &p.display.back_material)
            .placed(place(0.0, 0.0))
            .colored(WHITE),
        sheet(DISPLAY_CHANNELS, channels, t, &p.display.clear_material)
            .placed(place(t, 10.0))
            .marked(rest_landmarks(p))
            .colored(CLEAR),
        sheet(
            DISPLAY_COVER,
            with_holes(
                with_holes(plate(DISPLAY_COVER), &inlets, needle_hole_mm(p)),
                &vents,
                vent_mm(p),
            ),
            t,
            &p.display.clear_material,
        )
        .placed(place(2.0 * t, 28.0))
        .colored(CLEAR),
        sheet(DISPLAY_SEAL, seal(p), t, &p.display.clear_material)
            .placed([SENSOR.at(over_vents).lifted(46.0)])
            .colored(CLEAR),
        sheet(
            STAND_PLATE,
            Joints::new(p, layout).camera.pierced(plate(STAND_PLATE)),
            p.housing.sheet.mm(),
            &p.housing.material,
        )
        .placed(place(layout.stand_z_mm, 96.0))
        .colored(BLACK),
    ]
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
