//! Where rays from within leave through the sensing surface.

use fabkit_geometry::{
    CompiledSolid, DomeSurface, EllipsoidOffset, InvalidSolid, PlaneSurface, Point3, Ray, Scratch,
    Solid, TouchSurface, Vector3,
};

/// A crossing nearer than this to where a ray starts is that start itself, mm.
pub const START_MM: f64 = 1e-9;

/// How far down the prism below a flat pad goes, mm: farther than any camera.
const DOWN_MM: f64 = 1e4;

/// What lies within the surface, endlessly far down: every ray from a camera starts in it.
#[derive(Clone, Debug)]
pub struct SensingSurface(Inside);

#[derive(Clone, Debug)]
enum Inside {
    Dome(InsideDome),
    Plane(InsidePlane),
}

impl SensingSurface {
    /// Prepares a sensing surface.
    ///
    /// # Errors
    /// Dimensions that make no solid.
    pub fn new(touch: &TouchSurface) -> Result<Self, InvalidSolid> {
        Ok(Self(match touch {
            TouchSurface::Dome(dome) => Inside::Dome(InsideDome::new(dome)?),
            TouchSurface::Plane(plane) => Inside::Plane(InsidePlane::new(plane)?),
        }))
    }

    /// Range and outward normal where a ray of unit direction leaves; below the foot it leaves
    /// through the housing, which is nothing to see.
    // Inlined, so that where only the range is wanted no normal is computed.
    #[inline(always)]
    pub fn exit(&self, ray: &Ray, scratch: &mut Scratch) -> Option<(f64, Vector3<f64>)> {
        match &self.0 {
            Inside::Dome(dome) => dome.exit(ray, scratch),
            Inside::Plane(plane) => plane.exit(ray, scratch),
        }
    }
}

/// A prism with the pad's outline.
#[derive(Clone, Debug)]
struct InsidePlane {
    prism: Box<CompiledSolid>,
    foot_z_mm: f64,
}

impl InsidePlane {
    fn new(plane: &PlaneSurface) -> Result<Self, InvalidSolid> {
        let prism = CompiledSolid::new(&plane.solid(0.0, plane.foot_z_mm - DOWN_MM))?;
        Ok(Self { prism: Box::new(prism), foot_z_mm: plane.foot_z_mm })
    }

    fn exit(&self, ray: &Ray, scratch: &mut Scratch) -> Option<(f64, Vector3<f64>)> {
        let exit = exit_body(&self.prism, ray, scratch)?;
        (ray.at(exit.0).z >= self.foot_z_mm).then_some(exit)
    }
}

/// Dome and wall together are convex, so that a ray leaves through the dome if it is above the
/// dome's centre there, else through the wall. Both are asked in closed form where there is one:
/// this is asked once for every pixel, and nothing else is.
#[derive(Clone, Debug)]
struct InsideDome {
    dome: Dome,
    radius_mm: f64,
    /// One over it, 1/mm.
    per_radius: f64,
    centre_z_mm: f64,
    foot_z_mm: f64,
}

#[derive(Clone, Debug)]
enum Dome {
    /// Its radius is that of the wall.
    Sphere,
    /// An ellipsoid of revolution: one over its half axes, 1/mm.
    Ellipsoid(Vector3<f64>),
    /// A surface parallel to one.
    Offset(Box<CompiledSolid>),
}

impl InsideDome {
    fn new(touch: &DomeSurface) -> Result<Self, InvalidSolid> {
        let DomeSurface { dome, centre_z_mm, foot_z_mm, .. } = touch;
        let EllipsoidOffset { equatorial_mm, polar_mm, offset_mm } = *dome;
        let (radius_mm, height_mm) = (touch.equator_radius_mm(), polar_mm + offset_mm);
        let dome = if equatorial_mm == polar_mm || offset_mm == 0.0 {
            let half_axes_mm = [radius_mm, radius_mm, height_mm];
            // Checked as the solid that it is.
            Solid::ellipsoid(half_axes_mm).validate()?;
            match radius_mm == height_mm {
                true => Dome::Sphere,
                false => Dome::Ellipsoid(Vector3::from(half_axes_mm).map(f64::recip)),
            }
        } else {
            let solid = Solid::EllipsoidOffset(dome.clone()).at(0.0, 0.0, *centre_z_mm);
            Dome::Offset(Box::new(CompiledSolid::new(&solid)?))
        };
        Ok(Self {
            dome,
            radius_mm,
            per_radius: radius_mm.recip(),
            centre_z_mm: *centre_z_mm,
            foot_z_mm: *foot_z_mm,
        })
    }

    #[inline(always)]
    fn exit(&self, ray: &Ray, scratch: &mut Scratch) -> Option<(f64, Vector3<f64>)> {
        let through_dome = match &self.dome {
            Dome::Sphere => self.exit_sphere(ray),
            Dome::Ellipsoid(per_mm) => self.exit_ellipsoid(ray, per_mm),
            Dome::Offset(body) => exit_body(body, ray, scratch),
        };
        let z_mm = |range_mm: f64| ray.origin.z + range_mm * ray.direction.z;
        let above = through_dome.filter(|(range_mm, _)| z_mm(*range_mm) >= self.centre_z_mm);
        let exit = match above {
            Some(exit) => exit,
            // Where the foot lies above the centre there is no wall.
            None if self.foot_z_mm >= self.centre_z_mm => return None,
            None => self.exit_wall(ray)?,
        };
        (z_mm(exit.0) >= self.foot_z_mm).then_some(exit)
    }

    /// The discriminant from the foot of the perpendicular (Haines et al., "Precision Improvements
    /// for Ray/Sphere Intersection", Ray Tracing Gems, 2019).
    #[inline(always)]
    fn exit_sphere(&self, ray: &Ray) -> Option<(f64, Vector3<f64>)> {
        let origin = ray.origin - Point3::new(0.0, 0.0, self.centre_z_mm);
        let b = origin.dot(&ray.direction);
        let half_squared =
            self.radius_mm * self.radius_mm - (origin - b * ray.direction).norm_squared();
        if half_squared <= 0.0 {
            return None;
        }
        let range_mm = half_squared.sqrt() - b;
        let normal = (origin + range_mm * ray.direction) * self.per_radius;
        (range_mm > START_MM).then_some((range_mm, normal))
    }

    /// The sphere of radius 1 in coordinates scaled by one over the half axes.
    #[inline(always)]
    fn exit_ellipsoid(&self, ray: &Ray, per_mm: &Vector3<f64>) -> Option<(f64, Vector3<f64>)> {
        let centre = Point3::new(0.0, 0.0, self.centre_z_mm);
        let origin = (ray.origin - centre).component_mul(per_mm);
        let direction = ray.direction.component_mul(per_mm);
        let per_a = 1.0 / direction.norm_squared();
        let b = origin.dot(&direction) * per_a;
        let half_squared = (1.0 - (origin - b * direction).norm_squared()) * per_a;
        if half_squared <= 0.0 {
            return None;
        }
        let range_mm = half_squared.sqrt() - b;
        let normal = (origin + range_mm * direction).component_mul(per_mm);
        (range_mm > START_MM).then(|| (range_mm, normal.normalize()))
    }

    /// The endless cylinder; a ray along its axis never leaves.
    #[inline(always)]
    fn exit_wall(&self, ray: &Ray) -> Option<(f64, Vector3<f64>)> {
        let (o, d) = (ray.origin.coords.xy(), ray.direction.xy());
        let a = d.norm_squared();
        let per_a = 1.0 / a;
        let cross = o.x * d.y - o.y * d.x;
        let half_squared = (self.radius_mm * self.radius_mm - cross * cross * per_a) * per_a;
        // NaN comes from a = 0.
        if half_squared.is_nan() || half_squared <= 0.0 {
            return None;
        }
        let range_mm = half_squared.sqrt() - o.dot(&d) * per_a;
        let at = (o + range_mm * d) * self.per_radius;
        (range_mm > START_MM && range_mm.is_finite())
            .then_some((range_mm, Vector3::new(at.x, at.y, 0.0)))
    }
}

#[inline(never)]
fn exit_body(
    body: &CompiledSolid,
    ray: &Ray,
    scratch: &mut Scratch,
) -> Option<(f64, Vector3<f64>)> {
    body.first_crossing(ray, START_MM, false, scratch).map(|exit| (exit.t, exit.normal))
}
