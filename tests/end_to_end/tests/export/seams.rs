//! Where faces of different primitives meet, meshes keep to the tolerance as everywhere else: looked
//! for on both sides of every such edge, where lines thrown at a part hardly ever pass.

use std::collections::BTreeMap;

use fabkit_designs::Design;
use fabkit_geometry::{CompiledSolid, Crossing, Point3, Ray, Scratch, Solid, Vector3};
use fabkit_mesh::{DEFAULT_TOLERANCE_MM, TriMesh, mesh};

/// Rounding of the comparison itself, mm.
const ROUNDING_MM: f64 = 1e-9;

/// Asks an exact solid how near its surface is, by lines alone.
struct Nearness {
    body: CompiledSolid,
    scratch: Scratch,
    hits: Vec<Crossing>,
}

impl Nearness {
    fn new(solid: &Solid) -> Self {
        let body = CompiledSolid::new(solid).unwrap();
        Self { body, scratch: Scratch::default(), hits: Vec::new() }
    }

    /// How far the surface is along a line, either way, mm.
    fn along(&mut self, from: Vector3<f64>, direction: Vector3<f64>) -> f64 {
        let ray = Ray { origin: Point3::from(from), direction };
        self.body.crossings_into(&ray, &mut self.scratch, &mut self.hits);
        self.hits.iter().map(|hit| hit.t.abs()).fold(f64::INFINITY, f64::min)
    }

    /// At least the distance of a point from the surface, mm. The search for the shortest way ends as
    /// soon as one is no longer than `enough_mm`.
    fn at_most_mm(&mut self, from: Vector3<f64>, first: &[Vector3<f64>], enough_mm: f64) -> f64 {
        let all_round = (0..13).map(|i| {
            let [x, y, z] = [i % 3 - 1, i / 3 % 3 - 1, i / 9].map(f64::from);
            // Askew: not along faces.
            Vector3::new(x + 0.01, y - 0.013, z + 0.107).normalize()
        });
        let mut best = (f64::INFINITY, Vector3::z());
        for direction in first.iter().copied().chain(all_round) {
            let way = self.along(from, direction);
            if way < best.0 {
                best = (way, direction);
            }
            if best.0 <= enough_mm {
                return best.0;
            }
        }
        let mut step: f64 = 0.5;
        while step > 1e-4 {
            let aside = best.1.cross(&best.1.yzx()).normalize();
            let other = best.1.cross(&aside);
            let turned = (0..8).map(|k| {
                let (s, c) = (f64::from(k) * std::f64::consts::FRAC_PI_4).sin_cos();
                (best.1 + step * (c * aside + s * other)).normalize()
            });
            let ways = turned.map(|direction| (self.along(from, direction), direction));
            let nearest = ways.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
            if nearest.0 < best.0 {
                best = nearest;
            } else {
                step /= 2.0;
            }
            if best.0 <= enough_mm {
                break;
            }
        }
        best.0
    }
}

/// The farthest from the exact solid of the points on and beside edges between different primitives,
/// mm, and where it is. Anything up to `enough_mm` may be reported as that.
fn worst_at_seams(solid: &Solid, mesh: &TriMesh, enough_mm: f64) -> (f64, Vector3<f64>) {
    let at = |v: u32| Vector3::from(mesh.vertices[v as usize]);
    let mut triangle_of = BTreeMap::new();
    for (t, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        triangle_of.extend([[a, b], [b, c], [c, a]].map(|edge| (edge, t)));
    }
    let normal = |t: usize| {
        let [a, b, c] = mesh.triangles[t].map(at);
        (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or(Vector3::z())
    };
    let mut exact = Nearness::new(solid);
    let mut worst = (0.0, Vector3::zeros());
    let mut look = |point: Vector3<f64>, first: &[Vector3<f64>]| {
        let distance_mm = exact.at_most_mm(point, first, enough_mm);
        if distance_mm > worst.0 {
            worst = (distance_mm, point);
        }
    };
    for (&[a, b], &t) in &triangle_of {
        let other = triangle_of[&[b, a]];
        if mesh.faces[t].leaf == mesh.faces[other].leaf {
            continue;
        }
        if a < b {
            for share in [0.25, 0.5, 0.75] {
                look((1.0 - share) * at(a) + share * at(b), &[normal(t), normal(other)]);
            }
        }
        let [p, q, r] = mesh.triangles[t].map(at);
        for point in [(p + q + r) / 3.0, (p + q) / 2.0, (q + r) / 2.0, (r + p) / 2.0] {
            look(point, &[normal(t)]);
        }
    }
    worst
}

fn check(designs: &[Design], tolerance_mm: f64) {
    let mut beyond = Vec::new();
    for design in designs {
        for part in design.sensor.parts() {
            let mesh = mesh(&part.solid, tolerance_mm).unwrap();
            let (worst_mm, at) = worst_at_seams(&part.solid, &mesh, 0.9 * tolerance_mm);
            if worst_mm > tolerance_mm + ROUNDING_MM {
                let (sensor, part) = (&design.sensor.name, &part.name);
                let [x, y, z] = at.into();
                beyond
                    .push(format!("{sensor} {part}: {worst_mm:.5} mm at ({x:.3}, {y:.3}, {z:.3})"));
            }
        }
    }
    assert!(beyond.is_empty(), "beyond {tolerance_mm} mm:\n{}", beyond.join("\n"));
}

#[test]
fn meshes_keep_to_the_tolerance_where_primitives_meet() {
    check(&fabkit_tests::builtin_designs(), DEFAULT_TOLERANCE_MM);
}

#[test]
fn meshes_of_fixtures_keep_to_the_tolerance_where_primitives_meet() {
    let mut fixtures = fabkit_tests::builtin_fixtures();
    for design in &mut fixtures {
        // Of a hundred halves of calibration bodies, a few.
        design.sensor.bodies.truncate(12);
    }
    check(&fixtures, DEFAULT_TOLERANCE_MM);
}
