//! Solid prepared for geometric queries: bounds, containment and line crossings.

mod boxes;
mod compile;
mod extrusion;
mod flat;
mod offset;
mod region;
mod revolution;
mod ring;
mod round;
mod shape;
mod span;
mod subdivision;

use nalgebra::{Point3, Vector3};

pub(crate) use self::boxes::Line;
use self::boxes::enlarge_for_rounding;
use self::compile::{CompiledLeaf, Compiler, Node};
pub(crate) use self::region::{Edge, Region, path_length, signed_area};
use self::shape::{CastBuffers, LocalRay};
use self::span::SLIVER_MM;
pub(crate) use self::span::{Hit, Span};
pub(crate) use self::subdivision::{subdivide_for_obstacles, subdivide_for_overlap};
use crate::{Aabb, InvalidSolid, Pose, Ray, Solid};

/// Crossing of a line with a solid's surface.
///
/// ```
/// use fabkit_geometry::{CompiledSolid, Point3, Ray, Solid, Vector3};
/// let bore = Solid::rod(2.0, [-0.1, 1.1]).named("bore");
/// let washer = CompiledSolid::new(&Solid::cylinder(5.0, 1.0).minus(bore))?;
/// let ray = Ray { origin: Point3::new(0.0, 0.0, 0.5), direction: Vector3::x() };
/// let out_of_bore = washer.crossings(&ray).into_iter().find(|crossing| crossing.t > 0.0).unwrap();
/// assert_eq!((out_of_bore.t, out_of_bore.entering), (2.0, true)); // into the material
/// assert_eq!(washer.feature_of(out_of_bore.leaf), "bore");
/// assert_eq!(out_of_bore.normal, -Vector3::x()); // out of the material, towards the axis
/// # Ok::<(), fabkit_geometry::InvalidSolid>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Position on the ray, in lengths of its direction.
    pub t: f64,
    /// Unit normal that points out of the solid; along the ray for crossings at infinity.
    pub normal: Vector3<f64>,
    /// Leaf whose surface is crossed: an index into [`CompiledSolid::leaves`] and equally into [`Solid::leaves`].
    pub leaf: u32,
    /// Face of that primitive, numbered as the primitive documents.
    pub face: u32,
    /// True where the line enters the solid, false where it leaves it.
    pub entering: bool,
}

/// Primitive of a body with its pose and the name of the innermost feature around it.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedPrimitive {
    /// Primitive; always one of the primitive variants of [`Solid`].
    pub primitive: Solid,
    /// Maps the primitive's frame to the body's.
    pub body_from_leaf: Pose,
    /// Name of the innermost feature; empty if there is none.
    pub feature: String,
    /// True if the primitive is cut away, so that its surface faces the other way.
    pub is_tool: bool,
}

/// Buffers for [`CompiledSolid::crossings_into`]; one per thread, reused from ray to ray and body to body.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    spans: Vec<Span>,
    work: CastBuffers,
}

/// Validated [`Solid`], flattened for queries of bounds, containment and line crossings.
///
/// A line is reduced to sorted stretches inside each primitive and these are combined, so that booleans are exact.
/// Contacts and gaps shorter than 1e-10 mm along a line are treated as rounding.
///
/// ```
/// use fabkit_geometry::{CompiledSolid, Point3, Solid};
/// let socket = Solid::cuboid(20.0, 20.0, 8.0).minus(Solid::sphere(6.0).at_z(8.0));
/// let body = CompiledSolid::new(&socket)?;
/// assert!(body.contains(&Point3::new(0.0, 0.0, 1.9)) && !body.contains(&Point3::new(0.0, 0.0, 2.1)));
/// assert_eq!(body.bounds().size_mm(), [20.0, 20.0, 8.0]);
/// # Ok::<(), fabkit_geometry::InvalidSolid>(())
/// ```
#[derive(Clone, Debug)]
pub struct CompiledSolid {
    nodes: Vec<Node>,
    /// Slightly enlarged box of each node.
    boxes: Vec<Aabb>,
    compiled: Vec<CompiledLeaf>,
    leaves: Vec<PlacedPrimitive>,
    root: u32,
    bounds: Aabb,
}

impl CompiledSolid {
    /// Compiles a solid.
    ///
    /// # Errors
    /// Any violation that [`Solid::validate`] finds.
    pub fn new(solid: &Solid) -> Result<Self, InvalidSolid> {
        solid.validate()?;
        // The compiler adds leaves in the order of `Solid::leaves`, so both lists correspond.
        let mut compiler = Compiler::default();
        let root = compiler.add(solid, Pose::identity(), false);
        let Compiler { nodes, bounds, leaves: compiled } = compiler;
        let leaves = solid
            .leaves()
            .into_iter()
            .zip(&compiled)
            .map(|(leaf, compiled)| PlacedPrimitive {
                primitive: leaf.primitive.clone(),
                body_from_leaf: leaf.root_from_leaf,
                feature: leaf.feature.to_owned(),
                is_tool: compiled.is_tool,
            })
            .collect();
        let boxes = bounds.iter().map(enlarge_for_rounding).collect();
        Ok(Self { nodes, boxes, compiled, leaves, root, bounds: bounds[root as usize] })
    }

    /// Returns a bounding box: exact for primitives and unions, possibly too large for intersections and differences.
    /// [`Aabb::nothing`] if the boxes of an intersection's operands are apart.
    ///
    /// ```
    /// use fabkit_geometry::{CompiledSolid, Solid};
    /// let lower_half = Solid::sphere(10.0).minus(Solid::cuboid(30.0, 30.0, 30.0));
    /// // The solid ends at z = 0, its box does not.
    /// assert_eq!(CompiledSolid::new(&lower_half)?.bounds().max.z, 10.0);
    /// assert!(!CompiledSolid::new(&Solid::below(0.0))?.bounds().is_finite());
    /// # Ok::<(), fabkit_geometry::InvalidSolid>(())
    /// ```
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Returns all primitives; leaf numbers are indices into this list.
    ///
    /// ```
    /// use fabkit_geometry::{CompiledSolid, Point3, Solid};
    /// let hole = Solid::cylinder(1.0, 5.0).at(3.0, 0.0, -1.0).named("hole");
    /// let body = CompiledSolid::new(&Solid::cuboid(10.0, 10.0, 3.0).minus(hole))?;
    /// let [block, tool] = body.leaves() else { panic!("two primitives") };
    /// assert_eq!((block.is_tool, tool.is_tool, &*tool.feature), (false, true, "hole"));
    /// assert_eq!(tool.body_from_leaf.point(Point3::origin()), Point3::new(3.0, 0.0, -1.0));
    /// # Ok::<(), fabkit_geometry::InvalidSolid>(())
    /// ```
    pub fn leaves(&self) -> &[PlacedPrimitive] {
        &self.leaves
    }

    /// Returns the name of the innermost feature around a leaf; empty if there is none.
    ///
    /// # Panics
    /// If there is no such leaf.
    pub fn feature_of(&self, leaf: u32) -> &str {
        &self.leaves[leaf as usize].feature
    }

    /// Returns whether the point lies inside. On the surface itself either result is possible.
    pub fn contains(&self, point: &Point3<f64>) -> bool {
        self.node_contains(self.root, point)
    }

    fn node_contains(&self, node: u32, point: &Point3<f64>) -> bool {
        match &self.nodes[node as usize] {
            Node::Leaf(leaf) => {
                let leaf = &self.compiled[*leaf as usize];
                leaf.primitive.shape().contains(&leaf.leaf_from_root.point(*point).coords)
            }
            Node::Union(children) => {
                children.find(|b| b.contains(point), |child| self.node_contains(child, point))
            }
            Node::Intersection(children) => {
                children.iter().all(|&child| self.node_contains(child, point))
            }
            Node::Difference { of, tools } => {
                self.node_contains(*of, point) && !self.node_contains(*tools, point)
            }
        }
    }

    /// Returns all crossings along the whole line, in order, alternately entering and leaving.
    ///
    /// Each entry has its exit, so the number is even: where a solid is unbounded, the first or the last crossing is at
    /// minus or plus infinity. A direction of length zero crosses nothing.
    ///
    /// ```
    /// use fabkit_geometry::{CompiledSolid, Point3, Ray, Solid, Vector3};
    /// let table = CompiledSolid::new(&Solid::below(2.0))?;
    /// let down = Ray { origin: Point3::new(0.0, 0.0, 5.0), direction: -Vector3::z() };
    /// let depths_mm: Vec<f64> = table.crossings(&down).iter().map(|crossing| crossing.t).collect();
    /// assert_eq!(depths_mm, [3.0, f64::INFINITY]); // the half-space has no bottom
    /// # Ok::<(), fabkit_geometry::InvalidSolid>(())
    /// ```
    pub fn crossings(&self, ray: &Ray) -> Vec<Crossing> {
        let mut crossings = Vec::new();
        self.crossings_into(ray, &mut Scratch::default(), &mut crossings);
        crossings
    }

    /// Computes the same as [`CompiledSolid::crossings`] without allocating for each ray. `crossings` is cleared first.
    ///
    /// ```
    /// use fabkit_geometry::{CompiledSolid, Point3, Ray, Scratch, Solid, Vector3};
    /// let ball = CompiledSolid::new(&Solid::sphere(2.0))?;
    /// let (mut scratch, mut crossings) = (Scratch::default(), Vec::new());
    /// let ray = Ray { origin: Point3::new(0.0, 0.0, 9.0), direction: -Vector3::z() };
    /// ball.crossings_into(&ray, &mut scratch, &mut crossings);
    /// assert_eq!((crossings[0].t, crossings[1].t), (7.0, 11.0));
    /// assert_eq!(crossings[0].normal, Vector3::z());
    /// # Ok::<(), fabkit_geometry::InvalidSolid>(())
    /// ```
    pub fn crossings_into(&self, ray: &Ray, scratch: &mut Scratch, crossings: &mut Vec<Crossing>) {
        crossings.clear();
        let length = ray.direction.norm();
        if !(length > 0.0 && length.is_finite()) {
            return;
        }
        let line = Line::new(ray.origin, ray.direction / length);
        for span in self.spans(&line, scratch) {
            for (hit, entering) in [(span.enter, true), (span.exit, false)] {
                crossings.push(Crossing {
                    t: hit.t_mm / length,
                    normal: self.normal(&line, &hit, entering),
                    leaf: hit.leaf,
                    face: hit.face,
                    entering,
                });
            }
        }
    }

    /// Computes the stretches of a line inside the solid, as pairs of `t`. Skips the normals of
    /// [`CompiledSolid::crossings_into`], which take about half of the time. `stretches` is cleared first.
    ///
    /// ```
    /// use fabkit_geometry::{CompiledSolid, Point3, Ray, Scratch, Solid, Vector3};
    /// let ball = CompiledSolid::new(&Solid::sphere(2.0))?;
    /// let ray = Ray { origin: Point3::new(0.0, 0.0, 9.0), direction: -Vector3::z() };
    /// let mut stretches = Vec::new();
    /// ball.stretches_into(&ray, &mut Scratch::default(), &mut stretches);
    /// assert_eq!(stretches, [[7.0, 11.0]]);
    /// # Ok::<(), fabkit_geometry::InvalidSolid>(())
    /// ```
    pub fn stretches_into(&self, ray: &Ray, scratch: &mut Scratch, stretches: &mut Vec<[f64; 2]>) {
        stretches.clear();
        let length = ray.direction.norm();
        if !(length > 0.0 && length.is_finite()) {
            return;
        }
        let line = Line::new(ray.origin, ray.direction / length);
        let ends = |span: &Span| [span.enter.t_mm / length, span.exit.t_mm / length];
        stretches.extend(self.spans(&line, scratch).iter().map(ends));
    }

    /// Returns the first crossing beyond `after_mm` that enters the solid (or leaves it, if `entering` is false).
    ///
    /// The ray's direction must be of unit length, so that `t` is in mm. Cheaper than [`CompiledSolid::crossings_into`]
    /// where one crossing is enough: a single normal is computed.
    ///
    /// ```
    /// use fabkit_geometry::{CompiledSolid, Point3, Ray, Scratch, Solid, Vector3};
    /// let ball = CompiledSolid::new(&Solid::sphere(2.0))?;
    /// let ray = Ray { origin: Point3::origin(), direction: Vector3::z() };
    /// let exit = ball.first_crossing(&ray, 0.0, false, &mut Scratch::default());
    /// assert_eq!(exit.map(|crossing| crossing.t), Some(2.0));
    /// # Ok::<(), fabkit_geometry::InvalidSolid>(())
    /// ```
    pub fn first_crossing(
        &self,
        ray: &Ray,
        after_mm: f64,
        entering: bool,
        scratch: &mut Scratch,
    ) -> Option<Crossing> {
        let line = Line::new(ray.origin, ray.direction);
        let end = |span: &Span| if entering { span.enter } else { span.exit };
        let hit = self.spans(&line, scratch).iter().map(end).find(|hit| hit.t_mm > after_mm)?;
        Some(Crossing {
            t: hit.t_mm,
            normal: self.normal(&line, &hit, entering),
            leaf: hit.leaf,
            face: hit.face,
            entering,
        })
    }

    /// Returns the stretches of a line inside the solid, in order.
    pub(crate) fn spans<'a>(&self, line: &Line, scratch: &'a mut Scratch) -> &'a [Span] {
        scratch.spans.clear();
        if line.meets(&self.boxes[self.root as usize]) {
            self.cast(self.root, line, scratch);
        }
        &scratch.spans
    }

    /// Appends the stretches of the line inside a node whose box the line is known to meet.
    fn cast(&self, node: u32, line: &Line, scratch: &mut Scratch) {
        let from = scratch.spans.len();
        match &self.nodes[node as usize] {
            Node::Leaf(leaf) => self.cast_leaf(*leaf, line, scratch),
            Node::Union(children) => {
                // The spans of a single child are sorted already: the union is needed only if several were hit.
                let mut hit_children = 0;
                children.find(
                    |bounds| line.meets(bounds),
                    |child| {
                        let before = scratch.spans.len();
                        self.cast(child, line, scratch);
                        hit_children += usize::from(scratch.spans.len() > before);
                        false
                    },
                );
                if hit_children > 1 {
                    span::unite(&mut scratch.spans, from);
                }
            }
            Node::Intersection(children) => {
                for (i, &child) in children.iter().enumerate() {
                    let middle = scratch.spans.len();
                    if line.meets(&self.boxes[child as usize]) {
                        self.cast(child, line, scratch);
                    }
                    // The first operand has nothing to be intersected with.
                    if i > 0 {
                        span::intersect(&mut scratch.spans, from, middle);
                    }
                    if scratch.spans.len() == from {
                        break;
                    }
                }
            }
            Node::Difference { of, tools } => {
                self.cast(*of, line, scratch);
                let middle = scratch.spans.len();
                if middle > from && line.meets(&self.boxes[*tools as usize]) {
                    self.cast(*tools, line, scratch);
                    if scratch.spans.len() > middle {
                        span::subtract(&mut scratch.spans, from, middle);
                    }
                }
            }
        }
    }

    fn cast_leaf(&self, number: u32, line: &Line, scratch: &mut Scratch) {
        let leaf = &self.compiled[number as usize];
        let direction = leaf.leaf_from_root.vector(line.direction);
        let origin = leaf.leaf_from_root.point(line.origin).coords - leaf.centre;
        // The origin is moved to the foot of the perpendicular from the centre, so that distant rays keep their digits.
        let foot_mm = -origin.dot(&direction);
        let origin = origin + foot_mm * direction + leaf.centre;
        let ray = LocalRay { origin, direction, reach_mm: leaf.reach_mm };
        let Scratch { spans, work } = scratch;
        work.chords.clear();
        leaf.primitive.shape().cast(&ray, work);
        for chord in &work.chords {
            let hit = |end: usize| Hit {
                t_mm: foot_mm + chord.t_mm[end],
                leaf: number,
                face: chord.face[end],
            };
            let span = Span { enter: hit(0), exit: hit(1) };
            if span.exit.t_mm - span.enter.t_mm > SLIVER_MM {
                spans.push(span);
            }
        }
    }

    /// Returns the unit normal out of the body where the line crosses a leaf's face.
    pub(crate) fn normal(&self, line: &Line, hit: &Hit, entering: bool) -> Vector3<f64> {
        if hit.t_mm.is_infinite() {
            return if entering { -line.direction } else { line.direction };
        }
        let leaf = &self.compiled[hit.leaf as usize];
        let p = leaf.leaf_from_root.point(line.origin + hit.t_mm * line.direction);
        let normal = leaf.primitive.shape().normal(hit.face, &p.coords);
        let normal = leaf.leaf_from_root.rotation().tr_mul(&normal);
        // Only a cone's apex and a revolution's pole have no normal; the reversed line direction serves there.
        let normal = normal.try_normalize(0.0).unwrap_or(-line.direction);
        if leaf.is_tool { -normal } else { normal }
    }
}
