//! Probe sets: the tip of one indenter, pressed along the normal at many places to many depths.
//!
//! UVDtact's reconstruction learns a map from the pixel of the largest change to the position of the indenter's tip
//! (Sections IV-B and V-A). Here the tip is given and its pixel is computed. Columns:
//!
//! | column | content |
//! |---|---|
//! | `index` | number of the probe, from 0 |
//! | `depth_mm` | depth of the tip below the undeformed surface, along its normal |
//! | `x_mm`, `y_mm`, `z_mm` | position of the tip, sensor frame |
//! | `u_px`, `v_px` | column and row where the camera sees the tip; empty if it does not |
//! | `r_mm`, `theta_rad`, `phi_rad` | the tip in spherical coordinates: distance from the sensor's origin, angle from +z, angle around it from +x |
//! | `phi_image_rad` | `atan2(v - vc, u - uc)`, with `(uc, vc)` where the surface's apex is seen |

use fabkit_camera::Point2;
use fabkit_fixtures::SurfacePoints;
use fabkit_geometry::csv::CsvTable;
use fabkit_geometry::sequences::EvenPoints;
use fabkit_geometry::{InvalidSolid, Point3, TouchSurface};
use fabkit_optics::ViewStacks;
use rayon::prelude::*;

use super::Viewpoint;
use super::projector::{POINTS_PER_CHUNK, Projector};

/// Number of probes in UVDtact's set.
pub const DEFAULT_COUNT: u32 = 33_803;

/// A probe set as text, and the number of visible tips.
#[derive(Clone, Debug, PartialEq)]
pub struct Probes {
    /// Table as CSV with a header line.
    pub csv: String,
    /// Number of tips that the camera sees.
    pub visible_tips: u32,
}

/// Samples tips evenly over the surface's area and over depths up to `deepest_mm`, and projects them to pixels. The
/// same `seed` gives the same set.
///
/// # Errors
/// Returns an error if the surface's dimensions make no valid solid.
///
/// ```
/// use fabkit_scene::ground_truth::probes::sample_probes;
///
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// # let viewpoint = fabkit_scene::ground_truth::Viewpoint::new(&project.design.sensor.camera, None, None)?;
/// # let viewpoint = viewpoint.resized([640, 480])?;
/// # let scene = fabkit_scene::SensorView::new(std::sync::Arc::new(project), viewpoint)?;
/// let seed = 7;
/// let set = sample_probes(scene.touch()?, &scene.viewpoint, scene.sights(), 20, 1.5, seed)?;
/// // A header line, then a line for each probe.
/// assert_eq!(set.csv.lines().count(), 21);
/// let depths_mm = set.csv.lines().skip(1).filter_map(|line| line.split(',').nth(1)?.parse().ok());
/// assert!(depths_mm.into_iter().all(|depth_mm: f64| depth_mm > 0.0 && depth_mm <= 1.5));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn sample_probes(
    touch: &TouchSurface,
    viewpoint: &Viewpoint,
    sights: &ViewStacks,
    count: u32,
    deepest_mm: f64,
    seed: u64,
) -> Result<Probes, InvalidSolid> {
    let points = SurfacePoints::new(touch)?;
    let apex = Point3::new(0.0, 0.0, touch.apex_z_mm());
    // The apex may lie outside the image; its projection still defines the centre.
    let centre = Projector::new(viewpoint, sights).project(&apex);
    let mut table = CsvTable::new(
        "index,depth_mm,x_mm,y_mm,z_mm,u_px,v_px,r_mm,theta_rad,phi_rad,phi_image_rad",
    );
    let mut seen = 0;
    let even = seeded_points(seed);
    let places = (0..).map(|number| even.at(number)).filter_map(|[along, around, deep]| {
        // The factor 1 - deep turns the range [0, 1) into depths in (0, deepest].
        Some((points.point_at_area_fractions([along, around])?, deepest_mm * (1.0 - deep)))
    });
    let tips = places
        .take(count as usize)
        .map(|((point, outward), depth_mm)| (point - depth_mm * outward, depth_mm));
    let tips: Vec<(Point3<f64>, f64)> = tips.collect();
    let pixels = tips.par_chunks(POINTS_PER_CHUNK).flat_map_iter(|tips| {
        let mut looking = Projector::new(viewpoint, sights);
        tips.iter().map(|(tip, _)| looking.look(tip).ok()).collect::<Vec<_>>()
    });
    let pixels: Vec<Option<Point2<f64>>> = pixels.collect();
    for (index, ((tip, depth_mm), pixel)) in tips.into_iter().zip(pixels).enumerate() {
        let (r_mm, across_mm) = (tip.coords.norm(), tip.x.hypot(tip.y));
        let (theta_rad, phi_rad) = (across_mm.atan2(tip.z), tip.y.atan2(tip.x));
        let phi_image_rad = pixel.zip(centre).map(|(pixel, centre)| {
            seen += 1;
            (pixel.y - centre.y).atan2(pixel.x - centre.x)
        });
        table.row([
            index.into(),
            depth_mm.into(),
            tip.x.into(),
            tip.y.into(),
            tip.z.into(),
            pixel.map(|pixel| pixel.x).into(),
            pixel.map(|pixel| pixel.y).into(),
            r_mm.into(),
            theta_rad.into(),
            phi_rad.into(),
            phi_image_rad.into(),
        ]);
    }
    Ok(Probes { csv: table.finish(), visible_tips: seen })
}

/// Returns the sequence of a seed: evenly spread points, shifted by an offset that a multiplicative hash derives from
/// the seed for each axis.
pub(super) fn seeded_points(seed: u64) -> EvenPoints<3> {
    EvenPoints::cube(std::array::from_fn(|axis| {
        // The multiplier is 2^64 divided by the golden ratio (Fibonacci hashing).
        let mixed = seed.wrapping_mul(3).wrapping_add(axis as u64);
        let mixed = mixed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (0.5 + (mixed >> 11) as f64 / (1u64 << 53) as f64).fract()
    }))
}
