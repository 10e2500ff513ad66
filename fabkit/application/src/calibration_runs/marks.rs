//! Rendered offset between the mark of a pin and the pixel of its tip.
//!
//! A pin darkens the image along its flanks as well as at its tip, a slanted ray meets one flank before the other, and
//! layers are darker along longer paths. The centroid of the dark mark therefore lies outwards from the tip, by pixels
//! where the surface is steep. This offset is not an unknown of the calibration: the press of that pin is rendered
//! through the drawn layers, and the same detector finds its mark.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use fabkit_calibration::image::GreyImage;
use fabkit_calibration::landmarks::{PinLandmark, PinLandmarks};
use fabkit_calibration::model::{FitParameter, MarkOffset, MarkOffsets, Model, Observation};
use fabkit_calibration::pin_captures::PinCaptures;
use fabkit_calibration::pin_detection::{DetectionOptions, Polarity, background_cell_px, detect};
use fabkit_camera::{Camera, Interface, Point2, Vector2};
use fabkit_capture::{LayerScene, LightConstants};
use fabkit_depth::ground_truth::{PixelRays, PlacedIndenter, ReferenceSurface};
use fabkit_files::Error;
use fabkit_fixtures::halves::{body_index, is_from_halves};
use fabkit_fixtures::{PressBody, Project};
use fabkit_geometry::{Point3, Pose, Sensor, Solid, TouchSurface, Vector3, VisibleEffect};
use fabkit_optics::{CameraView, OpticalStack, ViewStacks};
use fabkit_scene::press_simulation::{ElasticSolver, resources};
use rayon::prelude::*;

/// Half the side of the window rendered around a tip, as a share of the image's shorter side. It exceeds the widest
/// mark that the detector accepts.
const WINDOW_HALF_SHARE: f64 = 0.12;
/// Length of the modelled pin, mm.
const PIN_LENGTH_MM: f64 = 8.0;
/// Intensity of the pixels outside the window: a lit surface without contact.
const SURROUNDING_INTENSITY: f64 = 128.0;
/// Margin around the window that the detector uses, px: more than the reach of its background filter. It is at least an
/// image's smallest side.
const MARGIN_PX: u32 = 64;
/// Intensity that the detector's images represent as 1.
const WHITE_INTENSITY: f64 = 255.0;

/// Relative standard deviation of an offset. In reality pins press together, not one by one, and the light differs from
/// the assumed one in more than the two fitted parameters.
const OFFSET_RELATIVE_SIGMA: f64 = 0.06;

/// Step in indentation for the finite difference of the offset, mm.
const INDENTATION_STEP_MM: f64 = 0.15;
/// Steps for the finite differences in light: factor of the layer's scattering, and additional lateral spread, mm.
const SCATTER_STEP_FACTOR: f64 = 2.0;
const SPREAD_STEP_MM: f64 = 0.15;
/// Largest deviation from the assumed light that is rendered, in prior standard deviations.
const MAX_LIGHT_SIGMAS: f64 = 2.0;
/// Smallest contrast that the detector accepts. It can be low, because rendered images have no noise.
const MIN_CONTRAST: f64 = 0.01;

/// Pressed pin, or one protrusion pressed together with the others of its half.
struct PressedPin {
    /// Position of the tip in the sensor frame, mm.
    tip: Point3<f64>,
    /// Unit direction of the press, into the sensor.
    inwards: Vector3<f64>,
    /// All bodies pressed together, and the index of this one.
    bodies: Vec<PressBody>,
    own: usize,
}

/// Shapes that press at the landmarks.
pub(super) enum LandmarkShapes<'a> {
    /// Single pins with round tips of one radius, mm.
    Pins { radius_mm: f64 },
    /// Halves: the landmarks are their protrusions, and each half presses as a whole.
    Halves { landmarks: &'a PinLandmarks, presses: BTreeMap<String, Vec<PressBody>> },
}

impl<'a> LandmarkShapes<'a> {
    /// Finds the shapes that occur in the captures; `None` if the tip radius is unknown.
    pub(super) fn find(
        project: &Project,
        landmarks: &'a PinLandmarks,
        captures: &PinCaptures<'_>,
        tip_radius_mm: f64,
    ) -> Option<Self> {
        let pins = captures.marked.iter().flat_map(|capture| &capture.pins);
        let kinds: BTreeSet<&str> = pins.map(|pin| pin.kind.as_str()).collect();
        let finder = project.press_finder();
        let press = |kind: &str| Some((kind.to_owned(), finder.press(kind).ok()?.bodies));
        if !is_from_halves(landmarks) {
            return (tip_radius_mm > 0.0).then_some(Self::Pins { radius_mm: tip_radius_mm });
        }
        let presses = kinds.into_iter().filter_map(press).collect();
        Some(Self::Halves { landmarks, presses })
    }

    /// Returns the pin or protrusion at a contact; `None` if no shape is known for it.
    fn pressed_pin(&self, tip: Point3<f64>, inwards: Vector3<f64>) -> Option<PressedPin> {
        match self {
            Self::Pins { radius_mm } => {
                let radius_mm = *radius_mm;
                let solid =
                    // The sphere is centred one radius above the tip, and the cylinder continues it outwards.
                    Solid::union([Solid::sphere(radius_mm), Solid::cylinder(radius_mm, PIN_LENGTH_MM)]);
                let sensor_from_body = Pose::z_to(-inwards, tip - radius_mm * inwards);
                let body = PressBody { name: "pin".to_owned(), solid, sensor_from_body };
                Some(PressedPin { tip, inwards, bodies: vec![body], own: 0 })
            }
            Self::Halves { landmarks, presses } => {
                // Exact comparison: the contact was copied from the same landmark.
                let is_here = |pin: &&PinLandmark| pin.contact_in_sensor_mm == tip;
                let landmark = landmarks.pins.iter().find(is_here)?;
                let bodies = presses.get(&landmark.kind)?.clone();
                let own = body_index(landmark.hole).filter(|own| *own < bodies.len())?;
                Some(PressedPin { tip, inwards, bodies, own })
            }
        }
    }
}

impl PressedPin {
    /// Returns the same press with its indentation reduced by `by_mm`.
    fn shallower(&self, by_mm: f64) -> Self {
        let out = -by_mm * self.inwards;
        let mut bodies = self.bodies.clone();
        let body = &mut bodies[self.own].sensor_from_body;
        *body = Pose::translation(out.x, out.y, out.z).then_in(*body);
        Self { tip: self.tip + out, bodies, ..*self }
    }
}

/// Renderer of pin marks through a sensor's drawn bodies and layers.
pub(super) struct PinMarkRenderer<'a> {
    touch: &'a TouchSurface,
    camera: Camera,
    sights: Arc<ViewStacks>,
    layers: LayerScene<'a>,
    ready: ElasticSolver,
    constants: &'a LightConstants,
    shapes: LandmarkShapes<'a>,
}

/// Camera pose and light for which marks are rendered.
#[derive(Clone, Copy, Debug)]
pub(super) struct RenderingView {
    pub(super) camera_from_sensor: Pose,
    /// Logarithm of the layer's scattering relative to the assumed value, and additional lateral spread of light in it,
    /// mm.
    pub(super) layer: [f64; 2],
}

impl RenderingView {
    /// Uses the assumed light.
    pub(super) fn in_assumed_light(camera_from_sensor: Pose) -> Self {
        Self { camera_from_sensor, layer: [0.0; 2] }
    }

    /// Takes pose and light from a model. Light parameters are clamped to `MAX_LIGHT_SIGMAS`: beyond that, the fit does not
    /// know them.
    pub(super) fn from_model(model: &Model) -> Self {
        let held = |value: f64, of: FitParameter| {
            let most = MAX_LIGHT_SIGMAS * of.prior_sigma();
            value.clamp(-most, most)
        };
        let [scatter, spread] = FitParameter::LIGHT;
        let layer = [held(model.layer_scatter_log, scatter), held(model.layer_spread_mm, spread)];
        Self { camera_from_sensor: model.camera_from_sensor, layer }
    }
}

impl<'a> PinMarkRenderer<'a> {
    /// Makes the renderer for a sensor that shows contact by the thickness of its layers; `None` for other sensors, or
    /// without shapes.
    ///
    /// # Errors
    /// Layers that cannot be pressed, bodies through which no light can be traced.
    pub(super) fn new(
        sensor: &'a Sensor,
        camera: &Camera,
        constants: &'a LightConstants,
        shapes: Option<LandmarkShapes<'a>>,
    ) -> Result<Option<Self>, Error> {
        let lighting = sensor.lightings.first();
        let lighting =
            lighting.filter(|light| matches!(light.effect, VisibleEffect::Thickness { .. }));
        let (Some(touch), Some(lighting), Some(shapes)) = (&sensor.touch, lighting, shapes) else {
            return Ok(None);
        };
        let lens = *camera.lens();
        let camera =
            Camera::new(camera.width_px(), camera.height_px(), lens, Interface::FromDrawing);
        let camera = camera.map_err(Error::bug)?;
        let sights =
            Arc::new(ViewStacks::new(OpticalStack::from_sensor(sensor).map_err(Error::bug)?));
        let rays =
            PixelRays::new(&camera, &sensor.camera.sensor_from_camera).traced_through(&sights);
        let whole = ReferenceSurface::cast(touch, &rays).map_err(Error::bug)?;
        let layers = LayerScene::new(sensor, lighting, constants)?;
        Ok(Some(Self {
            touch,
            camera,
            sights,
            // Brightness is normalised by the whole resting image, because the windows rendered later are only parts of
            // it.
            layers: layers.for_crops_of(&whole.map_without_contact()),
            ready: ElasticSolver::for_any_press(sensor, None, false, resources())?,
            constants,
            shapes,
        }))
    }

    /// Computes, for each distinct contact, the offset of the mark from the pixel of the tip, and its derivatives. Pins
    /// without a detected mark or a visible tip are left out. The derivative by indentation is taken from `known` where
    /// it was rendered before.
    pub(super) fn compute_offsets(
        &self,
        from: &RenderingView,
        observations: &[Observation],
        known: Option<&MarkOffsets>,
    ) -> MarkOffsets {
        let mut pins: Vec<PressedPin> = Vec::new();
        for contact in observations.iter().map(|observation| &observation.contact) {
            let place = contact.contact_in_sensor_mm;
            // Several captures may press the same pin, which is rendered once.
            if !pins.iter().any(|known| known.tip == place) {
                let inwards = contact.axis_in_sensor;
                // Without an axis of its own, a pin presses along the surface normal.
                let inwards = inwards.unwrap_or_else(|| -self.touch.depth_mm(&place).1);
                pins.extend(self.shapes.pressed_pin(place, inwards));
            }
        }
        let [scatter, spread] = from.layer;
        // The assumed light, then one light with a step in each parameter, for finite differences.
        let lights = [[0.0; 2], [SCATTER_STEP_FACTOR.ln(), 0.0], [0.0, SPREAD_STEP_MM]];
        let lights =
            lights.map(|[more, wider]| self.changed_light([scatter + more, spread + wider]));
        let of_pin = |pin: &PressedPin| {
            let known = known.and_then(|known| known.offset_at(&pin.tip));
            let by_depth = known.map(|known| known.by_depth);
            Some((pin.tip, self.compute_offset(from, pin, &lights, by_depth)?))
        };
        MarkOffsets::new(pins.par_iter().filter_map(of_pin).collect::<Vec<_>>())
    }

    /// Returns the light constants with changed scattering (logarithm of the factor) and additional spread.
    fn changed_light(&self, [scatter_log, wider_mm]: [f64; 2]) -> LightConstants {
        let mut light = self.constants.clone();
        // Keeps the brightness at rest about constant, so that nothing saturates.
        light.scatter_per_mm.value *= scatter_log.exp();
        light.layer_grey.value /= scatter_log.exp();
        light.spread_mm.value = (light.spread_mm.value + wider_mm).max(0.0);
        light
    }

    /// Computes an offset with its derivatives by finite differences, and extrapolates it linearly to the assumed
    /// light.
    fn compute_offset(
        &self,
        from: &RenderingView,
        pin: &PressedPin,
        lights: &[LightConstants; 3],
        by_depth: Option<Vector2<f64>>,
    ) -> Option<MarkOffset> {
        let pose = &from.camera_from_sensor;
        let [here, more, wider] = self.render_offsets(pose, pin, lights.each_ref())?;
        let by_depth = by_depth.unwrap_or_else(|| {
            let less = self.render_offsets(pose, &pin.shallower(INDENTATION_STEP_MM), [&lights[0]]);
            less.map_or_else(Vector2::zeros, |[less]| (here - less) / INDENTATION_STEP_MM)
        });
        let by_light = [(more - here) / SCATTER_STEP_FACTOR.ln(), (wider - here) / SPREAD_STEP_MM];
        let by_px = here - from.layer[0] * by_light[0] - from.layer[1] * by_light[1];
        // Divided by the square root of 2, so that the two coordinates together have the relative standard deviation.
        let sigma_px = OFFSET_RELATIVE_SIGMA * here.norm() / std::f64::consts::SQRT_2;
        Some(MarkOffset { offset_px: by_px, by_depth, by_light, sigma_px })
    }

    /// Computes the offset of a pin's mark from its tip, px, for several sets of light constants.
    fn render_offsets<const N: usize>(
        &self,
        camera_from_sensor: &Pose,
        pin: &PressedPin,
        constants: [&LightConstants; N],
    ) -> Option<[Vector2<f64>; N]> {
        let sensor_from_camera = camera_from_sensor.inverse();
        let lens = self.camera.without_interface();
        let mut viewer = CameraView::new(&lens, &sensor_from_camera, &self.sights);
        let tip = viewer.project(&pin.tip).ok()?.pixel;
        let indenter = |body: &PressBody| {
            PlacedIndenter::new(body.name.clone(), &body.solid, body.sensor_from_body).ok()
        };
        let indenters = pin.bodies.iter().map(indenter).collect::<Option<Vec<_>>>()?;
        let answer = self.ready.solve_contact(self.touch, &pin.bodies, [0.0; 2], None).ok()?;
        let window = ImageWindow::around(&self.camera, &tip)?;
        let rays = PixelRays::new(&window.camera, &sensor_from_camera).traced_through(&self.sights);
        let surface = ReferenceSurface::cast(self.touch, &rays).ok()?;
        let (rest, pressed) =
            (surface.map_without_contact(), surface.map_deformed(&indenters, &answer, false));
        let rest = self.layers.grey_by_each(constants, &rest, None);
        let pressed = self.layers.grey_by_each(constants, &pressed, Some(&answer));
        let tip = tip.coords - Vector2::from(window.first.map(f64::from));
        let mut found = [Vector2::zeros(); N];
        for (found, (rest, pressed)) in found.iter_mut().zip(rest.iter().zip(&pressed)) {
            let marks = window.detect_marks(rest, pressed)?.into_iter().map(|mark| mark - tip);
            // A half leaves several marks in the window; the one nearest to the tip is taken.
            *found = marks.min_by(|a, b| a.norm().total_cmp(&b.norm()))?;
        }
        Some(found)
    }
}

/// Rectangular part of an image, around a tip.
struct ImageWindow {
    /// Camera that images this part alone.
    camera: Camera,
    /// First column and row of the part, px.
    first: [u32; 2],
    /// Shorter side of the whole image, px.
    shorter_px: u32,
    /// Columns left of the part and rows above it that are added for the detector's background.
    before: [usize; 2],
    /// Width and height of the part with its margins, px.
    size: [usize; 2],
}

impl ImageWindow {
    fn around(camera: &Camera, middle: &Point2<f64>) -> Option<Self> {
        let whole = [camera.width_px(), camera.height_px()];
        let shorter_px = whole[0].min(whole[1]);
        let half = WINDOW_HALF_SHARE * f64::from(shorter_px);
        let ends = [0, 1].map(|axis| {
            let from = (middle[axis] - half).round().max(0.0);
            let to = (middle[axis] + half).round().min(f64::from(whole[axis]));
            [from, to]
        });
        // The tip lies outside the image.
        if ends.iter().any(|[from, to]| to - from < 2.0) {
            return None;
        }
        let ends = ends.map(|ends| ends.map(|px| px as u32));
        let first = ends.map(|[from, _]| from);
        let camera = camera.cropped(first, ends.map(|[from, to]| to - from)).ok()?;
        let around = [0, 1].map(|axis| {
            let [from, to] = ends[axis];
            // The margin starts at a cell border of the whole image's background grid, so that the detector divides
            // both alike.
            let cell_px = background_cell_px(shorter_px as usize) as u32;
            let beside = from.saturating_sub(MARGIN_PX) / cell_px * cell_px;
            [from - beside, (to + MARGIN_PX).min(whole[axis]) - beside].map(|px| px as usize)
        });
        let [before, size] = [0, 1].map(|end| around.map(|ends| ends[end]));
        Some(Self { camera, first, shorter_px, before, size })
    }

    /// Detects marks between the images at rest and pressed. Returns positions relative to the part's first pixel, px.
    fn detect_marks(&self, rest: &[f64], pressed: &[f64]) -> Option<Vec<Vector2<f64>>> {
        let options = DetectionOptions {
            polarity: Polarity::Darker,
            // One pin alone was rendered, without noise: nothing else competes with it.
            min_contrast: MIN_CONTRAST,
            certain_contrast: MIN_CONTRAST,
            part_of_px: Some(self.shorter_px),
            ..DetectionOptions::default()
        };
        let found = detect(&self.pad_window(rest)?, &self.pad_window(pressed)?, &options).ok()?;
        let before = Vector2::from(self.before.map(|px| px as f64));
        Some(found.marks.kept().iter().map(|mark| mark.pixel.coords - before).collect())
    }

    /// Pads the part with its margins. The values are neither rounded nor JPEG-compressed: compression moves each mark
    /// by up to 0.2 px in its own direction, which would pass for an effect of the light.
    fn pad_window(&self, part: &[f64]) -> Option<GreyImage> {
        let [width, height] = self.size;
        let mut values = vec![(SURROUNDING_INTENSITY / WHITE_INTENSITY) as f32; width * height];
        for (y, row) in part.chunks_exact(self.camera.width_px() as usize).enumerate() {
            let first = (self.before[1] + y) * width + self.before[0];
            let to = &mut values[first..][..row.len()];
            to.iter_mut().zip(row).for_each(|(to, grey)| *to = (grey / WHITE_INTENSITY) as f32);
        }
        GreyImage::new(width as u32, height as u32, values).ok()
    }
}

#[cfg(test)]
mod tests {
    use fabkit_calibration::model::Contact;
    use fabkit_designs::builtin_yaml;

    use super::*;
    use crate::calibration_runs::extrinsics::fixture_landmarks;
    use crate::fixtures;

    /// R-Tac0 is rotationally symmetric about the camera's axis, so pins at one height have equal offsets, with equal
    /// derivatives by light.
    #[test]
    fn pins_at_one_height_have_one_mark() {
        let project = fixtures::load("rtac0", builtin_yaml("rtac0").unwrap(), &[]).unwrap();
        let sensor = &project.design.sensor;
        let dome = project.fixture("pin-dome").unwrap();
        let landmarks = fixture_landmarks(&dome).unwrap();
        let of = |x_mm: f64, y_mm: f64| {
            let off = |place: &Point3<f64>| (place.x - x_mm).hypot(place.y - y_mm);
            let by_off = |a: &&_, b: &&_| {
                let [a, b]: [&PinLandmark; 2] = [a, b];
                off(&a.contact_in_sensor_mm).total_cmp(&off(&b.contact_in_sensor_mm))
            };
            let pin = landmarks.pins.iter().min_by(by_off).unwrap();
            let contact = Contact {
                capture: 0,
                hole: pin.hole,
                contact_in_sensor_mm: pin.contact_in_sensor_mm,
                axis_in_sensor: pin.axis_in_sensor,
            };
            Observation { contact, pixel: Point2::origin(), sigma_px: 1.0 }
        };
        let pins = [of(9.18, 9.18), of(-9.18, 9.18), of(-9.18, -9.18), of(9.18, -9.18)];
        let constants = LightConstants::for_sensor(sensor);
        let camera = &sensor.camera;
        let terms = camera.lens.projection.terms();
        let fov_rad = camera.field_of_view.rad();
        let lens =
            Camera::from_data_sheet(camera.width_px, camera.height_px, fov_rad, terms).unwrap();
        let shapes = LandmarkShapes::Pins { radius_mm: landmarks.tip_radius_mm };
        let marks = PinMarkRenderer::new(sensor, &lens, &constants, Some(shapes));
        let marks = marks.unwrap().unwrap();
        let from = RenderingView::in_assumed_light(camera.sensor_from_camera.inverse());
        let offsets = marks.compute_offsets(&from, &pins, None);
        let found = pins.map(|pin| offsets.offset_at(&pin.contact.contact_in_sensor_mm).unwrap());
        let spread = |of: &dyn Fn(&MarkOffset) -> f64| {
            let values = found.map(|offset| of(&offset));
            let [least, most] = [f64::min, f64::max].map(|f| values.into_iter().reduce(f).unwrap());
            assert!(most > 0.0, "{values:?}");
            most - least
        };
        // Marks are thresholded at half their contrast in whole pixels, which costs some hundredths of a pixel in each
        // of the two compared values.
        const PIXELS: f64 = 0.06;
        assert!(spread(&|offset| offset.offset_px.norm()) < PIXELS);
        assert!(spread(&|offset| offset.by_light[0].norm() * SCATTER_STEP_FACTOR.ln()) < PIXELS);
        assert!(spread(&|offset| offset.by_light[1].norm() * SPREAD_STEP_MM) < 2.0 * PIXELS);
    }
}
