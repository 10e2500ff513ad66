//! Samples of the exact solid (rays, points, landmarks), for comparison with any other geometry kernel.

mod seams;

use std::collections::BTreeMap;

use fabkit_geometry::sequences::SplitMix64;
use fabkit_geometry::{CompiledSolid, Landmark, Point3, Ray, Scratch, Solid, Vector3};
use fabkit_mesh::{DEFAULT_TOLERANCE_MM, FaceId, TriMesh};
use serde::Serialize;

use super::figures::{ExactFigures, figures};
use crate::{ExportError, VERSION, json_bytes};

/// Number of lines of each of the three parallel bundles.
const LINES_PER_BUNDLE: usize = 144;
/// Number of lines aimed at each face of each primitive.
const LINES_PER_FACE: usize = 2;
/// Maximum number of lines aimed at faces.
const MAX_AIMED: usize = 6000;
/// Number of random points that are classified as inside or outside.
const POINTS: usize = 96;
/// Sine of the angle between line and face below which the crossing's position is ill-conditioned.
const GRAZING: f64 = 0.05;
/// Distance below which a kernel with tolerances may merge two crossings, mm.
const CLOSE_MM: f64 = 1e-4;
/// Shift of a line at a landmark or a seam under which its crossings must stay the same, mm. It exceeds the errors of
/// other kernels.
const ASIDE_MM: f64 = 0.02;
/// Distance from the surface below which a landmark lies on it, mm.
const TOUCH_MM: f64 = 1e-7;

/// All samples of one body (`fabkit-samples` version 1).
#[derive(Clone, Debug, Serialize)]
struct Form<'a> {
    format: &'static str,
    version: u32,
    fabkit: &'static str,
    design_hash: &'a str,
    sensor: &'a str,
    name: &'a str,
    figures: ExactFigures,
    /// Cross-section that each line of a bundle stands for, mm^2, for the three directions.
    bundle_mm2: Vec<f64>,
    lines: Vec<Line>,
    points: Vec<Point>,
    landmarks: Vec<LandmarkClaim<'a>>,
}

/// A line with all its crossings of the exact surface.
#[derive(Clone, Debug, Serialize)]
struct Line {
    /// Purpose: `bundle 0` to `bundle 2`, the feature or face that it is aimed at, the seam, or `landmark NAME`.
    of: String,
    origin_mm: [f64; 3],
    /// Direction, unit length.
    direction: [f64; 3],
    /// Positions of the crossings along the line, from the origin, ascending, mm.
    t_mm: Vec<f64>,
    /// Cosine between line and outward normal at each crossing: negative where the line enters.
    cosine: Vec<f64>,
    leaf: Vec<u32>,
    face: Vec<u32>,
}

#[derive(Clone, Debug, Serialize)]
struct Point {
    point_mm: [f64; 3],
    inside: bool,
}

/// Position of a landmark relative to the solid.
#[derive(Clone, Debug, Serialize)]
struct LandmarkClaim<'a> {
    name: &'a str,
    point_mm: [f64; 3],
    axis: [f64; 3],
    /// Location of the landmark: `surface`, `void` or `solid`.
    lies_in: &'static str,
}

/// Body to be sampled.
///
/// ```
/// use fabkit_export::{SamplesDocument, samples};
/// use fabkit_geometry::Solid;
/// use serde_json::Value;
///
/// let solid = Solid::cuboid(6.0, 4.0, 2.0);
/// let document = SamplesDocument {
///     design_hash: "0123",
///     sensor: "demo",
///     name: "block",
///     solid: &solid,
///     landmarks: &[],
/// };
/// let json: Value = serde_json::from_slice(&samples(&document)?)?;
/// let volume_mm3 = json["figures"]["volume_mm3"].as_f64().unwrap_or_default();
/// assert!((volume_mm3 - 48.0).abs() < 1e-9);
/// // Every line enters as often as it leaves.
/// let lines = json["lines"].as_array().map(Vec::as_slice).unwrap_or_default();
/// assert!(lines.iter().all(|line| line["t_mm"].as_array().is_some_and(|t| t.len() % 2 == 0)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct SamplesDocument<'a> {
    /// Hash of the design and the fabkit version, as in the tree file.
    pub design_hash: &'a str,
    /// Name of the sensor.
    pub sensor: &'a str,
    /// Name of the body.
    pub name: &'a str,
    /// Exact shape, mm, in the body's own frame.
    pub solid: &'a Solid,
    /// Landmarks of the body.
    pub landmarks: &'a [Landmark],
}

/// Writes the crossings of lines with the exact solid, points inside and outside, locations of landmarks and the
/// solid's integrals, as JSON (`fabkit-samples` version 1).
///
/// Three bundles of parallel lines measure the whole volume. Two lines are aimed at each face of each primitive that
/// has any surface left, so that no feature is missed. Where faces of two primitives meet, further lines pass the
/// points where triangles deviate most.
///
/// # Errors
/// [`ExportError::Samples`] for a solid that cannot be meshed, [`ExportError::Json`] if the encoder fails.
pub fn samples(document: &SamplesDocument) -> Result<Vec<u8>, ExportError> {
    let refused = |reason: String| ExportError::Samples { name: document.name.into(), reason };
    let body = CompiledSolid::new(document.solid).map_err(|e| refused(e.to_string()))?;
    let (figures, mesh) = figures(document.solid).map_err(|e| refused(e.to_string()))?;
    let mut caster =
        Caster { body: &body, scratch: Scratch::default(), random: SplitMix64::new(1) };
    let reach_mm = (mesh.bounds().max - mesh.bounds().min).norm();

    let mut lines = Vec::new();
    let mut bundle_mm2 = Vec::new();
    for (i, direction) in BUNDLES.iter().enumerate() {
        bundle_mm2.push(caster.bundle(i, Vector3::from(*direction), &mesh, &mut lines));
    }
    caster.cast_at_faces(&mesh, reach_mm, &mut lines);
    // Seams are sampled where a mesh at the usual tolerance deviates, not the finer one of the figures.
    let usual = fabkit_mesh::mesh(document.solid, DEFAULT_TOLERANCE_MM);
    seams::cast_at_seams(
        &mut caster,
        &usual.map_err(|e| refused(e.to_string()))?,
        reach_mm,
        &mut lines,
    );
    let landmarks = document.landmarks.iter().map(|landmark| {
        let lies_in = caster.landmark(landmark, reach_mm, &mut lines);
        let (point_mm, axis) = (landmark.point.coords.into(), landmark.axis.into());
        LandmarkClaim { name: &landmark.name, point_mm, axis, lies_in }
    });
    let landmarks = landmarks.collect();
    let points = caster.points(&mesh);
    json_bytes(&Form {
        format: "fabkit-samples",
        version: 1,
        fabkit: VERSION,
        design_hash: document.design_hash,
        sensor: document.sensor,
        name: document.name,
        figures,
        bundle_mm2,
        lines,
        points,
        landmarks,
    })
}

/// Directions of the bundles, oblique to everything that parts are made of.
const BUNDLES: [[f64; 3]; 3] =
    [[0.9731, 0.1877, 0.1331], [0.1523, 0.9658, 0.2099], [0.1234, 0.0917, 1.0]];

/// Returns four unit vectors perpendicular to a direction.
fn perpendiculars(direction: &Vector3<f64>) -> [Vector3<f64>; 4] {
    let side = direction.cross(&direction.yzx()).try_normalize(1e-6);
    let side = side.unwrap_or_else(|| direction.cross(&Vector3::x()).normalize());
    [side, -side, direction.cross(&side), side.cross(direction)]
}

struct Caster<'a> {
    body: &'a CompiledSolid,
    scratch: Scratch,
    random: SplitMix64,
}

impl Caster<'_> {
    /// Casts a line; `None` where it grazes a face or crossings are too close to each other.
    fn line(&mut self, of: &str, origin: Point3<f64>, direction: Vector3<f64>) -> Option<Line> {
        let direction = direction.normalize();
        let mut crossings = Vec::new();
        self.body.crossings_into(&Ray { origin, direction }, &mut self.scratch, &mut crossings);
        let cosine: Vec<f64> = crossings.iter().map(|c| c.normal.dot(&direction)).collect();
        let t_mm: Vec<f64> = crossings.iter().map(|c| c.t).collect();
        let clear = cosine.iter().all(|c| c.abs() > GRAZING)
            && t_mm.windows(2).all(|pair| pair[1] - pair[0] > CLOSE_MM);
        clear.then(|| Line {
            of: of.into(),
            origin_mm: origin.coords.into(),
            direction: direction.into(),
            t_mm,
            cosine,
            leaf: crossings.iter().map(|c| c.leaf).collect(),
            face: crossings.iter().map(|c| c.face).collect(),
        })
    }

    /// Returns whether slightly shifted lines have as many crossings. A line that follows a face or an edge does not,
    /// and another kernel's result there would be arbitrary.
    fn is_clear(&self, origin: Point3<f64>, direction: Vector3<f64>) -> bool {
        let count = |origin| self.body.crossings(&Ray { origin, direction }).len();
        perpendiculars(&direction)
            .into_iter()
            .all(|aside| count(origin + ASIDE_MM * aside) == count(origin))
    }

    /// Returns whether slightly shifted lines have their crossings at the same positions, allowing for the slope of
    /// faces. A line beside a step does not: a mesh's step is off by a chord, so that a line may cross its other side.
    fn has_steady_crossings(&self, origin: Point3<f64>, direction: Vector3<f64>) -> bool {
        let crossings = |origin| self.body.crossings(&Ray { origin, direction });
        let here = crossings(origin);
        perpendiculars(&direction).into_iter().all(|aside| {
            let moved = crossings(origin + ASIDE_MM * aside);
            moved.len() == here.len()
                && here.iter().zip(&moved).all(|(one, other)| {
                    let cosine = one.normal.dot(&direction).abs().max(GRAZING);
                    (one.t - other.t).abs() <= 2.0 * ASIDE_MM / cosine
                })
        })
    }

    /// Casts lines through a jittered grid over the mesh's shadow. Returns the cross-section that each stands for,
    /// mm^2.
    fn bundle(
        &mut self,
        number: usize,
        direction: Vector3<f64>,
        mesh: &TriMesh,
        lines: &mut Vec<Line>,
    ) -> f64 {
        let direction = direction.normalize();
        let u = direction.cross(&direction.yzx()).normalize();
        let v = direction.cross(&u);
        let span = |w: Vector3<f64>| {
            let heights = mesh.vertices.iter().map(|p| w.dot(&Vector3::from(*p)));
            heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), h| (a.min(h), b.max(h)))
        };
        // Lines start 1 mm behind the body.
        let (span_u, span_v, behind) = (span(u), span(v), span(direction).0);
        let rows = (LINES_PER_BUNDLE as f64).sqrt() as usize;
        let step = |(low, high): (f64, f64), i: usize, jitter: f64| {
            low + (i as f64 + jitter) / rows as f64 * (high - low)
        };
        for i in 0..rows * rows {
            let (a, b) = (self.random.unit(), self.random.unit());
            let at = step(span_u, i % rows, a) * u + step(span_v, i / rows, b) * v;
            let origin = Point3::from(at + (behind - 1.0) * direction);
            lines.extend(self.line(&format!("bundle {number}"), origin, direction));
        }
        (span_u.1 - span_u.0) * (span_v.1 - span_v.0) / (rows * rows) as f64
    }

    /// Casts lines through the centres of triangles of each face, within 60 degrees of their normals.
    fn cast_at_faces(&mut self, mesh: &TriMesh, reach_mm: f64, lines: &mut Vec<Line>) {
        let mut triangles: BTreeMap<FaceId, Vec<usize>> = BTreeMap::new();
        for (index, face) in mesh.faces.iter().enumerate() {
            triangles.entry(*face).or_default().push(index);
        }
        // Fewer lines per face for bodies with very many faces.
        let per_face = LINES_PER_FACE.min(MAX_AIMED / triangles.len().max(1)).max(1);
        for (id, triangles) in triangles.iter().take(MAX_AIMED) {
            let feature = self.body.feature_of(id.leaf);
            let of = match feature {
                "" => format!("leaf {} face {}", id.leaf, id.face),
                name => format!("{name}, leaf {} face {}", id.leaf, id.face),
            };
            let mut found = 0;
            // Many candidates graze something or hit another face first; a few tries per line suffice.
            for _ in 0..12 * per_face {
                if found == per_face {
                    break;
                }
                let index = triangles[(self.random.unit() * triangles.len() as f64) as usize];
                let Some((origin, direction)) = self.aim(mesh, index, reach_mm) else { continue };
                let Some(line) = self.line(&of, origin, direction) else { continue };
                let hits = line.leaf.iter().zip(&line.face);
                if hits.into_iter().any(|(leaf, face)| (*leaf, *face) == (id.leaf, id.face)) {
                    lines.push(line);
                    found += 1;
                }
            }
        }
    }

    /// Aims a line at the centre of a triangle, from outside, at 0.2 to 1 rad from its normal.
    fn aim(
        &mut self,
        mesh: &TriMesh,
        index: usize,
        reach_mm: f64,
    ) -> Option<(Point3<f64>, Vector3<f64>)> {
        let [a, b, c] = mesh.triangles[index].map(|v| Vector3::from(mesh.vertices[v as usize]));
        let normal = (b - a).cross(&(c - a)).try_normalize(1e-12)?;
        let side = normal.cross(&(b - a)).try_normalize(1e-12)?;
        let tilt = 0.2 + 0.8 * self.random.unit();
        let turn = std::f64::consts::TAU * self.random.unit();
        let across = turn.cos() * side + turn.sin() * normal.cross(&side);
        let direction = -(tilt.cos() * normal + tilt.sin() * across);
        let target = Point3::from((a + b + c) / 3.0);
        Some((target - reach_mm * direction, direction))
    }

    /// Casts one line along a landmark's axis and one across it. Returns the location of the landmark.
    fn landmark(
        &mut self,
        landmark: &Landmark,
        reach_mm: f64,
        lines: &mut Vec<Line>,
    ) -> &'static str {
        let axis = landmark.axis.normalize();
        let side = axis.cross(&axis.yzx()).try_normalize(1e-6).unwrap_or_else(|| {
            // For an axis with three equal coordinates.
            axis.cross(&Vector3::x()).normalize()
        });
        let other = axis.cross(&side);
        // Oblique, so that it follows neither the plane of the landmark nor the side of a slot.
        let across = side + 0.11 * other + 0.31 * axis;
        let of = format!("landmark {}", landmark.name);
        for direction in [axis, across.normalize()] {
            let origin = landmark.point - reach_mm * direction;
            if self.is_clear(origin, direction) {
                lines.extend(self.line(&of, origin, direction));
            }
        }
        // Some of these enter the solid even from an edge, whatever faces meet there.
        let oblique = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]]
            .map(|[a, b]| axis + 0.83 * a * side + 0.61 * b * other);
        let touches = [axis, across].into_iter().chain(oblique).any(|direction| {
            let ray = Ray { origin: landmark.point, direction: direction.normalize() };
            let hits = self.body.crossings(&ray);
            hits.iter().any(|c| (c.t * c.normal.dot(&ray.direction)).abs() < TOUCH_MM)
        });
        if touches {
            "surface"
        } else if self.body.contains(&landmark.point) {
            "solid"
        } else {
            "void"
        }
    }

    /// Classifies random points of the bounding box that are not close to the surface.
    fn points(&mut self, mesh: &TriMesh) -> Vec<Point> {
        let bounds = mesh.bounds().grown(0.5);
        let mut points = Vec::with_capacity(POINTS);
        for _ in 0..4 * POINTS {
            if points.len() == POINTS {
                break;
            }
            let size = bounds.max - bounds.min;
            let shift = size.map(|side| side * self.random.unit());
            let point = bounds.min + shift;
            // Distances along three axes stand for the distance from the surface.
            let directions = [Vector3::x(), Vector3::y(), Vector3::z()];
            let is_clear = directions.iter().all(|direction| {
                let ray = Ray { origin: point, direction: *direction };
                self.body.crossings(&ray).iter().all(|c| c.t.abs() > 1e-3)
            });
            if is_clear {
                let inside = self.body.contains(&point);
                points.push(Point { point_mm: point.coords.into(), inside });
            }
        }
        points
    }
}
