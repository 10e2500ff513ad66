//! The printed tip (skin with pins, dots, ring) and what fills and closes it.
//!
//! The three printed bodies leave the printer as one piece. They are built from the same numbers
//! wherever they meet, so that their meshes share the vertices of the common faces.

use fabkit_geometry::{
    Body, Carrier, Color, Landmark, Mark, Path, Point3, Pose, Process, Profile, Shells, Solid,
    Vector3,
};

use super::bodies::*;
use super::layout::Layout;
use super::parameters::PinTip;
use crate::assembling::{Name, flipped, in_sensor};
use crate::blocks::{GLASS, copies};
use crate::materials::glazing;

const SKIN_BLACK: Color = [70, 72, 78];
const VERO_WHITE: Color = [244, 244, 240];
const GEL_BLUE: Color = [170, 210, 235];

/// How far a pin reaches into the skin, as a share of the skin's thickness.
const PIN_ROOT_SHARE: f64 = 0.5;

/// Depth of a pin's root in the skin, mm.
pub fn pin_root_mm(p: &PinTip) -> f64 {
    PIN_ROOT_SHARE * p.skin.thickness.mm()
}

/// Where the pins stand; `check` has refused layouts without any.
fn pins(p: &PinTip, layout: &Layout) -> Vec<Pose> {
    layout.pin_poses(p).unwrap_or_default()
}

/// A cylinder as thick as the pins at each of their places, between two heights above the skin's
/// inside (positive into the tip).
fn columns(p: &PinTip, layout: &Layout, word: &str, from_mm: f64, to_mm: f64) -> Vec<Solid> {
    let column = Solid::cylinder(layout.pin_diameter_mm / 2.0, to_mm - from_mm).at_z(-to_mm);
    copies(word, &pins(p, layout), &column)
}

/// Skin and pins, dots, ring.
pub fn printed(p: &PinTip, layout: &Layout) -> [Body; 3] {
    let part = |name: Name, solid: Solid, lift_mm: f64| {
        name.made(Process::PolyJet, solid)
            .from(&p.tip.rigid_material)
            .placed([in_sensor().lifted(lift_mm), FILLING.at(flipped()).lifted(-lift_mm)])
            .colored(VERO_WHITE)
            .note(
                "one piece with the other bodies of the group `tip`: load their common 3MF, or \
                 their STL files as one assembly; they share their coordinates",
            )
            .note("wash the support out from below with water, between the pins last and gently")
    };
    let (from, to) = (p.pins.length.mm(), p.pins.length.mm() + p.pins.dot_thickness.mm());
    let dots = Solid::union(columns(p, layout, "dot", from, to));
    [
        part(SKIN, skin(p, layout), 84.0)
            .from(p.tip.soft_material.clone())
            .giving_way()
            .colored(SKIN_BLACK),
        part(DOTS, dots, 62.0)
            .marked(dot_landmarks(p, layout))
            // Each dot is a piece of its own, without a hole.
            .in_shells(Shells::pieces(dot_landmarks(p, layout).len())),
        part(RING, ring(layout), 24.0)
            .marked(vec![Landmark {
                name: "mouth".into(),
                point: Point3::new(0.0, 0.0, layout.ring_bottom_z_mm),
                axis: -Vector3::z(),
            }])
            .with_handles(1),
    ]
}

fn skin(p: &PinTip, layout: &Layout) -> Solid {
    let (inner, outer, upstand) =
        (layout.skin_radius_mm, layout.outer_radius_mm, layout.upstand_radius_mm);
    let bowl = Path::from([inner, 0.0])
        .arc([0.0, inner], [0.0, 0.0], true)
        .line([0.0, outer])
        .arc([outer, 0.0], [0.0, 0.0], false)
        .line([outer, layout.skirt_z_mm])
        .line([upstand, layout.skirt_z_mm])
        .line([upstand, 0.0])
        .close();
    let pins = columns(p, layout, "pin", -pin_root_mm(p), p.pins.length.mm());
    Solid::union(std::iter::once(Solid::revolution(bowl).named("skin")).chain(pins))
}

fn ring(layout: &Layout) -> Solid {
    let bore = layout.tip_joint.bore_radius;
    let outline = Path::polygon(&[
        [layout.skin_radius_mm, 0.0],
        [layout.upstand_radius_mm, 0.0],
        [layout.upstand_radius_mm, layout.skirt_z_mm],
        [layout.outer_radius_mm, layout.skirt_z_mm],
        [layout.outer_radius_mm, layout.ring_bottom_z_mm],
        [bore, layout.ring_bottom_z_mm],
        [bore, layout.lens_top_z_mm],
        [layout.ledge_radius_mm, layout.lens_top_z_mm],
        [layout.ledge_radius_mm, layout.slope_bottom_z()],
    ]);
    Solid::revolution(outline).minus_all(layout.tip_joint.female_tools(layout.ring_bottom_z_mm))
}

/// The dots, which the camera follows: pins carry them.
pub fn marks(p: &PinTip, layout: &Layout) -> Vec<Mark> {
    let depth = p.pins.length.mm() + p.pins.dot_thickness.mm();
    let pin = |pose: &Pose| Carrier::Pin { root: pose.point(Point3::origin()) };
    Mark::below("dot", &pins(p, layout), depth, layout.pin_diameter_mm / 2.0, pin)
}

/// The centre of each dot's outer face, and the direction in which the pin points.
fn dot_landmarks(p: &PinTip, layout: &Layout) -> Vec<Landmark> {
    let landmark = |mark: Mark| Landmark { name: mark.name, point: mark.point, axis: mark.axis };
    marks(p, layout).into_iter().map(landmark).collect()
}

/// The gel between skin and lens, around pins and dots.
pub fn gel(p: &PinTip, layout: &Layout) -> Body {
    let inner = layout.skin_radius_mm;
    let core = Path::from([0.0, layout.lens_top_z_mm])
        .line([layout.ledge_radius_mm, layout.lens_top_z_mm])
        .line([layout.ledge_radius_mm, layout.slope_bottom_z()])
        .line([inner, 0.0])
        .arc([0.0, inner], [0.0, 0.0], true)
        .close();
    let end = p.pins.length.mm() + p.pins.dot_thickness.mm();
    GEL.cast(Solid::revolution(core).minus_all(columns(p, layout, "pin", -pin_root_mm(p), end)))
        .from(&p.fill.material)
        .placed([in_sensor().lifted(44.0), FILLING.at(flipped()).lifted(-44.0)])
        .colored(GEL_BLUE)
        .opaque(0.35)
    // Pins make dimples, not holes.
}

/// Centres of the two holes in the lens: gel in at one, air out at the other.
pub fn lens_holes(p: &PinTip) -> [[f64; 2]; 2] {
    let radius = p.lens.hole_radius.mm();
    [[radius, 0.0], [-radius, 0.0]]
}

/// The window.
pub fn lens(p: &PinTip, layout: &Layout) -> Body {
    let hole = p.lens.hole_diameter.mm() / 2.0;
    let outline = lens_holes(p)
        .into_iter()
        .fold(Profile::new(Path::circle([0.0, 0.0], layout.lens_radius_mm)), |profile, centre| {
            profile.with_hole(Path::circle(centre, hole))
        });
    let solid = Solid::extrusion(outline, p.lens.thickness.mm()).at_z(layout.lens_bottom_z_mm);
    LENS.made(Process::Laser, solid)
        .from(&p.lens.material)
        .in_light(glazing(&p.lens.material))
        .placed([in_sensor().lifted(8.0), FILLING.at(flipped()).lifted(-8.0)])
        .colored(GLASS)
        .note("cut with the film on; peel it off before gluing")
        .with_handles(2)
}
