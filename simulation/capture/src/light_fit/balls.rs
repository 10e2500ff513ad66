//! Radial intensity profiles of a ball on a pad, from real captures.

use fabkit_files::Error;
use fabkit_geometry::{Point3, SurfacePoints};
use fabkit_scene::press_simulation::ContactModel;
use fabkit_scene::{Cast, SensorView};

use super::FitLightError;
use super::simulated_profile::Raster;
use crate::plausibility::CheckedImage;
use crate::{LayerScene, RestRay};

/// Number of profile bins per ball radius, and extent of a profile in radii. The gel is displaced out to there.
const BINS_TO_RADIUS: f64 = 16.0;
const REACH: f64 = 2.0;
/// Minimum extent of a profile, in radii. A shorter one may show nothing beside the contact.
const LEAST_REACH: f64 = 1.0;
/// Number of a patch's places per ball radius, and half width of a patch in radii. The patch is larger than the profile
/// since light spreads in from beyond it.
const PLACES_TO_RADIUS: f64 = 20.0;
const PATCH: f64 = 2.3;
/// Number of cells per ball radius in the search for the darkest place.
const CELLS_TO_RADIUS: f64 = 8.0;
/// Share of the darkest cell's darkness above which pixels count for the ball's centre, and number of iterations.
const DARK: f64 = 0.5;
const ROUNDS: usize = 3;
/// Minimum darkness of a ball's middle, in intensities.
const LEAST_GREY: f64 = 8.0;
/// Maximum number of equally dark pixels beyond the profile, as a share of the pixels in the ball's middle. More mean a
/// second ball.
const STRAY: f64 = 0.2;
/// Minimum slope of a ray to the normal (tangent) for estimating from where rays come.
const LEAST_SLOPE: f64 = 0.05;
/// Margin along the layers' edge that is ignored, mm.
const EDGE_MM: f64 = 0.7;
/// Minimum number of pixels in a bin or cell.
const LEAST_PIXELS: usize = 4;
/// Intensity of a value of 1 in an image.
pub(super) const WHITE: f64 = 255.0;

/// Returns the grid of places around a ball and the bins of its profile. `from_mm` is the distance from which rays seem
/// to come.
pub(super) fn raster(ball_radius_mm: f64, from_mm: f64) -> Raster {
    Raster {
        nearer_per_mm: from_mm.recip(),
        step_mm: ball_radius_mm / PLACES_TO_RADIUS,
        half: (PATCH * PLACES_TO_RADIUS) as usize,
        bin_mm: ball_radius_mm / BINS_TO_RADIUS,
        bins: (REACH * BINS_TO_RADIUS) as usize,
    }
}

/// A pixel that sees the pad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PadPixel {
    /// Point on the undeformed surface, sensor frame, mm.
    pub at_mm: [f64; 2],
    /// Ratio of the ray's path in the layer to the layer's thickness.
    pub slant: f64,
}

/// Memory per ray of what is seen at rest, bytes: a place with its normal and path, and a pixel.
const SEEN_BYTES: u64 = 100;

/// Mapping between an image and a pad's undeformed surface.
#[derive(Clone, Debug)]
pub(super) struct PadImageMap {
    size_px: [usize; 2],
    /// Pixels row by row; `None` where no pad is seen.
    pixels: Vec<Option<PadPixel>>,
    /// Depth below the surface, mm, under the camera, from which rays seem to come if their direction in the layer is
    /// extended straight.
    from_mm: f64,
}

impl PadImageMap {
    /// Computes the mapping for a nominal or calibrated camera.
    ///
    /// # Errors
    /// Returns an error if the pad cannot be cast.
    pub(super) fn from_camera(scene: &SensorView, layers: &LayerScene<'_>) -> Result<Self, Error> {
        let camera = scene.viewpoint.camera();
        let size_px = [camera.width_px(), camera.height_px()].map(|px| px as usize);
        let cast = Cast::at_rest(ContactModel::Rigid);
        let seen =
            scene.cast(&cast, SEEN_BYTES, |seen| Ok::<_, Error>(layers.seen_at_rest(seen.map)))?;
        let pixel = |seen: RestRay| PadPixel {
            at_mm: [seen.place.x, seen.place.y],
            slant: seen.path_mm / seen.thick_mm,
        };
        let pixels: Vec<_> = seen.into_iter().map(|seen| seen.map(pixel)).collect();
        let pupil = scene.viewpoint.sensor_from_camera.point(Point3::origin());
        let from_mm = |pixel: &PadPixel| {
            let aside_mm = (pixel.at_mm[0] - pupil.x).hypot(pixel.at_mm[1] - pupil.y);
            // The slant is 1 / cos of the angle to the normal, so this is its tangent.
            let slope = (pixel.slant * pixel.slant - 1.0).sqrt();
            (slope > LEAST_SLOPE).then(|| aside_mm / slope)
        };
        let from_mm = median(pixels.iter().flatten().filter_map(from_mm));
        // Without any slanted ray, the rays are taken as parallel.
        let from_mm = if from_mm.is_finite() { from_mm } else { f64::INFINITY };
        Ok(Self { size_px, pixels, from_mm }.without_edge())
    }

    /// Returns the mapping for rectified images with `mm` millimetres per pixel. Their centre is the pad's centre and
    /// lies below the camera, which is as far away as in this view.
    pub(super) fn rectified(&self, points: &SurfacePoints, size_px: [usize; 2], mm: f64) -> Self {
        let [width, height] = size_px;
        let middle = size_px.map(|px| 0.5 * (px as f64 - 1.0));
        let pixel = |i: usize| {
            let at_mm =
                [(((i % width) as f64) - middle[0]) * mm, (middle[1] - ((i / width) as f64)) * mm];
            let SurfacePoints::Plane(pad) = points else { return None };
            let slope = at_mm[0].hypot(at_mm[1]) / self.from_mm;
            pad.at(at_mm).map(|_| PadPixel { at_mm, slant: 1.0_f64.hypot(slope) })
        };
        let pixels = (0..width * height).map(pixel).collect();
        Self { size_px, pixels, from_mm: self.from_mm }.without_edge()
    }

    /// Removes pixels near the layers' edge: a displaced gel does not fill them.
    fn without_edge(self) -> Self {
        let [[left, right], [below, above]] = self.bounds_mm();
        let pixel_mm =
            ((right - left) * (above - below) / self.visible_pixels().count() as f64).sqrt();
        // Without any visible pixel the profile reports the error.
        let aside = if pixel_mm.is_finite() { (EDGE_MM / pixel_mm).ceil() as i64 } else { 0 };
        let [width, height] = self.size_px.map(|px| px as i64);
        let is_seen = |i: usize, [dx, dy]: [i64; 2]| {
            let (x, y) = (i as i64 % width + dx * aside, i as i64 / width + dy * aside);
            // The layers may continue beyond the image's border, so it does not count as an edge.
            let is_outside = x < 0 || y < 0 || x >= width || y >= height;
            is_outside || self.pixels[(y * width + x) as usize].is_some()
        };
        let around = || (0..9).map(|k| [k % 3 - 1, k / 3 - 1]);
        let pixel = |i: usize| self.pixels[i].filter(|_| around().all(|way| is_seen(i, way)));
        Self { pixels: (0..self.pixels.len()).map(pixel).collect(), ..self }
    }

    /// Returns the distance from which rays seem to come, mm.
    pub(super) fn seen_from_mm(&self) -> f64 {
        self.from_mm
    }

    /// Returns the number of columns and rows of images.
    pub(super) fn size_px(&self) -> [usize; 2] {
        self.size_px
    }

    /// Iterates over the pixels that see the pad, with their indices.
    pub(super) fn visible_pixels(&self) -> impl Iterator<Item = (usize, PadPixel)> + '_ {
        self.pixels.iter().enumerate().filter_map(|(i, pixel)| Some((i, (*pixel)?)))
    }

    /// Returns the smallest and largest visible x and y, mm.
    fn bounds_mm(&self) -> [[f64; 2]; 2] {
        let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for (_, pixel) in self.visible_pixels() {
            for ([least, most], mm) in bounds.iter_mut().zip(pixel.at_mm) {
                (*least, *most) = (least.min(mm), most.max(mm));
            }
        }
        bounds
    }
}

/// Radial profile of a ball in one capture.
#[derive(Clone, Debug)]
pub(super) struct BallProfile {
    /// Centre of the ball, sensor frame, mm.
    pub at_mm: [f64; 2],
    /// Mean of [`PadPixel::slant`] there.
    pub slant: f64,
    /// Mean intensity there at rest.
    pub rest_grey: f64,
    /// Offset of the whole image against the one at rest, measured beyond the profile, in intensities.
    pub brighter_grey: f64,
    /// Loss of intensity against rest, corrected by the offset, by distance from the centre; as far as full rings are
    /// seen.
    pub darker: Vec<f64>,
}

impl BallProfile {
    /// Finds the ball in a capture, and computes its profile against the image at rest.
    ///
    /// # Errors
    /// Returns an error if the image shows no ball, several balls, or too little around one.
    pub(super) fn measure(
        view: &PadImageMap,
        [reference, image]: [&CheckedImage; 2],
        ball_radius_mm: f64,
    ) -> Result<Self, Error> {
        let file = image.file();
        let [reference, image] = [reference.grey(), image.grey()];
        let darker = |i: usize| WHITE * f64::from(reference[i] - image[i]);
        // A first estimate of the offset; most of the pad is undisturbed.
        let brighter_grey = -median(view.visible_pixels().map(|(i, _)| darker(i)));
        let (at_mm, darkest) =
            find_dark_centre(view, ball_radius_mm, |i| darker(i) + brighter_grey)
                .ok_or_else(|| FitLightError::NoBall { file: file.into(), least: LEAST_GREY })?;
        let Raster { bin_mm, bins, .. } = raster(ball_radius_mm, view.from_mm);
        let away_mm =
            |pixel: &PadPixel| (pixel.at_mm[0] - at_mm[0]).hypot(pixel.at_mm[1] - at_mm[1]);
        let to_side_mm = view
            .bounds_mm()
            .iter()
            .zip(at_mm)
            .fold(f64::INFINITY, |all, (side, at)| all.min(at - side[0]).min(side[1] - at));
        let mut sums = vec![(0.0, 0); bins];
        let (mut beyond, mut here) = (Vec::new(), Vec::new());
        for (i, pixel) in view.visible_pixels() {
            let mm = away_mm(&pixel);
            match sums.get_mut((mm / bin_mm) as usize) {
                Some((sum, count)) => (*sum, *count) = (*sum + darker(i), *count + 1),
                None => beyond.push(darker(i)),
            }
            if mm < ball_radius_mm / 2.0 {
                here.push((f64::from(reference[i]) * WHITE, pixel.slant));
            }
        }
        // Bins beyond the nearest side are cut off.
        let whole = (to_side_mm / bin_mm).max(0.0) as usize;
        let dark = beyond.iter().filter(|grey| **grey + brighter_grey > DARK * darkest).count();
        if dark as f64 > STRAY * here.len() as f64 {
            return Err(FitLightError::SeveralBalls { file: file.into() }.into());
        }
        let means = sums.iter().take(whole).take_while(|(_, count)| *count >= LEAST_PIXELS);
        let means: Vec<f64> = means.map(|(sum, count)| sum / *count as f64).collect();
        if (means.len() as f64) < LEAST_REACH * BINS_TO_RADIUS || beyond.is_empty() {
            let least_mm = LEAST_REACH * ball_radius_mm;
            let error = FitLightError::BallAtEdge { file: file.into(), at_mm, least_mm };
            return Err(error.into());
        }
        // The undisturbed surroundings of the ball give the offset of the whole image.
        let brighter_grey = -median(beyond.into_iter());
        let count = here.len() as f64;
        Ok(Self {
            at_mm,
            slant: here.iter().map(|(_, slant)| slant).sum::<f64>() / count,
            rest_grey: here.iter().map(|(grey, _)| grey).sum::<f64>() / count,
            brighter_grey,
            darker: means.into_iter().map(|mean| mean + brighter_grey).collect(),
        })
    }
}

/// Finds the centre of the dark region around the darkest cell, and its darkness.
fn find_dark_centre(
    view: &PadImageMap,
    ball_radius_mm: f64,
    darker: impl Fn(usize) -> f64,
) -> Option<([f64; 2], f64)> {
    let cell_mm = ball_radius_mm / CELLS_TO_RADIUS;
    let mut cells: std::collections::BTreeMap<[i64; 2], (f64, usize)> = Default::default();
    for (i, pixel) in view.visible_pixels() {
        let (sum, count) =
            cells.entry(pixel.at_mm.map(|mm| (mm / cell_mm).floor() as i64)).or_default();
        (*sum, *count) = (*sum + darker(i), *count + 1);
    }
    let means = cells.iter().filter(|(_, (_, count))| *count >= LEAST_PIXELS);
    let means = means.map(|(cell, (sum, count))| (cell, sum / *count as f64));
    let (cell, darkest) = means.max_by(|a, b| a.1.total_cmp(&b.1))?;
    if darkest < LEAST_GREY {
        return None;
    }
    let mut at = cell.map(|k| (k as f64 + 0.5) * cell_mm);
    for _ in 0..ROUNDS {
        let (mut sum, mut count) = ([0.0; 2], 0.0);
        for (i, pixel) in view.visible_pixels() {
            let [x, y] = pixel.at_mm;
            let near = (x - at[0]).hypot(y - at[1]) < ball_radius_mm;
            if near && darker(i) > DARK * darkest {
                (sum, count) = ([sum[0] + x, sum[1] + y], count + 1.0);
            }
        }
        at = sum.map(|sum| sum / count);
    }
    at.iter().all(|mm| mm.is_finite()).then_some((at, darkest))
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    super::median(&mut values.collect::<Vec<_>>())
}
