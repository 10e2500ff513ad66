//! Restriction of one primitive to a box, as sides of surfaces.

use nalgebra::{Vector2, Vector3};

use super::super::region::{Edge, Ellipse, Region};
use super::super::shape::Primitive;
use super::plane::{Rectangle, RegionPart};
use super::surface::{Families, Literal, LocalSurface};
use super::{Cell, SLACK_MM, SideFormula};
use crate::{Cuboid, PlacedPrimitive, Pose};

/// Surfaces of one primitive, created on demand.
#[derive(Clone, Debug, Default)]
pub(super) struct Faces {
    /// Surface of each face, by the primitive's own face numbers.
    faces: Vec<Option<Literal>>,
    /// Separating surface at the end of each edge, where it continues smoothly into the next edge.
    seams: Vec<Option<Literal>>,
    whole: Option<Literal>,
}

/// Smallest and largest value of a function within a box.
type Range = [f64; 2];

/// One primitive with its cached surfaces and the surface families of all bodies.
pub(super) struct Leaf<'a, 'b> {
    pub(super) primitive: &'a Primitive,
    pub(super) leaf: &'a PlacedPrimitive,
    pub(super) faces: &'b mut Faces,
    pub(super) families: &'b mut Families<'a>,
}

/// Position of a box relative to a convex primitive: outside, or within all faces but those listed.
enum Convex {
    Outside,
    Within(Vec<u32>),
}

/// Returns the faces that cross the box. The solid lies where the function of every face is negative.
fn classify_convex(ranges: impl IntoIterator<Item = (u32, Range)>) -> Convex {
    let mut left = Vec::new();
    for (face, [low, high]) in ranges {
        if low >= -SLACK_MM {
            return Convex::Outside;
        }
        if high > SLACK_MM {
            left.push(face);
        }
    }
    Convex::Within(left)
}

/// Range of the distance from the origin over a box with this centre and these half edges.
fn length(centre: &[f64], half: &[f64]) -> Range {
    let sum = |of: fn(f64, f64) -> f64| {
        let squares = centre.iter().zip(half).map(|(c, h)| of(*c, *h).powi(2));
        squares.sum::<f64>().sqrt()
    };
    [sum(|c, h| (c.abs() - h).max(0.0)), sum(|c, h| c.abs() + h)]
}

fn subtract_level(range: Range, level: f64) -> Range {
    [range[0] - level, range[1] - level]
}

/// Part of a profile's walls that lies in a box, with its surfaces.
enum Walls {
    Nothing,
    Everything,
    Behind(Literal),
    Corner { walls: [Literal; 2], both: bool },
    Seam { seam: Literal, walls: [Literal; 2] },
    Unknown(Literal),
}

/// Part of a primitive that lies in a box: behind all of `caps` and within `walls`.
pub(super) struct Local {
    caps: Vec<Literal>,
    walls: Walls,
}

impl Local {
    const NOTHING: Self = Self { caps: Vec::new(), walls: Walls::Nothing };

    /// Returns a formula for the points of the box inside (or outside) the primitive.
    pub(super) fn sides(&self, inside: bool) -> SideFormula {
        let walls = match &self.walls {
            Walls::Nothing => return SideFormula::empty(inside),
            Walls::Everything => SideFormula::empty(!inside),
            Walls::Behind(wall) | Walls::Unknown(wall) => SideFormula::behind(&[*wall], inside),
            Walls::Corner { walls, both: true } => SideFormula::behind(walls, inside),
            // By De Morgan: behind either wall is the complement of beyond both.
            Walls::Corner { walls, both: false } => {
                SideFormula::behind(&walls.map(Literal::negated), !inside)
            }
            Walls::Seam { seam, walls: [before, after] } => {
                let side = |l: &Literal| if inside { *l } else { l.negated() };
                let before = SideFormula::behind(&[*seam, side(before)], true);
                before.join(SideFormula::behind(&[seam.negated(), side(after)], true))
            }
        };
        let caps = SideFormula::behind(&self.caps, inside);
        if inside { caps.meet(&walls) } else { caps.join(walls) }
    }

    /// Returns every face that crosses the box, with the solid's side of it; `None` if the faces are not known
    /// individually.
    pub(super) fn faces(&self) -> Option<impl Iterator<Item = &Literal>> {
        let walls = match &self.walls {
            Walls::Nothing | Walls::Everything => &[],
            Walls::Behind(wall) => std::slice::from_ref(wall),
            Walls::Corner { walls, .. } | Walls::Seam { walls, .. } => walls.as_slice(),
            Walls::Unknown(_) => return None,
        };
        Some(self.caps.iter().chain(walls))
    }

    pub(super) fn is_nothing(&self) -> bool {
        matches!(self.walls, Walls::Nothing)
    }
}

impl<'a> Leaf<'a, '_> {
    /// Returns the part of the primitive that lies in a box, given in the frame of the body.
    pub(super) fn local(&mut self, cell: &Cell) -> Local {
        let pose = &self.leaf.body_from_leaf;
        let leaf_from_body = pose.inverse();
        let c = leaf_from_body.point(cell.centre).coords;
        // Half edges of the box that encloses the rotated cell in the frame of the primitive.
        let h = leaf_from_body.rotation().abs() * cell.half;
        let along = |i: usize| [c[i] - h[i], c[i] + h[i]];
        let across = length(&[c.x, c.y], &[h.x, h.y]);
        let z = along(2);
        // Functions of the bottom (-z) and the top (z - height); the solid is where both are negative.
        let ends = |height_mm: f64| [(1, [-z[1], -z[0]]), (2, subtract_level(z, height_mm))];
        let simple = match self.primitive {
            Primitive::Sphere(s) => classify_convex([(
                0,
                subtract_level(length(c.as_slice(), h.as_slice()), s.radius_mm),
            )]),
            Primitive::Ellipsoid(s) => {
                let scaled = |v: Vector3<f64>| v.component_div(&Vector3::from(s.semi_axes_mm));
                let range = length(scaled(c).as_slice(), scaled(h).as_slice());
                // Scaled by the smallest semi-axis, the function never exceeds the distance in mm.
                let least = s.semi_axes_mm.into_iter().fold(f64::INFINITY, f64::min);
                classify_convex([(0, subtract_level(range, 1.0).map(|v| v * least))])
            }
            Primitive::Cylinder(s) => classify_convex(
                std::iter::once((0, subtract_level(across, s.radius_mm))).chain(ends(s.height_mm)),
            ),
            Primitive::Cone(s) => {
                // Radius minus the cone's radius at that height; an upper bound of the distance, which suffices for
                // signs.
                let slope = (s.top_radius_mm - s.bottom_radius_mm) / s.height_mm;
                let grown = z.map(|z| slope * z);
                let low = across[0] - grown[0].max(grown[1]) - s.bottom_radius_mm;
                let high = across[1] - grown[0].min(grown[1]) - s.bottom_radius_mm;
                classify_convex(std::iter::once((0, [low, high])).chain(ends(s.height_mm)))
            }
            Primitive::Cuboid(s) => {
                let [x, y] = [0, 1].map(|i| 0.5 * s.size_mm[i]);
                let pair = |i: usize, half_mm: f64| {
                    let [low, high] = along(i);
                    let face = 2 * i as u32;
                    [
                        (face, subtract_level([-high, -low], half_mm)),
                        (face + 1, subtract_level([low, high], half_mm)),
                    ]
                };
                let upright = [(4, [-z[1], -z[0]]), (5, subtract_level(z, s.size_mm[2]))];
                classify_convex(pair(0, x).into_iter().chain(pair(1, y)).chain(upright))
            }
            Primitive::HalfSpace(_) => classify_convex([(0, z)]),
            Primitive::Torus(s) => {
                let range = length(
                    &[0.5 * (across[0] + across[1]) - s.ring_radius_mm, c.z],
                    &[0.5 * (across[1] - across[0]), h.z],
                );
                classify_convex([(0, subtract_level(range, s.tube_radius_mm))])
            }
            Primitive::EllipsoidOffset(s) => {
                // A signed distance changes by no more than the distance moved.
                let (distance, way) = (s.distance(&c).0, h.norm());
                classify_convex([(0, [distance - way, distance + way])])
            }
            Primitive::Extrusion(prism) => {
                let rectangle = Rectangle {
                    min: Vector2::new(c.x - h.x, c.y - h.y),
                    max: Vector2::new(c.x + h.x, c.y + h.y),
                };
                let (region, height_mm) = prism.parts();
                let caps =
                    match classify_convex([(0, [-z[1], -z[0]]), (1, subtract_level(z, height_mm))])
                    {
                        Convex::Outside => return Local::NOTHING,
                        Convex::Within(faces) => faces,
                    };
                let part = region.part_in(&rectangle, |_| false);
                let caps = caps.into_iter().map(|face| self.face(face)).collect();
                return Local { caps, walls: self.walls(region, part, 2) };
            }
            Primitive::Revolution(spun) => {
                let rectangle = Rectangle {
                    min: Vector2::new(across[0], z[0]),
                    max: Vector2::new(across[1], z[1]),
                };
                let region = spun.region();
                let is_axis =
                    // Edges on the axis of revolution bound no volume.
                    |edge: &Edge| edge.ellipse.is_none() && edge.from.x == 0.0 && edge.to.x == 0.0;
                let part = region.part_in(&rectangle, is_axis);
                return Local { caps: Vec::new(), walls: self.walls(region, part, 0) };
            }
        };
        match simple {
            Convex::Outside => Local::NOTHING,
            Convex::Within(faces) => Local {
                caps: faces.into_iter().map(|face| self.face(face)).collect(),
                walls: Walls::Everything,
            },
        }
    }

    /// Converts a part of a profile to walls; `first` is the face number of the profile's first edge.
    fn walls(&mut self, region: &Region, part: RegionPart, first: u32) -> Walls {
        let mut wall = |edge: usize| self.face(first + edge as u32);
        match part {
            RegionPart::Nothing => Walls::Nothing,
            RegionPart::Everything => Walls::Everything,
            RegionPart::Behind(edge) => Walls::Behind(wall(edge)),
            RegionPart::Corner { edges, both } => Walls::Corner { walls: edges.map(wall), both },
            RegionPart::Seam(edges) => {
                let walls = edges.map(&mut wall);
                Walls::Seam { seam: self.seam(region, edges[0]), walls }
            }
            RegionPart::Unknown => Walls::Unknown(self.whole()),
        }
    }

    fn whole(&mut self) -> Literal {
        // One surface stands for the whole primitive where its faces cannot be told apart.
        let known = self.faces.whole;
        known.unwrap_or_else(|| {
            let literal = self.families.literal(LocalSurface::primitive(self.leaf));
            self.faces.whole = Some(literal);
            literal
        })
    }

    fn seam(&mut self, region: &Region, edge: usize) -> Literal {
        self.faces.seams.resize(region.edges.len(), None);
        if let Some(literal) = self.faces.seams[edge] {
            return literal;
        }
        let Edge { to, .. } = region.edges[edge];
        let direction = region.edges[edge].direction_at_end();
        let pose = &self.leaf.body_from_leaf;
        let surface = match self.primitive {
            Primitive::Revolution(_) => LocalSurface::swept(pose, to, direction),
            _ => LocalSurface::plane(pose, to.push(0.0), direction.push(0.0)),
        };
        let literal = self.families.literal(surface);
        self.faces.seams[edge] = Some(literal);
        literal
    }

    fn face(&mut self, face: u32) -> Literal {
        // Most faces are never needed, so the list grows on demand.
        let index = face as usize;
        if self.faces.faces.len() <= index {
            self.faces.faces.resize(index + 1, None);
        }
        if let Some(literal) = self.faces.faces[index] {
            return literal;
        }
        let surface = surface(self.primitive, self.leaf, face);
        let literal = match surface {
            Some(surface) => self.families.literal(surface),
            None => self.whole(),
        };
        self.faces.faces[index] = Some(literal);
        literal
    }
}

/// Returns the surface of a face; `None` where only the primitive itself describes it.
fn surface<'a>(
    primitive: &Primitive,
    leaf: &PlacedPrimitive,
    face: u32,
) -> Option<LocalSurface<'a>> {
    let pose = &leaf.body_from_leaf;
    let cap = |height_mm: f64, top: bool| {
        let outward = if top { Vector3::z() } else { -Vector3::z() };
        Some(LocalSurface::plane(pose, Vector3::z() * height_mm, outward))
    };
    match primitive {
        Primitive::Sphere(s) => Some(LocalSurface::round(pose, 0.0, s.radius_mm, true)),
        Primitive::Ellipsoid(s) => {
            let [x, y, z] = s.semi_axes_mm;
            (x == y).then(|| LocalSurface::spheroid(pose, 0.0, [x, z], 0.0, true))
        }
        Primitive::EllipsoidOffset(s) => Some(LocalSurface::spheroid(
            pose,
            0.0,
            [s.equatorial_mm, s.polar_mm],
            s.offset_mm,
            true,
        )),
        Primitive::Cylinder(s) => match face {
            0 => Some(LocalSurface::pipe(pose, Vector2::zeros(), s.radius_mm, true)),
            1 => cap(0.0, false),
            _ => cap(s.height_mm, true),
        },
        Primitive::Cone(s) => match face {
            0 => {
                let grown = s.top_radius_mm - s.bottom_radius_mm;
                let start = Vector2::new(s.bottom_radius_mm, 0.0);
                Some(LocalSurface::swept(pose, start, Vector2::new(s.height_mm, -grown)))
            }
            1 => cap(0.0, false),
            _ => cap(s.height_mm, true),
        },
        Primitive::Cuboid(s) => Some(cuboid(pose, s, face)),
        Primitive::HalfSpace(_) => cap(0.0, true),
        Primitive::Torus(s) => {
            let centre = Vector2::new(s.ring_radius_mm, 0.0);
            Some(LocalSurface::ring(pose, centre, s.tube_radius_mm, true))
        }
        Primitive::Extrusion(prism) => {
            let (region, height_mm) = prism.parts();
            match face {
                0 => cap(0.0, false),
                1 => cap(height_mm, true),
                wall => {
                    let edge = &region.edges[wall as usize - 2];
                    match edge.ellipse {
                        None => {
                            let outward = edge.outward(edge.from).normalize();
                            Some(LocalSurface::plane(pose, edge.from.push(0.0), outward.push(0.0)))
                        }
                        Some(Ellipse { centre, half_axes }) => {
                            (half_axes.x == half_axes.y).then(|| {
                                LocalSurface::pipe(pose, centre, half_axes.x, is_convex_arc(edge))
                            })
                        }
                    }
                }
            }
        }
        Primitive::Revolution(spun) => {
            let edge = &spun.region().edges[face as usize];
            match edge.ellipse {
                None => Some(LocalSurface::swept(pose, edge.from, edge.outward(edge.from))),
                Some(Ellipse { centre, half_axes }) if centre.x == 0.0 => {
                    Some(LocalSurface::spheroid(
                        pose,
                        centre.y,
                        [half_axes.x, half_axes.y],
                        0.0,
                        is_convex_arc(edge),
                    ))
                }
                Some(Ellipse { centre, half_axes }) => (half_axes.x == half_axes.y)
                    .then(|| LocalSurface::ring(pose, centre, half_axes.x, is_convex_arc(edge))),
            }
        }
    }
}

/// Returns whether an arc is convex: its solid lies within the ellipse.
fn is_convex_arc(edge: &Edge) -> bool {
    let Some(ellipse) = &edge.ellipse else { return true };
    edge.outward(edge.from).dot(&(edge.from - ellipse.centre)) > 0.0
}

fn cuboid(pose: &Pose, cuboid: &Cuboid, face: u32) -> LocalSurface<'static> {
    let size = cuboid.size_mm;
    let axis = face as usize / 2;
    let mut outward = Vector3::zeros();
    outward[axis] = if face.is_multiple_of(2) { -1.0 } else { 1.0 };
    let reach_mm = match face {
        4 => 0.0,
        5 => size[2],
        _ => 0.5 * size[axis],
    };
    LocalSurface::plane(pose, outward * reach_mm, outward)
}
