//! Faces of a part that can carry text: flat or nearly so, not covered by anything that the part touches, and thick
//! enough.

use fabkit_geometry::{
    Body, CompiledSolid, OpticalClarity, Point3, Pose, Ray, Scratch, Sensor, Vector3,
};

/// Flat margin around the letters, mm.
pub(super) const MARGIN_MM: f64 = 0.6;

/// Margin around the letters on round walls, mm, where the letters need all of the little that is nearly flat.
const ROUND_MARGIN_MM: f64 = 0.2;

/// Smallest fall of a face below the text, mm, for it to count as round.
const ROUND_MM: f64 = 0.05;

/// Material behind sunken letters, mm: two lines of a 0.4 mm nozzle.
const BEHIND_MM: f64 = 0.8;

/// Free height above a face, mm: more than letters that stand out, and than parts that are glued on.
const BEFORE_MM: f64 = 1.0;

/// Tolerance within which heights belong to one plane, mm.
const FLAT_MM: f64 = 1e-6;

/// Largest fall of an upright wall below the text, mm: barely visible with a nozzle of 0.4 mm.
const CURVED_MM: f64 = 0.4;

/// Depth below the highest point, mm, down to which faces are preferred: deeper ones are hard to read.
const SHALLOW_MM: f64 = 3.0;

/// Coarse grid: maximum number of lines along an edge of a face, and their smallest distance, mm.
const LINES: (f64, f64) = (36.0, 0.6);

/// Distance of the lines of the fine grid, mm: no wider than the strokes of letters.
const FINE_MM: f64 = 0.45;

/// Maximum number of places on one face that are examined on the fine grid for one text.
const MOST_PLACES: usize = 6;

/// Place for a text.
pub(super) struct LabelPlace {
    /// Pose of the text: x along it, y up, z towards the reader; origin on the highest point of the face below it.
    pub pose: Pose,
    /// Fall of the face below the text, mm; 0 where it is flat.
    pub fall_mm: f64,
}

/// Search for a place on one part.
pub(super) struct FaceSearch<'a> {
    body: &'a Body,
    own: &'a CompiledSolid,
    sensor: &'a Sensor,
    compiled: &'a [Option<CompiledSolid>],
    /// Depth of sunken letters, mm; `None` if they stand out.
    sunken_mm: Option<f64>,
    views: Vec<FaceView>,
}

/// Direction from which faces are examined, in the frame of the body. `axes` point along the text, up, and towards the
/// reader; `middle` and `half` are centre and half edges of the bounding box along them, mm.
struct FaceView {
    axes: [Vector3<f64>; 3],
    /// Components of `axes`, as plain numbers for speed.
    numbers: [[f64; 3]; 3],
    inward: Vector3<f64>,
    middle: [f64; 3],
    half: [f64; 3],
    /// Largest fall of a face below the text, mm.
    allowed_mm: f64,
    height_map: Option<HeightMap>,
}

/// Height map of a view on the coarse grid, with a summed-area table of its uneven cells.
struct HeightMap {
    count: [i64; 2],
    step: [f64; 2],
    heights: Vec<Option<f64>>,
    /// Summed-area table of uneven cells, from the lower left corner.
    uneven: Vec<u32>,
}

impl FaceView {
    /// Creates the view of a body along `-axes[2]`.
    fn new(own: &CompiledSolid, axes: [Vector3<f64>; 3], allowed_mm: f64) -> Self {
        let bounds = own.bounds();
        let (middle, size) = (bounds.centre(), bounds.size_mm());
        let half = axes.map(|axis| (0..3).map(|i| axis[i].abs() * size[i] / 2.0).sum());
        let middle = axes.map(|axis| axis.dot(&middle.coords));
        let (numbers, inward) = (axes.map(|axis| axis.into()), -axes[2]);
        Self { axes, numbers, inward, middle, half, allowed_mm, height_map: None }
    }

    /// Returns the point at given distances from the middle of the face and at a height.
    ///
    /// Written out by components: this crate is built without optimization, where sums of vectors cost dozens of calls,
    /// and thousands of rays are cast for each part.
    fn point(&self, [u, v]: [f64; 2], height: f64) -> Point3<f64> {
        let (u, v) = (self.middle[0] + u, self.middle[1] + v);
        let [[ux, uy, uz], [vx, vy, vz], [nx, ny, nz]] = self.numbers;
        Point3::new(
            u * ux + v * vx + height * nx,
            u * uy + v * vy + height * ny,
            u * uz + v * vz + height * nz,
        )
    }

    /// Returns the height of the bounding box's top, mm.
    fn top_mm(&self) -> f64 {
        self.middle[2] + self.half[2]
    }

    /// Casts a ray towards the face. Returns the height at which it enters the body and the length of its first stretch
    /// inside, mm.
    fn cast_ray(
        &self,
        own: &CompiledSolid,
        at: [f64; 2],
        buffers: &mut Buffers,
    ) -> Option<[f64; 2]> {
        // The ray starts outside the body.
        let above = self.top_mm() + 1.0;
        let ray = Ray { origin: self.point(at, above), direction: self.inward };
        own.stretches_into(&ray, &mut buffers.0, &mut buffers.1);
        let [enter, exit] = *buffers.1.first()?;
        Some([above - enter, exit - enter])
    }

    /// Samples the heights of the face on the coarse grid.
    fn sample_heights(&mut self, own: &CompiledSolid) {
        let step = [0, 1].map(|i| (2.0 * self.half[i] / LINES.0).max(LINES.1));
        let count = [0, 1].map(|i| (self.half[i] / step[i]).floor() as i64);
        let buffers = &mut Buffers::default();
        let mut heights = Vec::new();
        for j in -count[1]..=count[1] {
            for i in -count[0]..=count[0] {
                let met = self.cast_ray(own, [i as f64 * step[0], j as f64 * step[1]], buffers);
                heights.push(met.map(|[height, _]| height));
            }
        }
        let [width, rows] = count.map(|count| (2 * count + 1) as usize);
        let is_even = |a: usize, b: usize| match (heights[a], heights[b]) {
            (Some(a), Some(b)) => (a - b).abs() < FLAT_MM + self.allowed_mm / 2.0,
            _ => false,
        };
        let mut uneven = vec![0; (width + 1) * (rows + 1)];
        for j in 0..rows {
            for i in 0..width {
                let at = j * width + i;
                let beside = i > 0 && !is_even(at, at - 1);
                let below = j > 0 && !is_even(at, at - width);
                let own = u32::from(beside || below || heights[at].is_none());
                let sum = |i: usize, j: usize| uneven[j * (width + 1) + i];
                uneven[(j + 1) * (width + 1) + i + 1] =
                    own + sum(i, j + 1) + sum(i + 1, j) - sum(i, j);
            }
        }
        self.height_map = Some(HeightMap { count, step, heights, uneven });
    }
}

/// Buffers that ray casts reuse.
type Buffers = (Scratch, Vec<[f64; 2]>);

impl HeightMap {
    /// Returns the centres and heights of even rectangles with the given half edges, nearest to the middle of the face
    /// first.
    fn even_places(&self, need: [f64; 2]) -> Vec<([f64; 2], f64)> {
        let [width, _] = self.count.map(|count| (2 * count + 1) as usize);
        let reach = [0, 1].map(|i| (need[i] / self.step[i]).floor() as i64);
        let sum = |i: i64, j: i64| self.uneven[j as usize * (width + 1) + i as usize];
        let mut places = Vec::new();
        for j in reach[1]..=2 * self.count[1] - reach[1] {
            for i in reach[0]..=2 * self.count[0] - reach[0] {
                let [low, high] = [[i - reach[0], j - reach[1]], [i + reach[0], j + reach[1]]];
                // Counts steps between the rectangle's own columns and rows only: those at its left and lower edges
                // lead out of it.
                let [from, to] = [[low[0] + 1, low[1] + 1], [high[0] + 1, high[1] + 1]];
                let inside = sum(to[0], to[1]) + sum(from[0].min(to[0]), from[1].min(to[1]))
                    - sum(from[0].min(to[0]), to[1])
                    - sum(to[0], from[1].min(to[1]));
                let Some(height) = self.heights[j as usize * width + i as usize] else { continue };
                if inside == 0 {
                    let at = [
                        (i - self.count[0]) as f64 * self.step[0],
                        (j - self.count[1]) as f64 * self.step[1],
                    ];
                    places.push((at, height));
                }
            }
        }
        places.sort_by(|(a, _), (b, _)| a[0].hypot(a[1]).total_cmp(&b[0].hypot(b[1])));
        places
    }
}

impl<'a> FaceSearch<'a> {
    /// Prepares the search; `sunken_mm` is the depth of sunken letters.
    pub(super) fn new(
        body: &'a Body,
        own: &'a CompiledSolid,
        sensor: &'a Sensor,
        compiled: &'a [Option<CompiledSolid>],
        sunken_mm: Option<f64>,
    ) -> Self {
        let bed = body.bed_from_body.inverse();
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        // The upper face first, then the sides; the face on the bed only if the letters are cut in.
        let mut normals = vec![(z, y, 0.0)];
        normals.extend([-y, x, y, -x].map(|normal| (normal, z, CURVED_MM)));
        if sunken_mm.is_some() {
            normals.push((-z, y, 0.0));
        }
        let views = normals.into_iter().map(|(normal, up, allowed_mm)| {
            let axes = [up.cross(&normal), up, normal].map(|axis| bed.vector(axis));
            FaceView::new(own, axes, allowed_mm)
        });
        Self { body, own, sensor, compiled, sunken_mm, views: views.collect() }
    }

    /// Finds the first face that has room for a text of this width and height, mm, along either of its edges.
    pub(super) fn find(&mut self, size: [f64; 2]) -> Option<LabelPlace> {
        // Shallow faces first, then deep ones; round walls with their smaller margin last.
        let passes = [(MARGIN_MM, true), (MARGIN_MM, false), (ROUND_MARGIN_MM, true)];
        passes.into_iter().find_map(|(margin_mm, is_shallow)| {
            let is_round = margin_mm < MARGIN_MM;
            let tried = |view: &FaceView| !is_round || view.allowed_mm > 0.0;
            let views: Vec<usize> =
                (0..self.views.len()).filter(|i| tried(&self.views[*i])).collect();
            let mut found = views.into_iter().filter_map(|view| {
                self.find_on_face(view, size.map(|mm| mm / 2.0 + margin_mm), is_shallow)
            });
            found.find(|found| !is_round || found.fall_mm > ROUND_MM)
        })
    }

    /// Finds a place for a rectangle of these half edges on one face, near its middle.
    fn find_on_face(
        &mut self,
        view: usize,
        need: [f64; 2],
        is_shallow: bool,
    ) -> Option<LabelPlace> {
        let turned = [need[1], need[0]];
        let fits = |need: [f64; 2], half: [f64; 3]| (0..2).all(|i| need[i] <= half[i]);
        let half = self.views[view].half;
        if !fits(need, half) && !fits(turned, half) {
            return None;
        }
        let own = self.own;
        let looked = &mut self.views[view];
        if looked.height_map.is_none() {
            looked.sample_heights(own);
        }
        let view = &self.views[view];
        let seen = view.height_map.as_ref()?;
        for (need, is_turned) in [(need, false), (turned, true)] {
            let places = seen
                .even_places(need)
                .into_iter()
                .filter(|(_, height)| (view.top_mm() - height <= SHALLOW_MM) == is_shallow);
            let found = places.take(MOST_PLACES).find_map(|(at, _)| {
                let [low, high] = self.height_range(view, at, need)?;
                self.is_free(view, at, [low, high], need).then_some((at, low, high))
            });
            let Some((at, low, high)) = found else { continue };
            let [u, v, n] = view.axes;
            let axes = if is_turned { [v, -u, n] } else { [u, v, n] };
            let pose = Pose::with_axes(axes, view.point(at, high))?;
            // Rounding errors are no fall.
            let fall_mm = if high - low < 2.0 * FLAT_MM { 0.0 } else { high - low };
            return Some(LabelPlace { pose, fall_mm });
        }
        None
    }

    /// Returns the lowest and the highest point of the face below text and margin, if it is even there and thick enough
    /// behind.
    fn height_range(&self, view: &FaceView, at: [f64; 2], need: [f64; 2]) -> Option<[f64; 2]> {
        let buffers = &mut Buffers::default();
        let (mut low, mut high, mut back) = (f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY);
        for at in grid(at, need, FINE_MM) {
            let [height, run] = view.cast_ray(self.own, at, buffers)?;
            (low, high) = (low.min(height), high.max(height));
            back = back.max(height - run);
            if high - low > FLAT_MM + view.allowed_mm {
                return None;
            }
        }
        let behind = low - self.sunken_mm.unwrap_or(0.0) - back;
        (behind >= BEHIND_MM).then_some([low, high])
    }

    /// Returns whether the place is free: no other body of an assembly with this part covers it, it is not beside the
    /// touched surface, and no camera looks through it.
    fn is_free(
        &self,
        view: &FaceView,
        at: [f64; 2],
        [low, high]: [f64; 2],
        need: [f64; 2],
    ) -> bool {
        // Just above the face, and up to the free height.
        let heights = [low + 0.01, low + BEFORE_MM / 2.0, high + BEFORE_MM];
        let points: Vec<Point3<f64>> = grid(at, need, 1.0)
            .flat_map(|at| heights.map(|height| view.point(at, height)))
            .collect();
        self.body.placements.iter().all(|own| {
            let placed: Vec<Point3<f64>> =
                points.iter().map(|point| own.assembly_from_body.point(*point)).collect();
            let is_in_use = own.assembly.0 == "sensor";
            let is_felt = self.sensor.touch.is_some() && placed.iter().any(|point| point.z > -0.05);
            if is_in_use && (is_felt || self.body.clarity() != OpticalClarity::Opaque) {
                return false;
            }
            let others = self.sensor.bodies.iter().zip(self.compiled);
            others.filter(|(other, _)| other.name != self.body.name).all(|(other, solid)| {
                let places = other.placements.iter().filter(|p| p.assembly == own.assembly);
                places.into_iter().all(|place| {
                    let Some(solid) = solid else { return true };
                    let other_from_assembly = place.assembly_from_body.inverse();
                    placed.iter().all(|point| {
                        let point = other_from_assembly.point(*point);
                        !(solid.bounds().contains(&point) && solid.contains(&point))
                    })
                })
            })
        })
    }
}

/// Returns points that cover a rectangle of these half edges around `at`, at most `step` mm apart.
fn grid(at: [f64; 2], half: [f64; 2], step: f64) -> impl Iterator<Item = [f64; 2]> {
    let count = half.map(|half| (2.0 * half / step).ceil() as u32);
    let place = move |axis: usize, i: u32| {
        at[axis] + half[axis] * (2.0 * f64::from(i) / f64::from(count[axis]) - 1.0)
    };
    (0..=count[1]).flat_map(move |j| (0..=count[0]).map(move |i| [place(0, i), place(1, j)]))
}
