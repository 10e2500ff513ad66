//! Synthetic captures with known truth, for tests and to try a fixture before it is printed.
//!
//! Images come from the measurement model itself: each pixel's ray is compared with the contacts, so that a mark is as
//! large and as oblique as the camera and its interface make it.

use fabkit_camera::{OutsideDomain, ViewRay};
use fabkit_geometry::sequences::SplitMix64;
use nalgebra::{Point2, Point3, Vector2, Vector3};

use crate::image::{GreyImage, ImageError};
use crate::landmarks::PinLandmark;
use crate::model::{Contact, Model, Observation};

/// Simulated sensor with a known camera, and the parameters of its images.
///
/// ```
/// use fabkit_calibration::landmarks::PinLandmarks;
/// use fabkit_calibration::model::Model;
/// use fabkit_calibration::synthetic::SyntheticSensor;
/// use fabkit_camera::Camera;
/// use fabkit_geometry::Pose;
/// let landmarks = PinLandmarks::from_json(r#"{"1": [0, 0, 15], "2": [9, 0, 12]}"#)?;
/// let model = Model::new(Camera::equidistant(640, 480, 2.8)?, Pose::translation(0.0, 0.0, 7.0));
/// let captures = [landmarks.pins.iter().collect()];
/// // Without noise, the pin at the tip is in the middle of the image.
/// let exact = SyntheticSensor::new(model.clone(), 1).observe(&captures, 0.0)?;
/// assert_eq!((exact[0].pixel.x, exact[0].pixel.y), (319.5, 239.5));
/// // The same seed gives the same noise.
/// let noisy = || SyntheticSensor::new(model.clone(), 5).observe(&captures, 0.3);
/// assert_eq!(noisy()?, noisy()?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SyntheticSensor {
    /// True model.
    pub model: Model,
    /// Play of the tips, mm: standard deviation in each direction.
    pub play_mm: f64,
    /// Radius at which a mark has faded to 1/e, mm.
    pub mark_radius_mm: f64,
    /// Fraction of the light that a mark removes at its centre.
    pub contrast: f64,
    /// Standard deviation of a pixel's intensity, where white is 1.
    pub brightness_noise: f64,
    /// Generator of the random numbers.
    pub noise: SplitMix64,
}

/// Image of pins with the true positions of its marks.
#[derive(Clone, Debug)]
pub struct SyntheticCapture {
    /// Rendered image.
    pub image: GreyImage,
    /// Hole and true pixel of each pin, play included.
    pub pins: Vec<(u32, Point2<f64>)>,
}

impl SyntheticSensor {
    /// Creates a sensor with noise as of 8-bit images, marks of 0.8 mm and no play.
    pub fn new(model: Model, seed: u64) -> Self {
        Self {
            model,
            play_mm: 0.0,
            mark_radius_mm: 0.8,
            contrast: 0.4,
            brightness_noise: 0.004,
            noise: SplitMix64::new(seed),
        }
    }

    /// Simulates observations without images: with each pin's play, and normal noise of `sigma_px`.
    ///
    /// # Errors
    /// Fails for a pin that the camera cannot see.
    pub fn observe(
        &mut self,
        captures: &[Vec<&PinLandmark>],
        sigma_px: f64,
    ) -> Result<Vec<Observation>, OutsideDomain> {
        let mut observations = Vec::new();
        for (capture, pins) in captures.iter().enumerate() {
            for pin in pins {
                let contact = contact(pin, capture);
                let tip = self.tip(&contact);
                let pixel = self.model.camera.project(&tip)?;
                let noise = Vector2::new(self.noise.normal(), self.noise.normal());
                observations.push(Observation {
                    contact,
                    pixel: pixel + sigma_px * noise,
                    sigma_px,
                });
            }
        }
        Ok(observations)
    }

    /// Renders the image without contact, at a light level relative to the usual 1.
    ///
    /// # Errors
    /// Fails if the camera's image is too small or too large for a [`GreyImage`].
    pub fn reference(&mut self, light: f64) -> Result<GreyImage, ImageError> {
        self.render(light, &[])
    }

    /// Renders an image of pins.
    ///
    /// # Errors
    /// Fails as [`SyntheticSensor::reference`]. Pins that cannot be seen leave no mark.
    ///
    /// ```
    /// use fabkit_calibration::landmarks::PinLandmarks;
    /// use fabkit_calibration::model::Model;
    /// use fabkit_calibration::pin_detection::{DetectionOptions, detect};
    /// use fabkit_calibration::synthetic::SyntheticSensor;
    /// use fabkit_camera::Camera;
    /// use fabkit_geometry::Pose;
    /// let landmarks = PinLandmarks::from_json(r#"{"1": [0, 0, 15], "2": [9, 0, 12]}"#)?;
    /// let model = Model::new(Camera::equidistant(320, 240, 2.8)?, Pose::translation(0.0, 0.0, 7.0));
    /// let mut sensor = SyntheticSensor::new(model, 1);
    /// let reference = sensor.reference(1.0)?;
    /// // A tenth darker, as if the light had drifted.
    /// let taken = sensor.capture(0, &[&landmarks.pins[1]], 0.9)?;
    /// let found = detect(&reference, &taken.image, &DetectionOptions::default())?;
    /// let (hole, truth) = taken.pins[0];
    /// assert_eq!((hole, found.marks.kept().len()), (2, 1));
    /// assert!((found.marks.kept()[0].pixel - truth).norm() < 0.3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn capture(
        &mut self,
        capture: usize,
        pins: &[&PinLandmark],
        light: f64,
    ) -> Result<SyntheticCapture, ImageError> {
        let mut tips = Vec::new();
        let mut truth = Vec::new();
        for pin in pins {
            let tip = self.tip(&contact(pin, capture));
            if let Ok(pixel) = self.model.camera.project(&tip) {
                truth.push((pin.hole, pixel));
            }
            tips.push(tip);
        }
        Ok(SyntheticCapture { image: self.render(light, &tips)?, pins: truth })
    }

    /// Computes the tip of a pin with the play of this press, camera frame, mm.
    fn tip(&mut self, contact: &Contact) -> Point3<f64> {
        let play = self.play_mm * Vector3::from_fn(|_, _| self.noise.normal());
        self.model.camera_from_sensor.point(self.model.displaced_contact(contact) + play)
    }

    /// Renders the surface with marks of the given tips.
    fn render(
        &mut self,
        light: f64,
        tips_in_camera: &[Point3<f64>],
    ) -> Result<GreyImage, ImageError> {
        let camera = self.model.camera;
        let (width, height) = (camera.width_px(), camera.height_px());
        let mut values = Vec::with_capacity(width as usize * height as usize);
        let half = Vector2::new(f64::from(width), f64::from(height)) / 2.0;
        for y in 0..height {
            for x in 0..width {
                let pixel = Point2::new(f64::from(x), f64::from(y));
                let from_centre = (pixel.coords - half).norm() / half.min();
                let noise = self.brightness_noise * self.noise.normal();
                let Some(ray) = camera.unproject(&pixel).ok().filter(|_| from_centre < 0.95) else {
                    values.push((0.05 + noise).clamp(0.0, 1.0) as f32);
                    continue;
                };
                // Brighter on one side, darker towards the edge, with specks that are the same in every image.
                let slope = 1.0 + 0.15 * (pixel.x - half.x) / half.x;
                let speck = if (x / 3 * 7 + y / 3 * 13) % 97 == 0 { 0.93 } else { 1.0 };
                let surface = 0.62 * light * slope * (1.0 - 0.3 * from_centre.powi(2)) * speck;
                let dark: f64 = tips_in_camera.iter().map(|tip| self.mark(&ray, tip)).sum();
                values.push((surface * (1.0 - dark.min(0.95)) + noise).clamp(0.0, 1.0) as f32);
            }
        }
        GreyImage::new(width, height, values)
    }

    /// Computes the fraction of the light that a tip removes along a ray.
    fn mark(&self, ray: &ViewRay, tip: &Point3<f64>) -> f64 {
        let to_tip = tip - ray.origin_in_camera;
        // Distance of the tip from the ray.
        let miss_mm = ray.direction.cross(&to_tip).norm();
        // Behind the camera, or so far from the ray that the Gaussian is below 1e-6.
        if ray.direction.dot(&to_tip) < 0.0 || miss_mm > 4.0 * self.mark_radius_mm {
            return 0.0;
        }
        self.contrast * (-(miss_mm / self.mark_radius_mm).powi(2)).exp()
    }
}

/// Creates the contact of a pin in a capture.
fn contact(pin: &PinLandmark, capture: usize) -> Contact {
    Contact {
        capture,
        hole: pin.hole,
        contact_in_sensor_mm: pin.contact_in_sensor_mm,
        axis_in_sensor: pin.axis_in_sensor,
    }
}
