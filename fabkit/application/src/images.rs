//! Images of parts and assemblies, rendered from the exact geometry.

use std::str::FromStr;

use fabkit_depth::{Actor, RenderError, RenderedImage, View, render_with_progress};
use fabkit_export::ExportError;
use fabkit_files::progress::{ProgressCallback, report_counts};
use fabkit_files::{ErrorKind, ErrorSubject, Explained, UnknownName};
use fabkit_geometry::{
    Action, Assembly, Body, CompiledSolid, InvalidSolid, Placement, Point3, Pose, Sensor, Vector3,
};

pub use fabkit_depth::MAX_PIXELS;

/// View of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageView {
    /// Width and height of the image, px.
    pub size_px: [u32; 2],
    /// Remove the half nearer to the viewer: the half in front of the x-z plane if no viewer is given.
    pub is_section: bool,
    /// Direction from which the body is viewed; by default from the front, the right and above.
    pub from: Option<ViewDirection>,
}

/// Direction from which an image is viewed: a side's name, or `AZ,EL` in degrees.
///
/// ```
/// use fabkit_application::images::ViewDirection;
/// let front: ViewDirection = "front".parse()?;
/// assert_eq!(front, "-90,0".parse()?);
/// assert!("upside".parse::<ViewDirection>().is_err());
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewDirection {
    /// Angle around z, from +x towards +y, degrees.
    pub azimuth_deg: f64,
    /// Angle above the x-y plane, degrees.
    pub elevation_deg: f64,
}

/// Named sides with azimuth and elevation, degrees. The front is -y.
pub const SIDES: [(&str, [f64; 2]); 6] = [
    ("front", [-90.0, 0.0]),
    ("back", [90.0, 0.0]),
    ("left", [180.0, 0.0]),
    ("right", [0.0, 0.0]),
    ("top", [-90.0, 90.0]),
    ("bottom", [-90.0, -90.0]),
];

impl FromStr for ViewDirection {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let named = SIDES.into_iter().find(|(name, _)| *name == text.trim());
        if let Some((_, [azimuth_deg, elevation_deg])) = named {
            return Ok(Self { azimuth_deg, elevation_deg });
        }
        let sides = SIDES.map(|(name, _)| name);
        let Some((azimuth, elevation)) = text.split_once(',') else {
            let meant = fabkit_text::find_similar(text, sides);
            let hint = match meant.first() {
                Some(side) => fabkit_text::did_you_mean(&[side]),
                None => format!("write {}, or azimuth and elevation: 30,20", sides.join(", ")),
            };
            return Err(format!("`{text}` is no side: {hint}"));
        };
        let degrees = |text: &str, most: f64, what: &str| match text.trim().parse::<f64>() {
            Ok(value) if value.abs() <= most => Ok(value),
            _ => Err(format!("`{}` is no {what} of -{most} to {most} degrees", text.trim())),
        };
        let azimuth_deg = degrees(azimuth, 360.0, "azimuth")?;
        Ok(Self { azimuth_deg, elevation_deg: degrees(elevation, 90.0, "elevation")? })
    }
}

/// Error of an image.
#[derive(Debug, thiserror::Error)]
pub enum DrawingError {
    /// Invalid solid of a body.
    #[error("{body}: {source}")]
    Solid {
        /// Name of the body.
        body: String,
        /// Reason.
        source: InvalidSolid,
    },
    /// Invalid viewing direction.
    #[error("{0}")]
    Viewer(String),
    /// Unknown assembly.
    #[error(transparent)]
    Unknown(#[from] UnknownName),
    /// The scene cannot be rendered.
    #[error("{}", describe_render_error(.0))]
    Render(#[from] RenderError),
    /// The image cannot be encoded.
    #[error(transparent)]
    Encode(#[from] ExportError),
}

/// Describes a rendering error. The renderer does not know section planes, which are why nothing is left to draw here.
fn describe_render_error(error: &RenderError) -> String {
    match error {
        RenderError::NothingToDraw => "nothing is left behind the section plane".into(),
        other => other.to_string(),
    }
}

impl Explained for DrawingError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Viewer(_)
            | Self::Unknown(_)
            | Self::Render(RenderError::NothingToDraw | RenderError::NoPixels { .. }) => {
                ErrorKind::BadInput
            }
            Self::Render(RenderError::TooLarge { .. }) => ErrorKind::Limit,
            _ => ErrorKind::Bug,
        }
    }

    fn hint(&self) -> Option<String> {
        match self {
            Self::Unknown(unknown) => Some(unknown.hint()),
            Self::Render(RenderError::TooLarge { .. }) => Some("ask for a smaller image".into()),
            _ => None,
        }
    }

    fn subject(&self) -> ErrorSubject {
        match self {
            Self::Unknown(error) => error.subject(),
            other => ErrorSubject::from_kind(other.kind()),
        }
    }
}

/// Draws a single body as PNG: as placed on the printer's bed or, if not printed, in its own frame.
///
/// # Errors
/// [`DrawingError`].
///
/// ```
/// use fabkit_application::images::{ImageView, draw_body};
/// use fabkit_application::{progress::ignore_progress, source::Target};
///
/// let design = Target::new("rtac0").design(&[])?;
/// let base = design.sensor.body("base").ok_or("no such body")?;
/// let shot = ImageView { size_px: [64, 48], is_section: false, from: Some("front".parse()?) };
/// let png = draw_body(base, shot, &ignore_progress)?;
/// // Width and height in the header of a PNG.
/// assert_eq!((&png[1..4], png[19], png[23]), (&b"PNG"[..], 64, 48));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn draw_body(
    body: &Body,
    shot: ImageView,
    progress: ProgressCallback,
) -> Result<Vec<u8>, DrawingError> {
    let actor = actor(body, &compile_body(body)?, body.bed_from_body, 1.0);
    draw(&[actor], shot, progress)
}

/// Draws all bodies of an assembly as PNG, in their places or exploded as the design defines. Molds stand upright as
/// for pouring.
///
/// # Errors
/// [`DrawingError`].
///
/// ```
/// use fabkit_application::images::{ImageView, default_assembly, draw_assembly};
/// use fabkit_application::{progress::ignore_progress, source::Target};
///
/// let sensor = Target::new("9dtact").design(&[])?.sensor;
/// let shot = ImageView { size_px: [64, 48], is_section: true, from: None };
/// let png = draw_assembly(&sensor, &default_assembly(&sensor), false, shot, &ignore_progress)?;
/// assert_eq!(&png[1..4], b"PNG");
/// assert!(draw_assembly(&sensor, "no such assembly", false, shot, &ignore_progress).is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn draw_assembly(
    sensor: &Sensor,
    assembly: &str,
    exploded: bool,
    shot: ImageView,
    progress: ProgressCallback,
) -> Result<Vec<u8>, DrawingError> {
    draw(&assembly_actors(sensor, assembly, exploded)?, shot, progress)
}

/// Makes a renderable actor of each body in an assembly.
pub(crate) fn assembly_actors(
    sensor: &Sensor,
    assembly: &str,
    exploded: bool,
) -> Result<Vec<Actor>, DrawingError> {
    let upright = upright_rotation(sensor, assembly);
    let mut actors = Vec::new();
    for body in &sensor.bodies {
        let places: Vec<&Placement> =
            body.placements.iter().filter(|p| p.assembly.0 == assembly).collect();
        if places.is_empty() {
            continue;
        }
        let prepared = compile_body(body)?;
        for place in places {
            let apart_mm = if exploded { place.explode_mm } else { Vector3::zeros() };
            let shift = Pose::translation(apart_mm.x, apart_mm.y, apart_mm.z);
            actors.push(actor(
                body,
                &prepared,
                upright.then_in(shift.then_in(place.assembly_from_body)),
                body.opacity,
            ));
        }
    }
    if actors.is_empty() {
        let known: std::collections::BTreeSet<&str> = sensor
            .bodies
            .iter()
            .flat_map(|b| &b.placements)
            .map(|p| p.assembly.0.as_str())
            .collect();
        return Err(UnknownName::new("assembly", assembly, known).into());
    }
    Ok(actors)
}

/// Returns the assembly shown by default: the sensor itself or, for a fixture, its first assembly.
///
/// ```
/// use fabkit_application::{images::default_assembly, source::Target};
/// assert_eq!(default_assembly(&Target::new("rtac0").design(&[])?.sensor), "sensor");
/// # Ok::<(), fabkit_application::Error>(())
/// ```
pub fn default_assembly(sensor: &Sensor) -> String {
    let mut assemblies =
        sensor.bodies.iter().flat_map(|body| &body.placements).map(|p| &p.assembly);
    let sensor = Assembly::sensor();
    let first = assemblies.clone().next();
    let found = assemblies.find(|assembly| **assembly == sensor).or(first);
    found.unwrap_or(&sensor).0.clone()
}

/// Returns the rotation that sets a mold upright as its last layer cures. The sensor itself is not rotated.
pub(crate) fn upright_rotation(sensor: &Sensor, assembly: &str) -> Pose {
    if assembly == Assembly::sensor().0 {
        return Pose::identity();
    }
    let up = sensor.chain.iter().rev().find_map(|step| match &step.action {
        Action::Pour(pour) if step.assembly.as_ref()?.0 == assembly => Some(pour.up),
        _ => None,
    });
    up.map_or_else(Pose::identity, |up| Pose::z_to(up, Point3::origin()).inverse())
}

pub(crate) fn compile_body(body: &Body) -> Result<CompiledSolid, DrawingError> {
    CompiledSolid::new(&body.solid)
        .map_err(|source| DrawingError::Solid { body: body.name.clone(), source })
}

fn actor(body: &Body, prepared: &CompiledSolid, scene_from_body: Pose, opacity: f64) -> Actor {
    Actor { body: prepared.clone(), scene_from_body, color: body.color, opacity }
}

fn draw(
    actors: &[Actor],
    shot: ImageView,
    progress: ProgressCallback,
) -> Result<Vec<u8>, DrawingError> {
    let [width_px, height_px] = shot.size_px;
    let view = match (shot.from, shot.is_section) {
        (None, false) => View::isometric(width_px, height_px),
        (None, true) => View::section(width_px, height_px, Point3::origin(), -Vector3::y()),
        (Some(ViewDirection { azimuth_deg, elevation_deg }), section) => {
            let view = View::from_side(azimuth_deg, elevation_deg, width_px, height_px);
            if section { view.clone().cut(Point3::origin(), section_normal(&view)) } else { view }
        }
    };
    encode_png(&render_with_progress(actors, &view, &report_counts(progress))?)
}

pub(crate) fn encode_png(image: &RenderedImage) -> Result<Vec<u8>, DrawingError> {
    Ok(fabkit_export::png(image.width_px, image.height_px, &image.rgb)?)
}

/// Returns the normal of the half that a section removes. Section planes are upright unless the view is straight down
/// or up.
pub(crate) fn section_normal(view: &View) -> Vector3<f64> {
    let across = Vector3::new(view.looking.x, view.looking.y, 0.0);
    -across.try_normalize(1e-9).unwrap_or(view.looking)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mold_is_drawn_as_its_last_layer_is_poured() {
        let mut molds = 0;
        for name in fabkit_designs::builtin_names() {
            let yaml = fabkit_designs::builtin_yaml(name).unwrap();
            let design = fabkit_designs::load(name, yaml, &[], &["fixtures"]).unwrap();
            for step in &design.sensor.chain {
                let (Action::Pour(pour), Some(assembly)) = (&step.action, &step.assembly) else {
                    continue;
                };
                let upright = upright_rotation(&design.sensor, &assembly.0);
                let is_mold = *assembly != Assembly::sensor();
                let wanted = if is_mold { Vector3::z() } else { pour.up };
                let tilt = (upright.vector(pour.up) - wanted).norm();
                assert!(tilt < 1e-12, "{name}, {}: {tilt}", step.name);
                molds += usize::from(is_mold);
            }
            assert_eq!(upright_rotation(&design.sensor, "shelf"), Pose::identity());
        }
        assert!(molds > 8, "{molds}");
    }

    #[test]
    fn a_section_takes_away_what_is_nearer_to_the_viewer() {
        for (name, [azimuth_deg, elevation_deg]) in SIDES {
            let view = View::from_side(azimuth_deg, elevation_deg, 80, 60);
            let towards = section_normal(&view);
            assert!((towards + view.looking).norm() < 1e-12, "{name}: {towards}");
        }
        let above = View::from_side(30.0, 60.0, 80, 60);
        assert!(section_normal(&above).z.abs() < 1e-12 && above.looking.z < -0.8);
    }
}
