//! Optical constants of captures, with their sources.

use fabkit_checks::UnknownProperty;
use fabkit_geometry::{Rgb, Sensor, Vector3, VisibleEffect};
use fabkit_light::{DEFAULT_TRANSMITTANCE, ImageSensorNoise, TwoStream};
use serde_json::{Value, json};

use super::provenance::{Constant, Provenance};
use super::surfaces::{CameraGain, Surfaces};

/// Optical constants of captures in any lighting.
///
/// ```
/// use fabkit_capture::{LightConstants, Provenance};
///
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// let sensor = &project.design.sensor;
/// let constants = LightConstants::for_sensor(sensor);
/// assert_eq!(constants.layer_grey.known, Provenance::Fitted);
/// // Light that shows the thickness of layers depends on their scattering, and not on how a coat shines.
/// let names: Vec<&str> = constants.all(&sensor.lightings[0].effect).iter().map(|one| one.name).collect();
/// assert!(names.contains(&"scatter_per_mm") && !names.contains(&"coat_shine"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LightConstants {
    /// Scattering coefficient of the layer, 1/mm.
    pub scatter_per_mm: Constant,
    /// Intensity of an infinitely thick layer at mean irradiance.
    pub layer_grey: Constant,
    /// Intensity of light from elsewhere that reaches the same pixel, independent of the layer.
    pub ground_grey: Constant,
    /// Lateral spread of light in the layer as a standard deviation, mm.
    pub spread_mm: Constant,
    /// Uniform light from repeated reflections, relative to the mean direct irradiance.
    pub bounce: Constant,
    /// Diffuse share, specular share and specular exponent of a reflective coat.
    pub coat: [Constant; 3],
    /// Diffuse reflectance of the coat for red, green and blue light, relative to its mean.
    pub coat_tint: Rgb,
    /// Share of the light that passes the diffuser; `None` for sensors without one.
    pub diffuser: Option<Constant>,
    /// Attenuation of the exciting light in glowing layers, 1/mm.
    pub uv_per_mm: Constant,
    /// Shift of the core of the layers' mold, sensor frame, mm. Layers are thinner on the side towards which it is
    /// shifted.
    pub core_off_mm: Vector3<f64>,
    /// Absorption of green and blue light in dyed liquid, 1/mm.
    pub dye_per_mm: Constant,
    /// Reflectances of light markers and of their dark background, or of dark ink on a coat.
    pub marks: [Constant; 2],
    /// Intensity of the brightest marker at rest, for which the exposure is set.
    pub mark_grey: Constant,
    /// Intensity of the middle of the surface at rest, for which the exposure is set. `None` for constants fitted to a
    /// unit with an exposure of its own.
    pub middle_grey: Option<Constant>,
    /// Intensity where the camera sees no sensing surface.
    pub beside_grey: Constant,
    /// Standard deviation of the noise in the dark, in intensities.
    pub read_noise: Constant,
    /// Standard deviation of the shot noise at an intensity of 1.
    pub shot_noise: Constant,
    /// Standard deviation of the offset of a whole image, in intensities.
    pub drift: Constant,
}

/// Largest intensity of the surface at rest after exposure.
const MAX_INTENSITY: f64 = 235.0;
impl LightConstants {
    /// Returns the default constants: those of R-Tac0's published unit, with the reflection of the sensor's own coat,
    /// markers and walls, as far as their materials state it.
    pub fn for_sensor(sensor: &Sensor) -> Self {
        use Provenance::{Chosen, Fitted, Measured};
        let constant = |name, value, known, source: &str| Constant {
            name,
            value,
            known,
            source: source.to_owned(),
            unknown: Vec::new(),
        };
        let surfaces = Surfaces::from_sensor(sensor);
        const PINS: &str = "R-Tac0's published captures of pins, 15, by `fit-light`; 2.4 grey rms are left of profiles; known as its product with the layer's scattering alone";
        const PAIRS: &str = "differences of R-Tac0's published captures, 1.2 grey rms a pair after the JPEG of quality 70 in which they came";
        Self {
            scatter_per_mm: surfaces.scattering,
            layer_grey: constant("layer_grey", 921.0, Fitted, PINS),
            ground_grey: constant("ground_grey", 17.0, Fitted, PINS),
            spread_mm: constant("spread_mm", 0.4, Fitted, PINS),
            bounce: surfaces.bounce,
            coat: surfaces.coat,
            coat_tint: surfaces.coat_tint,
            diffuser: surfaces.diffuser,
            uv_per_mm: constant(
                "uv_per_mm",
                0.5,
                Chosen,
                "ink of 1 part in 21 of elastomer: two thirds are used up in the 2 mm of both layers",
            ),
            core_off_mm: Vector3::zeros(),
            dye_per_mm: constant(
                "dye_per_mm",
                0.8,
                Chosen,
                "red food dye: a tenth passes a sheet of 3 mm",
            ),
            marks: surfaces.marks,
            mark_grey: constant("mark_grey", 220.0, Chosen, "bright, and below white"),
            middle_grey: Some(constant(
                "middle_grey",
                151.0,
                Chosen,
                "the exposure of R-Tac0's published captures; 9DTact's are 165",
            )),
            beside_grey: constant("beside_grey", 12.0, Chosen, "black plastic in stray light"),
            read_noise: constant("read_noise_grey", 0.4, Chosen, "usual for small chips"),
            shot_noise: constant("shot_noise_grey", 0.13, Fitted, PAIRS),
            drift: constant(
                "drift_grey",
                1.8,
                Measured,
                "R-Tac0's published captures, far from their pins",
            ),
        }
    }

    /// Sets the constants that `fit-light` fits to pins, in the order of its parameters.
    pub(crate) fn set_fitted(&mut self, values: &[f64]) {
        let fitted = [
            &mut self.layer_grey,
            &mut self.ground_grey,
            &mut self.scatter_per_mm,
            &mut self.spread_mm,
        ];
        fitted.into_iter().zip(values).for_each(|(constant, value)| constant.value = *value);
    }

    /// Returns the constants that matter for what a lighting shows, in the order of outputs.
    pub fn all(&self, shows: &VisibleEffect) -> Vec<&Constant> {
        let mut all = match shows {
            VisibleEffect::Thickness { .. } => vec![
                &self.scatter_per_mm,
                &self.layer_grey,
                &self.ground_grey,
                &self.spread_mm,
                &self.bounce,
            ],
            VisibleEffect::Slopes { printed, .. } => {
                let dark = printed.iter().map(|_| &self.marks[1]);
                self.coat.iter().chain([&self.bounce]).chain(dark).collect()
            }
            VisibleEffect::Fluorescence { .. } => {
                vec![&self.uv_per_mm, &self.spread_mm, &self.bounce]
            }
            VisibleEffect::Markers { .. } => self.marks.iter().chain([&self.bounce]).collect(),
            VisibleEffect::LiquidColumns { .. } => {
                vec![&self.marks[1], &self.dye_per_mm]
            }
        };
        // The light that excites fluorescence passes no diffuser, and that of columns is the room's.
        let is_diffused = !matches!(
            shows,
            VisibleEffect::Fluorescence { .. } | VisibleEffect::LiquidColumns { .. }
        );
        all.extend(self.diffuser.iter().filter(|_| is_diffused));
        // These matter whatever the lighting shows.
        all.extend([&self.beside_grey, &self.read_noise, &self.shot_noise, &self.drift]);
        match shows {
            // Marker lightings are exposed for the brightest marker, others for the middle of the surface.
            VisibleEffect::Markers { .. } | VisibleEffect::LiquidColumns { .. } => {
                all.push(&self.mark_grey)
            }
            _ => all.extend(&self.middle_grey),
        }
        all
    }

    /// Returns the properties of drawn materials that images of a lighting depend on and no source states, by property
    /// and material.
    ///
    /// ```
    /// use fabkit_capture::{LightConstants, find_lighting};
    ///
    /// # let yaml = fabkit_designs::builtin_yaml("digit-like").ok_or("no such sensor")?;
    /// # let project = fabkit_fixtures::load("digit-like.yaml", yaml, &["shell.material=PETG".to_owned()])?;
    /// let sensor = &project.design.sensor;
    /// let unknown = LightConstants::for_sensor(sensor).not_known(&find_lighting(sensor, None)?.effect);
    /// // Nobody says which colour this PETG has.
    /// assert_eq!(unknown.len(), 1);
    /// assert_eq!(unknown[0].subject(), "reflectance of PETG");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn not_known(&self, shows: &VisibleEffect) -> Vec<UnknownProperty> {
        UnknownProperty::merged(self.all(shows).into_iter().flat_map(|one| one.unknown.clone()))
    }

    /// Returns the camera's gain over usual materials for light that passes the diffuser.
    pub(super) fn diffuser_gain(&self) -> CameraGain {
        match &self.diffuser {
            // Fitted constants hold the unit's own exposure.
            Some(passes) if self.middle_grey.is_some() => {
                CameraGain::new(DEFAULT_TRANSMITTANCE / passes.value)
            }
            _ => CameraGain::NONE,
        }
    }

    /// Returns the factor on all light that puts the middle of the surface at `middle_grey`, given its relative
    /// irradiance and the path in the layer there, mm. 1 without `middle_grey`.
    pub(super) fn exposure(&self, lit: f64, path_mm: f64) -> f64 {
        let sent = lit
            * (self.ground_grey.value + self.layer_grey.value * self.layer().reflectance(path_mm));
        match &self.middle_grey {
            Some(middle) if sent > 0.0 => middle.value / sent,
            // Constants of a unit already contain its exposure.
            _ => 1.0,
        }
    }

    /// Returns the factor by which exposure is reduced so that the brightest place stays below white, at most 1.
    pub(super) fn exposure_limit_factor(&self, brightest_over_middle: f64) -> f64 {
        let most = self.middle_grey.as_ref().map(|middle| middle.value * brightest_over_middle);
        most.map_or(1.0, |most| (MAX_INTENSITY / most).min(1.0))
    }

    /// Returns the reflectance model of the layer.
    ///
    /// ```
    /// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
    /// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
    /// let constants = fabkit_capture::LightConstants::for_sensor(&project.design.sensor);
    /// // A path p scatters back s p / (1 + s p) of the light, here with s = 0.14 per mm.
    /// assert!((constants.layer().reflectance(2.0) - 0.28 / 1.28).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn layer(&self) -> TwoStream {
        TwoStream { scatter_per_mm: self.scatter_per_mm.value }
    }

    /// Returns the noise model of the chip at a gain. The gain amplifies the noise in the dark with the light; an
    /// intensity then stands for as many times fewer electrons, whose noise is their root.
    pub fn chip(&self, gain: CameraGain) -> ImageSensorNoise {
        let gain = gain.noise_gain();
        ImageSensorNoise {
            read_noise: gain * self.read_noise.value,
            shot_noise: gain.sqrt() * self.shot_noise.value,
        }
    }

    /// Returns the constants for what a lighting shows as JSON.
    pub fn document(&self, shows: &VisibleEffect) -> Value {
        let constant = |constant: &&Constant| {
            json!({
                "name": constant.name,
                "value": constant.value,
                "known": constant.known.name(),
                "source": constant.source,
            })
        };
        self.all(shows).iter().map(constant).collect()
    }
}
