//! Tools of revolution as a sequence of profile segments (strokes).

use std::f64::consts::TAU;

use fabkit_geometry::{Segment, Solid, Vector3};

use crate::facets::Facets;

/// Distance below which two points of a profile count as one, mm.
const SAME_MM: f64 = 1e-9;

/// Tool of revolution around its own z axis, solid up to the axis: a cylinder, a cone, or a profile whose outer path
/// begins and ends on the axis.
///
/// Along its profile, from the lower end of the axis outwards and to the upper end, the solid is on the left.
pub(crate) struct RevolvedTool {
    pub facets: Facets,
    pub strokes: Vec<ToolStroke>,
}

/// Segment of the profile.
pub(crate) struct ToolStroke {
    /// Start point: distance from the axis and z, mm.
    pub from: [f64; 2],
    pub to: [f64; 2],
    pub straight: bool,
    /// Face number within the primitive.
    pub face: u32,
    /// Indices of its triangles in the pin's facets.
    pub triangles: Vec<u32>,
    /// Vertices of the first and the last ring by azimuth from x, for straight strokes; a single one where the ring is
    /// a point on the axis.
    pub rings: [Vec<u32>; 2],
    /// Largest distance from the axis, mm; for curved strokes it includes the tessellation's tolerance.
    radius_mm: f64,
    pub z_mm: [f64; 2],
}

impl RevolvedTool {
    /// Returns whether a solid is one of the primitives that can be such a tool.
    pub fn may_be(solid: &Solid) -> bool {
        matches!(solid, Solid::Cylinder(_) | Solid::Cone(_) | Solid::Revolution(_))
    }

    /// Creates the tool with its tessellation; `None` if the primitive is no such tool.
    pub fn new(primitive: &Solid, facets: &Facets, tolerance_mm: f64) -> Option<Self> {
        let outline = outline(primitive)?;
        let ends = [outline.first()?.from, outline.last()?.to];
        let inner = &outline[1..];
        let on_axis = |p: [f64; 2]| p[0].abs() < SAME_MM;
        // The profile must start and end on the axis and must not touch it in between.
        if !ends.into_iter().all(on_axis) || inner.iter().any(|s| on_axis(s.from)) {
            return None;
        }
        if doubled_area(&outline) <= 0.0 {
            return None;
        }
        let strokes = outline.into_iter().map(|line| ToolStroke::new(line, facets, tolerance_mm));
        let strokes: Vec<ToolStroke> = strokes.collect::<Option<_>>()?;
        Some(Self { facets: facets.clone(), strokes })
    }

    /// Returns the diagonal of its bounding box, mm.
    pub fn diagonal_mm(&self) -> f64 {
        Vector3::from(self.facets.bounds().size_mm()).norm()
    }

    /// Returns the largest distance from the axis between two heights, mm; `None` beyond the tool's ends.
    pub fn radius_between_mm(&self, [low, high]: [f64; 2]) -> Option<f64> {
        let reach = |stroke: &ToolStroke| {
            let [bottom, top] = stroke.z_mm;
            if top < low || bottom > high {
                return None;
            }
            // No interpolation on curved and horizontal strokes: their largest radius is safe.
            if !stroke.straight || top - bottom < SAME_MM {
                return Some(stroke.radius_mm);
            }
            let at = |z: f64| {
                let share = (z - stroke.from[1]) / (stroke.to[1] - stroke.from[1]);
                stroke.from[0] + share * (stroke.to[0] - stroke.from[0])
            };
            Some(at(low.max(bottom)).max(at(high.min(top))))
        };
        self.strokes.iter().filter_map(reach).reduce(f64::max)
    }
}

/// Segment of the profile without tessellation.
struct Line {
    from: [f64; 2],
    to: [f64; 2],
    straight: bool,
    face: u32,
}

fn outline(primitive: &Solid) -> Option<Vec<Line>> {
    let straight = |from, to, face| Line { from, to, straight: true, face };
    let frustum = |bottom: f64, top: f64, height: f64| {
        let corners = [[0.0, 0.0], [bottom, 0.0], [top, height], [0.0, height]];
        // Face numbers of bottom, side and top, in the order of the profile.
        [1, 0, 2]
            .into_iter()
            .enumerate()
            .map(|(i, face)| straight(corners[i], corners[i + 1], face))
            .filter(|line| line.from != line.to)
            .collect()
    };
    match primitive {
        Solid::Cylinder(s) => Some(frustum(s.radius_mm, s.radius_mm, s.height_mm)),
        Solid::Cone(s) => Some(frustum(s.bottom_radius_mm, s.top_radius_mm, s.height_mm)),
        Solid::Revolution(s) if s.profile.holes.is_empty() => {
            let path = &s.profile.outer;
            let mut from = path.start;
            let mut lines = Vec::with_capacity(path.segments.len());
            for (face, segment) in (0..).zip(&path.segments) {
                let to = segment.to();
                let is_straight = matches!(segment, Segment::Line { .. });
                lines.push(Line { from, to, straight: is_straight, face });
                from = to;
            }
            // The segment along the axis sweeps no surface; the sequence starts after it.
            let along_axis = |l: &Line| l.straight && l.from[0].max(l.to[0]) < SAME_MM;
            let axis = lines.iter().position(along_axis)?;
            lines.rotate_left(axis + 1);
            lines.pop();
            Some(lines)
        }
        _ => None,
    }
}

/// Computes twice the area between the corners of a profile and the axis, positive for counter-clockwise profiles.
fn doubled_area(lines: &[Line]) -> f64 {
    lines.iter().map(|l| l.from[0] * l.to[1] - l.to[0] * l.from[1]).sum()
}

impl ToolStroke {
    fn new(line: Line, facets: &Facets, tolerance_mm: f64) -> Option<Self> {
        let Line { from, to, straight, face } = line;
        let numbered = (0..).zip(&facets.faces);
        let triangles: Vec<u32> = numbered.filter(|(_, f)| **f == face).map(|(t, _)| t).collect();
        let mut vertices: Vec<u32> =
            triangles.iter().flat_map(|&t| facets.triangles[t as usize]).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let place = |v: u32| {
            let [x, y, z] = facets.vertices[v as usize];
            [x.hypot(y), z]
        };
        let mut stroke = Self {
            radius_mm: from[0].max(to[0]),
            z_mm: [from[1].min(to[1]), from[1].max(to[1])],
            rings: [Vec::new(), Vec::new()],
            from,
            to,
            straight,
            face,
            triangles,
        };
        if straight {
            stroke.rings = [from, to].map(|end| {
                let near = |v: &u32| {
                    let [r, z] = place(*v);
                    (r - end[0]).hypot(z - end[1]) < SAME_MM
                };
                let mut ring: Vec<u32> = vertices.iter().copied().filter(near).collect();
                ring.sort_by(|&a, &b| azimuth(facets, a).total_cmp(&azimuth(facets, b)));
                ring
            });
            let [first, last] = &stroke.rings;
            // Straight strokes have vertices only on their two end rings.
            let complete = first.len() + last.len() == vertices.len();
            return (complete && !first.is_empty() && !last.is_empty()).then_some(stroke);
        }
        for [r, z] in vertices.into_iter().map(place) {
            stroke.radius_mm = stroke.radius_mm.max(r + tolerance_mm);
            stroke.z_mm = [stroke.z_mm[0].min(z), stroke.z_mm[1].max(z)];
        }
        Some(stroke)
    }
}

/// Returns the azimuth from 0 to a full turn. Angles that rounding puts just below 0 stay there, so that they sort
/// first.
fn azimuth(facets: &Facets, vertex: u32) -> f64 {
    let [x, y, _] = facets.vertices[vertex as usize];
    let angle = y.atan2(x);
    if angle < -SAME_MM { angle + TAU } else { angle }
}
