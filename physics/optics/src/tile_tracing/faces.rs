//! Faces of the bodies: their quadrics where they have one, and bounding cells.

use std::f64::consts::FRAC_PI_2;
use std::ops::Range;

use fabkit_geometry::{
    Aabb, Angle, CompiledSolid, Crossing, EllipsoidOffset, PlacedPrimitive, Point3, Pose, Ray,
    Scratch, Solid, Vector3,
};

use super::edges::{Edge, bounding_box, edges};
use super::quadric::{Quadric, Surface};
use super::trim::{Outline, Trim};
use crate::stack::Item;
use crate::trace::box_entry;

/// Parts per quarter into which curved edges are split, so that their boxes are tight.
pub(super) const PARTS_PER_QUARTER: usize = 12;

/// Margin of boxes for rounding, mm.
pub(super) const SLACK_MM: f64 = 1e-6;

/// Bounding volume of a part of a face: a box and a range of distances from the z axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    pub(super) face: u32,
    pub(super) bounds: Aabb,
    /// Minimum and maximum distance from the z axis, mm.
    pub(super) radius_mm: [f64; 2],
}

impl Cell {
    /// Returns whether the cell overlaps a box and its range of distances from the z axis.
    #[inline]
    pub(super) fn touches(&self, bounds: &Aabb, radius_mm: [f64; 2]) -> bool {
        let overlap = |axis: usize| {
            self.bounds.min[axis] <= bounds.max[axis] && bounds.min[axis] <= self.bounds.max[axis]
        };
        overlap(2)
            && self.radius_mm[0] <= radius_mm[1]
            && radius_mm[0] <= self.radius_mm[1]
            && overlap(0)
            && overlap(1)
    }
}

/// All faces of the primitives of all items, including those that other primitives have cut away. A ray that passes the
/// same faces of primitives as another one is therefore in the same bodies.
#[derive(Clone, Debug)]
pub(super) struct Faces {
    pub(super) cells: Vec<Cell>,
    surfaces: Vec<Option<Surface>>,
    /// Trim of each face.
    trims: Vec<Trim>,
    /// For each primitive, a cell around all of its cells, and their range.
    groups: Vec<(Cell, Range<u32>)>,
    /// Primitives of each item.
    leaves: Vec<Vec<Leaf>>,
    /// Bounding box of each item.
    bounds: Vec<Aabb>,
    /// Box around all cells.
    pub(super) around: Aabb,
}

/// Placed primitive.
#[derive(Clone, Debug)]
struct Leaf {
    solid: CompiledSolid,
    /// Box around the primitive, with a margin.
    bounds: Aabb,
    first_face: u32,
}

/// Intersection of a line with a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct FaceIntersection {
    pub(super) t_mm: f64,
    pub(super) face: u32,
}

impl Faces {
    /// Creates a set without faces.
    fn empty() -> Self {
        Self {
            cells: Vec::new(),
            groups: Vec::new(),
            surfaces: Vec::new(),
            trims: Vec::new(),
            leaves: Vec::new(),
            bounds: Vec::new(),
            around: Aabb::nothing(),
        }
    }

    /// Collects the faces of all items.
    pub(super) fn from_items(items: &[Item]) -> Self {
        let mut faces = Self::empty();
        for item in items {
            let mut leaves = Vec::new();
            let (item_first, item_cells) = (faces.surfaces.len(), faces.cells.len() as u32);
            let mut is_clipped = false;
            for leaf in item.solid.leaves() {
                let (first, cells) = (faces.surfaces.len() as u32, faces.cells.len());
                faces.add(leaf);
                is_clipped |= faces.clip(cells, &item.bounds);
                faces.groups.push((
                    enclosing_cell(&faces.cells[cells..]),
                    cells as u32..faces.cells.len() as u32,
                ));
                let cells = cells as u32..faces.cells.len() as u32;
                faces.trims[first as usize..]
                    .iter_mut()
                    .for_each(|trim| trim.cells = cells.clone());
                let placed = leaf.primitive.clone().placed(leaf.body_from_leaf);
                // A primitive of a valid solid is valid.
                leaves.extend(CompiledSolid::new(&placed).ok().map(|solid| Leaf {
                    bounds: solid.bounds().grown(SLACK_MM),
                    solid,
                    first_face: first,
                }));
            }
            if is_clipped {
                let cells = item_cells..faces.cells.len() as u32;
                faces.trims[item_first..]
                    .iter_mut()
                    .for_each(|trim| trim.clipped_item_cells = cells.clone());
            }
            faces.leaves.push(leaves);
            faces.bounds.push(item.bounds);
        }
        let all = faces.cells.iter().map(|cell| cell.bounds);
        faces.around = all.fold(Aabb::nothing(), |hull, bounds| hull.hull(&bounds));
        faces
    }

    /// Clips the cells added since `from` to the item's box, outside of which the item is not. Returns whether that took
    /// anything off.
    ///
    /// Outside the box, rays may then pass other faces than each other: one comes in through a hole, the other beside it.
    /// See [`Trim::clipped_item_cells`].
    fn clip(&mut self, from: usize, bounds: &Aabb) -> bool {
        let added = self.cells.split_off(from);
        let mut is_clipped = false;
        for cell in added {
            let clipped = Cell { bounds: cell.bounds.common(bounds), ..cell };
            is_clipped |= clipped.bounds != cell.bounds;
            if !clipped.bounds.is_empty() {
                self.cells.push(clipped);
            }
        }
        is_clipped
    }

    /// Appends the intersections of a line with the faces of an item's primitives, within the item's box.
    pub(super) fn intersect_item(
        &self,
        item: u32,
        line: &Ray,
        scratch: &mut (Scratch, Vec<Crossing>),
        passed: &mut Vec<FaceIntersection>,
    ) {
        let (scratch, crossings) = scratch;
        for Leaf { solid, bounds, first_face } in &self.leaves[item as usize] {
            if box_entry(bounds, line).is_none() {
                continue;
            }
            solid.crossings_into(line, scratch, crossings);
            let within =
                |crossing: &&Crossing| self.bounds[item as usize].contains(&line.at(crossing.t));
            let of = |crossing: &Crossing| FaceIntersection {
                t_mm: crossing.t,
                face: first_face + crossing.face,
            };
            passed.extend(crossings.iter().filter(within).map(of));
        }
    }

    /// Returns the cells that overlap a box and its range of distances from the z axis, in order.
    pub(super) fn overlapping_cells(
        &self,
        bounds: &Aabb,
        radius_mm: [f64; 2],
    ) -> impl Iterator<Item = &Cell> {
        let bounds = *bounds;
        let near = self.groups.iter().filter(move |(room, _)| room.touches(&bounds, radius_mm));
        let cells =
            near.flat_map(|(_, cells)| &self.cells[cells.start as usize..cells.end as usize]);
        cells.filter(move |cell| cell.touches(&bounds, radius_mm))
    }

    /// Returns whether a face certainly does not pass through a box.
    pub(super) fn misses_box(&self, face: u32, bounds: &Aabb) -> bool {
        let is_missed = |surface: &Surface| surface.misses_box(bounds);
        let trim = self.trim(face);
        self.surface(face).is_some_and(is_missed) || (trim.has_outline() && trim.misses_box(bounds))
    }

    /// Returns whether a point on the surface of the faces certainly lies on none of them.
    pub(super) fn miss_point(&self, faces: &[u32], point: &Point3<f64>) -> bool {
        faces.iter().all(|face| self.trim(*face).misses(point))
    }

    /// Returns the surface of a face, if it is a quadric.
    pub(super) fn surface(&self, face: u32) -> Option<&Surface> {
        self.surfaces[face as usize].as_ref()
    }

    /// Adds all faces of a primitive.
    fn add(&mut self, leaf: &PlacedPrimitive) {
        let first = self.trims.len();
        let pose = &leaf.body_from_leaf;
        let axis = pose.vector(Vector3::z());
        // Exact comparisons: designs place axes exactly along z, and those of revolution exactly on it.
        let is_along = axis.x == 0.0 && axis.y == 0.0;
        let up = AxialPose { pose: *pose, is_along, sign: axis.z.signum() };
        match &leaf.primitive {
            Solid::Sphere(sphere) => {
                let r = sphere.radius_mm;
                let centre = pose.translation_mm();
                let quadric = Some(Quadric::ellipsoid(*centre, r, r));
                let cells = if up.offset() > r {
                    // Far from the axis, rings about it would be wider than the ball.
                    vec![cell_from_box(Aabb {
                        min: Point3::from(centre.add_scalar(-r)),
                        max: Point3::from(centre.add_scalar(r)),
                    })]
                } else {
                    ellipsoid_cells(&up, [r, r])
                };
                self.face(quadric, true, cells);
            }
            Solid::Ellipsoid(ellipsoid) if is_along => {
                let [x, y, z] = ellipsoid.semi_axes_mm;
                // Ellipsoids of three different axes are not among the quadrics used here.
                let quadric = (x == y).then(|| Quadric::ellipsoid(*pose.translation_mm(), x, z));
                self.face(quadric, true, ellipsoid_cells(&up, [x.max(y), z]));
            }
            Solid::EllipsoidOffset(offset) if is_along => {
                let centre = *pose.translation_mm();
                let EllipsoidOffset { equatorial_mm: a, polar_mm: b, offset_mm: by } = *offset;
                // The offset surface of an ellipsoid is a quadric only for spheres.
                let is_quadric = by == 0.0 || a == b;
                let quadric = is_quadric.then(|| Quadric::ellipsoid(centre, a + by, b + by));
                self.face(quadric, true, offset_cells(&up, offset));
            }
            Solid::Cylinder(cylinder) if is_along => {
                let (r, height) = (cylinder.radius_mm, cylinder.height_mm);
                self.add_frustum(&up, [r, r], height);
            }
            Solid::Cone(cone) if is_along => {
                self.add_frustum(&up, [cone.bottom_radius_mm, cone.top_radius_mm], cone.height_mm);
            }
            Solid::Cuboid(cuboid) if is_axis_aligned(pose) => self.add_cuboid(pose, cuboid.size_mm),
            Solid::Extrusion(extrusion) if is_along => {
                let height = extrusion.height_mm;
                let edges = edges(&extrusion.profile.outer, &extrusion.profile.holes);
                let span = bounding_box(&edges);
                // A face spans all distances between those of its edges, and those down to zero if it contains the
                // axis.
                let holds = CompiledSolid::new(&leaf.primitive).is_ok_and(|solid| {
                    let back = pose.inverse().point(Point3::origin());
                    solid.contains(&Point3::new(back.x, back.y, height / 2.0))
                });
                let nearest = edges
                    .iter()
                    .map(|edge| edge.min_axis_distance(&up))
                    .fold(f64::INFINITY, f64::min);
                let outline = Outline::from_extrusion(extrusion, &edges, pose);
                for z in [0.0, height] {
                    let plane =
                        Quadric::plane(Vector3::z(), pose.point(Point3::new(0.0, 0.0, z)).coords);
                    let mut cell = up.cell([span[0], span[1]], [z, z]);
                    cell.radius_mm[0] = if holds { 0.0 } else { nearest };
                    self.face(Some(plane), false, vec![cell]);
                    self.trims.last_mut().expect("of the face just added").outline =
                        outline.clone();
                }
                // The box around at most a quarter of a circle contains no other part of it, unless the box is turned.
                let is_square = is_axis_aligned(pose);
                let is_exact =
                    |edge: &Edge| edge.is_line() || (is_square && edge.is_within_quarter());
                for edge in &edges {
                    self.face(edge.wall_quadric(&up), is_exact(edge), edge.wall_cells(&up, height));
                    // Only the box bounds the wall: an arc about the z axis would lie exactly at the end of its range
                    // of distances, where rounding decides.
                    let trim = self.trims.last_mut().expect("of the face just added");
                    trim.room.radius_mm = [0.0, f64::INFINITY];
                }
            }
            Solid::Revolution(revolution) if is_along => {
                for edge in edges(&revolution.profile.outer, &revolution.profile.holes) {
                    // An edge on the axis sweeps no area.
                    if edge.from[0] == 0.0 && edge.segment.to()[0] == 0.0 && edge.is_line() {
                        self.face(None, false, Vec::new());
                        continue;
                    }
                    let is_exact = up.is_on_axis() && edge.is_within_quarter();
                    self.face(edge.revolved_quadric(&up), is_exact, edge.revolved_cells(&up));
                }
            }
            // A tilted primitive is built upright in its own frame and then moved.
            Solid::Ellipsoid(_)
            | Solid::Cuboid(_)
            | Solid::Cylinder(_)
            | Solid::Cone(_)
            | Solid::Extrusion(_)
            | Solid::Revolution(_) => {
                let (first, cells) = (self.surfaces.len(), self.cells.len());
                self.add(&PlacedPrimitive { body_from_leaf: Pose::identity(), ..leaf.clone() });
                self.move_to_sensor(first, cells, pose);
            }
            other => self.add_bounding_box(other, pose),
        }
        let is_round =
            matches!(leaf.primitive, Solid::Cylinder(_) | Solid::Cone(_) | Solid::Revolution(_));
        if is_round && is_along && !up.is_on_axis() {
            self.trim_around_own_axis(first, leaf);
        }
    }

    /// Replaces the trims of a round primitive beside the z axis: distances from its own axis bound it more tightly.
    fn trim_around_own_axis(&mut self, first: usize, leaf: &PlacedPrimitive) {
        let mut own = Self::empty();
        own.add(&PlacedPrimitive { body_from_leaf: Pose::identity(), ..leaf.clone() });
        let leaf_from_sensor = Some(leaf.body_from_leaf.inverse());
        for (trim, own) in self.trims[first..].iter_mut().zip(own.trims) {
            *trim = Trim { leaf_from_sensor, ..own };
        }
    }

    /// Moves faces that were added in a primitive's own frame to the sensor's frame.
    fn move_to_sensor(&mut self, first: usize, cells: usize, sensor_from_leaf: &Pose) {
        let leaf_from_sensor = sensor_from_leaf.inverse();
        for surface in self.surfaces[first..].iter_mut().flatten() {
            *surface = surface.in_frame(leaf_from_sensor);
        }
        for trim in &mut self.trims[first..] {
            trim.leaf_from_sensor = Some(leaf_from_sensor);
        }
        for cell in &mut self.cells[cells..] {
            let Aabb { min, max } = cell.bounds;
            let corner = |i: usize| {
                let pick = |axis: usize| if i >> axis & 1 == 0 { min[axis] } else { max[axis] };
                sensor_from_leaf.point(Point3::new(pick(0), pick(1), pick(2)))
            };
            let corners = (0..8).map(corner);
            let bounds =
                corners.fold(Aabb::nothing(), |hull, p| hull.hull(&Aabb { min: p, max: p }));
            *cell = Cell { face: cell.face, ..cell_from_box(bounds) };
        }
    }

    /// Returns the trim of a face.
    pub(super) fn trim(&self, face: u32) -> &Trim {
        &self.trims[face as usize]
    }

    /// Adds a face. `is_exact` states that the part of the quadric within the room around all cells is the face.
    fn face(&mut self, quadric: Option<Quadric>, is_exact: bool, cells: Vec<Cell>) {
        let face = self.surfaces.len() as u32;
        self.surfaces.push(quadric.map(Surface::from));
        let room = Cell { face, ..enclosing_cell(&cells) };
        self.trims.push(Trim {
            room,
            leaf_from_sensor: None,
            outline: None,
            is_exact,
            cells: 0..0,
            clipped_item_cells: 0..0,
        });
        self.cells.extend(cells.into_iter().map(|cell| Cell { face, ..cell }));
    }

    /// Adds the faces of a cylinder or a cone.
    fn add_frustum(&mut self, up: &AxialPose, radii: [f64; 2], height: f64) {
        let growth = up.sign * (radii[1] - radii[0]) / height;
        let quadric = Quadric::cone(*up.pose.translation_mm(), radii[0], growth);
        let parts = if growth == 0.0 { 1 } else { PARTS_PER_QUARTER };
        let at = |k: usize| k as f64 / parts as f64;
        let side = (0..parts).map(|k| {
            let [low, high] = [at(k), at(k + 1)];
            let radius = [low, high].map(|s| radii[0] + s * (radii[1] - radii[0]));
            up.ring(
                [radius[0].min(radius[1]), radius[0].max(radius[1])],
                [low * height, high * height],
            )
        });
        self.face(Some(quadric), true, side.collect());
        for (z, r) in [(0.0, radii[0]), (height, radii[1])] {
            let plane =
                Quadric::plane(Vector3::z(), up.pose.point(Point3::new(0.0, 0.0, z)).coords);
            // The ring of distances is exactly a cap only about the sensor's axis.
            self.face(Some(plane), up.is_on_axis(), vec![up.ring([0.0, r], [z, z])]);
        }
    }

    /// Adds the faces of a cuboid.
    fn add_cuboid(&mut self, pose: &Pose, size: [f64; 3]) {
        let [x, y, z] = size;
        let (min, max) = ([-x / 2.0, -y / 2.0, 0.0], [x / 2.0, y / 2.0, z]);
        for side in 0..6 {
            let (axis, value) =
                (side / 2, if side % 2 == 0 { min[side / 2] } else { max[side / 2] });
            let (mut low, mut high) = (min, max);
            (low[axis], high[axis]) = (value, value);
            let corners = (0..8).map(|i| {
                pose.point(Point3::from(
                    [0, 1, 2].map(|k| if i >> k & 1 == 0 { low[k] } else { high[k] }),
                ))
            });
            let bounds = corners
                .clone()
                .fold(Aabb::nothing(), |hull, p| hull.hull(&Aabb { min: p, max: p }));
            let mut normal = Vector3::zeros();
            normal[axis] = 1.0;
            let plane = Quadric::plane(pose.vector(normal), pose.point(Point3::from(low)).coords);
            self.face(Some(plane), true, vec![cell_from_box(bounds)]);
        }
    }

    /// Adds the faces of any other primitive: without quadrics, and with one box for all of them.
    fn add_bounding_box(&mut self, primitive: &Solid, pose: &Pose) {
        let placed = CompiledSolid::new(&primitive.clone().placed(*pose));
        let bounds = placed.map_or_else(|_| Aabb::everything(), |solid| solid.bounds());
        for _ in 0..primitive_faces(primitive) {
            self.face(None, false, vec![cell_from_box(bounds)]);
        }
    }
}

/// Returns whether the axes are exactly parallel to the sensor's.
fn is_axis_aligned(pose: &Pose) -> bool {
    pose.rotation().iter().all(|value| value.fract() == 0.0)
}

/// Returns the maximum number of faces of a primitive.
fn primitive_faces(primitive: &Solid) -> usize {
    let of = |profile: &fabkit_geometry::Profile| {
        let paths = std::iter::once(&profile.outer).chain(&profile.holes);
        paths.map(|path| path.segments.len()).sum::<usize>()
    };
    match primitive {
        Solid::Extrusion(extrusion) => 2 + of(&extrusion.profile),
        Solid::Revolution(revolution) => of(&revolution.profile),
        Solid::Cylinder(_) | Solid::Cone(_) => 3,
        _ => 1,
    }
}

/// Pose of a primitive whose axis is parallel to the sensor's z axis.
pub(super) struct AxialPose {
    pub(super) pose: Pose,
    is_along: bool,
    /// Direction of the axis: -1 if the primitive is upside down.
    pub(super) sign: f64,
}

impl AxialPose {
    /// Returns the distance of the axis from the sensor's, mm.
    fn offset(&self) -> f64 {
        let at = self.pose.translation_mm();
        debug_assert!(self.is_along);
        at.x.hypot(at.y)
    }

    /// Returns whether the axis is the sensor's.
    pub(super) fn is_on_axis(&self) -> bool {
        self.offset() == 0.0
    }

    /// Returns the cell between two corners in the primitive's xy plane and two heights.
    pub(super) fn cell(&self, corners: [[f64; 2]; 2], z: [f64; 2]) -> Cell {
        let [low, high] = corners;
        let points = (0..8).map(|i| {
            let pick = |bit: usize, a: f64, b: f64| if i >> bit & 1 == 0 { a } else { b };
            let point = Point3::new(
                pick(0, low[0], high[0]),
                pick(1, low[1], high[1]),
                pick(2, z[0], z[1]),
            );
            self.pose.point(point)
        });
        cell_from_box(points.fold(Aabb::nothing(), |hull, p| hull.hull(&Aabb { min: p, max: p })))
    }

    /// Returns the cell of a ring around the primitive's axis.
    fn ring(&self, radius: [f64; 2], z: [f64; 2]) -> Cell {
        let r = radius[1];
        let cell = self.cell([[-r, -r], [r, r]], z);
        let offset = self.offset();
        // The circle's own box is smaller than that of a square turned about z.
        let at = self.pose.translation_mm();
        let mut bounds = cell.bounds;
        for axis in 0..2 {
            (bounds.min[axis], bounds.max[axis]) =
                (at[axis] - r - SLACK_MM, at[axis] + r + SLACK_MM);
        }
        let least = (radius[0] - offset).max(offset - radius[1]).max(0.0);
        Cell { bounds, radius_mm: [least - SLACK_MM, radius[1] + offset + SLACK_MM], ..cell }
    }
}

/// Returns the cell of a box, with a margin.
fn cell_from_box(bounds: Aabb) -> Cell {
    let bounds = bounds.grown(SLACK_MM);
    Cell { face: 0, bounds, radius_mm: radius_range(&bounds) }
}

/// Returns the cell around several cells.
fn enclosing_cell(cells: &[Cell]) -> Cell {
    let nothing = Cell { face: 0, bounds: Aabb::nothing(), radius_mm: [f64::INFINITY, 0.0] };
    cells.iter().fold(nothing, |room, cell| Cell {
        face: 0,
        bounds: room.bounds.hull(&cell.bounds),
        radius_mm: [
            room.radius_mm[0].min(cell.radius_mm[0]),
            room.radius_mm[1].max(cell.radius_mm[1]),
        ],
    })
}

/// Returns the minimum and maximum distance of a box from the z axis, mm.
#[inline]
pub(super) fn radius_range(bounds: &Aabb) -> [f64; 2] {
    let near = |axis: usize| bounds.min[axis].max(-bounds.max[axis]).max(0.0);
    let far = |axis: usize| bounds.max[axis].abs().max(bounds.min[axis].abs());
    [near(0).hypot(near(1)), far(0).hypot(far(1))]
}

/// Returns the cells of an ellipsoid of revolution about the axis, from the top down.
fn ellipsoid_cells(up: &AxialPose, half_axes: [f64; 2]) -> Vec<Cell> {
    meridian_cells(up, |polar| {
        let (sin, cos) = polar.sin_cos();
        [half_axes[0] * sin, half_axes[1] * cos]
    })
}

/// Returns the cells of the offset surface of an ellipsoid.
fn offset_cells(up: &AxialPose, offset: &EllipsoidOffset) -> Vec<Cell> {
    meridian_cells(up, |polar| {
        Angle::from_rad(polar).map_or([0.0; 2], |polar| offset.meridian_point(polar))
    })
}

/// Returns the cells of a surface of revolution whose meridian runs from pole to pole and is monotonic in each quarter.
fn meridian_cells(up: &AxialPose, at: impl Fn(f64) -> [f64; 2]) -> Vec<Cell> {
    let point = |k: usize| at(k as f64 * FRAC_PI_2 / PARTS_PER_QUARTER as f64);
    (0..2 * PARTS_PER_QUARTER).map(|k| ring_between(up, point(k), point(k + 1))).collect()
}

/// Returns the cell of the ring between two points of a meridian.
pub(super) fn ring_between(up: &AxialPose, a: [f64; 2], b: [f64; 2]) -> Cell {
    let sort = |a: f64, b: f64| [a.min(b), a.max(b)];
    let radius = sort(a[0], b[0]).map(|r| r.max(0.0));
    up.ring(radius, sort(a[1], b[1]))
}
