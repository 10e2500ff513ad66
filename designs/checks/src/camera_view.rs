//! View of the camera: it sees what it should through clear bodies, and with enough pixels.
//!
//! Rays leave the pupil evenly, once in all directions and once towards the bodies in view, which may be small. Each
//! ray represents a piece of the surface that it meets and the pixels in its direction. Rays are not refracted, and
//! only the nominal projection of the lens is used; the limits are far larger than either error.

use std::collections::BTreeMap;

use fabkit_geometry::{
    Aabb, Assembly, NominalCamera, OpticalClarity, Point3, Ray, Sensor, TouchSurface, Vector3,
};
use rayon::prelude::*;

use crate::declaration::rule;
use crate::finding::Finding;
use crate::hardness;
use crate::illumination;
use crate::material_questions::MaterialQuestions;
use crate::rule::Rule;
use crate::rule_input::{RuleInput, RuleResult};
use crate::sampling_lines::{Caster, basis, steepness};
use crate::scene::{Assemblies, Placed};

rule! {
    /// The camera sees what it should.
    Sight = "sight",
    examines: "bodies in view",
    finds: "a surface or markers that are hidden, lie outside the image or are covered by too \
             few pixels; light from outside; markers at the image's edge; and, for rays through \
             the drawn bodies, the visible fractions of surface and markers and the bodies that \
             hide the rest (a note), a middle of the surface or markers that are not visible, and \
             a body that hides much (warnings); a diffuser that stops the light, and one that \
             spreads none or a coat too dark to show its slopes (warnings)",
    limit: "a third hidden, two thirds outside, 100 px for a surface, half a pixel for a marker, \
             3 % at the edge, which is a maker's tolerance of the view and of the chip's \
             position; for refracted rays a tenth of that third of the surface which is nearest \
             to its tip or middle, a twentieth of the markers, a tenth of the surface hidden by \
             one body (chosen: published sensors lose 4, 2 and 3 %); a tenth of the light through a \
             diffuser and from a coat (chosen: frosted sheets pass 30 % and more, reflective coats \
             send back 30 to 60 %, black ones 5 %)",
    for_variants: true,
    look: apply,
}

fn apply(case: &RuleInput<'_>) -> RuleResult {
    let (mut unseen, to_be_seen) = examine(case.sensor, case.scene, &case.questions);
    unseen.extend(hardness::contrasts(case.sensor, &case.questions));
    unseen.extend(illumination::examine(case.sensor, &case.questions));
    Ok((unseen, to_be_seen))
}

/// Number of rays in all directions, and again towards the bodies in view.
const RAYS: usize = 8_192;

/// Largest fraction of the bodies in view that may lie outside the image; some flat sensors look only at the middle of
/// their pads.
const MOST_UNSEEN: f64 = 2.0 / 3.0;

/// Largest fraction that one body may hide; the window's rim of a small flat sensor hides a fifth.
const MOST_HIDDEN: f64 = 1.0 / 3.0;

/// Smallest number of pixels that look at a surface, and at each marker. The chip of an optical mouse with 30 x 30
/// pixels, the smallest in use, has one for each marker.
const LEAST_PIXELS: [f64; 2] = [100.0, 0.5];

/// Largest fraction of the image that looks out of the sensor.
const MOST_OUTSIDE: f64 = 0.01;

/// Smallest margin between markers and the image's edge, as a fraction of the half width or height, or of the view. The
/// makers' tolerance of the view is 1 to 2 percent, and a chip that is off the lens's axis takes another one.
const LEAST_MARGIN: f64 = 0.03;

/// Smallest steepness with which a face is weighted, which limits the weight of grazing rays.
const LEAST_STEEPNESS: f64 = 0.05;

/// Sums over the rays.
#[derive(Debug, Default)]
struct ViewSums<'a> {
    /// Area of the bodies in view, mm2: total, within the image, and hidden, by the body that hides it.
    all_mm2: f64,
    seen_mm2: f64,
    hidden_mm2: BTreeMap<&'a str, f64>,
    /// Pixels that look at the bodies in view, pixels that look out of the sensor, and all pixels.
    on_it_px: f64,
    outside_px: f64,
    all_px: f64,
    /// Largest distance of the bodies in view from the image's centre; 1 at its edge.
    reach: f64,
}

/// A body that blocks or scatters light, or that the camera should see.
pub(crate) struct ViewBody<'a> {
    pub(crate) placed: &'a Placed<'a>,
    pub(crate) clarity: OpticalClarity,
    pub(crate) is_target: bool,
}

/// Finds what keeps the camera from seeing. Also returns the number of bodies in view.
pub(crate) fn examine(
    sensor: &Sensor,
    scene: &Assemblies,
    questions: &MaterialQuestions,
) -> (Vec<Finding>, usize) {
    if sensor.visible_bodies.is_empty() {
        return (Vec::new(), 0);
    }
    let seen = look(sensor, scene, questions);
    let names = || sensor.visible_bodies.iter().map(String::as_str);
    let mut findings = Vec::new();
    let mut add = |finding: Finding| {
        findings.push(finding.in_assembly(&Assembly::sensor().0));
    };
    // If there is no area at all, none of it is seen.
    let share_of = |mm2: f64| if seen.all_mm2 > 0.0 { mm2 / seen.all_mm2 } else { 0.0 };
    let outside = seen.outside_px / seen.all_px;
    if outside > MOST_OUTSIDE {
        let message = format!("the camera sees out of the sensor past {}", listed(sensor));
        let fix = "take an opaque material around the bodies in view: daylight enters where the camera looks out";
        let finding = Finding::error(Rule::Sight, message, fix).about_bodies(names());
        add(finding.with_measurement(outside, MOST_OUTSIDE, ""));
        return (findings, sensor.visible_bodies.len());
    }
    for (by, hidden_mm2) in &seen.hidden_mm2 {
        let share = share_of(*hidden_mm2);
        if share > MOST_HIDDEN {
            let message = format!("{by} stands between the camera and {}", listed(sensor));
            let fix = format!("take a clear material for {by}, or make its opening wider");
            let bodies = std::iter::once(*by).chain(names());
            add(Finding::error(Rule::Sight, message, fix).about_bodies(bodies).with_measurement(
                share,
                MOST_HIDDEN,
                "",
            ));
        }
    }
    // A hidden surface has few pixels for that reason alone.
    let is_hidden = seen.hidden_mm2.values().any(|mm2| share_of(*mm2) > MOST_HIDDEN);
    let hidden: f64 = seen.hidden_mm2.values().sum();
    let unseen = 1.0 - share_of(seen.seen_mm2 + hidden);
    if unseen > MOST_UNSEEN {
        let message = format!("most of {} lies outside the camera's image", listed(sensor));
        let fix = "take a lens with a wider view, or move the camera further away";
        let finding = Finding::error(Rule::Sight, message, fix).about_bodies(names());
        add(finding.with_measurement(unseen, MOST_UNSEEN, ""));
    }
    let least_px = least_pixels(sensor);
    if seen.on_it_px < least_px && !is_hidden {
        let message = format!("too few pixels look at {}", listed(sensor));
        let fix = "take a camera with more pixels, or a lens with a narrower view";
        let finding = Finding::error(Rule::Sight, message, fix).about_bodies(names());
        add(finding.with_measurement(seen.on_it_px.round(), least_px, "px"));
    }
    if is_markers(sensor) && seen.reach > 1.0 - LEAST_MARGIN {
        let message = format!("{} reach to the edge of the image or beyond", listed(sensor));
        let fix = "move the markers further in or the camera further away, or take a lens with a wider view";
        let finding = Finding::error(Rule::Sight, message, fix).about_bodies(names());
        add(finding.with_measurement(1.0 - seen.reach, LEAST_MARGIN, ""));
    }
    (findings, sensor.visible_bodies.len())
}

/// Returns whether the bodies in view are many small markers, each of which counts.
pub(crate) fn is_markers(sensor: &Sensor) -> bool {
    pieces(sensor) > sensor.visible_bodies.len()
}

/// Counts the pieces of the bodies in view.
fn pieces(sensor: &Sensor) -> usize {
    let shells = sensor.visible_bodies.iter().filter_map(|name| sensor.body(name)?.shells);
    shells.map(|shells| shells.pieces).sum()
}

/// Formats the names of the bodies in view.
pub(crate) fn listed(sensor: &Sensor) -> String {
    sensor.visible_bodies.join(" and ")
}

/// Returns the smallest number of pixels for the bodies in view.
fn least_pixels(sensor: &Sensor) -> f64 {
    let [of_surface, of_marker] = LEAST_PIXELS;
    if is_markers(sensor) { of_marker * pieces(sensor) as f64 } else { of_surface }
}

/// Returns the bodies that rays of the camera meet in the sensor, without those of unknown transparency. `rule` is the one
/// that needs them.
pub(crate) fn bodies<'a>(
    sensor: &Sensor,
    scene: &'a Assemblies,
    rule: Rule,
    questions: &MaterialQuestions,
) -> Vec<ViewBody<'a>> {
    let pupil = sensor.camera.sensor_from_camera.point(Point3::origin());
    scene
        .bodies(&Assembly::sensor().0)
        .iter()
        // The pupil lies inside the lens or the housing around it, which would block every ray.
        .filter(|placed| !placed.body.contains(&pupil))
        .filter_map(|placed| {
            let clarity = questions.transparency(rule, sensor.body(placed.name)?)?;
            let is_wanted = sensor.visible_bodies.iter().any(|name| name == placed.name);
            // Light passes other clear bodies as if they were not there.
            let counts = is_wanted || clarity != OpticalClarity::Clear;
            counts.then_some(ViewBody { placed, clarity, is_target: is_wanted })
        })
        .collect()
}

/// Casts rays in all directions and towards the bodies in view.
fn look<'a>(
    sensor: &'a Sensor,
    scene: &'a Assemblies,
    questions: &MaterialQuestions,
) -> ViewSums<'a> {
    let camera = &sensor.camera;
    let pupil = camera.sensor_from_camera.point(Point3::origin());
    let is_pad = matches!(sensor.touch, Some(TouchSurface::Plane(_)));
    let bodies = bodies(sensor, scene, Rule::Sight, questions);
    let wide = cast(camera, &bodies, &Cone::ALL, is_pad);
    let near = cast(camera, &bodies, &Cone::around(&bodies, &pupil), is_pad);
    // The narrow cone samples the bodies in view; only the full sphere measures the image as a whole.
    ViewSums { outside_px: wide.outside_px, all_px: wide.all_px, ..near }
}

/// Cone of directions around an axis.
pub(crate) struct Cone {
    pub(crate) axis: Vector3<f64>,
    /// Cosine of the angle between the axis and the outermost directions.
    pub(crate) cosine: f64,
}

impl Cone {
    /// All directions.
    const ALL: Self = Self { axis: Vector3::new(0.0, 0.0, 1.0), cosine: -1.0 };

    /// Creates the cone of directions from a point to the bodies in view; all directions if the point lies among them.
    pub(crate) fn around(bodies: &[ViewBody], point: &Point3<f64>) -> Self {
        let wanted = bodies.iter().filter(|met| met.is_target).map(|met| met.placed.body.bounds());
        let bounds = wanted.fold(Aabb::nothing(), |hull, bounds| hull.hull(&bounds));
        let towards = bounds.centre() - point;
        let [radius, distance] = [(bounds.max - bounds.centre()).norm(), towards.norm()];
        if bounds.is_empty() || radius >= distance {
            return Self::ALL;
        }
        Self { axis: towards / distance, cosine: (1.0 - (radius / distance).powi(2)).sqrt() }
    }

    /// Returns the solid angle of one of `rays` rays.
    pub(crate) fn solid_angle(&self, rays: usize) -> f64 {
        2.0 * std::f64::consts::PI * (1.0 - self.cosine) / rays as f64
    }

    /// Returns one of `rays` directions, which are spread evenly (a Fibonacci lattice).
    pub(crate) fn direction(&self, number: usize, rays: usize) -> Vector3<f64> {
        let along = 1.0 - (1.0 - self.cosine) * (number as f64 + 0.5) / rays as f64;
        let turn = number as f64 * std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
        let (sin, cos) = turn.sin_cos();
        let across = (1.0 - along * along).sqrt();
        let [u, v] = basis(&self.axis);
        across * (cos * u + sin * v) + along * self.axis
    }
}

/// Casts the rays of a cone and sums up what they meet.
fn cast<'a>(
    camera: &NominalCamera,
    bodies: &[ViewBody<'a>],
    cone: &Cone,
    is_pad: bool,
) -> ViewSums<'a> {
    let pupil = camera.sensor_from_camera.point(Point3::origin());
    let solid_angle = cone.solid_angle(RAYS);
    (0..RAYS)
        .into_par_iter()
        .map_init(Caster::default, |caster, number| {
            let ray = Ray { origin: pupil, direction: cone.direction(number, RAYS) };
            let mut first: Option<(f64, &'a str, bool)> = None;
            let mut wanted: Option<(f64, f64)> = None;
            let mut is_dark = false;
            for ViewBody { placed, clarity, is_target: is_wanted } in bodies {
                let Some(enter) = caster.first_entry(&placed.body, &ray) else { continue };
                // A ray that meets no opaque body leads out of the sensor.
                is_dark |= *clarity == OpticalClarity::Opaque;
                if *clarity != OpticalClarity::Clear && first.is_none_or(|(t, _, _)| enter.t < t) {
                    first = Some((enter.t, placed.name, *is_wanted));
                }
                if *is_wanted && wanted.is_none_or(|(t, _)| enter.t < t) {
                    // On a pad only the pressed face counts, not its sides.
                    let share = if is_pad { enter.normal.z.abs() } else { 1.0 };
                    let steep = steepness(&ray, &enter).max(LEAST_STEEPNESS);
                    wanted = Some((enter.t, share * enter.t * enter.t / steep));
                }
            }
            // Pixels per steradian times the steradians of one ray.
            let pixels = pixels_per_steradian(camera, &ray.direction) * solid_angle;
            let is_first = matches!(first, Some((_, _, true)));
            let reach = if is_first { reach(camera, &ray.direction) } else { 0.0 };
            let wanted_mm2 = wanted.map_or(0.0, |(_, mm2)| mm2 * solid_angle);
            (pixels, first, wanted_mm2, is_dark, reach)
        })
        .collect::<Vec<_>>()
        .into_iter()
        // Summed in order, so that the result does not depend on the threads.
        .fold(ViewSums::default(), |mut seen, (pixels, first, area_mm2, is_dark, reach)| {
            seen.reach = seen.reach.max(reach);
            seen.all_px += pixels;
            seen.all_mm2 += area_mm2;
            seen.outside_px += if is_dark { 0.0 } else { pixels };
            match first {
                Some((_, _, true)) => {
                    seen.on_it_px += pixels;
                    seen.seen_mm2 += if pixels > 0.0 { area_mm2 } else { 0.0 };
                }
                Some((_, by, false)) if pixels > 0.0 && area_mm2 > 0.0 => {
                    *seen.hidden_mm2.entry(by).or_default() += area_mm2;
                }
                _ => {}
            }
            seen
        })
}

/// Projects a direction in the sensor's frame to the image. Returns the position relative to the image's centre, px,
/// the angle off the axis, rad, and the lengths of a radian there along and across the radius, px.
///
/// Uses only the projection of the lens, without refraction.
fn project_direction(
    camera: &NominalCamera,
    direction: &Vector3<f64>,
) -> ([f64; 2], f64, [f64; 2]) {
    let direction = camera.sensor_from_camera.inverse().vector(*direction);
    let focal_px = camera.focal_px();
    let across = direction.x.hypot(direction.y);
    let angle = across.atan2(direction.z);
    let radius_px = focal_px * camera.lens.projection.radius(angle);
    // On the axis both lengths equal the focal length.
    let scale = if across > 0.0 { radius_px / across } else { focal_px };
    let along = focal_px * camera.lens.projection.slope(angle);
    ([direction.x * scale, direction.y * scale], angle, [along, scale])
}

/// Returns the relative distance of a direction from the image's centre; 1 at its edge.
fn reach(camera: &NominalCamera, direction: &Vector3<f64>) -> f64 {
    let ([x, y], angle, _) = project_direction(camera, direction);
    let [width, height] = [camera.width_px, camera.height_px].map(f64::from);
    // The image is a rectangle, and its field of view a cone.
    let sides = (x.abs() / (width / 2.0)).max(y.abs() / (height / 2.0));
    sides.max(angle / (camera.field_of_view.rad() / 2.0))
}

/// Returns the number of pixels per steradian around a direction in the sensor's frame; 0 outside the image.
pub(crate) fn pixels_per_steradian(camera: &NominalCamera, direction: &Vector3<f64>) -> f64 {
    let [focal_px, scale] = project_direction(camera, direction).2;
    if reach(camera, direction) <= 1.0 { focal_px * scale } else { 0.0 }
}
