//! Laser-cut sheets: every one is a plain extrusion of one profile, standing on z = 0 of its own
//! frame; placements lift it to where it belongs.

use fabkit_geometry::{Angle, Body, Path, Pose, Process, Profile, Solid};

use super::layout::{Layout, bolt_hole_mm};
use super::parameters::SheetMold;
use crate::assembling::Name;
use crate::hardware::tools::pry;
use crate::materials::glazing;

/// A sheet with this profile; each of its holes is one handle.
pub fn sheet(name: Name, profile: Profile, thickness_mm: f64, material: &str) -> Body {
    let handles = profile.holes.len() as i32;
    name.made(Process::Laser, Solid::extrusion(profile, thickness_mm))
        .from(material)
        .with_handles(handles)
        .in_light(glazing(material))
}

/// The outline that all square plates share.
pub fn square(p: &SheetMold) -> Path {
    Path::rectangle([0.0; 2], [p.plate.side.mm(); 2], corner_mm(p))
}

/// The same outline with a notch at the middle of each side along y, for a screwdriver.
pub fn square_with_notches(p: &SheetMold) -> Path {
    let (half, r) = (p.plate.side.mm() / 2.0, corner_mm(p));
    let (w, depth) = (p.plate.pry_width.mm() / 2.0, p.plate.pry_depth.mm());
    let floor = half - depth;
    Path::from([half - r, -half])
        .arc([half, r - half], [half - r, r - half], true)
        .line([half, half - r])
        .arc([half - r, half], [half - r, half - r], true)
        .line([w, half])
        .line([w, floor])
        .line([-w, floor])
        .line([-w, half])
        .line([r - half, half])
        .arc([-half, half - r], [r - half, half - r], true)
        .line([-half, r - half])
        .arc([r - half, -half], [r - half, r - half], true)
        .line([-w, -half])
        .line([-w, -floor])
        .line([w, -floor])
        .line([w, -half])
        .close()
}

/// A sheet with that outline, and the screwdrivers that part it from its neighbours.
pub fn pried(p: &SheetMold, sheet: Body, thickness_mm: f64) -> Body {
    let turns =
        [-90.0, 90.0].map(|deg| Angle::from_deg(deg).expect("a quarter of a turn is finite"));
    let mouth = Pose::translation(p.plate.side.mm() / 2.0, 0.0, thickness_mm / 2.0);
    turns.into_iter().fold(sheet, |sheet, turn| {
        sheet.reached(pry(Pose::rotation_z(turn).then_in(mouth), p.plate.pry_depth.mm()))
    })
}

/// Radius of the plates' corners, mm: as far from the bolts as the straight sides.
fn corner_mm(p: &SheetMold) -> f64 {
    (p.plate.side.mm() - p.plate.bolt_spacing.mm()) / 2.0
}

/// Adds the four bolt holes of a square plate.
pub fn with_bolts(profile: Profile, p: &SheetMold, layout: &Layout, plate: Name) -> Profile {
    with_holes(profile, &layout.bolts(), bolt_hole_mm(p, plate))
}

/// Adds round holes.
pub fn with_holes(profile: Profile, centres: &[[f64; 2]], radius_mm: f64) -> Profile {
    centres.iter().fold(profile, |p, &centre| p.with_hole(Path::circle(centre, radius_mm)))
}
