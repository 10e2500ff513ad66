//! Radial intensity profiles of pins in real captures, and mean intensities at rest.

use fabkit_calibration::image::GreyImage;
use fabkit_calibration::model::Observation;
use fabkit_camera::{Point2, Vector2};
use fabkit_geometry::{Point3, TouchSurface, Vector3};

use super::corrected_camera::CorrectedCamera;

/// Width of a bin, mm, and number of bins.
pub(super) const BIN_MM: f64 = 0.25;
pub(super) const BINS: usize = 12;
/// Distance from the mark to which profiles reach, mm.
pub(super) const REACH_MM: f64 = BINS as f64 * BIN_MM;
/// First bin beside the pin: the bins from here on give the offset of the whole capture.
pub(super) const FIRST_BIN_BESIDE: usize = 8;
/// Step along the surface for the image's local scale, mm.
const SCALE_MM: f64 = 0.25;
/// Minimum number of pixels in a bin.
const LEAST_PIXELS: usize = 4;
/// Intensity of a value of 1 in an image.
const WHITE: f64 = 255.0;

/// Radial profile of a pin in one capture.
#[derive(Clone, Debug)]
pub(super) struct PinProfile {
    /// Index of the capture.
    pub(super) capture: usize,
    /// Polar angle from the tip, rad.
    pub(super) polar_rad: f64,
    /// Depth of the pin in its landmark, mm.
    pub(super) stated_mm: f64,
    /// Loss of intensity against rest by distance.
    pub(super) darker: [f64; BINS],
}

impl PinProfile {
    /// Computes the profile around a pin's mark. `None` where the image ends, or the camera model maps no pixel.
    pub(super) fn measure(
        observation: &Observation,
        seen: &CorrectedCamera<'_>,
        touch: &TouchSurface,
        [reference, capture]: [&GreyImage; 2],
    ) -> Option<Self> {
        let contact = observation.contact.contact_in_sensor_mm;
        let (depth_mm, outward) = touch.depth_mm(&contact);
        let surface = contact + depth_mm * outward;
        let scale = LocalScale::at(&surface, &outward, |place| seen.project(place))?;
        // Limits the loops below.
        let reach_px = scale.reach_px(REACH_MM);
        let (mut sums, mut counts) = ([0.0; BINS], [0; BINS]);
        let at = observation.pixel;
        let range = |middle: f64, size: usize| {
            let from = (middle - reach_px).floor().max(0.0) as usize;
            let to = ((middle + reach_px).ceil().max(0.0) as usize).min(size.saturating_sub(1));
            from..=to
        };
        for y in range(at.y, reference.height_px()) {
            for x in range(at.x, reference.width_px()) {
                let bin = scale.bin(Point2::new(x as f64, y as f64) - at);
                if bin < BINS {
                    sums[bin] += WHITE * f64::from(reference.at(x, y) - capture.at(x, y));
                    counts[bin] += 1;
                }
            }
        }
        let darker = std::array::from_fn(|bin| sums[bin] / counts[bin] as f64);
        // Bins with too few pixels mean that the image ends within the profile.
        let is_whole = counts.iter().all(|count| *count >= LEAST_PIXELS);
        is_whole.then_some(Self {
            capture: observation.contact.capture,
            polar_rad: outward.z.clamp(-1.0, 1.0).acos(),
            stated_mm: depth_mm,
            darker,
        })
    }
}

/// Scale of an image around a place of the surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalScale {
    /// Pixels per millimetre along two directions in the surface, at right angles to each other.
    px_per_mm: [Vector2<f64>; 2],
}

impl LocalScale {
    /// Measures the scale at a place with its outward normal; `None` where `project` maps no pixel.
    pub(super) fn at(
        surface: &Point3<f64>,
        outward: &Vector3<f64>,
        mut project: impl FnMut(&Point3<f64>) -> Option<Point2<f64>>,
    ) -> Option<Self> {
        let across = tangents(outward).map(|way| {
            let [ahead, behind] = [SCALE_MM, -SCALE_MM].map(|mm| project(&(surface + mm * way)));
            Some((ahead? - behind?) / (2.0 * SCALE_MM))
        });
        let [Some(a), Some(b)] = across else { return None };
        Some(Self { px_per_mm: [a, b] })
    }

    /// Returns the bin of a distance in the image, px; beyond the last bin there are more numbers.
    pub(super) fn bin(&self, off: Vector2<f64>) -> usize {
        // Inverts the 2 x 2 map from millimetres to pixels.
        let [a, b] = &self.px_per_mm;
        let determinant = a.x * b.y - a.y * b.x;
        let u = (off.x * b.y - off.y * b.x) / determinant;
        let v = (a.x * off.y - a.y * off.x) / determinant;
        (u.hypot(v) / BIN_MM) as usize
    }

    /// Returns an upper bound of a distance in the image, px, for one on the surface, mm.
    pub(super) fn reach_px(&self, reach_mm: f64) -> f64 {
        reach_mm * self.px_per_mm[0].norm().max(self.px_per_mm[1].norm())
    }
}

/// Returns two unit vectors in the surface, at right angles to each other.
// An auxiliary axis that is not nearly parallel to the normal.
pub(super) fn tangents(outward: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let beside = if outward.z.abs() < 0.9 { Vector3::z() } else { Vector3::x() };
    let first = beside.cross(outward).normalize();
    [first, outward.cross(&first)]
}

/// Returns the mean intensity at places of the undeformed surface that the camera sees; `None` if it sees none.
pub(super) fn mean_intensity(
    places: impl Iterator<Item = Point3<f64>>,
    seen: &CorrectedCamera<'_>,
    picture: &GreyImage,
) -> Option<f64> {
    let (width, height) = (picture.width_px() as f64, picture.height_px() as f64);
    let grey = |point: Point3<f64>| {
        let pixel = seen.project(&point)?;
        // The outer half of the first pixels belongs to them as that of the last ones does.
        let inside =
            (-0.5..width - 0.5).contains(&pixel.x) && (-0.5..height - 0.5).contains(&pixel.y);
        inside.then(|| {
            WHITE * f64::from(picture.at(pixel.x.round() as usize, pixel.y.round() as usize))
        })
    };
    let found: Vec<f64> = places.filter_map(grey).collect();
    (!found.is_empty()).then(|| found.iter().sum::<f64>() / found.len() as f64)
}
