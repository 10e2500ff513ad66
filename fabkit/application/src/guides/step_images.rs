//! Images of a build step: incoming or outgoing pieces with arrows, and the state afterwards.

use std::collections::BTreeMap;

use fabkit_checks::{Movement, PlacedBody, Stage};
use fabkit_depth::{Actor, RenderError, View, render};
use fabkit_geometry::{Aabb, Action, CompiledSolid, Point3, Pose, Sensor, Solid, Vector3};

use crate::images::{DrawingError, compile_body, encode_png, upright_rotation};

/// Width and height of a step's image, px.
const STEP_PX: [u32; 2] = [340, 255];

/// Gap between a moving piece and its place, relative to the size of the whole scene.
const GAP_SHARE: f64 = 0.22;

/// Radius of an arrow's shaft, radius of its head, and length of the head, relative to the arrow's length.
const ARROW_SHARES: [f64; 3] = [0.055, 0.14, 0.35];

const ARROW_COLOR: [u8; 3] = [192, 57, 43];

/// Scene of a step's image.
pub(super) struct Scene {
    /// Key that is equal for scenes with the same image.
    pub(super) key: String,
    actors: Vec<Actor>,
    is_cut: bool,
    is_from_below: bool,
}

impl Scene {
    /// Draws the scene as PNG.
    pub(super) fn draw(&self) -> Result<Vec<u8>, DrawingError> {
        let [width, height] = STEP_PX;
        let cut = View::section(width, height, Point3::origin(), -Vector3::y());
        let whole = if self.is_from_below {
            View::from_side(-50.0, -24.0, width, height)
        } else {
            View::isometric(width, height)
        };
        let image = match render(&self.actors, if self.is_cut { &cut } else { &whole }) {
            // All bodies may lie in front of the section plane; then they are drawn whole.
            Err(RenderError::NothingToDraw) if self.is_cut => render(&self.actors, &whole),
            other => other,
        };
        encode_png(&image?)
    }
}

/// All bodies of a sensor, compiled once.
pub(super) struct CompiledBodies<'a> {
    sensor: &'a Sensor,
    solids: BTreeMap<&'a str, CompiledSolid>,
}

/// Body at its place, shifted for display.
#[derive(Clone, Copy)]
struct ShiftedBody<'a> {
    stand: PlacedBody<'a>,
    shift: Vector3<f64>,
}

impl<'a> CompiledBodies<'a> {
    pub(super) fn new(sensor: &'a Sensor, stages: &[Stage<'a>]) -> Result<Self, DrawingError> {
        let all = stages.iter().flat_map(|stage| stage.before.iter().chain(&stage.after));
        let mut solids = BTreeMap::new();
        for stand in all {
            if !solids.contains_key(stand.body.name.as_str()) {
                solids.insert(stand.body.name.as_str(), compile_body(stand.body)?);
            }
        }
        Ok(Self { sensor, solids })
    }

    /// Makes the scenes of a step: before it, with the moving pieces apart, and after it.
    pub(super) fn scenes(&self, stage: &Stage<'a>) -> [Option<Scene>; 2] {
        let action = &self.sensor.chain[stage.step].action;
        // Molds are cut open to show their inside; assemblies are seen from outside.
        let is_cut = matches!(action, Action::Pour(_) | Action::Spray(_) | Action::Demold(_));
        let before = if stage.going.is_empty() {
            self.movement_scene(stage, &stage.before, &stage.coming, false, is_cut)
        } else {
            // Pieces leave in the given order; reversed, so that the first one to leave ends up outermost.
            let leaving: Vec<Movement> = stage.going.iter().rev().cloned().collect();
            self.movement_scene(stage, &stage.after, &leaving, true, is_cut)
        };
        let after =
            stage.after.iter().map(|stand| ShiftedBody { stand: *stand, shift: Vector3::zeros() });
        [before, self.build_scene(stage, after.collect(), Vec::new(), [true, false])]
    }

    fn movement_scene(
        &self,
        stage: &Stage<'a>,
        standing: &[PlacedBody<'a>],
        moving: &[Movement<'a>],
        is_leaving: bool,
        is_cut: bool,
    ) -> Option<Scene> {
        let here = |stand: &PlacedBody<'a>| ShiftedBody { stand: *stand, shift: Vector3::zeros() };
        let mut sets: Vec<ShiftedBody> = standing.iter().map(here).collect();
        let all = standing.iter().chain(moving.iter().flat_map(|came| &came.bodies));
        let hull = all.fold(Aabb::nothing(), |hull, stand| hull.hull(&self.bounds(&here(stand))));
        if hull.is_empty() {
            return None;
        }
        let assembly = self.sensor.chain[stage.step].assembly.as_ref()?;
        let upright = upright_rotation(self.sensor, &assembly.0);
        let gap_mm = GAP_SHARE * (hull.max - hull.min).norm();
        let mut arrows = Vec::new();
        self.spread_pieces(&mut sets, moving, gap_mm, is_leaving, &mut arrows);
        let outs = arrows.iter().map(|arrow| upright.vector(arrow.out).z);
        let is_from_below = outs.clone().count() > 0 && outs.sum::<f64>() < 0.0;
        self.build_scene(stage, sets, arrows, [is_cut, is_from_below])
    }

    /// Places moving pieces away from the standing ones, each beyond those before it. Pieces that are assembled outside
    /// are spread there first.
    fn spread_pieces(
        &self,
        sets: &mut Vec<ShiftedBody<'a>>,
        moving: &[Movement<'a>],
        gap_mm: f64,
        is_leaving: bool,
        arrows: &mut Vec<Arrow>,
    ) {
        for came in moving {
            let (mut piece, mut inner) = (Vec::new(), Vec::new());
            if came.parts.is_empty() {
                let here =
                    |stand: &PlacedBody<'a>| ShiftedBody { stand: *stand, shift: Vector3::zeros() };
                piece.extend(came.bodies.iter().map(here));
            } else {
                // The members of a sub-assembly are spread by half the gap, so that they still appear as a group.
                self.spread_pieces(&mut piece, &came.parts, gap_mm / 2.0, is_leaving, &mut inner);
            }
            let mut shift = Vector3::zeros();
            if let Some(out) = came.removal_direction {
                let bounds =
                    piece.iter().fold(Aabb::nothing(), |hull, set| hull.hull(&self.bounds(set)));
                let way_mm = self.clearance_mm(&bounds, &out, sets) + gap_mm;
                shift = way_mm * out;
                arrows.push(Arrow::in_gap(&bounds, &out, way_mm, gap_mm, is_leaving));
            }
            let moved = |set: ShiftedBody<'a>| ShiftedBody { shift: set.shift + shift, ..set };
            sets.extend(piece.into_iter().map(moved));
            arrows
                .extend(inner.into_iter().map(|arrow| Arrow { tail: arrow.tail + shift, ..arrow }));
        }
    }

    /// Computes how far a piece must move along `out` to clear everything ahead of it, mm. Bodies that do not overlap
    /// it seen along `out` do not block it.
    fn clearance_mm(&self, piece: &Aabb, out: &Vector3<f64>, sets: &[ShiftedBody]) -> f64 {
        // A helper axis that is not nearly parallel to `out`, for two directions across it.
        let aside = if out.z.abs() < 0.9 { Vector3::z() } else { Vector3::x() };
        let u = out.cross(&aside).normalize();
        let across = [u, out.cross(&u)];
        let shadow = |bounds: &Aabb, w: &Vector3<f64>| {
            let half = 0.5 * w.abs().dot(&(bounds.max - bounds.min));
            let middle = w.dot(&bounds.centre().coords);
            [middle - half, middle + half]
        };
        let back = shadow(piece, out)[0];
        let ahead = sets.iter().map(|set| self.bounds(set)).filter(|other| {
            across.iter().all(|w| {
                let ([a, b], [c, d]) = (shadow(piece, w), shadow(other, w));
                a.max(c) < b.min(d)
            })
        });
        ahead.map(|other| shadow(&other, out)[1] - back).fold(0.0, f64::max)
    }

    fn bounds(&self, set: &ShiftedBody) -> Aabb {
        let (bounds, pose) =
            (self.solids[set.stand.body.name.as_str()].bounds(), set.stand.assembly_from_body);
        // Axis-aligned bounds of a rotated box: absolute rotation times the half sides.
        let half = pose.rotation().abs() * (0.5 * (bounds.max - bounds.min));
        let centre = pose.point(bounds.centre()) + set.shift;
        Aabb { min: centre - half, max: centre + half }
    }

    fn build_scene(
        &self,
        stage: &Stage,
        sets: Vec<ShiftedBody>,
        arrows: Vec<Arrow>,
        [is_cut, is_from_below]: [bool; 2],
    ) -> Option<Scene> {
        if sets.is_empty() {
            return None;
        }
        let assembly = self.sensor.chain[stage.step].assembly.as_ref()?;
        let upright = upright_rotation(self.sensor, &assembly.0);
        let mut key = format!("{is_cut} {is_from_below}");
        let mut actors = Vec::new();
        for ShiftedBody { stand, shift } in sets {
            let moved = Pose::translation(shift.x, shift.y, shift.z);
            let pose = upright.then_in(moved.then_in(stand.assembly_from_body));
            key += &format!("|{} {:?}", stand.body.name, pose);
            actors.push(Actor {
                body: self.solids[stand.body.name.as_str()].clone(),
                scene_from_body: pose,
                color: stand.body.color,
                opacity: stand.body.opacity,
            });
        }
        for arrow in arrows {
            let (solid, pose) = arrow.placed(&upright, is_cut)?;
            key += &format!("|arrow {pose:?}");
            actors.push(Actor::new(solid, ARROW_COLOR).placed(pose));
        }
        Some(Scene { key, actors, is_cut, is_from_below })
    }
}

/// Arrow in the assembly's frame.
struct Arrow {
    /// Direction from the piece's place outwards.
    out: Vector3<f64>,
    tail: Point3<f64>,
    along: Vector3<f64>,
    length_mm: f64,
}

impl Arrow {
    /// Places an arrow in the gap behind a piece that was moved away from its place.
    fn in_gap(
        piece: &Aabb,
        out: &Vector3<f64>,
        way_mm: f64,
        gap_mm: f64,
        is_leaving: bool,
    ) -> Self {
        let half = 0.5 * out.abs().dot(&(piece.max - piece.min));
        let near = piece.centre() + out * (way_mm - half);
        // The arrow occupies the gap from 10 % to 90 %.
        let at = |share: f64| near - out * (share * gap_mm);
        let (tail, along) = if is_leaving { (at(0.9), *out) } else { (at(0.1), -out) };
        Self { out: *out, tail, along, length_mm: 0.8 * gap_mm }
    }

    /// Returns the arrow's solid and its pose in the scene.
    fn placed(&self, upright: &Pose, is_cut: bool) -> Option<(CompiledSolid, Pose)> {
        let [shaft, head, tip] = ARROW_SHARES.map(|share| share * self.length_mm);
        let neck = self.length_mm - tip;
        let solid = Solid::cylinder(shaft, neck).plus(Solid::cone(head, 0.0, tip).at_z(neck));
        let (mut tail, along) = (upright.point(self.tail), upright.vector(self.along));
        // A section would cut the arrow in half, so it is moved behind the plane.
        if is_cut && tail.y.abs() < head && along.y.abs() < 0.5 {
            tail.y = 1.05 * head;
        }
        Some((CompiledSolid::new(&solid).ok()?, Pose::z_to(along, tail)))
    }
}
