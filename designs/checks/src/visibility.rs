//! Fraction of the touch surface, or of the markers, that the camera sees through the drawn bodies.
//!
//! Points are viewed as in ground truth: light is refracted at the drawn faces and ends at opaque bodies. The fraction
//! that is lost, and its causes, are always reported as a note. They are a warning where the sensor cannot do its task:
//!
//! - A camera that follows *markers* must see them: a pin that it does not see measures nothing.
//! - A camera that looks at a *surface* must see its middle, which is touched most: the third of the area that is
//!   nearest to the tip of a dome or to the middle of a pad. The foot of a dome or the corners of a pad lie outside the
//!   image of most published sensors, which say so.
//! - No body may hide much of the rest. What lies outside the image is a choice of lens; what a rim hides is nobody's
//!   choice.

use std::collections::BTreeMap;

use fabkit_camera::Camera;
use fabkit_geometry::sequences::EvenPoints;
use fabkit_geometry::{Assembly, InvalidSolid, Point3, Ray, Sensor, SurfacePoints, TouchSurface};
use fabkit_optics::{
    CameraView, InvalidStack, InvisibleReason, OpticalStack, ViewStacks, describe_losses,
};

use crate::camera_view::{Cone, bodies, is_markers, listed};
use crate::finding::{Finding, Severity};
use crate::material_questions::MaterialQuestions;
use crate::rule::Rule;
use crate::sampling_lines::{Caster, steepness};
use crate::scene::{Assemblies, InvalidBody};

/// Number of points that are viewed; gives fractions to about a hundredth.
const PLACES: usize = 256;

/// Fraction of the surface that counts as its middle.
const MIDDLE: f64 = 1.0 / 3.0;

/// Largest fraction of the middle that may be lost; the image of a published dome cuts off 4 % at its sides.
const MOST_LOST: f64 = 0.1;

/// Largest fraction of markers that may be lost; the rim of an LED ring hides 2 % of the markers of a published tip.
const MOST_MARKERS_LOST: f64 = 0.05;

/// Largest fraction of the whole surface that one body may hide.
const MOST_HIDDEN: f64 = 0.1;

/// Smallest steepness with which a marker's face is weighted, which limits the weight of grazing rays.
const LEAST_STEEPNESS: f64 = 0.05;

/// A point with its weight; `counts` tells whether it belongs to the part that must be seen.
struct Place {
    point: Point3<f64>,
    weight: f64,
    counts: bool,
}

/// Lost fractions by cause, the largest first.
type Shares = Vec<(String, f64)>;

/// Compares the visible fractions with their limits. Returns nothing for a sensor without a camera.
pub(crate) fn examine(sensor: &Sensor) -> Result<Vec<Finding>, InvalidBody> {
    if sensor.visible_bodies.is_empty() {
        return Ok(Vec::new());
    }
    let camera = &sensor.camera;
    let terms = camera.lens.projection.terms();
    let view_rad = camera.field_of_view.rad();
    let camera = Camera::from_data_sheet(camera.width_px, camera.height_px, view_rad, terms);
    // The limits of the parameters exclude invalid cameras.
    let Ok(camera) = camera else { return Ok(Vec::new()) };
    let sights = match OpticalStack::from_sensor(sensor) {
        Ok(stack) => ViewStacks::new(stack),
        Err(InvalidStack::Solid { body, source }) => return Err(InvalidBody { body, source }),
        Err(error) => return Ok(vec![unknown(&error)]),
    };
    let mut viewer = CameraView::new(&camera, &sensor.camera.sensor_from_camera, &sights);
    let mut findings = Vec::new();
    if let Some(touch) = &sensor.touch {
        let of_surface = |source| InvalidBody { body: "surface".into(), source };
        let places = sample_surface(touch).map_err(of_surface)?;
        let (all, counting) = look(&places, &mut viewer, sights.stack());
        findings.push(note(
            "the sensing surface",
            &all,
            "depth SENSOR --reference --coverage-map FILE.png",
        ));
        if !is_markers(sensor) {
            // One cause is reported once.
            findings.extend(middle(sensor, &counting).or_else(|| hidden(sensor, &all)));
        }
    }
    if is_markers(sensor) {
        let places = sample_markers(sensor)?;
        let (all, _) = look(&places, &mut viewer, sights.stack());
        findings.push(note(&listed(sensor), &all, "render SENSOR --camera -o FILE.png"));
        findings.extend(markers(sensor, &all));
    }
    Ok(findings.into_iter().map(|finding| finding.in_assembly(&Assembly::sensor().0)).collect())
}

/// Samples points evenly over the area of the touch surface.
fn sample_surface(touch: &TouchSurface) -> Result<Vec<Place>, InvalidSolid> {
    let points = SurfacePoints::new(touch)?;
    let even = EvenPoints::square([0.5; 2]);
    let all = (0..PLACES).filter_map(|number| {
        let [along, across] = even.at(number);
        points.point_at_area_fractions([along, across]).map(|(point, _)| (along, point))
    });
    let mut all: Vec<(f64, Point3<f64>)> = all.collect();
    if let SurfacePoints::Plane(pad) = &points {
        // Distance from the middle, relative to the edge of the pad's bounding box.
        let bounds = pad.bounds_mm();
        for (out, point) in &mut all {
            let of_axis =
                |[least, most]: [f64; 2], at: f64| (2.0 * at - least - most) / (most - least);
            *out = of_axis(bounds[0], point.x).abs().max(of_axis(bounds[1], point.y).abs());
        }
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    // The points nearest to the middle, by rank.
    let inner = (MIDDLE * all.len() as f64).round() as usize;
    let place = |(rank, (_, point))| Place { point, weight: 1.0, counts: rank < inner };
    Ok(all.into_iter().enumerate().map(place).collect())
}

/// Samples points on the faces of the markers that straight rays from the pupil meet, ignoring all other bodies.
fn sample_markers(sensor: &Sensor) -> Result<Vec<Place>, InvalidBody> {
    let scene = Assemblies::new(sensor)?;
    let pupil = sensor.camera.sensor_from_camera.point(Point3::origin());
    // The rule of the straight rays asks the same, and reports what nobody answers.
    let all = bodies(sensor, &scene, Rule::Sight, &MaterialQuestions::default());
    let cone = Cone::around(&all, &pupil);
    let mut caster = Caster::default();
    let mut places = Vec::new();
    // Many rays miss the markers.
    let count = 16 * PLACES;
    for number in 0..count {
        let ray = Ray { origin: pupil, direction: cone.direction(number, count) };
        let wanted = all.iter().filter(|met| met.is_target);
        let met = wanted.filter_map(|met| caster.first_entry(&met.placed.body, &ray));
        if let Some(enter) = met.min_by(|a, b| a.t.total_cmp(&b.t)) {
            // Area of the face for one ray.
            let weight = enter.t * enter.t / steepness(&ray, &enter).max(LEAST_STEEPNESS);
            places.push(Place { point: ray.at(enter.t), weight, counts: true });
        }
    }
    // Every n-th point is as good a sample as all of them, and faster.
    let step = places.len().div_ceil(PLACES).max(1);
    Ok(places.into_iter().step_by(step).collect())
}

/// Returns the lost fractions of all points and of those that count.
fn look(places: &[Place], viewer: &mut CameraView, stack: &OpticalStack) -> (Shares, Shares) {
    let lost: Vec<Option<InvisibleReason>> =
        places.iter().map(|place| viewer.visible_pixel(&place.point).err()).collect();
    let shares = |is_asked: &dyn Fn(&Place) -> bool| {
        let (mut all, mut by_cause) = (0.0, BTreeMap::<InvisibleReason, f64>::new());
        for (place, lost) in places.iter().zip(&lost).filter(|(place, _)| is_asked(place)) {
            all += place.weight;
            if let Some(lost) = lost {
                *by_cause.entry(*lost).or_default() += place.weight;
            }
        }
        let share =
            |(lost, weight): (InvisibleReason, f64)| (lost.label(stack).to_owned(), weight / all);
        let mut shares: Shares = by_cause.into_iter().map(share).collect();
        shares.sort_by(|a, b| b.1.total_cmp(&a.1));
        shares
    };
    (shares(&|_| true), shares(&|place| place.counts))
}

/// Returns the total lost fraction.
fn sum(lost: &Shares) -> f64 {
    lost.iter().map(|(_, share)| share).sum()
}

/// Reports as a note the fraction that is seen, and the causes of loss.
fn note(of: &str, lost: &Shares, shown_by: &str) -> Finding {
    let seen = 100.0 * (1.0 - sum(lost));
    // Causes below half a percent would be rounded to 0 %.
    let told: Shares = lost.iter().filter(|(_, share)| *share >= 0.005).cloned().collect();
    let rest =
        if told.is_empty() { String::new() } else { format!("; {}", describe_losses(&told, 0)) };
    let message = format!("the camera sees {seen:.0} % of {of}{rest}");
    let fix = format!("`fabkit {shown_by}` shows it");
    Finding::error(Rule::Sight, message, fix).with_severity(Severity::Note)
}

/// Creates a warning about the bodies in view.
fn warning(sensor: &Sensor, message: String, fix: String, measured: [f64; 2]) -> Finding {
    Finding::error(Rule::Sight, message, fix)
        .with_severity(Severity::Warning)
        .about_bodies(sensor.visible_bodies.iter().map(String::as_str))
        .with_measurement(measured[0], measured[1], "")
}

/// Warns if too much of the surface's middle is lost.
fn middle(sensor: &Sensor, lost: &Shares) -> Option<Finding> {
    let share = sum(lost);
    let message = format!(
        "the camera does not see all of the surface's middle third: {}",
        describe_losses(lost, 0)
    );
    (share > MOST_LOST).then(|| warning(sensor, message, fix(lost), [share, MOST_LOST]))
}

/// Warns if one body hides too much of the surface.
fn hidden(sensor: &Sensor, lost: &Shares) -> Option<Finding> {
    // Causes are names of bodies, or refraction and the image's edge.
    let is_body = |(by, _): &&(String, f64)| sensor.body(by).is_some();
    let (by, share) = lost.iter().find(is_body)?;
    let message = format!("{by} hides a part of the surface from the camera");
    let found = || {
        let finding = warning(sensor, message, fix_of(by), [*share, MOST_HIDDEN]);
        let names = sensor.visible_bodies.iter().map(String::as_str);
        finding.about_bodies(std::iter::once(by.as_str()).chain(names))
    };
    (*share > MOST_HIDDEN).then(found)
}

/// Warns if too many markers are lost.
fn markers(sensor: &Sensor, lost: &Shares) -> Option<Finding> {
    let share = sum(lost);
    let message =
        format!("the camera does not see all of {}: {}", listed(sensor), describe_losses(lost, 0));
    let measured = [share, MOST_MARKERS_LOST];
    (share > MOST_MARKERS_LOST).then(|| warning(sensor, message, fix(lost), measured))
}

/// Returns a remedy for the largest loss.
fn fix(lost: &Shares) -> String {
    lost.first().map_or_else(String::new, |(by, _)| fix_of(by))
}

/// Returns a remedy for one cause of loss.
fn fix_of(by: &str) -> String {
    match by {
        fabkit_optics::OUTSIDE_IMAGE => {
            "take a lens with a wider view, or move the camera further away or turn it there".to_owned()
        }
        fabkit_optics::REFRACTION => {
            "move the camera nearer to the clear face that it looks through, or put a lens on that face so that rays meet it steeply"
                .to_owned()
        }
        body => format!("make the opening in {body} wider, or move the camera nearer to it"),
    }
}

/// Reports a sensor through which light cannot be followed.
fn unknown(error: &InvalidStack) -> Finding {
    let message = format!("the view through the drawn bodies is not known: {error}");
    let fix = "state `refractive_index` and `clarity` of every body that the camera looks through, below `materials:`";
    Finding::error(Rule::Sight, message, fix).with_severity(Severity::Warning)
}
