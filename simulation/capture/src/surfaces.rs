//! Reflection of the drawn bodies, from their materials, and what is assumed where these state nothing.

use fabkit_checks::UnknownProperty;
use fabkit_depth::ground_truth::PixelRays;
use fabkit_geometry::{
    Assembly, Body, BodyKind, CompiledSolid, Gloss, Lighting, MaterialProperty, OpticalClarity,
    OpticalFigure, Rgb, Sensor, VisibleEffect,
};
use fabkit_light::DEFAULT_TRANSMITTANCE;

use super::provenance::{Constant, Provenance};

/// Diffuse share, specular share and specular exponent of a usual reflective coat, to which exposures refer, and which
/// stands for coats of unknown reflection. Chosen: silicone with aluminium powder, between matt paint and satin metal.
pub(super) const USUAL_COAT: [f64; 3] = [0.45, 0.15, 12.0];
/// Scattering coefficient of a usual translucent gel, 1/mm, which stands for gels of unknown scattering.
const USUAL_SCATTERING: f64 = 0.14;
/// Reflectance of usual light markers, to which exposures refer.
pub(super) const USUAL_MARK: f64 = 0.85;
/// Reflectances of dark, of light and of other bodies whose material states none. Chosen: black plastic reflects 4 to
/// 7 %, white plastic 80 to 90 %.
const SHADE_REFLECTANCES: [f64; 3] = [0.05, 0.85, 0.3];
/// Largest reflectance of walls all around. Chosen: openings, LEDs and the camera take up a twentieth at least.
const MOST_WALL_REFLECTANCE: f64 = 0.95;
/// Largest gain of a camera over the exposure that suits usual materials. Chosen: 12 dB. Small cameras go to 18 dB and
/// more, but the LEDs of a sensor are set so that its own surface needs none, and exposure times cannot grow with 30
/// images per second.
pub(super) const MOST_CAMERA_GAIN: f64 = 4.0;

/// Gain of the camera over the exposure that suits usual materials.
///
/// ```
/// use fabkit_capture::CameraGain;
/// // A coat that sends back a tenth of the usual light would need ten times the exposure, and gets four times.
/// let black = CameraGain::new(10.0);
/// assert_eq!((black.applied(), black.light_factor()), (4.0, 0.4));
/// // A brighter coat is exposed for a shorter time.
/// assert_eq!((CameraGain::new(0.5).applied(), CameraGain::new(0.5).noise_gain()), (0.5, 1.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraGain {
    /// Gain that would give the surface its usual intensity.
    pub needed: f64,
}

impl CameraGain {
    /// Gain of a sensor of usual materials.
    pub(super) const NONE: Self = Self { needed: 1.0 };

    /// Creates the gain from the light of usual materials over that of the drawn ones.
    pub fn new(needed: f64) -> Self {
        Self { needed }
    }

    /// Returns the gain that the camera applies.
    pub fn applied(self) -> f64 {
        self.needed.min(MOST_CAMERA_GAIN)
    }

    /// Returns the factor by which intensities fall short of the usual ones, at most 1.
    pub fn light_factor(self) -> f64 {
        if self.needed <= MOST_CAMERA_GAIN { 1.0 } else { MOST_CAMERA_GAIN / self.needed }
    }

    /// Returns the factor on the noise of the chip. Less light than usual is amplified; of more light, less is let in.
    pub fn noise_gain(self) -> f64 {
        self.applied().max(1.0)
    }

    /// Returns the largest gain that a camera applies.
    pub fn most() -> f64 {
        MOST_CAMERA_GAIN
    }

    /// Returns a phrase for people; `None` for a sensor of usual materials.
    pub fn phrase(self) -> Option<String> {
        let text = format!("exposure {:.2} times that of usual materials", self.applied());
        match self.needed {
            1.0 => None,
            needed if needed > MOST_CAMERA_GAIN => Some(format!(
                "{text}, the most that a camera amplifies; {needed:.1} times would make the image as bright"
            )),
            _ => Some(text),
        }
    }
}

/// Reflection of the materials in images, as constants.
pub(super) struct Surfaces {
    /// Scattering coefficient of the layers whose thickness images show, 1/mm.
    pub scattering: Constant,
    /// Diffuse share, specular share and specular exponent of the coat.
    pub coat: [Constant; 3],
    /// Diffuse reflectance of the coat for each colour, relative to its mean.
    pub coat_tint: Rgb,
    /// Reflectances of markers and of what is dark beside them.
    pub marks: [Constant; 2],
    /// Share of the light that passes the diffuser; `None` without one.
    pub diffuser: Option<Constant>,
    /// Light from repeated reflections between the walls.
    pub bounce: Constant,
}

impl Surfaces {
    /// Looks up the bodies that the sensor's lightings name.
    pub fn from_sensor(sensor: &Sensor) -> Self {
        let effects = || sensor.lightings.iter().map(|lighting| &lighting.effect);
        let coat = effects().find_map(|effect| match effect {
            VisibleEffect::Slopes { coat, .. } => sensor.body(coat),
            _ => None,
        });
        let rgb = coat.and_then(|coat| Some(coat.substance.optics.reflectance.as_ref()?.value));
        let mean = coat.and_then(|coat| coat.substance.optics.mean_reflectance());
        let coat_tint = match rgb.zip(mean) {
            Some((rgb, mean)) if mean > 0.0 => rgb.map(|part| part / mean),
            _ => [1.0; 3],
        };
        Self {
            scattering: scattering_constant(sensor),
            coat: coat_constants(coat),
            coat_tint,
            marks: mark_constants(sensor),
            diffuser: sensor.lightings.iter().find_map(|light| diffuser_constant(sensor, light)),
            bounce: repeated_reflections(sensor),
        }
    }
}

/// Returns a constant that a material states, or else the assumption that stands for it.
fn constant_of_body<T>(
    name: &'static str,
    (property, body): (MaterialProperty, Option<&Body>),
    stated: Option<&OpticalFigure<T>>,
    value: impl FnOnce(&OpticalFigure<T>) -> f64,
    (assumed, reason): (f64, &str),
) -> Constant {
    match (stated, body) {
        (Some(figure), _) => Constant {
            name,
            value: value(figure),
            known: if figure.is_chosen { Provenance::Chosen } else { Provenance::Stated },
            source: figure.source.clone(),
            unknown: Vec::new(),
        },
        (None, body) => {
            let unknown = body.map(|body| UnknownProperty::of_body(property, body));
            let source = match &unknown {
                Some(unknown) => format!("{} is not known; as {reason}", unknown.subject()),
                None => reason.to_owned(),
            };
            let unknown = unknown.into_iter().collect();
            Constant { name, value: assumed, known: Provenance::Chosen, source, unknown }
        }
    }
}

/// Returns the scattering coefficient of the layers whose thickness the sensor's images show. Images take the layers as
/// one, which scatters like their mean; one of unknown scattering leaves it unknown.
fn scattering_constant(sensor: &Sensor) -> Constant {
    const USUAL: &str = "Ecoflex 00-30 in R-Tac0's published captures";
    let layers = sensor.lightings.iter().find_map(|lighting| match &lighting.effect {
        VisibleEffect::Thickness { layers } => Some(layers),
        _ => None,
    });
    let stated = |body: &&Body| body.substance.optics.scattering_per_mm.is_some();
    let bodies = || layers.into_iter().flatten().filter_map(|name| sensor.body(name));
    let open = || bodies().filter(|body| !stated(body));
    let body = open().next().or_else(|| bodies().next());
    let figure = body.and_then(|body| body.substance.optics.scattering_per_mm.as_ref());
    let (of, usual) = ((MaterialProperty::Scattering, body), (USUAL_SCATTERING, USUAL));
    let mut constant = constant_of_body("scatter_per_mm", of, figure, |figure| figure.value, usual);
    let unknown = |body| UnknownProperty::of_body(MaterialProperty::Scattering, body);
    constant.unknown = open().map(unknown).collect();
    let known = bodies().filter_map(|body| body.substance.optics.scattering_per_mm.as_ref());
    let known: Vec<f64> = known.map(|figure| figure.value).collect();
    if constant.unknown.is_empty() && known.iter().any(|value| *value != constant.value) {
        constant.value = known.iter().sum::<f64>() / known.len() as f64;
        constant.source +=
            &format!("; the mean of layers of {known:?} /mm, which images take as one");
    }
    constant
}

/// Returns reflectance, gloss and exponent of the coat.
fn coat_constants(coat: Option<&Body>) -> [Constant; 3] {
    const USUAL: &str =
        "silicone with aluminium powder and a little white: between matt paint and satin metal";
    let [diffuse, shine, exponent] = USUAL_COAT;
    let optics = coat.map(|coat| &coat.substance.optics);
    let mean = optics.and_then(|optics| optics.mean_reflectance()).unwrap_or(diffuse);
    let reflectance = optics.and_then(|optics| optics.reflectance.as_ref());
    let gloss = optics.and_then(|optics| optics.gloss.as_ref());
    let of_gloss = |name, value: fn(Gloss) -> f64, assumed| {
        let of = (MaterialProperty::Gloss, coat);
        constant_of_body(name, of, gloss, |gloss| value(gloss.value), (assumed, USUAL))
    };
    let of = (MaterialProperty::Reflectance, coat);
    let mut constant =
        constant_of_body("coat_diffuse", of, reflectance, |_| mean, (diffuse, USUAL));
    if let Some([red, green, blue]) = reflectance.map(|figure| figure.value)
        && (red != green || green != blue)
    {
        let percent = [red, green, blue].map(|part| format!("{:.0}", 100.0 * part)).join(", ");
        constant.source += &format!("; mean of {percent} % of red, green and blue light");
    }
    [
        constant,
        of_gloss("coat_shine", |gloss| gloss.share, shine),
        of_gloss("coat_exponent", |gloss| gloss.exponent, exponent),
    ]
}

/// Returns the reflectances of markers and of what is dark beside them: the body behind markers that stand out by their
/// brightness, or the ink on a coat.
fn mark_constants(sensor: &Sensor) -> [Constant; 2] {
    let named = sensor.lightings.iter().find_map(|lighting| match &lighting.effect {
        VisibleEffect::Markers { marks } => {
            let pair = sensor.contrasts.iter().find(|[light, _]| light == marks);
            Some((Some(marks), pair.map(|[_, behind]| behind)))
        }
        VisibleEffect::Slopes { printed: Some(printed), .. } => Some((None, Some(printed))),
        _ => None,
    });
    let (marks, behind) = named.unwrap_or_default();
    let constant = |name, body: Option<&String>, assumed, reason| {
        let body = body.and_then(|name| sensor.body(name));
        let optics = body.map(|body| &body.substance.optics);
        let mean = optics.and_then(|optics| optics.mean_reflectance()).unwrap_or(assumed);
        let figure = optics.and_then(|optics| optics.reflectance.as_ref());
        let of = (MaterialProperty::Reflectance, body);
        constant_of_body(name, of, figure, |_| mean, (assumed, reason))
    };
    let [dark, light, _] = SHADE_REFLECTANCES;
    [
        constant("marks_send_back", marks, light, "white paint and white resin"),
        constant("ground_sends_back", behind, dark, "black rubber and black paint"),
    ]
}

/// Returns the share of the light that passes the diffuser of a lighting; `None` if it has none, or one that spreads
/// nothing.
fn diffuser_constant(sensor: &Sensor, lighting: &Lighting) -> Option<Constant> {
    let body = sensor.body(lighting.diffuser.as_ref()?)?;
    if body.clarity() != OpticalClarity::Translucent {
        return None;
    }
    const USUAL: &str = "frosted and opal sheets, which pass 30 to 90 %";
    let figure = body.substance.optics.transmission.as_ref();
    let of = (MaterialProperty::Transmission, Some(body));
    let usual = (DEFAULT_TRANSMITTANCE, USUAL);
    Some(constant_of_body("diffuser_passes", of, figure, |figure| figure.value, usual))
}

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
    let [.., neither] = SHADE_REFLECTANCES;
    let part = wall.map_or(neither, body_reflectance).min(MOST_WALL_REFLECTANCE);
    let (name, material) = wall.map_or(("no wall", "nothing"), |wall| (&wall.name, &wall.material));
    let mut source =
        format!("{name} of {material} sends back {:.0} % of what meets it", 100.0 * part);
    let unknown = wall.and_then(unknown_reflectance);
    if unknown.is_some() {
        source += ", assumed";
    }
    Constant {
        name: "bounce",
        value: part / (1.0 - part),
        known: Provenance::Chosen,
        source,
        unknown: unknown.into_iter().collect(),
    }
}

/// Returns the reflectance of a body; that of its shade where its material states none.
fn body_reflectance(body: &Body) -> f64 {
    let [dark, light, neither] = SHADE_REFLECTANCES;
    let assumed = match body.substance.is_dark {
        Some(true) => dark,
        Some(false) => light,
        None => neither,
    };
    body.substance.optics.mean_reflectance().unwrap_or(assumed)
}

fn unknown_reflectance(body: &Body) -> Option<UnknownProperty> {
    let is_known = body.substance.optics.reflectance.is_some();
    (!is_known).then(|| UnknownProperty::of_body(MaterialProperty::Reflectance, body))
}

/// Returns the reflectance of a body on which rays end; that of the ground for the surface and for rays that meet
/// nothing.
pub(super) fn reflectance(body: Option<&Body>, ground: &Constant) -> f64 {
    body.map_or(ground.value, body_reflectance)
}

/// Returns the bodies on which rays end, apart from light sources, whose materials state no reflectance.
pub(super) fn unknown_in_view(
    sensor: &Sensor,
    rays: &PixelRays,
    lamps: &[String],
) -> Vec<UnknownProperty> {
    let names = rays.seen_by_names();
    let mut is_seen = vec![false; names.len()];
    rays.seen_by().iter().for_each(|by| is_seen[usize::from(*by)] = true);
    let seen =
        names.iter().zip(is_seen).filter(|(name, is_seen)| *is_seen && !lamps.contains(name));
    UnknownProperty::merged(seen.filter_map(|(name, _)| unknown_reflectance(sensor.body(name)?)))
}
