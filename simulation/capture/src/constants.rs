//! What a picture's light rests on: constants with their sources.

use fabkit_geometry::{Assembly, Body, Clarity, CompiledSolid, Kind, Sensor, Shows, Vector3};
use fabkit_light::{Chip, TwoStream};
use serde_json::{Value, json};

/// How a constant is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Known {
    /// Nobody knows; a plausible value.
    Chosen,
    /// Measured.
    Measured,
    /// Fitted; to what, its source says.
    Fitted,
}

impl Known {
    fn word(self) -> &'static str {
        match self {
            Self::Chosen => "chosen",
            Self::Measured => "measured",
            Self::Fitted => "fitted",
        }
    }
}

/// A number that somebody stands for.
#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    /// As outputs call it, with its unit.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// How it is known.
    pub known: Known,
    /// From where.
    pub source: String,
}

/// The constants of pictures, whatever light shows.
#[derive(Clone, Debug, PartialEq)]
pub struct LightConstants {
    /// How much the layer scatters, 1/mm.
    pub scatter_per_mm: Constant,
    /// What an endless layer would send back where the light is as on average, grey.
    pub layer_grey: Constant,
    /// What comes back from elsewhere at the same place, whatever the layer does, grey.
    pub ground_grey: Constant,
    /// How far light goes sideways in the layer, mm: a standard deviation.
    pub spread_mm: Constant,
    /// What bounces on and arrives everywhere alike, as a part of what arrives straight on average.
    pub bounce: Constant,
    /// Which part of the light a reflective coat spreads, which it sends on as a rough mirror does, and how narrowly.
    pub coat: [Constant; 3],
    /// How fast layers that glow use up the light that makes them, 1/mm.
    pub uv_per_mm: Constant,
    /// How far off the core of the layers' mold stands, sensor frame, mm: layers are thinner on that side.
    pub core_off_mm: Vector3<f64>,
    /// How fast dyed liquid swallows green and blue light, 1/mm.
    pub dye_per_mm: Constant,
    /// What light marks and their dark ground send back.
    pub marks: [Constant; 2],
    /// How bright the brightest mark at rest is: what the exposure is set for.
    pub mark_grey: Constant,
    /// How bright the middle of the surface at rest is: what the exposure is set for; nothing where
    /// the constants are those of a unit with its own.
    pub middle_grey: Option<Constant>,
    /// What the chip records where the camera sees no sensing surface, grey.
    pub beside_grey: Constant,
    /// Noise in the dark, grey.
    pub read_noise: Constant,
    /// Noise at a grey value of 1, grey.
    pub shot_noise: Constant,
    /// Standard deviation of how bright a whole picture is, grey.
    pub drift: Constant,
}

/// As bright as anything of the surface at rest is exposed, grey.
const BELOW_WHITE: f64 = 235.0;
/// Of light that meets them, what comes back from dark walls, from white ones, and from those of which nobody says what
/// colour they have. Chosen: black plastic 4 to 7 %, white plastic 80 to 90 %.
const WALLS: [f64; 3] = [0.05, 0.85, 0.3];

/// What goes round between the walls of a sensor, as a part of what comes straight: of walls that send back a part r,
/// r + r^2 + ... = r / (1 - r), as in an integrating sphere.
fn bounce(sensor: &Sensor) -> Constant {
    let is_wall = |body: &&Body| {
        let in_use = body.placements.iter().any(|place| place.assembly == Assembly::sensor());
        in_use && matches!(body.kind, Kind::Made(_)) && body.clarity() == Clarity::Opaque
    };
    // The largest is what surrounds the light.
    let volume_mm3 = |body: &&Body| {
        CompiledSolid::new(&body.solid)
            .map_or(0.0, |solid| solid.bounds().size_mm().iter().product())
    };
    let walls = sensor.bodies.iter().filter(is_wall);
    let wall = walls.max_by(|a, b| volume_mm3(a).total_cmp(&volume_mm3(b)));
    let [dark, white, unknown] = WALLS;
    let part = match wall.and_then(|wall| wall.substance.is_dark) {
        Some(true) => dark,
        Some(false) => white,
        None => unknown,
    };
    let (name, material) = wall.map_or(("no wall", "nothing"), |wall| (&wall.name, &wall.material));
    Constant {
        name: "bounce",
        value: part / (1.0 - part),
        known: Known::Chosen,
        source: format!("{name} of {material} sends back {:.0} % of what meets it", 100.0 * part),
    }
}

impl LightConstants {
    /// For a sensor: those of R-Tac0's published unit, with what goes round between its own walls.
    pub fn of(sensor: &Sensor) -> Self {
        use Known::{Chosen, Fitted, Measured};
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
            bounce: bounce(sensor),
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

    /// Those that a light's pictures rest on, in order.
    pub fn all(&self, shows: &Shows) -> Vec<&Constant> {
        let mut all = match shows {
            Shows::Thickness { .. } => vec![
                &self.scatter_per_mm,
                &self.layer_grey,
                &self.ground_grey,
                &self.spread_mm,
                &self.bounce,
            ],
            Shows::Slopes { printed, .. } => {
                let dark = printed.iter().map(|_| &self.marks[1]);
                self.coat.iter().chain([&self.bounce]).chain(dark).collect()
            }
            Shows::Glow { .. } => vec![&self.uv_per_mm, &self.spread_mm, &self.bounce],
            Shows::Marks { .. } => self.marks.iter().chain([&self.bounce]).collect(),
            Shows::Columns { .. } => self.marks.iter().chain([&self.dye_per_mm]).collect(),
        };
        all.extend([&self.beside_grey, &self.read_noise, &self.shot_noise, &self.drift]);
        match shows {
            Shows::Marks { .. } | Shows::Columns { .. } => all.push(&self.mark_grey),
            _ => all.extend(&self.middle_grey),
        }
        all
    }

    /// By what all light is multiplied, where the middle of the surface gets so much of it and the path in the layer is
    /// that long, mm.
    pub(super) fn exposure(&self, lit: f64, path_mm: f64) -> f64 {
        let sent = lit
            * (self.ground_grey.value + self.layer_grey.value * self.layer().reflectance(path_mm));
        match &self.middle_grey {
            Some(middle) if sent > 0.0 => middle.value / sent,
            _ => 1.0,
        }
    }

    /// By how much less is exposed where the middle is not as bright as other places are, so that those are not white.
    pub(super) fn dimmer(&self, brightest_over_middle: f64) -> f64 {
        let most = self.middle_grey.as_ref().map(|middle| middle.value * brightest_over_middle);
        most.map_or(1.0, |most| (BELOW_WHITE / most).min(1.0))
    }

    /// The law of the layer.
    pub fn layer(&self) -> TwoStream {
        TwoStream { scatter_per_mm: self.scatter_per_mm.value }
    }

    /// The chip.
    pub fn chip(&self) -> Chip {
        Chip { read_noise: self.read_noise.value, shot_noise: self.shot_noise.value }
    }

    /// As JSON.
    pub fn document(&self, shows: &Shows) -> Value {
        let constant = |constant: &&Constant| {
            json!({
                "name": constant.name,
                "value": constant.value,
                "known": constant.known.word(),
                "source": constant.source,
            })
        };
        self.all(shows).iter().map(constant).collect()
    }
}
