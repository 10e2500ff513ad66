//! Ground truth against another route: protrusions as meshes of 1e-4 mm, cast by parry3d.
//!
//! A mesh whose chords lie within the tolerance moves what a ray meets by no more than the tolerance
//! over the cosine of incidence, as long as the ray meets the same smooth face. At creases and
//! outlines it may meet another one; but then so does an exact ray that is shifted sideways by the
//! tolerance. What is explained by neither is a missed or an extra hit.

use std::f64::consts::PI;

use fabkit_application::depth::ground_truth::{PixelRays, ReferenceSurface, SURFACE_LABEL};
use fabkit_application::fixtures::{PressBody, load};
use fabkit_application::geometry::{DomeSurface, Pose};
use fabkit_application::ground_truth::{Viewpoint, compile_indenters};
use parry3d_f64::math::Vector;
use parry3d_f64::query::{Ray, RayCast};
use parry3d_f64::shape::TriMesh;

const TOLERANCE_MM: f64 = 1e-4;
/// Every other column and row, so that the test takes seconds.
const STEP_PX: usize = 2;
/// Two halves from each side.
const PRESSES: [&str; 4] =
    ["semi-dome-003", "semi-dome-017-flipped", "semi-dome-029", "semi-dome-058-flipped"];

fn mesh_of(body: &PressBody) -> TriMesh {
    let mesh = fabkit_application::mesh::mesh(&body.solid, TOLERANCE_MM).unwrap();
    let mesh = mesh.placed(&body.sensor_from_body);
    let vertices = mesh.vertices.iter().map(|[x, y, z]| Vector::new(*x, *y, *z)).collect();
    TriMesh::new(vertices, mesh.triangles).unwrap()
}

/// Hemisphere and wall, as rings of vertices; chords along and around each take half the tolerance.
fn dome_mesh(touch: &DomeSurface) -> TriMesh {
    let radius_mm = touch.equator_radius_mm();
    let step = 2.0 * (1.0 - 0.5 * TOLERANCE_MM / radius_mm).acos();
    let (rings, around) = ((0.5 * PI / step).ceil() as u32, (2.0 * PI / step).ceil() as u32);
    let mut vertices = Vec::new();
    for ring in 0..=rings + 1 {
        let (r, z) = if ring > rings {
            (radius_mm, touch.foot_z_mm)
        } else {
            let polar = (0.5 * PI * f64::from(ring) / f64::from(rings)).max(1e-9);
            (radius_mm * polar.sin(), touch.centre_z_mm + radius_mm * polar.cos())
        };
        for k in 0..around {
            let (y, x) = (2.0 * PI * f64::from(k) / f64::from(around)).sin_cos();
            vertices.push(Vector::new(r * x, r * y, z));
        }
    }
    let faces = (0..=rings).flat_map(|ring| (0..around).map(move |k| (ring, k)));
    let faces = faces.flat_map(|(ring, k)| {
        let [a, b] = [k, (k + 1) % around].map(|k| ring * around + k);
        [[a, b, a + around], [b, b + around, a + around]]
    });
    TriMesh::new(vertices, faces.collect()).unwrap()
}

#[test]
fn meshes_of_a_tenth_of_a_micrometre_agree_away_from_creases_and_miss_nothing() {
    let yaml = fabkit_application::designs::builtin_yaml("rtac0").unwrap();
    let project = load("rtac0.yaml", yaml, &[]).unwrap();
    let touch = project.design.sensor.touch.as_ref().unwrap();
    let presses = PRESSES.map(|id| project.press(id).unwrap());
    let viewpoint = Viewpoint::new(&project.design.sensor.camera, None, None).unwrap();
    let rays = viewpoint.rays(1);
    let surface = ReferenceSurface::cast(touch, &rays).unwrap();
    let indenters = compile_indenters(&presses).unwrap();
    let map = surface.map_with_indenters(&indenters);

    // The same camera a little aside: every ray moves by 2 to 3.5 tolerances, to all sides.
    let aside = (0..8).map(|corner| {
        let shift = |axis: u32| if corner >> axis & 1 == 0 { -2e-4 } else { 2e-4 };
        let pose = Pose::translation(shift(0), shift(1), shift(2));
        let rays = PixelRays::new(viewpoint.camera(), &pose.then_in(viewpoint.sensor_from_camera));
        let surface = ReferenceSurface::cast(touch, &rays).unwrap();
        surface.map_with_indenters(&indenters).range_mm().to_vec()
    });
    let aside: Vec<Vec<f64>> = aside.collect();

    let dome = dome_mesh(touch.dome().unwrap());
    let bodies: Vec<TriMesh> = presses.iter().flat_map(|p| &p.bodies).map(mesh_of).collect();
    let triangles: usize = bodies.iter().map(|mesh| mesh.indices().len()).sum();
    let incidence_rad: Vec<f64> = map.incidence_rad().collect();
    let cast = |mesh: &TriMesh, ray: &Ray| mesh.cast_local_ray(ray, f64::MAX, false);

    let judge = |pixel: usize, found_mm: f64| -> Verdict {
        let exact_mm = map.range_mm()[pixel];
        let bound_mm = TOLERANCE_MM / incidence_rad[pixel].cos() + 1e-9;
        if exact_mm.is_nan() && found_mm.is_nan() || (found_mm - exact_mm).abs() <= bound_mm {
            return Verdict::WithinChord;
        }
        let around = aside.iter().map(|map| map[pixel]).chain([exact_mm]);
        let is_crease = if found_mm.is_nan() {
            around.into_iter().any(f64::is_nan)
        } else {
            let [low, high] = around.fold([f64::INFINITY, 0.0f64], |[low, high], range_mm| {
                [low.min(range_mm), high.max(range_mm)]
            });
            (low - TOLERANCE_MM..=high + TOLERANCE_MM).contains(&found_mm)
        };
        if is_crease { Verdict::AtCrease } else { Verdict::Wrong }
    };

    let (mut rays_cast, mut contact, mut at_crease, mut micrometres_noticed) = (0, 0, 0, 0);
    let mut wrong = Vec::new();
    let (width, height) = (rays.width_px() as usize, rays.height_px() as usize);
    let pixels = (0..height)
        .step_by(STEP_PX)
        .flat_map(|row| (0..width).step_by(STEP_PX).map(move |column| row * width + column));
    for pixel in pixels {
        let Some(ray) = rays.ray(pixel) else { continue };
        let (o, d) = (ray.origin, ray.direction);
        let ray = Ray::new(Vector::new(o.x, o.y, o.z), Vector::new(d.x, d.y, d.z));
        // Where no surface is seen nothing presses into it.
        let at_rest_mm = cast(&dome, &ray).unwrap_or(f64::NAN);
        let pressed_mm = bodies.iter().filter_map(|mesh| cast(mesh, &ray));
        let found_mm = pressed_mm.fold(at_rest_mm, |least, mm| if mm < least { mm } else { least });
        rays_cast += 1;
        match judge(pixel, found_mm) {
            Verdict::WithinChord => {}
            Verdict::AtCrease => at_crease += 1,
            Verdict::Wrong => {
                wrong.push((pixel % width, pixel / width, map.range_mm()[pixel], found_mm));
            }
        }
        if map.label()[pixel] > SURFACE_LABEL {
            contact += 1;
            micrometres_noticed += usize::from(judge(pixel, found_mm + 1e-3) == Verdict::Wrong);
        }
    }
    println!(
        "{rays_cast} rays, {contact} of them to protrusions of {triangles} triangles: {at_crease} \
         beyond the chord's error at creases, {} missed or extra; a micrometre would be noticed at \
         {micrometres_noticed}",
        wrong.len()
    );
    assert!(wrong.is_empty(), "column, row, exact, found: {wrong:?}");
    assert!(contact > 300 && at_crease < contact / 50, "{contact} {at_crease}");
    assert!(micrometres_noticed > contact * 9 / 10, "{micrometres_noticed}");
}

#[derive(PartialEq)]
enum Verdict {
    /// The chord's error at this incidence.
    WithinChord,
    /// More, but no more than exact rays a little aside.
    AtCrease,
    Wrong,
}
