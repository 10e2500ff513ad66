//! Tessellation of primitives.
//!
//! Vertices lie on the exact surface, and no triangle deviates from it by more than the tolerance. The triangles of a
//! face depend only on that face and the tolerance, not on the rest of its solid: two bodies that share a face get the
//! same triangles on it.

mod arc;
mod circle;
mod extruded;
mod revolved;
mod rings;
mod stitch;

use fabkit_geometry::{Cone, Cuboid, EllipsoidOffset, Solid};

use crate::facets::Facets;
use arc::Arc;
pub(crate) use circle::cos_sin_of_turn;
use revolved::{Stroke, revolve, strokes};
pub(crate) use stitch::{RingPoints, StripTriangle, stitch};

/// Returns the number of faces of a primitive; for booleans, the sum over their leaves.
pub(crate) fn face_count(solid: &Solid) -> u32 {
    match solid {
        Solid::Sphere(_)
        | Solid::Ellipsoid(_)
        | Solid::Torus(_)
        | Solid::HalfSpace(_)
        | Solid::EllipsoidOffset(_) => 1,
        Solid::Cylinder(_) | Solid::Cone(_) => 3,
        Solid::Cuboid(_) => 6,
        Solid::Extrusion(s) => 2 + s.profile.paths().map(|p| p.segments.len() as u32).sum::<u32>(),
        Solid::Revolution(s) => s.profile.paths().map(|p| p.segments.len() as u32).sum(),
        _ => solid.children().into_iter().map(face_count).sum(),
    }
}

/// Tessellates a primitive in its own frame. `None` if it is unbounded, no primitive, or needs too many triangles.
pub(crate) fn tessellate(primitive: &Solid, tolerance_mm: f64) -> Option<Facets> {
    let mut out = Facets::default();
    let good = match primitive {
        Solid::Sphere(s) => ball(&mut out, [s.radius_mm; 2], 0.0, tolerance_mm),
        Solid::Ellipsoid(s) => ellipsoid(&mut out, s.semi_axes_mm, tolerance_mm),
        Solid::EllipsoidOffset(EllipsoidOffset { equatorial_mm, polar_mm, offset_mm }) => {
            ball(&mut out, [*equatorial_mm, *polar_mm], *offset_mm, tolerance_mm)
        }
        Solid::Cylinder(s) => frustum(&mut out, [s.radius_mm; 2], s.height_mm, tolerance_mm),
        Solid::Cone(Cone { bottom_radius_mm, top_radius_mm, height_mm }) => {
            frustum(&mut out, [*bottom_radius_mm, *top_radius_mm], *height_mm, tolerance_mm)
        }
        Solid::Torus(s) => {
            let (ring, tube) = (s.ring_radius_mm, s.tube_radius_mm);
            let (centre, outer, inner) = ([ring, 0.0], [ring + tube, 0.0], [ring - tube, 0.0]);
            let upper = Stroke::arc(inner, Arc::between(outer, inner, centre, [tube; 2]), 0);
            let lower = Stroke::arc(outer, Arc::between(inner, outer, centre, [tube; 2]), 0);
            revolve(&mut out, outer, &[upper, lower], true, tolerance_mm)
        }
        Solid::Revolution(s) => {
            let mut first_face = 0;
            s.profile.paths().enumerate().all(|(i, path)| {
                let strokes = strokes(path, first_face);
                first_face += path.segments.len() as u32;
                revolve(&mut out, path.start, &strokes, i == 0, tolerance_mm)
            })
        }
        Solid::Cuboid(s) => {
            cuboid(&mut out, s);
            true
        }
        Solid::Extrusion(s) => extruded::extrude(&mut out, s, tolerance_mm),
        _ => false,
    };
    good.then_some(out)
}

/// Tessellates an ellipsoid of revolution, or a parallel surface of one. Returns whether that is possible.
fn ball(out: &mut Facets, semi_axes_mm: [f64; 2], offset_mm: f64, tolerance_mm: f64) -> bool {
    let quarter = std::f64::consts::FRAC_PI_2;
    let arc =
        Arc { centre: [0.0, 0.0], semi_axes_mm, offset_mm, from_rad: -quarter, to_rad: quarter };
    let tip_mm = semi_axes_mm[1] + offset_mm;
    let meridian = Stroke::arc([0.0, tip_mm], arc, 0);
    let axis = Stroke::line([0.0, -tip_mm], 0);
    revolve(out, [0.0, -tip_mm], &[meridian, axis], true, tolerance_mm)
}

/// Tessellates an ellipsoid with any three half axes: the ellipsoid of revolution around z with the longer of x and y
/// as radius, compressed along the other axis. Compression brings no two points farther apart, so the tolerance holds.
fn ellipsoid(out: &mut Facets, [a, b, c]: [f64; 3], tolerance_mm: f64) -> bool {
    let wide = a.max(b);
    let good = ball(out, [wide, c], 0.0, tolerance_mm);
    for vertex in &mut out.vertices {
        vertex[0] *= a / wide;
        vertex[1] *= b / wide;
    }
    good
}

fn frustum(out: &mut Facets, radii_mm: [f64; 2], height_mm: f64, tolerance_mm: f64) -> bool {
    let [bottom, top] = radii_mm;
    let on_axis = [[0.0, 0.0], [0.0, height_mm]];
    let mut strokes = Vec::with_capacity(4);
    if bottom > 0.0 {
        strokes.push(Stroke::line([bottom, 0.0], 1));
    }
    strokes.push(Stroke::line([top, height_mm], 0));
    if top > 0.0 {
        strokes.push(Stroke::line(on_axis[1], 2));
    }
    // The closing stroke on the axis sweeps no surface, so its face number does not matter.
    strokes.push(Stroke::line(on_axis[0], 0));
    revolve(out, on_axis[0], &strokes, true, tolerance_mm)
}

fn cuboid(out: &mut Facets, solid: &Cuboid) {
    let [x, y, z] = solid.size_mm;
    // Bits of corner k: bit 0 is x, bit 1 is y, bit 2 is z.
    for k in 0..8 {
        let pick = |bit: u32, low: f64, high: f64| if k >> bit & 1 == 0 { low } else { high };
        out.vertex([pick(0, -x / 2.0, x / 2.0), pick(1, -y / 2.0, y / 2.0), pick(2, 0.0, z)]);
    }
    box_faces(out, [0, 1, 2, 3, 4, 5]);
}

/// Adds the 12 triangles of a box whose corners are the first eight vertices, numbered by bits.
pub(crate) fn box_faces(out: &mut Facets, faces: [u32; 6]) {
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    for ([a, b, c, d], face) in quads.into_iter().zip(faces) {
        out.triangle([a, b, c], face);
        out.triangle([a, c, d], face);
    }
}
