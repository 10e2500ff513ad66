//! Optical constants of captures, with their sources.

use fabkit_geometry::{
    Assembly, Body, BodyKind, CompiledSolid, OpticalClarity, Sensor, Vector3, VisibleEffect,
};
use fabkit_light::{ImageSensorNoise, TwoStream};
use serde_json::{Value, json};

/// Provenance of a constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Provenance {
    /// Not known; a plausible value.
    Chosen,
    /// Measured.
    Measured,
    /// Fitted; the constant's source states to which data.
    Fitted,
}

impl Provenance {
    fn name(self) -> &'static str {
        match self {
            Self::Chosen => "chosen",
            Self::Measured => "measured",
            Self::Fitted => "fitted",
        }
    }
}

/// A constant with its provenance.
#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    /// Name with unit, as in outputs.
    pub name: &'static str,
    /// Numeric value.
    pub value: f64,
    /// Provenance of the value.
    pub known: Provenance,
    /// Description of the source.
    pub source: String,
}

/// Optical constants of captures in any lighting.
///
/// ```
/// use fabkit_capture::{LightConstants, Provenance};
///
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// let sensor = &project.design.sensor;
/// let constants = LightConstants::for_sensor(sensor);
/// assert_eq!(constants.scatter_per_mm.known, Provenance::Fitted);
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
    /// Attenuation of the exciting light in glowing layers, 1/mm.
    pub uv_per_mm: Constant,
    /// Shift of the core of the layers' mold, sensor frame, mm. Layers are thinner on the side towards which it is
    /// shifted.
    pub core_off_mm: Vector3<f64>,
    /// Absorption of green and blue light in dyed liquid, 1/mm.
    pub dye_per_mm: Constant,
    /// Reflectances of light markers and of their dark background.
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
/// Reflectances of dark walls, of white walls and of walls of unknown colour. Chosen: black plastic reflects 4 to 7 %,
/// white plastic 80 to 90 %.
const WALL_REFLECTANCES: [f64; 3] = [0.05, 0.85, 0.3];

/// Returns the light from repeated reflections between a sensor's walls, relative to the direct light. For walls of
/// reflectance r it is r + r^2 + ... = r / (1 - r), as in an integrating sphere.
fn repeated_reflections(sensor: &Sensor) -> Constant {
    let is_wall = |body: &&Body| {
        let in_use = body.placements.iter().any(|place| place.assembly == Assembly::sensor());
        in_use && matches!(body.kind, BodyKind::Made(_)) && body.clarity() == OpticalClarity::Opaque
    };
    // The largest opaque body is taken as the one that encloses the light.
    let volume_mm3 = |body: &&Body| {
        CompiledSolid::new(&body.solid)
            .map_or(0.0, |solid| solid.bounds().size_mm().iter().product())
    };
    let walls = sensor.bodies.iter().filter(is_wall);
    let wall = walls.max_by(|a, b| volume_mm3(a).total_cmp(&volume_mm3(b)));
    let [dark, white, unknown] = WALL_REFLECTANCES;
    let part = match wall.and_then(|wall| wall.substance.is_dark) {
        Some(true) => dark,
        Some(false) => white,
        None => unknown,
    };
    let (name, material) = wall.map_or(("no wall", "nothing"), |wall| (&wall.name, &wall.material));
    Constant {
        name: "bounce",
        value: part / (1.0 - part),
        known: Provenance::Chosen,
        source: format!("{name} of {material} sends back {:.0} % of what meets it", 100.0 * part),
    }
}

impl LightConstants {
    /// Returns the default constants: those of R-Tac0's published unit, with the repeated reflections of the sensor's
    /// own walls.
    pub fn for_sensor(sensor: &Sensor) -> Self {
        use Provenance::{Chosen, Fitted, Measured};
        let constant = |name, value, known, source: &str| Constant {
            name,
            value,
            known,
            source: source.to_owned(),
        };
        const PINS: &str = "R-Tac0's published captures of pins, 15, by `fit-light`; 2.4 grey rms are left of profiles; layer_grey and scatter_per_mm are known as their product alone";
        const COATS: &str =
            "silicone with aluminium powder and a little white: between matt paint and satin metal";
        const PAIRS: &str = "differences of R-Tac0's published captures, 1.2 grey rms a pair after the JPEG of quality 70 in which they came";
        Self {
            scatter_per_mm: constant("scatter_per_mm", 0.14, Fitted, PINS),
            layer_grey: constant("layer_grey", 921.0, Fitted, PINS),
            ground_grey: constant("ground_grey", 17.0, Fitted, PINS),
            spread_mm: constant("spread_mm", 0.4, Fitted, PINS),
            bounce: repeated_reflections(sensor),
            coat: [
                constant("coat_diffuse", 0.45, Chosen, COATS),
                constant("coat_shine", 0.15, Chosen, COATS),
                constant("coat_exponent", 12.0, Chosen, COATS),
            ],
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
            marks: [
                constant("marks_send_back", 0.85, Chosen, "white paint and white resin"),
                constant("ground_sends_back", 0.05, Chosen, "black rubber and black paint"),
            ],
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
                self.marks.iter().chain([&self.dye_per_mm]).collect()
            }
        };
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

    /// Returns the noise model of the chip.
    pub fn chip(&self) -> ImageSensorNoise {
        ImageSensorNoise { read_noise: self.read_noise.value, shot_noise: self.shot_noise.value }
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
