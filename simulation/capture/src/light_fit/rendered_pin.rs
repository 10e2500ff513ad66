//! Pins as `capture` renders them: the same rays, layers and lateral spread as in its images.

use std::sync::Arc;

use fabkit_camera::{Camera, Interface, Point2};
use fabkit_depth::ground_truth::{PixelRays, PlacedIndenter, ReferenceSurface};
use fabkit_files::Error;
use fabkit_fixtures::PressBody;
use fabkit_geometry::{Lighting, Point3, Pose, Sensor, Solid, TouchSurface, Vector3};
use fabkit_optics::{CameraView, OpticalStack, ViewStacks};
use fabkit_scene::press_simulation::{ElasticSolver, resources};

use super::profiles::{BINS, LocalScale, REACH_MM};
use super::{FitLightError, SPACING_MM};
use crate::layers::LayerHits;
use crate::{LayerScene, LightConstants};

/// Length of the pin's shaft, mm.
const PIN_MM: f64 = 8.0;
/// Largest number of pixels along a side of a rendered part. Images with more are rendered smaller: a part of 6 mm is
/// then resolved to 0.06 mm, a quarter of a bin.
const MOST_PX: f64 = 110.0;
/// Largest width or height at which the whole image is traced for the distance of its pixels on the surface.
const MOST_WHOLE_PX: u32 = 960;
/// Part of its greatest darkness above which a place belongs to a mark. Marks are found at half their contrast in real
/// captures as well.
const MARK_SHARE: f64 = 0.5;

/// Renders single pins through a sensor's drawn bodies and layers, seen by a calibrated lens at the drawn pose.
pub(super) struct PinRenderer<'a> {
    touch: &'a TouchSurface,
    camera: Camera,
    sensor_from_camera: Pose,
    sights: Arc<ViewStacks>,
    layers: LayerScene<'a>,
    /// Width of the pixels of the traced whole image, in those of the real one.
    traced_larger: f64,
    ready: ElasticSolver,
    constants: &'a LightConstants,
}

/// One pin, rendered for any constants of light.
#[derive(Clone, Debug)]
pub(super) struct RenderedPin {
    rest: LayerHits,
    pressed: LayerHits,
    /// Bin of each pixel by its distance from the mark; beyond the last bin there are more numbers.
    bin_of_pixel: Vec<usize>,
}

impl<'a> PinRenderer<'a> {
    /// Makes the renderer. `constants` hold no exposure of their own, as those of a unit.
    pub(super) fn new(
        sensor: &'a Sensor,
        lighting: &'a Lighting,
        lens: &Camera,
        constants: &'a LightConstants,
    ) -> Result<Self, Error> {
        let layers = LayerScene::new(sensor, lighting, constants)?;
        let touch = layers.scene.touch;
        let stack = OpticalStack::from_sensor(sensor).map_err(Error::bug)?;
        let sights = Arc::new(ViewStacks::new(stack));
        let sensor_from_camera = sensor.camera.sensor_from_camera;
        let size = [lens.width_px(), lens.height_px()];
        let camera = Camera::new(size[0], size[1], *lens.lens(), Interface::FromDrawing);
        let camera = camera.map_err(Error::bug)?;
        let traced_larger = size[0].max(size[1]).div_ceil(MOST_WHOLE_PX).max(1);
        let traced = camera.resized(size.map(|px| (px / traced_larger).max(1)));
        let traced = traced.map_err(Error::bug)?;
        let rays = PixelRays::new(&traced, &sensor_from_camera).traced_through(&sights);
        let whole = ReferenceSurface::cast(touch, &rays).map_err(Error::bug)?;
        // As in images, one distance of pixels holds for the whole surface.
        let layers = layers.for_crops_of(&whole.map_without_contact());
        let ready = ElasticSolver::for_any_press(sensor, Some(SPACING_MM), false, resources())?;
        let traced_larger = f64::from(traced_larger);
        Ok(Self {
            touch,
            camera,
            sensor_from_camera,
            sights,
            layers,
            traced_larger,
            ready,
            constants,
        })
    }

    /// Presses a pin with a round tip along the normal into a place of the surface.
    ///
    /// # Errors
    /// A place that the camera does not see; a press that the layers do not stand.
    pub(super) fn render(
        &self,
        surface: &Point3<f64>,
        [radius_mm, depth_mm]: [f64; 2],
    ) -> Result<RenderedPin, Error> {
        let (_, outward) = self.touch.depth_mm(surface);
        let pin = PressBody {
            name: "pin".to_owned(),
            solid: Solid::union([Solid::sphere(radius_mm), Solid::cylinder(radius_mm, PIN_MM)]),
            sensor_from_body: Pose::z_to(outward, surface + (radius_mm - depth_mm) * outward),
        };
        let part = self.part_around(surface, &outward).ok_or(FitLightError::NoFit)?;
        let rays = PixelRays::new(&part.camera, &self.sensor_from_camera);
        let rays = rays.traced_through(&self.sights);
        let seen = ReferenceSurface::cast(self.touch, &rays).map_err(Error::bug)?;
        let indenter = PlacedIndenter::new(pin.name.clone(), &pin.solid, pin.sensor_from_body);
        let indenter = indenter.map_err(Error::bug)?;
        let answer = self.ready.solve_contact(self.touch, &[pin], [0.0; 2], None)?;
        let rest = self.layers.hits(&seen.map_without_contact(), None);
        let pressed =
            self.layers.hits(&seen.map_deformed(&[indenter], &answer, false), Some(&answer));
        let larger = part.larger / self.traced_larger;
        let [rest, pressed] = [rest, pressed].map(|hits| hits.with_larger_pixels(larger));
        let mut pin = RenderedPin { rest, pressed, bin_of_pixel: Vec::new() };
        let darker = self.darker(&pin, self.constants);
        let width = part.camera.width_px() as usize;
        let middle = mark(&darker, width).ok_or(FitLightError::NoFit)?;
        pin.bin_of_pixel = (0..darker.len())
            .map(|i| part.scale.bin(Point2::new((i % width) as f64, (i / width) as f64) - middle))
            .collect();
        Ok(pin)
    }

    /// Returns the loss of intensity against rest by distance from the mark.
    pub(super) fn profile(&self, pin: &RenderedPin, constants: &LightConstants) -> Vec<f64> {
        let (mut sums, mut counts) = ([0.0; BINS], [0.0; BINS]);
        for (darker, bin) in self.darker(pin, constants).iter().zip(&pin.bin_of_pixel) {
            if *bin < BINS {
                sums[*bin] += darker;
                counts[*bin] += 1.0;
            }
        }
        (0..BINS).map(|bin| sums[bin] / counts[bin]).collect()
    }

    fn darker(&self, pin: &RenderedPin, constants: &LightConstants) -> Vec<f64> {
        self.layers.grey_lost(constants, &pin.rest, &pin.pressed)
    }

    /// Returns the part of the image around a place; `None` if the camera does not see all of it.
    fn part_around(&self, surface: &Point3<f64>, outward: &Vector3<f64>) -> Option<ImagePart> {
        let lens = self.camera.without_interface();
        let pixel = |lens: &Camera, place: &Point3<f64>| {
            let mut view = CameraView::new(lens, &self.sensor_from_camera, &self.sights);
            Some(view.project(place).ok()?.pixel)
        };
        let scale = LocalScale::at(surface, outward, |place| pixel(&lens, place))?;
        let larger = (2.0 * scale.reach_px(REACH_MM) / MOST_PX).ceil().max(1.0);
        let size = [lens.width_px(), lens.height_px()];
        let small = size.map(|px| (f64::from(px) / larger).round() as u32);
        let camera = self.camera.resized(small).ok()?;
        let lens = camera.without_interface();
        let middle = pixel(&lens, surface)?;
        let scale = LocalScale::at(surface, outward, |place| pixel(&lens, place))?;
        let reach_px = scale.reach_px(REACH_MM);
        let ends = [0, 1].map(|axis| {
            let most = f64::from(small[axis]);
            let from = (middle[axis] - reach_px).floor().max(0.0);
            [from, (middle[axis] + reach_px).ceil().min(most)].map(|px| px as u32)
        });
        if ends.iter().any(|[from, to]| to <= from) {
            return None;
        }
        let camera = camera.cropped(ends.map(|[from, _]| from), ends.map(|[from, to]| to - from));
        Some(ImagePart { camera: camera.ok()?, scale, larger })
    }
}

/// Part of an image, around a pin.
struct ImagePart {
    camera: Camera,
    scale: LocalScale,
    /// Width of its pixels, in those of the real image.
    larger: f64,
}

/// Returns the pixel in the middle of a mark; `None` if nothing is darker.
fn mark(darker: &[f64], width: usize) -> Option<Point2<f64>> {
    let most = darker.iter().copied().fold(0.0, f64::max);
    let (mut sum, mut count) = (Point2::origin().coords, 0.0);
    for (i, _) in darker.iter().enumerate().filter(|(_, grey)| **grey > MARK_SHARE * most) {
        sum += Point2::new((i % width) as f64, (i / width) as f64).coords;
        count += 1.0;
    }
    (count > 0.0).then(|| Point2::from(sum / count))
}
