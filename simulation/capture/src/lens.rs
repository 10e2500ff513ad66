//! What the camera's lens does to what it shows: it is darker off its axis, and sharp at one distance.

use std::borrow::Cow;

use fabkit_designs::Design;
use fabkit_designs::parameters::Setting;
use fabkit_files::Error;
use fabkit_geometry::{LensImaging, Lighting, NominalCamera, Point3, Ray, Rgb, Sensor};
use fabkit_light::{Defocus, circle_px};
use fabkit_optics::{LightPath, Stack, Tracer};
use fabkit_scene::SceneError;
use fabkit_scene::ground_truth::Viewpoint;
use rayon::prelude::*;
use serde_json::{Value, json};

/// What pictures leave out of what lenses do, where their lens is said to do nothing.
pub(super) const LEFT_OUT: &str = "vignetting and defocus of the lens";

/// Nothing nearer to the optical centre is seen, mm.
const NEAREST_MM: f64 = 0.1;

/// What the lens does to each ray's light, the same for all pictures of a sensor through it: where disks depend on how far
/// away something is, that is where it is at rest.
#[derive(Debug)]
pub(super) struct LensEffects {
    /// Which part of its light arrives; empty where all does.
    falloff: Vec<f64>,
    defocus: Option<Defocus>,
}

impl LensEffects {
    /// Of a view of a sensor in a light; nothing where its lens is said to do nothing.
    pub(super) fn of(
        sensor: &Sensor,
        lighting: &Lighting,
        viewpoint: &Viewpoint,
        samples: u32,
    ) -> Result<Option<Self>, Error> {
        let LensImaging { falloff_power, pupil_mm, focus_mm } = imaging(sensor, lighting);
        if falloff_power == 0.0 && pupil_mm == 0.0 {
            return Ok(None);
        }
        let rays = viewpoint.rays(samples);
        let camera = viewpoint.camera().in_air();
        let part = |i: usize| {
            let ray = camera.unproject(&rays.at_px(i));
            ray.map_or(0.0, |ray| ray.direction.z.max(0.0).powf(falloff_power))
        };
        let falloff = match falloff_power > 0.0 {
            true => (0..rays.len()).into_par_iter().map(part).collect(),
            false => Vec::new(),
        };
        if pupil_mm == 0.0 {
            return Ok(Some(Self { falloff, defocus: None }));
        }
        let stack = stack(sensor, lighting, viewpoint)?;
        let focal = camera.lens().intrinsics();
        let focal_px = f64::midpoint(focal.fx_px, focal.fy_px) * f64::from(samples);
        let pose = &viewpoint.sensor_from_camera;
        let pupil = pose.point(Point3::origin());
        // How far away what it sees looks is counted from the pupil, and the drawn interface is near enough to the camera's own.
        let ray = |i: usize| match stack.is_entered() {
            true => {
                let direction = camera.unproject(&rays.at_px(i)).ok()?.direction;
                Some(Ray { origin: pupil, direction: pose.vector(direction) })
            }
            false => rays.ray(i),
        };
        let diameter = |tracer: &mut Tracer<'_>, i: usize| {
            let Some(ray) = ray(i) else { return 0.0 };
            let path = tracer.follow(&ray);
            circle_px(pupil_mm, focus_mm, apparent_mm(&ray, &path, tracer), focal_px)
        };
        let all = (0..rays.len()).into_par_iter();
        let diameters: Vec<f64> = all.map_init(|| Tracer::new(&stack), diameter).collect();
        let defocus = Defocus::new(&diameters, rays.width_px() as usize);
        Ok(Some(Self { falloff, defocus }))
    }

    /// Changes what rays see to what arrives at the chip.
    pub(super) fn apply(&self, light: &mut [Rgb]) {
        for (light, part) in light.iter_mut().zip(&self.falloff) {
            *light = light.map(|grey| part * grey);
        }
        if let Some(defocus) = &self.defocus {
            defocus.apply(light);
        }
    }
}

/// How far away along the ray the end of a path looks through air, mm: what is in a medium looks nearer by its index, as
/// rays near the normal of its faces show it. Along the ray, not along the axis: what wide lenses show near the picture's
/// edge is hardly before them at all, and they are not focused on a plane.
fn apparent_mm(ray: &Ray, path: &LightPath, tracer: &Tracer<'_>) -> f64 {
    if !path.end_mm.is_finite() {
        return f64::INFINITY;
    }
    let (mut from, mut index, mut sum_mm) = (ray.origin, 1.0, 0.0);
    for bend in tracer.bends() {
        sum_mm += (bend.place - from).norm() / bend.indices[0];
        (from, index) = (bend.place, bend.indices[1]);
    }
    sum_mm += (path.last.at(path.end_mm) - from).norm() / index;
    sum_mm.max(NEAREST_MM)
}

fn stack(sensor: &Sensor, lighting: &Lighting, viewpoint: &Viewpoint) -> Result<Stack, Error> {
    // Seen by the camera that looks at it.
    let seen = match &lighting.camera {
        Some(camera) => Cow::Owned(Sensor { camera: camera.clone(), ..sensor.clone() }),
        None => Cow::Borrowed(sensor),
    };
    Ok(viewpoint.stack(&seen).map_err(SceneError::Light)?)
}

fn imaging(sensor: &Sensor, lighting: &Lighting) -> LensImaging {
    let camera: &NominalCamera = lighting.camera.as_ref().unwrap_or(&sensor.camera);
    camera.lens.imaging
}

/// What the lens's part of pictures rests on, as constants; nothing where it has none.
pub(super) fn constants(design: &Design, lighting: &Lighting) -> Vec<Value> {
    let LensImaging { falloff_power, pupil_mm, focus_mm } = imaging(&design.sensor, lighting);
    let constant = |name: &str, value: f64, key: &str| {
        let is_it = |setting: &&Setting| setting.path == format!("camera.{key}");
        let source = design.parameters.iter().find(is_it).map(|setting| &setting.source);
        json!({
            "name": name,
            "value": value,
            "known": source.map_or("chosen", |source| source.kind.word()),
            "source": source.map_or("", |source| &source.note),
        })
    };
    let mut all = Vec::new();
    if falloff_power > 0.0 {
        all.push(constant("vignetting_power", falloff_power, "vignetting"));
    }
    if pupil_mm > 0.0 {
        all.push(constant("aperture_mm", pupil_mm, "aperture"));
        all.push(constant("focus_mm", focus_mm, "focus"));
    }
    all
}

/// What pictures leave out of what lenses do.
pub(super) fn left_out(sensor: &Sensor, lighting: &Lighting) -> Vec<&'static str> {
    let LensImaging { falloff_power, pupil_mm, .. } = imaging(sensor, lighting);
    match (falloff_power > 0.0, pupil_mm > 0.0) {
        (false, false) => vec![LEFT_OUT],
        (false, true) => vec!["vignetting of the lens", "that what moves is defocused otherwise"],
        (true, false) => vec!["defocus of the lens"],
        (true, true) => vec!["that what moves is defocused otherwise"],
    }
}
