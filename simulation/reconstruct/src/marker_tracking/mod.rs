//! Tracking of markers (dots, dimples, pins, ends of columns), each by its name in the sensor's description.
//!
//! The projection of a marker through the nominal or calibrated camera gives its expected place and size. Spots that
//! stand out there in the image at rest, by brightness, darkness or colour as the lighting has it, are assigned to
//! markers by [`assignment`]. The places found are the expected ones for all further images. A camera that is slightly
//! off its design shifts all markers and so mixes up none.

mod appearance;
mod assignment;
mod column_tracking;
mod scaling;
mod spot_detection;

use std::time::Instant;

use appearance::{Appearance, NormalisedImage};
use assignment::{Pattern, Px, REACH, add, subtract};
use column_tracking::ColumnTracker;
use fabkit_camera::DMatrix;
use fabkit_capture::plausibility::CheckedImage;
use fabkit_capture::{check_size, column_ends, placed_solid};
use fabkit_export::{NpyArray, NpyValues};
use fabkit_files::Error;
use fabkit_geometry::{Lighting, Marker, Rgb, Sensor, Vector3, VisibleEffect};
use fabkit_optics::ViewStacks;
use fabkit_scene::SceneError;
use fabkit_scene::ground_truth::{Viewpoint, project_points};
use scaling::Scaling;
use spot_detection::{Blob, MarkerSignal, MarkerSize, SignalImage, darkness_weights};

use super::{CapturedImage, ReconstructError, check_has_colours};

/// Minimum strength of a spot at rest, relative to the median of nearby markers.
const LEAST_OF_MEDIAN: f64 = 0.25;
/// Minimum strength of a spot in further images, relative to that of the marker at rest.
const LEAST_OF_REST: f64 = 0.35;
/// Minimum strength of a spot in standard deviations of the noise: noise alone exceeds it once in a thousand million
/// pixels.
const NOISES: f64 = 6.0;
/// Distance below which two spots are the same, relative to the distance between markers.
const SAME_SPOT: f64 = 0.35;
/// Minimum share of the expected markers in an image at rest.
const LEAST_FOUND: f64 = 0.5;
/// Half width of the surroundings over which brightness is averaged, in distances between markers.
const EVEN_PITCHES: f64 = 1.0;
/// Minimum determinant of a marker's projection, relative to its larger column squared. Below, pixel displacements do
/// not determine the movement.
const LEAST_SLOPE: f64 = 0.05;

/// Tracker of a sensor's markers, calibrated with the image at rest.
///
/// ```
/// use std::path::Path;
///
/// use fabkit_capture::plausibility::{ExpectedLight, ImageGate};
/// use fabkit_reconstruct::{CapturedImage, MarkerTracker};
/// # use fabkit_capture::find_lighting;
/// # use fabkit_optics::ViewStacks;
/// # use fabkit_scene::ground_truth::{Viewpoint, project_points};
///
/// # let yaml = fabkit_designs::builtin_yaml("gelsight-like").ok_or("no such sensor")?;
/// # let sensor = &fabkit_designs::load("gelsight-like.yaml", yaml, &[], &["fixtures"])?.sensor;
/// # let viewpoint = Viewpoint::new(&sensor.camera, None, None)?.resized([320, 240])?;
/// # let sights = ViewStacks::new(viewpoint.stack(sensor)?);
/// # let places: Vec<_> = sensor.marks.iter().map(|mark| Some(mark.point)).collect();
/// # let dots = project_points(&viewpoint, &sights, &places);
/// # let image = |right_px: f64| {
/// #     let ink = |i: usize| {
/// #         let [x, y] = [i / 3 % 320, i / 3 / 320].map(|px| px as f64);
/// #         let square = |dot: &[f64; 2]| (dot[0] + right_px - x).powi(2) + (dot[1] - y).powi(2);
/// #         let nearest = dots.iter().flatten().map(square).fold(f64::INFINITY, f64::min);
/// #         (4.5 - nearest.sqrt()).clamp(0.0, 1.0) as f32
/// #     };
/// #     let values = (0..3 * 320 * 240).map(|i| 0.6 - 0.5 * ink(i)).collect();
/// #     CapturedImage { size_px: [320, 240], channels: 3, values }
/// # };
/// // `image` draws dark dots where the camera sees them, so many pixels further right.
/// let lighting = find_lighting(sensor, None)?;
/// // Images pass a gate first.
/// let expected = ExpectedLight::from_markers([320, 240]);
/// let gate = ImageGate::new(expected, Path::new("rest.png"), image(0.0))?.accept()?;
/// let tracker = MarkerTracker::new(sensor, &viewpoint, lighting, gate.reference())?;
/// let moved = gate.check(Path::new("moved.png"), image(2.0))?.accept()?;
/// let followed = tracker.follow(&moved)?;
/// assert_eq!((tracker.names().len(), followed.found()), (63, 63));
/// let moved_px = tracker.displacements_px(&followed);
/// assert!(moved_px.iter().flatten().all(|[x, y]| (x - 2.0).abs() < 0.1 && y.abs() < 0.1));
/// // With 320 columns, a pixel is 0.06 mm on the surface.
/// let moved_mm = tracker.displacements_mm(&followed)[31].ok_or("lost")?;
/// assert!((moved_mm.norm() - 0.12).abs() < 0.02);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct MarkerTracker {
    size_px: [usize; 2],
    is_colored: bool,
    names: Vec<String>,
    drawn_px: Vec<Option<Px>>,
    rest_px: Vec<Option<Px>>,
    /// Displacement along the surface, sensor frame, mm, per pixel along columns and along rows.
    mm_per_px: Vec<Option<[Vector3<f64>; 2]>>,
    by: Detector,
}

#[derive(Clone, Debug)]
enum Detector {
    Spots(Box<SpotTracker>),
    Columns(ColumnTracker),
}

/// Positions of markers in an image, in the order of the description.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackedMarkers {
    /// Column and row of each marker, px; `None` if it is not found.
    pub px: Vec<Option<[f64; 2]>>,
}

impl TrackedMarkers {
    /// Returns the number of markers found.
    pub fn found(&self) -> usize {
        self.px.iter().flatten().count()
    }
}

/// Returns the reason why a lighting shows no markers; `None` if it shows some.
///
/// ```
/// use fabkit_reconstruct::why_markers_hidden;
///
/// # let yaml = fabkit_designs::builtin_yaml("uvdtact").ok_or("no such sensor")?;
/// # let design = fabkit_designs::load("uvdtact.yaml", yaml, &[], &["fixtures"])?;
/// let sensor = &design.sensor;
/// let [white, uv] = &sensor.lightings[..] else { return Err("two lightings".into()) };
/// assert_eq!(why_markers_hidden(sensor, uv), None);
/// let why = why_markers_hidden(sensor, white).ok_or("shown")?;
/// assert_eq!(why, "marks of `uvdtact` do not show in `white` light, but in `uv`");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn why_markers_hidden(sensor: &Sensor, lighting: &Lighting) -> Option<String> {
    let shows = |lighting: &Lighting| match &lighting.effect {
        VisibleEffect::LiquidColumns { columns, .. } => !columns.is_empty(),
        VisibleEffect::Thickness { .. } => false,
        VisibleEffect::Fluorescence { layers } => {
            !sensor.marks.is_empty() && marker_layer(sensor, layers).is_some()
        }
        VisibleEffect::Slopes { .. } | VisibleEffect::Markers { .. } => !sensor.marks.is_empty(),
    };
    if shows(lighting) {
        return None;
    }
    let others: Vec<String> = sensor
        .lightings
        .iter()
        .filter(|other| shows(other))
        .map(|other| format!("`{}`", other.name))
        .collect();
    let name = &sensor.name;
    Some(match &others[..] {
        [] => format!("`{name}` has no markers to track"),
        _ => format!(
            "markers of `{name}` do not show in `{}` light, but in {}",
            lighting.name,
            others.join(" and ")
        ),
    })
}

impl MarkerTracker {
    /// Creates a tracker from a sensor, the camera of this lighting, and the image at rest.
    ///
    /// # Errors
    /// Returns an error for a lighting that shows no markers, and for an image that has another size, lacks required
    /// colours or shows less than half of the expected markers.
    pub fn new(
        sensor: &Sensor,
        viewpoint: &Viewpoint,
        lighting: &Lighting,
        checked: &CheckedImage,
    ) -> Result<Self, Error> {
        if let Some(why) = why_markers_hidden(sensor, lighting) {
            return Err(ReconstructError::NoMarkersShown { why }.into());
        }
        let camera = viewpoint.camera();
        let size_px = [camera.width_px(), camera.height_px()].map(|px| px as usize);
        let (file, reference) = (checked.file(), checked.image());
        check_size(file, reference, size_px)?;
        let is_colored = lighting.is_colored();
        if is_colored {
            check_has_colours(checked)?;
        }
        let mut seen = sensor.clone();
        // Refraction must be that of the camera of this lighting.
        seen.camera = lighting.camera.clone().unwrap_or(seen.camera);
        let sights = ViewStacks::new(viewpoint.stack(&seen).map_err(SceneError::Light)?);
        let look = |places: &[_]| project_points(viewpoint, &sights, places);
        let (by, names, drawn_px, rest_px, mm_per_px);
        match &lighting.effect {
            VisibleEffect::LiquidColumns { columns, .. } => {
                let ends = column_ends(columns, &[]);
                names = ends.iter().map(|end| end.mark.name.clone()).collect();
                let places = ColumnTracker::reference_points(columns);
                let known = ColumnTracker::new(columns, &look(&places));
                drawn_px = known.drawn_px();
                rest_px = known.ends_px(reference);
                mm_per_px = known.mm_per_px();
                by = Detector::Columns(known);
            }
            shows => {
                let marks = &sensor.marks;
                names = marks.iter().map(|mark| mark.name.clone()).collect();
                let drawn: Vec<Option<ProjectedMarker>> =
                    project_markers(marks, |places| project_points(viewpoint, &sights, places));
                drawn_px = drawn.iter().map(|drawn| Some(drawn.as_ref()?.at)).collect();
                mm_per_px = drawn.iter().map(|drawn| drawn.as_ref()?.mm_per_px()).collect();
                let radii_px: Vec<f64> =
                    drawn.iter().map(|drawn| drawn.as_ref().map_or(0.0, |d| d.radius_px)).collect();
                let light = (sensor, shows);
                let spots = SpotTracker::at_rest(light, (&drawn_px, &radii_px), size_px, reference);
                rest_px = spots.rest.at().to_vec();
                by = Detector::Spots(Box::new(spots));
            }
        }
        let own = Self { size_px, is_colored, names, drawn_px, rest_px, mm_per_px, by };
        let [found, of] = [&own.rest_px, &own.drawn_px].map(|px| px.iter().flatten().count());
        // Without expected markers the share is undefined; finding none is an error in any case.
        if found == 0 || (found as f64) < LEAST_FOUND * of as f64 {
            return Err(ReconstructError::TooFewMarkers { file: file.to_owned(), found, of }.into());
        }
        Ok(own)
    }

    /// Returns the width and height of images, px.
    pub fn size_px(&self) -> [usize; 2] {
        self.size_px
    }

    /// Returns the names as in the description; a marker's number is its place in this list, from 1.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Returns the expected pixels of the markers by design and calibration; `None` outside the image.
    pub fn drawn_px(&self) -> &[Option<[f64; 2]>] {
        &self.drawn_px
    }

    /// Returns the pixels of the markers at rest; `None` for those not found, which are not tracked.
    pub fn rest_px(&self) -> &[Option<[f64; 2]>] {
        &self.rest_px
    }

    /// Tracks the markers in an image.
    ///
    /// # Errors
    /// Returns an error for an image that has another size or lacks required colours.
    pub fn follow(&self, checked: &CheckedImage) -> Result<TrackedMarkers, Error> {
        let image = checked.image();
        check_size(checked.file(), image, self.size_px)?;
        if self.is_colored {
            check_has_colours(checked)?;
        }
        let px = match &self.by {
            Detector::Spots(spots) => spots.follow(image),
            Detector::Columns(columns) => {
                let ends = columns.ends_px(image);
                // Without a position at rest there is no displacement.
                ends.into_iter()
                    .zip(&self.rest_px)
                    .map(|(end, rest)| end.filter(|_| rest.is_some()))
                    .collect()
            }
        };
        Ok(TrackedMarkers { px })
    }

    /// Returns the displacement of each marker from rest along columns and rows, px.
    pub fn displacements_px(&self, followed: &TrackedMarkers) -> Vec<Option<[f64; 2]>> {
        let both = followed.px.iter().zip(&self.rest_px);
        both.map(|(now, rest)| Some(subtract(now.as_ref()?, rest.as_ref()?))).collect()
    }

    /// Returns the displacement of each marker along the surface on which it lies at rest, or along its column, sensor
    /// frame, mm. The component that an image does not show is taken as 0.
    pub fn displacements_mm(&self, followed: &TrackedMarkers) -> Vec<Option<Vector3<f64>>> {
        let moved = self.displacements_px(followed).into_iter().zip(&self.mm_per_px);
        moved
            .map(|(px, per_px)| {
                let ([dx, dy], [x, y]) = (px?, per_px.as_ref()?);
                Some(dx * x + dy * y)
            })
            .collect()
    }

    /// Returns arrays for `numpy.load`, for N markers in the order of the description: `mark_id`, from 1; `mark_name`;
    /// `mark_drawn_px`, `mark_rest_px`, `mark_px`, `mark_moved_px`, N x 2; `mark_moved_mm`, N x 3, sensor frame;
    /// `mark_seen`. Unknown values are NaN.
    pub fn arrays(&self, followed: &TrackedMarkers) -> Vec<NpyArray> {
        let count = self.names.len();
        let array = |name: &str, width: Option<usize>, values| NpyArray {
            name: name.to_owned(),
            shape: [count].into_iter().chain(width).collect(),
            values,
        };
        let px = |name: &str, px: &[Option<Px>]| {
            let values = px.iter().flat_map(|px| px.unwrap_or([f64::NAN; 2])).collect();
            array(name, Some(2), NpyValues::F64(values))
        };
        let unknown = Vector3::repeat(f64::NAN);
        let mm = self.displacements_mm(followed);
        let mm = mm.into_iter().flat_map(|mm| <[f64; 3]>::from(mm.unwrap_or(unknown))).collect();
        let number = |i: usize| u16::try_from(i + 1).unwrap_or(u16::MAX);
        vec![
            array("mark_id", None, NpyValues::U16((0..count).map(number).collect())),
            array("mark_name", None, NpyValues::Text(self.names.clone())),
            px("mark_drawn_px", &self.drawn_px),
            px("mark_rest_px", &self.rest_px),
            px("mark_px", &followed.px),
            px("mark_moved_px", &self.displacements_px(followed)),
            array("mark_moved_mm", Some(3), NpyValues::F64(mm)),
            array(
                "mark_seen",
                None,
                NpyValues::Bool(followed.px.iter().map(Option::is_some).collect()),
            ),
        ]
    }

    /// Measures the number of images that one core tracks per second, without decoding: the fastest of several runs.
    ///
    /// # Errors
    /// Returns the errors of [`Self::follow`].
    pub fn measure_images_per_s(&self, image: &CheckedImage) -> Result<f64, Error> {
        const RUNS: usize = 5;
        let mut fastest_s = f64::INFINITY;
        for _ in 0..RUNS {
            let start = Instant::now();
            std::hint::black_box(self.follow(image)?);
            fastest_s = fastest_s.min(start.elapsed().as_secs_f64());
        }
        Ok(fastest_s.recip())
    }
}

/// A marker as projected from the design.
struct ProjectedMarker {
    at: Px,
    radius_px: f64,
    /// Two unit tangents of the surface at the marker, and the change of its pixel along each, px / mm.
    along: [(Vector3<f64>, Px); 2],
}

impl ProjectedMarker {
    fn mm_per_px(&self) -> Option<[Vector3<f64>; 2]> {
        let [(first, a), (second, b)] = &self.along;
        // Inverse of the 2 x 2 Jacobian, whose columns are `a` and `b`.
        let det = a[0] * b[1] - a[1] * b[0];
        let longer = (a[0].hypot(a[1])).max(b[0].hypot(b[1]));
        if det.abs() < LEAST_SLOPE * longer * longer {
            return None;
        }
        let of =
            |x: f64, y: f64| ((x * b[1] - y * b[0]) * first + (y * a[0] - x * a[1]) * second) / det;
        Some([of(1.0, 0.0), of(0.0, 1.0)])
    }
}

fn project_markers(
    marks: &[Marker],
    look: impl Fn(&[Option<fabkit_geometry::Point3<f64>>]) -> Vec<Option<Px>>,
) -> Vec<Option<ProjectedMarker>> {
    let ways = |mark: &Marker| {
        let first = mark.axis.cross(&Vector3::ith(mark.axis.iamin(), 1.0)).normalize();
        [first, mark.axis.cross(&first)]
    };
    let places: Vec<_> = marks
        .iter()
        .flat_map(|mark| {
            let [first, second] = ways(mark).map(|way| Some(mark.point + mark.radius_mm * way));
            [Some(mark.point), first, second]
        })
        .collect();
    let pixels = look(&places);
    let drawn = |(mark, pixels): (&Marker, &[Option<Px>])| {
        let &[at, first, second] = pixels else { return None };
        let at = at?;
        let moved = [first, second].map(|px| Some(subtract(&px?, &at)));
        let [Some(first), Some(second)] = moved else { return None };
        let radius_px = 0.5 * [first, second].map(|[x, y]| x.hypot(y)).iter().sum::<f64>();
        let [along, across] = ways(mark);
        let per_mm = |px: Px| px.map(|px| px / mark.radius_mm);
        Some(ProjectedMarker {
            at,
            radius_px,
            along: [(along, per_mm(first)), (across, per_mm(second))],
        })
    };
    marks.iter().zip(pixels.chunks_exact(3)).map(drawn).collect()
}

/// Returns the index of the glowing layer that the markers are made of.
fn marker_layer(sensor: &Sensor, layers: &[(String, Rgb)]) -> Option<usize> {
    let solids: Vec<_> =
        layers.iter().filter_map(|(layer, _)| placed_solid(sensor.body(layer)?).ok()).collect();
    let within = |mark: &Marker| {
        // The point lies inside the marker's body, half a radius below its tip.
        let place = mark.point - 0.5 * mark.radius_mm * mark.axis;
        solids.iter().position(|solid| solid.contains(&place))
    };
    sensor.marks.iter().find_map(within)
}

/// Tracker of markers that appear as spots.
#[derive(Clone, Debug)]
struct SpotTracker {
    scaling: Scaling,
    tells: MarkerSignal,
    sizes: Vec<MarkerSize>,
    rest: Pattern,
    /// Strength of each spot at rest.
    strengths: Vec<f64>,
    /// Appearance at rest of markers that throw shadows; empty where markers are even spots.
    looks: Vec<Option<Appearance>>,
}

impl SpotTracker {
    fn at_rest(
        (sensor, shows): (&Sensor, &VisibleEffect),
        (drawn_px, radii_px): (&[Option<Px>], &[f64]),
        size_px: [usize; 2],
        reference: &CapturedImage,
    ) -> Self {
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
        let sizes: Vec<MarkerSize> = radii_px
            .iter()
            .zip(drawn.pitch_px())
            .map(|(radius_px, pitch_px)| MarkerSize { radius_px: *radius_px, pitch_px: *pitch_px })
            .collect();
        let said = SignalImage::new(&scaling, &tells, &values, reference.channels);
        let strongest = |(i, at): (usize, Px)| {
            let size = sizes[i];
            let near = said.find_maxima(&at, 0.5 * size.pitch_px, size, 0.0);
            near.iter().map(|blob| blob.strength).fold(0.0, f64::max)
        };
        let mut strongest_of = vec![0.0; sizes.len()];
        known().for_each(|(i, at)| strongest_of[i] = strongest((i, at)));
        // Light falls off over the surface, so thresholds follow from the markers nearby.
        let least = |(i, size): (usize, &MarkerSize)| {
            let near = drawn.neighbours(i).iter().chain([&i]).map(|j| strongest_of[*j]);
            let usual = LEAST_OF_MEDIAN * median(&mut near.collect::<Vec<_>>()).unwrap_or(0.0);
            usual.max(NOISES * said.noise(*size))
        };
        let leasts: Vec<f64> = sizes.iter().enumerate().map(least).collect();
        let found = candidates(&said, &drawn, &sizes, &leasts);
        let chosen = drawn.assign(&found);
        let middles = chosen.iter().zip(&sizes);
        let middles =
            middles.map(|(chosen, size)| Some(said.spot_centre(&found[(*chosen)?], *size)));
        let rest_px: Vec<Option<Px>> = middles.collect();
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
        // From now on the measured places replace the expected ones.
        let rest = Pattern::new(rest_px, alone_px);
        Self { looks, scaling, tells, sizes, rest, strengths }
    }

    fn follow(&self, image: &CapturedImage) -> Vec<Option<Px>> {
        let values = self.scaling.values(image);
        let said = SignalImage::new(&self.scaling, &self.tells, &values, image.channels);
        let least = |(size, strength): (&MarkerSize, &f64)| {
            (LEAST_OF_REST * strength).max(NOISES * said.noise(*size))
        };
        let leasts: Vec<f64> = self.sizes.iter().zip(&self.strengths).map(least).collect();
        let found = candidates(&said, &self.rest, &self.sizes, &leasts);
        let chosen = self.rest.assign(&found);
        let evened = match &self.tells {
            MarkerSignal::Dark(counts) if !self.looks.is_empty() => {
                Some(NormalisedImage::new(&self.scaling, &values, counts))
            }
            _ => None,
        };
        let place = |(i, (chosen, size)): (usize, (&Option<usize>, &MarkerSize))| {
            let (place, rest) = (found[(*chosen)?], self.rest.at()[i]?);
            let looks = self.looks.get(i).and_then(Option::as_ref);
            let Some((looks, evened)) = looks.zip(evened.as_ref()) else {
                return Some(said.spot_centre(&place, *size));
                // With shadows, the place of the best correlation is more reliable than the centre of the dark spot.
            };
            let by = subtract(&place, &rest);
            Some(add(&rest, &looks.find_displacement(&self.scaling, evened, &by, size.pitch_px)?))
        };
        chosen.iter().zip(&self.sizes).enumerate().map(place).collect()
    }
}

/// Returns the spots that may be markers, each once and the strongest first.
fn candidates(
    said: &SignalImage<'_>,
    pattern: &Pattern,
    sizes: &[MarkerSize],
    leasts: &[f64],
) -> Vec<Px> {
    let mut all: Vec<(Blob, f64)> = Vec::new();
    for (i, at) in pattern.at().iter().enumerate() {
        let Some(at) = at else { continue };
        let pitch_px = pattern.pitch_px()[i];
        let near = said.find_maxima(at, REACH * pitch_px, sizes[i], leasts[i]);
        all.extend(near.into_iter().map(|blob| (blob, SAME_SPOT * pitch_px)));
    }
    all.sort_by(|a, b| b.0.strength.total_cmp(&a.0.strength));
    let mut kept: Vec<(Px, f64)> = Vec::new();
    for (blob, one_px) in all {
        let is_new =
            // Of spots that are too close to each other, only the strongest is kept.
            |(other, reach): &(Px, f64)| assignment::distance(other, &blob.at) > reach.min(one_px);
        if kept.iter().all(is_new) {
            kept.push((blob.at, one_px));
        }
    }
    kept.into_iter().map(|(at, _)| at).collect()
}

/// Returns weights that separate colours by least squares: for the sum of all, and for one.
fn colour_share(layers: &[(String, Rgb)], one: usize) -> MarkerSignal {
    let colors = DMatrix::from_fn(3, layers.len(), |k, layer| layers[layer].1[k]);
    // Layers of nearly equal colour cannot be separated, so small singular values are cut off.
    let apart = colors.pseudo_inverse(1e-6).unwrap_or_else(|_| DMatrix::zeros(layers.len(), 3));
    let row = |layer: usize| [0, 1, 2].map(|k| apart[(layer, k)]);
    let all =
        (0..layers.len()).map(row).fold([0.0; 3], |sum, row| [0, 1, 2].map(|k| sum[k] + row[k]));
    MarkerSignal::Share([all, row(one)])
}

fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}
