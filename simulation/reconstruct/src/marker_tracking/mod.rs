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
mod spot_tracking;

use std::time::Instant;

use assignment::{Px, subtract};
use column_tracking::ColumnTracker;
use fabkit_calibration::significance::{LeftOut, Significance};
use fabkit_camera::DMatrix;
use fabkit_capture::plausibility::CheckedImage;
use fabkit_capture::{check_size, column_ends, placed_solid};
use fabkit_export::{NpyArray, NpyValues};
use fabkit_files::Error;
use fabkit_geometry::{Lighting, Marker, Rgb, Sensor, Vector3, VisibleEffect};
use fabkit_optics::ViewStacks;
use fabkit_scene::SceneError;
use fabkit_scene::ground_truth::{Viewpoint, project_points};
use spot_detection::MarkerSignal;
use spot_tracking::SpotTracker;

use super::{ReconstructError, check_has_colours};

/// Minimum share of the expected markers in an image at rest.
const LEAST_FOUND: f64 = 0.5;
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
    rest: TrackedMarkers,
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

/// A marker that is found in an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackedMarker {
    /// Column and row, px.
    pub px: [f64; 2],
    /// Contrast in standard deviations of the image's noise.
    pub significance: Significance,
}

/// Markers in an image, in the order of the description, and what was left out of it.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackedMarkers {
    /// Each marker; `None` if it is not found.
    pub markers: Vec<Option<TrackedMarker>>,
    /// Spots near markers that are not found, which are too faint to be told from noise or from uneven light.
    pub left_out: LeftOut,
}

impl TrackedMarkers {
    /// Returns the number of markers found.
    pub fn found(&self) -> usize {
        self.markers.iter().flatten().count()
    }

    /// Returns the column and row of each marker, px.
    pub fn px(&self) -> Vec<Option<[f64; 2]>> {
        self.markers.iter().map(|marker| Some(marker.as_ref()?.px)).collect()
    }

    /// Returns the significance of the least significant marker.
    pub fn least_significance(&self) -> Option<Significance> {
        let all = self.markers.iter().flatten().map(|marker| marker.significance);
        all.min_by(|a, b| a.sigmas().total_cmp(&b.sigmas()))
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
/// assert_eq!(why, "markers of `uvdtact` do not show in `white` light, but in `uv`");
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
        let (by, names, drawn_px, rest, mm_per_px);
        match &lighting.effect {
            VisibleEffect::LiquidColumns { columns, .. } => {
                let ends = column_ends(columns, &[]);
                names = ends.iter().map(|end| end.mark.name.clone()).collect();
                let places = ColumnTracker::reference_points(columns);
                let known = ColumnTracker::new(columns, &look(&places));
                drawn_px = known.drawn_px();
                rest = known.find_ends(reference);
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
                let spots;
                (spots, rest) =
                    SpotTracker::at_rest(light, (&drawn_px, &radii_px), size_px, reference);
                by = Detector::Spots(Box::new(spots));
            }
        }
        let rest_px = rest.px();
        let own = Self { size_px, is_colored, names, drawn_px, rest, rest_px, mm_per_px, by };
        let [found, of] = [&own.rest_px, &own.drawn_px].map(|px| px.iter().flatten().count());
        // Without expected markers the share is undefined; finding none is an error in any case.
        if found == 0 || (found as f64) < LEAST_FOUND * of as f64 {
            let (file, left_out) = (file.to_owned(), own.rest.left_out);
            return Err(ReconstructError::TooFewMarkers { file, found, of, left_out }.into());
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

    /// Returns the markers at rest, and what was left out there.
    pub fn rest(&self) -> &TrackedMarkers {
        &self.rest
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
        Ok(match &self.by {
            Detector::Spots(spots) => spots.follow(image),
            Detector::Columns(columns) => {
                let TrackedMarkers { markers, left_out } = columns.find_ends(image);
                let both = markers.into_iter().zip(&self.rest_px);
                // Without a position at rest there is no displacement.
                let markers = both.map(|(end, rest)| end.filter(|_| rest.is_some())).collect();
                TrackedMarkers { markers, left_out }
            }
        })
    }

    /// Returns the displacement of each marker from rest along columns and rows, px.
    pub fn displacements_px(&self, followed: &TrackedMarkers) -> Vec<Option<[f64; 2]>> {
        let both = followed.markers.iter().zip(&self.rest_px);
        both.map(|(now, rest)| Some(subtract(&now.as_ref()?.px, rest.as_ref()?))).collect()
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
    /// `mark_seen`; `mark_significance`, in standard deviations of the noise, 0 for markers not found. Other unknown values
    /// are NaN.
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
        let sigmas = |marker: &Option<TrackedMarker>| {
            marker.as_ref().map_or(0.0, |marker| marker.significance.sigmas())
        };
        let sigmas = followed.markers.iter().map(sigmas).collect();
        let number = |i: usize| u16::try_from(i + 1).unwrap_or(u16::MAX);
        vec![
            array("mark_id", None, NpyValues::U16((0..count).map(number).collect())),
            array("mark_name", None, NpyValues::Text(self.names.clone())),
            px("mark_drawn_px", &self.drawn_px),
            px("mark_rest_px", &self.rest_px),
            px("mark_px", &followed.px()),
            px("mark_moved_px", &self.displacements_px(followed)),
            array("mark_moved_mm", Some(3), NpyValues::F64(mm)),
            array(
                "mark_seen",
                None,
                NpyValues::Bool(followed.markers.iter().map(Option::is_some).collect()),
            ),
            array("mark_significance", None, NpyValues::F64(sigmas)),
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
