//! Optics packs for other simulators: an image at rest, and a table of intensities by slope or depth. On a real unit
//! both are measured with balls; here they are rendered.

mod depths;
mod slopes;

use fabkit_designs::design_hash;
use fabkit_export::{NpyArray, NpyValues, npz, png};
use fabkit_files::Error;
use fabkit_files::staging::OutputFile;
use fabkit_geometry::{Lighting, VisibleEffect};
use fabkit_scene::press_simulation::{ContactModel, LinearOptions};
use fabkit_scene::{Cast, SensorView};
use serde_json::{Value, json};

use super::{CaptureError, CaptureRequest, LightConstants, SimulatedCapture};

pub use slopes::BINS as SLOPE_BINS;

/// Files of an optics pack with their description.
#[derive(Clone, Debug)]
pub struct OpticsPack {
    /// Files in the order in which they are listed.
    pub files: Vec<OutputFile>,
    /// Description as JSON, without the files.
    pub document: Value,
}

/// Renders the optics pack of a sensor in one of its lightings.
///
/// # Errors
/// [`CaptureError`] for a lighting that shows neither slopes nor thickness, and for slopes on a surface that is not
/// flat.
///
/// ```
/// use fabkit_capture::{LightConstants, find_lighting, optics_pack};
///
/// # let yaml = fabkit_designs::builtin_yaml("digit-like").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("digit-like.yaml", yaml, &[])?;
/// # let viewpoint = fabkit_scene::ground_truth::Viewpoint::new(&project.design.sensor.camera, None, None)?;
/// # let viewpoint = viewpoint.resized([32, 24])?;
/// # let scene = fabkit_scene::SensorView::new(std::sync::Arc::new(project), viewpoint)?;
/// let sensor = &scene.project.design.sensor;
/// let pack = optics_pack(&scene, find_lighting(sensor, None)?, &LightConstants::for_sensor(sensor))?;
/// assert_eq!(pack.document["shows"], "slopes");
/// assert!(pack.files.iter().any(|file| file.name == "background.png"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn optics_pack(
    scene: &SensorView,
    lighting: &Lighting,
    constants: &LightConstants,
) -> Result<OpticsPack, Error> {
    let project = &scene.project;
    let mut all = match &lighting.effect {
        VisibleEffect::Slopes { .. } => slopes::slope_pack(scene, lighting, constants)?,
        VisibleEffect::Thickness { .. } => depths::depth_pack(scene, lighting, constants)?,
        _ => {
            let (sensor, light) = (project.design.sensor.name.clone(), lighting.name);
            return Err(CaptureError::NoTable { sensor, light }.into());
        }
    };
    let document = &mut all.document;
    document["format"] = json!("fabkit-optics-pack");
    document["version"] = json!(1);
    document["is_simulated"] = json!(true);
    document["sensor"] = json!(project.design.sensor.name);
    document["design_hash"] = json!(design_hash(&project.design));
    document["light"] = json!(lighting.name);
    document["constants"] = constants.document(&lighting.effect);
    document["not_known"] =
        super::document::unknown_document(&constants.not_known(&lighting.effect));
    document["left_out"] = json!(super::document::omitted_effects(
        &lighting.effect,
        vec![super::lens::OMITTED_EFFECTS]
    ));
    let text = serde_json::to_string_pretty(&all.document).map_err(Error::bug)? + "\n";
    all.files.push(file("optics.json", text.into_bytes()));
    Ok(all)
}

/// Memory per ray of the files of a pack and of what is sampled for them, bytes: points with directions, and the image in
/// bytes, as arrays and as files.
const FILES_BYTES: u64 = 48 + 8 * 3 + 12;

/// Renders the image at rest without noise; `also` is called with its ground truth.
fn render_at_rest(
    scene: &SensorView,
    lighting: &Lighting,
    constants: &LightConstants,
    also: impl FnOnce(&fabkit_scene::CastResult<'_>) -> Result<(), Error>,
) -> Result<SimulatedCapture, Error> {
    let cast = Cast::at_rest(ContactModel::Linear(LinearOptions::default()));
    CaptureRequest { cast, lighting, constants, seed: None }.render(scene, FILES_BYTES, also)
}

/// Converts an image to 8-bit red, green and blue.
fn to_rgb8(image: &SimulatedCapture) -> Vec<u8> {
    let all = image.grey.chunks(image.channels);
    // A greyscale pixel is repeated for the three colours.
    all.flat_map(|pixel| std::array::from_fn::<_, 3, _>(|k| pixel[k % pixel.len()]))
        .map(|value| value.round().clamp(0.0, 255.0) as u8)
        .collect()
}

fn background_png(image: &SimulatedCapture) -> Result<Vec<u8>, Error> {
    let [width, height] = image.size_px;
    png(width, height, &to_rgb8(image)).map_err(Error::bug)
}

fn file(name: &str, bytes: Vec<u8>) -> OutputFile {
    OutputFile { name: name.to_owned(), bytes }
}

fn array(name: &str, shape: &[usize], values: NpyValues) -> NpyArray {
    NpyArray { name: name.to_owned(), shape: shape.to_vec(), values }
}

fn npz_file(name: &str, arrays: &[NpyArray]) -> Result<OutputFile, Error> {
    Ok(file(name, npz(arrays).map_err(Error::bug)?))
}
