//! What is cast and printed on: gel, bed, markers, coat, and the tools for them.

use fabkit_geometry::{Body, CUT_OVERLAP_MM, Color, Path, Pose, Process, Profile, Shells, Solid};

use super::layout::Layout;
use super::parameters::{CoatBy, FlatGel};
use super::{COAT_MOLD, GEL_MOLD, MARKING, in_sensor};
use crate::assembling::AssemblyName;
use crate::blocks::frame_mold::Frames;
use crate::blocks::{STEEL, copies, upright};
use crate::materials::castable;

/// Thickness of the film that markers are dabbed through, mm.
const STENCIL_MM: f64 = 0.1;

/// The assemblies in which a floor lies under the gel.
pub fn molds(p: &FlatGel) -> &'static [AssemblyName] {
    match p.coat.by {
        CoatBy::Pour => &[GEL_MOLD, COAT_MOLD],
        CoatBy::Spray => &[GEL_MOLD],
    }
}

/// The open molds.
pub fn frames<'a>(p: &'a FlatGel, layout: &Layout) -> Frames<'a> {
    Frames {
        mold: &p.mold,
        cavity: layout.pad.half,
        lowest_mm: layout.seen_z,
        shrinkage: castable(&p.pad.material).map_or(0.0, |m| m.shrinkage),
    }
}

/// Where the markers are, on the gel, z axis up: row by row from below.
pub fn marker_poses(p: &FlatGel, layout: &Layout) -> Vec<Pose> {
    let [columns, rows] = [p.markers.columns, p.markers.rows];
    let at = |i: u32, of: u32| p.markers.spacing.mm() * (f64::from(i) - f64::from(of - 1) / 2.0);
    (0..rows)
        .flat_map(|row| (0..columns).map(move |column| [at(column, columns), at(row, rows)]))
        .map(|place| upright(place, layout.seen_z))
        .collect()
}

/// Discs on the gel; as tools they go on below it.
fn dots(p: &FlatGel, layout: &Layout, is_tool: bool) -> Vec<Solid> {
    let below = if is_tool { -CUT_OVERLAP_MM } else { 0.0 };
    let dot = Solid::rod(p.markers.diameter.mm() / 2.0, [below, p.markers.thickness.mm()]);
    copies("marker", &marker_poses(p, layout), &dot)
}

/// Floor, frames, and the stencil if there are markers.
pub fn tools(p: &FlatGel, layout: &Layout) -> Vec<Body> {
    let frames = frames(p, layout);
    let floor = frames.floor(molds(p));
    let gel = frames.frame("mold-gel", layout.gel.path(), layout.seen_z, GEL_MOLD);
    let coat = (p.coat.by == CoatBy::Pour)
        .then(|| frames.frame("mold-coat", layout.pad.path(), layout.top_z, COAT_MOLD));
    [floor, gel].into_iter().chain(coat).chain(stencil(p, layout)).collect()
}

fn stencil(p: &FlatGel, layout: &Layout) -> Option<Body> {
    let poses = marker_poses(p, layout);
    let radius = p.markers.diameter.mm() / 2.0;
    let profile = poses.iter().fold(Profile::new(layout.gel.path()), |profile, pose| {
        let at = pose.translation_mm();
        profile.with_hole(Path::circle([at.x, at.y], radius))
    });
    let film = Solid::prism(profile, [layout.seen_z, layout.seen_z + STENCIL_MM]);
    let body =
        Body::made("marker-stencil", "film that ink is dabbed through", Process::Laser, film)
            .from("PET film")
            .placed([MARKING.in_place().lifted(8.0)])
            .colored(STEEL)
            .with_handles(poses.len() as i32);
    (!poses.is_empty()).then_some(body)
}

/// How a coat of that name looks.
fn coat_color(material: &str) -> Color {
    if material.contains("black") { [60, 60, 66] } else { [205, 207, 212] }
}

/// From the plate outwards.
pub fn layers(p: &FlatGel, layout: &Layout) -> Vec<Body> {
    let over = CUT_OVERLAP_MM;
    let markers = marker_poses(p, layout);
    let in_molds = || molds(p).iter().map(|name| name.in_place());
    let marking = (!markers.is_empty()).then(|| MARKING.in_place());

    let bed = layout
        .opening
        .prism([layout.plate_bottom_z, 0.0])
        .minus(layout.plate.prism([layout.plate_bottom_z - over, layout.plate_top_z]));
    let bed = Body::cast("bed", "clear gel on the plate, up to the shell's rim", bed)
        .from(&p.bed.material)
        .placed([in_sensor().lifted(26.0)])
        .colored([190, 215, 235])
        .opaque(0.8);
    let gel = Body::cast("gel", "soft gel under the coat", layout.gel.prism([0.0, layout.seen_z]))
        .from(&p.pad.material)
        .placed([in_sensor().lifted(36.0)])
        .placed(in_molds())
        .placed(marking.clone())
        .colored([225, 228, 232])
        .opaque(0.85);
    let ink = Body::cast("markers", "dots on the gel", Solid::union(dots(p, layout, false)))
        .from(&p.markers.material)
        .placed([in_sensor().lifted(42.0)])
        .placed(marking)
        .placed((p.coat.by == CoatBy::Pour).then(|| COAT_MOLD.in_place()))
        .colored([40, 40, 44])
        .in_shells(Shells::pieces(markers.len()));
    let coat = layout
        .pad
        .prism([0.0, layout.top_z])
        .minus(layout.gel.prism([-over, layout.seen_z]))
        .minus_all(dots(p, layout, true));
    let coat = Body::cast("coat", "opaque coat that touches", coat)
        .from(&p.coat.material)
        .placed([in_sensor().lifted(48.0)])
        .placed((p.coat.by == CoatBy::Pour).then(|| COAT_MOLD.in_place()))
        .colored(coat_color(&p.coat.material));
    let bed = (p.bed.thickness.mm() > 0.0).then_some(bed);
    let ink = (!markers.is_empty()).then_some(ink);
    bed.into_iter().chain([gel]).chain(ink).chain([coat]).collect()
}
