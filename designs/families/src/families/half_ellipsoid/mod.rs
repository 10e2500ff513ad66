//! Half-ellipsoid sensors: elastomers on a machined shell, LEDs and a camera below it (UVDtact).

mod bodies;
mod chain;
mod circuit;
mod components;
mod constraints;
mod housing;
mod joints;
mod layers;
mod layout;
mod markers;
mod parameters;
mod runner;
mod surface;
mod tooling;

use fabkit_geometry::{DomeSurface, EllipsoidOffset, Grip, Lighting, Path, Rgb, Sensor, Shows};

use crate::assembling::sight;
use crate::blocks::Rect;
use crate::blocks::adapter::MountFace;
use crate::blocks::marks::{RoundPattern, nearest_mm};
use crate::blocks::{self, mm};
use crate::parameters::Report;
use crate::{Built, Family, Header};
use joints::Joints;
use layout::Layout;
use parameters::HalfEllipsoid;

/// The family of UVDtact.
pub(crate) struct HalfEllipsoidFamily;

impl Family for HalfEllipsoidFamily {
    type Parameters = HalfEllipsoid;
    const NAME: &'static str = "half-ellipsoid";
    const SUMMARY: &'static str = "half ellipsoids of elastomer on a machined shell, UV markers";
    const EXAMPLE: &'static str = "uvdtact";
    const DEFAULTS: &'static [(&'static str, &'static str)] =
        &[("half-ellipsoid.yaml (defaults)", include_str!("defaults.yaml"))];

    fn check(parameters: &HalfEllipsoid, report: &mut Report) {
        constraints::check(parameters, report);
    }

    fn build(parameters: &HalfEllipsoid, header: &Header, _report: &mut Report) -> Option<Built> {
        let layout = Layout::new(parameters);
        let face = MountFace {
            holder: bodies::BASE,
            mounting: Joints::new(parameters, &layout).mounting,
            borrowed_mm: None,
            bottom_z_mm: layout.bottom_z_mm,
            outline: Rect::round(layout.holder_radius_mm),
            exits: housing::exits(parameters, &layout),
            heads: Vec::new(),
        };
        let sensor = sensor(parameters, header);
        Some(Built { sensor, derived: derived(parameters), face: Some(face) })
    }
}

/// Everything a half-ellipsoid sensor consists of.
fn sensor(p: &HalfEllipsoid, header: &Header) -> Sensor {
    let layout = Layout::new(p);
    let mut parts = housing::parts(p, &layout);
    parts.extend(tooling::parts(p, &layout));
    let pupil_z = layout.camera_front_z_mm - p.camera.pupil_behind_front.mm();
    let bodies = parts
        .into_iter()
        .chain(layers::layers(p, &layout))
        .chain(components::components(p, &layout));
    Sensor {
        chain: chain::chain(p, &layout),
        circuits: vec![circuit::circuit(p, &layout)],
        press_fits: Joints::new(p, &layout).holder.press_fit(bodies::BASE).into_iter().collect(),
        touch: Some(touch(p, &layout).into()),
        marks: markers::marks(p, &layout),
        lightings: lightings(p),
        sight: sight(
            &layers::elastomer_names(p)
                .into_iter()
                .map(|name| match name {
                    bodies::OUTER => (name, &p.outer_elastomer.material),
                    _ => (name, &p.inner_elastomer.material),
                })
                .collect::<Vec<_>>(),
            bodies::BLACK,
        ),
        ..blocks::sensor(
            header,
            p.camera.optics.camera_at(
                pupil_z,
                p.camera.pictures.size_px(),
                (p.camera.field_of_view, p.camera.projection),
            ),
            bodies,
        )
    }
}

/// What is touched, and what fixtures hold on to: holder and base, which are equally wide.
fn touch(p: &HalfEllipsoid, layout: &Layout) -> DomeSurface {
    let gels = [&p.black_gel.thickness, &p.outer_elastomer.thickness, &p.inner_elastomer.thickness];
    DomeSurface {
        dome: EllipsoidOffset {
            equatorial_mm: layout.ellipsoid.equatorial,
            polar_mm: layout.ellipsoid.polar,
            offset_mm: layout.black_offset_mm,
        },
        centre_z_mm: 0.0,
        foot_z_mm: 0.0,
        soft_mm: gels.iter().map(|thickness| thickness.mm()).sum(),
        grip: Grip {
            outline: Path::circle([0.0, 0.0], layout.holder_radius_mm),
            top_z_mm: 0.0,
            bottom_z_mm: layout.bottom_z_mm,
            clear_radius_mm: p.base.mount_radius.mm(),
            key: None,
            threads: Joints::new(p, layout).mounting.held().landmarks,
        },
    }
}

/// What follows from the parameters, for `fabkit show`.
fn derived(p: &HalfEllipsoid) -> Vec<(String, String)> {
    let layout = Layout::new(p);
    let mill = p.shell.ball_mill_diameter.mm() / 2.0;
    let outside = layout.ellipsoid.polar + layout.shell_offset_mm;
    let mut figures = vec![
        mm("outer diameter", 2.0 * layout.foot_of(layout.black_offset_mm)),
        mm("tip above the base circle", layout.ellipsoid.polar + layout.black_offset_mm),
        mm("total height", layout.ellipsoid.polar + layout.black_offset_mm - layout.bottom_z_mm),
        mm("tip's radius of curvature", layout.ellipsoid.tip_curvature_radius()),
        mm("shell bore radius", layout.bore_radius()),
        mm(
            "shell thickness at the tip",
            outside - layout.ellipsoid.cavity_tip_z(layout.cavity_depth_mm, mill),
        ),
        mm("slot depth", markers::depth(&p.markers)),
        mm("LED board radius", layout.board_radius_mm),
        mm("LED board top below the base circle", -layout.board_top_z_mm),
    ];
    if p.markers.pattern == RoundPattern::List {
        let ends = markers::end_centres(p, &layout);
        figures.push(("markers".into(), ends.len().to_string()));
        figures.extend(nearest_mm(&ends).map(|least| mm("nearest round ends", least)));
    } else if let Ok(spread) = markers::spread(&layout, p.markers.count) {
        figures.push(mm("marker spacing along the meridian", spread.spacing));
        figures.push(("markers per ring, from the tip".into(), spread.counts()));
    }
    figures
}

/// What the inks' colours leave on the camera's red, green and blue. Chosen: fluorescent inks glow in bands of 60 to 100 nm.
const INKS: [Rgb; 2] = [[1.0, 0.15, 0.05], [0.05, 0.25, 1.0]];

/// White for shape, ultraviolet for markers: both inks scatter white light alike, and glow in their own colours.
fn lightings(p: &HalfEllipsoid) -> Vec<Lighting> {
    let layers: Vec<String> = layers::elastomer_names(p).into_iter().map(String::from).collect();
    let glowing = layers.iter().cloned().zip(INKS).collect();
    vec![
        Lighting::by("white", bodies::WHITE_LED, Shows::Thickness { layers }),
        Lighting::by("uv", bodies::UV_LED, Shows::Glow { layers: glowing }),
    ]
}
