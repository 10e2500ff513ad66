//! Lens effects on captures: vignetting and defocus.

use std::borrow::Cow;

use fabkit_designs::Design;
use fabkit_designs::parameters::Setting;
use fabkit_files::Error;
use fabkit_geometry::{LensImaging, Lighting, NominalCamera, Point3, Ray, Rgb, Sensor};
use fabkit_light::{Defocus, blur_diameter_px};
use fabkit_optics::{LightPath, OpticalStack, Tracer};
use fabkit_scene::SceneError;
use fabkit_scene::ground_truth::Viewpoint;
use rayon::prelude::*;
use serde_json::{Value, json};

/// Effects left out where the lens has neither vignetting nor an aperture.
pub(super) const OMITTED_EFFECTS: &str = "vignetting and defocus of the lens";

/// Smallest apparent distance from the optical centre, mm.
const NEAREST_MM: f64 = 0.1;

/// Effects of the lens on each ray, the same for all captures of a view. Blur disks are computed for distances at rest.
#[derive(Debug)]
pub(super) struct LensEffects {
    /// Transmitted share of each ray's light; empty without vignetting.
    falloff: Vec<f64>,
    defocus: Option<Defocus>,
}

impl LensEffects {
    /// Computes the effects for a view of a sensor; `None` for a lens without vignetting and aperture.
    pub(super) fn new(
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
        let camera = viewpoint.camera().without_interface();
        let part = |i: usize| {
            let ray = camera.unproject(&rays.at_px(i));
            // Natural vignetting: a power of the cosine of the angle to the axis.
            ray.map_or(0.0, |ray| ray.direction.z.max(0.0).powf(falloff_power))
        };
        let falloff = if falloff_power > 0.0 {
            (0..rays.len()).into_par_iter().map(part).collect()
        } else {
            Vec::new()
        };
        if pupil_mm == 0.0 {
            return Ok(Some(Self { falloff, defocus: None }));
        }
        let stack = stack(sensor, lighting, viewpoint)?;
        let focal = camera.lens().intrinsics();
        let focal_px = f64::midpoint(focal.fx_px, focal.fy_px) * f64::from(samples);
        let pose = &viewpoint.sensor_from_camera;
        let pupil = pose.point(Point3::origin());
        // Apparent distances are measured from the pupil, so rays start there. The drawn interface is close enough to
        // that of the camera model.
        let ray = |i: usize| {
            if stack.starts_behind_interface() {
                let direction = camera.unproject(&rays.at_px(i)).ok()?.direction;
                Some(Ray { origin: pupil, direction: pose.vector(direction) })
            } else {
                rays.ray(i)
            }
        };
        let diameter = |tracer: &mut Tracer<'_>, i: usize| {
            let Some(ray) = ray(i) else { return 0.0 };
            let path = tracer.follow(&ray);
            blur_diameter_px(
                pupil_mm,
                focus_mm,
                apparent_distance_mm(&ray, &path, tracer),
                focal_px,
            )
        };
        let all = (0..rays.len()).into_par_iter();
        let diameters: Vec<f64> = all.map_init(|| Tracer::new(&stack), diameter).collect();
        let defocus = Defocus::new(&diameters, rays.width_px() as usize);
        Ok(Some(Self { falloff, defocus }))
    }

    /// Turns the light that rays see into the light that arrives at the chip.
    pub(super) fn apply(&self, light: &mut [Rgb]) {
        for (light, part) in light.iter_mut().zip(&self.falloff) {
            *light = light.map(|grey| part * grey);
        }
        if let Some(defocus) = &self.defocus {
            defocus.apply(light);
        }
    }
}

/// Returns the apparent distance of a path's end along the ray, as seen through air, mm. A length in a medium counts
/// divided by its index, which holds for rays near the normal of the media's faces. The distance is taken along the
/// ray, not along the axis: near the image's edge, wide lenses see points that are hardly in front of them, and their
/// focus is not on a plane.
fn apparent_distance_mm(ray: &Ray, path: &LightPath, tracer: &Tracer<'_>) -> f64 {
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

fn stack(
    sensor: &Sensor,
    lighting: &Lighting,
    viewpoint: &Viewpoint,
) -> Result<OpticalStack, Error> {
    // The stack must belong to the camera of this lighting, which may not be the sensor's own.
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

/// Returns the constants of the lens as JSON; empty if it has no effects.
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

/// Returns the lens effects that captures leave out.
pub(super) fn omitted_effects(sensor: &Sensor, lighting: &Lighting) -> Vec<&'static str> {
    let LensImaging { falloff_power, pupil_mm, .. } = imaging(sensor, lighting);
    match (falloff_power > 0.0, pupil_mm > 0.0) {
        (false, false) => vec![OMITTED_EFFECTS],
        (false, true) => vec!["vignetting of the lens", "that what moves is defocused otherwise"],
        (true, false) => vec!["defocus of the lens"],
        (true, true) => vec!["that what moves is defocused otherwise"],
    }
}
