//! Many rays at once: neighbours pass the same faces, and it is proved for each that it meets nothing else.
//!
//! Of a tile of rays one is followed in full; the faces that it passes, its *itinerary*, are passed by others
//! in closed form. A ray that passes the same faces of all primitives in the same order is in the same bodies
//! all the way, so that three things are to be shown:
//!
//! - It meets each surface of the itinerary once between its neighbours, and on the face itself.
//! - It meets no other face. Rays of a tile between two faces lie in the hull of the boxes around where they
//!   pass these, cut into slices; what no slice touches is not met. Of what one touches each ray is asked.
//! - A face with an outline of its own, such as a plate's, is met inside that: on the plate's plane, between
//!   where the first ray meets it and where another does, there is no wall of it.
//!
//! Rays for which that fails get an itinerary of their own; tiles that need many are quartered; what is left
//! is followed ray by ray.

mod chain;
mod edges;
mod faces;
mod itinerary;
mod lanes;
mod quadric;
mod trim;
mod wide;

use std::ops::Range;

use fabkit_geometry::{Aabb, Point3, Ray, Scratch};

pub(crate) use self::chain::{Chain, Surfaces};
use self::faces::{Cell, Faces, radius_of};
use self::itinerary::Itinerary;
use self::lanes::Lanes;
use crate::stack::Stack;
use crate::trace::{LightPath, Tracer};

/// Edge of a tile, rays. Larger ones have wider boxes, smaller ones more itineraries.
pub const TILE: u32 = 32;

/// Tiles of so few rays are followed one by one: an itinerary costs as much as some rays.
const FEW: usize = 6;

/// Most itineraries of a tile, unless so few rays are left that quartering is dearer.
const MOST_PLANS: usize = 3;

/// Tiles of so many rays are not quartered.
const SMALL: usize = 64;

/// Rays without an itinerary after which their few neighbours are not asked for one: finding none takes as long
/// as following them.
const MOST_NONES: usize = 2;

/// Slices of the room between two faces.
const SLICES: usize = 8;

/// A stack prepared for many rays.
#[derive(Clone, Debug)]
pub struct Bundles<'a> {
    stack: &'a Stack,
    faces: Faces,
}

/// Casts tiles of rays; one per thread.
#[derive(Debug)]
pub struct TileTracer<'a> {
    of: &'a Bundles<'a>,
    tracer: Tracer<'a>,
    scratch: Scratch,
    lanes: Lanes,
    near: Vec<Cell>,
    /// Of a tile.
    rays: Vec<Numbered>,
    singles: usize,
}

/// A ray of a tile, by its column and row.
type Numbered = (u32, u32, Ray);

impl<'a> Bundles<'a> {
    /// Looks at all faces.
    pub fn new(stack: &'a Stack) -> Self {
        Self { stack, faces: Faces::of(&stack.items) }
    }

    /// For the tiles of one thread.
    pub fn tracer(&'a self) -> TileTracer<'a> {
        TileTracer {
            of: self,
            tracer: Tracer::new(self.stack),
            scratch: Scratch::default(),
            lanes: Lanes::default(),
            near: Vec::new(),
            rays: Vec::new(),
            singles: 0,
        }
    }
}

impl TileTracer<'_> {
    /// How many rays were followed one by one so far.
    pub fn singles(&self) -> usize {
        self.singles
    }

    /// Follows the rays of a rectangle of pixels, which should be about [`TILE`] wide and high; `ray` says
    /// which ray a column and a row have, if any, and `take` gets its path.
    ///
    /// All rays must start at one point or near it, in one body.
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

    /// The same; `rays` ends up empty.
    fn cast_rays(&mut self, rays: &mut Vec<Numbered>, take: &mut impl FnMut(u32, u32, LightPath)) {
        let is_small = rays.len() <= SMALL;
        let (mut plans, mut nones) = (0, 0);
        while rays.len() > FEW && (plans < MOST_PLANS || is_small) {
            plans += 1;
            // One in the middle of what is left; its own path is known as that of the others, or by itself.
            let middle = rays.len() / 2;
            rays.swap(0, middle);
            let plan = Itinerary::of(&mut self.tracer, &self.of.faces, &rays[0].2);
            let is_followed =
                plan.as_ref().is_some_and(|plan| self.follow_all(plan, rays, !is_small));
            if is_followed {
                self.take_followed(rays, take);
            } else {
                let (column, row, ray) = rays.swap_remove(0);
                self.singles += 1;
                take(column, row, self.tracer.follow(&ray));
            }
            nones += usize::from(plan.is_none());
            if nones >= if is_small { MOST_NONES } else { 1 } {
                break;
            }
        }
        if rays.len() <= FEW || is_small {
            self.singles += rays.len();
            for (column, row, ray) in rays.drain(..) {
                take(column, row, self.tracer.follow(&ray));
            }
            return;
        }
        for mut quarter in quarters(rays) {
            self.cast_rays(&mut quarter, take);
        }
    }

    /// Hands out the paths that are known, and leaves the other rays.
    fn take_followed(
        &mut self,
        rays: &mut Vec<Numbered>,
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

    /// Follows along the itinerary of the first of them all rays that it surely is the itinerary of. `false`:
    /// of too few of them it is worth while, or of the first itself it cannot be said.
    fn follow_all(&mut self, plan: &Itinerary, rays: &[Numbered], is_large: bool) -> bool {
        let sensing = self.of.stack.sensing.as_ref();
        self.lanes.follow(plan, rays, &self.of.faces, sensing, &mut self.scratch);
        let is_worth_it = !is_large || 8 * self.lanes.count() > rays.len();
        // Outlines are between the first ray and the others: its points are in the boxes.
        if self.lanes.is_lost(0) || !is_worth_it || !self.drop_outside(plan) {
            return false;
        }
        self.drop_others(plan);
        !self.lanes.is_lost(0)
    }

    /// Drops the rays that may meet a face with an outline of its own outside of that: the first meets it
    /// inside, and no wall of its primitive lies between that place and theirs. `false` where that way does
    /// not lie within the face.
    fn drop_outside(&mut self, plan: &Itinerary) -> bool {
        let faces = &self.of.faces;
        for (number, step) in plan.steps.iter().enumerate() {
            let bounds = &self.lanes.boxes[number + 1].clone();
            let radius_mm = radius_of(bounds);
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
                        self.lanes.lose_those_that_meet(faces, cell.face, Err(inside), number + 1);
                    }
                }
            }
        }
        true
    }

    /// Drops the rays that may meet another face than those of their itinerary.
    fn drop_others(&mut self, plan: &Itinerary) {
        for number in 0..self.lanes.boxes.len() - 1 {
            let pair = [self.lanes.boxes[number], self.lanes.boxes[number + 1]];
            let before = number.checked_sub(1).map_or(&[][..], |n| &plan.steps[n].faces);
            let after = plan.steps.get(number).map_or(&plan.last_faces[..], |step| &step.faces);
            let is_passed = |cell: &Cell| before.contains(&cell.face) || after.contains(&cell.face);
            let hull = pair[0].hull(&pair[1]);
            let radius_mm = radius_of(&hull);
            let mut near = std::mem::take(&mut self.near);
            near.clear();
            let cells = self.of.faces.touching(&hull, radius_mm);
            near.extend(cells.filter(|cell| !is_passed(cell)));
            if !near.is_empty() {
                let slices = slices(&pair);
                // The cells of a face follow one another.
                let mut asked = None;
                for cell in &near {
                    let is_touched = |(slice, radius_mm): &(Aabb, _)| {
                        cell.touches(slice, *radius_mm) && !self.of.faces.is_off(cell.face, slice)
                    };
                    if asked != Some(cell.face) && slices.iter().any(is_touched) {
                        asked = Some(cell.face);
                        let (face, faces) = (cell.face, &self.of.faces);
                        self.lanes.lose_those_that_meet(faces, face, Ok(number), number + 1);
                    }
                }
            }
            self.near = near;
        }
    }
}

/// The room between two boxes, in slices, each with its distances from the z axis.
fn slices(pair: &[Aabb; 2]) -> [(Aabb, [f64; 2]); SLICES] {
    let at = |k: usize| {
        let share = k as f64 / SLICES as f64;
        let mix = |a: &Point3<f64>, b: &Point3<f64>| a + share * (b - a);
        Aabb { min: mix(&pair[0].min, &pair[1].min), max: mix(&pair[0].max, &pair[1].max) }
    };
    std::array::from_fn(|k| {
        let slice = at(k).hull(&at(k + 1));
        (slice, radius_of(&slice))
    })
}

/// By halves of the columns and rows that the rays span.
fn quarters(rays: &mut Vec<Numbered>) -> [Vec<Numbered>; 4] {
    let span = |of: fn(&Numbered) -> u32| {
        let (low, high) = rays.iter().map(of).fold((u32::MAX, 0), |(l, h), v| (l.min(v), h.max(v)));
        low + (high - low).div_ceil(2)
    };
    let (column, row) = (span(|ray| ray.0), span(|ray| ray.1));
    let mut quarters: [Vec<Numbered>; 4] = Default::default();
    for ray in rays.drain(..) {
        quarters[usize::from(ray.0 >= column) + 2 * usize::from(ray.1 >= row)].push(ray);
    }
    quarters
}
