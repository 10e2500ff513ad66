//! Printed negatives of the silicone molds, and what negatives and molds share.
//!
//! Everything stands in the sensor frame: molds close at z = 0, the plane of the elastomers' feet.

use fabkit_geometry::{Body, CUT_OVERLAP_MM, Path, Pose, Process, Solid};

use super::bodies::*;
use super::layout::Layout;
use super::markers;
use super::parameters::HalfEllipsoid;
use super::runner;
use crate::assembling::{AssemblyName, Name, flipped, shrinkage};
use crate::blocks::cup_and_bridge::bowl;
use crate::blocks::{TOOL_GREY, copies, marks, ring};
use crate::fits::Fit;
use crate::materials::Castable;

/// Height of the lip that centres the sleeve, and how far the core's negative rises above the
/// silicone, mm.
const LIP_MM: f64 = 2.0;

/// How far pins that leave vents stand out of the silicone, mm.
const PIN_SPARE_MM: f64 = 1.0;

/// Which boundary a silicone mold gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boundary {
    /// Outside of the inner elastomer.
    Inner,
    /// Outside of the outer elastomer.
    Outer,
    /// Outside of the black gel.
    Black,
}

impl Boundary {
    /// From the inside out; without markers there is no outer elastomer.
    pub fn all(p: &HalfEllipsoid) -> Vec<Self> {
        match p.markers.is_plain() {
            true => vec![Self::Inner, Self::Black],
            false => vec![Self::Inner, Self::Outer, Self::Black],
        }
    }

    /// Layer, silicone mold and the mold's printed negative.
    fn bodies(self) -> [Name; 3] {
        match self {
            Self::Inner => [INNER, INNER_CUP, INNER_NEGATIVE],
            Self::Outer => [OUTER, OUTER_CUP, OUTER_NEGATIVE],
            Self::Black => [BLACK, BLACK_CUP, BLACK_NEGATIVE],
        }
    }

    /// The layer that it bounds.
    pub fn layer(self) -> Name {
        self.bodies()[0]
    }

    /// The silicone mold.
    pub fn cup(self) -> Name {
        self.bodies()[1]
    }

    /// The printed negative of that mold.
    pub fn negative(self) -> Name {
        self.bodies()[2]
    }

    /// Where the silicone mold is cast.
    pub fn casting(self) -> AssemblyName {
        match self {
            Self::Inner => CAST_INNER_CUP,
            Self::Outer => CAST_OUTER_CUP,
            Self::Black => CAST_BLACK_CUP,
        }
    }

    /// Where the layer is cast.
    pub fn mold(self) -> AssemblyName {
        match self {
            Self::Inner => INNER_MOLD,
            Self::Outer => OUTER_MOLD,
            Self::Black => BLACK_MOLD,
        }
    }
}

/// Cones on the core that fit the cups' sockets, reaching into the core's flange.
pub fn keys(p: &HalfEllipsoid, layout: &Layout) -> Vec<Solid> {
    let (radius, height) = (p.tooling.key_diameter.mm() / 2.0, p.tooling.key_height.mm());
    // Drawn in at 20 degrees, so that it finds its socket and comes out of it.
    let slope = 20f64.to_radians().tan();
    let key = Solid::revolution(Path::polygon(&[
        [0.0, -CUT_OVERLAP_MM],
        [radius + CUT_OVERLAP_MM * slope, -CUT_OVERLAP_MM],
        [radius - height * slope, height],
        [0.0, height],
    ]));
    let first = Pose::translation(key_circle_mm(layout), 0.0, 0.0);
    copies("key", &ring(p.tooling.keys, 0.0, first), &key)
}

/// Radius of the circle of the keys, mm: midway between surface and side.
pub fn key_circle_mm(layout: &Layout) -> f64 {
    (layout.foot_of(layout.black_offset_mm) + layout.silicone_radius_mm) / 2.0
}

/// How much a vent narrows on its way out, mm of radius per mm: its pin is thickest where it stands, the
/// core slips off it, and what has cured in a vent comes out of it with the elastomer.
const VENT_DRAFT: f64 = 0.02;

/// Radius of the circle of vents, mm: over the middle of the inner elastomer's foot.
pub fn vent_circle_mm(layout: &Layout) -> f64 {
    (layout.foot_of(layout.shell_offset_mm) + layout.foot_of(layout.inner_offset_mm)) / 2.0
}

/// Where the vents meet the foot, z axis up.
pub fn vent_poses(p: &HalfEllipsoid, layout: &Layout) -> Vec<Pose> {
    ring(p.tooling.vents, 0.0, Pose::translation(vent_circle_mm(layout), 0.0, 0.0))
}

/// Radius of a vent so far below the foot, mm.
pub fn vent_radius_at(p: &HalfEllipsoid, depth_mm: f64) -> f64 {
    p.tooling.vent_diameter.mm() / 2.0 - VENT_DRAFT * depth_mm
}

/// The vents through the core's flange, `beyond_mm` longer on the far side.
fn vents(p: &HalfEllipsoid, layout: &Layout, beyond_mm: f64) -> Vec<Solid> {
    let depth = beyond_mm - layout.core_flange_z_mm;
    let [far, near] = [depth, -CUT_OVERLAP_MM].map(|depth| vent_radius_at(p, depth));
    let pin = Solid::cone(far, near, depth + CUT_OVERLAP_MM).at_z(-depth);
    copies("vent", &vent_poses(p, layout), &pin)
}

/// Vents, gates and sprue: what the core's flange has less, and its negative more, `beyond_mm` longer on
/// the far side.
pub fn ways_out(p: &HalfEllipsoid, layout: &Layout, beyond_mm: f64) -> Vec<Solid> {
    [vents(p, layout, beyond_mm), runner::tools(p, layout, beyond_mm)].concat()
}

/// The vent at the tip of the mold for the outer elastomer, from within the cavity to above the
/// silicone.
pub fn tip_vent(p: &HalfEllipsoid, layout: &Layout) -> Solid {
    let bottom = layout.ellipsoid.polar + layout.inner_offset_mm;
    let top = layout.silicone_top_z_mm + PIN_SPARE_MM;
    Solid::rod(p.tooling.tip_vent_diameter.mm() / 2.0, [bottom, top]).named("tip vent")
}

/// All negatives and the sleeve.
pub fn parts(p: &HalfEllipsoid, layout: &Layout) -> Vec<Body> {
    let mut parts: Vec<Body> =
        Boundary::all(p).iter().map(|&boundary| negative_of_cup(p, layout, boundary)).collect();
    parts.extend([negative_of_core(p, layout), sleeve(p, layout)]);
    parts
}

fn tool(p: &HalfEllipsoid, name: Name, solid: Solid) -> Body {
    name.made(Process::Sla, solid)
        .from(&p.tooling.resin)
        .colored(TOOL_GREY)
        .sealed("varnish")
        .note(
            "0.025 mm layers; wash twice, cure fully and bake at 60 C overnight: uncured resin \
             keeps the silicone from curing",
        )
        .note("a coat of clear acrylic varnish, then release agent")
}

/// What silicone mold and elastomer shrink together, for a negative whose silicone casts `layer`.
fn double_shrinkage(p: &HalfEllipsoid, layer: &Castable) -> f64 {
    1.0 - (1.0 - shrinkage(&p.tooling.silicone_material)) * (1.0 - shrinkage(layer))
}

/// The dome on a plate that a silicone cup is cast around.
fn negative_of_cup(p: &HalfEllipsoid, layout: &Layout, boundary: Boundary) -> Body {
    let (radius, wall) = (layout.silicone_radius_mm, p.tooling.wall.mm());
    let lip = radius + wall + p.making.gap_mm(boundary.negative(), Process::Sla, Fit::Slide);
    let plate = bowl([lip, lip + wall], LIP_MM, [0.0, -wall]);
    let on_plate = |solid: Solid| solid.minus(Solid::below(-CUT_OVERLAP_MM));
    let (dome, material) = match boundary {
        Boundary::Inner => (on_plate(markers::slotted(p, layout)), &p.inner_elastomer.material),
        Boundary::Outer => {
            (layout.ellipsoid.dome_tool(layout.outer_offset_mm), &p.outer_elastomer.material)
        }
        Boundary::Black => {
            (layout.ellipsoid.dome_tool(layout.black_offset_mm), &p.black_gel.material)
        }
    };
    let pin = (boundary == Boundary::Outer).then(|| tip_vent(p, layout));
    let pieces = [plate, dome.named("dome")].into_iter().chain(keys(p, layout)).chain(pin);
    let landmarks = match boundary {
        Boundary::Inner => marks("marker", &markers::poses(p, layout)),
        _ => Vec::new(),
    };
    tool(p, boundary.negative(), Solid::union(pieces))
        .placed([boundary.casting().in_place()])
        .marked(landmarks)
        .for_shrinkage(double_shrinkage(p, material))
}

/// The vessel that the silicone core is cast in.
fn negative_of_core(p: &HalfEllipsoid, layout: &Layout) -> Body {
    let (radius, wall) = (layout.silicone_radius_mm, p.tooling.wall.mm());
    let mouth = layout.core_flange_z_mm - LIP_MM;
    let top = layout.ellipsoid.polar + layout.shell_offset_mm + wall;
    let vessel = Solid::rod(radius + wall, [mouth, top]);
    let recess = Solid::cylinder(radius, CUT_OVERLAP_MM - mouth)
        .at_z(mouth - CUT_OVERLAP_MM)
        .named("flange");
    let body = vessel
        .minus(recess)
        .minus(layout.ellipsoid.dome_tool(layout.shell_offset_mm).named("core"))
        .minus_all(keys(p, layout));
    tool(
        p,
        CORE_NEGATIVE,
        Solid::union(std::iter::once(body).chain(ways_out(p, layout, PIN_SPARE_MM))),
    )
    .placed([CAST_CORE.in_place().lifted(45.0)])
    .lying(flipped())
    .for_shrinkage(double_shrinkage(p, &p.inner_elastomer.material))
}

/// The wall around the negatives of the cups.
fn sleeve(p: &HalfEllipsoid, layout: &Layout) -> Body {
    let inner = layout.silicone_radius_mm;
    let outer = inner + p.tooling.wall.mm();
    let top = layout.silicone_top_z_mm;
    let outline = [[inner, 0.0], [outer, 0.0], [outer, top], [inner, top]];
    tool(p, SLEEVE, Solid::revolution(Path::polygon(&outline)))
        .placed(
            Boundary::all(p)
                .into_iter()
                .map(|boundary| boundary.casting().in_place().lifted(110.0)),
        )
        .with_handles(1)
        .note("push the cured silicone out with two thumbs")
}
