//! Plate, layers cast on it, and the tools that cast them.

use fabkit_geometry::{Body, CUT_OVERLAP_MM, Color, Process};

use super::FlatGelLayout;
use super::parameters::*;
use crate::blocks::GLASS;
use crate::blocks::frame_mold::{FLOOR, Frames};
use crate::chain_builder::{AssemblyName, in_sensor, shrinkage};
use crate::fits::Fit;
use crate::materials::{is_dark, window_transparency};

/// Assemblies in which the gel lies on the molds' floor.
fn mold_assemblies(p: &FlatGel) -> &'static [AssemblyName] {
    match p.coat.by {
        CoatBy::Pour => &[GEL_MOLD, COAT_MOLD],
        CoatBy::Spray => &[GEL_MOLD],
    }
}

/// Returns the open molds of gel and coat.
pub fn frames<'a>(p: &'a FlatGel, layout: &FlatGelLayout) -> Frames<'a> {
    // All frames share one outline and one pair of dowel holes, so the larger of their gaps applies.
    let framed = [GEL_FRAME, COAT_FRAME].map(|frame| (frame, Process::Sla));
    Frames {
        mold: &p.mold,
        cavity: layout.pad.half,
        lowest_mm: layout.gel_top_z_mm,
        shrinkage: shrinkage(&p.pad.material),
        press_mm: p.making.gap_mm(FLOOR, Process::Sla, Fit::Press),
        slide_mm: p.making.widest_gap_mm(framed, Fit::Slide),
    }
}

/// Returns the clear plate.
pub fn plate(p: &FlatGel, layout: &FlatGelLayout) -> Body {
    let solid = layout.plate.prism([layout.plate_bottom_z_mm, layout.plate_top_z_mm]);
    PLATE
        .made(Process::Laser, solid)
        .with_material(&p.plate.material)
        .placed([in_sensor().lifted(14.0)])
        .colored(GLASS)
        .opaque(0.5)
        .as_window(window_transparency(&p.plate.material))
        .note("leave the protective film on until it is glued")
}

/// Returns floor, frames and dowels, and the stencil if there are markers.
pub fn tools(p: &FlatGel, layout: &FlatGelLayout) -> Vec<Body> {
    let frames = frames(p, layout);
    let gel = frames.frame(GEL_FRAME, layout.gel.path(), layout.gel_top_z_mm, GEL_MOLD);
    let coat = (p.coat.by == CoatBy::Pour)
        .then(|| frames.frame(COAT_FRAME, layout.pad.path(), layout.top_z_mm, COAT_MOLD));
    let stencil = p.markers.stencil(layout.gel, layout.gel_top_z_mm);
    let stencil = stencil.map(|body| body.placed([MARKING.in_place().lifted(8.0)]));
    [frames.floor(mold_assemblies(p)), gel, frames.dowels(mold_assemblies(p))]
        .into_iter()
        .chain(coat)
        .chain(stencil)
        .collect()
}

/// Colour in which a coat is drawn: light unless it is known to be dark.
fn coat_color(material: &str) -> Color {
    if is_dark(material) == Some(true) { [60, 60, 66] } else { [205, 207, 212] }
}

/// Returns the layers from the plate outwards: bed, gel, markers, coat.
pub fn layers(p: &FlatGel, layout: &FlatGelLayout) -> Vec<Body> {
    let over = CUT_OVERLAP_MM;
    let marking = p.markers.has_dots().then(|| MARKING.in_place());
    let coating = (p.coat.by == CoatBy::Pour).then(|| COAT_MOLD.in_place());

    // The bed fills the gap around the plate too, so the plate's outline is cut from it.
    let plate = layout.plate.prism([layout.plate_bottom_z_mm - over, layout.plate_top_z_mm]);
    let bed = layout.opening.prism([layout.plate_bottom_z_mm, 0.0]).minus(plate);
    let bed = BED
        .cast(bed)
        .with_material(&p.bed.material)
        .placed([in_sensor().lifted(26.0)])
        .colored([190, 215, 235])
        .opaque(0.8);
    let gel = GEL
        .cast(layout.gel.prism([0.0, layout.gel_top_z_mm]))
        .with_material(&p.pad.material)
        .placed([in_sensor().lifted(36.0)])
        .placed(mold_assemblies(p).iter().map(|name| name.in_place()))
        .placed(marking.clone())
        .colored([225, 228, 232])
        .opaque(0.85);
    let ink = p
        .markers
        .ink(layout.gel_top_z_mm)
        .map(|ink| ink.placed([in_sensor().lifted(40.0)]).placed(marking).placed(coating.clone()));
    let coat = layout
        .pad
        .prism([0.0, layout.top_z_mm])
        // The coat covers the gel's sides and top, and the ink's print.
        .minus(layout.gel.prism([-over, layout.gel_top_z_mm]))
        .minus_all(p.markers.tools(layout.gel_top_z_mm));
    let coat = COAT
        .cast(coat)
        .with_material(&p.coat.material)
        .placed([in_sensor().lifted(64.0)])
        .placed(coating)
        .colored(coat_color(&p.coat.material));
    let bed = (p.bed.thickness.mm() > 0.0).then_some(bed);
    bed.into_iter().chain([gel]).chain(ink).chain([coat]).collect()
}
