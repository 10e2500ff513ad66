//! Text on printed parts, placed by a rule that knows nothing of families: on the first flat face that
//! has room for it, that nothing else touches and that is thick enough.

use fabkit_geometry::{
    Body, CompiledSolid, Length, Point3, Pose, Process, Ray, Sensor, Solid, Vector3,
};

use crate::blocks::label::{Label, LabelError};
use crate::parameters::{Report, shown, suggestion};
use crate::{choices, parameters};

choices! {
    /// Whether printed parts carry text.
    pub enum LabelStyle {
        /// No text.
        None = "none",
        /// It stands out.
        Raised = "raised",
        /// It is cut in.
        Sunken = "sunken",
    }
}

parameters! {
    /// Text on printed parts.
    pub struct Labels {
        /// Whether there is any, and whether it stands out or is cut in.
        style: LabelStyle,
        /// Which printed parts carry it, by name; `all` for every one that has room.
        parts: Vec<String> = (1..=100, 1..=64),
        /// What is written; if nothing, the part's name.
        text: String = 0..=40,
        /// Height of the letters.
        height: Length = 2.0..=30.0,
        /// How deep they are cut, or how far they stand out.
        depth: Length = 0.2..=2.0,
    }
}

/// The key of the section in every family's files.
pub const KEY: &str = "labels";

/// What it is for.
pub const SUMMARY: &str = "Text on printed parts.";

/// Its values where no file says anything else, for messages, and their text.
pub const DEFAULTS: (&str, &str) = ("labels.yaml (defaults)", include_str!("labels.yaml"));

/// The word for every part.
const ALL: &str = "all";

/// Flat face beside the letters, mm.
const MARGIN_MM: f64 = 1.0;

/// Material behind sunken letters, mm: two lines of a 0.4 mm nozzle.
const BEHIND_MM: f64 = 0.8;

/// What must be free before a face, mm: more than what stands out, and than what is glued on.
const BEFORE_MM: f64 = 1.0;

/// Heights that differ by less are one plane, mm.
const FLAT_MM: f64 = 1e-6;

/// Lines along an edge of a face in the first look, at most, and how far apart they are at least, mm.
const LINES: (f64, f64) = (48.0, 0.5);

/// Lines of the second look are so far apart, mm: smaller than any hole that is drilled or printed.
const FINE_MM: f64 = 0.25;

/// Places that get a second look on one face, at most.
const MOST_PLACES: usize = 40;

/// Puts text on the parts that it is asked for; says on which, or reports why not.
pub(crate) fn apply(labels: &Labels, sensor: &mut Sensor, report: &mut Report) -> Vec<String> {
    if labels.style == LabelStyle::None {
        return Vec::new();
    }
    let is_printed = |body: &Body| {
        let process =
            matches!(body.process(), Some(Process::Fdm | Process::Sla | Process::PolyJet));
        let is_grouped = sensor.print_groups.iter().any(|group| group.parts.contains(&body.name));
        body.is_made() && process && !is_grouped
    };
    let printed: Vec<String> =
        sensor.bodies.iter().filter(|body| is_printed(body)).map(|b| b.name.clone()).collect();
    let is_all = labels.parts.iter().any(|name| name == ALL);
    for name in labels.parts.iter().filter(|name| *name != ALL && !printed.contains(name)) {
        report.require(
            false,
            "labels.parts",
            || format!("labels.parts: `{}` is not a printed part", shown(name)),
            || suggestion(name, printed.iter().map(String::as_str), "the printed parts are"),
        );
    }
    let compiled: Vec<Option<CompiledSolid>> =
        sensor.bodies.iter().map(|body| CompiledSolid::new(&body.solid).ok()).collect();
    let mut written = Vec::new();
    let mut changed = Vec::new();
    for (i, body) in sensor.bodies.iter().enumerate() {
        let is_named = labels.parts.contains(&body.name);
        let Some(own) = compiled[i].as_ref() else { continue };
        if !printed.contains(&body.name) || !(is_named || is_all) {
            continue;
        }
        let text = if labels.text.trim().is_empty() { &body.name } else { &labels.text };
        let made = Label::new(text, labels.height.mm(), Pose::identity());
        let label = match made.and_then(|label| label.deep(labels.depth.mm())) {
            Ok(label) => label,
            Err(why) => {
                let (path, hint) = match why {
                    LabelError::Low(_) => ("labels.height", "write higher letters"),
                    _ => ("labels.text", "write other letters"),
                };
                report.require(false, path, || format!("{path}: {why}"), || hint.into());
                return Vec::new();
            }
        };
        let face = Face { body, own, sensor, compiled: &compiled, labels, size: label.size_mm() };
        match face.find() {
            Some(pose) => {
                written.push(body.name.clone());
                changed.push((i, label.at(pose)));
            }
            None if is_named => {
                let [width, height] = label.size_mm().map(|mm| mm + 2.0 * MARGIN_MM);
                report.require(
                    false,
                    "labels.parts",
                    || {
                        format!(
                            "labels.parts: {} has no free flat face of {width:.1} x {height:.1} mm, \
                             which `{text}` takes",
                            body.name
                        )
                    },
                    || "write a shorter `labels.text` or a smaller `labels.height`, or leave the \
                        part out"
                        .into(),
                );
            }
            None => {}
        }
    }
    report.require(
        !written.is_empty() || !is_all,
        "labels.parts",
        || "labels.parts: no printed part has a free flat face for its text".into(),
        || "write a shorter `labels.text` or a smaller `labels.height`".into(),
    );
    drop(compiled);
    for (i, label) in changed {
        let body = &mut sensor.bodies[i];
        match labels.style {
            LabelStyle::Sunken => *body = body.clone().cut(label.sunken()),
            _ => body.solid = Solid::union([body.solid.clone(), label.raised()]),
        }
    }
    written
}

/// A part that looks for a place for its text.
struct Face<'a> {
    body: &'a Body,
    own: &'a CompiledSolid,
    sensor: &'a Sensor,
    compiled: &'a [Option<CompiledSolid>],
    labels: &'a Labels,
    size: [f64; 2],
}

/// A direction that faces are looked at from, in the frame of the body: along the text, up, to the
/// reader; and the middle and half the edges of what is seen, mm.
struct View {
    axes: [Vector3<f64>; 3],
    middle: [f64; 3],
    half: [f64; 3],
}

impl View {
    fn new(own: &CompiledSolid, axes: [Vector3<f64>; 3]) -> Self {
        let bounds = own.bounds();
        let corner = |i: usize| {
            let pick = |bit: usize, low: f64, high: f64| if i >> bit & 1 == 0 { low } else { high };
            Vector3::new(
                pick(0, bounds.min.x, bounds.max.x),
                pick(1, bounds.min.y, bounds.max.y),
                pick(2, bounds.min.z, bounds.max.z),
            )
        };
        let mut limits = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
        for (axis, limits) in axes.iter().zip(&mut limits) {
            for i in 0..8 {
                let at = corner(i).dot(axis);
                *limits = [limits[0].min(at), limits[1].max(at)];
            }
        }
        let middle = limits.map(|[low, high]| (low + high) / 2.0);
        Self { axes, middle, half: limits.map(|[low, high]| (high - low) / 2.0) }
    }

    /// A place by its distances from the middle of the face and its height.
    fn point(&self, [u, v]: [f64; 2], height: f64) -> Point3<f64> {
        let at = [self.middle[0] + u, self.middle[1] + v, height];
        Point3::from(self.axes.iter().zip(at).map(|(axis, mm)| axis * mm).sum::<Vector3<f64>>())
    }

    /// Where a line towards the face enters the body, and how far it runs in it, mm.
    fn met(&self, own: &CompiledSolid, at: [f64; 2]) -> Option<[f64; 2]> {
        let above = self.middle[2] + self.half[2] + 1.0;
        let ray = Ray { origin: self.point(at, above), direction: -self.axes[2] };
        let crossings = own.crossings(&ray);
        let (first, second) = (crossings.first()?, crossings.get(1)?);
        Some([above - first.t, second.t - first.t])
    }
}

impl Face<'_> {
    /// Where the text stands: x along it, y up, z to the reader.
    fn find(&self) -> Option<Pose> {
        let bed = self.body.bed_from_body.inverse();
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        // Up first, then the sides; what lies on the bed only where letters are cut in.
        let mut normals = vec![(z, y), (-y, z), (x, z), (y, z), (-x, z)];
        if self.labels.style == LabelStyle::Sunken {
            normals.push((-z, y));
        }
        normals.into_iter().find_map(|(normal, up)| {
            let axes = [up.cross(&normal), up, normal].map(|axis| bed.vector(axis));
            let view = View::new(self.own, axes);
            self.on(&view).and_then(|(at, height)| {
                let [u, v, n] = view.axes;
                let origin = view.point(at, height);
                Pose::with_axes([u, v, n], origin)
            })
        })
    }

    /// The place on one face that is nearest to its middle, and its height.
    fn on(&self, view: &View) -> Option<([f64; 2], f64)> {
        let need = self.size.map(|mm| mm / 2.0 + MARGIN_MM);
        if (0..2).any(|i| need[i] > view.half[i]) {
            return None;
        }
        let step = [0, 1].map(|i| (2.0 * view.half[i] / LINES.0).max(LINES.1));
        let count = [0, 1].map(|i| (view.half[i] / step[i]).floor() as i64);
        let at = |i: i64, j: i64| [i as f64 * step[0], j as f64 * step[1]];
        let width = (2 * count[0] + 1) as usize;
        let heights: Vec<Option<f64>> = (-count[1]..=count[1])
            .flat_map(|j| (-count[0]..=count[0]).map(move |i| (i, j)))
            .map(|(i, j)| view.met(self.own, at(i, j)).map(|[height, _]| height))
            .collect();
        let height =
            |i: i64, j: i64| heights[(j + count[1]) as usize * width + (i + count[0]) as usize];
        let reach = [0, 1].map(|i| (need[i] / step[i]).floor() as i64);
        let mut places: Vec<(i64, i64, f64)> = Vec::new();
        for j in reach[1] - count[1]..=count[1] - reach[1] {
            for i in reach[0] - count[0]..=count[0] - reach[0] {
                let Some(plane) = height(i, j) else { continue };
                let is_flat = (j - reach[1]..=j + reach[1]).all(|b| {
                    (i - reach[0]..=i + reach[0])
                        .all(|a| height(a, b).is_some_and(|h| (h - plane).abs() < FLAT_MM))
                });
                if is_flat {
                    places.push((i, j, plane));
                }
            }
        }
        let off = |(i, j, _): &(i64, i64, f64)| at(*i, *j)[0].hypot(at(*i, *j)[1]);
        places.sort_by(|a, b| off(a).total_cmp(&off(b)));
        let places = places.into_iter().take(MOST_PLACES);
        places.map(|(i, j, plane)| (at(i, j), plane)).find(|(at, plane)| {
            self.is_whole(view, *at, *plane, need) && self.is_free(view, *at, *plane, need)
        })
    }

    /// Whether a face is flat wherever text and margin are, and thick enough behind.
    fn is_whole(&self, view: &View, at: [f64; 2], plane: f64, need: [f64; 2]) -> bool {
        let behind = match self.labels.style {
            LabelStyle::Sunken => self.labels.depth.mm() + BEHIND_MM,
            _ => BEHIND_MM,
        };
        grid(at, need, FINE_MM).all(|at| {
            view.met(self.own, at)
                .is_some_and(|[height, run]| (height - plane).abs() < FLAT_MM && run >= behind)
        })
    }

    /// Whether no other body of the assemblies that this one stands in is before a face.
    fn is_free(&self, view: &View, at: [f64; 2], plane: f64, need: [f64; 2]) -> bool {
        let heights = [0.01, BEFORE_MM / 2.0, BEFORE_MM].map(|mm| plane + mm);
        let points: Vec<Point3<f64>> = grid(at, need, 1.0)
            .flat_map(|at| heights.map(|height| view.point(at, height)))
            .collect();
        self.body.placements.iter().all(|own| {
            let others = self.sensor.bodies.iter().zip(self.compiled);
            others.filter(|(other, _)| other.name != self.body.name).all(|(other, solid)| {
                let places = other.placements.iter().filter(|p| p.assembly == own.assembly);
                places.into_iter().all(|place| {
                    let Some(solid) = solid else { return true };
                    let other_from_assembly = place.assembly_from_body.inverse();
                    points.iter().all(|point| {
                        let point = own.assembly_from_body.point(*point);
                        !solid.contains(&other_from_assembly.point(point))
                    })
                })
            })
        })
    }
}

/// Points of a rectangle of these half edges around a middle, so far apart at most, mm.
fn grid(at: [f64; 2], half: [f64; 2], step: f64) -> impl Iterator<Item = [f64; 2]> {
    let count = half.map(|half| (2.0 * half / step).ceil() as u32);
    let place = move |axis: usize, i: u32| {
        at[axis] + half[axis] * (2.0 * f64::from(i) / f64::from(count[axis]) - 1.0)
    };
    (0..=count[1]).flat_map(move |j| (0..=count[0]).map(move |i| [place(0, i), place(1, j)]))
}
