//! The drawn light of a sensor at rest, as its camera sees it in cells.

use fabkit_depth::ground_truth::NO_LABEL;
use fabkit_files::Error;
use fabkit_geometry::{
    Assembly, BodyKind, CompiledSolid, Lighting, Point3, Ray, Scratch, Sensor, TouchSurface,
    Vector3,
};
use fabkit_scene::press_simulation::ContactModel;
use fabkit_scene::{Cast, SensorView};

use super::cells::{Cells, grid_size};
use crate::{CaptureRequest, CapturedImage, LightConstants, surface_middle};

/// Number of rays along each side of a cell, so that printed marks weigh as in the mean of a real image.
const SAMPLES: u32 = 4;
/// Intensity of a value of 1 in an image.
const WHITE: f64 = 255.0;
/// Smallest cosine between ray and normal. Flatter rays are treated as if they had it.
const LEAST_COSINE: f64 = 0.2;

/// Gap below which a body continues the one before, mm.
const JOINT_MM: f64 = 1e-3;

/// Drawn light of a sensor at rest, for comparison with images.
///
/// ```
/// # use fabkit_capture::{LightConstants, find_lighting};
/// use fabkit_capture::plausibility::ExpectedLight;
/// # let yaml = fabkit_designs::builtin_yaml("9dtact").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("9dtact.yaml", yaml, &[])?;
/// # let viewpoint = fabkit_scene::ground_truth::Viewpoint::new(&project.design.sensor.camera, None, None)?;
/// # let scene = fabkit_scene::SensorView::new(std::sync::Arc::new(project), viewpoint)?;
/// // `scene` is the view of a 9DTact by its camera with 640 x 480 pixels.
/// let sensor = &scene.project.design.sensor;
/// let constants = LightConstants::for_sensor(sensor);
/// let expected = ExpectedLight::render(&scene, find_lighting(sensor, None)?, &constants);
/// assert_eq!(expected.size_px(), [640, 480]);
/// assert_eq!(expected.why_unknown(), None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct ExpectedLight {
    pub(super) size_px: [usize; 2],
    pub(super) drawn: Result<DrawnLight, String>,
    /// Whether images consist of markers that move.
    pub(super) has_moving_markers: bool,
}

/// Light and layers in each cell.
#[derive(Clone, Debug)]
pub(super) struct DrawnLight {
    pub cells: Cells,
    /// Whether all rays of a cell see the surface.
    pub is_surface: Vec<bool>,
    /// Depth along the ray at which the soft layers end, mm.
    pub limit_mm: Vec<f64>,
    pub is_colored: bool,
}

impl ExpectedLight {
    /// Renders the drawn light, with few pixels. Light that cannot be rendered is not known, with the reason.
    pub fn render(view: &SensorView, lighting: &Lighting, constants: &LightConstants) -> Self {
        let camera = view.viewpoint.camera();
        let size_px = [camera.width_px(), camera.height_px()];
        Self {
            size_px: size_px.map(|px| px as usize),
            drawn: DrawnLight::render(view, lighting, constants, grid_size(size_px))
                .map_err(|error| error.to_string()),
            has_moving_markers: false,
        }
    }

    /// Expects images of a size, whose light is not known for this reason.
    pub fn unknown(size_px: [usize; 2], why: &str) -> Self {
        Self { size_px, drawn: Err(why.to_owned()), has_moving_markers: false }
    }

    /// Expects images of a size that show markers alone. Their places are compared where they are tracked.
    ///
    /// ```
    /// use fabkit_capture::plausibility::ExpectedLight;
    /// let expected = ExpectedLight::from_markers([30, 30]);
    /// assert!(expected.why_unknown().is_some_and(|why| why.contains("markers")));
    /// ```
    pub fn from_markers(size_px: [usize; 2]) -> Self {
        let why = "this light shows markers, whose places are compared instead";
        Self { has_moving_markers: true, ..Self::unknown(size_px, why) }
    }

    /// Returns the number of columns and rows of images, px.
    pub fn size_px(&self) -> [usize; 2] {
        self.size_px
    }

    /// Returns the reason why the light is not known; `None` if it is.
    pub fn why_unknown(&self) -> Option<&str> {
        self.drawn.as_ref().err().map(String::as_str)
    }
}

impl DrawnLight {
    fn render(
        view: &SensorView,
        lighting: &Lighting,
        constants: &LightConstants,
        cells_px: [u32; 2],
    ) -> Result<Self, Error> {
        let small = view.resized(cells_px)?;
        let soft = SoftBodies::new(&view.project.design.sensor).map_err(Error::bug)?;
        // A pad is as thick as in its middle; through its sides, the whole pad lies behind each other.
        let touch = view.touch()?;
        let of_pad_mm = match touch {
            TouchSurface::Plane(_) => {
                surface_middle(touch).map(|(middle, outward)| soft.thickness_mm(&middle, &outward))
            }
            TouchSurface::Dome(_) => None,
        };
        let cast = Cast { samples: SAMPLES, ..Cast::at_rest(ContactModel::Rigid) };
        let request = CaptureRequest { cast, lighting, constants, seed: None };
        let size = cells_px.map(|count| count as usize);
        let mut is_surface = vec![true; size[0] * size[1]];
        let mut limit_mm = vec![0.0f64; is_surface.len()];
        let captured = request.render(&small, 0, |seen| {
            let columns = seen.map.width_px() as usize;
            let places: Vec<_> = seen.map.point_in_sensor().collect();
            let normals = seen.map.normal_in_sensor();
            let rays = seen.map.label().iter().zip(seen.map.incidence_rad());
            for (ray, (label, incidence_rad)) in rays.enumerate() {
                let [x, y] = [ray % columns, ray / columns].map(|at| at / SAMPLES as usize);
                let cell = y * size[0] + x;
                is_surface[cell] &= *label != NO_LABEL;
                let cosine = incidence_rad.cos().abs();
                // One ray tells how thick the layers of a cell are.
                if *label != NO_LABEL && limit_mm[cell] == 0.0 && cosine.is_finite() {
                    let soft_mm =
                        of_pad_mm.unwrap_or_else(|| soft.thickness_mm(&places[ray], &normals[ray]));
                    limit_mm[cell] = soft_mm / cosine.max(LEAST_COSINE);
                }
            }
            Ok(())
        })?;
        let values = captured.grey.iter().map(|grey| (grey / WHITE).clamp(0.0, 1.0) as f32);
        let image =
            CapturedImage { size_px: size, channels: captured.channels, values: values.collect() };
        let is_colored = captured.channels == 3;
        Ok(Self { cells: Cells::from_image(&image), is_surface, limit_mm, is_colored })
    }
}

/// Cast and deformable bodies of a sensor.
struct SoftBodies(Vec<CompiledSolid>);

impl SoftBodies {
    fn new(sensor: &Sensor) -> Result<Self, fabkit_geometry::InvalidSolid> {
        let is_soft =
            |body: &&fabkit_geometry::Body| body.kind == BodyKind::Cast || body.is_deformable;
        let mut solids = Vec::new();
        for body in sensor.bodies.iter().filter(is_soft) {
            for place in body.placements.iter().filter(|p| p.assembly == Assembly::sensor()) {
                let solid = body.solid.clone().placed(place.assembly_from_body);
                solids.push(CompiledSolid::new(&solid)?);
            }
        }
        Ok(Self(solids))
    }

    /// Returns how far soft bodies adjoin each other below a point of the surface, mm. Presses end earlier where gel
    /// stiffens; this is what there is to be pressed.
    fn thickness_mm(&self, place: &Point3<f64>, outward: &Vector3<f64>) -> f64 {
        // From 1 mm outside, so that the ray crosses the surface itself.
        let ray = Ray { origin: place + outward, direction: -outward };
        let (mut scratch, mut found, mut met) = (Scratch::default(), Vec::new(), Vec::new());
        for solid in &self.0 {
            solid.stretches_into(&ray, &mut scratch, &mut found);
            met.extend(found.iter().copied());
        }
        met.sort_by(|a: &[f64; 2], b| a[0].total_cmp(&b[0]));
        let end_mm = met.iter().fold(
            1.0,
            |end: f64, [from, to]| {
                if *from < end + JOINT_MM { end.max(*to) } else { end }
            },
        );
        end_mm - 1.0
    }
}
