//! The markers: where they are, and the slot that each one fills.

use std::f64::consts::TAU;

use fabkit_geometry::{
    CUT_OVERLAP_MM, Carrier, InvalidPattern, Mark, Path, Pattern, Point3, Pose, Solid,
};

use super::layout::Layout;
use super::parameters::{HalfEllipsoid, Markers};
use crate::blocks::copies;
use crate::blocks::marks::RoundPattern;

/// Spread of the markers over rings around the tip.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// From ring to ring along the surface, mm.
    pub spacing: f64,
    /// The places on the inner elastomer's outside.
    pub pattern: Pattern,
}

impl Spread {
    /// Markers on each ring, for people.
    pub fn counts(&self) -> String {
        match &self.pattern {
            Pattern::SurfaceRings { counts, .. } => {
                counts.iter().map(u32::to_string).collect::<Vec<_>>().join(", ")
            }
            _ => String::new(),
        }
    }
}

/// One marker at the tip and the others on rings of latitude that are equally far from each other
/// along the surface; the last one stays half a step above the base circle, so that the rim cuts no
/// marker. Each ring gets its share by circumference (largest remainders first), and there are as
/// many rings as make the distance along a ring most like the distance between rings. So every
/// count can be had, and all markers stand for about the same area.
///
/// # Errors
/// A surface without meridian; no markers at all.
pub fn spread(layout: &Layout, count: u32) -> Result<Spread, InvalidPattern> {
    let surface = layout.ellipsoid.parallel(layout.inner_offset_mm);
    let length = layout.ellipsoid.meridian_length(layout.inner_offset_mm);
    let others = count.checked_sub(1).ok_or(InvalidPattern::Empty)?;
    let mut best: Option<(f64, Spread)> = None;
    // Where markers stand for equal squares, rings are as far apart as a square is wide; the best
    // number lies beside that.
    let square = layout.ellipsoid.area_estimate(layout.inner_offset_mm) / f64::from(count);
    let about = (length / square.sqrt()) as u32;
    for rings in about.saturating_sub(2).max(1)..=about + 2 {
        let spacing = length / (f64::from(rings) + 0.5);
        let one_each = Pattern::SurfaceRings {
            surface: surface.clone(),
            spacing_mm: spacing,
            counts: vec![1; rings as usize + 1],
        };
        let circles: Vec<f64> = one_each.poses()?[1..]
            .iter()
            .map(|pose| TAU * pose.translation_mm().xy().norm())
            .collect();
        let along = circles.iter().sum::<f64>() / f64::from(others.max(1));
        let uneven = (along / spacing).ln().abs();
        if best.as_ref().is_none_or(|(least, _)| uneven < *least) {
            let mut counts = vec![1];
            counts.extend(shares(&circles, others));
            let pattern =
                Pattern::SurfaceRings { surface: surface.clone(), spacing_mm: spacing, counts };
            best = Some((uneven, Spread { spacing, pattern }));
        }
    }
    best.map(|(_, spread)| spread).ok_or(InvalidPattern::Empty)
}

/// Whole numbers in proportion to `weights` that add up to `total` (largest remainders first).
fn shares(weights: &[f64], total: u32) -> Vec<u32> {
    let sum: f64 = weights.iter().sum();
    let exact: Vec<f64> = weights.iter().map(|w| w / sum * f64::from(total)).collect();
    let mut counts: Vec<u32> = exact.iter().map(|e| e.floor() as u32).collect();
    let mut order: Vec<usize> = (0..weights.len()).collect();
    order.sort_by(|&i, &j| (exact[j].fract()).total_cmp(&exact[i].fract()));
    let missing = total - counts.iter().sum::<u32>();
    for &i in order.iter().take(missing as usize) {
        counts[i] += 1;
    }
    counts
}

/// Origin of each marker on the inner elastomer's outside, z axis outwards along the normal; none
/// for no markers or a surface that `check` refuses.
pub fn poses(p: &HalfEllipsoid, layout: &Layout) -> Vec<Pose> {
    if p.markers.pattern == RoundPattern::List {
        return p.markers.listed().poses(&layout.ellipsoid.parallel(layout.inner_offset_mm));
    }
    spread(layout, p.markers.count).and_then(|s| s.pattern.poses()).unwrap_or_default()
}

/// Depth of a slot, mm.
pub fn depth(markers: &Markers) -> f64 {
    markers.straight_depth.mm() + markers.radius.mm()
}

/// Centre of each slot's round end, mm.
pub fn end_centres(p: &HalfEllipsoid, layout: &Layout) -> Vec<Point3<f64>> {
    let end = Point3::new(0.0, 0.0, -p.markers.straight_depth.mm());
    poses(p, layout).iter().map(|pose| pose.point(end)).collect()
}

/// The slots' ends, which the camera follows.
pub fn marks(p: &HalfEllipsoid, layout: &Layout) -> Vec<Mark> {
    let slots = &p.markers;
    Mark::below("marker", &poses(p, layout), depth(slots), slots.radius.mm(), |_| Carrier::Gel)
}

/// Everything within the inner elastomer's outside except the slots: what the inner elastomer and
/// its negative are cut from, and what the outer elastomer and the silicone mold go around.
pub fn slotted(p: &HalfEllipsoid, layout: &Layout) -> Solid {
    let (radius, straight) = (p.markers.radius.mm(), p.markers.straight_depth.mm());
    // The surface bends away from the slot's mouth, so that the overlap lies outside.
    let slot = Solid::revolution(
        Path::from([0.0, -straight - radius])
            .arc([radius, -straight], [0.0, -straight], true)
            .line([radius, CUT_OVERLAP_MM])
            .line([0.0, CUT_OVERLAP_MM])
            .close(),
    );
    let slots = copies("marker", &poses(p, layout), &slot);
    layout.ellipsoid.whole(layout.inner_offset_mm).minus_all(slots)
}
