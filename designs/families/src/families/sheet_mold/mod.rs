//! Sheet-mold sensors: a soft interface with liquid channels over markers, cast between laser-cut
//! sheets, on a box with a camera, with a display that a second camera watches (Soter et al.).

mod bodies;
mod cables;
mod chain;
mod channels;
mod circuit;
mod components;
mod constraints;
mod display;
mod housing;
mod joints;
mod layers;
mod layout;
mod molds;
mod parameters;
mod sheets;
mod skin;

use fabkit_geometry::Sensor;

use crate::assembling::names;
use crate::blocks::lighting::places;
use crate::blocks::{self, mm, press_fit};
use crate::parameters::Report;
use crate::{Built, Family, Header};
use bodies::{NEEDLE, TUBE};
use layout::Layout;
use parameters::SheetMold;

/// The family of the fluidic sensor.
pub(crate) struct SheetMoldFamily;

impl Family for SheetMoldFamily {
    type Parameters = SheetMold;
    const NAME: &'static str = "sheet-mold";
    const SUMMARY: &'static str = "liquid channels over markers, cast between laser-cut sheets";
    const EXAMPLE: &'static str = "fluidic";
    const DEFAULTS: &'static [(&'static str, &'static str)] =
        &[("sheet-mold.yaml (defaults)", include_str!("defaults.yaml"))];

    fn check(parameters: &SheetMold, report: &mut Report) {
        constraints::check(parameters, report);
    }

    fn build(p: &SheetMold, header: &Header, report: &mut Report) -> Option<Built> {
        let layout = Layout::new(p);
        let sensor = sensor(p, &layout, header);
        constraints::check_sheets(p, &sensor, report);
        let derived = derived(p, &layout);
        let face = Some(housing::face(p, &layout));
        report.is_clean().then_some(Built { sensor, derived, face })
    }
}

fn sensor(p: &SheetMold, layout: &Layout, header: &Header) -> Sensor {
    let size = [p.camera.width_px, p.camera.height_px];
    // The camera looks up at the markers.
    let view = (p.camera.field_of_view, p.camera.projection);
    let camera = p.camera.optics.camera_at(layout.pupil_z_mm, size, view);
    let bodies = molds::sheets(p, layout)
        .into_iter()
        .chain(housing::sheets(p, layout))
        .chain(display::sheets(p, layout))
        .chain(layers::layers(p, layout))
        .chain(components::components(p, layout));
    let stretch_mm = (p.tubes.needle_outer_diameter.mm() - p.tubes.inner_diameter.mm()) / 2.0;
    let reason = "the tube is stretched over the needle";
    Sensor {
        chain: chain::chain(p, layout),
        circuits: vec![circuit::circuit(p, layout)],
        liquid: Some(skin::skin(p, layout)),
        marks: molds::marks(p, layout),
        lightings: vec![
            places(bodies::MARKER_PAINT, bodies::LED_STRIP),
            display::lighting(p, layout),
        ],
        contrasts: vec![[bodies::MARKER_PAINT, bodies::MARKER_LAYER].map(String::from)],
        press_fits: vec![press_fit(NEEDLE, TUBE, stretch_mm, reason)],
        sight: names(&[bodies::MARKER_PAINT]),
        ..blocks::sensor(header, camera, bodies)
    }
}

/// What follows from the parameters, for `fabkit show`.
fn derived(p: &SheetMold, layout: &Layout) -> Vec<(String, String)> {
    let display_area_mm2 = p.display.channel_width.mm() * p.display.sheet.mm();
    vec![
        mm("thickness of the interface", layout.touch_z_mm),
        mm("height of the box with the interface", layout.touch_z_mm - layout.bottom_z_mm),
        mm("from the camera's pupil to the markers", layout.marker_end_z_mm - layout.pupil_z_mm),
        mm(
            "from the second pupil to the liquid",
            layout.display_pupil_z_mm - layout.cover_top_mm / 2.0,
        ),
        mm("smallest wall between two channels", constraints::thinnest_wall_mm(p)),
        ("water in the channels".into(), format!("{:.1} mm3", 2.0 * layers::side_volume_mm3(p))),
        ("water in one tube".into(), format!("{:.1} mm3", layers::tube_volume_mm3(p))),
        mm("travel in the display for 10 mm3", 10.0 / display_area_mm2),
        mm("length of the display", layout.display_size_mm[0]),
        mm("width of the display", layout.display_size_mm[1]),
    ]
}
