//! Kerf compensation of outlines.

use std::f64::consts::{PI, TAU};

use cavalier_contours::polyline::{
    PlineOffsetOptions, PlineSource, PlineSourceMut, Polyline, seg_arc_radius_and_center,
};
use fabkit_geometry::{Path, Profile, Segment};

use crate::ExportError;

/// Distance below which end points coincide, mm; far below a machine's resolution, far above rounding.
const SAME_POINT_MM: f64 = 1e-9;

/// Bulge below which a segment is straight: the arc deviates from a chord of one metre by less than a nanometre.
const STRAIGHT_BULGE: f64 = 1e-12;

/// Computes the outlines for the centre of a beam of width `kerf_mm` so that the remaining piece is `profile`: the
/// outer boundary grows by half the kerf, holes shrink by as much.
///
/// Outlines are parallel curves: lines and arcs stay lines and arcs. Corners that point into the waste become arcs of
/// radius `kerf_mm` / 2, since the beam turns around the corner; corners that point into the piece stay sharp and are
/// cut with the beam's roundness. For a convex outline of area A and length L the area becomes A + L kerf / 2 + pi
/// (kerf / 2)^2 (Steiner's formula).
///
/// ```
/// use fabkit_export::widen_for_kerf;
/// use fabkit_geometry::{Path, Profile};
/// let disc = Profile::new(Path::circle([0.0, 0.0], 5.0));
/// let cut = widen_for_kerf(&disc, 0.2)?;
/// assert!((cut.area_mm2() - std::f64::consts::PI * 5.1 * 5.1).abs() < 1e-9);
/// # Ok::<(), fabkit_export::ExportError>(())
/// ```
///
/// # Errors
/// [`ExportError::KerfTooWide`] if the beam closes or divides an outline, and [`ExportError::NotCuttable`] for elliptic
/// arcs.
pub fn widen_for_kerf(profile: &Profile, kerf_mm: f64) -> Result<Profile, ExportError> {
    if kerf_mm == 0.0 {
        return Ok(profile.clone());
    }
    let failed = |outline: String| ExportError::KerfTooWide { outline, kerf_mm };
    let outer = offset_path(&profile.outer, kerf_mm / 2.0)?;
    let mut widened = Profile::new(outer.ok_or_else(|| failed("the outer boundary".into()))?);
    for (i, hole) in profile.holes.iter().enumerate() {
        let shrunk = offset_path(hole, -kerf_mm / 2.0)?.ok_or_else(|| {
            let [min, max] = Profile::new(hole.clone()).bounds_mm();
            let [x, y] = [0, 1].map(|axis| (min[axis] + max[axis]) / 2.0);
            failed(format!("hole {} around ({x:.2}, {y:.2}) mm", i + 1))
        })?;
        widened.holes.push(shrunk);
    }
    Ok(widened)
}

/// Offsets a path outwards, or inwards by a negative distance; `None` if the result is not a single path.
fn offset_path(path: &Path, outwards_mm: f64) -> Result<Option<Path>, ExportError> {
    let line = polyline(path)?;
    let options = PlineOffsetOptions {
        pos_equal_eps: SAME_POINT_MM,
        offset_dist_eps: 10.0 * SAME_POINT_MM,
        ..PlineOffsetOptions::default()
    };
    // Positive offsets lie to the left, which is inside where the path runs counter-clockwise.
    let left_mm = if path.signed_area_mm2() > 0.0 { -outwards_mm } else { outwards_mm };
    let moved = line.parallel_offset_opt(left_mm, &options);
    Ok(match moved.as_slice() {
        [one] => Some(to_path(one)),
        _ => None,
    })
}

/// Converts a path to a polyline with bulges.
fn polyline(path: &Path) -> Result<Polyline, ExportError> {
    let mut line = Polyline::new_closed();
    let mut from = path.start;
    for segment in &path.segments {
        match segment {
            // Split in halves, since the offset supports arcs of up to half a circle.
            Segment::Arc { to, centre, ccw } if sweep(from, *to, *centre, *ccw).abs() > PI => {
                let half = sweep(from, *to, *centre, *ccw) / 2.0;
                let (sin, cos) = half.sin_cos();
                let [x, y] = [from[0] - centre[0], from[1] - centre[1]];
                let middle = [centre[0] + x * cos - y * sin, centre[1] + x * sin + y * cos];
                for start in [from, middle] {
                    line.add(start[0], start[1], (half / 4.0).tan());
                }
            }
            _ => line.add(from[0], from[1], bulge(from, segment)?),
        }
        from = segment.to();
    }
    Ok(line)
}

/// Converts a polyline with bulges back to a path.
fn to_path(line: &Polyline) -> Path {
    let start = line.at(0);
    let path = Path::from([start.x, start.y]);
    line.iter_segments().fold(path, |path, (from, to)| {
        let end = [to.x, to.y];
        if from.bulge.abs() < STRAIGHT_BULGE {
            return path.line(end);
        }
        let (_, centre) = seg_arc_radius_and_center(from, to);
        path.arc(end, [centre.x, centre.y], from.bulge > 0.0)
    })
}

/// Computes the bulge of a segment: the tangent of a quarter of the angle that it sweeps, positive counter-clockwise,
/// as DXF and the offset represent arcs; 0 for a line.
///
/// # Errors
/// [`ExportError::NotCuttable`] for an elliptic arc.
pub(crate) fn bulge(from: [f64; 2], segment: &Segment) -> Result<f64, ExportError> {
    match segment {
        Segment::Line { .. } => Ok(0.0),
        Segment::Arc { to, centre, ccw } => Ok((sweep(from, *to, *centre, *ccw) / 4.0).tan()),
        Segment::EllipticArc { .. } => Err(ExportError::NotCuttable),
    }
}

/// Computes the signed angle that an arc sweeps, rad.
pub(crate) fn sweep(from: [f64; 2], to: [f64; 2], centre: [f64; 2], ccw: bool) -> f64 {
    let arm = |p: [f64; 2]| [p[0] - centre[0], p[1] - centre[1]];
    let (a, b) = (arm(from), arm(to));
    let turn = (a[0] * b[1] - a[1] * b[0]).atan2(a[0] * b[0] + a[1] * b[1]);
    if ccw { turn.rem_euclid(TAU) } else { -((-turn).rem_euclid(TAU)) }
}
