//! The resin mold that casts the skin: a block with the cavity, a lid whose boss closes it, and a
//! spacer between both.
//!
//! It stands in the sensor frame with its mouth at z = 0, facing down: in use it is turned over.
//! The gel is poured into the block and degassed, then the lid goes on. Its boss meets the block on
//! a narrow land; what is too much runs over the land into the trough inside the spacer, and out
//! through the notches. The boss is flat and wider than the gel, so that the bolts' play does not
//! matter and no dowels are needed.

use fabkit_geometry::{
    Body, CUT_OVERLAP_MM, Landmark, Path, Point3, Pose, Process, Solid, Vector3,
};

use super::casing::turn;
use super::layout::Layout;
use super::parameters::Cap;
use super::skin::gel;
use super::{MOLD_BLUE, SKIN_MOLD, TOOL_GREY, flipped};
use crate::fits::{Fit, gap_mm};
use crate::hardware::HexNut;
use crate::materials::castable;

/// Where the bolts' heads bear on the lid: z axis out of the lid, downwards.
pub fn bolt_poses(p: &Cap, layout: &Layout) -> Vec<Pose> {
    let radius = p.mold.bolt_circle.mm() / 2.0;
    let down = Pose::z_to(-Vector3::z(), Point3::new(radius, 0.0, layout.lid_z));
    (0..p.mold.bolts).map(|i| Pose::rotation_z(turn(i, p.mold.bolts, 0.0)).then_in(down)).collect()
}

/// Where the nuts bear on the block: z axis up.
pub fn nut_poses(p: &Cap, layout: &Layout) -> Vec<Pose> {
    let out = Pose::translation(p.mold.bolt_circle.mm() / 2.0, 0.0, layout.nut_z);
    (0..p.mold.bolts).map(|i| Pose::rotation_z(turn(i, p.mold.bolts, 0.0)).then_in(out)).collect()
}

/// Radius of the circle on which the vents open, mm: midway between what the camera sees and the
/// gel's edge.
pub fn vent_circle_mm(layout: &Layout) -> f64 {
    (layout.chamber_radius + layout.foot_radius) / 2.0
}

/// Where the vents meet the gel's foot, z axis up.
pub fn vent_poses(p: &Cap, layout: &Layout) -> Vec<Pose> {
    let out = Pose::translation(vent_circle_mm(layout), 0.0, 0.0);
    (0..p.mold.vents).map(|i| Pose::rotation_z(turn(i, p.mold.vents, 0.5)).then_in(out)).collect()
}

fn bolt_holes(p: &Cap, layout: &Layout, diameter_mm: f64) -> Vec<Solid> {
    let depth = p.mold.height.mm() - layout.lid_z + CUT_OVERLAP_MM;
    let hole = Solid::cylinder(diameter_mm / 2.0, depth + CUT_OVERLAP_MM).at(0.0, 0.0, -depth);
    bolt_poses(p, layout)
        .into_iter()
        .enumerate()
        .map(|(i, pose)| hole.clone().placed(pose).named(format!("bolt hole {}", i + 1)))
        .collect()
}

/// Two radial slots at the outside, between bolts, from `bottom_z` upwards. `reach_mm` in from the
/// outside.
fn slots(p: &Cap, layout: &Layout, reach_mm: f64, bottom_z: f64, height: f64) -> [Solid; 2] {
    [0, 1].map(|i| {
        let slot = Solid::cuboid(2.0 * reach_mm, p.mold.pry_width.mm(), height)
            .at(layout.mold_radius, 0.0, bottom_z)
            .turned_z(turn(i * (p.mold.bolts / 2), p.mold.bolts, 0.5));
        slot.named(format!("pry slot {}", i + 1))
    })
}

fn tool(p: &Cap, name: &str, summary: &str, solid: Solid, genus: i32) -> Body {
    Body::made(name, summary, Process::Sla, solid)
        .from(&p.mold.material)
        .placed([SKIN_MOLD.in_place()])
        .colored(TOOL_GREY)
        .note("wash, cure and bake: uncured resin keeps platinum silicone from curing")
        .for_shrinkage(castable(&p.skin.material).map_or(0.0, |m| m.shrinkage))
        .with_handles(genus)
}

/// Block, spacer and lid.
pub fn parts(p: &Cap, layout: &Layout, dimples: &[Pose]) -> [Body; 3] {
    [block(p, layout, dimples), spacer(p, layout), lid(p, layout)]
}

/// The block: everything around the gel, so that each dimple leaves its pin.
fn block(p: &Cap, layout: &Layout, dimples: &[Pose]) -> Body {
    let height = p.mold.height.mm();
    let pocket = HexNut::M3.tool(gap_mm(Process::Sla, Fit::Slide), height - layout.nut_z);
    let nuts = nut_poses(p, layout)
        .into_iter()
        .enumerate()
        .map(|(i, pose)| pocket.clone().placed(pose).named(format!("nut pocket {}", i + 1)));
    let pry_gap = p.mold.pry_gap.mm();
    let solid = Solid::cylinder(layout.mold_radius, height)
        .minus(gel(p, layout, dimples, true))
        .minus_all(bolt_holes(p, layout, p.mold.block_hole.mm()))
        .minus_all(nuts)
        .minus_all(slots(
            p,
            layout,
            p.mold.pry_depth.mm(),
            -CUT_OVERLAP_MM,
            pry_gap + CUT_OVERLAP_MM,
        ));
    let landmarks = dimples.iter().enumerate().map(|(i, pose)| Landmark {
        name: format!("dimple {}", i + 1),
        point: pose.point(Point3::origin()),
        axis: pose.vector(Vector3::z()),
    });
    let mut part = tool(
        p,
        "mold-skin-block",
        "cavity of the skin, with the dimples' pins",
        solid,
        p.mold.bolts as i32,
    );
    part.placements = vec![SKIN_MOLD.in_place().lifted(26.0)];
    part.color = MOLD_BLUE;
    part.landmarks = landmarks.collect();
    part.bed_from_body = flipped();
    part.notes.insert(0, "cavity up, 0.025 mm layers, no supports inside".into());
    part
}

fn spacer(p: &Cap, layout: &Layout) -> Body {
    let (bore, outside) = (layout.spacer_bore, layout.mold_radius);
    let ring = Solid::revolution(Path::polygon(&[
        [bore, layout.flange_z],
        [outside, layout.flange_z],
        [outside, 0.0],
        [bore, 0.0],
    ]));
    // All the way from the trough to the outside, half the spacer deep.
    let reach = outside - bore + 1.0;
    let depth = p.mold.spacer.mm() / 2.0 + CUT_OVERLAP_MM;
    let solid = ring.minus_all(bolt_holes(p, layout, p.mold.lid_hole.mm())).minus_all(slots(
        p,
        layout,
        reach,
        layout.flange_z - CUT_OVERLAP_MM,
        depth,
    ));
    let mut part = tool(
        p,
        "mold-skin-spacer",
        "sets the height of the lid; its notches let surplus out and a screwdriver in",
        solid,
        1 + p.mold.bolts as i32,
    );
    part.bed_from_body = flipped();
    part.notes.push("grind it down, or add film, if the skin comes out too thick or thin".into());
    part.placements = vec![SKIN_MOLD.in_place().lifted(-10.0)];
    part
}

fn lid(p: &Cap, layout: &Layout) -> Body {
    let outline = Path::polygon(&[
        [0.0, layout.lid_z],
        [layout.mold_radius, layout.lid_z],
        [layout.mold_radius, layout.flange_z],
        [layout.boss_radius, layout.flange_z],
        [layout.boss_radius, 0.0],
        [0.0, 0.0],
    ]);
    let depth = -layout.lid_z + CUT_OVERLAP_MM;
    let vent = Solid::cylinder(p.mold.vent_diameter.mm() / 2.0, depth + CUT_OVERLAP_MM)
        .at(0.0, 0.0, -depth);
    let vents = vent_poses(p, layout)
        .into_iter()
        .enumerate()
        .map(|(i, pose)| vent.clone().placed(pose).named(format!("vent {}", i + 1)));
    let mut part = tool(
        p,
        "mold-skin-lid",
        "closes the mold; the skin's flat foot forms on its boss",
        Solid::revolution(outline).minus_all(vents).minus_all(bolt_holes(
            p,
            layout,
            p.mold.lid_hole.mm(),
        )),
        (p.mold.vents + p.mold.bolts) as i32,
    );
    part.placements = vec![SKIN_MOLD.in_place().lifted(-24.0)];
    part.notes.insert(0, "boss up; polish the boss, the camera looks through its print".into());
    part
}
