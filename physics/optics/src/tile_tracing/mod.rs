//! Tracing of many rays at once. Neighbouring rays usually pass the same faces, and it is proved for each that it meets
//! no others.
//!
//! One ray of a tile is traced in full. Other rays follow the faces that it passes, its *itinerary*, in closed form. A
//! ray that passes the same faces of all primitives in the same order is in the same bodies all the way. Three things
//! have to be proved:
//!
//! - The ray meets each surface of the itinerary once between the previous and the next one, and does so on the face
//!   itself.
//! - It meets no other face. Between two faces, the rays of a tile lie in the hull of the boxes around their positions
//!   on these faces. The hull is cut into slices. A face that touches no slice is not met; for a face that does, each
//!   ray is tested.
//! - A face with an outline of its own, such as a plate's, is met inside the outline: on the plane of the plate, no
//!   wall of the plate lies between the position of the first ray and that of the other one.
//! - Faces outside a body's box are left out, so rays may differ in what they have passed before they enter the box. At
//!   a face of such a body, no face of it lies between the position of the first ray and that of the other one.
//!
//! Rays for which this fails get an itinerary of their own. Tiles that need many itineraries are quartered. The
//! remaining rays are traced one by one.

mod chain;
mod edges;
mod faces;
mod itinerary;
mod lanes;
mod quadric;
mod simd_lanes;
mod trim;

use std::ops::Range;

use fabkit_geometry::{Aabb, Point3, Ray, Scratch};

pub(crate) use self::chain::{FaceSurfaces, RefractionSequence};
use self::faces::{Cell, Faces, radius_range};
use self::itinerary::Itinerary;
use self::lanes::RayBlocks;
use crate::stack::OpticalStack;
use crate::trace::{LightPath, Tracer};

/// Edge of a tile, rays. Larger tiles have wider boxes, smaller ones need more itineraries.
pub const TILE: u32 = 32;

/// Number of rays up to which a tile is traced ray by ray: an itinerary costs as much as some rays.
const MAX_SINGLE_RAYS: usize = 6;

/// Maximum number of itineraries of a tile, unless it is too small for quartering to pay.
const MAX_ITINERARIES: usize = 3;

/// Number of rays up to which a tile is not quartered.
const MAX_UNDIVIDED_RAYS: usize = 64;

/// Failed itineraries after which the other rays of a small tile are traced singly: a failure takes as long as tracing
/// a ray.
const MAX_FAILED_ITINERARIES: usize = 2;

/// Number of slices between two faces.
const SLICES: usize = 8;

/// Stack prepared for tracing many rays.
///
/// ```
/// # use fabkit_geometry::{Angle, Assembly, Body, MaterialProperties, NominalCamera, OpticalClarity};
/// # use fabkit_geometry::{Placement, Point3, Pose, Ray, Sensor, Solid, Vector3};
/// # let camera = NominalCamera {
/// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
/// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
/// # };
/// # let mut pane = Body::bought("pane", "glass", Solid::cylinder(20.0, 2.0).at(0.0, 0.0, 5.0))
/// #     .with_clarity(OpticalClarity::Clear)
/// #     .placed([Placement::in_place(Assembly::sensor())]);
/// # pane.substance = MaterialProperties { refractive_index: Some(1.5), ..MaterialProperties::default() };
/// use fabkit_optics::{OpticalStack, TILE, TileTracing, Tracer};
///
/// // A tile of rays through a pane: all pass the same two faces, and come out as if traced one by one.
/// let stack = OpticalStack::from_sensor(&Sensor::new("window", "A window", "", camera, [pane]))?;
/// let ray = |column: u32, row: u32| {
///     let direction = Vector3::new(0.01 * f64::from(column), 0.01 * f64::from(row), 1.0).normalize();
///     Some(Ray { origin: Point3::origin(), direction })
/// };
/// let (tracing, mut single, mut rays) = (TileTracing::new(&stack), Tracer::new(&stack), 0);
/// tracing.tracer().cast(0..TILE, 0..TILE, &ray, &mut |column, row, path| {
///     let expected = single.follow(&ray(column, row).unwrap());
///     assert!((path.lead_mm - expected.lead_mm).abs() < 1e-9 && path.end == expected.end);
///     rays += 1;
/// });
/// assert_eq!(rays, TILE * TILE);
/// # Ok::<(), fabkit_optics::InvalidStack>(())
/// ```
#[derive(Clone, Debug)]
pub struct TileTracing<'a> {
    stack: &'a OpticalStack,
    faces: Faces,
}

/// Tracer of tiles of rays; one is needed per thread.
#[derive(Debug)]
pub struct TileTracer<'a> {
    of: &'a TileTracing<'a>,
    tracer: Tracer<'a>,
    scratch: Scratch,
    lanes: RayBlocks,
    near_cells: Vec<Cell>,
    /// Rays of the present tile.
    rays: Vec<PixelRay>,
    single_rays: usize,
}

/// Column, row and ray of a pixel.
type PixelRay = (u32, u32, Ray);

impl<'a> TileTracing<'a> {
    /// Prepares all faces of a stack.
    pub fn new(stack: &'a OpticalStack) -> Self {
        Self { stack, faces: Faces::from_items(&stack.items) }
    }

    /// Creates a tracer for the tiles of one thread.
    pub fn tracer(&'a self) -> TileTracer<'a> {
        TileTracer {
            of: self,
            tracer: Tracer::new(self.stack),
            scratch: Scratch::default(),
            lanes: RayBlocks::default(),
            near_cells: Vec::new(),
            rays: Vec::new(),
            single_rays: 0,
        }
    }
}

impl TileTracer<'_> {
    /// Returns the number of rays that have been traced one by one so far.
    pub fn single_ray_count(&self) -> usize {
        self.single_rays
    }

    /// Traces the rays of a rectangle of pixels, which should be about [`TILE`] wide and high. `ray` returns the ray of
    /// a column and a row, if there is one, and `take` receives its path.
    ///
    /// All rays must start at one point or close to it, within one body.
    pub fn cast(
        &mut self,
        columns: Range<u32>,
        rows: Range<u32>,
        ray: &impl Fn(u32, u32) -> Option<Ray>,
        take: &mut impl FnMut(u32, u32, LightPath),
    ) {
        let places = rows.clone().flat_map(|row| columns.clone().map(move |column| (column, row)));
        let mut rays = std::mem::take(&mut self.rays);
        rays.extend(
            places.filter_map(|(column, row)| ray(column, row).map(|ray| (column, row, ray))),
        );
        self.cast_rays(&mut rays, take);
        self.rays = rays;
    }

    /// Traces a list of rays, which is emptied.
    fn cast_rays(&mut self, rays: &mut Vec<PixelRay>, take: &mut impl FnMut(u32, u32, LightPath)) {
        let is_small = rays.len() <= MAX_UNDIVIDED_RAYS;
        let (mut plans, mut nones) = (0, 0);
        while rays.len() > MAX_SINGLE_RAYS && (plans < MAX_ITINERARIES || is_small) {
            plans += 1;
            // Takes the ray in the middle of those left. Its own path comes from the itinerary too, or from tracing it
            // singly.
            let middle = rays.len() / 2;
            rays.swap(0, middle);
            let plan = Itinerary::from_ray(&mut self.tracer, &self.of.faces, &rays[0].2);
            let is_followed =
                plan.as_ref().is_some_and(|plan| self.follow_all(plan, rays, !is_small));
            if is_followed {
                self.take_known_paths(rays, take);
            } else {
                let (column, row, ray) = rays.swap_remove(0);
                self.single_rays += 1;
                take(column, row, self.tracer.follow(&ray));
            }
            nones += usize::from(plan.is_none());
            // Large tiles are quartered at the first failure.
            if nones >= if is_small { MAX_FAILED_ITINERARIES } else { 1 } {
                break;
            }
        }
        if rays.len() <= MAX_SINGLE_RAYS || is_small {
            self.single_rays += rays.len();
            for (column, row, ray) in rays.drain(..) {
                take(column, row, self.tracer.follow(&ray));
            }
            return;
        }
        for mut quarter in quarters(rays) {
            self.cast_rays(&mut quarter, take);
        }
    }

    /// Passes on the paths that are known, and keeps the other rays in the list.
    fn take_known_paths(
        &mut self,
        rays: &mut Vec<PixelRay>,
        take: &mut impl FnMut(u32, u32, LightPath),
    ) {
        let mut number = 0;
        rays.retain(|(column, row, _)| {
            let path = self.lanes.path(number);
            number += 1;
            path.is_none_or(|path| {
                take(*column, *row, path);
                false
            })
        });
    }

    /// Traces all rays along the itinerary of the first, as far as it certainly is theirs. Returns false if that holds
    /// for too few of them to pay, or is uncertain for the first ray itself.
    fn follow_all(&mut self, plan: &Itinerary, rays: &[PixelRay], is_large: bool) -> bool {
        let sensing = self.of.stack.sensing.as_ref();
        self.lanes.follow(plan, rays, &self.of.faces, sensing, &mut self.scratch);
        // At least an eighth of a large tile must follow.
        let is_worth_it = !is_large || 8 * self.lanes.count() > rays.len();
        // The positions of the first ray must be in the boxes, because outlines are checked between it and the others.
        if self.lanes.is_lost(0) || !is_worth_it || !self.mark_outside_outlines(plan) {
            return false;
        }
        self.mark_in_other_primitives(plan);
        self.mark_meeting_other_faces(plan);
        !self.lanes.is_lost(0)
    }

    /// Marks as lost the rays that may meet a face with an outline of its own outside that outline. The first ray meets
    /// it inside, and it is checked that no wall of the primitive lies between its position and the others'. Returns
    /// false if the straight way between them does not lie in the face.
    fn mark_outside_outlines(&mut self, plan: &Itinerary) -> bool {
        let faces = &self.of.faces;
        for (number, step) in plan.steps.iter().enumerate() {
            let bounds = &self.lanes.boxes[number + 1].clone();
            let radius_mm = radius_range(bounds);
            for face in step.faces.iter().filter(|face| !faces.trim(**face).is_exact) {
                let Range { start, end } = faces.trim(*face).cells;
                let mut asked = None;
                for cell in &faces.cells[start as usize..end as usize] {
                    let is_other = cell.face != *face && asked != Some(cell.face);
                    if is_other && cell.touches(bounds, radius_mm) {
                        if !step.surface.is_flat() {
                            return false;
                        }
                        asked = Some(cell.face);
                        let inside = self.lanes.point(0, number + 1);
                        self.lanes.mark_intersecting(faces, cell.face, Err(inside), number + 1);
                    }
                }
            }
        }
        true
    }

    /// Marks as lost the rays that may be in other primitives than the first ray at a face of a clipped item: those with
    /// a face of the item between their positions.
    fn mark_in_other_primitives(&mut self, plan: &Itinerary) {
        let faces = &self.of.faces;
        for (number, step) in plan.steps.iter().enumerate() {
            let bounds = &self.lanes.boxes[number + 1].clone();
            let radius_mm = radius_range(bounds);
            let first = self.lanes.point(0, number + 1);
            for face in &step.faces {
                let Range { start, end } = faces.trim(*face).clipped_item_cells;
                let mut asked = None;
                for cell in &faces.cells[start as usize..end as usize] {
                    let is_other = !step.faces.contains(&cell.face) && asked != Some(cell.face);
                    if is_other && cell.touches(bounds, radius_mm) {
                        asked = Some(cell.face);
                        self.lanes.mark_intersecting(faces, cell.face, Err(first), number + 1);
                    }
                }
            }
        }
    }

    /// Marks as lost the rays that may meet a face that is not in their itinerary.
    fn mark_meeting_other_faces(&mut self, plan: &Itinerary) {
        for number in 0..self.lanes.boxes.len() - 1 {
            let pair = [self.lanes.boxes[number], self.lanes.boxes[number + 1]];
            let before = number.checked_sub(1).map_or(&[][..], |n| &plan.steps[n].faces);
            let after = plan.steps.get(number).map_or(&plan.last_faces[..], |step| &step.faces);
            let is_passed = |cell: &Cell| before.contains(&cell.face) || after.contains(&cell.face);
            let hull = pair[0].hull(&pair[1]);
            let radius_mm = radius_range(&hull);
            let mut near = std::mem::take(&mut self.near_cells);
            near.clear();
            let cells = self.of.faces.overlapping_cells(&hull, radius_mm);
            near.extend(cells.filter(|cell| !is_passed(cell)));
            if !near.is_empty() {
                let slices = slices(&pair);
                // Cells of one face follow each other, so each face is tested once.
                let mut asked = None;
                for cell in &near {
                    let is_touched = |(slice, radius_mm): &(Aabb, _)| {
                        cell.touches(slice, *radius_mm)
                            && !self.of.faces.misses_box(cell.face, slice)
                    };
                    if asked != Some(cell.face) && slices.iter().any(is_touched) {
                        asked = Some(cell.face);
                        let (face, faces) = (cell.face, &self.of.faces);
                        self.lanes.mark_intersecting(faces, face, Ok(number), number + 1);
                    }
                }
            }
            self.near_cells = near;
        }
    }
}

/// Cuts the room between two boxes into slices, each with its range of distances from the z axis.
fn slices(pair: &[Aabb; 2]) -> [(Aabb, [f64; 2]); SLICES] {
    let at = |k: usize| {
        let share = k as f64 / SLICES as f64;
        let mix = |a: &Point3<f64>, b: &Point3<f64>| a + share * (b - a);
        Aabb { min: mix(&pair[0].min, &pair[1].min), max: mix(&pair[0].max, &pair[1].max) }
    };
    std::array::from_fn(|k| {
        let slice = at(k).hull(&at(k + 1));
        (slice, radius_range(&slice))
    })
}

/// Divides rays into quarters by halving their range of columns and rows.
fn quarters(rays: &mut Vec<PixelRay>) -> [Vec<PixelRay>; 4] {
    let span = |of: fn(&PixelRay) -> u32| {
        let (low, high) = rays.iter().map(of).fold((u32::MAX, 0), |(l, h), v| (l.min(v), h.max(v)));
        low + (high - low).div_ceil(2)
    };
    let (column, row) = (span(|ray| ray.0), span(|ray| ray.1));
    let mut quarters: [Vec<PixelRay>; 4] = Default::default();
    for ray in rays.drain(..) {
        quarters[usize::from(ray.0 >= column) + 2 * usize::from(ray.1 >= row)].push(ray);
    }
    quarters
}
