//! Validation of solids.

use crate::profile_validity::{self, MAX_SEGMENTS};
use crate::{Path, Profile, Segment, Solid};

/// Largest depth of a tree. The limit protects the stack, and lets every valid tree survive JSON: readers stop at 128
/// brackets, a difference takes three, a profile's points nine.
const MAX_DEPTH: usize = 36;

/// Smallest size, mm. Nothing that a lab makes is smaller than a nanometre or larger than a kilometre, and within these
/// limits no intermediate result overflows or underflows.
const MIN_SIZE_MM: f64 = 1e-6;
/// Largest size, mm.
const MAX_SIZE_MM: f64 = 1e6;

/// Relative tolerance for the distances of an arc's ends from its centre.
const ARC_TOLERANCE: f64 = 1e-9;

/// Violation of a rule by a node of a tree.
#[derive(Clone, Debug, PartialEq)]
pub struct Violation {
    /// Position in the tree, for example `difference/minus[3]/cylinder`.
    pub place: String,
    /// Description of the problem, with value and limit.
    pub problem: String,
}

/// Error of a tree that describes no solid, with all violations.
///
/// ```
/// use fabkit_geometry::Solid;
/// let plate = Solid::cuboid(10.0, 0.0, 2.0).minus(Solid::cylinder(-1.0, 4.0));
/// let violations = plate.validate().unwrap_err().violations;
/// let places: Vec<&str> = violations.iter().map(|violation| violation.place.as_str()).collect();
/// assert_eq!(places, ["difference/of/cuboid", "difference/minus[0]/cylinder"]);
/// assert!(violations[1].problem.starts_with("radius is -1 mm"));
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("not a solid: {}", list(.violations))]
pub struct InvalidSolid {
    /// Violations; at least one.
    pub violations: Vec<Violation>,
}

fn list(violations: &[Violation]) -> String {
    let lines: Vec<_> = violations.iter().map(|v| format!("{}: {}", v.place, v.problem)).collect();
    lines.join("; ")
}

impl Solid {
    /// Validates the whole tree: finite and positive sizes, closed profiles, no empty boolean.
    ///
    /// # Errors
    /// All violations, each with its position in the tree.
    pub fn validate(&self) -> Result<(), InvalidSolid> {
        let mut found = Checker { place: Vec::new(), violations: Vec::new() };
        found.solid(self);
        if found.violations.is_empty() {
            Ok(())
        } else {
            Err(InvalidSolid { violations: found.violations })
        }
    }
}

struct Checker {
    place: Vec<String>,
    violations: Vec<Violation>,
}

impl Checker {
    fn report(&mut self, problem: impl Into<String>) {
        self.violations.push(Violation { place: self.place.join("/"), problem: problem.into() });
    }

    fn at(&mut self, step: impl Into<String>, check: impl FnOnce(&mut Self)) {
        self.place.push(step.into());
        check(self);
        self.place.pop();
    }

    fn positive(&mut self, name: &str, value_mm: f64) {
        if !(MIN_SIZE_MM..=MAX_SIZE_MM).contains(&value_mm) {
            self.report(format!(
                "{name} is {value_mm} mm; it must lie between {MIN_SIZE_MM} and {MAX_SIZE_MM} mm"
            ));
        }
    }

    fn solid(&mut self, solid: &Solid) {
        if self.place.len() >= MAX_DEPTH {
            self.report(format!("the tree is deeper than {MAX_DEPTH} levels"));
            return;
        }
        match solid {
            Solid::Sphere(s) => self.at("sphere", |c| c.positive("radius", s.radius_mm)),
            Solid::Ellipsoid(s) => self.at("ellipsoid", |c| {
                for half_axis in s.semi_axes_mm {
                    c.positive("half axis", half_axis);
                }
            }),
            Solid::Cylinder(s) => self.at("cylinder", |c| {
                c.positive("radius", s.radius_mm);
                c.positive("height", s.height_mm);
            }),
            Solid::Cone(s) => self.at("cone", |c| {
                c.positive("height", s.height_mm);
                c.positive("larger radius", s.bottom_radius_mm.max(s.top_radius_mm));
                // The smaller radius may be 0 (an apex); the sum is finite only if both are.
                let smaller = s.bottom_radius_mm.min(s.top_radius_mm);
                if !(smaller >= 0.0 && (s.bottom_radius_mm + s.top_radius_mm).is_finite()) {
                    c.report(format!("a radius is {smaller} mm; it must be finite, at least 0"));
                }
            }),
            Solid::Cuboid(s) => self.at("cuboid", |c| {
                for edge in s.size_mm {
                    c.positive("edge", edge);
                }
            }),
            Solid::Torus(s) => self.at("torus", |c| {
                c.positive("tube radius", s.tube_radius_mm);
                c.positive("ring radius beyond the tube's", s.ring_radius_mm - s.tube_radius_mm);
            }),
            Solid::HalfSpace(_) => {}
            Solid::Extrusion(s) => self.at("extrusion", |c| {
                c.positive("height", s.height_mm);
                c.profile(&s.profile, false);
            }),
            Solid::Revolution(s) => self.at("revolution", |c| c.profile(&s.profile, true)),
            Solid::EllipsoidOffset(s) => self.at("ellipsoid-offset", |c| {
                c.positive("equatorial half axis", s.equatorial_mm);
                c.positive("polar half axis", s.polar_mm);
                let (long, short) =
                    (s.equatorial_mm.max(s.polar_mm), s.equatorial_mm.min(s.polar_mm));
                let deepest_mm = -short * short / long;
                if !(s.offset_mm <= MAX_SIZE_MM && s.offset_mm > deepest_mm) {
                    c.report(format!(
                        "offset is {} mm; it must be at most {MAX_SIZE_MM} mm and, inwards, above \
                         {deepest_mm} mm, the smallest radius of curvature",
                        s.offset_mm
                    ));
                }
            }),
            Solid::Union(of) => self.many("union", of),
            Solid::Intersection(of) => self.many("intersection", of),
            Solid::Difference { of, minus } => {
                self.at("difference/of", |c| c.solid(of));
                self.many("difference/minus", minus);
            }
            Solid::Placed { pose, of } => {
                if !pose.is_rigid() {
                    self.report("a placement must be finite, without mirror or scale");
                }
                if pose.translation_mm().amax() > MAX_SIZE_MM {
                    self.report(format!("a shift beyond {MAX_SIZE_MM} mm"));
                }
                self.solid_below(of);
            }
            Solid::Feature { name, of } => {
                if name.is_empty() || name.len() > 64 {
                    self.report(format!("a feature name of {} bytes; 1 to 64 do", name.len()));
                }
                self.at(name.clone(), |c| c.solid(of));
            }
        }
    }

    /// Checks a placed solid. Placements add depth but no name.
    fn solid_below(&mut self, solid: &Solid) {
        self.at("placed", |c| c.solid(solid));
    }

    fn many(&mut self, kind: &str, of: &[Solid]) {
        if of.is_empty() {
            self.at(kind, |c| c.report("holds nothing; a boolean needs at least one solid"));
        }
        for (i, child) in of.iter().enumerate() {
            self.at(format!("{kind}[{i}]"), |c| c.solid(child));
        }
    }

    fn profile(&mut self, profile: &Profile, in_half_plane: bool) {
        let before = self.violations.len();
        let count: usize = profile.paths().map(|path| path.segments.len()).sum();
        if count > MAX_SEGMENTS {
            self.report(format!("{count} segments; the limit is {MAX_SEGMENTS}"));
            return;
        }
        for (i, path) in profile.paths().enumerate() {
            let name = if i == 0 { "outer".to_string() } else { format!("holes[{}]", i - 1) };
            self.at(name, |c| c.path(path, in_half_plane));
        }
        // Segments can be compared with each other only if each is valid by itself.
        if self.violations.len() == before {
            for problem in profile_validity::find_violations(profile) {
                self.report(problem);
            }
        }
    }

    fn path(&mut self, path: &Path, in_half_plane: bool) {
        let count = path.segments.len();
        if count < 2 {
            self.report(format!("{count} segments close no area; at least 2 do"));
            return;
        }
        if path.end() != path.start {
            self.report(format!("ends at {:?}, not where it starts, {:?}", path.end(), path.start));
        }
        let mut from = path.start;
        for (i, segment) in path.segments.iter().enumerate() {
            self.at(format!("segments[{i}]"), |c| c.segment(from, segment, in_half_plane));
            from = segment.to();
        }
    }

    fn segment(&mut self, from: [f64; 2], segment: &Segment, in_half_plane: bool) {
        let to = segment.to();
        if !from.iter().chain(&to).all(|v| v.abs() <= MAX_SIZE_MM) {
            self.report(format!("has a point that is not finite or beyond {MAX_SIZE_MM} mm"));
            return;
        }
        if from == to {
            self.report("starts where it ends; a circle is two arcs");
        }
        if in_half_plane && (from[0] < 0.0 || to[0] < 0.0) {
            self.report(format!("reaches {} mm, beyond the axis", from[0].min(to[0])));
        }
        let (centre, half_axes) = match segment {
            Segment::Line { .. } => return,
            Segment::Arc { centre, .. } => {
                let radius = (from[0] - centre[0]).hypot(from[1] - centre[1]);
                (centre, [radius; 2])
            }
            Segment::EllipticArc { centre, semi_axes_mm, .. } => {
                if !in_half_plane {
                    self.report("an elliptic arc; extrusions take lines and circular arcs");
                }
                (centre, *semi_axes_mm)
            }
        };
        self.positive("radius", half_axes[0]);
        self.positive("radius", half_axes[1]);
        for end in [from, to] {
            let (u, v) = ((end[0] - centre[0]) / half_axes[0], (end[1] - centre[1]) / half_axes[1]);
            let off = (u.hypot(v) - 1.0).abs();
            // `!(a <= b)` refuses NaN too.
            #[allow(clippy::neg_cmp_op_on_partial_ord)]
            if !(off <= ARC_TOLERANCE) {
                self.report(format!("its end {end:?} misses its own curve by {off:e} radii"));
            }
        }
        // Both ends may lie right of the axis while the arc between them crosses it.
        if in_half_plane && centre[0] - half_axes[0] < -ARC_TOLERANCE * half_axes[0] {
            self.arc_beyond_axis(from, segment, *centre, half_axes);
        }
    }

    /// Reports an arc that reaches beyond the axis. An arc whose full ellipse crosses the axis may still stay on one
    /// side of it.
    fn arc_beyond_axis(
        &mut self,
        from: [f64; 2],
        segment: &Segment,
        centre: [f64; 2],
        half_axes: [f64; 2],
    ) {
        let leftmost = [centre[0] - half_axes[0], centre[1]];
        if segment.passes(from, leftmost) {
            self.report(format!("reaches {} mm, beyond the axis", leftmost[0]));
        }
    }
}

impl Segment {
    /// Returns whether an arc that starts at `from` runs through `point`, a point of its full ellipse. Always false for
    /// a line.
    pub(crate) fn passes(&self, from: [f64; 2], point: [f64; 2]) -> bool {
        let (centre, half_axes, ccw) = match self {
            Self::Line { .. } => return false,
            Self::Arc { centre, ccw, .. } => (*centre, [1.0, 1.0], *ccw),
            Self::EllipticArc { centre, semi_axes_mm, ccw, .. } => (*centre, *semi_axes_mm, *ccw),
        };
        let angle = |p: [f64; 2]| {
            ((p[1] - centre[1]) / half_axes[1]).atan2((p[0] - centre[0]) / half_axes[0])
        };
        let turn = |to: [f64; 2]| {
            let delta = if ccw { angle(to) - angle(from) } else { angle(from) - angle(to) };
            delta.rem_euclid(std::f64::consts::TAU)
        };
        // Angles from the start in the arc's direction: the point comes before the end.
        turn(point) < turn(self.to())
    }
}
