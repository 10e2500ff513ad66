//! What real captures show: how dark it is by the distance from a pin's mark, and how bright it is at rest.

use fabkit_calibration::image::GreyImage;
use fabkit_calibration::model::Observation;
use fabkit_camera::Point2;
use fabkit_geometry::{Point3, TouchSurface, Vector3};

use super::seen::Seen;

/// Width of a bin, mm, and how many there are.
pub(super) const BIN_MM: f64 = 0.25;
pub(super) const BINS: usize = 12;
/// Bins from here on are beside the pin: they tell how bright the whole picture is.
pub(super) const BESIDE: usize = 8;
/// Step along the surface from which the picture's scale follows, mm.
const SCALE_MM: f64 = 0.25;
/// Least pixels of a bin that counts.
const LEAST_PIXELS: usize = 4;
/// A grey value of 255 is this bright in a picture.
const WHITE: f64 = 255.0;

/// A pin as one capture shows it.
#[derive(Clone, Debug)]
pub(super) struct Profile {
    /// Which capture, from 0.
    pub(super) capture: usize,
    /// How far from the tip, rad.
    pub(super) polar_rad: f64,
    /// How deep the pin goes in, as its landmark says, mm.
    pub(super) stated_mm: f64,
    /// Grey by which it is darker than at rest, by distance.
    pub(super) darker: [f64; BINS],
}

impl Profile {
    /// Around the mark of a pin; nothing where the picture ends, or the camera's model does.
    pub(super) fn of(
        observation: &Observation,
        seen: &Seen<'_>,
        touch: &TouchSurface,
        [reference, capture]: [&GreyImage; 2],
    ) -> Option<Self> {
        let contact = observation.contact.contact_in_sensor_mm;
        let (depth_mm, outward) = touch.depth_mm(&contact);
        let surface = contact + depth_mm * outward;
        let across = tangents(&outward).map(|way| {
            let [ahead, behind] = [SCALE_MM, -SCALE_MM].map(|mm| seen.pixel(&(surface + mm * way)));
            Some((ahead? - behind?) / (2.0 * SCALE_MM))
        });
        let [Some(a), Some(b)] = across else { return None };
        // Pixels to millimetres.
        let determinant = a.x * b.y - a.y * b.x;
        let mm = |d: Point2<f64>| {
            let u = (d.x * b.y - d.y * b.x) / determinant;
            let v = (a.x * d.y - a.y * d.x) / determinant;
            u.hypot(v)
        };
        let reach_mm = BINS as f64 * BIN_MM;
        let reach_px = reach_mm * a.norm().max(b.norm());
        let (mut sums, mut counts) = ([0.0; BINS], [0; BINS]);
        let at = observation.pixel;
        let range = |middle: f64, size: usize| {
            let from = (middle - reach_px).floor().max(0.0) as usize;
            let to = ((middle + reach_px).ceil().max(0.0) as usize).min(size.saturating_sub(1));
            from..=to
        };
        for y in range(at.y, reference.height_px()) {
            for x in range(at.x, reference.width_px()) {
                let off_mm = mm(Point2::new(x as f64 - at.x, y as f64 - at.y));
                let bin = (off_mm / BIN_MM) as usize;
                if bin < BINS {
                    sums[bin] += WHITE * f64::from(reference.at(x, y) - capture.at(x, y));
                    counts[bin] += 1;
                }
            }
        }
        let darker = std::array::from_fn(|bin| sums[bin] / counts[bin] as f64);
        let is_whole = counts.iter().all(|count| *count >= LEAST_PIXELS);
        is_whole.then_some(Self {
            capture: observation.contact.capture,
            polar_rad: outward.z.clamp(-1.0, 1.0).acos(),
            stated_mm: depth_mm,
            darker,
        })
    }
}

/// Two ways along a surface, across each other.
pub(super) fn tangents(outward: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let beside = if outward.z.abs() < 0.9 { Vector3::z() } else { Vector3::x() };
    let first = beside.cross(outward).normalize();
    [first, outward.cross(&first)]
}

/// Mean grey at places of the surface at rest that the camera sees.
pub(super) fn mean_grey(
    places: impl Iterator<Item = Point3<f64>>,
    seen: &Seen<'_>,
    picture: &GreyImage,
) -> Option<f64> {
    let (width, height) = (picture.width_px() as f64, picture.height_px() as f64);
    let grey = |point: Point3<f64>| {
        let pixel = seen.pixel(&point)?;
        let inside =
            (0.0..width - 0.5).contains(&pixel.x) && (0.0..height - 0.5).contains(&pixel.y);
        inside.then(|| {
            WHITE * f64::from(picture.at(pixel.x.round() as usize, pixel.y.round() as usize))
        })
    };
    let found: Vec<f64> = places.filter_map(grey).collect();
    (!found.is_empty()).then(|| found.iter().sum::<f64>() / found.len() as f64)
}
