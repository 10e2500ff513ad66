//! Itinerary of a ray: the faces that it passes, in order. Neighbouring rays usually have the same one.

use fabkit_geometry::Ray;

use super::faces::{FaceIntersection, Faces};
use super::quadric::Surface;
use super::trim::{Room, Trim};
use crate::snell::refract;
use crate::trace::{PieceEnd, RayEnd, TOUCH_TOLERANCE_MM, Tracer};

/// Faces that are passed together: those of two touching bodies lie in one surface.
#[derive(Clone, Debug)]
pub(super) struct ItineraryStep {
    pub(super) surface: Surface,
    /// True if the surface's function grows along the ray.
    pub(super) grows: bool,
    /// Rooms of the exact faces, in which the ray must meet them. Faces that are not exact are bounded by their
    /// neighbours.
    pub(super) rooms: Vec<Room>,
    /// Refractive index before the surface over that behind it, if light is refracted.
    pub(super) ratio: Option<f64>,
    /// True if the previous step passes the same surface, so that the second intersection of either is the other.
    pub(super) is_same_surface: bool,
    /// Indices of the faces.
    pub(super) faces: Vec<u32>,
}

/// Path of a ray as a sequence of faces.
#[derive(Clone, Debug)]
pub(super) struct Itinerary {
    pub(super) steps: Vec<ItineraryStep>,
    pub(super) end: RayEnd,
    /// True if it ends at skin. Skin hides the sensing surface only from rays that do not reach that surface through
    /// it.
    pub(super) ends_at_skin: bool,
    /// Faces that lie in the sensing surface, if it ends there.
    pub(super) last_faces: Vec<u32>,
}

impl Itinerary {
    /// Finds the itinerary of a ray; `None` if it passes surfaces other than quadrics, or an edge.
    pub(super) fn from_ray(tracer: &mut Tracer, faces: &Faces, ray: &Ray) -> Option<Self> {
        let mut steps = Vec::new();
        let (mut line, mut index, mut from_mm) = (*ray, None, 0.0);
        let mut scratch = Default::default();
        loop {
            let event = tracer.trace_piece(&line, &mut index);
            let at_mm = event.at_mm();
            let mut passed = Vec::new();
            for item in tracer.boxes_before(at_mm + TOUCH_TOLERANCE_MM) {
                faces.intersect_item(item, &line, &mut scratch, &mut passed);
            }
            // Only faces on the present piece.
            passed.retain(|face| face.t_mm > from_mm && face.t_mm <= at_mm + TOUCH_TOLERANCE_MM);
            passed.sort_by(|a, b| a.t_mm.total_cmp(&b.t_mm).then(a.face.cmp(&b.face)));
            // Faces within the tolerance are passed together.
            let mut groups =
                passed.chunk_by(|a, b| b.t_mm - a.t_mm <= TOUCH_TOLERANCE_MM).peekable();
            let mut last_faces = Vec::new();
            while let Some(group) = groups.next() {
                let is_last = groups.peek().is_none();
                if is_last && matches!(event, PieceEnd::End { end: RayEnd::Surface, .. }) {
                    let is_there = (group[0].t_mm - at_mm).abs() <= TOUCH_TOLERANCE_MM;
                    if is_there {
                        last_faces = group.iter().map(|passed| passed.face).collect();
                        break;
                    }
                }
                let mut step = build_step(faces, &line, group)?;
                let last = steps.last();
                step.is_same_surface =
                    last.is_some_and(|last: &ItineraryStep| last.surface.is_same(&step.surface));
                steps.push(step);
            }
            // Otherwise the event belongs to no known face, as at an edge.
            let reaches =
                passed.last().is_some_and(|last| (last.t_mm - at_mm).abs() <= TOUCH_TOLERANCE_MM);
            match event {
                PieceEnd::Bend { normal, to_index, item, .. } if reaches => {
                    let ratio = index? / to_index;
                    steps.last_mut()?.ratio = Some(ratio);
                    let Some(direction) = refract(&line.direction, &normal, ratio) else {
                        let end = RayEnd::TotalReflection(tracer.name(item));
                        return Some(Self { steps, end, ends_at_skin: false, last_faces });
                    };
                    line = Ray { origin: line.at(at_mm), direction };
                    // Skips the face just passed.
                    (index, from_mm) = (Some(to_index), TOUCH_TOLERANCE_MM);
                }
                PieceEnd::End { end: end @ RayEnd::Body(name), .. } if reaches => {
                    let ends_at_skin = tracer.is_skin(name);
                    return Some(Self { steps, end, ends_at_skin, last_faces });
                }
                PieceEnd::End { end: end @ (RayEnd::Surface | RayEnd::Nothing), .. } => {
                    return Some(Self { steps, end, ends_at_skin: false, last_faces });
                }
                _ => return None,
            }
        }
    }
}

/// Builds the step through faces that are passed together; `None` unless they lie in one surface.
fn build_step(faces: &Faces, line: &Ray, group: &[FaceIntersection]) -> Option<ItineraryStep> {
    let surface = faces.surface(group[0].face)?;
    for other in &group[1..] {
        if !faces.surface(other.face)?.is_same(surface) {
            return None;
        }
    }
    let trims = group.iter().map(|passed| faces.trim(passed.face));
    Some(ItineraryStep {
        surface: surface.clone(),
        grows: surface.grows(line, group[0].t_mm),
        rooms: trims.filter(|trim| trim.is_exact).map(Trim::room).collect(),
        ratio: None,
        is_same_surface: false,
        faces: group.iter().map(|passed| passed.face).collect(),
    })
}
