//! Blocks of rays that follow one itinerary, computed in parallel lanes.

use fabkit_geometry::{Aabb, Point3, Ray, Scratch};

use super::PixelRay;
use super::faces::Faces;
use super::itinerary::{Itinerary, ItineraryStep};
use super::quadric::{Intersections, ZERO_TOLERANCE};
use super::simd_lanes::{
    LANES, Lane, Mask, Triple, ZERO_TRIPLE, advance, bounding_box, gradients, intersect,
    lane_point, mark_outside, may_intersect, refract_lanes, rotate, second_intersections,
    transform,
};
use crate::sensing::SensingSurface;
use crate::trace::{LightPath, RayEnd};

/// Length within a curved surface below which a ray grazes it, mm: it is followed singly, since rounding would decide
/// whether it meets it. At a radius of 100 mm the ray then lies up to 1e-11 mm inside, a hundred times the rounding of
/// coordinates.
const GRAZING_MM: f64 = 1e-4;

/// Rays of a tile along an itinerary.
#[derive(Debug, Default)]
pub(super) struct RayBlocks {
    blocks: Vec<RayBlock>,
    /// Positions for each block and place. The places are the start, each step, and the end if that is not a step.
    points: Vec<Triple>,
    places: usize,
    /// Box around the rays at each place.
    pub(super) boxes: Vec<Aabb>,
    /// Boxes around the rays of the present block at each place.
    own_boxes: Vec<Aabb>,
    end: Option<RayEnd>,
    bends: u32,
}

/// Block of rays at their present positions.
#[derive(Clone, Debug)]
struct RayBlock {
    origin: Triple,
    direction: Triple,
    lead_mm: Lane,
    /// Distance of the last face along the line, and distance at which the line meets that face's surface again.
    at_mm: Lane,
    again_mm: Lane,
    /// Mask of rays that do not follow the itinerary, or may not.
    is_lost: Mask,
}

impl RayBlocks {
    /// Follows rays along an itinerary.
    pub(super) fn follow(
        &mut self,
        plan: &Itinerary,
        rays: &[PixelRay],
        faces: &Faces,
        sensing: Option<&SensingSurface>,
        scratch: &mut Scratch,
    ) {
        let goes_on = matches!(plan.end, RayEnd::Surface | RayEnd::Nothing);
        self.places = plan.steps.len() + 1 + usize::from(goes_on);
        self.end = Some(plan.end);
        let is_mirror = matches!(plan.end, RayEnd::TotalReflection(_));
        let bends = plan.steps.iter().filter(|step| step.ratio.is_some()).count();
        // The last step before a total reflection has a ratio but refracts nothing.
        self.bends = bends as u32 - u32::from(is_mirror);
        self.boxes.clear();
        self.boxes.resize(self.places, Aabb::nothing());
        let count = rays.len().div_ceil(LANES);
        self.blocks.resize(count, RayBlock::EMPTY);
        // Old content is overwritten.
        if self.points.len() < count * self.places {
            self.points.resize(count * self.places, ZERO_TRIPLE);
        }
        let points = self.points.chunks_exact_mut(self.places);
        for ((block, points), rays) in self.blocks.iter_mut().zip(points).zip(rays.chunks(LANES)) {
            block.start(rays);
            points[0] = block.origin;
            let mut before = &[][..];
            for (number, step) in plan.steps.iter().enumerate() {
                let is_mirror = is_mirror && number + 1 == plan.steps.len();
                block.advance_to_step(step, is_mirror, before, faces, &mut points[number + 1]);
                before = &step.faces;
                if block.is_all_lost() {
                    break;
                }
            }
            if let (true, Some(sensing)) = (plan.ends_at_skin, sensing) {
                block.mark_if(|ray| sensing.exit(&ray, scratch).is_some());
            }
            if plan.end == RayEnd::Surface {
                let mut exit = |ray: &Ray, _| Some(sensing?.exit(ray, scratch)?.0);
                points[self.places - 1] = block.advance_to_end(&mut exit, before, faces);
            } else if plan.end == RayEnd::Nothing {
                let mut exit = |ray: &Ray, at_mm| Some(distance_outside(&faces.around, ray, at_mm));
                points[self.places - 1] = block.advance_to_end(&mut exit, before, faces);
                block.at_mm = [f64::INFINITY; LANES];
            }
            if block.is_all_lost() {
                continue;
            }
            let own = &mut self.own_boxes;
            own.clear();
            own.extend(points.iter().map(|points| bounding_box(points, &block.is_lost)));
            let mut is_inside = true;
            for ((step, points), bounds) in plan.steps.iter().zip(&points[1..]).zip(&own[1..]) {
                // Most blocks lie in the room as a whole, which makes tests of single rays superfluous.
                for room in step.rooms.iter().filter(|room| !room.contains_box(bounds)) {
                    is_inside = false;
                    mark_outside(room, points, &mut block.is_lost);
                }
            }
            // Lost rays must not widen the boxes.
            if !is_inside {
                own.clear();
                own.extend(points.iter().map(|points| bounding_box(points, &block.is_lost)));
            }
            for (bounds, own) in self.boxes.iter_mut().zip(own) {
                *bounds = bounds.hull(own);
            }
        }
    }

    /// Returns the number of rays that are not lost.
    pub(super) fn count(&self) -> usize {
        let kept = |block: &RayBlock| block.is_lost.iter().filter(|lost| **lost == 0).count();
        self.blocks.iter().map(kept).sum()
    }

    /// Returns whether a ray is lost.
    pub(super) fn is_lost(&self, ray: usize) -> bool {
        self.blocks[ray / LANES].is_lost[ray % LANES] != 0
    }

    /// Returns the position of a ray at a place.
    pub(super) fn point(&self, ray: usize, place: usize) -> Point3<f64> {
        lane_point(&self.points[ray / LANES * self.places + place], ray % LANES)
    }

    /// Returns the path of a ray that is not lost.
    pub(super) fn path(&self, ray: usize) -> Option<LightPath> {
        let (block, lane) = (&self.blocks[ray / LANES], ray % LANES);
        let last = block.ray(lane);
        (block.is_lost[lane] == 0).then_some(LightPath {
            last,
            lead_mm: block.lead_mm[lane],
            end_mm: block.at_mm[lane],
            end: self.end?,
            bends: self.bends,
        })
    }

    /// Marks as lost the rays that may meet a face on their straight way from one place (or one point) to another.
    pub(super) fn mark_intersecting(
        &mut self,
        faces: &Faces,
        face: u32,
        from: Result<usize, Point3<f64>>,
        to: usize,
    ) {
        let (surface, trim) = (faces.surface(face), faces.trim(face));
        for (number, block) in self.blocks.iter_mut().enumerate() {
            // Without a closed form nothing can be excluded.
            let Some(surface) = surface else {
                block.is_lost = [1; LANES];
                continue;
            };
            let points = &self.points[number * self.places..];
            let constant;
            let from = match from {
                Ok(place) => &points[place],
                Err(point) => {
                    constant = [[point.x; LANES], [point.y; LANES], [point.z; LANES]];
                    &constant
                }
            };
            let to = &points[to];
            let is_near = may_intersect(surface, from, to);
            if trim.has_outline() {
                let is_asked = |lane: &usize| is_near[*lane] != 0 && block.is_lost[*lane] == 0;
                let meetings = (0..LANES)
                    .filter(is_asked)
                    .map(|lane| surface.meetings(&lane_point(from, lane), &lane_point(to, lane)));
                if Intersections::box_around(meetings)
                    .is_some_and(|bounds| trim.misses_box(&bounds))
                {
                    continue;
                }
            }
            for (lane, is_lost) in block.is_lost.iter_mut().enumerate() {
                if is_near[lane] != 0
                    && *is_lost == 0
                    && !surface
                        .meetings(&lane_point(from, lane), &lane_point(to, lane))
                        .miss_face(trim)
                {
                    *is_lost = 1;
                }
            }
        }
    }
}

impl RayBlock {
    /// Block without rays.
    const EMPTY: Self = Self {
        origin: ZERO_TRIPLE,
        direction: ZERO_TRIPLE,
        lead_mm: [0.0; LANES],
        at_mm: [0.0; LANES],
        again_mm: [f64::NAN; LANES],
        is_lost: [1; LANES],
    };

    /// Initializes the block at the start of rays.
    fn start(&mut self, rays: &[PixelRay]) {
        let block = self;
        block.lead_mm = [0.0; LANES];
        block.at_mm = [0.0; LANES];
        block.again_mm = [f64::NAN; LANES];
        for lane in 0..LANES {
            // Surplus lanes hold a copy of the last ray and are lost.
            let (_, _, ray) = &rays[lane.min(rays.len() - 1)];
            for axis in 0..3 {
                block.origin[axis][lane] = ray.origin[axis];
                block.direction[axis][lane] = ray.direction[axis];
            }
            block.is_lost[lane] = u64::from(lane >= rays.len());
        }
    }

    /// Returns whether all rays of the block are lost.
    fn is_all_lost(&self) -> bool {
        self.is_lost.iter().fold(1, |all, is_lost| all & is_lost) != 0
    }

    /// Returns the present straight piece of a ray.
    fn ray(&self, lane: usize) -> Ray {
        let direction = lane_point(&self.direction, lane).coords;
        Ray { origin: lane_point(&self.origin, lane), direction }
    }

    /// Marks as lost the rays that satisfy a condition.
    fn mark_if(&mut self, mut is_so: impl FnMut(Ray) -> bool) {
        for lane in 0..LANES {
            if self.is_lost[lane] == 0 {
                self.is_lost[lane] = u64::from(is_so(self.ray(lane)));
            }
        }
    }

    /// Advances to the faces of a step; `before` are the faces of the previous step. The new positions go to `points`.
    /// A mirror must reflect all rays. Whether the positions lie on the faces is checked elsewhere.
    fn advance_to_step(
        &mut self,
        step: &ItineraryStep,
        is_mirror: bool,
        before: &[u32],
        faces: &Faces,
        points: &mut Triple,
    ) {
        let frame = step.surface.frame();
        // The sign is chosen so that the function grows where it is passed.
        let quadric = if step.grows { *step.surface.quadric() } else { -*step.surface.quadric() };
        let [t_mm, back_mm] = match frame {
            None => intersect(&quadric, &self.origin, &self.direction),
            Some(pose) => {
                intersect(&quadric, &transform(pose, &self.origin), &rotate(pose, &self.direction))
            }
        };
        self.mark_blocked(step, before, faces, &t_mm, &back_mm);
        advance(&self.origin, &self.direction, &t_mm, points);
        let across = step.ratio.map(|_| match frame {
            None => gradients(&quadric, points),
            Some(pose) => gradients(&quadric, &transform(pose, points)),
        });
        let Some((ratio, across)) = step.ratio.zip(across) else {
            (self.at_mm, self.again_mm) = (t_mm, back_mm);
            return;
        };
        let turned_back = frame.map(|pose| rotate(&pose.inverse(), &across));
        let normal = turned_back.as_ref().unwrap_or(&across);
        if is_mirror {
            let squared = refract_lanes(&mut self.direction.clone(), normal, ratio);
            self.mark_unless(|lane| squared[lane] < -ZERO_TOLERANCE);
            self.at_mm = t_mm;
            return;
        }
        let squared = refract_lanes(&mut self.direction, normal, ratio);
        // Rays close to total reflection are followed singly, since rounding would decide.
        self.mark_unless(|lane| squared[lane] > ZERO_TOLERANCE);
        self.again_mm = match frame {
            None => second_intersections(&quadric, &across, &self.direction),
            Some(pose) => second_intersections(&quadric, &across, &rotate(pose, &self.direction)),
        };
        self.origin = *points;
        for (lead_mm, t_mm) in self.lead_mm.iter_mut().zip(&t_mm) {
            *lead_mm += t_mm;
        }
        self.at_mm = [0.0; LANES];
    }

    /// Marks as lost the lanes that do not satisfy a condition.
    fn mark_unless(&mut self, is_so: impl Fn(usize) -> bool) {
        for (lane, is_lost) in self.is_lost.iter_mut().enumerate() {
            *is_lost |= u64::from(!is_so(lane));
        }
    }

    /// Marks as lost the rays that do not meet the next face or graze its surface, and those that, before it, meet its surface or that of
    /// the previous faces on one of these faces.
    fn mark_blocked(
        &mut self,
        step: &ItineraryStep,
        before: &[u32],
        faces: &Faces,
        t_mm: &Lane,
        back_mm: &Lane,
    ) {
        let mut is_between = [0u64; LANES];
        for lane in 0..LANES {
            let (at, t) = (self.at_mm[lane], t_mm[lane]);
            // `&` instead of `&&` avoids branches, so that the loop is vectorized.
            let between = |other: f64| (at < other) & (other < t);
            let is_grazing = (t - back_mm[lane]).abs() < GRAZING_MM;
            self.is_lost[lane] |= u64::from(!((t > at) & (t < f64::INFINITY)) | is_grazing);
            is_between[lane] = u64::from(between(back_mm[lane]) | between(self.again_mm[lane]));
        }
        if step.is_same_surface || is_between.iter().all(|is| *is == 0) {
            return;
        }
        for lane in 0..LANES {
            if is_between[lane] == 0 || self.is_lost[lane] != 0 {
                continue;
            }
            let (at, t, ray) = (self.at_mm[lane], t_mm[lane], self.ray(lane));
            let is_off = |faces_of: &[u32], other: f64| {
                !(at < other && other < t) || faces.miss_point(faces_of, &ray.at(other))
            };
            let is_clear =
                is_off(&step.faces, back_mm[lane]) && is_off(before, self.again_mm[lane]);
            self.is_lost[lane] |= u64::from(!is_clear);
        }
    }

    /// Advances to an end that is not a step, at the distance that `exit` returns for the ray and its last distance.
    fn advance_to_end(
        &mut self,
        exit: &mut impl FnMut(&Ray, f64) -> Option<f64>,
        before: &[u32],
        faces: &Faces,
    ) -> Triple {
        let mut exits_mm = [0.0; LANES];
        for (lane, exit_mm) in exits_mm.iter_mut().enumerate() {
            if self.is_lost[lane] != 0 {
                continue;
            }
            let (ray, at_mm, again_mm) = (self.ray(lane), self.at_mm[lane], self.again_mm[lane]);
            *exit_mm = exit(&ray, at_mm).unwrap_or(f64::NEG_INFINITY);
            let is_between = at_mm < again_mm && again_mm < *exit_mm;
            let is_ahead = at_mm < *exit_mm && exit_mm.is_finite();
            let is_clear = is_ahead && (!is_between || faces.miss_point(before, &ray.at(again_mm)));
            self.is_lost[lane] |= u64::from(!is_clear);
        }
        self.at_mm = exits_mm;
        let mut points = ZERO_TRIPLE;
        advance(&self.origin, &self.direction, &exits_mm, &mut points);
        points
    }
}

/// Returns a distance on a ray that is beyond `at_mm` and from which on the ray lies outside a box.
fn distance_outside(bounds: &Aabb, ray: &Ray, at_mm: f64) -> f64 {
    // Beside the box all of the ray is outside.
    ray.range_in(bounds).map_or(at_mm, |[_, exit_mm]| exit_mm.max(at_mm)) + 1.0
}
