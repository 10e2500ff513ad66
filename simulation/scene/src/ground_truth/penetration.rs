//! Penetration depth of bodies into a surface, independent of any camera.
//!
//! Every point of a body's surface lies on a ray from the dome's centre, or over a flat pad on a ray straight down.
//! Rays on a grid around the body give its deepest point among all their crossings; finer grids around that point
//! refine it.

use std::f64::consts::PI;

use fabkit_fixtures::PressBody;
use fabkit_geometry::{
    Aabb, CompiledSolid, Crossing, DomeSurface, InvalidSolid, PlaneSurface, Point3, Pose, Ray,
    Scratch, TouchSurface, Vector3,
};

/// Number of rays along each side of the first grid.
const FIRST: u32 = 25;
/// Number of rays along each side of the finer grids, and number of these grids. Each covers two steps of the one
/// before, so the step shrinks fourfold each time.
const FINER: u32 = 9;
const ROUNDS: u32 = 5;

/// Deepest point of a body relative to a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penetration {
    /// Depth below the undeformed surface along its normal, mm; negative above it.
    pub depth_mm: f64,
    /// The point, sensor frame, mm.
    pub point_in_sensor: Point3<f64>,
}

/// Finds the deepest point of a body inside a surface; `None` if the body stays outside.
///
/// Accurate to a micrometre for round and flat bodies. A spike thinner than a 25th of the body may be missed.
///
/// ```
/// use fabkit_fixtures::load;
/// use fabkit_scene::ground_truth::find_penetration;
///
/// let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// let project = load("rtac0.yaml", yaml, &[])?;
/// let press = project.press("hemisphere@30deg,120deg,1.2mm")?;
/// let touch = project.design.sensor.touch.as_ref().ok_or("no surface")?;
/// let deepest = find_penetration(touch, &press.bodies[0])?.ok_or("no contact")?;
/// assert!((deepest.depth_mm - 1.2).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Returns an error if the body's solid is not valid.
pub fn find_penetration(
    touch: &TouchSurface,
    body: &PressBody,
) -> Result<Option<Penetration>, InvalidSolid> {
    Ok(find_deepest_point(touch, body)?.filter(|deepest| deepest.depth_mm > 0.0))
}

/// Finds the point of a body that is deepest in a surface, or nearest to it if none is inside. Returns `None` if the
/// whole body lies below the surface's foot. Accuracy as for [`find_penetration`].
///
/// # Errors
/// Returns an error if the body's solid is not valid.
///
/// ```
/// use fabkit_geometry::Pose;
/// use fabkit_scene::ground_truth::{find_deepest_point, find_penetration};
///
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// let touch = project.design.sensor.touch.as_ref().ok_or("no surface")?;
/// let mut body = project.press("hemisphere@0deg,0deg,1mm")?.bodies.remove(0);
/// // Lifted by 3 mm, it ends 2 mm above the surface: the depth is negative.
/// body.sensor_from_body = Pose::translation(0.0, 0.0, 3.0).then_in(body.sensor_from_body);
/// let nearest = find_deepest_point(touch, &body)?.ok_or("below the foot")?;
/// assert!((nearest.depth_mm + 2.0).abs() < 1e-6);
/// assert_eq!(find_penetration(touch, &body)?, None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn find_deepest_point(
    touch: &TouchSurface,
    body: &PressBody,
) -> Result<Option<Penetration>, InvalidSolid> {
    let solid = CompiledSolid::new(&body.solid)?;
    let bounds = solid.bounds();
    if bounds.is_empty() || !bounds.is_finite() {
        return Ok(None);
    }
    let (look, reach) = match touch {
        TouchSurface::Dome(dome) => RayBundle::from_dome_centre(dome, body, &bounds),
        TouchSurface::Plane(plane) => RayBundle::downwards(plane, body, &bounds)?,
    };
    let mut rays = PenetrationSearch {
        touch,
        solid: &solid,
        look,
        body_from_sensor: body.sensor_from_body.inverse(),
        scratch: Scratch::default(),
        crossings: Vec::new(),
    };
    let mut best: Option<(Penetration, [f64; 2])> = None;
    let (mut middle, mut half, mut count) = ([0.0; 2], reach, FIRST);
    for _ in 0..=ROUNDS {
        let step = 2.0 * half / f64::from(count - 1);
        let places = (0..count * count).map(|i| {
            let offset = |i: u32| step * f64::from(i) - half;
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
        (middle, half, count) = (place, step, FINER);
    }
    Ok(best.map(|(deepest, _)| deepest))
}

/// Bundle of rays along which a surface is searched. Each ray has two parameters, both 0 towards the body's middle.
enum RayBundle {
    /// Rays from the dome's centre. The z axis of their frame points to the body; the parameters are angles, rad.
    FromCentre { sensor_from_rays: Pose },
    /// Rays straight down from above the whole body; the parameters are x and y, mm.
    Downwards { above: Point3<f64>, pad: Box<CompiledSolid> },
}

impl RayBundle {
    /// Returns rays out of a dome, and their largest angle around the body's middle, rad.
    fn from_dome_centre(dome: &DomeSurface, body: &PressBody, bounds: &Aabb) -> (Self, f64) {
        let centre = Point3::new(0.0, 0.0, dome.centre_z_mm);
        let towards = body.sensor_from_body.point(bounds.centre()) - centre;
        let radius_mm = 0.5 * Vector3::from(bounds.size_mm()).norm();
        let distance_mm = towards.norm();
        // A bounding ball that contains the centre fills every direction.
        let reach_rad = if distance_mm > radius_mm { (radius_mm / distance_mm).asin() } else { PI };
        let sensor_from_rays = match towards.try_normalize(0.0) {
            Some(axis) => Pose::z_to(axis, centre),
            None => Pose::translation(0.0, 0.0, dome.centre_z_mm),
        };
        (Self::FromCentre { sensor_from_rays }, reach_rad)
    }

    /// Returns rays down on a pad, and their largest distance from the body's middle, mm.
    fn downwards(
        plane: &PlaneSurface,
        body: &PressBody,
        bounds: &Aabb,
    ) -> Result<(Self, f64), InvalidSolid> {
        let middle = body.sensor_from_body.point(bounds.centre());
        let radius_mm = 0.5 * Vector3::from(bounds.size_mm()).norm();
        let above = middle + (1.0 + radius_mm) * Vector3::z();
        // Contact beside the pad or below its foot is not contact with the sensing surface.
        let pad = PlaneSurface { top_z_mm: above.z.max(plane.top_z_mm) + 1.0, ..plane.clone() };
        let pad = CompiledSolid::new(&pad.solid(0.0, plane.foot_z_mm))?;
        Ok((Self::Downwards { above, pad: Box::new(pad) }, radius_mm))
    }

    fn ray(&self, place: [f64; 2]) -> Ray {
        match self {
            Self::FromCentre { sensor_from_rays } => {
                let angle = place[0].hypot(place[1]);
                let (sin, cos) = angle.min(PI).sin_cos();
                // The limit of sin(angle) / angle at 0 is 1.
                let share = if angle > 1e-9 { sin / angle } else { 1.0 };
                let direction = Vector3::new(share * place[0], share * place[1], cos);
                Ray {
                    origin: sensor_from_rays.point(Point3::origin()),
                    direction: sensor_from_rays.vector(direction),
                }
            }
            Self::Downwards { above, .. } => {
                let origin = above + Vector3::new(place[0], place[1], 0.0);
                Ray { origin, direction: -Vector3::z() }
            }
        }
    }

    /// Returns whether a point is on or over the part of the surface that can be pressed.
    fn is_pressed(&self, touch: &TouchSurface, point: &Point3<f64>) -> bool {
        match self {
            Self::FromCentre { .. } => point.z >= touch.foot_z_mm(),
            Self::Downwards { pad, .. } => pad.contains(point),
        }
    }
}

struct PenetrationSearch<'a> {
    touch: &'a TouchSurface,
    solid: &'a CompiledSolid,
    look: RayBundle,
    body_from_sensor: Pose,
    scratch: Scratch,
    crossings: Vec<Crossing>,
}

impl PenetrationSearch<'_> {
    /// Returns the deepest of the ray's crossings with the body; `place` has the ray's two parameters.
    fn deepest(&mut self, place: [f64; 2]) -> Option<Penetration> {
        let ray = self.look.ray(place);
        let ray_in_body = Ray {
            origin: self.body_from_sensor.point(ray.origin),
            direction: self.body_from_sensor.vector(ray.direction),
        };
        self.solid.crossings_into(&ray_in_body, &mut self.scratch, &mut self.crossings);
        // Crossings behind the centre belong to rays of the opposite direction. If the centre is inside the body, the
        // ray leaves the body first, and the centre itself is a point of it.
        let ahead = || self.crossings.iter().filter(|crossing| crossing.t > 0.0);
        let centre = ahead().next().filter(|first| !first.entering).map(|_| ray.origin);
        let points = ahead().map(|crossing| ray.at(crossing.t)).chain(centre);
        let pressed = points.filter(|point| self.look.is_pressed(self.touch, point)).map(|point| {
            let (depth_mm, _) = self.touch.depth_mm(&point);
            Penetration { depth_mm, point_in_sensor: point }
        });
        pressed.max_by(|a, b| a.depth_mm.total_cmp(&b.depth_mm))
    }
}
