//! Ground truth against closed forms, implemented independently.

use fabkit_camera::{Camera, FlatInterface, Interface};
use fabkit_depth::ground_truth::{
    PixelRays, PlacedIndenter, ReferenceSurface, SURFACE_LABEL, Seam, Side, SurfaceDisplacement,
};
use fabkit_geometry::{
    Angle, DomeSurface, EllipsoidOffset, FixtureGrip, Path, PlaneSurface, Point3, Pose, Ray, Solid,
    TouchSurface, Vector3,
};

const TOLERANCE_MM: f64 = 1e-9;

fn touch(equatorial_mm: f64, polar_mm: f64, offset_mm: f64, centre_z_mm: f64) -> TouchSurface {
    let dome = EllipsoidOffset { equatorial_mm, polar_mm, offset_mm };
    let grip = grip(Path::circle([0.0, 0.0], equatorial_mm));
    DomeSurface { dome, centre_z_mm, foot_z_mm: 0.0, max_indentation_mm: 1.5, grip }.into()
}

fn pad(outline: Path) -> TouchSurface {
    let grip = grip(outline.offset_outwards(2.0));
    PlaneSurface { outline, top_z_mm: 4.0, foot_z_mm: 1.0, max_indentation_mm: 3.0, grip }.into()
}

fn grip(outline: Path) -> FixtureGrip {
    FixtureGrip {
        outline,
        top_z_mm: 0.0,
        bottom_z_mm: -20.0,
        clear_radius_mm: 0.0,
        key: None,
        threads: Vec::new(),
    }
}

/// R-Tac0's touch surface.
fn bullet() -> TouchSurface {
    touch(15.0, 15.0, 0.0, 6.0)
}

fn camera() -> Camera {
    Camera::equidistant(160, 120, 160f64.to_radians()).unwrap()
}

/// A little off the axis and tilted, so that nothing is symmetric.
fn sensor_from_camera() -> Pose {
    Pose::translation(0.3, -0.2, -7.0).then_in(Pose::rotation_x(Angle::from_deg(2.0).unwrap()))
}

/// Both roots of a t^2 + 2 b t + c, the smaller first.
fn roots(a: f64, b: f64, c: f64) -> Option<[f64; 2]> {
    let d = b * b - a * c;
    (d > 0.0).then(|| {
        let q = -(b + d.sqrt().copysign(b));
        let (x, y) = (q / a, c / q);
        [x.min(y), x.max(y)]
    })
}

#[test]
fn the_reference_is_the_surface_in_closed_form() {
    let rays = PixelRays::new(&camera(), &sensor_from_camera());
    let touch = bullet();
    let surface = ReferenceSurface::cast(&touch, &rays).unwrap();
    let mut seen = 0;
    for pixel in 0..rays.len() {
        let Some(ray) = rays.ray(pixel) else { continue };
        // Above the centre on the sphere, below it on the wall.
        let from_centre = ray.origin - Point3::new(0.0, 0.0, 6.0);
        let b = from_centre.dot(&ray.direction);
        let [_, sphere] = roots(1.0, b, from_centre.norm_squared() - 225.0).unwrap();
        let (o, d) = (ray.origin.coords.xy(), ray.direction.xy());
        let [_, wall] = roots(d.norm_squared(), o.dot(&d), o.norm_squared() - 225.0).unwrap();
        let expected = if ray.at(sphere).z >= 6.0 { sphere } else { wall };
        let found = surface.range_mm()[pixel];
        if ray.at(expected).z < 0.0 {
            assert!(found.is_nan());
        } else {
            assert!((found - expected).abs() < TOLERANCE_MM, "{found} {expected}");
            seen += 1;
        }
    }
    assert_eq!(seen, surface.visible_pixels());
    assert!(seen > 15_000);
    // Normals point away from the axis of the wall or the centre of the dome.
    let map = surface.map_without_contact();
    for (point, normal) in map.point_in_sensor().zip(map.normal_in_sensor()) {
        if point.x.is_finite() {
            let outward = point - Point3::new(0.0, 0.0, point.z.min(6.0));
            assert!((normal - outward / 15.0).norm() < 1e-12);
        }
    }
    assert!(map.indentation_mm().all(|mm| mm.is_nan() || mm == 0.0));
    assert!(map.contact().all(|contact| !contact));
}

#[test]
fn every_kind_of_surface_is_left_where_its_solid_is() {
    // The same surfaces as solids, whose crossings are tested in their own crate.
    let domes = [
        bullet(),
        touch(14.0, 30.0, 0.0, 0.0),
        touch(14.0, 30.0, -0.4, 0.0),
        touch(24.0, 24.0, 0.0, -16.0),
    ];
    let pads =
        [pad(Path::rectangle([0.0; 2], [20.0, 16.0], 2.0)), pad(Path::circle([0.0; 2], 9.0))];
    for touch in domes.into_iter().chain(pads) {
        let rays = PixelRays::new(&camera(), &sensor_from_camera());
        let surface = ReferenceSurface::cast(&touch, &rays).unwrap();
        let body = fabkit_geometry::CompiledSolid::new(&touch.solid(0.0, -60.0)).unwrap();
        let mut seen = 0;
        for pixel in (0..rays.len()).step_by(7) {
            let Some(ray) = rays.ray(pixel) else { continue };
            let exit = body.crossings(&ray).iter().map(|c| c.t).fold(0.0, f64::max);
            let found = surface.range_mm()[pixel];
            if found.is_finite() {
                assert!((found - exit).abs() < TOLERANCE_MM, "{found} {exit}");
                seen += 1;
            } else {
                assert!(ray.at(exit).z < touch.foot_z_mm() + TOLERANCE_MM);
            }
        }
        assert!(seen > 1000, "{seen}");
    }
}

/// Range at which a ray first enters a ball, in closed form; local frame of the indenter.
type Entry = fn(&Ray) -> Option<f64>;

fn sphere(ray: &Ray) -> Option<f64> {
    let o = ray.origin.coords;
    roots(1.0, o.dot(&ray.direction), o.norm_squared() - 4.0).map(|[near, _]| near)
}

/// Range at which a ray meets a disc of radius 1 at height z.
fn disc(ray: &Ray, z: f64, radius: f64) -> Option<f64> {
    let t = (z - ray.origin.z) / ray.direction.z;
    (ray.at(t).coords.xy().norm() <= radius).then_some(t)
}

fn first(of: impl IntoIterator<Item = Option<f64>>) -> Option<f64> {
    of.into_iter().flatten().filter(|t| *t > 0.0).min_by(f64::total_cmp)
}

fn cylinder(ray: &Ray) -> Option<f64> {
    let (o, d) = (ray.origin.coords.xy(), ray.direction.xy());
    let sides = roots(d.norm_squared(), o.dot(&d), o.norm_squared() - 1.0).into_iter().flatten();
    let sides = sides.filter(|t| (0.0..=3.0).contains(&ray.at(*t).z)).map(Some);
    first(sides.chain([disc(ray, 0.0, 1.0), disc(ray, 3.0, 1.0)]))
}

/// Radius 0.2 at z = 0, 1.4 at z = 3.
fn cone(ray: &Ray) -> Option<f64> {
    let (o, d) = (ray.origin, ray.direction);
    let (k, r) = (0.4, 0.2 + 0.4 * o.z);
    let a = d.xy().norm_squared() - k * k * d.z * d.z;
    let b = o.coords.xy().dot(&d.xy()) - k * d.z * r;
    let sides = roots(a, b, o.coords.xy().norm_squared() - r * r).into_iter().flatten();
    let sides = sides.filter(|t| (0.0..=3.0).contains(&ray.at(*t).z)).map(Some);
    first(sides.chain([disc(ray, 0.0, 0.2), disc(ray, 3.0, 1.4)]))
}

fn slab(ray: &Ray) -> Option<f64> {
    let (low, high) = (Vector3::new(-2.0, -0.5, 0.0), Vector3::new(2.0, 0.5, 3.0));
    let (mut enter, mut exit) = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in 0..3 {
        let at = |wall: f64| (wall - ray.origin[axis]) / ray.direction[axis];
        let (x, y) = (at(low[axis]), at(high[axis]));
        enter = enter.max(x.min(y));
        exit = exit.min(x.max(y));
    }
    (enter < exit).then_some(enter)
}

#[test]
fn pressed_primitives_agree_with_closed_forms_creases_included() {
    let kinds: [(Solid, Entry); 4] = [
        (Solid::sphere(2.0), sphere),
        (Solid::cylinder(1.0, 3.0), cylinder),
        (Solid::cone(0.2, 1.4, 3.0), cone),
        (Solid::cuboid(4.0, 1.0, 3.0), slab),
    ];
    for interface in [
        Interface::None,
        Interface::Flat(FlatInterface {
            tilt_x_rad: 0.01,
            tilt_y_rad: -0.02,
            ..FlatInterface::bare_in_air(2.0, 1.41)
        }),
    ] {
        let camera = camera();
        let camera = Camera::new(160, 120, *camera.lens(), interface).unwrap();
        let rays = PixelRays::new(&camera, &sensor_from_camera());
        let surface = ReferenceSurface::cast(&bullet(), &rays).unwrap();
        for (i, (solid, entry)) in kinds.iter().enumerate() {
            // z points inwards; oblique, so that edges and side walls are visible.
            let (tilt, azimuth) = (0.3 + 0.2 * i as f64, 1.3 * i as f64);
            let out =
                Vector3::new(tilt.sin() * azimuth.cos(), tilt.sin() * azimuth.sin(), tilt.cos());
            let at = Point3::new(0.0, 0.0, 6.0) + 13.0 * out;
            let pose = Pose::z_to(out + Vector3::new(0.2, -0.1, 0.0), at);
            let indenter = PlacedIndenter::new("it", solid, pose).unwrap();
            let map = surface.map_with_indenters(&[indenter]);
            let inverse = pose.inverse();
            let mut contact = 0;
            for (pixel, normal) in map.normal_in_sensor().into_iter().enumerate() {
                let Some(ray) = rays.ray(pixel) else { continue };
                let reference = surface.range_mm()[pixel];
                if reference.is_nan() {
                    continue;
                }
                let local = Ray {
                    origin: inverse.point(ray.origin),
                    direction: inverse.vector(ray.direction),
                };
                let entered = entry(&local).filter(|t| *t > 0.0 && *t < reference);
                let expected = entered.unwrap_or(reference);
                let found = map.range_mm()[pixel];
                assert!((found - expected).abs() < TOLERANCE_MM, "{i}: {found} {expected}");
                let label = map.label()[pixel];
                // At the very edge of the contact both are right.
                if (reference - expected).abs() > TOLERANCE_MM {
                    assert_eq!(label, SURFACE_LABEL + 1);
                    contact += 1;
                }
                assert!(normal.dot(&ray.direction) > -1e-9, "out of the gel");
            }
            assert!(contact > 15, "{i}: {contact}");
        }
    }
}

#[test]
fn a_finer_image_holds_the_coarser_one() {
    let (camera, pose) = (camera(), sensor_from_camera());
    let (coarse, fine) =
        (PixelRays::new(&camera, &pose), PixelRays::with_samples(&camera, &pose, 3));
    let (coarse, fine) = (
        ReferenceSurface::cast(&bullet(), &coarse).unwrap().range_mm().to_vec(),
        ReferenceSurface::cast(&bullet(), &fine).unwrap().range_mm().to_vec(),
    );
    let mut same = 0;
    for row in 0..120 {
        for column in 0..160 {
            let [a, b] = [coarse[row * 160 + column], fine[(3 * row + 1) * 480 + 3 * column + 1]];
            assert!(a.is_nan() && b.is_nan() || (a - b).abs() < 1e-10);
            same += usize::from(a.is_finite());
        }
    }
    assert!(same > 15_000);
}

#[test]
fn a_press_is_the_same_on_any_number_of_threads() {
    let pose = Pose::z_to(Vector3::new(0.5, 0.2, 1.0), Point3::new(5.0, 3.0, 19.0));
    let indenter = PlacedIndenter::new("ball", &Solid::sphere(2.0), pose).unwrap();
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let rays = PixelRays::new(&camera(), &sensor_from_camera());
            let surface = ReferenceSurface::cast(&bullet(), &rays).unwrap();
            let map = surface.map_with_indenters(std::slice::from_ref(&indenter));
            let bits: Vec<u64> = map.range_mm().iter().map(|range| range.to_bits()).collect();
            (bits, map.label().to_vec())
        })
    };
    assert!(run(1) == run(3));
}

/// A punch with a flat end, 1 mm deep at the apex.
fn punch() -> PlacedIndenter {
    let pose = Pose::translation(0.0, 0.0, 20.0);
    PlacedIndenter::new("punch", &Solid::cylinder(2.0, 5.0), pose).unwrap()
}

#[test]
fn a_membrane_fades_from_the_edge_of_a_punch_and_leaves_the_contact_alone() {
    let rays = PixelRays::new(&camera(), &Pose::translation(0.0, 0.0, -7.0));
    let surface = ReferenceSurface::cast(&bullet(), &rays).unwrap();
    let rigid = surface.map_with_indenters(&[punch()]);
    let soft = rigid.clone().with_membrane(1.5);
    let bits = |ranges: &[f64]| ranges.iter().map(|range| range.to_bits()).collect::<Vec<u64>>();
    assert!(bits(rigid.clone().with_membrane(0.0).range_mm()) == bits(rigid.range_mm()));
    assert_eq!(soft.label(), rigid.label());
    let deepest = rigid.indentation_mm().filter(|mm| mm.is_finite()).fold(0.0, f64::max);
    let normals = soft.normal_in_sensor();
    let rest: Vec<Point3<f64>> = surface.map_without_contact().point_in_sensor().collect();
    let mut faded = 0;
    for (pixel, (hard, mm)) in rigid.indentation_mm().zip(soft.indentation_mm()).enumerate() {
        if hard.is_nan() {
            continue;
        }
        let from_axis = rest[pixel].coords.xy().norm();
        assert!(mm >= hard && mm <= deepest + 1e-12);
        // Nothing moves farther from the punch's edge than the radius.
        if from_axis > 2.0 + 1.5 {
            assert_eq!(mm, hard);
        }
        if mm > hard + 1e-3 && from_axis > 2.05 {
            faded += 1;
            let outward = normals[pixel];
            assert!((outward.norm() - 1.0).abs() < 1e-12);
            assert!(outward.dot(&rays.ray(pixel).unwrap().direction) > 0.0);
        }
    }
    assert!(faded > 50, "{faded}");
}

#[test]
fn halves_are_stitched_along_the_seam() {
    stitched_along_the_seam(&bullet(), 19.0);
    let flat = pad(Path::rectangle([0.0; 2], [20.0, 16.0], 2.0));
    let TouchSurface::Plane(plane) = &flat else { panic!("it is flat") };
    // 1 mm deep.
    stitched_along_the_seam(&flat, plane.top_z_mm + 1.0);
}

/// Stitches balls of 2 mm on both sides, with their centres at a height.
fn stitched_along_the_seam(touch: &TouchSurface, middle_z_mm: f64) {
    let rays = PixelRays::new(&camera(), &sensor_from_camera());
    let surface = ReferenceSurface::cast(touch, &rays).unwrap();
    let ball = |x: f64| {
        let pose = Pose::translation(x, 2.0, middle_z_mm);
        PlacedIndenter::new("ball", &Solid::sphere(2.0), pose).unwrap()
    };
    let (left, right) =
        (surface.map_with_indenters(&[ball(-5.0)]), surface.map_with_indenters(&[ball(5.0)]));
    let both = surface.map_with_indenters(&[ball(-5.0), ball(5.0)]);
    let seam = Seam::new(&surface, Vector3::x(), 0.5);
    let stitched = seam.stitch(left.range_mm(), right.range_mm(), f64::NAN);
    for (pixel, side) in seam.sides().iter().enumerate() {
        match side {
            Side::Neither => assert!(stitched[pixel].is_nan()),
            _ => assert_eq!(stitched[pixel].to_bits(), both.range_mm()[pixel].to_bits()),
        }
    }
    let neither = seam.sides().iter().filter(|side| **side == Side::Neither).count();
    // A strip of 1 mm, and pixels that see no surface: there are more beside a pad.
    assert!((300..8000).contains(&neither), "{neither}");
    // Both balls are visible, each on its own side.
    for (map, sign) in [(&left, -1.0), (&right, 1.0)] {
        let contact: Vec<usize> = map.contact().enumerate().filter(|c| c.1).map(|c| c.0).collect();
        assert!(contact.len() > 50, "{}", contact.len());
        for pixel in contact {
            let place = rays.ray(pixel).unwrap().at(map.range_mm()[pixel]);
            assert!(place.x * sign > 1.0, "{place}");
        }
    }
}

/// A dent of a pad, in closed form: pressed in within a millimetre, raised around it.
struct Dent;

impl Dent {
    fn outwards_mm(x: f64, y: f64) -> f64 {
        let r2 = x * x + (y - 1.0) * (y - 1.0);
        -(1.0 - r2 / 3.0) * (-r2 / 2.0).exp()
    }
}

impl SurfaceDisplacement for Dent {
    fn outwards_mm(&self, point: &Point3<f64>, _: &Vector3<f64>) -> f64 {
        Self::outwards_mm(point.x, point.y)
    }

    fn is_touched(&self, point: &Point3<f64>, _: &Vector3<f64>) -> bool {
        point.x.hypot(point.y - 1.0) < 0.5
    }

    fn limits_mm(&self) -> [f64; 2] {
        [1.0, 0.2]
    }
}

#[test]
fn rays_end_on_a_surface_that_has_moved() {
    let touch = pad(Path::circle([0.0, 0.0], 12.0));
    let rays = PixelRays::new(&camera(), &sensor_from_camera());
    let surface = ReferenceSurface::cast(&touch, &rays).unwrap();
    // A punch that presses within its edge, and stands clear of the raised gel beyond.
    let pose = Pose::translation(0.0, 1.0, 3.4);
    let punch = PlacedIndenter::new("punch", &Solid::cylinder(0.8, 5.0), pose).unwrap();
    let map = surface.map_deformed(&[punch], &Dent, true);
    let normals = map.normal_in_sensor();
    let rest: Vec<Point3<f64>> = surface.map_without_contact().point_in_sensor().collect();
    let (mut touched, mut moved, mut out) = (0, 0, 0);
    for (pixel, point) in map.point_in_sensor().enumerate() {
        // At the pad's edge a displaced surface may leave the outline.
        if point.x.is_nan() || rest[pixel].coords.xy().norm() > 9.0 {
            continue;
        }
        if map.label()[pixel] > SURFACE_LABEL {
            touched += 1;
            assert!((point.z - 3.4).abs() < 1e-9, "on the punch");
            continue;
        }
        let z_mm = 4.0 + Dent::outwards_mm(point.x, point.y);
        let is_under_the_punch = point.x.hypot(point.y - 1.0) < 0.8 + 1e-6;
        assert!((point.z - z_mm.min(if is_under_the_punch { 3.4 } else { 9.0 })).abs() < 2e-6);
        if !is_under_the_punch {
            // The surface z = 4 + w(x, y) has the normal (-w_x, -w_y, 1).
            let h = 1e-5;
            let slope = |dx: f64, dy: f64| {
                (Dent::outwards_mm(point.x + dx, point.y + dy)
                    - Dent::outwards_mm(point.x - dx, point.y - dy))
                    / (2.0 * h)
            };
            let expected = Vector3::new(-slope(h, 0.0), -slope(0.0, h), 1.0).normalize();
            assert!((normals[pixel] - expected).norm() < 1e-4, "{} {expected}", normals[pixel]);
            moved += 1;
        }
        out += usize::from(point.z > 4.01);
    }
    assert!(touched > 20 && moved > 3000 && out > 300, "{touched} {moved} {out}");
}
