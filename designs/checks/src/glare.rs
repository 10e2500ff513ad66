//! Glare: mirror images of LEDs in faces between air and a clear body.
//!
//! Rays leave the pupil evenly over the image. At each face with air on one side, a few percent of the light is
//! reflected (Fresnel). If the reflected ray ends on a light source, the camera sees the source there, brighter than
//! the surface behind it. Rays are not refracted: the position of an image in the first face is exact, that in a later
//! face is off by the refraction before it.

use std::collections::{BTreeMap, BTreeSet};

use fabkit_geometry::{
    Assembly, Body, CompiledSolid, NominalCamera, OpticalClarity, Point3, Ray, Sensor, Vector3,
};
use rayon::prelude::*;

use crate::camera_view::{Cone, pixels_per_steradian};
use crate::declaration::rule;
use crate::finding::{Finding, Severity};
use crate::material_questions::MaterialQuestions;
use crate::rule::Rule;
use crate::rule_input::{RuleInput, RuleResult};
use crate::sampling_lines::{Caster, Stretch};
use crate::scene::{Assemblies, InvalidBody, Placed};

rule! {
    /// No light source is mirrored into the image.
    Glare = "glare",
    examines: "light sources",
    finds: "light sources that a face between air and a clear body reflects into the image",
    limit: "half a percent of the image, within half of the view, is a warning; further out it \
             is a note, because most published sensors with bare LEDs beside a flat window have \
             such reflections",
    for_variants: true,
    look: apply,
}

fn apply(case: &RuleInput<'_>) -> RuleResult {
    examine(case.sensor, case.scene, &case.questions)
}

/// Number of rays over the image: about eight meet a light source of 3 x 3 mm that is 30 mm behind its mirror.
const RAYS: usize = 8_192;

/// Largest gap between bodies that touch and reflect no light between them, mm.
const TOGETHER_MM: f64 = 1e-3;

/// Smallest fraction of the image for which mirror images are reported: a light source or two.
const LEAST_TOLD: f64 = 0.005;

/// Fraction of the field of view, from its axis, in which mirror images are a warning. In nearly every published sensor
/// with a flat window, bare LEDs are mirrored near the image's edge.
const MIDDLE: f64 = 0.5;

/// A body of the sensor with its optical properties.
struct OpticalBody<'a> {
    placed: &'a Placed<'a>,
    clarity: OpticalClarity,
    /// Emitting solid, if the body is a light source.
    emitter: Option<CompiledSolid>,
}

/// A ray that shows a mirror image of a light source.
struct MirrorImage<'a> {
    mirror: &'a str,
    lamp: usize,
    angle_rad: f64,
    pixels: f64,
    place: Point3<f64>,
}

/// Finds mirror images. Also returns the number of light sources.
///
/// # Errors
/// [`InvalidBody`] if the emitting solid of a light source is not valid.
pub(crate) fn examine(
    sensor: &Sensor,
    scene: &Assemblies,
    questions: &MaterialQuestions,
) -> Result<(Vec<Finding>, usize), InvalidBody> {
    let bodies = optical_bodies(sensor, scene, questions)?;
    let lamps = bodies.iter().filter(|body| body.emitter.is_some()).count();
    if lamps == 0 || sensor.visible_bodies.is_empty() {
        return Ok((Vec::new(), lamps));
    }
    let (images, all_px) = look(&sensor.camera, &bodies);
    let mut mirrors = BTreeMap::<&str, Vec<&MirrorImage>>::new();
    for image in &images {
        mirrors.entry(image.mirror).or_default().push(image);
    }
    let findings = mirrors.into_iter().filter_map(|(mirror, images)| {
        let half_rad = MIDDLE * sensor.camera.field_of_view.rad() / 2.0;
        let share_of = |images: &[&MirrorImage]| sum_px(images) / all_px;
        let inner: Vec<&MirrorImage> =
            images.iter().copied().filter(|image| image.angle_rad < half_rad).collect();
        let is_amid = share_of(&inner) > LEAST_TOLD;
        let told = if is_amid { inner } else { images };
        let severity = if is_amid { Severity::Warning } else { Severity::Note };
        let share = share_of(&told);
        (share > LEAST_TOLD).then(|| finding(mirror, &told, share, lamps).with_severity(severity))
    });
    Ok((findings.collect(), lamps))
}

fn sum_px(images: &[&MirrorImage]) -> f64 {
    images.iter().map(|image| image.pixels).sum()
}

fn finding(mirror: &str, images: &[&MirrorImage], share: f64, lamps: usize) -> Finding {
    let seen: BTreeSet<usize> = images.iter().map(|image| image.lamp).collect();
    let mut angles: Vec<f64> = images.iter().map(|image| image.angle_rad.to_degrees()).collect();
    // The median angle stands for all rays of the image.
    angles.sort_by(f64::total_cmp);
    let middle_deg = angles[angles.len() / 2];
    let message = format!(
        "{mirror} mirrors {} of {lamps} light sources into the image, about {middle_deg:.0} degrees off the axis",
        seen.len()
    );
    let fix = "move the light sources further out, keep air from the face, shade them, or make the face matt";
    Finding::error(Rule::Glare, message, fix)
        .in_assembly(&Assembly::sensor().0)
        .about_bodies([mirror])
        .at_position(images.first().map(|image| image.place))
        .with_measurement(share, LEAST_TOLD, "")
}

fn optical_bodies<'a>(
    sensor: &'a Sensor,
    scene: &'a Assemblies,
    questions: &MaterialQuestions,
) -> Result<Vec<OpticalBody<'a>>, InvalidBody> {
    let pupil = sensor.camera.sensor_from_camera.point(Point3::origin());
    let mut lit = Vec::new();
    let mut number = BTreeMap::<&str, usize>::new();
    for placed in scene.bodies(&Assembly::sensor().0) {
        let Some(body) = sensor.body(placed.name) else { continue };
        // Placements are counted by name, to find the emitter of each copy.
        let place = number.entry(placed.name).or_default();
        let lamp = compile_emitter(body, *place)?;
        *place += 1;
        // The pupil lies inside the lens or the housing around it, which would block every ray.
        if placed.body.contains(&pupil) {
            continue;
        }
        if let Some(clarity) = questions.transparency(Rule::Glare, body) {
            lit.push(OpticalBody { placed, clarity, emitter: lamp });
        }
    }
    Ok(lit)
}

/// Compiles the emitting solid of a body at its placement number `place` in the sensor.
fn compile_emitter(body: &Body, place: usize) -> Result<Option<CompiledSolid>, InvalidBody> {
    let mut in_sensor = body.placements.iter().filter(|place| place.assembly == Assembly::sensor());
    let (Some(solid), Some(placement)) = (&body.light_source, in_sensor.nth(place)) else {
        return Ok(None);
    };
    let compiled = CompiledSolid::new(&solid.clone().placed(placement.assembly_from_body));
    compiled.map(Some).map_err(|source| InvalidBody { body: body.name.clone(), source })
}

/// Returns every ray that shows a mirror image, and the number of pixels of the whole image.
fn look<'a>(camera: &NominalCamera, bodies: &[OpticalBody<'a>]) -> (Vec<MirrorImage<'a>>, f64) {
    let pupil = camera.sensor_from_camera.point(Point3::origin());
    let axis = camera.sensor_from_camera.vector(Vector3::z());
    // A view can be wider than all directions.
    let half = (camera.field_of_view.rad() / 2.0).min(std::f64::consts::PI);
    let cone = Cone { axis, cosine: half.cos() };
    let solid_angle = cone.solid_angle(RAYS);
    let rays: Vec<(Vec<MirrorImage>, f64)> = (0..RAYS)
        .into_par_iter()
        .map_init(Caster::default, |caster, number| {
            let direction = cone.direction(number, RAYS);
            let pixels = pixels_per_steradian(camera, &direction) * solid_angle;
            if pixels == 0.0 {
                return (Vec::new(), 0.0);
            }
            let ray = Ray { origin: pupil, direction };
            let angle_rad = direction.dot(&axis).clamp(-1.0, 1.0).acos();
            let faces = faces(bodies, &ray, caster);
            let images = faces.into_iter().filter_map(|(mirror, t, normal)| {
                // Law of reflection; the sign of the normal does not matter.
                let thrown = direction - 2.0 * direction.dot(&normal) * normal;
                let thrown = Ray { origin: ray.at(t), direction: thrown };
                let lamp = find_light_source(bodies, &thrown, caster)?;
                Some(MirrorImage { mirror, lamp, angle_rad, pixels, place: ray.at(t) })
            });
            (images.collect(), pixels)
        })
        .collect();
    let all_px = rays.iter().map(|(_, pixels)| pixels).sum();
    (rays.into_iter().flat_map(|(images, _)| images).collect(), all_px)
}

/// Finds the faces between air and a clear body that a ray crosses before it ends. Returns the body's name, the
/// distance along the ray, mm, and the normal.
fn faces<'a>(
    bodies: &[OpticalBody<'a>],
    ray: &Ray,
    caster: &mut Caster,
) -> Vec<(&'a str, f64, Vector3<f64>)> {
    let mut ends = f64::INFINITY;
    let mut clear: Vec<(&str, Stretch)> = Vec::new();
    for OpticalBody { placed, clarity, emitter: lamp } in bodies {
        for stretch in caster.stretches(&placed.body, ray) {
            if stretch.exit.t <= 0.0 {
                continue;
            }
            // LEDs end rays even if their body is clear.
            if *clarity == OpticalClarity::Clear && lamp.is_none() {
                clear.push((placed.name, stretch));
            } else {
                ends = ends.min(stretch.enter.t);
            }
        }
    }
    let is_air = |t: f64| {
        t < ends - TOGETHER_MM
            && clear.iter().all(|(_, stretch)| t < stretch.enter.t || t > stretch.exit.t)
    };
    let mut faces = Vec::new();
    for (name, Stretch { enter, exit }) in &clear {
        // The outside of a face lies before its entry and behind its exit.
        let sides = [(enter, -TOGETHER_MM), (exit, TOGETHER_MM)];
        for (crossing, outwards_mm) in sides {
            if crossing.t > 0.0 && crossing.t < ends && is_air(crossing.t + outwards_mm) {
                faces.push((*name, crossing.t, crossing.normal));
            }
        }
    }
    faces
}

/// Returns the index of the light source on which a ray ends; `None` if it ends elsewhere.
fn find_light_source(bodies: &[OpticalBody], ray: &Ray, caster: &mut Caster) -> Option<usize> {
    let mut enters = |body: &CompiledSolid| {
        let mut enters = caster.stretches(body, ray).map(|stretch| stretch.enter.t);
        enters.find(|t| *t > TOGETHER_MM)
    };
    let mut first: Option<(f64, usize)> = None;
    for (number, body) in bodies.iter().enumerate() {
        if body.emitter.is_none() && body.clarity == OpticalClarity::Clear {
            continue;
        }
        if let Some(t) = enters(&body.placed.body)
            && first.is_none_or(|(nearest, _)| t < nearest)
        {
            first = Some((t, number));
        }
    }
    let (t, number) = first?;
    // The ray must meet the emitter where it meets the body, not the LED's housing beside it.
    let shines = enters(bodies[number].emitter.as_ref()?)? <= t + TOGETHER_MM;
    shines.then_some(number)
}
