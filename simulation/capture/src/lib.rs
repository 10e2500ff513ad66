//! The picture that a sensor's camera would take, simulated, with the truth that it shows.
//!
//! A sensor says in which ways it is lit and what each shows: the thickness of translucent layers, which way a coat
//! looks, layers that glow, places of marks. Paths, layers, marks and lamps are those of the drawn bodies; what a press
//! does to them is what [`fabkit_scene::pressing`] says.

mod coat;
mod columns;
mod constants;
mod constants_file;
mod document;
mod glowing;
mod layers;
mod lens;
mod lighting;
mod lit;
mod marks;
mod pack;
mod pegs;
mod scene;
mod sent;
mod skin;
mod studio;
mod table;
mod taken;
mod thins;
mod unit;

pub mod fitting_light;
pub mod live;

use fabkit_depth::truth::DepthMap;
use fabkit_geometry::{Body, Lighting, Mark, Rgb, Sensor, Shows, Vector3};
use fabkit_light::{Chip, NoLight, drift};
use fabkit_optics::Sights;
use rayon::prelude::*;

pub use columns::column_ends;
pub use constants::{Constant, Known, LightConstants};
pub use constants_file::{ConstantsError, read_constants};
pub use document::{comment, document};
pub use lighting::{lighting, lit};
pub use pack::{OpticsPack, SLOPE_BINS, optics_pack};
pub use scene::Scene;
pub use skin::SkinView;
pub use studio::Studio;
pub use taken::{OtherSize, Taken, check_size};
pub use unit::{Unit, unit_document};

pub use self::coat::CoatScene;
use self::glowing::GlowScene;
pub use self::layers::{LayerScene, SeenAtRest};
use self::lens::LensEffects;
use self::marks::MarkScene;
pub use self::scene::{in_use, middle_of};
use self::sent::sent;
pub use self::skin::skin_pictures;
pub use self::thins::Thins;
use fabkit_files::{Error, ErrorKind, ErrorSubject, Explained, UnknownName};
use fabkit_scene::ground_truth::{Viewpoint, pixels_of};
use fabkit_scene::pressing::{Answer, Contact, Moved};
use fabkit_scene::{Cast, Seen, SensorView};

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum CaptureError {
    /// Nobody says how it is lit.
    #[error("nobody says how `{sensor}` is lit, or what of it that shows")]
    OtherLight {
        /// The sensor.
        sensor: String,
    },
    /// It has no surface that a camera could look at.
    #[error("`{sensor}` has no surface of known shape")]
    NoSurface {
        /// The sensor.
        sensor: String,
    },
    /// A light of that name it has not.
    #[error("`{sensor}` has no light `{light}`: it has {}", .known.join(", "))]
    UnknownLight {
        /// The sensor.
        sensor: String,
        /// What was asked for.
        light: String,
        /// What there is.
        known: Vec<&'static str>,
    },
    /// Constants of another kind of light.
    #[error(
        "fitted constants are those of translucent layers; `{sensor}` in `{light}` light shows something else"
    )]
    OtherConstants {
        /// The sensor.
        sensor: String,
        /// Its light.
        light: &'static str,
    },
    /// Marks that nobody moves.
    #[error("`rigid` contact does not say where marks go, which `{light}` light shows")]
    RigidMarks {
        /// The light.
        light: &'static str,
    },
    /// Light of which simulators have no tables.
    #[error(
        "simulators have tables of slopes and of thickness; `{sensor}` in `{light}` light shows something else"
    )]
    NoTable {
        /// The sensor.
        sensor: String,
        /// Its light.
        light: &'static str,
    },
    /// Slopes on a surface that is not flat.
    #[error(
        "tables of slopes count pixels of one size on a flat gel; the surface of `{sensor}` is curved"
    )]
    NotFlat {
        /// The sensor.
        sensor: String,
    },
    /// Nobody knows how it is lit.
    #[error(transparent)]
    NoLight(#[from] NoLight),
    /// Lamps that do not reach the surface.
    #[error(
        "no light of `{sensor}`'s lamps reaches what its camera looks at: opaque bodies are in the way"
    )]
    Dark {
        /// The sensor.
        sensor: String,
    },
}

impl Explained for CaptureError {
    fn kind(&self) -> ErrorKind {
        ErrorKind::BadInput
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::OtherLight { .. } | Self::NoSurface { .. } => {
                "take a built-in sensor, or one of its family"
            }
            Self::UnknownLight { light, known, .. } => {
                return Some(UnknownName::new("light", light, known.iter().copied()).hint());
            }
            Self::OtherConstants { .. } => "leave the constants out",
            Self::NoTable { .. } => {
                "take another of its lights, or render pictures with `fabkit capture`"
            }
            Self::NotFlat { .. } => "render its pictures with `fabkit capture` or `fabkit dataset`",
            Self::RigidMarks { .. } => "take `linear` contact",
            Self::NoLight(NoLight::NoLamps { .. }) => "draw its lamps",
            Self::Dark { .. } => "`fabkit check` says what is in the way",
            Self::NoLight(_) => return None,
        };
        Some(hint.to_owned())
    }

    fn subject(&self) -> ErrorSubject {
        ErrorSubject::new("no_light")
    }
}

/// What to take a picture of.
#[derive(Clone, Debug)]
pub struct Capturing<'a> {
    /// What presses, and how the layers answer; a sample is a ray, a pixel the mean of its own.
    pub cast: Cast<'a>,
    /// How the sensor is lit.
    pub lighting: &'a Lighting,
    /// What the light rests on.
    pub constants: &'a LightConstants,
    /// For the noise; nothing for none, and no drift.
    pub seed: Option<u64>,
}

/// A picture, with what it was made from.
#[derive(Clone, Debug)]
pub struct Captured {
    /// Columns and rows.
    pub size_px: [u32; 2],
    /// Values of a pixel: 1, or 3 for red, green and blue.
    pub channels: usize,
    /// Row by row, 0 to 255, not rounded to whole numbers, but to what the chip tells apart where that is less.
    pub grey: Vec<f64>,
    /// How thick the layers are that each ray meets, mm; NaN where it meets none. Row by row, `samples` times as many;
    /// empty where no thickness is shown.
    pub thickness_mm: Vec<f64>,
    /// By what all light was multiplied.
    pub exposure: f64,
    /// How much brighter than others this picture is, grey.
    pub drift_grey: f64,
    /// What the light shows, in words.
    pub shown: String,
    /// What shines, in words.
    pub lamps: String,
    /// Where marks are, if those are shown.
    pub marks: Vec<Moved>,
    /// Column and row of each, px, whether or not something opaque hides it; nothing beside the picture.
    pub mark_pixels: Vec<Option<[f64; 2]>>,
    /// What the soft layers answered, as JSON.
    pub elastic: Option<serde_json::Value>,
    /// How the surface answered.
    pub contact_level: &'static str,
}

impl Captured {
    /// Least and largest grey value.
    pub fn range_grey(&self) -> [f64; 2] {
        let ends = |[low, high]: [f64; 2], grey: &f64| [low.min(*grey), high.max(*grey)];
        self.grey.iter().fold([f64::INFINITY, f64::NEG_INFINITY], ends)
    }
}

/// What rays see, before a chip records it.
pub struct Painted {
    /// Of each ray, in grey values.
    pub light: Vec<Rgb>,
    /// As in [`Captured`].
    thickness_mm: Vec<f64>,
    /// As in [`Captured`].
    marks: Vec<Moved>,
}

impl Painted {
    /// As it arrives at the chip.
    fn through(mut self, lens: Option<&LensEffects>) -> Self {
        if let Some(lens) = lens {
            lens.apply(&mut self.light);
        }
        self
    }
}

/// A sensor in one of its lights.
#[derive(Debug)]
enum Painter<'a> {
    Layers(LayerScene<'a>),
    Coat(CoatScene<'a>),
    Glow(GlowScene<'a>),
    Marks(Box<MarkScene<'a>>),
}

impl<'a> Painter<'a> {
    fn of(
        sensor: &'a Sensor,
        lighting: &'a Lighting,
        constants: &'a LightConstants,
    ) -> Result<Self, Error> {
        Ok(match &lighting.shows {
            Shows::Thickness { .. } => Self::Layers(LayerScene::of(sensor, lighting, constants)?),
            Shows::Slopes { .. } => Self::Coat(CoatScene::of(sensor, lighting, constants)?),
            Shows::Glow { .. } => Self::Glow(GlowScene::of(sensor, lighting, constants)?),
            Shows::Marks { .. } => {
                Self::Marks(Box::new(MarkScene::of(sensor, lighting, constants)?))
            }
            Shows::Columns { .. } => {
                let sensor = sensor.name.clone();
                return Err(CaptureError::OtherLight { sensor }.into());
            }
        })
    }

    fn paint(
        &self,
        scene: &SensorView,
        cast: &Cast<'_>,
        seen: &Seen<'_>,
    ) -> Result<Painted, Error> {
        Ok(match self {
            Self::Layers(layers) => layers.paint(seen.map, seen.answer),
            Self::Coat(coat) => coat.paint(seen),
            Self::Glow(glow) => {
                let marks = moved(&scene.project.design.sensor, seen.answer);
                Painted { marks, ..glow.paint(seen.map, seen.answer) }
            }
            Self::Marks(marks) => {
                let moved = moved(&scene.project.design.sensor, seen.answer);
                marks.paint(&scene.viewpoint, cast.samples, moved)?
            }
        })
    }

    fn exposure(&self) -> f64 {
        match self {
            Self::Layers(layers) => layers.exposure,
            Self::Coat(coat) => coat.exposure,
            Self::Glow(glow) => glow.exposure,
            Self::Marks(marks) => marks.exposure,
        }
    }

    /// What is shown and what shines, in words.
    fn words(&self) -> [String; 2] {
        match self {
            Self::Layers(layers) => layers.words(),
            Self::Coat(coat) => coat.words(),
            Self::Glow(glow) => glow.words(),
            Self::Marks(marks) => marks.words(),
        }
    }
}

impl Capturing<'_> {
    /// Takes the picture; `also` sees the truth that it shows.
    ///
    /// # Errors
    /// A sensor whose light is not known here, and what [`SensorView::cast`] says.
    pub fn take(
        &self,
        scene: &SensorView,
        also: impl FnOnce(&Seen<'_>) -> Result<(), Error>,
    ) -> Result<Captured, Error> {
        let sensor = &scene.project.design.sensor;
        self.check(sensor, self.cast.presses.is_empty(), self.cast.contact)?;
        let painter = Painter::of(sensor, self.lighting, self.constants)?;
        let samples = self.cast.samples;
        let lens = LensEffects::of(sensor, self.lighting, &scene.viewpoint, samples)?;
        scene.cast(&self.cast, |seen| {
            also(&seen)?;
            let painted = painter.paint(scene, &self.cast, &seen)?.through(lens.as_ref());
            let size_px = [seen.map.width_px(), seen.map.height_px()];
            let size_px = size_px.map(|side| side / self.cast.samples);
            let words = (painter.words(), painter.exposure());
            let elastic = seen.answer.map(fabkit_scene::pressing::answer);
            let mark_pixels = mark_pixels(&scene.viewpoint, scene.sights(), &painted.marks);
            let captured = self.recorded(sensor, painted, size_px, words)?;
            Ok::<_, Error>(Captured { elastic, mark_pixels, ..captured })
        })
    }

    fn check(
        &self,
        sensor: &Sensor,
        is_at_rest: bool,
        contact: Contact,
    ) -> Result<(), CaptureError> {
        let shows = &self.lighting.shows;
        let shows_thickness = matches!(shows, Shows::Thickness { .. });
        if self.constants.middle_grey.is_none() && !shows_thickness {
            let sensor = sensor.name.clone();
            return Err(CaptureError::OtherConstants { sensor, light: self.lighting.name });
        }
        let is_elastic = matches!(contact, Contact::Linear(_));
        let has_marks = !sensor.marks.is_empty() && !shows_thickness;
        if has_marks && !is_elastic && !is_at_rest {
            return Err(CaptureError::RigidMarks { light: self.lighting.name });
        }
        Ok(())
    }

    /// What the chip makes of it.
    fn recorded(
        &self,
        sensor: &Sensor,
        painted: Painted,
        size_px: [u32; 2],
        ([shown, lamps], exposure): ([String; 2], f64),
    ) -> Result<Captured, Error> {
        Ok(Captured {
            size_px,
            channels: self.channels(),
            grey: self.values(sensor, &painted.light, size_px)?,
            thickness_mm: painted.thickness_mm,
            exposure,
            drift_grey: self.drift_grey(),
            shown,
            lamps,
            marks: painted.marks,
            mark_pixels: Vec::new(),
            elastic: None,
            contact_level: self.cast.contact.name(),
        })
    }

    fn channels(&self) -> usize {
        if self.lighting.is_colored() { 3 } else { 1 }
    }

    fn drift_grey(&self) -> f64 {
        self.seed.map_or(0.0, |seed| drift(self.constants.drift.value, seed))
    }

    /// The quality of the JPEG in which pictures come; a picture without noise comes as it is.
    fn jpeg_quality(&self, sensor: &Sensor) -> Option<u8> {
        sensor.jpeg_quality.filter(|_| self.seed.is_some())
    }

    /// What comes of each pixel's rays: means over its samples, with drift, noise, in the steps that the chip tells apart,
    /// as the camera sends them.
    fn values(&self, sensor: &Sensor, light: &[Rgb], size_px: [u32; 2]) -> Result<Vec<f64>, Error> {
        let taken = self.taken(sensor, light, size_px);
        match self.jpeg_quality(sensor) {
            Some(quality) => sent(&taken, size_px, quality),
            None => Ok(taken),
        }
    }

    fn taken(&self, sensor: &Sensor, light: &[Rgb], [width, height]: [u32; 2]) -> Vec<f64> {
        let samples = self.cast.samples as usize;
        let drift_grey = self.drift_grey();
        let (chip, seed) = match self.seed {
            Some(seed) => (self.constants.chip(), seed),
            None => (Chip::IDEAL, 0),
        };
        let (width, height) = (width as usize, height as usize);
        let channels = self.channels();
        // A chip of less than eight bits has less steps up to the same white; of more, nobody asks.
        let steps = f64::from((1u32 << sensor.grey_bits.min(8)) - 1);
        let stepped = |grey: f64| match sensor.grey_bits {
            8.. => grey,
            _ => (grey / 255.0 * steps).round() * 255.0 / steps,
        };
        let value = |i: usize| {
            let (pixel, channel) = (i / channels, i % channels);
            let first = pixel / width * samples * width * samples + pixel % width * samples;
            let rows = (0..samples).map(|row| first + row * width * samples);
            let all = rows.flat_map(|begin| &light[begin..begin + samples]);
            let mean = all.map(|light| light[channel]).sum::<f64>() / (samples * samples) as f64;
            stepped(chip.records(mean + drift_grey, seed, i as u64))
        };
        (0..width * height * channels).into_par_iter().map(value).collect()
    }
}

/// Which part of the light comes back from what a camera sees, light or dark: of the surface and of nothing it is what is
/// dark, of what nobody says a third.
fn sends_back(body: Option<&Body>, [light, dark]: [f64; 2]) -> f64 {
    match body.map(|body| body.substance.is_dark) {
        None | Some(Some(true)) => dark,
        Some(Some(false)) => light,
        Some(None) => UNKNOWN_SENDS,
    }
}

/// Chosen: what is neither white nor black.
const UNKNOWN_SENDS: f64 = 0.3;

/// A sensor's marks, where they are now.
pub fn moved(sensor: &Sensor, answer: Option<&Answer<'_>>) -> Vec<Moved> {
    let at_rest = |mark: &Mark| Moved {
        displacement_mm: Some(Vector3::zeros()),
        axis: mark.axis,
        mark: mark.clone(),
    };
    match (answer, &sensor.touch) {
        (Some(answer), Some(touch)) => answer.marks(sensor, touch),
        _ => sensor.marks.iter().map(at_rest).collect(),
    }
}

/// Where marks are in the picture.
pub fn mark_pixels(
    viewpoint: &Viewpoint,
    sights: &Sights,
    marks: &[Moved],
) -> Vec<Option<[f64; 2]>> {
    let place = |moved: &Moved| Some(moved.mark.point + moved.displacement_mm?);
    pixels_of(viewpoint, sights, &marks.iter().map(place).collect::<Vec<_>>())
}

/// How far neighbouring rays meet the surface from each other, mm: the median along rows.
pub fn ray_mm(map: &DepthMap<'_>) -> f64 {
    use fabkit_depth::truth::NO_LABEL;
    let places: Vec<_> = map.point_in_sensor().collect();
    let width = map.width_px() as usize;
    let both = |pair: &[usize; 2]| pair.iter().all(|i| map.label()[*i] != NO_LABEL);
    let beside = (1..places.len()).filter(|i| i % width != 0).map(|i| [i - 1, i]).filter(both);
    let mut apart: Vec<f64> = beside.map(|[a, b]| (places[b] - places[a]).norm()).collect();
    apart.sort_by(f64::total_cmp);
    apart.get(apart.len() / 2).copied().unwrap_or(f64::INFINITY)
}
