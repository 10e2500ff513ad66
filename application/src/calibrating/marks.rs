//! Where the mark of a pin is found, beside the pixel of its tip.
//!
//! A pin darkens what its flanks press in as well as what its tip does, a slanted ray meets one flank before the other, and
//! layers are darker along longer paths: the middle of what is dark lies off the tip, outwards, by pixels where the surface
//! is steep. How far is no unknown: the press of that pin is rendered from the drawn layers, and the same detector finds its
//! mark.

use std::sync::Arc;

use fabkit_calibration::image::GreyImage;
use fabkit_calibration::model::{MarkOffset, MarkOffsets, Observation};
use fabkit_calibration::pins::{DetectionOptions, Polarity, detect};
use fabkit_camera::{Camera, Interface, Point2, Vector2};
use fabkit_depth::truth::{PixelRays, Presser, ReferenceSurface};
use fabkit_fixtures::PressBody;
use fabkit_geometry::{Point3, Pose, Sensor, Shows, Solid, TouchSurface, Vector3};
use fabkit_optics::{Sights, Stack, Viewer};
use rayon::prelude::*;

use crate::Error;
use crate::capturing::{LayerScene, LightConstants, sent};
use crate::pressing::{Ready, threads};

/// Half the side of the part of a picture that is rendered around a tip, as a part of the picture's shorter side: beyond the
/// widest mark that the detector takes for one.
const HALF: f64 = 0.12;
/// How far out a pin reaches, mm.
const PIN_MM: f64 = 8.0;
/// What stands for all that is not rendered: a lit surface that nothing touches, grey.
const ELSEWHERE: f64 = 128.0;
/// A grey value of 255 is this bright in a picture.
const WHITE: f64 = 255.0;

/// How well an offset is known, as a part of it: pins press together instead of each by itself, and light differs from what is
/// assumed by more than two numbers.
const SHARE_KNOWN: f64 = 0.06;

/// So much less deep a pin is pressed in to see what depth does, mm.
const LESS_MM: f64 = 0.15;
/// So many times as much a layer scatters, and so much farther light goes in it, mm, to see what light does.
const MORE_SCATTER: f64 = 2.0;
const WIDER_MM: f64 = 0.15;
/// Without noise the faintest marks are found.
const FAINTEST: f64 = 0.01;

/// A pin that is pressed in: where its tip touches, mm, and which way it is pushed.
type Pin = (Point3<f64>, Vector3<f64>);

/// Renders pins through a sensor's drawn bodies and layers.
pub(super) struct PinMarks<'a> {
    touch: &'a TouchSurface,
    camera: Camera,
    sights: Arc<Sights>,
    layers: LayerScene<'a>,
    ready: Ready,
    constants: &'a LightConstants,
    /// A layer that scatters more, and one in which light goes farther.
    others: [LightConstants; 2],
    radius_mm: f64,
    jpeg_quality: Option<u8>,
}

impl<'a> PinMarks<'a> {
    /// Of a sensor that shows pins by the thickness of layers; `None` where it shows them otherwise, or nobody says how.
    ///
    /// # Errors
    /// Layers that cannot be pressed, bodies that no light can be followed through.
    pub(super) fn of(
        sensor: &'a Sensor,
        camera: &Camera,
        constants: &'a LightConstants,
        radius_mm: f64,
    ) -> Result<Option<Self>, Error> {
        let lighting = sensor.lightings.first();
        let lighting = lighting.filter(|light| matches!(light.shows, Shows::Thickness { .. }));
        let (Some(touch), Some(lighting)) = (&sensor.touch, lighting) else { return Ok(None) };
        if radius_mm <= 0.0 {
            return Ok(None);
        }
        let lens = *camera.lens();
        let camera = Camera::new(camera.width_px(), camera.height_px(), lens, Interface::Drawn);
        let camera = camera.map_err(Error::bug)?;
        let sights = Arc::new(Sights::new(Stack::of(sensor).map_err(Error::bug)?));
        let rays = PixelRays::new(&camera, &sensor.camera.sensor_from_camera).through(&sights);
        let whole = ReferenceSurface::cast(touch, &rays).map_err(Error::bug)?;
        let layers = LayerScene::of(sensor, lighting, constants)?;
        Ok(Some(Self {
            touch,
            camera,
            sights,
            layers: layers.for_parts_of(&whole.untouched()),
            ready: Ready::for_all(sensor, None, threads())?,
            constants,
            others: {
                let mut others = [constants.clone(), constants.clone()];
                // As bright at rest, about: nothing is to become white.
                others[0].scatter_per_mm.value *= MORE_SCATTER;
                others[0].layer_grey.value /= MORE_SCATTER;
                others[1].spread_mm.value += WIDER_MM;
                others
            },
            radius_mm,
            jpeg_quality: sensor.jpeg_quality,
        }))
    }

    /// How far from the pixels of their tips marks are found, with the camera at a pose, and what changes that: all but the
    /// offsets themselves as `known` has it. Pins without a mark that is found, or a tip that is seen, are left out.
    pub(super) fn all(
        &self,
        camera_from_sensor: &Pose,
        observations: &[Observation],
        known: Option<&MarkOffsets>,
    ) -> MarkOffsets {
        let mut pins: Vec<Pin> = Vec::new();
        for contact in observations.iter().map(|observation| &observation.contact) {
            let place = contact.contact_in_sensor_mm;
            if !pins.iter().any(|(known, _)| *known == place) {
                let inwards = contact.axis_in_sensor;
                pins.push((place, inwards.unwrap_or_else(|| -self.touch.depth_mm(&place).1)));
            }
        }
        let of_pin = |pin: &Pin| {
            let before = known.map(|known| known.of(&pin.0));
            let offset = match before {
                Some(before) => {
                    let [by_px] = self.offsets(camera_from_sensor, pin, [self.constants])?;
                    MarkOffset { by_px, ..before? }
                }
                None => self.differentiated(camera_from_sensor, pin)?,
            };
            Some((pin.0, offset))
        };
        MarkOffsets::new(pins.par_iter().filter_map(of_pin).collect::<Vec<_>>())
    }

    /// An offset with its derivatives.
    fn differentiated(&self, camera_from_sensor: &Pose, pin: &Pin) -> Option<MarkOffset> {
        let [scatters, spreads] = &self.others;
        let [by_px, more, wider] =
            self.offsets(camera_from_sensor, pin, [self.constants, scatters, spreads])?;
        let shallower = (pin.0 - LESS_MM * pin.1, pin.1);
        let less = self.offsets(camera_from_sensor, &shallower, [self.constants]);
        let by_depth = less.map_or_else(Vector2::zeros, |[less]| (by_px - less) / LESS_MM);
        let by_light = [(more - by_px) / MORE_SCATTER.ln(), (wider - by_px) / WIDER_MM];
        let sigma_px = SHARE_KNOWN * by_px.norm() / std::f64::consts::SQRT_2;
        Some(MarkOffset { by_px, by_depth, by_light, sigma_px })
    }

    /// For several constants of the layer.
    fn offsets<const N: usize>(
        &self,
        camera_from_sensor: &Pose,
        (contact, axis): &Pin,
        constants: [&LightConstants; N],
    ) -> Option<[Vector2<f64>; N]> {
        let sensor_from_camera = camera_from_sensor.inverse();
        let lens = self.camera.in_air();
        let mut viewer = Viewer::new(&lens, &sensor_from_camera, &self.sights);
        let tip = viewer.look_at(contact).ok()?.pixel;
        let outward = -axis;
        let body = PressBody {
            name: "pin".to_owned(),
            solid: Solid::union([
                Solid::sphere(self.radius_mm),
                Solid::cylinder(self.radius_mm, PIN_MM),
            ]),
            sensor_from_body: Pose::z_to(outward, contact + self.radius_mm * outward),
        };
        let presser = Presser::new(body.name.clone(), &body.solid, body.sensor_from_body).ok()?;
        let answer = self.ready.answer(self.touch, &[body], [0.0; 2], None).ok()?;
        let window = Window::around(&self.camera, &tip)?;
        let rays = PixelRays::new(&window.camera, &sensor_from_camera).through(&self.sights);
        let surface = ReferenceSurface::cast(self.touch, &rays).ok()?;
        let (rest, pressed) = (surface.untouched(), surface.yielded(&[presser], &answer, false));
        let mut found = [Vector2::zeros(); N];
        for (found, constants) in found.iter_mut().zip(constants) {
            let rest = self.layers.paint_by(constants, &rest, None);
            let pressed = self.layers.paint_by(constants, &pressed, Some(&answer));
            let [rest, pressed] = [rest, pressed].map(|painted| {
                window.within(painted.light.into_iter().map(|[grey, ..]| grey), self.jpeg_quality)
            });
            let detected = detect(&rest?, &pressed?, &options()).ok()?;
            let off = |mark: &Point2<f64>| (mark - tip).norm();
            let marks = detected.marks.iter().map(|mark| mark.pixel);
            *found = marks.min_by(|a, b| off(a).total_cmp(&off(b)))? - tip;
        }
        Some(found)
    }
}

fn options() -> DetectionOptions {
    DetectionOptions {
        polarity: Polarity::Darker,
        min_contrast: FAINTEST,
        ..DetectionOptions::default()
    }
}

/// A part of a picture.
struct Window {
    /// A camera that sees that part alone.
    camera: Camera,
    /// Of the whole picture, px.
    size: [usize; 2],
    /// Its first column and row, px.
    first: [usize; 2],
}

impl Window {
    fn around(camera: &Camera, middle: &Point2<f64>) -> Option<Self> {
        let size = [camera.width_px(), camera.height_px()].map(|px| px as usize);
        let half = HALF * size[0].min(size[1]) as f64;
        let ends = [0, 1].map(|axis| {
            let from = (middle[axis] - half).round().max(0.0);
            let to = (middle[axis] + half).round().min(size[axis] as f64);
            [from, to]
        });
        if ends.iter().any(|[from, to]| to - from < 2.0) {
            return None;
        }
        let first = ends.map(|[from, _]| from as u32);
        let camera = camera.part(first, ends.map(|[from, to]| (to - from) as u32)).ok()?;
        Some(Self { camera, size, first: first.map(|px| px as usize) })
    }

    /// The whole picture, with this part of it, as the camera sends it.
    fn within(&self, part: impl Iterator<Item = f64>, quality: Option<u8>) -> Option<GreyImage> {
        let [width, height] = self.size;
        let mut values = vec![ELSEWHERE; width * height];
        let across = self.camera.width_px() as usize;
        for (i, grey) in part.enumerate() {
            let [x, y] = [self.first[0] + i % across, self.first[1] + i / across];
            values[y * width + x] = grey;
        }
        let size_px = [width as u32, height as u32];
        if let Some(quality) = quality {
            values = sent(&values, size_px, quality).ok()?;
        }
        let values = values.into_iter().map(|grey| (grey / WHITE) as f32).collect();
        GreyImage::new(size_px[0], size_px[1], values).ok()
    }
}
