//! A solid prepared for questions.

mod boxes;
mod compile;
mod extrusion;
mod flat;
mod local;
mod offset;
mod region;
mod revolution;
mod ring;
mod round;
mod shape;
mod span;

use nalgebra::{Point3, Vector3};

pub(crate) use self::boxes::Line;
use self::boxes::generous;
use self::compile::{CompiledLeaf, Compiler, Node};
pub(crate) use self::local::{held_boxes, meeting_boxes};
pub(crate) use self::region::{Edge, Region, path_length, signed_area};
use self::shape::{LocalRay, Work};
use self::span::SLIVER_MM;
pub(crate) use self::span::{Hit, Span};
use crate::{Aabb, InvalidSolid, Pose, Solid};

/// A line with a direction; `t` is measured in lengths of `direction`, backwards too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Point at t = 0, mm.
    pub origin: Point3<f64>,
    /// Need not be of unit length; must not be zero.
    pub direction: Vector3<f64>,
}

impl Ray {
    /// The point at a parameter, mm.
    pub fn at(&self, t: f64) -> Point3<f64> {
        self.origin + t * self.direction
    }
}

/// Where a line passes through a solid's surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Position on the ray, in lengths of its direction.
    pub t: f64,
    /// Unit normal, out of the solid. At infinity, along the ray.
    pub normal: Vector3<f64>,
    /// Whose surface: an index into [`CompiledSolid::leaves`], which is also one into [`Solid::leaves`].
    pub leaf: u32,
    /// Which face of that primitive, numbered as the primitive documents.
    pub face: u32,
    /// Into the solid; out of it otherwise.
    pub entering: bool,
}

/// A primitive of a body in its place, with the name of the innermost feature around it.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedPrimitive {
    /// Always one of the primitive variants.
    pub primitive: Solid,
    /// Maps the primitive's frame to the body's.
    pub body_from_leaf: Pose,
    /// Innermost feature name; empty where there is none.
    pub feature: String,
    /// Whether it is cut away: its surface faces the other way.
    pub is_tool: bool,
}

/// Buffers for [`CompiledSolid::crossings_into`]; one per thread, reused from ray to ray and body to body.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    spans: Vec<Span>,
    work: Work,
}

/// A validated [`Solid`], flattened for bounds, containment and ray crossings.
///
/// Lines are combined as sorted stretches inside each primitive, so that booleans are exact;
/// contacts and gaps shorter than 1e-10 mm along a line are taken for rounding.
#[derive(Clone, Debug)]
pub struct CompiledSolid {
    nodes: Vec<Node>,
    /// One generous box per node.
    boxes: Vec<Aabb>,
    compiled: Vec<CompiledLeaf>,
    leaves: Vec<PlacedPrimitive>,
    root: u32,
    bounds: Aabb,
}

impl CompiledSolid {
    /// Prepares a solid.
    ///
    /// # Errors
    /// Whatever [`Solid::validate`] finds.
    pub fn new(solid: &Solid) -> Result<Self, InvalidSolid> {
        solid.validate()?;
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
        let boxes = bounds.iter().map(generous).collect();
        Ok(Self { nodes, boxes, compiled, leaves, root, bounds: bounds[root as usize] })
    }

    /// A box around the solid: exact for primitives and unions; for intersections and differences
    /// it encloses, and may be larger. [`Aabb::nothing`] where the boxes of an intersection are
    /// apart.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// All primitives: leaf numbers are indices into this list.
    pub fn leaves(&self) -> &[PlacedPrimitive] {
        &self.leaves
    }

    /// The name of the innermost feature around a leaf; empty where there is none.
    ///
    /// # Panics
    /// If there is no such leaf.
    pub fn feature_of(&self, leaf: u32) -> &str {
        &self.leaves[leaf as usize].feature
    }

    /// Whether the point lies inside. On the surface itself the answer may be either.
    pub fn contains(&self, point: &Point3<f64>) -> bool {
        self.node_contains(self.root, point)
    }

    fn node_contains(&self, node: u32, point: &Point3<f64>) -> bool {
        match &self.nodes[node as usize] {
            Node::Leaf(leaf) => {
                let leaf = &self.compiled[*leaf as usize];
                leaf.primitive.shape().holds(&leaf.leaf_from_root.point(*point).coords)
            }
            Node::Any(children) => {
                children.find(|b| b.contains(point), |child| self.node_contains(child, point))
            }
            Node::All(children) => children.iter().all(|&child| self.node_contains(child, point)),
            Node::Minus { of, tools } => {
                self.node_contains(*of, point) && !self.node_contains(*tools, point)
            }
        }
    }

    /// All crossings along the whole line, in order, entering and leaving in turn.
    ///
    /// Each entry has its exit, so the number is even: where a solid is unbounded, the first or the
    /// last crossing is at minus or plus infinity. A direction of length zero crosses nothing.
    pub fn crossings(&self, ray: &Ray) -> Vec<Crossing> {
        let mut crossings = Vec::new();
        self.crossings_into(ray, &mut Scratch::default(), &mut crossings);
        crossings
    }

    /// The same as [`CompiledSolid::crossings`] without allocating for each ray. `crossings` is cleared.
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

    /// The stretches of a line inside, as pairs of `t`: those of [`CompiledSolid::crossings_into`] without
    /// their normals, which take as long as the rest. `stretches` is cleared.
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

    /// The first crossing beyond `after_mm` in one direction: into the solid, or out of it.
    ///
    /// The ray's direction must be of unit length, so that `t` is in mm. Cheaper than
    /// [`CompiledSolid::crossings_into`] where one crossing is enough: a single normal is computed.
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

    /// The stretches of a line inside, in order.
    pub(crate) fn spans<'a>(&self, line: &Line, scratch: &'a mut Scratch) -> &'a [Span] {
        scratch.spans.clear();
        if line.meets(&self.boxes[self.root as usize]) {
            self.cast(self.root, line, scratch);
        }
        &scratch.spans
    }

    /// Appends the stretches of the line inside a node. Its box has been tested.
    fn cast(&self, node: u32, line: &Line, scratch: &mut Scratch) {
        let from = scratch.spans.len();
        match &self.nodes[node as usize] {
            Node::Leaf(leaf) => self.cast_leaf(*leaf, line, scratch),
            Node::Any(children) => {
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
            Node::All(children) => {
                for (i, &child) in children.iter().enumerate() {
                    let middle = scratch.spans.len();
                    if line.meets(&self.boxes[child as usize]) {
                        self.cast(child, line, scratch);
                    }
                    if i > 0 {
                        span::intersect(&mut scratch.spans, from, middle);
                    }
                    if scratch.spans.len() == from {
                        break;
                    }
                }
            }
            Node::Minus { of, tools } => {
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

    /// Unit normal out of the body where the line passes a leaf's face.
    pub(crate) fn normal(&self, line: &Line, hit: &Hit, entering: bool) -> Vector3<f64> {
        if hit.t_mm.is_infinite() {
            return if entering { -line.direction } else { line.direction };
        }
        let leaf = &self.compiled[hit.leaf as usize];
        let p = leaf.leaf_from_root.point(line.origin + hit.t_mm * line.direction);
        let normal = leaf.primitive.shape().normal(hit.face, &p.coords);
        let normal = leaf.leaf_from_root.rotation().tr_mul(&normal);
        // Only a cone's apex and a revolution's pole have no normal; the axis serves there.
        let normal = normal.try_normalize(0.0).unwrap_or(-line.direction);
        if leaf.is_tool { -normal } else { normal }
    }
}
