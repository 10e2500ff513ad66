//! How the contact module is held: gel that goes on from the filling gel through the diffuser, out to the
//! shell, around its ribs and into its groove.
//!
//! It is poured through the shell, tip down, onto the filling gel: so every face that looks down then lets
//! air out, and the groove's upper flank rises inwards.

use fabkit_geometry::{Angle, Body, CUT_OVERLAP_MM, Path, Profile, Solid};

use super::bodies::*;
use super::housing::notched_circle;
use super::layout::Layout;
use super::parameters::Dome;
use crate::assembling::in_sensor;
use crate::blocks::{INTO_MM, turn};

/// How much gel lies between the groove and the diffuser, and between the groove and its own face, mm.
const GROOVE_EDGE_MM: f64 = 0.4;

/// Height of the groove's inmost face, mm.
const GROOVE_MM: f64 = 0.5;

/// How far a rib reaches into the wall, or into the wall behind the groove, that carries it, mm.
const RIB_ROOT_MM: f64 = 0.5;

/// How far a rib's shoulder lies below the diffuser, mm: gel closes the gap around the diffuser above it.
const RIB_STEP_MM: f64 = 0.3;

/// How wide the diffuser rests on a rib at least, mm.
pub const LEDGE_MM: f64 = 0.4;

/// Whether there is any.
pub fn is_locked(p: &Dome) -> bool {
    p.filling_gel.lock_depth.mm() > 0.0
}

/// How deep gel must be for the groove, mm.
pub fn groove_room_mm(p: &Dome) -> f64 {
    2.0 * GROOVE_EDGE_MM + GROOVE_MM + p.shell.lock_groove.mm()
}

/// The groove's outline from the diffuser downwards, in (radius, height), mm; nothing where there is none.
fn groove(p: &Dome, layout: &Layout) -> Vec<[f64; 2]> {
    let depth = p.shell.lock_groove.mm();
    if depth == 0.0 {
        return Vec::new();
    }
    let bore = layout.shell_bore_radius_mm;
    let top = layout.diffuser_bottom_z_mm - GROOVE_EDGE_MM;
    let inmost = top - GROOVE_MM;
    // The flank at 45 degrees prints without support and traps no air.
    vec![[bore, top], [bore + depth, top], [bore + depth, inmost], [bore, inmost - depth]]
}

/// What the shell's bore gets: the groove.
pub fn groove_tool(p: &Dome, layout: &Layout) -> Option<Solid> {
    let outline = groove(p, layout);
    let (first, last) = (outline.first()?, outline.last()?);
    // It begins inside the bore.
    let inside = layout.shell_bore_radius_mm - INTO_MM;
    let outline = [&[[inside, last[1]], [inside, first[1]]], &outline[..]].concat();
    Some(Solid::revolution(Path::polygon(&outline)).named("lock groove"))
}

/// The ribs between diffuser and LED board, `up_mm` longer at the diffuser.
pub fn ribs(p: &Dome, layout: &Layout, up_mm: f64) -> Vec<Solid> {
    // A rib's width is an angle at the bore.
    let half_width = (p.shell.rib_width.mm() / 2.0 / layout.shell_bore_radius_mm).asin();
    let half_width = Angle::from_rad(half_width).expect("ribs are narrower than the shell");
    let back = Angle::from_rad(-half_width.rad()).expect("finite");
    let sector = |inner: f64, outer: f64, top: f64| {
        Solid::prism(
            Path::ring_sector(inner, outer, back, half_width),
            [layout.board_top_z_mm, top],
        )
    };
    let root = layout.shell_bore_radius_mm + p.shell.lock_groove.mm() + RIB_ROOT_MM;
    let top = layout.diffuser_bottom_z_mm + up_mm;
    let rib = if is_locked(p) {
        let ledge = layout.diffuser_radius_mm - layout.rib_radius_mm;
        let bears = layout.rib_radius_mm + LEDGE_MM.max(ledge - LEDGE_MM / 2.0);
        let step = layout.diffuser_bottom_z_mm - RIB_STEP_MM;
        sector(layout.rib_radius_mm, bears, top).plus(sector(bears - INTO_MM / 2.0, root, step))
    } else {
        sector(layout.rib_radius_mm, root, top)
    };
    (0..p.shell.ribs)
        .map(|i| rib.clone().turned_z(turn(i, p.shell.ribs, 0.0)).named(format!("rib {}", i + 1)))
        .collect()
}

/// The gel below the diffuser, in its bore and its notches, and around its edge.
pub fn locking_gel(p: &Dome, layout: &Layout) -> Option<Body> {
    if !is_locked(p) {
        return None;
    }
    let (face, under) = (layout.gel_face_z_mm, layout.diffuser_bottom_z_mm);
    let (bore, seat) = (layout.shell_bore_radius_mm, layout.seat_radius_mm);
    let mut outline = vec![[0.0, face], [bore, face]];
    outline.extend(groove(p, layout).iter().rev());
    if seat < bore {
        // Below the shoulder, which the ribs carry.
        let shoulder = under - INTO_MM;
        outline.extend([[bore, shoulder], [seat, shoulder]]);
    }
    let edge = layout.diffuser_radius_mm;
    outline.extend([[seat, 0.0], [edge, 0.0], [edge, under], [0.0, under]]);
    let d = &p.diffuser;
    let hole = notched_circle(
        d.bore_radius.mm(),
        d.notch_radius.mm(),
        d.notch_width.mm() / 2.0,
        d.notches,
    );
    let plug =
        Solid::prism(Profile::new(hole), [under - INTO_MM, 0.0]).named("through the diffuser");
    // Ribs reach beyond the face; above them there is the diffuser.
    let solid = Solid::revolution(Path::polygon(&outline)).plus(plug).minus_all(ribs(
        p,
        layout,
        CUT_OVERLAP_MM,
    ));
    Some(
        LOCKING_GEL
            .cast(solid)
            .from(&p.filling_gel.material)
            .placed([in_sensor().lifted(8.0), JOINING.in_place().lifted(-52.0)])
            .colored([214, 226, 236])
            .opaque(0.35)
            // It closes around each rib, over its shoulder.
            .with_handles(p.shell.ribs as i32),
    )
}
