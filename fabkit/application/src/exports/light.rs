//! Optical description of a sensor, for ray tracing without fabkit.

use fabkit_designs::Design;
use fabkit_export::{
    LightBody, LightCamera, LightDocument, LightDome, LightPlacement, LightPlane, LightSurface,
    OpticalRole as LightRole,
};
use fabkit_files::staging::OutputFile;
use fabkit_geometry::{
    Assembly, Body, CompiledSolid, OpticalClarity, Point3, Sensor, Solid, TouchSurface,
};
use fabkit_optics::{InvalidStack, OpticalRole, OpticalStack};
use fabkit_scene::ground_truth::Viewpoint;
use serde_json::json;

use super::{ExportRunError, MadeFile};

/// Name of the file.
pub const LIGHT_NAME: &str = "light.json";

/// Length by which the surface's solid is extended below its foot, mm: farther than any camera.
const SURFACE_EXTENSION_MM: f64 = 1_000.0;

/// Makes the document of all bodies of the finished sensor, independent of the requested parts.
pub(super) fn make_file(design: &Design, design_hash: &str) -> Result<MadeFile, ExportRunError> {
    let sensor = &design.sensor;
    let viewpoint = Viewpoint::new(&sensor.camera, None, None)?;
    // Overlaps, and cameras inside of parts, are errors here as for ground truth.
    let stack = viewpoint.stack(sensor)?;
    let words = ["nothing", "surface"].map(str::to_owned).into_iter();
    let last = "total reflection".to_owned();
    let pupil = viewpoint.sensor_from_camera.point(Point3::origin());
    let bodies =
        sensor.bodies.iter().filter_map(|body| describe_body(sensor, body, &pupil).transpose());
    let bodies = bodies.collect::<Result<Vec<_>, InvalidStack>>()?;
    let document = LightDocument {
        design_hash,
        sensor: &sensor.name,
        camera: camera(&viewpoint),
        surface: sensor.touch.as_ref().map(surface),
        seen_by_names: words.chain(names(&stack)).chain([last]).collect(),
        bodies,
    };
    let parts = document.bodies.iter().map(|body| body.name.to_owned()).collect();
    let failed = |source| ExportRunError::Write { file: LIGHT_NAME.to_owned(), source };
    let bytes = fabkit_export::light(&document).map_err(failed)?;
    let file = OutputFile { name: LIGHT_NAME.to_owned(), bytes };
    Ok(MadeFile { file, format: "light", parts, stock: None })
}

fn names(stack: &OpticalStack) -> impl Iterator<Item = String> {
    stack.names().iter().cloned()
}

fn camera(viewpoint: &Viewpoint) -> LightCamera {
    let camera = viewpoint.camera();
    let parameters = camera.parameters().into_iter();
    LightCamera {
        sensor_from_camera: viewpoint.sensor_from_camera,
        width_px: camera.width_px(),
        height_px: camera.height_px(),
        lens: camera.lens().model_name(),
        parameters: parameters.map(|(name, value)| (name.to_owned(), json!(value))).collect(),
    }
}

/// Describes a body as placed in the sensor; `None` for bodies that are not, such as tools.
fn describe_body<'a>(
    sensor: &Sensor,
    body: &'a Body,
    pupil: &Point3<f64>,
) -> Result<Option<LightBody<'a>>, InvalidStack> {
    let place = Assembly::sensor();
    let mut placements: Vec<LightPlacement> = Vec::new();
    let part = OpticalRole::from_body(sensor, body);
    for placed in body.placements.iter().filter(|placed| placed.assembly == place) {
        let pose = placed.assembly_from_body;
        let of_body = |source| InvalidStack::Solid { body: body.name.clone(), source };
        let solid = CompiledSolid::new(&body.solid.clone().placed(pose)).map_err(of_body)?;
        // An opaque part around the pupil is the camera's own housing: rays must start inside it.
        let is_cameras_own =
            part.as_ref().is_ok_and(|part| part.is_stop()) && solid.contains(pupil);
        placements.push(LightPlacement { sensor_from_body: pose, is_cameras_own });
    }
    if placements.is_empty() {
        return Ok(None);
    }
    let (part, is_skin) = match part? {
        OpticalRole::Medium { is_skin, .. } => (LightRole::Medium, is_skin),
        // No body has this role by itself.
        OpticalRole::Surroundings => (LightRole::Medium, false),
        OpticalRole::Skin => (LightRole::Skin, true),
        OpticalRole::Opaque { is_skin } => (LightRole::Stop, is_skin),
    };
    Ok(Some(LightBody {
        name: &body.name,
        kind: body.kind.word(),
        material: &body.material,
        clarity: match body.clarity() {
            OpticalClarity::Clear => "clear",
            OpticalClarity::Translucent => "translucent",
            OpticalClarity::Opaque => "opaque",
        },
        refractive_index: body.substance.refractive_index,
        is_looked_at: sensor.visible_bodies.contains(&body.name) || body.is_deformable,
        is_marker: sensor.is_marker_body(&body.name),
        part,
        is_skin,
        placements,
        solid: &body.solid,
    }))
}

fn surface(touch: &TouchSurface) -> LightSurface<'_> {
    let foot_z_mm = touch.foot_z_mm();
    let solid: Solid = touch.solid(0.0, foot_z_mm - SURFACE_EXTENSION_MM);
    let dome = touch.dome().map(|dome| LightDome {
        equatorial_mm: dome.dome.equatorial_mm,
        polar_mm: dome.dome.polar_mm,
        offset_mm: dome.dome.offset_mm,
        centre_z_mm: dome.centre_z_mm,
    });
    let plane =
        touch.plane().map(|pad| LightPlane { outline: &pad.outline, top_z_mm: pad.top_z_mm });
    LightSurface { solid, foot_z_mm, dome, plane }
}
