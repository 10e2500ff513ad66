//! How deep a body goes, seen by a camera or not.
//!
//! Every point of a body's surface lies on a ray from the dome's centre. Rays on a grid around the
//! body find its deepest point among all their crossings, finer grids around it find it exactly.

use std::f64::consts::PI;

use fabkit_fixtures::PressBody;
use fabkit_geometry::{
    CompiledSolid, Crossing, InvalidSolid, Point3, Pose, Ray, Scratch, TouchSurface, Vector3,
};

/// Rays along each side of the first grid.
const FIRST: u32 = 25;
/// Along each side of the others, and how many there are; each covers two steps of the one before,
/// so that steps shrink fourfold each time.
const FINER: u32 = 9;
const ROUNDS: u32 = 5;

/// The deepest point of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penetration {
    /// Below the untouched surface, along its normal, mm; negative above it.
    pub depth_mm: f64,
    /// Where, sensor frame, mm.
    pub point_in_sensor: Point3<f64>,
}

/// How deep a body goes into a surface; `None` if it stays outside.
///
/// Good to a micrometre for what is round or flat; a spike thinner than a 25th of the body may be
/// missed.
///
/// ```
/// use fabkit_application::fixtures::load;
/// use fabkit_application::ground_truth::penetration;
///
/// let yaml = fabkit_application::designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// let project = load("rtac0.yaml", yaml, &[])?;
/// let press = project.press("hemisphere@30deg,120deg,1.2mm")?;
/// let touch = project.design.sensor.touch.as_ref().ok_or("no surface")?;
/// let deepest = penetration(touch, &press.bodies[0])?.ok_or("no contact")?;
/// assert!((deepest.depth_mm - 1.2).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// A solid that is none.
pub fn penetration(
    touch: &TouchSurface,
    body: &PressBody,
) -> Result<Option<Penetration>, InvalidSolid> {
    Ok(approach(touch, body)?.filter(|deepest| deepest.depth_mm > 0.0))
}

/// The point of a body that is deepest in a surface, or nearest to it if none is inside; `None` if
/// all of the body lies below the surface's foot. As good as [`penetration`].
///
/// # Errors
/// A solid that is none.
pub fn approach(
    touch: &TouchSurface,
    body: &PressBody,
) -> Result<Option<Penetration>, InvalidSolid> {
    let solid = CompiledSolid::new(&body.solid)?;
    let bounds = solid.bounds();
    if bounds.is_empty() || !bounds.is_finite() {
        return Ok(None);
    }
    let centre = Point3::new(0.0, 0.0, touch.centre_z_mm);
    let towards = body.sensor_from_body.point(bounds.centre()) - centre;
    let radius_mm = 0.5 * Vector3::from(bounds.size_mm()).norm();
    let distance_mm = towards.norm();
    // A ball around the centre itself is seen in every direction.
    let reach_rad = if distance_mm > radius_mm { (radius_mm / distance_mm).asin() } else { PI };
    let frame = match towards.try_normalize(0.0) {
        Some(axis) => Pose::z_to(axis, centre),
        None => Pose::translation(0.0, 0.0, touch.centre_z_mm),
    };
    let mut rays = Rays {
        touch,
        solid: &solid,
        sensor_from_rays: frame,
        body_from_sensor: body.sensor_from_body.inverse(),
        scratch: Scratch::default(),
        crossings: Vec::new(),
    };
    let mut best: Option<(Penetration, [f64; 2])> = None;
    let (mut middle, mut half_rad, mut count) = ([0.0; 2], reach_rad, FIRST);
    for _ in 0..=ROUNDS {
        let step_rad = 2.0 * half_rad / f64::from(count - 1);
        let places = (0..count * count).map(|i| {
            let offset = |i: u32| step_rad * f64::from(i) - half_rad;
            [middle[0] + offset(i % count), middle[1] + offset(i / count)]
        });
        for place in places {
            if let Some(found) = rays.deepest(place)
                && best.is_none_or(|(deepest, _)| found.depth_mm > deepest.depth_mm)
            {
                best = Some((found, place));
            }
        }
        let Some((_, place)) = best else { return Ok(None) };
        (middle, half_rad, count) = (place, step_rad, FINER);
    }
    Ok(best.map(|(deepest, _)| deepest))
}

struct Rays<'a> {
    touch: &'a TouchSurface,
    solid: &'a CompiledSolid,
    /// Origin at the dome's centre, z towards the body.
    sensor_from_rays: Pose,
    body_from_sensor: Pose,
    scratch: Scratch,
    crossings: Vec<Crossing>,
}

impl Rays<'_> {
    /// On the ray `offset` from z, rad: its length is the angle between them.
    fn deepest(&mut self, offset: [f64; 2]) -> Option<Penetration> {
        let angle = offset[0].hypot(offset[1]);
        let (sin, cos) = angle.min(PI).sin_cos();
        // The sine over the angle, without dividing 0 by 0.
        let share = if angle > 1e-9 { sin / angle } else { 1.0 };
        let direction = Vector3::new(share * offset[0], share * offset[1], cos);
        let ray = Ray {
            origin: self.sensor_from_rays.point(Point3::origin()),
            direction: self.sensor_from_rays.vector(direction),
        };
        let ray_in_body = Ray {
            origin: self.body_from_sensor.point(ray.origin),
            direction: self.body_from_sensor.vector(ray.direction),
        };
        self.solid.crossings_into(&ray_in_body, &mut self.scratch, &mut self.crossings);
        // What lies behind the centre is seen by rays of the other direction. A centre within the
        // body, which the ray then leaves first, is a point of it too.
        let ahead = || self.crossings.iter().filter(|crossing| crossing.t > 0.0);
        let centre = ahead().next().filter(|first| !first.entering).map(|_| ray.origin);
        let points = ahead().map(|crossing| ray.at(crossing.t)).chain(centre);
        let pressed = points.filter(|point| point.z >= self.touch.foot_z_mm).map(|point| {
            let (depth_mm, _) = self.touch.depth_mm(&point);
            Penetration { depth_mm, point_in_sensor: point }
        });
        pressed.max_by(|a, b| a.depth_mm.total_cmp(&b.depth_mm))
    }
}
