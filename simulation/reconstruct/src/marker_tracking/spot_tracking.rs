//! Tracking of markers that appear as spots.

use fabkit_calibration::significance::{Detected, Detections, LeftOut, Significance};
use fabkit_geometry::{Sensor, VisibleEffect};

use super::appearance::{Appearance, NormalisedImage};
use super::assignment::{Pattern, Px, REACH, add, distance, subtract};
use super::scaling::Scaling;
use super::spot_detection::{
    Blob, MarkerSignal, MarkerSize, NoiseWeights, SignalImage, darkness_weights,
};
use super::{TrackedMarker, TrackedMarkers, colour_share, marker_layer, median};
use crate::CapturedImage;

/// Minimum strength of a spot at rest, relative to the median of nearby markers.
const LEAST_OF_MEDIAN: f64 = 0.25;
/// Minimum strength of a spot in further images, relative to that of the marker at rest.
const LEAST_OF_REST: f64 = 0.35;
/// Minimum significance of a spot: noise alone exceeds it once in a thousand million pixels.
const MIN_SIGMAS: f64 = 6.0;
/// Largest typical distance of a spot at rest from the place that its neighbours predict, relative to the distance between
/// markers, and the same in pixels. Spots of noise, of blocks and of uneven light lie anywhere within the reach of the
/// assignment (0.42): theirs is 0.18 to 0.27 in twenty such images, that of markers 0.001 to 0.03 in 18.
const MAX_MISS: f64 = 0.1;
const MAX_MISS_PX: f64 = 0.5;
/// Minimum strength of a spot that is counted as left out, relative to that of one that is kept, and its significance: the
/// surroundings of a marker are some hundred places, one in 300 of which has noise of 4 standard deviations.
const LEAST_LEFT_OUT: f64 = 0.5;
const LEFT_OUT_SIGMAS: f64 = 4.0;
/// Distance below which two spots are the same, relative to the distance between markers.
const SAME_SPOT: f64 = 0.35;
/// Half width of the surroundings over which brightness is averaged, in distances between markers.
const EVEN_PITCHES: f64 = 1.0;

/// Tracker of markers that appear as spots.
#[derive(Clone, Debug)]
pub(super) struct SpotTracker {
    scaling: Scaling,
    tells: MarkerSignal,
    weights: NoiseWeights,
    sizes: Vec<MarkerSize>,
    rest: Pattern,
    /// Strength of each spot at rest.
    strengths: Vec<f64>,
    /// Appearance at rest of markers that throw shadows; empty where markers are even spots.
    looks: Vec<Option<Appearance>>,
}

/// Spot that may be a marker, with the limit that applies to it.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    blob: Blob,
    least: f64,
    /// Distance below which another spot is the same, px.
    same_px: f64,
    /// Contrast of a strength of 1, as a fraction.
    contrast_unit: f64,
}

impl Detected for Candidate {
    fn contrast(&self) -> f64 {
        self.contrast_unit * self.blob.strength
    }

    fn significance(&self) -> Significance {
        self.blob.significance
    }
}

impl SpotTracker {
    /// Creates a tracker from the image at rest. Also returns the markers found in it.
    pub(super) fn at_rest(
        (sensor, shows): (&Sensor, &VisibleEffect),
        (drawn_px, radii_px): (&[Option<Px>], &[f64]),
        size_px: [usize; 2],
        reference: &CapturedImage,
    ) -> (Self, TrackedMarkers) {
        // A marker without neighbours may move by a quarter of the image.
        let alone_px = 0.25 * size_px[0].min(size_px[1]) as f64;
        let drawn = Pattern::new(drawn_px.to_vec(), alone_px);
        let known = || drawn_px.iter().enumerate().filter_map(|(i, px)| Some((i, (*px)?)));
        // The narrowest marker decides the resolution of the whole image.
        let narrowest_px = known().map(|(i, _)| radii_px[i]).fold(f64::INFINITY, f64::min);
        let scaling = Scaling::new(size_px, narrowest_px, sensor.intensity_bits);
        let values = scaling.values(reference);
        let tells = match shows {
            VisibleEffect::Fluorescence { layers } => {
                colour_share(layers, marker_layer(sensor, layers).unwrap_or(0))
            }
            VisibleEffect::Slopes { .. } => {
                let mut pitches: Vec<f64> = known().map(|(i, _)| drawn.pitch_px()[i]).collect();
                let pitch_px = median(&mut pitches).unwrap_or(alone_px);
                let half = (EVEN_PITCHES * pitch_px / scaling.binned as f64).ceil() as usize;
                MarkerSignal::Dark(darkness_weights(&scaling, &values, reference.channels, half))
            }
            _ => MarkerSignal::Bright,
        };
        let weights = NoiseWeights::new(&tells, &values, reference.channels);
        let sizes: Vec<MarkerSize> = radii_px
            .iter()
            .zip(drawn.pitch_px())
            .map(|(radius_px, pitch_px)| MarkerSize { radius_px: *radius_px, pitch_px: *pitch_px })
            .collect();
        let blocks = weights.block_noise(reference, scaling.grey_step);
        let said = SignalImage::new(&scaling, &tells, &values, reference.channels, blocks);
        let noises: Vec<f64> = sizes.iter().map(|size| said.noise(*size)).collect();
        let strongest = |said: &SignalImage<'_>, i: usize, at: &Px| {
            let size = sizes[i];
            let near = said.find_maxima(at, 0.5 * size.pitch_px, size, [0.0, noises[i]]);
            near.iter().map(|blob| blob.strength).fold(0.0, f64::max)
        };
        let mut strongest_of = vec![0.0; sizes.len()];
        known().for_each(|(i, at)| strongest_of[i] = strongest(&said, i, &at));
        // Light falls off over the surface, so thresholds follow from the markers nearby.
        let least = |(i, noise): (usize, &f64)| {
            let near = drawn.neighbours(i).iter().chain([&i]).map(|j| strongest_of[*j]);
            let usual = LEAST_OF_MEDIAN * median(&mut near.collect::<Vec<_>>()).unwrap_or(0.0);
            usual.max(MIN_SIGMAS * noise)
        };
        let leasts: Vec<f64> = noises.iter().enumerate().map(least).collect();
        let mut found = candidates(&said, &drawn, &sizes, (&leasts, &noises), reference.channels);
        let spots: Vec<Px> = found.kept().iter().map(|spot| spot.blob.at).collect();
        let mut chosen = drawn.assign(&spots);
        let middle = |(chosen, size): (&Option<usize>, &MarkerSize)| {
            Some(said.spot_centre(&spots[(*chosen)?], *size))
        };
        let mut rest_px: Vec<Option<Px>> = chosen.iter().zip(&sizes).map(middle).collect();
        if !is_pattern(&drawn, &rest_px) {
            // These spots are no markers, however far they stand out.
            let all = [found.kept(), found.left_out()].concat();
            found = Detections::split(all, |_| false);
            chosen.fill(None);
            rest_px.fill(None);
        }
        let strength = |(px, size): (&Option<Px>, &MarkerSize)| {
            px.as_ref().map_or(0.0, |px| said.strength_at(px, *size))
        };
        let strengths = rest_px.iter().zip(&sizes).map(strength).collect();
        let looks = match (&tells, shows) {
            (MarkerSignal::Dark(counts), VisibleEffect::Slopes { printed: None, .. })
                if reference.channels == 3 =>
            {
                let evened = NormalisedImage::new(&scaling, &values, counts);
                let look = |(px, size): (&Option<Px>, &MarkerSize)| {
                    Appearance::new(&scaling, &evened, px.as_ref()?, size.radius_px)
                };
                rest_px.iter().zip(&sizes).map(look).collect()
            }
            _ => Vec::new(),
        };
        let markers = tracked_markers(&drawn, &found, &chosen, &rest_px);
        // From now on the measured places replace the expected ones.
        let rest = Pattern::new(rest_px, alone_px);
        (Self { looks, scaling, tells, weights, sizes, rest, strengths }, markers)
    }

    /// Tracks the markers in an image.
    pub(super) fn follow(&self, image: &CapturedImage) -> TrackedMarkers {
        let values = self.scaling.values(image);
        let blocks = self.weights.block_noise(image, self.scaling.grey_step);
        let said = SignalImage::new(&self.scaling, &self.tells, &values, image.channels, blocks);
        let noises: Vec<f64> = self.sizes.iter().map(|size| said.noise(*size)).collect();
        let least =
            |(noise, strength): (&f64, &f64)| (LEAST_OF_REST * strength).max(MIN_SIGMAS * noise);
        let leasts: Vec<f64> = noises.iter().zip(&self.strengths).map(least).collect();
        let limits = (&leasts[..], &noises[..]);
        let found = candidates(&said, &self.rest, &self.sizes, limits, image.channels);
        let spots: Vec<Px> = found.kept().iter().map(|spot| spot.blob.at).collect();
        let chosen = self.rest.assign(&spots);
        let evened = match &self.tells {
            MarkerSignal::Dark(counts) if !self.looks.is_empty() => {
                Some(NormalisedImage::new(&self.scaling, &values, counts))
            }
            _ => None,
        };
        let place = |(i, (chosen, size)): (usize, (&Option<usize>, &MarkerSize))| {
            let (place, rest) = (spots[(*chosen)?], self.rest.at()[i]?);
            let looks = self.looks.get(i).and_then(Option::as_ref);
            let Some((looks, evened)) = looks.zip(evened.as_ref()) else {
                return Some(said.spot_centre(&place, *size));
                // With shadows, the place of the best correlation is more reliable than the centre of the dark spot.
            };
            let by = subtract(&place, &rest);
            Some(add(&rest, &looks.find_displacement(&self.scaling, evened, &by, size.pitch_px)?))
        };
        let px: Vec<Option<Px>> = chosen.iter().zip(&self.sizes).enumerate().map(place).collect();
        tracked_markers(&self.rest, &found, &chosen, &px)
    }
}

/// Returns whether spots at rest lie as the drawn markers do. A camera that is slightly off its design moves neighbours
/// alike.
fn is_pattern(drawn: &Pattern, rest_px: &[Option<Px>]) -> bool {
    let moved = |i: usize| Some(subtract(rest_px[i].as_ref()?, drawn.at()[i].as_ref()?));
    let miss = |i: usize| {
        let own = moved(i)?;
        let beside: Vec<Px> = drawn.neighbours(i).iter().filter_map(|j| moved(*j)).collect();
        let mean = [0, 1].map(|k| beside.iter().map(|px| px[k]).sum::<f64>() / beside.len() as f64);
        let limit_px = (MAX_MISS * drawn.pitch_px()[i]).max(MAX_MISS_PX);
        (!beside.is_empty()).then(|| distance(&own, &mean) / limit_px)
    };
    let mut misses: Vec<f64> = (0..rest_px.len()).filter_map(miss).collect();
    // A single marker has no neighbours to disagree with.
    median(&mut misses).is_none_or(|miss| miss <= 1.0)
}

/// Joins places of markers with the significance of their spots. A spot was left out if the marker nearest to it is not
/// found.
fn tracked_markers(
    pattern: &Pattern,
    found: &Detections<Candidate>,
    chosen: &[Option<usize>],
    px: &[Option<Px>],
) -> TrackedMarkers {
    let marker = |(chosen, px): (&Option<usize>, &Option<Px>)| {
        let significance = found.kept()[(*chosen)?].significance();
        Some(TrackedMarker { px: (*px)?, significance })
    };
    let markers: Vec<Option<TrackedMarker>> = chosen.iter().zip(px).map(marker).collect();
    let is_missing = |spot: &&Candidate| {
        let known = pattern.at().iter().enumerate().filter_map(|(i, at)| Some((i, (*at)?)));
        let off = |at: &Px| distance(at, &spot.blob.at);
        let nearest = known.min_by(|(_, a), (_, b)| off(a).total_cmp(&off(b)));
        nearest.is_some_and(|(i, _)| markers[i].is_none())
    };
    let missing = found.left_out().iter().filter(is_missing);
    let left_out = missing.fold(LeftOut::default(), |sum, spot| LeftOut {
        count: sum.count + 1,
        max_contrast: sum.max_contrast.max(spot.contrast()),
    });
    TrackedMarkers { markers, left_out }
}

/// Returns the spots that may be markers, each once and the strongest first.
fn candidates(
    said: &SignalImage<'_>,
    pattern: &Pattern,
    sizes: &[MarkerSize],
    (leasts, noises): (&[f64], &[f64]),
    channels: usize,
) -> Detections<Candidate> {
    let contrast_unit = said.contrast_unit(channels);
    let mut all: Vec<Candidate> = Vec::new();
    for (i, at) in pattern.at().iter().enumerate() {
        let Some(at) = at else { continue };
        let pitch_px = pattern.pitch_px()[i];
        let (least, same_px) = (leasts[i], SAME_SPOT * pitch_px);
        let faintest = (LEAST_LEFT_OUT * least).max(LEFT_OUT_SIGMAS * noises[i]).min(least);
        let near = said.find_maxima(at, REACH * pitch_px, sizes[i], [faintest, noises[i]]);
        let near = near.into_iter();
        all.extend(near.map(|blob| Candidate { blob, least, same_px, contrast_unit }));
    }
    let is_kept = |one: &Candidate| one.blob.strength >= one.least;
    // Of spots that are too close to each other, only the strongest is kept, and none that is too faint displaces another.
    all.sort_by(|a, b| {
        is_kept(b).cmp(&is_kept(a)).then(b.blob.strength.total_cmp(&a.blob.strength))
    });
    let mut apart: Vec<Candidate> = Vec::new();
    for one in all {
        let is_new = |other: &Candidate| {
            distance(&other.blob.at, &one.blob.at) > other.same_px.min(one.same_px)
        };
        if apart.iter().all(is_new) {
            apart.push(one);
        }
    }
    Detections::split(apart, is_kept)
}
