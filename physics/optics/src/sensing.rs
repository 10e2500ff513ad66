//! Exit of rays from within through the sensing surface.

use std::f64::consts::TAU;

use fabkit_geometry::{
    CompiledSolid, DomeSurface, EllipsoidOffset, InvalidSolid, Path, PlaneSurface, Point3, Ray,
    Scratch, Segment, Solid, TouchSurface, Vector3,
};

/// Distance from the start of a ray within which an intersection counts as the start itself, mm.
pub const START_TOLERANCE_MM: f64 = 1e-9;

/// Depth of the prism below a flat pad, mm: farther than any camera.
const PRISM_DEPTH_MM: f64 = 1e4;

/// Margin of outline edges for rounding, mm.
const CORE_SLACK_MM: f64 = 1e-6;

/// Volume within the sensing surface, extended downwards without end, so that every ray from a camera starts in it.
///
/// ```
/// # use fabkit_geometry::{DomeSurface, EllipsoidOffset, FixtureGrip, Path, Point3, Ray, Vector3};
/// # let grip = FixtureGrip {
/// #     outline: Path::circle([0.0, 0.0], 10.0), top_z_mm: 0.0, bottom_z_mm: -20.0, clear_radius_mm: 8.0,
/// #     key: None, threads: Vec::new(),
/// # };
/// use fabkit_optics::SensingSurface;
///
/// // A hemisphere of radius 10 mm around (0, 0, 4) on a straight wall; its foot is at z = 0.
/// let dome = EllipsoidOffset { equatorial_mm: 10.0, polar_mm: 10.0, offset_mm: 0.0 };
/// let touch = DomeSurface { dome, centre_z_mm: 4.0, foot_z_mm: 0.0, max_indentation_mm: 1.0, grip };
/// let surface = SensingSurface::new(&touch.into())?;
/// let exit = |origin, direction| surface.exit(&Ray { origin, direction }, &mut Default::default());
/// assert_eq!(exit(Point3::origin(), Vector3::z()), Some((14.0, Vector3::z())));
/// assert_eq!(exit(Point3::new(0.0, 0.0, 1.0), Vector3::x()), Some((10.0, Vector3::x())));
/// // Below the foot is the housing.
/// assert_eq!(exit(Point3::new(0.0, 0.0, -1.0), Vector3::x()), None);
/// # Ok::<(), fabkit_geometry::InvalidSolid>(())
/// ```
#[derive(Clone, Debug)]
pub struct SensingSurface(SensingVolume);

/// Volume by the kind of its surface.
#[derive(Clone, Debug)]
enum SensingVolume {
    Dome(DomeVolume),
    Plane(PadVolume),
}

impl SensingSurface {
    /// Prepares a sensing surface.
    ///
    /// # Errors
    /// If its dimensions do not form a valid solid.
    pub fn new(touch: &TouchSurface) -> Result<Self, InvalidSolid> {
        Ok(Self(match touch {
            TouchSurface::Dome(dome) => SensingVolume::Dome(DomeVolume::new(dome)?),
            TouchSurface::Plane(plane) => SensingVolume::Plane(PadVolume::new(plane)?),
        }))
    }

    /// Returns distance and outward normal where a ray of unit direction leaves the volume; `None` below the foot,
    /// where it leaves through the housing.
    // Inlined, so that callers that need only the distance do not compute the normal.
    #[inline(always)]
    pub fn exit(&self, ray: &Ray, scratch: &mut Scratch) -> Option<(f64, Vector3<f64>)> {
        match &self.0 {
            SensingVolume::Dome(dome) => dome.exit(ray, scratch),
            SensingVolume::Plane(plane) => plane.exit(ray, scratch),
        }
    }
}

/// Prism with the outline of a pad.
#[derive(Clone, Debug)]
struct PadVolume {
    prism: Box<CompiledSolid>,
    top_z_mm: f64,
    foot_z_mm: f64,
    /// Box within the outline, as its smallest and largest x and y. A ray that starts and ends in it leaves through the
    /// top. Empty if none was found.
    inner_box: [[f64; 2]; 2],
}

impl PadVolume {
    fn new(plane: &PlaneSurface) -> Result<Self, InvalidSolid> {
        let &PlaneSurface { top_z_mm, foot_z_mm, .. } = plane;
        let prism = CompiledSolid::new(&plane.solid(0.0, foot_z_mm - PRISM_DEPTH_MM))?;
        let core = find_inner_box(&plane.outline, &prism, foot_z_mm - 0.5 * PRISM_DEPTH_MM);
        Ok(Self { prism: Box::new(prism), top_z_mm, foot_z_mm, inner_box: core })
    }

    #[inline(always)]
    fn exit(&self, ray: &Ray, scratch: &mut Scratch) -> Option<(f64, Vector3<f64>)> {
        let rise_mm = self.top_z_mm - ray.origin.z;
        let range_mm = rise_mm / ray.direction.z;
        let is_in = |x: f64, y: f64| {
            let [low, high] = &self.inner_box;
            low[0] <= x && x <= high[0] && low[1] <= y && y <= high[1]
        };
        let (from, to) = (&ray.origin, ray.at(range_mm));
        // Rays that start below the prism take the general way.
        let is_upwards = range_mm > START_TOLERANCE_MM && rise_mm > 0.0 && rise_mm < PRISM_DEPTH_MM;
        if is_upwards && is_in(from.x, from.y) && is_in(to.x, to.y) {
            return Some((range_mm, Vector3::z()));
        }
        let exit = exit_solid(&self.prism, ray, scratch)?;
        (ray.at(exit.0).z >= self.foot_z_mm).then_some(exit)
    }
}

/// Finds the largest box within an outline, among those that are its bounding box reduced by an equal margin. If no
/// edge comes near a box and its centre lies within the outline, all of it does.
fn find_inner_box(outline: &Path, prism: &CompiledSolid, z_mm: f64) -> [[f64; 2]; 2] {
    const NONE: [[f64; 2]; 2] = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    let Some(edges) = edge_boxes(outline) else { return NONE };
    let (min, max) = (prism.bounds().min, prism.bounds().max);
    let middle = Point3::new(0.5 * (min.x + max.x), 0.5 * (min.y + max.y), z_mm);
    if !prism.contains(&middle) {
        return NONE;
    }
    let half_mm = 0.5 * (max.x - min.x).min(max.y - min.y);
    let boxes = (1..100).map(|percent| {
        let by_mm = f64::from(percent) / 100.0 * half_mm;
        [[min.x + by_mm, min.y + by_mm], [max.x - by_mm, max.y - by_mm]]
    });
    let is_clear = |[low, high]: &[[f64; 2]; 2]| {
        let touches = |edge: &[[f64; 2]; 2]| {
            (0..2).all(|axis| edge[0][axis] <= high[axis] && low[axis] <= edge[1][axis])
        };
        !edges.iter().any(touches)
    };
    boxes.into_iter().find(is_clear).unwrap_or(NONE)
}

/// Returns boxes that contain the edges of an outline; `None` for curves other than circles.
fn edge_boxes(outline: &Path) -> Option<Vec<[[f64; 2]; 2]>> {
    /// Boxes per segment.
    const PARTS: u32 = 32;
    let (mut boxes, mut from) = (Vec::new(), outline.start);
    for segment in &outline.segments {
        let to = segment.to();
        let (points, sagitta_mm): (Vec<[f64; 2]>, f64) = match segment {
            Segment::Line { .. } => {
                let at = |part: u32| {
                    let share = f64::from(part) / f64::from(PARTS);
                    [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]))
                };
                ((0..=PARTS).map(at).collect(), 0.0)
            }
            Segment::Arc { centre, ccw, .. } => {
                let angle = |p: [f64; 2]| (p[1] - centre[1]).atan2(p[0] - centre[0]);
                let turn = if *ccw { 1.0 } else { -1.0 };
                let sweep = (turn * (angle(to) - angle(from))).rem_euclid(TAU);
                // A full circle ends where it starts.
                let step = turn * if sweep == 0.0 { TAU } else { sweep } / f64::from(PARTS);
                let radius_mm = (from[0] - centre[0]).hypot(from[1] - centre[1]);
                let at = |part: u32| {
                    let (sin, cos) = (angle(from) + f64::from(part) * step).sin_cos();
                    [centre[0] + radius_mm * cos, centre[1] + radius_mm * sin]
                };
                // The sagitta: by how much an arc bulges beyond its chord.
                ((0..=PARTS).map(at).collect(), radius_mm * (1.0 - (0.5 * step).cos()))
            }
            Segment::EllipticArc { .. } => return None,
        };
        let by_mm = sagitta_mm + CORE_SLACK_MM;
        boxes.extend(points.windows(2).map(|ends| {
            let (low, high) = (
                [0, 1].map(|k| ends[0][k].min(ends[1][k]) - by_mm),
                [0, 1].map(|k| ends[0][k].max(ends[1][k]) + by_mm),
            );
            [low, high]
        }));
        from = to;
    }
    Some(boxes)
}

/// Volume under a dome and its wall. Both together are convex, so a ray leaves through the dome if that exit lies above
/// the dome's centre, and otherwise through the wall. Closed forms are used where there are any, because this is
/// computed for every pixel.
#[derive(Clone, Debug)]
struct DomeVolume {
    dome: DomeShape,
    radius_mm: f64,
    /// Reciprocal of the radius, 1/mm.
    per_radius: f64,
    centre_z_mm: f64,
    foot_z_mm: f64,
}

/// Shape of a dome.
#[derive(Clone, Debug)]
enum DomeShape {
    /// Sphere with the radius of the wall.
    Sphere,
    /// Ellipsoid of revolution, by its reciprocal semi-axes, 1/mm.
    Ellipsoid(Vector3<f64>),
    /// Surface at a constant distance from an ellipsoid.
    Offset(Box<CompiledSolid>),
}

impl DomeVolume {
    fn new(touch: &DomeSurface) -> Result<Self, InvalidSolid> {
        let DomeSurface { dome, centre_z_mm, foot_z_mm, .. } = touch;
        let EllipsoidOffset { equatorial_mm, polar_mm, offset_mm } = *dome;
        let (radius_mm, height_mm) = (touch.equator_radius_mm(), polar_mm + offset_mm);
        let dome = if equatorial_mm == polar_mm || offset_mm == 0.0 {
            let half_axes_mm = [radius_mm, radius_mm, height_mm];
            // Validated as a solid, although none is built.
            Solid::ellipsoid(half_axes_mm).validate()?;
            if radius_mm == height_mm {
                DomeShape::Sphere
            } else {
                DomeShape::Ellipsoid(Vector3::from(half_axes_mm).map(f64::recip))
            }
        } else {
            let solid = Solid::EllipsoidOffset(dome.clone()).at(0.0, 0.0, *centre_z_mm);
            DomeShape::Offset(Box::new(CompiledSolid::new(&solid)?))
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
            DomeShape::Sphere => self.exit_sphere(ray),
            DomeShape::Ellipsoid(per_mm) => self.exit_ellipsoid(ray, per_mm),
            DomeShape::Offset(body) => exit_solid(body, ray, scratch),
        };
        let z_mm = |range_mm: f64| ray.origin.z + range_mm * ray.direction.z;
        let above = through_dome.filter(|(range_mm, _)| z_mm(*range_mm) >= self.centre_z_mm);
        let exit = match above {
            Some(exit) => exit,
            // If the foot lies above the centre, there is no wall.
            None if self.foot_z_mm >= self.centre_z_mm => return None,
            None => self.exit_wall(ray)?,
        };
        (z_mm(exit.0) >= self.foot_z_mm).then_some(exit)
    }

    /// Intersects the sphere, with the discriminant from the foot of the perpendicular (Haines et al., "Precision
    /// Improvements for Ray/Sphere Intersection", Ray Tracing Gems, 2019).
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
        (range_mm > START_TOLERANCE_MM).then_some((range_mm, normal))
    }

    /// Intersects the ellipsoid: a unit sphere in coordinates divided by the semi-axes.
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
        (range_mm > START_TOLERANCE_MM).then(|| (range_mm, normal.normalize()))
    }

    /// Intersects the infinite cylinder of the wall; a ray along its axis never leaves.
    #[inline(always)]
    fn exit_wall(&self, ray: &Ray) -> Option<(f64, Vector3<f64>)> {
        let (o, d) = (ray.origin.coords.xy(), ray.direction.xy());
        let a = d.norm_squared();
        let per_a = 1.0 / a;
        let cross = o.x * d.y - o.y * d.x;
        let half_squared = (self.radius_mm * self.radius_mm - cross * cross * per_a) * per_a;
        // NaN comes from a = 0, a ray along the axis.
        if half_squared.is_nan() || half_squared <= 0.0 {
            return None;
        }
        let range_mm = half_squared.sqrt() - o.dot(&d) * per_a;
        let at = (o + range_mm * d) * self.per_radius;
        (range_mm > START_TOLERANCE_MM && range_mm.is_finite())
            .then_some((range_mm, Vector3::new(at.x, at.y, 0.0)))
    }
}

/// Intersects a general solid. Not inlined, to keep the common closed forms small.
#[inline(never)]
fn exit_solid(
    body: &CompiledSolid,
    ray: &Ray,
    scratch: &mut Scratch,
) -> Option<(f64, Vector3<f64>)> {
    body.first_crossing(ray, START_TOLERANCE_MM, false, scratch).map(|exit| (exit.t, exit.normal))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fabkit_geometry::FixtureGrip;

    /// The closed form used in the middle agrees with the solid used at the rim.
    #[test]
    fn closed_form_exits_equal_those_of_the_prism() {
        let arc = |to, centre| Segment::Arc { to, centre, ccw: true };
        let outline = Path {
            start: [-4.0, -5.0],
            segments: vec![
                Segment::Line { to: [4.0, -5.0] },
                arc([6.0, -3.0], [4.0, -3.0]),
                Segment::Line { to: [6.0, 5.0] },
                Segment::Line { to: [-6.0, 5.0] },
                Segment::Line { to: [-6.0, -3.0] },
                arc([-4.0, -5.0], [-4.0, -3.0]),
            ],
        };
        let grip = FixtureGrip {
            outline: outline.clone(),
            top_z_mm: 0.0,
            bottom_z_mm: -3.0,
            clear_radius_mm: 5.0,
            key: None,
            threads: Vec::new(),
        };
        let surface =
            PlaneSurface { outline, top_z_mm: 4.0, foot_z_mm: 1.0, max_indentation_mm: 2.0, grip };
        let plane = PadVolume::new(&surface).unwrap();
        let [low, high] = plane.inner_box;
        assert!(low[0] < -5.0 && high[0] > 5.0 && low[1] < -4.0 && high[1] > 4.0);
        let mut scratch = Scratch::default();
        let mut tops = 0;
        for number in 0..10_000 {
            let turn = f64::from(number) * 2.4;
            let out = f64::from(number) / 5_000.0;
            let direction = Vector3::new(out * turn.cos(), out * turn.sin(), 1.0).normalize();
            let ray = Ray { origin: Point3::new(0.5, -1.0, -2.0), direction };
            let by_prism = exit_solid(&plane.prism, &ray, &mut scratch);
            let by_prism = by_prism.filter(|(range_mm, _)| ray.at(*range_mm).z >= 1.0);
            let exit = plane.exit(&ray, &mut scratch);
            assert_eq!(exit.is_some(), by_prism.is_some(), "{ray:?}");
            if let (Some(exit), Some(expected)) = (exit, by_prism) {
                assert!((exit.0 - expected.0).abs() < 1e-9, "{exit:?} {expected:?}");
                assert!((exit.1 - expected.1).norm() < 1e-9, "{exit:?} {expected:?}");
                tops += usize::from(exit.1.z == 1.0);
            }
        }
        assert!((1_000..9_000).contains(&tops), "{tops}");
    }
}
